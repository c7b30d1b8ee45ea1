"""The random campaign: many designs, two at a time, each judged; resumable, with a summary by outcome.

    scripts/campaign --count 2100 --out exports/campaign.jsonl
    scripts/campaign --seed 1234            one design, printed whole

Records go to a file of one JSON object a line; seeds that are in it already are not run again.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import re
import signal
import sys
from collections import Counter
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests"), str(Path(__file__).parent)]
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from designs import KINDS, KINDS_LATER, design, kind_of  # noqa: E402
from judging import judge  # noqa: E402

LIMIT = 120
"""s that one design may take"""


class TooLongError(Exception):
    """A design took longer than LIMIT."""


def _alarm(*_: Any) -> None:
    raise TooLongError(f"more than {LIMIT} s")


def run(seed: int) -> dict[str, Any]:
    """The record of a seed."""
    signal.signal(signal.SIGALRM, _alarm)
    signal.alarm(LIMIT)
    try:
        record = judge(design(seed), seed)
    finally:
        signal.alarm(0)
    return {"seed": seed, "kind": kind_of(seed), **record}


def shape_of(text: str) -> str:
    """A message without its numbers, to count kinds of messages."""
    return re.sub(r"'[^']*'", "'..'", re.sub(r"-?\d+(\.\d+)?(e[+-]?\d+)?", "#", text))[:110]


def summary(records: list[dict[str, Any]]) -> str:
    """Counts by kind and outcome, largest error, silent failures."""
    outcomes = ("good", "finding", "no body", "refused", "stopped", "FAILURE")
    lines = [f"{'kind':<18}" + "".join(f"{o:>9}" for o in outcomes) + f"{'error':>9}{'median s':>10}"]
    for kind in (*dict.fromkeys((*KINDS, *KINDS_LATER)), "all"):
        own = [r for r in records if kind in (r["kind"], "all")]
        counts = Counter(r["outcome"] for r in own)
        errors = [r["error"] for r in own if r["outcome"] == "good"]
        seconds = sorted(r["seconds"] for r in own) or [0.0]
        lines.append(
            f"{kind:<18}" + "".join(f"{counts[o]:>9}" for o in outcomes)
            + f"{max(errors, default=0.0):>9.3f}{seconds[len(seconds) // 2]:>10.2f}"
        )
    for outcome in ("refused", "stopped", "no body", "FAILURE"):
        said = [r["why"].splitlines()[-1] for r in records if r["outcome"] == outcome]
        shapes = Counter(map(shape_of, said))
        lines += [f"\n{outcome}:", *(f"  {n:>5}  {text}" for text, n in shapes.most_common(25))]
    found = Counter(f for r in records for f in r.get("findings", ()))
    lines += ["\nfindings:", *(f"  {n:>5}  {name}" for name, n in found.most_common())]
    return "\n".join(lines)


def main() -> int:
    """Run the campaign; exit status 1 where a silent failure is found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2100)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--seed", type=int, help="run one seed and print design and record")
    parser.add_argument("--out", type=Path, default=ROOT / "exports" / "campaign.jsonl")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--again", action="store_true", help="run seeds again that failed")
    args = parser.parse_args()
    if args.seed is not None:
        print(json.dumps(design(args.seed), indent=1))
        print(json.dumps(run(args.seed), indent=1))
        return 0
    args.out.parent.mkdir(parents=True, exist_ok=True)
    records = [json.loads(line) for line in args.out.read_text().splitlines()] if args.out.exists() else []
    if args.again:
        records = [r for r in records if r["outcome"] != "FAILURE"]
        args.out.write_text("".join(json.dumps(r) + "\n" for r in records))
    known = {r["seed"] for r in records}
    seeds = [seed for seed in range(args.first, args.first + args.count) if seed not in known]
    print(f"seeds {args.first} .. {args.first + args.count - 1}: {len(seeds)} to run")
    context = multiprocessing.get_context("forkserver")
    with context.Pool(args.jobs, maxtasksperchild=200) as pool, args.out.open("a") as file:
        for record in pool.imap_unordered(run, seeds, chunksize=4):
            records.append(record)
            file.write(json.dumps(record) + "\n")
            file.flush()
            if record["outcome"] == "FAILURE":
                print(f"seed {record['seed']} ({record['kind']}): {record['why']}", flush=True)
    wanted = set(range(args.first, args.first + args.count))
    records = [r for r in records if r["seed"] in wanted]
    print(summary(records))
    return int(any(r["outcome"] == "FAILURE" for r in records))


if __name__ == "__main__":
    sys.exit(main())
