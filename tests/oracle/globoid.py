"""Globoids measured: walls against the nearest roller, the volume of a dwell by its meridian section."""

from __future__ import annotations

from math import pi

import numpy as np

from tests.oracle.envelope import roller_distance, swept_distance, triangle_points
from tests.reference.indexing_machines import dwell_half_angle, meridian_of, turret_pose

TOLERANCE = 0.1


def solid_of(cam, setup, tolerance=TOLERANCE):
    (part,) = cam.mechanism(setup).parts
    return part.solid(tolerance)


def wall_error(cam, setup, shape, solid, samples=16, seed=1):
    """Largest distance of flank triangles from the nearest roller, and the deepest point of all inside one, mm."""
    mesh = solid.mesh
    rng = np.random.default_rng(seed)
    picked = []
    for name in ("flank", "floor", "land"):
        found = mesh.faces[mesh.group_faces(name)]
        picked.append(found[rng.choice(len(found), min(samples, len(found)), replace=False)] if len(found) else found)
    points = triangle_points(mesh.vertices, np.concatenate(picked), 4)
    kind = meridian_of(setup, shape)
    radius = 0.5 * setup.roller.diameter + cam.running_clearance
    count = setup.follower.count
    starts = round(setup.program.advance / (2.0 * pi / count)) or 1
    sense = 1.0 if cam.direction == "ccw" else -1.0
    wall, body = np.full(len(points), np.inf), np.full(len(points), np.inf)
    for start in range(starts):
        shift = dwell_half_angle(setup, cam.form) + start * 2.0 * pi / count
        pose = turret_pose(setup, cam.center_distance, shift, cam.hand, sense)
        low, high = cam.mechanism(setup).cutters[start].span
        deep = cam.mechanism(setup).tip + 12.0
        for best, tip in ((wall, deep), (body, cam.mechanism(setup).tip)):

            def distance(x, a, u, tip=tip):
                return roller_distance(x, a, u, radius, tip, tip_high=True, shape=kind)

            coarse = int(120 * (high - low) / (2.0 * pi))
            np.minimum(best, swept_distance(points, pose, distance, low, high, coarse, 3, 22), out=best)
    flank = 4 * len(picked[0])
    floor = body[flank : flank + 4 * len(picked[1])]
    return float(wall[:flank].max()), float(body.min()), float(floor.min(initial=np.inf))


def dwell_section(cam, setup, rows=400_001):
    """Volume per radian of the dwell: integral of rho²/2 dz over the meridian section."""
    z = np.linspace(-0.5 * cam.width, 0.5 * cam.width, rows)
    outer = cam.center_distance - np.sqrt(cam.globoid_radius**2 - z**2)
    radius, floor, tau = 0.5 * setup.roller.diameter, cam.mechanism(setup).floor_radius, pi / setup.follower.count
    reach = np.sqrt(floor**2 - radius**2)
    area = 0.5 * outer**2
    for sign in (1.0, -1.0):
        u = np.array([-np.cos(tau), sign * np.sin(tau)])
        across = np.array([-u[1], u[0]])
        # A line of height z crosses the strip |x . across| <= r between these, and its floor x . u = reach here.
        ends = np.sort(np.stack([(s * radius - z * across[1]) / across[0] for s in (1.0, -1.0)]), axis=0)
        low = cam.center_distance + np.maximum(ends[0], (reach - z * u[1]) / u[0])
        high = np.minimum(cam.center_distance + ends[1], outer)
        area -= np.where(high > low, 0.5 * (high**2 - low**2), 0.0)
    return float(np.trapezoid(area, z))
