"""DXF drawings read back by ezdxf: no audit error, units, layers, and the exact curves within what the file states."""

from __future__ import annotations

from pathlib import Path

import ezdxf
import numpy as np
import pytest

from camgeom.errors import ExportError, NotConverged
from camgeom.export import write
from camgeom.maths.curves import PlaneCurve, chords, fitted
from camgeom.model import Model, read
from camgeom.model.surfaces import flank_surfaces
from camgeom.profile import parse
from camgeom.track.flank import Flank
from tests.oracle.envelope import roller_distance, swept_distance
from tests.places import PROFILES
from tests.reference.planar_machines import flat, smallest_flat_base


def changed(name: str, old: str, new: str) -> Model:
    text = (PROFILES / f"{name}.toml").read_text()
    assert old in text
    return Model(parse(text.replace(old, new)))


def curves(document, kind):
    """(layer, curve name, stated error, entity) of the splines or polylines that carry a curve's name."""
    for entity in document.modelspace().query(kind):
        if entity.has_xdata("CAMGEOM"):
            data = entity.get_xdata("CAMGEOM")
            yield entity.dxf.layer, data[0].value, data[1].value, entity


def on_spline(entity, count=4000):
    """Points (n, 2) of a spline entity by ezdxf's own evaluation."""
    tool = entity.construction_tool()
    u = np.linspace(tool.knots()[0], tool.knots()[-1], count)
    return np.array([(p.x, p.y) for p in tool.points(u)])


def readable(path: Path):
    document = ezdxf.readfile(path)
    audit = document.audit()
    assert not audit.errors
    assert not audit.fixes
    assert document.units == ezdxf.units.MM
    return document


def from_roller(model, points, track, radius):
    """Signed distance of plane points from the nearest of all roller positions: the oracle of a disc's flank."""
    x = np.column_stack([points, np.zeros(len(points))])

    def pose(phi):
        found = track.pose(np.ravel(phi), 0)
        shape = (*np.shape(phi), 3)
        return found.a[0].T.reshape(shape), found.u[0].T.reshape(shape)

    def distance(x, a, u):
        return roller_distance(x, a, u, radius, -1e9)

    return swept_distance(x, pose, distance, 0.0, 2.0 * np.pi, coarse=720, rounds=45)


@pytest.mark.parametrize("deviation", [1e-3, 1e-4])
def test_a_disc_is_drawn_within_the_stated_deviation(tmp_path: Path, deviation: float) -> None:
    model = read(str(PROFILES / "disc_offset_roller.toml"))
    write(model, tmp_path / "cam.dxf", deviation=deviation, chord=0.01)
    document = readable(tmp_path / "cam.dxf")
    track = model.tracks[0]
    radius = 0.5 * model.setup.roller.diameter
    found = {name: (layer, stated, entity) for layer, name, stated, entity in curves(document, "SPLINE")}
    assert set(found) == {"profile", "pitch curve"}
    layer, stated, entity = found["profile"]
    assert layer == "PROFILE_SPLINE"
    assert stated <= deviation
    error = np.abs(from_roller(model, on_spline(entity, 1500), track, radius))
    assert error.max() <= 1.02 * stated + 1e-9
    assert error.max() > 0.5 * stated
    tool = entity.construction_tool()
    assert tool.is_clamped
    assert np.allclose(tool.control_points[0], tool.control_points[-1], atol=1e-12)


def test_the_polyline_is_on_the_curve_and_its_chords_within_the_stated_error(tmp_path: Path) -> None:
    model = read(str(PROFILES / "disc_offset_roller.toml"))
    write(model, tmp_path / "cam.dxf", chord=0.02)
    document = readable(tmp_path / "cam.dxf")
    track, radius = model.tracks[0], 0.5 * model.setup.roller.diameter
    for layer, name, stated, entity in curves(document, "LWPOLYLINE"):
        if name != "profile":
            continue
        assert layer == "PROFILE_POLYLINE"
        assert entity.closed
        assert 0.005 < stated <= 0.02
        corners = np.array(entity.get_points("xy"))
        assert np.abs(from_roller(model, corners, track, radius)).max() < 1e-9
        between = 0.5 * (corners + np.roll(corners, -1, axis=0))
        assert np.abs(from_roller(model, between, track, radius)).max() <= 1.02 * stated
        return
    raise AssertionError("no polyline of the profile")


def test_cutter_paths_lie_at_the_cutter_radius(tmp_path: Path) -> None:
    model = changed("disc_face_groove", "[output]\n", '[cutter]\nkind = "flat"\ndiameter = 24\n[output]\n')
    write(model, tmp_path / "cam.dxf")
    document = readable(tmp_path / "cam.dxf")
    paths = {name: entity for layer, name, _, entity in curves(document, "SPLINE") if layer == "CUTTER_SPLINE"}
    assert len(paths) == 2
    phi = np.linspace(0.0, 2.0 * np.pi, 20001)
    for name, entity in paths.items():
        flank = model.planar.outlines[name.partition(",")[0]].curve(phi).points.T
        for point in on_spline(entity, 40):
            assert np.hypot(*(flank - point).T).min() == pytest.approx(12.0, abs=2e-4)


