"""Variants of a profile: its keys varied, what they may be, and why one cannot exist."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from copy import copy
from functools import lru_cache
from math import pi
from typing import TYPE_CHECKING, Any, final

import numpy as np
from numpy.typing import NDArray

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.mechanics.load import Demand
from camgeom.model.loads import DEGREES

if TYPE_CHECKING:
    from pydantic.fields import FieldInfo

    from camgeom.profile import Profile

Mask = NDArray[np.bool_]

SOLVED = ("dynamics", "impact", "cutter", "tolerance")
"""tables of a profile that a solver of their own answers"""
KEY = re.compile(r"([\w-]+)(?:\[(\d+)\])?")


@lru_cache(maxsize=1024)
def path_of(key: str) -> tuple[str | int, ...]:
    """The path of a key through tables and arrays: "motion[0].to" is ("motion", 0, "to")."""
    path: list[str | int] = []
    for part in key.split("."):
        found = KEY.fullmatch(part)
        if found is None:
            raise ValueError(f"{key!r} is no key of a profile")
        path += [found[1]] if found[2] is None else [found[1], int(found[2])]
    return tuple(path)


BEARING = {
    "limits.bearing_reliability", *(f"roller.{key}" for key in (
        "bearing_type", "fatigue_load_limit", "contamination", "pitch_diameter", "max_radial_load", "max_static_load",
        "limiting_speed", "designation", "catalogue")),
}  # fmt: skip
"""keys of a bearing that no kernel knows"""


def refused_keys(profile: Profile, varied: Sequence[str]) -> str | None:
    """Why no kernel carries these keys, whatever the cam; None where that is for the kernel to say."""
    from camgeom.profile.idle import ENDS, idle_keys

    if profile.units != "mm":
        return "a profile in inches is computed by the exact model"
    if profile.duty:
        return "[[duty]]: damage is summed over its states by the exact model"
    if profile.track:
        return "[[track]]: several tracks on one body are left to the exact model"
    if profile.station:
        return "[[station]]: several followers on one track are left to the exact model"
    if profile.return_roller is not None:
        return "rollers of two kinds: a [return_roller] is left to the exact model"
    roller, limits = profile.roller, profile.limits
    if roller is not None and roller.dynamic_rating is not None:
        simple = roller.bearing_type == "roller" and limits.bearing_reliability == 90
        bent = roller.max_static_load is not None or roller.max_radial_load is not None
        if not simple or bent or profile.lubricant is not None:
            return "the bearing is rated by the exact model where more than C and C0 of it is given"
    idle = idle_keys(profile, profile.setup())
    if profile.roller is not None and profile.roller.ends.stated:
        return "how the roller ends or stands is left to the exact model: its contact is solved on a half-space"
    if profile.roller is not None and profile.roller.arc is not None and profile.follower.shares:
        return "crowned rollers that share a turret's torque are left to the exact model"
    for key in varied:
        table = path_of(key)[0]
        if key in BEARING:
            return f"{key}: the bearing is rated by the exact model where more than C and C0 of it is given"
        if table == "output_shaft" or key.startswith("limits.bolt_"):
            return f"{key}: output shaft and bolts are left to the exact model"
        if table in SOLVED:
            return f"{key}: [{table}] is answered by a solver, which takes one variant at a time"
        moved = table == "operation" or key in ("follower.mass", "follower.inertia")
        if moved and (profile.dynamics is not None or profile.impact is not None):
            return f"{key}: the profile's [dynamics] or [impact] is solved again for every variant"
        if key in (f"roller.{end}" for end in ENDS):
            return f"{key}: is left to the exact model, which solves the contact on a half-space"
        if key in idle:
            return f"{key}: means nothing here ({idle[key]})"
        if not isinstance(value_of(profile, key), int | float | None) or isinstance(value_of(profile, key), bool):
            return f"{key}: is no number"
        if _field(profile, key) is None:
            return f"{key}: is not known to the batch"
    return None


def value_of(profile: Profile, key: str) -> Any:
    """What the profile has at a key; None where it leaves it out."""
    here: Any = profile
    for part in path_of(key):
        if here is None:
            return None
        if isinstance(part, int):
            here = here[part] if part < len(here) else None
        else:
            here = getattr(here, {"from": "begin"}.get(part, part), None)
    return here


def _field(profile: Profile, key: str) -> FieldInfo | None:
    """The field of the section that a key is in; None where it is in none (a law's own key)."""
    *parents, last = path_of(key)
    owner: Any = profile
    for part in parents:
        owner = owner[part] if isinstance(part, int) else getattr(owner, part, None)
    fields = getattr(type(owner), "model_fields", {})
    found: FieldInfo | None = fields.get({"from": "begin"}.get(str(last), str(last)))
    return found


@final
@immutable
class Batch:
    """What n variants came to.

    figures  by the names of a study's columns, (n,) each; infinite where there is no end (an unloaded contact lives
             for ever) or no such place (a profile that is nowhere hollow), never NaN
    reason   (n,) 0 where the variant exists, else a place in `reasons`: its figures are 0 and mean nothing
    reasons  the exact model's own words: "key: what is wrong with it", or the name of the check that it fails
    """

    figures: dict[str, Floats]
    reason: NDArray[np.int16]
    reasons: tuple[str, ...]

    @property
    def words(self) -> list[str]:
        """The reason of every variant in words, empty where it exists."""
        return [self.reasons[code] for code in self.reason]


class Variants:
    """A profile with some of its keys varied: a number (1,) where a key is not varied, (n,) where it is.

    rows  which of the columns' values are theirs, (n,); None: all
    """

    def __init__(self, profile: Profile, columns: Mapping[str, Floats]) -> None:
        self.profile = profile
        self.columns = columns
        self.size = len(next(iter(self.columns.values())))
        self.rows: NDArray[np.intp] | None = None
        self.precision: type[np.floating] = np.float64
        self.refusals = Refusals(self.size)
        for key, values in self.columns.items():
            self.refusals.add(_beyond(profile, key, values), f"{key}: out of range")
        if self.varied("limits."):
            self._refuse_warnings()

    def _refuse_warnings(self) -> None:
        """Thresholds of warnings beyond the limit they stand before."""
        angle, margin = self.optional("limits.pressure_angle_deg"), self.number("limits.undercut_margin")
        for key, limit in (("limits.warn_pressure_angle_deg", angle), ("limits.warn_undercut_margin", margin)):
            warn = self.optional(key)
            stated = key in self.columns or key.removeprefix("limits.") in self.profile.limits.model_fields_set
            if warn is None or limit is None or not stated:
                continue
            beyond = warn > limit if limit is angle else (warn > 0.0) & (warn < limit)
            self.refusals.add(beyond, f"{key}: the limit fails before it warns")

    def of(self, rows: NDArray[np.intp]) -> Variants:
        """These variants, each as often as it is named, without their reasons."""
        found = copy(self)
        # Columns are taken when they are asked for: few are.
        found.rows = rows if self.rows is None else self.rows.take(rows)
        found.size, found.refusals = len(rows), Refusals(len(rows))
        return found

    @property
    def rough(self) -> Variants:
        """The same in single precision, without their reasons."""
        found = copy(self)
        found.precision, found.refusals = np.float32, Refusals(self.size)
        return found

    def number(self, key: str) -> Floats:
        """The value of a key, (n,) or (1,); a key that the profile leaves out must have a default."""
        found = self.optional(key)
        if found is None:
            raise ValueError(f"the profile has no {key}")
        return found

    def optional(self, key: str) -> Floats | None:
        """The same; None where the profile leaves it out and it is not varied."""
        value: Any
        if key in self.columns:
            value = self.columns[key] if self.rows is None else self.columns[key].take(self.rows)
        else:
            value = value_of(self.profile, key)
        return None if value is None else np.atleast_1d(np.asarray(value, dtype=self.precision))

    def varied(self, *prefixes: str) -> bool:
        """Whether a key is varied that begins with one of these."""
        return any(key.startswith(prefix) for key in self.columns for prefix in prefixes)

    def full(self, values: Floats | float) -> Floats:
        """One number for every variant, (n,)."""
        return np.array(np.broadcast_to(values, (self.size,)), dtype=self.precision)


def _beyond(profile: Profile, key: str, values: Floats) -> Mask:
    """Where values of a key are outside the range that its section allows."""
    from camgeom.profile.errors import _constraints

    info = _field(profile, key)
    bad = ~np.isfinite(values)
    for one in [*info.metadata, *_constraints(info.annotation)] if info is not None else ():
        for name, within in (("gt", np.greater), ("ge", np.greater_equal), ("lt", np.less), ("le", np.less_equal)):
            bound = getattr(one, name, None)
            if bound is not None:
                bad |= ~within(values, bound)
    return bad


def demand_of(variants: Variants) -> Demand:
    """What acts on a slide, an arm or a turret, N and mm or N mm and rad."""
    number, operation = variants.number, variants.profile.operation
    assert operation is not None
    speed, turning = number("operation.speed") * (2.0 * pi / 60.0), variants.profile.rotating
    what, unit = ("inertia", DEGREES) if turning else ("mass", 1.0)
    mass = number(f"follower.{what}") + number(f"operation.load_{what}")
    return Demand(
        np.asarray(speed), mass, number("operation.friction"), number("operation.spring_preload"),
        number("operation.spring_rate") * unit, mass * (0.0 if turning else number("operation.gravity")),
        tuple(force.applied() for force in operation.force), turning,
    )  # fmt: skip


class Refusals:
    """Why variants cannot exist: the first reason given to each."""

    def __init__(self, size: int) -> None:
        self.code = np.zeros(size, dtype=np.int16)
        self.words = [""]

    def add(self, bad: Mask | bool, word: str) -> None:
        """Give a reason where `bad` is true, broadcastable to (n,), and none was given yet."""
        bad = np.asarray(bad)
        if not bad.any():
            return
        if word not in self.words:
            self.words.append(word)
        self.code[bad & (self.code == 0)] = self.words.index(word)

    @property
    def none(self) -> Mask:
        """The variants without a reason."""
        return np.asarray(self.code == 0)

    def scattered(self, rest: Batch | None, names: Sequence[str]) -> Batch:
        """The batch of all variants from that of those without a reason (None where there is none)."""
        kept, code, words = self.none, self.code.copy(), list(self.words)
        figures = {name: np.zeros(len(code)) for name in names}
        if rest is not None:
            words += [word for word in rest.reasons if word not in words]
            code[kept] = np.array([words.index(word) for word in rest.reasons], dtype=np.int16)[rest.reason]
            for name, values in figures.items():
                values[kept] = rest.figures[name]
        return Batch(figures, code, tuple(words))

    def batch(self, figures: Mapping[str, Floats]) -> Batch:
        """The figures with 0 for those that do not exist; a bug where one of a variant that does is NaN."""
        exists, found = self.none, {}
        for name, values in figures.items():
            kept = np.where(exists, values, 0.0)
            if np.isnan(kept).any():
                raise ArithmeticError(f"{name} has no value for a variant that exists; this is a bug")
            found[name] = kept
        return Batch(found, self.code, tuple(self.words))
