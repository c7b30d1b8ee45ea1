"""Stress at a root, or in a frame's plate, against what its material endures in bending."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import solved
from camgeom.checks.verdict import Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.model import Model


@solved("root-stress", "root")
def root_stress(model: Model) -> Iterable[Finding | NotJudged]:
    """Peak stress at the root against material.cam.bending_limit; without a peak the nominal stress can only fail.

    It is solved under the rigid forces: what vibration or impacts press so much harder that the peak, which grows with
    the force, would be beyond the limit does not pass.
    """
    found, limit = model.root_stress, model.root_limit
    if found is None or limit is None:
        return
    worst = found.worst
    advice = f"{found.body.remedy}; less force; a stronger material"
    if worst.value > limit:
        yield judged("root-stress", worst.value, "<=", limit, "MPa", advice, cam_angle=worst.cam_angle,
                     where=f"{worst.where}, nominal")  # fmt: skip
    elif found.peak is not None and (found.hardest or found.peak > limit):
        more, solved_by = _harder(model)
        if found.peak <= limit < more * found.peak:
            yield NotJudged("root-stress", f"the peak is solved under the rigid forces, {found.peak:.4g} MPa of "
                            f"{limit:.4g}; with {solved_by} the largest force is {more:.4g} times theirs")  # fmt: skip
            return
        yield judged("root-stress", found.peak, "<=", limit, "MPa", advice, cam_angle=found.patch.theta,
                     where=found.body.root)
    else:
        told = f"the largest nominal stress is {worst.value:.4g} MPa at {degrees(worst.cam_angle):.4g} deg"
        why = found.why_no_peak or (
            f"the peak, {found.peak:.4g} MPa at {degrees(found.patch.theta):.4g} deg, is not where that of a corner is "
            "largest: name that angle by output.load_angle_deg"
        )
        yield NotJudged("root-stress", f"{why}; {told}, below the limit")


def _harder(model: Model) -> tuple[float, str]:
    """Largest force with vibration or impacts in any state over the largest rigid one of that which the stress is of,
    and with which of them; 1 without them."""
    rigid = model.hardest_state.peak_force
    assert rigid is not None, "what is bent is pressed"
    turns = [(name, duties) for state in model.states for name, each in (
        ("vibration", (state.dynamic_duties if state.profile.dynamics_spec is not None else (),)),
        ("impacts", state.impact_duties)) for duties in each]  # fmt: skip
    found = [(duty.peak_force.value / rigid.value, name) for name, duties in turns for duty in duties]
    return max(found, default=(1.0, ""))
