"""Indexing drive: error against time of every integrator, and against scipy's general solvers; steady states; sweeps.

45 degrees in 300 degrees of cam angle, modified trapezoid, from rest over two turns. Error: largest difference of the
load-plate acceleration over the second turn, a share of its peak, against gauss8 on a grid four times as fine. Time:
matrices, maps and walk, the best of three.
"""

from __future__ import annotations

from math import pi, radians

import numpy as np
from kit import Plot, Row, Table, best, milli, run, short
from scipy.integrate import solve_ivp

from camgeom.dynamics.indexing.drive import IndexingDrive
from camgeom.dynamics.indexing.response import steady_state, sweep
from camgeom.dynamics.indexing.system import TorsionSystem
from camgeom.dynamics.linear.accuracy import Accuracy
from camgeom.dynamics.linear.method import INTEGRATORS
from camgeom.dynamics.linear.response import output
from camgeom.dynamics.linear.solve import Solution, transient
from camgeom.dynamics.linear.walk import TurnGrid, aligned_grid
from camgeom.errors import NotConverged
from camgeom.motion import Program, Segment

RPM = pi / 30.0
SPEEDS = (655.64, 1639.10, 3000.0)
STEPS = (120, 240, 480, 960, 1920)
SOLVERS = (("DOP853", 1e-6), ("DOP853", 1e-9), ("Radau", 1e-6), ("LSODA", 1e-6), ("LSODA", 1e-9))
GENERAL = "scipy: angles at the end of the second turn, a share of their largest; piece by piece between the knots."
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


def load(system: TorsionSystem, found: Solution) -> np.ndarray:
    """Load-plate acceleration at the nodes of the second turn."""
    values = output(system, "load_acceleration")(found.theta[None], found.position, found.rate, "right")[0]
    return values[found.grid.steps :]


def integrators(motion: Program, rpm: float, quick: bool) -> list[Row]:
    """A row a method and a number of steps; a method that is unstable at that step is left out of the picture."""
    system = TorsionSystem(DRIVE, motion, np.array([rpm * RPM]))
    rows: list[Row] = []
    for steps in STEPS[::2] if quick else STEPS:
        grid = aligned_grid(motion.knots, steps)
        right = reference(system, grid)
        for name in INTEGRATORS:
            row: Row = {"speed_rpm": rpm, "method": name, "steps": grid.steps}
            try:
                seconds, found = best(lambda g=grid, n=name: transient(system, g, n, turns=2), 3)
            except NotConverged:
                rows.append(row | {"error": "unstable", "time_ms": ""})
                continue
            error = float(np.abs(load(system, found) - right).max() / np.abs(right).max())
            rows.append(row | {"error": short(error, 3), "time_ms": milli(seconds)})
    return rows


def reference(system: TorsionSystem, grid: TurnGrid) -> np.ndarray:
    """The load-plate acceleration by gauss8 on a grid four times as fine, at the angles of the grid."""
    return load(system, transient(system, grid.halved().halved(), "gauss8", turns=2))[::4]


def general(motion: Program, rpm: float) -> list[Row]:
    """scipy's solvers on the same two turns, piece by piece between the knots."""
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
    rows: list[Row] = []
    for name, tolerance in SOLVERS:

        def solve(name: str = name, tolerance: float = tolerance) -> np.ndarray:
            y = np.zeros(6)
            for begin, end in zip(knots[:-1], knots[1:], strict=True):
                y = solve_ivp(motion_of, (begin, end), y, method=name, rtol=tolerance, atol=1e-3 * tolerance).y[:, -1]
            return y

        seconds, found = best(solve, 1)
        error = float((np.abs(found[:3] - target) / scale).max())
        rows.append({"speed_rpm": rpm, "method": f"scipy {name}", "steps": f"rtol {tolerance:g}",
                     "error": short(error, 3), "time_ms": milli(seconds)})
    return rows


def steady(motion: Program) -> list[Row]:
    """Steady state at one speed, verified by halving, and its peak between the nodes."""
    rows: list[Row] = []
    for rpm in SPEEDS:
        for tolerance in (1e-6, 1e-9):
            seconds, found = best(lambda r=rpm, t=tolerance: steady_state(DRIVE, motion, r * RPM, Accuracy(t)), 5)
            more, top = best(lambda response=found: response.peak("load_acceleration"), 5)
            rows.append({"speed_rpm": rpm, "tolerance": tolerance, "state_ms": milli(seconds), "peak_ms": milli(more),
                         "peak_rad_s2": f"{top.maximum[0]:.9g}", "chosen": str(found.solution.choice)})
    return rows


def sweeps(motion: Program) -> list[Row]:
    """A hundred speeds in one call."""
    speeds = np.linspace(200.0, 3500.0, 100) * RPM
    rows: list[Row] = []
    for tolerance in (1e-6, 1e-9):
        seconds, found = best(lambda t=tolerance: sweep(DRIVE, motion, speeds, Accuracy(t)), 3)
        rows.append({"speeds": 100, "tolerance": tolerance, "time_s": short(seconds),
                     "largest_error": short(float(found.error.max()), 2)})
    return rows


def tables(quick: bool) -> list[Table]:
    """Integrators, general solvers, steady states, sweeps."""
    move = Segment(radians(300.0), radians(45.0), "modified-trapezoid")
    motion = Program.from_segments([move, Segment(2.0 * pi)], closed=False, angular=True)
    made = [
        Table("dynamics_steady", "Steady state at one speed, verified by halving", steady(motion)),
        Table("dynamics_sweep", "Steady states over speed", sweeps(motion)),
    ]
    plot = Plot("error", "time_ms", "method", "error of the load-plate acceleration, share of its peak", "time, ms")
    for rpm in SPEEDS[1:2] if quick else SPEEDS:
        rows = integrators(motion, rpm, quick) + ([] if quick else general(motion, rpm))
        name = f"dynamics_{rpm:.0f}"
        made.append(Table(name, f"Integrators at {rpm:g} r/min, two turns from rest", rows, GENERAL, plot))
    return made


if __name__ == "__main__":
    run(tables, __doc__)
