"""Between which values a force's expression of the cam angle stays: peaks that samples pass by are found or refused.

Every step of an expression is taken with intervals (R. E. Moore, Interval Analysis, Prentice-Hall 1966): what comes out
holds all values over a range of angles, and more. Ranges in which a value may lie beyond those seen are halved, and the
value in their middle is seen: a peak shows, or the bound falls below what is known.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import numpy.typing as npt

from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats, distinct
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.mechanics.applied import Expression, Step

ANGLES, MOVED = frozenset({"phi", "theta", "deg"}), frozenset("sva")
"""variables of an expression"""
SEEN = math.radians(0.5)
"""rad between angles at which a force is looked at anyhow"""
RESOLVED = 1e-4
"""rad, a quarter of the narrowest panel that a force is resolved on: a peak that shows in no wider range is not"""
POINT, JUMP = 1e-6, 1e-9
"""rad, of which the halves are not looked into: nearer to 0 / 0 values are rounding; within which a jump is placed"""
BEYOND = 0.05
"""share of the largest force by which a peak that is too narrow to be resolved rises above what is seen there"""
LEAST, OF_LARGEST, OF_ROUNDING = 0.002, 1e-4, 1e-9
"""shares of the range over which the force varies, and of the largest force, by which a peak or a jump is one: a
constant beside it hides none, as the least contact force may be a small rest of large ones; and what rounding makes"""
AT_END = 0.5
"""the same at an end of the range, where a force may rise steeply up to it, and panels become as narrow"""
GOES_ON = 2.0 / 3.0
"""share of the step before by which it may rise further up to an end, which is no further away"""
PIECE, OF_PIECE = 16, 1.0 / 256.0
"""angles at which a piece of a motion is looked at, at least, and the share of it that is narrow: panels end at its
ends, where it may kink"""
ASIDE, INSIDE = 0.381966, 1e-7
"""of a step, so that no angle of a round number of degrees is looked at, where a pole may lie; of the range's ends"""
MOST_RANGES, MOST_POLES, MOST_JUMPS = 50_000, 200_000, 5_000
"""looked into, after which those with a bound are left, and all: terms that cancel each other give wide ones; ranges
that are halved to place a jump"""
Range = tuple[Floats, Floats]
"""least and largest values, (n,) each"""
Motion = Callable[[Floats], Sequence[Floats]]
"""lift, velocity and acceleration at cam angles, rad, as forces are given them"""


@lru_cache(256)
def narrow_peaks(value: Expression, begin: float, length: float) -> tuple[float, ...]:
    """Cam angles in [0, 2 pi], rad, round peaks of an expression of the cam angle alone that samples might pass by,
    from a cam angle on, rad.

    Raises ProfileError, naming its key and the angle, where it has a pole, or a peak narrower than is resolved.
    """
    return () if value.variables.isdisjoint(ANGLES) or value.variables & MOVED else peaks_of(value, begin, length, None)


