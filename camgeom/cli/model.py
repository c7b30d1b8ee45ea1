"""`camgeom run`, `build`, `check`, `solve`, `report`: read a profile, compute what is asked, write and print it."""

from __future__ import annotations

import argparse
import os
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from camgeom.checks.verdict import RANK, life_told
from camgeom.cli import Console, UsageError, aligned, number, number_in
from camgeom.errors import ExportError, Problem, ProfileError
from camgeom.profile.sections import TOLERANCE_RANGE
from camgeom.report.figures import KEY_FIGURES
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.checks.verdict import Finding
    from camgeom.report.result import Result

QUIET_FOR = 1.0
"""s; progress is shown on a terminal after this"""
SELDOM = 10.0
"""s, from one line of progress to the next where nobody looks at a terminal"""
BODIES = {"solid", "exports", "report"}
"""products that show or write bodies: where none is asked for, what is judged by is meshed the quicker way"""
CROWNED = {
    "straight": "straight, as a cylinder grinds it; the crown meets it in a point",
    "conforming": "conforming, the envelope of the crown: a tool of the same meridian cuts it",
}
"""what `flank.crown` says, in words"""
USUAL = {"3mf", "stl", "step", "ply", "dxf", "outline.csv", "cutter.csv", "gcode", "apt", "rest.vtu", "png", "pdf"}
"""formats that are known without importing the writers"""


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Carry out one of the commands on a model; returns the exit status."""
    from camgeom.model import Model
    from camgeom.profile import read
    from camgeom.report.delivery import RESULT, Order, deliver
    from camgeom.report.result import chosen

    if arguments.formats == "list":
        from camgeom.cli.tables import formats

        return formats(arguments, console)
    tolerance = number_in(arguments.tolerance, "--tolerance", "mm", *TOLERANCE_RANGE)
    only = names(arguments.only, "--only")
    sections = _sections(only) if arguments.command == "report" and only else None
    products, checks = (_shown(sections), None) if sections else chosen(arguments.command, only)
    refuse_nameless(arguments.out)
    profile = read(arguments.profile)
    wanted = _formats(arguments, profile.output.formats, products, only)
    if profile.output.fewest_triangles is None and not BODIES & set(products):
        output = profile.output.model_copy(update={"fewest_triangles": False})
        profile = profile.model_copy(update={"output": output})
    order = Order(
        arguments.command, products, checks, wanted, sections, slug(profile.name), explained=arguments.explain
    )
    model = Model(profile, tolerance, ProgressObserver(console))
    # A command that only judges or solves leaves no trace unless a folder is named.
    writes = arguments.out is not None or bool({"exports", "report"} & set(products))
    if writes:
        from camgeom.export.folder import RunFolder

        folder = output_folder(arguments.out, profile.name)
        refuse_unwritable(folder)
        with RunFolder(folder, say=console.told) as place:
            result = deliver(model, order, place, lambda text: console.err(f"camgeom: {text}"))
        files = [*result.data["files"], str(folder / RESULT)]
    else:
        result, files = deliver(model, order, None, console.err), []
    console.progress("")
    _print(result, arguments, console, files)
    return result.exit_status


def _print(result: Result, arguments: argparse.Namespace, console: Console, files: list[str]) -> None:
    for names_, reason in _unmade(result, told=False):
        console.err(f"camgeom: no {' or '.join(names_)}: {reason}")
    if arguments.json:
        import json

        console.out(json.dumps(result.data, indent=2, allow_nan=False))
        return
    for line in summary(result, files):
        console.out(line)
    for line in result.data.get("explain", ()):
        console.out(line)


class ProgressObserver:
    """Shows the fact, file or picture under way: on a terminal once a command takes longer than QUIET_FOR, in a pipe
    or a file one line every SELDOM."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._began = perf_counter()
        self._told = 0.0

    def __call__(self, event: str, name: str, seconds: float) -> None:
        """Called by the model at the start and the end of every fact."""
        elapsed = perf_counter() - self._began
        done = f"done in {seconds:.1f} s" if event == "done" else "..."
        line = f"{elapsed:6.1f} s  {name.replace('_', ' ')} {done}"
        if not self._console.lively and elapsed - self._told >= SELDOM:
            self._told = elapsed
            self._console.err(f"camgeom: {line}")
        elif elapsed > QUIET_FOR:
            self._console.progress(line)


def names(text: str | None, option: str) -> tuple[str, ...] | None:
    """The names in a comma-separated option. Raises UsageError where it is empty."""
    if text is None:
        return None
    found = tuple(word.strip() for word in text.split(",") if word.strip())
    if not found:
        raise UsageError(f"{option}: needs at least one name")
    return found


