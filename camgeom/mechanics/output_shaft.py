"""What a turret's torque goes out through: the output shaft at its weakest section, and bolts that carry by friction.

T/WLJC 15-2018 (6.2.4) asks for the strength of shaft and bolts and gives no formula. The shaft is bent and twisted
(equivalent stress of von Mises); bolts are tightened and grip as in VDI 2230-1:2015. Forces N, lengths mm, stresses
MPa.
"""

from __future__ import annotations

from math import pi, sin, sqrt
from typing import Annotated, Literal, Self, final

from pydantic import Field, model_validator

from camgeom.immutable import immutable
from camgeom.keys import Gap, Length, Section

Size = Literal[
    "M4", "M5", "M6", "M8", "M10", "M12", "M14", "M16", "M18", "M20", "M22", "M24", "M27", "M30", "M33", "M36"
]
Grade = Literal["8.8", "10.9", "12.9"]
PITCH: dict[Size, float] = {
    "M4": 0.7, "M5": 0.8, "M6": 1.0, "M8": 1.25, "M10": 1.5, "M12": 1.75, "M14": 2.0, "M16": 2.0, "M18": 2.5,
    "M20": 2.5, "M22": 2.5, "M24": 3.0, "M27": 3.0, "M30": 3.5, "M33": 3.5, "M36": 4.0,
}  # fmt: skip
"""mm, coarse thread (ISO 261)"""
STRENGTH: dict[Grade, tuple[float, float, float]] = {
    "8.8": (640.0, 800.0, 0.65), "10.9": (940.0, 1040.0, 0.62), "12.9": (1100.0, 1220.0, 0.60),
}  # fmt: skip
"""MPa, 0.2 % proof and tensile strength (ISO 898-1, least; of 8.8 those up to M16), and shear over tensile strength
(VDI 2230-1)"""
USED = 0.9
"""share of the proof strength that tightening uses: the tables of VDI 2230-1"""
HEAD = 1.5
"""diameter of a socket head over that of its thread (ISO 4762), so far apart at least stand the bolts of a circle"""


@final
class OutputShaft(Section):
    """The output shaft of a turret where it is weakest, and the bolts that carry its torque; either of both, or both.

    Defaults of the joint are on the weak side: clean dry steel, tightened by a signalling wrench, short bolts.
    """

    diameter: Length | None = Field(
        None, description="mm, of the output shaft where it is weakest; with lever and stress_limit it is judged"
    )
    bore: Gap = Field(0.0, description="mm, of a hollow shaft")
    lever: Gap | None = Field(
        None, description="mm, along the output axis, from the middle of the rollers to that section"
    )
    stress_limit: Annotated[float, Field(gt=0.0, le=1e5)] | None = Field(
        None, description="MPa, equivalent stress that it bears there for ever, reversed, with its notches and keyway"
    )
    bolts: Annotated[int, Field(ge=2, le=100)] | None = Field(
        None, description="on one circle, which carry the output torque by friction; with bolt_size and bolt_circle"
    )
    bolt_size: Size | None = Field(None, description="coarse metric thread (ISO 261)")
    bolt_circle: Length | None = Field(
        None, description="mm, diameter of their circle, which stands on the turret's disc or dials"
    )
    bolt_grade: Grade = Field("8.8", description="property class (ISO 898-1)")
    joint_friction: Annotated[float, Field(ge=0.01, le=1.0)] = Field(
        0.1, description="1, least friction in the joint; steel on steel, clean, 0.1 to 0.2"
    )
    thread_friction: Annotated[float, Field(ge=0.04, le=0.5)] = Field(
        0.14, description="1, friction in the threads, which leaves the less of a bolt's strength for its preload"
    )
    tightening_factor: Annotated[float, Field(ge=1.0, le=4.0)] = Field(
        2.0, description="1, largest over least preload: 1.6 to 2 by a torque wrench, 1.2 to 1.4 by angle (VDI 2230-1)"
    )
    preload_loss: Annotated[float, Field(ge=0.0, lt=1.0)] = Field(
        0.2, description="1, share of the least preload that embedding takes: 0.2 of short bolts, 0.05 of long ones"
    )

    @model_validator(mode="after")
    def _whole(self) -> Self:
        shaft = {"diameter": self.diameter, "lever": self.lever, "stress_limit": self.stress_limit}
        joint = {"bolts": self.bolts, "bolt_size": self.bolt_size, "bolt_circle": self.bolt_circle}
        for part in (shaft, joint):
            missing = [key for key, value in part.items() if value is None]
            if missing and len(missing) < len(part):
                raise ValueError(f"{' and '.join(missing)} missing: {', '.join(part)} go together")
        if self.diameter is None and self.bolts is None:
            raise ValueError("nothing to judge: give diameter, lever, stress_limit, or bolts, bolt_size, bolt_circle")
        if self.diameter is None and self.bore:
            raise ValueError(f"bore = {self.bore:g}: means nothing without the diameter of the shaft")
        if self.diameter is not None and self.bore >= self.diameter:
            raise ValueError(f"bore = {self.bore:g}: allowed: below the diameter, {self.diameter:g} mm")
        stated = {key for key in type(self).model_fields if key in JOINT} & self.model_fields_set
        if self.bolts is None and stated:
            raise ValueError(f"{', '.join(sorted(stated))}: mean nothing without bolts, bolt_size and bolt_circle")
        if self.bolts is not None and self.bolt_size is not None and self.bolt_circle is not None:
            apart, head = self.bolt_circle * sin(pi / self.bolts), HEAD * float(self.bolt_size[1:])
            if apart < head:
                least = head / sin(pi / self.bolts)
                raise ValueError(f"bolt_circle = {self.bolt_circle:g}: the heads of {self.bolts} bolts overlap; "
                                 f"allowed: {least:.6g} mm or more, or fewer bolts")  # fmt: skip
        return self


