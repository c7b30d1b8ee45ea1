"""Cylindrical indexing cams against the distance to the nearest roller position."""

from __future__ import annotations

import re
from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from tests.oracle.envelope import roller_distance, swept_distance, triangle_points
from tests.reference.indexing_machines import BARREL_SIZES, SHAPES, barrel, dwell_half_angle, indexer

STARTER = starter("cylindrical-index")

TOLERANCE = 0.1


def pose_of(cam, setup, shift):
    """A turret about a line along X through (0, C, 0); rollers along X, seen from a cam turning by +phi about Z."""
    rf, sign = setup.follower.pitch_radius, 1.0 if cam.hand == "right" else -1.0

    def pose(phi):
        tau = setup.program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi)) + shift
        y, z = cam.center_distance - rf * np.cos(tau), sign * rf * np.sin(tau)
        c, s = np.cos(phi), np.sin(phi)
        return np.stack([y * s, y * c, z], -1), np.stack([c, -s, np.zeros_like(c)], -1)

    return pose


CASES = [
    *[(n, form, "right", 1, "cylinder") for n in BARREL_SIZES for form in ("rib", "groove")],
    *[(12, "rib", "left", 1, shape) for shape in SHAPES],
    (12, "groove", "left", 1, "cone"),
    (4, "rib", "right", 2, "cylinder"),
    (8, "groove", "right", 2, "crowned"),
]


@pytest.mark.parametrize(("stops", "form", "hand", "starts", "shape"), CASES)
def test_every_triangle_within_tolerance(stops, form, hand, starts, shape):
    cam, setup = barrel(stops, form, hand, starts, shape)
    assert cam.problems(setup) == []
    (part,) = cam.mechanism(setup).parts
    solid = part.solid(TOLERANCE)
    assert solid.sound, (solid.mesh.components, solid.mesh.genus)
    mesh, rng = solid.mesh, np.random.default_rng(2)
    flank, rest = (np.flatnonzero(m) for m in (mesh.group_faces("flank"), ~mesh.group_faces("flank")))
    picked = np.concatenate([rng.choice(flank, 40), rng.choice(rest, 40)])
    points = triangle_points(mesh.vertices, mesh.faces[picked], 4)
    mechanism = cam.mechanism(setup)
    radius, tip = 0.5 * setup.roller.diameter, mechanism.tip
    slope = -np.tan(np.radians(8.0)) * -1.0
    kind = {"cylinder": None, "cone": ("cone", slope, mechanism.quoted_radius), "sphere": ("sphere", None, 65.0)}
    if shape == "crowned":
        kind["crowned"] = ("crowned", setup.roller.crown_radius, cam.mechanism(setup).quoted_radius)
    wall, body = np.full(len(points), np.inf), np.full(len(points), np.inf)
    for start in range(starts):
        shift = dwell_half_angle(setup, cam.form) + start * 2.0 * pi / setup.follower.count
        low, high = cam.mechanism(setup).cutters[start].span
        for best, end in ((wall, tip - 6.0), (body, tip)):

            def distance(x, a, u, end=end):
                return roller_distance(x, a, u, radius, end, shape=kind[shape])

            coarse = int(150 * (high - low) / (2.0 * pi))
            pose = pose_of(cam, setup, shift)
            np.minimum(best, swept_distance(points, pose, distance, low, high, coarse, 3, 22), out=best)
    assert float(wall[: 4 * 40].max()) <= 1.0001 * solid.chord_error <= 1.0001 * TOLERANCE
    assert float(body.min()) >= -1.0001 * solid.chord_error


def test_starter_passes_its_checks_and_carries_its_load():
    result = compute(Model(parse(STARTER), 0.05), ("checks", "contact", "fatigue"))
    assert [f for f in result.findings if not f.passed] == []
    assert result.data["contact"]["rollers_sharing_least"] >= 1
    assert 10.0 < result.data["contact"]["peak_pressure_mpa"] < 2000.0
    assert result.data["fatigue"]["cam_life_h"] > 0.0


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("width = 76", "width = 230", "so that the rollers swing clear of it"),
        ("diameter = 26", "diameter = 64", "distance of neighbouring rollers"),
        ("center_distance = 118", "center_distance = 40", "stay over the groove floor"),
        ("bore = 40", "bore = 92", "outline inside the groove floor"),
    ],
)
def test_bad_input_is_refused_with_the_allowed_range(old, new, words):
    with pytest.raises(ProfileError) as refused:
        parse(STARTER.replace(old, new))
    assert words in str(refused.value)


@pytest.mark.parametrize("end", ["low", "high"])
def test_rollers_stay_over_the_floor_of_a_barrel(end):
    """A hair inside the stated range of centre distances there is a sound body, a hair outside a refusal."""
    with pytest.raises(ProfileError) as refused:
        parse(STARTER.replace("center_distance = 118", "center_distance = 40"))
    low, high = map(float, re.search(r"([\d.]+) \.\. ([\d.]+) mm", str(refused.value)).groups())
    bound, inward = (low, 1.0) if end == "low" else (high, -1.0)
    narrow = STARTER.replace("bore = 40", "bore = 0")
    good = Model(parse(narrow.replace("center_distance = 118", f"center_distance = {bound + 0.02 * inward}")))
    assert good.cam.mechanism(good.setup).parts[0].solid(0.05).sound
    with pytest.raises(ProfileError, match="stay over the groove floor"):
        parse(narrow.replace("center_distance = 118", f"center_distance = {bound - 0.02 * inward}"))


def test_a_barrel_too_wide_for_its_turret_is_refused():
    wide = STARTER.replace("diameter = 120", "diameter = 76").replace("width = 76", "width = 190")
    with pytest.raises(ProfileError, match="nowhere do the rollers stay over the groove floor"):
        parse(wide)


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", ["globoidal", "cylindrical-index"])
def test_turret_stands_in_its_grooves_without_touching_the_cam(kind, shape):
    """The turret's solid at some cam angles against the cam's: they meet in the chords' slack only."""
    cam, setup = barrel(12, shape=shape) if kind != "globoidal" else indexer(8, shape=shape)
    (part,) = cam.mechanism(setup).parts
    solid = part.solid(0.05)
    standing = cam.mechanism(setup).turret.body
    turret = standing.solid(0.05)
    assert turret.sound
    for angle in (0.0, 2.9, 3.6):
        body = replace(standing, cam_angle=angle).solid(0.05)
        assert body.mesh.volume == pytest.approx(turret.mesh.volume, rel=1e-5)
        common = manifold(body.mesh) ^ manifold(solid.mesh)
        assert common.volume() < 1e-4 * setup.roller.diameter**3


def manifold(mesh):
    import manifold3d

    return manifold3d.Manifold(manifold3d.Mesh64(mesh.vertices, mesh.faces.astype(np.uint64)))
