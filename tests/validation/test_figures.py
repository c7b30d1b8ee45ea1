"""The figures of the sources: their curves meet the numbers that the sources print of them, or the entries say why."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from camgeom.drawing.content import Block, Chart, Series
from camgeom.validation import SOURCES
from camgeom.validation.figures import conjugate, figures

BY_SHORT = {source.short: {figure.place: figure for figure in figures(source)} for source in SOURCES}


@cache
def _drawn(short: str, place: str) -> tuple[Block, ...]:
    """A figure, drawn once: some take seconds."""
    return tuple(BY_SHORT[short][place].draw())


def _series(block: Block, panel: int = 0) -> dict[str, Series]:
    assert isinstance(block, Chart)
    return {series.name: series for series in block.panels[panel].series}


def test_every_source_with_curves_has_its_figures() -> None:
    places = {short: set(found) for short, found in BY_SHORT.items()}
    assert places["S1"] >= {"Fig. 5", "Fig. 6", "Fig. 7", "Fig. 8", "Fig. 9"}
    assert places["S2"] == {"Fig. 3", "Fig. 4", "Fig. 5"}
    assert places["S3"] == set()
    assert places["S4"] == {"Fig. 5", "Fig. 6", "Fig. 7"}
    assert places["S5"] >= {"Fig. 11", "Fig. 12", "Fig. 13", "Fig. 14", "Fig. 15", "Fig. 16"}


def test_loads_of_the_groove_cam_add_up() -> None:
    (chart,) = _drawn("S1", "Figs. 2, 3")
    force = _series(chart)
    parts = force["inertia I"].y + force["friction F1 + F2"].y + force["pin hole F3"].y
    assert parts == pytest.approx(force["sum Fx"].y, abs=1e-9)
    omega, stroke, span = 20.0 * np.pi, 74.0, np.radians(70.0)
    peak = 2.25e-3 * omega**2 * 2.0 * np.pi * stroke / span**2 + 8.3
    assert np.abs(force["sum Fx"].y).max() == pytest.approx(peak, rel=1e-6)
    assert force["pin hole F3"].y.min() > -1e-9
    assert force["pin hole F3"].y.max() > 1.0


def test_the_papers_lives_meet_its_numbers_and_small_drums_have_none() -> None:
    papers, ours = _drawn("S1", "Fig. 7")
    claimed, true = _series(papers), _series(ours)
    assert len([name for name in claimed if name.endswith(" mm")]) == 7
    line, printed = claimed["22 mm"], claimed["printed"]
    assert np.interp(printed.x, line.x, line.y) == pytest.approx(printed.y, rel=0.05)
    assert true["22 mm"].x.min() == 115.0, "the smallest drum with a groove has 114.33 mm"
    dotted = claimed["undercut: no groove"]
    assert {110.0} < set(dotted.x[np.isin(dotted.y, line.y)].tolist())
    assert 115.0 not in dotted.x[np.isin(dotted.y, line.y)]


def test_the_paper_left_out_a_term_of_its_first_frequency() -> None:
    (chart,) = _drawn("S4", "Fig. 5")
    lines = _series(chart)
    assert lines["exact"].y.min() == pytest.approx(245.686, abs=1e-3)
    assert lines["without K12 τ'²"].y.min() == pytest.approx(165.688, abs=1e-3)
    assert _series(chart, 2)["exact"].y.max() == pytest.approx(3408.347, abs=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize("short", ["S1", "S2", "S4", "S5"])
def test_every_figure_can_be_drawn(short: str, monkeypatch: pytest.MonkeyPatch) -> None:
    # Fig. 14 of S5 solves nine clearances for each law of contact: two are enough to be drawn.
    monkeypatch.setattr(conjugate, "CONTACTS", list(conjugate.CONTACTS)[:2])
    for place in BY_SHORT[short]:
        assert _drawn(short, place), place
