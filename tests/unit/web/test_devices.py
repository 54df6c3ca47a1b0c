"""The devices of the bus as the console is told of them."""

import asyncio

from tests.unit.nmea2000.test_devices import claim
from tests.unit.web.scene import frame, scene
from timonel.web.messages import DeviceState


def test_who_introduces_itself_is_shown_and_nothing_is_made_anew_for_who_only_lives_on() -> None:
    async def play() -> None:
        async with scene() as here:
            before = here.console.state.topics(here.gateway.now)["devices"]
            assert before == []
            await here.hear(frame(claim(1, instance=9), 204))
            (told,) = shown = here.console.state.topics(here.gateway.now)["devices"]
            assert isinstance(told, DeviceState)
            assert (told.address, told.maker, told.function, told.instance) == (204, "Raymarine", "Autopilot", 9)
            assert (told.model, told.ours) == (None, False)
            assert -0.1 <= here.gateway.now - told.since < 60.0  # it is told to the tenth
            await here.hear(frame(claim(1, instance=9), 204))
            assert here.console.state.topics(here.gateway.now)["devices"] is shown

    asyncio.run(play())
