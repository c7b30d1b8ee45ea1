"""A normalised motion law as data: exact jets and integrals, its breaks, and its characteristic values."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.motion.piece import Piece
from camgeom.motion.table import JUMP_TOLERANCE, Side, Table

ParamValue = Any
"""A number, a truth value, a text or a (nested) tuple of numbers: what TOML can say, made hashable."""
ORDER_LIMIT = 9
"""Derivatives are compared up to this order when smoothness is measured."""


@final
@dataclass(frozen=True)
class Claims:
    """Characteristic values of a law for unit lift over unit travel, all dimensionless.

    vm, am, jm   peak |s'|, |s''|, |s'''|; am is inf where the velocity jumps, jm is inf where the acceleration jumps,
                 the ends against a dwell included
    vam          peak |s' s''|, the drive torque of a pure inertia
    arms         root mean square of s''
    order_start, order_end   the highest derivative that is continuous against a dwell (0: not even the velocity)
    order_inside             the same at the inner breaks; inf where the law is smooth inside
    """

    vm: float
    am: float
    jm: float
    vam: float
    arms: float
    order_start: int
    order_end: int
    order_inside: float = math.inf

    @property
    def order(self) -> int:
        """The highest derivative that is continuous from dwell to dwell."""
        return int(min(self.order_start, self.order_end, self.order_inside))


@final
@dataclass(frozen=True)
class Law:
    """A motion law on 0 <= x <= 1 with s(0) = 0 and s(1) = 1, dimensionless, as contiguous pieces.

    Every piece is a power series and waves, so derivatives of any order and integrals are exact.

    >>> from camgeom.motion import make
    >>> make("cycloidal").jet(0.25, order=1).round(6)
    array([0.090845, 1.      ])
    """

    name: str
    pieces: tuple[Piece, ...]
    source: str = ""
    claims: Claims | None = None
    params: tuple[tuple[str, ParamValue], ...] = ()

    @cached_property
    def table(self) -> Table:
        """The pieces as arrays."""
        return Table.of(self.pieces)

    def jet(self, x: npt.ArrayLike, order: int = 3, side: Side = "right") -> Floats:
        """s and its derivatives with respect to x, (order + 1, *x.shape), dimensionless.

        At a break the right-hand piece is used, or the left-hand one with side="left". Raises ValueError where an x
        lies outside 0..1 or is not a number.
        """
        points = np.asarray(x, dtype=float)
        if not np.all((points >= 0.0) & (points <= 1.0)):
            raise ValueError(f"law {self.name!r} is defined on 0 <= x <= 1")
        return self.table.jet(points.ravel(), order, side).reshape(order + 1, *points.shape)

    @cached_property
    def knots(self) -> tuple[float, ...]:
        """The ends and the inner places where some derivative jumps."""
        return (0.0, *(edge for edge, _ in self._breaks), 1.0)

    @cached_property
    def _breaks(self) -> tuple[tuple[float, int], ...]:
        """Inner breaks: (x, lowest derivative that jumps)."""
        after = np.arange(1, len(self.pieces))
        lowest = lowest_jump(self.table.steps(after - 1, after, ORDER_LIMIT))
        inner = self.table.edges[1:-1]
        return tuple((float(x), int(r)) for x, r in zip(inner, lowest, strict=True) if r <= ORDER_LIMIT)

    def peaks(self) -> Claims:
        """The characteristic values measured on the law itself, dimensionless (see `Claims`)."""
        table = self.table
        inside = min((order - 1 for _, order in self._breaks), default=math.inf)
        start, end = self._rest_order("first"), self._rest_order("last")
        order = min(start, end, inside)
        torque = table.peak(3, lambda d: d[1] * d[2], lambda d: d[2] * d[2] + d[1] * d[3])
        impulsive = order < 1
        return Claims(
            vm=abs(table.derivative_peak(1).value),
            am=math.inf if impulsive else abs(table.derivative_peak(2).value),
            jm=math.inf if order < 2 else abs(table.derivative_peak(3).value),
            vam=math.inf if impulsive else abs(torque.value),
            arms=math.inf if impulsive else math.sqrt(table.mean_square(2)),
            order_start=start,
            order_end=end,
            order_inside=inside,
        )

    def integral(self, x: npt.ArrayLike = 1.0) -> Floats:
        """The integral of s from 0 to x, (*x.shape), dimensionless; exact, piece by piece."""
        total, parts = 0.0, []
        for piece in self.pieces:
            parts.append(piece.integrated(total))
            total = parts[-1].value(piece.end)
        points = np.asarray(x, dtype=float)
        return np.asarray(Table.of(parts).jet(points.ravel(), 0)[0].reshape(points.shape))

    def mean_square(self, order: int = 2) -> float:
        """The mean square of a derivative over the travel, dimensionless."""
        return self.table.mean_square(order)

    def _rest_order(self, end: Literal["first", "last"]) -> int:
        """The number of derivatives that vanish at an end, counted up to the limit."""
        piece = 0 if end == "first" else len(self.pieces) - 1
        jet = self.table.limit(np.array([piece]), ORDER_LIMIT, end)[:, 0]
        bound = self.table.bounds(ORDER_LIMIT)[:, piece]
        moving = np.abs(jet[1:]) > JUMP_TOLERANCE * bound[1:]
        return int(np.argmax(moving)) if moving.any() else ORDER_LIMIT


def lowest_jump(steps: Floats) -> npt.NDArray[np.intp]:
    """The lowest derivative that steps, (m,), of steps (orders, m); the number of orders where none does."""
    jumps = steps != 0.0
    return np.where(jumps.any(axis=0), np.argmax(jumps, axis=0), len(steps))


def finish(pieces: Sequence[Piece], lift: float = 1.0) -> tuple[Piece, ...]:
    """Anchor the first piece at x = 0 and the last at x = 1, so that both end positions are exact to the last digit."""
    first, *rest = pieces
    if not rest:
        first, rest = first.between(0.0, 0.5), [first.between(0.5, 1.0)]
    first, last = first.about(first.start), rest[-1].about(rest[-1].end)
    scale = max(abs(lift), *(abs(c) for c in (*first.power, *last.power)))
    if abs(first.power[0]) > 1e-9 * scale or abs(last.power[0] - lift) > 1e-9 * scale:
        raise ValueError(f"the pieces run from {first.power[0]!r} to {last.power[0]!r}, not from 0 to {lift!r}")
    ends = (first, last)
    targets = (0.0, lift)
    exact = [replace(piece, power=(value, *piece.power[1:])) for piece, value in zip(ends, targets, strict=True)]
    return (exact[0], *rest[:-1], exact[1])
