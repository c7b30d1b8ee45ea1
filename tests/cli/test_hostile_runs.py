"""Runs that are stopped, starved or crowded: nothing half-written or lost, one message, the right exit status."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from camgeom.interrupts import beginning_children
from tests.places import PROFILES, ROOT

PROFILE = PROFILES / "disc_offset_roller.toml"
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "OPENBLAS_NUM_THREADS": "1"}
QUICK = ("--formats", "stl,ply,obj", "--tolerance", "0.0005")


def start(*arguments: str, limit: int | None = None, profile: Path = PROFILE) -> subprocess.Popen[str]:
    """A `camgeom build` under way; limit: the largest file it may write, bytes."""

    def bounded() -> None:
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    command = [sys.executable, "-m", "camgeom", "build", str(profile), *arguments]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True, env=ENVIRONMENT, preexec_fn=bounded)


def heard() -> None:
    """A shell's background job inherits that interrupts are ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def finished(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=120)
    assert "Traceback" not in err
    return process.returncode, out, err


def whole(folder: Path) -> set[str]:
    """Names in the folder, after a look into each file: result.json parses, an STL has the size it says."""
    for path in folder.iterdir():
        if path.name == "result.json":
            json.loads(path.read_text())
        elif path.suffix == ".stl":
            content = path.read_bytes()
            assert len(content) == 84 + 50 * int.from_bytes(content[80:84], "little")
        elif path.suffix == ".ply":
            assert path.read_bytes().startswith(b"ply\n")
    return {path.name for path in folder.iterdir()}


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL])
def test_stopped_runs_leave_whole_files(tmp_path: Path, how: signal.Signals) -> None:
    code, _, err = finished(start(*QUICK, "--out", str(tmp_path)))
    assert code in (0, 1), err
    names = whole(tmp_path)
    for later in (0.0, 0.002, 0.005, 0.02):
        process = start(*QUICK, "--out", str(tmp_path))
        # In the middle of a write: from the first temporary file on.
        known = set(tmp_path.glob(".*.part"))
        while process.poll() is None and set(tmp_path.glob(".*.part")) <= known:
            time.sleep(0.0005)
        time.sleep(later)
        process.send_signal(how)
        finished(process)
        left = whole(tmp_path)
        assert names <= left
        # What was killed outright may leave its temporary file, hidden and under no name that anybody reads.
        assert all(name.startswith(".") and name.endswith(".part") for name in left - names)
        assert how == signal.SIGKILL or left == names


BEFORE = (
    "import os, signal, sys; sys.argv = ['camgeom', '--version']; from camgeom import __main__ as entry; "
    # A shell's background job inherits that interrupts are ignored.
    "signal.signal(signal.SIGINT, signal.default_int_handler); "
)


@pytest.mark.parametrize(("how", "code", "said"), [("SIGINT", 130, "interrupted"), ("SIGTERM", 143, "terminated")])
@pytest.mark.parametrize("early", [True, False], ids=["before", "after"])
def test_a_signal_before_and_after_the_command_leaves_no_trace(early: bool, how: str, code: int, said: str) -> None:
    came = f"os.kill(os.getpid(), signal.{how})"
    moment, out, err = f"status = entry.run(); {came}; sys.exit(status)", "camgeom", ""
    if early:
        late = f"sys.meta_path.insert(0, type('Late', (), {{'find_spec': lambda *_: {came}}})()); "
        moment, out, err = f"{late}sys.exit(entry.run())", "", f"camgeom: {said}\n"
    code = code if early else 0
    done = subprocess.run([sys.executable, "-c", BEFORE + moment], capture_output=True, text=True, env=ENVIRONMENT,
                          check=False)  # fmt: skip
    assert (done.returncode, done.stdout[: len(out)], done.stderr) == (code, out, err)


GOES = """
class Going:
    def __del__(self):
        os.kill(os.getpid(), signal.{how})
        os.getpid()
def swallow():
    going = Going()
    del going
"""
CATCHES = """
def swallow():
    try:
        os.kill(os.getpid(), signal.{how})
        os.getpid()
    except BaseException:
        pass
"""
MAIN = """
def main():
    swallow()
    for _ in range(1000):
        time.sleep(0.01)
    return 0
import time, camgeom.cli
camgeom.cli.main = main
sys.exit(entry.run())
"""


@pytest.mark.parametrize(("how", "code", "said"), [("SIGINT", 130, "interrupted"), ("SIGTERM", 143, "terminated")])
@pytest.mark.parametrize("swallowing", [GOES, CATCHES], ids=["goes", "catches"])
def test_a_signal_within_code_that_cannot_raise_comes_again(swallowing: str, how: str, code: int, said: str) -> None:
    """A study had loaded the tables of SciPy's Sobol sequences when SIGTERM came: it was printed and went on."""
    done = subprocess.run([sys.executable, "-c", BEFORE + swallowing.format(how=how) + MAIN], capture_output=True,
                          text=True, env=ENVIRONMENT, check=False)  # fmt: skip
    assert (done.returncode, done.stderr) == (code, f"camgeom: {said}\n")


