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

from collections.abc import Iterable
from dataclasses import fields
from typing import Literal, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct, gauss_rule
from camgeom.maths.extremum import bracketed_root
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import DERIVATIVE, POINTS, TURN, Panels, chebyshev, evaluate
from camgeom.mechanics.contact import Contact
from camgeom.mechanics.material import Material

Ints = NDArray[np.intp]
Count = Literal["from-behind", "both"]
"""from-behind: contacts counted from the first on the wall behind, as published; both: with the contact on the wall
ahead that points past half a turn have before it."""
FINE = 32
"""Points a panel at which damage is tabled for the first search, and roller angles that fall into a panel"""
FEWEST = 64
"""Least number of roller angles in the first search"""
NOTHING = 1e-9
"""rad; a range of roller angles between two jumps that holds none"""
KEEP = 0.9
"""Local maxima of the first search within this share of the largest are refined; its error is below a third of that"""
ANGLE_TOLERANCE = 1e-12
"""rad; the hot spot's angle, at which the damage itself has long settled"""
CHUNK = 400_000
"""Table look-ups done at once: a few megabytes"""
MOST_DAMAGE = 250.0
"""Power of ten of the relative damage beyond which doubles could overflow"""
BATCH = 100_000
"""Contacts evaluated at once: some tens of megabytes"""
MOST_STEPS, STILL = 60, 1e-200
"""steps of Newton's method from a path to its place in a panel, few but where the roller stands: below that rate, mm"""
MAX_CONTACTS = 4000
"""Contacts of one roller point in one cam turn up to which they are summed one by one"""


@final
@immutable
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
@immutable
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


def summed_life(lives: Iterable[tuple[float, float]]) -> float:
    """Life in hours of running from the (weight, life in hours) of every operating state: 1 / sum(weight / life).

    Miner's rule; weights are shares of the running time. 0 where a state has no life, infinite without any damage.
    """
    pairs = [(weight, life) for weight, life in lives if weight > 0.0]
    if any(life <= 0.0 for _, life in pairs):
        return 0.0
    damage = sum(weight / life for weight, life in pairs)
    return 1.0 / damage if damage > 0.0 else float("inf")


def swept_damage(place: Floats, damage: Floats) -> float:
    """Largest damage of a turn on a face over which the contact sweeps to and fro.

    place (n,): of the contact on the face, mm, round the turn; damage (n,): of one contact there. In every stroke from
    one turning point to the next a point of the face is pressed once, at a turning point by both strokes; a contact
    that rests belongs to the stroke that brings it.
    """
    step = 1e-6 * float(np.ptp(place))
    if step == 0.0:
        return float(damage.max(initial=0.0))
    where = np.round(place / step).astype(np.int64)
    way = np.sign(np.diff(where, append=where[:1]))
    moving = np.flatnonzero(way)
    way = way[moving][np.searchsorted(moving, np.arange(len(way)), side="right") - 1]
    first = int(np.flatnonzero(way != np.roll(way, 1))[0])
    where, way, damage = np.roll(where, -first), np.roll(way, -first), np.roll(damage, -first)
    begins = np.flatnonzero(np.diff(way, prepend=way[-1]))
    points, total = distinct(where), np.zeros(1)
    for begin, end in zip(begins, [*begins[1:], len(way)]):
        stroke = np.arange(begin, end + 1) % len(way)
        reached, which = np.unique(where[stroke], return_inverse=True)
        most = np.zeros(len(reached))
        np.maximum.at(most, which, damage[stroke])
        total = total + np.interp(points, reached, most, left=0.0, right=0.0)
    return float(total.max())


