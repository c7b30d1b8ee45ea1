"""The finished bodies against their followers over the whole turn: how near these come, and what is cut too deep."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.maths import Floats
from camgeom.solid import UNION
from camgeom.track.clearance import (
    Clearance,
    edge_clearance,
    facet_points,
    floor_points,
    largest_gap,
    least_beside,
    least_clearance,
    wall_ends,
    wall_points,
)

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.solid import Solid
    from camgeom.track import Track

RIM = 1e-9
"""mm beside a plate's rim within which its wall is the rim"""
SAG = 1.01
"""of the chord error, to which a facet may stand off: it is measured by a quadratic patch and one normal a cell, which
on coarse meshes of cones is 0.4 % less than the least distance of a facet's middle"""


def clearances(model: Model, grow: float) -> tuple[Clearance, ...]:
    """Least distance between every roller, face or edge, larger by `grow` mm (normal), and the mesh over the turn."""
    passages = tuple(map(model.mechanism.cutting, model.passages))
    found = [least_clearance(track, *_surface_points(model, track), grow) for track in passages]
    edges = [edge_clearance(track, tool, grow) for track, tool in zip(passages, model.cutters) if tool.root]
    found = [min(pair, key=lambda one: one.value) for pair in zip(found, edges)] if edges else found
    found += [least_beside(slider, *_surface_points(model, None), grow) for slider in model.mechanism.sliders]
    return tuple(found)


def backlash(model: Model) -> tuple[Clearance, ...]:
    """The largest distance at which the follower passes a point of each body's flank, mm: what is cut too deep.

    Less the chord error where a point may stand off the true surface by as much. The rim of a plate between the
    flanks of its rollers is no flank; the union of rollers has none.
    """
    turret, outside = model.mechanism.turret, model.mechanism.outside_diameter
    plates = turret is not None and not turret.rib_depths
    # A straight flank falls away from the crown beside its crest. A track with more room than the first one is
    # passed by a roller that counts as so much larger.
    asked = model.mechanism.allowed_backlash
    passages = {one: tuple(one.mechanism.cutting(track).grown(one.mechanism.allowed_backlash - asked)
                           for track in one.passages) for one in model.grooves}  # fmt: skip
    every = tuple(track for each in passages.values() for track in each)
    sliders = tuple(slider for one in model.grooves for slider in one.mechanism.sliders)
    gaps = []
    for solid in model.solids:
        flank = solid.mesh.group_vertices("flank")
        if plates and outside is not None:
            flank &= np.hypot(*solid.mesh.vertices[:, :2].T) < 0.5 * outside - RIM
        if flank.any() and solid.method != UNION:
            middle = float(solid.mesh.vertices[:, 2].mean())
            points, slack = list[Floats](), list[Floats]()
            for one, own in passages.items():
                # Of a pair each disc has its own roller, of several tracks on a disc each its own wall.
                beside = min(own, key=lambda track: abs(0.5 * sum(track.contact) - middle), default=None)
                on, wall = flank, one.mechanism.wall
                if len(passages) > 1 and wall is not None:
                    off = [np.abs(end - to) for end, to in zip(wall_ends(solid.mesh), wall)]
                    on = flank & (np.maximum(*off) < RIM)
                elif points:
                    break
                vertices = _vertices(model, solid, beside)
                middles = facet_points(solid.mesh, vertices, on, inner=solid.free_error is not None)
                points += [vertices[on], middles]
                slack += [solid.cut_errors[on], np.full(len(middles), _flank_slack(model, solid))]
            gaps.append(largest_gap(every, sliders, np.concatenate(points), np.concatenate(slack)))
    return tuple(gaps)


def _flank_slack(model: Model, solid: Solid) -> float:
    """By how much the middle of a flank's facet may stand off its true surface, mm.

    Beside coarser faces a flank's cells are as long as it alone allows. For them that patch is short by up to 5 %
    of the tolerance (some 200 random designs), so that the tolerance is what counts.
    """
    return max(SAG * solid.chord_error, 0.0 if solid.free_error is None else model.tolerance)


def _vertices(model: Model, solid: Solid, track: Track | None) -> Floats:
    """Vertices (v, 3) of a body; of the wall of a disc or plate, which has them at its ends, beside the roller."""
    plane = any(one.planar is not None or one.profiles is not None for one in model.grooves)
    if track is None or (not plane and model.mechanism.carriage is None):
        return solid.mesh.vertices
    return wall_points(solid.mesh, 0.5 * sum(track.contact))


def _surface_points(model: Model, track: Track | None) -> tuple[Floats, Floats]:
    """Points of all bodies, and by how much each may stand inside the true surface, mm.

    Vertices lie on it, but for those where a facet was cut; middles of facets and floors by the chord error.
    """
    points, slack = [], []
    for solid in model.solids:
        vertices = _vertices(model, solid, track)
        floors, flanks = floor_points(solid.mesh), facet_points(solid.mesh, vertices)
        points += [vertices, floors, flanks]
        off = (len(floors), SAG * solid.largest_error), (len(flanks), _flank_slack(model, solid))
        slack += [solid.cut_errors, *(np.full(*each) for each in off)]
    return np.concatenate(points), np.concatenate(slack)
