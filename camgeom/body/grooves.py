"""Cross-sections of bodies with several grooves: side by side on a drum, or in both faces of a plate.

Each groove has its own layer (see `section`); what lies between two of them is ruled from one layer's outer edge to the
other's, so that neighbours have as many cells where they face each other, wherever the grooves run.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import DrumGroove, PlateGroove, Walled, at_azimuths
from camgeom.body.section import CROSSED, Fineness, GroovedSection, Pair, ruled, standing
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.solid import Part
from camgeom.solid.grooves import GroovedDrum
from camgeom.solid.prism import GroovedPlate
from camgeom.track import Track
from camgeom.track.outline import CircleOutline

Index = npt.NDArray[np.int64]
ALONE = "of several tracks the one that is named is pressed alone"
OF_BETWEEN = 0.6
"""of what lies between two grooves that each of them counts as its wall"""


@final
@immutable(eq=True)
class DrumGrooves:
    """Grooves side by side on a drum, from the lower end up, and the numbers of their tracks."""

    grooves: tuple[DrumGroove, ...]
    tracks: tuple[int, ...]

    def walled(self, track: int) -> Walled:
        """The groove of a track, whose walls end at its neighbours."""
        at = self.tracks.index(track)
        own = GroovedSection.of(self.grooves[at], Fineness()).groove
        below = self.grooves[at - 1] if at else None
        above = self.grooves[at + 1] if at + 1 < len(self.grooves) else None
        assert isinstance(own, DrumGroove)
        return Neighboured(own, below, above)

    def section(self, track: int, fine: Fineness) -> DrumStack:
        """The section, with these cells beside a track's groove."""
        at = self.tracks.index(track)
        plain = Fineness((1, 1), (2, 2), 1, 1, (1, 1), fine.core, fine.growth)
        cells = [plain] * len(self.grooves)
        cells[at] = fine
        if at + 1 < len(cells):
            cells[at + 1] = _facing(plain, 0, fine, 1)
        if at:
            cells[at - 1] = _facing(plain, 1, fine, 0)
        return DrumStack(tuple(GroovedSection.of(one, own) for one, own in zip(self.grooves, cells)), self.tracks, at)


@final
@immutable(eq=True)
class PlateGrooves:
    """Grooves in both faces of a plate: of the upper face first, and the numbers of their tracks."""

    grooves: tuple[PlateGroove, PlateGroove]
    tracks: tuple[int, int]

    def walled(self, track: int) -> Walled:
        """The groove of a track."""
        return GroovedSection.of(self.grooves[self.tracks.index(track)], Fineness()).groove

    def section(self, track: int, fine: Fineness) -> PlateFaces:
        """The section, with these cells beside a track's groove."""
        at = self.tracks.index(track)
        # The lower face's section is turned round: its second flank faces the upper one's first.
        other = replace(fine, flank=(1, 1), root=fine.root[::-1], wall=fine.wall[::-1], layer=1)
        cells = (fine, other) if at == 0 else (other, fine)
        upper, lower = (GroovedSection.of(one, own) for one, own in zip(self.grooves, cells))
        return PlateFaces((upper, lower), self.tracks, at)


def _facing(plain: Fineness, side: int, fine: Fineness, other: int) -> Fineness:
    """Cells that on one side meet those of another section's side."""
    flank, root = fine.flank[other], fine.root[other]
    if side == 0:
        return replace(plain, flank=(flank, plain.flank[1]), root=(root, plain.root[1]))
    return replace(plain, flank=(plain.flank[0], flank), root=(plain.root[0], root))


