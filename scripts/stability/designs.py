"""Random cam designs as plain profile tables: every kind, form, follower, roller, law; six decades of size; some bad.

A design is a function of its seed alone. About one in five has a number or two multiplied by a factor of up to eight
(out of the range that makes sense), so that refusals and findings are met as well as good bodies.
"""

from __future__ import annotations

from math import asin, pi, sin, sqrt
from typing import Any

import numpy as np

KINDS = (
    "disc", "cylindrical", "disc-groove", "constant-width", "cylindrical", "conjugate", "disc", "globoidal",
    "cylindrical", "cylindrical-index",
    "disc", "cylindrical", "disc-groove", "constant-width", "cylindrical", "conjugate", "disc", "globoidal",
    "cylindrical", "parallel-index",
)  # fmt: skip
"""the kind of a seed is KINDS[seed % 20]; those that cost most come less often"""
LATER, KINDS_LATER = 100_000, ("end-face", "unequal-pair", "stations", "grooves", "linear", "faces",
                              "linear-edge", "disc-cone", "conical", "bell", "groove-cone", "pair-cone",
                              "faces-cone")  # fmt: skip
"""kinds that came when the seeds below had been judged already: those of seeds from LATER on, EACH of one after
another, and then from the first one again, ROUND kinds in all
"""
EACH, ROUND = 10_000, 13
"""seeds of a kind, and kinds that come again: one that is added takes seeds of its own"""
SMOOTH = (
    "3-4-5", "4-5-6-7", "5-6-7-8-9", "cycloidal", "freudenstein-1-3", "freudenstein-1-3-5", "gutman-1-3",
    "modified-constant-velocity", "modified-sine", "modified-trapezoid", "polynomial", "power-polynomial", "scca",
    "trapezoidal-acceleration", "triple-harmonic", "universal-asymmetric", "b-spline", "spline",
)  # fmt: skip
ROUGH = (
    "simple-harmonic", "parabolic", "double-harmonic", "cubic-2", "trapezoidal-velocity",
    "constant-velocity", "cubic-1",
)  # fmt: skip
LENGTHS = {
    "cam": (
        "base_radius", "width", "center_distance", "diameter", "groove_depth", "running_clearance", "bore",
        "keyway_width", "keyway_depth", "length", "start", "pitch_radius", "rib_thickness", "return_arm",
        "return_radius", "gap", "mark_diameter", "mark_radius", "globoid_radius", "tip_clearance", "preload",
        "hub_diameter", "hub_length", "inner_diameter", "height", "web", "stroke", "thickness", "edge", "root_radius",
    ),
    "follower": (
        "offset", "face_radius", "face_width", "clearance", "arm", "pivot_distance", "face_offset", "pitch_radius",
    ),
    "roller": ("diameter", "length", "crown_radius"),
    "return_roller": ("diameter", "length", "crown_radius"),
}  # fmt: skip


