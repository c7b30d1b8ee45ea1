"""The 3D view of a report page as frozen data: bodies, how they move, and the results that colour them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, final

from camgeom.drawing.content_plot import Axis
from camgeom.maths import Floats
from camgeom.maths.mesh import Mesh


@final
@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One rigid body of a scene: its mesh at pose identity, and poses (n, 3, 4) [R | t] in the machine frame at the
    scene's cam angles; None for a body that stands still. `fields` are results on its vertices, (v,), by the key of a
    shade; NaN where a vertex has none."""

    name: str
    mesh: Mesh
    poses: Floats | None = None
    role: Literal["cam", "follower", "frame"] = "cam"
    fields: Mapping[str, Floats] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if any(values.shape != (len(self.mesh.vertices),) for values in self.fields.values()):
            raise ValueError(f"body {self.name!r}: a field does not fit its {len(self.mesh.vertices)} vertices")


@final
@dataclass(frozen=True, slots=True)
class Shade:
    """How a field of the bodies is shown: its key, label, unit, and whether it is signed about zero.

    Only faces of the named groups take the colour; all that have values at every corner where none is named.
    """

    key: str
    label: str
    unit: str = ""
    diverging: bool = False
    groups: tuple[str, ...] = ()


@final
@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """An interactive 3D view of bodies over one cam turn. `readouts` (n,) run beside the slider: lift, pressure."""

    caption: str
    angles: Floats
    """(n,) cam angles, degrees, rising from the first to the last frame"""
    bodies: tuple[Body, ...]
    shades: tuple[Shade, ...] = ()
    readouts: tuple[tuple[Axis, Floats], ...] = ()
    speed: float = 60.0
    """r/min of the real cam, stated beside the animation's slow-motion factor"""

    def __post_init__(self) -> None:
        for body in self.bodies:
            if body.poses is not None and body.poses.shape != (len(self.angles), 3, 4):
                raise ValueError(f"body {body.name!r}: poses {body.poses.shape} do not fit {len(self.angles)} angles")
