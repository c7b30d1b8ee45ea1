"""Matrices assembled from energies, their exact decoupling into blocks, and the definiteness of every block.

A quadratic energy is a sum of terms c/2 (g . x)^2 (a spring, an inertia, a damper along one direction g) or c (g .
x)(h . x) (a mixed term). The matrices are sums of dyads, so they are symmetric by construction and a coupling that no
energy names is exactly zero: the blocks found from that pattern are independent to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

import numpy as np

from camgeom.maths import Floats

DEFINITE = 1e-12
"""smallest eigenvalue of a block scaled to a unit diagonal that counts as positive"""


@dataclass(frozen=True)
class Term:
    """One quadratic energy c/2 (g . x)^2, or c (g . x)(h . x) when h is given; names of coordinates to weights."""

    coefficient: float
    g: tuple[tuple[str, float], ...]
    h: tuple[tuple[str, float], ...] = ()

    def matrix(self, names: Sequence[str]) -> Floats:
        """Second derivative (m, m) of the energy."""
        g = _vector(self.g, names)
        if not self.h:
            return self.coefficient * np.outer(g, g)
        h = _vector(self.h, names)
        return self.coefficient * (np.outer(g, h) + np.outer(h, g))


def _vector(weights: tuple[tuple[str, float], ...], names: Sequence[str]) -> Floats:
    out = np.zeros(len(names))
    for name, weight in weights:
        out[list(names).index(name)] = weight
    return out


def along(name: str, weight: float = 1.0) -> tuple[tuple[str, float], ...]:
    """The direction of one coordinate."""
    return ((name, weight),)


def between(first: str, second: str) -> tuple[tuple[str, float], ...]:
    """The difference first - second of two coordinates."""
    return ((first, 1.0), (second, -1.0))


def assemble(terms: Sequence[Term], names: Sequence[str]) -> Floats:
    """Matrix (m, m) of a sum of energies."""
    total = np.zeros((len(names), len(names)))
    for term in terms:
        total += term.matrix(names)
    return total


def decoupled(names: Sequence[str], *matrices: Floats) -> tuple[tuple[str, ...], ...]:
    """Blocks of coordinates that no matrix (m, m) couples, in the order of their first coordinate."""
    coupled = np.zeros((len(names), len(names)), dtype=bool)
    for matrix in matrices:
        coupled |= (matrix != 0.0) | (matrix.T != 0.0)
    left = list(range(len(names)))
    blocks = []
    while left:
        block, reach = set(), {left[0]}
        while reach:
            block |= reach
            reach = {int(j) for i in reach for j in np.flatnonzero(coupled[i])} - block
        blocks.append(tuple(names[i] for i in sorted(block)))
        left = [i for i in left if i not in block]
    return tuple(blocks)


@dataclass(frozen=True)
class Indefinite:
    """A stiffness block that is no stiffness: some displacement lowers its energy, so a disturbance grows without
    bound.

    scaled_eigenvalue has no unit (unit diagonal), eigenvalue N/m or N m/rad, growth_rate 1/s, frequencies_squared
    (rad/s)^2 with their sign (a negative one is the divergence, never the root of its magnitude), admissible says
    which data would do.
    """

    block: tuple[str, ...]
    scaled_eigenvalue: float
    eigenvalue: float
    growth_rate: float
    frequencies_squared: tuple[float, ...]
    admissible: str

    def __str__(self) -> str:
        return (
            f"stiffness of {', '.join(self.block)} is indefinite: eigenvalue {self.eigenvalue:.6e}, scaled "
            f"{self.scaled_eigenvalue:.6f}, a disturbance grows with {self.growth_rate:.6f} 1/s; "
            f"needs {self.admissible}"
        )


def definiteness(
    block: tuple[str, ...], mass: Floats, stiffness: Floats, labels: Sequence[str] = ()
) -> Indefinite | None:
    """None for a positive definite stiffness (m, m), else what is wrong with it, with the admissible range of its
    entries.

    Checked on the matrix scaled to a unit diagonal, so that units and sizes do not matter.
    """
    diagonal = np.diag(stiffness)
    if np.all(diagonal > 0.0):
        scale = 1.0 / np.sqrt(diagonal)
        scaled = float(np.linalg.eigvalsh(stiffness * scale[:, None] * scale)[0])
    else:
        scaled = float(diagonal.min() / max(float(np.abs(stiffness).max()), 1e-300))
    if scaled > DEFINITE:
        return None
    squared = squared_frequencies(mass, stiffness)
    return Indefinite(
        block,
        scaled,
        float(np.linalg.eigvalsh(stiffness)[0]),
        sqrt(max(0.0, -float(squared[0]))),
        tuple(float(value) for value in squared),
        _admissible(stiffness, labels or block),
    )


def _admissible(stiffness: Floats, labels: Sequence[str]) -> str:
    """The range of the entries of a 1x1 or 2x2 block that makes it definite, the rule for larger ones."""
    if len(stiffness) == 1:
        return f"{labels[0]} > 0"
    if len(stiffness) == 2 and np.all(np.diag(stiffness) > 0.0):
        first, second, cross = stiffness[0, 0], stiffness[1, 1], abs(stiffness[0, 1])
        names = labels if len(labels) == 3 else ("first diagonal", "second diagonal", "coupling")
        return (
            f"{names[1]} > {cross * cross / first:.6e} or {names[0]} > {cross * cross / second:.6e} "
            f"or |{names[2]}| < {sqrt(first * second):.6e}"
        )
    return "a positive diagonal and positive leading minors"


def squared_frequencies(mass: Floats, stiffness: Floats) -> Floats:
    """Squares of the natural frequencies (..., m), (rad/s)^2 with sign, ascending, of K x = omega^2 M x, K (..., m,
    m).
    """
    return np.asarray(np.linalg.eigvalsh(_normalised(mass, stiffness)))


def modes(mass: Floats, stiffness: Floats) -> tuple[Floats, Floats]:
    """Squared frequencies (..., m) with sign and mass-normalised mode shapes (..., m, m) in columns, largest entry
    positive.
    """
    values, vectors = np.linalg.eigh(_normalised(mass, stiffness))
    shapes = np.linalg.solve(np.linalg.cholesky(mass).T, vectors)
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(-2)[..., None, :], -2)
    return values, np.asarray(shapes * np.sign(largest))


def _normalised(mass: Floats, stiffness: Floats) -> Floats:
    """L^-1 K L^-T with M = L L^T: symmetric, with the squared frequencies as eigenvalues."""
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    out = inverse @ stiffness @ inverse.T
    return np.asarray((out + np.swapaxes(out, -1, -2)) / 2.0)
