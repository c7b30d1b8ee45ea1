"""Volume, centroid and inertia of a closed mesh by the divergence theorem (exact for the polyhedron)."""

from __future__ import annotations

import numpy as np

from camgeom.maths.mesh import Mesh

Vector = tuple[float, float, float]


def mass_properties(mesh: Mesh, density: float) -> tuple[float, float, Vector, tuple[Vector, ...]]:
    """Volume mm³, mass kg, centroid mm, inertia tensor about the centroid kg m²; density kg/m³.

    Signed tetrahedra from the vertex mean (to keep digits); the second moments of a tetrahedron with one corner at the
    origin are V/20 (sum_i p_i p_i^T + (sum p)(sum p)^T) over its three other corners.
    """
    origin = mesh.vertices.mean(axis=0)
    p = mesh.vertices[mesh.faces] - origin
    volume = np.einsum("fi,fi->f", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6.0
    total = float(volume.sum())
    together = p.sum(axis=1)
    first = (volume[:, None] * together).sum(axis=0) / 4.0
    centre = first / total
    second = (np.einsum("f,fki,fkj->ij", volume, p, p) + np.einsum("f,fi,fj->ij", volume, together, together)) / 20.0
    about = second - total * np.outer(centre, centre)
    inertia = (np.trace(about) * np.eye(3) - about) * density * 1e-15
    where = origin + centre
    rows = tuple((float(r[0]), float(r[1]), float(r[2])) for r in inertia)
    return total, total * density * 1e-9, (float(where[0]), float(where[1]), float(where[2])), rows
