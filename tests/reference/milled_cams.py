"""A drum and a globoid with a [cutter], and the files written of them."""

from __future__ import annotations

import json
from pathlib import Path

from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import parse

DRUM = """
[cam]
kind = "cylindrical"
diameter = 100
length = 80
start = 25
groove_depth = 11
[follower]
kind = "translating"
[roller]
diameter = 20
length = 10
[[motion]]
until = 90
[[motion]]
until = 200
to = 30
law = "cycloidal"
[[motion]]
until = 240
[[motion]]
until = 360
to = 0
law = "cycloidal"
"""
GLOBOID = """
[cam]
kind = "globoidal"
form = "rib"
center_distance = 180
width = 90
globoid_radius = 80
[follower]
kind = "turret"
stops = 8
pitch_radius = 90
[roller]
diameter = 30
length = 24
[[motion]]
until = 120
[[motion]]
until = 240
to = 45
law = "cycloidal"
[[motion]]
until = 360
"""


def model(text: str, **cutter: object) -> Model:
    lines = [f"{key} = {json.dumps(value)}" for key, value in cutter.items()]
    return Model(parse(text + "\n[cutter]\n" + "\n".join(lines) + "\n"))


def written(made: Model, folder: Path, name: str) -> Path:
    path = folder / f"cam.{name}"
    assert write(made, path) == path.stat().st_size
    return path