def peaks_of(
    value: Expression, begin: float, length: float, motion: Motion | None, knots: Sequence[float] | Floats = (),
    of_largest: float = OF_LARGEST,
) -> tuple[float, ...]:  # fmt: skip
    """The same of one that hangs on the motion too: within a range that is held to move by a quarter more than its ends
    and middle say.

    knots       cam angles in [0, 2 pi], rad, between which the motion is of one piece, however short
    of_largest  share of the largest force that is no peak
    """

    def known(angle: Floats) -> dict[str, Floats]:
        turned = np.mod(angle, TURN)
        found = {"phi": turned, "theta": turned, "deg": np.degrees(turned)}
        return found if motion is None else {**found, **dict(zip("sva", motion(turned)))}

    def at(angle: Floats) -> Floats:
        with np.errstate(all="ignore"):
            return np.array(np.broadcast_to(value.of(known(angle)), angle.shape))

    def moved(low: Floats, high: Floats) -> dict[str, Range]:
        if motion is None:
            return {}
        every = motion(np.mod(np.stack([low, 0.5 * (low + high), high]), TURN))
        ends = [(one.min(axis=0), one.max(axis=0)) for one in every]
        return {name: (low - 0.25 * (high - low), high + 0.25 * (high - low)) for name, (low, high) in zip("sva", ends)}

    count = max(2, math.ceil(length / SEEN))
    edges = begin + length * (np.arange(count) + ASIDE) / count
    joints = distinct(np.r_[begin, begin + np.mod(np.asarray(knots, dtype=np.float64) - begin, TURN)])
    joints = np.r_[joints[joints < begin + length], begin + length]
    edges = np.r_[begin + INSIDE * length, edges, _within(joints), begin + (1.0 - INSIDE) * length]
    edges = distinct(np.r_[edges, [TURN] if begin < TURN < begin + length else []])
    if len(edges) < 4:  # a range of no length
        return ()
    seen = at(edges)
    # The ends are seen, but do not say what is beside them: a pole or half a peak may stand there.
    known_by = seen.copy()
    known_by[[0, -1]] = seen[[1, -2]]
    least, most = (f(known_by[:-1], known_by[1:]) for f in (np.fmin, np.fmax))
    with np.errstate(invalid="ignore"):
        goes_on = GOES_ON * np.nan_to_num(np.abs(seen[[1, -2]] - seen[[2, -3]]), nan=0.0, posinf=0.0)
    least[[0, -1]], most[[0, -1]] = least[[0, -1]] - goes_on, most[[0, -1]] + goes_on
    low, high, largest = edges[:-1], edges[1:], float(np.fmax.reduce(np.abs(known_by), initial=0.0))
    finite = known_by[np.isfinite(known_by)]
    span = [float(finite.min()), float(finite.max())] if finite.size else [0.0, 0.0]

    def small() -> float:
        """What is no peak beside the values seen by now."""
        return max(LEAST * (span[1] - span[0]), of_largest * largest)

    looked, narrow, peaks = -len(low), (0.0, 0.0), _alone(edges, seen, small())
    jumps = _jumps(at, edges, seen, small())
    at_joint = np.searchsorted(joints, jumps + POINT) > np.searchsorted(joints, jumps - POINT)  # panels end there
    peaks += [float(x) for x in jumps[~at_joint]]
    joined = at(joints + np.array([[-POINT], [POINT]]) * ASIDE)
    # An end that falls to a value that there is elsewhere, or to the nothing beside its range, hides no more than that.
    some = np.r_[known_by, [] if length > TURN - POINT else 0.0]
    lowest, highest = float(np.fmin.reduce(some)), float(np.fmax.reduce(some))
    if length > 4.0 * RESOLVED:
        ends, last = edges[[0, -1]], seen[[0, -1]]
        before = at(ends + np.array([RESOLVED, -RESOLVED]))
        much = AT_END * max(largest, float(np.fmax.reduce(np.abs(before))))
        steep = (np.abs(last - before) > much) & ~(np.abs(last - np.clip(last, lowest, highest)) <= much)
        narrow = max([narrow, *((abs(float(last[k])), float(ends[k])) for k in np.flatnonzero(steep))])
    while len(low) and looked <= MOST_POLES:
        allowed = small()
        under, over = enclosed(value.steps, low, high, moved(low, high))
        more = ~((under >= least - allowed) & (over <= most + allowed)) & (high - low > POINT)
        if (looked := looked + len(low)) > MOST_RANGES:
            more &= ~(np.isfinite(under) & np.isfinite(over))
        low, high, least, most = low[more], high[more], least[more], most[more]
        middle = 0.5 * (low + high)
        found = at(middle)
        if len(none := np.flatnonzero(~np.isfinite(found))):
            _refuse(value, f"has no finite value at cam angle {_shown(middle[none[0]])} deg")
        largest = max(largest, float(np.abs(found).max(initial=0.0)))
        span = [float(found.min(initial=span[0])), float(found.max(initial=span[1]))]
        beyond = np.fmax(found - most, least - found)
        for far in np.flatnonzero(beyond > small()):
            share, above = BEYOND, float(beyond[far])
            if low[far] <= edges[0] or high[far] >= edges[-1]:
                share, above = AT_END, min(above, max(lowest - float(found[far]), float(found[far]) - highest))
            first, last = np.searchsorted(joints, [low[far], high[far]])
            piece = float(np.diff(joints[max(first - 1, 0) : last + 1]).min(initial=TURN))
            finest, wide = min(RESOLVED, OF_PIECE * piece), float(high[far] - low[far])
            if wide < finest and above > share * largest:
                narrow = max(narrow, (abs(float(found[far])), float(middle[far])))
            elif wide > 0.25 * finest and not _between(float(found[far]), joined[:, first:last], allowed):
                peaks += [low[far], middle[far], high[far]]
        least, most = np.fmin(least, found), np.fmax(most, found)
        low, high, least, most = np.r_[low, middle], np.r_[middle, high], np.r_[least, least], np.r_[most, most]
    if narrow[0]:
        what = f"has a pole, or a peak narrower than {math.degrees(RESOLVED):.2g} deg, at cam angle"
        _refuse(value, f"{what} {_shown(narrow[1])} deg, where it reaches {narrow[0]:.4g}")
    return tuple(sorted({float(x) if x <= TURN else float(x) - TURN for x in peaks}))


