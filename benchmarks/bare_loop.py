"""The least that a program of this language must do: wake up, read a frame, look its sentence up, write it to all.

It decodes nothing, decides nothing and notices nothing: what it costs is the system calls, the loop and the readers
that they wake. What the gateway costs beyond it is the gateway's own.
"""

import asyncio
import os
import socket
import tty
from multiprocessing.connection import Connection

from benchmarks.live_gateway import HERE, Setup
from benchmarks.processes import resident_mib
from benchmarks.traffic import places, raw_cycle
from timonel.links.tcp import prepare


def run_bare_loop(pipe: Connection, bus: int, directory: str, setup: Setup) -> None:
    """As `run_gateway`."""
    asyncio.run(_run(pipe, bus, directory, setup))


async def _run(pipe: Connection, bus: int, directory: str, setup: Setup) -> None:
    loop = asyncio.get_running_loop()
    can = socket.socket(fileno=bus)
    can.setblocking(False)
    cycle = raw_cycle()
    lines = {cycle[place]: line for line, place in places().items()}
    outputs = [_terminal(f"{directory}/{number}") for number in range(1, 1 + setup.terminals)]
    server = socket.create_server((HERE, 0))
    loop.add_reader(can.fileno(), _pass_on, can, lines, outputs)
    loop.add_reader(server.fileno(), _welcome, server, outputs)
    loop.add_reader(pipe.fileno(), _answer, pipe)
    pipe.send((server.getsockname(), None))
    await asyncio.Event().wait()


def _terminal(path: str) -> int:
    fd, program_end = os.openpty()
    tty.setraw(program_end)
    os.symlink(os.ttyname(program_end), path)
    os.set_blocking(fd, False)
    return fd


def _welcome(server: socket.socket, outputs: list[int]) -> None:
    stream, _ = server.accept()
    prepare(stream)
    stream.setblocking(False)
    outputs.append(stream.detach())


def _pass_on(can: socket.socket, lines: dict[bytes, bytes], outputs: list[int]) -> None:
    line = lines.get(can.recv(16), b"")
    for fd in outputs:
        os.write(fd, line)


def _answer(pipe: Connection) -> None:
    pipe.recv()
    pipe.send({"frames": 0, "lost": 0, "mib": resident_mib()})
