"""Best laws of random requirements: what each takes, how near its bound is, how far it exceeds a limit.

    python scripts/law_campaign.py [--laws 300] [--seed 1] [--against FILE] [--out FILE]

Jerk limits from 45 to 300, bands from 0.6 to 13, half with a limit of velocity or acceleration, some damped, some with
ends that move. Prints those that take longest, how many take over half a second of a processor, the medians, the
largest excess over a limit; --against compares with the lines of another run, law by law. Exit status 1 where a limit
is exceeded by more than 1e-9 of it, or a bound is above its law.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from time import process_time
from typing import Any

# As the command line sets it, before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
import numpy as np

from camgeom.errors import NotConverged
from camgeom.motion.optimal.best import Best, Wish, sought

LONG = 0.5
"""s of a processor; the aim for each law"""
OVER = 1e-9
"""relative; by how much a limit may be exceeded"""


def wish_of(seed: int, number: int) -> Wish:
    """A random requirement."""
    rng = np.random.default_rng([seed, number])
    low = float(rng.uniform(0.6, 7.0))
    band = (round(low, 2), round(low + float(rng.uniform(0.3, 6.0)), 2))
    asked: dict[str, Any] = {"jerk": round(float(np.exp(rng.uniform(np.log(45.0), np.log(300.0)))), 1), "band": band}
    if rng.random() < 0.25:
        asked |= {"aim": "peak-acceleration", "residual": round(float(10.0 ** rng.uniform(-2.5, -1.0)), 5)}
    else:
        asked |= {"aim": "residual"}
    limited = rng.random()
    if limited < 0.35:
        asked["velocity"] = round(float(rng.uniform(1.35, 1.95)), 3)
    if 0.25 < limited < 0.5 and asked["aim"] == "residual":
        asked["acceleration"] = round(float(rng.uniform(4.8, 9.0)), 3)
    if rng.random() < 0.2:
        asked["damping"] = round(float(rng.uniform(0.005, 0.1)), 3)
    if rng.random() < 0.15:
        asked["start"] = (round(float(rng.uniform(0.0, 0.8)), 3), 0.0)
    if rng.random() < 0.15:
        asked["end"] = (round(float(rng.uniform(0.0, 0.8)), 3), 0.0)
    return Wish(**asked)


def excess_of(found: Best) -> float:
    """By how much the law exceeds a limit at most, relative, limits that are themselves least aside."""
    wish, peaks = found.wish, found.peaks
    limits = {name: getattr(wish, name) for name in wish.given}
    return float(max(peaks[name] / limit - 1.0 for name, limit in limits.items()))


def told(number: int, wish: Wish) -> dict[str, Any]:
    """What became of one requirement."""
    begun = process_time()
    try:
        found = sought(wish)
    except NotConverged:
        return {"number": number, "time": process_time() - begun, "said": "not found"}
    line: dict[str, Any] = {"number": number, "time": process_time() - begun}
    if not isinstance(found, Best):
        return line | {"said": "impossible", "value": found.least, "bound": found.bound}
    return line | {"said": "found", "value": found.value, "bound": found.bound, "over": excess_of(found)}


def summary(lines: list[dict[str, Any]], seed: int) -> bool:
    """Print what they came to; whether all is sound."""
    times = np.array([line["time"] for line in lines])
    found = [line for line in lines if line["said"] == "found"]
    over = max(line["over"] for line in found)
    above = [line["number"] for line in found if line["bound"] > line["value"] * (1.0 + 1e-12)]
    print(f"{len(lines)} requirements, {len(found)} laws; median {np.median(times):.3f} s, 90 % "
          f"{np.quantile(times, 0.9):.3f}, slowest {times.max():.2f}, sum {times.sum():.1f}; "
          f"{np.sum(times > LONG)} over {LONG} s")  # fmt: skip
    large = [line for line in found if line["value"] > 1e-3]
    gaps = np.array([1.0 - line["bound"] / line["value"] for line in large])
    print(f"largest excess {over:.1e}; bounds above their law {above}; of {len(large)} values above 1e-3 "
          f"{np.sum(gaps > 3e-5)} bounds are further than 3e-5")  # fmt: skip
    for line in sorted(lines, key=lambda one: -one["time"])[:12]:
        print(f"  {line['time']:.2f} s  {line['said']}  {wish_of(seed, line['number'])}")
    return over <= OVER and not above


def compared(lines: list[dict[str, Any]], others: list[dict[str, Any]]) -> None:
    """Print how they differ from those of another run."""
    pairs = [(one, two) for one, two in zip(lines, others) if one["number"] == two["number"]]
    shares = np.array([one["time"] / two["time"] for one, two in pairs])
    print(f"times over the others': median {np.median(shares):.2f}, {np.sum(shares > 1.1)} slower by more than a "
          f"tenth, at most {shares.max():.2f}")  # fmt: skip
    for one, two in pairs:
        if one["said"] != two["said"]:
            print(f"  {one['number']}: {one['said']}, was {two['said']}")
        elif one["said"] == "found":
            worse = one["value"] / two["value"] - 1.0
            if abs(worse) > 1e-5 and max(one["value"], two["value"]) > 1e-6:
                print(f"  {one['number']}: {one['value']:.9g} was {two['value']:.9g} ({worse:+.1e}), bound "
                      f"{one['bound']:.9g} was {two['bound']:.9g}")  # fmt: skip
            if one["value"] < two["bound"] * (1.0 - 1e-12) or two["value"] < one["bound"] * (1.0 - 1e-12):
                print(f"  {one['number']}: A LAW IS BELOW THE OTHER'S BOUND")


def main() -> int:
    """Find them all and print what they came to."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--laws", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--against", type=Path, help="lines of another run")
    parser.add_argument("--out", type=Path, help="where the lines go, JSON")
    arguments = parser.parse_args()
    lines = []
    for number in range(arguments.laws):
        lines.append(told(number, wish_of(arguments.seed, number)))
        if arguments.out:
            arguments.out.write_text("\n".join(map(json.dumps, lines)) + "\n")
    sound = summary(lines, arguments.seed)
    if arguments.against:
        compared(lines, [json.loads(line) for line in arguments.against.read_text().splitlines()])
    return 0 if sound else 1


if __name__ == "__main__":
    sys.exit(main())
