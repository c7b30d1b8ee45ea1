"""What the sources print, computed from their own data by this package, with a verdict for each printed result.

One file a source holds its entries as data; an entry is a printed number or equation, the place where it stands and a
function that computes it. The verdict follows from the numbers alone (`entry`), never from a word in an entry.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from camgeom.errors import Problem, ProfileError, did_you_mean
from camgeom.validation import conjugate, globoidal_design, indexing, pin_insertion, pressing
from camgeom.validation.entry import Answer, Entry, JudgedEntry, Reading, Source, judge

__all__ = ["SOURCES", "Answer", "Entry", "JudgedEntry", "Reading", "Source", "source_named", "validate"]

SOURCES: tuple[Source, ...] = tuple(
    room.SOURCE for room in (pin_insertion, pressing, globoidal_design, indexing, conjugate)
)
"""In the order of their numbers."""


def source_named(name: str) -> Source:
    """The source with a name: `S1`, `1` or `pin-insertion`. Raises ProfileError with the names there are."""
    wanted = name.strip().lower().replace("_", "-")
    for source in SOURCES:
        if wanted in (source.short.lower(), source.short[1:], source.key):
            return source
    known = [key for source in SOURCES for key in (source.short, source.key)]
    hint = did_you_mean(wanted, known)
    raise ProfileError([Problem("NAME", "no such source", name[:60], ", ".join(known), hint)])


def validate(
    sources: Iterable[Source] = SOURCES, slow: bool = True, watch: Callable[[Source, Entry], None] | None = None
) -> list[JudgedEntry]:
    """Every entry judged, in order; without `slow` only those that take less than a second or so."""
    rows = []
    for source in sources:
        for entry in source.entries:
            if slow or not entry.slow:
                if watch is not None:
                    watch(source, entry)
                rows.append(judge(source.short, entry))
    return rows
