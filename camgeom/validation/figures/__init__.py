"""The figures of the sources, drawn anew from their own data with the printed numbers as points.

One file a source holds its figures; a figure is drawn when it is asked for. Where the source's convention is not ours
both stand under each other.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import final

from camgeom.drawing.content import Block
from camgeom.immutable import immutable
from camgeom.validation.entry import Source


@final
@immutable(eq=True)
class SourceFigure:
    """A figure of a source: its number, and what draws it."""

    place: str
    draw: Callable[[], tuple[Block, ...]]


PLACES = {"S1": "pin_insertion", "S2": "pressing", "S4": "indexing", "S5": "conjugate"}
"""the rooms of this package by source; S3 has sketches alone"""


def figures(source: Source) -> tuple[SourceFigure, ...]:
    """The figures of a source, none of one that has no curves."""
    if source.short not in PLACES:
        return ()
    found: tuple[SourceFigure, ...] = import_module(f"{__name__}.{PLACES[source.short]}").FIGURES
    return found
