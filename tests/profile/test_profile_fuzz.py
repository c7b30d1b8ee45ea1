"""Whatever a profile holds, reading it gives a Profile or a ProfileError: no other exception, no warning, no hang."""

from __future__ import annotations

import copy
import json
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camgeom.cams import kinds
from camgeom.errors import ProfileError
from camgeom.motion import LAWS
from camgeom.profile import from_data, parse
from camgeom.profile.errors import keys_of
from camgeom.profile.reader import FOLLOWERS, PLAIN_SECTIONS, ROLLERS
from camgeom.profile.schema import schema
from camgeom.profile.text import load
from tests.places import ROOT

BASE = load(
    """
[cam]
kind = "cylindrical"
diameter = 134
length = 110
start = 18
groove_depth = 13
[follower]
kind = "translating"
[roller]
diameter = 22
length = 12
[[motion]]
until = 155
to = 37
law = "cycloidal"
[[motion]]
until = 360
to = 0
law = "polynomial"
[operation]
speed = 600
[[operation.force]]
from = 200
until = 300
expression = "8 * sin(phi)"
[limits]
life_h = 100
[output]
tolerance = 0.01
""",
    "",
)[0]

TURRET = {
    "cam": {"kind": "globoidal", "center_distance": 180, "width": 90, "globoid_radius": 100, "bore": 40},
    "follower": {"kind": "turret", "stops": 8, "pitch_radius": 105},
    "roller": {"diameter": 32, "length": 24},
    "motion": ({"until": 120, "to": 45, "law": "modified-sine"}, {"until": 360}),
    "impact": {"law": "power", "stiffness": 1e5, "study": (0.1, 0.2)},
}

numbers = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False),
    st.integers(-(10**18), 10**18),
    st.sampled_from([0, -1, 1, 1e-300, 1e-6, 1e-5, 360, 1e5, 1e9, 1e300, 0.5, 90, 180]),
)
words = st.one_of(
    st.sampled_from([*kinds(), *FOLLOWERS, *ROLLERS, *LAWS, "groove", "rib", "cw", "../x.csv", "x.csv", "sin(phi)"]),
    st.text(max_size=20),
)
SECTIONS = [*FOLLOWERS.values(), *ROLLERS.values(), *PLAIN_SECTIONS.values()]
SEGMENT_KEYS = ["until", "to", "law", "velocity", "acceleration", "jerk", "share", "points", "rows", "control", "file"]
OTHER_KEYS = ["cam", "follower", "roller", "motion", "kind", "shape", "diameter", "exponents", "parameters", "source"]
keys = st.one_of(
    st.sampled_from(sorted({*SEGMENT_KEYS, *OTHER_KEYS, *(key for model in SECTIONS for key in keys_of(model))})),
    st.text(max_size=8),
)
values = st.recursive(
    st.one_of(numbers, words, st.booleans()),
    lambda inner: st.one_of(st.lists(inner, max_size=4).map(tuple), st.dictionaries(keys, inner, max_size=4)),
    max_leaves=12,
)


def places(data: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """Every path in the data."""
    found = [at] if at else []
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, tuple) else ()
    for key, value in items:
        found += places(value, (*at, key))
    return found


def put(data: Any, path: tuple[Any, ...], value: Any) -> Any:
    """The data with one value replaced or added."""
    if not path:
        return value
    head, *rest = path
    if isinstance(data, tuple):
        return tuple(put(item, tuple(rest), value) if i == head else item for i, item in enumerate(data))
    inner = data.get(head, {}) if isinstance(data, dict) else {}
    return {**(data if isinstance(data, dict) else {}), head: put(inner, tuple(rest), value)}


SLOW = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow], max_examples=80)


def read(data: Any) -> None:
    try:
        from_data(data, "fuzz.toml")
        return
    except ProfileError as error:
        text = str(error)
    assert text.startswith("fuzz.toml: ")
    assert "Input should" not in text, "a message of the validator came through"


@SLOW
@given(st.lists(st.tuples(st.sampled_from(places(BASE)), values), min_size=1, max_size=3))
def test_wrong_values(changes: list[tuple[tuple[Any, ...], Any]]) -> None:
    data = copy.deepcopy(BASE)
    for path, value in changes:
        data = put(data, path, value)
    read(data)


@SLOW
@given(st.lists(st.tuples(st.sampled_from(places(TURRET)), values), min_size=1, max_size=3))
def test_wrong_values_of_a_turret(changes: list[tuple[tuple[Any, ...], Any]]) -> None:
    data = copy.deepcopy(TURRET)
    for path, value in changes:
        data = put(data, path, value)
    read(data)


