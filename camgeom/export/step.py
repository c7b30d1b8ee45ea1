"""STEP files: exact boundary representations (AP242, or AP214 on request), and triangles as AP242 tessellated geometry.

The file is text, the same bytes for the same shape. Lengths are mm, angles rad. Faces keep their names. A solid comes
from `brep_solids` (prisms, bodies of revolution), from `step_groove` (cams with a closed groove or rib), or from any
stack of `brep_sheet.Band`s.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, final

from camgeom.errors import ExportError
from camgeom.export.brep import Assembly, Placed, Solid
from camgeom.export.brep_geometry import Frame
from camgeom.export.step_brep import placement, solid, triangles
from camgeom.export.step_text import Instances, real, references, string
from camgeom.maths.mesh import Mesh

Schema = Literal["AP242", "AP214"]
_SCHEMAS = {
    "AP242": "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
    "AP214": "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
}
_PROTOCOLS = {
    "AP242": ("managed model based 3d engineering", "ap242_managed_model_based_3d_engineering", 2014),
    "AP214": ("core data for automotive mechanical design processes", "automotive_design", 2000),
}


@final
@dataclass(frozen=True)
class StepOptions:
    """What a STEP file says about itself.

    schema       AP242 or AP214 (triangles need AP242)
    uncertainty  mm, the distance below which a reader may take points for one
    timestamp    ISO 8601; fixed by default so that the same shape gives the same bytes
    """

    schema: Schema = "AP242"
    uncertainty: float = 1e-7
    timestamp: str = "1970-01-01T00:00:00"
    author: str = ""
    organization: str = ""


def step_text(shape: Solid | Assembly | Mesh, name: str = "", options: StepOptions | None = None) -> str:
    """The STEP file of a solid, an assembly or a mesh, as text. Raises ExportError for a mesh in AP214."""
    options = options or StepOptions()
    out = Instances()
    title = name or (shape.name if not isinstance(shape, Mesh) else "mesh")
    _Product(out, options).write(shape, title)
    return _header(title, options) + out.data() + "ENDSEC;\nEND-ISO-10303-21;\n"


def write_step(
    path: str | Path, shape: Solid | Assembly | Mesh, name: str = "", options: StepOptions | None = None
) -> int:
    """Write a STEP file whole or not at all; returns its size in bytes. Raises ExportError where it cannot be written."""
    data = step_text(shape, name, options).encode("ascii")
    _replace(Path(path), data)
    return len(data)


def _replace(path: Path, data: bytes) -> None:
    """Write beside the target, then put in place, so that an earlier file is untouched by a failure."""
    beside = ""
    try:
        handle, beside = tempfile.mkstemp(prefix=path.name, dir=path.parent)
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        os.replace(beside, path)
    except OSError as error:
        if beside and os.path.exists(beside):
            os.unlink(beside)
        raise ExportError(f"{path}: {error.strerror or error}") from error


def _header(title: str, options: StepOptions) -> str:
    people = f"({string(options.author)}),({string(options.organization)})"
    return (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('cam geometry, mm'),'2;1');\n"
        f"FILE_NAME({string(title)},{string(options.timestamp)},{people},'camgeom','camgeom','');\n"
        f"FILE_SCHEMA(({string(_SCHEMAS[options.schema])}));\nENDSEC;\nDATA;\n"
    )


@final
class _Product:
    """Product structure round the shapes: one product for each solid, one for an assembly of them."""

    def __init__(self, out: Instances, options: StepOptions) -> None:
        self.out, self.options = out, options
        what, status, year = _PROTOCOLS[options.schema]
        application = out.add(f"APPLICATION_CONTEXT({string(what)})")
        out.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard',{string(status)},{year},#{application})")
        self.product_context = out.add(f"PRODUCT_CONTEXT('',#{application},'mechanical')")
        self.definition_context = out.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')")
        self.length = out.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = out.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        space = out.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        limit = f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({real(options.uncertainty)}),#{self.length},"
        near = out.add(limit + "'distance_accuracy_value','largest gap between edges and faces')")
        self.context = out.add(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{near}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT((#{self.length},#{angle},#{space}))REPRESENTATION_CONTEXT('','3D'))"
        )
        self.origin = placement(out, Frame())
        self.styled: list[int] = []

    def write(self, shape: Solid | Assembly | Mesh, title: str) -> None:
        """The whole DATA section."""
        if isinstance(shape, Assembly):
            self._assembly(shape, title)
        elif isinstance(shape, Mesh):
            self._mesh(shape, title)
        else:
            self._part(shape, title)
        if self.styled:
            listed = f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{references(self.styled)}"
            self.out.add(f"{listed},#{self.context})")

    def _definition(self, name: str, category: str = "part") -> int:
        """PRODUCT down to PRODUCT_DEFINITION; returns the definition."""
        out, label = self.out, string(name)
        product = out.add(f"PRODUCT({label},{label},'',(#{self.product_context}))")
        out.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('{category}',$,(#{product}))")
        version = out.add(f"PRODUCT_DEFINITION_FORMATION('','',#{product})")
        return out.add(f"PRODUCT_DEFINITION('design','',#{version},#{self.definition_context})")

    def _shaped(self, definition: int, representation: int) -> None:
        shape = self.out.add(f"PRODUCT_DEFINITION_SHAPE('','',#{definition})")
        self.out.add(f"SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})")

    def _part(self, body: Solid, title: str) -> tuple[int, int]:
        """A product of one solid; returns its definition and its representation."""
        out = self.out
        definition = self._definition(title)
        brep, styled = solid(out, body)
        self.styled += styled
        items = references((self.origin, brep))
        kind = "ADVANCED_BREP_SHAPE_REPRESENTATION"
        representation = out.add(f"{kind}({string(title)},{items},#{self.context})")
        self._shaped(definition, representation)
        if body.density is not None:
            self._density(definition, body.density)
        return definition, representation

    def _mesh(self, mesh: Mesh, title: str) -> None:
        if self.options.schema != "AP242":
            raise ExportError("triangles in STEP need schema AP242")
        body = triangles(self.out, title, mesh)
        kind = "TESSELLATED_SHAPE_REPRESENTATION"
        representation = self.out.add(f"{kind}({string(title)},(#{body}),#{self.context})")
        self._shaped(self._definition(title), representation)

    def _density(self, definition: int, density: float) -> None:
        """Density as a property of the part, kg/mm³."""
        out = self.out
        mass = out.once("(MASS_UNIT()NAMED_UNIT(*)SI_UNIT(.KILO.,.GRAM.))")
        parts = (
            out.once(f"DERIVED_UNIT_ELEMENT(#{mass},1.)"),
            out.once(f"DERIVED_UNIT_ELEMENT(#{self.length},-3.)"),
        )
        unit = out.once(f"DERIVED_UNIT({references(parts)})")
        item = out.add(f"MEASURE_REPRESENTATION_ITEM('density measure',POSITIVE_RATIO_MEASURE({real(density)}),#{unit})")
        value = out.add(f"REPRESENTATION('density',(#{item}),#{self.context})")
        what = out.add(f"PROPERTY_DEFINITION('material property','density',#{definition})")
        out.add(f"PROPERTY_DEFINITION_REPRESENTATION(#{what},#{value})")

    def _assembly(self, assembly: Assembly, title: str) -> None:
        out = self.out
        definition = self._definition(title)
        places = [placement(out, part.frame) for part in assembly.parts]
        items = references(dict.fromkeys((self.origin, *places)))
        whole = out.add(f"SHAPE_REPRESENTATION({string(title)},{items},#{self.context})")
        self._shaped(definition, whole)
        written: dict[int, tuple[int, int]] = {}
        for index, (part, place) in enumerate(zip(assembly.parts, places), 1):
            if id(part.solid) not in written:
                written[id(part.solid)] = self._part(part.solid, part.solid.name)
            self._occurrence(index, part, place, (definition, whole), written[id(part.solid)])

    def _occurrence(self, index: int, part: Placed, place: int, whole: tuple[int, int], child: tuple[int, int]) -> None:
        """One use of a part in the assembly, at its placement."""
        out = self.out
        name = string(part.name or part.solid.name)
        use = out.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{index}',{name},'',#{whole[0]},#{child[0]},$)")
        shape = out.add(f"PRODUCT_DEFINITION_SHAPE('placement','',#{use})")
        move = out.add(f"ITEM_DEFINED_TRANSFORMATION('','',#{self.origin},#{place})")
        relation = out.add(
            f"(REPRESENTATION_RELATIONSHIP('','',#{child[1]},#{whole[1]})"
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{move})SHAPE_REPRESENTATION_RELATIONSHIP())"
        )
        out.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape})")