@pytest.mark.parametrize(("share", "drawn"), [(0.999, True), (1.002, False)])
def test_a_cutter_that_does_not_reach_is_told(tmp_path: Path, share: float, drawn: bool) -> None:
    hollow = read(str(PROFILES / "disc_face_groove.toml")).planar.radii[1].value
    tool = f'[cutter]\nkind = "flat"\ndiameter = {2.0 * share * hollow}\n[output]\n'
    model = changed("disc_face_groove", "[output]\n", tool)
    write(model, tmp_path / "cam.dxf")
    document = readable(tmp_path / "cam.dxf")
    assert any(layer == "CUTTER_SPLINE" for layer, *_ in curves(document, "SPLINE")) == drawn
    assert any("does not reach" in text.text for text in document.modelspace().query("MTEXT")) != drawn


def test_the_bore_with_its_keyway_is_exact(tmp_path: Path) -> None:
    model = read(str(PROFILES / "disc_face_groove.toml"))
    write(model, tmp_path / "cam.dxf")
    document = readable(tmp_path / "cam.dxf")
    (bore,) = document.modelspace().query('LWPOLYLINE[layer=="BORE"]')
    arcs = [part for part in bore.virtual_entities() if part.dxftype() == "ARC"]
    assert len(arcs) == 2
    for arc in arcs:
        assert arc.dxf.radius == pytest.approx(0.5 * model.cam.bore, abs=1e-12)
        assert tuple(arc.dxf.center)[:2] == pytest.approx((0.0, 0.0), abs=1e-12)


def test_what_is_rolled_out_has_the_name_that_measured_points_have(tmp_path: Path) -> None:
    """Both grooves of a drum had the same names, and an end face was called a groove."""
    model = read(str(PROFILES / "two_groove_drum.toml"))
    write(model, tmp_path / "cam.dxf", chord=0.1, deviation=0.01)
    document = readable(tmp_path / "cam.dxf")
    flanks = {name: entity for layer, name, _, entity in curves(document, "LWPOLYLINE") if layer == "FLANK_POLYLINE"}
    assert list(flanks) == [surface.name for surface in flank_surfaces(model)]
    heights = [np.array(list(flanks[f"groove {number} flank -"].vertices()))[:, 1] for number in (1, 2)]
    assert heights[0].max() < heights[1].min()
    write(read(str(PROFILES / "end_face_lifter.toml")), tmp_path / "ring.dxf", chord=0.1, deviation=0.01)
    notes = [text.text for text in readable(tmp_path / "ring.dxf").modelspace().query("MTEXT")]
    assert all(text.startswith("end face rolled out") for text in notes)


@pytest.mark.parametrize("name", ["pin_insertion", "steep_shuttle"])
def test_the_developed_groove_is_the_flank_rolled_out(tmp_path: Path, name: str) -> None:
    model = read(str(PROFILES / f"{name}.toml"))
    write(model, tmp_path / "cam.dxf")
    document = readable(tmp_path / "cam.dxf")
    track, radius = model.cutters[0], model.cam.radius
    origin = np.zeros(2)
    for text in document.modelspace().query("MTEXT"):
        if "outer radius" in text.text:
            line = next(line for line in text.text.split("\\P") if line.startswith("origin"))
            origin = np.array([float(v) for v in line.partition("(")[2].partition(")")[0].split(",")])
    phi = np.linspace(0.3, 5.9, 60)
    seen = 0
    for _, name, stated, entity in curves(document, "SPLINE"):
        if "flank" not in name:
            continue
        points = on_spline(entity) - origin
        if not np.all(np.abs(points[:, 1] - 0.5 * model.cam.length) < 0.6 * model.cam.length):
            continue  # the view at the pitch radius
        # Rolled up again, every point of the line touches the tool's surface where it stands.
        azimuth = points[:, 0] / radius
        x = np.column_stack([radius * np.cos(azimuth), radius * np.sin(azimuth), points[:, 1]])
        side = 1.0 if name.endswith("+") else -1.0
        t = np.array([track.meridian.parameter(track.contact[1])])
        near = Flank(track, phi, t, side).points[:, 0]
        assert np.sqrt(((x[None] - near[:, None]) ** 2).sum(axis=2)).min(axis=1).max() < 3.0

        shape = ("cone", track.meridian.slope, track.meridian.centre)

        def pose(p):
            found = track.pose(np.ravel(p), 0)
            return found.a[0].T.reshape(*np.shape(p), 3), found.u[0].T.reshape(*np.shape(p), 3)

        def distance(x, a, u, shape=shape):
            return roller_distance(x, a, u, track.meridian.radius, 0.0, shape=shape)

        error = np.abs(swept_distance(x[::40], pose, distance, -0.5, 2.0 * np.pi + 0.5, coarse=720, rounds=45))
        assert error.max() <= 1.1 * stated + 1e-9
        seen += 1
    assert seen == 2


