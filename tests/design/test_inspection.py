"""Inspection: nominal points on the exact flank of every cam kind, and measured points fitted back to it."""

from __future__ import annotations

import csv
import json
from contextlib import suppress
from functools import cache
from math import degrees, radians
from pathlib import Path

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.errors import NotConverged, ProfileError
from camgeom.export import write
from camgeom.export.points import flank_points
from camgeom.inspection import GROSS, inspect, rotation
from camgeom.inspection.points import MeasuredPoints, read_points
from camgeom.model import Model, read
from camgeom.model.surfaces import flank_surfaces, within
from camgeom.profile import from_data
from tests.oracle.envelope import roller_distance, swept_distance
from tests.places import PROFILES

ROLLED = ["pin_insertion", "steep_shuttle", "feeder_runout", "tool_changer", "two_start", "barrel_indexer",
          "bell_lifter", "conical_groove", "conical_pair"]  # fmt: skip
PLANAR = ["disc_offset_roller", "disc_face_groove", "disc_flat_face", "conjugate_rocker", "constant_width_press"]


@cache
def model(name: str) -> Model:
    return read(str(PROFILES / f"{name}.toml"))


def nominal(made: Model, seed: int = 0, count: int = 200):
    """Points, outward normals (3, n), flank numbers, cam angles: random places on every flank."""
    rng, inside = np.random.default_rng(seed), within(made)
    parts = []
    for number, surface in enumerate(flank_surfaces(made)):
        phi = rng.uniform(*surface.span, count)
        low, high = surface.touched
        patch = surface.at(phi, low + (high - low) * rng.uniform(0.1, 0.9, count))
        keep = inside(patch.x) >= 0.0
        parts.append((patch.x[:, keep], patch.n[:, keep], np.full(keep.sum(), number), phi[keep]))
    return [np.concatenate(column, axis=-1) for column in zip(*parts)]


def measured(x, planar: bool = False, flank=None) -> MeasuredPoints:
    return MeasuredPoints(np.asarray(x), planar, flank)


