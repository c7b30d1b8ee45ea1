"""Electronic cams for servo drives and controllers: CSV, and PLCopen XML.

PLCopen XML: the exchange format of PLCopen's technical committee 6, version 2.0 (namespace tc6_0200, the one that
controller tools read and write; IEC 61131-10 grew out of it). PLCopen's motion control part 1 leaves the content of
MC_CAM_REF to the vendor; the structures here have the fields that SoftMotion systems document for a cam of points with
position, velocity and acceleration (XYVA, run with a quintic between the points): xStart, xEnd, byType = 3, nElements,
and per point dX, dY, dV, dA. They have names of their own, so that they import where no vendor's library is, and are
copied field by field where one is.
"""

from __future__ import annotations

import re
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET

from camgeom.errors import CamgeomError, ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.export.master_table import Interpolation, MasterTable, master_table, quintic, straight

if TYPE_CHECKING:
    from camgeom.profile import Profile

NAMESPACE = "http://www.plcopen.org/xml/tc6_0200"
XHTML = "http://www.w3.org/1999/xhtml"
FIELDS = ("dX", "dY", "dV", "dA")
XYVA = 3
"""byType of a cam whose points carry position, velocity and acceleration"""


@writer(".ecam.csv", "electronic cam: position, velocity, acceleration, jerk over master angle, CSV", takes="profile")
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
    with atomic_write(path) as stream:
        stream.write((",".join(heads) + "\n").encode())
        for row in zip(*(column.tolist() for column in columns)):
            stream.write((",".join(map(repr, row)) + "\n").encode())
        return stream.tell()


@writer(".plcopen.xml", "electronic cam for controllers: PLCopen XML (TC6), XYVA points", takes="profile")
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

    now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S")
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
