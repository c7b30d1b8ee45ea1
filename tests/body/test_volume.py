"""Volume meshes: nodes on the true faces, a load that is the duty's, and files that others read back whole."""

from __future__ import annotations

import sys
import tempfile
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import Delaunay

from camgeom.body.element import gauss, gradients, least_volume, shapes
from camgeom.body.grooves import grooves_of
from camgeom.body.load import RollerForce
from camgeom.body.tetra import TetraMesh, quadratic, turret_sample
from camgeom.body.volume import BodyVolume
from camgeom.errors import DesignError
from camgeom.export import format_of, write
from camgeom.export import volume as writers
from camgeom.mechanics.material import Material
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.solid.blank import Blank
from tests.body.files import FORMATS, read
from tests.body.ribs import ribbed
from tests.oracle.cams import judges_of
from tests.places import PROFILES


def changed(name: str, **tables: dict[str, Any]) -> dict[str, Any]:
    data = read_data(PROFILES / f"{name}.toml")
    return {**data, **{table: {**data.get(table, {}), **keys} for table, keys in tables.items()}}


PIN = changed("pin_insertion", cam={"root_radius": 1.0}, output={"load_angle_deg": 298.0})


@pytest.fixture(scope="module")
def pin() -> Model:
    return Model(from_data(PIN))


def volume_mm3(volume: BodyVolume) -> float:
    at, weight = gauss()
    return float((gradients(volume.ring.nodes[volume.ring.elements], shapes(at)[1])[1] * weight).sum())


def test_nodes_stand_on_the_true_faces(pin: Model) -> None:
    volume, program = pin.volume, pin.setup.program
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(PIN, lambda phi: program.jet(phi, 0)[0], low, high, ends)
    rng = np.random.default_rng(5)
    for name in ("flank_lower", "flank_upper", "root_lower", "root_upper", "floor"):
        nodes = volume.sets[name]
        picked = volume.ring.nodes[rng.choice(nodes, min(40, len(nodes)), replace=False)]
        assert np.abs(oracle.least(picked)).max() < 1e-7
    x = volume.ring.nodes
    rho = np.hypot(x[:, 0], x[:, 1])
    assert np.allclose(rho[volume.sets["bore"]], 20.0)
    assert np.allclose(rho[volume.sets["land"]], 67.0)
    assert np.allclose(x[volume.sets["end_upper"], 2], 110.0)
    # The keyway, 12 x some 3.8 mm over the whole length, is left out.
    assert 0.0 < volume_mm3(volume) - pin.solid.mesh.volume < 1.05 * 12.0 * 4.0 * 110.0
    assert "keyway" in " ".join(volume.about)


def test_the_load_is_that_of_the_duty(pin: Model) -> None:
    volume = pin.volume
    force, patch = volume.forces.sum(axis=0), volume.patch
    assert patch.normal == pytest.approx(1882.96, rel=1e-5)
    assert np.linalg.norm(force) == pytest.approx(patch.normal, rel=2e-3)  # the normal turns a little along the line
    assert patch.where == "the upper flank"
    assert force[2] > 0.95 * patch.normal
    torque = np.cross(volume.ring.nodes, volume.forces).sum(axis=0)[2]
    at = float(pin.duty.force.panels.at(pin.duty.torque, np.array([np.radians(298.0)]))[0])
    assert abs(torque) == pytest.approx(abs(at), rel=1e-3)
    assert 7.5 < patch.thickness < 8.5
    every = Model(from_data(changed("pin_insertion", cam={"root_radius": 1.0}))).volume
    assert 290.0 < np.degrees(every.patch.theta) < 310.0


PLATE = changed("disc_face_groove", cam={"root_radius": 1.0}, output={"load_angle_deg": 100.0})


