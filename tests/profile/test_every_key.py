"""Every key of every section, for all kinds of cam and all followers: changed, it changes a result or is refused.

A key that does nothing in silence flatters a design: what its author meant is not what was judged. The few keys that
only name things, or only say how a file is written, are listed with the reason.
"""

from __future__ import annotations

import copy
import json
import os
import re
from collections.abc import Container, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, get_args, get_origin

import pytest
from pydantic import BaseModel

import camgeom
from camgeom.errors import CamgeomError, DesignError, ExportError, ProfileError
from camgeom.model import Model
from camgeom.profile import Profile, from_data
from camgeom.profile.errors import models_in
from camgeom.report.result import compute
from tests.profile.cases import CASES, MILD, Data, frozen, made, put
from tests.reference.profiles import built

STAGES = (("motion", "contact", "fatigue"), ("flank",), ("checks",), ("dynamics",), ("solid",), ("cutter",))
"""products in the order of what they cost; a key is looked for in the next where the last does not know it"""

ONLY_NAMES = "a name, shown and not judged"
ONLY_FILE = "how a file is written"
EXEMPT = {
    "name": ONLY_NAMES,
    "units": "another way to state the same lengths: tested in tests/profile/test_units.py",
    "reproduces": "names what the report tells beside the design",
    "material.cam.name": ONLY_NAMES,
    "material.roller.name": ONLY_NAMES,
    "output.formats": ONLY_FILE,
    "output.table_points": ONLY_FILE,
    "output.table_tolerance": ONLY_FILE,
    "output.load_angle_deg": "the load of volume files and of the body's stress: tested in tests/body",
    "material.cam.bending_limit": "the body is solved with it, which takes a minute: tested in tests/body",
    "material.roller.bending_limit": "the frame is solved with it: tested in tests/body",
    "dynamics.body_compliance": "the body is solved with it: tested in tests/body",
    "output.undercut_solid": "speaks of undercut drums alone; theirs is tested in tests/solid",
    "cutter.gouge_limit": "none of these tools cuts into a flank",
    "follower.kind": "another kind is another section",
    "cam.kind": "another kind is another section",
    "roller.shape": "another shape is another section",
    "return_roller.shape": "another shape is another section",
}
"""Keys that change no figure, with the reason."""
EXEMPT_OF = {
    ("disc, arm with flat face", "limits.warn_pressure_angle_deg"): "a flat face through the pivot pushes square to it",
    ("disc, arm with flat face", "follower.arm"): "asked of every arm; a face through the pivot touches where it does",
    **{
        ("drum, impact", f"impact.{key}"): "a groove slides past its roller far above the slip_speed"
        for key in ("static_friction", "stick_speed", "slip_speed")
    },
    **{
        ("drum, groove", f"roller.{key}"): "a half-space is solved with it, for seconds: tested in tests/mechanics"
        for key in ("misalignment_deg", "end_radius")
    },
    ("globoid, mill", "cutter.max_feed"): "the tool's centre is nowhere that much faster than the contact",
}
"""The same for keys of one case."""

SOLVED = {"elastic": "dynamics", "drive": "dynamics", "impact": "impact", "mill": "cutter", "ball": "cutter",
          "wheel": "cutter"}  # fmt: skip
"""The one section whose keys are changed, of cases that have a solver or a tool beside the cam of another case."""
FIRST = {"limits": 2, "dynamics": 3, "impact": 3, "cutter": 6}
"""The stage that knows most keys of a section."""
QUICK = ("disc, flat face", "drum, groove")


def sections(case: str, profile: Profile) -> Iterator[tuple[str, type[BaseModel]]]:
    """Every section of a case with its own type: those it has, and those that any profile may have."""
    only = SOLVED.get(case.rpartition(", ")[2].rpartition(" ")[2])
    if only is not None:
        yield only, type(getattr(profile, only))
        return
    for name in ("cam", "follower", "roller", "return_roller"):
        if getattr(profile, name) is not None:
            yield name, type(getattr(profile, name))
    for name in ("operation", "material", "output", "limits"):
        model = next(iter(models_in(Profile.model_fields[name].annotation)))
        if name != "material":
            yield name, model
        else:
            yield from ((f"material.{body}", type(getattr(profile.material, body))) for body in model.model_fields)


