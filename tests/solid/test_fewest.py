"""Bodies of drums with the fewest triangles: as exact as the structured grid, with half the triangles."""

from __future__ import annotations

import json
import sys
import tomllib
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from scipy.optimize import least_squares

from camgeom.cli import main
from camgeom.errors import DesignError, NotConverged, ProfileError
from camgeom.maths.banded import Band, banded
from camgeom.maths.banded.facets import sags
from camgeom.model import Model, read
from camgeom.profile import from_data, parse
from camgeom.report.files import _coloured
from camgeom.solid.fewest import fewest, round_body, turret_grooves
from camgeom.solid.lands import NotOneSurface
from camgeom.solid.round import land
from camgeom.track.follower import ConeRoller
from tests.oracle.cams import judges_of
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points
from tests.places import PROFILES, ROOT
from tests.reference.machines import pin_cam, pin_setup, swinging_cam, swinging_setup

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

import designs
from judging import frozen

SHARES = {
    "pin_insertion": 0.53, "steep_shuttle": 0.56, "end_face_lifter": 0.68, "two_groove_drum": 0.53,
    "bell_lifter": 0.58, "tool_changer": 0.63,
    "two_start": 0.66, "conical_indexer": 0.75, "barrel_indexer": 0.76,
}  # fmt: skip
"""most triangles as a share of the structured grid's"""


def directed(faces, count):
    """Numbers of the directed edges of faces, and of the same edges the other way."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    return edges[:, 0] * count + edges[:, 1], edges[:, 1] * count + edges[:, 0]


@pytest.mark.parametrize("name", SHARES)
def test_the_same_body_with_fewer_triangles(name):
    model = read(str(PROFILES / f"{name}.toml"))
    (part,) = model.parts
    many, few = part.solid(model.tolerance), fewest(part, model.tolerance)
    assert len(few.mesh.faces) < SHARES[name] * len(many.mesh.faces)
    assert few.sound
    assert few.chord_error <= model.tolerance
    assert set(few.mesh.groups) == set(many.mesh.groups)
    key, back = directed(few.mesh.faces, len(few.mesh.vertices))
    assert len(np.unique(key)) == len(key)
    assert np.array_equal(np.sort(key), np.sort(back))
    assert few.mesh.volume == pytest.approx(many.mesh.volume, rel=1e-4)
    again = fewest(part, model.tolerance)
    assert np.array_equal(again.mesh.vertices, few.mesh.vertices)
    assert np.array_equal(again.mesh.faces, few.mesh.faces)


def judged(name, tolerance):
    """The oracle of a profile with one body, and that body's mesh."""
    path = PROFILES / f"{name}.toml"
    model = read(str(path))
    program = model.setup.program
    ends = np.array([span.end for span in program.spans])
    low, high = (float(end.value) for end in program.extremes(0))
    (oracle,) = judges_of(tomllib.loads(path.read_text()), lambda phi: program.jet(phi, 0)[0], low, high, ends)
    return oracle, fewest(model.parts[0], tolerance).mesh


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("pin_insertion", 2e-2), ("pin_insertion", 1e-3), ("tool_changer", 2e-2), ("two_start", 5e-3)],
)
def test_the_oracle_finds_no_facet_beyond_the_tolerance(name, tolerance):
    """By the follower placed from the keys, at random points of random facets; near the tolerance somewhere."""
    oracle, mesh = judged(name, tolerance)
    rng = np.random.default_rng(2)
    names = np.array(mesh.groups)[mesh.group]
    faces = rng.choice(np.flatnonzero(np.isin(names, ("flank", "edge"))), 400)
    x = np.einsum("fk,fkx->fx", rng.dirichlet(np.ones(3), 400), mesh.vertices[mesh.faces[faces]])
    # Beyond the roller's own end the tool leaves more.
    touch = np.maximum(oracle.least(x, loose=True), -oracle.least(x)) if oracle.loose else np.abs(oracle.least(x))
    off = np.minimum(touch, oracle.blank(x))
    assert 0.6 * tolerance < off.max() <= tolerance


