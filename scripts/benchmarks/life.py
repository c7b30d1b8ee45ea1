"""Fatigue life: many variants in one call against one variant at a time, and how time and memory grow; the rated
bearing, the film, and operating states.

A two-stroke groove cam with inertia and friction; the variants differ in roller radius.
"""

from __future__ import annotations

import math
import resource
from pathlib import Path
from typing import Any

import numpy as np
from kit import Table, best, milli, run, short

from camgeom.mechanics import groove
from camgeom.mechanics.bearing import bearing_life, modified
from camgeom.mechanics.film import Oil, line_film
from camgeom.mechanics.groove import groove_contact
from camgeom.mechanics.life import roller_life
from camgeom.mechanics.load import FollowerForce, Load
from camgeom.mechanics.material import STEEL
from camgeom.mechanics.rating import Lubrication, Rating
from camgeom.model import Model
from camgeom.motion import Program, Segment
from camgeom.profile import parse

ROOT = Path(__file__).resolve().parents[2]
SPEED = 60.0


def shuttle() -> FollowerForce:
    """A two-stroke motion with dwells, inertia and friction."""
    turn = 2.0 * math.pi
    program = Program.from_segments([
        Segment(0.4 * turn), Segment(0.6 * turn, 40.0, "cycloidal"), Segment(0.78 * turn, 74.0, "modified-sine"),
        Segment(0.8 * turn), Segment(turn, 0.0, "cycloidal")])
    return Load(program, SPEED, 2.25, 8.3).sampled()


def life(load: FollowerForce, radius: Any) -> Any:
    """Life for one roller radius or an array of them, mm."""
    return roller_life(groove_contact(load, 67.0, radius, 12.0, STEEL, STEEL, "flat"), STEEL, radius, SPEED)


def tables(quick: bool) -> list[Table]:
    """Variants from one to ten thousand."""
    load = shuttle()
    one, _ = best(lambda: life(load, 11.0), 9)
    rows = [{"variants": 1, "time_ms": milli(one), "us_a_variant": short(one * 1e6), "gain": 1.0,
             "peak_memory_mb": memory()}]
    for count in (10, 100, 1000) if quick else (10, 100, 1000, 10_000):
        radii = np.linspace(5.0, 13.0, count)
        seconds, _ = best(lambda r=radii: life(load, r), 3)
        rows.append({"variants": count, "time_ms": milli(seconds), "us_a_variant": short(seconds / count * 1e6),
                     "gain": short(count * one / seconds, 3), "peak_memory_mb": memory()})
    note = "gain: against as many calls of one variant each."
    return [Table("life", "Roller life of many variants in one call", rows, note), rated(load, quick), states(quick)]


def rated(load: FollowerForce, quick: bool) -> Table:
    """The roller's bearing with a_ISO, and the film, of many variants in one call."""
    rate, normal = groove.path_rate(67.0, load.ds), load.normal(groove.cos_pressure_angle(67.0, load.ds))
    oil, rows = Lubrication(700.0, 0.5, 14.0, 25.0), []
    for count in (1, 100, 1000) if quick else (1, 100, 1000, 10_000):
        radii, ratings = np.linspace(5.0, 13.0, count), np.linspace(4e3, 9e3, count)
        spread = normal[None] * np.ones((count, 1, 1))
        seconds, _ = best(lambda r=radii, c=ratings, n=spread: modified(
            bearing_life(load.panels, n, rate, r, SPEED, c, 1.3 * c), Rating(1.0, lubrication=oil)), 3)
        film, _ = best(lambda r=radii, n=spread: line_film(
            SPEED * rate, 1.0 / r[:, None, None], np.abs(n) / 12.0 + 1.0, Oil(4e-8, 0.022, 3e-4), 9e-6), 3)
        rows.append({"variants": count, "bearing_ms": milli(seconds), "film_ms": milli(film)})
    return Table("rated", "Rated bearing (a_ISO) and film of many variants in one call", rows,
                 "film: at every point of the turn")  # fmt: skip


def states(quick: bool) -> Table:
    """Lives over several operating states of the pin cam, beside one."""
    text, rows = (ROOT / "profiles" / "pin_insertion.toml").read_text(), []
    for count in (1, 2, 4) if quick else (1, 2, 4, 8, 16):
        # The first state runs at the speed of [operation].
        speeds = ["", *(f"speed = {400 + 20 * k}\n" for k in range(1, count))]
        duty = "".join(f"\n[[duty]]\n{speed}hours = {100 + k}\n" for k, speed in enumerate(speeds))
        profile = parse(text + duty)
        seconds, _ = best(lambda p=profile: Model(p).lives, 3)
        rows.append({"states": count, "time_ms": milli(seconds), "ms_a_state": short(1e3 * seconds / count)})
    return Table("states", "Lives of the pin cam over its operating states", rows, "each state is solved by itself")


def memory() -> float:
    """Peak memory of this process so far, MB."""
    return short(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3, 3)


if __name__ == "__main__":
    run(tables, __doc__)
