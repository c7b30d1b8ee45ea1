"""Pieces, one formula on one interval each, and rows of them as arrays: jets of any order, jumps, peaks, mean squares.

A jet is evaluated by repeated Horner for the power series and by half angles for the waves, one piece or many at once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Literal, NamedTuple, final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats, gauss_rule
from camgeom.maths.extremum import bracketed_root

Wave = tuple[float, float, float]
"""(w, a, b): the term a (cos(w u) - 1) + b sin(w u), which is zero at the anchor."""


@final
@dataclass(frozen=True, slots=True)
class Piece:
    """f(x) on start <= x <= end: sum_k power[k] u^k + sum (a (cos(w u) - 1) + b sin(w u)), u = x - anchor.

    Every term but power[0] vanishes at the anchor, so the value there is exact; an anchor at the end of a motion keeps
    the last digits there. Every derivative and every integral of a piece is again a piece.
    """

    start: float
    end: float
    anchor: float
    power: tuple[float, ...]
    waves: tuple[Wave, ...] = ()
    kept: int = -1
    """derivatives up to this order continue the piece before by construction (a spline); -1 where nothing is known"""

    def value(self, x: float, order: int = 0) -> float:
        """The derivative of the given order at x (scalar; arrays are evaluated by `PieceTable`)."""
        u = x - self.anchor
        total = 0.0
        for k in range(len(self.power) - 1, order - 1, -1):
            total = total * u + self.power[k] * math.perm(k, order)
        for w, a, b in self.waves:
            c, s = math.cos(w * u), math.sin(w * u)
            versine = -2.0 * math.sin(0.5 * w * u) ** 2
            quarter = (a * (c if order else versine) + b * s, b * c - a * s)[order % 2]
            total += w**order * (-1.0 if order % 4 >= 2 else 1.0) * quarter
        return total

    def scaled(self, factor: float, offset: float = 0.0) -> Piece:
        """offset + factor f."""
        power = (offset + factor * self.power[0], *(factor * c for c in self.power[1:]))
        return replace(self, power=power, waves=tuple((w, factor * a, factor * b) for w, a, b in self.waves))

    def mirrored(self) -> Piece:
        """1 - f(1 - x): the same motion run backwards from the other end."""
        power = tuple(c if k % 2 else -c for k, c in enumerate(self.power))
        return Piece(
            1.0 - self.end,
            1.0 - self.start,
            1.0 - self.anchor,
            (1.0 - self.power[0], *power[1:]),
            tuple((w, -a, b) for w, a, b in self.waves),
        )

    def about(self, anchor: float) -> Piece:
        """The same function written about another anchor (Taylor shift of the powers, rotation of the waves)."""
        shift = anchor - self.anchor
        power = [
            sum(self.power[k] * math.comb(k, r) * shift ** (k - r) for k in range(len(self.power) - 1, r - 1, -1))
            for r in range(len(self.power))
        ]
        waves: list[Wave] = []
        for w, a, b in self.waves:
            c, s = math.cos(w * shift), math.sin(w * shift)
            power[0] += -2.0 * a * math.sin(0.5 * w * shift) ** 2 + b * s
            waves.append((w, a * c + b * s, b * c - a * s))
        return replace(self, anchor=anchor, power=tuple(power), waves=tuple(waves))

    def between(self, start: float, end: float) -> Piece:
        """The same formula on another interval."""
        return replace(self, start=start, end=end)

    def integrated(self, value_at_start: float) -> Piece:
        """The antiderivative that takes the given value at `start`; exact, term by term."""
        slope = self.power[0] - sum(a for _, a, _ in self.waves)
        power = (0.0, slope, *(c / (k + 2) for k, c in enumerate(self.power[1:])))
        raw = Piece(self.start, self.end, self.anchor, power, tuple((w, -b / w, a / w) for w, a, b in self.waves))
        return replace(raw, power=(value_at_start - raw.value(self.start), *power[1:]))


Indices = npt.NDArray[np.intp]
Row = Floats | float


class Block(NamedTuple):
    """Pieces of one shape (degree, number of waves) as columns: power (degree + 1, m); w, a, b (waves, m)."""

    power: Floats
    w: Floats
    a: Floats
    b: Floats

    def fill(self, out: Floats, column: Indices, u: Floats) -> None:
        """Write the jets at the points u (n,) of the pieces `column` (n,) into out (order + 1, n)."""
        waves = zip(self.w, self.a, self.b, strict=True)
        fill(out, (row[column] for row in self.power[::-1]), (tuple(row[column] for row in wave) for wave in waves), u)

    def bound(self, reach: Floats, order: int) -> Floats:
        """Upper bounds (order + 1, m) of |derivative| where |u| <= reach (m,): the scale that rounding is judged by."""
        out = np.zeros((order + 1, len(reach)))
        for r in range(order + 1):
            for k in range(len(self.power) - 1, r - 1, -1):
                out[r] *= reach
                out[r] += math.perm(k, r) * np.abs(self.power[k])
            for w, a, b in zip(self.w, self.a, self.b, strict=True):
                out[r] += (np.abs(a) + np.abs(b)) * w**r
        return out


def fill(out: Floats, power: Iterable[Row], waves: Iterable[tuple[Row, Row, Row]], u: Floats) -> None:
    """Write the jet at u (n,) into out (order + 1, n); `power` from the highest down, rows are (n,) or numbers."""
    top = 0
    # Repeated Horner: afterwards out[r] is the r-th derivative divided by r!.
    for step, c in enumerate(power):
        if step == 0:
            out[0] = c
            out[1:] = 0.0
            continue
        top = min(step, len(out) - 1)
        for r in range(top, 0, -1):
            if r < step:
                out[r] *= u
            out[r] += out[r - 1]
        out[0] *= u
        out[0] += c
    for r in range(2, top + 1):
        out[r] *= math.factorial(r)
    for w, a, b in waves:
        _add_wave(out, w, a, b, u)


def _add_wave(out: Floats, w: Row, a: Row, b: Row, u: Floats) -> None:
    """Add the jet of a (cos(w u) - 1) + b sin(w u); half angles keep the digits of cos - 1 near the anchor."""
    half = u * (0.5 * w)
    sine = np.sin(half)
    versine = sine * sine
    versine *= -2.0
    np.cos(half, out=half)
    sine *= half
    sine *= 2.0
    out[0] += _mix(a, versine, b, sine)
    if len(out) == 1:
        return
    versine += 1.0
    terms = _mix(a, versine, b, sine), _mix(b, versine, -a, sine)
    factor: Row = w
    for r in range(1, len(out)):
        out[r] += (-factor if r % 4 >= 2 else factor) * terms[r % 2]
        factor = factor * w


def _mix(a: Row, x: Floats, b: Row, y: Floats) -> Floats:
    """a x + b y; most waves are a pure sine or cosine, and half the work is saved there."""
    if isinstance(a, float) and a == 0.0:
        return b * y
    if isinstance(b, float) and b == 0.0:
        return a * x
    return a * x + b * y


def stretched(piece: Piece, rate: float) -> tuple[tuple[float, ...], tuple[Wave, ...]]:
    """The powers and waves of a piece for an argument that runs 1/rate times as long."""
    if rate == 1.0:
        return piece.power, piece.waves
    power = tuple([c * rate**k for k, c in enumerate(piece.power)])
    return power, tuple([(w * rate, a, b) for w, a, b in piece.waves])


Side = Literal["left", "right"]
JetMap = Callable[[Floats], Floats]
ROUNDING = 4e-16
"""of the largest u: how near a root is found"""
JUMP_TOLERANCE = 1e-9
"""A difference counts as a jump above this fraction of the derivative's own bound on the two pieces that meet."""
LEAST_JUMP = 1e-280
"""Below this a number has too few digits left to tell a jump from rounding."""
RUN_LENGTH = 64
"""Points a run from which on it pays to evaluate run after run instead of gathering coefficients point by point."""
CACHED = 4096
"""Points evaluated at once, so that the working arrays stay in the processor's cache."""


