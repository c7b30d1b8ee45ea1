"""Entries of the validation: a printed result, ours, and the verdict that follows from both.

confirmed         ours agrees within half a unit of the last printed digit (a bound: it holds)
misprint          it does not, but one changed term explains it: of a number, a reading of the source that gives what is
                  printed; of an equation, a corrected form that gives what the exact computation does
not reproducible  neither; the readings that were tried are told with their values
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from math import isfinite
from typing import Any, Literal, final

from camgeom.immutable import immutable

Verdict = Literal["confirmed", "misprint", "not reproducible"]
Comparison = Literal["=", "<", ">"]
EQUATION = 1e-6
"""share within which an equation has to agree with the exact computation"""


@final
@immutable(eq=True)
class Reading:
    """Another reading of the source, one thing changed, and the value that it gives.

    slip  whether the change is one of a term of the source, which can explain a misprint; else another model of ours
    """

    what: str
    value: float
    slip: bool = True


@final
@immutable(eq=True)
class Answer:
    """What an entry's computation gives.

    computed  ours
    readings  what else was tried: of a printed number, readings of the source; of an equation, corrected forms
    printed   of an equation: what its printed form gives where it is tested
    """

    computed: float
    readings: tuple[Reading, ...] = ()
    printed: float | None = None


@final
@immutable(eq=True)
class Entry:
    """A printed result: where it stands, what it says, and how it is computed.

    printed     as it stands in the source, so that its last digit is known; "" of an equation
    comparison  "=" of a number, "<" or ">" of a statement that something is less or more than `printed`
    within      where not half a unit of the last digit: "about", or the digits of the numbers it is made of
    reason      why the source and the computation differ, or what the figure rests on
    """

    item: str
    place: str
    says: str
    printed: str
    unit: str
    answer: Callable[[], Answer]
    reason: str = ""
    comparison: Comparison = "="
    within: float | None = None
    slow: bool = False


@final
@immutable(eq=True)
class JudgedEntry:
    """A judged entry. `tolerance` is the deviation up to which the printed digits are met, `tried` the readings."""

    source: str
    item: str
    place: str
    says: str
    printed: float
    comparison: Comparison
    computed: float
    unit: str
    tolerance: float
    verdict: Verdict
    reason: str
    tried: tuple[Reading, ...] = ()

    @property
    def difference(self) -> float:
        """Ours less the printed one."""
        return self.computed - self.printed

    def as_dict(self) -> dict[str, Any]:
        """Plain data, with the difference."""
        return {**asdict(self), "difference": self.difference}


@final
@immutable(eq=True)
class Source:
    """A document: its short and its long name, what it is, and its entries."""

    short: str
    key: str
    title: str
    reference: str
    entries: tuple[Entry, ...]


def last_digit(printed: str) -> float:
    """Half a unit of the last digit of a printed number."""
    mantissa, _, exponent = printed.lower().partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** (int(exponent or 0) - decimals)


def judge(source: str, entry: Entry) -> JudgedEntry:
    """The entry computed and judged. Raises ValueError where a computation gives no finite number: a bug."""
    answer = entry.answer()
    equation = not entry.printed
    printed = answer.printed if equation else float(entry.printed)
    if printed is None or not all(map(isfinite, (printed, answer.computed, *(r.value for r in answer.readings)))):
        raise ValueError(f"{source} {entry.item}: no finite value")
    own = EQUATION * abs(answer.computed) if equation else last_digit(entry.printed)
    tolerance = own if entry.within is None else entry.within
    target = answer.computed if equation else printed
    told = tuple(r for r in answer.readings if r.slip and holds(target, r.value, entry.comparison, tolerance))
    verdict: Verdict = "not reproducible"
    if holds(printed, answer.computed, entry.comparison, tolerance):
        verdict = "confirmed"
    elif told:
        verdict = "misprint"
    return JudgedEntry(
        source, entry.item, entry.place, entry.says, printed, entry.comparison, answer.computed, entry.unit,
        tolerance, verdict, _reason(entry.reason, verdict, told, answer.readings), answer.readings,
    )  # fmt: skip


def holds(printed: float, value: float, comparison: Comparison, tolerance: float) -> bool:
    """Whether a value meets what is printed; the last digit may be rounded either way."""
    if comparison == "<":
        return value < printed
    if comparison == ">":
        return value > printed
    return abs(value - printed) <= tolerance * (1.0 + 1e-9)


def _reason(text: str, verdict: Verdict, told: tuple[Reading, ...], tried: tuple[Reading, ...]) -> str:
    """The entry's reason, with the reading that explains a misprint or everything that was tried in vain."""
    parts = [text] if text else []
    if verdict == "misprint":
        parts.insert(0, " ".join(f"{r.what}: {r.value:.7g}." for r in told))
    elif verdict == "not reproducible" and tried:
        parts.append("Tried: " + "; ".join(f"{r.what} {r.value:.7g}" for r in tried) + ".")
    return " ".join(parts)
