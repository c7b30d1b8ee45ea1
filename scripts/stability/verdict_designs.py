"""Sound designs of every kind as plain profile tables, with room to every limit by formulas that stand here alone.

Nothing of the product is imported: sizes follow from a target for the pressure angle, for r k (radius of roller times
curvature of its path) and for walls, loads from Hertz' line contact. A design is a function of its seed.
"""

from __future__ import annotations

from collections.abc import Callable
from math import atan, cos, degrees, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
from designs import Dice

Data = dict[str, Any]
LAWS = {
    "cycloidal": (2.0, 2.0 * pi),
    "modified-sine": (1.7596, 5.528),
    "3-4-5": (1.875, 5.7735),
    "4-5-6-7": (2.1875, 7.5132),
    "modified-trapezoid": (2.0, 4.8881),
}
"""peak velocity and acceleration of the normalised laws (any handbook of cams)"""
STEEL = 206000.0
"""MPa"""
LIMIT = 2450.0
"""MPa, the hardened steel of the profiles"""


class Trip:
    """Dwell, rise, dwell, return, dwell: what bounds the slopes of a motion."""

    def __init__(self, dice: Dice) -> None:
        self.first, self.top = dice.between(15.0, 40.0), dice.between(25.0, 50.0)
        self.rise, self.fall = dice.between(95.0, 130.0), dice.between(95.0, 130.0)
        self.laws = dice.one(*LAWS), dice.one(*LAWS)

    @property
    def velocity(self) -> float:
        """Largest lift' / stroke, 1/rad."""
        return max(LAWS[law][0] / radians(b) for law, b in zip(self.laws, (self.rise, self.fall)))

    @property
    def acceleration(self) -> float:
        """Largest lift'' / stroke, 1/rad²."""
        return max(LAWS[law][1] / radians(b) ** 2 for law, b in zip(self.laws, (self.rise, self.fall)))

    def segments(self, stroke: float) -> list[Data]:
        """The [[motion]] of a stroke."""
        up = self.first + self.rise
        down = up + self.top + self.fall
        rise, fall = ({"to": to, "law": law} for to, law in zip((stroke, 0.0), self.laws))
        still = {"until": up + self.top}
        return [{"until": self.first}, {"until": up} | rise, still, {"until": down} | fall, {"until": 360.0}]


def hertz(force: float, length: float, radius: float) -> float:
    """Peak pressure of steel on steel in line contact, MPa (N, mm, mm)."""
    return 0.418 * sqrt(force * STEEL / (length * radius))


def bored(dice: Dice, cam: Data, room: float, wall: float) -> None:
    """A bore, at times with a keyway, `wall` mm inside the radius `room`."""
    if dice.chance(0.8):
        keyed = dice.chance(0.5)
        radius = (room - wall) * dice.between(0.4, 0.75)
        cam["bore"] = 2.0 * radius
        if keyed:
            cam |= {"keyway_width": 0.6 * radius, "keyway_depth": 0.15 * radius}


def roller(dice: Dice, radius: float, length: float, shapes: tuple[str, ...] = ("cylinder", "crowned")) -> Data:
    """A roller; a crown is so flat that it takes nothing from the estimate of the pressure."""
    made: Data = {"shape": dice.one(*shapes), "diameter": 2.0 * radius, "length": length}
    if made["shape"] == "crowned":
        made["crown_radius"] = length * dice.between(60.0, 120.0)
    if made["shape"] == "cone":
        made["half_angle"] = dice.between(3.0, 8.0)
    return made


def loaded(dice: Dice, data: Data, reach: float, lift: float, sprung: bool) -> None:
    """Speed, mass and friction so that the pressure stays below a third of the limit; a spring that keeps contact.

    reach   mm, least r L (force-bearing radius times length) of the contact
    lift    mm (rad of a swing), the largest second derivative by the cam angle
    """
    follower, cam, made = data["follower"], data["cam"], data.get("roller", {})
    if made.get("shape") == "crowned" and "groove_depth" in cam:
        # Its belly has to pass the mouth of the groove, which is that of its thinner end.
        drop = made["length"] ** 2 / (8.0 * made["crown_radius"])
        cam["running_clearance"] = max(cam.get("running_clearance", 0.0), 2.0 * drop + 0.002)
    swings = follower["kind"] in ("swinging", "turret")
    arm = follower.get("arm", follower.get("pitch_radius", 1.0)) if swings else 1.0
    force = (LIMIT * dice.between(0.08, 0.2) / 0.418) ** 2 * reach / STEEL
    speed = dice.log(60.0, 300.0)
    peak = lift * (speed * pi / 30.0) ** 2
    share = 0.25 if sprung else 0.6
    operation: Data = {"speed": speed, "friction": 0.05 * force * arm}
    if swings:
        follower["inertia"] = share * force * arm / peak / 1e3
    else:
        follower["mass"] = share * force / peak * 1e3
    if sprung:
        operation |= {"spring_preload": 0.6 * force * arm, "spring_rate": 0.0}
    data["operation"] = operation
    if dice.chance(0.3):
        data["limits"] = {"life_h": 100.0}


