"""Results on the profile of a planar cam that a face or an edge touches: what the 3D view and the stills colour."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh

if TYPE_CHECKING:
    from camgeom.model import Model

ACROSS = 2881
"""places round the profile that mesh vertices are looked up in"""
NEAR = 0.01
"""a vertex belongs to the profile within this share of the cam's size"""
STEEPEST = 1e4
"""1/mm; a sharper profile has a corner, not a curvature"""
FLAT = 1e-9
"""rad; a pressure angle this small is rounding"""


def profile_fields(model: Model, mesh: Mesh) -> dict[str, Floats]:
    """Results on the vertices (v,) of a cam body, NaN away from its profile; empty where nothing is known."""
    planar = model.planar
    if planar is None:
        return {}
    phi = np.linspace(0.0, 2.0 * np.pi, ACROSS)
    points, values = [], []
    for number, touch in enumerate(planar.touches):
        at = touch.at(phi)
        points.append(at.curve.points.T)
        values.append({"pressure_angle": np.degrees(np.abs(at.pressure_angle)), "curvature": at.relative})
        if (pressure := _pressure(model, number, phi)) is not None:
            values[-1]["pressure"] = pressure
    distance, nearest = _nearest(np.concatenate(points), mesh.vertices[:, :2])
    wall = np.zeros(len(mesh.vertices), dtype=bool)
    wall[mesh.faces[mesh.group_faces("flank")]] = True
    on = wall & (distance < NEAR * float(np.ptp(mesh.vertices[:, :2])))
    found: dict[str, Floats] = {}
    for name in ("pressure_angle", "curvature", "pressure"):
        if any(name not in one for one in values):
            continue
        field = np.concatenate([one[name] for one in values])
        known = np.isfinite(field) & (np.abs(field) < STEEPEST)
        if known.all() and not (name == "pressure_angle" and float(field.max()) < np.degrees(FLAT)):
            found[name] = np.where(on, field[nearest], np.nan)
    return {name: field for name, field in found.items() if np.any(np.isfinite(field))}


def _pressure(model: Model, number: int, phi: Floats) -> Floats | None:
    """Peak pressure of a touch at cam angles phi (n,), the largest along a roller; None where none is known."""
    touch = model.planar.touches[number] if model.planar is not None else None
    if touch is None or not model.driven or touch.name not in model.drive.contacts:
        return None
    contact = model.drive.contacts[touch.name]
    square = contact.behind
    if model.loaded:
        duty = model.duties[number if len(model.duties) > 1 else 0]
        if not bool(np.all(duty.slices.sound)):
            return None
        contact = duty.slices
        square = (contact.behind if touch.way > 0.0 else contact.ahead).max(axis=0)
    where = contact.panels
    inside = np.clip(phi, where.edges[0] + 1e-9, where.edges[-1] - 1e-9)
    return np.sqrt(np.maximum(np.asarray(where.at(square, inside)), 0.0))


def _nearest(points: Floats, places: Floats) -> tuple[Floats, np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """Distance (v,) of places (v, 2) from the nearest of the points (k, 2), and which that is."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(points).query(places)
    return np.asarray(distance, dtype=np.float64), np.asarray(nearest, dtype=np.intp)
