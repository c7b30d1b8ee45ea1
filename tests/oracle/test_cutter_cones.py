"""Discs of conical rollers: the G-code's tool, moved as its comments say, against flanks placed from the keys."""

from __future__ import annotations

import re
import sys
import tomllib
from math import atan2, cos, degrees, radians, sin, tan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from camgeom.checks import judge
from camgeom.errors import DesignError, ProfileError
from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from tests.oracle.conical_discs import DATA, centres, drawn
from tests.oracle.cutter_simulation import dense, fed_passes, read_gcode, swept
from tests.places import PROFILES, ROOT
from tests.reference import profiles

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from judging import _judges

GROOVE: dict[str, Any] = DATA | {
    "cam": {"kind": "disc", "form": "groove", "base_radius": 40.0, "width": 22.0, "diameter": 170.0,
            "groove_depth": 13.0, "running_clearance": 0.03},
    "roller": {"shape": "cone", "diameter": 24.0, "length": 12.0, "half_angle": 9.0},
}  # fmt: skip


def made(folder: Path, data: dict[str, Any], **cutter: object) -> tuple[Model, str, list[list[dict]]]:
    """The model with a tool, its G-code, and what is fed by passes."""
    model = Model(from_data(data | {"cutter": cutter}))
    path = folder / "cam.gcode"
    write(model, path)
    return model, path.read_text(), fed_passes(read_gcode(path))


def flank_points(data: dict[str, Any], count: int = 60) -> list[np.ndarray]:
    """Points (n, 3) of each flank: the inner one, and a groove's outer one; no cone of any other place is nearer."""
    cam, roller = data["cam"], data["roller"]
    grooved, width, lean = cam.get("form") == "groove", cam["width"], radians(roller["half_angle"])
    low = width - cam["groove_depth"] if grooved else 0.0
    middle = width - 0.5 * roller["length"] if grooved else 0.5 * width
    rng = np.random.default_rng(2)
    theta, z, hair = rng.uniform(0.0, 2.0 * np.pi, count), rng.uniform(low, width, count), 1e-5
    z[:4] = low, low, width, width
    at = centres(data, theta)
    along = centres(data, theta + hair) - centres(data, theta - hair)
    normal = np.stack([-along[1], along[0]]) / np.hypot(*along)
    normal *= np.sign((normal * at).sum(axis=0))
    radius = 0.5 * roller["diameter"] + cam.get("running_clearance", 0.0) / cos(lean) + tan(lean) * (z - middle)
    tree = cKDTree(centres(data, np.linspace(0.0, 2.0 * np.pi, 20001)).T)
    found = []
    for way in (-1.0, 1.0)[: 1 + grooved]:
        x = at + way * radius * normal
        assert (tree.query(x.T)[0] - radius).min() > -1e-5, "undercut"
        found.append(np.concatenate([x, z[None]]).T)
    return found


def said(text: str) -> float:
    """What the head says of the path, mm."""
    return float(re.search(r"PATH WITHIN ([0-9.E-]+) MM", text)[1])


def left(passes: list[list[dict]], points: np.ndarray, tool: list[float], rotary: str = "C") -> np.ndarray:
    return np.min([swept(points, *dense(one, rotary, upright=True), tool) for one in passes], axis=0)


def taper(diameter: float, half_angle: float) -> list[float]:
    return [diameter, 0.0, 0.5 * diameter, 0.0, 0.0, half_angle, 30.0]


def tools_of(data: dict[str, Any]) -> list[tuple[dict[str, Any], list[float]]]:
    """Tables of [cutter], each with its tool in APT's numbers."""
    roller, cam = data["roller"], data["cam"]
    lean, depth = roller["half_angle"], cam.get("groove_depth", cam["width"])
    above = 0.5 * roller["length"] if "form" in cam else 0.5 * depth
    end = roller["diameter"] + 2.0 * cam.get("running_clearance", 0.0) / cos(radians(lean))
    end -= 2.0 * tan(radians(lean)) * (depth - above)
    # One that widens to its end is as thick there as the roller; a taper stays open at its mouth.
    return [
        ({}, taper(end, lean)),
        ({"kind": "flat", "diameter": 0.4 * end, "axis": "fitted"}, taper(0.4 * end, 0.0)),
        ({"kind": "flat", "diameter": 0.6 * end, "half_angle": lean}, taper(0.6 * end, lean)),
    ]


