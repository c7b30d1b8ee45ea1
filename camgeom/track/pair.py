"""Residual of a conjugate pair: the gap left at the return roller when parts are not as drawn.

The discs are cut as designed. The follower, with its errors of centre distance, arm angle and roller radii, rests with
its main roller on the main disc; what is left between return roller and return disc is the residual: zero (or the
play asked for) everywhere for perfect parts, negative where the pair jams.

Both contacts are exact: the main one solves B(q) = C(u) + d n(u) for joint coordinate and foot point by Newton's
method, the return one the foot point of the roller's centre on its pitch curve; all angles at once.
"""

from __future__ import annotations

from math import radians, sqrt
from typing import final

import numpy as np
import numpy.typing as npt

from camgeom.errors import NotConverged
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.track import Slide, Straight, Swing, Track

Complexes = npt.NDArray[np.complex128]

STEPS = 40
SMALL = 1e-13
"""share of the pitch curve's size to which foot points are found"""
FARTHEST = 0.05
"""rad; longest Newton step of a foot point, so that none strays over a jump of curvature"""


@final
@immutable(eq=True)
class PairErrors:
    """Deviations of a pair from its drawing: what the assembled follower has more than it should.

    centre_distance  mm, of the pivot (slide: of its guide along the motion, which changes nothing)
    arm_angle        deg, between the arms (slide: meaningless, 0)
    main_roller      mm, radius
    return_roller    mm, radius
    spread           mm, of the return roller's centre away from the main one's along a slide (rocker: of its arm)
    """

    centre_distance: float = 0.0
    arm_angle: float = 0.0
    main_roller: float = 0.0
    return_roller: float = 0.0
    spread: float = 0.0


@final
@immutable
class PairResidual:
    """The gap at the return roller round the turn, (n,) mm at cam angles phi; and the follower's real position.

    gap       along the common normal, mm: positive where the return roller stands off
    position  joint coordinate at which the main roller rests, mm or rad
    """

    phi: Floats
    gap: Floats
    position: Floats

    @property
    def least(self) -> float:
        """Smallest gap, mm; negative where the pair jams."""
        return float(self.gap.min())

    @property
    def spread(self) -> float:
        """Largest less smallest gap, mm: what no setting of the clearance takes away."""
        return float(np.ptp(self.gap))


def pair_residual(main: Track, back: Track, phi: Floats, errors: PairErrors | None = None) -> PairResidual:
    """The residual of a pair of tracks (main and return roller on one joint) at cam angles phi (n,).

    Raises NotConverged where the follower finds no rest on the main disc.
    """
    given = errors or PairErrors()
    phi = np.asarray(phi, dtype=float)
    one, two = _Roller.of(main, given, False), _Roller.of(back, given, True)
    q, _ = _rest(main, one, phi, given.main_roller)
    turn = np.exp(-1j * main.sense * phi)
    gap = _stand_off(back, turn * two.centre(q), phi) - given.return_roller
    if isinstance(back.meridian, Straight):
        # Beside a disc that leans the common normal does too.
        gap /= sqrt(1.0 + back.meridian.slope**2)
    return PairResidual(phi, gap, q)


@immutable(eq=True)
class _Roller:
    """The centre of a roller on the real follower: pivot + arm exp(i way q), or start + q along +X; complex, mm."""

    pivot: complex
    arm: complex
    way: float

    @classmethod
    def of(cls, track: Track, errors: PairErrors, returning: bool) -> _Roller:
        start = complex(track.anchor[0], track.anchor[1])
        joint = track.joint
        if isinstance(joint, Slide):
            return cls(start - (errors.spread if returning else 0.0), 0j, 0.0)
        assert isinstance(joint, Swing)
        pivot, way = complex(joint.centre[0], joint.centre[1]), joint.axis[2]
        arm = start - pivot
        if returning:
            arm *= (1.0 + errors.spread / abs(arm)) * np.exp(-1j * way * radians(errors.arm_angle))
        return cls(pivot + errors.centre_distance, arm, way)

    def centre(self, q: Floats) -> Complexes:
        """Where the roller's centre stands."""
        moved = self.pivot + self.arm * np.exp(1j * self.way * q) if self.way else self.pivot + q
        return np.asarray(moved, dtype=complex)

    def rate(self, q: Floats) -> Complexes:
        """Its derivative by the joint coordinate."""
        moved = 1j * self.way * self.arm * np.exp(1j * self.way * q) if self.way else np.ones_like(q)
        return np.asarray(moved, dtype=complex)


def _curve(track: Track, u: Floats) -> tuple[Complexes, Complexes, Complexes]:
    """Pitch curve and two derivatives by the cam angle."""
    jet = track.pose(u, 2).a
    c, d, dd = (jet[k, 0] + 1j * jet[k, 1] for k in range(3))
    return c, d, dd


def _outward(track: Track, d: Complexes) -> Complexes:
    """Unit normal out of the disc: the follower travels round it against its turning."""
    return np.asarray(1j * track.sense * d / np.abs(d))


def _rest(track: Track, roller: _Roller, phi: Floats, more: float) -> tuple[Floats, Floats]:
    """Joint coordinate and foot point (n,) at which a roller larger by `more` rests on the disc."""
    turn = np.exp(-1j * track.sense * phi)
    q, u = track.coordinate(phi, 0)[0], phi.copy()
    size = float(np.abs(track.anchor).max())
    for _ in range(STEPS):
        c, d, dd = _curve(track, u)
        n = _outward(track, d)
        bend = (np.conj(d) * dd).imag / np.abs(d) ** 2
        miss = turn * roller.centre(q) - c - more * n
        # The normal turns with the tangent, at the rate `bend`: n' = i bend n.
        along, push = -(d + more * 1j * bend * n), turn * roller.rate(q)
        det = along.real * push.imag - along.imag * push.real
        du = (-miss.real * push.imag + miss.imag * push.real) / det
        dq = (-along.real * miss.imag + along.imag * miss.real) / det
        step = np.clip(du, -FARTHEST, FARTHEST)
        u, q = u + step, q + dq * np.where(du != 0.0, step / np.where(du != 0.0, du, 1.0), 1.0)
        if np.abs(miss).max() <= SMALL * size:
            return q, u
    worst = int(np.argmax(np.abs(miss)))
    raise NotConverged(
        f"the main roller finds no rest on its disc at cam angle {np.degrees(phi[worst]):.6g} deg (still "
        f"{abs(miss[worst]):.3g} mm off): the errors are too large for this mechanism"
    )


def _stand_off(track: Track, point: Complexes, phi: Floats) -> Floats:
    """Signed distance of points (n,) from the pitch curve along its normal, mm, positive outside."""
    u = phi.copy()
    for _ in range(STEPS):
        c, d, dd = _curve(track, u)
        off = point - c
        slope = (np.conj(d) * off).real
        step = slope / (np.abs(d) ** 2 - (np.conj(dd) * off).real)
        u = u + np.clip(step, -FARTHEST, FARTHEST)
        if np.abs(step).max() <= 1e-12:
            break
    else:
        raise NotConverged("the return roller has no foot point on its pitch curve: the errors are too large")
    c, d, _ = _curve(track, u)
    return np.asarray((np.conj(_outward(track, d)) * (point - c)).real)
