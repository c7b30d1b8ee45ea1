"""Design drawing: true sections of the bodies with rollers and main dimensions, and the groove developed."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, final

import numpy as np

from camgeom.drawing.content import (
    Axis,
    Block,
    Chart,
    Circle,
    Dimension,
    Drawing,
    Leader,
    Panel,
    Path,
    Region,
    Series,
    Table,
    Text,
    quantities,
)
from camgeom.drawing.sheet import number
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.hidden import edges_behind
from camgeom.maths.mesh import Mesh
from camgeom.report.sections.bodies import cam_meshes, carrier_meshes, face_bodies, kept, placed, poses, roller_meshes
from camgeom.solid.mechanism import Drive
from camgeom.track import TURN, Swing, Track
from camgeom.track.flank import Flank
from camgeom.track.follower import ConeRoller

if TYPE_CHECKING:
    from camgeom.model import Model

AXIAL, ACROSS, END = ("z", "x"), ("x", "y"), ("y", "z")
SPARE = 3.0
"""deg by which a line runs on beyond the turn, so that it ends at the frame"""


def design(model: Model) -> tuple[Block, ...]:
    """Axial section, cross-section through the roller, and for drums the developed groove."""
    try:
        meshes = cam_meshes(model)
    except DesignError as error:
        return (Text((f"No body can be drawn: {error}.",)), *developed(model), *named(model))
    return (*views(model, meshes), *developed(model), *named(model))


def named(model: Model) -> tuple[Table, ...]:
    """The measures that the standards of the kind have names for; none of others."""
    rows = [(key.removesuffix("_mm").replace("_", " ").capitalize(), value, "mm")
            for key, value in model.mechanism.named.items()]  # fmt: skip
    return (quantities("Measures by their names", rows),) if rows else ()


def views(model: Model, meshes: Meshes) -> tuple[Drawing, ...]:
    """Both sections, first the one that shows more: a plate shows its shape from above, with each of its tracks."""
    if model.mechanism.box is not None:
        return kept(model, "section drawings", lambda: plate_views(model, meshes, True))
    flat = _plate(model)
    shown = kept(model, "section drawings", lambda: (
        axial(model, meshes), *(across(one, meshes) for one in (model.grooves if flat else (model,)))
    ))  # fmt: skip
    return (*shown[1:], shown[0], *frame_view(model)) if flat else shown


Meshes = tuple[tuple[str, Mesh], ...]


def part_views(model: Model, meshes: Meshes) -> tuple[Drawing, ...]:
    """The cam alone, as its drawing shows it: the section through its axis, and one across every body."""
    if model.mechanism.box is not None:
        return plate_views(model, meshes, False)
    several = len(meshes) > 1
    caption = f"Section through the cam axis{_leaning(model)}"
    across_each = [_section(model, mesh, name if several else "") for name, mesh in meshes]
    if len(model.grooves) > 1 and _plate(model):
        across_each = [_section(one, meshes[0][1], "") for one in model.grooves]
    return (replace(_alone(model, meshes), caption=caption), *across_each[:MOST_SECTIONS], *frame_view(model))


def frame_view(model: Model) -> tuple[Drawing, ...]:
    """The frame that is a part, cut through its middle plane, with its sizes; none of other cams."""
    plate, mass = model.mechanism.frame, model.frame_mass
    if plate is None or model.frame is None or mass is None:
        return ()
    mesh, level = model.frame.mesh, plate.height * (1.0 + 1e-9)
    (low, high), middle, side, near = plate.ends, plate.middle, 0.5 * plate.width, 0.5 * plate.opening
    face, wide = 0.5 * plate.face, 0.5 * plate.window
    over = 0.04 * plate.length
    paths = [Path(np.array([[low - over, y], [high + over, y]]), "axis") for y in (0.0, *plate.rods)]
    paths += _behind((("frame", mesh),), 2, level, ACROSS)
    dimensions = [
        Dimension((middle - near, 0.0), (middle + near, 0.0), number(plate.opening, 7), "below"),
        Dimension((low, -side), (high, -side), number(plate.length, 6), "below"),
        Dimension((low, -side), (low, side), number(plate.width, 6), "left"),
        Dimension((middle + near, -face), (middle + near, face), number(plate.face, 6), "right"),
    ]
    if plate.rise:
        reach = near + plate.rise
        dimensions += [Dimension((middle - reach, wide), (middle + reach, wide), number(2.0 * reach, 7), "above"),
                       Dimension((middle, -wide), (middle, wide), number(plate.window, 6), "right")]  # fmt: skip
    leaders = []
    if plate.corner:
        leaders.append(Leader((middle - near - 0.7 * plate.rise, wide), f"4 × R{number(plate.corner, 6)}"))
    if plate.bore:
        dimensions.append(Dimension((high, plate.rods[0]), (high, plate.rods[1]), number(plate.spacing, 6), "right"))
        leaders.append(Leader((low, plate.rods[1]), f"2 × ⌀ {number(plate.bore, 6)}"))
    caption = (f"Frame, {number(plate.thickness, 6)} mm thick, {number(mass, 4)} kg; section at "
               f"z = {number(plate.height, 6)} mm, seen from +Z")  # fmt: skip
    region = Region(_flat(outlines(mesh, 2, level), ACROSS))
    return (Drawing(caption, tuple(paths), (), tuple(dimensions), tuple(leaders), (region,)),)


MOST_SECTIONS = 3
"""across bodies, on one sheet"""


def _alone(model: Model, meshes: Meshes) -> Drawing:
    """The section through the axis with the sizes of the blank, of the bore, and of every body along the axis."""
    size = _Size.of(model, meshes)
    low, high, reach = float(size.low[2]), float(size.high[2]), size.reach
    over = 0.06 * (high - low)
    paths = [Path(np.array([[low - over, 0.0], [high + over, 0.0]]), "axis"), *_beyond(model, meshes)]
    dimensions = [Dimension((low, -reach), (high, -reach), number(high - low, 5), "below")]
    if len(meshes) > 1:
        ends = [(float(mesh.vertices[:, 2].min()), float(mesh.vertices[:, 2].max())) for _, mesh in meshes]
        dimensions += [Dimension((a, -reach), (b, -reach), number(b - a, 5), "below") for a, b in ends]
    if size.round or not _plate(model):
        dimensions.append(Dimension((low, -reach), (low, reach), f"⌀ {number(2.0 * reach, 5)}", "left"))
    dimensions += _inside(model, high)
    paths += _behind(meshes, 1, 0.0, AXIAL)
    leaders = []
    for whose, track in [(one, track) for one in model.grooves for track in one.tracks[:1]]:
        if _plate(model) or isinstance(track.joint, Swing):
            continue
        z = _face(track) if whose.mechanism.drive is Drive.ALONE else _height(whose, track)
        if low < z < high:
            dimensions.append(Dimension((low, reach), (z, reach), number(z - low, 6), "above"))
            leaders += _depth_notes(whose, track)
    return Drawing("", tuple(paths), (), tuple(dimensions), tuple(leaders), _regions(meshes, 1, 0.0, AXIAL))


def _plate(model: Model) -> bool:
    """Whether the profile lies across the axis, as that of discs does."""
    return not model.tracks or abs(model.tracks[0].axis[2]) > 0.99


def _beyond(model: Model, meshes: Meshes) -> list[Path]:
    """Ends of plates behind the plane of the axial section, where they reach farther than in it."""
    if not _plate(model):
        return []
    found = []
    for _, mesh in meshes:
        behind = mesh.vertices[mesh.vertices[:, 1] > 0.0]
        cut = np.concatenate(outlines(mesh, 1, 0.0))
        faces = [float(mesh.vertices[:, 2].min()), float(mesh.vertices[:, 2].max())]
        near = 1e-9 * (faces[1] - faces[0])
        for way in (1.0, -1.0):  # a flank that leans reaches another place at either face
            end, there = (
                [float((way * x[np.abs(x[:, 2] - z) <= near, 0]).max()) for z in faces] for x in (behind, cut)
            )
            if any(one > other for one, other in zip(end, there)):
                shown = [(faces[0], there[0]), (faces[0], end[0]), (faces[1], end[1]), (faces[1], there[1])]
                found.append(Path(np.array(shown) * [1.0, way]))
    return found


def _leaning(model: Model) -> str:
    """By how much the flanks of a disc lean from its axis, in words; empty where none does."""
    told = ""
    for one in model.grooves:
        walls = one.profiles.walls if one.profiles is not None else ()
        leans = {wall.name: f"{number(abs(np.degrees(wall.lean)), 6)}°" for wall in walls if wall.lean}
        alike = len(set(leans.values())) == 1 and len(leans) == len(walls)
        each = tuple(leans.values())[:1] if alike else tuple(f"{lean} ({name})" for name, lean in leans.items())
        whose = f" of follower {one.number + 1}" if len(model.grooves) > 1 else ""
        told += f"; flank{whose} leans by {', '.join(each)}" if each else ""
    return told


def _draw_base(model: Model, circles: list[Circle], leaders: list[Leader]) -> None:
    """The base circle and its diameter, of cams that have one."""
    base = model.mechanism.base_radius
    if base is not None:
        circles.append(Circle((0.0, 0.0), base, "hidden"))
        leaders.append(Leader((-0.8 * base, -0.6 * base), f"base circle ⌀ {number(2.0 * base, 6)}"))


def _section(model: Model, mesh: Mesh, name: str) -> Drawing:
    """The section across one body with the sizes of that section and of its keyway."""
    low, high = (float(end(mesh.vertices[:, 2])) for end in (np.min, np.max))
    stand = float(_stand(model.tracks[0])[2]) if model.tracks else low
    told = stand if low < stand < high and not name else 0.5 * (low + high)
    level = told + 1e-6 * (high - low)
    loops = _flat(outlines(mesh, 2, level), ACROSS)
    points = np.concatenate(loops)
    (left, bottom), (right, top) = points.min(axis=0).tolist(), points.max(axis=0).tolist()
    over = 1.08 * float(np.abs(points).max())
    paths = [Path(np.array([[-over, 0.0], [over, 0.0]]), "axis"), Path(np.array([[0.0, -over], [0.0, over]]), "axis")]
    dimensions = []
    if _plate(model) and not _Size.of(model, ((name, mesh),)).round:  # else its diameter stands at the other view
        dimensions += [Dimension((left, 0.0), (right, 0.0), number(right - left, 5), "below"),
                       Dimension((0.0, bottom), (0.0, top), number(top - bottom, 5), "left")]  # fmt: skip
    paths += _behind(((name, mesh),), 2, level, ACROSS)
    circles: list[Circle] = []
    leaders: list[Leader] = []
    if not name:
        _draw_base(model, circles, leaders)
    if (bore := model.mechanism.bore) is not None and bore.keyway_width:
        wall, half = 0.5 * bore.diameter + bore.keyway_depth, 0.5 * bore.keyway_width
        dimensions += [
            Dimension((wall, -half), (wall, half), number(bore.keyway_width, 6), "right"),
            Dimension((-0.5 * bore.diameter, 0.0), (wall, 0.0), number(bore.diameter + bore.keyway_depth, 6), "above"),
        ]
    way = "clockwise" if model.mechanism.sense < 0.0 else "counter-clockwise"
    head = f"{name[:1].upper()}{name[1:]}, section" if name else "Section"
    caption = f"{head} at z = {_place(told)} mm, seen from +Z; turns {way}"
    return Drawing(caption, tuple(paths), tuple(circles), tuple(dimensions), tuple(leaders), (Region(loops),))


def _place(level: float) -> str:
    """A coordinate, mm, to a micrometre: what rounding leaves of a zero is none."""
    return number(round(level, 3) + 0.0)


def outlines(mesh: Mesh, axis: int, level: float) -> tuple[Floats, ...]:
    """Closed outlines (k, 3) where a closed mesh meets the plane x[axis] = level.

    Vertices on the plane count as above it, so every outline closes by the mesh's own topology.
    """
    above = mesh.vertices[:, axis] >= level
    faces = mesh.faces[(above[mesh.faces].any(axis=1)) & ~(above[mesh.faces].all(axis=1))]
    following: dict[tuple[int, int], tuple[int, int]] = {}
    for face in faces.tolist():
        ends: dict[bool, tuple[int, int]] = {}
        for a, b in zip(face, (*face[1:], face[0])):
            if above[a] != above[b]:
                ends[bool(above[a])] = (min(a, b), max(a, b))
        following[ends[True]] = ends[False]
    loops = []
    while following:
        first, edge = following.popitem()
        loop = [first]
        while edge != first:
            loop.append(edge)
            edge = following.pop(edge)
        a, b = mesh.vertices[np.array(loop).T]
        share = (level - a[:, axis]) / (b[:, axis] - a[:, axis])
        loops.append(a + share[:, None] * (b - a))
    return tuple(loops)


def _flat(loops: tuple[Floats, ...], axes: tuple[str, str]) -> tuple[Floats, ...]:
    columns = ["xyz".index(axis) for axis in axes]
    return tuple(np.ascontiguousarray(loop[:, columns]) for loop in loops)


def _regions(meshes: Meshes, plane: int, level: float, axes: tuple[str, str]) -> tuple[Region, ...]:
    found = [_flat(outlines(mesh, plane, level), axes) for _, mesh in meshes]
    return tuple(Region(loops) for loops in found if loops)


def _followers(model: Model, plane: int, level: float, axes: tuple[str, str]) -> tuple[Path, ...]:
    """Outlines of the follower where it stands at cam angle 0 and meets the plane; left out where it stands aside."""
    start = np.zeros(1)
    bodies = [(mesh, poses(track, start)) for _, mesh, track in roller_meshes(model) if _meets(track, plane, level)]
    if bodies or not model.tracks:
        bodies += [(mesh, poses(track, start)) for _, mesh, track in carrier_meshes(model)]
        bodies += [(mesh, moved) for _, mesh, moved in face_bodies(model, start)]
    paths = []
    for mesh, moved in bodies:
        there = placed(mesh, moved[0])
        loops = _flat(outlines(there, plane, level), axes)
        paths += [Path(loops[0], "ghost", True, loops[1:])] if loops else []
    return tuple(paths)


def _meets(track: Track, plane: int, level: float) -> bool:
    """Whether the plane goes through the roller as it stands at cam angle 0."""
    reach = float(track.meridian.jet(np.array([track.meridian.parameter(0.5 * sum(track.contact))]))[3][0])
    return abs(float(_stand(track)[plane]) - level) < 0.9 * max(reach, 0.5 * abs(track.contact[1] - track.contact[0]))


@final
@immutable
class _Size:
    """Bounds of all cam bodies, mm: low and high corners (3,), largest radius, and whether the outline is round."""

    low: Floats
    high: Floats
    reach: float
    round: bool

    @classmethod
    def of(cls, model: Model, meshes: Meshes) -> _Size:
        everything = np.concatenate([mesh.vertices for _, mesh in meshes])
        low, high = everything.min(axis=0), everything.max(axis=0)
        reach = float(np.hypot(everything[:, 0], everything[:, 1]).max())
        wide = (high - low)[:2]
        is_round = bool(np.all(np.abs(wide - 2.0 * reach) < 2e-3 * reach))
        nominal = model.mechanism.outside_diameter
        return cls(low, high, 0.5 * nominal if is_round and nominal else reach, is_round)


def axial(model: Model, meshes: Meshes) -> Drawing:
    """Section through the cam axis and the X axis, seen along +Y."""
    size = _Size.of(model, meshes)
    low, high, reach = float(size.low[2]), float(size.high[2]), size.reach
    over = 0.06 * (high - low)
    paths = [Path(np.array([[low - over, 0.0], [high + over, 0.0]]), "axis")]
    dimensions = [Dimension((low, -reach), (high, -reach), number(high - low, 5), "below")]
    if size.round:
        dimensions.append(Dimension((low, -reach), (low, reach), f"⌀ {number(2.0 * reach, 5)}", "left"))
    dimensions += _inside(model, high)
    paths += _behind(meshes, 1, 0.0, AXIAL)
    leaders: list[Leader] = []
    # A follower that stands elsewhere about the cam is not in this section.
    shown = []
    for one in model.grooves:
        ghosts = () if one.angle else _followers(one, 1, 0.0, AXIAL)
        paths += ghosts
        shown += [one.number + 1] if ghosts else []
        leaders += _roller_notes(one, AXIAL) if ghosts and any(_meets(track, 1, 0.0) for track in one.tracks) else []
    for whose, track in [(one, track) for one in model.grooves for track in one.tracks[:1]]:
        joint = track.joint
        if _plate(whose):
            continue
        if not isinstance(joint, Swing):
            z = _height(whose, track)
            if low < z < high:
                dimensions.append(Dimension((low, reach), (z, reach), number(z - low, 6), "above"))
                leaders += _depth_notes(whose, track)
        elif _turret(track):  # its axis is a point in this view
            x, z = joint.centre[0], joint.centre[2]
            paths += _cross(z, x, 0.05 * reach)
            # Away from the bore, whose size stands on the cam axis, too.
            dimensions.append(Dimension((z, 0.0), (z, x), number(abs(x), 6), "left"))
            leaders.append(Leader((z, x), "turret axis"))
    names = f" {' and '.join(map(str, shown))}" if len(model.grooves) > 1 else ""
    stands = f", follower{names} at cam angle 0" if shown else ""
    caption = f"Section through the cam axis{stands}{_leaning(model)}"
    regions = _regions(meshes, 1, 0.0, AXIAL)
    return Drawing(caption, tuple(paths), (), tuple(dimensions), tuple(leaders), regions)


def _inside(model: Model, high: float) -> list[Dimension]:
    """Sizes of the axial section beside length and outside: of the bore, which ends at `high`, and what a kind has."""
    found = []
    if model.mechanism.bore:
        bore, end = model.mechanism.bore.diameter, (model.mechanism.bored or (0.0, high))[1]
        found.append(Dimension((end, -0.5 * bore), (end, 0.5 * bore), f"⌀ {number(bore, 6)}", "right"))
    for one in [measure for each in model.grooves for measure in each.mechanism.measures]:
        text = f"⌀ {number(one.size, 6)}" if one.is_diameter else number(one.size, 6)
        found.append(Dimension(one.start, one.stop, text, "right" if one.is_diameter else "above"))
    return found


def _behind(meshes: Meshes, plane: int, level: float, axes: tuple[str, str]) -> list[Path]:
    """What is seen of the edges behind a section: along +Y of one through the axis, from +Z down of one across it."""
    sense, columns = 1.0 if plane == 1 else -1.0, ["xyz".index(axis) for axis in axes]
    bodies = [mesh for _, mesh in meshes]
    cut = [loop for mesh in bodies for loop in outlines(mesh, plane, level)]
    return [Path(np.ascontiguousarray(line[:, columns])) for line in edges_behind(bodies, plane, level, sense, cut)]


def across(model: Model, meshes: Meshes) -> Drawing:
    """Section across the cam axis through the roller, seen from +Z."""
    size = _Size.of(model, meshes)
    low, high, reach, tracks = size.low, size.high, size.reach, model.tracks
    stand = float(_stand(tracks[0])[2]) if tracks else low[2]
    told = float(stand if low[2] < stand < high[2] else 0.5 * (low[2] + high[2]))
    level = told + 1e-6 * reach
    over = 1.08 * reach
    paths = [Path(np.array([[-over, 0.0], [over, 0.0]]), "axis"), Path(np.array([[0.0, -over], [0.0, over]]), "axis")]
    dimensions = []
    if not size.round:
        if len(meshes) == 1:  # of a flank that leans the sizes of this section
            cut = np.concatenate(_flat(outlines(meshes[0][1], 2, level), ACROSS))
            low, high = cut.min(axis=0), cut.max(axis=0)
        wide, tall = (float(v) for v in (high - low)[:2])
        dimensions.append(Dimension((float(low[0]), 0.0), (float(high[0]), 0.0), number(wide), "below"))
        dimensions.append(Dimension((0.0, float(low[1])), (0.0, float(high[1])), number(tall), "left"))
    leaders = list(_roller_notes(model, ACROSS))
    circles: list[Circle] = []
    _draw_base(model, circles, leaders)
    if (bore := model.mechanism.bore) is not None and bore.keyway_width:
        bottom = 0.5 * bore.diameter + bore.keyway_depth
        across_both = number(bore.diameter + bore.keyway_depth, 6)
        text = f"keyway {number(bore.keyway_width, 6)} wide, {across_both} to the far wall"
        leaders.append(Leader((bottom, 0.5 * bore.keyway_width), text))
    for track in tracks:
        if abs(track.axis[2]) > 0.99:  # rollers parallel to the cam axis: the pitch curve lies in this view
            curve = np.ascontiguousarray(track.pose(np.linspace(*track.span, 361), 0).a[0][:2].T)
            paths.append(Path(curve, "axis"))
            x, y = (float(v) for v in curve[len(curve) // 6])
            leaders.append(Leader((x, y), f"pitch curve, {track.name}"))
    for track in tracks[:1]:
        joint = track.joint
        if isinstance(joint, Swing) and abs(joint.axis[2]) > 0.99:
            x, y = joint.centre[:2]
            paths += _cross(x, y, 0.05 * reach)
            dimensions.append(Dimension((0.0, 0.0), (x, y), number(abs(x), 6), "above"))
            leaders.append(Leader((x, y), "pivot"))
    paths += [*_behind(meshes, 2, level, ACROSS), *_followers(model, 2, level, ACROSS)]
    way = "clockwise" if model.mechanism.sense < 0.0 else "counter-clockwise"
    stands = "follower at cam angle 0"
    if len(model.grooves) > 1:
        stands = f"follower {model.number + 1} at cam angle {number(np.degrees(model.angle), 6)}°, its own 0"
    caption = f"Section at z = {_place(told)} mm, seen from +Z, {stands}; the cam turns {way}"
    regions = _regions(meshes, 2, level, ACROSS)
    return Drawing(caption, tuple(paths), tuple(circles), tuple(dimensions), tuple(leaders), regions)


def plate_views(model: Model, meshes: Meshes, with_follower: bool) -> tuple[Drawing, ...]:
    """A plate that slides: from above, cut through the middle of its roller, and cut across where that is at zero
    travel."""
    box, carriage = model.mechanism.box, model.mechanism.carriage
    assert box is not None
    assert carriage is not None
    (length, width, thick), (track,) = box, model.tracks
    x, y, z = (float(v) for v in _stand(track))
    path = track.evenly.pose(np.linspace(0.0, TURN, 361), 0).a[0][:2].T
    (far, _), (floor, top) = path[-1].tolist(), sorted((model.cutters[0].tip, thick))
    flat = [Path(np.ascontiguousarray(path), "axis")]
    dimensions = [
        Dimension((0.0, 0.0), (length, 0.0), number(length, 6), "below"),
        Dimension((0.0, 0.0), (0.0, width), number(width, 6), "left"),
        Dimension((0.0, width), (x, y), number(x, 6), "above"),
        Dimension((x, y), (far, y), number(far - x, 6), "above"),
        Dimension((length, 0.0), (x, y), number(y, 6), "right"),
    ]
    leaders = [Leader((float(path[120, 0]), float(path[120, 1])), "pitch curve")]
    wide = 2.0 * float(model.cutters[0].meridian.jet(np.array([track.meridian.parameter(z)]))[3][0])
    if with_follower and isinstance(track.joint, Swing):
        pivot = track.joint.centre[:2]
        flat += _cross(*pivot, 0.03 * length)
        dimensions.append(Dimension(pivot, (x, y), number(float(np.hypot(x - pivot[0], y - pivot[1])), 6), "above"))
        leaders.append(Leader(pivot, "pivot"))
    grooved = model.mechanism.form == "groove"
    made = f"groove {number(wide, 6)} wide" if grooved else f"edge of a roller ⌀ {number(wide, 6)}"
    notes = _roller_notes(model, ACROSS) if with_follower else (Leader((x, y), made),)
    leaders += notes
    flat += _followers(model, 2, z, ACROSS) if with_follower else ()
    told = f", follower at zero travel; slides along -X by {number(carriage.stroke, 6)} mm" if with_follower else ""
    regions = _regions(meshes, 2, z + 1e-6 * thick, ACROSS)
    caption = f"Section at z = {number(z)} mm, seen from +Z{told}"
    above = Drawing(caption, tuple(flat), (), tuple(dimensions), tuple(leaders), regions)
    cut = _regions(meshes, 0, x + 1e-6 * length, END)
    if not grooved:
        width = max(float(loop[:, 0].max()) for region in cut for loop in region.loops)
    ends = [
        Dimension((0.0, 0.0), (width, 0.0), number(width, 6), "below"),
        Dimension((0.0, 0.0), (0.0, thick), number(thick, 6), "left"),
        *([Dimension((width, floor), (width, top), number(top - floor, 6), "right")] if grooved else []),
    ]
    ghosts = _followers(model, 0, x, END) if with_follower else ()
    across_it = Drawing(f"Section at x = {number(x, 6)} mm, seen from +X", tuple(ghosts), (), tuple(ends), (), cut)
    return above, across_it


def _depth_notes(model: Model, track: Track) -> list[Leader]:
    """How deep a drum's groove is, and how a cone leans."""
    drum = model.mechanism.drum
    if drum is None or drum.depth is None:
        return []
    word = "rib height" if model.mechanism.form == "rib" else "groove depth"
    floor = _stand(track, drum.floor)
    notes = [Leader((float(floor[2]), float(floor[0])), f"{word} {number(drum.depth, 6)}")]
    if drum.slope:
        z, lean = 0.97 * drum.high + 0.03 * drum.low, float(np.degrees(np.arctan(drum.slope)))
        notes.append(Leader((z, -drum.at(z)), f"half angle {number(abs(lean), 6)}°"))
    return notes


