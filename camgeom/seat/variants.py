"""Studies from a program: profile keys varied, the figures of every variant as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, final

import numpy as np
import numpy.typing as npt

from camgeom.design import light_checks
from camgeom.design.engine import Alone, local
from camgeom.design.sampling import Plan
from camgeom.design.sampling import tie as _tie
from camgeom.design.study import Axis, Figures, Row, Study
from camgeom.errors import CamgeomError, Problem, ProfileError
from camgeom.profile.text import key_path
from camgeom.report.delivery import finite
from camgeom.report.result import PRODUCTS, chosen, compute

if TYPE_CHECKING:
    from camgeom.checks.verdict import Verdict
    from camgeom.model import Model

STUDIED = ("motion", "blank", "flank", "checks", "contact", "fatigue")
"""Products of a study where none are named: everything that needs no solid."""
MOVING = ("dynamics", "impact", "operation")
"""tables of a profile whose keys, when they are varied, ask for the dynamics too"""
OVERRIDDEN: dict[tuple[str | int, ...], str] = {
    ("operation", "speed"): "speed", ("lubricant", "temperature"): "temperature",
}  # fmt: skip
"""keys that a profile needs, and that of a state which stands in their place"""
OF_TABLES = ("dynamics", "cutter", "tolerance")
"""products of a table of the profile, whose checks judge them"""


def asked(
    only: Sequence[str] | None, data: dict[str, Any], axes: Sequence[Axis], figures: Sequence[str]
) -> tuple[tuple[str, ...], tuple[str, ...] | None]:
    """Products and checks of a study: those named, with the checks of a named table's product; without any all that
    needs no solid, and what the varied keys, a [tolerance] table and the figures ask for beside."""
    if only is not None:
        from camgeom.checks import checks

        products, named = chosen("run", only)
        tables = set(products) & set(OF_TABLES)
        if named is None and tables:
            named = tuple(name for name, one in checks().items() if tables & set(one.needs))
            products = (*products, "checks")
        return products, named
    wanted = {figure.partition(".")[0] for figure in figures} & set(PRODUCTS) - {"exports", "report"}
    if ("dynamics" in data or "impact" in data) and any(one.path[0] in MOVING for one in axes):
        wanted.add("dynamics")
    if any(one.path[0] == "cutter" for one in axes):
        wanted.add("cutter")
    if "tolerance" in data or any(one.path[0] == "tolerance" for one in axes):
        wanted.add("tolerance")
    beside = (name for name in PRODUCTS if name in wanted - set(STUDIED))
    return (*STUDIED, *beside), light_checks()


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


def columns(study: Study, rows: Sequence[Row]) -> dict[str, list[Any]]:
    """The rows by columns; a varied key is of words in every row where it is in one."""
    figures = dict.fromkeys(key for row in rows for key in row.figures)
    found: dict[str, list[Any]] = {}
    for i, one in enumerate(study.varied):
        words = any(isinstance(row.values[i], str) for row in rows)
        found[one.key] = [str(row.values[i]) if words else row.values[i] for row in rows]
    found |= {key: [row.figures.get(key) for row in rows] for key in figures}
    return {**found, "verdict": [row.verdict for row in rows], "reason": [row.reason for row in rows]}


def measure(
    model: Model, products: tuple[str, ...], checks: tuple[str, ...] | None, only: tuple[str, ...] = ()
) -> tuple[Figures, str, str]:
    """The figures of one variant (of these names; default all), its verdict and the reason of that."""
    result = compute(model, products, checks)
    figures: Figures = {}
    for section in ("motion", "blank", "flank", "solid", "contact", "output_shaft", "fatigue", "dynamics", "impact",
                    "cutter", "tolerance", "body"):  # fmt: skip
        figures |= _flat(result.data.get(section, {}), section)
    for row in result.data.get("fatigue", {}).get("conventions", ()):
        figures |= _flat(row, f"fatigue.conventions.{row['convention'].replace(', ', '-')}")
    for finding in result.findings:
        name = f"checks.{finding.check}" + (f" {finding.where}" if f"checks.{finding.check}" in figures else "")
        figures[name] = finite(finding.value)
    failed = [finding.check for finding in result.findings if not finding.passed]
    unmade = [product.reason for product in result.products if product.exit_status]
    words = {0: result.verdict.level, 1: "fail", 2: "bad input", 3: "no result"}
    if result.verdict.loads is not None:
        figures["loads"] = result.verdict.loads.whose
    figures = {name: value for name, value in figures.items() if not only or name in only}
    figures["not_judged"] = _not_judged(model, result.verdict, checks if "checks" in products else ())
    return figures, words[result.exit_status], "; ".join(dict.fromkeys([*unmade, *failed]))


def _not_judged(model: Model, verdict: Verdict, checks: tuple[str, ...] | None) -> str:
    """Names of the checks that a variant's verdict leaves out: told by the verdict, or not asked for by the study."""
    from camgeom.checks import applies
    from camgeom.checks import checks as registered

    asked = registered(model).items() if checks is not None else ()
    left = [name for name, entry in asked if name not in (checks or ()) and applies(entry, model)]
    return " ".join(dict.fromkeys([*(omitted.check for omitted in verdict.not_judged), *left]))


