"""Form deviation of a measured cam: its points best-fitted to the exact flanks, by Gauss-Newton least squares.

The unknown is the motion that brings the measuring machine's frame into the cam frame. Every point gives the distance
of the probe from its exact foot point on the flank, less the probe's radius; its derivative by the motion is the
flank's normal, so the steps are exact to first order and the fit settles in a few. The starting angle about the axis
is searched over the whole turn.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING, Any, Literal, final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.inspection.feet import ROUGH_ROUNDS as FEW
from camgeom.inspection.feet import ROUNDS as ENOUGH
from camgeom.inspection.feet import Feet, Target
from camgeom.inspection.points import MeasuredPoints
from camgeom.maths import Floats
from camgeom.model.surfaces import measured_surfaces, within
from camgeom.track import TURN

if TYPE_CHECKING:
    from camgeom.model import Model

Fit = Literal["none", "angle", "axial", "travel", "rigid"]
"""nothing moves; angle about the axis; that and the shift along it; of a plate shifts along its travel and its height;
all six degrees of freedom"""

FREE: dict[str, tuple[int, ...]] = {
    "none": (), "angle": (2,), "axial": (2, 5), "travel": (3, 5), "rigid": (0, 1, 2, 3, 4, 5),
}  # fmt: skip
"""columns of (rotation vector, translation) that a fit moves"""
ANGLES, TRIED, SUBSET, SEARCHED = 360, 4, 160, 48
ROUNDS, ROUGH_ROUNDS = 60, 12
SMALLEST = 1e-6
"""mm, of what is measured"""
SETTLED = 1e-13
"""step, as a share of the cam's size, that ends the fit"""
STALLED = 1e-6
"""step below which a fit that gains nothing has settled too"""
WEAK = 1e-6
"""mm of deviation per mm of motion, rms, below which the points say nothing about a motion"""
FLICKERS = 10
"""rounds after which a point that comes to lie beyond an edge stays out, lest it come and go with every step"""
HOPELESS = 3
"""rounds after which a starting angle that is still far off is given up"""
SUSPECT = 0.01
"""mm; rms deviation above which the mirror image is tried too"""
SURE = 0.1
"""share of GROSS below which a starting angle is taken without trying others"""
GROSS = 0.25
"""mm; rms deviation above which points are taken not to belong to the cam"""
EDGE = 1e-3
"""mm; a point whose foot is further aside than this lies beyond the flank's edge"""
MOST_BEYOND = 0.25


@immutable(eq=True)
class Deviation:
    """Form deviation of a set of points, mm: largest, smallest, root mean square, and where the worst lies.

    Positive where material stands proud of the flank. cam_angle rad and station mm of the worst point's foot.
    """

    name: str
    points: int
    largest: float
    smallest: float
    rms: float
    worst: float
    cam_angle: float
    station: float

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "flank": self.name,
            "points": self.points,
            "max_mm": self.largest,
            "min_mm": self.smallest,
            "peak_to_valley_mm": self.largest - self.smallest,
            "rms_mm": self.rms,
            "worst_mm": self.worst,
            "worst_cam_angle_deg": degrees(self.cam_angle) % 360.0,
            "worst_station_mm": self.station,
        }


