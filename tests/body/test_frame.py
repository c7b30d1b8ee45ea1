"""The frame about a constant-width cam as a volume: mesh, load, the sections' forces, peaks, check and files."""

from __future__ import annotations

import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.body import frame_stress
from camgeom.body.element import elasticity, gauss, gradients, shapes, stresses
from camgeom.body.frame import HELD, FrameCells, FrameMesh
from camgeom.body.frame_stress import FrameBending, FrameVolume
from camgeom.body.hexes import HexMesh
from camgeom.body.sparse_solver import SparseElastic
from camgeom.checks import judge
from camgeom.drawing.content import Map, Text
from camgeom.errors import DesignError, ProfileError
from camgeom.export import format_of, write
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.report.result import compute
from camgeom.report.sections.body import body
from camgeom.solid.frame import FramePlate
from tests.body.files import FORMATS, read
from tests.places import PROFILES

COARSE = FrameCells(2, 2, 1, 1, 1, 1, 1, 1, 1)
STEEL = elasticity(206000.0, 0.3)
PLAIN = {"face_width": 144.0, "face_height": 0.0, "window_radius": 0.0}
"""of a window whose faces fill its ends"""


def press(limit: float | None = None, output: dict[str, Any] | None = None, **follower: Any) -> Model:
    data = read_data(PROFILES / "constant_width_press.toml")
    del data["impact"]
    steel = {} if limit is None else {"material": {"roller": {"bending_limit": limit}}}
    return Model(from_data({**data, **steel, "follower": {**data["follower"], **follower},
                            "output": {**data["output"], **(output or {})}}))  # fmt: skip


def plate(model: Model) -> FramePlate:
    assert model.mechanism.frame is not None
    return model.mechanism.frame


def bending(model: Model) -> FrameBending:
    assert model.root_stress is not None
    assert isinstance(model.root_stress.body, FrameBending)
    return model.root_stress.body


def filled(mesh: HexMesh) -> float:
    at, weight = gauss()
    return float((gradients(mesh.nodes[mesh.elements], shapes(at)[1])[1] * weight).sum())


