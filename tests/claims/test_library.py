"""A model as a library: what it hands out cannot be changed, each fact is computed once, also by many threads."""

import json
import os
import pickle
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from hashlib import sha256
from pathlib import Path
from threading import Barrier

import numpy as np
import pytest

import camgeom
from camgeom.errors import CamgeomError
from camgeom.model import Model
from camgeom.profile import parse, read
from camgeom.report.files import format_rows
from tests.places import CAMGEOM, PROFILES

SHAPES = ("pin_insertion", "disc_offset_roller", "conjugate_rocker", "tool_changer", "disc_flat_face", "conical_disc",
          "conical_guide", "linear_edge", "bell_lifter")  # fmt: skip
DEEPEST = 4
"""attributes of attributes that are followed from the model; some make new objects of their own kind without end"""

SOLVED = ("Model.root_stress", "MachineStudy.widest")
"""a minute of finite elements and ten seconds of search: tests/body and tests/tolerance ask them"""


def attributes(thing: object) -> list[str]:
    """Names of the public attributes of an object, computed ones included, methods not."""
    named = {name for name in vars(thing) if not name.startswith("_")} if hasattr(thing, "__dict__") else set()
    for kind in type(thing).__mro__:
        if kind.__module__.startswith("camgeom."):
            for name, value in list(vars(kind).items()):
                computed = isinstance(value, property) or (hasattr(value, "__get__") and not callable(value))
                if computed and not name.startswith("_") and f"{kind.__name__}.{name}" not in SOLVED:
                    named.add(name)
    return sorted(named)


def arrays(model: Model) -> Iterator[tuple[str, np.ndarray]]:
    """Every array that can be reached from a model by public attributes, with the path to it."""
    seen: dict[int, object] = {}
    waiting: list[tuple[str, object]] = [("model", model)]
    while waiting:
        path, thing = waiting.pop()
        if isinstance(thing, np.ndarray):
            yield path, thing
            continue
        if id(thing) in seen or path.count(".") > DEEPEST:
            continue
        seen[id(thing)] = thing  # kept, so that no id is given twice
        if isinstance(thing, tuple | list):
            waiting += [(f"{path}[{i}]", item) for i, item in enumerate(thing[:3])]
        elif isinstance(thing, dict):
            waiting += [(f"{path}[{key}]", item) for key, item in thing.items()]
        elif type(thing).__module__.startswith("camgeom."):
            for name in attributes(thing):
                try:
                    waiting.append((f"{path}.{name}", getattr(thing, name)))
                except CamgeomError:
                    continue


def sources_with(pattern: str) -> list[str]:
    """Names of the package's files in which a pattern stands."""
    return [path.name for path in CAMGEOM.rglob("*.py") if re.search(pattern, path.read_text())]


@pytest.mark.parametrize("name", SHAPES)
def test_no_array_that_a_model_hands_out_can_be_written_into(name: str) -> None:
    reached = dict(arrays(camgeom.read(str(PROFILES / f"{name}.toml"))))
    assert len(reached) > 40
    assert [path for path, array in reached.items() if array.flags.writeable] == []


def test_every_cached_property_freezes_its_arrays() -> None:
    assert sources_with(r"from functools import .*cached_property") == []


@pytest.mark.parametrize("name", ["profile", "tolerance", "body", "number", "solid", "anything"])
def test_nothing_of_a_model_can_be_set(name: str) -> None:
    model = camgeom.read(str(PROFILES / "disc_flat_face.toml"))
    before = getattr(model, name, None)
    with pytest.raises(AttributeError, match="cannot be set"):
        setattr(model, name, before)
    with pytest.raises(AttributeError, match="cannot be set"):
        model.body.tolerance = 1.0
    assert camgeom.read(str(PROFILES / "disc_flat_face.toml")).tolerance == model.tolerance


