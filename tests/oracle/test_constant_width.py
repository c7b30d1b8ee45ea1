"""Constant-width cams: the width all round, the machine of the paper, the yoke with two rollers, the solid."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.errors import ProfileError
from camgeom.profile import parse
from tests.reference.planar_machines import machine

YOKE = '[roller]\nshape = "cylinder"\ndiameter = 20\nlength = 16'


def supports(points: np.ndarray, azimuth: np.ndarray) -> np.ndarray:
    """Largest reach of points (n, 2) in each direction (k,): what a straight edge laid against them measures."""
    return (points @ np.stack([np.cos(azimuth), np.sin(azimuth)])).max(axis=0)


@pytest.mark.parametrize("law", ["simple-harmonic", "modified-sine", "cycloidal"])
def test_width_is_constant_all_round(law: str) -> None:
    model = machine(law)
    phi = np.linspace(0.0, 2.0 * pi, 3601)
    near, far = (touch.at(phi).curve for touch in model.mechanism.touches)
    width = ((near.points - far.points) * near.normals).sum(axis=0)
    assert np.abs(width - 110.0).max() < 1e-12
    assert model.mechanism.span_between == 110.0


def test_straight_edges_measure_the_width_of_the_solid() -> None:
    model = machine()
    ring = model.solid.mesh.vertices
    azimuth = np.linspace(0.0, pi, 721)
    width = supports(ring[:, :2], azimuth) + supports(ring[:, :2], azimuth + pi)
    assert width.max() < 110.0 + 1e-12
    assert width.min() > 110.0 - 2.0 * model.solid.chord_error
    assert model.solid.sound


def test_yoke_measures_one_diameter_and_its_rollers_touch() -> None:
    model = machine(roller=YOKE)
    phi = np.linspace(0.0, 2.0 * pi, 1441)
    near, far = (track.pose(phi, 0).a[0] for track in model.tracks)
    distance = np.sqrt(((near - far) ** 2).sum(axis=0))
    assert np.abs(distance - 130.0).max() < 1e-12
    profile = model.mechanism.outlines["profile"].curve(phi).points.T
    for centre in (near, far):
        gap = np.sqrt(((profile[:, None] - centre[:2].T[None, ::8]) ** 2).sum(axis=2)).min(axis=0) - 10.0
        # A sampled outline is never nearer than the exact one, and at most the sag of a step away.
        assert np.abs(gap).max() < 1e-3


def test_supports_of_the_motion_are_checked() -> None:
    text = starter("constant-width")
    with pytest.raises(ProfileError, match="must end the stated half turn"):
        parse(text.replace("until = 180", "until = 200"))
    with pytest.raises(ProfileError, match="bore"):
        parse(text.replace("bore = 24", "bore = 90"))
