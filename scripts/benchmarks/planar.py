"""Disc cams: profile error against time, beside a cam package and polygon offsetting; solids at several tolerances.

The cam is the reference disc: base circle 30, roller radius 10, cycloidal rise of 20 mm. The peers, `mechanism` (PyPI)
and the offsetting of `shapely`, are installed into a throwaway environment (or the folder that CAMGEOM_PEERS names,
which is kept); without a network they are left out and the table says so. Every error is the distance of vertices and
edge middles from the nearest roller position, by tests/oracle/envelope.py, which shares no code with what it measures.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from kit import Plot, Row, Table, best, milli, run, short

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
        run = subprocess.run(step, capture_output=True, text=True, check=False, env={**os.environ, "MPLBACKEND": "Agg"})
        if run.returncode:
            return (run.stderr.strip().splitlines() or ["no message"])[-1]
    return ""


def error(points: np.ndarray, most: int = 1200) -> float:
    """Largest deviation of vertices and edge middles (n, 2) from the true profile, mm."""
    from tests.oracle.envelope import roller_distance, swept_distance

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


def own() -> tuple[list[Row], list[Row]]:
    """Rows of camgeom: profiles of equal angles, profiles of equal error, and solids."""
    from camgeom.model import Model
    from camgeom.profile import parse
    from camgeom.solid.prism import outline_grid

    model = Model(parse(PROFILE))
    outline = model.planar.outlines["profile"]
    profiles, solids = [], []
    for count in COUNTS:
        theta = np.arange(count) * TURN / count
        seconds, curve = best(lambda theta=theta: outline.curve(theta), 15)
        profiles.append(row("camgeom, equal angles", curve.points.T, seconds))
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5):
        seconds, grid = best(lambda t=tolerance: outline_grid(outline, t), 15)
        profiles.append(row("camgeom, equal error", grid.points[:2, :-1, 0].T, seconds))
    for tolerance in (1e-2, 1e-3, 1e-4, 1e-5):
        seconds, solid = best(lambda t=tolerance: model.parts[0].solid(t), 15)
        solids.append({"tolerance_um": tolerance * 1e3, "triangles": len(solid.mesh.faces), "time_ms": milli(seconds)})
    return profiles, solids


def row(way: str, points: np.ndarray, seconds: float) -> Row:
    return {"way": way, "points": len(points), "error_um": short(error(points) * 1e3), "time_ms": milli(seconds)}


def base_circles(found) -> list[Row]:
    """Smallest base circle for 25 degrees, this package's and the peer's, judged by the exact pressure angle."""
    from camgeom.design.planar import smallest_prime_radius
    from camgeom.model import Model
    from camgeom.profile import parse

    program = Model(parse(PROFILE)).setup.program
    rows = []
    for offset in (0.0, 8.0):
        # The peer counts its eccentricity to the side on which the rise gets gentler.
        seconds, prime = best(lambda e=-offset: smallest_prime_radius(program, np.radians(25.0), e), 15)
        peer, peer_seconds = found[f"base/{offset:g}"]
        for name, base, spent in (("camgeom", prime - ROLLER, seconds), ("mechanism", peer, peer_seconds)):
            text = PROFILE.replace("base_radius = 30", f"base_radius = {base}")
            text = text.replace('"translating"', f'"translating"\noffset = {-offset}')
            angle = float(np.degrees(Model(parse(text)).planar.pressure_angle.value))
            rows.append({"offset_mm": offset, "way": name, "base_radius_mm": f"{base:.9f}",
                         "angle_it_has_deg": f"{angle:.9f}", "time_ms": milli(spent)})
    return rows


def tables(quick: bool) -> list[Table]:
    """Profiles, solids, base circles."""
    rows, solids = own()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "peers.npz"
        reason = run_peers(Path(os.environ.get("CAMGEOM_PEERS", folder)) / "venv", out)
        found = None if reason else dict(np.load(out))
    for name in ("mechanism", "shapely") if found else ():
        rows += [row(name, found[f"{name}/{n}"], float(found[f"{name}/{n}/s"])) for n in COUNTS]
    note = "" if found else f"Without the peers mechanism and shapely: {reason}"
    plot = Plot("error_um", "time_ms", "way", "measured error, um", "time, ms")
    made = [
        Table("planar", "Disc profile: time against measured error", rows, note, plot),
        Table("planar_solid", "Disc solid", solids),
    ]
    if found:
        title = "Smallest base circle for a pressure angle of 25 degrees"
        made.append(Table("planar_base", title, base_circles(found), "Judged by the exact pressure angle."))
    return made


if __name__ == "__main__":
    if sys.argv[1:2] == ["--peers"]:
        peers(Path(sys.argv[2]))
    else:
        run(tables, __doc__)
