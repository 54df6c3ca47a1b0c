import asyncio
import queue
import threading
from contextlib import asynccontextmanager

import can
import pytest

from tests.unit.links.far_side import Ear, until
from timonel.core.frame import Frame
from timonel.links import python_can
from timonel.links.python_can import PythonCanLink

HEADING = Frame(0x09F11201, bytes.fromhex("00b86fff7fff7ffc"))
DRIVE = Frame(100, bytes.fromhex("9c00"), extended=False)


def message(frame: Frame) -> can.Message:
    return can.Message(arbitration_id=frame.identifier, data=frame.data, is_extended_id=frame.extended)


class Driver(can.BusABC):
    """A python-can driver that does what it is told: messages, None, or exceptions, in order."""

    opened = 0
    latest: "Driver"

    def __init__(self, channel: object, **parameters: object) -> None:
        super().__init__(channel=channel)
        self.parameters = parameters
        self.script: queue.Queue[can.Message | Exception] = queue.Queue()
        self.sent: list[can.Message] = []
        self.send_fault: Exception | None = None
        self.waits = True
        self.polls = 0
        self.shut = False
        Driver.opened += 1
        Driver.latest = self

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        self.polls += 1
        try:
            step = self.script.get(timeout=timeout if self.waits else 0)
        except queue.Empty:
            return None, True
        if isinstance(step, Exception):
            raise step
        return step, True

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        if self.send_fault:
            raise self.send_fault
        self.sent.append(msg)

    def shutdown(self) -> None:
        super().shutdown()
        self.shut = True


@pytest.fixture(autouse=True)
def driver(monkeypatch):
    monkeypatch.setattr(can.interface, "BACKENDS", {**can.interface.BACKENDS, "told": (__name__, "Driver")})
    monkeypatch.setattr(PythonCanLink, "PAUSE", 0.01)
    monkeypatch.setattr(python_can, "POLL", 0.02)
    Driver.opened = 0


@asynccontextmanager
async def opened(interface="told", channel="boat", **parameters):
    ear = Ear()
    link = PythonCanLink(interface, channel, **parameters)
    await link.open(ear.receive_frames, ear.changed)
    yield link, ear
    await link.close()


def test_frames_go_both_ways_over_a_virtual_bus():
    async def session():
        async with opened("virtual") as (one, heard_by_one), opened("virtual") as (two, heard_by_two):
            one.send([HEADING, DRIVE])
            await until(lambda: heard_by_two.frames == [HEADING, DRIVE])
            two.send([DRIVE])
            await until(lambda: heard_by_one.frames == [DRIVE])
            await until(lambda: one.counters.frames_out == 2)
            assert (one.counters.frames_in, two.counters.frames_in) == (1, 2)

    asyncio.run(session())


def test_frames_reach_the_loop_in_batches_and_in_order():
    async def session():
        async with opened() as (_, ear):
            frames = [Frame(number, b"") for number in range(1000)]
            for frame in frames:
                Driver.latest.script.put(message(frame))
            await until(lambda: len(ear.frames) == 1000)
            assert ear.frames == frames
            assert ear.batches <= 200

    asyncio.run(session())


def test_a_broken_line_is_counted_and_reading_goes_on():
    async def session():
        async with opened() as (link, ear):
            for step in (ValueError("bad line"), message(HEADING), IndexError("short line"), message(DRIVE)):
                Driver.latest.script.put(step)
            await until(lambda: ear.frames == [HEADING, DRIVE])
            assert link.counters.rejected == 2
            assert Driver.opened == 1

    asyncio.run(session())


def test_nothing_but_broken_lines_is_a_dead_bus():
    async def session():
        async with opened() as (_, ear):
            for _ in range(python_can.STRIKES):
                Driver.latest.script.put(ValueError("bad line"))
            await until(lambda: Driver.opened == 2 and ear.connected)
            assert (False, "ValueError: bad line") in ear.changes

    asyncio.run(session())


