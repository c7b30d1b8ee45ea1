"""The stress field below a line contact, from which the share and the depth of its largest shear follow."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from camgeom.maths import Floats


def line_stress(x: ArrayLike, z: ArrayLike) -> tuple[Floats, Floats, Floats]:
    """Stresses sigma_x, sigma_z, tau_xz below a line contact, over peak pressure (1), tension positive.

    x across, z into the body, both over the half-width (McEwen; Johnson, equation 4.49). Far away they fall as 1/z.
    """
    across, down = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(z, dtype=np.float64))
    sum_ = 1.0 - across * across + down * down
    root = np.hypot(sum_, 2.0 * across * down)
    m2, n2 = 0.5 * (root + sum_), 0.5 * (root - sum_)
    # One of root ± sum_ cancels; their product is (x z)², which gives the lost one back.
    product = (across * down) ** 2
    m2 = np.where(sum_ >= 0.0, m2, np.divide(product, n2, out=np.zeros_like(root), where=n2 > 0.0))
    n2 = np.where(sum_ >= 0.0, np.divide(product, m2, out=np.zeros_like(root), where=m2 > 0.0), n2)
    m, n = np.sqrt(np.maximum(m2, 0.0)), np.sign(across) * np.sqrt(np.maximum(n2, 0.0))
    # m² - z² without cancellation, from m² - n² = 1 - x² + z² and m n = x z.
    rest = np.divide(m2, m2 + across * across, out=np.zeros_like(root), where=m2 > 0.0)
    bend = np.divide(rest, m2 + n2, out=np.zeros_like(root), where=m2 + n2 > 0.0)
    above = np.divide(rest, m + down, out=np.zeros_like(root), where=m + down > 0.0)
    return np.asarray(m * bend - 2.0 * above), np.asarray(-m * bend), np.asarray(-n * bend)
