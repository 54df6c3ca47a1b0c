"""The whole gateway of a boat as one machine: what goes in, what comes out."""

from math import radians

import pytest

from timonel.core.alerts import AlertChanged
from timonel.core.effects import Effect, Refused, Rejected, Say, SecurityEvent, Transmit
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.nmea0183.sentences import ACK, ACN, AlertCommand
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, RateOfTurn, Rudder, VesselHeading
from timonel.vehicles.boat.alerts import COMMANDER_UNPLUGGED
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

PORTS = [Port(f"IN{station}", station) for station in (1, 2, 3, 4)]
PILOT = 204


def heading(degrees: float, reference: HeadingReference = HeadingReference.TRUE) -> VesselHeading:
    return VesselHeading(sid=None, heading=radians(degrees), deviation=None, variation=None, reference=reference)


def rudder(degrees: float) -> Rudder:
    return Rudder(instance=0, direction_order=None, angle_order=None, position=radians(degrees))


def frames(message: Message, source: int = 10, sequence: int = 0) -> list[Frame]:
    pgn = type(message).PGN
    assert pgn is not None
    identifier = join(2, pgn, source)
    payload = message.encode()
    parts = fragment(payload, sequence) if pgn == 127237 else [payload]
    return [Frame(identifier, part) for part in parts]


def lines(effects: list[Effect]) -> list[str]:
    return [effect.line.decode().rstrip() for effect in effects if isinstance(effect, Say)]


def parp_lines(effects: list[Effect]) -> list[str]:
    return [line[1:-3] for line in lines(effects) if line.startswith("$PARP")]


def sent(effects: list[Effect]) -> list[Frame]:
    return [effect.frame for effect in effects if isinstance(effect, Transmit)]


class Afloat:
    """A boat with a living backbone, and short ways to speak to it."""

    def __init__(self, degrees: float = 90.0, ports: list[Port] = PORTS, **settings: object) -> None:
        self.boat = Boat(BoatSettings(**settings), ports, now=0.0)  # type: ignore[arg-type]
        self.now = 0.0
        self.boat.expire(0.0)
        self.bus(heading(degrees))

    def bus(self, message: Message, source: int = 10, sequence: int = 0) -> list[Effect]:
        return self.boat.receive_frames(frames(message, source, sequence), self.now)

    def say(self, station: int, verb: Verb, parameter: float = 0.0, port: str = "") -> list[Effect]:
        return self.boat.receive_bytes(port or f"IN{station}", parp.command(verb, station, parameter), self.now)

    def in_command(self, station: int = 1) -> "Afloat":
        self.say(station, Verb.REQCMD)
        assert self.boat.helm.transfer.commander == station
        return self


# Steering -------------------------------------------------------------------------------------------


def test_a_set_heading_becomes_the_four_frames_of_the_worked_example():
    afloat = Afloat(44.8).in_command()
    afloat.say(1, Verb.ENGAGE)
    effects = afloat.say(1, Verb.SETHEADING, 45.5)
    assert [frame.identifier for frame in sent(effects)] == [0x09F10523] * 4
    assert [frame.data.hex(" ") for frame in sent(effects)] == [
        "20 15 3f 3c ff ff 7f 05",
        "21 1f ff ff ff ff ff ff",
        "22 ff 7f ff 7f ff 7f 8b",
        "23 1e ff ff ff ff ff ff",
    ]


def test_disengage_says_main_steering_and_no_course():
    afloat = Afloat(44.8).in_command()
    payload = b"".join(
        frame.data[2 if index == 0 else 1 :] for index, frame in enumerate(sent(afloat.say(1, Verb.DISENGAGE)))
    )
    message = HeadingTrackControl.decode(payload[:21])
    assert message.steering_mode is SteeringMode.MAIN_STEERING
    assert message.heading_to_steer_course is None
    assert message.vessel_heading == pytest.approx(radians(44.8), abs=1e-4)


def test_the_sequence_counter_turns():
    afloat = Afloat().in_command()
    afloat.say(1, Verb.ENGAGE)
    counters = [sent(afloat.say(1, Verb.STBDONE))[0].data[0] >> 5 for _ in range(9)]
    assert counters == [1, 2, 3, 4, 5, 6, 7, 0, 1]


