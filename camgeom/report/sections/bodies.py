"""Bodies for pictures: the cam at picture resolution, and its follower: rollers, what carries them, faces, edges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from camgeom.maths import Floats, distinct
from camgeom.maths.frozen import once
from camgeom.maths.mesh import Mesh, rowed
from camgeom.track import TURN, Swing, Track
from camgeom.track.outline import FaceOutline, FlatFace, RollerOutline

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from camgeom.model import Model
    from camgeom.solid.mechanism import Mechanism

T = TypeVar("T")

KEPT: WeakKeyDictionary[Model, dict[str, Any]] = WeakKeyDictionary()

FINENESS = 1e-4
"""chord error of a picture as a share of the part's size: a tenth of a pixel on a screen"""
MOST_FACES = 60_000
ROWS = 17
"""heights at which a pressure that changes along the roller is shown"""
ROUND = 48
STUD = 0.45
"""stud radius as a share of the roller's"""
THICK = 0.12
"""thickness of a face plate as a share of its reach"""


def kept(model: Model, name: str, compute: Callable[[], T]) -> T:
    """What several sections share of a model: computed once as long as it lives, its cost booked under `name`."""
    return once(KEPT.setdefault(model, {}), name, model.ledger, compute)


def cam_meshes(model: Model) -> tuple[tuple[str, Mesh], ...]:
    """Name and mesh of every body of the cam, as fine as a picture needs. Raises DesignError where it is undercut."""

    def compute() -> tuple[tuple[str, Mesh], ...]:
        model.refuse_folded()
        rows = pressed_rows(model)
        return tuple((part.name, rowed(_coarse(model, i), rows, "flank")) for i, part in enumerate(model.parts))

    return kept(model, "picture mesh", compute)


def pressed_rows(model: Model) -> Floats:
    """Heights z, mm, between which the pressure of a planar cam's roller changes: its wall has vertices at its ends."""
    duties = [duty for one in model.bindings if one.planar is not None and one.profile.operation for duty in one.duties]
    rows = []
    for duty in duties:
        low, high = sorted(duty.track.contact)
        hair = 1e-4 * (high - low)
        rows.append(np.array([low - hair, low + hair, high - hair, high + hair]))
        if duty.level != "line":
            places = duty.pressed_places
            rows.append(np.linspace(max(places[0], low), min(places[1], high), ROWS))
    return distinct(np.concatenate(rows)) if rows else np.zeros(0)


def _coarse(model: Model, i: int) -> Mesh:
    part = model.parts[i]
    rough = part.solid(max(model.tolerance, 0.05)).mesh
    size = float((rough.vertices.max(axis=0) - rough.vertices.min(axis=0)).max())
    tolerance = max(model.tolerance, FINENESS * size)
    mesh = part.solid(tolerance).mesh
    while len(mesh.faces) > MOST_FACES and tolerance < 0.01 * size:
        tolerance *= 3.0
        mesh = part.solid(tolerance).mesh
    return mesh


def roller_meshes(model: Model) -> tuple[tuple[str, Mesh, Track], ...]:
    """Every roller at joint coordinate zero in the machine frame, with the track that moves it."""
    turret = model.mechanism.turret
    if turret is not None and turret.rollers:
        return tuple((f"roller {track.name}", roller_mesh(track), track) for track in turret.rollers)
    found = [(f"roller {track.name}", roller_mesh(track), track) for track in model.tracks]
    if turret is not None:
        found += _spare_rollers(model.tracks, turret.follower.count)
    return tuple(found)


def _spare_rollers(tracks: tuple[Track, ...], count: int) -> list[tuple[str, Mesh, Track]]:
    """The turret's rollers that cut no track of their own in this turn."""
    from dataclasses import replace

    step = TURN / count
    taken = {round((track.shift - tracks[0].shift) / step) % count for track in tracks}
    free = [k for k in range(count) if k not in taken]
    shifted = [replace(tracks[0], shift=tracks[0].shift + k * step) for k in free]
    return [("roller", roller_mesh(track), track) for track in shifted]


def roller_mesh(track: Track) -> Mesh:
    """The roller of a track with a stud at its back, a closed mesh at joint coordinate zero."""
    ends = (track.tip, *track.contact)
    low, high = min(ends), max(ends)
    tip, back = (high, low) if track.tip_sign > 0 else (low, high)
    delta = np.linspace(tip, back, 17)
    t = np.array([track.meridian.parameter(float(d)) for d in delta])
    radius = np.maximum(track.meridian.jet(t)[3], 1e-6)
    stud = STUD * float(radius[-1])
    reach = back + (back - tip) * 0.6
    profile = np.column_stack([np.r_[delta, back, reach], np.r_[radius, stud, stud]])
    return turned(profile, np.array(track.anchor), np.array(track.axis))


