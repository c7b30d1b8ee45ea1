"""The load plate's response over a sweep of input speeds: steady states in groups of one grid, verified speed by
speed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.drive import IndexingDrive, Motion
from camgeom.dynamics.indexing.response import CONSTANT, Response, refuse_indefinite, watch
from camgeom.dynamics.indexing.system import Fluctuation, TorsionSystem
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy, predicted_steps, verified
from camgeom.dynamics.linear.method import Method, find
from camgeom.dynamics.linear.solve import periodic
from camgeom.dynamics.linear.walk import aligned_grid
from camgeom.errors import NotConverged
from camgeom.maths import Floats

GROUP = 64
"""speeds solved together; more would outgrow the cache"""


@dataclass(frozen=True, eq=False)
class Sweep:
    """Steady states over input speeds (s,) in rad/s: peaks of the load-plate acceleration in rad/s2, where, and how
    exact.

    refused maps the index of a speed to the reason why it has no steady state; its numbers are those of the rigid
    motion and answered (s,) is False.
    """

    speed: Floats
    maximum: Floats
    maximum_at: Floats
    minimum: Floats
    minimum_at: Floats
    amplification: Floats
    spectral_radius: Floats
    error: Floats
    answered: npt.NDArray[np.bool_]
    choices: tuple[str, ...]
    refused: tuple[tuple[int, str], ...]

    @property
    def speed_rpm(self) -> Floats:
        """Input speeds (s,) in r/min."""
        return self.speed * 30.0 / np.pi

    @property
    def peak(self) -> Floats:
        """Larger magnitude of the load-plate acceleration (s,) in rad/s2."""
        return np.maximum(np.abs(self.maximum), np.abs(self.minimum))


def sweep(
    drive: IndexingDrive,
    motion: Motion,
    speed: npt.ArrayLike,
    accuracy: Accuracy = STANDARD,
    fluctuation: Fluctuation = CONSTANT,
    exact: bool = False,
) -> Sweep:
    """Steady state at every input speed (s,) in rad/s.

    A speed without a steady state (resonance without damping) is refused by name and does not stop the others. Raises
    DesignError for an indefinite torsion.
    """
    refuse_indefinite(drive, motion)
    speeds = np.atleast_1d(np.asarray(speed, dtype=float))
    table = np.zeros((8, len(speeds)))
    choices, refused = [""] * len(speeds), list[tuple[int, str]]()
    for group in _groups(drive, motion, speeds, accuracy, fluctuation, exact):
        for part, found in _answers(drive, motion, speeds, *group, accuracy, fluctuation, exact):
            if isinstance(found, str):
                refused.append((int(part[0]), found))
                continue
            table[:, part] = _row(found)
            for k in part:
                choices[k] = found.solution.choice
    top, top_at, bottom, bottom_at, ratio, radius, error, answered = table
    reasons = tuple(sorted(refused))
    good = answered > 0.0
    return Sweep(speeds, top, top_at, bottom, bottom_at, ratio, radius, error, good, tuple(choices), reasons)


Answer = tuple[npt.NDArray[np.intp], Response | str]
Group = tuple[npt.NDArray[np.intp], Method, int]


def _groups(
    drive: IndexingDrive, motion: Motion, speeds: Floats, accuracy: Accuracy, fluctuation: Fluctuation, exact: bool
) -> list[Group]:
    """Speeds that share a method and a grid, with the steps to begin with."""
    system = TorsionSystem(drive, motion, speeds, fluctuation, exact=exact)
    method = find(accuracy.method)
    if accuracy.steps is not None:
        return [(part, method, accuracy.steps) for part in _parts(np.arange(len(speeds)))]
    steps = predicted_steps(system, system.knots, accuracy.tolerance, method)
    # neighbours share a grid: fewer groups, at most two fifths more steps
    rungs = np.exp2(np.ceil(np.log2(steps) * 2.0) / 2.0).round().astype(int)
    out: list[Group] = []
    for rung in np.unique(rungs):
        out += [(part, method, int(rung)) for part in _parts(np.flatnonzero(rungs == rung))]
    return out


def _parts(index: npt.NDArray[np.intp]) -> list[npt.NDArray[np.intp]]:
    return [index[low : low + GROUP] for low in range(0, len(index), GROUP)]


def _answers(
    drive: IndexingDrive,
    motion: Motion,
    speeds: Floats,
    index: npt.NDArray[np.intp],
    method: Method,
    steps: int,
    accuracy: Accuracy,
    fluctuation: Fluctuation,
    exact: bool,
) -> list[Answer]:
    """Responses of a group; a group with a refusal is halved until the refused speed stands alone."""
    system = TorsionSystem(drive, motion, speeds[index], fluctuation, exact=exact)
    grid = aligned_grid(system.knots, steps)
    try:
        if accuracy.steps is not None:
            return [(index, Response(system, periodic(system, grid, method)))]
        found = verified(lambda g: periodic(system, g, method), grid, accuracy.tolerance, watch)
        return [(index, Response(system, found))]
    except NotConverged as reason:
        if len(index) == 1:
            return [(index, str(reason))]
    half = len(index) // 2
    args = (method, steps, accuracy, fluctuation, exact)
    return [
        *_answers(drive, motion, speeds, index[:half], *args),
        *_answers(drive, motion, speeds, index[half:], *args),
    ]


def _row(found: Response) -> Floats:
    """The columns of a sweep for a group of speeds."""
    peak = found.peak("load_acceleration")
    ratio = peak.magnitude / found.rigid_peak()
    radius, error = found.solution.spectral_radius, found.solution.error
    # a solution of a given number of steps has no measured error
    error = np.where(np.isfinite(error), error, 1.0)
    return np.stack(
        [peak.maximum, peak.maximum_at, peak.minimum, peak.minimum_at, ratio, radius, error, np.ones_like(radius)]
    )
