"""Triangles of drums, end faces and indexing cams, as one regular grid and as bodies have them by default.

The fewest triangles with vertices on a surface and a chord error e cover 3 sqrt(3)/2 e / sqrt(K) each where it is bent
to one side, and 2 sqrt(5) e / sqrt(-K) where it is bent both ways (K the Gaussian curvature; Pottmann, Krasauskas,
Hamann, Joy and Seibold, J. Geometry and Graphics 4, 2000). Surfaces without curvature of both kinds, as in dwells, ask
for none by that count, but their edges do: a chord of h is off by L h² / 8, L by the more bent of the two surfaces that
meet in it, and a ring of triangles has at least one for each link of both its edges. With edges: the larger of both
counts at every angle of the turn. The error is that of tests/oracle, which places the follower from
the profile's keys and shares no code with what it measures, on points of facets drawn at random.
"""

from __future__ import annotations

import sys
import tomllib
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from kit import ROOT, Row, Table, run, short

sys.path.append(str(ROOT / "scripts" / "stability"))

from judging import judge

from camgeom.maths.banded import Band, forms_of, plan
from camgeom.maths.sampling import subdivided_knots
from camgeom.model import Model, read
from camgeom.solid import Part, Solid
from camgeom.solid import fewest as mesher
from camgeom.solid.cut import IndexingCut
from camgeom.solid.round import land_steps

ELLIPTIC, HYPERBOLIC = 1.5 * 3.0**0.5, 2.0 * 5.0**0.5
CELLS = 400
TURNS = 4
"""times that a body is made, of which the quickest counts"""


def least(bands: Sequence[Band], knots: np.ndarray, error: float) -> tuple[Counter[str], Counter[str]]:
    """Least numbers of triangles of the bands between two lands, by name: by quadrature of their second forms, and with
    what their edges ask for."""
    theta = subdivided_knots(knots, CELLS)
    step = np.diff(theta)
    forms = forms_of(bands, theta)
    bent = forms.L * forms.N - forms.M**2
    inside = (np.sqrt(np.abs(bent)) / np.where(bent > 0.0, ELLIPTIC, HYPERBOLIC)).sum(axis=1) / plan.ACROSS / error
    # A chord of an edge is within the error of the surfaces on both of its sides; without width there is none.
    wide = forms.width > error
    links = np.zeros((len(bands) + 1, len(step)))
    links[[0, -1]] = 1.0 / land_steps((0.0, 0.0), error, theta[:-1] + 0.5 * step, forms.ends)
    for side, own in enumerate((links[:-1], links[1:])):
        np.maximum(own, np.where(wide, np.sqrt(np.abs(forms.edges[side]) / (8.0 * error)), 0.0), out=own)
    with_edges = np.where(wide, np.maximum(inside, links[:-1] + links[1:]), 0.0)
    found: tuple[Counter[str], Counter[str]] = Counter(), Counter()
    for counter, density in zip(found, (inside, with_edges)):
        for band, own in zip(bands, density):
            counter[band.name] += float((own * step).sum())
    return found


def surfaces(model: Model) -> list[tuple[Sequence[Band], np.ndarray]] | None:
    """Bands and knots of all that runs round the axis; None where no body is made so. Those of indexing cams run on
    beyond the ends, and are left out."""
    if any(isinstance(part, IndexingCut) for part in model.parts):
        return []
    bodies = [mesher.round_body(part, model.tolerance) for part in model.parts]
    found = [(run.bands, run.knots) for body in bodies if body is not None for run in body.runs]
    return found or None


def figures(model: Model, make: Callable[[Part, float], Solid], data: dict[str, Any]) -> dict[str, Any]:
    """Triangles by band, processor time, s, and errors stated and measured, mm, of the bodies made one way."""
    times = []
    for _ in range(TURNS):
        began = process_time()
        solids = [make(part, model.tolerance) for part in model.parts]
        times.append(process_time() - began)
    count: Counter[str] = Counter()
    for solid in solids:
        count.update(np.array(solid.mesh.groups)[solid.mesh.face_groups].tolist())
    record = judge(data)
    measured = record["error"] * model.tolerance if "error" in record else float("nan")
    stated = max(solid.chord_error for solid in solids)
    return {"count": count, "seconds": min(times), "stated": stated, "measured": measured}


def row(path: Path) -> Row | None:
    """The row of a profile; None where bodies are regular grids."""
    data = tomllib.loads(path.read_text())
    model = read(str(path))
    bands = surfaces(model)
    if bands is None:
        return None
    regular = data | {"output": data.get("output", {}) | {"fewest_triangles": False}}
    before = figures(model, lambda part, tolerance: part.solid(tolerance), regular)
    after = figures(model, mesher.fewest, data)
    fewest: tuple[Counter[str], Counter[str]] = Counter(), Counter()
    for body in bands:
        for counter, own in zip(fewest, least(*body, after["stated"])):
            counter.update(own)
    found: Row = {"profile": path.stem, "tolerance_um": short(model.tolerance * 1e3)}
    for kind, names in (("", None), ("flank_", ("flank",)), ("rim_", ("edge", "root"))):
        was, now = (
            sum(n for name, n in one["count"].items() if names is None or name in names) for one in (before, after)
        )
        found |= {f"{kind}triangles_before": was, f"{kind}triangles": now}
        if names is not None:
            for label, counter in zip(("of_fewest", "of_fewest_with_edges"), fewest):
                possible = sum(counter[name] for name in names)
                found[f"{kind}{label}"] = short(now / possible, 3) if possible >= 1.0 else ""
    for label, one in (("_before", before), ("", after)):
        found[f"time_ms{label}"] = short(one["seconds"] * 1e3, 3)
        found[f"stl_mb{label}"] = short((84 + 50 * one["count"].total()) * 1e-6, 3)
        found[f"stated_um{label}"] = short(one["stated"] * 1e3, 3)
        found[f"measured_um{label}"] = short(one["measured"] * 1e3, 3)
    return found


def tables(quick: bool) -> list[Table]:
    """A row a profile that has a drum, an end face or an indexing cam."""
    rows = [found for path in sorted((ROOT / "profiles").glob("*.toml")) if (found := row(path)) is not None]
    note = ("Rims: what the edge of the roller's end sweeps, or the root. Of fewest: times the fewest possible, by "
            "curvature alone and with edges.")  # fmt: skip
    return [Table("fewest", "Triangles of drums and indexing cams against the fewest possible", rows, note)]


if __name__ == "__main__":
    run(tables, __doc__)
