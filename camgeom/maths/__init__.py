"""Mathematics without cam words: screws, surfaces, meshes, extremes, sampling, curves, creases."""

from __future__ import annotations

from typing import TypeVar

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
"""An array of floats, of any shape."""
Number = TypeVar("Number", np.float64, np.int32, np.int64, np.intp)


def distinct(values: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """The different values (n,), rising: `numpy.unique` without the masked arrays that its first call imports."""
    ordered = np.sort(values, axis=None)
    return ordered[np.append(True, ordered[1:] != ordered[:-1])] if ordered.size else ordered
