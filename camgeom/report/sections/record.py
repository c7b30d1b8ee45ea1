"""What stands behind the page: every parameter of the profile, and what was computed and what it cost."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from camgeom.drawing.content import Block, Cell, Column, Cost, Table
from camgeom.keys import Section

if TYPE_CHECKING:
    from camgeom.model import Model


def parameters(model: Model) -> tuple[Block, ...]:
    """Every key of the profile with its value, unit and meaning; defaults included."""
    rows = tuple(_rows(model.profile, ""))
    columns = (Column("Key"), Column("Value"), Column("Meaning"))
    return (Table("The profile, with defaults", columns, rows),)


def _rows(section: Section, prefix: str) -> Iterator[tuple[Cell, ...]]:
    for name, field in type(section).model_fields.items():
        extra = field.json_schema_extra
        if isinstance(extra, dict) and extra.get("internal") and name != "parameters":
            continue
        value = getattr(section, name)
        key = f"{prefix}{field.alias or name}"
        if isinstance(value, Section):
            yield from _rows(value, f"{key}.")
        elif isinstance(value, tuple) and value and all(isinstance(item, Section) for item in value):
            for i, item in enumerate(value, start=1):
                yield from _rows(item, f"{key}[{i}].")
        elif name == "parameters":
            yield from ((f"{prefix}{word}", _text(given), "parameter of the law") for word, given in value)
        elif value is not None and value != ():
            yield key, _text(value), field.description or ""


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.12g}"
    if isinstance(value, tuple):
        return ", ".join(map(_text, value))
    return str(value)


def cost(model: Model) -> tuple[Block, ...]:
    """Seconds of every fact computed so far, and the facts nobody asked for."""
    facts = ("flanks", "solids", "clearances", "mass", "duty")
    costs = model.ledger.costs
    return (Cost(tuple(costs.items()), tuple(name for name in facts if name not in costs)),)
