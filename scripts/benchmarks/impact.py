"""Contact with clearance: accuracy and time of the event solver, beside general solvers, and studies on both cores.

The mechanism B1 at 600 r/min.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable
from typing import Any

import numpy as np
from kit import Row, Table, best, run, short

from camgeom.dynamics.impact.problem import Regime, State
from camgeom.dynamics.impact.rates import CompiledProblem
from camgeom.dynamics.impact.run import solve
from camgeom.dynamics.impact.solver import LONGEST_STEP
from camgeom.dynamics.impact.study import clearance_study
from camgeom.errors import NotConverged
from camgeom.validation.fixed_step import solve_fixed
from tests.reference.impact_reference import b1_problem

END = math.radians(140.0)


def general(contact: str, clearance: float, method: str, rtol: float) -> float:
    """Peak acceleration by a general solver on the same equations without events, 0 where it loses the contact.

    The force law switches inside the right-hand side, and the approach speed is latched when a call first finds the
    roller inside, as simple programs do. The steps are bounded by 1 degree of the cam, or contacts would be missed.
    """
    from scipy.integrate import solve_ivp

    problem = b1_problem(clearance, contact=contact)
    machine = CompiledProblem(problem)
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


def contact_cost() -> list[Row]:
    """Cost of the parts of the right-hand side, and its share of a turn."""
    machine = CompiledProblem(b1_problem(1e-4))
    jets, touch, law = machine.jets, machine.touches[0], machine.problem.law.force
    jet = jets.at(0, 0.5)
    regime = Regime(State.MAIN, 0, 0.0, 0.1, False)
    rate = machine.rate(regime)
    parts: dict[str, Callable[[], object]] = {
        "motion": lambda: jets.jets[0](0.5),
        "contact": lambda: touch(0, 0.5, *jet, -1e-5),
        "law": lambda: law(1e-5, 0.0),
        "right-hand side": lambda: rate(0.008, -1e-5 + 0.1j),
    }
    rows: list[Row] = []
    turn, made = best(lambda: solve(machine.problem), 3)
    for name, part in parts.items():
        spent, _ = best(lambda p=part: [p() for _ in range(2000)], 3)
        rows.append({"part": name, "time_us": short(spent / 2000 * 1e6)})
    rows[-1]["share_of_a_turn_percent"] = short(100.0 * rows[-1]["time_us"] * 1e-6 * made.recorded.calls / turn, 3)
    return rows


def one_turn() -> list[Row]:
    """Accuracy and time of the event solver over one turn."""
    rows: list[Row] = []
    for contact in ("power-soft", "hertz"):
        for clearance in (1e-5, 1e-4, 1e-3):
            problem = b1_problem(clearance, contact=contact)
            spent, made = best(lambda p=problem: solve(p), 3)
            peaks, peak = best(lambda r=made: r.peak("acceleration").value, 1)
            tight = solve(problem, rtol=1e-10).peak("acceleration").value
            rows.append({
                "contact": contact, "clearance_mm": 1e3 * clearance, "solve_s": short(spent, 3),
                "peaks_s": short(peaks, 3), "steps": len(made.recorded.steps), "calls": made.recorded.calls,
                "peak_rad_s2": f"{peak:.6g}", "change_at_ten_times_tighter": short(abs(peak / tight - 1), 2),
                "energy_residual": short(abs(made.energy.relative_residual), 2),
            })
    return rows


def against_general(quick: bool) -> list[Row]:
    """The first 140 degrees beside scipy without events."""
    rows: list[Row] = []
    for clearance in (1e-4,) if quick else (1e-4, 1e-3):
        problem = b1_problem(clearance, contact="power-soft")
        mine, made = best(lambda p=problem: solve(p, end_angle=END), 3)
        exact = solve(problem, end_angle=END, rtol=1e-11).peak("acceleration").value
        error = abs(made.peak("acceleration").value / exact - 1)
        rows.append({"clearance_mm": 1e3 * clearance, "solver": "camgeom, events", "rtol": 1e-9,
                     "time_s": short(mine, 3), "times_ours": 1.0, "peak_error": short(error, 2)})
        for method, rtol in (("DOP853", 1e-8), ("DOP853", 1e-11), ("RK45", 1e-8), ("LSODA", 1e-8), ("Radau", 1e-8)):
            spent, peak = best(lambda m=method, r=rtol, c=clearance: general("power-soft", c, m, r), 1)
            told = short(abs(peak / exact - 1), 2) if peak else "the contact is lost"
            rows.append({"clearance_mm": 1e3 * clearance, "solver": f"scipy {method}", "rtol": rtol,
                         "time_s": short(spent, 3), "times_ours": short(spent / mine, 3), "peak_error": told})
    return rows


def studies(quick: bool) -> list[Row]:
    """Many clearances, on one and on all processors, and the fixed-step method for as many."""
    problem = b1_problem(1e-4)
    options: dict[str, Any] = {"count": 16 if quick else 64, "turns": 2, "tighter": False}
    spent, found = best(lambda: clearance_study(problem, **options), 1)
    alone, same = best(lambda: clearance_study(problem, workers=1, **options), 1)
    fixed, _ = best(lambda: solve_fixed(problem, [row.clearance for row in found], end_angle=0.1), 1)
    return [
        {"way": "one process", "time_s": short(alone), "gain": 1.0, "same_rows": True},
        {"way": f"all {os.cpu_count()} processors", "time_s": short(spent), "gain": short(alone / spent, 3),
         "same_rows": found == same},
        {"way": "fixed step 1e-5 s, all together (scaled from 0.1 rad)", "time_s": short(fixed * 4.0 * math.pi / 0.1),
         "gain": short(alone / (fixed * 4.0 * math.pi / 0.1), 3), "same_rows": False},
    ]


def tables(quick: bool) -> list[Table]:
    """One turn, general solvers, studies, parts."""
    lost = "general: the same forces without events, steps of at most one degree; the right-hand side switches inside."
    count = 16 if quick else 64
    share = "The share is the most a compiled kernel could save."
    return [
        Table("impact_turn", "One turn of B1, rtol 1e-9", one_turn()),
        Table("impact_general", "First 140 degrees beside general solvers", against_general(quick), lost),
        Table("impact_study", f"{count} clearances from 0.001 to 1 mm, two turns each", studies(quick)),
        Table("impact_parts", "Cost of one right-hand side", contact_cost(), share),
    ]


if __name__ == "__main__":
    run(tables, __doc__)
