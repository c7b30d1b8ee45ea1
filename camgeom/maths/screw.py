"""Pose jets: a point or direction carried by a joint and seen from a turning body, with exact derivatives.

All jets here are component-major, shape (order + 1, 3, n): derivative order, xyz, parameter value. Derivatives are with
respect to the cam angle phi. Orders up to 3.
"""

from __future__ import annotations

from math import comb

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats

Complexes = npt.NDArray[np.complex128]


def constant_jet(vector: Floats, order: int, n: int) -> Floats:
    """Jet of a vector that does not move, (order + 1, 3, n)."""
    jet = np.zeros((order + 1, 3, n))
    jet[0] = np.asarray(vector, dtype=float)[:, None]
    return jet


def slide_jet(point: Floats, direction: Floats, coordinate: Floats) -> Floats:
    """Jet of a point that slides: point + coordinate * direction.

    coordinate  (order + 1, n) jet of the joint coordinate, mm
    Returns (order + 1, 3, n).
    """
    jet = coordinate[:, None, :] * np.asarray(direction, dtype=float)[None, :, None]
    jet[0] += np.asarray(point, dtype=float)[:, None]
    return np.asarray(jet)


def unit_circle_jet(angle: Floats) -> Complexes:
    """Jet of exp(i angle(phi)), (order + 1, n), by the chain rule (Faà di Bruno), order <= 3."""
    order = len(angle) - 1
    g = np.exp(1j * angle[0])
    jet = np.empty((order + 1, *g.shape), dtype=complex)
    jet[0] = g
    if order >= 1:
        jet[1] = 1j * angle[1] * g
    if order >= 2:
        jet[2] = (1j * angle[2] - angle[1] ** 2) * g
    if order >= 3:
        jet[3] = (1j * angle[3] - 3.0 * angle[1] * angle[2] - 1j * angle[1] ** 3) * g
    return jet


def swing_jet(vector: Floats, axis: Floats, circle: Complexes) -> Floats:
    """Jet of a vector turned about a unit axis by the angle whose circle jet is given.

    circle  (order + 1, n) from `unit_circle_jet`
    Returns (order + 1, 3, n); the component along the axis stays.
    """
    vector, axis = np.asarray(vector, dtype=float), np.asarray(axis, dtype=float)
    along = float(vector @ axis) * axis
    across = vector - along
    (a, b, c), (x, y, z) = axis.tolist(), across.tolist()
    third = np.array([b * z - c * y, c * x - a * z, a * y - b * x])
    jet: Floats = circle.real[:, None, :] * across[:, None]
    jet += circle.imag[:, None, :] * third[:, None]
    jet[0] += along[:, None]
    return jet


def seen_from_turning(jet: Floats, turn: Complexes, sense: float) -> Floats:
    """Jet in a frame that turns by sense * phi about Z: Rz(-sense phi) applied with all its derivatives.

    jet   (order + 1, 3, n) in the fixed frame
    turn  (n,) exp(-i sense phi), computed once per angle by the caller
    In the plane, d/dphi of exp(-i sense phi) z is exp(-i sense phi) (z' - i sense z); Leibniz gives every order.
    """
    order = len(jet) - 1
    z = jet[:, 0] + 1j * jet[:, 1]
    out = np.empty_like(jet)
    spin = -1j * sense
    for k in range(order + 1):
        total = z[k].copy()
        for j in range(k):
            total += comb(k, j) * spin ** (k - j) * z[j]
        total *= turn
        out[k, 0], out[k, 1] = total.real, total.imag
        out[k, 2] = jet[k, 2]
    return out
