"""Duty: who presses the cam over one turn, how hard, and for how long it lasts.

Three carriers fulfil it: one roller (`roller_duty`), faces and whatever else touches a planar cam (`face_duty`), and
the rollers of a turret that share its torque (`turret_duty`). Here is what they have in common, and the one way in
which it becomes plain data.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from math import degrees, inf, isfinite, pi
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import Panels, highest
from camgeom.mechanics.hertz import Beneath
from camgeom.mechanics.load import FollowerForce

if TYPE_CHECKING:
    from camgeom.mechanics.bearing import BearingLife
    from camgeom.mechanics.contact import Stiffness
    from camgeom.mechanics.film import Film, Oil
    from camgeom.mechanics.finite_contact import PressurePatch
    from camgeom.mechanics.finite_turn import FiniteTurn
    from camgeom.mechanics.finite_turret import FiniteTurret
    from camgeom.mechanics.kept import Kept
    from camgeom.mechanics.rating import Rating

MILLI = 1e-3
TILT = "{}.misalignment_deg"
"""key of a roller's tilt, by its table"""
PLACES = 7200
"""of the cam at which the damage by several contacts is summed: twentieths of a degree"""
MEAN_OF_NOTHING = 1e-12
"""share of the largest torque below which a mean over the turn is the rounding of its sum"""


def free() -> None:
    """No price."""


class Duty(ABC):
    """One contact, or several that carry together, under load over one turn; arrays on the panels (p, n) of `force`.

    A carrier answers what differs; where it has nothing to say the answers are those of here.
    """

    @property
    @abstractmethod
    def force(self) -> FollowerForce:
        """Motion of the follower and the force, N, or torque, N mm, that it needs."""

    @property
    @abstractmethod
    def contact_forces(self) -> Floats:
        """Normal force of every contact, N, (k, p, n), zero where it does not carry."""

    @property
    @abstractmethod
    def torque(self) -> Floats:
        """Torque that the cam takes from its shaft, N mm, (p, n)."""

    @cached_property
    def peak_force(self) -> Extreme:
        """Largest normal force of a contact, N."""
        return peak_of(self.force.panels, self.contact_forces.max(axis=0))

    @cached_property
    def peak_torque(self) -> Extreme:
        """Largest torque that the cam takes from its shaft or gives it, N mm, as a magnitude."""
        return largest_of(self.force.panels, self.torque)

    @property
    def peak_pressure(self) -> Extreme | None:
        """Largest contact pressure, MPa, at its place along the roller; None where there is none (`no_stress`)."""
        return None if self.no_stress else self.least_peak

    @property
    @abstractmethod
    def no_stress(self) -> str:
        """Why there is no largest pressure, and what to give so that there is: a knife edge, a sharp end that bears."""

    @property
    def squared(self) -> tuple[str, Duty] | None:
        """Which key tilts its roller, and the duty of one that stands square to its flank; None where it does."""
        return None

    @property
    def square_spot(self) -> float | None:
        """Pressure, MPa, where it is hardest, were rollers square to their flanks; None where no tilt is solved."""
        return None

    @property
    @abstractmethod
    def least_peak(self) -> Extreme | None:
        """A pressure, MPa, that is surely exceeded where none is the largest; None where nothing is known."""

    @property
    @abstractmethod
    def peak_contact(self) -> Beneath | None:
        """Half-width and subsurface shear of that contact; None where no stress can be given."""

    @property
    @abstractmethod
    def deepest_shear(self) -> Extreme | None:
        """Largest depth, mm, over the turn and along the contact, of the largest shear below it; None likewise."""

    @property
    def finite(self) -> FiniteTurn | FiniteTurret | None:
        """The contact on a half-space over the turn; None where it is rated as a line or an ellipse."""
        return None

    @property
    def least_shear(self) -> Extreme | None:
        """A depth, mm, that the largest shear surely reaches: the deepest, or as of a line below `least_peak`."""
        peak = self.least_peak
        if self.deepest_shear is not None or self.finite is None or peak is None:
            return self.deepest_shear
        return replace(peak, value=self.finite.hardest[1].bodies.line_depth(peak.value))

    @property
    def unheld(self) -> Extreme | None:
        """Largest force, N (N mm), that presses where no wall is; None where a wall is all round."""
        return None

    @abstractmethod
    def spot(self, at: Extreme) -> str:
        """A place on what presses the cam, in words: which contact, where along a roller, how much of it touches."""

    @cached_property
    def work(self) -> float:
        """Work of the cam over a turn, N mm: what all friction and applied forces consume."""
        return float(self.force.panels.integral(self.torque))

    @property
    def kept(self) -> Kept | None:
        """What keeps the follower on a cam that pushes one way; None where both directions are driven."""
        return None

    @property
    @abstractmethod
    def lives(self) -> Mapping[str, float]:
        """Fatigue life, h, at the hardest place of each body that has one.

        "roller" or "face", "cam", and the roller's "bearing" where it is rated.
        """

    @property
    def meeting(self) -> Meeting | None:
        """How its contact comes to places of the cam that another's comes to; None where it has a wall of its own."""
        return None

    @property
    def rating(self) -> Rating | None:
        """What is known of the bearing of its roller; None without a dynamic rating."""
        return None

    @property
    def bearing(self) -> BearingLife | None:
        """Life of the hardest used roller's bearing; None without a rating."""
        return None

    @abstractmethod
    def film(self, oil: Oil) -> Film | None:
        """The film in the hardest contact and slice of every cam angle; None of a knife edge and without any load."""

    @property
    @abstractmethod
    def rubbed(self) -> float:
        """Load times sliding way of all contacts over a turn, N mm; times a coefficient of friction their heat."""

    @property
    @abstractmethod
    def rubbing(self) -> Mapping[str, float]:
        """Load per width, times sliding way over the way that a point is passed on, N/mm, summed over a turn at the
        hardest rubbed place of "roller" or "face" and "cam": times a wear rate, mm³/(N mm), its depth, mm."""

    @abstractmethod
    def contact_data(self) -> dict[str, Any]:
        """Force, pressure and torque as plain data for result.json."""

    @abstractmethod
    def fatigue_data(self) -> dict[str, Any]:
        """Fatigue lives of the surfaces as plain data for result.json."""


