"""A model's curves as arrays for programs: motion, pitch curve, profile, flank; mm and rad in the cam frame."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.errors import CamgeomError, DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import frozen
from camgeom.track import TURN, Track

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.track.flank import Flank

PER_TURN = 721
"""cam angles from 0 to 2 pi where none are given"""


@final
@immutable
class MotionArrays:
    """The follower's motion at cam angles theta (n,), rad.

    s, v, a, j  position and its derivatives per rad of cam angle (n,): mm, mm/rad, mm/rad2, mm/rad3; of a swinging
                follower or a turret rad, 1, 1/rad, 1/rad2. At a cam speed of omega rad/s the velocity is omega v, the
                acceleration omega^2 a, the jerk omega^3 j. Where one jumps, its right-hand limit.
    """

    theta: Floats
    s: Floats
    v: Floats
    a: Floats
    j: Floats


def angles(theta: Any) -> Floats:
    """Cam angles (n,), rad: those given, or 721 from 0 to 2 pi."""
    if theta is None:
        return np.linspace(0.0, TURN, PER_TURN)
    return np.atleast_1d(np.asarray(theta, dtype=float)).ravel()


def motion(model: Model, theta: Any) -> MotionArrays:
    """See `Model.motion`."""
    at = angles(theta)
    found: MotionArrays = frozen(MotionArrays(at, *model.setup.program.jet(at, 3)))
    return found


def numbered(model: Model, number: int) -> Track:
    """A roller track by its number. Raises DesignError where there is none of it."""
    if not 0 <= number < len(model.tracks):
        none = f"a {model.setup.follower.kind} follower without a roller has no track"
        some = f"there is no track {number}: the cam has tracks 0 to {len(model.tracks) - 1}"
        raise DesignError(some if model.tracks else none)
    return model.tracks[number]


def pitch_curve(model: Model, theta: Any, track: int) -> Floats:
    """See `Model.pitch_curve`."""
    chosen = numbered(model, track)
    at = np.linspace(*chosen.span, PER_TURN) if theta is None else angles(theta)
    pose = chosen.pose(at, 0)
    found: Floats = frozen(np.ascontiguousarray((pose.a[0] + 0.5 * sum(chosen.contact) * pose.u[0]).T))
    return found


def outline(model: Model, theta: Any, touch: int) -> Floats:
    """See `Model.outline`."""
    if model.planar is None:
        raise DesignError("the profile of this cam is no plane curve: ask for its flank")
    touches = model.planar.touches
    if not 0 <= touch < len(touches):
        raise DesignError(f"there is no touch {touch}: the cam has touches 0 to {len(touches) - 1}")
    found: Floats = frozen(np.ascontiguousarray(touches[touch].outline.curve(angles(theta)).points.T))
    return found


def flank(model: Model, side: float | None, theta: Any, stations: int, track: int) -> Flank:
    """See `Model.flank`."""
    from camgeom.track.flank import Flank

    chosen = model.mechanism.cutting(numbered(model, track))
    way = chosen.sides[0] if side is None else float(side)
    if way not in chosen.sides:
        allowed = " or ".join(f"{one:+g}" for one in chosen.sides)
        raise DesignError(f"the track has no flank on the side {way:+g}; it has {allowed}")
    at = np.linspace(*chosen.span, PER_TURN) if theta is None else angles(theta)
    ends = [chosen.meridian.parameter(end) for end in chosen.contact]
    return Flank(chosen, at, np.linspace(min(ends), max(ends), stations), way)


def plot(model: Model, axes: Any) -> Any:
    """See `Model.plot`."""
    try:
        from matplotlib import pyplot
    except ImportError:
        raise CamgeomError("a plot needs matplotlib: pip install matplotlib") from None
    omega = model.profile.operation.speed * TURN / 60.0 if model.profile.operation is not None else 1.0
    unit, timed = ("rad" if model.profile.rotating else "mm"), model.profile.operation is not None
    per = ["", "/s", "/s²", "/s³"] if timed else ["", "/rad", "/rad²", "/rad³"]
    if axes is None:
        _, axes = pyplot.subplots(4, 1, sharex=True, figsize=(7.0, 8.0), layout="constrained")
    theta = np.linspace(0.0, TURN, PER_TURN)
    rows = zip(("position", "velocity", "acceleration", "jerk"), per, model.setup.program.jet(theta, 3))
    for order, (axis, (word, under, values)) in enumerate(zip(np.ravel(axes), rows)):
        axis.plot(np.degrees(theta), omega**order * values, label=model.profile.name)
        axis.set_ylabel(f"{word}, {unit}{under}")
        axis.set_xlim(0.0, 360.0)
        axis.grid(visible=True, alpha=0.3)
    np.ravel(axes)[-1].set_xlabel("cam angle, °")
    return axes
