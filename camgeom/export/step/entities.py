"""A boundary representation as STEP instances: geometry, topology, colours, and triangles for meshes."""

from __future__ import annotations

import numpy as np

from camgeom.export.step.brep import Colour, Edge, Face, Facets, Loop, Solid, Vertex
from camgeom.export.step.geometry import Circle, Cone, Curve, Frame, Line, Plane, SplineCurve, Surface, Torus
from camgeom.export.step.spline import Basis
from camgeom.export.step.text import Instances, integers, real, reals, references, string, triples


def placement(out: Instances, frame: Frame) -> int:
    """AXIS2_PLACEMENT_3D of a frame, shared with equal ones."""
    parts = out.point(frame.origin), out.direction(frame.axis), out.direction(frame.ref)
    return out.once("AXIS2_PLACEMENT_3D('',#{},#{},#{})".format(*parts))


def curve(out: Instances, shape: Curve) -> int:
    """The curve's instance."""
    if isinstance(shape, Line):
        along = out.once(f"VECTOR('',#{out.direction(shape.direction)},1.)")
        return out.add(f"LINE('',#{out.point(shape.origin)},#{along})")
    if isinstance(shape, Circle):
        return out.once(f"CIRCLE('',#{placement(out, shape.frame)},{real(shape.radius)})")
    return _spline_curve(out, shape)


def _spline_curve(out: Instances, shape: SplineCurve) -> int:
    poles = references(out.points(shape.poles))
    head = f"{shape.basis.degree},{poles},.UNSPECIFIED.,.F.,.F."
    knots = f"{integers(shape.basis.multiplicities)},{_breaks(shape.basis)},.UNSPECIFIED."
    if shape.weights is None:
        return out.add(f"B_SPLINE_CURVE_WITH_KNOTS('',{head},{knots})")
    return out.add(
        f"(BOUNDED_CURVE()B_SPLINE_CURVE({head})B_SPLINE_CURVE_WITH_KNOTS({knots})CURVE()"
        f"GEOMETRIC_REPRESENTATION_ITEM()RATIONAL_B_SPLINE_CURVE({reals(shape.weights.tolist())})REPRESENTATION_ITEM(''))"
    )


def _breaks(basis: Basis) -> str:
    return reals(basis.breaks.tolist())


def surface(out: Instances, shape: Surface) -> int:
    """The surface's instance; elementary surfaces are shared with equal ones."""
    if isinstance(shape, Plane):
        return out.once(f"PLANE('',#{placement(out, shape.frame)})")
    if isinstance(shape, Cone):
        place = placement(out, shape.frame)
        if shape.half_angle == 0.0:
            return out.once(f"CYLINDRICAL_SURFACE('',#{place},{real(shape.radius)})")
        return out.once(f"CONICAL_SURFACE('',#{place},{real(shape.radius)},{real(shape.half_angle)})")
    if isinstance(shape, Torus):
        place = placement(out, shape.frame)
        return out.once(f"TOROIDAL_SURFACE('',#{place},{real(shape.major)},{real(shape.minor)})")
    nv = shape.poles.shape[1]
    numbers = out.points(shape.poles.reshape(-1, 3))
    rows = [references(numbers[i : i + nv]) for i in range(0, len(numbers), nv)]
    head = f"{shape.u.degree},{shape.v.degree},({','.join(rows)}),.UNSPECIFIED.,.F.,.F.,.F."
    mults = f"{integers(shape.u.multiplicities)},{integers(shape.v.multiplicities)}"
    knots = f"{mults},{_breaks(shape.u)},{_breaks(shape.v)},.UNSPECIFIED."
    if shape.weights is None:
        return out.add(f"B_SPLINE_SURFACE_WITH_KNOTS('',{head},{knots})")
    weights = ",".join(reals(row) for row in shape.weights.tolist())
    return out.add(
        f"(BOUNDED_SURFACE()B_SPLINE_SURFACE({head})B_SPLINE_SURFACE_WITH_KNOTS({knots})GEOMETRIC_REPRESENTATION_ITEM()"
        f"RATIONAL_B_SPLINE_SURFACE(({weights}))REPRESENTATION_ITEM('')SURFACE())"
    )


