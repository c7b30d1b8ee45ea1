"""Run every profile and hold its result to the expected numbers in profiles/expected/<name>.json.

An expected file maps a path in result.json to what must stand there:

    {"solid.volume_mm3": {"value": 1.2e6, "rel": 1e-6},       within a relative deviation
     "motion.backlash_mm": {"value": 0.0, "abs": 1e-9},       within an absolute one
     "contact.peak_pressure_mpa": {"max": 2450, "min": 100},  within bounds
     "solid.watertight": {"value": true},                     equal
     "checks.pressure-angle.passed": {"value": true},         in a list: by position, or by the entry's check or name
     "exit_status": {"value": 1}}                             of `camgeom run`; 0 unless stated

Every result is also held to `camgeom schema --result`. The exit status is 0 when all holds, else 1.
A profile without an expected file, or with an empty one, fails.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
LIMITS = {"value", "rel", "abs", "min", "max"}


@dataclass(frozen=True)
class Line:
    """One expected number and what was found; `problem` is empty where it holds."""

    profile: str
    path: str
    expected: str
    found: str
    problem: str


def look_up(result: Any, path: str) -> Any:
    """The value at a dotted path; KeyError, with the part that is missing, where there is none."""
    here = result
    for part in path.split("."):
        if isinstance(here, dict) and part in here:
            here = here[part]
        elif isinstance(here, list):
            entries = [entry for entry in here if isinstance(entry, dict)]
            named = [entry for entry in entries if part in (entry.get("check"), entry.get("name"))]
            if named:
                here = named[0]
            elif part.isdigit() and int(part) < len(here):
                here = here[int(part)]
            else:
                raise KeyError(part)
        else:
            raise KeyError(part)
    return here


def miss(found: Any, want: dict[str, Any]) -> str:
    """Why a value does not meet its expectation; empty where it does."""
    if not want or set(want) - LIMITS:
        return f"an expectation has some of {', '.join(sorted(LIMITS))}, not {', '.join(want) or 'nothing'}"
    is_number = isinstance(found, int | float) and not isinstance(found, bool)
    if not is_number:
        same = set(want) == {"value"} and type(found) is type(want["value"]) and found == want["value"]
        return "" if same else "differs"
    if not math.isfinite(found):
        return "not finite"
    if "min" in want and found < want["min"]:
        return f"below {want['min']:g}"
    if "max" in want and found > want["max"]:
        return f"above {want['max']:g}"
    if "value" not in want:
        return ""
    if isinstance(want["value"], str | bool) or want["value"] is None:
        return "differs"
    deviation = abs(found - want["value"])
    allowed = max(want.get("abs", 0.0), want.get("rel", 0.0) * abs(want["value"]))
    return "" if deviation <= allowed else f"off by {deviation:.3g}, allowed {allowed:.3g}"


def show(want: dict[str, Any]) -> str:
    """An expectation in a few characters."""
    value = [f"{want['value']}"] if "value" in want else []
    return " ".join(value + [f"{key} {want[key]:g}" for key in ("rel", "abs", "min", "max") if key in want])


def compare(profile: str, result: dict[str, Any], expected: dict[str, dict[str, Any]]) -> list[Line]:
    """Every expected number of one profile against its result."""
    lines = []
    for path, want in expected.items():
        try:
            found = look_up(result, path)
        except KeyError as missing:
            lines.append(Line(profile, path, show(want), "-", f"no {missing.args[0]!r} in the result"))
        else:
            text = f"{found:.9g}" if isinstance(found, float) else str(found)
            lines.append(Line(profile, path, show(want), text, miss(found, want)))
    return lines


JSON_TYPES: dict[str, tuple[type, ...]] = {
    "object": (dict,), "array": (list,), "string": (str,), "boolean": (bool,), "integer": (int,),
    "number": (int, float), "null": (type(None),),
}  # fmt: skip


def astray(value: Any, schema: dict[str, Any], whole: dict[str, Any], at: str = "result") -> Iterator[str]:
    """Where a value is not what a JSON Schema says; of the words that the schema of a result has."""
    if "$ref" in schema:
        yield from astray(value, whole["$defs"][schema["$ref"].rpartition("/")[2]], whole, at)
    if "const" in schema and value != schema["const"]:
        yield f"{at} is {value!r}, not {schema['const']!r}"
    if "enum" in schema and value not in schema["enum"]:
        yield f"{at} is {value!r}, none of {schema['enum']}"
    if "anyOf" in schema:
        tried = [list(astray(value, option, whole, at)) for option in schema["anyOf"]]
        if all(tried):
            yield min(tried, key=len)[0]
    names = schema.get("type", [])
    allowed = [kind for name in ([names] if isinstance(names, str) else names) for kind in JSON_TYPES[name]]
    if allowed and (not isinstance(value, tuple(allowed)) or (isinstance(value, bool) and bool not in allowed)):
        yield f"{at} is {value!r}, no {names}"
    elif isinstance(value, dict):
        yield from (f"{at} has no {key}" for key in schema.get("required", ()) if key not in value)
        for key, item in value.items():
            own = [schema["properties"][key]] if key in schema.get("properties", {}) else []
            own += [part for words, part in schema.get("patternProperties", {}).items() if re.search(words, key)]
            rest = schema.get("additionalProperties", {}) if not own else {}
            if rest is False:
                yield f"{at}.{key} is not described"
            for part in own or [rest or {}]:
                yield from astray(item, part, whole, f"{at}.{key}")
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from astray(item, schema.get("items", {}), whole, f"{at}[{i}]")


def described(name: str, result: dict[str, Any]) -> list[Line]:
    """Where a result is not what `camgeom schema --result` says."""
    from camgeom.report.result_schema import schema

    whole = schema()
    return [Line(name, "", "the schema of result.json", "-", problem) for problem in astray(result, whole, whole)]


def check(profile: Path) -> list[Line]:
    """Run one profile into a temporary folder and compare."""
    name = profile.stem
    file = profile.parent / "expected" / f"{name}.json"
    if not file.is_file():
        return [Line(name, "", "", "", f"{file.relative_to(ROOT)} is missing")]
    expected = json.loads(file.read_text(encoding="utf-8"))
    if not expected:
        return [Line(name, "", "", "", f"{file.relative_to(ROOT)} expects nothing")]
    with tempfile.TemporaryDirectory(prefix="camgeom-") as folder:
        command = [sys.executable, "-m", "camgeom", "run", str(profile), "--json", "--out", folder]
        run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    try:
        result = json.loads(run.stdout)
    except json.JSONDecodeError:
        reason = (run.stderr.strip().splitlines() or ["nothing on stderr"])[-1]
        return [Line(name, "", "", "", f"exit status {run.returncode} and no JSON on stdout: {reason}")]
    stated = {"exit_status": {"value": 0}, **expected}
    return described(name, result) + compare(name, {**result, "exit_status": run.returncode}, stated)


def main() -> int:
    """Print the table and the closing count; 0 when all holds."""
    parser = argparse.ArgumentParser(description="Hold every profile to its expected numbers.")
    parser.add_argument("profile", nargs="*", type=Path, help="profiles to run; all of profiles/ by default")
    chosen = [path.resolve() for path in parser.parse_args().profile] or sorted((ROOT / "profiles").glob("*.toml"))
    if not chosen:
        print("no profiles")
        return 0
    with ThreadPoolExecutor(max_workers=2) as pool:
        lines = [line for part in pool.map(check, chosen) for line in part]
    widths = [max(len(getattr(line, key)) for line in lines) for key in ("profile", "path", "expected", "found")]
    for line in lines:
        cells = [text.ljust(n) for text, n in zip((line.profile, line.path, line.expected, line.found), widths)]
        print("  ".join([*cells, line.problem and f"FAIL: {line.problem}"]).rstrip())
    failed = sum(bool(line.problem) for line in lines)
    print(f"{len(lines) - failed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