def test_a_plate_with_a_groove_is_a_ring_on_its_true_faces() -> None:
    model = Model(from_data(PLATE))
    volume, program, duty = model.volume, model.setup.program, model.duty
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(PLATE, lambda phi: program.jet(phi, 0)[0], low, high, ends)
    for name in ("flank_inner", "flank_outer", "root_inner", "root_outer", "floor"):
        assert np.abs(oracle.least(volume.ring.nodes[volume.sets[name][::97]])).max() < 1e-7
    x = volume.ring.nodes
    rho = np.hypot(x[:, 0], x[:, 1])
    assert np.allclose(rho[volume.sets["bore"]], 17.5)
    assert np.allclose(rho[volume.sets["rim"]], 110.0)
    assert np.allclose(x[volume.sets["end_lower"], 2], 0.0)
    assert np.allclose(x[volume.sets["land"], 2], 24.0)
    assert volume_mm3(volume) == pytest.approx(model.solid.mesh.volume, rel=2e-3)
    assert np.linalg.norm(volume.forces.sum(axis=0)) == pytest.approx(volume.patch.normal)
    torque = np.cross(x, volume.forces).sum(axis=0)[2]
    at = float(duty.force.panels.at(duty.torque, np.array([np.radians(100.0)]))[0])
    assert abs(torque) == pytest.approx(abs(at), rel=1e-3)
    assert set(volume.sets["patch"]) & set(volume.sets[f"flank_{volume.patch.where.split()[1]}"])


def test_a_sharp_root_is_rounded_and_said_so() -> None:
    volume = Model(from_data(changed("pin_insertion"))).volume
    assert any("sharp root is rounded by 0.78 mm" in line for line in volume.about)


@pytest.mark.parametrize("name", ["disc_offset_roller", "disc_flat_face", "constant_width_press", "end_face_lifter",
                                  "conjugate_rocker", "parallel_index"])  # fmt: skip
def test_plates_frames_and_end_faces_are_rings(name: str) -> None:
    model = Model(from_data(changed(name)))
    volume = model.volume
    assert isinstance(volume, BodyVolume)
    assert np.linalg.norm(volume.forces.sum(axis=0)) == pytest.approx(volume.patch.normal, rel=1e-3)
    solid = next(solid for solid in model.solids if solid.name == volume.name)
    assert volume_mm3(volume) == pytest.approx(solid.mesh.volume, rel=0.012)  # keyway and marks are left out
    assert {"bore", "flank", "end_lower", "patch"} <= set(volume.sets)
    x, torque = volume.ring.nodes, 0.0
    if model.turret_duty is not None:
        at = np.argmin(np.abs(model.turret_duty.theta - volume.patch.theta))
        points, inward, sizes, _ = model.turret_duty.pressed(int(at))
        torque = float(np.cross(points, sizes[:, None] * inward).sum(axis=0)[2])
        assert np.cross(x, volume.forces).sum(axis=0)[2] == pytest.approx(torque, rel=1e-3)


def test_end_face_nodes_stand_on_the_true_face() -> None:
    data = changed("end_face_lifter")
    model = Model(from_data(data))
    program = model.setup.program
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(data, lambda phi: program.jet(phi, 0)[0], low, high, ends)
    volume = model.volume
    assert np.abs(oracle.least(volume.nodes[volume.sets["flank"][::11]])).max() < 1e-7


def test_a_rib_stands_on_its_drum_with_its_flanks_on_the_rollers() -> None:
    data = ribbed(6.0)
    model = Model(from_data(data))
    program, volume = model.setup.program, model.volume
    low, high = (float(end.value) for end in program.extremes(0))
    ends = np.array([span.end for span in program.spans])
    (oracle,) = judges_of(data, lambda phi: program.jet(phi, 0)[0], low, high, ends)
    assert isinstance(volume, BodyVolume)
    for name in ("flank_lower", "flank_upper"):
        nodes = volume.nodes[volume.sets[name][::11]]
        above = np.hypot(nodes[:, 0], nodes[:, 1]) > 50.0  # where the roller begins
        assert np.abs(oracle.least(nodes[above])).max() < 1e-7
    rho = np.hypot(volume.nodes[:, 0], volume.nodes[:, 1])
    for name, radius in (("land", 60.0), ("base", 48.0), ("bore", 15.0)):
        assert np.allclose(rho[volume.sets[name]], radius)
    assert volume_mm3(volume) == pytest.approx(model.solid.mesh.volume, rel=2e-3)
    assert np.linalg.norm(volume.forces.sum(axis=0)) == pytest.approx(volume.patch.normal, rel=1e-3)
    assert least_volume(volume.nodes[volume.elements]) > 0.0
    # The roller that presses there is the one whose flank is loaded.
    for degrees in (100.0, 150.0):
        asked = Model(from_data({**data, "output": {"load_angle_deg": degrees}})).volume
        duty = max(model.duties, key=lambda one: abs(float(one.force.panels.at(one.normal, np.radians([degrees]))[0])))
        assert isinstance(asked, BodyVolume)
        assert asked.patch.where == f"the rib's {duty.track.name.split()[0]} flank"
        assert asked.forces.sum(axis=0)[2] * (1.0 if "lower" in asked.patch.where else -1.0) > 0.0
        touches = RollerForce(duty).points(float(np.radians(degrees)))
        acts = np.cross(touches.points, touches.forces).sum(axis=0)
        assert np.abs(np.cross(asked.nodes, asked.forces).sum(axis=0) - acts).max() < 1e-6 * np.abs(acts).max()


