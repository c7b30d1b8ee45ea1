"""The sections of a profile that belong to no single part: motion segments, operation, materials, output, limits."""

from typing import TYPE_CHECKING, Annotated, Any, Literal, Self, final

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from camgeom.errors import ProfileError
from camgeom.keys import Degrees, Gap, Section, Share
from camgeom.mechanics.material import Material
from camgeom.track.follower import AnyFollower, Inertia, Mass

if TYPE_CHECKING:
    from camgeom.mechanics.applied import Applied

TOLERANCE_RANGE = (1e-7, 1.0)
"""mm; finer than a tenth of a nanometre is below the rounding of a part's coordinates"""

MOST_STATES = 64
"""of [[duty]]"""
MOST_STATIONS = 12
"""of [[station]]"""
MOST_LOADED = 256
"""followers, each in every operating state; one takes a tenth of a second, and its contacts a megabyte"""
MOST_FOLLOWED = 40_000
"""pieces of motions and rows of forces' tables, of every follower in every state: some 25 s and 0.9 GB"""
TURRETS_FOLLOWED = 7
"""times less of a turret, of which every roller and slice is followed: some 40 s and 1.5 GB, [dynamics] included"""

NonNegative = Annotated[float, Field(ge=0.0, le=1e9, allow_inf_nan=False)]
Value = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False)]
Number = Annotated[float, Field(ge=-1e12, le=1e12, allow_inf_nan=False)]

Reproduced = Literal["S1", "S2", "S3", "S4", "S5"]
"""the source documents of `camgeom.validation`, by their short names"""

INTERNAL: dict[str, Any] = {"internal": True}
"""Marks a field that is no key of the profile."""
Units = Literal["mm", "inch"]
INCH = 25.4
"""mm, exactly (ISO 80000-3)"""


@final
class MotionSegment(Section):
    """One segment of the motion; every other key of it is a parameter of its law."""

    until: Annotated[float, Field(gt=0.0, le=1e5)] = Field(
        description="deg, cam angle at the segment's end, up to 360; of a linear cam mm of travel, up to its stroke"
    )
    to: Degrees | None = Field(
        None, description="mm (deg of swinging followers and turrets), position at the segment's end; none: dwell"
    )
    law: Annotated[str, Field(max_length=60)] | None = Field(None, description="motion law, see `camgeom laws`")
    velocity: Number | None = Field(
        None, description="mm (or deg) per degree of cam angle at the segment's end, for laws that join neighbours; of "
        "a linear cam per mm of travel"
    )
    acceleration: Number | None = Field(None, description="mm (or deg) per square degree at the segment's end")
    jerk: Number | None = Field(None, description="mm (or deg) per cubic degree at the segment's end")
    parameters: tuple[tuple[str, Any], ...] = Field((), description="the law's own keys", json_schema_extra=INTERNAL)
    rows_from: str = Field("", description="the file that its law's rows were read from", json_schema_extra=INTERNAL)


def _rows(table: object) -> object:
    """A list of lists, which is what TOML gives, as the tuples that a frozen section holds."""
    return tuple(tuple(row) if isinstance(row, list) else row for row in table) if isinstance(table, list) else table


@final
class Force(Section):
    """One applied force of a profile: `from`, `until` (degrees) with an `expression`, or a `table` of (degrees, N)."""

    begin: Degrees = Field(0.0, alias="from", description="Cam angle where the force begins, degrees")
    until: Degrees = Field(360.0, description="Cam angle where the force ends, degrees; smaller than `from`: past 360")
    expression: str | None = Field(
        None, max_length=2000, description="Force against motion towards larger lift, N (N mm on a swinging follower "
        "or a turret); variables phi (rad), deg, s (mm, of what turns rad), v (mm/s, rad/s), a (mm/s2, rad/s2); no "
        "pole, no peak narrower than 0.006 deg")
    table: Annotated[tuple[tuple[Degrees, Value], ...] | None, BeforeValidator(_rows)] = Field(
        None, max_length=100_000, description="Rows of cam angle (degrees, increasing) and force (N or N mm)")
    interpolation: Literal["linear", "smooth"] = Field(
        "linear", description="Between table rows: linear, or smooth (monotone cubic)")

    @model_validator(mode="after")
    def _complete(self) -> Self:
        from camgeom.mechanics.applied import ROUNDED, check_table, compile_expression

        if (self.expression is None) == (self.table is None):
            raise ValueError("a force needs either an expression or a table")
        stated = self.model_fields_set
        if self.table is not None and {"begin", "until"} & stated:
            raise ValueError("`from` and `until` are of an expression: a table acts from its first to its last row")
        if self.expression is not None and "interpolation" in stated:
            raise ValueError("`interpolation` is of a table: an expression has no rows")
        if self.expression is not None:
            length = self.until - self.begin
            if length == 0.0 or abs(length + 360.0) <= ROUNDED:
                raise ValueError("`from` and `until` are equal: the force has no range of cam angle")
            if not -360.0 < length <= 360.0 + ROUNDED:
                raise ValueError("`from` and `until` are more than a turn apart: the force is that of one turn")
            try:
                compile_expression(self.expression)
            except ProfileError as refused:
                # pydantic turns a ValueError into a finding with its place in the profile.
                raise ValueError(_reason(refused)) from None
        if self.table is not None:
            check_table([row[0] for row in self.table])
        return self

    @property
    def hangs_on_speed(self) -> bool:
        """Whether the follower's velocity or acceleration has a part in it."""
        from camgeom.mechanics.applied import compile_expression

        return self.expression is not None and bool(compile_expression(self.expression).variables & {"v", "a"})

    def applied(self, key: str = "operation.force") -> "Applied":
        """The force as an array function of cam angle and motion."""
        from camgeom.mechanics.applied import expression_force, table_force

        if self.table is not None:
            rows = np.asarray(self.table, dtype=np.float64)
            return table_force(np.radians(rows[:, 0]), rows[:, 1], self.interpolation)
        return expression_force(self.expression or "0", np.radians(self.begin), np.radians(self.until), key)


