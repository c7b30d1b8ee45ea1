"""Reading files that others wrote: only regular ones, no larger than allowed, UTF-8, line after line of bounded length.

No size is trusted: a device has no end, a pipe may have no writer, a file may grow while it is read.
"""

from __future__ import annotations

import io
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from camgeom.errors import Problem, ProfileError

MAX_LINE = 10_000
"""characters in a line of a table"""


def refuse(message: str, file: str, *, key: str = "file", value: object = None, allowed: str = "") -> ProfileError:
    """A ProfileError with a single problem."""
    return ProfileError([Problem(key, message, value, allowed)], file)


def read_bytes(path: Path, limit: int, shown: str, key: str = "file") -> bytes:
    """The bytes of a regular file of at most `limit` bytes; the size is looked at before a byte is read.

    Raises ProfileError for a missing or unreadable file, a folder, a device or pipe, a loop of links, a large file.
    """
    try:
        # Not blocking, so that a pipe with no writer is refused instead of waited for.
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    except (OSError, ValueError) as error:
        raise refuse(os_reason(error), shown, key=key) from None
    try:
        info = os.fstat(handle)
        if stat.S_ISDIR(info.st_mode):
            raise refuse("is a folder, not a file", shown, key=key)
        if not stat.S_ISREG(info.st_mode):
            raise refuse("is not a regular file", shown, key=key)
        content = b"" if info.st_size > limit else _up_to(handle, limit + 1)
    except OSError as error:
        raise refuse(os_reason(error), shown, key=key) from None
    finally:
        os.close(handle)
    size = max(info.st_size, len(content))
    if size > limit:
        raise refuse("the file is too large", shown, key=key, value=size, allowed=f"at most {limit} bytes")
    return content


def _up_to(handle: int, most: int) -> bytes:
    """The file's bytes to its end, at most so many; a file may grow while it is read."""
    chunks: list[bytes] = []
    while most > 0 and (chunk := os.read(handle, most)):
        chunks.append(chunk)
        most -= len(chunk)
    return b"".join(chunks)


def os_reason(error: OSError | ValueError) -> str:
    if isinstance(error, FileNotFoundError):
        return "there is no such file"
    if isinstance(error, PermissionError):
        return "may not be read (no permission)"
    if isinstance(error, IsADirectoryError):
        return "is a folder, not a file"
    if isinstance(error, OSError) and error.strerror:
        return f"cannot be opened: {error.strerror}"
    return f"is not a usable file name: {error}"


def decode(content: bytes, shown: str, key: str = "file") -> str:
    """UTF-8 text; a byte order mark is dropped. ProfileError names the line of the first bad byte."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise refuse(f"is not UTF-8 text (byte {error.start + 1}, line {line})", shown, key=key) from None
    if "\x00" in text:
        line = text.count("\n", 0, text.index("\x00")) + 1
        raise refuse(f"is not text: it holds a NUL byte (line {line})", shown, key=key)
    return text


def lines_of(content: bytes, shown: str, key: str = "file") -> Iterator[str]:
    """The lines of a UTF-8 table without their ends, one at a time; a byte order mark is dropped.

    Raises ProfileError, naming the line, where one is too long or no text.
    """
    number = 0
    try:
        for number, line in enumerate(io.TextIOWrapper(io.BytesIO(content), encoding="utf-8-sig", newline=None), 1):
            if len(line) > MAX_LINE or "\0" in line:
                text = f"line {number} is too long" if len(line) > MAX_LINE else f"line {number} holds a NUL byte"
                raise refuse(text, shown, key=key, allowed=f"text of at most {MAX_LINE} characters in a line")
            yield line.rstrip("\n")
    except UnicodeDecodeError:
        raise refuse(f"is not UTF-8 text after line {number}", shown, key=key) from None
