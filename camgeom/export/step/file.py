"""The STEP file round the shapes: header, units, products, assemblies, density, colours."""

from __future__ import annotations

from typing import Literal, final

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import Colour
from camgeom.export.step.brep import Assembly, Brep, Edge, Face, FacetBody, Loop, Placed, Vertex
from camgeom.export.step.geometry import (
    Circle,
    Cone,
    Curve,
    Frame,
    Line,
    Plane,
    SplineCurve,
    SplineSurface,
    Surface,
    Torus,
)
from camgeom.export.step.text import Instances, integers, real, reals, references, string, triples
from camgeom.maths.splines import Basis

Schema = Literal["AP242", "AP214"]
_SCHEMAS: dict[Schema, tuple[str, str, str, int]] = {
    "AP242": (
        "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF { 1 0 10303 442 1 1 4 }",
        "managed model based 3d engineering", "ap242_managed_model_based_3d_engineering", 2014,
    ),
    "AP214": (
        "AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }",
        "core data for automotive mechanical design processes", "automotive_design", 2000,
    ),
}  # fmt: skip
"""What a file says of itself: its schema, and the application protocol with its status and year."""
UNCERTAINTY = 1e-7
"""mm, the distance below which a reader may take points for one"""
Lines = dict[Edge, list[int]]
"""PCURVEs of edges, in the faces they border"""
TIMESTAMP = "1970-01-01T00:00:00"
"""The same for every file, so that the same shape gives the same bytes."""


def step_text(shape: Brep | FacetBody | Assembly, schema: Schema = "AP242") -> str:
    """The STEP file of a solid, of a body of triangles or of an assembly, as ASCII text.

    Raises ExportError for a schema that is none, and for triangles in AP214, which has none.
    """
    if schema not in _SCHEMAS:
        raise ExportError(f"no STEP schema {schema!r}; there are {', '.join(_SCHEMAS)}")
    out = Instances()
    _Product(out, schema).write(shape)
    return _header(shape.name, schema) + out.data() + "ENDSEC;\nEND-ISO-10303-21;\n"


def _header(title: str, schema: Schema) -> str:
    return (
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('cam geometry, mm'),'2;1');\n"
        f"FILE_NAME({string(title)},'{TIMESTAMP}',(''),(''),'camgeom','camgeom','');\n"
        f"FILE_SCHEMA(({string(_SCHEMAS[schema][0])}));\nENDSEC;\nDATA;\n"
    )


def _about(body: Brep | FacetBody) -> str:
    """What the file says of a body's accuracy."""
    if isinstance(body, Brep):
        return f"exact faces, fitted ones within {body.deviation:.2g} mm" if body.deviation else "exact faces"
    within = f" within {body.deviation:.3g} mm" if body.deviation else ""
    return f"triangles{within}" + (f": {body.reason}" if body.reason else "")


@final
class _Product:
    """Product structure round the shapes: one product for each solid, one for an assembly of them."""

    def __init__(self, out: Instances, schema: Schema) -> None:
        self.out, self.schema = out, schema
        _, what, status, year = _SCHEMAS[schema]
        application = out.add(f"APPLICATION_CONTEXT({string(what)})")
        out.add(f"APPLICATION_PROTOCOL_DEFINITION('international standard',{string(status)},{year},#{application})")
        self.product_context = out.add(f"PRODUCT_CONTEXT('',#{application},'mechanical')")
        self.definition_context = out.add(f"PRODUCT_DEFINITION_CONTEXT('part definition',#{application},'design')")
        self.length = out.add("(LENGTH_UNIT()NAMED_UNIT(*)SI_UNIT(.MILLI.,.METRE.))")
        angle = out.add("(NAMED_UNIT(*)PLANE_ANGLE_UNIT()SI_UNIT($,.RADIAN.))")
        space = out.add("(NAMED_UNIT(*)SI_UNIT($,.STERADIAN.)SOLID_ANGLE_UNIT())")
        limit = f"UNCERTAINTY_MEASURE_WITH_UNIT(LENGTH_MEASURE({real(UNCERTAINTY)}),#{self.length},"
        near = out.add(limit + "'distance_accuracy_value','largest gap between edges and faces')")
        self.context = out.add(
            f"(GEOMETRIC_REPRESENTATION_CONTEXT(3)GLOBAL_UNCERTAINTY_ASSIGNED_CONTEXT((#{near}))"
            f"GLOBAL_UNIT_ASSIGNED_CONTEXT((#{self.length},#{angle},#{space}))REPRESENTATION_CONTEXT('','3D'))"
        )
        self.origin = _placement(out, Frame())
        self.styled: list[int] = []

    def write(self, shape: Brep | FacetBody | Assembly) -> None:
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

    def _part(self, body: Brep | FacetBody) -> tuple[int, int]:
        """A product of one body; returns its definition and its representation."""
        definition = self._definition(body.name, _about(body))
        representation = self._facets(body) if isinstance(body, FacetBody) else self._brep(body)
        self._shaped(definition, representation)
        if isinstance(body, Brep) and body.density is not None:
            self._density(definition, body.density)
        return definition, representation

    def _brep(self, body: Brep) -> int:
        brep = _solid(self.out, body)
        if body.colour is not None:
            style = _style(self.out, body.colour)
            self.styled.append(self.out.add(f"STYLED_ITEM('colour',(#{style}),#{brep})"))
        items = references((self.origin, brep))
        return self.out.add(f"ADVANCED_BREP_SHAPE_REPRESENTATION({string(body.name)},{items},#{self.context})")

    def _facets(self, body: FacetBody) -> int:
        if self.schema != "AP242":
            why = f" ({body.reason})" if body.reason else ""
            raise ExportError(f"{body.name!r} is known as triangles only{why}, which need schema AP242")
        items = references((self.origin, _triangles(self.out, body)))
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
        places = [_placement(out, part.frame) for part in assembly.parts]
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


