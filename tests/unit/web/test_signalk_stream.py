"""One client of the Signal K stream."""

import asyncio
import json
from typing import Any

import pytest

from tests.unit.web.scene import Scene, heading, scene
from tests.unit.web.test_socket import READER, FakeLine, FakeSocket
from timonel.interop.signalk.subscriptions import ROWS_MAX
from timonel.web import signalk_stream
from timonel.web.signalk import FOLLOWERS_MAX, SignalK
from timonel.web.signalk_stream import MESSAGES_PER_SECOND, Client
from timonel.web.socket import NOT_UNDERSTOOD, POLICY, STUCK, TRY_AGAIN

HEADING = "navigation.headingTrue"
STATE = "steering.autopilot.state"


def server(here: Scene) -> SignalK:
    assert here.console.signalk is not None
    return here.console.signalk


def told(line: FakeLine) -> list[dict[str, Any]]:
    """The deltas, each as its values by path."""
    return [
        {each["path"]: each["value"] for update in message["updates"] for each in update.get("values", ())}
        for message in line.messages()
        if "updates" in message
    ]


class Talk:
    """A client, without a socket, and what it hears."""

    def __init__(self, here: Scene, **query: str) -> None:
        self.line = FakeLine()
        server(here).refresh(here.gateway.now)
        self.client = Client(server(here), self.line, query)
        self._here = here
        server(here).followers.add(self.client)

    def look(self, later: float = 0.0) -> None:
        server(self._here).look(self._here.gateway.now + later)

    def say(self, **message: Any) -> None:
        self.client._obey(signalk_stream._decoder.decode(json.dumps(message)))
        self.look()


async def talk(here: Scene, *says: str | bytes, **query: str) -> tuple[FakeLine, FakeSocket]:
    """Everything that a client is told that says this and leaves."""
    line = FakeLine()
    end = FakeSocket(line, READER, list(says))
    await signalk_stream.serve(here.console, server(here), end, query)  # type: ignore[arg-type]
    return line, end


def test_first_comes_who_we_are_then_all_that_is_known_then_what_changes() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            client = Talk(here)
            client.look()
            hello = client.line.messages()[0]
            assert hello["self"] == server(here).vessel.context
            (everything,) = told(client.line)
            assert everything[HEADING] == pytest.approx(1.5708, abs=1e-4)
            assert everything[STATE] == "standby"
            await here.hear(heading(91.0))
            client.look()
            assert told(client.line)[1].keys() == {HEADING}
            client.look()
            assert len(told(client.line)) == 2

    asyncio.run(play())


def test_two_that_have_seen_as_much_get_the_same_bytes() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            one, other = Talk(here), Talk(here)
            one.look()
            assert one.line.frames[1] is other.line.frames[1]

    asyncio.run(play())


def test_who_wants_no_past_is_told_from_now_on() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            client = Talk(here, sendCachedValues="false")
            client.look()
            assert told(client.line) == []
            await here.hear(heading(91.0))
            client.look()
            assert [delta.keys() for delta in told(client.line)] == [{HEADING}]

    asyncio.run(play())


def test_who_wants_nothing_subscribes() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            client = Talk(here, subscribe="none")
            client.look()
            assert told(client.line) == []
            client.say(context="vessels.self", subscribe=[{"path": "navigation.heading*", "period": 1000}])
            assert [delta.keys() for delta in told(client.line)] == [{HEADING}]
            await here.hear(heading(91.0))
            client.look()
            assert len(told(client.line)) == 1
            client.look(1.0)
            assert len(told(client.line)) == 2
            client.say(context="*", unsubscribe=[{"path": "*"}])
            client.look(10.0)
            assert len(told(client.line)) == 2

    asyncio.run(play())


def test_another_vessel_is_not_known_here() -> None:
    async def play() -> None:
        async with scene() as here:
            client = Talk(here, subscribe="none")
            client.say(context="vessels.urn:mrn:imo:mmsi:230029970", subscribe=[{"path": "*"}])
            assert told(client.line) == []
            client.say(context=server(here).vessel.context, subscribe=[{"path": "*"}])
            assert told(client.line) != []

    asyncio.run(play())


def test_who_wants_it_is_told_what_the_paths_mean() -> None:
    async def play() -> None:
        async with scene() as here:
            client = Talk(here, sendMeta="all")
            client.look()
            meta = client.line.messages()[1]["updates"][0]["meta"]
            assert {"path": HEADING, "value": {"units": "rad", "description": "Where the bow points, true"}} in meta

    asyncio.run(play())


def test_a_client_that_does_not_listen_gets_the_newest_when_it_does() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            everything, some = Talk(here), Talk(here, subscribe="none")
            everything.look()
            some.say(subscribe=[{"path": HEADING}])
            for client in (everything, some):
                client.line.room = False
            for course in (91.0, 92.0, 93.0):
                await here.hear(heading(course))
                everything.look()
            for client in (everything, some):
                client.line.room = True
            everything.look()
            for client in (everything, some):
                courses = [delta[HEADING] for delta in told(client.line)]
                assert courses == pytest.approx([1.5708, 1.6232], abs=1e-4)

    asyncio.run(play())


def test_a_client_that_takes_nothing_is_cut_off() -> None:
    async def play() -> None:
        async with scene() as here:
            client = Talk(here)
            client.line.room = False
            client.look()
            client.look(STUCK - 1.0)
            assert not client.line.aborted
            client.look(STUCK + 1.0)
            assert client.line.aborted

    asyncio.run(play())


def test_nothing_is_put_here() -> None:
    async def play() -> None:
        async with scene() as here:
            put = json.dumps({"requestId": "r1", "put": {"path": "steering.rudderAngle", "value": 1}})
            line, _ = await talk(here, put, json.dumps({"updates": [{"values": [{"path": "x", "value": 1}]}]}))
            (answer,) = [message for message in line.messages() if "requestId" in message]
            assert (answer["requestId"], answer["state"], answer["statusCode"]) == ("r1", "COMPLETED", 405)
            assert "x" not in server(here).model.entries

    asyncio.run(play())


@pytest.mark.parametrize(
    "said", [b"{}", "", "{", "[]", '{"subscribe": [{"path": "*", "policy": "often"}]}', "[" * 9999]
)
def test_what_is_not_understood_ends_the_socket(said: str | bytes) -> None:
    async def play() -> None:
        async with scene() as here:
            _, end = await talk(here, said)
            assert end.closed is not None
            assert end.closed[0] == NOT_UNDERSTOOD
            assert not server(here).followers

    asyncio.run(play())


def test_who_says_more_than_anybody_could_mean_is_sent_away() -> None:
    async def play() -> None:
        async with scene() as here:
            _, end = await talk(here, *["{}"] * (MESSAGES_PER_SECOND + 1))
            assert end.closed == (POLICY, "too many messages")
            rows = [{"path": "navigation.*"}] * (ROWS_MAX + 1)
            _, end = await talk(here, json.dumps({"subscribe": rows}))
            assert end.closed == (POLICY, "too many messages")

    asyncio.run(play())


def test_there_is_room_for_so_many() -> None:
    async def play() -> None:
        async with scene() as here:
            for _ in range(FOLLOWERS_MAX):
                Talk(here)
            _, end = await talk(here)
            assert (end.accepted, end.closed) == (False, (TRY_AGAIN, ""))

    asyncio.run(play())


def test_nothing_is_looked_at_while_nobody_follows() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            here.console._tick(here.gateway.now, [])
            assert server(here).model.sequence == 0

    asyncio.run(play())
