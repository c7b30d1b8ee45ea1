"""`camgeom run`, `build`, `check`, `solve`, `report`: read a profile, compute what is asked, write and print it."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Iterable
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from camgeom.checks.verdict import RANK, life_shown
from camgeom.cli import Console, UsageError
from camgeom.cli.tables import aligned, formats, number, number_in
from camgeom.errors import ExportError, Problem, ProfileError
from camgeom.profile.sections import TOLERANCE_RANGE

if TYPE_CHECKING:
    from camgeom.checks.verdict import Finding
    from camgeom.report.result import Result

QUIET_FOR = 1.0
"""s; progress is shown on a terminal after this"""
CROWNED = {
    "straight": "straight, as a cylinder grinds it; the crown meets it in a point",
    "conforming": "conforming, the envelope of the crown: a tool of the same meridian cuts it",
}
"""what `flank.crown` says, in words"""
USUAL = {"3mf", "stl", "step", "ply", "dxf", "outline.csv", "cutter.csv", "gcode", "apt", "rest.vtu", "png", "pdf"}
"""formats that are known without importing the writers"""
KEY_FIGURES: dict[str, tuple[tuple[str, str, str], ...]] = {
    "blank": (
        ("diameter_mm", "largest diameter", "mm"),
        ("length_mm", "length along the axis", "mm"),
    ),
    "flank": (
        ("max_pressure_angle_deg", "largest pressure angle", "deg"),
        ("min_relative_radius_mm", "smallest relative radius", "mm"),
        ("undercut_margin", "undercut margin", ""),
    ),
    "solid": (
        ("volume_mm3", "volume", "mm3"),
        ("mass_kg", "mass", "kg"),
        ("triangles", "triangles", ""),
        ("chord_error_mm", "chord error", "mm"),
    ),
    "contact": (
        ("peak_pressure_mpa", "peak contact pressure", "MPa"),
        ("peak_slice_pressure_mpa", "peak at the hardest place", "MPa"),
        ("inside_pressure_mpa", "0.5 mm inside the sharp end (no peak)", "MPa"),
        ("load_centre_mm", "load acts along the roller at", "mm"),
        ("contact_length_mm", "length that touches there", "mm"),
        ("peak_force_n", "peak contact force", "N"),
        ("least_force_n", "least contact force", "N"),
        ("peak_torque_n_m", "peak camshaft torque", "N m"),
        ("mean_torque_n_m", "mean camshaft torque", "N m"),
    ),
    "fatigue": (
        ("roller_life_h", "roller life, quoted place", "h"),
        ("roller_slice_life_h", "roller life, hardest place", "h"),
        ("face_life_h", "face life", "h"),
        ("cam_life_h", "cam life", "h"),
        ("cam_slice_life_h", "cam life, hardest place", "h"),
        ("bearing_life_h", "bearing life", "h"),
        ("bearing_rated_life_h", "bearing life, rated", "h"),
        ("bearing_life_factor", "life factor a_ISO of the bearing", ""),
        ("bearing_static_safety", "static safety of the bearing", ""),
        ("film_ratio", "least film over roughness, lambda", ""),
        ("film_thickness_um", "least film", "um"),
        ("friction_power_w", "heat of sliding", "W"),
        ("cam_wear_um_per_1000h", "wear of the cam in 1000 h", "um"),
        ("roller_wear_um_per_1000h", "wear of the roller in 1000 h", "um"),
        ("face_wear_um_per_1000h", "wear of the face in 1000 h", "um"),
    ),
    "body": (
        ("nominal_stress_mpa", "nominal stress at the root", "MPa"),
        ("nominal_at_deg", "at", "deg"),
        ("peak_stress_mpa", "peak stress at the root", "MPa"),
        ("load_angle_deg", "under the load at", "deg"),
        ("fatigue_factor", "bending limit over peak stress", ""),
    ),
    "dynamics": (
        ("first_frequency_hz", "lowest natural frequency", "Hz"),
        ("frequencies_hz.0", "lowest natural frequency", "Hz"),
        ("first_critical_speed_rpm", "first critical speed", "r/min"),
        ("speed_class", "class of the speed", ""),
        ("peak_load_acceleration_rad_s2", "peak load acceleration", "rad/s2"),
        ("peak_acceleration_m_s2", "peak acceleration, elastic", "m/s2"),
        ("peak_acceleration_rad_s2", "peak acceleration, elastic", "rad/s2"),
        ("amplification", "over the rigid one", ""),
        ("peak_contact_torque_n_m", "peak contact torque, elastic", "N m"),
        ("peak_input_torque_n_m", "peak input torque, elastic", "N m"),
        ("input_power_w", "mean input power", "W"),
        ("peak_contact_force_n", "peak contact force, elastic", "N"),
        ("peak_contact_force_n_m", "peak contact torque, elastic", "N m"),
        ("least_contact_force_n", "least contact force, elastic", "N"),
        ("least_contact_force_n_m", "least contact torque, elastic", "N m"),
        ("required_preload_n", "preload that just keeps contact", "N"),
        ("required_preload_n_m", "preload that just keeps contact", "N m"),
        ("residual_deviation_deg", "largest deviation in the dwell", "deg"),
        ("residual_vibration_m", "largest vibration in the dwell", "m"),
        ("residual_vibration_rad", "largest vibration in the dwell", "rad"),
        ("settling_time_s", "settled in the dwell after", "s"),
        ("duty.peak_pressure_mpa", "peak contact pressure, elastic", "MPa"),
        ("duty.roller_life_h", "roller life, elastic", "h"),
        ("duty.cam_life_h", "cam life, elastic", "h"),
        ("duty.face_life_h", "face life, elastic", "h"),
        ("duty.bearing_life_h", "bearing life, elastic", "h"),
        ("duty.bearing_static_safety", "static safety of the bearing, elastic", ""),
        ("camshaft_torque_n_m", "peak camshaft torque, elastic", "N m"),
        ("output_torque_n_m", "peak torque of the output shaft", "N m"),
        ("start_duty.peak_pressure_mpa", "peak contact pressure, from rest", "MPa"),
        ("start_duty.bearing_static_safety", "static safety of the bearing, from rest", ""),
        ("start_camshaft_torque_n_m", "peak camshaft torque, from rest", "N m"),
        ("impact.over_turns.peak_acceleration_m_s2.largest", "peak acceleration with impacts", "m/s2"),
        ("impact.over_turns.peak_acceleration_rad_s2.largest", "peak acceleration with impacts", "rad/s2"),
        ("impact.over_turns.amplification", "mean of the turns over the ideal one", ""),
        ("impact.worst_pressure_mpa", "peak pressure of impacts", "MPa"),
        ("impact.over_turns.peak_force_main_n.largest", "peak force of impacts, main side", "N"),
        ("impact.over_turns.peak_force_return_n.largest", "peak force of impacts, return side", "N"),
        ("impact.over_turns.approach_speed_m_s.largest", "largest approach speed", "m/s"),
        ("impact.over_turns.impacts_per_turn.mean", "impacts in a turn", ""),
        ("impact.duty.peak_torque_n_m", "peak camshaft torque with impacts", "N m"),
        ("impact.duty.roller_life_h", "roller life with impacts", "h"),
        ("impact.duty.face_life_h", "face life with impacts", "h"),
        ("impact.duty.cam_life_h", "cam life with impacts", "h"),
        ("impact.duty.bearing_life_h", "bearing life with impacts", "h"),
        ("impact.duty.bearing_static_safety", "static safety of the bearing with impacts", ""),
        ("impact.sensitivity.reproducible_turns", "turns that can be reproduced", ""),
        ("impact.sensitivity.turns", "of turns solved", ""),
    ),
    "cutter": (
        ("least_rest_mm", "least stock left by the tool", "mm"),
        ("most_rest_mm", "most stock left by the tool", "mm"),
        ("scallop_mm", "ridges between its rows", "mm"),
        ("cutting_time_min", "time at the feeds", "min"),
    ),
    "tolerance": (
        ("dwell_arcsec", "error in the dwells, at the wanted yield", "arcsec"),
        ("dwell_um", "error in the dwells, at the wanted yield", "um"),
        ("motion_arcsec", "error over the turn, at the wanted yield", "arcsec"),
        ("motion_um", "error over the turn, at the wanted yield", "um"),
        ("backlash_arcsec", "play in the dwells, at the wanted yield", "arcsec"),
        ("backlash_um", "play in the dwells, at the wanted yield", "um"),
        ("yield", "machines that keep every limit", ""),
    ),
}
"""Figures worth a line: section, key (dotted within it), words, unit."""


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Carry out one of the commands on a model; returns the exit status."""
    from camgeom.model import Model
    from camgeom.profile import read
    from camgeom.report.delivery import RESULT, Order, deliver
    from camgeom.report.result import chosen

    if arguments.formats == "list":
        return formats(arguments, console)
    tolerance = number_in(arguments.tolerance, "--tolerance", "mm", *TOLERANCE_RANGE)
    only = names(arguments.only, "--only")
    sections = _sections(only) if arguments.command == "report" and only else None
    products, checks = (_shown(sections), None) if sections else chosen(arguments.command, only)
    refuse_nameless(arguments.out)
    profile = read(arguments.profile)
    wanted = _formats(arguments, profile.output.formats, products, only)
    order = Order(
        arguments.command, products, checks, wanted, sections, slug(profile.name), explained=arguments.explain
    )
    model = Model(profile, tolerance, progress(console))
    # A command that only judges or solves leaves no trace unless a folder is named.
    writes = arguments.out is not None or bool({"exports", "report"} & set(products))
    if writes:
        from camgeom.export.folder import RunFolder

        folder = output_folder(arguments.out, profile.name)
        refuse_unwritable(folder)
        with RunFolder(folder) as place:
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
        console.out(json.dumps(result.data, indent=2, allow_nan=False))
        return
    for line in summary(result, files):
        console.out(line)
    for line in result.data.get("explain", ()):
        console.out(line)


