"""Largest values and roots of smooth pieces, refined beyond the sampling grid, many at once. No scipy."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import numpy.typing as npt
from numpy.typing import ArrayLike

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats

FAN = 17
_SHARES = np.linspace(0.0, 1.0, FAN)
BESIDE = 2.0**-46
"""64 units in the last place: on its own side of a knot also after whole turns are taken off"""
ROUNDS = 9
"""rounds of FAN samples: a bracket shrinks to 1e-8 of its width, and the value at a peak to its square"""
TRUST = 1.0 / 64.0
"""of a step of samples, on both sides of a parabola's vertex: where the maximum of a smooth function is looked for"""
SAME = 4e-16
"""share by which rounding tells two values apart"""
FLAT = 1.6e-15
"""share within which all samples of a bracket are one value"""
MET = 8e-15
"""the same of a value that parabolas extrapolate"""


@immutable(eq=True)
class Extreme:
    """The largest (or least) value of a quantity, and where.

    cam_angle  rad; place: along what has it (a roller: delta, mm), 0 where there is but one place
    where      the name of what has it (a flank, a touch, a wall), where there are several
    """

    value: float
    cam_angle: float
    place: float = 0.0
    where: str = ""


def hardest(found: Iterable[Extreme]) -> Extreme:
    """The one with the largest value."""
    return max(found, key=lambda extreme: extreme.value)


def piece_grid(knots: Floats, per_turn: int, least: int = 9) -> tuple[Floats, npt.NDArray[np.int64]]:
    """Sample points inside each knot interval, its ends included but nudged inwards so that one-sided values are met.

    knots     (k,) increasing
    per_turn  samples for 2 pi of the parameter
    Returns the points (n,) and the interval number of each.
    """
    points, owner = [], []
    for i, (low, high) in enumerate(zip(knots[:-1], knots[1:])):
        count = max(least, int(np.ceil(per_turn * (high - low) / (2.0 * np.pi))) + 1)
        nudge = min(BESIDE * max(abs(low), abs(high)), 1e-9 * (high - low))
        points.append(np.linspace(low + nudge, high - nudge, count))
        owner.append(np.full(count, i))
    return np.concatenate(points), np.concatenate(owner)


def brackets(x: Floats, owner: npt.NDArray[np.int64], values: Floats, keep: int = 6,
             least: float = -np.inf) -> tuple[Floats, Floats]:
    """Where between samples the largest value may lie: ends (k,) of the intervals beside the best local maxima.

    x  increasing samples; `owner` numbers the smooth piece of each; values (n,); keep, least: see `refined_maximum`
    """
    left = np.r_[False, owner[1:] == owner[:-1]]
    right = np.r_[owner[:-1] == owner[1:], False]
    below = np.r_[-np.inf, values[:-1]]
    above = np.r_[values[1:], -np.inf]
    peak = (~left | (values >= below)) & (~right | (values >= above))
    # Between two samples a smooth function rises no more above the better one than that stands above its neighbours.
    lower = np.minimum(np.where(left, below, values), np.where(right, above, values))
    drop = np.subtract(values, lower, out=np.zeros_like(values), where=np.isfinite(values))
    index = np.flatnonzero(peak & (values + drop >= max(float(values.max()), least)))
    index = index[np.argsort(values[index])[::-1][:keep]]
    low = np.where(left[index], x[np.maximum(index - 1, 0)], x[index])
    high = np.where(right[index], x[np.minimum(index + 1, len(x) - 1)], x[index])
    return low, high


def refined_maximum(f: Callable[[Floats], Floats], x: Floats, owner: npt.NDArray[np.int64], values: Floats,
                    keep: int = 6, grain: float = 0.0, least: float = -np.inf) -> tuple[float, float]:
    """Largest value of f and where, refined about the best local maxima of the samples.

    f       vectorised function of x (n,) -> (n,)
    x       increasing samples; `owner` numbers the smooth piece of each; values (n,) = f(x)
    grain   share by which values beside a kink differ for no reason
    least   what does not reach this is of no interest: it need not be refined
    Returns (value, x). The result is never below the best sample.
    """
    low, high = brackets(x, owner, values, keep, least)
    start = int(np.argmax(values))
    if not len(low):
        return float(values[start]), float(x[start])
    found, where = bracketed_maximum(
        lambda at: f(at.ravel()).reshape(at.shape), low, high, grain=grain, least=max(float(values[start]), least)
    )
    best = int(np.argmax(found))
    if found[best] >= values[start]:
        return float(found[best]), float(where[best])
    return float(values[start]), float(x[start])


