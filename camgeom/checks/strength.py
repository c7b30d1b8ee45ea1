"""Contact pressure, fatigue life, hardness and case against the profile's limits, whoever presses the cam.

One judgement a question; its name and advice are those of the carrier: a roller, faces, a turret's rollers that share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from camgeom.checks import LIFTED, Need, check, judged_lives, judged_pressure, no_stress, solved
from camgeom.checks.verdict import Finding, NotJudged, judged, life_told
from camgeom.mechanics.hardness import CONTACT_CYCLES, CONTACT_LIMIT, hardness_bound
from camgeom.mechanics.material import CASE_SHARE, Material

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.model import Model



def pressure(name: str, remedy: str, model: Model) -> Iterable[Finding | NotJudged]:
    """Peak contact pressure: of the hardest place along a roller, of all rollers that share, of all faces."""
    if model.carrier is not None:
        yield from judged_pressure(name, model, (model.carrier,), remedy)


def life(name: str, remedy: str, model: Model) -> Iterable[Finding | NotJudged]:
    """Fatigue life at the hardest place of roller or face and cam, and of the bearing of a roller that is rated."""
    every = [duty for state in model.states for duty in state.carriers]
    keys = dict.fromkeys(duty.squared[0] for duty in every if duty.squared is not None)
    for word in judged_lives(name, model, model.lives, remedy, lost=no_stress(every)):
        if keys and isinstance(word, Finding) and not word.passed:
            # Of rollers that stand square, but bear with a nearly sharp end, no life is known.
            hours = model.square_lives.get(word.where)
            if hours is not None and hours >= (model.profile.limits.life_h or 0.0):
                yield replace(word, advice=f"a smaller {' or '.join(keys)}: without it the life is {life_told(hours)}")
                continue
        yield word


JUDGEMENTS: tuple[tuple[str, Need, Callable[[str, str, Model], Iterable[Finding | NotJudged]], str], ...] = (
    ("contact-pressure", "roller load", pressure, "use a longer or larger roller, a larger cam, less mass or speed"),
    ("face-pressure", "face load", pressure,
     "use a wider cam, a larger base_radius, or less mass, speed or preload"),
    ("turret-pressure", "turret load", pressure,
     "use longer or larger rollers, a larger centre distance, less inertia or speed"),
    ("life", "roller load", life, "lower the contact pressure: longer or larger roller, larger cam, less speed"),
    ("face-life", "face load", life,
     "lower the contact pressure: a wider cam, a larger base_radius, less speed or preload"),
    ("turret-life", "turret load", life, "lower the load: larger rollers or centre distance, less inertia or speed"),
)  # fmt: skip
for _name, _need, _judge, _remedy in JUDGEMENTS:
    check(_name, _need, summed=_judge is life)(partial(_judge, _name, _remedy))


MASS_SLACK = 1e-3
"""share by which the mass of a plate and what carries it may be below that of its mesh"""


@check("crown-length", "roller load", "crowned load")
def crown_length(model: Model) -> Iterable[Finding]:
    """Whether the contact ellipse of a crowned roller ends within its length; beyond it the ends press too."""
    yield from crown_lengths("crown-length", model.duties)


def crown_lengths(name: str, duties: Iterable[Duty]) -> Iterable[Finding]:
    """The longest ellipse of each duty of a roller with a crown against the room that the roller has for it.

    Of sharp ends: rounded ones may bear, and their pressure is judged.
    """
    from camgeom.mechanics.roller_duty import RollerDuty

    for duty in duties:
        if not isinstance(duty, RollerDuty) or duty.crowned is None or duty.ends.radius:
            continue
        along, room = duty.crowned.at_fullest
        yield judged(
            name, along, "<=", room, "mm",
            "a sharp end of the roller bears, whose pressure nothing bounds: use "
            f"{less_tilt(duty)}a stronger crown (a smaller {duty.table}.crown_radius), a longer roller, or give "
            f"{duty.table}.end_radius",
            cam_angle=duty.crowned.fullest.cam_angle,
            where=f"half-length of the contact ellipse, {duty.track.name}", worst="warn",
        )  # fmt: skip


def less_tilt(duty: RollerDuty) -> str:
    """Advice first of all where a crown's ellipse has its room on a roller that stands square; empty elsewhere."""
    square = duty.squared
    if square is None or square[1].crowned is None or square[1].crowned.fullest.value > 1.0:
        return ""
    return f"a smaller {square[0]}, "


