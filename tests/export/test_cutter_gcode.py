"""G-code read back with the kinematics that its comments describe: the tool stands where the roller does."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.model import Model, read
from tests.oracle.cutter_simulation import read_gcode, turned
from tests.places import PROFILES
from tests.reference.milled_cams import DRUM, GLOBOID, model, written

LETTERS = {"A": "ZYXBC", "B": "ZXYAC", "C": "XYZBA"}
"""radial, across and axial linear axes, the swing about the across axis and about the radial one"""
UNIT = {"X": [1.0, 0.0, 0.0], "Y": [0.0, 1.0, 0.0], "Z": [0.0, 0.0, 1.0]}


def rotated(v: np.ndarray, axis: str, angle: np.ndarray) -> np.ndarray:
    """Vectors (n, 3) turned right-handed about a machine axis (Rodrigues)."""
    k = np.array(UNIT[axis])
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    return v * c + np.cross(np.broadcast_to(k, v.shape), v) * s + (v @ k)[:, None] * k * (1.0 - c)


def forward(blocks: list[dict], rotary: str, helix: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Ends and axes in the cam frame: the machine's frame is right-handed with the cam along its axial letter."""
    radial, across, axial, tilt, about_radial = LETTERS[rotary]
    columns = {w: np.array([b.get(w, 0.0) for b in blocks]) for w in "XYZABC"}
    point = np.stack([columns[w] for w in "XYZ"], axis=1)
    n = len(blocks)
    sign = float(np.dot(np.cross(UNIT[axial], UNIT[radial]), UNIT[across]))
    if helix:
        zero = np.tile(sign * np.array(UNIT[across]), (n, 1))
        spindle = rotated(zero, radial, np.radians(columns[about_radial]))
    else:
        spindle = rotated(np.tile(UNIT[radial], (n, 1)), across, np.radians(columns[tilt]))
    # Cam x, y, z are the radial direction, the third one, and the axial direction.
    frame = np.array([UNIT[radial], np.cross(UNIT[axial], UNIT[radial]), UNIT[axial]])
    turn = -np.radians(columns[rotary])
    return turned(point @ frame.T, turn), turned(spindle @ frame.T, turn)


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


@pytest.mark.parametrize("name", ["two_start", "barrel_indexer", "conical_indexer", "fine_indexer", "steep_shuttle"])
def test_every_turret_and_drum(tmp_path: Path, name: str) -> None:
    made = read(str(PROFILES / f"{name}.toml"))
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
