"""An interrupt while the geometry engine loads is an interrupt."""

from __future__ import annotations

import builtins

import pytest

from camgeom.solid.engine import library


@pytest.mark.parametrize(
    ("told", "raised"),
    [("Traceback (most recent call last):\n\nKeyboardInterrupt: ", KeyboardInterrupt), ("no such file", ImportError)],
)
def test_an_import_that_an_interrupt_ends(
    monkeypatch: pytest.MonkeyPatch, told: str, raised: type[BaseException]
) -> None:
    real = builtins.__import__

    def loads(name: str, *rest, **named):
        if name == "manifold3d":
            raise ImportError(told)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", loads)
    with pytest.raises(raised):
        library()
