"""Contact of a body of finite length on a half-space: pressure of every cell, by conjugate gradients (no product code).

Boussinesq's deflection of a rectangle under constant pressure (Love 1929; Johnson, equation 3.25), summed by FFT on a
padded grid; the loaded cells and the approach by the constrained conjugate gradients of Polonsky and Keer
(doi 10.1016/S0043-1648(99)00113-1).
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


def love(x: Floats, y: Floats, a: float, b: float) -> Floats:
    """Integral of 1/r over the rectangle 2 a by 2 b about the origin, mm, seen from (x, y)."""
    total = np.zeros(np.broadcast(x, y).shape)
    for s in (1.0, -1.0):
        for t in (1.0, -1.0):
            u, v = x + s * a, y + t * b
            total += s * t * (u * np.arcsinh(v / np.abs(u)) + v * np.arcsinh(u / np.abs(v)))
    return total


def pressed(gap: Floats, dx: float, dy: float, compliance: float, load: float, tolerance: float = 1e-6) -> Floats:
    """Pressure (nx, ny), MPa, of cells dx by dy mm with this gap (mm) under a load, N; compliance 1/E*, 1/MPa.

    Nothing presses beyond the grid: a body that ends at its edge is sharp there.
    """
    nx, ny = gap.shape
    i = np.fft.fftfreq(2 * nx, 1.0 / (2 * nx))[:, None] * dx
    j = np.fft.fftfreq(2 * ny, 1.0 / (2 * ny))[None, :] * dy
    kernel = np.fft.rfft2(compliance / np.pi * love(i, j, 0.5 * dx, 0.5 * dy))

    def deflected(p: Floats) -> Floats:
        return np.fft.irfft2(kernel * np.fft.rfft2(p, (2 * nx, 2 * ny)), (2 * nx, 2 * ny))[:nx, :ny]

    cell = dx * dy
    p = np.full(gap.shape, load / gap.size / cell)
    way, old, fresh = np.zeros_like(p), 1.0, False
    for _ in range(5000):
        g = deflected(p) + gap
        on = p > 0.0
        g -= g[on].mean()
        new = (g[on] ** 2).sum()
        way = np.where(on, g + (new / old if fresh else 0.0) * way, 0.0)
        old = new
        r = deflected(way)
        r -= r[on].mean()
        step = (g[on] * way[on]).sum() / (r[on] * way[on]).sum()
        before = p
        p = np.maximum(p - step * way * on, 0.0)
        fresh = True
        late = (p == 0.0) & (g < 0.0)
        if late.any():
            p[late] -= step * g[late]
            fresh = False
        p *= load / (p.sum() * cell)
        if np.abs(p - before).sum() * cell < tolerance * load:
            return p
    raise RuntimeError("the contact did not converge")
