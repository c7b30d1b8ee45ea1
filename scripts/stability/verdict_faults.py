"""Faults of known classes, one injected into a sound design, and who must speak of each.

A class says for which kinds it means something, what it does to the profile (or to the finished body, as a machinist
or a careless mesher would), which checks may answer for it, and what a refusal must name. Nothing here asks the
product what is right.
"""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import dataclass, field
from math import acos, cos, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
from designs import Dice
from numpy.typing import NDArray
from verdict_designs import KINDS, LIMIT, Data

Change = Callable[[Data, Dice], None]
Floats = NDArray[np.float64]
DRUMS = tuple(kind for kind in KINDS if kind.startswith("drum"))
RIBS = tuple(kind for kind in KINDS if kind.startswith("drum rib"))
DISCS = tuple(kind for kind in KINDS if kind.startswith("disc"))
PLATES = tuple(kind for kind in KINDS if kind.startswith("face groove"))
WIDTHS, PAIRS = ("frame", "yoke"), ("rocker", "slide")
GLOBOIDS = ("globoid rib", "globoid groove")
SIDE_BY_SIDE = tuple(kind for kind in KINDS if kind.startswith("parallel"))
TURRETS = (*GLOBOIDS, "barrel", *SIDE_BY_SIDE)
SLIDING = ("disc, flat", "disc, curved", "frame")
ROLLING = tuple(kind for kind in KINDS if kind not in SLIDING)
BORED = tuple(KINDS)
KEYED = tuple(kind for kind in KINDS if kind not in ("disc, swinging roller", "face groove, swinging", "rocker"))
"""where the cam's least radius lies beside the keyway, on +X: swinging followers meet it at another angle"""


@dataclass(frozen=True)
class Fault:
    """A class of faults.

    checks   whose finding answers for it: a failure, or where `warns` a warning
    refusal  words of which a refused profile names one
    body     what is done to the finished body: "made with" the profile before the change, "moved", "coarse"
    pending  its checks are not in the product yet
    """

    kinds: tuple[str, ...]
    change: Change
    checks: tuple[str, ...]
    refusal: tuple[str, ...] = ()
    warns: bool = False
    body: str = ""
    pending: str = ""
    words: tuple[str, ...] = field(default=())


def thin_bore(data: Data, dice: Dice) -> None:
    """A bore that leaves 0.05 to 0.4 mm to the thinnest place beyond it."""
    cam, wall = data["cam"], dice.between(0.05, 0.4)
    for key in ("keyway_width", "keyway_depth", "hub_diameter", "hub_length"):
        cam.pop(key, None)
    cam["bore"] = 2.0 * (solid_core(data) - wall)


def solid_core(data: Data) -> float:
    """Radius about the axis that no follower ever cuts, mm."""
    cam, roller, follower = data["cam"], data.get("roller", {}), data["follower"]
    radius = 0.5 * roller.get("diameter", 0.0)
    match cam["kind"]:
        case "cylindrical":
            return float(0.5 * cam["diameter"] - cam["groove_depth"])
        case "globoidal":
            deep = follower["pitch_radius"] + 0.5 * roller["length"] + cam["tip_clearance"]
            return float(cam["center_distance"] - deep)
        case "cylindrical-index":
            # A roller's end that is inclined reaches deepest beside its middle: the estimate is from below.
            sag = follower["pitch_radius"] - cam["center_distance"]
            return float(0.5 * cam["diameter"] - roller["length"] - cam["tip_clearance"] - max(sag, 0.0) * 0.0)
        case "parallel-index":
            return float(cam["center_distance"] - follower["pitch_radius"] - radius - cam.get("running_clearance", 0.0))
        case "conjugate":
            return float(cam["base_radius"])
        case _:
            return float(cam["base_radius"] - cam.get("running_clearance", 0.0))


def thin_keyway(data: Data, dice: Dice) -> None:
    """A keyway that leaves 0.05 to 0.4 mm above its floor."""
    thin_bore(data, dice)
    core = 0.5 * data["cam"]["bore"]
    data["cam"] |= {"bore": 1.4 * core, "keyway_width": 0.3 * core}
    # The corner of the keyway lies farther out than its floor.
    data["cam"]["keyway_depth"] = sqrt(core**2 - (0.15 * core) ** 2) - 0.7 * core


def thin_end(data: Data, dice: Dice) -> None:
    """A groove 0.05 to 0.4 mm above the drum's lower end."""
    cam = data["cam"]
    roller = data["roller"]
    # A cone is widest at the drum's outside, half its length from where its diameter is quoted.
    widest = 0.5 * roller["diameter"] + 0.6 * roller["length"] * tan(radians(roller.get("half_angle", 0.0)))
    cam["start"] = widest + cam.get("running_clearance", 0.0) + dice.between(0.05, 0.4)


