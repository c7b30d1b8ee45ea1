"""Tolerances: what every error of assembly and manufacture does alone, and what all of them leave of the accuracy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Column, Limit, Panel, Series, Table, Text
from camgeom.tolerance.machine import machine_data
from camgeom.tolerance.study import tolerance_data

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.tolerance.study import ToleranceStudy

CURVES = 5
"""errors whose motion over the turn is drawn: those with the largest share of it at their tolerance"""
BINS = 80
FIGURES = (("dwell", "Error in the dwells"), ("motion", "Error anywhere in the turn"), ("backlash", "Play in dwells"))


def tolerance(model: Model) -> tuple[Block, ...]:
    """The section; empty for a profile without [tolerance].

    Of several followers the first one's begins with what a machine keeps with all of them.
    """
    if model.profile.tolerance_spec is None:
        return ()
    study, several = model.tolerances, len(model.bindings) > 1
    data = tolerance_data(study)
    machine = {} if model.number else machine_data(model.machine_tolerances, with_widest=True)
    if not several:
        data |= machine
    unit = _unit(data)
    blocks = [*_machine(model, machine)] if several and not model.number else list[Block]()
    kept = "every limit of this follower" if several else "every limit"
    blocks += [_together(data, unit, kept), _spread(study, unit), _parts(data), _alone(data, unit)]
    blocks.append(_over_the_turn(study, unit))
    if "widest_reason" in machine:
        blocks.append(Text((f"Widest tolerances: {machine['widest_reason']}",)))
    if data.get("wear"):
        worn: tuple[tuple[Cell, ...], ...] = tuple(
            (row["wear_um"], row["preload_um"], 100.0 * row["still_preloaded"]) for row in data["wear"]
        )
        left = (Column("Worn, roller and flank", "µm"), Column("Nominal preload left", "µm"),
                Column("Machines still preloaded", "%"))  # fmt: skip
        blocks.append(Table("What wear leaves of the preload", left, worn))
    return tuple(blocks)


def _unit(data: dict[str, Any]) -> str:
    return "arcsec" if data["unit"] == "arcsec" else "µm"


def _machine(model: Model, machine: dict[str, Any]) -> list[Block]:
    """What every follower keeps alone, what a machine keeps with all of them, and the widest tolerances for that."""
    each = [tolerance_data(one.tolerances) for one in model.bindings]
    wanted = 100.0 * each[0]["wanted_yield"]
    # What is judged comes first: it is seen without moving a wide table.
    heads = (Column("Follower"), Column("Track"), Column("Keep every limit", "%"),
             *(Column(label) for _, label in FIGURES), Column("Unit"))  # fmt: skip
    rows: list[tuple[Cell, ...]] = []
    for one, data in zip(model.bindings, each):
        figures = (data.get(f"{key}_{data['unit']}") for key, _ in FIGURES)
        kept = 100.0 * data["yield"] if "yield" in data else None
        rows.append((f"{one.number + 1}", f"{one.groove + 1}", kept, *figures, _unit(data)))
    if machine:
        blank = (None,) * len(FIGURES)
        rows.append(("all of a machine", "", 100.0 * machine["yield"], *blank, ""))
    caption = f"Every follower, and all of a machine together: machines, and within what {wanted:.4g} % of them stay"
    blocks: list[Block] = [Table(caption, heads, tuple(rows))]
    if (widest := machine.get("widest")) is not None:
        allowed: list[tuple[Cell, ...]] = []
        for key, wide in widest["tolerances"].items():
            given = each[0]["errors"][key]
            told = "any" if wide is None else f"± {wide:.3g}"
            allowed.append((_named(key), f"± {given['value']:.3g}", told, given["unit"]))
        caption = "The widest tolerances that hold the limits of all followers in "
        caption += f"{100.0 * widest['yield']:.4g} % of the machines"
        blocks.append(Table(caption, (Column("Error"), Column("Given"), Column("Widest"), Column("Unit")),
                            tuple(allowed)))  # fmt: skip
    return blocks


def _together(data: dict[str, Any], unit: str, limits: str) -> Block:
    share, name = 100.0 * data["wanted_yield"], data["unit"]
    rows: list[tuple[Cell, ...]] = [
        (label, data[f"median_{key}_{name}"], data[f"{key}_{name}"], data[f"worst_{key}_{name}"], unit)
        for key, label in FIGURES
        if f"{key}_{name}" in data
    ]
    within = Column(f"{share:.4g} % within")
    heads = Column("Quantity"), Column("Median"), within, Column("Worst case, from the drawing"), Column("Unit")
    if "groove_end_um" in data:
        told = f"Nearer to the groove's end, whose running clearance leaves {data['groove_end_room_um']:.4g} µm"
        rows.append((told, None, data["groove_end_um"], data["worst_groove_end_um"], "µm"))
    if "pressure_mpa" in data:
        rows.append(("Largest contact pressure", None, data["pressure_mpa"], None, "MPa"))
    if "edge" in data:
        edge = data["edge"]
        inside = ", at most half a millimetre inside its sharp end" if edge["unbounded"] else ""
        told = f"Hardest roller, tilted by {edge['tilt_arcmin']:.3g}′{inside}"
        told = f"{told}; level {edge['level_pressure_mpa']:.4g} MPa"
        rows.append((told, None, None, edge["tilted_pressure_mpa"], "MPa"))
    kept = f"; {100.0 * data['yield']:.4g} % keep {limits}" if "yield" in data else ""
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
    """The errors given, what each explains of the variance, and how wide it may be."""
    widest = (data.get("widest") or {}).get("tolerances")
    rows: list[tuple[Cell, ...]] = []
    for key, part in data["contributions"].items():
        given, bar = data["errors"][key], "█" * round(40.0 * part)
        wide: tuple[Cell, ...] = ()
        if widest is not None:
            wide = ("any" if widest[key] is None else f"± {widest[key]:.3g}",)
        about = f"{given['mean']:.3g} " if given["mean"] else ""
        rows.append((_named(key), f"{about}± {given['value']:.3g}", *wide, given["unit"], _percent(part), bar))
    together = data["contributions_together"]
    blank: tuple[Cell, ...] = (None,) if widest is not None else ()
    rows.append(("Errors acting together", None, *blank, "", _percent(together), "█" * round(40.0 * together)))
    allowed = (Column("Widest"),) if widest is not None else ()
    heads = (Column("Error"), Column("Given"), *allowed, Column("Unit"), Column("Explains alone", "%"), Column(""))
    caption = "What the error in the dwells comes from: parts of its variance"
    if widest is not None:
        held = 100.0 * data["widest"]["yield"]
        caption += f"; the widest tolerances that hold the limits in {held:.4g} % of the machines"
    return Table(caption, heads, tuple(rows))


def _percent(part: float) -> float:
    return round(100.0 * part, 1)


def _alone(data: dict[str, Any], unit: str) -> Block:
    """What every error does alone, with the columns that mean something here."""
    name, rows = data["unit"], data["sensitivities"]
    columns: dict[Column, list[Cell]] = {
        Column("Error"): [_named(row["error"]) for row in rows],
        Column("of"): [f"{row['size']:g} {row['size_unit']}" for row in rows],
        Column("Motion", unit): [row[f"motion_{name}"] for row in rows],
    }
    if name == "arcsec":
        columns[Column("Motion", "µm")] = [row["motion_um"] for row in rows]
    # Where the drive of a plate turns, its angle is known but for rounding.
    angles = [row["cam_angle_deg"] for row in rows]
    columns[Column("at", "°")] = [None if angle is None else round(angle, 9) for angle in angles]
    if "preload_um" in data:
        columns[Column("Play", unit)] = [row[f"play_{name}"] for row in rows]
        columns[Column("Preload", "µm")] = [_lost(row["preload_loss_um"]) for row in rows]
    if data["pressed"]:
        columns[Column("Pressure", "times")] = [row["pressure_ratio"] for row in rows]
    told = ["motion of the follower", *(["and of its reference point"] if name == "arcsec" else []),
            *(["play, preload"] if "preload_um" in data else []), *(["peak pressure"] if data["pressed"] else [])]
    caption = f"Every error alone, the largest over the turn: {', '.join(told)}"
    return Table(caption.replace(", and", " and"), tuple(columns), tuple(zip(*columns.values())))


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
    return Chart("The largest errors at their tolerances, and what no machine goes beyond", CAM_ANGLE, panels)


def _named(key: str) -> str:
    return key.removesuffix("_arcmin").removesuffix("_arcsec").replace("_", " ")
