"""All followers of one machine under one [tolerance]: the machines that keep every limit of every follower, and the
widest tolerances that let a wanted share of them do so."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any, final

import numpy as np

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.tolerance.causes import CAUSES
from camgeom.tolerance.samples import BLOCK, Drawn, Spreads
from camgeom.tolerance.sensitivity import SIZES
from camgeom.tolerance.study import ToleranceStudy, tolerance_data

ALONE, TRIAL = 4096, 20_480
"""machines drawn with one error, and with all, in a round of the search for the widest tolerances"""
ROUNDS, SETTLING = 4, 16
WIDEST = 4.0
"""times what one drawing may take that the places of all drawings in that search may (8 s: 32 s)"""
NEAR = 0.995
"""share of a limit that counts as reached"""
NOTHING = 1e-6
"""share of a limit that an error alone may reach and count for nothing"""
Given = tuple[Spreads, ...]
"""the errors of every follower: a fit says other sizes of another roller"""


@final
@immutable(eq=True)
class Widest:
    """The widest tolerances that hold the limits in a share of all machines.

    values  half widths, in the errors' own units, by key; None: the error has no part in what is limited
    reached the share that holds, of all samples
    beyond  why they cannot be told: they are too wide for their first order; empty where they can
    """

    values: Mapping[str, float | None]
    reached: float
    beyond: str = ""


@final
@immutable
class MachineStudy:
    """The studies of all followers of a cam, the first one first; one alone says what its study says.

    A machine has one body: errors of the cam and its shaft are one draw for all followers, those of a track's walls for
    all on the track; each follower's place and rollers have draws of their own (`samples`).
    """

    followers: tuple[ToleranceStudy, ...]

    @property
    def limited(self) -> bool:
        """Whether any limit is given."""
        return any(one.limited for one in self.followers)

    @cached_property
    def ratios(self) -> Floats:
        """Of every machine the largest figure of any follower over its limit, (s,)."""
        return self._ratios(tuple(one.drawn for one in self.followers))

    @property
    def share(self) -> float:
        """Share of the machines of which every follower keeps every limit; 1 without any."""
        return float(np.mean(self.ratios <= 1.0))

    @cached_property
    def unpaid(self) -> str:
        """Why the widest tolerances are not sought: each drawing of others has its own places; empty where they are."""
        given, spent = self._given, WIDEST * self.followers[0].spent()
        drawings = ROUNDS * len(given[0]) + SETTLING
        machines = [one.machines(own) for one, own in zip(self.followers, given)]
        each, spent = sum(count * one for count, one in (one.places for one in machines)), spent * len(self.followers)
        if drawings * each <= spent:
            return ""
        waves = max(one.or_waves(drawings * each / max(spent, 1e-9)) for one in machines)
        return (
            f"some {drawings} drawings of machines, {each:.2g} s of one core before the first machine of each, would "
            f"take more than the {spent:.3g} s that are spent on them: fewer segments of the motion, or errors{waves}"
        )

    @cached_property
    def widest(self) -> Widest | None:
        """The widest tolerances for the wanted yield: least sum of cost over tolerance (`[tolerance.cost]`).

        Where the deviation is a sum of small parts its square is sum (s t)^2, and the least cost sum w / t has
        t ~ (w / s^2)^(1/3) (Lagrange); t counts in the tolerances given, s is what each reaches of the limit alone.
        The common factor is found by drawing all machines again. None where no limit is given, or none can be held.
        """
        spec = self.followers[0].spec
        if spec is None or not self.limited or not self.followers[0].causes or self.unpaid:
            return None
        wanted, given = spec.wanted_yield, self._given
        shares = dict.fromkeys((key for each in given for key in each), 1.0)
        keys = tuple(shares)
        offset = self._offset(wanted)
        if offset >= 1.0:
            return None
        for _ in range(ROUNDS):
            effect = {key: self._alone(shares, key, wanted) / shares[key] for key in keys}
            used = [key for key in keys if effect[key] > NOTHING]
            if not used:
                return None
            best = {key: (spec.cost.of(key) / effect[key] ** 2) ** (1.0 / 3.0) for key in used}
            factor = float(np.sqrt(sum((effect[key] * best[key]) ** 2 for key in used))) / (1.0 - offset)
            fresh = {key: best[key] / factor if key in used else 1.0 for key in keys}
            change = max(abs(fresh[key] / shares[key] - 1.0) for key in used)
            shares = fresh
            if change < 0.05:
                break
        return self._settled(_scaled(given, shares), set(used), wanted, spec.samples, offset)

    @property
    def _given(self) -> Given:
        """Where the search begins."""
        return tuple({key: (mean, value or _first(key), how) for key, (mean, value, how) in one.spreads.items()}
                     for one in self.followers)  # fmt: skip

    def _ratios(self, drawn: tuple[Drawn, ...]) -> Floats:
        return np.asarray(np.max([one.ratios(each) for one, each in zip(self.followers, drawn)], axis=0))

    def _drawn(self, given: Given, samples: int) -> tuple[Drawn, ...]:
        return tuple(one.machines(each).drawn(samples) for one, each in zip(self.followers, given))

    def _reached(self, given: Given, samples: int, wanted: float) -> float:
        """Largest figure over its limit, at the wanted yield, of so many machines with these errors."""
        drawn = self._drawn(given, samples)
        return drawn[0].at_yield(self._ratios(drawn), wanted)

    def _offset(self, wanted: float) -> float:
        """Largest figure over its limit where no error scatters: what their means do alone."""
        if not any(mean for each in self._given for mean, _, _ in each.values()):
            return 0.0
        still = tuple({key: (mean, 0.0, how) for key, (mean, _, how) in each.items()} for each in self._given)
        return max(0.0, self._reached(still, BLOCK, wanted))

    def _alone(self, shares: Mapping[str, float], key: str, wanted: float) -> float:
        """Largest figure over its limit, at the wanted yield, where all errors but one have no size."""
        only = tuple({key: (0.0, each[key][1] * shares[key], each[key][2])} for each in self._given)
        return self._reached(only, ALONE, wanted)

    def _settled(self, shown: Given, used: set[str], wanted: float, samples: int, offset: float) -> Widest | None:
        """The tolerances scaled until all samples hold the wanted share, and not much less would."""
        cost = sum(sum(one.machines(each).cost) for one, each in zip(self.followers, shown))
        whole = max(2, min(SETTLING - 4, int(3.0 * self.followers[0].spent() / (samples * cost))))
        for turn in range(4 + whole):
            drawn = self._drawn(shown, min(samples, TRIAL) if turn < 4 else samples)
            ratios = self._ratios(drawn)
            reached, ratio = float(np.mean(ratios <= 1.0)), drawn[0].at_yield(ratios, wanted)
            if turn >= 4 and reached >= wanted and ratio >= NEAR:
                beyond = next(filter(None, (one.beyond(each) for one, each in zip(self.followers, shown))), "")
                return Widest(_told(shown, used), reached, beyond)
            if not isfinite(ratio) or ratio <= offset:
                return None
            scale = (0.5 * (1.0 + NEAR) - offset) / (ratio - offset)
            if scale <= 0.0:
                return None
            shown = _scaled(shown, dict.fromkeys(used, scale))
        return None


def _scaled(given: Given, shares: Mapping[str, float]) -> Given:
    """The errors with their half widths times shares by key, 1 of a key without."""
    return tuple({key: (mean, value * shares.get(key, 1.0), how) for key, (mean, value, how) in each.items()}
                 for each in given)  # fmt: skip


def _told(given: Given, used: set[str]) -> dict[str, float | None]:
    """Half widths in the errors' own units; of one that differs with the follower the smallest."""
    return {key: min(each[key][1] for each in given) / CAUSES[key].scale if key in used else None for key in given[0]}


