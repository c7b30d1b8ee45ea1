"""Elastic and fatigue constants of the two bodies in contact."""

from typing import Annotated, final

from pydantic import Field, model_validator

from camgeom.keys import Section
from camgeom.mechanics.hardness import CONTACT_CYCLES, CONTACT_LIMIT, STEEL_MODULUS

CAST_IRON_MODULUS = 127000.0
"""MPa; cast iron (T/WLJC 15-2018)"""
STEEL_POISSON = 0.3
STEEL_DENSITY = 7850.0
"""kg/m³; carbon and bearing steel"""
EXPONENT = 6.0
CASE_SHARE = 0.5
"""depth of the largest shear over that of a hardened case: camgeom's own rule, for which no source is at hand. The
shear is that of a smooth line or ellipse; the rest of the case is for wear, regrinding and its falling hardness"""


@final
class Material(Section):
    """Elastic modulus (MPa), Poisson ratio and contact fatigue line of one body; the defaults are hardened steel.

    The fatigue line is N(sigma) = contact_cycles (contact_limit / sigma)^exponent, sigma the peak contact pressure.
    """

    grade: Annotated[str, Field(min_length=1, max_length=60)] | None = Field(
        None, description="material by its name in T/WLJC 15-2018 (`camgeom materials`): gives treatment, hardness, "
        "case, moduli and contact_limit where they are not stated")
    name: str = Field("hardened steel", max_length=80, description="Name shown in reports")
    elastic_modulus: Annotated[float, Field(ge=1e-3, le=1e7)] = Field(
        STEEL_MODULUS, description="Young's modulus, MPa; hardened steel 206000, cast iron 127000")
    poisson: Annotated[float, Field(ge=0.0, le=0.5)] = Field(STEEL_POISSON, description="Poisson ratio")
    contact_limit: Annotated[float, Field(gt=0.0, le=1e6)] = Field(
        CONTACT_LIMIT, description="Peak contact pressure, MPa, endured for contact_cycles; 2450 for steel at 60 HRC")
    contact_cycles: Annotated[float, Field(ge=1.0, le=1e15)] = Field(
        CONTACT_CYCLES, description="Load cycles at which contact_limit is quoted")
    exponent: Annotated[float, Field(ge=1.0, le=40.0)] = Field(
        EXPONENT, description="Exponent of the fatigue line in stress")
    density: Annotated[float, Field(gt=0.0, le=1e5)] = Field(STEEL_DENSITY, description="Density, kg/m³")
    hardness: Annotated[float, Field(gt=0.0, le=80.0)] | None = Field(None, description="Surface hardness, HRC")
    case_depth_mm: Annotated[float, Field(gt=0.0, le=100.0)] | None = Field(
        None, description="mm, depth of a hardened case; carburised tracks 0.8 to 1.2")
    roughness_um: Annotated[float, Field(gt=0.0, le=100.0)] | None = Field(
        None, description="um, roughness Rq (root mean square) of the surface; ground 0.2 to 0.4, honed 0.05 to 0.1")
    wear_rate: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None, description="mm3/(N m), wear volume per load and sliding way, K/H of Archard's law; measured, boundary "
        "lubricated steel 1e-9 to 1e-7")

    bending_limit: Annotated[float, Field(gt=0.0, le=1e5)] | None = Field(
        None, description="MPa, of the cam, or (roller) of a frame with a plate: stress at a groove's root, in the "
        "plate, that the body endures for ever, pulsating; with it the body is solved and root-stress judged")

    @model_validator(mode="before")
    @classmethod
    def _graded(cls, data: object) -> object:
        if isinstance(data, dict) and isinstance(data.get("grade"), str):
            from camgeom.mechanics.grades import filled

            return filled(data)
        return data

    @property
    def rated_limit(self) -> float:
        """Contact pressure, MPa, of the fatigue line at CONTACT_CYCLES."""
        return float(self.contact_limit * (self.contact_cycles / CONTACT_CYCLES) ** (1.0 / self.exponent))

    @property
    def compliance(self) -> float:
        """Plane-strain compliance (1 - nu²)/E, 1/MPa."""
        return (1.0 - self.poisson * self.poisson) / self.elastic_modulus


STEEL = Material()
CAST_IRON = Material(name="cast iron", elastic_modulus=CAST_IRON_MODULUS, poisson=0.25, density=7200.0,
                     contact_limit=1200.0)
"""Grey iron; its contact limit is half that of hardened steel, an estimate to be replaced by a measured one."""


def pair_compliance(first: Material, second: Material) -> float:
    """Compliance of a contacting pair, (1 - nu1²)/E1 + (1 - nu2²)/E2, 1/MPa (the inverse of the contact modulus)."""
    return first.compliance + second.compliance
