"""What a solution will cost, known before it starts; one that would cost too much is refused with the number.

Bytes are counted from the arrays that stay. Seconds are those of one core of a machine of 2020, measured once per kind
of step (docs/benchmarks.md): they decide what is begun, not what is found.
"""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from typing import Any, Generic, TypeVar, final

import numpy as np

from camgeom.dynamics.linear.method import Collocated, Method, System
from camgeom.errors import NotConverged
from camgeom.maths import within_range
from camgeom.maths.frozen import frozen

T = TypeVar("T")

MOST_BYTES = 1e9
"""of one solution"""
MOST_SECONDS = 4.0
"""of one solution; an elastic drive or follower takes about ten times as long for all of its figures"""
MOST_TOGETHER = 16.0
"""of one solution of each of all followers and operating states"""
MOST_SWEEP_SECONDS = 15.0
"""of a sweep"""
VERIFIED = 1.5
"""steps of a solution and of the one with half as many that it is measured by, over its own"""
PER_STEP = 1.8e-5
"""s a step, linear, where a contact varies alone or the method is of the Newmark family"""
PER_ENTRY = 7e-9
"""s for each entry of the cube of a step's matrix, stages times coordinates wide; the dozen passes that a non-linear
contact usually takes are in it"""


def step_cost(system: System, method: Method) -> tuple[float, float]:
    """Seconds and bytes for one step at one speed."""
    m = system.size
    kept = 8.0 * (3 * method.rows * m + 21)
    if isinstance(method, Collocated):
        return PER_STEP, kept
    wide = m * len(method.b)
    apart = system.linear and system.coefficients(np.zeros((1, 1))).contact is not None and method.c[-1] < 1.0
    seconds = PER_STEP if apart else PER_STEP + PER_ENTRY * wide**3
    return seconds, kept if system.linear else kept + 8.0 * (wide * wide + wide * (2 * m + 1) + 4 * m * (m + 1))


def refuse_costly(
    system: System, method: Method, steps: float, most: float = MOST_SECONDS, runs: int = 1, bytes_: float = MOST_BYTES
) -> None:
    """Raise NotConverged where so many steps, over all speeds together, would take too long or too much memory.

    most, bytes_  s and bytes that this solution may take
    runs          solutions like this one that a design asks for
    """
    each, kept = step_cost(system, method)
    seconds, size = VERIFIED * each * steps, VERIFIED * kept * steps
    if seconds <= most and size <= bytes_:
        return
    less = "" if system.linear else "exact_contact = false, "
    shared = f" on each of {runs} followers and operating states: fewer of them, " if runs > 1 else ": "
    memory = (f" and {size / 1e9:.2g} GB", f" and {bytes_ / 1e9:.2g} GB") if bytes_ < inf else ("", "")
    raise NotConverged(
        f"{steps:.3g} steps of {method.name} would take about {seconds:.3g} s{memory[0]}, more than the "
        f"{most:.3g} s{memory[1]} that are spent{shared}{less}a larger dynamics.tolerance, a higher "
        "speed or fewer sweep_points need fewer; a drive whose modes are thousands of times as fast as its cam moves "
        "as a rigid one does, and needs no [dynamics]"
    )


@final
class Purse:
    """What a sweep may still spend on its groups of speeds: those that are tried again in parts pay again."""

    def __init__(self, seconds: float = MOST_SWEEP_SECONDS) -> None:
        self._seconds = self._left = seconds

    def pay(self, system: System, method: Method, steps: float) -> None:
        """Take the cost of so many steps, over all speeds together. Raises NotConverged where it is not left."""
        self._left -= step_cost(system, method)[0] * steps
        if self._left < 0.0:
            raise NotConverged(
                f"the {self._seconds:.3g} s of the sweep are spent on speeds that are hard to solve: fewer "
                "sweep_points, a range away from resonances, or damping"
            )


@final
class sought(Generic[T]):
    """A cached property that keeps its refusal too: an answer that was not found is not sought again."""

    def __init__(self, compute: Callable[[Any], T]) -> None:
        self._compute = compute
        self._name = compute.__name__
        self.__doc__ = compute.__doc__

    def __get__(self, instance: object, owner: type | None = None) -> T:
        """The answer; NotConverged as the first time."""
        refusal = f"refusal of {self._name}"
        if refusal in vars(instance):
            kind, text, said = vars(instance)[refusal]
            raise _again(kind, text, said)
        try:
            with within_range(self._name.replace("_", " ")):
                answer = frozen(self._compute(instance))
        except NotConverged as error:
            vars(instance)[refusal] = (type(error), str(error), dict(vars(error)))
            raise
        vars(instance)[self._name] = answer
        return answer


def _again(kind: type[NotConverged], text: str, said: dict[str, Any]) -> NotConverged:
    """A refusal as it was, without the arrays that its traceback would keep."""
    error = kind.__new__(kind, text)
    vars(error).update(said)
    return error
