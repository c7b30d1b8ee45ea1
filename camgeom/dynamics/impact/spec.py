"""The `[impact]` table of a profile: contact with clearance (units at the edge: mm, N, MPa, degrees)."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self, final

from pydantic import Field, model_validator

from camgeom.dynamics.impact.laws import (
    ContactLaw,
    Coulomb,
    Damping,
    EllipsePatch,
    HertzEllipse,
    HertzLine,
    ImpactDamping,
    LinePatch,
    LiuCylinder,
    Patch,
    PowerLaw,
    PrintedStiffness,
    RampedDamping,
)
from camgeom.dynamics.impact.pair import Pair
from camgeom.dynamics.impact.problem import ImpactLoad, ImpactProblem, RollerSpin
from camgeom.keys import Length, Section

Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]


MOST_TURNS = 200
"""of all runs of a study together; a turn of a thousand steps takes about 0.2 s of one core with its statistics"""


def too_long(runs: int, turns: int) -> str:
    """What keeps so many runs of so many turns, with the first turn of each solved again, from a study; "" for none."""
    if runs * (turns + 1) <= MOST_TURNS:
        return ""
    return (f"{runs} runs of {turns} turns and a check would take about {0.2 * runs * (turns + 1):.3g} s of one core, "
            f"more than the {0.2 * MOST_TURNS:g} s that are spent: fewer of impact.study and impact.laws, or fewer "
            "turns")  # fmt: skip


@final
class ImpactSpec(Section):
    """Contact of the follower with free play: contact law, damping, friction, what to compute."""

    clearance: Annotated[
        Length | None, Field(description="mm; free play between the two contacts; default: that of [follower]")
    ] = None
    clearance_kind: Annotated[
        Literal["chord", "normal"],
        Field(description="chord: between the limiting positions of the roller centre; normal: gap along the normal"),
    ] = "chord"
    law: Annotated[
        Literal["hertz", "liu", "power", "printed"],
        Field(
            description="contact law: hertz (default; line, or ellipse of a crown on a straight flank), liu cylinder "
            "joint, power K x^n, printed (comparison only)"
        ),
    ] = "hertz"
    contact_length: Annotated[Length | None, Field(description="mm; default: the roller's contact length")] = None
    reference_radius: Annotated[
        Length | None, Field(description="mm; cam radius in the contact law; default: base radius")
    ] = None
    true_curvature: Annotated[
        bool, Field(description="follow the cam's curvature at the contact point in the hertz law")
    ] = False
    stiffness: Annotated[Positive | None, Field(description="N/mm^n; K of the power law")] = None
    exponent: Annotated[
        float | None, Field(ge=1.0, le=3.0, description="n of the power law (1.5) and of the printed one (1)")
    ] = None
    restitution: Annotated[float, Field(gt=0.0, le=1.0, description="nominal coefficient of restitution")] = 0.9
    exact_restitution: Annotated[
        bool, Field(description="make the restitution exactly the nominal one; false: the hybrid model as published")
    ] = False
    damping: Annotated[
        NotNegative | None, Field(description="N s/mm; viscous damping that ramps in, in place of the restitution")
    ] = None
    damping_depth: Annotated[Length, Field(description="mm; penetration at which that damping is full")] = 0.1
    speed_floor: Annotated[Positive, Field(description="m/s; least approach speed that the damping refers to")] = 1e-3
    static_friction: Annotated[NotNegative, Field(description="static friction of cam and roller; 0: none")] = 0.0
    dynamic_friction: Annotated[NotNegative, Field(description="dynamic friction of cam and roller")] = 0.0
    stick_speed: Annotated[Positive, Field(description="m/s; sliding speed of the static friction")] = 0.001
    slip_speed: Annotated[Positive, Field(description="m/s; sliding speed from which friction is dynamic")] = 0.002
    roller_inertia: Annotated[
        Positive | None,
        Field(description="kg mm²; the rollers of a planar cam turn; default: they do not, and rub on it"),
    ] = None
    inertia: Annotated[
        Positive | None, Field(description="kg (kg m² of what swings); default: the follower's inertia or mass")
    ] = None
    turns: Annotated[int, Field(ge=2, le=100, description="turns that are solved")] = 6
    settle: Annotated[int, Field(ge=0, le=99, description="turns at the start that are not counted")] = 1
    tolerance: Annotated[float, Field(ge=1e-12, le=1e-4, description="relative tolerance of the solver")] = 1e-9
    study: Annotated[
        tuple[Length, ...], Field(max_length=1000, strict=False, description="mm; clearances of a study; empty: none")
    ] = ()
    laws: Annotated[
        tuple[Annotated[str, Field(max_length=60)], ...],
        Field(max_length=50, strict=False, description="motion laws compared in place of the profile's own"),
    ] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.law == "power" and self.stiffness is None:
            raise ValueError("law = 'power' needs stiffness, N/mm^n")
        if self.dynamic_friction > self.static_friction:
            raise ValueError("dynamic_friction must not exceed static_friction")
        if self.slip_speed <= self.stick_speed:
            raise ValueError("slip_speed must exceed stick_speed")
        if said := too_long(len(self.study) + len(self.laws), self.turns):
            raise ValueError(said)
        if self.settle >= self.turns:
            raise ValueError("settle must be less than turns")
        if self.roller_inertia is not None and self.static_friction == 0.0:
            raise ValueError("roller_inertia needs friction: a roller is turned by nothing else")
        return self

    def idle(self) -> dict[str, str]:
        """The keys that nothing reads, each with the reason."""
        found = {}
        if self.law == "power":
            found["reference_radius"] = "law = 'power' knows no radii"
        else:
            found["stiffness"] = "only law = 'power' has it"
        if self.law not in ("power", "printed"):
            found["exponent"] = "only law = 'power' and law = 'printed' have it"
        if self.law != "hertz":
            found["true_curvature"] = "only law = 'hertz' follows a curvature"
        if self.damping is None:
            found["damping_depth"] = "only `damping` ramps in; restitution does not"
        else:
            reason = "`damping` is given in place of the restitution"
            found |= dict.fromkeys(("restitution", "exact_restitution", "speed_floor"), reason)
        if not self.static_friction:
            found |= dict.fromkeys(("stick_speed", "slip_speed"), "there is no static_friction")
        return found

    def contact_law(
        self,
        modulus_mpa: float,
        length_mm: float,
        roller_radius_mm: float,
        cam_radius_mm: float,
        crown_radius_mm: float | None = None,
    ) -> ContactLaw:
        """The contact law in SI units, from contact modulus, length and radii at the edge; own keys go first.

        crown_radius_mm: of a crowned roller on a straight flank, which touches in an ellipse
        """
        modulus, roller = 1e6 * modulus_mpa, 1e-3 * roller_radius_mm
        length = 1e-3 * (self.contact_length or length_mm)
        cam = 1e-3 * (self.reference_radius or cam_radius_mm)
        if self.law == "hertz" and crown_radius_mm is not None:
            return HertzEllipse(modulus, roller, cam, 1e-3 * crown_radius_mm)
        if self.law == "hertz":
            # A flat face has no centre to measure from; the depth of the other body stands for its own.
            depth = None if math.isfinite(roller) else 4.0 * cam
            return HertzLine(modulus, length, roller, cam, roller_depth=depth, true_curvature=self.true_curvature)
        if self.law == "liu":
            return LiuCylinder(modulus, length, cam + roller)
        if self.law == "printed":
            return PrintedStiffness(modulus, cam + roller, 1.0 if self.exponent is None else self.exponent)
        exponent = 1.5 if self.exponent is None else self.exponent
        return PowerLaw((self.stiffness or 0.0) * 10.0 ** (3.0 * exponent), exponent)

    def problem(
        self,
        pair: Pair,
        *,
        inertia: float,
        speed_rpm: float,
        modulus_mpa: float,
        length_mm: float,
        roller_radius_mm: float,
        cam_radius_mm: float,
        crown_radius_mm: float | None = None,
        load: ImpactLoad | None = None,
        back: tuple[float, float, float | None] | None = None,
    ) -> ImpactProblem:
        """The problem in SI units; `inertia` (kg or kg m²) is the follower's unless the section gives its own.

        `modulus_mpa` is the contact modulus E*, `cam_radius_mm` the cam radius of the contact law unless given here;
        `crown_radius_mm` of a crowned roller on a straight flank; `back`: contact length, roller radius and crown
        radius, mm, of the return side where they are others.
        """
        other = None
        if back is not None:
            length, radius, crown = back
            law = self.contact_law(modulus_mpa, length, radius, cam_radius_mm, crown)
            other = law, self.patch(modulus_mpa, length, radius, crown)
        return ImpactProblem(
            pair,
            self.inertia or inertia,
            speed_rpm * math.pi / 30.0,
            self.contact_law(modulus_mpa, length_mm, roller_radius_mm, cam_radius_mm, crown_radius_mm),
            self.damping_law(),
            self.friction_law(),
            self.spin(),
            load or ImpactLoad(),
            self.patch(modulus_mpa, length_mm, roller_radius_mm, crown_radius_mm),
            other,
        )

    def patch(
        self, modulus_mpa: float, length_mm: float, roller_radius_mm: float, crown_radius_mm: float | None = None
    ) -> Patch:
        """The data of the contact pressure in SI units."""
        if crown_radius_mm is not None:
            return EllipsePatch(1e6 * modulus_mpa, 1e-3 * roller_radius_mm, 1e-3 * crown_radius_mm)
        return LinePatch(1e6 * modulus_mpa, 1e-3 * (self.contact_length or length_mm), 1e-3 * roller_radius_mm)

    def damping_law(self) -> Damping:
        """The damping in SI units."""
        if self.damping is not None:
            return RampedDamping(1e3 * self.damping, 1e-3 * self.damping_depth)
        return ImpactDamping(self.restitution, self.exact_restitution, self.speed_floor)

    def friction_law(self) -> Coulomb | None:
        """The friction, or None."""
        if self.static_friction == 0.0:
            return None
        return Coulomb(self.static_friction, self.dynamic_friction, self.stick_speed, self.slip_speed)

    def spin(self) -> RollerSpin | None:
        """The roller spin in SI units, or None."""
        return None if self.roller_inertia is None else RollerSpin(1e-6 * self.roller_inertia)
