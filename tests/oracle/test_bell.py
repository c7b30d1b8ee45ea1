"""Bell cams with a groove in their inside: the drum of the same radii, closed forms, scale, mirror, exact faces, walls,
and what is refused."""

from __future__ import annotations

import sys
import tomllib
from dataclasses import replace
from math import cos, hypot, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

from camgeom.checks import findings
from camgeom.checks import judge as judged
from camgeom.errors import DesignError, ProfileError
from camgeom.export.dxf import plane_views
from camgeom.export.step.bodies import model_bodies
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.export.step.geometry import Cone, Plane, SplineSurface
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.report.pictures import seen_from
from camgeom.report.result import compute
from camgeom.report.sections.bodies import cam_meshes
from camgeom.report.sections.mechanism import fields
from camgeom.solid.blank import Bore
from tests.oracle.bells import ARM, CONE, CROWN, DEPTH, INNER, LENGTH, RADIUS, SWUNG, bell
from tests.oracle.cams import oracle_of
from tests.oracle.judge_volume import _width
from tests.places import PROFILES, ROOT
from tests.reference.profiles import enlarged

sys.path.insert(0, str(ROOT / "scripts" / "stability"))

from designs import design
from judging import judge

BARE = ("undercut", "slice", "least_contact", "contact_length", "half_width", "shear", "film")
"""figures that a drum has of other value, where its roller's outer end stands beyond the land"""


def model(**changes: Any) -> Model:
    return Model(from_data(bell(**changes)))


def drum(**changes: Any) -> Model:
    """The drum in whose groove the roller touches at the same radii; its roller's free end points to the axis."""
    data = bell(**changes)
    cam, roller = data["cam"], dict(data["roller"])
    if "half_angle" in roller:
        roller["half_angle"] *= -1.0
    keys = ("length", "start", "bore", "keyway_width", "keyway_depth", "running_clearance", "direction")
    made = {"kind": "cylindrical", "diameter": cam["inner_diameter"] + 2.0 * roller["length"],
            "groove_depth": roller["length"] + 1.0} | {key: cam[key] for key in keys}  # fmt: skip
    return Model(from_data(data | {"cam": made, "roller": roller}))


def finding(one: Model, name: str, where: str = "") -> Any:
    return next(f for f in findings(one, [name]) if where in f.where)


def figures(one: Model) -> dict[str, float]:
    data = compute(one, ("motion", "flank", "contact", "fatigue")).data
    return {
        f"{table}.{key}": value for table in ("flank", "contact", "fatigue") for key, value in data[table].items()
        if isinstance(value, float) and np.isfinite(value) and not any(word in key for word in BARE)
    }  # fmt: skip


CASES: dict[str, dict[str, Any]] = {
    "cylinder": {},
    "clockwise": {"direction": "cw"},
    "cone": {"roller": CONE},
    "crown": {"roller": CROWN},
    "arm": {"follower": ARM, "motion": SWUNG, "groove_depth": 12.0, "operation": {"gravity": None}},
}


@pytest.mark.parametrize("case", CASES)
def test_figures_are_those_of_the_drum_whose_roller_touches_at_the_same_radii(case: str) -> None:
    one, other = model(**CASES[case]), drum(**CASES[case])
    got, want = figures(one), figures(other)
    assert len(want) > 20
    assert got == pytest.approx(want, rel=1e-9, abs=1e-12)
    # A drum's roller leaves its land where it is steep, this one has a wall along the whole of itself: with one there
    # too, the hardest place is pressed as hard and lasts as long.
    (duty,), (twin,) = one.duties, (replace(each, beside=None) for each in other.duties)
    assert duty.peak_pressure.value == pytest.approx(twin.peak_pressure.value, rel=1e-9)
    assert duty.slice_life.life_h == pytest.approx(twin.slice_life.life_h, rel=1e-9)
    assert duty.slice_cam_life.life_h == pytest.approx(twin.slice_cam_life.life_h, rel=1e-9)
    # The walls are convex and hollow as the drum's are: the same relative curvature at the same radius.
    for side in (1.0, -1.0):
        assert one.flanks[0].flank(side).k_rel == pytest.approx(other.flanks[0].flank(side).k_rel, rel=1e-9)