@pytest.mark.parametrize(("name", "kind"), [("tool_changer", "LWPOLYLINE"), ("barrel_indexer", "CIRCLE")])
def test_the_turret_has_its_rollers(tmp_path: Path, name: str, kind: str) -> None:
    model = read(str(PROFILES / f"{name}.toml"))
    write(model, tmp_path / "cam.dxf")
    document = readable(tmp_path / "cam.dxf")
    follower = model.setup.follower
    rollers = document.modelspace().query(f'{kind}[layer=="ROLLERS"]')
    assert len(rollers) == follower.count
    pitch = list(document.modelspace().query('CIRCLE[layer=="CENTRE"]'))
    assert pitch[0].dxf.radius == pytest.approx(follower.pitch_radius)
    centre = np.array(tuple(pitch[0].dxf.center)[:2])
    if kind == "CIRCLE":
        places = np.array([tuple(r.dxf.center)[:2] for r in rollers])
    else:
        places = np.array([np.mean(np.array(r.get_points("xy")), axis=0) for r in rollers])
    radii = np.hypot(*(places - centre).T)
    assert np.ptp(radii) < 1e-9
    angles = np.sort(np.arctan2(*(places - centre).T[::-1]))
    assert np.diff(angles) == pytest.approx(2.0 * np.pi / follower.count, abs=1e-12)


def test_a_folded_profile_is_refused_and_the_old_file_stands(tmp_path: Path) -> None:
    old = tmp_path / "cam.dxf"
    old.write_text("old")
    model = flat(cam=f"base_radius = {0.98 * smallest_flat_base(flat().setup.program)}")
    with pytest.raises(ExportError, match=r"cam\.dxf: cannot be drawn: .*the profile folds"):
        write(model, old)
    assert old.read_text() == "old"


def circle(radius: float = 20.0) -> PlaneCurve:
    def at(phi):
        c, s = np.cos(phi), np.sin(phi)
        return radius * np.stack([c, s]), radius * np.stack([-s, c])

    return PlaneCurve("circle", "profile", at, np.linspace(0.0, 2.0 * np.pi, 4))


@pytest.mark.parametrize("deviation", [1e-2, 1e-5, 1e-8])
def test_a_spline_is_as_near_as_it_says_and_not_nearer(deviation: float) -> None:
    spline = fitted(circle(), deviation)
    u = np.linspace(spline.knots[0], spline.knots[-1], 9001)
    measured = np.abs(np.hypot(*spline(u).T) - 20.0).max()
    assert measured <= 1.001 * spline.deviation + 1e-14
    assert measured >= 0.9 * spline.deviation
    assert spline.deviation <= deviation
    assert spline.knots[-1] == pytest.approx(40.0 * np.pi, rel=1e-3)


def test_a_spline_turns_no_corner_at_the_joints() -> None:
    spline = fitted(circle(), 1e-6)
    inner = np.unique(spline.knots)[1:-1]
    before, after = (spline(inner + h) - spline(inner) for h in (-1e-5, 1e-5))
    assert np.abs(before + after).max() < 1e-9


@pytest.mark.parametrize("chord", [0.5, 0.01, 0.0003])
def test_chords_use_their_tolerance(chord: float) -> None:
    line = chords(circle(), chord)
    middles = 0.5 * (line.points + np.roll(line.points, -1, axis=0))
    assert 20.0 - np.hypot(*middles.T).min() == pytest.approx(line.chord_error, rel=1e-6)
    assert 0.7 * chord < line.chord_error <= chord


def test_a_corner_at_a_knot_is_exact(tmp_path: Path) -> None:
    def at(phi):
        return np.stack([np.abs(phi - 1.0), phi**2]), np.stack([np.sign(phi - 1.0), 2.0 * phi])

    spline = fitted(PlaneCurve("corner", "profile", at, np.array([0.0, 1.0, 2.3]), False), 1e-6)
    x, y = spline(np.linspace(spline.knots[0], spline.knots[-1], 5001)).T
    assert np.abs(x - np.abs(np.sqrt(np.maximum(y, 0.0)) - 1.0))[y > 0.01].max() < 1e-4
    corner = np.hypot(*(spline.control - (0.0, 1.0)).T).min()
    assert corner < 1e-11


def test_a_corner_is_met_as_nearly_as_asked() -> None:
    def at(phi):
        return np.stack([np.abs(phi - 1.0), phi]), np.stack([np.sign(phi - 1.0), np.ones_like(phi)])

    spline = fitted(PlaneCurve("corner", "profile", at, np.array([0.0, 2.3]), False), 1e-4)
    x, y = spline(np.linspace(spline.knots[0], spline.knots[-1], 5001)).T
    assert np.abs(x - np.abs(y - 1.0)).max() < 2e-4


def test_a_curve_that_stands_still_is_refused() -> None:
    def at(phi):
        return np.zeros((2, len(phi))), np.zeros((2, len(phi)))

    with pytest.raises(NotConverged, match="stands still"):
        fitted(PlaneCurve("point", "profile", at, np.array([0.0, 1.0]), False), 1e-4)
