"""The figures of the exact model for many variants of one profile at once, by the same names.

    batch = evaluate(profile, {"cam.base_radius": radii, "roller.diameter": diameters})
    batch.figures["flank.max_pressure_angle_deg"][batch.reason == 0]

Arrays run over variants and cam angles, in chunks that stay in the cache. Each family of cams is one file with a
kernel; the samples, the refined extremes and the vocabulary of reasons are common
(`motion`, `variants`). Where a kernel cannot
carry a key or a profile `supports` says why, and the exact model is the way.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol, cast

import numpy as np

from camgeom.design.batch.judged import judged
from camgeom.design.batch.variants import Batch, refused_keys, value_of
from camgeom.errors import ProfileError
from camgeom.maths import Floats

if TYPE_CHECKING:
    from camgeom.profile import Profile

KERNELS = {
    "disc": "planar",
    "constant-width": "planar",
    "conjugate": "planar",
    "cylindrical": "drum",
    "globoidal": "turret",
    "cylindrical-index": "turret",
    "parallel-index": "parallel",
}
"""The file that carries a kind of cam."""

ROLLED, FEWER = ("fatigue.roller_life_h", "fatigue.roller_slice_life_h"), 2048
"""figures that take some thousand places of every variant, and how many variants are then evaluated at once"""
KEPT = 30_000_000
"""bytes"""


class Kernel(Protocol):
    """One family of cams.

    CHUNK  variants that are evaluated at once
    """

    CHUNK: int

    def supports(self, profile: Profile, varied: Sequence[str]) -> str | None:
        """None where the kernel carries these keys of this profile, else why not."""

    def offered(self, profile: Profile) -> tuple[str, ...]:
        """Names of the figures that it gives for this profile."""

    def kernel(self, profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
        """The figures of one chunk of variants; `level` as in `evaluate`."""


def _kernel(profile: Profile) -> Kernel | None:
    name = KERNELS.get(profile.kind)
    return cast(Kernel, import_module(f"{__name__}.{name}")) if name else None


def supports(profile: Profile, varied: Sequence[str], trial: Mapping[str, Floats] | None = None) -> str | None:
    """None where the batch carries this profile with these keys varied; else, in words, why the exact model must.

    trial  a few of the variants, (n,) by key: by them it is told whether anything hangs on a key
    """
    found = _kernel(profile)
    if found is None:
        return f"the batch has no kernel for kind = {profile.kind!r}"
    return (refused_keys(profile, varied) or found.supports(profile, varied) or _restless(profile)
            or (_unread(found, profile, varied) if not trial else _untold(found, profile, trial)))


def _restless(profile: Profile) -> str | None:
    """Why its applied forces need the exact model, whose panels become as narrow as they ask for."""
    from camgeom.design.batch.legs import MOST_CUTS, force_cuts

    if profile.operation is None or not profile.operation.force:
        return None
    forces = [force.applied() for force in profile.operation.force]
    if not all(force.plain for force in forces):
        return (
            "operation.force: hangs on the motion otherwise than as a polynomial (numbers times products of up to "
            "three of s, v, a, abs(v)), so that its jumps and peaks may lie anywhere"
        )
    try:
        breaks = {angle for force in forces for angle in force.anywhere}
    except ProfileError:
        return "operation.force: has peaks beside what hangs on the motion that are too narrow"
    many = len(force_cuts(profile)) - len(breaks)
    return f"operation.force: turns so often that more than {MOST_CUTS} pieces follow it" if many > MOST_CUTS else None


class _Asked(dict[str, Floats]):
    """Columns that remember which of them were asked for."""

    def __init__(self, columns: Mapping[str, Floats]) -> None:
        super().__init__(columns)
        self.read: set[str] = set()

    def __getitem__(self, key: str) -> Floats:
        self.read.add(key)
        return super().__getitem__(key)

    def get(self, key: str, default: Any = None) -> Any:
        """The column, or the default."""
        self.read.add(key)
        return super().get(key, default)


NOTHING = "no figure and no check of the batch hangs on it"


def _unread(kernel: Kernel, profile: Profile, varied: Sequence[str]) -> str | None:
    """A varied key that neither a figure nor a check of the batch reads, so that all its rows would be equal: the
    profile's own values are computed once, by each key alone."""
    for key in varied:
        value = value_of(profile, key)
        columns = _Asked({key: np.array([1.0 if value is None else float(value)])})
        exists, *_ = _computed(kernel, profile, columns)
        # Of a variant that does not exist not everything was asked.
        if key not in columns.read and exists[0]:
            return f"{key}: {NOTHING}"
    return None


