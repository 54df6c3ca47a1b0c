"""One browser on the socket."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import pytest

from tests.unit.web.scene import Scene, heading, scene
from timonel.web import socket
from timonel.web.access import Least, Rights
from timonel.web.console import CLIENTS_MAX
from timonel.web.messages import Pong
from timonel.web.socket import LINE, MESSAGES_PER_SECOND, RIGHTS, STUCK, WAITING_MAX, Browser

ADMIN = Rights(Least.ADMIN, (1, 2, 3, 4))
READER = Rights(Least.READER)


class FakeLine:
    """Takes frames while `room` is true."""

    def __init__(self) -> None:
        self.frames: list[bytes] = []
        self.room = True
        self.aborted = False

    def write(self, frame: bytes) -> bool:
        if self.room:
            self.frames.append(frame)
        return self.room

    def abort(self) -> None:
        self.aborted = True

    def messages(self, type: str = "") -> list[Any]:
        told = [json.loads(frame[{126: 4, 127: 10}.get(frame[1], 2) :]) for frame in self.frames]
        return [message for message in told if not type or message["type"] == type]


class FakeSocket:
    """Starlette's end: what the browser says stands in `says`; then it leaves, or stays."""

    def __init__(self, line: FakeLine, rights: Rights, says: list[str | bytes], stays: bool = False) -> None:
        self.scope = {"extensions": {LINE: line}, RIGHTS: rights}
        self.client_state = socket.WebSocketState.CONNECTED
        self.accepted = False
        self.closed: tuple[int, str] | None = None
        self._says = says
        self._stays = stays

    async def accept(self) -> None:
        self.accepted = True

    async def close(self, code: int, reason: str = "") -> None:
        self.closed = code, reason

    async def receive(self) -> dict[str, Any]:
        await asyncio.sleep(0)
        if self._says:
            said = self._says.pop(0)
            return {"type": "websocket.receive", "text" if isinstance(said, str) else "bytes": said}
        if self._stays:
            await asyncio.Event().wait()
        return {"type": "websocket.disconnect", "code": 1001}


async def talk(here: Scene, *says: str | bytes, rights: Rights = ADMIN) -> tuple[FakeLine, FakeSocket]:
    """Everything that a browser is told that says this and leaves."""
    line = FakeLine()
    end = FakeSocket(line, rights, list(says))
    await socket.serve(here.console, end)  # type: ignore[arg-type]
    return line, end


@asynccontextmanager
async def browser(vehicle: str = "boat", rights: Rights = ADMIN) -> AsyncIterator[tuple[Scene, Browser, FakeLine]]:
    async with scene(vehicle) as here:
        line = FakeLine()
        yield here, Browser(here.console, line, rights), line


def say(client: Browser, type: str, **fields: Any) -> None:
    client._obey(socket._decoder.decode(json.dumps({"type": type, **fields})))


def answers(line: FakeLine) -> list[tuple[int, str, str]]:
    return [(each["id"], each["outcome"], each["reason"]) for each in line.messages("answer")]


def tick(here: Scene) -> None:
    news: list[Any] = []
    here.console._tick(here.gateway.now, news)
    for client in news:
        client.news()


def test_first_comes_everything_then_what_changed() -> None:
    async def play() -> None:
        async with browser() as (here, _, line):
            snapshot = line.messages()[0]
            assert (snapshot["type"], snapshot["vehicle"], snapshot["name"]) == ("snapshot", "boat", "Alba")
            assert snapshot["you"] == {"role": "admin", "station": None, "may_choose": [1, 2, 3, 4]}
            await here.hear(heading(90.0))
            tick(here)
            changes = line.messages()[1]
            assert (changes["type"], changes["since"]) == ("changes", snapshot["sequence"])
            assert "heading" in changes["topics"]
            assert "depth" not in changes["topics"]

    asyncio.run(play())


def test_who_takes_nothing_is_told_the_newest_when_he_goes_on() -> None:
    async def play() -> None:
        async with browser() as (here, client, line):
            line.room = False
            for degrees in range(50):
                await here.hear(heading(float(degrees)))
                tick(here)
            assert len(line.frames) == 1
            line.room = True
            client.news()
            _, changes = line.messages()
            assert changes["since"] == 1
            assert changes["topics"]["heading"]["value"] == pytest.approx(0.8552, abs=1e-3)

    asyncio.run(play())


def test_who_takes_nothing_for_half_a_minute_is_cut_off() -> None:
    async def play() -> None:
        async with browser() as (here, client, line):
            line.room = False
            client.tell(Pong(1, 0.0))
            client.look(here.gateway.now + STUCK - 1)
            assert not line.aborted
            client.look(here.gateway.now + STUCK + 1)
            assert line.aborted

    asyncio.run(play())


