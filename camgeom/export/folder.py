"""The folder of a run: its files appear together, and a manifest says which files belong to which design.

All files of a run are written into a hidden folder inside the run's own. When the last of them is whole on the disk,
the manifest is replaced by one that says what is going to stand where, the files are renamed into their places, and the
manifest says that it is done. A run that is killed before leaves the folder as it was; one that is killed between the
renames leaves a manifest with the state "being replaced", which the next run into the folder carries through.

A file of an earlier run of the same profile is replaced by the new one of its name. One that the new run does not
bring moves to `previous/`, unless it is of the same design (keys, version, tolerance) and was not asked for again: then
it stays, and the manifest names it. Files of another profile move to `previous/<its name>/`, all of them. What no
manifest names, or was changed since, is the user's and stays; in the place of a new file it moves to `previous/`.

Studies and searches do the same with manifests of their own, so that the results of each command stand beside those of
the others.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from camgeom.errors import ExportError
from camgeom.export.files import export_error, mode_of, write_whole

MANIFEST, STUDY, FRONT = MANIFESTS = "manifest.json", "study-manifest.json", "front-manifest.json"
"""of the files of a run, a study, a search"""
PREVIOUS = "previous"
COMPLETE, REPLACING = "complete", "being replaced"
_STAGED = re.compile(r"\.camgeom-[0-9a-f]{16}\.part")
_MOST = 10_000_000
"""bytes of a manifest that is read"""
_BLOCK = 1 << 20


class RunFolder:
    """The folder of one run, open from its first file to its manifest; leaving it without `close` changes nothing.

    manifest  of `MANIFESTS`
    Raises ExportError where the folder cannot be made or written in.
    """

    def __init__(self, folder: Path, manifest: str = MANIFEST) -> None:
        self.folder, self.manifest = folder, manifest
        self.staged = folder / f".camgeom-{secrets.token_hex(8)}.part"
        self._lock: int | None = None
        self._made: list[Path] = []
        self._begun = False

    def __enter__(self) -> RunFolder:
        try:
            for place in (self.folder, *self.folder.parents):
                if place.exists():
                    break
                self._made.append(place)
            self.folder.mkdir(parents=True, exist_ok=True)
            if os.path.lexists(self.folder / PREVIOUS) and not (self.folder / PREVIOUS).is_dir():
                raise ExportError(f"{self.folder / PREVIOUS}: is in the way of the folder of earlier files")
            with _alone(self.folder):
                self._clear()
                self.staged.mkdir()
                # Held as long as this process lives: whoever can take it may clear what a dead run left.
                self._lock = _hold(self.staged)
        except BaseException as error:
            # Nobody leaves what was not entered: an interrupt here would leave the staged folder behind.
            self._leave()
            if isinstance(error, OSError):
                raise export_error(self.folder, error) from error
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        if self._begun:  # stopped between the renames: another try, else the next run's
            with suppress(OSError, ExportError), _alone(self.folder):
                self._carry_through(read_manifest(self.folder, self.manifest), self.manifest)
        self._leave()

    def _leave(self) -> None:
        if not self._begun:
            shutil.rmtree(self.staged, ignore_errors=True)
        if self._lock is not None:
            os.close(self._lock)
        for place in self._made:  # those that were made for a run that wrote nothing
            with suppress(OSError):
                place.rmdir()

    def path(self, name: str) -> Path:
        """Where a file is to be written that will stand in the folder under that name.

        Raises ExportError where it could not stand there: a folder or a write-protected file has its place.
        """
        try:
            mode_of(self.folder / name)
        except OSError as error:
            raise export_error(self.folder / name, error) from error
        return self.staged / name

    def shown(self, text: str) -> str:
        """A message about a file as the user knows its place."""
        return text.replace(str(self.staged), str(self.folder))

    def close(self, about: dict[str, Any], design: str, made: dict[str, str], asked: set[str]) -> list[str]:
        """Let the files appear together; returns what was in their way or is of another design, now in `previous/`.

        about   what the manifest says of the run; design: what decides whether files of two runs belong together
        made    product by file name, of all files of this run; asked: products asked for, made or not
        Raises ExportError where a file cannot be moved; the manifest then says that the set is not whole.
        """
        try:
            with _alone(self.folder):
                self._carry_through(read_manifest(self.folder, self.manifest), self.manifest)
                earlier = read_manifest(self.folder, self.manifest)
                # What was changed since is the user's.
                ours = [entry for entry in earlier.get("files", []) if _same(self.folder / entry["file"], entry)]
                old = ours if earlier.get("design") == design else []
                kept = [entry for entry in old if entry["file"] not in made and entry.get("product") not in asked]
                files = [*kept, *(self._entry(name, product, about["command"]) for name, product in made.items())]
                place = PREVIOUS if earlier.get("name") == about["name"] else f"{PREVIOUS}/{earlier.get('stem', 'cam')}"
                stays = {entry["file"] for entry in kept} | (set(made) if place == PREVIOUS else set())
                aside = [(entry["file"], place) for entry in ours if entry["file"] not in stays]
                own = self.manifest
                aside += self._foreign({*made, *(() if earlier else (own,))} - {entry["file"] for entry in ours})
                if (own, PREVIOUS) in aside:
                    _move(self.folder / own, self.folder / PREVIOUS, None)
                journal = {"staged": self.staged.name, "aside": aside, "earlier": earlier}
                manifest = {"state": REPLACING, **about, "design": design, "files": files, **journal}
                _replace_json(self.folder, manifest, own)
                self._begun = True
                self._carry_through(manifest, own)
        except OSError as error:
            raise export_error(self.folder, error) from error
        return [name for name, _ in aside]

    def _entry(self, name: str, product: str, command: str) -> dict[str, Any]:
        size, digest = _digest(self.staged / name)
        return {"file": name, "product": product, "command": command, "bytes": size, "sha256": digest}

    def _foreign(self, names: set[str]) -> list[tuple[str, str]]:
        """The user's files in the places of new ones, and where they move. So do links: what they lead to is somebody's
        file elsewhere, perhaps of another run."""
        return [(name, PREVIOUS) for name in sorted(names) if os.path.lexists(self.folder / name)]

    def _carry_through(self, manifest: dict[str, Any], own: str) -> None:
        """Move and rename what a manifest, by its name, in the state "being replaced" still has to; else nothing."""
        if manifest.get("state") != REPLACING:
            return
        staged, new = self.folder / manifest["staged"], {entry["file"] for entry in manifest["files"]}
        known = {entry["file"]: entry for entry in manifest["earlier"].get("files", [])}
        for name, place in manifest["aside"]:
            # What has been renamed into its place already is the new one.
            if name != own and (name not in new or (staged / name).exists()):
                told = {key: manifest["earlier"].get(key) for key in ("name", "version", "design")}
                _move(self.folder / name, self.folder / place, {**known[name], **told} if name in known else None)
        for name in new:
            if (staged / name).exists():
                _place(staged / name, self.folder / name)
        _sync(self.folder)
        files = [entry for entry in manifest["files"] if (self.folder / entry["file"]).exists()]
        done = {key: value for key, value in manifest.items() if key not in ("staged", "aside", "earlier")}
        _replace_json(self.folder, {**done, "state": COMPLETE, "files": files}, own)
        self._begun = False

    def _clear(self) -> None:
        """Carry through what a killed run had begun, and drop what dead runs left behind."""
        for own in MANIFESTS:
            self._carry_through(read_manifest(self.folder, own), own)
        for place in self.folder.iterdir():
            if _STAGED.fullmatch(place.name) and place.is_dir() and (lock := _hold(place)) is not None:
                shutil.rmtree(place, ignore_errors=True)
                os.close(lock)


@contextmanager
def results(folder: Path, manifest: str) -> Iterator[RunFolder]:
    """The folder of a study or a search; what cannot be written is told as of its place there."""
    with RunFolder(folder, manifest) as place:
        try:
            yield place
        except ExportError as error:
            raise ExportError(place.shown(str(error))) from error


def read_manifest(folder: Path, manifest: str = MANIFEST) -> dict[str, Any]:
    """A manifest of a folder; empty where there is none, or what has its name is none of camgeom's."""
    path = folder / manifest
    try:
        if path.is_symlink() or not path.is_file() or path.stat().st_size > _MOST:
            return {}
        data = json.loads(path.read_bytes())
        names = [entry["file"] for entry in (*data["files"], *data.get("earlier", {}).get("files", ()))]
        names += [name for word, place in data.get("aside", ()) for name in (word, *place.split("/"))]
        names += [data.get("stem", "cam"), data.get("staged", "cam")]
        # Names only: a manifest that somebody changed must not reach outside the folder.
        plain = not any(name in ("", ".", "..") or re.search(r"[/\\\x00]", name) for name in names)
        begun = data["state"] == REPLACING and {"aside", "earlier"} <= set(data) and _STAGED.fullmatch(data["staged"])
        return dict(data) if plain and (begun or data["state"] == COMPLETE) else {}
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return {}


