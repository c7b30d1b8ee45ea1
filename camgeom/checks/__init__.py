"""Checks: facts judged against limits. One idea a file, found by file name; each is a function (Model) -> judgements.

A check module defines `@check("name", *needs)` functions that give findings (see `camgeom.checks.verdict`), or
`NotJudged` where something is missing that the check itself knows of. `NEEDS` names what a check is about: where the
cam has no such thing the check does not apply and says nothing; where it has, but the profile does not give what is
wanted, the verdict tells that it was not judged, and what to give.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import wraps
from importlib import import_module
from math import isfinite, pi
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Literal, TypeVar, final

from camgeom.checks.verdict import RANK, Finding, Level, Loads, NotJudged, Verdict, judged, life_told
from camgeom.errors import DesignError, NotConverged, Unmade, unmade
from camgeom.immutable import immutable
from camgeom.maths import within_range

if TYPE_CHECKING:
    from camgeom.mechanics.duty import Duty
    from camgeom.model import Model
    from camgeom.model.vibration import Turn

Judge = Callable[["Model"], Iterable[Finding | NotJudged]]
Need = Literal[
    "body", "solid", "tracks", "planar", "profiles", "arm", "turret", "operation", "rated", "roller load",
    "crowned load", "face load", "turret load", "dynamics", "impact", "cutter", "root", "tolerance", "shaft",
    "any rated",
]
OWN = frozenset({"rated", "any rated", "root", "tolerance"})
"""needs beside those of LOADED of checks that every follower on a track is judged by; all others see the track alone"""
LOADED: frozenset[Need] = frozenset(
    {"operation", "roller load", "crowned load", "face load", "turret load", "dynamics", "impact"}
)
"""what changes with the operating state: a check that needs any of these is asked in every state of [[duty]]"""
LIFTED = "the follower leaves its cam (see lift-off), so there is no periodic force to judge"
COARSEST = 0.01
"""largest error, as a share of the peak, of a vibration that is judged"""
NO_STRESS = (
    "the body has no bore that could hold it, its groove is no closed ring, a wall beside another track leans, or "
    "there is no [operation]"
)
LIMIT = "material.cam.bending_limit"
FRAME_LIMIT = "material.roller.bending_limit"
NO_LIMIT = "give {}, MPa, and the body is solved; `solve --only body` shows its stress without"
NO_OPERATION = "no [operation]: give operation.speed and what acts on the follower"


def _load(model: Model, applies: object) -> bool | str:
    """Whether there is a load on what a check is about; why not, where only the profile's [operation] is missing."""
    return bool(applies) and (model.profile.operation is not None or NO_OPERATION)


def judged_pressure(
    name: str, model: Model, duties: Iterable[Duty], remedy: str, rigid: Duty | None = None, worst: Level = "fail"
) -> Iterable[Finding | NotJudged]:
    """The largest pressure of duties against the limit; where none is the largest it is not judged, and says why.

    It fails where already the pressure that it surely reaches is beyond the limit.
    """
    each = tuple(duties)
    known = [(peak, duty) for peak, duty in ((duty.least_peak, duty) for duty in each) if peak is not None]
    lost = no_stress(each)
    if not known or (lost and max(peak.value for peak, _ in known) <= model.pressure_limit):
        yield NotJudged(name, lost)
        return
    peak, duty = max(known, key=lambda pair: pair[0].value)
    if not isfinite(peak.value):
        advice = "the flank that is pressed folds, or has a corner, where no pressure is to be judged: see undercut, "
        advice += "face-curvature and continuity"
        yield Finding(name, worst, None, "<=", model.pressure_limit, "MPa", where=duty.spot(peak), advice=advice)
        return
    if peak.value > model.pressure_limit:
        remedy = squared_remedy(duty, model.pressure_limit) or remedy
    beside = rigid.peak_pressure if rigid is not None else None
    where = f"{duty.spot(peak)}, at least: {duty.no_stress.partition(':')[0]}" if duty.no_stress else duty.spot(peak)
    yield judged(name, peak.value, "<=", model.pressure_limit, "MPa", remedy, cam_angle=peak.cam_angle, where=where,
                 worst=worst, rigid=beside.value if beside is not None else None)  # fmt: skip


def squared_remedy(duty: Duty, limit: float) -> str:
    """Advice where the tilt of a roller alone brings its pressure, MPa, beyond the limit; empty where it does not.

    Looked at where the tilted roller presses hardest: a whole turn without tilt is much work for a word.
    """
    if duty.squared is None or duty.square_spot is None or duty.square_spot > limit:
        return ""
    return f"a smaller {duty.squared[0]}: without it the roller presses there with {duty.square_spot:.6g} MPa"


