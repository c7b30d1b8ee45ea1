"""Stress and life of the groove cam's roller against the published case and against plain counting."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy import integrate, optimize

from camgeom.errors import DesignError, NotConverged
from camgeom.maths.panels import TURN
from camgeom.mechanics import groove
from camgeom.mechanics.contact import Contact, line_contacts
from camgeom.mechanics.groove import groove_contact
from camgeom.mechanics.life import cam_life, damage_profile, roller_life
from camgeom.mechanics.load import Load
from camgeom.mechanics.material import STEEL, Material, pair_compliance
from tests.reference.pin_machine import (
    CAM,
    LENGTH,
    PIN_MOTION,
    PITCH_RADIUS,
    ROLLER,
    ROLLER_RADIUS,
    SPEED,
    Cycloids,
    pin_load,
)

LOAD = pin_load().sampled()
TABLE = {
    "developed": (989.908, 313.714, 48231.0),
    "published": (1178.359, 309.124, 16971.0),
    "flat": (1072.765, 311.831, 32708.9),
    "developed-wall": (998.895, 313.363, None),
    "exact": (1004.677, 313.346, 45347.0),
}


def pin_contact(convention="exact", pitch=PITCH_RADIUS, radius=ROLLER_RADIUS, length=LENGTH, load=LOAD):
    return groove_contact(load, pitch, radius, length, ROLLER, CAM, convention)


@pytest.mark.parametrize("convention", TABLE)
def test_pin_machine_table(convention):
    pressure, degrees, life = TABLE[convention]
    contact = pin_contact(convention)
    peak = contact.peak()
    assert float(peak.pressure) == pytest.approx(pressure, abs=6e-4)
    assert np.degrees(float(peak.theta)) == pytest.approx(degrees, abs=6e-4)
    found = roller_life(contact, ROLLER, ROLLER_RADIUS, SPEED)
    assert float(found.path) == pytest.approx(481.201, abs=6e-4)
    if life is not None:
        assert float(found.life_h) == pytest.approx(life, abs=0.06)


def test_trends_of_the_published_convention():
    radius = np.array([5.0, 13.0])
    small, large = roller_life(pin_contact("published", radius=radius), ROLLER, radius, SPEED).life_h
    assert large / small == pytest.approx(15.12, abs=0.006)
    speed = SPEED * np.array([1.0, 1300.0 / 600.0])
    contact = pin_contact("published", load=pin_load(speed).sampled())
    slow, fast = roller_life(contact, ROLLER, ROLLER_RADIUS, speed).life_h
    assert fast / slow == pytest.approx(0.004484, abs=1e-6)
    contact = pin_contact("published", length=np.array([5.0, 15.0]))
    short, long = roller_life(contact, ROLLER, ROLLER_RADIUS, SPEED).life_h
    assert long / short == pytest.approx(27.0, rel=1e-9)


def test_minus_sign_gives_another_trend_than_printed():
    radius = np.array([5.0, 13.0])
    small, large = roller_life(pin_contact("developed", radius=radius), ROLLER, radius, SPEED).life_h
    assert large / small == pytest.approx(27.5, abs=0.06)


# --- an independent count -------------------------------------------------------------------------------------------


class Plain:
    """The same contact by quadrature and root search at every single contact, nothing tabled."""

    def __init__(self, motion: Cycloids, force, pitch: float, radius: float, length: float) -> None:
        self.motion, self.force, self.pitch, self.radius, self.length = motion, force, pitch, radius, length
        self.pair = pair_compliance(ROLLER, CAM)
        self.edges = np.unique(np.concatenate([np.linspace(a, b, 9) for a, b in pairwise(motion.knots)]))
        steps = [integrate.quad(self.rate, a, b, epsabs=1e-13, epsrel=1e-13)[0] for a, b in pairwise(self.edges)]
        self.sums = np.concatenate([[0.0], np.cumsum(steps)])

    def rate(self, phi: float) -> float:
        return float(np.hypot(self.pitch, self.motion.jet(np.array([phi]), 1)[1, 0]))

    def angle(self, path: float) -> float:
        k = min(int(np.searchsorted(self.sums, path, side="right")) - 1, len(self.edges) - 2)
        low, high = self.edges[k], self.edges[k + 1]

        def speed(t):
            return np.hypot(self.pitch, self.motion.jet(np.clip(t, low, high - 1e-12), 1)[1])

        def short(phi):
            return self.sums[k] + integrate.fixed_quad(speed, low, phi, n=20)[0] - path

        return low if short(low) >= 0 else high if short(high) <= 0 else optimize.brentq(short, low, high, xtol=1e-14)

    def stress(self, phi: float, wall: int) -> float:
        phi = min(phi, TURN - 1e-12)
        one, two = self.motion.jet(np.array([phi]), 2)[1:, 0]
        force = self.force(phi, one, two)
        if force * wall <= 0.0:
            return 0.0
        steep = np.hypot(self.pitch, one)
        kappa = wall * self.pitch * two / steep**3
        twist2 = (self.radius * one / steep**2) ** 2
        curve = (1.0 + twist2) / (self.radius * (1.0 + self.radius * kappa - twist2))
        return float(np.sqrt(abs(force) * steep / self.pitch / self.length * curve / (np.pi * self.pair)))

    def damage(self, theta: float, first: int = 1) -> float:
        total, j = 0.0, first
        while (path := theta * self.radius + (j - 1) * np.pi * self.radius) <= self.sums[-1]:
            if path >= 0.0:
                total += (self.stress(self.angle(path), 1 if j % 2 else -1) / 2450.0) ** 6 / 1e7
            j += 1
        return total


def pin_force(phi, one, two):
    insert = 0.0
    if 4.456 <= phi <= 14 * np.pi / 9:
        insert = 79.55 * ((56 * np.pi - 36 * phi) / (13 * np.pi) + np.sin((72 * phi - 86 * np.pi) / 13) / (2 * np.pi))
    return 8.3 * np.sign(one) + insert + 2.25e-3 * SPEED**2 * two


def test_damage_at_any_point_is_the_plain_count():
    plain = Plain(PIN_MOTION, pin_force, PITCH_RADIUS, ROLLER_RADIUS, LENGTH)
    contact = pin_contact()
    spot = float(roller_life(contact, ROLLER, ROLLER_RADIUS, SPEED).hot_spot)
    theta = np.concatenate([np.linspace(0.01, TURN - 0.01, 6), [spot]])
    found = damage_profile(contact, ROLLER, ROLLER_RADIUS, theta)
    expected = [plain.damage(float(t)) for t in theta]
    np.testing.assert_allclose(found, expected, rtol=1e-7, atol=1e-9 * max(expected))


def test_hot_spot_is_the_largest_of_fine_stepping():
    """Small steps of the cam, each counted for the point of the roller that is in contact: 0.0018 deg apart."""
    phi = (np.arange(200_000) + 0.5) * TURN / 200_000
    _, one, two = PIN_MOTION.jet(phi, 2)
    inside = (phi >= 4.456) & (phi <= 14 * np.pi / 9)
    insert = 79.55 * ((56 * np.pi - 36 * phi) / (13 * np.pi) + np.sin((72 * phi - 86 * np.pi) / 13) / (2 * np.pi))
    force = 8.3 * np.sign(np.round(one, 12)) + np.where(inside, insert, 0.0) + 2.25e-3 * SPEED**2 * two
    steep = np.hypot(PITCH_RADIUS, one)
    path = np.cumsum(steep) * TURN / 200_000
    kappa, twist2 = np.sign(force) * PITCH_RADIUS * two / steep**3, (ROLLER_RADIUS * one / steep**2) ** 2
    curve = (1 + twist2) / (ROLLER_RADIUS * (1 + ROLLER_RADIUS * kappa - twist2))
    line = np.abs(force) * steep / PITCH_RADIUS / LENGTH
    each = (line * curve / (np.pi * pair_compliance(ROLLER, CAM))) ** 3 / 2450.0**6 / 1e7
    theta = np.arange(20_000) * TURN / 20_000
    total = np.zeros(theta.size)
    for j in range(16):
        at = theta * ROLLER_RADIUS + j * np.pi * ROLLER_RADIUS
        here = np.clip(np.searchsorted(path, at), 0, phi.size - 1)
        total += np.where((at <= path[-1]) & (np.sign(force[here]) == (-1) ** j), each[here], 0.0)
    found = roller_life(pin_contact(), ROLLER, ROLLER_RADIUS, SPEED)
    assert total.max() == pytest.approx(float(found.damage), rel=1e-4)
    assert theta[total.argmax()] == pytest.approx(float(found.hot_spot), abs=2e-3)


FAST = Cycloids(((0, 12, 0, 3), (12, 40, 3, 40), (40, 200, 40, 10), (200, 215, 10, 10), (215, 360, 10, 0)))


@pytest.mark.parametrize(
    ("radius", "exponent"), [(0.5, 6.0), (3.0, 9.0), (7.0, 1.0), (25.0, 6.0), (300.0, 3.0), (1e4, 40.0)]
)
def test_hot_spot_on_other_motions_sizes_and_exponents(radius, exponent):
    """The refined maximum against the profile on a fine grid, for rollers from many turns to a fraction of one."""
    load = Load(FAST, 50.0, 1.0, 20.0, preload=5.0).sampled()
    material = Material(exponent=exponent)
    contact = groove_contact(load, 400.0, radius, 10.0, material, CAM, "flat")
    found = roller_life(contact, material, radius, 50.0)
    steps = int(np.clip(1.5e5 * radius / float(found.path), 120, 10_000))
    theta = (np.arange(steps) + 0.5) * TURN / steps
    profile = damage_profile(contact, material, radius, theta)
    assert profile.max() <= float(found.damage) * (1.0 + 1e-10)
    assert float(found.damage) <= profile.max() * 1.02
    at = damage_profile(contact, material, radius, float(found.hot_spot) + np.array([-1e-9, 0.0, 1e-9]))
    assert at.max() == pytest.approx(float(found.damage), rel=1e-5)
    whole = damage_profile(contact, material, radius, theta, "both")
    assert float(found.mean_damage) == pytest.approx(whole.mean(), rel=2e-3)


def test_counting_both_adds_the_contacts_before_the_first():
    """A load that pulls back from the start: points past half a turn meet the wall ahead before the wall behind."""
    pull = Load(Cycloids(((0, 180, 10, 0), (180, 360, 0, 10))), 40.0, 1.0, 5.0)

    def force(phi, one, two):
        return 5.0 * np.sign(one) + 1e-3 * 1600.0 * two

    plain = Plain(pull.motion, force, 50.0, 9.0, LENGTH)
    contact = groove_contact(pull.sampled(), 50.0, 9.0, LENGTH, ROLLER, CAM)
    theta = np.array([0.3, 3.5, 4.0, 5.0, 6.0])
    for count, first in (("from-behind", 1), ("both", 0)):
        found = damage_profile(contact, ROLLER, 9.0, theta, count)
        np.testing.assert_allclose(found, [plain.damage(float(t), first) for t in theta], rtol=1e-7)
    less, more = (roller_life(contact, ROLLER, 9.0, 40.0, count) for count in ("from-behind", "both"))
    assert float(more.mean_damage) == float(less.mean_damage)
    assert float(more.damage) >= float(less.damage)


def test_variants_are_the_single_cases():
    radius, pitch, length = np.array([4.0, 11.0, 15.0]), np.array([40.0, 67.0, 90.0]), np.array([6.0, 12.0, 20.0])
    speed = np.array([20.0, 62.0, 130.0])
    load = pin_load(speed).sampled(LOAD.panels)
    contact = pin_contact("flat", pitch, radius, length, load)
    together = roller_life(contact, ROLLER, radius, speed)
    for k in range(3):
        one = pin_contact("flat", pitch[k], radius[k], length[k], pin_load(speed[k]).sampled(LOAD.panels))
        alone = roller_life(one, ROLLER, radius[k], speed[k])
        for name in ("life_h", "damage", "mean_damage", "spread_life_h", "path"):
            assert getattr(together, name)[k] == pytest.approx(float(getattr(alone, name)), rel=1e-10), name
        assert float(contact.peak().pressure[k]) == pytest.approx(float(one.peak().pressure), rel=1e-12)
    grid = roller_life(pin_contact("flat", PITCH_RADIUS, radius[:, None], length), ROLLER, radius[:, None], SPEED)
    assert grid.life_h.shape == (3, 3)


def test_peak_pressure_against_scipy():
    plain = Plain(PIN_MOTION, pin_force, PITCH_RADIUS, ROLLER_RADIUS, LENGTH)
    found = optimize.minimize_scalar(
        lambda phi: -plain.stress(phi, -1), bounds=(5.3, 5.6), method="bounded", options={"xatol": 1e-10}
    )
    peak = pin_contact().peak()
    assert float(peak.pressure) == pytest.approx(-found.fun, rel=1e-10)
    assert float(peak.theta) == pytest.approx(found.x, abs=1e-6)


def test_cam_life_is_that_of_its_worst_point():
    contact = pin_contact()
    found = cam_life(contact, CAM, SPEED)
    pressure = float(contact.peak().pressure)
    assert float(found.life_h) == pytest.approx((2450.0 / pressure) ** 6 * 1e7 / 36000.0, rel=1e-9)
    # The return begins with a pull back: the wall ahead carries it.
    assert int(found.wall) == -1
    assert float(cam_life(contact, CAM, SPEED, passes=3.0).life_h) == pytest.approx(float(found.life_h) / 3.0)


# --- curvature ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wall", ["behind", "ahead"])
def test_exact_curvature_is_that_of_the_surface_by_differences(wall):
    """Distance of the flank from the roller's cylinder a step square to the line of contact, to second order."""
    radius, pitch, phi = 9.0, 50.0, 0.4
    lift = np.polynomial.Polynomial([3.0, 20.0, 15.0, -8.0])
    one, two = lift.deriv(1)(phi), lift.deriv(2)(phi)
    sign = 1.0 if wall == "behind" else -1.0

    def flank(angle, delta):
        u = np.array([np.cos(angle), -np.sin(angle), 0.0])
        v = lift.deriv(1)(angle) * np.array([0.0, 0.0, 1.0]) + delta * np.array([-np.sin(angle), -np.cos(angle), 0.0])
        n = np.cross(u, v)
        return delta * u + [0.0, 0.0, lift(angle)] + sign * radius * n / np.linalg.norm(n), n / np.linalg.norm(n)

    contact, normal = flank(phi, pitch)
    axis = np.array([np.cos(phi), -np.sin(phi), 0.0])
    # Twist turns the line of contact away from the roller's axis.
    line = flank(phi, pitch + 1e-4)[0] - flank(phi, pitch - 1e-4)[0]
    line /= np.linalg.norm(line)
    across = np.cross(normal, line)
    centre = contact - sign * radius * normal

    def gap(step):
        """Distance from the roller's surface of the flank at a step square to the line of contact."""

        def miss(place):
            return flank(*place)[0] @ np.array([across, line]).T - [contact @ across + step, contact @ line]

        place = optimize.fsolve(miss, [phi, pitch], xtol=1e-14)
        point = flank(*place)[0] - centre
        return np.linalg.norm(point - (point @ axis) * axis) - radius

    h = 0.02
    found = (gap(h) + gap(-h)) / h**2
    expected = float(groove.relative_curvature("exact", wall, radius, pitch, one, two))
    assert found == pytest.approx(expected, rel=1e-4)


