"""Writers of files, found by extension.

One format, or one family of them, is one file here. A writer is a function decorated with @writer: it takes the path
and the bodies (or what `takes` says), writes through `atomic_write` and returns the number of bytes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, TypeVar

from camgeom.errors import ExportError, did_you_mean
from camgeom.immutable import immutable
from camgeom.maths.mesh import Mesh

if TYPE_CHECKING:
    from camgeom.model import Model

NO_ROLLERS = "the follower has no rollers to place beside the cam, and no frame that is a part"
NO_PLATE = "the follower is no frame with a plate: give follower.plate_length, plate_width and face_width"
Colour = tuple[float, float, float]
"""Red, green, blue, each 0 to 1 (sRGB)."""
_Function = TypeVar("_Function", bound=Callable[..., int])


@immutable
class NamedMesh:
    """One named solid of a file: its mesh in mm in the cam frame, and a colour (sRGB, 0 to 1) or None."""

    name: str
    mesh: Mesh
    colour: Colour | None = None


@immutable(eq=True)
class Format:
    """One way to write a file.

    extension  with its dot, `.stl`; a compound one (`.points.ply`) wins over its last part
    takes      what the writer is given after the path: "bodies" (a sequence of Body), or an attribute of Model such as
               "flanks", or "model" itself
    about      one line for lists and help
    cams       which cams it is for
    write      (path, what it takes) -> bytes written
    missing    why a model's cam has no such file, empty where it may have one; known before anything is computed
    body       whether it says something of a body, so that there is none where the design admits no body
    """

    extension: str
    takes: str
    about: str
    write: Callable[..., int]
    cams: str = "every cam"
    missing: Callable[[Model], str] = lambda model: ""
    body: bool = True


_FORMATS: dict[str, Format] = {}


def writer(
    extension: str,
    about: str,
    takes: str = "bodies",
    cams: str = "every cam",
    missing: Callable[[Model], str] = lambda model: "",
    body: bool = True,
) -> Callable[[_Function], _Function]:
    """Register a function as the writer of an extension; the registry finds it by the file it stands in."""

    def register(function: _Function) -> _Function:
        other = _FORMATS.get(extension)
        if other and other.write.__module__ != function.__module__:
            raise ValueError(f"{extension} has two writers: {other.write.__module__} and {function.__module__}")
        _FORMATS[extension] = Format(extension, takes, about, function, cams, missing, body)
        return function

    return register


@cache
def _discover() -> None:
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")


def formats() -> dict[str, Format]:
    """Every format by extension, sorted."""
    _discover()
    return dict(sorted(_FORMATS.items()))


def format_of(path: Path | str, takes: str | None = None, extra: Mapping[str, Format] | None = None) -> Format:
    """The format a file name (or a bare one, `3mf`, `points.csv`) asks for, the longest matching extension first.

    `takes` limits the choice to the formats that are written from that; `extra` adds formats. Raises ExportError with
    the formats there are and the nearest spelling.
    """
    name = f".{Path(path).name.lower()}"
    every = sorted((formats() | dict(extra or {})).items())
    offered = {ext: form for ext, form in every if takes is None or form.takes == takes}
    matching = [ext for ext in offered if name.endswith(ext)]
    if matching:
        return offered[max(matching, key=len)]
    suffix = name[name.rindex(".") :]
    hint = did_you_mean(suffix, offered)
    raise ExportError(f"{path}: no writer for {suffix}{hint and '; ' + hint} (there are {', '.join(offered)})")


def as_bodies(
    solid: Mesh | NamedMesh | Sequence[NamedMesh | tuple[str, Mesh]], name: str = "cam"
) -> tuple[NamedMesh, ...]:
    """A mesh, a body or a sequence of bodies or (name, mesh) pairs as bodies; ExportError where one is empty."""
    if isinstance(solid, Mesh):
        return as_bodies([NamedMesh(name, solid)])
    if isinstance(solid, NamedMesh):
        return as_bodies([solid])
    bodies = tuple(item if isinstance(item, NamedMesh) else NamedMesh(item[0], item[1]) for item in solid)
    if not bodies:
        raise ExportError("nothing to write: no body given")
    for body in bodies:
        if len(body.mesh.faces) == 0:
            raise ExportError(f"nothing to write: body {body.name!r} has no faces")
    return bodies


def common_fields(path: Path, bodies: Sequence[NamedMesh]) -> tuple[str, ...]:
    """Names of the bodies' result fields, for a format with one table of vertices; ExportError where they differ."""
    names = tuple(bodies[0].mesh.fields)
    for body in bodies:
        if set(body.mesh.fields) != set(names):
            raise ExportError(f"{path}: the bodies {bodies[0].name!r} and {body.name!r} carry different fields")
    return names


def write_mesh(
    solid: Mesh | NamedMesh | Sequence[NamedMesh | tuple[str, Mesh]], path: Path | str, *, name: str = "cam",
    **options: Any,
) -> int:
    """Write a mesh or several bodies to a file, the format by extension; returns the bytes written.

    `options` go to the writer. Raises ExportError where the extension is unknown, there is nothing to write, or the
    file cannot be written; an earlier file then stands.
    """
    return format_of(path, takes="bodies").write(Path(path), as_bodies(solid, name), **options)


def write(model: Model, path: Path | str, **options: Any) -> int:
    """Write a model to a file, the format by extension; returns the bytes written.

    Formats of triangles get `model.workpieces`, the others the model itself or the attribute that the format names.
    `options` and errors as in `write_mesh`; what computing the solid raises passes through.
    """
    form = format_of(path)
    if form.takes == "bodies":
        if form.extension == ".stl":
            # Of all formats of triangles it alone may be coarser than the mesh.
            options = {"tolerance": model.tolerance, **options}
        return write_mesh([NamedMesh(solid.name, solid.mesh) for solid, _ in model.workpieces], path, **options)
    return form.write(Path(path), model if form.takes == "model" else getattr(model, form.takes), **options)
