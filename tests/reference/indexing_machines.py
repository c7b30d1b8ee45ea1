"""Turret machines that tests share, and their roller poses written from the theory with no package code."""

from __future__ import annotations

from math import cos, pi, radians, sin

import numpy as np

from camgeom.cams.cylindrical_index import CylindricalIndex
from camgeom.cams.globoidal import Globoidal
from camgeom.motion import Program, Segment
from camgeom.track.follower import ConeRoller, CrownedRoller, CylinderRoller, Setup, SphereRoller, TurretFollower

SHAPES = ("cylinder", "cone", "crowned", "sphere")


def index_program(stops, law="modified-sine", motion=120.0, indexes=1):
    """Dwell, one index (or `indexes` of them), dwell."""
    cycle = 360.0 / indexes
    steps, turned = [], 0.0
    for k in range(indexes):
        middle = (k + 0.5) * cycle
        steps.append(Segment(radians(middle - 0.5 * motion)))
        turned += 2.0 * pi / stops
        steps.append(Segment(radians(middle + 0.5 * motion), turned, law))
    return Program.from_segments([*steps, Segment(2.0 * pi)], closed=False, angular=True)


def roller_of(shape, diameter, length):
    """A roller of each shape."""
    if shape == "cone":
        return ConeRoller(shape="cone", diameter=diameter, length=length, half_angle=8.0)
    if shape == "crowned":
        arc = {"crown_radius": 12.0 * diameter, "flank": "conforming"}
        return CrownedRoller(shape="crowned", diameter=diameter, length=length, **arc)
    if shape == "sphere":
        return SphereRoller(shape="sphere", diameter=diameter)
    return CylinderRoller(diameter=diameter, length=length)


# stops, starts -> centre distance, pitch radius, roller diameter, length, width, globoid radius
BARREL_SIZES = {8: (92.0, 34.0, 74.0), 12: (118.0, 26.0, 76.0), 16: (150.0, 28.0, 80.0), 24: (170.0, 20.0, 64.0)}
SIZES = {
    3: (180.0, 70.0, 50.0, 20.0, 96.0, 62.0),
    4: (180.0, 78.0, 42.0, 20.0, 90.0, 70.0),
    6: (180.0, 85.0, 34.0, 20.0, 88.0, 77.0),
    8: (180.0, 90.0, 30.0, 20.0, 84.0, 82.0),
    12: (180.0, 100.0, 24.0, 16.0, 74.0, 94.0),
    16: (200.0, 125.0, 22.0, 14.0, 76.0, 119.0),
    24: (200.0, 140.0, 16.0, 10.0, 60.0, 136.0),
}

# Two starts at many stops.
MANY = {32: (240.0, 180.0, 14.0, 10.0, 60.0, 176.0), 48: (300.0, 240.0, 12.0, 8.0, 60.0, 237.0)}


def indexer(stops=8, form="rib", hand="right", starts=1, shape="cylinder", motion=120.0, indexes=1, **changes):
    """A globoidal cam and its setup; changes go to the cam."""
    centre, pitch, diameter, length, width, globoid = (SIZES | MANY)[stops * starts]
    follower = TurretFollower(kind="turret", stops=stops, rollers=stops * starts, pitch_radius=pitch, inertia=0.3)
    if shape == "sphere":
        globoid, half = pitch + 1.0, pi / (stops * starts)
        width = max(width, 2.1 * (globoid * sin(half) - 0.5 * diameter * cos(half)))
    keys = {
        "kind": "globoidal",
        "form": form,
        "hand": hand,
        "center_distance": centre,
        "width": width,
        "globoid_radius": globoid,
        "tip_clearance": 0.5,
    }
    setup = Setup(follower, roller_of(shape, diameter, length), index_program(stops, motion=motion, indexes=indexes))
    return Globoidal(**(keys | changes)), setup


def turret_pose(setup, centre, shift, hand="right", sense=1.0):
    """Pose of one roller in the cam frame: a turret about Y at (centre, 0, 0), the cam turning by +phi about Z."""
    sign = 1.0 if hand == "right" else -1.0

    def pose(phi):
        tau = setup.program.jet(np.ravel(phi), 0)[0].reshape(np.shape(phi)) + shift
        ux, uz = -np.cos(tau), sign * np.sin(tau)
        c, s = np.cos(sense * phi), np.sin(sense * phi)
        a = np.stack([centre * c, -centre * s, np.zeros_like(c)], -1)
        u = np.stack([ux * c, -ux * s, uz], -1)
        return a, u

    return pose


def dwell_half_angle(setup, form):
    """Angle of the rollers from the line of centres in the dwell, rad."""
    return pi / setup.follower.count if form == "rib" else 0.0


def meridian_of(setup, shape):
    """The oracle's words for the roller's shape: (kind, slope or arc, centre)."""
    centre = setup.follower.pitch_radius
    if shape == "cone":
        return ("cone", -sin(radians(8.0)) / cos(radians(8.0)), centre)
    if shape == "crowned":
        return ("crowned", setup.roller.crown_radius, centre)
    if shape == "sphere":
        return ("sphere", None, centre)
    return None


def barrel(stops=12, form="rib", hand="right", starts=1, shape="cylinder", **changes):
    """A cylindrical indexing cam and its setup."""
    pitch, diameter, width = BARREL_SIZES[stops * starts]
    follower = TurretFollower(kind="turret", stops=stops, rollers=stops * starts, pitch_radius=pitch)
    setup = Setup(follower, roller_of(shape, diameter, 14.0), index_program(stops, motion=150.0))
    keys = {"kind": "cylindrical-index", "form": form, "hand": hand, "center_distance": pitch - 3.0, "diameter": 130.0,
            "width": width, "bore": 30.0}
    return CylindricalIndex(**(keys | changes)), setup
