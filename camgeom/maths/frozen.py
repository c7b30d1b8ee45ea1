"""Derived values computed once and handed out read-only: who could write into one would change every later answer."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar, overload

import numpy as np

from camgeom.errors import CamgeomError

T = TypeVar("T")

SCALARS = (float, int, bool, str, bytes, complex, type(None), type, np.generic)
_INSIDE: dict[type, Callable[[Any], Iterable[Any]] | None] = {}
"""what there is inside a value, by its type; None where nothing is looked for"""


def _inside(kind: type) -> Callable[[Any], Iterable[Any]] | None:
    """What gives the parts of a value of a type."""
    if issubclass(kind, SCALARS):
        return None
    if issubclass(kind, tuple | list):
        return iter
    if issubclass(kind, Mapping):
        return lambda item: item.values()
    # What is hashed by its values holds no array, and what is derived from it was frozen when it was made.
    if kind.__module__.startswith("camgeom.") and kind.__dictoffset__ and kind.__hash__ in (None, object.__hash__):
        return lambda item: vars(item).values()
    return None


def frozen(value: T) -> T:
    """The same value with every array in it read-only: in tuples, lists, mappings and our own objects, at any depth."""
    seen: set[int] = set()
    waiting: list[Any] = [value]
    for item in waiting:
        if isinstance(item, np.ndarray):
            item.setflags(write=False)
            continue
        kind = type(item)
        if kind not in _INSIDE:
            _INSIDE[kind] = _inside(kind)
        inside = _INSIDE[kind]
        if inside is not None and id(item) not in seen:
            seen.add(id(item))
            waiting += inside(item)
    return value


class cached_property(functools.cached_property[T]):
    """`functools.cached_property` whose arrays are read-only, and of which all threads see the same value.

    A refusal is kept too: what was refused once is not tried again by the next one who asks.
    """

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> cached_property[T]: ...

    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> T: ...

    def __get__(self, instance: object, owner: type[Any] | None = None) -> Any:
        if instance is None:
            return self
        assert self.attrname is not None, "named by its class"
        kept, refusal = vars(instance), f"refusal of {self.attrname}"
        if refusal in kept:
            raise again(kept[refusal])
        try:
            value = frozen(self.func(instance))
        except CamgeomError as error:
            kept[refusal] = told(error)
            raise
        return kept.setdefault(self.attrname, value)


Told = tuple[type[Exception], tuple[Any, ...], dict[str, Any]]
"""an error without its traceback, which would keep every array of the attempt"""


def told(error: Exception) -> Told:
    """What is kept of an error."""
    return type(error), error.args, dict(vars(error))


def again(kept: Told) -> Exception:
    """The error as it was."""
    kind, arguments, attributes = kept
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(attributes)
    return error
