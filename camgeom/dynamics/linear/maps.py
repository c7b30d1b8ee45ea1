"""One-step maps of any method: which module forms them, and in which parts."""

from __future__ import annotations

import numpy as np

from camgeom.dynamics.linear import collocated as integrators_collocated
from camgeom.dynamics.linear import magnus as integrators_magnus
from camgeom.dynamics.linear import runge_kutta as integrators_runge_kutta
from camgeom.dynamics.linear import split as integrators_split
from camgeom.dynamics.linear.method import WORK_SET, Collocated, Method, RungeKutta, System
from camgeom.errors import NotConverged
from camgeom.maths import Floats


def step_maps(method: Method, system: System, start: Floats, step: Floats) -> Floats:
    """Affine one-step maps [P | r] (b, n, r, r + 1) for steps (n,) or (b, n) rad long from cam angles start, same
    shape.

    A step must not straddle a knot of the motion. Formed in parts of `WORK_SET` so that memory stays bounded. Raises
    NotConverged where the equations of a step are singular to working precision.
    """
    try:
        return _step_maps(method, system, start, step)
    except np.linalg.LinAlgError:
        raise NotConverged(
            f"the equations of a step of {method.name} are singular to working precision: the fastest mode is too many "
            "times as fast as the cam; take a higher speed, or leave out the stiffest member"
        ) from None


def _step_maps(method: Method, system: System, start: Floats, step: Floats) -> Floats:
    start, step = np.atleast_2d(start), np.atleast_2d(step)
    if isinstance(method, RungeKutta):
        found = integrators_split.step_maps(method, system, start, step)
        if found is not None:
            return found
    size, count = method.rows * system.size, start.shape[1]
    out = np.empty((system.batch, count, size, size + 1))
    stages = len(method.b) if isinstance(method, RungeKutta) else 2
    part = max(1, 4 * WORK_SET // (stages * system.batch))
    for low in range(0, count, part):
        cut = slice(low, low + part)
        if isinstance(method, Collocated):
            out[:, cut] = integrators_collocated.maps(method, system, start[:, cut], step[:, cut])
        elif isinstance(method, RungeKutta):
            out[:, cut] = integrators_runge_kutta.maps(method, system, start[:, cut], step[:, cut])
        else:
            out[:, cut] = integrators_magnus.maps(method, system, start[:, cut], step[:, cut])
    return out
