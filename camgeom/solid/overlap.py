"""Bodies that cross themselves: a closed mesh may hold some regions twice or turned inside out, and is then no body.

Grooves or ribs that overlap, or passes of one groove, make such meshes; each triangle is right by itself. The outlines
of a prism, or a coarse mesh of any other body, tell it in a part of the time; where they do, the body's own mesh has
the last word.
"""

from __future__ import annotations

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.maths.crossing import crossings, outline, outlines_cross
from camgeom.solid import Part, Solid

COARSE = 1e-3
"""share of a body's size: chord error of the mesh on which crossings are looked for first"""
MARGIN = 2.0
"""chord errors by which two surfaces of one mesh may run into each other without crossing"""


def refuse_overlap(part: Part, solid: Solid) -> None:
    """Raise DesignError where a finished body crosses itself by more than its chord errors."""
    if not solid.mesh.watertight:
        return
    edges = outline(solid.mesh)
    coarse = COARSE * float(np.ptp(solid.mesh.vertices, axis=0).max())
    if edges is not None:
        if not outlines_cross(solid.mesh, edges, MARGIN * solid.largest_error):
            return
    elif coarse > 2.0 * solid.largest_error:
        try:
            rough = part.rough(coarse)
        except (DesignError, NotConverged):
            rough = solid
        if not len(crossings(rough.mesh, MARGIN * rough.largest_error)):
            return
    pairs = crossings(solid.mesh, MARGIN * solid.largest_error)
    if not len(pairs):
        return
    x, y, z = solid.mesh.vertices[solid.mesh.faces[pairs[0]]].mean(axis=(0, 1))
    radius, azimuth = np.hypot(x, y), np.degrees(np.arctan2(y, x)) % 360.0
    raise DesignError(
        f"the surface of {solid.name!r} crosses itself ({len(pairs)} pairs of faces, as at radius {radius:.4g} mm, "
        f"azimuth {azimuth:.4g} deg, z = {z:.4g} mm): grooves or ribs overlap, so it bounds no body; see wall and "
        "rib-thickness"
    )
