"""Where the breaks of a best law come to rest, by Newton's method, once linear programmes have shown what it is built
of: quadratic where the programmes creep.

Under a limit of the jerk the best law's jerk is at its limit, or none where acceleration or velocity is held, so that
the breaks, and the value t that limits may hang on, are all the unknowns. A functional of the law, with kernel k, is

    f = -a(0) Phi'(0) + sum D Phi(x),    Phi(x) = integral from x to 1 of k(u) (u - x) du,    Phi'' = k,

D the jerk's steps: it curves with each break alone, and is linear in the jerk. Peaks of the vibration and of the
velocity move with the unknowns, which adds a term of rank one. The limits that hold are equations, and their
multipliers those of all laws.
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np
import numpy.typing as npt

from camgeom.maths import Floats
from camgeom.motion.optimal.excess import KEPT, excess
from camgeom.motion.optimal.programme import Cuts, Multipliers, Solved
from camgeom.motion.optimal.shape import Complexes, Shape, decay, residual_peaks
from camgeom.motion.optimal.wish import Task

STEPS = 12
"""of Newton's method; sound ones take five to nine"""
CHANGES = 5
"""of the set of limits that hold"""
STILL = 0.25
"""share of the jerk's limit below which a span holds what it has reached"""
TOUCHED = 1e-3
"""relative; how near a peak is that is taken for one at its limit"""
REST, ROUNDING, FAR = 1e-12, 1e-9, 1e-3
"""breaks that move less are at rest; those that move less, and no longer less with each step, are where rounding lets
them; breaks that move more are far from it"""
FARTHEST, NEAREST = 0.6, 0.02
"""share of itself by which a span shrinks at most in one step, and what share of a step is too little to go on with"""
SHORT = 1e-5
"""a span that leaves its jerk too few digits"""
EXACT = 2
"""steps by which the equations alone are met in the end"""
NOTHING = 1e-9
"""what rounding leaves of a multiplier"""


class Row(NamedTuple):
    """An equation lack = 0: its slopes for the inner breaks and t (M + 1,), its curvature with each break alone (M,)
    and the rest of it (M + 1, M + 1), and Phi of its kernel at all breaks (K + 1,)."""

    lack: float
    slope: Floats
    alone: Floats
    curve: Floats
    phi: Floats


class _Waves(NamedTuple):
    """z(n) (q,) with two derivatives by n; of its kernel Phi, Phi', Phi'' and the derivative of Phi' by n (q, K + 1).
    """

    z: Complexes
    rate: Complexes
    bend: Complexes
    phi: Complexes
    first: Complexes
    second: Complexes
    faster: Complexes

    @property
    def modulus(self) -> tuple[Floats, Floats, Floats]:
        """|z| and its two derivatives by n."""
        size = np.abs(self.z)
        back = np.conj(self.z) / size
        turned = (back * self.rate).imag
        return size, (back * self.rate).real, (back * self.bend).real + turned * turned / size


