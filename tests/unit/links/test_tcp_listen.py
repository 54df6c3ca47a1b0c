import asyncio
import errno
import socket
from contextlib import asynccontextmanager

from tests.unit.links.far_side import Ear, descriptors, line, until
from timonel.links import tcp_listen
from timonel.links.tcp_listen import TcpListenLink


@asynccontextmanager
async def listening(port=0):
    ear = Ear()
    link = TcpListenLink("127.0.0.1", port)
    await link.open(ear.receive, ear.changed)
    yield link, ear
    await link.close()


async def reader_of(link: TcpListenLink, *, buffer: int = 0) -> socket.socket:
    """A connected client that the link knows of."""
    stream = socket.socket()
    if buffer:
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
    stream.setblocking(False)
    known = len(link._readers)
    await asyncio.get_running_loop().sock_connect(stream, link.address)
    await until(lambda: len(link._readers) > known)
    return stream


async def read_until(stream: socket.socket, end: bytes) -> bytes:
    got = b""
    async with asyncio.timeout(10):
        while not got.endswith(end):
            got += await asyncio.get_running_loop().sock_recv(stream, 65536)
    return got


def test_every_reader_hears_every_line():
    async def session():
        async with listening() as (link, _):
            readers = [await reader_of(link) for _ in range(8)]
            link.send([line("$IIHDT,1.0,T"), line("$IIDPT,5.0")])
            for reader in readers:
                assert await read_until(reader, b"5.0\r\n") == b"$IIHDT,1.0,T\r\n$IIDPT,5.0\r\n"
                reader.close()

    asyncio.run(session())


def test_what_every_reader_is_told_first_comes_before_all_else():
    async def session():
        async with listening() as (link, _):
            link.greeting = lambda: b"hello\r\n"
            readers = [await reader_of(link) for _ in range(2)]
            link.send([line("$IIDPT,5.0")])
            for reader in readers:
                assert await read_until(reader, b"5.0\r\n") == b"hello\r\n$IIDPT,5.0\r\n"
                reader.close()

    asyncio.run(session())


def test_a_reader_that_stops_reading_delays_nobody_and_wakes_to_the_newest():
    async def session():
        async with listening() as (link, _):
            sleeper, awake = await reader_of(link, buffer=4096), await reader_of(link)
            for number in range(20_000):
                link.send([line(f"$IIHDT,{number:06},T", "HDT")])
                if number % 100 == 99:
                    await read_until(awake, b"%06d,T\r\n" % number)
            link.send([line("$PARP,CMDTRANSFER", "PARP", urgent=True), line("$IIDPT,5.0", "DPT")])
            assert link.counters.replaced > 10_000
            backlog = link._readers[min(link._readers)]._backlog
            assert len(backlog.head(1_000_000)) < 100
            got = await read_until(sleeper, b"$IIDPT,5.0\r\n")
            lines = got.split(b"\r\n")[:-1]
            assert set(map(len, lines)) == {15, 17, 10}
            assert lines[-3:] == [b"$PARP,CMDTRANSFER", b"$IIHDT,019999,T", b"$IIDPT,5.0"]
            sleeper.close()
            awake.close()

    asyncio.run(session())


def test_the_half_lines_of_two_clients_are_never_mixed():
    async def session():
        async with listening() as (link, ear):
            one, two = await reader_of(link), await reader_of(link)
            one.send(b"$PARP,REQ")
            two.send(b"$PARP,TAKE")
            await until(lambda: link.counters.bytes_in == 19)
            assert ear.data == b""
            one.send(b"CMD,02*XX\r\n")
            await until(lambda: ear.data == b"$PARP,REQCMD,02*XX\r\n")
            two.send(b"CMD,01*XX\r\nrest")
            await until(lambda: ear.data.endswith(b"$PARP,TAKECMD,01*XX\r\n"))
            one.close()
            two.close()

    asyncio.run(session())


def test_readers_come_and_go_and_the_number_of_them_is_told():
    async def session():
        async with listening() as (link, ear):
            before = descriptors()
            for _ in range(3):
                one, two = await reader_of(link), await reader_of(link)
                one.close()
                two.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")  # leave by RST
                two.close()
                await until(lambda: not link._readers)
                link.send([line("to nobody")])
            assert descriptors() == before
            told = ["", "readers: 1", "readers: 2", "readers: 1", ""]
            assert ear.changes[:5] == [(True, reason) for reason in told]

    asyncio.run(session())


def test_a_reader_that_goes_while_it_is_written_to_harms_no_other():
    async def session():
        async with listening() as (link, ear):
            gone, there = await reader_of(link), await reader_of(link)
            gone.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\1\0\0\0\0\0\0\0")
            gone.close()
            link.send([line("one")])
            link.send([line("two")])
            assert await read_until(there, b"two\r\n") == b"one\r\ntwo\r\n"
            await until(lambda: ear.changes[-1] == (True, "readers: 1"))
            there.close()

    asyncio.run(session())


def test_more_readers_than_the_limit_are_turned_away_and_counted(monkeypatch):
    monkeypatch.setattr(tcp_listen, "READERS_MAX", 1)

    async def session():
        async with listening() as (link, _):
            first, second = await reader_of(link), socket.create_connection(link.address)
            await until(lambda: link.counters.rejected == 1)
            assert second.recv(1) == b""
            link.send([line("still served")])
            assert await read_until(first, b"\r\n") == b"still served\r\n"
            first.close()
            second.close()

    asyncio.run(session())