def thin_rim(data: Data, dice: Dice) -> None:
    """A plate whose rim is 0.05 to 0.4 mm thick beside the groove at its widest."""
    cam = data["cam"]
    cam["diameter"] = 2.0 * (_reach(data) + dice.between(0.05, 0.4))


def _reach(data: Data) -> float:
    """Farthest point of a face groove from the axis, mm, from the roller's places alone."""
    cam, follower, radius = data["cam"], data["follower"], 0.5 * data["roller"]["diameter"]
    stroke = max(s.get("to", 0.0) for s in data["motion"])
    prime = cam["base_radius"] + radius
    if follower["kind"] == "swinging":
        # The law of cosines: the arm opens from where the roller stands on the prime circle.
        a, c = follower["arm"], cam["center_distance"]
        opening = acos((a * a + c * c - prime * prime) / (2.0 * a * c)) + radians(stroke)
        prime = sqrt(a * a + c * c - 2.0 * a * c * cos(opening))
    else:
        prime += stroke
    return float(prime + radius + cam.get("running_clearance", 0.0))


def thin_floor(data: Data, dice: Dice) -> None:
    """A face groove that leaves 0.05 to 0.4 mm of the plate."""
    data["cam"]["width"] = data["cam"]["groove_depth"] + dice.between(0.05, 0.4)


def short_drum(data: Data, dice: Dice) -> None:
    """A drum that ends before the stroke does: the roller's centre leaves it."""
    stroke = data["cam"]["length"] - 2.0 * data["cam"]["start"]
    data["cam"]["length"] = data["cam"]["start"] + stroke * dice.between(0.4, 0.9)


def crossing_rib(data: Data, dice: Dice) -> None:
    """A rib so thin and steep that its flanks cross: (t + 2 r) cos(angle) - 2 r below zero."""
    cam, radius = data["cam"], 0.5 * data["roller"]["diameter"]
    cam["rib_thickness"] = radius * dice.between(0.15, 0.3)
    _steeper(data, 0.32 * 360.0)
    del dice


def _steeper(data: Data, _: float = 0.0, by: float = 3.2) -> None:
    """Press the moves of a closed motion into shorter angles, the dwells grow."""
    moves = data["motion"]
    began, shares = 0.0, []
    for segment in moves:
        shares.append((segment["until"] - began) / (by if "to" in segment else 1.0))
        began = segment["until"]
    still = began - sum(share for share, segment in zip(shares, moves) if "to" in segment)
    rest = sum(share for share, segment in zip(shares, moves) if "to" not in segment)
    at = 0.0
    for share, segment in zip(shares, moves):
        at += share if "to" in segment else share * still / rest
        segment["until"] = at
    moves[-1]["until"] = began


def steep(data: Data, dice: Dice) -> None:
    """Moves in less than half the angle: tan of the pressure angle more than doubles, beyond the limit asked for."""
    _steeper(data, by=dice.between(2.0, 2.4))
    # From at most 23 deg (translating) the angle grows beyond 30; the limit is the design's own, far inside that.
    limit = 30.0 if data["follower"]["kind"] == "turret" else 5.0 if data["follower"].get("face") == "curved" else 12.0
    data.setdefault("limits", {})["pressure_angle_deg"] = limit


def undercut(data: Data, dice: Dice) -> None:
    """A roller larger than the radius of its path: moves so sharp that r k is above one by far."""
    _steeper(data, by=dice.between(6.0, 7.0))


def overlapping(data: Data, dice: Dice) -> None:
    """Rollers so thick that nothing is left of the rib between two of them."""
    cam, follower, roller = data["cam"], data["follower"], data["roller"]
    rollers = follower.get("rollers", follower["stops"])
    inner = follower["pitch_radius"] - (0.5 * roller["length"] if cam["kind"] == "globoidal" else 0.0)
    plates = cam.get("plates", 2) if cam["kind"] == "parallel-index" else 1
    for key in ("bore", "keyway_width", "keyway_depth"):
        cam.pop(key, None)
    share = dice.between(0.985 if plates == 1 else 1.001, 1.06)
    roller["diameter"] = 2.0 * inner * sin(pi * plates / rollers) * share


def heavy(data: Data, dice: Dice) -> None:
    """A constant force that presses ten times harder than the limit allows (pressure goes with its root)."""
    force = (LIMIT * dice.between(3.0, 4.0) / 0.418) ** 2 * _bearing(data) / 206000.0
    data["operation"]["force"] = [{"expression": repr(force * _arm(data))}]


