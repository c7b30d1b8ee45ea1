"""Distance to the limits: triangles against the fewest possible, evaluation against memory bandwidth.

The fewest triangles with vertices on a surface and a chord error e: on an elliptic patch an area of 3 sqrt(3)/2 e /
sqrt|K| each, on a hyperbolic one 2 sqrt(5) e / sqrt|K| (K the Gaussian curvature; Pottmann, Krasauskas, Hamann, Joy and
Seibold, On piecewise linear approximation of quadratic functions, 2000). The bound holds for small e and a free choice
of triangles; a structured grid that closes without a seam cannot reach it.
"""

from __future__ import annotations

import numpy as np
from kit import ROOT, Row, Table, best, milli, run, short

from camgeom.model import read
from camgeom.solid.drum import GroovedCylinder
from camgeom.track.flank import Flank

ELLIPTIC, HYPERBOLIC = 1.5 * 3.0**0.5, 2.0 * 5.0**0.5


def fewest(track, low: float, high: float, error: float) -> float:
    """Least number of triangles of both flanks between two depths, by quadrature of the curvature."""
    knots = track.knots()
    phi = np.unique(np.concatenate([a + (b - a) * (np.arange(400) + 0.5) / 400 for a, b in zip(knots, knots[1:])]))
    t = np.linspace(low, high, 41)
    middle = 0.5 * (t[1:] + t[:-1])
    width = np.gradient(phi)
    total = 0.0
    for side in (1.0, -1.0):
        flank = Flank(track, phi, middle, side)
        forms = flank.forms
        first = forms.E * forms.G - forms.F**2
        second = forms.L * forms.N - forms.M**2
        # sqrt|K| dA = sqrt(|LN - M²| / (EG - F²)) sqrt(EG - F²) dphi dt
        density = np.sqrt(np.abs(second)) / np.where(second > 0.0, ELLIPTIC, HYPERBOLIC)
        assert np.all(first > 0.0)
        total += float(np.sum(density * width[:, None]) * (t[1] - t[0])) / error
    return total


def triangle_rows(quick: bool) -> list[Row]:
    """Flank triangles of the drum against the fewest."""
    model = read(str(ROOT / "profiles" / "pin_insertion.toml"))
    cam = model.cam.model_copy(update={"keyway_width": 0.0, "keyway_depth": 0.0})
    (track,) = cam.mechanism(model.setup).cutters
    part = GroovedCylinder("cam", track, cam.mechanism(model.setup).blank, cam.radius, cam.length)
    low, high = (track.meridian.parameter(r) for r in (cam.radius - cam.groove_depth, cam.radius))
    rows = []
    for tolerance in (0.02, 0.005, 0.001) if quick else (0.02, 0.005, 0.001, 1e-4):
        solid = part.solid(tolerance)
        mesh = solid.mesh
        assert mesh.group is not None
        count = int(np.sum(mesh.group == mesh.groups.index("flank")))
        least = fewest(track, low, high, solid.chord_error)
        rows.append({"tolerance_um": short(tolerance * 1e3), "flank_triangles": count, "fewest": round(least),
                     "ratio": short(count / least, 3), "whole_mesh": len(mesh.faces)})
    return rows


def first_order(flank: Flank) -> object:
    return flank.points, flank.normals


def second_order(flank: Flank) -> object:
    return flank.k_rel, flank.pressure_angle()


def bandwidth_rows(quick: bool) -> list[Row]:
    """Points and normals of a flank, second-order values too, beside a copy of the bytes they are."""
    model = read(str(ROOT / "profiles" / "pin_insertion.toml"))
    (track,) = model.cutters
    t = np.linspace(54.0, 67.0, 20)
    rows = []
    for count in (1000, 50_000) if quick else (1000, 10_000, 100_000):
        phi = np.linspace(0.0, 2.0 * np.pi, count)
        size = 6 * count * len(t)
        source, sink = np.ones(size), np.empty(size)
        copy, _ = best(lambda a=sink, b=source: np.copyto(a, b), 9)
        works = {
            "points and normals": lambda p=phi: first_order(Flank(track, p, t, 1.0)),
            "curvature and pressure angle": lambda p=phi: second_order(Flank(track, p, t, 1.0)),
        }
        for name, work in works.items():
            seconds, _ = best(work, 7)
            rows.append({"what": name, "points": count * len(t), "time_ms": milli(seconds),
                         "ns_a_point": short(seconds * 1e9 / (count * len(t)), 3),
                         "gb_s_of_results": short(8e-9 * size / seconds, 3), "copy_gb_s": short(16e-9 * size / copy, 3),
                         "times_a_copy": short(seconds / copy, 3)})
    return rows


def tables(quick: bool) -> list[Table]:
    """Both limits."""
    title = "Flank triangles of the groove cam against the fewest possible"
    return [
        Table("limits_triangles", title, triangle_rows(quick)),
        Table("limits_bandwidth", "Evaluating a flank against copying as many numbers", bandwidth_rows(quick),
              "copy: bytes read and written a second by numpy; six numbers a point."),
    ]


if __name__ == "__main__":
    run(tables, __doc__)
