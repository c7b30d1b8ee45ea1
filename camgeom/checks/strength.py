"""Contact pressure, fatigue life, hardness and case against the profile's limits, whoever presses the cam.

One judgement a question; its name and advice are those of the carrier: a roller, faces, a turret's rollers that share.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from camgeom.checks import KNIFE, Need, check, solved
from camgeom.checks.verdict import Finding, NotJudged, judged
from camgeom.mechanics.material import CASE_SHARE, CONTACT_CYCLES, CONTACT_LIMIT, Material, hardness_bound

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model



def pressure(name: str, remedy: str, model: Model) -> Iterable[Finding | NotJudged]:
    """Peak contact pressure: of the hardest place along a roller, of all rollers that share, of all faces."""
    if model.carrier is None:
        return
    peak = model.carrier.peak_pressure
    if peak is None:
        yield NotJudged(name, KNIFE)
        return
    material = model.profile.material
    limit = model.profile.limits.contact_pressure_mpa or min(material.cam.contact_limit, material.roller.contact_limit)
    where = peak.where or f"slice at {peak.place:.4g} mm along the roller axis"
    yield judged(name, peak.value, "<=", limit, "MPa", remedy, cam_angle=peak.cam_angle, where=where)


def life(name: str, remedy: str, model: Model) -> Iterable[Finding | NotJudged]:
    """Fatigue life at the hardest place of roller or face and cam, and of the bearing of a roller that is rated."""
    limit = model.profile.limits.life_h
    if limit is None:
        return
    from camgeom.mechanics.duty import least_lives

    lives = least_lives(model.carriers)
    if not lives:
        yield NotJudged(name, KNIFE)
    for body, least in lives.items():
        yield judged(name, least, ">=", limit, "h", remedy, where=body, unlimited=True)


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
    check(_name, _need)(partial(_judge, _name, _remedy))


@check("crown-length", "roller load", "crowned load")
def crown_length(model: Model) -> Iterable[Finding]:
    """Whether the contact ellipse of a crowned roller ends within its length; beyond it the ends press too."""
    for duty in model.duties:
        if duty.ellipse is None:
            continue
        at = int(duty.ellipse.along.argmax())
        # Above a whole length the ends bear more than the middle (see `hertz.crowned_contact`).
        low = float(duty.ellipse.along.flat[at]) > duty.length
        shown = "what is shown for them is up to 9 % low over a ninth of the length" if low else "the middle bears most"
        yield judged(
            "crown-length",
            float(duty.ellipse.along.flat[at]),
            "<=",
            0.5 * duty.length,
            "mm",
            f"the roller's ends bear ({shown}; a sharp edge has no bound): use a stronger crown (a smaller "
            "crown_radius) or a longer roller",
            cam_angle=float(duty.force.panels.theta.flat[at]),
            where=f"half-length of the contact ellipse, {duty.track.name}",
            worst="warn",
        )


@check("load")
def load(model: Model) -> Iterable[Finding]:
    """Whether anything presses the cam at all."""
    if model.carrier is None:
        return
    peak = model.carrier.peak_force
    yield judged("load", peak.value, ">", 0.0, "N", "nothing presses the cam: give mass, friction, force or spring",
                 cam_angle=peak.cam_angle, where="largest contact force", worst="warn")  # fmt: skip


@check("moving-mass")
def moving_mass(model: Model) -> Iterable[Finding]:
    """Whether the mass or inertia of what moves is stated, a zero too; what is not stated has none."""
    operation, follower = model.profile.operation, model.mechanism.follower
    if operation is None:
        return
    key, unit = ("inertia", "kg m2") if model.mechanism.follower.rotating else ("mass", "kg")
    stated = key in follower.model_fields_set or f"load_{key}" in operation.model_fields_set
    advice = f"follower.{key} is not given, so no inertia force is counted: give it, or operation.load_{key}"
    if not stated:
        yield judged("moving-mass", 0.0, ">", 0.0, unit, advice, where=f"follower.{key}", worst="warn")


@check("hardness")
def hardness(model: Model) -> Iterable[Finding | NotJudged]:
    """Contact limit of cam and roller against what steel of their surface hardness bears."""
    if model.carrier is None:
        return
    for body, material in _bodies(model):
        if material.hardness is None:
            yield NotJudged("hardness", f"give material.{body}.hardness, HRC: the contact limit of "
                            f"{material.contact_limit:.6g} MPa is taken as it stands")  # fmt: skip
            continue
        bound = hardness_bound(material.hardness)
        source = "endurance of steel at 60 HRC" if bound == CONTACT_LIMIT else "load classes of T/WLJC 15-2018"
        advice = (
            f"a surface of {material.hardness:.6g} HRC is taken to bear {bound:.6g} MPa at {CONTACT_CYCLES:.0e} cycles "
            f"({source}): lower material.{body}.contact_limit or harden the surface"
        )
        yield judged("hardness", material.rated_limit, "<=", bound, "MPa", advice, slack=1e-9 * bound, where=body)


def _case(name: str, model: Model, duties: Callable[[], Iterable[Duty]]) -> Iterable[Finding | NotJudged]:
    """Depth of the largest shear below the hardest contacts against the hardened case; silent of a material without."""
    for body, material in _bodies(model):
        if material.case_depth_mm is None:
            continue
        beneath = [duty.peak_contact for duty in duties()]
        depths = [one.shear_depth for one in beneath if one is not None]
        if not depths or len(depths) < len(beneath):
            yield NotJudged(name, "no stress can be given below this contact: see the checks of its pressure")
            continue
        limit = CASE_SHARE * material.case_depth_mm
        advice = (
            "the largest shear lies deeper than half the case (camgeom's own rule, not a standard's): harden deeper "
            f"or lower the load on the {body}"
        )
        yield judged(name, max(depths), "<=", limit, "mm", advice, where=body)


@check("case-depth")
def case_depth(model: Model) -> Iterable[Finding | NotJudged]:
    """Half the case reaches below the largest shear of the rigid contact."""
    if model.carrier is not None:
        yield from _case("case-depth", model, lambda: model.carriers)


@solved("dynamic-case-depth", "dynamics")
def dynamic_case_depth(model: Model) -> Iterable[Finding | NotJudged]:
    """The same with vibration."""
    yield from _case("dynamic-case-depth", model, lambda: model.dynamic_duties)


@solved("impact-case-depth", "impact")
def impact_case_depth(model: Model) -> Iterable[Finding | NotJudged]:
    """The same over the turns that [impact] counts."""
    yield from _case("impact-case-depth", model, lambda: [duty for turn in model.impact_duties for duty in turn])


def _bodies(model: Model) -> tuple[tuple[str, Material], ...]:
    """The two bodies in contact by the name of their key."""
    return ("cam", model.profile.material.cam), ("roller", model.profile.material.roller)
