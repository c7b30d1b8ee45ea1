"""The report page: one HTML file with its styles, plots and 3D view inside, which asks the network for nothing."""

from __future__ import annotations

import html
import re
from dataclasses import replace
from importlib.resources import files
from itertools import count, groupby

from camgeom.drawing.content import (
    Block,
    Cell,
    Chapter,
    Chart,
    Column,
    Cost,
    Drawing,
    Figure,
    Level,
    Map,
    Page,
    Parallel,
    Polar,
    Remark,
    Scene,
    Table,
    Text,
)
from camgeom.drawing.drawing import drawing_sheet
from camgeom.drawing.maps import map_sheet
from camgeom.drawing.parallel import parallel_sheet
from camgeom.drawing.plots import NARROW, WIDE, chart_sheet
from camgeom.drawing.polar import polar_sheet
from camgeom.drawing.sheet import Sheet, number
from camgeom.errors import unmade, visible
from camgeom.report.result import Products
from camgeom.report.scene import scene_json

Plot = Chart | Map | Polar | Parallel | Drawing


def escape(text: str) -> str:
    """Text as HTML, nothing unseen in it."""
    return html.escape(visible(text))


_HATCH = (
    '<svg width="0" height="0" style="position:absolute" aria-hidden="true"><defs><pattern id="hatch" width="7" '
    'height="7" patternUnits="userSpaceOnUse" patternTransform="rotate(45)"><path class="hatch" d="M0 0V7"/></pattern>'
    "</defs></svg>"
)
POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data: blob:"


def render(page: Page, products: Products | None = None) -> str:
    """The page as one HTML text; it opens from disk, prints on A4 and follows the reader's light or dark setting.

    products  takes notes on sections that cannot be drawn, where the reason then stands; without, that is an error
    """
    has_scene = any(isinstance(block, Scene) for section in page.sections for block in section.blocks)
    figures, tables = count(1), count(1)
    body = [
        _title(page),
        _contents(page),
        _HATCH,
        "<main>",
        verdict_box(page),
        _key_figures(page.figures),
        *(_drawn(n, section, figures, tables, products) for n, section in enumerate(page.sections, start=1)),
        "<footer>Lengths in mm and angles in degrees unless stated. The 3D view and the plots are drawn to picture "
        "accuracy; decisions rest on the numbers in the tables.</footer></main>",
        f"<script>{asset('report.js')}</script>",
        f"<script>{asset('viewer.js')}</script>" if has_scene else "",
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark">'
        f"<title>{escape(page.title)}</title><style>{asset('report.css')}{_running_foot(page)}</style></head><body>"
        + "\n".join(body)
        + "</body></html>\n"
    )


def asset(name: str) -> str:
    """A file of styles or scripts."""
    return (files("camgeom.report") / "assets" / name).read_text(encoding="utf-8")


def _running_foot(page: Page) -> str:
    """Title and page number at the foot of printed pages; every character of the title as a CSS escape."""
    title = "".join(f"\\{ord(char):06x}" for char in page.title[:90])
    grey = "font:8pt system-ui,sans-serif;color:#56606b"
    return (
        f'@page{{@bottom-left{{content:"{title}";{grey}}}'
        f'@bottom-right{{content:counter(page) " / " counter(pages);{grey}}}}}'
    )


def _title(page: Page) -> str:
    details = "".join(f"<div><dt>{escape(k)}</dt><dd>{_breakable(v)}</dd></div>" for k, v in page.details)
    return (
        f'<header class="title"><div><div class="name"><h1>{escape(page.title)}</h1><p>{escape(page.kind)}</p></div>'
        f"<dl>{details}</dl></div></header>"
    )


def _breakable(text: str) -> str:
    """Text as HTML that breaks at the joints of a file's name before it breaks within a word."""
    return escape(text).replace("_", "_<wbr>")


def _contents(page: Page) -> str:
    if len(page.sections) < 2:
        return ""
    rows = (
        f'<li><a href="#{escape(section.key)}"><span class="number">{n}</span>{escape(section.title)}</a></li>'
        for n, section in enumerate(page.sections, start=1)
    )
    return f'<nav aria-label="Contents"><ol>{"".join(rows)}</ol></nav>'