def _reason(refused: ProfileError) -> str:
    problem = refused.problems[0]
    return f"{problem.message}; {problem.hint}" if problem.hint else problem.message


@final
class Operation(Section):
    """How the cam runs and what it drives."""

    speed: Annotated[float, Field(gt=0.0, le=1e6)] = Field(
        description="r/min, cam speed; of a linear cam that of its drive"
    )
    friction: NonNegative = Field(0.0, description="N (N mm of swinging followers and turrets), against the motion")
    guide_friction: Annotated[float, Field(ge=0.0, le=10.0)] = Field(
        0.0, description="1, friction of a slide's guides under its side thrust, times overhang over bearing distance"
    )
    load_mass: Mass = Field(0.0, description="kg, moved together with the follower")
    load_inertia: Inertia = Field(0.0, description="kg m2, turns together with a swinging follower or turret")
    spring_rate: NonNegative = Field(0.0, description="N/mm (N mm/deg), spring that pushes the follower back")
    spring_preload: NonNegative = Field(0.0, description="N (N mm), spring force at zero lift")
    gravity: Annotated[float, Field(ge=-1000.0, le=1000.0)] = Field(
        0.0, description="m/s2, share of gravity along the motion; positive pulls the follower back"
    )
    force: Annotated[tuple[Force, ...], Field(max_length=1000)] = Field((), description="applied forces")

    def idle(self, rotating: bool) -> dict[str, str]:
        """The keys that say something about the other kind of follower, translating or rotating, each with the reason.
        """
        if rotating:
            reason = "of a translating follower; a rotating one takes load_inertia, or a force"
            return dict.fromkeys(("load_mass", "gravity", "guide_friction"), reason)
        return {"load_inertia": "of a rotating follower; a translating one takes load_mass"}


@final
class Materials(Section):
    """The two bodies in contact."""

    cam: Material = Field(Material(), description="the cam; default hardened steel")
    roller: Material = Field(Material(), description="the roller; default hardened steel")


@final
class Output(Section):
    """What is written."""

    tolerance: Annotated[float, Field(ge=TOLERANCE_RANGE[0], le=TOLERANCE_RANGE[1])] = Field(
        0.005, description="mm, guaranteed chord error of the mesh"
    )
    free_tolerance: Annotated[float, Field(ge=TOLERANCE_RANGE[0], le=TOLERANCE_RANGE[1])] | None = Field(
        None, description="mm, of faces that no follower touches: bore, outside, floors, hubs; default the tolerance"
    )
    formats: Annotated[tuple[Annotated[str, Field(min_length=1, max_length=24)], ...], Field(max_length=40)] = Field(
        ("3mf", "stl"), description="file formats of the solid and its drawings"
    )
    table_points: Annotated[int, Field(ge=3, le=100_000)] | None = Field(
        None, description="points of the electronic cam, evenly spaced with both ends; default 361"
    )
    table_tolerance: Annotated[float, Field(ge=1e-9, le=10.0)] | None = Field(
        None, description="mm (deg), error of the electronic cam between its points; chooses their number and places"
    )
    load_angle_deg: Degrees | None = Field(
        None, description="deg, cam angle of the load in volume files and of the body's stress; default: where the "
        "contact force over the squared thickness of the wall behind it is largest"
    )
    fewest_triangles: bool | None = Field(
        None, description="drums, end faces and indexing cams are meshed with rows and columns that follow each face's "
        "curvature; default wherever that can be made, but for `camgeom check` and `solve`, which write no body; true "
        "refuses what cannot. false: one regular grid, in a third to a half of the time with up to twice the triangles"
    )
    undercut_solid: bool = Field(
        False, description="make the body of an undercut drum all the same, from many roller positions; slow, rough"
    )


Words = Annotated[str, Field(min_length=1, max_length=40)]


@final
class TitleBlock(Section):
    """What the part drawing's title block says beside what the profile gives; nothing of it is judged."""

    number: Words | None = Field(None, description="drawing number")
    revision: Words | None = Field(None, description="revision, for example B")
    author: Words | None = Field(None, description="who drew it")
    date: Words | None = Field(None, description="date of the drawing, in quotes")
    approved: Words | None = Field(None, description="who approved it")
    general_tolerance: Words | None = Field(None, description="general tolerances, for example ISO 2768-mK")
    finish: Words | None = Field(None, description="finish of the flanks, for example Ra 0.8")
    treatment: Words | None = Field(None, description="heat treatment, for example case depth 0.9 + 0.2 mm")