@final
@immutable
class Neighboured:
    """A drum's groove whose walls end at the next grooves, where there are any."""

    own: DrumGroove
    below: DrumGroove | None
    above: DrumGroove | None

    def second(self, side: float) -> bool:
        """See `Walled`."""
        return self.own.second(side)

    def word(self, side: float) -> str:
        """See `Walled`."""
        return self.own.word(side)

    def place(self, theta: float, side: float, t: Floats) -> tuple[Floats, Floats, Floats]:
        """See `Walled`."""
        return self.own.place(theta, side, t)

    def thickness(self, theta: Floats, side: float, t: float) -> Floats:
        """Of the wall behind a flank, mm: to the next groove's edge at this azimuth, or to the end of the drum."""
        second = self.own.second(side)
        next_ = self.above if second else self.below
        if next_ is None:
            return self.own.thickness(theta, side, t)
        x, n = self.own.point(theta, side, t)
        edge = at_azimuths(next_.at, next_.shape.sense, np.arctan2(x[1], x[0]), np.full((x.shape[1], 1),
                                                                                         0.0 if second else 5.0))
        return np.asarray(np.abs(edge[2] - x[2]) * np.abs(n[2]))


@immutable
class SeveralGrooves:
    """The section of a body with several grooves and the numbers of their tracks; `pressed` is the place of the one
    that is pressed."""

    sections: tuple[GroovedSection, ...]
    tracks: tuple[int, ...]
    pressed: int

    @property
    def rows(self) -> Floats:
        """Of the pressed groove."""
        return self.sections[self.pressed].rows

    @property
    def notes(self) -> tuple[str, ...]:
        """Of all grooves, and that one alone is pressed."""
        return tuple(dict.fromkeys((ALONE, *(note for one in self.sections for note in one.notes))))

    def root_cells(self, upper: bool) -> Index:
        """Numbers along the pressed groove's contour of the cells of one root."""
        return self.sections[self.pressed].root_cells(upper)


