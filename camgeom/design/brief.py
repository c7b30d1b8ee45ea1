"""What a globoidal drive has to do, one candidate for it, and the candidate written as a profile."""

from __future__ import annotations

from dataclasses import dataclass

from camgeom.design.series import RollerSize
from camgeom.errors import Problem

SEAT = 2.0
"""mm between the turret's body and the blank (T/WLJC 15-2018: 1 to 5 mm)"""


@dataclass(frozen=True)
class Wanted:
    """What the drive has to do: angles deg, lengths mm, speed r/min, inertia kg m², torque N m, life h.

    Either the centre distance or the envelope (the largest length of cam and turret together) is given.
    """

    stops: int
    motion_angle: float
    speed: float
    inertia: float
    torque: float
    life: float
    center_distance: float | None = None
    envelope: float | None = None
    name: str = "globoidal indexer"

    def problems(self) -> list[Problem]:
        """What is out of range."""
        found = []
        for key, low, high in (
            ("stops", 2, 48), ("motion_angle", 30.0, 330.0), ("speed", 0.1, 3000.0), ("inertia", 0.0, 1e4),
            ("torque", 0.0, 1e6), ("life", 1.0, 1e7), ("center_distance", 40.0, 1500.0), ("envelope", 80.0, 5000.0),
        ):
            value = getattr(self, key)
            if value is not None and not low <= value <= high:
                found.append(Problem(f"--{key.replace('_', '-')}", "out of range", value, f"{low:g} to {high:g}"))
        if (self.center_distance is None) == (self.envelope is None):
            found.append(Problem("--center-distance", "give either the centre distance or the envelope"))
        return found


@dataclass(frozen=True)
class Candidate:
    """Numbers of one trial; mm."""

    centre: float
    pitch: float
    roller: RollerSize
    length: float
    width: float
    rollers: int
    form: str
    law: str
    bore: float

    @property
    def globoid(self) -> float:
        """Globoid radius."""
        return round(self.pitch - 0.5 * self.length + SEAT, 2)


def profile_text(wanted: Wanted, trial: Candidate, material: tuple[str, float, float] | None) -> str:
    """The profile."""
    start = 0.5 * (360.0 - wanted.motion_angle)
    name, pressure, hardness = material or ("hardened steel", 1300.0, 60.0)
    return f"""# Designed by `camgeom design globoidal` from: {wanted.stops} stops, moving {wanted.motion_angle:g} deg,
# {wanted.speed:g} r/min, inertia {wanted.inertia:g} kg m2, load {wanted.torque:g} N m, life {wanted.life:g} h.

name = {_quoted(wanted.name)}

[cam]
kind = "globoidal"
form = "{trial.form}"
hand = "right"
center_distance = {trial.centre:g}
width = {trial.width:g}
globoid_radius = {trial.globoid:g}
tip_clearance = 0.8
bore = {trial.bore:g}

[follower]
kind = "turret"
stops = {wanted.stops}
rollers = {trial.rollers}
pitch_radius = {trial.pitch:g}
inertia = {wanted.inertia:g}

[roller]
shape = "cylinder"
diameter = {trial.roller.diameter:g}
length = {trial.length:g}
dynamic_rating = {trial.roller.dynamic:g}
static_rating = {trial.roller.static:g}

[[motion]]
until = {start:.10g}

[[motion]]
until = {start + wanted.motion_angle:.10g}
to = {360.0 / wanted.stops:.12g}
law = "{trial.law}"

[[motion]]
until = 360

[operation]
speed = {wanted.speed:g}
friction = {1e3 * wanted.torque:g}

[material.cam]
name = "{name}"
hardness = {hardness:g}
contact_limit = {pressure:g}
contact_cycles = 1e7

[limits]
life_h = {wanted.life:g}
min_wall_mm = {max(1.0, round(0.1 * trial.roller.diameter, 1)):g}

[output]
tolerance = 0.01
formats = ["3mf", "stl"]
"""


def _quoted(text: str) -> str:
    return '"' + "".join(c for c in text if c.isprintable() and c not in '"\\') + '"'
