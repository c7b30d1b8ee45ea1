"""Flat drawings for CAD and wire or laser cutting: AutoCAD DXF R2010, in mm, by ezdxf.

Every curve stands there twice: as one clamped cubic spline, C1 throughout, on a layer `..._SPLINE`, and as a polyline
of exact points on a layer `..._POLYLINE`. Their measured distances from the exact curve stand in the notes of the
drawing, and with the curve's name in the entity's extended data (application CAMGEOM). The entities of one view share
its origin; views after the first stand above it, at an origin that their notes give.

The views are outlines and tool paths of planar cams, developed grooves, the indexing turret, and a frame. A planar
cam stands in the cam frame, seen from +Z; other views say in their notes where they are. Of a flank that leans the
lower end stands on PROFILE_LOWER_..., the upper one on PROFILE_UPPER_...
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import field, replace
from io import StringIO
from math import asin, ceil, degrees, floor, sqrt
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, final
from uuid import NAMESPACE_URL, uuid5

import numpy as np

from camgeom.errors import CamgeomError, ExportError, not_installed
from camgeom.export import writer
from camgeom.export.files import moment, write_whole
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.curves import PlaneCurve, Polyline, Role, Spline, chords, fitted
from camgeom.solid.blank import Bore
from camgeom.solid.frame import FramePlate
from camgeom.solid.mechanism import Drum
from camgeom.solid.prism import GroovedPlate, Loop, Prism
from camgeom.track import TURN, Arc, Swing, Track
from camgeom.track.column import ConeLevel
from camgeom.track.developed import developed, drum_radii, rolled_out
from camgeom.track.follower import TurretFollower
from camgeom.track.outline import CircleOutline, Outline, ParallelOutline

if TYPE_CHECKING:
    from camgeom.model import Model


DEVIATION = 1e-4
"""mm, allowed between a spline and the exact curve"""
APPLICATION = "CAMGEOM"
COLOURS = {
    "PROFILE": 7, "PROFILE_LOWER": 7, "PROFILE_UPPER": 6, "PITCH": 5, "CUTTER": 1, "FLANK": 7, "CENTRE_LINE": 5,
    "BLANK": 8, "BORE": 3, "CENTRE": 4, "TURRET": 6, "ROLLERS": 2, "MARK": 3, "NOTES": 9, "FRAME": 6, "HIDDEN": 8,
}  # fmt: skip
"""AutoCAD colour index by layer (the part before _SPLINE or _POLYLINE)"""
LINES = {
    "PITCH": "CENTER", "CUTTER": "DASHED", "CENTRE_LINE": "CENTER", "CENTRE": "CENTER", "BLANK": "CONTINUOUS",
    "HIDDEN": "DASHED",
}  # fmt: skip
DEVELOPED = {"profile": "FLANK", "pitch": "CENTRE_LINE"}
GAP = 0.15
"""of a view's height, left free between views"""


@writer(
    ".dxf", "profiles, pitch and cutter curves, developed grooves, turret, frame: splines and polylines", takes="model"
)
def write_dxf(path: Path, model: Model, deviation: float = DEVIATION, chord: float | None = None) -> int:
    """Write the flat views of a cam; returns the bytes written.

    deviation  mm, of the splines; chord: mm, of the polylines (default: the model's tolerance). What was reached is
               measured and stands in the file. A tool's diameter in the profile's [cutter] adds its path.
    Raises ExportError for a cam with nothing flat to draw, where a flank is undercut, or the file cannot be written.
    """
    try:
        import ezdxf
    except ImportError:
        raise not_installed("a DXF drawing", "ezdxf", "dxf") from None

    cutter = model.profile.cutter_spec.diameter if model.profile.cutter_spec else None
    try:
        model.refuse_folded()
        views = plane_views(model, 0.5 * cutter if cutter else None)
        if not views:
            raise ExportError(f"{path}: a cam of kind {model.profile.kind} has no flat view")
        drawn = [_Drawn.of(view, deviation, chord if chord is not None else model.tolerance) for view in views]
    except ExportError:
        raise
    except CamgeomError as error:
        raise ExportError(f"{path}: cannot be drawn: {error}") from error
    document: Any = ezdxf.new("R2010", setup=["linetypes"])
    document.units = 4  # mm
    document.header["$MEASUREMENT"] = 1
    document.header.custom_vars.append("Design", model.profile.name)
    document.appids.add(APPLICATION)
    _place(document, drawn)
    # In an order of its own: that of ezdxf's sets differs from process to process.
    for kind in sorted(document.entitydb.dxf_types_in_use()):
        document.classes.add_class(kind)
    written = StringIO()
    document.write(written)
    text = _dated(written.getvalue())
    return write_whole(path, text.encode("utf-8", "surrogateescape"))


