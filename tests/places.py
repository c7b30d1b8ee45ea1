"""Where the checkout's own files stand."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CAMGEOM = ROOT / "camgeom"
PROFILES = ROOT / "profiles"
