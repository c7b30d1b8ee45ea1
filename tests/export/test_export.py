"""Every format is read back by another library with the same geometry; what a format loses is stated and measured."""

from __future__ import annotations

import json
import struct
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import lib3mf
import meshio
import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from camgeom.errors import ExportError
from camgeom.export import NamedMesh, as_bodies, format_of, formats, write, write_mesh
from camgeom.export.files import number_lines
from camgeom.maths.creases import shade
from camgeom.maths.mesh import Mesh

NAME = 'cam <1> & "co" \u2205\x07'
"""A name with everything that markup must escape."""


def tube(n: int = 60, m: int = 24, shift: float = 0.0) -> Mesh:
    """A closed ring of triangles with awkward coordinates, two groups and two fields."""
    a, b = 2.0 * np.pi * np.arange(n) / n, 2.0 * np.pi * np.arange(m) / m
    radius = 50.0 + 17.0 * np.cos(b)[None, :] + 0.123456789012345 * np.sin(3.0 * a)[:, None]
    x, y = radius * np.cos(a)[:, None], radius * np.sin(a)[:, None]
    points = np.stack([x + shift, y, np.broadcast_to(17.0 * np.sin(b), x.shape)], axis=-1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(n), np.arange(m), indexing="ij"))
    corner = [((i + p) % n) * m + (j + q) % m for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = np.concatenate([np.stack([corner[k] for k in t], axis=1) for t in ((0, 1, 2), (0, 2, 3))])
    group = (points[faces[:, 0], 2] > 5.0).astype(np.uint8)
    fields = {"pressure_mpa": points[:, 0] ** 2 / 3.0, "margin": np.cos(points[:, 1])}
    return Mesh(points, faces.astype(np.int32), ("flank", "land"), group, fields)


BODIES = (NamedMesh(NAME, tube(), (1.0, 0.5, 0.0)), NamedMesh("second", tube(31, 9, shift=200.0)))


def soup(mesh: Mesh) -> Any:
    """The triangles' corners (f, 3, 3)."""
    return mesh.vertices[mesh.faces]


@pytest.fixture(params=[1, 2], ids=["one body", "two bodies"])
def bodies(request: pytest.FixtureRequest) -> tuple[NamedMesh, ...]:
    return BODIES[: request.param]


def test_the_mesh_of_these_tests_is_a_closed_ring() -> None:
    for body in BODIES:
        assert body.mesh.watertight
        assert body.mesh.genus == 1
        assert body.mesh.volume > 0.0


@pytest.mark.parametrize("extension", [".3mf", ".glb", ".obj", ".ply", ".stl", ".vtu"])
def test_the_writer_returns_the_size_and_repeats_itself(
    tmp_path: Path, extension: str, bodies: tuple[NamedMesh, ...]
) -> None:
    path = tmp_path / f"cam{extension}"
    size = write_mesh(bodies, path)
    first = path.read_bytes()
    assert size == len(first)
    write_mesh(bodies, path)
    assert path.read_bytes() == first


def test_stl_is_the_float32_rounding_of_the_mesh(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    write_mesh(bodies, tmp_path / "cam.stl")
    corners = np.concatenate([soup(body.mesh) for body in bodies])
    read = trimesh.load_mesh(tmp_path / "cam.stl", process=False)
    np.testing.assert_array_equal(read.triangles, corners.astype(np.float32))
    assert np.abs(read.triangles - corners).max() <= 6e-8 * np.abs(corners).max()
    merged = trimesh.load_mesh(tmp_path / "cam.stl")
    assert merged.is_watertight
    assert merged.volume == pytest.approx(sum(body.mesh.volume for body in bodies), rel=1e-6)
    raw = np.fromfile(tmp_path / "cam.stl", np.dtype([("n", "<f4", 3), ("v", "<f4", 9), ("a", "<u2")]), offset=84)
    np.testing.assert_allclose(raw["n"], trimesh.triangles.normals(read.triangles)[0], atol=1e-6)
    assert not (tmp_path / "cam.stl").read_bytes().startswith(b"solid")


def test_stl_of_a_triangle_without_area_has_a_zero_normal(tmp_path: Path) -> None:
    mesh = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), np.array([[0, 1, 2]], np.int32))
    write_mesh(mesh, tmp_path / "flat.stl")
    assert np.fromfile(tmp_path / "flat.stl", "<f4", count=3, offset=84).tolist() == [0.0, 0.0, 0.0]


def joined(bodies: tuple[NamedMesh, ...]) -> dict[str, Any]:
    """The bodies as one table of vertices and one of faces."""
    starts = np.cumsum([0, *(len(body.mesh.vertices) for body in bodies)])
    return {
        "points": np.concatenate([body.mesh.vertices for body in bodies]),
        "faces": np.concatenate([body.mesh.faces + start for body, start in zip(bodies, starts)]),
        "group": np.concatenate([body.mesh.group for body in bodies if body.mesh.group is not None]),
        "body": np.repeat(np.arange(len(bodies)), [len(body.mesh.faces) for body in bodies]),
        **{name: np.concatenate([body.mesh.fields[name] for body in bodies]) for name in ("pressure_mpa", "margin")},
    }


