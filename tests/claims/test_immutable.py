"""Classes that nothing changes are dataclasses to all who ask."""

from __future__ import annotations

import pickle
from copy import deepcopy
from dataclasses import FrozenInstanceError, asdict, dataclass, field, fields, replace
from inspect import isfunction, signature

import pytest

from camgeom.immutable import immutable


@immutable
class Plain:
    first: int
    second: list[int] = field(default_factory=list)
    made: int = field(init=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "made", self.first + 1)


@immutable(eq=True)
class Compared:
    first: int
    second: str = "b"


@immutable(eq=True, kw_only=True)
class Named(Compared):
    third: float = 1.0


@dataclass(frozen=True)
class Usual:
    first: int
    second: str = "b"


def test_a_dataclass_to_all_who_ask() -> None:
    one, other = Plain(1), Plain(1)
    assert (one.first, one.second, one.made) == (1, [], 2)
    assert one.second is not other.second
    assert one != other
    assert hash(one) != hash(other)
    assert [each.name for each in fields(one)] == ["first", "second", "made"]
    assert asdict(Plain(3, [4])) == {"first": 3, "second": [4], "made": 4}
    assert repr(Plain(3, second=[4])) == "Plain(first=3, second=[4])"
    assert replace(one, first=5).made == 6


def test_it_is_compiled_when_it_is_first_asked_for() -> None:
    @immutable
    class Fresh:
        first: int
        second: str = "b"

    class Below(Fresh):
        """What has no `__init__` of its own."""

    assert not isfunction(vars(Fresh)["__init__"])
    assert Below(1).second == "b"
    assert isfunction(vars(Fresh)["__init__"])
    assert "__init__" not in vars(Below)

    @immutable
    class Asked:
        first: int
        second: str = "b"

    assert str(signature(Asked)) == "(first: 'int', second: 'str' = 'b') -> None"
    assert isfunction(vars(Asked)["__init__"])


def test_nothing_changes_it() -> None:
    one = Plain(1)
    for name in ("first", "new"):
        with pytest.raises(FrozenInstanceError):
            setattr(one, name, 2)
    with pytest.raises(FrozenInstanceError):
        del one.first
    assert vars(one) == vars(Plain(1))


def test_compared_by_fields_where_asked() -> None:
    assert Compared(1) == Compared(1, "b") != Compared(1, "c")
    assert len({Compared(1), Compared(1), Compared(2)}) == 2
    assert Compared(1) != Usual(1)
    assert Named(1, third=2.0) == Named(1, third=2.0) != Named(1)
    assert repr(Named(1)).endswith("Named(first=1, second='b', third=1.0)")


def test_wrong_arguments_are_refused_as_by_any_function() -> None:
    for arguments, named in (((), {}), ((1, "b", 2), {}), ((1,), {"fourth": 1}), ((1, "b", 1.0), {})):
        with pytest.raises(TypeError, match="argument"):
            Named(*arguments, **named)


def test_copies_and_pickles_are_equal() -> None:
    for one in (Compared(1), Named(2, third=3.0)):
        assert pickle.loads(pickle.dumps(one)) == deepcopy(one) == one
