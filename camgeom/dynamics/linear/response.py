"""Response of a driven system: periodic steady state, transient and sweep, their named outputs and extremes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf
from typing import Generic, Protocol, TypeVar, final

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.linear.accuracy import Accuracy, Once, affordable, predicted_steps, solved, verified
from camgeom.dynamics.linear.budget import Purse, refuse_costly
from camgeom.dynamics.linear.method import Method, Side, System, find
from camgeom.dynamics.linear.peaks import Output, OutputPeaks, peak
from camgeom.dynamics.linear.solve import Solution, advance, periodic, transient
from camgeom.dynamics.linear.walk import TurnGrid, aligned_grid
from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import cached_property, frozen

GROUP = 64
"""speeds solved together; more would outgrow the cache"""


class Driven(System, Protocol):
    """A system that a motion drives: speeds (b,) in rad/s, knots in rad, and the outputs that are read from it."""

    @property
    def speed(self) -> Floats: ...

    @property
    def knots(self) -> Floats: ...

    @property
    def outputs(self) -> Mapping[str, str]:
        """Names of the outputs, with unit and meaning."""
        ...

    @property
    def judged(self) -> str:
        """The output that must be as accurate as the coordinates themselves."""
        ...

    def read(self, name: str, theta: Floats, position: Floats, rate: Floats, side: Side) -> Floats:
        """An output (b, n) from q and q' (b, n, m) at cam angles theta (1 or b, n)."""
        ...


S = TypeVar("S", bound=Driven)


@final
@immutable
class Response(Generic[S]):
    """Motion of a system at one or more speeds (b,): the solution, and outputs computed when asked."""

    system: S
    solution: Solution

    @cached_property
    def theta(self) -> Floats:
        """Cam angles (n + 1) of the nodes in rad."""
        return self.solution.theta

    @cached_property
    def speed(self) -> Floats:
        """Speeds (b,) in rad/s."""
        return self.system.speed

    def output(self, name: str, side: Side = "right") -> Floats:
        """An output (b, n + 1) at the nodes; at a knot the limit from the given side."""
        return output(self.system, name)(self.theta[None], self.solution.position, self.solution.rate, side)

    def at(self, theta: npt.ArrayLike, name: str) -> Floats:
        """An output (b, k) at any cam angles (k,) of the solution, rad, by true steps from the nodes."""
        angles = np.atleast_1d(np.asarray(theta, dtype=float))
        index = np.clip(np.searchsorted(self.theta, angles, "right") - 1, 0, len(self.theta) - 2)
        y = np.concatenate([self.solution.position, self.solution.rate], -1)[:, index]
        y = advance(self.system, self.theta[None, index], (angles - self.theta[index])[None], y)
        m = self.system.size
        return output(self.system, name)(angles[None], y[..., :m], y[..., m:], "right")

    def peak(self, name: str) -> OutputPeaks:
        """Extremes of an output between the nodes too, with their cam angles."""
        if name not in self._peaks:
            self._peaks[name] = frozen(peak(self.solution, output(self.system, name)))
        return self._peaks[name]

    @cached_property
    def _peaks(self) -> dict[str, OutputPeaks]:
        """Extremes that were asked for."""
        return {}

    def certainty(self) -> dict[str, object]:
        """What a result file says about the numbers of the first speed: error, integrator, cautions."""
        solution, error = self.solution, float(self.solution.error[0])
        return {
            "error": error if np.isfinite(error) else None,
            "integrator": solution.choice or f"{solution.method.name}, {solution.grid.steps} steps",
            "cautions": list(solution.cautions),
        }


def output(system: Driven, name: str) -> Output:
    """The function that gives an output of the system; ProfileError names them for any other name."""
    if name not in system.outputs:
        raise ProfileError([Problem("dynamics.output", "no such output", name, ", ".join(system.outputs))])

    def value(theta: Floats, position: Floats, rate: Floats, side: Side) -> Floats:
        return system.read(name, theta, position, rate, side)

    return value


def periodic_response(system: S, accuracy: Accuracy) -> Response[S]:
    """Periodic steady state, one step for all speeds; raises as `periodic` and `verified` do."""
    return _solved(system, accuracy, lambda grid, method: periodic(system, grid, method))


def transient_response(system: S, accuracy: Accuracy, begin: Floats, turns: int) -> Response[S]:
    """Motion over `turns` turns from a state begin (b, 2m) of q, q' at the first cam angle."""
    return _solved(system, accuracy, lambda grid, method: transient(system, grid, method, begin, turns))


def _solved(system: S, accuracy: Accuracy, once: Once) -> Response[S]:
    return Response(system, solved(system, system.knots, accuracy, once, watch(system)))


@final
@immutable
class Sweep:
    """Steady states over speeds (s,) in rad/s: extremes of some outputs by name, and how exact they are.

    answered (s,) is False at a speed that has no steady state, and its figures are zeros; refused names the index of
    the speed and the reason.
    """

    speed: Floats
    peaks: Mapping[str, OutputPeaks]
    spectral_radius: Floats
    error: Floats
    answered: npt.NDArray[np.bool_]
    refused: tuple[tuple[int, str], ...]

    @cached_property
    def speed_rpm(self) -> Floats:
        """Speeds (s,) in r/min."""
        return self.speed * 30.0 / np.pi

    def figures(self, columns: Mapping[str, Floats]) -> dict[str, object]:
        """Columns (s,) of a result file as lists over the speeds, null where there is no steady state."""
        rows = {
            name: [float(v) if good else None for v, good in zip(values, self.answered, strict=True)]
            for name, values in columns.items()
        }
        refused = [{"speed_rpm": float(self.speed_rpm[k]), "reason": why} for k, why in self.refused]
        return {"speed_rpm": [float(v) for v in self.speed_rpm], **rows, "refused": refused}


