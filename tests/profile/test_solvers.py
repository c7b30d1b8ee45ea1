"""What a solver cannot carry, or cannot do without, is refused when the profile is read, by key, and not while it runs.

Every case has two sides: the change that is refused, and the neighbour that the solver then solves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.solvers import solver_problems
from camgeom.report.result import compute
from camgeom.track import TURN
from tests.profile.cases import frozen, made, put

Data = dict[str, Any]
FORCE = {"from": 60.0, "until": 110.0}
SHAFTS = {"dynamics": None, "dynamics.kind": "indexing", "dynamics.input_stiffness": 2e5,
          "dynamics.output_stiffness": 5e5}  # fmt: skip
BARE = {"dynamics.shaft_inertia": None, "dynamics.shaft_stiffness": None}


@dataclass(frozen=True)
class Two:
    """A case of `cases.CASES` with keys changed, the key that is refused then, and what makes it sound."""

    case: str
    key: str
    bad: Data
    good: Data


TWO = [
    Two("disc, elastic", "operation", {"operation": None}, {}),
    Two("indexing drive", "operation", {"operation": None}, {}),
    Two("drum, impact", "operation", {"operation": None}, {}),
    Two("indexing drive", "operation.spring_rate", {"operation.spring_rate": 3.0}, {"operation.spring_rate": 0.0}),
    Two("disc, elastic", "operation.guide_friction", {"operation.guide_friction": 0.05},
        {**BARE, "operation.guide_friction": 0.05}),
    Two("disc, elastic", "dynamics.tappet_mass", {**BARE, "dynamics.tappet_mass": 0.501},
        {**BARE, "dynamics.tappet_mass": 0.499}),
    Two("disc, elastic", "dynamics.mass", {"follower.mass": None}, {"follower.mass": None, "dynamics.mass": 0.5}),
    Two("disc, elastic", "dynamics.method", {"dynamics.method": "newmark"}, {**BARE, "dynamics.method": "newmark"}),
    Two("indexing drive", "dynamics.method", {"dynamics.method": "newmark", "dynamics.exact_contact": True},
        {"dynamics.method": "newmark"}),
    Two("disc, elastic", "operation.force[0].expression",
        {"dynamics.sweep": (100.0, 200.0), "dynamics.sweep_points": 2,
         "operation.force": ({**FORCE, "expression": "2 + v"},)},
        {"dynamics.sweep": (100.0, 200.0), "dynamics.sweep_points": 2,
         "operation.force": ({**FORCE, "expression": "2 + s"},)}),
    Two("disc, elastic", "duty[1].force[0].expression",
        {"dynamics.sweep": (100.0, 200.0), "dynamics.sweep_points": 2,
         "duty": ({"share": 0.5}, {"share": 0.5, "force": ({**FORCE, "expression": "2 + v"},)})},
        {"dynamics.sweep": (100.0, 200.0), "dynamics.sweep_points": 2,
         "duty": ({"share": 0.5}, {"share": 0.5, "force": ({**FORCE, "expression": "2 + s"},)})}),
    Two("drum, impact", "operation.guide_friction", {"operation.guide_friction": 0.05}, {}),
    Two("drum, impact", "impact.clearance", {"impact.clearance": None, "cam.running_clearance": None},
        {"impact.clearance": None, "cam.running_clearance": 0.02}),
    Two("drum, impact", "impact.inertia", {"follower.mass": None}, {"follower.mass": None, "impact.inertia": 2.0}),
    Two("drum, impact", "impact.laws", {"impact.laws": ("no-such-law",)}, {"impact.laws": ("modified-sine",)}),
]  # fmt: skip


def data_of(case: str, changes: Data) -> Data:
    """The data of a case with keys changed; what it says twice of what moves is left out."""
    data = made(case)
    for key, value in changes.items():
        put(data, key, value)
    return frozen(data)


@pytest.mark.parametrize("two", TWO, ids=lambda two: f"{two.case}: {two.key}")
def test_the_reader_says_what_the_solver_would(two: Two) -> None:
    with pytest.raises(ProfileError) as refused:
        from_data(data_of(two.case, two.bad), "part.toml")
    assert two.key in [problem.key for problem in refused.value.problems]
    assert str(refused.value).startswith("part.toml: ")


@pytest.mark.parametrize("two", [two for two in TWO if two.good], ids=lambda two: f"{two.case}: {two.key}")
def test_its_neighbour_is_solved(two: Two) -> None:
    model = Model(from_data(data_of(two.case, two.good), ""))
    products = {product.name: product for product in compute(model, ("dynamics",)).products}
    asked = "impact" if model.profile.impact_spec is not None else "dynamics"
    assert products[asked].status in ("made", "failed"), products[asked].reason
    assert products[asked].exit_status in (0, 3)


STATIONS = [
    ("disc, elastic", {"dynamics.tappet_mass": 0.1, "dynamics.tappet_stiffness": 2e4},
     {"guide_friction": 0.05}, {"guide_friction": 0.0}, "station[1].guide_friction"),
    ("disc, elastic", {"dynamics.tappet_mass": 0.3}, {"mass": 0.29}, {"mass": 0.31}, "dynamics.tappet_mass"),
    ("disc, elastic", {"dynamics.mass": 0.5}, {"mass": 0.6}, {"mass": 0.5}, "dynamics.mass"),
    ("disc, elastic", {"dynamics.sweep": (100.0, 200.0), "dynamics.sweep_points": 2},
     {"force": ({**FORCE, "expression": "2 + v"},)}, {"force": ({**FORCE, "expression": "2 + s"},)},
     "station[1].force[0].expression"),
    ("drum, impact", {}, {"guide_friction": 0.05}, {"guide_friction": 0.0}, "station[1].guide_friction"),
]  # fmt: skip


@pytest.mark.parametrize(("case", "changes", "bad", "good", "key"), STATIONS, ids=lambda one: f"{one}")
def test_a_station_is_asked_like_the_first_follower(case: str, changes: Data, bad: Data, good: Data, key: str) -> None:
    def read_with(own: Data) -> Any:
        stations = ({"angle": 90.0}, {"angle": 180.0, **own})
        found = {"station": stations} if case == "drum, impact" else {**BARE, "station": stations, **changes}
        return from_data(data_of(case, found), "part.toml")

    with pytest.raises(ProfileError) as refused:
        read_with(bad)
    (problem,) = refused.value.problems
    assert problem.key == key
    assert "station[1]" in f"{problem}"
    model = Model(read_with(good))
    name = "impact" if case == "drum, impact" else "dynamics"
    products = {product.name: product for product in compute(model, ("dynamics",)).products}
    assert products[f"follower 3.{name}"].exit_status in (0, 3), products[f"follower 3.{name}"].reason


@pytest.mark.parametrize(("moved", "own", "key"), [(0.0, 0.0, "dynamics.load_inertia"), (0.3, 0.0, "follower.inertia")])
def test_a_turret_without_inertia_leaves_none_for_its_load(moved: float, own: float, key: str) -> None:
    found = {"follower.inertia": own, "operation.load_inertia": moved, "dynamics.turret_inertia": None,
             "dynamics.load_inertia": None}  # fmt: skip
    with pytest.raises(ProfileError) as refused:
        from_data(data_of("indexing drive", {**found, "dynamics.cam_inertia": 0.1}), "")
    assert key in [problem.key for problem in refused.value.problems]
    assert from_data(data_of("indexing drive", {**found, "follower.inertia": 1.0, "dynamics.cam_inertia": 0.1}), "")


@pytest.mark.parametrize(("text", "told"), [("1 / (deg - 90)", True), ("log(deg - 70)", True), ("log(deg)", False)])
def test_a_force_without_a_value_is_told_when_it_is_read(text: str, told: bool) -> None:
    data = data_of("disc, roller", {"operation.force": ({**FORCE, "expression": text},)})
    if not told:
        assert from_data(data, "")
        return
    with pytest.raises(ProfileError, match=r"operation\.force\[0\]\.expression: (.*no finite value|has a pole)"):
        from_data(data, "part.toml")


STATES = ({"speed": 300.0, "share": 0.5}, {"speed": 700.0, "share": 0.5})


@pytest.mark.parametrize("place", ["operation", "station"])
@pytest.mark.parametrize("fast", [False, True])
def test_a_force_that_a_states_speed_makes_endless_is_told_with_both(place: str, fast: bool) -> None:
    """Stations were looked at at operation.speed alone: a run that had begun named `operation.force`, another one."""
    sound = {**FORCE, "from": 0.0, "until": 360.0, "expression": "0*v"}
    data = data_of("disc, roller", {"operation.speed": 300.0, "operation.force": (sound,), "operation.friction": 5.0})
    program = from_data(data).setup().program
    theta = np.linspace(0.0, TURN, 721)
    most = float(np.abs(program.jet(theta, 1)[1]).max()) * TURN / 60.0  # mm/s for each r/min
    bad = {**sound, "expression": f"1/(v-{most * (600.0 if fast else 800.0)!r})"}
    beside = {"station": ({"angle": 180.0, "force": (bad,)},)}
    changes = beside if place == "station" else {"operation.force": (bad,)}
    data = data_of("disc, roller", {"operation.speed": 300.0, "operation.force": (sound,), **changes, "duty": STATES})
    if not fast:
        assert from_data(data)
        return
    with pytest.raises(ProfileError) as refused:
        from_data(data)
    (problem,) = refused.value.problems
    assert problem.key == f"{place if place == 'operation' else 'station[0]'}.force[0].expression"
    assert problem.message.endswith(", at the 700 r/min of duty[1]")


def test_one_force_is_told_once_for_all_states() -> None:
    waves = {**FORCE, "from": 0.0, "until": 360.0, "expression": "200*sin(500*v)"}
    with pytest.raises(ProfileError) as refused:
        from_data(data_of("disc, roller", {"operation.speed": 300.0, "operation.force": (waves,), "duty": STATES}))
    assert [problem.message for problem in refused.value.problems] == ["swings too often"]


@pytest.mark.parametrize(("case", "most"), [("disc, roller", 9_000), ("globoid", 5_000)])
def test_force_tables_have_so_many_rows_and_no_more(case: str, most: int) -> None:
    for rows in (most, most + 1):
        table = tuple((360.0 * k / rows, 1.0) for k in range(rows))
        data = data_of(case, {"operation.force": ({"table": table},)})
        if rows == most:
            assert from_data(data, "")
        else:
            with pytest.raises(ProfileError, match=rf"operation\.force: .*\(found {rows}\); allowed: at most {most}"):
                from_data(data, "")


def test_a_motion_that_jumps_is_a_finding_and_no_refusal() -> None:
    """It leaves a parallel indexer without tracks: its drive and body are refused one by one, the rest is there."""
    changes = {"dynamics.kind": "indexing", "dynamics.input_stiffness": 2e5, "dynamics.output_stiffness": 5e5}
    data = data_of("plates", changes)
    for segment in data["motion"]:
        if "to" in segment:
            segment["law"] = "constant-velocity"
    products = compute(Model(from_data(data, "")), ("motion", "solid", "dynamics")).products
    assert products["motion"].status == "made"
    for name in ("solid", "dynamics"):
        assert (products[name].status, products[name].exit_status) == ("refused", 1)
        assert "velocity jumps" in products[name].reason


def test_a_profile_made_in_python_is_told_by_the_solver() -> None:
    """It was not read; the same rule stands at the solver's door."""
    profile = from_data(data_of("drum, impact", {}), "")
    other = profile.model_copy(update={"operation": profile.operation.model_copy(update={"guide_friction": 0.05})})
    model = Model(other)
    (problem,) = solver_problems(other, model.mechanism)
    assert problem.key == "operation.guide_friction"
    with pytest.raises(ProfileError, match="guide_friction"):
        _ = model.impact
