import asyncio
import os
import stat
import termios
from contextlib import asynccontextmanager

from tests.unit.links.far_side import Ear, descriptors, line, until
from timonel.links.pty import PtyLink


class Program:
    """A program that has the terminal open."""

    def __init__(self, path) -> None:
        self.fd = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def read(self) -> bytes:
        try:
            return os.read(self.fd, 65536)
        except BlockingIOError:
            return b""

    def say(self, data: bytes) -> None:
        os.write(self.fd, data)

    def leave(self) -> None:
        os.close(self.fd)


async def reads(program: Program, expected: bytes) -> None:
    got = b""
    async with asyncio.timeout(10):
        while len(got) < len(expected):
            got += program.read()
            await asyncio.sleep(0.002)
    assert got == expected


@asynccontextmanager
async def terminal(tmp_path, **settings):
    ear = Ear()
    link = PtyLink(str(tmp_path / "bridge"), **settings)
    await link.open(ear.receive, ear.changed)
    yield tmp_path / "bridge", link, ear
    await link.close()


def test_bytes_go_both_ways_unchanged(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, link, ear):
            program = Program(path)
            await until(lambda: ear.connected)
            every = bytes(range(256))
            program.say(every)
            await until(lambda: ear.data == every)
            link.send([line("$IIHDT,1.0,T"), line("$IIDPT,5.0")])
            await reads(program, b"$IIHDT,1.0,T\r\n$IIDPT,5.0\r\n")
            program.leave()

    asyncio.run(session())


def test_a_program_may_come_and_go_and_always_starts_with_news(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, link, ear):
            before = descriptors()
            for visit in range(20):
                link.send([line("dropped: nobody there")])
                program = Program(path)
                await until(lambda: ear.connected)
                link.send([line(f"for visit {visit}")])
                await reads(program, f"for visit {visit}\r\n".encode())
                link.send([line("never read")])
                program.leave()
                await until(lambda: not ear.connected)
            assert ear.changes[:2] == [(False, "no program has it open"), (True, "")]
            assert ear.changes[2] == (False, "Input/output error")
            assert (link.counters.dropped, link.counters.reopened) == (20, 19)
            assert descriptors() == before

    asyncio.run(session())


def test_a_program_that_writes_and_leaves_at_once_is_heard(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, _, ear):
            program = Program(path)
            program.say(b"$PARP,TAKECMD,01*XX\r\n")
            program.leave()
            await until(lambda: ear.data == b"$PARP,TAKECMD,01*XX\r\n")

    asyncio.run(session())


def test_the_next_program_finds_the_terminal_raw_whatever_the_last_one_made_of_it(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, _, ear):
            first = Program(path)
            await until(lambda: ear.connected)
            settings = termios.tcgetattr(first.fd)
            settings[3] |= termios.ICANON | termios.ECHO
            termios.tcsetattr(first.fd, termios.TCSANOW, settings)
            first.leave()
            await until(lambda: not ear.connected)
            second = Program(path)
            assert not termios.tcgetattr(second.fd)[3] & (termios.ICANON | termios.ECHO)
            second.leave()

    asyncio.run(session())


def test_nothing_spins_while_no_program_is_there(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, _, ear):
            program = Program(path)
            await until(lambda: ear.connected)
            program.leave()
            await until(lambda: not ear.connected)
            used = sum(os.times()[:2])
            await asyncio.sleep(0.5)
            assert sum(os.times()[:2]) - used < 0.2

    asyncio.run(session())


def test_a_program_that_stops_reading_gets_whole_lines_and_then_the_newest(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, link, ear):
            program = Program(path)
            await until(lambda: ear.connected)
            number = 0
            while not link.counters.replaced:
                number += 1
                link.send([line(f"$IIHDT,{number:06},T", "HDT")])
            link.send([line("$IIHDT,newest,T", "HDT")])
            got = b""
            async with asyncio.timeout(10):
                while not got.endswith(b"newest,T\r\n"):
                    got += program.read()
                    await asyncio.sleep(0)
            assert set(map(len, got.split(b"\r\n"))) == {len("$IIHDT,000000,T"), 0}
            program.leave()

    asyncio.run(session())


def test_the_link_at_its_path_goes_when_it_is_closed(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, _, _):
            assert path.is_symlink()
        assert not os.path.lexists(path)

    asyncio.run(session())


def test_a_link_left_behind_is_replaced(tmp_path):
    async def session():
        (tmp_path / "bridge").symlink_to("/dev/pts/gone")
        async with terminal(tmp_path) as (path, _, ear):
            program = Program(path)
            await until(lambda: ear.connected)
            program.leave()

    asyncio.run(session())


def test_a_file_in_the_way_is_left_alone_and_told(tmp_path):
    async def session():
        (tmp_path / "bridge").write_text("precious")
        before = descriptors()
        async with terminal(tmp_path) as (path, _, ear):
            await asyncio.sleep(0.3)
            assert ear.changes == [(False, "in the way: something that is not a symbolic link")]
            assert descriptors() == before
        assert path.read_text() == "precious"

    asyncio.run(session())


def test_a_link_that_another_has_put_there_meanwhile_is_not_removed(tmp_path):
    async def session():
        async with terminal(tmp_path) as (path, _, _):
            path.unlink()
            path.symlink_to("/dev/null")
        assert os.readlink(path) == "/dev/null"

    asyncio.run(session())


def test_the_terminal_gets_the_mode_asked_for(tmp_path):
    async def session():
        async with terminal(tmp_path, mode=0o666) as (path, _, _):
            assert stat.S_IMODE(path.stat().st_mode) == 0o666

    asyncio.run(session())
