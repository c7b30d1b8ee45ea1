"""Checks that ask the solved forces, not the rigid ones: run-outs without a wall, crowns longer than their rollers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.dynamics.impact import solver
from camgeom.errors import NotConverged, ProfileError
from camgeom.maths import Floats
from camgeom.mechanics.hertz import point_contact
from camgeom.model import Model
from camgeom.model.vibration import KnownForce
from camgeom.profile import from_data
from camgeom.profile.text import load
from tests.places import PROFILES


def feeder(balance: float) -> Model:
    """The feeder with its slider's vibration, lifted by a cylinder of so many N."""
    data = load((PROFILES / "feeder_runout.toml").read_text(), "feeder")[0]
    data["operation"]["force"] = ({**data["operation"]["force"][0], "expression": f"-{balance}"},)
    data["cam"] |= {"start": 6}
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 300, "linkage_damping": 20, "settling_band": 0.5}
    return Model(from_data(data, "feeder"))


def test_a_vibration_that_presses_where_no_wall_is_fails_though_the_rigid_force_does_not() -> None:
    verdict = judge(feeder(75.0), ("run-out", "dynamic-run-out"))
    levels = {(found.check, found.unit): found.level for found in verdict.findings}
    assert levels["run-out", "N"] == "pass"
    assert levels["dynamic-run-out", "N"] == "fail"
    held = judge(feeder(200.0), ("dynamic-run-out",)).findings
    assert [found.level for found in held] == ["pass"]


def crowned(clearance: float, **impact: Any) -> Model:
    data = load(starter("cylindrical"), "drum")[0]
    data["roller"] |= {"shape": "crowned", "crown_radius": 500.0, "flank": "straight"}
    data["cam"] |= {"running_clearance": 0.5 * clearance}
    data["impact"] = {"turns": 4, "settle": 2, **impact}
    return Model(from_data(data, "drum"))


def test_a_crown_is_asked_under_the_impacts() -> None:
    """The longest ellipse grows with the cube root of the force, as the pressure does."""
    made = crowned(0.2)
    (rigid,) = judge(made, ("crown-length",)).findings
    (struck,) = judge(made, ("impact-crown-length",)).findings
    peak = made.impact_pressure
    assert made.carrier is not None
    still = made.carrier.peak_pressure
    assert still is not None
    assert rigid.value is not None
    assert struck.value == pytest.approx(rigid.value * peak.value / still.value, rel=0.25)
    assert struck.value > 1.5 * rigid.value


def test_a_spring_on_a_turret_that_goes_on_is_refused() -> None:
    data: dict[str, Any] = load(starter("globoidal"), "globoid")[0]
    data["operation"] = {"speed": 100.0, "spring_rate": 2000.0}
    with pytest.raises(ProfileError, match=r"operation\.spring_rate.*wind it up"):
        from_data(data, "globoid")
    data["operation"]["spring_rate"] = 0.0
    from_data(data, "globoid")


def test_the_least_contact_force_has_the_friction_of_the_guides() -> None:
    data = load(starter("disc"), "disc")[0]
    for friction in (0.0, 0.2):
        data["operation"] |= {"guide_friction": friction}
        made = Model(from_data(data, "disc"))
        assert made.drive is not None
        found = made.drive.kept.least
        assert found is not None
        normal = made.drive.contact_forces
        assert found.value <= float(normal.min()) + 1e-6 * float(normal.max())
        assert found.value == pytest.approx(float(normal.min()), rel=2e-3)


def test_a_solved_force_is_solved_once_at_each_cam_angle() -> None:
    asked: list[int] = []

    def force(theta: Floats) -> Floats:
        asked.append(len(theta))
        return np.cos(theta)

    kept, theta = KnownForce(force), np.linspace(0.0, 3.0, 31)
    assert np.array_equal(kept(theta), np.cos(theta))
    more = np.concatenate([theta, theta[:-1] + 0.05])[::-1]
    assert np.array_equal(kept(more), np.cos(more))
    assert np.array_equal(kept(theta), np.cos(theta))
    assert asked == [31, 30]


