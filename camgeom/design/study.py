"""Many models: a profile with some of its keys varied over a grid, one row a variant.

A variant that cannot be read, made or solved is a row with the reason. Rows come in the order of the grid, the last
axis fastest, whatever order the worker processes finish in.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import islice, product
from multiprocessing import get_context
from time import perf_counter
from typing import TYPE_CHECKING, Any, final

from camgeom.errors import CamgeomError, DesignError, Problem, ProfileError
from camgeom.motion.own import begin_worker, loaded_files

if TYPE_CHECKING:
    from camgeom.model import Model

MOST_VARIANTS = 100_000
MOST_AXES = 8
ALONE_FOR = 0.5
"""s; worker processes take longer than this to start, so the first variants are computed without them"""
CHUNK = 8

Value = float | int | str
Data = dict[str, Any]
Figures = dict[str, float | int | bool | str | None]
Measure = Callable[["Model"], tuple[Figures, str, str]]
"""Figures of a model, its verdict and the reason of that; a function of a module, so that processes can share it."""


@final
@dataclass(frozen=True)
class Axis:
    """A profile key and the values it takes; `path` leads to it through tables and arrays."""

    key: str
    path: tuple[str | int, ...]
    values: tuple[Value, ...]


@final
@dataclass(frozen=True)
class Row:
    """One variant: the values of the axes, what was measured, and its verdict with the reason.

    verdict  "pass", "warn" or "fail"; "no result" or "bad input" where there is none
    """

    values: tuple[Value, ...]
    figures: Figures
    verdict: str
    reason: str = ""


def axis(text: str) -> Axis:
    """An axis from KEY=A:B:N (N values from A to B), KEY=A:B:N:log (in equal ratios) or KEY=a,b,c.

    Raises ProfileError where it is none of them.
    """
    key, equals, written = text.partition("=")
    key, written = key.strip(), written.strip()
    forms, example = "needs KEY=A:B:N, KEY=A:B:N:log or KEY=a,b,c", "for example cam.diameter=120:150:7"
    problem = Problem("--vary", forms, text[:200], example)
    if not equals or not re.fullmatch(r"[\w-]+(\[\d{1,5}\])?(\.[\w-]+(\[\d{1,5}\])?)*", key) or not written:
        raise ProfileError([problem])
    path: list[str | int] = []
    for part in key.split("."):
        name, _, index = part.partition("[")
        path += [name, int(index[:-1])] if index else [name]
    values = _span(written, problem) if ":" in written else tuple(_value(word) for word in written.split(","))
    if any(isinstance(v, float) and not math.isfinite(v) for v in values) or "" in values:
        raise ProfileError([Problem("--vary", "needs finite numbers or words", text[:200])])
    return Axis(key, tuple(path), values)


def _value(word: str) -> Value:
    word = word.strip()
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            continue
    return word.strip("\"'")


def _span(text: str, problem: Problem) -> tuple[Value, ...]:
    """Evenly spaced values with both ends (in equal ratios with :log); whole numbers where all of them are whole."""
    parts = [_value(word) for word in text.split(":")]
    in_ratios = len(parts) == 4 and parts[3] == "log"
    parts = parts[:3] if in_ratios else parts
    if len(parts) != 3 or not isinstance(parts[2], int) or any(isinstance(part, str) for part in parts):
        raise ProfileError([problem])
    first, last, count = float(parts[0]), float(parts[1]), parts[2]
    if not 1 <= count <= MOST_VARIANTS:
        raise ProfileError([Problem("--vary", "the number of values is out of range", count, f"1 to {MOST_VARIANTS}")])
    if not (math.isfinite(first) and math.isfinite(last)) or (count == 1 and first != last):
        raise ProfileError([problem])
    steps = max(count - 1, 1)
    if in_ratios and not (first > 0.0 and last > 0.0):
        raise ProfileError([Problem("--vary", "equal ratios need ends above 0", text[:200])])
    if in_ratios:
        values = [first * (last / first) ** (i / steps) for i in range(count - 1)] + [last]
    else:
        values = [first + (last - first) * i / steps for i in range(count - 1)] + [last]
    whole = all(isinstance(part, int) for part in parts) and all(value.is_integer() for value in values)
    return tuple(int(value) for value in values) if whole else tuple(values)


PLAY = {"follower.clearance": 1.0, "cam.running_clearance": 0.5}
"""keys of the play that a body is cut with, as shares of the play between two contacts"""


def replaced(data: Any, path: Sequence[str | int], value: Value, key: str) -> Any:
    """The data with the value at a path replaced, or added to a table. Raises ProfileError where the path breaks."""
    if not path:
        return value
    head, rest = path[0], path[1:]
    if isinstance(head, int):
        if not isinstance(data, tuple) or head >= len(data):
            allowed = f"0 to {len(data) - 1}" if isinstance(data, tuple) and data else "no array there"
            raise ProfileError([Problem(f"--vary {key}", "no such entry", head, allowed)])
        return tuple(replaced(item, rest, value, key) if i == head else item for i, item in enumerate(data))
    if not isinstance(data, dict):
        hint = f"write {key.partition('.')[0]}[0] for the first entry" if isinstance(data, tuple) else ""
        raise ProfileError([Problem(f"--vary {key}", f"there is no table that could hold {head!r}", hint=hint)])
    return {**data, head: replaced(data.get(head, {}), rest, value, key)}


@final
@dataclass(frozen=True)
class Study:
    """A profile's data (as `profile_text.load` gives it), the axes, and what is measured of each variant."""

    data: Data
    file: str
    axes: tuple[Axis, ...]
    measure: Measure

    def __post_init__(self) -> None:
        if not 1 <= len(self.axes) <= MOST_AXES:
            raise ProfileError([Problem("--vary", "a study needs axes", len(self.axes), f"1 to {MOST_AXES}")])
        keys = [one.key for one in self.axes]
        if len(set(keys)) < len(keys):
            raise ProfileError([Problem("--vary", "a key is varied twice", ", ".join(keys))])
        if len(self) > MOST_VARIANTS:
            raise ProfileError([Problem("--vary", "too many variants", len(self), f"at most {MOST_VARIANTS}")])
        # A wrong path or an unknown key is one mistake of the study, not a reason in every row.
        self._refuse_unknown(self.variant(tuple(one.values[0] for one in self.axes)))

    def __len__(self) -> int:
        return math.prod(len(one.values) for one in self.axes)

    def variant(self, values: Sequence[Value]) -> Data:
        """The profile's data with one value for each axis; a body that states its play has that of [impact]."""
        data = self.data
        for one, value in zip(self.axes, values, strict=True):
            data = replaced(data, one.path, value, one.key)
            if one.key == "impact.clearance" and isinstance(value, int | float):
                for key, share in PLAY.items():
                    table, _, name = key.partition(".")
                    if data.get(table, {}).get(name) and key not in [other.key for other in self.axes]:
                        data = replaced(data, (table, name), share * value, key)
        return data

    def _refuse_unknown(self, data: Data) -> None:
        from camgeom.profile import from_data

        try:
            from_data(data, self.file)
        except ProfileError as error:
            keys = {one.key for one in self.axes}
            unknown = [p for p in error.problems if p.message == "unknown key" and p.key in keys]
            if unknown:
                raise ProfileError([Problem(f"--vary {p.key}", p.message, None, "", p.hint) for p in unknown]) from None

    def row(self, values: tuple[Value, ...], before: Model | None = None) -> tuple[Row, Model | None]:
        """One variant computed, and its model; facts of the model before that hold for it too are taken over."""
        from camgeom.model import Model
        from camgeom.profile import from_data

        model = None
        try:
            model = Model(from_data(self.variant(values), self.file))
            _take_over(model, before)
            figures, verdict, reason = self.measure(model)
        except ProfileError as error:
            return Row(values, {}, "bad input", "; ".join(map(str, error.problems))), model
        except DesignError as error:
            return Row(values, {}, "fail", str(error)), model
        except CamgeomError as error:
            return Row(values, {}, "no result", str(error)), model
        return Row(values, figures, verdict, reason), model

    def rows(self, jobs: int | None = None) -> Iterator[Row]:
        """Every variant in order; by `jobs` worker processes (default: one per core) where it takes long."""
        grid = product(*(one.values for one in self.axes))
        workers = min(jobs or cores(), len(self))
        began = perf_counter()
        model = None
        for done, values in enumerate(grid, 1):
            row, model = self.row(values, model)
            yield row
            if workers > 1 and perf_counter() - began > ALONE_FOR and len(self) - done > workers:
                break
        yield from self._shared(grid, workers)

    def _shared(self, grid: Iterator[tuple[Value, ...]], workers: int) -> Iterator[Row]:
        """The rest of the grid by worker processes, a few chunks ahead of what is asked for."""
        first = list(islice(grid, CHUNK))
        if not first:
            return
        with ProcessPoolExecutor(workers, get_context("spawn"), begin_worker, (loaded_files(),)) as pool:
            waiting = [pool.submit(_chunk, self, first)]
            try:
                while waiting:
                    while len(waiting) < 3 * workers and (more := list(islice(grid, CHUNK))):
                        waiting.append(pool.submit(_chunk, self, more))
                    yield from waiting.pop(0).result()
            except BrokenProcessPool:
                raise CamgeomError("a worker process ended early (out of memory?); try --jobs 1") from None
            finally:
                pool.shutdown(wait=True, cancel_futures=True)


def _chunk(study: Study, variants: list[tuple[Value, ...]]) -> list[Row]:
    rows, model = [], None
    for values in variants:
        row, model = study.row(values, model)
        rows.append(row)
    return rows


GEOMETRY = ("setup", "mechanism", "tracks", "cutters", "flanks", "clearances", "turret")
"""Facts of a model that rest on cam, follower, roller and motion alone."""
SHAPE = ("parts", "solids", "walls")
"""Facts of its body that rest on them and on the tolerance."""


def _take_over(model: Model, before: Model | None) -> None:
    """Give the model the geometry of one that differs in speed, load, material or limits only."""
    if before is None or before.tolerance != model.tolerance:
        return
    old, new = before.profile, model.profile
    if (old.cam, old.follower, old.roller, old.motion) == (new.cam, new.follower, new.roller, new.motion):
        shape = (*SHAPE, "mass") if old.material == new.material else SHAPE
        # Facts are kept under their names in the instance, where the next access finds them.
        for to, source, names in ((model, before, GEOMETRY), (model.body, before.body, shape)):
            vars(to).update({name: vars(source)[name] for name in names if name in vars(source)})


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
