"""Points of the exact flanks and outlines, for measuring machines and for comparison: CSV, PLY, NPZ.

`.points` are all points that the surveys know, with normals and curvatures; `.cmm.csv` the few that a measuring machine
visits; `.outline.csv` the plane curves of a disc.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import CamgeomError, ExportError
from camgeom.export import NO_PLATE, writer
from camgeom.export.files import atomic_write, write_csv
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.model.surfaces import FlankSurface, Mask, RolledFlank, flank_surfaces, within
from camgeom.track.clearance import least_distances
from camgeom.track.flank import Flank

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.track.outline import Outline


def flank_points(model: Model) -> dict[str, Floats]:
    """Points of every flank of a model in the cam frame, mm, exact, with what is known there.

    They lie on the surface that is left of the cam: within the blank, running clearances in it, and nowhere that
    another pass of a tool has cut away. Values of the roller are those of its contact at the same cam angle and place.

    points, normals              (n, 3): the normal points out of the cam's material
    cam_angle_deg, roller_mm     when and where along the roller (planar cams: at which height) the point is touched
    pressure_angle_deg           between the normal and the velocity of the contact point
    curvature_1_per_mm, _2_      principal curvatures of the cam, the larger first; positive where it is convex
    relative_curvature_per_mm    of cam against follower across the contact line; infinite for a knife edge
    track, side                  number of the roller track (or disc); +1 or -1 for its flanks

    Raises DesignError where the flanks fold back on themselves, ExportError where no point of them is left.
    """
    parts: dict[str, list[Floats]] = {}
    left = _left(model)
    for number, surface in enumerate(flank_surfaces(model)):
        angles, _ = piece_grid(surface.knots(), PER_TURN_OF_POINTS)
        phi, t = (grid.ravel() for grid in np.meshgrid(angles, np.linspace(*surface.touched, STATIONS), indexing="ij"))
        kept = left(surface.at(phi, t).x)
        if not np.any(kept):
            continue
        phi, t = phi[kept], t[kept]
        patch = surface.at(phi, t)
        track, side, pressure, relative = _contact(model, surface, number, phi, t)
        larger, smaller = patch.curvatures
        columns = {
            "points": patch.x.T,
            "normals": patch.n.T + 0.0,
            "cam_angle_deg": np.degrees(surface.angle(phi)),
            "roller_mm": surface.station(t),
            "pressure_angle_deg": np.degrees(pressure),
            "curvature_1_per_mm": larger,
            "curvature_2_per_mm": smaller,
            "relative_curvature_per_mm": relative,
            "track": np.full(phi.shape, float(track)),
            "side": np.full(phi.shape, side),
        }
        for name, values in columns.items():
            parts.setdefault(name, []).append(values)
    if not parts:
        raise ExportError("no flank points: nothing of the flanks is left within the blank")
    return {name: np.concatenate(values) for name, values in parts.items()}


PER_TURN_OF_POINTS = 720
STATIONS = 9
CUT_AWAY = 1e-9
"""mm; a tool that comes so deep below a point has removed it"""


def _left(model: Model) -> Callable[[Floats], Mask]:
    """Whether points (3, n) of the flanks are left: within the blank, and cut away by no tool's other pass."""
    depth = within(model)
    cutters = tuple(track for one in model.grooves if one.planar is None for track in one.cutters)

    def left(x: Floats) -> Mask:
        kept = depth(x) >= 0.0
        for cutter in cutters:
            kept[kept] = least_distances(cutter, x[:, kept].T) > -CUT_AWAY
        return kept

    return left


def _contact(
    model: Model, surface: FlankSurface, number: int, phi: Floats, t: Floats
) -> tuple[int, float, Floats, Floats]:
    """Number and side of a flank's roller track; pressure angle (rad) and relative curvature (1/mm) of its contact."""
    if isinstance(surface, RolledFlank):
        flanks = [(one.groove + k, survey) for one in model.grooves for k, survey in enumerate(one.flanks)]
        track, survey = next(each for each in flanks if each[1].cutter is surface.track)
        flank = Flank(survey.track, surface.angle(phi), t[:, None], surface.side)
        return track, surface.side, flank.pressure_angle()[:, 0], flank.k_rel[:, 0]
    touches = [(one.groove, touch) for one in model.grooves for touch in one.mechanism.touches]
    track, touch = next((one for one in touches if one[1].outline is surface.outline), touches[0])
    at = touch.at(phi)
    disc = number if len(model.parts) > 1 else track
    return disc, -model.mechanism.sense * surface.material, at.pressure_angle, at.relative