@pytest.mark.parametrize("tool", [0, 1, 2])
@pytest.mark.parametrize("lean", [9.0, -7.0])
@pytest.mark.parametrize("form", ["external", "groove"])
def test_every_tool_gives_every_flank_back(tmp_path: Path, form: str, lean: float, tool: int) -> None:
    data = DATA if form == "external" else GROOVE
    data = data | {"roller": data["roller"] | {"half_angle": lean}}
    keys, numbers = tools_of(data)[tool]
    if form == "groove" and lean < 0.0 and tool == 0:
        # It is thicker at the floor than the groove's mouth.
        verdict = judge(Model(from_data(data | {"cutter": keys})), ("gouge",))
        failed = next(word for word in verdict.findings if word.where.startswith("mouth"))
        assert failed.level == "fail"
        assert failed.value == pytest.approx(13.0 * tan(radians(7.0)))
        return
    model, text, passes = made(tmp_path, data, **keys)
    assert len(passes) == (2 if form == "groove" and tool else 1)
    for points in flank_points(data):
        foot = points[:, 2].min()
        if tool == 1 and lean < 0.0 and form == "groove":
            # Beneath an overhang the rim of a flat end that leans stands off the foot.
            points = points[points[:, 2] > foot + numbers[0] * sin(radians(-lean))]
        off = left(passes, points, numbers)
        assert np.abs(off).max() < said(text) < 6.2e-4
        # The other side of the test: 2 um are seen.
        smaller = [numbers[0] - 0.004, *numbers[1:]]
        assert left(passes, points[:10], smaller).min() > 1.9e-3 * cos(radians(lean)) - said(text)
    assert judge(model, ("gouge",)).findings[0].level == "pass"


@pytest.mark.parametrize("rotary", ["A", "B", "C"])
@pytest.mark.parametrize("tool", [0, 1])
def test_every_rotary_letter_and_count(tmp_path: Path, rotary: str, tool: int) -> None:
    keys, numbers = tools_of(DATA)[tool]
    _, text, passes = made(tmp_path, DATA, rotary=rotary, **keys)
    (points,) = flank_points(DATA, 30)
    assert np.abs(left(passes, points, numbers, rotary)).max() < said(text)
    assert ("TILTS THE SPINDLE" in text) == bool(tool)


@pytest.mark.parametrize("keys", [{}, {"kind": "flat", "diameter": 9.0, "half_angle": 10.0}])
def test_a_plain_machine_takes_what_stands_upright(tmp_path: Path, keys: dict[str, Any]) -> None:
    _, text, passes = made(tmp_path, DATA, machine="plain", **keys)
    assert all("C" not in block and "B" not in block for one in passes for block in one)
    numbers = tools_of(DATA)[0][1] if not keys else taper(9.0, 10.0)
    assert np.abs(left(passes, flank_points(DATA)[0], numbers)).max() < said(text)


def test_rows_of_a_ball_leave_their_ridges_from_face_to_face(tmp_path: Path) -> None:
    model, text, passes = made(tmp_path, DATA, kind="ball", diameter=8.0, scallop=0.05, overrun=0.5)
    figures = model.machined.data()
    assert figures["foot_left_mm"] == 0.0
    off = left(passes, flank_points(DATA, 40)[0], [8.0, 4.0, 0.0, 4.0, 0.0, 0.0, 30.0])
    assert off.min() > -said(text)
    assert 0.3 * figures["scallop_mm"] < off.max() < figures["scallop_mm"] + said(text)


def test_an_allowance_is_left_square_to_the_flank(tmp_path: Path) -> None:
    for tool in (1, 2):
        keys, numbers = tools_of(GROOVE)[tool]
        _, text, passes = made(tmp_path, GROOVE, allowance=0.2, **keys)
        for points in flank_points(GROOVE, 30):
            assert left(passes, points, numbers) == pytest.approx(np.full(30, 0.2), abs=said(text))


