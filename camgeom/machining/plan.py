"""All passes that make one cam's flanks with one tool: their blocks, feeds, ways in and out, and rapid ways between.

A tool comes down beside the flank (or in the middle of the groove), goes in on a tangent arc, and back the same way.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, replace
from math import sqrt
from typing import Literal, final

import numpy as np

from camgeom.errors import DesignError, NotConverged
from camgeom.immutable import immutable
from camgeom.machining.machine import Machine
from camgeom.machining.path import Positions, SidePath, ToolPath, climbs
from camgeom.machining.rows import RowPath, Rows
from camgeom.machining.spec import LEAST, CutterSpec
from camgeom.machining.tool import Tool
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid, refined_maximum
from camgeom.maths.frozen import cached_property
from camgeom.maths.sampling import even_steps, steps_about, subdivided
from camgeom.maths.surface import dot
from camgeom.track import Track

SHARE = 0.5
"""of the room beside the flank: an arc of that radius stays within the roller's body"""


@immutable
class Move:
    """Positions reached one after another.

    kind     cut: along the flank; feed: in and out; rapid
    lengths  of a cut, (n,) mm: how far the contact moves along the flank up to each position from the one before
    """

    kind: str
    positions: Positions
    lengths: Floats | None = None


def lead_radius(wanted: float | None, room: float | None, tool_radius: float) -> float:
    """Radius of the arc in and out, mm: the wanted one, else what there is room for; 0: straight down."""
    if room is None:
        return tool_radius if wanted is None else wanted
    most = SHARE * room
    radius = most if wanted is None else wanted
    return radius if radius > LEAST else 0.0


def with_leads(cut: Positions, lengths: Floats, radius: float, lift: float, chord: float) -> list[Move]:
    """The cut with what comes before and after it.

    lengths  (n - 1,) mm, between its contacts, along the flank
    radius  mm, of the quarter circles in and out; 0: none
    lift    mm, from the cut to where the tool may move freely
    chord   mm, error of the arcs' chords
    """
    moves = []
    first, last = cut.part(slice(0, 1)), cut.part(slice(-1, None))
    arc_in = quarter(first, radius, chord, -1.0)
    arc_out = quarter(last, radius, chord, 1.0)
    begin = arc_in.part(slice(0, 1)) if arc_in else first
    end = arc_out.part(slice(-1, None)) if arc_out else last
    moves.append(Move("rapid", begin.lifted(lift)))
    moves.append(Move("feed", begin))
    if arc_in:
        moves.append(Move("feed", arc_in.part(slice(1, None))))
    steps = np.concatenate([[0.0], lengths])
    moves.append(Move("cut", cut, steps) if arc_in else Move("cut", cut.part(slice(1, None)), steps[1:]))
    if arc_out:
        moves.append(Move("feed", arc_out))
    moves.append(Move("rapid", end.lifted(lift)))
    return moves


def quarter(at: Positions, radius: float, chord: float, way: float) -> Positions | None:
    """A quarter circle that ends (way -1) or starts (+1) at a position, along its travel; without that position."""
    if radius <= LEAST:
        return None
    n = max(4, int(np.ceil(0.25 * np.pi / np.sqrt(2.0 * chord / radius))))
    angle = 0.5 * np.pi * np.arange(1, n + 1) / n
    angle = angle if way > 0.0 else angle[::-1]
    # Square to the tool's axis: beside a cone the normal is not, and the tool would go deeper.
    normal = at.normals[0] - dot(at.normals[0], at.axis) * at.axis
    normal = normal / np.sqrt(dot(normal, normal))
    off = way * np.sin(angle) * at.travel - (1.0 - np.cos(angle)) * normal
    return replace(at.repeated(len(angle)), tip=at.tip + radius * off)


Space = Literal["cam", "machine"]

MOST_BLOCKS = 2_000_000
"""in one pass; the arrays of one take about half a gigabyte"""
MOST_IN_FILE = 4_000_000
"""in all passes: some 15 s of one core, a file of 0.3 GB"""
FINE = np.radians(1.0)
"""cam angle of the chords that a contact's way is summed from"""
WIDEST = np.radians(30.0)
"""largest rotation of one block: controls that take the shorter way round must not turn back"""
SHARES = (0.25, 0.5, 0.75)
"""where along a block the chord is measured"""
FINER = 33
"""shares at which the sag of a chord is looked for, from what was measured"""
PER_TURN = 360
"""samples of a path before its extremes are refined"""
TRANSFER = np.radians(5.0)
"""rotation between the positions of a rapid way from one pass to the next"""


