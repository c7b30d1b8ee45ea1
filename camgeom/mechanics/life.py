"""Rolling contact fatigue of the roller and of the cam: Miner's sum over the contacts of every surface point.

The roller rolls along the groove and its circumference meets the two walls in turn. Point theta of it (rad, in the
sense of rolling) is at the wall behind at the path l = theta r, half a turn later at the wall ahead, and so on; the
j-th contact is at l = theta r + (j - 1) pi r, stressed only where that wall is loaded. Damage of one cam turn:

    Q(theta) = sum over contacts of (p0 / contact_limit)^exponent / contact_cycles,     life = 1 / (60 n max Q) hours

(doi 10.13705/j.issn.1671-6833.2023.01.017). Q is continuous but for jumps of the load; its maximum is bracketed between
all images of those jumps and refined on the derivative.

The published count lets the roller turn one way and start every cam turn alike. In truth its spin reverses with the
loaded wall and the remainder of a turn is carried on, so its points change places: the hot spot's life is the cautious
estimate, the life at the mean damage (`spread_life_h`) what all points sharing alike would give, the most there can be.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camgeom.maths import Floats
from camgeom.mechanics.contact import Contact
from camgeom.mechanics.material import Material
from camgeom.mechanics.panels import POINTS, TURN, bracketed_root, chebyshev, evaluate
from camgeom.mechanics.rolling import Count, Rolling, check_strength

Ints = NDArray[np.intp]
FINE = 32
"""Points a panel at which damage is tabled for the first search, and roller angles that fall into a panel"""
FEWEST = 64
"""Least number of roller angles in the first search"""
KEEP = 0.9
"""Local maxima of the first search within this share of the largest are refined; its error is below a third of that"""
ANGLE_TOLERANCE = 1e-12
"""rad; the hot spot's angle, at which the damage itself has long settled"""
CHUNK = 400_000
"""Table look-ups done at once: a few megabytes"""


@final
@dataclass(frozen=True, eq=False)
class RollerLife:
    """Fatigue of a roller's circumference; every field has the shape of the variants (...).

    life_h: hours at the hot spot, infinite without load, 0 where the contact is not sound; damage: Miner's sum of one
    cam turn there; hot_spot: its roller angle, rad; mean_damage: average over the circumference; spread_life_h: hours
    if the roller starts every cam turn at another angle, so that all points share the damage;
    path: mm rolled in a cam turn.
    """

    life_h: Floats
    damage: Floats
    hot_spot: Floats
    mean_damage: Floats
    spread_life_h: Floats
    path: Floats


@final
@dataclass(frozen=True, eq=False)
class CamLife:
    """Fatigue of the cam's walls: life in hours, damage of one turn, cam angle (rad) and wall (1 behind, -1 ahead)."""

    life_h: Floats
    damage: Floats
    theta: Floats
    wall: NDArray[np.intp]


def cam_life(contact: Contact, material: Material, speed: ArrayLike, passes: float = 1.0) -> CamLife:
    """Life of the cam surface: a wall point is met once per cam turn and roller (`passes`); speed rad/s, (...)."""
    peak = contact.peak()
    check_strength(peak.pressure, material)
    damage = passes * (peak.pressure / material.contact_limit) ** material.exponent / material.contact_cycles
    return CamLife(hours(damage, speed), np.asarray(damage), peak.theta, peak.wall)


def hours(damage: ArrayLike, speed: ArrayLike) -> Floats:
    """Life in hours from the damage of one cam turn and the cam speed in rad/s; infinite without damage."""
    each = np.asarray(damage, dtype=np.float64) * np.asarray(speed, dtype=np.float64) / TURN * 3600.0
    return np.asarray(np.divide(1.0, each, out=np.full(each.shape, np.inf), where=each > 0.0))


def roller_life(contact: Contact, material: Material, roller_radius: ArrayLike, speed: ArrayLike,
                count: Count = "from-behind") -> RollerLife:
    """Fatigue life of the roller surface; roller radius mm and cam speed rad/s, numbers or (...) as the contact.

    Raises NotConverged where a roller point has more than MAX_CONTACTS contacts in one cam turn.
    """
    lead = contact.behind.shape[:-2]
    radius = np.broadcast_to(np.asarray(roller_radius, dtype=np.float64), lead).reshape(-1)
    rolling = Rolling.of(contact, material, radius, count)
    damage, spot = _hot_spots(rolling)
    mean = rolling.mean()
    sound = contact.sound.reshape(-1)
    damage, mean = np.where(sound, damage, np.inf), np.where(sound, mean, np.inf)
    shaped = [x.reshape(lead) for x in (damage, spot, mean, rolling.path)]
    return RollerLife(hours(shaped[0], speed), shaped[0], shaped[1], shaped[2], hours(shaped[2], speed), shaped[3])


