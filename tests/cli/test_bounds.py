"""What is read, shown and solved has bounds: files without end, hostile text, closed streams, budgets."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from camgeom.cli import main
from camgeom.errors import Problem, ProfileError, visible
from camgeom.inspection.points import read_points
from camgeom.motion.own import load_laws
from camgeom.profile import parse, read
from camgeom.reading import MAX_LINE, lines_of, read_bytes
from tests.places import PROFILES

HOSTILE = "a\x1b[31mred\x1b[0m\u202egnp.\u202c\u200fb\rc\x07"


@pytest.mark.parametrize("reader", [read, read_points, load_laws])
def test_devices_pipes_and_folders_are_no_input(tmp_path: Path, reader) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for path in (Path("/dev/zero"), pipe, tmp_path):
        with pytest.raises(ProfileError, match=r"is not a regular file|is a folder"):
            reader(path)


def test_a_file_is_read_up_to_its_limit_and_no_further(tmp_path: Path) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(b"x" * 1000)
    assert read_bytes(path, 1000, "points.csv") == b"x" * 1000
    with pytest.raises(ProfileError, match=r"too large \(found 1000\); allowed: at most 999 bytes"):
        read_bytes(path, 999, "points.csv")
    # A file of the kernel says it is empty and has content all the same.
    assert read_bytes(Path("/proc/self/status"), 1_000_000, "status").startswith(b"Name:")


def test_a_line_is_as_long_as_allowed_and_no_longer() -> None:
    assert list(lines_of(b"\xef\xbb\xbfa\r\nb\rc\n" + b"d" * MAX_LINE, "t")) == ["a", "b", "c", "d" * MAX_LINE]
    with pytest.raises(ProfileError, match=f"line 2 is too long; allowed: text of at most {MAX_LINE} characters"):
        list(lines_of(b"a\n" + b"d" * (MAX_LINE + 1), "t"))


def test_a_lift_table_of_one_endless_cell_is_refused_by_line(tmp_path: Path) -> None:
    text = (PROFILES / "disc_offset_roller.toml").read_text()
    laws = 'law = "table"\nfile = "lift.csv"'
    first = text.index('law = "')
    text = text[:first] + laws + text[text.index("\n", first):]
    (tmp_path / "lift.csv").write_text("angle,lift\n" + "1" * 200_000)
    path = tmp_path / "cam.toml"
    path.write_text(text)
    with pytest.raises(ProfileError, match="line 2 is too long"):
        read(path).setup()


def test_what_is_not_seen_is_shown() -> None:
    shown = visible(HOSTILE)
    assert shown == "a\\x1b[31mred\\x1b[0m\\u202egnp.\\u202c\\u200fb\\rc\\x07"
    names = "Nockenwelle \u4e2d\u6587 \u05d0\u05d1 line\n\tnext"
    assert visible(names) == names
    error = ProfileError([Problem("key", "is wrong", HOSTILE)], HOSTILE)
    assert visible(str(error)).isprintable()


def test_hostile_names_reach_no_terminal_and_no_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (PROFILES / "disc_flat_face.toml").read_text()
    path = tmp_path / f"{HOSTILE}.toml"
    path.write_text(text)
    assert main(["report", str(path), "--out", str(tmp_path / "out"), "--only", "motion"]) == 0
    said = capsys.readouterr()
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    for shown in (said.out, said.err, page):
        assert not set(HOSTILE) & set("\x1b\u202e\u200f\x07") & set(shown)
    path.write_text(text + '\n["\\u001b[2J"]\nx = 1\n')
    assert main(["check", str(path)]) == 2
    assert "\x1b" not in capsys.readouterr().err
    with pytest.raises(ProfileError, match="control characters"):
        parse('name = "a\\u200fb"\n' + text.replace("name =", "# name =", 1))


def _camgeom(line: str, **more: object) -> int:
    command = f'exec "{sys.executable}" -m camgeom {line}'
    return subprocess.run(["bash", "-c", command], timeout=120, stdout=subprocess.DEVNULL, **more).returncode


@pytest.mark.parametrize("elsewhere", ["2>&-", "2>/dev/full"])
def test_a_closed_stderr_changes_no_exit_status(elsewhere: str) -> None:
    assert _camgeom(f"check '{PROFILES / 'pin_insertion.toml'}' {elsewhere}") == 0
    assert _camgeom(f"check nowhere.toml {elsewhere}") == 2


def test_a_design_on_stdout_is_a_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["design", "disc", "--pressure-angle", "30"]
    assert main(words) == 0
    said = capsys.readouterr()
    assert parse(said.out).kind == "disc"
    assert "checks pass" in said.err
    assert main([*words[:2], str(tmp_path / "cam.toml"), *words[2:]]) == 0
    assert "checks pass" in capsys.readouterr().out
    assert (tmp_path / "cam.toml").read_text() == said.out
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["profile"] == said.out
