"""Stress at a groove's root: nominal over the turn, the peak of two meshes, and the check that judges them."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from camgeom.body import bending, solver, stress
from camgeom.body.cut import cut_of
from camgeom.body.element import elasticity
from camgeom.body.groove import groove_of
from camgeom.body.load import LoadPatch, nodal_forces
from camgeom.body.rib import RibSection
from camgeom.body.ring import even_planes, ring_about, ring_of
from camgeom.body.section import Fineness, GroovedSection
from camgeom.body.solver import elastic
from camgeom.body.stress import PressedRing, RootStress, StressPeak
from camgeom.checks import judge
from camgeom.checks.root import _harder as harder
from camgeom.drawing.content import Map
from camgeom.errors import NotConverged, ProfileError
from camgeom.model import Model
from camgeom.profile import from_data, read_data
from camgeom.report.measured import measure
from camgeom.report.result import chosen, compute
from camgeom.report.sections.body import body
from camgeom.solid.drum import RibbedCylinder
from camgeom.track import TURN
from tests.body.ribs import ribbed
from tests.places import PROFILES
from tests.reference.profiles import built, data_of


def pin(root: float = 1.0, limit: float | None = 400.0, **cam: Any) -> Model:
    data = read_data(PROFILES / "pin_insertion.toml")
    steel = {**data["material"]["cam"]} | ({"bending_limit": limit} if limit is not None else {})
    cam = {**data["cam"], "root_radius": root, **cam}
    return Model(from_data({**data, "cam": cam, "material": {**data["material"], "cam": steel}}))


def plate(**cam: Any) -> Model:
    data = read_data(PROFILES / "disc_face_groove.toml")
    steel = {"elastic_modulus": 210000.0, "poisson": 0.3, "bending_limit": 400.0}
    material = {**data.get("material", {}), "cam": steel}
    return Model(from_data({**data, "cam": {**data["cam"], "root_radius": 1.0, **cam}, "material": material}))


def known(model: Model, nominal: float, *peaks: float) -> Model:
    """The model with these stresses in place of computed ones."""
    found = model.root_stress
    assert isinstance(found, RootStress)
    curve = np.zeros(stress.ANGLES)
    curve[60] = nominal
    theta = np.linspace(0.0, TURN, stress.ANGLES, endpoint=False)
    vars(found).update(theta=theta, nominal=curve, peaks=tuple(StressPeak(value, np.zeros(3), 1000) for value in peaks))
    return model


@pytest.mark.parametrize(
    ("peaks", "nominal", "level"),
    [
        ((401.0, 0.999 * 400.0), 20.0, "pass"),
        ((401.0, 1.002 * 400.0), 20.0, "fail"),
        ((300.0, 390.0), 20.0, "not judged"),
        ((), 20.0, "not judged"),
        ((), 0.999 * 400.0, "not judged"),
        ((), 1.002 * 400.0, "fail"),
        ((300.0, 390.0), 1.002 * 400.0, "fail"),
    ],
)  # fmt: skip
def test_the_root_is_judged_by_its_peak_and_can_fail_by_its_nominal_stress(
    peaks: tuple[float, ...], nominal: float, level: str
) -> None:
    verdict = judge(known(pin(root=1.0 if peaks else 0.0), nominal, *peaks), ["root-stress"])
    if level == "not judged":
        assert not verdict.findings
        assert "nominal stress" in verdict.not_judged[0].reason
    else:
        (finding,) = verdict.findings
        assert (finding.level, finding.limit, finding.unit) == (level, 400.0, "MPa")
        assert "flank" in finding.where


def test_a_plate_with_a_groove_is_judged_alike_and_without_a_bore_not_at_all() -> None:
    for peak, level in ((0.999 * 400.0, "pass"), (1.002 * 400.0, "fail")):
        model = known(plate(), 20.0, 401.0, peak)
        assert model.root_stress is not None
        vars(model.root_stress).update(nominal=np.full(stress.ANGLES, 20.0))
        (finding,) = judge(model, ["root-stress"]).findings
        assert (finding.level, finding.where) == (level, "root of the outer flank")
    verdict = judge(plate(bore=0.0, keyway_width=0.0, keyway_depth=0.0), ["root-stress"])
    assert not verdict.findings
    assert "no bore" in verdict.not_judged[0].reason


def test_a_peak_under_another_load_than_the_hardest_can_fail_and_not_pass() -> None:
    for peak, level in ((300.0, ""), (401.0, "fail")):
        model = known(pin(), 20.0, peak, peak)
        found = model.root_stress
        assert found is not None
        curve = np.array(found.nominal)
        curve[69] = 22.0
        vars(found).update(nominal=curve)
        verdict = judge(model, ["root-stress"])
        assert [finding.level for finding in verdict.findings] == ([level] if level else [])
        assert level or "load_angle_deg" in verdict.not_judged[0].reason


def test_the_result_has_the_figures_where_a_limit_is_given_or_they_are_asked_for() -> None:
    data = compute(known(pin(), 20.0, 119.0, 118.0), ("contact",)).data["body"]
    assert data["peak_stress_mpa"] == 118.0
    assert data["fatigue_factor"] == pytest.approx(400.0 / 118.0)
    assert (data["nominal_stress_mpa"], data["nominal_at_deg"]) == (20.0, 300.0)
    without = pin(limit=None)
    assert "body" not in compute(without, ("contact",)).data
    assert not judge(without, ["root-stress"]).findings
    assert compute(known(without, 20.0, 119.0, 118.0), ("body",)).data["body"]["peak_stress_mpa"] == 118.0
    reasons = compute(known(pin(0.0), 20.0), ("body",)).data["body"]
    assert reasons["peak_stress_mpa"] is None
    assert "sharp root" in reasons["no_peak"]


def test_a_round_root_without_a_limit_is_not_judged_and_a_body_that_is_asked_for_is() -> None:
    for root, told in ((1.0, True), (0.0, False)):
        verdict = judge(pin(root, limit=None), ["root-stress"])
        assert not verdict.findings
        assert ["material.cam.bending_limit" in word.reason for word in verdict.not_judged] == [True] * told
    assert chosen("solve", ["body"]) == (("body", "checks"), ("root-stress",))
    assert chosen("solve", ["contact"]) == (("contact",), None)
    products, checks = chosen("solve", ["body"])
    for peak, level in ((0.999 * 400.0, "pass"), (1.002 * 400.0, "fail")):
        assert compute(known(pin(), 20.0, peak, peak), products, checks).data["verdict"] == level


@pytest.mark.parametrize(
    ("name", "key"), [("tool_changer", "cam"), ("disc_flat_face", "cam"), ("pin_insertion", "roller")]
)
def test_a_limit_that_nothing_reads_is_refused(name: str, key: str) -> None:
    data = read_data(PROFILES / f"{name}.toml")
    material = {**data.get("material", {})}
    material[key] = {**material.get(key, {}), "bending_limit": 300.0}
    with pytest.raises(ProfileError, match="bending_limit"):
        from_data({**data, "material": material})


def test_the_ring_of_an_end_face_is_judged_by_its_nominal_stress_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stress, "ANGLES", 24)
    data = read_data(PROFILES / "end_face_lifter.toml")
    steel = {**data.get("material", {}).get("cam", {}), "bending_limit": 100.0}
    model = Model(from_data({**data, "material": {**data.get("material", {}), "cam": steel}}))
    found = model.root_stress
    assert found is not None
    assert found.nominal.max() > 0.0
    assert isinstance(found.body, PressedRing)
    section, patch = found.body.ring.section, found.body.patches[min(found.body.patches)][0]
    ring = ring_of(section, even_planes(72))
    radius = np.hypot(ring.nodes[:, 0], ring.nodes[:, 1])
    inner, outer = (float(r) for r in (model.parts[0].inner, model.parts[0].outer))  # type: ignore[attr-defined]
    moved = np.zeros_like(ring.nodes)
    # Pulled by 100 MPa and bent by 60 MPa, which the linearised stress is made of.
    moved[:, 2] = ring.nodes[:, 2] * (100.0 + 120.0 * (radius - 0.5 * (inner + outer)) / (outer - inner)) / 200000.0
    shown = found.body.ring.nominal(ring, moved, patch, elasticity(200000.0, 0.0))
    assert shown == pytest.approx(160.0, rel=0.01)
    for limit, level in ((0.999, "fail"), (1.002, "")):
        vars(found).pop("worst", None)
        vars(found)["nominal"] = np.full(len(found.theta), 100.0 / limit)
        verdict = judge(model, ["root-stress"])
        assert [finding.level for finding in verdict.findings] == ([level] if level else [])
        assert level or "sharp corner" in verdict.not_judged[0].reason


def test_the_nominal_stress_does_not_hang_on_where_the_planes_stand() -> None:
    """A level groove pressed alike all round, beside a wall of 7 mm: in the planes between elements 13.5 to 17.1 MPa
    were told, and a mirrored load had another stress."""
    motion = ({"until": 180.0, "to": 1e-6, "law": "cycloidal"}, {"until": 360.0, "to": 0.0, "law": "cycloidal"})
    data = read_data(PROFILES / "pin_insertion.toml")
    steel = {**data["material"]["cam"], "bending_limit": 400.0}
    model = Model(from_data({
        **data, "cam": {**data["cam"], "root_radius": 1.0}, "motion": motion,
        "operation": {"speed": 1.0, "spring_preload": 900.0}, "material": {**data["material"], "cam": steel},
    }))  # fmt: skip
    found = model.root_stress
    assert found is not None
    assert isinstance(found.body, PressedRing)
    bent, load = found.body.ring, found.body.patch
    ring = ring_of(bent.section, even_planes(48))
    turned = [replace(load, azimuth=load.azimuth - load.middle + share * TURN / 48.0, forces=load.forces @ about.T)
              for share in (0.0, 0.2, 0.5, 0.8)
              for turn in [share * TURN / 48.0 - load.middle]
              for about in [np.array([[np.cos(turn), -np.sin(turn), 0.0], [np.sin(turn), np.cos(turn), 0.0],
                                      [0.0, 0.0, 1.0]])]]  # fmt: skip
    solved = elastic(ring, model.profile.material.cam)
    moved = solved.solve(nodal_forces(ring, [[one] for one in turned]))
    told = [float(bent.nominal(ring, moved[:, :, k], one, solved.material).max()) for k, one in enumerate(turned)]
    assert told == pytest.approx([float(np.mean(told))] * 4, rel=0.06)
    assert told[1] == pytest.approx(told[3], rel=1e-4)


def test_cells_on_the_foot_are_as_low_as_the_rib_is_thin() -> None:
    """Over cells 2.5 times as high as the rib is thick its stress came out a fifth below what nodal forces bear out."""
    for thickness, cells in ((6.0, 4), (2.5, 8)):
        (part,) = Model(from_data(ribbed(thickness))).parts
        assert isinstance(part, RibbedCylinder)
        section = RibSection.of(part)
        assert section.cells[0] == cells
        feet = section.blocks(np.linspace(0.0, TURN, 73)[:-1])[0][0]
        assert 12.0 * section.rows[2] <= 1.01 * float((feet[:, 0, -1] - feet[:, 0, 0]).min())


@pytest.mark.parametrize(("thick", "high", "off"), [(3.0, 20.0, 0.06), (5.0, 20.0, 0.06)])
def test_a_rib_pressed_at_its_top_bends_as_a_long_cantilever_plate(thick: float, high: float, off: float) -> None:
    """A point load on the free edge of a plate clamped at the other gives a moment of 0.509 F per length there
    (Jaramillo 1950, Poisson's ratio 0.3); the drum below gives way a little, which takes some of it."""
    data = ribbed(thick)
    cam = {**data["cam"], "diameter": 400.0, "groove_depth": high, "start": 45.0}
    motion = tuple({**one, "to": 0.001 * one["to"]} if "to" in one else one for one in data["motion"])
    roller = {**data["roller"], "length": high - 2.0}
    model = Model(from_data({**data, "cam": cam, "motion": motion, "roller": roller}))
    (part,) = model.parts
    assert isinstance(part, RibbedCylinder)
    bent = bending.RibBending(RibSection(part))
    ring = ring_about(bent.section, 1.0, 0.012)
    load = LoadPatch(0.0, 100.0, "", np.array([0.9999]), np.array([1.0]), np.array([[0.0, 0.0, 100.0]]), thick)
    solved = elastic(ring, model.profile.material.cam)
    moved = solved.solve(nodal_forces(ring, [[load]]))[:, :, 0]
    found = float(bent.nominal(ring, moved, load, solved.material).max())
    assert found == pytest.approx(6.0 * 0.509 * 100.0 / thick**2, rel=off)


def test_a_study_has_the_stress_of_every_variant(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stress, "ANGLES", 24)
    told = [measure(Model(from_data(ribbed(thickness))), ("body",), None)[0]["body.nominal_stress_mpa"]
            for thickness in (6.0, 4.0)]  # fmt: skip
    assert told[1] > 1.5 * told[0] > 0.0


def test_a_thin_rib_that_hertz_passes_fails_at_its_foot(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stress, "ANGLES", 24)
    told = {}
    for thickness in (6.0, 2.5):
        data = ribbed(thickness)
        model = Model(from_data({**data, "material": {"cam": {"bending_limit": 40.0}}}))
        verdict = judge(model, ["root-stress", "contact-pressure"])
        told[thickness] = {finding.check: finding.level for finding in verdict.findings}
        found = model.root_stress
        assert found is not None
        assert isinstance(found.body, PressedRing)
        assert len(found.body.duties) == 2
        assert {patch.where for one in found.body.patches.values() for patch in one} == {
            "the rib's lower flank", "the rib's upper flank"}  # fmt: skip
    assert told == {6.0: {"contact-pressure": "pass"}, 2.5: {"root-stress": "fail", "contact-pressure": "pass"}}


def test_a_press_between_the_curves_angles_is_found_on_the_flank_that_it_presses(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A stroke of the press for 3 degrees of the turn, asked of at an angle where the other flank is pressed."""
    monkeypatch.setattr(stress, "ANGLES", 24)
    told = {}
    for force in ("-1.0", "-4000.0"):
        data = ribbed(6.0)
        operation = {**data["operation"], "force": ({"from": 141.0, "until": 144.0, "expression": force},)}
        model = Model(from_data({**data, "operation": operation, "output": {**data["output"], "load_angle_deg": 90.0},
                                 "material": {"cam": {"bending_limit": 60.0}}}))  # fmt: skip
        assert model.root_stress is not None
        assert model.root_stress.body.root == "root of the rib's upper flank"
        assert "load_angle_deg" not in model.root_stress.data()  # a sharp root has no peak to ask a load of
        told[force] = judge(model, ["root-stress"]).findings
    (finding,) = told["-4000.0"]
    assert not told["-1.0"]
    assert (finding.level, finding.where) == ("fail", "root of the rib's lower flank, nominal")
    assert "rib_thickness" in finding.advice
    assert finding.cam_angle_deg is not None
    assert 141.0 <= finding.cam_angle_deg <= 144.0


def test_a_section_is_coloured_within_the_body_alone() -> None:
    model = pin()
    groove = groove_of(model.parts[0], model.cutters)
    assert groove is not None
    section = GroovedSection.of(groove, Fineness((2, 2), (2, 2), 1, 1, (1, 1), 1))
    ring = ring_of(section, even_planes(48))
    # Stretched evenly along z by a thousandth: the stress is the same everywhere.
    moved = np.zeros_like(ring.nodes)
    moved[:, 2] = 1e-3 * ring.nodes[:, 2]
    cut = cut_of(ring, moved, elasticity(200000.0, 0.0), section.outline, groove.shape.depth, 1.0)
    assert np.allclose(cut.stress, 200.0)
    z, r, values = cut.window(60.0, 60.0, 200.0, 120)
    inside = np.isfinite(values)
    assert np.allclose(values[inside], 200.0)
    cell = (z[1] - z[0]) * (r[1] - r[0])
    x, y = cut.outline.T
    area = 0.5 * abs(float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum()))
    assert inside.sum() * cell == pytest.approx(area, rel=0.02)
    assert not inside[r > 55.0][:, np.abs(z - 0.5 * (cut.outline[: len(section.rows), 0].min()
                                                     + cut.outline[: len(section.rows), 0].max())) < 2.0].any()
    near = np.full(stress.ANGLES, 20.0)
    found = model.root_stress
    assert found is not None
    peaks = tuple(StressPeak(200.0, np.array([0.0, 54.0, 60.0]), 9, cut) for _ in range(2))
    vars(found).update(nominal=near, peaks=peaks)
    (drawn,) = (block for block in body(model) if isinstance(block, Map))
    assert drawn.value.label == "Largest principal stress"
    assert float(np.nanmax(drawn.values)) == pytest.approx(200.0)


@pytest.mark.parametrize(("name", "cells"), [("two_groove_drum", 5), ("both_faces_disc", 4)])
def test_every_track_is_judged_by_its_own_wall(name: str, cells: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Between two grooves the stress is linearised from flank to flank: pulled and bent, it is what it is made of."""
    monkeypatch.setattr(stress, "ANGLES", 24)
    data = read_data(PROFILES / f"{name}.toml")
    material = {**data["material"], "cam": {**data["material"]["cam"], "bending_limit": 50.0}}
    model = Model(from_data({**data, "material": material}))
    for number, one in enumerate(model.grooves):
        found = one.root_stress
        assert found is not None
        assert isinstance(found.body, PressedRing)
        assert isinstance(found.body.ring, bending.GrooveBending)
        own, section = found.body.ring, found.body.ring.section
        ring = ring_of(section, even_planes(48))
        cell_nodes = ring.elements.reshape(len(ring.planes), -1, 20)
        for second in (False, True):
            path = section.wall_path(second)
            x = ring.nodes[cell_nodes[:, [cell for cell, _ in path]]]
            inside = name == "two_groove_drum" and second == (number == 0)
            assert len(path) == (cells if inside else 4)
            assert np.ptp(np.hypot(x[..., 0], x[..., 1])) > 0.0
            patch = replace(found.body.patch, second=second)
            # Stretched by 1e-3 out of the groove.
            moved = 1e-3 * ring.nodes * ([1.0, 1.0, 0.0] if name == "two_groove_drum" else [0.0, 0.0, 1.0])
            shown = own.nominal(ring, moved, patch, elasticity(200000.0, 0.0))
            assert shown == pytest.approx(200.0, rel=1e-6)
        count = len(found.body.theta)
        vars(found).update(nominal=np.full(count, 10.0 + 50.0 * number), peaks=())
    told = judge(model, ["root-stress"])
    (failed,) = [finding for finding in told.findings if finding.level == "fail"]
    assert "follower 2" in failed.where
    assert any("follower 1" in word.reason for word in told.not_judged)


@pytest.mark.slow
def test_a_thinner_end_wall_bends_more_and_the_pressed_wall_bears_the_stress(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stress, "ANGLES", 12)
    monkeypatch.setattr(bending, "Fineness", lambda: Fineness((2, 2), (2, 2), 1, 1, (2, 2), 1))
    nominal = [pin(length=length).root_stress for length in (110.0, 106.0)]
    thick, thin = (one.nominal for one in nominal if one is not None)
    at = 10  # 300 deg, on the upper flank, whose wall ends at the drum's length
    assert thick[at] > 5.0
    assert thin[at] > 1.2 * thick[at]
    still = np.abs(thick[:5]).max()  # a dwell without load
    assert still < 0.05 * thick.max()


@pytest.mark.slow
@pytest.mark.skipif("CAMGEOM_JUDGE" not in os.environ, reason="takes a minute: scripts/test --judge")
def test_the_worst_wall_of_the_pin_cam_has_converged() -> None:
    """298 deg, the whole ring: a third mesh with planes a fifth closer moves the peak by half a per cent."""
    data = read_data(PROFILES / "pin_insertion.toml")
    output = {**data["output"], "load_angle_deg": 298.0}
    found = Model(from_data({**data, "cam": {**data["cam"], "root_radius": 1.0}, "output": output})).root_stress
    assert found is not None
    assert found.patch.normal == pytest.approx(1882.96, rel=1e-4)
    assert [one.value for one in found.peaks] == pytest.approx([120.6, 118.24], rel=2e-3)
    assert isinstance(found.body, PressedRing)
    assert isinstance(found.body.ring, bending.GrooveBending)
    assert isinstance(found.body.patch, LoadPatch)
    third = found.body.ring.peak(found.body.patch, found.body.material, 2, 0.028)
    assert third.value == pytest.approx(found.peaks[-1].value, rel=0.01)


@pytest.mark.slow
@pytest.mark.skipif("CAMGEOM_JUDGE" not in os.environ, reason="takes minutes: scripts/test --judge")
def test_a_thin_wall_that_the_contact_passes_fails_at_its_root() -> None:
    data = read_data(PROFILES / "pin_insertion.toml")
    steel = {**data["material"]["cam"], "bending_limit": 200.0}
    model = Model(from_data({
        **data, "cam": {**data["cam"], "root_radius": 1.0, "length": 106.0},
        "material": {**data["material"], "cam": steel}, "output": {**data["output"], "load_angle_deg": 298.0},
    }))  # fmt: skip
    levels = {finding.check: finding.level for finding in judge(model, ["contact-pressure", "root-stress"]).findings}
    assert levels == {"contact-pressure": "pass", "root-stress": "fail"}
    assert model.root_stress is not None
    assert model.root_stress.peak == pytest.approx(215.3, rel=0.02)


def test_a_flank_that_no_tool_with_a_corner_cuts_is_judged_as_a_straight_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By its nominal stress alone; its mesh goes on round the root as thick as the roller is at the flank's foot."""
    monkeypatch.setattr(stress, "ANGLES", 24)

    def made(limit: float, **roller: Any) -> Model:
        moves = ({"until": 150.0, "to": 36.0, "law": "modified-sine"}, {"until": 360.0, "to": 0.0, "law": "cycloidal"})
        cam = {"kind": "cylindrical", "diameter": 150.0, "length": 100.0, "start": 30.0, "groove_depth": 11.0,
               "bore": 35.0}  # fmt: skip
        return Model(from_data({
            "name": "crown", "cam": cam, "follower": {"kind": "translating", "mass": 2.4}, "motion": moves,
            "roller": {"diameter": 19.0, "length": 10.0, **roller}, "operation": {"speed": 100.0, "friction": 100.0},
            "material": {"cam": {"bending_limit": limit}},
        }))  # fmt: skip

    def crown(radius: float, limit: float = 300.0) -> Model:
        return made(limit, shape="crowned", crown_radius=radius, flank="conforming")

    straight = made(300.0).root_stress.worst.value  # type: ignore[union-attr]
    assert crown(1e5).root_stress.worst.value == pytest.approx(straight, rel=1e-3)  # type: ignore[union-attr]
    bent = crown(200.0)
    verdict = judge(bent, ["root-stress"])
    assert not verdict.findings
    assert "no tool with a corner" in verdict.not_judged[0].reason
    assert "root_radius" not in verdict.not_judged[0].reason
    nominal = bent.root_stress.worst.value  # type: ignore[union-attr]
    assert nominal == pytest.approx(straight, rel=0.15)
    (finding,) = judge(crown(200.0, nominal / 1.002), ["root-stress"]).findings
    assert (finding.level, finding.value) == ("fail", nominal)
    assert not judge(crown(200.0, nominal / 0.999), ["root-stress"]).findings
    # A flank that leans is pushed out of its groove or into it: half way between both it is the straight one.
    leaning = [made(300.0, shape="cone", half_angle=angle).root_stress for angle in (1.0, -1.0)]
    assert all("no tool with a corner" in one.why_no_peak for one in leaning)  # type: ignore[union-attr]
    assert np.mean([one.worst.value for one in leaning]) == pytest.approx(straight, rel=0.02)  # type: ignore[union-attr]


def test_followers_on_one_track_share_a_factorisation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each has the stress of its own load, as it has alone; the third of three its own force."""
    pressed = {"angle": 200.0, "force": [{"from": 100.0, "until": 140.0, "expression": "900"}]}
    made = built(data_of("pin_insertion", station=[{"angle": 90.0}, pressed]))
    count, factorised = 0, solver._factorised

    def counted(problem: solver.Elastic) -> solver._Factors:
        nonlocal count
        count += 1
        return factorised(problem)

    monkeypatch.setattr(solver, "_factorised", counted)
    found = [one.root_stress for one in made.bindings]
    assert all(one is not None for one in found)
    together = [one.nominal for one in found if one is not None]
    assert count == 1
    third = made.bindings[2].root_stress
    assert third is not None
    assert isinstance(third.body, PressedRing)
    alone = replace(third.body, solved=None).nominal
    assert count == 2
    np.testing.assert_array_equal(together[0], together[1])
    np.testing.assert_allclose(together[2], alone, rtol=1e-12)
    assert together[2].max() > 1.05 * together[0].max()


@pytest.mark.parametrize(
    ("round_", "followers", "states", "walls", "roots"),
    [(False, 12, 0, 12, 12), (False, 4, 1, 4, 4), (False, 5, 1, 4, 5), (True, 2, 0, 2, 2), (True, 4, 0, 4, 2),
     (True, 2, 1, 2, 2), (True, 3, 1, 3, 1)],
)  # fmt: skip
def test_roots_are_solved_as_far_as_the_purse_of_the_design_goes(
    round_: bool, followers: int, states: int, walls: int, roots: int
) -> None:
    """Followers on one track have their wall over the turn in common, but for their hardest states."""
    data = read_data(PROFILES / "pin_insertion.toml")
    data["material"]["cam"]["bending_limit"] = 300.0
    data["station"] = tuple({"angle": 25.0 * number} for number in range(1, followers))
    if states:
        data["duty"] = ({"share": 1.0},)
    if round_:
        data["cam"] = {**data["cam"], "root_radius": 0.5}
    model = Model(from_data(data))
    for number, one in enumerate(model.bindings):
        found = one.root_stress
        assert found is not None
        assert isinstance(found.body, PressedRing)
        assert bool(found.body.sharp) is not round_
        for pay, paid, told in zip(found.body.paid, (walls, roots), ("10 s .* s of loads", "14 s .* s of walls")):
            if number < paid:
                pay()
                continue
            with pytest.raises(NotConverged, match=f"{told}.* more than the 50 s .*: leave the bending_limit out"):
                pay()
    if walls < followers:
        with pytest.raises(NotConverged, match=r"over the turn \(5 of"):
            _ = found.nominal
    if roots < followers and round_:
        with pytest.raises(NotConverged, match=rf"round root \({followers} of"):
            _ = found.peaks


def test_the_forces_of_every_state_are_heard_beside_a_root() -> None:
    """Vibration of the quick state presses harder than that of the speed of [operation]; impacts of states that all
    differ from it are asked too."""
    data = read_data(PROFILES / "pin_insertion.toml")
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 3000, "linkage_damping": 20}
    data["duty"] = ({"share": 0.5}, {"share": 0.5, "speed": 700.0})
    model = Model(from_data(data))
    rigid, quick = model.hardest_state.peak_force, model.states[1]
    assert rigid is not None
    more, by = harder(model)
    assert by == "vibration"
    assert more == max(duty.peak_force.value for duty in quick.dynamic_duties) / rigid.value
    assert more > 1.2 * max(duty.peak_force.value for duty in model.states[0].dynamic_duties) / rigid.value
    data["duty"] = ({"share": 0.5, "load_factor": 1.5}, {"share": 0.5, "load_factor": 2.0})
    data["impact"] = {"clearance": 0.1, "turns": 2, "settle": 1}
    del data["dynamics"]
    more, by = harder(Model(from_data(data)))
    assert by == "impacts"
    assert more > 1.0
