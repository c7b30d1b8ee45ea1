"""The contact of a roller on a rocker with its disc cam, written out for speed: what most of the solver's time goes to.

The same equations as `CurveSide.compiled` of impact_roller, with rocker and disc put in, so that a contact costs no
calls but those of the exponential and the motion; a test holds it to the array evaluation.
"""

from __future__ import annotations

import cmath
from collections.abc import Callable

from camgeom.dynamics.impact.lift import LiftJets
from camgeom.dynamics.impact.side import Touch, Toucher

Search = Callable[[int, float, complex], tuple[complex, complex, complex]]
"""(arc, angle past its start, roller centre) -> point, first and second derivative at the foot, when Newton fails"""


def swing_toucher(
    jets: LiftJets,
    pivot: float,
    length: float,
    phase: float,
    shift: float,
    radius: float,
    gap: float,
    taylor: float,
    reach: float,
    search: Search,
) -> Toucher:
    """The contact function of one roller; lengths in m, angles in rad, named as in `CurveSide`."""
    exp, at = cmath.exp, jets.at
    ahead = shift - phase

    def touch(k: int, x: float, s0: float, s1: float, s2: float, eta: float) -> Touch:
        zp = length * exp(-1j * (s0 + eta - phase))
        p = pivot - zp
        z = length * exp(-1j * (s0 + ahead))
        c = pivot - z
        u1, u2, e, found = s1, s2, 0.0, False
        c1 = 1j * (z * u1 - c)
        for _ in range(12):
            c2 = z * (u1 * (u1 + 2.0) + 1j * u2) - c
            w = p - c
            size = c1.real * c1.real + c1.imag * c1.imag
            slope = w.real * c2.real + w.imag * c2.imag - size
            if slope > -0.05 * size:
                break
            de = -(w.real * c1.real + w.imag * c1.imag) / slope
            if -taylor < de < taylor:
                w -= de * (c1 + 0.5 * de * c2)
                c1 += de * c2
                found = True
                break
            e += de
            if not -reach < e < reach:
                break
            u0, u1, u2 = at(k, x + e)
            z = length * exp(-1j * (u0 + ahead + e))
            c = pivot * exp(-1j * e) - z
            c1 = 1j * (z * u1 - c)
        if not found:
            c, c1, c2 = search(k, x, p)
            w = p - c
        speed = abs(c1)
        n = 1j * c1 / speed
        nr, ni = n.real, n.imag
        foot = p - radius * n
        across = foot - pivot
        bend = (c1.real * c2.imag - c1.imag * c2.real) / (speed * speed * speed)
        return (
            -(w.real * nr + w.imag * ni) - gap,
            zp.real * ni - zp.imag * nr,
            foot.real * ni - foot.imag * nr,
            -across.real * nr - across.imag * ni,
            foot.real * nr + foot.imag * ni,
            -bend / (1.0 + bend * radius),
        )

    return touch
