"""Equal-error sampling against uniform steps of the cam angle, on every profile, at equal measured error.

Each surface that a profile's bodies sample is sampled again with even steps (knots of the motion kept, so that both
follow the same kinks) and the same cells across, as many as it takes for the same measured error.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from kit import ROOT, Row, Table, best, run, short

from camgeom.maths import sampling as strips
from camgeom.maths.sampling import Grid, measure
from camgeom.model import read

MOST = 4_000_000


def calls_of(profile: str) -> list[tuple[tuple[Any, ...], Grid]]:
    """Every call of `sample` while the profile's bodies are made, with its result."""
    from camgeom.solid import cut as turret_cut
    from camgeom.solid import drum as solid
    from camgeom.solid import prism

    found: list[tuple[tuple[Any, ...], Grid]] = []
    true = strips.sample

    def record(*arguments: Any) -> Grid:
        grid = true(*arguments)
        found.append((arguments, grid))
        return grid

    homes = [module for module in (prism, solid, turret_cut) if getattr(module, "sample", None) is true]
    for module in homes:
        module.sample = record
    try:
        model = read(profile)
        for part in model.parts:
            # Indexing cams sample all their grooves at once; their groove bodies, one by one, are what compares.
            getattr(part, "cut", part.solid)(model.tolerance)
    finally:
        for module in homes:
            module.sample = true
    return found


def even(knots: np.ndarray, count: int) -> np.ndarray:
    """About `count` even steps over the span of the knots, with the knots among them."""
    step = (knots[-1] - knots[0]) / count
    pieces = [
        np.linspace(low, high, max(1, int(np.ceil((high - low) / step - 1e-9))), endpoint=False)
        for low, high in zip(knots[:-1], knots[1:])
    ]
    return np.append(np.concatenate(pieces), knots[-1])


def error(section: Any, phi: np.ndarray, counts: tuple[int, ...]) -> float:
    """Measured chord error of a grid at these angles, in blocks to bound the memory."""
    worst = 0.0
    block = max(1, 2_000_000 // sum(counts))
    for low in range(0, len(phi) - 1, block):
        part = phi[low : low + block + 1]
        corner = section(part, counts)
        middle = section(0.5 * (part[1:] + part[:-1]), tuple(2 * c for c in counts))
        worst = max(worst, float(measure(corner[:, :-1], corner[:, 1:], middle).error()[0].max()))
    return worst


def even_steps(section: Any, knots: np.ndarray, counts: tuple[int, ...], target: float, first: int) -> int:
    """Least number of even steps (to half a percent) with at most the target error."""
    high = first
    while error(section, even(knots, high), counts) > target and high * sum(counts) < MOST:
        high *= 2
    low = high // 2
    while high - low > max(1, high // 200):
        middle = (low + high) // 2
        if error(section, even(knots, middle), counts) > target:
            low = middle
        else:
            high = middle
    return len(even(knots, high)) - 1


def tables(quick: bool) -> list[Table]:
    """A row a profile: cells of both ways at the same error."""
    rows: list[Row] = []
    for path in sorted((ROOT / "profiles").glob("*.toml")):
        ours = theirs = 0
        worst = 0.0
        for arguments, grid in calls_of(str(path)):
            section, knots = arguments[0], np.asarray(arguments[1])
            target = error(section, grid.phi, grid.counts)
            steps = even_steps(section, knots, grid.counts, target, 32)
            ours += (len(grid.phi) - 1) * sum(grid.counts)
            theirs += steps * sum(grid.counts)
            worst = max(worst, target)
        if ours:
            model = read(str(path))
            seconds, _ = best(lambda m=model: [part.solid(m.tolerance) for part in m.parts], 2)
            rows.append({"profile": path.stem, "error_um": short(worst * 1e3), "cells_equal_error": ours,
                         "cells_even": theirs, "ratio": short(theirs / ours, 3), "solid_ms": short(seconds * 1e3)})
    note = "ratio: how many times more cells even steps need at the same measured error. solid: all bodies."
    return [Table("sampling", "Cells at equal measured error", rows, note)]


if __name__ == "__main__":
    run(tables, __doc__)
