"""How the rollers that bear on a turret share its torque, and how stiffly they hold it.

The turret turns against the cam by an angle psi; a slice of a roller whose contact moves by `lever` per radian along
its normal approaches by preload + lever psi, and presses where that is above zero. psi is the one that makes the
slices' torques add up to the turret's torque.

A small vibration about that state feels the tangent, the sum of lever^2 dP/d(approach) over what presses; the secant,
lever^2 P / approach, is 7 to 9 % lower at usual loads. Three estimates of a roller and a flank under a line load:

- "half-space": the tangent of the approach of each body's surface to its own middle, see `hertz.line_flexibility`, the
  cam as deep as the roller is thick: the one that is right for small vibration;
- "secant": load over that approach;
- "chord": the heights of both arcs over the half contact width b, h = rho - sqrt(rho^2 - b^2), as in the source of the
  11-degree model, with its misprints mended (b is the half width, stiffness is P/(h1 + h2), a secant). It counts only
  what lies within the contact width, so it is an upper bound of the stiffness and nearly independent of load and
  curvature.

Units N, mm, MPa, rad.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, Self, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.mechanics.hertz import line_flexibility, line_half_width
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.track.turret import Engagement

Estimate = Literal["half-space", "secant", "chord"]

PASSES = 200
AT_ONCE = 256
"""cam angles whose loads are shared at once: what they need stays next to the processor"""
ROUNDED = 1e-15
"""share of an approach that is rounding"""
SETTLED = 1e-12
"""change of a slice's load, share of the largest, at which the sharing has settled"""


@final
@immutable
class Held:
    """A loaded turret: line load (n, e) in N/mm and angle psi (n,) in rad by which the turret yields."""

    line_load: Floats
    angle: Floats


