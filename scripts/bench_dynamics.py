"""Error against time of every integrator on the indexing drive, and against scipy's general solvers.

    python scripts/bench_dynamics.py [--scipy] [--sweep]

45 degrees in 300 degrees of cam angle, modified trapezoid, from rest over two turns. Error: largest difference of the
load-plate acceleration over the second turn, a share of its peak, against gauss8 on a grid four times as fine. Time:
matrices, maps and walk, the best of three. Before that the steady state to 1e-6 and 1e-9 of the peak, and with --sweep
a hundred speeds.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from math import pi, radians
from time import perf_counter
from typing import Any

import numpy as np

from camgeom.dynamics.indexing import IndexingDrive
from camgeom.dynamics.indexing_response import output, steady_state
from camgeom.dynamics.indexing_sweep import sweep
from camgeom.dynamics.indexing_system import TorsionSystem
from camgeom.dynamics.integrators import INTEGRATORS
from camgeom.dynamics.integrators_accuracy import Accuracy
from camgeom.dynamics.integrators_grid import Grid, aligned_grid
from camgeom.dynamics.integrators_solution import Solution
from camgeom.dynamics.integrators_solve import transient
from camgeom.errors import NotConverged
from camgeom.motion import Program, Segment

RPM = pi / 30.0
SPEEDS = (655.64, 1639.10, 3000.0)
STEPS = (120, 240, 480, 960, 1920)
SOLVERS = (("DOP853", 1e-6), ("DOP853", 1e-9), ("Radau", 1e-6), ("LSODA", 1e-6), ("LSODA", 1e-9))
DRIVE = IndexingDrive(
    cam_inertia=6.9996e-2,
    turret_inertia=3.471193e-3,
    load_inertia=5.9855881e-2,
    input_stiffness=1.9487e5,
    output_stiffness=3.5021e5,
    contact_stiffness=1.2329e6,
    input_damping=7.0,
    output_damping=8.7,
    contact_damping=3.9,
)


def best_of(count: int, run: Callable[[], Any]) -> tuple[Any, float]:
    """The result and the shortest of `count` times in ms."""
    times = []
    for _ in range(count):
        begin = perf_counter()
        found = run()
        times.append(perf_counter() - begin)
    return found, 1e3 * min(times)


def load(system: TorsionSystem, found: Solution) -> np.ndarray:
    """Load-plate acceleration at the nodes of the second turn."""
    values = output(system, "load_acceleration")(found.theta[None], found.position, found.rate, "right")[0]
    return values[found.grid.steps :]


def table(motion: Program, rpm: float) -> None:
    """Error (and ms) over steps a turn, one line a method."""
    system = TorsionSystem(DRIVE, motion, np.array([rpm * RPM]))
    grids = [aligned_grid(motion.knots, steps) for steps in STEPS]
    exact = [reference(system, grid) for grid in grids]
    print(f"\n{rpm:g} r/min: error of the load-plate acceleration (ms) at steps a turn")
    print(f"{'':18}" + "".join(f"{grid.steps:>17}" for grid in grids))
    for name in INTEGRATORS:
        cells = []
        for grid, right in zip(grids, exact, strict=True):
            try:
                found, ms = best_of(3, lambda grid=grid, name=name: transient(system, grid, name, turns=2))
            except NotConverged:
                cells.append("unstable")
                continue
            error = float(np.abs(load(system, found) - right).max() / np.abs(right).max())
            cells.append(f"{error:.1e} ({ms:.0f})")
        print(f"{name:18}" + "".join(f"{cell:>17}" for cell in cells), flush=True)


def reference(system: TorsionSystem, grid: Grid) -> np.ndarray:
    """The load-plate acceleration by gauss8 on a grid four times as fine, at the angles of the grid."""
    return load(system, transient(system, grid.halved().halved(), "gauss8", turns=2))[::4]


def general(motion: Program, rpm: float) -> None:
    """scipy's solvers on the same two turns, piece by piece between the knots."""
    from scipy.integrate import solve_ivp

    speed, d = rpm * RPM, DRIVE
    system = TorsionSystem(DRIVE, motion, np.array([speed]))
    grid = aligned_grid(motion.knots, 240)
    right = transient(system, grid.halved().halved(), "gauss8", turns=2)
    target, scale = right.position[0, -1], np.abs(right.position[0]).max(0)

    def motion_of(t: float, y: np.ndarray) -> np.ndarray:
        tau = motion.jet(speed * t, 2)
        q, v = y[:3], y[3:]
        torque = d.contact_stiffness * (q[1] - tau[1] * q[0])
        torque += d.contact_damping * (v[1] - tau[1] * v[0] - tau[2] * speed * q[0])
        shaft = d.output_stiffness * (q[2] - q[1]) + d.output_damping * (v[2] - v[1])
        cam = (-d.input_stiffness * q[0] - d.input_damping * v[0] + tau[1] * torque) / d.cam_inertia
        turret = (shaft - torque) / d.turret_inertia - tau[2] * speed**2
        return np.array([*v, cam, turret, -shaft / d.load_inertia - tau[2] * speed**2])

    knots = np.concatenate([motion.knots[:-1], motion.knots + 2.0 * pi]) / speed
    for name, tolerance in SOLVERS:

        def run(name: str = name, tolerance: float = tolerance) -> np.ndarray:
            y = np.zeros(6)
            for begin, end in zip(knots[:-1], knots[1:], strict=True):
                y = solve_ivp(motion_of, (begin, end), y, method=name, rtol=tolerance, atol=1e-3 * tolerance).y[:, -1]
            return y

        found, ms = best_of(1, run)
        error = float((np.abs(found[:3] - target) / scale).max())
        print(f"scipy {name:7} rtol {tolerance:g}: error {error:.1e}, {ms:.0f} ms", flush=True)


def steady(motion: Program) -> None:
    """Steady state at one speed, verified by halving, and its peak."""
    print("\nsteady state, verified by halving; ms for the state, and for the peak between the nodes")
    for rpm in SPEEDS:
        for tolerance in (1e-6, 1e-9):
            found, ms = best_of(5, lambda r=rpm, t=tolerance: steady_state(DRIVE, motion, r * RPM, Accuracy(t)))
            top, more = best_of(5, lambda response=found: response.peak("load_acceleration"))
            print(f"{rpm:8g} r/min: {ms:5.1f} + {more:4.1f} ms, {top.maximum[0]:.9g} rad/s2, {found.solution.choice}")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scipy", action="store_true", help="also scipy's general solvers (some seconds each)")
    parser.add_argument("--sweep", action="store_true", help="also a sweep over a hundred speeds")
    chosen = parser.parse_args()
    move = Segment(radians(300.0), radians(45.0), "modified-trapezoid")
    motion = Program.from_segments([move, Segment(2.0 * pi)], closed=False, angular=True)
    steady(motion)
    if chosen.sweep:
        speeds = np.linspace(200.0, 3500.0, 100) * RPM
        for tolerance in (1e-6, 1e-9):
            found, ms = best_of(2, lambda t=tolerance: sweep(DRIVE, motion, speeds, Accuracy(t)))
            print(f"sweep of 100 speeds to {tolerance:g}: {ms / 1e3:.2f} s, largest error {found.error.max():.1e}")
    for rpm in SPEEDS:
        table(motion, rpm)
        if chosen.scipy:
            general(motion, rpm)


if __name__ == "__main__":
    main()