@final
@immutable
class Inspection:
    """A fitted measurement.

    turn, shift   rotation (3, 3) and translation (3,) mm that take measured points into the cam frame
    undetermined  names of the motions the points say nothing about; they were left where they were
    points        (3, n) the measured points in the cam frame, mm
    kept          (n,) whether a point lies on a flank (the others lie beyond its edges and do not count)
    feet          of all points; `deviation` (n,) mm
    """

    fit: Fit
    turn: Floats
    shift: Floats
    undetermined: tuple[str, ...]
    names: tuple[str, ...]
    points: Floats
    kept: npt.NDArray[np.bool_]
    feet: Feet
    deviation: Floats
    stations: Floats
    angles: Floats
    rounds: int

    @property
    def angle(self) -> float:
        """Rotation about the cam axis, rad."""
        return float(np.arctan2(self.turn[1, 0], self.turn[0, 0]))

    def of(self, number: int | None = None) -> Deviation:
        """Deviation over one flank, or over all."""
        use = self.kept if number is None else self.kept & (self.feet.surface == number)
        index = np.flatnonzero(use)
        values = self.deviation[index]
        worst = int(index[np.argmax(np.abs(values))])
        return Deviation(
            "all" if number is None else self.names[number],
            len(index),
            float(values.max()),
            float(values.min()),
            float(np.sqrt(np.mean(values**2))),
            float(self.deviation[worst]),
            float(self.angles[worst]),
            float(self.stations[worst]),
        )

    @property
    def flanks(self) -> tuple[Deviation, ...]:
        """Deviation over every flank that has points."""
        present = sorted(set(self.feet.surface[self.kept].tolist()))
        return tuple(self.of(number) for number in present)

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "fit": self.fit,
            "angle_deg": degrees(self.angle),
            "axial_mm": float(self.shift[2]),
            "rotation": self.turn.tolist(),
            "translation_mm": self.shift.tolist(),
            "undetermined": list(self.undetermined),
            "points": len(self.kept),
            "beyond_the_flanks": int((~self.kept).sum()),
            "rounds": self.rounds,
            **{key: value for key, value in self.of().as_dict().items() if key not in ("flank", "points")},
            "flanks": [flank.as_dict() for flank in self.flanks],
        }


def inspect(model: Model, points: MeasuredPoints, probe_radius: float = 0.0, fit: Fit | None = None) -> Inspection:
    """Best-fit measured points to the exact flanks of a cam.

    probe_radius  mm, where the points are centres of the probe's ball; 0 where they are points of contact
    fit           None: "axial", of a plate, which has no axis to turn about, "travel"
    Raises ProfileError where the points do not belong to the cam (other profile, hand, unit), lack heights that the
    cam needs or name unknown flanks, NotConverged where the fit does not settle, DesignError where the cam has none.
    """
    slides = model.mechanism.carriage is not None
    fit = fit or ("travel" if slides else "axial")
    if slides and fit in ("angle", "axial"):
        raise ProfileError([Problem("--fit", "a plate has no axis to turn about", fit, "none, travel or rigid")])
    if fit == "travel" and not slides:
        raise ProfileError([Problem("--fit", "a cam that turns has no travel", fit, "none, angle, axial or rigid")])
    surfaces = measured_surfaces(model)
    target = Target.of(surfaces, within(model))
    names = tuple(surface.name for surface in surfaces)
    allowed = _allowed(points, names)
    x = points.x
    if points.planar:
        if model.planar is None:
            raise ProfileError([Problem("points", "need heights on a cam that is not planar", None, "a column z")])
        if len(model.grooves) > 1:
            why = "need heights on a disc with several tracks, whose flanks cross in the plane"
            raise ProfileError([Problem("points", why, None, "a column z")])
        x = np.stack([x[0], x[1], np.full(x.shape[1], 0.5 * sum(surfaces[0].wall))])
    registration = _Registration(target, x, probe_radius, allowed, FREE[fit])
    best = registration.solved()
    if best.foreign or (best.rms > SUSPECT and fit != "none"):
        _refuse(registration, best)
    stations, angles = np.zeros(x.shape[1]), np.zeros(x.shape[1])
    for number, surface in enumerate(surfaces):
        mine = best.feet.surface == number
        stations[mine] = surface.station(best.feet.t[mine])
        angles[mine] = surface.angle(best.feet.phi[mine])
    words = ("tilt about X", "tilt about Y", "angle", "shift along X", "shift along Y", "axial shift")
    return Inspection(
        fit, best.turn, best.shift, tuple(words[k] for k in best.weak), names,
        best.turn @ x + best.shift[:, None], best.kept, best.feet, best.deviation, stations, angles, best.rounds,
    )  # fmt: skip