def verdict_box(page: Page) -> str:
    """The verdict with what it rests on, as HTML."""
    told = sorted((f for f in page.findings if f.level is not Level.PASS), key=lambda f: f.level is not Level.FAIL)
    checked, counted = len(page.findings), sum(finding.level is page.level for finding in page.findings)
    heads = {
        Level.PASS: f"Passes what was judged, {checked} checks" if page.omitted else f"Passes all {checked} checks",
        Level.WARN: f"Passes {checked} checks, {counted} with a warning",
        Level.FAIL: f"Fails {counted} of {checked} checks",
        None: "Not judged",
    }
    if page.level is Level.PASS and checked == 1:
        heads[Level.PASS] = "Passes the one check made"
    head = heads[page.level] + (f"; {len(page.omitted)} not judged" if page.omitted and page.level else "")
    head = page.headline or head
    style = "" if page.level is None else f" {page.level.value}"
    summary = f"<p>{escape(page.summary)}</p>" if page.summary else ""
    reasons: dict[str, list[str]] = {}
    for check, reason in page.omitted:
        reasons.setdefault(check, []).append(reason)
    return (
        f'<section class="verdict{style}" id="verdict"><h2>{escape(head)}</h2>{summary}'
        + "".join([*map(_finding, told), *(_open(check, found) for check, found in reasons.items())])
        + "</section>"
    )


def _open(check: str, reasons: list[str]) -> str:
    """A check that is not judged, with every reason; what the reasons have in common is said once."""
    told = [f"Not judged: {'; '.join(_joined(reasons))}."]
    advice = "".join(f'<p class="advice">{_signs(text)}</p>' for text in told)
    return f'<div class="finding"><h3>{escape(check)}</h3>{advice}</div>'


def _joined(reasons: list[str]) -> list[str]:
    """Reasons `give A: words` and `give B: words` as one, `give A and B: words`."""
    found: dict[str, list[str]] = {}
    for reason in reasons:
        head, colon, tail = reason.partition(": ")
        found.setdefault(colon + tail, []).append(head)
    return [
        heads[0] + "".join(f" and {head.removeprefix('give ')}" for head in heads[1:]) + tail
        for tail, heads in found.items()
    ]


def _signs(text: str) -> str:
    """Text as HTML with the signs of print for those of a terminal."""
    return _words(text.replace("<= ", "≤ ").replace(">= ", "≥ "))


def _finding(finding: Remark) -> str:
    fact = [_value(finding.value, finding.unit)] if finding.value is not None else []
    fact += [escape(f"limit {finding.limit}")] if finding.limit else []
    fact += [_words(finding.where)] if finding.where else []
    advice = f'<p class="advice">{_signs(finding.advice)}</p>' if finding.advice else ""
    return f'<div class="finding"><h3>{escape(finding.check)}</h3><p class="fact">{", ".join(fact)}</p>{advice}</div>'


def _value(value: Cell, unit: str) -> str:
    gap = "" if unit == "°" or not unit else "\N{NARROW NO-BREAK SPACE}"
    return f"{_cell(value)}{gap}{escape(unit)}"


def _key_figures(figures: tuple[Figure, ...]) -> str:
    if not figures:
        return ""
    rows = []
    for figure in figures:
        unit = f" <small>{escape(figure.unit)}</small>" if figure.unit else ""
        note = f'<dd class="note">{escape(figure.note)}</dd>' if figure.note else ""
        rows.append(f"<div><dt>{escape(figure.label)}</dt><dd>{_cell(figure.value)}{unit}</dd>{note}</div>")
    return f'<dl class="figures">{"".join(rows)}</dl>'


def _drawn(n: int, section: Chapter, figures: count[int], tables: count[int], products: Products | None) -> str:
    """A section, or the reason why it cannot be drawn."""
    try:
        return _section(n, section, figures, tables)
    except Exception as error:
        if products is None:
            raise
        why = unmade(error)
        products.unmade(f"report.{section.key}", why)
        told = Text((f"This section cannot be drawn: {why.reason}",))
        return _section(n, replace(section, blocks=(told,)), figures, tables)


def _section(n: int, section: Chapter, figures: count[int], tables: count[int]) -> str:
    parts = []
    for width, run in groupby(section.blocks, key=_width):
        inner = "".join(_block(block, figures, tables) for block in run)
        parts.append(f'<div class="pair">{inner}</div>' if width == "half" else inner)
    return (
        f'<section id="{escape(section.key)}"><h2><span class="number">{n}</span>{escape(section.title)}</h2>'
        + "".join(parts)
        + "</section>"
    )


def _width(block: Block) -> str:
    return "full" if isinstance(block, (Text, Scene, Cost)) else block.width


def _block(block: Block, figures: count[int], tables: count[int]) -> str:
    if isinstance(block, Text):
        return "".join(f"<p>{escape(paragraph)}</p>" for paragraph in block.paragraphs)
    if isinstance(block, Table):
        return _table(block, next(tables))
    if isinstance(block, Cost):
        return _cost(block, next(tables))
    caption = f"<figcaption><b>Figure {next(figures)}</b>{escape(block.caption)}</figcaption>"
    if isinstance(block, Scene):
        # A true section and no shaded picture: that one took two thirds of a page's time, for the few browsers without
        # WebGL or scripts; `--formats png` draws it on request.
        drawn = "" if block.still is None else sheet(block.still, WIDE).render(block.still.caption, "drawing")
        return (
            f'<figure class="scene full">{caption}<div class="stage"><div class="poster">{drawn}</div>'
            "<p>The 3D view needs scripts.</p></div>"
            f'<div class="controls"></div><script type="application/json">{scene_json(block)}</script></figure>'
        )
    style = "drawing" if isinstance(block, Drawing) else ""
    narrow = sheet(block, NARROW).render(block.caption, style)
    if block.width == "half":
        return f'<figure class="half">{caption}{narrow}</figure>'
    wide = sheet(block, WIDE).render(block.caption, style)
    return f'<figure class="full">{caption}<div class="wide">{wide}</div><div class="narrow">{narrow}</div></figure>'


