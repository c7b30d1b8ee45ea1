"""A roller of real length over the turn: tilt, ends, run-out; what is judged of it and what never is."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from camgeom.body.load import RollerForce
from camgeom.checks import judge, squared_remedy
from camgeom.errors import ProfileError
from camgeom.maths.panels import panels
from camgeom.mechanics import finite_turn
from camgeom.mechanics.finite_contact import INSIDE, AxialProfile, Bodies, press
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.model import Model, read
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.report.files import write
from camgeom.report.result import compute
from tests.places import PROFILES

CYLINDER = {"shape": "cylinder", "crown_radius": None}
LOGARITHMIC = {"crown": "logarithmic", "crown_radius": None}


def data(name: str, **roller: Any) -> dict[str, Any]:
    found, _, _ = load((PROFILES / f"{name}.toml").read_text(), name)
    for key, value in roller.items():
        if value is None:
            found["roller"].pop(key, None)
        else:
            found["roller"][key] = value
    return found


@cache
def kept(name: str, roller: tuple[tuple[str, Any], ...], life_h: float | None, pressure: float | None) -> Model:
    found = data(name, **dict(roller))
    found["limits"] = {**found.get("limits", {}), **({"life_h": life_h} if life_h else {})}
    if pressure is not None:
        found["limits"]["contact_pressure_mpa"] = pressure
    return Model(from_data(found, name))


def made(name: str = "disc_offset_roller", life_h: float | None = 1000.0, pressure: float | None = None,
         **roller: Any) -> Model:
    return kept(name, tuple(roller.items()), life_h, pressure)


def said(model: Model, check: str) -> tuple[list[str], list[str]]:
    """Levels of the findings of a check, and the reasons why it was not judged."""
    verdict = judge(model, [check])
    return [found.level for found in verdict.findings], [one.reason for one in verdict.not_judged]


def test_what_is_not_stated_stays_the_exact_line_or_ellipse() -> None:
    assert made().duty.level == "ellipse"
    assert made(**CYLINDER).duty.level == "line"
    assert made("pin_insertion").duty.level == "line"
    assert made("pin_insertion").duty.finite is None


def test_a_tilt_moves_the_ellipse_of_a_crown_and_nothing_else() -> None:
    plain, tilted, back = made().duty, made(misalignment_deg=0.1).duty, made(misalignment_deg=-0.1).duty
    assert tilted.level == "ellipse"
    assert tilted.peak_pressure.value == pytest.approx(plain.peak_pressure.value, rel=1e-12)
    moved = 500.0 * np.sin(np.radians(0.1))
    assert tilted.peak_pressure.place - plain.peak_pressure.place == pytest.approx(moved, rel=1e-9)
    assert back.peak_pressure.place - plain.peak_pressure.place == pytest.approx(-moved, rel=1e-9)
    assert tilted.lives == pytest.approx(plain.lives, rel=1e-9)
    assert tilted.crowned.room.min() == pytest.approx(6.0 - moved, rel=1e-9)
    assert tilted.deepest_shear.place == pytest.approx(tilted.peak_pressure.place)


@pytest.mark.parametrize("roller", [{**CYLINDER, "misalignment_deg": 0.02}, {"crown_radius": 1e5},
                                    {"misalignment_deg": 0.7}])  # fmt: skip
def test_a_sharp_end_that_bears_gets_no_peak_no_life_and_no_pass(roller: dict[str, Any]) -> None:
    model = made(**roller)
    duty = model.duty
    assert duty.level == "finite"
    assert duty.peak_pressure is None
    assert duty.peak_contact is None
    assert duty.deepest_shear is None
    assert set(duty.lives) == {"bearing"}
    for check, levels in (("contact-pressure", []), ("life", ["pass"])):
        found, reasons = said(model, check)
        assert found == levels, "of the bearing alone"
        assert len(reasons) == 1
        assert "unbounded at the sharp end" in reasons[0]
        assert "roller.end_radius" in reasons[0]
    result = compute(model, ("contact", "fatigue")).data
    assert "peak_pressure_mpa" not in result["contact"]
    assert "peak_slice_pressure_mpa" not in result["contact"]
    assert not any(key.endswith("life_h") and "bearing" not in key for key in result["fatigue"])
    assert result["contact"]["inside_pressure_mpa"] > 300.0
    end = duty.finite.hardest[1].bodies.profile.high
    assert abs(duty.least_peak.place - 7.0) <= end - INSIDE + 1e-9


@pytest.mark.parametrize(("factor", "level"), [(0.999, "fail"), (1.002, "")])
def test_it_fails_where_already_half_a_millimetre_inside_is_too_much(factor: float, level: str) -> None:
    roller = {**CYLINDER, "misalignment_deg": 0.02}
    inside = made(**roller).duty.least_peak.value
    found, reasons = said(made(pressure=factor * inside, **roller), "contact-pressure")
    assert found == ([level] if level else [])
    assert bool(reasons) == (not level)


def test_a_case_is_too_thin_where_already_the_shear_inside_a_sharp_end_lies_deeper() -> None:
    """Of a line under the pressure half a millimetre inside; what lies at the end itself nobody knows."""
    found = data("disc_offset_roller", **CYLINDER, misalignment_deg=0.02)
    duty = Model(from_data(found, "")).duty
    assert duty.deepest_shear is None
    bodies = duty.finite.hardest[1].bodies
    half = 2.0 * duty.least_peak.value * bodies.compliance / bodies.curvature
    assert duty.least_shear.value == pytest.approx(0.786 * half, rel=1e-3)
    for body, share in (("cam", 0.999), ("roller", 1.002)):
        found["material"].setdefault(body, {})["case_depth_mm"] = 2.0 * share * duty.least_shear.value
    verdict = judge(Model(from_data(found, "")), ["case-depth"])
    assert [(one.level, one.where[:4]) for one in verdict.findings] == [("fail", "cam,")]
    assert len(verdict.not_judged) == 1


RETURN = """
[return_roller]
shape = "crowned"
crown = "logarithmic"
diameter = 40
length = 20
misalignment_deg = 0.1
"""


@pytest.fixture(scope="module")
def tilted_return() -> str:
    text = (PROFILES / "conjugate_rocker.toml").read_text(encoding="utf-8")
    return text[: text.index("[impact]")] + RETURN


@pytest.mark.parametrize(("pressure", "life", "tilt"), [(1300.0, 12000.0, True), (1290.0, 13000.0, False)])
def test_advice_names_the_tilt_where_it_is_the_cause(
    tilted_return: str, pressure: float, life: float, tilt: bool
) -> None:
    """Square the return roller presses with 1 298.5 MPa and lasts 12 532 h, tilted with 1 448.5 and 6 503."""
    model = read(f"{tilted_return}[limits]\ncontact_pressure_mpa = {pressure}\nlife_h = {life}\n")
    found = judge(model, ["contact-pressure", "life"]).findings
    assert [one.level for one in found] == ["fail"] * 3
    words = "a smaller return_roller.misalignment_deg: without it"
    assert [one.advice.startswith(words) for one in found] == [tilt] * 3


def test_where_square_rollers_have_no_life_their_tilt_is_not_blamed(
    tilted_return: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Under the little that is left without tilt the pressure at a nearly sharp end may not be known."""
    model = read(f"{tilted_return}[limits]\nlife_h = 12000\n")
    monkeypatch.setattr(Model, "square_lives", {})
    found = judge(model, ["life"]).findings
    assert [one.level for one in found] == ["fail"] * 2
    assert not any("without it" in one.advice for one in found)