class Peak(NamedTuple):
    """A signed extreme value and the place where it is reached."""

    value: float
    at: float


def _runs(index: Indices) -> list[int]:
    """Where each run of equal numbers ends, the last at len(index)."""
    if len(index) == 0:
        return []
    return [*(np.flatnonzero(index[1:] != index[:-1]) + 1).tolist(), len(index)]


@final
class PieceTable:
    """A row of pieces on the edges (p + 1,), each stretched over t by its own rate: x = x0 + (t - t0) rate. Immutable.

    Limits at the edges, peaks and means are taken in u = t - anchor as the pieces' own coordinates give it, so they
    keep their digits where an interval is so short that t itself has few.
    """

    def __init__(self, edges: Floats, anchors: Floats, rates: Floats, pieces: Sequence[Piece]) -> None:
        shapes: dict[tuple[int, int], list[int]] = {}
        for i, piece in enumerate(pieces):
            shapes.setdefault((len(piece.power), len(piece.waves)), []).append(i)
        self.edges, self.anchors = edges, anchors
        self.first_u = np.array([piece.start - piece.anchor for piece in pieces]) / rates
        self.last_u = np.array([piece.end - piece.anchor for piece in pieces]) / rates
        self.kept = np.array([piece.kept for piece in pieces])
        self._rows = [stretched(piece, rate) for piece, rate in zip(pieces, rates.tolist(), strict=True)]
        self._block_of = np.zeros(len(pieces), dtype=np.intp)
        self._column_of = np.zeros(len(pieces), dtype=np.intp)
        blocks = []
        for number, members in enumerate(shapes.values()):
            self._block_of[members] = number
            self._column_of[members] = np.arange(len(members))
            power = np.array([self._rows[i][0] for i in members], dtype=float).T
            waves = np.array([self._rows[i][1] for i in members], dtype=float).reshape(len(members), -1, 3)
            blocks.append(Block(power, *(np.ascontiguousarray(waves[:, :, c].T) for c in range(3))))
        self._blocks = tuple(blocks)
        for array in (edges, anchors, self.first_u, self.last_u, self.kept):
            array.setflags(write=False)

    def __len__(self) -> int:
        return len(self.anchors)

    @classmethod
    def of(cls, pieces: Sequence[Piece]) -> PieceTable:
        """The table of contiguous pieces in their own coordinate."""
        edges = np.array([pieces[0].start, *(piece.end for piece in pieces)])
        return cls(edges, np.array([piece.anchor for piece in pieces]), np.ones(len(pieces)), pieces)

    def locate(self, t: Floats, side: Side = "right") -> Indices:
        """The piece (n,) that holds each t; at an edge the right-hand or the left-hand one."""
        return np.searchsorted(self.edges[1:-1], t, side=side)

    def jet(self, t: Floats, order: int, side: Side = "right") -> Floats:
        """Value and derivatives (order + 1, n) at t (n,)."""
        index = self.locate(t, side)
        ends = _runs(index)
        if len(ends) * RUN_LENGTH < len(t):
            return self._by_runs(index, ends, t, order)
        if len(self) * RUN_LENGTH > len(t):
            out = np.empty((order + 1, len(t)))
            for low in range(0, len(t), CACHED):
                part = index[low : low + CACHED]
                out[:, low : low + CACHED] = self.at(part, t[low : low + CACHED] - self.anchors[part], order)
            return out
        # Small integers are sorted by radix, far quicker than the angles themselves.
        sorting = np.argsort(index.astype(np.int16) if len(self) < 2**15 else index, kind="stable")
        index = index[sorting]
        out = np.empty((order + 1, len(t)))
        out[:, sorting] = self._by_runs(index, _runs(index), t[sorting], order)
        return out

    def _by_runs(self, index: Indices, ends: list[int], t: Floats, order: int) -> Floats:
        """The jets (order + 1, n), each piece evaluated on its own runs of points with plain numbers."""
        out = np.empty((order + 1, len(t)))
        for start, end in pairwise([0, *ends]):
            i = int(index[start])
            power, waves = self._rows[i]
            anchor = float(self.anchors[i])
            for low in range(start, end, CACHED):
                part = slice(low, min(low + CACHED, end))
                fill(out[:, part], reversed(power), waves, t[part] - anchor)
        return out

    def limit(self, index: Indices, order: int, end: Literal["first", "last"]) -> Floats:
        """The jets (order + 1, m) of the given pieces at their own first or last point."""
        return self.at(index, (self.first_u if end == "first" else self.last_u)[index], order)

    def at(self, index: Indices, u: Floats, order: int) -> Floats:
        """Value and derivatives with respect to t (order + 1, n) of the pieces `index` (n,) at their own u (n,)."""
        out = np.empty((order + 1, len(u)))
        column, block_of = self._column_of[index], self._block_of[index]
        for number, block in enumerate(self._blocks):
            if len(self._blocks) == 1:
                block.fill(out, column, u)
                break
            chosen = np.flatnonzero(block_of == number)
            if len(chosen):
                part = np.empty((order + 1, len(chosen)))
                block.fill(part, column[chosen], u[chosen])
                out[:, chosen] = part
        return out

    def steps(self, before: Indices, after: Indices, order: int, advance: float = 0.0) -> Floats:
        """The steps (order + 1, m) in value and derivatives from one piece's end to another's start.

        A difference that rounding explains is 0; so is one that the pieces' construction rules out. `advance` is what
        the value has grown by when the first piece follows on the last.
        """
        steps = self.limit(after, order, "first") - self.limit(before, order, "last")
        steps[0] += np.where(after < before, advance, 0.0)
        bounds = self.bounds(order)
        known = np.arange(order + 1)[:, None] <= self.kept[after]
        steps[known | (np.abs(steps) <= JUMP_TOLERANCE * (bounds[:, before] + bounds[:, after]) + LEAST_JUMP)] = 0.0
        return steps

    def content(self) -> bytes:
        """All that makes it: tables of the same content move alike."""
        blocks = [array.tobytes() for block in self._blocks for array in block]
        return b"".join([self.edges.tobytes(), self.first_u.tobytes(), self._block_of.tobytes(), *blocks])

    def bounds(self, order: int) -> Floats:
        """Upper bounds (order + 1, p) of the derivatives on each piece."""
        reach = np.maximum(np.abs(self.first_u), np.abs(self.last_u))
        out = np.empty((order + 1, len(self)))
        for number, block in enumerate(self._blocks):
            members = np.flatnonzero(self._block_of == number)
            out[:, members] = block.bound(reach[members], order)
        return out

    def extremes(self, order: int, value: JetMap, slope: JetMap) -> tuple[Peak, Peak]:
        """The least and the greatest value(jet): edges from both sides, and the roots of `slope` inside, refined.

        Where a value is reached more than once the first place is given.
        """
        m = 17 + 2 * max(len(block.power) for block in self._blocks) + 4 * math.ceil(self._phase())
        u = np.linspace(self.first_u, self.last_u, m, axis=1)
        index = np.repeat(np.arange(len(self)), m)
        jets = self.at(index, u.ravel(), order)
        height, rise = value(jets).reshape(u.shape), slope(jets).reshape(u.shape)
        # Where a segment ends at rest the slope is rounding of either sign, and no root lies beside it.
        rise[np.abs(rise) <= 1e-15 * np.abs(rise).max()] = 0.0
        piece, left = np.nonzero(rise[:, :-1] * rise[:, 1:] < 0.0)
        inner = self._root(piece, u[piece, left], u[piece, left + 1], order, slope)
        heights = np.concatenate([value(self.at(piece, inner, order)), height.ravel()])
        places = self.anchors[np.concatenate([piece, index])] + np.concatenate([inner, u.ravel()])
        slack = 1e-12 * np.abs(heights).max()
        found = []
        for sign in (-1.0, 1.0):
            tied = np.flatnonzero(sign * heights >= (sign * heights).max() - slack)
            chosen = tied[np.argmin(places[tied])]
            found.append(Peak(float(heights[chosen]), float(places[chosen])))
        return found[0], found[1]

    def peak(self, order: int, value: JetMap, slope: JetMap) -> Peak:
        """The largest |value(jet)|, signed; of two equal ones the first."""
        pair = self.extremes(order, value, slope)
        most = max(abs(peak.value) for peak in pair) * (1.0 - 1e-12)
        return min((peak for peak in pair if abs(peak.value) >= most), key=lambda peak: peak.at)

    def _root(self, piece: Indices, low: Floats, high: Floats, order: int, slope: JetMap) -> Floats:
        """The roots (m,) of slope(jet) in the brackets (low, high), one a bracket."""
        if len(piece) == 0:
            return low
        reach = float(np.maximum(np.abs(low), np.abs(high)).max())
        return bracketed_root(lambda u: slope(self.at(piece, u, order)), low, high, ROUNDING * reach)

    def derivative_peak(self, order: int) -> Peak:
        """The largest |derivative of the given order| and where."""
        return self.peak(order + 1, lambda jets: jets[order], lambda jets: jets[order + 1])

    def derivative_extremes(self, order: int) -> tuple[Peak, Peak]:
        """The least and the greatest derivative of the given order and where."""
        return self.extremes(order + 1, lambda jets: jets[order], lambda jets: jets[order + 1])

    def mean_square(self, order: int) -> float:
        """The mean square of a derivative over the whole row.

        Gauss-Legendre per piece with degree + phase + 13 nodes: exact for the powers, and for the waves below
        rounding, since the rule converges faster than any power once it has more nodes than the phase in radians.
        """
        nodes = max(len(block.power) for block in self._blocks) + 13 + math.ceil(self._phase())
        x, weight = gauss_rule(nodes)
        middle, half = 0.5 * (self.last_u + self.first_u), 0.5 * (self.last_u - self.first_u)
        u = middle[:, None] + half[:, None] * x
        index = np.repeat(np.arange(len(self)), nodes)
        square = self.at(index, u.ravel(), order)[order].reshape(u.shape) ** 2
        return float((square @ weight * half).sum() / (self.edges[-1] - self.edges[0]))

    def _phase(self) -> float:
        """The largest phase, in radians, that a wave turns through on its piece."""
        width = self.last_u - self.first_u
        phases = [
            float((block.w * width[self._block_of == number]).max())
            for number, block in enumerate(self._blocks)
            if block.w.size
        ]
        return max(phases, default=0.0)
