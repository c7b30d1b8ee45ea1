"""Mathematics without cam words: screws, surfaces, meshes, extremes, sampling, curves, creases.

Arithmetic that leaves the range of numbers is an answer that was not found, never a warning and never a NaN.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from math import pi
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged

TURN = 2.0 * pi
"""rad"""
Floats = npt.NDArray[np.float64]
"""An array of floats, of any shape."""
Number = TypeVar("Number", np.float64, np.int32, np.int64, np.intp)
DOMAIN = ("math domain error", "math range error")
"""what the functions of `math` say where they have no value"""


def distinct(values: npt.NDArray[Number]) -> npt.NDArray[Number]:
    """The different values (n,), rising: `numpy.unique` without the masked arrays that its first call imports."""
    # Numbers of edges and the like come in rising runs, which a merge takes in a fifth of the time.
    ordered = np.sort(values, axis=None, kind="stable" if values.dtype.kind in "iu" else None)
    return ordered[np.append(True, ordered[1:] != ordered[:-1])] if ordered.size else ordered


def among(known: Floats, asked: Floats) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.bool_]]:
    """Where each asked value (n,) stands in the known ones (k,), which rise, and whether it is one of them."""
    if not known.size:
        return np.zeros(asked.shape, dtype=np.intp), np.zeros(asked.shape, dtype=bool)
    index = np.minimum(np.searchsorted(known, asked), known.size - 1)
    return index, known[index] == asked


@cache
def gauss_rule(count: int) -> tuple[Floats, Floats]:
    """Nodes in [-1, 1], rising, and weights of the rule exact to degree 2 count - 1.

    Newton steps on the Legendre polynomial from nearly its roots (Abramowitz and Stegun 22.16.6 and 25.4.29); numpy's
    own rule comes with all its polynomials, whose import takes as long as the loads of a small cam.
    """
    nodes = np.cos(np.pi * (np.arange(count, 0, -1) - 0.25) / (count + 0.5))
    for _ in range(5):
        before, value = np.ones(count), nodes
        for k in range(2, count + 1):
            before, value = value, ((2 * k - 1) * nodes * value - (k - 1) * before) / k
        slope = count * (before - nodes * value) / (1.0 - nodes * nodes)
        nodes = nodes - value / slope
    nodes = 0.5 * (nodes - nodes[::-1])
    weights = 2.0 / ((1.0 - nodes * nodes) * slope * slope)
    nodes.setflags(write=False)
    weights.setflags(write=False)
    return nodes, weights


@contextmanager
def within_range(what: str) -> Iterator[None]:
    """Raise NotConverged where something computed inside overflows, has no real value, or a matrix has no inverse."""
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        raise _lost(what, error) from error
    except ValueError as error:
        if str(error) not in DOMAIN:
            raise
        raise _lost(what, error) from error


def _lost(what: str, error: Exception) -> NotConverged:
    reason = " ".join(str(error).split())
    return NotConverged(
        f"{what}: the numbers leave their range ({reason}): some keys of the profile are out of proportion to the "
        "others; look at the smallest and the largest of its lengths, masses, stiffnesses and speeds"
    )