@pytest.mark.parametrize("follower", [
    {},
    {"guide_bore": 0.0},
    {"plate_thickness": 40.0},  # the bore is far from both large faces
    {"plate_thickness": 10.0, "plate_width": 220.0, "guide_bore": 6.0, "guide_spacing": 200.0},
    {"face_width": 136.0, "window_radius": 4.0},
    {"window_radius": 1.0},
    {"window_radius": 0.0},
    PLAIN,
    {**PLAIN, "guide_bore": 0.0},
])  # fmt: skip
def test_the_mesh_fills_the_plate_and_its_nodes_stand_on_the_true_faces(follower: dict[str, Any]) -> None:
    own = plate(press(**follower))
    mesh = FrameMesh(own).mesh
    assert filled(mesh) == pytest.approx(own.volume, rel=3e-4)
    assert all(len(nodes) for nodes in mesh.sets.values())
    x = mesh.nodes - np.array([own.middle, 0.0, 0.0])
    assert np.allclose(np.abs(x[mesh.sets["face"], 0]), 0.5 * own.opening)
    assert np.abs(x[mesh.sets["face"], 1]).max() == pytest.approx(0.5 * own.face)
    root = np.abs(x[mesh.sets["root"], :2]) - [0.5 * own.opening + own.rise - own.corner, 0.5 * own.window - own.corner]
    assert np.allclose(np.hypot(*root.T), own.corner)
    if own.bore:
        around = np.abs(x[mesh.sets[HELD], 1]) - 0.5 * own.spacing, x[mesh.sets[HELD], 2] - own.height
        assert np.allclose(np.hypot(*around), 0.5 * own.bore)
    # Every outer face lies on a named one: nothing is left open between two blocks.
    named = np.unique(np.concatenate(list(mesh.sets.values())))
    corners = np.sort(mesh.elements[:, np.array(((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 4, 5), (1, 2, 5, 6), (2, 3, 6, 7),
                                                 (3, 0, 7, 4)))].reshape(-1, 4), axis=1)  # fmt: skip
    each, count = np.unique(corners, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    assert np.isin(each[count == 1], named).all()


def test_an_even_strain_gives_an_even_stress() -> None:
    own = FrameMesh(plate(press()), COARSE).mesh
    rate = np.array([[1.0, 0.3, -0.2], [0.1, -0.7, 0.4], [0.2, 0.5, 0.6]]) * 1e-3
    moved = own.nodes @ rate.T
    found = stresses(own.nodes[own.elements], moved[own.elements], gauss()[0], STEEL)
    strain = np.array([rate[0, 0], rate[1, 1], rate[2, 2], rate[0, 1] + rate[1, 0], rate[1, 2] + rate[2, 1],
                       rate[2, 0] + rate[0, 2]])  # fmt: skip
    assert np.abs(found - STEEL @ strain).max() < 1e-10 * np.abs(STEEL @ strain).max()
    # And what is held outside takes the same field within: nothing else acts there.
    held = np.unique(np.concatenate(list(own.sets.values())))
    solver = SparseElastic(HexMesh(own.nodes, own.elements, {"skin": held}), STEEL, "skin")
    force = np.zeros_like(own.nodes)
    own_stiffness = own.stiffness(own.nodes[own.elements], STEEL)
    outside = np.zeros_like(moved)
    outside[held] = moved[held]
    np.add.at(force, own.elements, -(own_stiffness @ outside[own.elements].reshape(-1, 60, 1)).reshape(-1, 20, 3))
    inside = solver.solve(force[:, :, None], 1e-13)[:, :, 0] + outside
    assert np.abs(inside - moved).max() < 1e-10 * np.abs(moved).max()


def test_the_load_is_that_of_the_duty_on_the_face_that_it_presses() -> None:
    for degrees, where, way in ((150.0, "near face", 1.0), (250.0, "far face", -1.0), (60.0, "near face", 1.0)):
        model = press(output={"load_angle_deg": degrees})
        volume, drive = model.frame_volume, model.drive
        assert isinstance(volume, FrameVolume)
        assert drive is not None
        theta = np.radians([degrees])
        normal = drive.force.panels.at(drive.contact_forces.max(axis=0), theta)
        assert volume.patch.where == where
        force = volume.forces.sum(axis=0)
        assert force == pytest.approx([way * float(normal[0]), 0.0, 0.0], rel=1e-8, abs=1e-9)
        # The lever about the cam's axis is the rate of the motion: power is force times velocity.
        torque = float(np.cross(volume.nodes, volume.forces).sum(axis=0)[2])
        assert torque == pytest.approx(-volume.patch.y * force[0], rel=1e-9)
        rate = float(model.setup.program.jet(theta, 1)[1][0])
        assert abs(volume.patch.y) == pytest.approx(abs(rate), rel=1e-6, abs=1e-9)
        assert np.isin(volume.sets["patch"], volume.sets[f"face_{where.split()[0]}"]).all()
        assert len(volume.pressed_faces)


def test_a_plate_thicker_than_its_cam_is_pressed_over_the_cams_width() -> None:
    volume = press(plate_thickness=20.0).frame_volume
    assert isinstance(volume, FrameVolume)
    assert volume.patch.length == 16.0
    about = (volume.nodes[:, 2:] - 8.0) ** 2 * volume.forces[:, :1]
    assert float(about.sum()) == pytest.approx(volume.patch.normal * 16.0**2 / 12.0, rel=1e-6)


def test_what_sections_pass_on_is_in_balance_and_near_a_clamped_beams() -> None:
    body = bending(press(**{**PLAIN, "plate_length": 142.0, "plate_width": 240.0, "guide_bore": 8.0,
                            "guide_spacing": 153.5}))  # fmt: skip
    span, y = 2.0 * body.frame.root, np.array([0.0, 30.0, -18.0])
    upper, lower = body.beam(y), body.beam(-y)
    assert np.allclose(upper.cross + lower.cross, 1.0, atol=1e-6)
    assert np.allclose(upper.pull, lower.pull, atol=1e-5)
    # Moments at both corners, and the cross force between them: statics.
    assert np.allclose(upper.moment - lower.moment + (0.5 * span - y) * upper.cross - (0.5 * span + y) * lower.cross,
                       0.0, atol=1e-5 * span)  # fmt: skip
    middle = upper.moment + (0.5 * span - y) * upper.cross
    assert middle[0] - upper.moment[0] == pytest.approx(0.25 * span, rel=1e-6)
    # A slender end between bars that hold it is bent at its corners nearly as a beam that is clamped there, F l / 8.
    assert upper.moment[0] == pytest.approx(-span / 8.0, rel=0.12)
    assert upper.moment[1] == pytest.approx(-((0.5 * span + 30.0) ** 2) * (0.5 * span - 30.0) / span**2, rel=0.15)


def test_the_nominal_stress_is_that_of_the_nodes_forces_and_told_where_it_is() -> None:
    model = press()
    found, frame = model.root_stress, bending(model)
    assert found is not None
    theta, angle = found.theta, float(found.worst.cam_angle)
    assert len(theta) >= 72
    assert found.worst.value == found.nominal.max()
    assert found.worst.where == "plate behind the near face of the frame"
    rounded, sharp = frame.notches
    assert found.worst.value > rounded.max() > sharp.max() > 0.0
    # A solution of the whole mesh under the same load, linearised over the plate behind the contact.
    load = frame.load.asked(angle)
    moved = SparseElastic(frame.frame.mesh, STEEL, HELD).solve(
        frame_stress.nodal(frame.frame, frame.load, load)[:, :, None])[:, :, 0]  # fmt: skip
    mesh, end = frame.frame.mesh, plate(model).ends[1]
    outside = np.flatnonzero((np.abs(mesh.nodes[:, 0] - end) < 1e-6) & (np.abs(mesh.nodes[:, 1]) < 1e-6))
    on = np.isin(mesh.elements, outside)
    stress = stresses(mesh.nodes[mesh.elements[on.any(axis=1)]], moved[mesh.elements[on.any(axis=1)]],
                      np.array([[0.0, 0.0, 0.0]]), STEEL)  # fmt: skip
    assert 0.5 * found.worst.value < float(stress[..., 1].max()) < 1.1 * found.worst.value
    still = press(output={"load_angle_deg": 150.0})
    assert still.root_stress is not None
    assert still.root_stress.patch.theta == pytest.approx(np.radians(150.0))


def known(model: Model, nominal: float, *peaks: float) -> Model:
    """The model with these stresses in place of computed ones, the corner's as large as the largest."""
    found = model.root_stress
    assert found is not None
    body = found.body
    count = len(body.theta)
    vars(body).update(places=(np.full((2, 5, count), nominal), ["", "", "", "", ""]))
    vars(found).update(nominal=np.full(count, nominal),
                       peaks=tuple(frame_stress.StressPeak(value, np.zeros(3), 9) for value in peaks))  # fmt: skip
    return model


@pytest.mark.parametrize(("nominal", "peaks", "level"), [
    (20.0, (401.0, 0.999 * 400.0), "pass"),
    (20.0, (401.0, 1.002 * 400.0), "fail"),
    (0.999 * 400.0, (), "not judged"),
    (1.002 * 400.0, (), "fail"),
    (20.0, (300.0, 390.0), "not judged"),
])  # fmt: skip
def test_the_frame_is_judged_by_its_corners_peak_against_its_own_limit(
    nominal: float, peaks: tuple[float, ...], level: str
) -> None:
    verdict = judge(known(press(400.0, window_radius=4.0 if peaks else 0.0), nominal, *peaks), ["root-stress"])
    if level == "not judged":
        assert "nominal stress" in verdict.not_judged[0].reason
        assert not verdict.findings
    else:
        (finding,) = verdict.findings
        assert (finding.level, finding.limit, finding.unit) == (level, 400.0, "MPa")
        assert "frame" in finding.where or not peaks


@pytest.mark.parametrize(("share", "passes"), [(0.999, True), (1.002, False)])
def test_a_peak_that_impacts_would_bring_beyond_the_limit_does_not_pass(share: float, passes: bool) -> None:
    """The frame is struck with 1.8 times the largest rigid force."""
    data = read_data(PROFILES / "constant_width_press.toml")
    model = Model(from_data({**data, "material": {"roller": {"bending_limit": 400.0}}}))
    struck = max(duty.peak_force.value for turn in model.impact_duties for duty in turn)
    assert model.peak_force is not None
    ratio = struck / model.peak_force.value
    assert ratio > 1.5
    peak = share * 400.0 / ratio
    verdict = judge(known(model, 20.0, peak, peak), ["root-stress"])
    assert [finding.level for finding in verdict.findings] == (["pass"] if passes else [])
    assert passes or "impacts" in verdict.not_judged[0].reason


def test_a_larger_stress_at_a_sharp_foot_keeps_the_corners_peak_from_passing() -> None:
    for foot, levels in ((0.9, ["pass"]), (1.2, [])):
        model = known(press(400.0), 20.0, 300.0, 300.0)
        places = np.full((2, 5, len(bending(model).theta)), 20.0)
        places[:, 2] *= foot
        vars(bending(model)).update(places=(places, [""] * 5))
        assert [finding.level for finding in judge(model, ["root-stress"]).findings] == levels


def test_a_limit_without_a_plate_is_refused_and_a_round_corner_without_a_limit_not_judged() -> None:
    data = read_data(PROFILES / "constant_width_press.toml")
    bare = {"kind": "frame", "mass": 1.2, "clearance": 0.02}
    with pytest.raises(ProfileError, match=r"material\.roller\.bending_limit"):
        from_data({**data, "follower": bare, "material": {"roller": {"bending_limit": 300.0}}})
    (told,) = judge(press(), ["root-stress"]).not_judged
    assert "material.roller.bending_limit" in told.reason
    assert not judge(press(window_radius=0.0), ["root-stress"]).not_judged


def test_result_and_report_have_the_frames_stress(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(frame_stress, "TIMES", (0, 0))
    monkeypatch.setattr(FrameCells, "fine", classmethod(lambda cls, times: FrameCells()))
    model = press(200.0)
    data = compute(model, ("contact", "body")).data["body"]
    assert data["where"] == "window's corner beside the near face of the frame"
    assert data["fatigue_factor"] == pytest.approx(200.0 / data["peak_stress_mpa"])
    assert 1.2 * float(bending(model).notches[0].max()) < data["peak_stress_mpa"]
    assert (data["load_n"], data["wall_mm"]) == pytest.approx((15.0, 12.99))
    blocks = body(model)
    (drawn,) = (block for block in blocks if isinstance(block, Map))
    assert (drawn.x.label, drawn.y.label) == ("x", "y")
    assert float(np.nanmax(drawn.values)) == pytest.approx(data["peak_stress_mpa"], rel=0.05)  # beside the node
    assert np.isnan(drawn.values).any()  # the window
    sharp = press(200.0, window_radius=0.0)
    (said,) = (block for block in body(sharp) if isinstance(block, Text))
    assert "window_radius" in "".join(said.paragraphs)
    assert "where" not in compute(sharp, ("body",)).data["body"]


@pytest.mark.parametrize("form", FORMATS)
def test_files_of_the_frame_read_back_with_their_sets(
    form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "h5py", types.ModuleType("h5py"))
    model = press()
    volume, path = model.frame_volume, tmp_path / f"press.frame.volume.{form}"
    assert write(model, path) == path.stat().st_size
    points, cells, sets = read(path)
    assert np.abs(points - volume.nodes).max() < 1e-7
    assert np.array_equal(cells, volume.elements)
    assert {name: sorted(nodes.tolist()) for name, nodes in sets.items()} == {
        name: sorted(nodes.tolist()) for name, nodes in volume.sets.items()}  # fmt: skip
    if form == "inp":
        assert "guides,1,3" in path.read_text()


def test_a_frame_without_plate_or_load_has_no_volume_and_says_so() -> None:
    data = read_data(PROFILES / "constant_width_press.toml")
    bare = Model(from_data({**data, "follower": {"kind": "frame", "mass": 1.2, "clearance": 0.02}}))
    assert "plate_length" in format_of("frame.volume.inp").missing(bare)
    with pytest.raises(DesignError, match="no frame with a plate"):
        _ = bare.frame_volume
    idle = Model(from_data({key: value for key, value in data.items() if key not in ("operation", "impact", "limits")}))
    assert "no [operation]" in format_of("frame.volume.inp").missing(idle)
    assert format_of("frame.volume.inp").missing(press()) == ""


def test_a_contact_beyond_its_face_is_no_load() -> None:
    with pytest.raises(DesignError, match="leaves the frame's face"):
        _ = press(face_width=30.0).frame_volume