@writer(".points.ply", "flank points with normals and curvatures, binary PLY; exact", "model")
def write_points_ply(path: Path, model: Model) -> int:
    """Write the flank points to a little-endian PLY file of doubles (x y z nx ny nz, scalars); returns its bytes.

    Raises DesignError where the flanks fold, ExportError where a number is not finite or the file cannot be written.
    """
    names, table = _table(_cloud(path, model))
    lines = ["ply", "format binary_little_endian 1.0", "comment camgeom, lengths in mm"]
    lines += [f"element vertex {len(table)}", *(f"property double {name}" for name in names), "end_header"]
    with atomic_write(path) as stream:
        stream.write(("\n".join(lines) + "\n").encode("ascii"))
        stream.write(table.data)
        return stream.tell()


@writer(".points.csv", "flank points with normals and curvatures, CSV; exact", "model")
def write_points_csv(path: Path, model: Model) -> int:
    """Write the flank points to a CSV file, one a line; returns the bytes written. Raises as `write_points_ply`."""
    names, table = _table(_cloud(path, model))
    return write_csv(path, names, [("", table)])


@writer(".points.npz", "flank points with normals and curvatures, numpy archive; exact", "model")
def write_points_npz(path: Path, model: Model) -> int:
    """Write the flank points to a numpy archive, the arrays by name; returns the bytes written. Raises as above."""
    cloud = _cloud(path, model)
    with atomic_write(path) as stream:
        np.savez(stream, allow_pickle=False, **cloud)
        return stream.seek(0, 2)


def _cloud(path: Path, model: Model) -> dict[str, Floats]:
    """The flank points; ExportError naming the file where there are none or a number is not finite."""
    try:
        cloud = flank_points(model)
    except ExportError as error:
        raise ExportError(f"{path}: {error}") from error
    for name, values in cloud.items():
        # A knife edge is infinitely sharp.
        if np.any(np.isnan(values)) or (name != "relative_curvature_per_mm" and np.any(np.isinf(values))):
            raise ExportError(f"{path}: {name} has a value that is not finite")
    return cloud


def _table(cloud: dict[str, Floats]) -> tuple[list[str], Floats]:
    """Column names and the (n, k) table of flank points."""
    vectors = {"points": ["x", "y", "z"], "normals": ["nx", "ny", "nz"]}
    names = [column for name in cloud for column in vectors.get(name, [name])]
    return names, np.ascontiguousarray(np.column_stack(list(cloud.values())), dtype="<f8")


STEP = 1.0
"""deg of cam angle between points"""
ACROSS = 3
"""points along the roller"""
INSET = 0.1
"""share of the touched stretch that is left free at its ends"""
FRAME_STEP = 5.0
"""mm between points of a frame"""
COLUMNS = (
    "flank", "cam_angle_deg", "station_mm", "x_mm", "y_mm", "z_mm", "normal_x", "normal_y", "normal_z",
    "polar_angle_deg", "polar_radius_mm", "pitch_x_mm", "pitch_y_mm", "pitch_z_mm", "pitch_angle_deg",
    "pitch_radius_mm",
)  # fmt: skip


@writer(".cmm.csv", "inspection points of every flank: Cartesian, polar, normals, roller centres, CSV", takes="model")
def write_cmm_csv(path: Path, model: Model, step: float = STEP, across: int = ACROSS) -> int:
    """Write nominal points of every flank in the cam frame; returns the bytes written.

    step    deg of cam angle; across: points along the roller (or over the height of a disc)
    Points lie on the exact flank that is left within the blank; normals point out of the material; the polar angle
    is counted from +X towards +Y. Roller-centre columns stay empty where the follower has no roller. `camgeom inspect`
    reads the same columns with measured coordinates. Raises ExportError where the cam has no flank or the file cannot
    be written.
    """
    try:
        surfaces, left = flank_surfaces(model), _left(model)
        rows = [(surface.name, _inspection_rows(surface, step, across)) for surface in surfaces]
    except CamgeomError as error:
        raise ExportError(f"{path}: {error}") from error
    return write_csv(path, COLUMNS, ((f"{name},", table[left(table[:, 2:5].T)]) for name, table in rows))


