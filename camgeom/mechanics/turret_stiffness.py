"""Torsional stiffness between cam and turret over a turn, from the line contacts that bear the turret's own torque.

The turret turns against the cam by an angle psi; a slice of a roller whose contact moves by `lever` per radian along
its normal approaches by preload + lever psi, and presses where that is above zero. psi is the one that makes the
slices' torques add up to the turret's torque, and the stiffness is the sum of lever^2 P / approach over what presses.
Units N, mm, MPa, rad; the table is N m/rad.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError, NotConverged
from camgeom.maths import Floats
from camgeom.mechanics.hertz import line_flexibility
from camgeom.track.turret import Engagement, Inside

if TYPE_CHECKING:
    from camgeom.mechanics.load import FollowerForce
    from camgeom.mechanics.material import Material
    from camgeom.mechanics.stiffness import Estimate
    from camgeom.track import Track

Bools = npt.NDArray[np.bool_]

COUNT = 72
"""values in a turn"""
WITHIN = 5
"""cam angles averaged into a value: a roller that comes or goes within the step counts for its share of it"""
LEAST = 0.1
"""share of the largest torque that counts where the turret is loaded less: an unloaded line contact has no stiffness,
and a tenth of the load lowers it by about a sixth"""
PASSES = 200
SETTLED = 1e-12
MILLI = 1e-3
MEGA = 1e6


class LoadedTurret(Protocol):
    """What bears on a turret: its rollers, where the cam is, force and torque (N mm), preload (mm), materials."""

    @property
    def tracks(self) -> tuple[Track, ...]: ...
    @property
    def inside(self) -> Inside: ...
    @property
    def force(self) -> FollowerForce: ...
    @property
    def torque(self) -> Floats: ...
    @property
    def preload(self) -> float: ...
    @property
    def roller(self) -> Material: ...
    @property
    def cam(self) -> Material: ...


@dataclass(frozen=True, eq=False)
class Bearing:
    """The slices that may press at cam angles (n,), e = walls x rollers x slices; see `Engagement`.

    lever    mm, with the sign of the torque that the wall gives the turret, (n, e)
    preload  approach at psi = 0, mm, below zero where there is a gap, (n, e)
    """

    on: Bools
    lever: Floats
    curvature: Floats
    preload: Floats
    width: float
    radius: float


@dataclass(frozen=True, eq=False)
class Held:
    """A loaded turret: line load (n, e) in N/mm and angle psi (n,) in rad by which the turret yields."""

    line_load: Floats
    angle: Floats


def contact_table(duty: LoadedTurret, estimate: Estimate = "half-space") -> tuple[float, ...]:
    """K12 in N m/rad at COUNT equal steps of a turn from cam angle zero, under the duty's torque.

    Raises DesignError where no roller can bear.
    """
    from camgeom.mechanics.stiffness import Elastic, contact_stiffness

    step = 2.0 * np.pi / COUNT
    theta = (np.arange(COUNT * WITHIN) - WITHIN // 2) * step / WITHIN
    bearing = bearing_at(duty, theta)
    held = equilibrium(bearing, torque_at(duty, theta, bool(bearing.preload.any())), duty)
    found = contact_stiffness(
        bearing.curvature.T / MILLI,
        held.line_load.T * bearing.width,
        bearing.width * MILLI,
        bearing.radius * MILLI,
        Elastic(duty.cam.elastic_modulus * MEGA, duty.cam.poisson),
        Elastic(duty.roller.elastic_modulus * MEGA, duty.roller.poisson),
        estimate,
        2.0 * bearing.radius * MILLI,
    )
    each = found.torsional(np.abs(bearing.lever).T * MILLI)
    return tuple(float(value) for value in each.reshape(COUNT, WITHIN).mean(axis=1))


def torque_at(duty: LoadedTurret, theta: Floats, preloaded: bool) -> Floats:
    """Torque on the turret, N mm, (n,), at cam angles (n,), without preload at least LEAST of the largest."""
    torque = duty.force.panels.at(duty.force.force, np.mod(theta, 2.0 * np.pi))
    largest = float(np.abs(duty.torque).max(initial=0.0))
    if largest == 0.0:
        raise DesignError("the turret has no torque to press its rollers on the cam: give its inertia or a friction")
    if preloaded:
        return np.asarray(torque)
    return np.asarray(np.where(torque >= 0.0, 1.0, -1.0) * np.maximum(np.abs(torque), LEAST * largest))


def bearing_at(duty: LoadedTurret, theta: Floats) -> Bearing:
    """The slices beside the cam at cam angles (n,)."""
    return bearing_of(duty, Engagement(duty.tracks, duty.inside, theta))


def bearing_of(duty: LoadedTurret, beside: Engagement) -> Bearing:
    """The slices of an engagement at its cam angles (n,)."""
    n = len(beside.theta)
    side = np.array([1.0, -1.0])[:, None, None, None]

    def flat(values: Floats) -> Floats:
        return np.asarray(np.moveaxis(values, 0, 1).reshape(n, -1))

    on = flat(beside.on.astype(float)) > 0.5
    middle = len(beside.stations) // 2
    radius = float(duty.tracks[0].meridian.jet(beside.stations)[3][middle])
    return Bearing(
        on,
        flat(np.where(beside.on, side * beside.lever, side)),
        np.maximum(flat(np.where(beside.on, beside.curvature, 1.0)), 1e-12),
        flat(_preload(duty, beside)),
        beside.width,
        radius,
    )


def _preload(duty: LoadedTurret, beside: Engagement) -> Floats:
    """How far each slice is pressed into the cam, mm, (2, n, k, m), by a turret set closer along the line of centres.

    The closer setting is the one that gives the duty's normal interference in the dwell at cam angle zero; where no
    roller stands so that it presses there, nothing is preloaded.
    """
    if duty.preload <= 0.0:
        return np.zeros(beside.on.shape)
    turn = duty.tracks[0].sense * beside.theta[:, None, None]
    inward = np.sin(turn) * beside.normal[..., 1] - np.cos(turn) * beside.normal[..., 0]
    first = int(np.argmin(np.abs(beside.theta)))
    steepest = float(np.where(beside.on[:, first], inward[:, first], 0.0).max())
    if steepest <= 0.0:
        return np.zeros(beside.on.shape)
    return np.asarray(duty.preload / steepest * inward)


def equilibrium(bearing: Bearing, torque: Floats, duty: LoadedTurret) -> Held:
    """Line loads whose torques on the turret add up to torque (n,), N mm.

    The flexibility of a line contact hangs on its load by a logarithm only: it is renewed in every Newton step of psi.
    Raises DesignError where no roller can bear, NotConverged where the loads do not settle.
    """
    way = np.where(torque >= 0.0, 1.0, -1.0)[:, None]
    wanted, lever = np.abs(torque), way * bearing.lever
    helping = bearing.on & (lever > 0.0)
    if not helping.any(axis=1).all():
        raise DesignError("no roller can take the turret's torque at some cam angle: widen the cam")
    touch = np.where(helping, -bearing.preload / np.where(helping, lever, 1.0), np.inf).min(axis=1)
    # a first guess beyond the first touch; no load is below a millionth of the mean one
    angle = np.maximum(touch, 0.0)
    mean = wanted / (np.where(helping, lever, 0.0).sum(axis=1) * bearing.width)
    least = np.maximum(1e-6 * mean, 1e-9)[:, None]
    load = np.broadcast_to(np.maximum(mean[:, None], least), lever.shape)
    for turn in range(PASSES):
        soft = line_flexibility(
            np.maximum(load, least), bearing.curvature, duty.roller, duty.cam, bearing.radius, 2.0 * bearing.radius
        )
        approach = bearing.preload + lever * angle[:, None]
        pressed = bearing.on & ((approach > 0.0) | ((turn == 0) & helping & (approach >= 0.0)))
        hard = np.where(pressed, lever * bearing.width / soft, 0.0)
        slope = (hard * lever).sum(axis=1)
        change = np.divide(wanted - (hard * approach).sum(axis=1), slope, out=np.zeros_like(angle), where=slope > 0.0)
        angle = np.maximum(angle + change, touch)
        fresh = np.where(bearing.on, np.maximum(bearing.preload + lever * angle[:, None], 0.0), 0.0) / soft
        done = bool(np.all(np.abs(fresh - load) <= SETTLED * np.maximum(fresh.max(axis=1), mean)[:, None]))
        load = fresh
        if done:
            return Held(load, way[:, 0] * angle)
    raise NotConverged("the load on the turret's rollers did not settle: check the preload against the torque")