def slid(data: Data) -> float:
    """Least that the largest force along a linear cam's travel can be, N: of plate and slide where they turn back."""
    omega = data["operation"]["speed"] * pi / 30.0
    return float(data["cam"]["moving_mass"] * 0.5e-3 * data["cam"]["stroke"] * omega**2)


def moves(data: Data) -> list[tuple[float, float, str]]:
    """Angle, rad (of a linear cam mm), size (mm; rad of a swing) and law of every move."""
    unit, per = pi / 180.0 if swings(data) else 1.0, 1.0 if data["cam"]["kind"] == "linear" else pi / 180.0
    began, at, found = 0.0, 0.0, []
    for segment in data["motion"]:
        if "to" in segment:
            found.append((per * (segment["until"] - began), unit * abs(segment["to"] - at), segment["law"]))
            at = segment["to"]
        began = segment["until"]
    return found


def swings(data: Data) -> bool:
    return data["follower"]["kind"] in ("swinging", "turret")


def arm_of(data: Data) -> float:
    """What turns a force at the contact into the follower's: its arm, or one."""
    follower = data["follower"]
    if follower["kind"] in ("swinging", "turret"):
        return float(follower.get("arm", follower.get("pitch_radius")))
    return 1.0


def _drum(dice: Dice, form: str, swings: bool) -> Data:
    trip = Trip(dice)
    outer, radius = dice.between(52.0, 80.0), dice.between(7.0, 11.0)
    length = radius * dice.between(1.0, 1.3)
    depth = length + 1.0
    deep = outer - depth
    # A rib of thickness t, asked level, is (t + 2 r) cos(angle) - 2 r where it is steep: more than 0.85 t up to 16 deg.
    slope = tan(radians(dice.between(10.0, 22.0) if form == "groove" else dice.between(8.0, 16.0)))
    stroke = slope * deep / trip.velocity
    wall = dice.between(6.0, 14.0)
    cam: Data = {"kind": "cylindrical", "form": form, "diameter": 2.0 * outer, "groove_depth": depth}
    half = radius
    if form == "rib":
        cam["rib_thickness"] = 2.0 * radius * dice.between(0.7, 1.1)
        half = 0.5 * cam["rib_thickness"] + 2.0 * radius
    cam |= {"start": half + wall, "length": stroke + 2.0 * (half + wall)}
    if dice.chance(0.3):
        cam["running_clearance"] = dice.between(0.005, 0.02)
    bored(dice, cam, deep, 8.0)
    swung, moved = _slid_or_swung(dice, trip, stroke, swings)
    data: Data = {"cam": cam} | moved
    data["roller"] = roller(dice, radius, length, ("cylinder", "cylinder", "crowned", "cone"))
    loaded(dice, data, 0.5 * radius * length, trip.acceleration * (swung if swings else stroke), False)
    return data


def _disc(dice: Dice, face: str, swings: bool, shapes: tuple[str, ...] = ("cylinder", "crowned")) -> Data:
    trip = Trip(dice)
    base, width = dice.between(38.0, 60.0), dice.between(10.0, 18.0)
    radius = {"roller": dice.between(0.18, 0.3) * base, "curved": dice.between(1.2, 2.0) * base, "flat": 0.0}[face]
    prime = base + radius
    stroke = min(tan(radians(dice.between(12.0, 23.0))) * prime / trip.velocity, 0.35 * prime)
    if face != "roller":
        stroke = min(stroke, 0.35 * base / trip.acceleration)  # base + s + s'' stays above 0.6 base
    cam: Data = {"kind": "disc", "base_radius": base, "width": width}
    follower: Data = {"kind": "translating", "face": face}
    lift = stroke * trip.acceleration
    motion = trip.segments(stroke)
    if swings:
        arm = prime * dice.between(1.5, 1.9)
        cam["center_distance"] = sqrt(prime**2 + arm**2)
        swing = 0.8 * stroke / arm
        follower = {"kind": "swinging", "face": face, "arm": arm, "side": dice.one("left", "right")}
        lift, motion = swing * trip.acceleration, trip.segments(degrees(swing))
    elif face == "roller" and dice.chance(0.5):
        follower["offset"] = base * dice.between(-0.08, 0.08)
    data: Data = {"cam": cam, "follower": follower, "motion": motion}
    bored(dice, cam, base, 8.0)
    if face == "roller":
        data["roller"] = roller(dice, radius, width * dice.between(0.8, 1.0), shapes)
    elif face == "curved":
        follower["face_radius"] = radius
    else:
        follower["face_width"] = 2.0 * stroke * trip.velocity * 1.3 + 4.0
    rolls = radius * base / (radius + base) if radius else 0.5 * base
    loaded(dice, data, 0.4 * rolls * width, lift, True)
    if face != "roller":
        data.setdefault("limits", {}).pop("life_h", None)
    return data


