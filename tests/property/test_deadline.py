"""The boat works its deadline out only when something happened; it must all the same never come too late."""

from math import radians

from hypothesis import given
from hypothesis import strategies as st

from timonel.core.frame import Frame
from timonel.nmea0183 import parp
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, VesselHeading
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

PORTS = [Port("Bridge", 1), Port("Cockpit", 2)]
SETTINGS = BoatSettings(request_seconds=0.2, variation_model=False)


def heading(degrees: int | None) -> list[Frame]:
    angle = None if degrees is None else radians(degrees)
    message = VesselHeading(sid=None, heading=angle, deviation=None, variation=None, reference=HeadingReference.TRUE)
    return [Frame(join(2, 127250, 10), message.encode())]


def pilot(mode: SteeringMode, course: int) -> list[Frame]:
    message = HeadingTrackControl(
        steering_mode=mode, heading_reference=HeadingReference.TRUE, heading_to_steer_course=radians(course)
    )
    return [Frame(join(2, 127237, 11), data) for data in fragment(message.encode(), 0)]


frames = st.one_of(
    st.builds(heading, st.none() | st.integers(0, 359)),
    st.builds(
        pilot, st.sampled_from([SteeringMode.MAIN_STEERING, SteeringMode.HEADING_CONTROL]), st.sampled_from([10, 200])
    ),
)
commands = st.tuples(st.sampled_from(PORTS), st.sampled_from(list(parp.Verb)), st.sampled_from([0.0, 200.0]))
plugs = st.tuples(st.sampled_from(PORTS), st.booleans())
pauses = st.sampled_from([0.0, 0.01, 0.15, 0.4, 0.9, 2.1, 3.5])


@given(st.lists(st.tuples(pauses, frames | commands | plugs), max_size=40))
def test_the_deadline_is_never_later_than_what_is_due(steps):
    boat, now = Boat(SETTINGS, PORTS, 0.0), 0.0
    for pause, step in steps:
        now += pause
        match step:
            case list():
                boat.receive_frames(step, now)
            case Port(name=name), bool() as connected:
                boat.port_changed(name, connected, now)
            case Port(name=name, station=int() as station), parp.Verb() as verb, float() as parameter:
                boat.receive_bytes(name, parp.command(verb, station, parameter), now)
        assert boat.deadline <= boat.helm.deadline
        assert boat.deadline <= now + 0.5  # the next STATUS
