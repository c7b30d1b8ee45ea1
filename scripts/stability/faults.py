"""Fault injection: every write, every large array and every library fails in turn, and a run keeps its promises.

    scripts/stability/faults.py                     all kinds, every profile of PROFILES
    scripts/stability/faults.py --only memory --most 20

A counter goes through a run: the n-th write (or rename, or folder made), the n-th allocation of a large array, the n-th
library fails. At each operation the run forks: its twin fails there and goes on to its end, is judged, and what it has
left is put back before the run itself goes on, so that no work is done again for each fault. A twin has to end as any
run, with its result.json and the reason at the product that it cost; where the result itself cannot be written, with
one message and the earlier set whole.
"""

from __future__ import annotations

import argparse
import builtins
import errno
import fcntl
import json
import os
import re
import shutil
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Container
from functools import partial
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

import products as runs

LIBRARIES = ("scipy", "trimesh", "manifold3d", "pyvista", "vtkmodules", "PIL", "ezdxf", "imageio_ffmpeg", "meshio")
PATIENCE = 10_800.0
"""s, of a run with all its twins"""
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
    """Operations of a kind, of which the chosen ones fail, each in a twin of the run.

    judge  the class of how a twin has ended, by its exit status, before what it has left is put back
    """

    def __init__(
        self, chosen: Container[int], error: Callable[[], Exception], place: Path, judge: Callable[[int], str]
    ) -> None:
        self.chosen, self.error, self.place, self.judge = chosen, error, place, judge
        self.count, self.held, self.due = 0, False, list[int]()
        self.streams: list[Any] = []

    def here(self) -> None:
        """One more operation."""
        if self.held:
            return
        self.count += 1
        if self.count in self.chosen:
            self.due.append(self.count)
        # Of several threads a twin has one: what would fail in one of them fails in the next operation without others.
        while self.due and _alone():
            self.held = True  # in the twin nothing more fails, and what judges it is not counted
            folder, kept = self.place / "out", self.place / "kept"
            _linked(folder, kept)
            if alone := _alone():  # while files were linked another thread may have begun
                self._forked(self.due.pop(0), folder, kept)
            self.held = False
            if not alone:
                break

    def _forked(self, number: int, folder: Path, kept: Path) -> None:
        """Return in the run itself, raise in its twin."""
        for stream in self.streams:
            stream.flush()
        places = [stream.tell() for stream in self.streams]
        if (keeper := os.fork()) == 0:
            fcntl.flock = lambda *_: None  # type: ignore[assignment]  # the run holds its folder, for its twins too
            if (twin := os.fork()) == 0:
                runs.bound(self.place / "twin.stdout", self.place / "twin.stderr")
                raise self.error()
            code = os.waitstatus_to_exitcode(os.waitpid(twin, 0)[1])
            with (self.place / "endings").open("a") as file:
                file.write(json.dumps([number, self.judge(code)]) + "\n")
            _put_back(kept, folder)
            os._exit(0)
        if os.waitpid(keeper, 0)[1]:
            raise SystemExit("what a twin has left could not be judged and put back")
        for stream, place in zip(self.streams, places, strict=True):
            stream.seek(place)
            stream.truncate()

    def note(self) -> None:
        """Leave the count where the parent finds it."""
        if not self.held:
            self.held = True
            (self.place / "tally").write_text(str(self.count))


def _alone() -> bool:
    """Whether there is no other thread, of those that `threading` does not know too."""
    return len(sys._current_frames()) == 1


def _linked(folder: Path, copy: Path) -> None:
    """The same tree, its files being the same ones."""
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder, copy, copy_function=os.link)


def _put_back(copy: Path, folder: Path) -> None:
    """Make a folder again what it was, open files of it included; folders that are there stay the same ones."""
    for path in sorted(folder.rglob("*"), reverse=True):
        before = copy / path.relative_to(folder)
        if path.is_dir() and not before.is_dir():
            path.rmdir()
        elif not path.is_dir() and not (before.is_file() and before.samefile(path)):
            path.unlink()
    for before in sorted(copy.rglob("*")):
        path = folder / before.relative_to(copy)
        if before.is_dir():
            path.mkdir(exist_ok=True)
        elif not path.exists():
            os.link(before, path)


class Stream:
    """A file whose writes are counted."""

    def __init__(self, stream: Any, fault: Fault) -> None:
        self._stream, self._fault = stream, fault
        fault.streams.append(stream)

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
        self._fault.streams.remove(self._stream)
        self._stream.close()


def warm(profile: Path, folder: Path) -> None:
    """Run once, and keep the model for the run to come: a twin whose write fails computes little again."""
    import camgeom.model
    from camgeom.cli import main

    kept, made = list[Any](), camgeom.model.Model

    def model(*words: Any) -> Any:
        kept[:] = kept or [made(*words)]
        return kept[0]

    camgeom.model.Model = model  # type: ignore[assignment,misc]
    main(["run", str(profile), "--out", str(folder)])


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