def test_the_pressure_angle_is_that_of_the_path_at_the_inside() -> None:
    one = model()
    _, slopes = one.setup.program.jet(np.linspace(0.0, 2.0 * pi, 40001), 1)
    for place in (INNER, INNER + 0.5 * LENGTH, INNER + LENGTH):
        found = one.flanks[0].pressure_angle_at(place).value
        assert found == pytest.approx(np.arctan(np.abs(slopes).max() / place), rel=1e-7)
    assert one.pressure_angle is not None
    assert one.pressure_angle.place == pytest.approx(INNER)


@pytest.mark.parametrize("factor", [1e-3, 40.0])
def test_figures_scale_with_size(factor: float) -> None:
    data = {name: table for name, table in bell().items() if name not in ("operation", "lubricant", "material")}
    data = data | {"follower": {"kind": "translating"}, "roller": {"diameter": 2.0 * RADIUS, "length": LENGTH}}

    one, other = Model(from_data(data)), Model(from_data(enlarged(data, factor)))
    got, want = (compute(m, ("flank", "solid")).data for m in (other, one))
    for key, power in (("max_pressure_angle_deg", 0), ("undercut_margin", 0), ("min_relative_radius_mm", 1)):
        assert got["flank"][key] == pytest.approx(want["flank"][key] * factor**power, rel=1e-9)
    assert got["solid"]["volume_mm3"] == pytest.approx(want["solid"]["volume_mm3"] * factor**3, rel=1e-7)
    walls = [{wall.name: wall.thickness for wall in m.walls} for m in (other, one)]
    assert walls[0] == pytest.approx({name: size * factor for name, size in walls[1].items()}, rel=1e-9)


def test_a_clockwise_bell_is_the_mirror_image() -> None:
    meshes = [model(direction=way).solid.mesh for way in ("ccw", "cw")]
    one, other = (mesh.vertices[np.lexsort(np.round(mesh.vertices * [1.0, flip, 1.0], 6).T)] * [1.0, flip, 1.0]
                  for mesh, flip in zip(meshes, (1.0, -1.0)))  # fmt: skip
    assert np.abs(one - other).max() < 1e-9
    # A rise and the return after it have the same largest curvature, so that rounding chooses which angle is told.
    got, want = ({k: v for k, v in figures(model(direction=way)).items() if "_deg" not in k} for way in ("cw", "ccw"))
    assert got == pytest.approx(want, rel=1e-9)


@pytest.mark.parametrize("fewest", [False, True])
@pytest.mark.parametrize("case", CASES)
def test_the_body_lies_where_the_oracle_says(case: str, fewest: bool) -> None:
    data = bell(**CASES[case]) | {"output": {"tolerance": 0.01, "fewest_triangles": fewest}}
    record = judge(data)
    assert record["outcome"] == "good", record
    assert 0.3 < record["error"] <= 1.0


def test_random_designs_are_judged_by_the_oracle() -> None:
    outcomes = {judge(design(seed), seed)["outcome"] for seed in range(190_000, 190_024)}
    assert outcomes <= {"good", "finding", "no body", "refused"}


