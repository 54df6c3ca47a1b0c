import asyncio
import os
import pty
from contextlib import asynccontextmanager

import pytest

from tests.unit.gateway.concentrator import run
from tests.unit.gateway.fakes import FakePort
from tests.unit.links.far_side import Ear
from timonel.core.frame import Frame
from timonel.links.uart_bus import UartBus
from timonel.vehicles.rover.declaration import Party
from timonel.vehicles.rover.framing import DIALECTS, Hal062, Strzyga, StrzygaCrc
from timonel.vehicles.rover.protocol import Protocol

LENGTHS = Protocol().lengths(Party.OPERATOR)
STATUS = Frame(116, b"\x01", extended=False)
IMU = Frame(111, bytes(range(12)), extended=False)


@asynccontextmanager
async def opened(dialect: str = "strzyga"):
    port, ear = FakePort("uart"), Ear()
    bus = UartBus(port, DIALECTS[dialect](LENGTHS))
    await bus.open(ear.receive_frames, ear.changed)
    yield bus, port, ear
    await bus.close()


@pytest.mark.parametrize("dialect", DIALECTS)
def test_bytes_become_frames_and_frames_become_bytes(dialect: str):
    async def session():
        async with opened(dialect) as (bus, port, ear):
            data = DIALECTS[dialect].write(116, b"\x01")
            port.receive(data[:2])
            port.receive(data[2:])
            await asyncio.sleep(0.1)
            assert ear.frames == [STATUS]
            bus.send([STATUS])
            assert port.lines == [data]
            assert (bus.counters.frames_in, bus.counters.frames_out) == (1, 1)

    run(session())


def test_a_frame_longer_than_one_of_can_crosses_whole():
    async def session():
        async with opened() as (_, port, ear):
            port.receive(Strzyga.write(111, IMU.data) + b"#")
            assert ear.frames == [IMU]

    run(session())


def test_the_last_frame_of_a_burst_is_proved_by_silence():
    async def session():
        async with opened() as (_, port, ear):
            port.receive(Strzyga.write(116, b"\x01"))
            await asyncio.sleep(0.004)
            assert ear.frames == []
            await asyncio.sleep(0.002)
            assert ear.frames == [STATUS]

    run(session())


def test_what_the_dialect_cannot_carry_is_dropped_and_counted():
    async def session():
        async with opened("hal062") as (bus, port, _):
            bus.send([IMU, Frame(116, b"\x01", extended=True), Frame(0x123, b"", extended=False), STATUS])
            assert port.lines == [Hal062.write(116, b"\x01")]
            assert bus.counters.dropped == 3

    run(session())


def test_a_permission_or_stop_goes_ahead_and_voids_an_older_one_and_set_points_replace_each_other():
    async def session():
        async with opened() as (bus, port, _):
            bus.send([Frame(100, b"\0\0", extended=False), Frame(101, b"1", extended=False)])
            stick, permission = port.batches[0]
            assert (stick.urgent, stick.key) == (False, "100")
            assert (permission.urgent, permission.state, permission.key) == (True, True, "101")

    run(session())


def test_half_a_frame_is_not_finished_by_what_comes_after_the_link_was_lost():
    async def session():
        async with opened("strzyga-crc") as (bus, port, ear):
            data = StrzygaCrc.write(111, IMU.data)
            port.receive(data[:5])
            port.changed(False, "unplugged")
            port.changed(True, "")
            port.receive(data[5:] + StrzygaCrc.write(116, b"\x01"))
            assert ear.frames == [STATUS]
            assert ear.changes == [(False, "unplugged"), (True, "")]
            assert bus.framer.counters.skipped == len(data)

    run(session())


def test_nothing_comes_after_it_was_closed():
    async def session():
        async with opened() as (_, port, ear):
            port.receive(Strzyga.write(116, b"\x01"))
        await asyncio.sleep(1.0)
        assert ear.frames == []
        assert port.closed == 1

    run(session())


def test_it_runs_over_a_real_terminal(tmp_path):
    from timonel.links.urls import byte_link

    async def session():
        ours, theirs = pty.openpty()
        bus, ear = UartBus(byte_link(f"serial://{os.ttyname(theirs)}"), Strzyga(LENGTHS)), Ear()
        await bus.open(ear.receive_frames, ear.changed)
        os.write(ours, Strzyga.write(116, b"\x01"))
        async with asyncio.timeout(5):
            while ear.frames != [STATUS]:
                await asyncio.sleep(0.01)
        bus.send([Frame(101, b"\xce", extended=False)])
        await asyncio.sleep(0.05)
        assert os.read(ours, 100) == b"#\x65\xce"
        await bus.close()
        os.close(ours)
        os.close(theirs)

    asyncio.run(session())
