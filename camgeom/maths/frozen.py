"""Derived values computed once and handed out read-only: who could write into one would change every later answer.

`cached_property` keeps one; `fact` keeps one, books what it cost and serves several threads.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from threading import RLock
from time import perf_counter
from typing import Any, Generic, Protocol, TypeVar, cast, overload
from weakref import ReferenceType, ref

import numpy as np

from camgeom.errors import CamgeomError
from camgeom.maths import within_range

T = TypeVar("T")

SCALARS = (float, int, bool, str, bytes, complex, type(None), type, np.generic)
PLAIN = frozenset(SCALARS)
_INSIDE: dict[type, Callable[[Any], Iterable[Any]] | None] = {}
"""what there is inside a value, by its type; None where nothing is looked for"""


def _inside(kind: type) -> Callable[[Any], Iterable[Any]] | None:
    """What gives the parts of a value of a type."""
    if issubclass(kind, SCALARS):
        return None
    if issubclass(kind, tuple | list):
        return lambda item: () if PLAIN.issuperset(map(type, item)) else item  # rows of numbers are long
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


class ReadOnly(dict[Any, Any]):
    """A dictionary that is handed out: to read, to copy, to join to others."""

    def _refuse(self, *_: Any, **__: Any) -> Any:
        raise TypeError("what camgeom has computed cannot be changed; dict(...) makes a copy")

    __setitem__ = __delitem__ = __ior__ = clear = pop = popitem = setdefault = update = _refuse

    def __reduce__(self) -> tuple[type[ReadOnly], tuple[dict[Any, Any]]]:
        return ReadOnly, (dict(self),)


def handed_out(name: str, value: T) -> T:
    """A value as it is kept under a name: frozen, and no dictionary that others could change. What is kept for later
    under a name of one's own stays as it is."""
    found: Any = frozen(value)
    if type(found) is dict and not name.startswith("_"):
        found = ReadOnly(found)
    return cast(T, found)


class cached_property(functools.cached_property[T]):
    """`functools.cached_property` whose arrays are read-only, and of which all threads see the same value.

    A refusal is kept too, and that memory did not do: what failed once is not tried again by the next one who asks.
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
            value = handed_out(self.attrname, self.func(instance))
        except (CamgeomError, MemoryError) as error:
            kept[refusal] = told(error)
            raise
        return kept.setdefault(self.attrname, value)


SHELF, LATEST = 700_000_000, 0.5
"""bytes that all shelved values of a process hold, and the share of them that those computed last have in any case"""


class _Shelf:
    """What is kept of large values that are computed again where they are asked for later.

    Operating states are gone through one after the other, again and again: those that are kept longest are asked for
    first. What makes room is what was computed last, but for the latest.
    """

    def __init__(self) -> None:
        self._lock = RLock()
        self._kept: dict[tuple[int, str], tuple[ReferenceType[object], int]] = {}
        self._held = 0

    def add(self, instance: object, name: str, value: object) -> None:
        """One more; others go where all are too many."""
        with self._lock:
            key = id(instance), name
            if key in self._kept:
                return
            size = _bytes(value)
            self._kept[key] = ref(instance, lambda _: self._forget(key)), size
            self._held += size
            while self._held > SHELF and len(self._kept) > 1:
                gone = self._next(key)
                found = self._kept.get(gone)
                self._forget(gone)
                if found is not None and (owner := found[0]()) is not None:
                    vars(owner).pop(gone[1], None)

    def _next(self, added: tuple[int, str]) -> tuple[int, str]:
        """What goes next. An owner may be collected while this looks, and takes its values along."""
        every, latest = self._kept.copy(), 0
        for key, (_, size) in reversed(every.items()):
            latest += size
            if latest > LATEST * SHELF and key != added:
                return key
        return next(iter(every))

    def _forget(self, key: tuple[int, str]) -> None:
        with self._lock:
            if (found := self._kept.pop(key, None)) is not None:
                self._held -= found[1]


def _bytes(value: object) -> int:
    """Of the arrays in a value."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    inside = value.values() if isinstance(value, Mapping) else value if isinstance(value, tuple | list) else ()
    return sum(map(_bytes, inside))


_SHELF = _Shelf()


