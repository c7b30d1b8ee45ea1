"""The errors of assembly and manufacture, and how far each brings every contact nearer: approach per unit, mm.

A rigid displacement of the cam moves its wall at x by delta + omega x (x - pivot), one of the follower or of a roller
moves that; with the unit normal n from roller into cam, lever L = n . velocity and approach g at the nominal place,

    approach = g + L psi,     g = n . (dx_roller - dx_cam) + growth of roller and flank          (first order)

and the follower stands where psi lets the walls that bear just touch, or press as hard as its load asks (`seat`).

Frame: the machine's. `e_c` is the unit vector from the cam's axis to the follower's (along X of a slide: the side it
stands on), `e_s` = Z x e_c stands across both. A plate that slides is a disc whose axis lies infinitely far below its
edge: `e_c` = Y, across its travel, `e_s` = -X, the way it goes out, and its axis is the normal of its plane, Z.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import Literal, final

import numpy as np

from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.surface import cross, dot
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.tolerance.contacts import Contacts, M, moment
from camgeom.track import Arc, Slide, Swing

ARCMIN = pi / 10800.0
ARCSEC = pi / 648000.0
Holder = Literal["machine", "cam", "turret", "roller", "wall"]
"""what an error stays with: the machine's frame, the turning cam, the turning follower, one roller, one wall"""
COMMON = frozenset({"axial_shift", "squareness_arcmin", "phase_arcmin"})
"""errors in the machine's frame that the body has beside all of its followers; the others there are of each one's place
"""
Sharing = Literal["body", "track", ""]


@final
@immutable(eq=True)
class Pivots:
    """About what tilts turn, mm, machine frame.

    axes    a point, of a plate the one that is there while it is not yet out; wobble: its z on the cam's axis; turret:
            along the follower's axis from the line of centres
    roller  along the roller from the middle of its contact, towards its free end
    waves   of the flank's form in one turn of the cam
    """

    axes: tuple[float, float, float]
    wobble: float
    turret: float = 0.0
    roller: float = 0.0
    waves: int = 3


@final
@immutable(eq=True)
class Cause:
    """One kind of error: its key in [tolerance], its unit with that in mm or rad, who has it, what it is.

    parts  1, or 2 for an error that has a direction: across the cam's axis, the turret's axis, the roller's, or a phase
    """

    key: str
    unit: Literal["mm", "arcmin", "arcsec"]
    holder: Holder
    parts: int
    what: str

    @property
    def scale(self) -> float:
        """mm or rad in one unit."""
        return {"mm": 1.0, "arcmin": ARCMIN, "arcsec": ARCSEC}[self.unit]

    @property
    def shared(self) -> Sharing:
        """Who of one machine's followers have it alike: all on the body, those on one track, or nobody."""
        if self.holder == "cam" or self.key in COMMON:
            return "body"
        return "track" if self.holder == "wall" else ""


CAUSES = {
    cause.key: cause
    for cause in (
        Cause("center_distance", "mm", "machine", 1, "follower further from the cam along the line of centres; a slide "
              "along X, the side on which it stands; a plate's follower across the travel"),
        Cause("side_shift", "mm", "machine", 1, "follower shifted across the cam's axis and the line of centres; a "
              "plate's along the travel"),
        Cause("axial_shift", "mm", "machine", 1, "cam shifted along its axis, a plate square to its plane"),
        Cause("crossing_arcmin", "arcmin", "machine", 1, "cam's axis turned about the line of centres: the crossing "
              "angle of crossed axes, the twist of parallel ones; a plate tilted about the line across its travel"),
        Cause("skew_arcmin", "arcmin", "machine", 1, "cam's axis tilted in the plane of the line of centres; a plate "
              "about the line of its travel"),
        Cause("squareness_arcmin", "arcmin", "machine", 1, "plate and travel together turned in the plate's plane, out "
              "of square to the follower"),
        Cause("phase_arcmin", "arcmin", "machine", 1, "cam turned ahead on its shaft; a plate's drive turned ahead"),
        Cause("cam_yaw_arcmin", "arcmin", "cam", 1, "plate turned in its plane on its slide, goes along with it"),
        Cause("cam_eccentricity", "mm", "cam", 2, "cam's axis beside its shaft's, turns with the cam"),
        Cause("cam_wobble_arcmin", "arcmin", "cam", 2, "cam's axis askew on its shaft, turns with the cam"),
        Cause("turret_eccentricity", "mm", "turret", 2, "circle of the rollers beside the turret's axis"),
        Cause("turret_wobble_arcmin", "arcmin", "turret", 2, "plane of the rollers askew on the turret's axis"),
        Cause("roller_diameter", "mm", "roller", 1, "diameter of each roller"),
        Cause("pitch_angle_arcsec", "arcsec", "roller", 1, "angle of each roller about the follower's axis"),
        Cause("pitch_radius", "mm", "roller", 1, "distance of each roller from the follower's axis"),
        Cause("roller_place", "mm", "roller", 1, "place of each roller or face of a slide along its motion"),
        Cause("roller_axial", "mm", "roller", 1, "place of each roller along the follower's axis; on a slide along its "
              "own"),
        Cause("roller_tilt_arcmin", "arcmin", "roller", 2, "axis of each roller, or line of a face, askew"),
        Cause("face_squareness_arcmin", "arcmin", "roller", 1, "flat face askew in the plane of the disc"),
        Cause("flank_form", "mm", "wall", 2, "form of each wall of the cam, in waves round it"),
        Cause("flank_growth", "mm", "wall", 1, "size of each wall of the cam: stock left"),
        Cause("running_clearance", "mm", "machine", 1, "gap between a follower held on both sides and every wall, "
              "beyond the nominal one"),
    )
}  # fmt: skip
"""Every error by its key."""


