"""Every machined flank of a cam as one surface over two parameters, for measuring and for comparing.

phi is the cam angle (rad); t the meridian parameter along the roller, or the height z (mm) of a planar cam. Normals
point out of the material. Flanks are those the tool leaves: running clearances are in them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.surface import Forms, dot
from camgeom.solid.pocket import EdgePlate, PocketPlate
from camgeom.solid.prism import GroovedPlate, Prism
from camgeom.track import TURN, Track
from camgeom.track.carriage import Carriage
from camgeom.track.flank import Flank
from camgeom.track.outline import Outline, RollerOutline
from camgeom.track.plate import ROUND_ENDS, UPPER_SIDE, EdgeOutline, PocketOutline
from camgeom.track.runout import Within

if TYPE_CHECKING:
    from camgeom.model import Model

Mask = npt.NDArray[np.bool_]


@immutable
class FlankPatch:
    """A flank at parameters (n,): points x, outward unit normals n, derivatives by phi and t, (3, n).

    second  n times the second derivatives, (n,) each: by phi twice, by phi and t, by t twice
    """

    x: Floats
    n: Floats
    by_phi: Floats
    by_t: Floats
    second: tuple[Floats, Floats, Floats]

    @property
    def curvatures(self) -> tuple[Floats, Floats]:
        """Principal curvatures, the larger first, 1/mm; positive where the material is convex."""
        first = [dot(one, other) for one, other in ((self.by_phi,) * 2, (self.by_phi, self.by_t), (self.by_t,) * 2)]
        return Forms(*first, *(-form for form in self.second)).principal()


@final
@immutable
class RolledFlank:
    """The flank that a roller or cutter leaves on one of its sides; stations over the stretch the roller touches."""

    name: str
    track: Track
    side: float
    wall: tuple[float, float]
    touched: tuple[float, float]

    @property
    def span(self) -> tuple[float, float]:
        """Cam angles it exists over, rad; of a cam that slides a turn is one way, evenly: see `angle`."""
        return self.track.span

    def angle(self, phi: Floats) -> Floats:
        """The cam angles (n,), rad, at such places: of a cam that slides those of its drive, on the way out."""
        carriage = self.track.carriage
        return phi if carriage is None else carriage.out(phi * carriage.stroke / TURN)

    @property
    def _run(self) -> Track:
        return self.track.evenly

    @property
    def closed(self) -> bool:
        """True where the span's end is its beginning."""
        return self._run.closed

    def knots(self) -> Floats:
        """Cam angles where second derivatives may jump."""
        return self._run.knots()

    def at(self, phi: Floats, t: Floats) -> FlankPatch:
        """The flank at (phi, t), (n,) each. Raises DesignError where there is no contact."""
        flank = Flank(self._run, phi, t[:, None], self.side)
        rate = 1.0 if flank.pose.pace is None else flank.pose.pace
        one, two = flank.tangents
        forms = flank.forms
        second = -forms.L[:, 0] * rate**2, -forms.M[:, 0] * rate, -forms.N[:, 0]
        return FlankPatch(flank.x[:, :, 0], -flank.n[:, :, 0], one[:, :, 0] * rate, two[:, :, 0], second)

    def pitch(self, phi: Floats, t: Floats) -> Floats | None:
        """Points of the roller's axis beside the contact, (3, n)."""
        pose = self._run.pose(phi, 0)
        return np.asarray(pose.a[0] + self.track.meridian.jet(t)[0] * pose.u[0])

    def station(self, t: Floats) -> Floats:
        """Place along the roller, mm."""
        return self.track.meridian.jet(t)[0]


@final
@immutable
class PrismFlank:
    """The wall of a planar cam: its outline between two heights; material +1 inside the outline, -1 outside."""

    name: str
    outline: Outline
    wall: tuple[float, float]
    material: float = 1.0

    @property
    def touched(self) -> tuple[float, float]:
        """Heights that are measured, mm."""
        return self.wall

    @property
    def span(self) -> tuple[float, float]:
        """One turn, rad."""
        return 0.0, TURN

    def angle(self, phi: Floats) -> Floats:
        """The cam angles themselves."""
        return phi

    @property
    def closed(self) -> bool:
        """An outline is closed."""
        return True

    def knots(self) -> Floats:
        """Cam angles where second derivatives may jump."""
        return self.outline.knots()

    def at(self, phi: Floats, t: Floats) -> FlankPatch:
        """The wall at (phi, t), (n,) each."""
        return _raised(self.outline, self.material, phi, t)

    def pitch(self, phi: Floats, t: Floats) -> Floats | None:
        """Points of the roller's axis at that height, (3, n); None for a follower without a roller."""
        if not isinstance(self.outline, RollerOutline):
            return None
        return np.stack([*self.outline.track.pose(phi, 0).a[0][:2], t])

    def station(self, t: Floats) -> Floats:
        """The height z, mm."""
        return t


