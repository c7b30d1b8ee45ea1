"""A globoidal indexing drive designed from what it has to do, by the order of T/WLJC 15-2018, section 6.

Motion law, basic parameters, rollers and radii, flank, strength; every choice is given with its reason, and the result
is a profile that has been checked. Where a check still fails the choice behind it is changed and tried again.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import atan, ceil, degrees, floor, hypot, pi, radians, sin, sqrt, tan

from camgeom.checks import findings
from camgeom.checks.verdict import Finding
from camgeom.design import Choice, Design
from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.mechanics.grades import material_for, speed_class
from camgeom.model import Model
from camgeom.motion import LAWS
from camgeom.profile import parse
from camgeom.profile.text import word


@immutable(eq=True)
class RollerSize:
    """A stud cam follower: diameter and ring width, mm; dynamic and static ratings, N."""

    diameter: float
    width: float
    dynamic: float
    static: float


ROLLERS = (
    RollerSize(16, 11, 3000, 3000),
    RollerSize(19, 11, 3500, 4000),
    RollerSize(22, 12, 4500, 5200),
    RollerSize(26, 12, 5200, 6000),
    RollerSize(30, 14, 6800, 8300),
    RollerSize(32, 14, 7000, 8800),
    RollerSize(35, 18, 9700, 14000),
    RollerSize(40, 20, 10900, 14500),
    RollerSize(47, 24, 15500, 25000),
    RollerSize(52, 24, 16800, 29000),
    RollerSize(62, 29, 26000, 48000),
    RollerSize(72, 29, 28000, 53000),
    RollerSize(80, 35, 38000, 77000),
    RollerSize(90, 35, 39000, 80000),
)
"""Usual outside diameters and widths of stud cam followers; ratings are figures on the cautious side of what such sizes
have. The figures of the follower that is bought replace them in the profile."""

BORES = (12, 16, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 80, 90, 100, 110, 120)
"""mm, usual shaft diameters"""


SEAT = 2.0
"""mm between the turret's body and the blank (T/WLJC 15-2018: 1 to 5 mm)"""


@immutable(eq=True)
class Wanted:
    """What the drive has to do: angles deg, lengths mm, speed r/min, inertia kg m², torque N m, life h, pressure MPa.

    Pressure angle and contact pressure are the largest allowed, the latter by default what the material bears. Either
    the centre distance or the envelope (the largest length of cam and turret together) is given. A law that is named
    is taken; else load and speed choose it, or the accuracy in the dwell where that counts most.
    """

    stops: int
    motion_angle: float
    speed: float
    inertia: float
    torque: float
    life: float
    center_distance: float | None = None
    envelope: float | None = None
    name: str = "globoidal indexer"
    pressure_angle: float = 50.0
    contact_pressure: float | None = None
    law: str | None = None
    accurate_dwell: bool = False

    def problems(self) -> list[Problem]:
        """What is out of range."""
        found = []
        for key, low, high in (
            ("stops", 1, 48), ("motion_angle", 30.0, 330.0), ("speed", 0.1, 3000.0), ("inertia", 0.0, 1e4),
            ("torque", 0.0, 1e6), ("life", 1.0, 1e7), ("center_distance", 40.0, 1500.0), ("envelope", 80.0, 5000.0),
            ("pressure_angle", 15.0, 75.0), ("contact_pressure", 1.0, 1e5),
        ):
            value = getattr(self, key)
            if value is not None and not low <= value <= high:
                found.append(Problem(f"--{key.replace('_', '-')}", "out of range", value, f"{low:g} to {high:g}"))
        if (self.center_distance is None) == (self.envelope is None):
            found.append(Problem("--center-distance", "give either the centre distance or the envelope"))
        if self.law is not None and self.accurate_dwell:
            found.append(Problem("--law", "give either the law or --accurate-dwell, which chooses one"))
        smooth = [name for name, law in LAWS.items() if law.claims.order >= 2]
        if self.law is not None and self.law not in smooth:
            found.append(Problem("--law", "no law of continuous acceleration (section 7.2)", self.law,
                                 ", ".join(smooth)))
        return found


@immutable(eq=True)
class Candidate:
    """Numbers of one trial; mm."""

    centre: float
    pitch: float
    roller: RollerSize
    length: float
    width: float
    rollers: int
    form: str
    law: str
    bore: float

    @property
    def globoid(self) -> float:
        """Globoid radius."""
        return round(self.pitch - 0.5 * self.length + SEAT, 2)


