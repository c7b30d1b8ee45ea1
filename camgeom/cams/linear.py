"""Linear (plate) cam: a groove in a plate, or its edge; a drive slides it to and fro, and it moves a roller across."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, hypot, radians, sin
from typing import Annotated, ClassVar, Literal, final

import numpy as np
from pydantic import Field

from camgeom.cams import NO_DRUM, NO_GAPS, NO_ROOT, PLANE_REST, REGULAR, Cam, idle, problem
from camgeom.cams._plate import disc_wall, least_distance, roller_track, straight_problems
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.keys import Clearance, Length
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.motion.catalogue import LAWS
from camgeom.motion.program import Program
from camgeom.motion.segment import Segment
from camgeom.solid import Part
from camgeom.solid.blank import Wall
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.solid.pocket import EdgePlate, PocketPlate
from camgeom.solid.prism import Loop
from camgeom.track import TURN, Joint, Slide, Swing, Track
from camgeom.track.beside import least_outside
from camgeom.track.carriage import Carriage
from camgeom.track.follower import Mass, Setup, SwingingFollower, TranslatingFollower
from camgeom.track.outline import Outline, PolygonOutline
from camgeom.track.plate import EdgeOutline, PocketOutline

NO_IMPACT = "impacts in the groove of a plate that turns round are not solved so far"
NO_SHAFT = "the drive of a linear cam moves its plate too, of which nothing is in it: vibration takes it as rigid"
ONE_WAY = "a plate runs out and back over one flank, and a corrected motion needs two"
REACH_SAMPLES, PIVOT_SAMPLES = 721, 360
NO_FILM = "where the plate turns round nothing draws oil in: a film is known of surfaces that go on alone"


@final
class Linear(Cam):
    """A plate 0 <= x <= length, 0 <= y <= width, 0 <= z <= thickness that slides along X; the follower moves across it.

    The motion stands over the plate's travel, mm; the cam angle is that of the plate's drive, a turn for out and back.
    A plate of form = "edge" ends where the roller runs on it: its width follows, and a spring or weight holds that.
    """

    FOLLOWERS: ClassVar[tuple[str, ...]] = ("translating", "swinging")
    SLIDES: ClassVar[bool] = True
    MOST_PIECES: ClassVar[int] = 6_500

    kind: Literal["linear"]
    stroke: Length = Field(
        description="mm, travel of the plate, out and back in a turn of its drive; the motion's last segment ends there"
    )
    form: Literal["groove", "edge"] = Field(
        "groove", description="groove: the roller runs in one and is driven both ways; edge: a spring or weight holds "
        "it on the plate's upper edge, its envelope, which goes on straight to the plate's ends"
    )
    length: Length = Field(description="mm, of the plate along its travel")
    width: Length | None = Field(None, description="mm, of the plate across it; groove")
    thickness: Length = Field(description="mm, of the plate")
    start: Length = Field(description="mm, from the plate's end x = 0 to the roller's axis, the plate not yet out")
    edge: Length = Field(description="mm, from the plate's edge y = 0 to the roller's axis there at zero lift")
    inclination: Annotated[float, Field(gt=-80.0, lt=80.0)] = Field(
        0.0, description="deg, of the follower's slide from square to the travel; positive leans the way the roller "
        "goes along the plate as that goes out"
    )
    groove_depth: Length | None = Field(None, description="mm, from the plate's upper face; groove")
    running_clearance: Clearance = Field(0.0, description="mm, normal gap between roller and each flank; groove")
    drive: Annotated[str, Field(max_length=60)] = Field(
        "simple-harmonic", description="motion law by which the plate goes out and comes back, see `camgeom laws`; it "
        "has to begin and end at rest: simple-harmonic is a crank with a long rod"
    )
    drive_out: Annotated[float, Field(ge=10.0, le=350.0)] = Field(
        180.0, description="deg, angle of the drive's turn in which the plate goes out; in the rest of it it comes back"
    )
    moving_mass: Mass | None = Field(
        None, description="kg, of plate and slide, which the drive accelerates; needed for limits.drive_force_n"
    )

    @property
    def travel(self) -> float:
        """The stroke."""
        return self.stroke

    def carriage(self, path: Program) -> Carriage:
        """The plate on its slide. Raises ProfileError where no such law drives it."""
        if self.drive not in LAWS or LAWS[self.drive].joins or LAWS[self.drive].data:
            names = ", ".join(sorted(name for name, law in LAWS.items() if not law.joins and not law.data))
            raise ProfileError([Problem("cam.drive", "no law with a shape of its own", self.drive, names)])
        out = radians(self.drive_out)
        segments = [Segment(out, TURN, self.drive), Segment(TURN, 0.0, self.drive)]
        drive = Program.from_segments(segments, key="cam.drive")
        if drive.continuity.order < 1:
            limit = "a law that begins and ends at rest: nothing turns a plate round at full speed"
            raise ProfileError([problem("cam.drive", self.drive, limit)])
        rates = drive.jet(np.linspace(0.0, TURN, 1441), 1)[1]
        if np.any(rates[:721][np.linspace(0.0, TURN, 1441)[:721] < out] < -1e-9):
            raise ProfileError([problem("cam.drive", self.drive, "a law that does not go back on its way out")])
        return Carriage(path, drive, self.stroke)

    def mechanism(self, setup: Setup) -> LinearMechanism:
        """The plate with its follower."""
        assert isinstance(setup.follower, TranslatingFollower | SwingingFollower)
        assert setup.carriage is not None
        return LinearMechanism(
            follower=setup.follower,
            roller=setup.roller,
            program=setup.program,
            sense=1.0,
            drive=Drive.OPPOSED if self.form == "groove" else Drive.ALONE,
            width=self.thickness,
            form=self.form,
            running_clearance=self.running_clearance,
            cam=self,
            carriage=setup.carriage,
        )

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of cams that turn, and what is not solved of one that slides."""
        found = NO_DRUM | REGULAR | NO_ROOT | PLANE_REST
        found |= idle("belongs to a drum's follower", "follower.pivot_distance")
        leans = "an arm has no slide; follower.start_angle says how it stands"
        found |= idle(leans, "cam.inclination") if setup.follower.rotating else {}
        faces = ("face", "face_radius", "face_width", "face_offset")
        found |= idle("a linear cam's follower carries a roller", *(f"follower.{key}" for key in faces))
        found |= idle("a linear cam's slide has none; cam.edge says where the roller stands", "follower.offset")
        if self.form == "groove":
            found |= idle("a linear cam's follower has none; give cam.running_clearance", "follower.clearance")
        else:
            keys = ("cam.width", "cam.groove_depth", "cam.running_clearance")
            found |= idle("only form = 'groove' has one; form = 'edge' ends at the edge it has", *keys)
            held = "what a spring or weight holds on its cam has no play"
            found |= {} if setup.follower.rotating else NO_GAPS
            found |= idle(held, "follower.clearance", "limits.play_mm")
        found |= idle(NO_IMPACT, "impact") | idle(ONE_WAY, "dynamics.polydyne")
        found |= idle(NO_SHAFT, *(f"dynamics.shaft_{key}" for key in ("inertia", "stiffness", "damping")))
        found |= idle(NO_FILM, "lubricant.pressure_viscosity", "limits.film_ratio", "limits.warn_film_ratio")
        found |= idle(NO_FILM, "material.cam.roughness_um", "material.roller.roughness_um")
        unmeshed = "a linear cam's body is not meshed for a load"
        found |= idle(unmeshed, "output.load_angle_deg", "dynamics.body_compliance")
        reason = "the shaft of a linear cam's drive moves the plate too, of which nothing is in it: give limits."
        return found | idle(f"{reason}drive_force_n and cam.moving_mass", "limits.torque_n_m")

    def problems(self, setup: Setup) -> list[Problem]:
        """What cannot be built, with key, value and allowed range."""
        roller = setup.roller
        if roller is None:
            return [Problem("roller", "a linear cam needs a roller", None, "a [roller] table")]
        if roller.shape not in ("cylinder", "crowned"):
            return [problem("roller.shape", roller.shape, "cylinder or crowned on a linear cam")]
        found = straight_problems(roller)
        if self.form == "edge":
            return [*found, *self._edge_problems(self.mechanism(setup))]
        if self.groove_depth is None or self.width is None:
            return [
                Problem(f"cam.{key}", "is missing", None, "a length in mm, for form = 'groove'")
                for key in ("groove_depth", "width") if getattr(self, key) is None
            ]  # fmt: skip
        if self.groove_depth >= self.thickness:
            found.append(problem("cam.groove_depth", self.groove_depth, f"below the thickness {self.thickness:g} mm"))
        if roller.length is not None and roller.length > self.groove_depth:
            limit = f"at most the depth of the groove, {self.groove_depth:g} mm"
            found.append(problem("roller.length", roller.length, limit))
        half = 0.5 * roller.diameter + self.running_clearance
        along, across = self.mechanism(setup).reach
        return [
            *found,
            *self._room("start", self.start, half - along[0], self.length - half - along[1], "length"),
            *self._room("edge", self.edge, half - across[0], self.width - half - across[1], "width"),
        ]

    def _edge_problems(self, mechanism: LinearMechanism) -> list[Problem]:
        """An edge that does not lie on the plate, or does not go on to its ends."""
        (low, high), foot, ahead = mechanism.touched
        if not ahead:
            limit = "such that the edge goes on towards the plate's ends where the stroke ends"
            return [problem("cam.inclination", self.inclination, limit)]
        found = []
        if not -low < self.start < self.length - high:
            ends = f"above {0.0 - low:g} and below {self.length - high:g} mm"
            limit = f"{ends}, so that the roller stays on the plate's length"
            found.append(problem("cam.start", self.start, limit))
        if self.edge <= -foot:
            limit = f"above {-foot:g} mm, so that the edge stays above the plate's foot y = 0"
            found.append(problem("cam.edge", self.edge, limit))
        return found

    @staticmethod
    def _room(key: str, value: float, low: float, high: float, size: str) -> list[Problem]:
        """A place at which the groove would leave the plate."""
        if low < value < high:
            return []
        limit = f"between {low:g} and {high:g} mm, so that the groove stays within the {size}"
        return [problem(f"cam.{key}", value, limit)]


