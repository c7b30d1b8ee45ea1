"""The `[tolerance]` table of a profile: how far assembly and manufacture may err, and what the follower may do then."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil
from typing import TYPE_CHECKING, Annotated, Literal, Self, final

from pydantic import BeforeValidator, Field, model_validator

from camgeom.errors import Problem
from camgeom.keys import Gap, Length, Section, SignedLength
from camgeom.solid.mechanism import Drive
from camgeom.tolerance.fits import clearance, limits
from camgeom.track.follower import CylinderRoller

if TYPE_CHECKING:
    from camgeom.solid.mechanism import Mechanism
    from camgeom.tolerance.causes import Cause, Pivots

Distribution = Literal["normal", "uniform", "worst"]
FITTED = {"cam_eccentricity": "pair", "turret_eccentricity": "pair", "running_clearance": "gap",
          "roller_diameter": "size"}  # fmt: skip
"""errors that an ISO fit can state: half the largest clearance of a pair, a gap from wall to wall, one body's size"""

TILTS = frozenset({"crossing_arcmin", "skew_arcmin", "cam_wobble_arcmin", "turret_wobble_arcmin", "roller_tilt_arcmin",
                   "face_squareness_arcmin"})  # fmt: skip
"""errors that press the ends of a line of contact"""
PIVOTED = ("crossing_arcmin", "skew_arcmin", "squareness_arcmin", "cam_yaw_arcmin")
"""errors that turn about axes_pivot"""
FEWEST = 1000
"""machines that are drawn at least"""
RARE = 10.0
"""machines beyond a limit that a share of them is told from"""


@final
class Scatter(Section):
    """An error: +- value about mean, and how it is distributed between; or the ISO 286 fit that leaves it."""

    value: Gap | None = Field(None, description="half the tolerance: the error lies within +- value about its mean")
    mean: SignedLength = Field(0.0, description="what it is on the average")
    distribution: Distribution | None = Field(
        None, description="normal: value is three standard deviations; uniform; worst: always at one end or the other"
    )
    fit: Annotated[str, Field(min_length=2, max_length=12)] | None = Field(
        None, description="ISO 286 instead of a value: a fit such as \"H7/k6\" of eccentricities (half its largest "
        "clearance) and of running_clearance, a size such as \"h6\" of rollers"
    )
    size: Length | None = Field(None, description="mm, nominal size of the fit; default the bore's, the roller's")

    @model_validator(mode="after")
    def _one_of_both(self) -> Self:
        if (self.value is None) == (self.fit is None):
            raise ValueError("needs either a value or an ISO fit")
        if self.fit is not None and self.mean:
            raise ValueError("a fit has its own mean")
        if self.size is not None and self.fit is None:
            raise ValueError("only a fit has a nominal size")
        return self


def _scatter(value: object) -> object:
    """A plain number is a value."""
    return {"value": float(value)} if isinstance(value, int | float) and not isinstance(value, bool) else value


Error = Annotated[Scatter | float | None, BeforeValidator(_scatter)]
Weight = Annotated[float, Field(gt=0.0, le=1e6, allow_inf_nan=False)]


def _error(text: str, unit: str = "mm") -> Scatter | None:
    """A key of one error."""
    found: Scatter | None = Field(
        None, description=f"{unit}, {text}; a number is +- value, or {{ value, distribution, mean }}"
    )
    return found


@final
class Costs(Section):
    """What it costs to hold each error: weights of the widest tolerances, 1 where none is given."""

    center_distance: Weight = 1.0
    side_shift: Weight = 1.0
    axial_shift: Weight = 1.0
    crossing_arcmin: Weight = 1.0
    skew_arcmin: Weight = 1.0
    squareness_arcmin: Weight = 1.0
    phase_arcmin: Weight = 1.0
    cam_yaw_arcmin: Weight = 1.0
    cam_eccentricity: Weight = 1.0
    cam_wobble_arcmin: Weight = 1.0
    turret_eccentricity: Weight = 1.0
    turret_wobble_arcmin: Weight = 1.0
    roller_diameter: Weight = 1.0
    pitch_angle_arcsec: Weight = 1.0
    pitch_radius: Weight = 1.0
    roller_place: Weight = 1.0
    roller_axial: Weight = 1.0
    roller_tilt_arcmin: Weight = 1.0
    face_squareness_arcmin: Weight = 1.0
    flank_form: Weight = 1.0
    flank_growth: Weight = 1.0
    running_clearance: Weight = 1.0

    def of(self, key: str) -> float:
        """The weight of an error."""
        weight: float = dict(self)[key]
        return weight


