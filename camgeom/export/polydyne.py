"""Polydyne motion of an elastic follower: the cam lift whose response at the operating speed is the wanted motion."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from camgeom.errors import ExportError
from camgeom.export import writer
from camgeom.export.files import atomic_write
from camgeom.maths.extremum import piece_grid

if TYPE_CHECKING:
    from camgeom.model import Model

PER_TURN = 3600


@writer(
    ".polydyne.csv", "cam lift over the cam angle for an elastic follower (polydyne), CSV", takes="model",
    cams="followers with a linkage_stiffness in [dynamics]",
)
def write_polydyne_csv(path: Path, model: Model) -> int:
    """Write cam angle (deg) and cam lift (mm, deg of a swinging follower), one heading line; returns the bytes written.

    Raises ExportError for a profile without an elastic follower; ProfileError where the motion is not smooth enough for
    the correction.
    """
    study = model.elastic_follower
    if study is None:
        raise ExportError(f"{path}: only an elastic follower in [dynamics] has a polydyne motion")
    motion = study.corrected
    phi, _ = piece_grid(motion.knots, PER_TURN)
    phi = np.unique(phi)
    lift = motion.jet(phi, 0)[0] * (180.0 / np.pi if model.profile.rotating else 1.0)
    unit = "deg" if model.profile.rotating else "mm"
    with atomic_write(path) as stream:
        stream.write(f"cam_angle_deg,cam_lift_{unit}\n".encode())
        rows = np.stack([np.degrees(phi), lift], axis=1).tolist()
        stream.write("".join(f"{angle!r},{value!r}\n" for angle, value in rows).encode())
        return stream.tell()