def test_a_boat_may_be_steered_by_magnetic_headings():
    afloat = Afloat(heading_reference="magnetic")
    afloat.bus(heading(80.0, HeadingReference.MAGNETIC))
    afloat.in_command()
    effects = afloat.say(1, Verb.ENGAGE)
    assert parp_lines(effects) == ["PARP,STATUS,HEADING_HOLD,080.0,080.0,,01"]
    assert sent(effects)[0].data[3] >> 6 == HeadingReference.MAGNETIC


def test_the_pilots_report_is_shown_in_the_boats_reference():
    afloat = Afloat()
    report = HeadingTrackControl(
        steering_mode=SteeringMode.HEADING_CONTROL,
        heading_reference=HeadingReference.TRUE,
        heading_to_steer_course=radians(120.0),
    )
    assert parp_lines(afloat.bus(report, PILOT)) == ["PARP,STATUS,HEADING_HOLD,120.0,090.0,,00"]
    magnetic = HeadingTrackControl(
        steering_mode=SteeringMode.HEADING_CONTROL,
        heading_reference=HeadingReference.MAGNETIC,
        heading_to_steer_course=radians(120.0),
    )
    assert parp_lines(afloat.bus(magnetic, PILOT, sequence=1)) == [], "without variation the course is not known"


def test_a_pilot_that_tells_a_mode_nobody_understands_leaves_the_field_empty():
    afloat = Afloat()
    report = HeadingTrackControl(steering_mode=SteeringMode.FOLLOW_UP)
    assert parp_lines(afloat.bus(report, PILOT)) == ["PARP,STATUS,,,090.0,,00"]


def test_a_compass_that_still_speaks_does_not_keep_another_ones_heading_alive():
    afloat = Afloat(90.0)
    for tenth in range(1, 40):
        afloat.now = tenth / 10
        afloat.bus(heading(80.0, HeadingReference.MAGNETIC), source=11)
    assert afloat.boat.helm.pilot.heading(2.9) is not None
    assert afloat.boat.helm.pilot.heading(3.0) is None


# STATUS ---------------------------------------------------------------------------------------------


def test_status_is_said_twice_a_second_whatever_else_happens():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    said = []
    while boat.deadline < 10.0:
        now = boat.deadline
        said += [now for line in parp_lines(boat.expire(now)) if line.startswith("PARP,STATUS")]
        boat.receive_frames(frames(heading(90.0)), now)
    assert said == [0.5 * number for number in range(20)]


def test_a_late_timer_does_not_make_status_run_after_the_clock():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    assert len(parp_lines(boat.expire(7.3))) == 2, "the alarm, and the regular one"
    assert boat.deadline == 7.8


def test_what_is_not_known_is_an_empty_field():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    assert parp_lines(boat.expire(0.0)) == ["PARP,STATUS,STANDBY,000.0,,,00"]


def test_the_rudder_is_shown_with_its_sign_and_only_while_it_is_known():
    afloat = Afloat()
    afloat.bus(rudder(-3.2), 11)
    afloat.now = 0.5
    assert parp_lines(afloat.boat.expire(0.5)) == ["PARP,STATUS,STANDBY,000.0,090.0,-3.2,00"]
    afloat.now = 3.0
    afloat.bus(heading(90.0))
    assert parp_lines(afloat.boat.expire(3.5))[-1] == "PARP,STATUS,STANDBY,000.0,090.0,,00"


def test_status_goes_ahead_of_data_and_an_older_one_is_worthless():
    status = next(e for e in Afloat().say(1, Verb.REQCMD) if isinstance(e, Say) and b"STATUS" in e.line)
    assert (status.urgent, status.state) == (True, True)


# Stations -------------------------------------------------------------------------------------------


def test_a_transfer_is_announced_before_the_status_that_shows_it():
    assert parp_lines(Afloat().say(2, Verb.REQCMD)) == [
        "PARP,CMDTRANSFER,00,02",
        "PARP,STATUS,STANDBY,000.0,090.0,,02",
    ]


def test_a_refusal_is_answered_with_a_status_at_once():
    effects = Afloat().in_command(1).say(2, Verb.ENGAGE)
    assert Refused("not in command", 2) in effects
    assert parp_lines(effects) == ["PARP,STATUS,STANDBY,000.0,090.0,,01"]


