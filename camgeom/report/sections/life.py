"""Fatigue lives on the page: of surfaces and bearings of rollers, faces and turrets, over states and along a roller."""

from __future__ import annotations

from math import degrees, isfinite, pi
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks.verdict import ENDLESS_H, life_shown
from camgeom.drawing.content import Axis, Block, Cell, Chart, Column, Mark, Panel, Polar, Series, Table, Text, Width
from camgeom.drawing.sheet import number
from camgeom.maths import Floats
from camgeom.report.data.load import state_data
from camgeom.report.sections.film import lasting

if TYPE_CHECKING:
    from camgeom.mechanics.face_duty import FaceDuty
    from camgeom.mechanics.turret_duty import TurretDuty
    from camgeom.model import Model


def life(model: Model) -> tuple[Block, ...]:
    """Lives by part and cause, the film of oil, and where along and round the roller the damage is."""
    if model.carrier is None:
        return ()
    if model.profile.duty:
        return *life_over_states(model), *lasting(model, {})
    return *lasting(model, remarks(model)), *surface_life(model)


def remarks(model: Model) -> dict[str, str]:
    """What there is to know of the lives of the bodies, by their names."""
    found: dict[str, str] = {}
    if model.turret_duty is not None:
        turret = model.turret_duty
        if not len(turret.loaded) or not isfinite(turret.least_peak.value):
            return {}
        found = {"roller": "its points take turns in the load from passage to passage"}
        found["cam"] = f"cam angle {number(degrees(turret.least_peak.cam_angle) % 360.0)}°"
        bearing = turret.bearing
    elif model.duties:
        bearing = model.bearing
    else:
        return {"face": "sums the passes of the contact; wear comes besides"}
    if bearing is not None:
        static = f", static safety {number(float(bearing.static_safety))}" if bearing.static_safety is not None else ""
        found["bearing"] = f"equivalent load {number(float(bearing.mean_load))} N{static}"
    return found


def surface_life(model: Model) -> tuple[Block, ...]:
    """Hot spot, life along the roller and other ways to count its life; of one operating state of several its lives."""
    if model.turret_duty is not None:
        return turret_life(model.turret_duty, model.state is not None)
    if not model.duties:
        return face_life(model.drive) if model.drive is not None and model.state is not None else ()
    duty = model.duty
    if duty.no_stress:
        return (Text((f"No life of roller and cam: {duty.no_stress}.",)),)
    spot = hot_spot(model)
    along = along_roller(duty.slice_stations, np.asarray(duty.slice_life.life_h, dtype=float), 1.3, "half")
    each = (each_roller(model),) if len(model.duties) > 1 else ()
    return (*(block for block in (spot, along) if block is not None), lives(model), *each)


def life_over_states(model: Model) -> tuple[Block, ...]:
    """The damage that each operating state does, and the hardest one by itself."""
    data = [(state, state_data(state, model.own_lives)) for state in model.states]
    columns = [Column("State"), Column("Time", "%"), Column("Speed", "r/min"), Column("Pressure", "MPa")]
    columns += [Column(body.capitalize(), "%") for body in model.lives]
    damage = tuple(
        (one["name"], 100.0 * one["weight"], one["speed_rpm"], one.get("peak_pressure_mpa"),
         *(100.0 * one[f"{body}_damage_share"] for body in model.lives))
        for _, one in data
    )  # fmt: skip
    by_state = Table("Operating states, and their shares of the damage of each body", tuple(columns), damage)
    hardest = model.hardest_state
    name = hardest.state.name if hardest.state else ""
    alone = Text((f"Below: the state {name!r} by itself, as if it lasted all the time.",))
    return by_state, alone, *surface_life(hardest)


def face_life(drive: FaceDuty) -> tuple[Block, ...]:
    """Lives of the cam and of the face that slides on it; nothing of a knife edge."""
    if not drive.lives:
        return ()
    remarks = {"cam": "at its hardest point", "face": "sums the passes of the contact; wear comes besides"}
    rows: list[tuple[Cell, ...]] = [
        (f"{body.capitalize()} surface", hours(life), remarks[body]) for body, life in drive.lives.items()
    ]
    return (Table("Lives", (Column("Part"), Column("Life"), Column("Remark")), tuple(rows)),)


def hot_spot(model: Model) -> Polar | None:
    """Damage round the roller's circumference in 1000 hours, at the quoted place; None without load."""
    from camgeom.mechanics.life import damage_profile

    duty = model.duty
    life_h = float(duty.roller_life.life_h)
    if not isfinite(life_h) or life_h <= 0.0:
        return None
    spot = float(duty.roller_life.hot_spot)
    turn = np.sort(np.r_[np.linspace(0.0, 2.0 * pi, 361), spot])
    damage = damage_profile(duty.contact, duty.roller, duty.quoted.radius, turn)
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


