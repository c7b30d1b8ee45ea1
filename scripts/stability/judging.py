"""Judge one random design: a good body, a true finding, a true refusal, or a silent failure."""

from __future__ import annotations

import json
import re
import time
import warnings
from math import hypot, inf
from typing import Any

import numpy as np

from camgeom.errors import CamgeomError, ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.report.delivery import finite
from camgeom.report.result import compute
from camgeom.solid.mechanism import Drive
from tests.oracle.cams import disc_walls, judges_of
from tests.oracle.stations import least_apart, torque

PRODUCTS = ("motion", "flank", "checks", "solid", "contact", "fatigue")
SAMPLES = 80
ROUNDING = 1e-9
"""share of the part's size that rounding may take of a measured distance"""
SPEAKING = (
    "interference", "contact-length", "undercut", "self-crossing", "face-curvature", "relative-curvature", "watertight",
    "fins",
)  # fmt: skip
"""findings that say a body is not what the motion asks for"""


class Failure(Exception):
    """What the package did wrong without saying so."""


def judge(data: dict[str, Any], seed: int = 0) -> dict[str, Any]:
    """The record of a design: outcome, message or findings, measured errors, seconds."""
    began = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            record = _judged(frozen(data), np.random.default_rng(seed))
        except Failure as failure:
            record = {"outcome": "FAILURE", "why": str(failure)}
        except CamgeomError as error:
            record = {"outcome": "FAILURE", "why": f"untimely {type(error).__name__}: {error}"}
        except Exception as error:
            import traceback

            where = traceback.extract_tb(error.__traceback__)[-1]
            record = {"outcome": "FAILURE", "why": f"{type(error).__name__}: {error} ({where.filename}:{where.lineno})"}
    record["seconds"] = round(time.perf_counter() - began, 3)
    return record


