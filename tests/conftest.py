"""One thread for the linear algebra, and what decides whether a marked test can run: OpenGL, the OpenCASCADE judge."""

from __future__ import annotations

import os
from functools import cache

import pytest
from hypothesis import settings

# As camgeom/__main__.py sets it, and before numpy is imported: two workers whose linear algebra starts two threads each
# spend half of the processor's time waiting for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# How long an example takes says how busy the machine is.
settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")


@cache
def _missing(marker: str) -> str:
    """Why tests with a marker cannot run on this machine; empty where they can."""
    if marker == "opengl":
        from camgeom.report import painter

        return "" if painter.draws() else "no OpenGL library works here"
    from scripts.judge_step import available

    return "" if available() else "no OpenCASCADE: scripts/judge_step.py --install"


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what this machine has no library for."""
    for marker in ("opengl", "opencascade"):
        if item.get_closest_marker(marker) and (reason := _missing(marker)):
            pytest.skip(reason)
