"""Checks: facts judged against limits. One file a check, found by file name; each is a function (Model) -> findings.

A check module defines `@check("name", needs=...)` functions. `needs` names what has to exist for the check to apply:
"tracks", "solid", "operation", "face load", "turret", "turret load"; a check that does not apply says nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any

from camgeom.errors import DesignError

if TYPE_CHECKING:
    from camgeom.model import Model


@dataclass(frozen=True)
class Finding:
    """One fact judged: its value against a limit, in a unit, where, whether it passes, and advice if it does not."""

    check: str
    value: float | None
    limit: float | None
    unit: str
    passed: bool
    cam_angle_deg: float | None = None
    advice: str = ""
    where: str = ""

    def as_dict(self) -> dict[str, Any]:
        """The finding as plain data for result.json."""
        return asdict(self)


Judge = Callable[["Model"], Iterable[Finding]]


@dataclass(frozen=True)
class Check:
    """A registered check: its name, what it needs, and the judging function."""

    name: str
    needs: tuple[str, ...]
    judge: Judge


_REGISTRY: dict[str, Check] = {}


def check(name: str, *needs: str) -> Callable[[Judge], Judge]:
    """Register a judging function under a name; see the module's docstring for `needs`."""

    def register(judge: Judge) -> Judge:
        _REGISTRY[name] = Check(name, needs, judge)
        return judge

    return register


def checks() -> dict[str, Check]:
    """All checks by name."""
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")
    return dict(sorted(_REGISTRY.items()))


def findings(model: Model, only: Iterable[str] | None = None) -> tuple[Finding, ...]:
    """Judge the model: every check that applies, or the named ones. A body that cannot be made is a finding."""
    wanted = None if only is None else set(only)
    found: list[Finding] = []
    for name, one in checks().items():
        if wanted is not None and name not in wanted:
            continue
        if not all(_has(model, need) for need in one.needs):
            continue
        try:
            found.extend(one.judge(model))
        except DesignError as refusal:
            found.append(Finding(name, None, None, "", False, None, str(refusal)))
    return tuple(found)


def _has(model: Model, need: str) -> bool:
    if need == "tracks":
        return bool(model.tracks)
    if need == "operation":
        return model.loaded
    if need == "planar":
        return model.planar is not None
    if need == "turret":
        return model.mechanism.turret is not None
    if need == "turret load":
        return model.turret_loaded
    if need == "face load":
        return model.driven and not model.tracks
    return True
