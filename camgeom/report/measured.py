"""What a study keeps of a variant: products and checks that it asks for, and the numbers of their results by name."""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

from camgeom.checks import applies, light_checks
from camgeom.checks import checks as registered
from camgeom.report.delivery import finite
from camgeom.report.result import PRODUCTS, RIDES, chosen, compute, own_sections

if TYPE_CHECKING:
    from camgeom.checks.verdict import Verdict
    from camgeom.model import Model

Figures = dict[str, float | int | bool | str | None]
STUDIED = ("motion", "blank", "flank", "checks", "contact", "fatigue")
"""Products of a study where none are named: everything that needs no solid."""
MOVING = {"dynamics", "impact", "operation"}
"""tables of a profile whose keys, when they are varied, ask for the dynamics too"""
SECTIONS = ("motion", "blank", "flank", "solid", "contact", "together", "output_shaft", "fatigue", "dynamics", "impact",
            "cutter", "tolerance", "body")  # fmt: skip
"""of the result whose numbers are figures"""
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
    wanted = {product_of(figure) for figure in figures} & set(PRODUCTS) - {"exports", "report"}
    if ("dynamics" in data or "impact" in data) and tables & MOVING:
        wanted.add("dynamics")
    if "cutter" in tables:
        wanted.add("cutter")
    if "tolerance" in data or "tolerance" in tables:
        wanted.add("tolerance")
    beside = (name for name in PRODUCTS if name in wanted - set(STUDIED))
    return (*STUDIED, *beside), light_checks()


def product_of(figure: str) -> str:
    """The product of the result that a figure comes with: `contact` of `followers.2.contact.peak_pressure_mpa`."""
    first, *rest = figure.split(".")
    if first == "followers":
        first, *rest = rest[1:] or [""]
    return RIDES.get(".".join((first, *rest[:1])), RIDES.get(first, first))


def of_followers(figures: Collection[str], count: int) -> list[str]:
    """Names of figures, each with those of so many followers in its place behind it."""
    if count == 1:
        return list(figures)
    return [name for figure in figures
            for name in (figure, *(f"followers.{k}.{figure}" for k in range(1, count + 1)))]  # fmt: skip


def measure(
    model: Model, products: tuple[str, ...], checks: tuple[str, ...] | None
) -> tuple[Figures, str, str]:
    """The figures of one variant, its verdict and the reason of that.

    Of several followers no figure of one is without its number: `followers.1.contact.peak_pressure_mpa`; what they do
    together is `together.peak_pressure_mpa`.
    """
    result = compute(model, products, checks)
    figures: Figures = {}
    others = result.data.get("followers", [])
    own = own_sections(others)
    figures |= _told(result.data, [section for section in SECTIONS if section not in own])
    if own:
        for number, data in enumerate((result.data, *others), start=1):
            named = _told(data, [section for section in SECTIONS if section in own])
            figures |= {f"followers.{number}.{name}": value for name, value in named.items()}
    for finding in result.findings:
        name, who = f"checks.{finding.check}", re.match(r"follower \d+(?=: |$)", finding.where)
        name += f" {who[0]}" if who else ""
        figures[f"checks.{finding.check} {finding.where}" if name in figures else name] = finite(finding.value)
    failed = [finding.check for finding in result.findings if not finding.passed]
    unmade = [product.reason for product in result.products if product.exit_status]
    words = {0: result.verdict.level, 1: "fail", 2: "bad input", 3: "no result"}
    if result.verdict.loads is not None:
        figures["loads"] = result.verdict.loads.whose
    figures["not_judged"] = _not_judged(model, result.verdict, checks if "checks" in products else ())
    return figures, words[result.exit_status], "; ".join(dict.fromkeys([*unmade, *failed]))


def _told(data: dict[str, Any], sections: Sequence[str]) -> Figures:
    """The figures of some sections of a follower's data."""
    figures: Figures = {}
    for section in sections:
        figures |= _flat(data.get(section, {}), section)
    if "fatigue" in sections:
        for row in data.get("fatigue", {}).get("conventions", ()):
            figures |= _flat(row, f"fatigue.conventions.{row['convention'].replace(', ', '-')}")
    return figures


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