def _arm(data: Data) -> float:
    """What turns a force at the contact into the follower's: its arm, or one."""
    follower = data["follower"]
    if follower["kind"] in ("swinging", "turret"):
        return float(follower.get("arm", follower.get("pitch_radius")))
    return 1.0


def _bearing(data: Data) -> float:
    """Radius times length of a contact, mm², from above."""
    cam, roller = data["cam"], data.get("roller")
    wide = cam.get("width", 1e9) if cam["kind"] in ("disc", "constant-width", "conjugate") else 1e9
    if roller:
        return float(0.5 * roller["diameter"] * min(roller["length"], wide))
    return float(3.0 * cam["base_radius"] * wide)


def soft(data: Data, dice: Dice) -> None:
    """A cam that is hardly hardened, with the limit of steel at 60 HRC."""
    data["material"]["cam"]["hardness"] = dice.between(10.0, 25.0)


def weak(data: Data, dice: Dice) -> None:
    """A material that bears 5 to 15 MPa under the same load."""
    data["material"]["cam"]["contact_limit"] = dice.between(5.0, 15.0)


def loose(data: Data, dice: Dice) -> None:
    """A spring far too weak for the mass it holds."""
    mass = "inertia" if data["follower"]["kind"] == "swinging" else "mass"
    data["operation"]["spring_preload"] *= 0.02
    data["follower"][mass] *= dice.between(3.0, 6.0)


def unstated_mass(data: Data, dice: Dice) -> None:
    """Nobody says what the follower weighs."""
    for key in ("mass", "inertia"):
        data["follower"].pop(key, None)
    del dice


def endless_life(data: Data, dice: Dice) -> None:
    """A life that no surface at that pressure has."""
    heavy(data, dice)
    data["limits"] = {"life_h": 1e6, "contact_pressure_mpa": 1e6}


def narrow_face(data: Data, dice: Dice) -> None:
    """A flat face half as wide as the contact wanders."""
    data["follower"]["face_width"] *= dice.between(0.3, 0.5)


def jerky(data: Data, dice: Dice) -> None:
    """A straight line against dwells."""
    for segment in data["motion"]:
        if "to" in segment:
            segment["law"] = dice.one("parabolic", "simple-harmonic", "cubic-2")


def larger(data: Data, dice: Dice) -> None:
    """A roller (of an external disc or a rib: a cam) larger than the body was made for.

    By 2 to 10 tolerances, and the running clearance, which would still let it pass.
    """
    _resized(data, dice.between(2.0, 10.0) + data["cam"].get("running_clearance", 0.0) / data["output"]["tolerance"])


def smaller(data: Data, dice: Dice) -> None:
    """The same, smaller by 4 to 10 tolerances."""
    _resized(data, -dice.between(4.0, 10.0))


def _resized(data: Data, by: float) -> None:
    by *= data["output"]["tolerance"]
    cam = data["cam"]
    if cam["kind"] in ("disc", "constant-width", "conjugate") and cam.get("form") != "groove":
        cam["base_radius"] -= by  # what runs on it now comes nearer than what it was made for
    elif "rib_thickness" in cam:
        cam["rib_thickness"] -= 2.0 * by  # rollers beside a rib stand as far apart as they are thick
    else:
        data["roller"]["diameter"] += 2.0 * by


def untouched(data: Data, dice: Dice) -> None:
    """The profile stays; the body is spoilt."""
    del data, dice


IDLE: tuple[tuple[tuple[str, ...], str, str, Any], ...] = (
    (DRUMS, "follower", "offset", 3.0),
    (DRUMS, "follower", "face", "flat"),
    (DRUMS, "follower", "face_width", 20.0),
    (("drum groove", "drum groove, swinging"), "cam", "rib_thickness", 9.0),
    (("disc, roller", "disc, flat"), "cam", "center_distance", 120.0),
    (("disc, roller", "disc, swinging roller"), "cam", "groove_depth", 3.0),
    (("disc, roller", "disc, swinging roller"), "cam", "diameter", 200.0),
    (("disc, roller", "disc, swinging roller"), "follower", "face_radius", 50.0),
    (("disc, roller", "disc, swinging roller"), "follower", "face_width", 50.0),
    (DISCS, "cam", "running_clearance", 0.02),
    (("disc, roller", "disc, swinging roller"), "follower", "clearance", 0.05),
    (("face groove",), "cam", "center_distance", 120.0),
    (("drum groove", "drum rib"), "follower", "clearance", 0.05),
    (("drum groove, swinging", "drum rib, swinging"), "follower", "side", "right"),
    (("slide",), "cam", "center_distance", 150.0),
    (("slide",), "cam", "return_arm", 100.0),
    (("rocker",), "cam", "return_radius", 90.0),
    (("yoke",), "follower", "face_width", 80.0),
    (GLOBOIDS, "operation", "guide_friction", 0.2),
    (("drum groove, swinging", "rocker"), "operation", "load_mass", 1.0),
    (("drum groove", "slide"), "operation", "load_inertia", 1.0),
    (("frame",), "limits", "undercut_margin", 0.1),
)
"""(kinds, section, key, value) of keys that mean nothing there"""


