"""Studies in processes of their own, with pieces so short that there is a middle to kill them in."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

from camgeom.design.study import Figures
from camgeom.errors import DesignError, NotConverged
from camgeom.model import Model
from camgeom.profile.text import load
from tests.cli.small import GOOD
from tests.places import ROOT

ABSENT = "scripts/test_extras installs it and runs these tests"
TEXT = GOOD.partition("[output]")[0]
DATA = load(TEXT, "")[0]
VARIED = ["--vary", "cam.diameter=70:110:41", "--vary", "operation.speed=200,300,x", "--only", "motion,flank"]
"""123 variants, a third of them no profile"""
DRIVER = """
import sys
from camgeom.cli import main
from camgeom.design import engine, study
engine.PIECE_S = 0.1
study.ALONE_FOR = 0.05
if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
"""


def begun(folder: Path, *words: str) -> subprocess.Popen[bytes]:
    """A study in a folder, started; `words` follow `study`, or are the command's own where they name a profile."""
    (folder / "small.toml").write_text(TEXT)
    (folder / "driver.py").write_text(DRIVER)
    named = any(word.endswith(".toml") for word in words)
    command = [sys.executable, "driver.py", "study", *([] if named else ["small.toml", *VARIED]), *words, "--parquet"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def done(folder: Path, *words: str) -> str:
    """A study carried out; what it says on stderr."""
    running = begun(folder, *words)
    _, err = running.communicate(timeout=120)
    assert running.returncode == 0, err
    return err.decode()


def wait_for_parts(folder: Path, count: int, running: subprocess.Popen[bytes]) -> None:
    """Wait until a running study has written so many parts."""
    until = time.monotonic() + 60.0
    while len(list(folder.glob("study.parts/rows-*"))) < count:
        assert running.poll() is None, running.communicate()
        assert time.monotonic() < until
        time.sleep(0.01)


def light(model: Model) -> tuple[Figures, str, str]:
    """A cheap measure that refuses where the tests want it to."""
    diameter = model.profile.cam.diameter  # type: ignore[attr-defined]
    if diameter == 90.0:
        raise DesignError("ninety")
    if diameter == 91.0:
        raise NotConverged("ninety-one")
    return {"radius": 0.5 * diameter, "tracks": len(model.tracks)}, "pass", ""