FlankSurface = RolledFlank | PrismFlank


@final
@immutable
class PlateFlank:
    """The wall of a plate that slides, over a part of its outline's parameter, between two heights; material as above.
    """

    name: str
    outline: EdgeOutline | PocketOutline
    wall: tuple[float, float]
    span: tuple[float, float]
    carriage: Carriage
    material: float

    @property
    def closed(self) -> bool:
        """It has two ends."""
        return False

    def angle(self, phi: Floats) -> Floats:
        """The angles of its drive (n,), rad, on the way out, at which the roller is nearest to such places."""
        return self.carriage.out(self.outline.share(phi) * self.carriage.stroke)

    def at(self, phi: Floats, t: Floats) -> FlankPatch:
        """The wall at (phi, t), (n,) each."""
        return _raised(self.outline, self.material, phi, t)

    def station(self, t: Floats) -> Floats:
        """The height z, mm."""
        return t


MeasuredSurface = FlankSurface | PlateFlank


def _raised(outline: Outline, material: float, phi: Floats, t: Floats) -> FlankPatch:
    """The wall over an outline at parameters and heights (n,)."""
    curve = outline.curve(phi)
    zero = np.zeros_like(phi)
    n = np.stack([*curve.normals, zero])
    along = np.stack([-curve.normals[1] * curve.speed, curve.normals[0] * curve.speed, zero])
    bend = -material * curve.curvature * curve.speed**2
    up = np.stack([zero, zero, np.ones_like(phi)])
    return FlankPatch(np.stack([*curve.points, t]), material * n, along, up, (bend, zero, zero))


def flank_surfaces(model: Model) -> tuple[FlankSurface, ...]:
    """The flanks of a cam of any kind. Raises DesignError where the cam has none (or folds back on itself)."""
    for one in model.grooves:
        one.refuse_folded()
    found: list[FlankSurface] = []
    if any(one.planar is not None for one in model.grooves):
        for part in model.parts:
            if isinstance(part, Prism):
                name = "profile" if len(model.parts) == 1 else part.name
                found.append(PrismFlank(name, part.outer.outline, (part.z0, part.z1)))
            elif isinstance(part, GroovedPlate):
                if part.rim.name == "flank" and part.rim.upper is None:
                    found.append(PrismFlank("rim", part.rim.outline, (part.z0, part.z1)))
                for groove in part.grooves:
                    of = f"{groove.face} " if len(model.grooves) > 1 else ""
                    low, high = sorted((groove.foot, groove.top))
                    for name, loop, sign in (("inner flank", groove.inner, 1.0), ("outer flank", groove.outer, -1.0)):
                        if loop.upper is None:
                            found.append(PrismFlank(of + name, loop.outline, (low, high), sign))
    leaning = [one for one in model.grooves if one.planar is None]
    if leaning:
        several = len(model.grooves) > 1
        for number, survey in [(one.groove + 1, survey) for one in leaning for survey in one.flanks]:
            cutter, which = survey.cutter, f" {number}" if several else ""
            touched = sorted(cutter.meridian.parameter(d) for d in survey.track.contact)
            ends = float(survey.wall[0]), float(survey.wall[-1])
            touched = [min(max(t, ends[0]), ends[1]) for t in touched]
            for side in cutter.sides:
                word = f"{cutter.name}{which} flank {'+' if side > 0.0 else '-'}"
                word = word if len(cutter.sides) > 1 else cutter.name
                found.append(RolledFlank(word, cutter, side, ends, (touched[0], touched[1])))
    if not found:
        raise DesignError(f"a cam of kind {model.profile.kind} has no flank to measure")
    return tuple(found)


def measured_surfaces(model: Model) -> tuple[MeasuredSurface, ...]:
    """The flanks of a cam as far as they are made: a plate's edge straight on to its ends and through its thickness,
    and beside the walls of a plate's groove the half circles that end it. Raises as `flank_surfaces`.
    """
    flanks, carriage = flank_surfaces(model), model.mechanism.carriage
    found: list[MeasuredSurface] = list(flanks)
    for part in model.parts if carriage is not None else ():
        assert carriage is not None
        if isinstance(part, EdgePlate):
            found = [PlateFlank(flanks[0].name, part.outline, (0.0, part.top), UPPER_SIDE, carriage, 1.0)]
        elif isinstance(part, PocketPlate):
            outline, wall = part.pocket.outline, (part.floor, part.top)
            assert isinstance(outline, PocketOutline)
            found += [PlateFlank(f"groove, {name}", outline, wall, span, carriage, -1.0)
                      for name, span in zip(("start", "end"), ROUND_ENDS)]  # fmt: skip
    return tuple(found)


def within(model: Model) -> Within:
    """How deep points (3, n) of the flanks lie within the blank: tracks run beyond the cam's ends and outside."""
    drum = model.mechanism.drum
    return drum.within if drum is not None else model.within
