"""`camgeom study`: who computes the rows, and the rows of the exact model as CSV or Parquet."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from camgeom.cli import Console, UsageError, whole
from camgeom.cli.bulk import run as run_bulk
from camgeom.cli.model import names, output_folder, refuse_nameless, refuse_unwritable
from camgeom.cli.study_page import PLOTTED
from camgeom.cli.study_told import FIGURES, close, followers_of, tell, write_page
from camgeom.design.batch import LEVELS
from camgeom.design.bulk import Bulk
from camgeom.design.engine import Cluster, Engine, Pace, local
from camgeom.design.parts import Parts, read_rows
from camgeom.design.sampling import DRAWN, Plan, sample, tie
from camgeom.design.study import MOST_VARIANTS, Row, Study, axis, columns, figures_of, refuse_unsolved
from camgeom.errors import Problem, ProfileError
from camgeom.export.folder import STUDY, results
from camgeom.report.measured import asked, measure, of_followers
from camgeom.report.result import PRODUCTS


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Carry out a study; returns 0 where a variant passes what was judged, else 1."""
    from camgeom.profile import read_data

    refuse_nameless(arguments.out)
    only = names(arguments.only, "--only")
    data = read_data(arguments.profile)
    method, count, seed = sample(arguments.sample)
    axes = tuple(axis(text, method in DRAWN) for text in arguments.vary)
    figures = tuple(names(arguments.figures, "--figures") or ())
    products, checks = asked(only, data, {one.path[0] for one in axes}, figures)
    if left := {"exports", "report"} & set(products):
        allowed = ", ".join(name for name in PRODUCTS if name not in left)
        raise UsageError(f"--only: a study writes no {' and no '.join(sorted(left))}; allowed: {allowed}")
    plan = Plan(axes, method, count, seed, tuple(map(tie, arguments.tie)))
    bulk = Bulk(data, arguments.profile, plan, figures, _level(arguments.pressure_error))
    why = left_to_the_model(arguments, bulk)
    if arguments.pressure_error is not None and (why is not None or not bulk.leveled):
        text = f"the exact model computes the rows ({why})" if why is not None else ROUND_ALONE
        raise UsageError(f"--pressure-error: {text}")
    if why is None:
        return run_bulk(arguments, console, bulk, engine_of(arguments))
    refuse_unsolved(data, axes)
    if len(plan) > MOST_VARIANTS:
        text = f"too many variants for the exact model, which has to compute them ({why})"
        raise ProfileError([Problem("--vary", text, len(plan), f"at most {MOST_VARIANTS}")])
    measured = partial(measure, products=products, checks=checks)
    combined = None if plan.method == "grid" and not plan.ties else plan
    study = Study(data, arguments.profile, axes, measured, plan=combined, wanted=figures)
    name = str(data.get("name", Path(arguments.profile).stem))
    folder = output_folder(arguments.out, name)
    refuse_unwritable(folder)
    engine = engine_of(arguments)
    described = {**study.described(), "products": list(products), "checks": list(checks or ("all",))}
    described["figures"] = list(figures)
    written = "study.parquet" if arguments.parquet else "study.csv"
    with results(folder, STUDY, console.told) as place:
        if arguments.parquet:
            parts = Parts(folder / written, described, len(study))
            rows = streamed(study, engine, parts, place.path(written), console, arguments.json, figures)
            table = as_table(study, rows)
        else:
            rows = _collected(study, engine, console)
            table = as_table(study, rows)
            write_csv(table, place.path(written))
        write_page(study, rows, name, place.path("study.html"), written, figures=figures)
        files = close(place, name, described, (written, "study.html"))
    if arguments.parquet:
        parts.clear()
    status = 0 if any(row.verdict in ("pass", "warn") for row in rows) else 1
    if absent := [key for key in figures if not any(key in row.figures for row in rows)]:
        console.err(f"camgeom study: no variant has the figure {', '.join(absent)}")
    tell(console, arguments.json, study, name, rows, table, files, ("exact model", why))
    return status


