"""Grooves cut from within a ring: the G-code's tool, moved as its comments say, against rollers placed by the keys."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import CamgeomError, DesignError, ProfileError
from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import from_data, read
from tests.oracle.bells import ARM, CONE, CROWN, INNER, LENGTH, RADIUS, SWUNG, bell
from tests.oracle.cams import oracle_of
from tests.oracle.cutter_simulation import dense, fed_passes, read_gcode, swept
from tests.places import ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from designs import design

UP = 78.0
"""height of the shipped ring"""


def made(folder: Path, data: dict[str, Any], **cutter: object) -> tuple[Model, str, list[dict]]:
    """The model with a tool, its G-code and the blocks."""
    model = Model(from_data(data | {"cutter": cutter}))
    path = folder / "cam.gcode"
    write(model, path)
    return model, path.read_text(), read_gcode(path)


def flank_points(model: Model, data: dict[str, Any], count: int = 80) -> np.ndarray:
    """Points of the flanks that rollers placed from the keys touch, where no further out than the roller's end."""
    mesh, reach = model.solid.mesh, 0.5 * data["cam"]["inner_diameter"] + data["roller"]["length"]
    points = mesh.vertices[mesh.group_vertices("flank")]
    points = points[np.hypot(points[:, 0], points[:, 1]) < reach]
    points = points[np.random.default_rng(3).permutation(len(points))[:count]]
    assert np.abs(oracle_of(model, data).least(points)).max() < 1e-6 * reach
    return points


def left(blocks: list[dict], points: np.ndarray, tool: list[float], rotary: str = "C") -> np.ndarray:
    return np.min([swept(points, *dense(one, rotary, inside=True), tool) for one in fed_passes(blocks)], axis=0)


def said(text: str) -> float:
    """What the head says of the path, mm."""
    return float(re.search(r"PATH WITHIN ([0-9.E-]+) MM", text)[1])


CASES: dict[str, dict[str, Any]] = {
    "cylinder": {},
    "clockwise": {"direction": "cw"},
    "crown": {"roller": CROWN},
    "arm": {"follower": ARM, "motion": SWUNG, "groove_depth": 12.0, "operation": {"gravity": None}},
}


@pytest.mark.parametrize("rotary", ["C", "A"])
@pytest.mark.parametrize("case", CASES)
def test_a_tool_like_the_roller_gives_both_walls_back(tmp_path: Path, case: str, rotary: str) -> None:
    data = bell(**CASES[case])
    model, text, blocks = made(tmp_path, data, rotary=rotary)
    points, size = flank_points(model, data), 2.0 * (RADIUS + 0.02)
    off = left(blocks, points, [size, 0.0, 0.5 * size, 0.0, 0.0, 0.0, 20.0, 20.0], rotary)
    assert np.abs(off).max() < said(text) < 6.1e-4
    # The other side: what stands off by 1 um is seen.
    smaller = [size - 0.002, 0.0, 0.5 * size, 0.0, 0.0, 0.0, 20.0, 20.0]
    assert left(blocks, points, smaller, rotary).min() > 1e-3 - said(text)


def test_a_cone_is_cut_by_one_like_it(tmp_path: Path) -> None:
    data = bell(roller=CONE)
    model, text, blocks = made(tmp_path, data)
    tool = [*model.machining.tool.apt(20.0), 20.0]
    # Its half angle and its radius at the end are those of the keys, with the gap square to the side.
    slope = np.tan(np.radians(8.0))
    end = RADIUS + 0.02 * np.hypot(1.0, slope) - slope * (model.cutters[0].tip - INNER - 0.5 * LENGTH)
    assert tool[5] == pytest.approx(8.0)
    assert tool[0] == pytest.approx(2.0 * end)
    assert np.abs(left(blocks, flank_points(model, data), tool)).max() < said(text)


@pytest.mark.parametrize(("keys", "most"), [({}, 0.0), ({"allowance": 0.2}, 0.2)])
def test_a_smaller_tool_leaves_what_is_stated(tmp_path: Path, keys: dict[str, float], most: float) -> None:
    data = bell()
    model, text, blocks = made(tmp_path, data, kind="flat", diameter=12.0, **keys)
    off = left(blocks, flank_points(model, data), [12.0, 0.0, 6.0, 0.0, 0.0, 0.0, 20.0, 20.0])
    least, largest = model.machined.least, model.machined.most
    assert least is not None
    assert largest is not None
    assert len(fed_passes(blocks)) == 2
    assert least.value - said(text) < off.min()
    assert off.max() < largest.value + said(text)
    assert off.max() > most + 0.3 * (largest.value - most)


