"""The part drawing of every cam kind: nothing outside its frame, no words over words, true scale, PDF like SVG."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from pypdf import PdfReader

import camgeom
from camgeom.drawing.paper import POINT, Paper, advance, hatching, pdf
from camgeom.drawing.shapes import Dot, Lines, Words
from camgeom.drawing.sheet import overlap, text_box
from camgeom.errors import DesignError, ExportError
from camgeom.model import Model, read
from camgeom.report.files import format_rows
from camgeom.report.part_sheet import BOTTOM, LEFT, RIGHT, TOP, _plan, part_sheet, rows
from camgeom.report.sections.design import part_views
from camgeom.report.table_sheet import columns
from tests.places import PROFILES
from tests.reference.planar_machines import flat
from tests.reference.profiles import built, data_of

NAMES = ["pin_insertion", "disc_offset_roller", "conjugate_rocker", "constant_width_press", "barrel_indexer"]


@cache
def sheet(name: str) -> Paper:
    return part_sheet(read(str(PROFILES / f"{name}.toml")))


def boxes(paper: Paper):
    return [
        (text_box(shape.x, shape.y, shape.text, shape.anchor, shape.size), shape.text)
        for shape in paper.shapes
        if isinstance(shape, Words) and shape.text.strip()
    ]


@pytest.mark.parametrize("name", NAMES)
def test_no_words_over_words_and_nothing_outside_the_frame(name: str) -> None:
    paper = sheet(name)
    found = boxes(paper)
    for k, (box, text) in enumerate(found):
        assert box[0] >= LEFT, text
        assert box[2] <= RIGHT, text
        assert box[1] >= TOP, text
        assert box[3] <= BOTTOM, text
        for other, words in found[k + 1 :]:
            assert overlap(box, other) < 0.15, (text, words)
    for shape in paper.shapes:
        if isinstance(shape, Lines) and shape.lines:
            points = np.concatenate(shape.lines)
            assert points.min(axis=0) == pytest.approx(np.maximum(points.min(axis=0), (LEFT, TOP)), abs=0.05)
            assert points.max(axis=0) == pytest.approx(np.minimum(points.max(axis=0), (RIGHT, BOTTOM)), abs=0.05)


@pytest.mark.parametrize(("name", "size"), [("pin_insertion", 134.0), ("barrel_indexer", 130.0)])
def test_the_views_are_at_the_stated_scale(name: str, size: float) -> None:
    paper = sheet(name)
    words = [shape.text for shape in paper.shapes if isinstance(shape, Words)]
    ratio = words[words.index("Scale") + 1]
    over, under = (float(part) for part in ratio.split(":"))
    heights = [
        float(np.ptp(np.concatenate(shape.lines)[:, 1]))
        for shape in paper.shapes
        if isinstance(shape, Lines) and shape.style == "d-cut"
    ]
    assert max(heights) == pytest.approx(size * over / under, abs=0.15)


def test_parameters_carry_their_units() -> None:
    found = dict(rows(read(str(PROFILES / "pin_insertion.toml"))))
    assert found["cam diameter"] == "134 mm"
    assert found["155 to 215°"] == "to 37 mm, cycloidal"
    assert found["friction"] == "8.3 N"
    turret = dict(rows(read(str(PROFILES / "tool_changer.toml"))))
    assert turret["friction"].endswith("N mm")
    assert turret["follower inertia"] == "1.1 kg m²"


def drawn_on(paper: Paper) -> tuple[float, float]:
    """Width of a sheet and the scale it states."""
    over, under = (float(part) for part in said(paper)[said(paper).index("Scale") + 1].split(":"))
    return paper.width, over / under


def with_rim() -> Model:
    """Grooves in both faces of a plate whose rim is a profile: four views."""
    data = data_of("both_faces_disc", cam__diameter=None, cam__rim="profile")
    rim = {"angle": 250.0, "cam": {"form": "external", "base_radius": 105.0}, "follower": {"kind": "translating",
           "mass": 1.0}, "roller": {"diameter": 30.0, "length": 25.0}, "motion": data["track"][0]["motion"],
           "operation": {"friction": 10.0, "spring_preload": 300.0, "spring_rate": 4.0}}  # fmt: skip
    return built(data | {"track": [*data["track"], rim]})


@pytest.mark.parametrize(
    ("made", "wide", "scale"),
    [("both_faces_disc", 420.0, 0.4), (with_rim, 841.0, 0.5), ("two_groove_drum", 420.0, 0.5),
     ("bell_lifter", 420.0, 0.5), ("linear_groove", 420.0, 0.5), ("conical_pair", 420.0, 0.5)],
)  # fmt: skip
def test_a_part_fills_its_place_on_the_sheet(made: str | Callable[[], Model], wide: float, scale: float) -> None:
    """Two faces stood at 1:5, and with a rim at 1:100, where captions alone filled the sheet."""
    model = read(str(PROFILES / f"{made}.toml")) if isinstance(made, str) else made()
    paper = part_sheet(model)
    assert drawn_on(paper) == (wide, scale)
    cut = [np.concatenate(shape.lines) for shape in paper.shapes if isinstance(shape, Lines) and shape.style == "d-cut"]
    reach = 2.0 * float(np.hypot(*model.solids[0].mesh.vertices[:, :2].T).max())
    if model.mechanism.carriage is None:
        assert max(float(np.ptp(points[:, 1])) for points in cut) > 0.9 * scale * reach
    found = boxes(paper)
    for k, (box, text) in enumerate(found):
        assert box[2] <= wide - 10.0, text
        assert all(overlap(box, other) < 0.15 for other, _ in found[k + 1 :]), text


def test_a_sheet_is_larger_only_where_views_would_be_small_or_parameters_unread() -> None:
    views = part_views(model := with_rim(), tuple((solid.name, solid.mesh) for solid in model.solids))
    for count, wide in ((33, 420.0), (34, 594.0), (90, 594.0), (91, 841.0)):
        assert _plan(views[:2], count).form.width == wide
    assert [_plan(views[:k], 20).form.width for k in (2, 3, 4)] == [420.0, 594.0, 841.0]


def test_parameters_have_the_load_of_every_track() -> None:
    found = dict(rows(with_rim()))
    assert found["friction"] == "9000 N mm"
    assert (found["track 2 friction"], found["track 3 friction"]) == ("140 N", "10 N")
    assert (found["track 3 spring preload"], found["track 3 spring rate"]) == ("300 N", "4 N/mm")
    assert "track 2 spring preload" not in found


@pytest.mark.parametrize("name", NAMES[:2])
def test_pdf_and_svg_show_the_same(tmp_path: Path, name: str) -> None:
    model = read(str(PROFILES / f"{name}.toml"))
    for extension in ("svg", "pdf"):
        size = camgeom.write(model, tmp_path / f"cam.sheet.{extension}")
        assert size == (tmp_path / f"cam.sheet.{extension}").stat().st_size
    root = ET.parse(tmp_path / "cam.sheet.svg").getroot()
    assert (root.get("width"), root.get("height")) == ("420mm", "297mm")
    shown = {text.text for text in root.iter("{http://www.w3.org/2000/svg}text")}
    reader = PdfReader(tmp_path / "cam.sheet.pdf")
    (page,) = reader.pages
    assert [float(v) / POINT for v in page.mediabox[2:]] == pytest.approx([420.0, 297.0], abs=0.01)
    assert reader.metadata.title == model.profile.name
    text = page.extract_text()
    for words in (model.profile.name, "Parameters", "Scale", "A3", "Motion over one turn"):
        assert words in text
        assert any(words in one for one in shown)


def test_the_pdf_is_sound_to_the_byte() -> None:
    paper = Paper(100.0, 50.0, "a (b) \\ ⌀")
    paper.words(10.0, 10.0, "(⌀ 12,5 °) \\ − ≥")
    paper.lines("rule", [(0.0, 0.0), (100.0, 50.0)])
    paper.shapes.append(Dot("dot", (50.0, 25.0), 2.0))
    data = pdf(paper)
    assert data == pdf(paper)
    places = [int(m[1]) for m in re.finditer(rb"(\d{10}) 00000 n", data)]
    assert all(data[place:].startswith(f"{k} 0 obj".encode()) for k, place in enumerate(places, start=1))
    reader = PdfReader(BytesIO(data), strict=True)
    assert reader.pages[0].extract_text().strip() == "(Ø 12,5 °) \\ - >="
    assert reader.metadata.title == "a (b) \\ Ø"


def test_widths_are_those_of_the_face() -> None:
    assert advance("Hamburg", 1000.0) == 722 + 556 + 833 + 556 + 556 + 333 + 556
    assert advance("−1", 10.0) == advance("-1", 10.0)


def test_hatching_stays_inside_and_out_of_holes() -> None:
    square = np.array([[0.0, 0.0], [40.0, 0.0], [40.0, 40.0], [0.0, 40.0]])
    hole = np.array([[10.0, 10.0], [10.0, 30.0], [30.0, 30.0], [30.0, 10.0]])
    lines = hatching((square, hole), 2.0)
    length = sum(float(np.hypot(*(line[1] - line[0]))) for line in lines)
    assert length * 2.0 == pytest.approx(40.0**2 - 20.0**2, rel=0.05)
    for line in lines:
        middle = line.mean(axis=0)
        assert np.all((middle >= 0.0) & (middle <= 40.0))
        assert not np.all((middle > 10.0) & (middle < 30.0))


def test_a_folded_cam_is_refused_with_the_file(tmp_path: Path) -> None:
    path = tmp_path / "cam.sheet.pdf"
    path.write_text("old")
    folded: Model = flat(cam="base_radius = 5\nbore = 4")
    with pytest.raises((ExportError, DesignError), match=r"cam\.sheet\.pdf: .*folds"):
        camgeom.write(folded, path)
    assert path.read_text() == "old"


def test_the_formats_are_listed_with_their_use() -> None:
    found = {row["format"]: row for row in format_rows()}
    assert {"stl", "step", "dxf", "cmm.csv", "ecam.csv", "plcopen.xml", "sheet.svg", "sheet.pdf", "png"} <= set(found)
    assert found["outline.csv"]["cams"] == "planar cams"
    assert all(row["about"] and row["cams"] for row in found.values())


def said(paper: Paper) -> list[str]:
    return [shape.text for shape in paper.shapes if isinstance(shape, Words)]


def test_the_title_block_says_what_the_profile_gives() -> None:
    block = {"drawing.number": "C-1042", "drawing.revision": "B7", "drawing.author": "J. Weber"}
    model = camgeom.read(PROFILES / "disc_offset_roller.toml")
    plain, told = said(part_sheet(model)), said(part_sheet(model.with_({**block, "material.cam.hardness": 60})))
    for text in (*block.values(), "60 HRC"):
        assert text in told
        assert text not in plain
    with pytest.raises(camgeom.ProfileError, match="unknown key"):
        model.with_({"drawing.numbr": "1"})
    with pytest.raises(camgeom.ProfileError, match=r"drawing\.number"):
        model.with_({"drawing.number": "x" * 41})


def test_a_keyway_is_dimensioned_where_there_is_one() -> None:
    model = camgeom.read(PROFILES / "disc_offset_roller.toml")
    assert {"6", "22.8"} <= set(said(part_sheet(model)))  # its width, and its floor to the far wall
    bare = model.with_({"cam.keyway_width": None, "cam.keyway_depth": None})
    assert not {"6", "22.8"} & set(said(part_sheet(bare)))


def test_a_part_drawing_shows_the_part_alone_at_the_largest_scale() -> None:
    words = {text for _, text in boxes(sheet("barrel_indexer"))}
    assert not {shape.style for shape in sheet("barrel_indexer").shapes} & {"d-ghost"}
    assert not any(text.startswith("roller ⌀") or text in ("pivot", "turret axis") for text in words)
    assert {"1:1", "12", "43.3", "⌀ 130"} <= words  # the drum, its keyway's width and its depth over the bore


def test_both_discs_of_a_pair_have_a_section_with_their_own_sizes() -> None:
    model = read(str(PROFILES / "conjugate_rocker.toml"))
    views = part_views(model, tuple((solid.name, solid.mesh) for solid in model.solids))
    assert [view.caption.partition(",")[0] for view in views[1:]] == ["Main disc", "Return disc"]
    for view, solid in zip(views[1:], model.solids, strict=True):
        wide, tall = np.ptp(solid.mesh.vertices[:, :2], axis=0).tolist()
        texts = [dimension.text for dimension in view.dimensions]
        assert texts[:2] == [f"{wide:.5g}", f"{tall:.5g}"]
        assert texts[2:] == ["18", "64.4"]
    assert [dimension.text for dimension in views[0].dimensions if dimension.side == "below"] == ["44", "20", "20"]


@pytest.mark.parametrize("name", ["conjugate_rocker", "pin_insertion", "disc_flat_face"])
def test_the_table_has_every_degree_of_the_profile(tmp_path: Path, name: str) -> None:
    model = read(str(PROFILES / f"{name}.toml"))
    found = {label: values for label, _, values in columns(model)}
    assert found["cam"].tolist() == list(range(360))
    lift = found["position" if model.profile.rotating else "lift"]
    assert lift.max() == pytest.approx(max(s.to for s in model.profile.motion if s.to is not None), abs=1e-6)
    if model.planar is None:
        assert np.allclose(found["groove z"] - lift, model.profile.stated["cam"]["start"])
    else:
        polar = np.radians(found["main at" if "main at" in found else "at"])
        radius = found["main R" if "main R" in found else "R"]
        mesh = model.solids[0].mesh
        rim = mesh.vertices[np.unique(mesh.faces[mesh.group_faces("flank")])]
        rim = rim[rim[:, 2] == rim[0, 2], :2]
        rim = rim[np.argsort(np.arctan2(rim[:, 1], rim[:, 0]))]
        spots = np.stack([radius * np.cos(polar), radius * np.sin(polar)], axis=-1)[:, None, :]
        along = np.roll(rim, -1, axis=0) - rim
        share = ((spots - rim) * along).sum(axis=2) / np.maximum((along**2).sum(axis=1), 1e-30)
        away = np.linalg.norm(spots - rim - np.clip(share, 0.0, 1.0)[..., None] * along, axis=2).min(axis=1)
        assert away.max() < 1.01 * model.tolerance  # the chords of the mesh stand back
    assert camgeom.write(model, tmp_path / "cam.table.pdf") > 10_000
    text = PdfReader(tmp_path / "cam.table.pdf").pages[0].extract_text()
    assert model.profile.name in text
    assert "359" in text


def test_the_table_of_several_grooves_has_each_of_them() -> None:
    model = read(str(PROFILES / "two_groove_drum.toml"))
    found = {label: values for label, _, values in columns(model)}
    for number, start, stroke in ((1, 24.0, 46.0), (2, 102.0, 18.0)):
        z = found[f"groove {number} z"]
        assert (z.min(), np.ptp(z)) == pytest.approx((start, stroke))
        assert f"at {number}" in found
    # Half way from 20 to 80 deg of its own.
    assert found["groove 2 z"][50] == pytest.approx(102.0 + 9.0)


def test_the_table_of_both_faces_has_each_groove_and_an_end_wall_is_no_groove() -> None:
    """The lower face's groove was left out in silence; an end wall's roller stood there as a groove."""
    model = read(str(PROFILES / "both_faces_disc.toml"))
    found = {label: values for label, _, values in columns(model)}
    for number, base, roller in ((1, 52.0, 22.0), (2, 58.0, 19.0)):
        assert found[f"groove {number} R"].min() == pytest.approx(base + 0.5 * roller)
    # The second follower slides along X: its groove's middle is as far out as it stands.
    assert found["groove 2 R"].max() == pytest.approx(58.0 + 9.5 + 20.0)
    assert found["at 2"][90] == pytest.approx(270.0)
    ring = {label: values for label, _, values in columns(read(str(PROFILES / "end_face_lifter.toml")))}
    assert np.allclose(ring["roller z"] - ring["lift"], 42.0 + 12.0)
    assert not [label for label in ring if "groove" in label]


def test_a_long_entry_of_the_title_block_is_set_smaller_before_it_is_cut() -> None:
    treatment = "carburised, case 0.9 + 0.2 mm"
    made = part_sheet(read(str(PROFILES / "disc_offset_roller.toml")).with_(drawing={"treatment": treatment}))
    (shown,) = [shape for shape in made.shapes if isinstance(shape, Words) and shape.text == treatment]
    assert 1.8 <= shown.size < 2.7