def test_a_signal_within_text_that_runs_ends_with_its_status(tmp_path: Path) -> None:
    """Python remembered it as an interrupt that nobody caught, and ended by SIGINT: `terminated`, and 130."""
    (tmp_path / "laws.py").write_text('exec("import os, signal; os.kill(os.getpid(), signal.SIGTERM)")')
    words = [sys.executable, "-m", "camgeom", "check", str(PROFILE), "--laws", str(tmp_path / "laws.py")]
    done = subprocess.run(words, capture_output=True, text=True, env=ENVIRONMENT, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (143, "", "camgeom: terminated\n")


def test_processes_that_begin_leave_interrupts_to_their_parent() -> None:
    """Ctrl-C at a terminal goes to all of its processes: workers that were still importing showed tracebacks."""
    code = "import sys, time; print(1, flush=True); time.sleep(0.2); print(2)"
    with beginning_children():
        child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "1\n"
    child.send_signal(signal.SIGINT)
    assert (child.communicate()[0], child.returncode) == ("2\n", 0)
    assert signal.SIGINT not in signal.pthread_sigmask(signal.SIG_BLOCK, ())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("how", "code", "said"), [(signal.SIGINT, 130, "interrupted"), (signal.SIGTERM, 143, "terminated")]
)
def test_a_study_with_workers_ends_with_its_signal_and_leaves_nothing(
    tmp_path: Path, how: signal.Signals, code: int, said: str
) -> None:
    """SIGTERM left a hidden folder of parts, and Python's own warning of a lock that nobody had removed."""
    out = tmp_path / "out"
    words = ["study", str(PROFILE), "--exact", "--jobs", "2", "--sample", "sobol:4000",
             "--vary", "cam.base_radius=40:60", "--out", str(out)]  # fmt: skip
    process = subprocess.Popen([sys.executable, "-m", "camgeom", *words], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True, env=ENVIRONMENT, preexec_fn=heard)  # fmt: skip
    while process.poll() is None and not list(tmp_path.rglob("*.part")) + list(tmp_path.rglob(".camgeom*")):
        time.sleep(0.01)
    time.sleep(1.0)
    process.send_signal(how)
    ended, _, err = finished(process)
    assert (ended, err.strip().splitlines()[-1]) == (code, f"camgeom: {said}")
    assert "Warning" not in err
    assert not [path for path in tmp_path.rglob("*") if path.name.startswith(".")]


def test_a_closed_standard_input_is_told() -> None:
    words = f"{sys.executable} -m camgeom check - <&-"
    done = subprocess.run(words, shell=True, capture_output=True, text=True, env=ENVIRONMENT, check=False)
    assert (done.returncode, done.stderr) == (2, "camgeom: standard input: is closed\n")


@pytest.mark.slow
def test_a_full_disk_keeps_the_earlier_files(tmp_path: Path) -> None:
    finished(start("--formats", "stl", "--tolerance", "0.05", "--out", str(tmp_path)))
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    code, _, err = finished(start("--formats", "stl", "--tolerance", "0.0002", "--out", str(tmp_path), limit=60_000))
    assert code == 1  # a file asked for could not be made
    assert "cannot be written" in err
    moved, told = sorted(err.splitlines(), key=lambda line: "moved" not in line)
    assert moved.startswith(f"camgeom: moved to {tmp_path / 'previous'}: ")
    assert "cannot be written" in told
    # The mesh found no room: the earlier one is whole in `previous`; the result lists only what this run wrote.
    (mesh,) = (name for name in before if name.endswith(".stl"))
    assert {path.name for path in tmp_path.iterdir()} == {"manifest.json", "previous", "result.json"}
    assert (tmp_path / "previous" / mesh).read_bytes() == before[mesh]
    result = json.loads((tmp_path / "result.json").read_text())
    assert result["files"] == []
    assert result["products"]["stl"]["status"] == "failed"


@pytest.mark.slow
def test_two_runs_into_one_folder(tmp_path: Path) -> None:
    runs = [start(*QUICK[:2], "--tolerance", t, "--out", str(tmp_path)) for t in ("0.001", "0.002", "0.004")]
    assert {finished(run)[0] for run in runs} <= {0, 1}
    names = whole(tmp_path)
    assert "result.json" in names
    assert not any(name.endswith(".part") for name in names)


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["/proc/camgeom", "/dev/null", "/dev/null/x", "/sys/camgeom"])
def test_a_folder_that_cannot_be_written_is_named_at_once(folder: str) -> None:
    if not Path("/proc").is_dir():
        pytest.skip("needs a system with /proc")
    code, out, err = finished(start("--formats", "stl", "--out", folder))
    assert code == 3
    assert out == ""
    assert folder.removesuffix("/x") in err


@pytest.mark.slow
@pytest.mark.parametrize("place", ["/dev/zero", "/dev/full", "/dev/null", "/", "/proc/self/mem", "/nowhere.toml"])
def test_no_profile_at_that_place(place: str, tmp_path: Path) -> None:
    code, out, err = finished(start("--out", str(tmp_path / "x"), profile=Path(place)))
    assert code == 2
    assert out == ""
    assert place in err
    assert not (tmp_path / "x").exists()