def profile_text(wanted: Wanted, trial: Candidate, material: tuple[str, float, float] | None) -> str:
    """The profile."""
    start = 0.5 * (360.0 - wanted.motion_angle)
    name, pressure, hardness = material or ("hardened steel", 1300.0, 60.0)
    most = "" if wanted.contact_pressure is None else f"contact_pressure_mpa = {wanted.contact_pressure:g}\n"
    return f"""# Designed by `camgeom design globoidal` from: {wanted.stops} stops, moving {wanted.motion_angle:g} deg,
# {wanted.speed:g} r/min, inertia {wanted.inertia:g} kg m2, load {wanted.torque:g} N m, life {wanted.life:g} h.

name = {word(wanted.name)}

[cam]
kind = "globoidal"
form = "{trial.form}"
hand = "right"
center_distance = {trial.centre:g}
width = {trial.width:g}
globoid_radius = {trial.globoid:g}
tip_clearance = 0.8
bore = {trial.bore:g}

[follower]
kind = "turret"
stops = {wanted.stops}
rollers = {trial.rollers}
pitch_radius = {trial.pitch:g}
inertia = {wanted.inertia:g}

[roller]
shape = "cylinder"
diameter = {trial.roller.diameter:g}
length = {trial.length:g}
dynamic_rating = {trial.roller.dynamic:g}
static_rating = {trial.roller.static:g}

[[motion]]
until = {start:.10g}

[[motion]]
until = {start + wanted.motion_angle:.10g}
to = {360.0 / wanted.stops:.12g}
law = "{trial.law}"

[[motion]]
until = 360

[operation]
speed = {wanted.speed:g}
friction = {1e3 * wanted.torque:g}

[material.cam]
name = "{name}"
hardness = {hardness:g}
contact_limit = {pressure:g}
contact_cycles = 1e7

[limits]
life_h = {wanted.life:g}
pressure_angle_deg = {wanted.pressure_angle:g}
{most}min_wall_mm = {max(1.0, round(0.1 * trial.roller.diameter, 1)):g}

[output]
tolerance = 0.01
formats = ["3mf", "stl"]
"""


AIM = 0.8
"""share of the largest pressure angle aimed at on the pitch radius: 40 of 50 degrees; along the roller it grows"""
LEAST_RATIO, MOST_RATIO = 0.30, 0.66
"""rf / C below which ribs get weak, above which the cam gets thin"""
JUDGED = (
    ("hand-over", "pressure-angle", "turret-gap", "undercut", "relative-curvature", "continuity"),
    ("turret-pressure", "turret-life"),
    ("rib-thickness",),
)
"""checks that need no solid, the quick ones first: the trial of a candidate"""
TRIAL_TOLERANCE = 0.05
"""mm; of the solid that the finished design is checked with"""


def design(wanted: Wanted) -> Design:
    """The profile of a drive that passes its checks.

    Raises ProfileError for wrong inputs and DesignError, with the nearest limit, where no such drive can be found.
    """
    if problems := wanted.problems():
        raise ProfileError(problems)
    law, law_why = _law(wanted)
    rollers, form, form_why = _arrangement(wanted)
    ratio, ratio_why = _ratio(wanted, law)
    worst: tuple[Finding, ...] | None = None
    overloaded: set[tuple[float, float]] = set()
    for trial in _candidates(wanted, law, rollers, form, ratio):
        # Neither a wider cam nor a smaller roller takes the load better.
        if any(trial.pitch == pitch and trial.roller.diameter <= size for pitch, size in overloaded):
            continue
        failed, model = _tried(wanted, trial)
        if not failed and model is not None:
            return _finish(wanted, trial, model, (law_why, form_why, ratio_why))
        worst = failed
        if {f.check for f in failed} <= {"turret-pressure", "turret-life"}:
            overloaded.add((trial.pitch, trial.roller.diameter))
    if worst is None:
        smallest = f"the smallest of the series, {ROLLERS[0].diameter:g} mm"
        raise DesignError(
            f"no drive of this size can be tried: {rollers} rollers on a turret whose share of the centre distance is "
            f"{ratio:.3g} by the pressure angle leave no room for a roller ({smallest}), for a shaft, or for a cam "
            "narrow enough; give more centre distance, fewer stops, or another pressure angle"
        )
    reasons = "; ".join(f"{f.check} {f.where} {'' if f.value is None else format(f.value, '.4g')}: {f.advice}"
                        for f in worst)
    raise DesignError(f"no drive of this size does it; the last one tried fails: {reasons}")


