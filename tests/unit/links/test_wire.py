import asyncio
import os
import socket
from contextlib import contextmanager

from tests.unit.links.far_side import line, until
from timonel.links.link import Counters
from timonel.links.wire import READ_AT_ONCE, Wire


@contextmanager
def wired(**settings):
    """A wire on one end of a socket pair with small buffers, the other end, and what the wire reports."""
    near, far = socket.socketpair()
    near.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    far.setblocking(False)
    heard, losses, tally = [], [], Counters()
    wire = Wire(
        near.fileno(),
        receive=heard.append,
        lost=losses.append,
        release=near.close,
        tally=tally,
        **settings,
    )
    yield wire, far, heard, losses, tally
    wire.close()
    far.close()


def drain(far: socket.socket) -> bytes:
    got = b""
    try:
        while data := far.recv(65536):
            got += data
    except BlockingIOError:
        pass
    return got


def fill(wire: Wire) -> int:
    """Send lines of one kind until they wait; gives the number of the last."""
    number = 0
    while not wire.pending:
        number += 1
        wire.send([line(f"{number:0200}", "old")])
    return number


def test_a_batch_is_one_write(monkeypatch):
    writes = []
    write = os.write

    def counting(fd: int, data: bytes) -> int:
        writes.append(data)
        return write(fd, data)

    async def session():
        with wired() as (wire, _, _, _, _):
            monkeypatch.setattr(os, "write", counting)
            wire.send([line("one"), line("two"), line("three")])
            wire.send([])
            assert writes == [b"one\r\ntwo\r\nthree\r\n"]

    asyncio.run(session())


def test_a_full_descriptor_costs_no_write_until_it_is_writable_again(monkeypatch):
    async def session():
        with wired() as (wire, far, _, _, tally):
            fill(wire)
            out = tally.bytes_out
            monkeypatch.setattr(os, "write", None)
            for number in range(1000):
                wire.send([line(f"newer {number}", "new")])
                await asyncio.sleep(0)
            monkeypatch.undo()
            assert tally.bytes_out == out
            got = drain(far)
            await until(lambda: not wire.pending)
            assert (got + drain(far)).endswith(b"newer 999\r\n")
            assert tally.replaced == 999

    asyncio.run(session())


def test_one_port_is_read_in_small_pieces_so_that_a_flood_leaves_others_their_turn():
    async def session():
        with wired() as (_, far, heard, _, tally):
            flood = b"x" * 3 * READ_AT_ONCE
            sent = far.send(flood)
            await until(lambda: tally.bytes_in == sent)
            assert max(map(len, heard)) <= READ_AT_ONCE

    asyncio.run(session())


def test_a_hang_up_is_told_once_and_nothing_is_read_or_written_after_it():
    async def session():
        with wired() as (wire, far, heard, losses, tally):
            far.close()
            wire.send([line("one")])
            wire.send([line("two")])
            await until(lambda: losses)
            await asyncio.sleep(0.02)
            wire.send([line("three")])
            assert losses == ["Broken pipe"]
            assert heard == []
            assert not wire.pending
        assert tally.dropped == 3

    asyncio.run(session())


def test_the_last_words_of_one_who_left_are_heard_although_a_write_failed_first():
    async def session():
        with wired() as (wire, far, heard, losses, tally):
            far.send(b"$PARP,TAKECMD,01*XX\r\n")
            far.close()
            wire.send([line("$IIHDT,1.0,T")])
            await until(lambda: losses)
            assert heard == [b"$PARP,TAKECMD,01*XX\r\n"]
            assert tally.bytes_out == 0

    asyncio.run(session())


def test_a_wire_closed_at_the_moment_it_breaks_reads_nothing_more():
    async def session():
        with wired() as (wire, far, heard, losses, _):
            far.send(b"$PARP,TAKECMD,01*XX\r\n")
            far.close()
            wire.send([line("$IIHDT,1.0,T")])
            wire.close()
            await asyncio.sleep(0.01)
            assert (heard, losses) == ([], [])

    asyncio.run(session())


def test_the_end_of_a_stream_is_a_loss():
    async def session():
        with wired() as (_, far, _, losses, _):
            far.shutdown(socket.SHUT_WR)
            await until(lambda: losses)
            assert losses == ["closed by the other side"]

    asyncio.run(session())


def test_lines_too_old_are_dropped_when_a_stuck_descriptor_moves_again():
    async def session():
        with wired(stale_after=0.02) as (wire, far, _, _, _):
            fill(wire)
            wire.send([line("an old command", urgent=True)])
            await asyncio.sleep(0.05)
            got = drain(far)
            await until(lambda: not wire.pending)
            got += drain(far)
            assert b"an old command" not in got
            assert set(map(len, got.split(b"\r\n"))) == {200, 0}
            wire.send([line("a new command", urgent=True)])
            assert drain(far) == b"a new command\r\n"

    asyncio.run(session())


def test_a_wire_that_knows_its_room_writes_no_more_than_that():
    room = 0

    async def session():
        nonlocal room
        with wired(room=lambda: room) as (wire, far, _, _, _):
            wire.send([line("one"), line("two"), line("three")])
            assert drain(far) == b""
            room = 5
            wire.send([line("four")])
            await until(lambda: not wire.pending)
            assert drain(far) == b"one\r\ntwo\r\nthree\r\nfour\r\n"
            room = 6
            wire.send([line("12345"), line("67890")])
            assert drain(far) == b"12345\r\n"

    asyncio.run(session())