class Dice:
    """Random numbers of one design."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def between(self, low: float, high: float) -> float:
        return float(self.rng.uniform(low, high))

    def log(self, low: float, high: float) -> float:
        return float(np.exp(self.rng.uniform(np.log(low), np.log(high))))

    def one(self, *choices: Any) -> Any:
        return choices[int(self.rng.integers(len(choices)))]

    def chance(self, share: float) -> bool:
        return bool(self.rng.random() < share)

    def whole(self, low: int, high: int) -> int:
        return int(self.rng.integers(low, high + 1))


def kind_of(seed: int) -> str:
    """The kind of a seed."""
    if seed < LATER:
        return KINDS[seed % len(KINDS)]
    return KINDS_LATER[(seed - LATER) // EACH % ROUND]


def design(seed: int) -> dict[str, Any]:
    """The profile tables of a seed."""
    dice = Dice(seed)
    kind = kind_of(seed)
    data = {
        "disc": _disc,
        "disc-groove": _disc_groove,
        "constant-width": _constant_width,
        "conjugate": _conjugate,
        "unequal-pair": _unequal_pair,
        "stations": _stations,
        "grooves": _grooves,
        "faces": _faces,
        "cylindrical": _drum,
        "cylindrical-index": _barrel,
        "end-face": _end_face,
        "bell": _bell,
        "globoidal": _globoid,
        "linear": _linear,
        "linear-edge": _linear_edge,
        "conical": _conical,
        "disc-cone": _disc_cone,
        "groove-cone": _groove_cone,
        "pair-cone": _pair_cone,
        "faces-cone": _faces_cone,
        "parallel-index": _plates,
    }[kind](dice)
    data["name"] = f"seed {seed}"
    if data["cam"]["kind"] != "linear":
        data["cam"]["direction"] = dice.one("ccw", "cw")
    if dice.chance(0.6):
        _operation(dice, data)
    if "station" in data:
        _station_loads(dice, data)
    if dice.chance(0.2):
        _spoil(dice, data)
    cam = data["cam"]
    sizes = (cam.get(key, 0.0) for key in ("diameter", "width", "stroke"))
    size = max(2.0 * cam.get("base_radius", 0.0), *sizes)
    fine = 2e-4 if kind in ("globoidal", "cylindrical-index", "parallel-index") else 3e-5
    data["output"] = {"tolerance": size * dice.log(fine, 2e-3)}
    # A tolerance is at most 1 mm, so that a very large turret's cam would need millions of triangles.
    _scale(data, dice.log(1e-3, 1e3 if fine < 1e-4 else 30.0))
    data["output"]["tolerance"] = min(1.0, max(1e-7, data["output"]["tolerance"]))
    return data


def _spoil(dice: Dice, data: dict[str, Any]) -> None:
    """Multiply one to three numbers by a factor of 1/8 to 8."""
    tables = ("cam", "follower", "roller", "return_roller")
    places = [(t, k) for t in tables for k, v in data.get(t, {}).items() if isinstance(v, float)]
    places += [(i, "to") for i, segment in enumerate(data["motion"]) if segment.get("to")]
    for _ in range(dice.whole(1, 3)):
        table, key = places[dice.whole(0, len(places) - 1)]
        target = data["motion"][table] if isinstance(table, int) else data[table]
        target[key] *= dice.log(0.125, 8.0)


def _scale(data: dict[str, Any], by: float) -> None:
    """Multiply every length; lifts of sliding followers too."""
    for table, keys in LENGTHS.items():
        for key in keys:
            if key in data.get(table, {}):
                data[table][key] = float(data[table][key] * by)
    data.get("output", {"tolerance": 0.0})["tolerance"] *= by
    for track in data.get("track", ()):
        _scale(track, by)
    plate = data["cam"].get("kind") == "linear"
    for segment in data["motion"] if plate else ():
        segment["until"] *= by
    if plate:
        # The program ends at the stroke to the last digit.
        data["motion"][-1]["until"] = data["cam"]["stroke"]
        for segment in data["motion"] if data["follower"]["kind"] == "swinging" else ():
            for order, key in enumerate(("velocity", "acceleration"), 1):
                if key in segment:
                    segment[key] /= by**order
    if data["follower"]["kind"] in ("translating", "frame"):
        for segment in data["motion"]:
            if segment.get("to"):
                segment["to"] *= by
            for key in ("velocity", "acceleration"):
                if key in segment:
                    segment[key] *= (1.0 if key == "velocity" else 1.0 / by) if plate else by
            if segment.get("law") == "spline" and "points" in segment:
                segment["points"] = tuple((x, y * by) for x, y in segment["points"])
            if segment.get("law") == "b-spline" and "control" in segment:
                segment["control"] = tuple(y * by for y in segment["control"])


def _operation(dice: Dice, data: dict[str, Any]) -> None:
    data["operation"] = {"speed": dice.log(0.1, 3000.0), "friction": dice.log(1e-3, 1e3)}
    if dice.chance(0.5):
        data["operation"] |= {"spring_rate": dice.log(1e-2, 100.0), "spring_preload": dice.log(0.1, 1e4)}
    follower = data["follower"]
    follower["inertia" if follower["kind"] in ("swinging", "turret") else "mass"] = dice.log(1e-4, 1e3)
    if dice.chance(0.4) and "roller" in data:
        data["roller"]["dynamic_rating"] = dice.log(100.0, 1e5)
    if "return_roller" in data and dice.chance(0.4):
        data["return_roller"]["dynamic_rating"] = dice.log(100.0, 1e5)


def _law(dice: Dice) -> dict[str, Any]:
    name = dice.one(*SMOOTH) if dice.chance(0.88) else dice.one(*ROUGH)
    segment: dict[str, Any] = {"law": name}
    if name in ("modified-sine", "modified-trapezoid", "trapezoidal-acceleration") and dice.chance(0.5):
        segment["share"] = dice.between(0.02, 0.24)
    if name == "modified-constant-velocity" and dice.chance(0.5):
        segment |= {"share": dice.between(0.0, 0.8), "rise": dice.between(0.1, 0.9)}
    if name == "universal-asymmetric" and dice.chance(0.5):
        segment["accelerate"] = dice.between(0.2, 0.8)
        segment |= {"rise": dice.between(0.1, 0.5), "fall": dice.between(0.1, 0.5)}
    if name in ("polynomial", "spline", "b-spline") and dice.chance(0.4):
        segment["order"] = dice.whole(1, 3)
    return segment


def _moves(dice: Dice, levels: list[float], end: float = 360.0) -> tuple[dict[str, Any], ...]:
    """Segments through the levels in order, a dwell between some, all together `end` degrees."""
    steps: list[dict[str, Any]] = []
    weights = []
    for level in levels:
        if dice.chance(0.6):
            steps.append({})
            weights.append(dice.log(0.01, 1.0))
        steps.append({"to": level, **_law(dice)})
        weights.append(dice.between(0.5, 1.5))
    if dice.chance(0.5):
        steps.append({})
        weights.append(dice.log(0.01, 1.0))
    until = np.cumsum(weights) / sum(weights) * end
    for step, angle in zip(steps, until):
        step["until"] = float(angle)
    steps[-1]["until"] = end
    return tuple(steps)


def _round_trip(dice: Dice, stroke: float) -> tuple[dict[str, Any], ...]:
    """One to three heights and back to zero."""
    levels = [stroke] if dice.chance(0.7) else [stroke * dice.between(0.1, 1.0) for _ in range(dice.whole(2, 4))]
    return _moves(dice, [*levels, 0.0])


def _bored(dice: Dice, cam: dict[str, Any], room: float) -> None:
    """Give the cam a bore (and a keyway) within the radius `room`."""
    if not dice.chance(0.7) or room <= 0.0:
        return
    cam["bore"] = 2.0 * room * dice.between(0.2, 0.7)
    if dice.chance(0.5):
        cam["keyway_width"] = cam["bore"] * dice.between(0.1, 0.4)
        cam["keyway_depth"] = cam["bore"] * dice.between(0.03, 0.15)


def _flat_roller(dice: Dice, diameter: float, length: float) -> dict[str, Any]:
    roller: dict[str, Any] = {"diameter": diameter, "length": length}
    if dice.chance(0.3):
        roller |= {"shape": "crowned", "crown_radius": max(diameter, length) * dice.log(1.0, 100.0)}
    return roller


def _swing(dice: Dice, prime: float, stroke: float) -> tuple[dict[str, Any], float, float]:
    """A swinging follower beside a cam of the given prime radius: follower, centre distance, swing in degrees."""
    arm = prime * dice.between(0.8, 2.5)
    lean = dice.between(0.5 * pi, 0.75 * pi)
    distance = sqrt(prime**2 + arm**2 + 2.0 * prime * arm * (-np.cos(lean))) if dice.chance(0.7) else arm + 0.4 * prime
    follower = {"kind": "swinging", "arm": arm, "side": dice.one("left", "right")}
    return follower, float(distance), float(np.degrees(stroke / arm))


def _offset(dice: Dice, most: float) -> float:
    return 0.0 if dice.chance(0.5) else dice.between(-most, most)


def _disc(dice: Dice) -> dict[str, Any]:
    base = 30.0
    stroke = base * dice.log(1e-3, 1.5)
    cam: dict[str, Any] = {"kind": "disc", "base_radius": base, "width": base * dice.log(0.05, 2.0)}
    face = dice.one("roller", "roller", "roller", "flat", "knife", "curved")
    radius = base * dice.log(0.02, 1.5)
    touch = radius if face in ("roller", "curved") else 0.0
    if dice.chance(0.55):
        follower: dict[str, Any] = {"kind": "translating", "offset": _offset(dice, 0.8 * base)}
        if face == "flat":
            stroke *= 0.3
    else:
        follower, cam["center_distance"], stroke = _swing(dice, base + touch, min(stroke, 0.7 * base))
        if face == "flat":
            cam["center_distance"], stroke = base * dice.between(1.5, 4.0), stroke * 0.4
            follower["face_offset"] = base * dice.between(-0.3, 0.3)
    follower["face"] = face
    data: dict[str, Any] = {"cam": cam, "follower": follower, "motion": _round_trip(dice, stroke)}
    if face == "roller":
        data["roller"] = _flat_roller(dice, 2.0 * radius, cam["width"] * dice.between(0.3, 1.5))
    if face == "curved":
        follower["face_radius"] = radius
    _bored(dice, cam, base)
    return data


def _disc_cone(dice: Dice) -> dict[str, Any]:
    """The profile of a conical roller, which may come near to its point at an end of the disc."""
    base, radius = 30.0, 30.0 * dice.log(0.05, 1.2)
    stroke = base * dice.log(1e-3, 1.0)
    cam: dict[str, Any] = {"kind": "disc", "base_radius": base, "width": base * dice.log(0.05, 1.5)}
    if dice.chance(0.55):
        follower: dict[str, Any] = {"kind": "translating", "offset": _offset(dice, 0.8 * base)}
    else:
        follower, cam["center_distance"], stroke = _swing(dice, base + radius, min(stroke, 0.7 * base))
    data: dict[str, Any] = {"cam": cam, "follower": follower, "motion": _round_trip(dice, stroke)}
    data["roller"] = _cone(dice, 2.0 * radius, cam["width"])
    _bored(dice, cam, base)
    return data


def _cone(dice: Dice, diameter: float, width: float) -> dict[str, Any]:
    """A conical roller of a disc, which may come near to its point at one of its faces."""
    most = float(np.degrees(np.arctan2(diameter, width)))
    found = {"shape": "cone", "diameter": diameter, "length": width * dice.between(0.3, 1.0)}
    return found | {"half_angle": dice.one(-1.0, 1.0) * min(most, 79.0) * dice.log(0.01, 0.95)}


def _groove_cone(dice: Dice) -> dict[str, Any]:
    """The groove of a conical roller, which may come near to its point at the floor or at the mouth."""
    data = _disc_groove(dice)
    cam, size, depth = data["cam"], data["roller"]["diameter"], data["cam"]["groove_depth"]
    length, way = depth * dice.between(0.3, 1.0), dice.one(-1.0, 1.0)
    # Its middle is half of its length below the mouth; at times it is as thick there as the plate has room for.
    most = float(np.degrees(np.arctan2(0.5 * size, depth - 0.5 * length if way > 0.0 else 0.5 * length)))
    angle = way * min(most, 79.0) * dice.log(0.01, 0.95)
    wider = length if way > 0.0 else 2.0 * depth - length
    cam["diameter"] += wider * float(np.tan(np.radians(abs(angle)))) * dice.between(1.0, 1.5)
    return data | {"roller": {"shape": "cone", "diameter": size, "length": length, "half_angle": angle}}


def _pair_cone(dice: Dice) -> dict[str, Any]:
    """A pair of which one roller is a cone, or both are, alike or not."""
    data = _conjugate(dice)
    size, width = data["roller"]["diameter"], data["cam"]["width"]
    which = dice.one("both", "unequal", "main", "return")
    if which in ("both", "unequal", "main"):
        data["roller"] = _cone(dice, size, width)
    if which != "both":
        second = size * dice.log(0.5, 2.0)
        data["return_roller"] = _flat_roller(dice, second, width) if which == "main" else _cone(dice, second, width)
    return data


def _disc_groove(dice: Dice) -> dict[str, Any]:
    base, radius = 40.0, 40.0 * dice.log(0.02, 0.5)
    stroke = base * dice.log(1e-3, 0.8)
    width = base * dice.log(0.1, 1.5)
    cam: dict[str, Any] = {"kind": "disc", "form": "groove", "base_radius": base, "width": width}
    cam["groove_depth"] = width * dice.between(0.2, 0.9)
    if dice.chance(0.6):
        follower: dict[str, Any] = {"kind": "translating", "offset": _offset(dice, 0.5 * base)}
        lift = stroke
    else:
        lift = min(stroke, 0.5 * base)
        follower, cam["center_distance"], stroke = _swing(dice, base + radius, lift)
    cam["diameter"] = 2.0 * (base + 2.0 * radius + 1.1 * lift) * dice.between(1.02, 1.5)
    if dice.chance(0.4):
        cam["running_clearance"] = radius * dice.log(1e-4, 0.05)
    _bored(dice, cam, base)
    roller = _flat_roller(dice, 2.0 * radius, cam["groove_depth"] * dice.between(0.3, 1.0))
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _round_trip(dice, stroke)}


def _constant_width(dice: Dice) -> dict[str, Any]:
    base = 40.0
    cam: dict[str, Any] = {"kind": "constant-width", "base_radius": base, "width": base * dice.log(0.05, 2.0)}
    follower: dict[str, Any] = {"kind": "frame", "clearance": base * dice.log(1e-5, 1e-2) if dice.chance(0.5) else 0.0}
    stroke = base * dice.log(1e-3, 1.0)
    levels = [stroke] if dice.chance(0.8) else [stroke * dice.between(0.2, 0.8), stroke]
    data: dict[str, Any] = {"cam": cam, "follower": follower, "motion": _moves(dice, levels, 180.0)}
    if dice.chance(0.4):
        data["roller"] = _flat_roller(dice, base * dice.log(0.05, 1.0), cam["width"])
    elif dice.chance(0.5):
        follower["face_width"] = base * dice.between(1.0, 4.0)
    _bored(dice, cam, base)
    return data


def _conjugate(dice: Dice) -> dict[str, Any]:
    base, radius = 50.0, 50.0 * dice.log(0.05, 0.8)
    stroke = base * dice.log(1e-3, 0.6)
    cam: dict[str, Any] = {"kind": "conjugate", "base_radius": base, "width": base * dice.log(0.1, 1.0)}
    if dice.chance(0.4):
        follower: dict[str, Any] = {"kind": "translating", "offset": _offset(dice, 0.4 * base)}
        if dice.chance(0.3):
            cam["return_radius"] = base * dice.between(0.9, 2.0)
    else:
        follower, cam["center_distance"], stroke = _swing(dice, base + radius, stroke)
        if dice.chance(0.3):
            cam["return_arm"] = follower["arm"] * dice.between(0.8, 1.2)
    if dice.chance(0.5):
        follower["clearance"] = base * dice.log(1e-6, 1e-2)
    if dice.chance(0.5):
        cam["gap"] = cam["width"] * dice.between(0.0, 1.0)
    _bored(dice, cam, 0.8 * base)
    if dice.chance(0.3):
        cam |= {"mark_diameter": 0.06 * base, "mark_radius": 0.9 * base}
    roller = _flat_roller(dice, 2.0 * radius, cam["width"] * dice.between(0.4, 1.0))
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _round_trip(dice, stroke)}


def _unequal_pair(dice: Dice) -> dict[str, Any]:
    data = _conjugate(dice)
    first, width = data["roller"], data["cam"]["width"]
    data["return_roller"] = _flat_roller(dice, first["diameter"] * dice.log(0.4, 2.5), width * dice.between(0.3, 1.0))
    return data


def _stations(dice: Dice) -> dict[str, Any]:
    """A cam with two to four followers on one track."""
    data = dice.one(_disc, _disc, _disc_groove, _drum, _end_face, _conjugate)(dice)
    count = dice.whole(1, 3)
    angles = [360.0 * (k + 1) / (count + 1) + dice.between(-20.0, 20.0) for k in range(count)]
    data["station"] = [{"angle": angle} for angle in angles]
    return data


def _grooves(dice: Dice) -> dict[str, Any]:
    """A drum with two or three grooves beside each other, now and then into each other."""
    data = _drum(dice)
    while data["cam"]["form"] == "rib":
        data = _drum(dice)
    cam, outer, tracks = data["cam"], 60.0, []
    for _ in range(dice.whole(1, 2)):
        diameter = 2.0 * outer * dice.log(0.03, 0.3)
        depth = diameter * dice.between(0.3, 0.9)
        roller = _roller(dice, diameter, depth * dice.between(0.5, 1.0))
        stroke, margin = outer * dice.log(1e-3, 1.5), 0.5 * diameter
        start = cam["length"] + margin * dice.between(0.2, 2.0)
        cam["length"] = start + stroke + 2.0 * margin + 0.05 * outer
        own = {"start": start, "groove_depth": depth, "running_clearance": diameter * dice.one(0.0, 1e-3)}
        tracks.append({"angle": dice.between(0.0, 359.0), "cam": own, "follower": {"kind": "translating"},
                       "roller": roller, "motion": _round_trip(dice, stroke)})  # fmt: skip
    data["track"] = tracks
    return data


def _faces(dice: Dice) -> dict[str, Any]:
    """A disc with a groove in each face, or in one or both of a disc whose rim is a profile; now and then too thin."""
    width, reach, tracks = 40.0 * dice.log(0.2, 1.2), 0.0, []
    shape = dice.one("both", "both", "rim", "all")
    bore: dict[str, Any] = {}
    _bored(dice, bore, 30.0)
    rim = {"rim": "profile"} if shape != "both" else {}
    for face in ("upper", "lower")[: 1 if shape == "rim" else 2]:
        base = 40.0 * dice.between(0.8, 1.8)
        cam = {"form": "groove", "face": face, **rim, "groove_depth": width * dice.between(0.15, 0.6)}
        track, outer = _on_disc(dice, cam, base, base * dice.log(0.03, 0.3), base * dice.log(1e-3, 0.5))
        track["roller"] = _flat_roller(dice, track["roller"]["diameter"], cam["groove_depth"] * dice.between(0.4, 0.98))
        if dice.chance(0.4):
            cam["running_clearance"] = track["roller"]["diameter"] * dice.log(1e-4, 0.02)
        if dice.chance(0.2) and "shape" not in track["roller"]:
            cam["root_radius"] = (cam["groove_depth"] - track["roller"]["length"]) * dice.between(0.2, 1.0)
        tracks.append(track)
        reach = max(reach, outer)
    body = {"kind": "disc", "width": width, **bore}
    if rim:
        base = reach * dice.between(0.97, 1.5)
        track, _ = _on_disc(dice, {"form": "external"}, base, base * dice.log(0.05, 0.5), base * dice.log(1e-3, 0.3))
        track["roller"] = _flat_roller(dice, track["roller"]["diameter"], width * dice.between(0.3, 1.2))
        tracks.insert(dice.whole(0, len(tracks)), track)
    else:
        body["diameter"] = 2.0 * reach * dice.between(0.98, 1.4)
    first, *others = tracks
    for track in others:
        track["angle"] = dice.between(0.0, 359.0)
    return {**first, "cam": {**body, **first["cam"]}, "track": others}


def _faces_cone(dice: Dice) -> dict[str, Any]:
    """Several tracks on one disc, of which one roller is a cone at least, or so it was meant."""
    data = _faces(dice)
    width = data["cam"]["width"]
    for table in (data, *data["track"]):
        if dice.chance(0.6):
            cam, size = table["cam"], table["roller"]["diameter"]
            depth = cam.get("groove_depth", width)
            angle = float(np.degrees(np.arctan2(0.5 * size, depth))) * dice.log(0.02, 0.9)
            length = min(table["roller"].get("length", width), depth)
            table["roller"] = {"shape": "cone", "diameter": size, "length": length,
                               "half_angle": dice.one(-1.0, 1.0) * min(angle, 60.0)}  # fmt: skip
            cam.pop("root_radius", None)
    return data


def _on_disc(
    dice: Dice, cam: dict[str, Any], base: float, radius: float, stroke: float
) -> tuple[dict[str, Any], float]:
    """A track of a disc, and how far its roller reaches."""
    cam["base_radius"] = base
    follower: dict[str, Any] = {"kind": "translating", "offset": _offset(dice, 0.4 * base)}
    lift = stroke
    if dice.chance(0.4):
        follower, cam["center_distance"], stroke = _swing(dice, base + radius, lift)
    track = {"cam": cam, "follower": follower, "roller": {"diameter": 2.0 * radius}}
    return {**track, "motion": _round_trip(dice, stroke)}, base + 2.0 * radius + 1.05 * lift


def _station_loads(dice: Dice, data: dict[str, Any]) -> None:
    swings = data["follower"]["kind"] == "swinging"
    for station in data["station"]:
        if dice.chance(0.5):
            station["inertia" if swings else "mass"] = dice.log(1e-4, 1e3)
        if "operation" in data and dice.chance(0.5):
            station |= {"friction": dice.log(1e-3, 1e3), "spring_preload": dice.log(0.1, 1e4)}
        if "operation" in data and dice.chance(0.2):
            station["force"] = [{"from": 20.0, "until": 100.0, "expression": "50"}]


def _roller(dice: Dice, diameter: float, length: float) -> dict[str, Any]:
    shape = dice.one("cylinder", "cylinder", "cone", "crowned", "sphere")
    roller: dict[str, Any] = {"shape": shape, "diameter": diameter, "length": length}
    if shape == "cone":
        roller["half_angle"] = dice.between(-15.0, 25.0)
    if shape == "crowned":
        roller |= {"crown_radius": max(diameter, length) * dice.log(0.8, 50.0), "flank": "conforming"}
    if shape == "sphere":
        roller["length"] = min(length, 0.35 * diameter)
    return roller


def _drum(dice: Dice) -> dict[str, Any]:
    outer = 60.0
    diameter = 2.0 * outer * dice.log(0.03, 0.35)
    depth = diameter * dice.between(0.3, 0.9)
    roller = _roller(dice, diameter, depth * dice.between(0.5, 1.0))
    if roller["shape"] == "sphere":
        depth = 0.5 * diameter * dice.between(0.6, 1.0)
    form = dice.one("groove", "groove", "rib")
    cam: dict[str, Any] = {"kind": "cylindrical", "form": form, "diameter": 2.0 * outer, "groove_depth": depth}
    stroke = outer * dice.log(1e-3, 2.5)
    margin = 0.5 * diameter
    if form == "rib":
        cam["rib_thickness"] = diameter * dice.between(0.2, 2.0)
        margin = 0.5 * cam["rib_thickness"]
    margin = margin + 0.1 * outer if dice.chance(0.8) else margin * dice.between(0.0, 1.2)
    cam |= {"start": margin + 0.05 * outer, "length": stroke + 2.0 * margin + 0.1 * outer}
    if dice.chance(0.4):
        cam["running_clearance"] = diameter * dice.log(1e-4, 0.02)
    if dice.chance(0.65):
        follower: dict[str, Any] = {"kind": "translating"}
        motion = _round_trip(dice, stroke)
    else:
        follower, motion = _axial_arm(dice, stroke, outer)
    _bored(dice, cam, outer - depth)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": motion}


def _conical(dice: Dice) -> dict[str, Any]:
    """A groove in a cone of any half angle either way, its wider end as large as a drum's, with some room beside it."""
    outer, lean = 60.0, dice.between(-80.0, 80.0) if dice.chance(0.5) else dice.one(-1.0, 1.0) * dice.log(1e-3, 60.0)
    c, s = float(np.cos(np.radians(lean))), float(np.sin(np.radians(lean)))
    diameter = 2.0 * outer * dice.log(0.03, 0.3)
    depth = diameter * dice.between(0.3, 0.9)
    roller = _roller(dice, diameter, depth * dice.between(0.5, 1.0))
    if roller["shape"] == "sphere":
        depth = 0.5 * diameter * dice.between(0.6, 1.0)
    margins = [0.5 * diameter + outer * dice.log(0.01, 0.3) for _ in range(2)]
    # The groove's foot stands aside of its edge by depth tan(lean), towards the wider end.
    margins[0 if s > 0.0 else 1] += depth * abs(s) / c
    margins[dice.whole(0, 1)] *= dice.one(1.0, 1.0, 1.0, dice.between(0.5, 1.0))
    # Of the generator the stroke takes what the narrow end leaves of the radius.
    room = 0.9 * outer / max(abs(s), 1e-9) - sum(margins)
    stroke = min(outer * dice.log(1e-3, 2.0), max(room, 0.02 * outer) * dice.between(0.3, 1.0))
    length = (sum(margins) + stroke) * c
    lower = outer if s > 0.0 else outer - abs(s) / c * length
    cam: dict[str, Any] = {"kind": "conical", "diameter": 2.0 * lower, "half_angle": lean, "length": length,
                           "start": margins[0], "groove_depth": depth}  # fmt: skip
    if dice.chance(0.4):
        cam["running_clearance"] = diameter * dice.log(1e-4, 0.02)
    if roller["shape"] == "cylinder" and dice.chance(0.3):
        # The edge of a roller as long as the flank would stand in its root.
        cam["root_radius"] = min(depth - roller["length"], 0.3 * diameter) * dice.between(0.1, 1.0)
    _bored(dice, cam, 0.9 * (outer - (sum(margins) + stroke) * abs(s) - depth * c))
    return {"cam": cam, "follower": {"kind": "translating"}, "roller": roller, "motion": _round_trip(dice, stroke)}


