"""Every key of every section, for all kinds of cam and all followers: changed, it changes a result or is refused.

A key that does nothing in silence flatters a design: what its author meant is not what was judged. The few keys that
only name things, or only say how a file is written, are listed with the reason.
"""

from __future__ import annotations

import copy
import json
import os
import tomllib
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal, get_args, get_origin

import pytest
from pydantic import BaseModel

import camgeom
from camgeom.cams import starter
from camgeom.errors import CamgeomError, DesignError, ExportError, ProfileError
from camgeom.model import Model
from camgeom.profile import Profile, from_data
from camgeom.profile.errors import models_in
from camgeom.report.result import compute
from tests.places import PROFILES

Data = dict[str, Any]

STAGES = (("motion", "contact", "fatigue"), ("flank",), ("checks",), ("dynamics",), ("solid",), ("cutter",))
"""products in the order of what they cost; a key is looked for in the next where the last does not know it"""

ONLY_NAMES = "a name, shown and not judged"
ONLY_FILE = "how a file is written"
EXEMPT = {
    "name": ONLY_NAMES,
    "material.cam.name": ONLY_NAMES,
    "material.roller.name": ONLY_NAMES,
    "output.formats": ONLY_FILE,
    "output.table_points": ONLY_FILE,
    "output.table_tolerance": ONLY_FILE,
    "output.undercut_solid": "speaks of undercut drums alone; theirs is tested in tests/solid",
    "cutter.gouge_limit": "none of these tools cuts into a flank",
    "follower.kind": "another kind is another section",
    "cam.kind": "another kind is another section",
    "roller.shape": "another shape is another section",
}
"""Keys that change no figure, with the reason."""
EXEMPT_OF = {
    ("disc, arm with flat face", "follower.arm"): "every swinging follower has an arm; a flat face has no roller at it",
    ("disc, flat face", "limits.warn_pressure_angle_deg"): "the pressure angle of a sliding flat face is always 0",
    ("frame", "limits.warn_pressure_angle_deg"): "the pressure angle of a frame's flat faces is always 0",
    ("disc, arm with flat face", "limits.warn_pressure_angle_deg"): "a flat face through the pivot pushes square to it",
    **{
        ("drum, impact", f"impact.{key}"): "a groove slides past its roller far above the slip_speed"
        for key in ("static_friction", "stick_speed", "slip_speed")
    },
    ("globoid, mill", "cutter.max_feed"): "the tool's centre is nowhere that much faster than the contact",
    ("drum, mill", "cutter.lead"): "there is less room beside the flank than either radius takes",
    ("frame", "follower.clearance"): "the play of the assembly, which acts where [impact] is solved",
    ("yoke", "follower.clearance"): "the play of the assembly, which acts where [impact] is solved",
}
"""The same for keys of one case."""

DISC = """
[cam]
kind = "disc"
base_radius = 40
width = 14
bore = 20
keyway_width = 6
keyway_depth = 2.8
[[motion]]
until = 120
to = 12
law = "cycloidal"
[[motion]]
until = 160
[[motion]]
until = 280
to = 0
law = "cycloidal"
[[motion]]
until = 360
[operation]
speed = 300
friction = 5
spring_rate = 3
spring_preload = 90
"""
SLIDING = '[follower]\nkind = "translating"\nmass = 0.5\n'
SWINGING = '[follower]\nkind = "swinging"\narm = 90\ninertia = 0.004\n'
ROLLER = '[roller]\ndiameter = 20\nlength = 12\n'
PIVOT = {"cam.center_distance": 110.0}
GROOVE = {"cam.form": "groove", "cam.diameter": 180.0, "cam.groove_depth": 8.0, "roller.length": 7.0}
ELASTIC = {"dynamics.kind": "follower", "dynamics.linkage_stiffness": 4000.0, "dynamics.linkage_damping": 60.0}
IMPACT = {"impact.clearance": 0.05, "impact.turns": 2, "impact.tolerance": 1e-6}
FRICTION = {"impact.static_friction": 0.1, "impact.dynamic_friction": 0.04}
CREEP = {"impact.roller_inertia": 20.0, "impact.stick_speed": 0.1, "impact.slip_speed": 0.4}
"""a roller that rolls creeps at a hundredth of the sliding speeds; at the default it sticks and no step is left"""
MILL = {"cutter.kind": "flat", "cutter.diameter": 12.0, "cutter.tolerance": 0.05}
BALL = {"cutter.kind": "ball", "cutter.diameter": 8.0, "cutter.scallop": 0.4, "cutter.tolerance": 0.05}
WHEEL = {"cutter.kind": "wheel", "cutter.diameter": 80.0, "cutter.tolerance": 0.05}


def _starter(kind: str) -> str:
    return starter(kind)