@pytest.mark.parametrize("case", CASES)
def test_step_faces_are_exact_and_hold_what_the_mesh_holds(case: str) -> None:
    data = bell(**CASES[case])
    one = Model(from_data(data))
    solid = model_bodies(one)
    assert isinstance(solid, Brep)
    verdict = check_solid(solid)
    assert verdict.problems == ()
    assert solid.deviation <= 1e-5
    kinds = {name: {type(face.surface) for face in solid.faces if face.name == name}
             for name in ("land", "inside", "floor", "end")}  # fmt: skip
    assert kinds == {"land": {Cone}, "inside": {Cone}, "floor": {Cone}, "end": {Plane}}
    # Facets lie within the true surface by what their tolerance is: extrapolated to none.
    volumes = [one.with_(output__tolerance=size, output__fewest_triangles=True).solid.mesh.volume
               for size in (4e-4, 1e-4)]  # fmt: skip
    assert verdict.volume == pytest.approx(volumes[1] + (volumes[1] - volumes[0]) / 3.0, rel=1e-7)
    oracle, rng = oracle_of(one, data), np.random.default_rng(1)
    splines = [face.surface for face in solid.faces
               if face.name == "flank" and isinstance(face.surface, SplineSurface)]  # fmt: skip
    points = [
        surface.jet(surface.u.start + (surface.u.stop - surface.u.start) * rng.uniform(0.02, 0.98, 4),
                    rng.uniform(0.02, 0.98, 4))[0]
        for surface in splines
    ]  # fmt: skip
    assert np.abs(oracle.least(np.concatenate(points))).max() < 2e-5


def test_the_volume_is_that_of_the_ring_less_what_any_place_of_the_roller_covers() -> None:
    # At each radius the groove is as high as all places of a roller without ends are together: no envelope in it.
    one = model()
    span = one.setup.program
    phi, (x, w) = 2.0 * pi * np.arange(720) / 720, np.polynomial.legendre.leggauss(16)
    rho, weight = INNER + 0.5 * DEPTH * (1.0 + x), 0.5 * DEPTH * w
    groove = sum(
        float(g * r * _width(lambda at: span.jet(np.ravel(at) % (2.0 * pi), 0)[0].reshape(np.shape(at)), phi, r,
                             RADIUS + 0.02, 0.5 * pi).sum())
        for r, g in zip(rho, weight)
    ) * 2.0 * pi / len(phi)  # fmt: skip
    web = (pi * INNER**2 - Bore(35.0, 10.0, 3.3).area) * 16.0
    solid = model_bodies(one)
    assert isinstance(solid, Brep)
    want = pi * (75.0**2 - INNER**2) * 78.0 + web - groove
    assert check_solid(solid).volume == pytest.approx(want, rel=3e-8)


def test_walls_are_what_is_left_of_the_bell() -> None:
    one, wide = model(), RADIUS + 0.02
    walls = {wall.name: wall.thickness for wall in one.walls}
    assert walls["outside to groove floor"] == pytest.approx(75.0 - INNER - DEPTH)
    assert walls["groove to web"] == pytest.approx(34.0 - wide - 16.0)
    assert walls["groove to upper end"] == pytest.approx(78.0 - 34.0 - 26.0 - wide)
    assert walls["web"] == 16.0
    assert walls["web, bore to ring"] == pytest.approx(INNER - hypot(17.5 + 3.3, 5.0))
    mesh = one.solid.mesh
    floor = np.hypot(*mesh.vertices[mesh.group_vertices("floor")][:, :2].T)
    assert floor == pytest.approx(np.full_like(floor, INNER + DEPTH), rel=1e-12)
    # The thinnest wall is judged on both sides of its limit.
    for least, sound in ((7.99, True), (8.01, False)):
        assert finding(model(limits={"min_wall_mm": least}), "wall", "outside").passed is sound


def test_steep_passes_leave_the_web_of_the_drum_of_the_inside() -> None:
    # Between passes the groove's edges are nearest at the inside, the outside of a drum of that radius.
    motion = ({"until": 60.0, "to": 70.0, "law": "cycloidal"}, {"until": 120.0, "to": 0.0, "law": "cycloidal"},
              {"until": 360.0})  # fmt: skip
    one = model(motion=motion, length=130.0)
    data = bell(motion=motion, length=130.0)
    cam = {"kind": "cylindrical", "diameter": 2.0 * INNER, "length": 130.0, "start": 34.0, "groove_depth": LENGTH,
           "running_clearance": 0.02}  # fmt: skip
    two = Model(from_data(data | {"cam": cam}))
    name = "groove between passes"
    got, want = ({wall.name: wall.thickness for wall in each.walls} for each in (one, two))
    assert 0.0 < got[name] < 60.0
    # A drum's groove is nearer at its floor, which lies further in than this one's edge.
    assert got[name] > want[name]


