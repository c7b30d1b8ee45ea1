"""The elastic follower: one or two masses on a linkage with damping, return spring and preload, driven over the cam
angle. SI.

A force-closed or form-closed follower of moving mass m hangs on the cam through the stiffness of its linkage; a
spring of its own and its preload press it back. With a contact stiffness the tappet at the cam end is a second mass;
without, it follows the cam exactly and only adds its inertia to the contact force. An elastic cam shaft adds the
cam's windup, with the motion taken at the true cam angle.

Lifts of a program in mm are brought to metres by `scale` = 1e-3; for a swinging follower scale = 1 and masses are
inertias (kg m2), stiffnesses N m/rad and forces N m.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field, fields, replace
from types import MappingProxyType
from typing import Literal

import numpy as np

from camgeom.dynamics.linear.method import Coefficients, Correction, DrivenMotion, Side, VaryingContact
from camgeom.dynamics.linear.response import Response, positive_speeds
from camgeom.dynamics.linear.solve import acceleration
from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats

Closure = Literal["force", "form"]
Load = Callable[[Floats, Side], Floats]
"""Force (., n) in N on the follower mass against the lift over cam angles (., n); at a knot its limit from a side."""
JUMP = 1e-9
"""share of the largest velocity above which a step in velocity at a knot is a knock"""
OUTPUTS: Mapping[str, str] = MappingProxyType(
    {
        "deviation": "m, follower mass from its rigid position",
        "vibration": "m, follower mass from where the load at that cam angle would rest, in a dwell",
        "position": "m, follower mass",
        "velocity": "m/s of the follower mass",
        "acceleration": "m/s2 of the follower mass",
        "contact_force": "N between cam and follower along the motion, positive when it presses",
        "linkage_force": "N in the linkage, positive when it pushes the follower mass up",
        "cam_torque": "N m on the cam, contact force times ds/dtheta; none of a cam that slides",
        "windup": "rad, cam from its nominal angle",
        "shaft_torque": "N m in the cam shaft, positive when it drives the cam",
    }
)
"""The outputs of an elastic follower by name, with unit and meaning."""
TURNING = ("windup", "shaft_torque")
"""outputs of an elastic cam shaft"""
ORDERS: Mapping[str, int] = MappingProxyType({"position": 0, "velocity": 1, "acceleration": 2})


@immutable(eq=True, kw_only=True)
class FollowerTrain:
    """Moving masses (kg), linkage, contact and return spring (N/m), their dampings (N s/m), preload (N) at zero lift.

    mass is the mass at the far end of the linkage, tappet_mass that at the cam; contact_stiffness 0 means a rigid
    contact. slides: whether the cam does, so that no shaft turns with it.
    """

    mass: float
    stiffness: float
    damping: float = 0.0
    return_stiffness: float = 0.0
    return_damping: float = 0.0
    preload: float = 0.0
    tappet_mass: float = 0.0
    contact_stiffness: float = 0.0
    contact_damping: float = 0.0
    closure: Closure = "force"
    slides: bool = False

    def __post_init__(self) -> None:
        problems = []
        for item in fields(self):
            value = getattr(self, item.name)
            if isinstance(value, str | bool):
                continue
            if not np.isfinite(value) or value < 0.0:
                problems.append(Problem(f"dynamics.{item.name}", "must be finite and not negative", value, ">= 0"))
        for name in ("mass", "stiffness"):
            if getattr(self, name) == 0.0:
                problems.append(Problem(f"dynamics.{name}", "must be positive", 0.0, "> 0"))
        if self.contact_stiffness > 0.0 and self.tappet_mass == 0.0:
            problems.append(Problem("dynamics.tappet_mass", "an elastic contact needs a tappet mass", 0.0, "> 0"))
        if problems:
            raise ProfileError(problems)

    @property
    def two_masses(self) -> bool:
        """Whether the tappet is a mass of its own on an elastic contact."""
        return self.contact_stiffness > 0.0

    @property
    def first(self) -> tuple[float, float]:
        """Stiffness and damping of the spring at the cam: the contact, or the linkage where the contact is rigid."""
        return (self.contact_stiffness, self.contact_damping) if self.two_masses else (self.stiffness, self.damping)

    def natural_frequency(self) -> Floats:
        """Undamped natural frequencies in rad/s, ascending, of the follower on a fixed cam."""
        if not self.two_masses:
            return np.array([np.sqrt((self.stiffness + self.return_stiffness) / self.mass)])
        k = np.array([[self.contact_stiffness + self.stiffness, -self.stiffness], [-self.stiffness, self.stiffness]])
        k[1, 1] += self.return_stiffness
        scale = 1.0 / np.sqrt([self.tappet_mass, self.mass])
        return np.asarray(np.sqrt(np.linalg.eigvalsh(k * scale[:, None] * scale)))


@immutable(eq=True, kw_only=True)
class CamShaft:
    """Elastic cam shaft: cam inertia kg m2, torsional stiffness N m/rad, damping N m s/rad."""

    inertia: float
    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        if not (self.inertia > 0.0 and self.stiffness > 0.0 and self.damping >= 0.0):
            text = "needs positive inertia and stiffness and no negative damping"
            raise ProfileError([Problem("dynamics.shaft", text, (self.inertia, self.stiffness, self.damping))])


@immutable
class FollowerSystem:
    """Equation of motion at speeds (b,) in rad/s; coordinates are deviations from the rigid motion.

    Order: windup of the cam (rad, with a shaft), tappet (m, with two masses), follower mass (m). In flight the spring
    at the cam carries nothing (see `flight`); the cam shaft is rigid there.
    """

    train: FollowerTrain
    motion: DrivenMotion
    speed: Floats
    scale: float = 1e-3
    shaft: CamShaft | None = None
    load: Load | None = None
    flight: bool = False
    mass: Floats = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "speed", positive_speeds(self.speed))
        t = self.train
        masses = ([self.shaft.inertia] if self.shaft else []) + ([t.tappet_mass] if t.two_masses else []) + [t.mass]
        object.__setattr__(self, "mass", np.array(masses))
        assert not (self.flight and self.shaft)
        if self.shaft and t.tappet_mass > 0.0 and not t.two_masses:
            text = "with an elastic shaft the tappet needs a contact stiffness"
            raise ProfileError([Problem("dynamics.contact_stiffness", text, 0.0, "> 0")])
        _refuse_knocks(self.motion)

    @property
    def size(self) -> int:
        """Number of coordinates, 1 to 3."""
        return len(self.mass)

    @property
    def batch(self) -> int:
        """Number of speeds."""
        return len(self.speed)

    @property
    def knots(self) -> Floats:
        """Cam angles in rad at which some derivative of the motion jumps."""
        return np.asarray(self.motion.knots)

    @property
    def outputs(self) -> Mapping[str, str]:
        """`OUTPUTS`; without an elastic shaft those of the shaft are missing, of a cam that slides its torque too."""
        missing = (() if self.shaft is not None else TURNING) + (("cam_torque",) if self.train.slides else ())
        return {name: meaning for name, meaning in OUTPUTS.items() if name not in missing}

    @property
    def judged(self) -> str:
        """The force that decides whether the follower stays on its cam."""
        return "contact_force"

    def read(self, name: str, theta: Floats, position: Floats, rate: Floats, side: Side = "right") -> Floats:
        """An output (b, n) of `OUTPUTS` from q and q' (b, n, m) at cam angles theta (1 or b, n)."""
        q, u = position, rate
        if name == "deviation":
            return q[..., -1]
        if name == "vibration":
            here = self.coefficients(theta, side)
            return np.asarray(q[..., -1] - np.linalg.solve(here.stiffness, here.force[..., None])[..., -1, 0])
        if name in ORDERS:
            order = ORDERS[name]
            own = (q, u)[order] if order < 2 else acceleration(self, theta, q, u, side)
            return np.asarray((self.lift(theta, order, side)[order] + own[..., -1]) * self.speed[:, None] ** order)
        if name in ("contact_force", "cam_torque"):
            force, slope = self.contact(theta, q, u, side)
            return force if name == "contact_force" else force * slope
        if name == "linkage_force":
            return self._linkage(theta, q, u, side)
        if name == "windup" or self.shaft is None:
            return q[..., 0]
        return np.asarray(-self.shaft.stiffness * q[..., 0] - self.shaft.damping * self.speed[:, None] * u[..., 0])

    def _linkage(self, theta: Floats, q: Floats, u: Floats, side: Side) -> Floats:
        """Force (b, n) in N in the linkage."""
        t, w = self.train, self.speed[:, None]
        if t.two_masses:
            return np.asarray(t.stiffness * (q[..., -2] - q[..., -1]) + t.damping * w * (u[..., -2] - u[..., -1]))
        if self.shaft is None:
            return np.asarray(-t.stiffness * q[..., 0] - t.damping * w * u[..., 0])
        return self.contact(theta, q, u, side)[0]

    def rest(self) -> Floats:
        """State (b, 2m) of the follower standing still at the first cam angle under preload, spring and load."""
        here = replace(self, speed=np.array([1e-9])).coefficients(self.knots[None, :1])
        still = np.linalg.solve(here.stiffness[:, 0], here.force[:, 0, :, None])[..., 0]
        return np.broadcast_to(np.concatenate([still, np.zeros_like(still)], -1), (self.batch, 2 * self.size)).copy()

    @property
    def linear(self) -> bool:
        """Whether the motion is taken at the nominal cam angle (no elastic shaft)."""
        return self.shaft is None

    def lift(self, theta: Floats, order: int, side: Side = "right") -> Floats:
        """Lift in m and its derivatives per rad (order + 1, ., n) at cam angles theta (., n)."""
        return self.scale * self.motion.jet(theta.ravel(), order, side).reshape(order + 1, *theta.shape)

    def rigid_force(self, theta: Floats, s: Floats, side: Side = "right") -> Floats:
        """Force (b, n) in N that the rigid follower mass needs from the linkage; s: lift and its derivatives there."""
        t, w = self.train, self.speed[:, None]
        force = t.mass * s[2] * w * w + t.return_damping * s[1] * w + t.return_stiffness * s[0] + t.preload
        return np.asarray(force + (self.load(theta, side) if self.load is not None else 0.0))

    def coefficients(self, theta: Floats, side: Side = "right") -> Coefficients:
        """D, S, F per rad of cam angle at cam angles theta (1 or b, n)."""
        w, s = self.speed[:, None], self.lift(theta, 2, side)
        rigid = self.rigid_force(theta, s, side)
        stiffness, damping = self._springs()
        force = np.zeros((self.batch, theta.shape[1], self.size))
        force[..., -1] = -rigid
        if self.train.two_masses:
            force[..., -2] = -self.train.tappet_mass * s[2] * w * w
        inverse, rate = 1.0 / self.mass, w[..., None]
        fixed = stiffness * inverse[:, None] / rate[..., None] ** 2
        contact = None
        if self.shaft is not None:
            # the torque of the rigid force turns with the windup
            turned = np.zeros((self.batch, theta.shape[1], self.size, self.size))
            turned[..., 0, 0] = rigid * s[2] * inverse[0] / w**2
            fixed, contact = fixed + turned, VaryingContact.on_cam(s[1], s[2], *self.train.first, w, self.mass)
        return Coefficients(damping * inverse[:, None] / rate[..., None], fixed, force * inverse / rate**2, contact)

    def _springs(self) -> tuple[Floats, Floats]:
        """Stiffness and damping (m, m) of the springs that do not vary over the cam angle."""
        t, m = self.train, self.size
        stiffness, damping = np.zeros((m, m)), np.zeros((m, m))
        if self.shaft is not None:
            stiffness[0, 0], damping[0, 0] = self.shaft.stiffness, self.shaft.damping
        elif not self.flight:
            stiffness[0, 0], damping[0, 0] = t.first
        if t.two_masses:
            pair = np.zeros(m)
            pair[-2:] = -1.0, 1.0
            stiffness += t.stiffness * np.outer(pair, pair)
            damping += t.damping * np.outer(pair, pair)
        stiffness[-1, -1] += t.return_stiffness
        damping[-1, -1] += t.return_damping
        return stiffness, damping

    def contact(self, theta: Floats, q: Floats, u: Floats, side: Side = "right") -> tuple[Floats, Floats]:
        """Contact force (b, n) in N, positive when it presses, and ds/dtheta (m/rad) at the cam's true angle."""
        t, w = self.train, self.speed[:, None]
        k, c = t.first
        if self.shaft is None:
            s = self.lift(theta, 2, side)
            carried = 0.0 if t.two_masses else t.tappet_mass * s[2] * w * w
            return np.asarray(carried - k * q[..., 0] - c * w * u[..., 0]), s[1]
        return self._pressed(theta, self.lift(theta, 1, side), q, u, side)

    def _pressed(self, theta: Floats, s: Floats, q: Floats, u: Floats, side: Side) -> tuple[Floats, Floats]:
        """The same on an elastic shaft; s: lift and its derivative at the nominal cam angle."""
        k, c = self.train.first
        true = self.lift(theta + q[..., 0], 1, side)
        squeeze = true[0] - s[0] - q[..., 1]
        rate = self.speed[:, None] * (true[1] * (1.0 + u[..., 0]) - s[1] - u[..., 1])
        return np.asarray(k * squeeze + c * rate), true[1]

    def correction(self, theta: Floats, side: Side = "right") -> Correction:
        """Exact less linear q'' (b, n, m) per rad^2: the cam profile at the true cam angle."""
        if self.shaft is None:
            return lambda q, u: np.zeros_like(q)
        k, c = self.train.first
        w, s = self.speed[:, None], self.lift(theta, 2, side)
        turned = self.rigid_force(theta, s, side) * s[2]

        def of(q: Floats, u: Floats) -> Floats:
            straight = k * (s[1] * q[..., 0] - q[..., 1])
            straight = straight + c * w * (s[1] * u[..., 0] + s[2] * q[..., 0] - u[..., 1])
            force, slope = self._pressed(theta, s, q, u, side)
            out = np.zeros_like(q)
            out[..., 0] = (s[1] * straight + turned * q[..., 0] - slope * force) / (self.mass[0] * w * w)
            out[..., 1] = (force - straight) / (self.mass[1] * w * w)
            return out

        return of


FollowerResponse = Response[FollowerSystem]


def _refuse_knocks(motion: DrivenMotion) -> None:
    """DesignError when the velocity jumps at a knot: an elastic follower would be hit by an infinite force."""
    knots = np.asarray(motion.knots, dtype=float)
    left, right = motion.jet(knots, 1, "left")[1], motion.jet(knots, 1, "right")[1]
    step = np.abs(right - left)
    # Between dwells every velocity at a knot is rounding: the scale is that of the velocities on the way.
    inside = motion.jet(np.linspace(knots[0], knots[-1], 721), 1)[1]
    if float(step.max()) > JUMP * max(float(np.abs(part).max()) for part in (left, right, inside)):
        angle = float(np.degrees(knots[int(step.argmax())]))
        raise DesignError(
            f"motion: the velocity jumps at {angle:.6g} degrees: the response needs a continuous velocity; use a law "
            "such as cycloidal, modified-sine or 3-4-5"
        )
