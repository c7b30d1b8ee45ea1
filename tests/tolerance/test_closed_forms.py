"""First-order sensitivities against closed forms: discs, drums and turrets with radial rollers."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.model import Model
from camgeom.profile import parse, read
from camgeom.tolerance.causes import ARCMIN, CAUSES, Approaches, applicable, default_pivots
from camgeom.tolerance.contacts import Contacts, contacts
from camgeom.tolerance.seat import balance, bracket, room, walls_of
from tests.places import ROOT
from tests.reference.rising_disc import ROLLER, rising_disc

THETA = np.radians([15.0, 55.0, 88.0, 170.0, 215.0, 240.0])


def _moved(model: Model, theta: np.ndarray = THETA) -> tuple[Contacts, dict[str, np.ndarray]]:
    """Deviations of the coordinate per mm or rad of every error at every station, (parts, n, l, m)."""
    at = contacts(model.mechanism, theta)
    approaches = Approaches(at, default_pivots(model.mechanism))
    return at, {cause.key: -approaches.of(cause) / at.lever for cause in applicable(model.mechanism)}


def _disc(follower: str, roller: str = ROLLER, lift: float = 20.0) -> Model:
    return Model(parse(rising_disc(follower, roller, lift=lift)))


@pytest.mark.parametrize("offset", [0.0, 6.0, -9.0])
def test_a_roller_that_slides_on_a_disc(offset: float) -> None:
    """Along the line 1, across tan a, radius 1 / cos a, phase s': tan a = (s' + offset) / (r0 + s)."""
    model = _disc(f'kind = "translating"\noffset = {offset}')
    _, found = _moved(model)
    s, v = model.setup.program.jet(THETA, 1)
    tan = (v + offset) / (np.sqrt(45.0**2 - offset**2) + s)
    line = {key: value[..., 0, 3] for key, value in found.items()}
    # a follower mounted further out stands at a smaller coordinate
    assert line["center_distance"][0] == pytest.approx(-1.0, abs=1e-12)
    assert line["side_shift"][0] == pytest.approx(-tan, abs=1e-12)
    assert line["roller_diameter"][0] == pytest.approx(0.5 * np.hypot(1.0, tan), rel=1e-12)
    assert line["phase_arcmin"][0] == pytest.approx(v, abs=1e-9)


def test_the_bore_of_a_round_disc_beside_its_middle() -> None:
    """e cos(theta + theta0 - a) / cos a, sin a = offset / (Rb + r): an offset follower of a disc that stands still."""
    offset = 9.0
    text = rising_disc(f'kind = "translating"\noffset = {offset}', lift=0.0)
    model = Model(parse(text[: text.index("[[motion]]")] + "[[motion]]\nuntil = 360\n"))
    theta = np.linspace(0.1, 6.2, 37)
    _, found = _moved(model, theta)
    a = np.arcsin(offset / 45.0)
    for part, ahead in ((0, 0.0), (1, 0.5 * np.pi)):
        wanted = np.cos(theta + ahead - a) / np.cos(a)
        assert found["cam_eccentricity"][part][:, 0, 3] == pytest.approx(wanted, abs=1e-12)
    amplitude = np.hypot(*found["cam_eccentricity"][:, :, 0, 3])
    assert amplitude == pytest.approx(1.0 / np.cos(a)), "more than on a follower without offset"


def test_a_flat_face_feels_no_shift_across_and_its_tilt_by_the_lifts_derivative() -> None:
    model = _disc('kind = "translating"\nface = "flat"', "", 7.0)
    _, found = _moved(model)
    v = model.setup.program.jet(THETA, 1)[1]
    assert np.abs(found["side_shift"]).max() < 1e-12
    assert np.abs(found["face_squareness_arcmin"][0][:, 0, 3]) == pytest.approx(np.abs(v), abs=1e-9)


def test_a_12_mm_roller_on_a_tilted_disc_moves_the_same_way_for_both_signs() -> None:
    """A line contact touches at one end or the other: 6 mm times 1' either way, and never towards the cam."""
    model = _disc('kind = "translating"\noffset = -6')
    at = contacts(model.mechanism, THETA)
    walls = walls_of(at, np.zeros(len(THETA)), model.profile.material.roller, model.profile.material.cam, 0.0)
    tilt = Approaches(at, default_pivots(model.mechanism)).of(CAUSES["skew_arcmin"])[0]
    up, down = (walls.stand(sign * ARCMIN * tilt.reshape(len(THETA), -1)).low for sign in (1.0, -1.0))
    assert up == pytest.approx(6.0 * ARCMIN, rel=1e-12), "1.745 um"
    assert down == pytest.approx(up, rel=1e-12)
    both = Approaches(at, default_pivots(model.mechanism)).of(CAUSES["crossing_arcmin"])[0]
    askew = walls.stand(ARCMIN * (tilt + 0.05 * both).reshape(len(THETA), -1)).low
    assert np.all(askew >= up * 0.9)


