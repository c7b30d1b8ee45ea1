"""Motion laws and the program round the cam; each name is loaded when it is first asked for.

`camgeom.law` enters a motion law into the catalogue `LAWS` with its `Claims` and `Parameter`s; it returns `Piece`s, and
where it joins moving neighbours it takes their `Ends`. `make` builds a law by name.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camgeom.motion.catalogue import LAWS, make
    from camgeom.motion.law import Claims, Ends, Parameter
    from camgeom.motion.program import Program
    from camgeom.motion.segment import Segment
    from camgeom.motion.table import Piece

__all__ = ["LAWS", "Claims", "Ends", "Parameter", "Piece", "Program", "Segment", "make"]

_HOME = {"Program": "program", "Segment": "segment", "Piece": "table", "LAWS": "catalogue", "make": "catalogue"}


def __getattr__(name: str) -> Any:
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME.get(name, 'law')}"), name)
