"""The 3D view: bodies moving over one turn, the flanks coloured by their results."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np
import numpy.typing as npt

from camgeom.drawing.content import Actor, Axis, Block, Scene, Shade
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.mesh import Mesh
from camgeom.report.sections.bodies import (
    cam_meshes,
    cam_poses,
    follower_bodies,
    kept,
)
from camgeom.report.sections.design import views
from camgeom.report.sections.flank import FLAT, STEEPEST
from camgeom.report.sections.motion import units
from camgeom.track import TURN, Track
from camgeom.track.flank import Flank

if TYPE_CHECKING:
    from camgeom.maths.extremum import Extreme
    from camgeom.mechanics.roller_duty import RollerDuty
    from camgeom.model import Model
    from camgeom.track.planar import Planar
    from camgeom.track.touch import Touch

FRAMES = 181
ACROSS, ALONG = 721, 13
"""flank samples per track and side that mesh vertices are looked up in"""
WINDOW, STEPS = np.radians(15.0), 61
"""cam angles about its own at which a vertex is measured against the roller"""
BLOCK = 2048
"""vertices measured at once: some tens of megabytes"""
AROUND = 2881
"""places round the profile that mesh vertices are looked up in"""
NEAR, LEVEL = 0.01, 1e-6
"""a vertex belongs to the profile within this share of the cam's size, and so many mm above or below its wall"""
COLOURED = ("flank",)
GROOVE = ("flank", "floor", "edge", "root")
"""faces that a clearance is shown on"""
NOTHING = 1e-3
"""mm; a clearance nowhere larger than this is contact all over and no picture"""

SHADES = (
    Shade("pressure_angle", "Pressure angle", "°", groups=COLOURED),
    Shade("curvature", "Relative curvature", "1/mm", groups=COLOURED),
    Shade("pressure", "Contact pressure", "MPa", groups=COLOURED),
    Shade("clearance", "Clearance to the roller", "mm", groups=GROOVE),
)


def mechanism(model: Model) -> tuple[Block, ...]:
    """The scene of cam and follower over one turn."""
    return (kept(model, "3D view", lambda: scene(model, cam_meshes(model))),)


INTO_RING = (-0.72, -0.58, 1.1)
"""direction to the eye, over the far side of a ring whose follower stands within it at +X"""


def scene(model: Model, meshes: tuple[tuple[str, Mesh], ...], frames: int = FRAMES, whole: bool = True) -> Scene:
    """The scene of some meshes of the cam with its follower; `whole`: with their results and the drawing that stands in
    for it."""
    phi = np.linspace(0.0, TURN, frames)
    bodies = []
    for name, mesh in meshes:
        bodies.append(Actor(name, mesh, cam_poses(model.mechanism, phi), "cam", fields(model, mesh) if whole else {}))
    bodies += [Actor(name, mesh, moved, "follower") for _, name, mesh, moved in follower_bodies(model, phi)]
    shown = tuple(shade for shade in SHADES if any(shade.key in body.fields for body in bodies))
    axes, factors = units(model)
    lift = factors[0] * model.setup.program.jet(phi, 0)[0]
    readouts = ((Axis("Position" if model.profile.rotating else "Lift", axes[0].unit), lift),)
    operation = model.profile.operation
    speed = operation.speed if operation is not None else 60.0
    return Scene(
        "The mechanism over one turn: drag to turn it, click it and scroll to zoom",
        np.degrees(phi),
        tuple(bodies),
        shown,
        readouts,
        speed,
        views(model, meshes)[0] if whole else None,
        INTO_RING if model.mechanism.inside else None,
    )


@final
@immutable
class _Samples:
    """Flank samples: points (k, 3), cam angles (k,), results (k,) by name, and the track each belongs to (k,)."""

    points: Floats
    phi: Floats
    results: dict[str, Floats]
    track: npt.NDArray[np.intp]


def fields(model: Model, mesh: Mesh) -> dict[str, Floats]:
    """Results on the vertices (v,) of a cam body, NaN away from the flanks.

    The vertex nearest to where a follower presses hardest has that pressure: what is pressed may be narrower than the
    mesh, and than the samples that its vertices are looked up in.
    """
    found = _painted(model, mesh)
    if "pressure" in found:
        spots = kept(model, "hardest places", lambda: [spot for one in model.grooves for spot in hardest_places(one)])
        for point, value in spots:
            at = _vertex(mesh, point)
            found["pressure"][at] = np.fmax(found["pressure"][at], value)
    return found