@pytest.mark.parametrize(("band", "level", "ends"), [(0.0074, "pass", 110.0), (0.0060, "fail", 110.0)])
def test_every_dwell_has_to_settle_not_the_longest_alone(band: float, level: str, ends: float) -> None:
    """Ten degrees at the top swing by 0.0071 mm, the 140 degrees at the bottom 20 deg later by 0.0055 mm."""
    data = load(starter("disc"), "disc")[0]
    data["motion"] = (
        {"until": 100.0, "to": 20.0, "law": "modified-sine"}, {"until": 110.0},
        {"until": 220.0, "to": 0.0, "law": "modified-sine"}, {"until": 360.0},
    )  # fmt: skip
    data["operation"] = {"speed": 300.0, "spring_rate": 4.0, "spring_preload": 400.0}
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 800.0, "linkage_damping": 30.0, "settling_band": band}
    made = Model(from_data(data, "disc"))
    (found,) = judge(made, ("settling",)).findings
    assert (found.level, found.where.endswith(f"ends at {ends:g} deg")) == (level, True)
    study = made.elastic_follower
    assert study is not None
    top, bottom = (1e3 * np.abs(study.steady.at(np.radians(np.linspace(low, high, 2001)), "vibration")).max()
                   for low, high in ((100.0, 110.0), (240.0, 360.0)))  # fmt: skip
    assert bottom < 0.0060 < top < 0.0074
    assert 1e3 * float(study.residual.deviation[0]) == pytest.approx(top, rel=1e-3)


@pytest.mark.parametrize(("damping", "level"), [(0.3, "warn"), (1.0, "warn"), (4.0, "pass")])
def test_a_resonance_between_the_ends_of_the_band_is_met_where_a_harmonic_meets_the_mode(damping, level) -> None:
    """Harmonic 19 of the turn meets 45.02 Hz 1.3 % above the speed; a damping of 0.3 N s/m lets it ring threefold."""
    data = load(starter("disc"), "disc")[0]
    data["motion"] = (
        {"until": 100.0, "to": 20.0, "law": "4-5-6-7"}, {"until": 110.0},
        {"until": 220.0, "to": 0.0, "law": "4-5-6-7"}, {"until": 360.0},
    )  # fmt: skip
    data["operation"] = {"speed": 140.3, "spring_rate": 4.0, "spring_preload": 1400.0}
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 60.0, "linkage_damping": damping, "settling_band": 1.0}
    made = Model(from_data(data, "disc"))
    (found,) = judge(made, ("resonance",)).findings
    assert found.level == level
    study = made.elastic_follower
    assert study is not None
    shares = np.linspace(0.95, 1.05, 201)
    values = study.over(study.speed * shares).peaks["acceleration"].magnitude / shares**2
    assert found.value == pytest.approx(values.max() / values.min(), rel=0.03)
    assert (values.max() / values.min() > 1.25) == (level == "warn")


def test_impacts_on_a_crown_press_in_its_ellipse() -> None:
    """The law and the pressure of the solver are those of the exact ellipse; laws of lines are refused by name."""
    made = crowned(0.2)
    problem = made.impact.problem
    k = 1.0 / problem.law.cam_radius + 1.0 / problem.law.roller_radius
    exact = point_contact(1000.0, 1e-3 * k, 1.0 / 500.0, 1e6 / problem.law.modulus)
    force = problem.law.force(1e-3 * float(exact.approach), 0.0)
    assert force == pytest.approx(1000.0, rel=1e-9)
    pressure = problem.patch.pressure(np.array([1000.0]), np.array([1.0 / problem.law.cam_radius]))
    assert float(pressure[0]) == pytest.approx(1e6 * float(exact.pressure), rel=1e-9)
    for key, value in (("law", "liu"), ("true_curvature", True), ("contact_length", 5.0)):
        with pytest.raises(ProfileError, match=rf"impact\.{key}.*ellipse"):
            crowned(0.2, **{key: value})


