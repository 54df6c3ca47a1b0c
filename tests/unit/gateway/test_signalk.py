"""A gateway as a source for Signal K servers."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest
from msgspec.structs import replace
from websockets.asyncio.server import ServerConnection, serve

from tests.program import free_port, until
from tests.unit.web.scene import HERE, configuration, heading
from timonel.core.frame import Frame
from timonel.gateway import signalk as tested
from timonel.gateway.assemble import assemble
from timonel.gateway.gateway import Gateway
from timonel.gateway.signalk import signalk
from timonel.gateway.signalk_settings import SignalK
from timonel.links.link import BusLink
from timonel.links.urls import bus_link

HEADING = "navigation.headingTrue"


class Sea:
    """A gateway that tells Signal K, and the bus that it hears."""

    def __init__(self, gateway: Gateway, bus: BusLink) -> None:
        self.gateway = gateway
        self._bus = bus

    async def hear(self, *frames: Frame) -> None:
        self._bus.send(frames)
        await asyncio.sleep(0.01)


@asynccontextmanager
async def sea(settings: SignalK | None) -> AsyncIterator[Sea]:
    made_of = replace(configuration("boat", HERE), signalk=settings)
    gateway = assemble(made_of)
    bus = bus_link("loop://web", name="far end")
    await bus.open(lambda frames: None, lambda connected, reason: None)
    await gateway.open()
    async with signalk(gateway, made_of):
        yield Sea(gateway, bus)
    await gateway.close(0.0)
    await bus.close(0.0)


def courses(deltas: list[dict[str, Any]]) -> list[float | None]:
    return [
        each["value"]
        for delta in deltas
        for update in delta.get("updates", ())
        for each in update["values"]
        if each["path"] == HEADING
    ]


class Listener:
    """Who reads lines over TCP."""

    def __init__(self) -> None:
        self.lines: list[dict[str, Any]] = []

    async def read(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            while line := await reader.readline():
                assert line.endswith(b"\r\n")
                self.lines.append(json.loads(line))
        finally:
            writer.close()


def test_who_listens_is_told_who_we_are_then_what_is_known_then_what_is_new() -> None:
    async def play() -> None:
        port, listener = free_port(), Listener()
        async with sea(SignalK(tcp=f"tcp-listen://127.0.0.1:{port}")) as here:
            await here.hear(heading(90.0))
            await asyncio.sleep(0.15)
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            reading = asyncio.create_task(listener.read(reader, writer))
            await until(lambda: len(listener.lines) >= 2, "hello and all that is known")
            assert listener.lines[0]["self"] == listener.lines[1]["context"] == "vessels.self"
            assert courses(listener.lines[:2]) == pytest.approx([1.5708], abs=1e-4)
            await here.hear(heading(91.0))
            await until(lambda: len(courses(listener.lines)) >= 2, "a new heading")
            reading.cancel()
            await asyncio.sleep(0)

    asyncio.run(play())


def test_a_server_that_listens_is_told_the_same() -> None:
    async def play() -> None:
        listener = Listener()
        server = await asyncio.start_server(listener.read, "127.0.0.1", 0)
        port = server.sockets[0].getsockname()[1]
        async with sea(SignalK(tcp=f"tcp://127.0.0.1:{port}")) as here:
            await here.hear(heading(90.0))
            await until(lambda: courses(listener.lines), "the heading")
            assert listener.lines[0]["name"] == "timonel"
        server.close()
        await asyncio.sleep(0.05)

    asyncio.run(play())


def test_a_server_s_stream_is_told_with_a_token_and_again_when_it_is_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tested, "AGAIN", 0.01)
    heard: list[list[dict[str, Any]]] = []
    asked: list[tuple[str, str | None]] = []

    async def listen(stream: ServerConnection) -> None:
        assert stream.request is not None
        asked.append((stream.request.path, stream.request.headers.get("Authorization")))
        heard.append([])
        await stream.send('{"name":"server"}')
        async for message in stream:
            assert isinstance(message, str)
            heard[-1].append(json.loads(message))
            if courses(heard[-1]) and len(heard) == 1:
                return

    async def play() -> None:
        async with serve(listen, "127.0.0.1", 0) as server:
            port = next(iter(server.sockets)).getsockname()[1]
            stream = f"ws://127.0.0.1:{port}/signalk/v1/stream"
            async with sea(SignalK(push=stream, token="t0ken")) as here:
                await here.hear(heading(90.0))
                await until(lambda: len(heard) == 2 and courses(heard[1]), "the heading, twice")

    asyncio.run(play())
    assert asked == [("/signalk/v1/stream?subscribe=none", "Bearer t0ken")] * 2
    assert courses(heard[0]) == courses(heard[1]) == pytest.approx([1.5708], abs=1e-4)


def test_a_server_that_is_not_there_is_tried_ever_less_often(monkeypatch: pytest.MonkeyPatch) -> None:
    pauses: list[float] = []
    sleep = asyncio.sleep

    async def counted(seconds: float, result: object = None) -> None:
        if seconds >= 1.0:
            pauses.append(seconds)
        await sleep(0)

    async def play() -> None:
        async with sea(SignalK(push=f"ws://127.0.0.1:{free_port()}/signalk/v1/stream")):
            monkeypatch.setattr(asyncio, "sleep", counted)
            while len(pauses) < 7:
                await sleep(0.01)
            monkeypatch.undo()

    asyncio.run(play())
    assert pauses[:7] == [1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0]


@pytest.mark.parametrize("settings", [None, SignalK(station=2)])
def test_without_a_place_to_tell_nobody_is_told(settings: SignalK | None) -> None:
    async def play() -> None:
        async with sea(settings):
            assert not [task for task in asyncio.all_tasks() if task.get_name().startswith("Signal K")]

    asyncio.run(play())
