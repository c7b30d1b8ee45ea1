"""Discs of conical rollers: one profile, random designs, and where the roller's axis stands by the keys alone."""

from __future__ import annotations

import random
from math import acos, atan2, degrees, pi
from typing import Any

import numpy as np

DATA: dict[str, Any] = {
    "name": "cone",
    "cam": {"kind": "disc", "base_radius": 40.0, "width": 20.0, "bore": 25.0},
    "follower": {"kind": "translating", "mass": 2.0, "offset": 5.0},
    "roller": {"shape": "cone", "diameter": 24.0, "length": 16.0, "half_angle": 10.0},
    "operation": {"speed": 200.0, "spring_preload": 150.0, "spring_rate": 10.0},
    "motion": (
        {"until": 60.0},
        {"until": 160.0, "to": 15.0, "law": "cycloidal"},
        {"until": 220.0},
        {"until": 320.0, "to": 0.0, "law": "cycloidal"},
        {"until": 360.0},
    ),
}


def lift(theta: np.ndarray, stroke: float, first: float, last: float, back: float, end: float) -> np.ndarray:
    """Cycloidal rise from `first` to `last`, fall from `back` to `end`, degrees."""
    t = np.degrees(theta) % 360.0
    up, down = np.clip((t - first) / (last - first), 0.0, 1.0), np.clip((t - back) / (end - back), 0.0, 1.0)
    return stroke * ((up - np.sin(2 * pi * up) / (2 * pi)) - (down - np.sin(2 * pi * down) / (2 * pi)))


def centres(data: dict[str, Any], theta: np.ndarray) -> np.ndarray:
    """Roller's axis in the frame of the cam, (2, n), placed from the keys."""
    cam, follower = data["cam"], data["follower"]
    moves = [segment["until"] for segment in data["motion"]]
    s = lift(theta, data["motion"][1]["to"], *moves[:4])
    prime = cam["base_radius"] + 0.5 * data["roller"]["diameter"]
    if follower["kind"] == "translating":
        offset = follower.get("offset", 0.0)
        x, y = np.sqrt(prime**2 - offset**2) + s, np.full_like(s, offset)
    else:
        a, arm, way = cam["center_distance"], follower["arm"], -1.0 if follower.get("side") == "right" else 1.0
        angle = acos((a * a + arm * arm - prime * prime) / (2 * a * arm)) + np.radians(s)
        x, y = a - arm * np.cos(angle), way * arm * np.sin(angle)
    turned = theta * (1.0 if cam.get("direction", "ccw") == "ccw" else -1.0)
    # The cam has turned on by the cam angle: seen from it the machine has turned back.
    return np.stack([x * np.cos(turned) + y * np.sin(turned), y * np.cos(turned) - x * np.sin(turned)])


def drawn(seed: int) -> dict[str, Any]:
    """A design of a seed."""
    dice = random.Random(seed)
    base, radius, width = dice.uniform(30, 60), dice.uniform(8, 16), dice.uniform(10, 25)
    most = degrees(atan2(2.0 * radius, width))
    cam = {"kind": "disc", "base_radius": base, "width": width, "direction": dice.choice(["ccw", "cw"])}
    if dice.random() < 0.5:
        cam["bore"] = base * dice.uniform(0.3, 1.0)
    roller = {"shape": "cone", "diameter": 2 * radius, "length": width * dice.uniform(0.5, 1.0),
              "half_angle": dice.choice([-1, 1]) * dice.uniform(0.05, 0.6) * most}  # fmt: skip
    first, last = dice.uniform(10, 40), dice.uniform(130, 170)
    back, end = last + dice.uniform(10, 40), dice.uniform(310, 350)
    follower: dict[str, Any]
    if dice.random() < 0.5:
        follower, stroke = {"kind": "translating", "offset": dice.uniform(-0.2, 0.2) * base}, dice.uniform(5, 14)
    else:
        follower, stroke = {"kind": "swinging", "side": dice.choice(["left", "right"])}, dice.uniform(4, 12)
        cam["center_distance"] = base * dice.uniform(2.2, 3.0)
        follower["arm"] = cam["center_distance"] * dice.uniform(0.75, 0.95)
    moves = [(first, None), (last, stroke), (back, None), (end, 0.0), (360.0, None)]
    motion = tuple({"until": at} if to is None else {"until": at, "to": to, "law": "cycloidal"} for at, to in moves)
    return {"name": "cone", "cam": cam, "follower": follower, "roller": roller, "motion": motion,
            "output": {"tolerance": 0.01}}  # fmt: skip
