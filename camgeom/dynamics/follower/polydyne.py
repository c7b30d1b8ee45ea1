"""Polydyne cams: the motion whose dynamic response is the wanted one, for given stiffness, mass and speed.

The follower mass m shall do y(t). Up the chain: the linkage must carry m y.. + c y. + k_s y, so its cam end does
y + (m y.. + c y. + k_s y)/k; with a tappet mass on an elastic contact the same step once more. The cam's motion is

    P(D) y,   P(D) = sum_j a_j D^j,   D = d/dtheta

so its jets are exact. A constant preload only shifts the follower and drops out. A damper in the linkage or the contact
would make P rational: it is refused.
"""

from __future__ import annotations

import numpy as np

from camgeom.dynamics.follower.train import FollowerTrain
from camgeom.dynamics.linear.method import DrivenMotion, Side
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats


@immutable
class PolydyneMotion:
    """The cam's motion P(D) y, D = d/dtheta, for which the follower mass does the motion `wanted` at one speed.

    It has the jets and knots of a motion program, in the lift unit of `wanted`; coefficients per rad^j.
    """

    wanted: DrivenMotion
    coefficients: tuple[float, ...]

    @property
    def knots(self) -> Floats:
        """Cam angles in rad where some derivative may jump."""
        return self.wanted.knots

    def jet(self, theta: Floats, order: int = 3, side: Side = "right") -> Floats:
        """Lift and derivatives per rad (order + 1, ...) at cam angles theta in rad."""
        jets = self.wanted.jet(theta, order + len(self.coefficients) - 1, side)
        return np.asarray(sum(a * jets[j : j + order + 1] for j, a in enumerate(self.coefficients)))


def polydyne_motion(wanted: DrivenMotion, smooth: int, train: FollowerTrain, speed: float) -> PolydyneMotion:
    """The corrected motion of a whole turn at a cam speed in rad/s; smooth: continuous derivatives of `wanted`.

    The operator has order 2 (4 with a tappet mass), so the wanted motion must be smooth to one order more; ProfileError
    says by how much it falls short. At any other speed the response vibrates like that of any other motion.
    """
    coefficients = operator(train, 1.0 / speed)
    _refuse(train, smooth, len(coefficients) - 1)
    return PolydyneMotion(wanted, coefficients)


def _refuse(train: FollowerTrain, smooth: int, order: int) -> None:
    """ProfileError for damping that P cannot take, and for a motion that is not smooth enough for it."""
    problems = []
    if train.damping > 0.0 or (train.two_masses and train.contact_damping > 0.0):
        text = "polydyne correction takes damping to ground only"
        problems.append(Problem("dynamics.damping", text, train.damping, "0", "give return_damping instead"))
    if smooth < order + 1:
        text = f"the motion has {smooth} continuous derivatives, the correction needs {order + 1}"
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
