"""HTC and HTD of NMEA 0183 against 127237 of NMEA 2000, both ways, and HTC as a command."""

from math import degrees, radians, tau

import msgspec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.unit.boat.test_vehicle import Afloat, heading, sent
from timonel.core.effects import Refused, Rejected, Transmit
from timonel.nmea0183 import sentences as s
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.parp import Verb
from timonel.nmea0183.registry import parse
from timonel.nmea2000.lookups import DirectionRudder, HeadingReference, SteeringMode, TurnMode, YesNo
from timonel.nmea2000.messages.steering import HeadingTrackControl
from timonel.vehicles.boat.conversion import heading_track
from timonel.vehicles.boat.pilot import Mode
from timonel.vehicles.boat.pilots.htc import Hold, LetGo, from_htc, from_htd, order, to_htc
from timonel.vehicles.boat.settings import Port

TRUE, MAGNETIC = HeadingReference.TRUE, HeadingReference.MAGNETIC


def htc(text):
    """The sentence of some fields."""
    read = parse(seal(f"EIHTC,{text}").strip())
    assert isinstance(read, s.HTC)
    return read


def near(value, resolution):
    return pytest.approx(value, abs=resolution / 2 + 1e-9)


# From HTC -----------------------------------------------------------------------------------------------


def test_an_htc_of_a_manual_is_the_127237_of_the_worked_example():
    told = from_htc(htc("V,,,H,N,,,,,45.5,,,M,C"))
    assert told == HeadingTrackControl(
        override=YesNo.NO,
        steering_mode=SteeringMode.HEADING_CONTROL,
        turn_mode=TurnMode.RUDDER_LIMIT_CONTROLLED,
        heading_reference=MAGNETIC,
        heading_to_steer_course=radians(45.5),
    )
    assert told.encode()[5:7].hex() == "051f"


@pytest.mark.parametrize(
    ("letter", "mode"),
    [
        ("M", SteeringMode.MAIN_STEERING),
        ("S", SteeringMode.HEADING_CONTROL_STANDALONE),
        ("H", SteeringMode.HEADING_CONTROL),
        ("T", SteeringMode.TRACK_CONTROL),
        ("R", SteeringMode.FOLLOW_UP),
        ("", None),
    ],
)
def test_every_steering_mode_has_its_number(letter, mode):
    assert from_htc(htc(f"V,,,{letter},,,,,,,,,")).steering_mode is mode


@pytest.mark.parametrize(
    ("letter", "mode"),
    [
        ("N", TurnMode.RUDDER_LIMIT_CONTROLLED),
        ("T", TurnMode.TURN_RATE_CONTROLLED),
        ("R", TurnMode.RADIUS_CONTROLLED),
        ("", None),
    ],
)
def test_every_turn_mode_has_its_number(letter, mode):
    assert from_htc(htc(f"V,,,,{letter},,,,,,,,")).turn_mode is mode


@pytest.mark.parametrize(("letter", "answer"), [("A", YesNo.YES), ("V", YesNo.NO), ("", None)])
def test_an_override_is_told_or_not(letter, answer):
    assert from_htc(htc(f"{letter},,,,,,,,,,,,")).override is answer


@pytest.mark.parametrize(
    ("fields", "angle", "direction"),
    [
        ("10.0,R", radians(10), DirectionRudder.STARBOARD),
        ("10.0,L", -radians(10), DirectionRudder.PORT),
        ("0.0,", 0.0, DirectionRudder.NO_ORDER),
        ("10.0,", radians(10), None),
        (",L", None, DirectionRudder.PORT),
        (",", None, None),
    ],
)
def test_a_rudder_order_has_its_sign_and_its_direction(fields, angle, direction):
    told = from_htc(htc(f"V,{fields},R,,,,,,,,,"))
    assert (told.commanded_rudder_angle, told.commanded_rudder_direction) == (angle, direction)


