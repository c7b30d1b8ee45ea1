"""Contact of a profile's own follower with free play: the door from mm, N, MPa to the SI units of the impact solver."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.errors import DesignError, NotConverged, ProfileError
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme, hardest
from camgeom.maths.panels import TURN
from camgeom.mechanics.duty import least_lives
from camgeom.mechanics.material import pair_compliance
from camgeom.model.loads import carriers, load_of, ratings_of
from camgeom.model.price import ENDS, IMPACTS, STUDIES, afford, impact_steps
from camgeom.profile.solvers import refuse, with_law

if TYPE_CHECKING:
    from camgeom.dynamics.impact.pair import Pair
    from camgeom.dynamics.impact.problem import ImpactLoad, ImpactProblem
    from camgeom.dynamics.impact.run import ImpactRun, Quantity
    from camgeom.dynamics.impact.spec import ImpactSpec
    from camgeom.dynamics.impact.study import StudyRow, Unsolved
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.load import Load
    from camgeom.model import Model
    from camgeom.motion.program import Program
    from camgeom.profile import Profile
    from camgeom.solid.mechanism import Mechanism

    Duties = tuple[Duty, ...]

MILLI = 1e-3


def impact_of(profile: Profile, mechanism: Mechanism, load: Load, most: int | None = None) -> ImpactRun:
    """The follower's motion with free play between its two contacts, over the turns the profile asks for.

    most   steps that it may take (`most_steps`)

    Raises ProfileError for what the solver cannot do (`profile.solvers`), DesignError where the flanks are undercut or
    the motion jumps, NotConverged where it does not end within these steps.
    """
    from camgeom.dynamics.impact.run import solve

    spec = profile.impact_spec
    assert spec is not None
    refuse(profile, mechanism)
    return solve(impact_problem(profile, mechanism, load), turns=spec.turns, rtol=spec.tolerance, most=most)


def most_steps(model: Model) -> int | None:
    """Steps that a run may take, beside those of other followers and operating states that differ, which are solved in
    their order; None without [impact].

    All together have a purse, of which none takes more than twice its share, nor what ordinary turns of those after it
    need. Raises NotConverged before the first of them starts where ordinary turns of all would take too long.
    """
    from camgeom.dynamics.impact.solver import ORDINARY

    spec, runs = model.profile.impact_spec, model.runs
    if spec is None:
        return None
    afford(model.body, IMPACTS)
    every, mine = impact_steps(model), model._moving
    if mine not in runs:  # in no state that runs
        runs.append(mine)
    before = runs[: runs.index(mine)]
    after = (len(runs) - len(before) - 1) * spec.turns * ORDINARY
    return max(1, min(2 * every // len(runs), every - sum(map(steps_taken, before)) - after))


def steps_taken(model: Model) -> int:
    """Steps that a model's run took: all that it might where it did not end."""
    try:
        run = model.impact
    except NotConverged:
        return model.impact_most or 0
    except (DesignError, ProfileError):
        return 0
    return len(run.recorded.steps) if run is not None else 0


MOST_POINTS = 600_000
"""cam angles at which they are looked at, of all runs of a design, ten or more in every step of its solver"""
A_POINT = 1.3e-3
"""MB that they hold of one"""


def impact_duties_of(model: Model, run: ImpactRun) -> tuple[Duties, ...]:
    """The duties of all that presses the cam, in every counted turn of a run, by the code of the rigid ones.

    Raises NotConverged where the contacts of all runs of the design would take too long, or too much memory.
    """
    from camgeom.mechanics.roller_duty import RollerDuty

    profile, spec, load = model.profile, model.profile.impact_spec, model.load
    assert spec is not None
    found = []
    for turn in range(spec.settle, len(run.turn_times())):
        where, thrust = run.thrust(turn)
        acting = replace(load, solved=partial(where.at, thrust / MILLI if load.rotating else thrust), solved_on=where)
        found.append(carriers(profile.material, model.mechanism, acting, ratings_of(profile)))
    solved = [duty for duties in found for duty in duties if isinstance(duty, RollerDuty) and duty.level == "finite"]
    if solved:
        afford(model.body, ENDS)
    runs, turns = len(model.alike), spec.turns - spec.settle
    points = runs * sum(duty.force.panels.theta.size for duty in solved)
    if points > MOST_POINTS:
        raise NotConverged(
            f"contacts of rollers with stated ends ({len(solved)}, turns of [impact]: {turns}, followers and states "
            f"that differ: {runs}) at {points} cam angles, the steps of the motion, would take about "
            f"{A_POINT * points:.3g} MB, more than the {A_POINT * MOST_POINTS:.3g} MB that are spent on them: at most "
            f"{MOST_POINTS} angles, by fewer impact.turns, more that settle, or a larger impact.tolerance"
        )
    return tuple(found)


