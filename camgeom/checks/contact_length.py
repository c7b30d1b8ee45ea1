"""Does the roller of a drum reach its flank all the way round?"""

from __future__ import annotations

from collections.abc import Iterable
from math import degrees
from typing import TYPE_CHECKING

import numpy as np

from camgeom.checks import Finding, check

if TYPE_CHECKING:
    from camgeom.model import Model

PER_TURN = 720


@check("contact-length", "tracks")
def contact_length(model: Model) -> Iterable[Finding]:
    """Least length of flank beside the contact stretch of a drum's roller; swinging rollers can leave the drum."""
    from camgeom.maths.extremum import piece_grid

    lengths = getattr(model.cam, "contact_lengths", None)
    if lengths is None:
        return
    for track in model.tracks:
        phi, _ = piece_grid(track.knots(), PER_TURN)
        found = lengths(track, phi)
        least = int(np.argmin(found))
        value, angle = float(found[least]), degrees(float(phi[least])) % 360.0
        advice = "" if value > 0.0 else (
            "the roller leaves the drum sideways and touches nothing there: a longer arm, less swing, a pivot distance "
            "that centres the arc, or a larger drum"
        )
        yield Finding("contact-length", value, 0.0, "mm", value > 0.0, angle, advice, track.name)