def test_arcs_in_and_out_stay_off_the_flank_and_off_the_floor(tmp_path: Path) -> None:
    for data in (DATA, GROOVE):
        for keys, numbers in tools_of(data)[1:]:
            model, text, passes = made(tmp_path, data, start_angle=40.0, **keys)
            low = min(block["Z"] for one in passes for block in one)
            assert low > model.cutters[0].tip - said(text)
            for points in flank_points(data):
                for one in passes:
                    assert left([one[:14]], points, numbers).min() > -said(text)


def test_what_no_tool_does_is_named(tmp_path: Path) -> None:
    for data, keys, words in (
        (DATA, {"kind": "flat", "diameter": 9.0}, r"cutter.axis.*half_angle as the roller's"),
        (DATA, {"kind": "flat", "diameter": 9.0, "half_angle": 9.0}, r"cutter.half_angle.*of the roller, 10 deg"),
        (DATA, {"kind": "flat", "diameter": 9.0, "half_angle": 10.0, "axis": "fitted"}, r"cutter.axis.*for a taper"),
        (DATA, {"kind": "flat", "diameter": 9.0, "axis": "fitted", "machine": "plain"}, r"cutter.machine.*leans"),
        (DATA, {"kind": "flat", "diameter": 9.0, "axis": "fitted", "path": "shifted"}, r"cutter.path"),
        (DATA, {"pivot": 9.0}, r"cutter.pivot"),
        (DATA, {"half_angle": 10.0}, r"cutter.half_angle.*means nothing|only an end mill"),
        (GROOVE, {"overrun": 1.0}, r"cutter.overrun"),
        (GROOVE, {"kind": "flat", "diameter": 22.0, "axis": "fitted"}, r"cutter.diameter.*does not go into"),
    ):
        with pytest.raises(ProfileError, match=words):
            from_data(data | {"cutter": keys})
    straight = DATA | {"roller": {"diameter": 24.0, "length": 16.0}}
    with pytest.raises(ProfileError, match=r"cutter.half_angle.*allowed: 0$"):
        from_data(straight | {"cutter": {"kind": "flat", "diameter": 9.0, "half_angle": 10.0}})
    # No one taper cuts both discs of unequal cones, whatever its half angle; either of two equal ones it does.
    pair = read_data(PROFILES / "conical_pair.toml")
    for half_angle, other in ((6.0, -5.0), (-5.0, -5.0), (6.0, 0.0), (3.0, 5.99)):
        unequal = pair | {"cutter": {"kind": "flat", "diameter": 20.0, "half_angle": half_angle}}
        unequal["return_roller"] = unequal["return_roller"] | {"half_angle": other}
        if not other:
            unequal["return_roller"] = {"diameter": 28.0, "length": 14.0}
        fitted = "0 with axis = 'fitted', or kind = 'roller'"
        with pytest.raises(ProfileError, match=rf"half_angle.*{fitted}.* half angles, {min(other, 6.0):g} and .* deg"):
            from_data(unequal)
    with pytest.raises(ProfileError, match=r"cutter.axis.*allowed: fitted: along Z"):
        from_data(pair | {"cutter": {"kind": "flat", "diameter": 20.0}})
    for keys in ({}, {"kind": "flat", "diameter": 20.0, "axis": "fitted"}):
        assert Model(from_data(pair | {"cutter": keys})).machining
    equal = pair | {"return_roller": pair["return_roller"] | {"half_angle": 6.0}}
    tapered = {"kind": "flat", "diameter": 20.0, "half_angle": 6.0}
    assert len(Model(from_data(equal | {"cutter": tapered})).machining.paths) == 2
    with pytest.raises(ProfileError, match=r"cutter.half_angle.*0, or that of the roller, 6 deg"):
        from_data(equal | {"cutter": tapered | {"half_angle": 6.01}})
    # The largest taper is as thick at its end as the roller's cone at the floor.
    end = tools_of(GROOVE)[0][1][0]
    keys = {"kind": "flat", "half_angle": 9.0}
    assert Model(from_data(GROOVE | {"cutter": keys | {"diameter": end - 1e-6}})).machining
    with pytest.raises(ProfileError, match=r"cutter.diameter.*does not go into"):
        from_data(GROOVE | {"cutter": keys | {"diameter": end + 1e-6}})
    most = degrees(atan2(24.0, 20.0))
    assert most > 40.0
    pointed = DATA | {"roller": DATA["roller"] | {"half_angle": 0.99 * most, "length": 8.0}}
    with pytest.raises(DesignError, match=r"cutter.overrun 5 mm: the cone comes to its point"):
        made(tmp_path, pointed, overrun=5.0)