def _jumps(at: Callable[[Floats], Floats], edges: Floats, seen: Floats, allowed: float) -> Floats:
    """Angles at which a value jumps by more than is allowed: panels end there, else they swing beside them."""
    low, high, before, after = edges[:-1], edges[1:], seen[:-1], seen[1:]
    while True:
        with np.errstate(invalid="ignore"):
            much = np.abs(after - before) > allowed
        low, high, before, after = low[much], high[much], before[much], after[much]
        if not 0 < len(low) <= MOST_JUMPS or float((high - low).max()) < JUMP:
            break
        middle = 0.5 * (low + high)
        found = at(middle)
        low, high, before, after = np.r_[low, middle], np.r_[middle, high], np.r_[before, found], np.r_[found, after]
    if len(low) > MOST_JUMPS:
        return low[:0]
    # Nearer to 0 / 0 than a point values are rounding, not what the force has beside it; sign(0) is neither of its.
    place = 0.5 * (low + high)
    further, left, right, beyond = at(place + POINT * np.array([[-2.0], [-1.0], [1.0], [2.0]]))
    with np.errstate(invalid="ignore"):
        jumps = np.abs(right - left) > allowed
        jumps &= (np.abs(left - further) <= allowed) & (np.abs(beyond - right) <= allowed)
    return np.asarray(place[jumps])


def _between(value: float, known: Floats, allowed: float) -> bool:
    """Whether a value is no more than what is known of places where panels end anyhow."""
    if not known.size:
        return False
    return bool(np.fmin.reduce(known, None) - allowed <= value <= np.fmax.reduce(known, None) + allowed)


def _within(joints: Floats) -> Floats:
    """Angles within every piece of a motion that is shorter than what is looked at anyhow."""
    wide = np.diff(joints)
    short = (wide > POINT) & (wide < PIECE * SEEN)
    return np.asarray(joints[:-1][short, None] + wide[short, None] * (np.arange(PIECE) + ASIDE) / PIECE).ravel()


def _alone(edges: Floats, seen: Floats, allowed: float) -> list[float]:
    """Angles at which a value stands out from both beside it, and beside which others may look for it in vain."""
    both = np.stack([seen[:-2], seen[2:]])
    out = np.fmax(seen[1:-1] - both.max(axis=0), both.min(axis=0) - seen[1:-1]) > allowed
    at = edges[1:-1][out]
    return [float(x) for x in np.r_[at - 0.25 * SEEN, at, at + 0.25 * SEEN] if edges[0] < x < edges[-1]]


def _shown(angle: float) -> str:
    return f"{math.degrees(angle) % 360.0:.6g}"


def _refuse(value: Expression, why: str) -> NoReturn:
    hint = "limit its range of cam angle, or give a table"
    raise ProfileError([Problem(value.key, why, value.text, hint=hint)])


