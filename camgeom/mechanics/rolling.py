"""A roller rolling along its two walls: which point of it meets which wall, where, and with what damage.

Vectorised over V variants and over tasks, a task being a variant and an angle on its roller; see `fatigue`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

from camgeom.errors import DesignError, NotConverged
from camgeom.maths import Floats
from camgeom.mechanics.contact import Contact
from camgeom.mechanics.material import Material
from camgeom.mechanics.panels import DERIVATIVE, POINTS, TURN, Panels, chebyshev, evaluate

Ints = NDArray[np.intp]
Count = Literal["from-behind", "both"]
"""from-behind: contacts counted from the first on the wall behind, as published; both: with the contact on the wall
ahead that points past half a turn have before it."""

MOST_DAMAGE = 250.0
"""Power of ten of the relative damage beyond which doubles could overflow"""
BATCH = 100_000
"""Contacts evaluated at once: some tens of megabytes"""
MAX_CONTACTS = 4000
"""Contacts of one roller point in one cam turn up to which they are summed one by one"""


def check_strength(pressure: Floats, material: Material) -> None:
    """Raises DesignError where the pressure, MPa, is so far above the contact limit that no damage can be computed."""
    share = float(np.max(pressure, initial=0.0, where=np.isfinite(pressure))) / material.contact_limit
    if share > 1.0 and material.exponent * np.log10(share) > MOST_DAMAGE:
        limit = f"{material.contact_limit:.6g} MPa"
        raise DesignError(f"the peak pressure is {share:.3g} times the contact limit of {limit}: "
                          "there is no fatigue life to speak of; check force, length and units")


@final
@dataclass(frozen=True, eq=False)
class Rolling:
    """Path and squared relative stress of V variants as Chebyshev series on P panels."""

    panels: Panels
    radius: Floats
    edges: Floats
    """(V, P + 1) path at panel edges, mm"""
    inside: Floats
    """(V, P, n + 1) series of the path"""
    rates: Floats
    """(V, P, n) series of d path / dx"""
    squares: Floats
    """(2, V, P, n) series of (p0 / limit)², signed; wall behind, wall ahead"""
    loaded: NDArray[np.bool_]
    """(2, V, P) whether the wall is loaded anywhere in the panel"""
    laid: Floats
    """(V (P + 1),) the variants' panel edges laid end to end, each scaled to a length of 1 in a space of 2"""
    power: float
    cycles: float
    first: int

    @classmethod
    def of(cls, contact: Contact, material: Material, radius: Floats, count: Count) -> Rolling:
        """The rolling of every variant of a contact, radius (V,) in mm."""
        where = contact.panels
        rate = contact.path_rate.reshape(-1, *contact.path_rate.shape[-2:])
        edges, inside = where.running(rate)
        check_strength(contact.pressure, material)
        walls = np.stack([contact.behind, contact.ahead]).reshape(2, *rate.shape) / material.contact_limit**2
        most = float(np.max(edges[:, -1] / (np.pi * radius)))
        if most > MAX_CONTACTS:
            raise NotConverged(f"a roller point meets the walls {most:.3g} times in one cam turn, more than "
                               f"{MAX_CONTACTS}: use a larger roller, or the mean over the circumference")
        squares = where.coefficients(walls)
        dense = squares @ chebyshev(np.linspace(-1.0, 1.0, 2 * POINTS + 1), POINTS - 1)
        laid = edges / edges[:, -1:] + 2.0 * np.arange(len(edges))[:, None]
        return cls(where, radius, edges, inside, where.coefficients(rate) * where.half[:, None], squares,
                   np.asarray((dense > 0.0).any(axis=-1)), laid.ravel(), 0.5 * material.exponent,
                   material.contact_cycles, -1 if count == "both" else 0)

    @property
    def path(self) -> Floats:
        """Path rolled in one cam turn, mm, (V,)."""
        return np.asarray(self.edges[:, -1])

    def mean(self) -> Floats:
        """Damage averaged over the circumference: the damage per path integrated over the path, over 2 pi r."""
        grid, weights = np.polynomial.legendre.leggauss(2 * POINTS)
        basis = chebyshev(grid, POINTS - 1)
        damage = (np.maximum(self.squares @ basis, 0.0) ** self.power).sum(axis=0) / self.cycles
        each = (damage * (self.rates @ basis)) @ weights
        return np.asarray(each.sum(axis=-1) / (TURN * self.radius))

    def contacts(self, variant: Ints, theta: Floats, middle: Floats) -> tuple[Floats, Ints, Ints]:
        """Path, wall and task, (N,) each, of every contact of the tasks; `middle` decides which exist."""
        most = int(np.ceil(np.max(self.path[variant] / self.radius[variant]) / np.pi)) + 1
        step = np.arange(self.first, most)
        reach = np.pi * self.radius[variant, None] * step
        r = self.radius[variant, None]
        there = middle[:, None] * r + reach
        task, which = np.nonzero((there >= 0.0) & (there <= self.path[variant, None]))
        path = np.clip((theta[:, None] * r + reach)[task, which], 0.0, self.path[variant][task])
        return path, np.asarray(step[which] % 2, dtype=np.intp), np.asarray(task, dtype=np.intp)

    def locate(self, variant: Ints, path: Floats) -> Ints:
        """Panel that holds the path, right-hand one at an edge."""
        wanted = path / self.path[variant] + 2.0 * variant
        panel = np.searchsorted(self.laid, wanted, side="right") - 1 - variant * self.edges.shape[1]
        return np.asarray(np.clip(panel, 0, self.edges.shape[1] - 2), dtype=np.intp)

    def solve(self, variant: Ints, panel: Ints, path: Floats) -> Floats:
        """Position in its panel, x in [-1, 1], at which the path is reached: Newton on a monotone series."""
        series, rate = self.inside[variant, panel], self.rates[variant, panel]
        lo, hi = self.edges[variant, panel], self.edges[variant, panel + 1]
        x = np.clip(2.0 * (path - lo) / np.maximum(hi - lo, 1e-300) - 1.0, -1.0, 1.0)
        for _ in range(12):
            move = (evaluate(series, x) - path) / evaluate(rate, x)
            x = np.clip(x - move, -1.0, 1.0)
            if np.all(np.abs(move) < 1e-13) or np.all(np.abs(np.clip(x - move, -1.0, 1.0) - x) < 1e-13):
                break
        return x

    def damage(self, variant: Ints, theta: Floats, middle: Floats) -> tuple[Floats, Floats]:
        """Damage Q of the tasks and its derivative by the roller angle, (T,) each.

        Each contact stays in the piece (range between jumps) in which it is for the roller angle `middle`, so that at
        the end of such a range the one-sided limit is given.
        """
        most = 1.0 + float(np.max(self.path / self.radius)) / np.pi
        size = max(1, int(BATCH / most))
        parts = [self._batch(variant[k : k + size], theta[k : k + size], middle[k : k + size])
                 for k in range(0, theta.size, size)]
        value, slope = zip(*parts) if parts else ((np.zeros(0),), (np.zeros(0),))
        return np.concatenate(value), np.concatenate(slope)

    def _batch(self, variant: Ints, theta: Floats, middle: Floats) -> tuple[Floats, Floats]:
        path, wall, task = self.contacts(variant, theta, middle)
        owner = variant[task]
        path, panel = self._kept(owner, path, path + (middle - theta)[task] * self.radius[owner])
        live = self.loaded[wall, owner, panel]
        path, wall, task, owner, panel = path[live], wall[live], task[live], owner[live], panel[live]
        x = self.solve(owner, panel, path)
        series = self.squares[wall, owner, panel]
        square = np.maximum(evaluate(series, x), 0.0)
        steep = evaluate(series @ DERIVATIVE.T, x) / evaluate(self.rates[owner, panel], x) * self.radius[owner]
        each = square**self.power
        slope = self.power * steep * np.divide(each, square, out=np.zeros_like(square), where=square > 0.0)
        total = np.bincount(task, each, minlength=theta.size) / self.cycles
        return total, np.bincount(task, slope, minlength=theta.size) / self.cycles

    def _kept(self, owner: Ints, path: Floats, middle: Floats) -> tuple[Floats, Ints]:
        """Path and panel held within the piece that contains the path `middle`."""
        ends = self.panels.break_edges
        piece = self.panels.piece[self.locate(owner, np.clip(middle, 0.0, self.path[owner]))]
        first, last = ends[piece], ends[piece + 1]
        held = np.clip(path, self.edges[owner, first], self.edges[owner, last])
        return held, np.asarray(np.clip(self.locate(owner, held), first, last - 1), dtype=np.intp)
