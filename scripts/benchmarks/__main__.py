"""All benchmark sections, or the named ones, each in a process of its own; results in docs/benchmarks.

    scripts/bench [SECTION ...] [--quick] [--list] [--out DIR]

Writes results.json (all tables, the machine, when and on which code each section was measured), one CSV a table, the
plots as SVG, and benchmarks.md beside the folder. Sections that are not run keep their last results. A section that
fails is named, and the exit status is 1.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import subprocess
import sys
import tempfile
from datetime import date
from pathlib import Path
from time import perf_counter
from typing import Any

from kit import ROOT, Plot, Table, draw, machine, markdown, write_csv

HERE = Path(__file__).resolve().parent
ORDER = (
    *("start", "groove", "planar", "globoidal", "sampling", "limits", "growth", "opencascade"),
    *("batch", "motion", "best_law", "contact", "life", "dynamics", "impact", "tolerance", "export"),
)
FOLDED = 40
"""Rows from which on a table is folded away under its picture."""


def sections() -> dict[str, str]:
    """First line of every section's docstring by name, in the order of the page."""
    found = {}
    for path in HERE.glob("*.py"):
        if path.stem not in ("kit", "__main__"):
            found[path.stem] = (ast.get_docstring(ast.parse(path.read_text())) or "").split("\n", 1)[0]
    rank = {name: k for k, name in enumerate(ORDER)}
    return dict(sorted(found.items(), key=lambda item: (rank.get(item[0], len(rank)), item[0])))


def measure(name: str, quick: bool) -> list[dict[str, Any]] | None:
    """Run one section; its tables, or None where it failed."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "tables.json"
        command = [sys.executable, str(HERE / f"{name}.py"), "--json", str(out), *(["--quick"] if quick else [])]
        done = subprocess.run(command, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"}, check=False)
        return json.loads(out.read_text()) if done.returncode == 0 and out.exists() else None


def page(results: dict[str, Any], titles: dict[str, str], plots: str) -> str:
    """docs/benchmarks.md."""
    about = ", ".join(f"{key.replace('_', ' ')} {value}" for key, value in results["machine"].items())
    intro = (HERE / "introduction.md").read_text().strip()
    lines = ["# Benchmarks", "", intro, "", f"The last section was measured on: {about}.", ""]
    for name, title in titles.items():
        if name not in results["sections"]:
            continue
        lines += [f"## {name.capitalize()}", "", title, "", f"Measured {results['measured'][name]}.", ""]
        for raw in results["sections"][name]:
            table = as_table(raw)
            lines += [f"### {table.title}", ""]
            if table.plot is not None:
                lines += [f"![{table.title}]({plots}/{table.name}.svg)", ""]
            shown = [markdown(table), ""]
            if len(table.rows) > FOLDED:
                shown = [f"<details><summary>{len(table.rows)} rows</summary>", "", *shown, "</details>", ""]
            lines += [*shown, *([table.note, ""] if table.note else [])]
    limits = (HERE / "limits.md").read_text().strip()
    return "\n".join([*lines, limits, ""])


def stamp() -> str:
    """The day, the commit and the load of the machine."""
    words = ["git", "-C", str(ROOT), "log", "-1", "--format=%h"]
    commit = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    return f"{date.today().isoformat()} at commit {commit}, {os.getloadavg()[0]:.1f} processes wanting the processor"


def as_table(raw: dict[str, Any]) -> Table:
    """A table read back from JSON."""
    return Table(**{**raw, "plot": Plot(**raw["plot"]) if raw["plot"] else None})


def main() -> int:
    titles = sections()
    parser = argparse.ArgumentParser(prog="scripts/bench", description=__doc__.split("\n", 1)[0])
    parser.add_argument("sections", nargs="*", metavar="SECTION", help=", ".join(titles))
    parser.add_argument("--quick", action="store_true", help="fewer and smaller cases")
    parser.add_argument("--list", action="store_true", help="the sections and what they measure")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "benchmarks", help="folder of the results")
    options = parser.parse_args()
    if options.list:
        print("\n".join(f"{name:10} {title}" for name, title in titles.items()))
        return 0
    if unknown := [name for name in options.sections if name not in titles]:
        parser.error(f"unknown section {', '.join(unknown)}; choose from {', '.join(titles)}")
    options.out.mkdir(parents=True, exist_ok=True)
    store = options.out / "results.json"
    stored = json.loads(store.read_text()) if store.exists() else {"measured": {}, "sections": {}}
    kept, measured = stored["sections"], stored["measured"]
    results: dict[str, Any] = {"machine": machine(), "measured": measured, "sections": kept}
    failed = []
    for name in options.sections or titles:
        began = perf_counter()
        tables = measure(name, options.quick)
        print(f"-- {name}: {'failed' if tables is None else 'done'} in {perf_counter() - began:.0f} s", flush=True)
        if tables is None:
            failed.append(name)
            continue
        kept[name], measured[name] = tables, stamp()
        for table in map(as_table, tables):
            write_csv(table, options.out / f"{table.name}.csv")
            if table.plot is not None:
                draw(table, options.out / f"{table.name}.svg")
        store.write_text(json.dumps(results, indent=1) + "\n")
        (options.out.parent / "benchmarks.md").write_text(page(results, titles, options.out.name))
    if failed:
        print(f"failed: {', '.join(failed)}", file=sys.stderr)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
