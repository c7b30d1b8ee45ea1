"""Track rollers by designation: the figures of a catalogue fill in what [roller] leaves out.

The shipped catalogue is `track_rollers.toml`; a file of the user's own, named by `roller.catalogue`, has the same form
and is asked first. A key that the profile gives beside a designation has to agree with the catalogue within 1 %:
neither wins in silence.
"""

from __future__ import annotations

from math import isclose
from pathlib import Path
from typing import Annotated, Any, Literal, final

from pydantic import Field, ValidationError

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.keys import Length, Section
from camgeom.profile.text import load
from camgeom.profile.twice import SAME
from camgeom.reading import decode, read_bytes

LARGEST = 1_000_000
"""B, of a catalogue"""
NO_KEYS = ("designation", "source", "type", "bore", "width")
"""what a catalogue says of a roller and no key of [roller] does"""

Load = Annotated[float, Field(gt=0.0, le=1e9, allow_inf_nan=False)]


@final
class CatalogueSource(Section):
    """Where rows of a catalogue were read."""

    key: Annotated[str, Field(min_length=1, max_length=60)]
    text: Annotated[str, Field(min_length=1, max_length=1000)]


@final
class CatalogueRoller(Section):
    """One track roller of a catalogue; what its page does not print is None."""

    designation: Annotated[str, Field(min_length=1, max_length=60)]
    source: Annotated[str, Field(max_length=60)] = ""
    type: Literal["stud", "yoke"]
    diameter: Length
    crown_radius: Length | None = None
    bore: Length
    width: Length
    dynamic_rating: Load
    static_rating: Load | None = None
    bearing_type: Literal["roller", "ball"] = "roller"
    fatigue_load_limit: Load | None = None
    pitch_diameter: Length | None = None
    max_radial_load: Load | None = None
    max_static_load: Load | None = None
    limiting_speed: Annotated[float, Field(gt=0.0, le=1e7)] | None = None

    @property
    def figures(self) -> dict[str, Any]:
        """Its figures as keys of [roller]."""
        return {key: value for key, value in self if key not in NO_KEYS and value is not None}


@final
class RollerCatalogue(Section):
    """The rollers of one file, and where their figures were read."""

    source: tuple[CatalogueSource, ...] = ()
    follower: tuple[CatalogueRoller, ...]

    def source_of(self, roller: CatalogueRoller) -> str:
        """Where a roller's figures were read; empty where the file does not say."""
        return next((one.text for one in self.source if one.key == roller.source), roller.source)


def shipped() -> RollerCatalogue:
    """The catalogue that comes with camgeom."""
    return parse((Path(__file__).parent / "track_rollers.toml").read_text(encoding="utf-8"), "track_rollers.toml")


def parse(text: str, file: str) -> RollerCatalogue:
    """A catalogue from its TOML text. Raises ProfileError."""
    data, problems, _ = load(text, file)
    if not problems:
        try:
            return RollerCatalogue.model_validate(data)
        except ValidationError as error:
            problems = [Problem(".".join(map(str, item["loc"])), item["msg"]) for item in error.errors()[:20]]
    raise ProfileError(problems, file)


def read(path: Path, key: str) -> RollerCatalogue:
    """A catalogue in a file; `key` names it in messages. Raises ProfileError."""
    return parse(decode(read_bytes(path, LARGEST, "", key), str(path)), path.name)


def filled(
    table: dict[str, Any], catalogues: list[RollerCatalogue], name: str = "roller"
) -> tuple[dict[str, Any], list[Problem]]:
    """A roller's table (`name`) of a profile with the figures of its designation, and what is wrong with that."""
    wanted = str(table["designation"])
    rollers = {one.designation: one for catalogue in reversed(catalogues) for one in catalogue.follower}
    plain = {_plain(name): one for name, one in rollers.items()}
    found = plain.get(_plain(wanted))
    if found is None:
        hint = did_you_mean(wanted, tuple(rollers)) or f"`camgeom rollers` lists them; {name}.catalogue names your own"
        return table, [Problem(f"{name}.designation", "is in no catalogue", wanted, "", hint)]
    problems = [
        Problem(f"{name}.{key}", f"is stated twice: the catalogue's {found.designation} has {value:g}", table[key],
                f"within {SAME:.0%} of it", "leave the key out, or the designation")
        for key, value in found.figures.items()
        if isinstance(value, float) and isinstance(table.get(key), int | float)
        and not isclose(table[key], value, rel_tol=SAME)
    ]  # fmt: skip
    shape = table.get("shape", "crowned")
    if found.crown_radius is not None and shape != "crowned":
        hint = f"its contact is an ellipse, harder pressed than a line: crown_radius = {found.crown_radius:g}"
        problems.append(Problem(f"{name}.shape", f"the outer ring of {found.designation} is crowned", shape,
                                'shape = "crowned"', hint))  # fmt: skip
    length = table.get("length")
    if isinstance(length, int | float) and length > found.width:
        problems.append(Problem(f"{name}.length", f"is longer than the outer ring of {found.designation}", length,
                                f"at most {found.width:g} mm"))  # fmt: skip
    if found.crown_radius is None:
        return {**found.figures, **table}, problems
    crown = {"shape": "crowned"} if not problems else {"crown_radius": None, "shape": shape}
    figures = {key: value for key, value in (found.figures | crown).items() if value is not None}
    return {**figures, **table}, problems


def _plain(designation: str) -> str:
    """A designation without blanks, in capitals."""
    return "".join(designation.split()).upper()
