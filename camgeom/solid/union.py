"""The body that a roller really leaves where its flank folds: the blank minus many roller positions, error stated.

An undercut flank crosses itself and bounds no body. What the tool leaves is the blank without the union of its
positions. Between two positions a distance d apart a smooth wall stands proud by about d² / (8 r), and more beside a
cusp: so the error stated is measured, the deepest vertex inside the true sweep and the facets' own sag.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

import numpy as np

from camgeom.errors import DesignError
from camgeom.maths.mesh import Mesh
from camgeom.solid.blank import Blank
from camgeom.solid.drum import Solid
from camgeom.solid.engine import subtract, unite
from camgeom.track import Straight, Track
from camgeom.track.clearance import least_clearance

MOST_ROLLERS = 360


@dataclass(frozen=True, eq=False)
class RollerUnion:
    """A blank minus the positions of straight rollers that reach from their tip out to `beyond`, mm."""

    name: str
    tracks: tuple[Track, ...]
    blank: Blank
    beyond: float

    def solid(self, tolerance: float) -> Solid:
        """At most MOST_ROLLERS positions a track; `chord_error` says what that leaves. Raises GeometryEngineError."""
        tools = [unite(self._positions(track, tolerance)) for track in self.tracks]
        mesh = subtract(self.blank.mesh(tolerance), tools)
        deepest = min(least_clearance(track, mesh.vertices).value for track in self.tracks)
        return Solid(self.name, mesh, tolerance + max(0.0, -deepest), "union of rollers", mesh.genus)

    def _positions(self, track: Track, tolerance: float) -> list[Mesh]:
        """Roller bodies at equal steps of their largest travel."""
        if not isinstance(track.meridian, Straight):
            raise DesignError("an undercut body is made of straight rollers (cylinder or cone) only")
        fine = np.linspace(*track.span, 7201)
        pose = track.pose(fine, 0)
        ends = [pose.a[0] + d * pose.u[0] for d in (track.tip, self.beyond)]
        step = np.max([np.sqrt((np.diff(x, axis=1) ** 2).sum(axis=0)) for x in ends], axis=0)
        path = np.concatenate([[0.0], np.cumsum(step)])
        radius = track.meridian.radius
        count = min(MOST_ROLLERS, max(24, ceil(path[-1] / np.sqrt(8.0 * radius * tolerance))))
        phi = np.interp(np.linspace(0.0, path[-1], count + 1), path, fine)[: -1 if track.closed else None]
        return [self._body(track, float(p), tolerance) for p in phi]

    def _body(self, track: Track, phi: float, tolerance: float) -> Mesh:
        """The roller standing at one cam angle, from its tip to `beyond`."""
        low, high = sorted((track.tip, self.beyond))
        r = track.meridian.jet(np.array([low, high]))[3]
        upright = Blank(((float(r[0]), low), (float(r[1]), high)), names=("flank",)).mesh(tolerance)
        pose = track.pose(np.array([phi]), 0)
        u = pose.u[0][:, 0]
        side = np.cross(u, [0.0, 0.0, 1.0] if abs(u[2]) < 0.9 else [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        frame = np.stack([side, np.cross(u, side), u])
        return Mesh(upright.vertices @ frame + pose.a[0][:, 0], upright.faces, upright.groups, upright.group)
