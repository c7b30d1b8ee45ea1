"""The envelope and its differential geometry, against formulas and differences that share no code with it."""

from __future__ import annotations

import numpy as np
import pytest

from camgeom.errors import DesignError
from camgeom.track.flank import flank
from camgeom.track.follower import ConeRoller, CrownedRoller, CylinderRoller, Setup, SphereRoller, TranslatingFollower
from camgeom.track.survey import Survey
from tests.reference.machines import gentle_program, pin_cam, pin_setup, program, swinging_cam, swinging_setup

ROLLERS = {
    "cylinder": CylinderRoller(diameter=20.0, length=10.0),
    "cone": ConeRoller(shape="cone", diameter=20.0, length=10.0, half_angle=9.0),
    "crowned": CrownedRoller(shape="crowned", diameter=20.0, length=10.0, crown_radius=150.0),
    "sphere": SphereRoller(shape="sphere", diameter=20.0),
}


def swinging_track(shape="cylinder"):
    setup = swinging_setup(ROLLERS[shape])
    return swinging_cam(groove_depth=10.0 if shape == "sphere" else 11.0).mechanism(setup).tracks[0]


def stations(track, count=5):
    low, high = (track.meridian.parameter(d) for d in track.contact)
    return np.linspace(low, high, count)


@pytest.mark.parametrize("shape", ROLLERS)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_contact_equation_and_normal(shape, side):
    """n is perpendicular to the relative velocity of the roller point, and to both tangents of the flank."""
    track = swinging_track(shape)
    phi = np.radians([20.0, 61.0, 110.0, 200.0, 260.0])
    f = flank(track, phi, stations(track), side)
    h = 1e-5
    tangent = (flank(track, phi + h, f.t, side).points - flank(track, phi - h, f.t, side).points) / (2 * h)
    across = (flank(track, phi, f.t + h, side).points - flank(track, phi, f.t - h, side).points) / (2 * h)
    n = f.normals
    assert np.allclose(np.einsum("nmi,nmi->nm", n, n), 1.0, atol=1e-14)
    for t in (tangent, across):
        size = np.linalg.norm(t, axis=-1)
        assert np.max(np.abs(np.einsum("nmi,nmi->nm", n, t)) / size) < 1e-8


@pytest.mark.parametrize("shape", ROLLERS)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_second_form_against_differences(shape, side):
    """L, M, N from the implicit derivatives equal -dn.dx by differences of the exact normal."""
    track = swinging_track(shape)
    phi = np.radians([20.0, 61.0, 110.0, 200.0, 260.0])
    t = stations(track)
    f = flank(track, phi, t, side)
    h = 1e-5

    def difference(what):
        def at(dphi, dt):
            return getattr(flank(track, phi + dphi, t + dt, side), what)

        return (at(h, 0.0) - at(-h, 0.0)) / (2 * h), (at(0.0, h) - at(0.0, -h)) / (2 * h)

    x_phi, x_t = difference("points")
    n_phi, n_t = difference("normals")
    pairs = {"L": (n_phi, x_phi), "M": (n_phi, x_t), "N": (n_t, x_t)}
    scale = np.abs(f.forms.L).max()
    for name, (dn, dx) in pairs.items():
        assert np.allclose(getattr(f.forms, name), -np.einsum("nmi,nmi->nm", dn, dx), atol=3e-7 * scale)


def test_relative_curvature_against_the_ruled_surface():
    """For a cylinder the general formula is the parallel surface of the pitch surface (closed form of the theory)."""
    track = pin_cam().mechanism(pin_setup()).tracks[0]
    phi, t, r = np.radians(np.linspace(156.0, 359.0, 40)), np.array([55.0, 61.0, 67.0]), 11.0
    pose = track.pose(phi, 2)
    u, up, upp = (np.moveaxis(pose.u[k], 0, -1)[:, None] for k in range(3))
    v = np.moveaxis(pose.a[1], 0, -1)[:, None] + t[None, :, None] * up
    pp = np.moveaxis(pose.a[2], 0, -1)[:, None] + t[None, :, None] * upp
    c = np.cross(u, v)
    d = (c * c).sum(-1)
    n = c / np.sqrt(d)[..., None]
    big_l, big_m, f = (n * pp).sum(-1), (n * up).sum(-1), (v * u).sum(-1)
    gauss, mean = -(big_m**2) / d, 0.5 * (big_l - 2 * f * big_m) / d
    k1, k2 = mean + np.sqrt(mean**2 - gauss), mean - np.sqrt(mean**2 - gauss)
    for s in (1.0, -1.0):
        found = flank(track, phi, t, s)
        expected = np.abs(k1 / (1 - s * r * k1) + k2 / (1 - s * r * k2) + s / r)
        assert np.allclose(found.k_rel, expected, rtol=1e-12)
        assert np.allclose(found.margin, 1 - r * np.maximum(s * k1, s * k2), atol=1e-12)


