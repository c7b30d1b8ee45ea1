"""Does the roller of a drum reach its flank all the way round?"""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.maths import Floats
    from camgeom.model import Model
    from camgeom.track import Track
    from camgeom.track.section import Level

PER_TURN = 720


@check("contact-length", "tracks")
def contact_length(model: Model) -> Iterable[Finding]:
    """Least length of flank beside the contact stretch of a drum's roller; swinging rollers can leave the drum."""
    from camgeom.maths.extremum import piece_grid

    top = model.mechanism.wall_top
    if top is None:
        return
    for track in model.tracks:
        phi, _ = piece_grid(track.knots(), PER_TURN)
        found = _lengths(track, phi, *top)
        least = int(np.argmin(found))
        value, angle = float(found[least]), degrees(float(phi[least])) % 360.0
        advice = "" if value > 0.0 else (
            "the roller leaves the drum sideways and touches nothing there: a longer arm, less swing, a pivot distance "
            "that centres the arc, or a larger drum"
        )
        yield Finding("contact-length", value, 0.0, "mm", value > 0.0, angle, advice, track.name)


def _lengths(track: Track, phi: Floats, top: Level, near: float) -> Floats:
    """Length of flank beside a roller's contact stretch at cam angles (n,), mm; not positive: none."""
    from camgeom.track.section import Column

    low, high = sorted(track.contact)
    column = Column(track, phi)
    ends = [column.reach(side, top, near)[:, 0] for side in track.sides]
    return np.asarray(np.min([np.minimum(track.meridian.jet(end)[0], high) - low for end in ends], axis=0))
