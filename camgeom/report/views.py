"""Off-screen pictures of bodies, drawn in software: parallel projection, soft light, dark creases, cut by a plane."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from camgeom.drawing.colours import CUT, FLANK, STEEL, scale, value_range
from camgeom.errors import ExportError
from camgeom.export import NamedMesh
from camgeom.immutable import immutable
from camgeom.maths import Floats, distinct
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


@immutable(eq=True)
class CuttingPlane:
    """A cutting plane through `point` (mm); what lies on the side of `normal` is taken away."""

    point: tuple[float, float, float]
    normal: tuple[float, float, float]

    def height(self, points: Floats) -> Floats:
        """Distance of points (n, 3) above the plane, mm, (n,)."""
        normal = np.array(self.normal) / np.linalg.norm(self.normal)
        return np.asarray((points - np.array(self.point)) @ normal)


@immutable
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


def skin(mesh: Mesh, field: str | None = None, plane: CuttingPlane | None = None) -> Skin:
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


def _cut(mesh: Mesh, field: str | None, plane: CuttingPlane) -> tuple[Mesh, Floats]:
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


@immutable(eq=True)
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
    section: CuttingPlane | None = None
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


class Stage:
    """A lit scene of bodies: `place` moves one, `image` draws what stands there now, `close` gives the memory back.

    Belongs into a process that may draw: the graphics library ends it where it fails. See report/painter.py.

    reach   points (n, 3), mm, that the picture has to hold; by default the bodies where they are given
    """

    def __init__(self, bodies: Sequence[NamedMesh], view: View, reach: Floats | None = None) -> None:
        import pyvista

        self._view, self._axes = view, view.axes()
        self._actors: dict[str, list[Any]] = {}
        self._bar: ColourBar | None = None
        self._mm_per_pixel = 1.0
        self._drawn = False
        drawn = [round(_FINER * pixels) for pixels in view.size]
        self._plotter = pyvista.Plotter(off_screen=True, window_size=drawn, lighting="none")
        self._fill(bodies, reach)

    def close(self) -> None:
        """Give up the window."""
        self._plotter.close()

    def place(self, name: str, pose: Floats) -> None:
        """Put the named body where the rigid motion (3, 4) or (4, 4) takes it from its place in the cam frame."""
        matrix = np.eye(4)
        matrix[: len(pose)] = pose
        for actor in self._actors[name]:
            actor.user_matrix = matrix

    def image(self) -> Any:
        """The picture (PIL), with scale bar, axes and colour bar."""
        self._plotter.reset_camera_clipping_range()
        if self._drawn:  # the first screenshot draws by itself
            self._plotter.render()
        self._drawn = True
        drawn = np.asarray(self._plotter.screenshot(None, return_img=True))[..., :3]
        return overlay(np.ascontiguousarray(drawn), self._view.size, self._mm_per_pixel, self._axes[:2].T, self._bar)

    def _fill(self, bodies: Sequence[NamedMesh], reach: Floats | None) -> None:
        """Add the bodies, light and camera."""
        view = self._view
        self._plotter.set_background("white")
        cut = {body.name for body in bodies if not view.section_bodies or body.name in view.section_bodies}
        skins = {b.name: skin(b.mesh, view.field, view.section if b.name in cut else None) for b in bodies}
        self._range(list(skins.values()))
        for body in bodies:
            self._add(body, skins[body.name])
        points = np.concatenate([s.points[distinct(s.faces)] for s in skins.values()]) if reach is None else reach
        self._aim(points)
        self._light(float(np.ptp(points @ self._axes.T, axis=0).max()))

    def _shown(self, drawn: Skin) -> npt.NDArray[np.bool_]:
        """Mask (f,) of the faces that show the field."""
        if drawn.values is None:
            return np.zeros(len(drawn.faces), dtype=bool)
        wanted = [n for n in drawn.groups if n != "cut" and n in (self._view.field_groups or drawn.groups)]
        known = np.all(np.isfinite(drawn.values[drawn.faces]), axis=1)
        return np.asarray(known & np.isin(drawn.group, [drawn.groups.index(name) for name in wanted]))

    def _range(self, skins: Sequence[Skin]) -> None:
        if self._view.field is None:
            return
        values = [s.values[s.faces[self._shown(s)]].ravel() for s in skins if s.values is not None]
        shown = np.concatenate(values)
        if not len(shown):
            raise ExportError(f"no face of {', '.join(self._view.field_groups)} carries the field {self._view.field!r}")
        low, high = self._view.limits or value_range(shown, self._view.diverging)
        title = ", ".join(part for part in (self._view.label or self._view.field, self._view.unit) if part)
        self._bar = ColourBar(title, low, high, self._view.diverging)

    def _add(self, body: NamedMesh, drawn: Skin) -> None:
        """One actor for the field's faces, one for each colour of the others, one for the lines."""
        shown = self._shown(drawn)
        actors = []
        if self._bar is not None and shown.any():
            assert drawn.values is not None
            values = np.nan_to_num(drawn.values, nan=self._bar.low)
            place = np.clip((values - self._bar.low) / (self._bar.high - self._bar.low), 0.0, 1.0)
            colours = scale(self._bar.diverging)[np.rint(255.0 * place).astype(int)]
            actors.append(self._surface(drawn, shown, colours))
        for number, name in enumerate(drawn.groups):
            colour = body.colour or (FLANK if name.startswith("flank") and self._bar is None else STEEL)
            chosen = (drawn.group == number) & ~shown
            if chosen.any():
                actors.append(self._surface(drawn, chosen, CUT if name == "cut" else colour))
        for lines, tone, width in ((drawn.hatch, _HATCH, 0.9), (drawn.lines, _LINE, 1.5)):
            if len(lines):
                actors.append(self._lines(lines, tone, width))
        self._actors[body.name] = actors

    def _surface(self, drawn: Skin, chosen: npt.NDArray[np.bool_], colour: Any) -> Any:
        import pyvista

        used, faces = np.unique(drawn.faces[chosen], return_inverse=True)
        data = pyvista.PolyData.from_regular_faces(drawn.points[used], faces.reshape(-1, 3))
        data.point_data["Normals"] = drawn.normals[used].astype(np.float32)
        data.point_data.active_normals_name = "Normals"
        if isinstance(colour, tuple):
            look = _FLAT if colour == CUT else _METAL
            return self._plotter.add_mesh(data, color=colour, smooth_shading=True, **look)
        data.point_data["colours"] = colour[used]
        return self._plotter.add_mesh(data, scalars="colours", rgb=True, smooth_shading=True, **_PAINT)

    def _lines(self, lines: Floats, colour: str, width: float) -> Any:
        import pyvista

        ends = np.arange(2 * len(lines)).reshape(-1, 2)
        data = pyvista.PolyData(lines.reshape(-1, 3), lines=np.insert(ends, 0, 2, axis=1).ravel())
        width = max(width * _FINER * self._view.size[1] / 1000.0, 2.0)  # a thinner one breaks into dashes
        actor = self._plotter.add_mesh(data, color=colour, line_width=width, lighting=False)
        # Towards the eye by a hair, so that the faces beside a line do not eat half of it.
        actor.mapper.SetResolveCoincidentTopologyToPolygonOffset()
        actor.mapper.SetRelativeCoincidentTopologyLineOffsetParameters(-2.0, -2.0)
        return actor

    def _aim(self, points: Floats) -> None:
        """Parallel projection that shows all points, with room for the bars."""
        width, height = self._view.size
        seen = points @ self._axes.T
        low, high = seen.min(axis=0), seen.max(axis=0)
        free = np.array([1.0 - (0.16 if self._bar is not None else 0.06), 1.0 - 0.13]) * (width, height)
        self._mm_per_pixel = float(np.max((high - low)[:2] / (0.97 * free)))
        middle = 0.5 * (low + high)
        middle[0] += self._mm_per_pixel * (0.05 * width if self._bar is not None else 0.0)
        middle[1] -= self._mm_per_pixel * 0.035 * height
        focus = middle @ self._axes
        camera = self._plotter.camera
        camera.parallel_projection = True
        camera.focal_point = focus
        camera.position = focus + 4.0 * float(np.ptp(seen, axis=0).max()) * self._axes[2]
        camera.up = self._axes[1]
        camera.parallel_scale = 0.5 * self._mm_per_pixel * height

    def _light(self, size: float) -> None:
        """A key light from the upper left, weaker ones from the eye and from the right; corners lie in shade.

        Seen from below, the key light comes from below too.
        """
        import pyvista

        high = 0.6 if self._axes[2, 2] > -0.1 else -0.6
        for right, up, towards, strength in ((-0.55, high, 0.8, 0.62), (0.0, 0.0, 1.0, 0.50), (0.95, 0.1, 0.4, 0.20)):
            light = pyvista.Light(light_type="scene light", intensity=strength)
            light.positional = False
            light.focal_point = (0.0, 0.0, 0.0)
            light.position = tuple(np.array([right, up, towards]) @ self._axes)
            self._plotter.add_light(light)
        if self._view.soft:
            self._plotter.enable_ssao(radius=0.12 * size, bias=0.012 * size, kernel_size=24, blur=True)