@final
class ToleranceSpec(Section):
    """Errors of assembly and manufacture, each independent of the others, and the limits of what they may do.

    Angles are seconds or minutes of arc, as the keys' names say. Errors of rollers are those of each roller, all of one
    tolerance.
    """

    center_distance: Error = _error("follower off along the line of centres; of a slide along X, where it stands; of a "
                                    "linear cam across the travel, along Y")
    side_shift: Error = _error("follower off across the cam's axis and the line of centres; of a linear cam along the "
                               "travel, along -X")
    axial_shift: Error = _error("cam off along its axis, a plate along Z")
    crossing_arcmin: Error = _error("cam's axis turned about the line of centres: crossing angle, twist; plate and "
                                    "travel of a linear cam tilted about Y", "arcmin")
    skew_arcmin: Error = _error("cam's axis tilted in the plane with the line of centres; plate and travel of a linear "
                                "cam tilted about X", "arcmin")
    squareness_arcmin: Error = _error("plate and travel of a linear cam turned about Z: out of square to the follower",
                                      "arcmin")
    phase_arcmin: Error = _error("cam turned on its shaft; the drive of a linear cam turned ahead", "arcmin")
    cam_yaw_arcmin: Error = _error("plate of a linear cam turned about Z on its slide, whose travel is true", "arcmin")
    cam_eccentricity: Error = _error("cam's axis beside its shaft's, any way; or its { fit = \"H7/k6\" }")
    cam_wobble_arcmin: Error = _error("cam's axis askew on its shaft, any way", "arcmin")
    turret_eccentricity: Error = _error("circle of the rollers beside the turret's axis, any way; or its "
                                        "{ fit = \"H7/k6\" }")
    turret_wobble_arcmin: Error = _error("plane of the rollers askew on the turret's axis, any way", "arcmin")
    roller_diameter: Error = _error("diameter of each roller; or { fit = \"h6\" }, a size")
    pitch_angle_arcsec: Error = _error("angle of each roller about the follower's axis", "arcsec")
    pitch_radius: Error = _error("distance of each roller from the follower's axis")
    roller_place: Error = _error("place of each roller or face of a slide along its motion")
    roller_axial: Error = _error("place of each roller along the follower's axis, on a slide along its own")
    roller_tilt_arcmin: Error = _error("axis of each roller, or line of a face, askew, any way", "arcmin")
    face_squareness_arcmin: Error = _error("flat face askew in the plane of the disc", "arcmin")
    flank_form: Error = _error("form of each wall of the cam, in waves round it")
    flank_growth: Error = _error("stock left on each wall of the cam")
    running_clearance: Error = _error("gap on either side beyond the nominal one; or a { fit = ... } from wall to wall")
    distribution: Distribution = Field("normal", description="of the errors that state none: normal (value is three "
                                       "standard deviations), uniform, worst (always at an end)")
    axes_pivot: tuple[SignedLength, SignedLength, SignedLength] | None = Field(
        None, description="mm, point about which crossing, skew, squareness and yaw turn; default where the line of "
        "centres meets the cam's axis, else the middle of the cam on it; of a linear cam the roller's place at zero "
        "travel in the middle of its contact, of yaw the point of the plate that is there then"
    )
    wobble_pivot: SignedLength | None = Field(None, description="mm, z about which the cam wobbles; default as above")
    turret_pivot: SignedLength = Field(0.0, description="mm along the turret's axis from the line of centres, where it "
                                       "wobbles")
    roller_pivot: SignedLength = Field(0.0, description="mm along a roller from the middle of its contact, where it "
                                       "tilts")
    flank_waves: Annotated[int, Field(ge=1, le=360)] = Field(3, description="1, waves of flank_form in a cam turn")
    reference: Literal["absolute", "first-dwell"] = Field(
        "absolute", description="what the follower's error is measured from: the drawing, or where this machine's "
        "follower stands in the first dwell of the first stop"
    )
    dwell_limit: Annotated[float, Field(gt=0.0, le=1e7)] | None = Field(
        None, description="um (seconds of arc of what turns), largest error of the follower's place in its dwells"
    )
    motion_limit: Annotated[float, Field(gt=0.0, le=1e7)] | None = Field(
        None, description="um (seconds of arc), largest error of its place anywhere in the turn"
    )
    backlash_limit: Annotated[float, Field(gt=0.0, le=1e7)] | None = Field(
        None, description="um (seconds of arc), largest play of the follower in its dwells (of a program without one: "
        "anywhere)"
    )
    preload_limit: Annotated[float, Field(gt=0.0, le=1e4)] | None = Field(
        None, description="um, least interference along the normals in the dwells that a preloaded turret has to keep"
    )
    pressure_limit: Annotated[float, Field(gt=0.0, le=1e6)] | None = Field(
        None, description="MPa, largest contact pressure of line contacts in the turn, at all stops"
    )
    wanted_yield: Annotated[float, Field(gt=0.0, lt=1.0)] = Field(
        0.99, alias="yield", description="1, share of the machines that have to keep each limit"
    )
    samples: Annotated[int, Field(ge=FEWEST, le=20_000_000)] = Field(
        100_000, description="1, machines that are drawn; the same ones every time"
    )
    cost: Costs = Field(Costs(), description="weights of the widest tolerances: what it costs to hold each error")

    @property
    def least_samples(self) -> int:
        """Machines that tell the wanted yield."""
        return max(FEWEST, ceil(RARE / (1.0 - self.wanted_yield) * (1.0 - 1e-9)))

    def stated(self) -> dict[str, Scatter]:
        """The errors given, by key."""
        return {key: value for key, value in self if isinstance(value, Scatter)}

    def pivots(self, mechanism: Mechanism) -> Pivots:
        """About what tilts turn."""
        from camgeom.tolerance.causes import Pivots, default_pivots

        usual = default_pivots(mechanism)
        axes = usual.axes if self.axes_pivot is None else self.axes_pivot
        wobble = usual.wobble if self.wobble_pivot is None else self.wobble_pivot
        return Pivots(axes, wobble, self.turret_pivot, self.roller_pivot, self.flank_waves)

    def spread(self, cause: Cause, mechanism: Mechanism) -> tuple[float, float, Distribution]:
        """Mean and half width of an error, in mm or rad, and its distribution. Raises ValueError for a wrong fit."""
        given = self.stated()[cause.key]
        mean, value = given.mean, given.value or 0.0
        if given.fit is not None:
            mean, value = _fitted(cause.key, given, mechanism)
        return mean * cause.scale, value * cause.scale, given.distribution or self.distribution

    def problems(self, mechanism: Mechanism) -> Iterator[Problem]:
        """Errors that this cam cannot have, and fits that cannot be looked up."""
        from camgeom.tolerance.causes import CAUSES, applicable

        possible = {cause.key for cause in applicable(mechanism)}
        for key, given in self.stated().items():
            if key not in possible:
                yield Problem(f"tolerance.{key}", "means nothing here", None, f"one of {', '.join(sorted(possible))}",
                              f"{CAUSES[key].what}: this cam has none")  # fmt: skip
            elif given.fit is not None:
                try:
                    self.spread(CAUSES[key], mechanism)
                except ValueError as why:
                    yield Problem(f"tolerance.{key}.fit", str(why), given.fit)
            elif given.mean and CAUSES[key].parts == 2:
                yield Problem(f"tolerance.{key}.mean", "means nothing here: its direction is any", given.mean, "0")
        for key in sorted(self.cost.model_fields_set - self.stated().keys()):
            yield Problem(f"tolerance.cost.{key}", "means nothing here: no such error is given")
        yield from self._limit_problems(mechanism)
        turret = mechanism.turret
        if self.preload_limit is not None and (turret is None or turret.preload <= 1e-3 * self.preload_limit):
            nominal = turret.preload if turret is not None else 0.0
            allowed = f"below the nominal {1e3 * nominal:g} um" if nominal else "none: there is no preload"
            yield Problem("tolerance.preload_limit", "is never kept", self.preload_limit, allowed)
        if not self.stated():
            yield Problem("tolerance", "states no error", None, f"one of {', '.join(sorted(possible))}")
        if self.wobble_pivot is not None and self.cam_wobble_arcmin is None:
            yield Problem("tolerance.wobble_pivot", "means nothing without cam_wobble_arcmin", self.wobble_pivot)
        if self.axes_pivot is not None and not any(key in PIVOTED for key in self.stated()):
            keys = [key for key in PIVOTED if key in possible]
            yield Problem("tolerance.axes_pivot", f"means nothing without {', '.join(keys[:-1])} or {keys[-1]}")
        if self.turret_pivot and self.turret_wobble_arcmin is None:
            yield Problem("tolerance.turret_pivot", "means nothing without turret_wobble_arcmin", self.turret_pivot)
        if self.roller_pivot and self.roller_tilt_arcmin is None:
            yield Problem("tolerance.roller_pivot", "means nothing without roller_tilt_arcmin", self.roller_pivot)
        if "flank_waves" in self.model_fields_set and self.flank_form is None:
            yield Problem("tolerance.flank_waves", "means nothing without flank_form", self.flank_waves)

    def _limit_problems(self, mechanism: Mechanism) -> Iterator[Problem]:
        """Limits that this cam, with these errors and so many samples, cannot be judged by."""
        if self.backlash_limit is not None and mechanism.drive is Drive.ALONE:
            why = "means nothing here: what a spring or weight holds on its cam has no play"
            yield Problem("tolerance.backlash_limit", why, self.backlash_limit)
        if self.pressure_limit is not None:
            tilts = sorted(key for key in self.stated() if key in TILTS)
            if tilts:
                why = f"cannot be judged beside {', '.join(tilts)}: tilts press the ends of lines, told as `edge` alone"
                yield Problem("tolerance.pressure_limit", why, self.pressure_limit)
            elif any(roller.ends.stated or not isinstance(roller, CylinderRoller) for roller in mechanism.rollers):
                why = "is of straight cylinders that stand level and touch along a line"
                yield Problem("tolerance.pressure_limit", why, self.pressure_limit)
        if self.samples < (least := self.least_samples):
            yield Problem("tolerance.samples", "are too few for this yield", self.samples, f"{least} or more")
        if self.reference == "first-dwell" and not any(span.before == span.after for span in mechanism.program.spans):
            yield Problem("tolerance.reference", "means nothing here: the motion has no dwell", self.reference)


