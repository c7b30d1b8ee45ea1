"""Every format there is: a disk that fills up, a folder that may not be written in, and the old file stands."""

from __future__ import annotations

import builtins
import errno
import os
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

import camgeom
from camgeom.errors import CamgeomError, ExportError, unmade
from camgeom.model import Model
from camgeom.profile import parse
from camgeom.report.files import formats
from tests.places import PROFILES
from tests.reference.planar_machines import ELASTIC, flat

ARROW = pytest.mark.skipif(find_spec("pyarrow") is None, reason="no pyarrow: pip install 'camgeom[parquet]'")
FORMATS = [
    pytest.param(form.extension, marks=[ARROW] if form.extension.endswith(".parquet") else [])
    for form in formats().values()
]
NO_FLANK = (".ecam.csv", ".plcopen.xml", ".history.csv", ".history.parquet")
"""of the motion, and of a turn: they need no flank"""
OPENED = builtins.open


@cache
def made(name: str) -> Model:
    text = (PROFILES / f"{name}.toml").read_text().replace("tolerance = 0.005", "tolerance = 0.05")
    return Model(parse(text if "[cutter]" in text else text + '\n[cutter]\nkind = "flat"\ndiameter = 16\n'))


def model(extension: str = "") -> Model:
    """A face groove, which admits every format but the stock a tool leaves, volumes, and what solvers need."""
    if extension.startswith(".impact"):
        return made("conjugate_rocker")
    if extension.startswith(".frame"):
        return made("constant_width_press")
    if extension == ".polydyne.csv":
        return Model(parse(ELASTIC.format(law="5-6-7-8-9")))
    return made("pin_insertion" if extension.startswith((".rest", ".volume")) else "disc_face_groove")


class Filling:
    """A file whose disk is full after some bytes."""

    def __init__(self, stream, room: int) -> None:
        self._stream, self._room = stream, room

    def write(self, data) -> int:
        size = len(memoryview(data).cast("B")) if not isinstance(data, bytes) else len(data)
        self._room -= size
        if self._room < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return self._stream.write(data)

    def writelines(self, lines) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str):
        return getattr(self._stream, name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._stream.close()


@pytest.mark.parametrize("room", [0, 700], ids=["at once", "midway"])
@pytest.mark.parametrize("extension", FORMATS)
def test_a_full_disk_is_named_with_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, extension: str, room: int
) -> None:
    path = tmp_path / f"cam{extension}"
    path.write_text("old")

    def filling(name, mode="r", *rest, **more):
        stream = OPENED(name, mode, *rest, **more)
        return Filling(stream, room) if str(name).endswith(".part") else stream

    monkeypatch.setattr(builtins, "open", filling)
    with pytest.raises(ExportError) as caught:
        camgeom.write(model(extension), path)
    assert str(caught.value) == f"{path}: cannot be written: the disk is full"
    monkeypatch.undo()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("extension", FORMATS)
def test_a_folder_that_may_not_be_written_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, extension: str
) -> None:
    path = tmp_path / f"cam{extension}"
    path.write_text("old")

    def forbidden(name, mode="r", *rest, **more):
        if str(name).endswith(".part"):
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(name))
        return OPENED(name, mode, *rest, **more)

    monkeypatch.setattr(builtins, "open", forbidden)
    with pytest.raises(ExportError) as caught:
        camgeom.write(model(extension), path)
    assert str(caught.value) == f"{path}: cannot be written: no permission to write in the folder {tmp_path}"
    monkeypatch.undo()
    assert path.read_text() == "old"


@pytest.mark.parametrize("extension", FORMATS)
def test_every_format_is_written_whole(tmp_path: Path, extension: str) -> None:
    path = tmp_path / f"cam{extension}"
    assert camgeom.write(model(extension), path) == path.stat().st_size > 500
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("extension", [one for one in FORMATS if one.values[0] not in NO_FLANK])
def test_what_a_design_does_not_admit_names_the_file(tmp_path: Path, extension: str) -> None:
    """A folded flank: no format but those that need no flank leaves anything behind."""
    rest = '[operation]\nspeed = 60\n[cutter]\nkind = "flat"\ndiameter = 8'
    folded = flat(cam="base_radius = 5\nbore = 4", rest=rest)
    path = tmp_path / f"cam{extension}"
    path.write_text("old")
    if extension == ".outline.csv":
        camgeom.write(folded, path)  # curves as data, the fold to be seen
        return
    with pytest.raises(CamgeomError, match=rf"cam{extension}".replace(".", r"\.")):
        camgeom.write(folded, path)
    assert path.read_text() == "old"


def test_the_second_reader_of_a_whole_cam_sees_the_same_body(tmp_path: Path) -> None:
    """STL, PLY, OBJ, GLB and 3MF of one cam by trimesh: watertight, and the volume of the mesh."""
    import trimesh

    solid = model().solid
    for extension, exact, unit in ((".stl", 1e-6, 1.0), (".ply", 1e-12, 1.0), (".obj", 1e-9, 1.0), (".3mf", 1e-8, 1.0),
                                   (".glb", 1e-5, 1e3)):  # fmt: skip
        path = tmp_path / f"cam{extension}"
        camgeom.write(model(), path)
        read = trimesh.load(path, force="mesh")
        read.merge_vertices(merge_tex=True, merge_norm=True)
        assert read.is_watertight, extension
        assert read.volume * unit**3 == pytest.approx(solid.mesh.volume, rel=exact), extension
        size = np.sort(np.ptp(read.vertices, axis=0) * unit)
        assert size == pytest.approx(np.sort(np.ptp(solid.mesh.vertices, axis=0)), rel=exact), extension


@pytest.mark.parametrize(
    ("extension", "library", "extra"), [(".dxf", "ezdxf", "dxf"), (".history.parquet", "pyarrow", "parquet")]
)
def test_a_library_that_is_missing_costs_its_file_alone_and_is_named(
    extension: str, library: str, extra: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    with pytest.raises(ExportError, match=rf"needs {library}, which is not installed: .*camgeom\[{extra}\]") as caught:
        camgeom.write(model(extension), tmp_path / f"cam{extension}")
    why = unmade(caught.value)
    assert (why.status, why.exit_status) == ("failed", 1)
