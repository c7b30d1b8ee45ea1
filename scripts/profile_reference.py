"""Write docs/profile.md, the reference of profile keys, from the JSON Schema that `camgeom schema` prints.

    python scripts/profile_reference.py            # writes docs/profile.md
    python scripts/profile_reference.py --check    # exit status 1 where the file is not what the schema says
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
PAGE = ROOT / "docs" / "profile.md"
Schema = dict[str, Any]
SHARED = ("until", "to", "law")
"""keys of every moving segment, listed once"""

HEAD = """# Keys of a profile

A profile is a TOML file. This page is made from the schema by `scripts/profile_reference.py`; `camgeom schema` prints
the schema itself, for editors that complete and check while you type, and `camgeom new KIND` a commented profile to
start from. With `camgeom schema > camgeom.schema.json` beside a profile, editors that know Taplo find it by the
profile's line `#:schema camgeom.schema.json`. Lengths are mm, angles degrees, forces N, stresses MPa, masses kg,
inertias kg m², speeds r/min. With `units = "inch"` at the top every length that the profile states is in inches: keys
whose meaning begins with mm, their arrays and scatters, and for translating followers `to`, its rates per degree and
the lifts among a law's own keys. Nothing else changes: a key that ends in `_mm` keeps mm as its name says, and N,
N/mm, N mm, N m, MPa, kg, mm/s, mm/min, mm2/s, mm3/(N m) and um stay (1 lbf = 4.4482 N, 1 lbf/in = 0.17513 N/mm, 1 psi
= 0.0068948 MPa). Options of the command line (`--tolerance`), data files and results are mm, and say so; lift tables
in files and forces that are expressions of the lift are refused by name there. `with_`, `--vary` and the page write
the profile's own unit. A key without a default must be given unless its meaning says what it is otherwise. A key that
is misspelt, out of range or missing is reported with its allowed range and the nearest spelling, all of them at once;
so is a key that means nothing for the cam, follower, roller, tool or solver of the profile (other than at its
default), with what it belongs to.
"""


def main() -> int:
    """Write the page, or compare it; 0 when it is current."""
    parser = argparse.ArgumentParser(description="Reference of profile keys.")
    parser.add_argument("--check", action="store_true", help="compare only")
    text = reference()
    if parser.parse_args().check:
        return int(not PAGE.is_file() or PAGE.read_text(encoding="utf-8") != text)
    PAGE.write_text(text, encoding="utf-8")
    print(f"{PAGE.relative_to(ROOT)}: {len(text.splitlines())} lines")
    return 0


def reference() -> str:
    """The page."""
    from camgeom.profile.schema import schema

    whole = schema()
    lines = [HEAD]
    needed = set(whole["required"])
    plain = [name for name, section in whole["properties"].items() if section.get("type") == "string"]
    told: dict[str, Any] = {}
    lines += ["## At the top of the file", "", *table(whole["properties"], plain, needed, whole["$defs"])]
    for name, section in whole["properties"].items():
        if name in plain:
            continue
        lines += ["", f"## {heading(name, section)}", ""]
        if name not in needed:
            lines += ["Optional.", ""]
        lines += [f"{sentence(section['description'])}", ""] if section.get("description") else []
        kinds = section.get("oneOf")
        same = next((other for other, known in told.items() if kinds is not None and known == kinds), None)
        told[name] = kinds
        if same is not None:
            lines += [f"Its keys are those of `[{same}]`."]
            continue
        lines += motion(section) if name == "motion" else parts(name, section.get("items", section), whole["$defs"])
    return "\n".join(lines).rstrip() + "\n"


def heading(name: str, section: Schema) -> str:
    """The section as it is written in a profile."""
    return f"`[[{name}]]`" if section.get("type") == "array" else f"`[{name}]`"


def sentence(text: str) -> str:
    """A meaning as a sentence."""
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".")


def parts(name: str, section: Schema, definitions: Schema) -> Iterator[str]:
    """The keys of a section, of each of its kinds, and of the tables inside it."""
    for option in section.get("oneOf", [section]):
        if "oneOf" in section:
            tag = next(key for key, value in option["properties"].items() if "const" in value)
            name_of = option["properties"][tag]["const"]
            yield from (f'### `{tag} = "{name_of}"`', "", sentence(option["description"]), "")
        yield from table(option["properties"], list(option["properties"]), set(option.get("required", [])), definitions)
        yield ""
        for key, value in option["properties"].items():
            inner = target(value, definitions) or target(value.get("items", {}), definitions)
            if inner is not None:
                dotted = f"[[{name}.{key}]]" if value.get("type") == "array" else f"[{name}.{key}]"
                yield from (f"### `{dotted}`", "", sentence(inner.get("description", "")), "")
                yield from table(inner["properties"], list(inner["properties"]), set(inner.get("required", [])), {})
                yield ""


def target(value: Schema, definitions: Schema) -> Schema | None:
    """The table that a value refers to; None for a plain value."""
    return definitions.get(value["$ref"].rpartition("/")[2]) if "$ref" in value else None


def table(properties: Schema, names: list[str], needed: set[str], definitions: Schema) -> list[str]:
    """Rows of key, value, default and meaning."""
    rows = ["| key | value | default | meaning |", "|---|---|---|---|"]
    for name in names:
        value = properties[name]
        if "const" in value:  # the heading says it
            continue
        default = "required" if name in needed else shown_default(value, definitions)
        meaning = cell(value.get("description", ""))
        rows.append(f"| `{name}` | {cell(kind(value, definitions))} | {default} | {meaning} |")
    return rows


def cell(text: str) -> str:
    """Text that cannot break out of a table row."""
    return text.replace("|", "\\|").replace("\n", " ")


def shown_default(value: Schema, definitions: Schema) -> str:
    """The default as TOML; empty where there is none or it is a table."""
    if "default" not in value or target(value, definitions) is not None or isinstance(value["default"], dict):
        return ""
    return f"`{toml(value['default'])}`"


def toml(value: Any) -> str:
    """A value as it is written in a profile."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return f"{value:g}" if isinstance(value, float) else str(value)


