"""Face grooves and conjugate pairs of conical rollers: bodies by the oracle, limits, scale, mirror, exact faces, forces
by hand, and what is refused by name."""

from __future__ import annotations

import sys
from math import atan2, cos, degrees, pi, radians, tan
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from camgeom.errors import DesignError, ProfileError
from camgeom.export.dxf import plane_views
from camgeom.export.step.bodies import model_bodies
from camgeom.export.step.brep import Assembly, Brep
from camgeom.export.step.check import check_solid
from camgeom.export.step.solids import grooved_plate_solid
from camgeom.model import Model
from camgeom.report.result import compute
from camgeom.track.outline import OutlineIntegrals, ParallelOutline, RollerOutline
from tests.places import ROOT
from tests.reference import profiles
from tests.reference.profiles import said

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from designs import design
from judging import judge

GROOVE, PAIR = "conical_groove", "conical_pair"
SLIDE: dict[str, Any] = {
    "follower": {"kind": "translating", "mass": 2.0, "offset": 6.0}, "cam__center_distance": None,
    "cam__diameter": 250.0, "output": {},
}  # fmt: skip
PAIR_SLIDE: dict[str, Any] = {
    "follower": {"kind": "translating", "mass": 2.0, "offset": 4.0, "clearance": 0.05}, "cam__center_distance": None,
    "cam__rocker_angle": None,
}  # fmt: skip
FORMS = [(GROOVE, {}), (GROOVE, SLIDE), (PAIR, {}), (PAIR, PAIR_SLIDE)]
CYLINDER = {"shape": "cylinder", "diameter": 24.0, "length": 12.0}


def data_of(name: str, **keys: Any) -> dict[str, Any]:
    """A shipped profile's, without the taper that goes with its own cone alone."""
    return profiles.data_of(name, **({"cutter": None} | keys))


def model(name: str, **keys: Any) -> Model:
    """A shipped profile's, without the taper that goes with its own cone alone."""
    return profiles.model(name, **({"cutter": None} | keys))


@pytest.mark.parametrize("first", [200_000, 210_000])
def test_random_ones_lie_where_the_oracle_says(first: int) -> None:
    records = {seed: judge(design(seed), seed) for seed in range(first, first + 12)}
    assert not {seed: one for seed, one in records.items() if one["outcome"] == "FAILURE"}
    errors = [one["error"] for one in records.values() if "error" in one]
    assert len(errors) > 6
    assert max(errors) <= 1.0 + 1e-6


@pytest.mark.parametrize(("name", "keys"), FORMS)
@pytest.mark.parametrize("lean", [1.0, -1.0])
def test_both_ways_of_the_cone_and_of_the_turning_lie_where_the_oracle_says(
    name: str, keys: dict[str, Any], lean: float
) -> None:
    tables = {"roller__half_angle": 11.0 * lean, "output": {"tolerance": 0.02}, "cam__direction": "ccw"}
    if name == PAIR:
        tables["return_roller__half_angle"] = 9.0 * lean
    record = judge(data_of(name, **keys | tables))
    assert record["outcome"] in ("good", "finding"), record
    assert 0.3 < record["error"] <= 1.0 + 1e-6


def figures(one: Model) -> dict[str, float]:
    data = compute(one, ("motion", "flank", "contact", "fatigue", "solid")).data
    wanted = {"flank": ("max_pressure_angle_deg", "undercut_margin"),
              "contact": ("peak_pressure_mpa", "peak_torque_n_m")}  # fmt: skip
    found = {key: float(data[table][key]) for table, keys in wanted.items() for key in keys}
    return found | {"volume": sum(part.solid(2e-4).mesh.volume for part in one.parts)}


@pytest.mark.parametrize(("name", "keys"), FORMS)
def test_a_cone_of_no_angle_is_the_cylinder(name: str, keys: dict[str, Any]) -> None:
    # A clearance moves what presses aside by as much in a straight groove, where its pressure angle is told.
    keys = keys | ({"cam__running_clearance": 0.0} if name == GROOVE else {})
    rollers = ("roller", "return_roller") if name == PAIR else ("roller",)
    flat = {f"{table}__half_angle": None for table in rollers} | {f"{table}__shape": "cylinder" for table in rollers}
    want = figures(model(name, **keys | flat))
    assert figures(model(name, **keys | {f"{table}__half_angle": 1e-9 for table in rollers})) == pytest.approx(
        want, rel=1e-6
    )


