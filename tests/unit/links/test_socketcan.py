import asyncio
import errno
import socket
import struct
from contextlib import asynccontextmanager

import pytest

from tests.unit.links.far_side import Ear, descriptors, until
from timonel.core.frame import Frame
from timonel.links.socketcan import SocketCanLink, controller_state, pack

HEADING = Frame(0x09F11201, bytes.fromhex("00b86fff7fff7ffc"))
DRIVE = Frame(100, bytes.fromhex("9c00"), extended=False)


class Bus:
    """Plays the kernel: the far end of a socket that keeps frames apart, like a raw CAN socket."""

    def __init__(self) -> None:
        self.opened = 0
        self.far = socket.socket(socket.AF_UNIX)

    def make(self, channel: str) -> socket.socket:
        self.opened += 1
        self.far.close()
        near, self.far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        return near

    def error(self, kind: int, detail: int = 0) -> None:
        self.far.send(struct.pack("=IB3x8s", 0x2000_0000 | kind, 8, bytes([0, detail])))


@asynccontextmanager
async def opened(channel="lo"):
    """A link on the loopback interface, which is up everywhere, with a socket pair in place of the bus."""
    bus, ear = Bus(), Ear()
    link = SocketCanLink(channel, make=bus.make)
    await link.open(ear.receive_frames, ear.changed)
    yield bus, link, ear
    await link.close()
    bus.far.close()


def test_a_frame_is_packed_as_the_kernel_has_it():
    assert pack(HEADING) == bytes.fromhex("0112f189 08000000 00b86fff7fff7ffc")
    assert pack(DRIVE) == bytes.fromhex("64000000 02000000 9c00000000000000")


def test_frames_of_both_formats_go_both_ways():
    async def session():
        async with opened() as (bus, link, ear):
            bus.far.send(pack(HEADING))
            bus.far.send(pack(DRIVE))
            await until(lambda: len(ear.frames) == 2)
            assert ear.frames == [HEADING, DRIVE]
            link.send([DRIVE, HEADING])
            assert (bus.far.recv(100), bus.far.recv(100)) == (pack(DRIVE), pack(HEADING))
            assert (link.counters.frames_in, link.counters.frames_out) == (2, 2)

    asyncio.run(session())


def test_what_has_piled_up_comes_in_batches_of_at_most_64():
    async def session():
        async with opened() as (bus, _, ear):
            for number in range(100):
                bus.far.send(pack(Frame(number, b"")))
            await until(lambda: len(ear.frames) == 100)
            assert [frame.identifier for frame in ear.frames] == list(range(100))
            assert ear.batches == 2

    asyncio.run(session())


class Asked(socket.socket):
    """Counts how often it is asked for a frame."""

    times = 0

    def recv(self, *size):
        self.times += 1
        return super().recv(*size)


def test_frames_that_come_one_by_one_are_asked_for_little_more_than_once_each():
    async def session():
        near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        asked = Asked(fileno=near.detach())
        link, ear = SocketCanLink("lo", make=lambda _: asked), Ear()
        await link.open(ear.receive_frames, ear.changed)
        for number in range(50):
            far.send(pack(Frame(number, b"")))
            await until(lambda expected=number + 1: len(ear.frames) == expected)
        assert [frame.identifier for frame in ear.frames] == list(range(50))
        assert asked.times == 60
        await link.close()
        far.close()

    asyncio.run(session())


def test_what_has_piled_up_behind_frames_that_came_one_by_one_comes_in_batches_again():
    async def session():
        async with opened() as (bus, _, ear):
            bus.far.send(pack(Frame(0, b"")))
            await until(lambda: ear.frames)
            for number in range(1, 100):
                bus.far.send(pack(Frame(number, b"")))
            await until(lambda: len(ear.frames) == 100)
            assert [frame.identifier for frame in ear.frames] == list(range(100))
            assert ear.batches == 1 + 4 + 2

    asyncio.run(session())


def test_remote_frames_are_counted_and_passed_over():
    async def session():
        async with opened() as (bus, link, ear):
            bus.far.send(struct.pack("=IB3x8s", 0x4000_0064, 2, b""))
            bus.far.send(pack(DRIVE))
            await until(lambda: ear.frames)
            assert ear.frames == [DRIVE]
            assert link.counters.rejected == 1

    asyncio.run(session())


