"""A file that appears whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from camgeom.errors import ExportError

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
    target = Path(path)
    try:
        final = target.resolve() if target.is_symlink() else target
        mode = _mode(final)
        final.parent.mkdir(parents=True, exist_ok=True)
        temporary = final.with_name(f".{final.name[:80]}.{secrets.token_hex(8)}.part")
        stream = open(temporary, "x+b")  # noqa: SIM115 - closed below, before the rename
    except (OSError, RuntimeError, ValueError) as error:
        raise _export_error(target, error) from error
    try:
        try:
            with stream:
                yield stream
                stream.flush()
                os.fsync(stream.fileno())
            if mode is not None:
                temporary.chmod(mode)
            temporary.replace(final)
        except OSError as error:
            raise _export_error(target, error) from error
    except BaseException:
        with suppress(OSError):  # the first failure is the one to tell; the folder may be gone with the file
            temporary.unlink()
        raise


def _mode(final: Path) -> int | None:
    """Permissions of the file that is replaced, None where there is none; OSError where it must not be replaced."""
    if not final.exists():
        return None
    if final.is_dir():
        raise IsADirectoryError(errno.EISDIR, "is a directory")
    if not os.access(final, os.W_OK):
        raise PermissionError(0, "the file is write-protected")
    return final.stat().st_mode & 0o777


def _export_error(path: Path, error: Exception) -> ExportError:
    """The failure in words, naming the file."""
    if not isinstance(error, OSError):
        return ExportError(f"{path}: cannot be written: {error}")
    reason = REASONS.get(error.errno or 0, error.strerror or str(error))
    return ExportError(f"{path}: cannot be written: {reason.format(folder=path.parent)}")