def test_the_roller_s_flat_end_stays_within_the_hollow_floor() -> None:
    # Its edge is the furthest from the axis: sqrt((inner + length)^2 + r^2), of the tool with its gap.
    most = sqrt((INNER + DEPTH) ** 2 - (RADIUS + 0.02) ** 2) - INNER
    one = model(roller={"length": most - 0.01})
    assert finding(one, "floor-gap").value == pytest.approx(0.01)
    assert finding(one, "floor-gap").passed
    corner = hypot(INNER + most - 0.01, RADIUS)
    assert corner < INNER + DEPTH
    assert not finding(model(roller={"length": most - 0.01}, limits={"clearance_mm": 0.02}), "floor-gap").passed
    with pytest.raises(ProfileError, match=r"roller.length.*edge of its flat end meets the floor"):
        model(roller={"length": most + 0.01})
    with pytest.raises(ProfileError, match=r"cam.groove_depth.*flat end has room"):
        model(roller={"length": 0.1}, groove_depth=0.5)


def test_what_carries_the_roller_is_judged_once_its_size_is_known() -> None:
    # The roller's axis stands at 34 mm at its lowest, the web ends at 16 mm.
    for thick, sound in ((0.999 * 36.0, True), (1.002 * 36.0, False)):
        (bar,) = findings(model(carrier_diameter=thick), ["carrier"])
        assert bar.passed is sound
        assert bar.value == pytest.approx(18.0 - 0.5 * thick)
    assert not next(iter(findings(model(carrier_diameter=35.0, limits={"clearance_mm": 0.6}), ["carrier"]))).passed
    data = bell()
    del data["cam"]["carrier_diameter"]
    (lacks,) = [each for each in judged(Model(from_data(data)), ["carrier"]).not_judged if each.check == "carrier"]
    assert "give cam.carrier_diameter" in lacks.reason
    assert "18 mm above the web" in lacks.reason
    with pytest.raises(ProfileError, match=r"cam.carrier_diameter.*below 112 mm"):
        model(carrier_diameter=112.0)
    end = tomllib.loads((PROFILES / "end_face_lifter.toml").read_text())
    end |= {"motion": tuple(end["motion"]), "output": {}, "cam": end["cam"] | {"carrier_diameter": 10.0}}
    with pytest.raises(ProfileError, match=r"cam.carrier_diameter.*only form = 'groove'"):
        from_data(end)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_a_cone_on_an_arm_presses_each_wall_with_that_walls_lever(way: float, direction: str) -> None:
    """In a dwell a flank is a surface of revolution: on a circle round the cam axis it is highest or lowest where it
    touches, so that r m_y = -r' (y + r m_y) r / x at the place x of the roller's axis, y beside the cam's."""
    arm, start, slope, torque = 90.0, radians(-25.0), -tan(radians(8.0)), 5000.0
    pivot = arm * cos(start) + 6.0
    one = model(
        follower=ARM | {"start_angle": -25.0, "pivot_distance": pivot}, motion=SWUNG, groove_depth=12.5, start=30.0,
        length=90.0, direction=direction, roller=CONE | {"length": 9.0}, running_clearance=0.0,
        operation={"gravity": None, "force": ({"expression": f"{way * torque}"},)},
    )
    place, radius, beside = INNER + 4.5, RADIUS, pivot - arm * cos(start)
    m_y = -slope * beside / (place + radius * slope)
    # The lower wall, which m points down to, pushes the follower on.
    normal = np.array([m_y, -way * sqrt(1.0 - m_y**2)]) / hypot(1.0, slope)
    lever = abs((beside - pivot) * normal[1] - arm * sin(start) * normal[0])
    duty = one.duty
    (got,) = np.abs(duty.force.panels.at(duty.normal, radians(12.0)))
    assert got == pytest.approx(torque / lever, rel=1e-9)
    other = abs((beside - pivot) * normal[1] + arm * sin(start) * normal[0])
    assert abs(torque / other / got - 1.0) > 2e-3


