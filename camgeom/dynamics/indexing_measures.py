"""What is judged from a response: energy balance of the periodic state, residual vibration in the dwell, settling
time.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
import numpy.typing as npt

from camgeom.dynamics.indexing_response import Response, output
from camgeom.dynamics.integrators import Array
from camgeom.dynamics.integrators_exact import advance
from camgeom.errors import Problem, ProfileError

QUADRATURE = 5
"""Gauss points a step for the mean powers"""


@dataclass(frozen=True, eq=False)
class EnergyBalance:
    """Mean powers (b,) in W over a turn: input, dissipated, and what linearisation of the contact adds; error is a
    share.

    The linearised contact stores no consistent energy: its mean power is T12 tau'' omega q1; with the exact contact
    it is zero. external is the power of an applied torque.
    """

    input: Array
    dissipated: Array
    linearisation: Array
    external: Array
    kinetic: Array

    @property
    def error(self) -> Array:
        """Unbalanced share (b,) of the largest of the mean powers."""
        parts = [self.input, -self.dissipated, self.linearisation, self.external, -self.kinetic]
        scale = np.max(np.abs(parts), axis=0)
        return np.asarray(np.abs(np.sum(parts, axis=0)) / np.where(scale > 0.0, scale, 1.0))


def energy_balance(response: Response) -> EnergyBalance:
    """Mean powers over the last turn of a response, by Gauss quadrature of true partial steps.

    kinetic is the energy gained over the turn divided by its time: zero for a steady state.
    """
    system, solution = response.system, response.solution
    d = system.drive
    count = solution.grid.steps
    begin, step = solution.theta[-count - 1 : -1], np.diff(solution.theta[-count - 1 :])
    roots, weights = np.polynomial.legendre.leggauss(QUADRATURE)
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

    def mean(power: Array) -> Array:
        return np.asarray((power * weight / omega).sum(-1) / total)

    v = omega[..., None] * u
    torque = output(system, "contact_torque")(theta, q, u, "right")
    input_torque = output(system, "input_torque")(theta, q, u, "right")
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
    return EnergyBalance(mean(input_torque * omega), mean(loss), mean(linear), mean(outside), _gained(response) / total)


def _gained(response: Response) -> Array:
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
        stretch = q[..., 1] - tau[1] * q[..., 0]
        if system.exact:
            stretch = q[..., 1] - (system.jet(theta + q[..., 0], 0)[0] - tau[0])
        elastic = 0.5 * (
            d.input_stiffness * q[..., 0] ** 2
            + d.output_stiffness * (q[..., 2] - q[..., 1]) ** 2
            + d.contact_stiffness_at(theta) * stretch**2
        )
        out.append((kinetic + elastic)[:, 0])
    return np.asarray(out[1] - out[0])


@dataclass(frozen=True, eq=False)
class Residual:
    """Vibration left in a dwell (b,): peaks of load deviation (rad) and acceleration (rad/s2), and their settling
    time (s).

    settled (b,) is False where the band is not reached before the dwell ends; the time is then the dwell itself.
    """

    begin_rad: float
    end_rad: float
    deviation: Array
    acceleration: Array
    settling_s: Array
    settled: npt.NDArray[np.bool_]


def residual_vibration(response: Response, band: float = 1e-4, samples: int = 64) -> Residual:
    """Residual vibration in the longest dwell of the last turn; band in rad of load-plate deviation defines settling.

    Raises ProfileError when the motion has no dwell. Samples per step: the peak is exact to (omega h/samples)^2/8.
    """
    if not band > 0.0:
        raise ProfileError([Problem("dynamics.settling_band", "must be positive", band, "> 0 rad")])
    low, high = longest_dwell(response)
    solution = response.solution
    offset = solution.theta[-1] - solution.grid.theta[-1]
    count = max(
        2, samples * int(np.searchsorted(solution.grid.theta, high) - np.searchsorted(solution.grid.theta, low))
    )
    theta = offset + np.linspace(low, high, count)
    # the dwell's last angle belongs to the next motion
    theta[-1] = np.nextafter(theta[-1], 0.0)
    deviation = np.abs(response.at(theta, "load_deviation"))
    acceleration = np.abs(response.at(theta, "load_acceleration"))
    outside = deviation > band
    last = np.where(outside.any(-1), count - 1 - outside[:, ::-1].argmax(-1), 0)
    settled = last < count - 1
    time = np.where(outside.any(-1), (theta[last] - theta[0]), 0.0) / response.speed
    return Residual(low, high, deviation.max(-1), acceleration.max(-1), time, settled)


def longest_dwell(response: Response) -> tuple[float, float]:
    """Cam angles in rad between which the turret rests longest, within one turn."""
    motion = response.system.motion
    knots = np.asarray(motion.knots)
    middle = 0.5 * (knots[:-1] + knots[1:])
    at_rest = ~np.any(
        motion.jet(np.concatenate([middle, middle + 0.2 * np.diff(knots)]), 2)[1:].reshape(2, 2, -1), axis=(0, 1)
    )
    best = (0.0, 0.0)
    k = 0
    while k < len(middle):
        end = k
        while end < len(middle) and at_rest[end]:
            end += 1
        if end > k and knots[end] - knots[k] > best[1] - best[0]:
            best = (float(knots[k]), float(knots[end]))
        k = max(end, k + 1)
    if best[1] <= best[0]:
        raise ProfileError(
            [Problem("motion", "has no dwell, so there is no residual vibration", None, "", f"0 to {2 * pi:.6f}")]
        )
    return best
