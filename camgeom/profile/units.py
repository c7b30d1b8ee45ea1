"""Profiles whose lengths are inches: what is converted to the mm of all that follows, and what says so.

Lengths are the keys whose meaning begins with mm, and lifts of a follower that translates: `to`, the rates of a
segment per degree, lifts among a law's parameters. A key whose name carries its unit (`min_wall_mm`) keeps it, and so
does every other quantity: deg, r/min, N, N/mm, N m, MPa, kg, mm/s, mm/min, mm2/s, um.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from math import isclose
from typing import Any

from pydantic import BaseModel

from camgeom.errors import Problem
from camgeom.motion.catalogue import LAWS
from camgeom.motion.law import Parameter
from camgeom.profile.errors import OF_SLIDE, keys_of, models_in
from camgeom.profile.sections import INCH
from camgeom.profile.text import Path_, dotted, key_path

_LENGTH = re.compile(r"mm(?![\w/²³^])")


def is_length(key: str, meaning: str, rotating: bool) -> bool:
    """Whether a key of this meaning is a length of the follower's kind, and stands in the unit of the profile."""
    if key.endswith("_mm"):
        return False
    return not rotating if OF_SLIDE.match(meaning) else bool(_LENGTH.match(meaning))


def in_mm(
    data: Mapping[str, Any], sections: Mapping[str, Sequence[type[BaseModel]]], rotating: bool, slides: bool = False
) -> tuple[dict[str, Any], list[Problem]]:
    """The data of a profile in inches with its lengths in mm, and what cannot be converted.

    sections  the model of every section, by its name; slides: the motion stands over a travel and not over an angle
    """
    found: list[Problem] = []
    made = dict(data)
    for name, models in sections.items():
        if name in data and "." not in name and name != "profile":
            made[name] = _converted(data[name], models, (name,), rotating, found)
    if slides and isinstance(segments := data.get("motion"), tuple):
        made["motion"] = tuple(_over_travel(*pair, rotating) for pair in zip(made["motion"], segments))
    return made, found


def _over_travel(made: Any, stated: Any, rotating: bool) -> Any:
    """A segment over a travel in inches: where it ends is a length, and its rates are lengths, or angles, per length.
    """
    if not isinstance(made, dict) or not isinstance(stated, dict):
        return made
    rates = {key: power - rotating for key, power in TRAVEL_RATES.items() if key in stated}
    powers = rates | ({"until": 1} if "until" in stated else {})
    return {**made, **{key: _scaled(stated[key], INCH**power) for key, power in powers.items()}}


TRAVEL_RATES = {"velocity": 0, "acceleration": -1, "jerk": -2}
"""powers of a length in the rates of a lift that is a length, over a travel"""


def _converted(
    data: Any, models: Sequence[type[BaseModel]], at: Path_, rotating: bool, found: list[Problem]
) -> Any:
    """A table, or each of an array of tables, with its lengths in mm."""
    if isinstance(data, tuple):
        return tuple(_converted(one, models, (*at, i), rotating, found) for i, one in enumerate(data))
    if not isinstance(data, dict):
        return data
    fields = {key: field for model in models for key, field in keys_of(model).items()}
    law = LAWS.get(str(data.get("law"))) if at[0] == "motion" else None
    made = {}
    for key, value in data.items():
        path = (*at, key)
        if key in fields:
            meaning = fields[key].description or ""
            inner = list(models_in(fields[key].annotation))
            if is_length(key, meaning, rotating):
                value = _scaled(value)
            elif inner:
                value = _converted(value, inner, path, rotating, found)
            elif key == "expression" and not rotating:
                found += _in_lifts(value, path)
        elif law is not None and key in law.parameters and not rotating:
            value, problems = _lifts(value, law.parameters[key], path)
            found += problems
        made[key] = value
    return made


def _scaled(value: Any, by: float = INCH) -> Any:
    """Every number of a value in mm: of an array, and of a table that scatters about a length."""
    if isinstance(value, dict):
        return {key: _scaled(one, by) for key, one in value.items()}
    if isinstance(value, tuple):
        return tuple(_scaled(one, by) for one in value)
    if not isinstance(value, int | float) or isinstance(value, bool):
        return value
    # 0.75 in is 19.05 mm, as it is printed, and not the 19.049999999999997 of the product.
    return float(f"{by * value:.15g}")


def _lifts(value: Any, parameter: Parameter, path: Path_) -> tuple[Any, list[Problem]]:
    """A law's parameter with its lifts in mm: the numbers of a list, or the last of each of its rows."""
    if parameter.lift == "":
        return value, []
    if parameter.lift == "refused":
        text = "its lifts are mm; a profile in inches has them inline"
        return value, [Problem(dotted(path), text, value, "", 'give `rows`, or units = "mm"')]
    if parameter.lift == "number":
        return (_scaled(value) if isinstance(value, int | float) and value > 0.0 else value), []
    if not isinstance(value, tuple):
        return value, []
    rows = ((*one[:-1], _scaled(one[-1])) if isinstance(one, tuple) and one else _scaled(one) for one in value)
    return tuple(rows), []


def _in_lifts(expression: Any, path: Path_) -> list[Problem]:
    """Why a force that hangs on the lift has no place in a profile in inches."""
    named = re.findall(r"\b[sva]\b", expression) if isinstance(expression, str) else []
    if not named:
        return []
    text = f"{', '.join(dict.fromkeys(named))}: lift, velocity and acceleration are mm here, in a profile in inches"
    return [Problem(dotted(path), text, expression, "phi and deg", 'give a table, or units = "mm"')]


def as_stated(problems: Iterable[Problem], data: Mapping[str, Any]) -> list[Problem]:
    """The problems of a profile in inches with what it states beside each length in mm."""
    return [_beside(problem, data) for problem in problems]


def _beside(problem: Problem, data: Any) -> Problem:
    here = data
    for part in key_path(problem.key) or ():
        if isinstance(part, int):
            here = here[part] if isinstance(here, tuple) and part < len(here) else None
        else:
            here = here.get(part) if isinstance(here, dict) else None
    given, value = here, problem.value
    if not isinstance(given, int | float) or not isinstance(value, int | float) or value == given:
        return problem
    if not isclose(value, INCH * given, rel_tol=1e-12):
        return problem
    hint = f"stated as {given:.15g} in"
    return replace(problem, hint=f"{problem.hint}; {hint}" if problem.hint else hint)