def _tried(wanted: Wanted, trial: Candidate) -> tuple[tuple[Finding, ...], Model | None]:
    """What fails of a candidate (the quick checks first), and its model."""
    try:
        model = Model(parse(profile_text(wanted, trial, None)))
        for checks in JUDGED:
            failed = tuple(f for f in findings(model, checks) if not f.passed)
            if failed:
                return failed, None
    except (ProfileError, DesignError) as refusal:
        return (Finding("profile", "fail", None, "", None, "", advice=str(refusal)),), None
    return (), model


def _law(wanted: Wanted) -> tuple[str, Choice]:
    """Motion law as given, by the accuracy in the dwell, or by load and speed (section 7.4 of the specification)."""
    index, angle = 2.0 * pi / wanted.stops, radians(wanted.motion_angle)
    omega = wanted.speed * pi / 30.0
    inertial = wanted.inertia * index * (omega / angle) ** 2 * LAWS["modified-sine"].claims.am
    if wanted.law is not None:
        name, why = wanted.law, "given"
    elif wanted.accurate_dwell:
        name, why = "universal-asymmetric", "accuracy in the dwell: it slows down for longer than it speeds up"
    elif wanted.torque > 2.0 * inertial:
        name = "modified-constant-velocity"
        why = f"low speed, heavy load ({wanted.torque:.4g} N m against {inertial:.4g} N m of inertia): low Vm"
    elif wanted.speed > 400.0 and inertial > 5.0 * wanted.torque:
        name = "modified-trapezoid"
        why = f"high speed, load of inertia ({inertial:.4g} N m): lowest peak acceleration"
    else:
        name = "modified-sine"
        why = f"medium speed and load (inertia {inertial:.4g} N m, load {wanted.torque:.4g} N m): low Vm and (AV)m"
    claims = LAWS[name].claims
    return name, Choice("motion law", name, f"{why}; Vm {claims.vm:.4g}, Am {claims.am:.4g}")


def _arrangement(wanted: Wanted) -> tuple[int, str, Choice]:
    """Rollers on the turret and the cam's form."""
    starts = 1 if wanted.stops >= 5 else ceil(6 / wanted.stops)
    rollers = wanted.stops * starts
    form = "rib" if rollers <= 16 else "groove"
    why = ("few stops: several starts keep rollers close enough to hand over" if starts > 1
           else "one roller a stop and one groove")
    why += "; few rollers ride a rib, which is easy to make" if form == "rib" else "; many rollers jam less in a groove"
    return rollers, form, Choice("rollers and form", f"{rollers} rollers, {starts} start(s), {form}", why)


def _ratio(wanted: Wanted, law: str) -> tuple[float, Choice]:
    """Ratio rf / C under the pressure-angle limit (equation 9); DesignError where the angle cannot be reached."""
    slope = 360.0 / wanted.stops / wanted.motion_angle * LAWS[law].claims.vm
    aim = radians(AIM * wanted.pressure_angle)
    ratio = 1.0 / (1.0 + slope / tan(aim))
    if ratio < LEAST_RATIO:
        reached = degrees(atan(slope * LEAST_RATIO / (1.0 - LEAST_RATIO)))
        least = 360.0 / wanted.stops * LAWS[law].claims.vm * LEAST_RATIO / (1.0 - LEAST_RATIO) / tan(aim)
        allowed = f"a motion angle of at least {least:.4g} deg" if least <= 330.0 else "more stops"
        raise DesignError(
            f"the pressure angle is out of reach: with rf/C = {LEAST_RATIO:g} it is {reached:.4g} deg and "
            f"{degrees(aim):g} deg is the aim; allowed: {allowed}"
        )
    chosen = min(ratio, MOST_RATIO)
    why = f"pressure angle {degrees(aim):g} deg on the pitch radius at Vm {LAWS[law].claims.vm:.4g} (equation 9)"
    if chosen < ratio:
        why = f"equation 9 allows {ratio:.3g}; {MOST_RATIO:g} leaves the cam its body"
    return chosen, Choice("ratio rf/C", f"{chosen:.3f}", why)


def _candidates(wanted: Wanted, law: str, rollers: int, form: str, ratio: float) -> Iterator[Candidate]:
    """Trials from the recommended one on: rollers downwards in the series, each with widths upwards."""
    pitch_angle = 2.0 * pi / rollers
    for share in (1.0, 0.93, 0.86):
        centre = wanted.center_distance or _centre_within(float(wanted.envelope or 0.0), ratio * share)
        pitch = floor(ratio * share * centre)
        # Equation 6: rf is about r0 / sin(a quarter of the roller pitch), so r0 at most a little above that.
        most = 2.0 * pitch * sin(0.25 * pitch_angle) * 1.08
        for size in [one for one in reversed(ROLLERS) if one.diameter <= most][:4]:
            length = min(size.width, floor(0.3 * pitch))
            base = 2.0 * pitch * sin(0.5 * pitch_angle) * (1.0 if form == "rib" else 1.4) + 0.5 * size.diameter
            bore = _bore(centre, pitch, length, size.diameter)
            if bore is None:
                continue
            for grow in (1.0, 1.06, 1.12, 1.2, 1.3, 1.4):
                trial = Candidate(centre, pitch, size, length, ceil(base * grow), rollers, form, law, bore)
                if trial.width < 1.9 * trial.globoid:
                    yield trial


