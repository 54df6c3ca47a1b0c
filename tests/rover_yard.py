"""The rover's controller as a program, with a simulated rover on its bus and a UART that can be cut, in real time.

```
program ──serial── wire, which loses bytes ──serial── timonel run ──slcan── simulated rover
```
"""

import asyncio
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from random import Random
from types import TracebackType
from typing import Self

from tests.program import Program, until
from tests.unit.links.far_side import Adapter
from timonel.core.frame import Frame
from timonel.vehicles.rover.simulator import SimulatedRover

TICK = 0.02  # s
SINGLE = 8  # bytes of a CAN frame


class Relay:
    """Two adapters back to back; each byte is lost with the probability `loss`."""

    def __init__(self, near: Path, far: Path, loss: float) -> None:
        self.near, self.far = Adapter(near), Adapter(far)
        self.cut = False
        self._loss = loss
        self._random = Random(1)

    def open(self) -> None:
        loop = asyncio.get_running_loop()
        loop.add_reader(self.near.fd, self._pass, self.near, self.far)
        loop.add_reader(self.far.fd, self._pass, self.far, self.near)

    def close(self) -> None:
        for adapter in (self.near, self.far):
            asyncio.get_running_loop().remove_reader(adapter.fd)
            adapter.pull()

    def _pass(self, source: Adapter, sink: Adapter) -> None:
        data = source.hear()
        if self.cut or not data:
            return
        kept = bytes(byte for byte in data if self._random.random() >= self._loss)
        with suppress(BlockingIOError):  # nobody reads there
            os.write(sink.fd, kept)


class Bus:
    """A Lawicel adapter with the simulated rover behind it."""

    def __init__(self, path: Path, rover: SimulatedRover) -> None:
        self.adapter = Adapter(path)
        self.rover = rover
        self._rest = b""

    async def live(self) -> None:
        """For ever."""
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            *lines, self._rest = (self._rest + self.adapter.hear()).split(b"\r")
            for line in lines:
                if line[:1] == b"t":
                    self.rover.receive(Frame(int(line[1:4], 16), bytes.fromhex(line[5:].decode()), extended=False))
            if loop.time() >= due:
                due += TICK
                self._speak(self.rover.step(TICK))
            await asyncio.sleep(0.002)

    def _speak(self, frames: list[Frame]) -> None:
        short = [frame for frame in frames if len(frame.data) <= SINGLE]
        lines = (b"t%03X%d%b\r" % (frame.identifier, len(frame.data), frame.data.hex().encode()) for frame in short)
        with suppress(BlockingIOError):  # the program is gone
            os.write(self.adapter.fd, b"".join(lines))


class Yard:
    """Entered, the controller runs. `station` is who drives; `client` is where its program finds the UART."""

    def __init__(
        self,
        directory: Path,
        *,
        station: int = 1,
        dialect: str = "strzyga",
        loss: float = 0.0,
        module_timeout: float | None = None,
    ) -> None:
        self.rover = SimulatedRover(module_timeout=module_timeout)
        self.client = directory / "client"
        self.relay = Relay(directory / "controller", self.client, loss)
        self.bus = Bus(directory / "can", self.rover)
        configuration = directory / "rover.toml"
        configuration.write_text(
            f'[vehicle]\nkind = "rover"\ndialect = "{dialect}"\n[bus]\nurl = "slcan://{directory}/can"\n'
            f'[[station]]\nid = {station}\nurl = "serial://{directory}/controller"\n'
        )
        self.program = Program(directory, "run", str(configuration))

    async def __aenter__(self) -> Self:
        self._living = asyncio.get_running_loop().create_task(self.bus.live())
        self.relay.open()
        self.program.start()
        await self.program.running()
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.program.kill()
        self._living.cancel()
        await asyncio.gather(self._living, return_exceptions=True)
        self.relay.close()
        self.bus.adapter.pull()

    @property
    def moving(self) -> bool:
        """Whether a wheel is told to turn."""
        return self.rover.setpoints != ((0, 0, 0), (0, 0, 0))

    async def stops_after(self, happens: Callable[[], object]) -> float:
        """How long the wheels are still told to turn after it, s."""
        assert self.moving
        happens()
        return await until(lambda: not self.moving, "the wheels are told to stand")
