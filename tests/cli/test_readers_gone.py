"""What surrounds a command: readers that leave, letters that the output lacks, names that are no text, little room."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from camgeom.cams import starter
from camgeom.cli import main
from camgeom.profile import read_data
from tests.places import PROFILES

LIGHT = PROFILES / "disc_offset_roller.toml"


def started(words: list[str], place: Path, **given: object) -> subprocess.CompletedProcess[bytes]:
    environment = {**os.environ, **{key: str(value) for key, value in given.items()}}
    return subprocess.run([sys.executable, "-m", "camgeom", *words], cwd=place, env=environment, capture_output=True)


def failing(place: Path) -> Path:
    path = place / "failing.toml"
    path.write_text(re.sub(r"pressure_angle_deg = .*", "pressure_angle_deg = 5.0", LIGHT.read_text()))
    return path


@pytest.mark.parametrize("words", [["check"], ["check", "--json"], ["run", "--out", "o"]])
def test_a_reader_that_has_gone_changes_no_exit_status(tmp_path: Path, words: list[str]) -> None:
    """A failing design passed in a pipe."""
    profile = failing(tmp_path)
    command = [sys.executable, "-m", "camgeom", words[0], str(profile), *words[1:]]
    read, write = os.pipe()
    os.close(read)
    ended = subprocess.run(command, cwd=tmp_path, stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert (ended.returncode, ended.stderr) == (1, b"")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "utf-8"])
def test_a_designed_profile_is_one_whatever_the_output_is_written_in(tmp_path: Path, encoding: str) -> None:
    words = ["design", "globoidal", "--stops", "8", "--motion-angle", "120", "--center-distance", "160"]
    made = started([*words, "--name", "Kurventräger 凸轮"], tmp_path, PYTHONIOENCODING=encoding)
    assert made.returncode == 0, made.stderr
    path = tmp_path / "made.toml"
    path.write_bytes(made.stdout)
    assert read_data(path)["name"] == "Kurventräger 凸轮"
    # A text in single quotes has no escapes.
    path.write_text(re.sub("^name = .*", "name = 'Größe 凸轮'", starter("disc"), flags=re.MULTILINE), encoding="utf-8")
    made = started(["design", "disc", "--profile", str(path)], tmp_path, PYTHONIOENCODING=encoding)
    assert made.returncode == 0, made.stderr
    path.write_bytes(made.stdout)
    assert read_data(path)["name"] == "Größe 凸轮"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such names")
def test_a_name_that_is_no_text_loses_nothing(tmp_path: Path) -> None:
    """A folder and a profile whose names are bytes of another encoding ended a run as a bug, without its result."""
    profile = tmp_path / os.fsdecode(b"cam_\xfc.toml")
    text = LIGHT.read_text()
    profile.write_text(text)
    folder = tmp_path / os.fsdecode(b"out_\xfc")
    assert main(["run", str(profile), "--formats", "stl,sheet.svg", "--out", str(folder)]) in (0, 1)
    result = json.loads((folder / "result.json").read_text())
    assert not [name for name, one in result["products"].items() if one["status"] in ("refused", "failed")]
    assert os.fsencode(result["files"][0]).startswith(os.fsencode(folder))
    assert "\\udcfc.toml" in (folder / "report.html").read_text()


@pytest.mark.skipif(sys.platform != "linux", reason="limits of the address space")
@pytest.mark.parametrize("limit", ["AS", "DATA"])
@pytest.mark.parametrize(("room", "status"), [(145, 3), (300, 3), (700, 0)])
def test_too_little_room_is_said_before_the_libraries_try_for_ever(
    tmp_path: Path, room: int, status: int, limit: str
) -> None:
    """The linear algebra waited without end, deaf to signals, or ended the process with the status of a failing cam."""
    import resource

    def limited() -> None:
        resource.setrlimit(getattr(resource, f"RLIMIT_{limit}"), (room * 10**6, room * 10**6))

    ended = subprocess.run([sys.executable, "-m", "camgeom", "check", str(LIGHT)], cwd=tmp_path, preexec_fn=limited,
                           capture_output=True, check=False, timeout=120)  # fmt: skip
    assert ended.returncode == status, ended.stderr
    assert (f"of {room} MB (ulimit -" in ended.stderr.decode()) == bool(status)


def test_a_folder_in_the_place_of_the_result_is_told_before_anything_is_computed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "o/result.json").mkdir(parents=True)
    monkeypatch.setattr("camgeom.report.delivery.compute", lambda *_: pytest.fail("computed"))
    assert main(["run", str(LIGHT), "--out", str(tmp_path / "o")]) == 3
    assert "result.json: cannot be written: it is a folder" in capsys.readouterr().err


def test_a_check_beside_a_run_leaves_the_files_of_the_same_design(tmp_path: Path) -> None:
    """How bodies are meshed is decided by a command that makes none, and counted as another design."""
    profile = tmp_path / "p.toml"
    profile.write_text((PROFILES / "pin_insertion.toml").read_text())
    assert main(["build", str(profile), "--formats", "stl", "--tolerance", "0.05", "--out", str(tmp_path / "o")]) == 0
    before = {path.name for path in (tmp_path / "o").iterdir()}
    assert main(["check", str(profile), "--tolerance", "0.05", "--out", str(tmp_path / "o")]) == 0
    assert {path.name for path in (tmp_path / "o").iterdir()} == before
    text = profile.read_text()
    profile.write_text(text.replace("[output]", "[output]\nfewest_triangles = false", 1))
    assert main(["check", str(profile), "--tolerance", "0.05", "--out", str(tmp_path / "o")]) == 0
    assert (tmp_path / "o/previous").is_dir()  # said in the profile it is another one
