"""What is judged from a response: energy balance of the periodic state, residual vibration in the dwell, settling
time.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing.system import DriveResponse, TorsionSystem
from camgeom.dynamics.linear.peaks import peak, sampled
from camgeom.dynamics.linear.response import output
from camgeom.dynamics.linear.solve import INSIDE, Solution, advance
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import TURN, Floats, gauss_rule
from camgeom.maths.frozen import cached_property

if TYPE_CHECKING:
    from camgeom.dynamics.follower.train import FollowerResponse

QUADRATURE = 5
"""Gauss points a step for the mean powers"""


@immutable
class EnergyBalance:
    """Mean powers (b,) in W over a turn: input, dissipated, and what the contact's model adds; error is a share.

    The linearised contact stores no consistent energy: its mean power is T12 tau'' omega q1; with the exact contact
    it is zero. Nor does one whose stiffness varies over the cam angle: varying, K12' omega/2 times its stretch squared.
    external is the power of an applied torque.
    """

    input: Floats
    dissipated: Floats
    linearisation: Floats
    varying: Floats
    external: Floats
    kinetic: Floats

    @cached_property
    def error(self) -> Floats:
        """Unbalanced share (b,) of the largest of the mean powers."""
        parts = [self.input, -self.dissipated, self.linearisation, self.varying, self.external, -self.kinetic]
        scale = np.max(np.abs(parts), axis=0)
        return np.asarray(np.abs(np.sum(parts, axis=0)) / np.where(scale > 0.0, scale, 1.0))


def energy_balance(response: DriveResponse) -> EnergyBalance:
    """Mean powers over the last turn of a response, by Gauss quadrature of true partial steps.

    kinetic is the energy gained over the turn divided by its time: zero for a steady state.
    """
    system, solution = response.system, response.solution
    d = system.drive
    count = solution.grid.steps
    begin, step = solution.theta[-count - 1 : -1], np.diff(solution.theta[-count - 1 :])
    roots, weights = gauss_rule(QUADRATURE)
    share = (roots + 1.0) / 2.0
    theta = (begin[:, None] + step[:, None] * share).ravel()[None]
    weight = (step[:, None] * weights / 2.0).ravel()
    state = np.concatenate([solution.position, solution.rate], -1)[:, -count - 1 : -1]
    y = advance(
        system,
        np.repeat(begin, QUADRATURE)[None],
        theta - np.repeat(begin, QUADRATURE),
        np.repeat(state, QUADRATURE, 1),
    )
    q, u = y[..., :3], y[..., 3:]
    omega, _ = system.rates(theta)
    tau = system.jet(theta, 2)
    # mean over time: dt = dtheta/omega
    total = (weight / omega).sum(-1)

    def mean(power: Floats) -> Floats:
        return np.asarray((power * weight / omega).sum(-1) / total)

    v = omega[..., None] * u
    torque = output(system, "contact_torque")(theta, q, u, "right")
    input_torque = output(system, "input_torque")(theta, q, u, "right")
    stretch = _stretch(system, theta, q, tau)
    varying = 0.5 * d.contact_stiffness_slope_at(theta) * omega * stretch**2
    if system.exact:
        true = system.jet(theta + q[..., 0], 1)[1]
        rate = v[..., 1] + tau[1] * omega - true * (omega + v[..., 0])
        linear = np.zeros_like(torque)
    else:
        rate = v[..., 1] - tau[1] * v[..., 0] - tau[2] * omega * q[..., 0]
        linear = -torque * tau[2] * omega * q[..., 0]
    cam, turret = omega + v[..., 0], v[..., 1] + tau[1] * omega
    loss = d.input_damping * v[..., 0] ** 2 + d.cam_friction * cam * cam + d.turret_friction * turret * turret
    loss = loss + d.contact_damping * rate**2 + d.output_damping * (v[..., 2] - v[..., 1]) ** 2
    outside = np.zeros_like(torque)
    if system.torque is not None:
        speeds = np.stack([cam, turret, v[..., 2] + tau[1] * omega], -1)
        outside = (system.torque(theta, "right") * speeds).sum(-1)
    return EnergyBalance(mean(input_torque * omega), mean(loss), mean(linear), mean(varying), mean(outside),
                         _gained(response) / total)  # fmt: skip


def _stretch(system: TorsionSystem, theta: Floats, q: Floats, tau: Floats) -> Floats:
    """Elongation of the contact, rad, (b, n), of deviations q (b, n, 3), with tau, tau' at cam angles theta."""
    if system.exact:
        return np.asarray(q[..., 1] - (system.jet(theta + q[..., 0], 0)[0] - tau[0]))
    return np.asarray(q[..., 1] - tau[1] * q[..., 0])


