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
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from camgeom.errors import ExportError
from camgeom.export.files import export_error, mode_of, write_whole
from camgeom.interrupts import held

MANIFEST, STUDY, FRONT, LAW, INSPECTION, VALIDATION = MANIFESTS = (
    "manifest.json", "study-manifest.json", "front-manifest.json", "law-manifest.json", "inspection-manifest.json",
    "validation-manifest.json",
)  # fmt: skip
"""of the files of a run, a study, a search, a best law, an inspection, the validation"""
PREVIOUS = "previous"
COMPLETE, REPLACING = "complete", "being replaced"
_TOLD, _TOLD_OF_EACH = {"name", "command", "version", "design"}, {"name", "version", "design", "sha256"}
"""what every manifest of ours says: of its run, or in `previous/`, where files are of several, of each file"""
_STAGED = re.compile(r"\.camgeom-[0-9a-f]{16}\.part")
_HALF = re.compile(rf"\.({'|'.join(map(re.escape, MANIFESTS))})\.[0-9a-f]{{16}}\.part")
"""a manifest that a killed run was writing: nobody else writes one where another is alone in the folder"""
_EARLIER = re.compile(rf"{PREVIOUS}(\.[0-9]+)?")
_LONGEST = 100
"""letters of the name of a folder of earlier files"""
_MOST = 10_000_000
"""bytes of a manifest that is read"""
_FINAL = ".complete.json"
"""the manifest of a whole set, among its files, until the last of them is in its place"""
MOST_TOLD = 6
"""names of files that had to make way, in a folder each"""
_BLOCK = 1 << 20
_PATIENCE, _PAUSE = 60.0, 0.02
"""s that a folder is waited for which another process holds, and between two tries"""


