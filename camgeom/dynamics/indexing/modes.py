"""Natural frequencies, mode shapes, critical speeds, speed classes and the Campbell diagram of the indexing drive.

Undamped, for a cam held at each angle: K(theta) phi = omega^2 M phi, block by block. The first published statement
that the three torsional modes are the lowest three is not true in general, so modes are sorted by value and labelled
by block.
"""

from __future__ import annotations

from math import pi
from typing import Literal

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.drive import TORSION, Indefinite, IndexingDrive, modes
from camgeom.dynamics.linear.method import DrivenMotion
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct

LOW, MEDIUM = 15.0, 6.0
"""divisors of the first critical speed that bound the low and the medium speed class"""
SpeedClass = Literal["low", "medium", "high"]


@immutable
class Mode:
    """One natural mode over the cam angle: block, squared frequency (n,) in (rad/s)^2 with sign, shape (n, m) per
    1/sqrt(kg).

    A negative square is a divergence, not an oscillation: it has no frequency.
    """

    block: tuple[str, ...]
    theta: Floats
    squared: Floats
    shape: Floats

    @property
    def label(self) -> str:
        """The coordinates of the block, torsion as one word."""
        return "torsion" if self.block == TORSION else " ".join(self.block)

    @property
    def oscillates(self) -> bool:
        """Whether the mode has a frequency at every cam angle."""
        return bool((self.squared > 0.0).all())

    def frequency_hz(self) -> Floats:
        """Frequency (n,) in Hz; DesignError for a divergent mode, which has none."""
        if not self.oscillates:
            lowest = float(self.squared.min())
            raise DesignError(
                f"dynamics: the mode of {self.label} diverges (lowest omega^2 {lowest:.6g}): its springs do not hold "
                "it; a smaller cross_bending, or larger turret_bending and load_bending"
            )
        return np.sqrt(self.squared) / (2.0 * pi)


@immutable
class Modes:
    """All modes over the cam angle (n,) rad, sorted by their lowest value, and the blocks that are no oscillators."""

    theta: Floats
    modes: tuple[Mode, ...]
    indefinite: tuple[Indefinite, ...]

    def torsional(self) -> tuple[Mode, ...]:
        """The three torsional modes, lowest first."""
        return tuple(mode for mode in self.modes if mode.block == TORSION)

    def lowest_hz(self) -> tuple[float, float]:
        """The lowest first torsional frequency in Hz and the cam angle in rad where it occurs."""
        frequency = self.torsional()[0].frequency_hz()
        index = int(frequency.argmin())
        return float(frequency[index]), float(self.theta[index])


def natural_modes(drive: IndexingDrive, motion: DrivenMotion, theta: npt.ArrayLike | None = None) -> Modes:
    """Modes of all blocks at cam angles theta (n,) rad, by default each degree, every knot and the steepest point."""
    angles = _angles(motion) if theta is None else np.asarray(theta, dtype=float)
    found = []
    for block in drive.blocks():
        mass = drive.matrix(drive.inertia_terms(), block)
        stiffness = drive.stiffness(angles, motion, block)
        squared, shapes = modes(mass, stiffness)
        found += [Mode(block, angles, squared[:, k], shapes[:, :, k]) for k in range(len(block))]
    found.sort(key=lambda mode: float(mode.squared.min()))
    return Modes(angles, tuple(found), drive.indefinite(motion, angles))


def _angles(motion: DrivenMotion) -> Floats:
    """Each degree, the knots, and the cam angle of the largest |tau'| (where the first frequency is lowest)."""
    degrees = np.linspace(0.0, 2.0 * pi, 361)
    base = distinct(np.concatenate([degrees, np.asarray(motion.knots)]))
    slope = np.abs(motion.jet(base, 1)[1])
    k = int(slope.argmax())
    low, high = base[max(k - 1, 0)], base[min(k + 1, len(base) - 1)]
    for _ in range(24):
        fine = np.linspace(low, high, 9)
        best = int(np.abs(motion.jet(fine, 1)[1]).argmax())
        low, high = fine[max(best - 1, 0)], fine[min(best + 1, 8)]
    return distinct(np.append(base, 0.5 * (low + high)))


@immutable(eq=True)
class CriticalSpeed:
    """Input speeds in r/min at which harmonic `order` of the turn meets a mode, from its lowest to its highest
    frequency.
    """

    label: str
    mode: int
    order: int
    lowest_rpm: float
    highest_rpm: float
    dwell_rpm: float


def critical_speeds(found: Modes, orders: int = 20) -> tuple[CriticalSpeed, ...]:
    """Critical speeds 60 f / k in r/min of every mode and harmonic k: one index a turn excites all harmonics.

    dwell_rpm belongs to the frequency at the last cam angle.
    """
    out = []
    for number, mode in enumerate((one for one in found.modes if one.oscillates), 1):
        hertz = mode.frequency_hz()
        low, high, dwell = 60.0 * float(hertz.min()), 60.0 * float(hertz.max()), 60.0 * float(hertz[-1])
        for k in range(1, orders + 1):
            out.append(CriticalSpeed(mode.label, number, k, low / k, high / k, dwell / k))
    return tuple(out)


@immutable(eq=True)
class SpeedClasses:
    """First critical speed n1 = 60 f_min and the bounds n1/15 and n1/6 of the low and the medium class, r/min."""

    first_critical_rpm: float
    low_rpm: float
    medium_rpm: float

    def of(self, speed_rpm: float) -> SpeedClass:
        """The class of an input speed in r/min."""
        if speed_rpm <= self.low_rpm:
            return "low"
        return "medium" if speed_rpm <= self.medium_rpm else "high"


def speed_classes(lowest_hz: float) -> SpeedClasses:
    """Classes of the input speed (r/min) for a lowest torsional frequency in Hz."""
    first = 60.0 * lowest_hz
    return SpeedClasses(first, first / LOW, first / MEDIUM)


@immutable
class Campbell:
    """Campbell diagram: speeds (s,) in r/min, harmonic lines (k, s) in Hz, labels of the oscillating modes."""

    speed_rpm: Floats
    harmonics: npt.NDArray[np.int_]
    lines_hz: Floats
    labels: tuple[str, ...]


def campbell(found: Modes, speed_rpm: npt.ArrayLike, orders: int = 20) -> Campbell:
    """Campbell diagram of the oscillating modes over input speeds (s,) in r/min."""
    speeds = np.atleast_1d(np.asarray(speed_rpm, dtype=float))
    harmonics = np.arange(1, orders + 1)
    labels = tuple(mode.label for mode in found.modes if mode.oscillates)
    return Campbell(speeds, harmonics, harmonics[:, None] * speeds / 60.0, labels)
