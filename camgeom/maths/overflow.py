"""Arithmetic that leaves the range of numbers is an answer that was not found, never a warning and never a NaN."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from camgeom.errors import NotConverged

DOMAIN = ("math domain error", "math range error")
"""what the functions of `math` say where they have no value"""


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