def _face_groove(dice: Dice, swings: bool, shapes: tuple[str, ...] = ("cylinder", "crowned")) -> Data:
    trip = Trip(dice)
    base, radius = dice.between(42.0, 60.0), dice.between(7.0, 11.0)
    prime, depth = base + radius, dice.between(9.0, 13.0)
    stroke = min(tan(radians(dice.between(12.0, 22.0))) * prime / trip.velocity, 0.3 * prime)
    cam: Data = {"kind": "disc", "form": "groove", "base_radius": base, "groove_depth": depth}
    cam["width"] = depth + dice.between(8.0, 14.0)
    cam["diameter"] = 2.0 * (base + 2.0 * radius + stroke + dice.between(8.0, 16.0))
    if dice.chance(0.4):
        cam["running_clearance"] = dice.between(0.005, 0.03)
    bored(dice, cam, base, 8.0)
    follower: Data = {"kind": "translating"}
    lift, motion = stroke * trip.acceleration, trip.segments(stroke)
    if swings:
        arm = prime * dice.between(1.5, 1.9)
        cam["center_distance"] = sqrt(prime**2 + arm**2)
        swing = 0.8 * stroke / arm
        follower = {"kind": "swinging", "arm": arm, "side": dice.one("left", "right")}
        lift, motion = swing * trip.acceleration, trip.segments(degrees(swing))
    length = depth - 1.0
    data = {"cam": cam, "follower": follower, "roller": roller(dice, radius, length, shapes), "motion": motion}
    loaded(dice, data, 0.4 * radius * length, lift, False)
    return data


BODY = ("kind", "width", "bore", "keyway_width", "keyway_depth", "diameter")
"""keys of a disc that all of its tracks have in common"""


def _track(dice: Dice, data: Data, speed: float, **cam: object) -> Data:
    """A design as a further track on a disc that turns at `speed`: as large a force asks a smaller mass for more."""
    operation = {key: value for key, value in data["operation"].items() if key != "speed"}
    follower = dict(data["follower"])
    key = "inertia" if "inertia" in follower else "mass"
    follower[key] *= (data["operation"]["speed"] / speed) ** 2
    own = {name: value for name, value in data["cam"].items() if name not in BODY}
    return {"angle": dice.between(0.0, 359.0), "cam": own | cam, "follower": follower, "roller": data["roller"],
            "motion": data["motion"], "operation": operation}  # fmt: skip


def _both_faces(dice: Dice) -> Data:
    """A plate with a groove in each face, 8 to 14 mm of web between the floors."""
    data, other = _face_groove(dice, False), _face_groove(dice, dice.chance(0.4))
    cam, lower = data["cam"], other["cam"]
    if lower["base_radius"] < cam["base_radius"]:
        # The bore is as far from one groove as from the other.
        cam |= {key: lower.get(key, 0.0) for key in ("bore", "keyway_width", "keyway_depth")}
        for key in [key for key in ("bore", "keyway_width", "keyway_depth") if not cam[key]]:
            del cam[key]
    cam["width"] = cam["groove_depth"] + lower["groove_depth"] + dice.between(8.0, 14.0)
    cam["diameter"] = max(cam["diameter"], lower["diameter"])
    lower.setdefault("running_clearance", 0.0)
    data["track"] = [_track(dice, other, data["operation"]["speed"], face="lower")]
    return data


def _groove_and_rim(dice: Dice) -> Data:
    """A disc with a groove in its upper face, and 8 to 16 mm of wall at least between that and its profile."""
    data, other = _disc(dice, "roller", False), _face_groove(dice, False)
    cam, groove = data["cam"], other["cam"]
    data["follower"].pop("offset", None)
    for key in ("bore", "keyway_width", "keyway_depth"):
        cam.pop(key, None)
    cam |= {key: groove[key] for key in ("bore", "keyway_width", "keyway_depth") if key in groove}
    cam["base_radius"] = 0.5 * groove["diameter"]
    cam["width"] = max(cam["width"], groove["width"])
    track = _track(dice, other, data["operation"]["speed"], rim="profile")
    # What presses one follower on its cam is not the other's.
    track["operation"] |= {"spring_preload": 0.0, "spring_rate": 0.0}
    data["track"] = [track]
    return data


def _constant_width(dice: Dice, yoke: bool) -> Data:
    law = dice.one(*LAWS)
    rise = dice.between(125.0, 150.0)
    velocity, acceleration = LAWS[law][0] / radians(rise), LAWS[law][1] / radians(rise) ** 2
    base = dice.between(36.0, 55.0)
    stroke = base * dice.between(0.2, 0.32)  # base + s + s'' stays above half of base
    cam: Data = {"kind": "constant-width", "base_radius": base, "width": dice.between(10.0, 18.0)}
    bored(dice, cam, base, 8.0)
    follower: Data = {"kind": "frame", "clearance": dice.between(0.01, 0.05)}
    motion: list[Data] = [{"until": rise, "to": stroke, "law": law}, {"until": 180.0}]
    data: Data = {"cam": cam, "follower": follower, "motion": motion}
    radius = 0.5 * base
    if yoke:
        radius = base * dice.between(0.15, 0.25)
        data["roller"] = roller(dice, radius, 0.9 * cam["width"])
    else:
        follower["face_width"] = 2.0 * stroke * velocity * 1.3 + 4.0
    loaded(dice, data, 0.4 * radius * cam["width"], stroke * acceleration, False)
    if not yoke:
        data.setdefault("limits", {}).pop("life_h", None)
    return data


