"""Materials of cams and rollers by name (T/WLJC 15-2018, 9.2 and 9.3): what a grade says where a profile does not, and
the steels that go with the load and the speed of a track (9.1).

The hardness is the least of the treatment's range, the contact limit what that hardness bears (`hardness_bound`), the
case the thinnest; a key that stands beside the grade is kept, a hardness or a case outside the range is refused.
"""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any, final

from pydantic import Field

from camgeom.errors import did_you_mean
from camgeom.immutable import immutable
from camgeom.keys import Section
from camgeom.mechanics.hardness import CONTACT_CYCLES, STEEL_MODULUS, hardness_bound

SOURCE = "T/WLJC 15-2018"
POISSON = 0.3
"""of steel and cast iron (section 8.1)"""
Range = tuple[float, float]


@final
class Grade(Section):
    """A material by its name: treatment, hardness, HRC, case, mm, moduli, MPa, density, kg/m³, and where it stands.

    contact_limit: MPa, where the source's load class and no hardness bounds it
    """

    name: str
    of: tuple[str, ...]
    treatment: str
    hardness: Range | None = None
    case_depth: Range | None = None
    elastic_modulus: float = STEEL_MODULUS
    density: float | None = Field(None)
    contact_limit: float | None = None
    place: str

    @property
    def limit(self) -> float | None:
        """Contact pressure, MPa, at CONTACT_CYCLES, of its least hardness; None where neither is printed."""
        return hardness_bound(self.hardness[0]) if self.hardness is not None else self.contact_limit

    @property
    def words(self) -> str:
        """Name, treatment and hardness, as drawings and reports show them."""
        hard = "" if self.hardness is None else f", {self.hardness[0]:g} to {self.hardness[1]:g} HRC"
        return f"{self.name}, {self.treatment}{hard}"


@cache
def grades() -> dict[str, Grade]:
    """All grades by name."""
    data = tomllib.loads((files("camgeom.mechanics") / "grades.toml").read_text(encoding="utf-8"))
    tuples = ({k: tuple(v) if isinstance(v, list) else v for k, v in one.items()} for one in data["grade"])
    return {one.name: one for one in (Grade.model_validate(_floats(row)) for row in tuples)}


def _floats(row: dict[str, Any]) -> dict[str, Any]:
    """Whole numbers of the table as floats, which a section is strict about."""

    def plain(value: Any) -> Any:
        if isinstance(value, tuple):
            return tuple(map(plain, value))
        return float(value) if isinstance(value, int) else value

    return {key: plain(value) for key, value in row.items()}


def filled(table: dict[str, Any]) -> dict[str, Any]:
    """A material's table with what its grade says. Raises ValueError for what cannot be, with what can."""
    wanted = table["grade"]
    found = grades().get(wanted)
    if found is None:
        names = ", ".join(grades())
        raise ValueError(f"no grade {wanted[:60]!r}; {did_you_mean(wanted, tuple(grades())) or f'known: {names}'}")
    hardness = _within(table, "hardness", found.hardness, found)
    case = _within(table, "case_depth_mm", found.case_depth, found)
    limit = found.limit if table.get("hardness") is None or hardness is None else hardness_bound(hardness)
    if limit is None and "contact_limit" not in table:
        what = "give hardness (HRC), which decides what it bears, or contact_limit"
        raise ValueError(f"{SOURCE} prints no hardness of {found.name}: {what}")
    given: dict[str, Any] = {
        "name": found.words, "elastic_modulus": found.elastic_modulus, "poisson": POISSON, "density": found.density,
        "hardness": hardness, "case_depth_mm": case, "contact_limit": limit, "contact_cycles": CONTACT_CYCLES,
    }  # fmt: skip
    if "contact_limit" in table:
        del given["contact_limit"], given["contact_cycles"]
    return {key: value for key, value in given.items() if value is not None} | table


def _within(table: dict[str, Any], key: str, allowed: Range | None, grade: Grade) -> float | None:
    """The value beside a grade, in its range; the least of the range where there is none."""
    value = table.get(key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        return None if allowed is None else allowed[0]
    if allowed is not None and not allowed[0] <= value <= allowed[1]:
        raise ValueError(f"{key} {value:g} is none of {grade.words}: {allowed[0]:g} to {allowed[1]:g}")
    return float(value)


@immutable(eq=True)
class TrackMaterial:
    """A cam material for a load class: up to a contact pressure (MPa), with a hardness (HRC)."""

    name: str
    pressure: float
    hardness: float
    load_class: str


MATERIALS = (
    TrackMaterial("45 quenched and tempered", 600.0, 30.0, "light, below 600 MPa (HRC 10 to 40)"),
    TrackMaterial("40Cr surface-hardened", 1000.0, 52.0, "medium, 600 to 1000 MPa (HRC 40 to 60)"),
    TrackMaterial("20Cr carburised 0.8 to 1.2 mm", 1300.0, 60.0, "heavy, 1000 to 1300 MPa (HRC 60 and above)"),
)
"""T/WLJC 15-2018: load classes of the track and the steels named for them"""


def speed_class(speed: float) -> str:
    """The class of a track speed in m/s (T/WLJC 15-2018)."""
    return "low, below 0.5 m/s" if speed < 0.5 else "medium, 0.5 to 1 m/s" if speed <= 1.0 else "high, above 1 m/s"


def material_for(pressure: float, speed: float) -> TrackMaterial | None:
    """The mildest material for a contact pressure (MPa) and track speed (m/s); None where none will do.

    A fast track wears: above 1 m/s it is surface-hardened even where the pressure is light.
    """
    fit = [one for one in MATERIALS if pressure <= one.pressure and (speed <= 1.0 or one.hardness > 40.0)]
    return fit[0] if fit else None
