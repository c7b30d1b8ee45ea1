"""The STEP file round the shapes: header, units, products, assemblies, density, colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, final

from camgeom.errors import ExportError
from camgeom.export.step.brep import Assembly, Facets, Placed, Solid
from camgeom.export.step.entities import placement, solid, triangles
from camgeom.export.step.geometry import Frame
from camgeom.export.step.text import Instances, real, references, string

Schema = Literal["AP242", "AP214"]
_SCHEMAS: dict[Schema, str] = {
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


def schema_of(name: str) -> Schema:
    """The schema of that name. Raises ExportError with those there are."""
    for schema in _SCHEMAS:
        if schema == name.upper():
            return schema
    raise ExportError(f"no STEP schema {name!r}; there are {', '.join(_SCHEMAS)}")


def step_text(shape: Solid | Facets | Assembly, options: StepOptions | None = None) -> str:
    """The STEP file of a solid, of a body of triangles or of an assembly, as ASCII text.

    Raises ExportError for triangles in AP214, which has none.
    """
    options = options or StepOptions()
    out = Instances()
    _Product(out, options).write(shape)
    return _header(shape.name, options) + out.data() + "ENDSEC;\nEND-ISO-10303-21;\n"


def _header(title: str, options: StepOptions) -> str:
    people = f"({string(options.author)}),({string(options.organization)})"
    return (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('cam geometry, mm'),'2;1');\n"
        f"FILE_NAME({string(title)},{string(options.timestamp)},{people},'camgeom','camgeom','');\n"
        f"FILE_SCHEMA(({string(_SCHEMAS[options.schema])}));\nENDSEC;\nDATA;\n"
    )


def _about(body: Solid | Facets) -> str:
    """What the file says of a body's accuracy."""
    if isinstance(body, Solid):
        return f"exact faces, fitted ones within {body.deviation:.2g} mm" if body.deviation else "exact faces"
    within = f" within {body.deviation:.3g} mm" if body.deviation else ""
    return f"triangles{within}" + (f": {body.reason}" if body.reason else "")


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

    def write(self, shape: Solid | Facets | Assembly) -> None:
        """The whole DATA section."""
        if isinstance(shape, Assembly):
            self._assembly(shape)
        else:
            self._part(shape)
        if self.styled:
            listed = f"MECHANICAL_DESIGN_GEOMETRIC_PRESENTATION_REPRESENTATION('',{references(self.styled)}"
            self.out.add(f"{listed},#{self.context})")

    def _definition(self, name: str, about: str = "") -> int:
        """PRODUCT down to PRODUCT_DEFINITION; returns the definition."""
        out, label = self.out, string(name)
        product = out.add(f"PRODUCT({label},{label},{string(about)},(#{self.product_context}))")
        out.add(f"PRODUCT_RELATED_PRODUCT_CATEGORY('part',$,(#{product}))")
        version = out.add(f"PRODUCT_DEFINITION_FORMATION('','',#{product})")
        return out.add(f"PRODUCT_DEFINITION('design','',#{version},#{self.definition_context})")

    def _shaped(self, definition: int, representation: int) -> None:
        shape = self.out.add(f"PRODUCT_DEFINITION_SHAPE('','',#{definition})")
        self.out.add(f"SHAPE_DEFINITION_REPRESENTATION(#{shape},#{representation})")

    def _part(self, body: Solid | Facets) -> tuple[int, int]:
        """A product of one body; returns its definition and its representation."""
        definition = self._definition(body.name, _about(body))
        representation = self._facets(body) if isinstance(body, Facets) else self._brep(body)
        self._shaped(definition, representation)
        if isinstance(body, Solid) and body.density is not None:
            self._density(definition, body.density)
        return definition, representation

    def _brep(self, body: Solid) -> int:
        brep, styled = solid(self.out, body)
        self.styled += styled
        items = references((self.origin, brep))
        return self.out.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION({string(body.name)},{items},#{self.context})")

    def _facets(self, body: Facets) -> int:
        if self.options.schema != "AP242":
            why = f" ({body.reason})" if body.reason else ""
            raise ExportError(f"{body.name!r} is known as triangles only{why}, which need schema AP242")
        number, styled = triangles(self.out, body)
        self.styled += styled
        items = references((self.origin, number))
        return self.out.add(f"TESSELLATED_SHAPE_REPRESENTATION({string(body.name)},{items},#{self.context})")

    def _density(self, definition: int, density: float) -> None:
        """Density as a property of the part, kg/mm³."""
        out = self.out
        mass = out.once("(MASS_UNIT()NAMED_UNIT(*)SI_UNIT(.KILO.,.GRAM.))")
        parts = (
            out.once(f"DERIVED_UNIT_ELEMENT(#{mass},1.)"),
            out.once(f"DERIVED_UNIT_ELEMENT(#{self.length},-3.)"),
        )
        unit = out.once(f"DERIVED_UNIT({references(parts)})")
        measure = f"POSITIVE_RATIO_MEASURE({real(density)})"
        item = out.add(f"MEASURE_REPRESENTATION_ITEM('density measure',{measure},#{unit})")
        value = out.add(f"REPRESENTATION('density',(#{item}),#{self.context})")
        what = out.add(f"PROPERTY_DEFINITION('material property','density',#{definition})")
        out.add(f"PROPERTY_DEFINITION_REPRESENTATION(#{what},#{value})")

    def _assembly(self, assembly: Assembly) -> None:
        out = self.out
        definition = self._definition(assembly.name)
        places = [placement(out, part.frame) for part in assembly.parts]
        items = references(dict.fromkeys((self.origin, *places)))
        whole = out.add(f"SHAPE_REPRESENTATION({string(assembly.name)},{items},#{self.context})")
        self._shaped(definition, whole)
        written: dict[int, tuple[int, int]] = {}
        for index, (part, place) in enumerate(zip(assembly.parts, places), 1):
            if id(part.body) not in written:
                written[id(part.body)] = self._part(part.body)
            self._occurrence(index, part, place, (definition, whole), written[id(part.body)])

    def _occurrence(self, index: int, part: Placed, place: int, whole: tuple[int, int], child: tuple[int, int]) -> None:
        """One use of a part in the assembly, at its placement."""
        out = self.out
        name = string(part.name or part.body.name)
        use = out.add(f"NEXT_ASSEMBLY_USAGE_OCCURRENCE('{index}',{name},'',#{whole[0]},#{child[0]},$)")
        shape = out.add(f"PRODUCT_DEFINITION_SHAPE('placement','',#{use})")
        move = out.add(f"ITEM_DEFINED_TRANSFORMATION('','',#{self.origin},#{place})")
        relation = out.add(
            f"(REPRESENTATION_RELATIONSHIP('','',#{child[1]},#{whole[1]})"
            f"REPRESENTATION_RELATIONSHIP_WITH_TRANSFORMATION(#{move})SHAPE_REPRESENTATION_RELATIONSHIP())"
        )
        out.add(f"CONTEXT_DEPENDENT_SHAPE_REPRESENTATION(#{relation},#{shape})")