def test_error_frames_are_counted_and_tell_the_state_of_the_controller():
    async def session():
        async with opened() as (bus, link, ear):
            bus.error(0x04, 0x08)
            bus.error(0x04, 0x20)
            bus.error(0x20)
            bus.error(0x40)
            bus.error(0x100)
            await until(lambda: link.counters.errors == 5)
            await asyncio.sleep(0)
            assert ear.changes == [
                (True, ""),
                (True, "error warning"),
                (True, "error passive"),
                (False, "bus-off"),
                (True, ""),
            ]

    asyncio.run(session())


def test_a_bus_that_talks_again_is_not_off_although_nobody_told_of_its_restart():
    async def session():
        async with opened() as (bus, _, ear):
            bus.error(0x40)
            await until(lambda: ear.changes[-1:] == [(False, "bus-off")])
            bus.far.send(pack(HEADING))
            await until(lambda: ear.connected)

    asyncio.run(session())


@pytest.mark.parametrize(
    ("error", "detail", "state"),
    [
        (0x04, 0x01, None),  # an overflow says nothing of the state
        (0x04, 0x04, (True, "error warning")),
        (0x04, 0x10, (True, "error passive")),
        (0x04, 0x30, (True, "error passive")),
        (0x04, 0x40, (True, "")),
        (0x08, 0x00, None),
        (0x40, 0x00, (False, "bus-off")),
        (0x100, 0x00, (True, "")),
    ],
)
def test_the_state_of_the_controller_is_read_as_linux_can_error_h_has_it(error, detail, state):
    assert controller_state(error, bytes([0, detail])) == state


def test_an_interface_that_is_not_there_is_told_and_leaks_nothing(monkeypatch):
    monkeypatch.setattr(SocketCanLink, "PAUSE", 0.005)

    async def session():
        async with opened("no-such-can") as (bus, link, ear):
            await until(lambda: bus.opened == 3)
            before = descriptors()
            await until(lambda: bus.opened == 20)
            assert descriptors() <= before
            assert ear.changes == [(False, "No such device")]
            link.send([HEADING])
            assert link.counters.dropped == 1

    asyncio.run(session())


def test_an_interface_that_goes_down_is_noticed_though_its_socket_is_silent(monkeypatch):
    monkeypatch.setattr(SocketCanLink, "PAUSE", 0.005)
    monkeypatch.setattr("timonel.links.socketcan.WATCH", 0.005)
    running = True
    monkeypatch.setattr("timonel.links.socketcan.is_running", lambda interface, channel: running)

    async def session():
        nonlocal running
        async with opened() as (bus, link, ear):
            await asyncio.sleep(0.02)
            running = False
            await until(lambda: not ear.connected)
            assert ear.changes == [(True, ""), (False, "interface is down")]
            running = True
            await until(lambda: ear.connected)
            bus.far.send(pack(HEADING))
            await until(lambda: ear.frames == [HEADING])
            assert link.counters.reopened == 1

    asyncio.run(session())


class Failing:
    """A CAN socket whose kernel answers `send` with an error."""

    def __init__(self, real: socket.socket, fault: int) -> None:
        self.real = real
        self.fault = fault

    def send(self, data: bytes) -> int:
        raise OSError(self.fault, "refused")

    def __getattr__(self, name: str):
        return getattr(self.real, name)


@pytest.mark.parametrize("fault", [errno.ENOBUFS, errno.EAGAIN])
def test_a_full_queue_drops_and_counts_and_the_link_stays_open(fault):
    async def session():
        async with opened() as (bus, link, ear):
            whole, link._socket = link._socket, Failing(link._socket, fault)
            link.send([HEADING, DRIVE])
            link._socket = whole
            link.send([HEADING])
            assert bus.far.recv(100) == pack(HEADING)
            assert (link.counters.dropped, link.counters.frames_out) == (2, 1)
            await asyncio.sleep(0)
            assert ear.changes == [(True, "")]

    asyncio.run(session())


def test_a_socket_that_fails_is_opened_again_without_spinning(monkeypatch):
    monkeypatch.setattr(SocketCanLink, "PAUSE", 0.005)

    async def session():
        async with opened() as (bus, link, ear):
            link._socket = Failing(link._socket, errno.ENETDOWN)
            link.send([HEADING, DRIVE])
            await until(lambda: bus.opened == 2)
            assert link.counters.dropped == 2
            await until(lambda: ear.connected)
            assert ear.changes[1] == (False, "refused")

    asyncio.run(session())
