"""One step of the explicit Runge-Kutta pair DOP853 for a state that is a single complex number.

A one-coordinate system has the state (position, velocity); held as position + 1j * velocity every linear combination of
the stages is one Python operation, so a step costs a few microseconds beside its twelve calls of the right-hand side.
The same code takes a complex numpy array where more coordinates are needed (roller spin).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

Rate = Callable[[float, Any], tuple[Any, complex]]
"""f(t, y) -> (dy/dt, powers); the powers (two of them in one complex number) are integrated beside the state."""


class Stepped(NamedTuple):
    """A trial step: the new state, its error measure vectors of order 5 and 3, and the integrated powers."""

    state: Any
    fifth: Any
    third: Any
    work: complex


def step(f: Rate, t: float, y: Any, k1: Any, p1: complex, h: float) -> Stepped:
    """The state at t + h by the 12-stage method of order 8 of Dormand and Prince, as given by Hairer.

    `k1, p1` are f(t, y). Coefficients: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
    section II.10 (DOP853). They stand in the text as literals because a literal is the quickest operand there is.
    The powers take the quadrature of the same order and never feed back.
    """
    k2, _ = f(t + 0.05260015195876773 * h, y + h * (0.05260015195876773 * k1))
    k3, _ = f(t + 0.0789002279381516 * h, y + h * (0.0197250569845379 * k1 + 0.0591751709536137 * k2))
    k4, _ = f(t + 0.1183503419072274 * h, y + h * (0.02958758547680685 * k1 + 0.08876275643042054 * k3))
    rise = 0.2413651341592667 * k1 - 0.8845494793282861 * k3 + 0.924834003261792 * k4
    k5, _ = f(t + 0.2816496580927726 * h, y + h * rise)
    rise = 0.037037037037037035 * k1 + 0.17082860872947386 * k4 + 0.12546768756682242 * k5
    k6, p6 = f(t + 0.3333333333333333 * h, y + h * rise)
    rise = 0.037109375 * k1 + 0.17025221101954405 * k4 + 0.06021653898045596 * k5 - 0.017578125 * k6
    k7, p7 = f(t + 0.25 * h, y + h * rise)
    rise = (
        0.03709200011850479 * k1
        + 0.17038392571223998 * k4
        + 0.10726203044637328 * k5
        - 0.015319437748624402 * k6
        + 0.008273789163814023 * k7
    )
    k8, p8 = f(t + 0.3076923076923077 * h, y + h * rise)
    rise = (
        0.6241109587160757 * k1
        - 3.3608926294469414 * k4
        - 0.868219346841726 * k5
        + 27.59209969944671 * k6
        + 20.154067550477894 * k7
        - 43.48988418106996 * k8
    )
    k9, p9 = f(t + 0.6512820512820513 * h, y + h * rise)
    rise = (
        0.47766253643826434 * k1
        - 2.4881146199716677 * k4
        - 0.590290826836843 * k5
        + 21.230051448181193 * k6
        + 15.279233632882423 * k7
        - 33.28821096898486 * k8
        - 0.020331201708508627 * k9
    )
    k10, p10 = f(t + 0.6 * h, y + h * rise)
    rise = (
        -0.9371424300859873 * k1
        + 5.186372428844064 * k4
        + 1.0914373489967295 * k5
        - 8.149787010746927 * k6
        - 18.52006565999696 * k7
        + 22.739487099350505 * k8
        + 2.4936055526796523 * k9
        - 3.0467644718982196 * k10
    )
    k11, p11 = f(t + 0.8571428571428571 * h, y + h * rise)
    rise = (
        2.273310147516538 * k1
        - 10.53449546673725 * k4
        - 2.0008720582248625 * k5
        - 17.9589318631188 * k6
        + 27.94888452941996 * k7
        - 2.8589982771350235 * k8
        - 8.87285693353063 * k9
        + 12.360567175794303 * k10
        + 0.6433927460157636 * k11
    )
    k12, p12 = f(t + h, y + h * rise)
    rise = (
        0.054293734116568765 * k1
        + 4.450312892752409 * k6
        + 1.8915178993145003 * k7
        - 5.801203960010585 * k8
        + 0.3111643669578199 * k9
        - 0.1521609496625161 * k10
        + 0.20136540080403034 * k11
        + 0.04471061572777259 * k12
    )
    fifth = (
        0.01312004499419488 * k1
        - 1.2251564463762044 * k6
        - 0.4957589496572502 * k7
        + 1.6643771824549864 * k8
        - 0.35032884874997366 * k9
        + 0.3341791187130175 * k10
        + 0.08192320648511571 * k11
        - 0.022355307863886294 * k12
    )
    third = rise - 0.2440944881889764 * k1 - 0.7338466882816118 * k9 - 0.022058823529411766 * k12
    work = h * (
        0.054293734116568765 * p1
        + 4.450312892752409 * p6
        + 1.8915178993145003 * p7
        - 5.801203960010585 * p8
        + 0.3111643669578199 * p9
        - 0.1521609496625161 * p10
        + 0.20136540080403034 * p11
        + 0.04471061572777259 * p12
    )
    return Stepped(y + h * rise, fifth, third, work)


def error_norm(made: Stepped, h: float, scale: complex) -> float:
    """The error of a step over its tolerance, 1; `scale` holds the tolerances of the two components of the state."""
    a, b = made.fifth.real / scale.real, made.fifth.imag / scale.imag
    c, d = made.third.real / scale.real, made.third.imag / scale.imag
    five, three = a * a + b * b, c * c + d * d
    if five == 0.0:
        return 0.0
    return float(abs(h) * five / math.sqrt(2.0 * (five + 0.01 * three)))


def next_step(h: float, error: float) -> float:
    """The step to try after one of length h whose error over the tolerance was `error` (safety 0.9, 0.2 to 8 times)."""
    if error == 0.0:
        return 8.0 * h
    return h * min(8.0, max(0.2, 0.9 * math.pow(error, -0.125)))