def _conjugate(dice: Dice, swings: bool, shapes: tuple[str, ...] = ("cylinder", "crowned")) -> Data:
    trip = Trip(dice)
    base = dice.between(70.0, 130.0)
    radius, width = base * dice.between(0.13, 0.17), dice.between(14.0, 22.0)
    prime = base + radius
    stroke = tan(radians(dice.between(12.0, 20.0))) * prime / trip.velocity
    cam: Data = {"kind": "conjugate", "base_radius": base, "width": width, "gap": dice.between(2.0, 8.0)}
    bored(dice, cam, 0.8 * base, 8.0)
    follower: Data = {"kind": "translating", "clearance": 0.06}
    lift, motion = stroke * trip.acceleration, trip.segments(stroke)
    if swings:
        # The proportions of a machine that is published: 205 mm apart, 130 mm of base radius, an arm of 90 mm.
        arm = 0.6 * prime
        cam["center_distance"] = 1.367 * prime
        swing = min(0.6 * stroke / arm, radians(20.0))
        follower = {"kind": "swinging", "arm": arm, "clearance": 0.1}
        lift, motion = swing * trip.acceleration, trip.segments(degrees(swing))
    data = {"cam": cam, "follower": follower, "roller": roller(dice, radius, width, shapes), "motion": motion}
    loaded(dice, data, 0.4 * radius * width, lift, False)
    return data


def _index(dice: Dice, angle: float, low: float, high: float) -> tuple[list[Data], float, float]:
    """One index of a turret by `angle` deg: its segments, its largest slope and second derivative."""
    over = dice.between(low, high)
    law = dice.one("modified-sine", "modified-sine", "3-4-5")
    before = 180.0 - 0.5 * over
    segments: list[Data] = [{"until": before}, {"until": 360.0 - before, "to": angle, "law": law}, {"until": 360.0}]
    return segments, LAWS[law][0] * angle / over, LAWS[law][1] * radians(angle) / radians(over) ** 2


def _globoid(dice: Dice, form: str) -> Data:
    count = dice.whole(6, 10) if form == "rib" else dice.whole(16, 24)
    pitch = dice.between(75.0, 95.0) if form == "rib" else dice.between(125.0, 150.0)
    chord = 2.0 * pitch * sin(pi / count)
    radius = 0.5 * chord * (dice.between(0.42, 0.5) if form == "rib" else 0.52)
    length = radius * dice.between(1.1, 1.4)
    segments, slope, lift = _index(dice, 360.0 / count, 140.0, 180.0)
    deep = pitch + 0.5 * length
    steep = tan(radians(dice.between(24.0, 31.0)))
    center = deep + max(deep * slope / steep, 0.5 * deep)
    tip = dice.between(0.6, 1.0)
    cam: Data = {"kind": "globoidal", "form": form, "hand": dice.one("right", "left"), "center_distance": center}
    made = roller(dice, radius, length, ("cylinder", "cone") if form == "rib" else ("cylinder",))
    # The grooves of the rollers that straddle a rib stay open at the end faces, also where a cone is narrow.
    narrow = radius - 0.5 * length * tan(radians(made.get("half_angle", 0.0)))
    room = 2.0 * (pitch - 0.5 * length) * sin(pi / count) + 1.5 * narrow if form == "rib" else chord + 2.6 * radius
    cam |= {"width": room, "globoid_radius": pitch - 0.5 * length + 2.0}
    cam["tip_clearance"] = tip
    bored(dice, cam, center - deep - tip, 10.0)
    follower: Data = {"kind": "turret", "stops": count, "pitch_radius": pitch}
    data = {"cam": cam, "follower": follower, "roller": made, "motion": segments}
    loaded(dice, data, 0.3 * radius * length, lift, False)
    return data


def _barrel(dice: Dice) -> Data:
    count = dice.whole(12, 20)
    chord = dice.between(50.0, 64.0)
    pitch = 0.5 * chord / sin(pi / count)
    radius = 0.5 * chord * dice.between(0.45, 0.52)
    length = radius * dice.between(0.85, 1.0)
    segments, slope, lift = _index(dice, 360.0 / count, 150.0, 190.0)
    steep = tan(radians(dice.between(28.0, 34.0)))
    outer = max(pitch * slope / steep + length, 50.0)
    sag = pitch * (1.0 - sqrt(1.0 - (0.5 * chord / pitch) ** 2))
    cam: Data = {"kind": "cylindrical-index", "form": "rib", "hand": dice.one("right", "left")}
    cam |= {"center_distance": pitch - 0.7 * sag, "diameter": 2.0 * outer, "width": chord + 1.3 * radius}
    cam["tip_clearance"] = 0.6
    bored(dice, cam, outer - length - 4.0 - sag, 8.0)
    follower: Data = {"kind": "turret", "stops": count, "pitch_radius": pitch}
    data = {"cam": cam, "follower": follower, "roller": roller(dice, radius, length, ("cylinder",)), "motion": segments}
    loaded(dice, data, 0.3 * radius * length, lift, False)
    return data


