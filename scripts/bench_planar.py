"""Disc cams: profile error against time, beside a cam package and polygon offsetting; solids at several tolerances.

    python scripts/bench_planar.py [--venv DIR] [--offline] [--json FILE]

The cam is the reference disc: base circle 30, roller radius 10, cycloidal rise of 20 mm. The peers, `mechanism` (PyPI)
and the offsetting of `shapely`, are installed into a throwaway environment (or DIR, which is kept and reused); without
a network, or with --offline, they are left out and the script says so. Every error is the distance of vertices and edge
middles from the nearest roller position, by tests/oracle.py, which shares no code with what it measures.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
TURN = 2.0 * np.pi
BASE, ROLLER, LIFT = 30.0, 10.0, 20.0
COUNTS = (360, 3600, 36000)
PROFILE = """
name = "reference disc"
[cam]
kind = "disc"
base_radius = 30
width = 12
bore = 20
[follower]
kind = "translating"
[roller]
diameter = 20
length = 12
[[motion]]
until = 120
to = 20
law = "cycloidal"
[[motion]]
until = 150
[[motion]]
until = 270
to = 0
law = "cycloidal"
[[motion]]
until = 360
"""


def best(work, runs: int = 15):
    """Shortest time of some runs, s, and the last result."""
    times, result = [], None
    for _ in range(runs):
        began = perf_counter()
        result = work()
        times.append(perf_counter() - began)
    return min(times), result


def lift(theta):
    """The motion written out by hand, for the peers and the oracle: cycloidal rise, dwell, cycloidal return, dwell."""
    x = np.degrees(np.mod(theta, TURN))
    up, down = np.clip(x / 120.0, 0.0, 1.0), np.clip((x - 150.0) / 120.0, 0.0, 1.0)
    wave = [share - np.sin(TURN * share) / TURN for share in (up, down)]
    return LIFT * (wave[0] - wave[1])


def peers(out: Path) -> None:
    """Run in the peers' own environment: profiles and times into an npz file, base circles into a json beside it."""
    import shapely
    from mechanism.cams import Cam

    found = {}
    motion = [("Rise", LIFT, 120), ("Dwell", 30), ("Fall", LIFT, 120), ("Dwell", 90)]
    for count in COUNTS:

        def package(count=count):
            cam = Cam(motion=motion, degrees=True, omega=1.0, h=TURN / count)
            return cam.cycloidal.get_profile(BASE, cam.thetas_r)

        def offset(count=count):
            theta = np.arange(count) * TURN / count
            pitch = (BASE + ROLLER + lift(theta))[:, None] * np.stack([np.cos(theta), -np.sin(theta)], 1)
            return shapely.get_coordinates(shapely.Polygon(pitch).buffer(-ROLLER, quad_segs=64))

        for name, work, runs in (("mechanism", package, 5), ("shapely", offset, 3 if count > 5000 else 7)):
            seconds, points = best(work, runs)
            points = np.stack(points, 1) if isinstance(points, tuple) else points
            found[f"{name}/{count}"], found[f"{name}/{count}/s"] = points, np.array(seconds)
    cam = Cam(motion=motion, degrees=True, omega=1.0, h=TURN / 3600)
    for offset_mm in (0.0, 8.0):
        keys = {"roller_radius": ROLLER, "eccentricity": offset_mm, "max_pressure_angle": 25.0}
        seconds, sized = best(lambda keys=keys: cam.get_base_circle("cycloidal", "roller", **keys), 5)
        found[f"base/{offset_mm:g}"] = np.array([float(sized["Rb"]), seconds])
    np.savez(out, **found)


def run_peers(folder: Path, out: Path) -> str:
    """Install and run the peers; the reason where that fails, else empty."""
    python = folder / "bin" / "python"
    steps = [] if python.exists() else [[sys.executable, "-m", "venv", str(folder)]]
    steps.append([str(python), "-m", "pip", "install", "--quiet", "mechanism", "shapely", "numpy"])
    steps.append([str(python), __file__, "--peers", str(out)])
    for step in steps:
        run = subprocess.run(step, capture_output=True, text=True, check=False, env={"MPLBACKEND": "Agg", "PATH": ""})
        if run.returncode:
            return (run.stderr.strip().splitlines() or ["no message"])[-1]
    return ""


