"""The lubricant of roller and cam: its viscosity at the running temperature, and what it needs to make a film."""

from __future__ import annotations

from math import log10
from typing import Annotated, Self, final

from pydantic import Field, model_validator

from camgeom.keys import Section

KELVIN = 273.15
WALTHER = 0.7
"""mm²/s added to the viscosity under both logarithms (ASTM D341-20, viscosities above 2 mm²/s)"""
DENSITY = 870.0
"""kg/m³; mineral oil, on the light side: a denser one makes a thicker film"""

Viscosity = Annotated[float, Field(ge=2.0, le=1e6, allow_inf_nan=False)]
Celsius = Annotated[float, Field(ge=-60.0, le=300.0, allow_inf_nan=False)]


@final
class Lubricant(Section):
    """An oil, or the base oil of a grease, by its viscosities at 40 and 100 °C and the temperature in the contacts."""

    viscosity_40: Viscosity = Field(description="mm2/s, kinematic viscosity at 40 °C: the number of an ISO VG")
    viscosity_100: Viscosity = Field(description="mm2/s, kinematic viscosity at 100 °C")
    temperature: Celsius = Field(description="°C, of the oil where it enters the contacts")
    density: Annotated[float, Field(ge=500.0, le=2000.0)] = Field(
        DENSITY, description="kg/m3, at that temperature; default a light mineral oil")
    pressure_viscosity: Annotated[float, Field(gt=0.0, le=100.0)] | None = Field(
        None, description="1/GPa, pressure-viscosity coefficient, mineral oils 15 to 25; needed for the film")
    friction: Annotated[float, Field(gt=0.0, le=2.0)] | None = Field(
        None, description="1, coefficient of friction of roller or face on the cam, for the friction power")

    @model_validator(mode="after")
    def _thins(self) -> Self:
        if self.viscosity_100 >= self.viscosity_40:
            raise ValueError(f"viscosity_100 = {self.viscosity_100:g}: an oil is thinner at 100 °C than at 40 °C; "
                             f"allowed: below viscosity_40, {self.viscosity_40:g} mm2/s")  # fmt: skip
        return self

    @property
    def viscosity(self) -> float:
        """Kinematic viscosity at the temperature, mm²/s; see `walther`."""
        return walther(self.temperature, (40.0, self.viscosity_40), (100.0, self.viscosity_100))

    @property
    def dynamic_viscosity(self) -> float:
        """Dynamic viscosity at the temperature, Pa s."""
        return 1e-6 * self.viscosity * self.density


def walther(temperature: float, first: tuple[float, float], second: tuple[float, float]) -> float:
    """Kinematic viscosity, mm²/s, at a temperature, °C, from two known ones (°C, mm²/s) each.

    log10 log10 (nu + 0.7) = A - B log10 T, T in K (Walther; ASTM D341). Below 2 mm²/s the standard adds terms: there
    the formula is up to some per cent off.
    """
    (t1, y1), (t2, y2) = ((log10(t + KELVIN), log10(log10(nu + WALTHER))) for t, nu in (first, second))
    slope = (y2 - y1) / (t2 - t1)
    exponent = 10.0 ** (y1 + slope * (log10(temperature + KELVIN) - t1))
    return float(10.0 ** min(exponent, 12.0) - WALTHER)
