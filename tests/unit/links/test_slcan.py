import asyncio
from contextlib import asynccontextmanager

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.unit.links.far_side import Adapter, Ear, hears, until
from timonel.core.frame import Frame
from timonel.links.link import Counters
from timonel.links.slcan import SlcanLink, SlcanParser, decode, encode

HEADING = Frame(0x09F11201, bytes.fromhex("00b86fff7fff7ffc"))
DRIVE = Frame(100, bytes.fromhex("9c00"), extended=False)

FRAMES = st.builds(Frame, st.integers(0, 0x1FFF_FFFF), st.binary(max_size=8), st.just(True)) | st.builds(
    Frame, st.integers(0, 0x7FF), st.binary(max_size=8), st.just(False)
)


def test_a_frame_is_written_as_the_adapter_expects_it():
    assert encode(HEADING) == b"T09F11201800B86FFF7FFF7FFC\r"
    assert encode(DRIVE) == b"t06429C00\r"
    assert encode(Frame(0x7FF, b"", extended=False)) == b"t7FF0\r"


@given(FRAMES)
def test_every_frame_comes_back_as_it_was(frame):
    assert decode(encode(frame).removesuffix(b"\r")) == frame


@pytest.mark.parametrize(
    "line",
    [b"T09f11201800b86fff7fff7ffc", b"T09F11201800B86FFF7FFF7FFC1A2B"],
    ids=["lower case", "time stamp"],
)
def test_variants_of_adapters_are_understood(line):
    assert decode(line) == HEADING


@pytest.mark.parametrize(
    "line",
    [
        b"T09F11201800B86FFF7FFF7FF",  # a digit short
        b"T09F11201800B86FFF7FFF7FFC1A2",  # neither with nor without a stamp
        b"T09F1120190000000000000000",  # nine bytes
        b"TFFFFFFFF0",  # beyond 29 bits
        b"t8000",  # beyond 11 bits
        b"t 640",
        b"t+640",
        b"t0641 1",
        b"t0642_1_1",
        b"t06",
        b"x",
        "t06419ü".encode(),
    ],
)
def test_a_broken_line_is_counted_and_never_a_frame(line):
    tally = Counters()
    parser = SlcanParser(tally)
    assert parser.receive(line + b"\r" + encode(DRIVE)) == [DRIVE]
    assert tally.rejected == 1


def test_answers_and_remote_frames_are_passed_over_and_refusals_counted():
    tally = Counters()
    parser = SlcanParser(tally)
    assert parser.receive(b"\rz\rZ\rV1013\rNA123\rF00\rr0648\rR000000648\r\a\at06429C00\r") == [DRIVE]
    assert (tally.rejected, tally.errors) == (0, 2)


def test_a_line_without_end_is_counted_once_and_its_tail_is_no_frame():
    tally = Counters()
    parser = SlcanParser(tally)
    for _ in range(100):
        assert parser.receive(b"T" * 40) == []
    assert parser.receive(encode(DRIVE) + encode(HEADING)) == [HEADING]
    assert tally.rejected == 1


@given(st.lists(FRAMES), st.lists(st.integers(1, 30)))
def test_however_the_bytes_are_cut_the_same_frames_come_out(frames, cuts):
    stream = b"".join(map(encode, frames))
    parser = SlcanParser(Counters())
    got = []
    for cut in [*cuts, len(stream)]:
        got += parser.receive(stream[:cut])
        stream = stream[cut:]
    assert got == frames


@given(st.binary(max_size=300))
def test_after_any_garbage_the_next_line_is_understood(garbage):
    parser = SlcanParser(Counters())
    parser.receive(garbage)
    parser.receive(b"\r")
    assert parser.receive(encode(HEADING)) == [HEADING]


@asynccontextmanager
async def plugged(tmp_path, **settings):
    adapter = Adapter(tmp_path / "adapter")
    ear = Ear()
    link = SlcanLink(str(adapter.path), **settings)
    await link.open(ear.receive_frames, ear.changed)
    yield adapter, link, ear
    await link.close()


def test_the_channel_is_opened_at_its_bit_rate_and_closed_at_the_end(tmp_path):
    async def session():
        async with plugged(tmp_path, bitrate=500_000) as (adapter, link, _):
            await hears(adapter, b"C\rS6\rO\r")
            await link.close()
            assert adapter.hear() == b"C\r"

    asyncio.run(session())


def test_frames_go_both_ways_past_broken_lines(tmp_path):
    async def session():
        async with plugged(tmp_path) as (adapter, link, ear):
            await hears(adapter, b"C\rS5\rO\r")
            adapter.say(b"11201800B8\r" + encode(HEADING)[:9])
            await until(lambda: link.counters.rejected == 1)
            adapter.say(encode(HEADING)[9:] + encode(DRIVE))
            await until(lambda: ear.frames == [HEADING, DRIVE])
            link.send([DRIVE, HEADING])
            await hears(adapter, encode(DRIVE) + encode(HEADING))
            assert (link.counters.frames_in, link.counters.frames_out) == (2, 2)

    asyncio.run(session())


def test_a_replugged_adapter_is_set_up_again_and_hears_no_old_frame(tmp_path, monkeypatch):
    monkeypatch.setattr(SlcanLink, "PAUSE", 0.01)

    async def session():
        async with plugged(tmp_path) as (adapter, link, ear):
            adapter.say(b"T09F1")
            adapter.pull()
            await until(lambda: not ear.connected)
            link.send([HEADING])
            adapter.plug()
            await until(lambda: ear.connected)
            await hears(adapter, b"C\rS5\rO\r")
            adapter.say(encode(DRIVE))
            await until(lambda: ear.frames == [DRIVE])
            assert adapter.hear() == b""
            assert link.counters.dropped == 1

    asyncio.run(session())
