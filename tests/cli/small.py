"""A small profile that is sound and quick."""

from __future__ import annotations

GOOD = """
name = "small groove cam"
[cam]
kind = "cylindrical"
diameter = 80
length = 60
start = 20
groove_depth = 9
[follower]
kind = "translating"
mass = 1
[roller]
diameter = 12
length = 8
[[motion]]
until = 180
to = 15
law = "cycloidal"
[[motion]]
until = 360
to = 0
law = "modified-sine"
[operation]
speed = 300
[output]
tolerance = 0.05
formats = ["stl"]
"""