def _placement(out: Instances, frame: Frame) -> int:
    """AXIS2_PLACEMENT_3D of a frame, shared with equal ones."""
    parts = out.point(frame.origin), out.direction(frame.axis), out.direction(frame.ref)
    return out.once("AXIS2_PLACEMENT_3D('',#{},#{},#{})".format(*parts))


def _curve(out: Instances, shape: Curve) -> int:
    """The curve's instance."""
    if isinstance(shape, Line):
        along = out.once(f"VECTOR('',#{out.direction(shape.direction)},1.)")
        return out.add(f"LINE('',#{out.point(shape.origin)},#{along})")
    if isinstance(shape, Circle):
        return out.once(f"CIRCLE('',#{_placement(out, shape.frame)},{real(shape.radius)})")
    return _spline_curve(out, shape)


def _spline_curve(out: Instances, shape: SplineCurve) -> int:
    poles = references(out.points(shape.poles))
    head = f"{shape.basis.degree},{poles},.UNSPECIFIED.,.F.,.F."
    knots = f"{integers(shape.basis.multiplicities)},{_breaks(shape.basis)},.UNSPECIFIED."
    return out.add(f"B_SPLINE_CURVE_WITH_KNOTS('',{head},{knots})")


def _breaks(basis: Basis) -> str:
    return reals(basis.breaks.tolist())


def _surface(out: Instances, shape: Surface) -> int:
    """The surface's instance; elementary surfaces are shared with equal ones."""
    if isinstance(shape, Plane):
        return out.once(f"PLANE('',#{_placement(out, shape.frame)})")
    if isinstance(shape, Cone):
        place = _placement(out, shape.frame)
        if shape.half_angle == 0.0:
            return out.once(f"CYLINDRICAL_SURFACE('',#{place},{real(shape.radius)})")
        return out.once(f"CONICAL_SURFACE('',#{place},{real(shape.radius)},{real(shape.half_angle)})")
    if isinstance(shape, Torus):
        place = _placement(out, shape.frame)
        return out.once(f"TOROIDAL_SURFACE('',#{place},{real(shape.major)},{real(shape.minor)})")
    nv = shape.poles.shape[1]
    numbers = out.points(shape.poles.reshape(-1, 3))
    rows = [references(numbers[i : i + nv]) for i in range(0, len(numbers), nv)]
    head = f"{shape.u.degree},{shape.v.degree},({','.join(rows)}),.UNSPECIFIED.,.F.,.F.,.F."
    mults = f"{integers(shape.u.multiplicities)},{integers(shape.v.multiplicities)}"
    knots = f"{mults},{_breaks(shape.u)},{_breaks(shape.v)},.UNSPECIFIED."
    return out.add(f"B_SPLINE_SURFACE_WITH_KNOTS('',{head},{knots})")


def _vertex(out: Instances, corner: Vertex) -> int:
    known = out.known(corner)
    return known or out.remember(corner, out.add(f"VERTEX_POINT('',#{out.point(corner.point)})"))


def _edge(out: Instances, edge: Edge, lines: Lines) -> int:
    known = out.known(edge)
    if known:
        return known
    ends = _vertex(out, edge.start), _vertex(out, edge.end)
    curve = _curve(out, edge.curve)
    if edge in lines:
        curve = out.add(f"SURFACE_CURVE('',#{curve},{references(lines[edge])},.CURVE_3D.)")
    return out.remember(edge, out.add(f"EDGE_CURVE('',#{ends[0]},#{ends[1]},#{curve},.T.)"))