def sheet(block: Plot, width: float) -> Sheet:
    """A plot of any kind set at a width, px."""
    if isinstance(block, Chart):
        return chart_sheet(block, width)
    if isinstance(block, Map):
        return map_sheet(block, width)
    if isinstance(block, Polar):
        return polar_sheet(block, width)
    if isinstance(block, Parallel):
        return parallel_sheet(block, width)
    return drawing_sheet(block, width)


UNLIMITED = "unlimited"
"""how a life without end is shown"""
SHORT = 12
"""characters up to which a cell is not broken"""
_LEVELS = {
    Level.PASS: '<span class="pass">✓ passes</span>',
    Level.WARN: '<span class="warn">! warns</span>',
    Level.FAIL: '<span class="fail">✗ fails</span>',
}


def _cell(value: Cell) -> str:
    if value is None:
        return "–"
    if isinstance(value, Level):
        return _LEVELS[value]
    if isinstance(value, bool):
        return '<span class="pass">✓ passes</span>' if value else '<span class="fail">✗ fails</span>'
    text = value if isinstance(value, str) else number(value)
    return _words(text.replace(" ", "\N{NO-BREAK SPACE}") if len(text) < SHORT else text)


def _words(text: str) -> str:
    """Text as HTML with the minus of numbers as print sets it, and what stands in backticks as code."""
    return re.sub("`([^`]+)`", r"<code>\1</code>", escape(re.sub(r"(?<![\w.])-(?=\d)", "−", text)))


def _table(table: Table, n: int) -> str:
    numeric = [_is_numeric(table, i) for i in range(len(table.columns))]
    head = "".join(_heading(column, right) for column, right in zip(table.columns, numeric))
    labels = [escape(f"{c.label}, {c.unit}" if c.unit else c.label) for c in table.columns]
    rows = []
    for row in table.rows:
        cells = "".join(map(_table_cell, row, numeric, labels))
        failed = Level.FAIL in row or any(value is False for value in row)
        rows.append(f"<tr{' class=failed' if failed else ''}>{cells}</tr>")
    stacks = " class=stacks" if len(table.columns) > 3 else ""  # a phone sets the cells of a row one under another
    return (
        f'<div class="scroll"><table{stacks}><caption><b>Table {n}</b>{escape(table.caption)}</caption>'
        f"<thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table></div>"
    )


def _table_cell(value: Cell, right: bool, label: str) -> str:
    kinds = [word for word, applies in (("n", right), ("void", value is None or value == "")) if applies]
    style = f' class="{" ".join(kinds)}"' if kinds else ""
    return f'<td{style} data-label="{label}">{_cell(value)}</td>'


def _is_numeric(table: Table, i: int) -> bool:
    """A column of numbers (and blanks, and lives without end) is set right."""
    cells = [row[i] for row in table.rows if row[i] not in (None, UNLIMITED)]
    return bool(cells) and all(isinstance(c, (int, float)) and not isinstance(c, bool) for c in cells)


def _heading(column: Column, right: bool) -> str:
    unit = f" <small>{escape(column.unit)}</small>" if column.unit else ""
    return f"<th{' class=n' if right else ''}>{escape(column.label)}{unit}</th>"


def _cost(cost: Cost, n: int) -> str:
    most = max((seconds for _, seconds in cost.computed), default=0.0) or 1.0
    total = sum(seconds for _, seconds in cost.computed)
    rows = "".join(
        f'<tr><td>{escape(name)}</td><td class="n">{number(seconds, 3)}</td>'
        f'<td class="bar"><span style="width:{100.0 * seconds / most:.1f}%"></span></td></tr>'
        for name, seconds in sorted(cost.computed, key=lambda item: -item[1])
    )
    skipped = f"<p>Not asked for, so not computed: {escape(', '.join(cost.skipped))}.</p>" if cost.skipped else ""
    return (
        f'<div class="scroll"><table><caption><b>Table {n}</b>What was computed, {number(total, 3)} s in all</caption>'
        '<thead><tr><th>Product</th><th class="n">Time <small>s</small></th><th></th></tr></thead>'
        f"<tbody>{rows}</tbody></table></div>{skipped}"
    )