def _gained(response: DriveResponse) -> Floats:
    """Energy gained (b,) in J over the last turn, kinetic and elastic."""
    system, solution, d = response.system, response.solution, response.system.drive
    out = []
    for index in (-1 - solution.grid.steps, -1):
        theta = solution.theta[[index]][None]
        q, u = solution.position[:, [index]], solution.rate[:, [index]]
        omega, _ = system.rates(theta)
        tau = system.jet(theta, 1)
        speeds = omega[..., None] * (u + np.stack([np.ones_like(tau[1]), tau[1], tau[1]], -1))
        kinetic = 0.5 * (system.mass * speeds**2).sum(-1)
        stretch = _stretch(system, theta, q, tau)
        elastic = 0.5 * (
            d.input_stiffness * q[..., 0] ** 2
            + d.output_stiffness * (q[..., 2] - q[..., 1]) ** 2
            + d.contact_stiffness_at(theta) * stretch**2
        )
        out.append((kinetic + elastic)[:, 0])
    return np.asarray(out[1] - out[0])


@immutable
class Residual:
    """Vibration left in a dwell (b,): peaks of load deviation (rad) and acceleration (rad/s2), and their settling
    time (s).

    settled (b,) is False where the band is not reached before the dwell ends; the time is then the dwell itself.
    """

    begin_rad: float
    end_rad: float
    deviation: Floats
    acceleration: Floats
    settling_s: Floats
    settled: npt.NDArray[np.bool_]

    def room(self, speed: Floats) -> float:
        """Time, s, that the dwell has left once it has settled, the least; endless where the band is never left."""
        left = (self.end_rad - self.begin_rad) / speed - self.settling_s
        return float(np.where(self.settling_s > 0.0, left, np.inf).min())


class Rings(Protocol):
    """A motion that vibrates on in its dwell: cam speed, rad/s; half a period of its lowest mode, s."""

    @property
    def speed(self) -> float: ...
    @property
    def residual(self) -> Residual: ...
    @property
    def half_swing(self) -> float: ...


class Settles:
    """Whether and when a motion comes to rest in its hardest dwell."""

    @property
    def dwells(self: Rings) -> bool:
        """Whether the motion has a dwell to settle in."""
        try:
            return bool(self.residual.end_rad > self.residual.begin_rad)
        except ProfileError:
            return False

    @property
    def settling_time(self: Rings) -> float | None:
        """Time, s, from the dwell's begin after which the band is kept for half a swing at least; None where it is not.

        What comes into the band for less than that has not settled: it only passes through. Raises ProfileError where
        the motion has no dwell.
        """
        left = self.residual
        dwell, last = (left.end_rad - left.begin_rad) / self.speed, float(left.settling_s[0])
        return last if left.settled[0] and (last == 0.0 or last <= dwell - self.half_swing) else None


def residual_vibration(
    response: DriveResponse | FollowerResponse,
    band: float = 1e-4,
    deviation_of: str = "load_deviation",
    acceleration_of: str = "load_acceleration",
) -> Residual:
    """Residual vibration in the hardest dwell; band of the deviation, rad (a slide's: m), defines settling.

    The hardest is the one that has the least time left once it has settled; of those that never leave the band, or
    never keep it, the one with the largest deviation.

    A dwell goes on over the turn's end where the response is periodic; of a transient the last turn counts. Peaks are
    as exact as the solution. Raises ProfileError when the motion has no dwell.
    """
    if not band > 0.0:
        raise ProfileError([Problem("dynamics.settling_band", "must be positive", band, "> 0 rad")])
    found = [_of_dwell(response, low, high, band, (deviation_of, acceleration_of)) for low, high in dwells(response)]
    return max(found, key=lambda one: (-one.room(response.speed), float(one.deviation.max())))