class shelved(cached_property[T]):
    """A `cached_property` of arrays so large that not every operating state of a design can keep them: `SHELF` bytes
    of all together are kept, and what has made room is computed again, to the same value."""

    @overload
    def __get__(self, instance: None, owner: type[Any] | None = None) -> shelved[T]: ...

    @overload
    def __get__(self, instance: object, owner: type[Any] | None = None) -> T: ...

    def __get__(self, instance: object, owner: type[Any] | None = None) -> Any:
        value = super().__get__(instance, owner)
        if instance is not None:
            assert self.attrname is not None
            _SHELF.add(instance, self.attrname, value)
        return value


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


TWIN = "_twin"
"""attribute of an object whose facts are another one's, which it names"""

Observer = Callable[[str, str, float], None]
"""Called as observer("start" or "done", fact name, seconds)."""


class Ledger:
    """What was computed and what it cost, without what it asked of others; nested facts are charged to themselves.

    notes: what writers say of their files, plain data by format
    turn: held while a fact is computed, so that several threads compute each fact once
    """

    def __init__(self, observer: Observer | None = None) -> None:
        self.costs: dict[str, float] = {}
        self.notes: dict[str, Any] = {}
        self.turn = RLock()
        self._observer = observer
        self._inner: list[float] = []

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in vars(self).items() if name != "turn"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, turn=RLock())

    def charge(self, name: str, compute: Callable[[], T]) -> T:
        """Run compute() and book its own time under `name`."""
        def job() -> T:
            with within_range(name.replace("_", " ")):
                return compute()

        return self.book(name, job)

    def book(self, name: str, job: Callable[[], T]) -> T:
        """Do what is no fact, a file or a picture, and book its own time under `name`."""
        if self._observer:
            self._observer("start", name, 0.0)
        self._inner.append(0.0)
        began = perf_counter()
        try:
            return job()
        finally:
            spent = perf_counter() - began
            inner = self._inner.pop()
            if self._inner:
                self._inner[-1] += spent
            self.costs[name] = self.costs.get(name, 0.0) + spent - inner
            if self._observer:
                self._observer("done", name, spent)


class HasLedger(Protocol):
    """An object whose facts are booked."""

    @property
    def ledger(self) -> Ledger:
        """Where costs are booked."""


class fact(Generic[T]):
    """An attribute computed on first access, once, and kept, its arrays read-only; its cost is booked in the ledger.

    A refusal is kept too, and an error: what the design does not admit, or no memory is enough for, is not tried again.
    """

    def __init__(self, compute: Callable[[Any], T], asked: str = "") -> None:
        self._compute = compute
        self.__doc__ = compute.__doc__
        self._name = compute.__name__
        self._asked = asked

    def __set_name__(self, owner: type, name: str) -> None:
        self._name = name

    @overload
    def __get__(self, instance: None, owner: type) -> fact[T]: ...

    @overload
    def __get__(self, instance: HasLedger, owner: type) -> T: ...

    def __get__(self, instance: Any, owner: type) -> Any:
        if instance is None:
            return self
        asked = vars(instance).get(TWIN, instance)
        if self._asked:
            asked = getattr(asked, self._asked)
        return once(vars(asked), self._name, asked.ledger, lambda: self._compute(asked))


def fact_of(asked: str) -> Callable[[Callable[[Any], T]], fact[T]]:
    """A fact that an object has in common with another one, which its attribute `asked` names: computed there, once."""
    return lambda compute: fact(compute, asked)


def once(kept: dict[str, Any], name: str, ledger: Ledger, compute: Callable[[], T]) -> T:
    """What is kept under a name, computed the first time, its arrays read-only; so is an error, raised again."""
    refusal = f"refusal of {name}"
    with ledger.turn:
        if refusal in kept:
            raise again(kept[refusal])
        if name not in kept:
            try:
                kept[name] = handed_out(name, ledger.charge(name, compute))
            except Exception as error:
                kept[refusal] = told(error)
                raise
    found: T = kept[name]
    return found


class Sealed:
    """An object whose attributes cannot be set from outside: its facts were computed from them."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name} of a {type(self).__name__} cannot be set: its facts rest on it; make another one")
