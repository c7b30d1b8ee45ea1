"""Fault injection: every write, every large array and every library fails in turn, and a run keeps its promises.

    scripts/stability/faults.py                     all kinds, every profile of PROFILES
    scripts/stability/faults.py --only memory --most 20

A counter goes through a run: the n-th write (or rename, or folder made), the n-th allocation of a large array, the n-th
library fails. The run has to end as any other, with its result.json and the reason at the product that it cost; where
the result itself cannot be written, with one message and the earlier set whole.
"""

from __future__ import annotations

import argparse
import builtins
import errno
import json
import os
import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import products as runs

LIBRARIES = ("scipy", "trimesh", "manifold3d", "pyvista", "vtkmodules", "PIL", "ezdxf", "imageio_ffmpeg", "meshio")
LARGE = 20_000
"""numbers in an array that is called large"""
MAKERS = (
    "empty",
    "zeros",
    "ones",
    "full",
    "arange",
    "linspace",
    "concatenate",
    "stack",
    "column_stack",
    "repeat",
    "tile",
)
PROFILES = {
    "drum": (
        "pin_insertion",
        'formats = ["3mf", "stl", "step", "dxf", "points.npz", "cmm.csv", "ecam.csv", "sheet.pdf"]',
    ),
    "disc": ("disc_offset_roller", 'formats = ["ply", "glb", "vtu", "outline.csv", "apt", "plcopen.xml", "stp"]'),
    "globoid": ("tool_changer", 'formats = ["obj", "assembly.step", "cutter.csv", "sheet.svg"]'),
    "milled": ("milled_drum", 'formats = ["gcode", "rest.csv", "rest.vtu", "apt", "cutter.csv"]'),
    "pair": ("conjugate_rocker", 'formats = ["3mf", "stl", "ap214.step", "dxf", "points.csv", "outline.csv"]'),
    "frame": ("constant_width_press", 'formats = ["ply", "step", "sheet.svg", "cmm.csv", "ecam.csv"]'),
    "barrel": ("barrel_indexer", 'formats = ["stl", "glb", "points.ply", "cmm.csv", "stp"]'),
    "ring": ("end_face_lifter", 'formats = ["3mf", "step", "dxf", "sheet.svg", "cmm.csv", "history.csv", "gcode"]'),
    "volume": (
        "pin_insertion",
        'formats = ["volume.inp", "volume.bdf", "volume.msh", "volume.vtu", "volume.xdmf", "history.csv"]',
    ),
    "drawn": ("tool_changer", 'formats = ["stl", "history.csv", "impact.csv"]'),
    "slide": (
        "linear_groove",
        'formats = ["3mf", "stl", "step", "dxf", "sheet.svg", "cmm.csv", "gcode", "history.csv"]',
    ),
    "tracks": ("two_groove_drum", 'formats = ["3mf", "step", "dxf", "sheet.pdf", "points.csv", "ecam.csv"]'),
    "faces": ("both_faces_disc", 'formats = ["stl", "step", "dxf", "sheet.svg", "outline.csv", "cmm.csv"]'),
    "bell": ("bell_lifter", 'formats = ["3mf", "stp", "dxf", "sheet.svg", "cmm.csv", "history.csv"]'),
    "cone": ("conical_guide", 'formats = ["stl", "step", "points.csv", "sheet.pdf", "cutter.csv", "ecam.csv"]'),
    "leaning": ("conical_disc", 'formats = ["3mf", "step", "dxf", "outline.csv", "cmm.csv", "history.csv"]'),
    "plates": ("parallel_index", 'formats = ["3mf", "vtu", "assembly.step", "dxf", "outline.csv"]'),
}
"""one profile of every kind, one that is milled, one meshed as a volume, one with [tolerance]; nearly every format but
pictures and films"""