def idle_key(data: Data, dice: Dice) -> None:
    """One key that means nothing for this cam."""
    kind = data["kind"]
    _, section, key, value = dice.one(*[row for row in IDLE if kind in row[0]])
    data.setdefault(section, {})[key] = value
    data["named"] = key


def stiffness_of(data: Data, periods: float) -> float:
    """N m/rad of an output shaft whose load swings `periods` times during one index."""
    moving = next(s for s in data["motion"] if "to" in s)
    began = data["motion"][0]["until"]
    index = (moving["until"] - began) / 360.0 * 60.0 / data["operation"]["speed"]
    return float(data["follower"]["inertia"] * (2.0 * pi * periods / index) ** 2)


def bad_drive(data: Data, dice: Dice) -> None:
    """A turret on a shaft so soft and so little damped that it swings all through its dwell."""
    data["dynamics"] = soft_drive(data, dice.between(1.2, 2.2))
    share = 0.02
    data["follower"]["inertia"], data["operation"]["load_inertia"] = (
        share * data["follower"]["inertia"], (1.0 - share) * data["follower"]["inertia"],
    )  # fmt: skip


def soft_drive(data: Data, periods: float) -> Data:
    """[dynamics] of a drive whose load swings `periods` times in an index, damped by 0.2 %; all else is stiff."""
    soft = stiffness_of(data, periods)
    damping = 0.002 * 2.0 * sqrt(soft * data["follower"]["inertia"])
    return {
        "kind": "indexing", "input_stiffness": 30.0 * soft, "output_stiffness": soft, "output_damping": damping,
        "input_damping": 10.0 * damping, "contact_damping": 10.0 * damping, "settling_band": 0.005,
    }  # fmt: skip


def dynamic_load(data: Data, dice: Dice) -> None:
    """Drives of that kind, one of which will press its rollers harder than the rigid one; the limit lies between."""
    drives = [soft_drive(data, dice.between(1.2, 2.2)) for _ in range(6)]
    bad_drive(data, dice)
    data["between"] = drives