def judged(code: int, err: Path, place: Path, profile: Path, formats: list[str]) -> str:
    """The class of how a run under a fault has ended, into a folder with an earlier run of another state."""
    try:
        return _promised(code, err.read_text(errors="replace"), place, profile, formats)
    except runs.Failure as failure:
        return f"FAILURE: {failure}"


def _promised(code: int, said: str, place: Path, profile: Path, formats: list[str]) -> str:
    """The same; raises `Failure` where a promise is not kept."""
    folder, before = place / "out", place / "before"
    name = json.loads((before / "result.json").read_text())["name"]
    for word in ("Warning", "Traceback", "this is a bug"):
        if word in said:
            raise runs.Failure(f"stderr says {word}: {said[-700:]}")
    if code not in (0, 1, 2, 3):
        raise runs.Failure(f"ended with {code}: {said[-300:]}")
    old = json.loads((before / "manifest.json").read_text())
    new = json.loads((folder / "manifest.json").read_text())
    if new["state"] != "complete":
        # A rename that fails leaves a set half way, and says so: the next run carries it through.
        if code != 3:
            raise runs.Failure("a set was left half way without a word")
        runs.one_set(folder, killed=True)
        runs.recovered(folder, profile)
        return "carried through"
    runs.one_set(folder, killed=False)
    if new["profile_sha256"] == old["profile_sha256"]:
        if code != 3 or "cannot be written" not in said:
            raise runs.Failure(f"no result and exit status {code}: {said[-300:]}")
        return "earlier set whole"
    result = json.loads((folder / "result.json").read_text())
    runs.every_product(result, {"name": name, "output": {"formats": formats}}, folder)
    lost = [key for key, one in result["products"].items() if one["status"] in ("refused", "failed")]
    return f"exit {code}, {'nothing' if not lost else 'products'} lost"


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
            profile = place / "profile.toml"
            profile.write_text(_with_output(text, f"tolerance = 0.02\n{formats}"))
            earlier = place / "earlier.toml"
            earlier.write_text(_with_output(text, f"tolerance = 0.05\n{formats}"))
            ended = runs.child(["run", str(earlier), "--out", str(place / "before")], place, None)
            if ended["code"] not in (0, 1):
                raise runs.Failure(f"the earlier run ended with {ended['code']}: {ended['stderr']}")
            for kind in kinds:
                found = _libraries(place, profile, wanted) if kind == "library" else _counted(
                    kind, place, profile, wanted, most
                )
                for name, ending in found:
                    if ending.startswith("FAILURE"):
                        say(f"{label}, {kind} {name}: {ending}")
                    counts[f"{kind}: {ending.partition(':')[0]}"] += 1
    return counts


def _run(place: Path, profile: Path, prepare: Callable[[], Callable[[], None] | None]) -> int:
    """The exit status of a run into a folder with an earlier one."""
    folder = place / "out"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(place / "before", folder)
    ended = runs.child(["run", str(profile), "--out", str(folder)], place, PATIENCE, prepare=prepare)
    return int(ended["code"])


def _libraries(place: Path, profile: Path, wanted: list[str]) -> list[tuple[str, str]]:
    """How runs end without each library."""
    return [
        (name, judged(_run(place, profile, partial(library, name)), place / "stderr", place, profile, wanted))
        for name in LIBRARIES
    ]


def _with_output(text: str, keys: str) -> str:
    """A profile with another [output]."""
    return re.sub(r"^\[output\]\n(?:(?!\[).*\n?)*", "", text, flags=re.MULTILINE) + f"\n[output]\n{keys}\n"


def _counted(kind: str, place: Path, profile: Path, wanted: list[str], most: int) -> list[tuple[str, str]]:
    """The faults of a kind, at most so many, evenly over the run, and how their twins end."""
    error = (lambda: OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))) if kind == "write" else MemoryError
    install = writes if kind == "write" else memory

    def total(chosen: Container[int]) -> int:
        def prepare() -> Callable[[], None]:
            judge = lambda code: judged(code, place / "twin.stderr", place, profile, wanted)  # noqa: E731
            if kind == "write":
                warm(profile, place / "warm")
            fault = Fault(chosen, error, place, judge)
            install(fault)
            return fault.note

        (place / "tally").unlink(missing_ok=True)
        (place / "endings").write_text("")
        ending = judged(_run(place, profile, prepare), place / "stderr", place, profile, wanted)
        if not ending.startswith("exit"):
            raise runs.Failure(f"the run that is forked: {ending}")
        return int((place / "tally").read_text())

    every = range(1, total(()) + 1)
    chosen = {1 + k * (len(every) - 1) // max(1, most - 1) for k in range(most)} if len(every) > most else set(every)
    total(chosen)
    endings = [json.loads(line) for line in (place / "endings").read_text().splitlines()]
    missing = chosen - {number for number, _ in endings}
    endings += [(number, "not injected: nothing came after its thread") for number in sorted(missing)]
    return [(f"{number} of {len(every)}", ending) for number, ending in endings]


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
