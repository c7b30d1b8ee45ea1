"""Classes of values that nothing changes: a dataclass in a third of the time that `dataclasses` takes to make one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import MISSING, Field, FrozenInstanceError, dataclass, field, fields
from operator import attrgetter
from typing import Any, TypeVar, dataclass_transform, overload

T = TypeVar("T")


@overload
def immutable(cls: type[T]) -> type[T]: ...


@overload
def immutable(*, eq: bool = False, kw_only: bool = False) -> Callable[[type[T]], type[T]]: ...


@dataclass_transform(frozen_default=True, eq_default=False, field_specifiers=(field,))
def immutable(cls: type[T] | None = None, *, eq: bool = False, kw_only: bool = False) -> Any:
    """A frozen dataclass, with all that `dataclasses` does with one (fields, replace, asdict).

    eq  compared and hashed by its fields, not by identity

    Of each class `dataclass(frozen=True)` compiles six methods; here its `__init__` alone is, when the first object is
    made; all others are shared.
    """
    if cls is None:
        return lambda cls: _made(cls, eq, kw_only)
    return _made(cls, eq, kw_only)


def _made(cls: type[Any], eq: bool, kw_only: bool) -> type[Any]:
    methods: dict[str, Any] = {"__setattr__": _set, "__delattr__": _delete, "__repr__": _shown}
    cls.__doc__ = cls.__doc__ or cls.__name__
    made = dataclass(init=False, repr=False, eq=False, kw_only=kw_only)(cls)
    if eq:
        methods |= _compared(fields(made))
    methods["__init__"] = _Init(made)
    for name, method in methods.items():
        if name not in vars(made):
            setattr(made, name, method)
    return made


def _set(self: object, name: str, value: object) -> None:
    raise FrozenInstanceError(f"cannot assign to field {name!r}")


def _delete(self: object, name: str) -> None:
    raise FrozenInstanceError(f"cannot delete field {name!r}")


def _shown(self: Any) -> str:
    told = ", ".join(f"{one.name}={getattr(self, one.name)!r}" for one in fields(self) if one.repr)
    return f"{type(self).__qualname__}({told})"


def _compared(every: tuple[Field[Any], ...]) -> dict[str, Any]:
    names = [one.name for one in every if one.compare]
    key: Callable[[Any], object] = attrgetter(*names) if names else lambda self: ()

    def equal(self: object, other: object) -> bool:
        return key(self) == key(other) if other.__class__ is self.__class__ else NotImplemented

    def hashed(self: object) -> int:
        return hash(key(self))

    return {"__eq__": equal, "__hash__": hashed}


class _Init:
    """The `__init__` of a class until somebody asks for it: it is compiled then, and stands in its own place."""

    def __init__(self, cls: type[Any]) -> None:
        self._cls = cls

    def __get__(self, instance: object, owner: type[Any]) -> Any:
        if vars(self._cls).get("__init__") is self:
            self._cls.__init__ = _init(self._cls)
        return self._cls.__init__.__get__(instance, owner)


def _init(cls: type[Any]) -> Any:
    """The `__init__` of a class: what is not given is its default, or made by its factory."""
    values: dict[str, Any] = {"_set_": object.__setattr__, "_missing_": MISSING}
    taken: dict[bool, list[str]] = {False: [], True: []}
    lines = []
    for one in fields(cls):
        name, value = one.name, one.name
        if one.default_factory is not MISSING:
            values[f"_of_{name}"] = one.default_factory
            made = f"_of_{name}()"
            value = f"{made} if {name} is _missing_ else {name}" if one.init else made
        if one.init:
            default = "" if one.default_factory is MISSING else "=_missing_"
            if one.default is not MISSING:
                values[f"_of_{name}"] = one.default
                default = f"=_of_{name}"
            taken[one.kw_only is True].append(name + default)
        elif one.default_factory is MISSING:
            continue
        lines.append(f" _set_(self,{name!r},{value})")
    if hasattr(cls, "__post_init__"):
        lines.append(" self.__post_init__()")
    given = ",".join(["self", *taken[False], *(["*", *taken[True]] if taken[True] else [])])
    exec(f"def __init__({given}):\n" + ("\n".join(lines) or " pass"), values)
    init = values["__init__"]
    init.__qualname__ = f"{cls.__qualname__}.__init__"
    init.__module__ = cls.__module__
    init.__annotations__ = {one.name: one.type for one in fields(cls) if one.init} | {"return": None}
    return init
