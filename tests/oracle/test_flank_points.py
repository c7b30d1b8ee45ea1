"""Exported flank points lie on what is left of the cam, measured against the roller or face that made it."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.export.points import flank_points
from camgeom.maths import Floats
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track import Arc, Straight, Track
from tests.oracle.envelope import roller_distance, swept_distance
from tests.places import PROFILES

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