def test_what_is_not_meshed_says_why() -> None:
    model = Model(from_data(changed("pin_insertion", cam={"bore": 0.0, "keyway_width": 0.0, "keyway_depth": 0.0})))
    with pytest.raises(DesignError, match="without a bore"):
        _ = model.volume
    assert "without a bore" in format_of("volume.inp").missing(model)


def test_a_steep_groove_of_a_cone_is_meshed_as_thick_as_its_roller_is_at_each_depth() -> None:
    """With the roller's middle for its end the elements of this groove were folded."""
    model = Model(from_data(changed("steep_shuttle", cam={"keyway_width": 0.0, "keyway_depth": 0.0})))
    corners = model.volume.nodes[model.volume.elements]
    assert least_volume(corners) > 0.0
    assert volume_mm3(model.volume) == pytest.approx(model.solid.mesh.volume, rel=1e-3)
    with pytest.raises(DesignError, match="folded"):
        gradients(corners * [1.0, 1.0, -1.0], shapes(gauss()[0])[1])


def with_rim() -> dict[str, Any]:
    """A plate whose rim is a second track."""
    data = changed("both_faces_disc")
    groove, (track,) = {k: v for k, v in data["cam"].items() if k != "diameter"}, data["track"]
    cam = {"form": "external", "base_radius": 96.0}
    rest = {key: value for key, value in track.items() if key != "cam"}
    data.pop("cutter")
    return {**data, "cam": {**groove, "rim": "profile"}, "track": ({**rest, "cam": cam},)}


@pytest.mark.parametrize("data", [changed("linear_groove"), with_rim()])
def test_no_volume_is_offered_of_a_body_that_has_none(data: dict[str, Any]) -> None:
    model = Model(from_data(data))
    assert "plates that slide, plates whose rim is a track" in format_of("volume.inp").missing(model)
    with pytest.raises(DesignError, match="plates that slide"):
        _ = model.volume


@pytest.mark.parametrize(("name", "degrees", "track", "flank"), [
    ("two_groove_drum", None, 0, "lower"), ("two_groove_drum", 160.0, 1, None), ("two_groove_drum", 60.0, 0, None),
    ("both_faces_disc", None, 1, "outer"), ("both_faces_disc", 60.0, 0, None), ("both_faces_disc", 200.0, 1, None),
])  # fmt: skip
def test_a_body_with_two_tracks_is_pressed_by_the_harder_one(
    name: str, degrees: float | None, track: int, flank: str | None
) -> None:
    output = {} if degrees is None else {"load_angle_deg": degrees}
    model = Model(from_data(changed(name, output=output)))
    assert format_of("volume.inp").missing(model) == ""
    volume, one = model.volume, model.grooves[track]
    assert isinstance(volume, BodyVolume)
    assert least_volume(volume.nodes[volume.elements]) > 0.0
    assert volume_mm3(volume) == pytest.approx(model.solid.mesh.volume, rel=4e-3)  # the keyway is left out
    assert volume.patch.where.endswith(f"of track {track + 1}")
    assert flank is None or flank in volume.patch.where
    # Cam angles are told as the cam's; the second follower's own are less by its place about the cam.
    assert degrees is None or np.degrees(volume.patch.theta) == pytest.approx(degrees)
    own = np.array([(volume.patch.theta - one.angle) % (2.0 * np.pi)])
    duty = max(one.duties, key=lambda duty: float(np.abs(duty.force.panels.at(duty.normal, own))[0]))
    assert volume.patch.normal == pytest.approx(abs(float(duty.force.panels.at(duty.normal, own)[0])), rel=1e-6)
    torque = float(np.cross(volume.nodes, volume.forces).sum(axis=0)[2])
    assert abs(torque) == pytest.approx(abs(float(duty.force.panels.at(duty.torque, own)[0])), rel=2e-3)
    for number in (1, 2):
        for face in ("flank", "root"):
            first, other = (one for one in volume.sets if one.startswith(f"{face}_") and one.endswith(str(number)))
            assert len(volume.sets[first])
            assert set(volume.sets[first]) | set(volume.sets[other]) <= set(volume.sets[face])
    word = volume.patch.where.removeprefix("the ").split()[0]
    assert set(volume.sets["patch"]) & set(volume.sets[f"flank_{word}_{track + 1}"])


