"""One-step maps of the Newmark family: Wilson-theta, Newmark, generalized-alpha as one formula.

With the stretched step H = theta h and a~ = a0 + theta (a1 - a0):

    q~ = q0 + H v0 + H^2 ((1/2 - beta) a0 + beta a~),   v~ = v0 + H ((1 - gamma) a0 + gamma a~)
    (1 - am) a~ + am a0 + (1 - af)(D~ v~ + S~ q~ - F~) + af (D0 v0 + S0 q0 - F0) = 0

then q1, v1 follow from a1 by the same formulas with H = h. D~, S~, F~ are carried on linearly from the two ends of the
step, so that a step never looks past a knot of the motion, where the acceleration may jump.
"""

from __future__ import annotations

import numpy as np

from camgeom.dynamics.linear.method import Coefficients, Collocated, System
from camgeom.maths import Floats


def maps(method: Collocated, system: System, start: Floats, step: Floats) -> Floats:
    """Affine maps (b, n, 3m, 3m + 1) of the state (q, q', q'') for steps (1 or b, n) from cam angles start, rad."""
    m = system.size
    near = system.coefficients(start, "right")
    far = system.coefficients(start + step, "left")
    ahead = _blend(near, far, method.theta)
    h = step[:, :, None, None]
    out = np.zeros((system.batch, start.shape[1], 3 * m, 3 * m + 1))
    a1 = _new_acceleration(method, near, ahead, h, m)
    out[:, :, 2 * m :, :] = a1
    start_rows = np.broadcast_to(np.eye(3 * m, 3 * m + 1), out.shape)
    q0, v0, a0 = start_rows[:, :, :m], start_rows[:, :, m : 2 * m], start_rows[:, :, 2 * m :]
    out[:, :, m : 2 * m, :] = v0 + h * ((1.0 - method.gamma) * a0 + method.gamma * a1)
    out[:, :, :m, :] = q0 + h * v0 + h * h * ((0.5 - method.beta) * a0 + method.beta * a1)
    return out


def _new_acceleration(method: Collocated, near: Coefficients, ahead: Coefficients, h: Floats, m: int) -> Floats:
    """q'' at the end of the step as rows over (q0, v0, a0, 1), shape (b, n, m, 3m + 1)."""
    hh = method.theta * h
    eye = np.eye(m)
    am, af = method.alpha_m, method.alpha_f
    left = (1.0 - am) * eye + (1.0 - af) * (hh * method.gamma * ahead.damping + hh * hh * method.beta * ahead.stiffness)
    damping, stiffness = np.broadcast_arrays(ahead.damping, ahead.stiffness)
    on_q = -(1.0 - af) * stiffness - af * near.stiffness
    on_v = -(1.0 - af) * (damping + hh * stiffness) - af * near.damping
    on_a = -am * eye - (1.0 - af) * (hh * (1.0 - method.gamma) * damping + hh * hh * (0.5 - method.beta) * stiffness)
    constant = ((1.0 - af) * ahead.force + af * near.force)[..., None]
    shape = np.broadcast_shapes(on_q.shape[:2], on_a.shape[:2], constant.shape[:2])
    right = np.concatenate([np.broadcast_to(part, shape + part.shape[2:]) for part in (on_q, on_v, on_a, constant)], -1)
    stretched = np.linalg.solve(np.broadcast_to(left, shape + left.shape[2:]), right)
    # a1 = a0 + (a~ - a0)/theta
    stretched /= method.theta
    stretched[..., 2 * m : 3 * m] += (1.0 - 1.0 / method.theta) * eye
    return np.asarray(stretched)


def _blend(near: Coefficients, far: Coefficients, theta: float) -> Coefficients:
    """Coefficients carried on linearly from the ends of the step to theta steps."""
    return Coefficients(
        near.damping + theta * (far.damping - near.damping),
        near.stiffness + theta * (far.stiffness - near.stiffness),
        near.force + theta * (far.force - near.force),
    )


def restart(system: System, theta: Floats) -> Floats:
    """Affine maps (b, n, 3m, 3m + 1) that renew the acceleration across knots at theta (1, n), where the forces may
    jump.

    The carried q'' keeps its method-specific value and receives only the jump of F - D q' - S q.
    """
    m = system.size
    left, right = system.coefficients(theta, "left"), system.coefficients(theta, "right")
    out = np.zeros((system.batch, theta.shape[1], 3 * m, 3 * m + 1))
    out[..., : 3 * m] = np.eye(3 * m)
    out[:, :, 2 * m :, :m] = left.stiffness - right.stiffness
    out[:, :, 2 * m :, m : 2 * m] = left.damping - right.damping
    out[:, :, 2 * m :, 3 * m] = right.force - left.force
    return out
