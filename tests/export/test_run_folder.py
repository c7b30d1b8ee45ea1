"""The folder of a run is one set: its files appear together, and none of another run stands there as if it were new."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from camgeom.errors import ExportError
from camgeom.export import folder as rooms
from camgeom.export.folder import FRONT, MANIFEST, STUDY, RunFolder, read_manifest, results
from camgeom.interrupts import ENDING

ABOUT = {"name": "cam one", "stem": "cam-one", "command": "run", "version": "1", "tolerance_mm": 0.01}


def run(
    place: Path, files: dict[str, str], *, design: str = "a", asked: frozenset[str] = frozenset(), **about: str
) -> list[str]:
    with RunFolder(place) as folder:
        for name, text in files.items():
            folder.path(name).write_text(text)
        made = {name: name.rpartition(".")[2] for name in files}
        folder.close({**ABOUT, **about}, design, made, {*made.values(), *asked})
        assert all(path.relative_to(place).parts[0].startswith("previous") for path in folder.moved)
        return [path.name for path in folder.moved]


def names(place: Path) -> set[str]:
    return {str(path.relative_to(place)) for path in place.rglob("*") if path.is_file()}


def told(place: Path) -> dict[str, Any]:
    """The files of a complete set, each of which is what its manifest says."""
    manifest = json.loads((place / "manifest.json").read_text())
    assert manifest["state"] == "complete"
    for entry in manifest["files"]:
        content = (place / entry["file"]).read_bytes()
        assert (len(content), hashlib.sha256(content).hexdigest()) == (entry["bytes"], entry["sha256"])
    return {entry["file"]: entry for entry in manifest["files"]}


def test_nothing_is_to_be_seen_until_all_of_it_is(tmp_path: Path) -> None:
    with RunFolder(tmp_path / "o") as folder:
        folder.path("cam.stl").write_text("stl")
        assert not any(not path.name.startswith(".") for path in (tmp_path / "o").iterdir())
        folder.close(ABOUT, "a", {"cam.stl": "stl"}, {"stl"})
    assert names(tmp_path / "o") == {"cam.stl", "manifest.json"}
    assert told(tmp_path / "o")["cam.stl"]["product"] == "stl"


def stopped(place: Path, error: type[BaseException]) -> None:
    with RunFolder(place) as folder:
        folder.path("cam.stl").write_text("half")
        raise error


def test_a_run_that_ends_early_leaves_all_as_it_was(tmp_path: Path) -> None:
    place = tmp_path / "o"
    with pytest.raises(KeyboardInterrupt):
        stopped(place / "deeper", KeyboardInterrupt)
    assert not place.exists()  # nor is a folder left that was made for it
    run(place, {"cam.stl": "old", "result.json": "{}"})
    with pytest.raises(ZeroDivisionError):
        stopped(place, ZeroDivisionError)
    assert (place / "cam.stl").read_text() == "old"
    assert names(place) == {"cam.stl", "result.json", "manifest.json"}


@pytest.mark.parametrize(
    ("design", "asked", "left", "moved"),
    [
        ("a", frozenset(), {"cam.stl"}, set()),  # the same design, not asked for again: it is still true
        ("a", frozenset({"stl"}), set(), {"previous/cam.stl"}),  # asked for and not made
        ("b", frozenset(), set(), {"previous/cam.stl"}),  # of another state of the profile
    ],
)
def test_a_file_that_a_run_does_not_bring(
    tmp_path: Path, design: str, asked: frozenset[str], left: set[str], moved: set[str]
) -> None:
    run(tmp_path, {"cam.stl": "stl", "result.json": "old"})
    run(tmp_path, {"result.json": "new", "report.html": "page"}, design=design, asked=asked)
    assert set(told(tmp_path)) == {"result.json", "report.html"} | left
    kept = {name for name in names(tmp_path) if not name.endswith("manifest.json")}
    assert kept == {"result.json", "report.html"} | left | moved
    for name in moved:
        entry = told(tmp_path / "previous")[Path(name).name]
        assert (entry["design"], entry["name"]) == ("a", "cam one")


def test_another_profile_gets_the_folder_and_the_first_stays_whole(tmp_path: Path) -> None:
    run(tmp_path, {"cam.stl": "stl", "result.json": "one", "report.html": "one"})
    run(tmp_path, {"result.json": "two"}, design="b", name="cam two", stem="cam-two")
    assert set(told(tmp_path)) == {"result.json"}
    assert set(told(tmp_path / "previous" / "cam-one")) == {"cam.stl", "result.json", "report.html"}
    assert (tmp_path / "previous/cam-one/result.json").read_text() == "one"


def test_what_is_in_the_place_of_previous_stops_nothing(tmp_path: Path) -> None:
    """A folder of another file system, or one of that name below `previous`, left a set half way for ever."""
    (tmp_path / "previous").write_text("mine")
    assert run(tmp_path, {"cam.stl": "one"}) == []
    (tmp_path / "previous.1").mkdir()
    (tmp_path / "previous.1/cam-one").write_text("mine too")
    assert run(tmp_path, {"cam.ply": "two"}, design="b", name="cam two", stem="cam-two") == ["cam.stl"]
    assert set(told(tmp_path / "previous.1/cam-one.1")) == {"cam.stl"}
    assert (tmp_path / "previous").read_text() == "mine"
    assert (tmp_path / "previous.1/cam-one").read_text() == "mine too"


def test_a_folder_of_another_file_system_is_not_moved_into(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(tmp_path, {"cam.stl": "one"})
    (tmp_path / "previous").mkdir()
    found = Path.stat

    def elsewhere(self: Path, **way: Any) -> os.stat_result:
        one = list(found(self, **way))
        return os.stat_result([*one[:2], one[2] + (self.name == "previous"), *one[3:]])

    with monkeypatch.context() as patched:
        patched.setattr(Path, "stat", elsewhere)
        assert rooms._taking(tmp_path, "previous") == "previous.1"
    assert rooms._taking(tmp_path, "previous") == "previous"


def test_what_the_user_has_among_earlier_files_stays(tmp_path: Path) -> None:
    """A manifest that is none of ours, and a file that was changed there, were written over."""
    (tmp_path / "manifest.json").write_text("mine")
    run(tmp_path, {"cam.stl": "one", "cam.obj": "one"})
    assert (tmp_path / "previous/manifest.json.1").read_text() == "mine"
    (tmp_path / "previous/manifest.json").write_text("mine too")
    run(tmp_path, {"result.json": "two"}, design="b")
    assert set(told(tmp_path / "previous")) == {"cam.stl", "cam.obj"}
    assert (tmp_path / "previous/manifest.json.2").read_text() == "mine too"
    (tmp_path / "previous/cam.stl").write_text("edited")
    run(tmp_path, {"cam.stl": "three", "cam.obj": "three"}, design="c")
    run(tmp_path, {"result.json": "four"}, design="d")
    assert (tmp_path / "previous/cam.stl").read_text() == "edited"
    assert (tmp_path / "previous/cam.stl.1").read_text() == (tmp_path / "previous/cam.obj").read_text() == "three"


def test_a_folder_that_another_process_holds_is_waited_for_and_then_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fcntl = pytest.importorskip("fcntl")
    holder = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(holder, fcntl.LOCK_EX)
    monkeypatch.setattr(rooms, "_PATIENCE", 0.1)
    with pytest.raises(ExportError, match=r"another process has held a lock on it for 0\.1 s"):
        run(tmp_path, {"cam.stl": "one"})
    assert names(tmp_path) == set()
    monkeypatch.setattr(rooms, "_PATIENCE", 60.0)
    monkeypatch.setattr(rooms.time, "sleep", lambda _: fcntl.flock(holder, fcntl.LOCK_UN))
    run(tmp_path, {"cam.stl": "one"})
    os.close(holder)
    assert set(told(tmp_path)) == {"cam.stl"}


@pytest.mark.parametrize(("other", "kept"), [("cam one", {"cam.stl"}), ("cam-one", {"cam.stl", "cam.stl.1"})])
def test_names_that_give_one_folder_lose_nothing_of_each_other(tmp_path: Path, other: str, kept: set[str]) -> None:
    """Of one name the later is kept; of two, both."""
    for name, text in (("cam one", "first"), ("cam two", "second"), (other, "third"), ("cam two", "fourth")):
        run(tmp_path, {"cam.stl": text}, design=text, name=name, stem=name.replace(" ", "-"))
    place = tmp_path / "previous/cam-one"
    assert set(told(place)) == kept
    assert {(place / name).read_text() for name in kept} == ({"first", "third"} if len(kept) > 1 else {"third"})


def test_what_the_user_put_there_stays(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "cam.stl").write_text("mine too")
    (tmp_path / "manifest.json").write_text('{"name": "a web page"}')
    assert set(run(tmp_path, {"cam.stl": "stl", "result.json": "{}"})) == {"cam.stl", "manifest.json.1"}
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / "previous/cam.stl").read_text() == "mine too"
    assert "web page" in (tmp_path / "previous/manifest.json.1").read_text()
    # A file of a run that was changed since is the user's too.
    (tmp_path / "cam.stl").write_text("edited")
    run(tmp_path, {"cam.stl": "again", "result.json": "{}"})
    assert (tmp_path / "cam.stl").read_text() == "again"
    assert (tmp_path / "previous/cam.stl").read_text() == "mine too"
    assert (tmp_path / "previous/cam.stl.1").read_text() == "edited"


def test_a_link_is_moved_as_a_users_file_is_and_a_folder_in_the_way_is_named(tmp_path: Path) -> None:
    """Runs wrote through it: over a user's file elsewhere, or beside the result of another run."""
    other, own = tmp_path / "other", tmp_path / "o"
    run(other, {"cam.stl": "of another", "result.json": "{}"})
    before = {path.name: path.read_bytes() for path in other.iterdir()}
    own.mkdir()
    for name in ("cam.stl", "manifest.json", "result.json"):
        (own / name).symlink_to(other / name)
    run(own, {"cam.stl": "new", "result.json": "{}"}, design="b")
    assert {path.name: path.read_bytes() for path in other.iterdir()} == before
    assert (own / "cam.stl").read_text() == "new"
    assert not any(path.is_symlink() for path in own.iterdir())
    assert (own / "previous/cam.stl").resolve() == other / "cam.stl"
    (tmp_path / "o/cam.ply").mkdir()
    told = r"cam\.ply: cannot be written: it is a folder"
    with RunFolder(tmp_path / "o") as folder, pytest.raises(ExportError, match=told):
        folder.path("cam.ply")