def test_advice_about_tilt_solves_one_contact_and_no_turn(tilted_return: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Square the hardest contact presses with nearly what the hardest of a turn of square rollers presses with."""
    duty = next(one for one in read(tilted_return).carriers if one.squared is not None)
    assert duty.square_spot == pytest.approx(duty.squared[1].least_peak.value, rel=0.01)
    words = f"the roller presses there with {duty.square_spot:.6g} MPa"
    monkeypatch.setattr(finite_turn, "PressureTable", None)
    assert squared_remedy(duty, duty.square_spot * 0.999) == ""
    assert squared_remedy(duty, duty.square_spot * 1.001).endswith(words)


@pytest.mark.parametrize("name", ["disc_offset_roller", "conical_disc", "linear_edge"])
def test_the_tilt_of_a_roller_with_sharp_ends_is_blamed_where_its_line_alone_would_pass(name: str) -> None:
    """Without the tilt its profile is rated by the line, whose ends press no more than the middle."""
    plain = CYLINDER if name == "disc_offset_roller" else {}
    tilted, square = made(name, **plain, misalignment_deg=0.05).duty, made(name, **plain).duty
    assert (tilted.level, square.level) == ("finite", "line")
    alone = square._at(square.hardest_pressure, tilted.least_peak.cam_angle)
    for share, blamed in ((0.999, False), (1.001, True)):
        model = made(name, pressure=share * alone, **plain, misalignment_deg=0.05)
        (found,) = judge(model, ["contact-pressure"]).findings
        assert found.level == "fail"
        assert found.advice.startswith("a smaller roller.misalignment_deg: without it") == blamed


def test_a_sharp_end_is_told_by_the_table_of_its_roller(tilted_return: str) -> None:
    _, reasons = said(read(tilted_return.replace('shape = "crowned"\ncrown = "logarithmic"\n', "")), "contact-pressure")
    assert len(reasons) == 1
    assert "give return_roller.end_radius" in reasons[0]


def test_a_crown_s_advice_names_the_tilt_where_it_is_the_cause() -> None:
    (tilted,), (strong,) = (judge(made(**keys), ["crown-length"]).findings
                            for keys in ({"misalignment_deg": 0.7}, {"crown_radius": 1e5}))  # fmt: skip
    assert (tilted.level, strong.level) == ("warn", "warn")
    assert "use a smaller roller.misalignment_deg, a stronger crown (a smaller roller.crown_radius)" in tilted.advice
    assert "misalignment" not in strong.advice


@pytest.mark.parametrize("roller", [{**CYLINDER, "misalignment_deg": 0.02, "end_radius": 1.0},
                                    {**LOGARITHMIC, "misalignment_deg": 0.05}])  # fmt: skip
def test_ends_that_run_out_are_judged_by_their_peak(roller: dict[str, Any]) -> None:
    """Both sides of the limit; the peak is that of the half-space at the hardest angle, its error stated."""
    duty = made(**roller).duty
    peak = duty.peak_pressure
    k = duty.force.panels.at(duty.pressing.reference.behind, np.array([peak.cam_angle]))[0]
    force = duty.force.panels.at(np.abs(duty.normal), np.array([peak.cam_angle]))[0]
    patch = duty.finite.hardest[1]
    assert (patch.bodies.curvature, patch.load) == pytest.approx((k, force), rel=1e-9)
    assert press(patch.bodies, force, 96, 96, 192).peak[0] == pytest.approx(peak.value, rel=4e-3)
    assert duty.contact_data()["peak_pressure_error"] < 5e-3
    assert duty.slices.pressure.max() == pytest.approx(peak.value, rel=3e-3)
    for factor, level in ((1.002, "pass"), (0.999, "fail")):
        found, reasons = said(made(pressure=factor * peak.value, **roller), "contact-pressure")
        assert (found, reasons) == ([level], [])
    life = duty.lives["roller"]
    for factor, level in ((0.999, "pass"), (1.002, "fail")):
        assert said(made(life_h=factor * life, **roller), "life")[0][0] == level


@pytest.mark.parametrize("roller", [{**CYLINDER, "misalignment_deg": 0.02, "end_radius": 1.0}, LOGARITHMIC])
def test_the_table_is_the_half_space_at_every_angle(roller: dict[str, Any]) -> None:
    """Where the load is a third of the largest and more; below it what is damaged does not count."""
    duty = made(**roller).duty
    turn = duty.finite
    (bodies,) = turn.walls.values()
    load = np.abs(duty.normal)
    for at in np.argwhere(load > 0.35 * load.max())[::37]:
        p, n = int(at[0]), int(at[1])
        solved = press(replace(bodies, curvature=float(turn.curvature[p, n])), float(load[p, n]))
        assert np.sqrt(turn.squares[:, p, n].max()) == pytest.approx(solved.peak[0], rel=1.5e-2)


def test_the_table_is_solved_only_where_loads_and_curvatures_go_together() -> None:
    bodies = Bodies(0.02, AxialProfile(-5.0, 5.0, end_radius=1.0), 1e-5, 1e-4)
    load, curvature = np.linspace(20.0, 1000.0, 300), np.geomspace(0.1, 0.005, 300)
    edges = np.linspace(-5.0, 5.0, 12)
    table = finite_turn.PressureTable(bodies, load, curvature, edges, cells=(16, 24, 32))
    told = table.pressures(load, curvature)
    known = ~np.isnan(table.values).any(axis=-1)
    assert 0 < known.sum() < 0.6 * known.size
    table.fill(np.ones(known.shape, dtype=bool))
    assert not np.isnan(table.values).any()
    assert np.array_equal(table.pressures(load, curvature), told)


def test_curvatures_that_differ_by_rounding_alone_are_one() -> None:
    bodies, edges = Bodies(0.02, AxialProfile(-5.0, 5.0, end_radius=1.0), 1e-5, 1e-4), np.linspace(-5.0, 5.0, 12)
    load = np.linspace(500.0, 1000.0, 30)
    told = []
    for noise in (0.0, 1e-14):
        curvature = 0.02 * (1.0 + noise * np.linspace(-1.0, 1.0, 30))
        table = finite_turn.PressureTable(bodies, load, curvature, edges, cells=(16, 24, 32))
        assert len(table.bends) == 1
        told.append(table.pressures(load, curvature))
    assert np.array_equal(*told)


def test_walls_that_ask_for_the_same_contacts_share_them() -> None:
    load, curvature, edges = np.linspace(500.0, 1000.0, 30), np.full(30, 0.02), np.linspace(-5.0, 5.0, 12)
    told = []
    for tilt, noise in ((2e-4, 0.0), (-2e-4, 1e-14)):
        bodies = Bodies(0.02, AxialProfile(-5.0, 5.0, end_radius=1.0), 1e-5, tilt, growth=1e-18 * tilt)
        table = finite_turn.PressureTable(
            bodies, load * (1.0 + noise), curvature, edges, np.linspace(-1e-22, 1e-22, 30), cells=(16, 24, 32)
        )
        assert len(table.leans) == 1
        missed = press.cache_info().misses
        told.append(table.pressures(load, curvature))
        assert (press.cache_info().misses > missed) == (tilt > 0.0)
    assert told[0] == pytest.approx(told[1][::-1], rel=1e-12)
    assert told[0][0].max() > told[0][-1].max()


def test_where_the_force_jumps_its_harder_side_is_the_hardest() -> None:
    """The rise of this cam ends with a jump of the force, down from 402.7 N to 377.7 N, at 120 degrees."""
    duty = made("misaligned_roller").duty
    angles, peak = duty.force.panels, duty.peak_pressure
    assert np.degrees(peak.cam_angle) == pytest.approx(120.0)
    before, after = angles.at(np.abs(duty.normal), np.radians([120.0 - 1e-6, 120.0]))
    assert (before, after) == (pytest.approx(402.73, rel=1e-4), pytest.approx(377.73, rel=1e-4))
    assert duty.finite.hardest[1].load == pytest.approx(before, rel=1e-6)
    pressed = RollerForce(duty).points(None)
    assert np.linalg.norm(pressed.forces.sum(axis=0)) == pytest.approx(before, rel=1e-6)
    (bodies,) = duty.finite.walls.values()
    here = replace(bodies, curvature=float(angles.at(duty.finite.curvature, np.radians(119.0))[0]))
    least = press(here, float(angles.at(np.abs(duty.normal), np.radians(119.0))[0])).peak[0]
    assert least < peak.value < 1.001 * least
    assert np.sqrt(duty.finite.squares.max()) == pytest.approx(peak.value, rel=1e-3)


@pytest.mark.parametrize(("left", "right"), [(3.0, 2.0), (2.0, 3.0)])
def test_a_limit_is_that_of_the_harder_side(left: float, right: float) -> None:
    where = panels([0.0, 1.0, 2.0])
    judged = np.where(where.theta < 1.0, left, right)
    values = np.stack([where.theta + 10.0 * (where.theta > 1.0), -judged])
    assert where.harder(0.4, judged) == 0.4
    for angle in (1.0, np.nextafter(1.0, 0.0), np.nextafter(1.0, 2.0)):
        assert where.at(judged, where.harder(angle, judged)) == pytest.approx(3.0)
        assert where.limit(values, angle, judged) == pytest.approx([1.0 if left > right else 11.0, -3.0], abs=1e-12)
    assert where.limit(values, 0.5, judged) == pytest.approx([0.5, -left], abs=1e-12)


def test_tilt_presses_the_end_that_it_names_on_either_wall() -> None:
    """Of a groove's roller a tilt presses one end on the wall behind and the other on the wall ahead."""
    for way in (1.0, -1.0):
        duty = made("pin_insertion", misalignment_deg=0.01 * way, end_radius=1.0).duty
        slices, places = duty.slices, duty.slice_places[:, 0, 0]
        middle = 0.5 * (places[0] + places[-1])
        behind, ahead = (np.maximum(square, 0.0).max(axis=(1, 2)) for square in (slices.behind, slices.ahead))
        assert way * (places[int(behind.argmax())] - middle) > 5.0
        assert way * (places[int(ahead.argmax())] - middle) < -5.0


def test_rounder_ends_and_less_tilt_are_softer() -> None:
    peaks = [made(**CYLINDER, misalignment_deg=tilt, end_radius=end).duty.peak_pressure.value
             for tilt, end in ((0.02, 2.0), (0.02, 1.0), (0.04, 1.0))]  # fmt: skip
    assert peaks[0] < peaks[1] < peaks[2]
    free = made(**CYLINDER, misalignment_deg=0.02, end_radius=1.0, free_ends="mirrored").duty
    assert free.peak_pressure.value < peaks[1]


def test_stiffness_of_an_exact_ellipse_is_the_half_spaces() -> None:
    """Hertz: approach as load^(2/3), so that the tangent is 3/2 of the secant; a line's is nearer to it."""
    patch = made(**LOGARITHMIC).duty.finite.stiffness
    assert 1.2 < patch.tangent / patch.secant < 1.55
    line = made(**CYLINDER, end_radius=1.0).duty.finite.stiffness
    assert 1.0 < line.tangent / line.secant < 1.2
    assert line.tangent > patch.tangent


def test_the_level_is_told_and_the_shear_lies_below_the_peak() -> None:
    duty = made(**LOGARITHMIC).duty
    shown = duty.contact_data()
    assert shown["contact_level"] == "finite"
    assert shown["peak_shear_mpa"] / shown["peak_slice_pressure_mpa"] == pytest.approx(0.305, abs=0.01)
    assert shown["shear_depth_mm"] / shown["half_width_mm"] == pytest.approx(0.78, abs=0.02)
    assert shown["load_centre_mm"] == pytest.approx(7.0, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "roller", "reason"),
    [
        ("tool_changer", {"free_ends": "mirrored"}, r"roller\.free_ends.*misalignment_deg"),
        ("pin_insertion", {"free_ends": "mirrored"}, r"roller\.free_ends"),
        ("disc_offset_roller", {**LOGARITHMIC, "free_ends": "mirrored"}, r"roller\.free_ends.*no end of a logarithmic"),
        ("disc_offset_roller", {"crown": "logarithmic"}, r"crown_radius: only crown = 'circular'"),
        ("disc_offset_roller", {"crown_radius": None}, r"crown_radius is missing"),
        ("disc_offset_roller", {**LOGARITHMIC, "end_radius": 0.5}, r"end_radius: a logarithmic run-out"),
        ("disc_offset_roller", {**LOGARITHMIC, "flank": "conforming"}, r"conforming"),
        ("disc_offset_roller", {"crown_factor": 0.001}, r"crown_factor: only crown = 'logarithmic'"),
        ("disc_offset_roller", {"misalignment_deg": 1.5}, r"misalignment_deg"),
    ],
)
def test_what_means_nothing_is_refused_by_name(name: str, roller: dict[str, Any], reason: str) -> None:
    with pytest.raises(ProfileError, match=reason):
        from_data(data(name, **roller), name)


