"""Several followers on one track: places, torque and distances by the oracle, lives by hand, keys on both sides."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.checks import findings, judge
from camgeom.errors import ProfileError
from camgeom.export import write
from camgeom.export.history import impact_history, turn_history
from camgeom.model import Model
from camgeom.report.result import compute
from camgeom.report.sections.bodies import cam_poses, follower_bodies
from tests.oracle.cams import judges_of
from tests.oracle.stations import axes, least_apart, stood, torque
from tests.profile.cases import made
from tests.reference.profiles import built, changed

Data = dict[str, Any]
TURN = 2.0 * np.pi
NEAR: Data = {"station": [{"angle": 10.0, "mass": 2.0}]}
TWO: Data = {"station": [{"angle": 100.0, "mass": 2.0, "spring_preload": 200.0}, {"angle": 250.0, "friction": 20.0}]}


def data_of(case: str, **keys: Any) -> Data:
    return changed(made(case), **keys)


def model_of(case: str, **keys: Any) -> Model:
    return built(data_of(case, **keys))


@pytest.mark.parametrize("direction", ["ccw", "cw"])
@pytest.mark.parametrize("case", ["disc, roller", "disc, arm with roller"])
def test_every_roller_stands_on_the_cam_where_the_oracle_puts_it(case: str, direction: str) -> None:
    """As the pictures have it: the oracle's place in the machine, and in touch with the turned cam's profile."""
    stations = {"station": [{"angle": 100.0}, {"angle": 250.0}]}
    data = data_of(case, cam__direction=direction, **stations)
    model = model_of(case, cam__direction=direction, **stations)
    program, sense = model.setup.program, model.mechanism.sense
    ((ends, radius),) = axes(data, lambda phi: program.jet(phi, 0)[0])
    theta = np.radians(np.array([10.0, 77.0, 200.0, 333.0]))
    shown = [(mesh, moved) for kind, _, mesh, moved in follower_bodies(model, theta) if kind == "roller"]
    (oracle,) = judges_of(data, lambda phi: program.jet(phi, 0)[0], 0.0, 12.0, np.array([2.0, 4.0]))
    outline = model.outline(np.linspace(0.0, 6.283, 4001))
    turned = cam_poses(model.mechanism, theta)
    for (mesh, moved), angle in zip(shown, np.radians([0.0, 100.0, 250.0]), strict=True):
        low, high = (stood(end, angle, sense) for end in ends((theta - angle) % (2.0 * np.pi)))
        for k in range(len(theta)):
            placed = mesh.vertices @ moved[k, :, :3].T + moved[k, :, 3]
            middle = 0.5 * (placed.min(axis=0) + placed.max(axis=0))
            assert middle[:2] == pytest.approx(0.5 * (low + high)[:2, k], abs=1e-9)
            cam = outline @ turned[k, :2, :2].T
            assert np.hypot(*(cam - middle[:2]).T).min() == pytest.approx(radius, abs=2e-3)
    assert oracle.least(np.column_stack([outline[::400], np.full(11, 5.0)])) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("case", ["disc, roller", "pair, slide", "drum, groove"])
def test_torques_add_over_the_cam_s_angle(case: str) -> None:
    data, model = data_of(case, **TWO), model_of(case, **TWO)
    theta = np.random.default_rng(3).uniform(0.0, 2.0 * np.pi, 300)
    wanted, pulls = torque(data, model.setup.program, theta)
    fair = ~pulls if case == "disc, roller" else np.ones(300, dtype=bool)
    scale = model.camshaft.peak_torque.value
    off = np.abs(model.camshaft.at(theta[fair]) - wanted[fair]) / scale
    assert np.quantile(off, 0.99) < 1e-7
    history = turn_history(model)
    rows = np.degrees(theta[fair])[:20]
    shown = np.interp(rows, history["cam_angle_deg"], history["all_followers_torque_n_m"])
    assert shown == pytest.approx(1e-3 * wanted[fair][:20], abs=0.03e-3 * scale)
    each = [history["camshaft_torque_n_m"], *(history[f"follower_{k}.camshaft_torque_n_m"] for k in (2, 3))]
    assert sum(each) == pytest.approx(history["all_followers_torque_n_m"], abs=1e-6 * scale)


@pytest.mark.parametrize("duty", [(), ({"share": 0.5, "speed": 30.0}, {"share": 0.5})])
def test_the_shaft_is_judged_under_all_followers(duty: tuple[Data, ...]) -> None:
    """Each takes less than the limit that all of them break."""
    free = model_of("drum, groove", **NEAR, duty=duty)
    states = zip(*(one.states for one in free.bindings), strict=True)
    theta = np.linspace(0.0, TURN, 20001)
    peaks = [
        np.abs(sum(one.shaft.panels.at(one.shaft.torque, (theta - one.angle) % TURN) for one in state)).max()
        for state in states
    ]
    largest = 1e-3 * max(peaks)
    assert 1e-3 * max(one.hardest_state.shaft.peak_torque.value for one in free.bindings) < 0.95 * largest
    for share, level in ((1.002, "pass"), (0.998, "fail")):
        judged = model_of("drum, groove", **NEAR, duty=duty, limits__torque_n_m=share * largest)
        (found,) = findings(judged, ["torque"])
        assert (found.level, found.value) == (level, pytest.approx(largest, rel=1e-4))
        assert "all followers" in found.where


def test_every_follower_s_run_in_its_clearance_is_written(tmp_path: Path) -> None:
    model = model_of("drum, impact", impact__tolerance=1e-4, **NEAR)
    write(model, tmp_path / "a.impact.csv")
    with (tmp_path / "a.impact.csv").open() as file:
        heads = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",")
    assert heads[0] == "follower"
    for one in model.bindings:
        found = impact_history(one.impact, False)
        mine = rows[rows[:, 0] == one.number + 1]
        assert mine[:, heads.index("main_force_n")] == pytest.approx(found["main_force_n"])
        assert mine[0, heads.index("cam_angle_deg")] == pytest.approx(10.0 * one.number)
        speed = 6.0 * model.profile.operation.speed
        assert mine[0, heads.index("time_s")] == pytest.approx(10.0 * one.number / speed)


def test_every_follower_s_cam_lift_is_written(tmp_path: Path) -> None:
    """The heavier follower needs another correction; both stand over the cam's angle."""
    free = ("dynamics.shaft_inertia", "dynamics.shaft_stiffness", "dynamics.linkage_damping", "operation.friction")
    motion = [{"until": 180.0, "to": 12.0, "law": "5-6-7-8-9"}, {"until": 360.0, "to": 0.0, "law": "5-6-7-8-9"}]
    model = model_of("disc, elastic", **dict.fromkeys(free), motion=motion, **NEAR)
    write(model, tmp_path / "a.polydyne.csv")
    with (tmp_path / "a.polydyne.csv").open() as file:
        assert file.readline().strip() == "cam_angle_deg,cam_lift_mm,follower_2.cam_lift_mm"
        angle, *lifts = np.loadtxt(file, delimiter=",").T
    for one, lift in zip(model.bindings, lifts, strict=True):
        wanted = one.elastic_follower.corrected.jet(np.radians(angle) - one.angle, 0)[0]
        assert lift == pytest.approx(wanted, abs=1e-9)