@immutable
class Chords:
    """What is interpolated, and what counts.

    curve    phi (n,) -> coordinates (c, n) that a machine interpolates in straight lines
    locate   coordinates (c, n) -> points of the tool (k, 3, n), mm, whose way counts
    """

    curve: Callable[[Floats], Floats]
    locate: Callable[[Floats], Floats]

    def error(self, phi: Floats) -> Floats:
        """Largest distance (n - 1,), mm, of each chord from the true way, across it."""
        ends = self.curve(phi)
        points = self.locate(ends)
        chord = points[:, :, 1:] - points[:, :, :-1]
        length = np.sqrt((chord**2).sum(axis=1, keepdims=True))
        along = chord / np.where(length > 0.0, length, 1.0)
        worst = np.zeros(len(phi) - 1)
        for share in SHARES:
            mixed = (1.0 - share) * ends[:, :-1] + share * ends[:, 1:]
            off = self.locate(mixed) - self.locate(self.curve((1.0 - share) * phi[:-1] + share * phi[1:]))
            across = off - (off * along).sum(axis=1, keepdims=True) * along
            worst = np.maximum(worst, np.sqrt((across**2).sum(axis=1)).max(axis=0))
        return worst


@final
@immutable
class Pass:
    """One pass, from where the tool is free to where it is free again.

    moves        in order
    chord_error  mm, measured on the cut (rows of a ball: on the lowest, middle and highest)
    tool         number of its tool among those of the cam, the first is 0
    below        True where the part is turned over, since the spindle would come from below
    begins       True where another tool or another side of the part begins: nothing leads there from the pass before
    """

    name: str
    moves: tuple[Move, ...]
    chord_error: float
    tool: int = 0
    below: bool = False
    begins: bool = True

    @property
    def blocks(self) -> int:
        """Positions of all moves."""
        return sum(len(move.positions.phi) for move in self.moves)


@final
@immutable
class Sag:
    """What the chords of a path do to its flanks, mm: how deep they cut at most, and how much they leave; each with
    the cam angle, rad."""

    cut: float = 0.0
    cut_at: float = 0.0
    left: float = 0.0
    left_at: float = 0.0

    @classmethod
    def worst(cls, found: Sequence[Sag]) -> Sag:
        """The most of each."""
        cut = max(found, key=lambda one: one.cut, default=cls())
        left = max(found, key=lambda one: one.left, default=cls())
        return cls(cut.cut, cut.cut_at, left.left, left.left_at)


@final
@immutable
class Hollow:
    """The room within a ring that a tool works from: its radius, and heights z from the web to the upper end, mm."""

    radius: float
    low: float
    high: float


@immutable
class Room:
    """What a ring that is cut from within leaves an angle head, mm.

    length  of it with its tool, as thick as that, from the tool's end, where it is free, to the ring behind
    below   from the tool's axis, where it is lowest, down to the web
    """

    length: float
    below: float


