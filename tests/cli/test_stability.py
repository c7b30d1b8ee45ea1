"""Failures that the random campaign found, each held down: no silent one may come back."""

from __future__ import annotations

from math import degrees

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.report.result import compute
from camgeom.track.column import Column
from camgeom.track.flank import Flank
from camgeom.track.follower import CylinderRoller, SphereRoller
from camgeom.track.survey import FLANKS, Survey
from tests.reference.machines import pin_cam, pin_setup, program

DISC = {
    "cam": {"kind": "disc", "base_radius": 30.0, "width": 12.0},
    "follower": {"kind": "translating", "mass": 0.5},
    "roller": {"diameter": 20.0, "length": 8.0},
    "motion": (
        {"until": 120.0, "to": 12.0, "law": "cycloidal"},
        {"until": 300.0, "to": 0.0, "law": "cycloidal"},
        {"until": 360.0},
    ),
    "output": {"tolerance": 0.02},
}


def changed(**sections):
    """The disc's tables with keys replaced."""
    return {**DISC, **{name: {**DISC.get(name, {}), **keys} for name, keys in sections.items()}}


@pytest.mark.parametrize("times", [0.5, 0.9, 1.1, 1.9, 2.1, 3.0, 10.0])
def test_margin_of_a_flank_folded_once_or_twice(times):
    # A short parabolic rise from rest: the pitch curve has one curvature k there, and r k is chosen.
    rise = 0.02
    height = times * 67.0**2 / 11.0 * rise**2 / 4.0
    up, down = (100 + degrees(rise), height, "parabolic"), (300, 0.0, "cycloidal")
    motion = program((100, None, None), up, down, (360, None, None))
    setup = pin_setup(motion=motion)
    survey = Survey(pin_cam().mechanism(setup).tracks[0], pin_cam().mechanism(setup).cutters[0])
    # At the wall's inner end the same motion is on a smaller radius: 55 mm and not 67.
    assert survey.margin.value <= 1.0 - times * (67.0 / 68.0) ** 2
    assert (survey.margin.value > 0.0) == (times < 0.6)


def test_rollers_narrower_than_the_disc_are_measured_against_its_wall():
    model = Model(from_data(DISC))
    finding = next(f for f in compute(model, ("checks",)).findings if f.check == "interference")
    assert finding.value == pytest.approx(0.0, abs=1e-9)
    # A larger roller than the cam was cut for stands in it by the difference.
    assert model.clearances_with(0.25)[0].value == pytest.approx(-0.25, abs=1e-9)


def test_a_stress_that_has_no_answer_leaves_the_rest_of_the_result():
    data = changed(operation={"speed": 10.0, "friction": 1e8})
    result = compute(Model(from_data(data)), ("motion", "solid", "contact", "fatigue"))
    assert "half-space" in result.data["contact"]["refused"]
    assert result.data["solid"]["watertight"]
    assert result.exit_status == 1
    statuses = {product.name: product.status for product in result.products}
    assert statuses == {"motion": "made", "solid": "made", "contact": "refused", "fatigue": "refused"}


def test_singular_surface_gives_large_curvatures_and_no_warning():
    from camgeom.maths.surface import Forms

    one, zero = np.ones(3), np.zeros(3)
    high, low = Forms(one, one, one, one, zero, zero).principal()
    assert np.isfinite([high, low]).all()
    assert (np.maximum(np.abs(high), np.abs(low)) > 1e12).all()
    flat = Forms(zero, zero, zero, zero, zero, zero).principal()
    assert np.isfinite(flat).all()


def test_undercut_seed_is_refused_by_name():
    data = dict(DISC)
    data["motion"] = (
        {"until": 20.0, "to": 12.0, "law": "cycloidal"},
        {"until": 40.0, "to": 0.0, "law": "cycloidal"},
        {"until": 360.0},
    )
    model = Model(from_data(data))
    with pytest.raises(DesignError, match="undercut at cam angle"):
        _ = model.solid


def test_a_rib_is_judged_down_to_its_foot_and_no_deeper():
    # Seed 41: the tool reaches below the drum, where the rolled surface folds but no rib is.
    motion = program((200, 38.0, "cycloidal"), (250, None, None), (360, 0.0, "cycloidal"))
    keys = {"form": "rib", "rib_thickness": 20.0, "groove_depth": 20.0, "bore": 0.0, "length": 130.0, "start": 40.0}
    cam = pin_cam(diameter=100.0, pitch_radius=None, **keys)
    setup = pin_setup(CylinderRoller(diameter=26.0, length=18.0), motion)
    track, cutter = cam.mechanism(setup).tracks[0], cam.mechanism(setup).cutters[0]
    to_the_tip, to_the_foot = Survey(track, cutter).margin, Survey(track, cutter, cam.mechanism(setup).wall_foot).margin
    assert to_the_foot.value > to_the_tip.value
    at = to_the_foot
    foot = Flank(cutter, np.array([at.cam_angle]), np.array([at.place]), FLANKS[at.where]).points[0, 0]
    assert np.hypot(*foot[:2]) >= cam.floor_radius - 1e-9


@pytest.mark.parametrize("diameter", [9.399676072582427, 10.0, 7.7, 12.3456789])
def test_a_ball_is_known_whatever_its_diameter_rounds_to(diameter):
    # Seed 264: the tip lay a rounding short of the ball's pole, and the groove was refused.
    for depth in np.linspace(0.3, 0.45, 7) * diameter:
        cam = pin_cam(diameter=123.43966764470657, groove_depth=float(depth), pitch_radius=None)
        (cutter,) = cam.mechanism(pin_setup(SphereRoller(shape="sphere", diameter=diameter))).cutters
        assert Column(cutter, np.zeros(1)).ball_ended