def _end_face(dice: Dice) -> dict[str, Any]:
    outer = 60.0
    inner = outer * dice.between(0.4, 0.95)
    diameter = inner * dice.log(0.05, 0.9)
    roller = _roller(dice, diameter, (outer - inner) * dice.between(0.3, 1.0))
    if roller["shape"] == "crowned":
        roller["flank"] = dice.one("straight", "straight", "straight", "conforming")
    stroke = outer * dice.log(1e-3, 1.5)
    height = outer * dice.log(0.05, 1.0)
    cam: dict[str, Any] = {"kind": "end-face", "diameter": 2.0 * outer, "inner_diameter": 2.0 * inner,
                           "height": height, "web": height * dice.between(0.1, 1.02)}  # fmt: skip
    if dice.chance(0.65):
        follower: dict[str, Any] = {"kind": "translating"}
        motion = _round_trip(dice, stroke)
    else:
        follower, motion = _axial_arm(dice, stroke, outer)
    _bored(dice, cam, inner)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": motion}


def _bell(dice: Dice) -> dict[str, Any]:
    """A groove in the inside of a ring, with some room beside it and behind its floor, under a slide or an arm."""
    inner = 60.0
    diameter = 2.0 * inner * dice.log(0.03, 0.5)
    roller = _flat_roller(dice, diameter, diameter * dice.between(0.2, 0.8))
    if dice.chance(0.3):
        roller = {"shape": "cone", "diameter": diameter, "length": roller["length"],
                  "half_angle": dice.between(0.0, 20.0)}  # fmt: skip
    stroke = inner * dice.log(1e-3, 2.0)
    follower: dict[str, Any] = {"kind": "translating"}
    motion, aside = _round_trip(dice, stroke), 0.0
    if dice.chance(0.35):
        follower, motion = _axial_arm(dice, stroke, 1.4 * inner)
        aside = 0.5 * follower["arm"] * (1.0 - float(np.cos(np.radians(follower["start_angle"]))))
    half = 0.5 * diameter
    # The edge of the roller's flat end has to stay within the floor.
    depth = (float(np.hypot(inner + roller["length"], half + aside)) - inner) * dice.between(1.0, 1.3)
    rooms = [half + inner * dice.log(0.01, 0.3) * dice.one(*[1.0] * 15, -0.3) for _ in range(2)]
    web = inner * dice.log(0.02, 0.5)
    cam: dict[str, Any] = {
        "kind": "end-face", "form": "groove", "inner_diameter": 2.0 * inner, "groove_depth": depth, "web": web,
        "diameter": 2.0 * (inner + depth * dice.between(0.99, 2.0)), "start": web + rooms[0],
        "length": web + sum(rooms) + stroke,
    }  # fmt: skip
    if dice.chance(0.5):
        cam["running_clearance"] = diameter * dice.log(1e-4, 0.02)
    _bored(dice, cam, inner)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": motion}


