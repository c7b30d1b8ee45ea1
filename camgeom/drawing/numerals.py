"""Numbers as an engineer reads them: significant digits, thin spaces, real minus signs, round axis ticks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from camgeom.maths import Floats

THIN = "\N{NARROW NO-BREAK SPACE}"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_STEPS = (1.0, 2.0, 2.5, 5.0, 10.0)
_DEGREE_STEPS = (1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 45.0, 60.0, 90.0, 180.0, 360.0, 720.0)
_FLAT = 1e-7
"""a range this small against its values is rounding noise and is shown as a constant"""
_PLAIN = (1e-3, 1e7)


def number(value: float, digits: int = 4) -> str:
    """Text of a number with at most `digits` significant digits, trailing zeros of a fraction dropped.

    >>> number(1234567.0), number(-0.00012345), number(37.0)
    ('1\u202f235\u202f000', '−1.234 × 10⁻⁴', '37')
    """
    if isinstance(value, int) and abs(value) < 1e15:
        return _grouped(str(value))
    if not math.isfinite(value):
        return "unbounded" if value > 0 else "unbounded below" if value < 0 else "not defined"
    if value == 0.0:
        return "0"
    rounded = float(f"{value:.{digits}g}")
    exponent = math.floor(math.log10(abs(rounded)))
    if not _PLAIN[0] <= abs(rounded) < _PLAIN[1]:
        mantissa = _trim(f"{rounded / 10.0**exponent:.{digits - 1}f}")
        return _sign(f"{mantissa} × 10{str(exponent).translate(_SUPERSCRIPT)}")
    return _grouped(_trim(f"{rounded:.{max(digits - 1 - exponent, 0)}f}"))


def decimals(value: float, places: int) -> str:
    """Text of a number with exactly `places` decimals.

    >>> decimals(-12345.678, 1)
    '−12\u202f345.7'
    """
    text = f"{value:.{places}f}"
    return _grouped(text.lstrip("-") if float(text) == 0.0 else text)


def _trim(text: str) -> str:
    return text.rstrip("0").rstrip(".") if "." in text else text


def _sign(text: str) -> str:
    return text.replace("-", "−", 1)


def _grouped(text: str) -> str:
    whole, point, fraction = text.lstrip("-").partition(".")
    if len(whole) > 4:
        whole = f"{int(whole):,}".replace(",", THIN)
    return ("−" if text.startswith("-") else "") + whole + point + fraction


@final
@dataclass(frozen=True, slots=True, eq=False)
class Ticks:
    """Round tick values over a range, the range they close, their texts and the power of ten they share."""

    low: float
    high: float
    at: Floats
    texts: tuple[str, ...]
    exponent: int = 0

    @property
    def factor(self) -> str:
        """`10³ ` where the texts are in thousands, else empty; it precedes the unit."""
        return f"10{str(self.exponent).translate(_SUPERSCRIPT)}" if self.exponent else ""


def ticks(low: float, high: float, count: int, *, unit: str = "", tight: bool = False) -> Ticks:
    """Ticks at a round step, at most about `count`; the range grows to the outer ticks unless `tight`.

    >>> ticks(0.0, 360.0, 9, unit="°", tight=True).texts
    ('0', '45', '90', '135', '180', '225', '270', '315', '360')
    """
    if not high - low > _FLAT * max(abs(low), abs(high)):
        pad = abs(low) * 0.1 or 1.0
        low, high = low - pad, high + pad
    raw = (high - low) / max(count, 1)
    step = _degree_step(raw) if unit in ("°", "deg") and 1.0 <= raw <= 720.0 else _step(raw)
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    if not tight:
        first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
        low, high = first * step, last * step
    at = np.asarray(np.arange(first, last + 1) * step, dtype=np.float64)
    exponent = _shared_exponent(at)
    places = max(0, -math.floor(math.log10(step / 10.0**exponent) + 1e-9))
    if step / 10.0**exponent * 10.0**places % 1.0 > 1e-6:  # a step of 2.5 needs one place more than its power of ten
        places += 1
    return Ticks(low, high, at, tuple(decimals(v / 10.0**exponent, places) for v in at), exponent)


def _step(raw: float) -> float:
    power: float = 10.0 ** math.floor(math.log10(raw))
    return next(s for s in _STEPS if s * power >= raw * (1.0 - 1e-9)) * power


def _degree_step(raw: float) -> float:
    return next(s for s in _DEGREE_STEPS if s >= raw * (1.0 - 1e-9))


def _shared_exponent(at: Floats) -> int:
    largest = float(np.max(np.abs(at)))
    if largest == 0.0 or 0.05 <= largest < 1e5:
        return 0
    return 3 * math.floor(math.log10(largest) / 3.0)
