"""The quadratic programme of the least mean square, solved as a least-distance problem.

In coordinates in which the mean square is a distance and the equations hold, the nearest point of a polyhedron is found
by non-negative least squares: finite, exact to rounding, with its multipliers (C. L. Lawson, R. J. Hanson, Solving
Least Squares Problems, SIAM 1995, ch. 23).
"""

from __future__ import annotations

import numpy as np

from camgeom.maths import Floats
from camgeom.motion.optimal.programme import Programme, Solved


def least_square(programme: Programme) -> Solved | None:
    """The shape of least root mean square under the rows of a programme; None where they leave none."""
    from scipy.linalg import null_space, solve_triangular
    from scipy.optimize import nnls

    levels = programme.levels
    low, high = programme.low[:levels], programme.high[:levels]
    unit, fixed = np.eye(levels), low == high
    equal = np.vstack([programme.equal[:, :levels], unit[fixed]])
    wanted = np.concatenate([programme.wanted, low[fixed]])
    limited = np.isfinite(high) & ~fixed
    rows = np.vstack([programme.matrix[:, :levels], unit[limited], -unit[limited]])
    sides = np.concatenate([programme.side, high[limited], -low[limited]])
    at = np.linalg.lstsq(equal, wanted, rcond=None)[0]
    free = null_space(equal)
    root = np.linalg.cholesky(_square(programme.shape.h)).T
    turned, triangle = np.linalg.qr(root @ free)
    start = turned.T @ (root @ at)
    # u = triangle q + start is the distance's own coordinate; rows a <= sides become c u >= d.
    into = solve_triangular(triangle, np.eye(len(triangle)))
    c = -(rows @ free) @ into
    d = rows @ at - sides + c @ start
    shadow = np.zeros(len(sides))
    u = np.zeros(len(start))
    if len(sides):
        size = np.maximum(np.linalg.norm(c, axis=1), 1e-300)
        system = np.vstack([(c / size[:, None]).T, d / size])
        target = np.zeros(len(system))
        target[-1] = 1.0
        found = nnls(system, target, maxiter=40 * len(sides))[0]
        rest = system @ found - target
        if np.linalg.norm(rest) <= 1e-9:
            return None
        u, shadow = -rest[:-1] / rest[-1], -found / rest[-1] / size
    a = at + free @ (into @ (u - start))
    value = float(np.sqrt(a @ _square(programme.shape.h) @ a))
    pull = _square(programme.shape.h) @ a + rows.T @ shadow
    moments = np.linalg.lstsq(equal.T, pull, rcond=None)[0][:2]
    count = len(programme.side)
    least = value if value > 0.0 else 1.0  # no limit is worth anything to an even motion
    return programme.solved(a, shadow[:count] / least, moments / least, value)


def _square(h: Floats) -> Floats:
    """The matrix (K + 1, K + 1) of the integral of the square of a row of straight pieces."""
    out = np.zeros((len(h) + 1, len(h) + 1))
    k = np.arange(len(h))
    out[k, k] += h / 3.0
    out[k + 1, k + 1] += h / 3.0
    out[k, k + 1] = out[k + 1, k] = h / 6.0
    return out