def _dated(text: str) -> str:
    """The drawing's text with the given date, if one is, and identifiers that follow from its content."""
    when, given = moment()
    if not given:
        return text
    day = when.toordinal() + 1721424.5 + (when.hour * 3600 + when.minute * 60 + when.second) / 86400.0
    text = re.sub(r"(\$TDU?(?:CREATE|UPDATE)\n *40\n)[^\n]*", rf"\g<1>{day!r}", text)
    text = re.sub(r"(\n\d+\.\d+\S* @ )\d{4}-\S*", rf"\g<1>{when.isoformat()}", text)
    guid = r"(\$(?:FINGERPRINT|VERSION)GUID\n *2\n)[^\n]*"
    own = str(uuid5(NAMESPACE_URL, re.sub(guid, r"\1", text))).upper()
    return re.sub(guid, rf"\g<1>{{{own}}}", text)


@final
@immutable
class _Drawn:
    """A view with its curves made: name, layer prefix, whether closed, spline and polyline of each."""

    view: PlaneView
    curves: list[tuple[str, str, bool, Spline, Polyline]] = field(default_factory=list)

    @classmethod
    def of(cls, view: PlaneView, deviation: float, chord: float) -> _Drawn:
        drawn = cls(view)
        for curve in view.curves:
            prefix = DEVELOPED.get(curve.role, "") if view.name.startswith("developed") else curve.role.upper()
            prefix += view.ends.get(curve.name, "")
            made = fitted(curve, deviation), chords(curve, chord)
            drawn.curves.append((curve.name, prefix, curve.closed, *made))
        return drawn

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Low and high corner of everything drawn, mm."""
        points = [line.points for *_, line in self.curves]
        points += [np.array(stroke.points) for stroke in self.view.strokes]
        points += [np.add(disc.centre, np.array([[-1.0], [1.0]]) * disc.radius) for disc in self.view.discs]
        every = np.concatenate(points)
        return every.min(axis=0), every.max(axis=0)

    def notes(self, origin: Floats) -> str:
        """What the drawing says about the view."""
        lines = [*self.view.notes, f"origin of this view at ({origin[0]:.9g}, {origin[1]:.9g}) mm"]
        for name, _, _, spline, line in self.curves:
            # Rounded upwards: what is stated holds.
            lines.append(
                f"{name}: spline within {_up(spline.deviation)} mm, polyline within {_up(line.chord_error)} mm"
            )
        return "\\P".join(lines)


def _up(value: float) -> str:
    return f"{1.005 * value + 1e-12:.3g}"


def _place(document: Any, drawn: list[_Drawn]) -> None:
    """The views one above the other, and the window that shows them all."""
    space = document.modelspace()
    base: float | None = None
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for one in drawn:
        bottom, top = one.bounds
        size = 1.0 + float((top - bottom).max())
        origin = np.zeros(2) if base is None else np.array([0.0, base - bottom[1]])
        _draw(document, space, one, origin, 0.012 * size)
        low, high = np.minimum(low, bottom + origin), np.maximum(high, top + origin)
        base = float(high[1]) + GAP * size
    middle = 0.5 * (low + high)
    document.set_modelspace_vport(height=1.2 * float((high - low).max()), center=tuple(middle.tolist()))


def _layer(document: Any, name: str) -> dict[str, str]:
    """Attributes of an entity on a layer, which is made when it is first used."""
    if name not in document.layers:
        prefix = name.removesuffix("_SPLINE").removesuffix("_POLYLINE")
        document.layers.add(name, color=COLOURS[prefix], linetype=LINES.get(prefix, "CONTINUOUS"))
    return {"layer": name}


def _draw(document: Any, space: Any, one: _Drawn, origin: Floats, height: float) -> None:
    for name, prefix, closed, spline, line in one.curves:
        entity = space.add_spline(degree=3, dxfattribs=_layer(document, f"{prefix}_SPLINE"))
        entity.control_points = np.column_stack([spline.control + origin, np.zeros(len(spline.control))])
        entity.knots = spline.knots
        entity.set_xdata(APPLICATION, [(1000, name), (1040, spline.deviation)])
        points = (line.points + origin).tolist()
        entity = space.add_lwpolyline(points, close=closed, dxfattribs=_layer(document, f"{prefix}_POLYLINE"))
        entity.set_xdata(APPLICATION, [(1000, name), (1040, line.chord_error)])
    for disc in one.view.discs:
        place = tuple((np.array(disc.centre) + origin).tolist())
        space.add_circle(place, disc.radius, dxfattribs=_layer(document, disc.layer.upper()))
    for stroke in one.view.strokes:
        bulges = stroke.bulges or (0.0,) * len(stroke.points)
        corners = [(x + origin[0], y + origin[1], b) for (x, y), b in zip(stroke.points, bulges)]
        attributes = _layer(document, stroke.layer.upper())
        space.add_lwpolyline(corners, format="xyb", close=stroke.closed, dxfattribs=attributes)
    notes = _layer(document, "NOTES")
    for label in one.view.labels:
        at = tuple((np.array(label.at) + origin).tolist())
        space.add_text(label.text, height=height, dxfattribs=notes).set_placement(at)
    high = one.bounds[1]
    text = space.add_mtext(one.notes(origin), dxfattribs={**notes, "char_height": height})
    text.set_location((float(high[0]) + origin[0] + 3.0 * height, float(high[1]) + origin[1]))


Layer = Literal["blank", "bore", "centre", "turret", "rollers", "mark", "frame", "hidden"]


@immutable(eq=True)
class FullCircle:
    """A full circle: layer, centre and radius, mm."""

    layer: Layer
    centre: tuple[float, float]
    radius: float


@immutable(eq=True)
class Stroke:
    """Straight lines and arcs through points; bulges are tan(quarter of the arc's angle) from each point on."""

    layer: Layer
    points: tuple[tuple[float, float], ...]
    bulges: tuple[float, ...] = ()
    closed: bool = False


@immutable(eq=True)
class Label:
    """Words at a place, mm."""

    at: tuple[float, float]
    text: str


@immutable
class PlaneView:
    """One flat view; `notes` say what it shows and where its origin is; `ends`: what the layer of a curve adds, by its
    name."""

    name: str
    curves: tuple[PlaneCurve, ...] = ()
    discs: tuple[FullCircle, ...] = ()
    strokes: tuple[Stroke, ...] = ()
    labels: tuple[Label, ...] = ()
    notes: tuple[str, ...] = ()
    ends: Mapping[str, str] = field(default_factory=dict)


def plane_views(model: Model, cutter_radius: float | None = None) -> tuple[PlaneView, ...]:
    """The flat views of a cam of any kind; cutter_radius (mm) asks for the paths of a round tool's centre."""
    views: list[PlaneView] = []
    if model.profiles is not None:
        radius = cutter_radius if model.planar is not None else None
        views += [_outlines(one, one.mechanism.outlines, radius) for one in model.grooves]
    elif model.mechanism.outlines:
        # Plates have corners, where a tool's path is not the parallel curve.
        views.append(_outlines(model, model.mechanism.outlines, None))
    elif model.mechanism.drum is not None:
        drum = model.mechanism.drum
        views += _cone(model, drum) if drum.slope else _drum(model, drum)
    if model.mechanism.turret is not None:
        views.append(_turret(model, model.mechanism.turret.follower))
    if model.mechanism.frame is not None:
        views.append(_frame(model.mechanism.frame))
    return tuple(views)


def _frame(plate: FramePlate) -> PlaneView:
    """The frame of a constant-width cam: outside, window and the edges of its guide bores, exact lines and arcs."""
    (low, high), side = plate.ends, 0.5 * plate.width
    corners = ((low, -side), (high, -side), (high, side), (low, side))
    starts, bulges = zip(*((side.start, side.bulge) for side in plate.sides))
    window = Stroke("frame", starts, bulges, closed=True)
    radius = 0.5 * plate.bore
    hidden = [Stroke("hidden", ((low, y + way), (high, y + way))) for y in plate.rods for way in (-radius, radius)]
    axes = [Stroke("centre", ((low, y), (high, y))) for y in (0.0, *plate.rods)]
    notes = [
        "frame seen from +Z at zero lift, origin on the cam axis",
        f"{plate.thickness:.9g} mm thick, {plate.opening:.9g} mm between its faces",
    ]
    if plate.bore:
        notes.append(f"hidden lines: 2 guide bores of {plate.bore:.9g} mm, {plate.spacing:.9g} mm apart, through")
    return PlaneView("frame", (), (), (Stroke("frame", corners, closed=True), window, *hidden, *axes), (), tuple(notes))


def _outline_curve(name: str, role: Role, outline: Outline) -> PlaneCurve:
    """An outline as a plane curve over the cam angle."""

    def at(phi: Floats) -> tuple[Floats, Floats]:
        curve = outline.curve(phi)
        n = curve.normals
        return curve.points, curve.speed * np.stack([-n[1], n[0]])

    return PlaneCurve(name, role, at, outline.knots())


def _outlines(model: Model, outlines: Mapping[str, Outline], cutter_radius: float | None) -> PlaneView:
    curves = [
        _outline_curve(name, "pitch" if name.endswith("pitch curve") else "profile", outline)
        for name, outline in outlines.items()
    ]
    notes = ["cam frame, seen from +Z, origin on the cam axis"]
    if model.mechanism.carriage is not None:
        curves.append(_path(model.tracks[0].evenly))
        notes = ["plate seen from +Z, origin at its corner, x along its travel"]
    hollow = model.planar.radii[1] if cutter_radius and model.planar is not None else None
    if cutter_radius and hollow is not None and cutter_radius >= hollow.value:
        notes.append(
            f"no cutter path: a tool of radius {cutter_radius:g} mm does not reach into the hollow of radius "
            f"{hollow.value:.6g} mm at cam angle {degrees(hollow.cam_angle) % 360.0:.6g} deg"
        )
    elif cutter_radius:
        for name, outline in outlines.items():
            if not name.endswith("pitch curve"):
                # The tool stands where the roller does: outside, but within the outer flank of a face groove.
                away = -cutter_radius if name == "outer flank" else cutter_radius
                path = ParallelOutline(outline, away)
                curves.append(_outline_curve(f"{name}, path of a cutter of radius {cutter_radius:g}", "cutter", path))
        notes.append(f"cutter paths: centre of a round tool of radius {cutter_radius:g} mm")
    discs, strokes = _openings(model)
    base = model.mechanism.base_radius
    if base is not None:
        discs.append(FullCircle("centre", (0.0, 0.0), base))
    name = "profile"
    if len(model.grooves) > 1:
        name = f"track {model.groove + 1}"
        notes.append(f"track {model.groove + 1}, between z = {_heights(model)} mm of the cam frame")
    return PlaneView(name, tuple(curves), tuple(discs), tuple(strokes), (), tuple(notes), _leaning(model))


def _leaning(model: Model) -> dict[str, str]:
    """Which end of a flank that leans an outline is, by its name."""
    touches = () if model.profiles is None else model.profiles.touches
    levels: dict[str, list[float]] = {}
    for touch in touches:
        levels.setdefault(touch.name, []).extend([] if touch.height is None else [touch.height])
    return {
        touch.where: "_LOWER" if touch.height == min(levels[touch.name]) else "_UPPER"
        for touch in touches if touch.height is not None
    }  # fmt: skip


def _heights(model: Model) -> str:
    """Between which heights the tool cuts this track of a disc, mm."""
    groove, width = model.mechanism.face_groove, model.mechanism.width
    return "{:.9g} and {:.9g}".format(*(0.0, width) if groove is None else sorted((groove.floor, groove.top)))


def _path(track: Track) -> PlaneCurve:
    """The path of a roller in a plate, from end to end."""

    def at(phi: Floats) -> tuple[Floats, Floats]:
        pose = track.pose(phi, 1)
        return pose.a[0][:2], pose.a[1][:2] * (1.0 if pose.pace is None else pose.pace)

    return PlaneCurve("pitch curve", "pitch", at, track.knots(), closed=False)


def _openings(model: Model) -> tuple[list[FullCircle], list[Stroke]]:
    """Bore, keyway, phase marks and plate rim of the model's parts, each once."""
    discs: dict[FullCircle, None] = {}
    strokes: dict[Stroke, None] = {}
    for part in model.parts:
        circles: list[tuple[Layer, Loop]] = []
        if isinstance(part, GroovedPlate):
            circles.append(("blank", part.rim))
        elif isinstance(part, Prism):
            circles += [("mark", hole) for hole in part.holes]
        for layer, loop in circles:
            if isinstance(loop.outline, CircleOutline):
                discs[FullCircle(layer, loop.outline.centre, loop.outline.radius)] = None
        if isinstance(part, GroovedPlate | Prism) and part.bore is not None:
            strokes[_bore_stroke(part.bore)] = None
    return list(discs), list(strokes)


def _bore_stroke(bore: Bore) -> Stroke:
    """The exact outline of a bore with its keyway, as lines and arcs."""
    r, h = 0.5 * bore.diameter, 0.5 * bore.keyway_width
    if not h:
        return Stroke("bore", ((r, 0.0), (-r, 0.0)), (1.0, 1.0), closed=True)
    half, top, wall = 0.5 * TURN - asin(h / r), r + bore.keyway_depth, sqrt(r * r - h * h)
    # Two arcs, each of less than half a turn, from the keyway's upper wall round to its lower one.
    bulge = float(np.tan(0.25 * half))
    points = ((wall, h), (-r, 0.0), (wall, -h), (top, -h), (top, h))
    return Stroke("bore", points, (bulge, bulge, 0.0, 0.0, 0.0), closed=True)


def _drum(model: Model, drum: Drum) -> list[PlaneView]:
    low, high, tracks = drum.low, drum.high, tuple(track for one in model.grooves for track in one.cutters)
    sense, roller = tracks[0].sense, model.setup.roller
    turns = range(
        floor(min(t.span[0] for t in tracks) / TURN + 1e-9), ceil(max(t.span[1] for t in tracks) / TURN - 1e-9)
    )
    base = [span.start for span in model.setup.program.spans]
    knots = [TURN * turn + start for turn in turns for start in base] + [TURN * turns.stop]
    several = len(model.grooves) > 1
    whose = " of the first groove's follower" if several else ""
    cut = "groove" if len(tracks[0].sides) > 1 else "rib" if len(tracks) > 1 else tracks[0].name
    room = roller.diameter if roller is not None and len(turns) > 1 else 1.0
    views = []
    for name, radius in drum_radii(drum.radius, model.mechanism.quoted_radius or drum.radius):
        word = "inner" if drum.hollow and name == "outer" else name
        places = [(radius * ((TURN - k) if sense > 0.0 else k), k) for k in knots]
        left, right = sorted((places[0][0], places[-1][0]))
        curves = tuple(
            replace(curve, name=curve.name.replace("groove", f"groove {one.groove + 1}", 1)) if several else curve
            for one in model.grooves for curve in developed(one.cutters, radius)
        )  # fmt: skip
        views.append(
            PlaneView(
                f"developed at the {word} radius",
                curves,
                (),
                (
                    Stroke("blank", ((left, low), (right, low), (right, high), (left, high)), closed=True),
                    *(Stroke("centre", ((x, low), (x, high + room))) for x, _ in places),
                ),
                tuple(Label((x, high + room), f"{degrees(k):.6g} deg") for x, k in places),
                (
                    f"{cut} rolled out at the {word} radius {radius:.9g} mm, seen from outside",
                    f"x = azimuth times radius, circumference {TURN * radius:.9g} mm; y = z of the cam frame",
                    f"thin lines: boundaries of the motion's segments{whose}, cam angle",
                ),
            )
        )
    return views


def _cone(model: Model, drum: Drum) -> list[PlaneView]:
    """A cone's groove rolled out about the apex, at the outside and at the pitch depth."""
    tracks, scale = model.cutters, sqrt(1.0 + drum.slope**2)
    sense, sine = tracks[0].sense, drum.slope / scale
    knots = [span.start for span in model.setup.program.spans] + [TURN]
    views = []
    for word, place in drum_radii(drum.radius, model.mechanism.quoted_radius or drum.radius):
        depth = drum.radius - place
        cone = ConeLevel(drum.radius - depth * scale, drum.slope)
        low, high = (cone.at(z) / sine for z in (drum.low, drum.high))
        wide, narrow = (low, high) if abs(low) > abs(high) else (high, low)

        def at(long: float, azimuth: float) -> tuple[float, float]:
            angle = sine * (azimuth - 0.5 * TURN)
            return float(long * np.sin(angle)), float(-long * np.cos(angle))

        bulge = float(np.tan(0.25 * TURN * sine))
        corners = (at(low, 0.0), at(low, TURN), at(high, TURN), at(high, 0.0))
        places = [((TURN - k) if sense > 0.0 else k, k) for k in knots]
        beyond = float(wide + np.copysign(0.05 * max(drum.at(drum.low), drum.at(drum.high)), wide))
        where = "outside" if word == "outer" else "pitch depth"
        views.append(
            PlaneView(
                f"developed at the {where}",
                rolled_out(tracks, cone, place),
                (),
                (
                    Stroke("blank", corners, (bulge, 0.0, -bulge, 0.0), closed=True),
                    *(Stroke("centre", (at(narrow, azimuth), at(beyond, azimuth))) for azimuth, _ in places),
                ),
                tuple(Label(at(2.0 * beyond - wide, azimuth), f"{degrees(k):.6g} deg") for azimuth, k in places),
                (
                    f"groove rolled out at the {where}, {depth:.9g} mm below the cone, seen from outside",
                    f"origin at the apex; a turn takes {degrees(TURN * abs(sine)):.9g} deg of the sector, "
                    f"from {abs(narrow):.9g} to {abs(wide):.9g} mm",
                    "thin lines: boundaries of the motion's segments, cam angle",
                ),
            )
        )
    return views


def _turret(model: Model, follower: TurretFollower) -> PlaneView:
    """The turret seen along its axis at cam angle zero; origin at the cam axis' foot, x towards the turret axis."""
    track = model.tracks[0]
    joint = track.joint
    assert isinstance(joint, Swing)
    centre, spin = np.array(joint.centre), np.array(joint.axis)
    towards = np.array([centre[0], centre[1], 0.0])
    distance = float(np.hypot(*towards[:2]))
    first = towards / distance
    second = np.array([0.0, 0.0, 1.0]) if abs(spin[2]) < 0.5 else np.cross(spin, first)
    frame = np.stack([first, second])
    strokes: list[Stroke] = []
    discs = [FullCircle("centre", (distance, 0.0), follower.pitch_radius)]
    radius = follower.pitch_radius
    for k in range(follower.count):
        turned = Track(**{**vars(track), "shift": track.shift + k * TURN / follower.count})
        pose = turned.pose(np.zeros(1), 0)
        a, u = frame @ pose.a[0][:, 0], frame @ pose.u[0][:, 0]
        delta, r = _meridian(track)
        if float(np.hypot(*u)) < 0.5:
            middle = (float(a[0]), float(a[1]))
            discs.append(FullCircle("rollers", middle, float(r.max())))
        else:
            across = np.array([-u[1], u[0]])
            one, two = a + delta[:, None] * u + r[:, None] * across, a + delta[:, None] * u - r[:, None] * across
            outline = np.concatenate([one, two[::-1]])
            strokes.append(Stroke("rollers", tuple(map(tuple, outline.tolist())), closed=True))
            middle_at = a + 0.5 * sum(track.contact) * u
            middle = (float(middle_at[0]), float(middle_at[1]))
        strokes.append(Stroke("centre", ((distance, 0.0), middle)))
    strokes.append(Stroke("centre", ((0.0, 0.0), (distance, 0.0))))
    strokes += _section(model)
    notes = (
        f"turret seen along its axis, {follower.stops} stops, {follower.count} rollers, cam angle 0",
        f"origin at the cam axis, turret axis at x = {distance:.9g} mm; pitch radius {radius:.9g} mm",
    )
    return PlaneView("turret", (), tuple(discs), tuple(strokes), (), notes)


def _meridian(track: Track) -> tuple[Floats, Floats]:
    """Places along a roller and its radii there, (m,) each, over the contact length and up to the tip."""
    low, high = sorted((min(*track.contact, track.tip), max(*track.contact, track.tip)))
    count = 65 if isinstance(track.meridian, Arc) else 2
    t = np.linspace(track.meridian.parameter(low), track.meridian.parameter(high), count)
    delta, _, _, r, _, _ = track.meridian.jet(t)
    return delta, r


def _section(model: Model) -> list[Stroke]:
    """The cam's blank in the plane of both axes, both halves of it: its exact lines and arcs."""
    blank = model.mechanism.blank
    if blank is None:
        return []
    arcs = blank.arcs or (None,) * (len(blank.outline) - 1)
    bulges = [_bulge(p, q, arc) for p, q, arc in zip(blank.outline, blank.outline[1:], arcs)]
    strokes = []
    for sign in (1.0, -1.0):
        points = tuple((sign * r, z) for r, z in blank.outline)
        strokes.append(Stroke("blank", points, (*(sign * b for b in bulges), 0.0)))
    for _, z in (blank.outline[0], blank.outline[-1]):
        reach = blank.outline[0][0]
        strokes.append(Stroke("blank", ((-reach, z), (reach, z))))
    return strokes


def _bulge(p: tuple[float, float], q: tuple[float, float], centre: tuple[float, float] | None) -> float:
    """tan of a quarter of the arc from p to q about the centre, positive counter-clockwise; 0 for a line."""
    if centre is None:
        return 0.0
    one, two = complex(p[0] - centre[0], p[1] - centre[1]), complex(q[0] - centre[0], q[1] - centre[1])
    angle = float(np.angle(two / one))
    return float(np.tan(0.25 * angle))
