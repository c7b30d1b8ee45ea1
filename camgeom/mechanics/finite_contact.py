"""Contact of a roller of real length on a half-space: crown that runs out, ends, end radius, tilt.

The third level of contact, where neither the exact line nor the exact ellipse (`hertz`) is what touches. Units mm, N,
MPa; x across the roller, y along its axis from its middle; the solver is that of `halfspace`.

A half-space reaches beyond the roller's ends and supports them: the pressure there is that of a roller as stiff as one
that goes on. `mirror` = 1 takes the roller's part of that support away by its mirrored pressure (de Mul, Kalker and
Fredriksson, doi 10.1115/1.3261081): **approximate**, since a quarter-space asks for 1.4 to 1.75 times as much.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import inf, pi, sqrt
from typing import final

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct, gauss_rule
from camgeom.maths.frozen import cached_property, frozen
from camgeom.mechanics import hertz
from camgeom.mechanics.halfspace import NOWHERE, Even, Influence, StripSpectrum, pressed

ACROSS, ALONG = 64, 64
"""cells of the solution"""
STRIPS = 96
"""of unequal length, where an end bears"""
INSIDE = 0.5
"""mm from a sharp end at which the pressure is told instead of the peak that it has not"""
POINTS = 6
"""in a cell along the roller, of the stress below"""
COARSE = (24, 32)
"""cells on which the contact is looked for"""
ROUNDS = 30
WINDOW = 1.12
"""window over the contact found before"""
KNOWN = 512
"""contacts that are kept"""


@final
@immutable(eq=True)
class AxialProfile:
    """Drop of a roller along its axis, mm; y = 0 is the crest of its crown.

    low, high    where its length ends, low < 0 < high
    crown        radius of its arc, mm; inf without one
    run_out      factor c of the logarithmic drop c ln(1 / (1 - (2 y / whole)²)), mm (ISO/TS 16281); 0 without one
    end_radius   rounding that follows beyond both ends, mm; 0: sharp edges
    whole        length over which it runs out, mm, about y = 0; 0: that of the roller
    """

    low: float
    high: float
    crown: float = inf
    run_out: float = 0.0
    end_radius: float = 0.0
    whole: float = 0.0

    @property
    def length(self) -> float:
        """Of the roller without its roundings, mm."""
        return self.high - self.low

    @property
    def sharp(self) -> tuple[bool, bool]:
        """Whether the low and the high end are edges, whose pressure nothing bounds where they bear."""
        if self.end_radius > 0.0:
            return False, False
        out = (0.5 - 1e-9) * (self.whole or self.length) if self.run_out > 0.0 else inf
        return -self.low < out, self.high < out

    @property
    def room(self) -> float:
        """From a sharp end to where its pressure is told, mm."""
        return min(INSIDE, 0.25 * self.length)

    @property
    def reach(self) -> tuple[float, float]:
        """Where the body ends, mm."""
        return self.low - self.end_radius, self.high + self.end_radius

    def drop(self, y: Floats) -> Floats:
        """Drop, mm, at places y, mm; NOWHERE beyond the body."""
        total = np.zeros_like(y)
        if self.crown < inf:
            square = np.minimum(np.square(y / self.crown), 1.0)
            total = self.crown * square / (1.0 + np.sqrt(1.0 - square))
        beyond = np.maximum(np.maximum(self.low - y, y - self.high), 0.0)
        if self.run_out > 0.0:
            share = np.square(2.0 * y / (self.whole or self.length))
            total = total - self.run_out * np.log(np.maximum(1.0 - share, 1e-300))
            return np.where(beyond > 0.0, NOWHERE, total)
        if self.end_radius == 0.0:
            return np.where(beyond > 0.0, NOWHERE, total)
        square = np.square(beyond / self.end_radius)
        rounded = self.end_radius * square / (1.0 + np.sqrt(np.maximum(1.0 - square, 0.0)))
        return np.where(square > 1.0, NOWHERE, total + rounded)


@final
@immutable(eq=True)
class Bodies:
    """Two bodies about to touch: relative curvature across, 1/mm; profile along; tilt, rad; twist, rad.

    compliance  of both, 1/MPa; own: the roller's share of it
    tilt        of the roller's axis against the flank: gap tilt * y, so that a positive one presses the low end
    twist       angle between the axis and the line along which the flank is straight
    mirror      1 takes the support beyond the roller's ends away, approximately; 0 leaves it
    growth      of the curvature along the roller, 1/mm²: `curvature` is that at y = 0
    """

    curvature: float
    profile: AxialProfile
    compliance: float
    tilt: float = 0.0
    twist: float = 0.0
    own: float = 0.5
    mirror: float = 0.0
    growth: float = 0.0

    @property
    def turned(self) -> Bodies:
        """The same seen from behind: y runs the other way."""
        profile = replace(self.profile, low=-self.profile.high, high=-self.profile.low)
        return replace(self, profile=profile, tilt=-self.tilt, twist=-self.twist, growth=-self.growth)

    def gap(self, x: Floats, y: Floats) -> Floats:
        """Unloaded gap, mm, (nx, ny), at places across (nx,) and along (ny,)."""
        drop = self.profile.drop(y) + self.tilt * y
        across = x[:, None] * np.cos(self.twist) - y[None, :] * np.sin(self.twist)
        return np.asarray(0.5 * (self.curvature + self.growth * y) * np.square(across) + drop)

    @property
    def nearest(self) -> float:
        """The least gap, mm, along the middle of the roller: where they touch first."""
        y = np.linspace(*self.profile.reach, 4001)
        if self.profile.crown < inf:
            y = np.append(y, np.clip(-self.profile.crown * np.sin(np.arctan(self.tilt)), *self.profile.reach))
        return float((self.profile.drop(y) + self.tilt * y).min())

    def line_depth(self, pressure: float) -> float:
        """Depth, mm, of the largest shear under a line contact of this pressure, MPa."""
        return float(hertz.line_depth(pressure, self.curvature, self.compliance))


@final
@immutable
class PressurePatch:
    """Pressure, MPa, (nx, ny), of cells about x (nx,) and y (ny,), mm, of even width across; along (ny,), mm.

    approach  of both bodies, mm, of points far away, since they touched first; steps: of the conjugate gradients
    error     share by which the peak differs from that on a grid half as fine
    """

    bodies: Bodies
    load: float
    x: Floats
    y: Floats
    along: Floats
    pressure: Floats
    approach: float
    steps: int
    error: float = inf

    @property
    def width(self) -> float:
        """Of a cell across, mm."""
        return float(self.x[1] - self.x[0])

    @cached_property
    def ridge(self) -> Floats:
        """Largest pressure across the roller at every y, MPa, (ny,)."""
        return _crests(self.pressure)

    @cached_property
    def line_load(self) -> Floats:
        """Load per length, N/mm, (ny,)."""
        return np.asarray(self.pressure.sum(axis=0) * self.width)

    @cached_property
    def span(self) -> tuple[float, float]:
        """Between which y it touches, mm: to the edges of the outermost pressed cells."""
        on = np.flatnonzero(self.line_load > 0.0)
        return (float(self.y[on[0]] - 0.5 * self.along[on[0]]), float(self.y[on[-1]] + 0.5 * self.along[on[-1]]))

    @property
    def length(self) -> float:
        """That touches, mm."""
        return self.span[1] - self.span[0]

    @cached_property
    def centre(self) -> float:
        """Where the resultant acts, mm along the roller."""
        carried = self.line_load * self.along
        return float((carried * self.y).sum() / carried.sum())

    @cached_property
    def half_widths(self) -> Floats:
        """Half of what touches across at every y, mm, (ny,): of half an ellipse of this line load and ridge."""
        ridge, load = self.ridge, self.line_load
        return np.divide(2.0 / pi * load, ridge, out=np.zeros_like(load), where=ridge > 0.0)

    @cached_property
    def bearing_ends(self) -> tuple[bool, bool]:
        """Whether the roller's low and high end bear."""
        edge = 1e-9 * self.bodies.profile.length
        low, high = self.bodies.profile.low, self.bodies.profile.high
        return self.span[0] <= low + edge, self.span[1] >= high - edge

    @property
    def to_the_end(self) -> float:
        """Share of the way from the roller's middle to its end that touches, of the nearer end: 1 where it bears."""
        if any(self.bearing_ends):
            return 1.0
        return max(self.span[0] / self.bodies.profile.low, self.span[1] / self.bodies.profile.high)

    @property
    def near_ends(self) -> tuple[bool, bool]:
        """Whether the contact comes within a cell of the roller's low and high end, so that the end may bear."""
        low, high = self.bodies.profile.low, self.bodies.profile.high
        return self.span[0] <= low + self.along[0], self.span[1] >= high - self.along[-1]

    @property
    def unbounded(self) -> bool:
        """Whether a sharp end bears, where no pressure is the largest."""
        return any(sharp and bears for sharp, bears in zip(self.bodies.profile.sharp, self.bearing_ends))

    @property
    def inside(self) -> float:
        """From a sharp end that bears to where its pressure is told, mm; halfway of a contact that is that short."""
        return min(self.bodies.profile.room, 0.5 * self.length)

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Largest pressure, MPa, and where along the roller, mm; of an unbounded one that `inside` its sharp ends."""
        return max(((self.at(y), y) for y in self._told), key=lambda each: each[0]) if self.unbounded else self._top

    @property
    def _top(self) -> tuple[float, float]:
        """The largest by a parabola of the squares of the ridge through three places."""
        y, at = self.y, int(np.argmax(self.ridge))
        if not 0 < at < len(y) - 1 or min(self.ridge[at - 1], self.ridge[at + 1]) == 0.0:
            return float(self.ridge[at]), float(y[at])
        (l, m, r), (a, b, c) = y[at - 1 : at + 2], np.square(self.ridge[at - 1 : at + 2])
        one, two = (b - a) / (m - l), (c - b) / (r - m)
        bend = (two - one) / (r - l)
        if bend >= 0.0:
            return float(self.ridge[at]), float(y[at])
        place = float(np.clip(0.5 * (l + m) - 0.5 * one / bend, l, r))
        return sqrt(float(a + one * (place - l) + bend * (place - l) * (place - m))), place

    @property
    def _told(self) -> list[float]:
        """Places where a finite pressure may be the largest: inside of the sharp ends that bear, and between."""
        profile = self.bodies.profile
        low, high = (self.inside * (sharp and bears) for sharp, bears in zip(profile.sharp, self.bearing_ends))
        ends = [profile.low + low] * (low > 0.0) + [profile.high - high] * (high > 0.0)
        within = (self.y >= profile.low + low) & (self.y <= profile.high - high)
        return [*ends, float(self.y[int(np.argmax(np.where(within, self.ridge, 0.0)))])]

    def at(self, y: float) -> float:
        """Largest pressure across the roller at a place along it, MPa; linear in its square between the cells."""
        return float(np.sqrt(np.interp(y, self.y, np.square(self.ridge), 0.0, 0.0)))

    def picture(self, n: int, m: int, middle: float) -> tuple[Floats, Floats, Floats]:
        """Even places along (n,), from `middle` on, and across (m,), mm, with the pressure there, MPa, (m, n).

        0 next to a sharp end that bears.
        """
        (low, high), profile = self.span, self.bodies.profile
        room = 0.05 * (high - low)
        along = np.linspace(low - room, high + room, n)
        half = 1.2 * float(np.abs(self.x[(self.pressure > 0.0).any(axis=1)]).max())
        across = np.linspace(-half, half, m)
        square = _beyond(np.square(self.pressure))
        rows = np.stack([np.interp(along, self.y, row, 0.0, 0.0) for row in square])
        value = np.stack([np.interp(across, self.x, column, 0.0, 0.0) for column in rows.T], axis=1)
        value = np.sqrt(np.maximum(value, 0.0))
        ends = ((1.0, profile.low), (-1.0, profile.high))
        for (way, end), sharp, bears in zip(ends, profile.sharp, self.bearing_ends):
            if sharp and bears:
                value[:, way * along < way * end + self.inside] = 0.0
        return middle + along, across, value

    def beneath(self, poisson: float) -> tuple[float, float, float]:
        """Half-width, mm, largest shear, MPa, and its depth, mm, below the peak (Johnson, equation 3.19, summed)."""
        place = self.peak[1]
        half = float(np.interp(place, self.y, self.half_widths))
        middle = float(np.average(self.x, weights=self.pressure[:, int(np.argmin(np.abs(self.y - place)))]))
        # Below a narrow ridge at an end it lies shallow, but not where single points of the sum would show.
        spacing = max(0.5 * self.width, float(np.interp(place, self.y, self.along)) / POINTS)
        low, high = max(0.04 * half, 2.5 * spacing), 1.3 * half
        for _ in range(4):
            depth = np.linspace(low, high, 9)
            shear = np.array([self._shear(middle, place, float(z), poisson) for z in depth])
            at = int(np.argmax(shear))
            low, high = float(depth[max(at - 1, 0)]), float(depth[min(at + 1, 8)])
        return half, float(shear[at]), float(depth[at])

    def _shear(self, x: float, y: float, z: float, poisson: float) -> float:
        """Largest shear, MPa, at depth z, mm, below (x, y)."""
        nodes, weights = gauss_rule(POINTS)
        every = self.y[:, None] + 0.5 * self.along[:, None] * nodes
        area = 0.25 * self.width * self.along[:, None] * weights
        force = np.repeat((self.pressure[:, :, None] * area).reshape(len(self.x), -1), 2, axis=0)
        across = (self.x[:, None] + self.width * np.array([-0.25, 0.25])).reshape(-1, 1)
        return _largest_shear(across - x, every.ravel() - y, z, force, poisson)


def _largest_shear(x: Floats, y: Floats, z: float, force: Floats, poisson: float) -> float:
    """Largest shear, MPa, from point forces, N, (nx, ny), at x (nx, 1), y (ny,) from a point at depth z."""
    r = np.sqrt(x * x + y * y + z * z)
    soft = 1.0 - 2.0 * poisson
    round_, bend = soft * (r * r - r * z - z * z) / (r**3 * (r + z)), soft * (2.0 * r + z) / (r**3 * (r + z) ** 2)
    three = 3.0 * z / r**5
    level, steep = (force * (three - bend)), force * three
    a = (level * x * x + force * round_).sum()
    b = (level * y * y + force * round_).sum()
    c, d, e, f = steep.sum() * z * z, (level * x * y).sum(), (steep * x).sum() * z, (steep * y).sum() * z
    stress = np.linalg.eigvalsh(np.array([[a, d, e], [d, b, f], [e, f, c]])) / (2.0 * pi)
    return 0.5 * float(stress[-1] - stress[0])


def _crests(pressure: Floats) -> Floats:
    """Largest pressure across at every y, (ny,), from that of cells (nx, ny): a parabola of the squares, exact below an
    ellipse."""
    square = np.square(pressure)
    at = np.clip(np.argmax(square, axis=0), 1, len(square) - 2)
    one, two, three = (np.take_along_axis(square, (at + k)[None], axis=0)[0] for k in (-1, 0, 1))
    bend = one - 2.0 * two + three
    rise = np.divide((three - one) ** 2, -8.0 * bend, out=np.zeros_like(two), where=bend < 0.0)
    # A neighbour outside the contact says nothing of the parabola.
    whole = (one > 0.0) & (three > 0.0)
    return np.asarray(np.sqrt(np.where(whole, two + rise, square.max(axis=0))))


def _beyond(square: Floats) -> Floats:
    """Squared pressure with the cells beside the contact below zero, as the two within tell, so that its edge shows."""
    total = square.copy()
    for axis in (0, 1):
        for way in (1, -1):
            one, two = (np.roll(square, way * step, axis) for step in (1, 2))
            beside = (square == 0.0) & (one > 0.0)
            total = np.where(beside, np.minimum(total, np.minimum(2.0 * one - two, 0.0)), total)
    return np.asarray(np.where((square == 0.0) & (total == 0.0), total.min(initial=0.0), total))


@lru_cache(maxsize=KNOWN)
def press(
    bodies: Bodies,
    load: float,
    across: int = ACROSS,
    along: int = ALONG,
    strips: int = STRIPS,
    checked: bool = True,
) -> PressurePatch:
    """The contact of two bodies under a load, N, above 0: found on a coarse grid, solved on one fitted to it.

    Even cells where it ends a cell before the roller does, `strips` that grow from the ends where they bear.
    checked: once with half as many cells before, from which the error is told. Raises NotConverged where the contact is
    not found. The latest are kept: the rigid load, its states and its lives ask for the same ones.
    """
    rough = _found(bodies, load)
    patches: list[PressurePatch] = []
    for part in (2, 1) if checked else (1,):
        if any(rough.near_ends):
            rough = _on_strips(bodies, load, patches[-1] if patches else rough, across // part, strips // part)
        else:
            rough = _on_cells(bodies, load, rough, across // part, along // part)
        patches.append(rough)
    return frozen(replace(rough, error=abs(patches[0].peak[0] / rough.peak[0] - 1.0) if checked else inf))


def _found(bodies: Bodies, load: float) -> PressurePatch:
    """A first, coarse contact: a window that grows until it holds what touches and shrinks while it is too wide."""
    profile = bodies.profile
    half = 2.0 * sqrt(load * bodies.compliance / (pi * bodies.curvature * profile.length))
    ends = np.array(profile.reach)
    if profile.crown < inf:
        middle = float(np.clip(-profile.crown * bodies.tilt, profile.low, profile.high))
        reach = 2.0 * np.cbrt(load * bodies.compliance * profile.crown) + half
        ends = np.array([max(ends[0], middle - reach), min(ends[1], middle + reach)])
    wide = 3.0 * half + abs(np.sin(bodies.twist)) * (ends[1] - ends[0])
    for _ in range(ROUNDS):
        found = _even(bodies, load, wide, (float(ends[0]), float(ends[1])), *COARSE)
        on = found.pressure > 0.0
        columns, rows = np.flatnonzero(on.any(axis=1)), np.flatnonzero(on.any(axis=0))
        spare = wide - max(abs(found.x[columns[0]]), abs(found.x[columns[-1]])) - 0.5 * found.width
        step = float(found.along[0])
        grow = np.array([rows[0] == 0, rows[-1] == COARSE[1] - 1]) & (np.abs(ends - np.array(profile.reach)) > 1e-9)
        long = len(rows) * step
        if spare < 0.5 * found.width:
            wide *= 2.0
        elif grow.any():
            ends += np.array([-1.0, 1.0]) * grow * 0.5 * (ends[1] - ends[0])
            ends = np.clip(ends, *profile.reach)
        elif wide - spare < 0.4 * wide:
            wide = 1.3 * (wide - spare)
        elif long < 0.4 * (ends[1] - ends[0]):
            ends = np.array([found.y[rows[0]], found.y[rows[-1]]]) + np.array([-1.0, 1.0]) * (0.3 * long + step)
            ends = np.clip(ends, *profile.reach)
        else:
            return found
    raise NotConverged("the contact along the roller was not found: check length, crown and tilt against the load")


def _even(bodies: Bodies, load: float, wide: float, ends: tuple[float, float], nx: int, ny: int,
          before: PressurePatch | None = None) -> PressurePatch:
    """The contact on even cells of a window, half as wide as `wide` tells, mm."""
    dx, dy = 2.0 * wide / nx, (ends[1] - ends[0]) / ny
    x, y = np.asarray((np.arange(nx) + 0.5) * dx - wide), np.asarray((np.arange(ny) + 0.5) * dy + ends[0])
    influence = Even(nx, ny, dx, dy, bodies.compliance)
    return _solved(bodies, load, x, y, np.full(ny, dy), influence, before)


def _solved(bodies: Bodies, load: float, x: Floats, y: Floats, along: Floats, influence: Influence,
            before: PressurePatch | None) -> PressurePatch:
    guess = _carried(before, x, y) if before is not None else None
    area = (x[1] - x[0]) * along[None, :]
    found = pressed(bodies.gap(x, y), influence, area, load, guess)
    return PressurePatch(bodies, load, x, y, along, found.pressure, found.approach - bodies.nearest, found.steps)


def _carried(patch: PressurePatch, x: Floats, y: Floats) -> Floats:
    """Its pressure between its cells, (nx, ny), as a guess for others: linear, 0 beyond."""
    rows = np.stack([np.interp(y, patch.y, row) for row in patch.pressure])
    return np.stack([np.interp(x, patch.x, column, 0.0, 0.0) for column in rows.T], axis=1)


def _widest(patch: PressurePatch) -> float:
    """Half a window across that holds what touches, mm."""
    on = np.flatnonzero((patch.pressure > 0.0).any(axis=1))
    return WINDOW * (float(np.abs(patch.x[on]).max()) + 0.5 * patch.width)


def _on_cells(bodies: Bodies, load: float, rough: PressurePatch, nx: int, ny: int) -> PressurePatch:
    """The contact on even cells of the window of a rough one, wider where that was too narrow."""
    wide, (low, high) = _widest(rough), rough.span
    room = 0.5 * (WINDOW - 1.0) * (high - low)
    low, high = low - room, high + room
    for _ in range(ROUNDS):
        low, high = max(low, bodies.profile.reach[0]), min(high, bodies.profile.reach[1])
        found = _even(bodies, load, wide, (low, high), nx, ny, rough)
        p = found.pressure
        if p[0].any() or p[-1].any():
            wide *= 1.1
        elif (p[:, 0].any() and low > bodies.profile.reach[0]) or (p[:, -1].any() and high < bodies.profile.reach[1]):
            low, high = low - 0.05 * (high - low), high + 0.05 * (high - low)
        else:
            return found
        rough = found
    raise NotConverged("the contact along the roller was not found: check length, crown and tilt against the load")


def _on_strips(bodies: Bodies, load: float, rough: PressurePatch, nx: int, ny: int) -> PressurePatch:
    """The contact on strips that grow away from the ends that bear; what a window was too narrow for leads the next."""
    before = rough
    wide, profile, bears = _widest(rough), bodies.profile, rough.near_ends
    mirrors = profile.reach if bodies.mirror > 0.0 else ()
    over = min(2.0 * float(rough.half_widths.max()) * sqrt(profile.end_radius * bodies.curvature), profile.end_radius)
    room = 0.5 * (WINDOW - 1.0) * rough.length
    for _ in range(ROUNDS):
        low = profile.low - over if bears[0] else max(rough.span[0] - room, profile.low)
        high = profile.high + over if bears[1] else min(rough.span[1] + room, profile.high)
        # A tilted roller under a small load may touch with the rounding of its end alone.
        beyond = bears[0] and rough.span[1] < profile.low, bears[1] and rough.span[0] > profile.high
        if any(beyond):
            low, high = max(rough.span[0] - room, profile.reach[0]), min(rough.span[1] + room, profile.reach[1])
        edges = _grown(low, high, [end for end, on in zip((profile.low, profile.high), bears) if on],
                       over / 10.0 if over > 0.0 else 0.002 * (high - low), ny)
        middles = 0.5 * (edges[1:] + edges[:-1])
        dx = 2.0 * wide / nx
        x = np.asarray((np.arange(nx) + 0.5) * dx - wide)
        influence = StripSpectrum(nx, dx, edges, bodies.compliance, mirrors, bodies.mirror * bodies.own)
        found = _solved(bodies, load, x, middles, np.diff(edges), influence, before)
        p, before = found.pressure, found
        first, last = bool(p[:, 0].any()), bool(p[:, -1].any())
        if p[0].any() or p[-1].any():
            wide *= 1.1
        elif any(beyond) and ((first and low > profile.reach[0]) or (last and high < profile.reach[1])):
            room *= 2.0
        elif over < profile.end_radius and ((first and bears[0]) or (last and bears[1])):
            over = min(1.5 * over, profile.end_radius)
        elif (first and not bears[0]) or (last and not bears[1]):
            room *= 2.0
            bears = bears[0] or low == profile.low, bears[1] or high == profile.high
        else:
            return found
    raise NotConverged("the contact along the roller was not found: check length, crown and tilt against the load")


def _grown(low: float, high: float, fine: list[float], least: float, count: int) -> Floats:
    """Edges (count + 1,) of strips from low to high that are short about the places `fine` and grow away from them.

    Their length at a distance d is as least + d / 8, scaled to the count.
    """
    y = distinct(np.concatenate([np.linspace(low, high, 2001), *(place + _near(least, high - low) for place in fine)]))
    y = y[(y >= low) & (y <= high)]
    off = np.min(np.abs(y[None, :] - np.array(fine)[:, None]), axis=0)
    density = 1.0 / (least + off / 8.0)
    whole = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(y))])
    return np.asarray(np.interp(np.linspace(0.0, whole[-1], count + 1), whole, y))


def _near(least: float, far: float) -> Floats:
    """Distances from a place, both ways, that resolve `least`."""
    away = np.geomspace(0.05 * least, far, 400)
    return np.concatenate([-away[::-1], [0.0], away])
