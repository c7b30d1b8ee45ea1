"""Response of the indexing drive: periodic steady state, transient from rest, and the load plate over many speeds."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.drive import TORSION, IndexingDrive
from camgeom.dynamics.indexing.system import DriveResponse, Fluctuation, Torque, TorsionSystem
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy
from camgeom.dynamics.linear.method import DrivenMotion
from camgeom.dynamics.linear.peaks import OutputPeaks
from camgeom.dynamics.linear.response import Sweep, periodic_response, swept, transient_response
from camgeom.dynamics.linear.walk import aligned_grid
from camgeom.errors import DesignError
from camgeom.maths import Floats

CONSTANT = Fluctuation()
STRETCHES = 360
"""pieces of a turn in each of which the rigid acceleration is searched"""


def steady_state(
    drive: IndexingDrive,
    motion: DrivenMotion,
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
    return periodic_response(driven(drive, motion, speed, fluctuation, torque, exact), accuracy)


def driven(
    drive: IndexingDrive, motion: DrivenMotion, speed: npt.ArrayLike, fluctuation: Fluctuation, torque: Torque | None,
    exact: bool,
) -> TorsionSystem:
    """The torsion of a drive at input speeds (b,) in rad/s. Raises DesignError where it is not definite."""
    refuse_indefinite(drive, motion)
    return TorsionSystem(drive, motion, np.atleast_1d(speed), fluctuation, torque, exact)


def from_rest(
    drive: IndexingDrive,
    motion: DrivenMotion,
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
    return begun(driven(drive, motion, speed, fluctuation, torque, exact), turns, accuracy, begin)


def begun(system: TorsionSystem, turns: int, accuracy: Accuracy, begin: npt.ArrayLike | None = None) -> DriveResponse:
    """The same of a system."""
    state = np.zeros((system.batch, 6))
    if begin is not None:
        state[:] = np.asarray(begin, dtype=float)
        state[:, 3:] /= system.rates(np.array([[system.motion.knots[0]]]))[0]
    return transient_response(system, accuracy, state, turns)


def at_rest(drive: IndexingDrive, motion: DrivenMotion, torque: Torque | None = None) -> Floats:
    """Deviations, rad, and rates, rad/s, (1, 6) of the drive that stands still at the first cam angle under a torque.

    K q = T with the contact between cam and turret at the motion's slope there; all zero without a torque. Raises
    DesignError as `refuse_indefinite`.
    """
    still = np.zeros((1, 6))
    if torque is not None:
        refuse_indefinite(drive, motion)
        theta = np.asarray(motion.knots[:1], dtype=float)
        stiffness = drive.stiffness(theta, motion, TORSION)[0]
        still[0, :3] = np.linalg.solve(stiffness, torque(theta[None], "right")[0, 0])
    return still


def refuse_indefinite(
    drive: IndexingDrive, motion: DrivenMotion, blocks: tuple[tuple[str, ...], ...] = (TORSION,)
) -> None:
    """DesignError when one of the blocks to be integrated has no definite stiffness, naming what would do."""
    wrong = [item for item in drive.indefinite(motion) if item.block in blocks]
    if wrong:
        raise DesignError("; ".join(str(item) for item in wrong) + "; it is not integrated")


def sweep(
    drive: IndexingDrive,
    motion: DrivenMotion,
    speed: npt.ArrayLike,
    accuracy: Accuracy = STANDARD,
    fluctuation: Fluctuation = CONSTANT,
    exact: bool = False,
    torque: Torque | None = None,
) -> Sweep:
    """Steady state at every input speed (s,) in rad/s: extremes of the load plate's acceleration.

    Raises DesignError for an indefinite torsion.
    """
    refuse_indefinite(drive, motion)

    def at(speeds: Floats) -> TorsionSystem:
        return TorsionSystem(drive, motion, speeds, fluctuation, torque, exact)

    return swept(at, np.atleast_1d(np.asarray(speed, dtype=float)), accuracy, ("load_acceleration",))


def rigid_peak(motion: DrivenMotion, speed: Floats) -> Floats:
    """Peak (b,) of the rigid turret acceleration in rad/s2 at mean speeds (b,) in rad/s."""
    theta = aligned_grid(motion.knots, STRETCHES).theta
    begin, width = theta[:-1], np.diff(theta)
    low, high = np.zeros_like(begin), np.ones_like(begin)
    best = float(np.abs(motion.jet(theta[1:], 2, "left")[2]).max())
    for _ in range(6):
        share = low + (high - low) * np.linspace(0.0, 1.0, 17)[:-1, None]
        values = np.abs(motion.jet(begin + share * width, 2)[2])
        best = max(best, float(values.max()))
        place = share.ravel()[values.argmax(0) * share.shape[1] + np.arange(share.shape[1])]
        reach = (high - low) / 16.0
        low, high = np.maximum(place - reach, 0.0), np.minimum(place + reach, 1.0)
    return np.asarray(speed**2 * best)


def amplification(peak: OutputPeaks, motion: DrivenMotion, speed: Floats) -> Floats:
    """Peak load-plate acceleration over its rigid value (b,) at mean speeds (b,) in rad/s, no unit."""
    return np.asarray(peak.magnitude / rigid_peak(motion, speed))
