"""Extremes of an output between the nodes of a solution, to the accuracy of the solution itself.

Candidates come from quintic Hermite interpolation (position, rate, acceleration at both ends of each step); the few
best intervals are then looked at with true partial steps of a high-order method, which never straddle a knot.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.linear.method import Side, System
from camgeom.dynamics.linear.solve import AT_ONCE, INSIDE, Solution, advance
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property

Output = Callable[[Floats, Floats, Floats, Side], Floats]
"""Value (b, n) from cam angles theta (1 or b, n), q (b, n, m), q' (b, n, m) and the side at a knot."""

CANDIDATES = 3
LOOKED_AT = 64
"""intervals with the largest and with the smallest promise"""
TRUST = 0.01
"""share of the range by which interpolated samples may exceed the true extreme"""
SWEEP = np.linspace(0.0, 1.0, 9)
QUARTIC = np.linspace(-1.0, 1.0, 5)
FIT = np.linalg.inv(np.vander(QUARTIC, increasing=True))
END = 1.0 - 1e-12
"""share of a step that still lies before its end, where a knot may be"""


@immutable
class OutputPeaks:
    """The largest and the smallest value (b,) of an output and the cam angles (b,) in rad where they occur."""

    maximum: Floats
    maximum_at: Floats
    minimum: Floats
    minimum_at: Floats

    @cached_property
    def magnitude(self) -> Floats:
        """The larger of both in magnitude (b,)."""
        return np.maximum(np.abs(self.maximum), np.abs(self.minimum))

    @cached_property
    def magnitude_at(self) -> Floats:
        """Cam angles (b,) in rad of the larger of both."""
        return np.where(np.abs(self.maximum) >= np.abs(self.minimum), self.maximum_at, self.minimum_at)


def peak(solution: Solution, output: Output) -> OutputPeaks:
    """Extremes of an output over a solution, between its nodes too.

    Where interpolation promises more than true steps find (a force through a spring much stiffer than the step
    resolves), true steps are taken in what promises most too, until no other interval could hold more if it were as
    wrong as the worst of those.
    """
    samples = sampled(solution, output)
    found = _best(solution, output, samples)
    for sign in (1.0, -1.0):
        left, wrong, count = np.arange(samples.shape[1]), np.zeros(len(samples)), LOOKED_AT
        while len(left):
            rest = sign * samples[:, left]
            short = rest.max((1, 2)) + wrong - sign * (found.maximum if sign > 0.0 else found.minimum)
            if np.all(short <= TRUST * (found.maximum - found.minimum)):
                break
            some = distinct(np.argsort(_tops(rest), axis=1)[:, -count:].ravel())
            true = _true_inside(solution, output, left[some])
            wrong = np.maximum(wrong, np.abs(sign * true - rest[:, some, : len(INSIDE)]).max((1, 2)))
            samples[:, left[some], : len(INSIDE)] = true
            left, count = np.delete(left, some), 4 * count
            found = _best(solution, output, samples)
    return found


def _best(solution: Solution, output: Output, samples: Floats) -> OutputPeaks:
    """Extremes in the intervals whose samples (b, steps, k) are largest and smallest."""
    upper = np.argsort(-_tops(samples), axis=1)[:, :CANDIDATES]
    lower = np.argsort(-_tops(-samples), axis=1)[:, :CANDIDATES]
    best = np.concatenate([upper, lower], 1)
    sign = np.repeat([1.0, -1.0], [upper.shape[1], lower.shape[1]])
    begin, width = solution.theta[:-1][best], np.diff(solution.theta)[best]
    state = np.concatenate([solution.position, solution.rate], -1)[np.arange(len(samples))[:, None], best]
    values, share = _refined(solution.system, output, sign[:, None], begin, width, state)
    values, places, half = values * sign, begin + share * width, upper.shape[1]
    row = np.arange(len(samples))
    top, bottom = values[:, :half].argmax(1), half + values[:, half:].argmin(1)
    return OutputPeaks(values[row, top], places[row, top], values[row, bottom], places[row, bottom])


def _tops(samples: Floats) -> Floats:
    """Largest value (b, steps) in each interval, by parabolas through its samples (inside first, then both ends)."""
    y = np.concatenate([samples[..., -2:-1], samples[..., :-2], samples[..., -1:]], -1)
    slope, bend = (y[..., 2:] - y[..., :-2]) / 2.0, y[..., 2:] - 2.0 * y[..., 1:-1] + y[..., :-2]
    place = np.divide(-slope, bend, out=np.zeros_like(slope), where=bend < 0.0)
    vertex = y[..., 1:-1] + np.where(np.abs(place) <= 1.0, place * slope / 2.0, 0.0)
    return np.asarray(np.maximum(y.max(-1), vertex.max(-1)))


