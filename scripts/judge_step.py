"""Let OpenCASCADE judge a STEP file: validity, tolerance, volume, bodies, names.

    python scripts/judge_step.py FILE...          a line or two for each file
    python scripts/judge_step.py --json FILE...   the same as a JSON list (--points=NAME adds points of such faces)
    python scripts/judge_step.py --install        only make the judge ready

OpenCASCADE (cadquery-ocp-novtk, 380 MB, and the system's libGL and libX11) is a judge for developers and never needed
to use camgeom. Where the running Python has none, one is made once in `.venv-judge` beside this folder, and files are
judged there in a process of their own. Exit status 1 where a file is neither valid closed solids nor triangles.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

WHEEL = "cadquery-ocp-novtk"
ROOM = Path(__file__).resolve().parent.parent / ".venv-judge"
PYTHON = ROOM / ("Scripts/python.exe" if sys.platform == "win32" else "bin/python")
READY = ROOM / ".ready"
"""written once OpenCASCADE has been imported there"""


@dataclass(frozen=True)
class Judgement:
    """What OpenCASCADE makes of a file; lengths mm."""

    solids: int
    free_shells: int
    valid: bool
    tolerance: float
    volume: float
    area: float
    triangles: int
    faces: int
    bodies: list[str] = field(default_factory=list)
    face_names: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)
    box: tuple[float, ...] = ()
    volumes: list[float] = field(default_factory=list)
    points: dict[str, list[list[float]]] = field(default_factory=dict)
    """by face name, where asked for"""


@cache
def available() -> bool:
    """Whether files can be judged now, without installing anything."""
    return find_spec("OCP") is not None or READY.exists()


def install() -> None:
    """Make the judge ready in `.venv-judge`, unless the running Python has OpenCASCADE itself.

    Raises CalledProcessError where pip or the import fails (libGL or libX11 missing).
    """
    if available():
        return
    subprocess.run([sys.executable, "-m", "venv", str(ROOM)], check=True)
    subprocess.run([str(PYTHON), "-m", "pip", "install", "--quiet", WHEEL], check=True)
    subprocess.run([str(PYTHON), "-c", "import OCP.STEPControl"], check=True)
    READY.touch()
    available.cache_clear()


def judged(paths: Sequence[str | Path], names: Sequence[str] = ()) -> list[Judgement]:
    """Judge files here or in `.venv-judge`; names of faces to take points from.

    Raises ValueError where a file cannot be read.
    """
    if find_spec("OCP") is not None:
        return [judge(path, names=names) for path in paths]
    wanted = [f"--points={name}" for name in names]
    command = [str(PYTHON), str(Path(__file__).resolve()), "--json", *wanted, *map(str, paths)]
    found = subprocess.run(command, capture_output=True, text=True, check=False)
    if not found.stdout:
        raise ValueError(found.stderr.strip() or "the judge said nothing")
    return [Judgement(**{**item, "box": tuple(item["box"])}) for item in json.loads(found.stdout.splitlines()[-1])]


def read(path: str | Path) -> Any:
    """A reader that has transferred everything; it must outlive its model.

    Raises ValueError where OpenCASCADE cannot read the file.
    """
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise ValueError(f"{path}: OpenCASCADE cannot read the file")
    reader.TransferRoots()
    return reader


def judge(path: str | Path, eps: float = 1e-9, names: Sequence[str] = ()) -> Judgement:
    """Judge one file. eps is the relative error of the adaptive integration (the default volume is up to 0.1 % off)."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance
    from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID

    reader = read(path)
    shape, model = reader.OneShape(), reader.StepModel()
    solids = list(explore(shape, TopAbs_SOLID))
    area, volumes = GProp_GProps(), []
    for solid in solids:
        volume = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid, volume, eps)
        volumes.append(float(volume.Mass()))
    if solids:
        BRepGProp.SurfaceProperties_s(shape, area, eps)
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box)
    ends = () if box.IsVoid() else (box.CornerMin(), box.CornerMax())
    corners = tuple(float(value) for end in ends for value in (end.X(), end.Y(), end.Z()))
    return Judgement(
        solids=len(solids),
        free_shells=len(list(explore(shape, TopAbs_SHELL, TopAbs_SOLID))),
        valid=bool(BRepCheck_Analyzer(shape).IsValid()),
        tolerance=float(ShapeAnalysis_ShapeTolerance().Tolerance(shape, 1)),
        volume=sum(volumes),
        area=float(area.Mass()),
        triangles=sum(_triangles(face) for face in explore(shape, TopAbs_FACE)),
        faces=len(list(explore(shape, TopAbs_FACE))),
        bodies=_names(model, "StepBasic_Product"),
        face_names=[*_names(model, "StepShape_AdvancedFace"), *_names(model, "StepVisual_TriangulatedFace")],
        complaints=complaints(shape),
        box=corners,
        volumes=volumes,
        points={name: face_points(reader, name) for name in names},
    )


