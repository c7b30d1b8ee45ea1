"""What keeps a follower on a cam that pushes one way only: the least force, where contact is lost, from which speed.

Where the follower would have to be pulled the contact is lost, and from there on it does not run as the motion says.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees, inf, pi
from typing import Any, final

import numpy as np

from camgeom.errors import NotConverged, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.extremum import Extreme
from camgeom.maths.frozen import cached_property
from camgeom.maths.panels import highest, roots
from camgeom.mechanics.duty import finite, peak_of
from camgeom.mechanics.load import QUIET, FollowerForce, Load, guided_force

STEP, FASTER, SLOWER = 1.2, 25, 38
"""ratio of speeds at which contact is looked at where forces hang on the speed, and how many up and down"""


@immutable(eq=True)
class Lost:
    """A range of cam angle (rad, end may pass the turn) without contact, with the largest missing force N and where."""

    begin: float
    end: float
    missing: float
    cam_angle: float


def zeroed(load: Load) -> FollowerForce:
    """The force that a follower needs, N (N mm), with a panel edge at every zero."""
    full = load.sampled()
    zeros = roots(full.panels, full.force[None], QUIET * float(np.abs(full.force).max(initial=0.0)))[0]
    return load.sampled(full.panels.split(zeros)) if zeros.size else full


@final
@immutable
class Kept:
    """One contact that pushes a follower towards larger lift, under load over one turn.

    force  what the follower needs, with a panel edge at every zero (`zeroed`)
    lever  velocity of the contact point along the normal per unit of the coordinate (1 or mm/rad), > 0, (p, n)
    cosine of a slide's pressure angle, whose guides take the thrust across the motion, (p, n)
    where  the contact's name
    """

    load: Load
    force: FollowerForce
    lever: Floats
    cosine: Floats
    where: str

    @cached_property
    def least(self) -> Extreme:
        """Least normal force, N, guides included; negative where the follower must be pulled: contact is lost."""
        force = self.force.force
        pushed = guided_force(np.maximum(force, 0.0), self.cosine, self.load.guide_friction, self.force.direction)
        pull = peak_of(self.force.panels, -np.where(force > 0.0, pushed, force) / self.lever)
        return Extreme(-pull.value, pull.cam_angle, where=self.where)

    @cached_property
    def lost(self) -> tuple[Lost, ...]:
        """Ranges of cam angle where the cam loses its follower."""
        least = self.least
        if least.value >= 0.0:
            return ()
        where, force = self.force.panels, self.force.force
        bad = force.mean(axis=-1) < 0.0
        if bad.all():
            return (Lost(0.0, 2.0 * pi, -least.value, least.cam_angle),)
        ranges = []
        begins = np.flatnonzero(bad & ~np.roll(bad, 1))
        for first in begins:
            count = int(np.argmin(np.roll(bad, -first)))
            index = (first + np.arange(count)) % len(bad)
            pull = np.where(np.isin(np.arange(len(bad)), index)[:, None], -force / self.lever, -inf)[index]
            part = np.unravel_index(int(np.argmax(pull)), pull.shape)
            last = int(index[-1])
            end = float(where.edges[last + 1]) + (2.0 * pi if last < first else 0.0)
            at = float(where.theta[index][part])
            ranges.append(Lost(float(where.edges[first]), end, float(pull[part]), at))
        return tuple(ranges)

    @cached_property
    def preload_needed(self) -> float:
        """Least spring force at zero lift that keeps contact at the given rate and speed, N (N mm)."""
        rest = float(np.asarray(self.load.preload))
        value, _ = highest(self.force.panels, rest - self.force.force)
        return max(0.0, float(value))

    @cached_property
    def leaving_speed(self) -> float | None:
        """Cam speed, rad/s, from which the follower leaves the cam; inf where it never does, 0 where contact fails at
        standstill.

        Contact needs static + omega² m s'' >= 0, so omega² = 1 / max(-m s'' / static). Where forces hang on the speed
        it is the speed nearest to the load's own at which contact is lost, or kept where it is lost at its own: looked
        for in steps of a fifth, a hundred times as fast and a thousand times as slow at most. None where such a force
        has no value, or cannot be followed, at a speed in between.
        """
        if self.load.solved is None and any(one.fast for one in self.load.applied):
            try:
                return self._changing()
            except (NotConverged, ProfileError):
                return None
        found = self.load.sampled()
        static = found.force - found.inertia
        if static.min() <= 0.0:
            return 0.0
        share, _ = highest(found.panels, -found.inertia / static)
        return self.load.omega / float(np.sqrt(share)) if share > 0.0 else inf

    def _changing(self) -> float:
        """The same where forces hang on the speed."""
        from scipy.optimize import brentq

        low = self.load.omega
        kept = self._lowest(low) > 0.0
        count, step = (FASTER, STEP) if kept else (SLOWER, 1.0 / STEP)
        for _ in range(count):
            high = step * low
            if (self._lowest(high) > 0.0) != kept:
                return float(brentq(self._lowest, low, high, rtol=1e-12, xtol=1e-12 * low))
            low = high
        return inf if kept else 0.0

    def _lowest(self, speed: float) -> float:
        """Least force at another speed, rad/s, N (N mm)."""
        applied = tuple(one.followed(self.load.motion, speed) for one in self.load.applied)
        found = replace(self.load, speed=speed, applied=applied).sampled()
        return -float(highest(found.panels, -found.force)[0])

    def data(self) -> dict[str, Any]:
        """Plain data for result.json."""
        return {
            "least_force_n": self.least.value,
            "least_force_at_deg": degrees(self.least.cam_angle) % 360.0,
            "lost_contact_deg": [[degrees(lost.begin), degrees(lost.end)] for lost in self.lost],
            "leaving_speed_rpm": None if self.leaving_speed is None else finite(self.leaving_speed * 30.0 / pi),
            "preload_needed": self.preload_needed,
        }