def _loop(out: Instances, loop: Loop, lines: Lines) -> int:
    uses = [
        out.add(f"ORIENTED_EDGE('',*,*,#{_edge(out, use.edge, lines)},{'.T.' if use.forward else '.F.'})")
        for use in loop
    ]
    return out.add(f"EDGE_LOOP('',{references(uses)})")


def _face(out: Instances, face: Face, on: int, lines: Lines) -> int:
    kinds = ["FACE_OUTER_BOUND", *["FACE_BOUND"] * (len(face.loops) - 1)]
    bounds = [out.add(f"{kind}('',#{_loop(out, loop, lines)},.T.)") for kind, loop in zip(kinds, face.loops)]
    sense = ".T." if face.same_sense else ".F."
    return out.add(f"ADVANCED_FACE({string(face.name)},{references(bounds)},#{on},{sense})")


def _lines(out: Instances, body: Brep, surfaces: list[int]) -> Lines:
    """Where edges run in the parameters of spline faces whose borders they are.

    Without it a reader projects the edge, and where a face is narrow or ends in a point the nearest point of the face
    says little about the parameter across it.
    """
    found: Lines = {}
    for face, on in zip(body.faces, surfaces):
        if not isinstance(face.surface, SplineSurface):
            continue
        for use in (use for loop in face.loops for use in loop):
            curve = use.edge.curve
            border = face.surface.border(curve) if isinstance(curve, SplineCurve) else None
            if border is not None:
                found.setdefault(use.edge, []).append(_line_in(out, on, *border))
    return found


def _line_in(out: Instances, on: int, axis: int, value: float, sign: int) -> int:
    """PCURVE along which one parameter (0 u, 1 v) of a surface has a value and the other one is the line's, signed."""
    plane = "(GEOMETRIC_REPRESENTATION_CONTEXT(2)PARAMETRIC_REPRESENTATION_CONTEXT()REPRESENTATION_CONTEXT('',''))"
    start, way = ((value, 0.0), (0.0, sign)) if axis == 0 else ((0.0, value), (sign, 0.0))
    along = out.once(f"VECTOR('',#{out.direction(way)},1.)")
    point = out.once(f"CARTESIAN_POINT('',{reals(start)})")
    line = out.once(f"LINE('',#{point},#{along})")
    held = out.once(f"DEFINITIONAL_REPRESENTATION('',(#{line}),#{out.once(plane)})")
    return out.add(f"PCURVE('',#{on},#{held})")


def _solid(out: Instances, body: Brep) -> int:
    """MANIFOLD_SOLID_BREP of a solid; returns its number."""
    surfaces = [_surface(out, face.surface) for face in body.faces]
    lines = _lines(out, body, surfaces)
    faces = [_face(out, face, on, lines) for face, on in zip(body.faces, surfaces)]
    shell = out.add(f"CLOSED_SHELL('',{references(faces)})")
    return out.add(f"MANIFOLD_SOLID_BREP({string(body.name)},#{shell})")


def _style(out: Instances, colour: Colour) -> int:
    rgb = out.once(f"COLOUR_RGB('',{','.join(real(share) for share in colour)})")
    fill = out.once(f"FILL_AREA_STYLE_COLOUR('',#{rgb})")
    area = out.once(f"FILL_AREA_STYLE('',(#{fill}))")
    filled = out.once(f"SURFACE_STYLE_FILL_AREA(#{area})")
    side = out.once(f"SURFACE_SIDE_STYLE('',(#{filled}))")
    usage = out.once(f"SURFACE_STYLE_USAGE(.BOTH.,#{side})")
    return out.once(f"PRESENTATION_STYLE_ASSIGNMENT((#{usage}))")


def _triangles(out: Instances, body: FacetBody) -> int:
    """TESSELLATED_SOLID of a mesh, one TRIANGULATED_FACE for each face group; returns its number."""
    mesh = body.mesh
    faces = []
    for index, label in enumerate(mesh.groups):
        chosen = mesh.faces[mesh.face_groups == index]
        if len(chosen) == 0:
            continue
        used, local = np.unique(chosen, return_inverse=True)
        listed = out.add(f"COORDINATES_LIST('',{len(used)},{triples(mesh.vertices[used])})")
        corners = ",".join([f"({a},{b},{c})" for a, b, c in (local.reshape(-1, 3) + 1).tolist()])
        faces.append(out.add(f"TRIANGULATED_FACE({string(label)},#{listed},{len(used)},(),$,(),({corners}))"))
    return out.add(f"TESSELLATED_SOLID({string(body.name)},{references(faces)},$)")
