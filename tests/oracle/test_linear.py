"""Linear cams against closed forms: the follower over crank and groove, forces, life of two passes, sizes, refusals."""

from __future__ import annotations

import itertools
from math import acos, atan, cos, degrees, hypot, pi, radians, sin

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from camgeom.checks import findings, judge
from camgeom.errors import DesignError, ProfileError
from camgeom.export.step.check import check_solid
from camgeom.export.step.solids import pocket_solid
from camgeom.machining.job import machining_of
from camgeom.machining.spec import CutterSpec
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute

STROKE, RISE, FIRST, WIDE, RADIUS, GAP = 100.0, 20.0, 15.0, 70.0, 9.0, 0.02
OMEGA = 4.0 * pi
BASE = """
name = "plate"
{units}
[cam]
kind = "linear"
stroke = 100
length = 150
width = 70
thickness = 20
start = 25
edge = 22
groove_depth = 10
running_clearance = 0.02
{cam}
[follower]
{swing}
{follower}
[roller]
diameter = 18
length = 9
[[motion]]
until = {first}
[[motion]]
until = 85
to = {rise}
law = "cycloidal"
[[motion]]
until = {last}
[operation]
speed = 120
friction = 12
[limits]
{limits}
[output]
tolerance = 0.01
{more}
"""


GIVEN = {"units": "", "cam": "", "swing": 'kind = "translating"\nmass = 3', "follower": "", "first": 15, "rise": 20,
         "last": 100, "limits": "", "more": ""}  # fmt: skip


ELASTIC = '[dynamics]\nkind = "follower"\nlinkage_stiffness = 30\nlinkage_damping = 60\n'


def plate(**keys: object) -> Model:
    given = GIVEN | {"cam": "moving_mass = 5"}
    return Model(parse(BASE.format(**given | keys)))


@pytest.fixture(scope="module")
def model() -> Model:
    return plate()


def finding(model: Model, name: str):
    return next(iter(findings(model, [name])))


