"""What the errors' tilt of a roller against its flank does at its ends, where the load is hardest.

Every error turns the line of contact by the slope of its approaches along the roller; that of all of them at their
tolerances is the root of the sum of squares, beside the sum of their means. Under that tilt and the load of the roller
the contact is solved on a half-space (`mechanics.finite_contact`), with the roller's own ends. A sharp end that bears
has no largest pressure.
"""

from __future__ import annotations

from math import inf, tan
from typing import TYPE_CHECKING, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.mechanics.finite_contact import AxialProfile, Bodies, press
from camgeom.mechanics.material import pair_compliance
from camgeom.tolerance.contacts import WEIGHTS

if TYPE_CHECKING:
    from camgeom.tolerance.study import ToleranceStudy


@final
@immutable(eq=True)
class Edge:
    """The hardest pressed roller, tilted: angle, rad, load, N, pressures, MPa, level and tilted, at a cam angle, rad.

    unbounded  True where a sharp end bears: `tilted` is that half a millimetre inside of it, a bound and no peak
    """

    tilt: float
    load: float
    level: float
    tilted: float
    unbounded: bool
    cam_angle: float


def edge_of(study: ToleranceStudy) -> Edge | None:
    """The pressure that the tilt of all errors brings; None without a load, or where no roller bears along a line."""
    loaded, peak = study.loaded, study.sensitivities.hard
    rollers = loaded.mechanism.rollers
    if peak is None or not rollers:
        return None
    seated = loaded.at(np.array([peak.cam_angle]))
    at, shape = seated.contacts, seated.contacts.on.shape
    force = seated.walls.forces(np.zeros(seated.walls.lever.shape)).reshape(shape)[0]
    line = int(np.argmax(force.sum(axis=1)))
    load, length = float(force[line].sum()), float(at.length[0, line].sum())
    away = at.x[:, 0, line] - at.centre[:, 0, line, None]
    along = (away * at.axis[:, 0, line, None]).sum(axis=0)
    pull = at.lever[0] * seated.walls.stiffness.reshape(shape)[0] * (force > 0.0)
    weight = -pull / (pull * at.lever[0]).sum()
    square = constant = 0.0
    for cause in study.causes:
        mean, value, _ = study.spreads[cause.key]
        for g in seated.approaches.of(cause)[:, 0]:
            if cause.holder == "roller":
                g = g * (at.roller == at.roller[line])[:, None]
            # What the follower gives way to tilts nothing.
            tilted_by = slope(g[line] + at.lever[0, line] * (weight * g).sum(), along)
            square += (value * tilted_by) ** 2
            constant += mean * tilted_by
    tilt = abs(constant) + float(np.sqrt(square))
    pair, ends = pair_compliance(loaded.roller, loaded.cam), rollers[min(at.roller[line], len(rollers) - 1)].ends
    middle = 0.5 * (along.min() + along.max())
    low, high = float(along.min() - middle), float(along.max() - middle)
    profile = AxialProfile(low, high, inf, ends.run_out, ends.radius, length)
    curvature = float(at.curvature[0, line].mean())
    level, tilted = (
        press(Bodies(curvature, profile, pair, gap, 0.0, loaded.roller.compliance / pair, float(ends.mirrored)), load)
        for gap in (tan(ends.tilt), tan(abs(ends.tilt) + tilt))
    )
    return Edge(tilt, load, level.peak[0], tilted.peak[0], tilted.unbounded, peak.cam_angle)


def slope(approach: Floats, along: Floats) -> float:
    """Slope of approaches (m,) along a roller, 1: least squares with the weights of the stations."""
    off = along - np.average(along, weights=WEIGHTS)
    square = float((WEIGHTS * off * off).sum())
    return float((WEIGHTS * off * approach).sum()) / square if square > 0.0 else 0.0


