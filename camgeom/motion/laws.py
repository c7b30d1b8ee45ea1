"""The catalogue of motion laws: importing this module fills `LAWS`; `make` builds one by name."""

from __future__ import annotations

from camgeom.errors import Problem, ProfileError
from camgeom.motion import laws_basic, laws_blocks, laws_joining
from camgeom.motion.curve import Law, ParamValue
from camgeom.motion.law import LAWS, LawEntry
from camgeom.spelling import did_you_mean

__all__ = ["LAWS", "entry", "laws_basic", "laws_blocks", "laws_joining", "make", "unknown_law"]


def unknown_law(name: str, key: str) -> Problem:
    """What to say of a law that is not in the catalogue, with the nearest spelling."""
    return Problem(key, "no motion law of this name", name, "a name from `camgeom laws`", did_you_mean(name, LAWS))


def entry(name: str) -> LawEntry:
    """The catalogue entry of a law; raises ProfileError with the nearest spelling."""
    if name not in LAWS:
        raise ProfileError([unknown_law(name, "law")])
    return LAWS[name]


def make(name: str, /, **params: ParamValue) -> Law:
    """The normalised motion law of this name, dimensionless; raises ProfileError naming the law or each parameter.

    >>> make("modified-sine").peaks().vm.__round__(6)
    1.759603
    """
    return entry(name).make(params)
