"""Passes of a tool in the groove of a plate that slides, or round its edge: X and Y alone, the plate clamped flat."""

from __future__ import annotations

from dataclasses import replace
from typing import final

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.machining.contour import ContourPath
from camgeom.machining.machine import Machine
from camgeom.machining.path import CentrePath, Positions, ToolPath
from camgeom.machining.plan import Machining
from camgeom.machining.spec import LEAST, CutterSpec
from camgeom.machining.tool import tool_of
from camgeom.machining.wall import SAME
from camgeom.maths import Floats
from camgeom.solid.mechanism import Mechanism
from camgeom.solid.pocket import EdgePlate, PocketPlate
from camgeom.track import TURN, Track
from camgeom.track.carriage import Carriage
from camgeom.track.plate import EdgeOutline, PocketOutline


@final
@immutable
class PlatePath:
    """A pass over a plate, told by the angle of its drive at which the roller stands where the tool cuts.

    along  the pass itself, over a parameter of its own; shares: (n,) of the stroke at parameters (n,)
    """

    along: ContourPath | CentrePath
    carriage: Carriage
    wall: PocketOutline | EdgeOutline | None

    @property
    def name(self) -> str:
        """What it makes."""
        return self.along.name

    @property
    def closed(self) -> bool:
        """True where it ends where it starts."""
        return self.along.closed

    @property
    def height(self) -> float:
        """Length of the tool in the cut, mm."""
        return self.along.height

    @property
    def room(self) -> float | None:
        """How far the tool may move off the flank, mm."""
        return self.along.room

    @property
    def below(self) -> bool:
        """A plate is cut from above."""
        return self.along.below

    @property
    def between(self) -> bool:
        """Whether it is in a groove."""
        return self.along.between

    def follows(self, track: Track) -> bool:
        """Whether it runs along the track of a roller."""
        return self.along.follows(track)

    def knots(self) -> Floats:
        """Parameters between which it is smooth."""
        return self.along.knots()

    def at(self, phi: Floats) -> Positions:
        """Positions at parameters (n,)."""
        found = self.along.at(phi)
        share = phi / TURN if self.wall is None else self.wall.share(found.phi)
        return replace(found, phi=self.carriage.out(share * self.carriage.stroke))


def plate_machining(title: str, spec: CutterSpec, mechanism: Mechanism, carriage: Carriage) -> Machining:
    """Once along the middle of the groove with a tool as wide, else once round its walls; round a plate with an edge.

    Raises DesignError where the tool does not go into the groove or is too short.
    """
    (track,), (part,) = mechanism.cutters, mechanism.parts
    if isinstance(part, EdgePlate):
        return _round_edge(title, spec, part, carriage)
    assert isinstance(part, PocketPlate)
    groove = part.pocket.outline
    assert isinstance(groove, PocketOutline)
    tool = tool_of(spec, None, groove.radius)
    reach, height = tool.radius + spec.allowance, part.top - part.floor
    room = groove.radius - reach
    if room < -SAME:
        raise DesignError(
            f"cutter.diameter: a tool of {2.0 * tool.radius:.6g} mm does not go into the groove; at most "
            f"{2.0 * (groove.radius - spec.allowance):.6g} mm"
        )
    _refuse_short(spec, height)
    path: ToolPath
    if room <= LEAST:
        path = PlatePath(CentrePath(track.straightened().evenly), carriage, None)
    else:
        round_it = ContourPath("groove", groove, -1.0, reach, part.floor, height, room, width=2.0 * groove.radius)
        round_it.refuse_gouge()
        path = PlatePath(round_it, carriage, groove)
    return Machining(title, spec, (path,), (tool,), Machine("C", "plain", False, slides=True), 0.0)


def _round_edge(title: str, spec: CutterSpec, part: EdgePlate, carriage: Carriage) -> Machining:
    """Once round the whole plate."""
    tool, height = tool_of(spec, None, part.outline.radius), part.top + spec.overrun
    _refuse_short(spec, height)
    path = ContourPath("profile", part.outline, 1.0, tool.radius + spec.allowance, -spec.overrun, height)
    path.refuse_gouge()
    round_it = PlatePath(path.with_lead(spec.lead, tool.radius), carriage, part.outline)
    return Machining(title, spec, (round_it,), (tool,), Machine("C", "plain", False, slides=True), 0.0)


def _refuse_short(spec: CutterSpec, height: float) -> None:
    if spec.length is not None and spec.length < height - SAME:
        raise DesignError(f"cutter.length {spec.length:g} mm is too short: the cut is {height:.6g} mm deep")