def groove(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """Lift, its slope and its second derivative over the travel."""
    u = np.clip((x - FIRST) / WIDE, 0.0, 1.0)
    s = RISE * (u - np.sin(2.0 * pi * u) / (2.0 * pi))
    return s, RISE / WIDE * (1.0 - np.cos(2.0 * pi * u)), 2.0 * pi * RISE / WIDE**2 * np.sin(2.0 * pi * u)


def crank(theta: np.ndarray, out: float = pi) -> tuple[np.ndarray, ...]:
    """Travel and two derivatives of a crank that takes `out` for the way out."""
    there = theta <= out
    rate = np.where(there, pi / out, pi / (2.0 * pi - out))
    angle = np.where(there, theta * rate, pi + (theta - out) * rate)
    half = 0.5 * STROKE
    return half * (1.0 - np.cos(angle)), half * rate * np.sin(angle), half * rate**2 * np.cos(angle)


@pytest.mark.parametrize("out", [180.0, 130.0])
def test_the_follower_runs_the_groove_out_and_back_at_the_cranks_pace(out: float) -> None:
    program = plate(cam=f"drive_out = {out}").setup.program
    theta = np.random.default_rng(1).uniform(0.0, 2.0 * pi, 500)
    x, dx, ddx = crank(theta, radians(out))
    s, slope, bend = groove(x)
    jet = program.jet(theta, 2)
    for found, wanted in zip(jet, (s, slope * dx, bend * dx * dx + slope * ddx)):
        assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()
    assert program.closed
    # The crank turns round at rest, so that two derivatives go on there even where its pace changes.
    assert program.continuity.order == 2
    assert [round(degrees(jump.angle)) % 360 not in (0, round(out)) for jump in program.continuity.jumps]


@pytest.mark.parametrize(("law", "drive"), [("5-6-7-8-9", "4-5-6-7"), ("4-5-6-7", "simple-harmonic"),
                                            ("modified-trapezoid", "5-6-7-8-9")])  # fmt: skip
def test_a_motion_that_comes_to_rest_smoothly_is_composed_too(law: str, drive: str) -> None:
    setup = plate(cam=f'drive = "{drive}"').with_({"motion[1].law": law}).setup
    theta = np.concatenate([np.linspace(0.0, 2.0 * pi, 400), pi + np.linspace(-0.01, 0.01, 50)])
    place = setup.carriage.drive.jet(theta, 2)
    lift = setup.carriage.path.jet(np.clip(place[0], 0.0, 2.0 * pi), 2)
    wanted = lift[0], lift[1] * place[1], lift[2] * place[1] ** 2 + lift[1] * place[2]
    for found, exact in zip(setup.program.jet(theta, 2), wanted):
        assert np.abs(found - exact).max() < 1e-12 * np.abs(exact).max()


def test_the_best_law_of_a_path_is_told_of_the_path() -> None:
    found = plate().with_({"motion[1].law": "optimal", "motion[1].minimise": "jerk"}).setup.program
    assert len(found.segments) > 3
    ((number, best),) = found.best_laws
    assert number == 1
    assert best.value == pytest.approx(32.0, rel=1e-6)


def test_a_linkage_swings_behind_the_plate_as_one_integrated_apart() -> None:
    """Newton's law of a mass behind spring and damper, over crank and groove, until its start has died away."""
    made, mass, stiff, damp = plate(more=ELASTIC, limits="drive_force_n = 1000"), 3.0, 30e3, 60.0

    def lifted(theta: float) -> tuple[float, float]:
        x, dx, _ = crank(np.array([theta % (2.0 * pi)]))
        s, slope, _ = groove(x)
        return 1e-3 * float(s[0]), 1e-3 * OMEGA * float((slope * dx)[0])

    def rest(theta: float) -> float:
        rate = lifted(theta)[1]
        return 12.0 * np.sign(rate) if abs(rate) > 1e-9 else 0.0

    def rates(time: float, state: np.ndarray) -> tuple[float, float]:
        place, rate = lifted(OMEGA * time)
        push = stiff * (place - state[0]) + damp * (rate - state[1])
        return state[1], (push - rest(OMEGA * time)) / mass

    turns, turn = 3, 2.0 * pi / OMEGA
    edges = [acos(1.0 - 2.0 * x / STROKE) / OMEGA for x in (FIRST, 85.0)]
    edges = [0.0, *edges, *(turn - edge for edge in reversed(edges)), turn]
    state, theta, push = np.zeros(2), [], []
    for number in range(turns):
        for begin, end in itertools.pairwise(edges):
            times = np.linspace(begin, end, 120)[1:-1]
            run = solve_ivp(rates, (begin, end), state, "DOP853", np.append(times, end), rtol=1e-10, atol=1e-13)
            state = run.y[:, -1]
            if number == turns - 1:
                theta += (OMEGA * times).tolist()
                place, rate = np.array([lifted(OMEGA * time) for time in times]).T
                push += (stiff * (place - run.y[0, :-1]) + damp * (rate - run.y[1, :-1])).tolist()
    angle, exact = np.array(theta), np.array(push)
    found = made.elastic_follower.steady.at(angle, "contact_force")[0]
    assert np.abs(found - exact).max() < 1e-4 * np.abs(exact).max()

    slid = made.dynamic_slide_drive
    x, _, ddx = crank(angle)
    drive = exact * groove(x)[1] + 5e-3 * OMEGA**2 * ddx
    assert np.abs(slid.duty.force.panels.at(slid.force, angle) - drive).max() < 2e-4 * np.abs(drive).max()
    # Largest where the plate turns round, with vibration or not; along the groove vibration asks more.
    assert slid.peak.value == pytest.approx(made.slide_drive.peak.value)
    assert slid.peak_groove.value > 1.05 * made.slide_drive.peak_groove.value
    assert slid.peak_groove.value == pytest.approx(np.abs(exact * groove(x)[1]).max(), rel=2e-3)
    told = compute(made, ("dynamics",)).data["dynamics"]
    assert told["duty"]["peak_travel_force_n"] == pytest.approx(slid.peak_groove.value)
    assert told["rigid_duty"]["peak_travel_force_n"] == pytest.approx(made.slide_drive.peak_groove.value)
    assert not any("torque" in key for key in (*told, *told["duty"], *told["start_duty"]))


@pytest.mark.parametrize(("share", "level"), [(0.999, "fail"), (1.001, "pass")])
def test_the_drives_force_with_vibration_has_two_sides(share: float, level: str) -> None:
    heavy = {"swing": 'kind = "translating"\nmass = 30', "more": ELASTIC.replace("= 30", "= 300")}
    free = plate(**heavy)
    steady, start = free.dynamic_slide_drive.peak.value, free.start_slide_drive.peak.value
    held = plate(**heavy, limits=f"drive_force_n = {share * steady}")
    assert steady > 1.05 * free.slide_drive.peak.value
    assert finding(held, "dynamic-drive-force").level == level
    assert finding(plate(**heavy, limits=f"drive_force_n = {share * start}"), "start-drive-force").level == level
    assert finding(held, "drive-force").level == "pass"
    assert not list(findings(held, ["dynamic-torque", "start-torque"]))


@pytest.mark.parametrize("lean", [0.0, 20.0, -25.0])
def test_the_pressure_angle_is_that_of_the_slope_seen_from_the_slide(lean: float) -> None:
    made = plate(cam=f"inclination = {lean}")
    worst = finding(made, "pressure-angle")
    slope = 2.0 * RISE / WIDE
    way = (1.0 + slope * sin(radians(lean)), slope * cos(radians(lean)))
    normal = (-way[1] / hypot(*way), way[0] / hypot(*way))
    cosine = normal[0] * sin(radians(lean)) + normal[1] * cos(radians(lean))
    # Leaning against the rise the dwells have the larger angle: that of the slide itself.
    assert cos(radians(worst.value)) == pytest.approx(min(cosine, cos(radians(lean))), abs=1e-9)
    if not lean:
        assert worst.value == pytest.approx(degrees(atan(slope)), abs=1e-9)
    if lean >= 0.0:
        assert made.pressure_angle.cam_angle == pytest.approx(0.5 * pi, abs=1e-5)  # half way out


def test_forces_are_newtons_and_the_plate_asks_most_where_it_turns_round(model: Model) -> None:
    drive, panels = model.slide_drive, model.duty.force.panels
    assert drive is not None
    theta = np.array([0.9, 1.4, 2.0, 4.1])
    x, dx, ddx = crank(theta)
    _, slope, bend = groove(x)
    force = 3e-3 * OMEGA**2 * (bend * dx * dx + slope * ddx) + 12.0 * np.sign(slope * dx)
    assert panels.at(model.duty.normal, theta) == pytest.approx(force * np.hypot(1.0, slope), rel=1e-9)
    assert panels.at(drive.groove, theta) == pytest.approx(force * slope, rel=1e-9)
    assert panels.at(drive.force, theta) == pytest.approx(force * slope + 5e-3 * OMEGA**2 * ddx, rel=1e-9)
    assert drive.peak.value == pytest.approx(5e-3 * OMEGA**2 * 0.5 * STROKE, rel=1e-9)
    # All the work is friction's: twice the rise.
    assert drive.data()["mean_drive_power_w"] == pytest.approx(12.0 * 2.0 * RISE * OMEGA / (2.0 * pi) * 1e-3, rel=1e-9)


@pytest.mark.parametrize("side", ["left", "right"])
def test_an_arm_is_driven_by_the_torque_of_its_pressure_angle(side: str) -> None:
    arm, rest, way = 60.0, radians(-6.0), 1.0 if side == "left" else -1.0
    made = plate(swing=f'kind = "swinging"\narm = 60\nstart_angle = -6\nside = "{side}"\ninertia = 0.01', rise=16)
    theta = np.array([0.9, 1.4, 2.0, 4.1])
    x, dx, ddx = crank(theta)
    s, slope, bend = (radians(16.0) / RISE * one for one in groove(x))
    # Seen from the plate the roller goes on by dx along it and by the arm's arc; it pushes square to that.
    along = 1.0 - way * arm * np.sin(rest + s) * slope
    across = arm * np.cos(rest + s) * slope
    swing = np.stack([-way * np.sin(rest + s), np.cos(rest + s)])
    cosine = np.abs(-across * swing[0] + along * swing[1]) / np.hypot(along, across)
    torque = 10.0 * OMEGA**2 * (bend * dx * dx + slope * ddx) + 12.0 * np.sign(slope * dx)
    assert made.duty.force.panels.at(made.duty.normal, theta) == pytest.approx(torque / (arm * cosine), rel=1e-9)
    drive = made.slide_drive
    assert drive.duty.force.panels.at(drive.groove, theta) == pytest.approx(torque * slope, rel=1e-9)
    x, _, _ = crank(made.flanks[0].phi)
    s, slope, _ = (radians(16.0) / RISE * one for one in groove(x))
    ahead, up = 1.0 - way * arm * np.sin(rest + s) * slope, arm * np.cos(rest + s) * slope
    cosine = (up * way * np.sin(rest + s) + ahead * np.cos(rest + s)) / np.hypot(ahead, up)
    found = made.flanks[0].flank(1.0).pressure_angle()[:, 4]
    assert found == pytest.approx(np.arccos(np.minimum(cosine, 1.0)), abs=1e-7)
    assert made.solid.sound


def test_what_presses_the_plate_on_its_slide_is_told_by_hand() -> None:
    made = plate(swing='kind = "swinging"\narm = 60\nstart_angle = -6\nside = "left"\ninertia = 0.01', rise=16,
                 limits="drive_force_n = 900")  # fmt: skip
    x, dx, ddx = crank(np.linspace(0.0, 2.0 * pi, 100_001))
    s, slope, bend = (radians(16.0) / RISE * one for one in groove(x))
    torque = 10.0 * OMEGA**2 * (bend * dx * dx + slope * ddx) + 12.0 * np.sign(slope * dx)
    turned = radians(-6.0) + s
    # The force on the roller is square to its way on the plate, and its lever about the pivot makes the torque.
    along, across = 1.0 - 60.0 * np.sin(turned) * slope, 60.0 * np.cos(turned) * slope
    pressed = torque * along / (60.0 * (across * np.sin(turned) + along * np.cos(turned)))
    assert made.slide_drive.peak_across.value == pytest.approx(np.abs(pressed).max(), rel=1e-6)
    (rubs,) = judge(made, ["drive-force"]).not_judged
    assert (rubs.check, f"by up to {np.abs(pressed).max():.4g} N" in rubs.reason) == ("drive-friction", True)
    # Where the drive's force is not judged itself, nothing is said of what it is without.
    assert [word.check for word in judge(plate(), ["drive-force"]).not_judged] == ["drive-force"]


def test_the_drives_force_has_two_sides_and_no_verdict_without_its_mass(model: Model) -> None:
    peak = model.slide_drive.peak.value
    for factor, level in ((1.0 / 0.999, "pass"), (1.0 / 1.002, "fail")):
        assert finding(plate(limits=f"drive_force_n = {factor * peak}"), "drive-force").level == level
    for keys in ({"cam": "", "limits": "drive_force_n = 90"}, {}):
        assert not [one for one in findings(plate(**keys), ["drive-force"]) if one.level != "not judged"]


def test_a_place_of_the_groove_is_passed_twice_a_turn_of_the_drive(model: Model) -> None:
    duty, material = model.duty, model.profile.material.cam
    top = float(duty.contact.peak().pressure)
    once = (top / material.contact_limit) ** material.exponent / material.contact_cycles
    assert duty.cam_life.life_h == pytest.approx(2.0 * pi / (2.0 * once * OMEGA * 3600.0), rel=1e-9)
    # The roller's path is the pitch curve's and what its slope turns it by, out and back.
    x = np.linspace(0.0, STROKE, 200_001)
    _, slope, _ = groove(x)
    length = np.trapezoid(np.hypot(1.0, slope), x)
    turned = np.abs(np.diff(np.arctan(slope))).sum()
    assert abs(float(duty.roller_life.path) - 2.0 * length) < 2.0 * RADIUS * turned


def test_the_body_is_the_plate_less_the_band_that_the_tool_sweeps(model: Model) -> None:
    x = np.linspace(0.0, STROKE, 200_001)
    length, radius = float(np.trapezoid(np.hypot(1.0, groove(x)[1]), x)), RADIUS + GAP
    volume = 150.0 * 70.0 * 20.0 - 10.0 * (2.0 * radius * length + pi * radius**2)
    assert check_solid(pocket_solid(model.parts[0])).volume == pytest.approx(volume, rel=1e-8)
    assert model.solid.sound
    assert model.solid.mesh.volume == pytest.approx(volume, rel=1e-4)
    assert finding(model, "interference").value == pytest.approx(GAP, abs=1e-9)
    assert finding(model, "backlash").passed
    walls = {wall.name: wall.thickness for wall in model.walls}
    assert walls["groove to the edge y = 0"] == pytest.approx(22.0 - radius, abs=1e-9)
    assert walls["groove to the other edge"] == pytest.approx(70.0 - 22.0 - RISE - radius, abs=1e-9)
    assert walls["groove to the end x = 0"] == pytest.approx(25.0 - radius, abs=1e-9)
    assert walls["groove to the other end"] == pytest.approx(25.0 - radius, abs=1e-9)
    # A wall as thin as the limit has two sides.
    for factor, level in ((0.999, "pass"), (1.002, "fail")):
        found = findings(plate(limits=f"min_wall_mm = {factor * (22.0 - radius)}"), ["wall"])
        (edge,) = (one for one in found if "edge y = 0" in one.where)
        assert (edge.level == "fail") is (level == "fail")


@pytest.mark.parametrize("tool", [{}, {"kind": "flat", "diameter": 12.0}])
def test_the_tool_keeps_to_the_groove(model: Model, tool: dict[str, object]) -> None:
    made = machining_of("plate", CutterSpec(**tool), [model.mechanism], model.parts)
    assert made.machine.letters == ("X", "Y", "Z")
    x = np.linspace(0.0, STROKE, 40_001)
    pitch = np.stack([25.0 + x, 22.0 + groove(x)[0]])
    (cut,) = made.passes("machine")
    tips = np.concatenate([move.positions.tip[:, :: max(1, move.positions.tip.shape[1] // 200)]
                           for move in cut.moves if move.kind == "cut"], axis=1)  # fmt: skip
    away = np.hypot(*(tips[:2, :, None] - pitch[:, None])).min(axis=1)
    assert away == pytest.approx(np.full(away.shape, RADIUS + GAP - 6.0 if tool else 0.0), abs=2e-3)
    assert tips[2] == pytest.approx(np.full(tips.shape[1], 10.0))
    with pytest.raises(DesignError, match="does not go into the groove"):
        machining_of("plate", CutterSpec(kind="flat", diameter=18.1), [model.mechanism], model.parts)


def test_lengths_in_inches_are_those_in_mm() -> None:
    data = plate().profile.stated
    inches = {**data, "units": "inch", "output": {"tolerance": 0.01 / 25.4}}
    lengths = {k: v / 25.4 for k, v in data["cam"].items() if k not in ("kind", "moving_mass")}
    inches["cam"] = {**data["cam"], **lengths}
    inches["roller"] = {k: v / 25.4 for k, v in data["roller"].items()}
    inches["motion"] = tuple({k: v if k == "law" else v / 25.4 for k, v in one.items()} for one in data["motion"])
    theta = np.linspace(0.0, 2.0 * pi, 50)
    made = plate().with_({}).profile.setup().program.jet(theta, 0)
    from camgeom.profile import from_data

    assert from_data(inches, "").setup().program.jet(theta, 0) == pytest.approx(made, abs=1e-9)


@pytest.mark.parametrize(("unit", "rates"), [("mm", 1.0), ("inch", 25.4)])
def test_rates_of_an_arm_over_a_travel_are_degrees_per_length(unit: str, rates: float) -> None:
    """Also in inches: deg/in, deg/in2, deg/in3."""
    arm = 'kind = "swinging"\narm = {}\nstart_angle = -6\nside = "left"\ninertia = 0.01'
    data = dict(plate(swing=arm.format(60.0 / rates), rise=16).profile.stated)
    law = {"law": "polynomial", "velocity": 0.01 * rates, "acceleration": 0.001 * rates**2}
    data["motion"] = ({"until": 50.0 / rates, "to": 8.0, **law},
                      {"until": 100.0 / rates, "to": 12.0, "law": "polynomial"})  # fmt: skip
    if unit == "inch":
        data |= {"units": "inch", "output": {"tolerance": 0.01 / rates}}
        data["cam"] = {k: v / rates if k not in ("kind", "moving_mass") else v for k, v in data["cam"].items()}
        data["roller"] = {k: v / rates for k, v in data["roller"].items()}
    from camgeom.profile import from_data

    # The crank is half way out: x = 50 mm, dx = 50 mm/rad, ddx = 0.
    _, rate, bend = from_data(data, "").setup().program.jet(np.array([0.5 * pi]), 2)[:, 0]
    assert (rate, bend) == pytest.approx((radians(0.01) * 50.0, radians(0.001) * 2500.0), rel=1e-9)


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.998, "fail")])
def test_what_moves_has_the_plates_own_mass_at_least(model: Model, share: float, level: str) -> None:
    own = model.mass[0].mass
    made = plate(cam=f"moving_mass = {share * own}")
    assert [one.level for one in findings(made, ["moving-mass"]) if "plate" in one.where] == [level]


