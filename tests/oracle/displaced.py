"""A displaced follower against a displaced cam, by search: no normals, no envelope equation, nothing linear.

The cam's material is every point farther from each place of a roller's axis over the turn than the roller's radius
(flat faces: behind every place of the face; knife edges: within the path of the edge). Cam, follower or roller are
moved rigidly, and the coordinate at which one circle of the roller (one point of a face or edge) first touches the
material is sought. Followers are placed from the profile's keys; lengths mm, angles rad, machine frame.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import acos, asin, cos, pi, radians, sin, sqrt, tan

import numpy as np

TURN = 2.0 * pi
ZERO = np.zeros(3)


@dataclass(frozen=True)
class Moved:
    """Errors, mm and rad: rigid moves are (shift, turn, pivot), the roller's own ones by name.

    ahead  of the drive of a plate that slides
    """

    cam: tuple = (ZERO, ZERO, ZERO)
    cam_turning: tuple = (ZERO, ZERO, ZERO)
    follower: tuple = (ZERO, ZERO, ZERO)
    turret: tuple = (ZERO, ZERO)
    diameter: float = 0.0
    angle: float = 0.0
    radius: float = 0.0
    axial: float = 0.0
    tilt: tuple = (0.0, 0.0)
    squareness: float = 0.0
    growth: float = 0.0
    ahead: float = 0.0


@dataclass(frozen=True)
class Follower:
    """place(k, q): a point of the roller's axis (delta = 0) and its direction at coordinate q; line(k, phi): q.

    joint  ("slide", direction) or ("swing", axis, centre); middle: of the contact along the axis; radius, slope, centre
    of the meridian; way: e_c of a turret's line of centres; travel(phi): how far a plate is out that slides along -X
    """

    sense: float
    lift: object
    joint: tuple
    home: object
    middle: float
    radius: float
    slope: float = 0.0
    centre: float = 0.0
    kind: str = "roller"
    shift: object = field(default=lambda k: 0.0)
    gap: float = 0.0
    base: float = 0.0
    travel: object = None

    def seen(self, x, phi):
        """Machine points as the cam sees them at a cam angle."""
        return cam_frame(x, phi, self.sense) if self.travel is None else _slid(x, self.travel(phi))

    def machine(self, x, phi):
        """The other way."""
        return machine(x, phi, self.sense) if self.travel is None else _slid(x, -self.travel(phi))

    def coordinate(self, phi, k):
        """Joint coordinate of roller k."""
        return self.lift(phi) + self.shift(k)


def turned(x, axis, angle):
    """Points (..., 3) turned about a unit axis by angles that broadcast (Rodrigues)."""
    angle = np.asarray(angle)[..., None]
    along = x @ np.outer(axis, axis)
    return along + (x - along) * np.cos(angle) - x @ _across(axis) * np.sin(angle)


def _across(v):
    """Matrix of the vector product from the left: x @ it is x cross v, at a fifth of what np.cross takes."""
    a, b, c = v
    return np.array([[0.0, -c, b], [c, 0.0, -a], [-b, a, 0.0]])


def rigid(x, move, inverse=False):
    """Points moved by (shift, rotation vector, pivot), exactly."""
    shift, omega, pivot = (np.asarray(part, float) for part in move)
    size = float(np.linalg.norm(omega))
    if inverse:
        x = x - shift
        return x if size == 0.0 else pivot + turned(x - pivot, omega / size, -size)
    return (x if size == 0.0 else pivot + turned(x - pivot, omega / size, size)) + shift


def carried(follower, k, q):
    """Axis point and direction of roller k at its coordinate q (...): (..., 3) each."""
    a, u = follower.home(k)
    if follower.joint[0] == "slide":
        return a + np.asarray(q)[..., None] * follower.joint[1], np.broadcast_to(u, (*np.shape(q), 3))
    axis, centre = follower.joint[1:]
    c, s = np.cos(q)[..., None], np.sin(q)[..., None]
    (a0, a1, a2), (u0, u1, u2) = (
        (along := (v @ axis) * axis, v - along, axis @ _across(v)) for v in (np.asarray(a - centre), np.asarray(u))
    )
    return centre + a0 + c * a1 + s * a2, u0 + c * u1 + s * u2


def cam_frame(x, phi, sense):
    """Machine points as the cam sees them that has turned by sense * phi."""
    c, s = np.cos(sense * phi), np.sin(sense * phi)
    return np.stack(np.broadcast_arrays(c * x[..., 0] + s * x[..., 1], c * x[..., 1] - s * x[..., 0], x[..., 2]), -1)


def machine(x, phi, sense):
    """The other way."""
    return cam_frame(x, -phi, sense)


def _slid(x, along):
    """Points moved along X."""
    return x + np.stack(np.broadcast_arrays(along, 0.0, 0.0), -1)


def _least(f, centre, wide, coarse, steps=(0.02, 0.0004)):
    """Least value of f about centre (...) within +-wide, and where: samples, then vertices of ever closer parabolas."""
    grid = centre[..., None] + wide * np.linspace(-1.0, 1.0, coarse)
    value = f(grid)
    i = np.argmin(value, -1)[..., None]
    at, best = np.take_along_axis(grid, i, -1)[..., 0], np.take_along_axis(value, i, -1)[..., 0]
    for step in (2.0 * wide / (coarse - 1), *(step * wide for step in steps)):
        a, b, c = np.moveaxis(f(at[..., None] + step * np.array([-1.0, 0.0, 1.0])), -1, 0)
        bend = a - 2.0 * b + c
        move = np.where(bend > 0.0, 0.5 * (a - c) / np.where(bend > 0.0, bend, 1.0), 0.0)
        at = at + step * np.clip(move, -1.0, 1.0)
    found = f(at[..., None])[..., 0]
    return np.minimum(found, best), at


def beyond(follower, k, x, near, wide=0.3, coarse=31):
    """How deep points (..., 3) of the cam frame lie in the material, mm: least over cam angles about `near` (...)."""
    return _least(lambda phi: clear(follower, k, x[..., None, :], phi), near, wide, coarse)[0]


def clear(follower, k, x, phi):
    """Distance of points of the cam frame from the nominal follower at cam angles phi."""
    m = follower.machine(x, phi)
    a, u = carried(follower, k, follower.coordinate(phi, k))
    d = m - a
    if follower.kind == "flat":
        return -np.einsum("...i,...i->...", d, face_normal(follower, k, phi)) + follower.gap * (k == 1)
    axial = np.einsum("...i,...i->...", d, u)
    across = np.sqrt(np.maximum(np.einsum("...i,...i->...", d, d) - axial**2, 0.0))
    wall = across - follower.radius - follower.slope * (axial - follower.centre)
    return wall / sqrt(1.0 + follower.slope**2)


def face_normal(follower, k, phi):
    """Unit vector out of the cam across a flat face."""
    outward = follower.base(k) if callable(follower.base) else np.array([1.0, 0.0, 0.0])
    if follower.joint[0] == "slide":
        return outward
    q = follower.coordinate(phi, k)
    return turned(np.broadcast_to(outward, (*np.shape(q), 3)), follower.joint[1], q)


def circle(follower, k, theta, psi, delta, chi, moved, frame):
    """Points of the displaced roller's surface in the displaced cam's frame: all arguments broadcast."""
    q = follower.coordinate(theta, k) + psi + moved.angle
    a, u = carried(follower, k, q)
    a, u = _own(follower, a, u, q, moved, frame)
    side = np.cross(u, frame[0])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    other = np.cross(side, u)
    r = follower.radius + follower.slope * (delta - follower.centre) + 0.5 * moved.diameter
    m = a + delta[..., None] * u + r[..., None] * (np.cos(chi)[..., None] * other + np.sin(chi)[..., None] * side)
    return _seen(m, theta, follower, moved)


def _seen(m, theta, follower, moved):
    m = rigid(m, moved.follower)
    x = follower.seen(rigid(m, moved.cam, inverse=True), theta + moved.ahead)
    return rigid(x, moved.cam_turning, inverse=True)


def _own(follower, a, u, q, moved, frame):
    """The roller's own errors: radius, axial place, tilt, and those of the turret that carries it."""
    mid = a + follower.middle * u
    if follower.joint[0] == "swing":
        axis, centre = (np.asarray(v, float) for v in follower.joint[1:])
        away = mid - centre
        away = away - (away @ axis)[..., None] * axis
        away = away / np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-300)
        motion = np.cross(axis, away)
        a = a + moved.radius * away + moved.axial * axis
        shift, omega = (np.asarray(v, float) for v in moved.turret)
        if shift.any() or omega.any():
            # fixed in the turret: given at coordinate lift = 0
            lift = (q - moved.angle) - frame[1]
            a = a + turned(np.broadcast_to(shift, a.shape), axis, lift)
            w = turned(np.broadcast_to(omega, a.shape), axis, lift)
            size = float(np.linalg.norm(omega))
            if size:
                a, u = centre + _spun(a - centre, w / size, size), _spun(u, w / size, size)
    else:
        motion = np.broadcast_to(np.asarray(follower.joint[1], float), u.shape)
        a = a + moved.axial * u
    if any(moved.tilt):
        motion = motion - np.einsum("...i,...i->...", motion, u)[..., None] * u
        motion = motion / np.linalg.norm(motion, axis=-1, keepdims=True)
        lean = np.cross(u, motion)
        omega = moved.tilt[0] * lean + moved.tilt[1] * np.cross(lean, u)
        size = float(np.hypot(*moved.tilt))
        mid = a + follower.middle * u
        u2 = _spun(u, omega / size, size)
        a, u = mid - follower.middle * u2, u2
    return a, u


