"""Let OpenCASCADE judge a STEP file: validity, tolerance, volume, bodies, names.

    python scripts/judge_step.py FILE...

Installs the OpenCASCADE wheel (cadquery-ocp-novtk) with pip where it is missing; it is a judge for developers and never
needed to use camgeom. Exit status 1 where a file is not one or more valid closed solids (or triangles).
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

WHEEL = "cadquery-ocp-novtk"


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


def install() -> None:
    """Install the judge with pip into the running interpreter, where it is missing."""
    try:
        import OCP  # noqa: F401
    except ImportError:
        subprocess.run([sys.executable, "-m", "pip", "install", WHEEL], check=True)


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


def judge(path: str | Path, eps: float = 1e-7) -> Judgement:
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
    volume, area = GProp_GProps(), GProp_GProps()
    if solids:
        BRepGProp.VolumeProperties_s(shape, volume, eps)
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
        volume=float(volume.Mass()),
        area=float(area.Mass()),
        triangles=sum(_triangles(face) for face in explore(shape, TopAbs_FACE)),
        faces=len(list(explore(shape, TopAbs_FACE))),
        bodies=_names(model, "StepBasic_Product"),
        face_names=[*_names(model, "StepShape_AdvancedFace"), *_names(model, "StepVisual_TriangulatedFace")],
        complaints=complaints(shape),
        box=corners,
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


def main(paths: list[str]) -> int:
    """Print what OpenCASCADE makes of each file."""
    if not paths:
        print(__doc__)
        return 2
    install()
    good = True
    for path in paths:
        verdict = judge(path)
        good = good and (verdict.triangles > 0 or (verdict.valid and verdict.solids > 0))
        # The checker wants a surface under every face, which triangles do not have.
        state = "triangles" if verdict.triangles else "valid" if verdict.valid else "NOT VALID"
        print(f"{path}: {state}, {verdict.solids} solids, {verdict.faces} faces")
        print(f"  tolerance {verdict.tolerance:.3g} mm, volume {verdict.volume:.9g} mm³, area {verdict.area:.9g} mm²")
        print(f"  bodies {verdict.bodies}, faces {sorted(set(verdict.face_names))}, triangles {verdict.triangles}")
        for complaint in verdict.complaints:
            print(f"  {complaint}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