@final
@immutable
class Slices:
    """The slices that may press at cam angles (n,), e = walls x rollers x slices; see `Engagement`.

    lever    mm, with the sign of the torque that the wall gives the turret, (n, e)
    preload  approach at psi = 0, mm, below zero where there is a gap, (n, e)
    width    of a slice that has a wall, mm, (n, e), 0 of an end, which bears no force; radius of the roller
             there, mm, (n, e) or one
    """

    on: npt.NDArray[np.bool_]
    lever: Floats
    curvature: Floats
    preload: Floats
    width: Floats
    radius: Floats | float
    roller: Material
    cam: Material

    @classmethod
    def of(
        cls, beside: Engagement, preload: float, roller: Material, cam: Material, drop: Floats | float = 0.0
    ) -> Self:
        """The slices of an engagement, rollers preloaded by a normal interference in the dwell, mm.

        drop  gap of crown, run-out and tilt, mm, (2, n, k, m)
        """
        n = len(beside.theta)
        side = np.array([1.0, -1.0])[:, None, None, None]

        def flat(values: Floats) -> Floats:
            return np.asarray(np.moveaxis(values, 0, 1).reshape(n, -1))

        radius = flat(beside.tracks[0].radii(beside.place))
        k, on = flat(beside.curvature), beside.touches
        return cls(
            np.moveaxis(on, 0, 1).reshape(n, -1),
            flat(np.where(on, side * beside.lever, side)),
            # An undercut wall, which has no such contact, counts as a plane; its pressure is infinite (`TurretDuty`).
            np.where(k > 0.0, k, 1.0 / radius),
            flat(_pressed_in(beside, preload) - drop),
            flat(beside.cover),
            radius,
            roller,
            cam,
        )

    def rows(self, rows: npt.NDArray[np.intp] | slice) -> Self:
        """The slices at some of the cam angles."""
        return replace(self, on=self.on[rows], lever=self.lever[rows], curvature=self.curvature[rows],
                       preload=self.preload[rows], width=self.width[rows],
                       radius=self.radius[rows] if isinstance(self.radius, np.ndarray) else self.radius)  # fmt: skip

    def held(self, torque: Floats) -> Held:
        """Line loads whose torques on the turret add up to torque (n,), N mm.

        The flexibility of a line contact hangs on its load by a logarithm only: it is renewed in every Newton step of
        psi. Raises DesignError where no roller can bear, NotConverged where the loads do not settle.
        """
        parts = [slice(first, first + AT_ONCE) for first in range(0, max(1, len(torque)), AT_ONCE)]
        found = [self.rows(part)._held(torque[part]) for part in parts]
        return Held(np.concatenate([one.line_load for one in found]), np.concatenate([one.angle for one in found]))

    def _held(self, torque: Floats) -> Held:
        way = np.where(torque >= 0.0, 1.0, -1.0)[:, None]
        wanted, lever = np.abs(torque), way * self.lever
        helping = self.on & (lever > 0.0) & (self.width > 0.0)
        if not helping.any(axis=1).all():
            raise DesignError("no roller can take the turret's torque at some cam angle: widen the cam")
        touching = np.where(helping, -self.preload / np.where(helping, lever, 1.0), np.inf)
        touch = touching.min(axis=1)
        # At the first touch a slice is pressed by nothing but its rounding, which may as well be a gap.
        first = touching <= touch[:, None]
        # a first guess beyond the first touch; no load is below a millionth of the mean one
        angle = np.maximum(touch, 0.0)
        mean = wanted / np.where(helping, lever * self.width, 0.0).sum(axis=1)
        least = np.maximum(1e-6 * mean, 1e-9)[:, None]
        load = np.broadcast_to(np.maximum(mean[:, None], least), lever.shape)
        for _ in range(PASSES):
            soft = self._half_space(np.maximum(load, least), self.curvature)
            approach = self.preload + lever * angle[:, None]
            pressed = self.on & ((approach > 0.0) | first)
            hard = np.where(pressed, lever * self.width / soft, 0.0)
            slope = (hard * lever).sum(axis=1)
            rest = wanted - (hard * approach).sum(axis=1)
            angle = np.maximum(angle + np.divide(rest, slope, out=np.zeros_like(angle), where=slope > 0.0), touch)
            fresh = np.where(self.on, np.maximum(self.preload + lever * angle[:, None], 0.0), 0.0) / soft
            # Under next to no torque the approach is the rounding of the gaps that are closed before it.
            noise = ROUNDED * np.abs(lever * angle[:, None]) / soft
            done = bool(np.all(np.abs(fresh - load) <= SETTLED * np.maximum(fresh.max(axis=1), mean)[:, None] + noise))
            load = fresh
            if done:
                return Held(load, way[:, 0] * angle)
        raise NotConverged("the load on the turret's rollers did not settle: check the preload against the torque")

    def stiffness(self, line_load: Floats, estimate: Estimate = "half-space") -> Floats:
        """Stiffness of the turret against the cam, N mm/rad, (n,), under line loads (n, e); see above.

        Raises DesignError where a contact is wider than the body that makes it.
        """
        return np.asarray((self.rates(line_load, estimate) * self.lever * self.width).sum(axis=1))

    def rates(self, line_load: Floats, estimate: Estimate = "half-space") -> Floats:
        """Change of the line loads, N/mm, with the turret's angle, rad, (n, e); zero of what does not press."""
        pressed = line_load > 0.0
        load, curvature = np.where(pressed, line_load, 1.0), np.where(pressed, self.curvature, 1.0)
        soft = self._chord(load, curvature) if estimate == "chord" else self._half_space(load, curvature)
        if estimate == "half-space":
            # The approach P f(P) has f fall with ln b, half of ln P: d(P f)/dP = f - (compliances)/pi.
            soft = soft - pair_compliance(self.roller, self.cam) / np.pi
        return np.where(pressed, self.lever / soft, 0.0)

    def _half_space(self, line_load: Floats, curvature: Floats) -> Floats:
        """Approach over line load, mm²/N, of bodies that yield down to the roller's axis and its diameter."""
        return line_flexibility(line_load, curvature, self.roller, self.cam, self.radius, 2.0 * self.radius)

    def _chord(self, line_load: Floats, curvature: Floats) -> Floats:
        """Approach over line load, mm²/N, of the arcs within the contact width."""
        half = line_half_width(line_load, curvature, pair_compliance(self.roller, self.cam))
        return (_arc(half, 1.0 / self.radius) + _arc(half, curvature - 1.0 / self.radius)) / line_load


def _arc(half: Floats, curvature: Floats | float) -> Floats:
    """Height, mm, of an arc of given curvature (1/mm, negative when hollow) over a half width b: rho - sqrt(rho^2 -
    b^2).
    """
    bend = half * curvature
    if np.any(np.abs(bend) >= 1.0):
        raise DesignError("the contact of roller and cam is wider than the body that makes it: lower the load")
    # (1 - sqrt(1 - x^2))/k without cancellation
    return np.asarray(half * bend / (1.0 + np.sqrt(1.0 - bend * bend)))


def _pressed_in(beside: Engagement, preload: float) -> Floats:
    """How far each slice is pressed into the cam, mm, (2, n, k, m), by a turret set closer along the line of centres.

    The closer setting is the one that gives the normal interference `preload` in the dwell at cam angle zero; where no
    roller stands so that it presses there, nothing is preloaded.
    """
    if preload <= 0.0:
        return np.zeros(beside.on.shape)
    turn = beside.tracks[0].sense * beside.theta[:, None, None]
    inward = np.sin(turn) * beside.normal[..., 1] - np.cos(turn) * beside.normal[..., 0]
    first = int(np.argmin(np.abs(beside.theta)))
    steepest = float(np.where(beside.cover[:, first] > 0.0, inward[:, first], 0.0).max())
    if steepest <= 0.0:
        return np.zeros(beside.on.shape)
    return np.asarray(preload / steepest * inward)
