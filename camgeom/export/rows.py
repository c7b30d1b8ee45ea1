"""Numbers as lines of text, a million a second: every digit is a column of bytes, filled by array arithmetic."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import numpy.typing as npt

_CHUNK = 16384
"""Lines at a time, so that the working arrays stay in the cache."""
_ABSENT = b"\0"
_MAX_DECIMALS = 9
"""Nine digits fit 32 bits, whose division is several times faster than that of 64."""


def rows(
    values: npt.NDArray[np.generic], before: Sequence[bytes], after: bytes, decimals: int = 0
) -> Iterator[bytes]:
    """Lines of text for values (n, k): before[0] value before[1] value ... after; in chunks of many lines.

    Each value is rounded to `decimals` places (0 to 9; an error of half a unit in the last one) and written without
    leading or trailing zeros, so 5.0 is `5`. The whole part must stay below 10⁹; ValueError otherwise, and for a value
    that is not finite.
    """
    if not 0 <= decimals <= _MAX_DECIMALS:
        raise ValueError(f"decimals = {decimals}, allowed 0 to {_MAX_DECIMALS}")
    if len(values) == 0:
        return
    largest = max(abs(float(values.max())), abs(float(values.min())))
    if not largest < 10.0**_MAX_DECIMALS - 1.0:
        raise ValueError(f"the value {largest} is too large to be written as text")
    whole = len(str(int(largest + 1.0)))
    for start in range(0, len(values), _CHUNK):
        yield _chunk(values[start : start + _CHUNK], before, after, whole, decimals)


def _chunk(
    values: npt.NDArray[np.generic], before: Sequence[bytes], after: bytes, whole: int, decimals: int
) -> bytes:
    width = sum(map(len, before)) + len(after) + values.shape[1] * (1 + whole + decimals + (decimals > 0))
    text = np.zeros((width, len(values)), dtype=np.uint8)
    at = 0
    for column, constant in enumerate(before):
        at = _constant(text, at, constant)
        scaled = np.rint(np.asarray(values[:, column], dtype=np.float64) * 10.0**decimals).astype(np.int64)
        text[at] = np.where(scaled < 0, ord("-"), 0)
        high, low = np.divmod(np.abs(scaled), 10**decimals) if decimals else (np.abs(scaled), scaled)
        _whole_digits(text[at + 1 : at + 1 + whole], high.astype(np.uint32))
        at += 1 + whole
        if decimals:
            _decimal_digits(text[at : at + 1 + decimals], low.astype(np.uint32))
            at += 1 + decimals
    _constant(text, at, after)
    return np.ascontiguousarray(text.T).tobytes().translate(None, _ABSENT)


def _constant(text: npt.NDArray[np.uint8], at: int, constant: bytes) -> int:
    text[at : at + len(constant)] = np.frombuffer(constant, dtype=np.uint8)[:, None]
    return at + len(constant)


def _whole_digits(text: npt.NDArray[np.uint8], number: npt.NDArray[np.uint32]) -> None:
    """Digits from the right; nothing in place of leading zeros but for the last digit."""
    for place in range(len(text) - 1, -1, -1):
        rest = number // np.uint32(10)
        digit = (number - rest * np.uint32(10) + np.uint32(ord("0"))).astype(np.uint8)
        text[place] = digit if place == len(text) - 1 else digit * (number > 0)
        number = rest


def _decimal_digits(text: npt.NDArray[np.uint8], number: npt.NDArray[np.uint32]) -> None:
    """Point and digits; nothing in place of trailing zeros, nor of the point where no digit follows."""
    started = np.zeros(len(number), dtype=bool)
    for place in range(len(text) - 1, 0, -1):
        rest = number // np.uint32(10)
        digit = (number - rest * np.uint32(10)).astype(np.uint8)
        started |= digit > 0
        text[place] = (digit + np.uint8(ord("0"))) * started
        number = rest
    text[0] = np.uint8(ord(".")) * started
