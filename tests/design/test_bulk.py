"""Studies of many variants: what is drawn, what is tied, rows by the batch equal to the exact model's, files whole."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.design.batch import LEVELS
from camgeom.design.batch.judged import limit_of
from camgeom.design.bulk import Bulk
from camgeom.design.sampling import DRAWN, Plan, sample, tie
from camgeom.design.study import axis, replaced
from camgeom.errors import ProfileError
from camgeom.profile import from_data, read_data
from camgeom.profile.text import dump
from tests.places import PROFILES

Captured = pytest.CaptureFixture[str]
DISC = """
name = "disc"
[cam]
kind = "disc"
base_radius = 40
width = 14
[follower]
kind = "translating"
mass = 0.9
[roller]
shape = "cylinder"
diameter = 22
length = 12
[[motion]]
until = 110
to = 20
law = "cycloidal"
[[motion]]
until = 240
to = 0
law = "3-4-5"
[[motion]]
until = 360
[operation]
speed = 300
friction = 12
spring_rate = 5
spring_preload = 200
"""
SIZES = ["--vary", "cam.base_radius=20:60", "--vary", "roller.diameter=12:30"]
VARIED = [*SIZES, "--tie", "roller.length=8+roller.diameter/9"]


@pytest.fixture
def disc(tmp_path: Path) -> Path:
    path = tmp_path / "disc.toml"
    path.write_text(DISC)
    return path


def plan(text: str, *varied: str) -> Plan:
    method, count, seed = sample(text)
    return Plan(tuple(axis(one, method in DRAWN) for one in varied), method, count, seed)


@pytest.mark.parametrize("method", ["sobol", "latin"])
def test_points_of_a_piece_hang_on_nothing_else(method: str) -> None:
    drawn = plan(f"{method}:100:3", "cam.base_radius=10:20", "cam.width=5,6,7")
    whole = drawn.columns(range(100), {})
    part = drawn.columns(range(37, 61), {})
    assert np.array_equal(whole["cam.base_radius"][37:61], part["cam.base_radius"])
    assert whole["cam.width"][37:61] == part["cam.width"]
    assert set(whole["cam.width"]) == {5, 6, 7}
    radii = np.asarray(whole["cam.base_radius"])
    assert 10.0 <= radii.min() < 10.5
    assert 19.5 < radii.max() <= 20.0
    other = plan(f"{method}:100:4", "cam.base_radius=10:20", "cam.width=5,6,7").columns(range(100), {})
    assert not np.array_equal(other["cam.base_radius"], radii)


def test_every_stretch_of_a_hypercube_has_one_point() -> None:
    found = np.asarray(plan("latin:50", "cam.base_radius=0:50").columns(range(50), {})["cam.base_radius"])
    assert sorted(found.astype(int)) == list(range(50))


def test_a_grid_and_a_list() -> None:
    grid = plan("grid", "cam.base_radius=1,2", "cam.width=5:7:3").columns(range(6), {})
    assert grid == {"cam.base_radius": [1, 1, 1, 2, 2, 2], "cam.width": [5, 6, 7, 5, 6, 7]}
    listed = plan("list", "cam.base_radius=1,2", "cam.direction=cw,ccw").columns(range(2), {})
    assert listed == {"cam.base_radius": [1, 2], "cam.direction": ["cw", "ccw"]}


def test_a_tie_takes_varied_keys_and_the_profiles() -> None:
    one = tie("cam.bore = 0.4 * cam.base_radius + motion[0].to")
    data = {"cam": {"base_radius": 30.0}, "motion": ({"to": 2.0},)}
    assert one.values({}, data).tolist() == [14.0]
    assert one.values({"cam.base_radius": np.array([10.0, 20.0])}, data).tolist() == [6.0, 10.0]


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("cam.bore", "KEY=EXPRESSION"), ("bore=3", "KEY=EXPRESSION"), ("cam.bore=1 if 2 else 3", "not allowed"),
        ("cam.bore=base", "unknown name"), ("cam.bore=cam.kind*2", "no number"), ("cam.bore=cam.none*2", "no number"),
        ("cam.bore=1/(cam.width-5)", "finite"),
    ],
)  # fmt: skip
def test_what_is_no_tie_is_refused(text: str, word: str) -> None:
    with pytest.raises(ProfileError, match=word):
        tie(text).values({}, {"cam": {"kind": "disc", "width": 5.0}})


@pytest.mark.parametrize("turned", [False, True])
def test_ties_follow_each_other_in_any_order(turned: bool) -> None:
    ties = [tie("cam.bore=cam.width"), tie("cam.width=cam.base_radius*0.3")]
    made = Plan((axis("cam.base_radius=40,50"),), ties=tuple(ties[::-1] if turned else ties))
    columns = made.columns(range(2), {"cam": {"base_radius": 30.0, "width": 14.0, "bore": 20.0}})
    assert tuple(columns) == made.keys
    assert list(columns["cam.bore"]) == list(columns["cam.width"]) == [12.0, 15.0]


@pytest.mark.parametrize("written", [("cam.bore=cam.bore+1",), ("cam.bore=cam.width", "cam.width=cam.bore")])
def test_ties_in_a_circle_are_refused(written: tuple[str, ...]) -> None:
    with pytest.raises(ProfileError, match="in a circle"):
        Plan((axis("cam.base_radius=40,50"),), ties=tuple(map(tie, written)))


def test_a_tie_to_a_switch_that_is_varied_says_so() -> None:
    with pytest.raises(ProfileError, match=r"varied by words \(found 'cam.run_out'\)"):
        tie("cam.bore=10*cam.run_out").values({"cam.run_out": ["true", "false"]}, {"cam": {"run_out": True}})


@pytest.mark.parametrize("written", ["foo*cam.width", "cam.width**", "cam.width/0", "key0+cam.width"])
def test_a_tie_is_told_as_it_was_written(written: str) -> None:
    """Not with the names that stand for its keys, one of which was taken for the key itself."""
    with pytest.raises(ProfileError) as refused:
        tie(f"cam.bore={written}").values({}, {"cam": {"kind": "disc", "width": 5.0}})
    assert f"(found '{written}')" in str(refused.value)
    assert "known: key" not in str(refused.value)


@pytest.mark.parametrize(("written", "status"), [("cam.none*2", 2), ("20/(cam.base_radius-20)", 0)])
def test_a_tie_without_a_number_is_refused_before_points_are_drawn(
    disc: Path, tmp_path: Path, written: str, status: int
) -> None:
    """Of an axis' first value, which points drawn hardly ever have, it need not be finite."""
    words = ["--vary", "cam.base_radius=20:60", "--tie", f"limits.life_h={written}", "--sample", "sobol:300"]
    assert main(["study", str(disc), *words, "--out", str(tmp_path / "out")]) == status
    assert (tmp_path / "out").exists() is (status == 0)