def test_a_taper_stands_within_the_cone(tmp_path: Path) -> None:
    data = bell(roller=CONE)
    model, text, blocks = made(tmp_path, data, kind="flat", diameter=8.0, half_angle=8.0)
    off = left(blocks, flank_points(model, data), [8.0, 0.0, 4.0, 0.0, 0.0, 8.0, 20.0, 20.0])
    outcome = model.machined
    assert outcome.certain
    assert outcome.most is not None
    assert len(fed_passes(blocks)) == 2
    assert -said(text) < off.min()
    assert off.max() < outcome.most.value + said(text)
    # What it leaves is what a small end mill leaves in the groove of a cylinder: the wall is twisted.
    assert 1e-4 < outcome.most.value < 5e-3
    # It goes in as far as the roller's cone is as thick at the tool's end.
    most = outcome.data()["largest_tool_diameter_mm"]
    assert Model(from_data(data | {"cutter": {"kind": "flat", "half_angle": 8.0, "diameter": most}})).machining
    with pytest.raises(ProfileError, match=r"cutter.diameter.*does not go into"):
        from_data(data | {"cutter": {"kind": "flat", "half_angle": 8.0, "diameter": most + 1e-6}})


def test_rows_of_a_ball_leave_their_ridges(tmp_path: Path) -> None:
    data = bell()
    model, text, blocks = made(tmp_path, data, kind="ball", diameter=6.0, scallop=0.05)
    figures = model.machined.data()
    points = flank_points(model, data, 400)
    # Below the lowest row the ball does not reach: its centre stands by its radius short of the tool's end.
    points = points[np.hypot(points[:, 0], points[:, 1]) < model.cutters[0].tip - figures["foot_left_mm"]][:60]
    off = left(blocks, points, [6.0, 3.0, 0.0, 3.0, 0.0, 0.0, 20.0, 20.0])
    assert off.min() > -said(text)
    assert 0.2 * figures["scallop_mm"] < off.max() < figures["scallop_mm"] + said(text)


def test_the_tool_comes_and_goes_over_the_ring_s_end_and_turns_within_it(tmp_path: Path) -> None:
    for keys in ({}, {"kind": "flat", "diameter": 12.0}, {"kind": "flat", "diameter": 12.0, "retract": 20.0}):
        model, _, blocks = made(tmp_path, bell(), **keys)
        retract, thick = keys.get("retract", 5.0), 0.5 * keys.get("diameter", 19.04)
        over = [block["Z"] > UP + retract + thick - 1e-3 for block in blocks]
        assert over[0]
        assert over[-1]
        assert sum(over) == 2
        ways = list(zip(blocks, blocks[1:]))
        for before, block in ways:
            if block["G"] == "G0":
                corner = np.hypot(block["X"], abs(block["Y"]) + thick)
                assert corner < INNER - retract + 1e-3
                # Down and up at one place, else at a height of the groove.
                if before["Z"] > UP or block["Z"] > UP:
                    assert (before["X"], before["Y"], before["C"]) == (block["X"], block["Y"], block["C"])
        room = model.machining.room
        assert room is not None
        # From the tool's end along its axis to the ring behind, which the rim of its shank meets first.
        behind = min(block["X"] + np.sqrt(INNER**2 - (abs(block["Y"]) + thick) ** 2) for block in blocks)
        assert room.length == pytest.approx(behind, abs=2e-3)
        assert room.below == pytest.approx(min(block["Z"] for block in blocks if block["G"] == "G1") - 16.0, abs=2e-3)


def test_what_an_angle_head_cannot_do_is_named(tmp_path: Path) -> None:
    for keys, words in (
        ({"kind": "wheel", "diameter": 10.0, "contact": "side", "width": 3.0}, r"cutter.contact.*rim within a ring"),
        ({"pivot": 50.0}, r"cutter.pivot.*does not swing"),
        ({"machine": "plain"}, r"cutter.machine"),
        ({"overrun": 1.0}, r"cutter.overrun"),
        ({"kind": "flat", "diameter": 19.05}, r"cutter.diameter.*at most 19.04 mm"),
    ):
        with pytest.raises(ProfileError, match=words):
            from_data(bell(cutter=keys))
    with pytest.raises(DesignError, match=r"angle head's tool stays square.*APT"):
        made(tmp_path, bell(), kind="flat", diameter=12.0, axis="fitted")
    with pytest.raises(DesignError, match=r"cutter.retract 50 mm leaves .* no place within the ring; below 48.24 mm"):
        made(tmp_path, bell(), kind="flat", diameter=12.0, retract=50.0)
    assert made(tmp_path, bell(), kind="flat", diameter=12.0, retract=48.23)[2]
    milled = Model(from_data(bell(cutter={"kind": "flat", "diameter": 12.0})))
    verdict = judge(milled, ("gouge", "stock-left", "angle-head"))
    assert [word.check for word in verdict.not_judged] == ["angle-head"]
    assert "has to be cut by an angle head" in verdict.not_judged[0].reason
    assert {word.level for word in verdict.findings} == {"pass"}


