"""Forces applied to the follower over a range of cam angle: a table or an expression."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal, Self, final

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, Field, model_validator

from camgeom.errors import Problem, ProfileError
from camgeom.keys import Degrees, Section
from camgeom.maths import Floats
from camgeom.mechanics.expression import Expression, compile_expression
from camgeom.mechanics.panels import TURN

Interpolation = Literal["linear", "smooth"]
Value = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]


def _rows(table: object) -> object:
    """A list of lists, which is what TOML gives, as the tuples that a frozen section holds."""
    return tuple(tuple(row) if isinstance(row, list) else row for row in table) if isinstance(table, list) else table


@final
class Force(Section):
    """One applied force of a profile: `from`, `until` (degrees) with an `expression`, or a `table` of (degrees, N)."""

    begin: Degrees = Field(0.0, alias="from", description="Cam angle where the force begins, degrees")
    until: Degrees = Field(360.0, description="Cam angle where the force ends, degrees; smaller than `from`: past 360")
    expression: str | None = Field(
        None, max_length=2000, description="Force against motion towards larger lift, N (N mm on a swinging follower "
        "or a turret); variables phi (rad), deg, s, v, a")
    table: Annotated[tuple[tuple[Degrees, Value], ...] | None, BeforeValidator(_rows)] = Field(
        None, max_length=100_000, description="Rows of cam angle (degrees, increasing) and force (N or N mm)")
    interpolation: Interpolation = Field("linear", description="Between table rows: linear, or smooth (monotone cubic)")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.expression is None) == (self.table is None):
            raise ValueError("a force needs either an expression or a table")
        if self.expression is not None:
            if self.begin == self.until:
                raise ValueError("`from` and `until` are equal: the force has no range of cam angle")
            try:
                compile_expression(self.expression)
            except ProfileError as refused:
                # pydantic turns a ValueError into a finding with its place in the profile.
                raise ValueError(_reason(refused)) from None
        if self.table is not None:
            _check_table([row[0] for row in self.table])
        return self

    def applied(self, key: str = "operation.force") -> Applied:
        """The force as an array function of cam angle and motion."""
        if self.table is not None:
            rows = np.asarray(self.table, dtype=np.float64)
            return table_force(np.radians(rows[:, 0]), rows[:, 1], self.interpolation)
        return expression_force(self.expression or "0", np.radians(self.begin), np.radians(self.until), key)


def _reason(refused: ProfileError) -> str:
    problem = refused.problems[0]
    return f"{problem.message}; {problem.hint}" if problem.hint else problem.message


def _check_table(angles: list[float]) -> None:
    if len(angles) < 2:
        raise ValueError("a force table needs two rows or more")
    if any(b <= a for a, b in itertools.pairwise(angles)):
        raise ValueError("the cam angles of a force table must increase")
    if angles[-1] - angles[0] > 360.0:
        raise ValueError("a force table covers more than one turn")


@final
@dataclass(frozen=True, eq=False)
class Applied:
    """A force, N (N mm on a rotating follower), on a closed range of cam angle; zero elsewhere.

    begin: rad in [0, 2 pi); length: rad, at most a turn; breaks: cam angles in [0, 2 pi], rad, where it may jump or
    kink; value: function of (cam angle in [0, 2 pi), lift, velocity, acceleration).
    """

    begin: float
    length: float
    breaks: tuple[float, ...]
    value: Callable[[Floats, Floats, Floats, Floats], Floats]

    def __call__(self, theta: ArrayLike, s: ArrayLike = 0.0, v: ArrayLike = 0.0, a: ArrayLike = 0.0) -> Floats:
        """Force at cam angle theta (rad, any turn); broadcast shape of the arguments."""
        angle, lift, speed, change = np.broadcast_arrays(
            np.asarray(theta, dtype=np.float64), *(np.asarray(x, dtype=np.float64) for x in (s, v, a)))
        turned = np.mod(angle - self.begin, TURN)
        inside = (turned <= self.length) | (self.length >= TURN)
        # The closing end belongs to the range although it may round to just past it or to a whole turn.
        inside |= np.minimum(np.abs(turned - self.length), TURN - turned) <= 1e-14 * TURN
        force = np.zeros(angle.shape)
        if inside.any():
            force[inside] = self.value(np.mod(angle[inside], TURN), lift[inside], speed[inside], change[inside])
        return force


def expression_force(text: str, begin: float, until: float, key: str = "operation.force") -> Applied:
    """A force given by an expression from cam angle `begin` to `until` (rad); past a turn where until < begin."""
    expression: Expression = compile_expression(text, key)
    return Applied(*_range(begin, until), value=expression)


def table_force(theta: ArrayLike, force: ArrayLike, interpolation: Interpolation = "linear") -> Applied:
    """A force, N, from a table over increasing cam angles (rad), within one turn; zero outside the table."""
    angle, value = np.asarray(theta, dtype=np.float64), np.asarray(force, dtype=np.float64)
    if angle.ndim != 1 or angle.shape != value.shape or not (np.isfinite(angle).all() and np.isfinite(value).all()):
        raise ProfileError([Problem("operation.force.table", "needs two columns of finite numbers")])
    try:
        _check_table(np.degrees(angle).tolist())
    except ValueError as error:
        raise ProfileError([Problem("operation.force.table", str(error))]) from None
    begin, length, _ = _range(float(angle[0]), float(angle[-1]))
    local = angle - angle[0]
    curve = _linear(local, value) if interpolation == "linear" else monotone_cubic(local, value)
    inner = np.mod(angle, TURN)
    ends = (TURN,) if np.any(inner == 0.0) else ()

    def at(turn: Floats, s: Floats, v: Floats, a: Floats) -> Floats:
        del s, v, a
        x = np.mod(turn - begin, TURN)
        return curve(np.where(x > local[-1] + 1e-12, np.minimum(x - TURN, 0.0), x))

    return Applied(begin, length, tuple(float(x) for x in inner) + ends, at)


def _range(begin: float, until: float) -> tuple[float, float, tuple[float, ...]]:
    """Start in [0, 2 pi), length and break angles of a range given by its two ends in rad."""
    length = until - begin
    if length <= 0.0 or length > TURN:
        length = float(np.mod(length, TURN)) or TURN
    start = float(np.mod(begin, TURN))
    end = start + length
    # The end as it was given, where it is within the turn: a recomputed one could miss a knot of the motion.
    stop = float(until) if 0.0 <= until <= TURN else (end if end <= TURN else end - TURN)
    return start, length, (start, stop)


def _linear(x: Floats, y: Floats) -> Callable[[Floats], Floats]:
    return lambda at: np.asarray(np.interp(at, x, y), dtype=np.float64)


def monotone_cubic(x: Floats, y: Floats) -> Callable[[Floats], Floats]:
    """Piecewise cubic through (x, y) that rises and falls only where the data do (slopes after Fritsch and Butland)."""
    step, rise = np.diff(x), np.diff(y)
    chord = rise / step
    slope = np.empty_like(y)
    if len(x) == 2:
        slope[:] = chord[0]
    else:
        near, far = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
        agree = np.sign(chord[:-1]) * np.sign(chord[1:]) > 0.0
        left, right = np.where(agree, chord[:-1], 1.0), np.where(agree, chord[1:], 1.0)
        slope[1:-1] = np.where(agree, (near + far) / (near / left + far / right), 0.0)
        slope[0] = _end_slope(step[0], step[1], chord[0], chord[1])
        slope[-1] = _end_slope(step[-1], step[-2], chord[-1], chord[-2])

    def curve(at: Floats) -> Floats:
        cell = np.clip(np.searchsorted(x, at, side="right") - 1, 0, len(step) - 1)
        h = step[cell]
        u = np.clip((at - x[cell]) / h, 0.0, 1.0)
        w = 1.0 - u
        return np.asarray(w * w * ((1.0 + 2.0 * u) * y[cell] + u * h * slope[cell])
                          + u * u * ((1.0 + 2.0 * w) * y[cell + 1] - w * h * slope[cell + 1]))

    return curve


def _end_slope(h0: float, h1: float, d0: float, d1: float) -> float:
    """One-sided three-point slope, limited so that the end cell stays monotone."""
    slope = ((2.0 * h0 + h1) * d0 - h0 * d1) / (h0 + h1)
    if slope * d0 <= 0.0:
        return 0.0
    return 3.0 * d0 if d0 * d1 <= 0.0 and abs(slope) > 3.0 * abs(d0) else slope