@final
@immutable
class Meeting:
    """A contact on a wall of the cam that several contacts pass.

    lag     cam angle, rad, after which it comes to a place that the first of them met
    damage  of a place that it meets at cam angles (n,), rad: damage, 1, in an hour, (n,)
    """

    lag: float
    damage: Callable[[Floats], Floats]


def least_lives(duties: Iterable[Duty]) -> dict[str, float]:
    """Fatigue life, h, of every body: the least of all duties; of a place of the cam that several meet by their sum."""
    found: dict[str, float] = {}
    met = []
    for duty in duties:
        for body, hours in duty.lives.items():
            found[body] = min(hours, found.get(body, hours))
        if duty.meeting is not None:
            met.append(duty.meeting)
    if len(met) > 1 and found.get("cam"):
        turn = np.linspace(0.0, 2.0 * pi, PLACES, endpoint=False)
        damage = float(np.sum([one.damage(turn + one.lag) for one in met], axis=0).max())
        found["cam"] = min(found["cam"], 1.0 / damage if damage > 0.0 else inf)
    return found


def least_safety(duties: Iterable[Duty]) -> float | None:
    """Least static safety of the rollers' bearings of some duties; None where no static rating is known."""
    bearings = [duty.bearing for duty in duties if duty.bearing is not None]
    return min((float(one.static_safety) for one in bearings if one.static_safety is not None), default=None)


def peak_of(where: Panels, values: Floats) -> Extreme:
    """Largest value of a quantity (p, n) on panels."""
    value, angle = highest(where, values)
    return Extreme(float(value), float(angle))


def largest_of(where: Panels, values: Floats) -> Extreme:
    """Largest magnitude of a quantity (p, n) on panels."""
    return max(peak_of(where, values), peak_of(where, -values), key=lambda peak: peak.value)