def no_stress(duties: Iterable[Duty]) -> str:
    """Why one of some duties has no largest pressure; empty where all have one."""
    return next((duty.no_stress for duty in duties if duty.no_stress), "")


def _crowned(model: Model) -> bool:
    return any(roller.shape in ("crowned", "sphere") for roller in model.profile.rollers.values())


def judged_lives(
    name: str, model: Model, lives: Mapping[str, float], remedy: str, basis: str = "", lost: str = ""
) -> Iterable[Finding | NotJudged]:
    """The lives, h, of bodies against the profile's; without one they are told, and what to give.

    basis: what the lives rest on, beside the body's name; lost: why surfaces have none, a knife's or a sharp end's
    """
    limit = model.profile.limits.life_h
    if limit is None:
        each = ", ".join(f"{body} {life_told(hours)}" for body, hours in lives.items())
        if lives:
            yield NotJudged(name, f"give limits.life_h, the hours that these lives have to reach: {each}")
        return
    if lost:
        yield NotJudged(name, lost)
    for body, least in lives.items():
        where = f"{body}, {basis}" if basis else body
        yield judged(name, least, ">=", limit, "h", remedy, where=where, unlimited=True)


def _rated(model: Model) -> bool:
    return any(roller.dynamic_rating is not None for roller in model.profile.rollers.values())


def _root(model: Model) -> bool | str:
    """Whether the stress at a root is asked for; why it is not judged, where there is a round root or a limit."""
    if model.root_limit is not None:
        return model.root_stress is not None or NO_STRESS
    if model.profile.operation is None:
        return False
    if model.mechanism.frame is not None:
        return NO_LIMIT.format(FRAME_LIMIT) if model.mechanism.frame.corner else False
    round_ = model.mechanism.root_radius > 0.0 and LIMIT not in model.cam.idle(model.setup)
    return NO_LIMIT.format(LIMIT) if round_ else False


NEEDS: dict[Need, Callable[[Model], bool | str]] = {
    "body": lambda model: True,
    "solid": lambda model: True,
    "tracks": lambda model: bool(model.tracks),
    "planar": lambda model: model.planar is not None,
    "profiles": lambda model: model.profiles is not None,
    "arm": lambda model: model.profile.follower.kind == "swinging",
    "turret": lambda model: model.mechanism.turret is not None,
    "operation": lambda model: True,
    "rated": lambda model: _rated(model),
    "any rated": lambda model: any(_rated(one) for one in model.bindings),
    "roller load": lambda model: _load(model, model.tracks and not model.mechanism.turret and model.setup.roller),
    "crowned load": lambda model: _load(model, _crowned(model)),
    "face load": lambda model: _load(model, model.mechanism.touches and not model.setup.roller),
    "turret load": lambda model: _load(model, model.mechanism.turret),
    "dynamics": lambda model: _load(model, model.profile.dynamics_spec),
    "impact": lambda model: _load(model, model.profile.impact_spec),
    "cutter": lambda model: model.profile.cutter_spec is not None,
    "root": lambda model: _root(model),
    "tolerance": lambda model: model.profile.tolerance_spec is not None,
    "shaft": lambda model: True,
}
"""What a check may need: True where it is there, False where the check does not apply, or what is missing.

"body" and "shaft", the camshaft, are judged once for all followers; "solid" marks what takes a mesh, "operation" what
hangs on the load."""


@final
@immutable(eq=True)
class Check:
    """A registered check: its name, what it needs, the judging function, whether it sums over operating states, and
    whether it takes long for what it needs."""

    name: str
    needs: tuple[Need, ...]
    judge: Judge
    summed: bool = False
    slow: bool = False


_REGISTRY: dict[str, Check] = {}


def check(name: str, *needs: Need, summed: bool = False, slow: bool = False) -> Callable[[Judge], Judge]:
    """Register a judging function under a name; see `NEEDS`.

    summed: it sums over the operating states itself; slow: who waits for the others is not to wait for it
    """

    def register(judge: Judge) -> Judge:
        _REGISTRY[name] = Check(name, needs, judge, summed, slow)
        return judge

    return register