def test_who_goes_on_in_time_is_not_cut_off() -> None:
    async def play() -> None:
        async with browser() as (here, client, line):
            line.room = False
            client.tell(Pong(1, 0.0))
            line.room = True
            client.news()
            client.look(here.gateway.now + STUCK + 1)
            assert not line.aborted
            assert line.messages("pong")

    asyncio.run(play())


def test_who_leaves_his_answers_lying_is_cut_off() -> None:
    async def play() -> None:
        async with browser() as (_, client, line):
            line.room = False
            for _ in range(WAITING_MAX):
                client.tell(Pong(1, 0.0))
            assert not line.aborted
            client.tell(Pong(1, 0.0))
            assert line.aborted

    asyncio.run(play())


def test_a_refresh_is_everything_again_and_a_ping_a_pong() -> None:
    async def play() -> None:
        async with browser() as (_, client, line):
            say(client, "refresh")
            say(client, "ping", n=17)
            assert [message["type"] for message in line.messages()] == ["snapshot", "snapshot", "pong"]
            assert line.messages("pong")[0]["n"] == 17

    asyncio.run(play())


def test_a_browser_may_be_what_it_was_paired_with_and_nothing_else() -> None:
    async def play() -> None:
        paired = Rights(Least.STATION, (2, 3))
        async with browser(rights=paired) as (here, client, line):
            assert client.station is None, "it must say which"
            say(client, "choose", id=1, station=4)
            say(client, "choose", id=2, station=3)
            assert answers(line) == [(1, "refused", "not paired with this station"), (2, "confirmed", "")]
            assert line.messages("snapshot")[-1]["you"]["station"] == 3
            assert here.console.ports[3].consoles == {1}
            assert here.console.state.topics(0.0)["command"].stations[2].web == 1
            say(client, "choose", id=3, station=None)
            assert here.console.ports[3].consoles == set()

    asyncio.run(play())


def test_a_browser_with_one_station_is_that_one_at_once() -> None:
    async def play() -> None:
        async with browser(rights=Rights(Least.STATION, (2,))) as (_, client, line):
            assert client.station == 2
            assert line.messages("snapshot")[0]["you"]["station"] == 2

    asyncio.run(play())


def test_a_reader_commands_nothing() -> None:
    async def play() -> None:
        for vehicle, order in (
            ("boat", {"type": "command", "verb": "TAKECMD"}),
            ("boat", {"type": "acknowledge", "alert": 101}),
            ("rover", {"type": "enable"}),
            ("rover", {"type": "stop"}),
        ):
            async with browser(vehicle, READER) as (here, client, line):
                say(client, id=1, **order)
                assert answers(line) == [(1, "refused", "you are no station")]
                if vehicle == "rover":
                    say(client, "stick", n=1, x=0, y=1)
                assert here.gateway.vehicle.helm.transfer.commander == 0

    asyncio.run(play())


def test_an_order_is_sent_and_then_ends() -> None:
    async def play() -> None:
        async with browser(rights=Rights(Least.STATION, (1,))) as (here, client, line):
            await here.hear(heading(90.0))
            say(client, "command", id=1, verb="TAKECMD")
            say(client, "command", id=2, verb="ENGAGE")
            say(client, "command", id=3, verb="ACKCMD")
            assert answers(line) == [
                (1, "sent", ""), (1, "confirmed", ""), (2, "sent", ""), (3, "refused", "no request to answer"),
            ]  # fmt: skip
            client.look(here.gateway.now + 2.0)
            assert answers(line)[-1] == (2, "unconfirmed", "the pilot has not confirmed")
            client.look(here.gateway.now + 3.0)
            assert len(answers(line)) == 5, "it ends once"

    asyncio.run(play())


def test_more_orders_than_anybody_decides_are_refused() -> None:
    async def play() -> None:
        async with browser(rights=Rights(Least.STATION, (1,))) as (here, client, line):
            await here.hear(heading(90.0))
            client._undecided = [(0, lambda now: None)] * WAITING_MAX
            say(client, "command", id=9, verb="TAKECMD")
            assert answers(line) == [(9, "refused", "too many commands")]

    asyncio.run(play())


