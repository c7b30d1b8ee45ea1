"""Rollers of a turret with ends, tilt and crown: against an independent half-space, Hertz, and by hand."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.mechanics.finite_turn import refined
from camgeom.mechanics.hertz import crowned_contact, line_pressure
from camgeom.mechanics.material import pair_compliance
from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.model import Model
from camgeom.profile import from_data, parse
from camgeom.profile.text import load
from camgeom.report.result import compute
from camgeom.report.sections.load import turret_map
from camgeom.track import TURN
from camgeom.track.flank import Flank
from tests.places import PROFILES
from tests.reference.half_space import pressed

LOGARITHMIC = {"shape": "crowned", "crown": "logarithmic"}


def made(name: str = "tool_changer", limits: dict[str, Any] | None = None, **roller: Any) -> Model:
    data = dict(load((PROFILES / f"{name}.toml").read_text(), name)[0])
    data = {key: value for key, value in data.items() if key not in ("tolerance", "dynamics")}
    data["limits"] = {**data.get("limits", {}), **(limits or {})}
    return Model(from_data(data | {"roller": {**data["roller"], **roller}}, name))


def duty_of(model: Model) -> TurretDuty:
    duty = model.turret_duty
    assert duty is not None
    return duty


@pytest.fixture(scope="module")
def tilted() -> Model:
    return made(**LOGARITHMIC, misalignment_deg=0.01)


def _hardest(duty: TurretDuty) -> tuple[int, int, int]:
    """Sample point, roller and wall of the hardest contact."""
    assert duty.finite is not None
    at, patch = duty.finite.hardest
    n = int(np.argmin(np.abs(duty.theta - at.cam_angle)))
    loads = np.stack([wall.load[n] for wall in duty.finite.walls])
    w, k = np.unravel_index(int(np.argmin(np.abs(loads - patch.load))), loads.shape)
    assert loads[w, k] == pytest.approx(patch.load, rel=1e-12)
    return n, int(k), int(w)


def test_the_hardest_roller_presses_as_an_independent_half_space_says(tilted: Model) -> None:
    """Curvature and lever of the flank at 96 places, the run-out and the tilt by hand; the turret's angle is that which
    shares the torque."""
    duty = duty_of(tilted)
    assert duty.finite is not None
    (n, k, w), patch = _hardest(duty), duty.finite.hardest[1]
    index, turn = duty.engagement.places[k]
    track, middle = duty.tracks[index], 82.0
    ny = 96
    dy = 24.0 / ny
    y = (np.arange(ny) + 0.5) * dy - 12.0
    flank = next(
        flank for side in track.sides
        if ((flank := Flank(track, np.array([duty.theta[n] + TURN * turn]),
                            np.array([track.meridian.parameter(middle + each) for each in y]), side))
            .behind) == (w == 0)
    )  # fmt: skip
    held = duty.slices(duty.engagement).rows(np.array([n])).held(duty.turret_torque[n : n + 1])
    approach = np.abs(flank.lever()[0]) * abs(float(held.angle[0]))
    way = -1.0 if w == 0 else 1.0
    drop = 0.00035 * 32.0 * np.log(1.0 / (1.0 - (2.0 * y / 24.0) ** 2)) + way * np.tan(np.radians(0.01)) * y - approach
    half = 1.15 * float(np.abs(patch.x[(patch.pressure > 0.0).any(axis=1)]).max())
    nx = 64
    dx = 2.0 * half / nx
    x = (np.arange(nx) + 0.5) * dx - half
    gap = 0.5 * flank.k_rel[0] * x[:, None] ** 2 + drop
    pair = pair_compliance(duty.roller, duty.cam)
    found = pressed(gap - gap.min(), dx, dy, pair, patch.load)
    assert found.max() == pytest.approx(duty.least_peak.value, rel=0.01)
    along = found.sum(axis=0)
    assert float((along * y).sum() / along.sum()) == pytest.approx(patch.centre, abs=0.05)


def test_the_rollers_forces_make_the_torque(tilted: Model) -> None:
    duty = duty_of(tilted)
    load, e = duty._on_walls[0], duty.engagement
    side = np.array([1.0, -1.0])[:, None, None, None]
    given = (side * load * e.cover * e.lever).sum(axis=(0, 2, 3))[duty.loaded]
    assert given == pytest.approx(duty.turret_torque[duty.loaded], rel=1e-9)


def test_a_level_roller_presses_in_its_middle_as_the_line_does() -> None:
    """A run-out so small that all of the roller bears alike; its ends apart."""
    plain, level = duty_of(made()), duty_of(made(**LOGARITHMIC, crown_factor=1e-6))
    assert level.roller_load == pytest.approx(plain.roller_load, rel=0.02, abs=3.0)
    assert level.finite is not None
    n, k, w = _hardest(level)
    patch = level.finite.hardest[1]
    inner = np.abs(patch.y) < 6.0
    e = plain.engagement
    line = np.interp(patch.y[inner], np.sort(e.place[w, n, k]) - 82.0,
                     plain.pressure[n, k][np.argsort(e.place[w, n, k])])  # fmt: skip
    assert patch.ridge[inner] == pytest.approx(line, rel=0.05), "its sharp ends take a little of the load"
    bend = patch.bodies.curvature + patch.bodies.growth * patch.y[inner]
    own = line_pressure(patch.line_load[inner], bend, patch.bodies.compliance)
    assert patch.ridge[inner] == pytest.approx(own, rel=0.01), "and the load that is left presses as a line"


def test_a_tilt_presses_the_outer_end_on_the_wall_that_pushes_and_the_inner_one_otherwise(tilted: Model) -> None:
    duty, other = duty_of(tilted), duty_of(made(**LOGARITHMIC, misalignment_deg=-0.01))
    level = duty_of(made(**LOGARITHMIC))
    for found, sign in ((duty, 1.0), (other, -1.0)):
        _, _, wall = _hardest(found)
        away = found.least_peak.place - level.least_peak.place
        assert away * sign * (1.0 if wall == 0 else -1.0) > 0.8
        assert found.least_peak.value > level.least_peak.value
    # The roller's own damage lies on both of its ends, half on each.
    assert duty.lives["cam"] < level.lives["cam"]


def test_a_crown_on_a_straight_flank_touches_in_the_exact_ellipse() -> None:
    duty = duty_of(made(shape="crowned", crown_radius=60.0))
    assert duty.finite is not None
    n, k, w = _hardest(duty)
    patch = duty.finite.hardest[1]
    wall = duty.finite.walls[w]
    across, c = float(wall.bend[0][n, k]), 1.0 / 60.0
    square = np.cos(patch.bodies.twist) ** 2
    half = 0.5 * (across + c)
    root = np.sqrt(half * half - across * c * square)
    bends = half + root, half - root
    exact = crowned_contact(np.array([patch.load]), np.array([bends[1]]), np.array([bends[0]]),
                            pair_compliance(duty.roller, duty.cam), np.array([12.0]), np.array([12.0]))  # fmt: skip
    assert patch.peak[0] == pytest.approx(float(exact.pressure[0]), rel=2e-3)
    assert duty_of(made(shape="crowned", crown_radius=1000.0)).least_peak.value < duty.least_peak.value


def test_a_sharp_end_that_bears_is_never_passed() -> None:
    model = made(misalignment_deg=0.02)
    duty = duty_of(model)
    assert "sharp end" in duty.no_stress
    assert duty.peak_pressure is None
    assert "roller" not in duty.lives
    verdict = judge(model, ["turret-pressure", "turret-life"])
    assert {word.check for word in verdict.not_judged} == {"turret-pressure", "turret-life"}
    assert {finding.where.partition(",")[0] for finding in verdict.findings} == {"bearing"}
    data = compute(model, ("contact", "fatigue")).data
    assert data["contact"]["inside_pressure_mpa"] == pytest.approx(duty.least_peak.value)
    assert "peak_pressure_mpa" not in data["contact"]
    assert "roller_life_h" not in data["fatigue"]


def test_without_tilt_the_hardest_angle_is_shared_and_pressed_anew(tilted: Model) -> None:
    """As a machine of square rollers has it at that cam angle; the advice says it up to the limit."""
    duty, square = duty_of(tilted), duty_of(made(**LOGARITHMIC, misalignment_deg=0.0))
    assert duty.finite is not None
    assert square.finite is not None
    n = _hardest(duty)[0]
    told = max(float(peaks[:, n].max()) for peaks in square.finite._tabled)
    assert duty.square_spot == pytest.approx(told, rel=0.05)
    assert duty.square_spot is not None
    for share, advised in ((0.999, False), (1.001, True)):
        limits = {"contact_pressure_mpa": duty.square_spot * share}
        model = made(limits=limits, **LOGARITHMIC, misalignment_deg=0.01)
        (found,) = judge(model, ["turret-pressure"]).findings
        assert found.level == "fail"
        assert ("without it the roller presses there" in found.advice) == advised


def test_without_tilt_rollers_with_sharp_ends_press_as_lines() -> None:
    """At that cam angle, as in the profile without the tilt; the advice says it up to the limit."""
    duty, square = duty_of(made(misalignment_deg=0.02)), duty_of(made())
    assert (duty.level, square.level) == ("finite", "line")
    n = int(np.argmin(np.abs(square.theta - duty.least_peak.cam_angle)))
    assert duty.square_spot is not None
    # A line is looked at in fewer slices, whose outermost stands farther from the end.
    assert duty.square_spot == pytest.approx(float(square.pressure[n].max()), rel=0.01)
    for share, advised in ((0.999, False), (1.001, True)):
        limits = {"contact_pressure_mpa": duty.square_spot * share}
        (found,) = judge(made(limits=limits, misalignment_deg=0.02), ["turret-pressure"]).findings
        assert found.level == "fail"
        assert ("without it the roller presses there" in found.advice) == advised


def test_the_peak_is_judged_and_told(tilted: Model) -> None:
    peak = duty_of(tilted).least_peak.value
    for limit, level in ((1.002 * peak, "pass"), (0.998 * peak, "fail")):
        roller = {**LOGARITHMIC, "misalignment_deg": 0.01}
        (found,) = judge(made(limits={"contact_pressure_mpa": limit}, **roller), ["turret-pressure"]).findings
        assert found.level == level
    contact = compute(tilted, ("contact",)).data["contact"]
    assert contact["contact_level"] == "finite"
    assert contact["peak_slice_pressure_mpa"] == pytest.approx(peak)
    assert contact["tangent_stiffness_n_mm"] > contact["secant_stiffness_n_mm"] > 0.0
    assert compute(made(), ("contact",)).data["contact"]["contact_level"] == "line"


@pytest.mark.parametrize(("name", "roller"), [
    ("fine_indexer", {**LOGARITHMIC, "misalignment_deg": -0.02}),
    ("barrel_indexer", {**LOGARITHMIC, "misalignment_deg": 0.01}),
    pytest.param("conical_indexer", {"end_radius": 1.0}, marks=pytest.mark.slow),
])
def test_preload_cones_and_barrels(name: str, roller: dict[str, Any]) -> None:
    plain, ended = duty_of(made(name)), duty_of(made(name, **roller))
    assert ended.level == "finite"
    assert ended.least_peak.value > plain.least_peak.value
    assert np.isfinite(list(ended.lives.values())).all()
    assert ended.peak_force.value == pytest.approx(plain.peak_force.value, rel=0.5)


@pytest.mark.parametrize(("crown", "level"), [(60.0, "warn"), (1e5, "")])
def test_a_mirror_at_an_end_that_does_not_bear_is_told(crown: float, level: str) -> None:
    model = made(shape="crowned", crown_radius=crown, free_ends="mirrored")
    verdict = judge(model, ["free-ends"])
    assert [finding.level for finding in verdict.findings] == ([level] if level else [])


@pytest.mark.slow
def test_the_table_is_the_half_space_at_part_of_the_load_and_of_the_length() -> None:
    """Where a wall has 20 to 70 % of its largest load the turning of the turret tilts its rollers less, too: the table
    within 5 %, where one tilt for all had been up to 25 % off."""
    finite = duty_of(made(end_radius=1.0)).finite
    assert finite is not None
    scale = finite._hardest[2]
    for w, wall in enumerate(finite.walls):
        share, most = wall.load / wall.load.max(), wall.cover.sum(axis=2).max()
        whole = wall.cover.sum(axis=2) > 0.98 * most
        for part in (0.2, 0.4, 0.7):
            at = np.unravel_index(int(np.argmin(np.where(whole, np.abs(share - part), 1.0))), share.shape)
            n, k = (int(i) for i in at)
            exact = refined(finite.bodies(w, (n, k)), float(wall.load[n, k]))
            assert scale * finite._tabled[w][:, n, k].max() == pytest.approx(exact.peak[0], rel=0.05)


@pytest.mark.slow
def test_the_table_is_the_half_space_on_both_walls() -> None:
    """Where each wall is pressed hardest, though a quarter of a millimetre of the roller stands out of the cam."""
    finite = duty_of(made(misalignment_deg=0.02, end_radius=1.0)).finite
    assert finite is not None
    assert finite._pressed == [0, 1]
    for w, wall in enumerate(finite.walls):
        n, k = np.unravel_index(int(np.argmax(wall.load)), wall.load.shape)
        exact = refined(finite.bodies(w, (int(n), int(k))), float(wall.load[n, k]))
        assert finite._tabled[w][:, n, k].max() == pytest.approx(exact.peak[0], rel=0.03)


def test_plates_bear_alike_wherever_they_stand_on_their_shaft() -> None:
    """Tilted rollers of all plates lean about their own middles: farther apart, nothing changes but the place."""
    near, far = _apart(24.0), _apart(60.0)
    one, other = duty_of(near), duty_of(far)
    assert one.roller_load == pytest.approx(other.roller_load, rel=1e-9)
    bears = (one.roller_load > 1e-3 * one.roller_load.max()).any(axis=0)
    assert {one.engagement.places[k][0] for k in np.flatnonzero(bears)} == {0, 1}
    assert one.finite is not None
    for wall in one.finite.walls:
        there = (wall.cover > 0.0) & bears[:, None]
        assert np.abs(wall.place[there]).max() <= 7.0, "from the middle of the roller on its own plate"
    shift = one.finite.middles - one.finite.middles[0]
    assert sorted(set(shift.round(9))) == [0.0, 40.0]


def _apart(gap: float) -> Model:
    data = dict(load((PROFILES / "parallel_index.toml").read_text(), "parallel_index")[0])
    roller = {**data["roller"], "misalignment_deg": 0.02, "end_radius": 1.0}
    return Model(from_data(data | {"cam": {**data["cam"], "gap": gap}, "roller": roller}, "parallel_index"))


HALF_BESIDE = """
name = "half a roller beside its blank"
[cam]
kind = "globoidal"
form = "groove"
width = 166.51
center_distance = 357.3
globoid_radius = 177.5
tip_clearance = 0.756884
[follower]
kind = "turret"
stops = 6
pitch_radius = 162.1
inertia = 0.0719
[roller]
shape = "crowned"
diameter = 60.14
length = 50.119
crown = "logarithmic"
flank = "straight"
[operation]
speed = 1250
[output]
tolerance = 0.2
[[motion]]
until = 10
[[motion]]
until = 330
to = 60
law = "cycloidal"
[[motion]]
until = 360
"""


def test_a_roller_half_of_which_is_beside_the_blank_presses_with_that_half() -> None:
    """Its table was that of the whole roller, leaning: nothing pressed where the blank is, and lives had no end."""
    duty = Model(parse(HALF_BESIDE)).turret_duty
    assert duty is not None
    assert duty.finite is not None
    hardest, _, scale, _ = duty.finite._hardest
    assert hardest.value == pytest.approx(812.0, rel=0.01)
    assert scale == pytest.approx(1.0, abs=0.06)
    assert float(duty.pressure.max()) == pytest.approx(hardest.value)
    # all of the load stands on the outer half
    delta = duty.tracks[0].meridian.jet(duty.engagement.stations)[0]
    assert delta[duty.pressure.max(axis=(0, 1)) > 0.0].min() > 162.1 + 10.0


FACING_AWAY = """name = "wall beside the middle"
[cam]
kind = "globoidal"
hand = "right"
width = 101.03
center_distance = 253.488
globoid_radius = 122.52
direction = "ccw"
[follower]
kind = "turret"
stops = 8
pitch_radius = 120.2
inertia = 0.888
[roller]
shape = "crowned"
diameter = 38.107
length = 23.33
crown_radius = 55.0
crown = "circular"
[operation]
speed = 6.85
friction = 97.1
[[motion]]
until = 20.0
[[motion]]
until = 350.0
to = 45.0
law = "cycloidal"
[[motion]]
until = 360.0
"""


def test_a_wall_that_ends_beside_the_middle_of_a_crowned_roller_is_pressed_by_its_edge() -> None:
    """The crown touches the wall's edge, of which the table of whole rollers knows nothing: lives had no end."""
    duty = Model(parse(FACING_AWAY)).turret_duty
    assert duty is not None
    assert duty.finite is not None
    assert duty.no_stress
    assert turret_map(duty).values[~np.isnan(turret_map(duty).values)].max() > 0.0
    rounded = Model(parse(FACING_AWAY).with_({"roller.end_radius": 0.5})).turret_duty
    assert rounded is not None
    assert rounded.finite is not None
    assert not rounded.no_stress
    n, k, _ = np.unravel_index(int(np.argmax(rounded.pressure)), rounded.pressure.shape)
    hardest = refined(rounded.finite.bodies(0, (int(n), int(k))), float(rounded.roller_load[n, k]))
    assert rounded.pressure.max() == pytest.approx(hardest.peak[0], rel=0.02)
    assert np.all(rounded.pressure.max(axis=2)[rounded.roller_load > 0.0] > 0.0)
    assert np.isfinite(rounded.roller_life)
