"""Volume meshes: nodes on the true faces, a load that is the duty's, and files that others read back whole."""

from __future__ import annotations

import sys
import tempfile
import types
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.body.element import gauss, gradients, shapes
from camgeom.body.volume import BodyVolume
from camgeom.errors import DesignError
from camgeom.export import format_of, write
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from tests.oracle.cams import judges_of
from tests.places import PROFILES

FORMATS = ("inp", "bdf", "vtu", "msh", "xdmf")


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
    assert patch.normal == pytest.approx(1874.0, rel=1e-3)
    assert np.linalg.norm(force) == pytest.approx(patch.normal, rel=2e-3)  # the normal turns a little along the line
    assert patch.where == "the upper flank"
    assert force[2] > 0.95 * patch.normal
    torque = np.cross(volume.ring.nodes, volume.forces).sum(axis=0)[2]
    at = float(pin.duty.force.panels.at(pin.duty.torque, np.array([np.radians(298.0)]))[0])
    assert abs(torque) == pytest.approx(abs(at), rel=0.02)
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
    assert abs(torque) == pytest.approx(abs(at), rel=0.02)
    assert set(volume.sets["patch"]) & set(volume.sets[f"flank_{volume.patch.where.split()[1]}"])


def test_a_sharp_root_is_rounded_and_said_so() -> None:
    volume = Model(from_data(changed("pin_insertion"))).volume
    assert any("sharp root is rounded by 0.78 mm" in line for line in volume.about)


def test_discs_and_frames_are_rings_and_others_are_refused_with_the_reason() -> None:
    for name in ("disc_offset_roller", "disc_flat_face", "constant_width_press"):
        model = Model(from_data(changed(name)))
        volume = model.volume
        assert np.linalg.norm(volume.forces.sum(axis=0)) == pytest.approx(volume.patch.normal)
        wanted = sum(solid.mesh.volume for solid in model.solids)
        assert volume_mm3(volume) == pytest.approx(wanted, rel=0.01)
    for name in ("tool_changer", "two_start"):
        with pytest.raises(DesignError, match="only rings"):
            _ = Model(from_data(changed(name))).volume


def read(path: Path) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Points, elements and sets of a file, by meshio; the sets of input files by their cards."""
    import meshio

    sets: dict[str, np.ndarray] = {}
    if path.suffix == ".inp":
        mesh = meshio.read(path, file_format="abaqus")
        sets = {name: np.asarray(nodes) for name, nodes in mesh.point_sets.items() if name != "all"}
    elif path.suffix == ".bdf":
        mesh, names, found = meshio.read(path), {}, {}
        for line in path.read_text().splitlines():
            if line.startswith("$ SET1"):
                _, _, number, name = line.split()
                names[number] = name
            elif line.startswith("SET1,"):
                _, number, *nodes = line.split(",")
                found.setdefault(names[number], []).extend(int(n) - 1 for n in nodes)
        sets = {name: np.array(nodes) for name, nodes in found.items()}
    else:
        mesh = meshio.read(path)
        fields = {name: np.asarray(values).ravel() for name, values in mesh.point_data.items() if name[:4] == "set_"}
        sets = {name.removeprefix("set_"): np.flatnonzero(values > 0.5) for name, values in fields.items()}
    assert mesh.cells[0].type == "hexahedron20"
    return mesh.points, mesh.cells[0].data, sets


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