def test_eight_threads_compute_each_fact_once_and_see_one_value() -> None:
    begun: list[str] = []
    profile = read(PROFILES / "pin_insertion.toml")
    model = Model(profile, 0.02, lambda event, name, seconds: begun.append(name) if event == "start" else None)
    together = Barrier(8)

    def ask(i: int) -> tuple[object, ...]:
        together.wait()
        wanted = ("solid", "duty", "clearances", "flanks") if i % 2 else ("flanks", "clearances", "duty", "solid")
        facts = {name: getattr(model, name) for name in wanted}
        return facts["solid"], facts["duty"], facts["duty"].peak_pressure, facts["flanks"]

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(ask, range(8)))
    assert len(begun) == len(set(begun)) > 5
    assert all(all(mine is first for mine, first in zip(answer, answers[0])) for answer in answers)


def test_a_pickled_model_keeps_its_facts_and_its_followers() -> None:
    model = camgeom.read(str(PROFILES / "disc_flat_face.toml"))
    volume = model.solid.mesh.volume
    again = pickle.loads(pickle.dumps(model))
    assert again.bindings == (again,)
    assert "solids" in vars(again.body)
    assert again.solid.mesh.volume == volume
    assert not again.solid.mesh.vertices.flags.writeable
    assert again.duties == ()
    assert again.drive is not None


@pytest.mark.parametrize(
    ("name", "facts"),
    [
        ("conjugate_rocker", ("impact", "impact_pressure", "impact_lives", "tolerances")),
        ("tool_changer", ("indexing", "dynamic_duties", "start_duties")),
        ("bell_lifter", ("elastic_follower", "dynamic_duties", "start_duties")),
    ],
)
def test_a_model_can_be_pickled_whatever_was_solved_of_it(name: str, facts: tuple[str, ...]) -> None:
    """What a solver is made of may be functions: they are made again."""
    model = camgeom.read(str(PROFILES / f"{name}.toml"))
    assert all(getattr(model, fact) for fact in facts)
    again = pickle.loads(pickle.dumps(model))
    assert set(facts) <= set(vars(again))
    for mine, its in zip(model.dynamic_duties, again.dynamic_duties, strict=True):
        assert its.peak_force == mine.peak_force
    if model.impact is not None:
        times = [0.1 * model.impact.problem.period, 0.7 * model.impact.problem.period]
        assert again.impact.state_at(times) == model.impact.state_at(times)
    if "tolerances" in facts:
        assert again.tolerances.causes == model.tolerances.causes


def test_no_module_sets_a_filter_of_warnings_for_the_whole_process() -> None:
    assert sources_with(r"catch_warnings|simplefilter|filterwarnings") == []


def test_a_fact_that_fails_is_asked_again_and_locks_nobody_out() -> None:
    model = camgeom.read(str(PROFILES / "disc_flat_face.toml"))
    for _ in range(2):
        with pytest.raises(camgeom.DesignError):
            _ = model.duty
    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(lambda: model.planar is not None).result(timeout=30)


def test_attributes_finds_properties_of_all_sorts() -> None:
    model = camgeom.read(str(PROFILES / "disc_flat_face.toml"))
    assert {"solid", "profile", "duty", "mechanism", "bindings"} <= set(attributes(model))


WORKER = """
import os, sys, time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from camgeom.motion.own import begin_worker
if __name__ == "__main__":
    pool = ProcessPoolExecutor(2, get_context("spawn"), begin_worker, ((),))
    print(*{pool.submit(os.getpid).result() for _ in range(4)}, flush=True)
    time.sleep(60)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_workers_end_with_a_parent_that_is_killed(tmp_path: Path) -> None:
    script = tmp_path / "parent.py"
    script.write_text(WORKER)
    environment = {**os.environ, "PYTHONPATH": str(CAMGEOM.parent)}
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True, env=environment) as parent:
        assert parent.stdout is not None
        workers = [int(word) for word in parent.stdout.readline().split()]
        parent.kill()
    assert workers
    until = time.monotonic() + 30.0
    while any(map(alive, workers)) and time.monotonic() < until:
        time.sleep(0.05)
    assert [worker for worker in workers if alive(worker)] == []


def alive(process: int) -> bool:
    """Whether a process runs (one that waits to be collected does not)."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    status = Path(f"/proc/{process}/stat")
    return not (status.exists() and status.read_text().rpartition(")")[2].split()[0] == "Z")


