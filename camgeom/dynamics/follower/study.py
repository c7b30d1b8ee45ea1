"""One call for the vibration of an elastic follower: steady state, jump, preload, windup, as frozen facts."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, pi

import numpy as np

from camgeom.dynamics.follower.polydyne import PolydyneMotion, polydyne_motion
from camgeom.dynamics.follower.response import Flight, SteadyContact, flight, from_rest, jump, steady_state
from camgeom.dynamics.follower.train import CamShaft, Closure, FollowerResponse, FollowerSystem, FollowerTrain, Load
from camgeom.dynamics.indexing.measures import Residual, Settles, residual_vibration
from camgeom.dynamics.linear.accuracy import STANDARD, Accuracy
from camgeom.dynamics.linear.budget import sought
from camgeom.dynamics.linear.method import DrivenMotion
from camgeom.dynamics.linear.response import Sweep, swept
from camgeom.dynamics.spec import DynamicsSpec
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program

RPM = pi / 30.0
SETTLED = 0.01
"""share of the stroke within which a follower counts as settled where the profile gives no band"""
BESIDE = (
    "frequencies_hz", "peak_acceleration_m_s2", "peak_acceleration_rad_s2", "peak_contact_force_n",
    "peak_contact_force_n_m", "least_contact_force_n", "least_contact_force_n_m",
)  # fmt: skip
"""figures of a follower on a rigid body that stand beside those on one that yields"""
STATIONS = 721
"""cam angles at which the stroke is looked for"""


@immutable
class FollowerStudy(Settles):
    """The vibration of an elastic follower at a cam speed in rad/s; scale is metres per unit of lift (1 for angles).

    band, m (rad): within it of where its load would rest, the follower counts as settled in a dwell. rigid: the same
    follower on a cam whose body is rigid below its contact, where this one's is not; body: that body's compliance, mm/N
    (rad/(N m)), and the cam angle, rad, at which it is that soft.
    """

    train: FollowerTrain
    motion: DrivenMotion
    speed: float
    scale: float = 1e-3
    accuracy: Accuracy = STANDARD
    shaft: CamShaft | None = None
    load: Load | None = None
    sweep_speeds: Floats | None = None
    polydyne: bool = False
    band: float = 1e-4
    rigid: FollowerStudy | None = None
    body: tuple[float, float] = (0.0, 0.0)

    @sought
    def steady(self) -> FollowerResponse:
        """Periodic steady state, contact held."""
        return steady_state(self.train, self.motion, self.speed, self.accuracy, self.scale, self.shaft, self.load)

    @sought
    def start(self) -> FollowerResponse:
        """First turn from static equilibrium."""
        return from_rest(self.train, self.motion, self.speed, 1, self.accuracy, self.scale, self.shaft, self.load)

    @sought
    def sweep(self) -> Sweep:
        """Steady states over the sweep; ProfileError when no sweep was asked for."""
        if self.sweep_speeds is None:
            raise ProfileError([Problem("dynamics.sweep", "is missing", None, "two speeds in r/min")])

        return self.over(self.sweep_speeds)

    def over(self, speeds: Floats, steps: int | None = None) -> Sweep:
        """Steady states at speeds (s,) in rad/s, in a number of steps a turn where one is given."""
        accuracy = self.accuracy if steps is None else replace(self.accuracy, steps=steps)

        def at(part: Floats) -> FollowerSystem:
            return FollowerSystem(self.train, self.motion, part, self.scale, self.shaft, self.load)

        return swept(at, speeds, accuracy, ("acceleration", "contact_force"))

    @cached_property
    def jump(self) -> SteadyContact | None:
        """Loss of contact; None for a form-closed follower, which cannot leave its groove."""
        return jump(self.steady) if self.train.closure == "force" else None

    @cached_property
    def residual(self) -> Residual:
        """Vibration left in the hardest dwell of the steady state, m (rad). Raises ProfileError where there is none."""
        return residual_vibration(self.steady, self.band, "vibration", "acceleration")

    @property
    def half_swing(self) -> float:
        """Half a period of the lowest mode, s: what a vibration needs to show its size."""
        return pi / float(self.train.natural_frequency()[0])

    @sought
    def flight(self) -> Flight:
        """Motion with loss of contact over three turns."""
        return flight(self.train, self.motion, self.speed, 3, self.scale, self.load)

    @cached_property
    def corrected(self) -> PolydyneMotion:
        """The cam motion for which the follower mass does the wanted one at this speed (polydyne).

        Raises ProfileError for a motion that is not smooth enough, and for damping in linkage or contact.
        """
        if not isinstance(self.motion, Program):
            raise ProfileError([Problem("motion", "only a motion program knows how smooth it is")])
        return polydyne_motion(self.motion, self.motion.continuity.order, self.train, self.speed)

    @sought
    def corrected_start(self) -> FollowerResponse:
        """First turn on the corrected cam from static equilibrium."""
        return from_rest(self.train, self.corrected, self.speed, 1, self.accuracy, self.scale, self.shaft, self.load)

    def _miss(self, response: FollowerResponse) -> float:
        """How far the follower mass strays from the wanted motion, a share of its stroke."""
        wanted = self.motion.jet(response.theta, 0)[0] * self.scale
        gap = response.output("position")[0] - wanted
        return float(np.ptp(gap) / np.ptp(wanted))

    def _polydyne_figures(self, length: str) -> dict[str, object]:
        """Both cams against the wanted motion."""
        lift = self.corrected.jet(self.corrected_start.theta, 0)[0] * self.scale
        return {
            "polydyne": {
                "coefficients": list(self.corrected.coefficients),
                f"cam_stroke_{length}": float(np.ptp(lift)),
                "follower_miss": self._miss(self.corrected_start),
                "follower_miss_uncorrected": self._miss(self.start),
            }
        }

    def summary(self, rotating: bool = False) -> dict[str, object]:
        """The figures of the follower for a result file, units in the names (rad, N m for a rotating follower)."""
        steady = self.steady
        length, force = ("rad", "n_m") if rotating else ("m", "n")
        acceleration, contact = steady.peak("acceleration"), steady.peak("contact_force")
        out: dict[str, object] = {
            "model": "elastic follower, two masses" if self.train.two_masses else "elastic follower, one mass",
            "frequencies_hz": [float(w) / (2.0 * pi) for w in self.train.natural_frequency()],
            f"peak_acceleration_{length}_s2": float(acceleration.magnitude[0]),
            f"peak_deviation_{length}": float(steady.peak("deviation").magnitude[0]),
            f"peak_contact_force_{force}": float(contact.magnitude[0]),
            f"least_contact_force_{force}": float(contact.minimum[0]),
            "least_contact_force_cam_angle_deg": degrees(float(contact.minimum_at[0])),
            **({} if self.train.slides else {"peak_cam_torque_n_m": float(steady.peak("cam_torque").magnitude[0])}),
            "spectral_radius": float(steady.solution.spectral_radius[0]),
            **steady.certainty(),
        }
        if self.jump is not None:
            out["contact_lost"] = bool(self.jump.lost[0])
            out[f"required_preload_{force}"] = float(self.jump.required_preload[0])
        if self.dwells:
            out[f"residual_vibration_{length}"] = float(self.residual.deviation[0])
            out["settling_time_s"] = self.settling_time
        if self.shaft is not None:
            out["peak_windup_deg"] = degrees(float(steady.peak("windup").magnitude[0]))
            out["peak_shaft_torque_n_m"] = float(steady.peak("shaft_torque").magnitude[0])
        if self.polydyne:
            out |= self._polydyne_figures(length)
        if self.sweep_speeds is not None:
            out["sweep"] = self._sweep_figures(length, force)
        if self.rigid is not None:
            soft, angle = self.body
            # Of a body as stiff as the contact's half-space, or stiffer, nothing is left to yield.
            out["body_stiffness_n_m_rad" if rotating else "body_stiffness_n_mm"] = 1.0 / soft if soft > 0.0 else None
            out["body_softest_at_deg"] = degrees(angle)
            beside = self.rigid.summary(rotating)
            out["rigid_body"] = {key: beside[key] for key in BESIDE if key in beside}
        return out

    def _sweep_figures(self, length: str, force: str) -> dict[str, object]:
        """Lists over the speeds of the sweep."""
        acceleration, contact = self.sweep.peaks["acceleration"], self.sweep.peaks["contact_force"]
        columns = {
            f"peak_acceleration_{length}_s2": acceleration.magnitude,
            f"least_contact_force_{force}": contact.minimum,
            f"peak_contact_force_{force}": contact.magnitude,
        }
        return self.sweep.figures(columns)


def follower_study(
    spec: DynamicsSpec,
    motion: DrivenMotion,
    speed_rpm: float,
    rotating: bool = False,
    closure: Closure = "force",
    mass: float = 0.0,
    return_stiffness: float = 0.0,
    preload: float = 0.0,
    load: Load | None = None,
    slides: bool = False,
) -> FollowerStudy:
    """The study a profile's [dynamics] table asks for, at the cam speed in r/min.

    mass (kg or kg m2), return_stiffness (N/m or N m/rad) and preload (N or N m) serve where the table gives none;
    lifts are mm, or rad for a rotating follower. slides: whether the cam does, on a drive of that many turns.
    """
    train = replace(spec.train(rotating, closure, mass, return_stiffness, preload), slides=slides)
    scale = 1.0 if rotating else 1e-3
    speed, accuracy = speed_rpm * RPM, spec.accuracy()
    if "settling_band" in spec.model_fields_set:
        band = np.radians(spec.settling_band) if rotating else scale * spec.settling_band
    else:
        stations = np.concatenate([np.asarray(motion.knots), np.linspace(motion.knots[0], motion.knots[-1], STATIONS)])
        band = SETTLED * scale * np.ptp(motion.jet(stations, 0)[0])
    return FollowerStudy(
        train, motion, speed, scale, accuracy, spec.shaft(), load, spec.speeds(), spec.polydyne, float(band)
    )
