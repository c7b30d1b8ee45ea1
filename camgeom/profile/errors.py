"""Plain words for what is wrong with a profile: validation errors, allowed ranges and nearest spellings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from types import UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from camgeom.errors import Problem, did_you_mean, nearest
from camgeom.profile.text import Path_, dotted

Model = type[BaseModel]
Sections = Mapping[str, Sequence[Model]]
"""Where each section (dotted path) is found and the models it may be made of."""

MOST_PROBLEMS = 50
"""More are not told; nobody reads further, and a hostile file must not make us look up spellings for ever."""
UNKNOWN = "unknown key"
OF_SLIDE = re.compile(r"deg \(mm|mm \((?:or )?deg")
"""at the head of a meaning: mm of a translating follower, degrees of one that turns"""

_WRONG_TYPE = {
    "float": "needs a number",
    "int": "needs a whole number",
    "string": "needs text in quotes",
    "bool": "needs true or false",
    "tuple": "needs an array",
    "list": "needs an array",
    "model": "needs a table",
    "dict": "needs a table",
}


def choice_problem(key: str, word: object, known: Sequence[str], what: str) -> Problem:
    """The problem of a name that is not one of the known ones."""
    listed = ", ".join(known)
    if not isinstance(word, str):
        return Problem(key, f"needs the name of {what} in quotes", plain(word), listed)
    return Problem(key, f"unknown {what.removeprefix('a ')}", word, listed, did_you_mean(word, known))


def plain(value: object) -> object:
    """A value fit to be shown: tables and arrays by their size only."""
    if isinstance(value, dict):
        return _Shown("a table")
    if isinstance(value, tuple | list):
        return _Shown(f"an array of {len(value)}")
    return _Shown(str(value).lower()) if isinstance(value, bool) else value


class _Shown:
    def __init__(self, text: str) -> None:
        self.text = text

    def __repr__(self) -> str:
        return self.text


def keys_of(model: Model) -> dict[str, FieldInfo]:
    """The keys of a section as they are written in the profile."""
    return {field.alias or name: field for name, field in model.model_fields.items() if not field.json_schema_extra}


def translate(error: ValidationError, model: Model, data: Any, at: Path_, sections: Sections) -> list[Problem]:
    """One problem for each wrong place in `data`, which stands at the path `at` and was to become a `model`."""
    found: dict[Path_, list[Problem]] = {}
    for item in error.errors(include_url=False)[:MOST_PROBLEMS]:
        local, owner, field = _walk(model, data, item["loc"], item["type"])
        path = (*at, *local)
        problem = _problem(dict(item), path, owner, field, sections)
        found.setdefault(path, []).append(problem)
    return without_guessed([_merged(problems) for problems in found.values()])


def without_guessed(problems: list[Problem]) -> list[Problem]:
    """The problems less each missing key that a misspelt key beside it was meant for."""
    meant = {_sibling(p.key, p.hint) for p in problems if p.message == UNKNOWN}
    return [p for p in problems if p.key not in meant or "missing" not in p.message]


def _sibling(key: str, hint: str) -> str:
    word = re.fullmatch(r"did you mean '(.*)'\?", hint)
    parent = key.rpartition(".")[0]
    return f"{parent}.{word[1]}".removeprefix(".") if word else ""


def _merged(problems: list[Problem]) -> Problem:
    """One problem for a place that fitted none of several possible forms."""
    first = problems[0]
    messages = list(dict.fromkeys(p.message for p in problems))
    allowed = list(dict.fromkeys(p.allowed for p in problems if p.allowed))
    return Problem(first.key, " or ".join(messages), first.value, "; or ".join(allowed), first.hint)


def _walk(
    model: Model, data: Any, loc: tuple[str | int, ...], kind: str
) -> tuple[Path_, Model | None, FieldInfo | None]:
    """The key path within `data` of an error's location, which also names union members and validators.

    Also the section that owns the key, and the key's field where the place is the key itself and no entry of its array.
    """
    path: list[str | int] = []
    owner: Model | None = model
    field: FieldInfo | None = None
    inside = False
    here = data
    for i, part in enumerate(loc):
        last = i == len(loc) - 1
        if isinstance(part, int) and isinstance(here, tuple | list) and part < len(here):
            path.append(part)
            here, inside = here[part], True
            continue
        if not isinstance(part, str):
            continue
        if isinstance(here, dict) and (part in here or (last and kind == "missing")):
            if field is not None:
                owner = _model_in(field, here)
            field = keys_of(owner).get(part) if owner is not None else None
            path.append(part)
            here, inside = here.get(part), False
    return tuple(path), owner, None if inside else field


def _model_in(field: FieldInfo, data: dict[str, Any]) -> Model | None:
    """The section a field holds; of several the one whose keys fit the data best."""
    models = list(models_in(field.annotation))
    return max(models, key=lambda m: _fit(m, data), default=None)


def _fit(model: Model, data: dict[str, Any]) -> int:
    keys = keys_of(model)
    score = sum(key in keys for key in data)
    for key, field in keys.items():
        if get_origin(field.annotation) is Literal and data.get(key, field.default) in get_args(field.annotation):
            score += 100
    return score


def models_in(annotation: Any) -> Iterable[Model]:
    """Every section class named in a type annotation."""
    if isinstance(annotation, type) and get_origin(annotation) is None:
        if issubclass(annotation, BaseModel):
            yield annotation
        return
    for argument in get_args(annotation):
        yield from models_in(argument)


def _problem(
    item: dict[str, Any], path: Path_, owner: Model | None, field: FieldInfo | None, sections: Sections
) -> Problem:
    kind, value, key = str(item["type"]), plain(item.get("input")), dotted(path)
    allowed = range_text(field) if field is not None else ""
    if kind == "missing":
        return Problem(key, "is missing", None, allowed, _meaning(field, bool(allowed)))
    if kind == "extra_forbidden":
        return Problem(key, UNKNOWN, value, "", _key_hint(str(path[-1]), path[:-1], owner, sections))
    context = item.get("ctx", {})
    if kind in {"literal_error", "enum"}:
        known = _choices(field) or [str(context.get("expected", ""))]
        hint = did_you_mean(value, known) if isinstance(value, str) else ""
        return Problem(key, "unknown choice", value, ", ".join(known), hint)
    if kind == "union_tag_invalid":
        known = re.findall(r"'([^']*)'", str(context.get("expected_tags", "")))
        tag = str(context.get("tag", ""))
        at = f"{key}.{str(context.get('discriminator', '')).strip(chr(39))}"
        return Problem(at, "unknown choice", tag, ", ".join(known), did_you_mean(tag, known))
    if kind == "union_tag_not_found":
        return Problem(f"{key}.{str(context.get('discriminator', '')).strip(chr(39))}", "is missing")
    if kind in {"value_error", "assertion_error"}:
        shown = None if isinstance(value, _Shown) else value
        return Problem(key, str(context.get("error", item["msg"])), shown, allowed)
    hint = ""
    if isinstance(value, str) and kind in ("float_type", "int_type"):
        from camgeom.profile.syntax import number_hint

        hint = number_hint(value)
    given = item.get("input")
    if kind == "tuple_type" and isinstance(given, dict) and field is not None and any(models_in(field.annotation)):
        hint = f"write [[{key}]] in double brackets: each is a table of its own"
    elif kind in ("model_type", "dict_type") and isinstance(given, tuple):
        hint = f"write [{key}] in single brackets: there is one of it"
    return Problem(key, _message(kind, item), value, allowed, hint)


def _message(kind: str, item: dict[str, Any]) -> str:
    head = kind.split("_")[0]
    if kind.endswith("_type") and head in _WRONG_TYPE:
        return _WRONG_TYPE[head]
    context = item.get("ctx", {})
    if kind == "finite_number":
        return "must be a finite number"
    if kind.startswith(("greater_than", "less_than")):
        return "out of range"
    if kind in {"too_short", "too_long"}:
        return f"has {context.get('actual_length')} entries"
    if kind in {"string_too_long", "string_too_short"}:
        return "has a wrong length"
    if kind == "missing_argument":
        return "has too few entries"
    return str(item["msg"])


def _choices(field: FieldInfo | None) -> list[str]:
    return [] if field is None else list(_literals(field.annotation))


def _literals(annotation: Any) -> Iterable[str]:
    if get_origin(annotation) is Literal:
        yield from map(str, get_args(annotation))
    else:
        for argument in get_args(annotation):
            yield from _literals(argument)


def _key_hint(word: str, parent: Path_, owner: Model | None, sections: Sections) -> str:
    """Where a misspelt or misplaced key may have been meant: this section and every other one."""
    here = nearest(word, keys_of(owner)) if owner is not None else None
    keys = [(name, key) for name, models in sections.items() for model in models for key in keys_of(model)]
    places = list(dict.fromkeys(_place(name) + word for name, key in keys if key == word and name != dotted(parent)))
    guesses = ([repr(here)] if here and here != word else []) + places[:3]
    if not guesses and owner is None and (near := nearest(word, sorted({key for _, key in keys}))):
        guesses = [_place(next(name for name, key in keys if key == near)) + near]
    if guesses:
        return f"did you mean {' or '.join(guesses)}?"
    return f"known keys: {', '.join(keys_of(owner))}" if owner is not None else ""


def _place(name: str) -> str:
    return "top-level " if name == "profile" else f"[{name}] "


_BOUNDS = {
    "gt": "more than {:.15g}",
    "ge": "at least {:.15g}",
    "lt": "less than {:.15g}",
    "le": "at most {:.15g}",
    "min_length": "at least {} long",
    "max_length": "at most {} long",
}


def range_text(field: FieldInfo) -> str:
    """The allowed range of a field in words, with the unit that its description begins with."""
    choices = _choices(field)
    if choices:
        return ", ".join(choices)
    constraints = [*field.metadata, *_constraints(field.annotation)]
    bounds = {name: getattr(c, name) for c in constraints for name in _BOUNDS if getattr(c, name, None) is not None}
    parts = [text.format(bounds[name]) for name, text in _BOUNDS.items() if name in bounds]
    text = field.description or ""
    unit = "mm or deg" if OF_SLIDE.match(text) else _unit(text)
    return " and ".join(parts) + (f" {unit}" if unit not in ("", "1") and parts else "")


def _constraints(annotation: Any) -> Iterable[Any]:
    """The bounds in a type annotation, through optional and annotated types."""
    if get_origin(annotation) is Annotated:
        for entry in annotation.__metadata__:
            yield from entry.metadata if isinstance(entry, FieldInfo) else (entry,)
        yield from _constraints(annotation.__origin__)
    elif get_origin(annotation) in (Union, UnionType):
        for argument in get_args(annotation):
            yield from _constraints(argument)


def _meaning(field: FieldInfo | None, unit_shown: bool) -> str:
    """What a key means, without its unit where that is shown already."""
    text = (field.description or "") if field is not None else ""
    unit = _unit(text)
    return text[len(unit) :].lstrip(",; ") if unit and unit_shown else text


def _unit(description: str) -> str:
    """The unit at the head of a description: "mm, contact length" or "N"."""
    head = re.split(r"[,;(:]", description, maxsplit=1)[0].strip()
    return head if head in UNITS else ""


UNITS = frozenset(
    {"mm", "deg", "N", "kg", "kg m2", "kg m²", "N/mm", "MPa", "r/min", "h", "N m", "N mm", "m/s2", "m/s²", "s", "1"}
)