def _replace_json(folder: Path, data: dict[str, Any], manifest: str = MANIFEST) -> None:
    """Replace a manifest of a folder in one step."""
    write_whole(folder / manifest, json.dumps(data, indent=2, allow_nan=False, ensure_ascii=False) + "\n")
    _sync(folder)


def _digest(path: Path) -> tuple[int, str]:
    """Bytes and SHA-256 of a file."""
    found, size = hashlib.sha256(), 0
    with open(path, "rb") as stream:
        while block := stream.read(_BLOCK):
            found.update(block)
            size += len(block)
    return size, found.hexdigest()


def _same(path: Path, entry: dict[str, Any]) -> bool:
    """Whether a file is still what the manifest says."""
    try:
        plain = not path.is_symlink() and path.is_file() and path.stat().st_size == entry.get("bytes")
        return plain and _digest(path) == (entry["bytes"], entry.get("sha256"))
    except OSError:
        return False


def _place(made: Path, final: Path) -> None:
    """Rename a finished file into its place, with the permissions of the one it replaces."""
    if (mode := mode_of(final)) is not None:
        made.chmod(mode)
    made.replace(final)


def _move(path: Path, folder: Path, entry: dict[str, Any] | None) -> None:
    """Move a file into a folder of earlier ones, whose manifest gets its entry; nothing where there is no such file.

    What the manifest there knows of that name and that cam is replaced; beside another file the new one is numbered.
    """
    if not os.path.lexists(path):
        return
    folder.mkdir(parents=True, exist_ok=True)
    listed = read_manifest(folder).get("files", [])
    name, number = path.name, 0
    ours = [one["file"] for one in listed if entry is not None and one.get("name") == entry.get("name")]
    while os.path.lexists(folder / name) and name not in ours:
        number += 1
        name = f"{path.name}.{number}"
    path.replace(folder / name)
    if entry is not None:
        files = [*(one for one in listed if one["file"] != name), {**entry, "file": name}]
        _replace_json(folder, {"state": COMPLETE, "files": files})


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Alone in a folder among the runs of camgeom, as far as the system has such locks."""
    lock = _hold(folder, wait=True)
    try:
        yield
    finally:
        if lock is not None:
            os.close(lock)


def _hold(folder: Path, wait: bool = False) -> int | None:
    """The lock of a folder, held until it is closed or the process ends; None where another process has it.

    Where the system has no such locks, as on Windows, a lock that is waited for is not had, and no other either.
    """
    try:
        import fcntl

        lock = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        return None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(lock)
        return None
    return lock


def _sync(folder: Path) -> None:
    """Let the renames in a folder reach the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
