"""From the parts of a model to the bodies of a STEP file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from camgeom.errors import CamgeomError, DesignError
from camgeom.export.step.brep import Assembly, Facets, Placed, Solid
from camgeom.export.step.cut import cut_solid
from camgeom.export.step.groove import grooved_solid, ribbed_solid
from camgeom.export.step.planar import face_groove_solid, planar_solid
from camgeom.export.step.solids import TOLERANCE
from camgeom.solid.cut import CutBlank, IndexingCut
from camgeom.solid.drum import GroovedCylinder, RibbedCylinder
from camgeom.solid.prism import FaceGroove, Prism

if TYPE_CHECKING:
    from camgeom.model import Model

EXACT: dict[type, Callable[[Any, float], Solid]] = {
    GroovedCylinder: grooved_solid,
    RibbedCylinder: ribbed_solid,
    Prism: planar_solid,
    FaceGroove: face_groove_solid,
    CutBlank: cut_solid,
    IndexingCut: cut_solid,
}
"""How a kind of part becomes a boundary representation: (part, tolerance mm) -> Solid."""


def model_bodies(model: Model, tolerance: float = TOLERANCE) -> Solid | Facets | Assembly:
    """A model's bodies: exact where the kind of part has a boundary representation, else the triangles of its mesh.

    Several bodies become an assembly. Raises DesignError where the cam is undercut and no body is made of it.
    """
    try:
        model.refuse_folded()
    except DesignError as error:
        bodies: list[Solid | Facets] = [_facets(model, index, error) for index in range(len(model.solids))]
    else:
        bodies = [_body(model, index, tolerance) for index in range(len(model.parts))]
    if len(bodies) == 1:
        return bodies[0]
    return Assembly(model.profile.name, tuple(Placed(body) for body in bodies))


def _body(model: Model, index: int, tolerance: float) -> Solid | Facets:
    part = model.parts[index]
    build = EXACT.get(type(part))
    if build is None:
        return _facets(model, index, f"a {type(part).__name__} has no exact faces")
    try:
        return replace(build(part, tolerance), density=model.profile.material.cam.density * 1e-9)
    except CamgeomError as error:
        return _facets(model, index, error)


def _facets(model: Model, index: int, reason: object) -> Facets:
    solid = model.solids[index]
    return Facets(solid.name, solid.mesh, deviation=solid.chord_error, reason=str(reason))


def notes(shape: Solid | Facets | Assembly) -> list[dict[str, Any]]:
    """What a file holds, body by body, as plain data: exact faces or triangles, and their deviation in mm."""
    placed = [part.body for part in shape.parts] if isinstance(shape, Assembly) else [shape]
    found = []
    for body in dict.fromkeys(placed):
        exact = isinstance(body, Solid)
        note: dict[str, Any] = {
            "name": body.name,
            "faces": "exact" if exact else "triangles",
            "deviation_mm": body.deviation,
            "count": placed.count(body),
        }
        if isinstance(body, Facets):
            note["reason"] = body.reason
        found.append(note)
    return found