def test_what_vibrates_alone_is_judged_by_the_sum_of_the_peaks() -> None:
    free = model_of("drum, elastic", **NEAR)
    peaks = [1e-3 * one.dynamic_torque.value for one in free.bindings]
    for limit, level in ((1.002 * sum(peaks), "pass"), (0.999 * sum(peaks), None), (0.999 * max(peaks), "fail")):
        verdict = judge(model_of("drum, elastic", **NEAR, limits__torque_n_m=limit), ["dynamic-torque"])
        assert [found.level for found in verdict.findings] == ([] if level is None else [level])
        assert [("solved alone" in one.reason) for one in verdict.not_judged] == ([True] if level is None else [])


def test_a_follower_has_the_figures_of_a_machine_of_its_own() -> None:
    model = model_of("disc, roller", **TWO)
    alone = model_of("disc, roller", follower__mass=2.0, operation__spring_preload=200.0)
    second = model.bindings[1]
    assert second.duty.peak_pressure == alone.duty.peak_pressure
    assert second.own_lives == alone.lives
    together = 1.0 / sum(1.0 / one.own_lives["cam"] for one in model.bindings)
    assert [one.lives["cam"] for one in model.bindings] == pytest.approx([together] * 3, rel=1e-12)
    assert second.lives["roller"] == alone.lives["roller"]
    assert compute(model, ["contact"]).data["together"]["cam_life_h"] == pytest.approx(together, rel=1e-12)


