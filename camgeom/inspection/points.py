"""Measured points of a coordinate measuring machine read from CSV: Cartesian or polar, any usual separator."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.maths import Floats

FEWEST, MOST = 6, 1_000_000
MAX_BYTES = 200_000_000
SEPARATORS = (";", "\t", ",")
LARGEST = 1e6
"""mm; a coordinate beyond is taken for an error"""
CARTESIAN = ({"x", "x_mm"}, {"y", "y_mm"}, {"z", "z_mm"})
POLAR = (
    {"polar_angle_deg", "angle_deg", "angle", "azimuth_deg", "azimuth", "theta_deg", "theta"},
    {"polar_radius_mm", "radius_mm", "radius", "r", "r_mm"},
    {"z", "z_mm"},
)
FLANK = {"flank", "curve", "surface"}


@dataclass(frozen=True, eq=False)
class MeasuredPoints:
    """Points (3, n) in mm in the frame of the measuring machine; planar: no height was given, so z is 0.

    flank  name of the flank of each point as the file says it, or None
    """

    x: Floats
    planar: bool
    flank: tuple[str, ...] | None


def read_points(path: Path | str) -> MeasuredPoints:
    """Points of a CSV file with one heading line.

    Columns x, y, z (mm) or angle (deg), radius (mm) and z; z may be missing for a planar cam. Other columns are not
    read, but for `flank`. Separators: comma, semicolon, tab; decimal commas beside the latter two. Raises ProfileError
    with file, line and value for what is no table of points.
    """
    name = str(path)
    lines = _lines(Path(path), name)
    try:
        return _parsed(lines, name)
    except csv.Error as error:
        raise _refused(name, "file", f"is no CSV: {error}") from error


def _parsed(lines: list[str], name: str) -> MeasuredPoints:
    separator = next((mark for mark in SEPARATORS if mark in lines[0]), ",")
    heads = [head.strip().lower().lstrip("\ufeff") for head in next(csv.reader([lines[0]], delimiter=separator))]
    columns, polar = _columns(heads, name)
    flank = next((i for i, head in enumerate(heads) if head in FLANK), None)
    values, names = [], []
    for number, row in enumerate(csv.reader(lines[1:], delimiter=separator), start=2):
        if not any(cell.strip() for cell in row):
            continue
        values.append([_number(row, column, heads, number, separator, name) for column in columns])
        if flank is not None:
            names.append(row[flank].strip() if flank < len(row) else "")
    if not FEWEST <= len(values) <= MOST:
        raise _refused(name, "points", "the number of points is out of range", len(values), f"{FEWEST} to {MOST}")
    table = np.array(values).T
    if polar:
        turn = np.radians(table[0])
        table = np.stack([table[1] * np.cos(turn), table[1] * np.sin(turn), *table[2:]])
    planar = len(table) == 2
    if planar:
        table = np.vstack([table, np.zeros(table.shape[1])])
    return MeasuredPoints(table, planar, tuple(names) if flank is not None else None)


def _lines(path: Path, name: str) -> list[str]:
    try:
        if path.stat().st_size > MAX_BYTES:
            raise _refused(name, "file", "is too large", path.stat().st_size, f"up to {MAX_BYTES} bytes")
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise _refused(name, "file", f"cannot be read: {error.strerror or error}") from error
    except UnicodeDecodeError:
        raise _refused(name, "file", "is no text", None, "CSV with columns x, y, z") from None
    lines = text.splitlines()
    if not lines or "\0" in text:
        raise _refused(name, "file", "holds no table", None, "CSV with columns x, y, z")
    return lines


def _columns(heads: list[str], name: str) -> tuple[list[int], bool]:
    """Indices of the coordinate columns (two or three), and whether they are polar."""
    for names, polar in ((CARTESIAN, False), (POLAR, True)):
        found = [next((i for i, head in enumerate(heads) if head in known), None) for known in names]
        if found[0] is not None and found[1] is not None:
            return [index for index in found if index is not None], polar
    known = sorted({*set.union(*CARTESIAN), *set.union(*POLAR)})
    hint = next((text for head in heads if (text := did_you_mean(head, known))), "")
    shown = ", ".join(heads)[:80]
    raise ProfileError([Problem("line 1", "names no coordinates", shown, "x, y, z or angle, radius, z", hint)], name)


def _number(row: list[str], column: int, heads: list[str], line: int, separator: str, name: str) -> float:
    text = row[column].strip() if column < len(row) else ""
    try:
        value = float(text.replace(",", ".") if separator != "," else text)
    except ValueError:
        value = float("nan")
    if not abs(value) <= LARGEST:
        limit = f"a number up to {LARGEST:g} in size"
        raise _refused(name, f"line {line}", f"column {heads[column]!r} needs a number", text[:40], limit)
    return value


def _refused(name: str, key: str, message: str, value: object = None, allowed: str = "") -> ProfileError:
    return ProfileError([Problem(key, message, value, allowed)], name)
