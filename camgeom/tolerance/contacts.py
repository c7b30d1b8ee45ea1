"""Where a follower touches its cam over a turn, line by line: points, normals and levers in the machine frame.

A line is one wall of one roller (or face) at one place beside the cam. The envelope of the nominal roller touches it
at stations from end to end of the stretch that has a wall; between errors of the first order nothing else is needed.

Arrays: n cam angles, l lines, m stations. Stations are Gauss-Lobatto nodes: both ends, which decide where lines tilt,
and an integral along the line of degree 2 m - 3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np
import numpy.typing as npt

from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.maths.frozen import cached_property
from camgeom.maths.surface import cross
from camgeom.solid.mechanism import Drive, Mechanism
from camgeom.track import TURN, Slide, Swing, Track
from camgeom.track.flank import Flank
from camgeom.track.runout import touching
from camgeom.track.turret import Engagement

if TYPE_CHECKING:
    from camgeom.track.touch import Touch

Bools = npt.NDArray[np.bool_]
NODES = np.array([-1.0, -0.830223896278567, -0.468848793470714, 0.0, 0.468848793470714, 0.830223896278567, 1.0])
WEIGHTS = np.array([1.0 / 21.0, 0.276826047361566, 0.431745381209863, 0.487619047619048, 0.431745381209863,
                    0.276826047361566, 1.0 / 21.0])  # fmt: skip
"""Gauss-Lobatto quadrature of seven points on -1 .. 1 (Abramowitz and Stegun, table 25.6)"""
M = len(NODES)
DEAD = 1e-9
"""mm/rad (1 on a slide), share of the largest lever below which a wall drives nothing"""


@final
@immutable
class Contacts:
    """Every line of contact of a mechanism at cam angles theta (n,), rad, machine frame, the follower at its program.

    on        whether a station has a wall, (n, l, m)
    x, normal points and unit normals into the cam, mm, (3, n, l, m)
    lever     velocity of the contact along the normal per unit of the joint coordinate, 1 or mm/rad, (n, l, m): below
              zero on a wall that pushes towards larger lift, above on one that holds
    gap       free distance of the nominal follower from the wall, mm, below zero where it is pressed in, (n, l, m)
    length    share of the line that a station stands for, mm, (n, l, m)
    curvature relative curvature across the line, 1/mm, (n, l, m); infinite below a knife edge
    roller    number of the roller on its follower at the first stop, (l,); wall: of the cam's flank, (l,)
    lag       cam angle, rad, after which the line meets what the first line on its wall met, (l,)
    centre, axis   middle of the roller's contact stretch and its direction, (3, n, l)
    turned    how far the follower has turned or moved by its program, rad or mm, (n,)
    """

    mechanism: Mechanism
    theta: Floats
    on: Bools
    x: Floats
    normal: Floats
    lever: Floats
    gap: Floats
    length: Floats
    curvature: Floats
    roller: npt.NDArray[np.intp]
    wall: npt.NDArray[np.intp]
    lag: Floats
    centre: Floats
    axis: Floats
    turned: Floats
    joint: Slide | Swing
    rollers: int

    @cached_property
    def radius(self) -> float:
        """Radius of the rollers in the middle of their contact, mm; infinite of a flat face, 0 of a knife edge."""
        tracks = lines_of(self.mechanism)
        if not tracks:
            return self.mechanism.touches[0].radius
        meridian = tracks[0].meridian
        return float(meridian.jet(np.array([meridian.parameter(0.5 * sum(tracks[0].contact))]))[3][0])

    @cached_property
    def round(self) -> Floats:
        """How far round the cam the first line on each wall is, (n,), rad: the cam angle; of a cam that slides, which
        meets the same flank out and back, its travel with the stroke as a turn."""
        carriage = self.mechanism.carriage
        return self.theta if carriage is None else carriage.travel(self.theta) * (TURN / carriage.stroke)

    @cached_property
    def pushes(self) -> Bools:
        """Which stations push towards larger lift, (n, l, m)."""
        return np.asarray(self.on & (self.lever < 0.0))

    @cached_property
    def holds(self) -> Bools:
        """Which stations hold the follower back, (n, l, m)."""
        return np.asarray(self.on & (self.lever > 0.0))


def lines_of(mechanism: Mechanism) -> tuple[Track, ...]:
    """The tracks whose rollers touch, with the shape that touches: a turret's bearing ones, else the mechanism's."""
    tracks = mechanism.turret.bearing if mechanism.turret is not None else mechanism.tracks
    return tuple(map(mechanism.cutting, tracks))


def contacts(mechanism: Mechanism, theta: Floats) -> Contacts:
    """The lines of contact of a mechanism at cam angles theta (n,), rad. Raises DesignError where there are none."""
    tracks = lines_of(mechanism)
    return _of_rollers(mechanism, tracks, theta) if tracks else _of_faces(mechanism, mechanism.touches, theta)


@final
class _Sheet:
    """Arrays that grow line by line."""

    def __init__(self, n: int, lines: int) -> None:
        self.on = np.zeros((n, lines, M), dtype=bool)
        self.x, self.normal = np.zeros((3, n, lines, M)), np.zeros((3, n, lines, M))
        self.lever, self.gap = np.ones((n, lines, M)), np.zeros((n, lines, M))
        self.length, self.curvature = np.zeros((n, lines, M)), np.ones((n, lines, M))
        self.centre, self.axis = np.zeros((3, n, lines)), np.zeros((3, n, lines))


def _of_rollers(mechanism: Mechanism, tracks: tuple[Track, ...], theta: Floats) -> Contacts:
    within = mechanism.within if mechanism.turret is not None else mechanism.beside
    shared = mechanism.drive is Drive.SHARED
    each = tuple((index, 0) for index in range(len(tracks)))
    places = Engagement(tracks, mechanism.within, theta).places if shared else each
    lines = [(index, turn, side) for index, turn in places for side in tracks[index].sides]
    sheet = _Sheet(len(theta), len(lines))
    rollers, walls, lags = [], [], []
    names = list(dict.fromkeys(track.name for track in tracks))
    for line, (index, turn, side) in enumerate(lines):
        track = tracks[index]
        phi = theta + TURN * turn
        rows = np.flatnonzero((phi >= track.span[0]) & (phi <= track.span[1])) if shared else np.arange(len(theta))
        rollers.append(_number(mechanism, tracks, index, turn))
        walls.append(0 if mechanism.lags else 2 * names.index(track.name) + (side < 0.0))
        lags.append(mechanism.lags[index] if mechanism.lags else 0.0)
        if not len(rows):
            continue
        whole = np.array([track.meridian.parameter(d) for d in sorted(track.contact)])
        pose = track.eased(side).pose(phi[rows], 2)
        crest = bool(mechanism.rollers) and mechanism.rollers[min(index, len(mechanism.rollers) - 1)].arc is not None
        if crest:
            # A crowned roller touches a straight flank at its crest alone.
            begin = stop = np.full(len(rows), track.meridian.centre)
        elif within is None:
            begin, stop = np.full(len(rows), whole[0]), np.full(len(rows), whole[1])
        else:
            begin, stop = touching(track, side, phi[rows], within, pose)
        t = 0.5 * (begin + stop)[:, None] + 0.5 * (stop - begin)[:, None] * NODES
        flank = Flank(track, phi[rows], t, side, given_pose=pose)
        back = np.conj(flank.pose.turn)
        slid = 0.0 if pose.slid is None else pose.slid
        sheet.x[:, rows, line], sheet.normal[:, rows, line] = _machine(flank.x, back), _machine(flank.n, back)
        sheet.x[0, rows, line] -= np.reshape(slid, (-1, 1))
        lever = flank.lever()
        sheet.lever[rows, line] = lever
        there = stop > begin
        if crest:
            there = np.ones(len(rows), dtype=bool) if within is None else within(flank.x[..., M // 2]) >= 0.0
        sheet.on[rows, line] = there[:, None] & (np.abs(lever) > DEAD * np.abs(lever).max())
        along = np.abs(track.meridian.jet(stop)[0] - track.meridian.jet(begin)[0])
        whole_length = max(track.contact) - min(track.contact)
        sheet.length[rows, line] = whole_length / M if crest else 0.5 * along[:, None] * WEIGHTS
        sheet.curvature[rows, line] = flank.k_rel
        middle = 0.5 * sum(track.contact)
        axis = _machine(flank.pose.u[0], back)
        sheet.axis[:, rows, line] = axis
        sheet.centre[:, rows, line] = _machine(flank.pose.a[0], back) + middle * axis
        sheet.centre[0, rows, line] -= slid
        sheet.gap[rows, line] = _gap(mechanism, index, lever, sheet.normal[0, rows, line], phi[rows])
    return Contacts(
        mechanism, theta, sheet.on, sheet.x, sheet.normal, sheet.lever, sheet.gap, sheet.length, sheet.curvature,
        np.array(rollers), np.array(walls), np.array(lags), sheet.centre, sheet.axis,
        mechanism.program.jet(theta, 0)[0],
        tracks[0].joint, _count(mechanism, tracks),
    )  # fmt: skip


def _count(mechanism: Mechanism, tracks: tuple[Track, ...]) -> int:
    return mechanism.turret.follower.count if mechanism.turret is not None else len(tracks)


def _number(mechanism: Mechanism, tracks: tuple[Track, ...], index: int, turn: int) -> int:
    """Number of the roller that runs on a track some turns from now, counted round the turret in the first dwell."""
    turret, track = mechanism.turret, tracks[index]
    if turret is None:
        return index
    pitch = TURN / turret.follower.count
    angle = track.shift - tracks[0].shift + track.factor * track.program.advance * turn
    return round(angle / pitch) % turret.follower.count


def _gap(mechanism: Mechanism, index: int, lever: Floats, across: Floats, phi: Floats) -> Floats:
    """Free distance of the nominal roller from its wall, mm: running clearance, relief, play, less the preload."""
    gap = np.full(lever.shape, mechanism.running_clearance)
    if mechanism.turret is not None:
        # A turret set closer by the shift moves its rollers against X by it (crossed axes; others have no preload).
        gap += mechanism.allowed_interference * across
        relief = mechanism.cutters[index].relief if mechanism.turret.relief else None
        if relief is not None:
            gap += np.abs(lever) * np.abs(relief.jet(phi, 0)[0])[:, None]
        return gap
    return gap + np.where(lever > 0.0, lever * _play(mechanism), 0.0)


def _play(mechanism: Mechanism) -> float:
    """Play of a follower of its own, by its coordinate, mm or rad: from the wall that pushes to the one that holds."""
    tracks = mechanism.tracks
    if len(tracks) == 2 and isinstance(tracks[0].joint, Swing):
        return tracks[1].shift - tracks[0].shift
    return mechanism.follower.clearance


def _of_faces(mechanism: Mechanism, touches: tuple[Touch, ...], theta: Floats) -> Contacts:
    """Flat faces and knife edges of planar cams: lines along the cam's axis, as long as they touch."""
    sheet = _Sheet(len(theta), len(touches))
    back = np.exp(1j * mechanism.sense * theta)
    half = 0.5 * touches[0].length
    z = 0.5 * mechanism.width + half * NODES
    for line, touch in enumerate(touches):
        at = touch.at(theta)
        x = np.stack([*at.curve.points, np.zeros_like(theta)])
        into = np.stack([*(-touch.material * at.curve.normals), np.zeros_like(theta)])
        sheet.x[:, :, line] = _machine(x, back)[:, :, None]
        sheet.x[2, :, line] = z
        sheet.normal[:, :, line] = _machine(into, back)[:, :, None]
        sheet.lever[:, line] = -at.lever[:, None]
        sheet.on[:, line] = True
        sheet.length[:, line] = half * WEIGHTS
        sheet.curvature[:, line] = at.relative[:, None]
        sheet.gap[:, line] = np.where(at.lever < 0.0, mechanism.follower.clearance, 0.0)[:, None]
        sheet.axis[2, :, line] = 1.0
        sheet.centre[:, :, line] = _reference(mechanism, touch, sheet.x[:, :, line])
    lines = np.arange(len(touches))
    lag = np.array([touch.lag for touch in touches])
    walls = np.zeros_like(lines) if mechanism.lags else lines
    return Contacts(
        mechanism, theta, sheet.on, sheet.x, sheet.normal, sheet.lever, sheet.gap, sheet.length, sheet.curvature,
        lines, walls, lag, sheet.centre, sheet.axis, mechanism.program.jet(theta, 0)[0], touches[0].joint, len(touches),
    )  # fmt: skip


def _reference(mechanism: Mechanism, touch: Touch, x: Floats) -> Floats:
    """Where a face turns that stands askew: on the follower's line, on an arm at its pivot; a knife edge on itself."""
    place = x[:, :, M // 2].copy()
    if touch.kind == "flat":
        if isinstance(touch.joint, Swing):
            place[:2] = np.array(touch.joint.centre[:2])[:, None]
        else:
            place[1] = mechanism.follower.offset
    return place


def _machine(vectors: Floats, back: npt.NDArray[np.complex128]) -> Floats:
    """Vectors of the cam frame (3, n, ...) in the machine frame; back (n,) turns them by the cam's angle."""
    shape = (-1, *([1] * (vectors.ndim - 2)))
    z = (vectors[0] + 1j * vectors[1]) * back.reshape(shape)
    return np.stack([z.real, z.imag, np.broadcast_to(vectors[2], z.shape)])


def moment(contacts: Contacts, about: Floats) -> Floats:
    """Moment of the unit normals about a point (3,) or (3, n, l), mm, (3, n, l, m)."""
    away = about[:, None, None, None] if about.ndim == 1 else about[..., None]
    return cross(contacts.x - away, contacts.normal)

