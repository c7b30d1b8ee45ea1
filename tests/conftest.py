"""What decides here whether a marked test can run: a software OpenGL, the OpenCASCADE judge."""

from __future__ import annotations

from functools import cache

import pytest


@cache
def _missing(marker: str) -> str:
    """Why tests with a marker cannot run on this machine; empty where they can."""
    if marker == "opengl":
        from camgeom.report import views

        return "" if views.opengl_window() is not None else "no OpenGL library works here"
    from scripts.judge_step import available

    return "" if available() else "no OpenCASCADE: scripts/judge_step.py --install"


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip what this machine has no library for."""
    for marker in ("opengl", "opencascade"):
        if item.get_closest_marker(marker) and (reason := _missing(marker)):
            pytest.skip(reason)
