"""The load rests on the length of a roller that touches: of drums, turrets and narrow discs, each against a count."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track.flank import Flank
from camgeom.track.turret import Engagement
from tests.places import PROFILES
from tests.reference.profiles import said

SHORT = {
    "name": "short contact",
    "cam": {"kind": "cylindrical", "form": "groove", "diameter": 70.0, "length": 110.0, "start": 30.0,
            "groove_depth": 5.0, "bore": 20.0},
    "follower": {"kind": "translating", "mass": 0.2},
    "roller": {"shape": "cylinder", "diameter": 32.0, "length": 5.0},
    "motion": ({"until": 20.0}, {"until": 180.0, "to": 50.0, "law": "modified-sine"}, {"until": 200.0},
               {"until": 360.0, "to": 0.0, "law": "modified-sine"}),
    "operation": {"speed": 60.0, "friction": 100.0, "force": (
        {"from": 90.0, "until": 110.0, "expression": "2000*sin((deg-90)*pi/20)**2"},)},
}  # fmt: skip


def short(**tables: dict[str, Any]) -> Model:
    """The thick roller in the shallow groove of a thin drum, with tables changed."""
    return Model(from_data(SHORT | {name: SHORT.get(name, {}) | table for name, table in tables.items()}, ""))


def model(name: str, **tables: dict[str, Any]) -> Model:
    """A shipped profile with tables changed; None removes a key."""
    data, _, _ = load((PROFILES / f"{name}.toml").read_text(), name)
    for table, keys in tables.items():
        data[table] = {k: v for k, v in (data.get(table, {}) | keys).items() if v is not None}
    return Model(from_data(data, name))


def counted(made: Model, at: float, side: float, length: float) -> float:
    """Length that touches at a cam angle, mm, by counting points of the wall under the drum's outside."""
    (track,) = made.tracks
    places = max(track.contact) - length + length * (np.arange(20000) + 0.5) / 20000
    x = Flank(track, np.array([at]), places, side).x[:, 0]
    drum = made.mechanism.drum
    assert drum is not None
    return length * float((np.hypot(x[0], x[1]) <= drum.radius).mean())


def test_the_steep_groove_of_a_thin_drum_holds_a_part_of_its_roller() -> None:
    made = short()
    duty, peak = made.duty, made.duty.peak_pressure
    length = counted(made, peak.cam_angle, 1.0, 5.0)
    assert duty.contact_length == pytest.approx(length, abs=1e-3) == pytest.approx(3.2233, abs=2e-3)
    # The force over the length that touches, shared equally, is within a thousandth of the slices' own sharing.
    quoted = duty.contact.peak()
    assert peak.value == pytest.approx(float(quoted.pressure) * np.sqrt(5.0 / length), rel=0.02)
    assert peak.value == pytest.approx(1547.37, abs=0.01)
    assert duty.contact_data()["contact_length_mm"] == duty.contact_length
    assert duty.least_touching.value <= duty.contact_length
    assert duty.lives["roller"] == pytest.approx(43761.799, rel=1e-6)


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.999, "fail")])
def test_it_is_judged_by_the_pressure_of_that_part(share: float, level: str) -> None:
    (finding,) = said(short(limits={"contact_pressure_mpa": 1547.3724 * share}), "contact-pressure")
    assert (finding.level, finding.where) == (level, "groove, at 33.22 mm along the roller axis, 3.223 of 5 mm touch")
    found = {f.where: f.level for f in said(short(limits={"life_h": 43761.799 / share}), "life")}
    assert found["roller"] == level