class Exhausted:
    """A listening socket in a process without descriptors, as long as `fault` is set."""

    def __init__(self, server: socket.socket) -> None:
        self.server = server
        self.fault: int | None = errno.EMFILE
        self.knocks = 0

    def accept(self):
        self.knocks += 1
        if self.fault is not None:
            raise OSError(self.fault, "exhausted")
        return self.server.accept()

    def __getattr__(self, name: str):
        return getattr(self.server, name)


def test_without_descriptors_it_rests_instead_of_spinning_and_then_goes_on(monkeypatch):
    monkeypatch.setattr(tcp_listen, "REST", 0.05)

    async def session():
        async with listening() as (link, ear):
            link._server = poor = Exhausted(link._server)
            stream = socket.create_connection(link.address)
            await asyncio.sleep(0.12)
            assert 1 <= poor.knocks <= 3
            assert ear.connected
            poor.fault = None
            await until(lambda: link._readers)
            assert link.counters.errors == poor.knocks - 2  # the last two: the one who came, and nobody more
            stream.close()

    asyncio.run(session())


def test_a_port_that_is_taken_is_told_and_tried_again(monkeypatch):
    monkeypatch.setattr(TcpListenLink, "PAUSE", 0.01)

    async def session():
        with socket.socket() as other:
            other.bind(("127.0.0.1", 0))
            other.listen()
            port = other.getsockname()[1]
            async with listening(port) as (link, ear):
                await until(lambda: ear.changes)
                assert ear.changes == [(False, "Address already in use")]
                assert link.address is None
                other.close()
                await until(lambda: ear.connected)
                assert link.address == ("127.0.0.1", port)

    asyncio.run(session())


def test_close_gives_readers_what_waits_for_them():
    async def session():
        async with listening() as (link, _):
            reader = await reader_of(link, buffer=4096)
            while not link._pending():
                link.send([line("x" * 200, str(number)) for number in range(50)])
            link.send([line("last words")])
            reading = asyncio.create_task(read_until(reader, b"last words\r\n"))
            await link.close(drain=5)
            await reading
            reader.close()

    asyncio.run(session())


@asynccontextmanager
async def raw():
    ear = Ear()
    link = TcpListenLink("127.0.0.1", 0, raw=True)
    await link.open(ear.receive, ear.changed)
    yield link, ear
    await link.close()


def test_raw_bytes_are_delivered_as_they_come():
    async def session():
        async with raw() as (link, ear):
            one = await reader_of(link)
            for piece in (b"#\x64", b"\x00", b"\x9c"):
                one.send(piece)
                heard = len(ear.data)
                await until(lambda heard=heard: len(ear.data) > heard)
            assert ear.data == b"#\x64\x00\x9c"
            one.close()

    asyncio.run(session())


def test_of_raw_clients_one_has_the_voice_and_all_hear():
    async def session():
        async with raw() as (link, ear):
            first, second = await reader_of(link), await reader_of(link)
            first.send(b"first")
            await until(lambda: ear.data == b"first")
            second.send(b"second")
            await until(lambda: link.counters.rejected == 1)
            first.send(b" again")
            await until(lambda: ear.data == b"first again")
            link.send([line("to all")])
            for reader in (first, second):
                assert await read_until(reader, b"\r\n") == b"to all\r\n"
                reader.close()

    asyncio.run(session())


def test_when_who_had_the_voice_leaves_it_is_told_and_the_next_who_speaks_has_it():
    async def session():
        async with raw() as (link, ear):
            first, second = await reader_of(link), await reader_of(link)
            first.send(b"1")
            await until(lambda: ear.data == b"1")
            first.close()
            await until(lambda: ear.changes[-1] == (False, "who spoke has left"))
            second.send(b"2")
            await until(lambda: ear.data == b"12")
            assert ear.changes[-3:] == [
                (True, "somebody speaks"), (False, "who spoke has left"), (True, "somebody speaks"),
            ]  # fmt: skip
            second.close()

    asyncio.run(session())


def test_who_has_the_voice_and_is_silent_loses_it_to_the_next(monkeypatch):
    monkeypatch.setattr(tcp_listen, "SILENT", 0.05)

    async def session():
        async with raw() as (link, ear):
            first, second = await reader_of(link), await reader_of(link)
            first.send(b"1")
            await until(lambda: ear.data == b"1")
            await asyncio.sleep(0.06)
            second.send(b"2")
            await until(lambda: ear.data == b"12")
            first.send(b"3")
            await until(lambda: link.counters.rejected == 1)
            first.close()
            await until(lambda: len(link._readers) == 1)
            assert ear.changes[-2:] == [(True, "somebody speaks")] * 2
            second.close()

    asyncio.run(session())


def test_a_new_voice_is_told_before_it_is_heard():
    async def session():
        order = []
        link = TcpListenLink("127.0.0.1", 0, raw=True)
        await link.open(order.append, lambda connected, reason: order.append(reason))
        one = await reader_of(link)
        one.send(b"#e\xce")
        await until(lambda: b"#e\xce" in order)
        assert order == ["", "somebody speaks", b"#e\xce"]
        one.close()
        await link.close()

    asyncio.run(session())
