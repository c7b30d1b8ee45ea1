"""A roller is judged at its ends too: there a curved flank presses it hardest, and no slice has its middle there.

The oracle has 2 001 places along the roller, the flank's curvature and lever there, and a bisection of its own for the
approach that all have in common: of a roller to its axis and of a cam to the roller's diameter, by K. L. Johnson,
Contact Mechanics (1985), section 5.6.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from camgeom.maths import Floats
from camgeom.mechanics.roller_duty import RollerDuty
from camgeom.mechanics.turret_duty import TurretDuty
from camgeom.model import Model
from camgeom.track import TURN
from camgeom.track.flank import Flank
from tests.reference.profiles import model, said

ROLLER, CAM = (208e3, 0.30), (218e3, 0.28)
"""modulus, MPa, and Poisson's ratio of the profile's materials"""
SOFT = tuple((1.0 - poisson**2) / modulus for modulus, poisson in (ROLLER, CAM))
PLACES = 2001


def loads(force: float, k: Floats, lever: Floats, width: Floats, radius: Floats) -> Floats:
    """Load per length, N/mm, of lines that approach alike: w f(w) = d lever, with f = (1 - nu²) / (pi E) times
    2 ln(4 R / b) - 1 of the roller and 2 ln(4 R / b) - nu / (1 - nu) of the cam."""

    def line(approach: float) -> Floats:
        w = approach * lever / (10.0 * sum(SOFT) / math.pi)
        for _ in range(80):
            far = np.log(4.0 * radius / np.sqrt(4.0 * w * sum(SOFT) / (math.pi * k)))
            flex = SOFT[0] * (2.0 * far - 1.0) + SOFT[1] * (2.0 * far - CAM[1] / (1.0 - CAM[1]))
            w = approach * lever * math.pi / flex
        return np.asarray(w)

    def rest(approach: float) -> float:
        return float((line(approach) * lever * width).sum()) - force

    return line(brentq(rest, 1e-9, 0.05, xtol=1e-15))


def hertz(line: Floats, k: Floats) -> Floats:
    return np.asarray(np.sqrt(line * k / (math.pi * sum(SOFT))))


def along(duty: RollerDuty, theta: float) -> tuple[Floats, Floats]:
    """Places along the roller, mm, and the pressure there, MPa, by the oracle."""
    at = duty.force.panels.at
    low, high = (float(at(end, np.array([theta]))[0]) for end in duty.pressing.stretch)
    force = float(at(duty.pressing.pushed, np.array([theta]))[0])
    delta = np.linspace(low, high, PLACES)
    for side in duty.track.sides:
        flank = Flank(duty.track, np.array([theta]), duty.track.meridian.parameters(delta), side)
        if flank.behind == (force >= 0.0):
            k, lever = flank.k_rel[0], np.abs(flank.lever()[0])
    width = np.full(PLACES, (high - low) / (PLACES - 1))
    width[[0, -1]] *= 0.5
    radius = duty.track.meridian.jet(duty.track.meridian.parameters(delta))[3]
    return delta, hertz(loads(abs(force), k, lever, width, radius), k)


LONG: dict[str, Any] = {
    "cam__diameter": 80.0, "cam__pitch_radius": 27.0, "cam__groove_depth": 26.0, "cam__bore": 15.0,
    "cam__keyway_width": 5.0, "cam__keyway_depth": 2.3, "roller__length": 25.0, "roller__diameter": 16.0,
    "motion": ({"until": 155.0}, {"until": 255.0, "to": 15.0, "law": "cycloidal"}, {"until": 260.0},
               {"until": 360.0, "to": 0.0, "law": "cycloidal"}),
    "operation__force": ({"from": 0.0, "until": 360.0, "expression": "400"},),
}  # fmt: skip


def drum(**changed: Any) -> Model:
    return model("pin_insertion", **changed)


@pytest.mark.parametrize("changed", [{}, LONG])
def test_a_drums_roller_is_hardest_at_its_end(changed: dict[str, Any]) -> None:
    duty = drum(**changed).duty
    peak = duty.peak_pressure
    assert peak is not None
    delta, pressure = along(duty, peak.cam_angle)
    hardest = int(np.argmax(pressure))
    assert hardest in (0, PLACES - 1)
    assert peak.place == pytest.approx(float(delta[hardest]), abs=1e-9)
    # Nine slices share the force as well as 2 000 do within a thousandth; the place is no slice's middle.
    assert peak.value == pytest.approx(float(pressure[hardest]), rel=1e-3)


@pytest.mark.parametrize("angle", [10.0, -10.0])
def test_a_cone_yields_at_every_place_by_its_radius_there(angle: float) -> None:
    """By the radius of its middle the thin end was told 1 to 5 % too low."""
    duty = drum(roller__shape="cone", roller__half_angle=angle).duty
    peak = duty.peak_pressure
    assert peak is not None
    delta, pressure = along(duty, peak.cam_angle)
    hardest = int(np.argmax(pressure))
    assert peak.place == pytest.approx(float(delta[hardest]), abs=1e-9)
    assert peak.value == pytest.approx(float(pressure[hardest]), rel=1e-3)


@pytest.mark.parametrize(("share", "level"), [(1.002, "pass"), (0.998, "fail")])
def test_a_long_roller_on_a_thin_drum_is_judged_by_its_end(share: float, level: str) -> None:
    duty = drum(**LONG).duty
    peak = duty.peak_pressure
    assert peak is not None
    _, pressure = along(duty, peak.cam_angle)
    assert pressure.max() > 1.2 * pressure[PLACES // 18 :: PLACES // 9][:9].max(), "of the middles of nine slices"
    found = said(drum(**LONG, limits__contact_pressure_mpa=share * float(pressure.max())), "contact-pressure")
    assert [one.level for one in found] == [level]


@pytest.mark.parametrize("name", ["tool_changer", "globoidal_drive", "barrel_indexer"])
def test_a_turrets_rollers_are_judged_at_their_ends(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Beside 301 slices, whose outermost all but reaches the end."""
    told = model(name).turret_duty
    assert told is not None
    at, few = told.least_peak, told.engagement.stations
    fine = finely(name, at.cam_angle, monkeypatch)
    assert at.value == pytest.approx(fine.max(), rel=2e-3)
    inner = fine[:, :, 301 // len(few) :: 301 // len(few)][:, :, :-1]
    assert at.value > 1.0005 * inner.max()


def finely(name: str, theta: float, monkeypatch: pytest.MonkeyPatch) -> Floats:
    """Pressure of 301 slices of every roller at a cam angle, MPa, (1, k, m)."""
    with monkeypatch.context() as patch:
        patch.setattr("camgeom.track.turret.SLICES", 301)
        duty = model(name).turret_duty
        assert isinstance(duty, TurretDuty)
        e = duty.beside.once(np.array([theta % TURN]))
        load = duty._loads(e)[0].sum(axis=0)
        way = 0 if float(duty._torque_on(np.array([theta % TURN]))[0]) >= 0.0 else 1
        return duty._as_line(load, e.curvature[way])


@pytest.mark.parametrize(("side", "angle", "force"), [("left", 0.0, "-1e6"), ("right", -100.0, "1e6")])
def test_a_roller_that_nothing_ever_presses_has_no_stress(side: str, angle: float, force: str) -> None:
    duty = model(
        "linear_edge", follower__kind="swinging", follower__arm=200.0, follower__start_angle=angle, follower__side=side,
        follower__inertia=0.01, follower__mass=None, limits__pressure_angle_deg=None,
        operation__force=({"from": 0.0, "until": 360.0, "expression": force},),
    ).duty  # fmt: skip
    below, deepest = duty.peak_contact, duty.deepest_shear
    assert below is not None
    assert deepest is not None
    assert (below.half_width, below.shear, deepest.value) == (0.0, 0.0, 0.0)
