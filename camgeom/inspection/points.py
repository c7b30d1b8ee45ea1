"""Measured points of a coordinate measuring machine read from CSV: Cartesian or polar, any usual separator."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.reading import lines_of, read_bytes

FEWEST, MOST = 6, 1_000_000
MAX_BYTES = 100_000_000
"""B; a hundred characters a point"""
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


@immutable
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
    content = read_bytes(Path(path), MAX_BYTES, name)
    if not content.strip():
        raise _refused(name, "file", "holds no table", None, "CSV with columns x, y, z")
    try:
        return _parsed(lines_of(content, name), name)
    except csv.Error as error:
        raise _refused(name, "file", f"is no CSV: {error}") from error


def _parsed(lines: Iterator[str], name: str) -> MeasuredPoints:
    first = next(lines)
    separator = next((mark for mark in SEPARATORS if mark in first), ",")
    heads = [head.strip().lower() for head in next(csv.reader([first], delimiter=separator), [])]
    columns, polar = _columns(heads, name)
    for column in columns:
        if heads.count(heads[column]) > 1:
            raise _refused(name, "line 1", f"names {heads[column]!r} twice", ", ".join(heads)[:80])
    flank = next((i for i, head in enumerate(heads) if head in FLANK), None)
    values: list[list[float]] = []
    names: list[str] = []
    for number, row in enumerate(csv.reader(lines, delimiter=separator), start=2):
        if not any(cell.strip() for cell in row):
            continue
        if len(values) == MOST:
            raise _refused(name, "points", "there are too many points", None, f"{FEWEST} to {MOST}")
        values.append([_number(row, column, heads, number, separator, name) for column in columns])
        if flank is not None:
            names.append(row[flank].strip() if flank < len(row) else "")
    if len(values) < FEWEST:
        raise _refused(name, "points", "there are too few points", len(values), f"{FEWEST} to {MOST}")
    table = np.array(values).T
    if polar:
        turn = np.radians(table[0])
        table = np.stack([table[1] * np.cos(turn), table[1] * np.sin(turn), *table[2:]])
    planar = len(table) == 2
    if planar:
        table = np.vstack([table, np.zeros(table.shape[1])])
    return MeasuredPoints(table, planar, tuple(names) if flank is not None else None)


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
