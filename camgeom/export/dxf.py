"""Flat drawings for CAD and wire or laser cutting: AutoCAD DXF R2010, in mm, by ezdxf.

Every curve stands there twice: as one clamped cubic spline, C1 throughout, on a layer `..._SPLINE`, and as a polyline
of exact points on a layer `..._POLYLINE`. Their measured distances from the exact curve stand in the notes of the
drawing, and with the curve's name in the entity's extended data (application CAMGEOM). The entities of one view share
its origin; views after the first stand above it, at an origin that their notes give.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.errors import CamgeomError, ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.export.flat import PlaneView, plane_views
from camgeom.maths import Floats
from camgeom.maths.curves import Polyline, Spline, chords, fitted

if TYPE_CHECKING:
    from camgeom.model import Model


DEVIATION = 1e-4
"""mm, allowed between a spline and the exact curve"""
APPLICATION = "CAMGEOM"
COLOURS = {
    "PROFILE": 7, "PITCH": 5, "CUTTER": 1, "FLANK": 7, "CENTRE_LINE": 5, "BLANK": 8, "BORE": 3, "CENTRE": 4,
    "TURRET": 6, "ROLLERS": 2, "MARK": 3, "NOTES": 9,
}  # fmt: skip
"""AutoCAD colour index by layer (the part before _SPLINE or _POLYLINE)"""
LINES = {"PITCH": "CENTER", "CUTTER": "DASHED", "CENTRE_LINE": "CENTER", "CENTRE": "CENTER", "BLANK": "CONTINUOUS"}
DEVELOPED = {"profile": "FLANK", "pitch": "CENTRE_LINE"}
GAP = 0.15
"""of a view's height, left free between views"""


@writer(".dxf", "profiles, pitch and cutter curves, developed grooves, turret: splines and polylines", takes="model")
def write_dxf(path: Path, model: Model, deviation: float = DEVIATION, chord: float | None = None) -> int:
    """Write the flat views of a cam; returns the bytes written.

    deviation  mm, of the splines; chord: mm, of the polylines (default: the model's tolerance). What was reached is
               measured and stands in the file. A tool's diameter in the profile's [cutter] adds its path.
    Raises ExportError for a cam with nothing flat to draw, where a flank is undercut, or the file cannot be written.
    """
    import ezdxf

    cutter = getattr(model.profile.cutter_spec, "diameter", None)
    try:
        model.refuse_folded()
        views = plane_views(model, 0.5 * cutter if cutter else None)
        if not views:
            raise ExportError(f"{path}: a cam of kind {model.profile.kind} has no flat view")
        drawn = [_Drawn.of(view, deviation, chord if chord is not None else model.tolerance) for view in views]
    except ExportError:
        raise
    except CamgeomError as error:
        raise ExportError(f"{path}: cannot be drawn: {error}") from error
    document: Any = ezdxf.new("R2010", setup=["linetypes"])
    document.units = 4  # mm
    document.header["$MEASUREMENT"] = 1
    document.header.custom_vars.append("Design", model.profile.name)
    document.appids.add(APPLICATION)
    _place(document, drawn)
    text = StringIO()
    document.write(text)
    with atomic_write(path) as stream:
        stream.write(text.getvalue().encode("utf-8", "surrogateescape"))
        return stream.tell()