def test_vtu_keeps_every_bit(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    write_mesh(bodies, tmp_path / "cam.vtu")
    read, want = meshio.read(tmp_path / "cam.vtu"), joined(bodies)
    np.testing.assert_array_equal(read.points, want["points"])
    np.testing.assert_array_equal(read.cells_dict["triangle"], want["faces"])
    for name in ("pressure_mpa", "margin"):
        np.testing.assert_array_equal(np.ravel(read.point_data[name]), want[name])
    for name in ("group", "body"):
        np.testing.assert_array_equal(np.ravel(read.cell_data[name][0]), want[name])
    assert 'body 0 cam <1> & "co" \u2205 : group 0 flank, group 1 land' in (tmp_path / "cam.vtu").read_bytes().decode(
        errors="replace"
    )


def test_ply_keeps_every_bit_and_names_its_groups(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    write_mesh(bodies, tmp_path / "cam.ply")
    read, want = trimesh.load_mesh(tmp_path / "cam.ply", process=False), joined(bodies)
    np.testing.assert_array_equal(read.vertices, want["points"])
    np.testing.assert_array_equal(read.faces, want["faces"])
    for name in ("pressure_mpa", "margin"):
        np.testing.assert_array_equal(np.ravel(read.metadata["_ply_raw"]["vertex"]["data"][name]), want[name])
    for name in ("group", "body"):
        np.testing.assert_array_equal(np.ravel(read.metadata["_ply_raw"]["face"]["data"][name]), want[name])
    assert b"comment body 0 group 1 land\n" in (tmp_path / "cam.ply").read_bytes()


@pytest.mark.parametrize("extension", [".ply", ".vtu"])
def test_bodies_with_different_fields_are_refused(tmp_path: Path, extension: str) -> None:
    plain = NamedMesh("plain", Mesh(BODIES[0].mesh.vertices, BODIES[0].mesh.faces))
    with pytest.raises(ExportError, match="'second' and 'plain' carry different fields"):
        write_mesh([BODIES[1], plain], tmp_path / f"cam{extension}")
    assert not list(tmp_path.iterdir())


def test_obj_keeps_nine_decimals_and_its_groups(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    write_mesh(bodies, tmp_path / "cam.obj")
    read = meshio.read(tmp_path / "cam.obj")
    points = np.concatenate([body.mesh.vertices for body in bodies])
    assert np.abs(read.points - points).max() <= 0.5001e-9
    corners = np.concatenate(
        [soup(body.mesh)[body.mesh.group == g] for body in bodies for g in (0, 1)]  # the file goes by group
    )
    faces = np.concatenate([block.data for block in read.cells])
    assert np.abs(read.points[faces] - corners).max() <= 0.5001e-9
    lines = (tmp_path / "cam.obj").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if line[0] in "og"][:3] == [
        'o cam_<1>_&_"co"_\u2205', 'g cam_<1>_&_"co"_\u2205_flank', 'g cam_<1>_&_"co"_\u2205_land',
    ]  # fmt: skip


def test_obj_is_read_by_a_second_reader(tmp_path: Path) -> None:
    write_mesh(BODIES[0], tmp_path / "cam.obj")
    read = trimesh.load_mesh(tmp_path / "cam.obj")
    assert read.is_watertight
    assert read.volume == pytest.approx(BODIES[0].mesh.volume, rel=1e-9)


def test_3mf_is_read_strictly_by_the_reference_reader(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    path = tmp_path / "a & <b>.3mf"
    write_mesh(bodies, path)
    model = lib3mf.Wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(path))
    assert reader.GetWarningCount() == 0
    assert model.GetUnit() == lib3mf.ModelUnit.MilliMeter
    assert model.GetMetaDataGroup().GetMetaDataByKey("", "Title").GetValue() == "a & <b>"
    items, objects = model.GetBuildItems(), model.GetMeshObjects()
    for body in bodies:
        assert items.MoveNext()
        assert objects.MoveNext()
        found = objects.GetCurrentMeshObject()
        assert found.GetName() == body.name.replace("\x07", " ")
        assert found.GetType() == lib3mf.ObjectType.Model
        assert found.IsManifoldAndOriented()
        points = np.array([vertex.Coordinates[:] for vertex in found.GetVertices()])
        assert np.abs(points - body.mesh.vertices).max() <= 6e-8 * np.abs(body.mesh.vertices).max()  # its float32
        np.testing.assert_array_equal([t.Indices[:] for t in found.GetTriangleIndices()], body.mesh.faces)
    assert not items.MoveNext()


def test_3mf_keeps_seven_decimals(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    write_mesh(bodies, tmp_path / "cam.3mf")
    scene = trimesh.load_scene(tmp_path / "cam.3mf", process=False)
    read = sorted(scene.geometry.values(), key=lambda mesh: mesh.bounds[0][0])
    for mesh, body in zip(read, bodies, strict=True):
        assert np.abs(mesh.triangles - soup(body.mesh)).max() <= 0.5001e-7
        assert mesh.volume == pytest.approx(body.mesh.volume, rel=1e-8)


def test_3mf_of_an_open_mesh_is_a_surface(tmp_path: Path) -> None:
    mesh = BODIES[0].mesh
    write_mesh(Mesh(mesh.vertices, mesh.faces[1:]), tmp_path / "open.3mf")
    with zipfile.ZipFile(tmp_path / "open.3mf") as package:
        assert package.testzip() is None
        text = package.read("3D/3dmodel.model")
    assert b'type="surface"' in text
    assert b'type="model"' not in text


def test_glb_is_read_in_metres_with_the_axis_upward(tmp_path: Path, bodies: tuple[NamedMesh, ...]) -> None:
    write_mesh(bodies, tmp_path / "cam.glb")
    scene = trimesh.load_scene(tmp_path / "cam.glb", process=False)
    places = dict(reversed(scene.graph.get(node)) for node in scene.graph.nodes_geometry)
    placed = [mesh.copy().apply_transform(places[name]) for name, mesh in scene.geometry.items()]
    read = np.concatenate([mesh.triangles for mesh in placed])
    corners = np.concatenate([soup(b.mesh)[b.mesh.group == g] for b in bodies for g in (0, 1)])  # primitives by group
    upward = np.stack([corners[..., 0], corners[..., 2], -corners[..., 1]], axis=-1) * 1e-3
    np.testing.assert_allclose(read, upward, atol=1.3e-7 * np.abs(upward).max(), rtol=0)


def glb_parts(path: Path) -> tuple[dict[str, Any], bytes]:
    """The JSON and the binary chunk."""
    data = path.read_bytes()
    magic, version, total, size, kind = struct.unpack("<4sIII4s", data[:20])
    assert (magic, version, total, kind) == (b"glTF", 2, len(data), b"JSON")
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def glb_array(path: Path, index: int) -> Any:
    document, binary = glb_parts(path)
    entry = document["accessors"][index]
    view = document["bufferViews"][entry["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
    kind = {5126: "<f4", 5125: "<u4", 5121: "u1"}[entry["componentType"]]
    values = np.frombuffer(binary, kind, entry["count"] * width, view["byteOffset"])
    return values.reshape(-1, width) if width > 1 else values


def test_glb_names_its_groups_and_carries_fields_and_colours(tmp_path: Path) -> None:
    path = tmp_path / "cam.glb"
    write_mesh(BODIES[1], path, colour_by="pressure_mpa")
    document, _ = glb_parts(path)
    assert [material["name"] for material in document["materials"]] == ["flank", "land"]
    attributes = document["meshes"][0]["primitives"][0]["attributes"]
    points, field = glb_array(path, attributes["POSITION"]), glb_array(path, attributes["_PRESSURE_MPA"])
    np.testing.assert_allclose(field, points[:, 0].astype(float) ** 2 / 3.0, rtol=1e-6)
    colours = glb_array(path, attributes["COLOR_0"])
    assert colours[np.argmax(field)].tolist() == [250, 204, 5, 255]  # bright yellow, as linear light
    assert colours[np.argmin(field)].tolist() == [15, 0, 23, 255]  # dark violet
    with pytest.raises(ExportError, match="no body carries the field 'pressure'"):
        write_mesh(BODIES[1], path, colour_by="pressure")


def box() -> Mesh:
    points = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    faces = [(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)]
    return Mesh(points, np.array(faces, np.int32))


def test_shading_splits_a_box_into_six_flat_sides() -> None:
    shaded = shade(box())
    assert box().volume == pytest.approx(1.0)
    assert len(shaded.source) == 24
    np.testing.assert_array_equal(shaded.source[shaded.faces], box().faces)
    flat = np.cross(*(box().vertices[box().faces[:, i]] - box().vertices[box().faces[:, 0]] for i in (1, 2)))
    np.testing.assert_allclose(shaded.normals[shaded.faces], np.repeat(flat[:, None], 3, axis=1), atol=1e-15)
    assert len(shade(box(), angle=91.0).source) == 8


@pytest.mark.parametrize(("bend", "vertices"), [(29.9, 8), (30.1, 10)])
def test_shading_splits_just_above_the_crease_angle(bend: float, vertices: int) -> None:
    """Three strips in a row, the first two bent against each other, the third a continuation of the second."""
    c, s = np.cos(np.radians(bend)), np.sin(np.radians(bend))
    profile = np.array([[-1.0, 0.0], [0.0, 0.0], [c, s], [2 * c, 2 * s]])
    points = np.array([[x, y, z] for y in (0.0, 1.0) for x, z in profile])
    quads = [(i, i + 1, i + 5, i + 4) for i in range(3)]
    faces = np.array([(q[0], q[i], q[i + 1]) for q in quads for i in (1, 2)], np.int32)
    assert len(shade(Mesh(points, faces)).source) == vertices


def test_shading_splits_between_groups_and_is_smooth_elsewhere() -> None:
    mesh = tube()
    assert mesh.group is not None
    whole = shade(Mesh(mesh.vertices, mesh.faces), angle=60.0)
    assert len(whole.source) == len(mesh.vertices)
    border = set(mesh.faces[mesh.group == 0].ravel()) & set(mesh.faces[mesh.group == 1].ravel())
    assert len(shade(mesh, angle=60.0).source) == len(mesh.vertices) + len(border)
    np.testing.assert_allclose(np.linalg.norm(whole.normals, axis=1), 1.0, rtol=1e-14)
    centre = mesh.vertices * [1.0, 1.0, 0.0] * (50.0 / np.hypot(*mesh.vertices.T[:2]))[:, None]
    outward = (mesh.vertices - centre)[whole.source]
    assert np.einsum("ni,ni->n", whole.normals, outward / np.linalg.norm(outward, axis=1)[:, None]).min() > 0.99


@settings(suppress_health_check=[HealthCheck.too_slow])  # a busy machine makes no worse data
@given(
    st.lists(st.floats(-999_999.0, 999_999.0), min_size=1, max_size=40),
    st.integers(0, 9),
)
@example([703687.9045043549], 8)
def test_text_rows_are_the_rounded_numbers_without_needless_zeros(values: list[float], decimals: int) -> None:
    text = b"".join(number_lines(np.array(values)[:, None], (b"<",), b">\n", decimals)).decode()
    for line, value in zip(text.splitlines(), values, strict=True):
        number = line[1:-1]
        # What is scaled to be rounded, and the text that is read again, are doubles.
        assert abs(float(number) - value) <= 0.5 * 10.0**-decimals * (1.0 + 1e-6) + 1e-10 + 2.0 * np.spacing(abs(value))
        assert number == np.format_float_positional(float(number), trim="-")


def test_text_rows_refuse_what_they_cannot_hold() -> None:
    for value in (1e9, np.nan, np.inf):
        with pytest.raises(ValueError, match="too large"):
            list(number_lines(np.array([[value]]), (b"",), b"\n", 3))
    with pytest.raises(ValueError, match="decimals = 10"):
        list(number_lines(np.zeros((1, 1)), (b"",), b"\n", 10))
    assert list(number_lines(np.zeros((0, 1)), (b"",), b"\n")) == []


def test_an_unknown_extension_names_the_nearest(tmp_path: Path) -> None:
    message = r"cam\.stll: no writer for \.stll; did you mean '\.stl'\? \(there are \.3mf, "
    with pytest.raises(ExportError, match=message):
        write_mesh(BODIES, tmp_path / "cam.stll")
    with pytest.raises(ExportError, match="no writer for"):
        write_mesh(BODIES, tmp_path / "cam")
    assert format_of("STL").extension == ".stl"
    assert format_of("points.csv").extension == ".points.csv"
    assert format_of("a/b.v2.Points.PLY").extension == ".points.ply"
    assert format_of("points.ply", takes="bodies").extension == ".ply"


def test_an_empty_mesh_is_refused(tmp_path: Path) -> None:
    empty = Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32))
    with pytest.raises(ExportError, match="body 'cam' has no faces"):
        write_mesh(empty, tmp_path / "cam.stl")
    with pytest.raises(ExportError, match="no body given"):
        as_bodies([])
    assert not list(tmp_path.iterdir())


def test_a_model_is_written_body_by_body(tmp_path: Path) -> None:
    parts = [SimpleNamespace(name=body.name, mesh=body.mesh) for body in BODIES]
    model: Any = SimpleNamespace(workpieces=[(part, None) for part in parts])
    write(model, tmp_path / "cam.obj")
    write_mesh([(body.name, body.mesh) for body in BODIES], tmp_path / "same.obj")
    assert (tmp_path / "cam.obj").read_bytes() == (tmp_path / "same.obj").read_bytes()


def test_every_format_says_what_it_is() -> None:
    expected = {".stl", ".3mf", ".ply", ".obj", ".glb", ".vtu", ".points.ply", ".points.csv", ".points.npz"}
    assert expected <= set(formats())
    assert all(form.about and form.extension == extension for extension, form in formats().items())