def _profile(name: str) -> str:
    return (PROFILES / f"{name}.toml").read_text(encoding="utf-8")


CASES: dict[str, tuple[str, Data]] = {
    "disc, roller": (DISC + SLIDING + ROLLER, {}),
    "disc, flat face": (DISC + SLIDING, {"follower.face": "flat", "follower.face_width": 60.0}),
    "disc, knife": (DISC + SLIDING, {"follower.face": "knife"}),
    "disc, curved face": (DISC + SLIDING, {"follower.face": "curved", "follower.face_radius": 60.0}),
    "disc, groove": (DISC + SLIDING + ROLLER, GROOVE),
    "disc, arm with roller": (DISC + SWINGING + ROLLER, PIVOT),
    "disc, arm with flat face": (DISC + SWINGING, {**PIVOT, "follower.face": "flat", "follower.face_width": 130.0}),
    "drum, groove": (_starter("cylindrical"), {}),
    "drum, rib": (_starter("cylindrical"), {"cam.form": "rib", "cam.rib_thickness": 12.0}),
    "drum, arm": (_profile("steep_shuttle"), {}),
    "pair, rocker": (_starter("conjugate"), {}),
    "pair, slide": (DISC + SLIDING + ROLLER, {"cam.kind": "conjugate", "follower.clearance": 0.02}),
    "frame": (_starter("constant-width"), {"roller": None}),
    "yoke": (_starter("constant-width"), {"roller": {"diameter": 16.0, "length": 10.0}, "follower.face_width": None}),
    "globoid": (_profile("tool_changer"), {"dynamics": None}),
    "barrel": (_starter("cylindrical-index"), {"dynamics": None}),
    "plates": (_starter("parallel-index"), {"dynamics": None}),
    "drum, elastic": (_starter("cylindrical"), {**ELASTIC, "dynamics.tappet_mass": 0.1}),
    "disc, elastic": (DISC + SLIDING + ROLLER, {**ELASTIC, "dynamics.shaft_inertia": 0.01,
                                                "dynamics.shaft_stiffness": 9000.0}),
    "indexing drive": (_profile("tool_changer"), {}),
    "pair, impact": (_starter("conjugate"), {**IMPACT, **FRICTION, **CREEP}),
    "drum, impact": (_starter("cylindrical"), {**IMPACT, **FRICTION}),
    "drum, mill": (_starter("cylindrical"), MILL),
    "drum, ball": (_starter("cylindrical"), BALL),
    "disc, mill": (DISC + SLIDING + ROLLER, MILL),
    "disc, wheel": (DISC + SLIDING + ROLLER, WHEEL),
    "globoid, mill": (_profile("tool_changer"), {"dynamics": None, **MILL}),
}  # fmt: skip
"""Cams with their followers, and solvers and tools: a profile and what is changed in it (None takes away)."""
SOLVED = {"elastic": "dynamics", "drive": "dynamics", "impact": "impact", "mill": "cutter", "ball": "cutter",
          "wheel": "cutter"}  # fmt: skip
"""The one section whose keys are changed, of cases that have a solver or a tool beside the cam of another case."""
FIRST = {"dynamics": 3, "impact": 3, "cutter": 6}
"""The stage that knows most keys of a section."""
QUICK = ("disc, flat face", "drum, groove")

