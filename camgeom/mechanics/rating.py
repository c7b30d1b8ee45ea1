"""Modified rating life of rolling bearings: L_nm = a1 a_ISO L_10 (ISO 281:2007), and the limits of track rollers.

Units N, mm, mm²/s; speeds r/min.
"""

from __future__ import annotations

from typing import final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.immutable import immutable
from camgeom.maths import Floats

RELIABILITY = {90: 1.0, 95: 0.64, 96: 0.55, 97: 0.47, 98: 0.37, 99: 0.25}
"""a1 by the reliability in % (ISO 281:2007, table 12); an older set, 0.62 to 0.21, is still about"""
LARGEST_FACTOR = 50.0
LEAST_RATIO, LARGEST_RATIO = 0.1, 4.0
"""of the viscosity: below the first a_ISO does not apply, above the second it counts as that"""
LEAST_LOAD_SHARE = 0.0167
"""of C0, the least load of a track roller (SKF, Rolling bearings: cam followers, loads)"""
BANDS = (0.4, 1.0)
"""viscosity ratios at which the formulas of a_ISO change"""
POWERS = (0.054381, 0.19087, 0.071739)


@final
@immutable(eq=True)
class Kind:
    """Constants of a_ISO of a radial bearing (ISO 281:2007, equations 31 to 36) and its load exponent."""

    exponent: float
    base: float
    shares: tuple[float, float, float]
    inner: float
    outer: float
    last: float


ROLLER = Kind(10.0 / 3.0, 1.5859, (1.3993, 1.2348, 1.2348), 1.0, 0.4, -9.185)
BALL = Kind(3.0, 2.5671, (2.2649, 1.9987, 1.9987), 0.83, 1.0 / 3.0, -9.3)
KINDS = {"roller": ROLLER, "ball": BALL}


@final
@immutable(eq=True)
class Lubrication:
    """What a_ISO takes: fatigue load limit C_u N, contamination factor e_C, pitch diameter D_pw mm, and viscosity nu,
    mm²/s, at the running temperature."""

    fatigue_limit: float
    contamination: float
    pitch_diameter: float
    viscosity: float


@final
@immutable(eq=True)
class Rating:
    """What is known of a roller's bearing: C and C0 N, its kind, a1, the static load its ring bears, its lubrication.

    static      the lower of C0 and the static load that the outer ring or the stud bears; None where C0 is not known
    basic       C0; bent: the largest load that bends the outer ring, N; fastest: its limiting speed, r/min; None where
                it is not known
    table       of the profile that says so; missing: what that leaves out of what a_ISO takes
    """

    dynamic: float
    static: float | None = None
    kind: Kind = ROLLER
    reliability: float = 1.0
    lubrication: Lubrication | None = None
    basic: float | None = None
    bent: float | None = None
    fastest: float | None = None
    table: str = "roller"
    missing: tuple[str, ...] = ()


def reference_viscosity(speed: ArrayLike, pitch_diameter: ArrayLike) -> Floats:
    """Viscosity nu1, mm²/s, that parts the surfaces: speed n r/min, pitch diameter D_pw mm (ISO 281:2007, 27 and 28).

    45000 n^-0.83 D_pw^-0.5 below 1000 r/min, 4500 n^-0.5 D_pw^-0.5 from there on; it jumps by 2.3 % there.
    """
    n, d = np.asarray(speed, dtype=np.float64), np.asarray(pitch_diameter, dtype=np.float64)
    return np.asarray(np.where(n < 1000.0, 45000.0 * n**-0.83, 4500.0 * n**-0.5) * d**-0.5)


def viscosity_ratio(viscosity: ArrayLike, speed: ArrayLike, pitch_diameter: ArrayLike) -> Floats:
    """kappa = nu / nu1."""
    return np.asarray(np.asarray(viscosity, dtype=np.float64) / reference_viscosity(speed, pitch_diameter))


def life_factor(kind: Kind, ratio: ArrayLike, share: ArrayLike) -> Floats:
    """a_ISO of a viscosity ratio kappa and of e_C C_u / P; 0 where kappa is below its range, so that nothing holds.

    0.1 [1 - (base - share_k / kappa^power_k)^inner (e_C C_u / P)^outer]^last, at most 50; a bracket that is not
    positive means 50. Some print 0.019087 as the middle power: that breaks the continuity at 0.4.
    """
    kappa, x = np.broadcast_arrays(np.asarray(ratio, dtype=np.float64), np.asarray(share, dtype=np.float64))
    bounded = np.clip(kappa, LEAST_RATIO, LARGEST_RATIO)
    band = np.searchsorted(BANDS, bounded, side="right")
    part = kind.base - np.array(kind.shares)[band] / bounded ** np.array(POWERS)[band]
    bracket = 1.0 - np.maximum(part, 0.0) ** kind.inner * x**kind.outer
    # Where the bracket reaches this, the factor is 50.
    least = (LARGEST_FACTOR / 0.1) ** (1.0 / kind.last)
    factor = 0.1 * np.maximum(bracket, least) ** kind.last
    return np.asarray(np.where(kappa < LEAST_RATIO, 0.0, np.minimum(factor, LARGEST_FACTOR)))