@final
class Limits(Section):
    """What the checks judge against; a limit that is not given is not judged, or has the default named here."""

    pressure_angle_deg: Annotated[float, Field(gt=0.0, lt=90.0)] | None = Field(
        None, description="deg, largest pressure angle; default 30 translating, 45 swinging and frame, 50 turret"
    )
    min_wall_mm: Gap = Field(1.0, description="mm, thinnest wall of the cam body; twice the tolerance at least")
    warn_pressure_angle_deg: Annotated[float, Field(gt=0.0, lt=90.0)] | None = Field(
        None, description="deg, pressure angle above which to warn; default the customary one, as the limit's"
    )
    undercut_margin: Share = Field(0.0, description="1, smallest margin 1 - r k against undercut")
    warn_undercut_margin: Share = Field(0.05, description="1, margin against undercut below which to warn")
    warn_rib_share: Share = Field(
        0.2, description="1, share by which a drum's rib may be thinner than in a level dwell before a warning"
    )
    clearance_mm: Gap = Field(
        0.0, description="mm, smallest gap to what must not be touched: floor, other disc, other follower, pivot, blank"
    )
    play_mm: Gap | None = Field(
        None, description="mm, largest play between the two walls that drive a follower: of a groove or rib square to "
        "them (a follower on a steep flank moves by more, which tolerance.backlash_limit judges), of a pair as its "
        "clearance is given; default: beyond the loosest running fit of ISO 286, H11/c11 of the roller's diameter "
        "(frame, yoke: of the cam's width), a warning"
    )
    contact_pressure_mpa: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="MPa, largest peak contact pressure; default what the weaker material's "
        "fatigue line bears at 1e7 cycles, its contact_limit where contact_cycles are as many"
    )
    life_h: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="h, life that roller, bearing and cam surface must reach"
    )
    torque_n_m: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="N m, largest torque of the camshaft: rigid, with vibration, from rest and with impacts"
    )
    drive_force_n: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="N, largest force of a linear cam's drive along the travel: for follower, plate and slide"
    )
    output_torque_n_m: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="N m, largest torque of a turret's output shaft: with vibration and from rest; rigid, of all "
        "that turns with it, where there is no [dynamics]"
    )
    bolt_slip_safety: Annotated[float, Field(ge=1.0, le=100.0)] = Field(
        1.8, description="1, least safety of the bolts of [output_shaft] against slipping; VDI 2230-1 asks for 1.8 "
        "where the torque alternates, for 1.2 where it rests"
    )
    bolt_shear_safety: Annotated[float, Field(ge=1.0, le=100.0)] = Field(
        1.1, description="1, least safety against shearing them off, should they slip (VDI 2230-1)"
    )
    bearing_static_safety: Annotated[float, Field(gt=0.0, le=1e6)] = Field(
        1.0, description="1, least static safety of the roller's bearing: static_rating over its largest load (ISO 76)"
    )
    warn_bearing_static_safety: Annotated[float, Field(gt=0.0, le=1e6)] = Field(
        1.5, description="1, static safety below which to warn: makers of needle rollers ask for it in ordinary running"
    )
    velocity: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="mm/s (deg/s), largest peak velocity of the follower: rigid, with vibration and with impacts"
    )
    least_velocity: Annotated[float, Field(gt=0.0, le=1e9)] | None = Field(
        None, description="mm/s (deg/s), what that peak has to reach at least"
    )
    cycles_per_min: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="1/min, most cycles: turns of the cam"
    )
    on_time: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None, description="1, largest share of the turn in which the follower stands at the far end of its stroke, or "
        "a turret that steps on between its steps"
    )
    least_on_time: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None, description="1, smallest share of the turn in which it stands there"
    )

    bearing_reliability: Literal[90, 95, 96, 97, 98, 99] = Field(
        90, description="%, reliability at which the bearing's life is rated: the factor a1 of ISO 281"
    )
    film_ratio: Annotated[float, Field(gt=0.0, le=100.0)] | None = Field(
        None, description="1, least ratio lambda of film to roughness; without it only warn_film_ratio is judged"
    )
    warn_film_ratio: Annotated[float, Field(ge=0.0, le=100.0)] = Field(
        1.0, description="1, ratio lambda below which to warn: there the surfaces' peaks touch"
    )
    wear_um: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="um, largest depth that either surface may wear over life_h"
    )

    def for_follower(self, follower: AnyFollower) -> "Limits":
        """The limits with the defaults that depend on the follower filled in."""
        usual = follower.pressure_angle_limit
        limit = self.pressure_angle_deg or usual
        warn = self.warn_pressure_angle_deg or min(usual, limit)
        filled = {**dict(self), "pressure_angle_deg": limit, "warn_pressure_angle_deg": warn}
        return Limits.model_construct(self.model_fields_set, **filled)
