"""Plates that slide, meshed directly, their chord error guaranteed: with a groove that has two ends, a pocket in the
upper face, or with an edge that a roller runs on."""

from __future__ import annotations

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.solid import TOUCHED, QuickPart, Solid, stated
from camgeom.solid.builder import Builder, cap
from camgeom.solid.prism import Loop, outline_grid, raised, wall
from camgeom.track.plate import FIRST, LAST, EdgeOutline


@immutable
class PocketPlate(QuickPart):
    """A plate 0 <= z <= top over a rim, with a pocket from its upper face down to `floor`."""

    name: str
    rim: Loop
    pocket: Loop
    floor: float
    top: float

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh within the tolerance. Raises DesignError where the outlines cross."""
        builder = Builder()
        rim = wall(builder, self.rim, 0.0, self.top, tolerance, False, free)
        pocket = wall(builder, self.pocket, self.floor, self.top, tolerance, True, free)
        cap(builder, [rim.high, pocket.high], [rim.above, pocket.above], "end", up=True)
        cap(builder, [pocket.low[::-1]], [pocket.below[::-1]], "floor", up=True)
        cap(builder, [rim.low], [rim.below], "end", up=False)
        error, free_error = stated([*rim.errors, *pocket.errors], free)
        return Solid(self.name, builder.mesh(), error, "direct", 0, free_error)


@immutable
class EdgePlate(QuickPart):
    """A plate 0 <= z <= top whose upper edge is a roller's envelope: that is its flank, all else its rim."""

    name: str
    outline: EdgeOutline
    top: float

    def solid(self, tolerance: float, free: float | None = None) -> Solid:
        """Mesh within the tolerance; its rim is plane. Raises DesignError where the outline crosses itself."""
        builder, grid = Builder(), outline_grid(self.outline, tolerance)
        names = named(0.5 * (grid.phi[:-1] + grid.phi[1:]))
        side = raised(builder, grid.points[:2, :-1, 0].T, names, 0.0, self.top, False, (TOUCHED, grid.chord_error))
        cap(builder, [side.high], [side.above], "end", up=True)
        cap(builder, [side.low], [side.below], "end", up=False)
        error, free_error = stated([*side.errors], free)
        return Solid(self.name, builder.mesh(), error, "direct", 0, free_error)


def named(phi: Floats) -> list[str]:
    """Faces of such a plate at parameters (n,) of its outline."""
    return [TOUCHED if FIRST < at < LAST else "rim" for at in phi.tolist()]
