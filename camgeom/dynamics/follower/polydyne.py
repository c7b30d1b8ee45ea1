"""Polydyne cams: the law whose dynamic response is the wanted motion, for given stiffness, mass and speed.

The follower mass m shall do y(t). Up the chain: the linkage must carry m y.. + c y. + k_s y, so its cam end does
y + (m y.. + c y. + k_s y)/k; with a tappet mass on an elastic contact the same step once more. The cam law is the
operator

    P(D) y / P(0),   P(D) = sum_j a_j D^j,   D = d/dx, x = t/T over the rise time T

on the pieces of the wanted law, so it is again an exact law. A constant preload only shifts the follower and drops
out. A damper in the linkage or the contact would make P rational and the law no sum of powers and waves: it is
refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from camgeom.dynamics.follower.train import FollowerTrain
from camgeom.dynamics.linear.method import Motion, Side
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats
from camgeom.motion.law import Law, finish
from camgeom.motion.table import Piece, Wave

ROUNDING = 1e-9
"""derivative of the wanted law at its ends, over its largest coefficient, that counts as zero"""


@dataclass(frozen=True)
class Polydyne:
    """The corrected cam law and what it belongs to.

    law is normalised; lift_factor is the cam lift for a unit lift of the follower mass (the return spring bends the
    linkage); coefficients a_0 .. a_p of the operator in D = d/dx; rise_time in s; continuity of the cam law
    (derivatives that do not jump).
    """

    law: Law
    lift_factor: float
    coefficients: tuple[float, ...]
    rise_time: float
    continuity: int


def polydyne(wanted: Law, train: FollowerTrain, rise_time: float) -> Polydyne:
    """Cam law for which the follower mass does the wanted law at this rise time in s.

    The operator has order 2 (4 with a tappet mass), so the wanted law must be smooth to one order more; ProfileError
    says by how much it falls short. At any other speed the response vibrates like that of any other law.
    """
    coefficients = operator(train, rise_time)
    order = len(coefficients) - 1
    smooth = wanted.peaks().order
    _refuse(train, f"the law {wanted.name}", smooth, order)
    pieces = [_combined(piece, coefficients) for piece in wanted.pieces]
    law = Law(f"polydyne {wanted.name}", finish(pieces), f"polydyne correction of {wanted.name}")
    return Polydyne(law, coefficients[0], tuple(coefficients), rise_time, smooth - order)


@dataclass(frozen=True, eq=False)
class PolydyneMotion:
    """The cam's motion P(D) y, D = d/dtheta, for which the follower mass does the motion `wanted` at one speed.

    It has the jets and knots of a motion program, in the lift unit of `wanted`; coefficients per rad^j.
    """

    wanted: Motion
    coefficients: tuple[float, ...]

    @property
    def knots(self) -> Floats:
        """Cam angles in rad where some derivative may jump."""
        return self.wanted.knots

    def jet(self, theta: Floats, order: int = 3, side: Side = "right") -> Floats:
        """Lift and derivatives per rad (order + 1, ...) at cam angles theta in rad."""
        jets = self.wanted.jet(theta, order + len(self.coefficients) - 1, side)
        return np.asarray(sum(a * jets[j : j + order + 1] for j, a in enumerate(self.coefficients)))


def polydyne_motion(wanted: Motion, smooth: int, train: FollowerTrain, speed: float) -> PolydyneMotion:
    """The corrected motion of a whole turn at a cam speed in rad/s; smooth: continuous derivatives of `wanted`.

    Raises ProfileError as `polydyne` does.
    """
    coefficients = operator(train, 1.0 / speed)
    _refuse(train, "the motion", smooth, len(coefficients) - 1)
    return PolydyneMotion(wanted, coefficients)


def _refuse(train: FollowerTrain, name: str, smooth: int, order: int) -> None:
    """ProfileError for damping that P cannot take, and for a motion that is not smooth enough for it."""
    problems = []
    if train.damping > 0.0 or (train.two_masses and train.contact_damping > 0.0):
        text = "polydyne correction takes damping to ground only"
        problems.append(Problem("dynamics.damping", text, train.damping, "0", "give return_damping instead"))
    if smooth < order + 1:
        text = f"{name} has {smooth} continuous derivatives, the correction needs {order + 1}"
        problems.append(
            Problem("motion.law", text, None, "", 'take a smoother one such as "5-6-7-8-9" or "polynomial"')
        )
    if problems:
        raise ProfileError(problems)


def operator(train: FollowerTrain, rise_time: float) -> tuple[float, ...]:
    """Coefficients a_j of P(D), no unit, for a rise time in s; a_0 is the static cam lift per follower lift."""
    if not (np.isfinite(rise_time) and rise_time > 0.0):
        raise ProfileError([Problem("dynamics.rise_time", "must be positive", rise_time, "> 0 s")])
    load = np.array([train.return_stiffness, train.return_damping / rise_time, train.mass / rise_time**2])
    end = load / train.stiffness
    end[0] += 1.0
    if not train.two_masses:
        return tuple(float(a) for a in end)
    force = np.convolve([0.0, 0.0, train.tappet_mass / rise_time**2], end)
    force[:3] += load
    force /= train.contact_stiffness
    force[:3] += end
    return tuple(float(a) for a in force)


def _combined(piece: Piece, coefficients: tuple[float, ...]) -> Piece:
    """sum_j (a_j / a_0) D^j of a piece."""
    part = piece
    total = part
    for a in coefficients[1:]:
        part = differentiated(part)
        total = _sum(total, part.scaled(a / coefficients[0]))
    return total


def differentiated(piece: Piece) -> Piece:
    """The derivative of a piece: d/du [a (cos w u - 1) + b sin w u] = w b (cos w u - 1) + w b - w a sin w u."""
    power = [k * c for k, c in enumerate(piece.power)][1:] or [0.0]
    power[0] += sum(w * b for w, _, b in piece.waves)
    return Piece(
        piece.start, piece.end, piece.anchor, tuple(power), tuple((w, w * b, -w * a) for w, a, b in piece.waves)
    )


def _sum(first: Piece, second: Piece) -> Piece:
    """Sum of two pieces on one interval and anchor."""
    count = max(len(first.power), len(second.power))
    power = [0.0] * count
    for part in (first.power, second.power):
        for k, c in enumerate(part):
            power[k] += c
    waves: dict[float, Wave] = {}
    for w, a, b in (*first.waves, *second.waves):
        _, a0, b0 = waves.get(w, (w, 0.0, 0.0))
        waves[w] = (w, a0 + a, b0 + b)
    return Piece(first.start, first.end, first.anchor, tuple(power), tuple(waves.values()))
