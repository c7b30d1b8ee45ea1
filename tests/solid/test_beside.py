"""What a follower must not touch: rollers beside the other disc or the dial, the pivot beside the disc."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.errors import ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.track.beside import least_across

SLIDE = """
name = "slide"
[cam]
kind = "conjugate"
base_radius = 100
return_radius = 40
width = 20
gap = 4
[follower]
kind = "translating"
mass = 1
[roller]
diameter = 30
length = 20
[[motion]]
until = 140
to = 20
law = "cycloidal"
[[motion]]
until = 180
[[motion]]
until = 320
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""
PIVOTED = """
name = "arm"
[cam]
kind = "disc"
base_radius = 50
width = 12
[follower]
kind = "swinging"
arm = 50
[roller]
diameter = 20
length = 12
[[motion]]
until = 120
to = 8
law = "cycloidal"
[[motion]]
until = 150
[[motion]]
until = 270
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""


def made(text: str, **changed: dict[str, Any]) -> Model:
    data = load(text, "")[0]
    for section, keys in changed.items():
        data[section] = {**data.get(section, {}), **keys}
    return Model(from_data(data, ""))


@pytest.mark.parametrize(("length", "level"), [(20.0, "pass"), (27.99, "pass"), (28.0, "fail"), (30.0, "fail")])
def test_rollers_of_a_pair_end_before_the_other_disc(length: float, level: str) -> None:
    """Discs of 20 mm, 4 mm apart: a roller in the middle of its disc reaches the other one when 28 mm long."""
    found = judge(made(starter("conjugate"), roller={"length": length}), ["neighbour"]).findings
    assert {f.where.partition(",")[0] for f in found} == {"main roller to return disc", "return roller to main disc"}
    assert {f.level for f in found} == {level}
    assert all(f.value == pytest.approx(14.0 - 0.5 * length, abs=1e-9) for f in found)


@pytest.mark.parametrize(("length", "axial"), [(70.0, -21.0), (80.0, -26.0)])
def test_a_roller_through_the_other_disc_is_in_it_by_as_much_as_it_reaches(length: float, axial: float) -> None:
    """The published pair: the main roller's centre runs 16.6 mm within the return disc, its circle 20 mm further."""
    found = {f.where.partition(" roller")[0]: f
             for f in judge(made(starter("conjugate"), roller={"length": length}), ["neighbour"]).findings}  # fmt: skip
    assert {f.level for f in found.values()} == {"fail"}
    assert found["main"].value == pytest.approx(max(axial, -36.6), abs=0.1)


def test_a_long_roller_may_stand_beside_a_disc_that_it_clears() -> None:
    """The main roller runs outside a small return disc; the return roller, as long, runs into the large main disc."""
    model = made(SLIDE, roller={"length": 30.0})
    main, back = judge(model, ["neighbour"]).findings
    assert (main.level, back.level) == ("pass", "fail")
    assert back.value == pytest.approx(-1.0)
    for share, level in ((0.999, "pass"), (1.002, "fail")):
        tight = made(SLIDE, roller={"length": 30.0}, limits={"clearance_mm": share * main.value})
        assert judge(tight, ["neighbour"]).findings[0].level == level


@pytest.mark.parametrize("number", [0, 1])
def test_the_distance_across_is_that_of_many_samples(number: int) -> None:
    """Of the path of the roller's centre and the outline: outside the nearest, inside the deepest."""
    beside = made(SLIDE).mechanism.neighbours[number]
    phi = np.linspace(0.0, 2.0 * np.pi, 20001)
    apart = cKDTree(beside.sections[0][1].curve(phi).points.T).query(beside.track.pose(phi, 0).a[0][:2].T)[0]
    sampled = apart.min() if number == 0 else -apart.max()
    found = least_across(beside.track, beside.sections[0][1], 15.0).value
    assert found == pytest.approx(sampled - 15.0, abs=(1e-6, 1e-3)[number])


def test_rollers_of_plates_leave_room_for_the_dial_between_them() -> None:
    """Plates of 14 mm, 20 mm apart: of the gap 18 mm are the dial's, less what rollers stand out of their plates."""
    for length, thick in ((12.0, 18.0), (14.0, 18.0), (24.0, 8.0), (31.0, 1.0), (31.1, 0.9)):
        model = made(starter("parallel-index"), roller={"length": length})
        found = next(f for f in judge(model, ["wall"]).findings if f.where.startswith("dial"))
        assert found.value == pytest.approx(thick)
        assert found.level == ("pass" if thick > 0.99 else "fail")
    with pytest.raises(ProfileError, match=r"roller\.length.*32 mm"):
        made(starter("parallel-index"), roller={"length": 120.0})


@pytest.mark.parametrize("face", ["roller", "curved"])
def test_a_pivot_within_the_circle_of_the_disc_is_told(face: str) -> None:
    follower = {} if face == "roller" else {"face": "curved", "face_radius": 10.0}
    text = PIVOTED if face == "roller" else PIVOTED.replace("[roller]\ndiameter = 20\nlength = 12\n", "")

    def at(centre: float) -> Model:
        return made(text, cam={"center_distance": centre}, follower=follower)

    (inside,) = judge(at(55.0), ["pivot"]).findings
    assert inside.level == "warn"
    assert "beside" in inside.advice
    model = at(55.0)
    phi = np.linspace(0.0, 2.0 * np.pi, 20001)
    swept = np.hypot(*model.mechanism.outlines["profile"].curve(phi).points).max()
    assert inside.value == pytest.approx(55.0 - swept, abs=1e-6)
    assert judge(at(90.0), ["pivot"]).findings[0].level == "pass"
    clear = judge(at(90.0), ["pivot"]).findings[0].value
    for share, level in ((0.999, "pass"), (1.002, "warn")):
        tight = made(text, cam={"center_distance": 90.0}, limits={"clearance_mm": share * clear}, follower=follower)
        assert judge(tight, ["pivot"]).findings[0].level == level


def test_an_arm_in_a_face_groove_and_a_slide_have_no_pivot_to_judge() -> None:
    assert judge(made(SLIDE), ["pivot"]).findings == ()
    groove = {"form": "groove", "diameter": 200.0, "groove_depth": 8.0, "center_distance": 55.0}
    assert judge(made(PIVOTED, cam=groove, roller={"length": 7.0}), ["pivot"]).findings == ()