NORMAL = frozenset({"roller_diameter", "flank_form", "flank_growth", "running_clearance"})
"""errors that bring a wall nearer along its normal, exactly"""


def line_of_centres(mechanism: Mechanism) -> Floats:
    """Unit vector e_c from the cam's axis towards the follower's, (3,)."""
    if mechanism.carriage is not None:
        return np.array([0.0, 1.0, 0.0])
    joint = joint_of(mechanism)
    if isinstance(joint, Slide):
        return np.array([1.0, 0.0, 0.0])
    away = np.array([joint.centre[0], joint.centre[1], 0.0])
    return np.asarray(away / np.linalg.norm(away))


def joint_of(mechanism: Mechanism) -> Slide | Swing:
    """What carries the follower."""
    return mechanism.tracks[0].joint if mechanism.tracks else mechanism.touches[0].joint


def default_pivots(mechanism: Mechanism) -> Pivots:
    """Where axes tilt unless told: where the line of centres meets the cam's axis, else in the middle of the cam; a
    plate where its roller stands at zero travel, in the middle of its contact."""
    if mechanism.carriage is not None:
        (track,) = mechanism.tracks
        x, y, _ = track.anchor
        height = 0.5 * sum(track.contact)
        return Pivots((x, y, height), height)
    joint = joint_of(mechanism)
    height = joint.centre[2] if isinstance(joint, Swing) and abs(joint.axis[2]) < 0.5 else 0.5 * mechanism.envelope[1]
    return Pivots((0.0, 0.0, height), height)


def applicable(mechanism: Mechanism) -> tuple[Cause, ...]:
    """The errors that a mechanism can have."""
    flat, knife = _faces(mechanism)
    turning, turret = isinstance(joint_of(mechanism), Swing), mechanism.turret is not None
    ball = _balls(mechanism)
    absent: set[str] = {"roller_place"} if turning else {"pitch_angle_arcsec", "pitch_radius"}
    absent |= {"squareness_arcmin", "cam_yaw_arcmin"} if mechanism.carriage is None else {
        "cam_eccentricity", "cam_wobble_arcmin"}  # fmt: skip
    if not turret:
        absent |= {"turret_eccentricity", "turret_wobble_arcmin"}
    if flat or knife:
        absent |= {"roller_diameter", "roller_axial", "pitch_radius", "pitch_angle_arcsec"}
    if not flat:
        absent.add("face_squareness_arcmin")
    if ball:
        absent.add("roller_tilt_arcmin")
    if mechanism.drive is Drive.ALONE:
        absent.add("running_clearance")
    return tuple(cause for key, cause in CAUSES.items() if key not in absent)


def _faces(mechanism: Mechanism) -> tuple[bool, bool]:
    """Whether flat faces touch the cam, or a knife edge."""
    kind = "" if mechanism.tracks else mechanism.touches[0].kind
    return kind == "flat", kind == "knife"


