"""Design drawing: true sections of the bodies with rollers and main dimensions, and the groove developed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.errors import DesignError
from camgeom.flank import Flank
from camgeom.maths.mesh import Floats, Mesh
from camgeom.report.content import (
    Axis,
    Block,
    Chart,
    Dimension,
    Drawing,
    Leader,
    Panel,
    Path,
    Region,
    Series,
    Text,
)
from camgeom.report.numerals import number
from camgeom.report.sections.bodies import cam_meshes, placed, poses, roller_meshes
from camgeom.track import Swing, Track

if TYPE_CHECKING:
    from camgeom.model import Model

AXIAL, ACROSS = ("z", "x"), ("x", "y")


def design(model: Model) -> tuple[Block, ...]:
    """Axial section, cross-section through the roller, and for drums the developed groove."""
    try:
        meshes = cam_meshes(model)
    except DesignError as error:
        return (Text((f"No body can be drawn: {error}.",)), *developed(model))
    return (axial(model, meshes), across(model, meshes), *developed(model))


Meshes = tuple[tuple[str, Mesh], ...]


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


def _rollers(model: Model, plane: int, level: float, axes: tuple[str, str]) -> tuple[Path, ...]:
    """Outlines of the rollers where they stand at cam angle 0 and meet the plane."""
    start = np.zeros(1)
    paths = []
    for _, mesh, track in roller_meshes(model):
        there = placed(mesh, poses(track, start)[0])
        paths += [Path(loop, "ghost", closed=True) for loop in _flat(outlines(there, plane, level), axes)]
    return tuple(paths)


def axial(model: Model, meshes: Meshes) -> Drawing:
    """Section through the cam axis and the X axis, seen along +Y."""
    regions = _regions(meshes, 1, 0.0, AXIAL)
    everything = np.concatenate([mesh.vertices for _, mesh in meshes])
    low, high = everything.min(axis=0), everything.max(axis=0)
    size = high - low
    reach = float(np.hypot(everything[:, 0], everything[:, 1]).max())
    paths = [Path(np.array([[low[2] - 0.06 * size[2], 0.0], [high[2] + 0.06 * size[2], 0.0]]), "axis")]
    dimensions = [Dimension((float(low[2]), -reach), (float(high[2]), -reach), number(float(size[2]), 6), "below")]
    round_body = abs(size[0] - 2.0 * reach) < 1e-3 * reach and abs(size[1] - 2.0 * reach) < 1e-3 * reach
    if round_body:
        dimensions.append(Dimension((float(low[2]), -reach), (float(low[2]), reach), f"⌀ {number(2.0 * reach, 6)}", "left"))
    bore = _bore(model)
    if bore:
        dimensions.append(Dimension((float(high[2]), -0.5 * bore), (float(high[2]), 0.5 * bore), f"⌀ {number(bore, 6)}", "right"))
    rollers = _rollers(model, 1, 0.0, AXIAL)
    leaders = list(_roller_notes(model, AXIAL))
    for track in model.tracks[:1]:
        joint = track.joint
        if not isinstance(joint, Swing):
            z = float(_stand(track)[2])
            if low[2] < z < high[2]:
                dimensions.append(Dimension((float(low[2]), reach), (z, reach), number(z - float(low[2]), 6), "above"))
        elif abs(joint.axis[1]) > 0.99:  # a turret: its axis is a point in this view
            x, z = joint.centre[0], joint.centre[2]
            paths += _cross(z, x, 0.05 * reach)
            dimensions.append(Dimension((z, 0.0), (z, x), number(abs(x), 6), "right"))
            leaders.append(Leader((z, x), "turret axis"))
    return Drawing("Section through the cam axis, follower at cam angle 0", (*paths, *rollers), (), regions, tuple(dimensions), tuple(leaders))


def across(model: Model, meshes: Meshes) -> Drawing:
    """Section across the cam axis through the roller, seen from +Z."""
    everything = np.concatenate([mesh.vertices for _, mesh in meshes])
    low, high = everything.min(axis=0), everything.max(axis=0)
    tracks = model.tracks
    level = float(0.5 * (low[2] + high[2]))
    if tracks:
        stand = float(_stand(tracks[0])[2])
        level = stand if low[2] < stand < high[2] else level
    reach = float(np.hypot(everything[:, 0], everything[:, 1]).max())
    regions = _regions(meshes, 2, level + 1e-6 * reach, ACROSS)
    paths = [
        Path(np.array([[-1.08 * reach, 0.0], [1.08 * reach, 0.0]]), "axis"),
        Path(np.array([[0.0, -1.08 * reach], [0.0, 1.08 * reach]]), "axis"),
    ]
    leaders = list(_roller_notes(model, ACROSS))
    dimensions = [
        Dimension((float(low[0]), 0.0), (float(high[0]), 0.0), number(float(high[0] - low[0]), 6), "below"),
        Dimension((0.0, float(low[1])), (0.0, float(high[1])), number(float(high[1] - low[1]), 6), "left"),
    ]
    for track in tracks:
        if abs(track.axis[2]) > 0.99:  # rollers parallel to the cam axis: the pitch curve lies in this view
            curve = track.pose(np.linspace(*track.span, 361), 0).a[0][:2].T
            paths.append(Path(curve, "axis"))
            at = curve[len(curve) // 6]
            leaders.append(Leader((float(at[0]), float(at[1])), f"pitch curve, {track.name}"))
        joint = track.joint
        if isinstance(joint, Swing) and abs(joint.axis[2]) > 0.99 and track is tracks[0]:
            x, y = joint.centre[:2]
            paths += _cross(x, y, 0.05 * reach)
            dimensions.append(Dimension((0.0, 0.0), (x, y), number(abs(x), 6), "above"))
            leaders.append(Leader((x, y), "pivot"))
    rollers = _rollers(model, 2, level + 1e-6 * reach, ACROSS)
    caption = f"Section across the cam axis at z = {number(level)} mm, seen from +Z, follower at cam angle 0"
    return Drawing(caption, (*paths, *rollers), (), regions, tuple(dimensions), tuple(leaders))


def _cross(x: float, y: float, half: float) -> list[Path]:
    return [
        Path(np.array([[x - half, y], [x + half, y]]), "axis"),
        Path(np.array([[x, y - half], [x, y + half]]), "axis"),
    ]


def _stand(track: Track) -> Floats:
    """Middle of the roller's contact length at cam angle 0, machine frame."""
    pose = track.pose(np.zeros(1), 0)
    return np.asarray(pose.a[0][:, 0] + 0.5 * sum(track.contact) * pose.u[0][:, 0])


