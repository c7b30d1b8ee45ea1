"""One machine with several followers: the errors of its body are one draw for all of them, each has its own beside."""

from __future__ import annotations

import json
from math import pi, radians
from pathlib import Path

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.checks.verdict import Finding
from camgeom.cli import main
from camgeom.drawing.content import Table
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.result import compute
from camgeom.report.sections import report
from camgeom.tolerance.causes import CAUSES
from tests.places import PROFILES
from tests.reference.rising_disc import rising_disc

DRUM = (PROFILES / "two_groove_drum.toml").read_text().partition("[tolerance]")[0].replace("to = 46", "to = 8")
STEEPEST = tuple(
    (peak * lift / radians(rise), -peak * lift / radians(back))
    for peak, lift, rise, back in ((1.7596, 8.0, 120.0, 130.0), (2.0, 18.0, 60.0, 70.0))
)
"""mm per rad of the cam in rise and return of both followers: modified sine and cycloid"""
MINUTE = pi / 10800.0
STATIONS = rising_disc(cam="bore = 20") + "[[station]]\nangle = 100\n[[station]]\nangle = 250\n"


def drum(lines: str) -> Model:
    return Model(parse(f"{DRUM}[tolerance]\n{lines}"))


def together(phase: float, place: float, limit: float, machines: int = 1_000_000) -> tuple[float, float, float]:
    """Shares of machines whose first, second and both followers keep within a limit, mm, by an own Monte Carlo.

    A cam ahead by phi moves a follower by its velocity times phi, at its steepest one way in the rise and the other in
    the return; its own place adds to that. Both errors are three standard deviations, arcmin and mm.
    """
    rng = np.random.default_rng(97)
    ahead = phase * MINUTE / 3.0 * rng.standard_normal(machines)
    kept = []
    for steepest in STEEPEST:
        beside = place / 3.0 * rng.standard_normal(machines)
        kept.append(np.max([np.abs(beside + steep * ahead) for steep in steepest], axis=0) <= limit)
    return float(kept[0].mean()), float(kept[1].mean()), float((kept[0] & kept[1]).mean())


@pytest.mark.parametrize(("phase", "place", "limit"), [(0.0, 0.03, 25.8), (3.0, 0.012, 22.0), (3.0, 0.0, 20.0),
                                                       (1.0, 0.025, 24.0)])  # fmt: skip
def test_the_yield_of_a_machine_is_that_of_an_own_monte_carlo(phase: float, place: float, limit: float) -> None:
    errors = f"phase_arcmin = {phase}\n" * bool(phase) + f"roller_place = {place}\n" * bool(place)
    model = drum(f"{errors}motion_limit = {limit}\nsamples = 100000\n")
    first, second, both = together(phase, place, 1e-3 * limit)
    alone = [one.tolerances.share() for one in model.bindings]
    assert alone == pytest.approx([first, second], abs=2.5e-3)
    assert model.machine_tolerances.share == pytest.approx(both, abs=2.5e-3)
    assert model.machine_tolerances.share <= min(alone)
    if place and not phase:
        assert model.machine_tolerances.share < min(alone) - 5e-3, "each has a place of its own"


@pytest.mark.parametrize(("error", "whose"), [
    ("phase_arcmin = 20", "body"), ("cam_eccentricity = 0.03", "body"), ("cam_wobble_arcmin = 30", "body"),
    ("axial_shift = 0.05\nskew_arcmin = 0.001", ""), ("flank_growth = 0.03", "track"), ("flank_form = 0.03", "track"),
    ("center_distance = 0.03", ""), ("roller_diameter = 0.03", ""), ("side_shift = 0.1", ""),
])  # fmt: skip
def test_followers_on_one_track_share_what_the_cam_has(error: str, whose: str) -> None:
    """One cam runs under all of them: its errors reach each as they reach the first, later; their own do not."""
    model = Model(parse(f"{STATIONS}[tolerance]\n{error}\nmotion_limit = 1e6\nsamples = 4000\n"))
    motions = [one.tolerances.drawn.motion for one in model.bindings]
    assert CAUSES[error.split(" ")[0]].shared == whose or "axial" in error
    for other in motions[1:]:
        assert np.array_equal(motions[0], other) is bool(whose)
        if not whose:
            assert abs(np.corrcoef(motions[0], other)[0, 1]) < 0.06
            assert np.quantile(motions[0], 0.5) == pytest.approx(np.quantile(other, 0.5), rel=0.08)


