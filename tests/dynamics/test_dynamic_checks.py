"""Findings on what [dynamics] and [impact] solve, each with a design just inside and one just beyond its limit."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from tests.dynamics.machines import (
    IMPACTS,
    OWN,
    ROCKER,
    TOOL_CHANGER,
    changed,
    changer,
    finding,
    follower,
    levels,
    limited,
)
from tests.places import PROFILES
from tests.reference.planar_machines import ELASTIC


def test_a_follower_that_lifts_at_591_rpm_passes_below_and_fails_above():
    below, above = follower(585), follower(640)
    assert levels(follower(590.7), "lift-off") == {"lift-off": "pass"}
    assert levels(follower(590.9), "lift-off") == {"lift-off": "fail"}
    assert levels(below)["lift-off"] == "pass"
    assert finding(below, "lift-off").value == pytest.approx(5.989, abs=1e-3)
    assert levels(above, "contact-kept", "lift-off") == {"contact-kept": "pass", "lift-off": "fail"}
    assert finding(above, "lift-off").value == pytest.approx(-53.24, abs=0.01)
    # its landings are not a steady state: pressure is not judged, and says so
    assert [word.check for word in judge(above, OWN).not_judged] == ["dynamic-pressure"]
    assert levels(above, "settling") == {"settling": "warn"}


def test_the_preload_that_lift_off_advises_just_holds():
    needed = float(follower(640).elastic_follower.jump.required_preload[0])
    for share, level in ((0.999, "fail"), (1.002, "pass")):
        model = follower(640, ("spring_preload = 90", f"spring_preload = {share * needed!r}"))
        assert levels(model, "lift-off") == {"lift-off": level}


def test_a_drive_is_judged_by_the_torque_that_its_vibration_makes():
    """350 r/min: 1 178 MPa rigid, 1 325 MPa elastic; the profile's limit of 1 300 stands between them."""
    model = changer(350)
    dynamic, rigid = model.dynamic_duty.peak_pressure.value, model.carrier.peak_pressure.value
    assert rigid == pytest.approx(1177.64, abs=0.1)
    assert dynamic == pytest.approx(1324.7, rel=1e-3)
    assert levels(model, "turret-pressure", "dynamic-pressure") == {
        "turret-pressure": "pass", "dynamic-pressure": "fail"}
    for share, level in ((1.001, "pass"), (0.998, "fail")):
        limited = changer(350, ("contact_limit = 1300", f"contact_limit = {share * dynamic!r}"))
        assert finding(limited, "dynamic-pressure").level == level
    assert all(model.dynamic_duty.lives[body] < hours for body, hours in model.carrier.lives.items())


def test_dynamic_lives_are_judged_on_both_sides():
    lives = changer(350).dynamic_duty.lives
    least = min(lives.values())
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        model = changer(350, ("life_h = 20000", f"life_h = {share * least!r}"))
        assert max(f.level == "fail" for f in judge(model, ("dynamic-life",)).findings) == (level == "fail")


def test_a_drive_that_does_not_settle_fails_the_band_it_was_given():
    """At 350 r/min the load still swings by 0.031 deg in the dwell."""
    assert levels(changer(120), "settling") == {"settling": "pass"}
    assert levels(changer(350), "settling") == {"settling": "warn"}
    # at 400 r/min a swing of 0.14 deg passes through the band just as the dwell ends
    assert levels(changer(400), "settling") == {"settling": "warn"}
    assert changer(400).indexing.settling_time is None
    for band, level in ((0.05, "pass"), (0.005, "fail")):
        model = changer(350, ("output_damping = 25", f"output_damping = 25\nsettling_band = {band}"))
        assert levels(model, "settling") == {"settling": level}


def ringing(damping, band=None):
    """An elastic follower without polydyne at 600 r/min, preloaded so that it stays on its cam."""
    more = "" if band is None else f"\nsettling_band = {band!r}"
    pairs = (("polydyne = true", ""), ("spring_preload = 400", "spring_preload = 4000"), ("speed = 900", "speed = 600"))
    rings = f"linkage_stiffness = 400\nlinkage_damping = {damping}{more}"
    return Model(parse(changed(ELASTIC.format(law="modified-sine"), *pairs, ("linkage_stiffness = 400", rings))))