def error(points: np.ndarray, most: int = 1200) -> float:
    """Largest deviation of vertices and edge middles (n, 2) from the true profile, mm."""
    from oracle import roller_distance, swept_distance

    def pose(phi):
        r, zero = BASE + ROLLER + lift(phi), np.zeros_like(phi)
        up = np.broadcast_to([0.0, 0.0, 1.0], (*phi.shape, 3))
        return np.stack([r * np.cos(phi), -r * np.sin(phi), zero], -1), up

    def distance(x, a, u):
        return roller_distance(x, a, u, ROLLER, -1e6)

    both = np.concatenate([points, 0.5 * (points + np.roll(points, -1, axis=0))])
    if len(both) > most:
        both = both[np.random.default_rng(0).choice(len(both), most, replace=False)]
    flat = np.column_stack([both, np.zeros(len(both))])
    return float(np.abs(swept_distance(flat, pose, distance, 0.0, TURN)).max())


def own() -> tuple[list[dict], list[dict]]:
    """Rows of camgeom: profiles of equal angles, profiles of equal error, and solids."""
    from camgeom.model import Model
    from camgeom.prism import outline_grid
    from camgeom.profile import parse

    model = Model(parse(PROFILE))
    outline = model.planar.outlines["profile"]
    profiles, solids = [], []
    for count in COUNTS:
        theta = np.arange(count) * TURN / count
        seconds, curve = best(lambda theta=theta: outline.curve(theta))
        profiles.append(row(f"camgeom, {count} equal angles", curve.points.T, seconds))
    for tolerance in (1e-2, 1e-3, 1e-4):
        seconds, grid = best(lambda t=tolerance: outline_grid(outline, t))
        profiles.append(row(f"camgeom, chord {tolerance * 1e3:g} um", grid.points[:2, :-1, 0].T, seconds))
        seconds, solid = best(lambda t=tolerance: model.parts[0].solid(t))
        solids.append({"tolerance_um": tolerance * 1e3, "triangles": len(solid.mesh.faces), "time_ms": milli(seconds)})
    return profiles, solids


def row(way: str, points: np.ndarray, seconds: float) -> dict:
    found = float(f"{error(points) * 1e3:.4g}")
    return {"way": way, "points": len(points), "error_um": found, "time_ms": milli(seconds)}


def milli(seconds: float) -> float:
    return float(f"{seconds * 1e3:.4g}")


def table(rows: list[dict]) -> None:
    """Print rows as aligned text."""
    columns = list(rows[0])
    widths = [max(len(c), *(len(str(r.get(c, ""))) for r in rows)) for c in columns]
    for cells in (columns, *([str(r.get(c, "")) for c in columns] for r in rows)):
        print("  ".join(cell.ljust(w) for cell, w in zip(cells, widths)).rstrip())


def base_circles(found) -> None:
    """Smallest base circle for 25 degrees, this package's and the peer's, judged by the exact pressure angle."""
    from camgeom.model import Model
    from camgeom.planar_design import smallest_prime_radius
    from camgeom.profile import parse

    program = Model(parse(PROFILE)).setup.program
    print("\nsmallest base circle for a pressure angle of 25 deg (and the angle it really has)")
    for offset in (0.0, 8.0):
        # The peer counts its eccentricity to the side on which the rise gets gentler.
        seconds, prime = best(lambda e=-offset: smallest_prime_radius(program, np.radians(25.0), e))
        peer, peer_seconds = found[f"base/{offset:g}"]
        for name, base, spent in (("camgeom", prime - ROLLER, seconds), ("mechanism", peer, peer_seconds)):
            text = PROFILE.replace("base_radius = 30", f"base_radius = {base}")
            text = text.replace('"translating"', f'"translating"\noffset = {-offset}')
            angle = np.degrees(Model(parse(text)).planar.pressure_angle.value)
            print(f"  offset {offset:g}: {name:9} {base:.9f} mm, {angle:.9f} deg, {milli(spent)} ms")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("--venv", type=Path, help="environment of the peers, kept and reused; default a throwaway one")
    parser.add_argument("--offline", action="store_true", help="leave the peers out")
    parser.add_argument("--json", type=Path, help="also write the rows here")
    parser.add_argument("--peers", type=Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.peers:
        peers(options.peers)
        return
    sys.path[:0] = [str(ROOT), str(ROOT / "tests")]
    rows, solids = own()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "peers.npz"
        reason = "--offline" if options.offline else run_peers(options.venv or Path(folder) / "venv", out)
        found = None if reason else dict(np.load(out))
    for name in ("mechanism", "shapely") if found else ():
        rows += [row(f"{name}, {n} angles", found[f"{name}/{n}"], float(found[f"{name}/{n}/s"])) for n in COUNTS]
    table(rows)
    print()
    table(solids)
    if found:
        base_circles(found)
    else:
        print(f"\nwithout the peers mechanism and shapely: {reason}")
    if options.json:
        options.json.write_text(json.dumps({"profiles": rows, "solids": solids}, indent=1))


if __name__ == "__main__":
    main()
