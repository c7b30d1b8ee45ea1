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
    from camgeom.body.stress import StressPeak
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
    """The section; empty where the profile gives no bending_limit, or there is no such root."""
    found, limit = model.root_stress, model.root_limit
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
        quantities(f"Stress at the {data.get('where', data['nominal_where'])}", rows),
        Chart("Largest nominal stress over one turn", CAM_ANGLE, (panel,)),
    ]
    if found.peaks and found.peaks[-1].cut is not None:
        blocks.append(_coloured(found.peaks[-1].cut, found.peaks[-1]))
    if found.why_no_peak:
        blocks.append(Text((f"No peak stress is given: {found.why_no_peak}.",)))
    return tuple(blocks)


def _coloured(cut: Cut, peak: StressPeak) -> Map:
    """Stress over the section beside the peak, as far round it as the groove is deep."""
    z, r = cut.place(peak.point)
    along, out, values = cut.window(z, r, cut.depth, CELLS)
    plate = cut.azimuth is None
    place = f"in the frame at z = {peak.point[2]:.4g} mm, beside its window's corner" if cut.azimuth is None else (
        f"in the plane at azimuth {np.degrees(cut.azimuth):.4g}°, through the root's peak"
    )
    caption = (
        f"Largest principal stress {place}; compression alone counts as 0, and beside the line that presses the "
        "colours end at the peak"
    )
    # Beside the line that presses, the mesh's own stress has no meaning.
    shown = np.clip(values, 0.0, peak.value)
    sides = (Axis("x", "mm"), Axis("y", "mm")) if plate else (Axis("z", "mm"), Axis("Radius", "mm"))
    return Map(caption, *sides, Axis("Largest principal stress", "MPa"), along, out, shown,
               marks=(Mark(z, r, f"{peak.value:.4g}"),), to_scale=True)  # fmt: skip