def check_strength(pressure: Floats, material: Material) -> None:
    """Raises DesignError where the pressure, MPa, is so far above the contact limit that no damage can be computed."""
    share = float(np.max(pressure, initial=0.0, where=np.isfinite(pressure))) / material.contact_limit
    if share > 1.0 and material.exponent * np.log10(share) > MOST_DAMAGE:
        limit = f"{material.contact_limit:.6g} MPa"
        raise DesignError(f"the peak pressure is {share:.3g} times the contact limit of {limit}: "
                          "there is no fatigue life to speak of; check force, length and units")


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
@immutable
class Rolling:
    """A roller rolling along its two walls: which point of it meets which wall, where, and with what damage.

    Path and squared relative stress of V variants as Chebyshev series on P panels. Vectorised over the variants and
    over tasks, a task being a variant and an angle on its roller.
    """


    panels: Panels
    radius: Floats
    edges: Floats
    """(V, P + 1) path at panel edges, mm"""
    inside: Floats
    """(V, P, n + 1) series of the path"""
    rates: Floats
    """(V, P, n) series of d path / dx"""
    squares: Floats
    """(2, V, P, n) series of (p0 / limit)², signed; wall behind, wall ahead"""
    loaded: NDArray[np.bool_]
    """(2, V, P) whether the wall is loaded anywhere in the panel"""
    laid: Floats
    """(V (P + 1),) the variants' panel edges laid end to end, each scaled to a length of 1 in a space of 2"""
    power: float
    cycles: float
    first: int

    @classmethod
    def of(cls, contact: Contact, material: Material, radius: Floats, count: Count) -> Rolling:
        """The rolling of every variant of a contact, radius (V,) in mm."""
        where = contact.panels
        rate = contact.path_rate.reshape(-1, *contact.path_rate.shape[-2:])
        edges, inside = where.running(rate)
        check_strength(contact.pressure, material)
        # A roller that bears on the wall ahead alone has its contacts counted from the first on that one.
        pair = (contact.behind, contact.ahead) if contact.behind.any() else (contact.ahead, contact.behind)
        walls = np.stack(pair).reshape(2, *rate.shape) / material.contact_limit**2
        most = float(np.max(edges[:, -1] / (np.pi * radius)))
        if most > MAX_CONTACTS:
            raise NotConverged(f"a roller point meets the walls {most:.3g} times in one cam turn, more than "
                               f"{MAX_CONTACTS}: use a larger roller, or the mean over the circumference")
        squares = where.coefficients(walls)
        dense = squares @ chebyshev(np.linspace(-1.0, 1.0, 2 * POINTS + 1), POINTS - 1)
        laid = edges / edges[:, -1:] + 2.0 * np.arange(len(edges))[:, None]
        return cls(where, radius, edges, inside, where.coefficients(rate) * where.half[:, None], squares,
                   np.asarray((dense > 0.0).any(axis=-1)), laid.ravel(), 0.5 * material.exponent,
                   material.contact_cycles, -1 if count == "both" else 0)

    @cached_property
    def path(self) -> Floats:
        """Path rolled in one cam turn, mm, (V,)."""
        return np.asarray(self.edges[:, -1])

    def mean(self) -> Floats:
        """Damage averaged over the circumference: the damage per path integrated over the path, over 2 pi r."""
        grid, weights = gauss_rule(2 * POINTS)
        basis = chebyshev(grid, POINTS - 1)
        damage = (np.maximum(self.squares @ basis, 0.0) ** self.power).sum(axis=0) / self.cycles
        each = (damage * (self.rates @ basis)) @ weights
        return np.asarray(each.sum(axis=-1) / (TURN * self.radius))

    def contacts(self, variant: Ints, theta: Floats, middle: Floats) -> tuple[Floats, Ints, Ints]:
        """Path, wall and task, (N,) each, of every contact of the tasks; `middle` decides which exist."""
        most = int(np.ceil(np.max(self.path[variant] / self.radius[variant]) / np.pi)) + 1
        step = np.arange(self.first, most)
        reach = np.pi * self.radius[variant, None] * step
        r = self.radius[variant, None]
        there = middle[:, None] * r + reach
        task, which = np.nonzero((there >= 0.0) & (there <= self.path[variant, None]))
        path = np.clip((theta[:, None] * r + reach)[task, which], 0.0, self.path[variant][task])
        return path, np.asarray(step[which] % 2, dtype=np.intp), np.asarray(task, dtype=np.intp)

    def locate(self, variant: Ints, path: Floats) -> Ints:
        """Panel that holds the path, right-hand one at an edge."""
        wanted = path / self.path[variant] + 2.0 * variant
        panel = np.searchsorted(self.laid, wanted, side="right") - 1 - variant * self.edges.shape[1]
        return np.asarray(np.clip(panel, 0, self.edges.shape[1] - 2), dtype=np.intp)

    def solve(self, variant: Ints, panel: Ints, path: Floats) -> Floats:
        """Position in its panel, x in [-1, 1], at which the path is reached: Newton on a monotone series.

        From a place where the roller stands, an end of the way of what goes to and fro, half of the way inwards.
        """
        series, rate = self.inside[variant, panel], self.rates[variant, panel]
        lo, hi = self.edges[variant, panel], self.edges[variant, panel + 1]
        x = np.clip(2.0 * (path - lo) / np.maximum(hi - lo, 1e-300) - 1.0, -1.0, 1.0)
        for _ in range(MOST_STEPS):
            off, slope = evaluate(series, x) - path, evaluate(rate, x)
            move = np.divide(off, slope, out=np.where(off == 0.0, 0.0, 0.5 * x), where=slope > STILL)
            x = np.clip(x - move, -1.0, 1.0)
            if np.all(np.abs(move) < 1e-13) or np.all(np.abs(np.clip(x - move, -1.0, 1.0) - x) < 1e-13):
                break
        return x

    def damage(self, variant: Ints, theta: Floats, middle: Floats) -> tuple[Floats, Floats]:
        """Damage Q of the tasks and its derivative by the roller angle, (T,) each.

        Each contact stays in the piece (range between jumps) in which it is for the roller angle `middle`, so that at
        the end of such a range the one-sided limit is given.
        """
        most = 1.0 + float(np.max(self.path / self.radius)) / np.pi
        size = max(1, int(BATCH / most))
        parts = [self._batch(variant[k : k + size], theta[k : k + size], middle[k : k + size])
                 for k in range(0, theta.size, size)]
        value, slope = zip(*parts) if parts else ((np.zeros(0),), (np.zeros(0),))
        return np.concatenate(value), np.concatenate(slope)

    def _batch(self, variant: Ints, theta: Floats, middle: Floats) -> tuple[Floats, Floats]:
        path, wall, task = self.contacts(variant, theta, middle)
        owner = variant[task]
        path, panel = self._kept(owner, path, path + (middle - theta)[task] * self.radius[owner])
        live = self.loaded[wall, owner, panel]
        path, wall, task, owner, panel = path[live], wall[live], task[live], owner[live], panel[live]
        x = self.solve(owner, panel, path)
        series = self.squares[wall, owner, panel]
        square = np.maximum(evaluate(series, x), 0.0)
        rate, bend = evaluate(self.rates[owner, panel], x), evaluate(series @ DERIVATIVE.T, x)
        steep = np.divide(bend, rate, out=np.zeros_like(rate), where=rate > STILL) * self.radius[owner]
        each = square**self.power
        slope = self.power * steep * np.divide(each, square, out=np.zeros_like(square), where=square > 0.0)
        total = np.bincount(task, each, minlength=theta.size) / self.cycles
        return total, np.bincount(task, slope, minlength=theta.size) / self.cycles

    def _kept(self, owner: Ints, path: Floats, middle: Floats) -> tuple[Floats, Ints]:
        """Path and panel held within the piece that contains the path `middle`."""
        ends = self.panels.break_edges
        piece = self.panels.piece[self.locate(owner, np.clip(middle, 0.0, self.path[owner]))]
        first, last = ends[piece], ends[piece + 1]
        held = np.clip(path, self.edges[owner, first], self.edges[owner, last])
        return held, np.asarray(np.clip(self.locate(owner, held), first, last - 1), dtype=np.intp)


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
@immutable
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
    owner, which = np.nonzero(np.diff(images, axis=1) >= NOTHING)
    low, high = images[owner, which], images[owner, which + 1]
    width = high - low
    # Steps such that FINE of them fall into a panel of mean length; a range with contacts is no longer than the path.
    turns = np.minimum(width * (rolling.radius[chunk] / rolling.path[chunk])[owner], 1.0)
    panels = FINE * rolling.edges.shape[1]
    steps = np.ceil(np.maximum(FEWEST / (images.shape[1] - 1), panels * turns)).astype(np.intp) + 2
    first = np.cumsum(steps + 1) - (steps + 1)
    of = np.repeat(np.arange(len(low)), steps + 1)
    i = np.arange(len(of)) - first[of]
    theta = low[of] + width[of] * np.clip(i / steps[of], 1e-7, 1.0 - 1e-7)
    value = _table(rolling, chunk, owner[of], theta)
    inner = (i > 0)[1:]
    before = np.append(-1.0, np.where(inner, value[:-1], -1.0))
    after = np.append(np.where(inner, value[1:], -1.0), -1.0)
    most = np.zeros(len(chunk))
    np.maximum.at(most, owner[of], value)
    # A plateau (no load at all, or constant damage) needs one candidate, not all of its points.
    kept = (value > before) & (value >= after) & (value >= KEEP * most[owner[of]])
    i, of = i[kept], of[kept]
    left, right = (low[of] + width[of] * at / steps[of] for at in (np.maximum(i - 1, 0), np.minimum(i + 1, steps[of])))
    return _Brackets(chunk[owner[of]], left, right, low[of], high[of])


def _table(rolling: Rolling, chunk: Ints, owner: Ints, theta: Floats) -> Floats:
    """Damage at roller angles (q,) of variants `owner` (q,) of a chunk by linear interpolation in a table of damage
    over path: the first search."""
    grid = np.linspace(-1.0, 1.0, FINE)
    walls = (np.maximum(rolling.squares[:, chunk] @ chebyshev(grid, POINTS - 1), 0.0)) ** rolling.power
    path = rolling.inside[chunk] @ chebyshev(grid, POINTS)
    offset = 2.0 * np.arange(len(chunk))
    size = rolling.path[chunk]
    known = np.maximum.accumulate((path / size[:, None, None] + offset[:, None, None]).ravel())
    step = (rolling.radius[chunk] / size)[owner]
    at = theta * step
    value = np.zeros(len(theta))
    for j in range(rolling.first, int(np.ceil(np.max(1.0 / step) / np.pi)) + 1):
        place = at + np.pi * j * step
        there = np.flatnonzero((place >= 0.0) & (place <= 1.0))
        if len(there):
            value[there] += np.interp(place[there] + offset[owner[there]], known, walls[j % 2].ravel())
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
@immutable
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
