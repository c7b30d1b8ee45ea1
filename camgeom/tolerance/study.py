"""All that [tolerance] asks of a follower: sensitivities, worst case, yield, and what wear leaves of a preload."""

from __future__ import annotations

from collections.abc import Callable
from math import degrees, isfinite
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.errors import DesignError, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.solid.mechanism import Drive
from camgeom.tolerance.causes import ARCMIN, CAUSES, Cause, Sharing, applicable
from camgeom.tolerance.ends import Ends
from camgeom.tolerance.order import refuse_beyond
from camgeom.tolerance.samples import SPENT, Drawn, Machines, Spreads
from camgeom.tolerance.sensitivity import Loaded, Sensitivities, resting_at
from camgeom.tolerance.spec import ToleranceSpec
from camgeom.tolerance.worst import Worst

if TYPE_CHECKING:
    from camgeom.tolerance.edge import Edge

WEAR = (0.001, 0.002, 0.005, 0.01, 0.02)
"""mm of wear, roller and flank together, that are told"""
NOISE = 1e-6
"""um or seconds of arc, below which a figure is rounding of what is none (single precision of what is drawn)"""
NO_ROOM = 1e-9
"""mm, towards the end of a groove, that are rounding of none"""


def _ordinary() -> float:
    """s of one core for one drawing of machines beside nothing else."""
    return SPENT