def _axial_arm(dice: Dice, stroke: float, size: float) -> tuple[dict[str, Any], Any]:
    """An arm whose roller moves along the cam axis by a stroke, and its motion."""
    arm = max(stroke, size) * dice.between(0.8, 3.0)
    half = asin(min(0.95, 0.5 * stroke / arm))
    follower = {"kind": "swinging", "arm": arm, "start_angle": float(np.degrees(-half))}
    return follower, _round_trip(dice, float(np.degrees(2.0 * half)))


def _linear(dice: Dice) -> dict[str, Any]:
    """A groove of one to four heights, back at its start or not, in a plate with some room beside it."""
    stroke = 100.0
    diameter = stroke * dice.log(0.02, 0.3)
    depth = diameter * dice.between(0.3, 0.9)
    rise = stroke * dice.log(1e-3, 0.6)
    levels = [rise * dice.between(-1.0, 1.0) for _ in range(dice.whole(1, 4))]
    lean = dice.one(0.0, 0.0, dice.between(-40.0, 40.0))
    low, high = min(0.0, *levels), max(0.0, *levels)
    half, aside = 0.5 * diameter, abs(sin(lean * pi / 180.0)) * (high - low)
    room = [half + dice.log(0.01, 0.5) * stroke for _ in range(4)]
    start, edge = room[0] + aside, room[1] - low
    cam: dict[str, Any] = {
        "kind": "linear", "stroke": stroke, "start": start, "length": start + stroke + aside + room[2], "edge": edge,
        "width": edge + high + room[3], "groove_depth": depth, "thickness": depth * dice.between(0.98, 3.0),
        "drive": dice.one("simple-harmonic", "simple-harmonic", "cycloidal", "3-4-5", "4-5-6-7"),
        "drive_out": dice.one(180.0, dice.between(60.0, 300.0)),
    }  # fmt: skip
    if lean:
        cam["inclination"] = lean
    if dice.chance(0.5):
        cam["running_clearance"] = diameter * dice.log(1e-4, 0.02)
    roller = _flat_roller(dice, diameter, depth * dice.between(0.5, 1.02))
    follower: dict[str, Any] = {"kind": "translating"}
    if not lean and dice.chance(0.5):
        # An arm so long that its swing stays below some 50 degrees; its arc leaves the line by less than the rise.
        arm = (high - low) * dice.between(1.2, 4.0)
        levels = [float(np.degrees(level / arm)) for level in levels]
        follower = {"kind": "swinging", "arm": arm, "start_angle": dice.between(-30.0, 15.0)}
        follower["side"] = dice.one("left", "right")
        cam["start"] += high - low
        cam["length"] += 2.0 * (high - low)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _moves(dice, levels, stroke)}