class RunFolder:
    """The folder of one run, open from its first file to its manifest; leaving it without `close` changes nothing.

    manifest  of `MANIFESTS`
    say       told at the end, however that is, which files had to make way, and where they are
    Raises ExportError where the folder cannot be made or written in.
    """

    def __init__(self, folder: Path, manifest: str = MANIFEST, say: Callable[[str], None] | None = None) -> None:
        self.folder, self.manifest, self._say = folder, manifest, say
        self.staged = folder / f".camgeom-{secrets.token_hex(8)}.part"
        self._lock: int | None = None
        self._made: list[Path] = []
        self._foretold = False
        self.moved: list[Path] = []
        """files that were in the way of this run's, or are of another design, where they are now"""

    def __enter__(self) -> RunFolder:
        try:
            for place in (self.folder, *self.folder.parents):
                if place.exists():
                    break
                self._made.append(place)
            self.folder.mkdir(parents=True, exist_ok=True)
            with _alone(self.folder):
                self._clear()
                self.staged.mkdir()
                # Held as long as this process lives: whoever can take it may clear what a dead run left.
                self._lock = _hold(self.staged)
        except BaseException as error:
            # Nobody leaves what was not entered: an interrupt here would leave the staged folder behind.
            with held():
                self._leave()
            if isinstance(error, OSError):
                raise export_error(self.folder, error) from error
            raise
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        with held():
            if self._begun:  # stopped between the renames: another try, else the next run's
                with suppress(OSError, ExportError), _alone(self.folder):
                    self._carry_through(read_manifest(self.folder, self.manifest), self.manifest)
            elif self._foretold:  # what was to move stays
                with suppress(OSError, ExportError), _alone(self.folder):
                    self._tidy()
            self._leave()
            self._tell()

    def _tell(self) -> None:
        """Say what moved."""
        if self._say is None:
            return
        for folder in dict.fromkeys(one.parent for one in self.moved):
            files = [one.name for one in self.moved if one.parent == folder]
            more = f" and {len(files) - MOST_TOLD} more" if len(files) > MOST_TOLD else ""
            self._say(f"moved to {folder}: {', '.join(files[:MOST_TOLD])}{more}")

    @property
    def _begun(self) -> bool:
        """Whether the manifest says that the files of this run are being renamed. It tells: a signal may come at any
        moment after it was written."""
        return read_manifest(self.folder, self.manifest).get("staged") == self.staged.name

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

    def close(self, about: dict[str, Any], design: str, made: dict[str, str], asked: set[str]) -> None:
        """Let the files appear together; what was in their way or is of another design moves to `previous/`.

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
                place = previous = _taking(self.folder, PREVIOUS)
                if other := earlier.get("name") != about["name"]:
                    place = _taking(self.folder, f"{previous}/{earlier.get('stem', 'cam')}")
                stays = {entry["file"] for entry in kept} | (set() if other else set(made))
                aside = [(entry["file"], place) for entry in ours if entry["file"] not in stays]
                own = self.manifest
                theirs = {*made, *(() if earlier else (own,))} - {entry["file"] for entry in ours}
                aside += self._foreign(theirs, previous)
                journal = {"staged": self.staged.name, "aside": aside, "earlier": earlier}
                manifest = {"state": REPLACING, **about, "design": design, "files": files, **journal}
                # What a full disk or a protected file forbids is met before anything moves.
                _replace_json(self.staged, {**_without_journal(manifest), "state": COMPLETE}, _FINAL)
                self._foretell(manifest)
                if (own, previous) in aside:
                    self._move(self.folder / own, self.folder / previous, None)
                _replace_json(self.folder, manifest, own)
                self._carry_through(manifest, own, fresh=True)
                self._foretold = False
        except OSError as error:
            raise export_error(self.folder, error) from error

    def _entry(self, name: str, product: str, command: str) -> dict[str, Any]:
        size, digest = _digest(self.staged / name)
        return {"file": name, "product": product, "command": command, "bytes": size, "sha256": digest}

    def _foreign(self, names: set[str], place: str) -> list[tuple[str, str]]:
        """The user's files in the places of new ones, and where they move. So do links: what they lead to is somebody's
        file elsewhere, perhaps of another run."""
        return [(name, place) for name in sorted(names) if os.path.lexists(self.folder / name)]

    def _carry_through(self, manifest: dict[str, Any], own: str, fresh: bool = False) -> None:
        """Move and rename what a manifest, by its name, in the state "being replaced" still has to; else nothing.

        fresh: all of it has just been written, by this run
        """
        if manifest.get("state") != REPLACING:
            return
        staged, new = self.folder / manifest["staged"], {entry["file"]: entry for entry in manifest["files"]}
        known = {entry["file"]: entry for entry in manifest["earlier"].get("files", [])}

        def away(name: str, place: str) -> None:
            # What was free when the manifest was written need not be so now.
            ours = name in known and _same(self.folder / name, known[name])
            self._move(self.folder / name, self._earlier(place), _entry_there(manifest, known[name]) if ours else None)

        for name, place in manifest["aside"]:
            # What has been renamed into its place already is the new one; what was changed since is the user's.
            standing = name in new and (staged / name).exists()
            if name != own and (standing or (name not in new and _same(self.folder / name, known.get(name, {})))):
                away(name, place)
        for name in new:
            if (staged / name).exists():
                # Since the run that began this was stopped somebody may have put a file of his own there.
                if os.path.lexists(self.folder / name) and not _same(self.folder / name, known.get(name, {})):
                    away(name, PREVIOUS)
                _place(staged / name, self.folder / name)
            elif name in known and known[name] != new[name] and _same(self.folder / name, known[name]):
                away(name, PREVIOUS)  # the new one is lost: nobody shall take this one for it
        _sync(self.folder)
        final = staged / _FINAL
        if fresh and final.exists():
            final.replace(self.folder / own)
            _sync(self.folder)
            return
        files = [entry for entry in manifest["files"] if fresh or _same(self.folder / entry["file"], entry)]
        _replace_json(self.folder, {**_without_journal(manifest), "state": COMPLETE, "files": files}, own)

    def _earlier(self, place: str) -> Path:
        """A folder of earlier files, as it is called now."""
        folder = self.folder
        for part in place.split("/"):
            folder /= _taking(folder, part)
        return folder

    def _foretell(self, manifest: dict[str, Any]) -> None:
        """Enter the files that are going to move in the manifests of where they move to."""
        self._foretold = True
        known = {entry["file"]: entry for entry in manifest["earlier"].get("files", [])}
        for name, place in manifest["aside"]:
            if name in known and _same(self.folder / name, known[name]):
                folder = self._earlier(place)
                folder.mkdir(parents=True, exist_ok=True)
                _entered(name, folder, _entry_there(manifest, known[name]))

    def _move(self, path: Path, folder: Path, entry: dict[str, Any] | None) -> None:
        if os.path.lexists(path):
            self.moved.append(_moved(path, folder, entry))

    def _clear(self) -> None:
        """Carry through what a killed run had begun, and drop what dead runs left behind."""
        for own in MANIFESTS:
            self._carry_through(read_manifest(self.folder, own), own)
        for place in self.folder.iterdir():
            if _STAGED.fullmatch(place.name) and place.is_dir() and (lock := _hold(place)) is not None:
                shutil.rmtree(place, ignore_errors=True)
                os.close(lock)
        _unfinished(self.folder)
        self._tidy()

    def _tidy(self) -> None:
        """Of the folders of earlier files, drop half manifests and entries of files that never came there, or have gone
        since. Where nothing is being moved, that is."""
        earlier = [one for one in self.folder.glob(f"{PREVIOUS}*") if _EARLIER.fullmatch(one.name)]
        earlier = [one for one in earlier if _ours(one)]
        for folder in (*earlier, *[one for above in earlier for one in above.iterdir() if _ours(one)]):
            if (lock := _hold(folder)) is not None:  # else it is a run's that has no manifest yet
                _unfinished(folder)
                with suppress(OSError, ExportError):
                    _pruned(folder)
                os.close(lock)


@contextmanager
def results(folder: Path, manifest: str, say: Callable[[str], None] | None = None) -> Iterator[RunFolder]:
    """The folder of a study or a search; what cannot be written is told as of its place there."""
    with RunFolder(folder, manifest, say) as place:
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
        if not (set(data) >= _TOLD or (data["files"] and all(set(entry) >= _TOLD_OF_EACH for entry in data["files"]))):
            return {}
        json.dumps(data, allow_nan=False, ensure_ascii=False).encode()  # what cannot be written again is none
        names = [entry["file"] for entry in (*data["files"], *data.get("earlier", {}).get("files", ()))]
        names += [name for name, _ in data.get("aside", ())]
        names += (places := [part for _, place in data.get("aside", ()) for part in place.split("/")])
        names += [stem := data.get("stem", "cam"), data.get("staged", "cam")]
        values = [value for entry in data["files"] for value in entry.values()]
        long = len(stem) > _LONGEST or any(len(part) > _LONGEST + 10 for part in places)  # with its number
        if long or not all(isinstance(value, str | int) for value in values):
            return {}
        # Names only: a manifest that somebody changed must not reach outside the folder.
        plain = not any(name in ("", ".", "..") or re.search(r"[/\\\x00]", name) for name in names)
        begun = data["state"] == REPLACING and {"aside", "earlier"} <= set(data) and _STAGED.fullmatch(data["staged"])
        return dict(data) if plain and (begun or data["state"] == COMPLETE) else {}
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
        return {}


def _ours(folder: Path) -> bool:
    """Whether it is a folder of earlier files: in another run's own, or one elsewhere, somebody else may write."""
    return folder.is_dir() and not folder.is_symlink() and "command" not in read_manifest(folder)