def _untold(kernel: Kernel, profile: Profile, trial: Mapping[str, Floats]) -> str | None:
    """The same by variants of a study. What is asked of the cam alone may be whether it exists, and no more: there
    figures have to change where that of another variant is put in its place."""
    columns = _Asked(trial)
    exists, *told = _computed(kernel, profile, columns)
    if not exists.any():
        return None
    for key, values in trial.items():
        if key not in columns.read:
            return f"{key}: {NOTHING}"
        other = np.roll(values, 1)
        if not key.startswith("cam.") or not (other != values).any():
            continue
        also, *changed = _computed(kernel, profile, {**trial, key: other})
        both = exists & also & (other != values)
        if both.any() and all(np.array_equal(one[both], two[both]) for one, two in zip(told, changed)):
            return f"{key}: {NOTHING}"
    return None


def _computed(kernel: Kernel, profile: Profile, columns: Mapping[str, Floats]) -> tuple[Any, ...]:
    """Which of some variants exist, and all that the batch tells of them, (n,) each."""
    batch = kernel.kernel(profile, columns, kernel.offered(profile), LEVELS[0])
    return batch.reason == 0, *judged(profile, columns, batch), *batch.figures.values()


LEVELS = (1e-2, 3e-3)
"""relative errors of pressures and forces that can be asked for where they jump, as those of indexers do where a roller
comes to bear; the first where nothing is asked"""


def leveled(profile: Profile) -> bool:
    """Whether the pressures of this profile hang on the level that is asked for."""
    return KERNELS.get(profile.kind) == "turret"


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that the batch gives for this profile; none without a kernel, nor of several followers."""
    found = None if profile.track or profile.station else _kernel(profile)
    return found.offered(profile) if found is not None else ()


def evaluate(
    profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str] | None = None, level: float = LEVELS[0]
) -> Batch:
    """The figures (default: all that are offered) of n variants, which `supports` has nothing against.

    columns  values (n,) by profile key as a study spells it: "cam.diameter", "motion[0].to"
    level    largest relative error of pressures and forces where they jump, one of LEVELS
    """
    found = _kernel(profile)
    if found is None:
        raise ValueError(f"the batch has no kernel for kind = {profile.kind!r}")
    wanted = tuple(figures) if figures is not None else found.offered(profile)
    if unknown := [name for name in wanted if name not in found.offered(profile)]:
        raise ValueError(f"no such figures of this profile: {', '.join(unknown)}")
    # Once a block of this size was freed the C library keeps what smaller ones leave; else every chunk would give its
    # memory back and fault all its pages in again, half as long as it computes.
    np.empty(KEPT, dtype=np.int8)
    arrays = {key: np.asarray(values, dtype=np.float64) for key, values in columns.items()}
    size = len(next(iter(arrays.values())))
    chunk = found.CHUNK if set(ROLLED).isdisjoint(wanted) else min(found.CHUNK, FEWER)
    parts = [
        found.kernel(profile, {key: values[k : k + chunk] for key, values in arrays.items()}, wanted, level)
        for k in range(0, size, chunk)
    ]
    return _joined(parts, wanted)


def _joined(parts: Sequence[Batch], names: Sequence[str]) -> Batch:
    """The parts one after the other, with one vocabulary."""
    known = tuple(dict.fromkeys(word for part in parts for word in part.reasons))
    codes = [np.array([known.index(word) for word in part.reasons], dtype=np.int16)[part.reason] for part in parts]
    figures = {name: np.concatenate([part.figures[name] for part in parts]) for name in names}
    return Batch(figures, np.concatenate(codes), known)
