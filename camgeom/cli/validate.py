"""`camgeom validate`: what the sources print beside what comes out, with a verdict for each result."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from camgeom.cli import Console, UsageError, aligned
from camgeom.cli.model import refuse_nameless, refuse_unwritable, write_set
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.drawing.content import Block
    from camgeom.validation import JudgedEntry, Source


def run(arguments: argparse.Namespace, console: Console) -> int:
    """Compute and judge, print the rows, write the pages where a folder is named; returns the exit status, 0.

    A misprint of a source is no failure of the design or of the command.
    """
    from camgeom.errors import ProfileError
    from camgeom.validation import SOURCES, source_named, validate

    try:
        sources = SOURCES if arguments.name is None else (source_named(arguments.name),)
    except ProfileError as error:
        raise UsageError(f"validate: {error}") from None
    refuse_nameless(arguments.out)
    folder = None if arguments.out is None else Path(arguments.out)
    if folder is not None:
        refuse_unwritable(folder)
    rows = validate(sources, watch=lambda source, entry: console.progress(f"{source.short} {entry.item}"))
    files = [] if folder is None else _written(folder, sources, rows, console)
    console.progress("")
    if arguments.json:
        console.out(_json(rows))
        return 0
    for line in _lines(sources, rows):
        console.out(line)
    for file in files:
        console.out(f"wrote {file}")
    return 0


def _lines(sources: Sequence[Source], rows: Sequence[JudgedEntry]) -> list[str]:
    """A table a source, with the reasons of what is not confirmed below it."""
    from camgeom.validation.page import counted, number, printed

    lines = []
    for source in sources:
        own = [row for row in rows if row.source == source.short]
        lines += [f"{source.short} {source.title}: {counted(own)}", f"  {source.reference}"]
        table = [("item", "where", "printed", "ours", "unit", "difference", "verdict")]
        table += [
            (r.item, r.place, printed(r), number(r.computed), r.unit, number(r.difference, r.printed), r.verdict)
            for r in own
        ]
        lines += [f"  {line}" for line in aligned(table, right=(2, 3, 5))]
        lines += [f"  {r.item}, {r.says}: {r.reason}" for r in own if r.verdict != "confirmed"]
        lines.append("")
    return [*lines, f"{len(rows)} results: {counted(rows)}"]


def _json(rows: Sequence[JudgedEntry]) -> str:
    return json.dumps({"rows": [row.as_dict() for row in rows]}, indent=2, allow_nan=False, ensure_ascii=False)


def _written(folder: Path, sources: Sequence[Source], rows: Sequence[JudgedEntry], console: Console) -> list[Path]:
    """The page as HTML, with the figures, and as Markdown, and the data; they appear together."""
    from camgeom.export.folder import VALIDATION
    from camgeom.report.page import render
    from camgeom.validation.figures import figures
    from camgeom.validation.page import markdown, page

    drawn: dict[str, tuple[Block, ...]] = {}
    for source in sources:
        for figure in figures(source):
            console.progress(f"{source.short} {figure.place}")
            drawn[source.short] = (*drawn.get(source.short, ()), *figure.draw())
    texts = {
        "validation.html": render(page(sources, rows, __version__, drawn)),
        "validation.md": markdown(sources, rows),
        "validation.json": _json(rows) + "\n",
    }
    return write_set(folder, VALIDATION, "validation", "validate", texts, console)