def test_conventions_agree_where_they_must():
    s1, s2 = np.array([0.0, 30.0]), np.array([40.0, 40.0])
    rho = (67.0**2 + s1**2) ** 1.5 / (67.0 * s2)
    for wall, true in (("behind", rho + 11.0), ("ahead", rho - 11.0)):
        sign = -1.0 if wall == "behind" else 1.0
        found = groove.relative_curvature("developed-wall", wall, 11.0, 67.0, s1, s2)
        np.testing.assert_allclose(found, 1 / 11.0 + sign / true, rtol=1e-13)
        # Without twist (s' = 0) the surface is the developed plane.
        exact = groove.relative_curvature("exact", wall, 11.0, 67.0, s1, s2)
        assert exact[0] == pytest.approx(found[0], rel=1e-13)
        for name, printed in (("developed", 1 / 11 - 1 / rho), ("published", 1 / 11 + 1 / rho), ("flat", [1 / 11] * 2)):
            found = groove.relative_curvature(name, wall, 11.0, 67.0, s1, s2)
            np.testing.assert_allclose(found, printed, rtol=1e-13)
    with pytest.raises(ValueError, match="developed-wall"):
        groove.relative_curvature("plane", "behind", 11.0, 67.0, s1, s2)  # type: ignore[arg-type]


