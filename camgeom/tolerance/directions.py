"""Errors that are tried: part by part at both ends, all parts of one together, and in directions beside that.

An error of any direction has two parts. What they do alone points to its hardest direction: exact where the follower
follows in proportion. Lines of contact that come to bear or go make what it does another than a sine of the direction;
that then points beside the hardest, by up to 2.4 % of it at shipped cams.

A figure is what an error does at a cam angle: a motion, a growth of the pressure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi
from typing import TYPE_CHECKING, Self, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_maximum
from camgeom.maths.frozen import cached_property
from camgeom.tolerance.causes import Cause
from camgeom.tolerance.seat import TOGETHER, Bools

if TYPE_CHECKING:
    from camgeom.tolerance.sensitivity import Seated

BESIDE = pi / 6.0
"""rad, on either side: a sine through three directions says where its largest is"""
CLOSER = BESIDE / 4.0
"""rad, a second time"""
LARGE, NEAR = 0.7, 0.97
"""share of an error's largest figure that the parts' effects promise from which directions beside theirs are tried, and
that is found from which they are tried more closely"""
SETTLED = 1e-10
"""share of the largest figure to which the search of all directions goes"""
MOST_HELD, COPIES = 1.2e9, 4.0
"""bytes of the errors that are tried and what is found of them, and those over the errors' own (measured)"""
Rows = npt.NDArray[np.intp]
Figure = Callable[[Floats], Floats]
"""figures (..., k) of errors (..., k, p), mm, at k cam angles"""


@final
@immutable
class Trials:
    """Errors put on, plus and minus, part by part; of each roller or wall in turn where each has its own.

    errors  (t, 2, n, p) of the packed stations, mm
    cause, group   numbers of the error and of whose it is, (t,): parts of one have both alike
    """

    errors: Floats
    cause: Rows
    group: Rows

    @classmethod
    def of(cls, seated: Seated, sizes: Sequence[tuple[Cause, float]]) -> Self:
        """Those of causes of a size in mm or rad each."""
        packed, parts = seated.packed, list[tuple[Floats, Bools | None]]()
        names: list[tuple[int, int]] = []
        for i, (cause, unit) in enumerate(sizes):
            g = unit * packed.taken(seated.flat(seated.approaches.of(cause)))
            owners = {"roller": packed.roller, "wall": packed.wall}.get(cause.holder)
            for share in [None] if owners is None else [owners == k for k in distinct(owners)]:
                parts += [(part, share) for part in g]
                names += [(i, len(parts))] * len(g)
        angle = COPIES * 16.0 * len(parts) * packed.order.shape[1]
        if (taken := angle * len(packed.order)) > MOST_HELD:
            raise NotConverged(
                f"errors at {len(packed.order)} cam angles of the turn would take about {1e-6 * taken:.0f} MB, at most "
                f"{int(MOST_HELD / angle)} are paid for with {1e-6 * MOST_HELD:.0f} MB: fewer segments of the motion, "
                "or rows of tables of forces"
            )
        errors = np.empty((len(parts), 2, *packed.order.shape))
        for both, (part, share) in zip(errors, parts):
            both[0] = part if share is None else part * share
            np.negative(both[0], out=both[1])
        cause_of, group = np.array(names, dtype=np.intp).T
        return cls(errors, cause_of, group)

    @cached_property
    def several(self) -> Rows:
        """Numbers of the parts, (g, 2), of errors that have two."""
        first = np.flatnonzero(self.group[1:] == self.group[:-1])
        return np.column_stack([first, first + 1])

    def at(self, rows: Rows) -> Trials:
        """The same at some of the cam angles."""
        return Trials(self.errors[:, :, rows], self.cause, self.group)

    def told(self, values: Floats, of: Figure) -> Floats:
        """Of every error the largest of all whose it is, at least 0, (w, causes, n), of w figures.

        values: those of the trials, (w, t, 2, n); of: those (w, g, n) with errors (w, g, n, p), each its own; both
        parts of one are put on together, each by its share alone
        """
        end, part = values.argmax(axis=2), np.maximum(values.max(axis=2), 0.0)
        found = np.stack([part[:, self.cause == i].max(axis=1) for i in range(int(self.cause[-1]) + 1)], axis=1)
        if len(self.several):
            size = np.hypot(*(part[:, one] for one in self.several.T))
            whole = np.zeros((*size.shape, self.errors.shape[-1]))
            for one in self.several.T:
                share = np.divide(part[:, one], size, out=np.zeros_like(size), where=size > 0.0)
                whole += np.where(end[:, one] == 0, share, -share)[..., None] * self.errors[one, 0]
            for cause, value in zip(self.cause[self.several[:, 0]], of(whole).swapaxes(0, 1)):
                found[:, cause] = np.maximum(found[:, cause], value)
        return found

    def swung(self, ends: Floats, found: Floats, figure: Callable[[Rows], Figure]) -> None:
        """Largest figures found (causes, n) of every error, raised where one of any direction does more beside where
        its parts point: at the angles where that is large, and in all directions where it is largest, of every holder.

        ends: figures (t, 2, n) of the trials; figure: that at cam angles (k,), by their numbers
        """
        if not len(self.several):
            return
        far, sign = ends.max(axis=1)[self.several], np.where(ends[:, 0] >= ends[:, 1], 1.0, -1.0)[self.several]
        cause = self.cause[self.several[:, 0]]
        large = np.hypot(far[:, 0], far[:, 1]) >= LARGE * found[cause].max(axis=1)[:, None]
        group, rows = np.nonzero(large & (far.max(axis=1) > 0.0))
        if not len(rows):
            return
        first, second = (sign * np.maximum(far, 0.0))[group, :, rows].T
        turned = Turned(figure, self.errors[self.several[group].T, 0, rows], rows)
        value, turn = turned.by_blocks(lambda block, own: block.farther(own[0]), np.arctan2(second, first))
        which, most = cause[group], found.max(axis=1)
        np.maximum.at(most, which, value)
        near = np.flatnonzero(value >= NEAR * most[which])
        closer, _ = turned.some(near).by_blocks(
            lambda block, own: block.beside(own[0], own[1], CLOSER), turn[near], value[near]
        )
        value[near] = np.maximum(value[near], closer)
        each = [np.flatnonzero(group == i) for i in distinct(group)]
        hardest = np.array([own[np.argmax(value[own])] for own in each])
        value[hardest] = np.maximum(value[hardest], turned.some(hardest).largest(float(value.max())))
        np.maximum.at(found, (which, rows), value)


