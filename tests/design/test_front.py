"""The front: what is asked for, the search, the exact model's word on every member, and the command."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.design.engine import Alone
from camgeom.design.front import Archive, Foretelling, balanced, front_of, judged, learnt, search, spread
from camgeom.design.requirement import Aim, Bound, Requirement, bounded, figure_name, free, limits_of
from camgeom.design.sampling import tie
from camgeom.design.study import Figures, Row
from camgeom.drawing.content import Axis, Parallel
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.profile.text import dump, load
from camgeom.report.page import sheet
from tests.design.runs import ABSENT, DATA
from tests.places import PROFILES


@pytest.fixture
def _pymoo() -> None:
    pytest.importorskip("pymoo", reason=f"no pymoo: {ABSENT}")


def test_free_keys() -> None:
    one = free("cam.diameter=70:110")
    assert one.values(np.array([0.0, 0.5, 0.12345678, 1.0])) == [70.0, 90.0, 74.938, 110.0]
    assert free("cam.diameter=0.1:0.3").values(np.array([1.0])) == [0.3]
    stepped = free("follower.stops=4:8:5")
    assert stepped.values(np.array([0.0, 0.19, 0.21, 1.0])) == [4, 4, 5, 8]
    assert free("motion[0].law=cycloidal,3-4-5").values(np.array([0.1, 0.9])) == ["cycloidal", "3-4-5"]


@pytest.mark.parametrize("text", ["", "a", "a=5:5", "a=9:5", "a=nan:5", "a=1:inf", "a=x:5", "=1:2", "a b=1:2"])
def test_keys_that_cannot_be_free(text: str) -> None:
    with pytest.raises(ProfileError, match="--free: needs KEY=A:B"):
        free(text)


def test_figures_by_name_end_and_alias() -> None:
    known = ["blank.volume_mm3", "contact.peak_pressure_mpa", "dynamics.duty.peak_pressure_mpa", "contact.peak_force_n"]
    assert figure_name("size", known, "--least") == "blank.volume_mm3"
    assert figure_name("peak_force_n", known, "--least") == "contact.peak_force_n"
    assert figure_name("contact.peak_pressure_mpa", known, "--least") == "contact.peak_pressure_mpa"
    with pytest.raises(ProfileError, match="--least: names several figures"):
        figure_name("peak_pressure_mpa", known, "--least")
    with pytest.raises(ProfileError, match=r"--most: is no figure .* did you mean 'contact.peak_force_n'"):
        figure_name("contact.peak_forc_n", known, "--most")


def test_what_counts_in_the_search() -> None:
    assert bounded("fatigue.roller_life_h", np.array([5.0, 1e9, np.inf])).tolist() == [5.0, 1e7, 1e7]
    assert bounded("contact.peak_torque_n_m", np.array([-3.0])).tolist() == [3.0]
    assert np.isfinite(bounded("flank.x", np.array([np.inf, -np.inf]))).all()
    assert Bound("f", 1.0, 30.0, "").excess(np.array([29.97, 30.06])).tolist() == pytest.approx([-0.001, 0.002])
    assert Bound("f", -1.0, 30.0, "").excess(np.array([29.97, 30.06])).tolist() == pytest.approx([0.001, -0.002])


def test_a_mean_torque_keeps_its_sign() -> None:
    """A bound of -0.05 N m on one that reaches -0.2 could not be kept, and its least was its largest."""
    assert bounded("contact.mean_torque_n_m", np.array([-0.2, 0.1])).tolist() == [-0.2, 0.1]
    assert bounded("contact.peak_torque_n_m", np.array([-0.2, 0.1])).tolist() == [0.2, 0.1]


@pytest.mark.usefixtures("_pymoo")
def test_a_bound_that_is_asked_for_leaves_the_profiles_own_limits(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Below the pressure angle that the profile allows: with it the search went past that, and what it showed was what
    had passed by chance."""
    words = ["optimise", str(disc(tmp_path)), "--free", "cam.base_radius=20:60", "--least", "size", "--over",
             "flank.max_pressure_angle_deg=5", "--points", "300", "--members", "3", "--jobs", "1", "--json",
             "--out", str(tmp_path / "out")]  # fmt: skip
    main(words)
    told = json.loads(capsys.readouterr().out)
    said = [bound["of"] for bound in told["bounds"] if bound["figure"] == "flank.max_pressure_angle_deg"]
    assert said == ["--over flank.max_pressure_angle_deg=5", "check pressure-angle"]