def swept(at: Callable[[Floats], S], speeds: Floats, accuracy: Accuracy, outputs: tuple[str, ...]) -> Sweep:
    """Periodic responses over speeds (s,) in rad/s of the system that `at` makes for some of them.

    A speed without a steady state (resonance without damping) is refused by name and does not stop the others. Raises
    NotConverged, with the cost, where the whole would take too long.
    """
    count = len(speeds)
    extremes, radius, error = np.zeros((len(outputs), 4, count)), np.zeros(count), np.zeros(count)
    answered, refused = np.zeros(count, dtype=bool), list[tuple[int, str]]()
    for index, answer in _grouped(at, speeds, accuracy):
        if isinstance(answer, str):
            refused.append((int(index[0]), answer))
            continue
        answered[index] = True
        radius[index], error[index] = answer.solution.spectral_radius, answer.solution.error
        for k, name in enumerate(outputs):
            top = answer.peak(name)
            extremes[k][:, index] = top.maximum, top.maximum_at, top.minimum, top.minimum_at
    peaks = {name: OutputPeaks(*rows) for name, rows in zip(outputs, extremes, strict=True)}
    return Sweep(speeds, peaks, radius, error, answered, tuple(sorted(refused)))


Answer = tuple[npt.NDArray[np.intp], Response[S] | str]
"""Speeds by index, and their response or, for a single one, the reason why it has none."""


def _grouped(at: Callable[[Floats], S], speeds: Floats, accuracy: Accuracy) -> list[Answer[S]]:
    """Responses of all speeds in groups: neighbours share a grid, at the price of at most two fifths more steps."""
    everywhere, purse = np.arange(len(speeds)), Purse(accuracy.sweep)
    if accuracy.steps is not None:
        steps = accuracy.steps
        refuse_costly(at(speeds[:1]), find(accuracy.method), steps * len(speeds), accuracy.sweep, bytes_=inf)
        return [answer for part in _parts(everywhere) for answer in _answers(at, speeds, part, steps, accuracy, purse)]
    whole, method = at(speeds), find(accuracy.method)
    predicted = predicted_steps(whole, whole.knots, accuracy.tolerance, method)
    refuse_costly(whole, method, 2.0 * float(predicted.sum()), accuracy.sweep, bytes_=inf)
    rungs = np.exp2(np.ceil(np.log2(predicted) * 2.0) / 2.0).round().astype(int)
    out: list[Answer[S]] = []
    for rung in distinct(rungs):
        for part in _parts(everywhere[rungs == rung]):
            out += _answers(at, speeds, part, int(rung), accuracy, purse)
    return out


def _parts(index: npt.NDArray[np.intp]) -> list[npt.NDArray[np.intp]]:
    return [index[low : low + GROUP] for low in range(0, len(index), GROUP)]


def _answers(
    at: Callable[[Floats], S], speeds: Floats, index: npt.NDArray[np.intp], steps: int, accuracy: Accuracy, purse: Purse
) -> list[Answer[S]]:
    """Responses of a group begun with some steps; one with a refusal is halved until the refused speed stands alone."""
    system, method = at(speeds[index]), find(accuracy.method)
    grid = aligned_grid(system.knots, steps)
    try:
        if accuracy.steps is not None:
            purse.pay(system, method, grid.steps * system.batch)
            return [(index, Response(system, periodic(system, grid, method)))]

        def paid(on: TurnGrid, by: Method) -> Solution:
            purse.pay(system, by, on.steps * system.batch)
            return periodic(system, on, by)

        once = affordable(system, method, paid)
        solution = verified(once, grid, accuracy.tolerance, watch(system))
        return [(index, Response(system, solution))]
    except NotConverged as reason:
        if len(index) == 1:
            return [(index, str(reason))]
    half = len(index) // 2
    return [
        *_answers(at, speeds, index[:half], steps, accuracy, purse),
        *_answers(at, speeds, index[half:], steps, accuracy, purse),
    ]


def watch(system: Driven) -> Callable[[Solution], Floats]:
    """What a response must have right: the coordinates and the judged output, (b, n + 1, m + 1)."""
    judged = output(system, system.judged)

    def watched(solution: Solution) -> Floats:
        values = judged(solution.theta[None], solution.position, solution.rate, "right")
        return np.concatenate([solution.position, values[..., None]], -1)

    return watched


def positive_speeds(speed: npt.ArrayLike) -> Floats:
    """Speeds (b,) in rad/s; ProfileError unless all are positive and finite."""
    speeds = np.atleast_1d(np.asarray(speed, dtype=float))
    if not (np.isfinite(speeds).all() and (speeds > 0.0).all()):
        raise ProfileError([Problem("operation.speed", "must be positive and finite", speeds.tolist(), "> 0")])
    return speeds
