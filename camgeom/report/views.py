"""Off-screen pictures of bodies, drawn in software: parallel projection, soft light, dark creases, cut by a plane."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from camgeom.drawing.colours import CUT, FLANK, STEEL, scale, value_range
from camgeom.errors import ExportError, not_installed
from camgeom.export import Body
from camgeom.export.files import atomic_write
from camgeom.maths import Floats
from camgeom.maths.creases import crease_lines, shade
from camgeom.maths.mesh import Ints, Mesh
from camgeom.report.overlay import ColourBar, overlay

_LINE, _HATCH = "#20252b", "#b98a45"

_METAL = {"ambient": 0.30, "diffuse": 0.74, "specular": 0.16, "specular_power": 20.0}
_PAINT = {"ambient": 0.62, "diffuse": 0.42, "specular": 0.0}
_FLAT = {"ambient": 0.75, "diffuse": 0.28, "specular": 0.0}
"""Result colours and cut faces are lit evenly, so that they can be compared with the bar and with each other."""

_FINER = 1.5
"""Drawn this many times larger and scaled down: smooth edges at a third of the cost of the library's own way."""

CAMERAS = {
    "iso": ((0.62, -0.66, 0.42), (0.0, 0.0, 1.0)),
    "back": ((-0.62, 0.66, 0.42), (0.0, 0.0, 1.0)),
    "+x": ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)),
    "-y": ((0.0, -1.0, 0.0), (0.0, 0.0, 1.0)),
    "+z": ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0)),
}
"""Where the eye stands, seen from the part, and which way is up."""

_CUT = "cut"
_HATCHES = 36
"""Hatch lines over the part's length."""

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
    if find_spec("pyvista") is None:
        raise not_installed("a picture", "pyvista", "pictures")
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


