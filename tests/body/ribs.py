"""A drum with a rib between two rollers."""

from __future__ import annotations

from typing import Any


def ribbed(thickness: float) -> dict[str, Any]:
    """Its profile as plain data; thickness of the rib, mm."""
    law = "modified-sine"
    return {
        "name": "rib",
        "cam": {"kind": "cylindrical", "form": "rib", "diameter": 120.0, "length": 90.0, "start": 30.0,
                "groove_depth": 12.0, "rib_thickness": thickness, "bore": 30.0},
        "follower": {"kind": "translating", "mass": 6.0},
        "roller": {"diameter": 16.0, "length": 10.0},
        "operation": {"speed": 300.0},
        "motion": ({"until": 60.0}, {"until": 180.0, "to": 30.0, "law": law}, {"until": 240.0},
                   {"until": 360.0, "to": 0.0, "law": law}),
        "output": {"formats": ("stl",)},
    }  # fmt: skip
