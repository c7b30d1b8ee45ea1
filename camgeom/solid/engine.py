"""Exact-topology booleans through manifold3d in double precision; every status is checked and raised by name."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any

import numpy as np

from camgeom.errors import GeometryEngineError
from camgeom.interrupts import held
from camgeom.maths.mesh import Mesh


def library() -> Any:
    """manifold3d. An interrupt, or SIGTERM, that comes while it loads waits: inside of it, it would end the process."""
    if "manifold3d" not in sys.modules:
        with held():
            import_module("manifold3d")
    return import_module("manifold3d")


def subtract(blank: Mesh, tools: Sequence[Mesh]) -> Mesh:
    """Blank minus all tools; face groups keep their names. Raises GeometryEngineError where the engine refuses."""
    return _combine(blank, tools, "Subtract")


def unite(bodies: Sequence[Mesh]) -> Mesh:
    """Union of bodies; face groups keep their names. Raises GeometryEngineError where the engine refuses."""
    return _combine(bodies[0], bodies[1:], "Add")


def _combine(first: Mesh, rest: Sequence[Mesh], operation: str) -> Mesh:
    manifold3d = library()

    names: dict[int, str] = {}
    solids = [_manifold(mesh, names) for mesh in (first, *rest)]
    result = manifold3d.Manifold.batch_boolean(solids, getattr(manifold3d.OpType, operation))
    checked(result, f"{operation.lower()} of {len(solids)} bodies")
    return _mesh(result, names)


def _manifold(mesh: Mesh, names: dict[int, str]) -> Any:
    """A manifold whose runs are the face groups; ids are entered in `names`."""
    manifold3d = library()

    group = np.zeros(len(mesh.faces), dtype=np.uint8) if mesh.group is None else mesh.group
    order = np.argsort(group, kind="stable")
    first = manifold3d.Manifold.reserve_ids(len(mesh.groups))
    counts = np.bincount(group, minlength=len(mesh.groups))
    ends = 3 * np.concatenate([[0], np.cumsum(counts)])
    present = counts > 0
    ids = np.arange(first, first + len(mesh.groups), dtype=np.uint32)
    names.update({int(i): name for i, name in zip(ids, mesh.groups)})
    solid = manifold3d.Manifold(
        manifold3d.Mesh64(
            vert_properties=np.ascontiguousarray(mesh.vertices),
            tri_verts=np.ascontiguousarray(mesh.faces[order].astype(np.uint64)),
            run_index=np.append(ends[:-1][present], ends[-1]).astype(np.uint64),
            run_original_id=ids[present],
        )
    )
    checked(solid, "input body")
    return solid


def checked(solid: Any, what: str) -> None:
    status = solid.status()
    if status.name != "NoError":
        raise GeometryEngineError(f"{what}: the geometry engine reports {status.name}")
    if solid.is_empty() or not solid.volume() > 0.0:
        raise GeometryEngineError(f"{what}: empty or turned inside out (volume {solid.volume():g} mm3)")


def _mesh(solid: Any, names: dict[int, str]) -> Mesh:
    """The result as a Mesh with its vertices merged across runs and groups by name."""
    raw = solid.to_mesh64()
    points = np.ascontiguousarray(np.asarray(raw.vert_properties)[:, :3])
    faces = np.asarray(raw.tri_verts).astype(np.int64)
    target = np.arange(len(points))
    target[np.asarray(raw.merge_from_vert).astype(np.int64)] = np.asarray(raw.merge_to_vert).astype(np.int64)
    faces = target[faces]
    used = np.zeros(len(points), dtype=bool)
    used[faces] = True
    number = np.cumsum(used) - 1
    bounds, ids = np.asarray(raw.run_index).astype(np.int64) // 3, np.asarray(raw.run_original_id)
    filled = [(start, stop, i) for start, stop, i in zip(bounds[:-1], bounds[1:], ids) if stop > start]
    labels = tuple(dict.fromkeys(names.get(int(i), "surface") for _, _, i in filled))
    group = np.empty(len(faces), dtype=np.uint8)
    for start, stop, i in filled:
        group[start:stop] = labels.index(names.get(int(i), "surface"))
    return Mesh(points[used], number[faces].astype(np.int32), labels, group)
