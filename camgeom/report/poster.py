"""A still of a scene drawn without OpenGL: visible surfaces by a depth buffer, smooth shading, dark creases.

It stands on the page where the 3D view cannot start, so it is made with numpy alone, in a fraction of a second.
"""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass, field
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.drawing.colours import CARRIER, FLANK, ROLLER, STEEL, png_rgba
from camgeom.drawing.content import Scene
from camgeom.maths import Floats
from camgeom.maths.creases import crease_lines, shade
from camgeom.maths.mesh import Mesh

Ints = npt.NDArray[np.int64]
EYE = (1.0, -1.2, 0.8)
"""direction to the eye, as the 3D view begins"""
SIZE = (820, 500)
"""px, the text column by the height of the 3D view"""
FINER = 2
"""drawn this many times larger and averaged: smooth edges"""
MARGIN = 0.04
LIGHTS = (((-0.6, 0.9, 1.0), 0.56), ((1.0, 0.2, 0.4), 0.20), ((0.0, 0.0, 1.0), 0.16))
"""directions right, up and towards the eye, and their strengths"""
AMBIENT, EDGE = 0.30, 0.42
NEAR = 2e-3
"""share of the scene's size by which a crease lies before its faces"""
CHUNK = 2_000_000
"""pixels tried at once"""


def poster(scene: Scene, size: tuple[int, int] = SIZE) -> str:
    """PNG data URI of the scene at its first cam angle, on a transparent ground."""
    width, height = size[0] * FINER, size[1] * FINER
    toward = np.array(EYE) / np.linalg.norm(EYE)
    right = np.cross((0.0, 0.0, 1.0), toward)
    right /= np.linalg.norm(right)
    axes = np.array([right, np.cross(toward, right), toward])
    seen = [_seen(body.mesh, axes, None if body.poses is None else body.poses[0]) for body in scene.bodies]
    corners = np.concatenate([one.points for one in seen])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = float(np.min((1.0 - 2.0 * MARGIN) * np.array([width, height]) / np.maximum((high - low)[:2], 1e-9)))
    middle = 0.5 * (low + high)
    canvas = _Canvas(width, height)
    places = []
    for body, one in zip(scene.bodies, seen):
        at = (one.points - middle) * scale
        at = np.column_stack([0.5 * width + at[:, 0], 0.5 * height - at[:, 1], at[:, 2]])
        canvas.fill(at, one.faces, one.normals, _colours(body.role, body.name, body.mesh))
        places.append(at[one.lines])
    canvas.lines(np.concatenate(places), NEAR * scale * float(np.ptp(corners, axis=0).max()))
    return "data:image/png;base64," + b64encode(png_rgba(canvas.picture())).decode()


def _colours(role: str, name: str, mesh: Mesh) -> Floats:
    """Colour (f, 3) of every face: steel with blue flanks, orange rollers, sand for what carries them."""
    base = STEEL if role == "cam" else ROLLER if name.startswith("roller") else CARRIER
    colours = np.tile(np.array(base), (len(mesh.faces), 1))
    if role == "cam":
        colours[mesh.group_faces("flank")] = FLANK
    return colours


@final
@dataclass(frozen=True, eq=False)
class _Seen:
    """A body as the eye sees it: points (n, 3) right, up, towards; faces (f, 3); normals (n, 3); lines (e, 2)."""

    points: Floats
    faces: Ints
    normals: Floats
    lines: Ints


def _seen(mesh: Mesh, axes: Floats, pose: Floats | None) -> _Seen:
    drawn = shade(mesh)
    turn = axes if pose is None else axes @ pose[:, :3]
    shift = np.zeros(3) if pose is None else axes @ pose[:, 3]
    points = mesh.vertices @ turn.T + shift
    # Lines go between the mesh's own vertices, which stand behind the doubled ones.
    lines = crease_lines(mesh).astype(np.int64) + len(drawn.source)
    normals = np.concatenate([drawn.normals @ turn.T, np.zeros_like(points)])
    return _Seen(np.concatenate([points[drawn.source], points]), drawn.faces.astype(np.int64), normals, lines)