@final
class Build:
    """What stays while breaks move: the sense of each span's jerk (K,), and where limits hold.

    t        what is least; the jerk of each span (K,) hangs on it: `growth` is how it grows with t, a share of itself

    levels   breaks at which the acceleration is at its limit, with its sign; it stays there where the jerk is none
    cruises  breaks from which the velocity stays at its limit, with its sign
    peaks    spans inside which the velocity has a peak at its limit, with its sign
    n        where the vibration has a peak at its limit; `pressed` is what each was worth when last seen
    """

    def __init__(self, task: Task, sense: Floats, first: float, t: float) -> None:
        self.task, self.sense, self.first = task, sense, first
        self.grow(t)
        self.fixed = 2 + (task.wish.end[1] is not None)
        self.levels: list[tuple[int, float]] = []
        self.cruises: list[tuple[int, float]] = []
        self.peaks: list[tuple[int, float]] = []
        self.n: Floats = np.empty(0)
        self.pressed: Floats = np.empty(0)

    @property
    def limits(self) -> npt.NDArray[np.bool_]:
        """Which rows are limits, worth something or nothing; all others are equations."""
        out = np.ones(self.fixed + len(self.levels) + 2 * len(self.cruises) + len(self.peaks) + len(self.n), dtype=bool)
        after = self.fixed + len(self.levels)
        out[: self.fixed] = False
        out[after + 1 : after + 2 * len(self.cruises) : 2] = False
        return out

    def shape(self, x: Floats) -> Shape:
        """The law with breaks at x (K + 1,)."""
        return Shape(x, self.first + np.append(0.0, np.cumsum(self.jerk * np.diff(x))))

    def rows(self, x: Floats) -> list[Row]:
        """All equations: the moments, the end's acceleration where it is fixed, then the limits in the order above; of
        a cruise its velocity and its acceleration, which is none."""
        task, wish, shape, t = self.task, self.task.wish, self.shape(x), self.t
        d, inner, y = self.steps[1:], x[1:-1], 1.0 - x
        none, still = np.zeros_like(x), np.zeros_like(d)
        rows = []
        for phi, first, second, wanted in zip(
            (0.5 * y**2, y**3 / 6.0), (-y, -0.5 * y**2), (np.ones_like(x), y), wish.moments, strict=True
        ):
            gained = float(self.steps @ phi[:-1])
            lack = gained - self.first * float(first[0]) - wanted
            rows.append(self._row(lack, d * first[1:-1], gained, d * second[1:-1], phi))
        if wish.end[1] is not None:
            rows.append(self._row(float(shape.a[-1]) - wish.end[1], -d, float(shape.a[-1]) - self.first, still, none))
        top = task.acceleration
        for k, sign in self.levels:
            at = float(shape.a[k])
            row = self._row(sign * at - top.at(t), sign * self._level(k), sign * (at - self.first), still, none)
            rows.append(_against(row, top.slope))
        v = shape.states(wish.start[0])[1]
        for k, sign in self.cruises:
            before = np.where(np.arange(len(d)) < k - 1, d, 0.0)
            slope, mixed = -before * (x[k] - inner), self._level(k)
            row = self._velocity(float(v[k]), slope, before, x, float(x[k]))
            # The break is the place, and moves.
            row.slope[k - 1] = shape.a[k]
            row.curve[k - 1, :-1] = row.curve[:-1, k - 1] = mixed
            row.curve[k - 1, -1] = row.curve[-1, k - 1] = self.growth * (float(shape.a[k]) - self.first)
            rows.append(self._limited(row, sign))
            rows.append(self._row(float(shape.a[k]), mixed, float(shape.a[k]) - self.first, still, none))
        for k, sign in self.peaks:
            u = -float(shape.a[k] / self.jerk[k])
            before = np.where(np.arange(len(d)) < k, d, 0.0)
            peak = float(v[k] + u * shape.a[k] / 2.0)
            row = self._velocity(peak, -before * (x[k] + u - inner), before, x, float(x[k]) + u)
            mixed = np.append(before, self.growth * self.first)
            row.curve[...] -= np.outer(mixed, mixed) / self.jerk[k]
            rows.append(self._limited(row, sign))
        return rows + self._residuals(x)

    def grow(self, t: float) -> None:
        """Take t, and the jerk that is its limit there."""
        limit, self.t = self.task.jerk, t
        self.jerk, self.growth = limit.at(t) * self.sense, limit.slope / limit.at(t)
        self.steps = np.diff(self.jerk, prepend=0.0)

    def _row(self, lack: float, slope: Floats, gained: float, alone: Floats, phi: Floats) -> Row:
        """The row of a functional that stays; `gained` is what it has by the jerk, and `slope` is by the jerk alone."""
        curve = np.zeros((len(slope) + 1, len(slope) + 1))
        curve[:-1, -1] = curve[-1, :-1] = self.growth * slope
        return Row(lack, np.append(slope, self.growth * gained), alone, curve, phi)

    def _level(self, k: int) -> Floats:
        """How the acceleration at break k answers to the inner breaks (M,)."""
        slope = np.where(np.arange(len(self.jerk) - 1) < k - 1, -self.steps[1:], 0.0)
        slope[k - 1] = self.jerk[k - 1]
        return slope

    def _velocity(self, v: float, slope: Floats, alone: Floats, x: Floats, at: float) -> Row:
        """The row of a velocity at a place."""
        gained = v - self.task.wish.start[0] - self.first * at
        return self._row(v, slope, gained, alone, 0.5 * np.maximum(at - x, 0.0) ** 2)

    def _limited(self, row: Row, sign: float) -> Row:
        """The row of a velocity that is at its limit, upwards or downwards."""
        limit = self.task.velocity
        signed = Row(sign * row.lack, sign * row.slope, sign * row.alone, sign * row.curve, sign * row.phi)
        if sign < 0.0 and self.task.wish.monotone:
            return signed
        return _against(signed._replace(lack=signed.lack - limit.at(self.t)), limit.slope)

    def _residuals(self, x: Floats) -> list[Row]:
        """A row of each peak of the vibration, n moved to where the peak is."""
        if not len(self.n):
            return []
        low, high = self.task.wish.band or (0.0, 0.0)
        _, rate, bend = self.waves(x).modulus
        self.n = np.clip(self.n - np.where(bend < 0.0, rate / np.where(bend < 0.0, bend, 1.0), 0.0), low, high)
        waves, d, limit = self.waves(x), self.steps[1:], self.task.residual
        size, _, bend = waves.modulus
        back = (np.conj(waves.z) / size)[:, None]
        # By the inner breaks, and by t: what is not of the start's acceleration grows with the jerk.
        by_t = self.growth * (waves.z + self.first * waves.first[:, 0])
        faster_by_t = self.growth * (waves.rate + self.first * waves.faster[:, 0])
        to = back * np.column_stack([d * waves.first[:, 1:-1], by_t])
        turned = (back[:, 0] * waves.rate).imag / size
        mixed = (back * np.column_stack([d * waves.faster[:, 1:-1], faster_by_t])).real + turned[:, None] * to.imag
        mixed[(self.n <= low) | (self.n >= high) | (bend >= 0.0)] = 0.0  # a peak at the band's end stays
        straight, phi = d * (back * waves.second)[:, 1:-1].real, (back * waves.phi).real
        rows = []
        for i in range(len(size)):
            row = self._row(float(size[i]) - limit.at(self.t), to[i, :-1].real, 0.0, straight[i], phi[i])
            row.slope[-1] = to[i, -1].real
            row.curve[...] += np.outer(to[i].imag, to[i].imag) / size[i] - np.outer(mixed[i], mixed[i]) / bend[i]
            rows.append(_against(row, limit.slope))
        return rows

    def waves(self, x: Floats) -> _Waves:
        """The vibration at n with what it answers to."""
        n, y = self.n[:, None], 1.0 - x
        rate_of, frequency = decay(self.n, self.task.wish.damping)
        k, damped = rate_of[:, None], frequency[:, None]
        fade = np.exp(-k * y)
        rise = (1.0 - fade) / k
        phi = (y - rise) / (k * damped)
        first: Complexes = -rise / damped
        second: Complexes = np.divide(fade, damped)
        faster = (2.0 * rise - y * fade) / (n * damped)
        # The derivatives of Phi and Phi' by n, the rate of decay and the frequency being proportional to it.
        once = (3.0 * rise - y * (2.0 + fade)) / (n * k * damped)
        twice = ((6.0 * y * (1.0 + fade) - 12.0 * rise) / k + y * y * fade) / (n * n * damped)
        fastest = (4.0 * y * fade - 6.0 * rise + k * y * y * fade) / (n * n * damped)
        z, rate, bend = (
            by_break[:, :-1] @ self.steps - self.first * by_start[:, 0]
            for by_break, by_start in ((phi, first), (once, faster), (twice, fastest))
        )
        return _Waves(z, rate, bend, phi, first, second, faster)

    def let_go(self, worth: Floats) -> bool | None:
        """Take out the touch of a limit that is worth least, below nothing; whether there was one, None where the build
        itself is what is worth less than nothing."""
        net = np.where(self.limits, worth, 0.0)
        least = int(net.argmin())
        if net[least] >= -NOTHING:
            return False
        at = least - self.fixed
        if at < len(self.levels):
            if self.jerk[self.levels[at][0]] == 0.0:
                return None
            self.levels.pop(at)
            return True
        at -= len(self.levels) + 2 * len(self.cruises)
        if at < 0:
            return None
        if at < len(self.peaks):
            self.peaks.pop(at)
        else:
            at -= len(self.peaks)
            self.n, self.pressed = np.delete(self.n, at), np.delete(self.pressed, at)
        return True

    def solved(self, x: Floats, worth: Floats) -> Solved:
        """The law with the multipliers of its rows."""
        shape, rows = self.shape(x), self.rows(x)
        after = self.fixed + len(self.levels)
        cruising, peaking = worth[after : after + 2 * len(self.cruises)], after + 2 * len(self.cruises)
        # S less the end of W: it steps where the acceleration is at a limit, and where a cruise begins.
        steps = np.zeros(len(x))
        steps[-1] = worth[2] if self.fixed > 2 else 0.0
        for (k, sign), w in zip(self.levels, worth[self.fixed : after], strict=True):
            steps[k] += sign * w
        for (k, _), w in zip(self.cruises, cruising[1::2], strict=True):
            steps[k] += w
        level = -np.cumsum(steps[::-1])[::-1][1:]
        mean = -np.diff(worth @ np.array([row.phi for row in rows])) / shape.h
        peaks = worth[peaking : peaking + len(self.peaks)]
        places = [x[k] for k, _ in self.cruises] + [x[k] - shape.a[k] / self.jerk[k] for k, _ in self.peaks]
        up = np.array([sign for _, sign in self.cruises + self.peaks]) > 0.0
        pressed = np.concatenate([cruising[::2], peaks])
        cuts = Cuts(self.n, np.angle(self.waves(x).z), np.array(places))
        return Solved(
            shape,
            self.t,
            Multipliers(
                -worth[:2],
                cuts,
                worth[peaking + len(self.peaks) :],
                cuts.places,
                np.where(up, pressed, 0.0),
                np.where(up, 0.0, pressed),
                np.where(self.jerk != 0.0, level - mean, 0.0),
            ),
            at_rest=True,
        )


