"""Parallel indexers: figures of many variants at once.

Rollers stay parallel to the cam's axis, so that a roller bears along all of its length or not at all: between the cam
angles at which its wall begins and ends (`plates`). With tau its angle from the line of centres, q = rf (1 + tau') and
v² = C² + q² - 2 C q cos tau the square of its speed in the cam,

    lever = C rf sin tau / v, tan alpha = |C cos tau - q| / (C |sin tau|),
    path curvature = [C (q (1 + tau') cos tau + rf tau'' sin tau + q cos tau) - C² - q² (1 + tau')] / v³.

Arrays are (P, n), P samples of the cam angle and n variants, (B, n) with a row for each roller's stretch of wall, or
(N,) of the rollers that have one beside them at a sample.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, Literal, final

import numpy as np

from camgeom.cams.parallel_index import DIAL_PLAY, ParallelIndex
from camgeom.design.batch.driven import LOAD_FIGURES, LOADED, Driven, chunk_of, refused
from camgeom.design.batch.legs import FINE, program_of
from camgeom.design.batch.motion import Ints, Motion, Points, motion_figures, top_row
from camgeom.design.batch.plates import Ring, Walls, vars_of, walls
from camgeom.design.batch.variants import Batch, Mask, Variants, path_of
from camgeom.errors import DesignError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.hertz import TOO_WIDE, flexibility
from camgeom.mechanics.load import QUIET
from camgeom.motion.program import TURN
from camgeom.track.follower import TurretFollower

if TYPE_CHECKING:
    from camgeom.profile import Profile

CHUNK = 4096
AT_ONCE = 512
"""variants whose samples are computed at once: what they need stays in the cache"""
BESIDE = 1e-8
"""rad on either side of a cam angle at which a roller comes to bear or ceases to"""
SHORTEST, BETWEEN = 2, tuple((np.arange(1.0, 10.0) / 10.0).tolist())
"""stretches of wall that are looked at between their ends, and where"""
TURNS = 3
"""times that flexibilities and loads of rollers are computed in turn"""
DENSE = 33
"""samples of a piece of a law"""
TOPS = 3
"""of the largest samples, apart from each other, about which a largest quantity is looked for"""
STEP = FINE // (DENSE - 1)
"""fine steps between two samples"""
SMOOTH = 1.0
"""fine steps down to which a quantity is looked for that has no bend where it is largest"""
NEARLY = 0.85
"""bend of a wall by the roller's radius, at the samples, from which on it is looked at whether it folds"""
HOLLOW = 1e-3
"""square of a half-width by the roller's radius from which on, at the samples, the largest is looked for"""
KEEN = 0.1
"""the same of one of which little is left of 1 where a wall is nearly undercut"""
PARTS = 4
"""of a step between samples, and then of a part, in which a largest quantity is looked for"""
FINER = 8.0
"""by how much finer than between its samples it is looked for in a short stretch of wall"""
GEOMETRY = (
    "motion.stroke_deg",
    *motion_figures("deg", "rad"),
    "flank.max_pressure_angle_deg",
    "flank.undercut_margin",
    "flank.min_relative_radius_mm",
)


def offered(profile: Profile) -> tuple[str, ...]:
    """Names of the figures that the batch gives."""
    return GEOMETRY + ((*LOADED, "contact.contact_length_mm") if profile.operation is not None else ())


def supports(profile: Profile, varied: Sequence[str]) -> str | None:
    """None where the walls can be told; else why not."""
    cam, program = profile.cam, profile.setup().program
    assert isinstance(cam, ParallelIndex)
    if cam.plates == 3:
        return "plates = 3: in a dwell two rollers of the middle plate sweep one circle, whose walls are both's"
    if any(jump.order <= 1 for jump in program.continuity.jumps):
        return "the motion's velocity jumps, so the rollers leave gaps in the plates' walls"
    return refused(profile, varied)


