"""Cross-sections of a planar cam's disc: a rectangle from the bore to the outline, graded to the flank."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.body.groove import bore_radius, left_out
from camgeom.body.section import graded
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid.prism import Prism
from camgeom.track import TURN

Index = npt.NDArray[np.int64]
SAMPLES = 2881
STEPS = 40
NEAR = 1e-12
LAYER = 0.25
"""share of the distance from outline to bore that the graded layer takes"""


@final
@immutable
class PlateSection:
    """The section of a disc; cells across its width, across the layer and from there to the bore."""

    body: Prism
    cells: tuple[int, int, int] = (4, 3, 3)

    @cached_property
    def rows(self) -> Floats:
        """Shares of the width."""
        return np.linspace(0.0, 1.0, 2 * self.cells[0] + 1)

    @property
    def notes(self) -> tuple[str, ...]:
        """Keyway and phase marks are left out."""
        return (*left_out(self.body.bore), *(("the phase marks are left out",) if self.body.holes else ()))

    @cached_property
    def _sampled(self) -> tuple[Floats, Floats]:
        """Azimuths in ascending order over more than a turn, and the outline's cam angles there."""
        outline = self.body.outer.outline
        knots = outline.knots()
        phi = np.linspace(knots[0], knots[0] + TURN, SAMPLES)
        x, y = outline.curve(phi).points
        azimuth = np.unwrap(np.arctan2(y, x))
        way = np.sign(azimuth[-1] - azimuth[0])
        if np.any(way * np.diff(azimuth) <= 0.0) or abs(abs(azimuth[-1] - azimuth[0]) - TURN) > 1e-6:
            raise DesignError("a ray from the axis meets the outline more than once: the volume is not meshed")
        order = slice(None) if way > 0.0 else slice(None, None, -1)
        return azimuth[order], phi[order]

    def radius(self, psi: Floats) -> Floats:
        """Exact radius of the outline at azimuths (n,), mm."""
        azimuth, phi = self._sampled
        outline = self.body.outer.outline
        low = azimuth[0]
        at = np.interp((psi - low) % TURN + low, azimuth, phi)
        slope = np.interp((psi - low) % TURN + low, azimuth, np.gradient(phi, azimuth))
        found = outline.curve(at).points
        for _ in range(STEPS):
            gap = (np.arctan2(found[1], found[0]) - psi + np.pi) % TURN - np.pi
            if float(np.abs(gap).max()) < NEAR:
                break
            at = at - gap * slope
            found = outline.curve(at % TURN).points
        return np.asarray(np.hypot(found[0], found[1]))

    def blocks(self, psi: Floats) -> list[tuple[Floats, Floats]]:
        """z and r (n, i, j) of layer and core; i runs inward in the layer and along z in the core, j the other way."""
        body, (_, deep, core) = self.body, self.cells
        inner, outer = bore_radius(body.bore), self.radius(psi)
        z = body.z0 + (body.z1 - body.z0) * self.rows
        foot = outer - LAYER * (outer - inner)
        down = outer[:, None] + graded(deep, 1.6) * (foot - outer)[:, None]
        up = inner + np.linspace(0.0, 1.0, 2 * core + 1) * (foot - inner)[:, None]
        layer = np.broadcast_to(z, (len(psi), down.shape[1], len(z))), np.repeat(down[:, :, None], len(z), axis=2)
        inside = np.repeat(np.broadcast_to(z, (len(psi), len(z)))[:, :, None], up.shape[1], axis=2)
        return [layer, (inside, np.repeat(up[:, None], len(z), axis=1))]

    def sets(self, grids: Sequence[Index]) -> dict[str, list[Index]]:
        """Nodes on the faces of the disc."""
        layer, core = grids
        return {
            "bore": [core[:, 0]],
            "flank": [layer[0]],
            "end_lower": [layer[:, 0], core[0]],
            "end_upper": [layer[:, -1], core[-1]],
        }
