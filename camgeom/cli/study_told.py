"""What a study says when its rows are there: its page, a summary on the terminal or JSON."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from camgeom.cli import Console, aligned, number
from camgeom.cli.model import slug
from camgeom.cli.study_page import cell, left_open, page, word
from camgeom.design.study import Row, Study
from camgeom.report.delivery import finite
from camgeom.report.measured import of_followers
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.export.folder import RunFolder

SHOWN = 20
"""rows shown on the terminal; the CSV file has all"""
FIGURES = (
    "flank.max_pressure_angle_deg",
    "flank.undercut_margin",
    "contact.peak_pressure_mpa",
    "contact.peak_slice_pressure_mpa",
    "contact.contact_length_mm",
    "together.peak_pressure_mpa",
    "together.peak_torque_n_m",
    "together.least_life_h",
    "fatigue.roller_life_h",
    "fatigue.roller_slice_life_h",
    "fatigue.face_life_h",
    "cutter.most_rest_mm",
    "cutter.least_rest_mm",
    "dynamics.amplification",
    "dynamics.duty.peak_pressure_mpa",
    "dynamics.duty.roller_life_h",
    "dynamics.camshaft_torque_n_m",
    "dynamics.duty.peak_drive_force_n",
    "dynamics.output_torque_n_m",
    "dynamics.start_duty.peak_pressure_mpa",
    "dynamics.impact.worst_pressure_mpa",
    "dynamics.impact.duty.roller_life_h",
    "dynamics.impact.duty.peak_torque_n_m",
    "dynamics.impact.over_turns.peak_acceleration_rad_s2.mean",
    "dynamics.impact.over_turns.peak_acceleration_m_s2.mean",
)
"""columns shown on the terminal"""


def tell(
    console: Console,
    as_json: bool,
    study: Study,
    name: str,
    rows: list[Row],
    table: list[dict[str, Any]],
    files: list[Path],
    computed: tuple[str, str],
    counts: Counter[str] | None = None,
) -> None:
    """Print the result: rows, the same as records (`table`), files, by whom the rows were `computed` and why."""
    by, because = computed
    if as_json:
        varied = {one.key: list(one.values) for one in study.axes}
        result = {"name": name, "computed_by": by, "because": because, "varied": varied, "rows": table,
                  "files": [str(file) for file in files]}  # fmt: skip
        console.out(json.dumps(finite(result), indent=2, allow_nan=False))
        return
    for line in summary(study, rows, table, counts):
        console.out(line)
    console.out(f"  computed by the {by}: {because}")
    for file in files:
        console.out(f"  wrote {file}")


def close(place: RunFolder, name: str, described: Mapping[str, Any], files: Sequence[str]) -> list[Path]:
    """Let these files of a study appear in its folder; those of another one there move to `previous/`.

    described  all that its rows rest on: files of one study stand beside each other
    """
    design = sha256(json.dumps(described, sort_keys=True).encode()).hexdigest()
    made = {file: file for file in files if (place.staged / file).exists()}
    about = {"name": name, "stem": slug(name), "command": "study", "version": __version__}
    place.close(about, design, made, set(made))
    return [place.folder / file for file in files]


def followers_of(study: Study) -> int:
    """How many followers its variants have."""
    return 1 + len(study.data.get("track") or study.data.get("station") or ())


def write_page(
    study: Study,
    rows: list[Row],
    name: str,
    path: Path,
    table: str = "study.csv",
    counts: Counter[str] | None = None,
    figures: Sequence[str] = (),
) -> Path:
    """The page with the plots; the file appears whole or not at all."""
    from camgeom.export.files import write_whole
    from camgeom.report.page import render

    text = render(page(study, rows, name, table, counts, figures))
    write_whole(path, text)
    return path


def summary(
    study: Study, rows: list[Row], table: list[dict[str, Any]], counts: Counter[str] | None = None
) -> list[str]:
    """How many variants there are of each verdict (`counts` where `rows` are the first alone), and the first of them.
    """
    counts = counts or Counter(row.verdict for row in rows)
    total = sum(counts.values())
    told = ", ".join(f"{count} {word(verdict, rows)}" for verdict, count in counts.items())
    lines = [f"{total} variants: {told}"]
    if open_ := left_open(rows):
        lines.append(f"  not judged here: {', '.join(open_)}; `camgeom check` judges a variant whole")
    columns = [one.key for one in study.varied] + ["verdict"]
    shown = dict.fromkeys((*study.wanted, *of_followers(FIGURES, followers_of(study))))
    columns += [key for key in shown if key in table[0]] + ["reason"]
    cells = [[number(cell(key, record[key]))[:60] for key in columns] for record in table[:SHOWN]]
    lines += [f"  {line}" for line in aligned([columns, *cells])]
    return lines if total <= SHOWN else [*lines, f"  and {total - SHOWN} more in the file"]
