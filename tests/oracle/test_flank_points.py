"""Exported flank points lie on what is left of the cam, measured against the roller or face that made it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.export.points import flank_points, write_cmm_csv
from camgeom.inspection import inspect
from camgeom.inspection.points import read_points
from camgeom.maths import Floats
from camgeom.model import Model
from camgeom.model.surfaces import flank_surfaces
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track import Arc, Straight, Track
from tests.oracle.cams import Judge, judges_of
from tests.oracle.envelope import roller_distance, swept_distance
from tests.places import PROFILES
from tests.reference.profiles import built

CLOSE = 1e-9
"""mm"""


def profile(name: str, **cam: float) -> Model:
    data = load((PROFILES / f"{name}.toml").read_text(), name)[0]
    data["cam"] = {**data["cam"], **cam}
    return Model(from_data(data, name))


def from_roller(track: Track, x: Floats) -> Floats:
    """Least distance of points (n, 3) from a cylinder, cone or crowned roller over its whole motion, mm."""
    meridian = track.meridian
    assert isinstance(meridian, Straight | Arc)

    def pose(phi: Floats) -> tuple[Floats, Floats]:
        jets = track.pose(phi.ravel(), 0)
        a, u = (jet[0].T.reshape(*phi.shape, 3) for jet in (jets.a, jets.u))
        return a, u

    straight = isinstance(meridian, Straight)
    shape = ("cone", meridian.slope, meridian.centre) if straight else ("crowned", meridian.arc, meridian.centre)

    def distance(at: Floats, a: Floats, u: Floats) -> Floats:
        return roller_distance(at, a, u, meridian.radius, track.tip, track.tip_sign > 0.0, shape)

    return swept_distance(x, pose, distance, *track.span)


ROLLED = {
    "pin_insertion": {"running_clearance": 0.02},
    "steep_shuttle": {},
    "feeder_runout": {},
    "two_start": {},
    "conical_indexer": {},
    "tool_changer": {"relief": 0},
    "barrel_indexer": {"running_clearance": 0.015},
}


@pytest.mark.parametrize("name", ROLLED)
def test_points_of_drums_and_globoids_are_on_the_flank_and_in_the_blank(name: str) -> None:
    """Every point is a running clearance from the roller that passes nearest, and no tool comes below any point."""
    model = profile(name, **ROLLED[name])
    cloud, mechanism = flank_points(model), model.mechanism
    pick = np.random.default_rng(7).choice(len(cloud["points"]), 250, replace=False)
    x, number = cloud["points"][pick], cloud["track"][pick]
    tools = [from_roller(cutter, x) for cutter in model.cutters]
    least = np.min(tools, axis=0)
    assert np.abs(least).max() < CLOSE
    for i, tool in enumerate(tools):
        assert np.abs(tool[number == i]).max(initial=0.0) < CLOSE, "each on its own track's flank"
    if name == "pin_insertion":
        assert from_roller(model.tracks[0], x) == pytest.approx(0.02, abs=CLOSE)
    low, high = (-0.5 * mechanism.width, 0.5 * mechanism.width) if mechanism.turret else (0.0, mechanism.width)
    assert low - CLOSE <= cloud["points"][:, 2].min() <= cloud["points"][:, 2].max() <= high + CLOSE
    assert np.all(mechanism.within(cloud["points"].T) >= 0.0)
    if mechanism.drum is not None:
        assert np.hypot(*cloud["points"][:, :2].T).max() <= mechanism.drum.radius + CLOSE
    assert np.linalg.norm(cloud["normals"], axis=1) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("name", "cam"),
    [("disc_face_groove", {"running_clearance": 0.03}), ("conjugate_rocker", {}), ("disc_offset_roller", {})],
)
def test_points_of_discs_stand_a_clearance_from_their_rollers(name: str, cam: dict[str, float]) -> None:
    model = profile(name, **cam)
    cloud = flank_points(model)
    for number, track in enumerate(track.straightened() for track in model.tracks):
        mine = cloud["points"][cloud["track"] == number]
        x = mine[np.random.default_rng(7).choice(len(mine), 250, replace=False)]
        flat = np.column_stack([x[:, :2], np.full(len(x), 0.5 * sum(track.contact))])
        assert from_roller(track, flat) == pytest.approx(cam.get("running_clearance", 0.0), abs=CLOSE)
    heights = cloud["points"][:, 2]
    stack = [part.z0 for part in model.parts] + [part.z1 for part in model.parts]  # type: ignore[attr-defined]
    assert min(stack) - CLOSE <= heights.min() <= heights.max() <= max(stack) + CLOSE
    if name == "disc_face_groove":
        assert heights.min() >= model.parts[0].grooves[0].floor - CLOSE  # type: ignore[attr-defined]


@pytest.mark.parametrize("name", ["disc_flat_face", "constant_width_press"])
def test_points_under_flat_faces_touch_the_face_and_are_never_cut_by_it(name: str) -> None:
    """The face stands at base_radius + s along the machine's X; the cam turns below it."""
    model = profile(name)
    cloud, base = flank_points(model), model.mechanism.base_radius
    x = cloud["points"][np.random.default_rng(7).choice(len(cloud["points"]), 200, replace=False)]
    phi = np.radians(cloud["cam_angle_deg"])
    way = model.mechanism.sense

    def beyond(x: Floats, phi: Floats) -> Floats:
        return x[..., 0] * np.cos(phi) - way * x[..., 1] * np.sin(phi) - base - model.setup.program.jet(phi, 0)[0]

    assert np.abs(beyond(cloud["points"], phi)).max() < CLOSE
    turn = np.linspace(0.0, 2.0 * np.pi, 7201)
    assert max(float(beyond(point[None], turn).max()) for point in x) < CLOSE
    assert cloud["normals"] == pytest.approx(
        np.column_stack([np.cos(phi), -way * np.sin(phi), 0.0 * phi]), abs=1e-12
    )
    assert 0.0 <= cloud["points"][:, 2].min() <= cloud["points"][:, 2].max() <= model.mechanism.width


