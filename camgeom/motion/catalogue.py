"""The catalogue of motion laws, which every law enters by `@law` with its source and its claims."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from itertools import islice
from numbers import Real
from pathlib import Path
from pkgutil import iter_modules
from typing import final

from camgeom.errors import CamgeomError, Problem, ProfileError, did_you_mean
from camgeom.motion.law import Claims, Ends, Factory, Law, LawEntry, Parameter, ParamValue, finish
from camgeom.motion.table import Piece

MOST_PIECES, MOST_SIZE = 100_000, 1e30
"""of what a law from outside gives: pieces, and the magnitude of their numbers"""
UNCONNECTED = "its pieces do not follow on one another from x = 0 to x = 1"
APART = 1e-12
"""share of the travel by which its pieces may fail to meet"""
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
    outside the package the claims are measured at once, and ProfileError says which does not hold.
    """

    def enter(factory: Factory) -> Factory:
        summary = next(iter((factory.__doc__ or "").strip().splitlines()), name)
        own = factory.__module__.startswith(f"{HOME}.laws_")
        if name in (LAWS.entered if own else LAWS):
            raise ValueError(f"two laws are called {name!r}; the name of a law is taken once")
        built = factory if own else partial(_guarded, name, factory)
        entry = LawEntry(name, summary, source, claims, parameters, built, joins, tuple(cases), tuple(data), stand_in)
        if not own:
            from camgeom.motion.claims import refuse_unkept

            refuse_unkept(entry)
        LAWS.entered[name] = entry
        return factory

    return enter


def _guarded(name: str, factory: Factory, /, *ends: Ends, **params: ParamValue) -> Sequence[Piece]:
    """The pieces of a law from outside of the package; ProfileError, and nothing else, where they are none."""
    try:
        pieces = list(islice(factory(*ends, **params), MOST_PIECES + 1))
        _refuse_unsound(pieces)
        return finish(pieces, ends[0].lift if ends else 1.0)
    except (CamgeomError, ArithmeticError, MemoryError, KeyboardInterrupt):
        raise
    except BaseException as error:  # whatever it raises must not end a command as if the design were judged
        said = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
        given = ", ".join(f"{key} = {value!r}"[:60] for key, value in params.items())
        at = f" at {given}" if given else ""
        fault = f"the function of {name} does not give a motion{at} ({said[:300]})"
        raise ProfileError([Problem("law", fault)]) from error


def _refuse_unsound(pieces: Sequence[Piece]) -> None:
    """Raise ValueError where they are not pieces from 0 to 1 of numbers that can be computed with."""
    if not 0 < len(pieces) <= MOST_PIECES:
        raise ValueError("it has no pieces" if not pieces else f"it has more than {MOST_PIECES} pieces")
    place = 0.0
    for piece in pieces:
        if not isinstance(piece, Piece):
            raise ValueError(f"{piece!r:.60} is no Piece")
        numbers = [piece.start, piece.end, piece.anchor, *piece.power, *(x for wave in piece.waves for x in wave)]
        if not piece.power or not all(isinstance(x, Real) and abs(x) <= MOST_SIZE for x in numbers):
            raise ValueError(f"a piece has no number, or one that is none or beyond {MOST_SIZE:g}")
        if abs(piece.start - place) > APART or not piece.end > piece.start:
            raise ValueError(UNCONNECTED)
        place = piece.end
    if abs(place - 1.0) > APART:
        raise ValueError(UNCONNECTED)


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
