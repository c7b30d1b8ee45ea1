"""Discs of conical rollers: the body against a cone placed from the keys, no envelope, and contact by hand."""

from __future__ import annotations

from math import acos, atan2, cos, degrees, hypot, pi, radians, tan
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from camgeom.checks import findings
from camgeom.errors import ProfileError
from camgeom.export.step.bodies import model_bodies
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.mechanics.hertz import line_pressure
from camgeom.mechanics.material import STEEL, pair_compliance
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.report.result import compute
from camgeom.report.sections.design import part_views
from camgeom.track.flank import Flank
from tests.oracle.conical_discs import DATA, centres, drawn, lift


def made(**tables: dict[str, Any]) -> Model:
    return Model(from_data({**DATA, **{name: {**DATA.get(name, {}), **keys} for name, keys in tables.items()}}, "cone"))


@pytest.mark.parametrize("seed", range(24))
def test_no_cone_stands_in_the_body_and_every_vertex_is_touched_by_one(seed: int) -> None:
    data = drawn(seed)
    model = Model(from_data(data, "cone"))
    if not model.solid.sound:
        pytest.fail("no body")
    if (undercut := next(iter(findings(model, ["undercut"])))).level != "pass":
        pytest.skip(f"undercut {undercut.value}")
    mesh, tolerance, width = model.solid.mesh, 0.01, data["cam"]["width"]
    assert model.solid.chord_error <= tolerance
    lean = radians(data["roller"]["half_angle"])
    theta = np.linspace(0.0, 2.0 * pi, 14401)[:-1]
    tree = cKDTree(centres(data, theta).T)

    def gap(x: np.ndarray) -> np.ndarray:
        """Distance of points (n, 3) from the nearest cone: negative inside."""
        radius = 0.5 * data["roller"]["diameter"] + tan(lean) * (x[:, 2] - 0.5 * width)
        return (tree.query(x[:, :2])[0] - radius) * cos(lean)

    # The roller's middle is the disc's: its free end, where a positive angle narrows it, is below.
    flank = mesh.vertices[mesh.group_vertices("flank")]
    # Samples a fortieth of a degree apart miss the nearest pose by up to a micrometre.
    assert np.abs(gap(flank)).max() < 2e-3
    middles = mesh.vertices[mesh.faces].mean(axis=1)
    assert gap(middles).min() > -tolerance - 1e-3


def test_its_step_file_is_the_exact_body() -> None:
    model = made(output={"tolerance": 1e-4})
    solid = model_bodies(model)
    assert isinstance(solid, Brep)
    verdict = check_solid(solid, 1e-5)
    assert verdict.problems == ()
    assert verdict.volume == pytest.approx(model.solid.mesh.volume, rel=2e-6)
    # Straight from end to end: Simpson's rule over three heights is exact but for the profile's own area.
    assert verdict.genus == 1


@pytest.mark.parametrize("half_angle", [12.0, -12.0])
def test_pressure_by_hand(half_angle: float) -> None:
    model = made(roller={"half_angle": half_angle}, follower={"mass": 2.0, "offset": 0.0})
    duty = model.duty
    assert duty is not None
    theta, omega, lean = radians(110.0), 200.0 * pi / 30.0, radians(half_angle)
    h = 1e-5
    s = lift(theta + h * np.array([-2, -1, 0, 1, 2]), 15.0, 60.0, 160.0, 220.0, 320.0)
    slope, bend = (s[3] - s[1]) / (2 * h), (s[0] * -1 + 16 * s[1] - 30 * s[2] + 16 * s[3] - s[4]) / (12 * h * h)
    force = 150.0 + 10.0 * s[2] + 2.0 * bend * 1e-3 * omega**2
    # Of a slide through the axis: the pitch curve is r = 52 + s, its normal leans by atan(s' / r).
    r = 52.0 + s[2]
    angle = atan2(slope, r)
    normal = force / (cos(angle) * cos(lean))
    assert duty.force.panels.at(duty.force.force, np.array([theta]))[0] == pytest.approx(force, rel=1e-5)
    pace = hypot(r, slope)
    pitch = (r * r + 2 * slope * slope - r * bend) / pace**3
    z = 10.0 + np.array([-8.0, 0.0, 8.0])
    radius = 12.0 + tan(lean) * (z - 10.0)
    profile = pitch / (1.0 - radius * pitch)
    relative = cos(lean) * (1.0 / radius + profile)
    # Load per length along the axis, which is above that along the cone's side by 1 / cos of its half angle.
    wanted = line_pressure(np.full(3, normal / 16.0), relative, pair_compliance(STEEL, STEEL))
    (track,) = model.tracks
    flank = Flank(track, np.array([theta]), z, track.sides[0])
    assert flank.k_rel[0] == pytest.approx(relative, rel=1e-6)
    # Slices share by their stiffness, which hangs on the load by a logarithm.
    found = duty.pressure_at(np.array([theta]), z)[0]
    assert found == pytest.approx(wanted, rel=0.03)
    assert np.mean(found**2 / relative) == pytest.approx(np.mean(wanted**2 / relative), rel=0.01)


