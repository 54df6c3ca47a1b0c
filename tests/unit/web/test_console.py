"""All who look at one vehicle, in their time."""

import asyncio

import pytest

from tests.unit.web.scene import Scene, heading, scene
from timonel.core.effects import Effect
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.web.access import Least, Rights
from timonel.web.console import Console
from timonel.web.messages import FromServer

READER = Rights(Least.READER)


class Onlooker:
    """A client that counts."""

    def __init__(self) -> None:
        self.rights = READER
        self.station: int | None = None
        self.told: list[FromServer] = []
        self.times: list[float] = []
        self.looked = 0

    def tell(self, message: FromServer) -> None:
        self.told.append(message)

    def news(self) -> None:
        self.times.append(asyncio.get_running_loop().time())

    def look(self, now: float) -> None:
        self.looked += 1


async def running(here: Scene, seconds: float) -> None:
    looking = asyncio.get_running_loop().create_task(here.console.run())
    await asyncio.sleep(seconds)
    looking.cancel()


def test_nobody_is_told_more_often_than_something_changes() -> None:
    async def play() -> None:
        async with scene() as here:
            client = Onlooker()
            here.console.enter(client)
            await running(here, 0.5)
            assert len(client.times) <= 1
            assert client.looked >= 3

    asyncio.run(play())


def test_what_presses_is_told_before_it_is_time() -> None:
    async def play() -> None:
        async with scene() as here:
            here.console._period = 5.0
            client = Onlooker()
            here.console.enter(client)
            looking = asyncio.get_running_loop().create_task(here.console.run())
            await asyncio.sleep(0.1)
            here.gateway.channels[0].receive.say(parp.command(Verb.TAKECMD, 1))  # type: ignore[union-attr]
            await asyncio.sleep(0.1)
            looking.cancel()
            assert len(client.times) == 1

    asyncio.run(play())


def test_the_history_is_kept_also_while_nobody_looks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("timonel.web.console.PERIOD", 0.05)

    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            await running(here, 0.4)
            kept = here.console.history.last("heading", 100)
            assert kept[-1] == pytest.approx(1.5708, abs=1e-4)
            assert here.console.feed.sequence == 0, "nothing is put together for nobody"

    asyncio.run(play())


def test_a_fault_in_what_is_shown_is_logged_and_the_next_look_is_taken(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def play() -> None:
        async with scene() as here:
            client = Onlooker()
            here.console.enter(client)
            whole = here.console.state.topics
            broken = [True]

            def topics(now: float) -> dict[str, object]:
                if broken:
                    broken.pop()
                    raise ZeroDivisionError
                return whole(now)

            monkeypatch.setattr(here.console.state, "topics", topics)
            await here.hear(heading(90.0))
            await running(here, 0.4)
            assert here.gateway.health.counts["fault"] == 1
            assert client.times

    asyncio.run(play())
    assert "console: fault in the gateway itself" in caplog.text


def test_a_fault_in_observing_takes_nothing_from_the_vehicle() -> None:
    async def play() -> None:
        async with scene() as here:

            def effect(effect: Effect, now: float) -> None:
                raise ZeroDivisionError

            here.console.state.effect = effect  # type: ignore[method-assign]
            here.gateway.channels[0].receive.say(parp.command(Verb.TAKECMD, 1))  # type: ignore[union-attr]
            assert here.gateway.vehicle.helm.transfer.commander == 1  # type: ignore[attr-defined]

    asyncio.run(play())


def test_a_gateway_of_something_else_has_no_console() -> None:
    async def play() -> None:
        async with scene() as here:
            here.gateway.vehicle = None  # type: ignore[assignment]
            with pytest.raises(AssertionError):
                Console(here.gateway, here.console.state._configuration, b"k")

    asyncio.run(play())