def test_limits_bind_only_what_the_check_judged() -> None:
    row = Row((), {"flank.max_pressure_angle_deg": 25.0, "contact.peak_pressure_mpa": 800.0}, "pass")
    findings = [
        {"check": "pressure-angle", "value": 25.0, "limit": 30.0, "comparison": "<="},
        {"check": "contact-pressure", "value": 900.0, "limit": 2450.0, "comparison": "<="},
        {"check": "watertight", "value": 1.0, "limit": 1.0, "comparison": "="},
    ]
    found = limits_of(row, findings, list(row.figures))
    assert [(b.figure, b.sign, b.value) for b in found] == [("flank.max_pressure_angle_deg", 1.0, 30.0)]
    assert limits_of(row, findings, []) == ()


def test_a_limit_that_may_not_be_met_is_kept_off() -> None:
    gap = Row((), {"checks.floor-gap": 0.5}, "pass")
    (one,) = limits_of(gap, [{"check": "floor-gap", "value": 0.5, "limit": 0.0, "comparison": ">"}], list(gap.figures))
    assert one.excess(np.array([0.0, 1e-6])).tolist() == pytest.approx([1e-9, -1e-6 + 1e-9])
    assert (one.excess(np.array([0.0, 1e-6])) > 0.0).tolist() == [True, False]


def test_a_requirement_needs_keys_and_aims() -> None:
    one, aim = free("cam.diameter=70:110"), Aim("a", 1.0)
    for keys, aims, message in (((), (aim,), "free key"), ((one,), (), "an aim"), ((one, one), (aim,), "twice")):
        with pytest.raises(ProfileError, match=message):
            Requirement(DATA, "", keys, aims)


def test_spread_takes_the_ends_and_keeps_what_is_given() -> None:
    x = np.linspace(0.0, 1.0, 101)
    scores = np.stack([x, 1.0 - x], axis=1)
    assert sorted(spread(scores, np.arange(101), 5)) == [0, 25, 50, 75, 100]
    assert 33 in spread(scores, np.arange(101), 4, [33])
    assert spread(scores, np.array([7, 9]), 5) == [7, 9]
    same = np.zeros((10, 2))
    assert len(spread(same, np.arange(10), 5)) == 1


KEYS = (free("cam.diameter=70:110"), free("roller.diameter=8:16"))


def toy(points):  # type: ignore[no-untyped-def]
    """Two figures with a front along roller.diameter = 16, which exist above a diameter of 75."""
    d, r = (np.array(column, dtype=float) for column in zip(*points))
    return {"size": d, "pressure": 2e4 / d + (16.0 - r) ** 2}, d > 75.0


def wanted(*bounds: Bound) -> Requirement:
    return Requirement(DATA, "", KEYS, (Aim("size", 1.0), Aim("pressure", 1.0)), bounds)


def exactly(model: Model, worse: float = 1.0) -> tuple[Figures, str, str]:
    """The toy's exact model: a figure a little worse, and a check that the search does not know of."""
    figures, _ = toy([(model.profile.cam.diameter, model.profile.roller.diameter)])  # type: ignore[attr-defined,union-attr]
    found = {"size": float(figures["size"][0]), "pressure": worse * float(figures["pressure"][0])}
    found["checks.too-large"] = model.profile.cam.diameter  # type: ignore[attr-defined]
    if model.profile.cam.diameter > 100.0:  # type: ignore[attr-defined]
        return {**found, "not_judged": ""}, "fail", "too-large"
    bad = found["pressure"] > 240.0
    return {**found, "not_judged": ""}, "fail" if bad else "pass", "contact-pressure" if bad else ""


@pytest.mark.usefixtures("_pymoo")
def test_the_search_finds_a_known_front() -> None:
    archive = search(wanted(), toy, 64, 40, lambda count: None)
    assert archive.evaluated == 64 * 40
    assert (archive.figures["size"] > 75.0).all()
    front = archive.front()
    d = archive.figures["size"][front]
    assert archive.figures["pressure"][front] == pytest.approx(2e4 / d, abs=0.5)
    assert d.min() < 75.5
    assert d.max() > 109.0
    again = search(wanted(), toy, 64, 40, lambda count: None)
    assert np.array_equal(archive.shares, again.shares)


