"""Where a follower stands between its walls: rigid bounds, and the balance of what is pressed.

A station whose nominal gap and errors leave the approach a (mm, negative: free) presses with k [a + L psi]+ when the
follower stands psi beyond its program. Walls that push bound psi from below, walls that hold from above,

    low = max a / |L| over what pushes,      high = min -a / |L| over what holds:

errors are added at every station before the extreme is taken, since lines that tilt touch at one of their ends. Where
low <= high the follower is free in between. ALONE: it stands at low. OPPOSED: at the bound that the load presses.
SHARED, or pressed from both sides: psi balances sum(-L k [a + L psi]+) = load.

Arrays: (..., n, q), q stations of all lines; the last two axes are those of `Walls`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.mechanics.hertz import line_flexibility, line_pressure
from camgeom.mechanics.load import QUIET
from camgeom.mechanics.material import Material, pair_compliance
from camgeom.solid.mechanism import Drive
from camgeom.tolerance.contacts import Contacts

Reals = Floats | npt.NDArray[np.float32]
Bools = npt.NDArray[np.bool_]
STEPS = 60
SAME = 1e-9
"""share of the largest bound to which a balance is found, of single precision what that holds"""
SHORTER = 0.8
"""of the last Newton step, at most"""
FEWER = 0.7
"""share of the rows, or less, that a balance goes on with alone once the others are found"""
SMALL = 8192
"""approaches of which going on with all rows costs less than parting those that are found"""
SCALE = 0.005
"""mm, of approach, at which a line contact's stiffness is taken that no load and no preload sets: it falls with the
load by a logarithm alone, and drops out where nothing but errors presses"""
LEAST = 0.1
"""share of the largest line load at which a contact that bears less, or not yet, is taken"""
TOGETHER = 65_536
"""approaches that stand at once: their arrays stay in a core's cache, and memory is not given back between the steps of
numpy, to be asked for page by page again (measured: half the time of eight times as many)"""
HAIR = 1e-9
"""mm of growth of all walls"""
SOFTEN = 6
"""rounds in which stiffness and load find each other"""


@final
@immutable
class Stand:
    """Where the follower stands, low .. high, in its coordinate (mm, rad) beyond the program, (..., n).

    Equal where it is pressed. play: high - low of the rigid bounds, below zero where it is pressed from both sides.
    """

    low: Floats
    high: Floats
    play: Floats


@final
@immutable
class Walls:
    """The stations of all lines of contact, flattened, and the load on the follower.

    approach  nominal, mm, (n, q), -inf where there is no wall; lever (n, q), signed as in `Contacts`
    stiffness of a station, N/mm, (n, q), 0 where there is no wall
    load      N or N mm, (n,), that the walls have to give: positive presses those that push; 0 leaves it to them
    known     where the loaded follower stands without errors, (n,), NaN without a load; None: not known yet
    """

    drive: Drive
    approach: Floats
    lever: Floats
    stiffness: Floats
    load: Floats
    known: Floats | None = None

    def rows(self, rows: npt.NDArray[np.intp]) -> Walls:
        """The walls at some of the cam angles; what is told by the largest load is told by that of these."""
        return replace(self, approach=self.approach[rows], lever=self.lever[rows], stiffness=self.stiffness[rows],
                       load=self.load[rows], known=self._start[rows])  # fmt: skip

    @cached_property
    def pushes(self) -> Bools:
        """Which stations push, (n, q)."""
        return np.isfinite(self.approach) & (self.lever < 0.0)

    @cached_property
    def holds(self) -> Bools:
        """Which stations hold, (n, q)."""
        return np.isfinite(self.approach) & (self.lever > 0.0)

    @cached_property
    def _nominal(self) -> Floats:
        """The nominal approach, mm, (n, q), 0 where there is no wall."""
        return np.where(np.isfinite(self.approach), self.approach, 0.0)

    @cached_property
    def _sides(self) -> tuple[tuple[Floats, Floats], tuple[Floats, Floats]]:
        """1 / |L| and nominal approach over |L|, (n, q), of what pushes and of what holds; 0 and -inf elsewhere."""
        size = 1.0 / np.abs(self.lever)
        push, hold = (
            (np.where(on, size, 0.0), np.where(on, self._nominal * size, -np.inf)) for on in (self.pushes, self.holds)
        )
        return push, hold

    @cached_property
    def half_levers(self) -> tuple[Floats, Floats]:
        """Normal approach of either of two opposed walls, mm, per unit of play, (n,): of a play below zero, and above.

        Of the walls that are nearest nominally; of those alike near, the ones that meet first where all walls grow,
        whose lever is the least, and where all shrink.
        """
        tight, loose = (
            [
                np.take_along_axis(np.abs(self.lever), np.argmax(nominal + hair * size, axis=1)[:, None], 1)[:, 0]
                for size, nominal in self._sides
            ]
            for hair in (HAIR, -HAIR)
        )
        pressed, free = (1.0 / (1.0 / first + 1.0 / second) for first, second in (tight, loose))
        return pressed, free

    def normal(self, play: Floats) -> Floats:
        """Normal interference, mm, (..., n), of a play below zero, mm or rad, (..., n); above it minus half the gap."""
        tight, loose = self.half_levers
        return np.asarray(-play * np.where(play < 0.0, tight, loose))

    def bounds(self, errors: Floats) -> tuple[Floats, Floats]:
        """Rigid bounds (..., n) under approaches (..., n, q), mm, beyond the nominal ones."""
        low, far = (_reach(errors, size, nominal) for size, nominal in self._sides)
        return low, -far

    def play(self, errors: Floats) -> Floats:
        """Play between the rigid bounds, (..., n), under approaches (..., n, q), mm, beyond the nominal ones."""
        low, high = self.bounds(errors)
        return high - low

    @cached_property
    def nearest(self) -> tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]:
        """The stations that push and that hold first, nominally, (n,) each."""
        push, hold = (np.argmax(nominal, axis=1) for _, nominal in self._sides)
        return push, hold

    @cached_property
    def _apart(self) -> tuple[tuple[npt.NDArray[np.intp], Floats, Floats], ...]:
        """The stations that push, and those that hold: numbers, as many as any angle has, and their sides, (n, a)."""
        found = []
        for on, (size, near) in zip((self.pushes, self.holds), self._sides):
            order = np.argsort(~on, axis=1, kind="stable")[:, : max(1, int(on.sum(axis=1).max(initial=0)))]
            found.append((order, np.take_along_axis(size, order, axis=1), np.take_along_axis(near, order, axis=1)))
        return tuple(found)

    def parted(self, mean: Floats, errors: Iterable[tuple[Floats, npt.NDArray[np.intp] | None]]) -> Floats:
        """A play, (n,), that no errors within their sizes go beyond.

        mean    approaches (n, q) that all machines have; errors: each one's parts at its size, (parts, n, q), of any
                direction, and whose they are, (n, q), where each roller or wall has its own
        The play is the least of all pairs of a station that pushes and one that holds; each pair has its own errors
        here, each at the end that parts it most (weak duality: the largest least is at most the least largest).
        """
        (pushing, push, near), (holding, hold, far) = self._apart
        first, second = (np.take_along_axis(mean, order, axis=1) for order in (pushing, holding))
        gap = -(near + first * push)[:, :, None] - (far + second * hold)[:, None, :]
        for parts, owner in errors:
            one, other = (np.take_along_axis(parts, order[None], axis=2) * size
                          for order, size in ((pushing, push), (holding, hold)))  # fmt: skip
            both = np.zeros_like(gap)
            for mine, yours in zip(one, other):
                apart = mine[:, :, None] + yours[:, None, :]
                apart *= apart
                both += apart
            np.sqrt(both, out=both)
            if owner is not None:
                each = np.sqrt((one * one).sum(axis=0))[:, :, None] + np.sqrt((other * other).sum(axis=0))[:, None, :]
                whose, other_s = (np.take_along_axis(owner, order, axis=1) for order in (pushing, holding))
                both = np.where(whose[:, :, None] == other_s[:, None, :], both, each)
            gap += both
        return np.asarray(gap.min(axis=(1, 2)))

    def swung(self, parts: Floats, turn: Floats) -> Floats:
        """Play between the rigid bounds, (n, w), under an error of parts (2, n, q), mm, in directions (n, w), rad."""
        ways, play = np.stack([np.cos(turn), np.sin(turn)], axis=1), np.zeros(turn.shape)
        for order, size, near in self._apart:
            both = np.stack([np.take_along_axis(part, order, axis=1) * size for part in parts], axis=2) @ ways
            both += near[:, :, None]
            play -= both.max(axis=1)
        return play

    def stand(self, errors: Floats) -> Stand:
        """Where the follower stands under approaches (..., n, q), mm, beyond the nominal ones."""
        if errors.ndim < 3 or errors.size <= TOGETHER:
            return self._stand(errors)
        few = max(1, TOGETHER // errors[0].size)
        each = [self._stand(errors[i : i + few]) for i in range(0, len(errors), few)]
        return Stand(*(np.concatenate(v) for v in zip(*((one.low, one.high, one.play) for one in each))))

    def _stand(self, errors: Floats) -> Stand:
        low, high = self.bounds(errors)
        play = high - low
        if self.drive is Drive.ALONE:
            return Stand(low, low, play)
        side = np.broadcast_to(self.load_side, low.shape)
        if self.drive is Drive.OPPOSED:
            lean = np.where(side > 0.0, low, np.where(side < 0.0, high, np.nan))
            pressed = (side == 0.0) & (play < 0.0)
        else:
            lean = np.full(low.shape, np.nan)
            pressed = (side != 0.0) | (play < 0.0)
        if pressed.any():
            lean[pressed] = self._balanced(errors, pressed, low, high)
        free = np.isnan(lean)
        return Stand(np.where(free, low, lean), np.where(free, high, lean), play)

    @cached_property
    def load_side(self) -> Floats:
        """1 where the load presses what pushes, -1 what holds, 0 where it is none, (n,)."""
        floor = QUIET * np.abs(self.load).max(initial=0.0)
        return np.where(np.abs(self.load) > floor, np.sign(self.load), 0.0)

    @cached_property
    def _start(self) -> Floats:
        """Where the loaded follower stands without errors, (n,), near which it stands with them; NaN without a load."""
        if self.known is not None:
            return self.known
        rows = np.flatnonzero(self.load_side)
        low, high = (bound[rows] for bound in self.bounds(np.zeros(self.lever.shape)))
        near, lever, stiffness = (v.take(rows, axis=1) for v in self._stations)
        found = np.full(len(self.load), np.nan)
        found[rows] = balance(near, lever, stiffness, self.load[rows], *bracket(low, high, self._room[rows]))
        return found

    @cached_property
    def _yield(self) -> Floats:
        """How far approaches move that follower as long as the same stations press, 1 or rad/mm, (n, q)."""
        pressed = np.nan_to_num(self._start)[:, None] * self.lever + self._nominal
        pull = np.where(pressed > 0.0, self.lever * self.stiffness, 0.0)
        slope = (pull * self.lever).sum(axis=1, keepdims=True)
        return np.asarray(-pull / np.where(slope > 0.0, slope, 1.0))

    @cached_property
    def _stations(self) -> tuple[Floats, Floats, Floats]:
        """Nominal approach, lever and stiffness, (q, n): sums over stations then run along the rows."""
        near, lever, stiffness = (np.ascontiguousarray(v.T) for v in (self._nominal, self.lever, self.stiffness))
        return near, lever, stiffness

    @cached_property
    def _room(self) -> Floats:
        """How far beyond its bounds the load may carry the follower, (n,)."""
        _, lever, stiffness = self._stations
        return room(lever, stiffness, self.load)

    def _balanced(self, errors: Floats, rows: Bools, low: Floats, high: Floats) -> Floats:
        """psi of the rows (..., n) that are pressed, (r,)."""
        at = np.nonzero(rows)[-1]
        near, lever, stiffness = (v.take(at, axis=1) for v in self._stations)
        near += np.broadcast_to(errors, (*rows.shape, errors.shape[-1]))[rows].T
        start = None
        if np.any(self.load):
            start = self._start[at] + np.einsum("...nq,nq->...n", errors, self._yield)[rows]
        below, above = bracket(low[rows], high[rows], self._room[at])
        return balance(near, lever, stiffness, self.load[at], below, above, start)

    def forces(self, errors: Floats, stand: Stand | None = None) -> Floats:
        """Force of every station, N, (..., n, q), of a loaded follower; none where nothing presses.

        stand: where it stands under these errors, if that is known
        """
        if stand is not None and self.drive is Drive.SHARED:
            rows, psi = (self.load_side != 0.0) | (stand.play < 0.0), stand.low
        else:
            low, high = self.bounds(errors)
            rows, psi = (self.load_side != 0.0) | (low > high), np.zeros(low.shape)
            if rows.any():
                psi[rows] = self._balanced(errors, np.broadcast_to(rows, low.shape), low, high)
        force = self.lever * np.where(rows, psi, 0.0)[..., None]
        force += self._nominal
        force += errors
        np.maximum(force, 0.0, out=force)
        force *= self.stiffness
        force *= rows[..., None]
        return np.asarray(force)


def balance(
    approach: Reals, lever: Reals, stiffness: Reals, load: Floats, below: Reals, above: Reals,
    start: Floats | None = None,
) -> Floats:  # fmt: skip
    """psi (r,) at which stations (q, r) press as hard as loads (r,) ask: sum(-L k [a + L psi]+) = load.

    below, above  where it is, (r,), see `bracket`; start: where it is looked for first, NaN: between. The sum falls
    with psi in straight pieces: Newton steps, kept in a bracket, end where they stay on one; one about as long as the
    last, from end to end between two walls that press alike, gives way to the bracket's middle.
    """
    pull = lever * stiffness
    hard = pull * lever
    psi: Floats = np.asarray(0.5 * (below + above), dtype=np.float64)
    if start is not None:
        psi = np.where(np.isnan(start), psi, np.clip(start, below, above))
    kind = approach.dtype
    scale = max(SAME, 8.0 * float(np.finfo(kind).eps)) * np.maximum(np.abs(below), np.abs(above))
    found, rows, last = psi, np.arange(len(psi)), np.full(len(psi), np.inf)
    pressed, on = np.empty_like(approach), np.empty_like(approach)
    for _ in range(STEPS):
        np.multiply(lever, psi.astype(kind), out=pressed)
        pressed += approach
        np.greater(pressed, 0.0, out=on)
        np.maximum(pressed, 0.0, out=pressed)
        rest = -_summed(pull, pressed) - load
        slope = _summed(hard, on)
        below, above = np.where(rest >= 0.0, psi, below), np.where(rest <= 0.0, psi, above)
        fresh = psi + rest / np.where(slope > 0.0, slope, 1.0)
        shorter = np.abs(fresh - psi) <= np.maximum(SHORTER * last, scale)
        fresh = np.where((slope > 0.0) & (fresh >= below) & (fresh <= above) & shorter, fresh, 0.5 * (below + above))
        last = np.abs(fresh - psi)
        left = last > scale
        psi, more = fresh, int(np.count_nonzero(left))
        if not more:
            found[rows] = psi
            return found
        if more <= FEWER * len(rows) and approach.size > SMALL:
            found[rows] = psi
            rows = rows[left]
            psi, below, above, scale, last = psi[left], below[left], above[left], scale[left], last[left]
            approach, lever, pull, hard, load = (_kept(left, v) for v in (approach, lever, pull, hard, load))
            pressed, on = np.empty_like(approach), np.empty_like(approach)
    raise NotConverged(f"where {len(rows)} of {len(found)} followers stand between their walls was not found")


def _kept(rows: Bools, values: Reals) -> Any:
    """Those rows of values (..., r), in the order of memory they have; of values (..., 1) that all rows share, all."""
    return values if values.shape[-1] == 1 else np.compress(rows, values, axis=-1)


def _summed(weight: Reals, values: Reals) -> Reals:
    """Sum over the stations (q, r) with weights (q, r), or (q, 1) that all rows share."""
    return weight[:, 0] @ values if weight.shape[1] == 1 else np.asarray(np.einsum("qr,qr->r", weight, values))


def _reach(errors: Floats, size: Floats, nominal: Floats) -> Floats:
    """Largest of errors (..., n, q) times size and beyond nominal (n, q), (..., n), without a copy more than it needs.
    """
    near = errors * size
    near += nominal
    return np.asarray(near.max(axis=-1))


def bracket(low: Reals, high: Reals, beyond: Floats) -> tuple[Floats, Floats]:
    """Between what the balance of rigid bounds low, high (r,) lies, that a load carries so far beyond them, (r,)."""
    if not np.all(np.isfinite(beyond)):
        raise NotConverged("no wall can give the follower's load at some cam angle")
    ends = np.where(np.isfinite(low), low, high), np.where(np.isfinite(high), high, low)
    least, most = (np.asarray(f(*ends), dtype=np.float64) for f in (np.minimum, np.maximum))
    return least - beyond, most + beyond


def room(lever: Reals, stiffness: Reals, load: Floats) -> Floats:
    """How far beyond its bounds a load (r,) may carry the follower, (r,): the softest of stations (q, r) that can bear
    it alone; infinite where none can."""
    along, hard = np.where(load > 0.0, -lever, lever) > 0.0, stiffness * lever * lever
    least = np.min(np.where(along & (hard > 0.0), hard, np.inf), axis=0)
    bearing = np.where(np.isfinite(least), least, 0.0)
    found = np.divide(np.abs(load), bearing, out=np.where(load == 0.0, 0.0, np.inf), where=bearing > 0.0)
    return np.asarray(found, dtype=np.float64)


def walls_of(contacts: Contacts, load: Floats, roller: Material, cam: Material, preload: float) -> Walls:
    """The walls of contacts under a load (n,), with the stiffness of their line contacts where they stand nominally.

    roller, cam: materials; preload: mm, the nominal one
    """
    n = len(contacts.theta)

    def flat(values: Floats) -> Floats:
        return np.asarray(values.reshape(n, -1))

    on, lever = contacts.on.reshape(n, -1), flat(contacts.lever)
    approach = np.where(on, -flat(contacts.gap), -np.inf)
    lever = np.where(on, lever, 1.0)
    curvature = _curvature(contacts)
    radius = np.where(np.isfinite(contacts.radius) & (contacts.radius > 0.0), contacts.radius, 1.0 / curvature)
    length = np.where(on, flat(contacts.length), 0.0)
    settled = max(preload, SCALE)
    line_load = np.full(on.shape, settled / line_flexibility(1.0, curvature, roller, cam, radius, 2.0 * radius))
    walls = None
    for _ in range(SOFTEN):
        soft = line_flexibility(np.maximum(line_load, 1e-9), curvature, roller, cam, radius, 2.0 * radius)
        walls = Walls(contacts.mechanism.drive, approach, lever, length / soft, load)
        found = np.divide(walls.forces(np.zeros(on.shape)), length, out=np.zeros(on.shape), where=length > 0.0)
        least = LEAST * found.max(axis=1, keepdims=True)
        line_load = np.where(least > 0.0, np.maximum(found, least), settled / soft)
    assert walls is not None
    return walls


def _curvature(contacts: Contacts) -> Floats:
    """Relative curvature, 1/mm, (n, q), finite and positive: an undercut wall counts as a plane."""
    k = contacts.curvature.reshape(len(contacts.theta), -1)
    plane = 1.0 / contacts.radius if 0.0 < contacts.radius < np.inf else 1.0
    return np.where((k > 0.0) & np.isfinite(k), k, plane)


def pressures(contacts: Contacts, force: Floats, roller: Material, cam: Material) -> Floats:
    """Contact pressure, MPa, (..., n, q), of forces of stations, N."""
    length = np.maximum(contacts.length.reshape(len(contacts.theta), -1), 1e-300)
    pair = pair_compliance(roller, cam)
    return np.asarray(line_pressure(force / length, _curvature(contacts), pair))
