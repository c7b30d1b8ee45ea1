"""Planar cams and ribs as faces: sound, and of the volume of the exact outline or of their mesh."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.export.step import step_text
from camgeom.export.step.bodies import EXACT
from camgeom.export.step.check import check_solid
from camgeom.export.step.groove import ribbed_solid
from camgeom.export.step.solids import grooved_plate_solid, planar_solid
from camgeom.motion import Program, Segment
from camgeom.solid.blank import Blank, Bore
from camgeom.solid.drum import RibbedCylinder
from camgeom.solid.prism import FaceGroove, GroovedPlate, Loop, Prism
from camgeom.track import Slide, Straight, Track
from camgeom.track.outline import CircleOutline, OutlineIntegrals, RollerOutline
from tests.export.step_bodies import BORE, LENGTH, RADIUS, rise_and_return


def plate_track(base: float = 50.0, lift: float = 20.0, roller: float = 10.0, sense: float = 1.0) -> Track:
    program = Program.from_segments(
        [
            Segment(radians(100), lift, "modified-sine"),
            Segment(radians(150)),
            Segment(radians(300), 0.0, "3-4-5"),
            Segment(2.0 * pi),
        ]
    )
    anchor, axis = (base, 0.0, 0.0), (0.0, 0.0, 1.0)
    return Track(Straight(roller, 0.0), Slide((1.0, 0.0, 0.0)), anchor, axis, -10.0, (-5.0, 5.0), program, sense)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_disc_cam_has_the_area_of_its_exact_outline(sense: float) -> None:
    outline = RollerOutline(plate_track(sense=sense), -10.0)
    bore = Bore(30.0, 8.0, 3.3)
    solid = planar_solid(Prism("disc", Loop(outline, "flank"), 0.0, 16.0, bore=bore), 1e-7)
    verdict = check_solid(solid)
    assert verdict.problems == ()
    assert verdict.genus == 1
    assert verdict.volume == pytest.approx(16.0 * (OutlineIntegrals(outline).properties.area - bore.area), rel=1e-9)
    assert {face.name for face in solid.faces} == {"flank", "bore", "keyway", "end"}


def test_face_groove_plate() -> None:
    track = plate_track()
    inner, outer = RollerOutline(track, -10.0), RollerOutline(track, 10.0)
    rim = CircleOutline(95.0)
    groove = FaceGroove(Loop(inner, "flank"), Loop(outer, "flank"), 8.0, 20.0)
    solid = grooved_plate_solid(
        GroovedPlate("plate", Loop(rim, "rim"), (groove,), 0.0, 20.0, BORE), 1e-7
    )
    verdict = check_solid(solid)
    groove = OutlineIntegrals(outer).properties.area - OutlineIntegrals(inner).properties.area
    assert verdict.problems == ()
    assert verdict.genus == 1
    assert verdict.volume == pytest.approx(20.0 * pi * (95.0**2 - 20.0**2) - 12.0 * groove, rel=1e-9)


def test_undercut_outline_is_refused_and_the_next_smaller_roller_is_not() -> None:
    track = plate_track(roller=10.0)
    nearest = 1.0 / float(RollerOutline(track, 0.0).curve(np.linspace(0.0, 2.0 * pi, 7201)).curvature.max())
    planar_solid(Prism("disc", Loop(RollerOutline(track, -0.999 * nearest), "flank"), 0.0, 16.0), 1e-3)
    with pytest.raises(DesignError, match="turns back"):
        planar_solid(Prism("disc", Loop(RollerOutline(track, -1.002 * nearest), "flank"), 0.0, 16.0))


@pytest.mark.parametrize(("diameter", "refused"), [(79.9, False), (80.1, True)])
def test_bore_must_stay_inside(diameter: float, refused: bool) -> None:
    body = Prism("disc", Loop(RollerOutline(plate_track(), -10.0), "flank"), 0.0, 16.0, bore=Bore(diameter))
    if refused:
        with pytest.raises(DesignError, match="the bore reaches"):
            planar_solid(body)
    else:
        assert check_solid(planar_solid(body, 1e-4)).sound


def rib(sense: float = 1.0) -> RibbedCylinder:
    program, joint = rise_and_return(30.0), Slide((0.0, 0.0, 1.0))
    tracks = [
        Track(Straight(9.0, 60.0), joint, (0.0, 0.0, z), (1.0, 0.0, 0.0), 52.7, (55.0, 67.0), program, sense)
        for z in (25.0, 55.0)
    ]
    return RibbedCylinder("rib", tracks[0], tracks[1], Blank.cylinder(RADIUS, LENGTH, BORE), 54.0, RADIUS, LENGTH)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_rib_has_the_volume_of_its_mesh(sense: float) -> None:
    body = rib(sense)
    verdict = check_solid(ribbed_solid(body, 1e-5))
    assert verdict.problems == ()
    coarse, fine = (body.solid(tolerance).mesh.volume for tolerance in (0.05, 0.0125))
    assert verdict.volume == pytest.approx(fine, abs=1.2 * abs(fine - coarse))


def test_every_kind_of_part_gives_a_file() -> None:
    assert set(EXACT) >= {RibbedCylinder, Prism, GroovedPlate}
    body = planar_solid(Prism("disc", Loop(RollerOutline(plate_track(), -10.0), "flank"), 0.0, 16.0))
    assert len(step_text(body)) < 100_000