@SLOW
@given(st.lists(st.tuples(st.sampled_from([(), *places(BASE)]), keys, values), min_size=1, max_size=3))
def test_stray_keys(changes: list[tuple[tuple[Any, ...], str, Any]]) -> None:
    data = copy.deepcopy(BASE)
    for path, key, value in changes:
        data = put(data, (*path, key), value)
    read(data)


@SLOW
@given(st.sampled_from(sorted(LAWS)), st.dictionaries(keys, values, max_size=4), numbers, numbers)
def test_laws_with_any_parameters(law: str, parameters: dict[str, Any], to: float, until: float) -> None:
    own = {key: parameters.get(key) for key in LAWS[law].parameters if key in parameters}
    segment = {**parameters, **own, "until": until, "to": to, "law": law}
    read({**BASE, "motion": (segment, {"until": 360, "to": 0, "law": "cycloidal"})})


@SLOW
@given(st.sampled_from(sorted(LAWS)), st.data())
def test_laws_with_parameters_of_the_right_kind(law: str, data: st.DataObject) -> None:
    kinds_of = {
        "number": numbers,
        "integer": st.integers(-5, 500),
        "switch": st.booleans(),
        "text": words,
        "list": st.lists(st.one_of(numbers, st.lists(numbers, max_size=3).map(tuple)), max_size=6).map(tuple),
    }
    own = {name: data.draw(kinds_of[p.kind]) for name, p in LAWS[law].parameters.items() if data.draw(st.booleans())}
    rates = data.draw(st.dictionaries(st.sampled_from(["velocity", "acceleration", "jerk"]), numbers, max_size=2))
    segment = {**own, **rates, "until": 100, "to": 30, "law": law}
    read({**BASE, "motion": (segment, {"until": 360, "to": 0, "law": "polynomial"})})


@SLOW
@given(st.text(max_size=200))
def test_any_text(text: str) -> None:
    with pytest.raises(ProfileError, match=r"\Afuzz.toml: "):
        parse(text, "fuzz.toml")


@SLOW
@given(values)
def test_whatever_stands_at_the_top(value: Any) -> None:
    read(value if isinstance(value, dict) else {"cam": value, "motion": value})


def test_schema_knows_every_key() -> None:
    found = schema()
    json.dumps(found, allow_nan=False)
    assert found["$schema"].endswith("2020-12/schema")
    assert {table["title"] for table in found["properties"]["cam"]["oneOf"]} == set(kinds())
    assert {table["title"] for table in found["properties"]["motion"]["items"]["oneOf"]} == {"dwell", *LAWS}
    speed = found["properties"]["operation"]["properties"]["speed"]
    assert speed["exclusiveMinimum"] == 0.0
    assert "r/min" in speed["description"]


@pytest.mark.parametrize("kind", ["globoidal", "cylindrical-index"])
def test_a_turret_that_never_turns_and_another_fault(kind: str) -> None:
    # Found by the fuzz campaign: the motion is judged although another section is wrong, and it has no index at all.
    cam = {"kind": kind, "center_distance": (1.0, 2.0), "width": 90.0}
    with pytest.raises(ProfileError, match="a turret needs a segment that turns it on"):
        from_data({**TURRET, "cam": cam, "motion": ({"until": 120.0}, {"until": 360.0})}, "fuzz.toml")


@pytest.mark.parametrize("key", ["points", "control"])
def test_lists_of_a_law_hold_numbers_that_derivatives_can_be_formed_of(key: str) -> None:
    law, good, bad = ("spline", ((0.5, 1e12),), ((0.5, 1e299),)) if key == "points" else ("b-spline", (1e12,), (1e299,))
    for values_, accepted in ((good, True), (bad, False)):
        segment = {"until": 155.0, "to": 37.0, "law": law, key: values_}
        data = {**BASE, "motion": (segment, {"until": 360.0, "to": 0.0, "law": "cycloidal"})}
        if accepted:
            assert from_data(data).setup().program.extremes(0)[1].value > 1e10
        else:
            with pytest.raises(ProfileError, match=rf"motion\[0\].{key}"):
                from_data(data, "fuzz.toml")


def test_the_short_fuzz_campaign() -> None:
    import sys

    sys.path.insert(0, str(ROOT / "scripts" / "stability"))
    import fuzz

    failures = [found for found in map(fuzz.fuzz, range(60)) if found[2] == "FAILURE"]
    assert not failures