def hardest_impact(run: ImpactRun, settle: int, turns: tuple[Duties, ...]) -> Extreme:
    """Largest pressure, MPa, in the counted turns of a run, with the contact that has it.

    At the hardest place along the roller; the solver's own line pressure where that is higher, since [impact] may give
    a contact_length of its own.
    """
    since = run.turn_times()[settle][0]
    sides: tuple[tuple[str, Quantity], ...] = (("main", "pressure_main"), ("return", "pressure_return"))
    found = []
    for name, quantity in sides:
        top = run.peak(quantity, since)
        found.append(Extreme(1e-6 * top.value, top.angle % TURN, where=f"{name} side, as a line along all of it"))
    for number, duties in enumerate(turns, settle + 1):
        for duty in duties:
            peak = duty.least_peak
            if peak is not None:
                found.append(replace(peak, where=f"turn {number}, {duty.spot(peak)}"))
    return hardest(found)


def impact_lives_of(turns: tuple[Duties, ...], reproducible: bool) -> dict[str, float]:
    """Fatigue life, h, of every body under a history of impacts, from the counted turns.

    One point of a body takes at most the damage of the hot spots of all turns together: their mean a turn bounds the
    life from below. Of turns that cannot be reproduced others will come: every turn then counts as the hardest one.
    """
    lives: dict[str, list[float]] = {}
    for duties in turns:
        for body, hours in least_lives(duties).items():
            lives.setdefault(body, []).append(hours)
    return {body: least_life(each, reproducible) for body, each in lives.items()}


def least_life(hours: list[float], mean: bool) -> float:
    """Life, h, from those of single turns: of the mean damage, or of the hardest turn; 0 where one has none."""
    if min(hours) == 0.0 or not mean:
        return min(hours)
    return len(hours) / sum(1.0 / one for one in hours) if min(hours) < float("inf") else float("inf")


def impact_problem(profile: Profile, mechanism: Mechanism, load: Load) -> ImpactProblem:
    """The contact problem of the profile's cam in SI units; raises as `impact_of`."""
    spec = profile.impact_spec
    assert spec is not None
    assert profile.operation is not None, "it made the load"
    rollers, drum, touches = mechanism.rollers, mechanism.drum, mechanism.touches
    sizes = [(touch.length, 0.5 * roller.diameter, roller.arc) for touch, roller in zip(touches, rollers)]
    length, radius, crown = mechanism.contact_length, float("inf"), None
    if rollers:
        radius, crown = 0.5 * rollers[0].diameter, rollers[0].arc
    if sizes:
        length, radius, crown = sizes[0]
    base = mechanism.base_radius or (drum.radius if drum else radius)
    pair, acting = impact_pair(profile, mechanism), impact_load(load, mechanism.program)
    if acting.applied is not None and acting.applied.jumps:
        pair = replace(pair, lift=pair.lift.split(acting.applied.jumps))
    return spec.problem(
        pair,
        inertia=load.si.mass,
        speed_rpm=profile.operation.speed,
        modulus_mpa=1.0 / pair_compliance(profile.material.roller, profile.material.cam),
        length_mm=length,
        roller_radius_mm=radius,
        cam_radius_mm=base,
        crown_radius_mm=crown,
        load=acting,
        back=sizes[1] if len(set(sizes)) > 1 else None,
    )


