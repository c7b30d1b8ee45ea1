"""One-step maps of Runge-Kutta methods, reduced to the accelerations of the stages.

For q'' = F - D q' - S q the stage velocities are V_i = v + h sum a_ij A_j and the stage positions
Q_i = q + c_i h v + h^2 sum (a a)_ij A_j, so the only unknowns are the s m accelerations A:

    A_i + sum_j (h a_ij D_i + h^2 (a a)_ij S_i) A_j = F_i - D_i v - S_i (q + c_i h v)

a third of the work of the first-order form. The same formula serves explicit and implicit tableaus.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camgeom.dynamics.linear.method import Coefficients, RungeKutta, Side, System
from camgeom.maths import Floats


@dataclass(frozen=True, eq=False)
class Stages:
    """The stages of many steps: accelerations as rows over (q, q', 1), shape (b, n, s m, 2m + 1), and how forces
    enter them.

    theta (1 or b, n, s) rad; inverse (b, n, s m, s m) takes stage forces to stage accelerations (only when asked for).
    """

    method: RungeKutta
    theta: Floats
    step: Floats
    rows: Floats
    inverse: Floats | None

    def maps(self) -> Floats:
        """Affine maps (b, n, 2m, 2m + 1) of the state (q, q')."""
        b, n, sm, width = self.rows.shape
        m = (width - 1) // 2
        position, speed = self.weights()
        stages = self.rows.reshape(b, n, sm // m, m * width)
        out = np.zeros((b, n, 2 * m, width))
        out[:, :, m:] = (speed @ stages).reshape(b, n, m, width)
        out[:, :, :m] = (position @ stages).reshape(b, n, m, width)
        index = np.arange(m)
        out[:, :, index, index] += 1.0
        out[:, :, m + index, m + index] += 1.0
        out[:, :, index, m + index] += self.step[:, :, None]
        return out

    def weights(self) -> tuple[Floats, Floats]:
        """Weights (1 or b, n, 1, s) of the stage accelerations in the step of q and of q'."""
        a, b = np.array(self.method.a), np.array(self.method.b)
        h = self.step[:, :, None]
        # (., n, 1, s) keeps the product with (b, n, s, .) a plain matrix product
        return (h * h * (b @ a))[:, :, None, :], (h * b)[:, :, None, :]


def stages(method: RungeKutta, system: System, start: Floats, step: Floats, keep_inverse: bool = False) -> Stages:
    """Stage accelerations of steps (1 or b, n) from cam angles start, rad."""
    m, s = system.size, len(method.b)
    a, c = np.array(method.a), np.array(method.c)
    theta = start[:, :, None] + step[:, :, None] * c
    here = _at(system, theta, c)
    h = step[:, :, None, None, None]
    damping, stiffness = here.damping, here.stiffness
    right = _right_hand_side(here, step, c, system.batch)
    if method.explicit:
        return Stages(method, theta, step, _sweep(method, damping, stiffness, right, h), None)
    n = right.shape[1]
    matrix = _stage_matrix(a, h * damping, h * h * stiffness, (system.batch, n, s, m, m))
    right = right.reshape(system.batch, n, s * m, 2 * m + 1)
    if keep_inverse:
        inverse: Floats = np.asarray(np.linalg.inv(matrix))
        return Stages(method, theta, step, inverse @ right, inverse)
    return Stages(method, theta, step, np.asarray(np.linalg.solve(matrix, right)), None)


def maps(method: RungeKutta, system: System, start: Floats, step: Floats) -> Floats:
    """Affine maps (b, n, 2m, 2m + 1) of the state (q, q') for steps (1 or b, n) from cam angles start, rad."""
    return stages(method, system, start, step).maps()


def _stage_matrix(a: Floats, damping: Floats, stiffness: Floats, shape: tuple[int, int, int, int, int]) -> Floats:
    """1 + the blocks (i, j): h a_ij D_i + h^2 (a a)_ij S_i, (b, n, s m, s m), from h D and h^2 S broadcast to shape.

    Formed with the steps on the last axis and turned round once: the small matrices would make loops of length m.
    """
    b, n, s, m, _ = shape
    first, second = (
        np.ascontiguousarray(np.broadcast_to(part, shape).transpose(2, 3, 4, 0, 1)) for part in (damping, stiffness)
    )
    left = np.empty((s, m, s, m, b, n))
    np.multiply(first[:, :, None], a[:, None, :, None, None, None], out=left)
    left += second[:, :, None] * (a @ a)[:, None, :, None, None, None]
    matrix: Floats = np.ascontiguousarray(left.transpose(4, 5, 0, 1, 2, 3)).reshape(b, n, s * m, s * m)
    index = np.arange(s * m)
    matrix[:, :, index, index] += 1.0
    return matrix


def _at(system: System, theta: Floats, c: Floats) -> Coefficients:
    """Coefficients at the stages (1 or b, n, s): damping and stiffness (., n, s, m, m), force (., n, s, m).

    A stage on the end of its step (explicit methods) takes the limit from inside the step.
    """
    inside = (c > 0.0) & (c < 1.0)
    flat = theta[:, :, inside]
    main = _unfold(system.coefficients(flat.reshape(flat.shape[0], -1)), flat.shape[1:])
    if inside.all():
        return main
    first = [_single(system, theta[:, :, 0], "right")] if c[0] == 0.0 else []
    last = [_single(system, theta[:, :, -1], "left")] if c[-1] == 1.0 else []
    parts = [*first, main, *last]
    return Coefficients(
        _joined([part.damping for part in parts]),
        _joined([part.stiffness for part in parts]),
        _joined([part.force for part in parts]),
    )


def _single(system: System, theta: Floats, side: Side) -> Coefficients:
    """Coefficients at one stage, with an axis for it."""
    here = system.coefficients(theta, side)
    return Coefficients(here.damping[:, :, None], here.stiffness[:, :, None], here.force[:, :, None])


def _joined(parts: list[Floats]) -> Floats:
    """Stages side by side; constant ones are not repeated."""
    if all(part.shape[1:3] == (1, 1) for part in parts):
        return parts[0]
    b, n = (max(part.shape[k] for part in parts) for k in (0, 1))
    whole = [np.broadcast_to(part, (b, n, *part.shape[2:])) for part in parts]
    return np.concatenate(whole, 2)


def _unfold(flat: Coefficients, shape: tuple[int, ...]) -> Coefficients:
    """Split the axis of n s stage angles into (n, s); an axis of length 1 stays."""

    def split(values: Floats) -> Floats:
        counts = shape if values.shape[1] != 1 or shape == (1, 1) else (1, 1)
        return values.reshape(values.shape[0], *counts, *values.shape[2:])

    return Coefficients(split(flat.damping), split(flat.stiffness), split(flat.force))


def _right_hand_side(here: Coefficients, step: Floats, c: Floats, batch: int) -> Floats:
    """F_i - D_i v - S_i (q + c_i h v) as rows over (q, v, 1): (b, n, s, m, 2m + 1)."""
    m = here.force.shape[-1]
    n = np.broadcast_shapes(here.force.shape[1:2], step.shape[1:2])[0]
    out = np.empty((batch, n, len(c), m, 2 * m + 1))
    out[..., :m] = -here.stiffness
    reach = (step[:, :, None] * c)[..., None, None]
    out[..., m : 2 * m] = -here.damping - reach * here.stiffness
    out[..., 2 * m] = here.force
    return out


def _sweep(method: RungeKutta, damping: Floats, stiffness: Floats, right: Floats, h: Floats) -> Floats:
    """Stage accelerations of an explicit tableau, one stage after the other: (b, n, s m, 2m + 1)."""
    a = np.array(method.a)
    aa = a @ a
    step = h[:, :, 0]
    found = np.zeros_like(right)
    for i in range(a.shape[0]):
        d = np.broadcast_to(damping, right.shape[:-1] + damping.shape[-1:])[:, :, i]
        k = np.broadcast_to(stiffness, right.shape[:-1] + stiffness.shape[-1:])[:, :, i]
        speed = np.einsum("j,bnjxy->bnxy", a[i], found) * step
        place = np.einsum("j,bnjxy->bnxy", aa[i], found) * step * step
        found[:, :, i] = right[:, :, i] - d @ speed - k @ place
    b, n, s, m, width = right.shape
    return found.reshape(b, n, s * m, width)