@final
@immutable
class Turned:
    """An error of any direction at cam angles rows (k,), both parts at its size, (2, k, p), mm, and a figure there."""

    figure: Callable[[Rows], Figure]
    parts: Floats
    rows: Rows

    @cached_property
    def _there(self) -> Figure:
        return self.figure(self.rows)

    def some(self, which: Rows) -> Turned:
        """At some of the cam angles."""
        return Turned(self.figure, self.parts[:, which], self.rows[which])

    def by_blocks(
        self, of: Callable[[Turned, list[Floats]], tuple[Floats, Floats]], *own: Floats
    ) -> tuple[Floats, Floats]:
        """Values and directions, (k,), of all cam angles, few of them at a time, with what each has of its own."""
        count = max(1, len(self.rows))
        few = max(1, TOGETHER * count // max(1, self.parts.size))
        blocks = [np.arange(i, min(i + few, len(self.rows))) for i in range(0, count, few)]
        found = [of(self.some(rows), [one[rows] for one in own]) for rows in blocks]
        value, turn = (np.concatenate(each) for each in zip(*found))
        return value, turn

    def turned(self, turn: Floats) -> Floats:
        """The figure in directions (k, q), rad, from the first part towards the second, (k, q)."""
        errors = np.stack([np.cos(turn), np.sin(turn)], axis=2) @ self.parts.swapaxes(0, 1)
        return self._there(errors.swapaxes(0, 1)).T

    def beside(self, start: Floats, value: Floats, by: float) -> tuple[Floats, Floats]:
        """The largest figure and its direction, (k,), of start (k,), where it is value (k,), those by, rad, beside it,
        and where a sine through these three is the largest."""
        sides = start[:, None] + np.array([-by, by])
        before, after = (two := self.turned(sides)).T
        bend = (value - 0.5 * (before + after)) / (1.0 - np.cos(by))
        vertex = start + np.arctan2((after - before) / (2.0 * np.sin(by)), bend)
        at_vertex = self.turned(vertex[:, None])
        return _best(np.column_stack([value, two, at_vertex]), np.column_stack([start, sides, vertex]))

    def farther(self, first: Floats) -> tuple[Floats, Floats]:
        """A large figure and its direction, (k,), near first (k,) or its mirror images in either part, or both: where
        a part acts both ways alike it does not say which of both."""
        images = np.column_stack([first, -first, pi - first, pi + first])
        value, start = _best(self.turned(images), images)
        return self.beside(start, value, BESIDE)

    def largest(self, known: float) -> Floats:
        """The largest figure of all directions, (k,), to a share of a known one."""
        count = len(self.rows)
        return bracketed_maximum(self.turned, np.zeros(count), np.full(count, 2.0 * pi), noise=SETTLED * known)[0]


def _best(values: Floats, turn: Floats) -> tuple[Floats, Floats]:
    """The largest of values (k, q) and its direction of turn (k, q), (k,)."""
    rows, best = np.arange(len(values)), np.argmax(values, axis=1)
    return values[rows, best], turn[rows, best]
