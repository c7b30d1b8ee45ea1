"""What the figures of a batch say of the limits, with the limits and words of the exact checks."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from camgeom.checks.verdict import NO_GAP
from camgeom.design.batch.variants import Batch
from camgeom.maths import Floats
from camgeom.mechanics.hardness import CONTACT_CYCLES

if TYPE_CHECKING:
    from camgeom.profile import Profile

Words = npt.NDArray[np.object_]

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
    limit, cycles, power = (
        columns.get(f"material.{body}.{key}", getattr(getattr(profile.material, body), key))
        for key in ("contact_limit", "contact_cycles", "exponent")
    )
    return limit * (cycles / CONTACT_CYCLES) ** (1.0 / power)

