"""JSON Schema (draft 2020-12) of the profile, for editors that complete and check TOML while it is typed.

Everything comes from the types: cam kinds, followers, rollers, motion laws with their parameters, ranges, meanings.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any, get_args

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema

from camgeom.cams import cam_class, kinds
from camgeom.motion.catalogue import LAWS
from camgeom.motion.law import LawEntry, Parameter
from camgeom.profile import Profile
from camgeom.profile.duty import OperatingState
from camgeom.profile.motion import MAX_SEGMENTS
from camgeom.profile.own_track import MOST_TRACKS, OwnTrack
from camgeom.profile.reader import FOLLOWERS, OPTIONAL_SECTIONS, PLAIN_SECTIONS, ROLLER_TABLES, ROLLERS
from camgeom.profile.sections import MOST_STATES, MOST_STATIONS, MotionSegment, Reproduced, Units
from camgeom.profile.station import Station

DIALECT = "https://json-schema.org/draft/2020-12/schema"
Schema = dict[str, Any]


def schema() -> Schema:
    """The schema of a whole profile."""
    collected = _Definitions()
    optional = {name: getattr(import_module(home), word) for name, (home, word) in OPTIONAL_SECTIONS.items()}
    sections: Schema = {
        "name": {"type": "string", "minLength": 1, "maxLength": 120, "description": "shown in reports"},
        "units": {
            "type": "string", "enum": list(get_args(Units)), "default": "mm", "description": _meaning("units")
        },
        "reproduces": {
            "type": "string", "enum": list(get_args(Reproduced)), "description": _meaning("reproduces")
        },
        "cam": _one_of("kind", {kind: collected.of(cam_class(kind)) for kind in kinds()}, required=True),
        "follower": _one_of("kind", {kind: collected.of(model) for kind, model in FOLLOWERS.items()}),
        **{
            table: {**_one_of("shape", {shape: collected.of(model) for shape, model in ROLLERS.items()}),
                    "description": _meaning(table)}
            for table in ROLLER_TABLES
        },
        "motion": {
            "type": "array",
            "minItems": 1,
            "maxItems": MAX_SEGMENTS,
            "description": _meaning("motion"),
            "items": _segment(collected),
        },
        **{name: collected.of(model) for name, model in {**PLAIN_SECTIONS, **optional}.items()},
        "duty": {"type": "array", "maxItems": MOST_STATES, "description": _meaning("duty"), "items": _state(collected)},
        "track": {"type": "array", "maxItems": MOST_TRACKS, "description": _meaning("track"),
                  "items": _without_internal(collected.of(OwnTrack))},
        "station": {"type": "array", "maxItems": MOST_STATIONS, "description": _meaning("station"),
                    "items": collected.of(Station)},
    }
    return {
        "$schema": DIALECT,
        "title": "camgeom profile",
        "type": "object",
        "properties": sections,
        "required": ["cam", "motion"],
        "additionalProperties": False,
        "$defs": collected.definitions,
    }


def _state(collected: _Definitions) -> Schema:
    """An operating state, whose history may stand in a file."""
    own = collected.of(OperatingState)
    file = {"type": "string", "description": "CSV file with one column, instead of `history`"}
    return {**own, "properties": {**own["properties"], "history_file": file}}


def _without_internal(schema: Schema) -> Schema:
    """A section without what it comes to."""
    return {**schema, "properties": {key: one for key, one in schema["properties"].items() if not one.get("internal")}}


def _meaning(key: str) -> str:
    return Profile.model_fields[key].description or ""


class _Definitions:
    """Schemas of sections, with what they share gathered under $defs."""

    def __init__(self) -> None:
        self.definitions: Schema = {}

    def of(self, model: type[BaseModel]) -> Schema:
        """The schema of one section."""
        own = model.model_json_schema(schema_generator=GenerateJsonSchema)
        self.definitions |= _without_null(own.pop("$defs", {}))
        own.pop("title", None)
        plain: Schema = _without_null(own)
        return plain


def _without_null(schema: Any) -> Any:
    """The schema with optional values by their type alone (TOML has no null), and no titles made from key names."""
    if isinstance(schema, list):
        return [_without_null(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    kept = {key: value for key, value in schema.items() if not (key == "default" and value is None)}
    if isinstance(kept.get("title"), str):
        del kept["title"]
    options = kept.get("anyOf")
    if isinstance(options, list) and {"type": "null"} in options:
        others = [option for option in options if option != {"type": "null"}]
        del kept["anyOf"]
        kept = {**others[0], **kept} if len(others) == 1 else {"anyOf": others, **kept}
    return {key: _without_null(value) for key, value in kept.items()}


def _one_of(tag: str, options: dict[str, Schema], required: bool = False) -> Schema:
    """One of several tables, told apart by the value of a key; without `required` the first is the default."""
    tables = []
    for i, (name, table) in enumerate(options.items()):
        properties = {tag: {"const": name}, **{k: v for k, v in table["properties"].items() if k != tag}}
        needs = [key for key in table.get("required", []) if key != tag]
        needs = [tag, *needs] if required or i else needs
        tables.append({**table, "title": name, "properties": properties, "required": needs})
    return {"oneOf": tables}


def _segment(collected: _Definitions) -> Schema:
    """A dwell, or a move by one of the laws with its own parameters."""
    own = collected.of(MotionSegment)
    properties = _without_internal(own)["properties"]
    until = {"until": properties["until"]}
    dwell = {"title": "dwell", "type": "object", "properties": until, "required": ["until"]}
    moves = [_move(entry, properties) for _, entry in sorted(LAWS.items())]
    return {"oneOf": [{**dwell, "additionalProperties": False}, *moves]}


def _move(entry: LawEntry, properties: Schema) -> Schema:
    law = {"const": entry.name, "description": f"{entry.summary} Source: {entry.source}"}
    parameters = {name: _parameter(parameter) for name, parameter in entry.parameters.items()}
    return {
        "title": entry.name,
        "type": "object",
        "properties": {**properties, "law": law, **parameters},
        "required": ["until", "to", "law"],
        "additionalProperties": False,
    }


def _parameter(parameter: Parameter) -> Schema:
    kinds_of = {"number": "number", "integer": "integer", "switch": "boolean", "text": "string", "list": "array"}
    found: Schema = {"type": kinds_of[parameter.kind], "description": f"{parameter.help} ({parameter.allowed})"}
    if parameter.kind in ("number", "integer"):
        found |= {"minimum": parameter.low, "maximum": parameter.high}
    if parameter.default is not None:
        found["default"] = list(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
    return found
