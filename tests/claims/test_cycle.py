"""Speed, rate and on-time of a machine's cycle against its limits, on both sides, rigid and as solved."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

import camgeom
from camgeom.checks import judge
from camgeom.checks.verdict import Finding
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from tests.places import PROFILES

TEXT = (PROFILES / "constant_width_press.toml").read_text(encoding="utf-8")
RIGID = TEXT[: TEXT.index("[impact]")]
PEAK = 0.5 * pi / (140.0 / 180.0 * pi) * 30.0 * 2.0 * pi
"""mm/s, simple harmonic motion: pi h omega / (2 phi)"""


ROCKER = 15.0 / 8.0 * 24.0 / 70.0 * 6.0 * 600.0
"""deg/s, peak of a swing by 3-4-5: 15/8 of the mean velocity"""


def found(check: str, text: str = RIGID, **limits: float) -> list[Finding]:
    told = "".join(f"{key} = {value!r}\n" for key, value in limits.items())
    return list(judge(camgeom.read(f"{text}\n[limits]\n{told}"), [check]).findings)


@pytest.mark.parametrize(
    ("check", "key", "limit", "level"),
    [
        ("velocity", "velocity", PEAK / 0.999, "pass"),
        ("velocity", "velocity", PEAK / 1.002, "fail"),
        ("velocity", "least_velocity", PEAK / 1.002, "pass"),
        ("velocity", "least_velocity", PEAK / 0.999, "fail"),
        ("cycle-rate", "cycles_per_min", 60.0 / 0.999, "pass"),
        ("cycle-rate", "cycles_per_min", 60.0 / 1.002, "fail"),
        ("on-time", "on_time", 40.0 / 360.0 / 0.999, "pass"),
        ("on-time", "on_time", 40.0 / 360.0 / 1.002, "fail"),
        ("on-time", "least_on_time", 40.0 / 360.0 / 1.002, "pass"),
        ("on-time", "least_on_time", 40.0 / 360.0 / 0.999, "fail"),
    ],
)
def test_both_sides(check: str, key: str, limit: float, level: str) -> None:
    (finding,) = found(check, **{key: limit})
    assert (finding.level, finding.limit) == (level, limit)
    assert finding.advice or level == "pass"


INDEXER = (PROFILES / "tool_changer.toml").read_text(encoding="utf-8")
INDEXER = INDEXER[: INDEXER.index("[dynamics]")]


@pytest.mark.parametrize(("limit", "level"), [(220.0 / 360.0 / 0.999, "pass"), (220.0 / 360.0 / 1.002, "fail")])
@pytest.mark.parametrize("start", [110, 40, 1, 219])
def test_a_turret_rests_between_its_steps_wherever_the_turn_begins(start: int, limit: float, level: str) -> None:
    text = INDEXER.replace("until = 110", f"until = {start}").replace("until = 250", f"until = {start + 140}")
    (finding,) = found("on-time", text, on_time=limit)
    assert (finding.level, finding.where) == (level, "dwell between steps")


@pytest.mark.parametrize(("limit", "level"), [(120.0 / 360.0 / 0.999, "pass"), (120.0 / 360.0 / 1.002, "fail")])
def test_a_turret_rests_at_every_stop_of_a_turn(limit: float, level: str) -> None:
    head, tail = INDEXER.split("[[motion]]", 1)[0], INDEXER[INDEXER.index("[operation]") :]
    steps = ((60, 0), (180, 45), (240, 0), (360, 90))
    motion = "".join(f"[[motion]]\nuntil = {until}\n" + (f'to = {to}\nlaw = "modified-sine"\n' if to else "")
                     for until, to in steps)  # fmt: skip
    (finding,) = found("on-time", head + motion + tail, on_time=limit)
    assert (finding.level, finding.value) == (level, pytest.approx(120.0 / 360.0))


def test_what_is_not_asked_for_is_not_judged() -> None:
    for check in ("velocity", "cycle-rate", "on-time"):
        assert found(check) == []


def test_the_solved_motion_is_judged_where_it_is_faster() -> None:
    whole = TEXT[: TEXT.index("[limits]")].replace("clearance = 0.02", "clearance = 0.1")
    (finding,) = found("velocity", whole, velocity=1.002 * PEAK)
    assert finding.where == "with impacts"
    assert finding.rigid == pytest.approx(PEAK)
    assert finding.value is not None
    assert finding.value > PEAK
    (least,) = found("velocity", whole, least_velocity=0.999 * PEAK)
    assert least.level == "pass"


@pytest.mark.parametrize(
    ("limits", "said"),
    [({"least_velocity": 1.002 * ROCKER}, ["fail"]), ({"least_velocity": 0.999 * ROCKER}, []),
     ({"velocity": 0.999 * ROCKER}, ["fail"]), ({"velocity": 1.002 * ROCKER}, []),
     ({"velocity": 1.5 * ROCKER, "least_velocity": 1.002 * ROCKER}, ["fail"])],
)  # fmt: skip
def test_what_the_rigid_motion_breaks_fails_without_what_no_solver_finds(
    limits: dict[str, float], said: list[str]
) -> None:
    """A roller that sinks into its cam took along that its rocker is half as fast as it has to be."""
    text = (PROFILES / "conjugate_rocker.toml").read_text(encoding="utf-8")
    text = text[: text.index("[impact]")] + '[impact]\nlaw = "power"\nstiffness = 5000\nexponent = 1.5\nturns = 3\n'
    told = "".join(f"{key} = {value!r}\n" for key, value in limits.items())
    verdict = judge(camgeom.read(f"{text}\n[limits]\n{told}"), ["velocity"])
    assert [one.level for one in verdict.findings] == said
    assert bool(said) or "sinks" in str(verdict.not_judged)


def test_without_a_speed_it_is_told() -> None:
    text = RIGID[: RIGID.index("[operation]")]
    verdict = judge(camgeom.read(f"{text}\n[limits]\nvelocity = 100\ncycles_per_min = 60\non_time = 0.5\n"),
                    ["velocity", "cycle-rate", "on-time"])  # fmt: skip
    assert {one.check for one in verdict.not_judged} == {"velocity", "cycle-rate"}
    assert [one.check for one in verdict.findings] == ["on-time"]


def test_a_rocker_is_judged_in_degrees() -> None:
    text = (PROFILES / "conjugate_rocker.toml").read_text(encoding="utf-8")
    text = text[: text.index("[impact]")]
    (finding,) = found("velocity", text, velocity=3000.0)
    assert finding.unit == "deg/s"
    assert finding.value == pytest.approx(1.875 * 24.0 / (70.0 / 360.0 * 0.1), rel=1e-9)


SHAFTS = {"kind": "indexing", "input_stiffness": 2e5, "output_stiffness": 4e4, "output_damping": 5.0,
          "contact_damping": 40.0, "cam_inertia": 0.1, "turret_inertia": 0.1, "contact_stiffness": 5e6}  # fmt: skip


def changer(limit: float, **dynamics: object) -> Model:
    data = load((PROFILES / "tool_changer.toml").read_text(encoding="utf-8"), "changer")[0]
    del data["tolerance"]
    data["operation"] |= {"speed": 400.0}
    return Model(from_data(data | {"dynamics": SHAFTS | dynamics, "limits": {"velocity": limit}}, "changer"))


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_the_load_of_an_indexing_drive_is_judged_as_it_swings(share: float, level: str) -> None:
    """The rigid turret of 1 357 deg/s passed where its load reaches 1 964."""
    study = changer(1e4).indexing
    assert study is not None
    response = study.steady
    theta = response.theta[-1] - 2.0 * pi * np.linspace(1.0, 0.0, 4001)[1:]
    rate = np.gradient(response.at(theta, "load_deviation")[0], theta) + study.motion.jet(np.mod(theta, 2.0 * pi), 1)[1]
    swung = np.degrees(np.abs(rate).max() * study.speed)
    peak = np.degrees(response.peak("load_velocity").magnitude[0])
    assert peak == pytest.approx(swung, rel=1e-4)
    (finding,) = judge(changer(share * peak), ("velocity",)).findings
    assert (finding.level, finding.where) == (level, "with vibration, of its load")
    assert finding.rigid is not None
    assert finding.rigid < 0.9 * peak


def test_a_solution_of_too_few_steps_passes_no_velocity() -> None:
    """The rigid turret's 1 357 deg/s fails below, and above it nothing is judged."""
    coarse = {"method": "wilson", "steps": 16}
    (word,) = judge(changer(1400.0, **coarse), ("velocity",)).not_judged
    assert "error of the solution" in word.reason
    (finding,) = judge(changer(1350.0, **coarse), ("velocity",)).findings
    assert (finding.level, finding.where) == ("fail", "rigid")
