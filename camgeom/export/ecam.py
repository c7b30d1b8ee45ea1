"""The follower's motion as tables: electronic cams for servo drives (CSV, PLCopen XML), polydyne lift (CSV).

An electronic cam is the follower's position and its derivatives over the master angle, the cam angle in degrees.
Derivatives are per degree of master angle (mm/deg, or deg/deg for swinging followers and turrets), as servo drives take
them at a master speed of one.

PLCopen XML: the exchange format of PLCopen's technical committee 6, version 2.0 (namespace tc6_0200, the one that
controller tools read and write; IEC 61131-10 grew out of it). PLCopen's motion control part 1 leaves the content of
MC_CAM_REF to the vendor; the structures here have the fields that SoftMotion systems document for a cam of points with
position, velocity and acceleration (XYVA, run with a quintic between the points): xStart, xEnd, byType = 3, nElements,
and per point dX, dY, dV, dA. They have names of their own, so that they import where no vendor's library is, and are
copied field by field where one is.

Of a cam with several followers every file has all of them over the cam's angle, the first by the plain names.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from math import degrees, radians
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np
import numpy.typing as npt

from camgeom.errors import CamgeomError, ExportError, NotConverged
from camgeom.export import writer
from camgeom.export.files import moment, write_csv, write_whole
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
from camgeom.maths.extremum import bracketed_maximum, piece_grid
from camgeom.maths.panels import TURN
from camgeom.maths.sampling import subdivided
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.motion.program import Program
    from camgeom.motion.table import Side


POINTS = 361
"""default number of points, one a degree"""
MOST = 200_000
SHARES = np.array([0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875])
"""where between two points the error of a table is measured first"""
NEAR = 0.5
"""share of the largest error so measured from which on an interval's own largest error is found to rounding"""
EVEN = 1e-9
"""share of the largest value below which both sides of a knot count as the same"""


@immutable
class MasterTable:
    """Rows of an electronic cam.

    master   (n,) strictly rising, deg, from 0 to 360
    jet      (4, n) position (unit), and derivatives by the master angle, unit/deg, unit/deg², unit/deg³; where one
             jumps, the mean of both sides
    unit     mm or deg
    error    largest measured difference (unit) between the motion and what the drive makes of the rows
    advance  position gained in one turn (an indexing turret), 0 for a follower that comes back
    """

    master: Floats
    jet: Floats
    unit: str
    error: float
    advance: float


Interpolation = Callable[[Floats, Floats, Floats, Floats], Floats]
"""(shares (m,) or (k, m), step (k,), jet at the start (4, k), jet at the end (4, k)) -> positions (k, m)"""


def straight(share: Floats, step: Floats, start: Floats, stop: Floats) -> Floats:
    """Straight lines from point to point: drives that are given positions alone."""
    del step
    return np.asarray(start[0][:, None] + (stop[0] - start[0])[:, None] * share)


def quintic(share: Floats, step: Floats, start: Floats, stop: Floats) -> Floats:
    """The polynomial of degree five through position, velocity and acceleration of both points."""
    x, h = share, step[:, None]
    d = (stop[0] - start[0])[:, None]
    v0, v1, a0, a1 = (q[:, None] for q in (start[1], stop[1], start[2], stop[2]))
    v0, v1, a0, a1 = v0 * h, v1 * h, a0 * h * h, a1 * h * h
    c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
    c5 = 6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1
    return np.asarray(start[0][:, None] + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5)))))


ORDERS: dict[Interpolation, int] = {straight: 2, quintic: 4}
"""With which power of the step the error falls (a quintic's where the acceleration jumps; smooth, the sixth)."""


@immutable
class CamAxis:
    """What one follower does over the cam's angle.

    angle  of its place about the cam, rad: it does later by that what its program says
    scale  of a position to the unit, mm or deg
    """

    program: Program
    angle: float
    scale: float
    unit: str

    @classmethod
    def of(cls, model: Model) -> CamAxis:
        """The axis of a model's follower."""
        rotating = model.profile.rotating
        scale, unit = (degrees(1.0), "deg") if rotating else (1.0, "mm")
        return cls(model.setup.program, model.angle, scale, unit)

    def jet(self, theta: Floats, order: int = 3, side: Side = "right") -> Floats:
        """Position and derivatives per rad of cam angle, in the unit, (order + 1, n), at cam angles (n,)."""
        return np.asarray(self.scale * self.program.jet(theta - self.angle, order, side))

    @property
    def knots(self) -> Floats:
        """Cam angles (rad) from 0 to a turn between which the motion is smooth."""
        return cam_knots(self.program.knots, self.angle)


