"""Whether pictures can be drawn here. Without an OpenGL library the process that draws dies, so a child tries."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

from camgeom.errors import ExportError

_CHOICE = "VTK_DEFAULT_OPENGL_WINDOW"
_SECONDS = 60
_TRIAL = """
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter
import vtkmodules.vtkRenderingOpenGL2
window, renderer = vtkRenderWindow(), vtkRenderer()
window.SetOffScreenRendering(1)
window.SetSize(8, 8)
window.AddRenderer(renderer)
renderer.SetBackground(1.0, 0.0, 0.0)
window.Render()
picture = vtkWindowToImageFilter()
picture.SetInput(window)
picture.Update()
assert picture.GetOutput().GetScalarComponentAsDouble(4, 4, 0, 0) == 255.0
print("drawn", flush=True)
import os
os._exit(0)
"""


@cache
def opengl_window() -> str | None:
    """Name of the window class that draws off-screen here ("" for the library's own choice), None where none does.

    Each candidate is tried in a child process, because the failure is a crash and no exception: the one that the
    environment variable VTK_DEFAULT_OPENGL_WINDOW names, else EGL, then the display if there is one, then OSMesa.
    The answer holds for the process.
    """
    named = os.environ.get(_CHOICE)
    if named is not None:
        candidates = [named]
    else:
        candidates = ["vtkEGLRenderWindow", *([""] if os.environ.get("DISPLAY") else []), "vtkOSOpenGLRenderWindow"]
    return next((window for window in candidates if _draws(window)), None)


def need_opengl() -> None:
    """Make ready to draw: set the window class for this process. Raises ExportError where nothing draws here.

    To be called before the first picture of the process.
    """
    window = opengl_window()
    if window is None:
        raise ExportError(
            "no picture can be drawn: no OpenGL library works here; on Debian or Ubuntu, as root: "
            "apt-get install libegl1 libgl1-mesa-dri"
        )
    if window:
        os.environ[_CHOICE] = window


def _draws(window: str) -> bool:
    environment = {**os.environ, _CHOICE: window} if window else dict(os.environ)
    try:
        trial = subprocess.run(
            [sys.executable, "-c", _TRIAL], env=environment, capture_output=True, timeout=_SECONDS, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return trial.returncode == 0 and trial.stdout.strip() == b"drawn"
