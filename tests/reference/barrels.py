"""The shipped barrel indexer with another width and roller."""

from __future__ import annotations

from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from tests.places import PROFILES


def barrel(width: float, shape: str) -> Model:
    """The barrel of a width, mm, with cylinders, or with balls for shape "sphere"; without its load."""
    data, _, _ = load((PROFILES / "barrel_indexer.toml").read_text(encoding="utf-8"), "")
    data["cam"] = data["cam"] | {"width": width}
    if shape == "sphere":
        data["roller"] = {"shape": "sphere", "diameter": 30.0}
    return Model(from_data({k: v for k, v in data.items() if k != "operation"}, ""))
