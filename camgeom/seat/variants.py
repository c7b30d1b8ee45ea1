"""Studies from a program: profile keys varied, the figures of every variant as arrays."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, final

import numpy as np
import numpy.typing as npt

from camgeom.design.engine import Alone, local
from camgeom.design.sampling import Plan
from camgeom.design.sampling import tie as _tie
from camgeom.design.study import Axis, Study, columns, refuse_unsolved
from camgeom.errors import CamgeomError, Problem, ProfileError
from camgeom.profile.text import key_path
from camgeom.report.measured import asked, measure

if TYPE_CHECKING:
    from camgeom.model import Model


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

    A variant that is bad input or fails is a row too, with its reason. Raises ProfileError for a key that is none,
    and for a figure that no variant has.
    """
    axes = tuple(_axis(key, values) for key, values in vary.items())
    data = model.profile.stated
    refuse_unsolved(data, axes)
    products, judging = asked(only, data, {one.path[0] for one in axes}, figures)
    measured = partial(measure, products=products, checks=judging)
    ties = tuple(_tie(f"{key}={text}") for key, text in (tie or {}).items())
    plan = Plan(axes, "grid", 0, 0, ties) if ties else None
    whole = Study(data, model.profile.source, axes, measured, plan=plan, wanted=tuple(figures))
    return Results(columns(whole, list(whole.rows(Alone() if jobs == 1 else local(jobs)))))


def _axis(key: str, values: Sequence[Any]) -> Axis:
    path = key_path(key)
    words = [values] if isinstance(values, str) else values
    plain = tuple(value.item() if isinstance(value, np.generic) else value for value in words)
    if path is None or not plain or not all(isinstance(value, int | float | str) for value in plain):
        text = "needs a dotted key and its values"
        raise ProfileError([Problem(f"vary {key}", text, values, "for example {'cam.diameter': [120, 130]}")])
    return Axis(key, path, plain)