@pytest.mark.parametrize("tool", [0, 1, 2])
@pytest.mark.parametrize("seed", range(4))
def test_random_discs(tmp_path: Path, seed: int, tool: int) -> None:
    data = {key: table for key, table in drawn(seed).items() if key != "output"}
    keys, numbers = tools_of(data)[tool]
    keys = {key: value for key, value in keys.items() if key != "diameter"} | (
        {"diameter": numbers[0]} if tool else {}
    )
    _, text, passes = made(tmp_path, data, **keys)
    (points,) = flank_points(data, 40)
    assert np.abs(left(passes, points, numbers)).max() < said(text)


@pytest.mark.parametrize("keys", [{}, {"kind": "flat", "diameter": 12.0, "axis": "fitted"}])
def test_each_disc_of_a_pair_is_cut_from_the_side_that_its_roller_comes_from(
    tmp_path: Path, keys: dict[str, Any]
) -> None:
    data = tomllib.loads((PROFILES / "conical_pair.toml").read_text())
    data = {name: tuple(table) if isinstance(table, list) else table for name, table in data.items()}
    model, text, passes = made(tmp_path, data, **keys)
    assert [path.below for path in model.machining.paths] == [False, True]
    assert "G55" in text
    tools = {len(passes) - 1 - k: [*model.machining.tools[k].apt(40.0)] for k in (0, 1)}
    over = float(re.search(r"G55 ON THE CAM AXIS AT CAM Z = ([0-9.]+)", text)[1])
    # The first body is the main disc, cut last, from below; each roller's cone leans towards its own end.
    for disc, oracle in enumerate(_judges(model, data)):
        mesh = model.solids[disc].mesh
        points = mesh.vertices[mesh.group_vertices("flank")]
        points = points[np.random.default_rng(1).permutation(len(points))[:40]]
        assert np.abs(oracle.least(points)).max() < 1e-6
        if disc == 0:
            points = points * [1.0, -1.0, -1.0] + [0.0, 0.0, over]
        off = left([passes[1 - disc]], points, tools[disc])
        assert np.abs(off).max() < said(text)


BALL = {"kind": "ball", "half_angle": 0.0, "scallop": 0.3}


@pytest.mark.parametrize(("end", "keys", "level"), [
    (18.0, {}, None), (21.0, {}, "fail"), (18.0, {"lead": 0.2}, "fail"), (14.0, {"lead": 0.2}, "fail"),
    (14.0, {"lead": 2.6}, None), (22.0, BALL, "fail"), (20.0, BALL, None),
])  # fmt: skip
def test_a_dovetail_mill_does_not_come_down_through_a_mouth_that_is_narrower(
    end: float, keys: dict[str, Any], level: str | None
) -> None:
    """Where the tool comes down and leaves its end is that far from the mouth's edges, or cuts them."""
    cutter = {"kind": "flat", "diameter": end, "half_angle": -8.0, **keys}
    model = profiles.model("conical_groove", roller__half_angle=-8.0, cutter=cutter)
    pose = model.tracks[0].pose(np.linspace(0.0, 2.0 * np.pi, 20_001), 1)
    normal = np.stack([-pose.a[1][1], pose.a[1][0]]) / np.hypot(*pose.a[1][:2])
    half = 12.0 - 6.0 * tan(radians(8.0)) + 0.03 / cos(radians(8.0))
    edges = np.concatenate([pose.a[0][:2] + way * half * normal for way in (-1.0, 1.0)], axis=1)
    ends = [move.positions.tip[:2, at] for one in model.machining.passes()
            for move, at in ((one.moves[1], 0), (one.moves[-1], 0))]  # fmt: skip
    cut = max(0.5 * end - float(np.hypot(*(edges - place[:, None])).min()) for place in ends)
    assert (cut > 0.0) is (level is not None)
    assert model.machined.mouth() == pytest.approx(max(0.0, cut), abs=0.02)
    found = [one.level for one in judge(model, ("gouge",)).findings if one.where.startswith("mouth")]
    assert found == ([] if level is None else [level])
