"""The head of the page: verdict, findings, key figures, title block; and the table of all checks."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import suppress
from dataclasses import replace
from math import degrees, pi
from typing import TYPE_CHECKING

from camgeom.checks.verdict import RANK, Verdict, life_shown
from camgeom.drawing.content import Block, Chapter, Column, Figure, Level, Page, Remark, Table
from camgeom.drawing.sheet import number
from camgeom.report.sections.bodies import kept
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.checks.verdict import Finding
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.kept import Kept
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model

UNITS = {"deg": "°", "1": "", "order": ""}
"""units as a reader expects them"""
SIGNS = {"<=": "≤", ">=": "≥"}
PICOMETRE = 1e-9
"""mm; a distance smaller than this is rounding"""


def _verdict(model: Model) -> Verdict:
    """The verdict of all checks, judged once for a model."""
    from camgeom.checks import judge

    return kept(model, "checks", lambda: judge(model))


def _shown(finding: Finding) -> Remark:
    value: float | str | None = finding.shown if finding.value is not None or finding.passed else None
    unit = "" if value == "unlimited" else UNITS.get(finding.unit, finding.unit)
    limit = None
    if finding.limit is not None:
        sign = SIGNS.get(finding.comparison, finding.comparison)
        limit = f"{sign} {number(finding.limit)}{'' if unit == '°' or not unit else ' '}{unit}".strip()
    angle = "" if finding.cam_angle_deg is None else f"cam angle {number(finding.cam_angle_deg)}°"
    where = ", ".join(part for part in (angle, finding.place) if part)
    level = Level(finding.level)
    return Remark(_words(finding.check), level, value, limit, unit, where, _sentence(finding.advice))


def _words(name: str) -> str:
    text = name.replace("-", " ")
    return text[:1].upper() + text[1:]


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:] + ("" if text.endswith(".") else ".") if text else ""


def check_table(model: Model) -> tuple[Block, ...]:
    """Every check with its value, limit and margin, the failed ones first."""
    ordered = sorted(_verdict(model).findings, key=lambda finding: -RANK[finding.level])
    rows = []
    for finding in ordered:
        f = _shown(finding)
        limit = f.limit and f.limit.removesuffix(f.unit).strip()
        rows.append((f.check, f.level, f.value, f.unit, limit, finding.room or None, f.where))
    columns = tuple(Column(label) for label in ("Check", "Verdict", "Value", "Unit", "Limit", "Margin", "Where"))
    return (Table("Checks made", columns, tuple(rows)),) if rows else ()


def head(model: Model, judged: bool, figures: tuple[Figure, ...], sections: tuple[Chapter, ...]) -> Page:
    """The page with its title block and, where the checks were asked for, its verdict."""
    return headed(model, _verdict(model) if judged else None, figures, sections)


def headed(
    model: Model, verdict: Verdict | None, figures: tuple[Figure, ...], sections: tuple[Chapter, ...] = ()
) -> Page:
    """The page with its title block and a verdict."""
    profile = model.profile
    operation = profile.operation
    details = [("Profile", profile.source.rsplit("/", 1)[-1] or "given in memory"), ("camgeom", __version__)]
    if operation is not None:
        states = f", fastest of {len(profile.duty)} operating states" if profile.duty else ""
        details.append(("Cam speed", f"{number(profile.fastest or 0.0)} r/min{states}"))
    fine, free = model.tolerance, model.free_tolerance
    coarse = f", {number(free)} mm where nothing touches" if free > fine else ""
    details.append(("Mesh tolerance", f"{number(fine)} mm{coarse}"))
    form = model.mechanism.form
    kind = f"{profile.kind.replace('-', ' ')} cam{f', {form}' if form else ''}, {profile.follower.kind} follower"
    if verdict is None or not verdict.findings:
        return Page(profile.name, kind, None, "", (), figures, sections, tuple(details))
    omitted = tuple((_words(word.check), word.reason) for word in verdict.not_judged)
    return Page(
        profile.name, kind, Level(verdict.level), _summary(verdict), tuple(map(_shown, verdict.findings)),
        figures, sections, tuple(details), omitted,
    )  # fmt: skip


def _summary(verdict: Verdict) -> str:
    """Below the verdict: what fails, or what is closest to its limit; and whose loads were judged."""
    loads = "" if verdict.loads is None else _sentence(verdict.loads.sentence)
    return " ".join(filter(None, (_hardest(verdict), loads)))


def _hardest(verdict: Verdict) -> str:
    failed = sorted({_words(f.check).lower() for f in verdict.findings if f.level == "fail"})
    if failed:
        return f"The design fails: {', '.join(failed)}. What to change stands below each finding."
    closest = verdict.closest
    if closest is None:
        return ""
    room = f"{_words(closest.check).lower()}, {round(closest.margin or 0.0)} % of the limit away from it"
    return f"The design meets its limits; the closest to its limit is the {room}."


def key_figures(model: Model, wanted: Collection[str]) -> tuple[Figure, ...]:
    """The figures a reader looks for first, of the sections asked for and computable; of several followers each's."""
    figures: list[Figure] = []
    for one in model.bindings[model.number :] if model.number == 0 else (model,):
        own = len(model.grooves) > 1 and one in model.grooves
        several = len(model.bindings) > 1
        for key, source, theirs in (("motion", _motion, own), ("flank", _flank, own), ("contact", _contact, several),
                                    ("fatigue", _life, several)):  # fmt: skip
            if key in wanted and (one is model or theirs):
                whose = f", follower {one.number + 1}" if theirs else ""
                figures += (replace(figure, label=figure.label + whose) for figure in _computable(source, one))
    return (*figures, *(_computable(_solid, model) if "solid" in wanted else ()))


