"""Laws built from blocks of acceleration: quarter waves, constants and ramps, integrated twice without error.

A half of such a law is a list of blocks (width, shape) of unit height, told from the end at rest. `joined` scales the
accelerating and the decelerating half so that the velocities meet and the lift is one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from camgeom.errors import Problem, ProfileError
from camgeom.motion.catalogue import law
from camgeom.motion.law import Claims, Parameter
from camgeom.motion.laws_basic import CYCLOID, HARMONIC
from camgeom.motion.table import Piece

PARABOLA = Claims(2.0, 4.0, math.inf, 8.0, 4.0, 1, 1, 1)
SINE = Claims(1.759603386, 5.527957071, 69.46635729, 5.457752763, 3.908855931, 2, 2, 3)
TRAPEZOID = Claims(2.0, 4.888123763, 61.42597481, 8.089980982, 4.233239355, 2, 2, 3)

Blocks = Sequence[tuple[float, str]]
LEAST_BLOCK = 1e-9
"""share of the travel; nothing shorter can be told from a jump"""
NORTON = "R. L. Norton, Cam Design and Manufacturing Handbook, 2nd ed., Industrial Press 2009, chapter 3"
MAKINO = "H. Makino, Automatic Machine Mechanisms (in Japanese), Nikkan Kogyo 1976: the universal cam curve"


def _acceleration(x: float, width: float, shape: str) -> Piece:
    """One block of unit acceleration beginning at x."""
    w = 0.5 * math.pi / width
    power, waves = {
        "rise": ((0.0,), ((w, 0.0, 1.0),)),
        "hold": ((1.0,), ()),
        "fall": ((1.0,), ((w, 1.0, 0.0),)),
        "ramp-up": ((0.0, 1.0 / width), ()),
        "ramp-down": ((1.0, -1.0 / width), ()),
    }[shape]
    return Piece(x, x + width, x, power, waves)


def _half(blocks: Blocks, edges: Sequence[float]) -> list[Piece]:
    """Displacement pieces of one half from rest at x = 0, for unit acceleration height."""
    pieces, position, velocity = [], 0.0, 0.0
    for (_, shape), start, end in zip(blocks, edges[:-1], edges[1:], strict=True):
        speed = _acceleration(start, end - start, shape).between(start, end).integrated(velocity)
        pieces.append(speed.integrated(position))
        velocity, position = speed.value(end), pieces[-1].value(end)
    return pieces


def joined(first: Blocks, last: Blocks, cruise: float = 0.0) -> list[Piece]:
    """The law that accelerates by `first`, cruises, and decelerates by `last` (told backwards from the end).

    Blocks shorter than LEAST_BLOCK are left out and the half's last block takes up their room.
    """
    span = math.fsum([width for width, _ in first])
    first, last = ([block for block in blocks if block[0] > LEAST_BLOCK] for blocks in (first, last))
    cruise = cruise if cruise > LEAST_BLOCK else 0.0
    halves, speeds, lifts = [], [], []
    for blocks, total in ((first, span), (last, 1.0 - cruise - span)):
        edges = [math.fsum([width for width, _ in blocks[:k]]) for k in range(len(blocks))] + [total]
        half = _half(blocks, edges)
        halves.append(half)
        speeds.append(half[-1].value(total, 1))
        lifts.append(half[-1].value(total))
    height = 1.0 / (lifts[0] + speeds[0] / speeds[1] * lifts[1] + speeds[0] * cruise)
    start = [piece.scaled(height) for piece in halves[0]]
    end = [piece.scaled(height * speeds[0] / speeds[1]).mirrored() for piece in reversed(halves[1])]
    if cruise == 0.0:
        end[0] = end[0].between(span, end[0].end)
        return [*start, *end]
    steady = Piece(span, end[0].start, span, (height * lifts[0], height * speeds[0]))
    return [*start, steady, *end]


def _quarter_waves(rise: float, hold: float, fall: float) -> Blocks:
    return ((rise, "rise"), (hold, "hold"), (fall, "fall"))


@law(
    "parabolic",
    source=NORTON,
    claims=PARABOLA,
)
def parabolic() -> list[Piece]:
    """Constant acceleration, constant deceleration: the least peak acceleration, with three jumps of it."""
    return joined([(0.5, "hold")], [(0.5, "hold")])


@law(
    "modified-sine",
    source=NORTON,
    claims=SINE,
    cases=[({"share": 0.0}, HARMONIC), ({"share": 0.25}, CYCLOID)],
    share=Parameter(0.125, 0.0, 0.499, "share of the travel in each quarter-sine start (1/8: the standard curve)"),
)
def modified_sine(share: float) -> list[Piece]:
    """Quarter sine into a long cosine: low peak torque; the common choice for indexing."""
    blocks = _quarter_waves(share, 0.0, 0.5 - share)
    return joined(blocks, blocks)


@law(
    "modified-trapezoid",
    source=NORTON,
    claims=TRAPEZOID,
    cases=[({"share": 0.0}, PARABOLA), ({"share": 0.25}, CYCLOID)],
    share=Parameter(0.125, 0.0, 0.25, "share of the travel in each of four quarter waves (1/8: the standard curve)"),
)
def modified_trapezoid(share: float) -> list[Piece]:
    """Constant acceleration with quarter-sine flanks: low peak acceleration."""
    blocks = _quarter_waves(share, 0.5 - 2.0 * share, share)
    return joined(blocks, blocks)


@law(
    "trapezoidal-acceleration",
    source=NORTON,
    cases=[({"share": 0.0}, PARABOLA)],
    claims=Claims(2.0, 16 / 3, 128 / 3, 80 / 9, 4.354648432, 2, 2, 2),
    share=Parameter(0.125, 0.0, 0.25, "share of the travel in each of the four ramps of acceleration"),
)
def trapezoidal_acceleration(share: float) -> list[Piece]:
    """Constant acceleration with straight ramps: finite jerk in steps."""
    blocks = ((share, "ramp-up"), (0.5 - 2.0 * share, "hold"), (share, "ramp-down"))
    return joined(blocks, blocks)


@law(
    "modified-constant-velocity",
    source=MAKINO,
    claims=Claims(1.275258173, 8.012683415, 201.3806988, 5.733377092, 4.006341707, 2, 2, 2),
    cases=[
        ({"share": 0.0}, SINE),
        ({"share": 0.2}, Claims(1.527538676, 5.998630353, 94.22626524, 5.14136839, 3.793866951, 2, 2, 2)),
    ],
    share=Parameter(0.5, 0.0, 0.98, "share of the travel at constant velocity (0.5: the curve MCV50)"),
    rise=Parameter(0.25, 0.0, 0.99, "part of each accelerating zone in which the acceleration builds up"),
)
def modified_constant_velocity(share: float, rise: float) -> list[Piece]:
    """Modified-sine ends joined by a constant velocity: low pressure angle, gentle long travel."""
    zone = 0.5 * (1.0 - share)
    blocks = _quarter_waves(rise * zone, 0.0, (1.0 - rise) * zone)
    return joined(blocks, blocks, share)


@law(
    "trapezoidal-velocity",
    source=NORTON,
    claims=Claims(1.5, 4.5, math.inf, 6.75, 4.5 * math.sqrt(2 / 3), 1, 1, 1),
    cases=[({"share": 0.0}, PARABOLA)],
    share=Parameter(1 / 3, 0.0, 0.98, "share of the travel at constant velocity"),
)
def trapezoidal_velocity(share: float) -> list[Piece]:
    """Constant acceleration, constant velocity, constant deceleration: four jumps of acceleration."""
    zone = [(0.5 * (1.0 - share), "hold")]
    return joined(zone, zone, share)


@law(
    "scca",
    source=f"{NORTON}: sine-constant-cosine acceleration",
    claims=TRAPEZOID,
    cases=[
        ({"b": 0.25, "c": 0.0, "d": 0.75}, SINE),
        ({"b": 0.5, "c": 0.0, "d": 0.5}, CYCLOID),
        ({"b": 0.0, "c": 0.0, "d": 1.0}, HARMONIC),
        ({"b": 0.0, "c": 1.0, "d": 0.0}, PARABOLA),
    ],
    b=Parameter(0.25, 0.0, 1.0, "share of the two quarter-sine zones at the ends, together"),
    c=Parameter(0.5, 0.0, 1.0, "share of the two zones of constant acceleration, together"),
    d=Parameter(0.25, 0.0, 1.0, "share of the cosine zone in the middle; b + c + d = 1"),
)
def scca(b: float, c: float, d: float) -> list[Piece]:
    """Sine, constant, cosine: the family of modified trapezoid, modified sine, cycloid, harmonic and parabola."""
    if abs(b + c + d - 1.0) > 1e-9:
        raise ProfileError([Problem("d", "the shares b, c and d must add up to 1", b + c + d, "b + c + d = 1")])
    blocks = _quarter_waves(0.5 * b, 0.5 * c, 0.5 * d)
    return joined(blocks, blocks)


@law(
    "universal-asymmetric",
    source="C. N. Neklutin, Mechanisms and Cams for Automatic Machines, Elsevier 1969; Makino 1976",
    claims=Claims(2.0, 6.110154704, 95.97808564, 10.11247623, 4.320531825, 2, 2, 2),
    cases=[({"accelerate": 0.5}, TRAPEZOID), ({"accelerate": 0.5, "fall": 0.75}, SINE)],
    accelerate=Parameter(0.4, 0.01, 0.99, "share of the travel in which the follower speeds up"),
    cruise=Parameter(0.0, 0.0, 0.98, "share of the travel at constant velocity"),
    rise=Parameter(0.25, 0.0, 1.0, "part of each zone in which the acceleration builds up as a quarter sine"),
    fall=Parameter(0.25, 0.0, 1.0, "part of each zone in which it decays as a quarter cosine; rise + fall <= 1"),
)
def universal_asymmetric(accelerate: float, cruise: float, rise: float, fall: float) -> list[Piece]:
    """Different shares for speeding up and slowing down, each a trapezoid with quarter-wave flanks."""
    problems = []
    if rise + fall > 1.0 + 1e-12:
        problems.append(Problem("fall", "build-up and decay fill more than the zone", rise + fall, "rise + fall <= 1"))
    slow = 1.0 - accelerate - cruise
    if slow < 0.009:
        problems.append(Problem("cruise", "no travel is left to slow down", cruise, f"below {0.99 - accelerate:g}"))
    if problems:
        raise ProfileError(problems)
    hold = max(0.0, 1.0 - rise - fall)
    zones = [_quarter_waves(rise * zone, hold * zone, fall * zone) for zone in (accelerate, slow)]
    return joined(zones[0], zones[1], cruise)