def test_a_ball_swung_beside_the_axis_has_a_wall_short_of_its_pole():
    # Seed 131: no contact exists between the lowest point of the contact circle and the pole.
    data = {
        "cam": {"kind": "cylindrical", "diameter": 147.6, "length": 187.0, "start": 11.2, "groove_depth": 6.9},
        "follower": {"kind": "swinging", "arm": 417.0, "start_angle": -11.4},
        "roller": {"shape": "sphere", "diameter": 21.7, "length": 7.6},
        "motion": ({"until": 143.0, "to": 22.8, "law": "cycloidal"}, {"until": 360.0, "to": 0.0, "law": "cycloidal"}),
        "output": {"tolerance": 0.05},
    }
    model = Model(from_data(data))
    assert 0.0 < model.flanks[0].margin.value < 1.0
    assert model.solid.sound


@pytest.mark.parametrize(("start", "good"), [(-10.9, True), (-11.1, False), (120.9, True), (121.1, False)])
def test_a_groove_that_misses_the_drum_is_refused(start, good):
    # Seeds 1341, 1691: a sound solid came out, without any groove.
    setup = pin_setup(motion=program((180, None, None), (360, None, None)))
    found = [p for p in pin_cam(start=start).problems(setup) if p.key == "cam.start"]
    assert not found if good else "meets the drum" in found[0].allowed


@pytest.mark.parametrize(("length", "good"), [(3.96, True), (3.94, False)])
def test_a_ball_touches_below_the_outside_of_the_drum(length, good):
    # Seed 1621: the stretch of contact lay outside the drum and had a negative length.
    cam = pin_cam(groove_depth=1.2, pitch_radius=None)
    setup = pin_setup(SphereRoller(shape="sphere", diameter=10.3, length=length))
    found = [p for p in cam.problems(setup) if p.key == "roller.length"]
    assert bool(found) != good


def test_a_ball_is_no_roller_of_a_rib():
    cam = pin_cam(form="rib", rib_thickness=12.0)
    problems = cam.problems(pin_setup(SphereRoller(shape="sphere", diameter=30.0)))
    assert any(p.key == "roller.shape" and "form = 'rib'" in p.allowed for p in problems)


def test_clearance_of_a_groove_much_wider_than_its_roller():
    data = {
        "cam": {"kind": "cylindrical", "diameter": 134.0, "length": 110.0, "start": 40.0, "groove_depth": 13.0},
        "follower": {"kind": "translating"},
        "roller": {"diameter": 22.0, "length": 12.0},
        "motion": ({"until": 180.0, "to": 0.5, "law": "cycloidal"}, {"until": 360.0, "to": 0.0, "law": "cycloidal"}),
        "output": {"tolerance": 0.02},
    }
    for gap in (0.0, 0.3, 1.5):
        data["cam"]["running_clearance"] = gap
        (found,) = Model(from_data(data)).clearances
        # 1 mm is left below the roller's end, where the floor has no vertices but at its feet.
        assert found.value == pytest.approx(min(gap, 1.0), abs=0.021 if gap > 1.0 else 1e-6)


@pytest.mark.parametrize(("swing", "passed"), [(12.0, True), (80.0, False)])
def test_a_swinging_roller_that_leaves_the_drum_is_found(swing, passed):
    data = {
        "cam": {"kind": "cylindrical", "diameter": 100.0, "length": 200.0, "start": 100.0, "groove_depth": 10.0},
        "follower": {"kind": "swinging", "arm": 250.0, "start_angle": -0.5 * swing},
        "roller": {"diameter": 10.0, "length": 8.0},
        "motion": ({"until": 180.0, "to": swing, "law": "cycloidal"}, {"until": 360.0, "to": 0.0, "law": "cycloidal"}),
    }
    data["cam"]["start"] = 100.0 - 250.0 * np.sin(np.radians(0.5 * swing))
    (finding,) = compute(Model(from_data(data)), ("checks",), ("contact-length",)).findings
    assert finding.passed == passed
    # Its arc is centred: at both ends and in the middle the roller stands the same distance beside the cam's axis.
    aside = 0.5 * 250.0 * (1.0 - np.cos(np.radians(0.5 * swing)))
    rough = np.sqrt(50.0**2 - aside**2) - 42.0
    assert finding.value == pytest.approx(min(rough, 8.0), abs=3.0 if passed else 6.0)


def test_extremes_of_a_survey_are_those_of_its_samples():
    # Two mutants of the survey lived: the smallest relative curvature as the largest, and a factor on the sliding.
    setup = pin_setup()
    survey = Survey(pin_cam().mechanism(setup).tracks[0], pin_cam().mechanism(setup).cutters[0])
    flanks = [survey.flank(side) for side in (1.0, -1.0)]
    least = min(float(f.k_rel.min()) for f in flanks)
    most = max(float(f.k_rel.max()) for f in flanks)
    assert survey.relative_curvature.value == pytest.approx(least, rel=1e-4)
    assert survey.relative_curvature.value <= least < most <= survey.largest_relative_curvature.value * (1.0 + 1e-12)
    slide = max(float(np.hypot(*f.sliding()).max()) for f in flanks)
    assert survey.sliding.value == pytest.approx(slide, rel=1e-12)
