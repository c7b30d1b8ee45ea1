"""How exact and by which method: the one place where a wanted tolerance becomes a verified solution."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from camgeom.dynamics.linear.choice import choose
from camgeom.dynamics.linear.method import INTEGRATORS, Magnus, Method, RungeKutta, System, find
from camgeom.dynamics.linear.solution import Solution
from camgeom.dynamics.linear.solve import Watch, verified
from camgeom.dynamics.linear.walk import MAX_STEPS, Grid, aligned_grid
from camgeom.errors import Problem, ProfileError
from camgeom.maths import Floats

Once = Callable[[Grid, Method], Solution]
"""A solution on a grid by a method."""


@dataclass(frozen=True)
class Accuracy:
    """Tolerance as a share of the peak, checked by halving the step; method by name or "auto".

    `steps` fixes the steps a turn instead: then nothing is checked and the error is unknown.
    """

    tolerance: float = 1e-6
    method: str | Method = "auto"
    steps: int | None = None

    def __post_init__(self) -> None:
        problems = []
        if not 1e-13 <= self.tolerance <= 0.1:
            problems.append(Problem("dynamics.tolerance", "out of range", self.tolerance, "1e-13 to 0.1"))
        if self.steps is not None and not 1 <= self.steps <= MAX_STEPS:
            problems.append(Problem("dynamics.steps", "out of range", self.steps, f"1 to {MAX_STEPS}"))
        if problems:
            raise ProfileError(problems)
        if self.method != "auto":
            find(self.method)

    def fixed(self) -> Method:
        """The method for a fixed number of steps: gauss4 for "auto"."""
        return find("gauss4" if self.method == "auto" else self.method)


STANDARD = Accuracy()
"""1e-6 of the peak, by the cheapest method"""


def pool(system: System, accuracy: Accuracy) -> tuple[Method, ...]:
    """The methods that "auto" may take: a non-linear correction needs implicit Gauss stages."""
    if accuracy.method != "auto":
        return (find(accuracy.method),)
    if system.linear:
        return tuple(one for one in INTEGRATORS.values() if system.smooth or not isinstance(one, Magnus))
    return tuple(one for one in INTEGRATORS.values() if isinstance(one, RungeKutta) and not one.explicit)


def solved(system: System, knots: Floats, accuracy: Accuracy, once: Once, watch: Watch) -> Solution:
    """A solution verified by halving, or one with the given number of steps; one method and grid for all speeds."""
    if accuracy.steps is not None:
        return once(aligned_grid(knots, accuracy.steps), accuracy.fixed())
    methods, steps = choose(system, knots, accuracy.tolerance, pool(system, accuracy))
    worst = int(np.argmax(steps))
    grid = aligned_grid(knots, round(float(steps[worst])))
    return verified(lambda g: once(g, methods[worst]), grid, accuracy.tolerance, watch)