def explore(shape: Any, kind: Any, avoid: Any = None) -> Any:
    """Sub-shapes of one kind."""
    from OCP.TopExp import TopExp_Explorer

    walk = TopExp_Explorer(shape, kind) if avoid is None else TopExp_Explorer(shape, kind, avoid)
    while walk.More():
        yield walk.Current()
        walk.Next()


def _triangles(face: Any) -> int:
    from OCP.BRep import BRep_Tool
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    cast = TopoDS.Face_s if hasattr(TopoDS, "Face_s") else TopoDS.Face
    mesh = BRep_Tool.Triangulation_s(cast(face), TopLoc_Location())
    return 0 if mesh is None else int(mesh.NbTriangles())


def _names(model: Any, kind: str) -> list[str]:
    """Names of all entities of one type in the file."""
    found = []
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if entity.DynamicType().Name() == kind:
            found.append(str(entity.Name().ToCString()))
    return found


def face_points(reader: Any, name: str, across: int = 9) -> list[list[float]]:
    """Points inside the faces of one name, as OpenCASCADE evaluates them: up to across² a face."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.BRepClass import BRepClass_FaceClassifier
    from OCP.BRepTools import BRepTools
    from OCP.gp import gp_Pnt2d
    from OCP.TopAbs import TopAbs_FACE, TopAbs_IN
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    cast = TopoDS.Face_s if hasattr(TopoDS, "Face_s") else TopoDS.Face
    transfer = reader.WS().TransferReader()
    found = []
    for shape in explore(reader.OneShape(), TopAbs_FACE):
        entity = transfer.EntityFromShapeResult(shape.Located(TopLoc_Location()), 1)
        if entity is None or str(entity.Name().ToCString()) != name:
            continue
        face = cast(shape)
        surface = BRepAdaptor_Surface(face)
        u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
        for i in range(across):
            for j in range(across):
                u, v = u0 + (u1 - u0) * (i + 0.41) / across, v0 + (v1 - v0) * (j + 0.43) / across
                if BRepClass_FaceClassifier(face, gp_Pnt2d(u, v), 1e-9).State() == TopAbs_IN:
                    point = surface.Value(u, v)
                    found.append([point.X(), point.Y(), point.Z()])
    return found


def complaints(shape: Any) -> list[str]:
    """How many sub-shapes of each kind the checker refuses."""
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SHELL, TopAbs_VERTEX, TopAbs_WIRE

    analyzer = BRepCheck_Analyzer(shape)
    kinds = {
        "vertices": TopAbs_VERTEX,
        "edges": TopAbs_EDGE,
        "wires": TopAbs_WIRE,
        "faces": TopAbs_FACE,
        "shells": TopAbs_SHELL,
    }
    counts = {name: sum(not analyzer.IsValid(part) for part in explore(shape, kind)) for name, kind in kinds.items()}
    return [f"{count} {name} refused" for name, count in counts.items() if count]


def good(verdict: Judgement) -> bool:
    """Triangles, or valid solids. (The checker wants a surface under every face, which triangles do not have.)"""
    return verdict.triangles > 0 or (verdict.valid and verdict.solids > 0)


def main(arguments: list[str]) -> int:
    """Print what OpenCASCADE makes of each file."""
    paths = [word for word in arguments if not word.startswith("--")]
    if not paths and "--install" not in arguments:
        print(__doc__)
        return 2
    install()
    names = [word.removeprefix("--points=") for word in arguments if word.startswith("--points=")]
    verdicts = judged(paths, names) if paths else []
    if "--json" in arguments:
        print(json.dumps([asdict(verdict) for verdict in verdicts]))
        return 0 if all(map(good, verdicts)) else 1
    for path, verdict in zip(paths, verdicts):
        state = "triangles" if verdict.triangles else "valid" if verdict.valid else "NOT VALID"
        print(f"{path}: {state}, {verdict.solids} solids, {verdict.faces} faces")
        print(f"  tolerance {verdict.tolerance:.3g} mm, volume {verdict.volume:.10g} mm³, area {verdict.area:.9g} mm²")
        print(f"  bodies {verdict.bodies}, faces {sorted(set(verdict.face_names))}, triangles {verdict.triangles}")
        for complaint in verdict.complaints:
            print(f"  {complaint}")
    return 0 if all(map(good, verdicts)) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
