"""The ways camgeom says no. Every message names what is wrong and what would be right, with the nearest spelling."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

UNSEEN = re.compile(
    r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028\u2029\u202a-\u202e\u2060\u2066-\u2069\ufeff\ud800-\udfff]"
)
"""characters that change what a reader sees without being seen: control characters, escapes of a terminal, marks that
turn the direction of writing, blanks of no width; and bytes of a file's name that are no text"""


def visible(text: str) -> str:
    """The text with every unseen character written as its escape; line ends and tabs stay."""
    return UNSEEN.sub(lambda mark: mark[0].encode("unicode_escape").decode(), text)


def one_line(text: str) -> str:
    """The text with its line ends as escapes: names of files may have some."""
    return text.replace("\n", "\\n").replace("\r", "\\r")


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


def not_installed(what: str, library: str, extra: str) -> ExportError:
    """What to install for something that a library of an extra makes."""
    return ExportError(f"{what} needs {library}, which is not installed: pip install 'camgeom[{extra}]'")


@dataclass(frozen=True)
class Unmade:
    """Why one product could not be made, while the others were.

    status       "refused" where the design or the profile admits no such product, "failed" where a method, the machine
                 or camgeom itself could not make it
    exit_status  what it means for a command: 1 a file that cannot be made, else that of the error
    trace        where an error of camgeom itself came from, else empty
    """

    status: Literal["refused", "failed"]
    reason: str
    exit_status: int
    trace: str = ""


def told_of(error: BaseException) -> str:
    """An error of somebody else's code in one short line, whatever its own text does."""
    try:
        text = " ".join(str(error).split())[:300]
    except KeyboardInterrupt:
        raise
    except BaseException:
        text = "its own text fails"
    return text if text and isinstance(error, ValueError | CamgeomError) else f"{type(error).__name__}: {text}"


def starved(error: BaseException) -> bool:
    """Whether memory ran out: threads and libraries that have no room for it say so in their own ways."""
    thread = isinstance(error, RuntimeError) and "start new thread" in str(error)
    library = isinstance(error, ImportError) and "failed to map segment" in str(error)
    return thread or library or isinstance(error, MemoryError) or isinstance(error.__cause__, MemoryError)


def memory_limits() -> dict[str, int]:
    """Bytes of memory that this process may have at most, by what a message calls them, where there is a limit."""
    try:
        from resource import RLIM_INFINITY, RLIMIT_AS, RLIMIT_DATA, getrlimit
    except ImportError:
        return {}
    kinds = ((RLIMIT_AS, "an address space of {} (ulimit -v)"), (RLIMIT_DATA, "data of {} (ulimit -d)"))
    found = {what: getrlimit(kind)[0] for kind, what in kinds}
    return {what.format(f"{limit // 10**6} MB"): limit for what, limit in found.items() if limit != RLIM_INFINITY}


NEED_LESS = "fewer segments, states, impact.turns or rows of tables need less"
"""what to try where memory ran out"""


def unmade(error: Exception) -> Unmade:
    """What an exception says about the product that it ended; its reason is one line.

    Expected are the errors of camgeom, memory that runs out, the file system, and libraries that cannot be loaded. Any
    other exception is a bug: it is told as one, and raised again where CAMGEOM_DEBUG is 1.
    """
    if isinstance(error.__cause__, KeyboardInterrupt):
        # Before Python 3.12 whatever ends the making of a class comes out as a RuntimeError.
        raise error.__cause__
    cause: BaseException = error
    while isinstance(cause, ExportError) and isinstance(cause.__cause__, CamgeomError):
        cause = cause.__cause__
    text = " ".join(str(error).split())
    if isinstance(cause, ProfileError):
        return Unmade("refused", "; ".join(map(str, cause.problems)), cause.exit_status)
    if isinstance(cause, DesignError):
        return Unmade("refused", text, cause.exit_status)
    if isinstance(cause, CamgeomError):
        return Unmade("failed", text, 1 if isinstance(cause, ExportError) else cause.exit_status)
    if starved(error):
        return Unmade("failed", f"out of memory; a larger output.tolerance, {NEED_LESS}", 3)
    if isinstance(error, ImportError):
        return Unmade("failed", f"a library that it needs cannot be loaded: {text}", 1)
    if isinstance(error, OSError):
        where = f"{error.filename}: " if error.filename else ""
        return Unmade("failed", f"{where}{error.strerror or text}", 1)
    if os.environ.get("CAMGEOM_DEBUG") == "1":
        raise error
    import traceback

    hint = "set CAMGEOM_DEBUG=1 to see where"
    trace = "".join(traceback.format_exception(error))
    return Unmade("failed", f"{type(error).__name__}: {text[:200]}; this is a bug ({hint})", 3, trace)