@final
@immutable
class ToleranceStudy:
    """A mechanism, its loads, and what its profile tolerates; `spec` None: no errors are given.

    number  of the follower on the cam, 0 of the first; groove: the track that it runs on
    kin     followers before it of which it shares errors: the first on the body, and on its track
    spent   gives the s of one core that one drawing of machines may take
    """

    loaded: Loaded
    spec: ToleranceSpec | None
    number: int = 0
    groove: int = 0
    kin: tuple[tuple[Sharing, ToleranceStudy], ...] = ()
    spent: Callable[[], float] = _ordinary

    @cached_property
    def sensitivities(self) -> Sensitivities:
        """What every error does alone."""
        return Sensitivities(self.loaded)

    @cached_property
    def causes(self) -> tuple[Cause, ...]:
        """The errors given."""
        stated = self.spec.stated() if self.spec is not None else {}
        return tuple(cause for cause in applicable(self.loaded.mechanism) if cause.key in stated)

    @cached_property
    def spreads(self) -> Spreads:
        """Mean, half width, mm or rad, and distribution of every error given.

        Raises DesignError where they are too large for the first order, in which all that follows from them is told.
        """
        if self._stated:
            refuse_beyond(self.sensitivities.seated, self.causes, self._stated, self._ends.curve)
        return self._stated

    @cached_property
    def _stated(self) -> Spreads:
        """The same as they are given, however large."""
        spec = self.spec
        return {} if spec is None else {cause.key: spec.spread(cause, self.loaded.mechanism) for cause in self.causes}

    @cached_property
    def _ends(self) -> Worst:
        """What they come to at most, see `worst`."""
        return self._worst(self._stated)

    def _worst(self, spreads: Spreads) -> Worst:
        return Worst.of(self.sensitivities.seated, self.causes, spreads)

    @property
    def limits(self) -> dict[str, float]:
        """The limits given, mm or rad of the joint coordinate, by figure."""
        if self.spec is None:
            return {}
        given = {"dwell": self.spec.dwell_limit, "motion": self.spec.motion_limit, "backlash": self.spec.backlash_limit}
        unit = self.loaded.shown(1.0)
        return {name: value / unit for name, value in given.items() if value is not None}

    @property
    def limited(self) -> bool:
        """Whether any limit is given."""
        spec = self.spec
        return bool(self.limits) or (spec is not None and (spec.preload_limit or spec.pressure_limit) is not None)

    @cached_property
    def edge(self) -> Edge | None:
        """The hardest pressed roller, tilted by all errors at their tolerances; None where no cylinder bears a load."""
        from camgeom.tolerance.edge import edge_of

        return edge_of(self) if self.spec is not None else None

    def machines(self, spreads: Spreads) -> Machines:
        """Machines whose errors scatter so."""
        relative = self.spec is not None and self.spec.reference == "first-dwell"
        kin = tuple((sharing, one.machines(spreads)) for sharing, one in self.kin)
        least = 1 if self.spec is None else self.spec.least_samples
        return Machines(self.sensitivities, spreads, relative, self.number, kin, self.spent(), least)

    @cached_property
    def drawn(self) -> Drawn:
        """The machines that the profile asks for. Raises ProfileError where it has no [tolerance]."""
        if self.spec is None:
            raise ProfileError([Problem("tolerance", "is missing", None, "a [tolerance] table: nobody said what errs")])
        return self.machines(self.spreads).drawn(self.spec.samples)

    def share(self, drawn: Drawn | None = None) -> float:
        """Share of the machines that hold every limit given; 1 without any."""
        return float(np.mean(self.ratios(drawn or self.drawn) <= 1.0))

    def ratios(self, drawn: Drawn) -> Floats:
        """Of every machine the largest figure over its limit, (s,); 0 without any limit.

        Of play, preload and pressure what grows or is lost, over what may; beside a limit also, of a plate, how far its
        roller goes towards the ends of its groove over the running clearance.
        """
        over = self.each_ratio(drawn)
        return np.max(list(over.values()), axis=0) if over else np.zeros(len(drawn.dwell))

    def each_ratio(self, drawn: Drawn) -> dict[str, Floats]:
        """The same of each limit alone, by its key."""
        # Of the moves and of the pressure nothing is drawn where they have no limit.
        over = {f"tolerance.{name}_limit": self._grown(drawn, name, limit) for name, limit in self.limits.items()}
        spec = self.spec
        if spec is not None and spec.preload_limit is not None and self.preload is not None:
            lost = (self.preload - drawn.preload) / (self.preload - 1e-3 * spec.preload_limit)
            over["tolerance.preload_limit"] = lost
        if spec is not None and spec.pressure_limit is not None:
            over["tolerance.pressure_limit"] = self._harder(drawn, spec.pressure_limit)
        if over and drawn.ended is not None and self.end_room is not None:
            none = np.where(drawn.ended > NO_ROOM, np.inf, 0.0)
            over["cam.running_clearance"] = drawn.ended / self.end_room if self.end_room else none
        return over

    def nominal_over(self, key: str) -> str:
        """What exceeds a limit, by its key, without any error; empty where nothing does."""
        spec = self.spec
        if key == "tolerance.pressure_limit" and spec is not None and spec.pressure_limit is not None:
            if self.peak is not None and self.peak >= spec.pressure_limit:
                return f"{self.peak:.4g} MPa"
            return "a pressure that nobody knows" if self.peak is None else ""
        if key == "tolerance.backlash_limit" and self.play >= self.limits["backlash"]:
            return f"a play of {self.loaded.shown(self.play):.4g} {self.loaded.unit}"
        return ""

    def _grown(self, drawn: Drawn, name: str, limit: float) -> Floats:
        """A figure of every machine over its limit, both beyond what there is without errors: a groove's play."""
        figure, base = drawn.figure(name), self.play if name == "backlash" else 0.0
        if limit <= base:
            return np.where(figure > limit, np.inf, 0.0)
        return np.asarray((figure - base) / (limit - base))

    @cached_property
    def play(self) -> float:
        """Largest nominal play in the dwells, mm or rad; 0 where it is pressed."""
        play = self.sensitivities.seated.nominal.play
        return max(0.0, float(play[resting_at(self.loaded.mechanism.program, self.sensitivities.theta)].max()))

    @property
    def end_room(self) -> float | None:
        """Room that a plate's roller has at the ends of its groove, mm; None of a groove without."""
        mechanism = self.loaded.mechanism
        return None if mechanism.carriage is None or not self.both else mechanism.running_clearance

    @cached_property
    def worst_end(self) -> float:
        """How far all errors within their sizes carry it there, mm, see `Machines.ended`."""
        ends = Ends.of(self.loaded.mechanism, self.loaded.pivots)
        if ends is None:
            return 0.0
        way, growth = ends.extent(self.causes, self.spreads)
        return float((way + growth).max())

    def _harder(self, drawn: Drawn, limit: float) -> Floats:
        """Growth of every machine's pressure over what a limit, MPa, leaves; infinite where it leaves none, and of a
        pressure that nobody knows."""
        pressure, peak = self.pressure(drawn), self.peak
        if pressure is None or peak is None or limit <= peak:
            return np.full(len(drawn.dwell), np.inf)
        return np.asarray((pressure - peak) / (limit - peak))

    @cached_property
    def peak(self) -> float | None:
        """Largest nominal contact pressure, MPa, as the contact's check has it; None of no line contact."""
        hard, peak = self.sensitivities.hard, self.loaded.peak
        if hard is None:
            return None
        own = peak() if peak is not None else None
        return own if own is not None and isfinite(own) else hard.value

    def pressure(self, drawn: Drawn) -> Floats | None:
        """Largest contact pressure of every machine, MPa, (s,): the nominal one by as much as it grows at the stations
        of its line, whose own share of the load is that of stiff lines; None of no line contact."""
        hard = self.sensitivities.hard
        if drawn.pressure is None or hard is None or self.peak is None:
            return None
        return np.asarray(drawn.pressure * (self.peak / hard.value))

    @property
    def both(self) -> bool:
        """Whether walls on both sides hold the follower, so that there is play or preload."""
        return self.loaded.mechanism.drive is not Drive.ALONE

    @property
    def worst(self) -> Worst:
        """All errors within their sizes at once: what no machine goes beyond, see `tolerance.worst`."""
        self.spreads  # noqa: B018  refused where they are too large
        return self._ends

    def beyond(self, spreads: Spreads) -> str:
        """Why the first order does not tell these errors; empty where it does."""
        try:
            refuse_beyond(self.sensitivities.seated, self.causes, spreads, self._worst(spreads).curve)
        except DesignError as why:
            return str(why)
        return ""

    @cached_property
    def preload(self) -> float | None:
        """Least nominal interference along the normals in the dwells, mm; below zero half the play; None of a spring.
        """
        if not self.both:
            return None
        seated = self.sensitivities.seated
        still = resting_at(self.loaded.mechanism.program, self.sensitivities.theta)
        return float(seated.preload(seated.nominal.play)[still].min())

    @cached_property
    def wear(self) -> tuple[tuple[float, float, float], ...]:
        """Rows of wear, mm, of roller and flank together, the nominal preload left, mm, and the share of the machines
        that have any: every micrometre worn off takes one of interference, whatever the lever. Empty without a preload.
        """
        if self.preload is None or self.preload <= 0.0 or self.spec is None:
            return ()
        tight = self.drawn.preload
        depths = (0.0, *WEAR, self.preload)
        return tuple((w, self.preload - w, float(np.mean(tight > w))) for w in sorted(depths))


