"""Cutter data: files simulated by a tool that shares nothing with their generator give the flanks back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.errors import CamgeomError, DesignError, NotConverged, ProfileError
from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import parse
from tests.oracle.cutter_simulation import (
    drum_flank,
    fed,
    forward_rotary_a,
    globoid_flank,
    globoid_pose,
    read_apt,
    read_gcode,
    swept,
)
from tests.reference.milled_cams import DRUM, GLOBOID, model, written

STEPS = ((90, None), (200, 30.0), (240, None), (360, 0.0))
INDEX = ((120, None), (240, 45.0), (360, None))


def drum_points(side: float, count: int = 120) -> np.ndarray:
    rng = np.random.default_rng(7)
    phi, delta = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(40.0, 50.0, count)
    return drum_flank(phi, delta, 10.0, 25.0, STEPS, side)[0]


def globoid_points(side: float, count: int = 120) -> np.ndarray:
    """Points of the first groove's flank that are on the blank."""
    rng = np.random.default_rng(8)
    phi, delta = rng.uniform(-2.0 * np.pi, 2.0 * np.pi, 4 * count), rng.uniform(80.0, 102.0, 4 * count)
    x, _ = globoid_flank(phi, delta, 15.0, 180.0, np.radians(22.5), INDEX, side)
    rho = np.hypot(x[:, 0], x[:, 1])
    inside = (np.abs(x[:, 2]) < 45.0) & (np.hypot(rho - 180.0, x[:, 2]) > 80.0)
    return x[inside][:count]


def test_tool_like_the_roller_gives_the_drum_back(tmp_path: Path) -> None:
    cutter, words, passes = read_apt(written(model(DRUM), tmp_path, "apt"))
    assert words[0] == "PARTNO"
    assert words[-1] == "FINI"
    assert {"UNITS", "CUTTER", "LOADTL", "SPINDL", "FEDRAT", "MULTAX"} <= set(words)
    assert cutter[:3] == [20.0, 0.0, 10.0]
    tip, axis = fed(passes[0])
    for side in (1.0, -1.0):
        left = swept(drum_points(side), tip, axis, cutter)
        assert np.abs(left).max() < 1e-3
        assert np.abs(left).max() > 1e-5  # the chords of the file, and no less
    # The other side of the test: a tool 2 µm smaller is seen.
    cutter[0] -= 0.004
    assert swept(drum_points(1.0), tip, axis, cutter).min() > 1e-3


def test_tool_like_the_roller_gives_the_globoid_back(tmp_path: Path) -> None:
    cutter, _, passes = read_apt(written(model(GLOBOID), tmp_path, "apt"))
    assert cutter[0] == 30.0
    tip, axis = fed(passes[0])
    for side in (1.0, -1.0):
        points = globoid_points(side)
        assert len(points) > 60
        assert np.abs(swept(points, tip, axis, cutter)).max() < 1e-3


@pytest.mark.parametrize(
    ("keys", "some"),
    [
        ({}, 0.0005),
        ({"axis": "fitted"}, 0.0),
        ({"path": "shifted", "gouge_limit": 0.0005}, 0.3),
        ({"path": "centre"}, 1.9),
        ({"axis": "radial", "gouge_limit": 9.0}, 0.02),
    ],
    ids=["flank", "fitted", "shifted", "centre", "radial"],
)
def test_smaller_tool_leaves_what_is_stated(tmp_path: Path, keys: dict[str, object], some: float) -> None:
    made = model(DRUM, kind="flat", diameter=16.0, **keys)
    least, most = made.machined.least, made.machined.most
    assert least is not None
    assert most is not None
    cutter, _, passes = read_apt(written(made, tmp_path, "apt"))
    assert len(passes) == (1 if keys.get("path") == "centre" else 2)

    def left(x: np.ndarray) -> np.ndarray:
        return np.min([swept(x, *fed(blocks), cutter) for blocks in passes], axis=0)

    every = np.concatenate([left(drum_points(side, 120)) for side in (1.0, -1.0)])
    assert every.max() <= most.value + 1e-3
    assert every.min() >= least.value - 1e-3
    assert every.max() > some
    # The stated extremes stand where they are said to be.
    for at in (least, most):
        point, _ = drum_flank(np.array([at.cam_angle]), np.array([at.delta]), 10.0, 25.0, STEPS, at.side)
        assert left(point)[0] == pytest.approx(at.value, abs=1e-3)