MILD: Data = {
    "follower.offset": 3.0, "follower.face_radius": 50.0, "follower.face_width": 25.0, "follower.face_offset": 2.0,
    "follower.clearance": 0.03, "follower.pivot_distance": 80.0, "follower.start_angle": -3.0, "follower.rollers": 16,
    "cam.diameter": 190.0, "cam.groove_depth": 9.0, "cam.running_clearance": 0.02, "cam.center_distance": 112.0,
    "cam.pitch_radius": 45.0, "cam.rib_thickness": 11.0, "cam.bore": 12.0, "cam.keyway_width": 4.0,
    "cam.keyway_depth": 2.0, "cam.mark_radius": 20.0, "cam.mark_diameter": 5.0, "cam.return_arm": 95.0,
    "cam.rocker_angle": 90.0, "cam.return_radius": 55.0, "cam.gap": 2.0, "cam.relief": 0.01, "cam.relief_angle": 4.0,
    "cam.preload": 0.004, "cam.hub_diameter": 60.0, "cam.hub_length": 8.0, "cam.tip_clearance": 0.7,
    "material.cam.hardness": 35.0, "material.roller.hardness": 35.0,
    "roller.dynamic_rating": 9000.0, "roller.static_rating": 8000.0, "roller.half_angle": 5.0, "roller.length": 9.0,
    "operation.guide_friction": 0.05, "operation.load_mass": 0.4, "operation.load_inertia": 0.02,
    "operation.gravity": 9.81, "operation.friction": 25.0, "operation.spring_rate": 2.0,
    "operation.spring_preload": 60.0, "operation.force": ({"from": 60.0, "until": 110.0, "expression": "30"},),
    "limits.min_wall_mm": 2.5, "limits.undercut_margin": 0.02, "limits.clearance_mm": 0.001, "limits.life_h": 1e8,
    "limits.warn_undercut_margin": 0.99, "limits.warn_pressure_angle_deg": 3.0, "limits.pressure_angle_deg": 41.0,
    "limits.contact_pressure_mpa": 333.0, "limits.warn_rib_share": 0.99,
    "dynamics.method": "gauss2", "dynamics.steps": 64, "dynamics.sweep": (100.0, 200.0), "dynamics.mass": 0.7,
    "dynamics.return_stiffness": 5.0, "dynamics.preload": 70.0, "dynamics.tappet_mass": 0.1,
    "dynamics.tappet_stiffness": 9000.0, "dynamics.shaft_inertia": 0.02, "dynamics.shaft_stiffness": 8000.0,
    "dynamics.cam_inertia": 0.02, "dynamics.turret_inertia": 0.5, "dynamics.load_inertia": 0.6,
    "dynamics.contact_stiffness": 2e6, "dynamics.fluctuation": 0.02, "dynamics.tolerance": 1e-4,
    "dynamics.linkage_damping": 90.0, "dynamics.settling_band": 1e-4,
    "impact.roller_inertia": 30.0, "impact.study": (0.02, 0.04), "impact.laws": ("modified-sine",),
    "impact.settle": 0, "impact.turns": 3, "impact.contact_length": 7.0, "impact.reference_radius": 33.0,
    "impact.inertia": 1.7, "impact.damping": 2.0, "impact.stiffness": 1e5, "impact.exponent": 1.4,
    "impact.dynamic_friction": 0.05, "impact.static_friction": 0.2, "impact.tolerance": 1e-5, "impact.restitution": 0.7,
    "cutter.length": 30.0, "cutter.width": 6.0, "cutter.neck": 1.0, "cutter.allowance": 0.1, "cutter.lead": 2.0,
    "cutter.overrun": 1.0, "cutter.pivot": 50.0, "cutter.start_angle": 20.0,
    "cutter.rotary": "B", "cutter.max_feed": 310.0,
}  # fmt: skip
"""Values that any of the cases would take, other than those that stand there, for keys that have no size to vary."""


def made(case: str) -> Data:
    """The plain data of a case, on a coarse mesh."""
    text, changes = CASES[case]
    data = tomllib.loads(text)
    data["output"] = {"tolerance": 0.1}
    for key, value in changes.items():
        put(data, key, value)
    return data


def put(data: Data, key: str, value: Any) -> None:
    """Set a key by its dotted path; None takes it away."""
    *sections, last = key.split(".")
    for name in sections:
        data = data.setdefault(name, {})
    if value is None:
        data.pop(last, None)
    else:
        data[last] = value


def frozen(value: Any) -> Any:
    """Arrays as tuples, as the reader has them."""
    if isinstance(value, dict):
        return {key: frozen(item) for key, item in value.items()}
    return tuple(map(frozen, value)) if isinstance(value, list | tuple) else value


def sections(case: str, profile: Profile) -> Iterator[tuple[str, type[BaseModel]]]:
    """Every section of a case with its own type: those it has, and those that any profile may have."""
    only = SOLVED.get(case.rpartition(", ")[2].rpartition(" ")[2])
    if only is not None:
        yield only, type(getattr(profile, only))
        return
    for name in ("cam", "follower", "roller"):
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
            model.append(Model(from_data(frozen(data), "")))
        found: object = compute(model[0], STAGES[number]).data if number < len(STAGES) else tool_files(model[0])
    except CamgeomError as error:
        return f"{type(error).__name__}: {error}"
    return json.dumps(found, sort_keys=True, default=str)


@cache
def known(case: str, number: int) -> str:
    """What a stage finds of a case as it stands."""
    return stage(made(case), number, _models(case))


@cache
def _models(case: str) -> list[Model]:
    return []


def idle(case: str) -> list[str]:
    """The keys of a case that may take another value without any effect."""
    data = made(case)
    profile = from_data(frozen(data), "")
    found = []
    for section, model in sections(case, profile):
        for name, field in model.model_fields.items():
            key = f"{section}.{field.alias or name}"
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
        model.append(Model(from_data(frozen(data), "")))
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
    monkeypatch.setattr("camgeom.profile.idle_problems", lambda profile, setup: [])
    quiet = {line.split()[0] for line in idle("disc, flat face")}
    assert {"follower.clearance", "follower.face_radius", "cam.groove_depth"} <= quiet
    assert not {"follower.face_width", "cam.base_radius", "limits.contact_pressure_mpa"} & quiet
