"""A file appears whole or not at all, whatever goes wrong while it is written."""

from __future__ import annotations

import errno
import multiprocessing
import os
import stat
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from camgeom.errors import ExportError
from camgeom.export.files import atomic_write

OLD = b"the old file"


@pytest.fixture
def target(tmp_path: Path) -> Path:
    path = tmp_path / "cam.stl"
    path.write_bytes(OLD)
    return path


def only_the_old_file(target: Path) -> bool:
    return target.read_bytes() == OLD and list(target.parent.iterdir()) == [target]


def test_writes_replaces_and_leaves_nothing_else(target: Path) -> None:
    with atomic_write(target) as stream:
        stream.write(b"new")
        assert target.read_bytes() == OLD
    assert target.read_bytes() == b"new"
    assert list(target.parent.iterdir()) == [target]


def test_a_missing_folder_is_made(tmp_path: Path) -> None:
    path = tmp_path / "a" / "b" / "cam.stl"
    with atomic_write(path) as stream:
        stream.write(b"new")
    assert path.read_bytes() == b"new"


def test_permissions_follow_the_umask_or_the_replaced_file(target: Path) -> None:
    before = os.umask(0o027)
    try:
        with atomic_write(target.with_name("fresh")) as stream:
            stream.write(b"new")
    finally:
        os.umask(before)
    assert stat.S_IMODE(target.with_name("fresh").stat().st_mode) == 0o640
    target.chmod(0o604)
    with atomic_write(target) as stream:
        stream.write(b"new")
    assert stat.S_IMODE(target.stat().st_mode) == 0o604


def test_a_link_is_followed(target: Path) -> None:
    link = target.with_name("link.stl")
    link.symlink_to(target)
    with atomic_write(link) as stream:
        stream.write(b"new")
    assert link.is_symlink()
    assert target.read_bytes() == b"new"


@pytest.mark.parametrize("exception", [ValueError, KeyboardInterrupt, ZeroDivisionError])
def test_an_interrupted_write_keeps_the_old_file(target: Path, exception: type[BaseException]) -> None:
    def write() -> None:
        with atomic_write(target) as stream:
            stream.write(b"half")
            raise exception

    with pytest.raises(exception):
        write()
    assert only_the_old_file(target)


def test_a_full_disk_is_named_and_keeps_the_old_file(target: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(ExportError, match=r"cam\.stl: cannot be written: the disk is full"), atomic_write(target) as s:
        s.write(b"new")
    assert only_the_old_file(target)


def test_a_file_beyond_the_limit_of_the_system_is_named(target: Path) -> None:
    """A real failed write: the process may not make a file of more than 64 kB."""
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        message = pool.apply(_write_beyond_the_limit, (str(target),))
    assert message == f"{target}: cannot be written: the file would exceed the largest size allowed here"
    assert only_the_old_file(target)


def _write_beyond_the_limit(path: str) -> str:
    import resource
    import signal

    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))
    try:
        with atomic_write(path) as stream:
            stream.write(bytes(200_000))
    except ExportError as error:
        return str(error)
    return "written"


def test_a_folder_as_target(tmp_path: Path) -> None:
    with pytest.raises(ExportError, match="it is a folder"), atomic_write(tmp_path):
        pass


def test_a_file_in_place_of_the_folder(target: Path) -> None:
    with pytest.raises(ExportError, match="is a file, not a folder"), atomic_write(target / "cam.stl"):
        pass
    assert only_the_old_file(target)


@pytest.mark.parametrize("name", ["x" * 300, "a\0b"])
def test_an_impossible_name(tmp_path: Path, name: str) -> None:
    with pytest.raises(ExportError, match="cannot be written"), atomic_write(tmp_path / name):
        pass
    assert not list(tmp_path.iterdir())


def test_the_longest_name_is_possible(tmp_path: Path) -> None:
    with atomic_write(tmp_path / ("x" * 255)) as stream:
        stream.write(b"new")
    assert (tmp_path / ("x" * 255)).read_bytes() == b"new"


@pytest.mark.parametrize(
    ("folder_mode", "file_mode", "reason"),
    [(0o555, 0o666, "no permission to write in the folder {folder}"), (0o777, 0o444, "the file is write-protected")],
)
def test_no_permission(folder_mode: int, file_mode: int, reason: str) -> None:
    """As an ordinary user, also where the tests run as root (pytest's own folders are closed to other users)."""
    with TemporaryDirectory() as folder:
        target = Path(folder, "cam.stl")
        target.write_bytes(OLD)
        target.chmod(file_mode)
        target.parent.chmod(folder_mode)
        message = _as_ordinary_user(str(target))
        target.parent.chmod(0o755)
        assert message == f"{target}: cannot be written: {reason.format(folder=folder)}"
        assert only_the_old_file(target)


def _as_ordinary_user(path: str) -> str:
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        return pool.apply(_write_without_rights, (path,))


def _write_without_rights(path: str) -> str:
    if os.getuid() == 0:
        os.setgroups([])
        os.setgid(65534)
        os.setuid(65534)
    try:
        with atomic_write(path) as stream:
            stream.write(b"new")
    except ExportError as error:
        return str(error)
    return "written"


def test_two_processes_leave_one_whole_file_of_either(tmp_path: Path) -> None:
    path = tmp_path / "shared" / "cam.stl"
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        pool.map(_write_many, [(str(path), letter) for letter in (b"a", b"b")], chunksize=1)
    content = path.read_bytes()
    assert content in (b"a" * 100_000, b"b" * 100_000)
    assert list(path.parent.iterdir()) == [path]


def _write_many(job: tuple[str, bytes]) -> None:
    path, letter = job
    for _ in range(20):
        with atomic_write(path) as stream:
            for _ in range(10):
                stream.write(letter * 10_000)
