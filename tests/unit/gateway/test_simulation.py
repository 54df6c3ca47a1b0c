import asyncio

from timonel.core.frame import Frame
from timonel.gateway.simulation import Simulation
from timonel.links.urls import bus_link
from timonel.nmea2000.lookups import HeadingReference
from timonel.nmea2000.sender import Sender
from timonel.vehicles.boat.drivers import StandardPilot
from timonel.vehicles.boat.simulator import SimulatedBoat


def test_the_simulated_boat_sails_in_the_loops_time_and_obeys_what_the_bus_tells_it() -> None:
    async def scene() -> None:
        heard: list[Frame] = []
        ours = bus_link("loop://simulation")
        await ours.open(heard.extend, lambda connected, reason: None)
        boat = SimulatedBoat(seed=1)
        began = boat.time
        async with Simulation(boat, bus_link("loop://simulation"), speed=10.0):
            course = StandardPilot(HeadingReference.TRUE).steer(900, 45.0)
            ours.send([frame for message in course for frame in Sender(0x23).frames(message)])
            await asyncio.sleep(0.3)
        assert 1.0 < boat.time - began < 30.0
        assert boat.pilot.engaged
        assert len(heard) > 50
        silent = len(heard)
        await asyncio.sleep(0.1)
        assert len(heard) == silent
        await ours.close()

    asyncio.run(scene())