def test_a_radial_roller_on_a_drum() -> None:
    """(x, y, z, tilt x, tilt y, phase) = (0, s'/rho, 1, -(z - z0) s'/rho, -rho, s'), rho the radius of the station."""
    model = Model(read(ROOT / "profiles" / "pin_insertion.toml"))
    theta = np.radians([170.0, 190.0, 230.0, 260.0, 300.0, 340.0])
    at, found = _moved(model, theta)
    s, v = model.setup.program.jet(theta, 1)
    for line in range(2):
        # stations count along the roller: their radius is that of its axis
        axial = np.einsum("inm,in->nm", at.x[:, :, line] - at.centre[:, :, line, None], at.axis[:, :, line])
        rho = at.centre[0][:, line, None] + axial
        z0 = 0.5 * model.profile.cam.mechanism(model.setup).envelope[1]
        z = 18.0 + s
        assert np.abs(found["center_distance"][0][:, line]).max() < 1e-12
        assert -found["side_shift"][0][:, line] == pytest.approx(v[:, None] / rho, abs=1e-9)
        assert found["axial_shift"][0][:, line] == pytest.approx(1.0, abs=1e-12)
        assert found["crossing_arcmin"][0][:, line] == pytest.approx(-(z - z0)[:, None] * v[:, None] / rho, abs=1e-6)
        assert found["skew_arcmin"][0][:, line] == pytest.approx(-rho, abs=1e-9)
        assert found["phase_arcmin"][0][:, line] == pytest.approx(np.broadcast_to(v[:, None], rho.shape), abs=1e-9)


def test_radial_cylinders_on_a_turret() -> None:
    """Pitch radius nothing at all; x sin tau / delta, z cos tau / delta, y tan a / delta, tilt x -sin tau tan a, tilt y
    1 - C cos tau / delta, diameter 1 / (2 delta cos a)."""
    model = Model(read(ROOT / "profiles" / "tool_changer.toml"))
    theta = np.radians([5.0, 130.0, 165.0, 190.0, 230.0])
    at, found = _moved(model, theta)
    centre, lift = 180.0, model.setup.program.jet(theta, 1)
    for line in range(at.on.shape[1]):
        rows = np.flatnonzero(at.on[:, line].all(axis=1))
        if not len(rows):
            continue
        axis = at.axis[:, rows, line]
        tau = np.arctan2(axis[2], -axis[0])[:, None]
        away = at.x[:, rows, line] - np.array([centre, 0.0, 0.0])[:, None, None]
        delta = np.einsum("inm,in->nm", away, axis)
        got = {key: value[:, rows, line] for key, value in found.items()}
        assert np.abs(got["pitch_radius"]).max() < 1e-12
        assert np.abs(got["pitch_angle_arcsec"][0]) == pytest.approx(1.0, rel=1e-12)
        assert np.abs(got["center_distance"][0]) == pytest.approx(np.abs(np.sin(tau) / delta), rel=1e-9)
        assert np.abs(got["axial_shift"][0]) == pytest.approx(np.abs(np.cos(tau) / delta), rel=1e-9)
        tan = np.abs(lift[1][rows, None]) * delta / (centre - delta * np.cos(tau))
        assert np.abs(got["side_shift"][0] * delta) == pytest.approx(tan, abs=1e-9)
        assert np.abs(got["crossing_arcmin"][0]) == pytest.approx(np.abs(np.sin(tau)) * tan, abs=1e-9)
        assert np.abs(got["skew_arcmin"][0]) == pytest.approx(np.abs(1.0 - centre * np.cos(tau) / delta), rel=1e-9)
        wanted = np.hypot(1.0, tan) / (2.0 * delta)
        assert np.abs(got["roller_diameter"][0]) == pytest.approx(wanted, rel=1e-9)


@pytest.mark.parametrize("start", [-0.002, -0.001, 0.004, None])
def test_a_balance_between_two_walls_does_not_leap_from_end_to_end(start: float | None) -> None:
    """From one rigid bound Newton's step, on the one wall that presses there, ends at the other bound, and back."""
    lever, stiffness = np.array([[-20.0], [25.0]]), np.array([[3.0e5], [3.0e5 * 16.0 / 25.0]])
    approach = -lever * np.array([[-0.001], [-0.002]])
    ends = bracket(np.array([-0.001]), np.array([-0.002]), room(lever, stiffness, np.zeros(1)))
    psi = balance(approach, lever, stiffness, np.zeros(1), *ends, None if start is None else np.array([start]))
    force = stiffness * np.maximum(approach + lever * psi, 0.0)
    assert float(np.sum(-lever * force)) == pytest.approx(0.0, abs=1e-6 * float(np.abs(lever * force).max()))
    assert -0.002 < psi[0] < -0.001
