"""What a verdict says: levels, margins, what is not judged, and the worst of all."""

from __future__ import annotations

from dataclasses import replace
from math import inf, nan

import numpy as np
import pytest

from camgeom.checks import NEEDS, OF_SOME, checks, judge
from camgeom.checks.verdict import Finding, NotJudged, Verdict, judged
from camgeom.model import Model, read
from camgeom.profile import from_data, parse
from camgeom.profile.text import load
from camgeom.track.flank import Flank
from tests.places import PROFILES


@pytest.mark.parametrize("file", OF_SOME)
def test_a_file_that_is_left_out_has_no_check_that_applies(file: str) -> None:
    here = [entry for entry in checks().values() if entry.judge.__module__ == f"camgeom.checks.{file}"]
    assert here
    assert all(set(entry.needs) & set(OF_SOME[file]) for entry in here)


@pytest.mark.parametrize(
    ("value", "comparison", "warn", "level", "margin"),
    [
        (0.999, "<=", None, "pass", 0.1),
        (1.002, "<=", None, "fail", -0.2),
        (0.999, "<=", 0.9, "warn", 0.1),
        (0.899, "<=", 0.9, "pass", 10.1),
        (1.001, ">=", None, "pass", 0.1),
        (0.998, ">=", None, "fail", -0.2),
        (1.001, ">=", 1.05, "warn", 0.1),
        (1.0, "<=", None, "pass", 0.0),
        (1.0, "<", None, "fail", 0.0),
        (1.0, ">", None, "fail", 0.0),
    ],
)
def test_a_value_against_its_limit(value, comparison, warn, level, margin) -> None:
    finding = judged("x", value, comparison, 1.0, "mm", "mend it", warn=warn)
    assert (finding.level, finding.passed) == (level, level != "fail")
    assert finding.margin == pytest.approx(margin, abs=1e-9)
    assert finding.advice.endswith("" if level == "pass" else "mend it")
    assert ("customary" in finding.advice) == (level == "warn")


@pytest.mark.parametrize(("value", "level", "room"), [(1.0 + 1e-12, "pass", "+0 %"), (1.0 - 1e-12, "pass", "+0 %"),
                                                      (1.0, "pass", "+0 %"), (0.994, "pass", "+1 %"),
                                                      (1.002, "fail", "-0 %"), (6.0, "warn", "-500 %")])  # fmt: skip
def test_room_of_what_passes_is_none_at_least(value: float, level: str, room: str) -> None:
    finding = replace(judged("x", 1.0, "<=", 1.0, "mm", ""), value=value, level=level)
    assert finding.room == room


def test_what_is_endless_or_no_number() -> None:
    endless = judged("life", inf, ">=", 1e4, "h", "", unlimited=True)
    assert (endless.level, endless.value, endless.shown) == ("pass", None, "unlimited")
    for value in (inf, -inf, nan):
        for comparison in ("<=", ">=", "<", ">", "=", ""):
            told = judged("gap", value, comparison, None if comparison == "" else 0.0, "mm", "mend it")
            assert (told.level, told.value, told.shown) == ("fail", None, "-")
            assert "not a finite number" in told.advice
            assert told.advice.endswith("mend it")
            if comparison != "":
                assert judged("gap", 1.0, comparison, value, "mm", "mend it").level == "fail"
                assert judged("gap", 1.0, comparison, value, "mm", "mend it").limit is None
    assert judged("life", -inf, ">=", 1e4, "h", "", unlimited=True).level == "fail"
    assert judged("life", nan, ">=", 1e4, "h", "", unlimited=True).level == "fail"
    assert judged("sag", inf, "<=", 1.0, "mm", "", unlimited=True).level == "fail"
    assert judged("stops", nan, "<=", 1.0, "1", "", worst="warn").level == "warn"


def test_the_verdict_is_the_worst_and_says_what_was_left_out() -> None:
    good, warns = judged("a", 1.0, "<=", 2.0, "mm", ""), judged("b", 1.9, "<=", 2.0, "mm", "", warn=1.0)
    bad = judged("c", 3.0, "<=", 2.0, "mm", "")
    assert Verdict(()).level == "pass"
    assert Verdict((good,)).sentence == "PASS, 1 findings"
    assert Verdict((good,), (NotJudged("d", "why"),)).sentence == "PASS of what was judged, 1 findings; 1 not judged"
    assert Verdict((good, warns)).sentence == "WARN, 1 of 2 findings"
    assert Verdict((good, warns, bad)).sentence == "FAIL, 1 of 3 findings"
    assert Verdict((good, warns, bad)).closest is warns


