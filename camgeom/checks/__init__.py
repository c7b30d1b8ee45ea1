"""Checks: facts judged against limits. One file a check, found by file name; each is a function (Model) -> findings.

A check module defines `@check("name", *needs)` functions. `NEEDS` names what has to exist for a check to apply; one
that does not apply says nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, replace
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, Literal

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
    needs: tuple[Need, ...]
    judge: Judge


_REGISTRY: dict[str, Check] = {}

Need = Literal["body", "solid", "tracks", "planar", "turret", "operation", "face load", "turret load"]
NEEDS: dict[Need, Callable[[Model], bool]] = {
    "body": lambda model: True,
    "solid": lambda model: True,
    "tracks": lambda model: bool(model.tracks),
    "planar": lambda model: model.planar is not None,
    "turret": lambda model: model.mechanism.turret is not None,
    "operation": lambda model: bool(model.duties),
    "face load": lambda model: model.drive is not None and not model.tracks,
    "turret load": lambda model: model.turret_duty is not None,
}
"""What a check may need. A "body" is judged once for all followers; "solid" marks what takes a mesh."""


def check(name: str, *needs: Need) -> Callable[[Judge], Judge]:
    """Register a judging function under a name; see `NEEDS`."""

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
    """Judge the model: every check that applies, or the named ones. A body that cannot be made is a finding.

    Checks of the body judge it once, the others every follower on it.
    """
    wanted = None if only is None else set(only)
    found: list[Finding] = []
    for name, one in checks().items():
        if wanted is None or name in wanted:
            bindings = model.bindings[:1] if "body" in one.needs else model.bindings
            found += [finding for binding in bindings for finding in _judged(one, binding, len(bindings) > 1)]
    return tuple(found)


def _judged(one: Check, model: Model, several: bool) -> list[Finding]:
    """What a check finds of one follower, which is named where there are several."""
    if not all(NEEDS[need](model) for need in one.needs):
        return []
    try:
        found = list(one.judge(model))
    except DesignError as refusal:
        found = [Finding(one.name, None, None, "", False, None, str(refusal))]
    own = f"follower {model.number + 1}"
    return [replace(f, where=f"{own}: {f.where}" if f.where else own) for f in found] if several else found
