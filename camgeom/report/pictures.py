"""The stills of a design: cam and follower, the section through the roller, the results on the flanks."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.colours import CARRIER, ROLLER
from camgeom.export import NamedMesh
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh
from camgeom.report.painter import render
from camgeom.report.sections.bodies import (
    cam_meshes,
    cam_poses,
    follower_bodies,
    placed,
)
from camgeom.report.sections.mechanism import INTO_RING, SHADES, fields
from camgeom.report.views import CuttingPlane, View

if TYPE_CHECKING:
    from camgeom.model import Model

_FLAT = 0.5
"""A cam lower than this share of its width is looked at from higher up."""
_ABOVE = 0.15
"""How much better the view from below must be."""
_LOW = 0.42
"""How high the eye stands over other cams, as a share of how far beside them."""
_RESULTS = ("pressure", "pressure_angle", "curvature")


def write_pictures(model: Model, folder: Path, stem: str, size: tuple[int, int] = (1600, 1200)) -> list[Path]:
    """Draw the stills of a model into `folder` as <stem>-<what>.png and give their paths; errors as of `stills`."""
    paths = []
    for what, draw in stills(model, size).items():
        paths.append(folder / f"{stem}-{what}.png")
        draw(paths[-1])
    return paths


def stills(model: Model, size: tuple[int, int] = (1600, 1200)) -> dict[str, Callable[[Path], int]]:
    """How every still of a model is drawn into a file, by what it shows.

    cam             the cam alone
    mechanism       cam and follower where the pressure angle is largest, in the machine frame
    section         the same, the cam cut through its axis and the follower's
    pressure, pressure-angle, curvature   on the flanks, seen from where they are largest (what the model has of them)

    Raises DesignError where the cam is undercut; drawing raises ExportError where no OpenGL library works here or a
    file cannot be written.
    """
    cams = cam_meshes(model)
    eye, inside = seen_from(cams, model.mechanism.inside, on_edge(model)), model.mechanism.inside
    scene = _mechanism(model, cams)
    names = tuple(name for name, _ in cams)
    plane = CuttingPlane((0.0, 0.0, 0.0), (0.0, -1.0, 0.0))
    views = [
        ("cam", [NamedMesh(name, mesh) for name, mesh in cams], View(camera=eye)),
        ("mechanism", scene, View(camera=eye)),
        ("section", scene, View(camera=seen_from(cams), section=plane, section_bodies=names)),
    ]
    coloured = [NamedMesh(name, replace(mesh, fields=fields(model, mesh))) for name, mesh in cams]
    for shade in SHADES:
        shown = [body for body in coloured if shade.key in body.mesh.fields]
        if shade.key in _RESULTS and shown:
            towards = _facing(shown, shade.key, _LOW if inside else eye[2], inside)
            look = View(shade.key, shade.groups, shade.label, shade.unit, camera=towards)
            if inside:
                # The half with the largest value, seen from where the other half was.
                half = CuttingPlane((0.0, 0.0, 0.0), (*towards[:2], 0.0))
                look = replace(look, section=half, section_bodies=names)
            views.append((shade.key.replace("_", "-"), coloured, look))
    return {what: partial(_draw, bodies, replace(view, size=size)) for what, bodies, view in views}


def _draw(bodies: list[NamedMesh], view: View, path: Path) -> int:
    return render(bodies, path, view)


def on_edge(model: Model) -> bool:
    """Whether the roller runs on the edge of a plate, which looks to +Y."""
    return model.mechanism.box is not None and len(model.tracks[0].sides) == 1


def seen_from(
    cams: tuple[tuple[str, Mesh], ...], inside: bool = False, edge: bool = False
) -> tuple[float, float, float]:
    """Direction to the eye: beside the follower, which stands at +X, and higher over a flat cam; of a follower inside a
    ring from over the far side of it, of one on the edge of a plate from that edge."""
    if inside:
        return INTO_RING
    if edge:
        return (0.58, 0.72, 0.85)
    size = np.ptp(np.concatenate([mesh.vertices for _, mesh in cams]), axis=0)
    return (0.72, -0.58, 0.85 if size[2] < _FLAT * size[:2].max() else _LOW)


def _mechanism(model: Model, cams: tuple[tuple[str, Mesh], ...]) -> list[NamedMesh]:
    """All bodies in the machine frame at the cam angle of the largest pressure angle."""
    steepest = model.pressure_angle.cam_angle if model.pressure_angle is not None else 0.0
    moving = moving_bodies(model, cams, np.array([steepest]))
    return [replace(body, mesh=placed(body.mesh, motion[0])) for body, motion in moving]


def moving_bodies(model: Model, cams: tuple[tuple[str, Mesh], ...], phi: Floats) -> list[tuple[NamedMesh, Floats]]:
    """Cam and follower with their poses (n, 3, 4) in the machine frame at cam angles phi (n,), rad."""
    turned = cam_poses(model.mechanism, phi)
    found = [(NamedMesh(name, mesh), turned) for name, mesh in cams]
    for number, (kind, name, mesh, moved) in enumerate(follower_bodies(model, phi)):
        found.append((NamedMesh(f"{name} {number}", mesh, ROLLER if kind == "roller" else CARRIER), moved))
    return found


def _facing(bodies: list[NamedMesh], key: str, height: float, inside: bool) -> tuple[float, float, float]:
    """Direction from which the face with the largest value is seen best, of the inside of a ring from across the axis;
    from below only where that is much better."""
    best = max(bodies, key=lambda body: float(np.nanmax(body.mesh.fields[key]))).mesh
    place = int(np.nanargmax(best.fields[key]))
    corners = best.vertices[best.faces[best.group_faces("flank") & np.any(best.faces == place, axis=1)]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]).sum(axis=0)
    normal = normal / (float(np.linalg.norm(normal)) or 1.0)
    azimuth = float(np.arctan2(best.vertices[place, 1], best.vertices[place, 0])) + (np.pi if inside else 0.0)
    eyes = [
        np.array([np.cos(azimuth + aside), np.sin(azimuth + aside), up])
        for aside in (-0.6, -0.35, 0.35, 0.6)
        for up in (height, -height)
    ]
    x, y, z = max(eyes, key=lambda eye: float(eye @ normal) + (_ABOVE if eye[2] > 0.0 else 0.0))
    return (float(x), float(y), float(z))
