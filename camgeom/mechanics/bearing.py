"""The roller as a bearing, its stud, and the camshaft: rated life, static safety, bending and torsion.

Units N, mm, MPa, N mm, rad, s.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, final

import numpy as np
from numpy.typing import ArrayLike

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import TURN, Panels, highest

if TYPE_CHECKING:
    from camgeom.mechanics.rating import Rating

ROLLER_EXPONENT = 10.0 / 3.0
"""Load exponent of roller bearings, line contact (ISO 281); 3 for ball bearings."""
MILLION = 1e6


@final
@immutable
class BearingLife:
    """Rated life of a roller bearing over a load spectrum; each field (...).

    life_h: L10 hours, infinite without load; mean_load: equivalent load, N; speed: mean roller speed, rad/s;
    static_safety: static rating over the largest load, infinite without load; None where no static rating is known;
    rated_h: L_n or L_nm hours at the reliability asked for, 0 where a_ISO does not apply (see `modified`);
    ratio, factor: kappa and a_ISO; None where nothing is known of the lubrication or nothing is loaded; peak_speed: the
    largest, rad/s.
    """

    life_h: Floats
    mean_load: Floats
    speed: Floats
    static_safety: Floats | None
    rated_h: Floats | None = None
    ratio: Floats | None = None
    factor: Floats | None = None
    peak_speed: Floats | None = None

    @property
    def judged_h(self) -> float:
        """The life that is judged, h: the rated one, where none was asked for L10."""
        return float(self.life_h if self.rated_h is None else self.rated_h)


def modified(life: BearingLife, rating: Rating) -> BearingLife:
    """A basic life with a1, and with a_ISO where the lubrication is known (ISO 281:2007, equation 23).

    What nothing loads has neither kappa nor a_ISO: no life of it hangs on its lubrication.
    """
    from camgeom.mechanics.rating import life_factor, viscosity_ratio

    known = rating.lubrication
    if known is None:
        return replace(life, rated_h=np.asarray(rating.reliability * life.life_h))
    loaded = (life.mean_load > 0.0) & (life.speed > 0.0)
    if not loaded.any():
        return replace(life, rated_h=np.full(loaded.shape, np.inf))
    turning = np.where(loaded, life.speed, 1.0) * 60.0 / TURN
    ratio = viscosity_ratio(known.viscosity, turning, known.pitch_diameter)
    share = known.contamination * known.fatigue_limit / np.where(loaded, life.mean_load, 1.0)
    factor = life_factor(rating.kind, ratio, share)
    rated = np.where(loaded, rating.reliability * factor * np.where(loaded, life.life_h, 1.0), np.inf)
    return replace(life, rated_h=np.asarray(rated), ratio=ratio, factor=factor)


def bearing_life(where: Panels, normal: Floats, path_rate: Floats, roller_radius: ArrayLike, speed: ArrayLike,
                 rating: ArrayLike, static_rating: ArrayLike | None = None,
                 exponent: float = ROLLER_EXPONENT) -> BearingLife:
    """L10 life of a cam follower from its normal force (N) and path rate (mm/rad), both (..., p, n), over a cam turn.

    Radius mm, cam speed rad/s, ratings C and C0 in N: numbers or (...). Each load counts by the roller turns made under
    it: P = (integral |Fn|^p |dturns| / integral |dturns|)^(1/p), L10 = (C/P)^p million turns (ISO 281).
    """
    mean = mean_load(where, normal, path_rate, exponent)
    travel = where.integral(np.abs(path_rate))
    radius, cam = np.asarray(roller_radius, dtype=np.float64), np.asarray(speed, dtype=np.float64)
    roller_speed = cam * travel / (TURN * radius)
    largest = np.maximum(highest(where, normal)[0], highest(where, -normal)[0])
    safety = static_safety(static_rating, largest) if static_rating is not None else None
    fastest = cam * np.abs(path_rate).max(axis=(-1, -2)) / radius
    return BearingLife(rated_hours(rating, mean, roller_speed, exponent), mean, np.asarray(roller_speed), safety,
                       peak_speed=np.asarray(fastest))


def static_safety(rating: ArrayLike | None, largest: Floats) -> Floats | None:
    """Static rating C0 over the largest load, N, (...); infinite without load, None without a rating."""
    if rating is None:
        return None
    c0 = np.asarray(rating, dtype=np.float64)
    lead = np.broadcast_shapes(c0.shape, largest.shape)
    return np.asarray(np.divide(np.broadcast_to(c0, lead), largest, out=np.full(lead, np.inf), where=largest > 0.0))


def mean_load(where: Panels, normal: Floats, path_rate: Floats, exponent: float = ROLLER_EXPONENT) -> Floats:
    """Equivalent constant load, N, of a load spectrum over one cam turn, weighted by roller travel: shape (...)."""
    force, rate = np.abs(normal), np.abs(path_rate)
    largest = force.max(axis=(-1, -2), keepdims=True)
    scaled = np.divide(force, largest, out=np.zeros_like(force), where=largest > 0.0)
    share = where.integral(scaled**exponent * rate) / where.integral(np.broadcast_to(rate, scaled.shape))
    return np.asarray(largest[..., 0, 0] * np.maximum(share, 0.0) ** (1.0 / exponent))


def rated_hours(rating: ArrayLike, load: ArrayLike, roller_speed: ArrayLike,
                exponent: float = ROLLER_EXPONENT) -> Floats:
    """L10 life in hours from the dynamic rating C (N), equivalent load (N) and roller speed (rad/s)."""
    c, p, omega = np.broadcast_arrays(*(np.asarray(x, dtype=np.float64) for x in (rating, load, roller_speed)))
    per_hour = omega / TURN * 3600.0 / MILLION
    loaded = (p > 0.0) & (per_hour > 0.0)
    turns = np.divide(c, p, out=np.ones(c.shape), where=loaded) ** exponent
    return np.asarray(np.divide(turns, per_hour, out=np.full(c.shape, np.inf), where=loaded))


def required_rating(load: ArrayLike, life_h: ArrayLike, roller_speed: ArrayLike,
                    exponent: float = ROLLER_EXPONENT) -> Floats:
    """Dynamic rating C, N, that a bearing needs for a life in hours: F (60 L n / 10^6)^(1/p), roller speed in rad/s.

    The inverse of F = C (10^6 / (60 L_h n))^(3/10) (T/WLJC 15-2018, equation 37), n in r/min.
    """
    turns = np.asarray(life_h, dtype=np.float64) * np.asarray(roller_speed, dtype=np.float64) / TURN * 3600.0
    return np.asarray(np.asarray(load, dtype=np.float64) * (turns / MILLION) ** (1.0 / exponent))


def borne_load(bearing: BearingLife, rating: Rating, life_h: float) -> float | None:
    """Equivalent load, N, that a bearing bears for a life in hours at its mean speed and reliability (equation 37).

    None where it does not turn, and with a_ISO, which changes with the load.
    """
    if rating.lubrication is not None or not float(bearing.speed) > 0.0:
        return None
    needed = required_rating(1.0, life_h / rating.reliability, bearing.speed, rating.kind.exponent)
    return rating.dynamic / float(needed)


@final
@immutable
class RoundStress:
    """Stresses in a round section, MPa: bending, and shear (the mean in a stud, that of torsion in a shaft)."""

    bending: Floats
    shear: Floats

    @cached_property
    def mises(self) -> Floats:
        """Both combined after von Mises, MPa."""
        return np.asarray(np.hypot(self.bending, np.sqrt(3.0) * self.shear))


def stud_stress(force: ArrayLike, arm: ArrayLike, diameter: ArrayLike) -> RoundStress:
    """Stress in a roller stud, MPa: force N at a distance `arm` mm from the clamped end, solid round section, mm.

    Bending 32 F a / (pi d³); shear 4 F / (pi d²), the mean: its peak is at the neutral fibre, where bending vanishes.
    """
    load, lever, d = (np.asarray(x, dtype=np.float64) for x in (force, arm, diameter))
    bending = 32.0 * np.abs(load) * lever / (np.pi * d**3)
    shear = 4.0 * np.abs(load) / (np.pi * d**2)
    return RoundStress(np.asarray(bending), np.asarray(shear))


def shaft_stress(moment: ArrayLike, torque: ArrayLike, diameter: ArrayLike, bore: ArrayLike = 0.0) -> RoundStress:
    """Stress in a round or hollow shaft, MPa: 32 M / (pi d³ (1 - q⁴)), 16 T / (pi d³ (1 - q⁴)), q = bore / diameter.

    Moment and torque in N mm, diameters in mm. Raises ValueError where the bore is not smaller than the diameter.
    """
    m, t, d, b = (np.asarray(x, dtype=np.float64) for x in (moment, torque, diameter, bore))
    if np.any(b >= d) or np.any(b < 0.0):
        raise ValueError("a shaft's bore must be smaller than its diameter")
    section = np.pi * d**3 * (1.0 - (b / d) ** 4)
    return RoundStress(np.asarray(32.0 * np.abs(m) / section), np.asarray(16.0 * np.abs(t) / section))


def span_moment(force: ArrayLike, left: ArrayLike, right: ArrayLike) -> Floats:
    """Bending moment, N mm, under a force (N) at left and right (mm) from the two bearings: F a b / (a + b)."""
    f, a, b = (np.asarray(x, dtype=np.float64) for x in (force, left, right))
    return np.asarray(np.abs(f) * a * b / (a + b))