def _of_dwell(
    response: DriveResponse | FollowerResponse, low: float, high: float, band: float, names: tuple[str, str]
) -> Residual:
    """Residual vibration in one dwell."""
    parts = [_between(response.solution, *ends) for ends in _pieces(low, high)]
    deviation, acceleration = (
        np.max([peak(part, output(response.system, name)).magnitude for part in parts], axis=0)
        for name in names
    )
    time, settled = _settling(response, parts, band, names[0])
    return Residual(low, high, deviation, acceleration, time, settled)


def _pieces(low: float, high: float) -> list[tuple[float, float]]:
    """The stretch within one turn, or the two that it falls into."""
    return [(low, high)] if high <= TURN else [(low, TURN), (0.0, high - TURN)]


def _between(solution: Solution, low: float, high: float) -> Solution:
    """The solution's last turn between two knots, rad."""
    first = len(solution.theta) - len(solution.grid.theta)
    i, j = (first + int(np.abs(solution.grid.theta - angle).argmin()) for angle in (low, high))
    return replace(solution, theta=solution.theta[i : j + 1], state=solution.state[:, i : j + 1])


def _settling(
    response: DriveResponse | FollowerResponse, parts: list[Solution], band: float, name: str
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Time (b,) in s from the dwell's begin to the last exit from the band, and whether there is none up to its end."""
    angles, values, begun = [], [], 0.0
    for part in parts:
        found = np.abs(sampled(part, output(response.system, name)))
        # sampled() gives the inside of each step first, then its two ends
        values.append(found[..., [5, 0, 1, 2, 3, 4, 6]].reshape(len(found), -1))
        share = np.concatenate([[0.0], INSIDE, [1.0]])
        place = part.theta[:-1, None] + np.diff(part.theta)[:, None] * share
        angles.append(begun + (place - part.theta[0]).ravel())
        begun += float(part.theta[-1] - part.theta[0])
    angle, value = np.concatenate(angles), np.concatenate(values, 1)
    outside = value > band
    count = len(angle)
    last = np.where(outside.any(-1), count - 1 - outside[:, ::-1].argmax(-1), 0)
    after = np.minimum(last + 1, count - 1)
    row = np.arange(len(value))
    drop = value[row, last] - value[row, after]
    share = np.divide(value[row, last] - band, drop, out=np.zeros_like(drop), where=drop > 0.0)
    place = angle[last] + np.clip(share, 0.0, 1.0) * (angle[after] - angle[last])
    return np.where(outside.any(-1), place, 0.0) / response.speed, last < count - 1


def dwells(response: DriveResponse | FollowerResponse) -> list[tuple[float, float]]:
    """Cam angles in rad between which the motion rests; beyond 2 pi where a periodic state rests over the end."""
    motion = response.system.motion
    knots = np.asarray(motion.knots)
    middle = 0.5 * (knots[:-1] + knots[1:])
    at_rest = ~np.any(
        motion.jet(np.concatenate([middle, middle + 0.2 * np.diff(knots)]), 2)[1:].reshape(2, 2, -1), axis=(0, 1)
    )
    edges = np.flatnonzero(np.diff(np.concatenate([[False], at_rest, [False]]).astype(int)))
    rests = [(float(knots[i]), float(knots[j])) for i, j in edges.reshape(-1, 2)]
    if len(rests) > 1 and at_rest[0] and at_rest[-1] and _comes_back(response.solution):
        rests = [*rests[1:-1], (rests[-1][0], TURN + rests[0][1])]
    if not rests:
        raise ProfileError(
            [Problem("motion", "has no dwell, so there is no residual vibration", None, "", f"0 to {TURN:.6f}")]
        )
    return rests


def _comes_back(solution: Solution) -> bool:
    """Whether the state after the last turn is the one before it, to a ten-thousandth of its largest."""
    first = len(solution.theta) - len(solution.grid.theta)
    scale = np.abs(solution.state).max(1)
    return bool(np.all(np.abs(solution.state[:, -1] - solution.state[:, first]) <= 1e-4 * scale))
