import asyncio
from contextlib import asynccontextmanager

from tests.unit.gateway.fakes import FakeBus, FakePort, FakeVehicle
from tests.unit.links.far_side import until
from timonel.core.effects import Transmit
from timonel.core.frame import Frame
from timonel.gateway.frame_output import ON_THE_BUS, FrameOutput, FrameOutputs
from timonel.gateway.gateway import Gateway
from timonel.links.tcp_listen import TcpListenLink

OURS = 0x23
HEARD = Frame(0x09F11217, bytes(8))
STEERING = Frame(0x09F10523, b"\x20\x15" + bytes(6))
REQUEST = Frame(0x18EAFF40, bytes.fromhex("00ee00"))
AS_CLIENT = b"18EAFF40 00 EE 00\r\n"


class Rig:
    def __init__(self, form, transmit=True, rate=400) -> None:
        self.writers = []
        self.vehicle = FakeVehicle()
        self.bus = FakeBus()
        self.gateway = Gateway(self.vehicle, self.bus, [])
        self.link = TcpListenLink("127.0.0.1", 0, name="Raw")
        self.other = FakePort("Other")
        outputs = [FrameOutput(self.link, form, transmit, rate), FrameOutput(self.other, "ydraw", transmit, rate)]
        self.outputs = FrameOutputs(self.gateway, outputs, lambda: OURS)

    async def client(self):
        already = len(self.link._readers)
        ends = await asyncio.open_connection(*self.link.address)
        self.writers.append(ends[1])
        await until(lambda: len(self.link._readers) > already)
        return ends

    @property
    def counted(self):
        return dict(self.gateway.health._watched["Raw frames"]())


@asynccontextmanager
async def a_rig(form="ydraw", **how):
    rig = Rig(form, **how)
    await rig.gateway.open()
    try:
        yield rig
    finally:
        for writer in rig.writers:
            writer.close()
    await rig.gateway.close()


async def untimed(reader) -> bytes:
    """A line without its time."""
    return (await asyncio.wait_for(reader.readline(), 5)).split(b" ", 1)[1]


def test_listeners_hear_what_the_bus_says_and_what_we_say_told_apart() -> None:
    async def scene() -> None:
        async with a_rig() as rig:
            reader, _ = await rig.client()
            rig.vehicle.answers["frames"] = [Transmit(STEERING)]
            rig.bus.receive([HEARD])
            assert await untimed(reader) == b"R 09F11217 00 00 00 00 00 00 00 00\r\n"
            assert await untimed(reader) == b"T 09F10523 20 15 00 00 00 00 00 00\r\n"

    asyncio.run(scene())


def test_what_a_listener_sends_goes_on_the_bus_is_heard_by_us_and_told_to_all_as_sent() -> None:
    async def scene() -> None:
        async with a_rig() as rig:
            (reader, writer), (reader_2, _) = await rig.client(), await rig.client()
            writer.write(AS_CLIENT)
            assert await untimed(reader) == b"T 18EAFF40 00 EE 00\r\n"
            assert await untimed(reader_2) == b"T 18EAFF40 00 EE 00\r\n"
            assert [line.split(b" ", 1)[1] for line in rig.other.lines] == [b"T 18EAFF40 00 EE 00\r\n"]
            assert rig.bus.batches == [[REQUEST]]
            assert rig.vehicle.told == [("frames", REQUEST)]
            assert rig.counted["transmitted"] == 1

    asyncio.run(scene())


def test_where_the_form_has_no_marks_who_sent_a_frame_does_not_get_it_back() -> None:
    async def scene() -> None:
        async with a_rig("candump") as rig:
            (reader, writer), (reader_2, _) = await rig.client(), await rig.client()
            writer.write(b"(1.0) can0 18EAFF40#00EE00\r\n")
            assert (await untimed(reader_2)) == b"can0 18EAFF40#00EE00\r\n"
            rig.bus.receive([HEARD])
            assert (await untimed(reader)) == b"can0 09F11217#0000000000000000\r\n"

    asyncio.run(scene())


def test_our_answer_to_a_listeners_question_is_told_to_it_too() -> None:
    async def scene() -> None:
        async with a_rig("candump") as rig:
            reader, writer = await rig.client()
            rig.vehicle.answers["frames"] = [Transmit(STEERING)]
            writer.write(b"(1.0) can0 18EAFF40#00EE00\r\n")
            assert (await untimed(reader)) == b"can0 09F10523#2015000000000000\r\n"

    asyncio.run(scene())


def test_whole_messages_of_a_listener_are_frames_on_the_bus() -> None:
    async def scene() -> None:
        async with a_rig("n2kascii") as rig:
            _, writer = await rig.client()
            writer.write(b"A000000.000 40FF3 1ED00 01EF010102030405060708\r\n")
            await until(lambda: rig.bus.batches)
            assert [frame.identifier for frame in rig.bus.batches[0]] == [0x0DEDFF40] * 2
            assert rig.bus.batches[0][0].data[1:] == bytes.fromhex("0b01ef010102 03".replace(" ", ""))

    asyncio.run(scene())


