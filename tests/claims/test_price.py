"""One purse for a design: the same answers whichever fact is asked first, and what is left is shared."""

from __future__ import annotations

import gc
import pickle
import weakref
from collections.abc import Callable
from itertools import permutations
from typing import Any

import pytest

from camgeom.body.frame_stress import FrameBending
from camgeom.errors import NotConverged
from camgeom.model import Model
from camgeom.model.price import (
    ENDS,
    HALF_SPACE,
    IMPACTS,
    LAWS,
    LIMITS,
    ROOTS,
    SPENT,
    VIBRATION,
    _prices,
    a_drawing,
    afford,
    impact_steps,
    limit,
)
from camgeom.motion.optimal.programme import WHOLE
from camgeom.profile import from_data, read_data
from tests.places import PROFILES

IMPACT = {"clearance": 0.1, "turns": 5, "settle": 4, "study": (0.05, 0.1)}
DYNAMICS = {"kind": "follower", "linkage_stiffness": 30000, "linkage_damping": 200, "body_compliance": True}


def drum(states: int, **tables: Any) -> Model:
    """The pin cam with round roots in some operating states."""
    data = read_data(PROFILES / "pin_insertion.toml") | tables
    data["material"]["cam"]["bending_limit"] = 300.0
    data["cam"] = {**data["cam"], "root_radius": 0.5}
    data["duty"] = tuple({"share": 1.0 / states, "speed": 600.0 - number} for number in range(states))
    return Model(from_data(data))


ASKED: dict[str, Callable[[Model], object]] = {
    "impacts": lambda model: model.states[1].impact,
    "below": lambda model: model.states[2].below,
    "wall": lambda model: model.root_stress and model.root_stress.nominal,
    "root": lambda model: model.root_stress and model.root_stress.peaks,
    "studies": lambda model: model.impact_clearances,
}