def _computable(source: Callable[[Model], Iterator[Figure]], model: Model) -> list[Figure]:
    """Figures of a model, up to the first that cannot be computed: the section says why, the head shows what there is.
    """
    from camgeom.errors import CamgeomError

    figures: list[Figure] = []
    with suppress(CamgeomError, MemoryError):
        for figure in source(model):
            figures.append(figure)
    return figures


def _motion(model: Model) -> Iterator[Figure]:
    program = model.setup.program
    rotating = model.profile.rotating
    unit, factor = ("°", 180.0 / pi) if rotating else ("mm", 1.0)
    lifts = [lift for span in program.spans for lift in (span.before, span.after)]
    name = "Index" if program.advance else "Stroke"
    yield Figure(name, factor * (max(lifts) - min(lifts)), unit)
    if model.profile.fastest is not None:
        omega = model.profile.fastest * pi / 30.0
        peak = program.peak(2)
        value = abs(peak.value) * omega**2 * (1.0 if rotating else 1e-3)
        yield Figure("Peak acceleration", value, "rad/s²" if rotating else "m/s²", f"at {degrees(peak.at):.1f}°")


def _flank(model: Model) -> Iterator[Figure]:
    if model.profiles is not None:
        yield from _profile(model)
    if not model.flanks:
        return
    if model.profiles is None and (worst := model.pressure_angle):
        limit = model.profile.limits.pressure_angle_deg
        note = _at(worst.cam_angle) + (f", limit {number(limit)}°" if limit else "")
        yield Figure("Largest pressure angle", degrees(worst.value), "°", note)
    margin = min((s.margin for s in model.flanks), key=lambda e: e.value)
    if margin.value <= 0.0:  # a folded flank has no curvature to quote
        yield Figure("Undercut margin", margin.value, "", f"folds at {degrees(margin.cam_angle) % 360.0:.1f}°")
        return
    sharp = max((s.largest_relative_curvature for s in model.flanks), key=lambda e: e.value)
    if sharp.value > 0.0:
        note = f"sharpest contact, at {degrees(sharp.cam_angle) % 360.0:.1f}°"
        yield Figure("Smallest relative radius", 1.0 / sharp.value, "mm", note)


def _profile(model: Model) -> Iterator[Figure]:
    """The profile of a planar cam, by what touches it."""
    if model.profiles is None:
        return
    top, limit = model.profiles.pressure_angle, model.profile.limits.pressure_angle_deg
    if degrees(top.value) > PICOMETRE:
        note = _at(top.cam_angle) + (f", limit {number(limit)}°" if limit else "")
        yield Figure("Largest pressure angle", degrees(top.value), "°", note)
    convex, hollow = model.profiles.radii
    sharp = min((one for one in (convex, hollow) if one), key=lambda one: one.value, default=None)
    if sharp is not None:
        word = "convex" if sharp is convex else "hollow"
        yield Figure("Smallest profile radius", sharp.value, "mm", f"{word}, {_at(sharp.cam_angle)}")


def _at(angle: float) -> str:
    return f"at {degrees(angle) % 360.0:.1f}°"


