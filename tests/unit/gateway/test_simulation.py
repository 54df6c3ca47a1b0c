import asyncio

from timonel.core.frame import Frame
from timonel.gateway.simulation import Simulation
from timonel.links.urls import bus_link
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.sender import Sender, outgoing
from timonel.vehicles.boat.simulator import SimulatedBoat


def test_the_simulated_boat_sails_in_the_loops_time_and_obeys_what_the_bus_tells_it() -> None:
    async def scene() -> None:
        heard: list[Frame] = []
        ours = bus_link("loop://simulation")
        await ours.open(heard.extend, lambda connected, reason: None)
        boat = SimulatedBoat(seed=1)
        began = boat.time
        async with Simulation(boat, bus_link("loop://simulation"), speed=10.0):
            course = HeadingTrackControl(
                steering_mode=SteeringMode.HEADING_CONTROL,
                heading_reference=HeadingReference.TRUE,
                heading_to_steer_course=1.57,
            )
            ours.send(Sender(0x23).frames(outgoing(course)))
            await asyncio.sleep(0.3)
        assert 1.0 < boat.time - began < 30.0
        assert boat.pilot.engaged
        assert len(heard) > 50
        silent = len(heard)
        await asyncio.sleep(0.1)
        assert len(heard) == silent
        await ours.close()

    asyncio.run(scene())
