"""Cam types, one final class a file, found by file name: kind "constant-width" is `constant_width.Cam`, and the
starter profile of that kind is starters/constant-width.toml.

Every `Cam` is a `Section` whose fields are the keys of the profile's [cam] table, with these members:

    FOLLOWERS: ClassVar[tuple[str, ...]]      follower kinds it accepts, the first one the usual
    MOTION_SPAN: ClassVar[float]              optional: 180.0 where the profile states half a turn of motion and the
                                              other half follows, s(theta + pi) = lift - s(theta)
    problems(setup) -> list[Problem]          what cannot be built, with key, value and allowed range
    parts(setup) -> tuple[Part, ...]          the bodies (see camgeom.solid.drum)
    tracks(setup) -> tuple[Track, ...]        the roller tracks (empty for flat and knife followers)

A cam that drives a turret also has

    inside(x) -> array                        which contact points (3, ...) lie on the cam's own material
    gaps(setup)                               free distances of the turret: (name, mm, advice) each
    passages(setup) -> tuple[Track, ...]      every roller as long as any part of it may be beside the cam
    SHARED_DRIVE: ClassVar[bool]              optional: True where rollers take turns, so that the best placed one of
                                              each direction is judged, and tracks are the walls that they touch
    rollers(setup), dials(setup)              optional, for pictures: all rollers one by one, their discs

A planar cam also has

    touches(setup) -> tuple[Touch, ...]       what touches it: one contact, or two that drive the follower both ways
    outlines(setup) -> dict[str, Outline]     its closed curves by name
    span_between(setup) -> float              optional: the constant width between parallel faces, mm
"""

from __future__ import annotations

from functools import lru_cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any


@lru_cache(maxsize=1)
def kinds() -> tuple[str, ...]:
    """Names of the cam kinds, found without importing any of them."""
    return tuple(sorted(m.name.replace("_", "-") for m in iter_modules(__path__) if not m.name.startswith("_")))


def cam_class(kind: str) -> Any:
    """The `Cam` section of a kind; KeyError for an unknown kind."""
    if kind not in kinds():
        raise KeyError(kind)
    return import_module(f"{__name__}.{kind.replace('-', '_')}").Cam


def starter(kind: str) -> str:
    """The commented starter profile (TOML) of a kind, which runs as it is; KeyError for an unknown kind."""
    if kind not in kinds():
        raise KeyError(kind)
    return (Path(__file__).parent / "starters" / f"{kind}.toml").read_text(encoding="utf-8")
