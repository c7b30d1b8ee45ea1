"""G-code read back with the kinematics that its comments describe: the tool stands where the roller does."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.export import write
from camgeom.model import Model, read
from camgeom.profile import parse
from tests.oracle.cutter_simulation import forward, read_gcode
from tests.places import PROFILES
from tests.reference.milled_cams import DRUM, GLOBOID, model, written


def where_the_tool_is(made: Model, blocks: list[dict], rotary: str, sense: float, helix: bool) -> float:
    """Largest distance of the blocks' ends, and of their axes 100 mm further on, from the exact path at that angle."""
    tip, axis = forward(blocks, rotary, helix)
    phi = sense * np.radians([b[rotary] for b in blocks])
    worst = np.full(len(blocks), np.inf)
    for path in made.machining.paths:
        low, high = path.knots()[[0, -1]]
        at = path.at(np.clip(phi, low, high))
        off = np.linalg.norm(at.tip.T - tip, axis=1) + 100.0 * np.linalg.norm(at.axis.T - axis, axis=1)
        worst = np.minimum(worst, off)
    return float(worst.max())


def cut(path: Path) -> list[dict]:
    """Blocks on the path: all at the feed but the plunge and the arcs, which stand at one angle."""
    blocks = [b for b in read_gcode(path) if b["G"] == "G1"]
    return blocks[1:]


@pytest.mark.parametrize(("kind", "most"), [("flat", 1.0), ("wheel", 1.0), ("roller", 0.0)])
def test_an_arc_in_and_out_fits_beside_the_flank_or_is_refused(kind: str, most: float) -> None:
    """Half of what a tool of 16 mm leaves free in a groove of 20 mm; none where it fills the groove."""
    tool = {"kind": kind} if kind == "roller" else {"kind": kind, "diameter": 16.0}
    assert model(DRUM, **tool, lead=0.999 * most).machining
    with pytest.raises(DesignError, match=r"cutter\.lead .* has no room beside the flank"):
        model(DRUM, **tool, lead=1.002 * most or 0.002).machining  # noqa: B018


@pytest.mark.parametrize("name", ["two_start", "barrel_indexer", "conical_indexer", "fine_indexer", "steep_shuttle"])
def test_every_turret_and_drum(tmp_path: Path, name: str) -> None:
    made = Model(parse((PROFILES / f"{name}.toml").read_text() + "\n[cutter]\n"))
    blocks = cut(written(made, tmp_path, "gcode"))
    sense = made.tracks[0].sense
    assert len(blocks) > 100
    assert where_the_tool_is(made, blocks, "A", sense, False) < 4e-4


@pytest.mark.parametrize("rotary", ["A", "B", "C"])
def test_every_rotary_letter(tmp_path: Path, rotary: str) -> None:
    made = model(GLOBOID, rotary=rotary)
    assert where_the_tool_is(made, cut(written(made, tmp_path, "gcode")), rotary, 1.0, False) < 4e-4


@pytest.mark.parametrize("rotary", ["A", "B", "C"])
def test_wheel_is_set_to_the_helix_angle(tmp_path: Path, rotary: str) -> None:
    made = model(DRUM, kind="wheel", contact="side", diameter=40.0, width=4.0, gouge_limit=20.0, rotary=rotary)
    text = written(made, tmp_path, "gcode")
    blocks = [b for b in read_gcode(text) if b["G"] == "G1"]
    assert where_the_tool_is(made, blocks, rotary, 1.0, True) < 4e-4
    assert "RIGHT-HANDED" in text.read_text()


def test_a_globoids_flank_is_no_work_for_a_wheel_with_one_swing(tmp_path: Path) -> None:
    made = model(GLOBOID, kind="wheel", contact="side", diameter=20.0, width=3.0, gouge_limit=20.0)
    assert made.machined.data()["blocks"]["gcode"] is None
    with pytest.raises(DesignError, match=r"one swing axis cannot set this tool"):
        written(made, tmp_path, "gcode")
    assert not list(tmp_path.iterdir())
    assert written(made, tmp_path, "apt").stat().st_size > 1000


