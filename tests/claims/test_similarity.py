"""A cam twice as large, under four times the force at the same speed, is the same cam: every figure of every check goes
with the power of length of its unit. Whatever breaks it, a length, a force, a mass, is hidden in the product."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from camgeom.checks import judge
from camgeom.profile.schema import schema
from tests.reference.profiles import Data, built, data_of

SIZE = 2.0
POWER = {"mm": 1, "um": 1, "N": 2, "N mm": 3, "N m": 3, "N/mm": 1, "kg": 1, "kg m2": 3, "m/s2": 1, "mm/s": 1, "W": 3,
         "1/mm": -1, "mm/s2": 1}  # fmt: skip
"""of lengths in a unit where stresses and speeds stay: forces go with the square, masses with the length, inertias with
the cube"""
TURNING = {"friction": 3, "spring_rate": 3, "spring_preload": 3, "inertia": 3, "load_inertia": 3, "to": 0}
SLIDING = {"friction": 2, "spring_rate": 1, "spring_preload": 2, "to": 1}
BOTH = {"keyway_width": 1, "keyway_depth": 1}
LEFT = ("name", "reproduces", "drawing", "cutter", "output", "dynamics", "impact", "tolerance", "body")


def _meanings(node: Any, found: dict[str, set[str]]) -> dict[str, set[str]]:
    """First words of the meanings of all keys of a schema."""
    if isinstance(node, dict):
        for key, value in (node.get("properties") or {}).items():
            found.setdefault(key, set()).add(value.get("description", "").split(",")[0].split(":")[0].strip())
        for value in node.values():
            _meanings(value, found)
    elif isinstance(node, list):
        for value in node:
            _meanings(value, found)
    return found


def _larger(data: Data) -> Data:
    slides = data["follower"]["kind"] in ("translating", "frame", "yoke")
    known = BOTH | (SLIDING if slides else TURNING)

    def grown(section: str, node: Any) -> Any:
        if isinstance(node, list | tuple):
            return tuple(grown(section, each) for each in node)
        if not isinstance(node, dict):
            return node
        sizes = {key: power(section, key) if isinstance(value, int | float) else 0 for key, value in node.items()}
        return {key: value * SIZE ** sizes[key] if sizes[key] else grown(section, value)
                for key, value in node.items()}  # fmt: skip

    @cache
    def power(section: str, key: str) -> int:
        ends = {"_mm": 1, "_n_m": 3, "_n": 2}
        if key in known:
            return known[key]
        named = next((size for end, size in ends.items() if key.endswith(end)), None)
        meant = _meanings(schema()["properties"][section], {}).get(key, set())
        return named if named is not None else next((POWER[one] for one in meant if one in POWER), 0)

    whole = {section: grown(section, node) for section, node in data.items()}
    # A wall of a millimetre is asked for by default, a density stays.
    whole.setdefault("limits", {}).setdefault("min_wall_mm", SIZE * 1.0)
    return whole


@pytest.mark.parametrize("name", ["pin_insertion", "disc_flat_face", "tool_changer", "parallel_index"])
def test_a_cam_twice_as_large_is_the_same_cam(name: str) -> None:
    data = {key: value for key, value in data_of(name).items() if key not in LEFT}
    if "output_shaft" in data:
        # Threads come in sizes of their own.
        data["output_shaft"] = {key: value for key, value in data["output_shaft"].items() if "bolt" not in key}
    mesh = {"output": {"tolerance": 0.01}}, {"output": {"tolerance": SIZE * 0.01}}
    one, other = (judge(built(dict(each) | out)) for each, out in zip((data, _larger(data)), mesh))
    assert [(f.check, f.level) for f in one.findings] == [(f.check, f.level) for f in other.findings]
    assert [word.check for word in one.not_judged] == [word.check for word in other.not_judged]
    for found, twice in zip(one.findings, other.findings):
        if found.value is None or found.check in ("chord-error", "backlash", "interference"):
            continue
        wanted = found.value * SIZE ** POWER.get(found.unit, 0)
        # Where a roller's rim begins its turn is sought among steps.
        within = 1e-3 if found.check == "life" else 1e-6
        assert twice.value == pytest.approx(wanted, rel=within, abs=1e-9), (found, twice)