class Fault:
    """The n-th of some kind of operation fails; `count` says how many there were."""

    def __init__(self, number: int, error: Callable[[], Exception], tally: Path) -> None:
        self.number, self.error, self.tally, self.count = number, error, tally, 0

    def here(self) -> None:
        """One more operation."""
        self.count += 1
        if self.count == self.number:
            raise self.error()

    def note(self) -> None:
        """Leave the count where the parent finds it."""
        os.write(os.open(self.tally, os.O_WRONLY | os.O_CREAT), str(self.count).encode())


class Stream:
    """A file whose writes are counted."""

    def __init__(self, stream: Any, fault: Fault) -> None:
        self._stream, self._fault = stream, fault

    def write(self, data: Any) -> int:
        self._fault.here()
        return int(self._stream.write(data))

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def __enter__(self) -> Stream:
        return self

    def __exit__(self, *_: Any) -> None:
        self._stream.close()


def writes(fault: Fault) -> None:
    """Count opening for writing, writing, syncing, renaming and making folders."""
    opened, renamed, made, synced = builtins.open, Path.replace, Path.mkdir, os.fsync

    def opening(name: Any, mode: str = "r", *rest: Any, **more: Any) -> Any:
        if isinstance(name, int) or not set(mode) & set("wxa+"):
            return opened(name, mode, *rest, **more)
        fault.here()
        stream = opened(name, mode, *rest, **more)
        return Stream(stream, fault) if str(name).endswith(".part") else stream

    def counted(function: Callable[..., Any]) -> Callable[..., Any]:
        def called(*words: Any, **more: Any) -> Any:
            fault.here()
            return function(*words, **more)

        return called

    builtins.open = opening  # type: ignore[assignment]
    Path.replace, Path.mkdir, os.fsync = counted(renamed), counted(made), counted(synced)  # type: ignore[method-assign]


def memory(fault: Fault) -> None:
    """Count large arrays, as they are made by name."""
    import numpy as np

    def counted(function: Callable[..., Any]) -> Callable[..., Any]:
        def called(*words: Any, **more: Any) -> Any:
            found = function(*words, **more)
            if found.size >= LARGE:
                fault.here()
            return found

        return called

    for name in MAKERS:
        setattr(np, name, counted(getattr(np, name)))


def library(name: str) -> None:
    """Let a library be missing."""

    class Missing:
        """A finder that finds it nowhere."""

        @staticmethod
        def find_spec(wanted: str, *_: Any) -> None:
            """Refuse the library and what is in it."""
            if wanted.partition(".")[0] == name:
                raise ModuleNotFoundError(f"No module named {wanted!r}", name=wanted)

    for known in [module for module in sys.modules if module.partition(".")[0] == name]:
        del sys.modules[known]
    sys.meta_path.insert(0, Missing)  # type: ignore[arg-type]


def judged(place: Path, profile: Path, prepare: Callable[[], Any], formats: list[str]) -> str:
    """The class of a run under a fault, into a folder with an earlier run of another state; raises `Failure`."""
    folder, before = place / "out", place / "before"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(before, folder)
    ended = runs.child(["run", str(profile), "--out", str(folder)], place, None, prepare=prepare)
    name = json.loads((before / "result.json").read_text())["name"]
    for word in ("Warning", "Traceback", "this is a bug"):
        if word in ended["stderr"]:
            raise runs.Failure(f"stderr says {word}: {ended['stderr'][-700:]}")
    if ended["code"] not in (0, 1, 2, 3):
        raise runs.Failure(f"ended with {ended['code']}: {ended['stderr'][-300:]}")
    old = json.loads((before / "manifest.json").read_text())
    new = json.loads((folder / "manifest.json").read_text())
    if new["state"] != "complete":
        # A rename that fails leaves a set half way, and says so: the next run carries it through.
        if ended["code"] != 3:
            raise runs.Failure("a set was left half way without a word")
        runs.one_set(folder, killed=True)
        runs.recovered(folder, profile)
        return "carried through"
    runs.one_set(folder, killed=False)
    if new["profile_sha256"] == old["profile_sha256"]:
        if ended["code"] != 3 or "cannot be written" not in ended["stderr"]:
            raise runs.Failure(f"no result and exit status {ended['code']}: {ended['stderr'][-300:]}")
        return "earlier set whole"
    result = json.loads((folder / "result.json").read_text())
    runs.every_product(result, {"name": name, "output": {"formats": formats}}, folder)
    lost = [key for key, one in result["products"].items() if one["status"] in ("refused", "failed")]
    return f"exit {ended['code']}, {'nothing' if not lost else 'products'} lost"


