"""Many readers served at once: each gets what it would get without the others, and every byte is counted."""

import asyncio
import os
import random
import socket
from contextlib import asynccontextmanager

import pytest

from tests.unit.links.far_side import Ear, line, until
from timonel.core.effects import Say
from timonel.links.fan import Fan, is_fanned
from timonel.links.inner import InnerLink
from timonel.links.tcp_listen import TcpListenLink
from timonel.links.wire import Port, Wire

HERE = "127.0.0.1"


class Pair(Port):
    """A port on one end of a socket pair; `far` is the other one. `room` is asked for as on a serial port."""

    PAUSE = 0.01

    def __init__(self, name="", room=None) -> None:
        super().__init__(name=name)
        self.far = None
        self.reachable = True
        self._asked = room

    async def _make_wire(self) -> Wire:
        if not self.reachable:
            raise OSError("nobody there")
        if self.far is not None:
            self.far.close()
        near, self.far = socket.socketpair()
        near.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        self.far.setblocking(False)
        return Wire(
            near.fileno(),
            receive=self._receive,
            lost=self._lost,
            release=near.close,
            tally=self._tally,
            room=self._asked,
        )

    def hear(self) -> bytes:
        got = b""
        try:
            while data := self.far.recv(65536):
                got += data
        except BlockingIOError:
            pass
        return got


@asynccontextmanager
async def opened(*links):
    for link in links:
        ear = Ear()
        await link.open(ear.receive, ear.changed)
    yield
    for link in links:
        await link.close(0.0)
        if isinstance(link, Pair):
            link.far.close()


async def connected(link: TcpListenLink, count: int) -> list[socket.socket]:
    readers = [socket.create_connection(link.address) for _ in range(count)]
    for reader in readers:
        reader.setblocking(False)
    await until(lambda: len(link.outlets()[0]) == count)
    return readers


def test_every_reader_of_every_link_gets_a_batch_in_one_write_and_its_bytes_are_counted(monkeypatch):
    async def session():
        ports, listeners = [Pair(), Pair()], TcpListenLink(HERE, 0)
        fan = Fan([*ports, listeners])
        async with opened(*ports, listeners):
            readers = await connected(listeners, 3)
            writes, write = [], os.write
            monkeypatch.setattr(os, "write", lambda fd, data: writes.append(data) or write(fd, data))
            fan.send([line("one"), line("two")])
            assert writes == [b"one\r\ntwo\r\n"] * 5
            monkeypatch.undo()
            fan.send([line("three")])
            said = b"one\r\ntwo\r\nthree\r\n"
            assert [port.hear() for port in ports] == [said, said]
            assert [reader.recv(100) for reader in readers] == [said] * 3
            assert [port.counters.bytes_out for port in ports] == [len(said)] * 2
            assert listeners.counters.bytes_out == listeners.counters.bytes_out == 3 * len(said)
            for reader in readers:
                reader.close()

    asyncio.run(session())


def test_a_reader_that_comes_or_goes_between_two_batches_gets_those_of_its_time():
    async def session():
        listeners = TcpListenLink(HERE, 0)
        fan = Fan([listeners])
        async with opened(listeners):
            (first,) = await connected(listeners, 1)
            fan.send([line("one")])
            (second,) = (socket.create_connection(listeners.address),)
            await until(lambda: len(listeners.outlets()[0]) == 2)
            fan.send([line("two")])
            assert first.recv(100) == b"one\r\ntwo\r\n"
            first.close()
            await until(lambda: len(listeners.outlets()[0]) == 1)
            fan.send([line("three")])
            assert second.recv(100) == b"two\r\nthree\r\n"
            assert listeners.counters.bytes_out == len(b"one\r\ntwo\r\n" + b"two\r\nthree\r\n")
            second.close()

    asyncio.run(session())


