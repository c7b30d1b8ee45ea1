"""Laws in one formula: straight line, harmonics, polynomials of rest-to-rest motion, finite Fourier series."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from camgeom.errors import Problem, ProfileError
from camgeom.motion.catalogue import law
from camgeom.motion.law import Claims, Parameter
from camgeom.motion.table import Piece

NORTON = "R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009"
ROTHBART = "H. A. Rothbart (ed.), Cam Design Handbook, McGraw-Hill 2004"
FREUDENSTEIN = (
    f"F. Freudenstein, On the dynamics of high-speed cam profiles, Int. J. Mech. Sci. 1 (1960); {ROTHBART}, ch. 4"
)

HARMONIC = Claims(math.pi / 2, math.pi**2 / 2, math.inf, math.pi**3 / 8, math.pi**2 / math.sqrt(8), 1, 1)
CYCLOID = Claims(2.0, 2 * math.pi, 4 * math.pi**2, 3 * math.sqrt(3) * math.pi / 2, math.sqrt(2) * math.pi, 2, 2)
CUBIC = Claims(1.5, 6.0, math.inf, 2 * math.sqrt(3), 2 * math.sqrt(3), 1, 1)
QUINTIC = Claims(1.875, 10 / math.sqrt(3), 60.0, 6.694268727, math.sqrt(120 / 7), 2, 2)
SEPTIC = Claims(2.1875, 7.513188404, 52.5, 10.75022616, 5.045249791, 3, 3)


def symmetric(power: Sequence[float], *waves: tuple[float, float, float]) -> list[Piece]:
    """The law whose first half is the given formula about x = 0 and whose second half is its point reflection."""
    first = Piece(0.0, 0.5, 0.0, tuple(power), waves)
    return [first, first.mirrored()]


def reversed_if(reverse: bool, pieces: list[Piece]) -> list[Piece]:
    """The law run backwards, so that its end becomes its start."""
    return [piece.mirrored() for piece in reversed(pieces)] if reverse else pieces


def sine_series(*heights: float) -> list[Piece]:
    """The law with acceleration sum_k heights[k - 1] sin(2 pi k x), where sum_k heights[k - 1] / (2 pi k) = 1."""
    turns = [2.0 * math.pi * k for k in range(1, len(heights) + 1)]
    waves = [(w, 0.0, -height / w**2) for w, height in zip(turns, heights, strict=True) if height != 0.0]
    return symmetric((0.0, 1.0), *waves)


def _reverse(what: str) -> Parameter:
    return Parameter(False, 0, 1, f"run the law backwards: {what}", "switch")


@law("constant-velocity", source=NORTON, claims=Claims(1.0, math.inf, math.inf, math.inf, math.inf, 0, 0))
def constant_velocity() -> list[Piece]:
    """A straight line: for ramps between moving neighbours; against a dwell the velocity jumps."""
    return symmetric((0.0, 1.0))


@law(
    "simple-harmonic",
    source=NORTON,
    claims=HARMONIC,
)
def simple_harmonic() -> list[Piece]:
    """Half a cosine: smooth inside, the acceleration jumps against a dwell."""
    return symmetric((0.0,), (math.pi, -0.5, 0.0))


@law(
    "double-harmonic",
    source=f"{ROTHBART}, ch. 2",
    claims=Claims(2.040524285, math.pi**2, math.inf, 9.894846853, math.pi**2 / 2, 3, 1),
    cases=[({"reverse": True}, Claims(2.040524285, math.pi**2, math.inf, 9.894846853, math.pi**2 / 2, 1, 3))],
    reverse=_reverse("smooth against a dwell at the end instead of the start"),
)
def double_harmonic(reverse: bool) -> list[Piece]:
    """Two cosines: smooth out of a dwell, full acceleration at the turning point: for rise-return-dwell."""
    first = Piece(0.0, 0.5, 0.0, (0.0,), ((math.pi, -0.5, 0.0), (2 * math.pi, 0.125, 0.0)))
    second = Piece(0.5, 1.0, 1.0, (1.0,), ((math.pi, 0.5, 0.0), (2 * math.pi, 0.125, 0.0)))
    return reversed_if(reverse, [first, second])


@law(
    "cycloidal",
    source=NORTON,
    claims=CYCLOID,
)
def cycloidal() -> list[Piece]:
    """A full sine of acceleration: gentle ends, high peak."""
    return sine_series(2 * math.pi)


@law(
    "gutman-1-3",
    source=f"A. S. Gutman, To avoid vibration - try this new cam profile, Product Engineering 1961; {ROTHBART}, ch. 4",
    claims=Claims(2.0, 5.130199321, 6 * math.pi**2, 8.124857839, 4.247690025, 2, 2),
)
def gutman_1_3() -> list[Piece]:
    """Sine and third harmonic of acceleration, the parabola's shape with little vibration: the law "Gutman 1-3"."""
    return sine_series(15 * math.pi / 8, 0.0, 3 * math.pi / 8)


@law(
    "freudenstein-1-3",
    source=FREUDENSTEIN,
    claims=Claims(2.0, 5.385587406, 36 * math.pi**2 / 7, 7.917471704, 4.310573157, 2, 2),
)
def freudenstein_1_3() -> list[Piece]:
    """Sine and third harmonic that weigh peak acceleration against its harmonics."""
    return sine_series(2 * math.pi * 27 / 28, 0.0, 2 * math.pi * 3 / 28)


