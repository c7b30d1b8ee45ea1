"""The plotter's parts: ticks, numbers, line thinning, lines of equal value, colour scales, packed scenes."""

from __future__ import annotations

import gzip
import json
import struct
import zlib
from base64 import b64decode

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from camgeom.drawing.colours import picture, scale
from camgeom.drawing.content import (
    CAM_ANGLE,
    Actor,
    Axis,
    Chart,
    Limit,
    Map,
    Mark,
    Panel,
    Scene,
    Series,
    Shade,
    Zone,
)
from camgeom.drawing.maps import isolines, map_sheet
from camgeom.drawing.plots import chart_sheet, spread
from camgeom.drawing.shapes import Rectangle, Segments, Words
from camgeom.drawing.sheet import number, outside, overlap, straightened, text_box, thin_line, ticks
from camgeom.maths.mesh import Mesh
from camgeom.report.scene import scene_json
from tests.report import demo as report_demo

finite = st.floats(-1e9, 1e9, allow_nan=False)


@given(finite, st.floats(1e-6, 1e9), st.integers(2, 12))
def test_ticks_are_round_rising_and_cover_the_range(low: float, span: float, count: int) -> None:
    span = max(span, 2e-7 * abs(low))
    found = ticks(low, low + span, count)
    assert found.low <= low + 1e-6 * span
    assert found.high >= low + span * (1.0 - 1e-6)
    assert 2 <= len(found.at) <= 2.6 * count + 3
    assert np.all(np.diff(found.at) > 0.0)


@given(st.floats(-1e5, 1e5), st.floats(1e-2, 1e5), st.integers(2, 12))
def test_tick_texts_say_the_tick(low: float, span: float, count: int) -> None:
    found = ticks(low, low + span, count)
    step = float(found.at[1] - found.at[0])
    for value, text in zip(found.at, found.texts):
        said = float(text.replace("−", "-").replace("\N{NARROW NO-BREAK SPACE}", "")) * 10.0**found.exponent
        assert abs(said - value) < 1e-3 * step + 1e-9 * abs(value)


@given(st.floats(1e-12, 1e12) | st.floats(-1e12, -1e-12))
def test_numbers_keep_four_digits(value: float) -> None:
    text = number(value).replace("−", "-").replace("\N{NARROW NO-BREAK SPACE}", "")
    text = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")).replace(" × 10", "e")
    assert abs(float(text) - value) <= 0.5001e-3 * abs(value)


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (-0.0, "0"), (float("inf"), "unbounded"), (float("nan"), "not defined"), (9999.96, "10\u202f000"),
     (0.1, "0.1"), (12, "12"), (1234567, "1\u202f234\u202f567"), (-3.5, "−3.5")],
)  # fmt: skip
def test_numbers_at_the_edges(value: float, text: str) -> None:
    assert number(value) == text


def test_thinned_line_keeps_every_peak_to_a_tenth_of_a_pixel() -> None:
    x = np.linspace(0.0, 700.0, 200_001)
    y = 100.0 + 80.0 * np.sin(0.3 * x) * np.exp(-x / 300.0)
    thin = thin_line(x, y)
    assert len(thin) < 5000
    assert abs(thin[:, 1].max() - y.max()) < 0.1
    assert abs(thin[:, 1].min() - y.min()) < 0.1
    off = np.abs(np.interp(x, thin[:, 0], thin[:, 1]) - y)
    slope = np.abs(np.gradient(y, x))
    assert np.all(off < 0.2 + 1.05 * slope)  # within the pixel column it stands for


def test_thinning_keeps_a_jump() -> None:
    x = np.array([0.0, 10.0, 10.0, 20.0])
    assert np.array_equal(thin_line(x, np.array([0.0, 0.0, 50.0, 50.0]))[:, 1], [0.0, 0.0, 50.0, 50.0])


