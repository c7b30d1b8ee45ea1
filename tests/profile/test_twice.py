"""One quantity under two keys: alike within 1 %, or refused by both names."""

from __future__ import annotations

import pytest

from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import Profile, from_data
from camgeom.profile.text import load
from tests.places import PROFILES

SHAFTS = {"kind": "indexing", "input_stiffness": 2e5, "output_stiffness": 5e5}
ELASTIC = {"kind": "follower", "linkage_stiffness": 400.0}


def given(name: str, **tables: dict[str, object]) -> Profile:
    """A shipped profile without its [dynamics] and [impact], and some keys more."""
    data, _, _ = load((PROFILES / f"{name}.toml").read_text(encoding="utf-8"), name)
    data = {key: value for key, value in data.items() if key not in ("dynamics", "impact")}
    for table, keys in tables.items():
        data[table] = data.get(table, {}) | keys
    return from_data(data, "")


# The changer's turret moves 1.1 kg m2 with its load, the rocker 0.14.
TWICE = [
    ("disc_offset_roller", "follower.mass",
     lambda x: {"follower": {"mass": 3.0}, "dynamics": ELASTIC | {"mass": 3 * x}}, "dynamics.mass"),
    ("disc_offset_roller", "operation.load_mass",
     lambda x: {"follower": {"mass": 3.0}, "operation": {"load_mass": 1.0},
                "dynamics": ELASTIC | {"mass": 3.5 * x, "tappet_mass": 0.5 * x}}, "dynamics.mass"),
    ("disc_offset_roller", "operation.spring_rate",
     lambda x: {"operation": {"spring_rate": 4.0}, "dynamics": ELASTIC | {"return_stiffness": 4 * x}},
     "dynamics.return_stiffness"),
    ("disc_offset_roller", "operation.spring_preload",
     lambda x: {"operation": {"spring_preload": 60.0}, "dynamics": ELASTIC | {"preload": 60 * x}}, "dynamics.preload"),
    ("tool_changer", "follower.inertia",
     lambda x: {"dynamics": SHAFTS | {"load_inertia": 1.0 * x, "turret_inertia": 0.1 * x}}, "dynamics.load_inertia"),
    ("conjugate_rocker", "follower.inertia", lambda x: {"impact": {"inertia": 0.14 * x}}, "impact.inertia"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "first", "tables", "second"), TWICE)
@pytest.mark.parametrize("share", [1.0, 0.992, 1.008])
def test_two_values_within_a_hundredth_are_one(name, first, tables, second, share) -> None:
    assert given(name, **tables(share))


@pytest.mark.parametrize(("name", "first", "tables", "second"), TWICE)
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_two_values_are_refused_by_both_names(name, first, tables, second, share) -> None:
    with pytest.raises(ProfileError) as refused:
        given(name, **tables(share))
    (problem,) = refused.value.problems
    assert problem.key == second
    assert first in problem.message


def test_the_second_serves_where_the_first_is_not_given() -> None:
    data, _, _ = load((PROFILES / "disc_offset_roller.toml").read_text(encoding="utf-8"), "")
    data["follower"] = {key: value for key, value in data["follower"].items() if key != "mass"}
    data["dynamics"] = ELASTIC | {"mass": 0.01}
    assert from_data(data, "").dynamics_spec


def test_the_turret_is_what_the_load_leaves() -> None:
    spec = SHAFTS | {"load_inertia": 0.9, "cam_inertia": 0.1, "contact_stiffness": 4e6}
    drive = Model(given("tool_changer", dynamics=spec)).indexing
    assert drive is not None
    assert drive.drive.turret_inertia == pytest.approx(0.2)
    with pytest.raises(ProfileError, match=r"follower\.inertia"):
        given("tool_changer", dynamics=spec | {"load_inertia": 1.1})


def test_the_play_of_impacts_is_that_of_the_body_or_more() -> None:
    """Bearings and wear add to what the flanks are cut with; the rocker's discs have 0.1 mm, the groove twice 0.25."""
    for play in (0.0995, 0.1, 0.3):
        assert given("conjugate_rocker", impact={"clearance": play})
    with pytest.raises(ProfileError, match=r"impact.clearance: .*follower.clearance"):
        given("conjugate_rocker", impact={"clearance": 0.098})
    assert given("pin_insertion", cam={"running_clearance": 0.25}, impact={"clearance": 0.5})
    with pytest.raises(ProfileError, match=r"impact.clearance: .*cam.running_clearance"):
        given("pin_insertion", cam={"running_clearance": 0.25}, impact={"clearance": 0.001})


def test_the_contact_is_no_longer_than_the_roller() -> None:
    for length in (12.0, 20.0):
        assert given("conjugate_rocker", impact={"contact_length": length})
    with pytest.raises(ProfileError, match=r"impact.contact_length: .*roller.length"):
        given("conjugate_rocker", impact={"contact_length": 20.04})
