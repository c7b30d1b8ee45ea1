"""Motion laws and the program round the cam. `LAWS` and `make` are loaded when first asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from camgeom.motion.laws import LAWS, make
    from camgeom.motion.program import Program, Segment

__all__ = ["LAWS", "Program", "Segment", "make"]


def __getattr__(name: str) -> Any:
    if name in ("LAWS", "make"):
        from camgeom.motion import laws

        return getattr(laws, name)
    if name in ("Program", "Segment"):
        from camgeom.motion import program

        return getattr(program, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
