"""The report page: complete, closed to the network, deaf to markup in names, and no label over another."""

from __future__ import annotations

import hashlib
import re
from html.parser import HTMLParser
from xml.etree import ElementTree

import numpy as np
import pytest

from camgeom.drawing.content import Chapter, Chart, Column, Drawing, Leader, Level, Map, Page, Path, Polar, Table
from camgeom.drawing.plots import NARROW, WIDE
from camgeom.drawing.shapes import Dot
from camgeom.drawing.sheet import overlap
from camgeom.report.page import render, sheet
from tests.places import ROOT
from tests.report import demo as report_demo

PLOTS = [
    b for section in report_demo.page().sections for b in section.blocks if isinstance(b, Chart | Map | Polar | Drawing)
]
VOID = {"meta", "br", "img", "input", "link"}


class _Reader(HTMLParser):
    """Collects tags and text and checks that elements close in order."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.feed(html)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if "script" not in self.open and "style" not in self.open:
            self.text.append(data)


@pytest.fixture(scope="module")
def html() -> str:
    return render(report_demo.page())


def test_page_is_well_formed_and_has_every_section(html: str) -> None:
    reader = _Reader(html)
    assert reader.open == []
    anchors = {attrs.get("id") for tag, attrs in reader.tags if tag == "section"}
    assert anchors == {"verdict", *(section.key for section in report_demo.page().sections)}


def test_verdict_comes_first_and_shows_failures_with_advice(html: str) -> None:
    text = " ".join(_Reader(html).text)
    verdict, advice, drawing = (text.index(s) for s in ("Fails 1 of 3 checks", "Lengthen the rise", "Plate cam at"))
    assert verdict < advice < drawing


def test_markup_in_text_does_nothing(html: str) -> None:
    tags = _Reader(html).tags
    assert not [tag for tag, attrs in tags if tag == "b" and attrs]
    assert not [attrs for _, attrs in tags if any(name.startswith("on") for name in attrs)]
    assert len([tag for tag, _ in tags if tag == "script"]) == 3  # the scene's data, the page's script, the viewer


@pytest.mark.parametrize(
    "evil", ["</style><script>x()</script>", "</title><b>", '";} body{display:none} "', "\\", "\N{SNOWMAN}'&amp;"]
)
def test_title_escapes_in_head_style_and_body(evil: str) -> None:
    reader = _Reader(render(Page(evil, evil, None, evil, details=((evil, evil),))))
    assert [tag for tag, _ in reader.tags].count("script") == 1
    assert [tag for tag, _ in reader.tags].count("b") == 0
    assert sum(evil in text for text in reader.text) == 6  # title, heading, kind, summary and the detail twice


def test_page_asks_the_network_for_nothing(html: str) -> None:
    for _, attrs in _Reader(html).tags:
        for name in ("src", "href", "action", "data"):
            assert (attrs.get(name) or "#").startswith(("#", "data:"))
    assert "default-src 'none'" in html
    assert set(re.findall(r"url\([^)]*\)", html.split("<body>")[0])) == {"url(#hatch)"}
    assert "@import" not in html


def test_viewer_is_carried_only_by_a_page_with_a_scene(html: str) -> None:
    plain = render(Page("p", "k", Level.PASS, sections=(Chapter("motion", "Motion", (report_demo.motion(),)),)))
    assert len(plain) < 120_000
    assert len(html) < 3_000_000
    assert "three.js" in html
    assert "three.js" not in plain


@pytest.mark.parametrize("width", [WIDE, NARROW, 300.0])
@pytest.mark.parametrize("plot", PLOTS, ids=lambda plot: plot.caption)
def test_labels_keep_clear_of_each_other_and_inside(plot: Chart | Map | Polar | Drawing, width: float) -> None:
    drawn = sheet(plot, width)
    for i, (box, text) in enumerate(drawn.words):
        assert box[0] > -1.5, text
        assert box[2] < drawn.width + 1.5, text
        assert box[1] > -1.5, text
        assert box[3] < drawn.height + 1.5, text
        for other, words in drawn.words[i + 1 :]:
            assert overlap(box, other, -1.5) < 30.0, (text, words)
    ElementTree.fromstring(drawn.render(plot.caption))


def test_every_number_in_the_page_is_finite(html: str) -> None:
    assert not re.search(r'(?:[">, ])(nan|inf)\b', html.split("<main>")[1].split('<script type="application/json">')[0])


def test_repeated_rendering_is_the_same(html: str) -> None:
    assert render(report_demo.page()) == html


def test_vendored_viewer_is_built_from_the_sources_here() -> None:
    root = ROOT
    assets = root / "camgeom" / "report" / "assets"
    bundle = (assets / "viewer.js").read_text(encoding="utf-8")
    sources = sorted((root / "scripts" / "viewer" / "src").iterdir())
    digest = hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    assert digest in bundle[:400], "run `npm ci && npm run build` in scripts/viewer"
    assert "MIT" in (assets / "viewer.LICENSE.txt").read_text(encoding="utf-8")
    assert "</script" not in bundle.lower()
    assert len(bundle) < 700_000


def test_numbers_have_the_minus_of_print_and_backticks_are_code() -> None:
    row = ("y = -43.3, a range 3-5, 1e-9, law 3-4-5", "-50 %", "at `length` or `a<b>`")
    table = Table("T", (Column("A"), Column("B"), Column("C")), (row,))
    text = render(Page("t", "k", None, sections=(Chapter("c", "C", (table,)),)))
    assert "y = −43.3, a range 3-5, 1e-9, law 3-4-5" in text
    assert "−50" in text
    assert "at <code>length</code> or <code>a&lt;b&gt;</code>" in text


def test_notes_at_one_place_of_a_narrow_drawing_stand_beside_each_other() -> None:
    leaders = (Leader((5.0, 5.0), "one"), Leader((5.2, 5.0), "two"), Leader((5.0, 5.2), "three"))
    box = Path(np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]]), closed=True)
    made = sheet(Drawing("d", (box,), leaders=leaders), NARROW)
    at = [shape.centre for shape in made.shapes if isinstance(shape, Dot) and shape.style == "balloon"][::2]
    apart = [np.hypot(a[0] - b[0], a[1] - b[1]) for k, a in enumerate(at) for b in at[k + 1 :]]
    assert min(apart) >= 2.0 * 8.0