def test_a_driver_drives_and_is_gone() -> None:
    async def play() -> None:
        async with browser("rover", Rights(Least.STATION, (1,))) as (here, client, _):
            rover = here.gateway.vehicle
            say(client, "command", id=1, verb="TAKECMD")
            say(client, "enable", id=2)
            say(client, "stick", n=1, x=0.0, y=0.5)
            await asyncio.sleep(0.03)
            assert rover.drive.obeyed(here.gateway.now).x == -50
            say(client, "let_go")
            assert rover.drive.obeyed(here.gateway.now).x == 0
            say(client, "stick", n=2, x=0.0, y=0.5)
            client.leave()
            assert not rover.drive.permitted
            assert here.console.clients == {}

    asyncio.run(play())


# The way in -------------------------------------------------------------------------------------------------


def test_a_browser_that_leaves_is_forgotten() -> None:
    async def play() -> None:
        async with scene() as here:
            line, end = await talk(here, '{"type": "ping", "n": 1}')
            assert end.accepted
            assert end.closed is None
            assert [message["type"] for message in line.messages()] == ["snapshot", "pong"]
            assert here.console.clients == {}

    asyncio.run(play())


@pytest.mark.parametrize("said", ["", "hello", '{"type": "x"}', b"\x00", '{"n":' + "[" * 2000 + "]" * 2000 + "}"])
def test_what_is_not_understood_ends_it(said: str | bytes) -> None:
    async def play() -> None:
        async with scene() as here:
            _, end = await talk(here, said)
            assert end.closed is not None
            assert end.closed[0] == 1007
            assert len(end.closed[1].encode()) < 124, "RFC 6455, 5.5"
            assert here.console.clients == {}

    asyncio.run(play())


def test_more_than_anybody_means_ends_it() -> None:
    async def play() -> None:
        async with scene() as here:
            line, end = await talk(here, *['{"type": "ping", "n": 1}'] * (MESSAGES_PER_SECOND + 1))
            assert end.closed == (1008, "too many messages")
            assert len(line.messages("pong")) == MESSAGES_PER_SECOND

    asyncio.run(play())


def test_only_so_many_browsers_are_let_in() -> None:
    async def play() -> None:
        async with scene() as here:
            for _ in range(CLIENTS_MAX):
                Browser(here.console, FakeLine(), READER)
            _, end = await talk(here)
            assert not end.accepted
            assert end.closed == (1013, "")

    asyncio.run(play())


# Pairing ----------------------------------------------------------------------------------------------------


def test_the_digits_are_shown_to_the_station_in_command_and_to_nobody_else() -> None:
    async def play() -> None:
        async with scene() as here:
            lines = [FakeLine() for _ in range(3)]
            commander, other, _ = (
                Browser(here.console, line, rights)
                for line, rights in zip(
                    lines, (Rights(Least.STATION, (1,)), Rights(Least.STATION, (2,)), READER), strict=True
                )
            )
            say(commander, "command", id=1, verb="TAKECMD")
            asked = here.console.pairings.ask(3, "tablet", "192.168.1.7", here.gateway.now)
            assert asked is not None
            shown = [line.messages("pairing") for line in lines]
            assert [len(each) for each in shown] == [1, 0, 0]
            told = shown[0][0]
            assert (told["code"], told["station_name"], told["name"]) == (asked.code, "Station 3", "tablet")
            assert asked.code.encode() not in b"".join(lines[1].frames + lines[2].frames)
            say(other, "refuse_pairing", id=1, pairing=asked.number)
            assert answers(lines[1])[-1] == (1, "refused", "no such pairing")
            say(commander, "refuse_pairing", id=2, pairing=asked.number)
            assert answers(lines[0])[-1] == (2, "confirmed", "")
            assert lines[0].messages("pairing_over")[0]["pairing"] == asked.number

    asyncio.run(play())


def test_who_comes_later_is_shown_what_waits() -> None:
    async def play() -> None:
        async with scene() as here:
            here.gateway.vehicle.helm.transfer.commander = 1
            here.console.pairings.ask(3, "tablet", "192.168.1.7", here.gateway.now)
            line = FakeLine()
            Browser(here.console, line, Rights(Least.STATION, (1,)))
            assert len(line.messages("pairing")) == 1

    asyncio.run(play())


def test_who_comes_into_command_later_is_shown_what_waits() -> None:
    async def play() -> None:
        async with browser(rights=Rights(Least.STATION, (1,))) as (here, _, line):
            here.console.pairings.ask(3, "tablet", "192.168.1.7", here.gateway.now)
            tick(here)
            assert line.messages("pairing") == []
            here.gateway.vehicle.helm.transfer.commander = 1
            tick(here)
            tick(here)
            assert len(line.messages("pairing")) == 1

    asyncio.run(play())
