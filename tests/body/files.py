"""Volume files read back by meshio."""

from __future__ import annotations

from pathlib import Path

import numpy as np

FORMATS = ("inp", "bdf", "vtu", "msh", "xdmf")


def read(path: Path) -> tuple[np.ndarray, np.ndarray, dict[str, np.ndarray]]:
    """Points, elements and sets of a file, by meshio; the sets of input files by their cards."""
    import meshio

    sets: dict[str, np.ndarray] = {}
    if path.suffix == ".inp":
        mesh = meshio.read(path, file_format="abaqus")
        sets = {name: np.asarray(nodes) for name, nodes in mesh.point_sets.items() if name != "all"}
    elif path.suffix == ".bdf":
        mesh, names, found = meshio.read(path), {}, {}
        for line in path.read_text().splitlines():
            if line.startswith("$ SET1"):
                _, _, number, name = line.split()
                names[number] = name
            elif line.startswith("SET1,"):
                _, number, *nodes = line.split(",")
                found.setdefault(names[number], []).extend(int(n) - 1 for n in nodes)
        sets = {name: np.array(nodes) for name, nodes in found.items()}
    else:
        mesh = meshio.read(path)
        fields = {name: np.asarray(values).ravel() for name, values in mesh.point_data.items() if name[:4] == "set_"}
        sets = {name.removeprefix("set_"): np.flatnonzero(values > 0.5) for name, values in fields.items()}
    assert mesh.cells[0].type in ("hexahedron20", "tetra10")
    return mesh.points, mesh.cells[0].data, sets
