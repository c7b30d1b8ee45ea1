"""A small disc that rises, rests, falls and rests, with whatever follows it."""

from __future__ import annotations

ROLLER = '[roller]\nshape = "cylinder"\ndiameter = 22\nlength = 12'


def rising_disc(follower: str = 'kind = "translating"', roller: str = ROLLER, cam: str = "", lift: float = 20.0) -> str:
    """Its profile: lines of [follower] and [cam], the roller's table, the lift in mm."""
    return f"""
[cam]
kind = "disc"
base_radius = 34
width = 14
{cam}
[follower]
{follower}
{roller}
[[motion]]
until = 110
to = {lift}
law = "modified-sine"
[[motion]]
until = 150
[[motion]]
until = 260
to = 0
law = "3-4-5"
[[motion]]
until = 360
"""
