"""JSON Schema (draft 2020-12) of result.json: its frame key by key, its figures by the unit that ends their names.

The words of figures are those that the text of a command prints (`report.figures`). A key that is taken away, renamed
or given another meaning makes a new VERSION; new figures and sections do not.
"""

from __future__ import annotations

from typing import Any, get_args

from camgeom.checks.verdict import RANK
from camgeom.report.figures import KEY_FIGURES, UNITS, VERSION
from camgeom.report.result import Status

DIALECT = "https://json-schema.org/draft/2020-12/schema"
Schema = dict[str, Any]

SECTIONS = {
    "motion": "the motion program: stroke, peaks per radian of cam angle and in time, jumps; best laws",
    "blank": "the cam's envelope, and the measures that its kind has names for",
    "flank": "extremes of pressure angle, curvature, undercut, sliding",
    "solid": "the bodies: volume, mass, inertia, mesh and its error",
    "contact": "forces, pressures and torques of the rigid follower, with their cam angles",
    "together": "what several followers on one cam do together: torque of the shaft, least distance, the cam's life; "
                "`tolerance` in it what a machine keeps with all of them",
    "output_shaft": "what output shaft and bolts of a turret bear",
    "fatigue": "lives of roller, cam, face and bearing, film, friction and wear",
    "body": "stress at the root of a groove, at the foot of a rib or of an end face's ring, or in a frame's plate",
    "dynamics": "vibration; `impact` in it are the impacts in the clearance",
    "cutter": "what the tool leaves and how long it takes",
    "tolerance": "what errors of assembly and manufacture cost",
}
"""sections of figures, each with what it tells"""
FILE_NOTES = {"step": "what each STEP file holds"}
"""what writers tell of their files"""


def _text(meaning: str) -> Schema:
    return {"type": "string", "description": meaning}


def _number(meaning: str) -> Schema:
    return {"type": ["number", "null"], "description": meaning}


def _table(properties: Schema, optional: tuple[str, ...] = ()) -> Schema:
    """An object of these keys and no others."""
    required = [key for key in properties if key not in optional]
    return {"type": "object", "required": required, "additionalProperties": False, "properties": properties}


def _list(items: Schema, meaning: str) -> Schema:
    return {"type": "array", "description": meaning, "items": items}


def products() -> Schema:
    """What became of everything that was asked for, by its name."""
    known = {
        "status": {"enum": list(get_args(Status))},
        "reason": _text("why it was not made; of what was made, what there is to know of it"),
        "files": _list({"type": "string"}, "names of its files in the folder"),
        "trace": _list({"type": "string"}, "where an error of camgeom itself came from"),
    }
    one = _table(known, ("reason", "files", "trace"))
    return {"type": "object", "description": "what was asked for, in the order in which it was tried",
            "additionalProperties": one}  # fmt: skip


def finding() -> Schema:
    """A judgement of the verdict."""
    return _table({
        "check": _text("its name"),
        "level": {"enum": list(RANK)},
        "value": _number("what was found; null: endless"),
        "limit": _number("what it is compared with; null: with nothing"),
        "comparison": {"enum": ["", "<=", ">=", "<", ">", "="]},
        "unit": _text("of value and limit"),
        "margin": _number("%, room to the limit, negative beyond it"),
        "passed": {"type": "boolean", "description": "true unless it fails"},
        "cam_angle_deg": _number("where round the cam"),
        "where": _text("in words"),
        "advice": _text("what would help"),
        "rigid": _number("the same figure of the rigid follower"),
    })  # fmt: skip


def section(name: str, meaning: str) -> Schema:
    """A section of figures, or why there is none; the figures that a command prints with their words."""
    words: dict[str, Schema] = {}
    for key, text, unit in KEY_FIGURES.get(name, ()):
        head, _, rest = key.partition(".")
        if not rest:
            words[head] = {"$ref": "#/$defs/quantity", "description": f"{unit + ', ' if unit else ''}{text}"}
    # A text, the speed's class, is no quantity.
    words = {key: value for key, value in words.items() if key != "speed_class"}
    return {"$ref": "#/$defs/figures", "description": meaning, "properties": words}


def schema() -> Schema:
    """The schema of result.json."""
    figures = {name: section(name, meaning) for name, meaning in SECTIONS.items()}
    frame: Schema = {
        "schema": {"const": VERSION, "description": "version of this schema"},
        "name": _text("of the profile"),
        "kind": _text("of the cam"),
        "version": _text("of camgeom"),
        "units": _text("only where the profile states lengths in another unit than mm"),
        "reproduces": _text("the source that the profile is the machine of"),
        **figures,
        "verdict": {"enum": list(RANK), "description": "the worst of the findings"},
        "loads": _table({
            "rigid": {"type": "boolean"}, "vibration": {"type": "boolean"}, "impacts": {"type": "boolean"},
            "shortest_move_ms": _number("time of the shortest move"),
        }),
        "not_judged": _list(_table({"check": _text("its name"), "reason": _text("what to give so that it is")}),
                            "checks that apply and could not be judged"),
        "checks": _list(finding(), "what was judged, in the order of the checks"),
        "followers": _list(
            {"type": "object", "additionalProperties": False,
             "properties": {"angle_deg": _number("its place; other angles are of its own cam angle"),
                            "track": _number("on which it runs, the first is 1"), **figures}},
            "the sections of loads and lives of every further follower"),
        **{name: _list({"type": "object"}, meaning) for name, meaning in FILE_NOTES.items()},
        "files": _list({"type": "string"}, "paths of what was written"),
        "products": products(),
        "cost_s": {"type": "object", "description": "s, what every fact cost", "additionalProperties": _number("")},
        "explain": _list({"type": "string"}, "the lines of --explain"),
    }  # fmt: skip
    return {
        "$schema": DIALECT,
        "title": f"camgeom result, version {VERSION}",
        **_table(frame, tuple(key for key in frame if key not in ("schema", "name", "kind", "version", "files",
                                                                  "products", "cost_s"))),
        "$defs": {
            "quantity": {
                "description": "a number in the unit that ends its name; null: endless, or none. " + ", ".join(
                    f"_{end}: {unit}" for end, unit in UNITS.items()),
                "anyOf": [
                    {"type": ["number", "null"]},
                    {"type": "array", "items": {"$ref": "#/$defs/quantity"}},
                    {"type": "object", "additionalProperties": {"anyOf": [
                        {"type": "string"}, {"$ref": "#/$defs/quantity"},
                    ]}},
                ],
            },
            "figures": {
                "description": "figures by name; in the place of a section that was not made, its status and reason",
                "type": "object",
                "patternProperties": {f"_({'|'.join(UNITS)})$": {"$ref": "#/$defs/quantity"}},
                "additionalProperties": {"anyOf": [
                    {"type": ["number", "null", "string", "boolean"]},
                    {"type": "array", "items": {"anyOf": [
                        {"type": ["number", "null", "string", "boolean", "array"]}, {"$ref": "#/$defs/figures"},
                    ]}},
                    {"$ref": "#/$defs/figures"},
                ]},
            },
        },
    }  # fmt: skip