def _allowed(points: MeasuredPoints, names: tuple[str, ...]) -> npt.NDArray[np.bool_]:
    """Flanks (n, s) a point may lie on: the one its row names, or any."""
    n = points.x.shape[1]
    if points.flank is None or not any(points.flank):
        return np.ones((n, len(names)), dtype=bool)
    unknown = next((name for name in points.flank if name and name not in names), None)
    if unknown is not None:
        raise ProfileError([Problem("flank", "the cam has no such flank", unknown, ", ".join(names))])
    return np.array([[not name or name == other for other in names] for name in points.flank])


@immutable
class _Placement:
    """A place of the points in the cam frame and what it gives."""

    turn: Floats
    shift: Floats
    feet: Feet
    deviation: Floats
    kept: npt.NDArray[np.bool_]
    rounds: int = 0
    weak: tuple[int, ...] = ()

    @property
    def rms(self) -> float:
        return self.rms_of(self.kept)

    def rms_of(self, points: npt.NDArray[np.bool_]) -> float:
        return float(np.sqrt(np.mean(self.deviation[points] ** 2))) if np.any(points) else float("inf")

    @property
    def beyond(self) -> float:
        return 1.0 - float(np.mean(self.kept))

    @property
    def foreign(self) -> bool:
        """True where the points do not lie on the cam."""
        return self.beyond > MOST_BEYOND or not self.rms <= GROSS


