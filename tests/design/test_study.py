"""Studies: axes, variants, rows that fail with their reason, worker processes, and the command."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from camgeom.cli import main
from camgeom.design import study as study_module
from camgeom.design.engine import Alone, Local
from camgeom.design.study import Axis, Figures, Row, Study, axis, replaced
from camgeom.drawing.content import Chart, Table
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import read_data
from tests.design.runs import DATA, TEXT, light
from tests.places import PROFILES
from tests.reference.rising_disc import rising_disc


def made(*texts: str) -> Study:
    return Study(DATA, "", tuple(axis(text) for text in texts), light)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("cam.diameter=1:2:3", (1.0, 1.5, 2.0)),
        ("follower.stops=4:8:5", (4, 5, 6, 7, 8)),
        ("a=0:1:1e0", None),
        ("a=5:5:1", (5,)),
        ("a=0.1:0.3:3", (0.1, 0.2, 0.3)),
        ("motion[1].law=cycloidal, 3-4-5", ("cycloidal", "3-4-5")),
        ("a= 1,2.5,-3e2", (1, 2.5, -300.0)),
    ],
)
def test_axis_values(text: str, values: tuple[object, ...] | None) -> None:
    if values is None:
        with pytest.raises(ProfileError):
            axis(text)
    else:
        found = axis(text).values
        assert found == pytest.approx(values) if all(isinstance(v, float) for v in values) else found == values
        assert [type(v) for v in found] == [type(v) for v in values]


WRONG = """
= | a | a= | =1 | a=1:2 | a=1:2:3:4 | a=1:2:0 | a=1:2:-3 | a=x:2:3 | a=1:nan:3 | a=1:inf:3 | a=1:2:1 | a=1,,2 | a=nan
| a b=1 | a[x]=1 | a[-1]=1 | a..b=1 | a=1:2:100001 | a=1:2:3.5 | a[1]b=2
"""


@pytest.mark.parametrize("text", ["", *(word.strip() for word in WRONG.split("|"))])
def test_wrong_axes(text: str) -> None:
    with pytest.raises(ProfileError, match="--vary"):
        axis(text)


def test_ends_of_a_span_are_exact() -> None:
    values = axis("a=0.1:0.7:7").values
    assert (values[0], values[-1]) == (0.1, 0.7)


def test_replacing_leaves_the_rest_alone() -> None:
    data = {"a": {"b": ({"c": 1}, {"c": 2})}, "d": 3}
    assert replaced(data, ("a", "b", 1, "c"), 9, "k") == {"a": {"b": ({"c": 1}, {"c": 9})}, "d": 3}
    assert replaced(data, ("e", "f"), 1, "k")["e"] == {"f": 1}
    assert data["a"]["b"][1]["c"] == 2  # type: ignore[index]


def test_grid_runs_the_last_axis_fastest() -> None:
    rows = list(made("cam.diameter=80,100", "roller.diameter=10,12,14").rows(Alone()))
    assert [row.values for row in rows] == [(80, 10), (80, 12), (80, 14), (100, 10), (100, 12), (100, 14)]
    assert [row.figures["radius"] for row in rows] == [40.0] * 3 + [50.0] * 3


def test_failing_variants_are_rows_with_their_reason() -> None:
    rows = list(made("cam.diameter=80,90,91,-1,10").rows(Alone()))
    assert [row.verdict for row in rows] == ["pass", "fail", "no result", "bad input", "bad input"]
    assert rows[1].reason == "ninety"
    assert "cam.diameter: out of range" in rows[3].reason
    assert "cam.groove_depth" in rows[4].reason


@pytest.mark.parametrize(
    ("texts", "message"),
    [
        (["cam.diamter=1,2"], "--vary cam.diamter: unknown key; did you mean 'diameter'"),
        (["motion[7].to=1,2"], "no such entry"),
        (["motion.to=1,2"], "write motion\\[0\\]"),
        (["cam.diameter.x=1,2"], "no table that could hold 'x'"),
        (["cam.diameter=1:2:400", "roller.diameter=1:2:400"], "too many variants"),
        (["cam.diameter=1,2", "cam.diameter=1,2"], "varied twice"),
    ],
)
def test_studies_that_cannot_be(texts: list[str], message: str) -> None:
    with pytest.raises(ProfileError, match=message):
        made(*texts)


def test_geometry_is_shared_where_only_the_load_varies() -> None:
    study = made("operation.speed=100,200")
    row, first = study.row((100,))
    assert row.verdict == "pass"
    assert first is not None
    _, second = study.row((200,), first)
    assert second is not None
    assert second.tracks is first.tracks
    _, other = made("cam.diameter=80,100").row((100,), first)
    assert other is not None
    assert other.tracks is not first.tracks


@pytest.mark.slow
@pytest.mark.parametrize(
    ("profile", "key", "values"),
    [
        ("milled_drum.toml", "cutter.corner_radius", (0.0, 1.0)),
        ("end_face_lifter.toml", "output.fewest_triangles", (False, True)),
    ],
)
def test_a_body_is_not_shared_where_something_else_shapes_it(profile: str, key: str, values: tuple[float, ...]) -> None:
    """The corner of the tool rounds a root: the row had the body of the variant before it, as `solid` told."""
    data = read_data(PROFILES / profile)
    data["output"] = {**data["output"], "tolerance": 0.1}
    study = Study(data, "", (Axis(key, tuple(key.split(".")), values),), lambda m: (measured(m), "pass", ""))
    rows, _ = study.computed(study.values(range(2)))
    alone, _ = study.row((values[1],))
    assert rows[1].figures == alone.figures
    assert rows[1].figures != rows[0].figures


def measured(model: Model) -> Figures:
    return {"volume": model.mass[0].volume, "triangles": len(model.solid.mesh.faces)}


def test_worker_processes_give_the_same_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    study = made("cam.diameter=60:100:41")
    alone = list(study.rows(Alone()))
    monkeypatch.setattr(study_module, "ALONE_FOR", -1.0)
    assert list(study.rows(Local(2))) == alone


def test_page_draws_a_line_for_each_setting() -> None:
    from camgeom.cli.study_page import page

    study = made("operation.speed=100:300:3", "motion[1].law=cycloidal,3-4-5")
    rows = [
        Row(values, {"contact.peak_pressure_mpa": 10.0 * i} if i != 2 else {}, "pass")
        for i, values in enumerate((speed, law) for speed in (100, 200, 300) for law in ("cycloidal", "3-4-5"))
    ]
    chart, table = page(study, rows, "x").sections[0].blocks
    assert isinstance(chart, Chart)
    assert isinstance(table, Table)
    lines = {series.name: series.x.tolist() for series in chart.panels[0].series if not series.dots}
    assert lines == {"motion[1].law cycloidal": [100.0, 300.0], "motion[1].law 3-4-5": [100.0, 200.0, 300.0]}
    assert len(table.rows) == 6


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(TEXT)
    words = ["study", "small.toml", "--vary", "cam.diameter=80,-1", "--only", "motion,continuity", "--json"]
    assert main(words) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    result = json.loads(captured.out)
    assert [row["verdict"] for row in result["rows"]] == ["pass", "bad input"]
    with Path("exports/small-groove-cam/study.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["cam.diameter"] for row in rows] == ["80", "-1"]
    assert float(rows[0]["motion.stroke_mm"]) == 15.0
    assert rows[1]["motion.stroke_mm"] == ""
    page = Path("exports/small-groove-cam/study.html").read_text()
    assert "cam.diameter" in page
    assert [Path(file).name for file in result["files"]] == ["study.csv", "study.html"]
    assert main(words[:-1]) == 0
    assert "2 variants: 1 pass of what was judged, 1 bad input" in capsys.readouterr().out
    assert main(["study", "small.toml", "--vary", "cam.diamter=1,2"]) == 2
    assert "did you mean 'diameter'?" in capsys.readouterr().err
    assert main(["study", "small.toml", "--vary", "cam.diameter=1,2", "--jobs", "none"]) == 2


def test_values_in_equal_ratios() -> None:
    found = axis("impact.clearance=0.001:1:4:log").values
    assert found == pytest.approx((0.001, 0.01, 0.1, 1.0), rel=1e-12)
    with pytest.raises(ProfileError, match="above 0"):
        axis("impact.clearance=0:1:4:log")
    with pytest.raises(ProfileError, match="needs KEY"):
        axis("impact.clearance=0.1:1:4:lin")


def test_a_study_of_clearances_from_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The impacts come with the study where their table is in the profile and one of its keys is varied."""
    rocker = PROFILES / "conjugate_rocker.toml"
    profile = tmp_path / "rocker.toml"
    profile.write_text(rocker.read_text().replace("turns = 3", "turns = 2\ntolerance = 1e-6"))
    vary = ["--vary", "impact.clearance=0.01:0.1:2:log", "--jobs", "1"]
    command = ["study", str(profile), *vary, "--out", str(tmp_path)]
    assert main([*command, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["rows"]
    peaks = [row["dynamics.impact.over_turns.peak_acceleration_rad_s2.mean"] for row in rows]
    assert peaks == pytest.approx([6444.0, 15409.0], rel=0.02)
    assert main([*command, "--json", "--only", "motion"]) == 0
    assert not any(key.startswith("dynamics") for key in json.loads(capsys.readouterr().out)["rows"][0])


def test_a_study_says_what_it_did_not_judge_and_fails_where_nothing_passes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    disc = str(PROFILES / "disc_flat_face.toml")
    common = ["--out", str(tmp_path), "--jobs", "1"]
    assert main(["study", disc, "--vary", "cam.width=10,12", *common]) == 0
    told = capsys.readouterr().out
    assert "2 pass of what was judged" in told
    assert "not judged here: " in told
    assert "interference" in told.partition("not judged here")[2]
    with (tmp_path / "study.csv").open(newline="") as stream:
        assert all("watertight" in row["not_judged"].split() for row in csv.DictReader(stream))
    assert "Not judged in this study" in (tmp_path / "study.html").read_text()
    failing = ["study", disc, "--vary", "limits.contact_pressure_mpa=1,2", *common]
    assert main(failing) == 1
    assert "2 variants: 2 fail" in capsys.readouterr().out
    assert main([*failing, "--json"]) == 1


TOLERANT = """
[tolerance]
center_distance = 0.03
motion_limit = 1000
dwell_limit = 26
samples = 4000
"""


def test_the_yield_under_tolerances_is_a_column_and_judges_its_row(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A slide follows its own error: 25.8 um of three deviations of 10 um hold 99 % of the machines."""
    profile = tmp_path / "disc.toml"
    profile.write_text(rising_disc() + TOLERANT)
    vary = ["study", str(profile), "--vary", "tolerance.dwell_limit=24.5,27", "--out", str(tmp_path / "out"), "--json"]
    columns = []
    for more in ([], ["--figures", "tolerance.yield,tolerance.dwell_um"], ["--only", "tolerance"]):
        assert main([*vary, "--jobs", "1", *more]) == 0
        said = capsys.readouterr()
        tight, wide = json.loads(said.out)["rows"]
        assert "no variant has the figure" not in said.err
        columns.append((tight["tolerance.yield"], wide["tolerance.yield"], wide["tolerance.dwell_um"]))
        assert tight["tolerance.yield"] < 0.99 <= wide["tolerance.yield"]
        assert (tight["verdict"], tight["reason"]) == ("fail", "dwell-tolerance; yield-tolerance")
        assert wide["verdict"] == "pass"
    assert columns[0] == columns[1] == columns[2]
    assert "undercut" in wide["not_judged"].split(), "not asked for, and not passed"


def test_a_figure_that_is_named_brings_its_product(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile = tmp_path / "disc.toml"
    profile.write_text(rising_disc())
    command = ["study", str(profile), "--vary", "cam.width=13,14", "--out", str(tmp_path / "out"), "--jobs", "1"]
    assert main([*command, "--figures", "solid.mass_kg", "--json"]) == 0
    thin, thick = json.loads(capsys.readouterr().out)["rows"]
    assert thin["solid.mass_kg"] / thick["solid.mass_kg"] == pytest.approx(13.0 / 14.0, rel=1e-6)


def test_the_words_of_a_switch_are_true_and_false(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    vary = ["--vary", "cam.run_out=false,true,no", "--only", "motion", "--out", str(tmp_path), "--jobs", "1", "--json"]
    assert main(["study", str(PROFILES / "feeder_runout.toml"), *vary]) == 0
    off, on, word = json.loads(capsys.readouterr().out)["rows"]
    assert [off["verdict"], on["verdict"], word["verdict"]] == ["pass", "pass", "bad input"]
    assert [off["cam.run_out"], on["cam.run_out"]] == ["false", "true"]
    assert "needs true or false (found 'no')" in word["reason"]
    data = {"cam": {"run_out": False, "note": "off"}, "motion": ({},)}
    assert replaced(data, ("cam", "run_out"), "true", "cam.run_out")["cam"]["run_out"] is True
    assert replaced(data, ("cam", "note"), "true", "cam.note")["cam"]["note"] == "true"
    assert replaced(data, ("motion", 0, "monotone"), "false", "motion[0].monotone")["motion"] == ({"monotone": False},)


@pytest.mark.parametrize("batch", [[], ["--batch"]], ids=["exact", "batch"])
def test_files_of_another_profiles_study_move_away_and_those_of_the_same_are_replaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], batch: list[str]
) -> None:
    out = tmp_path / "out"
    for name in ("one", "one", "two"):
        profile = tmp_path / f"{name}.toml"
        profile.write_text(rising_disc())
        command = ["study", str(profile), "--vary", "cam.width=13,14", "--out", str(out), "--jobs", "1", *batch]
        assert main([*command, "--figures", "blank.volume_mm3"]) in (0, 1)
        there = {str(path.relative_to(out)) for path in out.rglob("*") if path.is_file() and path.suffix != ".json"}
        mine = {"study.csv", "study.html"}
        assert there == (mine if name == "one" else mine | {f"previous/one/{file}" for file in mine})
    assert (out / "previous/one/study.csv").read_text() == (out / "study.csv").read_text()
    assert "one" in (out / "previous/one/study.html").read_text()
    capsys.readouterr()


def test_a_figure_that_no_variant_has_is_refused_before_the_others_are_computed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    profile = tmp_path / "disc.toml"
    profile.write_text(rising_disc())
    out = tmp_path / "out"
    end = ["--out", str(out), "--jobs", "1", "--json", "--figures"]
    command = ["study", str(profile), "--vary", "cam.width=13,14,15", *end]
    assert main([*command, "blank.volume_mm3,flank.max_presure_angle_deg"]) == 2
    said = capsys.readouterr().err
    assert "--figures: no variant has the figure (found 'flank.max_presure_angle_deg')" in said
    assert "did you mean 'flank.max_pressure_angle_deg'?" in said
    assert not (out / "study.csv").exists()
    # One that the last variant alone has is a column.
    command = ["study", str(PROFILES / "end_face_lifter.toml"), "--vary", "roller.misalignment_deg=0,0.02", *end]
    assert main([*command, "contact.inside_pressure_mpa"]) in (0, 1)
    square, leaning = json.loads(capsys.readouterr().out)["rows"]
    assert square["contact.inside_pressure_mpa"] is None
    assert leaning["contact.inside_pressure_mpa"] > 100.0