def _vertex(mesh: Mesh, point: Floats) -> npt.NDArray[np.intp]:
    """The vertex of the flanks nearest to a point (3,), none where that is of another body; without a height all above
    each other."""
    wall = distinct(mesh.faces[mesh.group_faces("flank")]).astype(np.intp)
    x = mesh.vertices[wall]
    if np.isnan(point[2]):
        far = np.hypot(*(x[:, :2] - point[:2]).T)
        return np.asarray(wall[far <= far.min() + LEVEL])
    if not x[:, 2].min() - LEVEL <= point[2] <= x[:, 2].max() + LEVEL:
        return np.asarray(wall[:0])
    return np.asarray(wall[[np.linalg.norm(x - point, axis=1).argmin()]])


def hardest_places(model: Model) -> list[tuple[Floats, float]]:
    """Where the followers on a track press it hardest: points (3,), cam frame, of height NaN where that is at all
    heights, and the largest pressures, MPa, as the check tells them."""
    found: list[tuple[Floats, float]] = []
    for one in model.mates:
        state = one.hardest_state
        if state.duties:
            touches = () if state.planar is None else state.planar.touches
            own = [(one,) for one in touches] if len(state.duties) > 1 and touches else [touches] * len(state.duties)
            each: list[tuple[Floats, float] | None] = [_hardest_of(*pair) for pair in zip(state.duties, own)]
        elif state.drive is not None and state.planar is not None:
            each = [_hardest_touch(state.drive.peak_pressure, state.planar)]
        else:
            each = [_hardest_roller(state)]
        found += [spot for spot in each if spot is not None and np.isfinite(spot[1])]
    return found


def _hardest_of(duty: RollerDuty, touches: tuple[Touch, ...]) -> tuple[Floats, float]:
    peak, behind = duty.least_peak, duty.hardest_wall > 0
    phi = np.array([peak.cam_angle])
    if touches:
        touch = next((one for one in touches if (one.way > 0.0) == behind), touches[0])
        return np.append(touch.at(phi).curve.points[:, 0], peak.place), peak.value
    t = np.array([duty.track.meridian.parameter(peak.place)])
    walls = [Flank(duty.track, phi, t, side) for side in duty.track.sides]
    wall = next((one for one in walls if one.behind == behind), walls[0])
    return wall.points[0, 0], peak.value


def _hardest_touch(peak: Extreme | None, planar: Planar) -> tuple[Floats, float] | None:
    if peak is None:
        return None
    touch = next(one for one in planar.touches if one.name == peak.where)
    return np.append(touch.at(np.array([peak.cam_angle])).curve.points[:, 0], np.nan), peak.value


def _hardest_roller(model: Model) -> tuple[Floats, float] | None:
    duty = model.turret_duty
    if duty is None:
        return None
    number, phi, wall = duty.hardest_contact
    track = model.flanks[number].track
    t = np.array([track.meridian.parameter(duty.least_peak.place)])
    flanks = [Flank(track, np.array([phi]), t, side) for side in track.sides]
    pressed = next((one for one in flanks if _wall(one)[0] == wall), flanks[0])
    return pressed.points[0, 0], duty.least_peak.value


def _wall(flank: Flank) -> npt.NDArray[np.intp]:
    """Which wall of a turret's roller a flank is, (n,): 0 that of a negative lever, else 1."""
    return np.where(flank.lever().mean(axis=1) < 0.0, 0, 1)


def _painted(model: Model, mesh: Mesh) -> dict[str, Floats]:
    """Results on the vertices (v,), of the nearest sample of a flank or place of a profile."""
    if len(model.grooves) > 1:
        # A vertex belongs to one groove: the others know nothing of it.
        each = [_fields_of(one, mesh) for one in model.grooves]
        names = dict.fromkeys(name for one in each for name in one)
        nothing = np.full(len(mesh.vertices), np.nan)
        return {name: np.fmax.reduce([one.get(name, nothing) for one in each]) for name in names}
    return _fields_of(model, mesh)


