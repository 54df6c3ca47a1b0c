import asyncio
from contextlib import asynccontextmanager

import pytest

from tests.unit.links.far_side import Ear, until
from timonel.core.frame import Frame
from timonel.errors import LinkError
from timonel.links.text_bus import ECHO_WITHIN, TextBus
from timonel.links.urls import bus_link, parse
from timonel.nmea2000.fastpacket import fragment

HEADING = Frame(0x09F11223, bytes.fromhex("ff10270080ff7ffd"))
STEER = [Frame(0x09F10523, data) for data in fragment(bytes(range(21)), 0)]
OTHERS = Frame(0x09F11217, bytes(8))
AS_CLIENT = b"09F11223 FF 10 27 00 80 FF 7F FD\r\n"


@asynccontextmanager
async def a_bus(form="ydraw"):
    """A bus to a gateway, the gateway's reader and writer, and what is heard."""
    clients = asyncio.Queue()
    server = await asyncio.start_server(lambda *ends: clients.put_nowait(ends), "127.0.0.1", 0)
    ear = Ear()
    bus = bus_link(f"{form}+tcp://127.0.0.1:{server.sockets[0].getsockname()[1]}", name="bus")
    await bus.open(ear.receive_frames, ear.changed)
    reader, writer = await clients.get()
    yield bus, reader, writer, ear
    await bus.close()
    writer.close()
    server.close()


def test_frames_go_out_as_a_client_writes_them_and_lines_come_in_as_frames():
    async def session():
        async with a_bus() as (bus, reader, writer, ear):
            bus.send([HEADING])
            assert await reader.readline() == AS_CLIENT
            writer.write(b"12:00:00.000 R 09F11217 00 00 00 00 00 00 00 00\r\nnonsense\r\n")
            await until(lambda: ear.frames == [OTHERS])
            counters = bus.counters
            assert (counters.frames_in, counters.frames_out, counters.rejected) == (1, 1, 1)
            assert ear.connected

    asyncio.run(session())


def test_whole_messages_are_put_together_on_the_way_out_and_taken_apart_on_the_way_in():
    async def session():
        async with a_bus("n2kascii") as (bus, reader, writer, ear):
            bus.send([*STEER[:2]])
            bus.send([*STEER[2:], HEADING])
            lines = [(await reader.readline()).split(b" ", 1)[1] for _ in range(2)]
            assert lines == [b"23FF2 1F105 %s\r\n" % bytes(range(21)).hex().upper().encode(),
                             b"23FF2 1F112 FF10270080FF7FFD\r\n"]  # fmt: skip
            writer.write(b"A120000.000 17FF2 1F105 %s\r\n" % bytes(range(21)).hex().encode())
            await until(lambda: len(ear.frames) == 4)
            assert [frame.data[1:] for frame in ear.frames] == [frame.data[1:] for frame in STEER]

    asyncio.run(session())


def test_what_the_gateway_sent_for_us_does_not_come_back_and_what_it_sent_for_another_does():
    async def session():
        async with a_bus() as (bus, reader, writer, ear):
            bus.send([HEADING])
            echo = b"12:00:00.000 T " + await reader.readline()
            other = b"12:00:00.000 T 09F11217 00 00 00 00 00 00 00 00\r\n"
            writer.write(echo + other + echo)
            await until(lambda: len(ear.frames) == 2)
            assert ear.frames == [OTHERS, HEADING]

    asyncio.run(session())


def test_an_echo_is_known_where_the_gateway_put_its_own_address_in_place_of_ours():
    async def session():
        async with a_bus() as (bus, reader, writer, ear):
            bus.send([HEADING])
            echo = b"12:00:00.000 T " + await reader.readline()
            writer.write(echo.replace(b"T 09F11223", b"T 09F11242") + echo)
            await until(lambda: ear.frames)
            assert ear.frames == [HEADING]

    asyncio.run(session())


def test_a_frame_of_ours_is_not_taken_for_an_echo_for_ever(monkeypatch):
    async def session():
        async with a_bus() as (bus, _reader, writer, ear):
            bus.send([HEADING])
            then = bus._loop.time
            monkeypatch.setattr(bus._loop, "time", lambda: then() + ECHO_WITHIN + 0.1)
            writer.write(b"12:00:00.000 T " + AS_CLIENT)
            await until(lambda: ear.frames == [HEADING])

    asyncio.run(session())


def test_what_was_begun_before_the_connection_was_lost_is_not_joined_to_what_comes_after():
    async def session():
        async with a_bus() as (bus, _reader, writer, ear):
            writer.write(b"12:00:00.000 R 09F11223 FF 10 2")
            await until(lambda: bus.counters.bytes_in == 31)
            bus._port_changed(False, "")
            writer.write(b"09F11217 00 00 00 00 00 00 00 00\r\n")
            await until(lambda: ear.frames)
            assert ear.frames == [OTHERS]

    asyncio.run(session())


def test_a_message_to_one_device_is_dropped_and_counted_where_the_form_has_no_destination():
    async def session():
        async with a_bus("seasmart") as (bus, reader, _writer, _ear):
            bus.send([Frame(0x18EA7F23, b"\0\xee\0"), HEADING])
            assert await reader.readline() == b"$PCDIN,01F112,00000000,23,FF10270080FF7FFD*5B\r\n"
            assert bus.counters.dropped == 1

    asyncio.run(session())


def test_every_form_goes_over_every_link_that_carries_bytes():
    for form in ("ydraw", "candump", "n2kascii", "seasmart"):
        bus = bus_link(f"{form}+udp://:1456", name="bus")
        assert isinstance(bus, TextBus)
        assert (bus.url, bus.name, bus.form) == (f"{form}+udp://:1456", "bus", form)
    assert parse("ydraw+serial:///dev/ttyUSB0?baud=230400").values["over"] == "serial:///dev/ttyUSB0?baud=230400"


BAD = {
    "ydrow+tcp://h:1": 'unknown form "ydrow" (did you mean "ydraw"?)',
    "ydraw+loop://x": "ydraw is text, and loop carries none",
    "ydraw+tcp://h": "a port is missing",
    "ydraw+ydraw+tcp://h:1": "ydraw is text, and ydraw+tcp carries none",
}


@pytest.mark.parametrize("url", BAD)
def test_a_bad_url_says_what_is_wrong_in_it(url):
    with pytest.raises(LinkError) as refusal:
        parse(url)
    assert BAD[url] in str(refusal.value)
