"""One-step maps of every method: the matrices of all steps and all speeds, formed at once.

**Gauss and Radau stages.** For q'' = F - D q' - S q the stage velocities are V_i = v + h sum a_ij A_j and the stage
positions Q_i = q + c_i h v + h^2 sum (a a)_ij A_j, so the only unknowns are the s m accelerations A, a third of the
work of the first-order form:

    A_i + sum_j (h a_ij D_i + h^2 (a a)_ij S_i) A_j = F_i - D_i v - S_i (q + c_i h v)

**Stages with the contact apart.** An indexing drive has constant springs and dampers but one, the contact:

    D = D0 + u r^T,  S = S0 + u p^T,  so that  q'' = F - D0 q' - S0 q - u t,  t = p . q + r . q'

with u, r, p (m,) varying. The stages of the constant part have one inverse for all steps of one length. What is left
to solve in each step are the s contact efforts t of its stages instead of the s m accelerations (the matrix inversion
lemma): the system shrinks by m.

**Newmark family.** With the stretched step H = theta h and a~ = a0 + theta (a1 - a0):

    q~ = q0 + H v0 + H^2 ((1/2 - beta) a0 + beta a~),   v~ = v0 + H ((1 - gamma) a0 + gamma a~)
    (1 - am) a~ + am a0 + (1 - af)(D~ v~ + S~ q~ - F~) + af (D0 v0 + S0 q0 - F0) = 0

then q1, v1 follow from a1 by the same formulas with H = h. D~, S~, F~ are carried on linearly from the two ends of the
step, so that a step never looks past a knot of the motion, where the acceleration may jump.
"""

from __future__ import annotations

from threading import RLock
from weakref import WeakKeyDictionary

import numpy as np

from camgeom.dynamics.linear.method import Coefficients, Collocated, Method, RungeKutta, System
from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import frozen

WORK_SET = 2048
"""steps x speeds x stages / 4 whose matrices are formed together; about 4 MB for three coordinates and four stages"""
SAME = 1e-14
"""share of the longest step within which two lengths are one"""
AT_ONCE = 16
"""parts of the steps whose motion is looked at together"""
WORTH = 4
"""steps of one length that pay for the inverse they share"""


KEPT = (256, 8192)
"""steps x speeds, from and up to which maps are kept: a steady state, a start from rest and what is read from them ask
for the same ones"""
KEPT_SETS = 6
_ONE = RLock()
_MAPS: WeakKeyDictionary[System, dict[tuple[str, bytes, bytes], Floats]] = WeakKeyDictionary()


def step_maps(method: Method, system: System, start: Floats, step: Floats) -> Floats:
    """Affine one-step maps [P | r] (b, n, r, r + 1) for steps (n,) or (b, n) rad long from cam angles start, same
    shape.

    A step must not straddle a knot of the motion. Formed in parts of `WORK_SET` so that memory stays bounded. Raises
    NotConverged where the equations of a step are singular to working precision.
    """
    start, step = np.atleast_2d(start), np.atleast_2d(step)
    if KEPT[0] <= start.shape[1] * system.batch <= KEPT[1]:
        key = method.name, start.tobytes(), step.tobytes()
        with _ONE:
            kept = _MAPS.setdefault(system, {})
            if key not in kept:
                if len(kept) >= KEPT_SETS:
                    del kept[next(iter(kept))]
                kept[key] = frozen(_formed(method, system, start, step))
            return kept[key]
    return _formed(method, system, start, step)


def _formed(method: Method, system: System, start: Floats, step: Floats) -> Floats:
    """The maps, not kept."""
    try:
        return _step_maps(method, system, start, step)
    except np.linalg.LinAlgError:
        raise _singular(method) from None


def _singular(method: Method) -> NotConverged:
    return NotConverged(
        f"the equations of a step of {method.name} are singular to working precision: the fastest mode is too many "
        "times as fast as the cam; take a higher speed, or leave out the stiffest member"
    )


