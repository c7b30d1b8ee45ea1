"""Volume of a cut body from meshes of exact points refined evenly, twice as many cells each way a time.

Sags are proportional to the square of the cells then, so that two volumes give their limit. The bore is taken off in
closed form.
"""

from __future__ import annotations

from itertools import pairwise
from math import ceil

import numpy as np

from camgeom.maths.mesh import Mesh
from camgeom.maths.sampling import Grid
from camgeom.solid.blank import Blank, close_ends
from camgeom.solid.builder import Builder
from camgeom.solid.cut import CutBlank, groove_body
from camgeom.solid.engine import subtract
from camgeom.track.column import Column
from camgeom.track.section import GrooveSection


def limit_volume(body, finest: int = 4, step: float = 0.05) -> float:
    """Volume in mm³ of an IndexingCut or CutBlank; `step` rad of cam angle a cell at refinement 1."""
    coarse, fine = (_volume(body, k, step) for k in (finest // 2, finest))
    bore = body.blank.bore
    length = body.blank.outline[-1][1] - body.blank.outline[0][1]
    return (4.0 * fine - coarse) / 3.0 - (bore.area * length if bore is not None else 0.0)


def _volume(body, k: int, step: float) -> float:
    return subtract(_blank(body.blank, k), [_groove(body, track, k, step) for track in body.tracks]).volume


def _groove(body, track, k: int, step: float) -> Mesh:
    cut = isinstance(body, CutBlank)
    section = GrooveSection(track, body.outside, body.guess, 1.0) if cut else body.section(track)
    counts = {"flank": 6 * k, "edge": 4 * k, "floor": 4 * k}
    across = tuple(min(counts[name], most) for name, most in zip(section.names, section.max_counts))
    knots = track.knots()
    pieces = [np.linspace(a, b, k * ceil((b - a) / step) + 1)[:-1] for a, b in pairwise(knots)]
    phi = np.append(np.concatenate(pieces), knots[-1])
    points = section.rows(Column(track, phi), across)
    grid = Grid(phi, points, across, np.ones((len(phi) - 1, sum(across)), dtype=bool), 0.0)
    return groove_body(grid, section, body.ridge, 1e-3)


def _blank(blank: Blank, k: int) -> Mesh:
    arcs = blank.arcs or (None,) * (len(blank.outline) - 1)
    rz = [blank.outline[0]]
    for start, stop, arc in zip(blank.outline[:-1], blank.outline[1:], arcs):
        if arc is not None:
            low, high = (np.arctan2(p[1] - arc[1], p[0] - arc[0]) for p in (start, stop))
            radius = np.hypot(start[0] - arc[0], start[1] - arc[1])
            turn = low + ((high - low + np.pi) % (2.0 * np.pi) - np.pi) * np.arange(1, 24 * k) / (24 * k)
            rz += [(arc[0] + radius * np.cos(t), arc[1] + radius * np.sin(t)) for t in turn]
        rz.append(stop)
    angle = 2.0 * np.pi * (np.arange(192 * k) + 0.37) / (192 * k)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    builder = Builder()
    rows = [builder.add(np.column_stack([r * ring, np.full(len(angle), z)])) for r, z in rz]
    for low, high in pairwise(rows):
        builder.band(low, high, "land")
    close_ends(builder, rows[0], rows[-1], rz[0][1], rz[-1][1], None, 1e-3)
    return builder.mesh()