@pytest.mark.parametrize(("side", "sign"), [("R", 1), ("L", -1), ("", 1)])
def test_limits_and_turns_keep_their_units_and_the_radius_its_side(side, sign):
    told = from_htc(htc(f"V,5.0,{side},T,R,25.0,20.0,0.50,60.0,190.4,0.10,188.0,T"))
    assert told.rudder_limit == radians(25)
    assert told.off_heading_limit == radians(20)
    assert told.radius_of_turn_order == sign * 926
    assert told.rate_of_turn_order == pytest.approx(radians(1))
    assert told.heading_to_steer_course == radians(190.4)
    assert told.off_track_limit == 185
    assert told.track == radians(188)
    assert told.heading_reference is TRUE


def test_what_127237_has_no_room_for_is_not_told():
    told = from_htc(htc("V,,,T,R,,,17.80,3600.0,,17.80,,T"))
    assert (told.radius_of_turn_order, told.rate_of_turn_order, told.off_track_limit) == (None, None, None)
    at_the_edge = from_htc(htc("V,,,T,R,,,17.69,3518.0,,17.69,,T"))
    assert None not in (at_the_edge.radius_of_turn_order, at_the_edge.off_track_limit)
    at_the_edge.encode()


def test_a_full_turn_is_no_turn():
    assert from_htc(htc("V,,,H,N,,,,,360.0,,,T")).heading_to_steer_course == 0.0


# From HTD -----------------------------------------------------------------------------------------------


def test_an_htd_of_a_manual_says_what_is_kept_and_where_the_bow_points():
    read = parse(b"$AGHTD,V,,,H,N,25.0,20.0,,,190.4,,,T,A,V,,186.4" + b"")
    sentence = parse(seal("AGHTD,V,,,H,N,25.0,20.0,,,190.4,,,T,A,V,,186.4").strip())
    assert not isinstance(read, s.HTD)  # without a check sum it is nothing
    assert isinstance(sentence, s.HTD)
    told = from_htd(sentence)
    assert told.rudder_limit_exceeded is YesNo.NO
    assert told.off_heading_limit_exceeded is YesNo.YES
    assert told.off_track_limit_exceeded is None
    assert told.vessel_heading == radians(186.4)
    assert told.heading_to_steer_course == radians(190.4)
    assert told.heading_reference is TRUE


# There and back -----------------------------------------------------------------------------------------

QUICK = settings(max_examples=60, deadline=None)
angles = st.none() | st.integers(0, 3599).map(lambda tenths: tenths / 10)
limits = st.none() | st.integers(0, 1800).map(lambda tenths: tenths / 10)
miles = st.none() | st.integers(0, 1700).map(lambda hundredths: hundredths / 100)
rates = st.none() | st.integers(-35000, 35000).map(lambda tenths: tenths / 10)
flags = st.none() | st.booleans()
shared = {
    "override": flags,
    "rudder_angle_deg": st.none() | st.integers(1, 1800).map(lambda tenths: tenths / 10),
    "rudder_direction": st.sampled_from(s.RudderDirection),
    "steering_mode": st.none() | st.sampled_from(s.SteeringMode),
    "turn_mode": st.none() | st.sampled_from(s.TurnMode),
    "rudder_limit_deg": limits,
    "off_heading_limit_deg": limits,
    "radius_nm": miles,
    "rate_deg_min": rates,
    "heading_to_steer_deg": angles,
    "off_track_limit_nm": miles,
    "track_deg": angles,
    "reference": st.none() | st.sampled_from(s.Reference),
}
reports = shared | {
    "within_rudder_limit": flags,
    "within_off_heading_limit": flags,
    "within_off_track_limit": flags,
    "heading_deg": angles,
}


def same(sentence, back):
    """All fields as they are printed; of a rate, 127237's steps are 0.107 degrees a minute."""
    rates = sentence.rate_deg_min, back.rate_deg_min
    assert (rates[0] is None) == (rates[1] is None)
    assert rates[0] is None or abs(rates[0] - rates[1]) <= 0.054
    plain = msgspec.structs.replace(sentence, rate_deg_min=None), msgspec.structs.replace(back, rate_deg_min=None)
    return plain[0].encode() == plain[1].encode()


@QUICK
@given(st.builds(s.HTC, **shared))
def test_an_htc_comes_back_as_it_was_over_the_bytes_of_127237(sentence):
    over_the_bus = HeadingTrackControl.decode(from_htc(sentence).encode())
    assert same(sentence, to_htc(over_the_bus))


