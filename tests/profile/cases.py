"""Profiles of every kind of cam, follower, roller, tool and solver, as data that a test changes key by key."""

from __future__ import annotations

import tomllib
from typing import Any

from camgeom.cams import starter
from tests.places import PROFILES

Data = dict[str, Any]

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
MOVES = """
until = 150
to = 25
law = "modified-sine"
[[motion]]
until = 330
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""
"""out and back by two laws, then a dwell: the segments after the first [[motion]]"""
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
    "disc, cone": (DISC + SLIDING + ROLLER, {"roller.shape": "cone", "roller.half_angle": 8.0}),
    "disc, arm with cone": (DISC + SWINGING + ROLLER, {**PIVOT, "roller.shape": "cone", "roller.half_angle": -8.0}),
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
    "pair, two rollers": (DISC + SLIDING + ROLLER + '[return_roller]\ndiameter = 26\nlength = 12\n',
                          {"cam.kind": "conjugate", "follower.clearance": 0.02, "return_roller.dynamic_rating": 7000.0,
                           "operation.speed": 1200.0, "operation.spring_rate": None, "operation.spring_preload": None}),
    "frame": (_starter("constant-width"), {"roller": None}),
    "frame, plate": (_starter("constant-width"), {"roller": None, "operation.load_mass": 1.0, **{
        f"follower.{key}": size for key, size in {
            "plate_length": 150.0, "plate_width": 185.0, "plate_thickness": 20.0, "window_width": 150.0,
            "face_height": 4.0, "window_radius": 3.0, "guide_bore": 8.0, "guide_spacing": 168.0}.items()}}),
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
MILD: Data = {
    "follower.offset": 3.0, "follower.face_radius": 50.0, "follower.face_width": 25.0, "follower.face_offset": 2.0,
    "follower.clearance": 0.03, "follower.plate_length": 152.0, "follower.plate_width": 186.0,
    "follower.plate_thickness": 12.0, "follower.window_width": 151.0, "follower.face_height": 4.5,
    "follower.window_radius": 2.5, "follower.guide_bore": 7.0, "follower.guide_spacing": 167.0,
    "follower.pivot_distance": 80.0, "follower.start_angle": -3.0, "follower.rollers": 16,
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
    "limits.contact_pressure_mpa": 333.0, "limits.warn_rib_share": 0.99, "limits.play_mm": 0.3,
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
