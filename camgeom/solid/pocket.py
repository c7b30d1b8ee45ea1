"""A plate with a groove that has two ends: a pocket in its upper face, meshed directly, its chord error guaranteed."""

from __future__ import annotations

from camgeom.immutable import immutable
from camgeom.solid import QuickPart, Solid, stated
from camgeom.solid.builder import Builder, cap
from camgeom.solid.prism import Loop, wall


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
        cap(builder, [rim.high, pocket.high], [rim.plane, pocket.plane], "end", up=True)
        cap(builder, [pocket.low[::-1]], [pocket.foot[::-1]], "floor", up=True)
        cap(builder, [rim.low], [rim.plane], "end", up=False)
        error, free_error = stated([*rim.errors, *pocket.errors], free)
        return Solid(self.name, builder.mesh(), error, "direct", 0, free_error)