def _pruned(folder: Path) -> None:
    """Drop what the manifest of a folder of earlier files says of files that are not there."""
    listed = read_manifest(folder).get("files", [])
    there = [entry for entry in listed if os.path.lexists(folder / entry["file"])]
    if there and len(there) < len(listed):
        _replace_json(folder, {"state": COMPLETE, "files": there})
    elif listed and not there:
        (folder / MANIFEST).unlink()
        folder.rmdir()
        if _EARLIER.fullmatch(folder.parent.name):
            folder.parent.rmdir()


def _unfinished(folder: Path) -> None:
    """Drop the half manifests of a folder that nobody else writes in."""
    for place in folder.glob(".*.part"):
        if _HALF.fullmatch(place.name) and place.is_file():
            with suppress(OSError):
                place.unlink()


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


def _taking(folder: Path, name: str) -> str:
    """The first of name, name.1, ... that is not there yet, or a folder that files can be moved into."""
    number, found = 0, name
    while os.path.lexists(place := folder / found):
        real = place.is_dir() and not place.is_symlink() and os.access(place, os.W_OK | os.X_OK)
        run = "command" in read_manifest(place)  # whose own folder that is
        if real and not run and place.stat().st_dev == folder.stat().st_dev:
            break
        number += 1
        found = f"{name}.{number}"
    return found


