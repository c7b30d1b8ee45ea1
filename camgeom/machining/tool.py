"""The body of a tool: a solid of revolution about its axis, from its end (the tip) on."""

from __future__ import annotations

from math import atan, degrees, inf, pi, radians, tan
from typing import Any, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.machining.spec import CutterSpec
from camgeom.maths import Floats
from camgeom.track import Meridian, Straight, Track


@final
@immutable(eq=True)
class Tool:
    """A tool. `s` is measured along its axis from its end towards the spindle, mm.

    kind     flat (cylinder, flat end), ball, roller (the roller's meridian), taper (a cone with a flat end), disc (a
             wheel that ends after `width`)
    radius   mm, the largest (for kind roller at its middle, for a taper at its end)
    meridian, tip, sign  of kinds roller and taper: the shape, where its end is on it, and delta = tip + sign * s
    width    mm, of a disc; else infinite (the shank is as thick as the tool)
    neck     mm, by which a ball's shank is thinner in radius
    corner   mm, radius of the rounding between a flat tool's side and its end
    grinds   a flat one is a grinding wheel whose rim works, no end mill
    """

    kind: str
    radius: float
    meridian: Meridian | None = None
    tip: float = 0.0
    sign: float = 1.0
    width: float = inf
    neck: float = 0.0
    corner: float = 0.0
    grinds: bool = False

    def distance(self, s: Floats, across: Floats) -> Floats:
        """Signed distance, mm, to the tool of points at s along and `across` from its axis; negative inside."""
        if self.kind == "ball":
            ball = np.hypot(across, s - self.radius) - self.radius
            shank = np.where(s < self.radius, np.inf, across - (self.radius - self.neck))
            return np.asarray(np.minimum(ball, shank))
        if self.corner:
            side, under = across - (self.radius - self.corner), self.corner - s
            outside = np.hypot(np.maximum(side, 0.0), np.maximum(under, 0.0))
            return np.asarray(outside + np.minimum(np.maximum(side, under), 0.0) - self.corner)
        wall = self._wall(s, across)
        end = np.maximum(-s, s - self.width) if self.width < inf else -s
        outside = np.hypot(np.maximum(wall, 0.0), np.maximum(end, 0.0))
        return np.asarray(np.where((wall > 0.0) | (end > 0.0), outside, np.maximum(wall, end)))

    def _wall(self, s: Floats, across: Floats) -> Floats:
        if self.meridian is None:
            return np.asarray(across - self.radius)
        delta = self.tip + self.sign * s
        if isinstance(self.meridian, Straight):
            slope = self.meridian.slope
            level = across - self.meridian.radius - slope * (delta - self.meridian.centre)
            return np.asarray(level / np.sqrt(1.0 + slope * slope))
        arc = self.meridian
        return np.asarray(np.hypot(across - (arc.radius - arc.arc), delta - arc.centre) - arc.arc)

    def thickest(self, height: float) -> float:
        """Largest radius from its end up to `height`, mm."""
        return float(self._radii(height).max())

    def thinnest(self, height: float) -> float:
        """Least radius of its side from its end up to `height`, mm."""
        return float(self._radii(height).min())

    def _radii(self, height: float) -> Floats:
        if self.meridian is None:
            return np.array([self.radius])
        ends = sorted((self.tip, self.tip + self.sign * height))
        low, high = (self.meridian.parameter(place) for place in ends)
        return self.meridian.jet(np.linspace(low, high, 33))[3]

    def apt(self, height: float) -> tuple[float, ...]:
        """The seven numbers of APT's CUTTER: d, r, e, f, a, b, h (mm, degrees).

        d diameter, r corner radius, e and f the corner's centre from the axis and from the end, a of the end, b of the
        side, h height.
        """
        if self.kind == "ball":
            return 2.0 * self.radius, self.radius, 0.0, self.radius, 0.0, 0.0, height
        if self.meridian is None:
            flat = self.radius - self.corner
            return 2.0 * self.radius, self.corner, flat, self.corner, 0.0, 0.0, min(height, self.width)
        if isinstance(self.meridian, Straight):
            slope = self.sign * self.meridian.slope
            end = self.meridian.radius + self.meridian.slope * (self.tip - self.meridian.centre)
            return 2.0 * end, 0.0, end, 0.0, 0.0, atan(slope) * 180.0 / pi, height
        arc = self.meridian
        return 2.0 * arc.radius, arc.arc, arc.radius - arc.arc, self.sign * (arc.centre - self.tip), 0.0, 0.0, height

    @property
    def shape(self) -> tuple[str, float]:
        """What tells it from another tool: its words, and the slope of a cone or the radius of a crown."""
        if self.meridian is None:
            return self.about, 0.0
        return self.about, self.meridian.slope if isinstance(self.meridian, Straight) else self.meridian.arc

    @property
    def about(self) -> str:
        """The tool in words."""
        size = f"{2.0 * self.radius:.6g} mm"
        if isinstance(self.meridian, Straight):
            if self.kind == "taper":
                return f"taper end mill, {size} at its end, half angle {degrees(atan(self.meridian.slope)):.6g} deg"
            return f"conical mill like the roller, {size} at its middle"
        words = {"flat": "grinding wheel" if self.grinds else "end mill", "ball": "ball mill",
                 "disc": f"wheel {self.width:.6g} mm wide,"}  # fmt: skip
        corner = f", corner radius {self.corner:.6g} mm" if self.corner else ""
        return f"{words.get(self.kind, 'form mill like the roller,')} {size}{corner}"


def tool_of(
    spec: CutterSpec, track: Track | None, roller_radius: float | None = None, corner: float = 0.0
) -> Tool:
    """The tool of a [cutter] table at one track (of a planar cam: with its roller's and its root's radius, mm)."""
    if spec.kind == "roller":
        if track is None:
            assert roller_radius is not None
            return Tool("flat", roller_radius, corner=corner)
        sign = -track.tip_sign
        middle = 0.5 * (track.contact[0] + track.contact[1])
        radius = float(track.meridian.jet(np.array([track.meridian.parameter(middle)]))[3][0])
        meridian: Any = track.meridian
        plain = isinstance(meridian, Straight) and meridian.slope == 0.0
        return Tool("flat", radius, corner=track.root) if plain else Tool("roller", radius, meridian, track.tip, sign)
    assert spec.diameter is not None
    radius = 0.5 * spec.diameter
    if spec.kind == "wheel" and spec.contact == "side":
        assert spec.width is not None
        return Tool("disc", radius, width=spec.width)
    if spec.half_angle:
        return Tool("taper", radius, Straight(radius, 0.0, tan(radians(spec.half_angle))), 0.0, 1.0)
    root = track.root if track is not None else corner
    neck = 0.1 * radius if spec.neck is None else spec.neck
    if spec.kind == "ball":
        return Tool("ball", radius, neck=neck)
    return Tool("flat", radius, corner=root, grinds=spec.kind == "wheel")
