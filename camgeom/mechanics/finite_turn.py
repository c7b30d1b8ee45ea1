"""Finite contact of a roller over a turn: solved where it is hardest, tabled over load and curvature for the rest.

Between the table's loads the pressure is linear in the root of the load, between its curvatures in their logarithm: 0.3
per cent. Ends, tilt and twist are those of the wall's hardest cam angle. Units mm, N, MPa, rad.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import ceil, floor, inf, log, log10
from typing import final

import numpy as np
from numpy.typing import NDArray

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import Panels, highest
from camgeom.mechanics.contact import Stiffness
from camgeom.mechanics.finite_contact import AxialProfile, Bodies, PressurePatch, press

BINS = 31
"""equal stretches along the roller, beside one at each end"""
STEPS, DECADE = 5, 4
"""of tabled loads below the first from the largest on, and in a decade: below the least the pressure goes to 0 with the
load's root"""
BEND = 0.25
"""step of the logarithm of the tabled curvature; both steps begin at 1, so that operating states, which differ in their
loads, ask for the same contacts, but where the load tilts a roller"""
COUNTED = 0.2
"""share of the largest load from which the curvature counts"""
ALIKE = 1e-9
"""share by which curvatures differ that are one"""
SAME = 0.02
"""share by which the tilts that a load gives, over it, differ at most where one is tabled"""
DIGITS, NO_TILT = 10, 1e-12
"""of tabled loads and curvatures, decimals of their twist, rad, and growth, 1/mm²; step of their tilt, rad"""
TABLED = (32, 48, 64)
"""cells across and along, and strips, of a tabled contact"""
FINE, FINER = 128, 256
"""strips of the hardest one, and of one whose peak is not yet known"""
NEAR = 0.03
"""share below the hardest wall by the table, which errs by less, within which the other wall is solved too"""
KNOWN = 0.02
"""error up to which a peak is one"""
SMALL = 0.02
"""share by which the load is changed for the tangent of the approach"""


@final
@immutable
class FiniteTurn:
    """Contact of one roller over one turn with either wall.

    normal     signed force, N, (p, n), positive on the wall behind; curvature: relative, of the wall that bears, 1/mm
    walls      the bodies of wall 1 (behind) and -1 (ahead), as far as they bear; their curvature does not count
    """

    panels: Panels
    normal: Floats
    curvature: Floats
    walls: Mapping[int, Bodies]

    @cached_property
    def edges(self) -> Floats:
        """Of the bins along the roller, mm from its middle, (m + 1,)."""
        return bins(self._profile)

    @cached_property
    def known(self) -> tuple[float, float]:
        """Between which places along the roller, mm, pressures are told: not next to a sharp end that bears."""
        (low, high), sharp, bears = self._profile.reach, self._profile.sharp, self.hardest[1].bearing_ends
        room = self._profile.room
        return low + room * (sharp[0] and bears[0]), high - room * (sharp[1] and bears[1])

    @property
    def _profile(self) -> AxialProfile:
        """Of the roller: that of both walls."""
        return next(iter(self.walls.values())).profile

    @cached_property
    def places(self) -> Floats:
        """Middles of the bins, those at the ends where the length ends, mm, (m,)."""
        return middles_of(self.edges, self._profile)

    def _of(self, wall: int) -> Floats:
        """Load on a wall, N, (p, n)."""
        return np.maximum(wall * self.normal, 0.0)

    @cached_property
    def squares(self) -> Floats:
        """Squared largest pressure of every bin, MPa², (m, p, n), of the wall that bears, as hard as `hardest`."""
        at, patch = self.hardest
        top = self._tabled.max(axis=0)
        tabled = float(self.panels.limit(top, at.cam_angle, top))
        return np.asarray(self._tabled * (1.0 if patch.unbounded else patch.peak[0] ** 2 / tabled))

    @cached_property
    def _tabled(self) -> Floats:
        """The same from the table's coarser cells."""
        total = np.zeros((len(self.places), *self.normal.shape))
        for wall in self.walls:
            table = PressureTable(self.walls[wall], self._of(wall), self.curvature, self.edges)
            total += np.square(table.pressures(self._of(wall), self.curvature))
        return total

    @cached_property
    def _tops(self) -> dict[int, tuple[Floats, Floats, Floats]]:
        """Of every wall what the table tells: largest squares of the bins and their angles, (m,), squares (m, p, n)."""
        found = {}
        for wall in self.walls:
            tabled = np.where(self._of(wall) > 0.0, self._tabled, 0.0)
            found[wall] = (*highest(self.panels, tabled), tabled)
        return found

    @cached_property
    def hardest(self) -> tuple[Extreme, PressurePatch]:
        """Where the table is hardest over the turn, and the contact solved there; an unbounded one before others."""
        found: list[tuple[Extreme, PressurePatch]] = []
        hardest = max(float(np.max(top)) for top, _, _ in self._tops.values())
        for wall, (top, angle, tabled) in self._tops.items():
            load, m = self._of(wall), int(np.argmax(top))
            places = {float(angle[m]): tabled[m]} if top[m] >= (1.0 - NEAR) ** 2 * hardest else {}
            if any(self._profile.sharp):
                # The table tells nothing of ends that bear: most do under the largest load.
                places = {float(highest(self.panels, load)[1]): load, float(angle[m]): tabled[m]}
            for each, judged in places.items():
                here, k = (float(self.panels.limit(one, each, judged)) for one in (load, self.curvature))
                if here > 0.0:
                    patch = refined(replace(self.walls[wall], curvature=k), here)
                    found.append((Extreme(surely(patch), each, patch.peak[1], where=str(wall)), patch))
        sharp = [one for one in found if one[1].unbounded]
        return max(sharp or found, key=lambda one: one[0].value)

    @property
    def unbounded(self) -> bool:
        """Whether a sharp end bears at the hardest angle, where no pressure is the largest."""
        return self.hardest[1].unbounded

    @property
    def unknown(self) -> bool:
        """Whether the largest pressure is not known within KNOWN: at ends that are nearly sharp."""
        return unknown(self.hardest[1])

    @cached_property
    def stiffness(self) -> Stiffness:
        """Of the hardest contact, N/mm."""
        return stiffness_of(self.hardest[1])


