"""Refusals and findings that name the right cause: arcs that leave a drum sideways, walls beside balls."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from camgeom.checks import judge
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track.column import Column, cylinder_level
from tests.places import PROFILES
from tests.reference.barrels import barrel

RADIUS = 67.0


def swinging(arm: float, swing: float, **follower) -> Model:
    data, _, _ = load((PROFILES / "pin_insertion.toml").read_text(encoding="utf-8"), "")
    data["cam"] = data["cam"] | {"length": 400, "start": 100}
    data["follower"] = {"kind": "swinging", "arm": arm, "inertia": 0.01} | follower
    data["motion"] = (
        {"until": 180, "to": swing, "law": "cycloidal"}, {"until": 240}, {"until": 360, "to": 0, "law": "cycloidal"},
    )
    data["limits"] = {"pressure_angle_deg": 70}
    return Model(from_data({k: v for k, v in data.items() if k != "operation"}, ""))


@pytest.mark.parametrize(("share", "refused"), [(0.999, False), (1.002, True)])
def test_an_arc_may_not_pass_beside_the_drum(share, refused) -> None:
    # From the tangent point inwards the arc leaves the axis plane by arm (1 - cos): as much as the drum's radius.
    arm = 200.0
    swing = np.degrees(np.arccos(1.0 - share * RADIUS / arm))
    if not refused:
        assert swinging(arm, swing, pivot_distance=arm).mechanism
        return
    with pytest.raises(ProfileError, match=r"pivot_distance.*beside the axis") as told:
        swinging(arm, swing, pivot_distance=arm)
    # What it allows is built.
    allowed = str(told.value).split("allowed: ")[1]
    low, high = float(allowed.split(" .. ")[0]), float(allowed.split(" .. ")[1].split(" mm")[0])
    assert low == pytest.approx(arm - RADIUS)
    assert high == pytest.approx(arm * np.cos(radians(swing)) + RADIUS, rel=1e-5)
    assert swinging(arm, swing, pivot_distance=high - 0.1).mechanism


def test_an_arc_that_bulges_more_than_the_drum_wants_another_arm() -> None:
    with pytest.raises(ProfileError, match=r"follower\.arm.*longer arm"):
        swinging(200.0, 75.0)
    assert swinging(200.0, 65.0).mechanism


def test_a_flank_that_leaves_the_drum_sideways_says_so() -> None:
    arm = 200.0
    model = swinging(arm, np.degrees(np.arccos(1.0 - 0.97 * RADIUS / arm)), pivot_distance=arm)
    (track,) = model.tracks
    said = []
    for phi in np.linspace(0.0, 6.2, 200):
        for side in track.sides:
            try:
                Column(track, np.array([phi])).reach(side, cylinder_level(RADIUS), RADIUS)
            except DesignError as refusal:
                said.append(str(refusal))
    assert said
    assert all("sideways" in text for text in said)


@pytest.mark.parametrize("width", [60.0, 70.0, 78.0])
def test_beside_balls_stand_no_horns(width) -> None:
    model = barrel(width, "sphere")
    assert judge(model, ["horns"]).findings == ()
    assert all(f.level == "pass" for f in judge(model, ["watertight", "interference", "backlash"]).findings)


def test_beside_cylinders_a_hoop_is_found() -> None:
    levels = {w: [f.level for f in judge(barrel(w, "cylinder"), ["horns"]).findings] for w in (78.0, 94.0)}
    assert levels == {78.0: ["pass"], 94.0: ["fail"]}
