"""A port whose far end is in this program."""

import asyncio

from timonel.core.effects import Say
from timonel.links.inner import InnerLink


def test_what_is_said_comes_in_at_once_while_it_is_open() -> None:
    async def scene() -> None:
        link = InnerLink(name="Bridge web")
        heard: list[bytes] = []
        told: list[tuple[bool, str]] = []
        link.say(b"too early")
        link.plug(True)
        await link.open(heard.append, lambda connected, reason: told.append((connected, reason)))
        link.say(b"one")
        link.plug(False, "gone")
        link.send([Say(b"$x\r\n", "x")])
        await link.close()
        link.say(b"too late")
        assert heard == [b"one"]
        assert told == [(False, "gone")]
        assert (link.counters.bytes_in, link.connected) == (3, False)

    asyncio.run(scene())