def _parallel(dice: Dice, plates: int) -> Data:
    """Two plates in the proportions of a published machine; three and four in those that this file's search found.

    Where the index begins, three plates hold one direction with a roller half a pitch t beside the line of centres:
    with C the centre distance over the pitch radius its pressure angle a is C sin(t) = cos(a) sqrt(C^2 - 2 C cos(t) +
    1), 41 to 45 deg at the C here, 57 deg with twelve rollers at 1.75.

    The path of a roller has a cusp where it crosses the line of centres as fast as the cam, at a ratio of C - 1. Of
    four plates one crosses at 3/8 of the lift, about that fast: C keeps 2.5 % of C - 1 away from there.
    """
    stops, count = {2: (4, 8), 3: (5, 15), 4: (4, 16)}[plates]
    pitch = dice.between(70.0, 100.0)
    center = pitch * (dice.between(1.26, 1.29) if plates == 3 else dice.between(1.72, 1.78))
    radius = pitch * (dice.between(0.09, 0.11) if plates == 3 else dice.between(0.105, 0.12))
    segments, _, lift = _index(dice, 360.0 / stops, 200.0, 225.0)
    if plates == 4:
        over = segments[1]["until"] - segments[0]["until"]
        crossing = {"modified-sine": 1.7003, "3-4-5": 1.8073}[segments[1]["law"]] * 360.0 / stops / over
        away = (center / pitch - 1.0) / crossing - 1.0
        if abs(away) < 0.025:
            center = pitch * (1.0 + crossing * (1.025 if away > 0.0 else 0.975))
    width = dice.between(12.0, 18.0)
    cam: Data = {"kind": "parallel-index", "center_distance": center, "width": width}
    cam["diameter"] = (1.68 if plates == 3 else 1.557) * center
    cam |= {"gap": width + dice.between(6.0, 10.0), "plates": plates}
    bored(dice, cam, center - pitch - radius, 4.0 if plates == 3 else 8.0)
    follower: Data = {"kind": "turret", "stops": stops, "rollers": count, "pitch_radius": pitch}
    made = roller(dice, radius, width - 2.0, ("cylinder",))
    data = {"cam": cam, "follower": follower, "roller": made, "motion": segments}
    loaded(dice, data, 0.2 * radius * width, lift, False)
    return data


def _end_face(dice: Dice, swings: bool) -> Data:
    trip = Trip(dice)
    outer, ring, radius = dice.between(52.0, 80.0), dice.between(14.0, 20.0), dice.between(8.0, 12.0)
    inner, length = outer - ring, ring * dice.between(0.6, 0.85)
    stroke = tan(radians(dice.between(10.0, 22.0))) * inner / trip.velocity
    web = dice.between(8.0, 14.0)
    cam: Data = {"kind": "end-face", "diameter": 2.0 * outer, "inner_diameter": 2.0 * inner, "web": web}
    cam["height"] = web + dice.between(10.0, 20.0)
    bored(dice, cam, inner, 8.0)
    swung, moved = _slid_or_swung(dice, trip, stroke, swings)
    data: Data = {"cam": cam} | moved
    lift = trip.acceleration * (swung if swings else stroke)
    data["roller"] = roller(dice, radius, length, ("cylinder", "cylinder", "crowned", "cone"))
    loaded(dice, data, 0.5 * radius * length, lift, True)
    return data


def _bell(dice: Dice, swings: bool) -> Data:
    """A groove in the inside of a ring, whose least radius is that of its path."""
    trip = Trip(dice)
    inner, radius = dice.between(48.0, 72.0), dice.between(7.0, 11.0)
    length, wall, web = radius * dice.between(1.0, 1.3), dice.between(6.0, 14.0), dice.between(8.0, 14.0)
    stroke = tan(radians(dice.between(10.0, 22.0))) * inner / trip.velocity
    swung, data = _slid_or_swung(dice, trip, stroke, swings)
    # A flat end reaches deepest with its edge, the more where an arm carries it aside of the axis.
    aside = 0.5 * data["follower"].get("arm", 0.0) * (1.0 - cos(0.5 * swung)) if swings else 0.0
    depth = sqrt((inner + length) ** 2 + (radius + aside) ** 2) - inner + 1.0
    cam: Data = {"kind": "end-face", "form": "groove", "inner_diameter": 2.0 * inner, "groove_depth": depth, "web": web}
    cam |= {"diameter": 2.0 * (inner + depth + wall), "start": web + wall + radius}
    cam["length"] = cam["start"] + stroke + radius + wall
    if dice.chance(0.3):
        cam["running_clearance"] = dice.between(0.005, 0.02)
    bored(dice, cam, inner, 8.0)
    data = {"cam": cam} | data
    data["roller"] = roller(dice, radius, length, ("cylinder", "cylinder", "crowned", "cone"))
    loaded(dice, data, 0.5 * radius * length, trip.acceleration * (swung if swings else stroke), False)
    return data