def _centre_within(envelope: float, ratio: float) -> float:
    """Centre distance at which cam and turret together just fit the envelope, mm."""
    # From the cam's far side to the turret's: end radius + C + turret's outer radius, all near shares of C.
    return float(floor(envelope / (1.0 + (1.0 - 0.75 * ratio) + 1.15 * ratio)))


def _bore(centre: float, pitch: float, length: float, diameter: float) -> float | None:
    """The largest usual shaft that leaves half its own diameter of wall under the groove floor."""
    floor_radius = centre - hypot(pitch + 0.5 * length, 0.5 * diameter, 0.5 * diameter) - 0.8
    fit = [bore for bore in BORES if bore <= floor_radius]
    return float(fit[-1]) if fit else None


def _finish(wanted: Wanted, trial: Candidate, model: Model, first: tuple[Choice, ...]) -> Design:
    """Material by stress and speed, all checks with the solid, and the reasons."""
    duty = model.turret_duty
    assert duty is not None
    pressure, speed = duty.least_peak.value, _track_speed(wanted, trial)
    material = material_for(pressure, speed)
    if material is None:
        raise DesignError(f"the contact pressure {pressure:.4g} MPa is above 1300 MPa; use a larger centre distance")
    text = profile_text(wanted, trial, (material.name, material.pressure, material.hardness))
    found = findings(Model(parse(text), TRIAL_TOLERANCE))
    if any(f.check == "turret-life" and not f.passed for f in found):
        # The class limit as a fatigue limit can be too cautious for the life: the next harder track then.
        harder = material_for(min(1.5 * material.pressure, 1300.0), speed) or material
        text = profile_text(wanted, trial, (harder.name, harder.pressure, harder.hardness))
        material, found = harder, findings(Model(parse(text), TRIAL_TOLERANCE))
    failed = [f for f in found if not f.passed]
    if failed:
        reasons = "; ".join(f"{f.check} {f.where}: {f.advice}" for f in failed)
        raise DesignError(f"the design fails: {reasons}")
    rib = min(f.value or 0.0 for f in found if f.check == "rib-thickness")
    quarter = 0.25 * 2.0 * pi / trial.rollers
    choices = (
        *first,
        Choice("centre distance", f"{trial.centre:g} mm", "given" if wanted.center_distance else
               f"largest that fits the envelope of {wanted.envelope:g} mm"),
        Choice("pitch radius", f"{trial.pitch:g} mm", f"rf/C times the centre distance: rf/C = "
               f"{trial.pitch / trial.centre:.3f}"),
        Choice("roller", f"{trial.roller.diameter:g} x {trial.length:g} mm", "preferred series, by equation 6: "
               f"r0 / sin(quarter pitch) = {0.5 * trial.roller.diameter / sin(quarter):.4g} mm"),
        Choice("globoid radius", f"{trial.globoid:g} mm", f"roller's inner end and {SEAT:g} mm (equation 10)"),
        Choice("width", f"{trial.width:g} mm",
               f"a roller is engaged at every angle, both ways; thinnest rib {rib:.4g} mm"),
        Choice("bore", f"{trial.bore:g} mm", f"largest usual shaft under the groove floor; stress "
               f"{duty.contact_data().get('shaft_stress_mpa', 0.0):.3g} MPa"),
        Choice("material", f"{material.name}, HRC {material.hardness:g}", f"contact pressure {pressure:.4g} MPa, class "
               f"{material.load_class}; track speed {speed:.3g} m/s, class {speed_class(speed)}"),
    )
    return Design(text, choices, found)


def _track_speed(wanted: Wanted, trial: Candidate) -> float:
    """Largest speed of the track under the roller, m/s: turning and crosswise together at the pitch radius."""
    omega = wanted.speed * pi / 30.0
    ratio = 360.0 / wanted.stops / wanted.motion_angle * LAWS[trial.law].claims.vm
    return 1e-3 * omega * sqrt((trial.centre - trial.pitch) ** 2 + (ratio * trial.pitch) ** 2)
