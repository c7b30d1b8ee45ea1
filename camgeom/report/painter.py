"""The process that draws: the graphics library ends its process where it fails, so it has one of its own.

The process starts with the first picture and serves all that follow. One that ends while it draws costs that picture,
and the next picture starts another.
"""

from __future__ import annotations

import atexit
import logging
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camgeom.errors import ExportError, memory_limits, not_installed
from camgeom.export import NamedMesh
from camgeom.export.files import write_whole
from camgeom.maths import Floats
from camgeom.report.views import Stage, View
from camgeom.worker import Worker, WorkerEnded

_CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"
_START_SECONDS, _PICTURE_SECONDS = 60.0, 600.0
"""until a process that does not answer is given up"""


def render(bodies: Sequence[NamedMesh], path: Path | str, view: View | None = None) -> int:
    """Draw bodies into a PNG file; returns the bytes written.

    A body without a colour is steel with blue flanks; give a roller ROLLER. Raises ExportError where no OpenGL library
    works here (naming the packages) or it fails, the field or camera is unknown, or the file cannot be written.
    """
    with stage(bodies, view or View()) as scene:
        picture = scene.png()
    return write_whole(Path(path), picture)


@contextmanager
def stage(bodies: Sequence[NamedMesh], view: View, reach: Floats | None = None) -> Iterator[StandingScene]:
    """A scene that can be drawn again and again with its bodies in other places. Raises as render does.

    reach   points (n, 3), mm, that the picture has to hold; by default the bodies where they are given
    """
    if view.field is not None and not any(view.field in body.mesh.fields for body in bodies):
        raise ExportError(f"no body carries the field {view.field!r}")
    view.axes()
    painter = working_painter()
    shown = [replace(body, mesh=replace(body.mesh, fields=_only(body, view.field))) for body in bodies]
    scene = StandingScene(painter, painter.ask("open", shown, view, reach))
    try:
        yield scene
    finally:
        with suppress(ExportError):
            painter.ask("close", scene.number)


def _only(body: NamedMesh, field: str | None) -> dict[str, Floats]:
    return {name: values for name, values in body.mesh.fields.items() if name == field}


class StandingScene:
    """A scene that stands in the process that draws."""

    def __init__(self, painter: Painter, number: int) -> None:
        self._painter, self.number = painter, number

    def place(self, name: str, pose: Floats) -> None:
        """Put the named body where the rigid motion (3, 4) or (4, 4) takes it from its place in the cam frame."""
        self._painter.ask("place", self.number, name, pose)

    def image(self) -> npt.NDArray[np.uint8]:
        """The picture (h, w, 3), with scale bar, axes and colour bar."""
        return np.asarray(self._painter.ask("image", self.number), np.uint8)

    def png(self) -> bytes:
        """The picture as a PNG file's content."""
        return bytes(self._painter.ask("png", self.number))


def draws() -> bool:
    """Whether pictures can be drawn here."""
    return find_spec("pyvista") is not None and _started(os.getpid()) is not None


def working_painter() -> Painter:
    """The process that draws for this one. Raises ExportError where nothing draws here."""
    if find_spec("pyvista") is None:
        raise not_installed("a picture", "pyvista", "pictures")
    painter = _started(os.getpid())
    if painter is not None and painter.ended:
        _started.cache_clear()
        painter = _started(os.getpid())
    if painter is None:
        within = f" within {' and '.join(limits)}" if (limits := memory_limits()) else ""
        raise ExportError(
            f"no picture can be drawn: no OpenGL library works here{within}; on Debian or Ubuntu, as root: "
            "apt-get install libegl1 libgl1-mesa-dri"
        )
    return painter


@cache
def _started(process: int) -> Painter | None:
    """The process that draws for a process; None where no window class does.

    The window class is the one that the environment variable VTK_DEFAULT_OPENGL_WINDOW names, else the first that
    draws of EGL, the library's own choice if there is a display, and OSMesa.
    """
    named = os.environ.get(_CHOICE)
    if named is not None:
        candidates = [named]
    else:
        candidates = ["vtkEGLRenderWindow", *([""] if os.environ.get("DISPLAY") else []), "vtkOSOpenGLRenderWindow"]
    return next((painter for window in candidates if (painter := _start(window)) is not None), None)


def _start(window: str) -> Painter | None:
    """A process that draws with a window class ("": the library's own choice); None where that fails."""
    try:
        painter = Painter(window)
    except OSError:
        return None
    try:
        drawn = painter.ask("trial", seconds=_START_SECONDS)
    except Exception:  # whatever it is, this window class draws nothing
        drawn = False
    if not drawn:
        painter.close()
        return None
    atexit.register(painter.close)
    return painter


class Painter:
    """A process that draws with a window class ("": the library's own choice). Raises OSError where it cannot start."""

    def __init__(self, window: str) -> None:
        self._worker = Worker("camgeom.report.painter:Studio", {_CHOICE: window} if window else None)

    @property
    def ended(self) -> bool:
        """Whether the process is gone."""
        return self._worker.ended

    def ask(self, what: str, *arguments: Any, seconds: float = _PICTURE_SECONDS) -> Any:
        """What a method of its Studio gives. Raises what that raises, and ExportError where the process ends."""
        try:
            return self._worker.ask(what, *arguments, seconds=seconds)
        except WorkerEnded as end:
            raise ExportError(f"no picture: the graphics library {end} while it drew") from None

    def close(self) -> None:
        """End the process."""
        self._worker.close()


class _Errors(logging.Handler):
    """What the graphics library calls an error; the picture is not to be trusted then."""

    def __init__(self) -> None:
        super().__init__(logging.ERROR)
        self.first = ""

    def emit(self, record: logging.LogRecord) -> None:
        self.first = self.first or " ".join(record.getMessage().split())[:200]


class Studio:
    """What a Painter asks of its process."""

    def __init__(self) -> None:
        self._stages: dict[int, Stage] = {}
        self._opened = 0
        self._errors = _Errors()
        logging.getLogger().addHandler(self._errors)

    def trial(self) -> bool:
        """Whether a red window comes out red."""
        import vtkmodules.vtkRenderingOpenGL2  # noqa: F401
        from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

        window, renderer = vtkRenderWindow(), vtkRenderer()
        window.SetOffScreenRendering(1)
        window.SetSize(8, 8)
        window.AddRenderer(renderer)
        renderer.SetBackground(1.0, 0.0, 0.0)
        window.Render()
        picture = vtkWindowToImageFilter()
        picture.SetInput(window)
        picture.Update()
        return bool(picture.GetOutput().GetScalarComponentAsDouble(4, 4, 0, 0) == 255.0)

    def open(self, bodies: Sequence[NamedMesh], view: View, reach: Floats | None) -> int:
        self._opened += 1
        self._stages[self._opened] = Stage(bodies, view, reach)
        return self._opened

    def place(self, number: int, name: str, pose: Floats) -> None:
        self._stages[number].place(name, pose)

    def image(self, number: int) -> npt.NDArray[np.uint8]:
        return np.asarray(self._drawn(number))

    def png(self, number: int) -> bytes:
        stream = BytesIO()
        self._drawn(number).save(stream, format="png", optimize=False, compress_level=6)
        return stream.getvalue()

    def _drawn(self, number: int) -> Any:
        picture, said = self._stages[number].image(), self._errors.first
        self._errors.first = ""
        if said:
            raise ExportError(f"no picture: the graphics library says: {said}")
        return picture

    def close(self, number: int) -> None:
        self._stages.pop(number).close()