def bracketed_maximum(f: Callable[[Floats], Floats], low: Floats, high: Floats, *, noise: float = 0.0,
                      grain: float = 0.0, least: float | None = None) -> tuple[Floats, Floats]:
    """Maxima of functions of x (k, q), row by row, in the brackets low .. high (k,): values (k,) and places (k,).

    Each row with one maximum in its bracket converges down to rounding: the parabola through the best sample and its
    neighbours says what is left to gain and where. Where the maximum is not there, the two parabolas through what lies
    on either side say where they meet, as at a kink. Where it is not there either, as at a jump, the row converges by
    (FAN - 1) / 2 a round from the bracket before.

    noise   what values of f differ by for no reason, beside SAME; grain: the same as a share, beside a kink
    least   only the largest of all rows is asked for, and only if it is larger than this: rows that do not rise to it
            need not converge; None: all have to
    """
    rows = np.arange(len(low))
    best, place = np.full(len(low), -np.inf), low
    jumped = np.zeros(len(low), dtype=bool)
    misses = np.zeros(len(low), dtype=np.int64)
    around = low, high
    for number in range(ROUNDS + 4):
        x = low[:, None] + (high - low)[:, None] * _SHARES
        values = f(x)
        top = np.argmax(values, axis=1)
        value, at = values[rows, top], x[rows, top]
        best, place = np.where(value >= best, value, best), np.where(value >= best, at, place)
        edge = (top == 0) | (top == FAN - 1)
        missed = jumped & edge
        misses = misses + missed
        middle = np.clip(top, 1, FAN - 2)
        three = values[rows[:, None], middle[:, None] + np.arange(-1, 2)]
        smooth = np.isfinite(three).all(axis=1)
        a, b, c = np.where(smooth[:, None], three, 0.0).T
        step, bend, slope = (high - low) / (FAN - 1), a - 2.0 * b + c, 0.5 * (c - a)
        vertex = np.where(bend < 0.0, -slope / np.where(bend < 0.0, bend, -1.0), top - middle)
        vertex = np.clip(vertex, -middle, FAN - 1 - middle)
        gain = b + vertex * (slope + 0.5 * vertex * bend) - value
        bottom = values.min(axis=1)
        known = np.isfinite(bottom)
        flat = known & (value - np.where(known, bottom, 0.0) <= FLAT * np.abs(b))
        done = smooth & (flat | ~missed & (gain <= SAME * np.abs(b) + noise))
        told = smooth & ~edge & (misses == 0)
        if misses.any():
            kink, meeting, meets = _meeting(values, top)
            off = meeting - value
            done |= meets & (misses > 0) & (np.abs(off) <= max(MET, grain) * np.abs(b) + noise)
            sought = meets & (misses == 1) & (off >= 0.0)
            vertex, told = np.where(sought, kink, vertex), told | sought
        if least is not None:
            # As between samples: above the best one no more than that stands above its neighbours, or twice that.
            beside, there = values[rows[:, None], np.clip(top[:, None] + (-1, 1), 0, FAN - 1)], np.isfinite(value)
            highest = np.where(there, value, 0.0)
            hope = 3.0 * highest - 2.0 * np.where(np.isfinite(beside), beside, highest[:, None]).min(axis=1)
            done |= there & ~missed & (np.maximum(best, hope) < max(float(best.max()), least))
        if (number > 0 and done.all()) or np.all(high - low <= SAME * np.maximum(np.abs(low), np.abs(high))):
            break
        left, right = x[rows, np.maximum(top - 1, 0)], x[rows, np.minimum(top + 1, FAN - 1)]
        around = np.where(missed, around[0], left), np.where(missed, around[1], right)
        jumped = told
        centre = x[rows, middle] + vertex * step
        low = np.where(jumped, np.maximum(around[0], centre - TRUST * step), around[0])
        high = np.where(jumped, np.minimum(around[1], centre + TRUST * step), around[1])
    return best, place


_BESIDE = np.array([-3, -2, -1, 1, 2, 3])


