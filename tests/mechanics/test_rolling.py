"""How far a roller turns about its pin: a turn more or less than its middle's path gives, by the side of the flank."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.mechanics.life import Rolling
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track.flank import Flank
from tests.places import PROFILES


def made(name: str, **changed: dict[str, object]) -> Model:
    text = (PROFILES / f"{name}.toml").read_text() if "_" in name else starter(name)
    data = load(text, name)[0]
    for section, keys in changed.items():
        data[section] = {key: value for key, value in {**data.get(section, {}), **keys}.items() if value is not None}
    return Model(from_data(data, name))


def turned(model: Model, side: float) -> tuple[float, float, float]:
    """Path of the roller's middle across its axis, path of its rim, and its circumference, mm, of one turn of the cam,
    by a fine midpoint sum."""
    track = model.tracks[0]
    n = 20_000
    phi = (np.arange(n) + 0.5) * (2.0 * pi / n)
    flank = Flank(track, phi, np.array([0.5 * sum(track.contact)]), side)
    pose = flank.pose
    delta = 0.5 * sum(track.contact)
    v, u = pose.a[1] + delta * pose.u[1], pose.u[0]
    across = v - (v * u).sum(axis=0) * u
    step = 2.0 * pi / n
    radius = 0.5 * model.profile.roller.diameter if model.profile.roller else 0.0
    return step * float(np.sqrt((across**2).sum(axis=0)).sum()), step * float(flank.rolled.sum()), 2.0 * pi * radius


@pytest.mark.parametrize("name", ["disc", "disc_face_groove"])
def test_round_a_disc_the_roller_turns_once_less_or_more_than_its_path_gives(name: str) -> None:
    """What rolls round the outside of a circle turns by path - circumference against its carrier, inside by path +."""
    model = made(name)
    found = []
    for side in model.tracks[0].sides:
        middle, rim, around = turned(model, side)
        found.append(round((rim - middle) / around, 6))
    assert sorted(found) == ([-1.0, 1.0] if len(found) == 2 else [-1.0])


def test_the_rim_on_a_flank_is_as_long_as_the_flank() -> None:
    """No slip, seen from the cam: over a closed turn rim and flank are one length, counted along the flank's points."""
    model = made("disc_offset_roller", roller={"shape": "cylinder", "crown_radius": None, "flank": None})
    track = model.tracks[0]
    phi = np.linspace(0.0, 2.0 * pi, 40_001)
    flank = Flank(track, phi, np.array([0.5 * sum(track.contact)]), track.sides[0])
    x = flank.points[:, 0, :2]
    length = float(np.hypot(*np.diff(x, axis=0).T).sum())
    assert turned(model, track.sides[0])[1] == pytest.approx(length, rel=1e-6)


def test_in_a_drums_groove_the_middles_path_is_what_it_rolls() -> None:
    model = made("pin_insertion")
    for side in model.tracks[0].sides:
        middle, rim, _ = turned(model, side)
        assert rim == pytest.approx(middle, rel=1e-12)


@pytest.mark.parametrize("name", ["disc_face_groove", "conical_guide"])
def test_what_a_roller_rolls_changes_where_it_goes_over_to_the_other_wall(name: str) -> None:
    """Its walls turn it at two speeds: a fine midpoint sum, and not a panel over the change."""
    duty = made(name).duty
    n = 60_000
    phi = (np.arange(n) + 0.5) * (2.0 * pi / n)
    signed = duty.force.panels.at(duty.force.force, phi)
    rolled = {}
    for side in duty.track.sides:
        flank = Flank(duty.track, phi, np.array([duty.station]), side)
        rolled[flank.behind] = flank.rolled[:, 0]
    want = np.where(signed >= 0.0, rolled[True], rolled[False]).sum() * 2.0 * pi / n
    assert duty.fatigue_data()["path_per_turn_m"] * 1000.0 == pytest.approx(want, rel=1e-5)


def test_the_bearing_of_a_roller_on_the_outer_flank_counts_all_its_turns() -> None:
    """Revolutions are the rim's path over the circumference."""
    model = made("disc_face_groove", roller={"dynamic_rating": 669.0})
    (duty,) = model.duties
    assert duty.bearing is not None
    rate = duty.force.panels.integral(duty.pressing.path_rate)
    expected = duty.speed * rate / (2.0 * pi * duty.radius)
    assert float(duty.bearing.speed) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("name", "preload"), [("fine_indexer", 4e-3), ("tool_changer", 0.0), ("conical_indexer", 0.0)])
