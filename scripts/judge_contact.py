#!/usr/bin/env python3
"""The half-space contact against tamaas (PyPI), which solves the same cells by other code: tilt, ends, crowns.

    python scripts/judge_contact.py

Needs tamaas, a development-only oracle: `pip install tamaas`. It judges the algebra (influence, convolution, the loaded
cells), not what a half-space leaves out at a free end.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from camgeom.mechanics.finite_contact import AxialProfile, Bodies  # noqa: E402
from camgeom.mechanics.halfspace import Even, pressed  # noqa: E402

COMPLIANCE = 8.7e-6
LENGTH = 12.0
AGREES = 1e-6
CASES: dict[str, tuple[Bodies, float, float, tuple[int, int]]] = {
    # bodies, load N, width of the window mm, cells
    "sharp ends": (Bodies(0.1, AxialProfile(-6.0, 6.0), COMPLIANCE), 500.0, 0.4, (32, 64)),
    "sharp ends, tilted": (Bodies(0.1, AxialProfile(-6.0, 6.0), COMPLIANCE, 2e-4), 500.0, 0.6, (64, 64)),
    "crown": (Bodies(0.1, AxialProfile(-6.0, 6.0, 500.0), COMPLIANCE), 500.0, 0.5, (64, 64)),
    "crown tilted to its end": (Bodies(0.1, AxialProfile(-6.0, 6.0, 500.0), COMPLIANCE, 9e-3), 500.0, 0.5, (64, 64)),
    "crown twisted": (Bodies(0.1, AxialProfile(-6.0, 6.0, 800.0), COMPLIANCE, 1e-3, 0.05), 500.0, 0.8, (64, 64)),
    "logarithmic, tilted": (
        Bodies(0.1, AxialProfile(-6.0, 6.0, run_out=0.002), COMPLIANCE, 3e-4), 500.0, 0.6, (64, 64)
    ),
}


def judged(case: str) -> float:
    """Largest difference of the pressures over the largest pressure. Raises ImportError without tamaas."""
    tm = importlib.import_module("tamaas")
    tm.set_log_level(tm.LogLevel.error)
    bodies, load, wide, (n, m) = CASES[case]
    dx, dy = wide / n, LENGTH / m
    x, y = (np.arange(n) + 0.5) * dx - 0.5 * wide, (np.arange(m) + 0.5) * dy - 0.5 * LENGTH
    gap = bodies.gap(x, y)
    model = tm.ModelFactory.createModel(tm.model_type.basic_2d, [wide, LENGTH], [n, m])
    model.E, model.nu = 1.0 / bodies.compliance, 0.0
    tm.ModelFactory.registerNonPeriodic(model, "dcfft")
    solver = tm.PolonskyKeerRey(model, -gap, 1e-12)
    solver.setIntegralOperator("dcfft")
    solver.solve(load / (wide * LENGTH))
    theirs = np.asarray(model.traction)
    ours = pressed(gap, Even(n, m, dx, dy, bodies.compliance), np.array(dx * dy), load, tolerance=1e-11)
    return float(np.abs(theirs - ours.pressure).max() / theirs.max())


def main() -> int:
    """Print every case; 1 where one differs by more than AGREES."""
    worst = 0.0
    for case in CASES:
        off = judged(case)
        worst = max(worst, off)
        print(f"{case:28s} {off:.1e} of the largest pressure")
    return int(worst > AGREES)


if __name__ == "__main__":
    sys.exit(main())