def _vertex(out: Instances, corner: Vertex) -> int:
    known = out.known(corner)
    return known or out.remember(corner, out.add(f"VERTEX_POINT('',#{out.point(corner.point)})"))


def _edge(out: Instances, edge: Edge) -> int:
    known = out.known(edge)
    if known:
        return known
    ends = _vertex(out, edge.start), _vertex(out, edge.end)
    return out.remember(edge, out.add(f"EDGE_CURVE('',#{ends[0]},#{ends[1]},#{curve(out, edge.curve)},.T.)"))


def _loop(out: Instances, loop: Loop) -> int:
    uses = [out.add(f"ORIENTED_EDGE('',*,*,#{_edge(out, use.edge)},{'.T.' if use.forward else '.F.'})") for use in loop]
    return out.add(f"EDGE_LOOP('',{references(uses)})")


def _face(out: Instances, face: Face) -> int:
    kinds = ["FACE_OUTER_BOUND", *["FACE_BOUND"] * (len(face.loops) - 1)]
    bounds = [out.add(f"{kind}('',#{_loop(out, loop)},.T.)") for kind, loop in zip(kinds, face.loops)]
    sense = ".T." if face.same_sense else ".F."
    on = surface(out, face.surface)
    return out.add(f"ADVANCED_FACE({string(face.name)},{references(bounds)},#{on},{sense})")


def solid(out: Instances, body: Solid) -> tuple[int, list[int]]:
    """MANIFOLD_SOLID_BREP of a solid; returns its number and the styled items for its colours."""
    faces = [_face(out, face) for face in body.faces]
    shell = out.add(f"CLOSED_SHELL('',{references(faces)})")
    brep = out.add(f"MANIFOLD_SOLID_BREP({string(body.name)},#{shell})")
    styled = []
    if body.colour is not None:
        styled.append(out.add(f"STYLED_ITEM('colour',(#{_style(out, body.colour)}),#{brep})"))
    for face, number in zip(body.faces, faces):
        if face.colour is None:
            continue
        style = _style(out, face.colour)
        over = f"OVER_RIDING_STYLED_ITEM('colour',(#{style}),#{number},#{styled[0]})"
        styled.append(out.add(over if body.colour is not None else f"STYLED_ITEM('colour',(#{style}),#{number})"))
    return brep, styled


def _style(out: Instances, colour: Colour) -> int:
    rgb = out.once(f"COLOUR_RGB('',{','.join(real(share) for share in colour)})")
    fill = out.once(f"FILL_AREA_STYLE_COLOUR('',#{rgb})")
    area = out.once(f"FILL_AREA_STYLE('',(#{fill}))")
    filled = out.once(f"SURFACE_STYLE_FILL_AREA(#{area})")
    side = out.once(f"SURFACE_SIDE_STYLE('',(#{filled}))")
    usage = out.once(f"SURFACE_STYLE_USAGE(.BOTH.,#{side})")
    return out.once(f"PRESENTATION_STYLE_ASSIGNMENT((#{usage}))")


def triangles(out: Instances, body: Facets) -> tuple[int, list[int]]:
    """TESSELLATED_SOLID of a mesh, one TRIANGULATED_FACE for each face group; its number and styled items."""
    mesh = body.mesh
    group = np.zeros(len(mesh.faces), dtype=np.uint8) if mesh.group is None else mesh.group
    faces = []
    for index, label in enumerate(mesh.groups):
        chosen = mesh.faces[group == index]
        if len(chosen) == 0:
            continue
        used, local = np.unique(chosen, return_inverse=True)
        listed = out.add(f"COORDINATES_LIST('',{len(used)},{triples(mesh.vertices[used])})")
        corners = ",".join([f"({a},{b},{c})" for a, b, c in (local.reshape(-1, 3) + 1).tolist()])
        faces.append(out.add(f"TRIANGULATED_FACE({string(label)},#{listed},{len(used)},(),$,(),({corners}))"))
    number = out.add(f"TESSELLATED_SOLID({string(body.name)},{references(faces)},$)")
    if body.colour is None:
        return number, []
    return number, [out.add(f"STYLED_ITEM('colour',(#{_style(out, body.colour)}),#{number})")]
