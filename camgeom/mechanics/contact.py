"""Roller on cam over one turn: the squared peak pressure of either wall, from which stress peaks and lives follow.

The square of the peak pressure of a line contact, w k_rel / (pi compliance), is a smooth function of the cam angle,
also where the load changes walls: it is kept with the sign of the load, positive where that wall is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from camgeom.maths import Floats
from camgeom.mechanics import curvature
from camgeom.mechanics.load import FollowerForce
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.mechanics.panels import Panels, highest


@final
@dataclass(frozen=True, eq=False)
class Contact:
    """Contact of one roller with its two walls over one turn.

    normal: signed normal force, N, positive on the wall behind; behind, ahead: squared peak pressure of that wall,
    MPa², positive where it is loaded; path_rate: path rolled per cam angle, mm/rad; all (..., p, n). sound: (...) False
    where the roller undercuts, anywhere, a wall that it loads: there both squares are 0 and no stress can be given.
    """

    panels: Panels
    normal: Floats
    behind: Floats
    ahead: Floats
    path_rate: Floats
    sound: NDArray[np.bool_]

    @property
    def pressure(self) -> Floats:
        """Peak pressure of the loaded wall at the sample points, MPa, (..., p, n)."""
        return np.asarray(np.sqrt(np.maximum(np.maximum(self.behind, self.ahead), 0.0)))

    @property
    def resolution(self) -> float:
        """Largest error of interpolation over the loaded panels, share of the largest squared pressure."""
        return float(self._tail().max(initial=0.0))

    def _tail(self) -> Floats:
        """That error per panel, (p,); a wall counts only in panels where it is loaded."""
        walls = np.stack([self.behind, self.ahead]).reshape(-1, *self.behind.shape[-2:])
        return self.panels.tail(np.where((walls > 0.0).any(axis=-1, keepdims=True), walls, 0.0))

    def split(self, tolerance: float) -> Panels | None:
        """Panels halved where the error exceeds the tolerance; None where none does."""
        coarse = self._tail() > tolerance
        if not coarse.any():
            return None
        edges = np.concatenate([self.panels.edges, self.panels.middle[coarse]])
        return Panels(np.sort(edges), self.panels.breaks)

    def peak(self) -> Peak:
        """Largest peak pressure over the turn and where; infinite for a variant that is not sound."""
        value = np.stack([self.behind, self.ahead])
        square, angle = highest(self.panels, value)
        wall = np.argmax(square, axis=0)
        best = np.take_along_axis(square, wall[None], axis=0)[0]
        where = np.take_along_axis(angle, wall[None], axis=0)[0]
        pressure = np.where(self.sound, np.sqrt(np.maximum(best, 0.0)), np.inf)
        return Peak(np.asarray(pressure), np.asarray(where), np.asarray(1 - 2 * wall))


@final
@dataclass(frozen=True, eq=False)
class Peak:
    """Largest peak pressure, MPa, its cam angle, rad, and its wall (1 behind, -1 ahead); each (...)."""

    pressure: Floats
    theta: Floats
    wall: NDArray[np.intp]


def line_contacts(where: Panels, normal: ArrayLike, behind: ArrayLike, ahead: ArrayLike, path_rate: ArrayLike,
                  length: ArrayLike, compliance: ArrayLike,
                  margins: tuple[ArrayLike, ArrayLike] | None = None) -> Contact:
    """Contact from signed normal force (N), relative curvatures of both walls (1/mm) and path rate (mm/rad).

    Arrays (..., p, n); length of contact (mm) and compliance (1/MPa) broadcast as they are, so variants of them are
    (..., 1, 1). To follow slices along the roller, give the slice's force and length on a leading axis of stations m.
    margins: undercut margins of both walls (1), smooth where the curvature has a pole; without them the curvature's
    sign at the sample points decides whether the roller fits.
    """
    force = np.asarray(normal, dtype=np.float64)
    near, far = np.asarray(behind, dtype=np.float64), np.asarray(ahead, dtype=np.float64)
    scale = force / (np.asarray(length, dtype=np.float64) * np.pi * np.asarray(compliance, dtype=np.float64))
    sound = _free(near, force > 0.0) & _free(far, force < 0.0)
    if margins is not None:
        one, two = (np.asarray(margin, dtype=np.float64) for margin in margins)
        sound = sound & _free(-highest(where, -one)[0][..., None, None], force > 0.0)
        sound = sound & _free(-highest(where, -two)[0][..., None, None], force < 0.0)
    good = sound[..., None, None]
    one, two, rate, good = np.broadcast_arrays(scale * near, -scale * far,
                                               np.asarray(path_rate, dtype=np.float64), good)
    sound = np.broadcast_to(sound, one.shape[:-2])
    return Contact(where, np.broadcast_to(force, one.shape), np.where(good, one, 0.0), np.where(good, two, 0.0), rate,
                   sound)


def _free(margin: Floats, loaded: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a wall has positive margins (..., p, n) all round, or never carries a load: (...)."""
    return np.asarray((margin > 0.0).all(axis=(-1, -2)) | ~loaded.any(axis=(-1, -2)))


def resolved_contact(build: Callable[[Panels], Contact], start: Panels, tolerance: float = 1e-9,
                     rounds: int = 8) -> Contact:
    """The contact on panels halved until it is resolved to the tolerance (share of the largest squared pressure).

    build: makes the contact on given panels, for example from the flank's curvatures there. What a kink inside a panel
    leaves after `rounds` is in `Contact.resolution`.
    """
    contact = build(start)
    for _ in range(rounds):
        finer = contact.split(tolerance)
        if finer is None:
            break
        contact = build(finer)
    return contact


def groove_contact(load: FollowerForce, pitch_radius: ArrayLike, roller_radius: ArrayLike, length: ArrayLike,
                   roller: Material, cam: Material, convention: curvature.Convention = "exact",
                   guide_friction: ArrayLike = 0.0) -> Contact:
    """Contact of a roller in a cylindrical groove, follower translating along the axis; radii and length in mm.

    Any of the numbers may be an array of variants (...), of the shape of the load's variants or broadcast with it.
    Force, curvature and rolling path are taken at the pitch radius; see `curvature.CONVENTIONS`.
    """
    big, small, long = (_column(x) for x in (pitch_radius, roller_radius, length))
    normal = load.normal(curvature.cos_pressure_angle(big, load.ds), guide_friction=guide_friction)
    behind = curvature.relative_curvature(convention, "behind", small, big, load.ds, load.dds)
    ahead = curvature.relative_curvature(convention, "ahead", small, big, load.ds, load.dds)
    margins = None if convention != "exact" else (
        curvature.undercut_margin("behind", small, big, load.ds, load.dds),
        curvature.undercut_margin("ahead", small, big, load.ds, load.dds))
    return line_contacts(load.panels, normal, behind, ahead, curvature.path_rate(big, load.ds), long,
                         pair_compliance(roller, cam), margins)


def _column(value: ArrayLike) -> Floats:
    array = np.asarray(value, dtype=np.float64)
    return array if array.ndim == 0 else array[..., None, None]
