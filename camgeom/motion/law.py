"""A normalised motion law as data, what is measured on it, and how one is built from its parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from functools import lru_cache
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.table import JUMP_TOLERANCE, Piece, PieceTable, Side

ParamValue = Any
"""A number, a truth value, a text or a (nested) tuple of numbers: what TOML can say, made hashable."""
ORDER_LIMIT = 9
"""Derivatives are compared up to this order when smoothness is measured."""


@final
@immutable(eq=True)
class Claims:
    """Characteristic values of a law for unit lift over unit travel, all dimensionless.

    vm, am, jm   peak |s'|, |s''|, |s'''|; am is inf where the velocity jumps, jm is inf where the acceleration jumps,
                 the ends against a dwell included
    vam          peak |s' s''|, the drive torque of a pure inertia
    arms         root mean square of s''
    order_start, order_end   the highest derivative that is continuous against a dwell (0: not even the velocity)
    order_inside             the same at the inner breaks; inf where the law is smooth inside
    """

    vm: float
    am: float
    jm: float
    vam: float
    arms: float
    order_start: int
    order_end: int
    order_inside: float = math.inf

    @property
    def order(self) -> int:
        """The highest derivative that is continuous from dwell to dwell."""
        return int(min(self.order_start, self.order_end, self.order_inside))


@final
@immutable(eq=True)
class Law:
    """A motion law on 0 <= x <= 1 with s(0) = 0 and s(1) = 1, dimensionless, as contiguous pieces.

    Every piece is a power series and waves, so derivatives of any order and integrals are exact.

    >>> from camgeom.motion import make
    >>> make("cycloidal").jet(0.25, order=1).round(6)
    array([0.090845, 1.      ])
    """

    name: str
    pieces: tuple[Piece, ...]
    source: str = ""
    claims: Claims | None = None
    params: tuple[tuple[str, ParamValue], ...] = ()

    @cached_property
    def table(self) -> PieceTable:
        """The pieces as arrays."""
        return PieceTable.of(self.pieces)

    def jet(self, x: npt.ArrayLike, order: int = 3, side: Side = "right") -> Floats:
        """s and its derivatives with respect to x, (order + 1, *x.shape), dimensionless.

        At a break the right-hand piece is used, or the left-hand one with side="left". Raises ValueError where an x
        lies outside 0..1 or is not a number.
        """
        points = np.asarray(x, dtype=float)
        if not np.all((points >= 0.0) & (points <= 1.0)):
            raise ValueError(f"law {self.name!r} is defined on 0 <= x <= 1")
        return self.table.jet(points.ravel(), order, side).reshape(order + 1, *points.shape)

    @cached_property
    def knots(self) -> tuple[float, ...]:
        """The ends and the inner places where some derivative jumps."""
        return (0.0, *(edge for edge, _ in self._breaks), 1.0)

    @cached_property
    def _breaks(self) -> tuple[tuple[float, int], ...]:
        """Inner breaks: (x, lowest derivative that jumps)."""
        after = np.arange(1, len(self.pieces))
        lowest = lowest_jump(self.table.steps(after - 1, after, ORDER_LIMIT))
        inner = self.table.edges[1:-1]
        return tuple((float(x), int(r)) for x, r in zip(inner, lowest, strict=True) if r <= ORDER_LIMIT)

    def peaks(self) -> Claims:
        """The characteristic values measured on the law itself, dimensionless (see `Claims`)."""
        table = self.table
        inside = min((order - 1 for _, order in self._breaks), default=math.inf)
        start, end = self._rest_order("first"), self._rest_order("last")
        order = min(start, end, inside)
        torque = table.peak(3, lambda d: d[1] * d[2], lambda d: d[2] * d[2] + d[1] * d[3])
        impulsive = order < 1
        return Claims(
            vm=abs(table.derivative_peak(1).value),
            am=math.inf if impulsive else abs(table.derivative_peak(2).value),
            jm=math.inf if order < 2 else abs(table.derivative_peak(3).value),
            vam=math.inf if impulsive else abs(torque.value),
            arms=math.inf if impulsive else math.sqrt(table.mean_square(2)),
            order_start=start,
            order_end=end,
            order_inside=inside,
        )

    def torque_rate(self) -> float:
        """Peak |(s' s'')'|, dimensionless: how fast the drive torque of a pure inertia changes (T/WLJC 15-2018, 7.1.6).

        Infinite where that torque jumps: where the acceleration does while the follower moves.
        """
        moving = JUMP_TOLERANCE * abs(self.table.derivative_peak(1).value)
        jumps = [x for x, order in self._breaks if order == 2]
        impulsive = min(self._rest_order("first"), self._rest_order("last")) < 1
        impulsive |= any(order < 2 for _, order in self._breaks)
        if impulsive or (jumps and float(np.abs(self.jet(jumps, 1)[1]).max()) > moving):
            return math.inf
        found = self.table.peak(4, lambda d: d[2] * d[2] + d[1] * d[3], lambda d: 3.0 * d[2] * d[3] + d[1] * d[4])
        return abs(found.value)

    def integral(self, x: npt.ArrayLike = 1.0) -> Floats:
        """The integral of s from 0 to x, (*x.shape), dimensionless; exact, piece by piece."""
        total, parts = 0.0, []
        for piece in self.pieces:
            parts.append(piece.integrated(total))
            total = parts[-1].value(piece.end)
        points = np.asarray(x, dtype=float)
        return np.asarray(PieceTable.of(parts).jet(points.ravel(), 0)[0].reshape(points.shape))

    def mean_square(self, order: int = 2) -> float:
        """The mean square of a derivative over the travel, dimensionless."""
        return self.table.mean_square(order)

    def _rest_order(self, end: Literal["first", "last"]) -> int:
        """The number of derivatives that vanish at an end, counted up to the limit."""
        piece = 0 if end == "first" else len(self.pieces) - 1
        jet = self.table.limit(np.array([piece]), ORDER_LIMIT, end)[:, 0]
        bound = self.table.bounds(ORDER_LIMIT)[:, piece]
        moving = np.abs(jet[1:]) > JUMP_TOLERANCE * bound[1:]
        return int(np.argmax(moving)) if moving.any() else ORDER_LIMIT


def lowest_jump(steps: Floats) -> npt.NDArray[np.intp]:
    """The lowest derivative that steps, (m,), of steps (orders, m); the number of orders where none does."""
    jumps = steps != 0.0
    return np.where(jumps.any(axis=0), np.argmax(jumps, axis=0), len(steps))


def finish(pieces: Sequence[Piece], lift: float = 1.0) -> tuple[Piece, ...]:
    """Anchor the first piece at x = 0 and the last at x = 1, so that both end positions are exact to the last digit."""
    first, *rest = pieces
    if not rest:
        first, rest = first.between(0.0, 0.5), [first.between(0.5, 1.0)]
    first, last = first.about(first.start), rest[-1].about(rest[-1].end)
    scale = max(abs(lift), *(abs(c) for c in (*first.power, *last.power)))
    if abs(first.power[0]) > 1e-9 * scale or abs(last.power[0] - lift) > 1e-9 * scale:
        raise ValueError(f"the pieces run from {first.power[0]!r} to {last.power[0]!r}, not from 0 to {lift!r}")
    ends = (first, last)
    targets = (0.0, lift)
    exact = [replace(piece, power=(value, *piece.power[1:])) for piece, value in zip(ends, targets, strict=True)]
    return (exact[0], *rest[:-1], exact[1])


@final
@immutable(eq=True)
class Ends:
    """What a joining law takes over from its neighbours: the lift and the derivatives per unit travel at both ends.

    start[r], end[r] is the derivative of order r + 1; `unit` is the inner value of one edge unit of lift (1 for mm,
    pi/180 for degrees) and `folder` the place that relative file names start from; `shared` says that a state is still
    sought together with a neighbour, so that the motion must answer to its ends linearly; `turn` is the share of a turn
    that the segment takes, 0 outside a program; `best` the number of best laws of the cam, which have what their
    search may cost in common.
    """

    lift: float = 1.0
    start: tuple[float, ...] = (0.0, 0.0, 0.0)
    end: tuple[float, ...] = (0.0, 0.0, 0.0)
    unit: float = 1.0
    folder: str = ""
    shared: bool = False
    turn: float = 0.0
    best: int = 1

    def values(self, order: int) -> tuple[Floats, Floats]:
        """Value and `order` derivatives per unit travel at the start and at the end, (order + 1,) each."""
        return np.array([0.0, *self.start[:order]]), np.array([self.lift, *self.end[:order]])


@final
@immutable(eq=True)
class Parameter:
    """One parameter of a law: default, allowed range (inclusive), meaning, and the kind of value it takes."""

    default: ParamValue
    low: float
    high: float
    help: str
    kind: Literal["number", "integer", "switch", "text", "list"] = "number"
    lift: Literal["", "number", "last", "refused"] = ""
    """what of it is a lift, in the unit of the profile: the number, the last of each entry, or what a file holds"""

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


def freeze(value: ParamValue) -> ParamValue:
    """The value with lists turned into tuples, so that it can be compared and looked up."""
    return tuple(freeze(item) for item in value) if isinstance(value, list | tuple) else value


Factory = Callable[..., Sequence[Piece]]


@final
@immutable(eq=True)
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
    data: tuple[str, ...] = ()
    stand_in: str = ""
    """the joining law that a state shared with a neighbour is sought with, where this one does not answer linearly"""

    def lacks(self, params: Mapping[str, ParamValue]) -> bool:
        """Whether the law is made of data, and the parameters give none: it would be another law."""
        return bool(self.data) and not any(params.get(key) for key in self.data)

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
        values = self.complete(params)
        if self.joins:
            return finish(self.factory(ends, **values), ends.lift)
        return tuple(piece.scaled(ends.lift) for piece in _law(self, tuple(values.items())).pieces)

    def make(self, params: Mapping[str, ParamValue]) -> Law:
        """The law itself, rest to rest where it joins; raises ProfileError naming each bad parameter."""
        problems = self.problems(params)
        if problems:
            raise ProfileError(problems)
        return _law(self, tuple(self.complete(params).items()))

    def claims_for(self, values: Mapping[str, ParamValue]) -> Claims | None:
        """The claims that hold at these parameters: the defaults', a listed case's, or none."""
        wanted = self.complete(values)
        matching = (claims for case, claims in (({}, self.claims), *self.cases) if self.complete(case) == wanted)
        return next(matching, None)

    def complete(self, params: Mapping[str, ParamValue]) -> dict[str, ParamValue]:
        """The parameters with defaults filled in, in the catalogue's order, lists as tuples."""
        return {name: freeze(params.get(name, parameter.default)) for name, parameter in self.parameters.items()}

    def __hash__(self) -> int:
        return hash(self.name)


@lru_cache(maxsize=512)
def _law(entry: LawEntry, values: tuple[tuple[str, ParamValue], ...]) -> Law:
    params = dict(values)
    pieces = entry.factory(Ends(), **params) if entry.joins else entry.factory(**params)
    return Law(entry.name, finish(pieces), entry.source, entry.claims_for(params), values)
