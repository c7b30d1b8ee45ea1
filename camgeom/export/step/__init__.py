"""STEP files: exact boundary representations, and triangles where there is nothing exact.

The schema is AP242; `.ap214.step` is written with AP214 for readers that know no later one (two entries in a table).

The file is text, the same bytes for the same shape; lengths mm, angles rad; faces and bodies keep their names.

How a cam becomes faces. A body is one or more shells (`shell.shell`): bands of exact points (phi, share across) stacked
round the cam, cut at the knots of the motion. Give each band as a callable, say where the knots are, and close the
shell with flat ends and holes (`solids.closed_solid`); edges, vertices, planes, cylinders and splines follow from the
points. `solids.prism_solid` does this for planar cams (disc, constant-width, conjugate), `solids.revolved_solid` for
blanks, `groove` for a closed groove or rib round a drum. Where grooves cut through ends or one another, `cut` takes the
topology from a mesh and finds every corner and edge on the surfaces themselves. An edge that borders a spline face is
written with its line in that face's parameters, which a reader cannot find where the face is narrow or ends in a point.
A new kind of part is one entry in `bodies.EXACT`; a part with none, or whose faces do not close, is written as
triangles. `check.check_solid` judges a solid without a CAD kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from camgeom.errors import ExportError, NotConverged
from camgeom.export import NO_PLATE, NO_ROLLERS, writer
from camgeom.export.files import atomic_write
from camgeom.export.step.brep import Assembly, Brep, FacetBody
from camgeom.export.step.file import Schema, step_text

if TYPE_CHECKING:
    from camgeom.model import Model


def write_step(path: str | Path, shape: Brep | FacetBody | Assembly, schema: Schema = "AP242") -> int:
    """Write a STEP file whole or not at all; returns its bytes. Raises ExportError where it cannot be written."""
    try:
        data = step_text(shape, schema).encode("ascii")
    except ExportError as error:
        raise ExportError(f"{path}: {error}") from None
    with atomic_write(path) as stream:
        stream.write(data)
    return len(data)


@writer(".step", "STEP AP242: exact faces, for CAD and CAM", takes="model")
@writer(".stp", "STEP, the same under its short name", takes="model")
def write_model(path: Path, model: Model, schema: Schema = "AP242", tolerance: float | None = None) -> int:
    """Write a model's bodies; schema AP242 or AP214; tolerance in mm of fitted faces (default 1e-5).

    What the file holds, and how near to the exact shape, is left in the model's notes under "step".
    """
    from camgeom.export.step.bodies import model_bodies

    return _written(path, model, model_bodies, schema, tolerance)


@writer(".ap214.step", "STEP AP214, for readers that know no later one", takes="model")
def write_ap214(path: Path, model: Model, tolerance: float | None = None) -> int:
    """As `write_model`, schema AP214."""
    return write_model(path, model, "AP214", tolerance)


@writer(
    ".assembly.step", "STEP AP242: the cam with its turret and rollers, or its frame, placed", takes="model",
    cams="cams with rollers or a frame's plate",
    missing=lambda model: "" if model.mechanism.roller is not None or model.mechanism.frame is not None else NO_ROLLERS,
)
def write_assembly(path: Path, model: Model, schema: Schema = "AP242", tolerance: float | None = None) -> int:
    """Write the cam's bodies with what they drive, as it stands at cam angle zero; options as `write_model`."""
    from camgeom.export.step.bodies import assembly_of

    return _written(path, model, assembly_of, schema, tolerance)


@writer(
    ".frame.step", "STEP AP242: the frame of a constant-width cam alone", takes="model", cams="frames with a plate",
    missing=lambda model: "" if model.mechanism.frame is not None else NO_PLATE,
)
def write_frame(path: Path, model: Model, schema: Schema = "AP242", tolerance: float | None = None) -> int:
    """Write the frame as it stands at zero lift; options as `write_model`."""
    from camgeom.export.step.bodies import frame_of

    return _written(path, model, frame_of, schema, tolerance)


def _written(
    path: Path,
    model: Model,
    make: Callable[[Model, float], Brep | FacetBody | Assembly],
    schema: Schema,
    tolerance: float | None,
) -> int:
    """Write what is made of a model and note what the file holds; returns its bytes."""
    from camgeom.export.step.bodies import notes
    from camgeom.export.step.solids import TOLERANCE

    if (pieces := model.profile.pieces) > (most := model.profile.cam.MOST_STEPPED):
        raise NotConverged(
            f"{path}: a STEP file of {pieces} pieces of motions would take more than its share of a minute: at most "
            f"{most} of this kind of cam, by fewer segments or points of their laws; or a file of triangles"
        )
    try:
        shape = make(model, tolerance or TOLERANCE)
    except ExportError as error:
        raise ExportError(f"{path}: {error}") from None
    size = write_step(path, shape, schema)
    listed = model.ledger.notes.setdefault("step", [])
    listed.append({"file": Path(path).name, "schema": schema, "bodies": notes(shape)})
    return size