@pytest.mark.parametrize(("room", "key"), [("web", "cam.start"), ("end", "cam.start")])
def test_the_groove_is_kept_between_web_and_end_on_both_sides(room: str, key: str) -> None:
    low, high = 16.0 + RADIUS + 0.02, 78.0 - 26.0 - RADIUS - 0.02
    start, beyond = (low * 1.0005, low * 0.9995) if room == "web" else (high * 0.9995, high * 1.0005)
    one = model(start=start)
    assert one.solid.mesh.volume > 0.0
    assert not finding(one, "wall", "groove to web" if room == "web" else "groove to upper end").passed
    with pytest.raises(ProfileError, match=rf"{key}.*between the web and the ring's end"):
        model(start=beyond)
    with pytest.raises(ProfileError, match=r"cam.length: cannot be built.*above"):
        model(length=40.0)
    with pytest.raises(DesignError, match="runs out"):
        replace(one.parts[0], length=50.0).solid(0.01)


def test_an_undercut_is_judged_where_the_wall_begins() -> None:
    # The path turns sharpest at the inside: what is sound in a drum of the roller's outer end is none there.
    for span, sound in ((115.0, True), (24.0, False)):
        motion = ({"until": span, "to": 26.0, "law": "cycloidal"}, {"until": 2.0 * span, "to": 0.0, "law": "cycloidal"},
                  {"until": 360.0})  # fmt: skip
        one = model(motion=motion, roller={"diameter": 24.0}, groove_depth=14.0)
        assert finding(one, "undercut").passed is sound
        if not sound:
            with pytest.raises(DesignError, match="undercut"):
                _ = one.solids
            place = one.flanks[0].margin.place
            assert INNER - 2.0 < place < INNER


def test_what_means_nothing_is_refused_by_name() -> None:
    for changes, words in (
        ({"height": 40.0}, "cam.height.*means nothing"),
        ({"material": {"cam": {"bending_limit": 300.0}}}, "solved in rings"),
        ({"roller": {"shape": "cone", "half_angle": -5.0}}, "roller.half_angle.*cannot be put into"),
        ({"roller": {"shape": "cone", "half_angle": 55.0, "length": 5.0}}, "roller.half_angle.*comes to its point"),
        ({"roller": {"shape": "sphere", "length": 6.0}}, "roller.shape"),
        ({"roller": CROWN | {"flank": "conforming"}}, "roller.flank.*straight"),
        ({"follower": {"kind": "translating", "clearance": 0.1}}, "running_clearance"),
        ({"groove_depth": 19.0}, "below the ring's thickness"),
        ({"web": 78.0}, "below the length of the ring"),
        ({"form": "end"}, "only form = 'groove' has it"),
        ({"run_out": True}, "run_out"),
        ({"root_radius": 1.0}, "root_radius"),
    ):
        with pytest.raises(ProfileError, match=words):
            from_data(bell(**changes))
    for key in ("length", "start", "groove_depth"):
        data = bell()
        del data["cam"][key]
        with pytest.raises(ProfileError, match=rf"cam.{key}: missing"):
            from_data(data)
    with pytest.raises(ProfileError, match=r"cam.height: missing"):
        from_data({"cam": {"kind": "end-face", "diameter": 120.0, "inner_diameter": 84.0, "web": 15.0},
                   "roller": {"diameter": 20.0, "length": 10.0}, "follower": {"kind": "translating"},
                   "motion": ({"until": 360.0},)})  # fmt: skip