@pytest.mark.parametrize(("keys", "key", "says"), [
    ({"last": 99}, "motion[2].until", "100 mm, cam.stroke"),
    ({"first": 90}, "motion[1].until", "above 90 mm of travel"),
    ({"cam": 'drive = "constant-velocity"'}, "cam.drive", "begins and ends at rest"),
    ({"cam": 'drive = "spline"'}, "cam.drive", "shape of its own"),
    ({"limits": "torque_n_m = 3"}, "limits.torque_n_m", "drive_force_n"),
    ({"follower": "offset = 3"}, "follower.offset", "cam.edge"),
    ({"more": f"{ELASTIC}polydyne = true"}, "dynamics.polydyne", "over one flank"),
    ({"more": f"{ELASTIC}body_compliance = true"}, "dynamics.body_compliance", "not meshed"),
    ({"more": f"{ELASTIC}shaft_inertia = 1\nshaft_stiffness = 1"}, "dynamics.shaft_inertia", "takes it as rigid"),
    ({"more": "[lubricant]\nviscosity_40 = 100\nviscosity_100 = 11\ntemperature = 50\npressure_viscosity = 20"},
     "lubricant.pressure_viscosity", "turns round"),
    ({"more": "[impact]\nrestitution = 0.5"}, "impact", "not solved so far"),
    ({"more": "[tolerance]\ncam_eccentricity = 0.01"}, "tolerance.cam_eccentricity", "with the cam: this cam has none"),
    ({"more": "[tolerance]\ncam_wobble_arcmin = 1"}, "tolerance.cam_wobble_arcmin", "with the cam: this cam has none"),
    ({"more": "[tolerance]\nside_shift = 0.01\naxes_pivot = [0, 0, 0]"}, "tolerance.axes_pivot", "cam_yaw_arcmin"),
    ({"more": '[cutter]\nkind = "flat"\ndiameter = 10\nrotary = "A"'}, "cutter.rotary", "none on a plate"),
])  # fmt: skip
def test_what_means_nothing_is_refused_by_name(keys: dict[str, object], key: str, says: str) -> None:
    with pytest.raises(ProfileError) as refused:
        plate(**keys)
    problem = next(one for one in refused.value.problems if one.key == key)
    assert says in f"{problem.message} {problem.allowed} {problem.hint}"