@pytest.mark.parametrize(("key", "value"), [
    ("mass", 2.5), ("friction", 30.0), ("spring_rate", 9.0), ("spring_preload", 300.0), ("load_mass", 1.5),
    ("gravity", 30.0), ("guide_friction", 0.4), ("force", [{"expression": "70"}]),
])  # fmt: skip
def test_every_key_of_a_station_is_its_follower_s_own(key: str, value: object) -> None:
    model = model_of("disc, roller", station=[{"angle": 90.0, key: value}])
    first, second = (one.shaft.peak_torque.value for one in model.bindings)
    assert first == model_of("disc, roller").shaft.peak_torque.value
    assert second != pytest.approx(first, rel=1e-3)


def test_rollers_that_meet_are_found() -> None:
    keys = {"station": [{"angle": 24.0}]}
    lift = model_of("disc, roller").setup.program
    wanted = least_apart(data_of("disc, roller", **keys), lambda phi: lift.jet(phi, 0)[0])
    model = model_of("disc, roller", **keys)
    assert model.apart.value == pytest.approx(wanted, abs=1e-3)
    near, far = (findings(model_of("disc, roller", station=[{"angle": at}]), ["followers-apart"])[0]
                 for at in (20.0, 30.0))  # fmt: skip
    assert (near.level, far.level) == ("fail", "pass")
    flat = judge(model_of("disc, flat face", station=[{"angle": 90.0}]), ["followers-apart"])
    assert "faces" in flat.not_judged[0].reason


def test_what_a_station_cannot_say_is_refused() -> None:
    with pytest.raises(ProfileError, match=r"station: means nothing here.*frames and turrets"):
        model_of("frame", station=[{"angle": 90.0}])
    with pytest.raises(ProfileError, match=r"station\[0\]\.inertia: means nothing here"):
        model_of("disc, roller", station=[{"angle": 90.0, "inertia": 1.0}])
    with pytest.raises(ProfileError, match=r"station\[0\]\.angle.*less than 360"):
        model_of("disc, roller", station=[{"angle": 360.0}])
    with pytest.raises(ProfileError, match=r"station\[1\]\.angle: is taken"):
        model_of("disc, roller", station=[{"angle": 90.0}, {"angle": 90.0}])
    with pytest.raises(ProfileError, match=r"station\[0\]\.guide_friction: means nothing here.*no side thrust"):
        model_of("disc, flat face", station=[{"angle": 90.0, "guide_friction": 0.1}])
    with pytest.raises(ProfileError, match=r"station\[0\]\.friction: means nothing here"):
        model_of("disc, roller", operation=None, station=[{"angle": 90.0, "friction": 1.0}])
    with pytest.raises(ProfileError, match=r"dynamics\.shaft_stiffness: couples all followers"):
        model_of("disc, elastic", station=[{"angle": 90.0}])
    with pytest.raises(ProfileError, match=r"station\[0\]\.speed: unknown key"):
        model_of("disc, roller", station=[{"angle": 90.0, "speed": 10.0}])