@final
@immutable
class Machining:
    """The passes over all flanks of a cam.

    paths   one a pass, in order
    tools   the tool of each path (a form tool's place on its meridian may differ from track to track)
    rows    of a ball, by track and side
    tracks  the cutters' tracks; empty for planar cams
    hollow  of a ring that is cut from within, by a tool that comes and goes over its upper end
    assumed  True where nobody chose the tool: one like the roller, with the table's defaults
    """

    title: str
    spec: CutterSpec
    paths: tuple[ToolPath, ...]
    tools: tuple[Tool, ...]
    machine: Machine
    safe_radius: float
    tracks: tuple[Track, ...] = ()
    rows: tuple[Rows, ...] = ()
    hollow: Hollow | None = None
    assumed: bool = False
    _shared: dict[tuple[Space, int | ToolPath], tuple[Floats, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Raises DesignError where the wanted arc in and out, cutter.lead, does not fit beside a flank."""
        wanted = self.spec.lead or 0.0
        for path in self.paths:
            most = SHARE * path.room if path.closed and path.room is not None else wanted
            if wanted > max(most, LEAST):
                least = f"at most {most:.6g} mm" if most > LEAST else "0, straight down"
                raise DesignError(f"cutter.lead {wanted:g} mm has no room beside the flank: {least}, or a smaller tool")

    @property
    def tool(self) -> Tool:
        """The first tool, of most cams the only one."""
        return self.tools[0]

    @property
    def different(self) -> tuple[Tool, ...]:
        """The tools to be got ready, each once: rollers of different sizes are followed by different tools."""
        return tuple({tool.shape: tool for tool in reversed(self.tools)}.values())[::-1]

    @cached_property
    def _by_path(self) -> dict[ToolPath, Tool]:
        return dict(zip(self.paths, self.tools))

    def _tool_of(self, path: ToolPath) -> Tool:
        return self._by_path[path]

    def tool_along(self, track: Track) -> Tool:
        """The tool of a track."""
        return next(tool for path, tool in zip(self.paths, self.tools) if path.follows(track))

    def blocks_about(self, space: Space = "cam") -> int:
        """About how many positions all passes take."""
        if self.rows:
            blocks = 0
            for i, group in enumerate(self.rows):
                chords, knots = self._chords_of_rows(i, space), group.paths[0].knots()
                blocks += len(group.paths) * self._about(chords, knots)
            return blocks
        return sum(self._about(self._chords((path,), space), path.knots()) for path in self.paths)

    def _about(self, chords: Chords, knots: Floats) -> int:
        return steps_about(chords.error, list(itertools.pairwise(knots.tolist())), self.spec.tolerance) + 1

    def passes(self, space: Space = "cam") -> Iterator[Pass]:
        """The passes one by one, blocks so spaced that the chord error in a space keeps spec.tolerance.

        space  cam: ends and axes of the tool are interpolated straight in the cam frame (CL data); machine: the
               coordinates of the machine are (G-code)
        Raises NotConverged where the file would have more than MOST_IN_FILE blocks.
        """
        about = self.blocks_about(space)
        if about > MOST_IN_FILE:
            raise NotConverged(
                f"the cutter data would have about {about} blocks, more than {MOST_IN_FILE}; ask for a coarser "
                "cutter.scallop or cutter.tolerance"
            )
        last: Positions | None = None
        shapes, at = [tool.shape for tool in self.different], (0, False)
        for path in self.paths:
            tool, below = shapes.index(self._tool_of(path).shape), path.below
            begins = last is None or (tool, below) != at
            tool_pass, at = replace(self._pass(path, space), tool=tool, below=below, begins=begins), (tool, below)
            first, *between, final = tool_pass.moves
            if last is not None and not begins:
                first = Move("rapid", self._transfer(last, first.positions))
            last = final.positions
            if self.hollow is not None:
                first = Move("rapid", self._over(first.positions, self.hollow)) if begins else first
                final = Move("rapid", self._over(last, self.hollow, -1)) if path is self.paths[-1] else final
            yield replace(tool_pass, moves=(first, *between, final))

    def _pass(self, path: ToolPath, space: Space) -> Pass:
        phi, error = self._blocks(path, space)
        cut = path.at(phi)
        lengths = contact_lengths(path, phi)
        wanted = climbs(cut) == (self.spec.milling == "climb")
        if not wanted and cut.contacts.shape[0] == 1 and not isinstance(path, SidePath):
            cut, lengths = cut.reversed(), lengths[::-1]
        moves = with_leads(cut, lengths, self.lead(path), path.height + self.spec.retract, 0.5 * self.spec.tolerance)
        moves[0] = Move("rapid", self._outside(moves[0].positions))
        moves[-1] = Move("rapid", self._outside(moves[-1].positions))
        return Pass(path.name, tuple(moves), error)

    def _blocks(self, path: ToolPath, space: Space) -> tuple[Floats, float]:
        """Cam angles of a pass's blocks and their chord error; rows of one flank share them."""
        rows = path.group if isinstance(path, RowPath) else None
        key = (space, path if rows is None else rows)
        if key not in self._shared:
            chords = self._chords((path,), space) if rows is None else self._chords_of_rows(rows, space)
            self._shared[key] = spaced(chords, divided_knots(path.knots()), self.spec.tolerance)
        return self._shared[key]

    def sag(self, path: ToolPath, space: Space = "cam") -> Sag:
        """By how much the chords of a path's blocks, as `passes` has them, are off along the flanks' normals: of a tool
        whose side works, at both ends of the cut."""
        phi, _ = self._blocks(path, space)
        chords, lever, share = self._chords((path,), space), self._lever((path,)), np.array(SHARES)[:, None]
        at = path.at(((1.0 - share) * phi[:-1] + share * phi[1:]).ravel())
        if space == "machine" and self.machine.below(at):
            at = at.turned_over(self.machine.over)
        ends = chords.curve(phi)
        mixed = (1.0 - share) * ends[:, None, :-1] + share * ends[:, None, 1:]
        off = chords.locate(mixed.reshape(len(ends), -1)) - np.stack([at.tip, at.tip + lever * at.axis])
        chord = np.tile(np.diff(chords.locate(ends)), len(share))
        square = np.maximum((chord**2).sum(axis=1, keepdims=True), 1e-300)
        off -= (off * chord).sum(axis=1, keepdims=True) / square * chord
        moved, turned, to = off[0], (off[1] - off[0]) / lever, at.contacts - at.tip
        # The tool turns about its end as its axis does, (axis x turned) x to.
        own = (at.normals * moved).sum(axis=1) - (at.normals * at.axis).sum(axis=1) * (to * turned).sum(axis=1)
        beside = self._tool_of(path).kind != "disc" and not isinstance(path, RowPath)
        leant = (at.normals * turned).sum(axis=1)
        deep = [own + place * leant for place in ((0.0, path.height) if beside else ((to * at.axis).sum(axis=1),))]
        found = _between(np.concatenate(deep).reshape(-1, len(share), len(phi) - 1))
        where = at.phi.reshape(len(share), -1)[1]
        cut, left = found.max(axis=(0, 1)), -found.min(axis=(0, 1))
        i, j = int(np.argmax(cut)), int(np.argmax(left))
        return Sag(max(0.0, float(cut[i])), float(where[i]), max(0.0, float(left[j])), float(where[j]))

    def _chords_of_rows(self, group: int, space: Space) -> Chords:
        paths = self.rows[group].paths
        picked = (paths[0], paths[len(paths) // 2], paths[-1]) if len(paths) > 2 else paths
        return self._chords(picked, space)

    def _chords(self, paths: tuple[ToolPath, ...], space: Space) -> Chords:
        """What a control interpolates on these paths, and the points of the tool whose way counts."""
        lever = self._lever(paths)
        into, back = self._coordinates(space)

        def curve(phi: Floats) -> Floats:
            return np.concatenate([into(path.at(phi)) for path in paths])

        def locate(coordinates: Floats) -> Floats:
            points = []
            for part in np.split(coordinates, len(paths)):
                tip, axis = back(part)
                points += [tip, tip + lever * axis / np.sqrt((axis**2).sum(axis=0))]
            return np.stack(points)

        return Chords(curve, locate)

    def _lever(self, paths: tuple[ToolPath, ...]) -> float:
        """From the tool's end to the other point of its axis whose way counts, mm."""
        return self.tool.radius if self.tool.kind == "disc" else max(path.height for path in paths)

    def _coordinates(
        self, space: Space
    ) -> tuple[Callable[[Positions], Floats], Callable[[Floats], tuple[Floats, Floats]]]:
        if space == "machine":
            return self.machine.solve, self.machine.positions
        return lambda at: np.concatenate([at.tip, at.axis]), lambda c: (c[:3], c[3:])

    def _outside(self, at: Positions) -> Positions:
        """A free position moved on, the way the tool leaves, until it is outside the blank's largest radius.

        Within a ring: until the tool stands within its inside. Raises DesignError where that has no room for it.
        """
        tip, away = at.tip[:, 0], at.away[:, 0]
        if self.hollow is not None:
            beside = abs(float(tip[0] * away[1] - tip[1] * away[0])) + self.thickest
            if beside >= self.safe_radius:
                raise DesignError(
                    f"cutter.retract {self.spec.retract:g} mm leaves a tool {2.0 * self.thickest:.6g} mm thick no "
                    f"place within the ring; below {self.hollow.radius - beside:.6g} mm"
                )
            return at.lifted(-sqrt(self.safe_radius**2 - beside**2) - float(tip[:2] @ away[:2]))
        a = float(away[0] ** 2 + away[1] ** 2)
        b = float(tip[0] * away[0] + tip[1] * away[1])
        c = float(tip[0] ** 2 + tip[1] ** 2) - self.safe_radius**2
        if c >= 0.0 or a < 1e-6:
            return at
        further = (-b + np.sqrt(b * b - a * c)) / a
        return at.lifted(further)

    @cached_property
    def thickest(self) -> float:
        """Largest radius of the tool along the cut, mm."""
        return max(tool.thickest(path.height) for path, tool in zip(self.paths, self.tools))

    @cached_property
    def standing(self) -> float:
        """Width of what mills leave of a groove between their passes along its two walls, mm; 0 where those meet."""
        if self.spec.kind == "wheel":
            return 0.0  # A groove is ground once it is milled.
        rooms = [(path.room or 0.0, tool.radius) for path, tool in zip(self.paths, self.tools) if path.between]
        width = max((2.0 * (room - radius) for room, radius in rooms), default=0.0)
        return width if width > LEAST else 0.0

    @cached_property
    def room(self) -> Room | None:
        """What a ring that is cut from within leaves the angle head; None of other cams."""
        if self.hollow is None:
            return None
        around = self.hollow.radius**2

        def length(at: Positions) -> Floats:
            along = at.tip[0] * at.away[0] + at.tip[1] * at.away[1]
            beside = np.abs(at.tip[0] * at.away[1] - at.tip[1] * at.away[0]) + self.thickest
            return np.asarray(np.sqrt(np.maximum(around - beside * beside, 0.0)) - along)

        free = [float(length(self._outside(at))[0]) for path in self.paths for at in self._plunges(path)]
        cut = [-_largest(path, lambda at: -length(at)) for path in self.paths]
        lowest = -max(_largest(path, lambda at: -at.tip[2]) for path in self.paths)
        return Room(min(free + cut), lowest - self.hollow.low)

    def _plunges(self, path: ToolPath) -> Iterator[Positions]:
        """Where the tool comes down beside the flank and where it leaves, at the far ends of the arcs."""
        for way, phi in zip((-1.0, 1.0), path.knots()[[0, -1]]):
            at = path.at(np.array([phi]))
            arc = quarter(at, self.lead(path), 0.5 * self.spec.tolerance, way)
            yield at if arc is None else arc.part(slice(0, 1) if way < 0.0 else slice(-1, None))

    def lead(self, path: ToolPath) -> float:
        """Radius of the arcs in and out, mm."""
        return lead_radius(self.spec.lead, path.room, self._tool_of(path).radius) if path.closed else 0.0

    def _over(self, at: Positions, hollow: Hollow, way: int = 1) -> Positions:
        """The way to a position from over the ring's upper end, way +1, or back there."""
        both = at.repeated(2)
        over = np.array([0.0, 0.0, hollow.high + self.spec.retract + self.thickest - at.tip[2, 0]])
        steps = np.stack([over, 0.0 * over], axis=1)
        return replace(both, tip=both.tip + steps[:, ::way])

    def _transfer(self, last: Positions, start: Positions) -> Positions:
        """A rapid way round the blank from the end of one pass to the start of the next.

        Radius, azimuth and height of the tool's end change evenly, and so does its axis beside the follower; where
        the axis turns to the other side it does so at the end.
        """
        turn = self.machine.sense * float(start.phi[0] - last.phi[0])
        # Whole turns need no travel in the cam frame, but the machine's rotary axis unwinds them.
        count = max(1, int(np.ceil(abs(turn) / TRANSFER)))
        share = np.arange(1, count + 1) / count
        ends = [_beside(at, self.machine.sense) for at in (last, start)]
        (place, axis), (goal, aim) = ends
        goal[1] = place[1] + np.angle(np.exp(1j * (goal[1] - place[1])))
        between = place[:, None] + (goal - place)[:, None] * share
        away = self.machine.sense * (last.phi[0] + (start.phi[0] - last.phi[0]) * share)
        spin = np.exp(1j * (between[1] - away))
        tip = np.stack([between[0] * spin.real, between[0] * spin.imag, between[2]])
        mixed = axis[:, None] + ((aim - axis)[:, None] * share if float(axis @ aim) > 0.0 else 0.0 * share)
        mixed = mixed / np.sqrt((mixed**2).sum(axis=0))
        flat = (mixed[0] + 1j * mixed[1]) * np.exp(-1j * away)
        axes = np.stack([flat.real, flat.imag, mixed[2]])
        tip[:, -1], axes[:, -1] = start.tip[:, 0], start.axis[:, 0]
        phi = last.phi[0] + (start.phi[0] - last.phi[0]) * share
        return replace(start.repeated(count), phi=phi, tip=tip, axis=axes)


def _between(values: Floats) -> Floats:
    """Of values (k, 3, n) at SHARES of chords, which vanish at their ends: those at finer shares (k, m, n)."""
    share = np.linspace(SHARES[0], SHARES[-1], FINER)[:, None] - 0.5
    low, middle, high = np.moveaxis(values / np.array([s * (1.0 - s) for s in SHARES])[:, None], 1, 0)[:, :, None]
    slope, bend = 2.0 * (high - low), 8.0 * (low - 2.0 * middle + high)
    return np.asarray((0.25 - share * share) * (middle + share * (slope + share * bend)))


def _largest(path: ToolPath, of: Callable[[Positions], Floats]) -> float:
    """The largest of a value (n,) of the positions of a path."""

    def value(phi: Floats) -> Floats:
        return of(path.at(phi))

    phi, owner = piece_grid(path.knots(), PER_TURN)
    return refined_maximum(value, phi, owner, value(phi))[0]


def _beside(at: Positions, sense: float) -> tuple[Floats, Floats]:
    """Radius, azimuth, height of a tool's end, and its axis, in the frame that the follower stands still in."""
    turn = np.exp(1j * sense * at.phi[0])
    place = (at.tip[0, 0] + 1j * at.tip[1, 0]) * turn
    axis = (at.axis[0, 0] + 1j * at.axis[1, 0]) * turn
    return (
        np.array([abs(place), float(np.angle(place)), float(at.tip[2, 0])]),
        np.array([axis.real, axis.imag, float(at.axis[2, 0])]),
    )


def spaced(chords: Chords, knots: Floats, tolerance: float) -> tuple[Floats, float]:
    """Cam angles of blocks, every knot among them, and the largest chord error measured between them, mm."""
    try:
        phi, error = even_steps(chords.error, list(itertools.pairwise(knots.tolist())), tolerance, MOST_BLOCKS)
    except NotConverged as reason:
        raise NotConverged(f"cutter.tolerance of one pass: {reason}") from None
    worst = float(error.max(initial=0.0))
    if worst > tolerance:
        at = float(np.degrees(phi[int(np.argmax(error))]))
        raise NotConverged(
            f"the tool's path bends too sharply at cam angle {at:.6g} deg: its chord error stays at {worst:.3g} mm, "
            f"above cutter.tolerance {tolerance:g} mm; smooth the motion there, or ask for a coarser tolerance"
        )
    return phi, worst


def divided_knots(knots: Floats) -> Floats:
    """Knots with others between them where a block would turn by more than WIDEST."""
    pieces = [
        np.linspace(low, high, max(1, int(np.ceil((high - low) / WIDEST - 1e-9))) + 1)[:-1]
        for low, high in zip(knots[:-1], knots[1:])
    ]
    return np.concatenate([*pieces, knots[-1:]])


def contact_lengths(path: ToolPath, phi: Floats) -> Floats:
    """How far the contact (of two the one that moves further) moves along the flank between cam angles, (n - 1,), mm.

    Summed over chords of at most FINE, which are short of the arc by a share of FINE² / 24.
    """
    parts = np.maximum(1, np.ceil(np.diff(phi) / FINE)).astype(np.int64)
    chords = np.sqrt((np.diff(path.at(subdivided(phi, parts)).contacts, axis=2) ** 2).sum(axis=1))
    return np.asarray(np.add.reduceat(chords, np.cumsum(parts) - parts, axis=1).max(axis=0))


def seconds(moves: tuple[Move, ...], spec: CutterSpec) -> list[Floats]:
    """Time of every block, s, by moves: on the flank so that the contact moves at spec.feed, but the tool's end no
    faster than spec.fastest; elsewhere at the feed of the tool's end. Rapid moves have no time (zero)."""
    found = []
    before: Positions | None = None
    for move in moves:
        at = move.positions
        tips = at.tip if before is None else np.concatenate([before.tip[:, -1:], at.tip], axis=1)
        way = np.sqrt((np.diff(tips, axis=1) ** 2).sum(axis=0))
        if before is None:
            way = np.concatenate([[0.0], way])
        if move.kind == "rapid":
            found.append(np.zeros(len(at.phi)))
        elif move.kind == "feed":
            found.append(60.0 * way / spec.feed)
        else:
            assert move.lengths is not None
            steps = move.lengths.copy()
            if steps[0] == 0.0:
                # The end of the arc in: the contact is there already.
                steps[0] = way[0]
            found.append(60.0 * np.maximum(steps / spec.feed, way / spec.fastest))
        before = at
    return found