def test_another_stations_id_on_a_bound_port_is_a_security_event_and_nothing_else():
    afloat = Afloat()
    assert afloat.say(1, Verb.TAKECMD, port="IN2") == [SecurityEvent("another station's id", "IN2", 1)]
    assert afloat.boat.helm.transfer.commander == 0


def test_on_a_shared_wire_the_sentence_says_who_speaks():
    afloat = Afloat(ports=[Port("UART2")])
    afloat.say(3, Verb.REQCMD, port="UART2")
    assert afloat.boat.helm.transfer.commander == 3
    afloat.say(1, Verb.TAKECMD, port="UART2")
    assert afloat.boat.helm.transfer.commander == 1


def test_on_a_shared_wire_the_short_form_says_too_little():
    afloat = Afloat(ports=[Port("UART2")])
    afloat.say(1, Verb.REQCMD, port="UART2")
    afloat.say(2, Verb.REQCMD, port="UART2")
    sentence = b"$PARP,RELCMD,02*00"
    assert afloat.boat.receive_bytes("UART2", sentence + b"\r\n", 0.0) == [Rejected("malformed", sentence, "UART2")]


@pytest.mark.parametrize(
    ("sentence", "reason"),
    [
        (b"$PARP,REQCMD,000.0,01*00", "wrong check sum"),
        (b"$PARP,REQCMD,000.0,01", "no check sum"),
        (b"$PARP,STEER,000.0,01*45", "unknown command"),
        (b"$PARP,REQCMD,000.0,09*14", "malformed"),
    ],
)
def test_a_sentence_that_is_none_is_counted_and_answered_by_nothing(sentence: bytes, reason: str):
    afloat = Afloat()
    assert afloat.boat.receive_bytes("IN1", sentence + b"\r\n", 0.0) == [Rejected(reason, sentence, "IN1")]
    assert afloat.boat.counters[reason] == 1


def test_a_sentence_may_come_in_pieces():
    afloat = Afloat()
    for byte in parp.command(Verb.REQCMD, 1):
        afloat.boat.receive_bytes("IN1", bytes((byte,)), 0.0)
    assert afloat.boat.helm.transfer.commander == 1


def test_sentences_of_other_kinds_are_not_for_us():
    afloat = Afloat()
    assert afloat.boat.receive_bytes("IN1", b"$HEHDT,1.0,T*29\r\n", 0.0) == []
    assert afloat.boat.counters["sentences not for us"] == 1


def test_beyond_twenty_commands_a_second_the_rest_is_dropped_counted_and_told_once():
    afloat = Afloat()
    effects = [effect for _ in range(50) for effect in afloat.say(2, Verb.ENGAGE)]
    assert sum(isinstance(effect, Refused) for effect in effects) == 20
    assert sum(isinstance(effect, Rejected) for effect in effects) == 1
    assert afloat.boat.counters["commands beyond the allowance"] == 30
    assert afloat.say(1, Verb.REQCMD), "another port is not held back"
    afloat.now = 1.0
    assert any(isinstance(effect, Refused) for effect in afloat.say(2, Verb.ENGAGE))


# Alerts ---------------------------------------------------------------------------------------------


def test_an_alert_is_said_and_any_station_acknowledges_it():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    assert "$IIALR,,101,A,V,backbone silent*70" in lines(boat.expire(3.0))
    effects = boat.receive_bytes("IN4", ACK(101).encode("II"), 3.0)
    assert [e.alert.acknowledged for e in effects if isinstance(e, AlertChanged)] == [True]
    assert boat.receive_bytes("IN3", ACK(101).encode("II"), 3.0) == []


def test_a_station_silences_and_acknowledges_an_alert_by_command_too():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    boat.expire(3.0)
    boat.receive_bytes("IN4", ACN(alarm=101, command=AlertCommand.SILENCE, status="C").encode("II"), 3.0)
    assert [alert.silenced_until for alert in boat.helm.alerts.standing] == [33.0]
    assert boat.deadline <= 33.0
    boat.receive_bytes("IN4", ACN(alarm=101, command=AlertCommand.ACKNOWLEDGE, status="C").encode("II"), 3.0)
    assert [alert.acknowledged for alert in boat.helm.alerts.standing] == [True]