def along_roller(x: Floats, lives: Floats, height: float = 1.0, width: Width = "full") -> Chart | None:
    """Roller life, h, over the place x along its axis; None where all are unlimited, or one has no end."""
    if not np.all(np.isfinite(lives)) or float(lives.min()) >= ENDLESS_H:
        return None
    worst, order = int(np.argmin(lives)), np.argsort(x)
    marks = (Mark(float(x[worst]), float(lives[worst]), hours(lives[worst])),)
    panel = Panel(
        Axis("Roller life", "h", zero=True), (Series("life", x[order], lives[order]),), marks=marks, height=height
    )
    return Chart("Life of the roller's slices", Axis("Along the roller axis", "mm"), (panel,), width=width)


def each_roller(model: Model) -> Table:
    """What each of a pair's rollers bears, and how long it and its disc live."""
    columns = [Column("Roller"), Column("Size", "mm"), Column("Force", "N"), Column("Pressure", "MPa")]
    bodies = list(dict.fromkeys(body for duty in model.duties for body in duty.lives))
    rows = []
    for duty in model.duties:
        peak = duty.peak_pressure
        size = f"⌀ {number(2.0 * duty.radius)} × {number(duty.length)}"
        row: tuple[Cell, ...] = (duty.track.name, size, duty.peak_force.value, None if peak is None else peak.value)
        rows.append((*row, *(hours(duty.lives[body]) if body in duty.lives else "" for body in bodies)))
    columns += [Column("Disc life" if body == "cam" else f"{body.capitalize()} life") for body in bodies]
    return Table("Each roller with its disc", tuple(columns), tuple(rows))


def lives(model: Model) -> Table:
    """Life of the hardest pressed roller and its disc or flank where it is quoted; all of one state of several."""
    duty = model.duty
    roller = duty.roller_life
    cam = duty.cam_life
    spot = f"hot spot at {number(degrees(float(roller.hot_spot)) % 360.0)}° of the roller"
    rows: list[tuple[Cell, ...]] = [
        ("Roller, at the quoted place", hours(roller.life_h), spot),
        ("Roller there, damage spread evenly", hours(roller.spread_life_h),
         "upper bound: the roller slips from turn to turn"),
        ("Cam surface, at the quoted place", hours(cam.life_h), f"cam angle {number(degrees(float(cam.theta)))}°"),
    ]  # fmt: skip
    if model.state is not None:
        rows.insert(1, ("Roller, worst slice", hours(duty.lives["roller"]), "along the roller"))
        rows.append(("Cam surface, worst slice", hours(duty.lives["cam"]), "along the roller"))
        rows += [("Roller bearing", hours(duty.bearing.life_h), "L10")] if duty.bearing is not None else []
    rows.append(("Path rolled in a turn", f"{number(1e-3 * float(roller.path))} m", "at the quoted place"))
    caption = "Lives of the state by itself" if model.state is not None else "Lives at the place that sources quote"
    return Table(caption, (Column("Part"), Column("Life"), Column("Remark")), tuple(rows))


def turret_life(duty: TurretDuty, alone: bool) -> tuple[Block, ...]:
    """The roller's life along its axis and the way it rolls; of one state of several (`alone`) its lives."""
    if not len(duty.loaded) or not isfinite(duty.least_peak.value):
        return ()
    if duty.no_stress:
        return (Text((f"No life of roller and cam: {duty.no_stress}.",)),)
    along = along_roller(duty.tracks[0].meridian.jet(duty.engagement.stations)[0], duty.slice_life)
    rolled = Text((f"A roller rolls {number(duty.path_per_turn * 1e-3)} m in a turn of the cam, on average.",))
    found: tuple[Block, ...] = (rolled,) if along is None else (along, rolled)
    if not alone:
        return found
    rows: list[tuple[Cell, ...]] = [
        ("Roller, worst slice", hours(duty.roller_life), "along the roller"),
        ("Cam surface", hours(duty.cam_life), f"cam angle {number(degrees(duty.least_peak.cam_angle))}°"),
    ]
    rows += [("Roller bearing", hours(duty.bearing.life_h), "L10")] if duty.bearing is not None else []
    caption = "Lives of the state by itself"
    return (Table(caption, (Column("Part"), Column("Life"), Column("Remark")), tuple(rows)), *found)


def hours(value: float | Floats) -> str:
    """A life in words."""
    shown = life_shown(float(value))
    return shown if isinstance(shown, str) else f"{number(shown)} h"
