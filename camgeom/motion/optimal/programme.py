"""One linear programme: the best shape near a shape, its breaks fixed or free to move a little, with multipliers.

Limits on acceleration and jerk are exact rows, for the shape is straight between its breaks; the vibration's circle is
cut from outside by tangents (J. E. Kelley, SIAM J. 8 (1960) 703), the velocity is held at its own extremes.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.motion.optimal.shape import (
    Shape,
    decay,
    moment_parts,
    residual_parts,
    slopes,
    velocity_parts,
)
from camgeom.motion.optimal.wish import Task

LARGE = 100.0
STILL = 1e-6
"""what a unit of a break's move costs against a unit of what is least"""
PACES = np.array([0.0, 0.02, 0.06, 0.15, 0.4, 1.0])
"""where the straight pieces of that cost meet, shares of the reach"""
FEW, STEPS = 2, 20
"""steps of the simplex method for each row and unknown after which a programme counts as stalled, and as lost; sound
ones take a quarter of one, at most 1.25"""
STALLED = (1, 4)
"""what the solver says where it ran out of steps or of digits"""
LOST = STALLED[1]
CLOSEST = 1e-3
"""no two breaks that move come closer than this share of the travel"""
WHOLE = 50_000_000
"""rows times steps that the search for one law may cost, about 25 s of a processor; ordinary ones take a hundredth"""
SETUP = 10_000
"""of the same; what a programme costs before its first step"""


@final
@immutable
class Cuts:
    """Rows that cut off what has exceeded a limit: tangents to the circle of the vibration, Re(z(n) exp(-i angle)) <=
    limit, and the velocity at places between the breaks; and whether it has dipped to its limit downwards, which is
    held from then on."""

    n: Floats
    angle: Floats
    places: Floats
    dips: bool = False

    def and_at(self, n: Floats, angle: Floats, places: Floats, dips: bool) -> Cuts:
        """These and further ones."""
        pairs = (self.n, n), (self.angle, angle), (self.places, places)
        n, angle, places = (np.concatenate(pair) for pair in pairs)
        return Cuts(n, angle, places, self.dips or dips)

    def living(self, worth: Floats, latest: int) -> Cuts:
        """All places, and of the tangents the latest ones and those that are worth something in a programme."""
        kept = (worth > 0.0) | (np.arange(len(worth)) >= len(worth) - latest)
        return Cuts(self.n[kept], self.angle[kept], self.places, self.dips)

    def rows(self, x: Floats, smooth: bool, damping: float) -> tuple[Floats, Floats]:
        """The real kernels against the pieces, and their values at the breaks."""
        turn = np.exp(-1j * self.angle)
        k, damped = decay(self.n, damping)
        at = np.exp(-k[:, None] * (1.0 - x)) / damped[:, None]
        return (residual_parts(x, smooth, self.n, damping) * turn[:, None, None]).real, (at * turn[:, None]).real


NO_CUTS = Cuts(np.empty(0), np.empty(0), np.empty(0))


@final
@immutable
class Multipliers:
    """What each row is worth: the moments (2,), the cuts (q,), the velocity above and below at its places, and the
    jerk of each span (K,), positive where its upper limit holds."""

    moments: Floats
    cuts: Cuts
    cut: Floats
    places: Floats
    above: Floats
    below: Floats
    jerk: Floats


@final
@immutable
class Solved:
    """The best shape of a programme, its value t, and the multipliers.

    at_rest   whether its breaks are where they belong among all laws, so that the multipliers are those of all laws
    """

    shape: Shape
    value: float
    multipliers: Multipliers
    at_rest: bool = False


