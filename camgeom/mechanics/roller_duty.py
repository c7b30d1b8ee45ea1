"""What the cam has to do: force, contact stress, life and torque, computed on the flank's own geometry.

One roller on one track (two walls, behind and ahead of it). Everything lives on panels of the cam angle on which it is
smooth, so peaks, reversals and the hot spot are found to rounding, not to a sampling step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees
from typing import Any, final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.panels import panels, roots
from camgeom.maths.surface import dot
from camgeom.mechanics import groove
from camgeom.mechanics.bearing import BearingLife, bearing_life
from camgeom.mechanics.contact import Contact, Peak, crown_gaps, line_contacts, share_load
from camgeom.mechanics.duty import MILLI, finite, hertz_data, peak_of, slice_data, torque_data
from camgeom.mechanics.hertz import LineContact, line_contact
from camgeom.mechanics.life import CamLife, RollerLife, cam_life, roller_life
from camgeom.mechanics.load import QUIET, FollowerForce, Load, guided_force, normal_force
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.track import Track
from camgeom.track.flank import Flank
from camgeom.track.runout import wall_ends

SLICES = 9
NOWHERE = 1e3
"""mm; gap beside a slice of the roller that has no wall: more than any load closes"""
Mask = npt.NDArray[np.bool_]


@final
@dataclass(frozen=True, eq=False)
class Walls:
    """The flank on panels (p, n) at one station: relative curvature of both walls, lever and path rolled.

    behind, ahead  relative curvature, 1/mm; `ahead` is zero where the cam has no such wall
    lever          velocity of the contact point along the normal per unit of the coordinate (1 or mm/rad), > 0
    cosine         of the pressure angle
    path_rate      path of the roller centre relative to the cam across its axis, mm/rad
    here           whether the walls behind and ahead exist beside the roller, which may leave the cam on purpose
    """

    behind: Floats
    ahead: Floats
    lever: Floats
    cosine: Floats
    path_rate: Floats
    here: tuple[Mask, Mask]


@final
@dataclass(frozen=True, eq=False)
class RollerDuty:
    """One roller under load over one turn.

    track   the roller's track; `station` its meridian parameter where the classical figures are quoted
    load    what acts on the follower
    crown   radius of the meridian, mm, of a crowned roller on a straight flank (planar cams); None: the flank is the
            roller's own envelope
    rating  of the roller's bearing, dynamic and static, N; None where it is not known
    inside  which contact points (3, ...) are on the cam, where the roller leaves it on purpose: no wall takes a force
            elsewhere
    """

    track: Track
    station: float
    length: float
    load: Load
    roller: Material
    cam: Material
    crown: float | None = None
    rating: float | None = None
    static_rating: float | None = None
    inside: Callable[[Floats], Mask] | None = None

    @property
    def speed(self) -> float:
        """Cam speed, rad/s."""
        return self.load.omega

    @cached_property
    def force(self) -> FollowerForce:
        """Motion and force of the follower on panels; what this track's walls can give.

        A track with one wall (force-closed cam, one disc of a conjugate pair) pushes one way only: the force is
        clipped at zero, on panels that have an edge where it changes sign.
        """
        full = self.load.sampled()
        if self.inside is not None:
            return self._held(full)
        if len(self.track.sides) > 1:
            return full
        zeros = roots(full.panels, full.force[None], QUIET * float(np.abs(full.force).max(initial=0.0)))[0]
        if zeros.size:
            full = self.load.sampled(panels(np.concatenate([full.panels.edges, zeros]), np.inf))
        sign = -float(np.sign(Flank(self.track, full.panels.theta[0], np.array([self.station]), self.track.sides[0])
                              .lever().mean()))
        return replace(full, force=np.maximum(sign * full.force, 0.0) * sign)

    def _held(self, full: FollowerForce) -> FollowerForce:
        """The force where the wall that it presses exists beside some slice of the roller, none elsewhere."""
        assert self.inside is not None
        stations = np.array([self.track.meridian.parameter(float(d)) for d in self._middles])
        edges = [roots(full.panels, full.force[None], QUIET * float(np.abs(full.force).max(initial=0.0)))[0]]
        edges += [lost for side in self.track.sides for lost in wall_ends(self.track, side, stations, self.inside)]
        split = self.load.sampled(panels(np.concatenate([full.panels.edges, *edges]), np.inf))
        theta = split.panels.theta
        held = np.zeros(theta.shape, dtype=bool)
        for side in self.track.sides:
            flank = Flank(self.track, theta.ravel(), stations, side)
            behind = float(flank.lever().mean()) < 0.0
            there = self.inside(flank.x).any(axis=1).reshape(theta.shape)
            held |= there & ((split.force >= 0.0) if behind else (split.force < 0.0))
        return replace(split, force=np.where(held, split.force, 0.0))

    @cached_property
    def unheld(self) -> Extreme | None:
        """Largest force on the follower, N (N mm), that presses where no wall is; None where a wall is all round."""
        if self.inside is None:
            return None
        full = np.abs(self.load.sampled(self.force.panels).force)
        lost = np.where(self.force.force == 0.0, full, 0.0)
        at = np.unravel_index(int(np.argmax(lost)), lost.shape)
        return Extreme(float(lost[at]), float(self.force.panels.theta[at]))

    @property
    def _middles(self) -> Floats:
        """Middles of the slices along the roller, mm."""
        edges = np.linspace(min(self.track.contact), max(self.track.contact), SLICES + 1)
        return np.asarray(0.5 * (edges[1:] + edges[:-1]))

    def walls(self, t: float) -> Walls:
        """The flank at one meridian parameter t."""
        shape = self.force.panels.theta.shape
        theta = self.force.panels.theta.ravel()
        flanks = {side: Flank(self.track, theta, np.array([t]), side) for side in self.track.sides}
        behind = next((s for s, f in flanks.items() if float(f.lever().mean()) < 0.0), None)
        ahead = next((s for s in flanks if s != behind), None)
        some = next(iter(flanks.values()))
        zero = np.zeros(shape)
        pose = some.pose
        delta = float(self.track.meridian.jet(np.array([t]))[0][0])
        v, u = pose.a[1] + delta * pose.u[1], pose.u[0]
        across = v - dot(v, u) * u
        here = {side: self._here(flank).reshape(shape) for side, flank in flanks.items()}
        curvature = {
            # A fold in free air is nobody's stress: a plane stands for it.
            side: flank.k_rel.reshape(shape) if self.inside is None else
            np.where(here[side] | (flank.k_rel.reshape(shape) > 0.0), flank.k_rel.reshape(shape), 1.0 / self.radius)
            for side, flank in flanks.items()
        }
        none = np.zeros(shape, dtype=bool)
        return Walls(
            curvature[behind] if behind is not None else zero,
            curvature[ahead] if ahead is not None else zero,
            np.abs(some.lever()).reshape(shape),
            np.cos(some.pressure_angle()).reshape(shape),
            np.sqrt(dot(across, across)).reshape(shape),
            (here[behind] if behind is not None else none, here[ahead] if ahead is not None else none),
        )

    def _here(self, flank: Flank) -> Mask:
        """Where a flank's points are on the cam, (n, m)."""
        return np.ones(flank.x.shape[1:], dtype=bool) if self.inside is None else self.inside(flank.x)

    @cached_property
    def reference(self) -> Walls:
        """The flank at the quoted station."""
        return self.walls(self.station)

    @cached_property
    def radius(self) -> float:
        """Roller radius at the quoted station, mm."""
        return float(self.track.meridian.jet(np.array([self.station]))[3][0])

    @cached_property
    def normal(self) -> Floats:
        """Signed normal force on the roller, N, (p, n); positive on the wall behind."""
        w = self.reference
        return normal_force(self.pushed, w.cosine, w.lever / w.cosine)

    @cached_property
    def pushed(self) -> Floats:
        """Force along the motion with the friction that the side thrust makes in a slide's guides, N (N mm), (p, n)."""
        force = self.force
        return guided_force(force.force, self.reference.cosine, self.load.guide_friction, force.direction)

    @cached_property
    def contact(self) -> Contact:
        """Contact at the quoted station with the exact relative curvature."""
        w = self.reference
        pair = pair_compliance(self.roller, self.cam)
        return line_contacts(self.force.panels, self.normal, w.behind, w.ahead, w.path_rate, self.length, pair)

    def conventions(self, pitch_radius: float) -> dict[groove.Convention, tuple[Peak, RollerLife]]:
        """Peak pressure and roller life under the curvature conventions of the literature, at the pitch radius, mm.

        Of a cylindrical roller on a translating follower, in the groove of a drum.
        """
        answers = {}
        for name in groove.CONVENTIONS:
            contact = groove.groove_contact(
                self.force, pitch_radius, self.radius, self.length, self.roller, self.cam, name,
                self.load.guide_friction,
            )  # fmt: skip
            answers[name] = (contact.peak(), roller_life(contact, self.roller, self.radius, self.speed))
        return answers

    @cached_property
    def slices(self) -> Contact:
        """Contact of SLICES equal slices along the roller that approach alike; a leading axis (m,)."""
        stations, widths, walls = self._slices
        force = self.pushed
        behind, ahead = (np.stack([getattr(w, k) for w in walls], axis=-1) for k in ("behind", "ahead"))
        lever = np.stack([w.lever for w in walls], axis=-1)
        k = np.where(force[..., None] >= 0.0, behind, ahead)
        gaps = self._gaps(stations)
        if self.inside is not None:
            near, far = (np.stack([w.here[i] for w in walls], axis=-1) for i in (0, 1))
            gaps = np.where(np.where(force[..., None] >= 0.0, near, far), gaps, NOWHERE)
        shared = share_load(
            np.abs(force),
            stations - stations.mean(),
            widths,
            np.maximum(k, 1e-12),
            self.roller,
            self.cam,
            self.radius,
            2.0 * self.radius,
            gaps,
            cosines=lever,
        )
        line = np.moveaxis(shared.line_load, -1, 0) * np.sign(force)
        pair = pair_compliance(self.roller, self.cam)
        return line_contacts(
            self.force.panels,
            line,
            np.moveaxis(behind, -1, 0),
            np.moveaxis(ahead, -1, 0),
            np.broadcast_to(self.reference.path_rate, line.shape),
            1.0,
            pair,
        )

    @cached_property
    def slice_stations(self) -> Floats:
        """Place of each slice's middle along the roller axis (delta), mm."""
        return self._slices[0]

    @cached_property
    def _slices(self) -> tuple[Floats, Floats, list[Walls]]:
        low, high = sorted(self.track.contact)
        walls = [self.walls(self.track.meridian.parameter(float(d))) for d in self._middles]
        return self._middles, np.diff(np.linspace(low, high, SLICES + 1)), walls

    def _gaps(self, stations: Floats) -> Floats:
        """Gap between roller and flank along the slices, mm: none where the flank is the roller's own envelope."""
        if self.crown is None:
            return np.zeros_like(stations)
        half = np.minimum(np.abs(stations - 0.5 * sum(self.track.contact)), self.crown)
        return crown_gaps(half, self.crown)

    @cached_property
    def peak_contact(self) -> LineContact:
        """Half-width, approach and subsurface shear of the hardest contact at the quoted station."""
        square = np.maximum(self.contact.behind, self.contact.ahead)
        at = np.unravel_index(int(np.argmax(square)), square.shape)
        w = self.reference
        k = w.behind[at] if self.normal[at] >= 0.0 else w.ahead[at]
        load = abs(float(self.normal[at])) / self.length
        return line_contact(load, k, self.roller, self.cam, self.radius)

    @cached_property
    def roller_life(self) -> RollerLife:
        """Fatigue life of the roller's circumference at the quoted station."""
        return roller_life(self.contact, self.roller, self.radius, self.speed)

    @cached_property
    def slice_life(self) -> RollerLife:
        """Fatigue life of every slice of the roller, (m,); its spin is that of the quoted station."""
        return roller_life(self.slices, self.roller, self.radius, self.speed)

    @cached_property
    def cam_life(self) -> CamLife:
        """Fatigue life of the cam's walls at the quoted station."""
        return cam_life(self.contact, self.cam, self.speed)

    @cached_property
    def bearing(self) -> BearingLife | None:
        """Life of the roller as a bearing; None where it has no rating."""
        if self.rating is None:
            return None
        return bearing_life(self.force.panels, self.normal, self.reference.path_rate, self.radius, self.speed,
                            self.rating, self.static_rating)

    @cached_property
    def lives(self) -> dict[str, float]:
        """Fatigue life, h, of the roller and the cam at the quoted station, and of the roller's bearing."""
        lives = {"roller": float(self.roller_life.life_h), "cam": float(self.cam_life.life_h)}
        return lives if self.bearing is None else lives | {"bearing": float(self.bearing.life_h)}

    @cached_property
    def torque(self) -> Floats:
        """Torque the cam takes from its shaft, N mm, (p, n)."""
        guides = (self.pushed - self.force.force) * self.force.ds
        return self.force.camshaft_torque() + guides

    @property
    def contact_forces(self) -> Floats:
        """Normal force of the roller on its walls, N, (1, p, n)."""
        return np.abs(self.normal)[None]

    @cached_property
    def peak_force(self) -> Extreme:
        """Largest normal force, N."""
        return peak_of(self.force.panels, np.abs(self.normal))

    @cached_property
    def peak_torque(self) -> Extreme:
        """Largest torque that the cam takes from its shaft, N mm."""
        return peak_of(self.force.panels, self.torque)

    @cached_property
    def peak_pressure(self) -> Extreme:
        """Largest contact pressure of all slices, MPa; infinite where the roller undercuts a wall that it loads."""
        peak = self.slices.peak()
        worst = int(np.argmax(peak.pressure))
        return Extreme(float(peak.pressure[worst]), float(peak.theta[worst]), float(self.slice_stations[worst]))

    @property
    def least_force(self) -> None:
        """None: what holds a roller on its cam is judged on the cam's touches (`face_duty`)."""

    def contact_data(self) -> dict[str, Any]:
        """Peak pressure at the quoted place and over the slices, force, torque, subsurface shear, as plain data."""
        peak = self.contact.peak()
        return {
            "peak_pressure_mpa": finite(peak.pressure),
            "cam_angle_deg": degrees(float(peak.theta)),
            "peak_force_n": self.peak_force.value,
            **slice_data(self.peak_pressure),
            **hertz_data(self.peak_contact),
            **torque_data(self.peak_torque, float(self.force.work())),
            "wall_reversals_deg": [degrees(r.taken) for r in self.force.reversals()[0]],
        }

    def fatigue_data(self) -> dict[str, Any]:
        """Lives of roller and cam as plain data."""
        life = self.roller_life
        return {
            "roller_life_h": finite(life.life_h),
            "roller_slice_life_h": finite(np.min(self.slice_life.life_h)),
            "hot_spot_deg": degrees(float(life.hot_spot)) % 360.0,
            "cam_life_h": finite(self.cam_life.life_h),
            "path_per_turn_m": float(life.path) * MILLI,
        }