def campaign(kinds: tuple[str, ...], chosen: tuple[str, ...], most: int, say: Callable[[str], None]) -> Counter[str]:
    """Counts of endings by kind of fault; failures are said."""
    runs.begin()
    counts: Counter[str] = Counter()
    for label in chosen:
        source, formats = PROFILES[label]
        text = (runs.ROOT / "profiles" / f"{source}.toml").read_text()
        wanted = re.findall(r'"([^"]+)"', formats)
        with tempfile.TemporaryDirectory(prefix="camgeom-fault-") as folder:
            place = Path(folder)
            profile, tally = place / "profile.toml", place / "tally"
            profile.write_text(_with_output(text, f"tolerance = 0.02\n{formats}"))
            earlier = place / "earlier.toml"
            earlier.write_text(_with_output(text, f"tolerance = 0.05\n{formats}"))
            ended = runs.child(["run", str(earlier), "--out", str(place / "before")], place, None)
            if ended["code"] not in (0, 1):
                raise runs.Failure(f"the earlier run ended with {ended['code']}: {ended['stderr']}")
            for kind in kinds:
                if kind == "library":
                    faults: list[tuple[str, Callable[[], Any]]] = [
                        (name, lambda name=name: library(name))
                        for name in LIBRARIES  # type: ignore[misc]
                    ]
                else:
                    faults = _counted(kind, place, profile, tally, wanted, most)
                for name, prepare in faults:
                    try:
                        ending = judged(place, profile, prepare, wanted)
                    except runs.Failure as failure:
                        ending = "FAILURE"
                        say(f"{label}, {kind} {name}: {failure}")
                    counts[f"{kind}: {ending}"] += 1
    return counts


def _with_output(text: str, keys: str) -> str:
    """A profile with another [output]."""
    return re.sub(r"^\[output\]\n(?:(?!\[).*\n?)*", "", text, flags=re.MULTILINE) + f"\n[output]\n{keys}\n"


def _counted(
    kind: str, place: Path, profile: Path, tally: Path, wanted: list[str], most: int
) -> list[tuple[str, Callable[[], Any]]]:
    """The faults of a kind, at most so many, evenly over the run."""
    error = (lambda: OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))) if kind == "write" else MemoryError
    install = writes if kind == "write" else memory

    def prepare(number: int) -> Callable[[], None]:
        fault = Fault(number, error, tally)
        install(fault)
        return fault.note

    tally.unlink(missing_ok=True)
    judged(place, profile, lambda: prepare(0), wanted)
    total = int(tally.read_text())
    numbers = (
        sorted({1 + k * (total - 1) // max(1, most - 1) for k in range(most)}) if total > most else range(1, total + 1)
    )
    return [(f"{number} of {total}", lambda number=number: prepare(number)) for number in numbers]  # type: ignore[misc]


def main() -> int:
    """Inject all faults; exit status 1 where a promise is not kept."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", choices=("write", "memory", "library"))
    parser.add_argument("--profile", choices=tuple(PROFILES))
    parser.add_argument("--most", type=int, default=10_000, help="faults of a kind and profile, evenly over the run")
    args = parser.parse_args()
    kinds = (args.only,) if args.only else ("write", "memory", "library")
    chosen = (args.profile,) if args.profile else tuple(PROFILES)
    counts = campaign(kinds, chosen, args.most, lambda text: print(text, flush=True))
    for ending, count in sorted(counts.items()):
        print(f"{count:>6}  {ending}")
    return int(any("FAILURE" in ending for ending in counts))


if __name__ == "__main__":
    sys.exit(main())
