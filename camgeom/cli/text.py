"""A result as a few lines of text for a terminal: the verdict first, then the findings, key figures and files."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camgeom.checks import Finding
    from camgeom.report.result import Result

KEY_FIGURES: dict[str, tuple[tuple[str, str, str], ...]] = {
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
        ("peak_slice_pressure_mpa", "peak over the slices", "MPa"),
        ("peak_force_n", "peak contact force", "N"),
    ),
    "fatigue": (("roller_life_h", "roller life", "h"), ("cam_life_h", "cam life", "h")),
    "cutter": (
        ("least_rest_mm", "least stock left by the tool", "mm"),
        ("most_rest_mm", "most stock left by the tool", "mm"),
        ("scallop_mm", "ridges between its rows", "mm"),
        ("cutting_time_min", "time at the feeds", "min"),
    ),
}
"""Figures worth a line: section, key, words, unit."""


def aligned(rows: Sequence[Sequence[str]], right: Iterable[int] = ()) -> list[str]:
    """Rows of cells as lines with aligned columns, two blanks between them; `right` columns are set right."""
    if not rows:
        return []
    set_right = set(right)
    widths = [max(len(row[c]) for row in rows) for c in range(len(rows[0]))]
    return [
        "  ".join(cell.rjust(w) if c in set_right else cell.ljust(w) for c, (cell, w) in enumerate(zip(row, widths)))
        .rstrip()
        for row in rows
    ]


def number(value: Any, digits: int = 6) -> str:
    """A number in a few significant digits; a dash where there is none."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return str(value)
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def summary(result: Result, files: Iterable[Path]) -> list[str]:
    """All lines for one result."""
    data = result.data
    lines = [f"{data['name']} ({data['kind']}): {_verdict(result)}"]
    lines += _findings(result.findings)
    if result.refused and all(result.refused != finding.advice for finding in result.findings):
        lines.append(f"  no solid: {result.refused}")
    for why in dict.fromkeys(why for _, why in result.unanswered):
        lines.append(f"  no {' or '.join(name for name, said in result.unanswered if said == why)}: {why}")
    figures = [
        (words, f"{number(data[section][key])} {unit}".rstrip())
        for section, entries in KEY_FIGURES.items()
        for key, words, unit in entries
        if data.get(section, {}).get(key) is not None
    ]
    lines += [f"  {line}" for line in aligned([(w, v) for w, v in _motion_figures(data) + figures])]
    return lines + [f"  wrote {file}" for file in files]


def _verdict(result: Result) -> str:
    failed = sum(not finding.passed for finding in result.findings)
    if result.findings:
        total = len(result.findings)
        return f"FAIL, {failed} of {total} findings" if failed else f"PASS, {total} findings"
    return "no solid" if result.refused else "done"


def _findings(findings: Iterable[Finding]) -> list[str]:
    """One aligned line a finding, the failed ones first; the advice below each failed one."""
    ordered = sorted(findings, key=lambda finding: finding.passed)
    rows = [
        (
            "PASS" if finding.passed else "FAIL",
            finding.check,
            number(finding.value),
            finding.unit,
            "" if finding.limit is None else f"limit {number(finding.limit)}",
            "" if finding.cam_angle_deg is None else f"at {finding.cam_angle_deg:.2f} deg",
            finding.where,
        )
        for finding in ordered
    ]
    lines = []
    given: set[str] = set()
    for finding, line in zip(ordered, aligned(rows, right=(2,))):
        lines.append(f"  {line}")
        if not finding.passed and finding.advice and finding.advice not in given:
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
    return figures


def format_lines(as_json: bool) -> list[str]:
    """The file formats with the cams each is for and what it is; as one JSON text where asked."""
    import json

    from camgeom.report.files import format_rows

    rows = format_rows()
    if as_json:
        return [json.dumps(rows, indent=2)]
    return aligned([("format", "for", "what it is"), *((row["format"], row["cams"], row["about"]) for row in rows)])
