"""The catalogue of motion laws, which every law enters by `@law` with its source and its claims."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import final

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.motion.law import Claims, Factory, Law, LawEntry, Parameter, ParamValue, freeze

HOME = "camgeom.motion"
"""the package whose modules laws_... hold the laws that camgeom brings along"""


@final
class Catalogue(Mapping[str, LawEntry]):
    """Laws by name, filled by `@law`; camgeom's own modules of laws are imported one after the other as names ask."""

    def __init__(self) -> None:
        self.entered: dict[str, LawEntry] = {}
        homes = (module.name for module in iter_modules([str(Path(__file__).parent)]))
        self._waiting = sorted(name for name in homes if name.startswith("laws_"))

    def _more(self) -> bool:
        """Import the next module of laws; False where there is none left."""
        if not self._waiting:
            return False
        import_module(f"{HOME}.{self._waiting.pop(0)}")
        return True

    def __getitem__(self, name: str) -> LawEntry:
        while name not in self.entered and self._more():
            pass
        return self.entered[name]

    def __iter__(self) -> Iterator[str]:
        while self._more():
            pass
        return iter(self.entered)

    def __len__(self) -> int:
        return len(list(iter(self)))


SEGMENT_KEYS = frozenset({"until", "to", "law", "velocity", "acceleration", "jerk"})
"""of every segment of a profile's motion"""
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._+-]{0,59}")
MOST_SAID = 500
"""characters of what is said of a law of the user's own"""
LAWS = Catalogue()
"""Every motion law by name."""


def law(
    name: str,
    *,
    source: str,
    claims: Claims,
    joins: bool = False,
    cases: Sequence[tuple[Mapping[str, ParamValue], Claims]] = (),
    data: Sequence[str] = (),
    stand_in: str = "",
    **parameters: Parameter,
) -> Callable[[Factory], Factory]:
    """Enter a law into the catalogue. The decorated function takes the parameters and returns the pieces of s.

    A joining law takes an `Ends` first and returns a motion from 0 to its lift. `claims` hold at the defaults, `cases`
    at other parameters. A segment of a profile has to give one of the parameters that `data` names; a joining law that
    does not answer linearly to its ends names the law that `stand_in`s for it. The first line of
    the docstring is the summary that the list of laws shows. Raises ValueError where the name is taken; of a law from
    outside the package the claims are measured at once, and ProfileError says which does not hold. A parameter cannot
    have the name of a key that every segment has, nor a default beyond its range; a name is 1 to 60 letters, digits and
    `. _ + -`, a source text of at most 500 characters (ValueError).
    """
    if taken := SEGMENT_KEYS.intersection(parameters):
        raise ValueError(f"a parameter cannot be called {min(taken)!r}: every segment has a key of that name")

    def enter(factory: Factory) -> Factory:
        _refuse_misstated(name, source, claims, parameters)
        summary = next(iter((factory.__doc__ or "").strip().splitlines()), name)
        own = factory.__module__.startswith(f"{HOME}.laws_")
        if name in (LAWS.entered if own else LAWS):
            raise ValueError(f"two laws are called {name!r}; the name of a law is taken once")
        entry = LawEntry(name, summary, source, claims, parameters, factory, joins, tuple(cases), tuple(data), stand_in)
        if not own:
            from camgeom.motion.claims import guarded, refuse_unkept

            entry = replace(entry, factory=partial(guarded, name, factory))
            refuse_unkept(entry)
        LAWS.entered[name] = entry
        return factory

    return enter


def _refuse_misstated(name: object, source: object, claims: object, parameters: Mapping[str, Parameter]) -> None:
    """Raise ValueError where what is said of a law is not what a list of laws can show and a segment can state."""
    if not (isinstance(name, str) and NAME.fullmatch(name)):
        raise ValueError(f"a law's name is 1 to 60 letters, digits, '.', '_', '+' and '-', not {name!r:.60}")
    if not (isinstance(source, str) and len(source) <= MOST_SAID and isinstance(claims, Claims)):
        raise ValueError(f"a law has a source, text of at most {MOST_SAID} characters, and Claims")
    for key, parameter in parameters.items():
        if not (isinstance(parameter, Parameter) and parameter.accepts(freeze(parameter.default))):
            raise ValueError(f"parameter {key!r} has no default of its kind within its range")


def unknown_law(name: str, key: str) -> Problem:
    """What to say of a law that is not in the catalogue, with the nearest spelling."""
    return Problem(key, "no motion law of this name", name, "a name from `camgeom laws`", did_you_mean(name, LAWS))


def entry(name: str) -> LawEntry:
    """The catalogue entry of a law; raises ProfileError with the nearest spelling."""
    if name not in LAWS:
        raise ProfileError([unknown_law(name, "law")])
    return LAWS[name]


def make(name: str, /, **params: ParamValue) -> Law:
    """The normalised motion law of this name, dimensionless; raises ProfileError naming the law or each parameter.

    >>> make("modified-sine").peaks().vm.__round__(6)
    1.759603
    """
    return entry(name).make(params)
