"""An interrupt while the geometry engine loads is an interrupt, and waits until it has loaded."""

from __future__ import annotations

import subprocess
import sys
from threading import Thread

import pytest

from camgeom.solid.engine import library

INTERRUPTED = """
import enum, os, signal, sys
import numpy
from camgeom.solid.engine import library

signal.signal(signal.{how}, {handler})
make, count = enum.EnumType.__call__, 0
def interrupting(cls, *given, **named):
    global count
    own = cls.__module__ != "signal"  # whose own are asked for when handlers are set
    count += own
    if own and count == {at}:
        os.kill(os.getpid(), signal.{how})
    return make(cls, *given, **named)
enum.EnumType.__call__ = interrupting
try:
    library()
    print("loaded")
except KeyboardInterrupt:
    print("interrupted", "manifold3d" in sys.modules)
assert count >= {at}, count
"""


@pytest.mark.parametrize("at", [1, 3])
@pytest.mark.parametrize(("handler", "said"), [("signal.default_int_handler", "interrupted True"),
                                               ("signal.SIG_IGN", "loaded")])  # fmt: skip
@pytest.mark.parametrize("how", ["SIGINT", "SIGTERM"])
def test_an_interrupt_waits_while_the_engine_loads(how: str, at: int, handler: str, said: str) -> None:
    """Its enumerations are made by Python, where an interrupt ended the process: "terminate called"."""
    code = INTERRUPTED.format(at=at, handler=handler, how=how)
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.strip(), ended.stderr) == (0, said, "")


def test_the_engine_loads_in_another_thread() -> None:
    code = "from threading import Thread; from camgeom.solid.engine import library\n"
    code += "found = []; thread = Thread(target=lambda: found.append(library())); thread.start(); thread.join()\n"
    code += "print(found[0].__name__)"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout.strip(), ended.stderr) == (0, "manifold3d", "")
    thread = Thread(target=library)
    thread.start()
    thread.join()


def test_an_engine_that_is_missing_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    with pytest.raises(ImportError):
        library()
