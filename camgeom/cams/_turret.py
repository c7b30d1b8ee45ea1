"""Keys and judgements that the indexing cams with grooves share: form, hand, clearances, relief, bore."""

from __future__ import annotations

from math import degrees, pi, radians
from typing import Annotated, ClassVar, Literal

from pydantic import Field

from camgeom.cams import NO_DRUM, NO_ROOT, ONE_WAY, Cam, idle, keyway_idle, problem, sense_of
from camgeom.errors import Problem
from camgeom.keys import Clearance, Gap
from camgeom.motion.program import Program
from camgeom.solid.blank import Bore
from camgeom.track import TURN, Meridian, Relief, Straight
from camgeom.track.follower import AnyRoller, Setup, SphereRoller, TurretFollower

ReliefAngle = Annotated[float, Field(gt=0.0, le=90.0, allow_inf_nan=False)]


class TurretKeys(Cam):
    """The keys of a cam whose grooves drive the rollers of a turret."""

    ROOTLESS: ClassVar[dict[str, str]] = NO_ROOT
    """keys of a root that mean nothing"""
    form: Literal["rib", "groove"] = Field(
        "rib", description="in a dwell two rollers straddle a rib, or one sits in a groove"
    )
    hand: Literal["right", "left"] = Field("right", description="right: rollers next to the cam move towards +Z")
    tip_clearance: Gap = Field(0.5, description="mm, from the roller's end to the groove floor")
    running_clearance: Clearance = Field(0.0, description="mm, normal gap between roller and each flank")
    relief: Gap = Field(
        0.0, description="mm, by which both flanks stand back at the ends of every dwell, at the pitch radius; 0: none"
    )
    relief_angle: ReliefAngle = Field(3.0, description="deg, over which the relief fades, before and after the end")
    bore: Gap = Field(0.0, description="mm, bore diameter; 0 leaves the cam solid")
    keyway_width: Gap = Field(0.0, description="mm; 0 leaves the keyway out")
    keyway_depth: Gap = Field(0.0, description="mm, from the bore wall")
    direction: Literal["ccw", "cw"] = Field("ccw", description="the cam's turning, seen from +Z")

    @property
    def way(self) -> float:
        """+1 right hand, -1 left."""
        return 1.0 if self.hand == "right" else -1.0

    def roller_pitch(self, follower: TurretFollower) -> float:
        """Angle between neighbouring rollers of the turret, rad."""
        return TURN / follower.count

    @property
    def bore_spec(self) -> Bore | None:
        """The bore, or None for a solid cam."""
        return Bore(self.bore, self.keyway_width, self.keyway_depth) if self.bore else None

    def dwell_ends(self, program: Program) -> tuple[float, ...]:
        """Cam angles in [0, 2 pi) at which a dwell begins or ends, rad."""
        return tuple(angle for angle, _ in _boundaries(program))

    def relief_of(self, program: Program, lever: float) -> Relief | None:
        """The relief of the cutters' turret angle.

        lever  mm, of the flank on the side u x v of a right hand, counter-clockwise cam about the turret's axis: the
               pitch radius, negative where that flank moves into the roller with a growing turret angle
        """
        if not self.relief:
            return None
        height = sense_of(self.direction) * self.way * self.relief / lever
        return Relief(self.dwell_ends(program), radians(self.relief_angle), height)

    def idle(self, setup: Setup) -> dict[str, str]:
        """Keys of a keyway without a bore, of a relief that is none, and of what grooves of balls do not have."""
        found = NO_DRUM | self.ROOTLESS | ONE_WAY | keyway_idle(self.bore)
        if isinstance(setup.roller, SphereRoller):
            found |= idle("grooves of balls are meshed with no fewer triangles", "output.fewest_triangles")
        found |= idle("the grooves are open, a tool comes in at an end", "cutter.lead", "cutter.start_angle")
        return found if self.relief else found | idle("without a relief it fades over no angle", "cam.relief_angle")

    def key_problems(self, setup: Setup) -> list[Problem]:
        """What is wrong with the shared keys, each with its allowed range."""
        follower, found = setup.follower, []
        assert isinstance(follower, TurretFollower)
        if follower.count % follower.stops:
            found.append(problem("follower.rollers", follower.count, f"a multiple of the {follower.stops} stops"))
        if follower.count < 2:
            found.append(problem("follower.rollers", follower.count, "at least 2, for the several starts of one stop"))
        if bool(self.keyway_width) != bool(self.keyway_depth):
            found.append(problem("cam.keyway_depth", self.keyway_depth, "width and depth both, or neither"))
        elif self.keyway_width and self.keyway_width >= self.bore:
            found.append(problem("cam.keyway_width", self.keyway_width, f"below the bore {self.bore:g} mm"))
        return found + self._step_problems(setup, follower) + self._relief_problems(setup)

    def _step_problems(self, setup: Setup, follower: TurretFollower) -> list[Problem]:
        """A cam turn carries rollers to where others stood: it steps by whole indexes, and these by whole pitches."""
        if setup.program.closed:
            return []
        advance, index = setup.program.advance, TURN / follower.stops
        counts = advance / index, advance / self.roller_pitch(follower)
        if advance > 0.0 and all(abs(count - round(count)) <= 1e-9 for count in counts):
            return []
        limit = f"a multiple of {degrees(index):.12g} deg, one index of {follower.stops} stops; `hand` turns it"
        return [problem("motion.to", degrees(advance), limit)]

    def _relief_problems(self, setup: Setup) -> list[Problem]:
        if not self.relief:
            return []
        ends = _boundaries(setup.program)
        if not ends:
            return [problem("cam.relief", self.relief, "0 for a motion without a dwell")]
        if isinstance(setup.roller, SphereRoller):
            return [problem("cam.relief", self.relief, "0 for balls, whose two flanks are one surface")]
        room = min(length for _, length in ends)
        most = degrees(0.5 * room)
        if self.relief_angle <= most + 1e-9:
            return []
        limit = f"at most {most:.12g} deg, half of the shortest dwell or motion beside an end"
        return [problem("cam.relief_angle", self.relief_angle, limit)]


def bearing_meridian(roller: AnyRoller, centre: float, tip_sign: float) -> Meridian:
    """The meridian that a turret's flank is made for: of a crown on a straight flank the cylinder of its crest."""
    meridian = roller.meridian(centre, tip_sign)
    return meridian if roller.arc is None else Straight(0.5 * roller.diameter, centre)


def _boundaries(program: Program) -> list[tuple[float, float]]:
    """Every cam angle in [0, 2 pi) between a dwell and a motion, with the length of the shorter of the two, rad."""
    spans = program.spans
    resting = [span.before == span.after for span in spans]
    runs: list[tuple[float, float, bool]] = []
    for span, still in zip(spans, resting):
        if runs and runs[-1][2] == still:
            runs[-1] = (runs[-1][0], span.end, still)
        else:
            runs.append((span.start, span.end, still))
    if len(runs) > 1 and runs[0][2] == runs[-1][2]:
        # The turn begins in the middle of a stretch.
        runs = [(runs[-1][0] - 2.0 * pi, runs[0][1], runs[0][2]), *runs[1:-1]]
    if len(runs) < 2:
        return []
    lengths = [end - start for start, end, _ in runs]
    return [(run[0] % TURN, min(lengths[i], lengths[i - 1])) for i, run in enumerate(runs)]
