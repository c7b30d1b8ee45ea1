"""Point clouds read back to the last bit; broken ones are refused before a file is touched."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from camgeom.errors import ExportError
from camgeom.export.cloud import Cloud, flank_points, write_cloud_csv, write_cloud_npz, write_cloud_ply
from camgeom.model import read
from tests.places import PROFILES


@pytest.fixture
def cloud() -> dict[str, np.ndarray]:
    rng = np.random.default_rng(1)
    normals = rng.normal(size=(500, 3))
    return {
        "points": 60.0 * rng.normal(size=(500, 3)),
        "normals": normals / np.linalg.norm(normals, axis=1)[:, None],
        "curvature_1_per_mm": 10.0 ** rng.uniform(-12.0, 3.0, 500),
    }


def columns(cloud: Cloud) -> np.ndarray:
    return np.column_stack(list(cloud.values()))


def test_ply_keeps_every_bit(tmp_path: Path, cloud: Cloud) -> None:
    path = tmp_path / "flank.points.ply"
    assert write_cloud_ply(path, cloud) == path.stat().st_size
    head, _, body = path.read_bytes().partition(b"end_header\n")
    names = [line.split()[-1] for line in head.decode().splitlines() if line.startswith("property double")]
    assert names == ["x", "y", "z", "nx", "ny", "nz", "curvature_1_per_mm"]
    np.testing.assert_array_equal(np.frombuffer(body, "<f8").reshape(-1, 7), columns(cloud))
    read = trimesh.load(path)
    np.testing.assert_array_equal(read.vertices, cloud["points"])


def test_csv_keeps_every_bit(tmp_path: Path, cloud: Cloud) -> None:
    path = tmp_path / "flank.points.csv"
    assert write_cloud_csv(path, cloud) == path.stat().st_size
    assert path.read_text().splitlines()[0] == "x,y,z,nx,ny,nz,curvature_1_per_mm"
    np.testing.assert_array_equal(np.loadtxt(path, delimiter=",", skiprows=1), columns(cloud))


def test_npz_keeps_every_bit(tmp_path: Path, cloud: Cloud) -> None:
    path = tmp_path / "flank.points.npz"
    assert write_cloud_npz(path, cloud) == path.stat().st_size
    with np.load(path) as read:
        assert set(read) == set(cloud)
        for name in cloud:
            np.testing.assert_array_equal(read[name], cloud[name])


@pytest.mark.parametrize("write", [write_cloud_ply, write_cloud_csv, write_cloud_npz])
@pytest.mark.parametrize(
    ("name", "values", "message"),
    [
        ("normals", np.zeros((499, 3)), r"normals has shape \(499, 3\) beside 500 points"),
        ("curvature", np.full(500, np.nan), "curvature has a value that is not finite"),
        ("points", np.zeros((0, 3)), r"a cloud has points \(n, 3\), n > 0"),
        ("points", np.zeros((500, 2)), r"a cloud has points \(n, 3\), n > 0"),
    ],
)
def test_a_broken_cloud_is_refused(tmp_path: Path, cloud: dict, write, name: str, values, message: str) -> None:
    with pytest.raises(ExportError, match=message):
        write(tmp_path / "flank.points.ply", {**cloud, name: values})
    assert not list(tmp_path.iterdir())


def test_flank_points_touch_the_roller_with_the_normal_towards_its_axis() -> None:
    """The pin-insertion cam's roller is a cylinder of radius 11 mm: every point is that far from its axis."""
    model = read(str(PROFILES / "pin_insertion.toml"))
    cloud = flank_points(model)
    pose = model.tracks[0].pose(np.radians(cloud["cam_angle_deg"]), 0)
    centre = (pose.a[0] + cloud["roller_mm"] * pose.u[0]).T
    np.testing.assert_allclose(centre - cloud["points"], 11.0 * cloud["normals"], atol=1e-9)
    assert set(cloud["side"]) == {-1.0, 1.0}
    larger, smaller = cloud["curvature_1_per_mm"], cloud["curvature_2_per_mm"]
    assert np.all(larger >= smaller)
    np.testing.assert_allclose(larger + smaller + 1.0 / 11.0, cloud["relative_curvature_per_mm"], atol=1e-12)


def test_a_cam_without_rollers_has_no_flank_points() -> None:
    with pytest.raises(ExportError, match="the follower has no roller"):
        flank_points(SimpleNamespace(flanks=()))  # type: ignore[arg-type]