def test_every_facet_at_the_flanks_foot_is_within_the_tolerance():
    """Thin facets, beside which the surface runs aside, where a rim begins: along its normals it is far nearer."""
    setup = swinging_setup(ConeRoller(shape="cone", diameter=20.0, length=10.0, half_angle=9.0))
    mechanism = swinging_cam(groove_depth=11.0).mechanism(setup)
    (track,) = mechanism.cutters
    tolerance, program = 0.01, setup.program
    mesh = fewest(mechanism.parts[0], tolerance).mesh

    def pose(phi):
        psi = np.radians(-12.0) + program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
        y, z = track.joint.centre[1] - 90.0 * np.cos(psi), 26.0 - 90.0 * (np.sin(np.radians(-12.0)) - np.sin(psi))
        a = np.stack([y * np.sin(phi), y * np.cos(phi), z], -1)
        return a, np.stack([np.cos(phi), -np.sin(phi), np.zeros_like(z)], -1)

    def distance(x, a, u):
        cone = track.meridian
        return roller_distance(x, a, u, cone.radius, track.tip, shape=("straight", cone.slope, cone.centre))

    faces = mesh.faces[mesh.group_faces("edge")]
    side = np.diff(mesh.vertices[faces[:, [0, 1, 2, 0]]], axis=1)
    area = np.linalg.norm(np.cross(side[:, 0], side[:, 1]), axis=1)
    thin = faces[area < 0.06 * (side * side).sum(axis=2).max(axis=1)]
    off = swept_distance(triangle_points(mesh.vertices, thin, 4), pose, distance, 0.0, 2.0 * np.pi, coarse=360)
    assert len(thin) > 100
    assert 0.5 * tolerance < np.abs(off).max() <= tolerance


THIN = {
    "corners": [[45.686511, 29.922922, 76.349847], [46.848692, 28.24979, 72.663316], [46.336311, 29.067969, 74.624022]],
    "middles": [[46.287115, 29.077128, 74.513484], [46.595078, 28.659111, 73.647656], [46.023736, 29.484467, 75.48266]],
}
"""a facet of the pin cam's rim beside which the surface runs aside by a fifth of its height"""


@pytest.mark.parametrize(("share", "split"), [(1.002, False), (0.999, True)])
def test_a_facet_beside_which_the_surface_runs_aside_is_held_to_what_is_nearest(share, split):
    """Along its own normal it is 4 % nearer than the nearest point of its patch, found here by a general search."""
    corners, middles = (np.array(THIN[key]) for key in ("corners", "middles"))
    a, b, c = corners
    bend = 4.0 * (middles - 0.5 * (corners + corners[[1, 2, 0]]))

    def away(place):
        s, t = place
        r = 1.0 - s - t
        x = r * a + s * b + t * c + r * s * bend[0] + s * t * bend[1] + t * r * bend[2]
        return x - 0.5 * (a + b)

    nearest = float(np.linalg.norm(least_squares(away, (0.5, 0.0), xtol=1e-14, ftol=1e-14, gtol=1e-14).fun))
    sag, mark = sags(corners.T, np.array([[0, 1, 2]]), middles.T[:, :, None], np.array([share * nearest]))
    assert sag[0] == pytest.approx(nearest, rel=1e-6)
    assert mark[:, 0].tolist() == [split, False, False]


RIMS = [("pin_insertion", 3e-3), ("milled_drum", 1e-2), ("conical_guide", 3e-3), ("steep_shuttle", 4e-3)]