MOST_LISTED = 6
"""numbers of a list that are columns of their own; longer lists are curves"""


def _flat(data: dict[str, Any], name: str) -> Figures:
    """The numbers of a table and of the tables and short lists in it, by dotted names; lists count from 1."""
    found: Figures = {}
    for key, value in data.items():
        if isinstance(value, list) and len(value) <= MOST_LISTED:
            value = {str(i): one for i, one in enumerate(value, 1) if isinstance(one, int | float)}
        if isinstance(value, dict):
            found |= _flat(value, f"{name}.{key}")
        elif value is None or isinstance(value, bool | int | float):
            found[f"{name}.{key}"] = finite(value)
    return found


@final
class Results(Mapping[str, npt.NDArray[Any]]):
    """The rows of a study by columns: varied keys, figures by their names in result.json, verdict and reason.

    Numbers are arrays (n,) of floats, NaN-free where every variant has the figure; a figure that some variant lacks is
    an array of objects with None there. Words are arrays of objects.
    """

    def __init__(self, columns: Mapping[str, Sequence[Any]]) -> None:
        self._columns = {key: _array(values) for key, values in columns.items()}

    def __getitem__(self, key: str) -> npt.NDArray[Any]:
        return self._columns[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    @property
    def passed(self) -> npt.NDArray[np.bool_]:
        """The variants (n,) that pass or warn, of what was judged."""
        return np.isin(self["verdict"].astype(str), ("pass", "warn"))

    def to_pandas(self) -> Any:
        """The same as a pandas.DataFrame. Raises CamgeomError where pandas is not installed."""
        try:
            import pandas
        except ImportError:
            raise CamgeomError("a DataFrame needs pandas: pip install pandas") from None
        return pandas.DataFrame(dict(self))

    def __repr__(self) -> str:
        return f"<camgeom study: {len(self['verdict'])} variants, {len(self)} columns>"


def _array(values: Sequence[Any]) -> npt.NDArray[Any]:
    number = all(isinstance(value, int | float) for value in values)
    found = np.array(values, dtype=float) if number else np.array([*values, None], dtype=object)[:-1]
    found.setflags(write=False)
    return found


def study(
    model: Model,
    vary: Mapping[str, Sequence[Any]],
    *,
    tie: Mapping[str, str] | None = None,
    only: Sequence[str] | None = None,
    figures: Sequence[str] = (),
    jobs: int = 1,
) -> Results:
    """Every combination of the values of the varied keys, computed by the exact model; a variant a row.

        found = camgeom.study(model, {"cam.diameter": [120, 130, 140], "operation.speed": [300, 600]})
        found["contact.peak_pressure_mpa"][found.passed]

    vary     dotted keys of the profile with their values; the last varies fastest
    tie      keys that follow others by an expression: {"cam.bore": "0.4*cam.base_radius"}
    only     products as of `camgeom study --only`; default all that needs no solid, and what the keys ask for
    figures  only these columns of figures; default all
    jobs     worker processes; more than one needs the `if __name__ == "__main__":` of every such program

    A variant that is bad input or fails is a row too, with its reason. Raises ProfileError for a key that is none.
    """
    axes = tuple(_axis(key, values) for key, values in vary.items())
    data = model.profile.stated
    refuse_unsolved(data, axes)
    products, judging = asked(only, data, axes, figures)
    measured = partial(measure, products=products, checks=judging, only=tuple(figures))
    ties = tuple(_tie(f"{key}={text}") for key, text in (tie or {}).items())
    plan = Plan(axes, "grid", 0, 0, ties) if ties else None
    whole = Study(data, model.profile.source, axes, measured, plan=plan)
    return Results(columns(whole, list(whole.rows(Alone() if jobs == 1 else local(jobs)))))


def _axis(key: str, values: Sequence[Any]) -> Axis:
    path = key_path(key)
    words = [values] if isinstance(values, str) else values
    plain = tuple(value.item() if isinstance(value, np.generic) else value for value in words)
    if path is None or not plain or not all(isinstance(value, int | float | str) for value in plain):
        text = "needs a dotted key and its values"
        raise ProfileError([Problem(f"vary {key}", text, values, "for example {'cam.diameter': [120, 130]}")])
    return Axis(key, path, plain)
