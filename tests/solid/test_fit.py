"""Rollers in the finished mesh: neither do they cut into it, nor does it stand back from them, nor is it rougher than
it says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.model import Model, read
from camgeom.solid import Solid
from tests.places import PROFILES

TURRETS = ["barrel_indexer", "conical_indexer", "fine_indexer", "tool_changer", "two_start"]


def model(name: str, *solids: Solid) -> Model:
    made = read(str(PROFILES / f"{name}.toml"))
    if solids:
        made.body.__dict__["solids"] = solids
    return made


def cut_by(name: str, gap: float, tolerance: float) -> Solid:
    """The body that rollers larger by `gap` mm leave."""
    (part,) = model(name).parts
    if hasattr(part, "track"):
        return replace(part, track=part.track.grown(gap)).solid(tolerance)
    return replace(part, tracks=tuple(track.grown(gap) for track in part.tracks)).solid(tolerance)


def told(made: Model, check: str):
    (finding,) = judge(made, [check]).findings
    return finding


@pytest.mark.parametrize("name", TURRETS)
def test_a_larger_roller_of_many_stops_cuts_in(name) -> None:
    """Flanks of many stops have vertices on seams alone: these too are on the surface, and have no slack."""
    made = model(name)
    solid = made.solid
    on_flank = solid.mesh.group_vertices("flank")
    assert np.mean(solid.cut_vertices[on_flank]) < 0.1
    touch, larger = (min(c.value for c in made.clearances_with(grow)) for grow in (0.0, 5e-3))
    assert larger == pytest.approx(touch - 5e-3, abs=1e-6)


@pytest.mark.parametrize("name", ["pin_insertion", "tool_changer", "milled_drum"])
def test_a_mesh_rougher_than_it_says_is_found(name) -> None:
    (part,) = model(name).parts
    rough = part.solid(0.5)
    assert told(model(name, rough), "interference").level == "pass"
    lying = told(model(name, replace(rough, chord_error=0.004)), "interference")
    assert lying.level == "fail"
    assert lying.value < -0.05
    assert "rougher" in lying.advice


@pytest.mark.parametrize("name", ["pin_insertion", "steep_shuttle", "tool_changer", "barrel_indexer"])
def test_a_flank_cut_too_deep_is_backlash(name) -> None:
    sound = model(name)
    finding = told(sound, "backlash")
    assert finding.level == "pass"
    assert finding.limit == pytest.approx(sound.mechanism.running_clearance + sound.solid.chord_error)
    deep = model(name, cut_by(name, 0.05, sound.tolerance))
    finding = told(deep, "backlash")
    assert finding.level == "fail"
    assert finding.value == pytest.approx(sound.mechanism.running_clearance + 0.05, abs=sound.tolerance)
    assert told(deep, "interference").level == "pass"


@pytest.mark.parametrize(("share", "level"), [(0.999, "pass"), (1.002, "fail")])
def test_the_limit_of_backlash_has_two_sides(share, level) -> None:
    body = cut_by("pin_insertion", 0.0, 0.004)
    limit = body.chord_error
    deep = replace(cut_by("pin_insertion", share * limit, 0.004), chord_error=limit)
    finding = told(model("pin_insertion", deep), "backlash")
    assert finding.value == pytest.approx(share * limit, rel=1e-6)
    assert finding.level == level


@pytest.mark.parametrize("name", ["conjugate_rocker", "disc_face_groove", "disc_offset_roller", "fine_indexer"])
def test_other_shipped_bodies_have_the_backlash_they_ask_for(name) -> None:
    made = model(name)
    for finding in judge(made, ["backlash"]).findings:
        assert finding.level == "pass"
        assert finding.value >= made.mechanism.running_clearance - 1e-9


def test_walls_that_nothing_touches_have_no_backlash() -> None:
    assert judge(model("parallel_index"), ["backlash"]).findings == ()
    assert judge(model("disc_flat_face"), ["backlash"]).findings == ()
