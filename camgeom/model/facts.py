"""Facts computed when first asked for, once, with their cost: the descriptor under `Model`."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any, Generic, Protocol, TypeVar, overload

from camgeom.errors import CamgeomError

T = TypeVar("T")

Observer = Callable[[str, str, float], None]
"""Called as observer("start" or "done", fact name, seconds)."""


class Ledger:
    """What was computed and what it cost, without what it asked of others; nested facts are charged to themselves.

    notes: what writers say of their files, plain data by format
    """

    def __init__(self, observer: Observer | None = None) -> None:
        self.costs: dict[str, float] = {}
        self.notes: dict[str, Any] = {}
        self._observer = observer
        self._inner: list[float] = []

    def charge(self, name: str, compute: Callable[[], T]) -> T:
        """Run compute() and book its own time under `name`."""
        if self._observer:
            self._observer("start", name, 0.0)
        self._inner.append(0.0)
        began = perf_counter()
        try:
            return compute()
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
    """An attribute computed on first access and kept; its cost is booked in the owner's ledger.

    A refusal is kept too: what the design does not admit, or no memory is enough for, is not tried again.
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
        refusal = f"refusal of {self._name}"
        if refusal in instance.__dict__:
            raise _again(*instance.__dict__[refusal])
        try:
            value = instance.ledger.charge(self._name, lambda: self._compute(instance))
        except (CamgeomError, MemoryError) as error:
            # Not the error itself: its traceback would keep every array of the attempt.
            instance.__dict__[refusal] = (type(error), error.args, dict(error.__dict__))
            raise
        instance.__dict__[self._name] = value
        return value


def _again(kind: type[Exception], arguments: tuple[Any, ...], attributes: dict[str, Any]) -> Exception:
    """An error as it was."""
    error = kind.__new__(kind, *arguments)
    error.__dict__.update(attributes)
    return error