JOINT = ("bolt_grade", "joint_friction", "thread_friction", "tightening_factor", "preload_loss")
"""keys of the bolts beside those that make them"""


@immutable(eq=True)
class Bolts:
    """Bolts of one size on a circle.

    friction  in the joint; thread: in the threads; scatter: largest over least preload; loss: share of the least
    """

    count: int
    size: Size
    grade: Grade
    circle: float
    friction: float
    thread: float
    scatter: float
    loss: float

    @property
    def head(self) -> float:
        """Diameter of a head, mm."""
        return HEAD * float(self.size[1:])

    @property
    def section(self) -> tuple[float, float]:
        """Mean flank diameter d2, mm, and stress cross-section, mm2 (ISO 724, ISO 898-1)."""
        across, pitch = float(self.size[1:]), PITCH[self.size]
        flank, core = across - 0.649519 * pitch, across - 1.226869 * pitch
        return flank, 0.25 * pi * (0.5 * (flank + core)) ** 2

    @property
    def preload(self) -> float:
        """Largest preload of a bolt, N, that uses USED of its proof strength while it is twisted by its threads.

        F_M = A_s nu R_p / sqrt(1 + 3 (3/2 d_2/d_s (P/(pi d_2) + 1.155 mu))^2), VDI 2230-1.
        """
        flank, area = self.section
        turn = PITCH[self.size] / (pi * flank) + 1.155 * self.thread
        twisted = 1.5 * flank / sqrt(4.0 * area / pi) * turn
        return area * USED * STRENGTH[self.grade][0] / sqrt(1.0 + 3.0 * twisted**2)

    @property
    def least_preload(self) -> float:
        """What scatter and embedding leave of it, N."""
        return self.preload / self.scatter * (1.0 - self.loss)

    @property
    def grip(self) -> float:
        """Torque, N mm, at which the joint slips: friction of all bolts at the radius of their circle."""
        return self.count * self.friction * self.least_preload * 0.5 * self.circle

    @property
    def shear(self) -> float:
        """Torque, N mm, that shears all bolts off in their threads, should the joint slip."""
        _, tensile, share = STRENGTH[self.grade]
        return self.count * share * tensile * self.section[1] * 0.5 * self.circle


def bolts_of(spec: OutputShaft) -> Bolts | None:
    """The bolts of a table; None where it has none."""
    if spec.bolts is None or spec.bolt_size is None or spec.bolt_circle is None:
        return None
    return Bolts(spec.bolts, spec.bolt_size, spec.bolt_grade, spec.bolt_circle, spec.joint_friction,
                 spec.thread_friction, spec.tightening_factor, spec.preload_loss)  # fmt: skip


def equivalent_stress(diameter: float, bore: float, bending: float, torque: float) -> float:
    """Stress of von Mises, MPa, at the outside of a round section under a bending moment and a torque, N mm."""
    modulus = pi * (diameter**4 - bore**4) / (32.0 * diameter)
    return sqrt(bending**2 + 0.75 * torque**2) / modulus
