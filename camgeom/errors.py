"""The ways camgeom says no. Every message names what is wrong and what would be right, with the nearest spelling."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

UNSEEN = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069\ufeff]")
"""characters that change what a reader sees without being seen: control characters, escapes of a terminal, marks that
turn the direction of writing"""


def visible(text: str) -> str:
    """The text with every unseen character written as its escape; line ends and tabs stay."""
    return UNSEEN.sub(lambda mark: mark[0].encode("unicode_escape").decode(), text)



class CamgeomError(Exception):
    """Base of every error that camgeom raises on purpose; its text is meant for the user."""

    exit_status = 3


@dataclass(frozen=True)
class Problem:
    """One thing wrong with an input: the key (dotted path), the value found, the allowed range and a hint."""

    key: str
    message: str
    value: object = None
    allowed: str = ""
    hint: str = ""

    def __str__(self) -> str:
        shown = "" if self.value is None else f" (found {_short(self.value)})"
        allowed = f"; allowed: {self.allowed}" if self.allowed else ""
        hint = f"; {self.hint}" if self.hint else ""
        return f"{self.key}: {self.message}{shown}{allowed}{hint}"


class ProfileError(CamgeomError):
    """A bad input: every problem found, with file, key, value, allowed range and the nearest spelling."""

    exit_status = 2

    def __init__(self, problems: list[Problem], file: str = "") -> None:
        self.problems = list(problems)
        self.file = file
        super().__init__(self._text())

    def _text(self) -> str:
        where = f"{self.file}: " if self.file else ""
        if len(self.problems) == 1:
            return f"{where}{self.problems[0]}"
        lines = "\n".join(f"  {problem}" for problem in self.problems)
        return f"{where}{len(self.problems)} problems\n{lines}"


class DesignError(CamgeomError):
    """The design admits no such product (an undercut cam has no solid); the text says which finding forbids it."""

    exit_status = 1


class NotConverged(CamgeomError):
    """A numerical method did not reach its tolerance; the text says why and what would help."""

    exit_status = 3


class GeometryEngineError(CamgeomError):
    """A geometry engine returned a bad status; the text names the operation and the status."""

    exit_status = 3


class ExportError(CamgeomError):
    """A file could not be written; the text names the file and the reason. An earlier file is untouched."""

    exit_status = 3


def _short(value: object, limit: int = 60) -> str:
    """A value as text, shortened so that a hostile value cannot flood the terminal."""
    text = repr(value)
    return text if len(text) <= limit else f"{text[: limit - 1]}…"


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The most similar of the known words, None where nothing is close."""
    import difflib

    lower = {k.lower().replace("_", "-"): k for k in known}
    close = difflib.get_close_matches(word[:80].lower().replace("_", "-"), list(lower), n=1, cutoff=0.6)
    return lower[close[0]] if close else None


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A hint with the nearest spelling, empty where nothing is close."""
    meant = nearest(word, known)
    return f"did you mean {meant!r}?" if meant else ""
