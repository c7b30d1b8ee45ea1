"""Tolerances: what every error of assembly and manufacture does alone, and what all of them leave of the accuracy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Column, Limit, Panel, Series, Table
from camgeom.tolerance.study import tolerance_data

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.tolerance.study import ToleranceStudy

CURVES = 5
"""errors whose motion over the turn is drawn: those with the largest share of it at their tolerance"""
BINS = 80
FIGURES = (("dwell", "Error in the dwells"), ("motion", "Error anywhere in the turn"), ("backlash", "Play in dwells"))


def tolerance(model: Model) -> tuple[Block, ...]:
    """The section; empty for a profile without [tolerance]."""
    if model.profile.tolerance_spec is None:
        return ()
    study = model.tolerances
    data = tolerance_data(study, with_widest=True)
    unit = "arcsec" if data["unit"] == "arcsec" else "µm"
    blocks: list[Block] = [_together(data, unit), _spread(study, unit), _parts(data), _alone(data, unit)]
    blocks.append(_over_the_turn(study, unit))
    if data.get("widest"):
        rows: list[tuple[Cell, ...]] = [
            (_named(key), f"± {value:.3g}" if value is not None else "no part in it", _unit(key),
             f"{100.0 * data['contributions'][key]:.1f} %")
            for key, value in data["widest"]["tolerances"].items()
        ]
        heads = (Column("Error"), Column("Widest"), Column("Unit"), Column("Part of the variance now"))
        caption = f"Widest tolerances that hold the limits in {100.0 * data['widest']['yield']:.4g} % of the machines"
        blocks.append(Table(caption, heads, tuple(rows)))
    if data.get("wear"):
        worn: tuple[tuple[Cell, ...], ...] = tuple(
            (row["wear_um"], row["preload_um"], 100.0 * row["still_preloaded"]) for row in data["wear"]
        )
        left = (Column("Worn, roller and flank", "µm"), Column("Nominal preload left", "µm"),
                Column("Machines still preloaded", "%"))  # fmt: skip
        blocks.append(Table("What wear leaves of the preload", left, worn))
    return tuple(blocks)


def _together(data: dict[str, Any], unit: str) -> Block:
    share, name = 100.0 * data["wanted_yield"], data["unit"]
    rows: list[tuple[Cell, ...]] = [
        (label, data[f"median_{key}_{name}"], data[f"{key}_{name}"], data[f"worst_{key}_{name}"], unit)
        for key, label in FIGURES
        if f"{key}_{name}" in data
    ]
    within = Column(f"{share:.4g} % within")
    heads = Column("Quantity"), Column("Median"), within, Column("Worst case, from the drawing"), Column("Unit")
    if "pressure_mpa" in data:
        rows.append(("Largest contact pressure", None, data["pressure_mpa"], None, "MPa"))
    if "edge" in data:
        edge = data["edge"]
        inside = ", half a millimetre inside its sharp end" if edge["unbounded"] else ""
        told = f"Hardest roller, tilted by {edge['tilt_arcmin']:.3g}′{inside}"
        told = f"{told}; level {edge['level_pressure_mpa']:.4g} MPa"
        rows.append((told, None, None, edge["tilted_pressure_mpa"], "MPa"))
    kept = f"; {100.0 * data['yield']:.4g} % keep every limit" if "yield" in data else ""
    start = "the drawing" if data["reference"] == "absolute" else "each machine's first dwell"
    return Table(f"{data['samples']:,} machines, measured from {start}{kept}".replace(",", " ", 1), heads, tuple(rows))


def _spread(study: ToleranceStudy, unit: str) -> Block:
    """How the machines' errors in the dwells are distributed."""
    loaded = study.loaded
    values = loaded.shown(1.0) * study.drawn.dwell
    top = float(np.sort(values)[int(0.9995 * (len(values) - 1))]) or 1.0
    count, edges = np.histogram(values, bins=BINS, range=(0.0, top))
    share = 100.0 * np.cumsum(count) / len(values)
    x = Axis("Largest error in the dwells", unit)
    limits = tuple(Limit(loaded.shown(limit), "limit", vertical=True) for name, limit in study.limits.items()
                   if name == "dwell" and loaded.shown(limit) <= top)  # fmt: skip
    line = Series("machines within", edges[1:], share)
    return Chart("Machines that stay within an error", x, (Panel(Axis("Machines", "%"), (line,), limits=limits),))


def _parts(data: dict[str, Any]) -> Block:
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (_named(key), 100.0 * part, "█" * round(40.0 * part)) for key, part in data["contributions"].items()
        if part >= 0.0005
    )  # fmt: skip
    heads = Column("Error"), Column("Part of the variance", "%"), Column("")
    return Table("What the error in the dwells comes from", heads, rows)


def _alone(data: dict[str, Any], unit: str) -> Block:
    name = data["unit"]
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (
            _named(row["error"]), f"{row['size']:g} {row['size_unit']}", row[f"motion_{name}"], row["motion_um"],
            row["cam_angle_deg"], row[f"play_{name}"], _lost(row["preload_loss_um"]), row["pressure_ratio"],
        )
        for row in data["sensitivities"]
    )  # fmt: skip
    heads = (
        Column("Error"), Column("of"), Column("Motion", unit), Column("Motion", "µm"), Column("at", "°"),
        Column("Play", unit), Column("Preload", "µm"), Column("Pressure", "times"),
    )  # fmt: skip
    caption = "Every error alone, the largest over the turn: motion of the follower and of its reference point"
    return Table(f"{caption}, play, preload, peak pressure", heads, rows)


def _lost(value: float | None) -> float | None:
    return None if value is None else 0.0 - value


def _over_the_turn(study: ToleranceStudy, unit: str) -> Block:
    """The errors that move the follower most at the tolerance given, and the worst case."""
    table, loaded = study.sensitivities, study.loaded
    degrees = np.degrees(table.theta)
    half = {key: value for key, (_, value, _) in study.spreads.items()}
    rows = [(row, half[row.cause.key] / (row.size * row.cause.scale)) for row in table.rows if row.cause.key in half]
    rows.sort(key=lambda item: -item[0].motion.value * item[1])
    lines = tuple(Series(_named(row.cause.key), degrees, loaded.shown(1.0) * share * row.curve)
                  for row, share in rows[:CURVES])  # fmt: skip
    worst = Series("all, worst case", degrees, loaded.shown(1.0) * study.worst.curve)
    panels = (Panel(Axis("Follower off by", unit), (*lines, worst)),)
    return Chart("The largest errors at their tolerances, and all at their ends at once", CAM_ANGLE, panels)


def _named(key: str) -> str:
    return key.removesuffix("_arcmin").removesuffix("_arcsec").replace("_", " ")


def _unit(key: str) -> str:
    from camgeom.tolerance.causes import CAUSES

    return CAUSES[key].unit


