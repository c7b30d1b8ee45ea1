"""The catalogue that every law enters by `@law`: parameters, source, claims, and how it is built and checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Literal, final

import numpy as np

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats
from camgeom.motion.curve import Claims, Law, ParamValue, finish
from camgeom.motion.piece import Piece
from camgeom.spelling import did_you_mean

__all__ = [
    "LAWS",
    "Claims",
    "Ends",
    "Law",
    "LawEntry",
    "ParamValue",
    "Parameter",
    "finish",
    "freeze",
    "law",
]


@final
@dataclass(frozen=True)
class Ends:
    """What a joining law takes over from its neighbours: the lift and the derivatives per unit travel at both ends.

    start[r], end[r] is the derivative of order r + 1; `unit` is the inner value of one edge unit of lift (1 for mm,
    pi/180 for degrees) and `folder` the place that relative file names start from; `shared` says that a state is still
    sought together with a neighbour, so that the motion must answer to its ends linearly.
    """

    lift: float = 1.0
    start: tuple[float, ...] = (0.0, 0.0, 0.0)
    end: tuple[float, ...] = (0.0, 0.0, 0.0)
    unit: float = 1.0
    folder: str = ""
    shared: bool = False

    def values(self, order: int) -> tuple[Floats, Floats]:
        """Value and `order` derivatives per unit travel at the start and at the end, (order + 1,) each."""
        return np.array([0.0, *self.start[:order]]), np.array([self.lift, *self.end[:order]])


@final
@dataclass(frozen=True)
class Parameter:
    """One parameter of a law: default, allowed range (inclusive), meaning, and the kind of value it takes."""

    default: ParamValue
    low: float
    high: float
    help: str
    kind: Literal["number", "integer", "switch", "text", "list"] = "number"

    @property
    def allowed(self) -> str:
        """The allowed values in words."""
        words = {"switch": "true or false", "text": "text", "list": f"a list of numbers up to {MOST_IN_LIST:g}"}
        return words.get(self.kind, f"{self.low:g} to {self.high:g}")

    def accepts(self, value: ParamValue) -> bool:
        """Whether the value is of the right kind and in range; lists are looked at by the law itself."""
        if self.kind == "list":
            return isinstance(value, tuple) and _all_numbers(value)
        if self.kind in ("switch", "text"):
            return isinstance(value, bool if self.kind == "switch" else str)
        whole = isinstance(value, int) and not isinstance(value, bool)
        return (whole or (self.kind == "number" and isinstance(value, float))) and self.low <= value <= self.high


MOST_IN_LIST = 1e12


def _all_numbers(value: ParamValue) -> bool:
    """Whether a nested tuple holds numbers of a size that derivatives can be formed of."""
    if isinstance(value, tuple):
        return all(_all_numbers(item) for item in value)
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= MOST_IN_LIST


Factory = Callable[..., Sequence[Piece]]


@final
@dataclass(frozen=True)
class LawEntry:
    """A catalogue entry: how a law is called, what it takes, where it comes from, what it claims, how it is built."""

    name: str
    summary: str
    source: str
    claims: Claims
    parameters: Mapping[str, Parameter]
    factory: Factory = field(repr=False)
    joins: bool = False
    cases: tuple[tuple[Mapping[str, ParamValue], Claims], ...] = ()

    def problems(self, params: Mapping[str, ParamValue], prefix: str = "") -> list[Problem]:
        """Everything wrong with the parameters: unknown names with the nearest spelling, wrong kinds, ranges."""
        found = []
        for key, value in params.items():
            parameter = self.parameters.get(key)
            if parameter is None:
                names = ", ".join(self.parameters) or "none"
                message = f"the law {self.name} has no parameter of this name"
                found.append(Problem(prefix + key, message, value, names, did_you_mean(key, self.parameters)))
            elif not parameter.accepts(freeze(value)):
                found.append(Problem(prefix + key, parameter.help, value, parameter.allowed))
        return found

    def pieces(self, params: Mapping[str, ParamValue], ends: Ends) -> tuple[Piece, ...]:
        """The motion from 0 to ends.lift over unit travel; `params` must have passed `problems`."""
        values = self._complete(params)
        if self.joins:
            return finish(self.factory(ends, **values), ends.lift)
        return tuple(piece.scaled(ends.lift) for piece in _law(self, tuple(values.items())).pieces)

    def make(self, params: Mapping[str, ParamValue]) -> Law:
        """The law itself, rest to rest where it joins; raises ProfileError naming each bad parameter."""
        problems = self.problems(params)
        if problems:
            raise ProfileError(problems)
        return _law(self, tuple(self._complete(params).items()))

    def claims_for(self, values: Mapping[str, ParamValue]) -> Claims | None:
        """The claims that hold at these parameters: the defaults', a listed case's, or none."""
        wanted = self._complete(values)
        matching = (claims for case, claims in (({}, self.claims), *self.cases) if self._complete(case) == wanted)
        return next(matching, None)

    def _complete(self, params: Mapping[str, ParamValue]) -> dict[str, ParamValue]:
        """The parameters with defaults filled in, in the catalogue's order, lists as tuples."""
        return {name: freeze(params.get(name, parameter.default)) for name, parameter in self.parameters.items()}

    def __hash__(self) -> int:
        return hash(self.name)


@lru_cache(maxsize=512)
def _law(entry: LawEntry, values: tuple[tuple[str, ParamValue], ...]) -> Law:
    params = dict(values)
    pieces = entry.factory(Ends(), **params) if entry.joins else entry.factory(**params)
    return Law(entry.name, finish(pieces), entry.source, entry.claims_for(params), values)


LAWS: dict[str, LawEntry] = {}
"""Every motion law by name; filled by `@law` when `camgeom.motion.laws` is imported."""


def law(
    name: str,
    *,
    source: str,
    claims: Claims,
    joins: bool = False,
    cases: Sequence[tuple[Mapping[str, ParamValue], Claims]] = (),
    **parameters: Parameter,
) -> Callable[[Factory], Factory]:
    """Enter a law into the catalogue. The decorated function takes the parameters and returns the pieces of s.

    A joining law takes an `Ends` first and returns a motion from 0 to its lift. `claims` hold at the defaults, `cases`
    at other parameters. The first line of the docstring is the summary that the list of laws shows.
    """

    def enter(factory: Factory) -> Factory:
        summary = (factory.__doc__ or "").strip().splitlines()[0]
        if name in LAWS:
            raise ValueError(f"two laws are called {name!r}")
        LAWS[name] = LawEntry(name, summary, source, claims, parameters, factory, joins, tuple(cases))
        return factory

    return enter


def freeze(value: ParamValue) -> ParamValue:
    """The value with lists turned into tuples, so that it can be compared and looked up."""
    return tuple(freeze(item) for item in value) if isinstance(value, list | tuple) else value