def test_an_elastic_follower_that_rings_in_its_dwell_does_not_settle():
    """Beyond 1 % of its stroke of where the load rests a warning, within it told; a given band passes or fails."""
    free, damped = ringing(50), ringing(800)
    assert levels(damped, "settling") == {}
    (word,) = judge(damped, ["settling"]).not_judged
    assert "give dynamics.settling_band, the mm that the dwell has to hold" in word.reason
    assert "is within 0.12 mm, 1 % of its stroke, after" in word.reason
    assert levels(ringing(800, 0.12), "settling") == {"settling": "pass"}
    told = finding(free, "settling")
    assert (told.level, told.where) == ("warn", "into 0.12 mm, before the dwell ends at 150 deg")
    data = compute(free, ("dynamics",)).data["dynamics"]
    swing = data["residual_vibration_m"]
    assert swing > 1.2e-4
    assert data["settling_time_s"] is None
    # the spring's static push on the linkage is no vibration
    assert free.elastic_follower.steady.peak("deviation").magnitude[0] > 4000 / 420e3
    for share, level in ((1.002, "pass"), (0.5, "fail")):
        assert levels(ringing(50, 1e3 * share * swing), "settling") == {"settling": level}


FIXED = "output_damping = 25\nsettling_band = 0.005\nmethod = \"{}\"\nsteps = {}"


def test_a_solution_too_coarse_to_be_judged_is_not():
    """16 steps of the wilson method made the same swing settle; its error is measured now, and said."""
    coarse = changer(350, ("output_damping = 25", FIXED.format("wilson", 16)))
    words = {word.check: word.reason for word in judge(coarse, OWN).not_judged}
    assert set(words) == {"dynamic-pressure", "dynamic-life", "settling", "resonance", "stability"}
    assert all("dynamics.steps" in reason for reason in words.values())
    assert not judge(coarse, OWN).findings
    assert coarse.indexing.summary()["error"] > 0.1
    # steps that are enough are judged as the solution with a tolerance is
    fine = changer(350, ("output_damping = 25", FIXED.format("gauss8", 64)))
    assert levels(fine, "settling", "stability") == {"settling": "fail", "stability": "pass"}
    assert fine.indexing.steady.solution.error[0] < 0.01


def test_a_deviation_known_less_than_its_band_settles_nothing():
    """Below 1 % of the peak, yet more than a tenth of the band."""
    model = changer(350, ("output_damping = 25", FIXED.format("wilson", 2000)))
    assert 1e-4 < model.indexing.steady.solution.error[0] < 0.01
    (word,) = judge(model, ("settling",)).not_judged
    assert "the band is 0.005 deg" in word.reason
    assert levels(model, "stability") == {"stability": "pass"}


def test_a_speed_near_a_critical_one_warns():
    """Harmonic 12 meets the first mode near 400 r/min, where the amplification is 1.72; at 120 r/min it is flat."""
    assert finding(changer(120), "resonance").value < 1.05
    near = finding(changer(400), "resonance")
    assert near.level == "warn"
    assert near.value > 1.3
    assert "harmonic 12" in near.advice


def test_a_resonance_without_damping_warns_and_the_rest_is_not_judged():
    bare = (("linkage_stiffness = 400", "linkage_stiffness = 400\nlinkage_damping = 0"),)
    text = changed(ELASTIC.format(law="cycloidal"), ("polydyne = true", ""), *bare)
    undamped = Model(parse(text)).elastic_follower
    hertz = float(undamped.train.natural_frequency()[0]) / (2.0 * np.pi)
    model = Model(parse(changed(text, ("speed = 900", f"speed = {60.0 * hertz / 8!r}"))))
    verdict = judge(model, OWN)
    assert {word.check for word in verdict.not_judged} >= {"dynamic-pressure", "lift-off", "stability"}
    assert all("resonance" in word.reason for word in verdict.not_judged)


def test_an_indefinite_block_warns_where_the_motion_does_not_move_it():
    lateral = "output_damping = 25\nturret_mass = 20\nload_mass = 30\noutput_axial = 1e5"
    lateral += "\nturret_bending = 1e5\nload_bending = 1e5"
    for cross, level in ((9e4, "pass"), (1.1e5, "warn")):
        model = changer(120, ("output_damping = 25", f"{lateral}\ncross_bending = {cross}"))
        assert max(judge(model, ("stability",)).findings, key=lambda f: f.level == "warn").level == level