def test_listeners_that_may_not_transmit_are_not_heard() -> None:
    async def scene() -> None:
        async with a_rig(transmit=False) as rig:
            reader, writer = await rig.client()
            writer.write(AS_CLIENT)
            await until(lambda: rig.link.counters.bytes_in == len(AS_CLIENT))
            rig.bus.receive([HEARD])
            assert await untimed(reader) == b"R 09F11217 00 00 00 00 00 00 00 00\r\n"
            assert rig.bus.batches == []

    asyncio.run(scene())


def test_nobody_speaks_from_our_own_address_nor_repeats_what_was_sent_nor_speaks_another_protocol() -> None:
    async def scene() -> None:
        async with a_rig() as rig:
            _, writer = await rig.client()
            writer.write(b"18EAFF23 00 EE 00\r\n12:00:00.000 T 18EAFF40 00 EE 00\r\nhello\r\n" + AS_CLIENT)
            await until(lambda: rig.bus.batches)
            assert rig.bus.batches == [[REQUEST]]
            assert rig.counted == {
                "from our own address": 1,
                "not to be sent": 1,
                "lines not understood": 1,
                "transmitted": 1,
            }

    asyncio.run(scene())


def test_a_listener_cannot_flood_the_bus() -> None:
    async def scene() -> None:
        async with a_rig(rate=10) as rig:
            _, writer = await rig.client()
            writer.write(AS_CLIENT * 50)
            await until(lambda: rig.link.counters.bytes_in == 50 * len(AS_CLIENT))
            assert sum(map(len, rig.bus.batches)) == 10
            assert rig.counted["beyond the allowance"] == 40

    asyncio.run(scene())


def test_a_message_of_which_the_allowance_has_not_room_for_all_frames_is_not_begun() -> None:
    async def scene() -> None:
        async with a_rig("n2kascii", rate=1) as rig:
            _, writer = await rig.client()
            line = b"A000000.000 40FF3 1ED00 01EF010102030405060708\r\n"
            writer.write(line)
            await until(lambda: rig.link.counters.bytes_in == len(line))
            assert rig.bus.batches == []

    asyncio.run(scene())


def test_two_gateways_on_one_backbone_that_listen_to_each_other_do_not_make_a_storm() -> None:
    """What the other one heard on the bus too, and tells us, is not put there again."""

    async def scene() -> None:
        async with a_rig("candump") as rig:
            reader, writer = await rig.client()
            for _ in range(10):
                rig.bus.receive([HEARD])
                writer.write(await reader.readline())
            await until(lambda: rig.counted.get("from the address of a device of the bus") == 10)
            assert rig.bus.batches == []

    asyncio.run(scene())


def test_a_listener_may_speak_for_a_device_that_fell_silent_on_the_bus(monkeypatch) -> None:
    async def scene() -> None:
        async with a_rig("candump") as rig:
            reader, writer = await rig.client()
            rig.bus.receive([HEARD])
            line, then = await reader.readline(), rig.gateway._loop.time
            monkeypatch.setattr(rig.gateway._loop, "time", lambda: then() + ON_THE_BUS)
            writer.write(line)
            await until(lambda: rig.bus.batches)
            assert rig.bus.batches == [[HEARD]]

    asyncio.run(scene())


def test_a_claim_of_an_address_that_is_taken_is_settled_on_the_bus() -> None:
    async def scene() -> None:
        async with a_rig() as rig:
            _, writer = await rig.client()
            rig.bus.receive([HEARD])
            writer.write(b"18EEFF17 01 02 03 04 05 06 07 C0\r\n18EEFF23 01 02 03 04 05 06 07 C0\r\n")
            await until(lambda: rig.counted.get("transmitted") == 2)
            assert [frame.identifier & 0xFF for frame in rig.bus.batches[0]] == [0x17, OURS]

    asyncio.run(scene())


def test_a_peer_that_comes_back_does_not_finish_the_line_that_it_had_begun() -> None:
    async def scene() -> None:
        async with a_rig() as rig:
            rig.other.receive(b"18EAFF40 00 E")
            rig.other.changed(False, "gone")
            rig.other.changed(True, "")
            rig.other.receive(AS_CLIENT)
            assert rig.bus.batches == [[REQUEST]]

    asyncio.run(scene())


def test_a_listener_that_does_not_read_loses_the_oldest_frames_and_they_are_counted() -> None:
    async def scene() -> None:
        async with a_rig() as rig:
            await rig.client()
            for _ in range(200):
                rig.bus.receive([HEARD] * 200)
            [reader] = rig.link._readers.values()
            assert len(reader._backlog._urgent) == 2048
            assert rig.link.counters.dropped > 0

    asyncio.run(scene())