def solved(
    name: str, *needs: Need, turn: Turn = "steady", summed: bool = False, slow: bool = False
) -> Callable[[Judge], Judge]:
    """Register a check of what a solver finds; where it finds nothing, the check is not judged and says why.

    turn: of [dynamics], whose solution has to be fine enough where something is found
    """

    def register(judge: Judge) -> Judge:
        @wraps(judge)
        def answered(model: Model) -> Said:
            try:
                said = list(judge(model))
                if "dynamics" in needs and any(isinstance(word, Finding) for word in said):
                    for state in model.states if summed else (model,):
                        refuse_coarse(state, turn)
                return said
            except NotConverged as lost:
                return [NotJudged(name, str(lost))]

        return check(name, *needs, summed=summed, slow=slow)(answered)

    return register


def refuse_coarse(model: Model, turn: Turn = "steady") -> None:
    """NotConverged where a turn of [dynamics] is too coarse to be judged, or nobody knows how coarse."""
    from camgeom.dynamics.linear.solve import Growing
    from camgeom.model.vibration import solved_turn

    try:
        found = solved_turn(model, turn)
        assert found is not None, "the registry asks for it"
        error = float(found.solution.error[0])
    except Growing:
        # What grows is no matter of accuracy: `stability` judges it, the others say so.
        return
    if not error <= COARSEST:
        known = f"is {error:.3g} of the peak by halving" if isfinite(error) else "is not known"
        raise NotConverged(f"the error of the solution {known}, more than {COARSEST:g}: leave dynamics.steps out, or "
                           "give more of them, or a smaller dynamics.tolerance")  # fmt: skip


OF_SOME: dict[str, tuple[Need, ...]] = {
    "planar": ("profiles", "planar"), "turret": ("turret",), "dynamics": ("dynamics", "impact"),
    "cutter": ("cutter",), "root": ("root",), "tolerance": ("tolerance",), "bearing": ("rated", "any rated"),
}  # fmt: skip
"""Files of checks of which each needs one of these: not imported for a model that has none of them."""


def checks(model: Model | None = None) -> dict[str, Check]:
    """All checks by name; of a model, at least those that may apply to it."""
    bindings = model.bindings if model is not None else ()
    for module in iter_modules(__path__):
        needs = OF_SOME.get(module.name, ())
        if not (needs and bindings) or any(NEEDS[need](binding) for need in needs for binding in bindings):
            import_module(f"{__name__}.{module.name}")
    return dict(sorted(_REGISTRY.items()))


def light_checks() -> tuple[str, ...]:
    """Names of the checks that need no solid."""
    return tuple(name for name, one in checks().items() if "solid" not in one.needs)


def applies(entry: Check, model: Model) -> bool:
    """Whether a check has something to say of a model, also where it could only say what is missing."""
    return any(all(NEEDS[need](binding) is not False for need in entry.needs) for binding in model.bindings)


Said = list[Finding | NotJudged]
Heard = dict[str, tuple[Said, list[Unmade]]]
"""What checks have said of a model, and what of it could not be made, by check."""


def judge(model: Model, only: Iterable[str] | None = None, heard: Heard | None = None) -> Verdict:
    """The verdict on a model: every check that applies, or the named ones. A body that cannot be made fails.

    heard: what checks have said of this model before, which is not asked again; what others say is added
    Checks of the body judge it once, of geometry every track, of load and life every follower. A check whose figures
    cannot be computed is not judged, for the reason that they cannot; the others are.
    """
    wanted = None if only is None else set(only)
    known: Heard = {} if heard is None else heard
    names = [name for name in checks(model) if wanted is None or name in wanted]
    for name in names:
        if name not in known:
            known[name] = _heard(_REGISTRY[name], model)
    said = _told_once([word for name in names for word in known[name][0]])
    findings = tuple(word for word in said if isinstance(word, Finding))
    open_ = tuple(word for word in said if isinstance(word, NotJudged))
    lost = tuple((name, reason) for name in names for reason in known[name][1])
    return Verdict(findings, open_, lost, loads_of(model))


def _heard(entry: Check, model: Model) -> tuple[Said, list[Unmade]]:
    """What a check says of all followers that it is asked of, and what of it could not be made."""
    bindings = model.bindings if (LOADED | OWN) & set(entry.needs) else model.grooves
    if {"body", "cutter", "shaft"} & set(entry.needs):
        bindings = model.bindings[:1]
    lost: list[Unmade] = []
    each: list[tuple[Model, Said]] = []
    for binding in bindings:
        try:
            each.append((binding, _said(entry, binding)))
        except Exception as error:
            lost.append(unmade(error))
            each.append((binding, [NotJudged(entry.name, lost[-1].reason)]))
    return (each[0][1] if len(each) == 1 else _of_followers(each)), lost


