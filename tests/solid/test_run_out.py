"""A drum's roller that leaves its groove through an end face: refused unless meant, and nothing judged in free air."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from tests.places import PROFILES


def segments(*rows):
    return tuple({"until": until, **({} if law is None else {"to": to, "law": law})} for until, to, law in rows)


STROKE = segments((90, 0, None), (180, 40, "cycloidal"), (270, 0, None), (360, 0, "cycloidal"))
# A kick in free air, 40 mm beyond the end face, folds a flank that does not exist there.
KICK = segments((60, 0, None), (170, 40, "cycloidal"), (176, 46, "cycloidal"), (200, 0, None), (340, 0, "cycloidal"),
                (360, 0, None))


def drum(name="pin_insertion", motion=None, pressed=None, **changes) -> Model:
    """pressed: N towards smaller lift, more than anything else there."""
    data, _, _ = load((PROFILES / f"{name}.toml").read_text(encoding="utf-8"), name)
    data["cam"] = data["cam"] | changes
    if motion is not None:
        data["motion"] = motion
        data["operation"] = {k: v for k, v in data["operation"].items() if k != "force"}
    if pressed is not None:
        data["operation"] = data["operation"] | {"force": ({"expression": str(pressed)},)}
    return Model(from_data(data, ""))


def judged(model: Model, check: str):
    return list(judge(model, [check]).findings)


def test_a_drum_shorter_than_the_stroke_fails_by_its_run_out() -> None:
    (finding,) = judged(drum(motion=STROKE, length=40, start=22), "run-out")
    assert finding.level == "fail"
    assert finding.value == pytest.approx(40 - (22 + 40 + 11), abs=1e-9)


@pytest.mark.parametrize(("room", "level"), [(0.001, "pass"), (-0.002, "fail")])
def test_the_contact_may_just_reach_the_end_face(room, level) -> None:
    (finding,) = judged(drum(motion=STROKE, length=22 + 40 + 11 + room, start=22), "run-out")
    assert (finding.level, finding.value) == (level, pytest.approx(room, abs=1e-9))


def test_a_run_out_that_is_meant_tells_where_the_roller_is_free() -> None:
    model = drum(motion=STROKE, length=40, start=22, run_out=True)
    findings = judged(model, "run-out")
    assert [finding.level for finding in findings] == ["warn", "warn", "fail"]
    findings, unheld = findings[:2], findings[2]
    assert unheld.where == "force that no wall takes"
    # The upper wall's contact stands 11 mm above the roller's centre, but for the groove's slope.
    theta = np.linspace(0.0, 2.0 * np.pi, 20001)
    beyond = 22.0 + model.setup.program.jet(theta, 0)[0] > 40.0
    for finding in findings:
        assert finding.value == pytest.approx(360.0 * beyond.mean(), abs=40.0)
    assert sum(f.value for f in findings) / 2 == pytest.approx(360.0 * beyond.mean(), abs=3.0)


def test_nothing_is_judged_in_free_air() -> None:
    meant = drum(motion=KICK, length=40, start=22, run_out=True)
    plain = drum(motion=KICK, length=110, start=22)
    assert plain.flanks[0].margin.value < 0.0 < 0.3 < meant.flanks[0].margin.value
    assert meant.pressure_angle.value < plain.pressure_angle.value
    assert {f.check for f in judge(meant).findings if f.level == "fail"} == {"run-out"}
    assert meant.solid.sound
    assert meant.duty.peak_pressure.value < np.inf
    # What happens on the drum is judged there: the same stroke on a longer drum has the same margin.
    same = drum(motion=STROKE, length=90, start=22)
    out = drum(motion=STROKE, length=89, start=22, run_out=True)
    assert out.flanks[0].margin.value == pytest.approx(same.flanks[0].margin.value, rel=1e-12)
    assert out.duty.peak_pressure.value == pytest.approx(same.duty.peak_pressure.value, rel=1e-9)


def test_no_wall_takes_a_force_where_it_is_missing() -> None:
    model = drum(motion=STROKE, length=40, start=22, run_out=True)
    duty = model.duty
    theta = duty.force.panels.theta
    deep = 22.0 - 11.0 + model.setup.program.jet(theta.ravel(), 0)[0].reshape(theta.shape) > 40.0
    assert deep.any()
    assert np.all(duty.contact_forces[0][deep] == 0.0)
    assert np.abs(duty.contact_forces).max() > 0.0


@pytest.mark.parametrize(("share", "level"), [(1.001, "pass"), (0.998, "fail")])
def test_a_force_towards_the_other_wall_holds_the_follower_where_one_is_missing(share, level) -> None:
    """Beyond the upper end the upper wall is gone: what pulls the follower up there has to be pressed back."""
    needed = drum(motion=STROKE, length=60, start=22, run_out=True, pressed=0).duty.unheld.value
    model = drum(motion=STROKE, length=60, start=22, run_out=True, pressed=share * needed)
    assert judged(model, "run-out")[-1].level == level
    assert judge(model).level == ("warn" if level == "pass" else "fail")


def test_a_run_out_that_is_not_there_is_told_and_a_rib_has_none() -> None:
    (*sides, told, force) = judged(drum(motion=STROKE, length=90, start=22, run_out=True), "run-out")
    assert [f.level for f in sides] == ["pass", "pass"]
    assert told.level == "warn"
    assert (force.level, force.value) == ("pass", 0.0)
    with pytest.raises(ProfileError, match="run_out"):
        drum(form="rib", rib_thickness=14, run_out=True)


def test_the_shipped_feeder_means_its_run_out() -> None:
    """Its balancing cylinder holds the weight and all inertia on the upper wall; without it the slider falls out."""
    told = [f for f in judged(drum("feeder_runout"), "run-out") if f.level == "warn"]
    assert [f.value for f in told] == [pytest.approx(77.5854, abs=1e-3)]
    loose = judged(drum("feeder_runout", pressed=0), "run-out")[-1]
    assert loose.level == "fail"
    assert loose.value > 1.1 * 9.81
    (finding,) = judged(drum("feeder_runout", run_out=False), "run-out")
    assert (finding.level, finding.value) == ("fail", pytest.approx(-2.0, abs=1e-6))
