"""The driver of pilots that obey 127237: what it fills in is what the declaration of the message encodes."""

from math import nan, nextafter, radians

import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.errors import EncodeError
from timonel.nmea2000.lookups import HeadingReference, SteeringMode, YesNo
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.nmea2000.sender import Outgoing
from timonel.vehicles.boat.pilot import TURN, Manner
from timonel.vehicles.boat.pilots.driver import Compass
from timonel.vehicles.boat.pilots.standard import StandardPilot

REFERENCES = (HeadingReference.TRUE, HeadingReference.MAGNETIC)


def unturned(course, reference, now):
    return course


def steered(reference, setpoint, heading):
    driver = StandardPilot(Compass(reference, unturned, unturned))
    return driver.steer(setpoint, heading, 0.0, Manner.COURSE)


def declared(reference, setpoint, heading):
    message = HeadingTrackControl(
        override=YesNo.NO,
        steering_mode=SteeringMode.MAIN_STEERING if setpoint is None else SteeringMode.HEADING_CONTROL,
        heading_reference=reference,
        heading_to_steer_course=None if setpoint is None else radians(setpoint / 10),
        vessel_heading=None if heading is None else radians(heading),
    )
    return [Outgoing(127237, message.encode())]


@pytest.mark.parametrize("reference", REFERENCES)
def test_every_course_is_told_as_the_message_is_declared(reference):
    for setpoint in range(TURN):
        heading = (setpoint * 7 % TURN) / 10
        assert steered(reference, setpoint, heading) == declared(reference, setpoint, heading)


@given(st.sampled_from(REFERENCES), st.none() | st.integers(0, TURN - 1), st.none() | st.floats(0.0, 360.0))
def test_any_heading_is_told_as_the_message_is_declared(reference, setpoint, heading):
    assert steered(reference, setpoint, heading) == declared(reference, setpoint, heading)


@pytest.mark.parametrize("heading", [0.0, 360.0, nextafter(360.0, 0.0), None])
@pytest.mark.parametrize("setpoint", [0, TURN - 1, None])
def test_the_ends_of_the_circle_and_what_is_not_known_are_told_as_declared(setpoint, heading):
    assert steered(HeadingReference.TRUE, setpoint, heading) == declared(HeadingReference.TRUE, setpoint, heading)


@pytest.mark.parametrize(("setpoint", "heading"), [(0, nan), (0, -0.1), (0, 361.0), (TURN + 10, 5.0), (-1, 5.0)])
def test_an_angle_that_is_none_is_refused_by_the_declaration(setpoint, heading):
    with pytest.raises(EncodeError):
        steered(HeadingReference.TRUE, setpoint, heading)
