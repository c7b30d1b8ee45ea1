"""What a study keeps of a variant: products and checks that it asks for, and the numbers of their results by name."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from camgeom.checks import applies, light_checks
from camgeom.checks import checks as registered
from camgeom.report.delivery import finite
from camgeom.report.result import PRODUCTS, chosen, compute

if TYPE_CHECKING:
    from camgeom.checks.verdict import Verdict
    from camgeom.model import Model

Figures = dict[str, float | int | bool | str | None]
STUDIED = ("motion", "blank", "flank", "checks", "contact", "fatigue")
"""Products of a study where none are named: everything that needs no solid."""
MOVING = {"dynamics", "impact", "operation"}
"""tables of a profile whose keys, when they are varied, ask for the dynamics too"""
OF_TABLES = ("dynamics", "cutter", "tolerance")
"""products of a table of the profile, whose checks judge them"""


def asked(
    only: Sequence[str] | None, data: dict[str, Any], tables: set[str | int], figures: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...] | None]:
    """Products and checks of a study: those named, with the checks of a named table's product; without any all that
    needs no solid, and what the `tables` of varied keys, a [tolerance] table and the figures ask for beside."""
    if only is not None:
        products, named = chosen("run", only)
        own = set(products) & set(OF_TABLES)
        if named is None and own:
            named = tuple(name for name, one in registered().items() if own & set(one.needs))
            products = (*products, "checks")
        return products, named
    wanted = {figure.partition(".")[0] for figure in figures} & set(PRODUCTS) - {"exports", "report"}
    if ("dynamics" in data or "impact" in data) and tables & MOVING:
        wanted.add("dynamics")
    if "cutter" in tables:
        wanted.add("cutter")
    if "tolerance" in data or "tolerance" in tables:
        wanted.add("tolerance")
    beside = (name for name in PRODUCTS if name in wanted - set(STUDIED))
    return (*STUDIED, *beside), light_checks()


def measure(
    model: Model, products: tuple[str, ...], checks: tuple[str, ...] | None
) -> tuple[Figures, str, str]:
    """The figures of one variant, its verdict and the reason of that."""
    result = compute(model, products, checks)
    figures: Figures = {}
    for section in ("motion", "blank", "flank", "solid", "contact", "output_shaft", "fatigue", "dynamics", "impact",
                    "cutter", "tolerance", "body"):  # fmt: skip
        figures |= _flat(result.data.get(section, {}), section)
    for row in result.data.get("fatigue", {}).get("conventions", ()):
        figures |= _flat(row, f"fatigue.conventions.{row['convention'].replace(', ', '-')}")
    for finding in result.findings:
        name = f"checks.{finding.check}" + (f" {finding.where}" if f"checks.{finding.check}" in figures else "")
        figures[name] = finite(finding.value)
    failed = [finding.check for finding in result.findings if not finding.passed]
    unmade = [product.reason for product in result.products if product.exit_status]
    words = {0: result.verdict.level, 1: "fail", 2: "bad input", 3: "no result"}
    if result.verdict.loads is not None:
        figures["loads"] = result.verdict.loads.whose
    figures["not_judged"] = _not_judged(model, result.verdict, checks if "checks" in products else ())
    return figures, words[result.exit_status], "; ".join(dict.fromkeys([*unmade, *failed]))


def _not_judged(model: Model, verdict: Verdict, checks: tuple[str, ...] | None) -> str:
    """Names of the checks that a variant's verdict leaves out: told by the verdict, or not asked for by the study."""
    asked = registered(model).items() if checks is not None else ()
    left = [name for name, entry in asked if name not in (checks or ()) and applies(entry, model)]
    return " ".join(dict.fromkeys([*(omitted.check for omitted in verdict.not_judged), *left]))


MOST_LISTED = 6
"""numbers of a list that are columns of their own; longer lists are curves"""


def _flat(data: dict[str, Any], name: str) -> Figures:
    """The numbers of a table and of the tables and short lists in it, by dotted names; lists count from 1."""
    found: Figures = {}
    for key, value in data.items():
        if isinstance(value, list) and len(value) <= MOST_LISTED:
            value = {str(i): one for i, one in enumerate(value, 1) if isinstance(one, int | float)}
        if isinstance(value, dict):
            found |= _flat(value, f"{name}.{key}")
        elif value is None or isinstance(value, bool | int | float):
            found[f"{name}.{key}"] = finite(value)
    return found