@pytest.mark.parametrize("name", ["pin_insertion", "steep_shuttle", "milled_drum", "feeder_runout"])
def test_no_slice_of_a_drums_roller_lies_beyond_its_wall(name: str) -> None:
    made = model(name)
    for duty in made.duties:
        theta = duty.force.panels.theta.ravel()
        t = duty.track.meridian.parameters(duty.slice_places.reshape(len(duty.slice_places), -1).T)
        drum = made.mechanism.drum
        assert drum is not None
        pressed = (duty.contact_forces[0] > 0.0).ravel()
        for side in duty.track.sides:
            flank = Flank(duty.track, theta, t, side)
            behind = flank.behind
            mine = pressed & ((duty.normal.ravel() >= 0.0) == behind)
            radius = np.hypot(flank.x[0], flank.x[1])[mine]
            assert np.all(radius <= drum.radius + 1e-6)
        assert np.all(duty.pressing.touching <= duty.length + 1e-12)


def test_a_level_groove_holds_all_of_its_roller() -> None:
    """Far from steep: a thick drum, where what stands out is micrometres."""
    thick = {"diameter": 700.0, "start": 30.0}
    duty = short(cam=thick).duty
    assert duty.least_touching.value == pytest.approx(5.0, abs=0.02)
    assert duty.peak_pressure.value == pytest.approx(float(duty.contact.peak().pressure), rel=0.01)


@pytest.mark.parametrize("name", ["tool_changer", "fine_indexer", "two_start", "barrel_indexer"])
def test_slices_of_a_turrets_rollers_are_as_long_as_they_touch(name: str) -> None:
    made = model(name)
    mechanism, duty = made.mechanism, made.turret_duty
    assert duty is not None
    theta = np.linspace(0.3, 6.0, 7)
    beside = Engagement(duty.tracks, mechanism.within, theta)
    places = [i for i, (index, turn) in enumerate(beside.places) if index == 0]
    (low, high), track = sorted(duty.tracks[0].contact), duty.tracks[0]
    fine = np.linspace(low, high, 4001)
    for place in places:
        _, turn = beside.places[place]
        phi = theta + 2.0 * np.pi * turn
        rows = np.flatnonzero((phi >= track.span[0]) & (phi <= track.span[1]))
        if not len(rows):
            continue
        found = np.zeros((2, len(rows)))
        for side in track.sides:
            flank = Flank(track, phi[rows], track.meridian.parameters(fine), side)
            way = np.where(flank.lever().mean(axis=1) < 0.0, 0, 1)
            found[way, np.arange(len(rows))] = (high - low) * (mechanism.within(flank.x) >= 0.0).mean(axis=1)
        assert beside.cover[:, rows, place].sum(axis=2) == pytest.approx(found, abs=(high - low) / 27)
    assert 0.0 < duty.contact_length <= high - low + 1e-9


@pytest.mark.parametrize(("width", "length"), [(6.0, 6.0), (12.0, 12.0), (20.0, 12.0)])
def test_a_disc_narrower_than_its_roller_bears_on_its_own_width(width: float, length: float) -> None:
    cylinder = {"shape": "cylinder", "crown_radius": None, "length": 12.0}
    duty = model("disc_offset_roller", cam={"width": width}, roller=cylinder).duty
    whole = model("disc_offset_roller", cam={"width": 12.0}, roller=cylinder).duty
    assert duty.contact_length == pytest.approx(length) == duty.least_touching.value
    share = duty.peak_force.value / whole.peak_force.value * 12.0 / length
    assert duty.peak_pressure.value == pytest.approx(whole.peak_pressure.value * np.sqrt(share), rel=1e-6)


def test_a_force_where_no_wall_is_has_no_bearable_pressure() -> None:
    made = short()
    duty = made.duty
    from dataclasses import replace

    bare = replace(duty, beside=lambda x: np.full(x.shape[1:], -1.0))
    assert bare.peak_pressure.value == np.inf
    assert bare.lives["roller"] == 0.0
    assert bare.deepest_shear is None


def test_text_names_the_length_that_touches() -> None:
    verdict = judge(model("pin_insertion"), ["contact-pressure"])
    assert "11.4 of 12 mm touch" in verdict.findings[0].where