def _refined(
    system: System, output: Output, sign: Floats, begin: Floats, width: Floats, state: Floats
) -> tuple[Floats, Floats]:
    """Maximum (b, j) of sign x output in intervals (b, j) and where, a share of the interval."""

    def at(share: Floats) -> Floats:
        return sign * _inside(system, output, begin, width, state, share)

    share = np.broadcast_to(SWEEP, (*begin.shape, len(SWEEP)))
    values = at(share)
    best, place = _pick(values, share)
    reach = 1.0 / (len(SWEEP) - 1)
    for _ in range(2):
        centre = np.clip(place, reach, 1.0 - reach)
        window = centre[..., None] + reach * QUARTIC
        values = at(window)
        direct, where = _pick(values, window)
        fitted, offset = _quartic_top(values)
        closer = fitted > direct
        place = np.where(closer, centre + reach * offset, where)
        best = np.maximum(best, direct)
        reach /= 8.0
    return best, place


def _quartic_top(values: Floats) -> tuple[Floats, Floats]:
    """Maximum of the quartic through five equally spaced values (..., 5), and where in -1 .. 1."""
    c = values @ FIT.T
    fine = np.linspace(-1.0, 1.0, 33)
    basis = np.vander(fine, 5, increasing=True)
    x = fine[(c @ basis.T).argmax(-1)]
    for _ in range(4):
        slope = c[..., 1] + x * (2.0 * c[..., 2] + x * (3.0 * c[..., 3] + x * 4.0 * c[..., 4]))
        bend = 2.0 * c[..., 2] + x * (6.0 * c[..., 3] + x * 12.0 * c[..., 4])
        x = np.clip(x - np.divide(slope, bend, out=np.zeros_like(slope), where=bend < 0.0), -1.0, 1.0)
    top = c[..., 0] + x * (c[..., 1] + x * (c[..., 2] + x * (c[..., 3] + x * c[..., 4])))
    return top, x


def _pick(values: Floats, share: Floats) -> tuple[Floats, Floats]:
    """Largest of the values (..., k) and its share."""
    index = values.argmax(-1)[..., None]
    return np.take_along_axis(values, index, -1)[..., 0], np.take_along_axis(share, index, -1)[..., 0]


def _inside(system: System, output: Output, begin: Floats, width: Floats, state: Floats, share: Floats) -> Floats:
    """The output (b, j, k) at shares (b, j, k) of intervals (b, j), by true steps from their first node."""
    b, j, k = share.shape
    start = np.broadcast_to(begin[..., None], share.shape).reshape(b, j * k)
    length = (width[..., None] * np.minimum(share, END)).reshape(b, j * k)
    y = np.broadcast_to(state[:, :, None, :], (b, j, k, state.shape[-1])).reshape(b, j * k, -1)
    y = advance(system, start, length, y)
    return output(start + length, y[..., : system.size], y[..., system.size :], "right").reshape(share.shape)


def _true_inside(solution: Solution, output: Output, steps: npt.NDArray[np.intp]) -> Floats:
    """The output (b, j, k) inside some steps (j,), by true steps from their first nodes."""
    shape = (solution.system.batch, len(steps))
    begin, width = (np.broadcast_to(each[steps], shape) for each in (solution.theta[:-1], np.diff(solution.theta)))
    state = np.concatenate([solution.position[:, steps], solution.rate[:, steps]], -1)
    return _inside(solution.system, output, begin, width, state, np.broadcast_to(INSIDE, (*shape, len(INSIDE))))


def _ends(solution: Solution, output: Output, low: int, high: int) -> Floats:
    """The output (b, steps, 2) at the start and at the end of the steps low .. high."""
    nodes = slice(low, high + 1)
    theta, q, v = solution.theta[None, nodes], solution.position[:, nodes], solution.rate[:, nodes]
    return np.stack([output(theta, q, v, "right")[:, :-1], output(theta, q, v, "left")[:, 1:]], -1)


def sampled(solution: Solution, output: Output) -> Floats:
    """The output (b, steps, k) inside and at the ends of every step, by quintic Hermite interpolation."""
    count, part = len(solution.theta) - 1, max(1, AT_ONCE // solution.system.batch)
    parts = []
    for low in range(0, count, part):
        high = min(low + part, count)
        values = output(*solution.inside(low, high), "right").reshape(solution.system.batch, high - low, len(INSIDE))
        parts.append(np.concatenate([values, _ends(solution, output, low, high)], -1))
    return np.concatenate(parts, 1)
