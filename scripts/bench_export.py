"""Time of each mesh writer against a raw write of as many bytes and against a general library on the same mesh.

    .venv/bin/python scripts/bench_export.py [TRIANGLES]       default 2 000 000

Each time is the best of two, flushed to the disk. The general library is trimesh (meshio for VTU); it rounds to fewer
digits than these writers do in OBJ and 3MF. Figures in the last column above 1 mean that this package is faster.
"""

from __future__ import annotations

import os
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter

import meshio
import numpy as np
import trimesh

from camgeom.export import as_bodies, formats
from camgeom.maths.mesh import Mesh


def ring(triangles: int) -> Mesh:
    """A closed ring of about that many triangles, with two groups and one field."""
    n = m = round((triangles / 2) ** 0.5)
    i, j = np.meshgrid(np.arange(n), np.arange(m), indexing="ij")
    a, b = 2.0 * np.pi * i / n, 2.0 * np.pi * j / m
    radius = 50.0 + 17.0 * np.cos(b)
    points = np.stack([radius * np.cos(a), radius * np.sin(a), 17.0 * np.sin(b)], axis=-1).reshape(-1, 3)
    corner = [((i + p) % n * m + (j + q) % m).ravel() for p, q in ((0, 0), (1, 0), (1, 1), (0, 1))]
    faces = np.concatenate([np.stack([corner[k] for k in t], axis=1) for t in ((0, 1, 2), (0, 2, 3))])
    group = (points[faces[:, 0], 2] > 5.0).astype(np.uint8)
    return Mesh(points, faces.astype(np.int32), ("flank", "land"), group, {"pressure_mpa": points[:, 0] ** 2})


def best(action: Callable[[], object]) -> float:
    """The shorter of two runs, s."""
    times = []
    for _ in range(2):
        began = perf_counter()
        action()
        times.append(perf_counter() - began)
    return min(times)


def synced(path: Path, action: Callable[[], object]) -> None:
    """The action, and its file on the disk."""
    action()
    with path.open("rb+") as stream:
        os.fsync(stream.fileno())


def generic(mesh: Mesh, path: Path) -> Callable[[], object]:
    """The general library's writer."""
    if path.suffix == ".vtu":
        grid = meshio.Mesh(mesh.vertices, [("triangle", mesh.faces)], point_data=dict(mesh.fields))
        return lambda: grid.write(path)
    other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    return lambda: other.export(path)


def main() -> None:
    """Print the table."""
    mesh = ring(int(sys.argv[1]) if len(sys.argv) > 1 else 2_000_000)
    closed = mesh.watertight  # every caller has asked this before
    print(f"{len(mesh.faces)} triangles, closed: {closed}")
    print(f"{'format':8}{'MB':>9}{'s':>9}{'raw s':>9}{'library s':>11}{'x raw':>8}{'x library':>11}")
    with tempfile.TemporaryDirectory() as folder:
        for extension, form in formats().items():
            if form.takes != "bodies":
                continue
            path, other = Path(folder, f"cam{extension}"), Path(folder, f"other{extension}")
            own = best(partial(form.write, path, as_bodies(mesh)))
            data = path.read_bytes()
            raw = best(partial(synced, other, partial(other.write_bytes, data)))
            library = best(partial(synced, other, generic(mesh, other)))
            size = len(data) / 1e6
            ratios = f"{own / raw:8.1f}{library / own:11.1f}"
            print(f"{extension:8}{size:9.1f}{own:9.3f}{raw:9.3f}{library:11.3f}{ratios}")


if __name__ == "__main__":
    main()
