"""What the drive of a cam that slides gives along its travel: the follower's share, and what the plate itself takes.

The groove asks F ds/dx of the slide, F the force along the follower's motion and ds/dx its lift per travel; plate and
slide of mass m ask m a besides, which is largest where the plate turns round and the groove may ask nothing.
"""

from __future__ import annotations

from math import degrees
from typing import Any, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.duty import largest_of
from camgeom.mechanics.load import MILLI
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.track import TURN
from camgeom.track.carriage import Carriage

WATT = 1e-3
"""W in N mm/s"""


@final
@immutable
class SlideDrive:
    """The drive of a plate under a roller's duty.

    mass  kg, of plate and slide; None where it is not known, and then only the follower's share is
    Arrays are (p, n) on the duty's panels; forces N, positive the way the plate goes out.
    """

    duty: RollerDuty
    carriage: Carriage
    mass: float | None

    def _plate(self, order: int) -> Floats:
        """Derivatives of the plate's place by the drive's angle, mm/rad^order."""
        theta = self.duty.force.panels.theta
        jet = self.carriage.drive.jet(theta.ravel(), order)[order].reshape(theta.shape)
        return np.asarray(jet * (self.carriage.stroke / TURN))

    @cached_property
    def groove(self) -> Floats:
        """Force that moves the follower."""
        theta = self.duty.force.panels.theta
        slope = self.carriage.lift(self.carriage.travel(theta.ravel()), 1)[1].reshape(theta.shape)
        return np.asarray(self.duty.pressing.pushed * slope)

    @cached_property
    def force(self) -> Floats:
        """Force of the drive; without a mass that on the groove alone."""
        inertia = 0.0 if self.mass is None else MILLI * self.mass * self.duty.speed**2 * self._plate(2)
        return self.groove + inertia

    @cached_property
    def peak_groove(self) -> Extreme:
        """Largest force that moves the follower, N, as a magnitude."""
        return largest_of(self.duty.force.panels, self.groove)

    @cached_property
    def peak_across(self) -> Extreme:
        """Largest force of the roller on the plate square to its travel, N: what presses the plate on its slide."""
        across = np.sqrt(np.maximum(self.duty.normal**2 - self.groove**2, 0.0))
        return largest_of(self.duty.force.panels, across)

    @cached_property
    def peak(self) -> Extreme:
        """Largest force of the drive, N, as a magnitude."""
        return largest_of(self.duty.force.panels, self.force)

    @cached_property
    def peak_power(self) -> Extreme:
        """Largest power of the drive, N mm/s, as a magnitude."""
        return largest_of(self.duty.force.panels, self.force * self._plate(1) * self.duty.speed)

    def data(self) -> dict[str, Any]:
        """Forces and power as plain data; those of the whole drive where the moving mass is known."""
        found = {
            "peak_travel_force_n": self.peak_groove.value,
            "peak_travel_force_at_deg": degrees(self.peak_groove.cam_angle),
            "mean_drive_power_w": WATT * self.duty.work / TURN * self.duty.speed,
        }
        if self.mass is None:
            return found
        return found | {
            "peak_drive_force_n": self.peak.value,
            "peak_drive_force_at_deg": degrees(self.peak.cam_angle),
            "peak_drive_power_w": WATT * self.peak_power.value,
        }
