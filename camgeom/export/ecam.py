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
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, pi
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

import numpy as np

from camgeom.errors import CamgeomError, ExportError, NotConverged
from camgeom.export import writer
from camgeom.export.files import atomic_write, moment, write_csv
from camgeom.maths import Floats
from camgeom.maths.extremum import piece_grid
from camgeom.maths.sampling import subdivided

if TYPE_CHECKING:
    from camgeom.model import Model
    from camgeom.motion.program import Program
    from camgeom.profile import Profile


POINTS = 361
"""default number of points, one a degree"""
MOST = 200_000
SHARES = np.array([0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875])
"""where between two points the error of a table is measured"""
EVEN = 1e-9
"""share of the largest value below which both sides of a knot count as the same"""


@dataclass(frozen=True, eq=False)
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
"""(share (m,), step (k,), jet at the start (4, k), jet at the end (4, k)) -> positions (k, m)"""


def straight(share: Floats, step: Floats, start: Floats, stop: Floats) -> Floats:
    """Straight lines from point to point: drives that are given positions alone."""
    del step
    return np.asarray(start[0][:, None] + (stop[0] - start[0])[:, None] * share)


def quintic(share: Floats, step: Floats, start: Floats, stop: Floats) -> Floats:
    """The polynomial of degree five through position, velocity and acceleration of both points."""
    x, h = share[None, :], step[:, None]
    d = (stop[0] - start[0])[:, None]
    v0, v1, a0, a1 = (q[:, None] for q in (start[1], stop[1], start[2], stop[2]))
    v0, v1, a0, a1 = v0 * h, v1 * h, a0 * h * h, a1 * h * h
    c3 = 10.0 * d - 6.0 * v0 - 4.0 * v1 - 1.5 * a0 + 0.5 * a1
    c4 = -15.0 * d + 8.0 * v0 + 7.0 * v1 + 1.5 * a0 - a1
    c5 = 6.0 * d - 3.0 * v0 - 3.0 * v1 - 0.5 * a0 + 0.5 * a1
    return np.asarray(start[0][:, None] + x * (v0 + x * (0.5 * a0 + x * (c3 + x * (c4 + x * c5)))))


ORDERS: dict[Interpolation, int] = {straight: 2, quintic: 4}
"""With which power of the step the error falls (a quintic's where the acceleration jumps; smooth, the sixth)."""


def master_table(profile: Profile, interpolation: Interpolation) -> MasterTable:
    """The electronic cam of a profile: `[output] table_tolerance` (mm or deg) chooses the points, or `table_points`.

    Raises NotConverged where the tolerance needs more than MOST points.
    """
    program, unit = profile.setup().program, degrees(1.0) if profile.rotating else 1.0
    output = profile.output
    if output.table_tolerance is not None:
        theta = _within(program, unit, interpolation, output.table_tolerance)
    else:
        theta = np.linspace(0.0, 2.0 * pi, output.table_points or POINTS)
    jet = _jets(program, unit, theta)
    error = float(_errors(program, unit, theta, jet, interpolation).max())
    word = "deg" if profile.rotating else "mm"
    return MasterTable(np.degrees(theta), jet, word, error, unit * program.advance)


def _jets(program: Program, unit: float, theta: Floats) -> Floats:
    """Jets (4, n) per degree; where both sides differ, their mean."""
    scale = unit * (pi / 180.0) ** np.arange(4)[:, None]
    right, left = scale * program.jet(theta, 3), scale * program.jet(theta, 3, side="left")
    size = np.maximum(np.abs(right).max(axis=1, keepdims=True), 1e-300)
    return np.asarray(np.where(np.abs(right - left) > EVEN * size, 0.5 * (right + left), right))


def _errors(program: Program, unit: float, theta: Floats, jet: Floats, interpolation: Interpolation) -> Floats:
    """Largest error (n - 1,) between neighbouring rows, in the table's unit."""
    step = np.diff(theta)
    between = theta[:-1, None] + step[:, None] * SHARES
    true = unit * program.jet(between.ravel(), 0)[0].reshape(between.shape)
    made = interpolation(SHARES, np.degrees(step), jet[:, :-1], jet[:, 1:])
    return np.asarray(np.abs(made - true).max(axis=1))


def _within(program: Program, unit: float, interpolation: Interpolation, tolerance: float) -> Floats:
    """Angles, with every knot of the motion among them, between which the error stays within the tolerance."""
    theta = np.unique(np.clip(program.knots, 0.0, 2.0 * pi))
    theta[0], theta[-1] = 0.0, 2.0 * pi
    for _ in range(40):
        error = _errors(program, unit, theta, _jets(program, unit, theta), interpolation)
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
    ".ecam.csv", "electronic cam: position, velocity, acceleration, jerk over master angle, CSV", "profile", body=False
)
def write_ecam_csv(path: Path, profile: Profile) -> int:
    """Write the electronic cam of the follower's axis, one heading line; returns the bytes written.

    Numbers read back to the last bit. With an [operation] the derivatives in time at that speed stand beside.
    Raises ExportError where the tolerance cannot be met or the file cannot be written.
    """
    table = _table(path, profile, straight)
    unit = table.unit
    heads = ["master_deg", f"position_{unit}"]
    heads += [f"velocity_{unit}_per_deg", f"acceleration_{unit}_per_deg2", f"jerk_{unit}_per_deg3"]
    columns = [table.master, *table.jet]
    if profile.operation is not None:
        pace = 6.0 * profile.operation.speed  # deg/s
        heads += [f"velocity_{unit}_per_s", f"acceleration_{unit}_per_s2", f"jerk_{unit}_per_s3"]
        columns += [table.jet[k] * pace**k for k in (1, 2, 3)]
    return write_csv(path, heads, [("", np.stack(columns, axis=1))])