def impact_laws(profile: Profile) -> dict[str, ImpactProblem]:
    """The contact problem for every law that [impact] compares, put in place of those of all moving segments.

    Each cam is made anew, so its levers and curvatures are those of its own motion. Raises as `impact_of`.
    """
    spec = profile.impact_spec
    assert spec is not None
    found = {}
    for law in spec.laws:
        other = with_law(profile, law)
        mechanism = other.cam.mechanism(other.setup())
        found[law] = impact_problem(other, mechanism, load_of(other, mechanism))
    return found


def clearance_rows(model: Model, run: ImpactRun) -> tuple[StudyRow | Unsolved, ...]:
    """The run's problem with every clearance that [impact] studies. Raises NotConverged where they are too many."""
    from camgeom.dynamics.impact.study import clearance_study

    spec = model.profile.impact_spec
    assert spec is not None
    afford(model.body, STUDIES)
    return tuple(clearance_study(run.problem, [MILLI * c for c in spec.study], **_counted(spec)))


def law_rows(model: Model) -> tuple[StudyRow | Unsolved, ...]:
    """Every law that [impact] compares; raises as `impact_of`, and NotConverged where they are too many."""
    from camgeom.dynamics.impact.study import study

    spec = model.profile.impact_spec
    assert spec is not None
    afford(model.body, STUDIES)
    return tuple(study(impact_laws(model.profile), **_counted(spec)))


def law_runs(profile: Profile) -> dict[str, ImpactRun]:
    """A run to the first counted turn with every law that [impact] compares and that converges; raises as `impact_of`.
    """
    from camgeom.dynamics.impact.run import solve
    from camgeom.dynamics.impact.solver import ORDINARY
    from camgeom.dynamics.impact.study import HARD

    spec = profile.impact_spec
    assert spec is not None
    found = {}
    for law, problem in impact_laws(profile).items():
        # One that does not converge is told by its row.
        with suppress(NotConverged):
            turns = spec.settle + 1
            found[law] = solve(problem, turns=turns, rtol=spec.tolerance, most=HARD * ORDINARY * turns)
    return found


def _counted(spec: ImpactSpec) -> dict[str, Any]:
    return {"turns": spec.turns, "skip": spec.settle, "rtol": spec.tolerance}


def impact_load(load: Load, program: Program) -> ImpactLoad:
    """What acts on the follower beside its inertia: spring, friction, weight, applied forces; SI.

    Applied forces are taken over the cam angle along the ideal motion. Friction is reached at a hundredth of the
    motion's peak speed.
    """
    from camgeom.dynamics.impact.lift import ForceTable
    from camgeom.dynamics.impact.problem import ImpactLoad

    si, omega = load.si, load.omega
    unit, length = (MILLI, 1.0) if load.rotating else (1.0, MILLI)
    applied = None
    if load.applied:

        def force(theta: Floats) -> Floats:
            s, v, a = program.jet(theta, 2)
            return np.asarray(unit * sum(one(theta, s, omega * v, omega**2 * a) for one in load.applied))

        applied = ForceTable.of(force, [*program.knots, *(b for one in load.applied for b in one.breaks)])
    fastest = length * abs(program.peak(1).value) * omega
    return ImpactLoad(-(si.preload + si.weight), si.rate, si.friction, 0.01 * fastest or 1e-3, applied)


def impact_pair(profile: Profile, mechanism: Mechanism) -> Pair:
    """The two opposing contacts of the profile's cam, in m and rad."""
    from camgeom.dynamics.impact.pair import groove_pair, planar_pair

    spec, tracks = profile.impact_spec, mechanism.tracks
    assert spec is not None
    clearance = MILLI * (spec.clearance or mechanism.free_play)
    if {touch.way for touch in mechanism.touches} == {1.0, -1.0}:
        return planar_pair(mechanism.program, mechanism.touches, clearance, spec.clearance_kind)
    return groove_pair(mechanism.cutting(tracks[0]), clearance, 0.5 * sum(tracks[0].contact))
