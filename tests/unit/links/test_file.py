import asyncio
from contextlib import asynccontextmanager

import pytest

from tests.recordings import recording
from tests.unit.links.far_side import Ear, descriptors, until
from timonel.core.frame import Frame
from timonel.links.file import FileLink, Pace
from timonel.nmea2000.fastpacket import Reassembler
from timonel.recording import open_log

LOG = """(1700000000.000000) can0 09F11201#00B86FFF7FFF7FFC
(1700000000.100000) can0 064#9C00
(1700000000.150000) can0 09F1
(1700000000.200000) can0 09F11201#01B86FFF7FFF7FFC
"""
HEADINGS = [Frame(0x09F11201, bytes.fromhex(f"{sid:02x}b86fff7fff7ffc")) for sid in (0, 1)]
PLAYED = [HEADINGS[0], Frame(100, bytes.fromhex("9c00"), extended=False), HEADINGS[1]]


@asynccontextmanager
async def played(path, **settings):
    ear = Ear()
    link = FileLink(str(path), **settings)
    await link.open(ear.receive_frames, ear.changed)
    yield link, ear
    await link.close()


@pytest.fixture
def log(tmp_path):
    (tmp_path / "bus.log").write_text(LOG)
    return tmp_path / "bus.log"


def test_a_recording_is_played_to_its_end_and_its_broken_lines_are_counted(log):
    async def session():
        async with played(log, speed=None) as (link, ear):
            await until(lambda: ear.changes == [(True, ""), (False, "end of the recording")])
            assert ear.frames == PLAYED
            assert (link.counters.frames_in, link.counters.rejected) == (3, 1)

    asyncio.run(session())


def test_what_is_sent_to_a_recording_is_dropped_and_counted(log):
    async def session():
        async with played(log) as (link, _):
            link.send(PLAYED)
            assert link.counters.dropped == 3

    asyncio.run(session())


def test_a_recording_may_start_again_at_its_end(log):
    async def session():
        async with played(log, speed=None, loop=True) as (_, ear):
            await until(lambda: len(ear.frames) > 10)
            assert ear.frames[:6] == PLAYED * 2
            assert ear.changes == [(True, "")]

    asyncio.run(session())


def test_frames_come_at_the_times_of_the_recording(log):
    async def session():
        loop = asyncio.get_running_loop()
        begun = loop.time()
        async with played(log, speed=2) as (_, ear):
            await until(lambda: len(ear.frames) == 1)
            await until(lambda: len(ear.frames) == 3)
            assert ear.batches == 3
            assert loop.time() - begun >= 0.09

    asyncio.run(session())


def test_the_pace_is_the_recordings_own_times_its_speed():
    pace = Pace(2.0, now=100.0)
    assert pace.wait(5000.0, now=100.0) == 0.0
    assert pace.wait(5010.0, now=100.0) == 5.0
    assert pace.wait(5010.0, now=104.0) == 1.0
    assert pace.wait(5010.0, now=106.0) == 0.0
    assert pace.wait(None, now=106.0) == 0.0


def test_stamps_that_run_backwards_start_the_count_anew():
    pace = Pace(1.0, now=100.0)
    pace.wait(5000.0, now=100.0)
    assert pace.wait(10.0, now=103.0) == 0.0
    assert pace.wait(12.0, now=103.0) == 2.0


def test_without_a_pace_nothing_is_waited_for():
    assert Pace(None, now=0.0).wait(5000.0, now=0.0) == 0.0


def test_messages_that_were_put_together_go_out_as_the_frames_they_came_in():
    path = recording("canboat_canboat/samples/sample-single.raw.txt")
    with open_log(path) as entries:
        whole = [entry for entry in entries if entry.whole]

    async def session():
        async with played(path, speed=None) as (_, ear):
            await until(lambda: ear.changes[-1:] == [(False, "end of the recording")])
            return [frame for frame in ear.frames if frame.identifier in fast]

    assert whole
    fast = {entry.identifier for entry in whole}
    reassembler = Reassembler()
    messages = [reassembler.receive(frame.identifier, frame.data, 0.0) for frame in asyncio.run(session())]
    assert [entry.data for entry in whole] == [message for message in messages if message is not None]


def test_playing_fast_leaves_the_loop_its_turn(tmp_path):
    (tmp_path / "bus.log").write_text("(1.0) can0 064#9C00\n" * 10_000)

    async def session():
        turns = 0
        async with played(tmp_path / "bus.log", speed=None) as (_, ear):
            while len(ear.frames) < 10_000:
                turns += 1
                await asyncio.sleep(0)
        assert turns >= 100

    asyncio.run(session())


@pytest.mark.parametrize(
    ("name", "reason"),
    [("missing", "No such file or directory"), (".", "not a regular file"), ("bus.log", "format")],
)
def test_what_cannot_be_played_is_told_with_its_reason(tmp_path, name, reason):
    (tmp_path / "bus.log").write_text("no recording\n")

    async def session():
        before = descriptors()
        async with played(tmp_path / name) as (_, ear):
            await until(lambda: ear.changes)
            assert not ear.connected
            assert reason in ear.changes[0][1]
        assert descriptors() == before

    asyncio.run(session())


def test_a_recording_that_is_closed_while_it_plays_leaks_nothing(log):
    async def session():
        before = descriptors()
        async with played(log, speed=0.001) as (_, ear):
            await until(lambda: ear.frames)
        assert descriptors() == before

    asyncio.run(session())
