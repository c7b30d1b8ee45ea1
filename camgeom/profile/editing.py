"""A profile's text with other values in it: comments, order and layout stay where one line is all that changes."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from camgeom.errors import Problem, ProfileError
from camgeom.profile.text import Path_, cleaned, dump, key_path, load, replaced, word

_HEADER = re.compile(r"\s*(\[\[?)\s*([\w-]+(?:\s*\.\s*[\w-]+)*)\s*\]\]?\s*(?:#.*)?$")
_LINE = re.compile(r"(\s*([\w-]+(?:\s*\.\s*[\w-]+)*)\s*=\s*)(.*)$")


def edited(text: str, changes: Mapping[str, Any], file: str = "") -> str:
    """The TOML text with other values under dotted keys (`cam.diameter`, `motion[1].to`); None takes a key away.

    What is written is read back: where the change cannot be made on its line, the whole text is written anew from its
    data, without comments. Raises ProfileError where the text is no TOML or a key breaks.
    """
    for key, value in changes.items():
        path = key_path(key)
        if path is None:
            allowed = "for example cam.diameter or motion[1].to"
            raise ProfileError([Problem(key, "is no dotted key", None, allowed)], file)
        clean, problems, _ = cleaned({"value": value} if value is not None else {}, file)
        if problems:
            raise ProfileError([Problem(key, problem.message) for problem in problems], file)
        data = replaced(_data(text, file), path, clean.get("value"), key)
        on_line = _on_line(text, path, clean.get("value"))
        text = on_line if on_line is not None and _same(on_line, data) else dump(data)
    return text


def _data(text: str, file: str) -> dict[str, Any]:
    return load(text, file)[0]


def _same(text: str, data: dict[str, Any]) -> bool:
    try:
        return load(text, "")[0] == data
    except ProfileError:
        return False


def _on_line(text: str, path: Path_, value: Any) -> str | None:
    """The text with one line changed, added or taken away; None where no line is the place."""
    lines = text.splitlines()
    end = None
    for number, at, match in _keys(lines):
        if at == path:
            head, rest = match[1], match[3]
            spent = _value_end(rest)
            if spent is None:
                return None
            changed = [] if value is None else [head + word(value) + rest[spent:]]
            return "\n".join([*lines[:number], *changed, *lines[number + 1 :]]) + "\n"
        if at[: len(path) - 1] == path[:-1] and len(at) == len(path):
            end = number
    if value is None or not isinstance(path[-1], str) or isinstance(value, dict):
        return None
    line = f"{path[-1]} = {word(value)}"
    if end is not None and _value_end(_LINE.match(lines[end])[3]) is not None:  # type: ignore[index]
        return "\n".join([*lines[: end + 1], line, *lines[end + 1 :]]) + "\n"
    if len(path) == 2:
        return "\n".join([*lines, "", f"[{path[0]}]", line]) + "\n"
    return None


def _keys(lines: list[str]) -> Iterator[tuple[int, Path_, re.Match[str]]]:
    """Number, path and match of every line that gives a key its value."""
    table: Path_ = ()
    counts: Counter[Path_] = Counter()
    for number, line in enumerate(lines):
        if header := _HEADER.match(line):
            names: Path_ = tuple(part.strip() for part in header[2].split("."))
            table = names
            if header[1] == "[[":
                table = (*names, counts[names])
                counts[names] += 1
        elif match := _LINE.match(line):
            yield number, (*table, *(part.strip() for part in match[2].split("."))), match


def _value_end(rest: str) -> int | None:
    """Where a value ends on its line: before blanks and a comment; None where it goes on below."""
    places = [match.start() for match in re.finditer("#", rest)] + [len(rest)]
    for place in places:
        value = rest[:place].rstrip()
        try:
            tomllib.loads(f"value = {value}")
        except (tomllib.TOMLDecodeError, RecursionError):
            continue
        return len(value)
    return None