@given(
    st.lists(st.tuples(st.integers(0, 40), st.integers(0, 40)), min_size=1, max_size=60),
    st.sampled_from([0.0, 0.5, 3.0]),
)
def test_a_straightened_line_is_that_of_the_recursion(places: list[tuple[int, int]], tolerance: float) -> None:
    xy = np.array(places, dtype=float)

    def inner(first: int, last: int) -> list[int]:
        chord, away = xy[last] - xy[first], xy[first + 1 : last] - xy[first]
        length = float(np.hypot(*chord))
        across = np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0])
        distance = across / length if length > 0.0 else np.hypot(*away.T)
        if last - first < 2 or distance.max() <= tolerance:
            return []
        middle = first + 1 + int(np.argmax(distance))
        return [*inner(first, middle), middle, *inner(middle, last)]

    kept = sorted({0, *inner(0, len(xy) - 1), len(xy) - 1})
    assert np.array_equal(straightened(xy, tolerance), xy[kept])


def test_isoline_of_a_paraboloid_is_its_circle() -> None:
    x, y = np.linspace(-2.0, 2.0, 161), np.linspace(-1.5, 1.5, 121)
    values = x[None, :] ** 2 + y[:, None] ** 2
    segments = isolines(x, y, values, 1.0)
    radius = np.hypot(segments[..., 0], segments[..., 1])
    assert np.max(np.abs(radius - 1.0)) < 0.025**2  # chord of the linear edge, h^2 / 8 times the curvature
    length = np.hypot(*(segments[:, 1] - segments[:, 0]).T).sum()
    assert abs(length - 2.0 * np.pi) < 2e-3


def test_lines_of_a_map_reach_its_edge_and_their_numbers_cover_no_words_and_no_crowd_of_lines() -> None:
    x, y = np.linspace(0.5, 359.5, 360), np.linspace(1.0, 19.0, 10)
    values = 100.0 / (1.0 + np.exp(-(x[None, :] - 180.0 - y[:, None]) / 4.0))  # all lines within a few degrees
    mark = Mark(185.0, 10.0, "100 MPa")
    chart = Map("steep", CAM_ANGLE, Axis("Along", "mm"), Axis("Pressure", "MPa"), x, y, values, marks=(mark,))
    sheet = map_sheet(chart, 820.0)
    lines = [shape.ends for shape in sheet.shapes if isinstance(shape, Segments) and shape.style == "iso"]
    heights = np.concatenate(lines)[:, :, 1]
    frame = next(shape.box for shape in sheet.shapes if isinstance(shape, Rectangle) and shape.style == "frame")
    assert (heights.min(), heights.max()) == pytest.approx((frame[1], frame[3]))
    on_map = [shape for shape in sheet.shapes if isinstance(shape, Words) and shape.style == "on-map"]
    assert "100 MPa" in [shape.text for shape in on_map]
    found = [(text_box(one.x, one.y, one.text, one.anchor, one.size), one.text) for one in on_map]
    for k, (box, text) in enumerate(found):
        assert all(overlap(box, other) == 0.0 for other, _ in found[k + 1 :]), text


def test_isolines_stop_at_blank_cells_and_split_saddles() -> None:
    values = np.array([[1.0, 0.0], [0.0, 1.0]])
    at = np.array([0.0, 1.0])
    assert len(isolines(at, at, values, 0.4)) == 2
    assert len(isolines(at, at, values, 0.6)) == 2
    assert len(isolines(at, at, np.array([[1.0, np.nan], [0.0, 1.0]]), 0.5)) == 0
    assert len(isolines(at, at, values, 2.0)) == 0


def _lightness(table: np.ndarray) -> np.ndarray:
    linear = np.where(table <= 10.31, table / 255.0 / 12.92, ((table / 255.0 + 0.055) / 1.055) ** 2.4)
    return linear @ np.array([0.2126, 0.7152, 0.0722])


def test_scales_read_in_greyscale() -> None:
    light = _lightness(scale().astype(float))
    assert np.all(np.diff(light) >= 0.0)
    assert np.all(light[2:] > light[:-2])  # two steps of the table are told apart even after rounding to 8 bits
    assert light[-1] / light[0] > 15.0
    signed = _lightness(scale(diverging=True).astype(float))
    assert np.argmax(signed) in range(120, 137)
    assert signed[0] < 0.5 * signed[-1]  # below zero is the darker end