def test_figures_scale_with_size_and_a_mirrored_machine_has_the_same() -> None:
    lengths = ("base_radius", "width", "diameter", "groove_depth", "center_distance", "running_clearance", "bore",
               "keyway_width", "keyway_depth")  # fmt: skip
    own = data_of(GROOVE)
    factor = 3.0
    large = {f"cam__{key}": factor * own["cam"][key] for key in lengths}
    large |= {f"roller__{key}": factor * own["roller"][key] for key in ("diameter", "length")}
    other = model(GROOVE, follower__arm=factor * own["follower"]["arm"], output={"tolerance": 0.015}, **large)
    one = model(GROOVE)
    got, want = (compute(each, ("flank", "solid")).data for each in (other, one))
    for key, power in (("max_pressure_angle_deg", 0), ("undercut_margin", 0), ("min_relative_radius_mm", 1)):
        assert got["flank"][key] == pytest.approx(want["flank"][key] * factor**power, rel=1e-9)
    assert got["solid"]["volume_mm3"] == pytest.approx(want["solid"]["volume_mm3"] * factor**3, rel=1e-9)
    turned = model(GROOVE, cam__direction="ccw", follower__side="right")
    assert figures(turned) == pytest.approx(figures(one), rel=1e-9)


def leaning_volume(outline: Any, low: float, high: float) -> float:
    """Simpson's rule over three heights, exact for an area whose outline moves evenly along its normal."""
    ends = [OutlineIntegrals(at).properties.area for at in outline]
    return (high - low) / 6.0 * (ends[0] + 4.0 * ends[1] + ends[2])


def test_the_volume_of_a_groove_is_that_of_its_areas() -> None:
    one = model(GROOVE, cam__bore=0.0, cam__keyway_width=0.0, cam__keyway_depth=0.0)
    cam, roller = one.profile.cam, one.setup.roller
    gap, lean = cam.running_clearance / cos(radians(8.0)), tan(radians(8.0))
    # The roller's middle stands half of its length below the face.
    radii = [12.0 + gap + lean * (z - (24.0 - 6.0)) for z in (10.0, 17.0, 24.0)]
    track = one.tracks[0]
    inner, outer = (leaning_volume([RollerOutline(track, way * r) for r in radii], 10.0, 24.0) for way in (-1.0, 1.0))
    wanted = pi * 120.0**2 * 24.0 - (outer - inner)
    assert roller.half_angle == 8.0
    step = check_solid(model_bodies(one, 1e-7), 1e-5)
    assert step.volume == pytest.approx(wanted, rel=1e-9)
    assert one.parts[0].solid(1e-4).mesh.volume == pytest.approx(wanted, rel=2e-6)


@pytest.mark.parametrize(("name", "keys"), FORMS)
def test_its_step_file_is_the_exact_body(name: str, keys: dict[str, Any]) -> None:
    one = model(name, **keys)
    made = model_bodies(one)
    bodies = [part.body for part in made.parts] if isinstance(made, Assembly) else [made]
    assert len(bodies) == len(one.parts)
    for body, part in zip(bodies, one.parts):
        assert isinstance(body, Brep)
        verdict = check_solid(body, 1e-5)
        assert verdict.problems == ()
        assert verdict.genus == (2 if name == PAIR else 1)
        assert verdict.volume == pytest.approx(part.solid(2e-4).mesh.volume, rel=3e-6)


@pytest.mark.parametrize("half_angle", [9.0, -9.0])
def test_force_and_pressure_angle_in_a_groove_by_hand(half_angle: float) -> None:
    """Of a slide through the axis: the pitch curve's normal leans by atan(s' / r) in the plane, and out of it by the
    cone's half angle."""
    one = model(GROOVE, **SLIDE | {"follower": {"kind": "translating", "mass": 2.0}}, roller__half_angle=half_angle,
                operation__friction=0.0)  # fmt: skip
    theta = np.linspace(0.0, 2.0 * pi, 14401)
    s, ds, dds = one.setup.program.jet(theta, 2)
    tangent = ds / (72.0 + s)
    plane = 1.0 / np.sqrt(1.0 + tangent**2)
    lean = cos(radians(half_angle))
    omega = 250.0 * pi / 30.0
    force = np.abs(2.0 * dds * 1e-3 * omega**2) / (plane * lean)
    assert one.duty.peak_force.value == pytest.approx(force.max(), rel=1e-5)
    (angle,) = said(one, "pressure-angle")
    assert angle.value == pytest.approx(degrees(np.arccos((plane * lean).min())), abs=1e-4)


