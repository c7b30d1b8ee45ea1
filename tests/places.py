"""Where the checkout's own files stand."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CAMGEOM = ROOT / "camgeom"
PROFILES = ROOT / "profiles"
PLATE = (
    "plate_length", "plate_width", "plate_thickness", "window_width", "face_height", "window_radius", "guide_bore",
    "guide_spacing",
)  # fmt: skip
"""keys of `[follower]` that make a frame a part"""
BARE = {f"follower__{key}": None for key in PLATE}
"""for `Model.with_`: the frame of constant_width_press as no part"""