def turned(profile: Floats, origin: Floats, axis: Floats) -> Mesh:
    """Closed body of revolution: profile (k, 2) of (place along the axis, radius > 0), flat at both ends."""
    along = axis / np.linalg.norm(axis)
    helper = np.eye(3)[int(np.argmin(np.abs(along)))]
    first = np.cross(along, helper)
    first /= np.linalg.norm(first)
    second = np.cross(along, first)
    turn = TURN * np.arange(ROUND) / ROUND
    ring = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
    return lofted(origin + profile[:, :1, None] * along + profile[:, 1:, None] * ring[None])


def lofted(rings: Floats, hollow: bool = False) -> Mesh:
    """Closed body through rings of points (m, n, 3), flat at the first and last; a hollow one joins these instead."""
    m, n, _ = rings.shape
    i = np.arange(n)
    j, first, last = (i + 1) % n, np.full(n, m * n), (m - 1) * n
    neighbours = [(n * k, n * (k + 1) % (m * n)) for k in range(m if hollow else m - 1)]
    faces = [np.column_stack(f) for a, b in neighbours for f in ((a + i, a + j, b + j), (a + i, b + j, b + i))]
    vertices = rings.reshape(-1, 3)
    if not hollow:
        faces += [np.column_stack([j, i, first]), np.column_stack([last + i, last + j, first + 1])]
        vertices = np.vstack([vertices, rings[[0, -1]].mean(axis=1)])
    return _outward(Mesh(vertices, np.vstack(faces).astype(np.int32)))


def _outward(mesh: Mesh) -> Mesh:
    if mesh.volume >= 0.0:
        return mesh
    return Mesh(mesh.vertices, np.ascontiguousarray(mesh.faces[:, ::-1]), mesh.groups, mesh.group)


def carrier_meshes(model: Model) -> tuple[tuple[str, Mesh, Track], ...]:
    """Hub of a turret or arm of a swinging follower, with the track it moves with; nothing for other followers."""
    turret = model.mechanism.turret
    found = []
    seen: set[float] = set()
    for track in model.tracks:
        joint = track.joint
        if not isinstance(joint, Swing):
            continue
        if turret is not None and turret.dials:
            return tuple(("turret", _dial(joint, *dial), track) for dial in turret.dials)
        if turret is not None:
            return (("turret", _hub(track, joint), track),)
        if track.shift not in seen:
            seen.add(track.shift)
            found.append((f"arm {track.name}", _arm(track, joint), track))
    return tuple(found)


def _back(track: Track) -> Floats:
    """Middle of the roller's back end at joint coordinate zero."""
    ends = (track.tip, *track.contact)
    back = min(ends) if track.tip_sign > 0 else max(ends)
    return np.asarray(np.array(track.anchor) + back * np.array(track.axis))


def _radius(track: Track) -> float:
    return float(track.meridian.jet(np.array([track.meridian.parameter(0.5 * sum(track.contact))]))[3][0])


def _hub(track: Track, joint: Swing) -> Mesh:
    """A disc about the turret axis that ends short of the rollers' backs."""
    axis, centre = np.array(joint.axis), np.array(joint.centre)
    arm = _back(track) - centre
    arm -= (arm @ axis) * axis
    height = (_back(track) - centre) @ axis
    outer, half = 0.97 * float(np.linalg.norm(arm)), 0.75 * _radius(track)
    return turned(np.array([[height - half, outer], [height + half, outer]]), centre, axis)


def _dial(joint: Swing, radius: float, low: float, high: float) -> Mesh:
    """A disc about a turret axis along Z, between two heights z."""
    profile = np.array([[low, radius], [high, radius]])
    return turned(profile, np.array(joint.centre), np.array([0.0, 0.0, 1.0]))


def _arm(track: Track, joint: Swing) -> Mesh:
    """A bar from the pivot to the roller, behind the roller, as thick as the stud."""
    axis, pivot = np.array(joint.axis), np.array(joint.centre)
    end = _back(track)
    outward = -track.tip_sign * np.array(track.axis)
    lift = (end - pivot) @ axis
    foot = pivot + lift * axis
    along = end - foot
    length = float(np.linalg.norm(along))
    along = along / max(length, 1e-9)
    across = np.cross(axis, along)
    wide = STUD * 1.6 * _radius(track)
    turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 25)
    cap = wide * (np.cos(turn)[:, None] * along + np.sin(turn)[:, None] * across)
    other = wide * (-np.cos(turn)[:, None] * along - np.sin(turn)[:, None] * across)
    loop = np.vstack([end + cap, foot + other])
    gap = 0.15 * _radius(track)
    thick = max(0.5 * _radius(track), 1e-3)
    return lofted(np.stack([loop + (gap + h) * outward for h in (0.0, thick)]))


