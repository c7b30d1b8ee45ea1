"""The command line: what each command prints and writes, exit statuses, and one plain message for every mistake."""

from __future__ import annotations

import errno
import io
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from camgeom.cli import COMMANDS, main
from camgeom.cli.model import USUAL, slug
from camgeom.model import Model
from camgeom.profile import read
from camgeom.track import Arc, Straight
from tests.cli.small import GOOD
from tests.places import PROFILES, ROOT


@pytest.fixture
def profile(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "small.toml"
    file.write_text(GOOD)
    return file


def entries(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def run(capsys: pytest.CaptureFixture[str], *words: object) -> tuple[int, str, str]:
    status = main([str(word) for word in words])
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    return status, captured.out, captured.err


def refused(capsys: pytest.CaptureFixture[str], *words: object) -> str:
    status, out, err = run(capsys, *words)
    assert (status, out) == (2, "")
    assert err.startswith("camgeom: ")
    assert err.count("\n") == 1
    return err


def test_check_writes_nothing(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = run(capsys, "check", profile)
    assert (status, err) == (0, "")
    assert out.startswith("small groove cam (cylindrical): PASS")
    assert "pressure-angle" in out
    assert entries(profile.parent) == ["small.toml"]


def test_check_json_is_json_alone(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = run(capsys, "check", profile, "--json", "--explain", "--only", "pressure-angle")
    assert (status, err) == (0, "")
    result = json.loads(out)
    assert result["kind"] == "cylindrical"
    assert [finding["check"] for finding in result["checks"]] == ["pressure-angle"]
    assert result["explain"]
    assert "solids" not in result["cost_s"]


def test_failing_design_is_status_1(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile.write_text(GOOD + "[limits]\npressure_angle_deg = 5\n")
    status, out, err = run(capsys, "check", profile, "--only", "pressure-angle", "--out", "found")
    assert (status, err) == (1, "")
    assert "FAIL" in out
    assert json.loads((profile.parent / "found/result.json").read_text())["checks"][0]["passed"] is False


def test_build_writes_files_and_then_the_result(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = run(capsys, "build", profile)
    assert (status, err) == (0, "")
    folder = profile.parent / "exports/small-groove-cam"
    assert entries(folder) == ["manifest.json", "result.json", "small-groove-cam.stl"]
    result = json.loads((folder / "result.json").read_text())
    assert result["solid"]["watertight"] is True
    assert [Path(name).name for name in result["files"]] == ["small-groove-cam.stl"]
    assert "wrote exports/small-groove-cam/result.json" in out


def test_undercut_design_still_gives_its_result(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile.write_text(GOOD.replace("diameter = 12", "diameter = 24").replace("until = 180", "until = 55"))
    status, _, err = run(capsys, "run", profile, "--only", "motion,solid,checks", "--out", "o")
    assert (status, err) == (1, "")
    assert "undercut" in json.loads((profile.parent / "o/result.json").read_text())["solid"]["refused"]


@pytest.mark.parametrize("tolerance", ["0", "-1", "5", "1e-9", "nan", "inf", "fine", ""])
def test_tolerance_out_of_range(profile: Path, capsys: pytest.CaptureFixture[str], tolerance: str) -> None:
    err = refused(capsys, "build", profile, f"--tolerance={tolerance}")
    assert "--tolerance: needs a number of mm" in err
    assert "1e-07 to 1 mm" in err
    assert entries(profile.parent) == ["small.toml"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["chek"], "unknown command 'chek'; did you mean 'check'?"),
        ([], "missing: COMMAND"),
        (["check"], "missing: PROFILE"),
        (["laws", "--jsn"], "unrecognized arguments: --jsn"),
        (["check", "none.toml"], "none.toml: file: there is no such file"),
        (["check", "."], "is a folder"),
        (["check", ""], "is a folder"),
        (["check", "small.toml", "--only", "presure-angle"], "did you mean pressure-angle?"),
        (["check", "small.toml", "--only", ","], "--only: needs at least one name"),
        (["run", "small.toml", "--formats", "stll"], "unknown format"),
        (["run", "small.toml", "--out", ""], "--out: needs the name of a folder"),
        (["new", "cylindricl"], "did you mean 'cylindrical'?"),
        (["new", "cylindrical", "small.toml"], "'small.toml' exists already"),
    ],
)
def test_one_plain_message(profile: Path, capsys: pytest.CaptureFixture[str], words: list[str], message: str) -> None:
    assert message in refused(capsys, *words)
    assert entries(profile.parent) == ["small.toml"]


def test_unknown_format_in_the_profile(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile.write_text(GOOD.replace('"stl"', '"stepp"'))
    assert "small.toml: output.formats[0]: unknown format" in refused(capsys, "build", profile)


def test_bad_profile_names_every_problem(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    profile.write_text(GOOD.replace("diameter = 80", "diameter = -80").replace("speed", "sped"))
    status, out, err = run(capsys, "run", profile, "--json")
    assert (status, out) == (2, "")
    assert "cam.diameter" in err
    assert "did you mean 'speed'?" in err
    assert entries(profile.parent) == ["small.toml"]


def test_folder_that_is_a_file(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, err = run(capsys, "check", profile, "--out", profile)
    assert (status, out) == (3, "")
    assert "is a file, not a folder" in err


def test_a_folder_that_is_a_link_to_nothing_is_told_as_that(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    link = profile.parent / "there"
    link.symlink_to("nowhere")
    status, _, err = run(capsys, "run", profile, "--out", link / "below")
    assert status == 3
    assert "there: is a link that leads nowhere" in err
    (profile.parent / "nowhere").mkdir()
    assert run(capsys, "run", profile, "--only", "checks", "--out", link / "below")[0] in (0, 1)


def test_full_disk_leaves_nothing(
    profile: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(_: int) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("camgeom.export.files.os.fsync", full)
    status, out, err = run(capsys, "check", profile, "--out", "o", "--only", "continuity")
    assert (status, out) == (3, "")
    assert err == "camgeom: o/result.json: cannot be written: the disk is full\n"
    assert entries(profile.parent) == ["small.toml"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_read_only_folder(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (profile.parent / "shut").mkdir(mode=0o500)
    status, _, err = run(capsys, "check", profile, "--out", "shut/deeper")
    assert status == 3
    assert "no permission" in err


def test_laws(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "laws")
    lines = out.splitlines()
    assert status == 0
    assert lines[0].split()[:4] == ["law", "Vm", "Am", "Jm"]
    assert any(line.startswith("modified-sine ") and " 1.75960 " in line for line in lines)
    status, out, _ = run(capsys, "laws", "--json")
    laws = {law["name"]: law for law in json.loads(out)}
    assert laws["cycloidal"]["vm"] == 2.0
    assert laws["constant-velocity"]["am"] is None


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("pin-insertion groove cam", "pin-insertion-groove-cam"),
        ("../../etc/passwd", "etc-passwd"),
        ("...", "cam"),
        ("Nocken für Öfen", "nocken-fur-ofen"),
        ("凸轮", "cam-f08dc3f7"),
        ("弧面凸轮", "cam-e9d9a844"),
        ("CON", "con-cam"),
        ("x" * 80, "x" * 80),
        ("x" * 500, "x" * 71 + "-c38c2bf3"),
    ],
)
def test_slug(name: str, expected: str) -> None:
    assert slug(name) == expected


def test_help_names_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "--help")
    assert status == 0
    for command in COMMANDS:
        assert command.name in out.split()
        assert run(capsys, command.name, "--help")[0] == 0


def test_bug_is_one_line(profile: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise ZeroDivisionError("a\nb")

    monkeypatch.setattr("camgeom.report.delivery.compute", broken)
    status, out, err = run(capsys, "check", profile)
    assert (status, out) == (3, "")
    assert err.startswith("camgeom: ZeroDivisionError: a b; this is a bug")
    monkeypatch.setenv("CAMGEOM_DEBUG", "1")
    with pytest.raises(ZeroDivisionError):
        main(["check", str(profile)])


def test_interrupt_is_status_130(
    profile: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("camgeom.report.delivery.compute", interrupted)
        assert run(capsys, "check", profile) == (130, "", "camgeom: interrupted\n")
    # Before anything is begun, too.
    monkeypatch.setattr(type(os.environ), "setdefault", interrupted)
    assert run(capsys, "check", profile) == (130, "", "camgeom: interrupted\n")


def process(*words: str, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "camgeom", *words]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.run(command, capture_output=True, text=True, env=environment, check=False, **options)  # type: ignore[call-overload,no-any-return]


def test_process_exit_status(profile: Path) -> None:
    found = process("chek")
    assert (found.returncode, found.stdout) == (2, "")
    assert "did you mean 'check'?" in found.stderr


@pytest.mark.parametrize(
    ("redirection", "status", "err"),
    [("| head -c 10; exit ${PIPESTATUS[0]}", 0, ""), ("> /dev/full", 3, "camgeom: No space left on device\n")],
)
def test_stdout_that_ends_early(redirection: str, status: int, err: str) -> None:
    tree = str(ROOT)
    shell = ["bash", "-c", f"{sys.executable} -m camgeom laws --json {redirection}"]
    found = subprocess.run(shell, capture_output=True, text=True, cwd=tree, check=False)
    assert (found.returncode, found.stderr) == (status, err)


def test_name_that_the_terminal_cannot_show(profile: Path) -> None:
    profile.write_text(GOOD.replace("small groove cam", "Öfen 凸轮"), encoding="utf-8")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONIOENCODING": "ascii"}
    command = [sys.executable, "-m", "camgeom", "check", str(profile), "--only", "continuity"]
    found = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert (found.returncode, found.stderr) == (0, "")
    assert found.stdout.startswith("\\xd6fen")
    found = subprocess.run([*command, "--json"], capture_output=True, text=True, env=environment, check=False)
    assert json.loads(found.stdout)["name"] == "Öfen 凸轮"


@pytest.mark.slow
def test_run_writes_everything(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, _, err = run(capsys, "run", profile, "--formats", "STL,.ply")
    assert (status, err) == (0, "")
    folder = profile.parent / "exports/small-groove-cam"
    wanted = ["report.html", "result.json", "small-groove-cam.ply", "small-groove-cam.stl"]
    assert entries(folder) == ["manifest.json", *wanted]
    result = json.loads((folder / "result.json").read_text())
    assert {Path(name).name for name in result["files"]} == set(wanted) - {"result.json"}
    assert {"motion", "flank", "checks", "solid", "contact", "fatigue", "cost_s"} <= set(result)


def test_a_format_that_cannot_be_written_does_not_stop_the_others(
    profile: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, err = run(capsys, "build", profile, "--formats", "gcode,outline.csv,ply", "--out", profile.parent / "o")
    assert status == 1
    assert "needs a [cutter] table" in err
    assert "only planar cams have outlines" in err
    assert entries(profile.parent / "o") == ["manifest.json", "result.json", "small-groove-cam.ply"]


@pytest.mark.parametrize("command", ["check", "solve", "report", "build", "run"])
def test_formats_of_a_profile_are_read_by_every_command(
    profile: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    profile.write_text(GOOD.replace('"stl"', '"iges"'))
    assert "small.toml: output.formats[0]: unknown format" in refused(capsys, command, profile)


def test_formats_known_without_their_writers_have_one() -> None:
    from camgeom.report.files import EXTRAS, formats

    assert {name.lstrip(".") for name in formats()} | set(EXTRAS) >= USUAL


def test_formats_mean_nothing_to_a_command_that_writes_none(profile: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "nothing is written here; build and run write" in refused(capsys, "check", profile, "--formats", "stl")
    only = refused(capsys, "run", profile, "--only", "checks", "--formats", "stl")
    assert "nothing is written here; --only leaves out exports" in only
    profile.write_text(GOOD.replace('"stl"', '"assembly.step"'))
    assert run(capsys, "check", profile, "--only", "continuity")[0] == 0


@pytest.mark.parametrize(
    ("tolerance", "status", "word"),
    [("3.4e-5", 0, ""), ("3.2e-5", 0, "beside"), ("3.4e-6", 0, "beside"), ("3.2e-6", 1, "more than")],
)
def test_an_stl_says_what_its_coordinates_cost(
    profile: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tolerance: str,
    status: int,
    word: str,
) -> None:
    """Coordinates of 32 to 64 mm are rounded by 1.9e-6 mm in each direction, vertices by 3.30e-6 mm."""
    monkeypatch.setattr("camgeom.model.body.Body.solids", Model(read(str(profile))).solids)
    found, _, err = run(capsys, "build", profile, "--formats", "stl", "--tolerance", tolerance, "--only", "exports")
    assert (found, bool(err)) == (status, bool(word))
    assert word in err
    assert ("3mf, ply" in err) == bool(word)


@pytest.mark.parametrize(
    ("name", "flank", "crown"),
    [
        ("disc_offset_roller", "", "straight"),
        ("feeder_runout", "", "straight"),
        ("feeder_runout", "conforming", "conforming"),
    ],
)
def test_how_a_flank_meets_a_crowned_roller_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, name: str, flank: str, crown: str
) -> None:
    """What is said is what is built: the meridian that the flank is surveyed with is an arc, or a line."""
    text = (ROOT / "profiles" / f"{name}.toml").read_text()
    profile = tmp_path / f"{name}.toml"
    profile.write_text(text.replace("[roller]", f'[roller]\nflank = "{flank}"') if flank else text)
    model = Model(read(str(profile)))
    assert isinstance(model.flanks[0].cutter.meridian, Arc if crown == "conforming" else Straight)
    assert f"flank under the crowned roller: {crown}" in run(capsys, "check", profile)[1]
    data = json.loads(run(capsys, "check", profile, "--json")[1])
    assert data["flank"]["crown"] == crown
    plain = json.loads(run(capsys, "check", ROOT / "profiles" / "disc_flat_face.toml", "--json")[1])
    assert "crown" not in plain["flank"]


def test_a_profile_may_come_from_standard_input(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    content = (PROFILES / "disc_offset_roller.toml").read_bytes()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))
    status, out, _ = run(capsys, "check", "-")
    assert (status, "disc cam with offset roller" in out) == (0, True)
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"x" * 2_000_000)))
    assert run(capsys, "check", "-")[0] == 2
    assert run(capsys, "serve", "-")[0] == 2


def test_rollers_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = run(capsys, "rollers", "--json")
    rows = json.loads(out)
    assert status == 0
    assert next(row for row in rows if row["designation"] == "CF 10 WBUUR/SG")["dynamic_rating"] == 5430.0
    status, out, _ = run(capsys, "rollers")
    assert status == 0
    assert "CF 10 WBUUR/SG" in out
    assert "source: IKO" in out