PICTURES = {"png", "gif", "mp4", "webm", "pdf"}
"""drawn by other libraries, films among them"""
DATED = """
import sys
from pathlib import Path
from camgeom.errors import CamgeomError
from camgeom.model import read
from camgeom.report.files import write
model = read(sys.argv[1])
for kind in sys.argv[3:]:
    try:
        write(model, Path(sys.argv[2]) / f"cam.{kind}")
    except CamgeomError:
        continue
"""


def test_the_same_profile_gives_the_same_bytes(tmp_path: Path) -> None:
    kinds = {row["format"] for row in format_rows()} - PICTURES
    made: set[str] = set()
    for name in ("milled_drum", "constant_width_press"):
        digests = []
        for seed in ("1", "2"):
            folder = tmp_path / f"{name} {seed}"
            folder.mkdir()
            environment = {**os.environ, "PYTHONPATH": str(CAMGEOM.parent), "PYTHONHASHSEED": seed}
            environment["SOURCE_DATE_EPOCH"] = "1700000000"
            words = [sys.executable, "-c", DATED, str(PROFILES / f"{name}.toml"), str(folder), *sorted(kinds)]
            subprocess.run(words, check=True, env=environment)
            digests.append({path.name: sha256(path.read_bytes()).hexdigest() for path in folder.iterdir()})
        assert digests[0] == digests[1]
        made |= {file.removeprefix("cam.") for file in digests[0]}
    # Parquet needs a library that need not be there, the other a polydyne motion.
    assert kinds - made <= {"history.parquet", "impact.parquet", "polydyne.csv"}
    assert "2023-11-14T22:13:20" in (tmp_path / "milled_drum 1" / "cam.plcopen.xml").read_text()


@pytest.mark.parametrize("given", ["", "now", "1e9", "9" * 30])
def test_a_date_that_is_none_is_refused(given: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.export import write

    monkeypatch.setenv("SOURCE_DATE_EPOCH", given)
    with pytest.raises(camgeom.CamgeomError, match="SOURCE_DATE_EPOCH: needs whole seconds"):
        write(camgeom.read(str(PROFILES / "disc_flat_face.toml")), tmp_path / "cam.plcopen.xml")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("file", ["plain.toml", "bell\x07.toml", "bad\udcff.toml", "a\u202eb.toml"])
def test_a_file_name_as_name_is_judged_like_a_name(file: str) -> None:
    text = (PROFILES / "disc_flat_face.toml").read_text()
    nameless = "\n".join(line for line in text.splitlines() if not line.startswith("name ="))
    if file == "plain.toml":
        assert parse(nameless, file).name == "plain"
        return
    with pytest.raises(camgeom.ProfileError, match="name: needs a text of 1 to 120 characters"):
        parse(nameless, file)


def test_dictionaries_that_are_handed_out_cannot_be_changed() -> None:
    """Emptied before the checks, the lives took both findings of `life` with them."""
    lives = camgeom.read(PROFILES / "pin_insertion.toml").lives
    for change in (lives.clear, lives.popitem, lambda: lives.update(cam=1.0), lambda: lives.pop("cam"),
                   lambda: lives.setdefault("a", 1.0), lambda: lives.__setitem__("cam", 1.0)):  # fmt: skip
        with pytest.raises(TypeError, match="cannot be changed"):
            change()
    assert pickle.loads(pickle.dumps(lives)) == lives == dict(lives)
    assert json.loads(json.dumps(lives)) == lives
