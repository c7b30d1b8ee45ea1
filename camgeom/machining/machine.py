"""Axes of a rotary-table mill: from tool positions in the cam frame to machine coordinates, and back.

The workpiece turns about its own axis by the rotary axis; three linear axes move the tool along the cam's axis
(`axial`), outwards in the plane through it (`radial`, the spindle's direction where nothing swings) and across that
plane; a swing axis tilts the tool in one of two planes. Linear coordinates are those of the tool's end in a frame fixed
to the machine, whose origin is the cam's; with a pivot length, those of the swing axis that far behind the end.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from typing import Literal, final

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.machining.path import Positions
from camgeom.maths import Floats

LETTERS = {
    "A": ("Z", "Y", "X", "B", "C"),
    "B": ("Z", "X", "Y", "A", "C"),
    "C": ("X", "Y", "Z", "B", "A"),
}
"""rotary letter: linear letters radial, across, axial; letters of a swing about the across and about the radial axis"""
ACROSS_SIGN = {"A": -1.0, "B": 1.0, "C": 1.0}
"""what keeps (X, Y, Z) right-handed with the radial, across and axial directions those of the cam's X, Y and Z"""
TILT_SIGN = {"A": 1.0, "B": -1.0, "C": -1.0}
"""of the swing about the across axis, from the radial towards the axial direction, by the right-hand rule"""
STRAIGHT = 1e-12
"""a direction component that counts as zero"""
SQUARE = 1e-9
"""lean of a tool that counts as none"""
LEAST_RADIUS = 1e-3
"""mm; nearer to the cam's axis a rotary axis cannot follow"""

Way = Literal["axis", "polar", "plain", "helix", "inside", "lean"]


