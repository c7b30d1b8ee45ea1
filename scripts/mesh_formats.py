"""Measure who writes a mesh format best: camgeom, trimesh or meshio. Prints the rows of the table in docs/body.md.

    python scripts/mesh_formats.py [PROFILE]

One body (the pin-insertion cam with a rounded root by default), its surface mesh and its volume mesh, written by each
that can and read back by the other's reader: processor time, bytes, largest error of a vertex, and the named faces
that come back.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from types import ModuleType

import meshio
import numpy as np
import trimesh

from camgeom.export import write
from camgeom.model import Model
from camgeom.profile import from_data, read_data

PROFILE = Path(__file__).resolve().parent.parent / "profiles" / "pin_insertion.toml"
SURFACE = ("stl", "ply", "glb", "3mf")
VOLUME = ("inp", "bdf", "vtu", "msh", "xdmf")


def timed(work: Callable[[], object]) -> float:
    """Processor time of a piece of work, s: the best of three."""
    took = []
    for _ in range(3):
        start = time.process_time()
        work()
        took.append(time.process_time() - start)
    return min(took)


def row(path: Path, who: str, work: Callable[[], object], vertices: np.ndarray, points: Callable[[], np.ndarray],
        groups: str) -> None:  # fmt: skip
    """One line of the table; `points` reads the file back."""
    try:
        took, x = timed(work), points()
    except (AssertionError, AttributeError, TypeError, ValueError) as error:
        # What a library cannot do is a result here.
        print(f"| {path.suffix} | {who} | | | fails: {type(error).__name__} {str(error)[:60]} | |")
        return
    off = f"{np.abs(x - vertices).max():.1e}" if x.shape == vertices.shape else "as many vertices as faces have"
    size = path.stat().st_size / 1e6
    print(f"| {path.name.split('.', 1)[1]} | {who} | {took:.2f} | {size:.2f} | {off} | {groups} |")


def surface(model: Model, folder: Path) -> None:
    """STL, PLY, GLB and 3MF by camgeom and trimesh."""
    mesh = model.solid.mesh
    other = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)

    def back(path: Path) -> Callable[[], np.ndarray]:
        def read() -> np.ndarray:
            x = np.asarray(trimesh.load(path, force="mesh", process=False).vertices)
            corners = mesh.vertices[mesh.faces].reshape(-1, 3)
            return mesh.vertices + np.abs(x - corners).max() if len(x) == len(corners) else x

        return read

    for form in SURFACE:
        ours, theirs = folder / f"ours.{form}", folder / f"theirs.{form}"
        faces = "none" if form == "stl" else "faces"
        row(ours, "camgeom", partial(write, model, ours), mesh.vertices, back(ours), faces)
        row(theirs, "trimesh", partial(other.export, theirs), mesh.vertices, back(theirs), "none")


def volume(model: Model, folder: Path) -> None:
    """Volume formats by camgeom's own writers and by meshio alone."""
    volume = model.volume
    sets = {name: np.asarray(nodes) for name, nodes in volume.sets.items()}
    kinds = {"inp": "abaqus", "bdf": "nastran", "vtu": "vtu", "msh": "gmsh", "xdmf": "xdmf"}
    for form in VOLUME:
        ours, theirs = folder / f"ours.volume.{form}", folder / f"theirs.volume.{form}"

        def by_meshio(path: Path = theirs, form: str = form) -> None:
            mesh = meshio.Mesh(volume.nodes.copy(), [(volume.cell, volume.elements.copy())], point_sets=dict(sets))
            meshio.write(path, mesh, file_format=kinds[form])

        def back(path: Path, form: str = form) -> Callable[[], np.ndarray]:
            return lambda: np.asarray(meshio.read(path, file_format=kinds[form]).points)

        row(ours, "camgeom", partial(write, model, ours), volume.nodes, back(ours), f"{len(sets)} sets, load")
        row(theirs, "meshio alone", by_meshio, volume.nodes, back(theirs), f"{len(sets)} sets" if form == "inp" else "")


def main(arguments: list[str]) -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    sys.modules.setdefault("h5py", ModuleType("h5py"))
    data = read_data(Path(arguments[0]) if arguments else PROFILE)
    if not arguments:
        data = {**data, "cam": {**data["cam"], "root_radius": 1.0}, "output": {**data["output"], "load_angle_deg": 298}}
    model = Model(from_data(data))
    print("| format | by | s | MB | vertices off, mm | names |\n|---|---|---|---|---|---|")
    with TemporaryDirectory() as folder:
        surface(model, Path(folder))
        volume(model, Path(folder))


if __name__ == "__main__":
    main(sys.argv[1:])