def poses(track: Track, phi: Floats) -> Floats:
    """Machine-frame poses (n, 3, 4) [R | t] of the follower that carries a track's roller, at cam angles phi, rad.

    The joint is asked where it carries the origin and the three axes.
    """
    coordinate = track.coordinate(phi, 0)
    joint = track.joint
    columns = [
        joint.carried((0.0, 0.0, 0.0), axis, coordinate)[1][0] for axis in ((1.0, 0, 0), (0, 1.0, 0), (0, 0, 1.0))
    ]
    origin = joint.carried((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), coordinate)[0][0]
    return np.ascontiguousarray(np.moveaxis(np.stack([*columns, origin], axis=1), 2, 0))


def follower_bodies(model: Model, phi: Floats) -> Iterator[tuple[str, str, Mesh, Floats]]:
    """Kind (roller, carrier, face), name, mesh and machine-frame poses (n, 3, 4) of every follower at cam angles phi.
    """
    for one in model.bindings:
        own, name = phi - one.angle, f", follower {one.number + 1}" if len(model.bindings) > 1 else ""
        turn = cam_poses(model.mechanism, np.array([one.angle]))[0, :, :3]
        for kind, meshes in (("roller", roller_meshes(one)), ("carrier", carrier_meshes(one))):
            for word, mesh, track in meshes:
                yield kind, word + name, mesh, turn @ poses(track, own)
        for word, mesh, moved in face_bodies(one, own):
            yield "face", word + name, mesh, turn @ moved


def cam_poses(mechanism: Mechanism, phi: Floats) -> Floats:
    """Poses (n, 3, 4) of the cam turning about Z, or sliding along -X."""
    sense, carriage = mechanism.sense, mechanism.carriage
    if carriage is not None:
        slid = np.repeat(np.eye(3, 4)[None], len(phi), axis=0)
        slid[:, 0, 3] = -carriage.travel(np.mod(phi, TURN))
        return slid
    c, s = np.cos(sense * phi), np.sin(sense * phi)
    out = np.zeros((len(phi), 3, 4))
    out[:, 0, 0] = out[:, 1, 1] = c
    out[:, 1, 0], out[:, 0, 1], out[:, 2, 2] = s, -s, 1.0
    return out


def placed(mesh: Mesh, pose: Floats) -> Mesh:
    """The mesh moved by one pose (3, 4)."""
    return Mesh(mesh.vertices @ pose[:, :3].T + pose[:, 3], mesh.faces, mesh.groups, mesh.group)


def face_bodies(model: Model, phi: Floats) -> tuple[tuple[str, Mesh, Floats], ...]:
    """Name, mesh at pose identity, and machine-frame poses (n, 3, 4) of a follower without a roller."""
    mechanism = model.mechanism
    if mechanism.tracks or not mechanism.touches:
        return ()
    outline, width, span = mechanism.touches[0].outline, mechanism.width, mechanism.span_between
    stated = model.profile.follower.face_width
    if mechanism.frame is not None:
        mesh = mechanism.frame.solid(max(model.tolerance, FINENESS * mechanism.frame.length)).mesh
        moved = np.zeros((len(phi), 3, 4))
        moved[:, range(3), range(3)], moved[:, 0, 3] = 1.0, mechanism.program.jet(phi, 0)[0]
        return (("frame", mesh, moved),)
    if span is not None and mechanism.base_radius is not None:
        mesh = frame(span, mechanism.base_radius, width, stated)
        reach = mechanism.base_radius + mechanism.program.jet(phi, 0)[0]
        moved = np.zeros((len(phi), 3, 4))
        moved[:, range(3), range(3)], moved[:, 0, 3] = 1.0, reach
        return (("frame", mesh, moved),)
    if isinstance(outline, FaceOutline):
        line = outline.line
        low, high = _touched(line)
        if stated is not None and line.pivot is None:
            middle = model.planar.centre if model.planar is not None else 0.0
            low, high = middle - 0.5 * stated, middle + 0.5 * stated
        elif stated is not None:  # from the pivot on, towards where the cam touches
            low, high = (0.0, stated) if high > -low else (-stated, 0.0)
        mesh, moved = flat_face(line, width, (low, high), phi)
        return (("flat face", mesh, moved),)
    if isinstance(outline, RollerOutline):
        return (("knife edge", _wedge(outline.track, width), poses(outline.track, phi)),)
    return ()