@final
@immutable(eq=True)
class Machine:
    """The axes of a machine.

    way     axis: the rotary axis brings the tool's axis into the plane of the swing; polar: it brings the tool's end
            there (tools parallel to the cam's axis); plain: it stands still; helix: it follows the cam angle, and the
            swing is about the radial axis (a wheel set to the helix angle); inside: as axis, with an angle head within
            a ring, whose tool points outwards; lean: as axis, with a tool that leans a little from the cam's axis
    swings  True where a swing axis is needed
    sense   +1 where the cam turns counter-clockwise
    slides  True of a plate that slides: it has no axis
    over    mm, thickness of a plate: what is cut from below is cut with the part turned over about X
    aside   of way lean: +1 where the tool leans towards the radial letter's +, -1 towards its -
    """

    rotary: str
    way: Way
    swings: bool
    sense: float = 1.0
    reverse: bool = False
    pivot: float = 0.0
    slides: bool = False
    over: float = 0.0
    aside: float = 1.0

    @property
    def origin(self) -> str:
        """Where the coordinates count from, in words."""
        return "AT THE PLATE'S CORNER, UNDERSIDE" if self.slides else "ON THE CAM AXIS"

    @property
    def letters(self) -> tuple[str, ...]:
        """Letters of the coordinates in the order of `solve`."""
        radial, across, axial, tilt, helix = LETTERS[self.rotary]
        linear = (radial, across, axial)
        turning = () if self.way == "plain" else (self.rotary,)
        return (*linear, *turning, *(((helix if self.way == "helix" else tilt),) if self.swings else ()))

    @property
    def retreat(self) -> str:
        """Letter of the linear axis along the untilted spindle, by which a tool leaves the part."""
        radial, across, axial, *_ = LETTERS[self.rotary]
        return {"axis": radial, "helix": across, "polar": axial, "plain": axial, "inside": axial,
                "lean": axial}[self.way]

    @property
    def about(self) -> list[str]:
        """What the axes are, in words."""
        radial, across, axial, *_ = LETTERS[self.rotary]
        if self.slides:
            return [f"{radial} ALONG THE TRAVEL, {across} ACROSS, {axial} UP; ORIGIN {self.origin}"]
        lines = [f"{axial} ALONG THE CAM AXIS, {radial} RADIAL, {across} ACROSS; ORIGIN ON THE CAM AXIS AT CAM Z = 0"]
        if self.way != "plain":
            way = "CLOCKWISE" if self.reverse else "COUNTER-CLOCKWISE"
            lines.append(f"{self.rotary} PLUS TURNS THE CAM {way} SEEN FROM ITS +Z END")
        if self.way == "inside":
            lines.append(f"ANGLE HEAD ALONG {axial}, ITS TOOL POINTS TO +{radial} FROM WITHIN THE RING")
        if self.swings:
            helix = self.way == "helix"
            about = radial if helix else across
            zero = f"{'-' if ACROSS_SIGN[self.rotary] < 0.0 else '+'}{across}" if helix else f"+{radial}"
            zero = f"+{axial}" if self.way == "lean" else zero
            where = f"PIVOT {self.pivot:.6g} MM BEHIND THE TOOL END" if self.pivot else "COORDINATES OF THE TOOL END"
            letter = self.letters[-1]
            lines.append(f"{letter} TILTS THE SPINDLE RIGHT-HANDED ABOUT {about}, ZERO TOWARDS {zero}; {where}")
        return lines

    @property
    def about_over(self) -> list[str]:
        """What they are once the part is turned over, in words."""
        radial, _, axial, *_ = LETTERS[self.rotary]
        lines = [f"LOWER FACE: PART TURNED OVER ABOUT {radial}, G55 ON THE CAM AXIS AT CAM Z = {self.over:.9g} MM, "
                 f"{axial} PLUS ALONG CAM -Z"]  # fmt: skip
        if self.way != "plain":
            way = "CLOCKWISE" if self.reverse else "COUNTER-CLOCKWISE"
            lines.append(f"THERE {self.rotary} PLUS TURNS THE CAM {way} SEEN FROM ITS -Z END")
        return lines

    def solve(self, positions: Positions) -> Floats:
        """Machine coordinates (k, n) in the order of `letters`: mm, and rad (the rotary axis runs on over turns).

        Raises DesignError where the axes cannot reach a position.
        """
        if self.below(positions):
            return replace(self, sense=-self.sense).solve(positions.turned_over(self.over))
        turn = self._turn(positions)
        tip, axis = _turned(positions.tip, turn), _turned(positions.axis, turn)
        if self.way == "inside" and (lean := float(np.abs(axis[2]).max(initial=0.0))) > SQUARE:
            raise DesignError(
                f"an angle head's tool stays square to the cam's axis, and this one leans by {degrees(lean):.3g} deg; "
                "use the APT file"
            )
        rows = [self._count * turn] if self.way != "plain" else []
        if self.swings:
            rows.append(self._swing * np.unwrap(self._tilt(axis)))
            tip = tip + self.pivot * axis
        return np.stack([tip[0], ACROSS_SIGN[self.rotary] * tip[1], tip[2], *rows])

    def positions(self, coordinates: Floats) -> tuple[Floats, Floats]:
        """Tool ends and axes in the cam frame, each (3, n), of machine coordinates (k, n): the way back.

        In the frame of the part as it lies: turned over for a lower face.
        """
        radial, across, axial = coordinates[0], ACROSS_SIGN[self.rotary] * coordinates[1], coordinates[2]
        n = coordinates.shape[1]
        turn = np.zeros(n)
        if self.way != "plain":
            turn = self._count * coordinates[3]
        axis = np.stack([np.zeros(n), np.zeros(n), np.ones(n)])
        if self.way == "inside":
            axis = np.stack([-np.ones(n), np.zeros(n), np.zeros(n)])
        elif self.way in ("axis", "helix", "lean"):
            tilt = self._swing * coordinates[4] if self.swings else np.zeros(n)
            c, s = np.cos(tilt), np.sin(tilt)
            zero = np.zeros(n)
            axis = np.stack({"helix": [zero, c, s], "lean": [s, zero, c]}.get(self.way, [c, zero, s]))
        tip = np.stack([radial, across, axial]) - (self.pivot if self.swings else 0.0) * axis
        return _turned(tip, -turn), _turned(axis, -turn)

    def below(self, positions: Positions) -> bool:
        """Whether these are cut from the lower face of a plate."""
        return self.way in ("polar", "plain", "lean") and bool(positions.axis[2, 0] < 0.0)

    @property
    def _swing(self) -> float:
        """Sign of the swing axis; that about the radial axis is right-handed as it is."""
        if self.way == "helix":
            return 1.0
        return -TILT_SIGN[self.rotary] if self.way == "lean" else TILT_SIGN[self.rotary]

    @property
    def _count(self) -> float:
        """-1 where the rotary axis counts the other way."""
        return -1.0 if self.reverse else 1.0

    def _turn(self, positions: Positions) -> Floats:
        """Angle of the cam about its axis, rad, continuous."""
        phi = self.sense * positions.phi
        if self.way == "plain":
            return np.zeros_like(phi)
        if self.way == "helix":
            return np.asarray(phi)
        x, y = (positions.tip if self.way == "polar" else positions.axis)[:2]
        if self.way == "lean":
            # What stands upright turns with the flank that it is beside, as what leans does.
            leans = np.hypot(x, y) > SQUARE
            x, y = (self.aside * np.where(leans, *each) for each in ((x, positions.normals[0, 0]),
                                                                     (y, positions.normals[0, 1])))  # fmt: skip
        if self.way == "inside":
            x, y = -x, -y
        least = LEAST_RADIUS if self.way == "polar" else STRAIGHT
        size = np.hypot(x, y)
        if np.any(size < least):
            at = degrees(float(positions.phi[int(np.argmin(size))]))
            raise DesignError(
                f"the rotary axis cannot follow the tool at cam angle {at:.6g} deg, where it stands on (or points "
                "along) the cam's axis; use machine = 'plain', or the APT file"
            )
        # The rotary axis follows the cam angle but for a slowly changing rest, which has no steps of a turn.
        rest = np.angle((x + 1j * y) * np.exp(1j * phi))
        rest = np.unwrap(rest)
        return np.asarray(phi - rest)

    def _tilt(self, axis: Floats) -> Floats:
        """Swing angle (rad) of tool axes (3, n) in the machine's frame."""
        off = axis[0] if self.way == "helix" else axis[1]
        if np.abs(off).max(initial=0.0) > SQUARE:
            raise DesignError(
                f"one swing axis cannot set this tool: its axis leaves the swing's plane by "
                f"{degrees(float(np.abs(off).max())):.3g} deg; use the APT file"
            )
        if self.way == "lean":
            return np.asarray(np.arctan2(axis[0], axis[2]))
        return np.asarray(np.arctan2(axis[2], axis[1] if self.way == "helix" else axis[0]))


def _turned(vectors: Floats, angle: Floats) -> Floats:
    """Vectors (3, n) turned about Z by angles (n,)."""
    z = (vectors[0] + 1j * vectors[1]) * np.exp(1j * angle)
    return np.stack([z.real, z.imag, vectors[2]])


def in_degrees(coordinates: Floats) -> Floats:
    """The coordinates with degrees in place of radians."""
    shown = coordinates.copy()
    shown[3:] = np.degrees(shown[3:])
    return shown