def _slid_or_swung(dice: Dice, trip: Trip, stroke: float, swings: bool) -> tuple[float, Data]:
    """Swing, rad, and follower with its motion: a slide's, or an arm's, which strays by a (1 - cos) of half its swing.
    """
    if not swings:
        return 0.0, {"follower": {"kind": "translating"}, "motion": trip.segments(stroke)}
    arm = max(stroke * dice.between(2.2, 3.2), 40.0)
    swing = 2.0 * atan(0.5 * stroke / arm)
    follower: Data = {"kind": "swinging", "arm": arm, "start_angle": -0.5 * degrees(swing)}
    return swing, {"follower": follower, "motion": trip.segments(degrees(swing))}


def _conical(dice: Dice) -> Data:
    """A groove in a cone, whose narrow end is as thick as a drum's core is."""
    trip = Trip(dice)
    narrow, radius = dice.between(46.0, 66.0), dice.between(7.0, 11.0)
    length, wall = radius * dice.between(1.0, 1.3), dice.between(6.0, 14.0)
    lean = radians(dice.between(5.0, 50.0))
    depth, c, s = length + 1.0, cos(lean), sin(lean)
    # The roller's tip is nearest to the axis where it stands at the narrow end.
    deep = narrow - depth * c
    stroke = tan(radians(dice.between(10.0, 22.0))) * deep / trip.velocity
    # Towards the wide end the groove's foot stands beyond its edge.
    ahead, behind = radius + wall, radius + wall + depth * s / c
    along = stroke + ahead + behind
    wide = narrow + along * s
    cam: Data = {"kind": "conical", "diameter": 2.0 * wide, "half_angle": degrees(lean), "start": behind}
    if dice.chance(0.5):
        cam |= {"diameter": 2.0 * narrow, "half_angle": -degrees(lean), "start": ahead}
    cam |= {"length": along * c, "groove_depth": depth}
    if dice.chance(0.3):
        cam["running_clearance"] = dice.between(0.005, 0.02)
    bored(dice, cam, deep, 8.0)
    data: Data = {"cam": cam, "motion": trip.segments(stroke), "follower": {"kind": "translating"}}
    data["roller"] = roller(dice, radius, length, ("cylinder", "cylinder", "crowned", "cone"))
    # Where the path is sharpest a flank has about half the roller's radius, see `loaded`.
    loaded(dice, data, 0.5 * radius * length, trip.acceleration * stroke, False)
    return data


def _linear(dice: Dice) -> Data:
    """A groove in a plate that a crank with a long rod slides out and back."""
    trip = Trip(dice)
    travel, radius = dice.between(140.0, 220.0), dice.between(7.0, 11.0)
    length, wall = radius * dice.between(1.0, 1.3), dice.between(8.0, 14.0)
    # Path of the roller over the travel, mm: slopes by the angle are slopes by the travel times travel / (2 pi).
    stroke = tan(radians(dice.between(10.0, 22.0))) * travel / (2.0 * pi) / trip.velocity
    cam: Data = {"kind": "linear", "stroke": travel, "drive": "simple-harmonic", "groove_depth": length + 1.0}
    cam |= {"thickness": length + 1.0 + wall, "start": radius + wall, "length": travel + 2.0 * (radius + wall)}
    cam |= {"edge": radius + wall, "width": stroke + 2.0 * (radius + wall)}
    cam["moving_mass"] = dice.between(2.0, 8.0) + blank_mass(cam, cam["width"])
    if dice.chance(0.3):
        cam["running_clearance"] = dice.between(0.005, 0.02)
    motion = trip.segments(stroke)
    for segment in motion:
        segment["until"] *= travel / 360.0
    data: Data = {"cam": cam, "motion": motion, "follower": {"kind": "translating"}}
    data["roller"] = roller(dice, radius, length)
    loaded(dice, data, radius * length, swayed(data), False)
    return data


def _linear_edge(dice: Dice) -> Data:
    """The edge of a plate, on which a spring holds the follower."""
    trip = Trip(dice)
    travel, radius = dice.between(140.0, 220.0), dice.between(7.0, 11.0)
    length, wall = radius * dice.between(1.0, 1.3), dice.between(8.0, 14.0)
    stroke = tan(radians(dice.between(10.0, 22.0))) * travel / (2.0 * pi) / trip.velocity
    cam: Data = {"kind": "linear", "form": "edge", "stroke": travel, "drive": "simple-harmonic"}
    cam |= {"thickness": length * dice.between(1.0, 2.0), "start": radius + wall, "edge": radius + wall}
    cam["length"] = travel + 2.0 * (radius + wall)
    cam["moving_mass"] = dice.between(2.0, 8.0) + blank_mass(cam, stroke + radius + wall)
    motion = trip.segments(stroke)
    for segment in motion:
        segment["until"] *= travel / 360.0
    data: Data = {"cam": cam, "motion": motion, "follower": {"kind": "translating"}}
    data["roller"] = roller(dice, radius, length)
    # Where the edge is sharpest it has about half the roller's radius, see `loaded`.
    loaded(dice, data, 0.5 * radius * length, swayed(data), True)
    return data


def blank_mass(cam: Data, height: float) -> float:
    """kg of the steel plate that a linear cam is cut from, which is heavier than the cam itself."""
    return float(7.85e-6 * cam["thickness"] * cam["length"] * height)