@pytest.mark.usefixtures("_pymoo")
def test_members_pass_where_the_exact_model_differs_from_the_search() -> None:
    """The exact pressure is 2 % higher than the search's, and a check of its own forbids large cams."""
    requirement = wanted(Bound("pressure", 1.0, 240.0, "limit"))
    archive = search(requirement, toy, 64, 40, lambda count: None)
    front = front_of(requirement, judged(archive, partial_exact, Alone(), 12, lambda count: None), 12)
    assert len(front.members) >= 8
    assert {row.verdict for row in front.members} == {"pass"}
    sizes = [float(row.figures["size"] or 0.0) for row in front.members]
    assert sizes == sorted(sizes)
    assert max(sizes) <= 100.0
    assert min(sizes) == pytest.approx(1.02 * 2e4 / 240.0, rel=0.01)
    assert max(sizes) > 97.0
    assert front.refused["too-large"] > 0


@pytest.mark.usefixtures("_pymoo")
def test_a_check_that_refused_members_is_foretold_in_the_next_search() -> None:
    requirement = wanted(Bound("pressure", 1.0, 240.0, "limit"))
    archive = search(requirement, toy, 64, 40, lambda count: None)
    rows = judged(archive, exactly, Alone(), 12, lambda count: None)
    limit = {"check": "too-large", "value": 80.0, "limit": 100.0, "comparison": "<="}
    other = {"check": "undercut", "value": 0.5, "limit": 0.0, "comparison": ">"}
    bounds, checks = learnt(requirement, rows, [limit, other])
    assert [(b.figure, b.sign, b.value, b.own) for b in bounds] == [("checks.too-large", 1.0, 100.0, True)]
    foretold = replace(requirement, bounds=(*requirement.bounds, *bounds))
    again = search(foretold, Foretelling(toy, requirement, checks), 64, 40, lambda count: None)
    more = judged(again, exactly, Alone(), 12, lambda count: None)
    passing = [row for row in more if row.verdict == "pass"]
    assert len(passing) >= 0.6 * len(more)
    front = front_of(requirement, [*rows, *more], 12)
    assert {row.verdict for row in front.members} == {"pass"}
    assert 99.5 < max(float(row.figures["size"] or 0.0) for row in front.members) <= 100.0
    assert learnt(requirement, rows, [other]) == ((), {})
    assert learnt(requirement, rows[:2], [limit]) == ((), {})


def partial_exact(model: Model) -> tuple[Figures, str, str]:
    return exactly(model, worse=1.02)


@pytest.mark.usefixtures("_pymoo")
def test_nothing_passes_is_told_with_the_reasons() -> None:
    def never(model: Model) -> tuple[Figures, str, str]:
        raise DesignError("no such body")

    archive = search(wanted(), toy, 32, 5, lambda count: None)
    front = front_of(wanted(), judged(archive, never, Alone(), 5, lambda count: None), 5)
    assert front.members == ()
    assert front.judged <= 20
    assert set(front.refused) == {"no such body"}


def test_the_balanced_member() -> None:
    rows = [Row((), {"size": s, "pressure": p}, "pass") for s, p in ((1.0, 9.0), (2.0, 3.0), (9.0, 1.0))]
    assert balanced(rows, wanted()) == 1


@pytest.mark.parametrize("path", sorted(PROFILES.glob("*.toml")), ids=lambda path: path.stem)
def test_profiles_are_written_as_they_were_read(path: Path) -> None:
    data = read_data(path)
    again, problems, _ = load(dump(data), str(path))
    assert problems == []
    assert again == data


def test_words_and_keys_are_written_safely() -> None:
    data = {"a b": 'quote " and \\ and é', "list": (1, 2.5, "x"), "pairs": ((1, 2), (3, 4)), "t": ({"u": {"v": True}},)}
    assert load(dump(data), "")[0] == data


@pytest.mark.parametrize("width", [320.0, 760.0])
@pytest.mark.parametrize("count", [2, 5, 14])
def test_parallel_coordinates_keep_their_words_apart(width: float, count: int) -> None:
    lines = np.random.default_rng(1).random((9, count)) * 10.0 ** np.arange(count)
    axes = tuple(Axis(f"quantity_{i}", "MPa") for i in range(count))
    drawn = sheet(Parallel("x", axes, lines, 3), width)
    assert all(box[0] >= -1.0 and box[2] <= width + 1.0 for box, _ in drawn.words)
    boxes = [box for box, _ in drawn.words]
    for i, box in enumerate(boxes):
        assert all(min(box[2], b[2]) <= max(box[0], b[0]) + 1 or min(box[3], b[3]) <= max(box[1], b[1]) + 3
                   for b in boxes[i + 1 :])  # fmt: skip
    with pytest.raises(ValueError, match="do not fit"):
        Parallel("x", axes, lines[:, 1:], 0)