def _fitted(key: str, given: Scatter, mechanism: Mechanism) -> tuple[float, float]:
    """Mean and half width, mm, of an error that an ISO fit leaves."""
    fit, kind = given.fit or "", FITTED.get(key)
    if kind is None:
        raise ValueError(f"states no {key}: a fit says eccentricities, running_clearance and roller_diameter")
    size = given.size
    if size is None:
        bore = mechanism.bore.diameter if mechanism.bore is not None else None
        sizes = {roller.diameter for roller in mechanism.rollers}
        if len(sizes) > 1 and key == "roller_diameter":
            raise ValueError("has two nominal sizes here, those of both rollers: give size, mm")
        roller = min(sizes, default=None)
        size = {"cam_eccentricity": bore, "turret_eccentricity": None}.get(key, roller)
    if size is None:
        raise ValueError("has no nominal size here: give size, mm")
    if kind == "size":
        low, high = limits(fit, size)
        return 0.5 * (low + high), 0.5 * (high - low)
    least, most = clearance(fit, size)
    if kind == "pair":
        return 0.0, 0.5 * max(most, 0.0)
    if mechanism.running_clearance:
        raise ValueError("is the whole gap: leave cam.running_clearance out, or give +- a value beyond it")
    return 0.25 * (least + most), 0.25 * (most - least)