def _cross(x: float, y: float, half: float) -> list[Path]:
    return [
        Path(np.array([[x - half, y], [x + half, y]]), "axis"),
        Path(np.array([[x, y - half], [x, y + half]]), "axis"),
    ]


def _height(model: Model, track: Track) -> float:
    """Height z at which the roller's axis meets a drum's outside at cam angle 0, mm; of others that of its middle."""
    drum = model.mechanism.drum
    return float(_stand(track, None if drum is None else drum.radius)[2])


def _face(track: Track) -> float:
    """Height z of a track's one wall beside the middle of its roller at cam angle 0, mm: no roller is on the part."""
    station, (side,) = track.meridian.parameter(0.5 * sum(track.contact)), track.sides
    return float(Flank(track, np.zeros(1), np.array([station]), side).x[2, 0, 0])


def _stand(track: Track, place: float | None = None) -> Floats:
    """A place along the roller at cam angle 0, machine frame; None: the middle of its contact length."""
    pose = track.pose(np.zeros(1), 0)
    place = 0.5 * sum(track.contact) if place is None else place
    return np.asarray(pose.a[0][:, 0] + place * pose.u[0][:, 0])


def _roller_notes(model: Model, axes: tuple[str, str]) -> tuple[Leader, ...]:
    rollers = model.mechanism.rollers
    several = len(set(rollers)) > 1
    notes = []
    for track, roller in zip(model.tracks, rollers if several else rollers[:1]):
        place = _stand(track)
        to = float(place["xyz".index(axes[0])]), float(place["xyz".index(axes[1])])
        length = f", contact length {number(roller.length, 6)}" if roller.length else ""
        if isinstance(roller, ConeRoller):
            length = f", half angle {number(roller.half_angle, 6)}°{length}"
        name = f"{track.name} roller" if several else "roller"
        notes.append(Leader(to, f"{name} ⌀ {number(roller.diameter, 6)}{length}"))
    return tuple(notes)