def _linear_edge(dice: Dice) -> dict[str, Any]:
    """The same path over the edge of a plate, whose ends the last one may leave on a slope."""
    data = _linear(dice)
    cam = {"form": "edge"} | {k: v for k, v in data["cam"].items()
                              if k not in ("width", "groove_depth", "running_clearance")}  # fmt: skip
    return data | {"cam": cam}


def _indexing(dice: Dice, stops: int, rollers: int) -> tuple[dict[str, Any], ...]:
    index = 360.0 / stops
    if dice.chance(0.12):
        swing = index * dice.between(0.3, 1.5)
        return _moves(dice, [swing, 0.0])
    indexes = 1 if dice.chance(0.85) else 2
    del rollers
    share = dice.between(0.25, 0.95) if dice.chance(0.85) else 1.0
    steps: list[dict[str, Any]] = []
    for k in range(indexes):
        low, high = ((k + 0.5 - 0.5 * share) * 360.0 / indexes, (k + 0.5 + 0.5 * share) * 360.0 / indexes)
        if share < 1.0:
            steps.append({"until": low})
        steps.append({"until": high, "to": (k + 1) * index, **_law(dice)})
    if share < 1.0:
        steps.append({"until": 360.0})
    else:
        steps[-1]["until"] = 360.0
    return tuple(steps)