def bins(profile: AxialProfile) -> Floats:
    """Edges of the bins along a roller, mm from its middle, (BINS + 3,)."""
    middle = np.linspace(profile.low + profile.room, profile.high - profile.room, BINS + 1)
    return np.concatenate([profile.reach[:1], middle, profile.reach[1:]])


def middles_of(edges: Floats, profile: AxialProfile) -> Floats:
    """Middles of the bins, those at the ends where the length ends, mm."""
    middles = 0.5 * (edges[1:] + edges[:-1])
    return np.concatenate([[profile.low], middles[1:-1], [profile.high]])


def stiffness_of(patch: PressurePatch) -> Stiffness:
    """Tangent and secant of a contact, N/mm."""
    loads = (patch.load * (1.0 + way * SMALL) for way in (-1.0, 1.0))
    less, more = (press(patch.bodies, load, *TABLED, checked=False).approach for load in loads)
    return Stiffness(2.0 * SMALL * patch.load / (more - less), patch.load / patch.approach)


def refined(bodies: Bodies, load: float) -> PressurePatch:
    """The contact under a load, N, on strips so fine that its peak is known, as far as it can be."""
    patch = press(bodies, load, strips=FINE)
    return press(bodies, load, strips=FINER) if unknown(patch) else patch


def square(patch: PressurePatch) -> float:
    """Pressure, MPa, of a contact whose roller stands square to its flank under the same load; inf where none is."""
    return pressure_of(refined(replace(patch.bodies, tilt=0.0), patch.load))


def pressure_of(patch: PressurePatch | None) -> float:
    """Its largest, MPa, with its error where that is large; 0 of none, inf of one that nothing bounds."""
    if patch is None:
        return 0.0
    return inf if patch.unbounded else patch.peak[0] * (1.0 + patch.error * unknown(patch))


def unknown(patch: PressurePatch) -> bool:
    """Whether a contact's largest pressure is not known within KNOWN: at an end that is nearly sharp."""
    return not patch.unbounded and patch.error > KNOWN


def surely(patch: PressurePatch) -> float:
    """A pressure, MPa, that its largest surely reaches; of an unbounded one that inside of the sharp end."""
    return patch.peak[0] * (max(0.0, 1.0 - patch.error) if unknown(patch) else 1.0)


def without_peak(patch: PressurePatch, table: str = "roller") -> str:
    """Why a contact has no largest pressure, and what to give so that it has; empty where it has one."""
    if unknown(patch):
        return (
            f"the pressure at the roller's end is known within {patch.error:.1%} alone: its edge is nearly sharp; give "
            f"a larger {table}.end_radius, or {table}.crown = 'logarithmic'"
        )
    if not patch.unbounded:
        return ""
    return (
        f"the pressure is unbounded at the sharp end that bears ({patch.peak[0]:.6g} MPa {patch.inside:.3g} mm inside"
        f"): give {table}.end_radius, or a crown that ends within the roller ({table}.crown = 'logarithmic')"
    )


