"""The body of an undercut drum: refused unless asked for, then within its stated error of the nearest roller."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.model import Model
from camgeom.profile import parse
from tests.cli.small import GOOD
from tests.oracle.envelope import roller_distance, swept_distance

PROFILE = (
    GOOD.replace("diameter = 12", "diameter = 24").replace("until = 180", "until = 40").replace("0.05", "0.2")
)


def test_undercut_drum_is_refused_unless_asked_for():
    with pytest.raises(DesignError, match="undercut"):
        _ = Model(parse(PROFILE)).solid


@pytest.mark.parametrize("tolerance", [None, 1e-4])
def test_undercut_drum_is_within_its_stated_error(tolerance):
    """Of a tolerance finer than its positions leave the rollers' facets take no part: they would cost minutes."""
    model = Model(parse(PROFILE + "undercut_solid = true\n"), tolerance=tolerance)
    solid = model.solid
    assert solid.method == "union of rollers"
    assert solid.mesh.watertight
    assert len(solid.mesh.faces) < 70_000
    motion = model.setup.program

    def pose(phi):
        s = motion.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi))
        zero = np.zeros_like(s)
        return np.stack([zero, zero, 20.0 + s], -1), np.stack([np.cos(phi), -np.sin(phi), zero], -1)

    points = solid.mesh.vertices[np.unique(solid.mesh.faces[solid.mesh.group_faces("flank")])]
    found = swept_distance(
        points, pose, lambda x, a, u: roller_distance(x, a, u, 12.0, 31.0), 0.0, 2.0 * np.pi, coarse=720
    )
    assert np.abs(found).max() <= solid.chord_error
    assert np.abs(found).max() > 0.1 * solid.chord_error