def test_free_ends_of_a_crown_are_warned_of_where_none_bears() -> None:
    """The arc of 100 mm keeps its ellipse within the roller; one of 50 m does not, and its ends bear."""
    assert said(made(free_ends="mirrored"), "free-ends") == (["warn"], [])
    assert said(made(), "free-ends") == ([], [])
    bearing = made(crown_radius=50000.0, end_radius=0.5, free_ends="mirrored")
    assert bearing.duty.level == "finite"
    assert said(bearing, "free-ends") == ([], [])


def test_duties_are_what_checks_take() -> None:
    assert isinstance(made().carrier, RollerDuty)
    assert made().carrier.no_stress == ""
    assert made().carrier.least_peak == made().duty.peak_pressure


def test_the_wall_of_a_planar_cam_is_coloured_where_it_is_pressed(tmp_path) -> None:
    """Not over all of its height: in rows along the ellipse, the largest its peak; the surface stays as it was."""
    pyvista = pytest.importorskip("pyvista")
    for roller, top, half in (({}, 754.44, 1.48), (CYLINDER, 304.6, 6.0)):
        model = made(**roller)
        write(model, tmp_path / "cam.vtu")
        grid = pyvista.read(tmp_path / "cam.vtu")
        pressure, z = grid.point_data["contact_pressure_mpa"], grid.points[:, 2]
        assert pressure.max() == pytest.approx(top, rel=1e-3)
        pressed = z[pressure > 1e-3 * top]
        assert np.ptp(pressed) == pytest.approx(2.0 * half, rel=0.14)
        assert np.ptp(z) == pytest.approx(14.0)
        a, b, c = (np.asarray(grid.points[corner]) for corner in grid.cell_connectivity.reshape(-1, 3).T)
        volume = float(np.einsum("fi,fi->", a, np.cross(b, c))) / 6.0
        assert volume == pytest.approx(model.solid.mesh.volume, rel=1e-9)