@final
@immutable(kw_only=True)
class LinearMechanism(Mechanism):
    """A plate on its slide and its follower."""

    follower: TranslatingFollower | SwingingFollower
    cam: Linear
    carriage: Carriage

    @property
    def _roller_radius(self) -> float:
        return 0.5 * self.roller.diameter if self.roller is not None else 0.0

    @property
    def contact(self) -> tuple[float, float]:
        """Heights z between which roller and plate touch, mm."""
        top = self.cam.thickness
        depth = self.cam.groove_depth or top
        length = min(depth, (self.roller and self.roller.length) or depth)
        return (top - length, top) if self._grooved else (0.5 * (top - length), 0.5 * (top + length))

    @property
    def quoted_radius(self) -> float:
        """Middle of the contact along the roller axis, mm (a height z)."""
        return 0.5 * sum(self.contact)

    @property
    def _grooved(self) -> bool:
        return self.cam.form == "groove"

    @property
    def _floor(self) -> float:
        """Height of the groove's floor, mm; of an edge the plate's lower face."""
        return self.cam.thickness - (self.cam.groove_depth or self.cam.thickness)

    @property
    def floor_gap(self) -> float | None:
        """From the roller's end to the floor of the groove, mm; None of an edge."""
        return self.contact[0] - self._floor if self._grooved else None

    @cached_property
    def tracks(self) -> tuple[Track, ...]:
        """The roller in the groove, or on the edge."""
        assert self.roller is not None
        anchor, meridian = (self.cam.start, self.cam.edge, 0.0), self.roller.meridian(self.quoted_radius, 1.0)
        sides = (1.0, -1.0) if self._grooved else (-1.0,)
        track = roller_track(self.cam.form, self.program, 1.0, anchor, self.joint, meridian, self.contact, sides=sides)
        return (replace(track, carriage=self.carriage),)

    @cached_property
    def pivot_gap(self) -> Extreme | None:
        """From the pivot of an arm to the plate with its edge, mm, over the travel; one over a groove stands above."""
        joint = self.joint
        if self._grooved or not isinstance(joint, Swing):
            return None
        x, y, _ = joint.centre
        rate = self.cam.stroke / TURN

        def beside(share: Floats) -> Floats:
            return np.stack([x + rate * share, np.full_like(share, y)])

        least = least_outside(beside, np.array([0.0, TURN]), self.profile, PIVOT_SAMPLES)
        return Extreme(least.value, self._angle(least.cam_angle / TURN), where="pivot to plate")

    @property
    def joint(self) -> Joint:
        """What carries the roller: a slide across the travel, or an arm that turns it towards +Y."""
        follower = self.follower
        if isinstance(follower, TranslatingFollower):
            lean = radians(self.cam.inclination)
            return Slide((sin(lean), cos(lean), 0.0))
        start, way, arm = radians(follower.start_angle), follower.way, follower.arm
        return Swing((0.0, 0.0, way), (self.cam.start - way * arm * cos(start), self.cam.edge - arm * sin(start), 0.0))

    @cached_property
    def reach(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """How far the roller's middle goes along the plate and across it from where it starts, mm: least and most."""
        (x, y), _ = self._path
        return (float(x.min()), float(x.max())), (float(y.min()), float(y.max()))

    @cached_property
    def _path(self) -> tuple[Floats, Floats]:
        """Places (2, n) of the roller's middle seen from where it starts, mm, and its unit directions (2, n)."""
        travel = distinct(np.concatenate([np.linspace(0.0, self.cam.stroke, REACH_SAMPLES),
                                           self.carriage.path.knots * (self.cam.stroke / TURN)]))  # fmt: skip
        lift, anchor = self.carriage.lift(travel, 1), (self.cam.start, self.cam.edge, 0.0)
        point, _ = self.joint.carried(anchor, (0.0, 0.0, 1.0), lift)
        way = np.stack([point[1, 0] + 1.0, point[1, 1]])
        place = np.stack([point[0, 0] + travel - self.cam.start, point[0, 1] - self.cam.edge])
        return place, way / np.maximum(np.hypot(*way), 1e-300)

    @property
    def touched(self) -> tuple[tuple[float, float], float, bool]:
        """Of an edge, mm, seen from where the roller starts: least and most place along the plate at which it touches,
        the lowest place of the edge with its straight ends; and whether both of those go on towards the plate's ends.
        """
        (x, y), way = self._path
        x, y = x + self._roller_radius * way[1], y - self._roller_radius * way[0]
        ahead = bool(way[0, 0] > 0.0 and way[0, -1] > 0.0)
        rise = [0.0, 0.0] if not ahead else (way[1, [0, -1]] / way[0, [0, -1]]).tolist()
        left = y[0] - rise[0] * (x[0] + self.cam.start)
        right = y[-1] + rise[1] * (self.cam.length - self.cam.start - x[-1])
        return (float(x.min()), float(x.max())), float(min(y.min(), left, right)), ahead

    @cached_property
    def cutters(self) -> tuple[Track, ...]:
        """The same with the tool: wider by the clearance, down to the floor, or through the plate."""
        return tuple(replace(track.grown(self.running_clearance), tip=self._floor) for track in self.tracks)

    @cached_property
    def groove(self) -> PocketOutline:
        """The edge of the groove."""
        return PocketOutline(self.tracks[0].straightened(), self._roller_radius + self.running_clearance)

    @cached_property
    def profile(self) -> EdgeOutline:
        """The plate whose upper edge the roller runs on."""
        return EdgeOutline(self.tracks[0].straightened(), self._roller_radius, self.cam.length)

    @cached_property
    def outlines(self) -> dict[str, Outline]:
        """The edge of the groove, and the plate's."""
        return {"groove": self.groove, "plate": self._rim} if self._grooved else {"profile": self.profile}

    @cached_property
    def _rim(self) -> PolygonOutline:
        length, width, _ = self.box
        return PolygonOutline(np.array([[0.0, 0.0], [length, 0.0], [length, width], [0.0, width]]))

    @property
    def parts(self) -> tuple[Part, ...]:
        """The plate with its groove, or its edge."""
        if not self._grooved:
            return (EdgePlate("cam", self.profile, self.cam.thickness),)
        groove = Loop(self.groove, "flank")
        return (PocketPlate("cam", Loop(self._rim, "rim"), groove, self._floor, self.cam.thickness),)

    @property
    def envelope(self) -> tuple[float, float]:
        """Of a circle round the plate."""
        length, width, thickness = self.box
        return hypot(length, width), thickness

    @cached_property
    def box(self) -> tuple[float, float, float]:
        """Length, width and thickness of the plate; an edge is as wide as it gets high."""
        width = self.cam.width
        if width is None:
            most, _ = least_distance(self.profile.envelope, lambda x: -x[1])
            width = max(-most, float(self.profile.corners[1].max()))
        return self.cam.length, width, self.cam.thickness

    @property
    def moving_mass(self) -> float | None:
        """Of plate and slide, kg."""
        return self.cam.moving_mass

    @property
    def passes(self) -> float:
        """Out and back."""
        return 2.0

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """From the groove to the plate's edges and ends, and below it; from an edge to the plate's foot."""
        if not self._grooved:
            low, at = least_distance(self.profile.envelope, lambda x: x[1])
            place: float | None = self._angle(at / TURN)
            if (end := float(self.profile.corners[1, [2, 5]].min())) < low:
                low, place = end, None
            foot = Wall("edge to the foot y = 0", low, place, "a greater cam.edge")
            return foot, disc_wall("plate", self.cam.thickness)
        length, width, _ = self.box
        places: tuple[tuple[str, Callable[[Floats], Floats], str], ...] = (
            ("groove to the edge y = 0", lambda x: x[1], "a greater cam.edge"),
            ("groove to the other edge", lambda x: width - x[1], "a smaller cam.edge or a wider plate"),
            ("groove to the end x = 0", lambda x: x[0], "a greater cam.start"),
            ("groove to the other end", lambda x: length - x[0], "a smaller cam.start or a longer plate"),
        )
        found = [Wall(name, *self._nearest(distance), advice) for name, distance, advice in places]
        below = Wall("under the groove floor", self._floor, None, "a thicker plate, a shallower groove")
        return (*found, below, disc_wall("plate", self.cam.thickness))

    def _nearest(self, distance: Callable[[Floats], Floats]) -> tuple[float, float]:
        """Least of a distance of the groove's edge, mm, and the angle of the drive at which the roller is there."""
        least, parameter = least_distance(self.groove, distance)
        return least, self._angle(float(self.groove.share(np.array([parameter]))[0]))

    def _angle(self, share: float) -> float:
        """Angle of the drive at which the plate is out by a share of its stroke."""
        return float(self.carriage.out(np.array([share * self.cam.stroke]))[0])