def _told_once(said: Said) -> Said:
    """What is said, where one refusal (a follower that jams) leaves no load: `load` fails by it, and what is judged by
    the load is not judged."""
    causes = {word.advice for word in said if isinstance(word, Finding) and word.check == "load" and word.value is None}
    return [
        NotJudged(word.check, "no load can act, for the reason that `load` gives")
        if isinstance(word, Finding) and word.check != "load" and word.value is None and word.advice in causes
        else word
        for word in said
    ]


def loads_of(model: Model) -> Loads | None:
    """Whose loads a verdict judges; None without an [operation]."""
    profile = model.profile
    if profile.operation is None:
        return None
    moves = [span.end - span.start for one in model.bindings for span in one.mechanism.program.spans
             if span.law != "dwell"]  # fmt: skip
    shortest = 1e3 * min(moves) * 30.0 / (pi * (profile.fastest or 0.0)) if moves else None
    return Loads(profile.dynamics_spec is not None, profile.impact_spec is not None, shortest)


def _of_followers(each: list[tuple[Model, Said]]) -> Said:
    """What a check says of several followers, which are named; what is not judged of any for one reason is said once.
    """
    alike = [word for word in each[0][1] if isinstance(word, NotJudged) and all(word in said for _, said in each)]
    named = (_named(f"follower {one.number + 1}", [word for word in said if word not in alike]) for one, said in each)
    return [*alike, *(word for words in named for word in words)]


def _said(entry: Check, model: Model) -> Said:
    """What a check says of one follower; of operating states the hardest."""
    if not model.profile.duty or entry.summed or not LOADED & set(entry.needs):
        return _said_of(entry, model)
    return _hardest([(one.state.name if one.state else "", _said_of(entry, one)) for one in model.states])


def _hardest(states: list[tuple[str, Said]]) -> Said:
    """Of what a check says in every operating state the worst of each finding, and what is not judged in any of them.

    A check says the same things in the same order, so the n-th finding of every state is of one thing.
    """
    findings: dict[int, list[tuple[str, Finding]]] = {}
    omitted: dict[str, list[str]] = {}
    for name, said in states:
        for number, word in enumerate(said):
            if isinstance(word, Finding):
                findings.setdefault(number, []).append((name, word))
            else:
                omitted.setdefault(word.reason, []).append(name)
    worst: list[Finding] = []
    for _, each in sorted(findings.items()):
        name, hardest = max(each, key=lambda pair: _severity(pair[1]))
        alike = len(each) == len(states) and all(word == hardest for _, word in each)
        worst += [hardest] if alike else _named(f"state {name!r}", [hardest])
    check_name = next((word.check for _, said in states for word in said), "")
    reasons = [
        reason if len(names) == len(states) else f"state {', '.join(map(repr, names))}: {reason}"
        for reason, names in omitted.items()
    ]
    return [*worst, *(NotJudged(check_name, reason) for reason in reasons)]


def _severity(finding: Finding) -> tuple[int, bool, float]:
    """The order of findings of one thing: level, then whether it has no value, then how little room is left."""
    value = finding.value or 0.0
    sign = -1.0 if finding.comparison in (">=", ">") else 1.0
    room = finding.margin if finding.margin is not None else -sign * value
    return RANK[finding.level], finding.value is None and finding.level != "pass", -room


F = TypeVar("F", Finding, NotJudged, Finding | NotJudged)


def _named(who: str, said: list[F]) -> list[F]:
    """What is said, with the follower or the state that it is said of."""
    return [
        replace(word, where=f"{who}: {word.where}" if word.where else who)
        if isinstance(word, Finding)
        else replace(word, reason=f"{who}: {word.reason}")
        for word in said
    ]


def _said_of(entry: Check, model: Model) -> Said:
    """What a check says of a follower in one operating state."""
    answers = [NEEDS[need](model) for need in entry.needs]
    if any(answer is False for answer in answers):
        return []
    missing = [answer for answer in answers if isinstance(answer, str)]
    if missing:
        return [NotJudged(entry.name, "; ".join(missing))]
    said: Said
    try:
        with within_range(f"check {entry.name}"):
            said = list(entry.judge(model))
    except DesignError as refusal:
        said = [Finding(entry.name, "fail", None, "", None, "", advice=str(refusal))]
    return said


def findings(model: Model, only: Iterable[str] | None = None) -> tuple[Finding, ...]:
    """The findings of a model's verdict."""
    return judge(model, only).findings