def test_a_growing_turn_fails():
    """A turret on a soft contact without damping, at a speed where the varying lever pumps the first mode."""
    study = changer(120).indexing
    from camgeom.dynamics.linear.solve import Growing

    class Pumped:
        @property
        def steady(self):
            raise Growing("a turn grows", 1.3)

    model = changer(120)
    vars(model)["indexing"] = type("Drive", (Pumped,), {"modes": study.modes})()
    found = finding(model, "stability")
    assert (found.level, found.value, found.comparison) == ("fail", 1.3, "<=")


@pytest.mark.parametrize(("share", "level"), [(1.001, "pass"), (0.998, "fail")])
def test_the_pressure_of_impacts_is_judged(share, level):
    text = ROCKER + "\n[impact]\nturns = 2\n"
    peak = Model(parse(text)).impact_pressure.value
    assert peak > 1.2 * Model(parse(text)).carrier.peak_pressure.value
    limits = "[limits]\n" if "[limits]" not in text else ""
    key = f"contact_pressure_mpa = {share * peak!r}\n"
    text = text + "\n" + limits + key if limits else text.replace("[limits]\n", "[limits]\n" + key)
    assert levels(Model(parse(text)), "impact-pressure") == {"impact-pressure": level}


LOADS = """
[[operation.force]]
from = 20
until = 60
expression = "150 * sin(4.5 * (phi - 20 * pi / 180))"
"""


def test_a_stiff_follower_presses_as_the_rigid_one_with_all_that_acts_on_it():
    """Spring, friction, guide friction, weight and an applied force: the limit of a stiff damped linkage is rigid."""
    every = (("spring_rate = 20", "spring_rate = 20\nfriction = 25\nguide_friction = 0.1\ngravity = 9.81"),
             ("linkage_stiffness = 400", "linkage_stiffness = 4e6"),
             ("linkage_damping = 250", "linkage_damping = 3e4"))  # fmt: skip
    model = follower(500, *every, more=LOADS)
    rigid, solved = model.duty, model.dynamic_duty
    assert solved.peak_force.value == pytest.approx(rigid.peak_force.value, rel=2e-3)
    assert solved.peak_pressure.value == pytest.approx(rigid.peak_pressure.value, rel=2e-3)
    theta = np.linspace(0.003, 6.28, 400)
    own = [duty.force.panels.at(duty.normal, theta) for duty in (rigid, solved)]
    assert np.median(np.abs(own[1] - own[0])) < 0.1


def test_a_stiff_drive_presses_as_the_rigid_one():
    stiff = (("input_stiffness = 210000", "input_stiffness = 2e9"),
             ("output_stiffness = 510000", "output_stiffness = 5e9"),
             ("contact_damping = 40", "contact_damping = 4000\ncontact_stiffness = 1e9"),
             ("output_damping = 25", "output_damping = 5000"))  # fmt: skip
    model = changer(120, *stiff)
    assert model.dynamic_duty.peak_pressure.value == pytest.approx(model.carrier.peak_pressure.value, rel=2e-3)
    assert model.dynamic_duty.lives["cam"] == pytest.approx(model.carrier.lives["cam"], rel=2e-2)


@pytest.mark.parametrize(
    "key", ["friction = 25", "guide_friction = 0.2", "gravity = 9.81", "load_mass = 0.5", 'force = "x"'])
def test_every_load_changes_the_elastic_follower(key):
    more, pair = ("", (("spring_rate = 20", f"spring_rate = 20\n{key}"),)) if "force" not in key else (LOADS, ())
    torques = [model.dynamic_duty.peak_torque.value for model in (follower(500, *pair, more=more), follower(500))]
    assert torques[0] != pytest.approx(torques[1], rel=1e-4)


@pytest.mark.parametrize("key", ["friction = 40000", "load_inertia = 0.1", 'force = "x"'])
def test_every_load_changes_the_indexing_drive(key):
    pairs = (("friction = 15000", key),) if "force" not in key else ()
    more = '\n[[operation.force]]\nexpression = "5000"\nfrom = 120\nuntil = 200\n' if "force" in key else ""
    plain = changer(120).indexing.steady.peak("contact_torque").maximum[0]
    text = changed(TOOL_CHANGER, *pairs) + more
    assert Model(parse(text)).indexing.steady.peak("contact_torque").maximum[0] != plain