@pytest.mark.parametrize("shape", ROLLERS)
def test_relative_curvature_is_the_gap_to_the_roller(shape):
    """Across the contact line the flank leaves the roller as k_rel s² / 2."""
    from tests.oracle.envelope import roller_distance

    track = swinging_track(shape)
    phi, t = np.radians([61.0]), stations(track)[2:3]
    for side in (1.0, -1.0):
        f = flank(track, phi, t, side)
        pose = track.pose(phi, 0)
        a, u = pose.a[0][:, 0], pose.u[0][:, 0]
        m = track.meridian
        kind = {"crowned": "crowned", "sphere": "sphere"}.get(shape)
        args = (kind, m.arc, m.centre) if kind else ("straight", m.slope, m.centre)
        gaps = []
        for step in (1e-3, -1e-3):
            x = flank(track, phi + step, t, side).points[0, 0]
            gaps.append(roller_distance(x, a, u, m.radius, m.centre - 30.0, shape=args))
        # The chord across the contact line: the part of x_phi perpendicular to the contact line's direction x_t.
        x_phi = (flank(track, phi + 1e-5, t, side).points - flank(track, phi - 1e-5, t, side).points)[0, 0] / 2e-5
        x_t = (flank(track, phi, t + 1e-5, side).points - flank(track, phi, t - 1e-5, side).points)[0, 0] / 2e-5
        e = x_t / np.linalg.norm(x_t)
        width = np.linalg.norm(x_phi - (x_phi @ e) * e) * 1e-3
        assert np.mean(gaps) == pytest.approx(0.5 * f.k_rel[0, 0] * width**2, rel=2e-3)


@pytest.mark.parametrize(("product", "passes"), [(0.999, True), (1.002, False)])
def test_undercut_has_two_sides(product, passes):
    """r k = 0.999 passes, 1.002 fails: the roller is sized from the exact largest pitch curvature."""
    motion = program((90, 20.0, "cycloidal"), (180, 0.0, "cycloidal"), (360, None, None))
    cam = pin_cam(groove_depth=8.0, pitch_radius=60.0, length=150.0, start=60.0)

    def survey(diameter):
        setup = Setup(TranslatingFollower(), CylinderRoller(diameter=diameter, length=8.0), motion)
        return Survey(cam.mechanism(setup).tracks[0], cam.mechanism(setup).cutters[0])

    small = 1e-3
    curvature = (1.0 - survey(2 * small).margin.value) / small
    assert curvature > 0.0
    found = survey(2.0 * product / curvature).margin
    assert found.value == pytest.approx(1.0 - product, abs=1e-9)
    assert (found.value > 0.0) is passes


def test_pressure_angle_at_every_depth():
    """tan(alpha) = |s'| / delta for a translating roller at its axis; it is larger at smaller radius."""
    track = pin_cam().mechanism(pin_setup()).tracks[0]
    phi, t = np.radians([185.0, 240.0, 325.0]), np.array([55.0, 61.0, 67.0])
    found = flank(track, phi, t, 1.0).pressure_angle("axis")
    slope = np.abs(pin_setup().program.jet(phi, 1)[1])
    assert np.allclose(np.tan(found), slope[:, None] / t, rtol=1e-12)
    assert np.all(np.diff(found, axis=1) < 0.0)


def test_sliding_vanishes_at_the_rolling_station():
    track = swinging_track()
    f = flank(track, np.radians([30.0, 61.0]), stations(track), 1.0)
    round_it, along = f.sliding()
    assert np.allclose(round_it[:, 2], 0.0)
    assert np.abs(round_it[:, [0, -1]]).min() > 1e-3
    assert np.isfinite(along).all()


def test_roller_that_moves_along_itself_is_refused():
    """A ball cannot lose its flank; a cylinder whose axis lies along its velocity can, and says so."""
    from camgeom.track import Slide, Straight, Track

    track = Track(
        meridian=Straight(5.0, 0.0),
        joint=Slide((0.0, 0.0, 1.0)),
        anchor=(0.0, 0.0, 0.0),
        axis=(0.0, 0.0, 1.0),
        tip=0.0,
        contact=(0.0, 10.0),
        program=gentle_program(),
    )
    with pytest.raises(DesignError, match="along its own axis"):
        _ = flank(track, np.radians([45.0]), np.array([1.0, 2.0]), 1.0).x


@pytest.mark.parametrize("direction", ["ccw", "cw"])
def test_direction_mirrors_the_cam(direction):
    cam = pin_cam(direction=direction)
    x = flank(cam.mechanism(pin_setup()).tracks[0], np.radians([185.0]), np.array([61.0]), 1.0)
    pose = x.track.pose(x.phi, 0)
    azimuth = np.degrees(np.arctan2(pose.u[0][1], pose.u[0][0]))[0]
    assert azimuth % 360.0 == pytest.approx(-185.0 % 360.0 if direction == "ccw" else 185.0)