def _stood(motion: FlatFace, phi: Floats) -> tuple[Floats, Floats, Floats]:
    """Normal, direction along the face and origin, each (n, 2), machine frame; see `flat_face`."""
    azimuth, support = motion.jets(phi)
    angle = azimuth[0] + motion.sense * phi
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    along = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    base = np.array([motion.pivot or 0.0, 0.0])
    return normal, along, base - (normal @ base - support[0])[:, None] * normal


def _touched(motion: FlatFace) -> tuple[float, float]:
    """Ends of a plate along the face that holds every place where the cam touches it, mm; back to a pivot too."""
    phi = np.linspace(0.0, TURN, 361)
    azimuth, support = motion.jets(phi)
    normal, along, origin = _stood(motion, phi)
    touch = support[0][:, None] * normal + (support[1] / azimuth[1])[:, None] * along
    place = np.einsum("ni,ni->n", touch - origin, along)
    slack = 0.15 * float(np.ptp(place)) + 0.1 * float(support[0].max())
    low, high = float(place.min()) - slack, float(place.max()) + slack
    if motion.pivot is not None:
        low, high = min(low, -0.1 * motion.pivot), max(high, 0.1 * motion.pivot)
    return low, high


def flat_face(motion: FlatFace, width: float, ends: tuple[float, float], phi: Floats) -> tuple[Mesh, Floats]:
    """Plate with its face through the origin, its outward normal along +X, from end to end along +Y; and its poses.

    Its origin is the foot of the perpendicular from the pivot (or the cam axis) on the face, a point fixed to it.
    """
    low, high = ends
    normal, along, origin = _stood(motion, phi)
    thick = THICK * (high - low)
    ring = np.array([[0.0, low], [thick, low], [thick, high], [0.0, high]])
    mesh = lofted(_at_heights((ring, -0.1 * width), (ring, 1.1 * width)))
    moved = np.zeros((len(phi), 3, 4))
    moved[:, :2, 0], moved[:, :2, 1], moved[:, 2, 2], moved[:, :2, 3] = normal, along, 1.0, origin
    return mesh, moved


def frame(span: float, base: float, width: float, stated: float | None = None) -> Mesh:
    """A frame about the cam: its near face through the origin across X, the far face `span` behind it.

    stated  mm, width of its faces; as wide as the opening, which clears the cam's largest radius, span - base, without
    Faces narrower than the opening stand out from the frame.
    """
    thick, clear = THICK * span, 1.05 * (span - base)
    face = clear if stated is None else 0.5 * stated
    half = max(clear, face)
    # A quarter of each ring, from the middle of the near face to that of a side; the others mirror it.
    back = thick / 3.0 if face < half else 0.0
    inner = _mirrored(np.array([[0.0, face], [back, face], [back, half]]), span)
    outer = _mirrored(np.array([[thick, face], [thick, 0.5 * (face + half)], [thick, half + thick]]), span)
    low, high = 0.1 * width, 0.9 * width
    return lofted(_at_heights((outer, low), (outer, high), (inner, high), (inner, low)), hollow=True)


def _mirrored(quarter: Floats, span: float) -> Floats:
    """A closed ring (4 n, 2) about (-span / 2, 0) from its quarter at large x and y, counter-clockwise."""
    across = quarter * (-1.0, 1.0) - (span, 0.0)
    upper = np.concatenate([quarter, across[::-1]])
    return np.concatenate([upper, upper[::-1] * (1.0, -1.0)])


def _at_heights(*rings: tuple[Floats, float]) -> Floats:
    """Flat rings of points (n, 2), each at its z, as points (m, n, 3)."""
    return np.stack([np.column_stack([ring, np.full(len(ring), z)]) for ring, z in rings])


def _wedge(track: Track, width: float) -> Mesh:
    """A prism with its edge at the track's anchor, pointing at the cam axis."""
    edge = np.array(track.anchor[:2])
    out = edge / max(float(np.hypot(*edge)), 1e-9)
    size = 0.35 * float(np.hypot(*edge))
    across = np.array([-out[1], out[0]])
    ring = np.array([edge, edge + size * (out - 0.3 * across), edge + size * (out + 0.3 * across)])
    return lofted(_at_heights((ring, -0.05 * width), (ring, 1.05 * width)))