def test_the_groove_rolled_out_is_as_long_as_it_is_in_the_ring() -> None:
    one = model()
    views = plane_views(one)
    assert [view.name for view in views] == ["developed at the pitch radius", "developed at the inner radius"]
    phi = np.linspace(0.0, 2.0 * pi, 20001)
    for view, place in zip(views, (INNER + 0.5 * LENGTH, INNER)):
        curve = next(c for c in view.curves if c.name == "groove centre")
        flat = np.hypot(*np.diff(curve.at(phi)[0], axis=1)).sum()
        s = one.setup.program.jet(phi, 0)[0]
        assert flat == pytest.approx(np.hypot(place * np.diff(phi), np.diff(s)).sum(), rel=1e-7)


def test_flanks_are_painted_whole_however_deep_the_groove_goes_on() -> None:
    # A straight flank has vertices at its mouth and its foot alone, and the foot may be far beyond the roller's end.
    one = model(groove_depth=16.0, roller={"length": 5.0})
    mesh = one.solid.mesh
    painted = fields(one, mesh)
    for name in ("pressure_angle", "curvature", "pressure"):
        assert np.isfinite(painted[name][mesh.group_vertices("flank")]).all(), name
    assert np.degrees(one.pressure_angle.value) == pytest.approx(np.nanmax(painted["pressure_angle"]), rel=1e-3)


def test_the_follower_in_the_ring_is_seen_from_over_its_far_side() -> None:
    # From there the near wall hides nothing above the web: the line of sight to the roller passes over the ring's end.
    one = model()
    (x, _, z), place = seen_from(cam_meshes(one), one.mechanism.inside), 34.0
    assert x < 0.0
    assert place + (INNER + INNER) * z / -x > 78.0
    assert not drum().mechanism.inside


@pytest.mark.parametrize(("angle", "free"), [(19.5, False), (19.6, True), (180.0, True)])
def test_followers_on_one_groove_are_kept_apart_where_they_are_nearest_inside(angle: float, free: bool) -> None:
    one = model(station=({"angle": angle},))
    apart = finding(one, "followers-apart")
    assert apart.passed is free
    if angle < 90.0:
        # While both dwell alike their inner ends are a chord of the inside apart.
        assert apart.value == pytest.approx(2.0 * INNER * np.sin(np.radians(0.5 * angle)) - 2.0 * RADIUS, abs=2e-3)


def test_carriers_of_several_followers_meet_near_the_axis() -> None:
    """Bars 30 mm thick at 60 deg: the corners of their ends meet where they are 15 / tan 30 deg from the axis."""
    close = model(station=({"angle": 60.0}, {"angle": 180.0}), carrier_diameter=30.0)
    (told,) = judged(close, ["carrier"]).not_judged
    corner = 15.0 / tan(radians(30.0)) + 15.0j
    assert abs((corner.conjugate() * np.exp(1j * radians(60.0))) - corner) < 1e-12
    assert (told.check, f"within {corner.real:.4g} mm" in told.reason) == ("carriers", True)
    for alone in ({}, {"station": ({"angle": 180.0},)}):
        assert not judged(model(carrier_diameter=30.0, **alone), ["carrier"]).not_judged


def test_impacts_are_those_of_the_drum() -> None:
    impact = {"law": "hertz", "restitution": 0.6, "turns": 2, "reference_radius": 60.0}
    one, two = (made(impact=impact) for made in (model, drum))
    got, want = (compute(each, ("dynamics",)).data["dynamics"]["impact"] for each in (one, two))
    got, want = got["over_turns"], want["over_turns"]
    for key in ("peak_acceleration_m_s2", "peak_force_main_n", "peak_pressure_mpa", "impacts_per_turn"):
        assert got[key] == pytest.approx(want[key], rel=1e-6), key
    assert got["peak_cam_torque_nm"] == pytest.approx(want["peak_cam_torque_nm"], rel=1e-6)
    assert 1.0 < got["amplification"] == pytest.approx(want["amplification"], rel=1e-6)