@QUICK
@given(st.builds(s.HTD, **reports))
def test_an_htd_comes_back_as_it_was_over_the_bytes_of_127237(sentence):
    over_the_bus = HeadingTrackControl.decode(from_htd(sentence).encode())
    assert same(sentence, heading_track(over_the_bus))


directions = st.none() | st.floats(0, tau - 1e-4)
messages = st.builds(
    HeadingTrackControl,
    override=st.none() | st.sampled_from([YesNo.NO, YesNo.YES]),
    steering_mode=st.none() | st.sampled_from([mode for mode in SteeringMode if mode != SteeringMode.NON_FOLLOW_UP]),
    turn_mode=st.none() | st.sampled_from(TurnMode),
    heading_reference=st.none() | st.sampled_from([TRUE, MAGNETIC]),
    heading_to_steer_course=directions,
    track=directions,
    rudder_limit=st.none() | st.floats(0, 3.0),
    off_heading_limit=st.none() | st.floats(0, 3.0),
    rate_of_turn_order=st.none() | st.floats(-1.0, 1.0),
    off_track_limit=st.none() | st.integers(0, 30000),
    vessel_heading=directions,
)


@QUICK
@given(messages)
def test_a_127237_comes_back_within_the_tenths_of_an_htd(message):
    read = parse(heading_track(message).encode().strip())
    assert isinstance(read, s.HTD)
    back = from_htd(read)
    for name in ("override", "steering_mode", "turn_mode", "heading_reference"):
        assert getattr(back, name) == getattr(message, name)
    for name in ("heading_to_steer_course", "track", "vessel_heading", "rudder_limit", "off_heading_limit"):
        one, other = getattr(message, name), getattr(back, name)
        assert (one is None) == (other is None)
        assert one is None or abs((degrees(one - other) + 180) % 360 - 180) <= 0.0501
    assert (message.off_track_limit is None) == (back.off_track_limit is None)
    assert message.off_track_limit is None or abs(message.off_track_limit - back.off_track_limit) <= 10


def test_non_follow_up_steering_is_lost_on_the_way():
    jogged = HeadingTrackControl(
        steering_mode=SteeringMode.NON_FOLLOW_UP, commanded_rudder_direction=DirectionRudder.PORT
    )
    sentence = heading_track(jogged)
    assert (sentence.steering_mode, sentence.rudder_direction) == (s.SteeringMode.RUDDER_CONTROL, "L")
    assert from_htd(sentence).steering_mode is SteeringMode.FOLLOW_UP


# As a command -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fields", "wanted"),
    [
        ("V,,,M,N,,,,,,,,", LetGo()),
        ("V,,,H,N,,,,,45.5,,,M", Hold(radians(45.5), MAGNETIC)),
        ("V,,,H,N,,,,,,,,", Hold(None, None)),
        ("V,,,S,N,,,,,45.5,,,M", Hold(None, None)),
        ("A,,,H,N,,,,,45.5,,,M", "HTC: override in use"),
        ("V,,,T,N,,,,,45.5,,,M", "HTC: steering mode T is not for us"),
        ("V,10.0,L,R,N,,,,,,,,", "HTC: steering mode R is not for us"),
        ("V,,,,N,,,,,45.5,,,M", "HTC: no steering mode"),
    ],
)
def test_an_htc_is_an_order_or_a_reason_why_not(fields, wanted):
    assert order(htc(fields)) == wanted


class Controlled(Afloat):
    """A boat whose station 1 is a heading controller."""

    def __init__(self, **settings):
        super().__init__(44.8, obey_htc=True, **settings)

    def controller(self, fields, port="IN1"):
        return self.boat.receive_bytes(port, seal(f"EIHTC,{fields}"), self.now)

    @property
    def mode(self):
        return self.boat.helm.pilot.mode

    @property
    def setpoint(self):
        return self.boat.helm.pilot.setpoint


def refused(effects):
    return [effect.reason for effect in effects if isinstance(effect, Refused)]


def test_a_heading_controller_in_command_engages_turns_and_lets_go():
    afloat = Controlled().in_command()
    afloat.controller("V,,,H,N,,,,,60.0,,,T")
    assert (afloat.mode, afloat.setpoint) == (Mode.HEADING_HOLD, 600)
    afloat.controller("V,,,H,N,,,,,62.5,,,T")
    assert (afloat.mode, afloat.setpoint) == (Mode.HEADING_HOLD, 625)
    afloat.controller("V,,,M,N,,,,,,,,")
    assert afloat.mode is Mode.STANDBY


