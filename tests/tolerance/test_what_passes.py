"""What a tolerance study must not pass: figures between its samples, pressures nobody knows, limits without meaning."""

from __future__ import annotations

from math import atan, tan

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.checks import findings
from camgeom.errors import DesignError, NotConverged, ProfileError
from camgeom.model import Model
from camgeom.profile import parse, read
from camgeom.tolerance.causes import CAUSES, Approaches, applicable, default_pivots
from camgeom.tolerance.contacts import contacts
from camgeom.tolerance.directions import Trials
from tests.places import PROFILES, ROOT
from tests.reference.profiles import model


def disc(table: str, text: str = "") -> Model:
    return Model(parse((text or starter("disc")) + f"\n[tolerance]\n{table}\n"))


def drum(table: str) -> Model:
    return Model(parse(starter("cylindrical") + f"\n[tolerance]\n{table}\n"))


def test_an_error_that_is_always_at_its_end_moves_as_its_worst_case() -> None:
    """Across the line of a slide by d: d tan of the largest pressure angle, which lies between no two samples."""
    d = 0.03
    made = disc(f'side_shift = {{ value = {d}, distribution = "worst" }}')
    theta = np.linspace(0.0, 2.0 * np.pi, 36001)
    s, ds = made.setup.program.jet(theta, 1)
    cam, roller = made.profile.cam, made.profile.roller
    tangent = float(np.abs(ds / (cam.base_radius + 0.5 * roller.diameter + s)).max())
    true = 1e3 * d * tan(atan(tangent))
    study = made.tolerances
    assert study.loaded.shown(study.worst.motion.value) == pytest.approx(true, rel=2e-3)
    assert study.loaded.shown(float(study.drawn.motion.min())) == pytest.approx(true, rel=5e-3)


def test_what_turns_with_the_cam_is_seen_all_along_a_dwell() -> None:
    """Eccentricity of every direction under a dwell of 300 degrees reaches all of itself."""
    text = starter("disc")
    head, tail = text[: text.index("[[motion]]")], text[text.index("[operation]") :]
    dwelling = f'{head}[[motion]]\nuntil = 300\n[[motion]]\nuntil = 330\nto = 2\nlaw = "cycloidal"\n'
    dwelling += f'[[motion]]\nuntil = 360\nto = 0\nlaw = "cycloidal"\n{tail}'
    made = disc('cam_eccentricity = { value = 0.02, distribution = "worst" }', dwelling)
    study = made.tolerances
    reach = study.loaded.shown(study.drawn.dwell)
    assert study.loaded.shown(study.worst.dwell.value) == pytest.approx(20.0, rel=1e-3)
    assert float(np.max(reach)) == pytest.approx(20.0, rel=0.02)


def test_means_that_undo_each_other_leave_nothing_and_a_gap_moves_no_wall_of_its_own() -> None:
    undone = disc("center_distance = { value = 0, mean = -0.02 }\nroller_place = { value = 0, mean = 0.02 }").tolerances
    added = disc("center_distance = { value = 0, mean = 0.02 }\nroller_place = { value = 0, mean = 0.02 }").tolerances
    assert sorted(round(one.loaded.shown(one.worst.motion.value), 3) for one in (undone, added)) == [0.0, 40.0]
    gap, rise = 0.0235, 0.004
    play = drum(f"running_clearance = {{ value = {rise}, mean = {gap} }}\naxial_shift = 0.1").tolerances
    assert play.loaded.shown(play.worst.backlash.value) == pytest.approx(2e3 * (gap + rise), rel=1e-3)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("side_shift = 0.02\nbacklash_limit = 10", "backlash_limit.*no play"),
        ("running_clearance = 0.02", "running_clearance.*held on both sides.*this cam has none"),
        ("skew_arcmin = 2\npressure_limit = 900", "pressure_limit.*skew_arcmin"),
        ("side_shift = 0.02\nyield = 0.9999\nsamples = 1000", "samples.*100000 or more"),
        ("side_shift = 0.02\n[tolerance.cost]\nphase_arcmin = 2", "cost.phase_arcmin.*no such error is given"),
    ],
)
def test_what_cannot_be_judged_is_refused(table: str, words: str) -> None:
    with pytest.raises(ProfileError, match=words):
        disc(table)


