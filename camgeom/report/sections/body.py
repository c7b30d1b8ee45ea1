"""Stress in the body: figures at a groove's root, and the nominal stress over the turn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Limit, Mark, Panel, Series, Text, quantities

if TYPE_CHECKING:
    from camgeom.model import Model

FIGURES = (
    ("nominal_stress_mpa", "Largest nominal stress, linearised over the wall", "MPa"),
    ("nominal_at_deg", "at cam angle", "°"),
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
    if found.why_no_peak:
        blocks.append(Text((f"No peak stress is given: {found.why_no_peak}.",)))
    return tuple(blocks)