ROUND_ALONE = "is of round indexing cams alone: loads of a parallel indexer are shared as the exact model does"
FEW = 200
"""variants up to which the exact model, with all its checks, takes some seconds"""


def left_to_the_model(arguments: argparse.Namespace, bulk: Bulk) -> str | None:
    """Why the exact model computes the rows; None where the batch does. Raises ProfileError where it was asked for
    and cannot."""
    if arguments.exact and arguments.batch:
        raise UsageError("--exact and --batch: leave one of the two out")
    if arguments.exact:
        return "asked for by --exact"
    if not arguments.batch and len(bulk.plan) <= FEW:
        return f"up to {FEW} variants, unless --batch asks for the batch"
    why = "--only names what the exact model gives" if arguments.only is not None else bulk.refused()
    if why is not None and arguments.batch:
        raise ProfileError([Problem("--batch", f"the batch cannot: {why}")])
    return why


def _level(text: str | None) -> float:
    """The largest error of an indexer's pressures by the batch."""
    if text is None:
        return LEVELS[0]
    found = {f"{level:g}": level for level in LEVELS}.get(text.strip())
    if found is None:
        raise UsageError(f"--pressure-error: needs one of {LEVELS[0]:g} and {LEVELS[1]:g} (found {text[:60]!r})")
    return found


def engine_of(arguments: argparse.Namespace) -> Engine:
    """Who computes the rows. Raises UsageError where both --jobs and --on say it."""
    jobs = whole(arguments.jobs, "--jobs", 1, 256, "processes")
    if arguments.on is None:
        return local(jobs)
    if jobs is not None:
        raise UsageError("--jobs: the scheduler of --on has its own workers; leave one of the two out")
    return Cluster(arguments.on)


def _collected(study: Study, engine: Engine, console: Console) -> list[Row]:
    """All rows in order, kept in memory."""
    pace, rows = Pace(len(study)), []
    for row in study.rows(engine):
        rows.append(row)
        console.progress(pace.after(1))
    console.progress("")
    return rows


def streamed(
    study: Study, engine: Engine, parts: Parts, path: Path, console: Console, whole: bool, figures: Sequence[str] = ()
) -> list[Row]:
    """All rows written as Parquet, to `path` unless the whole file is there; read back `whole`, or as far as is shown
    and asked for (`figures`)."""
    gaps = parts.gaps
    left = sum(map(len, gaps))
    if left < len(study):
        console.err(f"{len(study) - left} of {len(study)} variants were computed before")
    pace = Pace(len(study), len(study) - left)
    for piece, rows in study.pieces(engine, gaps):
        parts.write(piece, columns(study, rows))
        console.progress(pace.after(len(piece)))
    console.progress("")
    usual = of_followers((*FIGURES, *(key for key, _, _ in PLOTTED)), followers_of(study))
    shown = {"verdict", "reason", "not_judged", *usual, *figures}
    records = read_rows(parts.join(path), None if whole else shown)
    aside = {"verdict", "reason", *(one.key for one in study.varied)}
    measured = ({key: value for key, value in record.items() if key not in aside} for record in records)
    values = study.values(range(len(study)))
    return [Row(v, f, r["verdict"], r["reason"]) for v, f, r in zip(values, measured, records)]


def as_table(study: Study, rows: list[Row]) -> list[dict[str, Any]]:
    """The rows as records that all have the same columns."""
    figures = figures_of(study, rows)
    keys = [one.key for one in study.varied]

    def record(row: Row) -> dict[str, Any]:
        measured = {key: row.figures.get(key) for key in figures}
        return {**dict(zip(keys, row.values)), **measured, "verdict": row.verdict, "reason": row.reason}

    return [record(row) for row in rows]


def write_csv(table: list[dict[str, Any]], path: Path) -> Path:
    """The records as CSV, numbers with all their digits; the file appears whole or not at all."""
    from camgeom.export.files import write_whole

    text = io.StringIO()
    writer = csv.DictWriter(text, list(table[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({key: "" if value is None else value for key, value in record.items()} for record in table)
    write_whole(path, text.getvalue())
    return path
