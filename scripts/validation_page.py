"""Write docs/validation.md, every printed result of the sources beside ours, from what `camgeom validate` computes,
and docs/sources.md, the audit of the sources, from docs/sources.tsv and the same results.

    python scripts/validation_page.py            # writes both pages
    python scripts/validation_page.py --check    # exit status 1 where a page is not what comes out
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
if TYPE_CHECKING:
    from camgeom.validation import JudgedEntry, Source

DOCS = ROOT / "docs"
AUDIT = """# The five sources, line by line

One row for each equation, table, figure, rule and conclusion of the five documents: the command that shows it, and our
number beside the printed one with the verdict of [the validation](validation.md) where there is one. A row without a
number says why. The table is `docs/sources.tsv`; this page is written from it by `python scripts/validation_page.py`.
"""


def main() -> int:
    """Write the pages, or compare them; 0 when they are current."""
    from camgeom.validation import SOURCES, validate
    from camgeom.validation.page import markdown

    parser = argparse.ArgumentParser(description="The validation page and the audit of the sources.")
    parser.add_argument("--check", action="store_true", help="compare only")
    check = parser.parse_args().check
    rows = validate()
    texts = {"validation.md": markdown(SOURCES, rows), "sources.md": audit(SOURCES, rows)}
    if check:
        return int(any(not (DOCS / n).is_file() or (DOCS / n).read_text("utf-8") != t for n, t in texts.items()))
    for name, text in texts.items():
        (DOCS / name).write_text(text, encoding="utf-8")
        print(f"docs/{name}: {len(text.splitlines())} lines")
    return 0


def places() -> list[list[str]]:
    """The rows of docs/sources.tsv: source, place, what it is, command, items of the validation or ! and a reason."""
    lines = (DOCS / "sources.tsv").read_text(encoding="utf-8").splitlines()
    return [line.split("\t") for line in lines if line and not line.startswith("#")]


def audit(sources: Sequence[Source], rows: Sequence[JudgedEntry]) -> str:
    """The audit: a table a source, with the numbers of its rows."""
    from camgeom.validation.page import number, printed

    found = {(row.source, row.item): row for row in rows}
    whole = places()
    lines = [AUDIT, f"{len(whole)} rows, {sum(not row[4].startswith('!') for row in whole)} of them with a number.", ""]
    for source in sources:
        lines += [f"## {source.short}: {source.title}", "", "| where | what | shown by | ours (printed) | verdict |",
                  "|---|---|---|---|---|"]
        for short, place, what, command, items in whole:
            if short != source.short:
                continue
            shown = command or f"camgeom validate {source.short}"
            if items.startswith("!"):
                numbers, verdicts = items[1:].strip(), "-"
            else:
                own = [found[short, item.strip()] for item in items.split(", ")]
                units = ["" if row.unit == "1" else f" {row.unit}" for row in own]
                told = (f"{number(row.computed)}{unit} ({printed(row)})" for row, unit in zip(own, units))
                numbers = "; ".join(told)
                verdicts = ", ".join(dict.fromkeys(r.verdict for r in own))
            lines.append(f"| {place} | {what} | `{shown}` | {numbers} | {verdicts} |")
        lines.append("")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
