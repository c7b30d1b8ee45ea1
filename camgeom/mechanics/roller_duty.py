"""What the cam has to do: force, contact stress, life and torque, computed on the flank's own geometry.

One roller on one track (two walls, behind and ahead of it). Everything lives on panels of the cam angle on which it is
smooth, so peaks, reversals and the hot spot are found to rounding, not to a sampling step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import degrees, inf, sin, tan
from typing import TYPE_CHECKING, Any, Literal, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import TURN, highest
from camgeom.mechanics.contact import Contact, PressurePeak, Stiffness, line_contacts, share_load
from camgeom.mechanics.duty import (
    MILLI,
    TILT,
    Duty,
    Meeting,
    finite,
    free,
    hertz_data,
    inside_data,
    length_data,
    patch_data,
    peak_of,
    slice_data,
    slice_shares,
    torque_data,
)
from camgeom.mechanics.hertz import Beneath, beneath_line, beneath_point, line_depth, line_flexibility
from camgeom.mechanics.life import CamLife, RollerLife, cam_life, roller_life
from camgeom.mechanics.load import QUIET, FollowerForce, Load
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.mechanics.pressing import SLICES, Pressing, StationWalls
from camgeom.track import Track
from camgeom.track.flank import Flank
from camgeom.track.follower import PLAIN, Ends
from camgeom.track.runout import Within

if TYPE_CHECKING:
    from camgeom.mechanics.bearing import BearingLife
    from camgeom.mechanics.crown import Crown
    from camgeom.mechanics.film import Film, Oil
    from camgeom.mechanics.finite_turn import FiniteTurn
    from camgeom.mechanics.groove import Convention
    from camgeom.mechanics.kept import Kept
    from camgeom.mechanics.rating import Rating

LEAST_PRESSURE = 1e-9
"""MPa; below it nothing presses"""
ENDING = 0.02
"""share of a roller that counts as nothing where it is pressed beyond the end of its wall too"""
WITHIN = 41
"""places along the longest ellipse of a crown at which it slides"""


@final
@immutable
class RollerDuty(Duty):
    """One roller under load over one turn.

    track   the roller's track; `station` its meridian parameter at the middle of the contact, where force and path are
    at      meridian parameter where the classical figures are quoted; None: at the station
    load    what acts on the follower
    crown   radius of the meridian, mm, of a crowned roller on a straight flank, which the track's cylinder cuts: it
            touches at its crest, the station; None: the flank is the roller's own envelope
    rating  of the roller's bearing; None where it is not known
    ends    how the roller ends and how it stands against the flank
    beside  which contact points (3, ...) have a wall; None where the whole contact stretch always has one
    runs_out  True where the roller leaves the cam on purpose: nothing presses it where it has no wall
    table   of the profile that has the roller
    alone   True where this roller alone holds the follower on a cam that pushes one way, and no `Touch` tells of it
    passes  over a place of the cam in one turn of its drive: of several each counts as the hardest of them
    paid    raises NotConverged where contacts on a half-space would take too long
    lag     cam angle, rad, after which it meets what the first roller on its wall met; None where it is alone there
    """

    track: Track
    station: float
    length: float
    load: Load
    roller: Material
    cam: Material
    crown: float | None = None
    rating: Rating | None = None
    beside: Within | None = None
    runs_out: bool = False
    alone: bool = False
    ends: Ends = PLAIN
    table: str = "roller"
    passes: float = 1.0
    lag: float | None = None
    at: float | None = None
    paid: Callable[[], None] = free

    @property
    def speed(self) -> float:
        """Cam speed, rad/s."""
        return self.load.omega

    @cached_property
    def pressing(self) -> Pressing:
        """The walls that it presses, along how much of its length, and the force on them."""
        pair = pair_compliance(self.roller, self.cam)
        return Pressing(self.track, self.station, self.length, self.load, pair, self.crown is not None, self.ends,
                        self.beside, self.runs_out)  # fmt: skip

    @cached_property
    def quoted(self) -> Pressing:
        """The same with all of the force at the place where the classical figures are quoted."""
        return self.pressing if self.at is None else replace(self.pressing, station=self.at)

    @cached_property
    def crowned(self) -> Crown | None:
        """The ellipse under its crown; None without one."""
        if self.crown is None:
            return None
        from camgeom.mechanics.crown import Crown

        return Crown(self.pressing, self.crown, self.ends.tilt)

    @property
    def force(self) -> FollowerForce:
        """Motion and force of the follower on panels; what this track's walls can give."""
        return self.pressing.force

    @property
    def unheld(self) -> Extreme | None:
        """Largest force on the follower, N (N mm), that presses where no wall is; None where a wall is all round."""
        return self.pressing.unheld

    @property
    def normal(self) -> Floats:
        """Signed normal force on the roller, N, (p, n); positive on the wall behind."""
        return self.pressing.normal

    @property
    def least_touching(self) -> Extreme:
        """Least length of it that touches where a force presses, mm; the whole length without any force."""
        return self.pressing.least_touching

    @property
    def radius(self) -> float:
        """Roller radius in the middle of the contact, mm."""
        return self.pressing.radius

    @cached_property
    def contact(self) -> Contact:
        """Contact at the quoted station with the exact curvature: a crown touches in an ellipse, else it is a line.

        On a half-space that at the hardest place; under a tilted crown that where it touches.
        """
        if self.finite is not None:
            hardest = int(np.abs(self.pressing.middle + self.finite.places - self.least_peak.place).argmin())
            return self._finite_contact(self.finite.squares[hardest])
        if self.crowned is None:
            return self.quoted.as_line
        delta = float(self.track.meridian.jet(np.array([self.station]))[0][0])
        return self.crowned.contact((delta if self.ends.tilt == 0.0 else self.crowned.crest) - self.crowned.crest)

    @cached_property
    def level(self) -> Literal["line", "ellipse", "finite"]:
        """Which theory the contact is rated by: the exact line, the exact ellipse, or the half-space.

        The last where a crown's ellipse is longer than its room anywhere that it presses, and where it is stated how a
        roller without a crown ends or stands. A crown that is tilted within its room keeps its ellipse.
        """
        if self.crowned is None:
            return "finite" if self.ends.stated and self.normal.any() else "line"
        return "finite" if self.crowned.fullest.value > 1.0 else "ellipse"

    @cached_property
    def finite(self) -> FiniteTurn | None:
        """The contact on a half-space over the turn; None at the other levels, and where a wall is undercut."""
        if self.level != "finite" or not self.pressing.as_line.sound:
            return None
        self.paid()
        from camgeom.mechanics.crown import NEXT_TO_NONE
        from camgeom.mechanics.finite_contact import AxialProfile, Bodies
        from camgeom.mechanics.finite_turn import FiniteTurn

        k, load = self.pressing.curvature, np.abs(self.normal)
        at = np.unravel_index(int(np.argmax(load * k)), load.shape)
        low, high = (float(end[at]) - self.pressing.middle for end in self.pressing.stretch)
        if high - low < NEXT_TO_NONE * self.length:
            return None
        profile = AxialProfile(low, high, self.crown or inf, self.ends.run_out, self.ends.radius, self.length)
        twist = 0.0 if self.crown is None else float(np.arccos(np.sqrt(min(1.0, self.pressing.alignment[at]))))
        pair = pair_compliance(self.roller, self.cam)
        gap, own = tan(self.ends.tilt), self.roller.compliance / pair
        walls = {
            wall: Bodies(float(k[at]), profile, pair, -wall * gap, twist, own, float(self.ends.mirrored))
            for wall in (1, -1)
            if bool((wall * self.normal > 0.0).any())
        }
        return FiniteTurn(self.force.panels, self.normal, k, walls)

    def _finite_contact(self, square: Floats) -> Contact:
        """Contact of bins along the roller on a half-space, from their squared pressures (..., p, n)."""
        load = np.pi * self.pressing.pair * square / self.pressing.curvature * np.sign(self.normal)
        return self.pressing.rated(square, load)

    @property
    def no_stress(self) -> str:
        """Why no largest pressure can be given, and what to give so that it can; empty where there is one."""
        if self.finite is None:
            return ""
        from camgeom.mechanics.finite_turn import without_peak

        return without_peak(self.finite.hardest[1], self.table)

    @property
    def squared(self) -> tuple[str, RollerDuty] | None:
        """The key of the roller's tilt, and the duty without it; None of a roller that stands square."""
        ends = self.ends
        return (TILT.format(self.table), replace(self, ends=replace(ends, tilt=0.0))) if ends.tilt else None

    @cached_property
    def square_spot(self) -> float | None:
        """Pressure, MPa, of the hardest contact, were its roller square to its flank; None where no tilt is solved.

        Of a roller whose ends are not stated either it is that of the line, as by its profile without the tilt.
        """
        if self.finite is None or self.squared is None:
            return None
        without = self.squared[1]
        if without.level == "line":
            return without._at(without.hardest_pressure, self.least_peak.cam_angle)
        from camgeom.mechanics.finite_turn import square

        return square(self.finite.hardest[1])

    @cached_property
    def least_peak(self) -> Extreme:
        """Pressure half a millimetre inside of a sharp end that bears, MPa, at its place: no peak, but a bound of one.

        Where none bears it is the largest pressure.
        """
        if self.finite is None:
            return self._hardest_slice
        found = self.finite.hardest[0]
        return replace(found, place=self.pressing.middle + found.place, where="")

    def conventions(self, pitch_radius: float) -> dict[Convention, tuple[PressurePeak, RollerLife]]:
        """Peak pressure and roller life under the curvature conventions of the literature, at the pitch radius, mm.

        Of a cylindrical roller on a translating follower, in the groove of a drum.
        """
        from camgeom.mechanics.groove import CONVENTIONS, groove_contact

        answers = {}
        for name in CONVENTIONS:
            contact = groove_contact(
                self.force, pitch_radius, self.radius, self.length, self.roller, self.cam, name,
                self.load.guide_friction,
            )  # fmt: skip
            answers[name] = (contact.peak(), roller_life(contact, self.roller, self.radius, self.speed))
        return answers

    @cached_property
    def slices(self) -> Contact:
        """Contact in the middle of SLICES equal slices of the length that touches, of a line at its ends too; a
        leading axis (m,).

        Lines that approach alike where the flank is the roller's own envelope, slices of the ellipse under a crown.
        A slice is a share of that length: where the length changes it wanders along the roller, a little. An end bears
        the load per length that its approach gives it, and no force, since it has no width.
        """
        if self.finite is not None:
            return self._finite_contact(self.finite.squares)
        if self.crowned is not None:
            return self.crowned.contact(self.slice_places - self.crowned.crest)
        walls, press, force = self._slices, self.pressing, self.pressing.pushed
        behind, ahead, lever = (np.ascontiguousarray(np.moveaxis(one, 0, -1))
                                for one in (walls.behind, walls.ahead, walls.lever))  # fmt: skip
        k = np.where(force[..., None] >= 0.0, behind, ahead)
        radius = np.moveaxis(self.track.radii(self.slice_places), 0, -1)
        bare = (press.touching <= 0.0)[..., None]
        if np.any(bare & (force != 0.0)[..., None]):
            # Beside its end a wall is so short that there is no approach of bodies to it either.
            bare = (press.touching <= ENDING * self.length)[..., None]
        shared = share_load(
            np.abs(force),
            (self._shares - 0.5) * self.length,
            np.where(bare, self.length, press.touching[..., None]) * np.array([0.0, *[1.0 / SLICES] * SLICES, 0.0]),
            np.where(k > 0.0, k, 1.0 / radius),
            self.roller,
            self.cam,
            radius,
            2.0 * radius,
            cosines=lever,
        )
        # No pressure can be given of a force that presses where no wall is.
        lost = bare & (force != 0.0)[..., None]
        behind, ahead = np.where(lost, -1.0, behind), np.where(lost, -1.0, ahead)
        line = np.moveaxis(shared.line_load, -1, 0) * np.sign(force)
        pair = pair_compliance(self.roller, self.cam)
        return line_contacts(
            self.force.panels,
            line,
            np.moveaxis(behind, -1, 0),
            np.moveaxis(ahead, -1, 0),
            np.broadcast_to(press.path_rate, line.shape),
            1.0,
            pair,
        )

    @property
    def _sliced(self) -> tuple[Floats, Floats]:
        """Between which places there are slices: along what touches; under a crown, which spans less, along it all."""
        if self.crown is None and self.finite is None:
            return self.pressing.stretch
        ends: tuple[float, ...] = tuple(sorted(self.track.contact))
        if self.finite is not None:
            ends = tuple(float(self.pressing.middle + self.finite.places[at]) for at in (0, -1))
        low, high = (np.full(self.force.panels.theta.shape, end) for end in ends)
        return low, high

    @cached_property
    def _shares(self) -> Floats:
        """Of the way between those places at which the slices stand: their middles, of a line its ends too, (m,)."""
        equal = np.asarray((np.arange(SLICES) + 0.5) / SLICES)
        if self.finite is None:
            if self.crown is None:
                return np.concatenate([[0.0], equal, [1.0]])
            if self.ends.tilt == 0.0:
                return equal
            # Where the crown touches either wall is a slice too.
            moved = self.crown * sin(self.ends.tilt) / self.length
            return distinct(np.concatenate([equal, np.clip(0.5 + np.array([-moved, moved]), 0.0, 1.0)]))
        places = self.finite.places
        return np.asarray((places - places[0]) / (places[-1] - places[0]))

    @cached_property
    def slice_places(self) -> Floats:
        """Place of each slice along the roller axis (delta), mm, (m, p, n)."""
        low, high = self._sliced
        return np.asarray(low + self._shares[:, None, None] * (high - low))

    @cached_property
    def slice_stations(self) -> Floats:
        """The same at the cam angle of the largest pressure, (m,)."""
        angle = self.least_peak.cam_angle
        return np.array([self._at(place, angle) for place in self.slice_places])

    def spread(self, values: Floats, theta: Floats, delta: Floats) -> Floats:
        """Values of the slices (m, p, n) at cam angles (k,), rad, and places along it, (k, j) or (j,).

        Linear between the slices, 0 beyond what touches; (k, j).
        """
        at = self.force.panels.theta.ravel()
        low, high = (np.interp(theta, at, end.ravel())[:, None] for end in self._sliced)
        rows = np.stack([np.interp(theta, at, row.ravel()) for row in values], axis=-1)
        share = (delta - low) / np.where(high > low, high - low, 1.0)
        known = self._shares
        i = np.clip(np.searchsorted(known, share, "right") - 1, 0, len(known) - 2)
        x = np.clip((share - known[i]) / (known[i + 1] - known[i]), 0.0, 1.0)
        one, two = (np.take_along_axis(rows, index, axis=1) for index in (i, i + 1))
        within = (share >= -1e-9) & (share <= 1.0 + 1e-9) & (high > low)
        return np.where(within, one + x * (two - one), 0.0)

    def pressure_at(self, theta: Floats, delta: Floats, wall: int = 0) -> Floats:
        """Largest pressure across, MPa, (k, j), at cam angles (k,), rad, and places along it, (k, j) or (j,).

        wall: 1 behind, -1 ahead, 0 the one that bears. Under a crown its exact ellipse, else between the slices.
        """
        if self.level == "ellipse" and self.crowned is not None:
            return self.crowned.pressure_at(theta, delta, wall)
        square = self.slices.behind if wall > 0 else self.slices.ahead
        pressed = self.slices.pressure if wall == 0 else np.sqrt(np.maximum(square, 0.0))
        if self.finite is None:
            return self.spread(pressed, theta, delta)
        (near, far), middle = self.finite.known, self.pressing.middle
        within = (delta >= middle + near) & (delta <= middle + far)
        inner = middle + self.finite.places[[1, -2]]
        sharp = np.array([near, far]) != self.finite.edges[[0, -1]]
        low, high = np.where(sharp, inner, np.array([-inf, inf]))
        return np.where(within, self.spread(pressed, theta, np.clip(delta, low, high)), 0.0)

    @property
    def pressed_places(self) -> tuple[float, float]:
        """Between which places along the roller axis (delta), mm, it is pressed over the turn."""
        if self.finite is not None:
            on = np.flatnonzero(self.finite.squares.max(axis=(1, 2)) > 0.0)
            edges = self.pressing.middle + self.finite.edges
            return float(edges[on[0]]), float(edges[on[-1] + 1])
        if self.crowned is not None:
            return self.crowned.pressed_places
        low, high = sorted(self.track.contact)
        return low, high

    @cached_property
    def _slices(self) -> StationWalls:
        """The walls at every slice."""
        places = self.slice_places.reshape(len(self._shares), -1).T
        if self.beside is None:
            places = places[0]
        return self.pressing.walls(self.track.meridian.parameters(places))

    @cached_property
    def _curvatures(self) -> Floats:
        """Relative curvature of the wall that every slice presses, 1/mm, (m, p, n)."""
        return np.where(self.pressing.pushed >= 0.0, self._slices.behind, self._slices.ahead)

    @cached_property
    def _pressed_curvatures(self) -> Floats:
        """The same where a wall is pressed, or the slices would not be sound; the roller's own where undercut."""
        return np.where(self._curvatures > 0.0, self._curvatures, 1.0 / self.radius)

    @cached_property
    def peak_contact(self) -> Beneath | None:
        """Half-width and subsurface shear of the hardest contact, of all slices; None where a wall is undercut."""
        if not np.all(self.slices.sound):
            return None
        if self.finite is not None:
            return None if self.no_stress else Beneath(*self.finite.hardest[1].beneath(self.cam.poisson))
        peaks = self.slices.peak()
        m = int(np.argmax(peaks.pressure))
        pressure, angle = float(peaks.pressure[m]), float(peaks.theta[m])
        if self.crowned is not None:
            one = self.crowned.ellipse
            top, *axes = (
                self._at(each, angle, self.slices.pressure[m]) for each in (one.pressure, one.along, one.around)
            )
            return beneath_point(top, max(axes), min(axes), self.cam.poisson)
        k = self._at(self._pressed_curvatures[m], angle, self.slices.pressure[m])
        return beneath_line(pressure, k, self.pressing.pair)

    def patch(self, counts: tuple[int, int]) -> tuple[Floats, Floats, Floats]:
        """The hardest contact: places along the roller axis (delta) (i,) and across (j,), mm, pressure (j, i), MPa.

        Nothing is told of the pressure next to a sharp end that bears: 0 there.
        """
        n, m = counts
        if self.finite is not None:
            found = self.finite.hardest[1]
            return found.picture(n, m, self.pressing.middle)
        assert self.crowned is not None, "a line is alike all along"
        one, angle = self.crowned.ellipse, self.least_peak.cam_angle
        top, along, around, crest = (
            self._at(each, angle, one.pressure) for each in (one.pressure, one.along, one.around, self.crowned.crest)
        )
        x, y = crest + 1.1 * along * np.linspace(-1.0, 1.0, n), 1.1 * around * np.linspace(-1.0, 1.0, m)
        square = 1.0 - ((x - crest) / along) ** 2 - (y[:, None] / around) ** 2
        return x, y, np.asarray(top * np.sqrt(np.maximum(square, 0.0)))

    @cached_property
    def stiffness(self) -> Stiffness:
        """Of the hardest contact along its normal, N/mm, as a line, an ellipse (approach as load^(2/3)) or solved."""
        if self.finite is not None:
            return self.finite.stiffness
        angle = self.least_peak.cam_angle
        load = self._at(np.abs(self.normal), angle)
        if self.crowned is not None:
            secant = load / self._at(self.crowned.approach, angle)
            return Stiffness(1.5 * secant, secant)
        length, k = (self._at(each, angle) for each in (self.pressing.touching, self.pressing.curvature))
        soft = float(line_flexibility(load / length, k, self.roller, self.cam, self.radius, 2.0 * self.radius))
        return Stiffness(length / (soft - self.pressing.pair / np.pi), length / soft)

    @cached_property
    def deepest_shear(self) -> Extreme | None:
        """Where the largest shear lies deepest over the turn and along the roller, mm; None where a wall undercuts."""
        if not np.all(self.slices.sound):
            return None
        if self.finite is not None:
            below = self.peak_contact
            return None if below is None else replace(self.least_peak, value=below.shear_depth)
        if self.crowned is not None:
            depth = self.crowned.depths(self.cam)
            deepest = peak_of(self.force.panels, depth)
            return replace(deepest, place=self._at(self.crowned.crest, deepest.cam_angle, depth))
        depths = line_depth(self.slices.pressure, self._pressed_curvatures, self.pressing.pair)
        value, angle = highest(self.force.panels, depths)
        m = int(np.argmax(value))
        return Extreme(float(value[m]), float(angle[m]), self._at(self.slice_places[m], float(angle[m]), depths[m]))

    def spot(self, at: Extreme) -> str:
        """A place on the roller in words, and how much of it touches there where that is not all."""
        touching = self._at(self.pressing.touching, at.cam_angle)
        share = f", {touching:.4g} of {self.length:.4g} mm touch" if touching < (1.0 - 1e-4) * self.length else ""
        return f"{self.track.name}, at {at.place:.4g} mm along the roller axis{share}"

    @cached_property
    def roller_life(self) -> RollerLife:
        """Fatigue life of the roller's circumference at the quoted station."""
        return roller_life(self.contact, self.roller, self.quoted.radius, self.speed)

    @cached_property
    def slice_life(self) -> RollerLife:
        """Fatigue life of every slice of the roller, (m,); its spin is that of the middle."""
        return roller_life(self.slices, self.roller, self.radius, self.speed)

    @cached_property
    def cam_life(self) -> CamLife:
        """Fatigue life of the cam's walls at the quoted station."""
        return cam_life(self.contact, self.cam, self.speed, self.passes)

    @cached_property
    def slice_cam_life(self) -> CamLife:
        """Fatigue life of the cam's walls at every slice, (m,)."""
        return cam_life(self.slices, self.cam, self.speed, self.passes)

    @property
    def meeting(self) -> Meeting | None:
        """Its contact on a wall that other rollers pass too, as hard as its own life says; None where it is alone."""
        if self.lag is None or not self.lives.get("cam"):
            return None
        where, pressure = self.force.panels, self.hardest_pressure
        top, most = peak_of(where, pressure).value, 1.0 / self.lives["cam"]

        def damage(theta: Floats) -> Floats:
            share = np.maximum(where.at(pressure, np.mod(theta, TURN)), 0.0) / max(top, LEAST_PRESSURE)
            return np.asarray(most * share**self.cam.exponent)

        return Meeting(self.lag, damage)

    @cached_property
    def bearing(self) -> BearingLife | None:
        """Life of the roller as a bearing; None where it has no rating."""
        if self.rating is None:
            return None
        from camgeom.mechanics.bearing import bearing_life, modified

        basic = bearing_life(self.force.panels, self.normal, self.pressing.path_rate, self.radius, self.speed,
                             self.rating.dynamic, self.rating.static, self.rating.kind.exponent)
        return modified(basic, self.rating)

    def film(self, oil: Oil) -> Film | None:
        """The film of the thinnest slice, under a crown of its ellipse; None without load and where a wall is undercut.

        The roller rolls without slip in its middle; its own inertia may make it slide where it is spun up.
        """
        from camgeom.mechanics.film import line_film, point_film, thinnest

        if not np.all(self.slices.sound) or self.no_stress:
            return None
        theta, pair = self.force.panels.theta, self.pressing.pair
        if self.crowned is not None and self.level == "ellipse":
            bears, one = self.pressing.bears, self.crowned.ellipse
            load, along = np.where(bears, np.abs(self.normal), 1.0), np.where(bears, one.around, 1.0)
            k = np.where(bears, one.along, 1.0) / along
            speed = self.speed * self._runs[0][len(self._runs[0]) // 2]
            thick = point_film(speed, self.crowned.principal[0], load, k, oil, pair)
            return thinnest(theta, np.where(bears, thick / oil.roughness, np.inf), oil, k, self.crowned.crest)
        force = np.abs(self.slices.normal)
        bears = force > QUIET * force.max(initial=0.0)
        k = self._curvatures if self.finite is None else np.broadcast_to(self.pressing.curvature, force.shape)
        safe = np.where(bears & (k > 0.0), k, 1.0)
        thick = line_film(self.speed * self._runs[0], safe, np.where(bears, force, 1.0), oil, pair)
        ratio = np.where(bears & (k > 0.0), thick / oil.roughness, np.inf)
        m = np.argmin(ratio, axis=0)[None]
        return thinnest(theta, np.take_along_axis(ratio, m, 0)[0], oil,
                        place=np.take_along_axis(self.slice_places, m, 0)[0])  # fmt: skip

    @cached_property
    def _runs(self) -> tuple[Floats, Floats, Floats]:
        """Of the slices; see `Pressing.runs`."""
        return self.pressing.runs(self.slice_places)

    @cached_property
    def rubbed(self) -> float:
        """Load times sliding way over a turn, N mm: of places that roll less than the middle, or than the crest of
        a crown, and along the axis.
        """
        work, *_, width = self._rubs
        return float(self.force.panels.integral((work * width).sum(axis=0)))

    @cached_property
    def _rubs(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Of places along the roller, its ends among them, (m, p, n) each: load per length times sliding way, N/rad,
        that over the roller's circumference there and over the contact's speed along the cam, N/mm, and the length that
        each stands for, mm."""
        if self.crowned is not None:
            # Of WITHIN places along its ellipses: nothing is left of the load at their ends.
            crest, (low, high) = self.crowned.crest, self.crowned.pressed_places
            share = (np.arange(WITHIN) + 0.5) / WITHIN
            places = np.broadcast_to((low + share * (high - low))[:, None, None], (WITHIN, *crest.shape))
            first, last = self.pressing.stretch
            bears = (places >= first) & (places <= last)
            load = np.where(bears, np.abs(self.crowned.contact(places - crest).normal), 0.0)
            return self._rubbed(load, places, *self.pressing.runs(places, crest)[1:], np.array((high - low) / WITHIN))
        if self.finite is None:
            share = slice_shares(SLICES) / SLICES
        else:
            share = np.gradient(self._shares)
            share[[0, -1]] *= 0.5
        width = share[:, None, None] * self.pressing.touching
        return self._rubbed(np.abs(self.slices.normal), self.slice_places, *self._runs[1:], width)

    def _rubbed(
        self, load: Floats, places: Floats, on_cam: Floats, slip: Floats, width: Floats
    ) -> tuple[Floats, Floats, Floats, Floats]:
        work, radius = load * slip, self.track.radii(places)
        passed = np.divide(work, on_cam, out=np.zeros_like(work), where=on_cam > 0.0)
        return work, work / (2.0 * np.pi * radius), passed, width

    @cached_property
    def rubbing(self) -> dict[str, float]:
        """Load per width times sliding way that passes a point of cam and roller, N/mm; see `Duty.rubbing`."""
        _, on_roller, on_cam, _ = self._rubs
        roller = float(self.force.panels.integral(on_roller).max())
        return {"roller": roller, "cam": self.passes * float(on_cam.max())}

    @cached_property
    def lives(self) -> dict[str, float]:
        """Fatigue life, h, of roller and cam at the hardest place along the roller, and of the roller's bearing.

        No life of surfaces that a sharp end presses.
        """
        lives = {} if self.no_stress else {
            "roller": min(float(np.min(self.slice_life.life_h)), float(self.roller_life.life_h)),
            "cam": min(float(np.min(self.slice_cam_life.life_h)), float(self.cam_life.life_h)),
        }  # fmt: skip
        return lives if self.bearing is None else lives | {"bearing": self.bearing.judged_h}

    @cached_property
    def torque(self) -> Floats:
        """Torque the cam takes from its shaft, N mm, (p, n)."""
        guides = (self.pressing.pushed - self.force.force) * self.force.ds
        return self.force.camshaft_torque() + guides

    @cached_property
    def contact_forces(self) -> Floats:
        """Normal force of the roller on its walls, N, (1, p, n)."""
        return np.abs(self.normal)[None]

    @cached_property
    def quoted_force(self) -> Extreme:
        """The same as if all of it acted at the place where the classical figures are quoted."""
        return self.peak_force if self.at is None else peak_of(self.force.panels, np.abs(self.quoted.normal))

    @cached_property
    def hardest_pressure(self) -> Floats:
        """Pressure at the hardest place along the roller, MPa, (p, n), over the turn; as far as there is one."""
        return np.asarray(np.maximum(self.slices.pressure.max(axis=0), self.contact.pressure))

    @cached_property
    def _hardest_slice(self) -> Extreme:
        """Largest contact pressure, MPa, of all slices and the quoted place."""
        peak, quoted = self.slices.peak(), self.contact.peak()
        worst = int(np.argmax(peak.pressure))
        angle = float(peak.theta[worst])
        if float(quoted.pressure) > float(peak.pressure[worst]):
            delta = float(self.track.meridian.jet(np.array([self.quoted.station]))[0][0])
            if self.crowned is not None:
                delta = self._at(self.crowned.crest, float(quoted.theta), self.contact.pressure)
            return Extreme(float(quoted.pressure), float(quoted.theta), delta)
        place = self._at(self.slice_places[worst], angle, self.slices.pressure[worst])
        return Extreme(float(peak.pressure[worst]), angle, place)

    @property
    def hardest_wall(self) -> int:
        """The wall that bears where the pressure is largest: 1 behind, -1 ahead."""
        return 1 if self._at(self.pressing.pushed, self.least_peak.cam_angle) >= 0.0 else -1

    def _at(self, values: Floats, cam_angle: float, judged: Floats | None = None) -> float:
        """A quantity (p, n) at a cam angle, rad; at a jump on its side where the pressure, or `judged`, is larger."""
        harder = self.hardest_pressure if judged is None else judged
        return float(self.force.panels.limit(values, cam_angle, harder))

    @cached_property
    def contact_length(self) -> float:
        """Length that touches where the pressure is largest, mm; the least where the pressure has no bound."""
        if self.finite is not None:
            return self.finite.hardest[1].length
        if self.least_peak.value == inf:
            return self.least_touching.value
        angle = self.least_peak.cam_angle
        if self.crowned is not None:
            return 2.0 * self._at(self.crowned.ellipse.along, angle)
        return self._at(self.pressing.touching, angle)

    @cached_property
    def kept(self) -> Kept | None:
        """What keeps the follower on this roller's track; None where other rollers or touches hold it too."""
        if not self.alone:
            return None
        from camgeom.mechanics.kept import Kept, zeroed

        force = zeroed(self.load)
        theta, (side,) = force.panels.theta, self.track.sides
        flank = Flank(self.track, theta.ravel(), np.array([self.station]), side)
        lever, cosine = np.abs(flank.lever()), np.cos(flank.pressure_angle())
        return Kept(self.load, force, lever.reshape(theta.shape), cosine.reshape(theta.shape), self.track.name)

    def contact_data(self) -> dict[str, Any]:
        """Peak pressure at the quoted place and over the slices, force, torque, subsurface shear, as plain data.

        Of a sharp end that bears no pressure but that half a millimetre inside of it.
        """
        peak, hardest = self.contact.peak(), self.peak_pressure
        return {
            "contact_level": self.level,
            **(inside_data(self.least_peak) if hardest is None else {
                "peak_pressure_mpa": finite(peak.pressure),
                "cam_angle_deg": degrees(float(peak.theta)),
                **self._crown_data(),
            }),
            "peak_force_n": self.quoted_force.value,
            **({} if self.at is None else {"peak_middle_force_n": self.peak_force.value}),
            **(slice_data(hardest) if hardest is not None else {}),
            **length_data(self.contact_length, self.least_touching),
            **hertz_data(self.peak_contact, self.deepest_shear),
            **self._finite_data(),
            **torque_data(self.peak_torque, self.work),
            "wall_reversals_deg": [degrees(r.taken) for r in self.force.reversals()[0]],
            **(self.kept.data() if self.kept is not None else {}),
        }  # fmt: skip

    def _finite_data(self) -> dict[str, Any]:
        """Of a contact on a half-space; empty of another."""
        if self.finite is None:
            return {}
        return patch_data(self.finite.hardest[1], self.stiffness, self.pressing.middle)

    def _crown_data(self) -> dict[str, Any]:
        """Of a crowned roller: the pressure without its crown, and the largest half-length of its ellipse."""
        if self.crowned is None:
            return {}
        return {
            "line_pressure_mpa": finite(self.pressing.as_line.peak().pressure),
            "ellipse_half_length_mm": self.crowned.longest,
        }

    def fatigue_data(self) -> dict[str, Any]:
        """Lives of roller and cam, at the quoted place and at the hardest along the roller, as plain data.

        Of surfaces that a sharp end presses none, the path rolled alone.
        """
        life = self.roller_life
        if self.no_stress:
            return {"path_per_turn_m": float(life.path) * MILLI}
        return {
            "roller_life_h": finite(life.life_h),
            "roller_slice_life_h": finite(self.lives["roller"]),
            "hot_spot_deg": degrees(float(life.hot_spot)) % 360.0,
            "cam_life_h": finite(self.cam_life.life_h),
            "cam_slice_life_h": finite(self.lives["cam"]),
            "path_per_turn_m": float(life.path) * MILLI,
        }
