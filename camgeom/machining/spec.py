"""The `[cutter]` table of a profile: tool, path, feeds and axes (mm, degrees, mm/min, r/min)."""

from __future__ import annotations

from math import atan, cos, degrees, radians
from typing import TYPE_CHECKING, Annotated, Literal, final

from pydantic import Field

from camgeom.errors import Problem
from camgeom.keys import Degrees, Gap, Length, Section
from camgeom.machining.wall import SAME, is_radial, leans, narrowest, roller_at, slope_to_tip, wall_ends
from camgeom.track import Track

if TYPE_CHECKING:
    from collections.abc import Sequence

    from camgeom.solid.mechanism import Mechanism

Kind = Literal["roller", "flat", "ball", "wheel"]
WayOfPath = Literal["flank", "centre", "shifted"]
AxisRule = Literal["roller", "fitted", "radial"]

LEAST = 1e-6
"""mm; a smaller arc, or less room beside a tool in its groove, is none"""


@final
class CutterSpec(Section):
    """The tool that makes the flanks, its path, and the machine that carries it."""

    kind: Kind = Field(
        "roller", description="roller: shaped as the roller; flat: end mill; ball: ball mill; wheel: grinding wheel"
    )
    diameter: Length | None = Field(None, description="mm, of the tool; for kind roller that of the roller")
    half_angle: Annotated[float, Field(gt=-85.0, lt=85.0)] = Field(
        0.0, description="deg, of a taper end mill, as that of the conical roller, beside whose flank it stands with "
        "its axis along the roller's; its diameter is that of its end; 0: a straight one"
    )
    corner_radius: Gap = Field(
        0.0, description="mm, of the tool's end, which rounds the groove's root; 0: a sharp end"
    )
    length: Length | None = Field(None, description="mm, cutting length; default: as deep as the tool goes")
    neck: Gap | None = Field(
        None, description="mm, by which a ball's shank is thinner (in radius); default a tenth of the ball's radius"
    )
    width: Length | None = Field(None, description="mm, width of a wheel that works with its side")
    path: WayOfPath = Field(
        "flank",
        description="of a tool smaller than the roller. flank: along each flank's normal; centre: the roller's path; "
        "shifted: the roller's path moved along the follower's motion",
    )
    axis: AxisRule = Field(
        "roller",
        description="of the tool. roller: parallel to the roller's; fitted: through two depths of the flank; "
        "radial: through the cam's axis (drums on a machine without a cross axis)",
    )
    contact: Literal["rim", "side"] = Field("rim", description="of a wheel: its rim or its plane side works")
    allowance: Gap = Field(0.0, description="mm, stock left on the flank")
    scallop: Annotated[float, Field(ge=1e-5, le=10.0)] = Field(
        0.01, description="mm, height of the ridges between the rows of a ball"
    )
    tolerance: Annotated[float, Field(ge=1e-6, le=1.0)] = Field(
        0.0005, description="mm, chord error of the path between two blocks"
    )
    gouge_limit: Gap = Field(0.005, description="mm, by how much the tool may cut into a finished flank")
    feed: Annotated[float, Field(gt=0.0, le=1e6)] = Field(300.0, description="mm/min, surface speed at the contact")
    max_feed: Annotated[float, Field(gt=0.0, le=1e7)] | None = Field(
        None, description="mm/min, of the tool's centre, where the contact stands still; default ten times feed"
    )
    spindle: Annotated[float, Field(gt=0.0, le=1e6)] = Field(2000.0, description="r/min, clockwise")
    milling: Literal["climb", "conventional"] = Field("climb", description="way round the flanks")
    start_angle: Degrees = Field(0.0, description="deg, cam angle where a closed path starts and ends")
    lead: Gap | None = Field(None, description="mm, radius of the arc in and out; default: what room there is")
    retract: Length = Field(5.0, description="mm, from the blank to where the tool may move freely")
    overrun: Gap = Field(0.0, description="mm, by which the tool passes the lower face of a disc")
    machine: Literal["rotary", "plain"] = Field(
        "rotary", description="G-code: rotary: a rotary axis turns the cam; plain: planar cams by X and Y "
        "alone, as linear cams always are"
    )
    rotary: Literal["A", "B", "C"] | None = Field(
        None, description="letter of the axis that turns the cam; default A, on discs and within rings C"
    )
    reversed_rotary: bool = Field(False, description="the rotary axis counts the other way")
    pivot: Gap = Field(0.0, description="mm, from the tool's end to the swing axis; 0: the control follows the tip")
    feed_mode: Literal["inverse-time", "per-minute"] = Field("inverse-time", description="G93 or G94")
    tool_number: Annotated[int, Field(ge=1, le=9999)] = Field(1, description="of the tool changer")

    @property
    def fastest(self) -> float:
        """Largest speed of the tool's centre, mm/min."""
        return self.max_feed if self.max_feed is not None else 10.0 * self.feed

    def idle(self) -> dict[str, str]:
        """The keys that nothing reads, each with the reason."""
        found = {}
        if self.kind != "ball":
            found["scallop"] = "only a ball cuts in rows that leave ridges"
        if self.kind == "ball" or (self.kind == "wheel" and self.contact == "side"):
            found["corner_radius"] = "a ball, or a wheel that works with its side, has no corner of its own"
        if self.kind != "flat":
            found["half_angle"] = "only an end mill, kind = 'flat', may be a taper"
        if self.kind != "wheel":
            found["contact"] = "only a wheel works with its rim or its side"
        if self.machine == "plain":
            found |= dict.fromkeys(("rotary", "reversed_rotary"), "machine = 'plain' has no rotary axis")
        return found

    def one_way(self, mechanism: Mechanism) -> str:
        """Why `milling` is the same either way round a cam's flanks; empty where it is not."""
        if self.kind == "wheel" and self.contact == "side":
            return "a wheel that works with its side goes along a flank either way alike"
        tracks = mechanism.cutters
        if tracks and all(len(track.sides) > 1 and self._fills(track) for track in tracks):
            return "the tool fills its groove: it climbs along one wall and mills the other conventionally, either way"
        return ""

    def _fills(self, track: Track) -> bool:
        """Whether the tool goes once down the middle of a groove."""
        if self.kind == "roller" or self.path == "centre":
            return True
        if self.kind == "ball" or self.diameter is None or self.axis != "roller":
            return False
        return 0.5 * self.diameter + self.stock_across >= self._half(track) - LEAST

    @property
    def stock_across(self) -> float:
        """The stock left, square to the tool's axis, mm."""
        return self.allowance / cos(radians(self.half_angle))

    def _half(self, track: Track) -> float:
        """Largest radius of a tool that goes once down the middle of a groove, mm: of a taper at its end."""
        place = track.meridian.parameter(track.tip) if self.half_angle else 0.5 * sum(wall_ends(track))
        return roller_at(track, place)[1]

    def upright(self, mechanisms: Sequence[Mechanism]) -> list[Problem]:
        """What is wrong with a fitted axis on a disc of which no flank leans."""
        flat = all(one.blank is None and one.carriage is None for one in mechanisms)
        if self.axis != "fitted" or not flat or any(map(leaning, mechanisms)):
            return []
        return [_problem("axis", self.axis, "roller, for a disc")]

    def largest(self, track: Track) -> float:
        """Largest radius of a tool that goes into a groove, mm: of a taper at its end."""
        return self._half(track) if self.half_angle else narrowest(track)

    def problems(self, mechanism: Mechanism) -> list[Problem]:
        """What contradicts itself or the cam, with key, value and allowed range."""
        found = self._own_problems()
        if found:
            return found
        if self.half_angle:
            found += self._taper_problems(() if _shares(mechanism) else mechanism.tracks, leaning(mechanism))
        if mechanism.carriage is not None:
            return found + self._planar_problems(True) + self._plate_problems(mechanism)
        if leaning(mechanism):
            return found + self._leaning_problems(mechanism.cutters)
        if mechanism.blank is None:
            # A straight flank may stand beside one that leans: `upright` asks all tracks of a disc.
            found += self._planar_problems(mechanism.roller is not None)
            return [one for one in found if one.key != "cutter.axis" or self.axis != "fitted"]
        tracks = mechanism.cutters
        found += self.no_overrun()
        if self.machine == "plain":
            found.append(_problem("machine", self.machine, "rotary: this cam's flanks run round it"))
        if self.axis == "radial" and not all(is_radial(track) for track in tracks):
            found.append(_problem("axis", self.axis, "roller or fitted where the roller does not point at the axis"))
        found += self._ring_problems() if mechanism.inside else []
        return [*found, *self._width_problems(tracks), *self._root_problems(tracks)]

    def _taper_problems(self, tracks: tuple[Track, ...], leaning: bool) -> list[Problem]:
        """A taper lies along the flank of a cone of its own half angle, its axis along the roller's."""
        angles = _half_angles(tracks)
        if _unequal(angles):
            each = " and ".join(dict.fromkeys(f"{angle:g}" for angle in angles))
            straight = "0 with axis = 'fitted'" if leaning else "0"
            why = f"one taper does not lie along rollers of unequal half angles, {each} deg"
            limit = f"{straight}, or kind = 'roller': {why}"
            return [_problem("half_angle", self.half_angle, limit)]
        found = [_problem(key, getattr(self, key), f"{word}, for a taper")
                 for key, word in (("path", "flank"), ("axis", "roller")) if getattr(self, key) != word]  # fmt: skip
        if not angles or abs(angles[0] - self.half_angle) > SAME:
            leans = bool(angles) and max(map(abs, angles)) > SAME
            limit = f"0, or that of the roller, {angles[0]:g} deg" if leans else "0"
            found.append(_problem("half_angle", self.half_angle, limit))
        return found

    def _leaning_problems(self, tracks: tuple[Track, ...]) -> list[Problem]:
        """A disc's flank that leans is cut by a cone upright, by a mill that leans as it does, or in rows of a ball."""
        found = []
        leaning = self.axis == "fitted"
        if self.kind == "ball" and not all(map(leans, tracks)):
            found.append(_problem("kind", self.kind, "roller, flat or wheel: one disc's flank is straight"))
        if self.kind == "wheel" and self.contact == "side":
            found.append(_problem("contact", self.contact, "rim on a disc"))
        if self.kind in ("flat", "wheel") and not self.half_angle:
            if not leaning:
                tapered = self.kind == "flat" and not _unequal(_half_angles(tracks))
                other = " (or a half_angle as the roller's)" if tapered else ""
                limit = f"fitted{other}: along Z it does not lie on a flank that leans"
                found.append(_problem("axis", self.axis, limit))
            if self.path != "flank":
                found.append(_problem("path", self.path, "flank, for a disc"))
        if self.machine == "plain" and leaning:
            found.append(_problem("machine", self.machine, "rotary: the tool leans another way all round"))
        if self.pivot and not leaning:
            found.append(_problem("pivot", self.pivot, "0: nothing swings a tool that stays along the cam's axis"))
        found += self.no_overrun() if any(len(track.sides) > 1 for track in tracks) else []
        return found + self._width_problems(tracks)

    def no_overrun(self) -> list[Problem]:
        """Of a cam that is grooves alone."""
        allowed = "0: only the flank of a disc has a lower face to pass"
        return [_problem("overrun", self.overrun, allowed)] if self.overrun else []

    def _ring_problems(self) -> list[Problem]:
        """A groove in the inside of a ring is cut by an angle head."""
        found = []
        if self.kind == "wheel" and self.contact == "side":
            found.append(_problem("contact", self.contact, "rim within a ring"))
        if self.pivot:
            found.append(_problem("pivot", self.pivot, "0: an angle head within a ring does not swing"))
        return found

    def _root_problems(self, tracks: tuple[Track, ...]) -> list[Problem]:
        """A rounded root is swept by a tool whose end has that radius."""
        root = max(track.root for track in tracks)
        if not root:
            return []
        if self.kind == "ball" or (self.kind == "wheel" and self.contact == "side"):
            return [_problem("kind", self.kind, "roller, flat, or a wheel's rim, where the root is rounded")]
        if self.axis != "roller":
            return [_problem("axis", self.axis, "roller where the root is rounded")]
        if self.diameter is not None and root > 0.5 * self.diameter:
            limit = f"at least twice the root's radius, {2.0 * root:g} mm"
            return [_problem("diameter", self.diameter, limit)]
        return []

    def _own_problems(self) -> list[Problem]:
        found = []
        if self.kind == "roller":
            if self.diameter is not None:
                found.append(_problem("diameter", self.diameter, "none for kind = 'roller'; or choose another kind"))
            found += self._plain_path("a tool like the roller, which follows it")
            if self.allowance:
                found.append(_problem("allowance", self.allowance, "0: a tool like the roller leaves no stock"))
        elif self.diameter is None:
            found.append(Problem("cutter.diameter", "is missing", None, "mm, the tool's diameter"))
        if self.kind == "ball":
            found += self._plain_path("a ball")
        if self.neck is not None and not (self.kind == "ball" and self.diameter and self.neck < 0.5 * self.diameter):
            found.append(_problem("neck", self.neck, "below the radius, for a ball, and for it alone"))
        side = self.kind == "wheel" and self.contact == "side"
        if side != (self.width is not None):
            found.append(_problem("width", self.width, "mm, for a wheel that works with its side, and for it alone"))
        return found + (self._plain_path("a wheel's side") if side else [])

    def _plain_path(self, what: str) -> list[Problem]:
        """A tool that has one way to go: beside the flank, parallel to the roller."""
        wanted = {"path": "flank", "axis": "roller"}
        return [
            _problem(key, getattr(self, key), f"{word}, for {what}")
            for key, word in wanted.items()
            if getattr(self, key) != word
        ]

    def _planar_problems(self, rolled: bool) -> list[Problem]:
        found = []
        if self.kind == "roller" and not rolled:
            found.append(Problem("cutter.kind", "there is no roller to be like", self.kind, "flat or wheel"))
        if self.kind == "ball":
            found.append(_problem("kind", self.kind, "roller, flat or wheel: a disc's flank is straight"))
        if self.kind == "wheel" and self.contact == "side":
            found.append(_problem("contact", self.contact, "rim on a disc"))
        if self.pivot:
            found.append(_problem("pivot", self.pivot, "0: no swing axis turns on a disc"))
        return found + self._plain_path("a disc")

    def _plate_problems(self, mechanism: Mechanism) -> list[Problem]:
        """A plate is cut by X and Y alone, from its upper face, beginning at an end of its groove, or at a corner."""
        absent = {"start_angle": 0.0, "rotary": None, "reversed_rotary": False}
        absent |= {"overrun": 0.0} if mechanism.form == "groove" else {}
        return [
            _problem(key, getattr(self, key), "none on a plate, which lies still under X and Y and has two ends")
            for key, wanted in absent.items()
            if getattr(self, key) != wanted
        ]

    def _width_problems(self, tracks: tuple[Track, ...]) -> list[Problem]:
        """A tool must go into the groove; beside a rib it has room."""
        if self.kind == "roller" or self.diameter is None or (self.kind == "wheel" and self.contact == "side"):
            return []
        least = min((2.0 * self.largest(track) for track in tracks if len(track.sides) > 1), default=None)
        stock = 2.0 * self.stock_across
        if least is None or self.diameter + stock <= least + SAME:
            return []
        room = f"at most {least - stock:.6g} mm, the groove{' less the stock' if self.allowance else ''}"
        return [Problem("cutter.diameter", "the tool does not go into the groove", self.diameter, room)]


def leaning(mechanism: Mechanism) -> bool:
    """True of a disc, or a pair, with such a flank."""
    return mechanism.blank is None and not _shares(mechanism) and any(map(leans, mechanism.tracks))


def _shares(mechanism: Mechanism) -> bool:
    """True of plates that a turret's rollers share, which are cylinders."""
    from camgeom.solid.mechanism import Drive

    return mechanism.blank is None and mechanism.drive is Drive.SHARED


def _problem(key: str, value: object, allowed: str) -> Problem:
    return Problem(f"cutter.{key}", "cannot be made so", value, allowed)


def _half_angles(tracks: tuple[Track, ...]) -> list[float]:
    """Of the rollers of these tracks, deg, rising: what a taper for each would have."""
    return sorted({degrees(atan(slope_to_tip(track))) for track in tracks})


def _unequal(angles: list[float]) -> bool:
    """Whether no one taper lies along all rollers of these half angles, rising."""
    return bool(angles) and angles[-1] - angles[0] > SAME
