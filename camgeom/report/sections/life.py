"""Fatigue life: damage round the roller with its hot spot, life along the roller, and the lives in numbers."""

from __future__ import annotations

from math import degrees, isfinite, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.drawing.content import Axis, Block, Cell, Chart, Column, Mark, Panel, Polar, Series, Table
from camgeom.drawing.numerals import number

if TYPE_CHECKING:
    from camgeom.model import Model


def life(model: Model) -> tuple[Block, ...]:
    """Hot spot, life along the roller and the table of lives."""
    if model.turret_loaded:
        from camgeom.report.sections.turret import life as shared

        return shared(model)
    if not model.loaded:
        return ()
    blocks: list[Block] = []
    spot = hot_spot(model)
    along = along_roller(model)
    blocks += [block for block in (spot, along) if block is not None]
    return (*blocks, lives(model))


def hot_spot(model: Model) -> Polar | None:
    """Damage round the roller's circumference in 1000 hours, at the quoted place; None without load."""
    from camgeom.mechanics.life import damage_profile

    duty = model.duty
    life_h = float(duty.roller_life.life_h)
    if not isfinite(life_h) or life_h <= 0.0:
        return None
    spot = float(duty.roller_life.hot_spot)
    turn = np.sort(np.r_[np.linspace(0.0, 2.0 * pi, 361), spot])
    damage = damage_profile(duty.contact, duty.roller, duty.radius, turn)
    per = 1000.0 * 3600.0 * duty.speed / (2.0 * pi)
    angle = degrees(spot) % 360.0
    mark = Mark(angle, 1000.0 / life_h, f"hot spot {number(angle)}°")
    series = (Series("damage", np.degrees(turn), damage * per),)
    return Polar(
        "Damage round the roller in 1000 h (failure at 1); angle in its sense of rolling",
        Axis("Damage in 1000 h"),
        series,
        (mark,),
    )


def along_roller(model: Model) -> Chart | None:
    """Roller life over the place along its axis; None where a slice lives for ever."""
    duty = model.duty
    hours = np.asarray(duty.slice_life.life_h, dtype=float)
    if not np.all(np.isfinite(hours)):
        return None
    x = duty.slice_stations
    worst = int(np.argmin(hours))
    mark = Mark(float(x[worst]), float(hours[worst]), f"{number(float(hours[worst]))} h")
    panel = Panel(Axis("Roller life", "h", zero=True), (Series("life", x, hours),), marks=(mark,), height=1.3)
    return Chart("Life of the roller's slices", Axis("Along the roller axis", "mm"), (panel,), width="half")


def lives(model: Model) -> Table:
    """Life of roller, cam and bearing."""
    duty = model.duty
    roller = duty.roller_life
    cam = duty.cam_life
    spot = f"hot spot at {number(degrees(float(roller.hot_spot)) % 360.0)}° of the roller"
    rows: list[tuple[Cell, ...]] = [
        ("Roller, at the quoted place", _hours(roller.life_h), spot),
        ("Roller, worst slice", _hours(np.min(duty.slice_life.life_h)), "along the roller"),
        (
            "Roller, damage spread evenly",
            _hours(roller.spread_life_h),
            "upper bound: the roller slips from turn to turn",
        ),
        ("Cam surface", _hours(cam.life_h), f"cam angle {number(degrees(float(cam.theta)))}°"),
    ]
    spec = model.setup.roller
    if spec is not None and spec.dynamic_rating is not None:
        bearing = duty.bearing(spec.dynamic_rating, spec.static_rating)
        rows.append(
            ("Roller bearing, L10", _hours(bearing.life_h), f"equivalent load {number(float(bearing.mean_load))} N")
        )
    rows.append(("Path rolled in a turn", f"{number(1e-3 * float(roller.path))} m", "at the quoted place"))
    return Table("Lives", (Column("Part"), Column("Life"), Column("Remark")), tuple(rows))


def _hours(value: object) -> str:
    hours = float(value)  # type: ignore[arg-type]
    return f"{number(hours)} h" if isfinite(hours) else "unlimited"
