"""Groove cam as a CAD body: this package's exact boundary representation beside OpenCASCADE cutting and sewing.

OpenCASCADE subtracts a union of roller cylinders from the drum (no open kernel cuts a true envelope), or sews the
triangles of a finished mesh into a solid. It is used where cadquery-ocp-novtk is installed, else from a throwaway
environment (or the folder that CAMGEOM_PEERS names, which is kept); without a network it is left out and the table says
so. The exact body's flank deviation is measured by the tests that judge STEP files.
"""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import numpy as np
from kit import ROOT, Row, Table, best, milli, run, short

COUNTS = (12, 24, 48)
RADIUS, TIP, OUTER, LENGTH, BORE = 11.0, 54.0, 67.0, 110.0, 20.0


def peers(given: Path, out: Path) -> None:
    """Run where OpenCASCADE is: times, and points of the tessellated bodies, into an npz file."""
    data = dict(np.load(given))
    found: dict[str, np.ndarray] = {}
    for count in COUNTS:
        began = perf_counter()
        body = cut(data[f"a/{count}"], data[f"u/{count}"])
        found[f"cut/{count}/s"] = np.array(perf_counter() - began)
        found[f"cut/{count}/points"], found[f"cut/{count}/faces"] = tessellated(body, 1e-3)
    for name in ("coarse", "middle"):
        began = perf_counter()
        valid = sewn(data[f"{name}/vertices"], data[f"{name}/faces"])
        found[f"sew/{name}/s"], found[f"sew/{name}/valid"] = np.array(perf_counter() - began), np.array(valid)
    np.savez(out, **found)


def cut(a: np.ndarray, u: np.ndarray):
    """The drum minus all rollers by one general boolean."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    try:
        from OCP.collections import List_TopoDS_Shape as Shapes
    except ImportError:
        from OCP.TopTools import TopTools_ListOfShape as Shapes

    def cylinder(at: np.ndarray, along: np.ndarray, radius: float, length: float):
        axis = gp_Ax2(gp_Pnt(*map(float, at)), gp_Dir(*map(float, along)))
        return BRepPrimAPI_MakeCylinder(axis, radius, length).Shape()

    up = np.array([0.0, 0.0, 1.0])
    blanks, tools = Shapes(), Shapes()
    blanks.Append(cylinder(np.zeros(3), up, OUTER, LENGTH))
    tools.Append(cylinder(-up, up, BORE, LENGTH + 2.0))
    for point, axis in zip(a, u, strict=True):
        tools.Append(cylinder(point + TIP * axis, axis, RADIUS, 20.0))
    boolean = BRepAlgoAPI_Cut()
    boolean.SetArguments(blanks)
    boolean.SetTools(tools)
    boolean.Build()
    if not boolean.IsDone():
        raise SystemExit("OpenCASCADE refused the cut")
    return boolean.Shape()


def tessellated(shape, deflection: float) -> tuple[np.ndarray, np.ndarray]:
    """Points and triangles of all faces."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    cast = TopoDS.Face_s if hasattr(TopoDS, "Face_s") else TopoDS.Face
    BRepMesh_IncrementalMesh(shape, deflection, False, 0.05, False)
    points, faces, start = [], [], 0
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        mesh = BRep_Tool.Triangulation_s(cast(explorer.Current()), TopLoc_Location())
        explorer.Next()
        if mesh is None:
            continue
        nodes = [mesh.Node(k) for k in range(1, mesh.NbNodes() + 1)]
        points += [(p.X(), p.Y(), p.Z()) for p in nodes]
        faces += [[c + start - 1 for c in mesh.Triangle(k).Get()] for k in range(1, mesh.NbTriangles() + 1)]
        start += len(nodes)
    return np.array(points), np.array(faces, dtype=np.int32)


