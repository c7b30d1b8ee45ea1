"""Response of the indexing drive: periodic steady state, transient from rest, and the load plate over many speeds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.drive import TORSION, IndexingDrive
from camgeom.dynamics.indexing.system import DriveResponse, Fluctuation, Torque, TorsionSystem
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy
from camgeom.dynamics.linear.method import Motion
from camgeom.dynamics.linear.response import periodic_response, swept, transient_response
from camgeom.errors import DesignError
from camgeom.maths import Floats

CONSTANT = Fluctuation()


def steady_state(
    drive: IndexingDrive,
    motion: Motion,
    speed: npt.ArrayLike,
    accuracy: Accuracy = STANDARD,
    fluctuation: Fluctuation = CONSTANT,
    torque: Torque | None = None,
    exact: bool = False,
) -> DriveResponse:
    """Periodic steady state at input speeds (b,) in rad/s, one method and step for all of them.

    Raises DesignError for a torsion that is not definite, NotConverged for a resonance without damping, a growing
    turn or a tolerance out of reach.
    """
    system = TorsionSystem(drive, motion, np.atleast_1d(speed), fluctuation, torque, exact)
    refuse_indefinite(drive, motion)
    return periodic_response(system, accuracy)


def from_rest(
    drive: IndexingDrive,
    motion: Motion,
    speed: npt.ArrayLike,
    turns: int = 1,
    accuracy: Accuracy = STANDARD,
    fluctuation: Fluctuation = CONSTANT,
    torque: Torque | None = None,
    begin: npt.ArrayLike | None = None,
    exact: bool = False,
) -> DriveResponse:
    """Transient over `turns` turns from rest at the first cam angle (or from begin (b, 6): deviations, rad, and
    rates, rad/s).
    """
    system = TorsionSystem(drive, motion, np.atleast_1d(speed), fluctuation, torque, exact)
    refuse_indefinite(drive, motion)
    state = np.zeros((system.batch, 6))
    if begin is not None:
        state[:] = np.asarray(begin, dtype=float)
        state[:, 3:] /= system.rates(np.array([[motion.knots[0]]]))[0]
    return transient_response(system, accuracy, state, turns)


def refuse_indefinite(drive: IndexingDrive, motion: Motion, blocks: tuple[tuple[str, ...], ...] = (TORSION,)) -> None:
    """DesignError when one of the blocks to be integrated has no definite stiffness, naming what would do."""
    wrong = [item for item in drive.indefinite(motion) if item.block in blocks]
    if wrong:
        raise DesignError("; ".join(str(item) for item in wrong) + "; it is not integrated")


def rigid_peak(response: DriveResponse) -> Floats:
    """Peak (b,) of the rigid turret acceleration in rad/s2 at the mean speed."""
    begin, width = response.theta[:-1], np.diff(response.theta)
    motion = response.system.motion
    low, high = np.zeros_like(begin), np.ones_like(begin)
    best = float(np.abs(motion.jet(response.theta[1:], 2, "left")[2]).max())
    for _ in range(6):
        share = low + (high - low) * np.linspace(0.0, 1.0, 17)[:-1, None]
        values = np.abs(motion.jet(begin + share * width, 2)[2])
        best = max(best, float(values.max()))
        place = share.ravel()[values.argmax(0) * share.shape[1] + np.arange(share.shape[1])]
        reach = (high - low) / 16.0
        low, high = np.maximum(place - reach, 0.0), np.minimum(place + reach, 1.0)
    return np.asarray(response.speed**2 * best)


def amplification(response: DriveResponse) -> Floats:
    """Peak load-plate acceleration over its rigid value (b,), no unit."""
    return np.asarray(response.peak("load_acceleration").magnitude / rigid_peak(response))


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

    def at(some: Floats) -> TorsionSystem:
        return TorsionSystem(drive, motion, some, fluctuation, exact=exact)

    for part, answer in swept(at, speeds, accuracy):
        if isinstance(answer, str):
            refused.append((int(part[0]), answer))
            continue
        table[:, part] = _row(answer)
        for k in part:
            choices[k] = answer.solution.choice
    top, top_at, bottom, bottom_at, ratio, radius, error, answered = table
    reasons = tuple(sorted(refused))
    good = answered > 0.0
    return Sweep(speeds, top, top_at, bottom, bottom_at, ratio, radius, error, good, tuple(choices), reasons)


def _row(response: DriveResponse) -> Floats:
    """The columns of a sweep for a group of speeds."""
    peak = response.peak("load_acceleration")
    ratio = peak.magnitude / rigid_peak(response)
    radius, error = response.solution.spectral_radius, response.solution.error
    # a solution of a given number of steps has no measured error
    error = np.where(np.isfinite(error), error, 1.0)
    return np.stack(
        [peak.maximum, peak.maximum_at, peak.minimum, peak.minimum_at, ratio, radius, error, np.ones_like(radius)]
    )