def test_five_axes_hold_a_fitted_tool(tmp_path: Path) -> None:
    """A fitted axis leaves the plane of the cam's own turning: rotary and swing together hold it, block by block."""
    made = model(DRUM, kind="flat", diameter=16.0, axis="fitted", lead=0.0)
    blocks = cut(written(made, tmp_path, "gcode"))
    tip, axis = forward(blocks, "A")
    fine = np.linspace(0.0, 2.0 * np.pi, 4001)
    for k in range(5, len(blocks), 40):
        gaps = []
        for path in made.machining.paths:
            at = path.at(fine)
            i = int(np.argmin(np.linalg.norm(at.tip.T - tip[k], axis=1)))
            near = path.at(fine[i] + np.linspace(-2e-3, 2e-3, 2001))
            j = int(np.argmin(np.linalg.norm(near.tip.T - tip[k], axis=1)))
            gaps.append(np.linalg.norm(near.tip.T[j] - tip[k]) + 10.0 * np.linalg.norm(near.axis.T[j] - axis[k]))
        assert min(gaps) < 5e-4


def test_gcode_needs_a_cutter_and_other_cutter_data_say_what_is_assumed(tmp_path: Path) -> None:
    made = read(PROFILES / "pin_insertion.toml")
    with pytest.raises(DesignError, match=r"needs a \[cutter\] table"):
        write(made, tmp_path / "cam.gcode")
    assert not list(tmp_path.iterdir())
    write(made, tmp_path / "cam.apt")
    assert "ASSUMED" in (tmp_path / "cam.apt").read_text()
    assert "ASSUMED" not in written(model(DRUM), tmp_path, "apt").read_text()


@pytest.mark.parametrize(("rotary", "clear"), [("A", "Z"), ("C", "X")])
def test_the_tool_comes_over_its_start_and_then_down(tmp_path: Path, rotary: str, clear: str) -> None:
    """One thing at a time: the rotary axis, both other linear axes, the spindle's with the tool's length; then feed."""
    lines = written(model(DRUM, rotary=rotary, tool_number=7), tmp_path, "gcode").read_text().splitlines()
    way = lines[lines.index("G54") :]
    assert way[1] == f"G53 G0 {clear}0."
    turn, over, down = [line for line in way if line.startswith(("G0", "G43"))][:3]
    assert turn.split()[0] == "G0"
    assert [word[0] for word in turn.split()[1:]] == [rotary]
    assert sorted(word[0] for word in over.split()[1:]) == sorted(set("XYZ") - {clear})
    assert down.startswith(f"G43 H7 G0 {clear}")
    assert next(line for line in way[way.index(down) + 1 :] if line[:2] in ("G0", "G1")).startswith("G1")
    assert lines[-6:] == [f"G53 G0 {clear}0.", "G49", "M9", "M5", "M30", "%"]


def test_the_head_says_what_the_decimals_cost(tmp_path: Path) -> None:
    """Chords of 1e-6 mm are not what coordinates of 1e-4 mm give: the blocks read back stand off by what is said."""
    made = model(DRUM, tolerance=1e-4, lead=0.0)
    text = written(made, tmp_path, "gcode")
    head = text.read_text()
    said = float(re.search(r"DECIMALS ([0-9.E-]+)", head)[1])
    tip, _ = forward(cut(text), "A")
    fine = made.machining.paths[0]
    off = []
    for point, block in zip(tip[::25], cut(text)[::25]):
        near = fine.at(np.radians(block["A"]) + np.linspace(-1e-5, 1e-5, 2001))
        off.append(np.linalg.norm(near.tip.T - point, axis=1).min())
    assert 0.1 * said < max(off) < said
    assert "PLUNGES STRAIGHT" in head
