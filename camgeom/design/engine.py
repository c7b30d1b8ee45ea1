"""Who computes the pieces of a long run: this process, worker processes of this machine, or those of a Dask scheduler.

A piece is a range of row numbers, and what it gives depends on nothing else: neither the engine, nor the number of
workers, nor which of them died on the way changes a row. Its variants are drawn here, while workers begin, so that
none of them needs what draws them. A worker that dies costs its piece alone, which is computed again; a piece whose
workers died `TRIES` times comes back as None.
"""

from __future__ import annotations

import logging
import os
import re
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from functools import partial
from multiprocessing import get_context
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any, Protocol, TypeVar, final

from camgeom.errors import CamgeomError, Problem, ProfileError
from camgeom.immutable import immutable
from camgeom.interrupts import beginning_children
from camgeom.motion.own import begin_worker, cores, load_copies, loaded_copies, loaded_files
from camgeom.version import __version__

D = TypeVar("D")
R = TypeVar("R")

TRIES = 3
"""workers that may die over one piece; Dask's own count (`allowed-failures`) is the same"""
AHEAD = 2
"""pieces waiting at a scheduler for each thread of its workers, so that none is idle while an answer travels"""
PATIENCE = 120.0
"""s that a scheduler may stand without any worker; clusters that start machines on demand take a minute or so"""


class Engine(Protocol):
    """Computes pieces; they come back in the order in which they are ready."""

    @property
    def width(self) -> int:
        """How many pieces are computed at a time."""
        ...

    def run(
        self, work: Callable[[range, D], R], pieces: Iterable[range], drawn: Callable[[range], D]
    ) -> Iterator[tuple[range, R | None]]:
        """Each piece with what `work` gives of it and what is drawn for it, None where its workers died; `pieces` are
        asked for when needed."""
        ...


@final
class Alone:
    """This process, one piece after the other."""

    width = 1

    def run(
        self, work: Callable[[range, D], R], pieces: Iterable[range], drawn: Callable[[range], D]
    ) -> Iterator[tuple[range, R | None]]:
        for piece in pieces:
            yield piece, work(piece, drawn(piece))


@final
@immutable(eq=True)
class Local:
    """Worker processes of this machine. Each is a pool of its own, so that its death breaks no other's work."""

    width: int

    def run(
        self, work: Callable[[range, D], R], pieces: Iterable[range], drawn: Callable[[range], D]
    ) -> Iterator[tuple[range, R | None]]:
        """Raises CamgeomError where worker processes cannot even begin."""
        coming, again, deaths = iter(pieces), deque[range](), Counter[range]()
        pools: list[ProcessPoolExecutor] = []
        running: dict[Future[R], tuple[int, range]] = {}
        try:
            while True:
                busy = {slot for slot, _ in running.values()}
                taken: list[tuple[int, range]] = []
                for slot in (slot for slot in range(self.width) if slot not in busy):
                    piece = again.popleft() if again else next(coming, None)
                    if piece is None:
                        break
                    if slot == len(pools):
                        pools.append(_pool())
                        # Any task starts the process; this one has it import what the work needs, while we draw.
                        _submit(pools, slot, partial(callable, work))
                    taken.append((slot, piece))
                for slot, piece in taken:
                    running[_submit(pools, slot, partial(work, piece, drawn(piece)))] = slot, piece
                if not running:
                    return
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    slot, piece = running.pop(future)
                    try:
                        result = future.result()
                    except BrokenProcessPool:
                        _renew(pools, slot)
                        deaths[piece] += 1
                        if deaths[piece] < TRIES:
                            again.append(piece)
                        else:
                            _refuse_stillborn(pools[slot])
                            yield piece, None
                    else:
                        yield piece, result
        finally:
            for pool in pools:
                pool.shutdown(wait=True, cancel_futures=True)


def _pool() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, get_context("spawn"), begin_worker, (loaded_files(),))


def _renew(pools: list[ProcessPoolExecutor], slot: int) -> None:
    pools[slot].shutdown(wait=False, cancel_futures=True)
    pools[slot] = _pool()


def _submit(pools: list[ProcessPoolExecutor], slot: int, job: Callable[[], R]) -> Future[R]:
    """A piece handed to a worker; one that died while it had nothing to do is replaced."""
    with beginning_children():
        try:
            return pools[slot].submit(job)
        except BrokenProcessPool:
            _renew(pools, slot)
            return pools[slot].submit(job)


def _refuse_stillborn(pool: ProcessPoolExecutor) -> None:
    """Raise CamgeomError where a new worker process ends before it has done anything."""
    try:
        with beginning_children():
            begun = pool.submit(os.getpid)
        begun.result()
    except BrokenProcessPool:
        raise CamgeomError("worker processes end as soon as they begin; try --jobs 1") from None