@final
class DrumStack(SeveralGrooves):
    """The section of a drum with grooves side by side, from the lower end up."""

    def blocks(self, psi: Floats) -> list[Pair]:
        """z and r (n, i, j) of the layers, the pressed one first, of the walls from the lower end up, and of what lies
        below floors and walls."""
        each = self.sections
        contours = [one.contour(psi) for one in each]
        first = [u[:, : 2 * one.middles[0] + 1].min(axis=1) for one, (u, _, _) in zip(each, contours)]
        last = [u[:, 2 * one.middles[1] :].max(axis=1) for one, (u, _, _) in zip(each, contours)]
        start, stop = each[0].groove.shape.ends
        between = [OF_BETWEEN * (high - low) for low, high in zip(last, first[1:])]
        walls = [first[0] - start, *between, stop - last[-1]]
        back = each[0].groove.shape.back
        made = [one.layer((u, v), turn, (low, high), v.min(axis=1) - back)
                for one, (u, v, turn), low, high in zip(each, contours, walls, walls[1:])]  # fmt: skip
        lower = [one.wall(outer, False) for one, (_, outer) in zip(each, made)]
        upper = [one.wall(outer, True) for one, (_, outer) in zip(each, made)]
        ends = [(np.full_like(edge[0], end), edge[1]) for edge, end in ((lower[0], start), (upper[-1], stop))]
        found = [ruled(ends[0], lower[0], each[0].shares(False))]
        for number, (below, above) in enumerate(zip(upper, lower[1:])):
            found.append(ruled(below, above, np.linspace(0.0, 1.0, 2 * self._between(number) + 1)))
        found.append(ruled(upper[-1], ends[1], each[-1].shares(True)))
        core = np.linspace(0.0, 1.0, 2 * each[0].cells.core + 1)
        tops: list[Pair] = [one.bed(outer) for one, (_, outer) in zip(each, made)]
        tops += [(u[:, :, 0], v[:, :, 0]) for u, v in found]
        layers = [layer for layer, _ in made]
        layers.insert(0, layers.pop(self.pressed))
        return [*layers, *found, *(standing(top, back, core) for top in tops)]

    def _between(self, number: int) -> int:
        """Cells from the layer of a groove to that of the next one."""
        return max(self.sections[number].cells.wall[1], self.sections[number + 1].cells.wall[0])

    def wall_path(self, upper: bool) -> list[tuple[int, Floats]]:
        """See `GroovedSection.wall_path`: a wall between two grooves ends at the other one's flank."""
        each, at = self.sections, self.pressed
        own = each[at]
        order = [own, *(one for one in each if one is not own)]
        sizes = [one.contour_cells * one.cells.layer for one in order]
        counts = [each[0].cells.wall[0] * each[0].middles[0]]
        counts += [self._between(k) * (one.contour_cells - one.middles[1]) for k, one in enumerate(each[:-1])]
        number = at + int(upper)
        wall = sum(sizes) + sum(counts[:number])
        path = own.wall_path(upper, 0, wall)
        beyond = at + (1 if upper else -1)
        if not 0 <= beyond < len(each):
            return path
        foot = sum(own.counts[:4]) if upper else own.counts[0] - 1
        height, cells = own.height(upper, foot), self._between(min(at, beyond))
        along = own.contour_cells - own.middles[1] if upper else own.middles[0]
        way = 1.0 if upper else -1.0
        path = path[: own.cells.layer]
        steps = range(cells) if upper else reversed(range(cells))
        path += [(wall + along * i + height, CROSSED[way, -1.0]) for i in steps]
        other = each[beyond]
        start = sum(sizes[: order.index(other)])
        # The other groove's flank that faces this one: its contour runs the other way.
        cell = other.middles[0] - 1 - height if upper else other.middles[1] + height
        edge = 1.0 if upper else -1.0
        layers = reversed(range(other.cells.layer))
        return path + [(start + other.contour_cells * i + cell, CROSSED[-1.0, edge]) for i in layers]

    def outline(self, psi: float) -> Floats:
        """z and r (k, 2) of the body's outline at an azimuth, rad."""
        lines = [np.stack([one.contour(np.array([psi]))[k][0] for k in (0, 1)], axis=1) for one in self.sections]
        shape = self.sections[0].groove.shape
        (start, stop), top = shape.ends, float(lines[0][0, 1])
        around = np.array([[stop, top], [stop, shape.back], [start, shape.back], [start, top]])
        return np.concatenate([*lines, around])

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the body; of each groove by the number of its track."""
        count = len(self.sections)
        layers, walls, under = list(grids[:count]), grids[count : 2 * count + 1], grids[2 * count + 1 :]
        layers.insert(self.pressed, layers.pop(0))
        found = {"bore": [one[:, 0] for one in under],
                 "land": [*(one[:, -1] for one in walls), *(one[:, k] for one in layers for k in (0, -1))],
                 "end_lower": [walls[0][0], under[count][0]], "end_upper": [walls[-1][-1], under[-1][-1]]}  # fmt: skip
        for one, layer, track in zip(self.sections, layers, self.tracks):
            found |= contour_sets(one, layer, track)
        return found


@final
class PlateFaces(SeveralGrooves):
    """The section of a plate with a groove in its upper face and one in its lower one."""

    def blocks(self, psi: Floats) -> list[Pair]:
        """z and r (n, i, j) of the layers, the pressed one first, of both walls of the upper and the lower groove, and
        of what lies between them: below the floors, at the rim and at the bore."""
        layers, walls, beds = [], [], []
        contours = [one.contour(psi) for one in self.sections]
        web = contours[0][1].min(axis=1) + contours[1][1].min(axis=1)
        for one, (u, v, turn) in zip(self.sections, contours):
            start, stop = one.groove.shape.ends
            middles = [2 * number for number in one.middles]
            low, high = u[:, : middles[0] + 1].min(axis=1) - start, stop - u[:, middles[1] :].max(axis=1)
            layer, outer = one.layer((u, v), turn, (low, high), 0.5 * web)
            lower, upper = one.wall(outer, False), one.wall(outer, True)
            layers.append(one.groove.zr(*layer))
            walls.append(one.groove.zr(*ruled((np.full_like(lower[0], start), lower[1]), lower, one.shares(False))))
            walls.append(one.groove.zr(*ruled(upper, (np.full_like(upper[0], stop), upper[1]), one.shares(True))))
            beds.append(one.groove.zr(*one.bed(outer)))
        core = np.linspace(0.0, 1.0, 2 * self.sections[0].cells.core + 1)
        feet = [(z[:, :, 0], r[:, :, 0]) for z, r in walls]
        # From the lower groove up: what faces the upper one's first flank is the lower one's last.
        pairs = ((beds[1], beds[0]), (feet[3], feet[0]), (feet[2], feet[1]))
        web_blocks = [_across((low[0][:, ::-1], low[1][:, ::-1]), high, core) for low, high in pairs]
        if self.pressed:
            layers.reverse()
        return [*layers, *walls, *web_blocks]

    def wall_path(self, upper: bool) -> list[tuple[int, Floats]]:
        """See `GroovedSection.wall_path`."""
        own = self.sections[self.pressed]
        wall = sum(one.contour_cells * one.cells.layer for one in self.sections)
        sizes = [count * cells for one in self.sections for count, cells in
                 zip(one.cells.wall, (one.middles[0], one.contour_cells - one.middles[1]))]  # fmt: skip
        return own.wall_path(upper, 0, wall + sum(sizes[: 2 * self.pressed + int(upper)]))

    def outline(self, psi: float) -> Floats:
        """z and r (k, 2) of the body's outline at an azimuth, rad."""
        found = []
        for one in self.sections:
            u, v, _ = one.contour(np.array([psi]))
            start, stop = one.groove.shape.ends
            line = np.array([[start, v[0, 0]], *np.stack([u[0], v[0]], axis=1), [stop, v[0, -1]]])
            found.append(np.stack(one.groove.zr(line[:, 0], line[:, 1]), axis=1))
        return np.concatenate(found)

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the body; of each groove by the number of its track."""
        layers = list(grids[:2])
        if self.pressed:
            layers.reverse()
        rim_up, bore_up, bore_low, rim_low = grids[2:6]
        _, rim, bore = grids[6:]
        upper, lower = layers
        found = {
            "rim": [rim_up[0], rim_low[-1], rim[0]], "bore": [bore_up[-1], bore_low[0], bore[-1]],
            "end_upper": [rim_up[:, -1], bore_up[:, -1], upper[:, 0], upper[:, -1]],
            "end_lower": [rim_low[:, -1], bore_low[:, -1], lower[:, 0], lower[:, -1]],
        }  # fmt: skip
        for one, layer, track in zip(self.sections, layers, self.tracks):
            found |= contour_sets(one, layer, track)
        return found


def _across(low: Pair, high: Pair, shares: Floats) -> Pair:
    """Points (n, i, j) at shares (j,) of the way from points (n, i) to others."""
    z, r = (a[:, :, None] + shares * (b - a)[:, :, None] for a, b in zip(low, high))
    return z, r


def contour_sets(section: GroovedSection, layer: Index, track: int) -> dict[str, list[Index]]:
    """Nodes of flanks, roots and floor of a track's groove."""
    ends, (one, other) = 2 * np.cumsum((0, *section.counts)), section.groove.shape.flanks
    names = (f"flank_{one}", f"root_{one}", "floor", f"root_{other}", f"flank_{other}")
    return {f"{name}_{track + 1}": [layer[0, a : b + 1]] for name, a, b in zip(names, ends[:-1], ends[1:])}


def grooves_of(part: Part, cutters: Sequence[tuple[Track, ...]]) -> DrumGrooves | PlateGrooves | None:
    """The grooves of a body with several, cut by the tools of its tracks, where all are rings; None of others."""
    if isinstance(part, GroovedDrum) and part.fits:
        order = tuple(part.rings.index(ring) for ring in part.ordered)
        return DrumGrooves(tuple(DrumGroove(part.rings[k]) for k in order), order)
    circle = isinstance(part, GroovedPlate) and isinstance(part.rim.outline, CircleOutline)
    if isinstance(part, GroovedPlate) and circle and len(part.grooves) == 2 and not part.leans:
        each = sorted(range(2), key=lambda k: -part.grooves[k].way)
        upper, lower = (PlateGroove(part, cutters[k][0], k) for k in each)
        return PlateGrooves((upper, lower), (each[0], each[1]))
    return None
