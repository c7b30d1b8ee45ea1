"""Bell cams with a groove in their inside: the shipped profile's tables with changed keys."""

from __future__ import annotations

import tomllib
from typing import Any

from tests.places import PROFILES

INNER, DEPTH, LENGTH, RADIUS = 56.0, 11.0, 9.5, 9.5
CONE = {"shape": "cone", "half_angle": 8.0}
CROWN = {"shape": "crowned", "crown_radius": 900.0}
ARM = {"kind": "swinging", "arm": 90.0, "start_angle": -8.0, "inertia": 0.05}
SWUNG = ({"until": 25.0}, {"until": 140.0, "to": 16.0, "law": "modified-sine"}, {"until": 185.0},
         {"until": 320.0, "to": 0.0, "law": "cycloidal"}, {"until": 360.0})  # fmt: skip


def bell(**changes: Any) -> dict[str, Any]:
    """The shipped profile's tables with changed keys of [cam], and of other tables by name."""
    data: dict[str, Any] = tomllib.loads((PROFILES / "bell_lifter.toml").read_text())
    data |= {"motion": tuple(data["motion"]), "output": {"tolerance": 0.01}}
    data["limits"] = {}
    del data["dynamics"]
    for name, value in changes.items():
        if name in ("roller", "operation"):
            data[name] = {k: v for k, v in (data[name] | value).items() if v is not None}
        elif isinstance(value, dict | tuple):
            data[name] = value
        else:
            data["cam"] = data["cam"] | {name: value}
    return {name: table for name, table in data.items() if table is not None}
