import asyncio
import errno
import os
import termios
from contextlib import asynccontextmanager

import pytest

from tests.unit.links.far_side import Adapter, Ear, descriptors, hears, line, until
from timonel.links import serial
from timonel.links.serial import SerialLink, room_on_line


@asynccontextmanager
async def plugged(tmp_path, **settings):
    """An adapter, the link on it, and what the link says."""
    adapter = Adapter(tmp_path / "usb-adapter")
    ear = Ear()
    link = SerialLink(str(adapter.path), **settings)
    await link.open(ear.receive, ear.changed)
    yield adapter, link, ear
    await link.close()


def test_bytes_go_both_ways_however_they_are_cut(tmp_path):
    async def session():
        async with plugged(tmp_path) as (adapter, link, ear):
            adapter.say(b"$PARP,REQ")
            await until(lambda: ear.data == b"$PARP,REQ")
            adapter.say(b"CMD,02*XX\r\n")
            await until(lambda: ear.data == b"$PARP,REQCMD,02*XX\r\n")
            link.send([line("$IIHDT,1.0,T"), line("$IIDPT,5.0,0.0")])
            await hears(adapter, b"$IIHDT,1.0,T\r\n$IIDPT,5.0,0.0\r\n")
            assert ear.changes == [(True, "")]
            assert (link.counters.bytes_in, link.counters.bytes_out) == (20, 30)

    asyncio.run(session())


def test_the_line_is_raw_and_at_the_rate_asked_for(tmp_path):
    async def session():
        async with plugged(tmp_path, baud=4800) as (adapter, _, ear):
            device = os.open(adapter.path, os.O_RDWR | os.O_NOCTTY)
            iflag, oflag, cflag, lflag, _, speed, _ = termios.tcgetattr(device)
            os.close(device)
            assert speed == termios.B4800
            assert cflag & termios.CSIZE == termios.CS8
            assert not oflag & termios.OPOST
            assert not lflag & (termios.ICANON | termios.ECHO | termios.ISIG)
            assert not iflag & (termios.ICRNL | termios.IXON)
            adapter.say(b"\x03\x04\x11\r")
            await until(lambda: ear.data == b"\x03\x04\x11\r")

    asyncio.run(session())


def test_a_missing_adapter_is_told_once_and_opened_when_it_comes(tmp_path, monkeypatch):
    monkeypatch.setattr(SerialLink, "PAUSE", 0.01)

    async def session():
        ear = Ear()
        link = SerialLink(str(tmp_path / "usb-adapter"))
        await link.open(ear.receive, ear.changed)
        link.send([line("$IIHDT,1.0,T")])
        await asyncio.sleep(0.05)
        assert ear.changes == [(False, "No such file or directory")]
        adapter = Adapter(tmp_path / "usb-adapter")
        await until(lambda: ear.connected)
        adapter.say(b"here")
        await until(lambda: ear.data == b"here")
        assert ear.changes[1:] == [(True, "")]
        assert (link.counters.dropped, link.counters.reopened) == (1, 0)
        await link.close()

    asyncio.run(session())


def test_a_replugged_adapter_is_found_again_within_a_second(tmp_path):
    async def session():
        async with plugged(tmp_path) as (adapter, link, ear):
            adapter.pull()
            await until(lambda: not ear.connected)
            link.send([line("$IIHDT,old,T")])
            adapter.plug()
            await until(lambda: ear.connected, within=1.0)
            link.send([line("$IIHDT,new,T")])
            await hears(adapter, b"$IIHDT,new,T\r\n")
            assert (link.counters.dropped, link.counters.reopened) == (1, 1)

    asyncio.run(session())


def test_a_hundred_unpluggings_are_survived_and_leak_no_descriptor(tmp_path, monkeypatch):
    monkeypatch.setattr(SerialLink, "PAUSE", 0.001)

    async def session():
        async with plugged(tmp_path) as (adapter, link, ear):
            before = descriptors()
            for number in range(1, 101):
                adapter.say(b"before\r\n")
                link.send([line("$IIHDT,1.0,T")])
                adapter.pull()
                await until(lambda: not ear.connected)
                adapter.plug()
                await until(lambda: ear.connected)
                link.send([line(f"$IIDPT,{number}")])
                await hears(adapter, f"$IIDPT,{number}\r\n".encode())
            assert descriptors() == before
            assert link.counters.reopened == 100

    asyncio.run(session())


def test_an_adapter_pulled_while_lines_are_written_breaks_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr(SerialLink, "PAUSE", 0.001)

    async def session():
        async with plugged(tmp_path) as (adapter, link, ear):
            stuck = [line("x" * 200, str(number)) for number in range(500)]
            for _ in range(10):
                while not link.counters.replaced:
                    link.send(stuck)
                adapter.pull()
                link.send(stuck)
                await until(lambda: not ear.connected)
                link.send(stuck)
                adapter.plug()
                await until(lambda: ear.connected)
            link.send([line("still here")])
            await hears(adapter, b"still here\r\n")

    asyncio.run(session())


