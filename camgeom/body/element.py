"""The quadratic hexahedron of 20 nodes (serendipity), fully integrated: 3 x 3 x 3 Gauss points, as CalculiX' C3D20.

Nodes in the order of Abaqus and VTK: corners of the lower face and of the upper one, middles of the lower face's edges
and of the upper one's, middles of the upright edges. Units mm, N, MPa.
"""

from __future__ import annotations

import numpy as np

from camgeom.errors import DesignError
from camgeom.maths import Floats

CORNERS = ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))
EDGES = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
NATURAL: Floats = np.array(
    [*CORNERS, *(tuple((a + b) / 2 for a, b in zip(CORNERS[i], CORNERS[j])) for i, j in EDGES)], dtype=float
)
"""Natural coordinates (20, 3) of the nodes."""
FOLDED = "an element of the body's mesh is folded: the groove is too steep, or a root or wall too thin, for it"
CHUNK = 256
"""elements whose stiffness is made together"""


def shapes(at: Floats) -> tuple[Floats, Floats]:
    """Shape functions (p, 20) and their derivatives (p, 20, 3) at natural coordinates (p, 3)."""
    on = NATURAL == 0.0
    one = np.where(on, 1.0 - at[:, None] ** 2, 1.0 + at[:, None] * NATURAL)
    slope = np.where(on, -2.0 * at[:, None], NATURAL)
    value, change = one.prod(axis=2), np.stack(
        [slope[..., k] * one[..., (k + 1) % 3] * one[..., (k + 2) % 3] for k in range(3)], axis=2
    )
    found, rate = 0.25 * value, 0.25 * change
    rest = (at[:, None] * NATURAL[:8]).sum(axis=2) - 2.0
    found[:, :8] = 0.125 * value[:, :8] * rest
    rate[:, :8] = 0.125 * (change[:, :8] * rest[..., None] + value[:, :8, None] * NATURAL[:8])
    return found, rate


def gauss() -> tuple[Floats, Floats]:
    """Natural coordinates (27, 3) and weights (27,) of the integration points."""
    x, w = np.polynomial.legendre.leggauss(3)
    grid = np.stack(np.meshgrid(x, x, x, indexing="ij"), axis=-1).reshape(-1, 3)
    return grid, np.prod(np.stack(np.meshgrid(w, w, w, indexing="ij"), axis=-1), axis=-1).ravel()


def elasticity(modulus: float, poisson: float) -> Floats:
    """Stiffness (6, 6) of an isotropic solid, MPa, for strains (xx, yy, zz, xy, yz, zx), shear as angles."""
    if poisson >= 0.4999:
        raise DesignError("a body of poisson 0.5 keeps its volume, which these elements cannot: give a lower one")
    lame = modulus * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    shear = modulus / (2.0 * (1.0 + poisson))
    found = np.diag([2.0 * shear] * 3 + [shear] * 3)
    found[:3, :3] += lame
    return found


def gradients(x: Floats, rate: Floats) -> tuple[Floats, Floats]:
    """Derivatives (e, p, k, 3) by place of the shape functions, and det J (e, p), of elements x (e, k, 3).

    Raises DesignError where an element is folded.
    """
    jacobian = np.einsum("pna,enk->epak", rate, x, optimize=True)
    volume = np.linalg.det(jacobian)
    if float(volume.min()) <= 0.0:
        raise DesignError(FOLDED)
    return np.swapaxes(np.linalg.solve(jacobian, np.swapaxes(rate, 1, 2)[None]), 2, 3), volume


def least_volume(x: Floats) -> float:
    """Least det J, mm³, over the integration points of elements (e, 20, 3): not positive where one is folded."""
    return float(np.linalg.det(np.einsum("pna,enk->epak", shapes(gauss()[0])[1], x, optimize=True)).min())


def strain_matrix(gradient: Floats) -> Floats:
    """Strains (..., 6, 3 k) of unit displacements of the nodes, from derivatives (..., k, 3) of shape functions."""
    count = gradient.shape[-2]
    found = np.zeros((*gradient.shape[:-2], 6, count, 3))
    for k in range(3):
        found[..., k, :, k] = gradient[..., k]
        other = (k + 1) % 3
        found[..., 3 + k, :, k] = gradient[..., other]
        found[..., 3 + k, :, other] = gradient[..., k]
    return found.reshape(*gradient.shape[:-2], 6, 3 * count)


def stiffness(x: Floats, material: Floats) -> Floats:
    """Stiffness (e, 60, 60), N/mm, of elements with nodes (e, 20, 3). Raises DesignError where one is folded."""
    at, weight = gauss()
    rate = shapes(at)[1]
    found = np.empty((len(x), 60, 60))
    for start in range(0, len(x), CHUNK):
        part = slice(start, start + CHUNK)
        gradient, volume = gradients(x[part], rate)
        b = strain_matrix(gradient)
        db = (volume * weight)[:, :, None, None] * (material @ b)
        found[part] = np.swapaxes(b.reshape(len(b), -1, 60), 1, 2) @ db.reshape(len(b), -1, 60)
    return found


def stresses(x: Floats, moved: Floats, at: Floats, material: Floats) -> Floats:
    """Stresses (e, p, 6), MPa, of elements (e, 20, 3) whose nodes moved (e, 20, 3), at natural coordinates (p, 3)."""
    gradient, _ = gradients(x, shapes(at)[1])
    strain = strain_matrix(gradient) @ moved.reshape(len(x), 1, 60, 1)
    return np.asarray((material @ strain)[..., 0])


def tensors(stress: Floats) -> Floats:
    """Symmetric tensors (..., 3, 3) of stresses (..., 6)."""
    xx, yy, zz, xy, yz, zx = np.moveaxis(stress, -1, 0)
    return np.stack([np.stack([xx, xy, zx], -1), np.stack([xy, yy, yz], -1), np.stack([zx, yz, zz], -1)], -2)


def largest_principal(stress: Floats) -> Floats:
    """Largest principal stress (...) of stresses (..., 6), MPa."""
    return np.asarray(np.linalg.eigvalsh(tensors(stress))[..., -1])
