"""Sliding of the roller where the loaded wall changes and its spin must reverse.

Units N, mm, s, rad; inertia kg m².
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.maths import Floats

KILO = 1e3
"""kg m² rad/s² (N m) in N mm"""


@final
@dataclass(frozen=True, eq=False)
class SpinReversal:
    """What happens when a roller meets the other wall: each field (...).

    slip: sliding speed at first touch, mm/s; time: until it rolls again, s; cam_angle: turned meanwhile, rad;
    distance: slid, mm; energy: turned into heat, N mm (mJ).
    """

    slip: Floats
    time: Floats
    cam_angle: Floats
    distance: Floats
    energy: Floats


def slip_speed(path_rate: ArrayLike, speed: ArrayLike) -> Floats:
    """Sliding speed, mm/s, of a roller that changes walls: 2 v, with v = omega dl/dphi the speed of its centre.

    On one wall the roller spins at v/r, on the other at -v/r: before it has turned round, its rim passes the new wall
    at the speed of the centre plus that of the rim.
    """
    return np.asarray(2.0 * np.abs(np.asarray(path_rate, dtype=np.float64) * np.asarray(speed, dtype=np.float64)))


def spin_reversal(path_rate: ArrayLike, speed: ArrayLike, force_rate: ArrayLike, roller_radius: ArrayLike,
                  roller_inertia: ArrayLike, friction: ArrayLike) -> SpinReversal:
    """Estimate of the sliding after a change of walls, without backlash.

    path_rate mm/rad; cam speed rad/s; force_rate: slope of the normal force just after the change, N/rad; radius mm;
    inertia of roller and outer ring about the axis, kg m²; friction coefficient. The force grows as q t from zero, so
    that mu r q t²/2 = J 2v/r: time t = sqrt(4 J v / (mu q r²)), slid distance 2 v t 2/3, energy J (2v/r)²/2. The speed
    v is taken as constant during the slide, which holds while the cam angle turned is small.
    """
    v = 0.5 * slip_speed(path_rate, speed)
    r, mu, omega = (np.asarray(x, dtype=np.float64) for x in (roller_radius, friction, speed))
    inertia = KILO * np.asarray(roller_inertia, dtype=np.float64)
    growth = np.abs(np.asarray(force_rate, dtype=np.float64)) * np.abs(omega)
    if np.any(mu * growth <= 0.0):
        raise ValueError("without friction or without a growing force the roller never takes up its new spin")
    time = np.sqrt(4.0 * inertia * v / (mu * growth)) / r
    return SpinReversal(2.0 * v, np.asarray(time), np.asarray(np.abs(omega) * time),
                        np.asarray(4.0 / 3.0 * v * time), np.asarray(0.5 * inertia * (2.0 * v / r) ** 2))