def _fields_of(model: Model, mesh: Mesh) -> dict[str, Floats]:
    """The same of one track."""
    if model.planar is not None:
        # A prism has no vertices half way up, where a crowned roller presses: its profile knows more.
        known = profile_fields(model, mesh)
        return (_track_fields(model, mesh) if model.tracks else {}) | known
    return _track_fields(model, mesh)


def _track_fields(model: Model, mesh: Mesh) -> dict[str, Floats]:
    """Results on the vertices (v,) by the flanks of the roller tracks."""
    from scipy.spatial import cKDTree

    samples = kept(model, "flank samples", lambda: _sampled(model))
    found = cKDTree(samples.points).query(mesh.vertices)
    distance, nearest = np.asarray(found[0], dtype=np.float64), np.asarray(found[1], dtype=np.intp)
    out: dict[str, Floats] = {}
    radius = max(_largest_radius(track) for track in model.tracks)
    # A straight flank has vertices at its ends alone, the deeper of them beyond the roller's.
    beyond = max(abs(cutter.tip - track.tip) for track, cutter in zip(model.tracks, model.cutters))
    on = mesh.group_faces("flank")
    wall = np.zeros(len(mesh.vertices), dtype=bool)
    wall[mesh.faces[on]] = True
    for name, values in samples.results.items():
        field = np.where(wall & (distance < 0.25 * radius + beyond), values[nearest], np.nan)
        if np.any(np.isfinite(field)):
            out[name] = field
    groove = np.zeros(len(mesh.vertices), dtype=bool)
    for name in GROOVE:
        groove[mesh.faces[mesh.group_faces(name)]] = True
    near = np.flatnonzero(groove & (distance < 1.2 * radius))
    gap = np.full(len(mesh.vertices), np.nan)
    gap[near] = np.maximum(_clearance(model, mesh.vertices[near], samples, nearest[near]), 0.0)
    if np.any(gap[near] > NOTHING):
        out["clearance"] = gap
    return out


def _largest_radius(track: Track) -> float:
    ends = np.array([track.meridian.parameter(d) for d in track.contact])
    return float(track.meridian.jet(np.linspace(ends.min(), ends.max(), 9))[3].max())


def _sampled(model: Model) -> _Samples:
    parts: list[tuple[Floats, Floats, dict[str, Floats], int]] = []
    for number, survey in enumerate(model.flanks):
        low, high = survey.track.once
        hair = 1e-9 * (high - low)
        phi = np.linspace(low + hair, high - hair, ACROSS)
        t = np.linspace(survey.stations[0], survey.stations[-1], ALONG)
        for side in survey.track.sides:
            flank = Flank(survey.track, phi, t, side)
            results = {"pressure_angle": np.degrees(flank.pressure_angle()).ravel(), "curvature": flank.k_rel.ravel()}
            states = [one.hardest_state for one in model.mates]
            state = states[0]
            sound = all(one.duties and bool(np.all(one.duty.slices.sound)) for one in states)
            if number == 0 and model.planar is None and sound:
                each = [_pressure(one, flank, phi, t) for one in states]
                results["pressure"] = np.maximum.reduce(each).ravel()
            elif state.turret_duty is not None and model.planar is None:
                results["pressure"] = state.turret_duty.pressure_at(number, phi, t, _wall(flank)).ravel()
            parts.append((flank.points.reshape(-1, 3), np.repeat(phi, ALONG), results, number))
    names = sorted({name for part in parts for name in part[2]})
    blank = [np.full(len(part[1]), np.nan) for part in parts]
    return _Samples(
        np.concatenate([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts]),
        {name: np.concatenate([p[2].get(name, b) for p, b in zip(parts, blank)]) for name in names},
        np.concatenate([np.full(len(part[1]), part[3]) for part in parts]),
    )


def _pressure(model: Model, flank: Flank, phi: Floats, t: Floats) -> Floats:
    """Peak pressure (n, m) that a flank bears as the roller passes; zero where the other wall is loaded."""
    duty, wall = model.duty, 1 if flank.behind else -1
    delta, carriage = flank.track.meridian.jet(t)[0], model.mechanism.carriage
    out = duty.pressure_at(phi % TURN, delta, wall)
    return out if carriage is None else np.maximum(out, duty.pressure_at(carriage.back(phi), delta, wall))


