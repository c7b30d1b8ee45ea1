"""Point clouds read back to the last bit; broken ones are refused before a file is touched."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from camgeom.errors import ExportError
from camgeom.export import write
from camgeom.export.files import write_csv
from camgeom.export.points import flank_points
from camgeom.model import Model, read
from tests.places import PROFILES

POINTS_TEXT = ["x", "y", "z", "nx", "ny", "nz"]


@pytest.fixture(scope="module")
def model() -> Model:
    return read(PROFILES / "pin_insertion.toml")


def columns(model: Model) -> np.ndarray:
    return np.column_stack(list(flank_points(model).values()))


def test_ply_keeps_every_bit(tmp_path: Path, model: Model) -> None:
    path = tmp_path / "flank.points.ply"
    assert write(model, path) == path.stat().st_size
    head, _, body = path.read_bytes().partition(b"end_header\n")
    names = [line.split()[-1] for line in head.decode().splitlines() if line.startswith("property double")]
    assert names == [*POINTS_TEXT, *list(flank_points(model))[2:]]
    np.testing.assert_array_equal(np.frombuffer(body, "<f8").reshape(-1, len(names)), columns(model))
    np.testing.assert_array_equal(trimesh.load(path).vertices, flank_points(model)["points"])


def test_csv_keeps_every_bit(tmp_path: Path, model: Model) -> None:
    path = tmp_path / "flank.points.csv"
    assert write(model, path) == path.stat().st_size
    assert path.read_text().splitlines()[0] == ",".join([*POINTS_TEXT, *list(flank_points(model))[2:]])
    np.testing.assert_array_equal(np.loadtxt(path, delimiter=",", skiprows=1), columns(model))


def test_npz_keeps_every_bit(tmp_path: Path, model: Model) -> None:
    path = tmp_path / "flank.points.npz"
    assert write(model, path) == path.stat().st_size
    cloud = flank_points(model)
    with np.load(path) as archive:
        assert set(archive) == set(cloud)
        for name in cloud:
            np.testing.assert_array_equal(archive[name], cloud[name])


@pytest.mark.parametrize("ending", ["ply", "csv", "npz"])
def test_a_number_that_is_not_finite_is_refused(tmp_path: Path, model: Model, monkeypatch, ending: str) -> None:
    broken = flank_points(model)
    broken["relative_curvature_per_mm"][3] = np.nan
    monkeypatch.setattr("camgeom.export.points.flank_points", lambda _: broken)
    with pytest.raises(ExportError, match="relative_curvature_per_mm has a value that is not finite"):
        write(model, tmp_path / f"flank.points.{ending}")
    assert not list(tmp_path.iterdir())


def test_a_cell_without_a_number_stays_empty(tmp_path: Path) -> None:
    write_csv(tmp_path / "a.csv", ("name", "x", "y"), [("banana,", np.array([[1.5, np.nan], [-0.1, 2.0]]))])
    assert (tmp_path / "a.csv").read_text() == "name,x,y\nbanana,1.5,\nbanana,-0.1,2.0\n"


def test_flank_points_touch_the_roller_with_the_normal_towards_its_axis(model: Model) -> None:
    """The pin-insertion cam's roller is a cylinder of radius 11 mm: every point is that far from its axis."""
    cloud = flank_points(model)
    pose = model.tracks[0].pose(np.radians(cloud["cam_angle_deg"]), 0)
    centre = (pose.a[0] + cloud["roller_mm"] * pose.u[0]).T
    np.testing.assert_allclose(centre - cloud["points"], 11.0 * cloud["normals"], atol=1e-9)
    assert set(cloud["side"]) == {-1.0, 1.0}
    larger, smaller = cloud["curvature_1_per_mm"], cloud["curvature_2_per_mm"]
    assert np.all(larger >= smaller)
    np.testing.assert_allclose(larger + smaller + 1.0 / 11.0, cloud["relative_curvature_per_mm"], atol=1e-12)


def test_cams_without_rollers_have_flank_points_too() -> None:
    for name in ("disc_flat_face", "constant_width_press"):
        cloud = flank_points(read(PROFILES / f"{name}.toml"))
        assert len(cloud["points"]) > 5000
        np.testing.assert_allclose(cloud["relative_curvature_per_mm"], cloud["curvature_1_per_mm"], rtol=1e-9)