@pytest.mark.parametrize(("name", "tolerance"), RIMS)
def test_every_thin_facet_of_a_rim_by_the_oracle(name, tolerance):
    """Where a rim begins four facets of strips once were off by 1.028 times the tolerance, four of cells by 1.064;
    beside two of the rounded root, off by 1.004 times, and of a rim in steep motion a quadratic patch did not tell."""
    judge, mesh = judged(name, tolerance)
    faces = mesh.faces[np.concatenate([mesh.group_faces(one) for one in ("edge", "root") if one in mesh.groups])]
    side = np.diff(mesh.vertices[faces[:, [0, 1, 2, 0]]], axis=1)
    area = np.linalg.norm(np.cross(side[:, 0], side[:, 1]), axis=1)
    thin = faces[area < 0.06 * (side * side).sum(axis=2).max(axis=1)]
    x = triangle_points(mesh.vertices, thin, 4)
    touch = np.maximum(judge.least(x, loose=True), -judge.least(x)) if judge.loose else np.abs(judge.least(x))
    off = np.minimum(touch, judge.blank(x))
    assert len(thin) > 300
    assert 0.8 * tolerance < off.max() <= tolerance


def asked(name, value="true"):
    """The text of a profile with the key."""
    return (PROFILES / f"{name}.toml").read_text().replace("[output]\n", f"[output]\nfewest_triangles = {value}\n")


def test_bodies_have_the_fewest_triangles_unless_the_key_says_no():
    unasked, model, plain = (
        read(str(PROFILES / "end_face_lifter.toml")),
        *(Model(parse(asked("end_face_lifter", value))) for value in ("true", "false")),
    )
    assert len(model.solid.mesh.faces) < 0.8 * len(plain.solid.mesh.faces)
    assert model.solid.chord_error <= model.tolerance
    assert np.array_equal(unasked.solid.mesh.faces, model.solid.mesh.faces)
    assert plain.body.gridded is plain.solids
    assert np.array_equal(unasked.body.gridded[0].mesh.vertices, plain.solid.mesh.vertices)


def test_a_drum_whose_groove_runs_out_refuses_the_key():
    with pytest.raises(ProfileError, match="fewest_triangles"):
        parse(asked("feeder_runout"))
    plain = Model(parse(asked("feeder_runout", "false")))
    assert np.array_equal(read(str(PROFILES / "feeder_runout.toml")).solid.mesh.faces, plain.solid.mesh.faces)


@pytest.mark.parametrize("fault", [NotOneSurface("two grooves touch"), NotConverged("a row a thousandth as long")])
def test_what_cannot_be_made_so_is_made_regularly_and_refused_where_it_is_asked_for(fault, monkeypatch):
    def failing(*_):
        raise fault

    monkeypatch.setattr("camgeom.solid.fewest.fewest", failing)
    plain = Model(parse(asked("end_face_lifter", "false"))).solid.mesh
    assert np.array_equal(read(str(PROFILES / "end_face_lifter.toml")).solid.mesh.faces, plain.faces)
    with pytest.raises((DesignError, NotConverged), match=str(fault)):
        _ = Model(parse(asked("end_face_lifter"))).solid


def test_a_body_whose_long_facets_pierce_each_other_is_made_regularly(monkeypatch):
    """Where a rim is a sliver its long facets reach beyond each other's planes by more than both may be off."""
    monkeypatch.setattr(designs, "kind_of", lambda _: "conical")
    data = frozen(designs.design(7_700_018))
    solid = Model(from_data(data, "")).solid
    plain, asked_for = (
        Model(from_data(data | {"output": data["output"] | {"fewest_triangles": value}}, "")) for value in (False, True)
    )
    assert solid.sound
    assert np.array_equal(solid.mesh.faces, plain.solid.mesh.faces)
    with pytest.raises(DesignError, match="crosses itself"):
        _ = asked_for.solid


def test_what_writes_no_body_meshes_the_quicker_way(monkeypatch, capsys):
    """`check` of an indexing cam took up to 60 % longer; a body that is asked for is the one that is written."""
    path, made = str(PROFILES / "end_face_lifter.toml"), []
    monkeypatch.setattr("camgeom.solid.fewest.fewest", lambda part, *more: made.append(part) or fewest(part, *more))
    assert main(["check", path]) == 0
    assert not made
    capsys.readouterr()
    assert main(["run", path, "--only", "solid", "--json"]) == 0
    assert made
    told = json.loads(capsys.readouterr().out)["solid"]
    assert told["triangles"] == len(read(path).solid.mesh.faces)


