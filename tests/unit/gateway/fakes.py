"""A vehicle that does what a test tells it to, and links whose far side is the test."""

import asyncio
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from timonel.core.effects import Effect, Say
from timonel.core.frame import Frame
from timonel.links.link import Changed, Counters

Incoming = TypeVar("Incoming")


class FakeVehicle:
    """Writes down what it is told, and answers what `answers` has for it."""

    def __init__(self) -> None:
        self.told: list[tuple[object, ...]] = []
        self.answers: dict[str, list[Effect]] = {}
        self.fault: Exception | None = None
        self.deadline = float("inf")
        self.expired: list[float] = []

    def receive_frames(self, frames: Sequence[Frame], now: float) -> list[Effect]:
        return self._hear("frames", *frames)

    def receive_message(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        return self._hear("message", identifier, payload)

    def receive_bytes(self, port: str, data: bytes, now: float) -> list[Effect]:
        return self._hear("bytes", port, data)

    def port_changed(self, port: str, connected: bool, now: float) -> list[Effect]:
        return self._hear("port", port, connected)

    def expire(self, now: float) -> list[Effect]:
        self.expired.append(now)
        if self.fault is None:
            self.deadline = float("inf")
        return self._hear("expire")

    def _hear(self, *what: object) -> list[Effect]:
        self.told.append(what)
        if self.fault is not None:
            raise self.fault
        return self.answers.get(str(what[0]), [])


class FakeLink(Generic[Incoming]):
    """`receive` and `changed` are the gateway's ends; what it sends is in `batches`."""

    def __init__(self, name: str) -> None:
        self.url = f"fake://{name}"
        self.name = name
        self.counters = Counters()
        self.opened = 0
        self.closed = 0
        self.receive: Callable[[Incoming], None]
        self.changed: Changed

    async def open(self, receive: Callable[[Incoming], None], changed: Changed) -> None:
        self.opened += 1
        self.receive, self.changed = receive, changed

    async def close(self, drain: float = 0.5) -> None:
        await asyncio.sleep(0)
        self.closed += 1


class FakeBus(FakeLink[list[Frame]]):
    def __init__(self) -> None:
        super().__init__("bus")
        self.batches: list[list[Frame]] = []

    def send(self, frames: Sequence[Frame]) -> None:
        self.batches.append(list(frames))


class FakePort(FakeLink[bytes]):
    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.batches: list[list[Say]] = []

    def send(self, lines: Sequence[Say]) -> None:
        self.batches.append(list(lines))

    @property
    def lines(self) -> list[bytes]:
        return [say.line for batch in self.batches for say in batch]