def progress(console: Console) -> ProgressObserver | None:
    """An observer of computed facts that shows the one under way; None where nobody looks."""
    return ProgressObserver(console) if console.lively else None


class ProgressObserver:
    """Shows the fact that is being computed, once a command takes longer than QUIET_FOR."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._began = perf_counter()

    def __call__(self, event: str, name: str, seconds: float) -> None:
        """Called by the model at the start and the end of every fact."""
        elapsed = perf_counter() - self._began
        if elapsed > QUIET_FOR:
            done = f"done in {seconds:.1f} s" if event == "done" else "..."
            self._console.progress(f"{elapsed:6.1f} s  {name.replace('_', ' ')} {done}")


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
                    raise ExportError("nothing is written here; build and run write files")
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
        there = next(place for place in (folder, *folder.absolute().parents) if place.exists())
        problem = "is a file, not a folder" if not there.is_dir() else ""
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
    told = [
        (words, _at(data.get(section, {}), key), unit)
        for section, entries in KEY_FIGURES.items()
        for key, words, unit in entries
    ]
    figures = [
        (words, value if isinstance(value, str) else _figure(value, unit))
        for words, value, unit in told
        if isinstance(value, str | int | float)
    ]
    lines += [f"  {line}" for line in aligned([(w, v) for w, v in _motion_figures(data) + figures])]
    if crown := data.get("flank", {}).get("crown"):
        lines.append(f"  flank under the crowned roller: {CROWNED[crown]}")
    return lines + [f"  wrote {file}" for file in files]


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
    shown = life_shown(value) if unit == "h" else value
    return shown if isinstance(shown, str) else f"{number(shown)} {unit}".rstrip()


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
            number(finding.shown),
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
        figures.append((f"motion[{i}] optimal", f"{told} (unit lift over unit travel)"))
    return figures
