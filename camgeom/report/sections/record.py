"""What stands behind the page: facts computed a second way, every parameter of the profile, what was computed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from camgeom.drawing.content import Block, Cell, Column, Cost, Table, Text
from camgeom.drawing.sheet import number
from camgeom.errors import CamgeomError
from camgeom.keys import Section
from camgeom.report.result import Product
from camgeom.track.flank import Flank

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.track.survey import Survey

STEP = 1e-5
"""rad, of the difference quotients; their own error is the step squared times the third derivative"""


def validation(model: Model) -> tuple[Block, ...]:
    """The table of second ways, and for groove cams the curvature conventions of the literature."""
    rows: list[tuple[Cell, ...]] = []
    rows += motion_rows(model)
    if model.flanks:
        rows += flank_rows(model.flanks[0])
    rows += solid_rows(model)
    rows += load_rows(model)
    columns = tuple(Column(label) for label in ("Fact", "Second way", "Difference", "Allowed", "Unit", "Verdict"))
    blocks: list[Block] = [Table("Facts of this design computed a second way", columns, tuple(rows))]
    return (*blocks, *conventions(model))


def _row(fact: str, way: str, value: float, allowed: float, unit: str) -> tuple[Cell, ...]:
    return fact, way, value, allowed, unit, value <= allowed


def motion_rows(model: Model) -> list[tuple[Cell, ...]]:
    """Derivatives of the lift against difference quotients away from the knots."""
    program = model.setup.program
    knots = program.knots
    theta = np.concatenate([np.linspace(a, b, 41)[1:-1] for a, b in zip(knots[:-1], knots[1:]) if b - a > 100 * STEP])
    jet = program.jet(theta, 3)
    before, after = program.jet(theta - STEP, 3), program.jet(theta + STEP, 3)
    rows = []
    for order, word in ((1, "velocity"), (2, "acceleration")):
        scale = float(np.abs(jet[order]).max())
        if scale == 0.0:
            continue
        quotient = (after[order - 1] - before[order - 1]) / (2.0 * STEP)
        error = float(np.abs(quotient - jet[order]).max()) / scale
        rows.append(_row(f"{word.capitalize()} of the follower", "difference quotient", error, 1e-6, "of its peak"))
    return rows


def flank_rows(survey: Survey) -> list[tuple[Cell, ...]]:
    """Normals and relative curvature against difference quotients of the contact points."""
    low, high = survey.track.span
    phi = np.linspace(low, high, 181)[1:-1]
    knots = survey.track.knots()
    phi = phi[np.abs(phi[:, None] - knots[None, :]).min(axis=1) > 10 * STEP]
    t = survey.stations[1:-1:3]
    tilt, turned = 0.0, 0.0
    for side in survey.track.sides:
        here = Flank(survey.track, phi, t, side)
        before, after = Flank(survey.track, phi - STEP, t, side), Flank(survey.track, phi + STEP, t, side)
        along = (after.x - before.x) / (2.0 * STEP)
        length = np.sqrt((along**2).sum(axis=0))
        keep = length > 1e-3 * float(length.max())
        sine = np.abs((along * here.n).sum(axis=0)) / np.where(keep, length, 1.0)
        tilt = max(tilt, float(sine[keep].max()))
        unit = np.sqrt((here.n**2).sum(axis=0))
        turned = max(turned, float(np.abs(unit - 1.0).max()))
    return [
        _row("Normal of the flank", "at right angles to the path of the contact point", tilt, 1e-6, "rad"),
        _row("Normal of the flank", "of unit length", turned, 1e-12, "1"),
    ]


def solid_rows(model: Model) -> list[tuple[Cell, ...]]:
    """Bodies against the roller that made them, and closedness."""
    try:
        solids = [solid for solid, _ in model.workpieces]
    except CamgeomError as error:
        return [("Solid", str(error), None, None, "", False)]
    rows: list[tuple[Cell, ...]] = []
    for solid in solids:
        mesh = solid.mesh
        euler = f"watertight, one shell, genus {solid.expected_genus}"
        rows.append((f"Body {solid.name}", euler, float(abs(mesh.genus - solid.expected_genus)), 0.0, "", solid.sound))
        rows.append(
            _row(
                f"Mesh of {solid.name}",
                "sagitta of every edge on the true surface",
                solid.chord_error,
                model.tolerance,
                "mm",
            )
        )
        if solid.free_error is not None:
            free = f"Mesh of {solid.name}, faces that nothing touches"
            rows.append(_row(free, "sagitta of every edge", solid.free_error, model.free_tolerance, "mm"))
    for found in model.clearances:
        name = f"{'Face' if model.mechanism.sliders else 'Roller'} of {found.where} against the mesh"
        if np.isfinite(found.value):
            meant = model.mechanism.allowed_interference
            way = "deepest penetration over the turn" + (", beyond the preload" if meant else "")
            rows.append(_row(name, way, max(0.0, -found.value - meant), 1e-6, "mm"))
    return rows


def load_rows(model: Model) -> list[tuple[Cell, ...]]:
    """Energy of one turn: inertia takes nothing, the torque gives what friction and forces consume."""
    if not model.duties:
        return []
    duty = model.duty
    force, panels = duty.force, duty.force.panels
    moved = float(panels.integral(np.abs(force.force * force.ds)))
    if moved <= 0.0:
        return []
    idle = abs(float(panels.integral(force.inertia * force.ds))) / moved
    x = np.linspace(0.0, 2.0 * np.pi, 200_001)
    middle = 0.5 * (x[1:] + x[:-1])
    direct = float((panels.at(force.force, middle) * panels.at(force.ds, middle)).sum() * (x[1] - x[0]))
    apart = abs(direct - float(force.work())) / moved
    return [
        _row("Work of the inertia in a turn", "zero, since the motion repeats", idle, 1e-8, "of the work moved"),
        _row("Work of the cam in a turn", "sum over 200 000 steps", apart, 1e-5, "of the work moved"),
    ]


def conventions(model: Model) -> tuple[Block, ...]:
    """Peak pressure and life under each curvature convention found in the literature (groove cams)."""
    radius = model.mechanism.quoted_radius
    if not (model.duties and model.mechanism.classical) or radius is None:
        return ()
    rows: list[tuple[Cell, ...]] = [
        (name, float(peak.pressure), float(np.degrees(peak.theta)), float(life.life_h))
        for name, (peak, life) in model.duty.conventions(radius).items()
    ]
    columns = (
        Column("Curvature"),
        Column("Peak pressure", "MPa"),
        Column("Cam angle", "°"),
        Column("Roller life", "h"),
    )
    caption = f"Conventions of the literature, quoted at {number(radius)} mm; this page uses the exact surface"
    return (Table(caption, columns, tuple(rows)),)


def product_table(products: Iterable[Product]) -> Table:
    """Every product of the run so far with its files, or the reason why there are none."""
    rows = tuple((one.name, one.status, ", ".join((*one.files, *filter(None, [one.reason])))) for one in products)
    columns = (Column("Product"), Column("Status"), Column("Files, or the reason"))
    return Table("What was asked for, and what became of it", columns, rows)


def source(model: Model) -> tuple[Block, ...]:
    """The results of the source with their verdicts and reasons; nothing of a profile that names none.

    They are computed from the source's own data, whatever the profile says beside them.
    """
    name = model.profile.reproduces
    if name is None:
        return ()
    from camgeom.validation import source_named, validate
    from camgeom.validation.page import results

    document = source_named(name)
    rows, left = validate((document,), slow=False), sum(entry.slow for entry in document.entries)
    more = f", among them {left} more that take some seconds" if left else ""
    text = (
        f"{document.title}. {document.reference}. Computed from the data that the source prints, whatever this profile "
        f"says beside them; camgeom validate {name} --out DIR draws its figures anew and has all results{more}."
    )
    return (Text((text,)), *results(document, rows))


def parameters(model: Model) -> tuple[Block, ...]:
    """Every key of the profile with its value, unit and meaning; defaults included."""
    rows = tuple(_rows(model.profile, ""))
    columns = (Column("Key"), Column("Value"), Column("Meaning"))
    note = f"; {model.profile.units_note}" if model.profile.units_note else ""
    return (Table(f"The profile, with defaults{note}", columns, rows),)


def _rows(section: Section, prefix: str) -> Iterator[tuple[Cell, ...]]:
    for name, field in type(section).model_fields.items():
        extra = field.json_schema_extra
        if isinstance(extra, dict) and extra.get("internal") and name != "parameters":
            continue
        value = getattr(section, name)
        key = f"{prefix}{field.alias or name}"
        if isinstance(value, Section):
            yield from _rows(value, f"{key}.")
        elif isinstance(value, tuple) and value and all(isinstance(item, Section) for item in value):
            for i, item in enumerate(value):
                yield from _rows(item, f"{key}[{i}].")
        elif name == "parameters":
            yield from ((f"{prefix}{word}", _text(given), "parameter of the law") for word, given in value)
        elif value is not None and value != ():
            yield key, _text(value), field.description or ""


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.12g}"
    if isinstance(value, tuple):
        return ", ".join(map(_text, value))
    return str(value)


def cost(model: Model) -> tuple[Block, ...]:
    """Seconds of every fact computed so far, and the facts nobody asked for."""
    facts = ("flanks", "solids", "clearances", "mass", "duty")
    costs = model.ledger.costs
    return (Cost(tuple(costs.items()), tuple(name for name in facts if name not in costs)),)
