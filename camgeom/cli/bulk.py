"""`camgeom study` where the batch computes the rows: pieces of columns as they come, into Parquet or CSV."""

from __future__ import annotations

import argparse
import csv
import io
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from camgeom.cli import Console
from camgeom.cli.model import output_folder, refuse_unwritable
from camgeom.cli.study_page import MOST_ROWS
from camgeom.cli.study_told import SHOWN, close, tell, write_page
from camgeom.design.bulk import Bulk
from camgeom.design.engine import Alone, Cluster, Engine, Pace
from camgeom.design.parts import Parts, pyarrow, read_rows
from camgeom.design.sampling import Column
from camgeom.design.study import Row, Study
from camgeom.errors import CamgeomError
from camgeom.export.folder import STUDY, results

SMALL = 20_000
"""rows that take less time here than worker processes take to begin"""
MOST_PIECE = 50_000
"""rows of a piece: some tens of megabytes"""
SAID = "figures of many variants at once; --exact asks the exact model and all its checks for every one"


def run(arguments: argparse.Namespace, console: Console, bulk: Bulk, engine: Engine) -> int:
    """Carry out a study by the batch; returns 0 where a variant passes what was judged, else 1."""
    name = str(bulk.data.get("name", Path(arguments.profile).stem))
    folder = output_folder(arguments.out, name)
    refuse_unwritable(folder)
    total = len(bulk.plan)
    engine = Alone() if total <= SMALL and not isinstance(engine, Cluster) else engine
    study = Study(bulk.data, bulk.file, bulk.plan.axes, unmeasured, plan=bulk.plan, most=total, wanted=bulk.figures)
    shown: list[dict[str, Any]]
    described = {**study.described(), "batch": [*bulk.figures, bulk.level]}
    table = "study.parquet" if arguments.parquet else "study.csv"
    with results(folder, STUDY, console.told) as place:
        if arguments.parquet:
            parts = Parts(folder / table, described, total)
            if (left := sum(map(len, parts.gaps))) < total:
                console.err(f"{total - left} of {total} variants were computed before")
            _written(bulk, engine, parts, console)
            shown, counts = _read(parts.join(place.path(table)), arguments.json)
        else:
            shown, counts = _as_csv(bulk, engine, place.path(table), console, arguments.json)
        left_open = " ".join(_not_judged(bulk))
        for record in shown:
            record["not_judged"] = left_open
        rows = [_row(study, record) for record in shown]
        write_page(study, rows[:MOST_ROWS], name, place.path("study.html"), table, counts, bulk.figures)
        files = close(place, name, described, (table, "study.html"))
    if arguments.parquet:
        parts.clear()
    dropped = replace(bulk, figures=()).judged_checks() - bulk.judged_checks()
    said = f"{SAID}; without --figures {', '.join(sorted(dropped))} would be judged too" if dropped else SAID
    tell(console, arguments.json, study, name, rows[: SHOWN + 1], shown, files, ("batch", said), counts)
    return 0 if counts["pass"] or counts["warn"] else 1


def unmeasured(model: object) -> tuple[dict[str, Any], str, str]:
    """What the exact model would be asked: nothing, since the batch has computed the rows."""
    del model
    return {}, "no result", ""