def sewn(vertices: np.ndarray, faces: np.ndarray) -> bool:
    """Triangles as planar faces, sewn into a solid; whether it is valid."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon, BRepBuilderAPI_Sewing
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.gp import gp_Pnt

    corners = [gp_Pnt(*map(float, v)) for v in vertices]
    sewing = BRepBuilderAPI_Sewing(1e-6)
    for i, j, k in faces:
        wire = BRepBuilderAPI_MakePolygon(corners[i], corners[j], corners[k], True).Wire()
        sewing.Add(BRepBuilderAPI_MakeFace(wire).Face())
    sewing.Perform()
    return bool(BRepCheck_Analyzer(sewing.SewedShape()).IsValid()) and sewing.NbFreeEdges() == 0


def run_peers(given: Path, folder: Path, out: Path) -> str:
    """Run OpenCASCADE, installing it first where it is missing; the reason where that fails, else empty."""
    python, steps = Path(sys.executable), []
    if importlib.util.find_spec("OCP") is None:
        python = folder / "bin" / "python"
        steps = [] if python.exists() else [[sys.executable, "-m", "venv", str(folder)]]
        steps.append([str(python), "-m", "pip", "install", "--quiet", "cadquery-ocp-novtk", "numpy"])
    steps.append([str(python), __file__, "--peers", str(given), str(out)])
    for step in steps:
        done = subprocess.run(step, capture_output=True, text=True, check=False)
        if done.returncode:
            return (done.stderr.strip().splitlines() or ["no message"])[-1]
    return ""


def tables(quick: bool) -> list[Table]:
    """Exact bodies, cut bodies, sewn triangles."""
    from groove import wall_error

    from camgeom import write
    from camgeom.maths.mesh import Mesh
    from camgeom.model import read
    from camgeom.solid.drum import GroovedCylinder

    model = read(str(ROOT / "profiles" / "pin_insertion.toml"))
    cam = model.cam.model_copy(update={"keyway_width": 0.0, "keyway_depth": 0.0})
    (track,) = cam.mechanism(model.setup).cutters
    part = GroovedCylinder("cam", track, cam.mechanism(model.setup).blank, cam.radius, cam.length)
    given: dict[str, np.ndarray] = {}
    for count in COUNTS:
        pose = track.pose(np.linspace(0.0, 2.0 * np.pi, count, endpoint=False), 0)
        given[f"a/{count}"], given[f"u/{count}"] = pose.a[0].T, pose.u[0].T
    sizes = {"coarse": 0.1, "middle": 0.02}
    for name, tolerance in sizes.items():
        mesh = part.solid(tolerance).mesh
        given[f"{name}/vertices"], given[f"{name}/faces"] = mesh.vertices, mesh.faces
    rows: list[Row] = []
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "cam.step"

        def own() -> None:
            write(read(model.profile.source), path)

        seconds, _ = best(own, 5)
        rows.append({"way": "camgeom, exact B-rep to a STEP file", "size": f"{path.stat().st_size // 1000} kB",
                     "time_ms": milli(seconds), "flank_error_um": "below 0.1"})
        np.savez(Path(folder) / "given.npz", **given)
        out = Path(folder) / "out.npz"
        reason = run_peers(Path(folder) / "given.npz", Path(os.environ.get("CAMGEOM_PEERS", folder)) / "occ", out)
        found = {} if reason else dict(np.load(out))
    for count in COUNTS if found else ():
        mesh = Mesh(found[f"cut/{count}/points"], found[f"cut/{count}/faces"])
        error = wall_error(mesh, model.setup.program)
        rows.append({"way": "OpenCASCADE, drum minus rollers", "size": f"{count} rollers",
                     "time_ms": milli(float(found[f"cut/{count}/s"])), "flank_error_um": short(error * 1e3)})
    for name in sizes if found else ():
        valid = "valid" if found[f"sew/{name}/valid"] else "not valid"
        count = len(given[f"{name}/faces"])
        rows.append({"way": f"OpenCASCADE, triangles sewn ({valid})", "size": f"{count} triangles",
                     "time_ms": milli(float(found[f"sew/{name}/s"])), "flank_error_um": short(sizes[name] * 1e3)})
    note = "Time in memory for OpenCASCADE, to a file on the disk for this package." if found else f"No peer: {reason}"
    return [Table("opencascade", "The groove cam as a CAD body", rows, note)]


if __name__ == "__main__":
    if sys.argv[1:2] == ["--peers"]:
        peers(Path(sys.argv[2]), Path(sys.argv[3]))
    else:
        run(tables, __doc__)
