"""Figures of profiles that lean: radii and signed pressure angle derived anew from the keys by differences, every key
as of the cylinder where the cone has no angle, layers of the drawing, and one meaning of each figure."""

from __future__ import annotations

from math import cos, radians, tan
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from camgeom.checks import judge
from camgeom.design.planar import PlanarLimits, smallest_base_radius
from camgeom.export.dxf import write_dxf
from camgeom.model import Model, read
from camgeom.report.pictures import on_edge, seen_from
from camgeom.report.result import compute
from camgeom.report.sections.bodies import cam_meshes
from camgeom.report.table_sheet import columns
from tests.places import ROOT
from tests.reference import profiles

DISC, GROOVE, PAIR = "conical_disc", "conical_groove", "conical_pair"
ROUND: dict[str, Any] = {"roller__half_angle": None, "roller__shape": "cylinder"}
PLAIN = {DISC: ROUND, GROOVE: ROUND, PAIR: ROUND | {
    "return_roller__half_angle": None, "return_roller__shape": "cylinder"}}  # fmt: skip
SLIGHT: dict[str, dict[str, Any]] = {DISC: {"roller__half_angle": 1e-7}, GROOVE: {"roller__half_angle": 1e-7}, PAIR: {
    "roller__half_angle": 1e-7, "return_roller__half_angle": -1e-7}}  # fmt: skip


def model(name: str, **keys: Any) -> Model:
    """A shipped profile's, without the taper that goes with its own cone alone."""
    return profiles.model(name, **({"cutter": None} | keys))


def modified_sine(x: np.ndarray) -> np.ndarray:
    k = 1.0 / (4.0 + np.pi)
    ends, middle = np.sin(4 * np.pi * x) / 4, 9 / 4 * np.sin((4 * np.pi * x + np.pi) / 3)
    return np.where(x < 1 / 8, k * (np.pi * x - ends),
                    np.where(x < 7 / 8, k * (2 + np.pi * x - middle), k * (4 + np.pi * x - ends)))  # fmt: skip


def lift(theta: np.ndarray, top: float, corners: tuple[float, float, float, float]) -> np.ndarray:
    a, b, c, d = np.radians(corners)
    up, down = np.clip((theta - a) / (b - a), 0.0, 1.0), np.clip((theta - c) / (d - c), 0.0, 1.0)
    return top * (modified_sine(up) - modified_sine(down))