@pytest.mark.parametrize("clearance", [0.0, 0.04])
def test_the_roller_stands_off_both_walls_by_the_clearance(clearance: float) -> None:
    one = model(GROOVE, cam__running_clearance=clearance)
    (inside,), (outside,) = said(one, "interference"), said(one, "backlash")
    assert inside.value == pytest.approx(clearance, abs=2e-6 + one.solid.chord_error * (clearance == 0.0))
    assert outside.value == pytest.approx(clearance, abs=1e-6)
    (play,) = said(one, "play") or (None,)
    assert play is None or play.value == pytest.approx(2.0 * clearance)


def test_walls_are_measured_where_the_groove_is_widest() -> None:
    for half_angle, widest in ((8.0, 24.0), (-8.0, 10.0)):
        one = model(GROOVE, roller__half_angle=half_angle, cam__running_clearance=0.0)
        radius = 12.0 + tan(radians(half_angle)) * (widest - 18.0)
        theta = np.linspace(0.0, 2.0 * pi, 72001)
        away = np.hypot(*one.tracks[0].pose(theta, 0).a[0][:2])
        walls = {wall.name: wall.thickness for wall in one.walls}
        assert walls["outer flank to rim"] == pytest.approx(120.0 - away.max() - radius, abs=1e-5)
        # The keyway's corner stands farther out than the bore: without one the least radius counts.
        bare = model(GROOVE, roller__half_angle=half_angle, cam__running_clearance=0.0, cam__keyway_width=0.0,
                     cam__keyway_depth=0.0)  # fmt: skip
        walls = {wall.name: wall.thickness for wall in bare.walls}
        assert walls["inner flank to bore"] == pytest.approx(away.min() - radius - 15.0, abs=1e-5)


def test_the_plate_has_to_be_larger_than_the_groove_at_its_mouth() -> None:
    reach = 2.0 * model(GROOVE).profile.cam.groove_reach(model(GROOVE).mechanism)
    assert model(GROOVE, cam__diameter=1.001 * reach).mechanism
    with pytest.raises(ProfileError, match=r"cam\.diameter: .* above"):
        model(GROOVE, cam__diameter=0.999 * reach)


@pytest.mark.parametrize(("name", "table", "way", "radius", "length"), [
    (GROOVE, "roller", 1.0, 12.0, 14.0 - 6.0), (GROOVE, "roller", -1.0, 12.0, 6.0),
    (PAIR, "roller", 1.0, 16.0, 9.0), (PAIR, "return_roller", -1.0, 14.0, 9.0),
])  # fmt: skip
def test_ends_of_the_lean_have_two_sides(name: str, table: str, way: float, radius: float, length: float) -> None:
    most = degrees(atan2(radius, length))
    short = {f"{table}__length": 12.0} if name == GROOVE else {f"{table}__length": 6.0}
    key = f"{table}__half_angle"
    if name == GROOVE and way < 0.0:
        # Towards its own end the roller comes to its point by itself.
        with pytest.raises(ProfileError, match="the cone comes to its point"):
            model(name, **{key: 1.001 * way * most})
        return
    keys = {**short, "cam__diameter": 600.0} if name == GROOVE else short
    assert model(name, **{key: 0.999 * way * most}, **keys).mechanism
    with pytest.raises(ProfileError, match="comes to its point"):
        model(name, **{key: 1.001 * way * most}, **keys)