@dataclass(frozen=True)
class Plane:
    """A cutting plane through `point` (mm); what lies on the side of `normal` is taken away."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def height(self, points: Floats) -> Floats:
        """Distance of points (n, 3) above the plane, mm, (n,)."""
        normal = np.array(self.normal) / np.linalg.norm(self.normal)
        return np.asarray((points - np.array(self.point)) @ normal)


@dataclass(frozen=True, eq=False)
class Skin:
    """Drawing data of one body.

    points, normals  (n, 3) mm and unit
    values           (n,) of the shown field, or None
    faces, group     (f, 3) and (f,) with the names in `groups`; the cut faces are of the group `cut`
    lines            (e, 2, 3) end points of creases, group borders and section outlines
    hatch            (e, 2, 3) end points of the hatching of the cut faces
    """

    points: Floats
    normals: Floats
    values: Floats | None
    faces: Ints
    group: npt.NDArray[np.uint8]
    groups: tuple[str, ...]
    lines: Floats
    hatch: Floats


def skin(mesh: Mesh, field: str | None = None, plane: Plane | None = None) -> Skin:
    """Drawing data of a mesh: split along its creases, with the field that it may carry, cut where asked.

    A mesh that is cut bounds a body.
    """
    hatch = np.zeros((0, 2, 3))
    if plane is not None:
        mesh, hatch = _cut(mesh, field, plane)
    group = np.zeros(len(mesh.faces), np.uint8) if mesh.group is None else mesh.group
    # The rest of a cut body ends at its section, which its open ends outline.
    rest = np.isin(group, [number for number, name in enumerate(mesh.groups) if name != _CUT])
    lines = crease_lines(Mesh(mesh.vertices, mesh.faces[rest], mesh.groups, group[rest]))
    shaded = shade(mesh)
    values = mesh.fields[field][shaded.source] if field is not None and field in mesh.fields else None
    points = mesh.vertices[shaded.source]
    return Skin(points, shaded.normals, values, shaded.faces, group, mesh.groups, mesh.vertices[lines], hatch)


def _cut(mesh: Mesh, field: str | None, plane: Plane) -> tuple[Mesh, Floats]:
    """What of a body lies below the plane, closed by faces of the group `cut`, and their hatching (e, 2, 3)."""
    import pyvista
    from vtkmodules.vtkFiltersGeneral import vtkContourTriangulator

    up = np.array(plane.normal) / np.linalg.norm(plane.normal)
    where = {"normal": up, "origin": plane.point}
    surface = pyvista.PolyData.from_regular_faces(mesh.vertices, mesh.faces)
    surface.cell_data["group"] = np.zeros(len(mesh.faces), np.uint8) if mesh.group is None else mesh.group
    shown = [name for name in mesh.fields if name == field]
    for name in shown:
        surface.point_data[name] = mesh.fields[name]
    below = surface.clip(**where).triangulate()
    closing = vtkContourTriangulator()
    closing.SetInputData(surface.slice(**where))
    closing.Update()
    cap = pyvista.wrap(closing.GetOutput())
    lids = cap.faces.reshape(-1, 4)[:, 1:]
    a, b, c = (cap.points[lids[:, k]] for k in range(3))
    turned = np.cross(b - a, c - a) @ up < 0.0
    lids = np.where(turned[:, None], lids[:, ::-1], lids) + below.n_points
    blank = np.full(cap.n_points, np.nan)
    cut = Mesh(
        np.concatenate([below.points, cap.points]),
        np.concatenate([below.faces.reshape(-1, 4)[:, 1:], lids]).astype(np.int32),
        (*mesh.groups, _CUT),
        np.concatenate([below.cell_data["group"], np.full(len(lids), len(mesh.groups), np.uint8)]),
        {name: np.concatenate([below.point_data[name], blank]) for name in shown},
    )
    return cut, _hatch(cap, up, float(np.ptp(mesh.vertices, axis=0).max()) / _HATCHES)


def _hatch(cap: Any, up: Floats, spacing: float) -> Floats:
    """Parallel lines (e, 2, 3) at 45 degrees over the faces of a cut, `spacing` mm apart."""
    along = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    along /= np.linalg.norm(along)
    height = cap.points @ (np.cross(up, along) - along) / np.sqrt(2.0)
    levels = spacing * np.arange(np.ceil(height.min(initial=0.0) / spacing), height.max(initial=0.0) / spacing)
    if not len(levels) or not cap.n_cells:
        return np.zeros((0, 2, 3))
    lines = cap.contour(levels, height)
    return np.asarray(lines.points[lines.lines.reshape(-1, 3)[:, 1:]], dtype=float)


@dataclass(frozen=True)
class View:
    """What a picture shows.

    field        name of the result field in colours, on the faces of `field_groups` (all where empty); a face with a
                 vertex where the field is NaN keeps the body's colour
    label, unit  its title at the colour bar
    limits       range of the colours; by default that of the shown values
    diverging    colours that part at zero
    section      cutting plane through the bodies that `section_bodies` names (all where empty)
    camera       a name in CAMERAS or the direction (x, y, z) from the part to the eye, Z up
    size         width and height, pixels
    soft         corners lie in shade (half of the time a picture takes)
    """

    field: str | None = None
    field_groups: tuple[str, ...] = ()
    label: str = ""
    unit: str = ""
    limits: tuple[float, float] | None = None
    diverging: bool = False
    section: Plane | None = None
    section_bodies: tuple[str, ...] = ()
    camera: str | tuple[float, float, float] = "iso"
    size: tuple[int, int] = (1600, 1200)
    soft: bool = True

    def axes(self) -> Floats:
        """Unit vectors (3, 3) to the right, up, and towards the eye."""
        if isinstance(self.camera, str) and self.camera not in CAMERAS:
            raise ExportError(f"no camera {self.camera!r}; there are {', '.join(CAMERAS)}, or a direction (x, y, z)")
        eye, up = CAMERAS[self.camera] if isinstance(self.camera, str) else (self.camera, (0.0, 0.0, 1.0))
        towards = np.array(eye) / np.linalg.norm(eye)
        if np.linalg.norm(np.cross(up, towards)) < 1e-6:
            up = (0.0, 1.0, 0.0)
        right = np.cross(up, towards)
        right /= np.linalg.norm(right)
        return np.array([right, np.cross(towards, right), towards])


def render(bodies: Sequence[Body], path: Path | str, view: View | None = None) -> int:
    """Draw bodies into a PNG file; returns the bytes written.

    A body without a colour is steel with blue flanks; give a roller ROLLER. Raises ExportError where no OpenGL library
    works here (naming the packages), the field or camera is unknown, or the file cannot be written.
    """
    with stage(bodies, view or View()) as scene:
        return scene.save(Path(path))


@contextmanager
def stage(bodies: Sequence[Body], view: View, reach: Floats | None = None) -> Iterator[Stage]:
    """A scene that can be drawn again and again with its bodies in other places; see Stage. Raises as render does.

    reach   points (n, 3), mm, that the picture has to hold; by default the bodies where they are given
    """
    if view.field is not None and not any(view.field in body.mesh.fields for body in bodies):
        raise ExportError(f"no body carries the field {view.field!r}")
    axes = view.axes()
    need_opengl()
    import pyvista

    drawn = [round(_FINER * pixels) for pixels in view.size]
    plotter = pyvista.Plotter(off_screen=True, window_size=drawn, lighting="none")
    try:
        scene = Stage(view, axes, plotter)
        scene.fill(bodies, reach)
        yield scene
    finally:
        plotter.close()


@dataclass(eq=False)
class Stage:
    """A lit scene of bodies. `place` moves a body, `image` and `save` draw what stands there now."""

    view: View
    axes: Floats
    plotter: Any
    actors: dict[str, list[Any]] = field(default_factory=dict)
    bar: ColourBar | None = None
    mm_per_pixel: float = 1.0
    drawn: bool = False

    def place(self, name: str, pose: Floats) -> None:
        """Put the named body where the rigid motion (3, 4) or (4, 4) takes it from its place in the cam frame."""
        matrix = np.eye(4)
        matrix[: len(pose)] = pose
        for actor in self.actors[name]:
            actor.user_matrix = matrix

    def image(self) -> npt.NDArray[np.uint8]:
        """The picture (h, w, 3), with scale bar, axes and colour bar."""
        return np.asarray(self._picture())

    def save(self, path: Path) -> int:
        """Write the picture as PNG; returns the bytes written."""
        picture = self._picture()
        with atomic_write(path) as stream:
            picture.save(stream, format="png", optimize=False, compress_level=6)
            return stream.tell()

    def _picture(self) -> Any:
        self.plotter.reset_camera_clipping_range()
        if self.drawn:  # the first screenshot draws by itself
            self.plotter.render()
        self.drawn = True
        drawn = np.asarray(self.plotter.screenshot(None, return_img=True))[..., :3]
        return overlay(np.ascontiguousarray(drawn), self.view.size, self.mm_per_pixel, self.axes[:2].T, self.bar)

    def fill(self, bodies: Sequence[Body], reach: Floats | None = None) -> None:
        """Add the bodies, light and camera; called once."""
        plotter, view = self.plotter, self.view
        plotter.set_background("white")
        cut = {body.name for body in bodies if not view.section_bodies or body.name in view.section_bodies}
        skins = {b.name: skin(b.mesh, view.field, view.section if b.name in cut else None) for b in bodies}
        self._range(list(skins.values()))
        for body in bodies:
            self._add(body, skins[body.name])
        points = np.concatenate([s.points[np.unique(s.faces)] for s in skins.values()]) if reach is None else reach
        self._aim(points)
        self._light(float(np.ptp(points @ self.axes.T, axis=0).max()))

    def _shown(self, drawn: Skin) -> npt.NDArray[np.bool_]:
        """Mask (f,) of the faces that show the field."""
        if drawn.values is None:
            return np.zeros(len(drawn.faces), dtype=bool)
        wanted = [n for n in drawn.groups if n != "cut" and n in (self.view.field_groups or drawn.groups)]
        known = np.all(np.isfinite(drawn.values[drawn.faces]), axis=1)
        return np.asarray(known & np.isin(drawn.group, [drawn.groups.index(name) for name in wanted]))

    def _range(self, skins: Sequence[Skin]) -> None:
        if self.view.field is None:
            return
        values = [s.values[s.faces[self._shown(s)]].ravel() for s in skins if s.values is not None]
        shown = np.concatenate(values)
        if not len(shown):
            raise ExportError(f"no face of {', '.join(self.view.field_groups)} carries the field {self.view.field!r}")
        low, high = self.view.limits or value_range(shown, self.view.diverging)
        title = ", ".join(part for part in (self.view.label or self.view.field, self.view.unit) if part)
        self.bar = ColourBar(title, low, high, self.view.diverging)

    def _add(self, body: Body, drawn: Skin) -> None:
        """One actor for the field's faces, one for each colour of the others, one for the lines."""
        shown = self._shown(drawn)
        actors = []
        if self.bar is not None and shown.any():
            assert drawn.values is not None
            values = np.nan_to_num(drawn.values, nan=self.bar.low)
            place = np.clip((values - self.bar.low) / (self.bar.high - self.bar.low), 0.0, 1.0)
            colours = scale(self.bar.diverging)[np.rint(255.0 * place).astype(int)]
            actors.append(self._surface(drawn, shown, colours))
        for number, name in enumerate(drawn.groups):
            colour = body.colour or (FLANK if name.startswith("flank") and self.bar is None else STEEL)
            chosen = (drawn.group == number) & ~shown
            if chosen.any():
                actors.append(self._surface(drawn, chosen, CUT if name == "cut" else colour))
        for lines, tone, width in ((drawn.hatch, _HATCH, 0.9), (drawn.lines, _LINE, 1.5)):
            if len(lines):
                actors.append(self._lines(lines, tone, width))
        self.actors[body.name] = actors

    def _surface(self, drawn: Skin, chosen: npt.NDArray[np.bool_], colour: Any) -> Any:
        import pyvista

        used, faces = np.unique(drawn.faces[chosen], return_inverse=True)
        data = pyvista.PolyData.from_regular_faces(drawn.points[used], faces.reshape(-1, 3))
        data.point_data["Normals"] = drawn.normals[used].astype(np.float32)
        data.point_data.active_normals_name = "Normals"
        if isinstance(colour, tuple):
            look = _FLAT if colour == CUT else _METAL
            return self.plotter.add_mesh(data, color=colour, smooth_shading=True, **look)
        data.point_data["colours"] = colour[used]
        return self.plotter.add_mesh(data, scalars="colours", rgb=True, smooth_shading=True, **_PAINT)

    def _lines(self, lines: Floats, colour: str, width: float) -> Any:
        import pyvista

        ends = np.arange(2 * len(lines)).reshape(-1, 2)
        data = pyvista.PolyData(lines.reshape(-1, 3), lines=np.insert(ends, 0, 2, axis=1).ravel())
        width = max(width * _FINER * self.view.size[1] / 1000.0, 2.0)  # a thinner one breaks into dashes
        actor = self.plotter.add_mesh(data, color=colour, line_width=width, lighting=False)
        # Towards the eye by a hair, so that the faces beside a line do not eat half of it.
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -2.0)
        return actor

    def _aim(self, points: Floats) -> None:
        """Parallel projection that shows all points, with room for the bars."""
        width, height = self.view.size
        seen = points @ self.axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        free = np.array([1.0 - (0.16 if self.bar is not None else 0.06), 1.0 - 0.13]) * (width, height)
        self.mm_per_pixel = float(np.max((high - low)[:2] / (0.97 * free)))
        middle = 0.5 * (low + high)
        middle[0] += self.mm_per_pixel * (0.05 * width if self.bar is not None else 0.0)
        middle[1] -= self.mm_per_pixel * 0.035 * height
        focus = middle @ self.axes
        camera = self.plotter.camera
        camera.parallel_projection = True
        camera.focal_point = focus
        camera.position = focus + 4.0 * float(np.ptp(seen, axis=0).max()) * self.axes[2]
        camera.up = self.axes[1]
        camera.parallel_scale = 0.5 * self.mm_per_pixel * height

    def _light(self, size: float) -> None:
        """A key light from the upper left, weaker ones from the eye and from the right; corners lie in shade.

        Seen from below, the key light comes from below too.
        """
        import pyvista

        high = 0.6 if self.axes[2, 2] > -0.1 else -0.6
        for right, up, towards, strength in ((-0.55, high, 0.8, 0.62), (0.0, 0.0, 1.0, 0.50), (0.95, 0.1, 0.4, 0.20)):
            light = pyvista.Light(light_type="scene light", intensity=strength)
            light.positional = False
            light.focal_point = (0.0, 0.0, 0.0)
            light.position = tuple(np.array([right, up, towards]) @ self.axes)
            self.plotter.add_light(light)
        if self.view.soft:
            self.plotter.enable_ssao(radius=0.12 * size, bias=0.012 * size, kernel_size=24, blur=True)
