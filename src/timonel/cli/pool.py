"""Worker processes, and new ones when one of them dies."""

import multiprocessing
from collections.abc import Iterable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Generic

from timonel.cli.many import R, Tell, Work
from timonel.errors import TimonelError

ATTEMPTS = 3
"""How often a recording is tried whose worker dies."""

_LOOK = 0.2  # s between looks at how far the workers are
_PRELOADED = ["timonel.recording.decoding", "timonel.recording.sinks.jsonl"]

_started: Any = None  # in a worker: what was read of each file, plus one


class Pool(Generic[R]):
    """Does the work of many recordings, `workers` of them at a time; `show` is told how many bytes were read."""

    def __init__(self, works: Sequence[Work[R]], workers: int, show: Tell) -> None:
        self._works = works
        self._workers = workers
        self._show = show
        self._context = multiprocessing.get_context("forkserver")
        self._context.set_forkserver_preload(_PRELOADED)
        self._read = self._context.Array("Q", len(works), lock=False)
        self._attempts = [0] * len(works)
        self._found: dict[int, R | Exception] = {}

    def run(self) -> list[R | Exception]:
        """All at once; then those whose worker may have been killed, each alone, so that it is known which it was."""
        self._round(list(range(len(self._works))), self._workers)
        while left := [number for number in range(len(self._works)) if number not in self._found]:
            fresh = [number for number in left if not self._attempts[number]]
            if fresh:
                self._round(fresh, self._workers)
            else:
                self._round(left[:1], 1)
        return [self._found[number] for number in range(len(self._works))]

    def _round(self, numbers: list[int], workers: int) -> None:
        """Some of the work, up to its end or to the death of a worker."""
        for number in numbers:
            self._read[number] = 0
        with ProcessPoolExecutor(workers, self._context, _share, (self._read,)) as pool:
            futures = {pool.submit(_work, number, self._works[number]): number for number in numbers}
            try:
                self._gather(futures)
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def _gather(self, futures: dict[Future[R], int]) -> None:
        waiting = set(futures)
        lost = False
        while waiting:
            done, waiting = wait(waiting, _LOOK, FIRST_COMPLETED)
            self._show(sum(self._read))
            for future in done:
                lost |= not self._take(futures[future], future)
        if lost:
            self._blame(futures.values())

    def _take(self, number: int, future: Future[R]) -> bool:
        """Note what came of a file; False if its worker is gone."""
        try:
            self._found[number] = future.result()
        except TimonelError as error:
            self._found[number] = error
        except BrokenProcessPool:
            return False
        return True

    def _blame(self, numbers: Iterable[int]) -> None:
        """One of those that were begun was its worker's end."""
        for number in numbers:
            if number in self._found or not self._read[number]:
                continue
            self._attempts[number] += 1
            if self._attempts[number] == ATTEMPTS:
                file = self._works[number].file
                self._found[number] = TimonelError(f"{file}: the process that read it was killed, {ATTEMPTS} times")


def _share(read: Any) -> None:
    global _started
    _started = read


def _work(number: int, work: Work[R]) -> R:
    def tell(read: int) -> None:
        _started[number] = read + 1

    tell(0)
    return work.function(work.file, tell, *work.arguments)
