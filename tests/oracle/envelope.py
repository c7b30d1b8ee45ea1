"""The oracle of the geometry: distance to the nearest position of the roller, with no envelope equation in it.

For a point X of a machined surface, the least signed distance from X to the roller body over the whole motion is zero;
anywhere else on the cam it is not negative. Only the positions a(phi) and directions u(phi) of the roller axis enter,
and those are written here again from the machine's description, not taken from the package.
"""

from __future__ import annotations

import numpy as np

GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def roller_distance(x, a, u, radius, tip, tip_high=False, shape=None):
    """Signed distance of points x to a roller; shape is (kind, slope or arc radius, centre of the meridian), or
    ("rounded", corner radius, None) of a cylinder whose end has a rounded edge.

    x, a, u broadcast to (..., 3); the roller is unbounded away from its tip.
    """
    d = x - a
    axial = np.einsum("...i,...i->...", d, u)
    if shape is not None and shape[0] in ("sphere", "crowned"):
        return _arc_distance(d, axial, radius, tip, tip_high, shape)
    if shape is not None and shape[0] == "rounded":
        across = np.sqrt(np.maximum(np.einsum("...i,...i->...", d, d) - axial**2, 0.0))
        side, under = across - radius + shape[1], ((axial - tip) if tip_high else (tip - axial)) + shape[1]
        outside = np.hypot(np.maximum(side, 0.0), np.maximum(under, 0.0))
        return outside + np.minimum(np.maximum(side, under), 0.0) - shape[1]
    slope, centre = (0.0, 0.0) if shape is None else (shape[1], shape[2])
    across = np.sqrt(np.maximum(np.einsum("...i,...i->...", d, d) - axial**2, 0.0))
    wall = (across - radius - slope * (axial - centre)) / np.sqrt(1.0 + slope * slope)
    end = (axial - tip) if tip_high else (tip - axial)
    if slope == 0.0:
        outside = np.hypot(np.maximum(wall, 0.0), np.maximum(end, 0.0))
        return np.where((wall > 0.0) | (end > 0.0), outside, np.maximum(wall, end))
    return _cone_distance(axial, across, wall, end, radius, slope, centre, tip)


def _cone_distance(axial, across, wall, end, radius, slope, centre, tip):
    """Half-infinite cone with a flat end, in the meridian half plane: nearest of side, end disc and rim."""
    rim = radius + slope * (tip - centre)
    inward = np.where(end == axial - tip, -1.0, 1.0)
    along = ((axial - tip) + slope * (across - rim)) * inward
    corner = np.hypot(axial - tip, across - rim)
    side = np.where(along >= 0.0, np.maximum(wall, 0.0), corner)
    disc = np.where(across <= rim, np.maximum(end, 0.0), corner)
    outside = np.minimum(np.where(wall > 0.0, side, corner), np.where(end > 0.0, disc, corner))
    return np.where((wall > 0.0) | (end > 0.0), outside, np.maximum(wall, end))


def _arc_distance(d, axial, radius, tip, tip_high, shape):
    kind, arc, centre = shape
    across = np.sqrt(np.maximum(np.einsum("...i,...i->...", d, d) - axial**2, 0.0))
    if kind == "sphere":
        return np.hypot(across, axial - centre) - radius
    body = np.hypot(across - (radius - arc), axial - centre) - arc
    end = (axial - tip) if tip_high else (tip - axial)
    rim = radius - arc + np.sqrt(arc**2 - (tip - centre) ** 2)
    corner = np.hypot(axial - tip, across - rim)
    return np.where(end > 0.0, np.where(across <= rim, end, corner), np.maximum(body, end))


def swept_distance(x, pose, distance, low, high, coarse=1440, keep=3, rounds=60):
    """Least roller distance of points x (n, 3) over low <= phi <= high, by dense sampling and golden section.

    pose(phi) -> a, u with shape phi.shape + (3,); distance(x, a, u) -> signed distance.
    The `keep` best coarse intervals of each point are all refined.
    """
    x = np.asarray(x, float)
    phi = np.linspace(low, high, coarse + 1)
    a, u = pose(phi)
    best = np.full(len(x), np.inf)
    for block in np.array_split(np.arange(len(x)), max(1, len(x) * coarse // 4_000_000 + 1)):
        if len(block) == 0:
            continue
        value = distance(x[block][:, None], a[None], u[None])
        left = np.concatenate([value[:, :1] + 1.0, value[:, :-1]], axis=1)
        right = np.concatenate([value[:, 1:], value[:, -1:] + 1.0], axis=1)
        minima = np.where((value <= left) & (value <= right), value, np.inf)
        order = np.argpartition(minima, keep, axis=1)[:, :keep]
        for k in range(keep):
            found = _golden(x[block], phi[order[:, k]], phi[1] - phi[0], pose, distance, low, high, rounds)
            best[block] = np.minimum(best[block], found)
    return best


def _golden(x, centre, half, pose, distance, low, high, rounds):
    lo, hi = np.maximum(centre - half, low), np.minimum(centre + half, high)

    def value(p):
        a, u = pose(p)
        return distance(x, a, u)

    p, q = hi - GOLDEN * (hi - lo), lo + GOLDEN * (hi - lo)
    fp, fq = value(p), value(q)
    for _ in range(rounds):
        smaller = fp < fq
        hi, lo = np.where(smaller, q, hi), np.where(smaller, lo, p)
        p_new = hi - GOLDEN * (hi - lo)
        q_new = lo + GOLDEN * (hi - lo)
        fp_new = np.where(smaller, value(p_new), fq)
        fq_new = np.where(smaller, fp, value(q_new))
        p, q, fp, fq = p_new, q_new, fp_new, fq_new
    return np.minimum(np.minimum(fp, fq), np.minimum(value(lo), value(hi)))


def triangle_points(vertices, faces, per_face=6, seed=0):
    """Vertices' triangles sampled at the centroid, edge middles and random interior points, (f * per_face, 3)."""
    rng = np.random.default_rng(seed)
    fixed = np.array([[1, 1, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]], float)
    fixed /= fixed.sum(axis=1, keepdims=True)
    extra = rng.dirichlet(np.ones(3), size=max(0, per_face - len(fixed)))
    weights = np.concatenate([fixed, extra])[:per_face]
    return np.einsum("wk,fkx->fwx", weights, vertices[faces]).reshape(-1, 3)
