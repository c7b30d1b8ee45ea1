"""What the design procedure chooses from: roller sizes, shaft diameters, materials by load class."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class RollerSize:
    """A stud cam follower: diameter and ring width, mm; dynamic and static ratings, N."""

    diameter: float
    width: float
    dynamic: float
    static: float


ROLLERS = (
    RollerSize(16, 11, 3000, 3000),
    RollerSize(19, 11, 3500, 4000),
    RollerSize(22, 12, 4500, 5200),
    RollerSize(26, 12, 5200, 6000),
    RollerSize(30, 14, 6800, 8300),
    RollerSize(32, 14, 7000, 8800),
    RollerSize(35, 18, 9700, 14000),
    RollerSize(40, 20, 10900, 14500),
    RollerSize(47, 24, 15500, 25000),
    RollerSize(52, 24, 16800, 29000),
    RollerSize(62, 29, 26000, 48000),
    RollerSize(72, 29, 28000, 53000),
    RollerSize(80, 35, 38000, 77000),
    RollerSize(90, 35, 39000, 80000),
)
"""Usual outside diameters and widths of stud cam followers; ratings are figures on the cautious side of what such sizes
have. The figures of the follower that is bought replace them in the profile."""

BORES = (12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90, 100, 110, 120)
"""mm, usual shaft diameters"""


@dataclass(frozen=True)
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
