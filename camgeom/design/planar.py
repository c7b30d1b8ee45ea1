"""The smallest cam for given limits, of planar and of end-face cams; best offset and balance of a disc.

Smallest radii with a closed form are exact maxima over the motion; the others are roots of the worst margin over the
turn, whose extremes are refined, so that they are good to rounding as well.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import atan2, ceil, degrees, hypot, inf, pi, radians, sqrt, tan
from typing import final

import numpy as np

from camgeom.cams.conjugate import Conjugate
from camgeom.cams.disc import Disc
from camgeom.cams.end_face import EndFace
from camgeom.checks import findings, judge, light_checks
from camgeom.design import Choice, Design
from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_maximum, bracketed_root, piece_grid, refined_maximum
from camgeom.model import Model
from camgeom.motion.program import Program
from camgeom.profile import Profile, from_data, parse
from camgeom.profile.sections import INCH
from camgeom.profile.text import replaced
from camgeom.solid.prism import Prism
from camgeom.track.outline import (
    CircleOutline,
    Outline,
    OutlineIntegrals,
    PolygonOutline,
    RollerOutline,
)

PER_TURN = 720
SCANNED, EVENLY = 33, 97
RINGS, LARGEST = 25, 1000.0
"""middle radii of a ring that are tried first, and the largest of them, mm"""
UNBUILDABLE = -1e6
"""below every share by which a limit can fail"""


def _greatest(program: Program, f: Callable[[Floats], Floats]) -> float:
    phi, owner = piece_grid(program.knots, PER_TURN)
    return refined_maximum(f, phi, owner, f(phi))[0]


def smallest_prime_radius(
    program: Program, pressure_angle: float, offset: float = 0.0, sense: float = 1.0, back: float | None = None
) -> float:
    """Smallest prime radius, mm, of a translating roller follower whose pressure angle stays within a limit.

    pressure_angle  rad, where the cam drives (rise); `back` the limit in the return, default the same
    offset          mm, towards +Y; sense +1 where the cam turns counter-clockwise
    tan(alpha) = (s' + sense offset) / (s0 + s) with s0² = prime² - offset², so s0 is the largest of
    |s' + sense offset| / tan(limit) - s over the turn.
    """
    up, down = tan(pressure_angle), tan(pressure_angle if back is None else back)

    def needed(phi: Floats) -> Floats:
        s, ds = program.jet(phi, 1)
        return np.asarray(np.abs(ds + sense * offset) / np.where(ds < 0.0, down, up) - s)

    return hypot(max(0.0, _greatest(program, needed)), offset)


@final
@immutable(eq=True)
class PlanarLimits:
    """Limits that a cam must keep; None: not asked for.

    pressure_angle_deg    largest pressure angle
    convex_radius_mm      smallest convex radius of curvature of the profile; 0 asks for no undercut only
    contact_pressure_mpa  largest peak contact pressure (needs an [operation])
    """

    pressure_angle_deg: float | None = None
    convex_radius_mm: float | None = 0.0
    contact_pressure_mpa: float | None = None


def smallest_base_radius(profile: Profile, wanted: PlanarLimits, low: float = 1.0, high: float = 1000.0) -> float:
    """Smallest base radius, mm, from which on a planar cam keeps the limits, up to `high` or as far as it can be built.

    Any follower: radii are scanned, geometrically and, where an arm forms a triangle with its centre distance, evenly
    over what that allows; the root of the worst margin between the last bad and the first good one of the uppermost
    good stretch is found to rounding. Returns `low` where all are good. Raises DesignError where none is good, with the
    radius that comes nearest and the limit that fails there.
    """
    radii = np.geomspace(low, high, SCANNED)
    if profile.follower.rotating:
        cam = profile.cam
        centre = (cam.center_distance if isinstance(cam, Disc | Conjugate) else None) or high
        radii = distinct(np.concatenate([radii, np.linspace(low, min(high, 2.0 * centre), EVENLY)]))
    return smallest_radius(lambda radius: margins(profile, radius, wanted), radii)


def smallest_ring(profile: Profile, cam: EndFace, wanted: PlanarLimits) -> float:
    """Smallest middle radius, mm, of an end-face cam's ring that keeps the limits, as `smallest_base_radius`."""
    if cam.pitch_radius is not None:
        raise ProfileError([Problem("cam.pitch_radius", "is given, and the ring is sought", cam.pitch_radius, "",
                                    "leave it out: the middle of the contact")], profile.source)  # fmt: skip
    radii = np.geomspace(0.25 * (cam.diameter - cam.inner_diameter) + 1.0, LARGEST, RINGS)
    return smallest_radius(lambda middle: ring_margins(profile, middle, wanted), radii, "middle radius of the ring")


def smallest_radius(margins_of: Callable[[float], dict[str, float]], radii: Floats, name: str = "base radius") -> float:
    """Smallest of the radii, mm, (n,) rising, or between two of them, from which on every margin is kept; as above."""
    low, high = float(radii[0]), float(radii[-1])

    def margin(radius: float) -> float:
        return min(margins_of(float(radius)).values())

    found = np.array([margin(radius) for radius in radii])
    best = int(np.argmax(found))
    if UNBUILDABLE < found[best] < 0.0:
        # A stretch between two samples may be good.
        ends = radii[max(best - 1, 0)], radii[min(best + 1, len(radii) - 1)]
        value, peak = bracketed_maximum(
            lambda r: np.array([margin(x) for x in r.ravel()]).reshape(r.shape), *(np.array([end]) for end in ends)
        )
        radii, found = np.insert(radii, best, peak[0]), np.insert(found, best, value[0])
        order = np.argsort(radii)
        radii, found = radii[order], found[order]
        best = int(np.argmax(found))
    if found[best] < 0.0:
        worst = min(margins_of(float(radii[best])).items(), key=lambda item: item[1])
        if found[best] == UNBUILDABLE:
            raise DesignError(f"no {name} from {low:g} to {high:g} mm can be built; change the other keys first")
        raise DesignError(
            f"no {name} up to {high:g} mm keeps the limits: {worst[0]} fails by a share of {-worst[1]:.3g} at "
            f"{radii[best]:.4g} mm, which comes nearest; give the motion more cam angle, or change arm, centre "
            "distance or roller with the radius"
        )
    good = int(np.flatnonzero(found >= 0.0)[-1])
    bad = np.flatnonzero(found[:good] < 0.0)
    if not bad.size:
        return low
    below, above = radii[bad[-1]], radii[bad[-1] + 1]
    root = bracketed_root(lambda r: np.array([margin(x) for x in r]), np.array([below]), np.array([above]))
    return float(root[0])


def margins(profile: Profile, radius: float, wanted: PlanarLimits) -> dict[str, float]:
    """How far each limit is kept, as a share of it; negative where it is not.

    Of a disc with several tracks that of every track: those that state no base radius have this one too.
    """
    data = replaced(profile.stated, ("cam", "base_radius"), radius / unit_of(profile), "cam.base_radius")
    try:
        model = Model(from_data(data, profile.source))
    except ProfileError:
        return {"what can be built": UNBUILDABLE}
    least = profile.limits.min_wall_mm
    found = {f"wall, {wall.name},": (wall.thickness - least) / radius for wall in model.walls}
    for one in model.grooves:
        planar, of = one.profiles, f" of track {one.groove + 1}" if len(model.grooves) > 1 else ""
        if planar is None:
            raise DesignError("only planar cams have a base radius to solve for")
        if wanted.pressure_angle_deg is not None:
            angle = degrees(planar.pressure_angle.value)
            found[f"pressure angle{of}"] = 1.0 - angle / wanted.pressure_angle_deg
        if wanted.convex_radius_mm is not None:
            if planar.face_radius is not None:
                found[f"convex radius{of}"] = (planar.face_radius.value - wanted.convex_radius_mm) / radius
            for track, tool, roller in zip(one.tracks, one.mechanism.cutters, one.mechanism.rollers):
                # The profile is sharpest where its tool is thickest: at an end of a cone, in the middle of a crown.
                ends = tool.radii(np.array(tool.contact)).tolist()
                reach = wanted.convex_radius_mm + max(0.5 * roller.diameter, *ends)
                found[f"convex radius, {track.name}{of}"] = 1.0 - reach * _sharpest(RollerOutline(track, 0.0))
    if wanted.contact_pressure_mpa is not None and all(m > 0.0 for k, m in found.items() if k.startswith("convex")):
        found["contact pressure"] = 1.0 - largest_pressure(model) / wanted.contact_pressure_mpa
    return found


def ring_margins(profile: Profile, radius: float, wanted: PlanarLimits) -> dict[str, float]:
    """The same of an end-face cam by its middle radius, mm."""
    cam = _ring(profile, radius)
    model = Model(profile.model_copy(update={"cam": cam}))
    if cam.problems(model.setup):
        return {"what can be built": UNBUILDABLE}
    try:
        found = {"undercut": min(survey.margin.value for survey in model.flanks) - profile.limits.undercut_margin}
        least = profile.limits.min_wall_mm
        found |= {f"wall, {wall.name},": (wall.thickness - least) / radius for wall in model.walls}
        if wanted.pressure_angle_deg is not None and model.pressure_angle is not None:
            found["pressure angle"] = 1.0 - degrees(model.pressure_angle.value) / wanted.pressure_angle_deg
        if wanted.contact_pressure_mpa is not None and found["undercut"] > 0.0:
            found["contact pressure"] = 1.0 - largest_pressure(model) / wanted.contact_pressure_mpa
    except DesignError:
        # The roller dives into a ring so small, or presses it out of all theory.
        return {"what can be built": UNBUILDABLE}
    return found


def _ring(profile: Profile, radius: float) -> EndFace:
    """The cam with a ring of a middle radius, mm, as wide as before."""
    cam = profile.cam
    assert isinstance(cam, EndFace)
    width = 0.5 * (cam.diameter - cam.inner_diameter)
    return cam.model_copy(update={"diameter": 2.0 * radius + width, "inner_diameter": 2.0 * radius - width})


def largest_pressure(model: Model) -> float:
    """The largest pressure that the verdict reads, MPa, of all followers; infinite where one has none."""
    verdict = judge(model, ("contact-pressure", "face-pressure"))
    values = [finding.value for finding in verdict.findings if finding.value is not None]
    return max(values) if values and not verdict.not_judged else inf


def _sharpest(outline: Outline) -> float:
    """Largest convex curvature of an outline, 1/mm."""
    phi, owner = piece_grid(outline.knots(), PER_TURN)

    def f(x: Floats) -> Floats:
        return outline.curve(x).curvature

    return refined_maximum(f, phi, owner, f(phi))[0]


@final
@immutable(eq=True)
class Balance:
    """A disc as a rotor: area mm², mass kg, centroid mm, polar inertia about the shaft kg m², unbalance and correction.

    unbalance   mass times distance of the centroid from the shaft, g mm
    correction  cam-frame angle, rad, at which balancing mass belongs (opposite the centroid)
    """

    area: float
    mass: float
    centroid: tuple[float, float]
    inertia: float
    unbalance: float
    correction: float


def balance(prism: Prism, density: float) -> Balance:
    """The balance of a disc with its bore, keyway and holes, from the exact curves; density kg/m³."""
    outlines = [prism.outer.outline, *(hole.outline for hole in prism.holes)]
    if prism.bore is not None and prism.bore.keyway_width:
        # A fine polygon on the exact bore: its area is good to the square of a micrometre's sag.
        outlines.append(PolygonOutline(prism.bore.outline(1e-7)[0]))
    elif prism.bore is not None:
        outlines.append(CircleOutline(0.5 * prism.bore.diameter))
    area, moment, polar = 0.0, np.zeros(2), 0.0
    for sign, outline in zip([1.0, *([-1.0] * (len(outlines) - 1))], outlines):
        found = OutlineIntegrals(outline).properties
        area += sign * found.area
        moment += sign * found.area * np.array(found.centroid)
        polar += sign * (found.moments[0] + found.moments[1])
    mass = density * 1e-9 * area * (prism.z1 - prism.z0)
    centre = moment / area
    offset = float(np.hypot(*centre))
    correction = (atan2(float(centre[1]), float(centre[0])) + pi) % (2.0 * pi)
    inertia = polar * (prism.z1 - prism.z0) * density * 1e-15
    return Balance(area, mass, (float(centre[0]), float(centre[1])), inertia, mass * 1e3 * offset, correction)


def best_offset(program: Program, pressure_angle: float, sense: float = 1.0, back: float | None = None) -> float:
    """Offset towards +Y, mm, that gives a translating roller follower the smallest prime radius for its limits.

    The needed s0 is convex in the offset (a maximum of straight lines); its prime radius has one minimum, found by
    golden section to the square root of rounding.
    """
    reach = abs(program.peak(1).value) + 1.0
    low, high = -reach, reach
    share = 0.5 * (sqrt(5.0) - 1.0)
    for _ in range(80):
        one, two = high - share * (high - low), low + share * (high - low)
        first, second = (smallest_prime_radius(program, pressure_angle, e, sense, back) for e in (one, two))
        low, high = (low, two) if first < second else (one, high)
    return 0.5 * (low + high)


STEP = 0.01
"""mm; a designed radius or offset is rounded to this"""


def design(text: str, source: str, kind: str, limits: Mapping[str, float | None], best: bool) -> Design:
    """The profile in the text as small as keeps the limits, and with `best` at the best offset too.

    Small is the base radius, of an end-face cam the middle radius of its ring, which stays as wide as it is. `limits`
    are pressure_angle (deg), convex_radius (mm) and contact_pressure (MPa), None for what the profile says. Raises
    ProfileError where the profile is of another kind or a limit asks too much of it, DesignError where no radius keeps
    the limits.
    """
    profile = parse(text, source)
    if profile.kind != kind:
        raise ProfileError([Problem("cam.kind", "is not the kind to design", profile.kind, kind)], source)
    wanted = wanted_of(profile, limits)
    choices = []
    if best:
        offset = _offset(profile, wanted)
        text = with_key(text, "follower", "offset", offset / unit_of(profile))
        profile = parse(text, source)
        choices.append(Choice("follower.offset", offset, "gives the smallest prime radius for the pressure angle"))
    if isinstance(profile.cam, EndFace):
        wanted = replace(wanted, convex_radius_mm=None)
        radius = ceil(smallest_ring(profile, profile.cam, wanted) / STEP) * STEP
        kept, ring = ring_margins(profile, radius, wanted), _ring(profile, radius)
        sizes = {"diameter": ring.diameter, "inner_diameter": ring.inner_diameter}
    else:
        radius = ceil(smallest_base_radius(profile, wanted) / STEP) * STEP
        kept, sizes = margins(profile, radius, wanted), {"base_radius": radius}
    tight = min(kept, key=lambda name: kept[name]) if kept else ""
    asked = [
        f"pressure angle {wanted.pressure_angle_deg:g} deg" if wanted.pressure_angle_deg is not None else "",
        f"convex radius {wanted.convex_radius_mm:g} mm" if wanted.convex_radius_mm is not None else "",
        f"contact pressure {wanted.contact_pressure_mpa:g} MPa" if wanted.contact_pressure_mpa is not None else "",
    ]
    told = ", ".join(filter(None, asked)) or "what can be built"
    why = f"the smallest for {told}; {tight} decides" if tight else "nothing limits it"
    for (key, size), reason in zip(sizes.items(), (why, "the ring is as wide as before")):
        choices.append(Choice(f"cam.{key}", round(size, 6), reason))
        text = with_key(text, "cam", key, round(size, 6) / unit_of(profile))
    text = asking(text, limits)
    return Design(text, tuple(choices), findings(Model(parse(text, source)), light_checks()))


def asking(text: str, limits: Mapping[str, float | None]) -> str:
    """The TOML text with the limits that were asked for as its own, so that every later check judges by them."""
    for name, key in (("pressure_angle", "pressure_angle_deg"), ("contact_pressure", "contact_pressure_mpa")):
        if (value := limits[name]) is not None:
            text = with_key(text, "limits", key, value)
    return text


def unit_of(profile: Profile) -> float:
    """The unit of the profile's lengths, mm."""
    return INCH if profile.units == "inch" else 1.0


def wanted_of(profile: Profile, limits: Mapping[str, float | None]) -> PlanarLimits:
    """The limits given, else those of the profile. Raises ProfileError for one that no cam can keep."""
    ranges = {"pressure_angle": ("deg", 90.0), "convex_radius": ("mm", inf), "contact_pressure": ("MPa", inf)}
    bad = [
        Problem(f"--{key.replace('_', '-')}", "is out of range", value, f"above 0 and below {high:g} {unit}")
        for key, (unit, high) in ranges.items()
        if (value := limits[key]) is not None and not (0.0 < value < high or (key == "convex_radius" and value == 0.0))
    ]
    if bad:
        raise ProfileError(bad)
    own = profile.limits.for_follower(profile.follower)
    if limits["pressure_angle"] is not None and profile.roller is None and profile.follower.square:
        text = "a flat face pushes square to itself: its pressure angle is 0 on a cam of any size"
        raise ProfileError([Problem("--pressure-angle", text, limits["pressure_angle"], "", "leave it out")])
    angle, pressure = limits["pressure_angle"], limits["contact_pressure"]
    pressure = own.contact_pressure_mpa if pressure is None else pressure
    if pressure is not None and profile.operation is None:
        raise ProfileError([Problem("--contact-pressure", "the profile has no [operation] to compute it from")])
    return PlanarLimits(own.pressure_angle_deg if angle is None else angle, limits["convex_radius"] or 0.0, pressure)


def _offset(profile: Profile, wanted: PlanarLimits) -> float:
    """The best offset of a translating roller follower, mm, to a hundredth."""
    follower, mechanism = profile.follower, profile.cam.mechanism(profile.setup())
    simple = follower.face == "roller" and not follower.rotating and len(mechanism.tracks) == 1
    if not simple or wanted.pressure_angle_deg is None:
        raise ProfileError([Problem("--best-offset", "only a roller on a slide has an offset to choose")])
    best = best_offset(mechanism.program, radians(wanted.pressure_angle_deg), mechanism.sense)
    return round(best / STEP) * STEP


def with_key(text: str, table: str, key: str, value: float) -> str:
    """The TOML text with one number of a table replaced or added; everything else, comments too, stays as it is."""
    lines = text.splitlines()
    heads = [i for i, line in enumerate(lines) if line.lstrip().startswith("[")]
    first = next((i for i in heads if re.match(rf"\s*\[\s*{re.escape(table)}\s*\]", lines[i])), None)
    if first is None:
        return "\n".join([*lines, "", f"[{table}]", f"{key} = {value:.12g}", ""])
    last = next((i for i in heads if i > first), len(lines))
    for i in range(first + 1, last):
        found = re.match(rf"(\s*{re.escape(key)}\s*=\s*)[^#\s]+(.*)$", lines[i])
        if found:
            lines[i] = f"{found[1]}{value:.12g}{found[2]}"
            break
    else:
        lines.insert(first + 1, f"{key} = {value:.12g}")
    return "\n".join(lines) + "\n"
