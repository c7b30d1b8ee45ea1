"""From the parts of a model to the bodies of a STEP file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from camgeom.export.step.brep import Assembly, Facets, Placed, Solid
from camgeom.export.step.groove import grooved_solid, ribbed_solid
from camgeom.export.step.planar import face_groove_solid, planar_solid
from camgeom.export.step.solids import TOLERANCE
from camgeom.prism import FaceGroove, Prism
from camgeom.solid import GroovedCylinder, RibbedCylinder

if TYPE_CHECKING:
    from camgeom.model import Model

EXACT: dict[type, Callable[[Any, float], Solid]] = {
    GroovedCylinder: grooved_solid,
    RibbedCylinder: ribbed_solid,
    Prism: planar_solid,
    FaceGroove: face_groove_solid,
}
"""How a kind of part becomes a boundary representation: (part, tolerance mm) -> Solid."""


def model_bodies(model: Model, tolerance: float = TOLERANCE) -> Solid | Facets | Assembly:
    """A model's bodies: exact where the kind of part has a boundary representation, else the triangles of its mesh.

    Several bodies become an assembly. Raises DesignError where the cam is undercut.
    """
    model.refuse_folded()
    density = model.profile.material.cam.density
    bodies: list[Solid | Facets] = []
    for index, part in enumerate(model.parts):
        build = EXACT.get(type(part))
        if build is None:
            bodies.append(Facets(part.name, model.solids[index].mesh))
        else:
            bodies.append(replace(build(part, tolerance), density=density * 1e-9))
    if len(bodies) == 1:
        return bodies[0]
    return Assembly(model.profile.name, tuple(Placed(body) for body in bodies))
