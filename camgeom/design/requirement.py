"""What a search is asked for: keys that are free, figures to be least or most, bounds to be kept."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any, final

import numpy as np

from camgeom.checks.verdict import ENDLESS_H
from camgeom.design.sampling import Tie, in_turn
from camgeom.design.study import Axis, Data, Measure, Row, Study, Value, alike, axis
from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.immutable import immutable
from camgeom.maths import Floats

ALIASES = {"size": "blank.volume_mm3"}
"""short names of figures"""
FINENESS = 1e-4
"""share of a range to which a free value is rounded, to a decimal place: a drawing says no more"""
UNBOUNDED = 1e12
"""what an endless figure counts in the search; a life counts as long as it is told apart (`ENDLESS_H`)"""
NONE = 1e-6
"""a limit below is 0, with no share of it to count in"""
STRICT = 1e-9
"""share of a limit by which a figure stays off one that it may not meet"""
CHECKED = {
    "pressure-angle": ("flank.max_pressure_angle_deg",),
    "undercut": ("flank.undercut_margin",),
    "contact-pressure": ("contact.peak_slice_pressure_mpa", "contact.peak_pressure_mpa"),
    "contact-kept": ("contact.least_force_n",),
    "torque": ("contact.peak_torque_n_m", "together.peak_torque_n_m"),
    "bearing": ("fatigue.bearing_static_safety",),
    "life": ("fatigue.roller_slice_life_h", "fatigue.cam_slice_life_h", "fatigue.bearing_life_h",
             "fatigue.face_life_h"),
}  # fmt: skip
"""figures that a check judges"""


@final
@immutable(eq=True)
class Free:
    """A key that the search may set: any value of a range, or one of a list.

    low, high  of a range; its values are rounded to `places` decimals
    """

    axis: Axis
    low: float = 0.0
    high: float = 0.0
    places: int = 0

    @property
    def listed(self) -> bool:
        """Whether it has a list of values and no range."""
        return self.low == self.high

    def values(self, share: Floats) -> list[Value]:
        """Values at shares (n,) of the range, 0 to 1."""
        if self.listed:
            known = self.axis.values
            return [known[i] for i in np.minimum((share * len(known)).astype(int), len(known) - 1).tolist()]
        found = np.round(self.low + share * (self.high - self.low), self.places)
        return list(np.clip(found, self.low, self.high).tolist())


def free(text: str) -> Free:
    """A free key from KEY=A:B (any value between), KEY=A:B:N (one of N) or KEY=a,b,c."""
    key, equals, written = text.partition("=")
    ends = written.split(":")
    if not equals or len(ends) != 2:
        # What is no axis of values is told below with the forms there are.
        with suppress(ProfileError):
            return Free(axis(text))
    try:
        low, high = (float(end) for end in ends)
        if not (math.isfinite(low) and math.isfinite(high) and low < high):
            raise ValueError
        places = max(0, -math.floor(math.log10(FINENESS * (high - low))))
        return Free(axis(f"{key}={low!r},{high!r}"), low, high, places)
    except (ValueError, ProfileError):
        forms, example = "needs KEY=A:B, KEY=A:B:N or KEY=a,b,c", "for example cam.diameter=120:200"
        raise ProfileError([Problem("--free", forms, text[:200], example)]) from None


@final
@immutable(eq=True)
class Aim:
    """A figure to be made small (sign +1) or large (-1)."""

    figure: str
    sign: float

    @property
    def words(self) -> str:
        """For a reader."""
        return f"{'least' if self.sign > 0.0 else 'most'} {self.figure}"


@final
@immutable(eq=True)
class Bound:
    """A figure that stays on one side of a value: sign +1 below it, -1 above it.

    said  who asks for it; own: a check of the profile does
    """

    figure: str
    sign: float
    value: float
    said: str
    own: bool = False

    def excess(self, values: Floats) -> Floats:
        """How far figures (n,) are beyond the bound, as a share of it; not above 0 where they keep it."""
        whole = abs(self.value) if abs(self.value) > NONE else 1.0
        return np.asarray(self.sign * (values - self.value) / whole)


@final
@immutable(eq=True)
class Requirement:
    """What is sought: a profile's data with free keys and keys tied to them, aims, and bounds beside its own limits."""

    data: Data
    file: str
    free: tuple[Free, ...]
    aims: tuple[Aim, ...]
    bounds: tuple[Bound, ...] = ()
    ties: tuple[Tie, ...] = ()

    def __post_init__(self) -> None:
        if not self.free or not self.aims:
            what = "--free: a search needs a free key" if not self.free else "--least: a search needs an aim"
            raise ProfileError([Problem(*what.split(": "))])
        for key, names in (("--free", [one.key for one in self.axes]), ("--least", [a.figure for a in self.aims])):
            if twice := [name for name, count in Counter(names).items() if count > 1]:
                raise ProfileError([Problem(key, "is given twice", ", ".join(twice))])

    @property
    def axes(self) -> tuple[Axis, ...]:
        """The keys of a point, those that are tied last."""
        return (*(one.axis for one in self.free), *(Axis(one.key, one.path, (0.0,)) for one in self.ties))

    @property
    def figures(self) -> tuple[str, ...]:
        """Names of all figures of aims and bounds."""
        return tuple(dict.fromkeys([a.figure for a in self.aims] + [b.figure for b in self.bounds]))

    def points(self, shares: Floats) -> tuple[tuple[Value, ...], ...]:
        """Values of the keys, free ones at shares (n, k) of their ranges."""
        columns: dict[str, list[Value] | Floats] = {}
        for one, column in zip(self.free, shares.T):
            columns[one.axis.key] = one.values(column)
        for tied in in_turn(self.ties):
            columns[tied.key] = np.broadcast_to(tied.values(columns, self.data), (len(shares),)).tolist()
        return tuple(zip(*(columns[one.key] for one in self.axes)))

    def placed(self, points: Sequence[tuple[Value, ...]]) -> Floats:
        """Where points stand in the ranges of the free keys that are numbers, (n, k), 0 to 1."""
        columns = []
        for one, column in zip(self.free, zip(*points)):
            if not any(isinstance(value, str) for value in one.axis.values):
                ends = np.array(one.axis.values, dtype=np.float64)
                columns.append((np.array(column, dtype=np.float64) - ends.min()) / (np.ptp(ends) or 1.0))
        return np.stack(columns, axis=1) if columns else np.zeros((len(points), 0))

    def study(self, points: Sequence[tuple[Value, ...]], measure: Measure) -> Study:
        """Exact models of some points."""
        return Study(self.data, self.file, self.axes, measure, tuple(points))

    def scores(self, figures: Mapping[str, Floats]) -> Floats:
        """What the search makes small, (n, aims)."""
        return np.stack([aim.sign * bounded(aim.figure, figures[aim.figure]) for aim in self.aims], axis=1)

    def excess(self, figures: Mapping[str, Floats]) -> Floats:
        """How far every bound is passed, (n, bounds)."""
        n = len(next(iter(figures.values())))
        found = [bound.excess(bounded(bound.figure, figures[bound.figure])) for bound in self.bounds]
        return np.stack(found, axis=1) if found else np.zeros((n, 0))


