"""Segments on the disk, written by a thread: whoever records never waits for it.

What the disk does not take is dropped and counted. After a failure the segment is left as far as it is sound, and
every `RETRY` seconds a new one is tried. Files of the same name are deleted, the oldest first, before a new segment
could make them more than the budget.
"""

import os
import re
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from queue import Empty, Full, Queue

import msgspec

from timonel.recording.flight import Metadata
from timonel.recording.flight_segment import SegmentFile
from timonel.recording.flight_tape import Page

PAGES = 32  # that may wait for the disk
RETRY = 2.0  # s
STAMP = "%Y%m%dT%H%M%S"


class Limits(msgspec.Struct, frozen=True):
    """When a new segment is begun (bytes, s), and what all of them may take (bytes)."""

    segment_size: int = 64_000_000
    segment_age: float = 3600.0
    budget: int = 2_000_000_000


class Written(msgspec.Struct, gc=False):
    """What was written, and what was not."""

    pages: int = 0
    steps: int = 0
    bytes: int = 0
    segments: int = 0
    deleted: int = 0
    """Files of older recordings that the budget had no room for."""
    failures: int = 0
    lost_pages: int = 0
    lost_steps: int = 0


def file_name(name: str, began_ns: int, number: int) -> str:
    """`Alisea-20260727T101500.123Z-0.mcap`: whose recording, when its run began, and which part of it this is."""
    return f"{run_name(name, began_ns)}-{number}.mcap"


def run_name(name: str, began_ns: int) -> str:
    """What the files of one run have in common."""
    began = datetime.fromtimestamp(began_ns // 1_000_000_000, UTC)
    return f"{plain(name)}-{began:{STAMP}}.{began_ns // 1_000_000 % 1000:03}Z"


def plain(name: str) -> str:
    """A vehicle's name as a file's."""
    return re.sub(r"[^\w.]+", "-", name).strip("-.") or "recording"


def number_of(path: Path) -> int:
    """Which part of its run a file is; -1 for a file that is not called so."""
    match = re.fullmatch(r".*Z-(\d+)\.mcap", path.name)
    return int(match[1]) if match else -1


class FlightWriter:
    """Writes the pages of one run. `front` gives the metadata of a segment by its number.

    `trouble` is why pages are lost now, None while all is well; `written` counts. Both may be read at any time.
    """

    def __init__(
        self,
        directory: Path,
        name: str,
        limits: Limits,
        front: Callable[[int], Metadata],
        *,
        began_ns: int | None = None,
    ) -> None:
        self.directory = directory
        self.limits = limits
        self.trouble: str | None = None
        self.written = Written()
        self._name = name
        self._front = front
        self._began_ns = time.time_ns() if began_ns is None else began_ns
        self._pages: Queue[Page | None] = Queue(PAGES)
        self._segment: SegmentFile | None = None
        self._segment_began = 0.0
        self._number = 0
        self._resume = 0.0
        self._thread = threading.Thread(target=self._work, name="flight recorder", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def put(self, page: Page) -> bool:
        """Have a page written; False if it was dropped because the disk is too slow."""
        try:
            self._pages.put_nowait(page)
        except Full:
            self._lose(page)
            return False
        return True

    @property
    def waiting(self) -> int:
        """How many pages wait for the disk."""
        return self._pages.qsize()

    def close(self, within: float = 2.0) -> bool:
        """Write what waits, bring the segment to an end; False if that took more than `within` s."""
        with suppress(Full):
            self._pages.put(None, timeout=within)
        self._thread.join(within)
        return not self._thread.is_alive()

    def drain(self) -> None:
        """Write what waits on the thread of the caller: for a recording that is not live, instead of `start`."""
        with suppress(Empty):
            while (page := self._pages.get_nowait()) is not None:
                self._write(page)

    def finish(self) -> None:
        """Bring the segment to an end, on the thread of the caller."""
        self.drain()
        self._end_segment()

    def _work(self) -> None:
        while (page := self._pages.get()) is not None:
            self._write(page)
        self._end_segment()

    def _lose(self, page: Page) -> None:
        self.written.lost_pages += 1
        self.written.lost_steps += page.steps

    def _write(self, page: Page) -> None:
        if self.trouble is not None and time.monotonic() < self._resume:
            self._lose(page)
            return
        try:
            self._write_now(page)
        except OSError as fault:
            self.trouble = fault.strerror or str(fault)
            self.written.failures += 1
            self._resume = time.monotonic() + RETRY
            self._lose(page)
            self._end_segment()
        else:
            self.trouble = None

    def _write_now(self, page: Page) -> None:
        segment = self._segment or self._begin_segment()
        before = segment.size
        segment.write(page)
        if self._pages.empty():
            segment.sync()
        self.written.pages += 1
        self.written.steps += page.steps
        self.written.bytes += segment.size - before
        old = time.monotonic() - self._segment_began >= self.limits.segment_age
        if old or segment.size >= self.limits.segment_size:
            self._end_segment()

    def _begin_segment(self) -> SegmentFile:
        self.directory.mkdir(parents=True, exist_ok=True)
        self._keep_budget()
        path = self.directory / file_name(self._name, self._began_ns, self._number)
        self._segment = SegmentFile(path, self._front(self._number))
        self._segment_began = time.monotonic()
        self.written.segments += 1
        _sync_directory(self.directory)
        return self._segment

    def _end_segment(self) -> None:
        """One that cannot be finished is left as it is, sound up to its last chunk; one without any is not left."""
        segment, self._segment = self._segment, None
        if segment is None:
            return
        with suppress(OSError):
            if segment.chunks:
                self._number += 1
                segment.finish()
            else:
                segment.discard()

    def _keep_budget(self) -> None:
        """Make room for one more segment."""
        files = sorted(self._own_files(), key=lambda path: (path.stem.rpartition("-")[0], number_of(path)))
        sizes = {path: path.stat().st_size for path in files}
        for path in files:
            if sum(sizes.values()) + self.limits.segment_size <= self.limits.budget:
                return
            path.unlink()
            del sizes[path]
            self.written.deleted += 1

    def _own_files(self) -> list[Path]:
        pattern = re.compile(re.escape(plain(self._name)) + r"-\d{8}T\d{6}\.\d{3}Z-\d+\.mcap")
        return [path for path in self.directory.iterdir() if pattern.fullmatch(path.name)]


def _sync_directory(directory: Path) -> None:
    """So that the file is there after a power cut."""
    fd = os.open(directory, os.O_RDONLY)
    try:
        os.fsync(fd)
    finally:
        os.close(fd)