def damage_profile(contact: Contact, material: Material, roller_radius: float, theta: ArrayLike,
                   count: Count = "from-behind") -> Floats:
    """Damage of one cam turn at roller angles theta (q,), rad, of a single contact (no variants): (q,)."""
    rolling = Rolling.of(contact, material, np.array([float(roller_radius)]), count)
    angle = np.atleast_1d(np.asarray(theta, dtype=np.float64))
    return rolling.damage(np.zeros(angle.size, dtype=np.intp), angle, angle)[0]


@final
@dataclass(frozen=True, eq=False)
class RollerContacts:
    """The contacts of one roller point in one cam turn: cam angles rad, walls (1 behind, -1 ahead), pressures MPa."""

    theta: Floats
    wall: NDArray[np.intp]
    pressure: Floats


def roller_contacts(contact: Contact, material: Material, roller_radius: float, spot: float,
                    count: Count = "from-behind") -> RollerContacts:
    """Every contact that the roller point at angle `spot` (rad) has in one cam turn, loaded or not (no variants)."""
    rolling = Rolling.of(contact, material, np.array([float(roller_radius)]), count)
    at = np.array([float(spot)])
    path, wall, _ = rolling.contacts(np.zeros(1, dtype=np.intp), at, at)
    panel = np.clip(np.searchsorted(rolling.edges[0], path, side="right") - 1, 0, rolling.edges.shape[1] - 2)
    x = rolling.solve(np.zeros(path.size, dtype=np.intp), panel, path)
    square = evaluate(rolling.squares[wall, 0, panel], x) * material.contact_limit**2
    where = contact.panels
    return RollerContacts(where.middle[panel] + where.half[panel] * x, 1 - 2 * wall,
                          np.asarray(np.sqrt(np.maximum(square, 0.0))))


def _hot_spots(rolling: Rolling) -> tuple[Floats, Floats]:
    """Largest damage and its roller angle, (V,) each."""
    total = len(rolling.radius)
    brackets = [_candidates(rolling, chunk) for chunk in _chunks(rolling)]
    within = _Brackets(*(np.concatenate([getattr(one, key.name) for one in brackets]) for key in fields(_Brackets)))
    variant = within.variant
    value, angle = _refined(rolling, within)
    damage, spot = np.zeros(total), np.zeros(total)
    order = np.lexsort((-value, variant))
    owners, first = np.unique(variant[order], return_index=True)
    damage[owners], spot[owners] = value[order][first], angle[order][first]
    return damage, np.mod(spot, TURN)


