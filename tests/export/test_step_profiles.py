"""The STEP file of every profile, read back by OpenCASCADE: valid, tight, of the mesh's volume, flanks on the roller.

Takes some minutes, so it runs where it is asked for: `scripts/test --judge tests/export/test_step_profiles.py`.
"""

from __future__ import annotations

import os
from pathlib import Path
from time import perf_counter

import numpy as np
import pytest

from camgeom.export import write
from camgeom.model import Model, read
from camgeom.solid import Part
from camgeom.solid.bell import GroovedRing
from camgeom.solid.cut import CutBlank, IndexingCut
from camgeom.track import TURN, Straight, Track
from scripts.judge_step import judged
from tests.oracle.envelope import roller_distance, swept_distance
from tests.oracle.refined_volume import limit_volume
from tests.places import PROFILES

NAMES = sorted(path.stem for path in PROFILES.glob("*.toml"))

pytestmark = [
    pytest.mark.opencascade,
    pytest.mark.slow,
    pytest.mark.skipif("CAMGEOM_JUDGE" not in os.environ, reason="takes minutes: scripts/test --judge"),
]


def mesh_limit(part: Part) -> float:
    """Volume in mm³ to which the part's meshes tend."""
    if isinstance(part, CutBlank | IndexingCut):
        return limit_volume(part, 8, 0.06)
    coarse, fine = (part.solid(tolerance).mesh.volume for tolerance in (1e-4, 2.5e-5))
    return (4.0 * fine - coarse) / 3.0


def roller_gap(model: Model, points: np.ndarray) -> np.ndarray:
    """Signed distance in mm of flank points from the nearest position of a tool of any track, (n,)."""
    gaps = []
    for one in model.grooves:
        own = np.array([_gap(track, points, one) for track in one.cutters])
        if one.planar is not None or one.profile.kind == "parallel-index" or len(one.parts) > 1:
            # Each disc has its own roller; beside the other one it means nothing.
            own = own[np.argmin(np.abs(own), axis=0), np.arange(len(points))][None]
        gaps.append(own.min(axis=0))
    each = np.array(gaps)
    return each[np.argmin(np.abs(each), axis=0), np.arange(len(points))]


def _gap(track: Track, points: np.ndarray, model: Model) -> np.ndarray:
    meridian = track.meridian
    kind = "cone" if isinstance(meridian, Straight) else "sphere" if meridian.arc == meridian.radius else "crowned"
    shape = kind, meridian.slope if isinstance(meridian, Straight) else meridian.arc, meridian.centre
    # A groove's walls go on beyond the roller's end, down to a floor that clears it.
    more = meridian.radius if isinstance(model.parts[0], IndexingCut | GroovedRing) else 0.0
    tip = track.tip + more * track.tip_sign
    if abs(track.axis[2]) == 1.0:
        # The walls of a plate end at its faces. A crown runs on a straight one, a cone leans on beyond.
        if not isinstance(meridian, Straight):
            shape = "cone", 0.0, 0.0
        tip = track.tip + 1e3 * track.tip_sign

    def pose(phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found = track.pose(phi.ravel(), 0)
        return tuple(x[0].T.reshape(*phi.shape, 3) for x in (found.a, found.u))  # type: ignore[return-value]

    def distance(x: np.ndarray, a: np.ndarray, u: np.ndarray) -> np.ndarray:
        found = roller_distance(x, a, u, meridian.radius, tip, track.tip_sign > 0.0, shape)
        if track.tip_sign > 0.0 and track.axis[2] == 0.0:  # from within a ring it does not go on to the other side
            return np.where(np.einsum("...i,...i->...", x - a, u) < 0.0, 1e3, found)
        return found

    low, high = (-0.5, TURN + 0.5) if track.closed else track.span
    return swept_distance(points, pose, distance, low, high, int(240 * (high - low) / TURN), 3, 45)


@pytest.mark.parametrize("name", NAMES)
def test_opencascade_reads_one_valid_solid_a_body(name: str, tmp_path: Path) -> None:
    path = tmp_path / "cam.step"
    model = read(str(PROFILES / f"{name}.toml"))
    write(model, path)
    (verdict,) = judged([path], ["flank"])
    notes = model.ledger.notes["step"][0]["bodies"]
    wanted = [mesh_limit(part) for part in model.parts]
    off = max(abs(a / b - 1.0) for a, b in zip(verdict.volumes, wanted))
    points = np.array(verdict.points["flank"])
    if model.profile.kind == "parallel-index":  # its plates' rims are no flanks
        points = points[np.hypot(points[:, 0], points[:, 1]) < 0.5 * model.cam.diameter - 1e-6]
    points = points[:: max(1, len(points) // 400)]
    gap = float(np.abs(roller_gap(model, points)).max()) if model.cutters else float("nan")
    print(
        f"{name}: {verdict.solids} solids, {verdict.faces} faces, tolerance {verdict.tolerance:.1e} mm, volume off by "
        f"{off:.1e}, flank off by {gap:.1e} mm at {len(points)} points, fitted within {notes[0]['deviation_mm']:.1e} mm"
    )
    count = len(model.parts) + (model.frame is not None)
    assert [note["faces"] for note in notes] == ["exact"] * count
    assert (verdict.solids, verdict.free_shells, verdict.valid) == (count, 0, True), verdict.complaints
    assert (verdict.triangles, len(verdict.volumes)) == (0, count)
    assert verdict.tolerance <= 1e-5
    assert [part.name for part in model.parts] == verdict.bodies[-count:][: len(model.parts)]
    assert off < 1e-7
    assert not gap > 1e-4
    assert len(points) > 20 or not model.cutters


def test_groove_cam_is_quick_and_small(tmp_path: Path) -> None:
    path, took = tmp_path / "pin.step", []
    for _ in range(7):
        model = read(str(PROFILES / "pin_insertion.toml"))
        began = perf_counter()
        size = write(model, path)
        took.append(perf_counter() - began)
    print("groove cam", min(took), size)
    assert size < 1_000_000