@pytest.mark.parametrize("sentence", [b"$IIACK,*4A", b"$IIACK,101*00", b"$IIACK,xyz*33", b"$IIACN,,,101,,Q,C*6E"])
def test_an_acknowledgement_that_is_none_is_rejected(sentence: bytes):
    effects = Afloat().boat.receive_bytes("IN1", sentence + b"\r\n", 0.0)
    assert [type(effect) for effect in effects] == [Rejected]


def test_an_unplugged_commander_keeps_command_and_people_are_told():
    afloat = Afloat().in_command(2)
    afloat.boat.port_changed("IN3", False, 0.0)
    assert not afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)
    effects = afloat.boat.port_changed("IN2", False, 0.0)
    assert afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)
    assert any(line.startswith("$IIALR,,106,A,V") for line in lines(effects))
    assert afloat.boat.helm.transfer.commander == 2
    afloat.boat.port_changed("IN2", True, 0.0)
    assert not afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)


def test_a_commander_with_another_port_that_is_connected_is_not_unplugged():
    afloat = Afloat(ports=[*PORTS, Port("console", 2, console=True)]).in_command(2)
    afloat.boat.port_changed("console", True, 0.0)
    afloat.boat.port_changed("IN2", False, 0.0)
    assert not afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)
    afloat.boat.port_changed("console", False, 0.0)
    assert afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)
    afloat.boat.port_changed("IN2", True, 0.0)
    assert not afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)


def test_command_that_goes_to_an_unplugged_station_raises_the_alert_and_leaving_it_ends_it():
    afloat = Afloat().in_command(2)
    afloat.say(3, Verb.REQCMD)
    afloat.boat.port_changed("IN3", False, 0.0)
    afloat.say(2, Verb.RELCMD)
    assert afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)
    afloat.say(1, Verb.TAKECMD)
    assert not afloat.boat.helm.alerts.active(COMMANDER_UNPLUGGED)


def test_half_a_sentence_of_an_unplugged_port_is_not_finished_by_the_next_one():
    afloat = Afloat()
    whole = parp.command(Verb.REQCMD, 1)
    afloat.boat.receive_bytes("IN1", whole[:10], 0.0)
    afloat.boat.port_changed("IN1", False, 0.0)
    afloat.boat.receive_bytes("IN1", whole[10:], 0.0)
    assert afloat.boat.helm.transfer.commander == 0


def test_a_port_that_only_listens_is_of_no_concern():
    assert Afloat().boat.port_changed("OUT1", False, 0.0) == []


# The bus --------------------------------------------------------------------------------------------


def test_frames_of_our_own_address_and_of_other_buses_are_not_heard():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    ours = frames(heading(90.0), source=0x23)
    assert boat.receive_frames(ours, 0.0)[1:] == []
    short = [Frame(100, b"\0\0", extended=False)]
    boat.receive_frames(short, 1.0)
    assert boat.counters == {"frames from our own address": 1, "frames with 11-bit identifiers": 1}
    boat.expire(3.0)
    assert boat.helm.pilot.mode.value == "ALARM", "they are no sign of life"


def test_a_pgn_that_nobody_understands_is_a_sign_of_life():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    boat.receive_frames([Frame(join(6, 65301, 7), b"\xff" * 8)], 2.0)
    boat.expire(4.0)
    assert boat.helm.pilot.mode.value == "STANDBY"


def test_a_whole_message_is_heard_like_its_frames():
    afloat = Afloat()
    report = HeadingTrackControl(steering_mode=SteeringMode.TRACK_CONTROL)
    effects = afloat.boat.receive_message(join(2, 127237, PILOT), report.encode(), 0.0)
    assert parp_lines(effects) == ["PARP,STATUS,TRACK,,090.0,,00"]
    effects = afloat.boat.receive_message(join(2, 127251, 10), RateOfTurn(sid=None, rate=0.01).encode(), 0.0)
    assert lines(effects) == ["$IIROT,34.4,A*15"]
    assert afloat.boat.receive_message(join(2, 129041, 10), bytes(28), 0.0) == []


def test_a_lost_frame_of_a_pilots_report_is_no_report():
    afloat = Afloat()
    report = HeadingTrackControl(steering_mode=SteeringMode.TRACK_CONTROL)
    parts = frames(report, PILOT)
    del parts[1]
    assert afloat.boat.receive_frames(parts, 0.0) == []
    assert afloat.boat.fast_packets.completed == 0
