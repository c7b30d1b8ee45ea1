"""Followers that touch the cam without a roller, for pictures: a flat face, or a knife edge."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.track import Track

if TYPE_CHECKING:
    from camgeom.model import Model

THICK = 0.12
"""thickness of a face plate as a share of its reach"""


class FaceMotion(Protocol):
    """A flat face seen from the cam: azimuth of its normal (rad) and distance from the cam axis (mm), each (3, n)."""

    @property
    def sense(self) -> float: ...

    @property
    def pivot(self) -> float | None: ...

    def jets(self, phi: Floats) -> tuple[Floats, Floats]: ...


def face_bodies(model: Model, phi: Floats) -> tuple[tuple[str, Mesh, Floats], ...]:
    """Name, mesh at pose identity, and machine-frame poses (n, 3, 4) of a follower without a roller."""
    if model.tracks:
        return ()
    face = getattr(model.setup.follower, "face", "")
    width = float(getattr(model.cam, "width", 0.0))
    if face == "flat" and hasattr(model.cam, "face_motion"):
        mesh, poses = flat_face(model.cam.face_motion(model.setup), width, phi)
        return (("flat face", mesh, poses),)
    if model.setup.follower.kind == "frame" and hasattr(model.cam, "span_between"):
        base = float(model.cam.base_radius)
        mesh = frame(float(model.cam.span_between(model.setup)), base, width)
        reach = base + model.setup.program.jet(phi, 0)[0]
        poses = np.zeros((len(phi), 3, 4))
        poses[:, range(3), range(3)], poses[:, 0, 3] = 1.0, reach
        return (("frame", mesh, poses),)
    if face == "knife" and hasattr(model.cam, "track"):
        from camgeom.report.sections.bodies import poses as carried

        track: Track = model.cam.track(model.setup)
        return (("knife edge", _wedge(track, width), carried(track, phi)),)
    return ()


def flat_face(motion: FaceMotion, width: float, phi: Floats) -> tuple[Mesh, Floats]:
    """Plate with its face through the origin and its outward normal along +X, and its poses.

    Its origin is the foot of the perpendicular from the pivot (or the cam axis) on the face, a point fixed to it.
    """
    azimuth, support = motion.jets(phi)
    angle = azimuth[0] + motion.sense * phi
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    along = np.stack([-np.sin(angle), np.cos(angle)], axis=-1)
    base = np.array([motion.pivot or 0.0, 0.0])
    origin = base - (normal @ base - support[0])[:, None] * normal
    touch = support[0][:, None] * normal + (support[1] / azimuth[1])[:, None] * along
    place = np.einsum("ni,ni->n", touch - origin, along)
    slack = 0.15 * float(np.ptp(place)) + 0.1 * float(support[0].max())
    low, high = float(place.min()) - slack, float(place.max()) + slack
    if motion.pivot is not None:  # the arm reaches back to its pivot
        low, high = min(low, -0.1 * motion.pivot), max(high, 0.1 * motion.pivot)
    mesh = box((0.0, low, -0.1 * width), (THICK * (high - low), high, 1.1 * width))
    poses = np.zeros((len(phi), 3, 4))
    poses[:, :2, 0], poses[:, :2, 1], poses[:, 2, 2], poses[:, :2, 3] = normal, along, 1.0, origin
    return mesh, poses


def frame(span: float, base: float, width: float) -> Mesh:
    """A frame about the cam: its near face through the origin across X, the far face `span` behind it.

    The cam's largest radius is span - base; its opening clears that.
    """
    thick, half = THICK * span, 1.05 * (span - base)
    inner = np.array([[-span, -half], [0.0, -half], [0.0, half], [-span, half]])
    outer = inner + thick * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    levels = (0.1 * width, 0.9 * width)
    vertices = np.vstack([np.column_stack([ring, np.full(4, z)]) for ring in (outer, inner) for z in levels])
    i, j = np.arange(4), (np.arange(4) + 1) % 4
    bands = ((0, 4, False), (8, 12, True), (0, 8, True), (4, 12, False))  # outside, inside, below, above
    faces = []
    for a, b, turned in bands:
        quads = np.stack([np.column_stack([a + i, a + j, b + j]), np.column_stack([a + i, b + j, b + i])]).reshape(
            -1, 3
        )
        faces.append(quads[:, ::-1] if turned else quads)
    return Mesh(vertices, np.ascontiguousarray(np.vstack(faces), dtype=np.int32))


def box(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    """A box between two corners."""
    corners = np.array([[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])])
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    return Mesh(corners, np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32))


def _wedge(track: Track, width: float) -> Mesh:
    """A prism with its edge at the track's anchor, pointing at the cam axis."""
    edge = np.array(track.anchor[:2])
    out = edge / max(float(np.hypot(*edge)), 1e-9)
    size = 0.35 * float(np.hypot(*edge))
    across = np.array([-out[1], out[0]])
    ring = np.array([edge, edge + size * (out - 0.3 * across), edge + size * (out + 0.3 * across)])
    vertices = np.vstack([np.column_stack([ring, np.full(3, z)]) for z in (-0.05 * width, 1.05 * width)])
    i, j = np.arange(3), (np.arange(3) + 1) % 3
    sides = np.vstack([np.column_stack([i, j, j + 3]), np.column_stack([i, j + 3, i + 3])])
    mesh = Mesh(vertices, np.vstack([sides, [[0, 2, 1], [3, 4, 5]]]).astype(np.int32))
    return mesh if mesh.volume > 0.0 else Mesh(vertices, np.ascontiguousarray(mesh.faces[:, ::-1]))