def test_two_links_cannot_share_an_adapter(tmp_path):
    async def session():
        async with plugged(tmp_path) as (adapter, _, _):
            ear = Ear()
            second = SerialLink(str(adapter.path))
            await second.open(ear.receive, ear.changed)
            await until(lambda: ear.changes)
            assert not ear.connected
            assert "already locked" in ear.changes[0][1] or ear.changes[0][1] == os.strerror(errno.EBUSY)
            await second.close()

    asyncio.run(session())


def test_what_is_no_serial_port_is_refused_with_a_reason(tmp_path):
    async def session():
        (tmp_path / "file").write_text("not a port")
        ear = Ear()
        link = SerialLink(str(tmp_path / "file"))
        await link.open(ear.receive, ear.changed)
        await until(lambda: ear.changes)
        assert ear.changes == [(False, "Inappropriate ioctl for device")]
        await link.close()

    asyncio.run(session())


def test_a_driver_is_given_no_more_than_a_tenth_of_a_second_of_its_line(monkeypatch):
    monkeypatch.setattr(serial, "held_by_driver", lambda fd: 100)
    assert room_on_line(0, 115200) == 1152 - 100
    assert room_on_line(0, 4800) == 256 - 100


def test_on_a_full_line_news_replaces_what_waits_and_urgent_lines_go_first(tmp_path, monkeypatch):
    held = 1000
    monkeypatch.setattr(serial, "held_by_driver", lambda fd: held)

    async def session():
        nonlocal held
        async with plugged(tmp_path, baud=4800) as (adapter, link, _):
            link.send([line("$IIHDT,old,T", "HDT"), line("$IIDPT,5.0", "DPT")])
            link.send([line("$IIHDT,new,T", "HDT"), line("$PARP,CMDTRANSFER", "PARP", urgent=True)])
            await asyncio.sleep(0.05)
            assert adapter.hear() == b""
            held = 0
            await hears(adapter, b"$PARP,CMDTRANSFER\r\n$IIHDT,new,T\r\n$IIDPT,5.0\r\n")
            assert link.counters.replaced == 1

    asyncio.run(session())


def test_close_lets_what_waits_go_out(tmp_path, monkeypatch):
    held = 2000
    monkeypatch.setattr(serial, "held_by_driver", lambda fd: held)

    async def session():
        nonlocal held
        async with plugged(tmp_path) as (adapter, link, _):
            link.send([line("last words")])
            held = 0
            await link.close()
            assert adapter.hear() == b"last words\r\n"

    asyncio.run(session())


def test_close_waits_for_what_the_driver_still_holds(tmp_path, monkeypatch):
    held = 0
    monkeypatch.setattr(serial, "held_by_driver", lambda fd: held)

    async def session():
        nonlocal held
        async with plugged(tmp_path) as (_, link, _):
            link.send([line("last words")])
            held = 12
            closing = asyncio.create_task(link.close(drain=10))
            await asyncio.sleep(0.03)
            assert not closing.done()
            held = 0
            await closing

    asyncio.run(session())


def test_two_lines_of_one_kind_in_one_batch_both_go_out(tmp_path):
    async def session():
        async with plugged(tmp_path) as (adapter, link, _):
            link.send([line("$IIXDR,1", "XDR"), line("$IIXDR,2", "XDR")])
            await hears(adapter, b"$IIXDR,1\r\n$IIXDR,2\r\n")

    asyncio.run(session())


def test_close_does_not_wait_for_a_line_that_never_moves(tmp_path, monkeypatch):
    monkeypatch.setattr(serial, "held_by_driver", lambda fd: 2000)

    async def session():
        async with plugged(tmp_path) as (_, link, _):
            link.send([line("never")])
            await asyncio.wait_for(link.close(drain=0.05), 5)
            assert link.counters.dropped == 1

    asyncio.run(session())


@pytest.mark.parametrize("moment", range(3))
def test_closing_while_it_opens_leaks_nothing(tmp_path, moment):
    async def session():
        adapter = Adapter(tmp_path / "usb-adapter")
        warm = SerialLink(str(adapter.path))
        await warm.open(lambda data: None, lambda connected, reason: None)
        await warm.close()
        before = descriptors()
        link = SerialLink(str(adapter.path))
        opening = asyncio.ensure_future(link.open(lambda data: None, lambda connected, reason: None))
        await asyncio.sleep(0.004 * moment)
        opening.cancel()
        await asyncio.wait({opening})
        await link.close()
        await until(lambda: descriptors() == before)

    asyncio.run(session())
