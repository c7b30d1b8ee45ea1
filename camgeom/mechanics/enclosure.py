"""Between which values a force's expression of the cam angle stays: peaks that samples pass by are found or refused.

Every step of an expression is taken with intervals (R. E. Moore, Interval Analysis, Prentice-Hall 1966): what comes out
holds all values over a range of angles, and more. Ranges in which a value may lie beyond those seen are halved, and the
value in their middle is seen: a peak shows, or the bound falls below what is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.mechanics.applied import Expression, Step

SEEN = math.radians(0.5)
"""rad between angles at which a force is looked at anyhow"""
RESOLVED = 1e-4
"""rad, a quarter of the narrowest panel that a force is resolved on: a peak that shows in no wider range is not"""
POINT = 1e-10
"""rad, of which the halves are not looked into"""
BEYOND = 1.05
"""times the largest value known, from which on one is a peak of its own"""
END = 10.0
"""times the largest value in between, up to which one at an end of a range is as good"""
MOST_RANGES = 50_000
Range = tuple[Floats, Floats]
"""least and largest values, (n,) each"""


@lru_cache(256)
def narrow_peaks(value: Expression, begin: float, length: float) -> tuple[float, ...]:
    """Cam angles in [0, 2 pi], rad, round peaks of an expression of the cam angle alone that samples might pass by,
    from a cam angle on, rad.

    Raises ProfileError, naming its key and the angle, where it has a pole, or a peak narrower than is resolved.
    """
    if not value.variables or not value.variables.isdisjoint("sva"):
        return ()

    def at(angle: Floats) -> Floats:
        with np.errstate(all="ignore"):
            turned = np.mod(angle, TURN)
            found = np.broadcast_to(value.of({"phi": turned, "theta": turned, "deg": np.degrees(turned)}), angle.shape)
        return np.where(np.isfinite(found), np.abs(found), 0.0)

    whole = np.linspace(begin, begin + length, max(2, math.ceil(length / SEEN)) + 1)
    whole = np.unique(np.r_[whole, [TURN] if begin < TURN < begin + length else []])
    low, high = whole[:-1], whole[1:]
    # An end may lie on a pole: a tangent has 1.6e16 beside the one at a right angle.
    known, ends, peaks = float(at(0.5 * (low + high)).max()), at(whole), list[float]()
    known = max(known, float(ends[ends <= END * known].max(initial=0.0)))
    seen, narrow = 0, (0.0, 0.0)
    while len(low) and (seen := seen + len(low)) <= MOST_RANGES:
        least, most = enclosed(value.steps, low, high)
        size = np.maximum(-least, most)
        wide = ~(size <= BEYOND * known) & (high - low > POINT)
        low, high = low[wide], high[wide]
        middle = 0.5 * (low + high)
        found = at(middle)
        for far in np.flatnonzero(found > BEYOND * known):
            if high[far] - low[far] < RESOLVED:
                narrow = max(narrow, (float(found[far]), float(middle[far])))
            else:
                peaks += [low[far], middle[far], high[far]]
        known = max(known, float(found.max(initial=0.0)))
        low, high = np.r_[low, middle], np.r_[middle, high]
    if narrow[0]:
        raise ProfileError([Problem(
            value.key, f"has a pole, or a peak narrower than {math.degrees(RESOLVED):.2g} deg, at cam angle "
            f"{math.degrees(narrow[1]) % 360.0:.6g} deg, where it reaches {narrow[0]:.4g}", value.text,
            hint="limit its range of cam angle, or give a table")])  # fmt: skip
    return tuple(sorted({float(x) if x <= TURN else float(x) - TURN for x in peaks}))


def enclosed(steps: Sequence[Step], low: Floats, high: Floats) -> Range:
    """Between which values an expression of the cam angle stays over ranges of it, rad, within a turn; infinite where
    it may have none."""
    first, last = np.mod(low, TURN), np.mod(low, TURN) + (high - low)
    stack: list[Range] = []
    with np.errstate(all="ignore"):
        for kind, name, number in steps:
            if kind == "number":
                stack.append((np.full_like(low, number),) * 2)
            elif kind == "variable":
                scale = 180.0 / math.pi if name == "deg" else 1.0
                stack.append((scale * first, scale * last))
            else:
                count = int(number)
                arguments = stack[-count:]
                del stack[-count:]
                stack.append(_taken(name, arguments))
    return stack[0]


def _taken(name: str, arguments: list[Range]) -> Range:
    """One step, of values between others."""
    if name in ("minimum", "min", "maximum", "max"):
        which = np.minimum if name.startswith("min") else np.maximum
        least, most = arguments[0]
        for low, high in arguments[1:]:
            least, most = which(least, low), which(most, high)
        return least, most
    found = _STEPS[name](*arguments) if name in _STEPS else _rising(_RISING[name], *arguments)
    # What is none may be anything.
    return np.where(np.isnan(found[0]), -np.inf, found[0]), np.where(np.isnan(found[1]), np.inf, found[1])


def _rising(function: Callable[[Floats], Floats], x: Range) -> Range:
    """Of a function that rises over all of where it has values; beyond there the nearest that it has."""
    low, high = (-1.0, 1.0) if function is np.arcsin else (0.0 if function in _OF_POSITIVE else -np.inf, np.inf)
    return function(np.clip(x[0], low, high)), function(np.clip(x[1], low, high))


def _negative(x: Range) -> Range:
    return -x[1], -x[0]


def _add(x: Range, y: Range) -> Range:
    return x[0] + y[0], x[1] + y[1]


def _of_ends(function: Callable[[Floats, Floats], Floats], x: Range, y: Range) -> Range:
    """Of a function whose extremes are at ends of both ranges; 0 times infinity is 0, the end being none itself."""
    each = np.stack([function(a, b) for a in x for b in y])
    each[np.isnan(each)] = 0.0
    return each.min(axis=0), each.max(axis=0)


def _multiply(x: Range, y: Range) -> Range:
    return _of_ends(np.multiply, x, y)


def _divide(x: Range, y: Range) -> Range:
    found = _of_ends(np.divide, x, y)
    over = (y[0] <= 0.0) & (y[1] >= 0.0)
    return np.where(over, -np.inf, found[0]), np.where(over, np.inf, found[1])


def _power(x: Range, y: Range) -> Range:
    """Of an exponent that is one number."""
    exponent = y[0]
    whole, even = exponent == np.round(exponent), np.mod(exponent, 2.0) == 0.0
    low, high = (np.where(whole, end, np.maximum(end, 0.0)) for end in x)
    ends = np.stack([np.power(low, exponent), np.power(high, exponent)])
    least, most = ends.min(axis=0), ends.max(axis=0)
    through = (low <= 0.0) & (high >= 0.0)
    least = np.where(through & even & (exponent > 0.0), 0.0, least)
    pole = through & (exponent < 0.0)
    return np.where(pole, -np.inf, least), np.where(pole, np.inf, most)


def _absolute(x: Range) -> Range:
    least = np.where((x[0] <= 0.0) & (x[1] >= 0.0), 0.0, np.minimum(np.abs(x[0]), np.abs(x[1])))
    return least, np.maximum(np.abs(x[0]), np.abs(x[1]))


def _wave(x: Range, crest: float, function: Callable[[Floats], Floats]) -> Range:
    """Of a sine or cosine, whose crests are a turn apart."""
    ends = np.stack([function(x[0]), function(x[1])])

    def passed(place: float) -> npt.NDArray[np.bool_]:
        return np.asarray(~(np.floor((x[1] - place) / TURN) < np.ceil((x[0] - place) / TURN)))

    return (np.where(passed(crest + math.pi), -1.0, ends.min(axis=0)),
            np.where(passed(crest), 1.0, ends.max(axis=0)))  # fmt: skip


def _tan(x: Range) -> Range:
    pole = ~(np.floor(x[1] / math.pi - 0.5) < np.ceil(x[0] / math.pi - 0.5))
    return np.where(pole, -np.inf, np.tan(x[0])), np.where(pole, np.inf, np.tan(x[1]))


def _cosh(x: Range) -> Range:
    return _rising(np.cosh, _absolute(x))


def _hypot(x: Range, y: Range) -> Range:
    (a, b), (c, d) = _absolute(x), _absolute(y)
    return np.hypot(a, c), np.hypot(b, d)


def _atan2(y: Range, x: Range) -> Range:
    """Anything but right of the origin, where its extremes are at the ends."""
    right = x[0] > 0.0
    least, most = _of_ends(np.arctan2, y, x)
    return np.where(right, least, -math.pi), np.where(right, most, math.pi)


def _acos(x: Range) -> Range:
    return np.arccos(np.clip(x[1], -1.0, 1.0)), np.arccos(np.clip(x[0], -1.0, 1.0))


_OF_POSITIVE = (np.sqrt, np.log, np.log10)
_RISING: dict[str, Callable[[Floats], Floats]] = {
    "asin": np.arcsin, "atan": np.arctan, "sinh": np.sinh, "tanh": np.tanh, "exp": np.exp, "sqrt": np.sqrt,
    "sign": np.sign, "log": np.log, "log10": np.log10, "floor": np.floor, "ceil": np.ceil,
}  # fmt: skip
_STEPS: dict[str, Callable[..., Range]] = {
    "negative": _negative, "add": _add, "subtract": lambda x, y: _add(x, _negative(y)), "multiply": _multiply,
    "divide": _divide, "power": _power, "abs": _absolute, "tan": _tan, "cosh": _cosh, "hypot": _hypot,
    "atan2": _atan2, "acos": _acos,
    "sin": lambda x: _wave(x, 0.5 * math.pi, np.sin), "cos": lambda x: _wave(x, 0.0, np.cos),
}  # fmt: skip