@check("free-ends", "crowned load")
def free_ends(model: Model) -> Iterable[Finding]:
    """Whether an end bears at all where roller.free_ends says how: no contact that ends within its room asks for it."""
    if model.profile.dynamics_spec is not None or model.profile.impact_spec is not None:
        return  # ends may bear under the forces solved there
    shares = [share for share in (_to_the_end(duty) for duty in model.duties) if share is not None]
    if model.turret_duty is not None and model.turret_duty.ends.mirrored and model.turret_duty.finite is not None:
        shares.append(model.turret_duty.finite.hardest[1].to_the_end)
    if shares and max(shares) < 1.0:
        advice = "leave roller.free_ends out: no end bears, and it says nothing"
        where = "share of the way to its end or room that a contact fills"
        yield judged("free-ends", max(shares), ">=", 1.0, "1", advice, where=where, worst="warn")


def _to_the_end(duty: RollerDuty) -> float | None:
    """Share of the way to the end that a contact fills at its hardest; None where its free ends are those of a
    half-space."""
    if not duty.ends.mirrored:
        return None
    if duty.finite is not None:
        return duty.finite.hardest[1].to_the_end
    return None if duty.crowned is None else duty.crowned.fullest.value


@solved("dynamic-crown-length", "dynamics", "crowned load")
def dynamic_crown_length(model: Model) -> Iterable[Finding]:
    """Whether a crown's contact ellipse ends within its roller under the periodic contact force."""
    yield from crown_lengths("dynamic-crown-length", model.dynamic_duties)


@solved("impact-crown-length", "impact", "crowned load")
def impact_crown_length(model: Model) -> Iterable[Finding]:
    """The same under the forces of the counted turns, of which the longest ellipse counts."""
    found = [one for duties in model.impact_duties for one in crown_lengths("impact-crown-length", duties)]
    yield from sorted(found, key=lambda one: -(one.value or 0.0))[:1]


@check("load", "operation", summed=True)
def load(model: Model) -> Iterable[Finding]:
    """Whether anything presses the cam at all, in every operating state."""
    peaks = [(force, one.state) for one in model.states if (force := one.peak_force) is not None]
    if not peaks:
        return
    peak, state = min(peaks, key=lambda pair: pair[0].value)
    if peak.value > 0.0:
        peak, state = max(peaks, key=lambda pair: pair[0].value)
    where = f"state {state.name!r}: largest contact force" if state is not None else "largest contact force"
    yield judged("load", peak.value, ">", 0.0, "N", "nothing presses the cam: give mass, friction, force or spring",
                 cam_angle=peak.cam_angle, where=where, worst="warn")  # fmt: skip


@check("moving-mass", "operation")
def moving_mass(model: Model) -> Iterable[Finding]:
    """Whether the mass or inertia of what moves is stated, a zero too; what is not stated has none.

    That of a plate, or of a frame that is a part, is known: what moves is not lighter.
    """
    operation, follower = model.profile.operation, model.mechanism.follower
    if operation is None:
        return
    key, unit = ("inertia", "kg m2") if model.mechanism.follower.rotating else ("mass", "kg")
    stated = key in follower.model_fields_set or f"load_{key}" in operation.model_fields_set
    advice = f"follower.{key} is not given, so no inertia force is counted: give it, or operation.load_{key}"
    if not stated and model.frame_mass is None:
        yield judged("moving-mass", 0.0, ">", 0.0, unit, advice, where=f"follower.{key}", worst="warn")
    drive = model.slide_drive
    if drive is not None and drive.mass is not None:
        own = sum(body.mass for body in model.mass)
        advice = "cam.moving_mass is that of the plate and of what carries it"
        yield judged("moving-mass", drive.mass, ">=", own, "kg", advice, slack=MASS_SLACK * own,
                     where="cam.moving_mass, against the plate's own")  # fmt: skip
    if model.frame_mass is not None:
        own = model.frame_mass
        advice = "give follower.mass and operation.load_mass: those of the frame's plate and of all that it carries"
        yield judged("moving-mass", follower.moving(operation.load_mass, 0.0), ">=", own, "kg", advice,
                     where="follower, against the frame's own plate")  # fmt: skip