def test_results_in_colours_stand_on_the_rows_of_the_regular_grid():
    """Between its edges a flank of one row has no vertex: the pressure at its mouth, where no roller is, ran across."""
    model = read(str(PROFILES / "pin_insertion.toml"))
    (body,), (grid,) = _coloured(model), model.body.gridded
    assert np.array_equal(body.mesh.faces, grid.mesh.faces)
    assert len(grid.mesh.faces) > 1.5 * len(model.solid.mesh.faces)


def test_an_indexing_cam_whose_facets_at_the_ends_are_far_off_is_meshed_regularly():
    """Where one facet at an end is far off all others were made as much finer: 60 018 triangles at 3.9 um once."""
    (part,) = read(str(PROFILES / "barrel_indexer.toml")).parts
    with pytest.raises(NotConverged, match=r"off by 2\.\d+ tolerances"):
        part.direct(0.0043, mesher=turret_grooves)
    few, plain = fewest(part, 0.0043), part.solid(0.0043)
    assert np.array_equal(few.mesh.faces, plain.mesh.faces)
    assert len(fewest(part, 0.003).mesh.faces) < 0.65 * len(part.solid(0.003).mesh.faces)


def bowl(sense):
    """A band of a cylinder of radius 10 that swells by the square of the way across, and the one behind it."""

    def at(phi, u):
        radius = 10.0 + sense * u * (1.0 - u) + 0.3 * np.cos(3.0 * phi)[:, None]
        return np.stack([radius * np.cos(phi)[:, None], radius * np.sin(phi)[:, None], 0.0 * phi[:, None] + 4.0 * u])

    return at


def shifted(band, phi, u):
    x = band.at(phi, u).copy()
    x[2] += 4.0
    return x


@pytest.mark.parametrize("sense", [1.0, -1.0, 0.0])
def test_facets_of_bands_against_their_surface_everywhere(sense):
    tolerance, knots = 2e-3, np.array([0.0, 2.0, 2.0 * np.pi])
    lower = Band("lower", bowl(sense), tolerance)
    upper = replace(lower, name="upper", at=partial(shifted, lower))
    surface = banded([lower, replace(upper, even=True)], knots)
    key, back = directed(surface.faces, surface.points.shape[1])
    assert len(np.unique(key)) == len(key)
    assert len(np.setdiff1d(key, back)) == len(surface.edges[0]) + len(surface.edges[-1])
    rng = np.random.default_rng(1)
    x = np.einsum("fk,xfk->xf", rng.dirichlet(np.ones(3), len(surface.faces)), surface.points[:, surface.faces])
    phi = np.arctan2(x[1], x[0]) % (2.0 * np.pi)
    u = np.where(surface.band == 0, x[2] / 4.0, x[2] / 4.0 - 1.0)
    radius = 10.0 + sense * u * (1.0 - u) + 0.3 * np.cos(3.0 * phi)
    # Square to the axis the distance is no less than square to the surface.
    assert np.abs(np.hypot(x[0], x[1]) - radius).max() <= 1.05 * tolerance
    assert 0.5 * tolerance < surface.chord_error <= tolerance


def test_a_tolerance_that_takes_too_many_rows_is_refused():
    with pytest.raises(NotConverged, match=r"rows|vertices"):
        banded([Band("lower", bowl(1.0), 1e-9)], np.array([0.0, 2.0 * np.pi]))


