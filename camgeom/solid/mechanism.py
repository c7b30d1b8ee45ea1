"""The one typed thing a cam type makes: a cam bound to its follower, its roller and its motion program.

Every question that the house asks of a cam has a typed answer here, empty where the cam has nothing to say, so that
nobody asks whether a cam *has* an answer. A cam type answers what is abstract, and of the rest what applies to it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from enum import Enum
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.motion.program import Program
from camgeom.track import Track
from camgeom.track.follower import AnyFollower, AnyRoller, CrownedRoller, TurretFollower

if TYPE_CHECKING:
    from camgeom.solid import Part
    from camgeom.solid.blank import Blank, Bore, Wall
    from camgeom.solid.frame import FramePlate
    from camgeom.solid.prism import FaceGroove
    from camgeom.solid.turret import StackedTurret, TurretBody
    from camgeom.track.beside import Neighbour
    from camgeom.track.carriage import Carriage
    from camgeom.track.column import Level
    from camgeom.track.outline import Outline
    from camgeom.track.runout import Within
    from camgeom.track.sliding import Slider
    from camgeom.track.touch import Touch
    from camgeom.track.turret import Beside


class Drive(Enum):
    """Who presses whom."""

    ALONE = "alone"
    """one contact pushes; a spring or weight holds the follower on it"""
    OPPOSED = "opposed"
    """the cam drives to and fro: the walls of a groove, both sides of a rib, two discs, two faces"""
    SHARED = "shared"
    """several rollers of a turret share the load"""


@immutable(eq=True)
class Drum:
    """The outside of a drum, a cylinder or a cone, or the inside of a ring, which can be rolled out (mm).

    low, high  heights z of its ends; depth: of the groove (rib: its height), square to the outside, where it is one
               number round the drum
    radius     of a cone: at z = 0; slope: by which it falls per mm of height
    hollow     True of the inside of a ring, whose material lies beyond its radius
    """

    radius: float
    low: float
    high: float
    depth: float | None = None
    slope: float = 0.0
    hollow: bool = False

    def at(self, z: float) -> float:
        """Radius at a height, mm."""
        return self.radius - self.slope * z

    @property
    def floor(self) -> float:
        """Where along the roller the groove's floor is, or the drum beside its rib, mm."""
        deep = self.depth or 0.0
        return self.radius + deep if self.hollow else self.radius - deep

    def under(self, x: Floats) -> Floats:
        """How deep points (3, ...) of the cam frame lie under the drum's outside, as far as it may reach, mm."""
        away = np.sqrt(x[0] * x[0] + x[1] * x[1])
        if self.hollow:
            return np.asarray(away + 1e-9 - self.radius)
        if self.slope:
            return np.asarray((self.radius - self.slope * x[2] - away) / sqrt(1.0 + self.slope**2) + 1e-9)
        return np.asarray(self.radius + 1e-9 - away)

    def within(self, x: Floats) -> Floats:
        """How deep points (3, ...) of the cam frame lie within the drum, mm; what it ends at is 1e-9 mm deep."""
        return np.asarray(np.minimum(self.under(x), np.minimum(x[2] - self.low, self.high - x[2]) + 1e-9))


@immutable(eq=True)
class Carrier:
    """A bar about a roller's axis, which carries it within a ring.

    room      least way from that axis down to the ring's web, mm
    diameter  of the bar, mm; None where the profile does not say
    """

    room: float
    diameter: float | None


@immutable(eq=True)
class Measure:
    """A dimension of the section through the axis, from (z, x) to (z, x), mm: a length along it, or a diameter."""

    start: tuple[float, float]
    stop: tuple[float, float]

    @property
    def is_diameter(self) -> bool:
        """True where it runs across the axis."""
        return self.start[0] == self.stop[0]

    @property
    def size(self) -> float:
        """Its length, mm."""
        return abs(self.stop[0] - self.start[0]) + abs(self.stop[1] - self.start[1])


@immutable
class Turret:
    """An indexing turret beside its cam.

    follower    its stops, its number of rollers, and the circle of their middles
    body        the turret with its rollers at cam angle zero
    gaps        free distances, mm: (name, distance, advice)
    bearing     the tracks whose walls rollers may bear on, where the mechanism's `within` says so
    room        radius about the turret's axis that its shaft may have, mm: of its own disc, or to the plates beside it
    take_turns  True where only the best placed roller of each direction is judged: others carry where one cannot
    rib_depths  where ribs are measured along the roller, mm: (name, delta); none for plates, which have no ribs
    preload     mm, by which rollers press into the ribs they ride in the dwell
    relief      mm, by which flanks stand back at the ends of every dwell
    dwell_ends  cam angles in [0, 2 pi) at which a dwell begins or ends, rad
    rollers     all rollers one by one, where they stand on several rings
    dials       discs between plates: (radius, low z, high z), mm
    """

    follower: TurretFollower
    body: TurretBody | StackedTurret
    gaps: tuple[tuple[str, float, str], ...]
    bearing: tuple[Track, ...]
    room: float
    take_turns: bool = False
    rib_depths: tuple[tuple[str, float], ...] = ()
    preload: float = 0.0
    relief: float = 0.0
    dwell_ends: tuple[float, ...] = ()
    rollers: tuple[Track, ...] = ()
    dials: tuple[tuple[float, float, float], ...] = ()