@check("hardness", "operation")
def hardness(model: Model) -> Iterable[Finding | NotJudged]:
    """The pressure that the verdict lets cam and roller bear against what steel of their surface hardness bears.

    That is the limit of their pressure or that of their lives, whichever is higher. A knife edge has no pressure.
    """
    if model.carrier is None or model.carrier.least_peak is None:
        return
    for body, material in _bodies(model):
        if material.hardness is None:
            yield NotJudged("hardness", f"give material.{body}.hardness, HRC: the contact limit of "
                            f"{material.contact_limit:.6g} MPa is taken as it stands")  # fmt: skip
            continue
        bound, allowed = hardness_bound(material.hardness), max(model.pressure_limit, material.rated_limit)
        key = f"material.{body}.contact_limit" if allowed == material.rated_limit else "limits.contact_pressure_mpa"
        source = "endurance of steel at 60 HRC" if bound == CONTACT_LIMIT else "load classes of T/WLJC 15-2018"
        advice = (
            f"a surface of {material.hardness:.6g} HRC is taken to bear {bound:.6g} MPa at {CONTACT_CYCLES:.0e} cycles "
            f"({source}): lower {key} or harden the surface"
        )
        yield judged("hardness", allowed, "<=", bound, "MPa", advice, slack=1e-9 * bound, where=f"{body}, {key}")


def _cased(
    name: str, model: Model, duties: Sequence[Duty], rigid: bool = False
) -> Iterable[Finding | NotJudged]:
    """The largest shear, where over the turn it lies deepest, against every case; silent of a material without one.

    rigid: whether the depth under the rigid load is told beside
    """
    cases = [(body, material) for body, material in _bodies(model) if material.case_depth_mm is not None]
    known = [(duty, depth) for duty in duties if (depth := duty.least_shear) is not None] if cases else []
    # Of a sharp end that bears the depth inside of it is known: it may be too deep, and is never shallow enough.
    lost = bool(cases) and any(duty.deepest_shear is None for duty in duties)
    untold = lost and not known
    for body, material in cases if known else ():
        assert material.case_depth_mm is not None
        duty, deepest = max(known, key=lambda pair: pair[1].value)
        limit = CASE_SHARE * material.case_depth_mm
        if lost and deepest.value <= limit:
            untold = True
            continue
        rigidly = [one.deepest_shear for one in model.carriers] if rigid else []
        advice = (
            "the largest shear lies deeper than half the case (camgeom's own rule, not a standard's): harden deeper "
            f"or lower the load on the {body}"
        )
        yield judged(name, deepest.value, "<=", limit, "mm", advice, cam_angle=deepest.cam_angle,
                     where=f"{body}, {duty.spot(deepest)}",
                     rigid=max((one.value for one in rigidly if one is not None), default=None))  # fmt: skip
    if untold:
        yield NotJudged(name, "no stress can be given below this contact: see the checks of its pressure")


@check("case-depth", "operation")
def case_depth(model: Model) -> Iterable[Finding | NotJudged]:
    """Half the case reaches below the largest shear of the rigid contact, all round."""
    yield from _cased("case-depth", model, model.carriers)


@solved("dynamic-case-depth", "dynamics")
def dynamic_case_depth(model: Model) -> Iterable[Finding | NotJudged]:
    """The same with vibration."""
    if not _has_case(model):
        return
    if not model.dynamic_duties:
        yield NotJudged("dynamic-case-depth", LIFTED)
    yield from _cased("dynamic-case-depth", model, model.dynamic_duties, rigid=True)


@solved("impact-case-depth", "impact")
def impact_case_depth(model: Model) -> Iterable[Finding | NotJudged]:
    """The same over the turns that [impact] counts."""
    if _has_case(model):
        every = [duty for turn in model.impact_duties for duty in turn]
        yield from _cased("impact-case-depth", model, every, rigid=True)


def _has_case(model: Model) -> bool:
    return any(material.case_depth_mm is not None for _, material in _bodies(model))


def _bodies(model: Model) -> tuple[tuple[str, Material], ...]:
    """The two bodies in contact by the name of their key."""
    return ("cam", model.profile.material.cam), ("roller", model.profile.material.roller)