OPTIMISE = ["--free", "cam.base_radius=25:60", "--free", "roller.diameter=10:30", "--least", "size",
            "--least", "contact.peak_slice_pressure_mpa", "--jobs", "1"]


def disc(folder: Path) -> Path:
    """A disc that the batch carries."""
    data = read_data(PROFILES / "disc_offset_roller.toml")
    loads = {key: value for key, value in data["operation"].items() if key != "force"}
    roller = {"shape": "cylinder", "diameter": 22, "length": 12}
    path = folder / "disc.toml"
    path.write_text(dump({**data, "roller": roller, "operation": loads}))
    return path


@pytest.mark.slow
@pytest.mark.usefixtures("_pymoo")
def test_every_member_that_the_command_shows_passes_the_exact_checks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["optimise", str(disc(tmp_path)), *OPTIMISE, "--points", "2560", "--members", "6", "--out", str(out)]
    assert main([*command, "--under", "flank.max_pressure_angle_deg=24", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["searched_by"] == "batch"
    assert told["searched"] == 2560
    assert 3 <= len(told["front"]) <= 6
    assert told["least"] == ["blank.volume_mm3", "contact.peak_slice_pressure_mpa"]
    sizes = [member["blank.volume_mm3"] for member in told["front"]]
    pressures = [member["contact.peak_slice_pressure_mpa"] for member in told["front"]]
    assert sizes == sorted(sizes)
    assert pressures == sorted(pressures, reverse=True)
    for member in told["front"]:
        assert member["flank.max_pressure_angle_deg"] <= 24.0
        assert main(["check", member["file"], "--json"]) == 0
        checked = json.loads(capsys.readouterr().out)
        assert checked["verdict"] in ("pass", "warn")
        assert checked["blank"]["volume_mm3"] == member["blank.volume_mm3"]
    chosen = from_data(read_data(out / "chosen.toml"), str(out / "chosen.toml"))
    assert chosen.cam.base_radius == told["front"][told["chosen"] - 1]["cam.base_radius"]  # type: ignore[attr-defined]
    page = (out / "front.html").read_text()
    assert "members of the front" in page
    assert "http://" not in page.replace("http://www.w3.org", "")
    assert "https://" not in page


@pytest.mark.usefixtures("_pymoo")
def test_members_of_an_earlier_search_do_not_stand_beside_those_of_a_new_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = ["optimise", str(disc(tmp_path)), *OPTIMISE, "--points", "256", "--members", "3", "--out", str(out)]

    def there() -> set[str]:
        capsys.readouterr()
        return {str(file.relative_to(out)) for file in out.rglob("*") if file.suffix in (".toml", ".html")}

    assert main(command) == 0
    members = {path.name for path in (out / "front").glob("*.toml")}
    first = there()
    assert first == {"chosen.toml", "front.html", *(f"front/{name}" for name in members)}
    assert len(members) > 1
    assert main(command) == 0
    assert there() == first, "the same search again replaces its files"
    assert main([*command, "--under", "size=1"]) == 1
    aside = {"previous/chosen.toml", *(f"front/previous/{name}" for name in members)}
    assert there() == {"front.html"} | aside
    assert main([*command, "--members", "1"]) == 0
    assert there() == {"chosen.toml", "front.html", "front/01.toml"} | aside


@pytest.mark.usefixtures("_pymoo")
@pytest.mark.parametrize("alike", [True, False])
def test_data_files_belong_to_the_search_and_those_of_the_user_are_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], alike: bool
) -> None:
    path, out = disc(tmp_path), tmp_path / "out"
    rise = {"until": 180, "law": "table", "file": "lift.csv", "to": 12.0}
    moves = (rise, {"until": 360, "law": "3-4-5", "to": 0.0})
    path.write_text(dump({**read_data(path), "motion": moves}))
    s = np.linspace(0.0, 1.0, 61)
    lift = "".join(f"{180 * x!r},{12 * (x - np.sin(2 * np.pi * x) / (2 * np.pi)):.17g}\n" for x in s.tolist())
    (tmp_path / "lift.csv").write_text(lift)
    (out / "front").mkdir(parents=True)
    (out / "lift.csv").write_text(lift if alike else "mine")
    words = ["--free", "cam.base_radius=34:45", "--least", "size", "--points", "16", "--members", "2"]
    words += ["--out", str(out)]
    assert main(["optimise", str(path), *words]) in (0, 1)
    assert main(["check", str(out / "chosen.toml")]) in (0, 1)
    assert (out / "lift.csv").read_text() == (out / "front" / "lift.csv").read_text() == lift
    assert (out / "previous" / "lift.csv").exists() is not alike
    # Another's search takes them away with the profiles that name them.
    other = tmp_path / "other.toml"
    other.write_text(dump({**read_data(disc(tmp_path)), "name": "another"}))
    assert main(["optimise", str(other), *words]) in (0, 1)
    assert (out / "lift.csv").exists() is alike
    assert not (out / "front" / "lift.csv").exists()
    if not alike:
        (place,) = (one for one in (out / "previous").iterdir() if one.is_dir())
        assert main(["check", str(place / "chosen.toml")]) in (0, 1)
        assert (out / "previous" / "lift.csv").read_text() == "mine"