def kernel(profile: Profile, columns: Mapping[str, Floats], figures: Sequence[str], level: float) -> Batch:
    """The figures of one chunk of variants: all loads are shared as the exact model shares them, at every level."""
    every, motion = chunk_of(profile, columns)
    values = {name: np.zeros(every.size) for name in figures}
    with np.errstate(all="ignore"):
        Plates(every, motion).refuse()
        rows = np.flatnonzero(every.refusals.none)
        if rows.size:
            whole = Plates(every.of(rows), motion.of(rows))
            walls, words = whole.walled()
            sound = np.flatnonzero(np.array(words) == "")
            lost, wide = np.zeros((2, every.size), dtype=bool)
            cams = Plates(whole.variants, whole.motion, walls).of(sound)
            folded = sound[cams.folded] if sound.size else sound
            if folded.size:
                walls = whole.asked(folded, walls, words)
                sound = np.flatnonzero(np.array(words) == "")
                cams = Plates(whole.variants, whole.motion, walls).of(sound)
            if sound.size:
                for name, column in values.items():
                    column[rows[sound]] = cams.figure(name)
                if any(name in LOAD_FIGURES for name in figures):
                    lost[rows[sound]], wide[rows[sound]] = cams.lost, cams.wide
            for word in dict.fromkeys(filter(None, words)):
                bad = np.zeros(every.size, dtype=bool)
                bad[rows] = np.array(words) == word
                every.refusals.add(bad, word)
            every.refusals.add(lost, "no roller can take the turret's torque")
            every.refusals.add(wide, TOO_WIDE)
    return every.refusals.batch(values)


SPIKE = 10.0
"""times the difference of neighbouring samples by which a largest quantity may stand above them"""
SHORT = 0.25
"""the same of neighbours in a short stretch of wall, twice what a parabola has"""
HAIR = 1e-5
"""share of itself by which a largest quantity is not looked for any further"""
Window = tuple[Ints, Floats, Floats, Floats]
Quantity = Callable[["Plates", "Beside", Points], Floats]
"""Something of the rollers of cams beside their plates at points, (P, n)."""


