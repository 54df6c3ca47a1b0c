"""Many recordings at once, on all processors: what a killed worker lost is done again."""

import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any, Generic, TypeVar

import click
import msgspec

from timonel.errors import TimonelError

R = TypeVar("R")
Tell = Callable[[int], object]
"""Is told how many bytes of the file were read."""


class Work(msgspec.Struct, Generic[R], frozen=True):
    """`function(file, tell, *arguments)`, which another process can import."""

    file: str
    function: Callable[..., R]
    arguments: tuple[Any, ...] = ()


class Outcome(msgspec.Struct, Generic[R]):
    """What came of it: results in the order of the work, and what is to be said of the files without one."""

    results: list[R]
    failures: list[str]

    def leave(self) -> None:
        """Say what failed; exit with 1 if something did."""
        for failure in self.failures:
            click.echo(failure, err=True)
        if self.failures:
            sys.exit(1)


def carry_out(works: Sequence[Work[R]], jobs: int | None = None) -> Outcome[R]:
    """Do all of it, `jobs` files at a time (as many as there are processors), with a bar for who is watching."""
    workers = min(len(works), jobs or len(os.sched_getaffinity(0)))
    with _bar([work.file for work in works]) as show:
        found = _here(works, show) if workers == 1 else _there(works, workers, show)
    failures = [str(one) for one in found if isinstance(one, Exception)]
    return Outcome([one for one in found if not isinstance(one, Exception)], failures)


def _here(works: Sequence[Work[R]], show: Tell) -> list[R | Exception]:
    found: list[R | Exception] = []
    done = 0
    for work in works:
        try:
            found.append(work.function(work.file, lambda read, done=done: show(done + read), *work.arguments))
        except TimonelError as error:
            found.append(error)
        done += _size(work.file)
    return found


def _there(works: Sequence[Work[R]], workers: int, show: Tell) -> list[R | Exception]:
    from timonel.cli.pool import Pool  # what processes need is not loaded for a single file

    return Pool(works, workers, show).run()


@contextmanager
def _bar(files: Sequence[str]) -> Iterator[Tell]:
    """Shows how much was read and how long the rest will take, where somebody watches and nothing runs through it."""
    if not sys.stderr.isatty() or sys.stdout.isatty():
        yield lambda read: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn

    columns = (TextColumn("{task.description}"), BarColumn(), DownloadColumn(), TimeRemainingColumn())
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        name = files[0] if len(files) == 1 else f"{len(files)} recordings"
        task = progress.add_task(name, total=sum(map(_size, files)) or None)
        yield lambda read: progress.update(task, completed=read)


def _size(file: str) -> int:
    return os.path.getsize(file) if os.path.isfile(file) else 0
