"""A loaded turret: torque shared among the rollers that bear, contact pressure, lives, what shaft and studs see.

All rollers whose walls can push the needed way turn with the turret by the same small angle, so that every slice
approaches by that angle times its own lever; the line contacts' stiffness then shares the torque. Units N, mm, MPa,
rad, s.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import degrees, inf, tan
from typing import TYPE_CHECKING, Any, Literal, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats, among, distinct
from camgeom.maths.extremum import Extreme, bracketed_maximum, brackets
from camgeom.maths.frozen import cached_property, shelved
from camgeom.maths.surface import dot
from camgeom.mechanics.bearing import (
    BearingLife,
    modified,
    rated_hours,
    shaft_stress,
    span_moment,
    static_safety,
    stud_stress,
)
from camgeom.mechanics.contact import share_load
from camgeom.mechanics.duty import (
    MILLI,
    TILT,
    Duty,
    finite,
    free,
    hertz_data,
    inside_data,
    length_data,
    patch_data,
    slice_data,
    slice_shares,
    torque_data,
)
from camgeom.mechanics.hertz import Beneath, allowable_load, beneath_line, line_depth, line_flexibility, line_pressure
from camgeom.mechanics.life import hours
from camgeom.mechanics.load import QUIET, FollowerForce, Load
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.mechanics.stiffness import Estimate, Slices
from camgeom.track import TURN, Track
from camgeom.track.flank import Flank
from camgeom.track.follower import PLAIN, Ends
from camgeom.track.turret import BESIDE, Beside, Engagement

if TYPE_CHECKING:
    from camgeom.mechanics.film import Film, Oil
    from camgeom.mechanics.finite_contact import AxialProfile
    from camgeom.mechanics.finite_turret import FiniteTurret
    from camgeom.mechanics.rating import Rating

FAR = 1e6
"""mm; gap of a slice with nothing to bear on"""
STUD_SHARE = 0.5
"""Stud over roller diameter of a usual cam follower, where nothing better is known"""
SPAN_SHARE = 1.6
"""Bearing distance of the camshaft over the cam's width, where nothing better is known"""
PEAKS = 3
"""samples of each quantity, the largest that stand above their neighbours, about which a larger one is looked for"""
GAIN = 1e-9
"""share of a largest quantity that is not worth another look"""
COUNT = 360
"""values of stiffness in a turn"""
WITHIN = 5
"""cam angles averaged into a value: a roller that comes or goes within the step counts for its share of it"""
LEAST = 0.1
"""share of the largest torque that counts where the turret is loaded less: an unloaded line contact has no stiffness,
and a tenth of the load lowers it by about a sixth"""