def test_walls_of_two_tracks_are_two() -> None:
    first, second = (one.tolerances.drawn.dwell for one in drum("flank_growth = 0.02\nsamples = 4000\n").bindings)
    assert abs(np.corrcoef(first, second)[0, 1]) < 0.06
    assert np.quantile(first, 0.5) == pytest.approx(np.quantile(second, 0.5), rel=0.08)


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
def test_the_yield_of_all_is_judged_though_each_alone_keeps_its_limit(share: float, level: str) -> None:
    """Two independent places, each within the limit in 99 % of the machines: both are in 98 %."""
    text = "roller_place = 0.03\nmotion_limit = 25.8\nsamples = 100000\nyield = {}\n"
    reached = drum(text.format(0.98)).machine_tolerances.share
    assert reached == pytest.approx(0.9804, abs=1.5e-3)
    verdict = judge(drum(text.format(share * reached)), ["motion-tolerance", "yield-tolerance"])
    levels = [(word.check, word.where.partition(":")[0], word.level) for word in verdict.findings]
    assert levels == [("motion-tolerance", "follower 1", "pass"), ("motion-tolerance", "follower 2", "pass"),
                      ("yield-tolerance", "all limits of all followers together", level)]  # fmt: skip


@pytest.mark.parametrize("errors", ["phase_arcmin = 3\n", "phase_arcmin = 3\nroller_place = 0.01\n"])
def test_the_widest_tolerances_hold_for_every_follower(errors: str) -> None:
    """0.999 of them pass every check, 1.02 fail one; the first follower alone would have let four times the phase."""
    text = "motion_limit = 20\nsamples = 20000\n"
    found = drum(errors + text).machine_tolerances.widest
    assert found is not None
    assert (found.values["phase_arcmin"] or 9.0) < 3.0
    for share, level in ((0.999, "pass"), (1.02, "fail")):
        lines = "".join(f"{key} = {share * (value or 0.0)}\n" for key, value in found.values.items())
        assert judge(drum(lines + text), ["motion-tolerance", "yield-tolerance"]).level == level


def test_the_command_names_every_follower(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "drum.toml"
    path.write_text(f"{DRUM}[tolerance]\nphase_arcmin = 3\nmotion_limit = 20\nsamples = 20000\n")
    assert main(["tolerance", str(path), "--json"]) == 1
    data = json.loads(capsys.readouterr().out)
    assert [one["follower"] for one in data["followers"]] == [1, 2]
    kept = [one["yield"] for one in data["followers"]]
    assert kept[0] == 1.0
    assert data["together"]["yield"] == kept[1] < 0.96
    assert data["together"]["widest"]["tolerances"]["phase_arcmin"] < 3.0
    assert not {"yield", "widest"} & data.keys()
    assert not any("widest" in one for one in data["followers"])
    assert main(["tolerance", str(path)]) == 1
    out = capsys.readouterr().out
    assert [line for line in out.splitlines() if line.startswith("follower")] == ["follower 1, track 1",
                                                                                "follower 2, track 2"]  # fmt: skip
    whole = out[out.index("all followers of a machine together") :]
    assert f"yield: {100.0 * kept[1]:.5g} % keep every limit of every follower; wanted 99 %" in whole
    assert out.count("widest tolerances") == 1
    path.write_text(DRUM)
    assert main(["tolerance", str(path), "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)["followers"]) == 2


def test_result_and_report_tell_what_all_keep() -> None:
    model = drum("phase_arcmin = 3\nmotion_limit = 20\nsamples = 20000\n")
    data = compute(model, ["tolerance"]).data
    assert data["together"]["tolerance"]["yield"] == data["followers"][0]["tolerance"]["yield"] < 0.96
    page = report(model, ["tolerance"])
    assert [one.title for one in page.sections] == ["Tolerances, follower 1", "Tolerances, follower 2"]
    tables = [block for one in page.sections for block in one.blocks if isinstance(block, Table)]
    (whole,) = (one for one in tables if one.caption.startswith("Every follower"))
    assert [row[0] for row in whole.rows] == ["1", "2", "all of a machine"]
    assert whole.rows[-1][2] == pytest.approx(100.0 * data["together"]["tolerance"]["yield"])
    assert sum("keep every limit of this follower" in one.caption for one in tables) == 2
    assert sum("widest" in one.caption for one in tables) == 1


def test_one_follower_is_told_as_ever() -> None:
    model = Model(parse(rising_disc() + "[tolerance]\ncenter_distance = 0.03\ndwell_limit = 20\nsamples = 4000\n"))
    assert model.machine_tolerances.share == model.tolerances.share()
    assert "together" not in compute(model, ["tolerance"]).data
    (page,) = report(model, ["tolerance"]).sections
    assert page.title == "Tolerances"
    assert all(isinstance(word, Finding) for word in judge(model, ["yield-tolerance"]).findings)
