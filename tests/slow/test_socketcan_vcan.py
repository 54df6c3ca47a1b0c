"""The real kernel: run as root on a machine that has `vcan0`, for instance in a virtual one."""

import asyncio
import subprocess
from contextlib import asynccontextmanager

import pytest

from tests.unit.links.far_side import Ear, descriptors, until
from timonel.core.frame import Frame
from timonel.links.socketcan import SocketCanLink

pytestmark = pytest.mark.slow

HEADING = Frame(0x09F11201, bytes.fromhex("00b86fff7fff7ffc"))
DRIVE = Frame(100, bytes.fromhex("9c00"), extended=False)


def ip(*words: str) -> None:
    subprocess.run(["ip", "link", *words], check=True)


@pytest.fixture(autouse=True)
def _restored():
    yield
    subprocess.run(["ip", "link", "add", "dev", "vcan0", "type", "vcan"], check=False, capture_output=True)
    ip("set", "vcan0", "up")


@asynccontextmanager
async def opened():
    ear = Ear()
    link = SocketCanLink("vcan0")
    await link.open(ear.receive_frames, ear.changed)
    await until(lambda: ear.changes)
    assert ear.changes == [(True, "")]
    yield link, ear
    await link.close()


def test_frames_of_both_formats_reach_the_other_but_not_the_sender():
    async def session():
        async with opened() as (one, heard_by_one), opened() as (_, heard_by_two):
            one.send([HEADING, DRIVE, Frame(0x1FFFFFFF, b"")])
            await until(lambda: len(heard_by_two.frames) == 3)
            assert heard_by_two.frames == [HEADING, DRIVE, Frame(0x1FFFFFFF, b"")]
            assert heard_by_one.frames == []
            assert one.counters.frames_out == 3

    asyncio.run(session())


def test_every_frame_of_a_burst_arrives_in_order():
    async def session():
        async with opened() as (one, _), opened() as (_, ear):
            sent = [Frame(number, number.to_bytes(8, "little")) for number in range(5000)]
            for start in range(0, 5000, 50):
                one.send(sent[start : start + 50])
                await asyncio.sleep(0)
            await until(lambda: len(ear.frames) == 5000)
            assert ear.frames == sent

    asyncio.run(session())


def test_frames_that_come_faster_than_they_are_taken_are_counted_to_the_last_one():
    async def session():
        async with opened() as (one, _), opened() as (two, _):
            one.send([HEADING] * 5000)
            await until(lambda: two.counters.frames_in + two.counters.overrun == 5000)
            assert two.counters.overrun > 0

    asyncio.run(session())


def test_an_interface_that_goes_down_and_comes_back_is_opened_again_within_a_second():
    async def session():
        async with opened() as (one, heard_by_one), opened() as (two, heard_by_two):
            before = descriptors()
            for _ in range(5):
                ip("set", "vcan0", "down")
                await until(lambda: not heard_by_one.connected and not heard_by_two.connected)
                one.send([HEADING])
                ip("set", "vcan0", "up")
                await until(lambda: heard_by_one.connected and heard_by_two.connected)
            heard_by_two.frames.clear()
            one.send([DRIVE])
            await until(lambda: heard_by_two.frames)
            assert heard_by_two.frames == [DRIVE]
            assert one.counters.dropped == 5
            assert two.counters.reopened == 5
            assert descriptors() == before

    asyncio.run(session())


def test_an_interface_that_is_deleted_and_made_anew_is_opened_again():
    async def session():
        async with opened() as (_, ear):
            ip("del", "vcan0")
            await until(lambda: not ear.connected)
            ip("add", "dev", "vcan0", "type", "vcan")
            ip("set", "vcan0", "up")
            await until(lambda: ear.connected)
            async with opened() as (other, _):
                other.send([HEADING])
                await until(lambda: ear.frames == [HEADING])

    asyncio.run(session())
