"""Rows as Parquet parts: killed, cut short, out of disk, they end as the same file as a run in one go."""

from __future__ import annotations

import errno
import json
import os
from pathlib import Path

import numpy as np
import pytest

from camgeom.cli import main
from camgeom.design.parts import GROUP, Parts, read_rows
from camgeom.errors import CamgeomError, ExportError, ProfileError
from tests.design.runs import ABSENT, TEXT, VARIED, begun, done, wait_for_parts

pytest.importorskip("pyarrow", reason=f"no pyarrow: {ABSENT}")

STUDY = ["study", "small.toml", *VARIED, "--parquet", "--out", "out", "--jobs", "1"]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The file of a run in one go by one process."""
    folder = tmp_path_factory.mktemp("whole")
    done(folder, "--out", "out", "--jobs", "1")
    return (folder / "out/study.parquet").read_bytes()


def test_rows_of_the_file(whole: bytes, tmp_path: Path) -> None:
    (tmp_path / "study.parquet").write_bytes(whole)
    rows = read_rows(tmp_path / "study.parquet")
    assert len(rows) == 123
    assert [row["cam.diameter"] for row in rows[::3]] == list(range(70, 111))
    assert [row["verdict"] for row in rows[:3]] == ["pass", "pass", "bad input"]
    assert all(row["motion.stroke_mm"] == (None if row["verdict"] == "bad input" else 15.0) for row in rows)
    assert list(rows[0])[-2:] == ["verdict", "reason"]
    assert read_rows(tmp_path / "study.parquet", ["verdict", "none such"])[0] == {"verdict": "pass"}


@pytest.mark.slow
@pytest.mark.parametrize("jobs", ["1", "2"])
def test_a_killed_run_goes_on_where_it_stopped(whole: bytes, tmp_path: Path, jobs: str) -> None:
    common = ["--out", "out", "--jobs", jobs]
    for kills in range(3):
        running = begun(tmp_path, *common)
        wait_for_parts(tmp_path / "out", 2 * (kills + 1), running)
        running.kill()
        running.communicate()
    assert not (tmp_path / "out/study.parquet").exists()
    assert "of 123 variants were computed before" in done(tmp_path, *common)
    assert (tmp_path / "out/study.parquet").read_bytes() == whole
    assert not (tmp_path / "out/study.parts").exists()
    assert "123 of 123 variants were computed before" in done(tmp_path, *common)
    assert (tmp_path / "out/study.parquet").read_bytes() == whole


@pytest.mark.parametrize("at", [0, 1, 3, -1])
def test_a_full_disk_costs_no_row(
    whole: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], at: int
) -> None:
    """Full at the manifest, at a part, or at the whole file; the same command goes on when there is room again."""
    from camgeom.design import engine, study

    monkeypatch.setattr(engine, "PIECE_S", 0.1)
    monkeypatch.setattr(study, "ALONE_FOR", 0.05)
    (tmp_path / "small.toml").write_text(TEXT)
    monkeypatch.chdir(tmp_path)
    count, real = [0], os.fsync

    def full(stream: int) -> None:
        last = at < 0 and Path(f"/proc/self/fd/{stream}").resolve().name.startswith(".study.parquet")
        if last or count[0] == at:
            raise OSError(errno.ENOSPC, "No space left on device")
        count[0] += 1
        real(stream)

    with monkeypatch.context() as patched:
        patched.setattr(os, "fsync", full)
        assert main(STUDY) == 3
    assert "the disk is full" in capsys.readouterr().err
    assert not Path("out/study.parquet").exists()
    assert main(STUDY) == 0
    assert Path("out/study.parquet").read_bytes() == whole


def test_parts_of_another_run_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "study.parquet"
    Parts(path, {"profile": {"a": 1}, "varied": {"k": [1, 2]}}, 2)
    Parts(path, {"profile": {"a": 1}, "varied": {"k": [1, 2]}}, 2)
    with pytest.raises(ProfileError, match="another run, which differs in: profile"):
        Parts(path, {"profile": {"a": 2}, "varied": {"k": [1, 2]}}, 2)
    with pytest.raises(ProfileError, match="differs in: rows, varied"):
        Parts(path, {"profile": {"a": 1}, "varied": {"k": [1, 2, 3]}}, 3)
    (tmp_path / "study.parts/run.json").write_text("not ours")
    with pytest.raises(CamgeomError, match="is not of this program"):
        Parts(path, {}, 2)


def test_gaps_and_rows_written_twice(tmp_path: Path) -> None:
    parts = Parts(tmp_path / "a.parquet", {}, 10)
    numbers = list(range(10))
    for piece in (range(2, 5), range(4, 7), range(4, 6), range(9, 10)):
        parts.write(piece, {"n": numbers[piece.start : piece.stop]})
    assert parts.gaps == [range(2), range(7, 9)]
    with pytest.raises(CamgeomError, match="rows are missing"):
        parts.join()
    for piece in parts.gaps:
        parts.write(piece, {"n": numbers[piece.start : piece.stop]})
    assert [row["n"] for row in read_rows(parts.join())] == numbers
    assert parts.gaps == []
    assert not parts.folder.exists()


def test_a_part_that_is_short_of_rows_is_told(tmp_path: Path) -> None:
    parts = Parts(tmp_path / "a.parquet", {}, 3)
    parts.write(range(3), {"n": [1, 2]})
    with pytest.raises(CamgeomError, match="holds 2 rows and not 3"):
        parts.join()


@pytest.mark.parametrize("cut", [[range(6)], [range(1), range(1, 2), range(2, 6)], [range(4), range(4, 6)]])
def test_types_do_not_depend_on_the_parts(tmp_path: Path, cut: list[range]) -> None:
    columns: dict[str, list[object]] = {
        "whole": [1, 2, None, 4, 5, 6],
        "mixed": [1, None, 2.5, 4, 5, 6],
        "truth": [None, None, True, False, True, None],
        "large": [1, 2, 3, 2**70, 5, 6],
        "empty": [None] * 6,
        "late": [None, None, None, None, "word", None],
        "verdict": ["pass"] * 6,
    }
    parts = Parts(tmp_path / "a.parquet", {}, 6)
    for piece in cut:
        given = {name: values[piece.start : piece.stop] for name, values in columns.items()}
        parts.write(piece, {name: v for name, v in given.items() if name == "verdict" or set(v) != {None}})
    rows = read_rows(parts.join())
    names = [name for name in columns if name != "empty"]
    assert set(rows[0]) == set(names)
    assert list(rows[0])[-1] == "verdict"
    for name in names:
        assert [row[name] for row in rows] == columns[name]
    assert all(isinstance(row["mixed"], float | None) for row in rows)


def test_arrays_and_row_groups(tmp_path: Path) -> None:
    import pyarrow.parquet

    count, files = 2 * GROUP + 7, []
    for name, cut in (("one", [count]), ("many", [5, GROUP, count])):
        parts = Parts(tmp_path / name / "rows.parquet", {}, count)
        start = 0
        for stop in cut:
            parts.write(range(start, stop), {"x": np.arange(start, stop) * 0.5})
            start = stop
        files.append(parts.join())
    assert files[0].read_bytes() == files[1].read_bytes()
    assert pyarrow.parquet.ParquetFile(files[0]).num_row_groups == 3
    assert pyarrow.parquet.read_table(files[0])["x"].to_pylist()[-1] == 0.5 * (count - 1)


def test_a_part_that_cannot_be_written_is_told(tmp_path: Path) -> None:
    parts = Parts(tmp_path / "a.parquet", {}, 1)
    (tmp_path / "a.parts/rows-000000000-000000001.parquet").mkdir()
    with pytest.raises(ExportError, match="it is a folder"):
        parts.write(range(1), {"n": [1]})


def test_a_finished_study_stays_until_another_profiles_takes_the_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    def study(text: str, *more: str) -> set[str]:
        Path("small.toml").write_text(text)
        command = ["study", "small.toml", "--vary", "cam.diameter=80,90", "--only", "motion,flank", "--jobs", "1"]
        assert main([*command, "--out", "out", *more]) == 0
        capsys.readouterr()
        return {str(path.relative_to("out")) for path in Path("out").rglob("study.*")}

    assert study(TEXT, "--parquet") == {"study.parquet", "study.html"}
    first = Path("out/study.parquet").read_bytes()
    assert study(TEXT, "--parquet") == {"study.parquet", "study.html"}
    assert study(TEXT) == {"study.csv", "study.parquet", "study.html"}
    assert Path("out/study.parquet").read_bytes() == first
    other = TEXT.replace('name = "', 'name = "other ')
    assert other != TEXT
    there = study(other, "--parquet")
    moved = {name for name in there if name.startswith("previous/")}
    assert there - moved == {"study.parquet", "study.html"}
    assert {Path(name).name for name in moved} == {"study.csv", "study.parquet", "study.html"}
    assert first in [Path("out", name).read_bytes() for name in moved]


def test_json_and_page_of_a_parquet_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(TEXT)
    common = ["study", "small.toml", "--vary", "cam.diameter=80,-1", "--only", "motion,flank", "--json", "--jobs", "1"]
    assert main([*common, "--out", "csv"]) == 0
    plain = json.loads(capsys.readouterr().out)
    assert main([*common, "--out", "parquet", "--parquet"]) == 0
    kept = json.loads(capsys.readouterr().out)
    assert kept["rows"] == plain["rows"]
    assert [Path(file).name for file in kept["files"]] == ["study.parquet", "study.html"]
    page = "study.html"
    assert Path("csv", page).read_text() == Path("parquet", page).read_text()