def cam_knots(own: Floats, angle: float) -> Floats:
    """Knots (rad) over a turn of a follower's own cam angle, as cam angles from 0 to a turn, both among them."""
    turned = own + angle
    inside = np.where(turned > TURN, turned - TURN, turned)
    # What rounding leaves beside an end is the end.
    beside = (inside > BESIDE) & (inside < TURN - BESIDE)
    return distinct(np.concatenate([[0.0, TURN], inside[beside]]))


BESIDE = 1e-12
"""rad"""


def master_tables(models: Sequence[Model], interpolation: Interpolation) -> tuple[MasterTable, ...]:
    """The electronic cams of followers of one cam, over the same rows of its angle.

    `[output] table_tolerance` (mm or deg) chooses the rows, or `table_points`. Raises NotConverged where the tolerance
    needs more than MOST points.
    """
    output, axes = models[0].profile.output, [CamAxis.of(one) for one in models]
    if output.table_tolerance is not None:
        theta = _within(axes, interpolation, output.table_tolerance)
    else:
        theta = np.linspace(0.0, TURN, output.table_points or POINTS)
    tables = []
    for axis in axes:
        jet = _jets(axis, theta)
        error = float(_errors(axis, theta, jet, interpolation).max())
        tables.append(MasterTable(np.degrees(theta), jet, axis.unit, error, axis.scale * axis.program.advance))
    return tuple(tables)


def _jets(axis: CamAxis, theta: Floats) -> Floats:
    """Jets (4, n) per degree; where both sides differ, their mean."""
    scale = radians(1.0) ** np.arange(4)[:, None]
    right, left = scale * axis.jet(theta), scale * axis.jet(theta, side="left")
    size = np.maximum(np.abs(right).max(axis=1, keepdims=True), 1e-300)
    return np.asarray(np.where(np.abs(right - left) > EVEN * size, 0.5 * (right + left), right))


def _errors(axis: CamAxis, theta: Floats, jet: Floats, interpolation: Interpolation) -> Floats:
    """Largest error (n - 1,) between neighbouring rows, in the table's unit.

    Exact where it comes near the largest of all; elsewhere that at SHARES.
    """

    def apart(rows: npt.NDArray[np.intp], share: Floats) -> Floats:
        step = np.diff(theta)[rows]
        true = axis.jet((theta[rows, None] + step[:, None] * share).ravel(), 0)[0].reshape(len(rows), -1)
        return np.asarray(np.abs(interpolation(share, np.degrees(step), jet[:, rows], jet[:, rows + 1]) - true))

    sampled = apart(np.arange(len(theta) - 1), SHARES)
    error = sampled.max(axis=1)
    near = np.flatnonzero(error >= NEAR * error.max())
    places, top = np.concatenate([[0.0], SHARES, [1.0]]), sampled[near].argmax(axis=1)
    rounding = 8.0 * np.finfo(float).eps * float(np.abs(jet[0]).max())
    found, _ = bracketed_maximum(lambda share: apart(near, share), places[top], places[top + 2], noise=rounding)
    error[near] = np.maximum(error[near], found)
    return np.asarray(error)


def _within(axes: Sequence[CamAxis], interpolation: Interpolation, tolerance: float) -> Floats:
    """Angles, with every knot of the motions among them, between which every error stays within the tolerance."""
    theta = distinct(np.concatenate([axis.knots for axis in axes]))
    for _ in range(40):
        error = np.max([_errors(axis, theta, _jets(axis, theta), interpolation) for axis in axes], axis=0)
        if error.max() <= tolerance:
            return np.asarray(theta)
        need = np.ceil(1.02 * (error / tolerance) ** (1.0 / ORDERS[interpolation]))
        parts = np.clip(need, np.where(error > tolerance, 2, 1), 16).astype(np.int64)
        if parts.sum() >= MOST:
            break
        theta = subdivided(theta, parts)
    raise NotConverged(f"an electronic cam within {tolerance:g} needs more than {MOST} points; ask for a coarser one")


NAMESPACE = "http://www.plcopen.org/xml/tc6_0200"
XHTML = "http://www.w3.org/1999/xhtml"
FIELDS = ("dX", "dY", "dV", "dA")
XYVA = 3
"""byType of a cam whose points carry position, velocity and acceleration"""