def developed(model: Model) -> tuple[Block, ...]:
    """Groove edges unrolled where rollers that stand radially on a drum, or in a ring, leave it."""
    tracks = [track for one in model.grooves for track in one.tracks]
    radial = [track for track in tracks if abs(track.axis[0]) > 0.99 and not _turret(track)]
    if not radial:
        return ()
    series = []
    mouth = max(radial[0].contact, key=lambda place: abs(place - radial[0].tip))
    for track in radial:
        t = np.array([track.meridian.parameter(mouth)])
        low, high = track.span
        phi = np.linspace(low + 1e-9, high - 1e-9, 721)
        for side in track.sides:
            x = Flank(track, phi, t, side).x[:, :, 0]
            around = -track.sense * np.unwrap(np.arctan2(x[1], x[0]))
            name = "edges" if len(track.sides) > 1 else f"edge, {track.name}"
            series += _turns(name, np.degrees(around), x[2], 0)
        pose = track.pose(phi, 0)
        centre = pose.a[0][:, :] + mouth * pose.u[0]
        around = -track.sense * np.unwrap(np.arctan2(centre[1], centre[0]))
        series += _turns("roller axis", np.degrees(around), centre[2], 4)
    axis = Axis("Angle round the cam against its turning", "°", 0.0, 360.0)
    panel = Panel(Axis("Height z", "mm", *_heights(model)), tuple(series), height=1.3)
    return (Chart(f"Flanks developed at radius {number(mouth)} mm", axis, (panel,)),)


def _heights(model: Model) -> tuple[float | None, float | None]:
    """Lower and upper end of the drum, mm; unknown where it is undercut."""
    try:
        everything = np.concatenate([mesh.vertices[:, 2] for _, mesh in cam_meshes(model)])
    except DesignError:
        return None, None
    return round(float(everything.min()), 9), round(float(everything.max()), 9)


def _turns(name: str, angle: Floats, height: Floats, style: int) -> list[Series]:
    """A line over any angles, degrees, as lines over one turn: one for each turn that it passes through."""
    found = []
    for turn in range(int(np.floor(angle.min() / 360.0)), int(np.ceil(angle.max() / 360.0))):
        near = (angle >= 360.0 * turn - SPARE) & (angle <= 360.0 * (turn + 1) + SPARE)
        if np.count_nonzero(near) > 1:
            found.append(Series(name, angle[near] - 360.0 * turn, height[near], style))
    return found


def _turret(track: Track) -> bool:
    return isinstance(track.joint, Swing) and abs(track.joint.axis[1]) > 0.99