def tolerance_data(study: ToleranceStudy) -> dict[str, Any]:
    """The study as plain data: um of a slide, seconds of arc of what turns; preload and wear in um."""
    loaded, unit = study.loaded, study.loaded.unit
    data: dict[str, Any] = {
        "unit": unit,
        "sensitivities": [
            {
                "error": row.cause.key,
                "size": row.size,
                "size_unit": row.cause.unit,
                f"motion_{unit}": _zero(loaded.shown(row.motion.value)),
                "motion_um": _zero(1e3 * loaded.arm * row.motion.value),
                "cam_angle_deg": degrees(row.motion.cam_angle) % 360.0 if _zero(1e3 * row.motion.value) else None,
                f"play_{unit}": _zero(loaded.shown(row.play)) if study.both else None,
                "preload_loss_um": _zero(1e3 * row.preload) if study.both else None,
                "pressure_ratio": row.pressure,
            }
            for row in study.sensitivities.rows
        ],
    }
    data["pressed"] = study.sensitivities.hard is not None
    if study.preload is not None:
        data["preload_um"] = _zero(1e3 * study.preload)
    spec = study.spec
    if spec is None:
        return data
    drawn, worst, share = study.drawn, study.worst, spec.wanted_yield
    figures = {"dwell": (drawn.dwell, worst.dwell), "motion": (drawn.motion, worst.motion)}
    if study.both:
        figures["backlash"] = drawn.backlash, worst.backlash
    data |= {"samples": spec.samples, "wanted_yield": share, "reference": spec.reference}
    for name, (figure, end) in figures.items():
        data |= {f"{name}_{unit}": _zero(loaded.shown(drawn.at_yield(figure, share))),
                 f"median_{name}_{unit}": _zero(loaded.shown(drawn.at_yield(figure, 0.5))),
                 f"worst_{name}_{unit}": _zero(loaded.shown(end.value))}  # fmt: skip
    if study.limited:
        data["yield"] = study.share()
    data["errors"] = {
        key: {"mean": mean / CAUSES[key].scale, "value": value / CAUSES[key].scale, "unit": CAUSES[key].unit,
              "distribution": how} for key, (mean, value, how) in study.spreads.items()
    }  # fmt: skip
    data["contributions"] = dict(sorted(drawn.shares.items(), key=lambda item: -item[1]))
    data["contributions_together"] = drawn.together
    if study.both:
        data["least_preload_um"] = _zero(1e3 * drawn.at_yield(drawn.preload, 1.0 - share))
    if study.end_room is not None and drawn.ended is not None:
        data |= {"groove_end_um": _zero(1e3 * drawn.at_yield(drawn.ended, share)),
                 "worst_groove_end_um": _zero(1e3 * study.worst_end),
                 "groove_end_room_um": 1e3 * study.end_room}  # fmt: skip
    if (pressed := study.pressure(drawn)) is not None and (nominal := study.peak) is not None:
        pressure = drawn.at_yield(pressed, share)
        exponent = max(loaded.roller.exponent, loaded.cam.exponent)
        data |= {"nominal_pressure_mpa": nominal, "pressure_mpa": pressure,
                 "life_share": float((nominal / pressure) ** exponent) if pressure > 0.0 else 1.0}  # fmt: skip
    if study.edge is not None:
        edge = study.edge
        data["edge"] = {
            "tilt_arcmin": _zero(edge.tilt / ARCMIN), "load_n": edge.load, "level_pressure_mpa": edge.level,
            "tilted_pressure_mpa": edge.tilted, "unbounded": edge.unbounded,
            "cam_angle_deg": degrees(edge.cam_angle) % 360.0,
        }  # fmt: skip
    if study.wear:
        data["wear"] = [{"wear_um": 1e3 * w, "preload_um": _zero(1e3 * left), "still_preloaded": part}
                        for w, left, part in study.wear]  # fmt: skip
    return data


def _zero(value: float) -> float:
    """A figure, um or seconds of arc; 0 where it is rounding of what is none."""
    return 0.0 if abs(value) < NOISE else value