def test_a_groove_that_leaves_the_plate_is_refused_and_one_just_within_is_not() -> None:
    least = RADIUS + GAP
    text = BASE.replace("edge = 22", "edge = {edge}").replace("start = 25", "start = {start}")
    for place in ("edge", "start"):
        for by, good in ((1e-3, True), (-1e-3, False)):
            keys = GIVEN | {"edge": 22, "start": 25} | {place: least + by}
            if good:
                parse(text.format(**keys))
            else:
                with pytest.raises(ProfileError, match=f"cam.{place}"):
                    parse(text.format(**keys))


def test_a_roller_too_large_for_its_path_is_undercut() -> None:
    made = plate().with_({"motion[1].until": 24.0, "motion[2].until": 100.0})
    assert finding(made, "undercut").level == "fail"
    with pytest.raises(DesignError, match="undercut"):
        _ = made.solid


@pytest.mark.parametrize(("drive", "out", "level"), [
    ("simple-harmonic", 180, "pass"), ("simple-harmonic", 120, "warn"), ("cycloidal", 120, "pass"),
])  # fmt: skip
def test_a_drive_whose_force_jumps_at_the_dead_points_is_told(drive: str, out: int, level: str) -> None:
    """Of a simple harmonic (stroke / 2) (pi / out)^2 on one side and (pi / back)^2 on the other: four times as much."""
    made = plate(cam=f'moving_mass = 5\ndrive = "{drive}"\ndrive_out = {out}')
    assert [one.level for one in findings(made, ["continuity"]) if one.where == "the plate's drive"] == [level]
