"""Let CalculiX run the volume meshes that camgeom writes, and compare its displacements with camgeom's own.

    python scripts/judge_body.py PROFILE...     a line for each: load, largest displacement of both, their difference
    python scripts/judge_body.py --install      only make the judge ready

CalculiX (`ccx`) is a judge for developers and never needed to use camgeom. Where the system has none, Debian's packages
are fetched by apt-get and unpacked in `.venv-judge/ccx` beside this folder; nothing is installed. Exit status 1 where a
file does not run without a word, or displacements differ by more than 1e-5 of the largest.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from camgeom import read  # noqa: E402
from camgeom.body.element import elasticity  # noqa: E402
from camgeom.body.frame_stress import FrameVolume  # noqa: E402
from camgeom.body.solver import elastic  # noqa: E402
from camgeom.body.sparse_solver import SparseElastic  # noqa: E402
from camgeom.body.volume import BodyVolume, Volume  # noqa: E402
from camgeom.errors import CamgeomError  # noqa: E402
from camgeom.export.volume import write_inp  # noqa: E402

ROOM = ROOT / ".venv-judge" / "ccx"
LIMIT = 1e-5
TIGHT = 1e-10
"""force that is left over where displacements are compared"""


@cache
def program() -> tuple[str, dict[str, str]] | None:
    """The program and the environment it runs in, or None where there is none."""
    if found := shutil.which("ccx"):
        return found, dict(os.environ)
    made = ROOM / "usr" / "bin" / "ccx"
    if not made.exists():
        return None
    folders = sorted({str(path.parent) for path in ROOM.rglob("lib*.so*")})
    return str(made), {**os.environ, "LD_LIBRARY_PATH": ":".join(folders)}


def install() -> None:
    """Unpack Debian's calculix-ccx and what it needs. Raises CalledProcessError where apt-get or dpkg fail."""
    if program() is not None:
        return
    ROOM.mkdir(parents=True, exist_ok=True)
    command = ["apt-get", "install", "--simulate", "--no-install-recommends", "calculix-ccx"]
    told = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    names = re.findall(r"^Inst (\S+)", told, re.MULTILINE)
    subprocess.run(["apt-get", "download", *names], check=True, cwd=ROOM, capture_output=True)
    for package in ROOM.glob("*.deb"):
        subprocess.run(["dpkg", "-x", package.name, "."], check=True, cwd=ROOM)
        package.unlink()
    program.cache_clear()


def displacements(volume: Volume) -> tuple[np.ndarray, list[str]]:
    """Displacements (v, 3), mm, that CalculiX finds for the file as it is written, and its complaints."""
    found = program()
    assert found is not None
    with TemporaryDirectory() as folder:
        write_inp(Path(folder, "cam.inp"), volume)
        done = subprocess.run([found[0], "-i", "cam"], cwd=folder, env=found[1], capture_output=True, text=True)
        words = [line for line in done.stdout.splitlines() if re.search(r"\*(WARNING|ERROR)", line)]
        if done.returncode or "Job finished" not in done.stdout:
            return np.zeros((0, 3)), [*words, "the job did not finish"]
        return _displaced(Path(folder, "cam.frd").read_text(), len(volume.nodes)), words


def _displaced(text: str, count: int) -> np.ndarray:
    """The field DISP of a result file: lines of a node's number and numbers of twelve characters."""
    rows = text.split(" -4  DISP", 1)[1].split("\n -3", 1)[0].splitlines()
    lines = [line for line in rows if line.startswith(" -1")]
    moved = np.zeros((count, 3))
    for line in lines:
        moved[int(line[3:13]) - 1] = [float(line[13 + 12 * k : 25 + 12 * k]) for k in range(3)]
    return moved


def judged(name: str, volume: Volume) -> bool:
    """Print a line for a volume; whether it fails."""
    material, forces = volume.material, volume.forces[:, :, None]
    theirs, words = displacements(volume)
    said = "".join("; " + word.strip() for word in words)
    if isinstance(volume, BodyVolume):
        own = elastic(volume.ring, material).solve(forces)[:, :, 0]
    elif isinstance(volume, FrameVolume):
        solver = SparseElastic(volume.frame.mesh, elasticity(material.elastic_modulus, material.poisson), volume.held)
        own = solver.solve(forces, TIGHT)[:, :, 0]
    else:
        moved = 1e3 * float(np.abs(theirs).max()) if len(theirs) else np.nan
        print(f"{name}: {volume.about[0]}; CalculiX finds {moved:.6g} um{said}")
        return bool(words) or not len(theirs)
    most = float(np.abs(own).max())
    off = float(np.abs(theirs - own).max()) / most if len(theirs) else np.inf
    print(f"{name}: {volume.name}, {len(own)} nodes, {volume.patch.normal:.6g} N, moved {1e3 * most:.6g} um, "
          f"CalculiX differs by {off:.2g}{said}")  # fmt: skip
    return bool(words) or off > LIMIT


def main(arguments: list[str]) -> int:
    """Judge the profiles."""
    install()
    failed = False
    for name in [one for one in arguments if not one.startswith("--")]:
        try:
            model = read(name)
            volumes = [model.volume, *([model.frame_volume] if model.mechanism.frame is not None else [])]
        except CamgeomError as error:
            print(f"{name}: no volume: {error}")
            continue
        for volume in volumes:
            failed |= judged(name, volume)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
