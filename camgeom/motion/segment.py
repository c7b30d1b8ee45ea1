"""A segment of a motion program: what the user says of it, and where it then lies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple, final

from camgeom.immutable import immutable
from camgeom.motion.law import ParamValue, freeze


@final
@immutable(eq=True)
class Segment:
    """One segment of a program: where it ends (cam angle, rad) and the position it reaches there (mm or rad).

    Without `to` it dwells. `params` are the law's parameters, a mapping or pairs. `velocity`, `acceleration` and `jerk`
    (lift per rad, rad², rad³) fix the state at its end, where a joining law such as "polynomial" takes them over.
    """

    until: float
    to: float | None = None
    law: str | None = None
    params: Mapping[str, ParamValue] | tuple[tuple[str, ParamValue], ...] = ()
    velocity: float | None = None
    acceleration: float | None = None
    jerk: float | None = None

    def __post_init__(self) -> None:
        pairs = self.params.items() if isinstance(self.params, Mapping) else self.params
        object.__setattr__(self, "params", tuple((str(key), freeze(value)) for key, value in pairs))

    @property
    def dwells(self) -> bool:
        """Whether the follower stands still."""
        return self.to is None


class Span(NamedTuple):
    """A segment in its place: cam angles (rad) and positions (mm or rad) at both ends, and what moves it there."""

    start: float
    end: float
    before: float
    after: float
    law: str
    """the law's name; "dwell" where the follower stands"""
