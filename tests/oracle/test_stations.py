"""Several followers on one track: places, torque and distances by the oracle, lives by hand, keys on both sides."""

from __future__ import annotations

from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camgeom.checks import findings, judge
from camgeom.errors import ProfileError
from camgeom.export import write
from camgeom.export.history import impact_history, turn_history
from camgeom.model import Model
from camgeom.profile import read_data
from camgeom.report.result import compute
from camgeom.report.sections.bodies import cam_poses, follower_bodies
from tests.oracle.cams import judges_of
from tests.oracle.stations import axes, least_apart, least_to_pivot, stood, torque
from tests.places import ROOT
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


def test_followers_keep_the_clearance_that_is_asked_for() -> None:
    least = model_of("disc, roller", station=[{"angle": 30.0}]).apart.value
    assert least > 0.0
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        asked = model_of("disc, roller", station=[{"angle": 30.0}], limits={"clearance_mm": share * least})
        (found,) = findings(asked, ["followers-apart"])
        assert (found.level, found.limit) == (level, share * least)
    with pytest.raises(ProfileError, match=r"limits\.clearance_mm: means nothing here.*other followers"):
        model_of("disc, roller", limits={"clearance_mm": 1.0})


def test_the_clearance_is_a_key_of_a_slide_beside_a_groove_of_another_track() -> None:
    """2 mm are left below the roller in the groove; the rollers are far apart."""
    groove = {"form": "groove", "rim": "profile", "base_radius": 20.0, "groove_depth": 8.0}
    track = [{"angle": 90.0, "cam": groove, "roller": {"diameter": 8.0, "length": 6.0}}]
    for limit, level in ((1.9, "pass"), (2.1, "fail")):
        both = model_of("disc, roller", track=track, limits={"clearance_mm": limit})
        levels = {one.check: (one.level, one.limit) for one in findings(both, ["floor-gap", "followers-apart"])}
        assert levels == {"floor-gap": (level, limit), "followers-apart": ("pass", limit)}


PASSING: Data = {
    "cam": {"kind": "disc", "base_radius": 60.0, "width": 16.0, "bore": 25.0, "center_distance": 104.0},
    "follower": {"kind": "swinging", "arm": 66.0, "inertia": 0.01, "side": "left"},
    "roller": {"diameter": 30.0, "length": 14.0},
    "motion": [{"until": 60.0}, {"until": 150.0, "to": 14.0, "law": "modified-sine"}, {"until": 200.0},
               {"until": 300.0, "to": 0.0, "law": "modified-sine"}, {"until": 360.0}],
    "operation": {"speed": 100.0, "spring_preload": 12000.0, "spring_rate": 100.0},
    "station": [{"angle": 40.0}],
}  # fmt: skip


def to_pivot(model: Model) -> tuple[Any, ...]:
    """Level, value and place of the finding on rollers and pivots."""
    (found,) = (one for one in findings(model, ["followers-apart"]) if "pivot" in one.where)
    return found.level, found.value, found.where


@pytest.mark.parametrize("direction", ["ccw", "cw"])
@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("angles", [(40.0,), (42.0, 130.0), (320.0,)])
def test_a_roller_keeps_off_the_pivots_of_the_other_arms(side: str, direction: str, angles: tuple[float, ...]) -> None:
    data = changed(deepcopy(PASSING), cam__direction=direction, follower__side=side)
    data["station"] = [{"angle": at} for at in angles]
    model = built(data)
    wanted = least_to_pivot(data, lambda phi: model.setup.program.jet(phi, 0)[0])
    level, value, _ = to_pivot(model)
    assert value == pytest.approx(wanted, abs=1e-6)
    assert level == ("pass" if wanted > 0.0 else "warn")


