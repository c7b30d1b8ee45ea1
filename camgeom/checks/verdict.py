"""What a judgement says: pass, warn, fail or not judged; and of many, the worst."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from math import degrees, inf, isfinite
from typing import Any, Literal, final

from camgeom.errors import Unmade
from camgeom.immutable import immutable

Level = Literal["pass", "warn", "fail"]
Comparison = Literal["<=", ">=", "<", ">", "=", ""]
RANK: dict[Level, int] = {"pass": 0, "warn": 1, "fail": 2}
COUNTS = ("order", "rollers", "stops", "crossings", "jumps", "")
"""units of what is counted: a whole number is met, not approached"""
BY_CHOICE = ("chord-error", "hardness")
"""checks of what is brought as near its limit as it may be by choice: the mesh, the limit that a material is given"""
_HOLDS: dict[Comparison, Callable[[float, float], bool]] = {
    "<=": lambda value, limit: value <= limit,
    ">=": lambda value, limit: value >= limit,
    "<": lambda value, limit: value < limit,
    ">": lambda value, limit: value > limit,
    "=": lambda value, limit: value == limit,
    "": lambda value, limit: True,
}


ENDLESS_H = 1e7
"""h, 1 141 years; a life that is longer is told as unlimited (result.json keeps the figure)"""


def life_shown(hours: float | None) -> float | str:
    """A life, h, to be read: "unlimited" where it is endless (None, of the result too) or longer than ENDLESS_H."""
    return "unlimited" if hours is None or hours >= ENDLESS_H else hours


def life_told(hours: float | None) -> str:
    """A life in a sentence: with its unit, whole hours of long ones."""
    life = life_shown(hours)
    return life if isinstance(life, str) else f"{life:.0f} h" if life >= 1e3 else f"{life:.4g} h"


ROUNDING = {"mm": 1e-9, "deg": 1e-9, "N": 1e-9, "N mm": 1e-9, "1": 1e-12}
"""values below are rounding of what is zero"""
NO_GAP = ROUNDING["mm"]
"""mm; a gap of rounding is none"""


@final
@immutable(eq=True)
class Finding:
    """One fact judged: its value, which has to stand in the comparison with the limit, where, and what to do.

    value       None where it could not be computed (a failure), or is endless (a life without load)
    rigid       the figure of the rigid cam and follower, of findings that [dynamics] or [impact] make
    advice      what would mend it; given where the level is not "pass"
    """

    check: str
    level: Level
    value: float | None
    comparison: Comparison
    limit: float | None
    unit: str
    cam_angle_deg: float | None = None
    where: str = ""
    advice: str = ""
    rigid: float | None = None

    @property
    def place(self) -> str:
        """Where, in words, and the rigid figure beside."""
        beside = "" if self.rigid is None else f"rigid: {self.rigid:.6g} {self.unit}".rstrip()
        return "; ".join(words for words in (self.where, beside) if words)

    @property
    def passed(self) -> bool:
        """True unless it fails."""
        return self.level != "fail"

    @property
    def shown(self) -> float | str:
        """The value to be read: 0 below rounding, "unlimited" for an endless life; a dash where there is none."""
        if self.value is None:
            return "unlimited" if self.level == "pass" else "-"
        if self.unit == "h" and self.passed:
            return life_shown(self.value)
        return 0.0 if abs(self.value) < ROUNDING.get(self.unit, 0.0) else self.value

    @property
    def margin(self) -> float | None:
        """Room to the limit, % of it, negative beyond it; None without a number to compare with."""
        if self.value is None or not self.limit or self.comparison not in ("<=", ">=", "<", ">"):
            return None
        sign = 1.0 if self.comparison in (">=", ">") else -1.0
        return 100.0 * sign * (self.value - self.limit) / abs(self.limit)

    @property
    def room(self) -> str:
        """The margin in a few letters; empty without one."""
        if self.margin is None:
            return ""
        if abs(self.margin) >= 1000.0:
            return "far" if self.margin > 0.0 else "far beyond"
        # What passes is beyond its limit by rounding alone; a zero has no sign.
        return f"{(max(self.margin, 0.0) if self.level == 'pass' else self.margin) + 0.0:+.0f} %"

    def as_dict(self) -> dict[str, Any]:
        """The finding as plain data for result.json."""
        return {
            "check": self.check,
            "level": self.level,
            "value": self.value,
            "limit": self.limit,
            "comparison": self.comparison,
            "unit": self.unit,
            "margin": self.margin,
            "passed": self.passed,
            "cam_angle_deg": self.cam_angle_deg,
            "where": self.where,
            "advice": self.advice,
            "rigid": self.rigid,
        }


@final
@immutable(eq=True)
class NotJudged:
    """A check that applies and could not be made: what is missing, and what to give so that it is made."""

    check: str
    reason: str

    def as_dict(self) -> dict[str, str]:
        """The omission as plain data for result.json."""
        return {"check": self.check, "reason": self.reason}


def _on_the_turn(angle: float) -> float:
    """A cam angle, deg, from 0 up to a turn; 0 where it is rounding away from it."""
    turned = angle % 360.0
    return turned if BESIDE < turned < 360.0 - BESIDE else 0.0


BESIDE = 1e-9
"""deg"""


def judged(
    check: str,
    value: float,
    comparison: Comparison,
    limit: float | None,
    unit: str,
    advice: str,
    *,
    warn: float | None = None,
    slack: float = 0.0,
    cam_angle: float | None = None,
    where: str = "",
    worst: Level = "fail",
    unlimited: bool = False,
    rigid: float | None = None,
) -> Finding:
    """The finding of a value against its limit.

    warn       beyond it a designer would want to know, though the limit holds; in the sense of the same comparison
    slack      rounding or mesh error that the comparison forgives, in the value's unit
    cam_angle  rad; worst: the level beyond the limit ("warn" of what is never a failure)
    unlimited  whether an endless value means something here: a life without load
    A value or limit that is not finite, any other than such an endless one, never passes; the finding has none of it.
    """
    eased = value + slack if comparison in (">=", ">") else value - slack
    holds = _HOLDS[comparison]
    level: Level = "pass"
    endless = unlimited and value == inf and comparison in (">=", ">")
    if not (isfinite(value) or endless) or not (limit is None or isfinite(limit)):
        level = worst
        which, advice = "limit" if isfinite(value) or endless else "value", f": {advice}" if advice else ""
        advice = f"the {which} is not a finite number, so nothing was judged by it{advice}"
    elif limit is not None and not holds(eased, limit):
        level = worst
    elif warn is not None and not holds(value, warn):
        level = "warn"
        usual = f"{comparison} {warn:g} {unit}" if unit != "1" else f"{comparison} {warn:g}"
        advice = f"allowed, but {usual} is customary: {advice}" if warn else advice
    return Finding(
        check,
        level,
        float(value) if isfinite(value) else None,
        comparison,
        limit if limit is None or isfinite(limit) else None,
        unit,
        None if cam_angle is None or not isfinite(cam_angle) else _on_the_turn(degrees(cam_angle)),
        where,
        "" if level == "pass" else advice,
        rigid if rigid is not None and isfinite(rigid) else None,
    )


@final
@immutable(eq=True)
class Loads:
    """Whose loads were judged, a statement and no finding: the rigid follower's, and which solver's beside them.

    shortest_move_ms  time of the program's shortest segment that moves; None of a program that stands still
    """

    vibration: bool
    impacts: bool
    shortest_move_ms: float | None

    @property
    def rigid(self) -> bool:
        """Whether all loads are those of a rigid follower without play."""
        return not (self.vibration or self.impacts)

    @property
    def whose(self) -> str:
        """The statement in a word or two."""
        beside = [words for given, words in ((self.vibration, "vibration"), (self.impacts, "impacts")) if given]
        return f"with {' and '.join(beside)}" if beside else "rigid"

    @property
    def sentence(self) -> str:
        """The statement as one line."""
        if not self.rigid:
            return f"loads: of the rigid follower, and {self.whose}"
        words = "loads: of a rigid follower; without [dynamics] or [impact] nothing says how it vibrates or strikes"
        if self.shortest_move_ms is None:
            return words
        return f"{words} (rigid is what swings many times within the shortest move, {self.shortest_move_ms:.4g} ms)"

    def as_dict(self) -> dict[str, Any]:
        """The statement as plain data for result.json."""
        return {"rigid": self.rigid, "vibration": self.vibration, "impacts": self.impacts,
                "shortest_move_ms": self.shortest_move_ms}  # fmt: skip


@final
@immutable(eq=True)
class Verdict:
    """All judgements of one design.

    lost   checks whose figures could not be computed, with the reason; they stand among the `not_judged` too
    loads  whose loads were judged; None without an [operation]
    """

    findings: tuple[Finding, ...]
    not_judged: tuple[NotJudged, ...] = ()
    lost: tuple[tuple[str, Unmade], ...] = ()
    loads: Loads | None = None

    @property
    def level(self) -> Level:
        """The worst of the findings."""
        return worst_of(finding.level for finding in self.findings)

    @property
    def sentence(self) -> str:
        """The verdict with its counts, as one line."""
        total, open_ = len(self.findings), len(self.not_judged)
        counted = sum(finding.level == self.level for finding in self.findings)
        heads = {
            "fail": f"FAIL, {counted} of {total} findings",
            "warn": f"WARN, {counted} of {total} findings",
            "pass": f"PASS of what was judged, {total} findings" if open_ else f"PASS, {total} findings",
        }
        return heads[self.level] + (f"; {open_} not judged" if open_ else "")

    @property
    def closest(self) -> Finding | None:
        """The finding that holds with the least room to its limit, in %; counts and the mesher's own goal aside."""
        holding = [f for f in self.findings if f.margin is not None and f.level != "fail"]
        holding = [f for f in holding if f.unit not in COUNTS and f.check not in BY_CHOICE]
        return min(holding, key=lambda f: f.margin or 0.0, default=None)


def worst_of(levels: Iterable[Level]) -> Level:
    """The worst of some levels; "pass" of none."""
    return max(levels, key=lambda level: RANK[level], default="pass")