def test_pressure_between_angles_and_places_is_the_ellipse() -> None:
    duty = made(misalignment_deg=0.1).duty
    peak = duty.peak_pressure
    angle, along = np.array([peak.cam_angle]), duty._at(duty.crowned.ellipse.along, peak.cam_angle)
    places = peak.place + along * np.array([-1.01, -0.6, 0.0, 0.8, 1.01])
    shares = duty.pressure_at(angle, places)[0] / peak.value
    assert shares == pytest.approx([0.0, 0.8, 1.0, 0.6, 0.0], abs=1e-6)
    assert duty.pressure_at(angle, places, -1).max() == 0.0
    x, y, patch = duty.patch((41, 21))
    assert patch.max() == pytest.approx(peak.value, rel=1e-9)
    area = (x[1] - x[0]) * (y[1] - y[0])
    assert patch.sum() * area == pytest.approx(duty._at(np.abs(duty.normal), peak.cam_angle), rel=2e-2)
    finite = made(**LOGARITHMIC, misalignment_deg=0.05).duty
    x, y, patch = finite.patch((160, 81))
    area = (x[1] - x[0]) * (y[1] - y[0])
    assert patch.sum() * area == pytest.approx(finite.finite.hardest[1].load, rel=2e-2)


def test_stiffness_of_line_and_ellipse_is_their_approach_by_load() -> None:
    ellipse, line = made().duty.stiffness, made(**CYLINDER).duty.stiffness
    assert ellipse.tangent / ellipse.secant == pytest.approx(1.5)
    assert 1.05 < line.tangent / line.secant < 1.1
    run_out = made(**LOGARITHMIC).duty.stiffness
    assert ellipse.tangent < run_out.tangent < line.tangent


def test_a_peak_that_is_not_known_is_not_passed(monkeypatch: pytest.MonkeyPatch) -> None:
    """What its own grid leaves open is as a sharp end: not judged, and failed by what is surely reached."""
    monkeypatch.setattr(finite_turn, "KNOWN", 1e-6)
    monkeypatch.setattr(finite_turn, "FINER", finite_turn.FINE)
    roller = {**CYLINDER, "misalignment_deg": 0.02, "end_radius": 1.0, "diameter": 22.0}
    model = Model(from_data(data("disc_offset_roller", **roller), "disc"))
    assert model.duty.finite.unknown
    assert model.duty.peak_pressure is None
    assert set(model.duty.lives) == {"bearing"}
    found, reasons = said(model, "contact-pressure")
    assert found == []
    assert "nearly sharp" in reasons[0]
    sure = model.duty.least_peak.value
    hard = data("disc_offset_roller", **roller)
    hard["limits"] |= {"contact_pressure_mpa": 0.999 * sure}
    assert said(Model(from_data(hard, "disc")), "contact-pressure")[0] == ["fail"]