def test_a_foot_without_width_is_one_line_of_vertices():
    """In the dwells of the pin cam the edge of the roller's end sweeps nothing."""
    (part,) = pin_cam().mechanism(pin_setup()).parts
    (run,) = round_body(part, 5e-3).runs
    assert [band.name for band in run.bands] == ["flank", "edge", "edge", "floor", "edge", "edge", "flank"]
    surface = banded(run.bands, run.knots)
    assert len(surface.points.T) == len(np.unique(surface.points.T, axis=0))
    assert set(surface.edges[1].tolist()) & set(surface.edges[2].tolist())


@pytest.mark.parametrize("clockwise", [False, True])
def test_a_land_takes_one_triangle_a_link_and_says_how_far_it_is_off(clockwise):
    """From a cone's end ring to a wavy edge of other steps, which begins at another azimuth."""
    rng, sense = np.random.default_rng(3), -1.0 if clockwise else 1.0
    low, high = (np.sort(rng.random(n)) * 2.0 * np.pi + start for n, start in ((40, 0.3), (71, 2.0)))

    def edge(angle, z):
        radius = 30.0 - 0.2 * z
        return np.stack([radius * np.cos(sense * angle), radius * np.sin(sense * angle), z])

    below, above = edge(low, np.zeros(len(low))), edge(high, 8.0 + 6.0 * np.cos(2.0 * high))
    corner, sag = land(below, above, clockwise)
    assert len(corner) == len(low) + len(high)
    key, back = directed(corner, len(low) + len(high))
    assert len(np.unique(key)) == len(key)
    assert len(np.setdiff1d(key, back)) == len(low) + len(high)
    points = np.concatenate([below, above], axis=1)[:, corner]
    normal = np.cross(points[:, :, 1] - points[:, :, 0], points[:, :, 2] - points[:, :, 0], axis=0)
    assert np.all(sense * (normal * points[:, :, 0])[:2].sum(axis=0) > 0.0)
    share = rng.dirichlet(np.ones(3), 4000)
    share[:2000, 2], share[:2000, :2] = 0.0, 0.5
    x = np.einsum("sk,xfk->xfs", share, points).reshape(3, -1)
    off = 30.0 - 0.2 * x[2] - np.hypot(x[0], x[1])
    assert 0.9 * sag < off.max() <= sag
    assert off.min() > -1e-12


def test_grooves_of_one_drum_have_the_steps_of_their_own_motions():
    """Each is meshed as if it were alone, whatever the others do; of the land between nothing is added."""
    model = read(str(PROFILES / "two_groove_drum.toml"))
    (part,) = model.parts
    runs = round_body(part, model.tolerance).runs
    assert [len(run.knots) for run in runs] == [10, 6]
    alone = [run.knots.tolist() for own in part.ordered for run in round_body(own, model.tolerance).runs]
    assert [run.knots.tolist() for run in runs] == alone
    mesh = fewest(part, model.tolerance).mesh
    lands = mesh.faces[mesh.group_faces("land")]
    others = np.delete(mesh.faces, mesh.group_faces("land"), axis=0)
    assert np.isin(lands, others).all()


def test_rows_stand_where_a_band_bends_most():
    """A band that is nearly straight at one edge and bent at the other; evenly spaced rows are all as near as there."""

    def at(phi, u):
        radius = 10.0 + u**4 + 0.3 * np.cos(3.0 * phi)[:, None]
        return np.stack([radius * np.cos(phi)[:, None], radius * np.sin(phi)[:, None], 4.0 * u + 0.0 * radius])

    band, knots = Band("bent", at, 2e-3), np.array([0.0, 2.0, 2.0 * np.pi])
    made = banded([band], knots)
    u = made.points[2][made.edge_of < 0] / 4.0
    assert np.count_nonzero(u > 0.5) > 1.3 * np.count_nonzero(u < 0.5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("camgeom.maths.banded.plan.SPARSE", 1.0)
        patch.setattr("camgeom.maths.banded.plan.DENSE", 1.0)
        evenly = banded([band], knots)
    assert len(made.faces) < 0.9 * len(evenly.faces)
    assert made.chord_error <= 2e-3