@law(
    "freudenstein-1-3-5",
    source=FREUDENSTEIN,
    claims=Claims(2.0, 5.060283469, 59.61506014, 7.850056552, 4.251823658, 2, 2),
)
def freudenstein_1_3_5() -> list[Piece]:
    """Sine, third and fifth harmonic that weigh peak acceleration against its harmonics."""
    unit = 2 * math.pi * 1125 / 1192
    return sine_series(unit, 0.0, unit / 6, 0.0, unit / 50)


@law(
    "triple-harmonic",
    source=f"finite sine series, {ROTHBART}, ch. 4; the default lies near the first terms of the modified sine",
    claims=Claims(1.780366179, 5.871874953, 66.71905728, 4.952041181, 3.925700273, 2, 2),
    cases=[
        ({"first": 2 * math.pi, "second": 0.0}, CYCLOID),
    ],
    first=Parameter(5.31, 0.0, 12.0, "height of sin(2 pi x) in the acceleration"),
    second=Parameter(1.38, -12.0, 12.0, "height of sin(4 pi x); sin(6 pi x) takes what a lift of one needs"),
)
def triple_harmonic(first: float, second: float) -> list[Piece]:
    """Three sines of acceleration with free shares: one formula that imitates most symmetric laws."""
    return sine_series(first, second, 6 * math.pi - 3 * first - 1.5 * second)


@law(
    "cubic-1",
    source=f"{ROTHBART}, ch. 2: constant pulse No. 1",
    claims=Claims(3.0, 12.0, math.inf, 36.0, 4 * math.sqrt(3), 2, 2, 1),
)
def cubic_1() -> list[Piece]:
    """Constant jerk in each half: acceleration grows from zero and flips at the middle."""
    return symmetric((0.0, 0.0, 0.0, 4.0))


@law(
    "cubic-2",
    source=f"{ROTHBART}, ch. 2: constant pulse No. 2",
    claims=CUBIC,
)
def cubic_2() -> list[Piece]:
    """The 2-3 polynomial, constant jerk throughout: straight acceleration, which jumps against a dwell."""
    return symmetric((0.0, 0.0, 3.0, -2.0))


@law("3-4-5", source=NORTON, claims=QUINTIC)
def polynomial_345() -> list[Piece]:
    """The polynomial of fifth degree with zero end acceleration: all-round."""
    return symmetric((0.0, 0.0, 0.0, 10.0, -15.0, 6.0))


@law("4-5-6-7", source=NORTON, claims=SEPTIC)
def polynomial_4567() -> list[Piece]:
    """The polynomial of seventh degree with zero end jerk: quiet ends, higher peaks."""
    return symmetric((0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0))


@law("5-6-7-8-9", source=NORTON, claims=Claims(2.4609375, 9.371976218, 78.75, 15.43593559, 5.936729339, 4, 4))
def polynomial_56789() -> list[Piece]:
    """The polynomial of ninth degree with zero fourth end derivative: quietest ends, highest peaks."""
    return symmetric((0.0, 0.0, 0.0, 0.0, 0.0, 126.0, -420.0, 540.0, -315.0, 70.0))


@law(
    "power-polynomial",
    source=f"D. A. Stoddart, Polydyne cam design, Machine Design 25 (1953); {ROTHBART}, ch. 3",
    claims=Claims(2.0736, 8.134530459, 120.0, 10.10019539, 4.780914437, 2, 3),
    cases=[
        ({"exponents": (3, 4, 5)}, QUINTIC),
        ({"exponents": (2, 3)}, CUBIC),
    ],
    exponents=Parameter(
        (3, 4, 5, 6), 1, 24, "rising exponents; n of them make n - 1 derivatives vanish at the end", "list"
    ),
    reverse=_reverse("the start gets the end's smoothness"),
)
def power_polynomial(exponents: tuple[int, ...], reverse: bool) -> list[Piece]:
    """A polynomial of chosen exponents, for example 2-10-12-14: as smooth at the end as it has terms."""
    whole = all(isinstance(p, int) and not isinstance(p, bool) and 1 <= p <= 24 for p in exponents)
    if not whole or not 1 <= len(exponents) <= 12 or any(p >= q for p, q in pairwise(exponents)):
        message = "the exponents must be whole numbers that rise"
        raise ProfileError([Problem("exponents", message, exponents, "1 to 12 whole numbers from 1 to 24, rising")])
    terms = {p: math.prod((Fraction(q, q - p) for q in exponents if q != p), start=Fraction(1)) for p in exponents}
    about_start = [terms.get(k, Fraction(0)) for k in range(exponents[-1] + 1)]
    # Exact fractions: shifting a polynomial of high degree to the other end in floating point would cost its digits.
    about_end = [sum((c * math.comb(p, k) for p, c in terms.items()), Fraction(0)) for k in range(len(about_start))]
    first = Piece(0.0, 0.5, 0.0, tuple(float(c) for c in about_start))
    return reversed_if(reverse, [first, Piece(0.5, 1.0, 1.0, tuple(float(c) for c in about_end))])