def _barrel(dice: Dice) -> dict[str, Any]:
    stops = dice.whole(4, 24)
    starts = 1 if dice.chance(0.8) else 2
    pitch_radius = 120.0
    room = 2.0 * pitch_radius * sin(pi / (stops * starts))
    diameter = room * dice.between(0.3, 0.7)
    outer = pitch_radius * dice.between(0.3, 0.8)
    length = min(diameter, 0.5 * outer) * dice.between(0.3, 0.9)
    width = min(room * dice.between(0.8, 2.2), 1.7 * pitch_radius - diameter)
    cam: dict[str, Any] = {"kind": "cylindrical-index", "form": dice.one("rib", "groove")}
    cam |= {"hand": dice.one("right", "left"), "diameter": 2.0 * outer, "width": width, "tip_clearance": 0.05 * length}
    cam["center_distance"] = pitch_radius * dice.between(0.93, 1.0)
    if dice.chance(0.3):
        cam["running_clearance"] = diameter * dice.log(1e-4, 0.02)
    _bored(dice, cam, 0.7 * (outer - length) - 0.3 * diameter)
    follower = {"kind": "turret", "stops": stops, "rollers": stops * starts, "pitch_radius": pitch_radius}
    roller = _roller(dice, diameter, length)
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _indexing(dice, stops, stops * starts)}


