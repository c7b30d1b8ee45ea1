"""Part 21 clear text (ISO 10303-21): numbers, strings with their escapes, and numbered instances."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import final

import numpy as np

from camgeom.maths import Floats

DECIMALS = 10
"""of coordinates, mm: far below the uncertainty of any file, and short"""
_WIDE = re.compile("[^ -~\U00010000-\U0010ffff]+|[\U00010000-\U0010ffff]+")
"""runs outside printable ASCII, of code units of one size"""


def string(text: str) -> str:
    """A string literal: quote and backslash doubled, everything outside printable ASCII as \\X2\\ or \\X4\\ code units.

    >>> string("Nut 'Ø 22'")
    "'Nut ''\\\\X2\\\\00D8\\\\X0\\\\ 22'''"
    """
    return "'" + _WIDE.sub(_code_units, text.replace("\\", "\\\\").replace("'", "''")) + "'"


def _code_units(run: re.Match[str]) -> str:
    size = 4 if ord(run[0][0]) > 0xFFFF else 2
    return f"\\X{size}\\" + "".join(f"{ord(character):0{2 * size}X}" for character in run[0]) + "\\X0\\"


def real(value: float) -> str:
    """A real literal that reads back as the same double; it always has a decimal point.

    >>> real(1e-7), real(5), real(-0.0)
    ('1.E-07', '5.', '0.')
    """
    text = repr(float(value) + 0.0).upper()
    mantissa, mark, exponent = text.partition("E")
    if "." not in mantissa:
        mantissa += "."
    elif mantissa.endswith(".0"):
        mantissa = mantissa[:-1]
    return mantissa + mark + exponent


def reals(values: Iterable[float]) -> str:
    """A list of real literals in parentheses."""
    return "(" + ",".join(real(value) for value in values) + ")"


def integers(values: Iterable[int]) -> str:
    """A list of integers in parentheses."""
    return "(" + ",".join(str(int(value)) for value in values) + ")"


def references(numbers: Iterable[int]) -> str:
    """A list of instance names in parentheses."""
    return "(" + ",".join(f"#{number}" for number in numbers) + ")"


def triples(points: Floats) -> str:
    """Coordinates (n, 3) as a list of lists."""
    return "(" + ",".join(f"({x},{y},{z})" for x, y, z in _texts(points)) + ")"


def _texts(points: Floats) -> list[list[str]]:
    """Coordinates (n, 3) as text, rounded to DECIMALS and without trailing zeros."""
    flat = (np.round(np.asarray(points, dtype=float), DECIMALS) + 0.0).ravel().tolist()
    texts = [f"{value:.{DECIMALS}f}".rstrip("0") for value in flat]
    return [texts[i : i + 3] for i in range(0, len(texts), 3)]


@final
class Instances:
    """The DATA section under construction: numbered instances in the order they are added."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self._shared: dict[str, int] = {}
        self._kept: list[object] = []
        self._numbers: dict[int, int] = {}

    def add(self, entity: str) -> int:
        """Append an instance; returns its number."""
        self.lines.append(entity)
        return len(self.lines)

    def once(self, entity: str) -> int:
        """The number of an instance with this very text, appended if it is new."""
        number = self._shared.get(entity)
        if number is None:
            number = self._shared[entity] = self.add(entity)
        return number

    def known(self, thing: object) -> int | None:
        """The number given to an object by `remember`, or None."""
        return self._numbers.get(id(thing))

    def remember(self, thing: object, number: int) -> int:
        """Note the number of an object that others share by identity."""
        self._kept.append(thing)
        self._numbers[id(thing)] = number
        return number

    def point(self, point: Sequence[float]) -> int:
        """CARTESIAN_POINT, shared with equal ones."""
        x, y, z = _texts(np.array([point]))[0]
        return self.once(f"CARTESIAN_POINT('',({x},{y},{z}))")

    def points(self, points: Floats) -> list[int]:
        """CARTESIAN_POINTs (n, 3), not shared."""
        first = len(self.lines) + 1
        self.lines.extend(f"CARTESIAN_POINT('',({x},{y},{z}))" for x, y, z in _texts(points))
        return list(range(first, first + len(points)))

    def direction(self, direction: Sequence[float]) -> int:
        """DIRECTION, shared with equal ones."""
        return self.once(f"DIRECTION('',{reals(direction)})")

    def data(self) -> str:
        """The instances as text, one a line."""
        return "".join([f"#{number}={line};\n" for number, line in enumerate(self.lines, 1)])