@pytest.mark.parametrize(
    ("text", "varied"),
    [
        ("sobol", ("cam.width=1:2",)), ("sobol:0", ("cam.width=1:2",)), ("grid", ("cam.width=1:2",)),
        ("list", ("cam.width=1,2", "cam.bore=1,2,3")), ("latin:5", ("cam.width=1:2", "cam.width=1:3")),
    ],
)  # fmt: skip
def test_what_is_no_plan_is_refused(text: str, varied: tuple[str, ...]) -> None:
    with pytest.raises(ProfileError):
        plan(text, *varied)


def run(capsys: Captured, *words: str) -> tuple[int, dict]:
    status = main(["study", *words, "--json"])
    return status, json.loads(capsys.readouterr().out)


def test_rows_of_the_batch_are_the_models(disc: Path, tmp_path: Path, capsys: Captured) -> None:
    words = [str(disc), *VARIED, "--sample", "sobol:12", "--out", str(tmp_path / "out")]
    status, batch = run(capsys, *words, "--batch")
    exact_status, exact = run(capsys, *words, "--exact")
    assert (status, batch["computed_by"]) == (0, "batch")
    assert (exact_status, exact["computed_by"]) == (0, "exact model")
    for one, other in zip(batch["rows"], exact["rows"], strict=True):
        assert one["verdict"] == other["verdict"]
        for key in one.keys() - {"verdict", "reason", "not_judged"}:
            assert one[key] == (other[key] if other[key] is None else pytest.approx(other[key], rel=1e-3)), key
    assert "wall" in batch["rows"][0]["not_judged"].split()
    assert "undercut" not in batch["rows"][0]["not_judged"].split()


