"""What acts on the follower along its motion, part by part: inertia, friction, spring and weight, applied forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Chart, Panel, Series
from camgeom.maths import Floats
from camgeom.report.sections.motion import extremes, over_turn, zones

if TYPE_CHECKING:
    from camgeom.model import Model

NOTHING = 1e-12
"""share of the largest part below which a part is none"""


def along(model: Model) -> tuple[Chart, ...]:
    """The parts of the force (N) or torque (N m) that the follower needs, and their sum; none without a load."""
    bearing = model.drive or model.carrier
    if bearing is None:
        return ()
    force, demand, rotating = bearing.force, model.load.demand, model.profile.rotating
    panels, jet = force.panels, (force.lift, force.ds, force.dds)
    applied = sum((demand.of(one, panels.theta, jet) for one in demand.applied), np.zeros(force.lift.shape))
    parts: dict[str, Floats] = {
        "inertia": force.inertia,
        "friction": demand.friction * force.direction,
        "spring and weight": demand.preload + demand.weight + demand.rate * force.lift,
        "applied": applied,
        "sum": force.force,
    }
    whole = {name: np.broadcast_to(values, force.lift.shape) for name, values in parts.items()}
    largest = max(float(np.abs(values).max()) for values in whole.values())
    if largest == 0.0:
        return ()
    factor, axis = (1e-3, Axis("Torque", "N m", zero=True)) if rotating else (1.0, Axis("Force", "N", zero=True))
    lines = []
    for name, values in whole.items():
        if float(np.abs(values).max()) > NOTHING * largest:
            x, y = over_turn(panels, factor * values)
            lines.append(Series(name, x, y))
    panel = Panel(axis, tuple(lines), marks=extremes(panels, force.force, factor), height=1.4)
    what = "torque about its axis" if rotating else "force along its motion"
    return (Chart(f"What the follower needs: {what}, part by part", CAM_ANGLE, (panel,),
                  zones(model.setup.program)),)  # fmt: skip