@pytest.mark.parametrize("name", ["two_groove_drum", "both_faces_disc"])
def test_nodes_of_two_grooves_stand_on_the_true_faces(name: str) -> None:
    import pyvista

    model = Model(from_data(changed(name, output={"tolerance": 0.002})))
    volume, mesh = model.volume, model.solid.mesh
    surface = pyvista.PolyData.from_regular_faces(mesh.vertices, np.asarray(mesh.faces))
    for number in (1, 2):
        for flank in [name for name in volume.sets if name.startswith("flank_") and name.endswith(str(number))]:
            x = volume.nodes[volume.sets[flank][::17]]
            _, on = surface.find_closest_cell(x, return_closest_point=True)
            assert np.sqrt(((x - np.asarray(on)) ** 2).sum(axis=1)).max() < 0.0025


def test_the_wall_between_two_grooves_is_their_land() -> None:
    """Two grooves that stand still: what is left between them is their distance less both radii."""
    data = changed("two_groove_drum", cam={"keyway_width": 0.0, "keyway_depth": 0.0})
    still = tuple({**one, "to": 1e-4 * one["to"]} if one.get("to") else one for one in data["motion"])
    (track,) = data["track"]
    slow = tuple({**one, "to": 1e-4 * one["to"]} if one.get("to") else one for one in track["motion"])
    model = Model(from_data({**data, "motion": still, "track": ({**track, "motion": slow},)}))
    body = grooves_of(model.parts[0], [one.cutters for one in model.grooves])
    assert body is not None
    theta, width = np.linspace(0.0, 6.0, 5), 102.0 - 24.0 - 0.5 * (19.0 + 16.0)
    for number, one in enumerate(model.grooves):
        walled = body.walled(number)
        t = one.tracks[0].meridian.parameter(0.5 * sum(one.tracks[0].contact))
        inner, outer = (next(walled.thickness(theta, side, t) for side in (1.0, -1.0) if walled.second(side) == second)
                        for second in ((True, False) if number == 0 else (False, True)))  # fmt: skip
        assert inner == pytest.approx(width, abs=0.01)
        assert outer == pytest.approx(24.0 - 9.5 if number == 0 else 150.0 - 102.0 - 8.0, abs=0.01)


@pytest.mark.parametrize("name", ["pin_insertion", "disc_face_groove", "conjugate_rocker", "tool_changer",
                                  "feeder_runout"])  # fmt: skip
def test_a_volume_is_offered_of_a_body_that_may_have_one(name: str) -> None:
    assert format_of("volume.vtu").missing(Model(from_data(changed(name)))) == ""


def test_the_load_of_a_groove_that_runs_out_is_that_of_the_duty() -> None:
    duty = Model(from_data(changed("feeder_runout"))).duty
    load = RollerForce(duty).points(None)
    assert np.linalg.norm(load.forces.sum(axis=0)) == pytest.approx(duty.peak_force.value, rel=5e-3)
    at = float(duty.force.panels.at(duty.torque, np.array([load.theta]))[0])
    assert abs(np.cross(load.points, load.forces).sum(axis=0)[2]) == pytest.approx(abs(at), rel=0.03)


def test_the_forces_of_rollers_that_share_are_those_of_the_duty() -> None:
    duty = Model(from_data(changed("tool_changer"))).turret_duty
    assert duty is not None
    at = turret_sample(duty, None)
    points, inward, sizes, _ = duty.pressed(at)
    forces = sizes[:, None] * inward
    assert sizes.sum() == pytest.approx(duty.roller_load[at].sum())
    theta = duty.theta[at : at + 1]
    assert abs(np.cross(points, forces).sum(axis=0)[2]) == pytest.approx(
        abs(float(duty.force.panels.at(duty.torque, theta)[0])), rel=1e-9
    )
    still = int(np.argmin(np.abs(duty.turret_torque)))
    assert not duty.roller_load[still].any()
    with pytest.raises(DesignError, match="nothing presses"):
        turret_sample(duty, float(duty.theta[still]))


