"""OpenCASCADE reads what we write: one valid solid, tight tolerance, the right volume and names."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

from camgeom.export.step import Assembly, Brep, FacetBody, write_step
from camgeom.export.step.brep import Placed
from camgeom.export.step.check import check_solid
from camgeom.export.step.file import Schema
from camgeom.export.step.geometry import Frame
from camgeom.export.step.groove import grooved_solid
from camgeom.export.step.solids import (
    ClosedCurve,
    bore_curve,
    circle_curve,
    prism_solid,
    revolved_solid,
)
from camgeom.solid.blank import Bore
from camgeom.track import Arc, Straight
from scripts.judge_step import Judgement
from scripts.judge_step import judged as judged_files
from tests.export.step_bodies import drum, polygon_curve, rise_and_return, swinging_drum

pytestmark = pytest.mark.opencascade


def judged(folder: Path, solid: Brep, schema: Schema = "AP242") -> Judgement:
    write_step(folder / "a.step", solid, schema)
    return judged_files([folder / "a.step"])[0]


def ellipse() -> ClosedCurve:
    return ClosedCurve(lambda t: np.stack([20.0 * np.cos(t), 12.0 * np.sin(t)], axis=1), (0.0, pi, 2.0 * pi), "flank")


SOLIDS = {
    "box": prism_solid(polygon_curve([(0, 0), (2, 0), (2, 3), (0, 3)]), 0.0, 4.0),
    "keyed disc": prism_solid(circle_curve(30.0, name="rim"), 0.0, 10.0, [bore_curve(20.0, 6.0, 3.0)]),
    "stepped blank": revolved_solid([(20, 0), (25, 5), (25, 10), (15, 10), (15, 14), (20, 20)]),
    "globoid blank": revolved_solid([(30, -10), (30, 10)], arcs=[(60, 0)]),
    "ellipse": prism_solid(ellipse(), 0.0, 10.0, [bore_curve(10.0, 3.0, 2.0)]),
}


@pytest.mark.parametrize("schema", ["AP242", "AP214"])
@pytest.mark.parametrize("name", SOLIDS)
def test_plain_solids(tmp_path: Path, name: str, schema: str) -> None:
    solid = SOLIDS[name]
    verdict, own = judged(tmp_path, solid, schema), check_solid(solid)  # type: ignore[arg-type]
    assert (verdict.solids, verdict.free_shells, verdict.valid) == (1, 0, True), verdict.complaints
    assert verdict.tolerance <= 1e-7
    assert verdict.volume == pytest.approx(own.volume, rel=1e-9)
    assert verdict.area == pytest.approx(own.area, rel=1e-8)
    assert sorted(verdict.face_names) == sorted(face.name for face in solid.faces)


def test_closed_forms(tmp_path: Path) -> None:
    assert judged(tmp_path, SOLIDS["box"]).volume == pytest.approx(24.0, rel=1e-12)
    keyed = (900.0 * pi - Bore(20.0, 6.0, 3.0).area) * 10.0
    assert judged(tmp_path, SOLIDS["keyed disc"]).volume == pytest.approx(keyed, rel=1e-9)


@pytest.mark.slow
def test_pin_cam(tmp_path: Path) -> None:
    solid = grooved_solid(drum())
    verdict = judged(tmp_path, solid)
    assert (verdict.solids, verdict.valid, verdict.complaints) == (1, True, [])
    assert verdict.tolerance <= 1e-5
    assert verdict.volume == pytest.approx(check_solid(solid).volume, rel=1e-9)
    assert verdict.bodies == ["pin cam"]
    assert set(verdict.face_names) == {"land", "flank", "edge", "floor", "bore", "end"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "body",
    [
        drum(rise_and_return(), Straight(11.0, 60.5, 0.15), sense=-1.0, bore=None),
        drum(rise_and_return(), Arc(11.0, 66.5, 11.0), tip=55.5),
        swinging_drum(),
    ],
    ids=["cone", "ball", "swinging"],
)
def test_relatives(tmp_path: Path, body: object) -> None:
    solid = grooved_solid(body)  # type: ignore[arg-type]
    verdict = judged(tmp_path, solid)
    assert (verdict.solids, verdict.valid, verdict.complaints) == (1, True, [])
    assert verdict.tolerance <= 1e-5
    assert verdict.volume == pytest.approx(check_solid(solid).volume, rel=1e-8)


def test_assembly_puts_its_parts_where_it_says(tmp_path: Path) -> None:
    body = SOLIDS["box"]
    away = Frame((100.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))  # X, Y, Z of the box go to Y, Z, X
    write_step(tmp_path / "a.step", Assembly("Getriebe Ø", (Placed(body), Placed(body, away, "turned"))))
    verdict = judged_files([tmp_path / "a.step"])[0]
    assert (verdict.solids, verdict.valid) == (2, True)
    assert verdict.volume == pytest.approx(48.0, rel=1e-9)
    assert verdict.box == pytest.approx((0.0, 0.0, 0.0, 104.0, 3.0, 4.0), abs=1e-6)


def test_triangles(tmp_path: Path) -> None:
    mesh = drum().solid(0.2).mesh
    write_step(tmp_path / "a.step", FacetBody("cam", mesh))
    verdict = judged_files([tmp_path / "a.step"])[0]
    assert verdict.triangles == len(mesh.faces)
    assert set(verdict.face_names) == set(mesh.groups)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    assert verdict.box == pytest.approx((*low, *high), abs=1e-2)


def test_a_rounded_root(tmp_path: Path) -> None:
    body = replace(drum(rise_and_return()), track=replace(drum(rise_and_return()).track, root=1.2))
    solid = grooved_solid(body)
    verdict = judged(tmp_path, solid)
    assert (verdict.solids, verdict.free_shells, verdict.valid) == (1, 0, True), verdict.complaints
    assert verdict.tolerance <= 1e-5
    assert verdict.volume == pytest.approx(check_solid(solid).volume, rel=1e-6)
    assert "root" in {name.split(".")[0].rstrip("0123456789- ") for name in verdict.face_names}
