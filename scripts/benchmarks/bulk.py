"""Studies of many variants by the batch, rows written to Parquet, against the exact model, one variant at a time."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any

from kit import ROOT, Row, Table, run, short

from camgeom.profile import read_data
from camgeom.profile.text import dump

SEVEN = (
    "flank.max_pressure_angle_deg", "flank.undercut_margin", "flank.min_relative_radius_mm", "contact.peak_force_n",
    "contact.peak_pressure_mpa", "contact.peak_torque_n_m", "fatigue.cam_life_h",
)  # fmt: skip
VARIED = ("cam.base_radius=30:60", "roller.diameter=12:30", "operation.speed=100:600")


def disc() -> dict[str, Any]:
    """The shipped disc with a cylindrical roller, without its press."""
    data = read_data(ROOT / "profiles" / "disc_offset_roller.toml")
    operation = {key: value for key, value in data["operation"].items() if key != "force"}
    return {**data, "operation": operation, "roller": {"shape": "cylinder", "diameter": 22, "length": 12}}


def study(profile: Path, folder: Path, *words: str) -> tuple[float, float]:
    """Wall time and time of all processors of one study, s."""
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), perf_counter()
    vary = [word for one in VARIED for word in ("--vary", one)]
    command = [sys.executable, "-m", "camgeom", "study", str(profile), *vary, "--out", str(folder), *words]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])}
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return perf_counter() - began, used


def tables(quick: bool) -> list[Table]:
    """Discs: seven figures, and all that are offered; and the exact model on some of the same variants."""
    rows: list[Row] = []
    cases: list[tuple[str, int, tuple[str, ...]]] = [
        ("seven figures", 50_000 if quick else 1_000_000, ("--figures", ",".join(SEVEN))),
        ("all figures", 10_000 if quick else 100_000, ()),
    ]
    with tempfile.TemporaryDirectory() as place:
        profile = Path(place) / "disc.toml"
        profile.write_text(dump(disc()))
        few = 100
        model, _ = study(profile, Path(place) / "exact", "--sample", f"sobol:{few}", "--exact", "--jobs", "1")
        for name, count, words in cases:
            wall, used = study(profile, Path(place) / name, "--sample", f"sobol:{count}", "--parquet", *words)
            size = (Path(place) / name / "study.parquet").stat().st_size
            row: dict[str, Any] = {"discs": name, "variants": count, "wall_s": short(wall, 3)}
            row |= {"processors_s": short(used, 3), "us_a_variant": short(used / count * 1e6, 3)}
            row |= {"exact_ms": short(model / few * 1e3, 3), "gain": short(model / few / (used / count), 3)}
            row |= {"peak_memory_mb": memory(), "file_mb": short(size / 1e6, 3)}
            rows.append(row)
    note = (
        "wall and time of all processors of the whole command, start of the workers and the Parquet file included; "
        "exact: one process, a variant, all its checks; gain: of processor time; memory: of the largest process."
    )
    return [Table("bulk", "Many variants at once", rows, note)]


def memory() -> float:
    """Peak memory of the largest process so far, MB."""
    return short(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3, 3)


if __name__ == "__main__":
    run(tables, __doc__)
