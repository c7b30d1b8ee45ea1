"""The JSON Schema of the profile: it takes what the reader takes, and refuses what an editor should mark.

The checker below knows the few keywords that the schema uses, and refuses any other, so that none is passed over.
"""

from __future__ import annotations

import tomllib
from math import inf
from pathlib import Path
from typing import Any

import pytest

from camgeom.cams import kinds, starter
from camgeom.cli import main
from camgeom.profile import parse
from camgeom.profile.schema import schema
from tests.places import PROFILES

SCHEMA = schema()
STARTERS = {kind: tomllib.loads(starter(kind)) for kind in kinds()}
NAMES = sorted(PROFILES.glob("*.toml"))
TYPES: dict[str, Any] = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "integer": int,
    "number": (int, float),
}
SILENT = {"$schema", "$defs", "title", "description", "default"}


def fits(value: Any, rule: dict[str, Any]) -> bool:
    """Whether a value fulfils a schema."""
    ordered = sorted(rule, key=lambda keyword: keyword != "type")  # a bound means nothing to a value of another type
    return all(_fulfils(value, keyword, rule) for keyword in ordered if keyword not in SILENT)


def _fulfils(value: Any, keyword: str, rule: dict[str, Any]) -> bool:
    wanted = rule[keyword]
    if keyword == "$ref":
        return fits(value, SCHEMA["$defs"][wanted.removeprefix("#/$defs/")])
    if keyword == "type":
        return isinstance(value, TYPES[wanted]) and (wanted == "boolean" or not isinstance(value, bool))
    if keyword in ("oneOf", "anyOf"):
        matches = sum(fits(value, option) for option in wanted)
        return matches == 1 if keyword == "oneOf" else matches >= 1
    if keyword in ("const", "enum"):
        return value in (wanted if keyword == "enum" else [wanted])
    if isinstance(value, dict):
        return _table_fulfils(value, keyword, rule)
    if isinstance(value, list):
        return _array_fulfils(value, keyword, rule)
    bounds = {
        "minimum": lambda: value >= wanted,
        "maximum": lambda: value <= wanted,
        "exclusiveMinimum": lambda: value > wanted,
        "exclusiveMaximum": lambda: value < wanted,
        "minLength": lambda: len(value) >= wanted,
        "maxLength": lambda: len(value) <= wanted,
        "pattern": lambda: pytest.fail("no pattern is expected"),
    }
    return keyword not in bounds or bool(bounds[keyword]()) if isinstance(value, str | int | float) else True


def _table_fulfils(value: dict[str, Any], keyword: str, rule: dict[str, Any]) -> bool:
    if keyword == "properties":
        return all(fits(value[key], inner) for key, inner in rule[keyword].items() if key in value)
    if keyword == "required":
        return set(rule[keyword]) <= set(value)
    assert keyword == "additionalProperties"
    if rule[keyword] is True:
        # Keys of a table that another section describes.
        return True
    assert rule[keyword] is False
    return set(value) <= set(rule["properties"])


def _array_fulfils(value: list[Any], keyword: str, rule: dict[str, Any]) -> bool:
    if keyword == "items":
        return rule[keyword] is False or all(fits(item, rule[keyword]) for item in value)
    if keyword == "prefixItems":
        return all(fits(item, inner) for item, inner in zip(value, rule[keyword]))
    assert keyword in ("minItems", "maxItems")
    return rule.get("minItems", 0) <= len(value) <= rule.get("maxItems", inf)


@pytest.mark.parametrize("kind", kinds())
def test_starters_fit(kind: str) -> None:
    assert fits(STARTERS[kind], SCHEMA)


@pytest.mark.parametrize("path", NAMES, ids=lambda path: path.stem)
def test_profiles_fit(path: Path) -> None:
    assert fits(tomllib.loads(path.read_text()), SCHEMA)


@pytest.mark.parametrize("kind", kinds())
def test_starters_are_profiles_of_their_kind(kind: str, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    text = starter(kind)
    profile = parse(text)
    assert profile.kind == kind
    assert "#" in text, "a starter is commented"
    assert main(["new", kind.replace("-", "_").upper()]) == 0
    assert capsys.readouterr().out == text.strip("\n") + "\n"
    file = tmp_path / "new.toml"
    assert main(["new", kind, str(file)]) == 0
    assert file.read_text() == text.lstrip("\n")
    assert capsys.readouterr().out == f"wrote {file}\n"
    assert main(["new", kind, str(file)]) == 2


@pytest.mark.parametrize("kind", kinds())
@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("cam", "bore", -1),
        ("cam", "boer", 1),
        ("cam", "kind", "square"),
        ("follower", "kind", "hopping"),
        ("roller", "diameter", "22"),
        ("roller", "shape", "cube"),
        ("output", "tolerance", 2),
        ("output", "formats", "stl"),
        ("operation", "speed", 0),
        ("limits", "life_h", True),
    ],
)
def test_mistakes_do_not_fit(kind: str, section: str, key: str, value: object) -> None:
    good = STARTERS[kind]
    assert not fits({**good, section: {**good.get(section, {}), key: value}}, SCHEMA)


@pytest.mark.parametrize(
    "segment",
    [
        {"until": 100_001},
        {"until": 0},
        {"until": 10, "to": 5},
        {"until": 10, "law": "cycloidal"},
        {"until": 10, "to": 5, "law": "cycloid"},
        {"until": 10, "to": 5, "law": "cycloidal", "share": 0.5},
        {"until": 10, "to": 5, "law": "modified-sine", "share": 5},
        {"until": 10, "parameters": []},
    ],
)
def test_segments_that_do_not_fit(segment: dict[str, Any]) -> None:
    rule = SCHEMA["properties"]["motion"]
    assert fits([{"until": 10, "to": 5, "law": "modified-sine", "share": 0.1}, {"until": 360}], rule)
    assert not fits([segment], rule)


def test_sections_are_described() -> None:
    for section in ("operation", "output", "limits"):
        for key, rule in SCHEMA["properties"][section]["properties"].items():
            assert rule.get("description"), f"{section}.{key} says what it means"