def _spun(x, axis, angle):
    """Rodrigues with an axis for each point."""
    along = np.einsum("...i,...i->...", x, axis)[..., None] * axis
    return along + (x - along) * cos(angle) + np.cross(axis, x) * sin(angle)


@dataclass(frozen=True)
class Touching:
    """Circles delta of roller k, for theta, delta (...), and how they touch the wall where nothing is displaced.

    wall  (...) +1: the wall that pushes towards larger coordinates, -1: the one that holds back
    chi, slope (...): where round the circle, and change of the depth there with the coordinate
    """

    follower: Follower
    k: int
    theta: np.ndarray
    delta: np.ndarray
    frame: tuple
    chi: np.ndarray
    slope: np.ndarray

    @classmethod
    def at(cls, follower, k, theta, delta, wall, frame):
        """The circles' nominal contact."""
        zero, unit = np.zeros_like(theta), 1e-3 if follower.joint[0] == "slide" else 1e-5
        free = cls(follower, k, theta, delta, frame, _sides(follower, k, theta, delta, frame, wall, unit), zero)
        chi = free.deepest(zero, free.chi, 0.06, Moved())[1]
        more, less = (free.deepest(zero + way * unit, chi, 0.02, Moved())[0] for way in (1.0, -1.0))
        return replace(free, chi=chi, slope=(more - less) / (2.0 * unit))

    def deepest(self, psi, chi, width, moved):
        """Depth in the material at coordinates off by psi, and where round the circles, sought near chi."""

        def shallow(grid):
            x = circle(self.follower, self.k, self.theta[..., None], psi[..., None], self.delta[..., None], grid, moved,
                       self.frame)  # fmt: skip
            return -beyond(self.follower, self.k, x, np.broadcast_to(self.theta[..., None], grid.shape))

        value, at = _least(shallow, chi, width, 7)
        return moved.growth - value, at

    def deviation(self, moved):
        """Of the coordinate, (...), at which the displaced circles first touch."""
        psi0 = np.zeros_like(self.theta)
        f0, c = self.deepest(psi0, self.chi, 0.02, moved)
        # A secant from the answer that the nominal lever gives.
        slope, psi1 = self.slope, -f0 / self.slope
        for _ in range(6):
            f1, c = self.deepest(psi1, c, 0.004, moved)
            if np.abs(f1).max() < 1e-9:
                break
            change = f1 - f0
            slope = np.where(np.abs(psi1 - psi0) > 1e-13, change / np.where(psi1 == psi0, 1.0, psi1 - psi0), slope)
            psi0, f0, psi1 = psi1, f1, psi1 - f1 / slope
        assert np.abs(f1).max() < 1e-7, np.abs(f1).max()
        return psi1


