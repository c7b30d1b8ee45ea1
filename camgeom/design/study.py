"""Many models: a profile with some of its keys varied over a grid, one row a variant.

A variant that cannot be read, made or solved is a row with the reason. Rows are numbered in the order of the grid, the
last axis fastest, whatever order the workers of an engine finish in.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any, final

import numpy as np

from camgeom.design.engine import Cutter, Engine
from camgeom.errors import CamgeomError, DesignError, Problem, ProfileError, did_you_mean
from camgeom.immutable import immutable
from camgeom.motion.own import loaded_copies
from camgeom.profile import text as text_module
from camgeom.profile.text import MAX_TABLE_BYTES, beside
from camgeom.reading import read_bytes
from camgeom.version import __version__

if TYPE_CHECKING:
    from camgeom.design.sampling import Plan, Tie
    from camgeom.model import Model

MOST_VARIANTS = 100_000
MOST_AXES = 8
MOST_DRAWN_AXES = 64
ALONE_FOR = 0.5
"""s; worker processes take longer than this to start, so the first variants are computed without them"""

Value = float | int | str
Data = dict[str, Any]
Figures = dict[str, float | int | bool | str | None]
Measure = Callable[["Model"], tuple[Figures, str, str]]
"""Figures of a model, its verdict and the reason of that; a function of a module, so that processes can share it."""


@final
@immutable(eq=True)
class Axis:
    """A profile key and the values it takes; `path` leads to it through tables and arrays.

    between  whether the values are the two ends of a range, from which values are drawn
    """

    key: str
    path: tuple[str | int, ...]
    values: tuple[Value, ...]
    between: bool = False


@final
@immutable(eq=True)
class Row:
    """One variant: the values of the axes, what was measured, and its verdict with the reason.

    verdict  "pass", "warn" or "fail"; "no result" or "bad input" where there is none
    """

    values: tuple[Value, ...]
    figures: Figures
    verdict: str
    reason: str = ""


Variants = Sequence[tuple[Value, ...]]
Work = Callable[[range, Variants], tuple[list[Row], float]]
"""Rows of a piece whose variants are drawn already, and the seconds that they took."""


def axis(text: str, drawn: bool = False) -> Axis:
    """An axis from KEY=A:B:N (N values from A to B), KEY=A:B:N:log (in equal ratios), KEY=a,b,c; `drawn`: or
    KEY=A:B, to draw from between both.

    Raises ProfileError where it is none of them.
    """
    key, equals, written = text.partition("=")
    key, written = key.strip(), written.strip()
    forms, example = "needs KEY=A:B:N, KEY=A:B:N:log or KEY=a,b,c", "for example cam.diameter=120:150:7"
    problem = Problem("--vary", forms, text[:200], example)
    path = text_module.key_path(key)
    if not equals or path is None or not written:
        raise ProfileError([problem])
    ends = [_value(word) for word in written.split(":")]
    if drawn and len(ends) == 2 and all(isinstance(end, int | float) and math.isfinite(end) for end in ends):
        return Axis(key, path, tuple(ends), between=True)
    values = _span(written, problem) if ":" in written else tuple(_value(word) for word in written.split(","))
    if any(isinstance(v, float) and not math.isfinite(v) for v in values) or "" in values:
        raise ProfileError([Problem("--vary", "needs finite numbers or words", text[:200])])
    return Axis(key, path, values)


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


def alike(name: str, known: Iterable[str]) -> list[str]:
    """Figures of several followers, and of all together, that end as a name does which is none of them."""
    last = name.rpartition(".")[2]
    return [one for one in known if (one.startswith("followers.") and one.endswith(f".{name}"))
            or one == f"together.{last}"]  # fmt: skip


PLAY = {"follower.clearance": 1.0, "cam.running_clearance": 0.5}
"""keys of the play that a body is cut with, as shares of the play between two contacts"""


SWITCH = {"true": True, "false": False}
"""words of the command line for a key that is no text"""


def replaced(data: Any, path: Sequence[str | int], value: Value, key: str) -> Any:
    """The data with the value at a path replaced, or added to a table; the words true and false are those of a switch,
    unless the key holds a text. Raises ProfileError where the path breaks."""
    switched = SWITCH.get(value, value) if isinstance(value, str) and not isinstance(_at(data, path), str) else value
    return text_module.replaced(data, tuple(path), switched, f"--vary {key}")


def _at(data: Any, path: Sequence[str | int]) -> Any:
    """What stands at a path, None where nothing does."""
    for part in path:
        inside = part in data if isinstance(data, dict) else isinstance(data, tuple) and part in range(len(data))
        data = data[part] if inside else None
    return data


@final
@immutable(eq=True)
class Study:
    """A profile's data (as `profile_text.load` gives it), the axes, and what is measured of each variant.

    points  variants one by one, a value for each axis; without, the grid of all values of the axes
    """

    data: Data
    file: str
    axes: tuple[Axis, ...]
    measure: Measure
    points: tuple[tuple[Value, ...], ...] | None = None
    plan: Plan | None = None
    """how the axes are combined and what is tied to them; the grid of the axes where it is None"""
    most: int = MOST_VARIANTS
    wanted: tuple[str, ...] = ()
    """names of the figures that rows keep; all where none is named"""

    def __post_init__(self) -> None:
        grown = self.points is None and (self.plan is None or not self.plan.drawn)
        most = MOST_AXES if grown else MOST_DRAWN_AXES
        if not 1 <= len(self.axes) <= most:
            raise ProfileError([Problem("--vary", "a study needs axes", len(self.axes), f"1 to {most}")])
        keys = [one.key for one in self.axes]
        if len(set(keys)) < len(keys):
            raise ProfileError([Problem("--vary", "a key is varied twice", ", ".join(keys))])
        if len(self) > self.most:
            text = "too many variants for the exact model"
            raise ProfileError([Problem("--vary", text, len(self), f"at most {self.most}")])
        # A wrong path or an unknown key is one mistake of the study, not a reason in every row.
        self._refuse_unknown(self.variant(self._typical()))

    def _typical(self) -> tuple[Value, ...]:
        """Values of a variant, the first where none has to be drawn for it."""
        if self.points is None and self.plan is not None and self.plan.drawn:
            return self.plan.undrawn(self.data)
        return self.values(range(1))[0]

    def __len__(self) -> int:
        if self.points is not None:
            return len(self.points)
        if self.plan is not None:
            return len(self.plan)
        return math.prod(len(one.values) for one in self.axes)

    @property
    def varied(self) -> tuple[Axis | Tie, ...]:
        """The keys of a row, in order: those varied, and those tied to them."""
        return self.axes if self.plan is None else (*self.axes, *self.plan.ties)

    def variant(self, values: Sequence[Value]) -> Data:
        """The profile's data with one value for each axis; a body that states its play has that of [impact]."""
        data = self.data
        for one, value in zip(self.varied, values, strict=True):
            data = replaced(data, one.path, value, one.key)
            if one.key == "impact.clearance" and isinstance(value, int | float):
                for key, share in PLAY.items():
                    table, _, name = key.partition(".")
                    if data.get(table, {}).get(name) and key not in [other.key for other in self.varied]:
                        data = replaced(data, (table, name), share * value, key)
        return data

    def _refuse_unknown(self, data: Data) -> None:
        from camgeom.profile import from_data

        try:
            from_data(data, self.file)
        except ProfileError as error:
            keys = {one.key for one in self.varied}
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

    def values(self, piece: range) -> list[tuple[Value, ...]]:
        """Values of the axes of the variants of these numbers, in the order of the grid."""
        if self.points is not None:
            return list(self.points[piece.start : piece.stop])
        if self.plan is not None:
            columns = self.plan.columns(piece, self.data).values()
            plain = (column.tolist() if isinstance(column, np.ndarray) else column for column in columns)
            return list(zip(*plain))
        counts = [len(one.values) for one in self.axes]
        below = [math.prod(counts[i + 1 :]) for i in range(len(counts))]
        return [tuple(one.values[n // b % c] for one, b, c in zip(self.axes, below, counts)) for n in piece]

    def described(self) -> dict[str, Any]:
        """All that its rows rest on but what is measured, as plain data: the profile, the variants, files of others."""
        copies = (*self.copies(), *loaded_copies())
        return {
            "camgeom": __version__,
            "profile": self.data,
            "varied": {one.key: list(one.values) for one in self.axes},
            "points": self.points,
            "plan": self.plan.described() if self.plan is not None else "grid",
            "files": {Path(name).name: sha256(content).hexdigest() for name, content in copies},
        }

    def copies(self) -> tuple[tuple[str, bytes], ...]:
        """The data files that the profile and its variants name, relative to it, with what stands in them."""
        named = [value for one in self.axes if one.path[-1] == "file" for value in one.values]
        names = dict.fromkeys(str(value) for value in (*_under(self.data, "file"), *named))
        folder = Path(self.file).parent if self.file else None
        places = {name: beside(name, folder, "file") for name in names}
        return tuple(
            (name, read_bytes(place, MAX_TABLE_BYTES, name))
            for name, place in places.items()
            if not isinstance(place, Problem)  # its rows say so
        )

    def rows(self, engine: Engine) -> Iterator[Row]:
        """Every variant in order."""
        ready: dict[int, list[Row]] = {}
        coming = 0
        for piece, rows in self.pieces(engine, [range(len(self))]):
            ready[piece.start] = rows
            while coming in ready:
                found = ready.pop(coming)
                coming += len(found)
                yield from found

    def pieces(self, engine: Engine, wanted: Iterable[range]) -> Iterator[tuple[range, list[Row]]]:
        """The rows of these numbers, piece by piece in the order in which the engine has them ready.

        The first are computed here: worker processes take longer to begin than a short study takes.
        """
        cut = Cutter(wanted, engine.width)
        rows, took = self.computed((self.values(range(n, n + 1))[0] for n in cut.first), ALONE_FOR)
        if rows:
            self._refuse_absent(rows)
            cut.took(len(rows), took)
            yield cut.next(len(rows)), self._named(rows)
        work = partial(_piece, self, self.copies())
        for piece, result in engine.run(work, cut, self.values):
            if result is None:
                yield piece, self._named(self._one_by_one(engine, work, piece))
            else:
                cut.took(len(piece), result[1])
                yield piece, self._named(result[0])

    def _named(self, rows: list[Row]) -> list[Row]:
        """Rows with the figures that are wanted alone; what was not judged is told of every one."""
        if not self.wanted:
            return rows
        kept = {*self.wanted, "not_judged"}
        return [replace(row, figures={key: row.figures[key] for key in row.figures if key in kept}) for row in rows]

    def _refuse_absent(self, rows: list[Row]) -> None:
        """Raise ProfileError for a wanted figure that neither the first rows nor the last variant of all has."""
        known = {key for row in rows for key in row.figures}
        absent = [key for key in self.wanted if key not in known]
        if not absent or not known:
            return
        last = len(self) - 1
        known |= self.row(self.values(range(last, last + 1))[0])[0].figures.keys()
        advice = "figures are named as in result.json, joined by dots: contact.peak_pressure_mpa"
        unknown = []
        for key in absent:
            if key not in known:
                several = alike(key, sorted(known))
                hint = f"one of {', '.join(several)}" if several else did_you_mean(key, known) or advice
                unknown.append(Problem("--figures", "no variant has the figure", key, "", hint))
        if unknown:
            raise ProfileError(unknown)

    def _one_by_one(self, engine: Engine, work: Work, piece: range) -> list[Row]:
        """A piece whose workers died, each variant alone: the one that ends its worker is a row that says so."""
        found: dict[int, Row] = {}
        for one, result in engine.run(work, (range(n, n + 1) for n in piece), self.values):
            lost = Row(self.values(one)[0], {}, "no result", "its worker process ended each time (out of memory?)")
            found[one.start] = lost if result is None else result[0][0]
        return [found[n] for n in piece]

    def computed(self, variants: Iterable[tuple[Value, ...]], within: float = math.inf) -> tuple[list[Row], float]:
        """Rows of these variants, of the first of them where they take longer than `within`; and the seconds."""
        rows: list[Row] = []
        model, took, began = None, 0.0, perf_counter()
        for values in variants:
            if took >= within:
                break
            row, model = self.row(values, model)
            rows.append(row)
            took = perf_counter() - began
        return rows, took


def _piece(
    study: Study, copies: tuple[tuple[str, bytes], ...], piece: range, variants: Variants
) -> tuple[list[Row], float]:
    """Rows of a piece in a process that may have none of the profile's files: they are laid beside it again."""
    if not copies:
        return study.computed(variants)
    with TemporaryDirectory(prefix="camgeom-") as folder:
        for name, content in copies:
            place = Path(folder, name)
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(content)
        return replace(study, file=str(Path(folder, Path(study.file).name))).computed(variants)


OVERRIDDEN: dict[tuple[str | int, ...], str] = {
    ("operation", "speed"): "speed", ("lubricant", "temperature"): "temperature",
}  # fmt: skip
"""keys that a profile needs, and that of a state which stands in their place"""


def refuse_unsolved(data: dict[str, Any], axes: Sequence[Axis]) -> None:
    """Raise ProfileError for keys whose rows would be equal: of a solver's table that the profile does not have, and
    those in whose place every operating state has its own."""
    for one in axes:
        table = one.path[0]
        if table in ("dynamics", "impact") and table not in data:
            text = f"the profile has no [{table}] table, so nothing is solved that this key changes"
            hint = f"give the profile an [{table}] table first (camgeom schema lists its keys)"
            raise ProfileError([Problem(f"--vary {one.key}", text, None, "", hint)])
        states, own = data.get("duty") or (), OVERRIDDEN.get(tuple(one.path))
        if own and states and all(isinstance(state, Mapping) and own in state for state in states):
            text = f"every state of [[duty]] has a {own} of its own, so nothing hangs on this key"
            raise ProfileError([Problem(f"--vary {one.key}", text, None, "", f"vary duty[0].{own}")])


def figures_of(study: Study, rows: Sequence[Row]) -> list[str]:
    """Names of the figures that rows have, those that were asked for first and in that order."""
    known = dict.fromkeys(key for row in rows for key in row.figures)
    return [*(key for key in dict.fromkeys(study.wanted) if key in known),
            *(key for key in known if key not in study.wanted)]  # fmt: skip


def columns(study: Study, rows: Sequence[Row]) -> dict[str, list[Any]]:
    """The rows by columns; a varied key is of words in every row where it is in one."""
    figures = figures_of(study, rows)
    found: dict[str, list[Any]] = {}
    for i, one in enumerate(study.varied):
        words = any(isinstance(row.values[i], str) for row in rows)
        found[one.key] = [str(row.values[i]) if words else row.values[i] for row in rows]
    found |= {key: [row.figures.get(key) for row in rows] for key in figures}
    return {**found, "verdict": [row.verdict for row in rows], "reason": [row.reason for row in rows]}


def _under(data: Any, key: str) -> Iterator[Any]:
    """Every value that stands under a key, at any depth."""
    for name, value in data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, tuple) else ():
        if name == key:
            yield value
        else:
            yield from _under(value, key)


GEOMETRY = ("setup", "mechanism", "tracks", "cutters", "flanks", "clearances", "turret")
"""Facts of a model that rest on cam, follower, roller and motion alone."""
SHAPE = ("parts", "solids", "walls")
"""Facts of its body that rest on them, on the tool's corner and on [output]."""
LOADING = frozenset({"name", "operation", "duty", "station", "material", "lubricant", "limits", "drawing", "dynamics",
                     "impact", "cutter", "tolerance", "output_shaft"})  # fmt: skip
"""sections of a profile on which none of these rest, but for the corner of the [cutter]"""


def _take_over(model: Model, before: Model | None) -> None:
    """Give the model the geometry of one that differs in speed, load, material or limits only."""
    if before is None or before.tolerance != model.tolerance:
        return
    old, new = before.profile, model.profile
    # A section that is not known to leave the geometry as it is may change it: the tool's corner rounds a root, the
    # way of meshing makes another mesh.
    named = (name for name in type(new).model_fields if name not in LOADING)
    corners = [one.cutter_spec.corner_radius if one.cutter_spec else 0.0 for one in (old, new)]
    if corners[0] == corners[1] and all(getattr(old, name) == getattr(new, name) for name in named):
        shape = (*SHAPE, "mass") if old.material == new.material else SHAPE
        # Facts are kept under their names in the instance, where the next access finds them.
        for to, source, names in ((model, before, GEOMETRY), (model.body, before.body, shape)):
            vars(to).update({name: vars(source)[name] for name in names if name in vars(source)})