@pytest.mark.parametrize(("make", "word"), [
    (lambda: changer(120, ("friction = 15000", "friction = 15000\nspring_rate = 10")).indexing, "spring_rate"),
    (lambda: changer(120, ("friction = 15000", "spring_preload = 10")).indexing, "spring_preload"),
    (lambda: follower(500, ("spring_rate = 20", "spring_rate = 20\nguide_friction = 0.1"),
                      ("linkage_damping = 250", "tappet_mass = 0.2\ntappet_stiffness = 1e4")).elastic_follower,
     "guide_friction"),
    (lambda: Model(parse(ELASTIC.format(law="5-6-7-8-9").replace("spring_rate", "friction = 5\nspring_rate")))
     .elastic_follower, "operation.friction"),
    (lambda: follower(500, ("linkage_damping = 250", "sweep = [100, 200]"),
                      more='\n[[operation.force]]\nexpression = "0.01 * v"\n').elastic_follower, "sweep"),
    (lambda: follower(500, ("linkage_damping = 250", "tappet_mass = 2")).elastic_follower, "tappet_mass"),
])  # fmt: skip
def test_what_a_solver_cannot_carry_is_refused_by_name(make, word):
    with pytest.raises(ProfileError, match=word):
        make()


def test_the_tappet_is_a_part_of_what_moves():
    train = follower(500, ("linkage_damping = 250", "tappet_mass = 0.5")).elastic_follower.train
    assert (train.mass, train.tappet_mass) == (1.5, 0.5)
    given = follower(500, ("linkage_damping = 250", "tappet_mass = 0.5\nmass = 1.49")).elastic_follower.train
    assert (given.mass, given.tappet_mass) == (1.49, 0.5)


@pytest.mark.parametrize(("play", "level"), [(0.1, "pass"), (1.0, "warn")])
def test_chaos_is_said(play, level):
    text = changed(ROCKER, ("clearance = 0.02", f"clearance = {play}")) if "clearance = 0.02" in ROCKER else ROCKER
    model = Model(parse(text + f"\n[impact]\nclearance = {play}\nturns = 5\n"))
    found = finding(model, "impact-reproducible")
    assert found.level == level
    assert ("not reproducible beyond turn" in found.advice) == (level == "warn")
    data = compute(model, ("dynamics",)).data["dynamics"]["impact"]
    assert data["sensitivity"]["reproducible_turns"] == found.value
    assert len(data["sensitivity"]["growth_over_turns"]) == 5


def test_the_text_of_solve_tells_vibration_impacts_torque_and_bearing_life(capsys, tmp_path):
    from camgeom.cli import main

    rocker = tmp_path / "rocker.toml"
    rocker.write_text(ROCKER + "\n[impact]\nturns = 2\n")
    wanted = {
        PROFILES / "tool_changer.toml": (
            "peak camshaft torque", "bearing life", "lowest natural frequency", "peak contact pressure, elastic",
            "cam life, elastic", "largest deviation in the dwell"),
        rocker: ("peak pressure of impacts", "impacts in a turn", "turns that can be reproduced"),
    }  # fmt: skip
    for profile, words in wanted.items():
        assert main(["solve", str(profile)]) == 0
        text = capsys.readouterr().out
        assert [word for word in words if word not in text] == []


def test_elastic_and_rigid_figures_stand_beside_each_other():
    found = compute(changer(350), ("dynamics",)).data["dynamics"]
    elastic, rigid = found["duty"], found["rigid_duty"]
    assert set(elastic) == set(rigid)
    assert elastic["peak_pressure_mpa"] > rigid["peak_pressure_mpa"]
    assert elastic["bearing_life_h"] < rigid["bearing_life_h"]


@pytest.fixture(scope="module")
def hit():
    return Model(parse(IMPACTS))


def test_the_forces_of_impacts_go_through_the_hertz_code_of_the_rigid_ones(hit):
    """Force, pressure and torque of the counted turns against those of the solver with its own contact law."""
    run, since = hit.impact, hit.impact.turn_times()[1][0]
    for turn in hit.impact_duties:
        for duty, side in zip(turn, ("main", "return")):
            assert duty.peak_force.value == pytest.approx(run.peak(f"force_{side}", since).value, rel=1e-3)
            assert duty.peak_pressure.value == pytest.approx(1e-6 * run.peak(f"pressure_{side}", since).value, rel=1e-3)
    torque = max(duty.peak_torque.value for turn in hit.impact_duties for duty in turn)
    assert hit.impact_torque.value == pytest.approx(torque, rel=1e-3)
    assert hit.impact_torque.value > 3.0 * hit.drive.peak_torque.value