def test_what_fails_a_limit_fails_by_its_check(disc: Path, tmp_path: Path, capsys: Captured) -> None:
    steep = ["--vary", "motion[0].until=40,110", "--vary", "operation.speed=300,2000"]
    words = [str(disc), *steep, "--vary", "limits.undercut_margin=0,0.99", "--out", str(tmp_path / "out")]
    _, batch = run(capsys, *words, "--batch")
    _, exact = run(capsys, *words, "--exact")
    judged = {"pressure-angle", "contact-kept", "undercut", "contact-pressure"}
    for one, other in zip(batch["rows"], exact["rows"], strict=True):
        assert set(one["reason"].split("; ")) - {""} == set(other["reason"].split("; ")) & judged
    assert {row["verdict"] for row in batch["rows"]} >= {"fail"}


@pytest.mark.parametrize(
    ("profile", "check", "lives"), [("barrel_indexer", "turret-pressure", "turret-life"),
                                    ("disc_flat_face", "face-pressure", "face-life")],
)  # fmt: skip
def test_checks_have_the_names_of_what_presses(
    profile: str, check: str, lives: str, tmp_path: Path, capsys: Captured
) -> None:
    """Also where nothing is varied on which geometry rests; what is judged by another name was told as left out."""
    words = [f"profiles/{profile}.toml", "--vary", "limits.contact_pressure_mpa=100,3000", "--out", str(tmp_path)]
    _, batch = run(capsys, *words, "--batch")
    _, exact = run(capsys, *words, "--exact")
    assert [row["reason"] for row in batch["rows"]] == [row["reason"] for row in exact["rows"]] == [check, ""]
    left = batch["rows"][0]["not_judged"].split()
    assert check not in left
    assert lives in left


def test_lives_of_some_bodies_are_no_judgement(disc: Path, tmp_path: Path, capsys: Captured) -> None:
    """Of a drum the batch knows the cam's life alone, of a disc all; a groove whose roller died passed by its cam."""
    words = ["--vary", "operation.load_mass=1,2", "--vary", "limits.life_h=1e4", "--batch", "--out", str(tmp_path)]
    _, drum = run(capsys, "profiles/pin_insertion.toml", *words)
    assert "life" in drum["rows"][0]["not_judged"].split()
    _, other = run(capsys, str(disc), *words)
    assert "life" not in other["rows"][0]["not_judged"].split()
    _, unasked = run(capsys, str(disc), *words[:2], *words[4:])
    assert "life" in unasked["rows"][0]["not_judged"].split()


