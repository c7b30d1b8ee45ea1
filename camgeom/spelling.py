"""The nearest of the known words, for messages about misspelt names."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The most similar of the known words, None where nothing is close."""
    lower = {k.lower().replace("_", "-"): k for k in known}
    found = difflib.get_close_matches(word[:80].lower().replace("_", "-"), list(lower), n=1, cutoff=0.6)
    return lower[found[0]] if found else None


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A hint with the nearest spelling, empty where nothing is close."""
    found = nearest(word, known)
    return f"did you mean {found!r}?" if found else ""