def swayed(data: Data) -> float:
    """Largest second derivative of a linear cam's lift by the angle of its crank, mm, by differences."""
    travel, count = data["cam"]["stroke"], 7200
    x = 0.5 * travel * (1.0 - np.cos(pi * np.arange(count + 1) / count))
    lift, began, at = np.zeros_like(x), 0.0, 0.0
    for segment in data["motion"]:
        share, to = (x - began) / (segment["until"] - began), segment.get("to", at)
        # One law for all: with the peak acceleration of any it differs by less than the room there is to limits.
        lift = np.where(share >= 0.0, at + (to - at) * five(np.clip(share, 0.0, 1.0)), lift)
        began, at = segment["until"], to
    return float(np.abs(np.diff(lift, 2)).max()) / (pi / count) ** 2


def five(x: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """The 3-4-5 polynomial."""
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


KINDS: dict[str, Callable[[Dice], Data]] = {
    "drum groove": lambda dice: _drum(dice, "groove", False),
    "drum groove, swinging": lambda dice: _drum(dice, "groove", True),
    "drum rib": lambda dice: _drum(dice, "rib", False),
    "drum rib, swinging": lambda dice: _drum(dice, "rib", True),
    "disc, roller": lambda dice: _disc(dice, "roller", False),
    "disc, swinging roller": lambda dice: _disc(dice, "roller", True),
    "disc, flat": lambda dice: _disc(dice, "flat", False),
    "disc, curved": lambda dice: _disc(dice, "curved", False),
    "face groove": lambda dice: _face_groove(dice, False),
    "face groove, swinging": lambda dice: _face_groove(dice, True),
    "frame": lambda dice: _constant_width(dice, False),
    "yoke": lambda dice: _constant_width(dice, True),
    "rocker": lambda dice: _conjugate(dice, True),
    "slide": lambda dice: _conjugate(dice, False),
    "globoid rib": lambda dice: _globoid(dice, "rib"),
    "globoid groove": lambda dice: _globoid(dice, "groove"),
    "barrel": _barrel,
    "parallel, 2 plates": lambda dice: _parallel(dice, 2),
    "parallel, 3 plates": lambda dice: _parallel(dice, 3),
    "parallel, 4 plates": lambda dice: _parallel(dice, 4),
    "end face": lambda dice: _end_face(dice, False),
    "end face, swinging": lambda dice: _end_face(dice, True),
    "both faces": _both_faces,
    "groove and rim": _groove_and_rim,
    "linear": _linear,
    "linear edge": _linear_edge,
    "disc, cone": lambda dice: _disc(dice, "roller", False, ("cone",)),
    "disc, swinging cone": lambda dice: _disc(dice, "roller", True, ("cone",)),
    "cone groove": _conical,
    "bell groove": lambda dice: _bell(dice, False),
    "bell groove, swinging": lambda dice: _bell(dice, True),
    "face groove, cone": lambda dice: _face_groove(dice, False, ("cone",)),
    "face groove, swinging cone": lambda dice: _face_groove(dice, True, ("cone",)),
    "rocker, cone": lambda dice: _conjugate(dice, True, ("cone",)),
    "slide, cone": lambda dice: _conjugate(dice, False, ("cone",)),
}
"""how a design of every kind is made; the kind of a seed is that of its remainder"""
SEVERAL = ("both faces", "groove and rim")
"""kinds with several tracks on one body: their own faults are those of what is left between the tracks"""
FIRST_SEED = 5000
"""sound designs from here on are furnished; those below are the ones of the record in docs/stability.md"""
FIRST_KINDS = 20
"""kinds of the seeds below"""
LINEAR_SEED, SECOND_KINDS = 60_000, 24
"""linear cams come from here on; kinds of the seeds below"""
SLID = 80_000
"""linear cams vibrate from here on"""
EDGE_SEED, THIRD_KINDS = 70_000, 25
"""edges of plates come from here on; kinds of the seeds below"""
CONE_SEED, FOURTH_KINDS = 90_000, 26
"""discs of conical rollers come from here on; kinds of the seeds below"""
DRUM_SEED, FIFTH_KINDS = 100_000, 28
"""conical drums come from here on; kinds of the seeds below"""
BELL_SEED, SIXTH_KINDS = 110_000, 29
"""bells with a groove come from here on; kinds of the seeds below"""
LEAN_SEED, SEVENTH_KINDS = 120_000, 31
"""grooves and pairs of conical rollers come from here on; kinds of the seeds below"""


def kinds_of(seed: int) -> tuple[str, ...]:
    """The kinds that a seed may have."""
    bounds = ((FIRST_SEED, FIRST_KINDS), (LINEAR_SEED, SECOND_KINDS), (EDGE_SEED, THIRD_KINDS),
              (CONE_SEED, FOURTH_KINDS), (DRUM_SEED, FIFTH_KINDS), (BELL_SEED, SIXTH_KINDS),
              (LEAN_SEED, SEVENTH_KINDS))  # fmt: skip
    return tuple(KINDS)[: next((count for end, count in bounds if seed < end), len(KINDS))]


def kind_of(seed: int) -> str:
    """The kind of a seed."""
    kinds = kinds_of(seed)
    return kinds[seed % len(kinds)]


def sound(seed: int, kind: str = "") -> Data:
    """The sound design of a seed, of its own kind or of the one given."""
    dice = Dice(seed)
    data = KINDS[kind or kind_of(seed)](dice)
    data["name"] = f"sound {seed}"
    direction = dice.one("ccw", "cw")
    data["cam"] |= {} if data["cam"]["kind"] == "linear" else {"direction": direction}
    data["output"] = {"tolerance": dice.log(0.008, 0.03)}
    data["material"] = {body: {"hardness": 60.0} for body in ("cam", "roller")}
    if data["follower"]["kind"] == "turret":
        # 30 seconds of arc are what a dwell may err by; the mesh takes at most 20 of them.
        finest = dice.between(12.0, 20.0) / 3600.0
        data["output"]["tolerance"] = radians(finest) * data["follower"]["pitch_radius"]
    return data


def pressing(data: Data) -> float:
    """Most that any force of a follower can be, N, from above: inertia, friction and spring together, twice."""
    operation, follower = data["operation"], data["follower"]
    omega = operation["speed"] * pi / 30.0
    mass = follower["inertia"] * 1e3 if swings(data) else follower["mass"] * 1e-3
    if data["cam"]["kind"] == "linear":
        inertia = mass * swayed(data) * omega**2
    else:
        inertia = max(mass * LAWS[law][1] * size / angle**2 * omega**2 for angle, size, law in moves(data))
    return float(2.0 * (inertia + operation["friction"] + operation.get("spring_preload", 0.0)) / arm_of(data))


def furnished(seed: int) -> Data:
    """The sound design of a seed with further limits, all far away, and a third of them with a stiff, damped drive."""
    data, dice = sound(seed), Dice(seed + 2_000_003)
    kind, most, limits = data["follower"]["kind"], pressing(data), data.setdefault("limits", {})
    linear = data["cam"]["kind"] == "linear"
    if linear and dice.chance(0.6):
        slope = max(LAWS[law][0] * size / angle for angle, size, law in moves(data))
        limits["drive_force_n"] = (most * (slope + 0.5) + slid(data)) * dice.between(2.0, 4.0)
    if "roller" in data and dice.chance(0.6):
        # No more than rolls: a law's mean acceleration is over half its peak, three rollers share, a move takes a third
        # of the turn and more, so that the equivalent load is above most / 2 / 2 / 3 * (1/3)^0.3 = 0.06 most, and
        # bearings need 0.0167 of their static rating to roll.
        data["roller"] |= {"dynamic_rating": 10.0 * most, "static_rating": dice.between(1.5, 3.0) * most}
    if dice.chance(0.6) and not linear:
        slope = max(LAWS[law][0] * size / angle for angle, size, law in moves(data))
        # Work of the follower over the angle; what presses off its line costs no torque.
        limits["torque_n_m"] = 1e-3 * most * arm_of(data) * slope * dice.between(2.0, 4.0)
    if kind == "turret" and dice.chance(0.6):
        limits["output_torque_n_m"] = 1e-3 * most * arm_of(data) * dice.between(1.5, 3.0)
    if dice.chance(0.6):
        for body in ("cam", "roller"):
            data["material"][body]["case_depth_mm"] = dice.between(4.0, 6.0)
    if data["operation"].get("spring_preload") is None and dice.chance(0.6):
        limits["play_mm"] = dice.between(0.25, 0.4)
    if dice.chance(0.33) and (not linear or seed >= SLID):
        data["dynamics"] = stiff(data, dice)
    if not limits:
        del data["limits"]
    return data


def stiff(data: Data, dice: Dice) -> Data:
    """[dynamics] whose lowest mode swings 30 to 40 times within the shortest move, damped by a fifth to a third."""
    omega, follower = data["operation"]["speed"] * pi / 30.0, data["follower"]
    # A plate is quickest at half its stroke per radian of the crank.
    per = 0.5 * data["cam"]["stroke"] if data["cam"]["kind"] == "linear" else 1.0
    shortest = min(angle for angle, _, _ in moves(data)) / (per * omega)
    rate, damped = 2.0 * pi * dice.between(30.0, 40.0) / shortest, 2.0 * dice.between(0.2, 0.33)
    if follower["kind"] != "turret":
        # kg m2 and N m/rad of an arm; of a slide kg, N/mm and N s/m
        mass, per = (follower["inertia"], 1.0) if swings(data) else (follower["mass"], 1e-3)
        band = 0.01 * max(segment.get("to", 0.0) for segment in data["motion"])
        return {"kind": "follower", "linkage_stiffness": per * mass * rate**2, "linkage_damping": damped * mass * rate,
                "settling_band": band, "tolerance": 1e-4}  # fmt: skip
    inertia = follower["inertia"]
    follower["inertia"], data["operation"]["load_inertia"] = 0.1 * inertia, 0.9 * inertia
    shaft = inertia * rate**2
    return {"kind": "indexing", "input_stiffness": 3.0 * shaft, "output_stiffness": shaft, "tolerance": 1e-4,
            "input_damping": damped * shaft / rate, "output_damping": damped * shaft / rate,
            "contact_damping": damped * shaft / rate, "settling_band": 0.05}  # fmt: skip