def test_lives_under_impacts_are_miners_sum_over_the_solved_forces(hit):
    """By hand: a point of the cam is pressed once a turn; points of the roller meet the pressures on their way."""
    material, run = hit.profile.material, hit.impact
    begin, end = run.turn_times()[1]
    per_hour = 60.0 * hit.profile.operation.speed
    cam = material.cam
    peak = max(1e-6 * run.peak(name, begin, end).value for name in ("pressure_main", "pressure_return"))
    by_hand = cam.contact_cycles / (peak / cam.contact_limit) ** cam.exponent / per_hour
    assert hit.impact_lives["cam"] == pytest.approx(by_hand, rel=5e-3)
    roller, duty = material.roller, hit.impact_duties[0][0]
    trace = run.trace.flat()
    inside = (trace.time >= begin) & (trace.time <= end)
    angle, pressure = trace.angle[inside] % (2.0 * np.pi), 1e-6 * trace.pressure[inside, 0]
    order = np.argsort(angle, kind="stable")
    where = duty.force.panels
    fine = np.linspace(0.0, 2.0 * np.pi, 400_001)
    rate = where.at(duty.pressing.path_rate, fine)
    path = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(fine)))
    damage = (np.interp(fine, angle[order], pressure[order]) / roller.contact_limit) ** roller.exponent
    # The wall that bears is met by every second half turn of the roller, beginning with the first or the second.
    start = 0.0 if duty.track.sides[0] == behind_of(duty) else np.pi
    place = np.mod(path / duty.radius - start, 2.0 * np.pi)
    grid = np.linspace(0.0, 2.0 * np.pi, 20_001)
    total, crossings = np.zeros(len(grid)), np.flatnonzero(np.diff(place) < 0.0) + 1
    for k, (first, last) in enumerate(zip([0, *crossings], [*crossings, len(fine)])):
        if k or not start:
            total += np.interp(grid, place[first:last], damage[first:last], left=0.0, right=0.0)
    by_hand = roller.contact_cycles / total.max() / per_hour
    assert duty.lives["roller"] == pytest.approx(by_hand, rel=0.01)


def behind_of(duty):
    """The side of a roller's track that lies behind it: where its lever is negative."""
    from camgeom.track.flank import Flank

    at = np.array([1.0]), np.array([duty.station])
    return next((side for side in duty.track.sides if Flank(duty.track, *at, side).behind), None)


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
def test_the_life_under_impacts_is_judged(hit, share, level):
    least = min(hit.impact_lives.values())
    assert least < 0.2 * min(hit.carrier.lives.values())
    model = Model(parse(limited(IMPACTS, f"life_h = {share * least!r}")))
    found = judge(model, ("impact-life", "life")).findings
    assert max(f.level == "fail" for f in found if f.check == "impact-life") == (level == "fail")
    assert {f.level for f in found if f.check == "life"} == {"pass"}
    figures = compute(model, ("dynamics",)).data["dynamics"]["impact"]
    assert min(figures["duty"][f"{body}_life_h"] for body in ("roller", "cam")) == pytest.approx(least)
    assert figures["rigid_duty"]["cam_life_h"] == pytest.approx(hit.carrier.lives["cam"])


def test_a_life_under_chaotic_impacts_takes_every_turn_as_the_hardest():
    from camgeom.model import HARDEST, MEAN
    from camgeom.model.impact import least_life

    assert least_life([100.0, 300.0], mean=True) == pytest.approx(150.0)
    assert least_life([100.0, 300.0], mean=False) == 100.0
    assert least_life([100.0, np.inf], mean=True) == pytest.approx(200.0)
    assert least_life([0.0, 300.0], mean=True) == 0.0
    text = changed(ROCKER, ("clearance = 0.02", "clearance = 1.0")) if "clearance = 0.02" in ROCKER else ROCKER
    wild = Model(parse(limited(text + "\n[impact]\nclearance = 1.0\nturns = 5\n", "life_h = 1")))
    assert wild.impact_basis == HARDEST != MEAN
    hours = [min(duty.lives["cam"] for duty in turn) for turn in wild.impact_duties]
    assert wild.impact_lives["cam"] == min(hours) < least_life(hours, mean=True)
    assert all(HARDEST in found.where for found in judge(wild, ("impact-life",)).findings)