def _sides(follower, k, theta, delta, frame, wall, unit):
    """Where round the circle the wanted wall is: the nominal roller touches there, and yields the right way."""
    grid = np.linspace(-pi, pi, 241)[:-1]
    shape = (*theta.shape, len(grid))
    t, d, chi = (np.broadcast_to(v, shape) for v in (theta[..., None], delta[..., None], grid))

    def depth(psi):
        x = circle(follower, k, t, np.full(shape, psi), d, chi, Moved(), frame)
        return beyond(follower, k, x, t)

    value, slope = depth(0.0), depth(unit) - depth(-unit)
    deepest = np.argmax(np.where(wall[..., None] * slope < 0.0, value, -1e9), -1)[..., None]
    return np.take_along_axis(chi, deepest, -1)[..., 0]


def face_contact(follower, k, theta, z, moved, wide=100.0):
    """Deviation at which a flat face first touches at height z: its points beside the cam are searched."""

    def deepest(psi):
        def shallow(grid):
            x = _face_points(follower, k, theta[..., None], psi[..., None], z[..., None], grid, moved)
            return -beyond(follower, k, x, np.broadcast_to(theta[..., None], grid.shape), wide=0.6, coarse=61)

        return moved.growth - _least(shallow, np.zeros_like(theta), wide, 41)[0]

    unit = 1e-3 if follower.joint[0] == "slide" else 1e-5
    psi0 = np.zeros_like(theta)
    f0 = deepest(psi0)
    psi1 = psi0 + unit
    for _ in range(10):
        f1 = deepest(psi1)
        if np.abs(f1).max() < 1e-9:
            break
        slope = (f1 - f0) / np.where(psi1 == psi0, 1.0, psi1 - psi0)
        psi0, f0, psi1 = psi1, f1, np.where(np.abs(f1) < 1e-12, psi1, psi1 - f1 / np.where(slope == 0.0, 1.0, slope))
    assert np.abs(f1).max() < 1e-7, np.abs(f1).max()
    return psi1


