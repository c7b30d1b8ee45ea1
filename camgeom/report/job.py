"""A job: the facts a command asks for, as the result that scripts rely on, and the files it leaves.

Products are named pieces of the result; a job computes those asked for and nothing they do not need.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.report.result import (
    contact_data,
    cutter_data,
    dynamics_data,
    fatigue_data,
    flank_data,
    motion_data,
    solid_data,
)

if TYPE_CHECKING:
    from camgeom.checks import Finding
    from camgeom.model import Model

PRODUCTS = ("motion", "flank", "checks", "solid", "contact", "fatigue", "dynamics", "cutter", "exports", "report")
COMMANDS: dict[str, tuple[str, ...]] = {
    "run": PRODUCTS,
    "build": ("motion", "solid", "cutter", "exports"),
    "check": ("motion", "flank", "checks"),
    "solve": ("motion", "contact", "fatigue", "dynamics"),
    "report": ("motion", "flank", "checks", "solid", "contact", "fatigue", "dynamics", "report"),
}


@dataclass(frozen=True, eq=False)
class Result:
    """What a job found: plain data for result.json, the findings, and whether all passed.

    refused  why there is no body, or nothing; unanswered: why there is no contact, fatigue ..., by product
    """

    data: dict[str, Any]
    findings: tuple[Finding, ...]
    refused: str = ""
    unanswered: tuple[tuple[str, str], ...] = ()

    @property
    def passed(self) -> bool:
        """True where every finding passes and everything asked for could be made."""
        return not self.refused and not self.unanswered and all(finding.passed for finding in self.findings)


def chosen(command: str, only: Iterable[str] | None) -> tuple[tuple[str, ...], tuple[str, ...] | None]:
    """Products and checks that a command computes; `only` narrows them. Raises ProfileError for an unknown name."""
    products = COMMANDS[command]
    if only is None:
        return products, None
    from difflib import get_close_matches

    from camgeom.checks import checks

    names = tuple(only)
    known = (*PRODUCTS, *checks())
    for name in names:
        if name not in known:
            near = get_close_matches(name, known, 1, 0.5)
            hint = f"did you mean {near[0]}?" if near else ""
            raise ProfileError([Problem("--only", "unknown product or check", name, ", ".join(known), hint)])
    wanted = tuple(name for name in names if name in PRODUCTS)
    single = tuple(name for name in names if name not in PRODUCTS)
    return tuple(dict.fromkeys((*wanted, *(("checks",) if single else ())))), single or None


def compute(model: Model, products: Iterable[str], only_checks: Iterable[str] | None = None) -> Result:
    """The result of the named products. What the design does not admit is reported in its place, not raised."""
    from camgeom import __version__

    wanted = set(products)
    data: dict[str, Any] = {"name": model.profile.name, "kind": model.profile.kind, "version": __version__}
    found: tuple[Finding, ...] = ()
    refused: dict[str, str] = {}

    def fill(name: str, source: Callable[[], dict[str, Any]]) -> None:
        try:
            data[name] = source()
        except DesignError as error:
            refused[name] = str(error)
            data[name] = {"refused": refused[name]}

    if "motion" in wanted:
        data["motion"] = motion_data(model)
    if "flank" in wanted:
        fill("flank", partial(_flank, model))
    if "checks" in wanted:
        from camgeom.checks import findings

        found = findings(model, only_checks)
        data["checks"] = [finding.as_dict() for finding in found]
    for name, source in SOURCES.items():
        if name in wanted:
            fill(name, partial(source, model))
    data = {name: value for name, value in data.items() if value != {}}
    data["files"] = []
    body = refused.pop("solid", "")
    return Result(data, found, body, tuple(refused.items()))


def _flank(model: Model) -> dict[str, Any]:
    data = flank_data(model) if model.tracks else {}
    for facts in (model.planar, model.pair):
        data |= facts.data() if facts is not None else {}
    return data


def _contact(model: Model) -> dict[str, Any]:
    data: dict[str, Any] = {}
    if model.loaded:
        data = contact_data(model)
    if model.turret_loaded:
        data = model.turret_duty.contact_data()
    if model.driven:
        # A roller's own contact (crowning, slices) stands; force and torque are those of all touches together.
        data = model.drive.data() | data | model.drive.totals()
    return data


def _fatigue(model: Model) -> dict[str, Any]:
    roller = model.setup.roller
    if model.turret_loaded and roller is not None:
        return model.turret_duty.fatigue_data(roller.dynamic_rating, roller.static_rating)
    return fatigue_data(model) if model.loaded else {}


def _cutter(model: Model) -> dict[str, Any]:
    return cutter_data(model) if model.profile.cutter is not None else {}


SOURCES: dict[str, Callable[[Model], dict[str, Any]]] = {
    "solid": solid_data,
    "contact": _contact,
    "fatigue": _fatigue,
    "dynamics": dynamics_data,
    "cutter": _cutter,
}


def with_costs(result: Result, model: Model) -> Result:
    """The result with what every computed fact cost, s."""
    result.data["cost_s"] = {name: round(seconds, 6) for name, seconds in model.ledger.costs.items()}
    return result


def write_result(result: Result, folder: Path) -> Path:
    """result.json in the folder, whole or not at all."""
    from camgeom.export.files import atomic_write

    path = folder / "result.json"
    text = json.dumps(result.data, indent=2, allow_nan=False, ensure_ascii=False) + "\n"
    with atomic_write(path) as file:
        file.write(text.encode())
    return path


def explain(model: Model, products: Iterable[str]) -> list[str]:
    """What was computed and what it cost, and what was skipped and why."""
    lines = [f"{seconds * 1e3:9.2f} ms  {name}" for name, seconds in model.ledger.costs.items()]
    facts = ("flanks", "solids", "clearances", "mass", "duty")
    skipped = [name for name in facts if name not in model.ledger.costs]
    reasons = dict.fromkeys(skipped, "not asked for")
    if "duty" in skipped and not model.loaded:
        reasons["duty"] = "the profile has no [operation], or no roller that one load bears on"
    lines += [f"  skipped     {name}: {reason}" for name, reason in reasons.items()]
    missing = [name for name in PRODUCTS if name not in set(products)]
    if missing:
        lines.append(f"  not asked   {', '.join(missing)}")
    import sys

    heavy = [m for m in ("scipy", "trimesh", "pyvista", "meshio", "manifold3d", "ezdxf") if m in sys.modules]
    lines.append(f"  imported    {', '.join(heavy) if heavy else 'none of the heavy libraries'}")
    return lines


