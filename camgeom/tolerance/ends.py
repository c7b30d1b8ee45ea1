"""The ends of a plate's groove: how far errors carry the roller towards them, and where its follower stands there.

An end is half a circle about the end of the roller's path, by the running clearance c wider than the roller. Errors
move the roller by t square to its follower's motion, towards the end, and make roller and wall larger by g: it runs
while t + g <= c. Let its wall have the normal a m + b d, with m towards the end and d along the motion. Where t is more
than a (c - g) the roller meets the circle before that wall and stands nearer to the middle, by

    (c - g - a t) / |b| - sqrt((c - g)² - t²)         along the motion.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Self, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import cross, dot
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.tolerance.causes import NORMAL, Approaches, Cause, Pivots
from camgeom.tolerance.contacts import Contacts, contacts
from camgeom.track import Swing

if TYPE_CHECKING:
    from camgeom.tolerance.samples import Spreads
    from camgeom.tolerance.seat import Bools

THERE = 1e-9
"""share of the stroke within which a plate counts as at its end"""


@final
@immutable
class Ends:
    """Both ends of a groove, at the start of the stroke and at its end; arrays (2, l, m) as those of `Contacts`.

    flank    the contacts there; at: the same with normals towards the end, square to the follower's motion
    room     running clearance, mm
    """

    flank: Contacts
    at: Contacts
    pivots: Pivots
    room: float

    @classmethod
    def of(cls, mechanism: Mechanism, pivots: Pivots) -> Self | None:
        """Those of a plate's groove; None of grooves without ends, and of an edge, which goes on straight."""
        carriage = mechanism.carriage
        if carriage is None or mechanism.drive is Drive.ALONE:
            return None
        flank = contacts(mechanism, np.array([0.0, carriage.turned]))
        if isinstance(flank.joint, Swing):
            away = flank.centre - np.array(flank.joint.centre)[:, None, None]
            motion = cross(np.broadcast_to(np.array(flank.joint.axis)[:, None, None], away.shape), away)
        else:
            motion = np.broadcast_to(np.array(flank.joint.direction)[:, None, None], flank.centre.shape)
        beyond = cross(flank.axis, motion)
        # The groove goes on along X from its start, and against X from its end.
        beyond = beyond * (np.sign(beyond[0]) * np.array([-1.0, 1.0])[:, None] / np.sqrt(dot(beyond, beyond)))
        normal = np.broadcast_to(beyond[..., None], flank.x.shape)
        x = flank.x + flank.radius * (normal - flank.normal)
        at = replace(flank, on=np.ones_like(flank.on), x=x, normal=normal, lever=np.zeros_like(flank.lever))
        return cls(flank, at, pivots, mechanism.running_clearance)

    @cached_property
    def _approaches(self) -> Approaches:
        return Approaches(self.at, self.pivots)

    def moved(self, cause: Cause) -> Floats:
        """How far an error carries the roller, mm per mm or rad, (parts, 2, l, m), of its own roller and wall."""
        return self._approaches.of(cause)

    def extent(self, causes: Iterable[Cause], spreads: Spreads) -> tuple[Floats, Floats]:
        """Largest way t and growth g, mm, of all errors within their sizes."""
        found = np.zeros((2, *self.at.on.shape))
        for cause in causes:
            mean, value, _ = spreads[cause.key]
            g = self.moved(cause)
            found[int(cause.key in NORMAL)] += mean * g[0] + value * np.sqrt((g * g).sum(axis=0))
        return found[0], found[1]

    @cached_property
    def beside(self) -> Floats:
        """a of each wall."""
        return np.asarray(dot(self.flank.normal, self.at.normal))

    def inset(self, way: Floats, growth: Floats) -> Floats:
        """How much nearer to the middle the roller stands, mm or rad of the coordinate, for ways and growths, mm."""
        return inset(way, self.room - growth, self.beside, self.flank.lever)

    def there(self, theta: Floats) -> Bools:
        """Which cam angles (n,) stand at either end, (2, n)."""
        carriage = self.at.mechanism.carriage
        assert carriage is not None
        share = carriage.travel(theta) / carriage.stroke
        return np.stack([share <= THERE, share >= 1.0 - THERE])

    def farther(self, theta: Floats, causes: Iterable[Cause], spreads: Spreads) -> Floats:
        """How much farther than beside straight walls a follower may stand off there, mm or rad, (n,)."""
        nominal = self.inset(np.zeros(self.at.on.shape), np.zeros(self.at.on.shape))
        more = np.maximum(self.inset(*self.extent(causes, spreads)) - nominal, nominal).max(axis=(1, 2))
        return np.asarray((self.there(theta) * more[:, None]).sum(axis=0))


def inset(way: Floats, room: Floats, beside: Floats, lever: Floats) -> Floats:
    """How much nearer to the middle a roller stands by the end of its groove than by a wall, mm or rad; all broadcast.

    way: t, mm; room: c - g, mm; beside: a of the wall; lever: its own, mm/rad or 1
    """
    left = np.maximum(room, 0.0)
    round_it = np.sqrt(np.maximum(1.0 - beside * beside, 0.0) * np.maximum(left * left - way * way, 0.0))
    nearer = np.where(way > beside * left, left - beside * way - round_it, 0.0)
    return np.asarray(np.maximum(nearer, 0.0) / np.abs(lever))
