"""Many variants at once: the batch on two processes against the exact study of the same variants, one by one.

Drums and indexers as they are shipped, six figures and all; wall times and processor times, since machines are shared.
"""

from __future__ import annotations

import resource
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from time import perf_counter, process_time
from typing import Any

import numpy as np
from kit import Table, run, short

from camgeom.checks import light_checks
from camgeom.design.batch import evaluate, offered
from camgeom.design.study import Study, axis
from camgeom.profile import from_data, read_data
from camgeom.report.measured import STUDIED, measure

SIX = (
    "flank.max_pressure_angle_deg", "flank.undercut_margin", "flank.min_relative_radius_mm",
    "contact.peak_torque_n_m",
)  # fmt: skip
CASES: dict[str, tuple[str, tuple[str, ...], dict[str, tuple[float, float]]]] = {
    "drum, two moves": (
        "milled_drum", ("contact.peak_pressure_mpa", "contact.peak_force_n", "fatigue.cam_life_h"),
        {"cam.diameter": (90, 130), "cam.groove_depth": (10.5, 14), "roller.diameter": (14, 24),
         "motion[1].until": (180, 220), "motion[1].to": (20, 35), "follower.mass": (0.5, 3),
         "operation.speed": (100, 400)},
    ),
    "drum, published": (
        "pin_insertion", ("contact.peak_pressure_mpa", "contact.peak_force_n", "fatigue.cam_life_h"),
        {"cam.diameter": (134, 145), "roller.diameter": (16, 24), "roller.length": (8, 13),
         "operation.speed": (300, 700), "follower.mass": (1, 4)},
    ),
    "drum, arm": (
        "steep_shuttle", ("contact.peak_pressure_mpa", "contact.peak_force_n", "fatigue.cam_life_h"),
        {"cam.diameter": (150, 200), "follower.arm": (75, 110), "follower.start_angle": (-25, -15),
         "roller.diameter": (16, 28), "motion[1].to": (25, 45), "follower.inertia": (0.005, 0.05),
         "operation.speed": (100, 400)},
    ),
    "barrel indexer": (
        "barrel_indexer", ("contact.peak_slice_pressure_mpa", "fatigue.cam_life_h"),
        {"cam.center_distance": (144, 152), "cam.width": (60, 90), "cam.diameter": (110, 150),
         "roller.diameter": (20, 40), "roller.length": (10, 20), "follower.inertia": (0.5, 3),
         "operation.speed": (50, 200), "motion[1].until": (200, 300)},
    ),
    "globoidal indexer": (
        "tool_changer", ("contact.peak_slice_pressure_mpa", "fatigue.cam_life_h"),
        {"cam.center_distance": (165, 200), "cam.width": (60, 100), "follower.pitch_radius": (78, 85),
         "roller.diameter": (22, 36), "roller.length": (20, 30), "operation.speed": (50, 200),
         "motion[1].until": (200, 300)},
    ),
    "parallel plates": (
        "parallel_index", ("contact.peak_slice_pressure_mpa", "fatigue.cam_life_h"),
        {"cam.center_distance": (137, 146), "cam.diameter": (208, 226), "follower.pitch_radius": (78, 82),
         "roller.diameter": (22, 28), "follower.inertia": (0.1, 0.6), "operation.speed": (50, 150),
         "motion[1].until": (280, 300)},
    ),
}  # fmt: skip
PART = 25_000


def data_of(name: str) -> dict[str, Any]:
    """A shipped profile without what a batch leaves to the exact model: a cylinder in place of a conical roller."""
    data = read_data(f"profiles/{name}.toml")
    if data["roller"]["shape"] == "cone":
        del data["roller"]["half_angle"]
        data["roller"]["shape"] = "cylinder"
    return {key: value for key, value in data.items() if key not in ("dynamics", "cutter")}


def part(case: str, figures: tuple[str, ...], level: float, size: int, seed: int) -> tuple[int, float, int]:
    """Variants that exist, processor time, s, and peak memory, kB, of one part of the random variants."""
    name, _, ranges = CASES[case]
    rng = np.random.default_rng(seed)
    columns = {key: rng.uniform(low, high, size) for key, (low, high) in ranges.items()}
    began = process_time()
    batch = evaluate(from_data(data_of(name)), columns, figures, level)
    spent = process_time() - began
    return int((batch.reason == 0).sum()), spent, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def exact(case: str, count: int) -> float:
    """Processor time, s, of the exact study of one variant, the mean of some."""
    name, _, ranges = CASES[case]
    rng = np.random.default_rng(1)
    began = process_time()
    for _ in range(count):
        axes = tuple(axis(f"{key}={float(rng.uniform(low, high))!r}") for key, (low, high) in ranges.items())
        study = Study(data_of(name), "", axes, partial(measure, products=STUDIED, checks=light_checks()))
        study.row(tuple(one.values[0] for one in axes))
    return (process_time() - began) / count


def tables(quick: bool) -> list[Table]:
    """A row a cam, a set of figures and, for indexers, a level."""
    rows = []
    with ProcessPoolExecutor(2) as pool:
        for case, (name, more, _) in CASES.items():
            alone = exact(case, 4 if quick else 20)
            every = offered(from_data(data_of(name)))
            levels = (1e-2, 3e-3) if "indexer" in case else (1e-3,)
            for figures, level in [*((SIX + more, level) for level in levels), (every, levels[-1])]:
                total = 4_000 if quick else (1_000_000 if figures is not every else 100_000)
                parts = [min(PART, total // 2)] * (total // min(PART, total // 2))
                began = perf_counter()
                jobs = [pool.submit(part, case, figures, level, size, seed) for seed, size in enumerate(parts)]
                found = [job.result() for job in jobs]
                wall = perf_counter() - began
                spent = sum(one[1] for one in found)
                rows.append({
                    "cam": case, "figures": len(figures), "level": level, "variants": sum(parts),
                    "exist": sum(one[0] for one in found), "wall_s": short(wall),
                    "processor_us_each": short(1e6 * spent / sum(parts)), "exact_ms_each": short(1e3 * alone),
                    "ratio": round(alone * sum(parts) / spent),
                    "memory_mb": round(max(one[2] for one in found) / 1e3),
                })  # fmt: skip
    note = ("Times of two processes; the exact model computes all of its figures and its light checks of every "
            "variant. Memory is the largest of a process.")
    return [Table("batch", "The batch on two processes against the exact study", rows, note)]


if __name__ == "__main__":
    run(tables, __doc__)