def _roller_notes(model: Model, axes: tuple[str, str]) -> tuple[Leader, ...]:
    roller: Any = model.setup.roller
    if roller is None or not model.tracks:
        return ()
    place = _stand(model.tracks[0])
    to = float(place["xyz".index(axes[0])]), float(place["xyz".index(axes[1])])
    length = f", contact length {number(roller.length, 6)}" if roller.length else ""
    return (Leader(to, f"roller ⌀ {number(roller.diameter, 6)}{length}"),)


def _bore(model: Model) -> float:
    bore = getattr(model.cam, "bore", 0.0)
    return float(bore) if isinstance(bore, int | float) else 0.0


def developed(model: Model) -> tuple[Block, ...]:
    """Groove edges unrolled at the outer end of the contact, for rollers that stand radially on a drum."""
    radial = [track for track in model.tracks if abs(track.axis[0]) > 0.99 and not _turret(track)]
    if not radial:
        return ()
    series = []
    radius = radial[0].contact[1]
    for track in radial:
        t = np.array([track.meridian.parameter(track.contact[1])])
        low, high = track.span
        phi = np.linspace(low + 1e-9, high - 1e-9, 721)
        for side in track.sides:
            x = Flank(track, phi, t, side).x[:, :, 0]
            around = -track.sense * np.unwrap(np.arctan2(x[1], x[0]))
            name = "edges" if len(track.sides) > 1 else f"edge, {track.name}"
            series.append(Series(name, np.degrees(around), x[2], 0))
        pose = track.pose(phi, 0)
        centre = pose.a[0][:, :] + track.contact[1] * pose.u[0]
        around = -track.sense * np.unwrap(np.arctan2(centre[1], centre[0]))
        series.append(Series("roller axis", np.degrees(around), centre[2], 4))
    axis = Axis("Angle round the drum against its turning", "°", 0.0, 360.0)
    length = getattr(model.cam, "length", None)
    panel = Panel(Axis("Height z", "mm", 0.0, length), tuple(series), height=1.3)
    return (Chart(f"Groove developed at radius {number(radius)} mm", axis, (panel,)),)


def _turret(track: Track) -> bool:
    return isinstance(track.joint, Swing) and abs(track.joint.axis[1]) > 0.99


__all__ = ["across", "axial", "design", "developed", "outlines"]
