"""Speed and accuracy of the contact solver with clearance, as ratios against general solvers in the same run.

python scripts/bench_impact.py            the mechanism B1, one turn, and a study of 64 clearances
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from camgeom.dynamics.impact import Regime, State
from camgeom.dynamics.impact_fixed import solve_fixed
from camgeom.dynamics.impact_rates import Machine
from camgeom.dynamics.impact_reference import b1_problem
from camgeom.dynamics.impact_run import solve
from camgeom.dynamics.impact_solver import LONGEST_STEP
from camgeom.dynamics.impact_study import clearance_study
from camgeom.errors import NotConverged

END = math.radians(140.0)


def timed(work: Callable[[], Any], repeat: int = 3) -> tuple[float, Any]:
    """Least time in seconds of a few calls, and the last result."""
    best, made = math.inf, None
    for _ in range(repeat):
        start = time.perf_counter()
        made = work()
        best = min(best, time.perf_counter() - start)
    return best, made


def general(contact: str, clearance: float, method: str, rtol: float) -> float:
    """Peak acceleration by a general solver on the same equations without events, 0 where it loses the contact.

    The force law switches inside the right-hand side, and the approach speed is latched when a call first finds the
    roller inside, as simple programs do. The steps are bounded by 1 degree of the cam, or contacts would be missed.
    """
    from scipy.integrate import solve_ivp

    problem = b1_problem(clearance, contact=contact)
    machine = Machine(problem)
    lift, w, factor = machine.lift, problem.speed, machine.factor
    latch = [0.0, 0.0]
    regimes = [Regime(State.FREE, k, start / w, 1.0, False) for k, start in enumerate(lift.starts)]

    def force(t: float, eta: float, rate: float) -> tuple[float, float]:
        arc = lift.arc_at(w * t)
        x = w * t - lift.starts[arc]
        s0, s1, s2 = machine.jets.jets[arc](x)
        torque = 0.0
        for which in (0, 1):
            if machine.depth(which, regimes[arc], t, complex(eta, rate))[0] <= 0.0:
                latch[which] = 0.0
                continue
            try:
                delta, h, g, _, _, bend = machine.touches[which](arc, x, s0, s1, s2, eta)
            except NotConverged:
                # A trial stage far inside the cam: a push that the step control must refuse.
                return math.copysign(1e9, -eta), s2 * w * w
            speed = g * w - h * (s1 * w + rate)
            if latch[which] == 0.0:
                latch[which] = max(speed, 1e-3)
            torque += h * max(problem.law.force(delta, bend) * (1.0 + factor * speed / latch[which]), 0.0)
        return torque / problem.inertia, s2 * w * w

    def right(t: float, y: Any) -> tuple[float, float]:
        push, ideal = force(t, float(y[0]), float(y[1]))
        return float(y[1]), push - ideal

    atol = [rtol * machine.eta_scale, rtol * machine.rate_scale]
    start = [problem.pair.middle(0.0), 0.0]
    times = np.linspace(0.0, END / w, 20_001)
    try:
        made = solve_ivp(right, (0.0, END / w), start, method, times, rtol=rtol, atol=atol, max_step=LONGEST_STEP / w)
        return max(abs(force(float(t), float(a), float(b))[0]) for t, a, b in zip(times, *made.y, strict=True))
    except NotConverged:
        return 0.0


def contact_cost() -> None:
    """Cost of the parts of the right-hand side."""
    machine = Machine(b1_problem(1e-4))
    jets, touch, law = machine.jets, machine.touches[0], machine.problem.law.force
    jet = jets.at(0, 0.5)
    regime = Regime(State.MAIN, 0, 0.0, 0.1, False)
    rate = machine.rate(regime)
    parts: list[tuple[str, Callable[[], object]]] = [
        ("motion", lambda: jets.jets[0](0.5)),
        ("contact", lambda: touch(0, 0.5, *jet, -1e-5)),
        ("law", lambda: law(1e-5, 0.0)),
        ("whole", lambda: rate(0.008, -1e-5 + 0.1j)),
    ]
    shown = []
    for name, part in parts:
        spent, _ = timed(lambda part=part: [part() for _ in range(2000)])  # type: ignore[misc]
        shown.append(f"{name} {spent / 2000 * 1e6:.1f} us")
    print("right-hand side:", ", ".join(shown))
    alone, _ = timed(lambda: [rate(0.008, -1e-5 + 0.1j) for _ in range(2000)])
    run_time, run = timed(lambda: solve(machine.problem))
    share = alone / 2000 * run.recorded.calls / run_time
    print(
        f"right-hand sides take {100 * share:.0f} % of the {run_time:.3f} s of a turn: that is the most a compiled "
        "kernel could save,\nwhich does not pay for a compiler at install time or 200 MB of wheels"
    )


def one_turn() -> None:
    """Accuracy and time of the event solver."""
    print("\none turn of B1 at 600 r/min, rtol 1e-9")
    print("contact     c mm   solve s  peaks s  steps  calls  peak acc      change at 1e-10  energy residual")
    for contact in ("power-soft", "hertz"):
        for clearance in (1e-5, 1e-4, 1e-3):
            problem = b1_problem(clearance, contact=contact)
            spent, run = timed(lambda problem=problem: solve(problem))  # type: ignore[misc]
            start = time.perf_counter()
            peak = run.peak("acceleration").value
            peaks = time.perf_counter() - start
            tight = solve(problem, rtol=1e-10).peak("acceleration").value
            made = run.recorded
            print(
                f"{contact:10} {1e3 * clearance:5g} {spent:9.3f} {peaks:8.3f} {len(made.steps):6} {made.calls:6} "
                f"{peak:12.3f} {abs(peak / tight - 1):12.1e} {run.energy.relative_residual:18.1e}"
            )


def against_general(contact: str = "power-soft") -> None:
    """The first 140 degrees against scipy without events."""
    print("\nfirst 140 degrees against general solvers without events (the same right-hand side)")
    for clearance in (1e-4, 1e-3):
        problem = b1_problem(clearance, contact=contact)
        mine, run = timed(lambda problem=problem: solve(problem, end_angle=END))  # type: ignore[misc]
        exact = solve(problem, end_angle=END, rtol=1e-11).peak("acceleration").value
        error = abs(run.peak("acceleration").value / exact - 1)
        print(f"c = {1e3 * clearance:g} mm: event solver {mine:.3f} s, peak error {error:.1e}")
        for method, rtol in (("DOP853", 1e-8), ("DOP853", 1e-11), ("RK45", 1e-8), ("LSODA", 1e-8), ("Radau", 1e-8)):
            spent, peak = timed(lambda m=method, r=rtol, c=clearance: general(contact, c, m, r), 1)  # type: ignore[misc]
            told = f"peak error {abs(peak / exact - 1):.1e}" if peak else "the contact is lost"
            print(f"   {method:7} rtol {rtol:g}: {spent / mine:6.1f} x the time, {told}")


def studies() -> None:
    """64 clearances, on one and on all processors, and the fixed-step method."""
    print("\n64 clearances from 0.001 to 1 mm, two turns each")
    problem = b1_problem(1e-4)
    options: dict[str, Any] = {"count": 64, "turns": 2, "tighter": False}
    spent, rows = timed(lambda: clearance_study(problem, **options), 1)
    alone, same = timed(lambda: clearance_study(problem, workers=1, **options), 1)
    print(f"all processors {spent:.1f} s, one {alone:.1f} s: {alone / spent:.2f} times; rows equal: {rows == same}")
    fixed, _ = timed(lambda: solve_fixed(problem, [row.clearance for row in rows], end_angle=0.1), 1)
    whole = fixed * 4.0 * math.pi / 0.1
    print(f"fixed step 1e-5 s, all together: {whole:.0f} s for two turns, {whole / alone:.1f} x the one process")


if __name__ == "__main__":
    contact_cost()
    one_turn()
    against_general()
    studies()
