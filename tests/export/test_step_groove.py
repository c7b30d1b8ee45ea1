"""The groove cam as faces: sound, within its tolerance of the true flank, and of the right volume."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.export.step.brep import Brep
from camgeom.export.step.check import check_solid
from camgeom.export.step.geometry import Cone, Plane, SplineSurface
from camgeom.export.step.groove import grooved_solid, split_knots
from camgeom.solid.drum import GroovedCylinder
from camgeom.track import Arc, Straight
from tests.export.step_bodies import FLOOR, LENGTH, RADIUS, ROLLER, drum, pin_program, rise_and_return, swinging_drum
from tests.oracle.envelope import roller_distance, swept_distance
from tests.oracle.judge_volume import groove_volume


@pytest.fixture(scope="module")
def pin_cam() -> Brep:
    return grooved_solid(drum())


def test_pin_cam_is_sound_and_its_dwells_are_plane(pin_cam: Brep) -> None:
    verdict = check_solid(pin_cam)
    assert verdict.problems == ()
    assert verdict.genus == 1
    assert verdict.deviation < 1e-6
    assert pin_cam.deviation <= 1e-5
    kinds = {name: {type(f.surface) for f in pin_cam.faces if f.name == name} for name in ("flank", "floor", "land")}
    assert kinds == {"flank": {Plane, SplineSurface}, "floor": {Cone}, "land": {Cone}}
    assert len(pin_cam.faces) == 26


def test_pin_cam_has_the_volume_of_the_swept_roller(pin_cam: Brep) -> None:
    program = pin_program()
    groove = groove_volume(lambda phi: program.jet(phi, 0)[0], RADIUS, FLOOR, ROLLER, 360)
    want = pi * (RADIUS**2 - 20.0**2) * LENGTH - groove
    assert check_solid(pin_cam).volume == pytest.approx(want, rel=1e-8)


def surface_points(solid: Brep, name: str, count: int = 5) -> np.ndarray:
    """Points inside the spline faces of one name, none of them an interpolated one."""
    found = []
    for face in solid.faces:
        if face.name == name and isinstance(face.surface, SplineSurface):
            rng = np.random.default_rng(len(found))
            u = face.surface.u.start + (face.surface.u.stop - face.surface.u.start) * rng.uniform(0.02, 0.98, count)
            found.append(face.surface.jet(u, rng.uniform(0.02, 0.98, count))[0])
    return np.concatenate(found)


def test_flank_and_edge_sweep_touch_the_roller_and_nothing_overlaps(pin_cam: Brep) -> None:
    program = pin_program()

    def pose(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        u = np.stack([np.cos(phi), -np.sin(phi), np.zeros_like(phi)], axis=-1)
        a = np.zeros((*np.shape(phi), 3))
        a[..., 2] = 18.0 + program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
        return a, u

    def distance(x: np.ndarray, a: np.ndarray, u: np.ndarray) -> np.ndarray:
        return roller_distance(x, a, u, ROLLER, FLOOR)

    for name in ("flank", "edge"):
        x = surface_points(pin_cam, name)
        least = swept_distance(x, pose, distance, 0.0, 2.0 * pi)
        assert float(np.abs(least).max()) < 1e-5


@pytest.mark.parametrize("tolerance", [1e-3, 1e-7])
def test_tolerance_is_kept_and_stated(tolerance: float) -> None:
    solid = grooved_solid(drum(), tolerance)
    assert 0.01 * tolerance < solid.deviation <= tolerance


@pytest.mark.parametrize(
    "body",
    [
        drum(sense=-1.0, bore=None),
        drum(rise_and_return()),
        drum(rise_and_return(), Straight(11.0, 60.5, 0.15)),
        drum(rise_and_return(), Arc(11.0, 60.5, 400.0)),
        drum(rise_and_return(), Arc(11.0, 66.5, 11.0), tip=55.5),
        swinging_drum(),
    ],
    ids=["clockwise", "no dwell", "cone", "crowned", "ball", "swinging"],
)
def test_relatives_are_sound_and_have_the_volume_of_their_mesh(body: GroovedCylinder) -> None:
    solid = grooved_solid(body, 1e-4)
    verdict = check_solid(solid)
    assert verdict.problems == ()
    assert verdict.deviation < 2e-4
    assert verdict.genus == (0 if body.blank.bore is None else 1)
    coarse, fine = (body.solid(tolerance).mesh.volume for tolerance in (0.1, 0.03))
    assert verdict.volume == pytest.approx(fine, abs=1.2 * abs(fine - coarse))


def test_edge_sweep_is_cut_where_the_follower_turns_round_inside_a_segment() -> None:
    body = drum(rise_and_return())
    knots = split_knots(body.track)
    assert knots == pytest.approx([0.0, pi, 2.0 * pi], abs=1e-9)


def test_groove_that_runs_out_is_refused() -> None:
    with pytest.raises(DesignError, match="runs out of an end face"):
        grooved_solid(drum(start=10.0))
