"""Studies of many variants by the batch: columns of a piece at a time, and what its figures say of the limits.

What the figures decide is judged, with the limits and words of the exact checks; the rest is told as not judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import chain, product
from typing import TYPE_CHECKING, Any, final

import numpy as np
import numpy.typing as npt

from camgeom.checks.verdict import NO_GAP
from camgeom.design.batch import LEVELS, Batch, evaluate, leveled, offered, supports
from camgeom.design.sampling import Column, Plan
from camgeom.design.study import Data, Value, replaced
from camgeom.errors import ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property

if TYPE_CHECKING:
    from camgeom.profile import Profile

Words = npt.NDArray[np.object_]


@final
@immutable(eq=True)
class Bulk:
    """The variants of a plan, which figures are wanted of them (names of a study's columns), and how near an indexer's
    pressures have to be."""

    data: Data
    file: str
    plan: Plan
    figures: tuple[str, ...] = ()
    level: float = LEVELS[0]

    def refused(self) -> str | None:
        """Why the exact model must compute these variants; None where the batch does."""
        from camgeom.profile import from_data

        try:
            for words in self._profiles():
                profile = from_data(words, self.file)
                why = supports(profile, self._numeric)
                lacking = [name for name in self.figures if name not in offered(profile)]
                if why is None and lacking:
                    why = f"the batch has no figure {lacking[0]} of this profile"
                if why is not None:
                    return why
        except ProfileError as error:
            return f"the profile itself cannot be made ({error.problems[0]})"
        return None

    @property
    def leveled(self) -> bool:
        """Whether the profile's pressures hang on the level."""
        from camgeom.profile import from_data

        return leveled(from_data(self.data, self.file))

    @property
    def _numeric(self) -> list[str]:
        """Keys that take numbers."""
        return [key for key in self.plan.keys if key not in self._words]

    @property
    def _words(self) -> dict[str, tuple[str | int, ...]]:
        """Keys that take words, with their paths: each combination of them is a profile of its own."""
        return {one.key: one.path for one in self.plan.axes if any(isinstance(value, str) for value in one.values)}

    def _parts(self, piece: range) -> list[tuple[Data, npt.NDArray[np.intp]]]:
        """The profile's data with every combination of words, and which rows of the piece have it."""
        columns = self.plan.columns(piece, self.data)
        rows: dict[tuple[Value, ...], list[int]] = {}
        if not self._words:
            return [(self.data, np.arange(len(piece)))]
        for i, words in enumerate(zip(*(columns[key] for key in self._words))):
            rows.setdefault(words, []).append(i)
        return [(self._with(words), np.array(where)) for words, where in rows.items()]

    def _profiles(self) -> Iterator[Data]:
        """The profile's data with every combination of words that may come."""
        values = ([str(one) for one in axis.values] for axis in self.plan.axes if axis.key in self._words)
        return map(self._with, product(*values))

    def _with(self, words: Sequence[Value]) -> Data:
        data = self.data
        for (key, path), word in zip(self._words.items(), words):
            data = replaced(data, path, word, key)
        return data

    @cached_property
    def _names(self) -> tuple[str, ...]:
        """Names of the figures of any row, in one order for all pieces."""
        from camgeom.profile import from_data

        every = (self.figures or offered(from_data(words, self.file)) for words in self._profiles())
        return tuple(dict.fromkeys(chain.from_iterable(every)))

    def columns(self, piece: range) -> dict[str, Column | Words]:
        """The rows of variants that are not `refused` by columns: keys, figures (infinite where there is none),
        verdict and reason."""
        from camgeom.profile import from_data

        keys = self.plan.columns(piece, self.data)
        figures = {name: np.full(len(piece), np.inf) for name in self._names}
        verdict, reason = np.empty(len(piece), dtype=object), np.empty(len(piece), dtype=object)
        for data, where in self._parts(piece):
            varied = {key: np.asarray(keys[key], dtype=np.float64)[where] for key in self._numeric}
            profile = from_data(data, self.file)
            names = self.figures or offered(profile)
            batch = evaluate(profile, varied, names, self.level)
            verdict[where], reason[where] = judged(profile, varied, batch)
            for name, values in batch.figures.items():
                figures[name][where] = np.where(batch.reason == 0, values, np.inf)
        return {**keys, **figures, "verdict": verdict, "reason": reason}

    def judged_checks(self) -> set[str]:
        """Names of the checks that the verdicts of the rows rest on."""
        from camgeom.profile import from_data

        found: set[str] = {"undercut", "face-curvature", "continuity"}
        left: set[str] = set()
        for data in self._profiles():
            profile = from_data(data, self.file)
            names = self.figures or offered(profile)
            found |= {check_of(check, profile) for check, figure, *_ in JUDGED if figure in names}
            width = getattr(profile.follower, "face_width", None)
            if width is None and "follower.face_width" not in self.plan.keys:
                left.add(FACE)
            rated = profile.roller is not None and profile.roller.dynamic_rating is not None
            lives = {*LIVES, *(BEARING if rated or "roller.dynamic_rating" in self.plan.keys else ())}
            asked = profile.limits.life_h is not None or "limits.life_h" in self.plan.keys
            if not asked or not lives <= set(names):
                left.add(check_of(LIFE, profile))
        return found - left


PRESSURE, LIFE, FACE = "pressure", "life", "face-width"
LIVES, BEARING = ("fatigue.roller_slice_life_h", "fatigue.cam_slice_life_h"), ("fatigue.bearing_life_h",)
"""a check of lives is made where all of them are known: one that fails says so, but no other one passes"""
JUDGED: tuple[tuple[str, str, str, str], ...] = (
    ("pressure-angle", "flank.max_pressure_angle_deg", "pressure_angle_deg", "<="),
    ("undercut", "flank.undercut_margin", "undercut_margin", ">="),
    (PRESSURE, "contact.peak_slice_pressure_mpa", "contact_pressure_mpa", "<="),
    (PRESSURE, "contact.peak_pressure_mpa", "contact_pressure_mpa", "<="),
    ("contact-kept", "contact.least_force_n", "", ">="),
    *((LIFE, figure, "life_h", ">=") for figure in (*LIVES, *BEARING)),
    ("torque", "contact.peak_torque_n_m", "torque_n_m", "<="),
    ("rib-thickness", "flank.rib_thickness_mm", "min_wall_mm", ">="),
    ("run-out", "checks.run-out", "", ">="),
    ("floor-gap", "checks.floor-gap", "clearance_mm", ">"),
    ("relative-curvature", "checks.relative-curvature", "", ">"),
    (FACE, "flank.face_width_needed_mm", "face_width", "<="),
)
"""check, the figure that it reads, the limit's key, and how they compare; of PRESSURE and LIFE see `check_of`"""
WARNED = {"pressure-angle": "warn_pressure_angle_deg", "undercut": "warn_undercut_margin"}
FORCE_SLACK = 1e-9


def check_of(name: str, profile: Profile) -> str:
    """The check by the name that it has for what presses the cam: a roller, faces, or rollers that share."""
    if name not in (PRESSURE, LIFE):
        return name
    if profile.follower.shares:
        return f"turret-{name}"
    if profile.roller is None:
        return f"face-{name}"
    return "contact-pressure" if name == PRESSURE else name


def judged(profile: Profile, columns: Mapping[str, Floats], batch: Batch) -> tuple[Words, Words]:
    """Verdict and reason of every variant, by what its figures say of the limits."""
    failed: dict[str, npt.NDArray[np.bool_]] = {}
    warned = np.zeros(len(batch.reason), dtype=bool)
    for check, figure, key, way in JUDGED:
        values = batch.figures.get(figure)
        if values is None or (figure == "contact.peak_pressure_mpa" and profile.roller is not None):
            continue
        limit = limit_of(profile, columns, key)
        if limit is None:
            continue
        check = check_of(check, profile)
        if check == "contact-kept":
            limit = -FORCE_SLACK * np.abs(batch.figures.get("contact.peak_force_n", np.zeros(1)))
        if check == "floor-gap":
            limit = limit + NO_GAP
        bad = values > limit if way == "<=" else values <= limit if way == ">" else values < limit
        if check == "undercut":
            bad |= values <= 0.0
        failed[check] = failed.get(check, np.zeros(len(bad), dtype=bool)) | bad
        warn = limit_of(profile, columns, f"{WARNED[check]}") if check in WARNED else None
        if check == "rib-thickness":
            share = limit_of(profile, columns, "warn_rib_share")
            thickness, play = (_given(profile, columns, f"cam.{key}") for key in ("rib_thickness", "running_clearance"))
            warn = (1.0 - share) * (thickness - 2.0 * play)
        if warn is not None:
            warned |= values > warn if way == "<=" else values < warn
    exists = batch.reason == 0
    names = tuple(sorted(failed))
    code = np.zeros(len(exists), dtype=np.int64)
    for i, name in enumerate(names):
        code |= (failed[name] & exists).astype(np.int64) << i
    told = {c: "; ".join(name for i, name in enumerate(names) if c >> i & 1) for c in np.unique(code).tolist()}
    reason = np.array([told[c] for c in sorted(told)], dtype=object)[np.searchsorted(sorted(told), code)]
    reason = np.where(exists, reason, np.array(batch.reasons, dtype=object)[batch.reason])
    level = np.where(code > 0, 2, np.where(warned, 1, 0))
    input_ = np.array([": " in word for word in batch.reasons])[batch.reason]
    level = np.where(exists, level, np.where(input_, 3, 2))
    return np.array(["pass", "warn", "fail", "bad input"], dtype=object)[level], reason


def limit_of(profile: Profile, columns: Mapping[str, Floats], key: str) -> Any:
    """A limit of the profile, a number or (n,); None where none is given; 0 for none that has to be given."""
    if not key:
        return 0.0
    if f"limits.{key}" in columns:
        return columns[f"limits.{key}"]
    if key == "face_width":
        return columns.get("follower.face_width", getattr(profile.follower, "face_width", None))
    value = getattr(profile.limits, key)
    if key == "warn_pressure_angle_deg" and key not in profile.limits.model_fields_set:
        return np.minimum(profile.follower.pressure_angle_limit, limit_of(profile, columns, "pressure_angle_deg"))
    if key == "min_wall_mm":
        return np.maximum(value, 2.0 * _given(profile, columns, "output.tolerance"))
    if key != "contact_pressure_mpa" or value is not None:
        return value
    # The weaker material's fatigue line, as `Model.pressure_limit` takes it.
    return np.minimum(*(_rated(profile, columns, body) for body in ("cam", "roller")))


def _given(profile: Profile, columns: Mapping[str, Floats], key: str) -> Any:
    section, name = key.split(".")
    return columns.get(key, getattr(getattr(profile, section), name))


def _rated(profile: Profile, columns: Mapping[str, Floats], body: str) -> Any:
    from camgeom.mechanics.material import CONTACT_CYCLES

    limit, cycles, power = (
        columns.get(f"material.{body}.{key}", getattr(getattr(profile.material, body), key))
        for key in ("contact_limit", "contact_cycles", "exponent")
    )
    return limit * (cycles / CONTACT_CYCLES) ** (1.0 / power)