def _formats(
    arguments: argparse.Namespace, profiled: tuple[str, ...], products: tuple[str, ...], only: tuple[str, ...] | None
) -> tuple[str, ...]:
    """The formats asked for, each known to a writer. Raises ProfileError naming all that are not.

    A command that exports nothing but reports brings pictures and pages along where --formats names them; one that
    judges a profile asks whether its cam may have the profile's.
    """
    given = names(arguments.formats, "--formats")
    exporting = "exports" in products
    # A profile's formats are read by every command: what passes a check can be run.
    wanted = profiled if given is None else given
    if given is None and not exporting and set(wanted) <= USUAL:
        return ()
    from camgeom.report.files import EXTRAS, format_of

    problems = []
    for i, name in enumerate(wanted):
        plain = name.lower().lstrip(".")
        if plain in EXTRAS and (given is None or exporting or "report" in products):
            continue
        try:
            if given is not None and not exporting:
                if "report" not in products:
                    raise ExportError(f"nothing is written here; {_writing(arguments.command)}")
                raise ExportError(f"a report brings along {', '.join(EXTRAS)}; the others come from build and run")
            format_of(name.lower())
        except ExportError as error:
            key = f"output.formats[{i}]" if given is None else "--formats"
            told = f"unknown format ({error})" if exporting or given is None else str(error)
            problems.append(Problem(key, told, name))
    if problems:
        raise ProfileError(problems, arguments.profile if given is None else "")
    if not exporting and given is None and not (arguments.command == "check" and only is None):
        return ()
    return tuple(dict.fromkeys(name.lower().lstrip(".") for name in wanted))


def _writing(command: str) -> str:
    """What would write files, where a command writes none."""
    from camgeom.report.result import COMMANDS

    return "--only leaves out exports" if "exports" in COMMANDS[command] else "build and run write files"


def slug(name: str) -> str:
    """A name as a safe folder or file name: lower-case ASCII letters, digits and hyphens, at most 80.

    Where letters without an ASCII form are lost, or the end is cut off, a digest keeps the name apart from others.
    """
    import re
    import unicodedata

    apart = unicodedata.normalize("NFKD", name)
    plain = apart.encode("ascii", "ignore").decode().lower()
    word = re.sub(r"[^a-z0-9]+", "-", plain).strip("-")
    if len(word) > 80 or any(letter.isalnum() and not letter.isascii() for letter in apart):
        from hashlib import sha256

        word = f"{word[:71].rstrip('-') or 'cam'}-{sha256(name.encode()).hexdigest()[:8]}"
    # Names of devices on Windows are no file names there.
    reserved = re.fullmatch(r"con|prn|aux|nul|com\d|lpt\d", word)
    return f"{word}-cam" if reserved else word or "cam"


def output_folder(given: str | None, name: str) -> Path:
    """The output folder: the one given, else exports/<name>."""
    return Path("exports") / slug(name) if given is None else Path(given)


def refuse_nameless(folder: str | None) -> None:
    """Raise UsageError for an --out that names no folder."""
    if folder is not None and (not folder.strip() or "\x00" in folder):
        raise UsageError("--out: needs the name of a folder")


def refuse_unwritable(folder: Path) -> None:
    """Raise ExportError before anything is computed where the folder cannot be made or written in."""
    try:
        there = next(place for place in (folder, *folder.absolute().parents) if os.path.lexists(place))
        problem = "is a file, not a folder" if not there.is_dir() else ""
        problem = problem if there.exists() else "is a link that leads nowhere"
        problem = problem or ("" if os.access(there, os.W_OK | os.X_OK) else "may not be written in (no permission)")
    except OSError as error:
        there, problem = folder, error.strerror or str(error)
    if problem:
        raise ExportError(f"{there}: {problem}; choose another folder with --out")


def _sections(only: tuple[str, ...]) -> tuple[str, ...]:
    """The sections of a report that holds nothing else. Raises ProfileError for an unknown one."""
    from camgeom.report.sections import chosen

    return chosen(only)


def _shown(sections: tuple[str, ...]) -> tuple[str, ...]:
    """Products of a report of some sections: the page computes what it shows, and only the checks are judged too."""
    return ("checks", "report") if "checks" in sections else ("report",)


def summary(result: Result, files: Iterable[str]) -> list[str]:
    """All lines for one result."""
    data = result.data
    lines = [f"{data['name']} ({data['kind']}): {_verdict(result)}"]
    lines += [f"  units: {data['units']}"] if "units" in data else []
    lines += _findings(result.findings)
    lines += [f"  {result.verdict.loads.sentence}"] if result.verdict.loads is not None else []
    lines += [f"  not judged: {word.check}: {word.reason}" for word in result.verdict.not_judged]
    lines += [f"  no {' or '.join(names_)}: {reason}" for names_, reason in _unmade(result, told=True)]
    lines += [f"  {line}" for line in aligned(_figures(data))]
    crowns = [one.get("flank", {}).get("crown") for one in (data, *data.get("followers", ()))]
    lines += [f"  flank under the crowned roller: {CROWNED[crown]}" for crown in dict.fromkeys(filter(None, crowns))]
    return lines + [f"  wrote {file}" for file in files]