def test_picture_is_a_png_with_the_array_upside_down_and_blanks_clear() -> None:
    data = b64decode(picture(np.array([[0.0, 1.0], [np.nan, 0.5]]), 0.0, 1.0, False).partition(",")[2])
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(data):
        (length,) = struct.unpack(">I", data[at : at + 4])
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + length]
        assert struct.unpack(">I", data[at + 8 + length : at + 12 + length])[0] == zlib.crc32(kind + body)
        chunks[kind] = body
        at += 12 + length
    assert zlib.decompress(chunks[b"IDAT"]) == bytes([0, 255, 127, 0, 0, 254])
    assert chunks[b"tRNS"][255] == 0
    assert set(chunks[b"tRNS"][:255]) == {255}


def test_spread_labels_keep_distance_order_and_room() -> None:
    at = spread(np.array([10.0, 11.0, 12.0, 90.0]), 15.0, 0.0, 100.0)
    assert np.all(np.diff(at) >= 15.0 - 1e-9)
    assert at[3] == pytest.approx(90.0)
    assert np.all(spread(np.array([95.0, 99.0]), 15.0, 0.0, 100.0) <= 100.0)


def test_lines_that_cannot_be_drawn_are_refused() -> None:
    x = np.arange(3.0)
    with pytest.raises(ValueError, match="not finite"):
        Series("s", x, np.array([0.0, np.nan, 1.0]))
    with pytest.raises(ValueError, match="not one line"):
        Series("s", x, np.arange(4.0))
    with pytest.raises(ValueError, match="do not fit"):
        Map("m", Axis("x"), Axis("y"), Axis("v"), x, x, np.zeros((2, 3)))
    with pytest.raises(ValueError, match="no finite"):
        Map("m", Axis("x"), Axis("y"), Axis("v"), x, x, np.full((3, 3), np.nan))


@pytest.mark.parametrize("y", [[0.0, 0.0], [5.0, 5.0], [1e-30, 2e-30], [1e12, -1e12]])
def test_flat_tiny_and_huge_lines_are_drawn(y: list[float]) -> None:
    chart = Chart("c", Axis("x"), (Panel(Axis("y"), (Series("s", np.array([0.0, 1.0]), np.array(y)),)),))
    assert "NaN" not in chart_sheet(chart, 400.0).render("c")


@pytest.mark.parametrize("width", [820.0, 370.0, 300.0])
def test_crowded_charts_keep_their_labels_apart(width: float) -> None:
    rng = np.random.default_rng(7)
    x = np.linspace(0.0, 360.0, 200)
    for _ in range(40):
        panels = []
        for _ in range(rng.integers(1, 4)):
            size, lift = 10.0 ** rng.integers(-9, 10), rng.choice([0.0, 3.0, 100.0])
            waves = [size * (np.sin(x / rng.uniform(5.0, 90.0) + k) + lift) for k in range(rng.integers(1, 4))]
            lines = tuple(Series("line " + "x" * int(rng.integers(1, 18)), x, y) for y in waves)
            ends = [(y, i) for y in waves for i in {int(np.argmax(y)), int(np.argmin(y))}]
            marks = tuple(Mark(float(x[i]), float(y[i]), f"{number(float(y[i]))} at {x[i]:.0f}°") for y, i in ends)
            limits = (Limit(float(size * rng.uniform(-2.0, 2.0)), "limit 12"),) if rng.random() < 0.5 else ()
            panels.append(Panel(Axis("Quantity of a longer name", "N m/rad"), lines, limits=limits, marks=marks))
        axis = CAM_ANGLE if rng.random() < 0.5 else Axis("x", "mm")
        drawn = chart_sheet(
            Chart("c", axis, tuple(panels), (Zone(0.0, 60.0, "dwell"), Zone(90.0, 94.0, "dwell"))), width
        )
        for i, (box, text) in enumerate(drawn.words):
            assert outside(box, (-1.5, -1.5, width + 1.5, drawn.height + 1.5)) == 0.0, text
            assert [t for b, t in drawn.words[i + 1 :] if overlap(box, b, -1.5) > 30.0] == [], text