def test_gcode_gives_the_same_positions(tmp_path: Path) -> None:
    made = model(GLOBOID)
    blocks = [b for b in read_gcode(written(made, tmp_path, "gcode")) if b["G"] == "G1"]
    tip, axis = forward_rotary_a(blocks)
    # The rotary axis is the cam angle itself, so each block says where the roller's own tip must be.
    end, along = globoid_pose(np.radians([block["A"] for block in blocks]), np.radians(22.5), 180.0, INDEX)
    floor = made.cutters[0].tip
    low = slice(1, -1)
    assert np.abs(end + floor * along - tip)[low].max() < 1.5e-4
    assert np.abs(along + axis)[low].max() < 1e-6
    dense = dense_gcode(blocks)
    for side in (1.0, -1.0):
        assert np.abs(swept(globoid_points(side), *dense, [30.0, 0.0, 15.0, 0.0, 0.0, 0.0, 30.0])).max() < 1e-3
    assert np.allclose(np.linalg.norm(axis, axis=1), 1.0)


def dense_gcode(blocks: list[dict], pivot: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Positions between blocks as a machine makes them: straight in its own coordinates."""
    letters = sorted({letter for block in blocks for letter in block if letter in "XYZABC" and len(letter) == 1})
    table = np.array([[block.get(letter, 0.0) for letter in letters] for block in blocks])
    at = np.arange(len(table))
    parts = np.maximum(2, np.ceil(np.abs(np.diff(table[:, letters.index("A")])) / 0.25)).astype(int)
    where = np.concatenate([i + np.arange(n) / n for i, n in enumerate(parts)] + [at[-1:]])
    fine = np.stack([np.interp(where, at, column) for column in table.T], axis=1)
    return forward_rotary_a([dict(zip(letters, row)) for row in fine], pivot)


def test_tool_larger_than_the_groove_is_refused_in_one_line() -> None:
    with pytest.raises(ProfileError) as error:
        model(DRUM, kind="flat", diameter=20.01)
    assert "\n" not in str(error.value)
    assert "cutter.diameter" in str(error.value)
    assert "at most 20 mm" in str(error.value)
    assert model(DRUM, kind="flat", diameter=20.0).machining.paths[0].name == "groove, centre"


def test_refusals_name_key_and_reason() -> None:
    for keys, key in (
        ({"kind": "flat"}, "cutter.diameter"),
        ({"diameter": 5.0}, "cutter.diameter"),
        ({"kind": "ball", "diameter": 8.0, "path": "centre"}, "cutter.path"),
        ({"kind": "wheel", "diameter": 60.0, "contact": "side"}, "cutter.width"),
        ({"kind": "flat", "diameter": 10.0, "machine": "plain"}, "cutter.machine"),
        ({"kind": "flat", "diameter": 19.9, "allowance": 0.2}, "cutter.diameter"),
    ):
        with pytest.raises(ProfileError, match=key):
            model(DRUM, **keys)


def test_gouges_are_refused_with_place_and_advice(tmp_path: Path) -> None:
    made = model(DRUM, kind="flat", diameter=16.0, axis="radial")
    with pytest.raises(DesignError, match=r"cuts .* mm into the flank at cam angle .*gouge_limit"):
        made.machined.refuse_gouges()
    with pytest.raises(CamgeomError):
        made.machined.data()


def test_ball_leaves_the_stated_ridges(tmp_path: Path) -> None:
    made = model(DRUM, kind="ball", diameter=8.0, scallop=0.03, tolerance=0.001)
    data = made.machined.data()
    assert data["scallop_mm"] <= 0.03
    assert data["scallop_mm"] > 0.02
    cutter, _, passes = read_apt(written(made, tmp_path, "apt"))
    assert len(passes) == data["rows"]
    rng = np.random.default_rng(5)
    low = 39.0 + data["foot_left_mm"]
    assert low == pytest.approx(43.0)
    x, n = drum_flank(rng.uniform(0.0, 2.0 * np.pi, 40), rng.uniform(low, 50.0, 40), 10.0, 25.0, STEPS, 1.0)
    rows = [fed(blocks) for blocks in passes[: len(passes) // 2]]

    def left_of(points: np.ndarray) -> np.ndarray:
        return np.min([swept(points, *row, cutter) for row in rows], axis=0)

    left = left_of(x)
    assert left.min() > -1e-3
    assert left.max() < data["scallop_mm"] + 1e-3
    assert left.max() > 0.5 * data["scallop_mm"]
    # The same seen along the normal: a point on the ridge is out of every ball.
    assert left_of(x - (data["scallop_mm"] + 1e-3) * n).max() < 0.0


def test_fine_ridges_are_bounded_and_finer_ones_refused() -> None:
    fine = model(DRUM, kind="ball", diameter=8.0, scallop=1e-4)
    assert 100 < len(fine.machining.paths) < 1000
    passes = fine.machining.passes("cam")
    assert next(passes).blocks < 10_000  # one pass at a time is in memory
    many = model(DRUM, kind="ball", diameter=0.02, scallop=1e-5, tolerance=1e-5).machining
    with pytest.raises(NotConverged, match=r"blocks, more than .*scallop"):
        next(many.passes("cam"))
    with pytest.raises(NotConverged, match=r"rows .*more than"):
        model(DRUM, kind="ball", diameter=0.002, scallop=1e-5).machining  # noqa: B018


def test_tool_of_a_hair(tmp_path: Path) -> None:
    made = model(DRUM, kind="flat", diameter=0.01)
    assert made.machined.data()["within_roller"]
    cutter, _, passes = read_apt(written(made, tmp_path, "apt"))
    left = [np.min([swept(drum_points(s), *fed(b), cutter) for b in passes], axis=0) for s in (1.0, -1.0)]
    most = made.machined.most
    assert most is not None
    assert np.max(left) < most.value + 1e-3
    assert np.min(left) > -1e-3


def test_undercut_drum_has_cutter_data_only_where_its_body_is_asked_for(tmp_path: Path) -> None:
    tight = DRUM.replace("until = 200", "until = 104").replace("until = 240", "until = 106")
    with pytest.raises(DesignError, match="undercut"):
        write(model(tight), tmp_path / "cam.apt")
    assert not list(tmp_path.iterdir())
    asked = model(tight + "[output]\nundercut_solid = true\n")
    assert write(asked, tmp_path / "cam.apt") > 1000


def test_cone_needs_a_fitted_axis(tmp_path: Path) -> None:
    text = DRUM.replace('[roller]\n', '[roller]\nshape = "cone"\nhalf_angle = 5\n')
    with pytest.raises(DesignError, match="axis = 'fitted'"):
        write(model(text, kind="flat", diameter=14.0), tmp_path / "cam.apt")
    fitted = model(text, kind="flat", diameter=14.0, axis="fitted", gouge_limit=0.02)
    assert fitted.machined.least is not None
    assert fitted.machined.least.value > -0.02
    like = model(text)
    cutter, _, passes = read_apt(written(like, tmp_path, "apt"))
    assert cutter[5] == pytest.approx(5.0)
    assert like.machined.data()["most_rest_mm"] < 1e-9
    assert len(passes) == 1


def test_wheel_side_is_measured_against_its_own_wall_and_the_other(tmp_path: Path) -> None:
    small = model(DRUM, kind="wheel", contact="side", diameter=40.0, width=4.0, gouge_limit=20.0)
    data = small.machined.data()
    assert data["opposite_wall_mm"] > 1.0
    assert data["least_rest_mm"] < -0.1  # a plane side cannot lie in a hollow
    with pytest.raises(DesignError, match=r"cuts at least .* into the flank"):
        write(model(DRUM, kind="wheel", contact="side", diameter=40.0, width=4.0), tmp_path / "cam.apt")
    wide = model(DRUM, kind="wheel", contact="side", diameter=22.0, width=22.0, gouge_limit=1.0)
    with pytest.raises(DesignError, match="opposite wall"):
        write(wide, tmp_path / "cam.apt")
    assert write(small, tmp_path / "cam.gcode") > 1000
    blocks = read_gcode(tmp_path / "cam.gcode")
    assert all("C" in block for block in blocks)


@pytest.mark.parametrize(("kind", "words"), [("wheel", "grinding wheel 16 mm"), ("flat", "end mill 16 mm")])
def test_a_tool_is_called_what_it_is(kind: str, words: str) -> None:
    assert model(DRUM, kind=kind, diameter=16.0).machining.tool.about == words


def test_map_of_the_rest_reads_back(tmp_path: Path) -> None:
    made = model(DRUM, kind="flat", diameter=16.0)
    most = made.machined.most
    assert most is not None
    table = np.loadtxt(written(made, tmp_path, "rest.csv"), delimiter=",", skiprows=1, usecols=range(1, 8))
    assert table[:, -1].max() == pytest.approx(most.value, rel=0.05)
    import meshio

    grid = meshio.read(written(made, tmp_path, "rest.vtu"))
    assert len(grid.points) == len(table)
    assert grid.point_data["rest_mm"].max() == table[:, -1].max()


def test_csv_holds_what_apt_holds(tmp_path: Path) -> None:
    made = model(DRUM, kind="flat", diameter=16.0, feed=200.0)
    lines = written(made, tmp_path, "cutter.csv").read_text().splitlines()
    head = lines[0].split(",")
    rows = [line.split(",") for line in lines[1:]]
    _, _, passes = read_apt(written(made, tmp_path, "apt"))
    blocks = [values for blocks in passes for _, values in blocks]
    first = head.index("x_mm")
    assert np.abs(np.array([row[first : first + 6] for row in rows], float) - np.array(blocks)).max() < 1e-6
    # The contact moves at the feed wherever the tool cuts.
    touch = np.array([row[head.index("contact_x_mm") : head.index("contact_z_mm") + 1] for row in rows], float)
    time = np.array([row[-1] for row in rows], float)
    cut = np.array([row[1] == "cut" for row in rows])
    inside = cut[1:] & cut[:-1]
    speed = np.linalg.norm(np.diff(touch, axis=0), axis=1)[inside] / time[1:][inside]
    assert np.abs(60.0 * speed / 200.0 - 1.0).max() < 1e-4


def test_two_axes_of_a_turret_machine_stand_still(tmp_path: Path) -> None:
    """With the pivot where the turret's axis is, the linear axes of the mill do not move: cam and turret turn alone."""
    made = model(GLOBOID)
    tip = made.cutters[0].tip
    held = model(GLOBOID, pivot=tip)
    blocks = [b for b in read_gcode(written(held, tmp_path, "gcode")) if b["G"] == "G1"]
    inner = blocks[1:]
    assert all(abs(b["X"]) < 1e-4 and abs(b["Y"]) < 1e-4 and abs(b["Z"] - 180.0) < 1e-4 for b in inner)
    ends, axes = forward_rotary_a(inner, tip)
    end, along = globoid_pose(np.radians([block["A"] for block in inner]), np.radians(22.5), 180.0, INDEX)
    assert np.abs(end + tip * along - ends).max() < 1.5e-4
    assert np.abs(along + axes).max() < 1e-6


def test_rotary_letter_and_count(tmp_path: Path) -> None:
    one = read_gcode(written(model(DRUM), tmp_path, "gcode"))
    other = read_gcode(written(model(DRUM, rotary="B", reversed_rotary=True), tmp_path, "gcode"))
    assert {"A", "X", "Y", "Z"} <= set(one[0])
    assert "A" not in other[0]
    assert [b["A"] for b in one] == [-b["B"] for b in other]
    assert [b["X"] for b in one] == [b["Y"] for b in other]
    # A and the cam's axis alone carry a tool like the roller.
    assert len({b["Z"] for b in one if b["G"] == "G1"}) == 1
    assert all(b["Y"] == 0.0 for b in one)


def test_rib_takes_a_tool_larger_than_its_roller(tmp_path: Path) -> None:
    rib = DRUM.replace("diameter = 100", 'diameter = 100\nform = "rib"\nrib_thickness = 12', 1)
    made = model(rib, kind="flat", diameter=26.0, gouge_limit=0.05)
    data = made.machined.data()
    assert data["passes"] == 2
    assert not data["within_roller"]
    assert write(made, tmp_path / "cam.apt") > 1000


def test_the_command_line_writes_all_or_says_why(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = tmp_path / "drum.toml"
    output = '[output]\nformats = ["apt", "cutter.csv", "gcode", "rest.csv"]\n[limits]\npressure_angle_deg = 60\n'
    profile.write_text(DRUM + '[cutter]\nkind = "flat"\ndiameter = 16\n' + output)
    out = tmp_path / "out"
    assert main(["build", str(profile), "--out", str(out)]) == 0
    found = json.loads((out / "result.json").read_text())
    assert found["cutter"]["passes"] == 2
    ways = {way["path"]: way for way in found["cutter"]["shop_errors"]}
    assert ways["centre"]["least_mm"] == pytest.approx(2.0, abs=1e-9)
    assert ways["centre"]["most_mm"] == pytest.approx(2.0, abs=1e-9)
    assert ways["shifted"]["most_mm"] > 0.3
    assert ways["radial"]["least_mm"] < -0.05
    assert len(found["files"]) == 4
    profile.write_text(DRUM + '[cutter]\nkind = "flat"\ndiameter = 16\naxis = "radial"\n' + output)
    assert main(["build", str(profile), "--out", str(tmp_path / "gouged")]) == 1
    assert "no cutter: the end mill" in capsys.readouterr().out
    found = json.loads((tmp_path / "gouged" / "result.json").read_text())
    assert "cuts" in found["cutter"]["refused"]
    assert [Path(file).name for file in found["files"]] == ["drum.rest.csv"]
    profile.write_text(DRUM + '[cutter]\nkind = "flat"\ndiameter = 21\n')
    assert main(["check", str(profile)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_report_shows_the_tool_and_its_stock() -> None:
    from camgeom.drawing.content import Map, Table
    from camgeom.report.sections import report

    made = model(DRUM, kind="flat", diameter=16.0)
    (section,) = report(made, ["cutter"]).sections
    tables = [block for block in section.blocks if isinstance(block, Table)]
    maps = [block for block in section.blocks if isinstance(block, Map)]
    assert len(tables) == 2
    assert len(maps) == 2
    assert made.machined.most is not None
    assert np.nanmax(maps[0].values) == pytest.approx(1e3 * made.machined.most.value, rel=0.02)
    assert report(Model(parse(DRUM)), ["cutter"]).sections == ()


def test_rapid_ways_stay_outside_the_blank(tmp_path: Path) -> None:
    """Between passes, and over several starts, the tool's end keeps off the cylinder round the cam."""
    for text, keys, radius in (
        (DRUM, {"kind": "flat", "diameter": 12.0}, 50.0),
        (GLOBOID, {"kind": "flat", "diameter": 20.0}, 180.0 - np.sqrt(80.0**2 - 45.0**2)),
    ):
        _, _, passes = read_apt(written(model(text, **keys), tmp_path, "apt"))
        ways = [[], []]
        last = None
        for blocks in passes:
            for kind, values in blocks:
                here = np.array(values[:3])
                if kind == "rapid" and last is not None and last[0] == "rapid":
                    ways[0].append(last[1])
                    ways[1].append(here)
                last = (kind, here)
        start, stop = np.array(ways[0]), np.array(ways[1])
        share = np.linspace(0.0, 1.0, 21)[:, None, None]
        between = start + share * (stop - start)
        assert len(start) > 0
        assert np.hypot(between[..., 0], between[..., 1]).min() > radius + 4.0


def test_a_study_of_tool_sizes_shows_what_each_leaves(tmp_path: Path) -> None:
    """Half the tool leaves more: the stock grows by what the tool is smaller than the roller."""
    profile = tmp_path / "drum.toml"
    profile.write_text(DRUM + '[cutter]\nkind = "flat"\ndiameter = 16\n')
    vary = ["--vary", "cutter.diameter=12:16:2", "--only", "cutter"]
    assert main(["study", str(profile), *vary, "--out", str(tmp_path)]) == 0
    table = (tmp_path / "study.csv").read_text().splitlines()
    column = table[0].split(",").index("cutter.most_rest_mm")
    left = [float(row.split(",")[column]) for row in table[1:]]
    assert left[0] == pytest.approx(2.0 * left[1], rel=0.01)


def test_allowance_is_left_on_both_flanks(tmp_path: Path) -> None:
    made = model(DRUM, kind="flat", diameter=16.0, allowance=0.1)
    assert made.machined.least is not None
    assert made.machined.least.value == pytest.approx(0.1, abs=1e-9)
    cutter, _, passes = read_apt(written(made, tmp_path, "apt"))
    for side in (1.0, -1.0):
        left = np.min([swept(drum_points(side, 60), *fed(blocks), cutter) for blocks in passes], axis=0)
        assert left.min() > 0.099
        assert left.max() < 0.106


def test_a_tool_beside_the_roller_is_the_roller_when_it_is_as_large() -> None:
    """A hair smaller: two passes that nearly meet; equal: one."""
    assert len(model(DRUM, kind="flat", diameter=20.0).machining.paths) == 1
    near = model(DRUM, kind="flat", diameter=19.999)
    assert len(near.machining.paths) == 2
    assert near.machined.most is not None
    assert near.machined.most.value < 1e-6


def test_what_an_undercut_loses_is_seen_in_the_stock() -> None:
    """A tool like the roller cuts away what the nominal flank of an undercut drum has too much."""
    tight = DRUM.replace("until = 200", "until = 104").replace("until = 240", "until = 106")
    asked = model(tight + "[output]\nundercut_solid = true\n")
    assert asked.machined.least is not None
    assert asked.machined.least.value < -1e-3