@pytest.fixture
def unsolved(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing dear is solved."""
    monkeypatch.setattr("camgeom.body.compliance.below_rollers", lambda *_: None)
    monkeypatch.setattr("camgeom.body.stress.nominals", lambda rings: [0.0 for _ in rings])
    monkeypatch.setattr("camgeom.body.bending.GrooveBending.peaks", lambda *_: ())
    monkeypatch.setattr("camgeom.dynamics.impact.run.solve", lambda *_, **__: None)


def answered(model: Model, name: str) -> str:
    """Why something is not solved; "" where it is."""
    try:
        ASKED[name](model)
    except NotConverged as refusal:
        return str(refusal)
    return ""


@pytest.mark.usefixtures("unsolved")
@pytest.mark.parametrize(
    ("states", "refused"),
    [
        (4, {"root": "14 s of one core beside 0.2 s of loads, 8 s of impacts, 1.8 s of [dynamics], 24 s of "
                     "body_compliance, 10 s of walls, more than the 50 s"}),
        (7, {"below": "42 s of one core beside 0.35 s of loads, 14 s of impacts, 3.15 s of [dynamics], more than the "
                      "50 s that are spent on a design: at most 5 of them, or leave dynamics.body_compliance out"}),
        (26, {"impacts": "52 s of one core beside 1.3 s of loads, more than the 50 s that are spent on a design: at "
                         "most 121 turns together, or fewer of impact.turns",
              "below": "156 s of one core beside 1.3 s of loads, 11.7 s of [dynamics], more",
              "studies": "52 s of one core beside 1.3 s of loads, more"}),
    ],
)  # fmt: skip
def test_what_is_paid_hangs_on_the_profile_and_not_on_what_is_asked_first(states: int, refused: dict[str, str]) -> None:
    for order in list(permutations(ASKED))[::50]:
        model = drum(states, impact=IMPACT, dynamics=DYNAMICS)
        said = {name: answered(model, name) for name in order}
        assert {name for name, why in said.items() if why} == set(refused), order
        for name, why in refused.items():
            assert why in said[name]
    again = pickle.loads(pickle.dumps(drum(states, impact=IMPACT, dynamics=DYNAMICS)))
    assert answered(again, "root") == said["root"]


@pytest.mark.usefixtures("unsolved")
def test_what_advice_leaves_is_paid() -> None:
    for states, refused in ((5, ""), (6, "at most 5 of them")):
        model = drum(states, impact=IMPACT | {"turns": 7}, dynamics=DYNAMICS)
        assert refused in answered(model, "below")
        assert bool(answered(model, "below")) is bool(refused)


@pytest.mark.usefixtures("unsolved")
@pytest.mark.parametrize(("turns", "held"), [(50, True), (51, False)])
def test_what_memory_refuses_is_not_paid(turns: int, held: bool) -> None:
    """Roots and the body were refused beside 40 s of impacts that never began."""
    model = drum(1, impact={"clearance": 0.1, "turns": turns, "settle": 4})
    paid = next(price for name, _, price in _prices(model) if name == IMPACTS).paid(SPENT)
    assert paid == (pytest.approx(0.4 * turns) if held else 0.0)
    if held:
        afford(model.body, IMPACTS)
    else:
        with pytest.raises(NotConverged, match=r"more than the 2 GB .*: at most 50 turns together"):
            afford(model.body, IMPACTS)
    assert limit(model, "machines") < limit(drum(1), "machines") if held else limit(model, "machines")


@pytest.mark.parametrize("states", [1, 4, 7])
def test_solvers_of_unknown_steps_share_what_is_left(states: int) -> None:
    alone = drum(states, impact={key: value for key, value in IMPACT.items() if key != "study"})
    left = SPENT - states * (0.05 + 0.4 * 5) - 10.0 - 14.0
    assert limit(alone, "impacts") == pytest.approx(max(4.0, min(left, 24.0)))
    assert impact_steps(alone) == int(1000 * (2.0 * states + limit(alone, "impacts")) / 0.4)
    both = drum(states, impact=IMPACT, dynamics=DYNAMICS | {"body_compliance": False, "sweep": (100.0, 900.0)})
    assert all(LIMITS[name][1] <= limit(both, name) <= LIMITS[name][2] for name in LIMITS)
    paid = states * (0.05 + 2.0 + 0.45) + 10.0 + 14.0 + 1.2
    shared = sum(limit(both, name) for name in LIMITS if name != "machines")
    assert shared == pytest.approx(max(SPENT - paid, 12.0), rel=0.1)
    study = both.states[0].elastic_follower
    assert study is not None
    assert study.accuracy.together == limit(both, "vibration")
    assert study.accuracy.sweep == limit(both, "sweep")
    assert study.accuracy.runs == states


def many(name: str, states: int, change: Callable[[dict[str, Any]], None]) -> Model:
    """A shipped profile in some operating states, changed."""
    data = read_data(PROFILES / f"{name}.toml")
    change(data)
    speed = data["operation"]["speed"]
    data["duty"] = tuple({"share": 1.0 / states, "speed": speed - 0.01 * number} for number in range(states))
    return Model(from_data(data))


def leaning(**keys: Any) -> Callable[[dict[str, Any]], None]:
    """Rollers with stated ends and a tilt."""

    def change(data: dict[str, Any]) -> None:
        data["cam"].pop("preload", None)
        data["follower"].pop("preload", None)
        data["roller"] |= {"misalignment_deg": 0.02, "end_radius": 0.5}
        data |= keys

    return change


DRIVE = {"kind": "indexing", "input_stiffness": 1.9e5, "output_stiffness": 3.5e5, "turret_inertia": 0.8,
         "load_inertia": 1.0}  # fmt: skip


@pytest.mark.parametrize(("states", "told"), [(6, ""), (7, r"\(7\), would take about 57.8 s .* at most 6 of them")])
def test_contacts_on_a_half_space_are_paid_in_every_state(states: int, told: str) -> None:
    """64 states of an indexer with leaning rollers took more than 190 s of a processor, priced at 3."""
    model = many("fine_indexer", states, leaning())
    duty = model.states[-1].turret_duty
    assert duty is not None
    assert duty.level == "finite"
    assert duty.peak_force.value > 0.0  # forces stand
    if not told:
        duty.paid()
        return
    with pytest.raises(NotConverged, match=told):
        _ = duty.least_peak


@pytest.mark.parametrize(("share", "states", "told"), [
    (1.0, 6, ""), (1e-3, 3, ""), (1e-3, 4, "at most 3 of them"), (1e-9, 1, ""), (1e-9, 2, "would take about 51.1 s"),
])  # fmt: skip
def test_what_hardly_presses_is_paid_as_what_it_takes(share: float, states: int, told: str) -> None:
    """Three states of a turret of 0.006 kg m2 without load, whose rollers lean, took 60 s of a processor (seed
    1380765), priced at 16.5: cells of a contact that is as narrow take more steps."""

    def light(data: dict[str, Any]) -> None:
        leaning()(data)
        data["follower"]["inertia"] *= share
        data["operation"] = {"speed": data["operation"]["speed"]}

    model = many("fine_indexer", states, light)
    if not told:
        afford(model.body, HALF_SPACE)
        return
    with pytest.raises(NotConverged, match=told):
        afford(model.body, HALF_SPACE)


@pytest.mark.parametrize(("states", "told"), [(2, ""), (3, "about 43 s of one core beside .* 24.8 s of contacts on")])
def test_contacts_on_a_half_space_under_vibration_are_paid(states: int, told: str) -> None:
    """Four states held 3.1 GB, 64 of them 21.8 GB."""
    model = many("fine_indexer", states, leaning(dynamics=DRIVE))
    if not told:
        afford(model.body, VIBRATION)
        return
    with pytest.raises(NotConverged, match=told):
        afford(model.body, VIBRATION)


@pytest.mark.parametrize(("states", "told"), [(27, ""), (28, r"\(168\), would take about 151 s .* at most 50 of them")])
def test_leaning_rollers_of_all_followers_are_paid(states: int, told: str) -> None:
    stations = ({"angle": 100.0}, {"angle": 200.0}) if told else ()
    model = many("bell_lifter", states, leaning(station=stations))
    if not told:
        afford(model.body, HALF_SPACE)
        return
    with pytest.raises(NotConverged, match=told):
        _ = model.states[0].duty.least_peak


@pytest.mark.parametrize(("searched", "told"), [(41.7, ""), (41.8, "about 8.25 s .* beside 41.8 s of best laws")])
def test_best_laws_are_paid_by_what_their_search_has_cost(
    searched: float, told: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The search for one may take 25 s of a processor, which came beside the 50 s."""
    model = many("optimal_indexer", 1, leaning())
    ((_, best),) = model.setup.program.best_laws
    assert 0 < best.spent < WHOLE
    monkeypatch.setattr("camgeom.model.price.A_SEARCH", searched * WHOLE / best.spent)
    assert {name: price.seconds for name, _, price in _prices(model)}[LAWS] == pytest.approx(searched)
    if not told:
        afford(model.body, HALF_SPACE)
        return
    with pytest.raises(NotConverged, match=told):
        afford(model.body, HALF_SPACE)


@pytest.mark.parametrize(("poisson", "told"), [(0.3, ""), (0.48, ""), (0.499, "round root .* about 124 s")])
def test_roots_of_what_hardly_gives_way_cost_more(poisson: float, told: str) -> None:
    """The root of one groove took 106 s at 0.499."""
    data = read_data(PROFILES / "pin_insertion.toml")
    data["material"]["cam"] |= {"bending_limit": 300.0, "poisson": poisson}
    data["cam"]["root_radius"] = 0.5
    model = Model(from_data(data))
    if not told:
        afford(model.body, ROOTS)
        return
    with pytest.raises(NotConverged, match=told):
        afford(model.body, ROOTS)


@pytest.mark.parametrize(("poisson", "paid"), [(0.3, True), (0.48, True), (0.49, False)])
def test_a_frame_has_its_price(poisson: float, paid: bool) -> None:
    data = read_data(PROFILES / "constant_width_press.toml")
    data["material"] = {**data.get("material", {}), "roller": {"bending_limit": 200.0, "poisson": poisson}}
    model = Model(from_data(data))
    found = model.root_stress
    assert found is not None
    assert isinstance(found.body, FrameBending)
    if paid:
        found.body.paid()
        return
    for asked in ("nominal", "peaks"):
        with pytest.raises(NotConverged, match=r"the frame.s plate would take about 64"):
            getattr(found.body, asked)


def test_a_price_keeps_no_model_alive_and_ends_with_it() -> None:
    """No cycle: a model that is dropped is gone at once, and what is left of it has no design that would pay."""
    gc.collect()
    gc.disable()
    try:
        model = many("bell_lifter", 64, leaning(station=({"angle": 100.0}, {"angle": 200.0})))
        (duty,) = model.bindings[1].duties
        gone = weakref.ref(Model(from_data(read_data(PROFILES / "bell_lifter.toml"))))
        assert gone() is None
        with pytest.raises(NotConverged):
            duty.paid()
        assert len(pickle.loads(pickle.dumps(duty)).force.panels.theta)
        pickle.loads(pickle.dumps(duty)).paid()
        del model
        gc.collect()
        duty.paid()
        lone = many("misaligned_roller", 1, lambda data: data.pop("duty", None))
        _ = lone.duties, lone.duty.finite
        alone = weakref.ref(lone)
        del lone
        gone_by_count = alone() is None
    finally:
        gc.enable()
    assert gone_by_count


def test_states_that_differ_in_their_oil_alone_are_paid_each_where_each_is_computed() -> None:
    oils = tuple({"share": 0.25, "temperature": 40.0 + 10.0 * number} for number in range(4))
    oil = {"viscosity_40": 100.0, "viscosity_100": 11.0, "temperature": 40.0}

    def states(data: dict[str, Any]) -> Model:
        data |= {"duty": oils, "lubricant": oil}
        return Model(from_data(data))

    data = read_data(PROFILES / "pin_insertion.toml") | {"impact": IMPACT}
    data["roller"] |= {"end_radius": 0.5}
    drums = states(data)
    assert len({id(one.duties) for one in drums.states}) == 4
    prices = {name: price for name, _, price in _prices(drums)}
    assert prices[ENDS].seconds == 4 * 1.25
    assert prices[IMPACTS].count == 5
    assert prices[HALF_SPACE].count == 4
    data = read_data(PROFILES / "fine_indexer.toml")
    leaning(dynamics=DRIVE)(data)
    turrets = states(data)
    with pytest.raises(NotConverged, match=r"about 56.4 s of one core"):
        afford(turrets.body, VIBRATION)


def test_states_that_are_alike_are_paid_once() -> None:
    data = read_data(PROFILES / "fine_indexer.toml")
    leaning()(data)
    data["duty"] = tuple({"share": 1.0 / 16.0} for _ in range(16))
    model = Model(from_data(data))
    assert model.states[7].turret_duty is model.states[0].turret_duty
    afford(model.body, HALF_SPACE)


def test_a_crown_that_leaves_its_room_under_impacts_alone_is_paid() -> None:
    data = read_data(PROFILES / "conjugate_rocker.toml")
    data["roller"] |= {"shape": "crowned", "crown_radius": 2000.0}
    data["impact"] |= {"turns": 60}
    model = Model(from_data(data))
    assert {duty.level for duty in model.duties} == {"ellipse"}
    prices = {name: price for name, _, price in _prices(model)}
    assert prices[ENDS].seconds == pytest.approx(2 * (60 - model.profile.impact_spec.settle) * 0.3)  # type: ignore[union-attr]


@pytest.mark.usefixtures("unsolved")
def test_a_model_in_no_state_that_runs_has_its_own_impact() -> None:
    data = read_data(PROFILES / "pin_insertion.toml") | {"impact": IMPACT}
    data["duty"] = ({"share": 0.5, "load_factor": 1.5}, {"share": 0.5, "load_factor": 2.0})
    model = Model(from_data(data))
    assert model.impact is None  # not solved, and no error
    assert model.impact_most is not None
    assert model.impact_most >= 1


def test_one_drawing_of_machines_is_that_of_all_followers() -> None:
    few, more = (many("bell_lifter", 1, lambda data, n=n: data.update(
        tolerance={"axial_shift": 0.01, "dwell_limit": 100.0}, station=tuple({"angle": 40.0 * k} for k in range(1, n))))
        for n in (1, 8))  # fmt: skip
    assert a_drawing(more) == pytest.approx(limit(more, "machines") / 24.0)
    assert a_drawing(few) == pytest.approx(limit(few, "machines") / 3.0)
    assert more.tolerances.machines(more.tolerances.spreads).spent == a_drawing(more)