def _clearance(model: Model, points: Floats, samples: _Samples, nearest: npt.NDArray[np.intp]) -> Floats:
    """Least distance (v,) of points from the roller as it passes, mm."""
    from camgeom.track.clearance import roller_distance

    out = np.full(len(points), np.inf)
    offsets = np.linspace(-WINDOW, WINDOW, STEPS)
    for number, track in enumerate(model.tracks):
        mine = np.flatnonzero(samples.track[nearest] == number)
        span = (-TURN, 2 * TURN) if track.closed else track.span
        for block in (mine[k : k + BLOCK] for k in range(0, len(mine), BLOCK)):
            phi = np.clip(samples.phi[nearest[block]][:, None] + offsets, *span)
            x = np.broadcast_to(points[block].T[:, :, None], (3, *phi.shape))
            out[block] = roller_distance(track, x, phi).min(axis=1)
    return out


def profile_fields(model: Model, mesh: Mesh) -> dict[str, Floats]:
    """Results on the vertices (v,) of a cam body, NaN away from its profile; empty where nothing is known."""
    planar = model.planar
    if planar is None:
        return {}
    phi = np.linspace(0.0, 2.0 * np.pi, AROUND)
    heights, level = np.unique(mesh.vertices[:, 2], return_inverse=True)
    points, values = [], []
    for number, touch in enumerate(planar.touches):
        at = touch.at(phi)
        points.append(at.curve.points.T)
        values.append({"pressure_angle": np.degrees(np.abs(at.pressure_angle)), "curvature": at.relative})
        mates = [_touch_pressure(one.hardest_state, number, phi, heights) for one in model.mates]
        if pressed := [pressure for pressure in mates if pressure is not None]:
            values[-1]["pressure"] = np.maximum.reduce(pressed)
    distance, nearest = _nearest(np.concatenate(points), mesh.vertices[:, :2])
    wall = np.zeros(len(mesh.vertices), dtype=bool)
    wall[mesh.faces[mesh.group_faces("flank")]] = True
    on = wall & (distance < NEAR * float(np.ptp(mesh.vertices[:, :2])))
    if (ends := model.mechanism.wall) is not None:
        # Of tracks in both faces of a disc the flanks cross in this plane.
        on &= (mesh.vertices[:, 2] > ends[0] - LEVEL) & (mesh.vertices[:, 2] < ends[1] + LEVEL)
    found: dict[str, Floats] = {}
    for name in ("pressure_angle", "curvature", "pressure"):
        if any(name not in one for one in values):
            continue
        field = np.concatenate([one[name] for one in values])
        known = np.isfinite(field) & (np.abs(field) < STEEPEST)
        if known.all() and not (name == "pressure_angle" and float(field.max()) < np.degrees(FLAT)):
            each = field[nearest] if field.ndim == 1 else field[nearest, level]
            found[name] = np.where(on, each, np.nan)
    return {name: field for name, field in found.items() if np.any(np.isfinite(field))}


def _touch_pressure(model: Model, number: int, phi: Floats, heights: Floats) -> Floats | None:
    """Peak pressure of a touch at cam angles phi (n,) and heights z (j,), (n, j); None where none is known.

    Of a roller where it touches along its length; of a face over all of it.
    """
    touch = model.planar.touches[number] if model.planar is not None else None
    if touch is None or model.drive is None or touch.name not in model.drive.contacts:
        return None
    if model.duties:
        duty = model.duties[number if len(model.duties) > 1 else 0]
        if not bool(np.all(duty.slices.sound)):
            return None
        return duty.pressure_at(phi % TURN, heights, 1 if touch.way > 0.0 else -1)
    contact = model.drive.contacts[touch.name]
    where = contact.panels
    inside = np.clip(phi, where.edges[0] + 1e-9, where.edges[-1] - 1e-9)
    each = np.sqrt(np.maximum(np.asarray(where.at(contact.behind, inside)), 0.0))
    return np.repeat(each[:, None], len(heights), axis=1)


def _nearest(points: Floats, places: Floats) -> tuple[Floats, np.ndarray[tuple[int], np.dtype[np.intp]]]:
    """Distance (v,) of places (v, 2) from the nearest of the points (k, 2), and which that is."""
    from scipy.spatial import cKDTree

    distance, nearest = cKDTree(points).query(places)
    return np.asarray(distance, dtype=np.float64), np.asarray(nearest, dtype=np.intp)