def slice_shares(count: int) -> Floats:
    """What each of so many slices and their ends stands for, as a share of a slice: exact of straight lines with a kink
    at a slice's middle, (m + 2,)."""
    return np.array([0.25, 0.75, *[1.0] * (count - 2), 0.75, 0.25])


def finite(value: ArrayLike) -> float | None:
    """A number for JSON; null where there is no end (an unloaded contact lives for ever)."""
    number = float(value)  # type: ignore[arg-type]
    return number if isfinite(number) else None


def torque_data(peak: Extreme, work: float) -> dict[str, Any]:
    """Torque of the camshaft, and its mean from the work of a turn, N mm; 0 where that is rounding of the largest."""
    mean = work / (2.0 * pi)
    if abs(mean) < MEAN_OF_NOTHING * abs(peak.value):
        mean = 0.0
    return {
        "peak_torque_n_m": peak.value * MILLI,
        "peak_torque_at_deg": degrees(peak.cam_angle),
        "mean_torque_n_m": mean * MILLI,
    }


def slice_data(peak: Extreme) -> dict[str, Any]:
    """The hardest pressed slice along a roller."""
    return {
        "peak_slice_pressure_mpa": finite(peak.value),
        "peak_slice_delta_mm": peak.place,
        "peak_slice_cam_angle_deg": degrees(peak.cam_angle),
    }


def inside_data(inside: Extreme) -> dict[str, Any]:
    """The pressure half a millimetre inside of a sharp end that bears."""
    return {
        "inside_pressure_mpa": inside.value,
        "inside_delta_mm": inside.place,
        "cam_angle_deg": degrees(inside.cam_angle),
    }


def patch_data(patch: PressurePatch, stiff: Stiffness, middle: float) -> dict[str, Any]:
    """Of a contact on a half-space: where its load acts (delta; `middle` is y = 0), error of its peak, approach,
    stiffness."""
    return {
        "load_centre_mm": middle + patch.centre,
        "peak_pressure_error": patch.error,
        "approach_mm": patch.approach,
        "tangent_stiffness_n_mm": stiff.tangent,
        "secant_stiffness_n_mm": stiff.secant,
    }


def length_data(length: float, least: Extreme) -> dict[str, Any]:
    """Length that touches at the largest pressure, and the least under load over the turn, mm."""
    return {
        "contact_length_mm": length,
        "least_contact_length_mm": least.value,
        "least_contact_length_at_deg": degrees(least.cam_angle) % 360.0,
    }


def hertz_data(hardest: Beneath | None, deepest: Extreme | None) -> dict[str, Any]:
    """Width and subsurface shear of the hardest contact, and where that shear lies deepest over the turn.

    Nothing where no stress can be given.
    """
    if hardest is None or deepest is None:
        return {}
    return {
        "half_width_mm": finite(hardest.half_width),
        "peak_shear_mpa": finite(hardest.shear),
        "shear_depth_mm": finite(hardest.shear_depth),
        "deepest_shear_mm": finite(deepest.value),
        "deepest_shear_at_deg": degrees(deepest.cam_angle) % 360.0,
    }


def bearing_data(bearing: BearingLife | None) -> dict[str, Any]:
    """Life of the roller's bearing; empty where it has no rating."""
    if bearing is None:
        return {}
    data: dict[str, Any] = {"bearing_life_h": finite(bearing.life_h), "bearing_mean_load_n": float(bearing.mean_load)}
    data["bearing_speed_rpm"] = float(bearing.speed) * 30.0 / pi
    if bearing.rated_h is not None:
        data["bearing_rated_life_h"] = finite(bearing.rated_h)
    if bearing.ratio is not None and bearing.factor is not None:
        data |= {"bearing_viscosity_ratio": float(bearing.ratio), "bearing_life_factor": float(bearing.factor)}
    return data if bearing.static_safety is None else data | {"bearing_static_safety": finite(bearing.static_safety)}
