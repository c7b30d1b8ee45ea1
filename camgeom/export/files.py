"""Files that appear whole or not at all, and numbers as lines of text, a million a second."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from camgeom.errors import ExportError
from camgeom.maths import Floats

REASONS = {
    errno.EACCES: "no permission to write in the folder {folder}",
    errno.EPERM: "no permission to write in the folder {folder}",
    errno.EROFS: "the folder {folder} is on a read-only file system",
    errno.ENOSPC: "the disk is full",
    errno.EDQUOT: "the disk quota is used up",
    errno.EFBIG: "the file would exceed the largest size allowed here",
    errno.ENAMETOOLONG: "the name is too long",
    errno.ENOTDIR: "a part of {folder} is a file, not a folder",
    errno.EEXIST: "a part of {folder} is a file, not a folder",
    errno.EISDIR: "it is a folder",
}
_CHUNK = 16384
"""Lines at a time, so that the working arrays stay in the cache."""
_ABSENT = b"\0"
_MAX_DECIMALS = 9
"""Nine digits fit 32 bits, whose division is several times faster than that of 64."""


def moment() -> tuple[datetime, bool]:
    """The time that formats with a date carry, and whether it was given: SOURCE_DATE_EPOCH, seconds since 1970.

    With it the same profile gives the same bytes (https://reproducible-builds.org/specs/source-date-epoch). Raises
    ExportError where it is no such number.
    """
    given = os.environ.get("SOURCE_DATE_EPOCH")
    if given is None:
        return datetime.now(UTC), False
    try:
        return datetime.fromtimestamp(int(given), UTC), True
    except (ValueError, OverflowError, OSError):
        raise ExportError(f"SOURCE_DATE_EPOCH: needs whole seconds since 1970 (found {given[:40]!r})") from None


@contextmanager
def atomic_write(path: Path | str) -> Iterator[BinaryIO]:
    """A binary file open for writing (and seeking) that becomes `path` when the block ends without an exception.

    The bytes go to a file of a unique name in the same folder, which is made if it is missing; they are flushed to the
    disk and then renamed over `path` in one step. So a reader sees the old file or the new one, two writers of the same
    path leave one whole file of either, and after any exception (KeyboardInterrupt included) the old file stands and
    the temporary one is gone. A symbolic link is followed: its target is replaced, not the link.

    Raises ExportError with the file and the reason for every failure of the file system; other exceptions of the block
    pass through.
    """
    target, temporary, opened = Path(path), None, False
    try:
        final = target.resolve() if target.is_symlink() else target
        mode = mode_of(final)
        final.parent.mkdir(parents=True, exist_ok=True)
        # Its name is known before it exists, so that an interrupt at any moment finds it.
        temporary = final.with_name(f".{final.name[:80]}.{secrets.token_hex(8)}.part")
        with open(temporary, "x+b") as stream:
            opened = True
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        if mode is not None:
            temporary.chmod(mode)
        temporary.replace(final)
    except BaseException as error:
        if temporary is not None:
            with suppress(OSError, ValueError):  # the first failure is the one to tell; the folder may be gone too
                temporary.unlink()
        if isinstance(error, OSError) or (not opened and isinstance(error, RuntimeError | ValueError)):
            raise export_error(target, error) from error
        raise


def write_whole(path: Path | str, content: bytes | str) -> int:
    """Write a file that appears whole or not at all, text as UTF-8, bytes of file names that are none as \\udc80 to
    \\udcff; returns its bytes. Errors as of `atomic_write`."""
    with atomic_write(path) as stream:
        return stream.write(content.encode(errors="backslashreplace") if isinstance(content, str) else content)


def mode_of(final: Path) -> int | None:
    """Permissions of the file that is replaced, None where there is none; OSError where it must not be replaced."""
    if not final.exists():
        return None
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory")
    if not os.access(final, os.W_OK):
        raise PermissionError(0, "the file is write-protected")
    return final.stat().st_mode & 0o777


def export_error(path: Path, error: Exception) -> ExportError:
    """The failure in words, naming the file."""
    if not isinstance(error, OSError):
        return ExportError(f"{path}: cannot be written: {error}")
    reason = REASONS.get(error.errno or 0, error.strerror or str(error))
    return ExportError(f"{path}: cannot be written: {reason.format(folder=path.parent)}")


def write_csv(path: Path, heads: Sequence[str], tables: Iterable[tuple[str, Floats]]) -> int:
    """Write a CSV file, one heading line and then tables of numbers (n, k); returns the bytes written.

    tables  each with the words (commas included) that begin every line of it. Numbers read back to the last bit; NaN
            leaves its cell empty. Raises ExportError where the file cannot be written.
    """
    with atomic_write(path) as stream:
        stream.write((",".join(heads) + "\n").encode())
        for words, table in tables:
            for start in range(0, len(table), _CHUNK):
                rows = table[start : start + _CHUNK].tolist()
                lines = (f"{words}{','.join(map(repr, row)).replace('nan', '')}\n" for row in rows)
                stream.write("".join(lines).encode())
        return stream.tell()


def number_lines(
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
