"""What [dynamics] and [impact] find, judged: pressure and life under the solved forces, contact, settling, resonance.

The rigid figures stand beside, in their own findings. A solver that finds no answer is not judged, with its reason.
The first turn from rest at full speed shows what no periodic state does. A limit of torque or static load holds for
its worst moment and fails; the limit of pressure is one of fatigue, which a turn does not use up, and a contact that a
start alone loses comes back: both warn.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import LIFTED, judged_lives, judged_pressure, no_stress, solved
from camgeom.checks.verdict import Finding, Level, NotJudged, judged
from camgeom.solid.mechanism import Drive

if TYPE_CHECKING:
    from camgeom.model import Model

LESS = "stiffen what is elastic, damp it, take a smoother law or less speed; the rigid figure leaves vibration out"
IMPACTS = "less clearance or speed, a smoother law, a longer or larger roller, or a tougher pair of materials"
SOFT = "run the machine up slowly, damp or stiffen what is elastic, or take a smoother law"
MOVING = "the motion does not stand still where the turn begins: let the program begin in a dwell"
LEFT = "the follower leaves its cam in its first turn (see start-lift-off), so there is no force to judge"
SURE = 0.1
"""share of the settling band to which the deviation must be known"""
SENSITIVE = 1.25
"""change of the largest acceleration over omega squared within `BAND` of the speed: a resonance doubles it or more"""
BAND = (0.95, 1.05)
RINGING = 0.5
"""of a swing left after a turn: as much as one turn stirs up, the next one finds"""
HARMONICS = 40
"""of the turn that are looked at one by one; those beyond are as small as they are close"""
BESIDE = (0.975, 1.025)
"""shares of the speed that are looked at within the band where no harmonic of the turn meets the lowest mode there"""
"""shares of the operating speed: it is held to a few per cent"""


@solved("dynamic-pressure", "dynamics")
def dynamic_pressure(model: Model) -> Iterable[Finding | NotJudged]:
    """Peak contact pressure under the periodic contact force of the elastic drive or follower."""
    if model.dynamic_duty is None:
        yield NotJudged("dynamic-pressure", LIFTED)
        return
    yield from judged_pressure("dynamic-pressure", model, (model.dynamic_duty,), LESS, model.carrier)


@solved("dynamic-life", "dynamics", summed=True)
def dynamic_life(model: Model) -> Iterable[Finding | NotJudged]:
    """Fatigue lives of roller, cam and bearing under the periodic contact force."""
    if all(state.dynamic_duties for state in model.states):
        lost = no_stress(duty for state in model.states for duty in state.dynamic_duties)
        yield from judged_lives("dynamic-life", model, model.dynamic_lives, LESS, lost=lost)
    elif model.profile.limits.life_h is not None:
        yield NotJudged("dynamic-life", LIFTED)


@solved("lift-off", "dynamics")
def lift_off(model: Model) -> Iterable[Finding]:
    """Least contact force of an elastic follower that a spring or weight holds on its cam."""
    follower = model.elastic_follower
    if follower is None or follower.jump is None:
        return
    unit = "N m" if model.profile.rotating else "N"
    needed = float(follower.jump.required_preload[0])
    advice = f"the follower leaves its cam: a preload of {needed:.4g} {unit} holds it, or a stiffer linkage, less speed"
    least, angle = float(follower.jump.minimum_force[0]), float(follower.jump.minimum_at[0])
    yield judged("lift-off", least, ">=", 0.0, unit, advice, cam_angle=angle, where="least contact force")


@solved("start-lift-off", "dynamics", turn="start")
def start_lift_off(model: Model) -> Iterable[Finding]:
    """Least contact force in the first turn of an elastic follower that a spring or weight holds; a warning at most."""
    from camgeom.model.vibration import least_contact, starts_at_rest

    if model.mechanism.turret is not None or not starts_at_rest(model):
        return
    least = least_contact(model, "start")
    if least is not None:
        advice = f"the follower leaves its cam in its first turn: more preload, or {SOFT}"
        unit = "N m" if model.profile.rotating else "N"
        yield judged("start-lift-off", least.value, ">=", 0.0, unit, advice, cam_angle=least.cam_angle,
                     where="least contact force from rest", worst="warn")  # fmt: skip


@solved("start-pressure", "dynamics", turn="start")
def start_pressure(model: Model) -> Iterable[Finding | NotJudged]:
    """Peak contact pressure in the first turn from rest; a warning at most."""
    from camgeom.model.vibration import starts_at_rest

    if not starts_at_rest(model):
        yield NotJudged("start-pressure", MOVING)
        return
    if not model.start_duties:
        yield NotJudged("start-pressure", LEFT)
        return
    yield from judged_pressure("start-pressure", model, model.start_duties, SOFT, model.carrier, "warn")


@solved("settling", "dynamics")
def settling(model: Model) -> Iterable[Finding | NotJudged]:
    """Time until the load of an indexing drive, or an elastic follower, stays in the settling band, against its dwell.

    A failure where the profile gives `dynamics.settling_band`, else a warning at most. What a dwell has to hold only
    the machine knows: a turret that settles passes the accuracy of its kind, a follower is told with its figures.
    """
    study, spec = model.indexing or model.elastic_follower, model.profile.dynamics_spec
    if study is None or spec is None or not study.dwells:
        return
    what, name = ("load", "load_deviation") if model.indexing is not None else ("follower", "deviation")
    unit, per = ("deg", 180.0 / np.pi) if model.profile.rotating else ("mm", 1e3)
    left, steady, band = study.residual, study.steady, f"{per * study.band:.6g} {unit}"
    unsure = float(steady.solution.error[0] * steady.peak(name).magnitude[0])
    if unsure > SURE * study.band:
        yield NotJudged("settling", f"the {what}'s deviation is known to {per * unsure:.3g} {unit}, the band is "
                        f"{band}: more dynamics.steps, or a smaller tolerance")  # fmt: skip
        return
    dwell = 1e3 * (left.end_rad - left.begin_rad) / study.speed
    value = dwell if study.settling_time is None else 1e3 * study.settling_time
    # What comes into the band for less than half a swing has not settled: it only passes through.
    limit = max(0.0, dwell - 1e3 * study.half_swing)
    advice = (
        f"the {what} swings by {per * left.deviation[0]:.4g} {unit} in its dwell and is not within "
        f"{band} when it ends: more damping, a stiffer shaft or linkage, a smoother law or less speed"
    )
    free = _free(model)
    if free > study.band and value <= limit:
        yield NotJudged("settling", f"in its play the {what} stands free within {per * free:.4g} {unit} of what is "
                        f"solved without it, the band is {band}: less clearance, or a wider band")  # fmt: skip
        return
    given = "settling_band" in spec.model_fields_set
    if not given and model.indexing is None and value <= limit:
        yield NotJudged("settling", f"give dynamics.settling_band, the {unit} that the dwell has to hold: the follower "
                        f"swings by {per * left.deviation[0]:.4g} {unit} in it and is within {band}, 1 % of its "
                        f"stroke, after {value:.4g} ms of {dwell:.4g} ms")  # fmt: skip
        return
    worst: Level = "fail" if given else "warn"
    yield judged("settling", value, "<=", limit, "ms", advice, cam_angle=left.begin_rad, worst=worst,
                 where=f"into {band}, before the dwell ends at {np.degrees(left.end_rad) % 360.0:.6g} deg")  # fmt: skip


def _free(model: Model) -> float:
    """By how much a follower that nothing holds to one wall stands free in its play, m or rad, from end to end."""
    mechanism = model.mechanism
    if mechanism.drive is Drive.ALONE:
        return 0.0
    radius = mechanism.follower.swing_radius
    return mechanism.free_play / radius if radius else 1e-3 * mechanism.free_play


@solved("resonance", "dynamics")
def resonance(model: Model) -> Iterable[Finding | NotJudged]:
    """How much the largest acceleration over omega squared changes near the operating speed; a warning at most.

    A mode beyond `HARMONICS` of the turn meets one of them within a per cent of any speed. Where next to nothing damps
    it and a step of friction stirs it, what is left of its ringing after a turn hangs on the last digits of the speed.
    """
    drive, follower = model.indexing, model.elastic_follower
    study = drive or follower
    assert study is not None, "the registry asks for it"
    name = "load_acceleration" if drive is not None else "acceleration"
    hertz = _lowest_frequency(model)
    shares = np.array([*BAND, *(_meetings(2.0 * np.pi * hertz / study.speed) or BESIDE)])
    # The halved step is known to meet the tolerance at the operating speed.
    sweep = study.over(study.speed * shares, max(1, study.steady.solution.grid.steps // 2))
    if not sweep.answered.all():
        yield Finding("resonance", "warn", None, "<=", SENSITIVE, "1", advice=sweep.refused[0][1])
        return
    here = float(study.steady.peak(name).magnitude[0])
    values = np.append(sweep.peaks[name].magnitude / shares**2, here)
    value = float(values.max() / values.min()) if values.min() > 0.0 else 1.0
    worst = study.speed * float(np.append(shares, 1.0)[values.argmax()]) * 30.0 / np.pi
    order = max(1, round(60.0 * hertz / worst))
    kept = float(study.steady.solution.spectral_radius[0])
    if value > SENSITIVE and order > HARMONICS and kept > RINGING:
        yield NotJudged(
            "resonance",
            f"next to nothing damps the mode of {hertz:.4g} Hz, harmonic {order} of the turn: {100.0 * kept:.3g} % of "
            "its swing is left after a turn, and what steps of friction and force add to it is another thing at every "
            "speed: give [dynamics] its damping",
        )
        return
    advice = (
        f"vibration is largest near {worst:.4g} r/min, where harmonic {order} of the turn meets the mode of "
        f"{hertz:.4g} Hz: keep off that speed, or move the mode by stiffness, inertia or damping"
    )
    yield judged("resonance", value, "<=", SENSITIVE, "1", advice, worst="warn",
                 where="change of the largest acceleration within 5 % of the speed")  # fmt: skip


def _meetings(turns: float) -> tuple[float, ...]:
    """Shares of the speed, inside the band, at which a harmonic of the turn meets a mode of so many swings a turn: the
    two nearest to the speed. A slightly damped mode answers nowhere else."""
    orders = np.arange(max(1.0, np.floor(turns) - 1.0), np.floor(turns) + 3.0)
    shares = turns / orders
    inside = shares[(shares > BAND[0]) & (shares < BAND[1]) & (orders <= HARMONICS)]
    return tuple(float(share) for share in inside[np.argsort(np.abs(inside - 1.0))][:2])


def _lowest_frequency(model: Model) -> float:
    """Lowest natural frequency that the motion excites, Hz."""
    if model.indexing is not None:
        return model.indexing.modes.lowest_hz()[0]
    assert model.elastic_follower is not None
    return float(model.elastic_follower.train.natural_frequency()[0]) / (2.0 * np.pi)


@solved("stability", "dynamics")
def stability(model: Model) -> Iterable[Finding]:
    """Stiffness blocks that are none, and what a turn of the cam makes of a small disturbance.

    A block that the motion does not move only warns: the response leaves it out. Raises NotConverged where the solver
    finds no steady state for another reason than growth.
    """
    from camgeom.dynamics.indexing.drive import TORSION
    from camgeom.dynamics.linear.solve import NEUTRAL, Growing

    drive, study = model.indexing, model.indexing or model.elastic_follower
    assert study is not None, "the registry asks for it"
    coupled = True
    for wrong in drive.modes.indefinite if drive is not None else ():
        in_drive = wrong.block == TORSION
        coupled &= not in_drive
        yield judged("stability", wrong.scaled_eigenvalue, ">", 0.0, "1", str(wrong),
                     worst="fail" if in_drive else "warn", where=f"stiffness of {', '.join(wrong.block)}")  # fmt: skip
    if not coupled:
        return
    try:
        radius = float(study.steady.solution.spectral_radius[0])
    except Growing as growing:
        radius = growing.radius
    advice = "a turn makes a small disturbance larger (parametric instability): more damping, or another speed"
    yield judged("stability", radius, "<=", 1.0, "1", advice, slack=NEUTRAL, where="growth of a disturbance in a turn")


@solved("impact-pressure", "impact")
def impact_pressure(model: Model) -> Iterable[Finding | NotJudged]:
    """Largest pressure of the contacts with free play, over the counted turns."""
    peak, lost = model.impact_pressure, no_stress(duty for turn in model.impact_duties for duty in turn)
    if lost and peak.value <= model.pressure_limit:
        yield NotJudged("impact-pressure", lost)
        return
    rigid = model.carrier.peak_pressure if model.carrier is not None else None
    yield judged("impact-pressure", peak.value, "<=", model.pressure_limit, "MPa", IMPACTS, cam_angle=peak.cam_angle,
                 where=peak.where, rigid=rigid.value if rigid is not None else None)  # fmt: skip


@solved("impact-life", "impact", summed=True)
def impact_life(model: Model) -> Iterable[Finding | NotJudged]:
    """Fatigue lives under the forces of the counted turns; of turns that cannot be reproduced, of the hardest one."""
    lost = no_stress(duty for state in model.states for turn in state.impact_duties for duty in turn)
    yield from judged_lives("impact-life", model, model.lives_in_play, IMPACTS, _basis(model), lost)


def _basis(model: Model) -> str:
    """What the lives rest on: in one operating state the hardest turn alone, if in any."""
    from camgeom.model import MEAN

    return next((one.impact_basis for one in model.states if one.impact_basis != MEAN), MEAN)


@solved("impact-reproducible", "impact")
def impact_reproducible(model: Model) -> Iterable[Finding]:
    """Turns whose peaks a small disturbance of the start leaves as they are, against those solved; a warning at most.

    A motion with impacts may be chaotic: then a peak beyond those turns is one of many that could come.
    """
    found = model.impact_sensitivity
    assert found is not None, "the registry asks for it"
    advice = (
        f"the motion is chaotic: peaks are not reproducible beyond turn {found.reproducible}, a disturbance grows by "
        f"{max(found.growth):.3g} within {found.turns} turns; judge by the statistics of many turns, or reduce the play"
    )
    yield judged("impact-reproducible", found.reproducible, ">=", found.turns, "", advice, worst="warn",
                 where="turns that a disturbance of 1e-9 of the play leaves alike")  # fmt: skip