@pytest.mark.parametrize("text", ["[" * 200_000, '{"a":' * 50_000])
def test_a_manifest_as_deep_as_a_well_is_the_users_file(tmp_path: Path, text: str) -> None:
    (tmp_path / "manifest.json").write_text(text)
    run(tmp_path, {"cam.stl": "new"})
    assert (tmp_path / "previous/manifest.json.1").read_text() == text


MOMENTS = range(12)
FILES = {f"{word}.txt": f"new {word}" for word in ("result", "one", "two", "three")}


class Killed(BaseException):
    """The process is gone."""


@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("other", [False, True], ids=["same profile", "another"])
@pytest.mark.parametrize("following", [MANIFEST, STUDY])
def test_stopped_between_the_renames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: int, other: bool, following: str
) -> None:
    """At every rename: the manifest tells which files belong together, and the next run carries the set through; so
    does a study in the same folder."""
    run(tmp_path, {"result.txt": "old result", "left.txt": "old left"})
    (tmp_path / "two.txt").write_text("mine")
    count, replace = [0], Path.replace

    def dying(self: Path, target: Path) -> Path:
        if count[0] == moment:
            raise Killed
        count[0] += 1
        return replace(self, target)

    about = {"name": "cam two", "stem": "cam-two"} if other else {}
    with monkeypatch.context() as patched:
        patched.setattr(Path, "replace", dying)
        patched.setattr(rooms.RunFolder, "__exit__", lambda self, *rest: os.close(self._lock))
        try:
            run(tmp_path, FILES, design="b", **about)
            dead = False
        except Killed:
            dead = True
    manifest = read_manifest(tmp_path)
    known = {entry["file"] for entry in (*manifest["files"], *manifest.get("earlier", {}).get("files", []))}
    if manifest["state"] == "complete":
        told(tmp_path)
    present = {path.name for path in tmp_path.iterdir() if path.is_file() and not path.name.startswith(".")}
    assert present - {"manifest.json", "two.txt"} <= known
    # The next run.
    with RunFolder(tmp_path, following):
        pass
    after = told(tmp_path)
    old = (tmp_path / "result.txt").read_text() == "old result"
    assert set(after) == ({"result.txt", "left.txt"} if old else set(FILES))
    assert old <= dead
    if not old:
        assert {name: (tmp_path / name).read_text() for name in FILES} == FILES
        assert (tmp_path / "previous/two.txt").read_text() == "mine"
        place = tmp_path / "previous/cam-one" if other else tmp_path / "previous"
        assert (place / "left.txt").read_text() == "old left"
        assert set(told(place)) == ({"left.txt", "result.txt"} if other else {"left.txt"})
    assert not list(tmp_path.rglob(".*"))
    for place in tmp_path.rglob("manifest.json"):
        told(place.parent)


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError(28, "No space left on device"), Killed])
@pytest.mark.parametrize("other", [False, True], ids=["same profile", "another"])
def test_what_was_to_move_and_stays_is_in_no_manifest_of_earlier_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, other: bool, error: Any
) -> None:
    run(tmp_path, {"result.txt": "old result", "left.txt": "old left", "right.txt": "old right"})
    before = names(tmp_path)
    foretell = rooms.RunFolder._foretell

    def ended(self: RunFolder, manifest: dict[str, Any]) -> None:
        foretell(self, manifest)
        assert len(names(tmp_path / "previous")) == 1
        (tmp_path / "previous" / f".manifest.json.{'0' * 16}.part").write_text("half")
        raise error

    about = {"name": "cam two", "stem": "cam-two"} if other else {}
    with monkeypatch.context() as patched:
        patched.setattr(rooms.RunFolder, "_foretell", ended)
        if error is Killed:
            patched.setattr(rooms.RunFolder, "__exit__", lambda self, *rest: os.close(self._lock))
        with pytest.raises((ExportError, KeyboardInterrupt, Killed)):
            run(tmp_path, FILES, design="b", **about)
    if error is Killed:
        with RunFolder(tmp_path):
            pass
    assert names(tmp_path) - {"manifest.json"} == before - {"manifest.json"}
    assert not (tmp_path / "previous").exists()
    # What somebody takes out of a folder of earlier files is none of them any more.
    run(tmp_path, FILES, design="b")
    place = tmp_path / "previous"
    assert set(told(place)) == {"left.txt", "right.txt"}
    (place / "left.txt").unlink()
    run(tmp_path, FILES, design="c")
    assert set(told(place)) == {"right.txt"}