def _shared(duty: TurretDuty) -> Iterator[Figure]:
    """A turret whose rollers share the load."""
    data = duty.contact_data()
    if duty.no_stress:
        note = f"{_at(duty.least_peak.cam_angle)}, at most half a millimetre inside the sharp end: no largest pressure"
        yield Figure("Contact pressure", duty.least_peak.value, "MPa", note)
    else:
        at = f"at {data['peak_slice_cam_angle_deg'] % 360.0:.1f}°, worst slice"
        yield Figure("Peak contact pressure", data["peak_slice_pressure_mpa"], "MPa", at)
    least, most = data["rollers_sharing_least"], data["rollers_sharing_most"]
    sharing = f"{least} to {most} rollers share" if most > least else f"{most} rollers share"
    yield Figure("Peak force on a roller", data["peak_force_n"], "N", sharing)
    torque = f"at {data['peak_torque_at_deg'] % 360.0:.1f}°"
    yield Figure("Peak camshaft torque", data["peak_torque_n_m"], "N m", torque)


def _least(holds: Kept | None) -> Iterator[Figure]:
    if holds is not None:
        note = f"{_at(holds.least.cam_angle)}, must stay above 0"
        yield Figure("Least contact force", holds.least.value, "N", note)


def _touched(model: Model, drive: FaceDuty) -> Iterator[Figure]:
    """A planar cam by all that touches it."""
    peak = drive.peak_pressure
    if peak is not None and not model.duties:
        yield Figure("Peak contact pressure", peak.value, "MPa", _at(peak.cam_angle))
    yield Figure("Peak contact force", drive.peak_force.value, "N", _at(drive.peak_force.cam_angle))
    yield from _least(drive.kept)
    yield Figure("Peak drive torque", drive.peak_torque.value * 1e-3, "N m", _at(drive.peak_torque.cam_angle))


def _contact(cam: Model) -> Iterator[Figure]:
    model = cam.hardest_state
    if model.turret_duty is not None:
        yield from _shared(model.turret_duty)
    if not model.duties:
        yield from _touched(model, model.drive) if model.drive is not None else ()
        return
    duty = model.duty
    worst, peak = duty.peak_pressure, duty.contact.peak()
    shown = duty.least_peak
    name = "Peak contact pressure" if worst is not None else "Pressure 0.5 mm inside the sharp end"
    place = f"{number(shown.place)} mm along the roller"
    yield Figure(name, shown.value, "MPa", f"at {degrees(shown.cam_angle):.1f}°, {place}")
    if duty.finite is None:
        note = f"at {degrees(float(peak.theta)):.1f}°, {_quoted(model)}"
        yield Figure("Contact pressure, quoted place", float(peak.pressure), "MPa", note)
    if model.drive is not None:
        yield from _touched(model, model.drive)
        return
    assert model.shaft is not None
    assert model.peak_force is not None
    force, torque = model.peak_force, model.shaft.peak_torque
    yield Figure("Peak contact force", force.value, "N", f"at {degrees(force.cam_angle):.1f}°")
    yield from _least(duty.kept)
    if (drive := model.slide_drive) is not None:
        note = "for the follower" if drive.mass is None else "for follower, plate and slide"
        yield Figure("Peak drive force", drive.peak.value, "N", f"{_at(drive.peak.cam_angle)}, {note}")
        return
    yield Figure("Peak drive torque", torque.value * 1e-3, "N m", f"at {degrees(torque.cam_angle):.1f}°")


def _quoted(model: Model) -> str:
    quoted = model.mechanism.quoted_radius
    return f"quoted at {number(quoted, 6)} mm" if quoted is not None else "middle of the roller"


def _life(model: Model) -> Iterator[Figure]:
    lives = model.lives
    for body in ("roller", "face", "cam"):
        if body in lives:
            value = life_shown(lives[body])
            unit = "" if isinstance(value, str) else "h"
            yield Figure(f"{body.capitalize()} life", value, unit, "contact fatigue, hardest place")


def _solid(model: Model) -> Iterator[Figure]:
    diameter, length = model.envelope
    if model.mechanism.box is not None:
        length, width, thick = model.mechanism.box
        yield Figure("Plate", length, "mm", f"{number(width)} mm wide, {number(thick)} mm thick")
    else:
        yield Figure("Largest diameter", diameter, "mm", f"{number(length)} mm along the axis")
    mass = sum(one.mass for one in model.mass)
    yield Figure("Cam mass", mass, "kg", f"{number(sum(one.volume for one in model.mass) / 1e3)} cm³")
    if model.frame_mass is not None and (plate := model.mechanism.frame) is not None:
        yield Figure("Frame mass", model.frame_mass, "kg", f"{number(plate.volume / 1e3)} cm³, its plate alone")
