"""Whatever is in a file of points: it is read, or refused with ProfileError in one line that names the file."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camgeom.errors import ProfileError
from camgeom.inspection.points import LARGEST, read_points

CELLS = st.one_of(
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.integers(-(10**9), 10**9).map(str),
    st.sampled_from(["", " ", "1,5", "1.5e3", "x", "NaN", '"', "1e400", "0x10", "1_000", "\u0663"]),
)
HEADS = st.lists(st.sampled_from(["x", "y", "z", "angle", "radius_mm", "flank", "note", ""]), min_size=1, max_size=5)
QUIET = settings(
    max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)


def judged(path: Path) -> None:
    points, refusal = None, ""
    try:
        points = read_points(path)
    except ProfileError as error:
        refusal = str(error)
    if points is None:
        assert str(path) in refusal
        assert "\n" not in refusal
        return
    assert points.x.shape[0] == 3
    assert np.all(np.isfinite(points.x))
    assert np.abs(points.x).max() <= LARGEST * math.sqrt(2.0)
    assert points.flank is None or len(points.flank) == points.x.shape[1]


@QUIET
@given(st.binary(max_size=400))
def test_any_bytes(tmp_path: Path, data: bytes) -> None:
    path = tmp_path / "points.csv"
    path.write_bytes(data)
    judged(path)


@QUIET
@given(HEADS, st.lists(st.lists(CELLS, max_size=5), max_size=12), st.sampled_from([",", ";", "\t"]))
def test_any_table(tmp_path: Path, heads: list[str], rows: list[list[str]], separator: str) -> None:
    path = tmp_path / "points.csv"
    text = "\n".join(separator.join(row) for row in [heads, *rows])
    path.write_text(text, encoding="utf-8", errors="surrogateescape")
    judged(path)
