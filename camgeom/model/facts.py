"""Facts computed when first asked for, once, with their cost: the descriptor under `Model`."""

from __future__ import annotations

from collections.abc import Callable
from threading import RLock
from time import perf_counter
from typing import Any, Generic, Protocol, TypeVar, overload

from camgeom.maths import within_range
from camgeom.maths.frozen import again, frozen, told

T = TypeVar("T")
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

    def __init__(self, compute: Callable[[Any], T]) -> None:
        self._compute = compute
        self.__doc__ = compute.__doc__
        self._name = compute.__name__

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
        return once(vars(asked), self._name, asked.ledger, lambda: self._compute(asked))


def once(kept: dict[str, Any], name: str, ledger: Ledger, compute: Callable[[], T]) -> T:
    """What is kept under a name, computed the first time, its arrays read-only; so is an error, raised again."""
    refusal = f"refusal of {name}"
    with ledger.turn:
        if refusal in kept:
            raise again(kept[refusal])
        if name not in kept:
            try:
                kept[name] = frozen(ledger.charge(name, compute))
            except Exception as error:
                kept[refusal] = told(error)
                raise
    found: T = kept[name]
    return found


class Sealed:
    """An object whose attributes cannot be set from outside: its facts were computed from them."""

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{name} of a {type(self).__name__} cannot be set: its facts rest on it; make another one")
