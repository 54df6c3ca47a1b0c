import asyncio
import socket
from contextlib import asynccontextmanager

from tests.unit.links.far_side import Ear, line, until
from timonel.links.iec450 import HEADER, LINES_MAX, Iec450Link
from timonel.links.urls import byte_link
from timonel.nmea0183.tag_block import TagBlock, write

GROUP, LOOPBACK = "239.192.0.4", "127.0.0.1"
HDT = b"$HEHDT,182.3,T*2F\r\n"


def free_port() -> int:
    with socket.socket(type=socket.SOCK_DGRAM) as any_port:
        any_port.bind((LOOPBACK, 0))
        return any_port.getsockname()[1]


def far_end(port: int) -> socket.socket:
    """Another system in the group, on the loopback interface alone."""
    far = socket.socket(type=socket.SOCK_DGRAM)
    far.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    far.bind((GROUP, port))
    far.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, socket.inet_aton(GROUP) + socket.inet_aton(LOOPBACK))
    far.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(LOOPBACK))
    far.settimeout(5)
    return far


@asynccontextmanager
async def opened():
    port, ear = free_port(), Ear()
    link = byte_link(f"iec450://{GROUP}:{port}?source=II0007&interface={LOOPBACK}", name="NAVD")
    await link.open(ear.receive, ear.changed)
    with far_end(port) as far:
        yield link, ear, far, (GROUP, port)
    await link.close()


def test_a_batch_is_one_datagram_of_tagged_lines_that_are_counted():
    async def scene():
        async with opened() as (link, ear, far, _):
            link.send([line("$IIHDT,1.0,T*2F"), line("$IIDPT,5.0*00")])
            data = far.recv(2000)
            first, second = (write(TagBlock("II0007", line=number)) for number in (1, 2))
            assert data == HEADER + first + b"$IIHDT,1.0,T*2F\r\n" + second + b"$IIDPT,5.0*00\r\n"
            assert ear.data == b""  # what we sent came back to us, and was not heard
            link._line = LINES_MAX
            link.send([line("$IIHDT,1.0,T*2F")])
            assert b",n:1*" in far.recv(2000)

    asyncio.run(scene())


def test_what_others_in_the_group_say_is_heard_without_their_tags():
    async def scene():
        async with opened() as (link, ear, far, group):
            tagged = write(TagBlock("HE0001", line=1)) + HDT
            far.sendto(HEADER + tagged + HDT + write(TagBlock("HE0001", "II0007", 2)) + HDT, group)
            await until(lambda: ear.data)
            assert ear.data == HDT * 3
            assert link.counters.rejected == 0

    asyncio.run(scene())


def test_what_is_broken_for_others_or_of_another_kind_is_counted_and_not_heard():
    async def scene():
        async with opened() as (link, ear, far, group):
            far.sendto(b"RaUdP\0" + bytes(30), group)
            far.sendto(HEADER + b"\\s:HE0001*00\\" + HDT + write(TagBlock("HE0001", "EI0001")) + HDT, group)
            far.sendto(HEADER + b"\\s:HE0001", group)
            far.sendto(HEADER + write(TagBlock("HE0001")) + HDT, group)
            await until(lambda: ear.data)
            assert ear.data == HDT
            assert link.counters.rejected == 4

    asyncio.run(scene())


def test_the_parts_of_a_long_message_are_marked_as_one_group():
    async def scene():
        async with opened() as (link, _, far, _):
            link.send([line("!AIVDM,2,1,3,A,55?*00"), line("!AIVDM,2,2,3,A,88*00"), line("!AIVDM,1,1,,A,13*00")])
            link.send([line("!AIVDM,2,1,4,B,55?*00")])
            data = far.recv(2000) + far.recv(2000)
            groups = [text.split(b",")[0] for text in data.split(b"\\")[1::2]]
            assert groups == [b"g:1-2-1", b"g:2-2-1", b"s:II0007", b"g:1-2-2"]

    asyncio.run(scene())


def test_a_batch_that_is_too_long_is_several_datagrams():
    async def scene():
        async with opened() as (link, _, far, _):
            link.send([line("$IIXDR," + "x" * 60)] * 40)
            sizes = [len(far.recv(2000)) for _ in range(3)]
            assert max(sizes) <= 1400

    asyncio.run(scene())


def test_what_cannot_be_sent_is_counted():
    async def scene():
        link = Iec450Link(GROUP, free_port(), interface="192.0.2.1", name="NAVD")  # an address that nobody has
        ear = Ear()
        await link.open(ear.receive, ear.changed)
        assert not ear.connected
        link.send([line("$IIHDT,1.0,T*2F")])
        assert link.counters.dropped == 1
        await link.close()

    asyncio.run(scene())