def swinging_torque(data: Data, theta: Floats) -> Floats:
    """Torque, N mm, that the rollers give a turret whose load swings on its soft output shaft, at cam angles, rad.

    One mass on a damped spring whose foot indexes; steady state, by the harmonics of the index. What is stiff is rigid.
    """
    count, (before, index, _) = 2**14, data["motion"]
    begin, end, omega = radians(before["until"]), radians(index["until"]), data["operation"]["speed"] * pi / 30.0
    turn = 2.0 * pi * np.arange(count) / count
    x = (turn - begin) / (end - begin)
    moving = (x > 0.0) & (x < 1.0)
    if index["law"] == "3-4-5":
        curve = 60.0 * x - 180.0 * x**2 + 120.0 * x**3
    else:
        ends = np.where(x < 0.5, np.sin(4.0 * pi * x), -np.sin(4.0 * pi * (1.0 - x)))
        inner = np.cos(4.0 * pi * (x - 0.125) / 3.0)
        curve = 4.0 * pi**2 / (pi + 4.0) * np.where((x > 0.125) & (x < 0.875), inner, ends)
    foot = np.where(moving, curve, 0.0) * radians(index["to"]) * (omega / (end - begin)) ** 2
    spring, damper = data["dynamics"]["output_stiffness"], data["dynamics"]["output_damping"]
    rate = 1j * omega * np.arange(count // 2 + 1)
    shaft = spring + damper * rate
    inertia = data["operation"]["load_inertia"]
    load = np.fft.irfft(np.fft.rfft(inertia * foot) * shaft / (inertia * rate**2 + shaft), count)
    torque = 1e3 * (load + data["follower"]["inertia"] * foot) + moving * data["operation"].get("friction", 0.0)
    return np.interp(theta, turn, torque, period=2.0 * pi)


def elastic_jump(data: Data, dice: Dice) -> None:
    """An elastic follower whose spring just holds it when rigid, and which vibrates."""
    follower, operation = data["follower"], data["operation"]
    rise = next(s for s in data["motion"] if "to" in s)
    seconds = (rise["until"] - data["motion"][0]["until"]) / 360.0 * 60.0 / operation["speed"]
    mass = follower["mass"]
    stiffness = mass * (2.0 * pi * dice.between(1.3, 1.8) / seconds) ** 2 / 1e3
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": stiffness, "linkage_damping": 0.0, "tolerance": 1e-3}
    operation["friction"] = 0.0
    # What a rigid follower of that mass needs is the largest deceleration; a third of it holds nothing that swings.
    operation["spring_preload"] *= 0.2


FAULTS: dict[str, Fault] = {
    "roller beyond the body": Fault(DRUMS, short_drum, ("run-out",), ("length", "start")),
    "crossing rib": Fault(RIBS, crossing_rib, ("rib-thickness",), ("rib_thickness",)),
    "thin wall: bore": Fault(BORED, thin_bore, ("wall",), ("bore",)),
    "thin wall: keyway": Fault(KEYED, thin_keyway, ("wall",), ("keyway", "bore")),
    "thin wall: end of a drum": Fault(
        ("drum groove", "drum groove, swinging"), thin_end, ("wall", "run-out"), ("start",)
    ),
    "thin wall: rim": Fault(PLATES, thin_rim, ("wall",), ("diameter",)),
    "thin wall: floor": Fault(PLATES, thin_floor, ("wall",), ("groove_depth", "width")),
    "overlapping neighbours": Fault(
        TURRETS, overlapping, ("rib-thickness", "turret-gap", "watertight", "wall"), ("roller.diameter",)
    ),
    "oversize roller": Fault(tuple(KINDS), larger, ("interference",), body="made with"),
    "undersize roller": Fault(tuple(KINDS), smaller, ("backlash",), body="made with"),
    "coarse mesh declared fine": Fault(
        tuple(KINDS), untouched, ("chord-error", "interference", "backlash"), body="coarse"
    ),
    "moved mesh": Fault(tuple(KINDS), untouched, ("interference", "backlash"), body="moved"),
    "undercut": Fault(
        ("drum groove", "disc, roller", "face groove"), undercut,
        ("undercut", "self-crossing", "relative-curvature", "face-curvature"),
    ),
    "fold under a face": Fault(
        ("disc, flat", "disc, curved", "frame"), undercut, ("face-curvature", "undercut", "self-crossing")
    ),
    "pressure angle": Fault(tuple(k for k in KINDS if k not in ("disc, flat", "frame")), steep, ("pressure-angle",)),
    "load above the limit": Fault(
        tuple(KINDS), heavy, ("contact-pressure", "face-pressure", "turret-pressure")
    ),
    "life": Fault(tuple(KINDS), endless_life, ("life", "turret-life", "face-life"), ("life_h",)),
    "lift-off, rigid": Fault(DISCS, loose, ("contact-kept",)),
    "lift-off, elastic": Fault(("disc, roller", "disc, flat"), elastic_jump, ("lift-off",)),
    "bad indexing drive": Fault(TURRETS, bad_drive, ("settling",)),
    "load above the limit, dynamic": Fault(TURRETS, dynamic_load, ("dynamic-pressure",)),
    "too soft for its limit": Fault(tuple(KINDS), soft, ("hardness",), ("hardness", "contact_limit")),
    "too weak a material": Fault(tuple(KINDS), weak, ("contact-pressure", "face-pressure", "turret-pressure")),
    "idle key": Fault(tuple(k for k in KINDS if any(k in row[0] for row in IDLE)), idle_key, (), ("named",)),
    "unstated mass": Fault(tuple(KINDS), unstated_mass, ("moving-mass",), ("mass", "inertia"), warns=True),
    "narrow face": Fault(("disc, flat", "frame"), narrow_face, ("face-width",)),
    "jump of acceleration": Fault(tuple(KINDS), jerky, ("continuity",)),
}  # fmt: skip


def fault_of(seed: int) -> str:
    """The class of a seed: classes in turn, so that all come equally often."""
    return list(FAULTS)[seed % len(FAULTS)]


def injected(name: str, data: Data, kind: str, seed: int) -> Data:
    """A copy of a sound design with the fault; `named` and `between` are notes for the judge, not part of it."""
    data = copy.deepcopy(data)
    data["kind"] = kind
    FAULTS[name].change(data, Dice(seed + 1_000_003))
    data.pop("kind")
    return data

PENDING: dict[str, tuple[str, ...]] = {}
"""kinds by class whose answer is not in the product yet: listed, not passed over"""