@final
@dataclass(frozen=True, eq=False)
class _Drawn:
    """A view with its curves made: name, layer prefix, spline and polyline of each."""

    view: PlaneView
    curves: list[tuple[str, str, bool, Spline, Polyline]] = field(default_factory=list)

    @classmethod
    def of(cls, view: PlaneView, deviation: float, chord: float) -> _Drawn:
        drawn = cls(view)
        for curve in view.curves:
            prefix = DEVELOPED.get(curve.role, "") if view.name.startswith("developed") else curve.role.upper()
            made = fitted(curve, deviation), chords(curve, chord)
            drawn.curves.append((curve.name, prefix, curve.closed, *made))
        return drawn

    @property
    def bounds(self) -> tuple[Floats, Floats]:
        """Low and high corner of everything drawn, mm."""
        points = [line.points for *_, line in self.curves]
        points += [np.array(stroke.points) for stroke in self.view.strokes]
        points += [np.add(disc.centre, np.array([[-1.0], [1.0]]) * disc.radius) for disc in self.view.discs]
        every = np.concatenate(points)
        return every.min(axis=0), every.max(axis=0)

    def notes(self, origin: Floats) -> str:
        """What the drawing says about the view."""
        lines = [*self.view.notes, f"origin of this view at ({origin[0]:.9g}, {origin[1]:.9g}) mm"]
        for name, _, _, spline, line in self.curves:
            # Rounded upwards: what is stated holds.
            lines.append(
                f"{name}: spline within {_up(spline.deviation)} mm, polyline within {_up(line.chord_error)} mm"
            )
        return "\\P".join(lines)


def _up(value: float) -> str:
    return f"{1.005 * value + 1e-12:.3g}"


def _place(document: Any, drawn: list[_Drawn]) -> None:
    """The views one above the other, and the window that shows them all."""
    space = document.modelspace()
    base: float | None = None
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for one in drawn:
        bottom, top = one.bounds
        size = 1.0 + float((top - bottom).max())
        origin = np.zeros(2) if base is None else np.array([0.0, base - bottom[1]])
        _draw(document, space, one, origin, 0.012 * size)
        low, high = np.minimum(low, bottom + origin), np.maximum(high, top + origin)
        base = float(high[1]) + GAP * size
    middle = 0.5 * (low + high)
    document.set_modelspace_vport(height=1.2 * float((high - low).max()), center=tuple(middle.tolist()))


def _layer(document: Any, name: str) -> dict[str, str]:
    """Attributes of an entity on a layer, which is made when it is first used."""
    if name not in document.layers:
        prefix = name.removesuffix("_SPLINE").removesuffix("_POLYLINE")
        document.layers.add(name, color=COLOURS[prefix], linetype=LINES.get(prefix, "CONTINUOUS"))
    return {"layer": name}


def _draw(document: Any, space: Any, one: _Drawn, origin: Floats, height: float) -> None:
    for name, prefix, closed, spline, line in one.curves:
        entity = space.add_spline(degree=3, dxfattribs=_layer(document, f"{prefix}_SPLINE"))
        entity.control_points = np.column_stack([spline.control + origin, np.zeros(len(spline.control))])
        entity.knots = spline.knots
        entity.set_xdata(APPLICATION, [(1000, name), (1040, spline.deviation)])
        points = (line.points + origin).tolist()
        entity = space.add_lwpolyline(points, close=closed, dxfattribs=_layer(document, f"{prefix}_POLYLINE"))
        entity.set_xdata(APPLICATION, [(1000, name), (1040, line.chord_error)])
    for disc in one.view.discs:
        place = tuple((np.array(disc.centre) + origin).tolist())
        space.add_circle(place, disc.radius, dxfattribs=_layer(document, disc.layer.upper()))
    for stroke in one.view.strokes:
        bulges = stroke.bulges or (0.0,) * len(stroke.points)
        corners = [(x + origin[0], y + origin[1], b) for (x, y), b in zip(stroke.points, bulges)]
        attributes = _layer(document, stroke.layer.upper())
        space.add_lwpolyline(corners, format="xyb", close=stroke.closed, dxfattribs=attributes)
    notes = _layer(document, "NOTES")
    for label in one.view.labels:
        at = tuple((np.array(label.at) + origin).tolist())
        space.add_text(label.text, height=height, dxfattribs=notes).set_placement(at)
    high = one.bounds[1]
    text = space.add_mtext(one.notes(origin), dxfattribs={**notes, "char_height": height})
    text.set_location((float(high[0]) + origin[0] + 3.0 * height, float(high[1]) + origin[1]))