def test_a_roller_of_a_turret_turns_so_that_its_slices_drag_it_neither_on_nor_back(name: str, preload: float) -> None:
    """A little faster and friction holds it back, a little slower and it is dragged on: by signs of the slips alone."""
    duty = made(name).turret_duty
    assert duty is not None
    assert duty.preload == preload
    e = duty.engagement
    radii = duty.tracks[0].meridian.jet(e.stations)[3]
    loads = duty._on_walls[0] if preload else np.zeros((2, *duty.line_load.shape))
    if not preload:
        way = np.where(duty.turret_torque >= 0.0, 0, 1)
        for n, wall in enumerate(way):
            loads[wall, n] = duty.line_load[n]
    moment = loads * e.cover * radii
    rate = duty.path_rate / radii[len(radii) // 2]
    pressed = moment.sum(axis=(0, 3)) > 0.0
    both = [np.abs(sum((moment * np.sign(e.turning - sense * (rate + step)[None, ..., None])).sum(axis=(0, 3))
                       for step in (-1e-9, 1e-9)))
            for sense in (1.0, -1.0)]  # fmt: skip
    least = np.minimum(*both)
    largest = 2.0 * moment.max(axis=(0, 3))
    assert pressed.sum() > 500
    assert np.all(least[pressed] <= largest[pressed] * (1.0 + 1e-9))


def test_under_a_preload_a_roller_rolls_on_the_wall_that_presses_it() -> None:
    """Of two rollers on opposite walls each has its own; the torque's wall would have both on one."""
    duty = made("fine_indexer").turret_duty
    assert duty is not None
    e, m = duty.engagement, len(duty.engagement.stations) // 2
    pressed = duty._on_walls[0][..., m] > 0.0
    walls = np.abs(e.turning[..., m]) * duty._radius
    own = np.where(pressed[0], walls[0], walls[1])
    one = pressed.any(axis=0) & e.touches.all(axis=3).any(axis=0)
    assert duty.path_rate[one] == pytest.approx(own[one], rel=0.02)
    way = np.where(duty.turret_torque >= 0.0, 0, 1)
    of_torque = walls[way, np.arange(len(way))]
    assert np.abs(of_torque[one] / own[one] - 1.0).max() > 0.07


def test_rings_of_a_parallel_indexer_roll_alike_to_and_from_the_middle_of_its_index() -> None:
    """Run backwards without friction one ring's passage is the other's; a roller on its only wall rolls, loaded or not.
    """
    duty = made("parallel_index", operation={"friction": 0.0}).turret_duty
    assert duty is not None
    assert duty.bearing is not None
    first, second = duty._path
    assert second == pytest.approx(first, rel=1e-6)
    e, m = duty.engagement, len(duty.engagement.stations) // 2
    there = (e.cover > 0.0).any(axis=3)
    alone = there[0] ^ there[1]
    assert alone.sum() > 500
    assert np.abs(duty.turning)[alone] == pytest.approx(np.abs(np.where(there[0], *e.turning[..., m]))[alone])


@pytest.mark.parametrize(
    ("limit", "level"), [(0.999 * 882.36, "warn"), (1.002 * 882.36, "pass"), (0.999 * 121.5, "fail")]
)
def test_the_speed_of_rollers_that_no_torque_presses_is_judged(limit: float, level: str) -> None:
    """Told were 83 r/min, of a ring that stood still whenever the torque pressed the other one."""
    (found,) = judge(made("parallel_index", roller={"limiting_speed": limit}), ("bearing-speed",)).findings
    assert found.level == level


def test_a_preload_of_a_nanometre_is_none() -> None:
    """Of rollers of every radius along themselves: loads, stiffness and paths have one limit, from both sides."""
    none, hair = (made("conical_indexer", cam={"preload": preload}).turret_duty for preload in (0.0, 1e-6))
    assert none is not None
    assert hair is not None
    assert hair.pressure.max() == pytest.approx(none.pressure.max(), rel=1e-3)
    assert hair._path == pytest.approx(none._path, rel=1e-3)
    assert hair.lives["roller"] == pytest.approx(none.lives["roller"], rel=5e-3)


@pytest.mark.parametrize("drive", ["cycloidal", "3-4-5", "simple-harmonic"])
def test_a_roller_that_stands_where_its_plate_turns_back_has_a_life(drive: str) -> None:
    """Where a plate's drive stands, the path of its roller grows by nothing: its place on that path was sought by
    Newton's method alone, which divided by that nothing and ended the check."""
    data, _, _ = load((PROFILES / "linear_groove.toml").read_text(encoding="utf-8"), "linear_groove")
    # No dwell at either end, where nothing would press the roller.
    motion = ({"until": 80.0, "to": 15.0, "law": "modified-sine"}, {"until": 160.0, "to": 0.0, "law": "cycloidal"})
    made = Model(from_data({**data, "cam": data["cam"] | {"drive": drive}, "motion": motion}, ""))
    (duty,) = made.duties
    radius = np.full(len(duty.slices.pressure), duty.radius)
    rolling = Rolling.of(duty.slices, duty.roller, radius, "from-behind")
    # A panel at both of whose ends it stands to the last bit: its rate is 1 - x², its path x - x³ / 3 + 2 / 3.
    rates, inside = np.zeros_like(rolling.rates), np.zeros_like(rolling.inside)
    rates[..., [0, 2]], inside[..., [0, 1, 3]] = [0.5, -0.5], [2.0 / 3.0, 0.75, -1.0 / 12.0]
    edges = np.broadcast_to(4.0 / 3.0 * np.arange(rolling.edges.shape[1]), rolling.edges.shape)
    stands = replace(rolling, rates=rates, inside=inside, edges=edges)
    path, none = np.linspace(0.0, 4.0 / 3.0, 2001), np.zeros(2001, dtype=np.intp)
    x = stands.solve(none, none, path)
    assert np.abs(x - x**3 / 3.0 + 2.0 / 3.0 - path).max() < 1e-12
    assert all(0.0 < life < np.inf for life in duty.lives.values())
    assert not [word for word in judge(made, ["life"]).not_judged if "range" in word.reason]