def bounded(name: str, values: Floats) -> Floats:
    """Figures without infinities; a peak torque by its size, a life no longer than it is told apart."""
    most = ENDLESS_H if name.endswith("_life_h") else UNBOUNDED
    values = np.abs(values) if "peak_" in name and "torque" in name else values
    return np.asarray(np.clip(values, -UNBOUNDED, most))


def figure_name(word: str, known: Sequence[str], key: str) -> str:
    """The figure that a word names: whole, by an alias, or by the end of a name that no other has."""
    name = ALIASES.get(word, word)
    ends = [one for one in known if one == name or one.endswith(f".{name}")]
    if name not in known and any(one.startswith("followers.") for one in ends):
        ends = list(dict.fromkeys((*ends, *alike(name, known))))
    if name in known or len(ends) == 1:
        return name if name in known else ends[0]
    message = "names several figures" if ends else "is no figure of this cam"
    hint = f"one of {', '.join(ends)}" if ends else did_you_mean(name, known) or "camgeom study shows them as columns"
    raise ProfileError([Problem(key, message, word, "", hint)])


def limits_of(row: Row, findings: Sequence[Mapping[str, Any]], known: Sequence[str]) -> tuple[Bound, ...]:
    """Bounds that the checks of the profile's own limits put on known figures, by the row and findings of the profile.

    A figure is bounded only where it is just what the check judged: a check may judge another load.
    """
    found: dict[str, Bound] = {}
    for finding in findings:
        sign = {"<": 1.0, ">": -1.0}.get(str(finding["comparison"])[:1])
        if finding["limit"] is None or finding["value"] is None or sign is None:
            continue
        limit = finding["limit"]
        if len(str(finding["comparison"])) == 1:  # it may not even be met
            limit -= sign * STRICT * max(abs(limit), 1.0)
        judged = (*CHECKED.get(finding["check"], ()), f"checks.{finding['check']}")
        each = [one for one in known if one.startswith("followers.") and one.split(".", 2)[2] in judged]
        each += [one for one in known if one.startswith(f"checks.{finding['check']} follower ")]
        for name in (*judged, *each):
            value = row.figures.get(name)
            same = isinstance(value, int | float) and math.isclose(abs(value), abs(finding["value"]), rel_tol=1e-6)
            if name in known and same:
                found[name] = Bound(name, sign, limit, f"check {finding['check']}", own=True)
    return tuple(found.values())
