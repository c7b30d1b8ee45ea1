"""The root of a groove: the sweep of the tool's torus corner, in mesh, STEP and stock, and what collides."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

from camgeom.checks import findings
from camgeom.errors import DesignError, ProfileError
from camgeom.export.step.bodies import model_bodies
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from tests.oracle.cams import judges_of
from tests.places import PROFILES, ROOT

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from judging import judge

SWING = {"kind": "swinging", "arm": 90.0, "inertia": 0.01}
CROWN = {"shape": "crowned", "diameter": 22.0, "length": 12.0, "crown_radius": 400.0}


def changed(name: str = "pin_insertion", **tables: dict[str, Any]) -> dict[str, Any]:
    """A shipped profile with other keys in some tables."""
    data = read_data(PROFILES / f"{name}.toml")
    return {**data, **{table: {**data.get(table, {}), **keys} for table, keys in tables.items()}}


def made(data: dict[str, Any]) -> Model:
    return Model(from_data(data))


def oracle_distances(model: Model, data: dict[str, Any], x: np.ndarray) -> np.ndarray:
    program = model.setup.program
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(data, lambda phi: program.jet(phi, 0)[0], low, high, ends)
    return np.asarray(oracle.least(x))


@pytest.mark.parametrize("name", ["pin_insertion", "disc_face_groove"])
@pytest.mark.parametrize("root", [0.2, 1.0, 4.0])
def test_vertices_of_flank_root_and_floor_lie_on_the_tool_with_a_corner(name: str, root: float) -> None:
    data = changed(name, cam={"root_radius": root})
    model = made(data)
    mesh, rng = model.solid.mesh, np.random.default_rng(20)
    assert model.solid.sound
    for group in ("flank", "root", "floor"):
        vertices = mesh.vertices[mesh.group_vertices(group)]
        picked = vertices[rng.choice(len(vertices), min(len(vertices), 60), replace=False)]
        assert np.abs(oracle_distances(model, data, picked)).max() < 1e-9


@pytest.mark.parametrize(
    "tables",
    [
        {"cam": {"root_radius": 0.8}},
        {"cutter": {"kind": "flat", "diameter": 16.0, "corner_radius": 0.8}},
        {"cam": {"root_radius": 0.9, "direction": "cw", "running_clearance": 0.02}},
        {"cam": {"root_radius": 0.7}, "roller": CROWN},
    ],
)  # fmt: skip
def test_the_stability_judge_finds_the_rounded_body_good(tables: dict[str, Any]) -> None:
    record = judge(changed(**tables))
    assert record["outcome"] == "good" or record["findings"] == ["life"], record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


@pytest.mark.parametrize("tables", [{"cam": {"root_radius": 0.8}}, {"cam": {"root_radius": 0.6, "direction": "cw"}},
                                    {"cutter": {"kind": "flat", "diameter": 16.0, "corner_radius": 0.8}}])  # fmt: skip
def test_the_stability_judge_finds_the_rounded_plate_good(tables: dict[str, Any]) -> None:
    record = judge(changed("disc_face_groove", **tables))
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


@pytest.mark.parametrize("tables", [
    {"cam": {"root_radius": 1.0}}, {"cam": {"root_radius": 2.5, "hand": "left", "running_clearance": 0.02}},
])  # fmt: skip
def test_a_globoids_flanks_and_roots_lie_on_the_tool_with_a_corner(tables: dict[str, Any]) -> None:
    data = changed("tool_changer", **tables)
    model, program = made(data), made(data).setup.program
    assert model.solid.sound
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(data, lambda phi: program.jet(phi, 0)[0], low, high, ends)
    mesh = model.solid.mesh
    for group in ("flank", "root", "floor"):
        vertices = mesh.vertices[mesh.group_vertices(group)]
        picked = vertices[:: max(1, len(vertices) // 40)]
        if group != "floor":
            assert np.abs(oracle.least(picked, loose=True)).max() < 1e-9
        else:
            assert oracle.least(picked).min() > 0.5  # the rollers' ends keep their tip clearance


def test_a_globoids_root_of_any_size_stays_clear_of_the_rollers_edges_or_says_so() -> None:
    for root in (1.0, 4.0):
        model = made(changed("tool_changer", cam={"root_radius": root}))
        (track, *_), (tool, *_) = model.passages, model.cutters
        over, aside = tool.tip - track.tip, model.cam.running_clearance
        room = root - float(np.hypot(root - aside, root - over)) if max(over, aside) < root else np.inf
        assert (interference(root, "tool_changer") == "pass") == (room >= 0.0)


def test_step_of_a_globoid_has_its_roots() -> None:
    verdict = check_solid(model_bodies(made(changed("tool_changer", cam={"root_radius": 1.0}))))
    assert not verdict.problems


def test_a_groove_that_runs_out_keeps_its_root() -> None:
    record = judge(changed("feeder_runout", cam={"root_radius": 0.5}))
    assert record["outcome"] in ("good", "finding"), record
    assert record["error"] <= 1.0 + 1e-6


def test_a_small_root_tends_to_the_sharp_body() -> None:
    sharp, small, round_ = (made(changed(cam={"root_radius": r})).solid.mesh.volume for r in (0.0, 0.02, 1.0))
    # A fillet leaves (1 - pi/4) r² more for its length: two of them, some 700 mm round the drum.
    assert abs(small - sharp) < 20.0  # what the chord errors differ by
    assert 200.0 < round_ - sharp < 400.0


def interference(root: float, name: str = "pin_insertion") -> str:
    model = made(changed(name, cam={"root_radius": root}))
    return next(f.level for f in findings(model) if f.check == "interference")


def test_a_roller_with_a_sharper_edge_than_the_root_collides() -> None:
    # The roller's end stands 1 mm above the floor, where a root of 1 mm begins.
    assert interference(1.0) == "pass"
    assert interference(1.002) == "fail"
    # The plate's roller has 0.03 mm of clearance: its edge, 1 mm above the floor, meets a root of 1.275 mm.
    edge = 1.0 + 0.03 + np.sqrt(2.0 * 0.03)
    assert interference(0.999 * edge, "disc_face_groove") == "pass"
    assert interference(1.002 * edge, "disc_face_groove") == "fail"


@pytest.mark.parametrize("name", ["pin_insertion", "disc_face_groove"])
def test_step_has_the_root_as_faces_of_one_valid_solid(name: str) -> None:
    model = made(changed(name, cam={"root_radius": 1.0}))
    brep = model_bodies(model)
    assert isinstance(brep, Brep)
    verdict = check_solid(brep)
    assert not verdict.problems
    assert {"root", "flank", "floor"} <= {face.name for face in brep.faces}
    assert "edge" not in {face.name for face in brep.faces}
    fine = Model(from_data(changed(name, cam={"root_radius": 1.0})), 5e-4).solid.mesh.volume
    assert abs(verdict.volume - fine) < 5e-4 * model.solid.mesh.area


def test_both_keys_agree_or_are_refused() -> None:
    tool = {"kind": "flat", "diameter": 16.0, "corner_radius": 0.8}
    assert made(changed(cam={"root_radius": 0.8}, cutter=tool)).mechanism.root_radius == 0.8
    assert made(changed(cutter=tool)).mechanism.root_radius == 0.8
    with pytest.raises(ProfileError, match=r"cam\.root_radius.*0\.8 mm, or none"):
        made(changed(cam={"root_radius": 0.9}, cutter=tool))


@pytest.mark.parametrize(
    ("name", "tables", "word"),
    [
        ("pin_insertion", {"cam": {"root_radius": 11.0}}, "below 11 mm"),
        ("pin_insertion", {"cam": {"root_radius": 0.001}}, "0.01 mm"),
        ("pin_insertion", {"cutter": {"kind": "ball", "diameter": 6.0, "corner_radius": 1.0}}, "no corner of its own"),
        ("pin_insertion", {"cam": {"root_radius": 1.0}, "cutter": {"kind": "ball", "diameter": 6.0}}, "roller, flat"),
        ("pin_insertion", {"cutter": {"kind": "flat", "diameter": 1.5, "corner_radius": 1.0}}, "at least twice"),
        ("pin_insertion", {"cam": {"root_radius": 1.0, "form": "rib", "rib_thickness": 12.0}}, "beside a rib"),
        ("steep_shuttle", {"cam": {"root_radius": 1.0}}, "cylindrical tool"),
        ("disc_face_groove", {"cam": {"root_radius": 12.2}}, "below 12 mm"),
        ("disc_offset_roller", {"cam": {"root_radius": 1.0}}, "only form = 'groove'"),
        ("barrel_indexer", {"cutter": {"corner_radius": 1.0}}, "sharp one so far"),
        ("tool_changer", {"cam": {"root_radius": 1.0, "relief": 0.02}}, "0 beside a rounded root"),
        ("tool_changer", {"cam": {"root_radius": 1.0, "preload": 0.02}}, "0 beside a rounded root"),
        ("conical_indexer", {"cam": {"root_radius": 1.0}}, "cylindrical tool"),
        ("disc_flat_face", {"cutter": {"kind": "flat", "diameter": 8.0, "corner_radius": 1.0}}, "no root"),
    ],
)  # fmt: skip
def test_what_has_no_such_root_refuses_the_key_by_name(name: str, tables: dict[str, Any], word: str) -> None:
    with pytest.raises(ProfileError, match=word):
        made(changed(name, **tables))


def test_a_root_as_high_as_the_flank_is_refused_with_the_reason() -> None:
    with pytest.raises(DesignError, match="leaves no flank"):
        _ = made(changed(cam={"root_radius": 10.9, "groove_depth": 11.2}, roller={"length": 0.2})).solid


def test_the_rough_body_of_an_undercut_drum_is_not_made_with_a_root() -> None:
    data = changed(cam={"root_radius": 1.0, "diameter": 90.0, "pitch_radius": 45.0}, output={"undercut_solid": True})
    with pytest.raises(DesignError, match="sharp root"):
        _ = made(data).solid


def test_a_tool_like_the_groove_leaves_no_stock_and_one_with_a_corner_cannot_reach_below_it() -> None:
    sharp = made(changed("milled_drum"))
    round_ = made(changed("milled_drum", cutter={"corner_radius": 0.8}))
    assert round_.machined.machining.tool.corner == 0.8
    s, across = np.array([0.0, 0.0, 0.8, 3.0]), np.array([8.0, 7.2, 8.0, 7.0])
    found = round_.machined.machining.tool.distance(s, across)
    assert np.allclose(found, [0.8 * (np.sqrt(2.0) - 1.0), 0.0, 0.0, -1.0])
    most = [model.machined.most for model in (sharp, round_)]
    assert most[0] is not None
    assert most[1] is not None
    assert most[1].value == pytest.approx(most[0].value, abs=5e-4)
