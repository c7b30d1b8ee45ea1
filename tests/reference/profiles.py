"""Models of shipped profiles and starters with keys changed, and what a check says of them; for all tests."""

from __future__ import annotations

import pickle
from functools import lru_cache
from typing import Any

from camgeom.cams import starter
from camgeom.checks import judge
from camgeom.checks.verdict import Finding
from camgeom.model import Model
from camgeom.profile import from_data
from camgeom.profile.text import load
from tests.places import PROFILES
from tests.profile.cases import frozen, put

Data = dict[str, Any]


def data_of(name: str, **changes: Any) -> Data:
    """Plain data of a shipped profile or a starter with keys, dots written as two underscores, changed; None removes
    one."""
    path = PROFILES / f"{name}.toml"
    data, _, _ = load(path.read_text() if path.exists() else starter(name), name)
    return changed(data, **changes)


def changed(data: Data, **changes: Any) -> Data:
    """The same plain data with keys, dots written as two underscores, changed; None removes one."""
    for key, value in changes.items():
        put(data, key.replace("__", "."), value)
    return data


def built(data: Data) -> Model:
    """The model of plain data."""
    return Model(from_data(frozen(data), ""))


def model(name: str, **changes: Any) -> Model:
    """The same as a model, kept for the next test that asks for it: nothing changes a model."""
    return _kept(name, pickle.dumps(changes))


def said(made: Model, check: str) -> list[Finding]:
    """Findings of one check."""
    return list(judge(made, [check]).findings)


@lru_cache(maxsize=48)
def _kept(name: str, changes: bytes) -> Model:
    return Model(from_data(data_of(name, **pickle.loads(changes)), name))


def enlarged(data: dict[str, Any], factor: float) -> dict[str, Any]:
    """The tables of a sliding follower's cam so many times as large: all lengths of [cam], [roller] and the lifts."""

    def lengths(table: dict[str, Any]) -> dict[str, Any]:
        return {key: value if isinstance(value, str) or key == "half_angle" else value * factor
                for key, value in table.items()}  # fmt: skip

    motion = tuple(s | ({"to": s["to"] * factor} if "to" in s else {}) for s in data["motion"])
    return data | {"cam": lengths(data["cam"]), "roller": lengths(data["roller"]), "motion": motion,
                   "output": {"tolerance": min(1.0, 0.01 * factor)}}  # fmt: skip