def table(path: Path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("name", ["pin_insertion", "steep_shuttle", "tool_changer"])
def test_nominal_points_touch_the_cutter(tmp_path: Path, name: str) -> None:
    """The oracle: no position of the tool comes nearer than its own surface, and one touches."""
    made = model(name)
    write(made, tmp_path / "cam.cmm.csv", step=7.0)
    rows = table(tmp_path / "cam.cmm.csv")
    x = np.array([[float(row[key]) for key in ("x_mm", "y_mm", "z_mm")] for row in rows])
    n = np.array([[float(row[key]) for key in ("normal_x", "normal_y", "normal_z")] for row in rows])
    pitch = np.array([[float(row[key]) for key in ("pitch_x_mm", "pitch_y_mm", "pitch_z_mm")] for row in rows])
    assert np.abs(np.linalg.norm(n, axis=1) - 1.0).max() < 1e-12
    track = made.cutters[0]
    shape = ("cone", track.meridian.slope, track.meridian.centre)
    radius = track.meridian.radius + track.meridian.slope * (
        np.array([float(row["station_mm"]) for row in rows]) - track.meridian.centre
    )
    assert np.linalg.norm(x - pitch, axis=1) == pytest.approx(radius, abs=1e-11)

    def pose(phi):
        found = track.pose(np.ravel(phi), 0)
        return found.a[0].T.reshape(*np.shape(phi), 3), found.u[0].T.reshape(*np.shape(phi), 3)

    def distance(x, a, u):
        return roller_distance(x, a, u, track.meridian.radius, track.tip, track.tip_sign > 0.0, shape)

    low, high = track.span
    coarse = round(240 * (high - low))
    gap = swept_distance(x, pose, distance, low - 0.1, high + 0.1, coarse=coarse, rounds=45)
    assert np.abs(gap).max() < 1e-9
    gap = swept_distance(x + 1e-3 * n, pose, distance, low - 0.1, high + 0.1, coarse=coarse, rounds=45)
    assert gap == pytest.approx(-0.0, abs=1.01e-3)


@pytest.mark.parametrize("name", ROLLED + PLANAR)
def test_every_kind_has_a_table(tmp_path: Path, name: str) -> None:
    made = model(name)
    write(made, tmp_path / "cam.cmm.csv", step=5.0)
    rows = table(tmp_path / "cam.cmm.csv")
    assert {row["flank"] for row in rows} == {surface.name for surface in flank_surfaces(made)}
    for row in rows[:: max(1, len(rows) // 50)]:
        x, y = float(row["x_mm"]), float(row["y_mm"])
        angle, radius = radians(float(row["polar_angle_deg"])), float(row["polar_radius_mm"])
        assert (radius * np.cos(angle), radius * np.sin(angle)) == pytest.approx((x, y), abs=1e-10)
        assert (row["pitch_x_mm"] == "") == (made.setup.roller is None)
    found = inspect(made, read_points(tmp_path / "cam.cmm.csv"), fit="none")
    assert max(abs(found.of().largest), abs(found.of().smallest)) < 1e-9
    assert np.all(found.kept)


@pytest.mark.parametrize(("name", "radius"), [(name, 1.5) for name in ROLLED + PLANAR] + [("pin_insertion", 0.0)])
def test_a_turned_and_shifted_cam_is_found_again(name: str, radius: float) -> None:
    made = model(name)
    x, n, _, _ = nominal(made)
    turn, shift = rotation(np.array([0.0, 0.0, 2.3])), np.array([0.0, 0.0, 0.4])
    found = inspect(made, measured(turn.T @ (x + radius * n - shift[:, None])), radius)
    whole = found.of()
    assert max(abs(whole.largest), abs(whole.smallest)) < 1e-9
    assert found.angle == pytest.approx(2.3, abs=1e-10)
    if name in PLANAR:
        assert found.undetermined == ("axial shift",)
    else:
        assert found.undetermined == ()
        assert found.shift[2] == pytest.approx(0.4, abs=1e-9)


@pytest.mark.parametrize("name", ["pin_insertion", "conical_indexer"])
def test_all_six_degrees_of_freedom_are_found_again(name: str) -> None:
    made = model(name)
    x, _, _, _ = nominal(made)
    turn, shift = rotation(np.array([0.004, -0.002, 1.1])), np.array([0.3, -0.2, 0.25])
    found = inspect(made, measured(turn.T @ (x - shift[:, None])), fit="rigid")
    assert np.abs(found.turn - turn).max() < 1e-10
    assert found.shift == pytest.approx(shift, abs=1e-9)
    assert found.of().rms < 1e-10
    tied = inspect(made, measured(x - np.array([[0.0], [0.02], [0.0]])), fit="axial")
    assert tied.of().rms > 1e-3  # an eccentric cam shows where only the angle and the axial shift may move


def test_errors_along_the_normal_come_back() -> None:
    """Without a fit every planted error is returned; with one, only what no motion can explain."""
    made = model("disc_face_groove")
    x, n, _, phi = nominal(made)
    error = 2e-3 * np.sin(7.0 * phi) * np.random.default_rng(3).uniform(0.2, 1.0, len(phi))
    found = inspect(made, measured(x + error * n), fit="none")
    assert found.deviation == pytest.approx(error, abs=1e-9)


@pytest.mark.parametrize(("name", "flank", "at"), [("pin_insertion", 1, 2.2), ("disc_offset_roller", 0, 4.0)])
def test_a_bump_is_found_in_its_place(name: str, flank: int, at: float) -> None:
    made = model(name)
    inside, parts = within(made), []
    for number, surface in enumerate(flank_surfaces(made)):
        phi, t = (g.ravel() for g in np.meshgrid(
            np.linspace(*surface.span, 720, endpoint=False), np.mean(surface.touched), indexing="ij"))  # fmt: skip
        patch = surface.at(phi, t)
        bump = 0.005 * np.exp(-(((phi - at) / 0.02) ** 2)) * (number == flank)
        parts.append((patch.x + bump * patch.n)[:, inside(patch.x) >= 0.0])
    found = inspect(made, measured(rotation(np.array([0.0, 0.0, -2.0])) @ np.concatenate(parts, axis=1)))
    whole = found.of()
    assert whole.worst == pytest.approx(0.005, abs=2.5e-4)  # the fit of the angle takes a little of it
    assert degrees(whole.cam_angle) == pytest.approx(degrees(at), abs=0.6)
    assert max(found.flanks, key=lambda one: one.largest).name == flank_surfaces(made)[flank].name
    dip = found.flanks[0].smallest
    assert dip > -1.5e-4


def test_noise_is_fitted_to_the_least_squares() -> None:
    """No small motion has a smaller sum of squares than the one found."""
    made = model("pin_insertion")
    x, n, _, _ = nominal(made)
    x = x + 0.004 * np.random.default_rng(5).standard_normal(x.shape[1]) * n
    found = inspect(made, measured(x))
    best = found.of().rms
    assert best == pytest.approx(0.004, rel=0.1)
    placed = found.turn @ x + found.shift[:, None]
    for angle, axial in ((2e-6, 0.0), (-2e-6, 0.0), (0.0, 1e-4), (0.0, -1e-4)):
        moved = rotation(np.array([0.0, 0.0, angle])) @ placed + np.array([[0.0], [0.0], [axial]])
        assert inspect(made, measured(moved), fit="none").of().rms > best


def test_the_wrong_hand_is_refused() -> None:
    made = model("disc_face_groove")
    x, _, _, _ = nominal(made, count=150)
    with pytest.raises(ProfileError, match="mirror image: look at the direction or hand"):
        inspect(made, measured(x * np.array([[1.0], [-1.0], [1.0]])))


@pytest.mark.parametrize(("size", "refused"), [(0.9, False), (1.5, True)])
def test_gross_deviations_are_refused(size: float, refused: bool) -> None:
    made = model("disc_offset_roller")
    x, n, _, phi = nominal(made)
    bad = measured(x + size * GROSS * np.sqrt(2.0) * np.sin(9.0 * phi) * n)
    if refused:
        with pytest.raises(ProfileError, match="do not belong to this cam"):
            inspect(made, bad)
    else:
        assert inspect(made, bad).of().rms == pytest.approx(size * GROSS, rel=0.2)


def test_points_beyond_the_edges_do_not_count() -> None:
    made = model("pin_insertion")
    x, _, _, _ = nominal(made)
    surface = flank_surfaces(made)[0]
    top = surface.at(np.full(40, 1.0), np.full(40, surface.wall[1]))
    beyond = top.x + 0.3 * top.by_t / np.linalg.norm(top.by_t, axis=0)
    found = inspect(made, measured(np.concatenate([x, beyond], axis=1)), fit="none")
    assert int((~found.kept).sum()) == 40
    assert found.of().points == x.shape[1]
    assert abs(found.of().worst) < 1e-9


@pytest.mark.parametrize("separator", [",", ";", "\t"])
@pytest.mark.parametrize("polar", [False, True])
def test_files_in_any_usual_form(tmp_path: Path, separator: str, polar: bool) -> None:
    made = model("disc_offset_roller")
    x, _, _, _ = nominal(made, count=60)
    heads = ("angle_deg", "radius_mm") if polar else ("X", "Y")
    one = (np.degrees(np.arctan2(x[1], x[0])), np.hypot(x[0], x[1])) if polar else (x[0], x[1])
    lines = [separator.join(("no", *heads))]
    for k, (a, b) in enumerate(zip(*one)):
        cells = [str(k), repr(float(a)), repr(float(b))]
        lines.append(separator.join(cell.replace(".", ",") if separator != "," else cell for cell in cells))
    path = tmp_path / "points.csv"
    path.write_text("\ufeff" + "\n".join(lines) + "\n\n")
    points = read_points(path)
    assert points.planar
    assert inspect(made, points).of().rms < 1e-9
    with pytest.raises(ProfileError, match="need heights"):
        inspect(model("pin_insertion"), points)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "holds no table"),
        ("x,y,z\n", "too few points .found 0.; allowed: 6 to"),
        ("a,b,c\n1,2,3\n", r"line 1: names no coordinates \(found 'a, b, c'\)"),
        ("x,y,zz\n" + "1,2,3\n" * 7, None),
        ("x,y,z\n" + "1,2,3\n" * 7 + "4,oops,6\n", r"line 9: column 'y' needs a number \(found 'oops'\)"),
        ("x,y,z\n" + "1,2,3\n" * 7 + "4,nan,6\n", "line 9: column 'y' needs a number"),
        ("x,y,z\n" + "1,2,3\n" * 7 + "4,5\n", "line 9: column 'z' needs a number"),
        ("x,y,z\n" + "1,2,1e9\n" * 7, "line 2: column 'z' needs a number"),
        ("\x00\x01\x02", "line 1 holds a NUL byte"),
        ("x,y,z\n" + "1,2,3\n" * 7 + "4" * 10_001, "line 9 is too long"),
    ],
)
def test_garbage_is_refused_in_one_line(tmp_path: Path, text: str, message: str | None) -> None:
    path = tmp_path / "points.csv"
    path.write_text(text)
    if message is None:
        assert read_points(path).planar
        return
    with pytest.raises(ProfileError, match=message) as caught:
        read_points(path)
    assert "\n" not in str(caught.value)
    assert str(path) in str(caught.value)


