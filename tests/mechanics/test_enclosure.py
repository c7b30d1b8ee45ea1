"""Poles and narrow peaks of forces: refused or found, whatever samples see; enclosures hold what they enclose."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import camgeom
from camgeom.cams import starter
from camgeom.errors import ProfileError
from camgeom.maths import Floats
from camgeom.mechanics import enclosure
from camgeom.mechanics.applied import FUNCTIONS, Step, compile_expression, moving
from camgeom.mechanics.enclosure import RESOLVED, enclosed, narrow_peaks
from camgeom.profile import read_data
from tests.places import PROFILES

LEAVES = st.sampled_from(["phi", "deg", "theta", "2", "0.3", "7", "pi", "-1.5"])


def _grown(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    one = st.sampled_from(sorted(name for name, (_, least, _) in FUNCTIONS.items() if least == 1))
    two = st.sampled_from(["atan2", "hypot", "min", "max"])
    return st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from("+-*/"), inner),
        st.builds("({} ** {})".format, inner, st.sampled_from(["2", "3", "-1", "-2", "0.5", "1.5", "0"])),
        st.builds("{}({})".format, one, inner),
        st.builds("{}({}, {})".format, two, inner, inner),
        st.builds("(-{})".format, inner),
    )


@given(
    text=st.recursive(LEAVES, _grown, max_leaves=8), low=st.floats(0.0, 6.2), width=st.floats(1e-6, 0.05),
)  # fmt: skip
def test_every_value_lies_in_its_enclosure(text: str, low: float, width: float) -> None:
    value = compile_expression(text)
    phi = np.linspace(low, low + width, 41)
    with np.errstate(all="ignore"):
        found = np.broadcast_to(value.of({"phi": phi, "theta": phi, "deg": np.degrees(phi)}), phi.shape)
    least, most = (float(end[0]) for end in enclosed(value.steps, np.array([low]), np.array([low + width])))
    finite = found[np.isfinite(found)]
    # Rounding of either: of angles, and of what is subtracted.
    slack = 1e-9 * max(1.0, float(np.abs(finite).max(initial=0.0)))
    assert not (finite < least - slack).any(), (least, finite.min())
    assert not (finite > most + slack).any(), (most, finite.max())
    # Where there is none, they say that there may be none.
    assert np.isfinite(found).all() or not (math.isfinite(least) and math.isfinite(most))


def peaks(text: str, begin: float, length: float) -> tuple[float, ...]:
    """From a cam angle on, deg."""
    return narrow_peaks(compile_expression(text), math.radians(begin), math.radians(length))


def pressed(expression: str, begin: float = 80.0, until: float = 110.0) -> camgeom.Model:
    data: dict[str, Any] = read_data(PROFILES / "disc_offset_roller.toml")
    force = {"from": begin, "until": until, "expression": expression}
    return camgeom.read({**data, "operation": {**data["operation"], "force": (force,)}})


@pytest.mark.parametrize(
    ("expression", "angle"),
    [
        ("0.01/abs(phi-1.66667)", "95.493"), ("1e-9/(phi-1.66666666666667)", "95.493"), ("1e-3/(phi-1.7)**2", "97.40"),
        ("tan(phi)", "90"), ("5/sin(10*(phi-1.6))", "91.67"), ("1/(phi-1.5)**3 - 1/(phi-1.55)", "88.8|85.9"),
        ("1e6*exp(-((phi-1.6637)/1e-5)**2)", "95.32"), ("0.01/abs(phi-1.66667)+0*s", "95.493"), ("100/(s-18.5)", "8"),
        ("30/(v-400)", "9"), ("1/log(phi-0.6)", "91.67"),
        ("100+0.01/abs(deg-98.03351)+(deg**6-deg**6)", "98.03"), ("200+tan(phi)-1e-3/(deg-100)", "90|100"),
    ],
)  # fmt: skip
def test_a_pole_is_refused_with_its_angle(expression: str, angle: str) -> None:
    """A force of 0.01/|phi - c| passed with 915 N, one of 1e6 N in a hundredth of a degree was not seen."""
    told = rf"force\[0\]\.expression: has a pole, or a peak narrower .* at cam angle ({angle})"
    with pytest.raises(ProfileError, match=told):
        pressed(expression)


@pytest.mark.parametrize("width", [6e-4, 1e-3, 3e-3, 0.02])
@pytest.mark.parametrize("centre", [1.55, 1.6612345, 1.7])
def test_a_narrow_peak_is_found(width: float, centre: float) -> None:
    without = float(pressed("0").load.sampled().force.max())
    found = pressed(f"1e4*exp(-((phi-{centre})/{width})**2)").load.sampled().force.max()
    assert found == pytest.approx(1e4 + 0.5 * without, abs=0.6 * without)


@pytest.mark.parametrize(
    "expression",
    ["sin(phi-1.6)/(phi-1.6)", "100*s+v", "40", "1000*(1-cos(phi-1.57))/(phi-1.57)**2",
     "12.1-0.3*deg+0.02*deg**2-3e-4*deg**3+2e-6*deg**4-6e-9*deg**5+6.1e-12*deg**6",
     "120 * sin(6 * (phi - 80 * pi / 180)) ** 2", "30*phi**7-200*phi**6+5*phi**3", "log(phi)", "exp(3*phi)"],
)  # fmt: skip
def test_what_is_bounded_is_left_as_it_is(expression: str) -> None:
    """So is a place of 0/0 beside which nothing grows; forces of the motion are not looked into."""
    assert peaks(expression, 80.0, 30.0) == ()
    assert np.isfinite(pressed(expression).load.sampled().force).all()


@pytest.mark.parametrize(
    ("expression", "places"),
    [("sign(phi-1.6)*30", [1.6]), ("floor(10*phi)", [1.4, 1.5, 1.6, 1.7, 1.8, 1.9]), ("30*tanh(1e12*(phi-1.7))", [1.7]),
     ("asin(sin(phi))", [0.5 * math.pi]), ("500-sign(phi-1.6)", [1.6])],
)  # fmt: skip
def test_panels_end_where_a_force_jumps_or_has_a_corner(expression: str, places: list[float]) -> None:
    """Panels swung beside a jump: a step of 20 000 N was told with 22 598, and one of 500 N lost a contact that 15 N
    kept."""
    found = np.array(peaks(expression, 80.0, 30.0))
    assert all(np.abs(found - place).min() < 5e-3 for place in places), found
    assert all(np.abs(np.array(places) - one).min() < 0.01 for one in found), found
    force, value = pressed(expression).load, compile_expression(expression)
    beside = np.array([place + 1e-7 * side for place in places for side in (-1.0, 1.0)])
    sampled, free = force.sampled(), pressed("0").load.sampled()
    change = sampled.panels.at(sampled.force, beside) - free.panels.at(free.force, beside)
    assert change == pytest.approx(value(beside), abs=0.3)


@pytest.mark.parametrize(
    ("pulse", "size"),
    [("-500-24.5*max(0,sign(deg-{0}))*max(0,sign({0}+0.33-deg))", 24.5), ("-9900-400*exp(-((deg-{0})/0.02)**2)", 400.0),
     ("-9900-19*exp(-((deg-{0})/0.02)**2)", 19.0), ("(20-s)**3-390*exp(-((deg-{0})/0.02)**2)", 390.0),
     ("-500-0.3*max(0,1-abs(deg-{0})/0.1)", 0.3)],
)  # fmt: skip
@pytest.mark.parametrize("place", [330.05, 330.31, 330.62])
def test_a_pulse_beside_a_constant_however_large_is_found(pulse: str, size: float, place: float) -> None:
    """Up to a twentieth of what one expression gives there was left: -9.5 N at the contact passed as 10, as large
    forces held each other."""
    text = pulse.format(place)
    data: dict[str, Any] = read_data(PROFILES / "disc_offset_roller.toml")
    force = {"from": 320.0, "until": 340.0}

    def least(expression: str) -> float:
        operation = {**data["operation"], "force": ({**force, "expression": expression},)}
        sampled = camgeom.read({**data, "operation": operation}).load.sampled()
        within = np.abs(np.degrees(sampled.panels.theta) - 330.0) < 9.0
        return float(sampled.force[within].min())

    without = text[: text.rindex("-", 0, text.index("max(" if "max(" in text else "exp("))]
    assert least(without) - least(text) == pytest.approx(size, rel=0.02, abs=0.02)


@pytest.mark.parametrize("text", ["1/(phi-1.8)", "sign(deg-50)", "5*exp(-((deg-100)/0.01)**2)"])
@pytest.mark.parametrize("end", [math.nextafter(100.0, 200.0), 100.00000000000001, 100.0000000000001, 100.000001])
def test_a_range_of_hardly_any_length_has_no_peak(text: str, end: float) -> None:
    assert peaks(text, 100.0, end - 100.0) == ()


@pytest.mark.parametrize("expression", ["1000*exp(30*(deg-110))", "1000*exp(30*(80-deg))", "tan(phi-0.4)"])
def test_a_steep_end_is_followed(expression: str) -> None:
    assert len(peaks(expression, 80.0, 30.0)) >= 3
    assert np.isfinite(pressed(expression).load.sampled().force).all()


@pytest.mark.parametrize(
    ("expression", "begin", "until"),
    [("100+50000*exp(-((deg-200)/0.002)**2)", 0.0, 200.0), ("100+50000*exp(-((deg-20)/0.002)**2)", 20.0, 200.0),
     ("100+0.01/(200.3-deg)", 0.0, 200.3), ("100+5000*exp(-deg/0.001)", 0.0, 360.0), ("100*tan(phi/4)", 0.0, 360.0),
     ("100+5000*exp((deg-360)/0.001)", 0.0, 360.0), ("100+0.001/(360-deg)**2", 0.0, 360.0),
     ("20-3000*exp((deg-300)/0.001)", 200.0, 300.0)],
)  # fmt: skip
def test_a_pole_or_peak_at_an_end_of_the_range_is_refused(expression: str, begin: float, until: float) -> None:
    """The outermost sample stood on it: one of 50 000 N passed with 240, a pole with 352."""
    with pytest.raises(ProfileError, match="has a pole, or a peak narrower"):
        pressed(expression, begin, until)


def test_a_pull_in_a_quiet_stretch_is_found_beside_a_stroke_twenty_times_as_hard() -> None:
    """A twentieth of the largest force anywhere was left: contact was lost, and kept by the check."""
    stroke = "12500*min(1,max(0,(deg-125)/10))*min(1,max(0,(145-deg)/10))"
    for size in (0.0, 600.0):
        sampled = pressed(f"{stroke}-{size}*exp(-((deg-300.22)/0.02)**2)", 0.0, 360.0).load.sampled()
        pulled = np.abs(np.degrees(sampled.panels.theta) - 300.22) < 0.03
        quiet = np.abs(np.degrees(sampled.panels.theta) - 301.0) < 0.7
        fallen = float(np.median(sampled.force[quiet])) - float(sampled.force[pulled | quiet].min())
        assert fallen == pytest.approx(size, rel=0.02, abs=5.0)


PEAKS = [
    ("20+0.5*s+60000*exp(-((deg-200.3)/0.03)**2)", 60000.0), ("40000*max(0,1-abs(s-13.137)/0.02)", 40000.0),
    ("100+3000*exp(-((s-13.137)/0.02)**2)", 3000.0), ("100+3000*exp(-((a-8000)/10)**2)", 3000.0),
]  # fmt: skip


@pytest.mark.parametrize(("expression", "size"), PEAKS)
@pytest.mark.parametrize("place", ["operation", "duty", "station", "track"])
def test_a_peak_that_hangs_on_the_motion_is_found(expression: str, size: float, place: str) -> None:
    """They were looked for, and forgotten: 170 N of 63 442 passed."""
    force = {"expression": expression}
    if place in ("operation", "duty"):
        data: dict[str, Any] = tomllib.loads(starter("disc"))
        if place == "duty":
            data["duty"] = [{"share": 1.0, "force": [force]}]
        else:
            data["operation"]["force"] = [force]
    else:
        data = tomllib.loads(starter("cylindrical"))
        if place == "station":
            data["station"] = [{"angle": 90.0, "force": [force]}]
        else:
            data["cam"]["length"] = 160.0
            data["track"] = [{"cam": {"start": 100.0}, "operation": {"force": [force]}}]
    model = camgeom.read(data)
    models = [model, *model.bindings, *model.states]
    peak = max(float(np.abs(one.load.sampled().force).max()) for one in models)
    assert 0.97 * size < peak < 1.5 * size


def test_a_pulse_beside_a_joint_of_the_motion_is_found() -> None:
    """Of a range with a joint in it no peak was kept, as a panel ends there: 990 N were 160."""
    data: dict[str, Any] = read_data(PROFILES / "disc_offset_roller.toml")
    begin, wide, height, back = 5.456719002761414, 0.4654596098975337, 0.046545960989753374, 46.45499749214443
    motion = ({"until": begin}, {"until": begin + wide, "to": height, "law": "3-4-5"}, {"until": begin + wide + 20.0},
              {"until": begin + wide + 20.0 + back, "to": 0.0, "law": "double-harmonic"}, {"until": 360.0})  # fmt: skip
    force = {"from": float(np.degrees(0.047618856477164115)), "until": float(np.degrees(0.12081480820203186)),
             "expression": "500.0*(sign(a+27364.6993386+17384.6)-sign(a+27364.6993386-17384.6))+0.001*a"}  # fmt: skip
    operation = {**data["operation"], "speed": 60.0, "force": (force,)}
    (applied,) = camgeom.read({**data, "motion": motion, "operation": operation}).load.applied
    angle = np.array(applied.breaks)
    program = camgeom.read({**data, "motion": motion}).setup.program
    assert applied(angle, *moving(program, 2.0 * np.pi, angle)).max() > 950.0


@pytest.mark.parametrize("law", ["simple-harmonic", "parabolic", "3-4-5"])
@pytest.mark.parametrize("rise", [0.03, 1.0, 100.0])
@pytest.mark.parametrize("expression", ["12*tanh(v)", "12*tanh(v/5)", "2*sqrt(abs(v))", "0.01*a", "12*v/(1+abs(v))"])
@pytest.mark.parametrize("whole", [True, False])
def test_friction_that_soon_has_its_value_is_no_pole_at_an_end(
    law: str, rise: float, expression: str, whole: bool
) -> None:
    """An end where it is as small as elsewhere, or as outside its range, was told as a peak of 0.08 N."""
    data: dict[str, Any] = read_data(PROFILES / "disc_offset_roller.toml")
    motion = ({"until": rise, "to": 0.2 * rise, "law": law}, {"until": 150.0},
              {"until": 250.0, "to": 0.0, "law": law}, {"until": 360.0})  # fmt: skip
    force = {"from": 0.0, "until": 360.0 if whole else rise, "expression": expression}
    changed = {**data, "motion": motion, "operation": {**data["operation"], "speed": 3000.0, "force": (force,)}}
    assert np.isfinite(camgeom.read(changed).load.sampled().force).all()


@pytest.mark.parametrize("start", [100.1, 100.15, 100.28, 100.4, 100.6, 300.05])
@pytest.mark.parametrize(
    ("expression", "told"),
    [("30000*exp(-((a-4e4)/100)**2)", True), ("30000*exp(-((v-0.4)/0.001)**2)", True),
     ("0.8*a", False), ("30000*exp(-((a-9e4)/100)**2)", False)],
)  # fmt: skip
def test_a_move_of_a_tenth_of_a_degree_is_looked_into(start: float, expression: str, told: bool) -> None:
    """Of two places half a degree apart neither saw it: 30 kN passed as 4, by where the move lay."""
    moves = ((start, 0.0), (start + 0.1, 1e-5), (start + 0.2, 0.0), (360.0, 0.0))
    data: dict[str, Any] = read_data(PROFILES / "disc_offset_roller.toml")
    motion = tuple({"until": until, "to": to, "law": "3-4-5"} if 0 < k < 3 else {"until": until}
                   for k, (until, to) in enumerate(moves))  # fmt: skip
    force = {"from": 90.0, "until": 350.0, "expression": expression}
    changed = {**data, "motion": motion, "operation": {**data["operation"], "speed": 600.0, "force": (force,)}}
    if told:
        with pytest.raises(ProfileError, match="has a pole, or a peak narrower"):
            camgeom.read(changed)
        return
    # The acceleration of the move reaches 10 / sqrt(3) times its height over the square of its time.
    most = 10.0 / np.sqrt(3.0) * 1e-5 / (0.1 / 360.0 / 10.0) ** 2
    assert 4e4 < most < 9e4
    found = float(camgeom.read(changed).load.sampled().force.max())
    assert (found > 0.8 * most) == ("0.8" in expression)


def test_what_swings_is_followed_as_far_as_tables_are() -> None:
    """Rows of tables were counted, swings of expressions not: 4 GB, and no end."""
    with pytest.raises(ProfileError, match=r"force\[0\]\.expression: swings too often .* at most 9000 panels"):
        pressed("100+1000*sin(70*deg)", 0.0, 360.0)
    data = tomllib.loads(starter("cylindrical"))
    data["station"] = [{"angle": 60.0 * k} for k in range(1, 6)]
    states = [{"speed": 200.0 + k, "share": 0.05, "force": [{"expression": f"100+{40 + k}*sin(15*deg)"}]}
              for k in range(20)]  # fmt: skip
    with pytest.raises(ProfileError, match=r"rows or swings of forces, .* 40000"):
        camgeom.read({**data, "duty": states})
    for state in states:
        state["force"] = [{"expression": "100+40*sin(phi)"}]
    assert len(camgeom.read({**data, "duty": states}).states) == 20


def test_a_force_of_all_states_is_named_where_it_stands() -> None:
    data = tomllib.loads(starter("disc"))
    data["operation"]["force"] = [{"expression": "30/(v-10)"}]
    data["duty"] = [{"share": 0.5, "speed": speed} for speed in (100.0, 200.0)]
    with pytest.raises(ProfileError) as told:
        camgeom.read(data)
    assert {problem.key for problem in told.value.problems} == {"operation.force[0].expression", "operation.speed"}


@pytest.mark.parametrize("size", [990.0, 1000.0, 1100.0])
@pytest.mark.parametrize("centre", [95.1037, 97.4028, 96.0])
@pytest.mark.parametrize("width", [0.012, 0.02, 0.1])
def test_a_peak_is_found_beside_a_force_as_large(size: float, centre: float, width: float) -> None:
    """One of -990 N, 0.033 degrees wide, was passed by beside 1000 N elsewhere."""
    text = f"1000*max(0,sign(deg-115))*max(0,sign(140-deg))-{size}*exp(-((deg-{centre})/{width})**2)"
    held, alone = (pressed(one, 0.0, 360.0).load.sampled() for one in (text, "0"))
    low = float(held.force.min()) - float(alone.force.min())
    assert -1.05 * size < low < -0.7 * size


def test_what_cannot_be_enclosed_is_left_in_time(monkeypatch: pytest.MonkeyPatch) -> None:
    looked, of = list[int](), enclosure.enclosed

    def counted(steps: Sequence[Step], low: Floats, *rest: Any) -> enclosure.Range:
        looked.append(len(low))
        return of(steps, low, *rest)

    monkeypatch.setattr(enclosure, "enclosed", counted)
    assert peaks("1/((deg-deg)+1e-9)", 0.0, 360.0) == ()
    assert enclosure.MOST_POLES < sum(looked) < 3 * enclosure.MOST_POLES


@pytest.mark.parametrize("text", ["100+0*sqrt(abs(phi-1.6)-1e-5)", "asin(1.00001*sin(phi))", "log(abs(phi-1.6)-1e-4)"])
def test_an_angle_without_a_value_is_told(text: str) -> None:
    with pytest.raises(ProfileError, match=r"has no finite value at cam angle (89|9[01])"):
        pressed(text)


def test_a_range_past_the_turn_s_end_is_looked_through() -> None:
    text = "1e5*exp(-((deg-2)/0.05)**2)"
    first, *_, last = peaks(text, 300.0, 100.0)
    assert math.radians(1.0) < first < math.radians(2.0) - RESOLVED
    assert math.radians(2.0) + RESOLVED < last < math.radians(3.0)
    with pytest.raises(ProfileError, match="at cam angle 2 deg"):
        peaks("1/(deg-2)", 300.0, 100.0)
    assert peaks(text, 300.0, 50.0) == ()
    assert peaks("1/(phi-7)", 0.0, 360.0) == ()