@pytest.mark.parametrize(("name", "keys", "said"), [
    (GROOVE, {"cutter": {"kind": "flat", "diameter": 10.0}}, "along Z it does not lie on a flank that leans"),
    (GROOVE, {"cam__root_radius": 1.0}, "0 for a roller whose flank is not cut by a cylindrical tool"),
    (GROOVE, {"material__cam__bending_limit": 400.0}, "solved in rings"),
    (GROOVE, {"impact": {"turns": 2, "clearance_kind": "normal"}}, "one for the chord and the normal"),
    (GROOVE, {"impact": {"turns": 2, "static_friction": 0.1, "roller_inertia": 1e-5}}, "does not turn in this solver"),
    (PAIR, {"cutter": {"kind": "flat", "diameter": 10.0}}, "along Z it does not lie on a flank that leans"),
    (PAIR, {"impact": {"turns": 2}}, "discs of one profile at all heights"),
])  # fmt: skip
def test_what_it_does_not_take_is_named(name: str, keys: dict[str, Any], said: str) -> None:
    with pytest.raises(ProfileError, match=said):
        model(name, **keys)



def test_a_long_cone_is_kept_off_the_other_disc_where_it_is_thickest() -> None:
    """The least gap in the plane at every height at which roller and disc stand beside each other, by samples."""
    one = model(PAIR, **PAIR_SLIDE, roller__length=40.0, roller__half_angle=-7.0)
    neighbour = one.mechanism.neighbours[0]
    found = neighbour.gap(5.0)
    theta = np.linspace(0.0, 2.0 * pi, 7201)
    main, back = (track.pose(theta, 0).a[0][:2] for track in one.tracks)
    apart = []
    # The main disc's middle is at 9 mm, its roller reaches to 29; the return disc begins at 24, its middle is at 33.
    for z in np.linspace(24.0, 29.0, 21):
        roller = 16.0 + tan(radians(7.0)) * (z - 9.0)
        other = 14.0 + tan(radians(5.0)) * (33.0 - z)
        outline = RollerOutline(one.tracks[1], -other).curve(theta).points
        nearest, _ = cKDTree(outline.T).query(main.T)
        inside = np.hypot(*main) < np.hypot(*outline).min()
        apart.append(float((np.where(inside, -nearest, nearest) - roller).min()))
    assert np.hypot(*back).min() > 0.0
    assert found.value == pytest.approx(max(min(apart), neighbour.along), abs=2e-3)


def test_both_ends_of_every_flank_are_drawn_and_written() -> None:
    (view,) = plane_views(model(GROOVE))
    names = {curve.name for curve in view.curves}
    ends = {f"{flank} flank at z = {z} mm" for flank in ("inner", "outer") for z in (10, 24)}
    assert ends < names
    assert len(view.strokes) == 1  # the bore with its keyway
    (pair,) = plane_views(model(PAIR))
    assert {"main at z = 0 mm", "main at z = 18 mm", "return at z = 24 mm"} < {curve.name for curve in pair.curves}
    one = model(GROOVE).mechanism
    low, high = (one.outlines[f"outer flank at z = {z} mm"] for z in (10, 24))
    wide = ParallelOutline(low, 14.0 * tan(radians(8.0)))
    phi = np.linspace(0.0, 6.28, 50)
    assert np.abs(wide.curve(phi).points - high.curve(phi).points).max() < 1e-11


def test_impacts_in_a_leaning_groove_go_over_to_those_in_a_straight_one() -> None:
    hit = {"impact": {"law": "hertz", "restitution": 0.8, "turns": 2}}
    runs = [max(one.peak_force for one in model(GROOVE, **hit, **keys).impact.impacts)
            for keys in ({"roller__half_angle": 1e-7}, {"roller__half_angle": None, "roller__shape": "cylinder"})]
    assert runs[0] == pytest.approx(runs[1], rel=2e-3)


def test_a_bore_that_meets_the_leaning_flank_leaves_no_body() -> None:
    """It stands within the base circle, which is that of the roller's middle, and beyond the flank at the mouth."""
    one = model(GROOVE, cam__bore=119.0, cam__keyway_width=0.0, cam__keyway_depth=0.0)
    walls = {wall.where: wall for wall in said(one, "wall")}
    assert walls["inner flank to bore"].level == "fail"
    assert walls["inner flank to bore"].value < 0.0
    with pytest.raises(DesignError, match="crosses itself or a hole"):
        one.parts[0].solid(0.01)
    with pytest.raises(DesignError, match="the bore reaches"):
        grooved_plate_solid(one.parts[0])