def _against(row: Row, slope: float) -> Row:
    """The row against a limit that grows with t."""
    row.slope[-1] -= slope
    return row


def build_of(task: Task, solved: Solved, proven: Shape | None = None) -> tuple[Build, Floats] | None:
    """The build of a law nearly at rest, and its breaks (K + 1,); None where it shows none.

    proven  the shape whose multipliers they are, where that is another one
    """
    shape, wish, most = solved.shape, task.wish, task.jerk.at(solved.value)
    sense = np.where(np.abs(shape.jerk) < STILL * most, 0.0, np.sign(shape.jerk))
    kept = np.concatenate([[True], np.diff(sense) != 0.0, [True]])
    x, a, v, sense = shape.x[kept], shape.a[kept], shape.states(wish.start[0])[1][kept], sense[kept[:-1]]
    build = Build(task, sense, float(shape.a[0]), solved.value)
    top, fast = task.acceleration.at(solved.value), task.velocity.at(solved.value)
    slow, size = (0.0, 1.0) if wish.monotone else (-fast, fast)
    if sense[0] == 0.0:
        return None
    for k in range(1, len(sense)):
        up = float(np.sign(a[k]))
        if sense[k] != 0.0:
            if sense[k - 1] * up > 0.0 > sense[k] * up and abs(a[k]) >= (1.0 - TOUCHED) * top:
                build.levels.append((k, up))
        elif 2.0 * abs(a[k]) > top:
            build.levels.append((k, up))
        elif v[k] - slow > fast - v[k]:
            build.cruises.append((k, 1.0))
        elif size < np.inf:
            build.cruises.append((k, -1.0))
        else:
            return None
    now = build.shape(x)
    v = now.states(wish.start[0])[1]
    cruises = [k for k, _ in build.cruises]
    for k in np.flatnonzero((now.a[:-1] * now.a[1:] < 0.0) & (sense != 0.0)).tolist():
        # Beside a cruise the acceleration is none, and rounding lets it change its sign.
        if k + 1 in cruises or k - 1 in cruises:
            continue
        peak = v[k] - now.a[k] ** 2 / now.jerk[k] / 2.0
        if sense[k] < 0.0 and peak >= (1.0 - TOUCHED) * fast:
            build.peaks.append((k, 1.0))
        elif sense[k] > 0.0 and peak <= slow + TOUCHED * size < np.inf:
            build.peaks.append((k, -1.0))
    if wish.band is not None and task.residual.asked:
        cuts = solved.multipliers.cuts
        n, _ = residual_peaks(proven or shape, wish.band, wish.damping)
        at = np.abs(cuts.n[:, None] - n).argmin(axis=1)
        pressed: Floats = np.bincount(at, solved.multipliers.cut, len(n)).astype(float)
        build.n, build.pressed = n[pressed > NOTHING], pressed[pressed > NOTHING]
    return build, x


