"""Points of scrambled Sobol sequences, any of them without those before it.

S. Joe, F. Y. Kuo, Constructing Sobol sequences with better two-dimensional projections, SIAM J. Sci. Comput. 30 (2008):
the first of their direction numbers. Scrambled as scipy does it (a lower triangular matrix of bits and a shift, by
J. Matousek, On the L2-discrepancy for anchored boxes, J. Complexity 14 (1998)): its very points. scipy's own stand in a
package that takes a second to import, in every process.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from camgeom.maths import Floats

BITS = 30
LOW = 12
"""bits of a point's number whose part is tabled"""
MOST = 1 << BITS
AXES = """
3:1 7:1,3 11:1,3,1 13:1,1,1 19:1,1,3,3 25:1,3,5,13 37:1,1,5,5,17 41:1,1,5,5,5 47:1,1,7,11,19 55:1,1,5,1,1
59:1,1,1,3,11 61:1,3,5,5,31 67:1,3,3,9,7,49 91:1,1,1,15,21,21 97:1,3,1,13,27,49 103:1,1,1,15,7,5 109:1,3,1,15,13,25
115:1,1,5,5,19,61 131:1,3,7,11,23,15,103 137:1,3,7,13,13,15,69 143:1,1,3,13,7,35,63 145:1,3,5,9,1,25,53
157:1,3,1,13,9,35,107 167:1,3,1,5,27,61,31 171:1,1,5,11,19,41,61 185:1,3,5,3,3,13,69 191:1,1,7,13,1,19,1
193:1,3,7,5,13,19,59 203:1,1,3,9,25,29,41 211:1,3,5,13,23,1,55 213:1,3,7,3,13,59,17 229:1,3,1,3,5,53,69
239:1,1,5,5,23,33,13 241:1,1,7,7,1,61,123 247:1,1,7,9,13,61,49 253:1,3,3,5,3,55,33 285:1,3,1,15,31,13,49,245
299:1,3,5,15,31,59,63,97 301:1,3,1,11,11,11,77,249 333:1,3,1,11,27,43,71,9 351:1,1,7,15,21,11,81,45
355:1,3,7,3,25,31,65,79 357:1,3,1,1,19,11,3,205 361:1,1,5,9,19,21,29,157 369:1,3,7,11,1,33,89,185
391:1,3,3,3,15,9,79,71 397:1,3,7,11,15,39,119,27 425:1,1,3,1,11,31,97,225 451:1,1,1,3,23,43,57,177
463:1,3,7,7,17,17,37,71 487:1,3,1,5,27,63,123,213 501:1,1,3,5,11,43,53,133 529:1,3,5,5,29,17,47,173,479
539:1,3,3,11,3,1,109,9,69 545:1,1,1,5,17,39,23,5,343 557:1,3,1,5,25,15,31,103,499 563:1,1,1,11,11,17,63,105,183
601:1,1,5,11,9,29,97,231,363 607:1,1,5,15,19,45,41,7,383 617:1,3,7,7,31,19,83,137,221 623:1,1,1,3,23,15,111,223,83
631:1,1,5,13,31,15,55,25,161 637:1,1,3,13,25,47,39,87,257
"""
"""Of every axis but the first: a primitive polynomial modulo 2, its coefficients as bits, and the first odd numbers."""

Bits = NDArray[np.int64]


def sobol(axes: int, seed: int, first: int, count: int) -> Floats:
    """Points first to first + count - 1, (count, axes), in 0..1, of at most 64 axes and numbers below MOST."""
    directions, shift = _scrambled(axes, seed)
    # A point is the sum of the directions that its number in Gray's code has, without carrying.
    table = np.zeros((1, axes), dtype=np.int64)
    for direction in directions[:LOW]:
        table = np.concatenate([table, table ^ direction])
    number = np.arange(first, first + count)
    gray = number ^ (number >> 1)
    found = table[gray & ((1 << LOW) - 1)] ^ shift
    for k in range(LOW, BITS):
        if (first + count) >> k:
            found ^= (gray[:, None] >> k & 1) * directions[k]
    return np.asarray(found * (1.0 / MOST))


@lru_cache(maxsize=4)
def _scrambled(axes: int, seed: int) -> tuple[Bits, Bits]:
    """Directions, (BITS, axes), and the shift, (axes,), of a scrambled sequence."""
    rng = np.random.default_rng(seed).spawn(1)[0]
    powers = 1 << np.arange(BITS)
    shift = rng.integers(2, size=(axes, BITS), dtype=np.uint32) @ powers
    lower = np.tril(rng.integers(2, size=(axes, BITS, BITS), dtype=np.uint32), -1) | np.eye(BITS, dtype=np.uint32)
    bits = _directions(axes)[:, :, None] >> np.arange(BITS)[::-1] & 1
    return np.einsum("api,aji->jap", lower, bits) % 2 @ powers[::-1], shift


def _directions(axes: int) -> Bits:
    """Directions, (axes, BITS)."""
    found = np.ones((axes, BITS), dtype=np.int64)
    for row, (polynomial, odd) in zip(found[1:], (word.split(":") for word in AXES.split())):
        numbers, bits = list(map(int, odd.split(","))), int(polynomial)
        degree = len(numbers)
        for _ in range(BITS - degree):
            new = numbers[-degree]
            for k in range(1, degree + 1):
                new ^= (bits >> (degree - k) & 1) * (numbers[-k] << k)
            numbers.append(new)
        row[:] = numbers
    return found << np.arange(BITS)[::-1]
