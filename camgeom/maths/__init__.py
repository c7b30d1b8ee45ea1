"""Mathematics without cam words: screws, surfaces, meshes, extremes, sampling, curves, creases."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
"""An array of floats, of any shape."""