def frozen(value: Any) -> Any:
    """Lists as tuples, as the reader of profiles gives them."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(frozen(item) for item in value) if isinstance(value, list | tuple) else value


def _judged(data: dict[str, Any], rng: np.random.Generator) -> dict[str, Any]:
    try:
        profile = from_data(data, "")
    except ProfileError as error:
        return {"outcome": "refused", "why": str(error)}
    model = Model(profile)
    result = compute(model, PRODUCTS)
    _refuse_nan(result.data)
    json.dumps(finite(result.data), allow_nan=False)
    failed = [f for f in result.findings if not f.passed]
    for finding in failed:
        if not finding.advice and finding.check != "hand-over":
            raise Failure(f"finding {finding.check} fails without advice")
    lost = {product.name: product for product in result.products if product.exit_status}
    for product in lost.values():
        if product.trace:
            raise Failure(f"{product.name}: {product.reason}")
        _verify_refusal(model, product.reason, data)
    if any(product.status == "failed" for product in lost.values()):
        return {"outcome": "stopped", "why": "; ".join(f"{name}: {one.reason}" for name, one in lost.items())}
    if "solid" in lost:
        return {"outcome": "no body", "why": lost["solid"].reason, "findings": sorted({f.check for f in failed})}
    spoken = sorted({f.check for f in failed} & set(SPEAKING))
    errors = _verify_bodies(model, data, rng, spoken)
    if data.get("track") and data["cam"]["kind"] == "disc":
        _verify_walls(model, data)
    if data.get("station") and "together" not in lost:
        _verify_stations(model, data)
    outcome = "finding" if failed else "good"
    return {"outcome": outcome, "findings": sorted({f.check for f in failed}), **errors}


def _refuse_nan(value: Any, path: str = "result") -> None:
    """Raise Failure for a NaN anywhere, and for an endless value of a finding that passes."""
    if isinstance(value, dict):
        if value.get("passed") is True and value.get("value") is not None and not np.isfinite(value["value"]):
            raise Failure(f"{path}: the finding {value['check']} passes with the value {value['value']}")
        for key, item in value.items():
            _refuse_nan(item, f"{path}.{key}")
    elif isinstance(value, list | tuple):
        for i, item in enumerate(value):
            _refuse_nan(item, f"{path}[{i}]")
    elif isinstance(value, float) and np.isnan(value):
        raise Failure(f"{path} is NaN")


def _judges(model: Model, data: dict[str, Any]) -> list[Any]:
    programs = [one.setup.program for one in model.grooves]
    ends = np.array([span.end for program in programs for span in program.spans])
    first, *others = [
        (lambda phi, program=program: program.jet(phi, 0)[0], *(float(end.value) for end in program.extremes(0)))
        for program in programs
    ]
    return judges_of(data, *first, ends, others)


def _verify_bodies(model: Model, data: dict[str, Any], rng: np.random.Generator, spoken: list[str]) -> dict[str, Any]:
    """Every body closed, of one piece and its genus, and its surface where the oracle says. Raises Failure."""
    worst, deepest = 0.0, 0.0
    solids, judges = model.solids, _judges(model, data)
    if "interference" in spoken and not data["cam"].get("preload"):
        _verify_interference(model, data, judges)
    if len(solids) != len(judges):
        raise Failure(f"{len(solids)} bodies where {len(judges)} are expected")
    for solid, oracle in zip(solids, judges):
        mesh = solid.mesh
        size = float(np.abs(mesh.vertices).max())
        closed, genus, pieces = topology(mesh)
        if not np.isfinite(mesh.vertices).all() or not closed:
            raise Failure("the mesh is not closed or not finite")
        if volume(mesh) <= 0.0:
            raise Failure("the mesh is inside out")
        if (pieces, genus) != (1, oracle.genus) and not {"watertight", "fins"} & set(spoken):
            raise Failure(f"{pieces} pieces of genus {genus} where 1 of {oracle.genus} is expected, and no finding")
        if solid.chord_error > model.tolerance * (1.0 + 1e-9):
            raise Failure(f"chord error {solid.chord_error:g} above the tolerance {model.tolerance:g}")
        if (solid.free_error or 0.0) > model.free_tolerance * (1.0 + 1e-9):
            raise Failure(f"free chord error {solid.free_error:g} above the tolerance {model.free_tolerance:g}")
        error, depth = _surface(mesh, oracle, (model.tolerance, model.free_tolerance), rng)
        worst, deepest = max(worst, error), max(deepest, depth)
    slack = 1.0 + ROUNDING * size / model.tolerance
    if deepest > slack and not spoken:
        raise Failure(f"the follower cuts {deepest:.6g} tolerances deep into the body, and no finding says so")
    if worst > slack and not spoken:
        raise Failure(f"the surface is {worst:.6g} tolerances off the oracle's")
    return {"error": round(worst, 4), "depth": round(deepest, 4), "triangles": sum(len(s.mesh.faces) for s in solids)}


def _verify_walls(model: Model, data: dict[str, Any]) -> None:
    """What is left between the tracks of a disc as thick as the swaths of its rollers leave it."""
    lifts = [lambda phi, program=one.setup.program: program.jet(phi, 0)[0] for one in model.grooves]
    wanted, off = disc_walls(data, lifts)
    told = {wall.name: wall.thickness for wall in model.walls}
    for name, thickness in wanted.items():
        if name not in told:
            raise Failure(f"no wall {name!r} is told, where {thickness:g} mm are left")
        if not -1e-3 * off <= thickness - told[name] <= off:
            raise Failure(f"the wall {name!r} is {thickness:g} mm, not {told[name]:g}")


def _verify_stations(model: Model, data: dict[str, Any]) -> None:
    """Followers on one track as near to each other as the oracle has them, and their torques its sum."""
    program = model.setup.program
    found = model.apart
    wanted = least_apart(data, lambda phi: program.jet(phi, 0)[0])
    size = float(np.abs(model.solid.mesh.vertices).max())
    # Places along an axis are sampled, so that the oracle sees the distance a little too large.
    if wanted is not None and (found is None or not -1e-9 * size <= wanted - found.value <= 0.02 * size):
        raise Failure(f"followers {found} apart where the oracle sees {wanted:g} mm")
    if "operation" not in data or model.camshaft is None or any("force" in one for one in data["station"]):
        return
    theta = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, 400)
    wanted_torque, pulls = torque(data, program, theta)
    if model.mechanism.drive is Drive.ALONE:
        theta, wanted_torque = theta[~pulls], wanted_torque[~pulls]
    scale = float(np.abs(model.camshaft.torque).max())
    off = np.abs(model.camshaft.at(theta) - wanted_torque)
    if len(theta) and np.quantile(off, 0.98) > 1e-6 * max(scale, 1e-300):
        raise Failure(f"the torque of all followers is {off.max():g} N mm off, of {scale:g}")


def _verify_interference(model: Model, data: dict[str, Any], judges: list[Any]) -> None:
    """Where the roller is said to stand in the body the oracle must see as much."""
    found = min(model.clearances, key=lambda c: c.value)
    if found.where.endswith("the roller's edge"):
        depth = min(_edge_in_root({**data, **one}) for one in ({}, *data.get("track", ())))
    else:
        depth = min(float(judge.least(np.array([found.point]))[0]) for judge in judges)
    if found.value < 0.0 and depth > 0.999 * found.value + model.tolerance:
        raise Failure(f"an interference of {found.value:g} mm is reported where the oracle sees {depth:g} mm")


def _edge_in_root(data: dict[str, Any]) -> float:
    """Distance of the sharp end of a roller, mm, from the fillet at the foot of its wall, by that circle."""
    root = data["cam"].get("root_radius", 0.0)
    over = data["cam"].get("groove_depth", inf) - data["roller"]["length"]
    return root - hypot(root, root - over) if over < root else inf


def _surface(
    mesh: Any, oracle: Any, tolerances: tuple[float, float], rng: np.random.Generator
) -> tuple[float, float]:
    """Largest distance of sampled points from both blank and follower, and deepest place inside the follower: over the
    tolerance of the faces they are on, flanks or others."""
    names = np.array(mesh.groups)[mesh.group if mesh.group is not None else np.zeros(len(mesh.faces), int)]
    area = mesh.face_areas
    cut = np.isin(names, ("flank", "edge", "root", "floor"))
    chosen = []
    for mask, count in ((cut, SAMPLES), (~cut, SAMPLES // 2)):
        if mask.any():
            share = np.where(mask, 0.5 * area / area[mask].sum() + 0.5 / mask.sum(), 0.0)
            chosen.append(rng.choice(len(area), count, p=share / share.sum()))
    faces = np.concatenate(chosen)
    weights = rng.dirichlet(np.ones(3), len(faces))
    x = np.einsum("fk,fkx->fx", weights, mesh.vertices[mesh.faces[faces]])
    depth = oracle.least(x)
    # Beyond the follower's own end a deeper tool may leave more: what it would cut there is in nobody's way.
    touch = np.maximum(oracle.least(x, loose=True), 0.0) if oracle.loose else np.abs(depth)
    off = np.minimum(touch, oracle.blank(x))
    off[np.isin(names[faces], oracle.floors)] = 0.0
    strict = names[faces] == "flank"
    if tolerances[1] > tolerances[0] and strict.any():
        # Beside a free face a flank ends at a chord of its edge, which runs aside of that within the flank's surface.
        strict[strict] = rim_distance(mesh, names == "flank", x[strict]) > tolerances[1]
    allowed = np.where(strict, *tolerances)
    return float((off / allowed).max()), float(max(0.0, -(depth / allowed).min()))


def rim_distance(mesh: Any, inside: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Distance (n,) of points (n, 3) from the edges between the faces `inside` (f,) and all others, mm."""
    own, rest = (np.sort(mesh.faces[on][:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)) for on in (inside, ~inside))
    count = np.int64(len(mesh.vertices))
    keys = np.intersect1d(*(pairs[:, 0] * count + pairs[:, 1] for pairs in (own, rest)))
    found = np.full(len(x), np.inf)
    for block in np.array_split(keys, max(1, len(keys) // 4000)):
        start, stop = mesh.vertices[block // count], mesh.vertices[block % count]
        way, to = stop - start, x[:, None] - start
        share = np.clip((to * way).sum(axis=2) / np.maximum((way * way).sum(axis=1), 1e-300), 0.0, 1.0)
        away = to - share[:, :, None] * way
        found = np.minimum(found, np.sqrt((away * away).sum(axis=2)).min(axis=1, initial=np.inf))
    return found


def topology(mesh: Any) -> tuple[bool, int, int]:
    """Closed and oriented, genus summed over the pieces, number of pieces: from the faces alone."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    f = np.asarray(mesh.faces, dtype=np.int64)
    edges = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
    n = int(f.max()) + 1
    key, back = edges[:, 0] * n + edges[:, 1], edges[:, 1] * n + edges[:, 0]
    closed = len(np.unique(key)) == len(key) and bool(np.array_equal(np.sort(key), np.sort(back)))
    used = np.unique(f)
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    pieces = len(np.unique(label[used]))
    euler = len(used) - len(edges) // 2 + len(f)
    return closed, pieces - euler // 2, pieces


def volume(mesh: Any) -> float:
    """Signed volume from the faces, mm³."""
    a, b, c = (mesh.vertices[mesh.faces[:, k]] - mesh.vertices[0] for k in range(3))
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0)


def _verify_refusal(model: Model, why: str, data: dict[str, Any]) -> None:
    """Raise Failure where a refused body could have been made, as far as an oracle can tell."""
    if "velocity jumps" in why:
        _verify_jump(model)
    elif "is undercut" in why:
        _verify_undercut(model, data)
    elif "profile folds" in why:
        _verify_fold(model)
    elif "moves along its own axis" in why:
        _verify_dive(model, why)


def _verify_jump(model: Model) -> None:
    if not any(_jumps(one.setup.program) for one in model.grooves):
        raise Failure("no jump of velocity is seen in the lift itself")


def _jumps(program: Any) -> bool:
    knots = np.concatenate([[0.0], [span.end for span in program.spans]])
    h = 1e-6
    slopes = [(program.jet(knots + s * h, 0)[0] - program.jet(knots, 0)[0]) / (s * h) for s in (1.0, -1.0)]
    return bool(np.abs(slopes[0] - slopes[1]).max() > 1e-4 * max(1e-300, np.abs(program.jet(knots, 0)[0]).max()))


def _verify_undercut(model: Model, data: dict[str, Any]) -> None:
    """Where the margin is negative the roller must cut into its own flank beside the worst place."""
    from camgeom.track.flank import Flank
    from camgeom.track.survey import FLANKS

    survey = min((s for one in model.grooves for s in one.flanks), key=lambda s: s.margin.value)
    at = survey.margin
    if at.value > -1e-3:
        return
    # At the roller's very end a neighbouring position may pass the point with its end, and where the wall begins there
    # is nothing beyond: a little to either side too.
    deltas = np.concatenate([at.place + (end - at.place) * np.array([0.0, 0.02, 0.1, 0.3])
                             for end in survey.cutter.contact])  # fmt: skip
    t = np.array([survey.cutter.meridian.parameter(float(d)) for d in deltas])
    x = Flank(survey.cutter, np.array([at.cam_angle]), t, FLANKS[at.where]).points[0]
    judges = _judges(model, data)
    depth = min(float(judge.least(x, loose=bool(judge.loose)).min()) for judge in judges)
    if depth >= -1e-13 * float(np.abs(x).max()):
        raise Failure(f"undercut margin {at.value:g}, but no roller position cuts into the flank there ({depth:g})")


def _verify_fold(model: Model) -> None:
    """The flat face's normals must turn back along the profile: second differences of the support."""
    assert model.planar is not None
    worst = model.planar.face_radius
    touch = next(t for t in model.planar.touches if worst is not None and t.name == worst.where)
    assert worst is not None
    for near in (0.0, -1e-5, 1e-5):  # a knot of the motion may be there
        curve = touch.at(worst.cam_angle + near + np.array([-4e-6, 4e-6])).curve
        step, left = np.diff(curve.points, axis=1)[:, 0], np.array([-curve.normals[1, 0], curve.normals[0, 0]])
        turn = float(curve.normals[:, 1] @ left)
        if float(step @ left) * np.sign(turn) <= 0.0:
            return
    if worst.value < -1e-6 * float(np.abs(curve.points).max()):
        raise Failure("the profile does not travel backwards where it is said to fold")


def _verify_dive(model: Model, why: str) -> None:
    """At some station all points round the roller must move the same way, in or out, by central differences."""
    angle = np.radians(float(re.search(r"cam angle (-?[\d.e+-]+) deg", why)[1]))  # type: ignore[index]
    tracks = [track for one in model.grooves for track in (*one.tracks, *one.cutters)]
    if any(_dives(track, angle) for track in tracks if repr(track.name) in why):
        return
    raise Failure(f"a contact line is there at every station, yet: {why}")


def _dives(track: Any, angle: float) -> bool:
    h = 1e-5
    a0, u0, a1, u1 = (getattr(track.pose(np.array([angle + s * h]), 0), k)[0][:, 0] for s in (-1, 1) for k in "au")
    u, da, du = 0.5 * (u0 + u1), (a1 - a0) / (2 * h), (u1 - u0) / (2 * h)
    u /= np.linalg.norm(u)
    side = np.cross(u, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    chi = np.linspace(0.0, 2.0 * np.pi, 721)
    m = side[:, None] * np.cos(chi) + np.cross(u, side)[:, None] * np.sin(chi)
    ends = [track.meridian.parameter(d) for d in (track.tip, *track.contact, 0.0, 2.0 * max(track.contact))]
    for t in np.linspace(min(ends), max(ends), 201):
        delta, dt, _, r, rt, _ = (float(x[0]) for x in track.meridian.jet(np.array([t])))
        normal = dt * m - rt * u[:, None]
        speed = ((da + delta * du)[:, None] + r * (np.zeros_like(m) - (m * du[:, None]).sum(0) * u[:, None])) * normal
        total = speed.sum(axis=0)
        if total.min() * total.max() >= -1e-6 * np.abs(total).max() ** 2:
            return True
    return False

