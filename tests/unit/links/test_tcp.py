import asyncio
import socket
from contextlib import asynccontextmanager

from tests.unit.links.far_side import Ear, descriptors, line, until
from timonel.links.tcp import TcpLink
from timonel.links.urls import byte_link, commanding_link


class Server:
    """A line server that can be stopped and started again on its port."""

    def __init__(self) -> None:
        self.heard = b""
        self.clients: list[asyncio.StreamWriter] = []
        self.port = 0

    async def start(self) -> None:
        self.server = await asyncio.start_server(self._attend, "127.0.0.1", self.port)
        self.port = self.server.sockets[0].getsockname()[1]

    async def _attend(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self.clients.append(writer)
        while data := await reader.read(1000):
            self.heard += data
        writer.close()

    async def stop(self) -> None:
        self.server.close()
        for client in self.clients:
            client.close()
        await self.server.wait_closed()


@asynccontextmanager
async def connected():
    server = Server()
    await server.start()
    ear = Ear()
    link = TcpLink("127.0.0.1", server.port)
    await link.open(ear.receive, ear.changed)
    yield server, link, ear
    await link.close()
    await server.stop()


def test_bytes_go_both_ways():
    async def session():
        async with connected() as (server, link, ear):
            link.send([line("$IIHDT,1.0,T"), line("$IIDPT,5.0")])
            await until(lambda: server.heard == b"$IIHDT,1.0,T\r\n$IIDPT,5.0\r\n")
            server.clients[0].write(b"$PARP,STATUS\r\n")
            await until(lambda: ear.data == b"$PARP,STATUS\r\n")

    asyncio.run(session())


def test_a_server_that_restarts_is_reached_again_and_no_descriptor_is_leaked(monkeypatch):
    monkeypatch.setattr(TcpLink, "PAUSE", 0.01)

    async def session():
        async with connected() as (server, link, ear):
            await until(lambda: server.clients)
            before = descriptors()
            for _ in range(10):
                await server.stop()
                await until(lambda: not ear.connected)
                link.send([line("dropped")])
                await asyncio.sleep(0.03)
                server.clients.clear()
                await server.start()
                await until(lambda: ear.connected and server.clients)
            assert descriptors() == before
            assert (link.counters.reopened, link.counters.dropped) == (10, 10)
            assert ear.changes[1:3] == [(False, "closed by the other side"), (False, "Connection refused")]

    asyncio.run(session())


def test_when_open_returns_the_outcome_of_the_first_attempt_was_told():
    async def session():
        async with connected() as (_, _, ear):
            assert ear.changes == [(True, "")]

    asyncio.run(session())


def test_nobody_there_is_told_once_with_the_reason(monkeypatch):
    monkeypatch.setattr(TcpLink, "PAUSE", 0.01)

    async def session():
        with socket.socket() as reserved:
            reserved.bind(("127.0.0.1", 0))
            ear = Ear()
            link = TcpLink("127.0.0.1", reserved.getsockname()[1])
            before = descriptors()
            await link.open(ear.receive, ear.changed)
            await asyncio.sleep(0.1)
            assert ear.changes == [(False, "Connection refused")]
            await link.close()
            assert descriptors() == before

    asyncio.run(session())


def test_a_server_that_never_answers_is_given_up_and_tried_again(monkeypatch):
    monkeypatch.setattr("timonel.links.tcp.CONNECT_WITHIN", 0.05)

    async def session():
        with socket.socket() as deaf:
            deaf.bind(("127.0.0.1", 0))
            deaf.listen(0)
            crowd = [socket.socket() for _ in range(4)]
            for stream in crowd:  # fill its backlog, so that a further connection hangs
                stream.setblocking(False)
                stream.connect_ex(deaf.getsockname())
            ear = Ear()
            link = TcpLink("127.0.0.1", deaf.getsockname()[1])
            before = descriptors()
            await link.open(ear.receive, ear.changed)
            await until(lambda: ear.changes)
            assert ear.changes == [(False, "no answer")]
            assert descriptors() == before
            await link.close()
            for stream in crowd:
                stream.close()

    asyncio.run(session())


def test_a_client_that_reached_itself_is_not_connected():
    async def session():
        with socket.socket() as reserved:
            reserved.bind(("127.0.0.1", 0))
            port = reserved.getsockname()[1]
        loop = asyncio.get_running_loop()
        connect = loop.sock_connect

        async def connect_to_itself(stream: socket.socket, address: tuple[str, int]) -> None:
            stream.bind(address)
            await connect(stream, address)

        loop.sock_connect = connect_to_itself
        ear = Ear()
        link = TcpLink("127.0.0.1", port)
        await link.open(ear.receive, ear.changed)
        await until(lambda: ear.changes)
        assert ear.changes == [(False, "Connection refused")]
        await link.close()

    asyncio.run(session())


def test_close_ends_a_link_that_is_not_connected_and_one_that_was_never_opened():
    async def session():
        link = TcpLink("127.0.0.1", 1)
        await link.close()
        await link.open(lambda data: None, lambda connected, reason: None)
        await link.close()
        await link.close()

    asyncio.run(session())


def test_a_listener_whose_own_code_fails_does_not_end_the_link(monkeypatch):
    monkeypatch.setattr(TcpLink, "PAUSE", 0.01)

    async def session():
        faults = []
        asyncio.get_running_loop().set_exception_handler(lambda loop, context: faults.append(context))

        def changed(connected: bool, reason: str) -> None:
            raise ZeroDivisionError

        server = Server()
        await server.start()
        link = TcpLink("127.0.0.1", server.port)
        await link.open(lambda data: None, changed)
        await until(lambda: server.clients)
        server.clients.pop().close()
        await until(lambda: server.clients)
        assert link.counters.reopened == 1
        assert len(faults) == 3
        await link.close()
        await server.stop()

    asyncio.run(session())


def test_a_command_that_could_not_go_out_in_time_is_never_sent():
    async def what_comes_after_a_stall(make) -> bytes:
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
            ear = Ear()
            link = make(f"tcp://127.0.0.1:{server.getsockname()[1]}")
            await link.open(ear.receive, ear.changed)
            far, _ = await asyncio.to_thread(server.accept)
            with far:
                await until(lambda: ear.connected)
                for number in range(5000):
                    link.send([line(f"{number:0200}", key=str(number))])
                link.send([line("$PARP,STBDTEN,0.0,01", urgent=True)])
                await asyncio.sleep(0.6)
                heard = b""
                far.settimeout(0.3)
                try:
                    while data := await asyncio.to_thread(far.recv, 1 << 20):
                        heard += data
                except TimeoutError:
                    pass
            await link.close(drain=0)
            return heard

    assert b"STBDTEN" not in asyncio.run(what_comes_after_a_stall(commanding_link))
    assert b"STBDTEN" in asyncio.run(what_comes_after_a_stall(byte_link))
