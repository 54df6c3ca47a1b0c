"""Segments, the budget, and disks that do not take what they are given."""

import errno
import os
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.unit.recording.flights import OFFSET, page
from timonel.recording import flight_writer
from timonel.recording.flight import Flight, Metadata
from timonel.recording.flight_tape import Tape
from timonel.recording.flight_writer import PAGES, FlightWriter, Limits

DAY = int(datetime(2026, 7, 27, 10, 15, tzinfo=UTC).timestamp()) * 10**9


def front(number: int) -> Metadata:
    return {"timonel.recording": {"run": "a", "segment": str(number)}}


def a_writer(directory: Path, **limits: float) -> FlightWriter:
    return FlightWriter(directory, "Alisea II", Limits(**limits), front, began_ns=DAY)  # type: ignore[arg-type]


def feed(writer: FlightWriter, pages: int, tape: Tape | None = None) -> None:
    """So many pages, written one after the other."""
    tape = tape or Tape([], OFFSET)
    for _ in range(pages):
        writer.put(page(tape, 1000 * (tape.step + 1)))
        writer.drain()


def steps(directory: Path) -> list[int]:
    """The steps of all files, in their order."""
    found: set[int] = set()
    for path in directory.iterdir():
        found |= {record.step for record in Flight(path)}
    return sorted(found)


@pytest.fixture
def eager(monkeypatch: pytest.MonkeyPatch) -> None:
    """A writer that tries again at once."""
    monkeypatch.setattr(flight_writer, "RETRY", 0.0)


def test_a_segment_is_called_after_its_vehicle_its_day_and_its_number(tmp_path: Path) -> None:
    writer = a_writer(tmp_path)
    feed(writer, 1)
    writer.finish()
    assert [path.name for path in tmp_path.iterdir()] == ["Alisea-II-20260727T101500.000Z-0.mcap"]


def test_a_segment_that_is_full_is_finished_and_the_next_begun(tmp_path: Path) -> None:
    writer = a_writer(tmp_path, segment_size=2000)
    feed(writer, 10)
    writer.finish()
    flights = [Flight(path) for path in sorted(tmp_path.iterdir())]
    assert len(flights) > 2
    assert [flight.metadata["timonel.recording"]["segment"] for flight in flights] == list(
        map(str, range(len(flights)))
    )
    for flight in flights:
        list(flight)
        assert flight.finished
    assert steps(tmp_path) == list(range(40))
    assert (writer.written.segments, writer.written.steps) == (len(flights), 40)


def test_a_segment_that_is_old_is_finished(tmp_path: Path) -> None:
    writer = a_writer(tmp_path, segment_age=0.0)
    feed(writer, 3)
    assert len(list(tmp_path.iterdir())) == 3


def test_the_oldest_files_of_the_same_name_are_deleted_for_the_budget(tmp_path: Path) -> None:
    tape = Tape([], OFFSET)
    (tmp_path / "Alisea-II-20250101T000000.000Z-0.mcap").write_bytes(bytes(3000))
    (tmp_path / "Alisea-20250101T000000.000Z-0.mcap").write_bytes(bytes(50_000))  # somebody else's
    (tmp_path / "Alisea-II.mcap").write_bytes(bytes(50_000))  # kept by its owner
    writer = a_writer(tmp_path, segment_size=2000, budget=9000)
    feed(writer, 40, tape)
    writer.finish()
    own = [path for path in tmp_path.iterdir() if path.name.startswith("Alisea-II-")]
    assert 5000 < sum(path.stat().st_size for path in own) <= 9000
    kept = sorted(int(path.stem.rpartition("-")[2]) for path in own)
    assert kept == list(range(writer.written.segments - len(kept), writer.written.segments))
    assert writer.written.deleted == writer.written.segments + 1 - len(kept)
    assert len(list(tmp_path.iterdir())) == len(own) + 2