class SearchPurse:
    """What the search for one law may cost: steps of the simplex method, each as dear as its programme has rows.

    Counted, not timed, so that the same requirement has the same answer on every machine. Of several laws of a cam,
    `among`, each has its share.
    """

    def __init__(self, whole: int = WHOLE, among: int = 1) -> None:
        self.left, self.spent, self.among = whole // among, 0, among

    def steps(self, rows: int) -> int:
        """How many steps a programme may take with what is left."""
        return max(1, self.left // max(rows, 1))

    def pay(self, steps: int, rows: int) -> None:
        """Take what a programme has cost. Raises NotConverged where nothing is left."""
        cost = SETUP + steps * max(rows, 1)
        self.left, self.spent = self.left - cost, self.spent + cost
        if self.left <= 0:
            raise NotConverged(
                "the best law for this requirement takes more steps than are spent on one"
                + (f" of {self.among} of a cam" if self.among > 1 else "")
                + "; a narrower band, a velocity limit less or a looser jerk limit is found sooner"
            )


class _Rows:
    """Rows of inequalities, collected with their right sides."""

    def __init__(self, width: int) -> None:
        self.width = width
        self.blocks: list[Floats] = []
        self.sides: list[Floats] = []
        self.count = 0

    def add(self, block: Floats, side: Floats) -> slice:
        """Add rows; where they stand."""
        self.blocks.append(block)
        self.sides.append(side)
        self.count += len(side)
        return slice(self.count - len(side), self.count)

    def all(self) -> tuple[Floats, Floats]:
        """The matrix and the right side."""
        if not self.blocks:
            return np.zeros((0, self.width)), np.zeros(0)
        return np.vstack(self.blocks), np.concatenate(self.sides)


class Programme:
    """The rows of a task near a shape; `reach` is how far its inner breaks may move, 0 for not at all.

    stalled  whether moves are counted in reaches: one before has stalled, or this one has when it is solved
    """

    def __init__(
        self, task: Task, shape: Shape, cuts: Cuts, value: float, reach: float, stiff: Floats | None = None,
        stalled: bool = False,
    ) -> None:  # fmt: skip
        self.task, self.shape, self.cuts, self.value = task, shape, cuts, value
        self.reach, self.stiff, self.stalled = reach, stiff, stalled
        self.levels, self.moves = len(shape.a), len(shape.x) - 2 if reach > 0.0 else 0
        self.width = self.levels + self.moves + 1
        wish, x = task.wish, shape.x
        unit = np.eye(self.levels)
        rows = _Rows(self.width)
        limit = task.acceleration
        self.low, self.high = np.full(self.width, -np.inf), np.full(self.width, np.inf)
        self.low[-1] = 0.0
        if limit.asked and limit.slope == 0.0:
            self.low[: self.levels], self.high[: self.levels] = -limit.const, limit.const
        elif limit.asked:
            for sign in (1.0, -1.0):
                rows.add(self._wide(sign * unit, t=-limit.slope), np.full(self.levels, limit.const))
        self.jerk_rows: tuple[slice, slice] | None = None
        if shape.smooth:
            for i, (_, fixed) in ((0, wish.start), (-2, wish.end)):
                if fixed is not None:
                    at = i if i == 0 else self.levels - 1
                    self.low[at] = self.high[at] = fixed
            if task.jerk.asked:
                step = np.diff(unit, axis=0)
                now = task.jerk.at(value)
                above, below = (
                    rows.add(
                        self._wide(sign * step, -now * self._widening(), -task.jerk.slope * shape.h),
                        task.jerk.const * shape.h,
                    )
                    for sign in (1.0, -1.0)
                )
                self.jerk_rows = above, below
        self.places = np.empty(0)
        if task.velocity.asked or wish.monotone:
            self._add_velocity(rows)
        if len(cuts.n):
            pieces, kernel = cuts.rows(x, shape.smooth, wish.damping)
            block = self._linear(pieces, kernel)
            block[:, -1] -= task.residual.slope
            # The programme's own slack is of the size of its rows: the vibration, a small number, is written large.
            self.cut_rows = rows.add(LARGE * block, np.full(len(block), LARGE * task.residual.const))
        if self.moves:
            near = np.minimum(CLOSEST, 0.5 * shape.h)
            rows.add(self._wide(np.zeros((len(shape.h), self.levels)), -self._widening()), shape.h - near)
            self.low[self.levels : -1], self.high[self.levels : -1] = -reach, reach
        self.matrix, self.side = rows.all()
        pieces, kernel = moment_parts(x, shape.smooth), np.array([np.ones(len(x)), 1.0 - x])
        self.equal = self._linear(pieces, kernel)
        self.wanted = np.array(wish.moments)

    def _wide(self, levels: Floats, moves: Floats | None = None, t: Floats | float = 0.0) -> Floats:
        """Rows over all unknowns."""
        out = np.zeros((len(levels), self.width))
        out[:, : self.levels] = levels
        if self.moves and moves is not None:
            out[:, self.levels : -1] = moves
        out[:, -1] = t
        return out

    def _widening(self) -> Floats:
        """How each span widens as the inner breaks move (K, K - 1)."""
        count = len(self.shape.h)
        return np.asarray(np.eye(count)[:, :-1] - np.eye(count)[:, 1:])

    def _linear(self, pieces: Floats, kernel: Floats) -> Floats:
        """Functionals as rows over all unknowns, linear about the shape."""
        moves = slopes(self.shape, pieces, kernel) if self.moves else None
        return self._wide(np.asarray(pieces.sum(axis=1)), moves)

    def _add_velocity(self, rows: _Rows) -> None:
        wish, shape, limit = self.task.wish, self.shape, self.task.velocity
        self.places = np.concatenate([shape.x[1:-1], self.cuts.places])
        pieces = velocity_parts(shape.x, shape.smooth, self.places)
        kernel = (shape.x < self.places[:, None]).astype(float)
        block = self._linear(pieces, kernel)
        if not shape.smooth and self.moves:
            # The place is a break and moves with it, at the level before it.
            inner = np.arange(len(shape.x) - 2)
            block[inner, self.levels + inner] += shape.a[:-1]
        begun = wish.start[0]
        self.velocity_above = self.velocity_below = slice(0, 0)
        if limit.asked:
            upper = block.copy()
            upper[:, -1] -= limit.slope
            self.velocity_above = rows.add(upper, np.full(len(block), limit.const - begun))
        if wish.monotone:
            self.velocity_below = rows.add(-block, np.full(len(block), begun))
        elif limit.asked and self.cuts.dips:
            lower = -block
            lower[:, -1] -= limit.slope
            self.velocity_below = rows.add(lower, np.full(len(block), limit.const + begun))

    def solve(self, purse: SearchPurse) -> Solved | None:
        """The best shape and its multipliers; None where the rows leave none, or the solver finds none in its steps.

        Raises NotConverged on an empty purse.
        """
        if not self.stalled:
            answer = self._answer(1.0, FEW if self.moves else STEPS, purse)
            self.stalled = self.moves > 0 and answer.status in STALLED
        if self.stalled:
            # Moves as small as the solver's tolerance: the simplex method steps about one corner for minutes. Counted
            # in reaches they are of the size of the other unknowns, though the trifle that each costs counts less.
            answer = self._answer(self.reach, STEPS, purse)
        if answer.x is None or not answer.success:
            return None
        worth = -answer.ineqlin.marginals if len(self.side) else np.empty(0)
        return self.solved(answer.x, worth, answer.eqlin.marginals, float(answer.x[self.width - 1]))

    def _answer(self, unit: float, steps: int, purse: SearchPurse) -> Any:
        """What the solver says, the moves in the unknowns counted in a unit, and given back without it."""
        from scipy.optimize import linprog

        cost = np.zeros(self.width)
        cost[-1] = 1.0
        matrix, equal, low, high = self.matrix, self.equal, self.low, self.high
        if self.moves:
            # What a move costs of the second order, as a row of straight pieces forth and back; and each costs a
            # trifle, so that breaks that gain nothing stay.
            moves = slice(self.levels, self.levels + self.moves)
            stiff = np.zeros(self.moves) if self.stiff is None else self.stiff
            paces = PACES if self.stiff is not None else PACES[[0, -1]]
            pieces = [np.diff(paces) * self.reach / unit, 0.5 * (paces[1:] + paces[:-1]) * self.reach]
            for sign in (unit, -unit):
                for width, middle in zip(*pieces, strict=True):
                    matrix, equal = (
                        np.hstack([rows, sign * own[:, moves]])
                        for rows, own in ((matrix, self.matrix), (equal, self.equal))
                    )
                    cost = np.concatenate([cost, unit * (stiff * middle + STILL * self.value)])
                    low = np.concatenate([low, np.zeros(self.moves)])
                    high = np.concatenate([high, np.full(self.moves, width)])
            low = low.copy()
            low[moves] = 0.0
            high = high.copy()
            high[moves] = 0.0
        limits = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10, "presolve": False,
                  "maxiter": min(steps * (len(self.side) + len(cost)), purse.steps(len(self.side)))}  # fmt: skip

        def answered(scale: Floats) -> Any:
            return linprog(  # type: ignore[call-overload]
                cost * scale,
                A_ub=matrix * scale if len(self.side) else None,
                b_ub=self.side if len(self.side) else None,
                A_eq=equal * scale,
                b_eq=self.wanted,
                bounds=np.column_stack([low, high]) / scale[:, None],
                method="highs",
                options=limits,
            )

        answer = answered(np.ones(len(cost)))
        if answer.status == LOST and not self.moves:
            # Unknowns of sizes far apart: once more, each counted by its largest coefficient.
            large = np.abs(np.vstack([matrix, equal])).max(axis=0)
            scale = 1.0 / np.where(large > 0.0, large, 1.0)
            answer = answered(scale)
            if answer.x is not None:
                answer.x = answer.x * scale
        purse.pay(int(answer.nit), len(self.side))
        if answer.x is not None:
            answer.x[self.width :] *= unit
        return answer

    def solved(self, unknowns: Floats, worth: Floats, moments: Floats, value: float) -> Solved:
        """The shape and the multipliers that unknowns and worths of rows stand for."""
        shape = self.shape
        x = shape.x.copy()
        if self.moves:
            forth, back = unknowns[self.width :].reshape(2, -1, self.moves).sum(axis=1)
            x[1:-1] += forth - back
        none = np.zeros(len(self.places))
        above = below = none
        if len(self.places):
            if self.task.velocity.asked:
                above = worth[self.velocity_above]
            if self.velocity_below.stop:
                below = worth[self.velocity_below]
        jerk = np.zeros(len(shape.h))
        if self.jerk_rows is not None:
            jerk = worth[self.jerk_rows[0]] - worth[self.jerk_rows[1]]
        cut = LARGE * worth[self.cut_rows] if len(self.cuts.n) else np.empty(0)
        found = Multipliers(np.asarray(moments), self.cuts, cut, self.places, above, below, jerk)
        return Solved(Shape(x, unknowns[: self.levels]), value, found)


def stiffness(task: Task, shape: Shape, m: Multipliers) -> Floats:
    """How the Lagrangian curves as the inner breaks move (K - 1,): where its kernels g meet a change of slope."""
    g = m.moments @ np.array([np.ones(len(shape.x)), 1.0 - shape.x])
    g = g - (shape.x[:, None] < m.places) @ (m.above - m.below)
    if len(m.cuts.n):
        g = g - m.cut @ m.cuts.rows(shape.x, shape.smooth, task.wish.damping)[1]
    if shape.smooth:
        return np.asarray(np.maximum(0.0, -np.diff(shape.jerk) * g[1:-1]))
    rise = np.full(len(shape.x), -m.moments[1])
    if len(m.cuts.n):
        k, damped = decay(m.cuts.n, task.wish.damping)
        at = np.exp(-k[:, None] * (1.0 - shape.x)) * (k / damped)[:, None]
        rise = rise - m.cut @ (at * np.exp(-1j * m.cuts.angle)[:, None]).real
    return np.asarray(np.maximum(0.0, np.diff(shape.a) * rise[1:-1]))
