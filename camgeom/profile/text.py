"""Reading a profile's text safely: TOML syntax and structure, each refused with one plain message.

Nothing here knows a cam word. `load` gives plain data (tables as dict, arrays as tuple) whose numbers are finite and of
sane size, whose strings are printable and whose depth and number of entries are bounded, so that what follows cannot be
flooded by a hostile file.
"""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import date, time
from pathlib import Path
from typing import Any

import numpy as np

from camgeom.errors import UNSEEN, Problem, ProfileError
from camgeom.reading import lines_of, os_reason, read_bytes, refuse

MAX_BYTES = 1_000_000
"""B; a profile of 3 000 segments and tables is half of that"""
MAX_TABLE_BYTES = 10_000_000
"""B; a measured table beside the profile"""
MAX_DEPTH = 12
MAX_ENTRIES = 200_000
MAX_TEXT = 20_000
"""characters in one string"""
MAX_KEY_PARTS = 32
"""parts of a dotted key; the TOML reader's work grows with its square"""
MAX_WHOLE = 2**63
MAX_TABLE_ROWS = 200_000
MOST_BAD_VALUES = 100

_NOT_IN_KEY = re.compile(r"[\n=,\[{#]")
_QUOTED_PART = re.compile(r"[\"'][ \t]*\.")

Path_ = tuple[str | int, ...]


def dotted(path: Path_) -> str:
    """A key path as it is written in messages: motion[3].until (the first entry of an array is 0)."""
    text = ""
    for part in path:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            shown = part if len(part) <= 60 else part[:59] + "…"
            shown = shown if re.fullmatch(r"[A-Za-z0-9_…-]+", shown) else repr(shown)
            text += f".{shown}" if text else shown
    return text or "profile"


def load(text: str, file: str) -> tuple[dict[str, Any], list[Problem], set[Path_]]:
    """TOML text as plain data, the problems of single values, and the paths of the values left out for them.

    Raises ProfileError at once where nothing can be read: syntax (with its line), nesting, number of entries.
    """
    if len(text) > MAX_BYTES:
        raise refuse("the text is too long", file, value=len(text), allowed=f"at most {MAX_BYTES} characters")
    _refuse_long_keys(text, file)
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        from camgeom.profile.syntax import line_hint

        hint = line_hint(text, str(error))
        raise ProfileError([Problem("TOML syntax", _first_lower(str(error)), hint=hint)], file) from None
    except RecursionError:
        raise refuse("arrays or tables are nested too deeply", file, allowed=f"at most {MAX_DEPTH} levels") from None
    except ValueError as error:
        # int() refuses numbers of more than a few thousand digits, dates may be impossible ones.
        reason = "a whole number has too many digits" if "digits" in str(error) else str(error)
        raise refuse(reason, file, key="TOML value") from None
    return cleaned(data, file)


def cleaned(data: dict[str, Any], file: str = "") -> tuple[dict[str, Any], list[Problem], set[Path_]]:
    """Plain data of a program (tables as dict, arrays as list or tuple) under the bounds of a text's; see `load`."""
    cleaner = _Cleaner(file)
    return cleaner.table(data, ()), cleaner.problems, cleaner.dropped


def _first_lower(text: str) -> str:
    return text[:1].lower() + text[1:]


def _refuse_long_keys(text: str, file: str) -> None:
    run = 0
    for part in text.split("."):
        run = run + 1 if part and not part.isspace() and not _NOT_IN_KEY.search(part) else 0
        if run > MAX_KEY_PARTS:
            raise refuse("a dotted key has too many parts", file, allowed=f"at most {MAX_KEY_PARTS}")
    if sum(1 for _ in _QUOTED_PART.finditer(text)) > 10 * MAX_KEY_PARTS:
        raise refuse("there are too many quoted dotted keys", file, allowed=f"at most {10 * MAX_KEY_PARTS}")


def text_fault(text: str) -> str:
    """What is wrong with a text, too long or not printable; empty where nothing is."""
    if len(text) > MAX_TEXT:
        return f"the text is too long ({len(text)} characters; allowed: at most {MAX_TEXT})"
    return "the text holds control characters" if UNSEEN.search(text) else ""


@dataclass
class _Cleaner:
    """Walks parsed TOML: bounds its depth and size, drops values that are no number, text, flag, array or table."""

    file: str
    problems: list[Problem] = field(default_factory=list)
    dropped: set[Path_] = field(default_factory=set)
    entries: int = 0

    def table(self, data: dict[str, Any], path: Path_) -> dict[str, Any]:
        self._count(path, len(data))
        if strange := [key for key in data if not isinstance(key, str)]:
            raise refuse("a key must be a text", self.file, key=dotted(path), value=strange[0])
        pairs = ((key, self.value(value, (*path, key))) for key, value in data.items())
        return {key: value for key, value in pairs if value is not None}

    def value(self, value: Any, path: Path_) -> Any:
        if isinstance(value, dict):
            return self.table(value, path)
        if isinstance(value, list | tuple):
            self._count(path, len(value))
            return tuple(self.value(item, (*path, i)) for i, item in enumerate(value))
        if isinstance(value, np.generic | np.ndarray):
            return self.value(value.tolist(), path)
        if isinstance(value, bool):
            return value
        if isinstance(value, int):
            reason = "" if abs(value) <= MAX_WHOLE else "the whole number is too large"
        elif isinstance(value, float):
            reason = "" if math.isfinite(value) else f"must be a finite number (found {value})"
        elif isinstance(value, str):
            reason = text_fault(value)
        elif isinstance(value, date | time):
            reason = f"a date or time has no place in a profile (found {value})"
        else:
            reason = f"a {type(value).__name__} has no place in a profile"
        if not reason:
            return value
        if len(self.problems) < MOST_BAD_VALUES:
            self.problems.append(Problem(dotted(path), reason))
        self.dropped.add(path)
        return None

    def _count(self, path: Path_, more: int) -> None:
        self.entries += more
        if len(path) > MAX_DEPTH:
            raise refuse("arrays or tables are nested too deeply", self.file, allowed=f"at most {MAX_DEPTH} levels")
        if self.entries > MAX_ENTRIES:
            raise refuse("the profile has too many entries", self.file, allowed=f"at most {MAX_ENTRIES}")