def test_undercut_has_two_sides():
    def margin(radius):
        return min(
            float(groove.undercut_margin(wall, radius, PITCH_RADIUS, LOAD.ds, LOAD.dds).min())
            for wall in ("behind", "ahead")
        )

    edge = optimize.brentq(margin, 11.0, 40.0)
    radius = edge * np.array([0.998, 1.003])
    contact = pin_contact(radius=radius)
    assert contact.sound.tolist() == [True, False]
    life = roller_life(contact, ROLLER, radius, SPEED)
    assert life.life_h[0] > 0.0
    assert life.life_h[1] == 0.0
    assert contact.peak().pressure[1] == np.inf


# --- limits ---------------------------------------------------------------------------------------------------------


def test_extreme_stress_and_size():
    with np.errstate(all="raise"):
        for length in (1e-9, 1.0, 1e9):
            for pitch, radius in ((1e9, 1e9), (1e9, 1e7), (PITCH_RADIUS, 1e9)):
                contact = pin_contact("flat", pitch, radius, length)
                found = roller_life(contact, ROLLER, radius, SPEED)
                assert float(found.life_h) > 0.0
                assert 0.0 <= float(found.hot_spot) <= TURN
    with pytest.raises(NotConverged, match="larger roller"):
        roller_life(pin_contact("flat", 1e9, 1e-3), ROLLER, 1e-3, SPEED)