def tetrahedra() -> TetraMesh:
    """A rough cylinder, filled without a mesher; its nodes move onto the faces of a fine one."""
    rough, fine = (Blank.cylinder(20.0, 30.0).mesh(tolerance) for tolerance in (0.4, 0.002))
    nodes = np.concatenate([rough.vertices, [[0.3, 0.2, 15.0]]])
    return quadratic(fine, nodes, Delaunay(nodes).simplices.astype(np.int64))


def test_tetrahedra_have_their_outer_nodes_on_the_faces_and_carry_the_load() -> None:
    mesh = tetrahedra()
    assert mesh.left_off < 1e-9
    rho = np.hypot(*mesh.nodes[mesh.sets["land"], :2].T)
    assert np.all(np.abs(rho - 20.0) < 0.002)
    assert np.abs(mesh.nodes[mesh.sets["end"], 2] * (mesh.nodes[mesh.sets["end"], 2] - 30.0)).max() < 1e-9
    points = np.array([[20.0, 0.0, 11.0], [0.0, 20.0, 17.0]])
    forces = np.array([[-3.0, 0.0, 1.0], [0.5, -7.0, 0.0]])
    loads = mesh.spread(points, forces)
    assert np.allclose(loads.sum(axis=0), forces.sum(axis=0))
    lever = np.cross(points, forces).sum(axis=0)
    assert np.allclose(np.cross(mesh.nodes, loads).sum(axis=0), lever, atol=0.02 * np.abs(lever).max())


def test_a_globoid_needs_the_mesher_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pytetwild", None)
    with pytest.raises(DesignError, match=r"camgeom\[tetra\]"):
        _ = Model(from_data(changed("tool_changer"))).volume


@pytest.mark.parametrize("form", FORMATS)
def test_meshio_reads_back_nodes_elements_and_sets(pin: Model, form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # meshio imports h5py for every XDMF file, also where none of its data is HDF5.
    monkeypatch.setitem(sys.modules, "h5py", types.ModuleType("h5py"))
    volume = pin.volume
    before = volume.ring.nodes.copy(), set(volume.sets)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"cam.volume.{form}")
        assert write(pin, path) == path.stat().st_size
        points, cells, sets = read(path)
    assert np.abs(points - volume.ring.nodes).max() < (1e-7 if form in ("inp", "bdf") else 1e-14)
    assert np.array_equal(cells, volume.ring.elements)
    assert {name: sorted(nodes.tolist()) for name, nodes in sets.items()} == {
        name: sorted(nodes.tolist()) for name, nodes in volume.sets.items()
    }
    assert np.array_equal(before[0], volume.ring.nodes)
    assert set(volume.sets) == before[1]


def test_the_formats_have_names_of_their_own() -> None:
    assert {format_of(f"volume.{form}").extension for form in FORMATS} == {f".volume.{form}" for form in FORMATS}
    assert format_of("vtu").extension == ".vtu"


@pytest.mark.parametrize("form", FORMATS)
def test_tetrahedra_are_read_back_with_their_sets(form: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "h5py", types.ModuleType("h5py"))
    mesh = tetrahedra()
    loads = mesh.spread(np.array([[20.0, 0.0, 11.0]]), np.array([[-3.0, 0.0, 1.0]]))
    sets = {**mesh.sets, "bore": mesh.sets["end"]}
    pressed = mesh.outer[mesh.labels == mesh.names.index("land")]
    volume = types.SimpleNamespace(
        name="cam", material=Material(), cell="tetra10", held="bore", nodes=mesh.nodes, sets=sets,
        elements=mesh.elements, forces=loads, pressed_faces=pressed, about=("a",),
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"cam.volume.{form}")
        getattr(writers, f"write_{form}")(path, volume)
        points, cells, found = read(path)
    assert np.abs(points - mesh.nodes).max() < (1e-7 if form in ("inp", "bdf") else 1e-14)
    assert np.array_equal(cells, mesh.elements)
    assert {k: sorted(v.tolist()) for k, v in found.items()} == {k: sorted(v.tolist()) for k, v in sets.items()}