def test_a_pivot_within_the_roller_of_another_follower_is_told() -> None:
    """Its axis comes within 13.07 mm of the middle of a roller of 30 mm, which is free of the other's roller."""
    model = built(PASSING)
    at = 104.0 * np.exp(1j * np.radians(40.0))
    rest = np.arccos((104.0**2 + 66.0**2 - 75.0**2) / (2.0 * 104.0 * 66.0))
    near = np.abs(104.0 + 66.0 * np.exp(1j * (np.pi - rest - np.radians(np.linspace(0.0, 14.0, 100_001)))) - at).min()
    level, value, where = to_pivot(model)
    assert near == pytest.approx(13.07, abs=5e-3)
    assert (level, value) == ("warn", pytest.approx(near - 15.0, abs=1e-6))
    assert where == "roller of follower 1 to pivot of follower 2"
    rollers, _ = findings(model, ["followers-apart"])
    assert (rollers.level, rollers.where) == ("pass", "follower 1 to follower 2")
    assert compute(model, ["contact"]).data["together"]["least_to_pivot_mm"] == pytest.approx(value)
    for share, wanted in ((0.999, "pass"), (1.002, "warn")):
        thin = changed(deepcopy(PASSING), roller__diameter=20.0, cam__base_radius=65.0)
        clear = to_pivot(built(thin))[1]
        assert clear == pytest.approx(near - 10.0, abs=1e-6)
        assert to_pivot(built(changed(deepcopy(thin), limits={"clearance_mm": share * clear})))[0] == wanted


def test_pivots_of_rockers_and_of_a_drum_s_arms_are_kept_clear() -> None:
    """A rocker's axis counts along both of its rollers; a drum's beside the roller of its own arm, and no further."""
    rocker = model_of("pair, rocker", station=[{"angle": 180.0}])
    theta = np.linspace(0.0, TURN, 20001)
    wanted = np.inf
    for track in rocker.tracks:
        point, _ = track.joint.carried(track.anchor, track.axis, track.coordinate(theta, 0))
        wanted = min(wanted, np.hypot(*(point[0][:2] + np.array(track.joint.centre[:2])[:, None])).min()
                     - 0.5 * rocker.setup.roller.diameter)  # fmt: skip
    assert rocker.apart_from_pivots.value == pytest.approx(wanted, abs=1e-6)
    drum = model_of("drum, arm", station=[{"angle": 75.0}])
    (track,), follower = drum.tracks, drum.setup.follower
    low, high = sorted(track.contact)
    turn = np.radians(follower.start_angle) + drum.setup.program.jet(theta, 0)[0]
    (_, distance, height), x = track.joint.centre, np.linspace(min(low, track.tip), high, 41)
    place = np.stack(np.broadcast_arrays(x[:, None], distance - follower.arm * np.cos(turn),
                                         height + follower.arm * np.sin(turn)))  # fmt: skip
    away = [np.inf]
    for way in (-1.0, 1.0):
        turned = stood(place.reshape(3, -1), np.radians(way * 75.0), drum.mechanism.sense)
        beyond = np.maximum(np.maximum(x[0] - turned[0], turned[0] - x[-1]), 0.0)
        away.append(np.sqrt(beyond**2 + (turned[1] - distance) ** 2 + (turned[2] - height) ** 2).min())
    thick = 12.0 + 6.5 * np.tan(np.radians(6.0))  # a cone, where it is thickest
    assert drum.apart_from_pivots.value == pytest.approx(min(away) - thick, abs=1e-3)


def test_a_roller_in_another_plane_does_not_meet_a_pivot() -> None:
    """A groove in either face: what runs in one passes below where the arm over the other one turns."""
    data = read_data(ROOT / "profiles" / "both_faces_disc.toml")
    both = built(data)
    assert both.apart_from_pivots is None
    assert both.apart is not None
    same = built({**{key: value for key, value in data.items() if key != "track"}, "station": [{"angle": 90.0}]})
    assert same.apart_from_pivots is not None


def test_curved_faces_are_parts_of_circles_and_no_rollers() -> None:
    judged = judge(model_of("disc, curved face", station=[{"angle": 40.0}]), ["followers-apart"])
    assert judged.findings == ()
    assert "faces" in judged.not_judged[0].reason


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
