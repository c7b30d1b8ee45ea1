"""Which variants a study has: a grid, lists side by side, Sobol points, a Latin hypercube; and keys tied to others.

Variants have numbers, and the values of a range of them hang on nothing else, so that any worker can make its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any, Literal, final

import numpy as np
import numpy.typing as npt

from camgeom.design.study import Axis, Data, Value, axis
from camgeom.errors import Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.maths import Floats
from camgeom.mechanics.applied import Expression, compile_expression

Method = Literal["grid", "list", "sobol", "latin"]
METHODS: tuple[Method, ...] = ("grid", "list", "sobol", "latin")
DRAWN = ("sobol", "latin")
MOST_DRAWN = 100_000_000
KEY = r"[A-Za-z_]\w*(?:\[\d{1,5}\])?(?:\.[A-Za-z_]\w*(?:\[\d{1,5}\])?)+"
"""a key of a profile within an expression: it has a dot, which no variable of arithmetic has"""
Column = list[Value] | Floats


@final
@immutable(eq=True)
class Tie:
    """A key that follows others: KEY=EXPRESSION over numbers and keys of the profile, in plain arithmetic."""

    key: str
    path: tuple[str | int, ...]
    written: str
    expression: Expression
    names: tuple[tuple[str, str, tuple[str | int, ...]], ...]
    """(variable, key, path) of every key that it uses"""

    def values(self, columns: Mapping[str, Column], data: Data) -> Floats:
        """Its values, (n,) or (1,), from varied columns and, of keys that are not varied, the profile's data.

        Raises ProfileError where a key has no number or a value is not finite.
        """
        found = self.reached(columns, data)
        if not np.isfinite(found).all():
            text = "has no finite value for some variant"
            raise ProfileError([Problem(f"--tie {self.key}", text, self.written)])
        return found

    def reached(self, columns: Mapping[str, Column], data: Data) -> Floats:
        """The same values, finite or not."""
        known = {name: self._number(key, path, columns, data) for name, key, path in self.names}
        with np.errstate(all="ignore"):
            return np.atleast_1d(np.asarray(self.expression.of(known), dtype=np.float64))

    def _number(self, key: str, path: tuple[str | int, ...], columns: Mapping[str, Column], data: Data) -> Floats:
        value: Any = columns.get(key)
        lacking = "is varied by words" if value is not None else "has no number in the profile and is not varied"
        if value is None:
            value = data
            for part in path:
                inside = isinstance(value, dict) and part in value
                inside |= isinstance(value, tuple) and isinstance(part, int) and part < len(value)
                value = value[part] if inside else ""  # no number either
        try:
            return np.asarray(value, dtype=np.float64) + 0.0
        except (TypeError, ValueError):
            raise ProfileError([Problem(f"--tie {self.key}", f"uses a key that {lacking}", key)]) from None


def tie(text: str) -> Tie:
    """A tie from KEY=EXPRESSION, for example cam.bore=0.4*cam.base_radius. Raises ProfileError where it is none."""
    key, equals, written = text.partition("=")
    key, written = key.strip(), written.strip()
    if not equals or not re.fullmatch(KEY, key) or not written:
        example = "for example cam.bore=0.4*cam.base_radius"
        raise ProfileError([Problem("--tie", "needs KEY=EXPRESSION", text[:200], example)])
    used = list(dict.fromkeys(re.findall(KEY, written)))
    stem = "key"
    while stem in written:
        stem += "_"
    names = {one: f"{stem}{i}_" for i, one in enumerate(used)}
    plain = re.sub(KEY, lambda found: names[found[0]], written)
    try:
        expression = compile_expression(plain, f"--tie {key}", {name: one for one, name in names.items()})
    except ProfileError as error:
        # Told as it was written, with the profile's keys.
        def told(text: str) -> str:
            return re.sub(rf"{stem}\d+_", lambda name: used[int(name[0][len(stem) : -1])], text)

        raise ProfileError(
            [replace(one, message=told(one.message), value=written, hint=told(one.hint)) for one in error.problems]
        ) from None
    paths = tuple((name, one, axis(f"{one}=0").path) for one, name in names.items())
    return Tie(key, axis(f"{key}=0").path, written, expression, paths)


def in_turn(ties: Sequence[Tie]) -> tuple[Tie, ...]:
    """Ties, each after those whose keys it uses. Raises ProfileError where keys follow each other in a circle."""
    left, found = list(ties), list[Tie]()
    while ready := [one for one in left if not {key for _, key, _ in one.names} & {other.key for other in left}]:
        found += ready
        left = [one for one in left if one not in ready]
    if left:
        text = "keys follow each other in a circle"
        raise ProfileError([Problem("--tie", text, ", ".join(f"{one.key}={one.written}" for one in left))])
    return tuple(found)


@final
@immutable(eq=True)
class Plan:
    """The variants of a study: axes, how they are combined, and ties.

    method  grid: every value of an axis with every one of the others; list: the n-th values of all axes together;
            sobol, latin: `count` points, an axis of two numbers (a range) drawn evenly between them, a list by choice
    """

    axes: tuple[Axis, ...]
    method: Method = "grid"
    count: int = 0
    seed: int = 0
    ties: tuple[Tie, ...] = ()

    def __post_init__(self) -> None:
        found: list[Problem] = []
        lengths = {len(one.values) for one in self.axes}
        if self.method == "list" and len(lengths) > 1:
            told = ", ".join(map(str, sorted(lengths)))
            found.append(Problem("--sample", "list needs as many values of every key", told))
        if self.method in DRAWN and not 1 <= self.count <= MOST_DRAWN:
            allowed = f"1 to {MOST_DRAWN}"
            found.append(Problem("--sample", "the number of variants is out of range", self.count, allowed))
        keys = self.keys
        if len(set(keys)) < len(keys):
            found.append(Problem("--vary", "a key is varied or tied twice", ", ".join(keys)))
        if found:
            raise ProfileError(found)
        in_turn(self.ties)

    @property
    def drawn(self) -> bool:
        """Whether its variants are points drawn."""
        return self.method in DRAWN

    @property
    def keys(self) -> tuple[str, ...]:
        """The keys of its columns."""
        return (*(one.key for one in self.axes), *(one.key for one in self.ties))

    def __len__(self) -> int:
        if self.method == "grid":
            return math.prod(len(one.values) for one in self.axes)
        return len(self.axes[0].values) if self.method == "list" else self.count

    def columns(self, piece: range, data: Data) -> dict[str, Column]:
        """Values of all keys of the variants of these numbers, in order; words and whole numbers as lists."""
        numbers = np.arange(piece.start, piece.stop)
        found: dict[str, Column] = {}
        points = self._points(numbers) if self.drawn else None
        below = len(self)
        for i, one in enumerate(self.axes):
            if points is not None and one.between:
                low, high = (float(value) for value in one.values)
                found[one.key] = low + (high - low) * points[:, i]
                continue
            count = len(one.values)
            if points is not None:
                chosen = np.minimum((points[:, i] * count).astype(np.intp), count - 1)
            elif self.method == "list":
                chosen = numbers
            else:
                below //= count
                chosen = numbers // below % count
            found[one.key] = _taken(one.values, chosen)
        for follower in in_turn(self.ties):
            found[follower.key] = np.broadcast_to(follower.values(found, data), numbers.shape).copy()
        return {key: found[key] for key in self.keys}

    def undrawn(self, data: Data) -> tuple[Value, ...]:
        """Values of all keys with every axis at its first: points drawn need not have this variant among them.

        Raises ProfileError where a tie uses a key that has no number.
        """
        found: dict[str, Column] = {one.key: [one.values[0]] for one in self.axes}
        for follower in in_turn(self.ties):
            found[follower.key] = follower.reached(found, data)
        return tuple(found[key][0] for key in self.keys)

    def _points(self, numbers: npt.NDArray[np.int64]) -> Floats:
        """Points (n, axes) of the unit cube of the variants of these consecutive numbers."""
        if self.method == "latin":
            places = _hypercube(self.count, len(self.axes), self.seed)
            return np.asarray(places[numbers[0] : numbers[-1] + 1])
        return _sobol(len(self.axes), self.seed, int(numbers[0]), len(numbers))

    def described(self) -> dict[str, Any]:
        """All that its variants rest on, as plain data."""
        return {
            "axes": {one.key: list(one.values) for one in self.axes},
            "method": [self.method, self.count, self.seed],
            "ties": {one.key: one.written for one in self.ties},
        }


def _taken(values: Sequence[Value], chosen: npt.NDArray[np.intp]) -> Column:
    """Values by their places; numbers that are not all whole as an array."""
    if all(isinstance(value, float | int) for value in values) and any(isinstance(value, float) for value in values):
        return np.array(values, dtype=np.float64)[chosen]
    return [values[i] for i in chosen]


def _sobol(axes: int, seed: int, first: int, count: int) -> Floats:
    """Points of a scrambled Sobol sequence from the number `first` on, (count, axes)."""
    from scipy.stats import qmc

    sequence = qmc.Sobol(axes, scramble=True, rng=np.random.default_rng(seed))
    if first:
        sequence.fast_forward(first)
        return np.asarray(sequence.random(count))
    # The first point alone: its balance is asked of a whole power of two, which a study need not have.
    return np.concatenate([sequence.random(1), sequence.random(count - 1)]) if count > 1 else sequence.random(1)


@lru_cache(maxsize=2)
def _hypercube(count: int, axes: int, seed: int) -> Floats:
    """A Latin hypercube, (count, axes): every one of `count` equal stretches of every axis has one point."""
    rng = np.random.default_rng(seed)
    places = np.stack([rng.permutation(count) for _ in range(axes)], axis=1)
    return np.asarray((places + rng.random((count, axes))) / count)


def sample(text: str) -> tuple[Method, int, int]:
    """Method, number of variants and seed from grid, list, sobol:N[:SEED] or latin:N[:SEED]."""
    found = re.fullmatch(r"(grid|list)|(sobol|latin):(\d{1,12})(?::(\d{1,9}))?", text.strip())
    if found is None:
        forms = "needs grid, list, sobol:N or latin:N"
        raise ProfileError([Problem("--sample", forms, text[:200], "for example sobol:4096")])
    method = next(one for one in METHODS if one == (found[1] or found[2]))
    return method, int(found[3] or 0), int(found[4] or 0)
