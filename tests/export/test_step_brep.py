"""Solids from outlines and meridians: closed-form volumes, and the checker must see every way to break them."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.export.step.brep import Brep, Vertex, reversed_loop
from camgeom.export.step.check import check_solid
from camgeom.export.step.geometry import Circle, Cone, Frame, Line, Plane, SplineCurve, SplineSurface, Torus
from camgeom.export.step.solids import (
    ClosedCurve,
    bore_curve,
    circle_curve,
    prism_solid,
    revolved_solid,
)
from camgeom.maths.splines import Basis
from camgeom.solid.blank import Bore
from tests.export.step_bodies import polygon_curve


def box() -> Brep:
    return prism_solid(polygon_curve([(0, 0), (2, 0), (2, 3), (0, 3)]), 0.0, 4.0)


def test_box() -> None:
    verdict = check_solid(box())
    assert verdict.sound
    assert (verdict.volume, verdict.area, verdict.genus) == pytest.approx((24.0, 52.0, 0), rel=1e-12)


def test_bored_and_keyed_disc_is_made_of_planes_and_cylinders() -> None:
    bore = Bore(20.0, 6.0, 3.0)
    solid = prism_solid(circle_curve(30.0, name="rim"), -5.0, 5.0, [bore_curve(20.0, 6.0, 3.0)])
    verdict = check_solid(solid)
    assert verdict.sound
    assert verdict.genus == 1
    assert verdict.volume == pytest.approx((900.0 * pi - bore.area) * 10.0, rel=1e-9)
    assert {type(face.surface) for face in solid.faces} == {Plane, Cone}
    assert {face.name for face in solid.faces} == {"rim", "bore", "keyway", "end"}


def test_blank_of_cones_cylinders_and_a_flat_shoulder() -> None:
    points = [(20, 0), (25, 5), (25, 10), (15, 10), (15, 14), (20, 20)]
    solid = revolved_solid(points)
    verdict = check_solid(solid)

    def frustum(a: float, b: float, h: float) -> float:
        return (a * a + a * b + b * b) * h / 3.0

    want = pi * (frustum(20, 25, 5) + 625 * 5 + 225 * 4 + frustum(15, 20, 6))
    assert verdict.sound
    assert verdict.volume == pytest.approx(want, rel=1e-10)
    assert {type(face.surface) for face in solid.faces} == {Plane, Cone}


def test_globoid_blank_is_a_torus() -> None:
    c, rho, h = 60.0, np.hypot(30.0, 10.0), 10.0
    solid = revolved_solid([(30.0, -h), (30.0, h)], arcs=[(c, 0.0)])
    z = np.polynomial.legendre.leggauss(60)
    want = pi * h * float(z[1] @ (c - np.sqrt(rho**2 - (h * z[0]) ** 2)) ** 2)
    assert check_solid(solid).volume == pytest.approx(want, rel=1e-10)
    assert Torus in {type(face.surface) for face in solid.faces}


def test_prism_over_a_curve_that_is_neither_line_nor_circle() -> None:
    ellipse = ClosedCurve(lambda t: np.stack([20.0 * np.cos(t), 12.0 * np.sin(t)], axis=1), (0.0, pi, 2 * pi), "flank")
    for tolerance in (1e-4, 1e-7):
        solid = prism_solid(ellipse, 0.0, 10.0, tolerance=tolerance)
        assert solid.deviation <= tolerance
        assert check_solid(solid).volume == pytest.approx(2400.0 * pi, abs=tolerance * 1000.0)
    assert any(isinstance(face.surface, SplineSurface) for face in solid.faces)


def test_checker_sees_a_missing_face() -> None:
    solid = box()
    verdict = check_solid(replace(solid, faces=solid.faces[:-1]))
    assert any("4 edges are not shared" in problem for problem in verdict.problems)


def test_checker_sees_a_face_turned_round() -> None:
    solid = box()
    first = solid.faces[0]
    flipped = replace(first, loops=tuple(reversed_loop(loop) for loop in first.loops))
    problems = check_solid(replace(solid, faces=(flipped, *solid.faces[1:]))).problems
    assert any("not shared" in problem for problem in problems)
    assert any("against its normal" in problem for problem in problems)


def test_checker_sees_an_open_loop() -> None:
    solid = box()
    first = solid.faces[0]
    cut = replace(first, loops=(first.loops[0][:-1],))
    assert any("not closed" in p for p in check_solid(replace(solid, faces=(cut, *solid.faces[1:]))).problems)


def test_checker_sees_everything_inside_out() -> None:
    solid = box()
    faces = tuple(
        replace(face, same_sense=not face.same_sense, loops=tuple(reversed_loop(loop) for loop in face.loops))
        for face in solid.faces
    )
    assert any("inwards" in problem for problem in check_solid(replace(solid, faces=faces)).problems)


@pytest.mark.parametrize(("shift", "sound"), [(0.0009, True), (0.0011, False)])
def test_checker_measures_the_gap_between_edges_and_surface(shift: float, sound: bool) -> None:
    solid = box()
    face = next(face for face in solid.faces if face.name == "end")
    frame = face.surface.frame  # type: ignore[union-attr]
    moved = replace(face, surface=Plane(Frame((0.0, 0.0, frame.origin[2] + shift), frame.axis, frame.ref)))
    verdict = check_solid(replace(solid, faces=tuple(moved if f is face else f for f in solid.faces)))
    assert verdict.deviation == pytest.approx(shift, rel=1e-9)
    assert verdict.sound is sound


def test_checker_sees_a_vertex_off_its_edge() -> None:
    solid = box()
    edge = solid.edges()[0]
    object.__setattr__(edge, "start", Vertex((1.0, 1.0, 1.0)))
    assert any("vertex is" in problem for problem in check_solid(solid).problems)


def parabola() -> SplineCurve:
    poles = np.array([[5.0, 0.0, 0.0], [5.0, 5.0, 0.0], [0.0, 5.0, 0.0]])
    return SplineCurve(Basis(2, np.array([0, 0, 0, 1, 1, 1.0])), poles)


@pytest.mark.parametrize(
    "curve",
    [
        Line((1.0, 2.0, 3.0), (0.6, 0.0, 0.8)),
        Circle(Frame((1.0, 0.0, 2.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0)), 7.0),
        parabola(),
    ],
)
def test_curves_locate_their_own_points(curve: Line | Circle | SplineCurve) -> None:
    t = np.linspace(0.05, 0.95, 7)
    assert np.allclose(curve.locate(curve.at(t)), t, atol=1e-12)
    step = 1e-6
    slope = (curve.at(t + step) - curve.at(t - step)) / (2.0 * step)
    assert np.allclose(curve.tangent(t), slope, atol=1e-7)


def test_spline_surface_has_the_jet_of_its_rule() -> None:
    """A parabola drawn along Z: poles halfway up, the slope of the curve along u, the height along v."""
    curve = parabola()
    poles = np.stack([curve.poles, curve.poles + np.array([0.0, 0.0, 4.0])], axis=1)
    surface = SplineSurface(curve.basis, Basis(1, np.array([0, 0, 1, 1.0])), poles)
    x, xu, xv = surface.jet(np.array([0.3]), np.array([0.5]))
    assert np.allclose(x[0], curve.at(np.array([0.3]))[0] + [0.0, 0.0, 2.0])
    assert np.allclose(xu, curve.tangent(np.array([0.3])))
    assert np.allclose(xv[0], [0.0, 0.0, 4.0])