def at_rest(task: Task, begun: Solved, proven: Shape | None = None) -> Solved | None:
    """The law at rest that is built like one nearly so, with its multipliers; None where Newton's method finds none
    that keeps all limits and in which each is worth something, or where no jerk or no start is given.

    proven  the shape whose multipliers those of `begun` are, where that is another one
    """
    if not task.jerk.asked or task.wish.start[1] is None or begun.value <= 0.0:
        return None
    shown = build_of(task, begun, proven)
    if shown is None:
        return None
    build, x = shown
    for _ in range(CHANGES):
        settled = _steps(build, x)
        if settled is None:
            return None
        x, worth = settled
        build.pressed = worth[len(worth) - len(build.n) :]
        gone = build.let_go(worth)
        if gone is None:
            return None
        if gone:
            continue
        shape, t = build.shape(x), build.t
        over, (n, _, places, _) = excess(task, shape, t)
        if np.abs(shape.a).max() > task.acceleration.at(t) * (1.0 + KEPT) or shape.h.min() < SHORT:
            return None
        if over <= KEPT:
            return build.solved(x, worth)
        n = n[np.abs(n[:, None] - build.n).min(axis=1, initial=np.inf) > TOUCHED]
        spans = (np.searchsorted(x, places) - 1).tolist()
        if not len(n) + len(spans) or set(spans) & {k for k, _ in build.peaks + build.cruises}:
            return None
        build.n, build.pressed = np.append(build.n, n), np.append(build.pressed, 0.0 * n)
        build.peaks += [(k, -float(np.sign(build.jerk[k]))) for k in spans]
    return None