@immutable(kw_only=True)
class Mechanism(ABC):
    """A cam with what it drives. Facts are attributes, computed when asked, once; lengths in mm, cam frame.

    roller             None for flat and knife followers; program: the motion round the cam
    sense              +1 where the cam turns counter-clockwise seen from +Z, -1 clockwise
    drive              who presses whom
    width              length of the cam, or thickness of each of its discs, along its axis
    form               the profile's word for one of several forms of a kind; empty where there is one
    bore               the opening for the shaft
    base_radius        of a planar cam's profile at zero lift
    outside_diameter   nominal, of a body that has one
    running_clearance  normal gap between roller and each flank
    root_radius        of the root between flanks and floor; 0: sharp, or none
    carriage           of a cam that slides where others turn; its cam angle is that of its drive
    """

    follower: AnyFollower
    roller: AnyRoller | None
    program: Program
    sense: float
    drive: Drive
    width: float
    form: str = ""
    bore: Bore | None = None
    base_radius: float | None = None
    outside_diameter: float | None = None
    running_clearance: float = 0.0
    root_radius: float = 0.0
    carriage: Carriage | None = None

    @property
    @abstractmethod
    def parts(self) -> tuple[Part, ...]:
        """The recipes of its bodies."""

    @property
    @abstractmethod
    def envelope(self) -> tuple[float, float]:
        """Diameter and length, mm, of the cylinder about the axis that just holds the finished cam."""

    @property
    def box(self) -> tuple[float, float, float] | None:
        """Length, width and thickness, mm, of a plate that slides; None of a body about an axis."""
        return None

    @property
    def moving_mass(self) -> float | None:
        """Of what the drive of a cam that slides accelerates, kg; None where it is not known, or turns."""
        return None

    @property
    def passes(self) -> float:
        """How often a roller passes a place of its flank in one turn of the drive."""
        return 1.0

    @property
    def lags(self) -> tuple[float, ...]:
        """Of contacts on one and the same wall: the cam angle, rad, after which each meets what the first met."""
        return ()

    @property
    def named(self) -> dict[str, float]:
        """Measures that the standards of its kind have names for, mm."""
        return {}

    @property
    def measures(self) -> tuple[Measure, ...]:
        """Dimensions of its section beside length, outside and bore."""
        return ()

    @property
    def bored(self) -> tuple[float, float] | None:
        """Heights z between which the bore runs, mm; None: from end to end of every body."""
        return None

    @property
    def quoted_radius(self) -> float | None:
        """Where the classical figures are quoted, along the roller as its track counts; None: no figures are quoted."""
        return None

    @property
    def tracks(self) -> tuple[Track, ...]:
        """The rollers' tracks; none for flat and knife followers."""
        return ()

    @property
    def rollers(self) -> tuple[AnyRoller, ...]:
        """The roller of every track."""
        return () if self.roller is None else (self.roller,) * len(self.tracks)

    @property
    def cutters(self) -> tuple[Track, ...]:
        """The same tracks with the tool that cuts them: larger by a clearance, deeper at the tip."""
        return self.tracks

    @property
    def passages(self) -> tuple[Track, ...]:
        """Every roller as long as any part of it may be beside the cam, also where it touches nothing."""
        return self.tracks

    @property
    def sliders(self) -> tuple[Slider, ...]:
        """What touches the cam without a roller: flat faces and knife edges."""
        return ()

    @property
    def touches(self) -> tuple[Touch, ...]:
        """What touches a planar cam: one contact, or two that drive the follower both ways; none for other cams."""
        return ()

    @property
    def profiles(self) -> tuple[Touch, ...]:
        """Plane profiles of a disc, which may not cross themselves and sweep a circle: what touches them there."""
        return self.touches

    @property
    def outlines(self) -> Mapping[str, Outline]:
        """Closed plane curves of the bodies by name."""
        return {}

    @property
    def walls(self) -> tuple[Wall, ...]:
        """Thinnest places of the bodies."""
        return ()

    @property
    def face_groove(self) -> FaceGroove | None:
        """The groove in a face of a disc; None of other tracks."""
        return None

    @property
    def wall(self) -> tuple[float, float] | None:
        """Heights z, mm, between which the flanks of a disc that may have several tracks stand; None of other cams."""
        return None

    @property
    def blank(self) -> Blank | None:
        """The body of revolution that the flanks are cut into."""
        return None

    @property
    def drum(self) -> Drum | None:
        """The outside of a drum."""
        return None

    @property
    def inside(self) -> bool:
        """True where the follower works within the cam, whose walls are seen from there alone."""
        return self.drum is not None and self.drum.hollow

    @property
    def wall_foot(self) -> tuple[Level, float] | None:
        """Surface on which the walls end, and a delta near it; None where they end at the tool's tip."""
        return None

    @property
    def wall_mouth(self) -> tuple[Level, float] | None:
        """Surface at which the walls begin, and a delta near it; None where they begin at the end of the contact."""
        return None

    @property
    def wall_top(self) -> tuple[Level, float] | None:
        """Surface that a roller may leave sideways, so that no flank is beside it, and a delta near it."""
        return None

    @property
    def ribs(self) -> tuple[Extreme, ...]:
        """Least normal thickness of a rib between two rollers, mm, at each of the places (`where`) it is measured."""
        return ()

    @property
    def rib_asked(self) -> float | None:
        """Normal thickness that the profile gives such a rib, mm."""
        return None

    @property
    def neighbours(self) -> tuple[Neighbour, ...]:
        """Discs that a roller passes without touching, each with the whole roller."""
        return ()

    @property
    def floor_gap(self) -> float | None:
        """From the flat end of a roller to the floor of its groove (rib: the drum beside it), mm; None without one.

        A turret's stands among its gaps.
        """
        return None

    @property
    def pivot_gap(self) -> Extreme | None:
        """Least distance from the pivot of an arm to a plate that slides, mm, negative within it; None of others."""
        return None

    @property
    def carrier(self) -> Carrier | None:
        """What carries a roller that stands within its cam; None where nothing of the cam is about it."""
        return None

    @property
    def span_between(self) -> float | None:
        """Constant width of the cam between parallel faces."""
        return None

    @property
    def turret(self) -> Turret | None:
        """The indexing turret."""
        return None

    @cached_property
    def engagements(self) -> Beside | None:
        """The rollers of the turret beside the cam, whatever state it runs in; None without a turret."""
        from camgeom.track.turret import Beside

        turret, roller = self.turret, self.roller
        if turret is None or roller is None:
            return None
        return Beside(turret.bearing, self.within, roller.ends.stated or roller.arc is not None)

    @property
    def frame(self) -> FramePlate | None:
        """The frame about the cam as it stands at zero lift, where the profile makes it a part."""
        return None

    @property
    def allowed_interference(self) -> float:
        """By how much a roller may stand in the cam on purpose."""
        return 0.0

    @property
    def allowed_backlash(self) -> float:
        """By how much a flank may stand back from what passes it on purpose, mm."""
        return self.running_clearance + (self.turret.relief if self.turret is not None else 0.0)

    @property
    def free_play(self) -> float:
        """Play of a follower driven both ways, mm: its own, or from wall to wall, of a turret where it is largest."""
        if self.turret is not None:
            return 2.0 * max(0.0, self.allowed_backlash - self.turret.preload)
        return self.follower.clearance or 2.0 * self.running_clearance

    @property
    def fit_size(self) -> float:
        """Nominal size of the fit that has this play, mm: of the smallest roller, or of the cam between two faces."""
        return min((roller.diameter for roller in self.rollers), default=self.span_between or 0.0)

    @property
    def contact_length(self) -> float:
        """Length, mm, over which a roller or face touches, the least of several; 1 where none has one."""
        return min((touch.length for touch in self.touches), default=(self.roller and self.roller.length) or 1.0)

    @property
    def crown(self) -> str:
        """How the flank meets a crowned roller: `CrownedRoller.flank`; empty for other rollers."""
        return next((roller.flank for roller in self.rollers if isinstance(roller, CrownedRoller)), "")

    def cutting(self, track: Track) -> Track:
        """The track of a roller with the shape that cuts its flank: a cylinder where a crown runs on a straight one."""
        return track.straightened() if self.crown == "straight" else track

    @property
    def classical(self) -> bool:
        """True for the case of the literature: a cylindrical roller on a slide, in the groove of a drum."""
        return False

    @property
    def runs_out(self) -> bool:
        """True where a roller leaves the cam on purpose: its contacts count where they are `inside` alone."""
        return False

    @property
    def beside(self) -> Within | None:
        """How deep contact points (3, ...) of a roller lie beneath where its wall ends; None where all have one."""
        return None

    def within(self, x: Floats) -> Floats:
        """How deep contact points (3, ...) lie on the cam's own material, mm: tracks may run beyond it."""
        return np.full(x.shape[1:], np.inf)