def test_a_limit_of_the_pressure_is_judged_by_the_share_of_the_machines() -> None:
    nominal = disc("roller_diameter = 0.02").duty.peak_pressure.value
    for limit, level in ((1.2 * nominal, "pass"), (0.9 * nominal, "fail")):
        (found,) = findings(disc(f"roller_diameter = 0.02\npressure_limit = {limit}"), ["yield-tolerance"])
        assert found.level == level
        assert ("alone, tolerance.pressure_limit is kept by 0 %: the design has" in found.advice) is (level == "fail")
        assert (f"{nominal:.4g} MPa without any error" in found.advice) is (level == "fail")
    crowned = starter("disc").replace('shape = "cylinder"', 'shape = "crowned"\ncrown_radius = 300')
    with pytest.raises(ProfileError, match=r"pressure_limit.*straight cylinders"):
        disc("roller_diameter = 0.02\npressure_limit = 900", crowned)


@pytest.mark.parametrize(("held", "level"), [(0.992, "fail"), (0.997, "pass")])
def test_limits_that_hold_one_by_one_fail_by_the_share_that_holds_all(held: float, level: str) -> None:
    """Place and play that know little of each other, each limit held by 99.2 %: all by fewer than 99 %."""
    table = "axial_shift = 0.3\nrunning_clearance = { value = 0.006, mean = 0.02 }\nsamples = 40000\n"
    study = drum(table).tolerances
    dwell, play = (study.loaded.shown(study.drawn.at_yield(one, held)) for one in
                   (study.drawn.dwell, study.drawn.backlash))  # fmt: skip
    limits = {"dwell": f"dwell_limit = {dwell * (1.0 + 1e-6)}\n", "play": f"backlash_limit = {play * (1.0 + 1e-6)}\n"}
    names = ["dwell-tolerance", "backlash-tolerance", "yield-tolerance"]
    both = findings(drum(table + "".join(limits.values())), names)
    assert {one.check: one.level for one in both} == {**dict.fromkeys(names[:2], "pass"), "yield-tolerance": level}
    alone = findings(drum(table + limits["play"]), names)
    assert [one.check for one in alone] == ["backlash-tolerance"], "one limit is judged by its own check"


def test_a_crown_on_a_straight_flank_touches_at_its_crest_alone() -> None:
    """On a turret too: what tilts its axis about its crest moves nothing, and there only where its crest has a wall."""
    text = (ROOT / "profiles" / "tool_changer.toml").read_text().partition("[tolerance]")[0]
    straight = Model(parse(text))
    crowned = Model(parse(text.replace('shape = "cylinder"', 'shape = "crowned"\ncrown_radius = 300')))
    theta = np.radians([0.0, 130.0, 180.0, 230.0])
    line, crest = (contacts(model.mechanism, theta) for model in (straight, crowned))
    assert 0 < crest.on.any(axis=2).sum() <= line.on.any(axis=2).sum()
    assert np.array_equal(crest.on.any(axis=2), crest.on.all(axis=2))
    tilt = Approaches(crest, default_pivots(crowned.mechanism)).of(CAUSES["roller_tilt_arcmin"])[0]
    level = Approaches(line, default_pivots(straight.mechanism)).of(CAUSES["roller_tilt_arcmin"])[0]
    assert np.abs(tilt[crest.on]).max() < 0.1 * np.abs(level[line.on]).max()


def test_a_tilt_takes_play_away_and_opens_none() -> None:
    """A roller askew in its groove touches both walls, each with an end; a gap opens by what it is."""
    rows = {row.cause.key: row for row in drum("axial_shift = 0.01").tolerances.sensitivities.rows}
    assert (rows["roller_tilt_arcmin"].play, rows["roller_tilt_arcmin"].preload) == (0.0, 0.0)
    assert rows["roller_tilt_arcmin"].motion.value > 1e-4
    assert rows["running_clearance"].play > 0.02
    assert rows["running_clearance"].preload == pytest.approx(0.01, rel=1e-9)