def _place(made: Path, final: Path) -> None:
    """Rename a finished file into its place, with the permissions of the one it replaces."""
    try:
        if (mode := mode_of(final)) is not None:
            made.chmod(mode)
        made.replace(final)
    except OSError as error:
        raise export_error(final, error) from error


def _without_journal(manifest: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in manifest.items() if key not in ("staged", "aside", "earlier")}


def _entry_there(manifest: dict[str, Any], entry: dict[str, Any]) -> dict[str, Any]:
    """What the manifest of a folder of earlier files says of a file, by that of the run before it."""
    return {**{key: manifest["earlier"].get(key) for key in ("name", "version", "design")}, **entry}


def _moved(path: Path, folder: Path, entry: dict[str, Any] | None) -> Path:
    """Move a file into a folder of earlier ones, whose manifest gets its entry; where it is then.

    What the manifest there knows of that name and that cam, and is still the same, is replaced; beside another file the
    new one is numbered. The manifest is told before the file moves: whenever this ends, no file of ours is without one.
    """
    folder.mkdir(parents=True, exist_ok=True)
    if entry is None:
        return path.replace(folder / _numbered(folder, path.name, []))
    name = _entered(path.name, folder, entry)
    place = path.replace(folder / name)
    listed = read_manifest(folder).get("files", [])
    left = [one for one in listed if one["file"] != name or one == {**entry, "file": name}]
    if len(left) < len(listed):  # the one that stood there before; nobody takes it for this one, whose digest differs
        with suppress(OSError, ExportError):
            _replace_json(folder, {"state": COMPLETE, "files": left})
    return place


def _entered(name: str, folder: Path, entry: dict[str, Any]) -> str:
    """The name that a file will have in a folder of earlier ones, whose manifest has its entry now."""
    listed = read_manifest(folder).get("files", [])
    if not listed and os.path.lexists(folder / MANIFEST) and not read_manifest(folder):
        (folder / MANIFEST).replace(folder / _numbered(folder, MANIFEST, []))  # somebody's, not ours
    found = _numbered(folder, name, [one for one in listed if one.get("name") == entry.get("name")])
    if {**entry, "file": found} not in listed:
        _replace_json(folder, {"state": COMPLETE, "files": [*listed, {**entry, "file": found}]})
    return found


def _numbered(folder: Path, name: str, ours: list[dict[str, Any]]) -> str:
    """The first of name, name.1, ... of which no file of somebody else's is there; those of ours that are as they were
    may be replaced. The name of a manifest is never free."""
    number, found = 0, name
    while found in MANIFESTS or (
        os.path.lexists(folder / found)
        and not any(one["file"] == found and _same(folder / found, one) for one in ours)
    ):
        number += 1
        found = f"{name}.{number}"
    return found


@contextmanager
def _alone(folder: Path) -> Iterator[None]:
    """Alone in a folder among the runs of camgeom, as far as the system has such locks. Raises ExportError where
    another process holds it for long: those of camgeom do while they rename files."""
    lock = _hold(folder, _PATIENCE)
    try:
        yield
    finally:
        if lock is not None:
            os.close(lock)


def _hold(folder: Path, patience: float = 0.0) -> int | None:
    """The lock of a folder, held until it is closed or the process ends; None where another process has it, and where
    the system has no such locks, as Windows. Raises ExportError where it was waited for, s, in vain."""
    try:
        import fcntl

        lock = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        return None
    had = False
    try:
        for left in range(round(patience / _PAUSE), -1, -1):
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                had = True
                return lock
            except BlockingIOError:
                if left:
                    time.sleep(_PAUSE)
        if patience:
            raise ExportError(f"{folder}: another process has held a lock on it for {patience:g} s; wait for its end")
    except OSError:
        pass  # a file system without locks
    finally:
        if not had:
            os.close(lock)
    return None


def _sync(folder: Path) -> None:
    """Let the renames in a folder reach the disk, where the system can."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
