"""Is the front of `camgeom optimise` as good as brute force? Hypervolumes beside those of 2^20 Sobol points.

    python scripts/front_hypervolume.py [--log2 20] [CASE ...]

Both sides are batch figures under the same bounds, so that only the search is compared. The hypervolume is the share of
the box between the best of every aim and a corner 5 % beyond the worst of both fronts. Exit status 1 where the search
falls behind by more than a hundredth of a percent of brute force. Needs pymoo (`pip install 'camgeom[optimise]'`).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from camgeom.design.front import Archive, ByBatch, search, spread, undominated
from camgeom.design.requirement import Aim, Bound, Requirement, free
from camgeom.profile import from_data, read_data

PROFILES = Path(__file__).resolve().parents[1] / "profiles"
CHUNK = 2**15
POPULATION, GENERATIONS, MEMBERS = 128, 200, 24
ALLOWED = 1e-4


@dataclass(frozen=True)
class Case:
    """A profile with some of its tables replaced, its free keys, aims and bounds."""

    profile: str
    free: tuple[str, ...]
    least: tuple[str, ...]
    under: tuple[tuple[str, float], ...] = ()
    over: tuple[tuple[str, float], ...] = ()
    edit: Callable[[dict[str, Any]], dict[str, Any]] = dict

    def requirement(self) -> Requirement:
        """What is sought."""
        data = self.edit(read_data(PROFILES / f"{self.profile}.toml"))
        sides = ((1.0, self.under), (-1.0, self.over))
        bounds = tuple(Bound(name, sign, value, "case") for sign, given in sides for name, value in given)
        aims = tuple(Aim(name, 1.0) for name in self.least)
        return Requirement(data, "", tuple(map(free, self.free)), aims, bounds)


def without(data: dict[str, Any], *tables: str, **replaced: Any) -> dict[str, Any]:
    """The data with some tables left out and others replaced."""
    return {key: value for key, value in {**data, **replaced}.items() if key not in tables}


def plain_disc(data: dict[str, Any]) -> dict[str, Any]:
    """With a cylindrical roller."""
    return without(data, roller={"shape": "cylinder", "diameter": 22, "length": 12})


ANGLE, MARGIN = "flank.max_pressure_angle_deg", "flank.undercut_margin"
PRESSURE, FORCE, TORQUE = "contact.peak_slice_pressure_mpa", "contact.least_force_n", "contact.peak_torque_n_m"
SIZE = "blank.volume_mm3"
CASES = {
    "disc": Case(
        "disc_offset_roller",
        ("cam.base_radius=20:60", "roller.diameter=8:40", "follower.offset=-15:15", "cam.width=6:30"),
        (SIZE, PRESSURE, ANGLE), ((ANGLE, 30.0),), ((MARGIN, 0.0), (FORCE, 0.0)), plain_disc,
    ),
    "drum": Case(
        "pin_insertion",
        ("cam.diameter=110:180", "roller.diameter=12:32", "cam.groove_depth=8:20", "cam.start=14:30"),
        (SIZE, PRESSURE), ((ANGLE, 70.0),), ((MARGIN, 0.0),),
    ),
    "conjugate": Case(
        "conjugate_rocker",
        ("cam.base_radius=105:160", "roller.diameter=20:70", "follower.arm=70:110", "cam.center_distance=195:240"),
        (SIZE, PRESSURE), ((ANGLE, 45.0),), ((MARGIN, 0.0),), lambda data: without(data, "impact"),
    ),
}  # fmt: skip


def brute(requirement: Requirement, evaluate: ByBatch, log2: int) -> Archive:
    """Every Sobol point that keeps the bounds, thinned to fronts of chunks on the way."""
    from scipy.stats.qmc import Sobol

    sobol = Sobol(len(requirement.free), seed=2)
    kept: list[tuple[Any, dict[str, Any]]] = []
    for _ in range(2**log2 // CHUNK):
        shares = sobol.random(CHUNK)
        figures, exist = evaluate(requirement.points(shares))
        good = np.flatnonzero(exist & np.all(requirement.excess(figures) <= 0.0, axis=1))
        good = good[undominated(requirement.scores(figures)[good])]
        kept.append((shares[good], {name: figures[name][good] for name in requirement.figures}))
    merged = {name: np.concatenate([part[name] for _, part in kept]) for name in requirement.figures}
    return Archive(requirement, 2**log2, np.concatenate([shares for shares, _ in kept]), merged)


def main(argv: list[str] | None = None) -> int:
    """Print a line for each side of every case; the exit status."""
    from moocore import hypervolume

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("case", nargs="*", help=f"default all: {', '.join(CASES)}")
    parser.add_argument("--log2", type=int, default=20, help="brute force has 2 to this many points, default 20")
    arguments = parser.parse_args(argv)
    behind = False
    for name in arguments.case or CASES:
        requirement = CASES[name].requirement()
        evaluate = ByBatch(from_data(requirement.data, ""), requirement)
        began = perf_counter()
        found = search(requirement, evaluate, POPULATION, GENERATIONS, lambda count: None)
        between = perf_counter()
        all_ = brute(requirement, evaluate, arguments.log2)
        times = between - began, perf_counter() - between
        scores = [requirement.scores(side.figures)[side.front()] for side in (found, all_)]
        both = np.concatenate(scores)
        low, high = both.min(axis=0), both.max(axis=0)
        corner = high + 0.05 * (high - low)
        shown = scores[0][spread(scores[0], np.arange(len(scores[0])), MEMBERS)]
        volumes = [hypervolume((s - low) / (corner - low), ref=np.ones(len(low))) for s in (*scores, shown)]
        print(f"{name}: least {', '.join(CASES[name].least)}")
        for words, points, front, volume, took in (
            ("brute force", all_.evaluated, len(scores[1]), volumes[1], times[1]),
            ("search", found.evaluated, len(scores[0]), volumes[0], times[0]),
            ("members shown", inf, len(shown), volumes[2], 0.0),
        ):
            looked = f"{points:9.0f} points {took:7.1f} s" if took else " " * 26
            print(f"  {words:14s} {looked}  front of {front:5d}  hypervolume {volume:.6f}")
        behind |= volumes[0] < volumes[1] * (1.0 - ALLOWED)
    return int(behind)


if __name__ == "__main__":
    sys.exit(main())
