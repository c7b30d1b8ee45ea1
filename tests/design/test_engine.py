"""Who computes the rows of a study: the same rows from every engine, whoever dies on the way."""

from __future__ import annotations

import os
import signal
from functools import partial
from pathlib import Path

import pytest

from camgeom.design import study as study_module
from camgeom.design.engine import GROWTH, PIECE_S, TRIES, Alone, Cluster, Cutter, Engine, Local, Pace, spoken
from camgeom.design.study import Figures, Study, axis
from camgeom.errors import CamgeomError, ProfileError
from camgeom.model import Model
from tests.design.runs import DATA, light


def dying(model: Model, folder: str, at: float, times: int) -> tuple[Figures, str, str]:
    """A measure whose process is killed at one diameter, so many times."""
    if model.profile.cam.diameter == at:  # type: ignore[attr-defined]
        before = len(list(Path(folder).iterdir()))
        if before < times:
            Path(folder, str(before)).touch()
            os.kill(os.getpid(), signal.SIGKILL)
    return light(model)


def made(folder: Path, at: float = 0.0, times: int = 0) -> Study:
    measure = partial(dying, folder=str(folder), at=at, times=times)
    return Study(DATA, "", (axis("cam.diameter=60:100:41"),), measure)


@pytest.fixture
def _at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No row is computed in this process."""
    monkeypatch.setattr(study_module, "ALONE_FOR", 0.0)


@pytest.mark.slow
@pytest.mark.usefixtures("_at_once")
@pytest.mark.parametrize("width", [1, 2])
@pytest.mark.parametrize("times", [1, TRIES - 1])
def test_a_dead_worker_changes_no_row(tmp_path: Path, width: int, times: int) -> None:
    alone = list(made(tmp_path).rows(Alone()))
    assert list(made(tmp_path, 75.0, times).rows(Local(width))) == alone
    assert len(list(tmp_path.iterdir())) == times


@pytest.mark.slow
@pytest.mark.usefixtures("_at_once")
def test_a_variant_that_ends_every_worker_is_a_row_that_says_so(tmp_path: Path) -> None:
    alone = list(made(tmp_path).rows(Alone()))
    rows = list(made(tmp_path, 75.0, 1000).rows(Local(2)))
    lost = [i for i, row in enumerate(rows) if row != alone[i]]
    assert [rows[i].values for i in lost] == [(75,)]
    assert rows[lost[0]].verdict == "no result"
    assert "its worker process ended" in rows[lost[0]].reason


def stillborn(files: tuple[str, ...]) -> None:
    os._exit(1)


@pytest.mark.slow
@pytest.mark.usefixtures("_at_once")
def test_workers_that_cannot_begin_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.design import engine

    monkeypatch.setattr(engine, "begin_worker", stillborn)
    with pytest.raises(CamgeomError, match="end as soon as they begin"):
        list(made(tmp_path).rows(Local(2)))


def told(piece: range, drawn: tuple[range, int]) -> tuple[range, int, int]:
    """What was drawn for the piece, by which process, and which computes it."""
    return *drawn, os.getpid()


@pytest.mark.parametrize("engine", [Alone(), Local(2)])
def test_variants_are_drawn_here_and_computed_there(engine: Engine) -> None:
    pieces = [range(3), range(3, 5), range(5, 6)]
    found = dict(engine.run(told, pieces, lambda piece: (piece, os.getpid())))
    assert list(map(found.get, pieces)) == [(piece, os.getpid(), found[piece][2]) for piece in pieces]
    assert (os.getpid() in {worker for _, _, worker in found.values()}) is (engine.width == 1)


class Backwards:
    """An engine that has the last pieces ready first."""

    width = 3

    def run(self, work, pieces, drawn):  # type: ignore[no-untyped-def]
        for piece in reversed(list(pieces)):
            yield piece, work(piece, drawn(piece))


@pytest.mark.parametrize("engine", [Alone(), Backwards()])
@pytest.mark.parametrize("wanted", [[range(41)], [range(3), range(10, 11), range(20, 41)], [range(0)], []])
def test_pieces_cover_what_is_wanted_once(tmp_path: Path, engine: Engine, wanted: list[range]) -> None:
    study = made(tmp_path)
    found = [number for piece, rows in study.pieces(engine, wanted) for number in piece if len(rows) == len(piece)]
    assert sorted(found) == [number for one in wanted for number in one]


def test_rows_come_in_order_from_an_engine_that_does_not_keep_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study_module, "ALONE_FOR", 0.0)
    assert list(made(tmp_path).rows(Backwards())) == list(made(tmp_path).rows(Alone()))


def test_pieces_take_about_the_same_time() -> None:
    cut = Cutter([range(100_000)], 2)
    pieces = iter(cut)
    assert len(next(pieces)) == 1
    cut.took(100, 0.01)
    assert len(next(pieces)) == 100 * GROWTH
    cut.took(100, 100.0)
    assert len(next(pieces)) == PIECE_S
    cut.took(100_000, 1.0)
    rest = [len(piece) for piece in pieces]
    assert rest == sorted(rest, reverse=True)
    assert rest[-1] == 1
    assert sum(rest) == 100_000 - 1 - 100 * GROWTH - PIECE_S


def test_numbers_lead_to_the_variants_of_the_grid() -> None:
    study = Study(DATA, "", (axis("cam.diameter=80,100"), axis("roller.diameter=10,12,14")), light)
    assert study.values(range(6)) == [(80, 10), (80, 12), (80, 14), (100, 10), (100, 12), (100, 14)]
    assert study.values(range(4, 5)) == [(100, 12)]


@pytest.mark.parametrize("address", ["", "here", "tcp://host", "http://host:1", "tcp://host:x", "tcp://a b:1"])
def test_addresses_of_a_scheduler(address: str) -> None:
    with pytest.raises(ProfileError, match="--on: is no address"):
        Cluster(address)


def test_progress_tells_rate_and_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    from camgeom.design import engine

    clock = [0.0]
    monkeypatch.setattr(engine, "monotonic", lambda: clock[0])
    pace = Pace(1000, 400)
    assert pace.after(1) == "401 of 1000 variants"
    clock[0] = 10.0
    assert pace.after(99) == "500 of 1000 variants, 10/s, 50 s left"
    assert [spoken(s) for s in (0.0, 89.0, 91.0, 5400.0, 86400.0, 172800.0)] == [
        "0 s", "89 s", "2 min", "1 h 30 min", "24 h 0 min", "2.0 d"
    ]