def kind(value: Schema, definitions: Schema) -> str:
    """Type and range of a value in words."""
    if target(value, definitions) is not None:
        return "table"
    if "const" in value:
        return f"`{toml(value['const'])}`"
    if "anyOf" in value:
        return " or ".join(kind(option, definitions) for option in value["anyOf"])
    if "enum" in value:
        return " · ".join(f"`{toml(word)}`" for word in value["enum"])
    if value.get("type") == "array":
        if target(value.get("items", {}), definitions) is not None:
            return "list of tables"
        items = value.get("items") or next(iter(value.get("prefixItems", [])), {})
        return f"list, each {kind(items, definitions)}" if items else "list"
    word = {"number": "number", "integer": "whole number", "boolean": "`true` · `false`", "string": "text"}
    return " ".join(part for part in (word.get(value.get("type", ""), "value"), bounds(value)) if part)


def bounds(value: Schema) -> str:
    """The range of a number."""
    low, over = value.get("minimum"), value.get("exclusiveMinimum")
    high, under = value.get("maximum"), value.get("exclusiveMaximum")
    least = f"{low:g}" if low is not None else f"above {over:g}" if over is not None else ""
    most = f"{high:g}" if high is not None else f"below {under:g}" if under is not None else ""
    if low is not None and most:
        return f"{least} to {most}"
    least = f"from {least}" if low is not None else least
    return ", ".join(part for part in (least, most and f"up to {most}") if part)


def motion(section: Schema) -> Iterator[str]:
    """The keys of a segment once, then the laws with their own parameters."""
    moves = [option for option in section["items"]["oneOf"] if "law" in option["properties"]]
    common = {key: value for key, value in moves[0]["properties"].items() if all(key in m["properties"] for m in moves)}
    common["law"] = {"type": "string", "description": "one of the laws below; a segment without `to` is a dwell"}
    yield from table(common, list(common), {"until"}, {})
    yield from ("", "| law | its own keys | what it is |", "|---|---|---|")
    for move in moves:
        own = {key: value for key, value in move["properties"].items() if key not in common}
        needed = set(move["required"])
        keys = "; ".join(f"`{k}` {parameter(v, k in needed)}" for k, v in own.items())
        yield f"| `{move['title']}` | {cell(keys)} | {cell(move['properties']['law']['description'])} |"


def parameter(value: Schema, needed: bool) -> str:
    """A law's parameter: meaning and default."""
    default = ", required" if needed else f", default `{toml(value['default'])}`" if "default" in value else ""
    return f"{value.get('description', '')}{default}"


if __name__ == "__main__":
    sys.exit(main())