@writer(
    ".ecam.csv", "electronic cam: position, velocity, acceleration, jerk over master angle, CSV", "model", body=False
)
def write_ecam_csv(path: Path, model: Model) -> int:
    """Write the electronic cam of every follower's axis, one heading line; returns the bytes written.

    Numbers read back to the last bit. With an [operation] the derivatives in time at that speed stand beside. The
    columns of further followers begin with `follower_2.` and so on. Raises ExportError where the tolerance cannot be
    met or the file cannot be written.
    """
    tables, operation = _made(path, model.bindings, straight), model.profile.operation
    columns = {"master_deg": tables[0].master}
    for number, table in enumerate(tables, start=1):
        unit, whose = table.unit, f"follower_{number}." if number > 1 else ""
        names = (f"velocity_{unit}_per_deg", f"acceleration_{unit}_per_deg2", f"jerk_{unit}_per_deg3")
        columns |= {f"{whose}{name}": row for name, row in zip((f"position_{unit}", *names), table.jet)}
        if operation is not None:
            pace = 6.0 * operation.speed  # deg/s
            timed = (f"velocity_{unit}_per_s", f"acceleration_{unit}_per_s2", f"jerk_{unit}_per_s3")
            columns |= {f"{whose}{name}": table.jet[k] * pace**k for k, name in enumerate(timed, start=1)}
    return write_csv(path, list(columns), [("", np.stack(list(columns.values()), axis=1))])


@writer(".plcopen.xml", "electronic cam for controllers: PLCopen XML (TC6), XYVA points", "model", body=False)
def write_plcopen_xml(path: Path, model: Model) -> int:
    """Write the electronic cams as a program that holds them, with their data types; returns the bytes written.

    Every follower has a table of its own, `Cam` and `Points` of the first, `Cam_2` and `Points_2` of the second. The
    measured error of the quintic between the points stands in the documentation. Raises ExportError where the
    tolerance cannot be met or the file cannot be written.
    """
    tables = [_made(path, [one], quintic)[0] for one in model.bindings]
    root = _project(model.profile.name, tables)
    ET.indent(root, " ")
    text = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    return write_whole(path, text + b"\n")


def _made(path: Path, models: Sequence[Model], interpolation: Interpolation) -> tuple[MasterTable, ...]:
    try:
        return master_tables(models, interpolation)
    except CamgeomError as error:
        raise ExportError(f"{path}: {error}") from error


def _identifier(name: str) -> str:
    """A name as IEC 61131-3 allows it: letters, digits and single underscores."""
    word = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_")[:24].rstrip("_")
    return f"CAM_{word or 'TABLE'}"


def _real(value: float) -> str:
    """A real literal of IEC 61131-3, which has a decimal point; reads back to the last bit."""
    digits, mark, power = repr(float(value)).partition("e")
    return f"{digits if '.' in digits else digits + '.0'}{mark}{power}"


def _add(parent: ET.Element, path: str, **attributes: str) -> ET.Element:
    """A chain of children a/b/c under an element; the last carries the attributes."""
    node = parent
    names = path.split("/")
    for name in names:
        node = ET.SubElement(node, name)
    for key, value in attributes.items():
        node.set(key, value)
    return node


