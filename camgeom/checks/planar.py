"""Planar cams: folds under a flat face, crossings, faces too small, widths, jumps of curvature."""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

from camgeom.checks import check
from camgeom.checks.verdict import NO_GAP, Finding, NotJudged, judged

if TYPE_CHECKING:
    from camgeom.model import Model

WIDTH_SLACK = 1e-9
"""mm; rounding of a width that is constant by construction"""
PAIR_SLACK = 1e-9
"""mm; rounding of a pair without play"""


@check("face-curvature", "planar")
def face_curvature(model: Model) -> Iterable[Finding]:
    """Smallest radius of curvature of a profile for flat faces; it folds where that is not positive."""
    worst = model.planar.face_radius if model.planar else None
    if worst is None or model.planar is None:
        return
    advice = f"the profile folds under the flat face: {model.planar.fold_advice}"
    yield judged(
        "face-curvature", worst.value, ">", 0.0, "mm", advice, cam_angle=worst.cam_angle, where=worst.where
    )


@check("self-crossing", "profiles")
def self_crossing(model: Model) -> Iterable[Finding]:
    """Number of profiles that cross themselves; none may."""
    assert model.profiles is not None
    for name, place in model.profiles.crossings.items():
        if place is None:
            yield judged("self-crossing", 0.0, "<=", 0.0, "crossings", "", where=name)
            continue
        yield judged(
            "self-crossing", 1.0, "<=", 0.0, "crossings",
            f"the profile of {degrees(place.first):.6g} deg crosses that of {degrees(place.second):.6g} deg: "
            "enlarge base_radius, take a smaller roller or a gentler motion",
            cam_angle=place.first, where=f"{name}, at x = {place.point[0]:.6g}, y = {place.point[1]:.6g} mm",
        )  # fmt: skip


@check("face-width", "planar")
def face_width(model: Model) -> Iterable[Finding | NotJudged]:
    """Width of a flat face, from the pivot on its length, against what the wandering contact needs."""
    follower, needed = model.setup.follower, model.planar.face_needed if model.planar else None
    if needed is None:
        return
    width = follower.face_end if follower.face_width is None else follower.face_width
    if width is None:
        yield NotJudged("face-width", f"no follower.face_width: the contact needs {needed.value:.6g} mm")
        return
    advice = f"the contact leaves the face: make face_width at least {needed.value:.6g} mm"
    yield judged(
        "face-width", width, ">=", needed.value, "mm", advice, cam_angle=needed.cam_angle, where=needed.where
    )


@check("window", "planar")
def window(model: Model) -> Iterable[Finding]:
    """From the circle that the cam sweeps to the sides of its frame's window, mm; the frame moves along them."""
    plate = model.mechanism.frame
    if plate is None:
        return
    assert model.planar is not None
    swept, limit = model.planar.largest_radius, model.profile.limits.clearance_mm
    needed = 2.0 * (swept.value + limit)
    yield judged(
        "window", 0.5 * plate.window - swept.value, ">", limit, "mm",
        f"the cam runs into the side of the window: make follower.window_width more than {needed:.6g} mm",
        slack=-NO_GAP, cam_angle=swept.cam_angle, where="side of the frame's window",
    )  # fmt: skip


@check("width", "planar")
def constant_width(model: Model) -> Iterable[Finding]:
    """Largest deviation from the constant width all round."""
    residual = model.planar.width_residual if model.planar else None
    if residual is not None:
        advice = "opposite motions do not mirror each other: s(theta + 180) = h - s(theta) must hold"
        yield judged("width", abs(residual.value), "<=", WIDTH_SLACK, "mm", advice, cam_angle=residual.cam_angle)


@check("pair", "profiles")
def pair(model: Model) -> Iterable[Finding]:
    """Least gap at the return roller of a pair while the main one rests; negative where the pair jams."""
    residual = model.pair
    if residual is not None:
        advice = "the return roller cuts into its disc: enlarge the clearance"
        yield judged(
            "pair", residual.least, ">=", 0.0, "mm", advice,
            slack=PAIR_SLACK, cam_angle=float(residual.phi[int(residual.gap.argmin())]), where="return roller",
        )  # fmt: skip


@check("curvature-jumps", "profiles")
def curvature_jumps(model: Model) -> Iterable[Finding]:
    """Cam angles at which the profile's curvature jumps: named, and judged by `continuity`."""
    assert model.profiles is not None
    jumps = model.profiles.curvature_jumps
    places = [f"{degrees(j.cam_angle):.6g} deg ({j.before:.4g} to {j.after:.4g} 1/mm)" for j in jumps[:8]]
    yield judged(
        "curvature-jumps", float(len(jumps)), "", None, "jumps", "",
        cam_angle=jumps[0].cam_angle if jumps else None, where=", ".join(places),
    )  # fmt: skip
