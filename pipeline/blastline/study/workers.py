"""Film after film, in this process or in several at once: what is measured in one film depends on no other."""

import os
import signal
import tempfile
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any, TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")
_given: list[Callable[[Any], Any]] = []
"""What a worker does, once it has been told."""


def each_of(
    work: Callable[[_Item], _Result], items: Iterable[_Item], *, jobs: int = 1
) -> Iterator[tuple[_Item, _Result]]:
    """Yield each item and what comes of it, in order, worked out by so many processes; one job is done in this one.

    With more, work, items and results are pickled: the work once for each process, so that what it keeps stays there.
    """
    if jobs == 1:
        for item in items:
            yield item, work(item)
        return
    every = list(items)
    # not forked: a library's threads would be gone in the children, and what they hold be held for ever
    spawned = get_context("spawn")
    with (
        tempfile.TemporaryDirectory(prefix="blastline-") as compiled,
        ProcessPoolExecutor(jobs, spawned, initializer=_take, initargs=(work, compiled)) as pool,
    ):
        try:
            # not mapped: what that cancels where one fails, the pool's own thread trips over when its workers end
            waiting = [pool.submit(_done, item) for item in every]
            yield from ((item, each.result()) for item, each in zip(every, waiting, strict=True))
        except BaseException:  # or else the pool waits until each worker is done with its film
            for worker in active_children():
                worker.terminate()
            raise


def _take(work: Callable[[Any], Any], compiled: str) -> None:
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # who interrupts the run hears from it, not from each worker
    # what numba, which librosa needs, compiles in two processes at once it mixes up in its cache: both then crash
    os.environ["NUMBA_CACHE_DIR"] = str(Path(compiled, str(os.getpid())))
    _given[:] = [work]


def _done(item: Any) -> Any:
    (work,) = _given
    return work(item)
