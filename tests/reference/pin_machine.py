"""The pin-insertion machine of doi 10.13705/j.issn.1671-6833.2023.01.017, for the tests of load and fatigue."""

from __future__ import annotations

import numpy as np

from camgeom.mechanics.applied import Applied, expression_force
from camgeom.mechanics.load import Load
from camgeom.mechanics.material import Material

SPEED = 600.0 * 2.0 * np.pi / 60.0
PITCH_RADIUS = 67.0
ROLLER_RADIUS = 11.0
LENGTH = 12.0
ROLLER = Material(elastic_modulus=2.08e5, poisson=0.30)
CAM = Material(elastic_modulus=2.18e5, poisson=0.28)
INSERTION = "79.55*((56*pi - 36*phi)/(13*pi) + sin((72*phi - 86*pi)/13)/(2*pi))"
INSERTION_FROM = 4.456
INSERTION_UNTIL = 14.0 * np.pi / 9.0


class Cycloids:
    """A motion of cycloidal segments written out in the plainest way: rows of (from deg, until deg, from mm, to mm)."""

    def __init__(self, rows: tuple[tuple[float, float, float, float], ...]) -> None:
        self.rows = rows
        self.knots = np.radians([rows[0][0], *(row[1] for row in rows)])

    def jet(self, theta: np.ndarray, order: int = 3) -> np.ndarray:
        turned = np.mod(theta, 2.0 * np.pi)
        out = np.zeros((order + 1, turned.size))
        for begin, until, low, high in self.rows:
            a, b = np.radians(begin), np.radians(until)
            here = (turned >= a) & (turned < b)
            x, wide, lift, w = (turned[here] - a) / (b - a), b - a, high - low, 2.0 * np.pi
            series = (x - np.sin(w * x) / w, 1.0 - np.cos(w * x), w * np.sin(w * x), w * w * np.cos(w * x))
            for k in range(order + 1):
                out[k, here] = lift * series[k] / wide**k
            out[0, here] += low
        return out


PIN_MOTION = Cycloids(((0, 155, 0, 0), (155, 215, 0, 37), (215, 280, 37, 74), (280, 290, 74, 74), (290, 360, 74, 0)))


def insertion() -> Applied:
    return expression_force(INSERTION, INSERTION_FROM, INSERTION_UNTIL)


def pin_load(speed: object = SPEED, **changes: object) -> Load:
    given = {"mass": 2.25, "friction": 8.3, "applied": (insertion(),)} | changes
    return Load(PIN_MOTION, speed, **given)  # type: ignore[arg-type]
