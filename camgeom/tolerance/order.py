"""How far the first order holds: what errors of their size leave beside it, and where that is too much.

A roller's centre that errors and the follower's own answer move by t across its line, beside the normal, leaves the
tangent of the pitch curve by

    k t^2 / 2,      k = |1 / r - 1 / (r^2 k_rel)| + 1 / R          (second order)

with the roller's radius r, the relative curvature k_rel of cam and roller and the distance R from the cam's axis, about
which the cam itself may turn (a plate: what its drive's second derivative and its own turns leave beside the first
order is added); the first term is the curvature of the pitch curve, of a knife edge that of the profile.
A flat face that tilts by d leaves its cam by d^2 / (2 k_rel). All errors count at their ends at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import DesignError
from camgeom.maths import Floats
from camgeom.maths.surface import cross, dot
from camgeom.solid.mechanism import Mechanism
from camgeom.tolerance.causes import NORMAL, Approaches, Cause, Pivots
from camgeom.tolerance.contacts import Contacts, moment
from camgeom.track import Swing

if TYPE_CHECKING:
    from camgeom.tolerance.samples import Spreads
    from camgeom.tolerance.sensitivity import Seated

MOST = 0.1
"""share of the largest deviation that the second order may be"""
LITTLE = 1e-6
"""mm of the second order that are rounding, whatever the first is"""
DRIVING = 0.3
"""share of the largest lever at a cam angle from which a station says where the follower stands"""


def refuse_beyond(seated: Seated, causes: tuple[Cause, ...], spreads: Spreads, curve: Floats) -> None:
    """Raise DesignError where errors are too large to be told by their first order.

    curve  largest deviation by the first order with all errors at their ends, mm or rad, (n,)
    """
    if not causes or not curve.max() > 0.0:
        return
    left, key = second_order(seated, causes, spreads, curve)
    if left <= max(MOST * float(curve.max()), LITTLE / seated.of.arm):
        return
    of = seated.of
    value, told = of.shown(left), of.shown(float(curve.max()))
    raise DesignError(
        f"errors this large are not told by their first order: the second leaves {value:.3g} {of.unit} beside "
        f"{told:.3g} {of.unit}, at most {MOST:.0%} may be left; tighten tolerance.{key}, which moves contacts farthest"
    )


def second_order(seated: Seated, causes: tuple[Cause, ...], spreads: Spreads, curve: Floats) -> tuple[float, str]:
    """What the first order leaves at most, mm or rad of the joint coordinate, and the error with the largest part."""
    at = seated.contacts
    tilts = {cause: abs(spreads[cause.key][0]) + spreads[cause.key][1] for cause in causes if cause.unit != "mm"}
    mean = np.zeros(at.on.shape)
    lever = np.where(at.on, np.abs(at.lever), 0.0)
    drives = at.on & (lever >= DRIVING * lever.max(axis=(1, 2), keepdims=True))
    if not drives.any():
        return 0.0, causes[0].key
    if np.isinf(at.radius):
        parts = {cause: np.full(at.on.shape, tilt) for cause, tilt in tilts.items()}
        own = curve if isinstance(at.joint, Swing) else np.zeros(len(curve))
        bend = 1.0 / np.maximum(np.abs(at.curvature), 1e-12)
    else:
        across = _across(at)
        beside = Approaches(across, seated.of.pivots)
        parts = {}
        for cause in causes:
            if cause.key not in NORMAL:
                part = beside.of(cause)
                parts[cause] = np.sqrt((part * part).sum(axis=0)) * spreads[cause.key][1]
                mean = mean + part[0] * spreads[cause.key][0]
        own = np.ones(len(curve))[:, None, None] * np.abs(across.lever) * curve[:, None, None]
        bend = _pitch_curvature(at)
        if at.mechanism.carriage is None:
            bend = bend + 1.0 / np.maximum(np.hypot(at.x[0], at.x[1]), 1e-12)
    moved = sum(parts.values(), np.abs(mean) + (own if own.ndim == 3 else own[:, None, None]))
    beyond = 0.5 * bend * moved**2 + _slid(at, seated.of.pivots, tilts)
    left = np.where(drives, beyond / np.where(drives, lever, 1.0), 0.0)
    worst = np.unravel_index(int(np.argmax(left)), left.shape)
    largest = max(parts, key=lambda cause: float(parts[cause][worst])) if parts else causes[0]
    return float(left[worst]), largest.key


def _slid(at: Contacts, pivots: Pivots, tilts: Mapping[Cause, float]) -> Floats:
    """Second order, mm, (n, l, m), of a plate whose drive is ahead and that turns about its pivots, by rad; else 0."""
    left, carriage = np.zeros(at.on.shape), at.mechanism.carriage
    if carriage is None:
        return left
    travel, _, bend = carriage.rates(at.theta)
    away = at.x - np.array(pivots.axes)[:, None, None, None]
    far = np.sqrt(dot(away, away)) + travel[:, None, None]
    for cause, angle in tilts.items():
        if cause.key == "phase_arcmin":
            left += 0.5 * angle**2 * np.abs(bend[:, None, None] * at.normal[0])
        elif cause.holder in ("machine", "cam"):
            left += 0.5 * angle**2 * far
    return left


def _across(at: Contacts) -> Contacts:
    """The contacts with the direction across their lines, beside the normal, in the normal's place."""
    axis = np.broadcast_to(at.axis[..., None], at.normal.shape)
    beside = cross(axis, at.normal)
    length = np.sqrt(dot(beside, beside))
    beside = beside / np.where(length > 0.0, length, 1.0)
    turned = replace(at, normal=np.asarray(beside))
    if isinstance(at.joint, Swing):
        lever = -np.tensordot(np.array(at.joint.axis), moment(turned, np.array(at.joint.centre)), 1)
    else:
        lever = np.tensordot(np.array(at.joint.direction), beside, 1)
    return replace(turned, lever=np.asarray(lever))


def _pitch_curvature(at: Contacts) -> Floats:
    """Curvature of the path of the roller's centre on the cam, 1/mm, (n, l, m); of a knife edge of the profile."""
    if at.radius == 0.0:
        return _profile_curvature(at.mechanism, at.theta)[..., None]
    relative = np.where(np.abs(at.curvature) > 1e-12, at.curvature, 1e-12)
    return np.asarray(np.abs(1.0 / at.radius - 1.0 / (at.radius**2 * relative)))


def _profile_curvature(mechanism: Mechanism, theta: Floats) -> Floats:
    """Curvature of the profile below a knife edge, 1/mm, (n, l)."""
    return np.stack([np.abs(touch.at(theta).curve.curvature) for touch in mechanism.touches], axis=1)