def running(*given: dict[str, Any], tables: dict[str, Any]) -> Model:
    """The starter's drum under a force in these operating states, all equally long."""
    data = load(starter("cylindrical"), "drum")[0] | tables
    data["operation"] = data["operation"] | {"force": ({"expression": "300"},)}
    data["lubricant"] = {"viscosity_40": 100.0, "viscosity_100": 11.0, "temperature": 60.0}
    data["duty"] = tuple({"share": 1.0 / len(given), **one} for one in given)
    return Model(from_data(data, "drum"))


@pytest.mark.parametrize(
    ("fact", "tables"),
    [
        ("impact", {"impact": {"clearance": 0.1, "turns": 2, "settle": 1}}),
        ("elastic_follower", {"dynamics": {"kind": "follower", "linkage_stiffness": 3000, "linkage_damping": 20}}),
    ],
)
def test_states_that_differ_in_their_oil_alone_are_solved_once_and_like_ones_share_all(
    fact: str, tables: dict[str, Any]
) -> None:
    model = running(
        {"temperature": 80.0},
        {"temperature": 20.0},
        {"load_factor": 1.5},
        {"speed": 333.0},
        {"temperature": 20.0},
        tables=tables,
    )
    warm, cold, loaded, quick, again = model.states
    assert getattr(warm, fact) is getattr(cold, fact)
    assert warm.duties is not cold.duties
    assert again.duties is cold.duties
    assert len({id(getattr(one, fact)) for one in (warm, loaded, quick)}) == 3


IMPACT = {"clearance": 0.1, "turns": 2, "settle": 1}