@final
@immutable
class TurretDuty(Duty):
    """The turret under load over one cam turn.

    load     torque on the turret
    preload  normal interference in the dwell, mm
    width, bore   of the cam, mm, for its shaft (no shaft stress without a bore)
    rating   of a roller's bearing; None where it is not known
    ends     how a roller ends and how it stands against its flank
    crown    radius of its meridian, mm, on a flank that is straight along it; None: the flank is its own envelope
    paid     raises NotConverged where contacts on a half-space would take too long
    """

    beside: Beside
    load: Load
    roller: Material
    cam: Material
    preload: float = 0.0
    width: float = 0.0
    bore: float = 0.0
    rating: Rating | None = None
    ends: Ends = PLAIN
    crown: float | None = None
    paid: Callable[[], None] = free

    @property
    def tracks(self) -> tuple[Track, ...]:
        """The grooves that the rollers bear in."""
        return self.beside.tracks

    @property
    def speed(self) -> float:
        """Cam speed, rad/s."""
        return self.load.omega

    @cached_property
    def force(self) -> FollowerForce:
        """Motion and torque (N mm) of the turret on panels, which end where a roller comes to bear or ceases to."""
        return self.load.sampled(self.load.panels().split(self.beside.comings[0]))

    @cached_property
    def _sampled(self) -> Floats:
        """Cam angles at which the turn is sampled, rad, (n,): those of the panels, and both sides of where a roller
        comes or the torque may jump."""
        events = np.concatenate([*self.beside.comings, self.force.panels.breaks])
        beside = np.concatenate([events - BESIDE, events + BESIDE])
        beside = beside[(beside > 0.0) & (beside < TURN)]
        return distinct(np.concatenate([self.force.panels.theta.ravel(), beside]))

    @cached_property
    def theta(self) -> Floats:
        """Cam angles of the sample points, rad, (n,): those, and where between them a roller is pressed hardest."""
        return distinct(np.concatenate([self._sampled, self._hardest_angles]))

    @cached_property
    def _hardest_angles(self) -> Floats:
        """Cam angles, rad, at which pressure, force on a roller or width of its contact may be largest, (q,).

        Of contacts on a half-space as their slices tell; none of crowned rollers, which touch with a hair of one.
        """
        if self.crown is not None or (self._most_torque == 0.0 and self.preload <= 0.0):
            return np.zeros(0)
        owner = np.searchsorted(self.force.panels.breaks, self._sampled)
        each = self._extremes(self._first, self._first_loads[0])
        found = [brackets(self._sampled, owner, values, PEAKS) for values in each]
        which = np.repeat(np.arange(len(found)), [len(low) for low, _ in found])[:, None]
        size = np.abs(each.max(axis=1))[which]

        def asked(at: Floats) -> Floats:
            theta = np.concatenate([self._sampled[:1], at.ravel()])
            beside = self.beside.once(theta)
            values = self._extremes(beside, self._loads(beside)[0])[:, 1:].reshape(-1, *at.shape)
            return np.asarray(values[which[:, 0], np.arange(len(at))] / size)

        low, high = (np.concatenate(ends) for ends in zip(*found))
        return bracketed_maximum(asked, low, high, noise=GAIN)[1]

    def _extremes(self, e: Engagement, load: Floats) -> Floats:
        """What is largest where pressure, force on a roller and width of a contact are, (3, n), -inf without load.

        load  per length on both walls, N/mm, (2, n, k, m)

        Of a pressure it is -1 / (w k), of a width -k / w: smooth through the pole at which a wall is undercut.
        """
        pressed = load > 0.0
        w, k = np.where(pressed, load, 1.0), np.where(pressed & (e.curvature != 0.0), e.curvature, 1.0)
        each = (
            np.where(pressed, -1.0 / (w * k), -np.inf).max(axis=(0, 2, 3)),
            (load * e.cover).sum(axis=(0, 3)).max(axis=1),
            np.where(pressed & (k > 0.0), -k / w, -np.inf).max(axis=(0, 2, 3)),
        )
        return np.stack(each)

    @cached_property
    def _nodes(self) -> npt.NDArray[np.intp]:
        """Which of them are the panels'."""
        return np.searchsorted(self.theta, self.force.panels.theta.ravel())

    @cached_property
    def turret_torque(self) -> Floats:
        """Torque that the cam gives the turret, N mm, (n,)."""
        return self._torque_on(self.theta)

    @cached_property
    def engagement(self) -> Engagement:
        """The rollers beside the cam at every sample point."""
        return self.beside.at(self.theta, self._first)

    @cached_property
    def _first(self) -> Engagement:
        """The rollers beside the cam at the cam angles that are sampled first."""
        return self.beside.at(self._sampled)

    @cached_property
    def _most_torque(self) -> float:
        """Largest torque on the turret of those, N mm."""
        return float(np.abs(self._torque_on(self._sampled)).max(initial=0.0))

    def _torque_on(self, theta: Floats) -> Floats:
        """Torque that the cam gives the turret at cam angles (n,), N mm."""
        return self.force.panels.at(self.force.force, theta)

    @cached_property
    def loaded(self) -> npt.NDArray[np.intp]:
        """Sample points with a torque worth the name."""
        return np.flatnonzero(np.abs(self.turret_torque) > QUIET * self._most_torque)

    @shelved
    def line_load(self) -> Floats:
        """Load per length on the wall that bears, N/mm, (n, k, m). Raises DesignError where nothing can bear."""
        return np.asarray(self._on_walls[0].sum(axis=0))

    @property
    def level(self) -> Literal["line", "finite"]:
        """Which theory the contact is rated by: Hertz's line, or the half-space where ends, tilt or crown are stated.
        """
        return "finite" if self.ends.stated or self.crown is not None else "line"

    @property
    def _by_slices(self) -> bool:
        """Whether slices have gaps or a preload of their own, and press whichever wall they reach."""
        return self.preload > 0.0 or self.level == "finite"

    @shelved
    def _on_walls(self) -> tuple[Floats, Floats]:
        """`_loads` at the sample points: what is known at those that are sampled first is not computed again."""
        if len(self.theta) == len(self._sampled):
            return self._first_loads
        at, there = among(self._sampled, self.theta)
        fresh = np.flatnonzero(~there)
        load, approach = np.empty((2, *self.engagement.on.shape))
        for each, known, more in zip((load, approach), self._first_loads, self._loads(self.engagement, fresh)):
            each[:, there], each[:, fresh] = known[:, at[there]], more
        return load, approach

    @shelved
    def _first_loads(self) -> tuple[Floats, Floats]:
        """`_loads` at the cam angles that are sampled first."""
        return self._loads(self._first)

    def _loads(self, e: Engagement, rows: npt.NDArray[np.intp] | None = None) -> tuple[Floats, Floats]:
        """Load per length on both walls, N/mm, and approach without crown, run-out and tilt, mm, (2, n, k, m) each.

        rows  of the engagement, (n,), all without
        A slice presses one of them; without preload none presses where there is no torque.
        Raises DesignError where nothing can bear.
        """
        every = np.arange(len(e.theta)) if rows is None else rows
        load, approach = np.zeros((2, 2, len(every), *e.on.shape[2:]))
        torque = self._torque_on(e.theta[every])
        some = np.abs(torque) > QUIET * self._most_torque
        if not self._by_slices:
            if some.any():
                way = np.where(torque[some] >= 0.0, 0, 1)
                load[way, np.flatnonzero(some)] = self._along(e, way, every[some], np.abs(torque[some]))
            return load, approach
        some |= self.preload > 0.0
        load[:, some], approach[:, some] = self._shared(self.slices(e).rows(every[some]), torque[some])
        return load, approach + self._drop(e)[:, every]

    def _along(self, e: Engagement, way: npt.NDArray[np.intp], rows: npt.NDArray[np.intp], torque: Floats) -> Floats:
        """Load per length, N/mm, (q, k, m), on the walls of a direction (q,) at rows (q,) under torques (q,), N mm."""
        on = e.touches[way, rows]
        flat = on.reshape(len(rows), -1)
        if not flat.any(axis=1).all():
            at = degrees(float(e.theta[rows[int(np.argmin(flat.any(axis=1)))]]))
            raise DesignError(f"no roller can take the turret's torque at cam angle {at:.6g} deg: widen the cam")
        k = e.curvature[way, rows].reshape(flat.shape)
        radius = self.tracks[0].radii(e.place[way, rows]).reshape(flat.shape)
        shared = share_load(
            torque,
            np.zeros(flat.shape[1]),
            e.cover[way, rows].reshape(flat.shape),
            np.where(k > 0.0, np.where(flat, k, 1.0), 1.0 / radius),
            self.roller,
            self.cam,
            radius,
            2.0 * radius,
            np.where(flat, 0.0, FAR),
            cosines=np.where(flat, e.lever[way, rows].reshape(flat.shape), 1.0),
        )
        return np.where(flat, shared.line_load, 0.0).reshape(on.shape)

    def _shared(self, slices: Slices, torque: Floats) -> Floats:
        """Load per length of slices under torques (n,), N mm, and their approach less their gap, (2, 2, n, k, m)."""
        held, e = slices.held(torque), self._first
        shape = (len(torque), 2, len(e.places), len(e.stations))
        each = held.line_load, slices.preload + slices.lever * held.angle[:, None]
        return np.stack([np.moveaxis(one.reshape(shape), 0, 1) for one in each])

    @property
    def torque_line_load(self) -> float:
        """Of one roller that takes the largest torque at its middle, N/mm."""
        return self._most_torque / (float(np.abs(self._middles).min()) * self._length)

    def _drop(self, beside: Engagement) -> Floats:
        """Gap of the slices' middles by crown, run-out and tilt, mm, (2, n, k, m)."""
        if self.level == "line":
            return np.zeros(beside.on.shape)
        y, tilt = beside.place - self._middles[:, None], tan(self.ends.tilt)
        way = np.array([-tilt, tilt])[:, None, None, None]
        return np.asarray(self._profile.drop(np.clip(y, *self._profile.reach)) + way * y)

    @cached_property
    def _middles(self) -> Floats:
        """Middle of every roller's contact stretch along its axis (delta), mm, (k,): plates stand side by side."""
        return np.array([0.5 * sum(self.tracks[index].contact) for index, _ in self._first.places])

    @property
    def middle(self) -> float:
        """Of the roller whose contact is solved, mm along its axis (delta)."""
        return float(self._middles[0]) if self.finite is None else self.finite.middle

    @cached_property
    def _profile(self) -> AxialProfile:
        """Of a roller beside the cam with all of its length."""
        from camgeom.mechanics.finite_contact import AxialProfile

        half = 0.5 * self._length
        return AxialProfile(-half, half, self.crown or inf, self.ends.run_out, self.ends.radius, 2.0 * half)

    @cached_property
    def finite(self) -> FiniteTurret | None:
        """The contact on a half-space; None of a plain line, without load, and where a loaded wall is undercut."""
        if self.level == "line" or not self.line_load.any():
            return None
        self.paid()
        return self._finite(self.engagement, *self._on_walls)

    def _finite(self, e: Engagement, load: Floats, approach: Floats) -> FiniteTurret | None:
        """Of rollers under loads and approaches (2, n, k, m) at the cam angles of an engagement."""
        if np.any((load > 0.0) & (e.curvature <= 0.0)):
            return None
        from camgeom.mechanics.finite_turret import FiniteTurret, WallLoad

        back, ahead = (
            WallLoad(load[w], e.cover[w], e.place[w] - self._middles[:, None], e.curvature[w], approach[w])
            for w in (0, 1)
        )
        pair = pair_compliance(self.roller, self.cam)
        return FiniteTurret(
            e.theta, (back, ahead), self._middles, self._profile, pair, self.roller.compliance / pair,
            float(self.ends.mirrored), tan(self.ends.tilt), partial(self._twist, e.theta),
        )  # fmt: skip

    def _twist(self, theta: Floats, wall: int, at: tuple[int, int]) -> float:
        """Angle, rad, of a roller's axis at one of theta to its line of contact with a wall; 0 without a crown."""
        index, turn = self.engagement.places[at[1]]
        track, t = self.tracks[index], np.array([self.tracks[index].meridian.parameter(float(self._middles[at[1]]))])
        for side in track.sides if self.crown is not None else ():
            flank = Flank(track, theta[at[0] : at[0] + 1] + TURN * turn, t, side)
            if flank.behind == (wall == 0):
                line = flank.tangents[1][:, :, 0]
                square = dot(line, flank.pose.u[0]) ** 2 / dot(line, line)
                return float(np.arccos(np.sqrt(min(1.0, float(square[0])))))
        return 0.0

    @shelved
    def pressure(self) -> Floats:
        """Peak contact pressure of every slice, MPa, (n, k, m); infinite where it bears on a wall that it undercuts."""
        if self.finite is not None:
            return self.finite.pressure(self.tracks[0].meridian.jet(self.engagement.stations)[0] - self._middles[0])
        return self._as_line(self.line_load, self._walls(self.engagement.curvature))

    def _as_line(self, load: Floats, k: Floats) -> Floats:
        """Hertz's pressure, MPa, of loads per length, N/mm, on walls of relative curvature k, 1/mm; inf undercut."""
        pair, hollow = pair_compliance(self.roller, self.cam), k <= 0.0
        pressed = line_pressure(load, np.where(hollow, 1.0 / self._radius, k), pair)
        return np.where(hollow & (load > 0.0), np.inf, pressed)

    def pressure_at(self, track: int, phi: Floats, t: Floats, wall: npt.NDArray[np.intp]) -> Floats:
        """Peak pressure, MPa, (n, m), of the rollers of a track on a wall (n,), 0 that of a negative lever, else 1.

        phi  (n,) angles of a roller, counted through all its turns; at the nearest sample point
        t    (m,) meridian parameters; of the nearest slice
        Zero where another wall bears, or none.
        """
        turn, angle = np.floor_divide(phi, TURN).astype(int), np.mod(phi, TURN)
        after = np.clip(np.searchsorted(self.theta, angle), 1, len(self.theta) - 1)
        near = np.where(angle - self.theta[after - 1] < self.theta[after] - angle, after - 1, after)
        known = {place: k for k, place in enumerate(self.engagement.places)}
        roller = np.array([known.get((track, one), -1) for one in turn.tolist()])
        delta, middles = (self.tracks[0].meridian.jet(one)[0] for one in (t, self.engagement.stations))
        slices = np.abs(delta[:, None] - middles[None, :]).argmin(axis=1)
        if self._by_slices:
            bears = self._on_walls[0][wall, near, roller] > 0.0
            # On a half-space a roller touches further than its slices do.
            bears = bears if self.finite is None else bears.any(axis=1, keepdims=True)
        else:
            bears = (wall == np.where(self.turret_torque[near] >= 0.0, 0, 1))[:, None]
        found = np.where(bears, self.pressure[near, roller], 0.0)[:, slices]
        return np.asarray(np.where((roller >= 0)[:, None] & np.isfinite(found), found, 0.0))

    def _walls(self, values: Floats) -> Floats:
        """Values (2, n, k, m, ...) of the wall that a slice presses, else of the one that the torque's sign chooses."""
        chosen = np.where(self.turret_torque >= 0.0, 0, 1)
        picked = np.asarray(values[chosen, np.arange(len(self.theta))])
        if not self._by_slices:
            return picked
        more = (1,) * (values.ndim - 4)
        for wall in (0, 1):
            pressed = self._on_walls[0][wall] > 0.0
            picked = np.where(pressed.reshape(*pressed.shape, *more), values[wall], picked)
        return picked

    @cached_property
    def roller_load(self) -> Floats:
        """Normal force on every roller, N, (n, k)."""
        return np.asarray((self.line_load * self._cover).sum(axis=2))

    def pressed(self, index: int) -> tuple[Floats, Floats, Floats, Floats]:
        """The pressed slices on the cam at a sample point: points (p, 3), mm, normals into the cam (p, 3), forces along
        them (p,), N, and per length (p,), N/mm."""
        e, way = self.engagement, 0 if self.turret_torque[index] >= 0.0 else 1
        loads = np.zeros(e.cover[:, index].shape)
        if self._by_slices:
            loads[:] = self._on_walls[0][:, index]
        else:
            loads[way] = self.line_load[index]
        each = [one for _, one in self._contacts(e, index, loads)]
        points, inward, sizes, density = (np.concatenate([one[k] for one in each]) for k in range(4))
        return points, inward, sizes, density

    def stirred(self, theta: Floats) -> list[list[tuple[float, tuple[Floats, Floats, Floats, Floats]]]]:
        """Every contact of a roller and a wall that presses at cam angles (n,), rad, in rising order: its stiffness, N
        mm/rad, and the same of what a turn of 1 rad of the turret would add there.

        Raises DesignError where no roller can bear.
        """
        e = self.beside.once(theta)
        slices = self.slices(e)
        rate = slices.rates(slices.held(self.torque_at(theta, self.preload > 0.0)).line_load)
        shape = (2, len(e.places), len(e.stations))
        return [self._contacts(e, i, one.reshape(shape)) for i, one in enumerate(rate)]

    def _contacts(
        self, e: Engagement, index: int, loads: Floats
    ) -> list[tuple[float, tuple[Floats, Floats, Floats, Floats]]]:
        """Torque, N mm, and `pressed` of every contact with line loads (2, k, m), N/mm, at one cam angle."""
        found = []
        for place, (number, turn) in enumerate(e.places):
            track, phi = self.tracks[number], e.theta[index : index + 1] + TURN * turn
            for side in track.sides if track.span[0] <= phi[0] <= track.span[1] else ():
                wall = 0 if Flank(track, phi, e.stations, side).behind else 1
                t = track.meridian.parameters(e.place[wall, index, place])
                line = loads[wall, place]
                force = line * e.cover[wall, index, place]
                some = force != 0.0
                if some.any():
                    torque = abs(float((force * e.lever[wall, index, place]).sum()))
                    x = Flank(track, phi, t, side).x[:, 0].T
                    found.append((torque, (x[some], e.normal[wall, index, place][some], force[some], line[some])))
        return found

    @cached_property
    def _cover(self) -> Floats:
        """Length of every slice that has the wall it presses, mm, (n, k, m)."""
        return self._walls(self.engagement.cover)

    @cached_property
    def shaft_force(self) -> Floats:
        """Resultant of the rollers on the cam across its axis, N, (n,)."""
        normal = self._walls(self.engagement.normal)
        total = (normal * (self.line_load * self._cover)[..., None]).sum(axis=(1, 2))
        return np.asarray(np.hypot(total[:, 0], total[:, 1]))

    @cached_property
    def torque(self) -> Floats:
        """Torque that the cam takes from its shaft, N mm, (p, n)."""
        return self.force.camshaft_torque()

    def slices(self, beside: Engagement) -> Slices:
        """The slices of the rollers that may press, preloaded, at the cam angles of an engagement."""
        return Slices.of(beside, self.preload, self.roller, self.cam, self._drop(beside))

    def stiffness_table(self, estimate: Estimate = "half-space") -> tuple[float, ...]:
        """Torsional stiffness between cam and turret, N m/rad, at COUNT equal steps of a turn from cam angle zero.

        Under the turret's own torque. Raises DesignError where no roller can bear.
        """
        step = TURN / COUNT
        theta = (np.arange(COUNT * WITHIN) - WITHIN // 2) * step / WITHIN
        slices = self.slices(self.beside.once(theta))
        held = slices.held(self.torque_at(theta, self.preload > 0.0))
        each = MILLI * slices.stiffness(held.line_load, estimate)
        return tuple(float(value) for value in each.reshape(COUNT, WITHIN).mean(axis=1))

    def torque_at(self, theta: Floats, preloaded: bool) -> Floats:
        """Torque on the turret, N mm, (n,), at cam angles (n,), without preload at least LEAST of the largest."""
        torque = self.force.panels.at(self.force.force, np.mod(theta, TURN))
        largest = float(np.abs(self.turret_torque).max(initial=0.0))
        if largest == 0.0:
            cause = "the turret has no torque to press its rollers on the cam"
            raise DesignError(f"{cause}: give its inertia or a friction")
        if preloaded:
            return np.asarray(torque)
        return np.asarray(np.where(torque >= 0.0, 1.0, -1.0) * np.maximum(np.abs(torque), LEAST * largest))

    @cached_property
    def passes_per_hour(self) -> float:
        """How often a roller runs through the cam in an hour: once in a turret turn, or in each cam turn to and fro."""
        turns = self.speed / TURN * 3600.0
        advance = abs(self.tracks[0].program.advance)
        return turns * advance / TURN if advance else turns

    def _on_roller(self, values: Floats) -> Floats:
        """Values of the slices (n, k, m), where they come to the same places of the roller again and again: the end of
        a wall that holds a part of it counts for the slice that it lies in, if as the larger."""
        if self.beside.graded:
            return values
        place, out = self._walls(self.engagement.place), values.copy()
        stations = self.tracks[0].meridian.jet(self.engagement.stations)[0]
        between = 0.5 * (stations[2:-1] + stations[1:-2])
        for end, own in ((0, 1), (-1, len(stations) - 2)):
            lies = 1 + np.searchsorted(between, place[..., end])
            n, k = np.nonzero((lies != own) & (values[..., end] > 0.0))
            m = lies[n, k]
            out[n, k, m] = np.maximum(out[n, k, m], values[n, k, end])
            out[n, k, end] = 0.0
        return out

    def _passage(self, weight: Floats) -> Floats:
        """Integral over a roller's whole passage of weight (n, k, ...) d(path), one row for each roller's path, mm."""
        return self._through(weight * self.path_rate.reshape(*self.path_rate.shape, *([1] * (weight.ndim - 2))))

    def _through(self, rate: Floats) -> Floats:
        """Integral over a roller's whole passage of what goes on per rad, (n, k, ...), one row for each roller's path.

        Tracks of one name are walls that one roller meets.
        """
        where = self.force.panels
        shaped = np.moveaxis(rate[self._nodes].reshape(*where.theta.shape, *rate.shape[1:]), (0, 1), (-2, -1))
        whole = where.integral(shaped)
        names = [self.tracks[t].name for t, _ in self.engagement.places]
        rows = [[p for p, n in enumerate(names) if n == name] for name in dict.fromkeys(names)]
        return np.stack([whole[r].sum(axis=0) for r in rows])

    @cached_property
    def path_rate(self) -> Floats:
        """Path that each roller's rim turns by at the middle of its length, mm/rad, (n, k), >= 0."""
        return np.asarray(self._radius * np.abs(self.turning))

    @cached_property
    def turning(self) -> Floats:
        """Turning of each roller about its pin, rad/rad, signed, (n, k).

        A slice whose wall asks for another turning slides. The friction mu N r of the slices that are dragged on equals
        that of those that are held back (a free bearing): the roller turns as the weighted median of its slices, each
        as wide as its weight and straight from middle to middle, on both walls where a preload presses both. Without
        load, as the middle slice beside the wall that the torque
        chooses, or beside the other one where that is the one it has.
        """
        e, radii = self.engagement, self.tracks[0].meridian.jet(self.engagement.stations)[3]
        if self._by_slices:
            weight, turning = (
                np.concatenate(list(v), axis=-1) for v in (self._on_walls[0] * e.cover * radii, e.turning)
            )
        else:
            weight, turning = self.line_load * self._cover * radii, self._walls(e.turning)
        order = np.argsort(np.where(weight > 0.0, turning, np.inf), axis=-1)
        turning, weight = (np.take_along_axis(values, order, axis=-1) for values in (turning, weight))
        total = np.cumsum(weight, axis=-1)
        middles, half = total - 0.5 * weight, 0.5 * total[..., -1:]
        first = np.maximum((middles <= half * (1.0 + 1e-12)).sum(axis=-1, keepdims=True) - 1, 0)
        after = np.minimum(first + 1, np.maximum((weight > 0.0).sum(axis=-1, keepdims=True) - 1, 0))
        below, above = (np.take_along_axis(middles, at, axis=-1) for at in (first, after))
        slower, faster = (np.take_along_axis(turning, at, axis=-1) for at in (first, after))
        share = np.divide(half - below, above - below, out=np.zeros_like(half), where=above > below)
        way, rows = np.where(self.turret_torque >= 0.0, 0, 1), np.arange(len(self.theta))
        there, beside = ((e.cover[wall, rows] > 0.0).any(axis=-1) for wall in (way, 1 - way))
        chosen, other = (e.turning[wall, rows][..., len(radii) // 2] for wall in (way, 1 - way))
        free = np.where(beside & ~there, other, chosen)
        pressed = (slower + share * (faster - slower))[..., 0]
        return np.asarray(np.where(total[..., -1] > 0.0, pressed, free))

    @cached_property
    def _runs(self) -> tuple[Floats, Floats, Floats]:
        """Of every slice on the wall that it presses, mm/rad, (n, k, m) each: mean speed of both surfaces through the
        contact, the contact's along the cam, and sliding, round the roller and along its axis."""
        on_cam, axial = (self._walls(values) for values in self.engagement.runs)
        wanted = self._walls(self.engagement.turning)
        radii = self.tracks[0].radii(self._walls(self.engagement.place))
        # A roller that turns faster than a slice rolls carries more oil in, whichever way it turns.
        slip = (self.turning[..., None] - wanted) * radii * np.where(wanted >= 0.0, 1.0, -1.0)
        return np.abs(on_cam + 0.5 * slip), on_cam, np.hypot(slip, axial)

    @cached_property
    def _path(self) -> Floats:
        """Path rolled by a roller in one passage while it touches a wall, mm, one for each track."""
        return self._passage((self.engagement.cover > 0.0).any(axis=(0, 3)).astype(float))

    @cached_property
    def bearing(self) -> BearingLife | None:
        """Life of the worst roller's bearing (equation 37, ISO 281); None where it has no rating."""
        if self.rating is None:
            return None
        power = self.rating.kind.exponent
        largest, zero = self.roller_load.max(initial=0.0), np.zeros(())
        safety = static_safety(self.rating.static, np.asarray(largest))
        if largest == 0.0:
            return modified(BearingLife(np.asarray(np.inf), zero, zero, safety, peak_speed=zero), self.rating)
        mean = largest * (self._passage((self.roller_load / largest) ** power) / self._path) ** (1.0 / power)
        omega = self._path / self._radius * self.passes_per_hour / 3600.0
        fastest = self.path_rate.max(initial=0.0) * self.speed / self._radius
        basic = rated_hours(self.rating.dynamic, mean, omega, power)
        each = modified(BearingLife(basic, mean, omega, None), self.rating)
        judged = each.life_h if each.rated_h is None else each.rated_h
        worst = int(np.argmin(judged))
        return BearingLife(
            each.life_h.min(), mean.max(), omega.max(), safety, judged[worst],
            None if each.ratio is None else each.ratio[worst], None if each.factor is None else each.factor[worst],
            np.asarray(fastest),
        )  # fmt: skip

    @cached_property
    def _radius(self) -> float:
        """Roller radius at the middle of the contact, mm."""
        return float(self.tracks[0].meridian.jet(self._first.stations)[3][len(self._first.stations) // 2])

    @cached_property
    def slice_life(self) -> Floats:
        """Fatigue life of the roller surface at every slice, h, (m,), of the hardest used roller.

        Miner's sum of a passage, shared by all points round the roller: it comes to each passage at another angle of
        its own, so that its points take turns.
        """
        limit, m = self.roller.contact_limit, self.roller
        folded = np.isinf(self.pressure)
        weight = (np.where(folded, 0.0, self.pressure) / limit) ** m.exponent
        damage = self._passage(self._on_roller(weight)).max(axis=0)
        damage = damage / (TURN * self._radius * m.contact_cycles) * self.passes_per_hour
        life = np.where(damage > 0.0, 1.0 / np.where(damage > 0.0, damage, 1.0), np.inf)
        return np.where(folded.any(axis=(0, 1)), 0.0, life)

    @property
    def roller_life(self) -> float:
        """Fatigue life of the roller surface, h: of its hardest pressed slice."""
        return float(self.slice_life.min())

    @cached_property
    def cam_life(self) -> float:
        """Fatigue life of the cam's walls, h: each point is met once in a cam turn."""
        m = self.cam
        return float(hours((self.least_peak.value / m.contact_limit) ** m.exponent / m.contact_cycles, self.speed))

    @property
    def lives(self) -> dict[str, float]:
        """Fatigue life, h, of roller, cam and the roller's bearing; no surface's where a sharp end bears."""
        lives = {} if self.no_stress else {"roller": self.roller_life, "cam": self.cam_life}
        return lives if self.bearing is None else lives | {"bearing": self.bearing.judged_h}

    def film(self, oil: Oil) -> Film | None:
        """The film of the thinnest slice of all rollers; None without load and where a wall is undercut."""
        from camgeom.mechanics.film import line_film, thinnest

        if np.isinf(self.pressure).any() or self.no_stress:
            return None
        bears = self.line_load > QUIET * self.line_load.max(initial=0.0)
        k = self._walls(self.engagement.curvature)
        speed = self.speed * self._runs[0]
        thick = line_film(
            speed, np.where(bears, k, 1.0), np.where(bears, self.line_load, 1.0), oil,
            pair_compliance(self.roller, self.cam),
        )  # fmt: skip
        ratio = np.where(bears, thick / oil.roughness, np.inf).reshape(len(self.theta), -1)
        m = np.argmin(ratio, axis=1)[:, None]
        place = self._walls(self.engagement.place).reshape(ratio.shape)
        return thinnest(self.theta, np.take_along_axis(ratio, m, 1)[:, 0], oil,
                        place=np.take_along_axis(place, m, 1)[:, 0])  # fmt: skip

    @cached_property
    def _rubbed_load(self) -> Floats:
        """Line load times sliding of every slice, N/rad, (n, k, m)."""
        return np.asarray(self.line_load * self._runs[2])

    @cached_property
    def rubbed(self) -> float:
        """Load times sliding way of all rollers over a turn, N mm."""
        width = self._cover
        if not self.beside.graded:
            inner = width[..., 1:-1]
            width = slice_shares(inner.shape[-1]) * np.concatenate([inner[..., :1], inner, inner[..., -1:]], axis=-1)
        total = (self._rubbed_load * width).sum(axis=(1, 2))[self._nodes]
        return float(self.force.panels.integral(total.reshape(self.force.panels.theta.shape)))

    @cached_property
    def rubbing(self) -> dict[str, float]:
        """Load per width times sliding way that passes a point of cam and roller, N/mm; see `Duty.rubbing`."""
        work, on_cam = self._rubbed_load, self._runs[1]
        passed = np.divide(work, on_cam, out=np.zeros_like(work), where=on_cam > 0.0)
        # A roller's own share of the turns of the cam; the next turn is another roller's.
        turns = self.speed / TURN * 3600.0
        radii = self.tracks[0].meridian.jet(self.engagement.stations)[3]
        through = self._through(self._on_roller(work)) / (TURN * radii)
        roller = through.max(initial=0.0) * self.passes_per_hour / turns
        return {"roller": float(roller), "cam": float(passed.max())}

    @cached_property
    def contact_forces(self) -> Floats:
        """Normal force of every roller, N, (k, p, n)."""
        return np.moveaxis(self.roller_load[self._nodes].reshape(*self.force.force.shape, -1), -1, 0)

    @cached_property
    def peak_force(self) -> Extreme:
        """Largest normal force on a roller, N."""
        at = int(np.argmax(self.roller_load.max(axis=1)))
        return Extreme(float(self.roller_load[at].max()), float(self.theta[at]))

    @cached_property
    def _hardest(self) -> tuple[int, int, int]:
        """Sample point, roller and slice of the largest pressure."""
        n, k, m = np.unravel_index(int(np.argmax(self.pressure)), self.pressure.shape)
        return int(n), int(k), int(m)

    @property
    def hardest_contact(self) -> tuple[int, float, int]:
        """Track, angle, rad, counted through all turns of its roller, and wall (as in `pressure_at`) of the largest
        pressure."""
        n = int(np.abs(self.theta - self.least_peak.cam_angle).argmin())
        k = int(self.pressure[n].max(axis=-1).argmax())
        wall = 0 if self.turret_torque[n] >= 0.0 else 1
        if self._by_slices:
            wall = int(self._on_walls[0][:, n, k].max(axis=-1).argmax())
        track, turn = self.engagement.places[k]
        return track, turn * TURN + float(self.theta[n]), wall

    @property
    def no_stress(self) -> str:
        """Why no largest pressure can be given, and what to give so that it can; empty where there is one."""
        return "" if self.finite is None else self.finite.no_stress

    @property
    def squared(self) -> tuple[str, TurretDuty] | None:
        """The key of the rollers' tilt, and the duty without it; None of rollers that stand square."""
        ends = self.ends
        return (TILT.format("roller"), replace(self, ends=replace(ends, tilt=0.0))) if ends.tilt else None

    @cached_property
    def square_spot(self) -> float | None:
        """Pressure, MPa, at the hardest cam angle, were all rollers square to their flanks; None where none is tilted.

        Where the torque alone presses them, which a tilt that wedges its roller in the groove may exceed by far. Of
        rollers whose ends are not stated either it is that of the line, as by their profile without the tilt.
        """
        if self.finite is None or self.squared is None:
            return None
        from camgeom.mechanics.finite_turn import pressure_of

        # The preload is set in the dwell at cam angle zero.
        theta = np.array([0.0, self.least_peak.cam_angle])
        square, at = self.squared[1], self.beside.once(theta)
        load, approach = square._shared(square.slices(at), self._torque_on(theta))
        if square.level == "line":
            return float(square._as_line(load, at.curvature)[:, 1].max())
        at, load = self.beside.once(theta[1:]), load[:, 1:]
        found = square._finite(at, load, approach[:, 1:] + square._drop(at))
        return inf if found is None else pressure_of(found.most_loaded)

    @cached_property
    def least_peak(self) -> Extreme:
        """The largest pressure; where a sharp end bears that half a millimetre inside, no peak, but a bound of one."""
        if self.finite is not None:
            return self.finite.hardest[0]
        n, k, m = self._hardest
        delta = float(self._walls(self.engagement.place)[n, k, m])
        return Extreme(float(self.pressure.max(initial=0.0)), float(self.theta[n]), delta)

    @cached_property
    def contact_length(self) -> float:
        """Length of the hardest pressed roller that touches where the pressure is largest, mm."""
        if self.finite is not None:
            return self.finite.hardest[1].length
        n, k, _ = self._hardest
        return float(self._cover[n, k].sum())

    @cached_property
    def least_touching(self) -> Extreme:
        """Least length of a roller that touches while it is pressed, mm; the whole length without any force."""
        pressed = self.roller_load > QUIET * self.roller_load.max(initial=0.0)
        length = np.where(pressed, self._cover.sum(axis=2), np.inf)
        n, k = np.unravel_index(int(np.argmin(length)), length.shape)
        return Extreme(min(float(length[n, k]), self._length), float(self.theta[n]))

    @property
    def _length(self) -> float:
        """Contact length of a roller, mm."""
        return self._first.length

    @cached_property
    def peak_contact(self) -> Beneath | None:
        """Half-width and subsurface shear of the hardest contact; None where a wall is undercut."""
        if self.finite is not None:
            return None if self.no_stress else Beneath(*self.finite.hardest[1].beneath(self.cam.poisson))
        pressure = float(self.pressure[self._hardest])
        if pressure == np.inf:
            return None
        k = float(self._walls(self.engagement.curvature)[self._hardest])
        return beneath_line(pressure, k if k > 0.0 else 1.0, pair_compliance(self.roller, self.cam))

    @cached_property
    def deepest_shear(self) -> Extreme | None:
        """Where the largest shear lies deepest over the turn, all rollers and slices, mm; None where one undercuts."""
        if np.isinf(self.pressure).any():
            return None
        if self.finite is not None:
            below = self.peak_contact
            return None if below is None else replace(self.least_peak, value=below.shear_depth)
        k = self._walls(self.engagement.curvature)
        depth = line_depth(self.pressure, np.where(k > 0.0, k, 1.0), pair_compliance(self.roller, self.cam))
        n, *at = np.unravel_index(int(np.argmax(depth)), depth.shape)
        place = float(self._walls(self.engagement.place)[(n, *at)])
        return Extreme(float(depth.max(initial=0.0)), float(self.theta[n]), place)

    def spot(self, at: Extreme) -> str:
        """A place on the rollers, in words, and how much of the hardest pressed one touches."""
        n = int(np.argmin(np.abs(self.theta - at.cam_angle)))
        touching = float(self._cover[n, int(np.argmax(self.pressure[n].max(axis=1)))].sum())
        share = f", {touching:.4g} of {self._length:.4g} mm touch" if touching < (1.0 - 1e-4) * self._length else ""
        return f"at {at.place:.4g} mm along the roller axis{share}"

    @property
    def preload_pressure(self) -> float:
        """Contact pressure that the preload alone gives in the dwell, MPa."""
        if self.preload <= 0.0:
            return 0.0
        e = self.engagement
        touches = e.touches[:, 0]
        k, radius = e.curvature[:, 0][touches], self.tracks[0].radii(e.place[:, 0][touches])
        load = np.ones(len(k))
        for _ in range(60):
            load = self.preload / line_flexibility(load, k, self.roller, self.cam, radius, 2.0 * radius)
        return float(line_pressure(load, k, pair_compliance(self.roller, self.cam)).max())

    def contact_data(self) -> dict[str, Any]:
        """Pressure, force, torque, and what shaft and studs see, as plain data for result.json."""
        middle = self.pressure[:, :, self.pressure.shape[2] // 2].max(axis=1)
        k_rel = float(self._walls(self.engagement.curvature)[self._hardest])
        carrying = (self.roller_load[self.loaded] > 0.0).sum(axis=1)
        limit, hardest = min(self.roller.rated_limit, self.cam.rated_limit), self.peak_pressure
        return {
            "contact_level": self.level,
            **(inside_data(self.least_peak) if hardest is None else {
                "peak_pressure_mpa": finite(middle.max()),
                "cam_angle_deg": degrees(float(self.theta[int(np.argmax(middle))])),
            }),
            "peak_force_n": self.peak_force.value,
            **(slice_data(hardest) if hardest is not None else {}),
            **length_data(self.contact_length, self.least_touching),
            **hertz_data(self.peak_contact, self.deepest_shear),
            **({} if self.finite is None else patch_data(self.finite.hardest[1], self.finite.stiffness, self.middle)),
            **({} if self.level == "finite" else {
                "allowable_force_n": (
                    float(allowable_load(limit, k_rel, self.contact_length, pair_compliance(self.roller, self.cam)))
                    if k_rel > 0.0 else 0.0
                ),
                "preload_pressure_mpa": self.preload_pressure,
            }),
            "rollers_sharing_least": int(carrying.min()) if len(carrying) else 0,
            "rollers_sharing_most": int(carrying.max()) if len(carrying) else 0,
            "peak_turret_torque_n_m": float(np.abs(self.turret_torque).max()) * MILLI,
            **torque_data(self.peak_torque, self.work),
            **self._supports(self._length),
        }

    def _supports(self, length: float) -> dict[str, Any]:
        """Stresses of stud and shaft, with the dimensions they are taken at."""
        stud = STUD_SHARE * 2.0 * self._radius
        data: dict[str, Any] = {
            "stud_diameter_mm": stud,
            "stud_stress_mpa": float(stud_stress(self.peak_force.value, 0.5 * length, stud).mises),
        }
        if self.bore > 0.0:
            moment = span_moment(self.shaft_force.max(), *(0.5 * SPAN_SHARE * self.width,) * 2)
            data["shaft_bearing_distance_mm"] = SPAN_SHARE * self.width
            data["shaft_stress_mpa"] = float(shaft_stress(moment, self.peak_torque.value, self.bore).mises)
        return data

    def fatigue_data(self) -> dict[str, Any]:
        """Lives of roller and cam as plain data; of surfaces that a sharp end presses the path rolled alone."""
        if self.no_stress:
            return {"path_per_turn_m": self.path_per_turn * MILLI}
        return {
            "roller_life_h": finite(self.roller_life),
            "roller_slice_life_h": finite(self.roller_life),
            "hot_spot_deg": degrees(self.least_peak.cam_angle),
            "cam_life_h": finite(self.cam_life),
            "cam_slice_life_h": finite(self.cam_life),
            "path_per_turn_m": self.path_per_turn * MILLI,
        }

    @property
    def path_per_turn(self) -> float:
        """Path that a roller rolls in a turn of the cam, mm, the longest of all."""
        return float(self._path.max()) * self.passes_per_hour / (self.speed / TURN * 3600.0)