def _pieces(gaps: Iterable[range], width: int) -> Iterator[range]:
    """The ranges in pieces, such that every worker has several."""
    for gap in gaps:
        size = min(MOST_PIECE, max(SMALL // 4, -(-len(gap) // (4 * width))))
        yield from (gap[k : k + size] for k in range(0, len(gap), size))


def _computed(
    bulk: Bulk, engine: Engine, gaps: Sequence[range], parts: Parts | None, console: Console
) -> Iterator[tuple[range, dict[str, Any]]]:
    """The pieces as they are ready; written by who computes them, and then empty, where `parts` is given."""
    total, left = len(bulk.plan), sum(map(len, gaps))
    pace = Pace(total, total - left)
    near = None if isinstance(engine, Cluster) else parts
    work = partial(_work, bulk, near)
    for piece, columns in engine.run(work, _pieces(gaps, engine.width), bulk.drawn):
        if columns is None:
            raise CamgeomError(f"variants {piece.start} to {piece.stop - 1}: the worker process ended each time")
        if parts is not None and near is None:
            parts.write(piece, columns)
        console.progress(pace.after(len(piece)))
        yield piece, columns
    console.progress("")


def _work(bulk: Bulk, parts: Parts | None, piece: range, keys: dict[str, Column]) -> dict[str, Any]:
    columns = bulk.columns(keys)
    if parts is None:
        return dict(columns)
    parts.write(piece, columns)
    return {}


def _written(bulk: Bulk, engine: Engine, parts: Parts, console: Console) -> None:
    for _ in _computed(bulk, engine, parts.gaps, parts, console):
        pass


def _read(path: Path, whole: bool) -> tuple[list[dict[str, Any]], Counter[str]]:
    """The first rows of the finished file (all where `whole`), and how many there are of each verdict."""
    arrow = pyarrow()
    file = arrow.parquet.ParquetFile(path)
    counts: Counter[str] = Counter()
    for batch in file.iter_batches(columns=["verdict"]):
        for entry in batch.column(0).value_counts().to_pylist():
            counts[entry["values"]] += entry["counts"]
    if whole:
        return read_rows(path), counts
    return next(file.iter_batches(batch_size=MOST_ROWS)).to_pylist(), counts


def _as_csv(
    bulk: Bulk, engine: Engine, path: Path, console: Console, whole: bool
) -> tuple[list[dict[str, Any]], Counter[str]]:
    """Write the rows in order as CSV; the first of them (all where `whole`), and how many there are of each verdict."""
    from camgeom.export.files import atomic_write

    shown: list[dict[str, Any]] = []
    counts: Counter[str] = Counter()
    ready: dict[int, dict[str, Any]] = {}
    coming = 0
    with atomic_write(path) as stream:
        for piece, columns in _computed(bulk, engine, [range(len(bulk.plan))], None, console):
            ready[piece.start] = columns
            while coming in ready:
                found = ready.pop(coming)
                counts.update(found["verdict"].tolist())
                rows = list(zip(*map(_plain, found.values())))
                text = io.StringIO()
                writer = csv.writer(text, lineterminator="\n")
                if not coming:
                    writer.writerow(found)
                writer.writerows(["" if value is None else value for value in row] for row in rows)
                stream.write(text.getvalue().encode())
                most = len(rows) if whole else MOST_ROWS - len(shown)
                shown += [dict(zip(found, row)) for row in rows[:most]]
                coming += len(rows)
    return shown, counts


def _plain(column: Any) -> list[Any]:
    """A column as Python's own values, None where there is no end."""
    if not isinstance(column, np.ndarray):
        return list(column)
    if column.dtype.kind != "f":
        return list(column.tolist())
    return [value if end else None for value, end in zip(column.tolist(), np.isfinite(column).tolist())]


def _row(study: Study, record: Mapping[str, Any]) -> Row:
    keys = [one.key for one in study.varied]
    aside = {*keys, "verdict", "reason"}
    figures = {key: value for key, value in record.items() if key not in aside}
    return Row(tuple(record[key] for key in keys), figures, record["verdict"], record["reason"])


def _not_judged(bulk: Bulk) -> list[str]:
    """Names of the checks that apply to the profile and that the figures of the batch do not decide."""
    from camgeom.checks import applies, checks, light_checks
    from camgeom.model import Model
    from camgeom.profile import from_data

    model = Model(from_data(bulk.data, bulk.file))
    judged = bulk.judged_checks()
    every = {**checks(model), **{name: checks()[name] for name in light_checks()}}
    return sorted(name for name, entry in every.items() if name not in judged and applies(entry, model))