@pytest.mark.parametrize("limit", [1.002, 0.998])
def test_what_errors_explain_is_asked_only_where_it_says_what_to_tighten(limit: float) -> None:
    table = "samples = 2048\nside_shift = 0.01\nroller_place = 0.03\nmotion_limit = "
    study = disc(f"{table}1000").tolerances
    reached = study.loaded.shown(study.drawn.at_yield(study.drawn.motion, 0.99))
    made = disc(f"{table}{limit * reached!r}")
    (finding,) = findings(made, ["motion-tolerance"])
    passes = limit > 1.0
    assert finding.level == ("pass" if passes else "fail")
    assert ("shares" in vars(made.tolerances.drawn)) is not passes
    assert ("tighten tolerance.roller_place" in finding.advice) is not passes


def test_a_groove_that_has_run_out_on_one_side_tells_a_play_only_where_both_walls_stand() -> None:
    """Beside one wall the play has no end, nominally and with any error: its growth was infinity less infinity."""
    model = Model(read(ROOT / "profiles" / "feeder_runout.toml"))
    rows = {row.cause.key: row for row in model.tolerances.sensitivities.rows}
    assert all(np.isfinite([row.play, row.preload, row.motion.value]).all() for row in rows.values())
    assert rows["running_clearance"].play == pytest.approx(2.0 * rows["flank_growth"].play, rel=1e-9)
    assert rows["running_clearance"].preload == pytest.approx(10e-3, rel=1e-6)
    assert rows["phase_arcmin"].play == pytest.approx(0.0, abs=1e-15)


def test_a_follower_beside_one_wall_that_nothing_presses_is_refused() -> None:
    """It stands anywhere: its motion under any error was told as infinity less infinity, with a load it has a place."""
    table = {"axial_shift": 0.01, "dwell_limit": 30.0, "samples": 1000}
    for tolerance in (None, table):
        loose = model("feeder_runout", operation=None, limits={}, tolerance=tolerance).tolerances
        with pytest.raises(DesignError, match="one wall has run out and no load presses"):
            _ = loose.drawn if tolerance else loose.sensitivities.rows
    pressed = model("feeder_runout", tolerance=table).tolerances
    assert np.isfinite(pressed.drawn.dwell).all()
    assert np.isfinite(pressed.worst.curve).all()


@pytest.mark.parametrize(("held", "told"), [(1.001, ""), (0.999, r"errors at \d+ cam angles of the turn would take")])
def test_errors_of_many_cam_angles_have_a_bound(monkeypatch: pytest.MonkeyPatch, held: float, told: str) -> None:
    """Those of a table of 4 900 rows on an indexer took 2.4 GB."""
    from camgeom.tolerance import directions

    tried = disc("roller_diameter = 0.02").tolerances.sensitivities
    sizes = [(cause, 1.0) for cause in applicable(tried.loaded.mechanism)]
    own = directions.COPIES * Trials.of(tried.seated, sizes).errors.nbytes
    monkeypatch.setattr(directions, "MOST_HELD", held * own)
    tried = disc("roller_diameter = 0.02").tolerances.sensitivities
    if not told:
        assert tried.rows
        return
    with pytest.raises(NotConverged, match=told):
        _ = tried.rows


def test_few_at_a_time_is_all_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    model = Model(read(PROFILES / "tool_changer.toml"))
    together = {one.cause.key: one for one in model.tolerances.sensitivities.rows}
    for module in ("seat", "sensitivity", "directions"):
        monkeypatch.setattr(f"camgeom.tolerance.{module}.TOGETHER", 700)
    again = Model(read(PROFILES / "tool_changer.toml"))
    for one in again.tolerances.sensitivities.rows:
        known = together[one.cause.key]
        assert one.motion.value == pytest.approx(known.motion.value, rel=1e-9)
        assert (one.play, one.preload) == pytest.approx((known.play, known.preload), rel=1e-9, abs=1e-15)
        assert one.pressure == (known.pressure and pytest.approx(known.pressure, rel=1e-9))