def test_every_need_of_a_check_is_known() -> None:
    for entry in checks().values():
        assert set(entry.needs) <= set(NEEDS), entry.name


def without(name: str, *sections: str) -> Model:
    data, _, _ = load((PROFILES / f"{name}.toml").read_text(encoding="utf-8"), "")
    return Model(from_data({key: value for key, value in data.items() if key not in sections}, ""))


@pytest.mark.parametrize(
    ("name", "check"),
    [("pin_insertion", "contact-pressure"), ("disc_flat_face", "face-pressure"), ("tool_changer", "turret-pressure")],
)
def test_a_design_without_a_load_is_told_what_was_not_judged(name: str, check: str) -> None:
    verdict = judge(without(name, "operation", "dynamics", "impact"), [check])
    assert verdict.findings == ()
    assert [word.check for word in verdict.not_judged] == [check]
    assert "operation" in verdict.not_judged[0].reason
    judged_now = judge(read(str(PROFILES / f"{name}.toml")), [check])
    assert [f.check for f in judged_now.findings] == [check]
    assert judged_now.not_judged == ()


def test_a_pressure_angle_beyond_the_customary_warns_though_the_limit_holds() -> None:
    (finding,) = judge(read(str(PROFILES / "pin_insertion.toml")), ["pressure-angle"]).findings
    assert isinstance(finding, Finding)
    assert (finding.level, finding.limit, finding.comparison) == ("warn", 70.0, "<=")
    assert finding.margin == pytest.approx(100.0 * (70.0 - 65.580914) / 70.0, abs=1e-4)


def test_what_is_brought_near_its_limit_by_choice_is_not_the_closest() -> None:
    angle = judged("pressure-angle", 29.9, "<=", 30.0, "deg", "")
    hardness = judged("hardness", 2450.0, "<=", 2450.0, "MPa", "")
    stops = judged("stops", 4.0, ">=", 4.0, "stops", "")
    wall = judged("wall", 2.0, ">=", 1.0, "mm", "")
    assert Verdict((hardness, stops, wall, angle)).closest is angle
    assert Verdict((hardness, stops)).closest is None


STEEP = """
[cam]
kind = "disc"
base_radius = 22
width = 14
[follower]
kind = "translating"
mass = 1
[roller]
shape = "cylinder"
diameter = 16
length = 12
[[motion]]
until = 90
to = 30
law = "modified-sine"
[[motion]]
until = 150
[[motion]]
until = 260
to = 0
law = "3-4-5"
[[motion]]
until = 360
[operation]
speed = 200
spring_rate = 5
spring_preload = 300
[limits]
life_h = 1e-6
"""


@pytest.mark.parametrize(("share", "jams"), [(0.999, False), (1.002, True)])
def test_a_follower_that_jams_is_one_finding(share: float, jams: bool) -> None:
    """The guides hold the follower from mu = 1 / tan(pressure angle) on: `load` tells it, and what is judged by the
    load is not judged; asked alone it fails."""
    flank = Flank(Model(parse(STEEP)).mechanism.tracks[0], np.linspace(0.0, 0.5 * np.pi, 20_001), np.zeros(1), 1.0)
    limit = 1.0 / float(np.abs(np.tan(flank.pressure_angle("axis"))).max())
    model = Model(parse(STEEP.replace("[limits]", f"guide_friction = {share * limit!r}\n[limits]")))
    verdict = judge(model)
    by_load = {"contact-kept", "contact-pressure", "life", "wear"}
    fails = {one.check for one in verdict.findings if one.level == "fail"}
    assert ("load" in fails) == jams
    assert not jams or fails == {"load", "pressure-angle"}
    assert by_load.isdisjoint({one.check for one in verdict.not_judged}) != jams
    (alone,) = [one.level for one in judge(model, ["contact-kept"]).findings]
    assert alone == ("fail" if jams else "pass")