def test_a_thin_rib_is_judged_by_the_batch_as_by_the_model(tmp_path: Path, capsys: Captured) -> None:
    """Its flanks cross, or it is thin on steep places, or it passes: thicker and thinner than asked."""
    data = read_data("profiles/milled_drum.toml")
    data["cam"] |= {"form": "rib", "rib_thickness": 20.0, "length": 160, "start": 65, "diameter": 140}
    del data["cutter"]
    path = tmp_path / "rib.toml"
    path.write_text(dump(data))
    words = [str(path), "--vary", "cam.rib_thickness=3,8.9,9.3,12,40", "--out", str(tmp_path / "out")]
    _, batch = run(capsys, *words, "--batch")
    _, exact = run(capsys, *words, "--exact")
    for one, other in zip(batch["rows"], exact["rows"], strict=True):
        assert ("rib-thickness" in one["reason"]) == ("rib-thickness" in other["reason"])
        assert one["flank.rib_thickness_mm"] == pytest.approx(other["flank.rib_thickness_mm"], rel=1e-5)
    assert [row["verdict"] for row in batch["rows"]][1:] == [row["verdict"] for row in exact["rows"]][1:]
    assert len({row["verdict"] for row in batch["rows"]}) == 3


DRUM = Path("profiles/pin_insertion.toml")


@pytest.mark.parametrize("key", ["limits.velocity", "limits.clearance_mm", "limits.life_h", "cam.root_radius"])
def test_a_key_that_no_figure_hangs_on_is_the_models(disc: Path, key: str) -> None:
    """300 limits of the velocity were 300 rows that were the same, and none of them failed."""
    groove, read = read_data(DRUM), ("limits.clearance_mm", "limits.life_h")
    why = Bulk(groove, str(DRUM), plan("sobol:300", f"{key}=1:2")).refused()
    assert why is None if key in read else why == f"{key}: no figure and no check of the batch hangs on it"
    if not key.startswith("cam"):
        # A disc has no floor.
        why = Bulk(read_data(disc), str(disc), plan("sobol:300", f"{key}=1:2")).refused()
        assert (why is None) == (key == "limits.life_h")


@pytest.mark.parametrize("varied", ["output.table_points=3:400", "cam.bore=10:20", "limits.velocity=1:2000"])
def test_a_key_that_only_lets_variants_exist_is_the_models(disc: Path, varied: str) -> None:
    """The first has no number of its own to be tried with, the second decides whether there is a cam, the third's
    profile cannot be made, so that nothing was asked of it: 300 equal rows each, and a wall that failed passed."""
    data = read_data(disc)
    if varied.startswith("limits"):
        data = replaced(data, ("cam", "base_radius"), 5.0, "cam.base_radius")
    axes = (varied, "cam.base_radius=40:60")
    why = Bulk(data, str(disc), plan("sobol:300", *axes)).refused()
    assert why == f"{varied.partition('=')[0]}: no figure and no check of the batch hangs on it"
    assert Bulk(data, str(disc), plan("sobol:300", axes[1])).refused() is None


def test_words_of_what_a_solver_answers_are_the_models() -> None:
    path = PROFILES / "conjugate_rocker.toml"
    drawn = plan("sobol:300", "impact.true_curvature=true,false", "material.cam.elastic_modulus=2e5:2.1e5")
    why = Bulk(read_data(path), str(path), drawn).refused()
    assert why == "impact.true_curvature: [impact] is answered by a solver"


def test_figures_that_were_asked_for_come_in_their_order_and_say_what_they_leave_open(
    disc: Path, tmp_path: Path, capsys: Captured
) -> None:
    """In CSV and on the terminal, by the batch as by the exact model."""
    wanted = ("contact.peak_torque_n_m", "contact.mean_torque_n_m")
    for way in ("--batch", "--exact"):
        out = tmp_path / way
        main(["study", str(disc), "--vary", "operation.speed=100:300:2", "--figures", ",".join(wanted), way,
              "--out", str(out)])  # fmt: skip
        said = capsys.readouterr().out
        assert all(key in said for key in wanted)
        assert ("without --figures contact-kept, " in said) == (way == "--batch")
        with open(out / "study.csv") as stream:
            assert next(csv.reader(stream))[1:3] == list(wanted)


