"""Drums for the tests of STEP files: the pin-insertion cam and its relatives."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, radians

import numpy as np

from camgeom.export.step.solids import ClosedCurve
from camgeom.maths import Floats
from camgeom.motion import Program, Segment
from camgeom.solid.blank import Blank, Bore
from camgeom.solid.drum import GroovedCylinder
from camgeom.track import Arc, Slide, Straight, Swing, Track

RADIUS, FLOOR, ROLLER, LENGTH = 67.0, 54.0, 11.0, 110.0
BORE = Bore(40.0)


def pin_program() -> Program:
    return Program.from_segments(
        [
            Segment(radians(155)),
            Segment(radians(215), 37.0, "cycloidal"),
            Segment(radians(280), 74.0, "cycloidal"),
            Segment(radians(290)),
            Segment(2.0 * pi, 0.0, "cycloidal"),
        ]
    )


def rise_and_return(lift: float = 30.0) -> Program:
    """No dwell anywhere: the follower turns round at 0 and 180 deg."""
    return Program.from_segments([Segment(pi, lift, "cycloidal"), Segment(2.0 * pi, 0.0, "cycloidal")])


def drum(
    program: Program | None = None,
    meridian: Straight | Arc | None = None,
    sense: float = 1.0,
    bore: Bore | None = BORE,
    tip: float = FLOOR,
    start: float = 18.0,
) -> GroovedCylinder:
    """A groove round a drum of the pin-insertion cam's size, translating follower."""
    meridian = meridian or Straight(ROLLER, 60.5)
    anchor, axis = (0.0, 0.0, start), (1.0, 0.0, 0.0)
    program = program or pin_program()
    track = Track(meridian, Slide((0.0, 0.0, 1.0)), anchor, axis, tip, (tip + 1.0, RADIUS), program, sense)
    return GroovedCylinder("pin cam", track, Blank.cylinder(RADIUS, LENGTH, bore), RADIUS, LENGTH)


def swinging_drum() -> GroovedCylinder:
    """A groove for a swinging follower with an arm of 90 mm, 40 deg of swing."""
    program = Program.from_segments(
        [Segment(radians(120), radians(40.0), "cycloidal"), Segment(radians(200)), Segment(2.0 * pi, 0.0, "3-4-5")],
        angular=True,
    )
    joint = Swing((-1.0, 0.0, 0.0), (0.0, 85.0, 55.0))
    roller, anchor, axis, middle = Straight(8.0, 60.0), (0.0, -5.0, 55.0), (1.0, 0.0, 0.0), radians(-20.0)
    track = Track(roller, joint, anchor, axis, FLOOR, (55.0, RADIUS), program, shift=middle)
    return GroovedCylinder("swing cam", track, Blank.cylinder(RADIUS, LENGTH, Bore(40.0, 12.0, 5.0)), RADIUS, LENGTH)


def polygon_curve(corners: Sequence[tuple[float, float]], name: str | tuple[str, ...] = "side") -> ClosedCurve:
    """A closed polygon through the corners (mm), counter-clockwise; edge i runs from corner i."""
    ring = np.array([*corners, corners[0]], dtype=float)

    def point(t: Floats) -> Floats:
        return np.stack([np.interp(t, np.arange(len(ring)), ring[:, c]) for c in (0, 1)], axis=1)

    return ClosedCurve(point, tuple(float(k) for k in range(len(ring))), name)
