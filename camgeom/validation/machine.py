"""Machines of the sources: profiles of the printed data beside this file, and models with some of it changed."""

from __future__ import annotations

from functools import cache
from importlib.resources import files
from typing import Any

from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load, replaced


@cache
def _data(name: str) -> dict[str, Any]:
    file = f"{name}.toml"
    return load((files("camgeom.validation") / file).read_text(encoding="utf-8"), file)[0]


@cache
def machine(name: str, *changes: tuple[str, float | str]) -> Model:
    """The model of a source's machine, with the values of some keys changed: ("roller.diameter", 26.0)."""
    data = _data(name)
    for key, value in changes:
        path = tuple(int(part) if part.isdigit() else part for part in key.split("."))
        data = replaced(data, path, value, key)
    return Model(from_data(data))