def test_no_text_and_no_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "x.bin").write_bytes(b"\xff\xfe\x80" * 50)
    with pytest.raises(ProfileError, match="is not UTF-8 text after line 0"):
        read_points(tmp_path / "x.bin")
    with pytest.raises(ProfileError, match="there is no such file"):
        read_points(tmp_path / "none.csv")


def test_unknown_flanks_are_refused() -> None:
    made = model("disc_offset_roller")
    x, _, _, _ = nominal(made, count=20)
    with pytest.raises(ProfileError, match=r"no such flank \(found 'lobe'\); allowed: profile"):
        inspect(made, measured(x, flank=("lobe",) * x.shape[1]))


def test_a_circle_leaves_the_angle_undetermined() -> None:
    made = model("disc_offset_roller")
    surface = flank_surfaces(made)[0]
    still = next(span for span in made.setup.program.spans if span.law == "dwell")
    phi = np.linspace(still.start + 0.05, still.end - 0.05, 200)
    x = surface.at(phi, np.full(200, np.mean(surface.wall))).x
    found = inspect(made, measured(x), fit="axial")
    assert "angle" in found.undetermined
    assert found.of().rms < 1e-6


def test_the_command_writes_and_judges(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = str(PROFILES / "disc_offset_roller.toml")
    made = model("disc_offset_roller")
    x, n, _, phi = nominal(made)
    x = x + 0.008 * np.sin(5.0 * phi) * n + 1.5 * n
    rows = "\n".join(",".join(map(repr, row)) for row in x.T.tolist())
    points = tmp_path / "points.csv"
    points.write_text(f"x,y,z\n{rows}\n")
    common = ["inspect", profile, str(points), "--probe-radius", "1.5"]
    assert main([*common, "--out", str(tmp_path / "out"), "--limit", "0.02"]) == 0
    assert "PASS" in capsys.readouterr().out
    data = json.loads((tmp_path / "out" / "inspection.json").read_text())
    assert data["rms_mm"] == pytest.approx(0.008 / np.sqrt(2.0), rel=0.15)
    assert len(table(tmp_path / "out" / "inspection.csv")) == x.shape[1]
    assert main([*common, "--limit", "0.004", "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["passed"] is False
    for wrong in (["--fit", "loose"], ["--limit", "-1"], ["--probe-radius", "big"]):
        assert main([*common, *wrong]) == 2
        assert capsys.readouterr().err.count("\n") == 1
    mirrored = x * np.array([[1.0], [-1.0], [1.0]])
    points.write_text("x,y,z\n" + "\n".join(",".join(map(repr, row)) for row in mirrored.T.tolist()))
    assert main(common) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_a_plate_is_fitted_along_its_travel_and_never_turned() -> None:
    """A groove that stands askew in its plate is an error, and not where the plate was clamped."""
    model = read(str(PROFILES / "linear_groove.toml"))
    cloud = flank_points(model)
    x = cloud["points"][::7]
    askew = x @ np.array([[1.0, 3e-4, 0.0], [-3e-4, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = inspect(model, MeasuredPoints(askew.T, False, None))
    assert found.fit == "travel"
    assert abs(found.of().worst) > 0.01
    moved = inspect(model, MeasuredPoints((x + np.array([0.03, 0.0, 0.0])).T, False, None))
    assert abs(moved.of().worst) < 1e-5
    for fit in ("angle", "axial"):
        with pytest.raises(ProfileError, match="no axis"):
            inspect(model, MeasuredPoints(x.T, False, None), fit=fit)


@pytest.mark.parametrize("name", ["feeder_runout", "two_start"])
@pytest.mark.parametrize("seed", range(4))
def test_points_at_the_very_edges_do_not_keep_the_fit_from_settling(name: str, seed: int) -> None:
    """One that came to lie beyond an edge raised the mean of the others, so that ever shorter steps were taken; what
    settles is the least of the points that count."""
    made, rng, inside = model(name), np.random.default_rng(seed), within(model(name))
    parts = []
    for surface in flank_surfaces(made):
        share = rng.choice([0.0, 0.3, 0.7, 1.0], 150)
        patch = surface.at(rng.uniform(*surface.span, 150), surface.touched[0] + np.ptp(surface.touched) * share)
        parts.append(np.stack([patch.x, patch.n])[:, :, inside(patch.x) >= 0.0])
    x, n = np.concatenate(parts, axis=2)
    proud = 0.006 * np.cos(5.0 * np.arctan2(x[1], x[0]) + 1.0) + 0.002
    placed = rotation(np.array([0.0, 0.0, 0.6])) @ (x + n * (proud + 1.0)) + np.array([0.0, 0.0, 0.3])[:, None]
    found = inspect(made, measured(placed), 1.0, "rigid")
    assert found.kept.mean() > 0.85
    normal = found.feet.n[:, found.kept]
    moves = np.vstack([np.cross(found.points[:, found.kept], normal, axis=0) / 50.0, normal])
    assert np.abs(moves @ found.deviation[found.kept]).max() < 1e-6 * found.kept.sum()
    assert float(np.std(found.deviation[found.kept])) < 0.006


def edge_plate() -> Model:
    """A plate whose edge is one straight ramp of 1 in 5, 150 mm long, under a roller of 9 mm that runs 25 to 125 mm."""
    cam = {"kind": "linear", "form": "edge", "stroke": 100.0, "length": 150.0, "thickness": 12.0, "start": 25.0,
           "edge": 32.0, "drive": "simple-harmonic"}  # fmt: skip
    roller = {"shape": "cylinder", "diameter": 18.0, "length": 9.0}
    return Model(from_data({"name": "ramp", "cam": cam, "follower": {"kind": "translating"}, "roller": roller,
                            "motion": ({"until": 40.0, "to": 8.0, "law": "constant-velocity"},
                                       {"until": 100.0, "to": 20.0, "law": "constant-velocity"})}))  # fmt: skip


def on_the_ramp(along: np.ndarray, off: float) -> np.ndarray:
    """Points (3, n) over places along the plate, `off` mm off its edge, at heights all through its thickness."""
    way = np.array([1.0, 0.2]) / np.hypot(1.0, 0.2)
    normal = np.array([-way[1], way[0]])
    middle = np.array([25.0, 32.0]) - 9.0 * normal
    foot = middle[:, None] + np.outer(way, (along - middle[0]) / way[0])
    return np.stack([*(foot + off * normal[:, None]), np.linspace(0.0, 12.0, len(along))])


def test_an_edge_is_measured_straight_on_to_the_plates_ends() -> None:
    made, along = edge_plate(), np.linspace(0.1, 149.9, 200)
    for off in (0.0, 0.03, -0.2):
        found = inspect(made, measured(on_the_ramp(along, off)), fit="none")
        assert found.kept.all()
        assert np.abs(found.deviation - off).max() < 1e-9
        assert found.feet.x[0].min() < 0.2
        assert found.feet.x[0].max() > 149.8
    # Beyond the ends there is no plate, and what is far off the edge is none of it.
    few = np.concatenate([along, np.linspace(151.0, 170.0, 40)])
    assert (~inspect(made, measured(on_the_ramp(few, 0.0)), fit="none").kept).sum() == 40
    for points in (on_the_ramp(np.linspace(110.0, 190.0, 200), 0.0), on_the_ramp(along, 0.26)):
        with pytest.raises(ProfileError, match="do not belong to this cam"):
            inspect(made, measured(points), fit="none")
    assert inspect(made, measured(on_the_ramp(along, 0.24)), fit="none").kept.all()


@pytest.mark.parametrize("name", ["linear_edge", "linear_groove"])
def test_what_a_plates_mesh_has_of_its_flank_is_measured(name: str) -> None:
    """An edge was known where the roller touches it alone, a groove without the half circles that end it."""
    mesh = model(name).solid.mesh
    x = mesh.vertices[mesh.group_vertices("flank")].T + np.array([0.03, 0.05, 0.0])[:, None]
    for fit in ("none", "travel"):
        found = inspect(model(name), measured(x), fit=fit)
        assert found.kept.all()
        assert abs(found.of().worst) < 0.06
    assert abs(found.shift[2]) < 1e-9
    whole = inspect(model(name), measured(x), fit="rigid")
    assert abs(whole.of().worst) < 1e-6
    assert np.allclose(whole.shift[:2], [-0.03, -0.05], atol=1e-5)
    with pytest.raises(ProfileError, match="do not belong to this cam"):
        inspect(model(name), measured(x + np.array([0.0, 2.0, 0.0])[:, None]), fit="none")


def test_the_text_tells_how_far_a_plate_was_shifted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mesh, file = model("linear_groove").solid.mesh, tmp_path / "points.csv"
    rows = mesh.vertices[mesh.group_vertices("flank")] + np.array([0.03, 0.0, 0.0])
    file.write_text("x,y,z\n" + "\n".join(",".join(map(repr, row)) for row in rows.tolist()))
    assert main(["inspect", str(PROFILES / "linear_groove.toml"), str(file)]) == 0
    assert "best fit: travel; travel -0.030000 mm" in capsys.readouterr().out
    assert main(["inspect", str(PROFILES / "linear_groove.toml"), str(file), "--fit", "rigid", "--json"]) == 0
    (x, y, z), angle = (lambda told: (told["translation_mm"], told["angle_deg"]))(json.loads(capsys.readouterr().out))
    assert main(["inspect", str(PROFILES / "linear_groove.toml"), str(file), "--fit", "rigid"]) == 0
    told = f"rigid; travel {x:.6f} mm, across {y:.6f} mm, height {z:.6f} mm, angle {angle:.6f} deg"
    assert told in capsys.readouterr().out


@pytest.mark.parametrize("fit", ["none", "angle", "axial", "rigid"])
@pytest.mark.parametrize("size", [0.0, 1e-200, 1e-12, 1e-3])
def test_points_that_are_all_but_one_place_are_told(size: float, fit: str) -> None:
    """Numbers of the file that no cam has: a division by nothing, and "this is a bug"."""
    x = size * np.random.default_rng(1).uniform(-1.0, 1.0, (3, 20))
    if fit == "rigid":  # shifted to a flank, one place is any other
        with suppress(NotConverged, ProfileError):
            assert np.isfinite(inspect(model("disc_offset_roller"), measured(x), fit=fit).deviation).all()
        return
    with pytest.raises(ProfileError, match="do not belong to this cam"):
        inspect(model("disc_offset_roller"), measured(x), fit=fit)


def test_a_column_twice_is_no_table(tmp_path: Path) -> None:
    for heads, told in (("x,x,y,z", True), ("x,note,note,y,z", False)):
        place = tmp_path / "points.csv"
        rows = "\n".join(",".join(str(k + j) for j in range(len(heads.split(",")))) for k in range(8))
        place.write_text(f"{heads}\n{rows}\n")
        if told:
            with pytest.raises(ProfileError, match="line 1: names 'x' twice"):
                read_points(place)
        else:
            assert read_points(place).x.shape == (3, 8)
