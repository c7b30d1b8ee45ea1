"""Small machines that tests share: programs, cams and setups by hand, with no profile in between."""

from __future__ import annotations

from math import radians

from camgeom.cams.cylindrical import Cylindrical
from camgeom.motion import Program, Segment
from camgeom.track.follower import CylinderRoller, Setup, SwingingFollower, TranslatingFollower


def program(*steps, angular=False):
    """Program from (until deg, to or None, law) steps; lifts in mm, or degrees where angular."""
    unit = radians(1.0) if angular else 1.0
    return Program.from_segments(
        [Segment(radians(u), None if to is None else unit * to, law) for u, to, law in steps], angular=angular
    )


def pin_program():
    """The motion of the pin-insertion machine."""
    return program(
        (155, None, None),
        (215, 37.0, "cycloidal"),
        (280, 74.0, "cycloidal"),
        (290, None, None),
        (360, 0.0, "cycloidal"),
    )


def pin_setup(roller=None, motion=None):
    """Follower, roller and motion of the pin-insertion machine."""
    return Setup(
        TranslatingFollower(mass=2.25), roller or CylinderRoller(diameter=22.0, length=12.0), motion or pin_program()
    )


def pin_cam(**changes):
    """The cam of the pin-insertion machine."""
    keys = {
        "kind": "cylindrical",
        "diameter": 134.0,
        "length": 110.0,
        "start": 18.0,
        "groove_depth": 13.0,
        "pitch_radius": 67.0,
        "bore": 40.0,
    }
    return Cylindrical(**(keys | changes))


def gentle_program():
    """A gentle rise and return."""
    return program((90, 20.0, "modified-sine"), (150, None, None), (270, 0.0, "4-5-6-7"), (360, None, None))


def swinging_setup(roller=None):
    """A swinging follower on a drum: 24 degrees to and fro."""
    motion = program((120, 24.0, "cycloidal"), (180, None, None), (300, 0.0, "3-4-5"), (360, None, None), angular=True)
    follower = SwingingFollower(kind="swinging", arm=90.0, start_angle=-12.0)
    return Setup(follower, roller or CylinderRoller(diameter=20.0, length=10.0), motion)


def swinging_cam(**changes):
    """The drum for it."""
    keys = {
        "kind": "cylindrical",
        "diameter": 120.0,
        "length": 90.0,
        "start": 26.0,
        "groove_depth": 11.0,
        "bore": 30.0,
    }
    return Cylindrical(**(keys | changes))
