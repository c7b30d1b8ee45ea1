"""Several followers on one track, written again from the profile's keys: where they stand, how near, what torque."""

from __future__ import annotations

from math import degrees, radians

import numpy as np

from tests.oracle.cams import _place

TURN = 2.0 * np.pi


def axes(data, lift):
    """Per roller of one follower: ends(phi), two points (3, n) of its axis in the machine, and its radius; or None."""
    cam, follower, roller = data["cam"], data["follower"], data.get("roller")
    if roller is None:
        return None
    r = 0.5 * roller["diameter"]
    if cam["kind"] == "disc" and cam.get("form", "external") == "external":
        half = 0.5 * min(roller["length"], cam["width"])
        place, middle = _place(cam, follower, r, lift), 0.5 * cam["width"]

        def ends(phi):
            x, y = np.broadcast_arrays(*place(phi))
            return tuple(np.stack([x, y, np.full(len(phi), middle + way * half)]) for way in (-1.0, 1.0))

        return [(ends, r)]
    if cam["kind"] == "conical" and roller.get("shape", "cylinder") == "cylinder":
        lean, outer = radians(cam["half_angle"]), 0.5 * cam["diameter"]

        def leaning(phi):
            along = cam["start"] + lift(phi)
            x, z = outer - along * np.sin(lean), along * np.cos(lean)
            return tuple(np.stack([x - deep * np.cos(lean), np.zeros(len(phi)), z - deep * np.sin(lean)])
                         for deep in (roller["length"], 0.0))  # fmt: skip

        return [(leaning, r)]
    if cam["kind"] != "end-face" or follower["kind"] != "translating" or roller.get("shape", "cylinder") != "cylinder":
        return None
    middle, half = 0.25 * (cam["diameter"] + cam["inner_diameter"]), 0.5 * roller["length"]
    reach, height = (middle - half, middle + half), cam["height"] + r

    def radial(phi):
        z = height + lift(phi)
        return tuple(np.stack([np.full(len(phi), x), np.zeros(len(phi)), z]) for x in reach)

    return [(radial, r)]


def stood(points, angle, sense):
    """Points (3, n) turned about the cam by the angle of a place."""
    c, s = np.cos(sense * angle), np.sin(sense * angle)
    return np.stack([c * points[0] - s * points[1], s * points[0] + c * points[1], points[2]])


def least_apart(data, lift, count=1801, shares=17):
    """Least distance between the rollers of two followers by brute force, mm; None where no roller is written here."""
    rollers = axes(data, lift)
    if rollers is None:
        return None
    sense = -1.0 if data["cam"].get("direction") == "cw" else 1.0
    theta = np.linspace(0.0, TURN, count)
    share = np.linspace(0.0, 1.0, shares)
    angles = [0.0, *(radians(station["angle"]) for station in data["station"])]
    sets = []
    for angle in angles:
        for ends, radius in rollers:
            a, b = (stood(end, angle, sense) for end in ends((theta - angle) % TURN))
            sets.append((angle, a[:, :, None] + (b - a)[:, :, None] * share, radius))
    best = np.inf
    for i, (one, p, r) in enumerate(sets):
        for other, q, s in sets[i + 1 :]:
            if one != other:
                gap = np.sqrt(((p[:, :, :, None] - q[:, :, None, :]) ** 2).sum(axis=0)).min(axis=(1, 2))
                best = min(best, float((gap - r - s).min()))
    return best


def least_to_pivot(data, lift, count=20001):
    """Least distance from a roller to the pivot of another follower's arm on a disc by brute force, mm."""
    sense = -1.0 if data["cam"].get("direction") == "cw" else 1.0
    theta, ((ends, radius),) = np.linspace(0.0, TURN, count), axes(data, lift)
    centre = np.array([[data["cam"]["center_distance"]], [0.0], [0.0]])
    angles = [0.0, *(radians(station["angle"]) for station in data["station"])]
    best = np.inf
    for one in angles:
        place = stood(ends((theta - one) % TURN)[0], one, sense)[:2]
        for other in angles:
            if one != other:
                pivot = stood(centre, other, sense)[:2]
                best = min(best, float(np.hypot(*(place - pivot)).min() - radius))
    return best


def torque(data, program, theta):
    """Torque of the camshaft, N mm, (n,), that every force takes by its slope; and where one would pull."""
    operation, follower = data["operation"], data["follower"]
    turns = follower["kind"] == "swinging"
    omega = operation["speed"] * TURN / 60.0
    total = np.zeros(len(theta))
    pulls = np.zeros(len(theta), dtype=bool)
    for station in ({"angle": 0.0}, *data["station"]):
        own = {**operation, **station}
        s, v, a = program.jet((theta - radians(station["angle"])) % TURN, 2)
        key = "inertia" if turns else "mass"
        mass = station.get(key, follower.get(key, 0.0)) + own.get(f"load_{key}", 0.0)
        # kg mm / s2 is 1e-3 N; kg m2 / s2 is 1e3 N mm.
        force = mass * omega**2 * a * (1e3 if turns else 1e-3)
        force = force + own.get("friction", 0.0) * np.sign(v) + own.get("spring_preload", 0.0)
        force = force + own.get("spring_rate", 0.0) * (degrees(1.0) if turns else 1.0) * s
        total += force * v
        pulls |= force < 0.0
    return total, pulls
