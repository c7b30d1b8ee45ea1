"""One-step maps of collocation methods where only one direction of the equation of motion varies with the cam angle.

An indexing drive or a cam on an elastic shaft has constant springs and dampers but one, the contact:

    D = D0 + u r^T,  S = S0 + u p^T,  so that  q'' = F - D0 q' - S0 q - u t,  t = p . q + r . q'

with u, r, p (m,) varying. The stages of the constant part have one inverse for all steps of one length. What is left
to solve in each step are the s contact efforts t of its stages instead of the s m accelerations (the matrix inversion
lemma): the system shrinks by m.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from camgeom.dynamics.linear.method import WORK_SET, RungeKutta, Side
from camgeom.maths import Floats

SAME = 1e-14
"""share of the longest step within which two lengths are one"""
AT_ONCE = 16
"""parts of the steps whose motion is looked at together"""
WORTH = 4
"""steps of one length that pay for the inverse they share"""


@dataclass(frozen=True, eq=False)
class Split:
    """D0 (b, m, m), S0 (b, m, m) and, at cam angles (n,), F (b, n, m), u (b, n, m), r (b, n, m), p (b, n, m).

    An axis b of length 1 stands for all speeds.
    """

    damping: Floats
    stiffness: Floats
    force: Floats
    push: Floats
    rate: Floats
    place: Floats

    def acceleration(self, position: Floats, rate: Floats) -> Floats:
        """q'' (b, n, m) for q and q' (b, n, m)."""
        effort = (self.place * position).sum(-1) + (self.rate * rate).sum(-1)
        plain = rate @ np.swapaxes(self.damping, -1, -2) + position @ np.swapaxes(self.stiffness, -1, -2)
        return np.asarray(self.force - plain - self.push * effort[..., None])


class Splitting(Protocol):
    """A system whose equation of motion splits; None where it does not."""

    @property
    def size(self) -> int: ...

    @property
    def batch(self) -> int: ...

    def split(self, theta: Floats, side: Side = "right") -> Split | None:
        """The parts at cam angles theta (1, n)."""
        ...


@dataclass(frozen=True, eq=False)
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


def step_maps(method: RungeKutta, system: Splitting, start: Floats, step: Floats) -> Floats | None:
    """Affine maps (b, n, 2m, 2m + 1) of steps (1, n) rad from cam angles start (1, n); None where they do not split.

    For a tableau without stages at the ends of the step: there the limit from inside the step would count.
    """
    c = np.array(method.c)
    longest = float(step.max())
    if start.shape[0] > 1 or step.shape[0] > 1 or method.explicit or c[-1] == 1.0 or longest <= 0.0:
        return None
    lengths, which = np.unique(np.round(step[0] / (SAME * longest)), return_inverse=True)
    if len(lengths) * WORTH > step.shape[1]:
        return None
    first = system.split(start[:, :1])
    if first is None:
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
            here = system.split(theta.reshape(1, -1))
            if here is None:
                return None
            parts = _stage_parts(here, s, len(whole))
            for low in range(0, len(whole), part):
                out[:, whole[low : low + part]] = _maps([one[..., low : low + part] for one in parts], shared)
    return out


def _constant(method: RungeKutta, split: Split, h: float, batch: int) -> Constant:
    """The shared part of steps h rad long."""
    a, b, c = np.array(method.a), np.array(method.b), np.array(method.c)
    m, s = split.damping.shape[-1], len(c)
    damping, stiffness = (np.broadcast_to(part, (batch, m, m)) for part in (split.damping, split.stiffness))
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


def _stage_parts(here: Split, s: int, n: int) -> list[Floats]:
    """F, u, r, p as (m, s, 1 or b, n) from the parts at the stages, (., s n, m) with the steps fastest."""
    return [
        part.reshape(len(part), s, n, part.shape[-1]).transpose(3, 1, 0, 2)
        for part in (here.force, here.push, here.rate, here.place)
    ]


def _maps(parts: list[Floats], shared: Constant) -> Floats:
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
