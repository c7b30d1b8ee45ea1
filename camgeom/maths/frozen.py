"""Derived values computed once and handed out read-only: who could write into one would change every later answer."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any, TypeVar, overload

import numpy as np

T = TypeVar("T")

SCALARS = (float, int, bool, str, bytes, complex, type(None), type, np.generic)


def frozen(value: T) -> T:
    """The same value with every array in it read-only: in tuples, lists, mappings and our own objects, at any depth."""
    seen: set[int] = set()
    waiting: list[Any] = [value]
    while waiting:
        item = waiting.pop()
        if isinstance(item, SCALARS) or id(item) in seen:
            continue
        seen.add(id(item))
        if isinstance(item, np.ndarray):
            item.setflags(write=False)
        elif isinstance(item, tuple | list):
            waiting += item
        elif isinstance(item, Mapping):
            waiting += item.values()
        elif type(item).__module__.startswith("camgeom.") and hasattr(item, "__dict__"):
            waiting += vars(item).values()
    return value


class cached_property(functools.cached_property[T]):
    """`functools.cached_property` whose arrays are read-only, and of which all threads see the same value."""

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> cached_property[T]: ...

    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> T: ...

    def __get__(self, instance: object, owner: type[Any] | None = None) -> Any:
        if instance is None:
            return self
        assert self.attrname is not None, "named by its class"
        return vars(instance).setdefault(self.attrname, frozen(self.func(instance)))