@pytest.fixture
def half(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of one run, in which another one was killed when its manifest was written and nothing was renamed."""
    run(tmp_path, {"result.txt": "old result", "left.txt": "old left"})

    through = rooms.RunFolder._carry_through

    def dying(self: RunFolder, manifest: dict[str, Any], own: str, fresh: bool = False) -> None:
        if fresh:
            raise Killed
        through(self, manifest, own)

    with monkeypatch.context() as patched:
        patched.setattr(rooms.RunFolder, "_carry_through", dying)
        patched.setattr(rooms.RunFolder, "__exit__", lambda self, *rest: os.close(self._lock))
        with pytest.raises(Killed):
            run(tmp_path, FILES, design="b")
    assert read_manifest(tmp_path)["state"] == "being replaced"
    return tmp_path


@pytest.mark.parametrize("kind", ["file", "link", "folder"])
def test_what_the_user_puts_there_between_a_kill_and_the_next_run_stays(half: Path, kind: str) -> None:
    """The set that was carried through stood on it."""
    if kind == "link":
        (half / "three.txt").symlink_to("elsewhere")
    elif kind == "folder":
        (half / "three.txt").mkdir()
    else:
        (half / "three.txt").write_text("mine")
        (half / "result.txt").write_text("mine too")
        (half / "left.txt").write_text("mine as well")
    with RunFolder(half, STUDY):
        pass
    assert set(told(half)) == set(FILES)
    assert {name: (half / name).read_text() for name in FILES} == FILES
    if kind == "file":
        assert (half / "previous/three.txt").read_text() == "mine"
        assert (half / "previous/result.txt").read_text() == "mine too"
        assert (half / "left.txt").read_text() == "mine as well"  # nothing of the new run stands there
    else:
        assert os.path.lexists(half / "previous/three.txt")
        assert not os.path.lexists(half / "previous/result.txt")  # ours, as it was: replaced
        assert (half / "previous/left.txt").read_text() == "old left"


def test_what_stands_in_the_way_of_earlier_files_by_then_stops_nothing(half: Path) -> None:
    """No run into the folder was possible any more."""
    shutil.rmtree(half / "previous")
    (half / "previous").write_text("mine")
    run(half, FILES, design="c")
    assert set(told(half)) == set(FILES)
    assert (half / "previous").read_text() == "mine"
    assert set(told(half / "previous.1")) == {"left.txt"}


@pytest.mark.parametrize("room", range(8))
def test_a_full_disk_leaves_the_earlier_set_or_the_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, room: int
) -> None:
    """Between the moves the manifests of `previous/` and of the whole set were still to be written: the manifest was of
    one design, result.json of another."""
    run(tmp_path, {"cam.stl": "one", "result.json": "{}"})
    before, write, left = {path: path.read_bytes() for path in tmp_path.iterdir()}, rooms.write_whole, [room]

    def full(path: Path, content: str | bytes) -> int:
        left[0] -= 1
        if left[0] < 0:
            raise ExportError(f"{path}: cannot be written: the disk is full")
        return write(path, content)

    with monkeypatch.context() as patched:
        patched.setattr(rooms, "write_whole", full)
        try:
            run(tmp_path, {"cam.ply": "two", "result.json": "{ }"}, design="b", name="cam two", stem="cam-two")
        except ExportError:
            assert room < 4
            assert {path: path.read_bytes() for path in tmp_path.iterdir() if path.is_file()} == before
            return
    assert set(told(tmp_path)) == {"cam.ply", "result.json"}
    assert set(told(tmp_path / "previous/cam-one")) == {"cam.stl", "result.json"}


def test_earlier_files_are_replaced_by_later_ones_of_their_design(tmp_path: Path) -> None:
    for text in ("one", "three"):
        run(tmp_path, {"cam.stl": text})
        run(tmp_path, {"cam.ply": text}, design="b", name="cam two", stem="cam-two")
    assert (tmp_path / "previous/cam-one/cam.stl").read_text() == "three"
    entries = json.loads((tmp_path / "previous/cam-one/manifest.json").read_text())["files"]
    assert [entry["file"] for entry in entries] == ["cam.stl"]
    told(tmp_path / "previous/cam-one")


@pytest.mark.parametrize("how", [signal.SIGINT, signal.SIGTERM])
def test_a_second_signal_leaves_no_clean_up_half_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, how: signal.Signals
) -> None:
    remove, before = rooms.shutil.rmtree, {one: signal.getsignal(one) for one in ENDING}

    def hit(*arguments: Any, **options: Any) -> None:
        signal.raise_signal(how)
        remove(*arguments, **options)

    monkeypatch.setattr(rooms.shutil, "rmtree", hit)
    came: list[int] = []
    signal.signal(how, lambda number, _: came.append(number))
    try:
        with pytest.raises(KeyboardInterrupt):
            stopped(tmp_path / "o", KeyboardInterrupt)
    finally:
        signal.signal(how, before[how])
    assert came == [how]  # once, at the end of it
    assert not (tmp_path / "o").exists()
    assert {one: signal.getsignal(one) for one in ENDING} == before


def test_a_manifest_that_a_kill_left_half_written_goes_with_the_next_run(half: Path) -> None:
    run(half, FILES, design="c")
    for place, name in product((half, half / "previous"), (MANIFEST, STUDY, FRONT)):
        (place / f".{name}.0123456789abcdef.part").write_text("{")
        (place / f".{name}.0123.part").write_text("somebody's")
    run(half, FILES, design="c")
    assert sorted(path.name for path in half.rglob(".*.part")) == sorted(
        f".{name}.0123.part" for name in (MANIFEST, STUDY, FRONT) * 2
    )


def test_half_written_manifests_of_others_are_theirs(tmp_path: Path) -> None:
    """Those behind a link, in a run's own folder and in one whose name begins alike were cleared."""
    place, half_written = tmp_path / "o", f".{MANIFEST}.0123456789abcdef.part"
    (tmp_path / "elsewhere").mkdir()
    run(place, {"cam.stl": "one"})
    (place / "previous").symlink_to(tmp_path / "elsewhere")
    (place / "previous-designs").mkdir()
    run(place / "previous.1", {"cam.stl": "own"})
    kept = [place / name / half_written for name in ("previous", "previous-designs", "previous.1")]
    for path in (*kept, place / half_written):
        path.write_text("{")
    run(place, {"cam.stl": "two"})
    assert all(path.exists() for path in kept)
    assert not (place / half_written).exists()


def test_a_file_that_must_not_be_replaced_is_named(half: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The folder was said to be write-protected."""
    ask = os.access
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "result.txt" and ask(path, mode))
    with pytest.raises(ExportError, match=r"result\.txt: cannot be written: the file is write-protected"):
        run(half, FILES, design="c")
    monkeypatch.undo()
    run(half, FILES, design="c")
    assert set(told(half)) == set(FILES)


def test_earlier_files_do_not_follow_a_link_out_of_the_folder(tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    place = tmp_path / "o"
    run(place, {"cam.stl": "one"})
    (place / "previous").symlink_to(tmp_path / "elsewhere")
    run(place, {"cam.stl": "two"}, design="b", name="cam two", stem="cam-two")
    assert not any((tmp_path / "elsewhere").iterdir())
    assert set(told(place / "previous.1/cam-one")) == {"cam.stl"}


def test_a_set_whose_files_are_gone_is_not_said_to_be_whole(half: Path) -> None:
    """The result of the earlier run was told to be that of the new one."""
    (staged,) = half.glob(".camgeom-*.part")
    for made in staged.iterdir():
        made.unlink()
    staged.rmdir()
    (half / "one.txt").write_text("mine")
    with RunFolder(half, STUDY):
        pass
    assert told(half) == {}
    assert (half / "one.txt").read_text() == "mine"
    assert set(told(half / "previous")) == {"left.txt", "result.txt"}
    assert (half / "previous/result.txt").read_text() == "old result"


@pytest.mark.parametrize("moment", range(8))
def test_a_signal_at_any_write_leaves_a_whole_set(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, moment: int) -> None:
    """One right after the manifest was written took the new files away, which it named."""
    run(tmp_path, {"result.txt": "old", "left.txt": "old"})
    count, sync = [0], rooms._sync

    def signalled(folder: Path) -> None:
        sync(folder)
        count[0] += 1
        if count[0] == moment:
            raise KeyboardInterrupt

    with monkeypatch.context() as patched:
        patched.setattr(rooms, "_sync", signalled)
        try:
            run(tmp_path, FILES, design="b", name="cam two", stem="cam-two")
        except KeyboardInterrupt:
            assert moment
    new = (tmp_path / "one.txt").exists()
    assert set(told(tmp_path)) == (set(FILES) if new else {"result.txt", "left.txt"})
    assert not list(tmp_path.glob(".camgeom*"))


def test_a_folder_of_earlier_files_that_is_a_run_s_own_is_left_alone(tmp_path: Path) -> None:
    """Its manifest became one of several runs, and then nobody's."""
    run(tmp_path / "previous", {"cam.stl": "of another"}, name="cam two", stem="cam-two")
    before = (tmp_path / "previous/manifest.json").read_bytes()
    for design in "abc":
        run(tmp_path, {f"{design}.stl": design}, design=design)
    assert (tmp_path / "previous/manifest.json").read_bytes() == before
    assert set(told(tmp_path / "previous.1")) == {"a.stl", "b.stl"}
    # And a run into the folder of earlier files keeps what is known of each.
    run(tmp_path / "previous.1", {"new.stl": "new"}, name="cam three", stem="cam-three")
    inside = told(tmp_path / "previous.1/previous/cam")
    assert {name: (one["name"], one["design"]) for name, one in inside.items()} == {
        "a.stl": ("cam one", "a"), "b.stl": ("cam one", "b"),
    }  # fmt: skip


def test_each_command_has_a_set_of_its_own(tmp_path: Path) -> None:
    run(tmp_path, {"cam.stl": "stl"})
    for manifest, name in ((STUDY, "study.csv"), (FRONT, "front.html")):
        with results(tmp_path, manifest) as place:
            place.path(name).write_text("new")
            place.close({**ABOUT, "name": "cam two", "stem": "cam-two"}, "b", {name: name}, {name})
    run(tmp_path, {"cam.stl": "another"}, design="c")
    assert names(tmp_path) == {"cam.stl", "study.csv", "front.html", MANIFEST, STUDY, FRONT}
    assert set(told(tmp_path)) == {"cam.stl"}
    (tmp_path / "study.parquet").mkdir()
    with pytest.raises(ExportError, match=r"study\.parquet: cannot be written: it is a folder"), \
            results(tmp_path, STUDY) as place:
        place.path("study.parquet")


OURS = '{"name": "a", "command": "run", "version": "1", "design": "d", %s}'


@pytest.mark.parametrize(
    "manifest",
    [
        "[]", "{", '{"files": [], "state": "complete"}', '{"files": [{"file": "a"}], "state": "complete"}',
        OURS % '"files": [{"file": "a", "product": ["x"]}], "state": "complete"',
        OURS % ('"files": [], "state": "complete", "stem": "' + 101 * "x" + '"'),
        OURS % '"files": 3, "state": "complete"', OURS % '"files": [{"file": "../x"}], "state": "complete"',
        OURS % '"files": [], "state": "complete", "stem": ".."', OURS % '"files": ["a"], "state": "complete"',
        OURS % '"files": [{"file": "a"}], "state": "being replaced", "staged": "..", "aside": [], "earlier": {}',
        OURS % '"files": [], "state": "being replaced", "staged": ".camgeom-0123456789abcdef.part", "earlier": {}, '
        '"aside": [["../../x", "previous"]]',
        OURS % '"files": [], "state": "complete", "x": NaN', OURS % '"files": [], "state": "complete", "x": 1e400',
        OURS % '"files": [{"file": "\\ud800"}], "state": "complete"',
    ],
)  # fmt: skip
def test_a_manifest_that_is_none_reaches_nothing(tmp_path: Path, manifest: str) -> None:
    place = tmp_path / "o"
    place.mkdir()
    (tmp_path / "x").write_text("outside")
    (place / "manifest.json").write_text(manifest)
    assert read_manifest(place) == {}
    run(place, {"result.json": "{}"})
    assert (tmp_path / "x").read_text() == "outside"
    assert (place / "previous/manifest.json.1").read_text() == manifest
    assert set(told(place)) == {"result.json"}


def test_a_manifest_that_could_not_be_another_program_s_is_ours(tmp_path: Path) -> None:
    (tmp_path / "manifest.json").write_text(OURS % '"files": [], "state": "complete"')
    assert read_manifest(tmp_path)["version"] == "1"
    each = {"file": "a", "name": "a", "version": "1", "design": "d", "sha256": "0"}
    (tmp_path / "manifest.json").write_text(json.dumps({"state": "complete", "files": [each]}))
    assert read_manifest(tmp_path)["files"] == [each]


@pytest.mark.parametrize("existed", [True, False])
def test_an_interrupt_while_the_folder_opens_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, existed: bool
) -> None:
    place = tmp_path / "o"
    if existed:
        place.mkdir()

    def interrupted(folder: Path, patience: float = 0.0) -> None:
        if folder.name.endswith(".part"):
            assert folder.is_dir()
            raise KeyboardInterrupt

    monkeypatch.setattr("camgeom.export.folder._hold", interrupted)
    with pytest.raises(KeyboardInterrupt), RunFolder(place):
        pass
    assert place.exists() == existed
    assert not list(tmp_path.rglob("*.part"))