@writer(".plcopen.xml", "electronic cam for controllers: PLCopen XML (TC6), XYVA points", "profile", body=False)
def write_plcopen_xml(path: Path, profile: Profile) -> int:
    """Write the electronic cam as a program that holds it, with its data types; returns the bytes written.

    The measured error of the quintic between the points stands in the documentation. Raises ExportError where the
    tolerance cannot be met or the file cannot be written.
    """
    table = _table(path, profile, quintic)
    root = _project(profile, table)
    ET.indent(root, " ")
    text = ET.tostring(root, encoding="utf-8", xml_declaration=True)
    with atomic_write(path) as stream:
        stream.write(text + b"\n")
        return stream.tell()


def _table(path: Path, profile: Profile, interpolation: Interpolation) -> MasterTable:
    try:
        return master_table(profile, interpolation)
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


def _project(profile: Profile, table: MasterTable) -> ET.Element:
    from camgeom import __version__

    now = moment()[0].strftime("%Y-%m-%dT%H:%M:%S")
    root = ET.Element("project", xmlns=NAMESPACE)
    product = {"companyName": "camgeom", "productName": "camgeom", "productVersion": __version__}
    _add(root, "fileHeader", **product, creationDateTime=now)
    content = _add(root, "contentHeader", name=profile.name, modificationDateTime=now)
    info = _add(content, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        _add(info, f"{language}/scaling", x="1", y="1")
    types = _add(root, "types")
    name, last = _identifier(profile.name), len(table.master) - 1
    data = _add(types, "dataTypes")
    _structure(data, f"{name}_POINT", [(field, "LREAL") for field in FIELDS])
    ends = [("xStart", "LREAL"), ("xEnd", "LREAL")]
    _structure(data, f"{name}_REF", [*ends, ("byType", "BYTE"), ("nElements", "UDINT")])
    pou = _add(types, "pous/pou", name=name, pouType="program")
    held = _add(pou, "interface/localVars")
    reference = _variable(held, "Cam", f"{name}_REF")
    spread = [("xStart", _real(table.master[0])), ("xEnd", _real(table.master[-1]))]
    sizes = [("byType", str(XYVA)), ("nElements", str(last + 1))]
    _struct_value(_add(reference, "initialValue"), spread + sizes)
    points = _add(held, "variable", name="Points")
    array = _add(points, "type/array")
    _add(array, "dimension", lower="0", upper=str(last))
    _add(array, "baseType/derived", name=f"{name}_POINT")
    rows = _add(points, "initialValue/arrayValue")
    for row in zip(table.master.tolist(), *(column.tolist() for column in table.jet[:3])):
        _struct_value(_add(rows, "value"), [(field, _real(value)) for field, value in zip(FIELDS, row)])
    _words(_add(pou, "body/ST"), ";")
    _words(_add(pou, "documentation"), _about(table))
    _add(root, "instances/configurations")
    return root


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
    """Why a cam has no correction for its follower's elasticity; empty where it has one."""
    from camgeom.profile.solvers import uncorrected

    spec = model.profile.dynamics_spec
    if spec is None or spec.kind != "follower":
        return "only an elastic follower in [dynamics] has a polydyne motion"
    return "; ".join(map(str, uncorrected(model.profile, model.mechanism)))


@writer(
    ".polydyne.csv", "cam lift over the cam angle for an elastic follower (polydyne), CSV", takes="model",
    cams="followers with a linkage_stiffness in [dynamics]", missing=_uncorrected,
    body=False,
)
def write_polydyne_csv(path: Path, model: Model) -> int:
    """Write cam angle (deg) and cam lift (mm, deg of a swinging follower), one heading line; returns the bytes written.

    Raises ExportError for a profile without an elastic follower, and where its cam cannot be corrected.
    """
    study, why = model.elastic_follower, _uncorrected(model)
    if study is None or why:
        raise ExportError(f"{path}: {why}")
    motion = study.corrected
    phi, _ = piece_grid(motion.knots, PER_TURN)
    phi = np.unique(phi)
    lift = motion.jet(phi, 0)[0] * (180.0 / np.pi if model.profile.rotating else 1.0)
    unit = "deg" if model.profile.rotating else "mm"
    table = np.stack([np.degrees(phi), lift], axis=1)
    return write_csv(path, ("cam_angle_deg", f"cam_lift_{unit}"), [("", table)])