def centre(name: str, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Roller's centre and the direction in which it moves with the lift, in the machine; the centre in the cam."""
    if name == DISC:
        s = lift(theta, 15.0, (60.0, 160.0, 220.0, 320.0))
        place = np.sqrt(52.0**2 - 5.0**2) + s + 5.0j
        return place, np.ones_like(place), place * np.exp(-1j * theta)
    s = lift(theta, radians(12.0), (50.0, 150.0, 210.0, 320.0))
    start = np.arccos((130.0**2 + 105.0**2 - 72.0**2) / (2 * 130.0 * 105.0))
    arm = 105.0 * np.exp(1j * (np.pi - start - s))
    return 130.0 + arm, -1j * arm / 105.0, (130.0 + arm) * np.exp(1j * theta)


@pytest.mark.parametrize(("name", "lean", "ends", "clearance"), [
    (DISC, 10.0, (-10.0, 10.0), 0.0), (DISC, -7.0, (-10.0, 10.0), 0.0),
    (GROOVE, 8.0, (-8.0, 6.0), 0.03), (GROOVE, -12.0, (-8.0, 6.0), 2.0),
])  # fmt: skip
def test_radii_and_signed_pressure_angle_are_those_of_the_keys(
    name: str, lean: float, ends: tuple[float, float], clearance: float
) -> None:
    keys = {"cam__running_clearance": clearance} if clearance else {}
    flank = compute(model(name, roller__half_angle=lean, **keys), ("flank",)).data["flank"]
    theta, h = np.linspace(0.0, 2.0 * np.pi, 20001)[1:-1], 1e-4
    (_, _, before), (place, way, pitch), (_, _, after) = (centre(name, theta + step) for step in (-h, 0.0, h))
    del place
    first, second = (after - before) / (2 * h), (after - 2 * pitch + before) / h**2
    outward = -1j * first / np.abs(first)
    outward *= np.sign((outward * np.conj(pitch)).real.mean())
    bent = (np.conj(first) * second).imag / np.abs(first) ** 3 * np.sign((first * np.conj(1j * pitch)).real.mean())
    # Beside a jump of curvature the differences straddle it.
    away = np.abs(np.subtract.outer(theta, np.radians((50, 60, 150, 160, 210, 220, 320)))).min(axis=1) > 2e-3
    curved = []
    for z in ends:
        tool = 12.0 + tan(radians(lean)) * z + clearance / cos(radians(lean))
        curved.append(bent / (1.0 - tool * bent))
        if name == GROOVE:
            curved.append(-bent / (1.0 + tool * bent))
    every = np.concatenate([k[away] for k in curved])
    assert flank["min_convex_radius_mm"] == pytest.approx(1.0 / every.max(), rel=2e-3)
    if every.min() < 0.0:
        assert flank["min_hollow_radius_mm"] == pytest.approx(-1.0 / every.min(), rel=2e-3)
    else:
        assert flank["min_hollow_radius_mm"] is None
    turned = outward * np.exp((1j if name == DISC else -1j) * theta)
    level = np.angle(turned / way) * (-1.0 if name == DISC else 1.0)
    steep = np.copysign(np.arccos(np.cos(level) * cos(radians(lean))), level)
    wanted = sorted((float(np.degrees(steep.min())), float(np.degrees(steep.max()))))
    found = flank["pressure_angle_range_deg"]
    mirrored = sorted(-value for value in wanted)
    nearer = min((wanted, mirrored), key=lambda two: abs(two[0] - found[0]))
    assert found == pytest.approx(nearer, abs=2e-3)
    assert max(np.abs(found)) == pytest.approx(flank["max_pressure_angle_deg"], abs=1e-9)


def flat(data: Any, key: str = "") -> dict[str, Any]:
    if isinstance(data, dict):
        return {k: v for name, one in data.items() for k, v in flat(one, f"{key}.{name}").items()}
    if isinstance(data, list):
        return {k: v for i, one in enumerate(data) for k, v in flat(one, f"{key}[{i}]").items()}
    return {key: data}


@pytest.mark.parametrize("name", [DISC, GROOVE, PAIR])
def test_a_cone_of_no_angle_has_every_key_of_the_cylinder(name: str) -> None:
    tables = ("motion", "flank", "contact", "fatigue")
    cone, cylinder = (
        flat({key: compute(model(name, **keys[name]), tables).data[key] for key in tables}) for keys in (SLIGHT, PLAIN)
    )
    assert set(cone) == set(cylinder)
    for key, value in cylinder.items():
        if isinstance(value, float) and not key.endswith(("_deg", "delta_mm")):
            assert cone[key] == pytest.approx(value, rel=1e-5, abs=1e-9), key
        elif not isinstance(value, float):
            assert cone[key] == value, key
    (jumps,) = judge(model(name), ("curvature-jumps",)).findings
    assert jumps.value == judge(model(name, **PLAIN[name]), ("curvature-jumps",)).findings[0].value


DISC_TEXT = (ROOT / "profiles" / "conical_disc.toml").read_text()


def test_a_jump_of_curvature_is_told_of_a_flank_that_leans() -> None:
    flank = compute(read(DISC_TEXT.replace("modified-sine", "parabolic")), ("flank",)).data["flank"]
    assert flank["curvature_jumps_deg"] == pytest.approx([60.0, 110.0, 160.0, 220.0, 270.0, 320.0])


@pytest.mark.parametrize("keys", [{}, ROUND])
def test_the_pressure_angle_of_a_groove_is_that_amid_its_play(keys: dict[str, Any]) -> None:
    """Whatever the clearance, and on both sides of a limit."""
    angles = [model(GROOVE, cam__running_clearance=gap, **keys).pressure_angle for gap in (0.0, 0.3)]
    assert angles[0] is not None
    assert angles[1] is not None
    assert angles[1].value == pytest.approx(angles[0].value, rel=1e-12)
    for share, level in ((1.001, "pass"), (0.999, "fail")):
        limit = {"pressure_angle_deg": float(np.degrees(angles[0].value)) * share}
        tight = model(GROOVE, cam__running_clearance=0.3, limits=limit, **keys)
        assert [one.level for one in judge(tight, ("pressure-angle",)).findings] == [level]


@pytest.mark.parametrize("keys", [{}, PLAIN[PAIR]])
def test_the_peak_force_of_a_pair_is_the_largest_of_both_rollers(keys: dict[str, Any]) -> None:
    """The return roller, smaller, has the larger pressure and the smaller force."""
    contact = compute(model(PAIR, **keys), ("contact",)).data["contact"]
    forces = {roller["name"]: roller["peak_force_n"] for roller in contact["rollers"]}
    assert forces["main"] > 1.05 * forces["return"]
    assert contact["peak_force_n"] == pytest.approx(forces["main"], rel=1e-9)
    assert contact["peak_at"] == "return"


def test_each_end_of_a_leaning_flank_has_a_layer_of_its_own(tmp_path: Any) -> None:
    ezdxf = pytest.importorskip("ezdxf")
    for name, ends in ((DISC, 1), (GROOVE, 2), (PAIR, 2)):
        one = model(name)
        write_dxf(tmp_path / "cam.dxf", one)
        space = ezdxf.readfile(tmp_path / "cam.dxf").modelspace()
        for layer in ("PROFILE_LOWER", "PROFILE_UPPER"):
            assert len(space.query(f'SPLINE[layer=="{layer}_SPLINE"]')) == ends, (name, layer)
            assert len(space.query(f'LWPOLYLINE[layer=="{layer}_POLYLINE"]')) == ends, (name, layer)
        assert not space.query('*[layer=="PROFILE_SPLINE"]')



EDGE = (ROOT / "profiles" / "linear_edge.toml").read_text()


def edge(diameter: float) -> Model:
    return read(EDGE.replace("diameter = 18", f"diameter = {diameter!r}").replace("edge = 32", "edge = 62"))


def test_an_undercut_edge_has_no_figure_of_its_fold() -> None:
    """Just before its cusp the curvature is a number, beyond it none."""
    cusp = brentq(lambda d: edge(d).flanks[0].margin.value, 60.0, 110.0, xtol=1e-6)
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        one = edge(share * cusp)
        (found,) = judge(one, ("relative-curvature",)).findings
        radius = compute(one, ("flank",)).data["flank"]["min_relative_radius_mm"]
        assert found.level == level
        if level == "pass":
            assert radius == pytest.approx(0.0005 * share * cusp, rel=1e-4)
        else:
            assert found.value is None
            assert radius == 0.0
            (pressure,) = judge(one, ("contact-pressure",)).findings
            assert (pressure.level, pressure.value) == ("fail", None)
            assert "see undercut" in pressure.advice


STIFF = '\n[dynamics]\nkind = "follower"\nlinkage_stiffness = 1e6\n'


def test_steps_of_friction_on_a_mode_that_nothing_damps_are_no_resonance_to_keep_off() -> None:
    bare = judge(read(EDGE + STIFF), ("resonance",))
    assert not bare.findings
    assert "give [dynamics] its damping" in bare.not_judged[0].reason
    for text in (EDGE + STIFF + "linkage_damping = 1000\n", EDGE.replace("friction = 12", "friction = 0") + STIFF):
        assert [one.level for one in judge(read(text), ("resonance",)).findings] == ["pass"]


@pytest.mark.parametrize(("name", "label", "radius"), [
    (DISC, "R", 40.0), (GROOVE, "inner flank R", 60.0), (PAIR, "main R", 80.0),
])  # fmt: skip
def test_a_shop_s_table_has_the_profile_half_way_up_a_flank_that_leans(name: str, label: str, radius: float) -> None:
    """The base radius is that of the roller's middle; a groove's foot is 2 mm below its roller, clear by 0.03 mm."""
    found = {column[0]: column[2] for column in columns(model(name))}
    away = tan(radians(8.0)) - 0.03 / cos(radians(8.0)) if name == GROOVE else 0.0
    assert found[label][0] == pytest.approx(radius + away, abs=1e-9)
    assert len(found) == len(columns(model(name, **PLAIN[name])))


@pytest.mark.parametrize(("limit", "value", "wanted"), [
    ("max_pressure_angle_deg", 34.0, PlanarLimits(pressure_angle_deg=34.0, convex_radius_mm=None)),
    ("min_convex_radius_mm", 25.0, PlanarLimits(convex_radius_mm=25.0)),
])  # fmt: skip
def test_the_smallest_base_radius_of_a_cone_keeps_its_limit_and_no_smaller_one_does(
    limit: str, value: float, wanted: PlanarLimits
) -> None:
    keys = {"cam__bore": 0.0, "cam__keyway_width": 0.0, "cam__keyway_depth": 0.0}
    least = smallest_base_radius(model(DISC, **keys).profile, wanted, 5.0, 120.0)
    found = [compute(model(DISC, cam__base_radius=share * least, **keys), ("flank",)).data["flank"][limit]
             for share in (0.998, 1.0, 1.002)]  # fmt: skip
    assert found[1] == pytest.approx(value, rel=1e-9)
    assert (found[0] - value) * (found[2] - value) < 0.0


def test_the_edge_of_a_plate_is_seen_from_its_side() -> None:
    one = edge(18.0)
    assert on_edge(one)
    assert seen_from(cam_meshes(one), edge=True)[1] > 0.0
    assert seen_from(cam_meshes(one))[1] < 0.0