def enclosed(steps: Sequence[Step], low: Floats, high: Floats, moved: Mapping[str, Range] | None = None) -> Range:
    """Between which values an expression stays over ranges of the cam angle, rad, within a turn; infinite, or no
    number, where it may have none. moved: of what it hangs on beside that."""
    first, last = np.mod(low, TURN), np.mod(low, TURN) + (high - low)
    stack: list[Range] = []
    with np.errstate(all="ignore"):
        for kind, name, number in steps:
            if kind == "number":
                stack.append((np.full_like(low, number),) * 2)
            elif kind == "variable" and moved and name in moved:
                stack.append(moved[name])
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
    return _STEPS[name](*arguments) if name in _STEPS else _rising(_RISING[name], *arguments)


def _rising(function: Callable[[Floats], Floats], x: Range) -> Range:
    """Of a function that rises over all of where it has values; no number where a range leaves that."""
    low, high = (-1.0, 1.0) if function is np.arcsin else (0.0 if function in _OF_POSITIVE else -np.inf, np.inf)
    inside = (x[0] >= low) & (x[1] <= high)
    least, most = function(np.clip(x[0], low, high)), function(np.clip(x[1], low, high))
    return np.where(inside, least, np.nan), np.where(inside, most, np.nan)


def _negative(x: Range) -> Range:
    return -x[1], -x[0]


def _add(x: Range, y: Range) -> Range:
    return x[0] + y[0], x[1] + y[1]


def _of_ends(function: Callable[[Floats, Floats], Floats], x: Range, y: Range) -> Range:
    """Of a function whose extremes are at ends of both ranges; 0 times infinity is 0, the end being none itself."""
    each = np.stack([function(a, b) for a in x for b in y])
    none = np.isnan(np.stack([*x, *y])).any(axis=0)
    each[np.isnan(each) & ~none] = 0.0
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
    outside = ~whole & (x[0] < 0.0)
    ends = np.stack([np.power(low, exponent), np.power(high, exponent)])
    least, most = ends.min(axis=0), ends.max(axis=0)
    through = (low <= 0.0) & (high >= 0.0)
    least = np.where(through & even & (exponent > 0.0), 0.0, least)
    pole = through & (exponent < 0.0)
    least, most = np.where(pole, -np.inf, least), np.where(pole, np.inf, most)
    return np.where(outside, np.nan, least), np.where(outside, np.nan, most)


def _absolute(x: Range) -> Range:
    least = np.where((x[0] <= 0.0) & (x[1] >= 0.0), 0.0, np.minimum(np.abs(x[0]), np.abs(x[1])))
    return least, np.maximum(np.abs(x[0]), np.abs(x[1]))


def _wave(x: Range, crest: float, function: Callable[[Floats], Floats]) -> Range:
    """Of a sine or cosine, whose crests are a turn apart."""
    ends = np.stack([function(x[0]), function(x[1])])

    def passed(place: float) -> npt.NDArray[np.bool_]:
        return np.asarray(~(np.floor((x[1] - place) / TURN) < np.ceil((x[0] - place) / TURN)))

    none = np.where(np.isnan(x[0]) | np.isnan(x[1]), np.nan, 0.0)
    return (np.where(passed(crest + math.pi), -1.0, ends.min(axis=0)) + none,
            np.where(passed(crest), 1.0, ends.max(axis=0)) + none)  # fmt: skip


def _tan(x: Range) -> Range:
    pole = ~(np.floor(x[1] / math.pi - 0.5) < np.ceil(x[0] / math.pi - 0.5))
    return np.where(pole, -np.inf, np.tan(x[0])), np.where(pole, np.inf, np.tan(x[1]))


def _cosh(x: Range) -> Range:
    return _rising(np.cosh, _absolute(x))


def _hypot(x: Range, y: Range) -> Range:
    (a, b), (c, d) = _absolute(x), _absolute(y)
    return np.hypot(a, c), np.hypot(b, d)


def _atan2(y: Range, x: Range) -> Range:
    """Its extremes are at the ends but where a range goes over the left half of the axis, or the origin."""
    over = (x[0] <= 0.0) & (y[0] <= 0.0) & (y[1] >= 0.0)
    least, most = _of_ends(np.arctan2, y, x)
    return np.where(over, -math.pi, least), np.where(over, math.pi, most)


def _acos(x: Range) -> Range:
    least, most = _rising(np.arcsin, x)
    return 0.5 * math.pi - most, 0.5 * math.pi - least


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