def other_values(key: str, old: Any, annotation: Any, default: Any) -> list[Any]:
    """Values that a key may take in place of the old one."""
    if key == "dynamics.method":
        return ["gauss4"]  # the paper's methods take minutes for the same figures
    if choices := list(_choices(annotation)):
        return [word for word in choices if word not in (old, default if old is None else old)]
    old = default if old is None else old
    if isinstance(old, bool):
        return [not old]
    if key in MILD and old != MILD[key]:
        return [MILD[key]]
    if isinstance(old, int):
        return [old + 1]
    if isinstance(old, float):
        return [1.03 * old if old else 0.7, 0.97 * old]
    return [] if isinstance(old, tuple) else [0.9]


def _choices(annotation: Any) -> Iterator[Any]:
    if get_origin(annotation) is Literal:
        yield from get_args(annotation)
    else:
        for argument in get_args(annotation):
            yield from _choices(argument)


def stage(data: Data, number: int, model: list[Model]) -> str:
    """What a stage finds, or what refuses it."""
    try:
        if not model:
            model.append(built(data))
        found: object = compute(model[0], STAGES[number]).data if number < len(STAGES) else tool_files(model[0])
    except CamgeomError as error:
        return f"{type(error).__name__}: {error}"
    return re.sub(r"-?\d+\.\d+(e[-+]?\d+)?", _rounded, json.dumps(found, sort_keys=True, default=str))


def _rounded(number: re.Match[str]) -> str:
    """A number as far as it is one of the design: seven digits, and nothing of what is rounding beside one."""
    value = float(number[0])
    return f"{value:.7g}" if abs(value) > 1e-12 else "0"


@cache
def known(case: str, number: int) -> str:
    """What a stage finds of a case as it stands."""
    return stage(made(case), number, _models(case))


@cache
def _models(case: str) -> list[Model]:
    return []


def idle(case: str, among: Container[str] | None = None) -> list[str]:
    """The keys of a case, all or those among some, that may take another value without any effect."""
    data = made(case)
    profile = from_data(frozen(data), "")
    found = []
    for section, model in sections(case, profile):
        for name, field in model.model_fields.items():
            key = f"{section}.{field.alias or name}"
            if among is not None and key not in among:
                continue
            if field.json_schema_extra or key in EXEMPT or (case, key) in EXEMPT_OF:
                continue
            old = data
            for part in key.split("."):
                old = old.get(part, {}) if isinstance(old, dict) else old
            old = None if old == {} else old
            values = other_values(key, frozen(old), field.annotation, field.get_default(call_default_factory=True))
            if not any(acts(case, key, value) for value in values):
                found.append(f"{key} {values}")
    return found


def acts(case: str, key: str, value: Any) -> bool:
    """Whether a key with another value changes a result, or is refused."""
    data, model = copy.deepcopy(made(case)), list[Model]()
    put(data, key, value)
    try:
        model.append(built(data))
    except ProfileError:
        return True
    first = FIRST.get(key.split(".")[0])
    stages = sorted(range(len(STAGES) + ("cutter" in data)), key=lambda number: number != first)
    return any(stage(data, number, model) != known(case, number) for number in stages)


def tool_files(model: Model) -> list[str]:
    """What is written for the machine and its operator."""
    with TemporaryDirectory() as folder:
        files = [Path(folder, f"cam.{name}") for name in ("gcode", "apt", "cutter.csv", "rest.csv")]
        for file in files:
            with suppress(DesignError, ExportError):
                camgeom.write(model, file)
        return [file.read_text(encoding="utf-8") for file in files if file.exists()]


LONG = (
    pytest.mark.slow,
    pytest.mark.skipif("CAMGEOM_JUDGE" not in os.environ, reason="takes minutes: scripts/test --judge"),
)
MARKED = [pytest.param(case, marks=() if case in QUICK else LONG) for case in CASES]


@pytest.mark.parametrize("case", MARKED)
def test_every_key_acts_or_is_refused(case: str) -> None:
    assert idle(case) == []


def test_the_search_knows_a_key_that_does_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The other side: where nothing is refused, the search names the keys that nothing reads."""
    monkeypatch.setattr("camgeom.profile.idle_problems", lambda *_: [])
    nothing = {"follower.clearance", "follower.face_radius", "cam.groove_depth"}
    acting = {"follower.face_width", "cam.base_radius", "limits.contact_pressure_mpa"}
    assert {line.split()[0] for line in idle("disc, flat face", nothing | acting)} == nothing
