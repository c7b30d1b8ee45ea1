"""`camgeom law`, and the best law's figures on their way from a profile's keys to every place that shows them."""

from __future__ import annotations

import csv
import json
import tomllib
from pathlib import Path

import pytest

from camgeom.cli import Console, main
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.measured import measure
from camgeom.report.result import compute
from camgeom.report.sections.motion import best_laws
from tests.places import PROFILES

MODIFIED = ["--vmax", "1.7596", "--jmax", "69.466", "--band", "2:6"]


def told(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> dict[str, object]:
    assert main(["law", "--json", *words]) == status
    return json.loads(capsys.readouterr().out)


def test_the_json_has_the_promised_names(capsys: pytest.CaptureFixture[str]) -> None:
    data = told(capsys, "--jmax", "60")
    assert data["peak_acceleration"] == pytest.approx(4.753049234, rel=1e-8)
    assert data["lower_bound"] == pytest.approx(data["peak_acceleration"], rel=1e-6)
    assert {"peak_velocity", "peak_jerk", "residual", "bound_holds_for"} <= set(data)
    assert all(len(data[key]) >= 1001 for key in ("x", "lift", "acceleration"))  # type: ignore[arg-type]
    assert (data["lift"][0], data["lift"][-1]) == (0.0, 1.0)  # type: ignore[index]


def test_of_next_to_nothing_the_most_to_gain_is_told_and_no_share(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A residual of a millionth of the lift ends the search; of one that is worth the name a share is told."""
    monkeypatch.setattr("camgeom.cli.law.ALONG", 2)
    little = told(capsys, "--least", "residual", "--jmax", "80", "--band", "4.629:7.414", "--out", str(tmp_path))
    assert 0.0 < little["value"] <= 2e-6  # type: ignore[operator]
    assert little["most_gain"] == little["value"] - little["lower_bound"]  # type: ignore[operator]
    assert f"the law is above it by {little['most_gain']:.2g}" in (tmp_path / "law.html").read_text(encoding="utf-8")
    more = told(capsys, "--least", "residual", "--jmax", "80", "--band", "2.121:3.369", "--out", str(tmp_path / "more"))
    assert more["most_gain"] == pytest.approx(more["gap"] * more["value"], abs=1e-12)  # type: ignore[operator]
    assert "the law is within" in (tmp_path / "more" / "law.html").read_text(encoding="utf-8")


def test_files_of_two_laws_are_no_set_and_what_was_edited_stays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A full disk left the segment of one law beside the table of another; an edited one was written over."""
    from camgeom.cli import model
    from camgeom.errors import ExportError
    from camgeom.export import files

    told(capsys, "--jmax", "60", "--out", str(tmp_path))
    before = {name: (tmp_path / name).read_bytes() for name in ("law.toml", "law.csv", "law.html")}
    write = files.write_whole

    def full(path: Path, content: str | bytes) -> int:
        if path.name == "law.csv":
            raise ExportError(f"{path}: cannot be written: the disk is full")
        return write(path, content)

    with monkeypatch.context() as patched:
        patched.setattr(files, "write_whole", full)
        assert main(["law", "--jmax", "80", "--out", str(tmp_path)]) == 3
    assert f"{tmp_path / 'law.csv'}: cannot be written" in capsys.readouterr().err
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    (tmp_path / "law.toml").write_text("# edited")
    assert main(["law", "--jmax", "80", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().err == f"camgeom: moved to {tmp_path / 'previous'}: law.toml\n"
    assert (tmp_path / "previous" / "law.toml").read_text() == "# edited"
    assert all((tmp_path / name).read_bytes() != content for name, content in before.items())
    manifest = json.loads((tmp_path / "law-manifest.json").read_text())
    assert ({entry["file"] for entry in manifest["files"]}, manifest["state"]) == (set(before), "complete")
    assert model.write_set(tmp_path, "law-manifest.json", "best law", "law", {}, Console()) == []


def test_without_a_jerk_limit_the_acceleration_may_jump(capsys: pytest.CaptureFixture[str]) -> None:
    data = told(capsys)
    assert data["peak_acceleration"] == pytest.approx(4.0, rel=1e-9)
    assert data["peak_jerk"] is None


def test_a_band_alone_is_measured_and_asks_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    free, banded = told(capsys, "--jmax", "60"), told(capsys, "--jmax", "60", "--band", "2:6")
    assert free["residual"] is None
    assert banded["residual"] > 0.0  # type: ignore[operator]
    assert banded["peak_acceleration"] == free["peak_acceleration"]


def test_what_no_law_can_do_ends_with_status_1_and_the_proof(capsys: pytest.CaptureFixture[str]) -> None:
    data = told(capsys, "--jmax", "31", status=1)
    assert data["possible"] is False
    assert data["bound"] > 1.0  # type: ignore[operator]
    assert main(["law", "--jmax", "31"]) == 1
    assert "no law at all keeps jerk 31" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--least", "lift"], "--least"),
        (["--jmax", "0"], "--jmax"),
        (["--vmax", "x"], "--vmax: needs a number"),
        (["--least", "jerk", "--jmax", "40"], "--jmax: says nothing beside"),
        (["--least", "residual", "--band", "2:6"], "--amax or --jmax"),
        (["--damping", "0.1"], "--damping: says nothing without --band"),
        (["--front"], "--front: says nothing without --band"),
        (["--residual", "0.1"], "--band: is missing"),
        (["--jmax", "60", "--order", "1.5"], "--order: needs a whole number"),
    ],
)
def test_wrong_options_are_named(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["law", *words]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.slow
def test_the_files_and_the_front(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("camgeom.cli.law.ALONG", 5)
    data = told(capsys, *MODIFIED, "--residual", "0.0426", "--out", str(tmp_path))
    points = data["front"]
    assert len(points) == 5  # type: ignore[arg-type]
    for point in points:  # type: ignore[attr-defined]
        assert point["lower_bound"] <= point["residual"] * (1.0 + 1e-6)
        for rival in data["catalogue"]:  # type: ignore[attr-defined]
            if rival["keeps_limits"] and rival["acceleration"] <= point["acceleration"]:
                assert rival["residual"] >= point["lower_bound"]
    keys = tomllib.loads((tmp_path / "law.toml").read_text(encoding="utf-8"))
    assert keys == {**data["segment"], "band": [2, 6]}  # type: ignore[dict-item]
    rows = list(csv.reader((tmp_path / "law.csv").read_text(encoding="utf-8").splitlines()))
    assert rows[0] == ["x", "lift", "velocity", "acceleration", "jerk"]
    assert "modified-sine" in (tmp_path / "law.html").read_text(encoding="utf-8")


def plate(keys: str) -> Model:
    """A plate's edge whose rise is the best law of these keys over the travel."""
    text = (PROFILES / "linear_edge.toml").read_text()
    rise = 'law = "optimal"\njerk_limit = 80\n' + ("" if "minimise" in keys else 'minimise = "peak-acceleration"\n')
    return Model(parse(text.replace('law = "modified-sine"', rise + keys), "x.toml"))


@pytest.mark.parametrize("key", ["residual_limit = 0.1", "band = [1, 2]", "natural_frequency = 45",
                                 "speeds = [150, 450]", "damping = 0.1", 'minimise = "residual"'])  # fmt: skip
def test_what_swings_in_time_has_no_place_over_the_travel_of_a_plate(key: str) -> None:
    with pytest.raises(ProfileError, match="travel, which does not go evenly in time") as refused:
        plate(key)
    assert [one.key for one in refused.value.problems] == [f"motion[1].{key.partition(' ')[0]}"]


def test_bounds_over_the_travel_of_a_plate_say_so_and_of_a_cam_that_turns_say_nothing_of_it() -> None:
    over = "unit lift over unit travel of the plate, not of the follower in time"
    slides, turns = plate(""), indexer()
    for model, words in ((slides, over), (turns, "unit lift over unit travel")):
        (told,) = compute(model, ("motion",)).data["motion"]["best_laws"].values()
        table = best_laws(model)
        assert told["over"] == words
        assert table is not None
        assert table.caption == f"Best laws, peaks for {words}"
    assert turns.setup.program.best_laws[0][1].wish.band is not None


def indexer(text: str = "") -> Model:
    source = (PROFILES / "optimal_indexer.toml").read_text(encoding="utf-8")
    return Model(parse(source.replace("residual_limit = 0.04 ", text or "residual_limit = 0.04 ")))


def test_the_figures_reach_study_and_report() -> None:
    model = indexer()
    figures, _, _ = measure(model, ("motion",), ())
    assert figures["motion.best_laws.1.value"] == pytest.approx(5.0441606, rel=1e-6)
    assert figures["motion.best_laws.1.lower_bound"] <= figures["motion.best_laws.1.value"]  # type: ignore[operator]
    table = best_laws(model)
    assert table is not None
    assert table.rows[0][0] == "motion[1]"
    looser = measure(indexer("residual_limit = 0.05 "), ("motion",), ())[0]
    assert looser["motion.best_laws.1.value"] < figures["motion.best_laws.1.value"]  # type: ignore[operator]


def test_an_impossible_wish_of_a_profile_names_the_key() -> None:
    with pytest.raises(ProfileError, match=r"motion\[1\]\.\w+_limit: no law at all keeps"):
        _ = indexer("residual_limit = 0.01 ").setup.program
