"""The motion: no jump of velocity or acceleration, and the cycle that a machine asks for: how fast, often and long.

Continuity is a selection rule of T/WLJC 15-2018. Of the cycle switch testers are the case at hand (GB 14048-2008, cited
in doi 10.3969/j.issn.1005-2895.2014.02.011): 50 to 150 mm/s, at most 60 operations a minute, closed for 10 to 50 % of
the cycle. A limit that is not given is not asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import degrees, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import NO_OPERATION, check, refuse_coarse, solved
from camgeom.checks.verdict import Comparison, Finding, Level, NotJudged, judged
from camgeom.errors import NotConverged
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.motion.program import Continuity

WORDS = ("lift", "velocity", "acceleration", "jerk")
Peak = tuple[float, float, str]
"""value, mm/s (deg/s), its cam angle, rad, and whose motion it is"""
SOLVED = {False: {"velocity": ""}, True: {"turret_velocity": ", of the turret", "load_velocity": ", of its load"}}
"""outputs of a follower and of an indexing drive that are velocities, and whose"""
UNSTATED, WORTH, ROUNDED = 1e-2, 2e-3, 1e-6
"""shares of a table's lift by which the motion may leave rows whose scatter is not stated, that are worth a word of
warning, and that rows of a few digits are rounded by"""
AT_STROKE = 1e-9
"""share of the stroke within which a dwell is at its far end"""
FASTER = "a smaller stroke, a longer motion, a law of lower peak velocity, or a lower speed"
SLOWER = "a larger stroke, a shorter motion, or a higher speed"


@check("continuity")
def continuity(model: Model) -> Iterable[Finding]:
    """Order of continuity of the program, and of how a plate is driven; 2 (continuous acceleration) is wanted."""
    join = "use a law with continuous acceleration, or join moving segments by a polynomial"
    yield _smooth(model.setup.program.continuity, f"jumps in {{}}; {join}")
    if model.mechanism.carriage is not None:
        turn = "the force on plate and slide jumps with the {}; use a cam.drive whose acceleration begins and ends at "
        even = "0, or, of a simple harmonic, cam.drive_out = 180"
        yield _smooth(model.mechanism.carriage.drive.continuity, turn + even, "the plate's drive", "warn")


def _smooth(found: Continuity, advice: str, where: str = "", worst: Level = "fail") -> Finding:
    bad = [jump for jump in found.jumps if jump.order <= 2]
    places = ", ".join(f"{WORDS[j.order]} at {degrees(j.angle):.6g} deg" for j in bad[:6])
    return judged("continuity", float(found.order), ">=", 2.0, "order", advice.format(places),
                  cam_angle=bad[0].angle if bad else None, where=where, worst=worst)  # fmt: skip


@check("table")
def table(model: Model) -> Iterable[Finding]:
    """Largest distance of the motion from the rows of a table: six times the smoothing that the profile states, else a
    hundredth of the table's lift, of which a fifth is worth a word."""
    unit = "deg" if model.profile.rotating else "mm"
    for one in model.tables:
        far, at = one.largest
        stated = one.smoothing is not None
        allowed = max(6.0 * (one.smoothing or 0.0), ROUNDED * one.size) if stated else UNSTATED * one.size
        loud = stated or far > allowed
        advice = f"the spline keeps off the rows (rms {one.rms:.3g} {unit}): state `smoothing`, the standard deviation "
        advice += "of the lifts, raise `knots`, or end a segment where the table rests or has a corner"
        worst: Level = "fail" if loud else "warn"
        yield judged("table", far, "<=", allowed if loud else WORTH * one.size, unit, advice, cam_angle=at,
                     where=f"motion[{one.segment}], {len(one.distance)} rows{', ' * bool(one.laid)}{one.laid}",
                     worst=worst)  # fmt: skip