@pytest.mark.parametrize("top", [18.0, 21.0, 24.0, 27.0])
def test_a_mark_keeps_off_the_line_of_a_limit(top: float) -> None:
    x = np.linspace(0.0, 360.0, 361)
    line = Series("angle", x, top * np.sin(np.radians(x)) ** 2)
    panel = Panel(Axis("Pressure angle", "°", zero=True), (line,), limits=(Limit(30.0, "limit 30°"),),
                  marks=(Mark(90.0, top, "the largest of all"),))  # fmt: skip
    drawn = chart_sheet(Chart("c", CAM_ANGLE, (panel,)), 820.0)
    (limit,) = [box for box, text in drawn.words if text == "limit 30°"]
    (mark,) = [box for box, text in drawn.words if text == "the largest of all"]
    (at,) = {float(y) for part in drawn.shapes if isinstance(part, Segments) and part.style == "limit"
             for y in np.ravel(part.ends[..., 1])}  # fmt: skip
    assert not limit[1] < at < limit[3]
    assert not mark[1] < at < mark[3]


def _unpack(text: str, kind: str) -> np.ndarray:
    planes = np.frombuffer(gzip.decompress(b64decode(text)), np.uint8)
    size = np.dtype(kind).itemsize
    return planes.reshape(size, -1).T.copy().view(kind).ravel()


def test_packed_scene_gives_the_mechanism_back() -> None:
    scene = report_demo.scene()
    data = json.loads(scene_json(scene))
    for body, packed in zip(scene.bodies, data["bodies"]):
        codes = np.cumsum(_unpack(packed["vertices"], "<u2").reshape(3, -1).T, axis=0, dtype=np.uint16)
        vertices = codes / 65535.0 * packed["size"] + packed["low"]
        assert np.max(np.abs(vertices - body.mesh.vertices)) <= 0.5001 * max(packed["size"]) / 65535.0
        faces = np.cumsum(_unpack(packed["faces"], "<u4").reshape(3, -1).T, axis=0, dtype=np.uint32)
        assert np.array_equal(faces, body.mesh.faces)
        assert body.poses is not None
        poses = _unpack(packed["poses"], "<f4").reshape(-1, 7)
        assert np.allclose(_rotation(poses[:, :4]), body.poses[:, :, :3], atol=1e-6)
        assert np.allclose(poses[:, 4:], body.poses[:, :, 3], atol=1e-5)
        assert np.all(np.einsum("ni,ni->n", poses[1:, :4], poses[:-1, :4]) > 0.0)
    shade, codes = data["shades"][0], _unpack(data["bodies"][0]["fields"]["pressure_angle"], "<u2")
    known = scene.bodies[0].fields["pressure_angle"]
    assert np.array_equal(codes == 65535, np.isnan(known))
    values = shade["low"] + codes / 65534.0 * (shade["high"] - shade["low"])
    assert np.nanmax(np.abs(np.where(codes == 65535, np.nan, values) - known)) < 1e-3


def _rotation(q: np.ndarray) -> np.ndarray:
    x, y, z, w = q.T
    return np.stack(
        [
            np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)], -1),
            np.stack([2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)], -1),
            np.stack([2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)], -1),
        ],
        axis=1,
    )


def test_scene_text_cannot_leave_its_script() -> None:
    mesh = Mesh(np.eye(3), np.array([[0, 1, 2]], np.int32))
    body = Actor("</script><script>", mesh, fields={"k": np.zeros(3)})
    text = scene_json(Scene("s", np.array([0.0]), (body,), (Shade("k", "<!--"),)))
    assert "<" not in text
    assert json.loads(text)["bodies"][0]["name"] == "</script><script>"


@pytest.mark.parametrize(("width", "tall"), [(820.0, 30.0), (820.0, 4.0), (360.0, 30.0)])
def test_a_place_on_a_body_is_drawn_to_scale(width: float, tall: float) -> None:
    x, y = np.linspace(0.5, 19.5, 20), np.linspace(40.0, 40.0 + tall, 21)
    values = np.add.outer(y, x)
    axes = Axis("x", "mm"), Axis("y", "mm"), Axis("Stress", "MPa")
    for chart, alike in ((Map("c", *axes, x, y, values, to_scale=True), True), (Map("c", *axes, x, y, values), False)):
        (frame,) = (shape.box for shape in map_sheet(chart, width).shapes
                    if isinstance(shape, Rectangle) and shape.style == "frame")  # fmt: skip
        scales = (frame[2] - frame[0]) / 20.0, (frame[3] - frame[1]) / (tall * 21.0 / 20.0)
        assert (scales[0] == pytest.approx(scales[1], rel=1e-9)) == alike
        assert frame[2] <= width