def in_the_ring(blocks: list[dict], length: float, thick: float) -> float:
    """How deep a straight tool stands in the ring, mm, of points along it and round it, at blocks below its end."""
    along, turn = (each.ravel() for each in np.meshgrid(np.linspace(0.3, 1.0, 40) * length, np.arange(0.0, 6.28, 0.05)))
    low = np.array([(block["X"], block["Y"], block["Z"]) for block in blocks if block["Z"] < UP - thick])
    x, y = low[:, :1] - along, low[:, 1:2] + thick * np.cos(turn)
    z = low[:, 2:] + thick * np.sin(turn)
    return float((np.hypot(x, y) - INNER)[z > 16.0].max())


@pytest.mark.parametrize("keys", [{"kind": "flat", "diameter": 12.0}, {"kind": "flat", "diameter": 12.0, "retract": 20},
                                  {"kind": "wheel", "diameter": 12.0}, {}])  # fmt: skip
def test_a_tool_too_long_for_its_ring_fails(tmp_path: Path, keys: dict[str, Any]) -> None:
    free, _, _ = made(tmp_path, bell(), **keys)
    room, thick = free.machined.data()["head_room_mm"], 0.5 * keys.get("diameter", 19.04)
    assert "head_left_mm" not in free.machined.data()
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        model, text, blocks = made(tmp_path, bell(), length=share * room, **keys)
        verdict = judge(model, ("gouge", "angle-head"))
        found = next(word for word in verdict.findings if word.check == "angle-head")
        assert (found.level, found.value, found.limit) == (level, share * room, room)
        assert model.machined.data()["head_left_mm"] == pytest.approx(room - share * room)
        assert [word.check for word in verdict.not_judged] == ["angle-head"]
        assert [word.check for word in verdict.findings if word.level == "fail"] == ["angle-head"] * (level == "fail")
        # A straight tool moved along the blocks meets the ring by what it is too long.
        assert in_the_ring(blocks, share * room, thick) == pytest.approx((share - 1.0) * room, rel=0.05)
        assert ("STANDS IN THE RING" in text) == (level == "fail")
    assert f"{0.002 * room:.6g} mm longer" in found.advice


def test_without_a_ring_there_is_no_angle_head() -> None:
    drum = Model(read(ROOT / "profiles" / "milled_drum.toml"))
    verdict = judge(drum, ("angle-head",))
    assert (verdict.findings, verdict.not_judged) == ((), ())


@pytest.mark.parametrize("tool", ["roller", "smaller"])
def test_random_rings(tmp_path: Path, tool: str) -> None:
    cut = 0
    for seed in range(190_000, 190_012):
        data = design(seed)
        size, cone = data["cam"]["inner_diameter"], data["roller"].get("shape") == "cone"
        keys: dict[str, Any] = {"tolerance": min(1.0, max(1e-6, 5e-6 * size)), "retract": 0.02 * size}
        if tool == "smaller":
            keys |= {"kind": "flat", "diameter": 0.7 * data["roller"]["diameter"], "gouge_limit": 0.001 * size}
        if cone and tool == "smaller":
            continue
        try:
            model, text, blocks = made(tmp_path, data, **keys)
            points = flank_points(model, data, 30)
        except CamgeomError:
            continue  # Refused or undercut: the campaigns judge what is said of that.
        numbers = [*model.machining.tool.apt(1.0), model.machining.paths[0].height]
        off, slack = left(blocks, points, numbers), 1.02 * said(text) + 1e-9 * size
        least, most = model.machined.least, model.machined.most
        assert least is not None
        assert most is not None
        assert least.value - slack < off.min(), seed
        assert off.max() < most.value + slack, seed
        cut += 1
    assert cut > 2