@final
class Plates(Driven):
    """The cams of n variants; numbers are (n,)."""

    def __init__(self, variants: Variants, motion: Motion, walls: tuple[Walls, ...] = ()) -> None:
        self.variants, self.motion, self.profile, self._walls = variants, motion, variants.profile, walls
        cam, follower = self.profile.cam, self.profile.follower
        assert isinstance(cam, ParallelIndex)
        assert isinstance(follower, TurretFollower)
        self.plates, self.count, self.advance = cam.plates, follower.count, program_of(self.profile).advance

        def full(key: str, share: float = 1.0) -> Floats:
            return variants.full(share * variants.number(key))

        self.centre, self.circle = full("cam.center_distance"), full("follower.pitch_radius")
        self.rim = full("cam.diameter", 0.5)
        self.roller = full("roller.diameter", 0.5)
        self.tool = self.roller + variants.number("cam.running_clearance")
        self.length = variants.full(np.minimum(variants.number("cam.width"), variants.number("roller.length")))

    def of(self, rows: Ints) -> Plates:
        """The cams of these variants."""
        found = Plates(self.variants.of(rows), self.motion.of(rows), tuple(one.of(rows) for one in self._walls))
        if "stretches" in vars(self):
            vars(found)["stretches"] = tuple(one.take(rows, axis=1) for one in self.stretches)
        return found

    def refuse(self) -> None:
        """As `ParallelIndex.problems`."""
        refusals, number, cannot = self.variants.refusals, self.variants.number, "cannot be built"
        low = self.centre - self.circle
        refusals.add(low <= 0.0, f"follower.pitch_radius: {cannot}")
        refusals.add((low >= self.rim) | (self.rim >= self.centre), f"cam.diameter: {cannot}")
        self.refuse_bore()
        refusals.add((self.bored > 0.0) & (self.bored >= np.maximum(low - self.tool, 0.0)), f"cam.bore: {cannot}")
        room = 2.0 * self.circle * np.sin(0.5 * TURN * self.plates / self.count)
        refusals.add(room <= 2.0 * self.roller, f"roller.diameter: {cannot}")
        room = number("cam.width") + (1.0 - 2.0 * DIAL_PLAY) * number("cam.gap")
        refusals.add(number("roller.length") >= room, f"roller.length: {cannot}")
        refusals.add(self.tool >= low, f"roller.diameter: {cannot}")

    # Walls

    def _ring(self, plate: int) -> Ring:
        pitch = TURN / self.count
        return Ring(self.motion, (0.5 + plate) * pitch, self.plates * pitch, self.advance,
                    self.centre, self.circle, self.tool, self.rim)  # fmt: skip

    @cached_property
    def _even(self) -> Floats | None:
        """Twice the cam angle, rad, (n,), about which the motion is even: plates from both ends are each other's mirror
        images then; None where it is not."""
        moving = [leg for leg in self.motion.legs if not leg.shape.dwells]
        if len(moving) != 1 or not moving[0].shape.even:
            return None
        return self.variants.full(moving[0].start + moving[0].end)

    def walled(self) -> tuple[tuple[Walls, ...], list[str]]:
        """Of every plate, and why a variant has none, (n,) words."""
        words = [""] * self.motion.size
        found = [walls(self._ring(plate)) for plate in range(self.plates // (1 if self._even is None else 2))]
        if self._even is not None:
            found += [one.mirrored(self._even, self.advance) for one in found[::-1]]
        return self.asked(np.flatnonzero(np.any([one.open for one in found], axis=0)), tuple(found), words), words

    def asked(self, rows: Ints, found: tuple[Walls, ...], words: list[str]) -> tuple[Walls, ...]:
        """The walls with those of some variants as the exact model finds them; a word goes to one that has none."""
        for row in rows.tolist():
            try:
                exact = self._exact(row)
            except DesignError as error:
                words[row] = str(error).partition(":")[0]
            else:
                found = tuple(one.with_rows(np.array([row]), other) for one, other in zip(found, exact, strict=True))
        return found

    @property
    def folded(self) -> Mask:
        """Whether a wall goes on beyond where its band folds, (n,): its band crosses itself before, unseen."""
        most = self.tool * self.at_samples(_bend).max(axis=0)
        rows = np.flatnonzero(most > NEARLY)
        if rows.size:
            part = self.of(rows)
            most[rows] = part.tool * part.bend
        return np.asarray(most >= 1.0)

    def _exact(self, row: int) -> tuple[Walls, ...]:
        """The walls of one variant as the exact model finds them. Raises DesignError where it finds none."""
        profile = self.profile
        for key in self.variants.columns:
            profile = _with(profile, path_of(key), float(self.variants.number(key)[row]))
        mechanism = profile.cam.mechanism(profile.setup())
        found = []
        for plate in range(self.plates):
            name = f"plate {plate + 1}"
            tracks = [one for one in mechanism.cutters if one.name.startswith(name)]
            each = np.array([(one.shift, mechanism.sense * one.sides[0], *one.span) for one in tracks])
            found.append(Walls(each.T[:, :, None], np.zeros(1, dtype=bool)))
        return tuple(found)

    @cached_property
    def stretches(self) -> tuple[Floats, Floats, Floats, Floats]:
        """Of every roller beside its plate in one turn: the angle from the line of centres at zero lift, rad, its
        wall's side, and the cam angles between which it has one, rad, (B, n) each."""
        shift, side, low, high = np.concatenate([one.each for one in self._walls], axis=1)
        there = high > low
        first = int(np.floor(np.where(there, low, np.inf).min() / TURN))
        last = int(np.floor(np.where(there, high, -np.inf).max() / TURN))
        each = []
        for turn in range(first, last + 1):
            begin, end = np.maximum(low - TURN * turn, 0.0), np.minimum(high - TURN * turn, TURN)
            each.append((shift + self.advance * turn, side, np.where(there, begin, 1.0), np.where(there, end, 0.0)))
        every = np.concatenate(each, axis=1)
        empty = every[3] <= every[2]
        order = np.argsort(empty, axis=0, kind="stable")[: int((~empty).sum(axis=0).max())]
        offset, side, begin, end = (np.take_along_axis(one, order, axis=0) for one in every)
        return offset, side, begin, end

    # Rollers beside their plates

    def beside(self, points: Points, kind: type[np.floating] = np.float64) -> Beside:
        """The rollers that have a wall at points (P, n), in a precision: where one comes and goes, and on which side of
        the line of centres it is, is as sure in the single one."""
        offset, side, begin, end = self.stretches
        size, shape = self.motion.size, np.broadcast_shapes(points.s.shape, (1, self.motion.size))
        on = (points.theta >= begin[:, None]) & (points.theta <= end[:, None])
        flat = np.flatnonzero(on)
        row, place = np.divmod(flat, shape[0] * size)
        variant = place % size
        which = row * size + variant

        def taken(values: Floats) -> Floats:
            return np.asarray(np.broadcast_to(values, shape).reshape(-1).take(place))

        tau = (taken(points.s) + offset.take(which)).astype(kind, copy=False)
        cos, sin = np.cos(tau), np.sin(tau)
        centre, circle, way = (one.astype(kind, copy=False).take(rows)
                               for one, rows in ((self.centre, variant), (self.circle, variant), (side, which)))
        rate, dds = (taken(one.astype(kind, copy=False)) for one in (1.0 + points.ds, points.dds))
        quick = circle * rate
        across, along = quick * sin, centre - quick * cos
        square = along * along + across * across
        pace = np.sqrt(square)
        lever = way * centre * circle * sin / pace
        bend = centre * (quick * (1.0 + rate) * cos + circle * dds * sin - centre) - quick * quick * rate
        tangent = np.abs(centre * cos - quick) / (centre * np.abs(sin))
        return Beside(on.shape, flat, place, variant, lever, way * bend / (square * pace), tangent)

    @cached_property
    def _shortest(self) -> tuple[Ints, Floats, Floats]:
        """The shortest stretches of wall, by their rows, and cam angles between which they are, rad, (SHORTEST, n)."""
        *_, begin, end = self.stretches
        order = np.argsort(np.where(end > begin, end - begin, np.inf), axis=0)[:SHORTEST]
        low, high = (np.take_along_axis(one, order, axis=0) for one in (begin, end))
        return order, low, high

    @cached_property
    def points(self) -> Points:
        """The samples of the motion, both sides of where a roller passes the line of centres, from where on its wall
        pushes the other way, and of where it comes to bear or ceases to, and places in between of the shortest
        stretches, which the samples may miss, (P, n)."""
        offset, _, begin, end = self.stretches
        there, passed = end > begin, self.motion.reached(-offset).theta
        events = (np.where(there, one, 0.5 * TURN) for one in (passed, begin, end))
        beside = [one + way for one in events for way in (-BESIDE, BESIDE)]
        _, low, high = self._shortest
        between = [low + share * (high - low) for share in BETWEEN]
        points = self.motion.whenever(np.clip(np.concatenate(beside + between), 0.0, TURN * (1.0 - 1e-15)))
        return _joined(self.motion.sampled(DENSE), points, self.motion.size)

    def _windows(self, values: Floats) -> Window:
        """About the largest values (P, n) at the samples that are no less than those beside: piece, fine step and
        reach, 0 where there is no such sample, (k, n), and the three values, (3, k, n), so far from each other."""
        whole, one = self.motion.moving * DENSE, np.arange(self.motion.size)
        moving = values[:whole]
        each = moving.reshape(-1, DENSE, self.motion.size)
        left = moving.copy()
        less, low = each[:, 1:] < each[:, :-1], left.reshape(each.shape)
        low[:, 1:][less] = -np.inf
        low[:, :-1][each[:, :-1] < each[:, 1:]] = -np.inf
        tops, there = list[Ints](), list[Mask]()
        for _ in range(TOPS):
            tops.append(left.argmax(axis=0))
            there.append(np.isfinite(left[tops[-1], one]))
            for beside in range(-2, 3):
                left[np.clip(tops[-1] + beside, 0, whole - 1), one] = -np.inf
        piece, sample = np.divmod(np.array(tops), DENSE)
        middle = np.clip(sample, 1, DENSE - 2)
        three = np.stack([moving[piece * DENSE + middle + k, one] for k in (-1, 0, 1)])
        return piece, middle * float(STEP), np.where(there, float(STEP), 0.0), three

    def _short_windows(self, values: Floats) -> Window:
        """The same in the shortest stretches; no reach where there is none or its largest value is at an end of it,
        where it is known."""
        order, low, high = self._shortest
        count, each = len(self.stretches[0]), len(BETWEEN)
        events = values[len(values) - 4 * count - each * len(order) :]
        # Beside its begin, at places between, beside its end.
        first, last = (np.take_along_axis(events[k * count : (k + 1) * count], order, axis=0) for k in (1, 2))
        grid = np.stack([first, *events[4 * count :].reshape(each, *order.shape), last])
        top = grid.argmax(axis=0)
        inside = (top > 0) & (top <= each) & (high > low)
        top = np.clip(top, 1, each)
        long = np.where(inside, high - low, 0.0) / (each + 1)
        piece, step = self.motion.placed(np.where(inside, low + top * long, 0.0))
        widths = np.broadcast_to(self.motion.widths, (len(self.motion.rows), self.motion.size))
        three = np.stack([np.take_along_axis(grid, (top + k)[None], axis=0)[0] for k in (-1, 0, 1)])
        return piece, step, FINE * long / widths[piece, np.arange(self.motion.size)], three

    @cached_property
    def sampled(self) -> Beside:
        """The rollers at these, in single precision: they show where a quantity is largest."""
        return self.beside(self.points, np.float32)

    @cached_property
    def blocks(self) -> tuple[Plates, ...]:
        """The same a few variants at a time."""
        size, _ = self.motion.size, self.stretches
        return tuple(self.of(np.arange(k, min(k + AT_ONCE, size))) for k in range(0, size, AT_ONCE))

    def at_samples(self, what: Quantity) -> Floats:
        """A quantity at the samples, (P, n), in single precision."""
        return np.concatenate([what(part, part.sampled, part.points) for part in self.blocks], axis=1)

    def at_one(self, what: Quantity, sample: Ints) -> Floats:
        """A quantity at a sample of every variant, (n,)."""
        rows = np.split(sample[None], np.arange(AT_ONCE, len(sample), AT_ONCE), axis=1)
        every = zip(*([np.take_along_axis(one, own, axis=0) for one in vars_of(part.points)]
                      for part, own in zip(self.blocks, rows, strict=True)))  # fmt: skip
        points = Points(*(np.concatenate(one, axis=1) for one in every))
        return np.asarray(what(self, self.beside(points), points)[0])

    def largest(
        self, what: Quantity, values: Floats | None = None, finest: float = 1.0, poles: bool = False,
        short: bool = False,
    ) -> Floats:  # fmt: skip
        """Largest of a quantity (P, n) of the rollers beside their plates over the turn, (n,).

        Where rollers come and go it may jump or be bent: it is looked for ever finer about the best samples, as long as
        more may lie beside them than the largest found: as far above as they differ from their neighbours.

        values  of the samples, where they are known
        finest  of a piece's fine steps
        poles   whether it may have some between samples, of which neighbours tell nothing
        short   whether it is looked for in short stretches of wall too, in which a lever may change its sign
        """
        values = self.at_samples(what) if values is None else values
        best = self.at_one(what, values.argmax(axis=0))
        windows = [self._windows(values), *((self._short_windows(values),) if short else ())]
        piece, step, reach, three = (np.concatenate(some, axis=-2) for some in zip(*windows))
        fine = np.minimum(finest, reach / FINER)
        times = np.repeat([SPIKE, SHORT], [TOPS, len(reach) - TOPS])[:, None]
        top, variant = np.nonzero((poles | _more(three, best, times)) & (reach > fine))
        piece, step, reach, fine = piece[top, variant], step[top, variant], reach[top, variant], fine[top, variant]
        three, cams, inner = three[:, top, variant], self.of(variant), [k for k in range(-PARTS + 1, PARTS) if k]
        while variant.size:
            reach = reach / PARTS
            steps = np.clip(step + reach * np.array(inner)[:, None], 0.0, FINE)
            points = cams.motion.at(np.broadcast_to(piece, steps.shape), steps)
            found = what(cams, cams.beside(points), points)
            np.maximum.at(best, variant, found.max(axis=0))
            # Three of the places were looked at before.
            found = np.stack([three[0], *found[: PARTS - 1], three[1], *found[PARTS - 1 :], three[2]])
            top, each = np.clip(top_row(found), 1, 2 * PARTS - 1), np.arange(len(variant))
            step = np.clip(step + reach * (top - PARTS), 0.0, FINE)
            three = np.stack([found[top + k, each] for k in (-1, 0, 1)])
            rows = np.flatnonzero((poles | _more(three, best[variant])) & (reach > fine))
            if len(rows) < len(variant):
                piece, step, reach, fine = piece[rows], step[rows], reach[rows], fine[rows]
                variant, three, cams = variant[rows], three[:, rows], cams.of(rows)
        return np.asarray(best)

    @cached_property
    def angle(self) -> Floats:
        """Largest pressure angle, deg, at which the best placed roller has to drive or to hold; 90 where none can."""

        def worst(_: Plates, beside: Beside, points: Points) -> Floats:
            ways = (np.where(forth, beside.tangent, np.inf) for forth in (beside.lever < 0.0, beside.lever >= 0.0))
            return np.asarray(np.maximum(*(beside.rows(one, np.inf).min(axis=0) for one in ways)))

        return np.degrees(np.arctan(self.largest(worst)))

    @cached_property
    def bend(self) -> Floats:
        """Largest curvature of the pitch curves, 1/mm, convex positive."""
        return self.largest(_bend, finest=KEEN)

    # Load

    def _pressed(self, beside: Beside, points: Points) -> tuple[Floats, Floats, Floats, Floats]:
        """Squares of the largest pressure, MPa², the largest force, N, and the square of the largest half-width by the
        roller's radius, and the size of the torque where no roller bears, N mm, else 0, (P, n) each."""
        kind = beside.lever.dtype
        torque = np.broadcast_to(self.torque(points), beside.shape[1:]).reshape(-1).astype(kind, copy=False)
        bears = np.flatnonzero((beside.lever < 0.0) == (torque >= 0.0)[beside.place])
        place, variant, lever = beside.place[bears], beside.variant[bears], np.abs(beside.lever[bears])
        radius, length = (one.astype(kind, copy=False).take(variant) for one in (self.roller, self.length))
        rest = radius * (1.0 - radius * beside.bend[bears])
        k, pair = 1.0 / np.where(rest > 0.0, rest, radius), self._each(self.pair, variant, kind)
        size = np.abs(torque)

        count = np.bincount(place, minlength=len(size))
        several = np.flatnonzero(count.take(place) > 1)

        def shared(stiff: Floats, rows: Ints | slice) -> Floats:
            """Load per length, N/mm, of some contacts so stiff to the turret's turn by their levers, no other of which
            bears beside them."""
            where = place[rows]
            total = np.bincount(where, stiff * (lever * length)[rows], len(size)).astype(kind, copy=False)[where]
            return np.asarray(stiff * np.divide(size[where], total, out=np.zeros_like(total), where=total > 0.0))

        # The exact model begins with loads that are alike.
        load, most = shared(lever, slice(None)), shared(np.ones_like(lever), slice(None))
        poisson = self._each(self.variants.number("material.cam.poisson"), variant, kind)
        roller, cam = (self._each(one, variant, kind) for one in self.compliances)
        still, more = (np.broadcast_to(flexibility(far, far, roller, cam, poisson), load.shape)[several].astype(kind)
                       for far in (np.zeros(1, kind), np.ones(1, kind)))  # fmt: skip
        high, far = np.log(4.0 * radius[several]), np.broadcast_to(4.0 * pair / (pi * k), load.shape)[several]
        for _ in range(TURNS if several.size else 0):
            reach = high - 0.5 * np.log(far * np.maximum(load[several], 1e-30))
            load[several] = shared(lever[several] / (still + (more - still) * reach), several)
        wide = 4.0 * np.maximum(load, most) * pair / (pi * k * radius * radius)
        each = load * k / (pi * pair), load * length, wide
        idle = np.where(count == 0, size, 0.0)
        square, force, wide = (beside.largest(bears, several, one) for one in each)
        return square, force, wide, idle.reshape(beside.shape[1:])

    def _each(self, values: Floats, variant: Ints, kind: np.dtype[np.floating]) -> Floats:
        """A number of every one of these variants, in a precision."""
        values = values.astype(kind, copy=False)
        return values if len(values) == 1 else values.take(variant)

    @cached_property
    def _sampled_load(self) -> tuple[Floats, Floats, Floats, Floats]:
        every = [part._pressed(part.sampled, part.points) for part in self.blocks]
        square, force, wide, idle = (np.concatenate(one, axis=1) for one in zip(*every))
        return square, force, wide, idle

    @property
    def lost(self) -> Mask:
        """Whether no roller bears somewhere."""
        return np.asarray((self._sampled_load[3] > QUIET * self.most_torque).any(axis=0))

    @property
    def wide(self) -> Mask:
        """Whether a contact is wider than its roller somewhere, where the walls are hollow and all but as round."""
        most = self._sampled_load[2].max(axis=0)
        rows = np.flatnonzero(most > HOLLOW)
        if rows.size:
            most[rows] = self.of(rows)._most(2)
        return np.asarray(most > 1.0)

    def _most(self, which: Literal[0, 1, 2]) -> Floats:
        """Largest of the squares of the pressure, of the force on a roller, or of the squares of half-widths."""
        return self.largest(lambda cams, beside, points: cams._pressed(beside, points)[which],
                            self._sampled_load[which], SMOOTH, which == 2, short=True)  # fmt: skip

    @cached_property
    def square(self) -> Floats:
        """Square of the largest pressure, MPa²."""
        return self._most(0)

    @property
    def middle(self) -> Floats:
        """The same: slices are alike, since the rollers stay parallel to the cam's axis."""
        return self.square

    @cached_property
    def force(self) -> Floats:
        """Largest force on a roller, N."""
        return self._most(1)

    def figure(self, name: str) -> Floats:
        """A figure by its name in a study, (n,) or (1,)."""
        if name.startswith("motion."):
            return self.motion_figure(name)
        return LOAD_FIGURES[name](self) if name in LOAD_FIGURES else FIGURES[name](self)


@final
@immutable
class Beside:
    """Rollers that have a wall at points: numbers of (B, P, n) and of (P, n), their variants, lever (negative: it can
    push on), mm, curvature of the pitch curve, 1/mm, convex positive, and tan of the pressure angle, (N,) each."""

    shape: tuple[int, ...]
    flat: Ints
    place: Ints
    variant: Ints
    lever: Floats
    bend: Floats
    tangent: Floats

    def rows(self, values: Floats, empty: float) -> Floats:
        """Values (N,) as (B, P, n)."""
        found = np.full(self.shape, empty, dtype=values.dtype)
        found.reshape(-1)[self.flat] = values
        return found

    def largest(self, rows: Ints, several: Ints, values: Floats) -> Floats:
        """The largest of values of some of them at points, (P, n), 0 where there is none; `several`: of those that are
        not alone at a point."""
        _, points, size = self.shape
        found, place = np.zeros(points * size, dtype=values.dtype), self.place[rows]
        found[place] = values
        np.maximum.at(found, place[several], values[several])
        return found.reshape(points, size)


def _bend(_: Plates, beside: Beside, __: Points) -> Floats:
    """The largest curvature of the pitch curves of all rollers at points."""
    return np.asarray(beside.rows(beside.bend, -np.inf).max(axis=0))


def _more(three: Floats, best: Floats, times: Floats | float = 1.0) -> Mask:
    """Whether beside the middle of three values (3, ...) there may be more than the largest found: as many times above
    as they differ."""
    most = three.max(axis=0)
    return np.asarray(most + times * (most - three.min(axis=0)) > best + HAIR * np.abs(best))


def _joined(one: Points, two: Points, size: int) -> Points:
    """Points of both, (P, n)."""
    return Points(*(
        np.concatenate([np.broadcast_to(part, (len(whole.s), size)) for part, whole in zip(parts, (one, two))])
        for parts in zip(vars_of(one), vars_of(two))
    ))  # fmt: skip


def _with(section: object, path: Sequence[str | int], value: float) -> Profile:
    """A section of a profile with a number of it replaced, which is known to be allowed."""
    first, *more = path
    if isinstance(first, int):
        assert isinstance(section, tuple)
        return (*section[:first], _with(section[first], more, value), *section[first + 1 :])  # type: ignore[return-value]
    fields = dict(section)  # type: ignore[call-overload]
    fields[first] = _with(fields[first], more, value) if more else value
    return type(section).model_construct(**fields)  # type: ignore[attr-defined, no-any-return]


FIGURES: dict[str, Callable[[Plates], Floats]] = {
    "flank.max_pressure_angle_deg": lambda i: i.angle,
    "flank.undercut_margin": lambda i: 1.0 - i.tool * i.bend,
    "flank.min_relative_radius_mm": lambda i: np.maximum(i.roller * (1.0 - i.roller * i.bend), 0.0),
    "contact.contact_length_mm": lambda i: i.length,
}