def test_a_heading_controller_without_a_heading_holds_the_present_one():
    afloat = Controlled().in_command()
    afloat.controller("V,,,S,N,,,,,60.0,,,T")
    assert (afloat.mode, afloat.setpoint) == (Mode.HEADING_HOLD, 448)


def test_a_heading_controller_that_is_not_in_command_is_refused():
    afloat = Controlled()
    effects = afloat.controller("V,,,H,N,,,,,60.0,,,T")
    assert refused(effects) == ["not in command"]
    assert sent(effects) == []
    assert afloat.mode is Mode.STANDBY
    afloat.in_command(2)
    assert refused(afloat.controller("V,,,M,N,,,,,,,,")) == ["not in command"]


def test_what_a_controller_says_again_is_not_done_again():
    afloat = Controlled().in_command()
    afloat.controller("V,,,H,N,,,,,60.0,,,T")
    afloat.say(1, Verb.DISENGAGE)
    assert afloat.controller("V,,,H,N,,,,,60.0,,,T") == []
    assert afloat.mode is Mode.STANDBY
    afloat.controller("V,,,H,N,,,,,61.0,,,T")
    assert afloat.mode is Mode.HEADING_HOLD


def test_what_was_refused_is_tried_when_it_is_said_again():
    afloat = Controlled()
    assert refused(afloat.controller("V,,,H,N,,,,,60.0,,,T")) == ["not in command"]
    afloat.in_command()
    assert refused(afloat.controller("V,,,H,N,,,,,60.0,,,T")) == []
    assert afloat.mode is Mode.HEADING_HOLD


def test_a_magnetic_course_is_counted_by_the_variation_or_refused():
    afloat = Controlled().in_command()
    assert refused(afloat.controller("V,,,H,N,,,,,60.0,,,M")) == [
        "HTC: its reference, or the magnetic variation, is not known"
    ]
    assert afloat.mode is Mode.STANDBY
    compass = msgspec.structs.replace(heading(42.8, MAGNETIC), deviation=0.0, variation=radians(2.0))
    afloat.bus(compass, source=11)
    afloat.controller("V,,,H,N,,,,,60.0,,,M")
    assert afloat.setpoint == 620


def test_a_course_without_a_reference_is_refused():
    afloat = Controlled().in_command()
    assert refused(afloat.controller("V,,,H,N,,,,,60.0,,,")) != []
    assert afloat.mode is Mode.STANDBY


def test_an_order_that_is_not_for_us_is_refused_with_its_reason():
    afloat = Controlled().in_command()
    assert refused(afloat.controller("V,,,T,N,,,,,60.0,,,T")) == ["HTC: steering mode T is not for us"]


def test_a_controller_is_not_heard_unless_the_owner_says_so_and_on_a_wire_of_its_own():
    deaf = Afloat(44.8).in_command()
    deaf.boat.receive_bytes("IN1", seal("EIHTC,V,,,H,N,,,,,60.0,,,T"), deaf.now)
    assert deaf.boat.helm.pilot.mode is Mode.STANDBY
    shared = Afloat(44.8, ports=[Port("bus"), Port("IN1", 1)], obey_htc=True).in_command()
    assert shared.boat.receive_bytes("bus", seal("EIHTC,V,,,H,N,,,,,60.0,,,T"), shared.now) == []
    assert shared.boat.helm.pilot.mode is Mode.STANDBY


def test_a_broken_htc_is_rejected_and_a_flood_of_them_is_told_once():
    afloat = Controlled(commands_per_second=3).in_command()
    (rejected,) = afloat.controller("V,,,X,N,,,,,60.0,,,T")
    assert isinstance(rejected, Rejected)
    afloat.controller("V,,,H,N,,,,,60.0,,,T")
    effects = [effect for _ in range(5) for effect in afloat.controller("V,,,H,N,,,,,60.0,,,T")]
    assert [type(effect) for effect in effects] == [Rejected]
    assert not any(isinstance(effect, Transmit) for effect in effects)