def test_many_runs_have_one_purse_of_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """None takes more than two shares, nor what ordinary turns of those after it need; what one leaves is another's."""
    given = [{"load_factor": 1.0 + 0.5 * number} for number in range(4)]
    free = running(*given, tables={"impact": IMPACT})
    steps = [len(one.impact.recorded.steps) for one in free.states if one.impact is not None]
    assert min(steps) > 100
    monkeypatch.setattr(solver, "ORDINARY", 1)

    def allowed(purse: int) -> list[int | None]:
        monkeypatch.setattr("camgeom.model.impact.impact_steps", lambda _: purse)
        model = running(*given, tables={"impact": IMPACT})
        last = model.states[3].impact  # asked first: the others are solved before it all the same
        assert last is not None
        return [one.impact_most for one in model.states]

    ample = sum(steps) + max(steps)
    assert allowed(ample) == [ample // 2] * 2 + [min(ample // 2, ample - sum(steps[:2]) - 2), ample - sum(steps[:3])]
    assert allowed(sum(steps))[3] == steps[3]
    with pytest.raises(NotConverged, match=f"^{steps[3]} steps"):
        allowed(sum(steps) - 1)


@pytest.mark.parametrize(
    ("states", "turns", "refused"),
    [(24, 2, ""), (25, 2, ""), (26, 2, "GB"), (60, 2, "s"), (2, 25, ""), (2, 26, "GB"), (2, 62, "GB"), (2, 63, "s")],
)
def test_runs_that_would_take_too_long_together_are_refused_before_they_start(
    states: int, turns: int, refused: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    monkeypatch.setattr("camgeom.dynamics.impact.run.solve", lambda *_, most, **given: asked.append(most))
    given = [{"load_factor": 1.0 + 0.01 * number} for number in range(states)]
    model = running(*given, tables={"impact": IMPACT | {"turns": turns}})
    loads = 0.05 * states
    if refused:
        would = f"impacts of {states} followers .* {turns} turns each, would take "
        would += ("more than the 2 GB .*at most 50 turns together" if refused == "GB" else
                  f"about {0.4 * states * turns:.3g} s.*"
                  f"beside {loads:.3g} s of loads, more than the 50 s.*at most "
                  f"{int((50 - loads) / 0.4)} turns together")
        with pytest.raises(NotConverged, match=would):
            _ = model.states[0].impact
    else:
        _ = model.states[0].impact
        left = 50.0 - loads - 0.4 * states * turns
        every = int(1000 * (0.4 * states * turns + min(max(4.0, left), 24.0)) / 0.4)
        assert asked == [min(2 * every // states, every - (states - 1) * turns * 1000)]


@pytest.mark.parametrize(("turns", "refused"), [(2, False), (3, True)])
def test_contacts_of_stated_ends_that_would_take_too_long_are_refused_unsolved(
    turns: int, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("camgeom.model.price.SPENT", 6.3)  # 0.1 of loads, 1.8 of their contacts, 1.6, 2.5 of theirs
    data = load(starter("cylindrical"), "drum")[0]
    tables = {"roller": data["roller"] | {"end_radius": 1.0}, "impact": IMPACT | {"turns": turns}}
    model = running({}, {"load_factor": 1.5}, tables=tables)
    assert model.states[0].impact is not None
    if refused:
        with pytest.raises(NotConverged, match=r"^contacts of .* \(4\) .* 5 s .* more than the 6.3 s .* most 1 of"):
            _ = model.states[0].impact_pressure
    else:
        assert len(model.states[0].impact_duties) == turns - 1


@pytest.mark.parametrize(("share", "refused"), [(1.0, False), (0.999, True)])
def test_contacts_of_stated_ends_that_would_hold_too_much_are_refused_unsolved(
    share: float, refused: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run of slow, stiff contacts has ten thousand steps in a turn: its pressures took more than 2 GB."""
    data = load(starter("cylindrical"), "drum")[0]
    tables = {"roller": data["roller"] | {"end_radius": 1.0}, "impact": IMPACT | {"turns": 2}}
    states = ({}, {"load_factor": 1.5})
    (turn,) = running(*states, tables=tables).states[0].impact_duties
    points = 2 * sum(duty.force.panels.theta.size for duty in turn)
    monkeypatch.setattr("camgeom.model.impact.MOST_POINTS", int(share * points))
    model = running(*states, tables=tables)
    if refused:
        with pytest.raises(NotConverged, match=rf"^contacts of .* \(1, turns .*: 1, .*: 2\) at {points} .* MB"):
            _ = model.states[0].impact_pressure
    else:
        assert len(model.states[0].impact_duties) == 1


FOLLOWERS: dict[str, tuple[tuple[dict[str, Any], ...], list[int]]] = {
    "station": (({"angle": 90.0}, {"angle": 180.0, "load_mass": 1.0}), [0, 0, 2]),
    "track": (({"cam": {"start": 24.0}, "angle": 37.0}, {"operation": {"friction": 2.0}}, {"angle": 10.0}),
              [0, 0, 2, 0]),
}


@pytest.mark.parametrize("table", FOLLOWERS)
def test_followers_that_differ_by_their_place_alone_move_alike_and_are_solved_once(table: str) -> None:
    """Each counts from its own cam angle: what it does alone is bit by bit what the first one does."""
    others, solved_by = FOLLOWERS[table]
    oils = ({"temperature": 80.0}, {"temperature": 20.0}, {"load_factor": 1.5})
    model = running(*oils, tables={"impact": IMPACT, table: others})
    for one, by in zip(model.bindings, solved_by, strict=True):
        for number, state in enumerate(one.states):
            first = model.bindings[by].states[0 if number < 2 else number]
            assert state.impact is first.impact
            assert state.impact_pressure is first.impact_pressure
            assert state.impact_row is first.impact_row
            assert state.impact_duties is model.bindings[by].states[number].impact_duties
        alone = Model(one.profile.model_copy(update={"station": (), "track": ()})).states[2].impact
        together = one.states[2].impact
        assert alone is not None
        assert together is not None
        assert alone.problem == together.problem
        assert alone.recorded.state == together.recorded.state
        assert np.array_equal(alone.trace.force, together.trace.force)
    assert len({id(one.states[2].impact) for one in model.bindings}) == len(set(solved_by))


def test_followers_that_differ_study_their_clearances_within_one_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    spec = IMPACT | {"study": tuple(0.05 + 0.001 * number for number in range(30))}
    others = ({"angle": 90.0}, {"angle": 180.0, "load_mass": 1.0}, {"angle": 200.0, "load_mass": 2.0})
    model = running({}, tables={"impact": spec, "station": others})
    monkeypatch.setattr("camgeom.model.price.SPENT", 20.0)
    with pytest.raises(NotConverged, match=r"would take about 27 s .* more than the 20 s"):
        _ = model.states[0].impact_clearances
