"""Where a designer sits: models in programs and notebooks, studies as arrays, and the page that answers while you drag.

What `camgeom.read` and `camgeom.Model` give is made here, so that a model shows itself with its verdict and picture.
"""

from __future__ import annotations

from camgeom.model import PAINTERS, TELLERS, Model, read
from camgeom.seat.notebook import painted, told

__all__ = ["Model", "read"]

if told not in TELLERS:
    TELLERS.append(told)
    PAINTERS.append(painted)