@immutable
class _Registration:
    """Points (3, n) of a probe of `radius` to be brought onto the target by the free motions."""

    target: Target
    x: Floats
    radius: float
    allowed: npt.NDArray[np.bool_]
    free: tuple[int, ...]
    newton: int = ENOUGH

    def solved(self) -> _Placement:
        """The best place: of several starting angles where the angle is free."""
        if not self.free:
            return self.state(np.eye(3), np.zeros(3))
        step = max(1, self.x.shape[1] // SUBSET)
        part = replace(self, x=self.x[:, ::step], allowed=self.allowed[::step], newton=FEW)
        best: _Placement | None = None
        for angle in part.starts()[0]:
            tried = part.descended(part.state(_about_z(angle), np.zeros(3)), rough=True)
            if best is None or (tried.beyond > MOST_BEYOND, tried.rms) < (best.beyond > MOST_BEYOND, best.rms):
                best = tried
            if not best.foreign and best.rms < SURE * GROSS:
                break
        assert best is not None
        return best if best.foreign else self.descended(self.state(best.turn, best.shift))

    def starts(self) -> tuple[list[float], float]:
        """Angles (rad) to start from, and about how far off the first is, mm.

        The best of the whole turn by the sampled flanks, then the given one.
        """
        angles = np.arange(ANGLES) * TURN / ANGLES
        few = self.x[:, :: max(1, self.x.shape[1] // SEARCHED)]
        score = np.array([np.median(self.target.rough(_about_z(a) @ few, self.radius)) for a in angles])
        low = (score <= np.roll(score, 1)) & (score <= np.roll(score, -1))
        places = np.flatnonzero(low)
        order = places[np.argsort(score[places])][:TRIED]
        return [*angles[order].tolist(), 0.0], float(score.min())

    def state(self, turn: Floats, shift: Floats, last: Feet | None = None) -> _Placement:
        """Feet and deviations with the points at a place."""
        placed = turn @ self.x + shift[:, None]
        feet = self.target.feet(placed, self.radius, self.allowed, last, self.newton)
        return _Placement(turn, shift, feet, feet.distance - self.radius, feet.beside < EDGE)

    def descended(self, state: _Placement, rough: bool = False) -> _Placement:
        """Gauss-Newton steps to the least squares, shortened where they do not descend, of the points that count before
        and after: one that comes to lie beyond an edge says nothing of the step."""
        # Points that are all but one place are turned about it by nothing.
        size = max(float(np.abs(self.x).max()), SMALLEST)
        for count in range(1, (ROUGH_ROUNDS if rough else ROUNDS) + 1):
            if not np.any(state.kept):
                return state
            step, weak = self._step(state, size)
            length = float(np.abs(step).max())
            share, better = 1.0, None
            while share > 1e-4:
                better = self._moved(state, share * step, size)
                if count > FLICKERS:
                    better = replace(better, kept=better.kept & state.kept)
                both = state.kept & better.kept
                descends = np.any(both) and better.rms_of(both) <= state.rms_of(both) * (1.0 + 1e-12)
                if descends or length < 1e-9:
                    break
                share *= 0.35
            assert better is not None
            if share <= 1e-4:
                if length < 1e-6:
                    return replace(state, rounds=count, weak=weak)
                break
            gained = 1.0 - better.rms_of(both) / max(state.rms_of(both), 1e-300)
            state = replace(better, rounds=count, weak=weak)
            if share * length < (1e-6 if rough else SETTLED) or (length < STALLED and gained < 1e-9):
                return state
            if rough and count >= HOPELESS and state.rms > 4.0 * GROSS:
                return state
        if rough:
            return state
        raise NotConverged(
            f"the best fit does not settle (rms {state.rms:.3g} mm after {ROUNDS} rounds); the points fit several "
            "places alike: measure more of the motion, or fit fewer degrees of freedom"
        )

    def _moved(self, state: _Placement, step: Floats, size: float) -> _Placement:
        turn = rotation(step[:3]) @ state.turn
        shift = rotation(step[:3]) @ state.shift + size * step[3:]
        near = float(np.abs(step).max()) < 1e-3
        return self.state(turn, shift, state.feet if near else None)

    def _step(self, state: _Placement, size: float) -> tuple[Floats, tuple[int, ...]]:
        """The step (rotation vector, translation over the size) and the free motions that have no effect."""
        feet = state.feet
        placed = (state.turn @ self.x + state.shift[:, None])[:, state.kept]
        n = feet.n[:, state.kept]
        jacobian = np.vstack([np.cross(placed, n, axis=0) / size, n]).T[:, list(self.free)]
        values, vectors = np.linalg.eigh(jacobian.T @ jacobian)
        strong = values > WEAK**2 * len(jacobian)
        use = jacobian @ vectors[:, strong]
        solution = np.linalg.lstsq(use, -state.deviation[state.kept] / size, rcond=None)[0]
        step = np.zeros(6)
        step[list(self.free)] = vectors[:, strong] @ solution
        lost = (vectors[:, ~strong] ** 2).sum(axis=1)
        return step, tuple(k for k, share in zip(self.free, lost) if share > 0.5)


def _refuse(registration: _Registration, best: _Placement) -> None:
    """Raise ProfileError where points do not belong to the cam, or belong to its mirror image."""
    mirrored = replace(registration, x=registration.x * np.array([1.0, -1.0, 1.0])[:, None])
    hint = False
    # Points that lie nowhere near the flanks are not searched for twice.
    if best.beyond <= MOST_BEYOND or mirrored.starts()[1] < 0.8 * registration.starts()[1]:
        try:
            other = mirrored.solved()
            hint = not other.foreign and other.rms < 0.2 * best.rms
        except NotConverged:
            hint = False  # its mirror image fits no better
    if not (hint or best.foreign):
        return
    amount = f"rms {best.rms:.4g} mm" if best.beyond <= MOST_BEYOND else f"{best.beyond:.0%} lie beyond the flanks"
    advice = "look at profile, units (mm), probe radius and the frame (Z along the cam axis)"
    if hint:
        advice = "they fit its mirror image: look at the direction or hand of the profile"
    raise ProfileError([Problem("points", f"do not belong to this cam ({amount} after the best fit); {advice}")])


def _about_z(angle: float) -> Floats:
    return rotation(np.array([0.0, 0.0, angle]))


def rotation(vector: Floats) -> Floats:
    """Rotation matrix of a rotation vector, rad (Rodrigues)."""
    angle = float(np.sqrt(vector @ vector))
    x, y, z = vector
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    # sin(a) / a and (1 - cos(a)) / a², both good at small angles.
    first = float(np.sinc(angle / np.pi))
    second = 0.5 * float(np.sinc(0.5 * angle / np.pi)) ** 2
    return np.asarray(np.eye(3) + first * cross + second * (cross @ cross))