def _face_points(follower, k, theta, psi, z, y, moved):
    q = follower.coordinate(theta, k) + psi + moved.angle
    a, _ = carried(follower, k, q)
    outward = face_normal(replace(follower, lift=lambda _: q), k, theta)
    up = np.array([0.0, 0.0, 1.0])
    pivot = a if follower.joint[0] == "slide" else np.broadcast_to(np.asarray(follower.joint[2], float), a.shape)
    pivot = np.concatenate([pivot[..., :2], np.full((*pivot.shape[:-1], 1), follower.middle)], -1)
    # along the face, from the follower's reference point; tilts turn about that at mid height
    along = np.cross(up, outward)
    base = a + follower.gap * (k == 1) * outward
    m = base + y[..., None] * along + np.stack(np.broadcast_arrays(0.0 * z, 0.0 * z, z), -1)
    if any(moved.tilt):
        motion = -np.broadcast_to(outward, m.shape)
        lean = np.cross(up, motion)
        omega = moved.tilt[0] * lean + moved.tilt[1] * np.cross(lean, up)
        size = float(np.hypot(*moved.tilt))
        m = pivot + _spun(m - pivot, np.broadcast_to(omega / size, m.shape), size)
    if moved.squareness:
        m = pivot + turned(m - pivot, up, np.broadcast_to(moved.squareness, m.shape[:-1]))
    return _seen(m, theta, follower, moved)