def test_the_life_of_the_hardest_body_is_judged_whichever_roller_has_it():
    """A roller that is pressed less may live shorter: it turns more often. Two stand-ins, the second of them worse."""

    class Pressed:
        no_stress = ""
        meeting = None

        def __init__(self, pressure, hours):
            self.peak_pressure = type("Peak", (), {"value": pressure})()
            self.lives = {"roller": hours, "cam": 3e5}

    for hours, level in ((20100.0, "pass"), (19900.0, "fail")):
        model = changer(120)
        vars(model)["dynamic_duties"] = (Pressed(900.0, 5e4), Pressed(800.0, hours))
        assert model.dynamic_duty.peak_pressure.value == 900.0
        found = {f.where: f for f in judge(model, ("dynamic-life",)).findings}
        assert (found["roller"].value, found["roller"].level) == (hours, level)
        assert found["cam"].level == "pass"


def test_both_rollers_of_an_elastic_pair_have_their_own_duty():
    elastic = ROCKER + '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 4e5\nlinkage_damping = 300\n'
    model = Model(parse(elastic))
    assert len(model.dynamic_duties) == len(model.duties) == 2
    data = compute(model, ("dynamics",)).data["dynamics"]["duty"]
    assert data["roller_life_h"] == min(duty.lives["roller"] for duty in model.dynamic_duties)
    assert data["cam_life_h"] == min(duty.lives["cam"] for duty in model.dynamic_duties)


@pytest.mark.parametrize(("check", "peak"), [
    ("torque", lambda model: model.shaft.peak_torque.value),
    ("dynamic-torque", lambda model: model.dynamic_torque.value),
])
def test_the_torque_of_the_camshaft_is_judged(check, peak):
    value = 1e-3 * peak(changer(350))
    for share, level in ((1.001, "pass"), (0.998, "fail")):
        model = changer(350, ("life_h = 20000", f"torque_n_m = {share * value!r}"))
        found = finding(model, check)
        assert (found.level, found.unit) == (level, "N m")
        assert found.value == pytest.approx(value)
    assert judge(changer(350), (check,)).findings == ()


def test_the_shaft_of_a_drive_takes_more_than_its_cam():
    """The input shaft turns the cam's own inertia too, and swings with it."""
    model = changer(350)
    steady = model.indexing.steady
    largest = max(1e-3 * model.dynamic_duty.peak_torque.value, float(steady.peak("input_torque").magnitude[0]))
    assert 1e-3 * model.dynamic_torque.value == pytest.approx(largest)
    assert compute(model, ("dynamics",)).data["dynamics"]["camshaft_torque_n_m"] == pytest.approx(largest)


def test_the_torque_of_impacts_is_judged(hit):
    value = 1e-3 * hit.impact_torque.value
    for share, level in ((1.001, "pass"), (0.998, "fail")):
        model = Model(parse(limited(IMPACTS, f"torque_n_m = {share * value!r}")))
        assert levels(model, "impact-torque", "torque") == {"impact-torque": level, "torque": "pass"}


def rated(key, *pairs):
    text = limited(TOOL_CHANGER, f"bearing_static_safety = {key!r}")
    return changed(text, ("speed = 120", "speed = 350"), *pairs)


def test_the_static_safety_of_bearings_is_judged():
    model = changer(350)
    from camgeom.mechanics.duty import least_safety

    for check, duties in (("bearing", model.carriers), ("dynamic-bearing", model.dynamic_duties)):
        safety = least_safety(duties)
        assert safety == pytest.approx(model.setup.roller.static_rating / duties[0].peak_force.value)
        for share, level in ((0.999, "pass"), (1.002, "fail")):
            found = finding(Model(parse(rated(share * safety))), check)
            assert (found.check, found.level) == (check, level)
    assert least_safety(model.dynamic_duties) < least_safety(model.carriers)


def test_impacts_spoil_a_bearing_too(hit):
    roller = "[roller]\n" if "[roller]" in ROCKER else pytest.fail("the rocker has rollers")
    text = IMPACTS.replace(roller, roller + "dynamic_rating = 50000\nstatic_rating = 60000\n")
    largest = max(duty.peak_force.value for turn in hit.impact_duties for duty in turn)
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        model = Model(parse(limited(text, f"bearing_static_safety = {share * 60000 / largest!r}")))
        assert levels(model, "impact-bearing", "bearing") == {"impact-bearing": level, "bearing": "pass"}