def test_a_reader_that_stops_reading_delays_nobody_and_wakes_to_the_newest():
    async def session():
        lazy, quick = Pair(), Pair()
        fan = Fan([lazy, quick])
        async with opened(lazy, quick):
            heard, number = b"", 0
            while not lazy.busy:
                number += 1
                fan.send([line(f"{number:0200}", "old")])
                heard += quick.hear()
            for newer in range(1000):
                fan.send([line(f"newer {newer}", "new")])
                heard += quick.hear()
            assert heard.count(b"\n") == number + 1000
            assert (quick.counters.bytes_out, quick.counters.replaced) == (len(heard), 0)
            late = lazy.hear()
            await until(lambda: not lazy.busy)
            late += lazy.hear()
            assert late.endswith(b"newer 999\r\n")
            assert (lazy.counters.bytes_out, lazy.counters.replaced) == (len(late), 999)
            fan.send([line("again")])
            assert (lazy.hear(), quick.hear()) == (b"again\r\n", b"again\r\n")

    asyncio.run(session())


def test_a_reader_that_is_gone_harms_no_other_and_what_it_does_not_get_is_counted():
    async def session():
        gone, other = Pair(), Pair()
        fan = Fan([gone, other])
        async with opened(gone, other):
            fan.send([line("one")])
            gone.reachable = False
            gone.far.close()
            fan.send([line("two")])
            fan.send([line("three")])
            await until(lambda: gone._wire is None)
            fan.send([line("four")])
            assert other.hear() == b"one\r\ntwo\r\nthree\r\nfour\r\n"
            assert (gone.counters.bytes_out, gone.counters.dropped) == (len(b"one\r\n"), 3)
            gone.reachable = True
            await until(lambda: gone.outlets()[0])
            fan.send([line("five")])
            assert gone.hear() == b"five\r\n"

    asyncio.run(session())


def test_a_port_whose_room_is_asked_for_is_not_written_to_while_it_has_none():
    async def session():
        room = [5]
        narrow, other = Pair(room=lambda: room.pop() if room else 0), Pair()
        fan = Fan([narrow, other])
        async with opened(narrow, other):
            fan.send([line("one")])
            fan.send([line("0123456789")])
            assert narrow.hear() == b"one\r\n"
            assert other.hear() == b"one\r\n0123456789\r\n"
            assert narrow.busy

    asyncio.run(session())


@pytest.mark.parametrize("seed", range(5))
def test_with_and_without_a_fan_the_same_lines_reach_readers_of_the_same_patience(seed):
    async def heard(fanned: bool) -> list[tuple[bytes, int, int, int]]:
        chance = random.Random(seed)
        ports = [Pair(str(number)) for number in range(3)]
        got = [b"", b"", b""]
        fan = Fan(ports) if fanned else None
        async with opened(*ports):
            for number in range(400):
                keys = chance.choices("abc", k=chance.randint(1, 3))
                urgent = chance.random() < 0.2
                lines = [Say(f"{key}{number:060}\r\n".encode(), key, urgent=urgent) for key in keys]
                for sender in (fan,) if fan else ports:
                    sender.send(lines)
                if chance.random() < 0.1:
                    reader = chance.randrange(3)
                    got[reader] += ports[reader].hear()
                if chance.random() < 0.1:
                    await asyncio.sleep(0)
                    await asyncio.sleep(0)
            for number, port in enumerate(ports):
                while port.busy:
                    got[number] += port.hear()
                    await asyncio.sleep(0)
                got[number] += port.hear()
            counted = [port.counters for port in ports]
        return [(data, c.bytes_out, c.replaced, c.dropped) for data, c in zip(got, counted, strict=True)]

    async def session():
        assert await heard(fanned=True) == await heard(fanned=False)

    asyncio.run(session())


def test_only_links_of_wires_have_a_fan():
    assert is_fanned(Pair())
    assert is_fanned(TcpListenLink(HERE, 0))
    assert not is_fanned(InnerLink(name="console"))
