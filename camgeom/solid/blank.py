"""The stock a cam is cut from: a body of revolution about Z with a bore and a keyway."""

from __future__ import annotations

from math import asin, atan2, ceil, cos, hypot, pi, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import Problem
from camgeom.immutable import immutable
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.maths.mesh import Mesh
    from camgeom.solid.builder import Builder, Index


@immutable(eq=True)
class Bore:
    """A round bore with an optional parallel keyway (flat bottom) centred on the +X side.

    diameter mm; keyway_width mm; keyway_depth mm measured from the bore wall on the keyway's centre line.
    """

    diameter: float
    keyway_width: float = 0.0
    keyway_depth: float = 0.0

    @property
    def reach(self) -> float:
        """Largest distance of the bore outline from the axis, mm."""
        r = 0.5 * self.diameter
        return hypot(r + self.keyway_depth, 0.5 * self.keyway_width) if self.keyway_width else r

    @property
    def area(self) -> float:
        """Area of the opening, mm² (closed form)."""
        r, h = 0.5 * self.diameter, 0.5 * self.keyway_width
        if not h:
            return pi * r * r
        chord = sqrt(r * r - h * h)
        segment = r * r * asin(h / r) - h * chord
        return pi * r * r + 2.0 * h * (r + self.keyway_depth - chord) - segment

    def _steps(self, tolerance: float) -> tuple[float, float, int]:
        """Where its round part begins, rad, how far it reaches, and how many chords it takes."""
        r = 0.5 * self.diameter
        start = asin(0.5 * self.keyway_width / r)
        span = 2.0 * pi - 2.0 * start
        return start, span, max(12, ceil(span / chord_step(r, tolerance)))

    def sag(self, tolerance: float) -> float:
        """Chord error of the polygon made within a tolerance, mm."""
        _, span, parts = self._steps(tolerance)
        return 0.5 * self.diameter * (1.0 - cos(0.5 * span / parts))

    def outline(self, tolerance: float) -> tuple[Floats, list[str]]:
        """Closed polygon (n, 2) counter-clockwise, vertices on the outline, and the name of each edge."""
        r, h = 0.5 * self.diameter, 0.5 * self.keyway_width
        start, span, parts = self._steps(tolerance)
        angle = start + span * np.arange(parts + (1 if h else 0)) / parts
        points = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)
        names = ["bore"] * parts
        if h:
            top = r + self.keyway_depth
            points = np.concatenate([points, [[top, -h], [top, h]]])
            names += ["keyway"] * 3
        return points, names


def arc_of(
    start: tuple[float, float], end: tuple[float, float], about: tuple[float, float]
) -> tuple[Floats, float, float, float]:
    """The shorter arc about a centre from (r, z) to (r, z): centre (2,) and radius, mm, first angle and sweep, rad."""
    centre = np.array(about, dtype=float)
    low, high = np.array(start) - centre, np.array(end) - centre
    a0, a1 = float(np.arctan2(low[1], low[0])), float(np.arctan2(high[1], high[0]))
    return centre, float(np.hypot(*low)), a0, (a1 - a0 + pi) % (2.0 * pi) - pi


def chord_step(radius: float, tolerance: float) -> float:
    """Largest angle step (rad) whose chord stays within tolerance of a circle: sag = R (1 - cos(step / 2))."""
    return 2.0 * float(np.arccos(max(0.0, 1.0 - min(1.0, tolerance / radius)))) if radius > 0.0 else pi


