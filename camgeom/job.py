"""A job: the facts a command asks for, as the result that scripts rely on, and the files it leaves.

Products are named pieces of the result; a job computes those asked for and nothing they do not need.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.products import (
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
    """What a job found: plain data for result.json, the findings, and whether all passed."""

    data: dict[str, Any]
    findings: tuple[Finding, ...]
    refused: str = ""

    @property
    def passed(self) -> bool:
        """True where every finding passes and every body asked for could be made."""
        return not self.refused and all(finding.passed for finding in self.findings)


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
    """The result of the named products. A body that cannot be made is reported, not raised."""
    from camgeom import __version__

    wanted = set(products)
    data: dict[str, Any] = {"name": model.profile.name, "kind": model.profile.kind, "version": __version__}
    found: tuple[Finding, ...] = ()
    refused = ""
    if "motion" in wanted:
        data["motion"] = motion_data(model)
    if "flank" in wanted and (model.tracks or model.planar is not None):
        data["flank"] = flank_data(model) if model.tracks else {}
        data["flank"] |= model.planar.data() if model.planar is not None else {}
        data["flank"] |= model.pair.data() if model.pair is not None else {}
    if "checks" in wanted:
        from camgeom.checks import findings

        found = findings(model, only_checks)
        data["checks"] = [finding.as_dict() for finding in found]
    if "solid" in wanted:
        try:
            data["solid"] = solid_data(model)
        except DesignError as error:
            refused = str(error)
            data["solid"] = {"refused": refused}
    if model.loaded and wanted & {"contact", "fatigue"}:
        if "contact" in wanted:
            data["contact"] = contact_data(model)
        if "fatigue" in wanted:
            data["fatigue"] = fatigue_data(model)
    if model.turret_loaded:
        if "contact" in wanted:
            data["contact"] = model.turret_duty.contact_data()
        if "fatigue" in wanted and model.setup.roller is not None:
            roller = model.setup.roller
            data["fatigue"] = model.turret_duty.fatigue_data(roller.dynamic_rating, roller.static_rating)
    if model.driven and "contact" in wanted:
        # A roller's own contact (crowning, slices) stands; force and torque are those of all touches together.
        data["contact"] = model.drive.data() | data.get("contact", {}) | model.drive.totals()
    if "dynamics" in wanted and (found_dynamics := dynamics_data(model)):
        data["dynamics"] = found_dynamics
    if "cutter" in wanted and model.profile.cutter is not None:
        try:
            data["cutter"] = cutter_data(model)
        except DesignError as error:
            refused = refused or str(error)
            data["cutter"] = {"refused": str(error)}
    data["files"] = []
    return Result(data, found, refused)


def with_costs(result: Result, model: Model) -> Result:
    """The result with what every computed fact cost, s."""
    result.data["cost_s"] = {name: round(seconds, 6) for name, seconds in model.ledger.costs.items()}
    return result


def write_result(result: Result, folder: Path) -> Path:
    """result.json in the folder, whole or not at all."""
    from camgeom.export.atomic import atomic_write

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


