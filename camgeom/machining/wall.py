"""The wall that a tool has to leave beside a roller: its ends, its depth, how narrow it gets and how it leans (mm)."""

from __future__ import annotations

import numpy as np

from camgeom.track import TURN, Arc, Slide, Straight, Track

SAME = 1e-9
"""mm; sizes that differ by less are equal"""


def up_of(track: Track) -> float:
    """+1 where the spindle stands at larger delta."""
    return -track.tip_sign


def wall_ends(track: Track) -> tuple[float, float]:
    """Meridian parameters of the cut wall: at its foot (a ball's contact: its lower end) and at the top."""
    top = track.contact[0] if track.tip_sign > 0.0 else track.contact[1]
    foot = track.foot
    t = track.meridian.parameter(foot)
    if abs(abs(t) - 0.25 * TURN) < 1e-9:
        foot = track.contact[1] if track.tip_sign > 0.0 else track.contact[0]
        t = track.meridian.parameter(foot)
    return t, track.meridian.parameter(top)


def depth_of(track: Track) -> float:
    """Depth of the cut along the roller, from the tool's end to the top of the contact, mm."""
    top = track.contact[0] if track.tip_sign > 0.0 else track.contact[1]
    return abs(top - track.tip)


def roller_at(track: Track, t: float) -> tuple[float, float]:
    """Height along the roller and its radius there, mm, at a meridian parameter."""
    delta, _, _, radius, _, _ = track.meridian.jet(np.array([t]))
    return float(delta[0]), float(radius[0])


def cosine_of(track: Track) -> float:
    """Cosine of a cone's half angle; 1 of other rollers."""
    meridian = track.meridian
    return 1.0 / float(np.hypot(1.0, meridian.slope)) if isinstance(meridian, Straight) else 1.0


def slope_to_tip(track: Track) -> float:
    """By how much a roller gets narrower per mm towards its free end; 0 but for a cone."""
    return -track.tip_sign * track.meridian.slope if isinstance(track.meridian, Straight) else 0.0


def leans(track: Track) -> bool:
    """True for the flank of a disc that a conical roller runs on."""
    return track.upright and slope_to_tip(track) != 0.0


def narrowest(track: Track) -> float:
    """Smallest radius of a roller over its contact, mm; of a ball its own."""
    low, high = (track.meridian.parameter(d) for d in track.contact)
    radii = track.meridian.jet(np.linspace(low, high, 33))[3]
    return float(radii.max() if is_ball(track) else radii.min())


def is_ball(track: Track) -> bool:
    """True for a spherical roller."""
    meridian = track.meridian
    return isinstance(meridian, Arc) and abs(meridian.arc - meridian.radius) <= SAME * meridian.radius


def is_radial(track: Track) -> bool:
    """True where the roller's axis always meets the cam's at a right angle (a drum with a sliding follower)."""
    along = isinstance(track.joint, Slide) and track.joint.direction == (0.0, 0.0, 1.0)
    return along and track.axis == (1.0, 0.0, 0.0) and track.anchor[1] == 0.0