def _balls(mechanism: Mechanism) -> bool:
    return bool(mechanism.tracks) and isinstance(mechanism.tracks[0].meridian, Arc) and not mechanism.crown


@final
class Approaches:
    """Approach of every station, mm, (parts, n, l, m), per mm or rad of each error of the line's own roller and wall.

    An error of another roller or wall leaves a line alone.
    """

    def __init__(self, contacts: Contacts, pivots: Pivots) -> None:
        self.contacts, self.pivots = contacts, pivots
        self._e_c = line_of_centres(contacts.mechanism)
        self._e_s = np.array([-self._e_c[1], self._e_c[0], 0.0])
        self._about_axes = moment(contacts, np.array(pivots.axes))
        self.flat, _ = _faces(contacts.mechanism)
        self._kept: dict[str, Floats] = {}

    def of(self, cause: Cause) -> Floats:
        """Of one error."""
        if cause.key not in self._kept:
            made = _RULES[cause.key](self)
            made[:, ~self.contacts.on] = 0.0
            self._kept[cause.key] = made
        return self._kept[cause.key]

    def along(self, e: Floats) -> Floats:
        """n . e of a fixed direction (3,)."""
        return np.tensordot(e, self.contacts.normal, 1)[None]

    def about(self, e: Floats) -> Floats:
        """Moment of n about a fixed axis (3,) through the pivot of the axes."""
        return np.tensordot(e, self._about_axes, 1)[None]

    def field(self, e: Floats, vectors: Floats) -> Floats:
        """Products of vectors (3, n, l, m) with directions (3, n) or (3, n, l)."""
        return dot(e[:, :, None, None] if e.ndim == 2 else e[..., None], vectors)

    @property
    def turning(self) -> tuple[Floats, Floats]:
        """The cam's own X and Y in the machine frame, (3, n)."""
        angle = self.contacts.mechanism.sense * self.contacts.theta
        c, s, zero = np.cos(angle), np.sin(angle), np.zeros_like(angle)
        return np.stack([c, s, zero]), np.stack([-s, c, zero])

    @property
    def carried(self) -> tuple[Floats, Floats]:
        """The follower's own two directions across its axis, (3, n): the first on the line of centres at lift zero."""
        joint, angle = self.contacts.joint, self.contacts.turned
        if not isinstance(joint, Swing):
            raise DesignError("a follower that slides does not turn with its own directions")
        axis = np.array(joint.axis)
        first, second = -self._e_c, np.cross(axis, -self._e_c)
        c, s = np.cos(angle), np.sin(angle)
        return first[:, None] * c + second[:, None] * s, second[:, None] * c - first[:, None] * s

    def cam_eccentricity(self) -> Floats:
        """Cam moved along its own X and Y."""
        return np.stack([-self.field(e, self.contacts.normal) for e in self.turning])

    def cam_wobble(self) -> Floats:
        """Cam tilted about its own X and Y."""
        about = moment(self.contacts, np.array([0.0, 0.0, self.pivots.wobble]))
        return np.stack([-self.field(e, about) for e in self.turning])

    def turret_eccentricity(self) -> Floats:
        """Rollers moved along the turret's own directions."""
        return np.stack([self.field(e, self.contacts.normal) for e in self.carried])

    def turret_wobble(self) -> Floats:
        """Rollers tilted about the turret's own directions."""
        joint = self.contacts.joint
        assert isinstance(joint, Swing)
        about = moment(self.contacts, np.array(joint.centre) + self.pivots.turret * np.array(joint.axis))
        return np.stack([self.field(e, about) for e in self.carried])

    def pitch_radius(self) -> Floats:
        """Rollers moved away from the joint's axis."""
        joint = self.contacts.joint
        assert isinstance(joint, Swing)
        axis = np.array(joint.axis)
        away = self.contacts.centre - np.array(joint.centre)[:, None, None]
        away = away - np.tensordot(axis, away, 1) * axis[:, None, None]
        return self.field(_unit(away), self.contacts.normal)[None]

    def roller_axial(self) -> Floats:
        """Rollers moved along the joint's axis, on a slide along their own."""
        joint = self.contacts.joint
        if isinstance(joint, Swing):
            return self.along(np.array(joint.axis))
        return self.field(self.contacts.axis, self.contacts.normal)[None]

    def roller_tilt(self) -> Floats:
        """Rollers leaned in the direction of their motion, and across it."""
        at, joint = self.contacts, self.contacts.joint
        pivot = at.centre + self.pivots.roller * at.axis
        if self.flat:
            motion = at.normal[..., M // 2]
        elif isinstance(joint, Swing):
            away = at.centre - np.array(joint.centre)[:, None, None]
            motion = cross(np.broadcast_to(np.array(joint.axis)[:, None, None], away.shape), away)
        else:
            motion = np.broadcast_to(np.array(joint.direction)[:, None, None], at.centre.shape)
        lean = cross(at.axis, _unit(motion - dot(motion, at.axis) * at.axis))
        about = moment(at, pivot)
        return np.stack([self.field(lean, about), self.field(cross(lean, at.axis), about)])

    def face_squareness(self) -> Floats:
        """Flat faces turned about Z at their reference point."""
        return np.asarray(moment(self.contacts, self.contacts.centre)[2][None])

    def roller_diameter(self) -> Floats:
        """Half the diameter across the roller's axis, of a ball along the normal."""
        if _balls(self.contacts.mechanism):
            return self.constant(0.5)
        along = self.field(self.contacts.axis, self.contacts.normal)
        return np.asarray(0.5 * np.sqrt(np.maximum(1.0 - along * along, 0.0))[None])

    def phase(self) -> Floats:
        """Cam turned ahead about its own axis; a plate further along -X, by what its drive does to it."""
        if (carriage := self.contacts.mechanism.carriage) is not None:
            return np.asarray((carriage.rates(self.contacts.theta)[1][:, None, None] * self.contacts.normal[0])[None])
        about = moment(self.contacts, np.zeros(3))[2]
        return np.asarray(-self.contacts.mechanism.sense * about[None])

    def yaw(self) -> Floats:
        """Plate turned about Z at a point of its own."""
        carriage = self.contacts.mechanism.carriage
        assert carriage is not None
        about = np.zeros((3, *self.contacts.on.shape[:2])) + np.array(self.pivots.axes)[:, None, None]
        about[0] -= carriage.travel(self.contacts.theta)[:, None]
        return np.asarray(-moment(self.contacts, about)[2][None])

    def constant(self, value: float) -> Floats:
        """The same everywhere."""
        return np.full((1, *self.contacts.on.shape), value)

    def waves(self) -> Floats:
        """cos and sin of the waves of a flank's form."""
        angle = self.pivots.waves * (self.contacts.round[:, None] + self.contacts.lag)
        shape = self.contacts.on.shape
        return np.stack([np.broadcast_to(f(angle)[..., None], shape) for f in (np.cos, np.sin)])


def _unit(vectors: Floats) -> Floats:
    length = np.sqrt(dot(vectors, vectors))
    return np.asarray(vectors / np.where(length > 0.0, length, 1.0))


_Z = np.array([0.0, 0.0, 1.0])
_RULES: dict[str, Callable[[Approaches], Floats]] = {
    "center_distance": lambda a: a.along(a._e_c),
    "side_shift": lambda a: a.along(a._e_s),
    "axial_shift": lambda a: -a.along(_Z),
    "crossing_arcmin": lambda a: -a.about(a._e_c),
    "skew_arcmin": lambda a: -a.about(a._e_s),
    "squareness_arcmin": lambda a: -a.about(_Z),
    "phase_arcmin": Approaches.phase,
    "cam_yaw_arcmin": Approaches.yaw,
    "cam_eccentricity": Approaches.cam_eccentricity,
    "cam_wobble_arcmin": Approaches.cam_wobble,
    "turret_eccentricity": Approaches.turret_eccentricity,
    "turret_wobble_arcmin": Approaches.turret_wobble,
    "roller_diameter": Approaches.roller_diameter,
    "pitch_angle_arcsec": lambda a: a.contacts.lever[None].copy(),
    "pitch_radius": Approaches.pitch_radius,
    "roller_place": lambda a: a.contacts.lever[None].copy(),
    "roller_axial": Approaches.roller_axial,
    "roller_tilt_arcmin": Approaches.roller_tilt,
    "face_squareness_arcmin": Approaches.face_squareness,
    "flank_form": Approaches.waves,
    "flank_growth": lambda a: a.constant(1.0),
    "running_clearance": lambda a: a.constant(-1.0),
}