def _inspection_rows(surface: FlankSurface, step: float, across: int) -> Floats:
    """Numbers (k, 15) of one flank; NaN where there is no roller."""
    low, high = surface.span
    count = max(3, round(np.degrees(high - low) / step))
    angles = np.linspace(low, high, count, endpoint=False) if surface.closed else np.linspace(low, high, count + 1)
    bottom, top = surface.touched
    share = np.linspace(INSET, 1.0 - INSET, across) if across > 1 else np.array([0.5])
    phi, t = (grid.ravel() for grid in np.meshgrid(angles, bottom + share * (top - bottom), indexing="ij"))
    patch = surface.at(phi, t)
    pitch = surface.pitch(phi, t)
    pitch = np.full((3, len(phi)), np.nan) if pitch is None else pitch
    angle = np.degrees(surface.angle(phi))
    columns = [angle, surface.station(t), *patch.x, *patch.n, *_polar(patch.x), *pitch, *_polar(pitch)]
    return np.column_stack(columns) + 0.0  # no negative zeros


FRAME_COLUMNS = ("face", "x_mm", "y_mm", "z_mm", "normal_x", "normal_y", "normal_z")


@writer(
    ".frame.points.csv", "inspection points of the frame: faces, window, guide bores, with normals, CSV; exact",
    takes="model", cams="frames with a plate",
    missing=lambda model: "" if model.mechanism.frame is not None else NO_PLATE,
)
def write_frame_points(path: Path, model: Model, step: float = FRAME_STEP) -> int:
    """Write nominal points of the frame as it stands at zero lift, cam frame; returns the bytes written.

    step  mm between points along the window and the guide bores. Normals point out of the material. Raises ExportError
    where the frame is no part, or the file cannot be written.
    """
    plate = model.mechanism.frame
    if plate is None:
        raise ExportError(f"{path}: {NO_PLATE}")
    rows = ((f"{name},", np.hstack([points, normals]) + 0.0) for name, points, normals in plate.points(step))
    return write_csv(path, FRAME_COLUMNS, rows)


def _polar(x: Floats) -> tuple[Floats, Floats]:
    """Angle (deg, 0 to 360) and radius (mm) of points (3, n) about the cam axis."""
    return np.degrees(np.arctan2(x[1], x[0])) % 360.0, np.hypot(x[0], x[1])


PER_TURN = 3600
NOT_PLANAR = "only planar cams have outlines"
OUTLINE_COLUMNS = ("curve", "cam_angle_deg", "x_mm", "y_mm", "normal_x", "normal_y", "curvature_per_mm")


@writer(
    ".outline.csv", "profile and pitch curves, normals, curvature, CSV; exact", takes="model", cams="planar cams",
    missing=lambda model: "" if model.mechanism.profiles else NOT_PLANAR, body=False,
)
def write_outline_csv(path: Path, model: Model) -> int:
    """Write every outline of a planar cam, a tenth of a degree apart and one-sided at knots; returns the bytes written.

    Points lie on the exact curve, numbers read back to the last bit; normals point outwards, curvature is positive
    where the curve is convex. Raises ExportError for a cam that is not planar, or where the file cannot be written.
    """
    if not model.mechanism.profiles:
        raise ExportError(f"{path}: {NOT_PLANAR}")

    def table(outline: Outline) -> Floats:
        phi, _ = piece_grid(outline.knots(), PER_TURN)
        curve = outline.curve(phi)
        return np.stack([np.degrees(phi), *curve.points, *curve.normals, curve.curvature], axis=1)

    several = len(model.grooves) > 1
    outlines = {
        f"track {one.groove + 1} {name}" if several else name: outline
        for one in model.grooves for name, outline in one.mechanism.outlines.items()
    }  # fmt: skip
    return write_csv(path, OUTLINE_COLUMNS, ((f"{name},", table(outline)) for name, outline in outlines.items()))