@final
@immutable(eq=True)
class Cluster:
    """The workers of a Dask scheduler that runs already; it shares the work out and gives it again where one dies.

    address  of the scheduler, tcp://host:port (tls:// with Dask's own configuration)
    """

    address: str

    def __post_init__(self) -> None:
        if not re.fullmatch(r"(tcp|tls)://[\w.\-\[\]:%]+:\d{1,5}", self.address):
            example = "the address of a Dask scheduler, for example tcp://10.0.0.5:8786"
            raise ProfileError([Problem("--on", "is no address", self.address[:200], example)])

    @property
    def width(self) -> int:
        """Unknown before it is asked and changing while it runs; pieces at the end of a run are cut for so many."""
        return 64

    def run(
        self, work: Callable[[range, D], R], pieces: Iterable[range], drawn: Callable[[range], D]
    ) -> Iterator[tuple[range, R | None]]:
        """Raises CamgeomError where the scheduler cannot be reached, is lost, or has no workers that could do it."""
        dask = _distributed()
        job = partial(_there, __version__, loaded_copies(), work)
        coming, running = iter(pieces), dict[str, range]()
        ready: SimpleQueue[Any] = SimpleQueue()
        futures: dict[str, Any] = {}
        client = self._client(dask)
        seen = monotonic()
        try:
            while True:
                threads = sum(client.nthreads().values())
                while len(running) < AHEAD * max(threads, 1) and (piece := next(coming, None)) is not None:
                    future = client.submit(job, piece, drawn(piece), pure=False)
                    running[future.key], futures[future.key] = piece, future
                    future.add_done_callback(ready.put)
                if not running:
                    return
                seen = monotonic() if threads else seen
                if monotonic() - seen > PATIENCE:
                    raise CamgeomError(f"the scheduler at {self.address} has no workers; start some (dask worker)")
                with suppress(Empty):
                    future = ready.get(timeout=1.0)
                    result = self._answer(future, dask)
                    del futures[future.key]
                    yield running.pop(future.key), result
                if client.status != "running":
                    raise self._lost()
        except (OSError, dask.CommClosedError):
            raise self._lost() from None
        finally:
            client.close()

    def _client(self, dask: Any) -> Any:
        try:
            return dask.Client(self.address, timeout=10, set_as_default=False)
        except (OSError, ValueError, dask.CommClosedError) as error:
            raise CamgeomError(f"--on: no Dask scheduler answers at {self.address} ({error})") from None

    def _answer(self, future: Any, dask: Any) -> Any:
        """What a finished future holds, None where the scheduler gave it up after its workers died."""
        if future.status == "cancelled":
            raise self._lost()
        try:
            return future.result()
        except dask.KilledWorker:
            return None
        except ImportError as error:
            text = f"the workers of {self.address} cannot load camgeom ({error}); install the same version there"
            raise CamgeomError(text) from None

    def _lost(self) -> CamgeomError:
        return CamgeomError(f"the scheduler at {self.address} was lost; the rows written so far stand")


def _distributed() -> Any:
    try:
        import distributed
        from distributed.comm.core import CommClosedError
    except ImportError:
        text = "--on needs Dask's distributed: pip install 'camgeom[cluster]'"
        raise CamgeomError(text) from None
    distributed.CommClosedError = CommClosedError
    # A lost scheduler is told once, by this package; Dask's own log would tell it with a trace for each task.
    for name in ("distributed", "distributed.client"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    return distributed


def _there(
    version: str, laws: tuple[tuple[str, bytes], ...], work: Callable[[range, D], R], piece: range, drawn: D
) -> R:
    """One piece on a worker of another machine, which must be of the same version and know the same laws."""
    if version != __version__:
        raise CamgeomError(f"a worker has camgeom {__version__}, this machine {version}; install the same version")
    try:
        load_copies(laws)
    except ProfileError as error:  # it would not come back whole: its parts are more than its text
        raise CamgeomError(str(error)) from None
    return work(piece, drawn)


PIECE_S = 2.0
"""s that a piece should take: a thousandth of it is lost to a scheduler, and no more of it to a worker's death"""
GROWTH = 4
"""the next pieces are at most so many times longer than one that is known: rows differ in cost"""


@final
class Cutter:
    """Ranges of row numbers cut into pieces that take about `PIECE_S`, by what the pieces before them took.

    width  workers; towards the end pieces become so short that all of them have work
    """

    def __init__(self, ranges: Iterable[range], width: int) -> None:
        self._left = deque(one for one in ranges if one)
        self._rest = sum(map(len, self._left))
        self._width, self._size = width, 1

    def took(self, rows: int, seconds: float) -> None:
        """A piece of so many rows took so long."""
        fitting = round(PIECE_S * rows / seconds) if seconds > 0.0 else GROWTH * rows
        self._size = max(1, min(fitting, GROWTH * rows))

    @property
    def first(self) -> range:
        """What is left of the first range; empty where nothing is."""
        return self._left[0] if self._left else range(0)

    def next(self, most: int) -> range:
        """The next piece of at most so many rows, from one range; empty where nothing is left."""
        piece, rest = self.first[:most], self.first[most:]
        if rest:
            self._left[0] = rest
        elif piece:
            self._left.popleft()
        self._rest -= len(piece)
        return piece

    def __iter__(self) -> Iterator[range]:
        while self._rest:
            yield self.next(min(self._size, -(-self._rest // (2 * self._width))))


@final
class Pace:
    """How far a run has come: rows per second since it began, and the time left at that rate."""

    def __init__(self, total: int, done: int = 0) -> None:
        self._total, self._before, self._done, self._began = total, done, done, monotonic()

    def after(self, rows: int) -> str:
        """The line of progress after so many more rows."""
        self._done += rows
        took = monotonic() - self._began
        text = f"{self._done} of {self._total} variants"
        if took < 1.0 or self._done == self._before:
            return text
        rate = (self._done - self._before) / took
        return f"{text}, {rate:.3g}/s, {spoken((self._total - self._done) / rate)} left"


def local(jobs: int | None = None) -> Engine:
    """Worker processes of this machine, by default one a core; this process alone where that is one."""
    workers = jobs or cores()
    return Local(workers) if workers > 1 else Alone()


def spoken(seconds: float) -> str:
    """A duration in one or two units."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 90:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min" if minutes < 2880 else f"{minutes / 1440:.1f} d"
