"""Mesh writers: each against a raw write of as many bytes and against a general library on the same mesh.

Each time is the best of two, flushed to the disk. The general library is trimesh (meshio for VTU); it rounds to fewer
digits than these writers do in OBJ and 3MF.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import meshio
import numpy as np
import trimesh
from kit import Table, best, run, short

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


def tables(quick: bool) -> list[Table]:
    """A row a format."""
    mesh = ring(200_000 if quick else 2_000_000)
    assert mesh.watertight  # every caller has asked this before
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for extension, form in formats().items():
            if form.takes != "bodies":
                continue
            path, other = Path(folder, f"cam{extension}"), Path(folder, f"other{extension}")
            own, _ = best(partial(form.write, path, as_bodies(mesh)), 2)
            data = path.read_bytes()
            raw, _ = best(partial(synced, other, partial(other.write_bytes, data)), 2)
            try:
                library = best(partial(synced, other, generic(mesh, other)), 2)[0]
            except (ValueError, KeyError):
                library = None
            rows.append({
                "format": extension, "mb": short(len(data) / 1e6), "time_s": short(own), "raw_write_s": short(raw),
                "library_s": short(library) if library else "no writer", "times_raw_write": short(own / raw, 3),
                "times_faster_than_library": short(library / own, 3) if library else "",
            })
    return [Table("export", f"Writing {len(mesh.faces):,} triangles".replace(",", " "), rows)]


if __name__ == "__main__":
    run(tables, __doc__)