def _globoid(dice: Dice) -> dict[str, Any]:
    stops = dice.whole(3, 24)
    starts = 1 if dice.chance(0.8) or stops > 16 else 2
    count = stops * starts
    pitch_radius = 90.0
    length = pitch_radius * dice.between(0.1, 0.3)
    inner = pitch_radius - 0.5 * length
    diameter = 2.0 * inner * sin(pi / count) * dice.between(0.35, 0.8)
    diameter = min(diameter, 0.9 * pitch_radius)
    roller = _roller(dice, diameter, length)
    low = pitch_radius if roller["shape"] == "sphere" else inner
    globoid = low + 0.05 * length * dice.between(0.2, 1.5)
    reach = pitch_radius + 0.5 * length + 0.25 * diameter
    cam: dict[str, Any] = {"kind": "globoidal", "form": dice.one("rib", "groove"), "hand": dice.one("right", "left")}
    cam |= {"center_distance": reach * dice.between(1.3, 2.2), "globoid_radius": globoid}
    cam["tip_clearance"] = 0.03 * length
    rib = 2.0 * pitch_radius * sin(pi / count)
    cam["width"] = min(rib * dice.between(0.7, 1.8), 1.5 * globoid)
    if dice.chance(0.3):
        cam["running_clearance"] = diameter * dice.log(1e-4, 0.02)
    if dice.chance(0.2):
        cam["preload"] = diameter * dice.log(1e-5, 1e-3)
    floor = cam["center_distance"] - reach - 0.1 * pitch_radius
    _bored(dice, cam, 0.8 * floor)
    if dice.chance(0.3):
        bore = 0.5 * cam.get("bore", 0.0) + cam.get("keyway_depth", 0.0)
        cam |= {"hub_diameter": 2.0 * (bore + 0.5 * max(0.0, floor - bore)), "hub_length": 0.3 * pitch_radius}
    follower = {"kind": "turret", "stops": stops, "rollers": count, "pitch_radius": pitch_radius}
    return {"cam": cam, "follower": follower, "roller": roller, "motion": _indexing(dice, stops, count)}