def followers_of(data, lift, low, high):
    """The follower of a profile's plain tables, placed from its keys."""
    cam = data["cam"]
    return _KINDS[cam["kind"]](cam, data["follower"], data.get("roller"), lift, low, high)


def _sense(cam):
    return -1.0 if cam.get("direction") == "cw" else 1.0


def _slope(roller, inward):
    if roller.get("shape") != "cone":
        return 0.0
    return tan(radians(roller["half_angle"])) * (1.0 if inward else -1.0)


def _planar(cam, follower, roller, lift, low, high):
    del low, high
    face = follower.get("face", "roller")
    r = {"roller": 0.5 * (roller or {}).get("diameter", 0.0), "curved": follower.get("face_radius", 0.0)}.get(face, 0.0)
    prime, width, sense = cam["base_radius"] + r, cam["width"], _sense(cam)
    depth = cam.get("groove_depth", width)
    length = min(depth, (roller or {}).get("length", depth))
    middle = cam["width"] - 0.5 * length if cam.get("form") == "groove" else 0.5 * width
    z = np.array([0.0, 0.0, 1.0])
    if follower["kind"] == "translating":
        e = follower.get("offset", 0.0)
        joint = ("slide", np.array([1.0, 0.0, 0.0]))
        home = np.array([cam["base_radius"] if face == "flat" else sqrt(prime**2 - e**2), e, 0.0])
        outward = np.array([1.0, 0.0, 0.0])
    else:
        a, way = cam["center_distance"], -1.0 if follower.get("side") == "right" else 1.0
        centre = np.array([a, 0.0, 0.0])
        # a growing angle carries the follower away from the cam's axis
        joint = ("swing", np.array([0.0, 0.0, -way]), centre)
        if face == "flat":
            offset = follower.get("face_offset", 0.0)
            beta = way * acos((cam["base_radius"] + offset) / a)
            outward = np.array([cos(beta), sin(beta), 0.0])
            home = centre - offset * outward
        else:
            arm = follower["arm"]
            start = acos((a * a + arm * arm - prime * prime) / (2.0 * a * arm))
            home = np.array([a - arm * cos(start), way * arm * sin(start), 0.0])
            outward = None
    kind, base = ("flat", lambda k: outward) if face == "flat" else ("roller", 0.0)
    cone = {"slope": _slope(roller or {}, True), "centre": middle}
    return Follower(sense, lift, joint, lambda k: (home, z), middle, r, **cone, kind=kind, base=base)


def _frame(cam, follower, roller, lift, low, high):
    sense, z, base = _sense(cam), np.array([0.0, 0.0, 1.0]), cam["base_radius"]
    joint = ("slide", np.array([1.0, 0.0, 0.0]))
    if roller:
        r = 0.5 * roller["diameter"]
        span = 2.0 * (base + r) + high
        return Follower(sense, lift, joint, lambda k: (np.array([base + r - (span if k else 0.0), 0.0, 0.0]), z),
                        0.5 * cam["width"], r)
    span = 2.0 * base + high
    return Follower(sense, lift, joint, lambda k: (np.array([base - (span if k else 0.0), 0.0, 0.0]), z),
                    0.5 * cam["width"], 0.0, kind="flat", base=lambda k: np.array([-1.0 if k else 1.0, 0.0, 0.0]))


