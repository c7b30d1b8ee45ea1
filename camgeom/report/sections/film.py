"""How long it lasts, part by part and cause by cause, and the film of oil over the turn."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import degrees, isfinite
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks.verdict import life_shown
from camgeom.drawing.content import CAM_ANGLE, Axis, Block, Cell, Chart, Column, Limit, Mark, Panel, Series, Table
from camgeom.drawing.sheet import number
from camgeom.errors import CamgeomError, unmade
from camgeom.report.sections.motion import zones

if TYPE_CHECKING:
    from camgeom.mechanics.film import Film
    from camgeom.model import Model

FULL = 3.0
"""lambda from which on the surfaces are taken to be parted"""
MOST_SHOWN = 10.0
"""times the least lambda, up to which the chart shows it: a nearly unloaded contact has a film without meaning"""


def lasting(model: Model, remarks: Mapping[str, str]) -> tuple[Block, ...]:
    """The lives by part and cause, and lambda over the turn of the operating state with the thinnest film.

    remarks  what there is to know of the life of a body, by its name
    """
    rows = tuple(_causes(model, remarks))
    columns = (Column("Part"), Column("Cause"), Column("Life"), Column("How"))
    blocks: tuple[Block, ...] = (Table("Life by part and cause", columns, rows),) if rows else ()
    states = [one for one in model.states if one.film is not None]
    thinnest = min(states, key=lambda one: one.film.least.value if one.film else np.inf, default=None)
    if thinnest is None or thinnest.film is None:
        return blocks
    return *blocks, _over_turn(thinnest, thinnest.film)


def _causes(model: Model, remarks: Mapping[str, str]) -> Iterator[tuple[Cell, ...]]:
    """Part, cause, life and how it was found."""
    more = {body: f"; {text}" for body, text in remarks.items()}
    over = "Miner's sum over the operating states, " if model.profile.duty else ""
    for body, hours in model.lives.items():
        if body == "bearing":
            yield body.capitalize(), "rolling fatigue", _hours(hours), over + _rated(model) + more.get(body, "")
        else:
            how = f"{over}at the hardest place{more.get(body, '')}"
            yield body.capitalize(), "contact fatigue", _hours(hours), how
    yield from _shaken(model, over)
    limit = model.profile.limits.wear_um
    for body, depth in model.wear_per_hour.items():
        life = 1e-3 * limit / depth if limit is not None and depth > 0.0 else None
        shown = "-" if limit is None else _hours(life if life is not None else float("inf"))
        until = "" if limit is None else f"until {number(limit)} um, "
        yield body.capitalize(), "sliding wear", shown, f"{until}{number(1e6 * depth)} um in 1000 h (Archard)"


def _shaken(model: Model, over: str) -> Iterator[tuple[Cell, ...]]:
    """The lives under the force that [dynamics] solves; where it could not be solved, why: the others stand."""
    if model.profile.dynamics_spec is None:
        return
    try:
        lives = model.dynamic_lives if all(state.dynamic_duties for state in model.states) else {}
    except (CamgeomError, MemoryError) as why:
        yield "All", "the same with vibration", "-", unmade(why).reason
        return
    for body, hours in lives.items():
        yield body.capitalize(), "the same with vibration", _hours(hours), over + "under the solved force"


def _hours(value: float) -> str:
    shown = life_shown(value if isfinite(value) else None)
    return shown if isinstance(shown, str) else f"{number(shown)} h"


def _rated(model: Model) -> str:
    """How the bearing is rated."""
    bearing = model.states[0].bearing
    words = f"ISO 281 at {model.profile.limits.bearing_reliability} %"
    if bearing is None or bearing.factor is None or bearing.ratio is None:
        return f"{words}, well lubricated and clean (a_ISO = 1)"
    if model.profile.duty:
        return f"{words}, a_ISO of every state"
    return f"{words}, a_ISO = {number(float(bearing.factor))} (kappa {number(float(bearing.ratio))})"


def _over_turn(model: Model, film: Film) -> Chart:
    """Lambda over the turn, where something bears, with its least value."""
    least = film.least
    shown = np.minimum(film.ratio, MOST_SHOWN * max(least.value, FULL / MOST_SHOWN))
    angle = degrees(least.cam_angle) % 360.0
    limits = model.profile.limits
    lines = [Limit(limits.warn_film_ratio, "surfaces touch")] if limits.film_ratio is None else []
    lines += [Limit(limits.film_ratio, "least allowed")] if limits.film_ratio is not None else []
    name = f", state {model.state.name!r}" if model.state is not None else ""
    panel = Panel(
        Axis("Film over roughness, lambda", zero=True), (Series("lambda", np.degrees(film.theta), shown),),
        limits=tuple(lines), marks=(Mark(angle, least.value, f"{number(least.value)} at {number(angle)}°"),),
    )  # fmt: skip
    caption = f"Oil film between the hardest slices, {number(1e3 * film.thickness)} um at its thinnest{name}"
    return Chart(caption, CAM_ANGLE, (panel,), zones(model.setup.program))
