"""Cam types, one a file, found by file name: kind "constant-width" is `constant_width.ConstantWidth`, and the
starter profile of that kind is starters/constant-width.toml.

A cam type is a section of the profile, `Cam`, that answers what cannot be built, and the `Mechanism` that it makes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, ClassVar

from camgeom.errors import DesignError, Problem
from camgeom.keys import Section
from camgeom.track.follower import AnyRoller, CrownedRoller, CylinderRoller, Setup

if TYPE_CHECKING:
    from camgeom.motion.program import Program
    from camgeom.solid import Part
    from camgeom.solid.blank import Wall
    from camgeom.solid.mechanism import Mechanism
    from camgeom.track.carriage import Carriage


class Cam(Section, ABC):
    """The [cam] table of a profile: its fields are the keys.

    FOLLOWERS    follower kinds it accepts, the first one the usual
    MOTION_SPAN  deg of cam angle that the profile states; 180 where the other half follows, s(theta + pi) = lift - s
    SLIDES       whether it goes to and fro where others turn, so that the profile states its motion over the `travel`
    STATIONS     whether several followers have room on one track of it
    TRACKS       keys of it that another track on the same body may have of its own; none: it has room for one
    PLACES       those of them that only say where the track lies: how its follower moves does not hang on them
    ROLLERS      tables of rollers that it has, the first one for all that have no table of their own
    MOST_PIECES  of the motions of all its tracks, which its bodies are made of: what 2 GB and a minute bear
    MOST_STEPPED of them in a STEP file, some 15 s of one core
    """

    FOLLOWERS: ClassVar[tuple[str, ...]]
    MOTION_SPAN: ClassVar[float] = 360.0
    SLIDES: ClassVar[bool] = False
    STATIONS: ClassVar[bool] = False
    TRACKS: ClassVar[tuple[str, ...]] = ()
    PLACES: ClassVar[tuple[str, ...]] = ()
    ROLLERS: ClassVar[tuple[str, ...]] = ("roller",)
    MOST_PIECES: ClassVar[int] = 5_000
    MOST_STEPPED: ClassVar[int] = 2_000

    @property
    def travel(self) -> float | None:
        """Over which a cam that slides states its motion, mm; None of cams that turn."""
        return None

    def carriage(self, path: Program) -> Carriage | None:
        """What slides such a cam along the `path`, the lift over its travel; None of cams that turn."""
        del path
        return None

    @abstractmethod
    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""

    @abstractmethod
    def idle(self, setup: Setup) -> dict[str, str]:
        """The keys, of any section, that mean nothing for this cam with this follower, each with the reason."""

    @abstractmethod
    def mechanism(self, setup: Setup) -> Mechanism:
        """The cam bound to its follower, roller and program, which `problems` has nothing against."""

    def together(self, others: Sequence[Cam], rollers: Sequence[AnyRoller | None]) -> list[Problem]:
        """What contradicts itself on one body with further tracks' tables; without any, of a track that is alone.

        rollers  of all tracks, the first one's first
        """
        del others, rollers
        return []

    def joined(self, mechanisms: Sequence[Mechanism]) -> tuple[Part, ...]:
        """The bodies that several tracks make. DesignError where no body holds them."""
        raise DesignError(f"{len(mechanisms)} tracks: this kind of cam has room for one")

    def joined_walls(self, mechanisms: Sequence[Mechanism], parts: Sequence[Part]) -> tuple[Wall, ...]:
        """All walls of the bodies that several tracks make."""
        raise DesignError(f"{len(mechanisms)} tracks: this kind of cam has room for one")


@lru_cache(maxsize=1)
def kinds() -> tuple[str, ...]:
    """Names of the cam kinds, found without importing any of them."""
    return tuple(sorted(m.name.replace("_", "-") for m in iter_modules(__path__) if not m.name.startswith("_")))


def cam_class(kind: str) -> type[Cam]:
    """The `Cam` of a kind; KeyError for an unknown kind."""
    if kind not in kinds():
        raise KeyError(kind)
    words = kind.split("-")
    found: type[Cam] = vars(import_module(f"{__name__}.{'_'.join(words)}"))["".join(map(str.capitalize, words))]
    return found


def starter(kind: str) -> str:
    """The commented starter profile (TOML) of a kind, which runs as it is; KeyError for an unknown kind."""
    if kind not in kinds():
        raise KeyError(kind)
    return (Path(__file__).parent / "starters" / f"{kind}.toml").read_text(encoding="utf-8")


def problem(key: str, value: object, allowed: str) -> Problem:
    """A value that cannot be built, with its allowed range."""
    return Problem(key, "cannot be built", value, allowed)


def idle(reason: str, *keys: str) -> dict[str, str]:
    """Keys that mean nothing for one and the same reason."""
    return dict.fromkeys(keys, reason)


LEAST_ROOT = 0.01
"""mm; a smaller radius is a sharp edge to any tool"""


def root_problems(setup: Setup, own: float, depth: float) -> list[Problem]:
    """A groove's root is swept by the corner of a tool as wide as the groove: within its depth and half its width.

    own  cam.root_radius, mm; depth: of the groove, mm
    """
    key, root = ("cutter.corner_radius", setup.corner) if setup.corner else ("cam.root_radius", own)
    roller = setup.roller
    if not root or roller is None:
        return []
    if setup.corner and own and setup.corner != own:
        return [problem("cam.root_radius", own, f"cutter.corner_radius, {setup.corner:g} mm, or none")]
    straight = isinstance(roller, CrownedRoller) and roller.flank == "straight"
    if not straight and not isinstance(roller, CylinderRoller):
        return [problem(key, root, "0 for a roller whose flank is not cut by a cylindrical tool")]
    most = min(depth, 0.5 * roller.diameter)
    if LEAST_ROOT <= root < most:
        return []
    return [problem(key, root, f"{LEAST_ROOT:g} mm, and below {most:g} mm, the groove's depth and half its width")]


NO_STRESS = idle(
    "stress in the body is found at the roots of grooves in drums and discs, of ribs and of end faces' rings, and in a "
    "frame's plate (material.roller.bending_limit)",
    "material.cam.bending_limit",
)
SHARP = idle(
    "flanks that end at a face have no root, and grooves of barrels are made with a sharp one so far",
    "cutter.corner_radius",
)
NO_ROOT = NO_STRESS | SHARP
NO_LAYERS = idle(
    "stress at a root is solved in rings, and what leans as a cone does is filled with tetrahedra, too coarse for it",
    "material.cam.bending_limit",
)
NORMAL_PLAY = idle("the play of walls that lean is one for the chord and the normal", "impact.clearance_kind") | idle(
    "a roller between walls that lean does not turn in this solver", "impact.roller_inertia"
)
NO_RIB = idle("only a drum's rib is asked for by its thickness", "limits.warn_rib_share")
NO_DRUM = NO_RIB | idle("only a drum's groove is made although it is undercut", "output.undercut_solid")
REGULAR = idle(
    "only drums, whose grooves stay within both ends, end faces and cams of turrets are meshed with fewer triangles",
    "output.fewest_triangles",
)  # fmt: skip
PLANE_REST = idle("all faces of this cam that no follower touches are plane", "output.free_tolerance")
NO_GAPS = idle(
    "a follower touches its own cam; what may not touch are floors of grooves, other discs, other followers, pivots "
    "and turrets' blanks",
    "limits.clearance_mm",
)
ONE_WAY = idle(
    "this cam does not drive one follower both ways; grooves of drums and discs, conjugate pairs and frames do",
    "impact",
)

NO_LIFE = idle(
    "no fatigue life is known of a knife edge",
    "limits.life_h",
    *(f"material.{body}.{key}" for body in ("cam", "roller") for key in ("contact_cycles", "exponent")),
)
NO_PRESSURE = idle(
    "a knife edge has no contact pressure",
    "limits.contact_pressure_mpa",
    *(
        f"material.{body}.{key}"
        for body in ("cam", "roller")
        for key in ("elastic_modulus", "poisson", "contact_limit", "hardness", "case_depth_mm")
    ),
)
NO_FILM_OR_WEAR = idle(
    "neither film nor wear is known of a knife edge, which touches along no width",
    "lubricant.pressure_viscosity",
    *(f"limits.{key}" for key in ("film_ratio", "warn_film_ratio", "wear_um")),
    *(f"material.{body}.{key}" for body in ("cam", "roller") for key in ("roughness_um", "wear_rate")),
)


def keyway_idle(bore: float) -> dict[str, str]:
    """The keys of a keyway, which mean nothing without a bore."""
    return {} if bore else idle("a cam without a bore has no keyway", "cam.keyway_width", "cam.keyway_depth")


def prism_idle(bore: float, mark: float = 0.0) -> dict[str, str]:
    """The keys that mean nothing for a disc whose wall is all flank, with or without a bore and a phase mark."""
    return keyway_idle(bore) | ({} if bore or mark else PLANE_REST)


def sense_of(direction: str) -> float:
    """+1 for a cam that turns counter-clockwise ("ccw", seen from +Z), -1 clockwise."""
    return 1.0 if direction == "ccw" else -1.0