def _conjugate(cam, follower, roller, lift, low, high):
    sense, r, z = _sense(cam), 0.5 * roller["diameter"], np.array([0.0, 0.0, 1.0])
    prime = cam["base_radius"] + r
    w = cam["width"]
    heights = 0.5 * w, 1.5 * w + cam.get("gap", 0.0)
    if follower["kind"] == "translating":
        e = follower.get("offset", 0.0)
        far = cam["return_radius"] + r if "return_radius" in cam else sqrt((sqrt(prime**2 - e**2) + high) ** 2 + e**2)
        homes = np.array([sqrt(prime**2 - e**2), e, 0.0]), np.array([-sqrt(far**2 - e**2), e, 0.0])
        joint, play = ("slide", np.array([1.0, 0.0, 0.0])), follower.get("clearance", 0.0)
    else:
        a, arm, main = cam["center_distance"], cam.get("return_arm", follower["arm"]), follower["arm"]
        way = -1.0 if follower.get("side") == "right" else 1.0
        start = acos((a * a + main**2 - prime**2) / (2.0 * a * main))
        if "rocker_angle" in cam:
            rocker = radians(cam["rocker_angle"])
        else:
            rocker = start + high + acos((a * a + arm * arm - prime**2) / (2.0 * a * arm))
        homes = tuple(np.array([a - length * cos(t), way * length * sin(t), 0.0])
                      for length, t in ((main, start), (arm, start - rocker)))
        joint = ("swing", np.array([0.0, 0.0, -way]), np.array([a, 0.0, 0.0]))
        play = 2.0 * asin(min(1.0, follower.get("clearance", 0.0) / (2.0 * arm)))
    made = [Follower(sense, lift, joint, lambda k: (homes[k], z), height, r, shift=lambda k: play * k)
            for height in heights]
    return made[0]


def _drum(cam, follower, roller, lift, low, high):
    sense, outer = _sense(cam), 0.5 * cam["diameter"]
    middle = outer - 0.5 * roller["length"]
    half = 0.5 * (cam.get("rib_thickness", 0.0) + roller["diameter"]) if cam.get("form") == "rib" else 0.0
    dz = (lambda k: (2 * k - 1) * half) if half else (lambda k: 0.0)
    x = np.array([1.0, 0.0, 0.0])
    made = {"middle": middle, "radius": 0.5 * roller["diameter"], "slope": _slope(roller, True), "centre": middle}
    if follower["kind"] == "translating":
        return Follower(sense, lift, ("slide", np.array([0.0, 0.0, 1.0])),
                        lambda k: (np.array([0.0, 0.0, cam["start"] + dz(k)]), x), **made)
    arm, start = follower["arm"], radians(follower.get("start_angle", 0.0))
    spread = np.cos(np.linspace(start + low, start + high, 20001))
    pivot = follower.get("pivot_distance") or arm * 0.5 * (spread.min() + spread.max())
    height = cam["start"] - arm * sin(start)
    joint = ("swing", np.array([-1.0, 0.0, 0.0]), np.array([0.0, pivot, height]))
    return Follower(sense, lift, joint, lambda k: (np.array([0.0, pivot - arm, height + dz(k)]), x),
                    shift=lambda k: start, **made)


def _conical(cam, follower, roller, lift, low, high):
    """A roller square to a cone, along whose generator it slides; delta is half the diameter at the cone's surface."""
    del follower, low, high
    lean, outer = radians(cam["half_angle"]), 0.5 * cam["diameter"]
    along, out = np.array([-sin(lean), 0.0, cos(lean)]), np.array([cos(lean), 0.0, sin(lean)])
    home = np.array([outer, 0.0, 0.0]) + cam["start"] * along - outer * out
    middle = outer - 0.5 * roller["length"]
    return Follower(_sense(cam), lift, ("slide", along), lambda k: (home, out), middle, 0.5 * roller["diameter"],
                    _slope(roller, True), middle)


def _end_face(cam, follower, roller, lift, low, high):
    """As a drum's groove, whose roller stands above the middle of the ring, or reaches out into its inside."""
    if cam.get("form") == "groove":
        made = _drum({"direction": cam.get("direction"), "start": cam["start"],
                      "diameter": cam["inner_diameter"] + 2.0 * roller["length"]}, follower, roller, lift, low, high)
        return replace(made, slope=_slope(roller, False))
    middle = 0.25 * (cam["diameter"] + cam["inner_diameter"])
    ring = {"diameter": 2.0 * middle + roller["length"], "start": cam["height"] + 0.5 * roller["diameter"]}
    return _drum({"direction": cam.get("direction"), **ring}, follower, roller, lift, low, high)


