import asyncio
import socket
from contextlib import asynccontextmanager

from tests.unit.links.far_side import Ear, descriptors, line, until
from timonel.links.udp import UdpLink, datagrams


@asynccontextmanager
async def opened(host, port):
    ear = Ear()
    link = UdpLink(host, port)
    await link.open(ear.receive, ear.changed)
    yield link, ear
    await link.close()


def peer() -> socket.socket:
    stream = socket.socket(type=socket.SOCK_DGRAM)
    stream.bind(("127.0.0.1", 0))
    stream.settimeout(5)
    return stream


def test_a_batch_is_one_datagram_and_what_comes_back_is_heard():
    async def session():
        with peer() as far:
            async with opened("127.0.0.1", far.getsockname()[1]) as (link, ear):
                link.send([line("$IIHDT,1.0,T"), line("$IIDPT,5.0")])
                data, sender = far.recvfrom(2000)
                assert data == b"$IIHDT,1.0,T\r\n$IIDPT,5.0\r\n"
                far.sendto(b"$PARP,STATUS\r\n", sender)
                await until(lambda: ear.data == b"$PARP,STATUS\r\n")

    asyncio.run(session())


def test_with_a_port_of_our_own_the_far_side_is_heard_without_having_been_asked():
    async def session():
        with peer() as far, peer() as stranger, peer() as taken:
            ours = taken.getsockname()[1]
            taken.close()
            ear, link = Ear(), UdpLink(*far.getsockname(), local=ours)
            await link.open(ear.receive, ear.changed)
            stranger.sendto(b"$PARP,TAKECMD\r\n", ("127.0.0.1", ours))
            far.sendto(b"$IIHDT,1.0,T\r\n", ("127.0.0.1", ours))
            await until(lambda: ear.data)
            assert ear.data == b"$IIHDT,1.0,T\r\n"
            link.send([line("$IIDPT,5.0")])
            assert far.recvfrom(2000) == (b"$IIDPT,5.0\r\n", ("127.0.0.1", ours))
            await link.close()

    asyncio.run(session())


def test_a_stranger_is_not_heard_by_a_link_to_a_host():
    async def session():
        with peer() as far, peer() as stranger:
            async with opened("127.0.0.1", far.getsockname()[1]) as (link, ear):
                stranger.sendto(b"$PARP,TAKECMD\r\n", link.address)
                far.sendto(b"$PARP,STATUS\r\n", link.address)
                await until(lambda: ear.data)
                assert ear.data == b"$PARP,STATUS\r\n"

    asyncio.run(session())


def test_a_listening_link_hears_everybody_and_never_joins_two_datagrams():
    async def session():
        with peer() as one, peer() as two:
            async with opened(None, 0) as (link, ear):
                to = ("127.0.0.1", link.address[1])
                one.sendto(b"$IIHDT,1.0,T", to)
                two.sendto(b"", to)
                two.sendto(b"$IIDPT,5.0\r\n", to)
                await until(lambda: ear.data == b"$IIHDT,1.0,T\r\n$IIDPT,5.0\r\n")
                link.send([line("to nobody")])
                assert link.counters.dropped == 1

    asyncio.run(session())


def test_nobody_listening_is_counted_and_stops_nothing():
    async def session():
        with peer() as far:
            port = far.getsockname()[1]
        async with opened("127.0.0.1", port) as (link, ear):
            link.send([line("one")])
            await until(lambda: link.counters.errors)
            link.send([line("two")])
            with socket.socket(type=socket.SOCK_DGRAM) as far:
                far.bind(("127.0.0.1", port))
                far.settimeout(5)
                link.send([line("three")])
                link.send([line("three")])
                assert far.recv(100) == b"three\r\n"
            assert ear.changes == [(True, "")]

    asyncio.run(session())


def test_lines_are_packed_whole_and_in_order_up_to_1400_bytes():
    lines = [line(f"{number:098}") for number in range(29)]
    packed = list(datagrams(lines))
    assert [count for _, count in packed] == [14, 14, 1]
    assert [len(data) for data, _ in packed] == [1400, 1400, 100]
    assert b"".join(data for data, _ in packed) == b"".join(say.line for say in lines)
    assert list(datagrams([])) == []


def test_an_unknown_host_is_told_and_leaks_nothing(monkeypatch):
    monkeypatch.setattr(UdpLink, "PAUSE", 0.01)

    async def session():
        before = descriptors()
        async with opened("host.invalid", 10110) as (link, ear):
            await until(lambda: ear.changes)
            assert not ear.connected
            assert link.address is None
            link.send([line("dropped")])
            assert link.counters.dropped == 1
        assert descriptors() == before

    asyncio.run(session())
