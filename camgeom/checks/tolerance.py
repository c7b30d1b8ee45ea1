"""What the errors of [tolerance] leave of accuracy: place in the dwells, over the turn, play, at the wanted yield."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import check
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.tolerance.study import NO_ROOM

if TYPE_CHECKING:
    from camgeom.maths import Floats
    from camgeom.model import Model


def _within(model: Model, name: str, figure: Floats, worst: float, limit: float | None, where: str) -> Finding:
    study, spec = model.tolerances, model.profile.tolerance_spec
    assert spec is not None, "the registry asks for it"
    loaded, share = study.loaded, spec.wanted_yield
    value = loaded.shown(study.drawn.at_yield(figure, share))
    advice = ""
    if limit is None or not value <= limit:
        # What each error explains takes as long as all else that is drawn.
        key = max(study.drawn.shares, key=lambda key: study.drawn.shares[key])
        widest = "take what `camgeom tolerance` gives as the widest"
        advice = f"tighten tolerance.{key}, the largest part of it, or {widest}"
    seen = f"{where}, {100.0 * share:.6g} % of the machines; worst case {loaded.shown(worst):.4g} {loaded.unit}"
    if spec.reference != "absolute" and figure is not study.drawn.backlash:
        seen += " from the drawing"
    return judged(name, value, "<=", limit, loaded.unit, advice, where=seen)


def _open(model: Model, name: str, key: str, figure: Floats) -> NotJudged:
    study, spec = model.tolerances, model.profile.tolerance_spec
    assert spec is not None, "the registry asks for it"
    value = study.loaded.shown(study.drawn.at_yield(figure, spec.wanted_yield))
    told = f"{100.0 * spec.wanted_yield:.6g} % of the machines stay within {value:.4g} {study.loaded.unit}"
    return NotJudged(name, f"give tolerance.{key}: {told}")


@check("dwell-tolerance", "tolerance")
def dwell_tolerance(model: Model) -> Iterable[Finding | NotJudged]:
    """Where the follower stands in its dwells, with the errors that the profile tolerates."""
    study, limit = model.tolerances, model.tolerances.spec.dwell_limit if model.tolerances.spec else None
    if limit is None:
        yield _open(model, "dwell-tolerance", "dwell_limit", study.drawn.dwell)
    else:
        yield _within(model, "dwell-tolerance", study.drawn.dwell, study.worst.dwell.value, limit, "in the dwells")


@check("motion-tolerance", "tolerance")
def motion_tolerance(model: Model) -> Iterable[Finding | NotJudged]:
    """Where it stands anywhere in the turn; judged where a limit is given."""
    study, limit = model.tolerances, model.tolerances.spec.motion_limit if model.tolerances.spec else None
    if limit is not None:
        yield _within(model, "motion-tolerance", study.drawn.motion, study.worst.motion.value, limit, "in the turn")


@check("yield-tolerance", "tolerance", "body")
def yield_tolerance(model: Model) -> Iterable[Finding]:
    """Share of the machines that keep every limit of every follower, where that is more than one of place or play asks.
    """
    study, spec = model.machine_tolerances, model.profile.tolerance_spec
    several, limits = len(study.followers) > 1, sum(len(one.limits) for one in study.followers)
    if spec is None or (spec.preload_limit is None and spec.pressure_limit is None and limits < 2):
        return
    # The limit that the fewest machines keep.
    each = [(float(np.mean(over <= 1.0)), key, one) for one in study.followers
            for key, over in one.each_ratio(one.drawn).items()]  # fmt: skip
    least, key, follower = min(each, key=lambda row: row[0])
    nominal = follower.nominal_over(key)
    whose = f" of follower {follower.number + 1}" if several else ""
    advice = f"alone, {key}{whose} is kept by {100.0 * least:.6g} %: " + (
        f"the design has {nominal} without any error: another design, or another limit" if nominal
        else "tighten the tolerances, or take what `camgeom tolerance` gives as the widest"
    )
    where = f"all limits{' of all followers' if several else ''} together"
    yield judged("yield-tolerance", study.share, ">=", spec.wanted_yield, "1", advice, where=where)


@check("backlash-tolerance", "tolerance")
def backlash_tolerance(model: Model) -> Iterable[Finding | NotJudged]:
    """Play of a follower between two walls in its dwells, with those errors."""
    study, limit = model.tolerances, model.tolerances.spec.backlash_limit if model.tolerances.spec else None
    if not study.both:
        return
    if limit is None:
        yield _open(model, "backlash-tolerance", "backlash_limit", study.drawn.backlash)
    else:
        figure, worst = study.drawn.backlash, study.worst.backlash.value
        yield _within(model, "backlash-tolerance", figure, worst, limit, "play in the dwells")


@check("groove-end-tolerance", "tolerance")
def groove_end_tolerance(model: Model) -> Iterable[Finding]:
    """Room of a plate's roller at the ends of its groove, which errors along the travel may not use up."""
    study, spec = model.tolerances, model.profile.tolerance_spec
    room, ended = study.end_room, study.drawn.ended if study.end_room is not None else None
    if spec is None or room is None or ended is None:
        return
    value, worst = study.drawn.at_yield(ended, spec.wanted_yield), 1e3 * study.worst_end
    value = 0.0 if abs(value) < NO_ROOM else value
    advice = "give the groove more cam.running_clearance, or tighten what moves the roller along the travel"
    seen = f"towards the groove's end, {100.0 * spec.wanted_yield:.6g} % of the machines; worst case {worst:.4g} um"
    yield judged("groove-end-tolerance", 1e3 * value, "<=", 1e3 * room, "um", advice, where=seen)
