"""A study on a real Dask scheduler with two real worker processes on the loopback, one of them killed in the middle."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from camgeom.cli import main
from camgeom.design.parts import read_rows
from tests.design.runs import ABSENT, TEXT, begun, done, wait_for_parts
from tests.places import ROOT

pytest.importorskip("distributed", reason=f"no distributed: {ABSENT}")
pytest.importorskip("pyarrow", reason=f"no pyarrow: {ABSENT}")
pytestmark = pytest.mark.slow

LAW = '''
from math import inf
from camgeom import Claims, Piece, law
said = Claims(vm=1.5, am=6.0, jm=inf, vam=2 * 3**0.5, arms=2 * 3**0.5, order_start=1, order_end=1)
@law("our-cubic", source="by hand", claims=said)
def our_cubic():
    "A cubic."
    return [Piece(0.0, 1.0, 0.0, (0.0, 0.0, 3.0, -2.0))]
'''


@dataclass
class Machines:
    """A scheduler and its workers, each a process of its own in a folder that has nothing of the study."""

    folder: Path
    processes: list[subprocess.Popen[bytes]] = field(default_factory=list)
    address: str = ""

    def start(self, *words: str) -> subprocess.Popen[bytes]:
        environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}
        command = [sys.executable, "-m", *words]
        with (self.folder / f"{len(self.processes)}.log").open("wb") as log:
            process = subprocess.Popen(command, cwd=self.folder, env=environment, stdout=log, stderr=log)
        self.processes.append(process)
        return process

    def log(self, number: int) -> str:
        return (self.folder / f"{number}.log").read_text()

    def said(self, number: int, pattern: str) -> str:
        """What a process writes, waited for."""
        until = time.monotonic() + 60.0
        while time.monotonic() < until:
            if found := re.search(pattern, self.log(number)):
                return found[1]
            time.sleep(0.05)
        raise AssertionError(self.log(number))

    def worker(self) -> subprocess.Popen[bytes]:
        words = ["distributed.cli.dask_worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        process = self.start(*words, "--host", "127.0.0.1", "--local-directory", str(self.folder))
        self.said(len(self.processes) - 1, r"(Registered to)")
        return process


@pytest.fixture
def machines(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Machines]:
    """A scheduler on the loopback, without workers."""
    found = Machines(tmp_path_factory.mktemp("machines"))
    found.start("distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
    try:
        found.address = found.said(0, r"Scheduler at:\s+(tcp://127\.0\.0\.1:\d+)")
        yield found
    finally:
        for process in found.processes:
            process.kill()
        for process in found.processes:
            process.wait()


def rows(folder: Path, out: str) -> bytes:
    return (folder / out / "study.parquet").read_bytes()


def test_rows_of_a_cluster_that_loses_a_worker_are_those_of_a_serial_run(machines: Machines, tmp_path: Path) -> None:
    done(tmp_path, "--out", "serial", "--jobs", "1")
    first = machines.worker()
    machines.worker()
    running = begun(tmp_path, "--out", "cluster", "--on", machines.address)
    wait_for_parts(tmp_path / "cluster", 8, running)
    first.kill()
    out, err = running.communicate(timeout=120)
    assert running.returncode == 0, err
    assert b"123 variants: 82 pass of what was judged, 41 bad input" in out
    assert rows(tmp_path, "cluster") == rows(tmp_path, "serial")


def test_a_study_goes_on_after_its_own_death(machines: Machines, tmp_path: Path) -> None:
    done(tmp_path, "--out", "serial", "--jobs", "1")
    machines.worker()
    machines.worker()
    running = begun(tmp_path, "--out", "cluster", "--on", machines.address)
    wait_for_parts(tmp_path / "cluster", 4, running)
    running.kill()
    running.communicate()
    told = done(tmp_path, "--out", "cluster", "--on", machines.address)
    assert "of 123 variants were computed before" in told
    assert rows(tmp_path, "cluster") == rows(tmp_path, "serial")


def test_laws_and_tables_travel_with_the_study(machines: Machines, tmp_path: Path) -> None:
    """Workers of another machine have neither the law's file nor the force table: the files are gone meanwhile."""
    (tmp_path / "laws.py").write_text(LAW)
    (tmp_path / "force.csv").write_text("0, 100\n180, 300\n360, 100\n")
    text = TEXT.replace('law = "cycloidal"', 'law = "our-cubic"')
    (tmp_path / "own.toml").write_text(text + '[[operation.force]]\nfile = "force.csv"\n')
    machines.worker()
    study = ["own.toml", "--laws", "laws.py", "--vary", "cam.diameter=70:110:41", "--only", "motion,contact"]
    done(tmp_path, *study, "--out", "serial", "--jobs", "1")
    running = begun(tmp_path, *study, "--out", "cluster", "--on", machines.address)
    wait_for_parts(tmp_path / "cluster", 1, running)
    (tmp_path / "laws.py").unlink()
    (tmp_path / "force.csv").unlink()
    _, err = running.communicate(timeout=120)
    assert running.returncode == 0, err
    assert rows(tmp_path, "cluster") == rows(tmp_path, "serial")
    assert all(row["contact.peak_force_n"] > 290.0 for row in read_rows(tmp_path / "cluster/study.parquet"))


def test_a_lost_scheduler_is_told_and_the_rows_stand(machines: Machines, tmp_path: Path) -> None:
    machines.worker()
    running = begun(tmp_path, "--out", "cluster", "--on", machines.address)
    wait_for_parts(tmp_path / "cluster", 4, running)
    machines.processes[0].kill()
    _, err = running.communicate(timeout=120)
    assert running.returncode == 3
    assert b"was lost; the rows written so far stand" in err
    assert b"Traceback" not in err
    assert len(list((tmp_path / "cluster").glob("study.parts/rows-*"))) >= 4


def test_what_a_scheduler_cannot_do_is_told(
    machines: Machines, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from camgeom.design import engine, study

    monkeypatch.setattr(study, "ALONE_FOR", 0.0)
    monkeypatch.setattr(engine, "PATIENCE", 0.5)
    monkeypatch.chdir(tmp_path)
    Path("small.toml").write_text(TEXT)
    command = ["study", "small.toml", "--vary", "cam.diameter=70,80", "--only", "motion", "--out", "out", "--on"]
    assert main([*command, machines.address]) == 3
    assert "has no workers" in capsys.readouterr().err
    assert main([*command, "tcp://127.0.0.1:9"]) == 3
    assert "no Dask scheduler answers at tcp://127.0.0.1:9" in capsys.readouterr().err
    assert main([*command, machines.address, "--jobs", "2"]) == 2
    machines.worker()
    monkeypatch.setattr("camgeom.design.engine.__version__", "0.0.0")
    assert main([*command, machines.address]) == 3
    assert "install the same version" in capsys.readouterr().err