def test_a_dead_bus_is_shut_down_and_opened_again():
    async def session():
        async with opened() as (link, ear):
            first = Driver.latest
            first.script.put(can.CanOperationError("unplugged"))
            await until(lambda: Driver.opened == 2 and ear.connected)
            assert first.shut
            assert ear.changes == [(True, ""), (False, "CanOperationError: unplugged"), (True, "")]
            Driver.latest.script.put(message(HEADING))
            await until(lambda: ear.frames == [HEADING])
            assert link.counters.reopened == 1

    asyncio.run(session())


def test_unplugging_again_and_again_leaves_no_thread_behind():
    async def session():
        async with opened() as (_, ear):
            before = threading.active_count()
            for number in range(2, 22):
                Driver.latest.script.put(OSError("unplugged"))
                await until(lambda wanted=number: Driver.opened == wanted and ear.connected)
            await until(lambda: threading.active_count() <= before + 1)  # and one of the loop's own

    asyncio.run(session())


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_receiver_that_dies_of_something_unheard_of_is_noticed():
    async def session():
        async with opened() as (_, ear):
            Driver.latest.script.put(ZeroDivisionError())
            await until(lambda: Driver.opened == 2 and ear.connected)
            assert (False, "the driver ended") in ear.changes

    asyncio.run(session())


def test_a_driver_that_neither_waits_nor_gives_does_not_make_us_spin():
    async def session():
        async with opened() as (_, ear):
            Driver.latest.waits = False
            for _ in range(25):  # on a busy machine it takes a while to notice
                Driver.latest.polls = 0
                await asyncio.sleep(0.2)
                if Driver.latest.polls <= 20:
                    break
            assert Driver.latest.polls <= 20
            Driver.latest.script.put(message(HEADING))
            await until(lambda: ear.frames == [HEADING])

    asyncio.run(session())


def test_a_frame_that_the_driver_refuses_is_counted_and_the_next_one_goes():
    async def session():
        async with opened() as (link, _):
            Driver.latest.send_fault = can.CanOperationError("buffer full")
            link.send([HEADING])
            await until(lambda: link.counters.dropped == 1)
            Driver.latest.send_fault = None
            link.send([DRIVE])
            await until(lambda: link.counters.frames_out == 1)
            assert [sent.arbitration_id for sent in Driver.latest.sent] == [DRIVE.identifier]
            assert link.counters.errors == 1

    asyncio.run(session())


def test_a_frame_that_waited_too_long_is_not_sent(monkeypatch):
    monkeypatch.setattr(python_can, "STALE", -1.0)

    async def session():
        async with opened() as (link, _):
            link.send([HEADING])
            await until(lambda: link.counters.dropped == 1)
            assert Driver.latest.sent == []

    asyncio.run(session())


def test_no_more_frames_wait_than_there_is_room_for(monkeypatch):
    monkeypatch.setattr(python_can, "OUTBOX", 2)

    async def session():
        async with opened() as (link, _):
            gate = threading.Event()
            monkeypatch.setattr(Driver.latest, "send", lambda msg, timeout: gate.wait(5))
            link.send([HEADING])
            await until(lambda: link._attendance._outgoing.empty())
            link.send([HEADING] * 5)
            gate.set()
            assert link.counters.dropped == 3

    asyncio.run(session())


def test_error_and_remote_frames_are_counted_and_passed_over():
    async def session():
        async with opened() as (link, ear):
            Driver.latest.script.put(can.Message(is_error_frame=True))
            Driver.latest.script.put(can.Message(arbitration_id=1, is_remote_frame=True))
            Driver.latest.script.put(message(HEADING))
            await until(lambda: ear.frames == [HEADING])
            assert (link.counters.errors, link.counters.rejected) == (1, 1)

    asyncio.run(session())


def test_a_bus_that_cannot_be_opened_is_told_with_its_reason(monkeypatch):
    def no_device(*arguments: object, **parameters: object) -> None:
        raise can.CanInitializationError("no such device")

    monkeypatch.setattr(can, "Bus", no_device)

    async def session():
        async with opened() as (link, ear):
            await until(lambda: ear.changes)
            link.send([HEADING])
            assert ear.changes == [(False, "CanInitializationError: no such device")]
            assert link.counters.dropped == 1

    asyncio.run(session())


def test_parameters_reach_the_driver():
    async def session():
        async with opened(bitrate=250_000):
            assert Driver.latest.parameters == {"bitrate": 250_000}

    asyncio.run(session())