@pytest.mark.parametrize(
    ("key", "holds", "fails", "check"),
    [
        ("cam.length", 103.1, 102.9, "run-out"),
        ("limits.clearance_mm", 0.99, 1.01, "floor-gap"),
    ],
)
def test_ends_and_floor_of_a_drum_are_judged_as_by_the_model(
    tmp_path: Path, capsys: Captured, key: str, holds: float, fails: float, check: str
) -> None:
    rows = []
    for way in ("--batch", "--exact"):
        command = ["study", str(DRUM), "--vary", f"{key}={holds},{fails}", "--out", str(tmp_path), "--json", way]
        main(command)
        rows.append([check in row["reason"].split("; ") for row in json.loads(capsys.readouterr().out)["rows"]])
    assert rows[0] == rows[1] == [False, True]


def test_a_face_too_narrow_is_judged_by_the_batch_as_by_the_model(tmp_path: Path, capsys: Captured) -> None:
    needed = 0.0
    for way in ("--exact", "--batch"):
        command = ["study", "profiles/disc_flat_face.toml", "--out", str(tmp_path), "--json", way]
        if not needed:
            main([*command, "--vary", "follower.face_width=60"])
            needed = json.loads(capsys.readouterr().out)["rows"][0]["flank.face_width_needed_mm"]
        main([*command, "--vary", f"follower.face_width={needed * 1.002},{needed * 0.998}"])
        assert [row["reason"] for row in json.loads(capsys.readouterr().out)["rows"]] == ["", "face-width"]


def test_a_warning_beyond_its_limit_is_bad_input_to_the_batch_too(disc: Path) -> None:
    axes = ("limits.pressure_angle_deg=40,20,40", "limits.warn_pressure_angle_deg=35,35,41")
    many = Bulk(read_data(disc), str(disc), plan("list", *axes))
    found = many.columns(many.drawn(range(3)))
    beyond = "limits.warn_pressure_angle_deg: the limit fails before it warns"
    assert list(found["reason"]) == ["", beyond, beyond]
    assert list(found["verdict"])[1:] == ["bad input"] * 2


def test_the_angle_that_warns_follows_a_varied_limit() -> None:
    """Of a limit of 24 deg it warns from 24 deg on, not from the usual 30 deg, nor from 24 where the limit is 40."""
    data = {**read_data(DRUM), "limits": {"pressure_angle_deg": 24.0}}
    profile = from_data(data, "")
    varied = {"limits.pressure_angle_deg": np.array([24.0, 28.0, 40.0])}
    assert list(limit_of(profile, varied, "warn_pressure_angle_deg")) == [24.0, 28.0, 30.0]
    assert [from_data(replaced(data, ("limits", "pressure_angle_deg"), float(one), ""), "").limits.
            warn_pressure_angle_deg for one in varied["limits.pressure_angle_deg"]] == [24.0, 28.0, 30.0]


def test_reasons_stand_in_the_order_of_the_models(disc: Path, tmp_path: Path, capsys: Captured) -> None:
    told = []
    for way in ("--batch", "--exact"):
        main(["study", str(disc), "--vary", "limits.pressure_angle_deg=5", "--vary", "limits.contact_pressure_mpa=5",
              "--out", str(tmp_path), "--json", way])
        told.append([row["reason"] for row in json.loads(capsys.readouterr().out)["rows"]])
    assert told[0] == told[1] == ["contact-pressure; pressure-angle"]