def key_path(key: str) -> Path_ | None:
    """The path that a dotted key of a program or a command names: `motion[3].until`; None where it is no such key."""
    if not re.fullmatch(r"[\w-]+(\[\d{1,5}\])?(\.[\w-]+(\[\d{1,5}\])?)*", key):
        return None
    path: list[str | int] = []
    for part in key.split("."):
        name, _, index = part.partition("[")
        path += [name, int(index[:-1])] if index else [name]
    return tuple(path)


def replaced(data: Any, path: Path_, value: Any, shown: str) -> Any:
    """The data with the value at a path replaced, or added to a table; None takes the key away.

    Raises ProfileError, which names what is `shown`, where the path breaks.
    """
    if not path:
        return value
    head, rest = path[0], path[1:]
    if isinstance(head, int):
        if not isinstance(data, tuple) or head >= len(data):
            allowed = f"0 to {len(data) - 1}" if isinstance(data, tuple) and data else "no array there"
            raise ProfileError([Problem(shown, "no such entry", head, allowed)])
        return tuple(replaced(item, rest, value, shown) if i == head else item for i, item in enumerate(data))
    if not isinstance(data, dict):
        hint = f"write {shown.split()[-1].partition('.')[0]}[0] for the first entry" if isinstance(data, tuple) else ""
        raise ProfileError([Problem(shown, f"there is no table that could hold {head!r}", hint=hint)])
    if value is None and not rest:
        return {key: item for key, item in data.items() if key != head}
    return {**data, head: replaced(data.get(head, {}), rest, value, shown)}


def beside(name: str, folder: Path | None, key: str) -> Path | Problem:
    """The path of a data file named in a profile: relative to the profile's folder and inside it, links followed."""
    allowed = "a file in the profile's folder or below it, as a relative path"
    if folder is None:
        return Problem(key, "a data file needs a profile that is read from a file", name, allowed)
    parts = re.split(r"[\\/]", name)
    if not name or name.startswith(("/", "\\", "~")) or ":" in name or ".." in parts or "\x00" in name:
        return Problem(key, "may not leave the profile's folder", name, allowed)
    try:
        home, target = folder.resolve(strict=True), (folder / name).resolve(strict=True)
    except (OSError, RuntimeError, ValueError) as error:
        reason = os_reason(error) if isinstance(error, OSError) else "is a loop of links"
        return Problem(key, reason, name, allowed)
    if not target.is_relative_to(home):
        return Problem(key, "may not leave the profile's folder (a link leads out of it)", name, allowed)
    return target if target.is_file() else Problem(key, "is not a regular file", name, allowed)


def number_table(path: Path, columns: int, key: str, shown: str) -> tuple[tuple[float, ...], ...] | Problem:
    """Rows of a CSV file (comma, semicolon or blank between numbers, # comments, one optional heading line)."""
    try:
        lines = list(lines_of(read_bytes(path, MAX_TABLE_BYTES, "", key), "", key))
    except ProfileError as error:
        return error.problems[0]
    rows: list[tuple[float, ...]] = []
    heading_allowed = True
    for line_number, line in enumerate(lines, 1):
        stripped = line.split("#", 1)[0].strip()
        if not stripped:
            continue
        row = _numbers(stripped)
        if row is None and heading_allowed:
            heading_allowed = False
            continue
        heading_allowed = False
        if row is None or len(row) != columns:
            return Problem(key, f"{shown} line {line_number}: needs {columns} finite numbers", stripped)
        rows.append(row)
        if len(rows) > MAX_TABLE_ROWS:
            return Problem(key, f"{shown} has too many rows", allowed=f"at most {MAX_TABLE_ROWS}")
    return tuple(rows)


def _numbers(line: str) -> tuple[float, ...] | None:
    try:
        row = tuple(float(word) for word in re.split(r"\s*[,;\t]\s*|\s+", line))
    except ValueError:
        return None
    return row if all(math.isfinite(x) for x in row) else None


def dump(data: dict[str, Any]) -> str:
    """Plain data as `load` gives it as TOML: values first, then tables, in their order."""
    return "\n".join(_lines(data, ())).strip() + "\n"


def _lines(table: dict[str, Any], path: tuple[str, ...]) -> Iterator[str]:
    tables = {key: value for key, value in table.items() if isinstance(value, dict) or _is_tables(value)}
    yield from (f"{_key(key)} = {word(value)}" for key, value in table.items() if key not in tables)
    for key, value in tables.items():
        name = ".".join(map(_key, (*path, key)))
        for one in value if isinstance(value, tuple) else (value,):
            yield f"\n[[{name}]]" if isinstance(value, tuple) else f"\n[{name}]"
            yield from _lines(one, (*path, key))


def _is_tables(value: Any) -> bool:
    return isinstance(value, tuple) and bool(value) and all(isinstance(item, dict) for item in value)


def _key(key: str) -> str:
    return key if re.fullmatch(r"[\w-]+", key, re.ASCII) else word(key)


def word(value: Any) -> str:
    """A value on one line; JSON's strings are TOML's, but for the deleting character."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {word(item)}" for key, item in value.items()) + " }"
    if isinstance(value, tuple):
        return "[" + ", ".join(map(word, value)) + "]"
    import json

    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