def _project(title: str, tables: Sequence[MasterTable]) -> ET.Element:
    now = moment()[0].strftime("%Y-%m-%dT%H:%M:%S")
    root = ET.Element("project", xmlns=NAMESPACE)
    product = {"companyName": "camgeom", "productName": "camgeom", "productVersion": __version__}
    _add(root, "fileHeader", **product, creationDateTime=now)
    content = _add(root, "contentHeader", name=title, modificationDateTime=now)
    info = _add(content, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        _add(info, f"{language}/scaling", x="1", y="1")
    types = _add(root, "types")
    name = _identifier(title)
    data = _add(types, "dataTypes")
    _structure(data, f"{name}_POINT", [(field, "LREAL") for field in FIELDS])
    ends = [("xStart", "LREAL"), ("xEnd", "LREAL")]
    _structure(data, f"{name}_REF", [*ends, ("byType", "BYTE"), ("nElements", "UDINT")])
    pou = _add(types, "pous/pou", name=name, pouType="program")
    held = _add(pou, "interface/localVars")
    for number, table in enumerate(tables, start=1):
        _held(held, name, f"_{number}" if number > 1 else "", table)
    _words(_add(pou, "body/ST"), ";")
    told = [_about(table) for table in tables]
    if len(tables) > 1:
        told = [f"Follower {number}: {words}" for number, words in enumerate(told, start=1)]
    _words(_add(pou, "documentation"), " ".join(told))
    _add(root, "instances/configurations")
    return root


def _held(held: ET.Element, name: str, ending: str, table: MasterTable) -> None:
    """The variables of one follower's cam: its head and its points."""
    last = len(table.master) - 1
    reference = _variable(held, f"Cam{ending}", f"{name}_REF")
    spread = [("xStart", _real(table.master[0])), ("xEnd", _real(table.master[-1]))]
    sizes = [("byType", str(XYVA)), ("nElements", str(last + 1))]
    _struct_value(_add(reference, "initialValue"), spread + sizes)
    points = _add(held, "variable", name=f"Points{ending}")
    array = _add(points, "type/array")
    _add(array, "dimension", lower="0", upper=str(last))
    _add(array, "baseType/derived", name=f"{name}_POINT")
    rows = _add(points, "initialValue/arrayValue")
    for row in zip(table.master.tolist(), *(column.tolist() for column in table.jet[:3])):
        _struct_value(_add(rows, "value"), [(field, _real(value)) for field, value in zip(FIELDS, row)])


def _about(table: MasterTable) -> str:
    unit = table.unit
    text = (
        f"Master angle dX in deg, position dY in {unit}, velocity dV in {unit}/deg, acceleration dA in {unit}/deg2. "
        f"The quintic through dY, dV, dA of neighbouring points is within {1.005 * table.error + 1e-15:.3g} {unit} of "
        "the motion, measured."
    )
    if table.advance:
        return f"{text} The position gains {table.advance!r} {unit} every turn of the master."
    return text


def _structure(data: ET.Element, name: str, fields: list[tuple[str, str]]) -> None:
    body = _add(_add(data, "dataType", name=name), "baseType/struct")
    for field, kind in fields:
        _add(_add(body, "variable", name=field), f"type/{kind}")


def _variable(parent: ET.Element, name: str, kind: str) -> ET.Element:
    variable = _add(parent, "variable", name=name)
    _add(variable, "type/derived", name=kind)
    return variable


def _struct_value(parent: ET.Element, fields: list[tuple[str, str]]) -> None:
    body = _add(parent, "structValue")
    for field, value in fields:
        _add(_add(body, "value", member=field), "simpleValue", value=value)


def _words(parent: ET.Element, text: str) -> None:
    ET.SubElement(parent, "p", xmlns=XHTML).text = text


PER_TURN = 3600


def _uncorrected(model: Model) -> str:
    """Why a cam has no correction for its followers' elasticity; empty where it has one."""
    from camgeom.profile.solvers import uncorrected

    found = []
    for one in model.bindings:
        spec, whose = one.profile.dynamics_spec, f"follower {one.number + 1}: " if len(model.bindings) > 1 else ""
        if spec is None or spec.kind != "follower":
            return "only an elastic follower in [dynamics] has a polydyne motion"
        found += [f"{whose}{problem}" for problem in uncorrected(one.profile, one.mechanism)]
    return "; ".join(found)


@writer(
    ".polydyne.csv", "cam lift over the cam angle for an elastic follower (polydyne), CSV", takes="model",
    cams="followers with a linkage_stiffness in [dynamics]", missing=_uncorrected,
    body=False,
)
def write_polydyne_csv(path: Path, model: Model) -> int:
    """Write cam angle (deg) and every follower's cam lift (mm, deg of a swinging one); returns the bytes written.

    Raises ExportError for a profile without an elastic follower, and where a cam cannot be corrected.
    """
    if why := _uncorrected(model):
        raise ExportError(f"{path}: {why}")
    studies = [(one, study.corrected) for one in model.bindings if (study := one.elastic_follower) is not None]
    phi, _ = piece_grid(distinct(np.concatenate([cam_knots(own.knots, one.angle) for one, own in studies])), PER_TURN)
    phi = distinct(phi)
    columns = {"cam_angle_deg": np.degrees(phi)}
    for one, own in studies:
        axis, whose = CamAxis.of(one), f"follower_{one.number + 1}." if one.number else ""
        columns[f"{whose}cam_lift_{axis.unit}"] = axis.scale * own.jet(phi - one.angle, 0)[0]
    return write_csv(path, list(columns), [("", np.stack(list(columns.values()), axis=1))])
