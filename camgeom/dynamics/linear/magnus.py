"""One-step maps by the matrix exponential: Magnus series of order 2 and 4, and the batched exponential itself.

The affine system y' = A y + g is the linear system [y; 1]' = [[A, g], [0, 0]] [y; 1]. Order 2 takes it at the middle
of the step; order 4 takes two Gauss points, Omega = h (A1 + A2)/2 - sqrt(3)/12 h^2 [A1, A2] (Iserles and Norsett
1999). Positions are scaled by the system's own rate so that both halves of the state are of one size: unscaled, the
exponential loses the digits of the ratio of its largest entries.
"""

from __future__ import annotations

from math import sqrt

import numpy as np

from camgeom.dynamics.linear.method import Magnus, StepTooLong, System
from camgeom.maths import Floats

PADE = (
    *(64764752532480000.0, 32382376266240000.0, 7771770303897600.0, 1187353796428800.0, 129060195264000.0),
    *(10559470521600.0, 670442572800.0, 33522128640.0, 1323241920.0, 40840800.0, 960960.0, 16380.0, 182.0, 1.0),
)
"""Numerator of the (13, 13) Pade approximation of exp (Higham 2005)."""
REACH = 5.371920351148152
"""largest 1-norm for which PADE is exact to double precision (Higham 2005)"""
MAX_SQUARINGS = 40


def exponential(matrices: Floats) -> Floats:
    """Matrix exponential (no unit) of (..., k, k), by scaling and squaring with the (13, 13) Pade approximation."""
    norm = float(np.abs(matrices).sum(-2).max(initial=0.0))
    squarings = 0 if norm <= REACH else min(MAX_SQUARINGS, int(np.ceil(np.log2(norm / REACH))))
    a = matrices / 2.0**squarings
    eye = np.eye(a.shape[-1])
    a2 = a @ a
    a4 = a2 @ a2
    a6 = a4 @ a2
    c = PADE
    odd = a6 @ (c[13] * a6 + c[11] * a4 + c[9] * a2) + c[7] * a6 + c[5] * a4 + c[3] * a2 + c[1] * eye
    even = a6 @ (c[12] * a6 + c[10] * a4 + c[8] * a2) + c[6] * a6 + c[4] * a4 + c[2] * a2 + c[0] * eye
    odd = a @ odd
    out = np.linalg.solve(even - odd, even + odd)
    # checked by the caller: squaring overflows where the true exponential does
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(squarings):
            out = out @ out
    return np.asarray(out)


def maps(method: Magnus, system: System, start: Floats, step: Floats) -> Floats:
    """Affine maps (b, n, 2m, 2m + 1) of the state (q, q') for steps (1 or b, n) from cam angles start, rad."""
    m = system.size
    h = step[:, :, None, None]
    if method.order == 2:
        omega, rate = _generator(system, start + step / 2.0, None)
        omega = omega * h
    else:
        reach = sqrt(3.0) / 6.0
        first, rate = _generator(system, start + (0.5 - reach) * step, None)
        second, _ = _generator(system, start + (0.5 + reach) * step, rate)
        omega = h * (first + second) / 2.0 - (sqrt(3.0) / 12.0) * h * h * (first @ second - second @ first)
    full = exponential(omega)[..., : 2 * m, :]
    if not np.isfinite(full).all():
        raise StepTooLong(
            f"{method.name}: the step is beyond the radius of convergence of the series; take shorter ones"
        )
    full[..., :m, :] /= rate
    full[..., :m] *= rate
    return full


def _generator(system: System, theta: Floats, rate: Floats | None) -> tuple[Floats, Floats]:
    """[[A, g], [0, 0]] (b, n, 2m + 1, 2m + 1) for the state (rate q, q'), and the rate (b, 1, 1, 1) in rad per rad."""
    m = system.size
    here = system.coefficients(theta)
    if rate is None:
        size = np.abs(here.stiffness).sum(-1).max(axis=(-1, -2))
        rate = np.sqrt(np.maximum(size, 1.0))[:, None, None, None]
    out = np.zeros((system.batch, theta.shape[1], 2 * m + 1, 2 * m + 1))
    index = np.arange(m)
    out[:, :, index, m + index] = rate[:, :, 0]
    out[:, :, m : 2 * m, :m] = -here.stiffness / rate
    out[:, :, m : 2 * m, m : 2 * m] = -here.damping
    out[:, :, m : 2 * m, 2 * m] = here.force
    return out, np.asarray(rate)