def _figures(data: dict[str, Any]) -> list[tuple[str, str]]:
    """Every figure worth a line, in words; what is each follower's own with its number."""
    from camgeom.report.result import own_sections

    others = data.get("followers", [])
    own = own_sections(others)
    rows = _rows(data, {"motion", *KEY_FIGURES} - own)
    for follower, one in enumerate((data, *others), start=1):
        rows += [(f"{words}, follower {follower}", value) for words, value in _rows(one, own)]
    return rows


def _rows(data: dict[str, Any], sections: Collection[str]) -> list[tuple[str, str]]:
    """Words and value of the figures of some sections."""
    told = [
        (words, _at(data.get(section, {}), key), unit)
        for section, entries in KEY_FIGURES.items()
        if section in sections
        for key, words, unit in entries
    ]
    figures = [
        (words, value if isinstance(value, str) else _figure(value, unit))
        for words, value, unit in told
        if isinstance(value, str | int | float)
    ]
    return (_motion_figures(data) if "motion" in sections else []) + figures


def _unmade(result: Result, told: bool) -> list[tuple[list[str], str]]:
    """Products that could not be made, by reason: of those that the summary tells, or of files alone.

    Sections of the report and pictures are told with what they belong to, checks among those not judged.
    """
    from camgeom.report.result import SOURCES

    grouped: dict[str, list[str]] = {}
    for product in result.products:
        if product.exit_status and not product.name.startswith(("checks", "report.", "png.")):
            grouped.setdefault(product.reason, []).append(product.name)
    groups = [(names_, reason) for reason, names_ in grouped.items()]
    return [group for group in groups if any(name in SOURCES for name in group[0]) == told]


def _at(data: Any, path: str) -> Any:
    """What stands at a dotted path of plain data; None where there is no such thing."""
    for name in path.split("."):
        if isinstance(data, list):
            data = data[int(name)] if name.isdecimal() and int(name) < len(data) else None
        else:
            data = data.get(name) if isinstance(data, dict) else None
    return data


def _figure(value: float, unit: str) -> str:
    """A figure with its unit; a life that no machine lives to see is unlimited."""
    return life_told(value) if unit == "h" else f"{number(value)} {unit}".rstrip()


def _verdict(result: Result) -> str:
    if result.findings:
        return result.verdict.sentence
    return "done" if all(p.status == "made" for p in result.products if p.name == "solid") else "no solid"


def _findings(findings: Iterable[Finding]) -> list[str]:
    """One aligned line a finding, the failed ones first; the advice below each that does not pass."""
    ordered = sorted(findings, key=lambda finding: -RANK[finding.level])
    rows = [
        (
            finding.level.upper(),
            finding.check,
            number(finding.shown, 7 if finding.unit == "h" else 6),
            "" if finding.shown == "unlimited" else finding.unit,
            "" if finding.limit is None else f"{finding.comparison} {number(finding.limit)}",
            finding.room,
            "" if finding.cam_angle_deg is None else f"at {finding.cam_angle_deg:.2f} deg",
            finding.place,
        )
        for finding in ordered
    ]
    lines = []
    given: set[str] = set()
    for finding, line in zip(ordered, aligned(rows, right=(2, 5))):
        lines.append(f"  {line}")
        if finding.advice and finding.advice not in given:
            lines.append(f"        {finding.advice}")
            given.add(finding.advice)
    return lines


def _motion_figures(data: dict[str, Any]) -> list[tuple[str, str]]:
    """Peak velocity and acceleration in time where a speed is known, else over cam angle."""
    motion = data.get("motion", {})
    figures = []
    for word in ("velocity", "acceleration"):
        keys = [key for key in motion if key.startswith(f"peak_{word}_") and not key.endswith("_at_deg")]
        timed = [key for key in keys if "_per_s" in key] or keys
        if timed:
            unit = timed[0].removeprefix(f"peak_{word}_").replace("_per_", "/")
            figures.append((f"peak {word}", f"{number(motion[timed[0]])} {unit}"))
    for i, found in motion.get("best_laws", {}).items():
        told = f"{found['minimise']} {number(found['value'])}, no law below {number(found['lower_bound'])}"
        figures.append((f"motion[{i}] optimal", f"{told} ({found['over']})"))
    return figures


def write_set(
    folder: Path,
    manifest: str,
    name: str,
    command: str,
    contents: Mapping[str, str | bytes],
    console: Console,
    product: str | None = None,
) -> list[Path]:
    """The files of a command that has no others in a folder, by name with their contents; where they are.

    name     of the design, or of what it is about
    product  that they are of, in the manifest; None: as the command is called
    Raises ExportError where one cannot be written.
    """
    from camgeom.export.files import write_whole
    from camgeom.export.folder import results

    about = {"name": name, "stem": slug(name), "command": command, "version": __version__}
    with results(folder, manifest, console.told) as place:
        for file, content in contents.items():
            write_whole(place.path(file), content)
        place.close(about, "", dict.fromkeys(contents, product or command), {product or command})
    return [folder / file for file in contents]