def _steps(build: Build, x: Floats) -> tuple[Floats, Floats] | None:
    """Breaks at which the equations of a build hold and nothing is gained by a move, the value being taken along, and
    what each equation is worth; None where Newton's method does not come there."""
    worth: Floats = np.empty(0)
    farthest = 1.0
    for _ in range(STEPS):
        rows = build.rows(x)
        slope = np.array([row.slope for row in rows])
        count, width = slope.shape
        aim = np.append(np.zeros(width - 1), 1.0)
        if not len(worth):
            known = count - len(build.n)
            pull = -aim - slope[known:].T @ build.pressed
            worth = np.concatenate([np.linalg.lstsq(slope[:known].T, pull, rcond=None)[0], build.pressed])
        system = np.zeros((width + count, width + count))
        weight = np.where(build.limits, np.maximum(worth, 0.0), worth) if farthest > FAR else worth
        alone = weight @ np.array([row.alone for row in rows])
        if farthest > FAR:
            # A law at rest is convex, as a rule in each break alone; what is far from it need not be.
            alone = np.maximum(alone, 0.0)
        curve = np.einsum("i,ijk", weight, np.array([row.curve for row in rows]))
        system[:width, :width] = curve + np.diag(np.append(alone, 0.0))
        system[:width, width:], system[width:, :width] = slope.T, slope
        try:
            answer = np.linalg.solve(system, -np.append(aim, [row.lack for row in rows]))
        except np.linalg.LinAlgError:
            return None
        move, worth = answer[: width - 1], answer[width:]
        before, farthest = farthest, float(np.abs(move).max())
        shrunk = float((-np.diff(move, prepend=0.0, append=0.0) / np.diff(x)).max())
        share = min(1.0, FARTHEST / max(shrunk, REST))
        if share < NEAREST or not np.isfinite(farthest):
            return None
        x = x + np.concatenate([[0.0], share * move, [0.0]])
        t = build.t + share * float(answer[width - 1])
        if build.task.jerk.at(t) <= 0.0:
            return None
        build.grow(t)
        if farthest <= REST or 0.5 * before < farthest <= ROUNDING:
            return _exact(build, x), worth
    return None


def _exact(build: Build, x: Floats) -> Floats:
    """Breaks at rest at which the equations hold as well as rounding lets them: by those alone, which are of one size,
    where the multipliers beside them are not. What is least is so to the second order of these moves."""
    for _ in range(EXACT):
        rows = build.rows(x)
        size = np.append(np.ones(len(x) - 2), max(build.t, FAR))
        slope = np.array([row.slope for row in rows]) * size
        move = size * np.linalg.lstsq(slope, -np.array([row.lack for row in rows]), rcond=None)[0]
        x = x + np.concatenate([[0.0], move[:-1], [0.0]])
        build.grow(build.t + float(move[-1]))
    return x
