"""Planar cams: folds under a flat face, crossings, faces too small, widths, jumps of curvature, contact kept."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees, pi
from typing import TYPE_CHECKING

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model

WIDTH_SLACK = 1e-9
"""mm; rounding of a width that is constant by construction"""
PAIR_SLACK = 1e-9
"""mm; rounding of a pair without play"""
FORCE_SLACK = 1e-9
"""share of the peak force that rounding leaves where contact just holds"""


@check("face-curvature", "planar")
def face_curvature(model: Model) -> Iterable[Finding]:
    """Smallest radius of curvature of a profile for flat faces; it folds where that is not positive."""
    worst = model.planar.face_radius if model.planar else None
    if worst is None or model.planar is None:
        return
    advice = "" if worst.value > 0.0 else f"the profile folds under the flat face: {model.planar.fold_advice}"
    angle = degrees(worst.cam_angle) % 360.0
    yield Finding("face-curvature", worst.value, 0.0, "mm", worst.value > 0.0, angle, advice, worst.where)


@check("self-crossing", "planar")
def self_crossing(model: Model) -> Iterable[Finding]:
    """Number of profiles that cross themselves; none may."""
    assert model.planar is not None
    for name, found in model.planar.crossings.items():
        if found is None:
            yield Finding("self-crossing", 0.0, 0.0, "crossings", True, None, "", name)
            continue
        where = f"{name}, at x = {found.point[0]:.6g}, y = {found.point[1]:.6g} mm"
        advice = f"the profile of {degrees(found.first):.6g} deg crosses that of {degrees(found.second):.6g} deg: "
        advice += "enlarge base_radius, take a smaller roller or a gentler motion"
        yield Finding("self-crossing", 1.0, 0.0, "crossings", False, degrees(found.first) % 360.0, advice, where)


@check("face-width", "planar")
def face_width(model: Model) -> Iterable[Finding]:
    """Width of a flat face against what the wandering contact needs."""
    given = model.setup.follower.face_width
    needed = model.planar.face_needed if model.planar else None
    if given is None or needed is None:
        return
    passed = given >= needed.value
    advice = "" if passed else f"the contact leaves the face: make face_width at least {needed.value:.6g} mm"
    angle = degrees(needed.cam_angle) % 360.0
    yield Finding("face-width", given, needed.value, "mm", passed, angle, advice, needed.where)


@check("width", "planar")
def width(model: Model) -> Iterable[Finding]:
    """Largest deviation from the constant width all round."""
    found = model.planar.width_residual if model.planar else None
    if found is None:
        return
    passed = abs(found.value) <= WIDTH_SLACK
    advice = "" if passed else "opposite motions do not mirror each other: s(theta + 180) = h - s(theta) must hold"
    yield Finding("width", abs(found.value), WIDTH_SLACK, "mm", passed, degrees(found.cam_angle) % 360.0, advice)


@check("pair", "planar")
def pair(model: Model) -> Iterable[Finding]:
    """Least gap at the return roller of a pair while the main one rests; negative where the pair jams."""
    found = model.pair
    if found is None:
        return
    angle = degrees(float(found.phi[int(found.gap.argmin())]))
    passed = found.least >= -PAIR_SLACK
    advice = "" if passed else "the return roller cuts into its disc: enlarge the clearance"
    yield Finding("pair", found.least, 0.0, "mm", passed, angle, advice, "return roller")


@check("curvature-jumps", "planar")
def curvature_jumps(model: Model) -> Iterable[Finding]:
    """Cam angles at which the profile's curvature jumps: named, and judged by `continuity`."""
    assert model.planar is not None
    jumps = model.planar.curvature_jumps
    places = [f"{degrees(j.cam_angle):.6g} deg ({j.before:.4g} to {j.after:.4g} 1/mm)" for j in jumps[:8]]
    first = degrees(jumps[0].cam_angle) if jumps else None
    yield Finding("curvature-jumps", float(len(jumps)), None, "jumps", True, first, "", ", ".join(places))


@check("contact-kept", "planar")
def contact_kept(model: Model) -> Iterable[Finding]:
    """Least force between a force-closed cam and its follower; below zero the follower leaves the cam."""
    drive = model.drive
    least = drive.least_force if drive is not None else None
    if drive is None or least is None:
        return
    passed = least.value >= -FORCE_SLACK * float(drive.contact_forces.max())
    advice = where = ""
    if not passed:
        ranges = [f"{degrees(lost.begin):.6g} to {degrees(lost.end):.6g}" for lost in drive.lost]
        where = ", ".join(f"no contact from {angles} deg" for angles in ranges)
        rpm = drive.leaving_speed * 30.0 / pi
        unit = "N mm" if model.profile.rotating else "N"
        advice = f"contact is lost above {rpm:.6g} r/min: raise spring_preload to {drive.preload_needed:.6g} {unit}"
        advice += " or more, lower the mass or the speed, or use a form-closed cam"
    yield Finding("contact-kept", least.value, 0.0, "N", passed, degrees(least.cam_angle) % 360.0, advice, where)
