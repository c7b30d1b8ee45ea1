"""Runs of whole random profiles, each in a process of its own under bounds, some killed, some into a folder in use.

    scripts/run_campaign --count 2000 --out exports/runs.jsonl
    scripts/run_campaign --seed 1234            one run, its profile and record printed

Every run has to end with 0, 1, 2 or 3 and a result.json (or a refusal of its profile alone), with a status for every
product and a reason for each that is missing, no warning, nothing that is called a bug, and a folder whose manifest
names the files that belong together. Records go to a file of one JSON object a line; seeds in it are not run again.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import multiprocessing
import os
import random
import re
import resource
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(Path(__file__).parent)]
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from whole_profiles import KINDS, accepted, lay, toml  # noqa: E402

MEMORY = 2 << 30
"""bytes of address space of a run"""
SECONDS = 60
"""of a run, on a processor"""
PATIENCE = 600
"""s that a run may take on the clock of a crowded machine"""
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)
NOTE = "notes.txt"
"""a file of the user, which no run may touch"""
CLASSES = ("0", "1", "2", "3", "refused", "killed", "FAILURE")


class Failure(Exception):
    """A promise that a run did not keep."""


def run(seed: int, kill: bool, fill: bool, pictures: float) -> dict[str, Any]:
    """The record of a seed."""
    data, dice = accepted(seed, pictures), random.Random(seed)
    record: dict[str, Any] = {"seed": seed, "kind": data["cam"]["kind"]}
    stop = dice.random() if kill and dice.random() < 1 / 3 else None
    filled = fill and dice.random() < 1 / 3
    with tempfile.TemporaryDirectory(prefix="camgeom-run-") as place:
        folder = Path(place) / "out"
        folder.mkdir()
        (folder / NOTE).write_text("mine")
        if filled:
            shutil.copytree(_earlier(dice), folder, dirs_exist_ok=True)
        profile = Path(place) / "profile.toml"
        profile.write_text(toml(data), encoding="utf-8")
        lay(profile.parent)
        words = ["run", str(profile), "--out", str(folder)]
        # At a moment of what such runs take; those that had ended by then were not killed.
        after = None if stop is None else stop * dice.choice(_WALLS)
        ended = child(words, Path(place), after, dice.choice(SIGNALS))
        if not ended["signal"]:
            _WALLS[:] = [*_WALLS[-20:], ended["wall"]]
        record |= {"filled": filled, "killed": ended["signal"], "seconds": ended["seconds"], "memory_mb": ended["mb"]}
        try:
            record["class"] = _judge(ended, folder, data, filled)
        except Failure as failure:
            record |= {"class": "FAILURE", "why": f"{failure}", "stderr": ended["stderr"][-600:]}
        else:
            record["why"] = ended["stderr"].strip()[:300]
        result = folder / "result.json"
        if record["class"] in "0123" and result.exists():
            products = json.loads(result.read_text())["products"]
            record["products"] = {name: [one["status"], one.get("reason", "")[:200]] for name, one in products.items()}
    return record


_WALLS = [8.0]
"""s that the latest runs of this process took by the clock"""


def _earlier(dice: random.Random) -> Path:
    """A folder with the run of another design, one of a few."""
    seed = 700_000 + dice.randrange(len(KINDS))
    place = Path(tempfile.gettempdir()) / f"camgeom-earlier-{os.getpid()}" / str(seed)
    if not place.exists():
        place.mkdir(parents=True)
        profile = place.with_suffix(".toml")
        profile.write_text(toml(accepted(seed, 0.0)))
        lay(profile.parent)
        child(["run", str(profile), "--out", str(place)], place.parent, None)
    return place


def child(
    words: list[str],
    place: Path,
    after: float | None,
    how: signal.Signals = signal.SIGKILL,
    prepare: Callable[[], Callable[[], None] | None] = lambda: None,
) -> dict[str, Any]:
    """How `camgeom` with these words ends in a process of its own, killed after some seconds or left alone.

    prepare  what is done in that process before, and may give what is done there after
    """
    out, err = place / "stdout", place / "stderr"
    began = time.perf_counter()
    child = os.fork()
    if child == 0:
        status = 70
        try:
            bound(out, err)
            from camgeom.cli import main

            after_all = prepare()
            try:
                status = main(words)
                signal.signal(signal.SIGINT, signal.SIG_IGN)
            except KeyboardInterrupt:  # as the command does, before it has begun and after it has ended
                status = 130 if status == 70 else status
            if after_all is not None:
                after_all()
            sys.stdout.flush()
            sys.stderr.flush()
        except BaseException:
            import traceback

            traceback.print_exc()
            sys.stderr.flush()
        finally:
            os._exit(status)
    sent, usage, code = "", None, 0
    while usage is None:
        done, code, found = os.wait4(child, os.WNOHANG)
        if done:
            usage = found
        elif not sent and time.perf_counter() - began > (PATIENCE if after is None else after):
            sent = how.name if after is not None else "SIGKILL"
            os.kill(child, signal.Signals[sent])
        else:
            time.sleep(0.002)
    return {
        "code": os.waitstatus_to_exitcode(code),
        "signal": sent,
        "seconds": round(usage.ru_utime + usage.ru_stime, 2),
        "wall": time.perf_counter() - began,
        "mb": usage.ru_maxrss // 1024,
        "stderr": err.read_text(errors="replace") if err.exists() else "",
    }


def bound(out: Path, err: Path) -> None:
    """Take the bounds and the streams of a run."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    for stream, path in ((1, out), (2, err)):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o644), stream)
    sys.stdout = open(1, "w", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", closefd=False)  # noqa: SIM115


def _judge(ended: dict[str, Any], folder: Path, data: dict[str, Any], filled: bool) -> str:
    """The class of a run. Raises Failure where a promise is not kept."""
    said = ended["stderr"]
    for word in ("Warning", "Traceback", "this is a bug"):
        if word in said:
            raise Failure(f"stderr says {word}")
    if (folder / NOTE).read_text() != "mine":
        raise Failure("the user's file was touched")
    state = one_set(folder, bool(ended["signal"]))
    if ended["signal"] and ended["code"] not in (0, 1, 2, 3):
        if state == "being replaced":
            recovered(folder, folder.parent / "profile.toml")
        return "killed"
    if ended["code"] not in (0, 1, 2, 3):
        raise Failure(f"ended with {ended['code']} after {ended['seconds']} s")
    if ended["code"] == 2 and ("problems\n" in said or "profile.toml: " in said) and not _result_is_new(folder, data):
        return "refused"
    if not _result_is_new(folder, data):
        raise Failure(f"no result.json, exit status {ended['code']}")
    result = json.loads((folder / "result.json").read_text())
    every_product(result, data, folder)
    manifest = json.loads((folder / "manifest.json").read_text())
    if state != "complete" or manifest["name"] != data["name"]:
        raise Failure(f"the manifest is {state} and of {manifest['name']}")
    if [path.name for path in folder.iterdir() if path.name.startswith(".")]:
        raise Failure("something hidden is left in the folder")
    return str(ended["code"])


def _result_is_new(folder: Path, data: dict[str, Any]) -> bool:
    path = folder / "result.json"
    return path.exists() and json.loads(path.read_text())["name"] == data["name"]


def every_product(result: dict[str, Any], data: dict[str, Any], folder: Path) -> None:
    """Raise Failure where a product has no status, or a missing one no reason."""
    products = result["products"]
    asked = [*data["output"]["formats"], "motion", "flank", "checks", "solid", "contact", "fatigue", "report"]
    for name in (*asked, "dynamics", "impact", "cutter"):
        if name not in products:
            raise Failure(f"nothing is said of {name}")
    for name, one in products.items():
        if one["status"] != "made" and not one.get("reason"):
            raise Failure(f"no reason for {name}, {one['status']}")
        if "trace" in one or "this is a bug" in one.get("reason", ""):
            raise Failure(f"{name}: {one['reason']}: {' | '.join(one.get('trace', [])[-4:])}")
        for file in one.get("files", ()):
            if not (folder / file).is_file():
                raise Failure(f"{name} says it made {file}, which is not there")
    page = folder / "report.html"
    if page.exists() and "this is a bug" in page.read_text():
        raise Failure("the report says that something is a bug")


def one_set(folder: Path, killed: bool) -> str:
    """The state of the manifest. Raises Failure where a file stands beside it of which it says nothing true."""
    path = folder / "manifest.json"
    present = {file.name for file in folder.iterdir() if file.is_file() and not file.name.startswith(".")} - {NOTE}
    if not path.exists():
        if present:
            raise Failure(f"no manifest beside {', '.join(sorted(present))}")
        return ""
    manifest = json.loads(path.read_text())
    entries = manifest["files"] + manifest.get("earlier", {}).get("files", [])
    told: dict[str, set[str]] = {}
    for entry in entries:
        told.setdefault(entry["file"], set()).add(entry["sha256"])
    for name in present - {"manifest.json"}:
        if name not in told:
            raise Failure(f"the manifest does not name {name}")
        if hashlib.sha256((folder / name).read_bytes()).hexdigest() not in told[name]:
            raise Failure(f"{name} is not what the manifest says")
    if manifest["state"] == "complete" and set(told) - present:
        raise Failure(f"the manifest names {', '.join(set(told) - present)}, which is not there")
    if manifest["state"] != "complete" and not killed:
        raise Failure("a run that ended left its set half way")
    return str(manifest["state"])


def recovered(folder: Path, profile: Path) -> None:
    """Raise Failure where the next run does not carry through what a killed one had begun."""
    child(["check", str(profile), "--only", "motion", "--out", str(folder)], folder.parent, None)
    if one_set(folder, killed=False) != "complete":
        raise Failure("what a killed run had begun was not carried through")


def shape_of(text: str) -> str:
    """A message without its numbers and names, to count kinds of messages."""
    return re.sub(r"'[^']*'", "'..'", re.sub(r"-?\d+(\.\d+)?(e[+-]?\d+)?", "#", text))[:110]


def summary(records: list[dict[str, Any]]) -> str:
    """Counts by kind and class, times and memory; why products are missing; what failed."""
    lines = [
        f"{'kind':<18}" + "".join(f"{name:>9}" for name in CLASSES) + f"{'median s':>10}{'most s':>8}{'most MB':>9}"
    ]
    for kind in (*KINDS, "all"):
        own = [record for record in records if kind in (record["kind"], "all")]
        counts = Counter(record["class"] for record in own)
        seconds = sorted(record["seconds"] for record in own if not record["killed"]) or [0.0]
        most = max((record["memory_mb"] for record in own), default=0)
        lines.append(
            f"{kind:<18}"
            + "".join(f"{counts[name]:>9}" for name in CLASSES)
            + f"{seconds[len(seconds) // 2]:>10.1f}{seconds[-1]:>8.1f}{most:>9}"
        )
    products = Counter(one[0] for record in records for one in record.get("products", {}).values())
    lines += ["", "products: " + ", ".join(f"{count} {status}" for status, count in products.most_common())]
    missing = Counter(
        f"{name}: {status}: {shape_of(why)}"
        for record in records
        for name, (status, why) in record.get("products", {}).items()
        if status in ("refused", "failed") and not name.startswith(("report.", "png.", "checks."))
    )
    lines += [f"  {count:>5}  {text}" for text, count in missing.most_common(40)]
    failed = [record for record in records if record["class"] == "FAILURE"]
    lines += ["", "FAILURE:", *(f"  {n:>5}  {text}" for text, n in Counter(shape_of(r["why"]) for r in failed).items())]
    return "\n".join(lines)


def _one(job: tuple[int, bool, bool, float]) -> dict[str, Any]:
    return run(*job)


def begin() -> None:
    """Import what every run needs, once: a run is a fork."""
    import camgeom.checks
    import camgeom.cli.model
    import camgeom.model
    import camgeom.report.delivery
    import camgeom.report.files
    import camgeom.report.sections  # noqa: F401


def main() -> int:
    """Run the campaign; exit status 1 where a promise is not kept."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--seed", type=int, help="run one seed and print profile and record")
    parser.add_argument(
        "--no-kill", dest="kill", action="store_false", help="kill none; else 1 in 3"
    )
    parser.add_argument("--no-fill", dest="fill", action="store_false", help="empty folders; else 1 in 3 in use")
    parser.add_argument("--pictures", type=float, default=0.03, help="how often a picture is asked for")
    parser.add_argument("--out", type=Path, default=ROOT / "exports" / "runs.jsonl")
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    if args.seed is not None:
        print(toml(accepted(args.seed, args.pictures)))
        begin()
        print(json.dumps(run(args.seed, args.kill, args.fill, args.pictures), indent=1))
        return 0
    args.out.parent.mkdir(parents=True, exist_ok=True)
    records = [json.loads(line) for line in args.out.read_text().splitlines()] if args.out.exists() else []
    wanted = range(args.first, args.first + args.count)
    known = {record["seed"] for record in records}
    jobs = [(seed, args.kill, args.fill, args.pictures) for seed in wanted if seed not in known]
    with multiprocessing.get_context("fork").Pool(args.jobs, begin) as pool, args.out.open("a") as file:
        for record in pool.imap_unordered(_one, jobs, chunksize=1):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            if record["class"] == "FAILURE":
                print(f"seed {record['seed']} ({record['kind']}): {record['why']}", flush=True)
    for place in Path(tempfile.gettempdir()).glob("camgeom-earlier-*"):
        with contextlib.suppress(OSError):
            shutil.rmtree(place)
    records = [record for record in records if record["seed"] in set(wanted)]
    print(summary(records))
    return int(any(record["class"] == "FAILURE" for record in records))


if __name__ == "__main__":
    sys.exit(main())