@final
class PressureTable:
    """Pressure of every bin over tilts, curvatures and loads, (t, c, l, m), of one wall."""

    def __init__(
        self, bodies: Bodies, load: Floats, curvature: Floats, edges: Floats, lean: Floats | None = None,
        cells: tuple[int, int, int] = TABLED,
    ) -> None:
        """bodies: of the wall, without what the load tilts; lean: tilt that the load gives, over it, 1/N; cells
        across, along, and strips."""
        most, self.cells = float(load.max(initial=0.0)), cells
        counted = load >= COUNTED * most
        low, high = float(curvature[counted].min()), float(curvature[counted].max())
        # Tilts that loads give are every table's own: so are its contacts then.
        alone = lean is not None
        top, origin = (most, log(low)) if alone else (10.0 ** (ceil(DECADE * log10(most)) / DECADE), 0.0)
        self.loads = _rounded(top * 10.0 ** (np.arange(alone - STEPS, 1) / DECADE))
        if high > low * (1.0 + ALIKE):
            steps = np.arange(floor((log(low) - origin) / BEND), ceil((log(high) - origin) / BEND) + 1)
            self.bends = _rounded(np.exp(origin + BEND * steps))
        else:
            self.bends = _rounded(np.array([low]))
        self.leans = _nodes(lean[counted] if lean is not None else np.zeros(1), NO_TILT / most if most else inf)
        self.edges = edges
        self.bodies = replace(bodies, twist=round(bodies.twist, DIGITS), growth=round(bodies.growth, DIGITS))
        self.values = np.full((len(self.leans), len(self.bends), len(self.loads), len(edges) - 1), np.nan)

    def fill(self, asked: NDArray[np.bool_]) -> None:
        """Solve what is asked of (t, c, l) and not known yet: load, curvature and tilt of a turn go together, so that
        most of their combinations never act."""
        for t, c, l in zip(*np.nonzero(asked & np.isnan(self.values[..., 0]))):  # fmt: skip
            load = float(self.loads[l])
            tilt = round((self.bodies.tilt + float(self.leans[t]) * load) / NO_TILT) * NO_TILT
            bodies = replace(self.bodies, curvature=float(self.bends[c]), tilt=tilt)
            self.values[t, c, l] = self._solved(bodies, load, self.edges)

    def _solved(self, bodies: Bodies, load: float, edges: Floats) -> Floats:
        if bodies.tilt < 0.0:  # both walls of a drive that moves to and fro alike ask for the same contacts
            return self._solved(bodies.turned, load, -edges[::-1])[::-1]
        patch = press(bodies, load, *self.cells, checked=False)
        fine = np.concatenate([np.linspace(a, b, 9) for a, b in zip(edges[:-1], edges[1:])])
        square = np.interp(fine, patch.y, np.square(patch.ridge), 0.0, 0.0).reshape(-1, 9).max(axis=1)
        # What lies in a narrow ridge between those places counts too.
        inside = np.clip(np.searchsorted(edges, patch.y) - 1, 0, len(edges) - 2)
        np.maximum.at(square, inside, np.square(patch.ridge))
        if patch.unbounded:
            square[[0, -1]] = np.where(patch.bearing_ends, 0.0, square[[0, -1]])
            # A contact that touches next to its sharp end alone is told where its neighbours are.
            peak, place = patch.peak
            at = int(np.clip(np.searchsorted(edges, place) - 1, 1, len(square) - 2))
            square[at] = max(square[at], peak * peak)
        return np.asarray(np.sqrt(square))

    def pressures(self, load: Floats, curvature: Floats, lean: Floats | None = None) -> Floats:
        """Pressure of every bin, MPa, (m, ...), under loads, of curvatures and with tilts over load (...)."""
        root = np.sqrt(np.concatenate([[0.0], self.loads]))
        bends = np.log(np.clip(curvature, self.bends[0], self.bends[-1]))
        leans = np.zeros(1) if lean is None else np.clip(lean, self.leans[0], self.leans[-1])
        axes = (_between(self.leans, leans), _between(np.log(self.bends), bends), _between(root, np.sqrt(load)))
        corners = []
        for corner in np.ndindex(*(2 if len(one) > 1 else 1 for one in (self.leans, self.bends, root))):
            shares = [part if way else 1.0 - part for way, (_, part) in zip(corner, axes)]
            at = np.broadcast_arrays(*(i + way for way, (i, _) in zip(corner, axes)))
            corners.append((np.prod(np.broadcast_arrays(*shares), axis=0), tuple(at)))
        asked = np.zeros((len(self.leans), len(self.bends), len(root)), dtype=bool)
        for share, at in corners:
            asked[tuple(one[share > 0.0] for one in at)] = True
        self.fill(asked[:, :, 1:])
        values = np.concatenate([np.zeros_like(self.values[:, :, :1]), self.values], axis=2)
        found = np.zeros((*np.shape(load), values.shape[-1]))
        for share, at in corners:
            found += share[..., None] * np.where(share[..., None] > 0.0, values[at], 0.0)
        return np.moveaxis(found, -1, 0)


def _rounded(x: Floats) -> Floats:
    """To DIGITS, so that what differs by rounding alone is solved once."""
    return np.array([float(f"{one:.{DIGITS - 1}e}") for one in x])


def _nodes(lean: Floats, none: float) -> Floats:
    """The least and the largest of what is interpolated, or one where they hardly differ, or by no more than `none`."""
    low, high = float(lean.min()), float(lean.max())
    return np.array([low, high]) if high - low > max(SAME * max(abs(low), abs(high)), none) else np.array([high])


def _between(known: Floats, x: Floats) -> tuple[np.ndarray[tuple[int, ...], np.dtype[np.intp]], Floats]:
    """Interval of every x among known values, and the share of the way through it."""
    if len(known) == 1:
        return np.zeros(x.shape, dtype=np.intp), np.zeros(x.shape)
    i = np.clip(np.searchsorted(known, x, "right") - 1, 0, len(known) - 2)
    return i, np.clip((x - known[i]) / (known[i + 1] - known[i]), 0.0, 1.0)
