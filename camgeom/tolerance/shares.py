"""Parts of the variance: how much of it each error alone explains, and what is left to errors that act together.

The first-order indices of Sobol (Math. Comput. Simul. 55, 2001, 271), S = Var E[Y | X] / Var Y, of the machines that
are drawn anyhow. E[Y | X] is the least-squares fit among functions of that error: straight ones, |x| of what acts both
ways alike (a line that tilts and touches at one end or the other), squares and x |x|; of an error with a direction the
same along directions all round. Y are both ends of where the follower may stand, in all dwells.

Arrays: s machines, o outcomes (two a place), k functions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import pi
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats

Singles = npt.NDArray[np.float32]
DIRECTIONS = np.exp(1j * pi / 8.0 * np.arange(8))
"""in which |x| of an error with a direction is taken"""
DEPENDENT = 1e-6
"""share of the largest eigenvalue below which functions are the same: of an error that is always at one end or other"""


def functions(x: Singles) -> Singles:
    """Functions (k, s) of an error of one holder, (parts, s), of the size of 1."""
    if len(x) == 1:
        (one,) = x
        return np.stack([one, np.abs(one), one * one, one * np.abs(one)])
    along = np.abs(np.outer(DIRECTIONS.real, x[0]) + np.outer(DIRECTIONS.imag, x[1]))
    return np.concatenate([x, x * x, (x[0] * x[1])[None], along]).astype(np.float32)


@final
@immutable
class Sums:
    """What a block of machines adds: products of centred functions and outcomes.

    gram  of each error's functions, (k, k); cross: with the outcomes, (k, o); square: of these, (o,)
    free  machines less the means taken off
    """

    gram: tuple[Floats, ...]
    cross: tuple[Singles, ...]
    square: Floats
    free: int


def sums_of(errors: Sequence[Singles], outcomes: Iterable[Singles]) -> Sums:
    """The sums of machines: errors (parts, s) each, outcomes (o, s) few at a time."""
    found = [functions(x) for x in errors]
    found = [f - f.mean(axis=1, keepdims=True) for f in found]
    every, crossed, squares = np.concatenate(found), list[Singles](), list[Floats]()
    for some in outcomes:
        off = some - some.mean(axis=1, keepdims=True)
        crossed.append(every @ off.T)
        squares.append(np.einsum("os,os->o", off, off, dtype=np.float64))
    cross = np.split(np.concatenate(crossed, axis=1), np.cumsum([len(f) for f in found])[:-1])
    wide = [f.astype(np.float64) for f in found]
    return Sums(tuple(f @ f.T for f in wide), tuple(cross), np.concatenate(squares), every.shape[1] - 1)


def first_order(blocks: Iterable[Sums], used: npt.NDArray[np.bool_]) -> Floats:
    """Share of the variance of all outcomes that each error explains alone, (errors,).

    used  which error has to do with an outcome, (errors, o): another correlates by chance alone, as each function does
    by 1 / (s - 1) on the average, which is taken off. 0 where nothing varies.
    """
    every = list(blocks)
    square, free = sum(one.square for one in every), sum(one.free for one in every)
    total = float(np.sum(square))
    shares = np.zeros(len(used))
    for i, mine in enumerate(used):
        if not total > 0.0 or not mine.any():
            continue
        gram = np.sum([one.gram[i] for one in every], axis=0)
        cross = np.asarray(np.sum([one.cross[i] for one in every], axis=0, dtype=np.float64))[:, mine]
        value, vector = np.linalg.eigh(gram)
        kept = value > DEPENDENT * value[-1]
        rank = int(kept.sum())
        if not value[-1] > 0.0 or free <= rank:
            continue
        part = ((vector[:, kept].T @ cross) ** 2 / value[kept, None]).sum(axis=0)
        part -= rank / (free - rank) * (np.asarray(square)[mine] - part)
        shares[i] = max(0.0, float(part.sum()) / total)
    return shares