ROLLERS = {
    "cylinder": {"shape": "cylinder"}, "crowned": {"shape": "crowned", "crown_radius": 150.0},
    "cone": {"shape": "cone", "half_angle": 7.0}, "widening": {"shape": "cone", "half_angle": -5.0},
}  # fmt: skip


def moves(stroke: float) -> tuple[dict[str, float | str], ...]:
    return ({"until": 180.0, "to": stroke, "law": "cycloidal"}, {"until": 360.0, "to": 0.0, "law": "cycloidal"})


def plate(upper: str, lower: str, rim: str | None, first: int) -> dict[str, Any]:
    """A disc with grooves in both faces, each as deep as its roller is long, and a profile or a circle as its rim.

    first  number of the track that stands before the others in the profile
    """
    own: dict[str, Any] = {"form": "groove", "rim": "profile" if rim else "circle"}
    tracks: list[dict[str, Any]] = [
        {"cam": own | {"face": "upper", "base_radius": 52.0, "center_distance": 135.0, "groove_depth": 11.0,
                       "running_clearance": 0.02},
         "follower": {"kind": "swinging", "arm": 115.0}, "roller": {"diameter": 22.0, "length": 11.0} | ROLLERS[upper],
         "motion": moves(8.0)},
        {"cam": own | {"face": "lower", "base_radius": 58.0, "groove_depth": 10.0},
         "follower": {"kind": "translating", "face": "roller", "offset": 6.0},
         "roller": {"diameter": 19.0, "length": 10.0} | ROLLERS[lower], "motion": moves(14.0)},
    ]  # fmt: skip
    outside: dict[str, Any] = {"cam": {"form": "external", "base_radius": 110.0}, "motion": moves(9.0)}
    if rim == "flat":
        tracks.append(outside | {"follower": {"kind": "translating", "face": "flat"}})
    elif rim:
        tracks.append(outside | {"follower": {"kind": "translating", "face": "roller", "offset": 0.0},
                                 "roller": {"diameter": 30.0, "length": 40.0} | ROLLERS[rim]})  # fmt: skip
    head, *others = tracks[first:] + tracks[:first]
    body = {"kind": "disc", "width": 40.0, "bore": 36.0} | ({} if rim else {"diameter": 230.0})
    return head | {"name": "plate", "cam": body | head["cam"], "track": tuple(others), "output": {"tolerance": 0.05}}


def off(made: Model, data: dict[str, Any], x: Floats) -> Floats:
    """Distance of points (n, 3) from the tool of each track, (k, n) mm, over the whole turn, by the oracle."""
    lifts = [lambda phi, program=one.setup.program: program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
             for one in made.grooves]  # fmt: skip
    first, *others = [(lift, 0.0, float(lift(np.array([np.pi]))[0])) for lift in lifts]
    (whole,) = judges_of(data, *first, np.array([np.pi, 2.0 * np.pi]), others)
    each = [Judge(lambda at, phi, k, own=own: whole.distance(at, phi, own + 0 * k), whole.blank, grid=whole.grid)
            for own in range(len(lifts))]  # fmt: skip
    return np.stack([one.least(x) for one in each])


@pytest.mark.parametrize("rim", [None, "flat", "cylinder", "crowned", "widening"])
@pytest.mark.parametrize("lower", ["cylinder", "crowned", "widening"])
@pytest.mark.parametrize("upper", ["cylinder", "crowned", "cone"])
def test_every_track_of_a_plate_has_its_points(
    upper: str, lower: str, rim: str | None, tmp_path: Path
) -> None:
    """Whichever track is the first: over all of its height, on the surface that its own tool leaves and none cuts."""
    heights = [(29.0, 40.0), (0.0, 10.0), (0.0, 40.0)][: 3 if rim else 2]
    for first in range(len(heights)):
        data = plate(upper, lower, rim, first)
        made, path = built(data), tmp_path / f"{first}.cmm.csv"
        cloud, dice = flank_points(made), np.random.default_rng(7)
        for number, ends in enumerate(heights[first:] + heights[:first]):
            x = cloud["points"][cloud["track"] == number]
            assert (x[:, 2].min(), x[:, 2].max()) == pytest.approx(ends, abs=CLOSE)
            away = off(made, data, dice.permutation(x)[:6])
            assert np.abs(away[number]).max() < CLOSE
            assert away.min() > -CLOSE
        write_cmm_csv(path, made, step=20.0)
        measured = read_points(path)
        assert measured.flank is not None
        assert {measured.flank.count(one.name) for one in flank_surfaces(made)} == {18 * 3}
        away = off(made, data, dice.permutation(measured.x.T)[:9])
        assert np.abs(away.min(axis=0)).max() < CLOSE


@pytest.mark.parametrize("first", range(3))
@pytest.mark.parametrize(("upper", "lower"), [("cone", "cylinder"), ("cylinder", "cone"), ("cone", "cone")])
def test_points_of_every_track_of_a_plate_are_inspected(upper: str, lower: str, first: int, tmp_path: Path) -> None:
    made = built(plate(upper, lower, "cylinder", first))
    write_cmm_csv(tmp_path / "plate.cmm.csv", made, step=10.0)
    found = inspect(made, read_points(tmp_path / "plate.cmm.csv"))
    assert len(found.flanks) == 5
    assert all(max(abs(one.largest), abs(one.smallest)) < 1e-7 for one in found.flanks)
    assert found.kept.all()