def _meeting(values: Floats, top: npt.NDArray[np.int64]) -> tuple[Floats, Floats, npt.NDArray[np.bool_]]:
    """Where the parabolas through three samples on either side of the best one (k,) meet, from it, in steps.

    Returns that place, the value there, and whether they do meet there, the left one rising and the right one falling.
    """
    rows = np.arange(len(top))[:, None]
    six = values[rows, np.clip(top[:, None] + _BESIDE, 0, FAN - 1)]
    there = (top >= 3) & (top <= FAN - 4) & np.isfinite(six).all(axis=1)
    six = np.where(there[:, None], six, 0.0)
    # Beside a cusp their squares would leave the numbers' range; a power of two takes no digit.
    size = np.ldexp(1.0, np.frexp(np.abs(six).max(axis=1))[1])
    a3, a2, a1, c1, c2, c3 = six.T / size
    # Newton's form about the nearest sample: a + b (s + 1) + c (s + 1) (s + 2), as a polynomial of s.
    left = _polynomial(a1, a2, a3)
    right = _polynomial(c1, c2, c3)
    right[1] *= -1.0
    d0, d1, d2 = right - left
    root = np.sqrt(np.maximum(d1 * d1 - 4.0 * d2 * d0, 0.0))
    below = d1 + np.where(d1 >= 0.0, root, -root)
    there &= below != 0.0
    s = -2.0 * d0 / np.where(there, below, 1.0)
    rises, falls = (line[1] + 2.0 * s * line[2] for line in (left, right))
    return s, size * (left[0] + s * (left[1] + s * left[2])), there & (np.abs(s) <= 1.0) & (rises > 0.0) & (falls < 0.0)


def _polynomial(one: Floats, two: Floats, three: Floats) -> Floats:
    """Coefficients (3, k) of the parabola of s that is one, two and three at s = -1, -2 and -3."""
    first, second = one - two, 0.5 * (one - 2.0 * two + three)
    return np.array([one + first + 2.0 * second, first + 3.0 * second, second])


def narrowed(f: Callable[[Floats], Floats], low: Floats, high: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """One round: every bracket sampled at FAN points in one call of f (k, FAN), and the two intervals about the best.

    Returns the largest samples (k,), their places, and the brackets left.
    """
    rows = np.arange(len(low))
    x = low[:, None] + (high - low)[:, None] * _SHARES
    values = f(x)
    best = np.argmax(values, axis=1)
    left, right = x[rows, np.maximum(best - 1, 0)], x[rows, np.minimum(best + 1, FAN - 1)]
    return values[rows, best], x[rows, best], left, right


def bracketed_root(function: Callable[[Floats], Floats], low: ArrayLike, high: ArrayLike, tolerance: float = 0.0,
                   steps: int = 120) -> Floats:
    """Roots of a vectorised function, one in each bracket [low, high] with opposite signs, to tolerance or rounding.

    Inverse quadratic steps where the three points are monotone enough, bisection elsewhere (Chandrupatla 1997). Where
    the ends do not differ in sign the end nearer zero is given.
    """
    b, a = np.array(low, dtype=np.float64), np.array(high, dtype=np.float64)
    if not a.size:
        return a
    fb, fa = function(b), function(a)
    opposite = np.sign(fa) * np.sign(fb) < 0.0
    best = np.where(np.abs(fa) <= np.abs(fb), a, b)
    share = np.full(a.shape, 0.5)
    active = opposite.copy()
    for _ in range(steps):
        if not active.any():
            return best
        x = np.where(active, a + share * (b - a), a)
        fx = function(x)
        same = np.sign(fx) == np.sign(fa)
        c, fc = np.where(same, a, b), np.where(same, fa, fb)
        b, fb = np.where(same, b, a), np.where(same, fb, fa)
        a, fa = x, fx
        best = np.where(active, np.where(np.abs(fa) <= np.abs(fb), a, b), best)
        least = np.maximum(2e-16 * np.abs(best), max(0.5 * tolerance, 1e-300))
        span = np.abs(b - a)
        active = active & (span > 2.0 * least) & (fx != 0.0)
        share = _next_share(a, b, c, fa, fb, fc)
        edge = np.minimum(np.divide(least, span, out=np.full(a.shape, 0.5), where=span > 2.0 * least), 0.5)
        share = np.clip(share, edge, 1.0 - edge)
    raise NotConverged("a root was bracketed but not found to rounding: is the function finite over the bracket?")


def _next_share(a: Floats, b: Floats, c: Floats, fa: Floats, fb: Floats, fc: Floats) -> Floats:
    """Where the next trial point lies between a and b: inverse quadratic where that is safe, else the middle."""
    usable = (fc != fb) & (c != b) & (fa != fb) & (fa != fc)
    one = np.where(usable, 1.0, 0.0)
    d_cb, d_ab, d_ac = np.where(usable, fc - fb, 1.0), np.where(usable, fa - fb, 1.0), np.where(usable, fa - fc, 1.0)
    where = (a - b) / np.where(c == b, 1.0, c - b)
    level = d_ab / d_cb * one
    usable &= (level * level < where) & ((1.0 - level) ** 2 < 1.0 - where)
    quadratic = (fa / -d_ab) * (fc / -d_cb) + (c - a) / np.where(a == b, 1.0, b - a) * (fa / -d_ac) * (fb / d_cb)
    return np.asarray(np.where(usable, quadratic, 0.5), dtype=np.float64)
