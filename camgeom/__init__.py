"""Exact cam geometry, watertight solids, contact stress, fatigue life and dynamics from one profile.

The public names are read, Model, check, write, encode, study, to_build123d, LAWS, law with what a law is made of, and
the errors; each is imported when it is first asked for, so that `import camgeom` costs a millisecond.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from camgeom.version import __version__ as __version__

if TYPE_CHECKING:
    from camgeom.checks import findings as check
    from camgeom.errors import (
        CamgeomError,
        DesignError,
        ExportError,
        GeometryEngineError,
        NotConverged,
        Problem,
        ProfileError,
    )
    from camgeom.motion import LAWS, Claims, Parameter, Piece
    from camgeom.motion.catalogue import law
    from camgeom.report.files import encode, to_build123d, write
    from camgeom.seat import Model, read
    from camgeom.seat.variants import study

__all__ = [
    "LAWS",
    "CamgeomError",
    "Claims",
    "DesignError",
    "ExportError",
    "GeometryEngineError",
    "Model",
    "NotConverged",
    "Parameter",
    "Piece",
    "Problem",
    "ProfileError",
    "check",
    "encode",
    "law",
    "read",
    "study",
    "to_build123d",
    "write",
]

_HOME = {
    "read": "camgeom.seat",
    "Model": "camgeom.seat",
    "check": "camgeom.checks:findings",
    "write": "camgeom.report.files",
    "encode": "camgeom.report.files",
    "to_build123d": "camgeom.report.files",
    "study": "camgeom.seat.variants",
    "LAWS": "camgeom.motion",
    "law": "camgeom.motion.catalogue",
    "Claims": "camgeom.motion",
    "Parameter": "camgeom.motion",
    "Piece": "camgeom.motion",
    "CamgeomError": "camgeom.errors",
    "Problem": "camgeom.errors",
    "ProfileError": "camgeom.errors",
    "DesignError": "camgeom.errors",
    "NotConverged": "camgeom.errors",
    "GeometryEngineError": "camgeom.errors",
    "ExportError": "camgeom.errors",
}
"""Each public name and the module it lives in (module:name where it has another name there)."""


def __getattr__(name: str) -> object:
    """A public name from its module; AttributeError for any other."""
    if name not in _HOME:
        raise AttributeError(f"module 'camgeom' has no attribute {name!r}; it offers {', '.join(_HOME)}")
    module, _, attribute = _HOME[name].partition(":")
    value: object = getattr(import_module(module), attribute or name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