@immutable(eq=True)
class Blank:
    """A body of revolution: outline points (r, z) from the lower end to the upper end, joined by lines or arcs.

    outline  ((r, z), ...) in order of increasing z, r > 0
    arcs     for each outline edge None (a line) or (centre r, centre z): an arc of revolution about that centre
    names    face-group name of each outline edge
    """

    outline: tuple[tuple[float, float], ...]
    bore: Bore | None = None
    arcs: tuple[tuple[float, float] | None, ...] = ()
    names: tuple[str, ...] = ()

    @classmethod
    def cylinder(cls, radius: float, length: float, bore: Bore | None = None) -> Blank:
        """A plain cylinder 0 <= z <= length."""
        return cls(((radius, 0.0), (radius, length)), bore, (None,), ("land",))

    @property
    def share(self) -> float:
        """Share of a tolerance that each of the two directions may take.

        Sags of a surface bent outward both ways add up inside a triangle; on a saddle (a globoid, whose arc is about a
        centre outside) or a surface straight one way they have opposite signs or are alone.
        """
        saddle = all(
            arc is None or arc[0] > max(start[0], stop[0])
            for start, stop, arc in zip(self.outline[:-1], self.outline[1:], self.arcs)
        )
        return 0.98 if saddle else 0.5

    @property
    def envelope(self) -> tuple[float, float]:
        """Diameter and length, mm; an arc that bulges outward between its ends counts with its top."""
        radii = [r for r, _ in self.outline]
        for start, stop, arc in zip(self.outline[:-1], self.outline[1:], self.arcs):
            if arc is not None and arc[0] < min(start[0], stop[0]) and start[1] < arc[1] < stop[1]:
                radii.append(arc[0] + hypot(start[0] - arc[0], start[1] - arc[1]))
        return 2.0 * max(radii), self.outline[-1][1] - self.outline[0][1]

    def sections(self, tolerance: float) -> tuple[Floats, list[str]]:
        """Outline polyline (k, 2) of (r, z) within tolerance, and the name of each of its edges."""
        points, names = [np.array(self.outline[0])], []
        arcs = self.arcs or (None,) * (len(self.outline) - 1)
        labels = self.names or ("land",) * (len(self.outline) - 1)
        for start, stop, arc, name in zip(self.outline[:-1], self.outline[1:], arcs, labels):
            if arc is None:
                points.append(np.array(stop))
                names.append(name)
                continue
            centre, radius, a0, sweep = arc_of(start, stop, arc)
            parts = max(1, ceil(abs(sweep) / chord_step(radius, tolerance)))
            angle = a0 + sweep * np.arange(1, parts + 1) / parts
            points.extend(centre + radius * np.array([cos(t), sin(t)]) for t in angle[:-1])
            points.append(np.array(stop))
            names.extend([name] * parts)
        return np.array(points), names

    def mesh(self, tolerance: float) -> Mesh:
        """Watertight mesh of the blank within tolerance, groups named by face."""
        from camgeom.solid.builder import Builder

        share = self.share * tolerance
        rz, names = self.sections(share)
        largest = float(rz[:, 0].max())
        parts = max(12, ceil(2.0 * pi / chord_step(largest, share)))
        angle = 2.0 * pi * np.arange(parts) / parts
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        builder = Builder()
        rows = [builder.add(np.column_stack([r * ring, np.full(parts, z)])) for r, z in rz]
        for low, high, name in zip(rows[:-1], rows[1:], names):
            builder.band(low, high, name)
        close_ends(builder, rows[0], rows[-1], float(rz[0, 1]), float(rz[-1, 1]), self.bore, tolerance)
        return builder.mesh()


