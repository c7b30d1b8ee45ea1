"""Play of followers that are driven both ways: bounded by a running fit or a key, and told where nothing solves it."""

from __future__ import annotations

from math import cbrt, radians, sqrt
from typing import Any

import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.checks.play import loose_fit
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.tolerance.fits import BELOW_C, C_SIZES, limits
from tests.places import PROFILES

YOKE = {"roller": {"diameter": 16.0, "length": 10.0}}
CASES: dict[str, tuple[str, str, float, float]] = {
    "frame": ("constant-width", "follower.clearance", 1.0, 110.0),
    "yoke": ("constant-width", "follower.clearance", 1.0, 110.0),
    "pair": ("conjugate", "follower.clearance", 1.0, 40.0),
    "drum": ("cylindrical", "cam.running_clearance", 2.0, 19.0),
    "face groove": ("disc_face_groove", "cam.running_clearance", 2.0, 25.0),
    "globoid": ("globoidal", "cam.running_clearance", 2.0, 30.0),
    "barrel": ("cylindrical-index", "cam.running_clearance", 2.0, 26.0),
    "plates": ("parallel-index", "cam.running_clearance", 2.0, 26.0),
}
"""starter or profile, the key of its play, plays from wall to wall in one of the key, and the size of the fit, mm"""


def made(case: str, gap: float, **changed: dict[str, Any]) -> Model:
    name, key, _, _ = CASES[case]
    text = (PROFILES / f"{name}.toml").read_text() if "_" in name else starter(name)
    data = load(text, name)[0]
    if case == "yoke":
        data |= YOKE
        del data["follower"]["face_width"]
    section, field = key.split(".")
    for part, keys in {section: {field: gap}, **changed}.items():
        data[part] = {**data.get(part, {}), **keys}
    return Model(from_data(data, name))


@pytest.mark.parametrize("case", CASES)
def test_play_beyond_a_loose_running_fit_is_told(case: str) -> None:
    _, _, share, size = CASES[case]
    limit = loose_fit(size)
    for by, level in ((0.999, "pass"), (1.002, "warn")):
        verdict = judge(made(case, by * limit / share), ["play"])
        (found,) = verdict.findings
        assert (found.level, found.limit) == (level, pytest.approx(limit))
        assert found.value == pytest.approx(by * limit)
        assert len(verdict.not_judged) == (level == "warn")
        assert all("impact" in word.reason for word in verdict.not_judged)


@pytest.mark.parametrize("case", CASES)
def test_the_key_bounds_it_and_says_what_is_meant(case: str) -> None:
    share = CASES[case][2]
    for by, level in ((0.999, "pass"), (1.002, "fail")):
        for limit in (0.05, 2.0):
            model = made(case, by * limit / share, limits={"play_mm": limit})
            (found,) = judge(model, ["play"]).findings
            assert (found.level, found.limit) == (level, limit)


def test_where_impacts_are_solved_nothing_is_left_unjudged() -> None:
    verdict = judge(made("pair", 8.0, impact={"turns": 2}), ["play"])
    assert [f.level for f in verdict.findings] == ["warn"]
    assert verdict.not_judged == ()


def test_what_a_spring_holds_on_its_cam_has_no_play() -> None:
    data = load(starter("disc"), "")[0]
    assert judge(Model(from_data(data, "")), ["play"]).findings == ()
    with pytest.raises(ProfileError, match=r"limits\.play_mm.*no play"):
        from_data(data | {"limits": {"play_mm": 0.1}}, "")


@pytest.mark.parametrize(
    ("size", "table"),
    [(3.0, 180), (3.01, 220), (30.0, 370), (30.01, 440), (40.0, 440), (40.01, 450), (50.0, 450), (72.0, 530),
     (110.0, 620), (150.0, 710), (225.0, 840), (225.01, 860), (300.0, 970), (380.0, 1120), (500.0, 1280)],
)  # fmt: skip
def test_the_fit_is_that_of_the_tables(size: float, table: float) -> None:
    """ISO 286-2, H11/c11, um: the largest clearances of the preferred fits, by steps of sizes."""
    assert loose_fit(size) == pytest.approx(1e-3 * table, rel=1e-12)


def test_the_table_follows_the_formulas_it_was_made_by() -> None:
    """ISO 286-1, annex: IT11 is 100 (0.45 D^(1/3) + 0.001 D) um, c above 40 mm is 95 + 0.8 D um.

    D is the geometric mean of a step, of IT11's wider one where two share it; both are rounded.
    """
    wide = (3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0, 180.0, 250.0, 315.0, 400.0, 500.0)
    ends = dict(zip(wide[1:], wide))
    for low, high, below in list(zip(C_SIZES, C_SIZES[1:], BELOW_C[1:]))[3:]:
        grade = 1e3 * limits("H11", high)[1]
        top = min(end for end in wide if end >= high)
        mean, own = sqrt(ends[top] * top), sqrt(low * high)
        assert grade == pytest.approx(100.0 * (0.45 * cbrt(mean) + 0.001 * mean), rel=0.03)
        assert high <= 40.0 or below == pytest.approx(95.0 + 0.8 * own, rel=0.03)


def test_beyond_the_table_the_fit_grows_no_more() -> None:
    assert loose_fit(2000.0) == loose_fit(500.0)
    assert all(loose_fit(high + 1e-9) >= loose_fit(high) for high in C_SIZES)


@pytest.mark.parametrize("kind", ["globoidal", "cylindrical-index"])
def test_a_relief_is_play_at_the_ends_of_dwells(kind: str) -> None:
    """Both flanks stand back by the relief there, on a globoid by its share at the flank's foot."""
    data = load(starter(kind), kind)[0]
    for relief, level in ((0.05, "pass"), (5.0, "warn")):
        data["cam"] |= {"relief": relief}
        (found,) = judge(Model(from_data(data, kind)), ["play"]).findings
        assert found.level == level
        assert found.value is not None
        assert 2.0 * relief <= found.value < 2.4 * relief


def test_flanks_that_stand_back_have_no_preload() -> None:
    data = load(starter("globoidal"), "globoidal")[0]
    data["cam"] |= {"preload": 0.02}
    from_data(data, "globoidal")
    data["cam"] |= {"running_clearance": 0.001}
    with pytest.raises(ProfileError, match=r"cam.preload.*running_clearance"):
        from_data(data, "globoidal")


@pytest.mark.parametrize(("share", "answer"), [(0.998, "pass"), (1.002, "not judged")])
def test_a_dwell_holds_no_band_that_its_play_exceeds(share: float, answer: str) -> None:
    data = load((PROFILES / "tool_changer.toml").read_text(), "tool changer")[0]
    radius, band = data["follower"]["pitch_radius"], 0.1
    data["dynamics"] |= {"settling_band": band}
    data["cam"] |= {"running_clearance": 0.5 * share * radians(band) * radius}
    verdict = judge(Model(from_data(data, "tool changer")), ["settling"])
    said = [f.level for f in verdict.findings] + ["not judged" for _ in verdict.not_judged]
    assert said == [answer]


def test_what_does_not_settle_fails_whatever_its_play() -> None:
    data = load((PROFILES / "tool_changer.toml").read_text(), "tool changer")[0]
    data["dynamics"] |= {"settling_band": 1e-6}
    data["cam"] |= {"running_clearance": 0.05}
    verdict = judge(Model(from_data(data, "tool changer")), ["settling"])
    assert [f.level for f in verdict.findings] == ["fail"]