def _plates(dice: Dice) -> dict[str, Any]:
    return plates(dice, dice.whole(2, 4))


def plates(dice: Dice, count: int) -> dict[str, Any]:
    """Two to four plates beside their turret, at the centre distance that the pressure angle in the dwell asks for.

    Where the index begins a direction of two or three plates has the roller half a pitch beside the line of centres, of
    four the one a pitch and a half beside it. With its angle t there, C the centre distance over the pitch radius and a
    the pressure angle, cos(a) = C sin(t) / sqrt(C^2 - 2 C cos(t) + 1).
    """
    stops = dice.whole(*{2: (4, 6), 3: (4, 9), 4: (4, 8)}[count])
    rollers, pitch_radius = stops * count, 100.0
    t, a = pi / rollers * (3.0 if count == 4 else 1.0), np.radians(dice.between(36.0, 44.0))
    k = float(np.cos(a))
    root = k * k * np.cos(t)
    apart = (root + sqrt(root**2 - k * k * (k * k - sin(t) ** 2))) / (k * k - sin(t) ** 2)
    center = float(pitch_radius * min(max(apart, 1.12), 2.6))
    ring = 2.0 * pitch_radius * sin(pi / stops)
    radius = min(0.16 * pitch_radius, 0.36 * ring, 0.55 * (center - pitch_radius)) * dice.between(0.7, 1.1)
    width = pitch_radius * dice.between(0.05, 0.3)
    cam: dict[str, Any] = {"kind": "parallel-index", "center_distance": center, "width": width, "plates": count}
    cam |= {"diameter": 2.0 * center * dice.between(0.8, 0.88), "gap": width * dice.between(0.8, 1.5)}
    if dice.chance(0.3):
        cam["running_clearance"] = radius * dice.log(1e-4, 0.02)
    _bored(dice, cam, 0.8 * (center - pitch_radius - radius))
    follower = {"kind": "turret", "stops": stops, "rollers": rollers, "pitch_radius": pitch_radius}
    roller = {"diameter": 2.0 * radius, "length": width * dice.between(0.7, 1.0)}
    share = dice.between(0.55, 0.75)
    low = 180.0 * (1.0 - share) * (dice.between(0.7, 1.3) if dice.chance(0.3) else 1.0)
    high = low + 360.0 * share
    motion = ({"until": low}, {"until": high, "to": 360.0 / stops, **_law(dice)}, {"until": 360.0})
    return {"cam": cam, "follower": follower, "roller": roller, "motion": motion}
