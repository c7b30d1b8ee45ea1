"""Planar cams as boundary representations: prisms over exact outlines, and plates with a groove in one face."""

from __future__ import annotations

import numpy as np

from camgeom.errors import DesignError
from camgeom.export.step.brep import Solid
from camgeom.export.step.groove import bore_holes
from camgeom.export.step.solids import TOLERANCE, Outline, flat_end, prism_solid, wall
from camgeom.solid.blank import Bore
from camgeom.solid.prism import FaceGroove, Loop, Prism


def planar_solid(body: Prism, tolerance: float = TOLERANCE) -> Solid:
    """The prism as a solid whose fitted faces are within `tolerance` mm of the exact ones.

    Raises DesignError where the outline turns back on itself or the bore breaks through it.
    """
    loops = [closed(loop, body.name) for loop in (body.outer, *body.holes)]
    keep_bore_inside(loops[0], body.bore, body.name)
    holes = [*loops[1:], *bore_holes(body.bore)]
    return prism_solid(loops[0], body.z0, body.z1, holes, body.name, tolerance=tolerance)


def face_groove_solid(body: FaceGroove, tolerance: float = TOLERANCE) -> Solid:
    """The plate with a groove in its upper face; raises as `planar_solid`."""
    rim, inner, outer = (closed(loop, body.name) for loop in (body.rim, body.inner, body.outer))
    keep_bore_inside(inner, body.bore, body.name)
    outside = wall(rim, body.z0, body.z1, 1.0, tolerance)
    far, near = (wall(o, body.floor, body.z1, side, tolerance) for o, side in ((outer, -1.0), (inner, 1.0)))
    bore = [wall(hole, body.z0, body.z1, -1.0, tolerance) for hole in bore_holes(body.bore)]
    flats = (
        flat_end("end", body.z0, False, [outside.first, *(hole.first for hole in bore)]),
        flat_end("end", body.z1, True, [outside.last, far.last]),
        flat_end("end", body.z1, True, [near.last, *(hole.last for hole in bore)]),
        flat_end("floor", body.floor, True, [far.first, near.first]),
    )
    sheets = (outside, far, near, *bore)
    faces = (*(face for found in sheets for face in found.faces), *flats)
    return Solid(body.name, faces, deviation=max(found.deviation for found in sheets))


def closed(loop: Loop, body: str, samples: int = 721) -> Outline:
    """A loop's outline. Raises DesignError where it has a cusp or turns back (its speed vanishes or changes sign)."""
    outline = loop.outline
    knots = outline.knots()
    phi = np.linspace(knots[0], knots[-1], samples)
    speed = outline.curve(phi).speed
    if float((speed * np.sign(speed[0])).min()) <= 0.0:
        worst = int(np.argmin(speed * np.sign(speed[0])))
        raise DesignError(
            f"{body!r}: the outline {loop.name!r} turns back on itself at cam angle {np.degrees(phi[worst]):.6g} deg, "
            "so it bounds no body; use a smaller roller, a larger cam or a gentler motion"
        )
    return Outline(lambda t: np.ascontiguousarray(outline.curve(t).points.T), tuple(knots.tolist()), loop.name)


def keep_bore_inside(outline: Outline, bore: Bore | None, body: str, samples: int = 721) -> None:
    """Raise DesignError where a bore about the axis reaches the outline."""
    if bore is None:
        return
    nearest = float(np.hypot(*outline.point(np.linspace(outline.knots[0], outline.knots[-1], samples)).T).min())
    if nearest <= bore.reach:
        raise DesignError(
            f"{body!r}: the bore reaches {bore.reach:.6g} mm from the axis, the outline is {nearest:.6g} mm from it"
        )