@solved("velocity", "operation", slow=True)
def velocity(model: Model) -> Iterable[Finding | NotJudged]:
    """Peak velocity of the follower between its bounds: rigid, with vibration, and with impacts where they are solved.
    """
    limits = model.profile.limits
    if limits.velocity is None and limits.least_velocity is None:
        return
    if model.profile.operation is None:
        yield NotJudged("velocity", NO_OPERATION)
        return
    unit = "deg/s" if model.profile.rotating else "mm/s"
    every: list[Peak] = []
    unsolved = None
    try:
        for peak in _peaks(model):
            every.append(peak)
    except NotConverged as error:
        unsolved = error
    # What is too fast, or too slow, without what a solver does not find is so with it.
    fast = limits.velocity is not None and max(every)[0] > limits.velocity
    slow = limits.least_velocity is not None and min(every)[0] < limits.least_velocity
    if unsolved is not None and not (fast or slow):
        raise unsolved
    if limits.velocity is not None and (fast or unsolved is None):
        yield _velocity(max(every), every[0], "<=", limits.velocity, unit, FASTER)
    if limits.least_velocity is not None and (slow or unsolved is None):
        yield _velocity(min(every), every[0], ">=", limits.least_velocity, unit, SLOWER)


def _velocity(peak: Peak, rigid: Peak, comparison: Comparison, limit: float, unit: str, advice: str) -> Finding:
    value, angle, where = peak
    beside = rigid[0] if where != rigid[2] else None
    return judged("velocity", value, comparison, limit, unit, advice, cam_angle=angle, where=where, rigid=beside)


def _peaks(model: Model) -> Iterator[Peak]:
    """Peaks of the velocity, the rigid one first."""
    operation, impact = model.profile.operation, model.profile.impact_spec
    assert operation is not None, "the check asks for it"
    unit = degrees(1.0) if model.profile.rotating else 1.0
    peak = model.setup.program.peak(1)
    yield unit * abs(peak.value) * operation.speed * pi / 30.0, peak.at, "rigid"
    unit = degrees(1.0) if model.profile.rotating else 1e3
    solved_by = model.indexing or model.elastic_follower
    if solved_by is not None:
        refuse_coarse(model)
        for name, whose in SOLVED[model.indexing is not None].items():
            found = solved_by.steady.peak(name)
            yield unit * float(found.magnitude[0]), float(found.magnitude_at[0]) % TURN, f"with vibration{whose}"
    run = model.impact
    if run is not None and impact is not None:
        trace = run.trace.flat()
        counted = np.where(trace.time >= impact.settle * run.problem.period, np.abs(trace.speed), 0.0)
        at = int(np.argmax(counted))
        yield unit * float(counted[at]), float(trace.angle[at]) % TURN, "with impacts"


@solved("cycle-rate", "operation")
def cycle_rate(model: Model) -> Iterable[Finding | NotJudged]:
    """Cycles a minute: turns of the cam."""
    limit, operation = model.profile.limits.cycles_per_min, model.profile.operation
    if limit is None:
        return
    if operation is None:
        yield NotJudged("cycle-rate", NO_OPERATION)
        return
    yield judged("cycle-rate", operation.speed, "<=", limit, "1/min", "a lower operation.speed")


@solved("on-time")
def on_time(model: Model) -> Iterable[Finding]:
    """Share of the turn in which the follower stands at the far end of its stroke, or a turret between its steps."""
    limits, program = model.profile.limits, model.setup.program
    if limits.on_time is None and limits.least_on_time is None:
        return
    ends = [end for span in program.spans for end in (span.before, span.after)]
    turret = model.mechanism.turret
    # What steps on stands at one of its stops before and after each step, wherever in its rest the turn begins.
    round_it, place, where = (
        (TURN / turret.follower.stops, min(ends), "dwell between steps") if turret is not None and program.advance
        else (np.inf, max(ends), "dwell at the far end of the stroke")
    )  # fmt: skip
    slip = AT_STROKE * (max(ends) - min(ends))
    held = [span for span in program.spans
            if span.law == "dwell" and (span.after - place + slip) % round_it <= 2.0 * slip]  # fmt: skip
    share = sum(span.end - span.start for span in held) / TURN
    if limits.on_time is not None:
        yield judged("on-time", share, "<=", limits.on_time, "of the turn", "a shorter dwell there", where=where)
    if limits.least_on_time is not None:
        yield judged("on-time", share, ">=", limits.least_on_time, "of the turn", "a longer dwell there", where=where)