def _turret(cam, follower):
    count = follower.get("rollers") or follower["stops"]
    pitch = TURN / count
    base = 0.5 * pitch if cam.get("form", "rib") == "rib" else 0.0
    return lambda k: base + k * pitch


def _barrel(cam, follower, roller, lift, low, high):
    del low, high
    hand = -1.0 if cam.get("hand") == "left" else 1.0
    middle, far, rf = 0.5 * cam["diameter"] - 0.5 * roller["length"], cam["center_distance"], follower["pitch_radius"]
    joint = ("swing", np.array([-hand, 0.0, 0.0]), np.array([0.0, far, 0.0]))
    home = np.array([0.0, far - rf, 0.0]), np.array([1.0, 0.0, 0.0])
    return Follower(_sense(cam), lift, joint, lambda k: home, middle, 0.5 * roller["diameter"],
                    _slope(roller, True), middle, shift=_turret(cam, follower))


def _globoid(cam, follower, roller, lift, low, high):
    del low, high
    hand = -1.0 if cam.get("hand") == "left" else 1.0
    far, middle = np.array([cam["center_distance"], 0.0, 0.0]), follower["pitch_radius"]
    joint = ("swing", np.array([0.0, hand, 0.0]), far)
    return Follower(_sense(cam), lift, joint, lambda k: (far, np.array([-1.0, 0.0, 0.0])), middle,
                    0.5 * roller["diameter"], _slope(roller, False), middle, shift=_turret(cam, follower))


def _parallel(cam, follower, roller, lift, low, high):
    del low, high
    sense, count = _sense(cam), follower.get("rollers") or follower["stops"]
    c, rf = cam["center_distance"], follower["pitch_radius"]
    joint = ("swing", np.array([0.0, 0.0, -sense]), np.array([c, 0.0, 0.0]))
    home = np.array([c - rf, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    return Follower(sense, lift, joint, lambda k: home, 0.5 * cam["width"], 0.5 * roller["diameter"],
                    shift=lambda k: (k + 0.5) * TURN / count)


def _plate(cam, follower, roller, lift, low, high):
    """A plate under a crank with a long rod; its motion is a dwell, a cycloidal rise, a dwell over the travel."""
    del lift, low, high
    stroke, (first, last), rise = cam["stroke"], cam["moves"], cam["rise"]
    radius, length = 0.5 * roller["diameter"], roller["length"]

    def travel(phi):
        return 0.5 * stroke * (1.0 - np.cos(phi))

    def lifted(phi):
        u = np.clip((travel(phi) - first) / (last - first), 0.0, 1.0)
        return rise * (u - np.sin(TURN * u) / TURN)

    home = np.array([cam["start"], cam["edge"], 0.0])
    made = {"middle": cam["thickness"] - 0.5 * length, "radius": radius, "travel": travel}
    up = np.array([0.0, 0.0, 1.0])
    if follower["kind"] == "translating":
        lean = radians(cam.get("inclination", 0.0))
        return Follower(1.0, lifted, ("slide", np.array([sin(lean), cos(lean), 0.0])), lambda k: (home, up), **made)
    way, arm = -1.0 if follower.get("side") == "right" else 1.0, follower["arm"]
    start = radians(follower["start_angle"])
    pivot = home - arm * np.array([way * cos(start), sin(start), 0.0])
    return Follower(1.0, lifted, ("swing", way * up, pivot), lambda k: (home, up), **made)


_KINDS = {"disc": _planar, "constant-width": _frame, "conjugate": _conjugate, "cylindrical": _drum,
          "conical": _conical, "end-face": _end_face, "cylindrical-index": _barrel, "globoidal": _globoid,
          "parallel-index": _parallel, "linear": _plate}  # fmt: skip