def test_tied_keys_follow_the_free_ones() -> None:
    follower = tie("cam.groove_depth=0.5*roller.diameter+cam.length/60")
    requirement = Requirement(DATA, "", KEYS, (Aim("size", 1.0),), (), (follower,))
    points = requirement.points(np.array([[0.0, 0.5], [1.0, 1.0]]))
    assert points == ((70.0, 12.0, 7.0), (110.0, 16.0, 9.0))
    study = requirement.study(points, partial_exact)
    assert study.variant(points[1])["cam"]["groove_depth"] == 9.0
    with pytest.raises(ProfileError, match="given twice"):
        Requirement(DATA, "", KEYS, (Aim("size", 1.0),), (), (tie("cam.diameter=2*roller.diameter"),))


@pytest.mark.slow
@pytest.mark.usefixtures("_pymoo")
def test_exact_models_search_where_the_batch_cannot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The front of laws: words are no numbers, so exact models search, and it is said."""
    profile = str(disc(tmp_path))
    common = ["--least", "motion.peak_acceleration_mm_per_rad2", "--least", "motion.peak_jerk_mm_per_rad3"]
    words = ["--free", "motion[0].law=cycloidal,modified-sine,3-4-5,4-5-6-7,harmonic", *common]
    command = ["optimise", profile, *words, "--points", "20", "--out", str(tmp_path / "out"), "--jobs", "1"]
    assert main(command) == 0
    told = capsys.readouterr().out
    assert "searched by exact models, fewer points: motion[0].law: is no number" in told
    assert "passing what was judged" in told
    assert (tmp_path / "out/front/01.toml").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--least", "sze"], "--least: is no figure of this cam"),
        (["--least", "size", "--under", "size"], "--under: needs FIGURE=VALUE"),
        (["--least", "size", "--over", "size=x"], "--over: needs FIGURE=VALUE"),
        (["--least", "size", "--points", "many"], "--points: needs a whole number"),
        ([], "--least: a search needs an aim"),
        (["--least", "size", "--most", "size"], "is given twice"),
    ],
)
def test_what_cannot_be_sought(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str
) -> None:
    command = ["optimise", str(disc(tmp_path)), "--free", "cam.base_radius=25:60", *words, "--out", str(tmp_path / "o")]
    assert main(command) == 2
    assert message in capsys.readouterr().err


def test_an_archive_is_asked_for_its_front_with_room() -> None:
    requirement = wanted(Bound("pressure", 1.0, 240.0, "limit"))
    figures = {"size": np.array([1.0, 2.0, 3.0, 4.0]), "pressure": np.array([250.0, 239.9, 230.0, 235.0])}
    archive = Archive(requirement, 4, np.zeros((4, 2)), figures)
    if pytest.importorskip("moocore", reason=f"no moocore: {ABSENT}"):
        assert archive.front().tolist() == [1, 2]
        assert archive.front(0.01).tolist() == [2]
        assert archive.front(0.0, np.array([True, False, True, True])).tolist() == [2]
    assert replace(archive, evaluated=5).evaluated == 5
