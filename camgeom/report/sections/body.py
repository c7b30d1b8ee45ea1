"""Stress in the body: figures at a wall's root, and the nominal stress over the turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import (
    CAM_ANGLE,
    Axis,
    Block,
    Cell,
    Chart,
    Limit,
    Map,
    Mark,
    Panel,
    Series,
    Text,
    quantities,
)

if TYPE_CHECKING:
    from camgeom.body.cut import Cut
    from camgeom.body.stress import Peak
    from camgeom.model import Model

CELLS = 160
"""of the coloured section, along its longer side"""
FIGURES = (
    ("nominal_stress_mpa", "Largest nominal stress, linearised over the wall", "MPa"),
    ("nominal_at_deg", "at cam angle", "°"),
    ("nominal_where", "which is at the", ""),
    ("peak_stress_mpa", "Peak stress, largest principal", "MPa"),
    ("load_angle_deg", "under the load at", "°"),
    ("load_n", "which is", "N"),
    ("wall_mm", "on a wall of", "mm"),
    ("fatigue_factor", "Bending limit over peak stress", ""),
)


def body(model: Model) -> tuple[Block, ...]:
    """The section; empty where the profile gives no material.cam.bending_limit, or its cam has no such root."""
    found, limit = model.root_stress, model.profile.material.cam.bending_limit
    if limit is None or found is None:
        return ()
    data = found.data()
    known = [figure for figure in FIGURES if data.get(figure[0]) is not None]
    rows: list[tuple[Cell, ...]] = [(label, data[key], unit) for key, label, unit in known]
    angle = np.degrees(np.append(found.theta, 2.0 * np.pi))
    stress = np.append(found.nominal, found.nominal[0])
    mark = Mark(data["nominal_at_deg"], data["nominal_stress_mpa"], f"{data['nominal_stress_mpa']:.4g}")
    limits = (Limit(limit, "bending limit"),) if limit < 3.0 * data["nominal_stress_mpa"] else ()
    panel = Panel(Axis("Nominal stress", "MPa", zero=True), (Series("nominal", angle, stress),), (), limits, (mark,))
    blocks: list[Block] = [
        quantities(f"Stress at the {data['where']}", rows),
        Chart("Nominal stress at the root of the pressed wall over one turn", CAM_ANGLE, (panel,)),
    ]
    if found.peaks and found.peaks[-1].cut is not None:
        blocks.append(_coloured(found.peaks[-1].cut, found.peaks[-1]))
    if found.why_no_peak:
        blocks.append(Text((f"No peak stress is given: {found.why_no_peak}.",)))
    return tuple(blocks)


def _coloured(cut: Cut, peak: Peak) -> Map:
    """Stress over the section beside the peak, as far round it as the groove is deep."""
    z, r = float(peak.point[2]), float(np.hypot(peak.point[0], peak.point[1]))
    along, out, values = cut.window(z, r, cut.depth, CELLS)
    caption = (
        f"Largest principal stress in the plane at azimuth {np.degrees(cut.azimuth):.4g}°, through the root's peak; "
        "compression alone counts as 0, and beside the line that presses the colours end at the peak"
    )
    # Beside the line that presses, the mesh's own stress has no meaning.
    shown = np.clip(values, 0.0, peak.value)
    return Map(caption, Axis("z", "mm"), Axis("Radius", "mm"), Axis("Largest principal stress", "MPa"), along, out,
               shown, marks=(Mark(z, r, f"{peak.value:.4g}"),))  # fmt: skip