def _first(key: str) -> float:
    """Where the search begins for an error of no size: 10 um, 1 minute, 10 seconds of arc."""
    return SIZES[CAUSES[key].unit] * CAUSES[key].scale


def machine_data(study: MachineStudy, with_widest: bool = False) -> dict[str, Any]:
    """What the limits come to for the whole machine, as plain data: yield, widest tolerances; empty without limits."""
    spec = study.followers[0].spec
    if spec is None or not study.limited:
        return {}
    data: dict[str, Any] = {"samples": spec.samples, "wanted_yield": spec.wanted_yield, "yield": study.share}
    if with_widest:
        found = study.widest
        told = found is not None and not found.beyond
        data["widest"] = {"yield": found.reached, "tolerances": dict(found.values)} if found and told else None
        if found is not None and found.beyond:
            data["widest_reason"] = f"wider than can be told; {found.beyond}"
        elif study.unpaid:
            data["widest_reason"] = f"not sought; {study.unpaid}"
    return data


def whole_data(study: MachineStudy) -> dict[str, Any]:
    """All that is told of a machine, with the widest tolerances: the study of one follower, or of several `together`
    what they keep together and `followers` the study of each, by its number and track."""
    machine = machine_data(study, with_widest=True)
    if len(study.followers) == 1:
        return tolerance_data(study.followers[0]) | machine
    each = [{"follower": one.number + 1, "track": one.groove + 1, **tolerance_data(one)} for one in study.followers]
    return {"together": machine, "followers": each}