def _step_maps(method: Method, system: System, start: Floats, step: Floats) -> Floats:
    if isinstance(method, RungeKutta):
        apart = contact_maps(method, system, start, step)
        if apart is not None:
            return apart
    size, count = method.rows * system.size, start.shape[1]
    out = np.empty((system.batch, count, size, size + 1))
    stages = len(method.b) if isinstance(method, RungeKutta) else 2
    part = max(1, 4 * WORK_SET // (stages * system.batch))
    for low in range(0, count, part):
        cut = slice(low, low + part)
        if isinstance(method, RungeKutta):
            out[:, cut] = stages_of(method, system, start[:, cut], step[:, cut]).maps()
        else:
            out[:, cut] = _collocated_maps(method, system, start[:, cut], step[:, cut])
    return out


@immutable
class Stages:
    """The stages of many steps: accelerations as rows over (q, q', 1), shape (b, n, s m, 2m + 1), and how forces
    enter them.

    theta (1 or b, n, s) rad; inverse (b, n, s m, s m) takes stage forces to stage accelerations (only when asked for).
    """

    method: RungeKutta
    theta: Floats
    step: Floats
    rows: Floats
    inverse: Floats | None

    def maps(self) -> Floats:
        """Affine maps (b, n, 2m, 2m + 1) of the state (q, q')."""
        b, n, sm, width = self.rows.shape
        m = (width - 1) // 2
        position, speed = self.weights()
        stages = self.rows.reshape(b, n, sm // m, m * width)
        out = np.zeros((b, n, 2 * m, width))
        out[:, :, m:] = (speed @ stages).reshape(b, n, m, width)
        out[:, :, :m] = (position @ stages).reshape(b, n, m, width)
        index = np.arange(m)
        out[:, :, index, index] += 1.0
        out[:, :, m + index, m + index] += 1.0
        out[:, :, index, m + index] += self.step[:, :, None]
        return out

    def bent(self, force: Floats) -> Floats:
        """Stage accelerations (b, n, s m) that stage forces (b, n, s m) give; only where the inverse was kept."""
        assert self.inverse is not None
        return np.asarray((self.inverse @ force[..., None])[..., 0])

    def weights(self) -> tuple[Floats, Floats]:
        """Weights (1 or b, n, 1, s) of the stage accelerations in the step of q and of q'."""
        a, b = np.array(self.method.a), np.array(self.method.b)
        h = self.step[:, :, None]
        # (., n, 1, s) keeps the product with (b, n, s, .) a plain matrix product
        return (h * h * (b @ a))[:, :, None, :], (h * b)[:, :, None, :]


def stages_of(method: RungeKutta, system: System, start: Floats, step: Floats, keep_inverse: bool = False) -> Stages:
    """Stage accelerations of steps (1 or b, n) from cam angles start, rad."""
    m, s = system.size, len(method.b)
    a, c = np.array(method.a), np.array(method.c)
    theta = start[:, :, None] + step[:, :, None] * c
    here = _at(system, theta, c)
    h = step[:, :, None, None, None]
    damping, stiffness = here.damping, here.stiffness
    right = _right_hand_side(here, step, c, system.batch)
    n = right.shape[1]
    matrix = _stage_matrix(a, h * damping, h * h * stiffness, (system.batch, n, s, m, m))
    right = right.reshape(system.batch, n, s * m, 2 * m + 1)
    if keep_inverse:
        inverse: Floats = np.asarray(np.linalg.inv(matrix))
        return Stages(method, theta, step, inverse @ right, inverse)
    return Stages(method, theta, step, np.asarray(np.linalg.solve(matrix, right)), None)


def stepped(method: RungeKutta, system: System, start: Floats, step: Floats, state: Floats) -> Floats:
    """States (b, n, 2m) of q and q' one step (1 or b, n) after the states at cam angles start: what `step_maps` do, for
    steps that are taken once. Raises likewise."""
    m, s, count = system.size, len(method.b), state.shape[1]
    a, b, c = np.array(method.a), np.array(method.b), np.array(method.c)
    q, v = state[..., None, :m], state[..., None, m:]
    here = _at(system, start[:, :, None] + step[:, :, None] * c, c)
    h = step[:, :, None, None, None]
    place = q + (step[:, :, None] * c)[..., None] * v
    force = here.force - (here.damping @ v[..., None] + here.stiffness @ place[..., None])[..., 0]
    shape = (system.batch, count, s, m, m)
    matrix = _stage_matrix(a, h * here.damping, h * h * here.stiffness, shape)
    try:
        bend = np.linalg.solve(matrix, force.reshape(system.batch, count, s * m, 1)).reshape(force.shape)
    except np.linalg.LinAlgError:
        raise _singular(method) from None
    h = step[:, :, None]
    return np.concatenate(
        [state[..., :m] + h * state[..., m:] + h * h * np.einsum("i,bnim->bnm", b @ a, bend),
         state[..., m:] + h * np.einsum("i,bnim->bnm", b, bend)], -1,
    )  # fmt: skip


def held_stages(method: RungeKutta, system: System, start: Floats, step: Floats) -> Stages:
    """The stages of steps (1, n) with their inverses, formed in parts of `WORK_SET`."""
    part = max(1, 4 * WORK_SET // (len(method.b) * system.batch))
    cuts = [slice(low, low + part) for low in range(0, start.shape[1], part)]
    parts = [stages_of(method, system, start[:, cut], step[:, cut], keep_inverse=True) for cut in cuts]
    inverse = np.concatenate([one.inverse for one in parts if one.inverse is not None], 1)
    rows = np.concatenate([one.rows for one in parts], 1)
    return Stages(method, np.concatenate([one.theta for one in parts], 1), step, rows, inverse)


def _stage_matrix(a: Floats, damping: Floats, stiffness: Floats, shape: tuple[int, int, int, int, int]) -> Floats:
    """1 + the blocks (i, j): h a_ij D_i + h^2 (a a)_ij S_i, (b, n, s m, s m), from h D and h^2 S broadcast to shape.

    Formed with the steps on the last axis and turned round once: the small matrices would make loops of length m.
    """
    b, n, s, m, _ = shape
    first, second = (
        np.ascontiguousarray(np.broadcast_to(part, shape).transpose(2, 3, 4, 0, 1)) for part in (damping, stiffness)
    )
    left = np.empty((s, m, s, m, b, n))
    np.multiply(first[:, :, None], a[:, None, :, None, None, None], out=left)
    left += second[:, :, None] * (a @ a)[:, None, :, None, None, None]
    matrix: Floats = np.ascontiguousarray(left.transpose(4, 5, 0, 1, 2, 3)).reshape(b, n, s * m, s * m)
    index = np.arange(s * m)
    matrix[:, :, index, index] += 1.0
    return matrix


def _at(system: System, theta: Floats, c: Floats) -> Coefficients:
    """Coefficients at the stages (1 or b, n, s): damping and stiffness (., n, s, m, m), force (., n, s, m).

    A stage on the end of its step (Radau) takes the limit from inside the step.
    """
    flat = theta[:, :, c < 1.0]
    inside = _unfold(system.coefficients(flat.reshape(flat.shape[0], -1)), flat.shape[1:])
    if c[-1] < 1.0:
        return inside
    end = system.coefficients(theta[:, :, -1], "left")
    stages = len(c)
    return Coefficients(
        _joined(inside.damping, end.damping, stages),
        _joined(inside.stiffness, end.stiffness, stages),
        _joined(inside.force, end.force, stages),
    )


def _joined(inside: Floats, end: Floats, stages: int) -> Floats:
    """Values inside the step (., n, s - 1 or 1, ...) and at its end (., n, ...) as (., n, s, ...)."""
    b, n = (max(inside.shape[k], end.shape[k]) for k in (0, 1))
    rest = end.shape[2:]
    return np.concatenate(
        [np.broadcast_to(inside, (b, n, stages - 1, *rest)), np.broadcast_to(end[:, :, None], (b, n, 1, *rest))], 2
    )


def _unfold(flat: Coefficients, shape: tuple[int, ...]) -> Coefficients:
    """Split the axis of n s stage angles into (n, s); an axis of length 1 stays."""

    def split(values: Floats) -> Floats:
        counts = shape if values.shape[1] != 1 or shape == (1, 1) else (1, 1)
        return values.reshape(values.shape[0], *counts, *values.shape[2:])

    return Coefficients(split(flat.damping), split(flat.stiffness), split(flat.force))


def _right_hand_side(here: Coefficients, step: Floats, c: Floats, batch: int) -> Floats:
    """F_i - D_i v - S_i (q + c_i h v) as rows over (q, v, 1): (b, n, s, m, 2m + 1)."""
    m = here.force.shape[-1]
    n = np.broadcast_shapes(here.force.shape[1:2], step.shape[1:2])[0]
    out = np.empty((batch, n, len(c), m, 2 * m + 1))
    out[..., :m] = -here.stiffness
    reach = (step[:, :, None] * c)[..., None, None]
    out[..., m : 2 * m] = -here.damping - reach * here.stiffness
    out[..., 2 * m] = here.force
    return out


@immutable
class Constant:
    """What all steps of one length share. Stages i, j; coordinates x, y; columns k over (q, q').

    rate, place     (m, m, s, s, b, 1)  q', q at stage i, coordinate x by a unit effort at stage j, coordinate y
    own_rate, own   (m, 2m, s, b, 1)    the same by the state at the step's start
    end             (b, 2m, s, m)       the state at the step's end by efforts; own_end (b, 2m, 2m) by the start
    """

    rate: Floats
    place: Floats
    own_rate: Floats
    own: Floats
    end: Floats
    own_end: Floats


def contact_maps(method: RungeKutta, system: System, start: Floats, step: Floats) -> Floats | None:
    """Affine maps (b, n, 2m, 2m + 1) of steps (1, n) rad from cam angles start (1, n); None where no one
    direction varies alone.

    For a tableau without stages at the ends of the step: there the limit from inside the step would count.
    """
    c = np.array(method.c)
    longest = float(step.max())
    if start.shape[0] > 1 or step.shape[0] > 1 or c[-1] == 1.0 or longest <= 0.0:
        return None
    lengths, which = np.unique(np.round(step[0] / (SAME * longest)), return_inverse=True)
    if len(lengths) * WORTH > step.shape[1]:
        return None
    first = system.coefficients(start[:, :1])
    if first.contact is None:
        return None
    m, s = system.size, len(c)
    out = np.empty((system.batch, step.shape[1], 2 * m, 2 * m + 1))
    part = max(1, 4 * WORK_SET // (s * system.batch))
    for k in range(len(lengths)):
        mine = np.flatnonzero(which == k)
        h = float(step[0, mine[0]])
        shared = _constant(method, first, h, system.batch)
        for many in range(0, len(mine), AT_ONCE * part):
            whole = mine[many : many + AT_ONCE * part]
            # stages first: (s, n) keeps the steps on the last axis
            theta = start[0, whole] + h * c[:, None]
            here = system.coefficients(theta.reshape(1, -1))
            if here.contact is None or here.fixed_damping.shape[1] > 1 or here.fixed_stiffness.shape[1] > 1:
                return None
            vectors = (here.force, here.contact.push, here.contact.rate, here.contact.place)
            parts = [_by_stage(values, s, len(whole)) for values in vectors]
            for low in range(0, len(whole), part):
                cut = slice(low, low + part)
                out[:, whole[cut]] = _effort_maps([values[..., cut] for values in parts], shared)
    return out


def _constant(method: RungeKutta, here: Coefficients, h: float, batch: int) -> Constant:
    """The shared part of steps h rad long."""
    a, b, c = np.array(method.a), np.array(method.b), np.array(method.c)
    m, s = here.force.shape[-1], len(c)
    fixed = (here.fixed_damping[:, 0], here.fixed_stiffness[:, 0])
    damping, stiffness = (np.broadcast_to(part, (batch, m, m)) for part in fixed)
    aa, eye = a @ a, np.eye(m)
    matrix = np.einsum("ij,bxy->bixjy", h * a, damping) + np.einsum("ij,bxy->bixjy", h * h * aa, stiffness)
    inverse = np.linalg.inv(matrix.reshape(batch, s * m, s * m) + np.eye(s * m))
    own = np.zeros((batch, s, m, 2 * m))
    own[..., :m] = -stiffness[:, None]
    own[..., m:] = -damping[:, None] - h * c[:, None, None] * stiffness[:, None]
    bend = (inverse @ own.reshape(batch, s * m, 2 * m)).reshape(batch, s, m, 2 * m)
    by = inverse.reshape(batch, s, m, s, m)
    own_rate, own_place = h * np.einsum("ij,bjxk->bixk", a, bend), h * h * np.einsum("ij,bjxk->bixk", aa, bend)
    own_rate[..., m:] += eye
    own_place[..., :m] += eye
    own_place[..., m:] += h * c[:, None, None] * eye
    weights = np.stack([h * h * (b @ a), h * b])
    own_end = np.einsum("wi,bixk->bwxk", weights, bend).reshape(batch, 2 * m, 2 * m) + np.eye(2 * m)
    own_end[:, :m, m:] += h * eye
    return Constant(
        _last(h * np.einsum("il,blxjy->xyijb", a, by)),
        _last(h * h * np.einsum("il,blxjy->xyijb", aa, by)),
        _last(own_rate.transpose(2, 3, 1, 0)),
        _last(own_place.transpose(2, 3, 1, 0)),
        np.ascontiguousarray(np.einsum("wi,bixjy->bwxjy", weights, by).reshape(batch, 2 * m, s, m)),
        own_end,
    )


def _last(values: Floats) -> Floats:
    """With an axis for the steps behind."""
    return np.ascontiguousarray(values)[..., None]


def _by_stage(values: Floats, s: int, n: int) -> Floats:
    """Values (m, s, 1 or b, n) from those at the stages, (., s n, m) with the steps fastest."""
    return values.reshape(len(values), s, n, values.shape[-1]).transpose(3, 1, 0, 2)


def _effort_maps(parts: list[Floats], shared: Constant) -> Floats:
    """Maps (b, n, 2m, 2m + 1) from F, u, r, p (m, s, 1 or b, n) at the stages."""
    force, push, rate, place = (np.ascontiguousarray(part) for part in parts)
    m, s, _, n = force.shape
    batch = shared.end.shape[0]
    left = np.zeros((s, s, batch, n))
    right = np.zeros((s, 2 * m + 1, batch, n))
    for x in range(m):
        if not (rate[x].any() or place[x].any()):
            continue
        for y in range(m):
            by_rate, by_place = shared.rate[x, y], shared.place[x, y]
            if not by_rate.any():
                continue
            effect = rate[x][:, None] * by_rate + place[x][:, None] * by_place
            if push[y].any():
                left += effect * push[y][None]
            if force[y].any():
                right[:, 2 * m] += (effect * force[y][None]).sum(1)
        for k in range(2 * m):
            if shared.own_rate[x, k].any() or shared.own[x, k].any():
                right[:, k] += rate[x] * shared.own_rate[x, k] + place[x] * shared.own[x, k]
    index = np.arange(s)
    left[index, index] += 1.0
    effort = np.linalg.solve(
        np.ascontiguousarray(left.transpose(2, 3, 0, 1)), np.ascontiguousarray(right.transpose(2, 3, 0, 1))
    )
    # (b, n, 2m, s): the end of the step by the efforts, and by the forces
    at_end = sum(shared.end[:, None, :, :, y] * push[y].transpose(1, 2, 0)[:, :, None] for y in range(m))
    out = -(at_end @ effort)
    out[..., : 2 * m] += shared.own_end[:, None]
    flat = shared.end.reshape(batch, 2 * m, s * m)
    loads = np.broadcast_to(force.transpose(2, 1, 0, 3).reshape(-1, s * m, n), (batch, s * m, n))
    out[..., 2 * m] += np.swapaxes(flat @ loads, 1, 2)
    return np.asarray(out)


def _collocated_maps(method: Collocated, system: System, start: Floats, step: Floats) -> Floats:
    """Affine maps (b, n, 3m, 3m + 1) of the state (q, q', q'') for steps (1 or b, n) from cam angles start, rad."""
    m = system.size
    near = system.coefficients(start, "right")
    far = system.coefficients(start + step, "left")
    ahead = _blend(near, far, method.theta)
    h = step[:, :, None, None]
    out = np.zeros((system.batch, start.shape[1], 3 * m, 3 * m + 1))
    a1 = _new_acceleration(method, near, ahead, h, m)
    out[:, :, 2 * m :, :] = a1
    start_rows = np.broadcast_to(np.eye(3 * m, 3 * m + 1), out.shape)
    q0, v0, a0 = start_rows[:, :, :m], start_rows[:, :, m : 2 * m], start_rows[:, :, 2 * m :]
    out[:, :, m : 2 * m, :] = v0 + h * ((1.0 - method.gamma) * a0 + method.gamma * a1)
    out[:, :, :m, :] = q0 + h * v0 + h * h * ((0.5 - method.beta) * a0 + method.beta * a1)
    return out


def _new_acceleration(method: Collocated, near: Coefficients, ahead: Coefficients, h: Floats, m: int) -> Floats:
    """q'' at the end of the step as rows over (q0, v0, a0, 1), shape (b, n, m, 3m + 1)."""
    hh = method.theta * h
    eye = np.eye(m)
    am, af = method.alpha_m, method.alpha_f
    left = (1.0 - am) * eye + (1.0 - af) * (hh * method.gamma * ahead.damping + hh * hh * method.beta * ahead.stiffness)
    damping, stiffness = np.broadcast_arrays(ahead.damping, ahead.stiffness)
    on_q = -(1.0 - af) * stiffness - af * near.stiffness
    on_v = -(1.0 - af) * (damping + hh * stiffness) - af * near.damping
    on_a = -am * eye - (1.0 - af) * (hh * (1.0 - method.gamma) * damping + hh * hh * (0.5 - method.beta) * stiffness)
    constant = ((1.0 - af) * ahead.force + af * near.force)[..., None]
    shape = np.broadcast_shapes(on_q.shape[:2], on_a.shape[:2], constant.shape[:2])
    right = np.concatenate([np.broadcast_to(part, shape + part.shape[2:]) for part in (on_q, on_v, on_a, constant)], -1)
    stretched = np.linalg.solve(np.broadcast_to(left, shape + left.shape[2:]), right)
    # a1 = a0 + (a~ - a0)/theta
    stretched /= method.theta
    stretched[..., 2 * m : 3 * m] += (1.0 - 1.0 / method.theta) * eye
    return np.asarray(stretched)


def _blend(near: Coefficients, far: Coefficients, theta: float) -> Coefficients:
    """Coefficients carried on linearly from the ends of the step to theta steps."""
    return Coefficients(
        near.damping + theta * (far.damping - near.damping),
        near.stiffness + theta * (far.stiffness - near.stiffness),
        near.force + theta * (far.force - near.force),
    )


def restart(system: System, theta: Floats) -> Floats:
    """Affine maps (b, n, 3m, 3m + 1) that renew the acceleration across knots at theta (1, n), where the forces may
    jump.

    The carried q'' keeps its method-specific value and receives only the jump of F - D q' - S q.
    """
    m = system.size
    left, right = system.coefficients(theta, "left"), system.coefficients(theta, "right")
    out = np.zeros((system.batch, theta.shape[1], 3 * m, 3 * m + 1))
    out[..., : 3 * m] = np.eye(3 * m)
    out[:, :, 2 * m :, :m] = left.stiffness - right.stiffness
    out[:, :, 2 * m :, m : 2 * m] = left.damping - right.damping
    out[:, :, 2 * m :, 3 * m] = right.force - left.force
    return out