@immutable(eq=True)
class Globoid:
    """A globoidal cam's blank: outside an arc about the turret axis, with hubs and bore; -width/2 <= z <= width/2, mm.

    centre  distance of the turret axis from the cam axis; radius: of the outside about the turret axis
    hub_diameter, hub_length  of hubs beyond both end faces, 0 for none
    """

    centre: float
    width: float
    radius: float
    bore: Bore | None = None
    hub_diameter: float = 0.0
    hub_length: float = 0.0

    @property
    def end_radius(self) -> float:
        """Radius at the end faces (its largest), mm."""
        return self.centre - sqrt(self.radius**2 - 0.25 * self.width**2)

    def blank(self) -> Blank:
        """The body of revolution."""
        half, end, arc = 0.5 * self.width, self.end_radius, (self.centre, 0.0)
        if not self.hub_length:
            return Blank(((end, -half), (end, half)), self.bore, (arc,), ("land",))
        hub, far = 0.5 * self.hub_diameter, half + self.hub_length
        outline = ((hub, -far), (hub, -half), (end, -half), (end, half), (hub, half), (hub, far))
        return Blank(outline, self.bore, (None, None, arc, None, None), ("hub", "end", "land", "end", "hub"))

    def within(self, x: Floats) -> Floats:
        """How deep points (3, ...) of the cam frame lie within the globoid, mm; what it ends at is 1e-9 mm deep."""
        away = np.sqrt(x[0] * x[0] + x[1] * x[1]) - self.centre
        under = np.sqrt(away * away + x[2] * x[2]) - self.radius
        return np.asarray(np.minimum(under, 0.5 * self.width - np.abs(x[2])) + 1e-9)

    def hub_problems(self, reach: float) -> list[Problem]:
        """What is wrong with the hubs beside rollers whose ends reach so far from the turret axis, mm."""
        if bool(self.hub_diameter) != bool(self.hub_length):
            limit = "diameter and length both, or neither"
            return [Problem("cam.hub_length", "cannot be built", self.hub_length, limit)]
        if not self.hub_length:
            return []
        least = 2.0 * self.bore.reach if self.bore else 0.0
        most = 2.0 * (self.centre - sqrt(max(0.0, reach**2 - 0.25 * self.width**2)))
        if least < self.hub_diameter < most:
            return []
        limit = f"{least:g} .. {most:g} mm, outside the bore and clear of the rollers"
        return [Problem("cam.hub_diameter", "cannot be built", self.hub_diameter, limit)]

    def clear_angle(self, low: float, radius: float) -> float:
        """Turret angle (rad) from the line of centres beyond which a tool of a radius is clear of the blank.

        low  distance of the tool's inner end from the turret axis, mm
        """
        size = hypot(low, radius)
        if 0.5 * self.width < size:
            angle = asin(0.5 * self.width / size) + atan2(radius, low)
            if angle < 0.5 * pi:
                return 1.02 * angle + 0.01
        return 0.5 * pi


@immutable(eq=True)
class Wall:
    """A wall of the finished body: its name, thickness (mm), the cam angle (rad) where it is thinnest, and advice."""

    name: str
    thickness: float
    cam_angle: float | None
    advice: str


def close_ends(
    builder: Builder,
    bottom: Index,
    top: Index,
    z0: float,
    z1: float,
    bore: Bore | None,
    tolerance: float,
) -> float:
    """Add both flat ends and the bore of a body whose outer end rings (counter-clockwise) are given; returns the chord
    error of the bore, mm."""
    if bore is None:
        for ring, z, flip in ((bottom, z0, True), (top, z1, False)):
            hub = builder.add(np.array([[0.0, 0.0, z]]))
            nxt = np.roll(ring, -1)
            fan = np.stack([np.broadcast_to(hub, ring.shape), ring, nxt], axis=1)
            builder.faces(fan[:, ::-1] if flip else fan, "end")
        return 0.0
    from camgeom.solid.builder import cap

    low, high, outline = bore_walls(builder, bore, z0, z1, tolerance)
    for ring, hole, up in ((bottom, low, False), (top, high, True)):
        cap(builder, [ring, hole[::-1]], [builder.points(ring)[:, :2], outline[::-1]], "end", up)
    return bore.sag(tolerance)


def bore_walls(
    builder: Builder, bore: Bore, z0: float, z1: float, tolerance: float
) -> tuple[Index, Index, Floats]:
    """Add the walls of a bore; returns its lower and upper ring (counter-clockwise) and its outline (n, 2)."""
    outline, names = bore.outline(tolerance)
    low, high = (builder.add(np.column_stack([outline, np.full(len(outline), z)])) for z in (z0, z1))
    low2, high2 = np.roll(low, -1), np.roll(high, -1)
    for name in dict.fromkeys(names):
        mask = np.array([n == name for n in names])
        quads = np.concatenate(
            [np.stack([low, high, high2], axis=1)[mask], np.stack([low, high2, low2], axis=1)[mask]]
        )
        builder.faces(quads, name)
    return low, high, outline