def test_a_full_disk_loses_the_page_and_recording_goes_on_when_there_is_room(
    tmp_path: Path, eager: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer, tape = a_writer(tmp_path), Tape([], OFFSET)
    feed(writer, 2, tape)
    with monkeypatch.context() as patch:
        patch.setattr(os, "write", _no_space)
        feed(writer, 3, tape)
        assert writer.trouble == "No space left on device"
        assert (writer.written.failures, writer.written.lost_pages, writer.written.lost_steps) == (3, 3, 12)
    feed(writer, 2, tape)
    writer.finish()
    assert writer.trouble is None
    assert steps(tmp_path) == [*range(8), *range(20, 28)]


def _no_space(fd: int, data: bytes) -> int:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_disk_that_takes_half_a_chunk_leaves_no_half_chunk(
    tmp_path: Path, eager: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer, tape = a_writer(tmp_path), Tape([], OFFSET)
    feed(writer, 1, tape)
    write, left = os.write, 300

    def fill(fd: int, data: bytes) -> int:
        nonlocal left
        if not left:
            return _no_space(fd, data)
        written = write(fd, data[:left])
        left -= written
        return written

    with monkeypatch.context() as patch:
        patch.setattr(os, "write", fill)
        feed(writer, 1, tape)
    (path,) = tmp_path.iterdir()
    flight = Flight(path)
    assert len(list(flight.pages())) == 1
    assert [damage.size for damage in flight.damage] == [0]


def test_a_disk_that_stays_full_is_not_littered(tmp_path: Path, eager: None, monkeypatch: pytest.MonkeyPatch) -> None:
    writer = a_writer(tmp_path / "recordings")
    monkeypatch.setattr(os, "write", _no_space)
    feed(writer, 5)
    assert list((tmp_path / "recordings").iterdir()) == []


def test_while_the_disk_is_out_of_order_it_is_tried_every_two_seconds_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "write", _no_space)
    writer = a_writer(tmp_path)
    feed(writer, 5)
    assert (writer.written.failures, writer.written.lost_pages) == (1, 5)


@pytest.mark.parametrize("directory", ["/dev/full/recordings", "/proc/recordings"])
def test_a_directory_that_cannot_be_made_is_trouble_and_nothing_worse(directory: str) -> None:
    writer = a_writer(Path(directory))
    feed(writer, 1)
    assert writer.trouble is not None
    assert writer.written.lost_pages == 1


def test_a_device_that_is_full_is_trouble(tmp_path: Path, eager: None, monkeypatch: pytest.MonkeyPatch) -> None:
    really_open = os.open

    def open_full(path: str | Path, flags: int, mode: int = 0o777) -> int:
        return really_open("/dev/full", os.O_WRONLY) if str(path).endswith(".mcap") else really_open(path, flags, mode)

    writer = a_writer(tmp_path)
    with monkeypatch.context() as patch:
        patch.setattr(os, "open", open_full)
        patch.setattr(os, "unlink", lambda path: None)
        feed(writer, 2)
    assert (writer.trouble, writer.written.lost_pages) == ("No space left on device", 2)


LIMITED = """
import resource, sys
from pathlib import Path
from tests.unit.recording.test_flight_writer import a_writer, feed
from timonel.recording import flight_writer
from timonel.recording.flight_tape import Tape

flight_writer.RETRY = 0.0
resource.setrlimit(resource.RLIMIT_FSIZE, (4000, resource.RLIM_INFINITY))
writer, tape = a_writer(Path(sys.argv[1])), Tape([], 0)
feed(writer, 30, tape)
writer.finish()
print(writer.written.failures, writer.written.lost_pages, writer.written.pages)
"""


def test_a_file_that_may_not_grow_is_followed_by_another(tmp_path: Path) -> None:
    """`ulimit -f`: the segment ends at its last whole chunk, and the page that did not fit is lost."""
    done = subprocess.run([sys.executable, "-c", LIMITED, str(tmp_path)], capture_output=True, text=True, check=True)
    failures, lost, written = map(int, done.stdout.split())
    assert failures == lost > 2
    assert written + lost == 30
    assert len(steps(tmp_path)) == 4 * written
    assert all(path.stat().st_size <= 4000 for path in tmp_path.iterdir())


def test_a_disk_that_does_not_answer_never_holds_anybody_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answer = threading.Event()
    fsync = os.fsync

    def wait(fd: int) -> None:
        answer.wait()
        fsync(fd)

    monkeypatch.setattr(os, "fsync", wait)
    writer, tape = a_writer(tmp_path), Tape([], OFFSET)
    writer.start()
    taken = [writer.put(page(tape, number)) for number in range(PAGES + 10)]
    assert PAGES <= sum(taken) <= PAGES + 1
    assert writer.written.lost_pages == taken.count(False)
    assert writer.close(within=0.01) is False
    answer.set()
    assert writer.close(within=30.0) is True
    assert len(steps(tmp_path)) == 4 * sum(taken)


@contextmanager
def a_small_file_system(directory: Path) -> Iterator[bool]:
    """A megabyte of its own at `directory`, where the system lets us; whether it does."""
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=1m", "timonel", str(directory)], capture_output=True, check=False
    )
    try:
        yield mounted.returncode == 0
    finally:
        if mounted.returncode == 0:
            subprocess.run(["umount", "-l", str(directory)], check=True)


def test_a_file_system_of_a_megabyte_fills_up_and_is_used_again_when_there_is_room(
    tmp_path: Path, eager: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    with a_small_file_system(tmp_path) as mounted:
        if not mounted:  # as in most containers: /dev/full and ulimit above show the same
            return
        ballast = tmp_path / "ballast"
        with suppress(OSError):
            ballast.write_bytes(bytes(1 << 20))
        writer, tape = a_writer(tmp_path), Tape([], OFFSET)
        feed(writer, 3, tape)
        assert writer.trouble == "No space left on device"
        ballast.unlink()
        feed(writer, 3, tape)
        writer.finish()
        assert writer.trouble is None
        assert steps(tmp_path) == list(range(12, 24))