def test_a_cone_of_no_angle_is_the_cylinder() -> None:
    straight = {key: value for key, value in DATA["roller"].items() if key not in ("half_angle", "shape")}
    cone, cylinder = made(roller={"half_angle": 1e-9}), Model(from_data(DATA | {"roller": straight}, "cylinder"))
    figures = [compute(one, ("contact", "fatigue", "motion")).data for one in (cone, cylinder)]
    for name in ("peak_force_n", "peak_pressure_mpa", "peak_torque_n_m"):
        assert figures[0]["contact"][name] == pytest.approx(figures[1]["contact"][name], rel=1e-6), name


def swung(half_angle: float, **tables: dict[str, Any]) -> dict[str, Any]:
    """A profile with an arm; no half angle: of a cylinder."""
    motion = tuple({**move, "to": 12.0} if move.get("to") else move for move in DATA["motion"])
    roller = DATA["roller"] | {"half_angle": half_angle}
    if half_angle == 0.0:
        roller = {"shape": "cylinder", "diameter": roller["diameter"], "length": roller["length"]}
    follower = {"kind": "swinging", "arm": 70.0, "inertia": 0.01} | tables.get("follower", {})
    cam = DATA["cam"] | {"center_distance": 85.0} | tables.get("cam", {})
    return {"name": "arm", "cam": cam, "follower": follower, "roller": roller, "motion": motion} | {
        name: table for name, table in tables.items() if name not in ("cam", "follower")
    }


@pytest.mark.parametrize("half_angle", [0.0, 1e-6, 10.0, -10.0])
@pytest.mark.parametrize(("side", "direction"), [("left", "ccw"), ("right", "ccw"), ("left", "cw")])
def test_pressure_angle_under_an_arm_is_that_of_the_roller_on_its_pin(
    half_angle: float, side: str, direction: str
) -> None:
    """The arm's end, placed from the keys, moves square to the arm; the contact's force goes through it."""
    data = swung(half_angle, follower={"side": side}, cam={"direction": direction})
    theta = np.linspace(0.0, 2.0 * pi, 36001)[:-1]
    hair = 1e-5
    places = [centres(data, theta + step) for step in (-hair, 0.0, hair)]
    along = places[2] - places[0]
    normal = np.stack([-along[1], along[0]]) / np.hypot(*along)
    sense, pivot = (1.0 if direction == "ccw" else -1.0), 85.0
    arm = places[1] - pivot * np.stack([np.cos(sense * theta), -np.sin(sense * theta)])
    square = np.stack([-arm[1], arm[0]]) / np.hypot(*arm)
    cosine = np.abs((normal * square).sum(axis=0)) * cos(radians(half_angle))
    wanted = degrees(acos(float(cosine.min())))
    model = Model(from_data(data, "arm"))
    (found,) = findings(model, ["pressure-angle"])
    assert found.value == pytest.approx(wanted, abs=1e-4)
    # What the flank is painted with is what is judged.
    (track,) = model.tracks
    painted = Flank(track, theta, np.array([10.0]), track.sides[0]).pressure_angle()
    assert degrees(float(painted.max())) == pytest.approx(wanted, abs=1e-4)
    for share, level in ((0.999, "fail"), (1.001, "pass")):
        limits = {"pressure_angle_deg": share * wanted}
        (judged,) = findings(Model(from_data(data | {"limits": limits}, "arm")), ["pressure-angle"])
        assert judged.level == level