def test_few_variants_are_the_models_and_it_says_so(disc: Path, tmp_path: Path, capsys: Captured) -> None:
    words = ["study", str(disc), "--vary", "cam.base_radius=30:40:3", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    assert "computed by the exact model: up to 200 variants" in capsys.readouterr().out
    assert main([*words[:3], "cam.base_radius=30:40:300", *words[4:]]) == 0
    assert "computed by the batch" in capsys.readouterr().out
    with open(tmp_path / "out" / "study.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 300
    assert float(rows[-1]["cam.base_radius"]) == 40.0
    assert main([*words[:3], "cam.bore=0:10:3", *words[4:], "--batch", "--only", "flank"]) == 2
    assert "--batch" in capsys.readouterr().err
    assert main([*words[:3], "cam.base_radius=30:40", "--sample", "sobol:200000", *words[4:], "--only", "flank"]) == 2
    assert "has to compute them (--only names what the exact model gives)" in capsys.readouterr().err


def test_words_are_profiles_of_their_own(disc: Path) -> None:
    data = read_data(disc)
    many = Bulk(data, "", plan("grid", "motion[0].law=cycloidal,3-4-5", "cam.base_radius=30:60:2"))
    assert many.refused() is None
    columns = many.columns(many.drawn(range(4)))
    jerk = columns["motion.peak_jerk_mm_per_rad3"]
    assert jerk[0] == jerk[1] != jerk[2] == jerk[3]
    other = Bulk(data, "", plan("grid", "roller.shape=cylinder,sphere"))
    assert other.refused() is not None


def test_all_pieces_have_the_columns_of_all_words() -> None:
    """A flat face has figures that a knife edge has not: a piece of one alone has them too, without a value."""
    data = read_data(PROFILES / "disc_flat_face.toml")
    kept = {key: data[key] for key in ("name", "cam", "operation", "motion")}
    follower = {key: value for key, value in data["follower"].items() if key != "face_width"}
    many = Bulk({**kept, "follower": follower}, "", plan("grid", "follower.face=flat,knife", "operation.speed=50:60:2"))
    assert many.refused() is None
    flat, knife, both = (many.columns(many.drawn(piece)) for piece in (range(2), range(2, 4), range(4)))
    assert list(flat) == list(knife) == list(both)
    assert np.isinf(knife["flank.min_face_radius_mm"]).all()
    assert np.isfinite(flat["flank.min_face_radius_mm"]).all()
    assert [list(both[name][2:]) for name in both] == [list(knife[name]) for name in knife]


def test_parquet_of_the_batch_is_whole_and_goes_on(disc: Path, tmp_path: Path, capsys: Captured) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    words = ["study", str(disc), *VARIED, "--sample", "latin:500", "--parquet", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    path = tmp_path / "out" / "study.parquet"
    first = path.read_bytes()
    assert parquet.read_metadata(path).num_rows == 500
    assert main(words) == 0
    assert "500 of 500 variants were computed before" in capsys.readouterr().err
    assert path.read_bytes() == first


def test_the_error_of_an_indexers_pressures_is_asked_for_where_it_means_something(
    disc: Path, tmp_path: Path, capsys: Captured
) -> None:
    data = read_data("profiles/barrel_indexer.toml")
    drawn = plan("sobol:40", "roller.diameter=20:40", "cam.width=60:90")
    pressure = "contact.peak_slice_pressure_mpa"
    studies = (Bulk(data, "", drawn, (pressure,), level) for level in LEVELS)
    rough, fine = (np.asarray(one.columns(one.drawn(range(40)))[pressure]) for one in studies)
    assert (rough != fine).any()
    exist = np.isfinite(fine)
    assert np.abs(rough / fine - 1.0)[exist].max() < LEVELS[0]
    command = ["study", "profiles/barrel_indexer.toml", "--vary", "roller.diameter=20:40", "--sample", "sobol:8"]
    command += ["--out", str(tmp_path), "--pressure-error"]
    assert main([*command, "0.003", "--batch"]) in (0, 1)
    capsys.readouterr()
    assert main([*command, "0.003", "--exact"]) == 2
    assert "exact model computes the rows" in capsys.readouterr().err
    assert main([*command, "0.02", "--batch"]) == 2
    assert "needs one of 0.01 and 0.003" in capsys.readouterr().err
    command[1] = str(disc)
    assert main([*command, "0.003", "--batch"]) == 2
    assert "of round indexing cams alone" in capsys.readouterr().err
