"""The stiffness of a tappet on its cam, from the contact itself: line, ellipse or half-space, tangent or secant."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest

from camgeom.cams import starter
from camgeom.errors import DesignError, ProfileError
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from camgeom.report.result import compute
from tests.places import PROFILES

SHAPES = (
    ("ellipse", {}),
    ("finite", {"crown_radius": None, "crown": "logarithmic"}),
    ("line", {"crown_radius": None, "shape": "cylinder"}),
)


def tapping(roller: dict[str, Any], **dynamics: Any) -> dict[str, Any]:
    data: dict[str, Any] = load((PROFILES / "disc_offset_roller.toml").read_text(), "disc")[0]
    data["roller"] = {key: value for key, value in (data["roller"] | roller).items() if value is not None}
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 900, "linkage_damping": 60, "tappet_mass": 0.2}
    data["dynamics"] |= dynamics
    return data


@pytest.mark.parametrize(("level", "roller"), SHAPES)
@pytest.mark.parametrize("which", ["tangent", "secant"])
def test_the_tappet_stands_on_its_contact(level: str, roller: dict[str, Any], which: str) -> None:
    """Along the motion: times the square of the lever; the two masses on their two springs swing as they should."""
    model = Model(from_data(tapping(roller, tappet_contact=which), "disc"))
    duty = model.duty
    assert duty.level == level
    angle = np.array([duty.least_peak.cam_angle])
    lever = float(duty.force.panels.at(duty.pressing.reference.lever, angle)[0])
    each = {"tangent": duty.stiffness.tangent, "secant": duty.stiffness.secant}[which]
    assert model.elastic_follower is not None
    train = model.elastic_follower.train
    assert train.contact_stiffness == pytest.approx(1e3 * each * lever**2, rel=1e-9)
    # Masses of 0.7 and 0.2 kg, 900 N/mm between them, the contact below, the spring of 5 N/mm above.
    one, two, contact = 900e3, 5e3, train.contact_stiffness
    matrix = np.array([[(one + two) / 0.7, -one / 0.7], [-one / 0.2, (one + contact) / 0.2]])
    wanted = np.sqrt(np.sort(np.linalg.eigvals(matrix))) / (2.0 * pi)
    found = model.elastic_follower.summary(False)["frequencies_hz"]
    assert found == pytest.approx(wanted.tolist(), rel=1e-6)


def test_a_point_is_softer_than_a_line_and_the_result_says_which() -> None:
    found = {}
    for level, roller in SHAPES:
        model = Model(from_data(tapping(roller, tappet_contact="tangent"), "disc"))
        shown = compute(model, ("dynamics",)).data["dynamics"]
        assert shown["tappet_stiffness_is"] == f"tangent of the contact, {level}"
        found[level] = shown["tappet_stiffness_n_mm"]
    assert found["ellipse"] < 0.5 * found["line"]
    assert found["ellipse"] < found["finite"] < found["line"]


@pytest.mark.parametrize(
    ("dynamics", "reason"),
    [
        ({"tappet_contact": "tangent", "tappet_stiffness": 1e4}, "leave it or tappet_contact out"),
        ({"tappet_contact": "tangent", "tappet_mass": 0.0}, "tappet_contact needs a tappet_mass"),
        ({"tappet_contact": "chord"}, "tappet_contact"),
    ],
)
def test_what_contradicts_is_refused(dynamics: dict[str, Any], reason: str) -> None:
    with pytest.raises(ProfileError, match=reason):
        from_data(tapping({}, **dynamics), "disc")


def test_a_follower_without_a_roller_gives_its_stiffness_itself() -> None:
    data = load((PROFILES / "disc_flat_face.toml").read_text(), "disc")[0]
    data["dynamics"] = {"kind": "follower", "linkage_stiffness": 900, "tappet_mass": 0.05, "tappet_contact": "tangent"}
    with pytest.raises(ProfileError, match=r"dynamics\.tappet_contact"):
        _ = Model(from_data(data, "disc")).elastic_follower
    drum = load(starter("cylindrical"), "drum")[0]
    drum["dynamics"] = {"kind": "follower", "linkage_stiffness": 900, "tappet_mass": 0.3, "tappet_contact": "secant"}
    study = Model(from_data(drum, "drum")).elastic_follower
    assert study is not None
    assert study.train.contact_stiffness > 1e7


@pytest.mark.parametrize(("force", "why"), [("0", "presses nothing"), ("1e-3", "")])
def test_a_contact_without_a_load_has_no_stiffness(force: str, why: str) -> None:
    data = tapping({"crown_radius": None, "shape": "cylinder"}, tappet_contact="secant")
    data["operation"] = {"speed": 60.0, "force": ({"expression": force},)}
    data["motion"] = ({"until": 360.0},)
    model = Model(from_data(data, "disc"))
    if why:
        with pytest.raises(DesignError, match=rf"the rigid load {why}.*give dynamics\.tappet_stiffness"):
            _ = model.elastic_follower
    else:
        assert model.elastic_follower is not None
