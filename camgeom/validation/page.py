"""The validation as pages: Markdown for the documentation, sections of an HTML page."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from camgeom.drawing.content import Block, Chapter, Column, Page, Table, Text
from camgeom.validation.entry import JudgedEntry, Source

VERDICTS = ("confirmed", "misprint", "not reproducible")
HEAD = """# What the sources print, and what comes out

Every printed result of the five sources, computed from its own data by the package: our number, the printed one, the
difference and the verdict. The page is written by `python scripts/validation_page.py` from `camgeom validate`; a test
keeps it. A verdict follows from the numbers alone:

- **confirmed**: ours agrees within half a unit of the last printed digit (a bound: it holds; an equation: its printed
  form gives what the exact computation does, where they differ most),
- **misprint**: it does not, but one changed term explains it; the reason names the term and what it then gives,
- **not reproducible**: neither; the reason tells what was tried.
"""


def number(value: float, like: float | None = None) -> str:
    """A number with seven significant digits; a deviation (`like` is the value it is of) only to what that shows."""
    if (like is not None and abs(value) <= 1e-9 * abs(like)) or abs(value) < 1e-11:
        return "0"
    return f"{value:.7g}" if like is None else f"{value:.6g}"


def counted(rows: Sequence[JudgedEntry]) -> str:
    """How many rows have which verdict, as words."""
    counts = [(verdict, sum(row.verdict == verdict for row in rows)) for verdict in VERDICTS]
    return ", ".join(f"{count} {verdict}" for verdict, count in counts)


def printed(row: JudgedEntry) -> str:
    """The printed number with its comparison sign."""
    return number(row.printed) if row.comparison == "=" else f"{row.comparison} {number(row.printed)}"


def markdown(sources: Sequence[Source], rows: Sequence[JudgedEntry]) -> str:
    """The page for the documentation."""
    lines = [HEAD, f"{len(rows)} results: {counted(rows)}.", ""]
    for source in sources:
        own = [row for row in rows if row.source == source.short]
        lines += [f"## {source.short}: {source.title}", "", f"{source.reference}. `camgeom validate {source.key}`: "
                  f"{counted(own)}.", "", "| item | where | what | printed | ours | unit | difference | verdict | "
                  "reason |", "|---|---|---|---|---|---|---|---|---|"]
        for row in own:
            cells = (cell.replace("|", "\\|") for cell in (*_facts(row), row.reason))
            lines.append(f"| {' | '.join(cells)} |")
        lines.append("")
    return "\n".join(lines)


def _facts(row: JudgedEntry) -> tuple[str, ...]:
    return (
        row.item, row.place, row.says, printed(row), number(row.computed), row.unit,
        number(row.difference, row.printed), row.verdict,
    )  # fmt: skip


RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")


def typeset(text: str) -> str:
    """A number or a unit as a page shows it: powers raised.

    >>> typeset("7.2475e+08"), typeset("rad/s2"), typeset("1.5e-07"), typeset("132")
    ('7.2475 × 10⁸', 'rad/s²', '1.5 × 10⁻⁷', '132')
    """
    power = re.sub(r"e\+?(-?)0*(\d+)$", lambda found: f" × 10{(found[1] + found[2]).translate(RAISED)}", text)
    return re.sub(r"(?<=[a-z])[23]$", lambda found: found[0].translate(RAISED), power)


def results(source: Source, rows: Sequence[JudgedEntry]) -> tuple[Block, ...]:
    """The results of a source and the reasons to read beside them."""
    heads = ("Item", "Where and what", "Printed", "Ours", "Unit", "Difference", "Verdict")
    own = [row for row in rows if row.source == source.short]
    facts = ((item, f"{place}: {says}", *map(typeset, rest)) for item, place, says, *rest in map(_facts, own))
    told = tuple((row.item, row.verdict, row.reason) for row in own if row.reason)
    caption = f"{source.reference}: {counted(own)}"
    return (
        Table(caption, tuple(map(Column, heads)), tuple(facts)),
        Table("Reasons", tuple(map(Column, ("Item", "Verdict", "Why"))), told),
    )


def page(
    sources: Sequence[Source], rows: Sequence[JudgedEntry], version: str, figures: Mapping[str, tuple[Block, ...]]
) -> Page:
    """The HTML page: a section for each source, its results, reasons and, by its short name, its figures."""
    chapters = [
        Chapter(s.key, f"{s.short}: {s.title}", (*results(s, rows), *figures.get(s.short, ()))) for s in sources
    ]
    intro = Text((
        "Every printed result of the sources, computed from its own data by the package. Confirmed: within half a unit "
        "of the last printed digit. Misprint: one changed term explains the difference. Not reproducible: neither; the "
        "reason tells what was tried.",
    ))
    return Page(
        title="What the sources print", kind="validation", level=None, headline=f"{len(rows)} results: {counted(rows)}",
        sections=(Chapter("rules", "What a verdict means", (intro,)), *chapters), details=(("camgeom", version),),
    )  # fmt: skip