def _chunks(rolling: Rolling) -> list[Ints]:
    """Variants in groups whose first search needs about CHUNK look-ups."""
    count = len(rolling.radius)
    size = max(1, CHUNK // (4 * FINE * rolling.edges.shape[1]))
    return [np.arange(start, min(start + size, count)) for start in range(0, count, size)]


def _images(rolling: Rolling, chunk: Ints) -> Floats:
    """Roller angles, (C, e) sorted in [0, 2 pi], where a contact passes a jump: Q is smooth between two of them."""
    turned = rolling.edges[chunk][:, rolling.panels.break_edges] / rolling.radius[chunk, None]
    both = np.mod(np.concatenate([turned, turned - np.pi], axis=1), TURN)
    ends = np.zeros((len(chunk), 1))
    return np.sort(np.concatenate([both, ends, ends + TURN], axis=1), axis=1)


@final
@dataclass(frozen=True, eq=False)
class _Brackets:
    """Ranges of roller angle, rad, that may hold the maximum, and the smooth ranges they lie in; (T,) each."""

    variant: Ints
    low: Floats
    high: Floats
    begin: Floats
    end: Floats

    @property
    def middle(self) -> Floats:
        return 0.5 * (self.begin + self.end)


def _candidates(rolling: Rolling, chunk: Ints) -> _Brackets:
    """Brackets about the local maxima of the first search that may turn out to be the largest."""
    images = _images(rolling, chunk)
    low, width = images[:, :-1], np.diff(images, axis=1)
    # Steps such that FINE of them fall into a panel of mean length; a range with contacts is no longer than the path.
    turns = np.minimum(width * (rolling.radius[chunk] / rolling.path[chunk])[:, None], 1.0)
    per = int(np.ceil(max(FEWEST / width.shape[1], FINE * rolling.edges.shape[1] * float(turns.max())))) + 2
    share = np.linspace(0.0, 1.0, per + 1)
    inner = np.clip(share, 1e-7, 1.0 - 1e-7)
    theta = low[..., None] + width[..., None] * inner
    value = _table(rolling, chunk, theta)
    value[width < 1e-9] = 0.0
    padded = np.pad(value, ((0, 0), (0, 0), (1, 1)), constant_values=-1.0)
    peak = (value >= padded[..., :-2]) & (value >= padded[..., 2:])
    keep = peak & (value >= KEEP * value.max(axis=(1, 2), keepdims=True))
    c, e, i = np.nonzero(keep)
    # A plateau (no load at all, or constant damage) needs one candidate, not all of its points.
    plateau = (i > 0) & (value[c, e, i] == value[c, e, np.maximum(i - 1, 0)])
    c, e, i = c[~plateau], e[~plateau], i[~plateau]
    left = low[c, e] + width[c, e] * share[np.maximum(i - 1, 0)]
    right = low[c, e] + width[c, e] * share[np.minimum(i + 1, per)]
    return _Brackets(chunk[c], left, right, low[c, e], images[:, 1:][c, e])


def _table(rolling: Rolling, chunk: Ints, theta: Floats) -> Floats:
    """Damage at roller angles (C, e, q) by linear interpolation in a table of damage over path: the first search."""
    grid = np.linspace(-1.0, 1.0, FINE)
    walls = (np.maximum(rolling.squares[:, chunk] @ chebyshev(grid, POINTS - 1), 0.0)) ** rolling.power
    path = rolling.inside[chunk] @ chebyshev(grid, POINTS)
    offset = 2.0 * np.arange(len(chunk))
    size = rolling.path[chunk]
    known = np.maximum.accumulate((path / size[:, None, None] + offset[:, None, None]).ravel())
    step = rolling.radius[chunk] / size
    at = theta * step[:, None, None]
    value = np.zeros(theta.shape)
    for j in range(rolling.first, int(np.ceil(np.max(1.0 / step) / np.pi)) + 1):
        place = at + (np.pi * j * step)[:, None, None]
        there = (place >= 0.0) & (place <= 1.0)
        if there.any():
            shifted = (place + offset[:, None, None])[there]
            value[there] += np.interp(shifted, known, walls[j % 2].ravel())
    return value / rolling.cycles


def _refined(rolling: Rolling, within: _Brackets) -> tuple[Floats, Floats]:
    """Maximum of the damage near each bracket and its roller angle: a root of the derivative, or an end."""
    variant, middle = within.variant, within.middle
    ends = _climbed(rolling, within)
    value = np.maximum(ends.low_value, ends.high_value)
    angle = np.where(ends.low_value >= ends.high_value, ends.low, ends.high)
    # Between the ends a concave maximum stays below what the steeper tangent reaches half way: most brackets drop out.
    most = value + 0.5 * (ends.high - ends.low) * np.maximum(ends.low_slope, -ends.high_slope)
    best = np.zeros(len(rolling.radius))
    np.maximum.at(best, variant, value)
    inner = (ends.low_slope > 0.0) & (ends.high_slope < 0.0) & (most >= best[variant])
    if inner.any():
        v, m = variant[inner], middle[inner]
        low, high = ends.low[inner], ends.high[inner]
        root = bracketed_root(lambda at: rolling.damage(v, at, m)[1], low, high, ANGLE_TOLERANCE)
        found = rolling.damage(v, root, m)[0]
        better = found >= value[inner]
        value[inner] = np.where(better, found, value[inner])
        angle[inner] = np.where(better, root, angle[inner])
    return value, angle


@final
@dataclass(frozen=True, eq=False)
class _Ends:
    """Both ends of every bracket: roller angle, damage and its derivative, (T,) each."""

    low: Floats
    high: Floats
    low_value: Floats
    high_value: Floats
    low_slope: Floats
    high_slope: Floats


def _climbed(rolling: Rolling, within: _Brackets) -> _Ends:
    """Ends of the brackets moved uphill, by doubling steps, until the maximum lies between or the range ends.

    The table's error may show a flat maximum some steps away from where it is.
    """
    variant, middle = within.variant, within.middle
    low, high = within.low.copy(), within.high.copy()
    low_value, low_slope = rolling.damage(variant, low, middle)
    high_value, high_slope = rolling.damage(variant, high, middle)
    for _ in range(64):
        down, up = (low_slope < 0.0) & (low > within.begin), (high_slope > 0.0) & (high < within.end)
        if not (down.any() or up.any()):
            break
        wide = high - low
        low[down] = np.maximum(low - wide, within.begin)[down]
        high[up] = np.minimum(high + wide, within.end)[up]
        low_value[down], low_slope[down] = rolling.damage(variant[down], low[down], middle[down])
        high_value[up], high_slope[up] = rolling.damage(variant[up], high[up], middle[up])
    return _Ends(low, high, low_value, high_value, low_slope, high_slope)
