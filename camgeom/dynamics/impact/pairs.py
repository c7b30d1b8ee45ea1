"""Pairs of contacts of rollers with free play: two on a rocker or a slide, one in a groove (SI units)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from camgeom.dynamics.impact.lift import Lift
from camgeom.dynamics.impact.roller import (
    CurveSide,
    DevelopedCurve,
    DiscCurve,
    SlideArm,
    SwingArm,
    check_profile,
    profile_problem,
)
from camgeom.dynamics.impact.side import ClearanceKind, Pair, check_clearance
from camgeom.errors import Problem

_CHORD = "chord between the two limiting positions of the roller centre"
_NORMAL = "gap along the common normal"


@final
@dataclass(frozen=True)
class RockerPair(Pair):
    """Two disc cams and a rocker with two rollers, one a cam; the rocker turns by q [rad] from its lowest position.

    `center_distance` of cam shaft and pivot, `arm_main`, `arm_return`, `roller_radius`, `base_radius` of the main
    profile, `arm_angle` between the arms (None: the angle that makes two equal arms mirror images), `clearance`, in m
    and rad. By "chord" the return cam is cut for a rocker ahead by 2 asin(c/(2 l)); by "normal" it is cut for the same
    position and lies back by c along its normal. Raises ProfileError where the triangle does not close or the
    profile is undercut.
    """

    lift: Lift
    center_distance: float
    arm_main: float
    arm_return: float
    roller_radius: float
    base_radius: float
    clearance: float
    clearance_kind: ClearanceKind = "chord"
    arm_angle: float | None = None

    def __post_init__(self) -> None:
        check_clearance(self.clearance)
        profile_problem(
            rocker_problems(
                self.center_distance, self.arm_main, self.roller_radius, self.base_radius, self.lift.peaks[0]
            )
        )
        main, back = self.sides
        profile_problem(check_profile(main, self.lift, "main") + check_profile(back, self.lift, "return"))

    @cached_property
    def lowest(self) -> float:
        """Angle [rad] between main arm and line of centres at zero lift."""
        a, l, r = self.center_distance, self.arm_main, self.base_radius + self.roller_radius
        return math.acos((a * a + l * l - r * r) / (2.0 * a * l))

    @cached_property
    def angle_between(self) -> float:
        """Angle [rad] from the main arm to the return arm."""
        return 2.0 * self.lowest + self.lift.peaks[0] if self.arm_angle is None else self.arm_angle

    @property
    def play(self) -> float:
        return 2.0 * math.asin(self.clearance / (2.0 * self.arm_return))

    @property
    def clearance_text(self) -> str:
        return _CHORD if self.clearance_kind == "chord" else _NORMAL

    @cached_property
    def sides(self) -> tuple[CurveSide, CurveSide]:
        a = self.center_distance
        arms = (
            SwingArm(a, self.arm_main, -self.lowest),
            SwingArm(a, self.arm_return, self.angle_between - self.lowest),
        )
        return _disc_sides(arms, self.roller_radius, self.clearance, self.play, self.clearance_kind)

    def with_clearance(self, clearance: float) -> RockerPair:
        return replace(self, clearance=clearance)

    def pressure_angle(self, count: int = 721) -> float:
        """Largest pressure angle [rad] of the two rollers over a turn."""
        angle = np.linspace(0.0, 2.0 * math.pi, count)
        worst = 0.0
        for side, arm in zip(self.sides, (self.arm_main, self.arm_return), strict=True):
            levers = side.many(self.lift, angle, np.zeros(count))[1]
            worst = max(worst, float(np.arccos(np.clip(np.abs(levers) / arm, 0.0, 1.0)).max()))
        return worst


@final
@dataclass(frozen=True)
class SlidePair(Pair):
    """Two disc cams and a slide along +x with a roller on either side of the shaft; q is the slide's lift [m].

    `base_main`, `base_return` [m] are the profile radii under the rollers at zero lift, `offset` [m] that of the
    slide's line towards +y. By "chord" the return cam is cut for a slide ahead by the clearance.
    """

    lift: Lift
    base_main: float
    base_return: float
    roller_radius: float
    clearance: float
    clearance_kind: ClearanceKind = "chord"
    offset: float = 0.0

    def __post_init__(self) -> None:
        check_clearance(self.clearance)
        problems = []
        for key, base in (("base_main", self.base_main), ("base_return", self.base_return)):
            least = abs(self.offset) - self.roller_radius
            if not base > max(least, 0.0):
                problems.append(Problem(key, "the roller does not reach its line", base, f"> {max(least, 0.0):g} m"))
        if self.base_return <= self.lift.peaks[0]:
            problems.append(Problem("base_return", "below the stroke", self.base_return, f"> {self.lift.peaks[0]:g} m"))
        profile_problem(problems)
        main, back = self.sides
        profile_problem(check_profile(main, self.lift, "main") + check_profile(back, self.lift, "return"))

    @property
    def play(self) -> float:
        return self.clearance

    @property
    def clearance_text(self) -> str:
        return _CHORD if self.clearance_kind == "chord" else _NORMAL

    @cached_property
    def sides(self) -> tuple[CurveSide, CurveSide]:
        r, e = self.roller_radius, self.offset
        front, rear = (math.sqrt((base + r) ** 2 - e * e) for base in (self.base_main, self.base_return))
        arms = (SlideArm(complex(front, e)), SlideArm(complex(-rear, e)))
        return _disc_sides(arms, r, self.clearance, self.play, self.clearance_kind)

    def with_clearance(self, clearance: float) -> SlidePair:
        return replace(self, clearance=clearance)


def _disc_sides(
    arms: tuple[SwingArm, SwingArm] | tuple[SlideArm, SlideArm],
    radius: float,
    clearance: float,
    play: float,
    kind: ClearanceKind,
) -> tuple[CurveSide, CurveSide]:
    """The main profile is cut to touch at eta = 0; the return profile leaves the play."""
    chord = kind == "chord"
    main = CurveSide(arms[0], DiscCurve(arms[0]), radius, 1, begins=0.0)
    curve = DiscCurve(arms[1], play if chord else 0.0)
    gap = 0.0 if chord else clearance
    return main, CurveSide(arms[1], curve, radius, -1, gap=gap, begins=play if chord else None)


@final
@dataclass(frozen=True)
class GroovePair(Pair):
    """A roller on a slide in a groove of constant width, roller diameter plus clearance, on the developed cylinder.

    q is the lift along the cam axis [m], `pitch_radius` [m] that of the development. The clearance is the gap along the
    normal, half on either side of the path; it has no chord that is the same all round.
    """

    lift: Lift
    pitch_radius: float
    roller_radius: float
    clearance: float

    def __post_init__(self) -> None:
        check_clearance(self.clearance)
        main, back = self.sides
        profile_problem(check_profile(main, self.lift, "lower wall") + check_profile(back, self.lift, "upper wall"))

    @property
    def play(self) -> float:
        angle = np.linspace(0.0, 2.0 * math.pi, 361)[:-1]
        slope = self.lift.many(angle, 1)[1] / self.pitch_radius
        return self.clearance * float(np.sqrt(1.0 + slope**2).mean())

    @property
    def clearance_text(self) -> str:
        return _NORMAL

    @cached_property
    def sides(self) -> tuple[CurveSide, CurveSide]:
        arm, curve, half = SlideArm(0j, 1j), DevelopedCurve(self.pitch_radius), 0.5 * self.clearance
        r = self.roller_radius
        return CurveSide(arm, curve, r, 1, 1, half), CurveSide(arm, curve, r, -1, -1, half)

    def with_clearance(self, clearance: float) -> GroovePair:
        return replace(self, clearance=clearance)


def rocker_problems(
    center_distance: float, arm: float, roller_radius: float, base_radius: float, swing: float
) -> list[Problem]:
    """What keeps a rocker from being assembled: the triangle of cam shaft, pivot and roller centre must close.

    The hints give the range of each length, the others kept. Lengths in m.
    """
    a, l, r = center_distance, arm, base_radius + roller_radius
    if not min(a, l, roller_radius, base_radius) > 0.0:
        return [Problem("center_distance", "lengths must be positive", min(a, l, roller_radius, base_radius), "> 0 m")]
    problems = []
    if not abs(a - l) < r < a + l:
        cosine = (a * a + l * l - r * r) / (2.0 * a * l)
        least, most = abs(a - l) - roller_radius, a + l - roller_radius
        hint = (
            f"the roller centre would need cos(psi) = {cosine:.6f}; keep the other lengths and take base_radius "
            f"{_mm(least)}..{_mm(most)} mm, or arm {_mm(abs(a - r))}..{_mm(a + r)} mm, "
            f"or center_distance {_mm(abs(l - r))}..{_mm(l + r)} mm"
        )
        problems.append(
            Problem(
                "base_radius", "the mechanism cannot be assembled", base_radius, f"{least:.6g} to {most:.6g} m", hint
            )
        )
    elif math.acos((a * a + l * l - r * r) / (2.0 * a * l)) + swing >= math.pi:
        problems.append(Problem("motion", "the rocker swings through the line of centres", swing, "less swing"))
    return problems


def _mm(length: float) -> str:
    return f"{1e3 * length:.6g}"