def test_the_lean_is_named_where_without_it_the_pressure_angle_would_pass() -> None:
    def told(limit: float, half_angle: float) -> str:
        limits = {"pressure_angle_deg": limit}
        (found,) = findings(made(roller={"half_angle": half_angle}, limits=limits), ["pressure-angle"])
        assert found.level == "fail"
        return found.advice

    (flat,) = findings(made(roller={"half_angle": 1e-9}), ["pressure-angle"])
    for share, named in ((1.001, True), (0.999, False)):
        assert ("without the cone's lean it is" in told(share * flat.value, -20.0)) == named


def test_the_quoted_place_is_a_height_and_no_radius() -> None:
    flank = compute(made(), ("flank",)).data["flank"]
    assert "pitch_radius_mm" not in flank
    assert "pitch_pressure_angle_deg" not in flank


@pytest.mark.parametrize("half_angle", [10.0, -10.0])
def test_what_lies_behind_its_section_leans_too(half_angle: float) -> None:
    """The ends of either face as far out as that face reaches behind the section, not as the larger one does."""
    model = made(roller={"half_angle": half_angle})
    mesh = model.solid.mesh
    (along, _) = part_views(model, (("cam", mesh),))
    shown = [path.points for path in along.paths if path.kind == "outline"]
    drawn = np.concatenate([*shown, *(loop for region in along.regions for loop in region.loops)])
    behind = mesh.vertices[mesh.vertices[:, 1] >= 0.0]
    for z in (0.0, 20.0):
        wanted = behind[np.abs(behind[:, 2] - z) < 1e-9, 0]
        found = drawn[np.abs(drawn[:, 0] - z) < 1e-9, 1]
        assert (found.min(), found.max()) == pytest.approx((wanted.min(), wanted.max()), abs=0.02), z


def test_ends_of_the_lean_have_two_sides() -> None:
    least = degrees(atan2(24.0, 20.0))
    assert made(roller={"half_angle": 0.999 * least, "length": 10.0}).mechanism
    with pytest.raises(ProfileError, match="comes to its point beside the disc"):
        made(roller={"half_angle": 1.001 * least, "length": 10.0})


def test_undercut_is_asked_where_the_cone_is_thickest_though_no_roller_reaches_there() -> None:
    """The cone's radius at the upper face against the hollow of the pitch curve, both by hand."""
    motion = [{"until": 60.0}, {"until": 120.0, "to": 15.0, "law": "cycloidal"}, *DATA["motion"][2:]]
    model = Model(from_data(DATA | {"motion": tuple(motion), "roller": DATA["roller"] | {"length": 4.0}}, "cone"))
    theta = np.linspace(0.0, 2.0 * pi, 200001)[:-1]
    s = lift(theta, 15.0, 60.0, 120.0, 220.0, 320.0)
    x, y = np.sqrt(52.0**2 - 25.0) + s, np.full_like(s, 5.0)
    points = (x + 1j * y) * np.exp(-1j * theta)
    step = theta[1]
    first = (np.roll(points, -1) - np.roll(points, 1)) / (2.0 * step)
    second = (np.roll(points, -1) - 2.0 * points + np.roll(points, 1)) / step**2
    bend = (np.conj(first) * second).imag / np.abs(first) ** 3
    # Inside a pitch curve the profile folds where that is bent more sharply, convex, than the roller is.
    wanted = 1.0 - (12.0 + tan(radians(10.0)) * 10.0) * float(np.max(bend * np.sign(np.mean(bend))))
    (found,) = findings(model, ["undercut"])
    assert found.value == pytest.approx(wanted, abs=1e-4)
    assert f"{found.where}".endswith("at 20 mm along the roller axis")