def test_the_case_lies_below_the_shear_of_vibration_and_impacts(hit):
    """A case that is deep enough for the rigid load alone fails by the check of the history."""
    model = changer(350)
    impacts = [duty for turn in hit.impact_duties for duty in turn]
    for kind, text, duties, rigid in (
        ("dynamic", changed(TOOL_CHANGER, ("speed = 120", "speed = 350")), model.dynamic_duties, model.carriers),
        ("impact", IMPACTS, impacts, hit.carriers),
    ):
        depth = max(duty.deepest_shear.value for duty in duties)
        assert depth > max(duty.deepest_shear.value for duty in rigid)
        for share, level in ((1.002, "pass"), (0.999, "fail")):
            key = f"case_depth_mm = {2.0 * share * depth!r}\n"
            head, table, rest = text.partition("[material.cam]")
            comment, _, keys = rest.partition("\n")
            cased = f"{head}{table}{comment}\n{key}{keys}" if table else f"{text}\n[material.cam]\n{key}"
            names = ("case-depth", f"{kind}-case-depth")
            assert levels(Model(parse(cased)), *names) == {"case-depth": "pass", f"{kind}-case-depth": level}


def test_limits_of_a_load_ask_for_what_they_need():
    with pytest.raises(ProfileError, match="bearing_static_safety"):
        parse(limited(ROCKER, "bearing_static_safety = 2"))  # no rating
    press = (PROFILES / "constant_width_press.toml").read_text()
    with pytest.raises(ProfileError, match="no bearing"):
        parse(limited(press, "bearing_static_safety = 2"))
    (word,) = judge(Model(parse(limited(DISC, "torque_n_m = 5"))), ("torque",)).not_judged
    assert "operation" in word.reason


DISC = """
[cam]
kind = "disc"
base_radius = 40
width = 14
[follower]
kind = "translating"
mass = 1
[roller]
diameter = 20
length = 12
[[motion]]
until = 180
to = 12
law = "cycloidal"
[[motion]]
until = 360
to = 0
law = "cycloidal"
"""


def test_a_study_of_a_table_that_the_profile_has_not_is_refused(tmp_path, capsys):
    from camgeom.cli import main

    for table, key in (("impact", "impact.clearance=0.01:0.1:2"), ("dynamics", "dynamics.sweep_points=3,4")):
        words = ["study", str(PROFILES / "pin_insertion.toml"), "--vary", key, "--out", str(tmp_path)]
        assert main(words) == 2
        assert f"has no [{table}] table" in capsys.readouterr().err


def test_a_turret_without_dynamics_is_told_to_be_judged_rigid() -> None:
    text = (PROFILES / "tool_changer.toml").read_text(encoding="utf-8")
    assert list(judge(Model(parse(text)), ["vibration"]).not_judged) == []
    before, _, after = text.partition("[dynamics]")
    rigid = before + after[after.index("\n[") :] if "\n[" in after else before
    (told,) = judge(Model(parse(rigid)), ["vibration"]).not_judged
    assert told.reason.startswith("no [dynamics]")
    drum = Model(parse((PROFILES / "pin_insertion.toml").read_text(encoding="utf-8")))
    assert judge(drum, ["vibration"]).not_judged == ()


CROWNED = """
name = "crowned"
[cam]
kind = "conjugate"
base_radius = 113.655
width = 18.614
gap = 6.833
center_distance = 180.474
direction = "cw"
[follower]
kind = "swinging"
arm = 79.213
inertia = 0.090537
[roller]
shape = "crowned"
diameter = 36.734
length = 18.614
crown_radius = 1739.6
[operation]
speed = 270.88
friction = 2831
[dynamics]
kind = "follower"
linkage_stiffness = 973449
linkage_damping = 125.9
[[motion]]
until = 35.124
[[motion]]
until = 160.179
to = 17.465
law = "modified-trapezoid"
[[motion]]
until = 206.023
[[motion]]
until = 322.13
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""


def test_a_stiff_drive_presses_its_crowned_rollers_as_a_rigid_one() -> None:
    """Next to no force comes and goes between both rollers while it rings: the squares far beside the ellipse do not
    leap with it (two thirds more pressure stood there, at the roller's end)."""
    model = Model(parse(CROWNED))
    rigid, vibrating = finding(model, "contact-pressure"), finding(model, "dynamic-pressure")
    assert vibrating.value == pytest.approx(rigid.value, rel=0.02)
    assert vibrating.where == rigid.where