def test_absurd_pressure_is_refused_by_name():
    steep = Material(exponent=40.0)
    for speed, fits in ((1e3, True), (1e9, False)):
        contact = pin_contact("flat", load=pin_load(speed, mass=1e3).sampled(LOAD.panels))
        if fits:
            assert float(roller_life(contact, steep, ROLLER_RADIUS, speed).life_h) < 1e-9
            continue
        with pytest.raises(DesignError, match="times the contact limit"):
            roller_life(contact, steep, ROLLER_RADIUS, speed)
        with pytest.raises(DesignError, match="times the contact limit"):
            cam_life(contact, steep, speed)


def test_no_load_lasts_for_ever():
    load = Load(PIN_MOTION, SPEED).sampled()
    contact = groove_contact(load, PITCH_RADIUS, ROLLER_RADIUS, LENGTH, STEEL, STEEL)
    found = roller_life(contact, STEEL, ROLLER_RADIUS, SPEED)
    assert float(found.life_h) == np.inf == float(cam_life(contact, STEEL, SPEED).life_h)
    assert float(found.damage) == 0.0


def test_slices_along_the_roller_are_a_leading_axis():
    radii = PITCH_RADIUS - LENGTH * (np.arange(4) + 0.5) / 4
    rates = groove.path_rate(radii[:, None, None], LOAD.ds)
    cosine = groove.cos_pressure_angle(radii[:, None, None], LOAD.ds)
    wide = LENGTH / 4
    line = LOAD.force / cosine.sum(axis=0) / wide
    walls = [
        groove.relative_curvature("exact", wall, ROLLER_RADIUS, radii[:, None, None], LOAD.ds, LOAD.dds)
        for wall in ("behind", "ahead")
    ]
    pair = pair_compliance(ROLLER, CAM)
    contact = line_contacts(LOAD.panels, line * wide, walls[0], walls[1], rates, wide, pair)
    assert isinstance(contact, Contact)
    found = roller_life(contact, ROLLER, ROLLER_RADIUS, SPEED)
    assert found.life_h.shape == (4,)
    # Nearer the axis the groove is steeper and more curved: concave there, it fits the roller better.
    assert np.isfinite(found.life_h).all()
    assert (np.diff(found.path) < 0).all()