@final
@dataclass(eq=False)
class _Canvas:
    """Depth (larger is nearer), colour and cover of every pixel, row after row from the top."""

    width: int
    height: int
    depth: Floats = field(init=False)
    colour: Floats = field(init=False)

    def __post_init__(self) -> None:
        self.depth = np.full(self.width * self.height, -np.inf)
        self.colour = np.zeros((self.width * self.height, 3))

    def fill(self, points: Floats, faces: Ints, normals: Floats, colours: Floats) -> None:
        """Shade the faces that look at the eye; pixels where something nearer stands stay."""
        a, b, c = points[faces].transpose(1, 0, 2)
        double = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (c[:, 0] - a[:, 0]) * (b[:, 1] - a[:, 1])
        front = np.flatnonzero(double < -1e-9)  # y runs down, so a front face turns clockwise
        for part in np.array_split(front, max(1, int(np.abs(double[front]).sum()) // CHUNK)):
            self._fill(points, faces[part], normals, colours[part], double[part])

    def _fill(self, points: Floats, faces: Ints, normals: Floats, colours: Floats, double: Floats) -> None:
        a, b, c = points[faces].transpose(1, 0, 2)
        face, x, y = self._covered(a, b, c)
        v = ((x - a[face, 0]) * (c - a)[face, 1] - (y - a[face, 1]) * (c - a)[face, 0]) / double[face]
        w = ((y - a[face, 1]) * (b - a)[face, 0] - (x - a[face, 0]) * (b - a)[face, 1]) / double[face]
        depth = a[face, 2] + v * (b - a)[face, 2] + w * (c - a)[face, 2]
        pixel = y.astype(np.int64) * self.width + x.astype(np.int64)
        np.maximum.at(self.depth, pixel, depth)
        top = depth >= self.depth[pixel]
        face, pixel, v, w = face[top], pixel[top], v[top, None], w[top, None]
        n = [normals[faces[:, k]] for k in range(3)]
        normal = (1.0 - v - w) * n[0][face] + v * n[1][face] + w * n[2][face]
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        light = np.full(len(face), AMBIENT)
        for direction, strength in LIGHTS:
            light += strength * np.maximum(normal @ (np.array(direction) / np.linalg.norm(direction)), 0.0)
        self.colour[pixel] = np.minimum(colours[face] * light[:, None], 1.0)

    def _covered(self, a: Floats, b: Floats, c: Floats) -> tuple[Ints, Floats, Floats]:
        """Face and centre (k,) of every pixel inside the triangles, row by row of each."""
        ys = np.stack([a[:, 1], b[:, 1], c[:, 1]])
        first = np.maximum(np.ceil(ys.min(axis=0) - 0.5), 0.0)
        count = np.maximum(np.minimum(np.floor(ys.max(axis=0) - 0.5), self.height - 1.0) - first + 1.0, 0.0).astype(int)
        face = np.repeat(np.arange(len(a)), count)
        y = first[face] + np.arange(len(face)) - np.repeat(np.cumsum(count) - count, count) + 0.5
        left, right = np.full(len(face), np.inf), np.full(len(face), -np.inf)
        for p, q in ((a, b), (b, c), (c, a)):
            rise = (q - p)[face, 1]
            met = (p[face, 1] <= y) != (q[face, 1] <= y)
            x = p[face, 0] + (y - p[face, 1]) / np.where(met, rise, 1.0) * (q - p)[face, 0]
            left, right = np.where(met, np.minimum(left, x), left), np.where(met, np.maximum(right, x), right)
        first = np.maximum(np.ceil(left - 0.5), 0.0)
        count = np.maximum(np.minimum(np.floor(right - 0.5), self.width - 1.0) - first + 1.0, 0.0).astype(int)
        row = np.repeat(np.arange(len(face)), count)
        x = first[row] + np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count) + 0.5
        return face[row], x, y[row]

    def lines(self, ends: Floats, near: float) -> None:
        """Darken the pixels along lines (e, 2, 3) that nothing nearer hides."""
        count = np.ceil(1.5 * np.abs(ends[:, 1] - ends[:, 0])[:, :2].max(axis=1)).astype(int) + 1
        line = np.repeat(np.arange(len(ends)), count)
        share = (np.arange(len(line)) - np.repeat(np.cumsum(count) - count, count)) / np.maximum(count[line] - 1, 1)
        at = ends[line, 0] + share[:, None] * (ends[line, 1] - ends[line, 0])
        column, row = (np.clip(at[:, k].astype(np.int64), 0, top - 1) for k, top in ((0, self.width), (1, self.height)))
        pixel = row * self.width + column
        seen = np.unique(pixel[at[:, 2] + near >= self.depth[pixel]])
        self.colour[seen] *= EDGE
        self.depth[seen] = np.where(np.isfinite(self.depth[seen]), self.depth[seen], -1e300)

    def picture(self) -> npt.NDArray[np.uint8]:
        """The picture (h, w, 4), averaged over the finer pixels; uncovered ones are transparent."""
        cover = np.isfinite(self.depth).astype(float)
        shape = (self.height // FINER, FINER, self.width // FINER, FINER, 4)
        mixed = np.column_stack([self.colour * cover[:, None], cover]).reshape(shape).mean(axis=(1, 3))
        alpha = mixed[..., 3:]
        colour = mixed[..., :3] / np.maximum(alpha, 1e-9)
        seen = np.concatenate([np.where(alpha > 0.0, colour, 0.0), alpha], axis=2)
        return np.asarray(np.rint(255.0 * seen), np.uint8)
