"""The whole boat and its alerts: one table, everybody told, one acknowledgement that reaches all."""

from math import radians

import msgspec
import pytest

from timonel.core.alerts import AlertChanged
from timonel.core.effects import Effect, Rejected, Say, SayTo, Transmit
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences import (
    ACK,
    ACN,
    ALC,
    ALF,
    ALR,
    AlertCommand,
    AlertCondition,
    AlertUrgency,
    Listed,
)
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import Reassembler, fragment
from timonel.nmea2000.identifier import join, split
from timonel.nmea2000.lookups import (
    AlertLanguageId,
    AlertResponseCommand,
    AlertState,
    AlertType,
    HeadingReference,
    SeatalkAlarmGroup,
    SeatalkAlarmId,
    SeatalkAlarmStatus,
    SimnetAlarmCommand,
    SimnetAlarmId,
    YesNoBit,
)
from timonel.nmea2000.messages.alerts import Alert as AlertMessage
from timonel.nmea2000.messages.alerts import AlertResponse, AlertText
from timonel.nmea2000.messages.maretron import MaretronAlertTransmission
from timonel.nmea2000.messages.navico import NavicoAlarm, SimnetAlarm, SimnetAlarmMessage
from timonel.nmea2000.messages.raymarine import SeatalkAlarm, SeatalkSilenceAlarm
from timonel.nmea2000.messages.steering import VesselHeading
from timonel.nmea2000.node import NodeSettings
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.alerting import Done
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

NAME = 0xC0328200_E07C04D2
OURS = (1 << 64) - 1  # our NAME while there is no node
PORTS = [Port("IN1", 1), Port("IN2", 2), Port("AIS", instrument=True), Port("BAM", 3, instrument=True)]


def heading() -> VesselHeading:
    true = HeadingReference.TRUE
    return VesselHeading(sid=None, heading=radians(90), deviation=None, variation=None, reference=true)


def alert(state: AlertState | None = AlertState.ACTIVE, name: int = NAME, **fields: object) -> AlertMessage:
    given: dict[str, object] = {
        "alert_type": AlertType.ALARM,
        "alert_id": 20493,
        "data_source_network_id_name": name,
        "data_source_instance": 0,
        "alert_occurrence_number": 1,
        "acknowledge_support": YesNoBit.YES,
        "acknowledge_source_network_id_name": OURS,
        "alert_state": state,
    }
    return AlertMessage(**given | fields)  # type: ignore[arg-type]


def text(words: str, name: int = NAME, **fields: object) -> AlertText:
    given: dict[str, object] = {
        "alert_id": 20493,
        "data_source_network_id_name": name,
        "data_source_instance": 0,
        "language_id": AlertLanguageId.ENGLISH_US,
        "alert_text_description": words,
        "alert_location_text_description": "",
    }
    return AlertText(**given | fields)  # type: ignore[arg-type]


def response(command: AlertResponseCommand, number: int = 101, name: int = OURS, occurrence: int = 1) -> AlertResponse:
    return AlertResponse(
        alert_id=number,
        data_source_network_id_name=name,
        alert_occurrence_number=occurrence,
        acknowledge_source_network_id_name=NAME,
        response_command=command,
    )


class Afloat:
    """A boat with alerts on a living backbone, and short ways to speak to it."""

    def __init__(self, node: NodeSettings | None = None, **settings: object) -> None:
        alerts = AlertSettings(**settings)  # type: ignore[arg-type]
        self.boat = Boat(BoatSettings(alerts=alerts, node=node), PORTS, now=0.0)
        self.now = 0.0
        self._sequence = 0
        self._reassembler = Reassembler()
        self.boat.expire(0.0)
        self.bus(heading())

    def bus(self, message: Message, source: int = 20) -> list[Effect]:
        pgn = type(message).PGN
        assert pgn is not None
        self._sequence = (self._sequence + 1) % 8
        payload = message.encode()[:223]
        parts = fragment(payload, self._sequence) if registry.is_fast(pgn) else [payload]
        return self.boat.receive_frames([Frame(join(2, pgn, source), part) for part in parts], self.now)

    def say(self, sentence: Sentence, port: str = "IN1", talker: str = "II") -> list[Effect]:
        return self.boat.receive_bytes(port, sentence.encode(talker), self.now)

    def silent_bus(self, now: float = 3.0) -> list[Effect]:
        self.now = now
        return self.boat.expire(now)

    def until(self, end: float) -> list[Effect]:
        """All that time brings, with a heading every second so that nothing is lost."""
        effects: list[Effect] = []
        while self.boat.deadline <= end:
            self.now = max(self.now, self.boat.deadline)
            effects += self.boat.expire(self.now)
            effects += self.bus(heading())
        self.now = end
        return effects

    def sent(self, effects: list[Effect]) -> list[Message]:
        """The messages that went out."""
        messages: list[Message] = []
        for effect in effects:
            if isinstance(effect, Transmit):
                frame = effect.frame
                pgn = split(frame.identifier).pgn
                fast = registry.is_fast(pgn)
                data = self._reassembler.receive(frame.identifier, frame.data, self.now) if fast else frame.data
                if data is not None and (message := registry.decode(pgn, data)) is not None:
                    messages.append(message)
        return messages

    def states(self, effects: list[Effect]) -> list[AlertState | None]:
        """What the bus was told of our alerts."""
        return [message.alert_state for message in self.sent(effects) if isinstance(message, AlertMessage)]

    @property
    def standing(self) -> list[tuple[int, str, bool, bool]]:
        return [(a.kind.id, a.kind.name, a.active, a.acknowledged) for a in self.boat.helm.alerts.standing]


def lines(effects: list[Effect]) -> list[str]:
    about_alerts = ("ALR", "ALF", "ALC", "ARC", "HBT")
    return [e.line.decode()[1:-5] for e in effects if isinstance(e, Say) and e.key in about_alerts]


# Ours, on the bus -----------------------------------------------------------------------------------


def test_an_alert_of_ours_is_told_to_the_bus_with_its_text_and_again_every_second():
    afloat = Afloat()
    state, words = afloat.sent(afloat.silent_bus())
    assert isinstance(state, AlertMessage)
    assert isinstance(words, AlertText)
    assert (state.alert_type, state.alert_id, state.alert_occurrence_number) == (AlertType.ALARM, 101, 1)
    assert (state.alert_state, state.acknowledge_support) == (AlertState.ACTIVE, YesNoBit.YES)
    assert state.data_source_network_id_name == words.data_source_network_id_name == OURS
    assert words.alert_text_description == "backbone silent: nothing heard from the backbone for 3 s"
    again = [effect for now in range(1, 101) for effect in afloat.boat.expire(3.0 + now / 10)]
    assert afloat.states(again) == [AlertState.ACTIVE] * 10
    assert [message for message in afloat.sent(again) if isinstance(message, AlertText)] == [words]


def test_an_alert_that_is_over_is_told_so_three_times_more():
    afloat = Afloat()
    afloat.silent_bus()
    back = afloat.bus(heading())
    assert afloat.states(back) == [AlertState.AWAITING_ACKNOWLEDGE]
    gone = afloat.say(ACK(101))
    assert afloat.states(gone) == [AlertState.NORMAL]
    assert afloat.states(afloat.until(20.0)) == [AlertState.NORMAL] * 3


def test_an_alert_that_arises_again_is_another_occurrence():
    afloat = Afloat()
    afloat.silent_bus()
    afloat.bus(heading())
    again = afloat.sent(afloat.silent_bus(8.0))
    assert {message.alert_occurrence_number for message in again if isinstance(message, AlertMessage)} == {2}


def test_many_alerts_take_turns_on_the_bus():
    afloat = Afloat()
    for number in range(20):
        afloat.say(ALR(None, number, True, False, f"alarm {number}"), "AIS", "AI")
    told = afloat.sent(afloat.until(2.5))
    numbers = [message.alert_id for message in told if isinstance(message, AlertMessage)]
    assert numbers == [*range(401, 421)]


def test_the_bus_is_not_told_where_its_owner_does_not_want_it():
    afloat = Afloat(tell_bus=False)
    assert afloat.sent(afloat.silent_bus()) == []
    assert afloat.sent(afloat.until(10.0)) == []


def test_an_alert_of_ours_bears_our_name():
    node = NodeSettings()
    afloat = Afloat(node)
    afloat.until(2.0)
    effects = afloat.silent_bus(6.0)
    (state,) = [message for message in afloat.sent(effects) if isinstance(message, AlertMessage)]
    assert state.data_source_network_id_name == afloat.boat.node.name


@pytest.mark.parametrize(
    ("command", "state"),
    [
        (AlertResponseCommand.ACKNOWLEDGE, AlertState.ACKNOWLEDGED),
        (AlertResponseCommand.TEMPORARY_SILENCE, AlertState.SILENCED),
    ],
)
def test_another_device_acknowledges_and_silences_an_alert_of_ours(command: AlertResponseCommand, state: AlertState):
    afloat = Afloat()
    afloat.say(ALR(None, 7, True, False, "no fix"), "AIS", "AI")
    effects = afloat.bus(response(command, 401))
    told = [message for message in afloat.sent(effects) if isinstance(message, AlertMessage)]
    assert [message.alert_state for message in told] == [state]
    acknowledged = state is AlertState.ACKNOWLEDGED
    assert [message.acknowledge_source_network_id_name for message in told] == [NAME if acknowledged else OURS]
    assert lines(effects) == [f"IIALR,,401,A,{'A' if acknowledged else 'V'},no fix"]


def test_a_response_to_another_occurrence_another_device_or_for_a_test_does_nothing():
    afloat = Afloat()
    afloat.silent_bus()
    afloat.bus(response(AlertResponseCommand.ACKNOWLEDGE, occurrence=7))
    afloat.bus(response(AlertResponseCommand.ACKNOWLEDGE, name=NAME))
    afloat.bus(response(AlertResponseCommand.ACKNOWLEDGE, number=102))
    afloat.bus(response(AlertResponseCommand.TEST_COMMAND_ON))
    assert afloat.standing == [(101, "backbone silent", False, False)]
    assert afloat.boat.counters["responses to an earlier alert"] == 1
    assert afloat.boat.counters["alert tests"] == 1


def test_our_own_alert_that_another_gateway_sends_again_is_nobody_elses():
    afloat = Afloat()
    afloat.silent_bus()
    told = afloat.bus(alert(name=OURS, alert_id=101))
    assert [effect for effect in told if isinstance(effect, AlertChanged) and effect.alert.kind.id != 101] == []
    assert [number for number, *_ in afloat.standing] == [101]


# The standard's, of others --------------------------------------------------------------------------


def test_an_alert_of_another_device_is_said_to_the_stations_and_not_to_the_bus():
    afloat = Afloat()
    effects = afloat.bus(alert())
    assert lines(effects) == ["IIALR,,401,A,V,alert 20493"]
    assert afloat.sent(effects) == []
    assert afloat.boat.helm.alerts.standing[0].text == "another device"


def test_its_text_is_its_name_whichever_comes_first():
    after = Afloat()
    after.bus(alert())
    assert lines(after.bus(text("High bilge", alert_location_text_description="Engine room"))) == [
        "IIALR,,401,A,V,High bilge"
    ]
    before = Afloat()
    before.bus(text("High bilge", alert_location_text_description="Engine room"))
    assert lines(before.bus(alert())) == ["IIALR,,401,A,V,High bilge"]
    for afloat in (after, before):
        assert afloat.boat.helm.alerts.standing[0].text == "Engine room"


def test_of_several_languages_english_is_heard_and_else_the_first():
    afloat = Afloat()
    afloat.bus(alert())
    afloat.bus(text("Hohe Bilge", language_id=AlertLanguageId.GERMAN))
    afloat.bus(text("Lensepumpe", language_id=AlertLanguageId.DANISH))
    assert afloat.standing[0][1] == "Hohe Bilge"
    afloat.bus(text("High bilge"))
    afloat.bus(text("Hohe Bilge", language_id=AlertLanguageId.GERMAN))
    assert afloat.standing[0][1] == "High bilge"


def test_texts_are_bounded_whatever_comes():
    afloat = Afloat()
    for number in range(1000):
        afloat.bus(text("flood", alert_id=number))
    afloat.bus(text("High bilge"))
    afloat.bus(alert())
    assert afloat.standing[0][1] == "High bilge"
    assert len(afloat.boat._alerting._words._words) == 256  # type: ignore[union-attr]


def test_parts_of_sentences_are_bounded_whatever_comes():
    afloat = Afloat(foreign=True)
    for number in range(300):
        afloat.say(alf(AlertCondition.NORMAL, total=2, alarm=number), "BAM", "RA")
    assert len(afloat.boat._alerting._lists._titles) == 64  # type: ignore[union-attr]


def maretron(extension: bytes) -> MaretronAlertTransmission:
    return MaretronAlertTransmission(
        alert_type=AlertType.ALARM,
        alert_category=None,
        alert_system=None,
        alert_sub_system=None,
        alert_id=20493,
        data_source_network_id_name=NAME,
        data_source_instance=0,
        data_source_index_source=None,
        alert_occurrence_number=1,
        maretron_extension=extension.ljust(16, b"\xff"),
    )


def test_maretrons_state_in_words_is_the_text_of_an_alert_that_has_none():
    afloat = Afloat()
    afloat.bus(alert())
    afloat.bus(text("Bilge switch"))
    afloat.bus(maretron(b"\x32\x00\x09\x01Tripped"))
    standing = afloat.boat.helm.alerts.standing[0]
    assert (standing.kind.name, standing.text) == ("Bilge switch", "Tripped")
    assert afloat.bus(maretron(b"\x32\x00\x05\x01Off")) == [], "it has one"


@pytest.mark.parametrize("extension", [b"", b"\x32\x00\x02\x01", b"\x32\x00\x09\x00Tripped", b"\x32\x00\x0f\x01Trip"])
def test_maretrons_extension_without_words_says_nothing(extension: bytes):
    afloat = Afloat()
    afloat.bus(alert())
    assert afloat.bus(maretron(extension)) == []


def test_an_alert_whose_device_is_not_known_bears_the_makers_name():
    afloat = Afloat()
    claim = int.from_bytes(bytes.fromhex("085136 11006e28c0".replace(" ", "")), "little")
    afloat.bus(alert(name=claim))
    assert afloat.boat.helm.alerts.standing[0].text == "maretron"


def test_the_station_that_acknowledges_a_foreign_alert_acknowledges_it_at_its_owner():
    afloat = Afloat()
    afloat.bus(alert())
    effects = afloat.say(ACK(401))
    (answer,) = afloat.sent(effects)
    assert isinstance(answer, AlertResponse)
    assert (answer.alert_id, answer.alert_occurrence_number, answer.alert_type) == (20493, 1, AlertType.ALARM)
    assert (answer.data_source_network_id_name, answer.acknowledge_source_network_id_name) == (NAME, OURS)
    assert answer.response_command is AlertResponseCommand.ACKNOWLEDGE
    assert lines(effects) == ["IIALR,,401,A,A,alert 20493"]


def test_the_station_that_silences_a_foreign_alert_silences_it_at_its_owner_for_thirty_seconds():
    afloat = Afloat()
    afloat.bus(alert())
    (answer,) = afloat.sent(afloat.say(ACN(alarm=401, command=AlertCommand.SILENCE, status="C")))
    assert isinstance(answer, AlertResponse)
    assert answer.response_command is AlertResponseCommand.TEMPORARY_SILENCE
    afloat.bus(alert(AlertState.SILENCED))
    assert [a.silenced_until for a in afloat.boat.helm.alerts.standing] == [30.0]
    afloat.until(30.1)
    assert [a.silenced_until for a in afloat.boat.helm.alerts.standing] == [None]


def test_what_is_acknowledged_at_its_owner_is_acknowledged_everywhere():
    afloat = Afloat()
    afloat.bus(alert())
    effects = afloat.bus(alert(AlertState.ACKNOWLEDGED))
    assert lines(effects) == ["IIALR,,401,A,A,alert 20493"]
    assert afloat.sent(effects) == [], "who told it is not told it"
    assert lines(afloat.bus(alert(AlertState.NORMAL))) == ["IIALR,,401,V,A,alert 20493"]
    assert afloat.standing == []


def test_a_state_that_nobody_knows_is_no_state():
    afloat = Afloat()
    assert afloat.bus(alert(None)) == []
    assert afloat.bus(alert(AlertState(17))) == []
    assert afloat.standing == []


def test_an_alert_whose_device_tells_no_name_is_its_addresss():
    afloat = Afloat()
    afloat.bus(alert(name=0), 20)
    afloat.bus(alert(name=0), 21)
    afloat.bus(alert(name=0), 21)
    assert [number for number, *_ in afloat.standing] == [401, 402]


def test_an_alert_stays_its_devices_when_that_moves_to_another_address():
    afloat = Afloat()
    afloat.bus(alert(), 20)
    assert afloat.bus(alert(), 21) == []


def test_a_type_that_nobody_knows_is_a_warning():
    afloat = Afloat()
    afloat.bus(alert(alert_type=AlertType(3)))
    afloat.bus(alert(alert_type=None, alert_id=2))
    assert {a.kind.priority.name for a in afloat.boat.helm.alerts.standing} == {"WARNING"}


def test_foreign_alerts_are_left_out_where_their_owner_does_not_want_them():
    afloat = Afloat(foreign=False)
    assert afloat.bus(alert()) == []
    assert lines(afloat.say(ALR(None, 5, True, False, "no fix"), "AIS", "AI")) == []
    assert afloat.standing == []


def test_a_boat_whose_settings_know_of_no_alerts_hears_none_and_tells_the_bus_of_none():
    boat = Boat(BoatSettings(), PORTS, now=0.0)
    payload = alert().encode()
    frames = [Frame(join(2, 126983, 20), part) for part in fragment(payload, 0)]
    assert [type(effect) for effect in boat.receive_frames(frames, 0.0)] == [Say]
    assert not any(isinstance(effect, Transmit) for effect in boat.expire(3.0))


# Raymarine ------------------------------------------------------------------------------------------


def seatalk(
    status: SeatalkAlarmStatus | None = SeatalkAlarmStatus.ACTIVE,
    alarm: SeatalkAlarmId | None = SeatalkAlarmId.PILOT_OFF_COURSE,
    group: SeatalkAlarmGroup = SeatalkAlarmGroup.AUTOPILOT,
) -> SeatalkAlarm:
    return SeatalkAlarm(sid=None, alarm_status=status, alarm_id=alarm, alarm_group=group, alarm_priority=0)


def test_raymarines_alarm_is_silenced_at_raymarines_by_an_acknowledgement_alone():
    afloat = Afloat()
    assert lines(afloat.bus(seatalk(), 204)) == ["IIALR,,401,A,V,pilot off course"]
    assert afloat.sent(afloat.say(ACN(alarm=401, command=AlertCommand.SILENCE, status="C"))) == []
    acknowledged = afloat.say(ACK(401))
    assert afloat.sent(acknowledged) == [
        SeatalkSilenceAlarm(alarm_id=SeatalkAlarmId.PILOT_OFF_COURSE, alarm_group=SeatalkAlarmGroup.AUTOPILOT)
    ]
    assert [effect.frame.data.hex(" ") for effect in acknowledged if isinstance(effect, Transmit)] == [
        "3b 9f 14 01 ff ff ff ff"
    ]


def test_what_was_silenced_at_a_raymarine_display_is_acknowledged():
    afloat = Afloat()
    afloat.bus(seatalk(), 204)
    assert lines(afloat.bus(seatalk(SeatalkAlarmStatus.SILENCED), 204)) == ["IIALR,,401,A,A,pilot off course"]
    assert lines(afloat.bus(seatalk(SeatalkAlarmStatus.NOT_MET), 204)) == ["IIALR,,401,V,A,pilot off course"]


@pytest.mark.parametrize(
    "message",
    [
        seatalk(SeatalkAlarmStatus.NOT_MET),
        seatalk(alarm=SeatalkAlarmId.NO_ALARM),
        seatalk(alarm=None),
        seatalk(None),
        seatalk(SeatalkAlarmStatus(9)),
    ],
)
def test_raymarines_message_about_no_alarm_is_none(message: SeatalkAlarm):
    afloat = Afloat()
    assert afloat.bus(message, 204) == []


def test_the_battery_of_an_accessory_is_a_caution():
    afloat = Afloat()
    low = seatalk(alarm=SeatalkAlarmId.BLUETOOTH_DEVICE_LOW_BATTERY, group=SeatalkAlarmGroup.BLUETOOTH_ACCESSORY)
    afloat.bus(low, 204)
    assert [(a.kind.priority.name, a.acknowledged) for a in afloat.boat.helm.alerts.standing] == [("CAUTION", True)]


# Navico ---------------------------------------------------------------------------------------------


def simnet(command: SimnetAlarmCommand, alarm: SimnetAlarmId | None = SimnetAlarmId.SHALLOW_WATER) -> SimnetAlarm:
    return SimnetAlarm(address=None, command=command, alarm_id=alarm, f=3, g=0)


def navico(state: AlertState | None, severity: AlertType | None = AlertType.WARNING) -> NavicoAlarm:
    shallow = SimnetAlarmId.SHALLOW_WATER
    return NavicoAlarm(
        instance=0,
        record_id=0,
        alarm_type=0,
        alarm_id=shallow,
        alarm_state=state,
        action_flag=0,
        alarm_severity=severity,
        value=0,
    )


def test_navicos_alarm_is_the_networks_whoever_raises_it():
    afloat = Afloat()
    assert lines(afloat.bus(simnet(SimnetAlarmCommand.ACTIVATE), 15)) == ["IIALR,,401,A,V,shallow water"]
    assert afloat.bus(simnet(SimnetAlarmCommand.ACTIVATE), 21) == []
    effects = afloat.say(ACK(401))
    assert afloat.sent(effects) == [simnet(SimnetAlarmCommand.ACKNOWLEDGE)]
    assert afloat.bus(navico(AlertState.ACTIVE, None), 15) == [], "it goes on telling what holds"
    assert afloat.standing == [(401, "shallow water", True, True)]
    assert lines(afloat.bus(simnet(SimnetAlarmCommand.DEACTIVATE), 15)) == ["IIALR,,401,V,A,shallow water"]
    assert afloat.sent(afloat.until(10.0)) == [], "nobody answers, so nobody is told twice"


def test_an_acknowledgement_at_a_navico_display_reaches_the_stations():
    afloat = Afloat()
    afloat.bus(simnet(SimnetAlarmCommand.ACTIVATE), 15)
    silenced = afloat.bus(simnet(SimnetAlarmCommand.SILENCE), 16)
    assert [e.alert.silenced_until for e in silenced if isinstance(e, AlertChanged)] == [30.0]
    acknowledged = afloat.bus(simnet(SimnetAlarmCommand.ACKNOWLEDGE), 16)
    assert lines(acknowledged) == ["IIALR,,401,A,A,shallow water"]
    assert afloat.sent(silenced + acknowledged) == []


def test_navicos_state_tells_how_severe_and_its_text_says_more():
    afloat = Afloat()
    afloat.bus(SimnetAlarmMessage(alarm_id=SimnetAlarmId.SHALLOW_WATER, b=None, c=None, text="Depth 1.8 m"), 15)
    afloat.bus(navico(AlertState.ACTIVE), 15)
    (standing,) = afloat.boat.helm.alerts.standing
    assert (standing.kind.priority.name, standing.text) == ("WARNING", "Depth 1.8 m")
    afloat.bus(SimnetAlarmMessage(alarm_id=SimnetAlarmId.SHALLOW_WATER, b=None, c=None, text="Depth 1.6 m"), 15)
    assert afloat.boat.helm.alerts.standing[0].text == "Depth 1.6 m"
    (answer,) = afloat.sent(afloat.say(ACK(401)))
    assert isinstance(answer, SimnetAlarm)
    assert (answer.command, answer.alarm_id) == (SimnetAlarmCommand.ACKNOWLEDGE, SimnetAlarmId.SHALLOW_WATER)
    afloat.bus(navico(AlertState.NORMAL), 15)
    assert afloat.standing == []


def test_a_man_overboard_is_an_emergency_to_which_nobody_answers():
    afloat = Afloat()
    afloat.bus(simnet(SimnetAlarmCommand.MOB_ACTIVATED, None), 15)
    (standing,) = afloat.boat.helm.alerts.standing
    assert (standing.kind.name, standing.kind.priority.name) == ("man overboard", "EMERGENCY")
    assert afloat.sent(afloat.say(ACK(401))) == []
    afloat.bus(simnet(SimnetAlarmCommand.MOB_CANCELLED, None), 15)
    assert afloat.standing == []


@pytest.mark.parametrize(
    "message",
    [
        simnet(SimnetAlarmCommand.ALARM_HISTORY),
        simnet(SimnetAlarmCommand.ACTIVATE, None),
        navico(None),
        navico(AlertState.NORMAL),
    ],
)
def test_navicos_message_about_no_alarm_is_none(message: Message):
    afloat = Afloat()
    assert afloat.bus(message, 15) == []


# Instruments on wires -------------------------------------------------------------------------------


def test_an_instruments_alarm_is_said_under_a_number_of_its_own_and_told_to_the_bus():
    afloat = Afloat()
    effects = afloat.say(ALR(None, 7, True, False, "AIS: no fix"), "AIS", "AI")
    assert lines(effects) == ["IIALR,,401,A,V,AIS: no fix"]
    state, words = afloat.sent(effects)
    assert isinstance(state, AlertMessage)
    assert isinstance(words, AlertText)
    assert (state.alert_id, state.data_source_network_id_name) == (401, OURS)
    assert words.alert_text_description == "AIS: no fix: AIS"


def test_its_acknowledgement_goes_to_that_port_alone_under_its_own_number():
    afloat = Afloat()
    afloat.say(ALR(None, 7, True, False, "AIS: no fix"), "BAM", "AI")
    effects = afloat.bus(response(AlertResponseCommand.ACKNOWLEDGE, 401))
    assert [effect for effect in effects if isinstance(effect, SayTo)] == [SayTo(ACK(7).encode(), "ACK", "BAM")]
    assert lines(effects) == ["IIALR,,401,A,A,AIS: no fix"]
    assert afloat.say(ALR(None, 7, True, False, "AIS: no fix"), "BAM", "AI") == [], "it may not have heard"
    assert lines(afloat.say(ALR(None, 7, False, True, "AIS: no fix"), "BAM", "AI")) == ["IIALR,,401,V,A,AIS: no fix"]


def test_an_instrument_that_says_an_alarm_is_acknowledged_is_believed():
    afloat = Afloat()
    afloat.say(ALR(None, 7, True, False, "no fix"), "AIS", "AI")
    assert lines(afloat.say(ALR(None, 7, True, True, "no fix"), "AIS", "AI")) == ["IIALR,,401,A,A,no fix"]


@pytest.mark.parametrize("sentence", [ALR(text="no alarms"), ALR(None, 7, None, None, ""), ALR(None, 7, False, False)])
def test_an_alr_about_no_alarm_is_none(sentence: ALR):
    assert Afloat().say(sentence, "AIS", "AI") == []


def test_an_alarm_without_words_has_its_number_for_a_name():
    afloat = Afloat()
    afloat.say(ALR(None, 7, True, False), "AIS", "AI")
    assert afloat.standing == [(401, "alarm 7", True, False)]


def test_a_stations_wire_tells_no_alarms_of_its_own():
    afloat = Afloat()
    assert afloat.say(ALR(None, 7, True, False, "no fix"), "IN1", "AI") == []
    assert afloat.boat.counters["sentences not for us"] == 1


def alf(
    state: AlertCondition | None, number: int = 1, total: int = 1, words: str = "Lost target", **fields: object
) -> ALF:
    given: dict[str, object] = {
        "total": total,
        "number": number,
        "sequence": 3,
        "priority": AlertUrgency.WARNING if number == 1 else None,
        "state": state,
        "maker": "FUR",
        "alarm": 3048,
        "instance": 2,
        "revision": 1,
        "escalation": 0,
        "text": words,
    }
    return ALF(**given | fields)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("state", "standing"),
    [
        (AlertCondition.UNACKNOWLEDGED, [(401, "Lost target", True, False)]),
        (AlertCondition.SILENCED, [(401, "Lost target", True, False)]),
        (AlertCondition.ACKNOWLEDGED, [(401, "Lost target", True, True)]),
        (AlertCondition.TRANSFERRED, [(401, "Lost target", True, True)]),
        (AlertCondition.RECTIFIED, [(401, "Lost target", False, False)]),
        (AlertCondition.NORMAL, []),
    ],
)
def test_alf_tells_an_alert_in_every_state(state: AlertCondition, standing: list[object]):
    afloat = Afloat()
    afloat.say(alf(state), "BAM", "RA")
    assert afloat.standing == standing


def test_the_second_sentence_of_alf_describes_the_first():
    afloat = Afloat()
    afloat.say(alf(AlertCondition.UNACKNOWLEDGED, total=2), "BAM", "RA")
    effects = afloat.say(alf(None, 2, 2, "MMSI 211000000"), "BAM", "RA")
    assert [e.alert.text for e in effects if isinstance(e, AlertChanged)] == ["MMSI 211000000"]
    assert afloat.say(alf(None, 2, 2, "again"), "BAM", "RA") == []
    for _ in range(3):
        assert afloat.say(alf(AlertCondition.UNACKNOWLEDGED, total=2), "BAM", "RA") == []
        assert afloat.say(alf(None, 2, 2, "MMSI 211000000"), "BAM", "RA") == [], "told again, nothing is new"


def test_a_second_sentence_of_another_alf_describes_nothing():
    afloat = Afloat()
    afloat.say(alf(AlertCondition.UNACKNOWLEDGED, total=2), "BAM", "RA")
    assert afloat.say(alf(None, 2, 2, "other", sequence=4), "BAM", "RA") == []
    assert afloat.say(alf(None), "BAM", "RA") == []


def test_an_alf_is_acknowledged_and_silenced_by_acn_with_its_makers_number():
    afloat = Afloat()
    afloat.say(alf(AlertCondition.UNACKNOWLEDGED), "BAM", "RA")
    said = afloat.say(ACN(alarm=401, command=AlertCommand.SILENCE, status="C"))
    said += afloat.say(ACN(alarm=401, command=AlertCommand.ACKNOWLEDGE, status="C"))
    orders = [effect for effect in said if isinstance(effect, SayTo)]
    wanted = [ACN(None, "FUR", 3048, 2, order, "C") for order in (AlertCommand.SILENCE, AlertCommand.ACKNOWLEDGE)]
    assert orders == [SayTo(command.encode(), "ACN", "BAM") for command in wanted]


def test_what_is_not_in_an_instruments_list_any_more_is_over():
    afloat = Afloat()
    afloat.say(alf(AlertCondition.ACKNOWLEDGED), "BAM", "RA")
    afloat.say(alf(AlertCondition.ACKNOWLEDGED, alarm=3050), "BAM", "RA")
    afloat.say(ALR(None, 9, True, True, "plain"), "BAM", "RA")
    afloat.say(alf(AlertCondition.ACKNOWLEDGED), "AIS", "AI")
    first, second = Listed("FUR", 3048, 2, 1), Listed("FUR", 3099, 2, 1)
    assert afloat.say(ALC(2, 1, 5, (first,)), "BAM", "RA") == []
    gone = afloat.say(ALC(2, 2, 5, (second,)), "BAM", "RA")
    assert [e.alert.kind.id for e in gone if isinstance(e, AlertChanged)] == [402]


def test_a_list_that_misses_a_part_ends_nothing():
    afloat = Afloat()
    afloat.say(alf(AlertCondition.ACKNOWLEDGED), "BAM", "RA")
    assert afloat.say(ALC(2, 2, 5), "BAM", "RA") == []
    afloat.say(ALC(3, 1, 5), "BAM", "RA")
    assert afloat.say(ALC(3, 3, 5), "BAM", "RA") == []
    afloat.say(ALC(2, 1, 6), "BAM", "RA")
    assert afloat.say(ALC(2, 2, 7), "BAM", "RA") == []
    assert [number for number, *_ in afloat.standing] == [401]


def test_broken_sentences_about_alerts_are_rejected():
    afloat = Afloat()
    effects = afloat.boat.receive_bytes("AIS", seal("AIALR,,x,A,V,broken"), 0.0)
    assert [type(effect) for effect in effects] == [Rejected]
    assert afloat.standing == []


# What stations command ------------------------------------------------------------------------------


@pytest.mark.parametrize("sentence", [b"$IIACK,*4A", b"$IIACK,101*00", b"$IIACN,,,101,,,C*3F", b"$IIACN,,,,,A,C*4F"])
def test_a_command_that_is_none_is_rejected(sentence: bytes):
    effects = Afloat().boat.receive_bytes("IN1", sentence + b"\r\n", 0.0)
    assert [type(effect) for effect in effects] == [Rejected]


@pytest.mark.parametrize(
    "command",
    [
        ACN(alarm=199, command=AlertCommand.ACKNOWLEDGE, status="C"),
        ACN(maker="FUR", alarm=101, command=AlertCommand.ACKNOWLEDGE, status="C"),
        ACN(alarm=199, command=AlertCommand.REPEAT, status="C"),
    ],
)
def test_a_command_about_no_alert_of_ours_is_refused(command: ACN):
    afloat = Afloat()
    afloat.silent_bus()
    effects = afloat.say(command)
    assert [line[:5] for line in lines(effects)] == ["IIARC"]
    assert afloat.standing == [(101, "backbone silent", True, False)]


def test_a_command_that_changes_nothing_is_refused_and_a_plain_acknowledgement_is_not_answered():
    afloat = Afloat()
    afloat.silent_bus()
    afloat.say(ACK(101))
    again = ACN(maker="ARP", alarm=101, command=AlertCommand.ACKNOWLEDGE, status="C")
    assert lines(afloat.say(again)) == ["IIARC,,ARP,101,,A"]
    assert afloat.say(ACK(101)) == afloat.say(ACK(199)) == []


def test_who_asks_hears_an_alert_once_more():
    afloat = Afloat(sentences="both")
    afloat.silent_bus()
    said = lines(afloat.say(ACN(alarm=101, command=AlertCommand.REPEAT, status="C")))
    assert [line[2:5] for line in said] == ["ALR", "ALF", "ALF"]


def test_commands_about_alerts_are_bounded_as_all_commands_are():
    afloat = Afloat()
    afloat.silent_bus()
    asked = [afloat.say(ACN(alarm=101, command=AlertCommand.REPEAT, status="C")) for _ in range(100)]
    assert len([effects for effects in asked if lines(effects)]) == 20
    assert [type(effect) for effects in asked[20:] for effect in effects] == [Rejected]
    afloat.now += 1.1
    assert lines(afloat.say(ACN(alarm=101, command=AlertCommand.REPEAT, status="C"))) != []


def test_who_takes_responsibility_makes_an_alert_quiet():
    afloat = Afloat(sentences="alf")
    afloat.silent_bus()
    effects = afloat.say(ACN(alarm=101, command=AlertCommand.TAKE_RESPONSIBILITY, status="C"))
    assert lines(effects)[0].startswith("IIALF,2,1,2,,B,A,O,ARP,101,1,2,0,")
    assert afloat.states(effects) == [AlertState.ACKNOWLEDGED]


# What stations hear ---------------------------------------------------------------------------------


def test_alf_tells_priority_state_and_text_of_every_change():
    afloat = Afloat(sentences="alf")
    assert lines(afloat.silent_bus()) == [
        "IIALF,2,1,1,,B,A,V,ARP,101,1,1,0,backbone silent",
        "IIALF,2,2,1,,,,,ARP,101,1,1,0,nothing heard from the backbone for 3 s",
    ]
    assert [line[:28] for line in lines(afloat.bus(heading()))] == [
        "IIALF,2,1,2,,B,A,U,ARP,101,1",
        "IIALF,2,2,2,,,,,ARP,101,1,2,",
    ]
    assert lines(afloat.say(ACK(101)))[0].startswith("IIALF,2,1,3,,B,A,N,ARP,101,1,3,0,")


def test_the_list_and_a_sign_of_life_come_every_thirty_seconds_with_alf():
    afloat = Afloat(sentences="alf")
    afloat.bus(alert(AlertState.ACKNOWLEDGED))
    assert lines(afloat.until(30.0)) == ["IIALC,01,01,01,1,ARP,401,1,1", "IIHBT,30,A,1"]
    afloat.bus(alert(AlertState.NORMAL))
    assert lines(afloat.until(61.0)) == ["IIALC,01,01,02,0", "IIHBT,30,A,2"]


def test_the_list_waits_for_its_time_while_the_bus_is_told_every_second():
    afloat = Afloat(sentences="alf", alarm_repeat=0)
    afloat.say(ALR(None, 7, True, False, "no fix"), "AIS", "AI")
    assert lines(afloat.until(29.0)) == []


def test_what_is_about_no_alert_does_nothing():
    alerting = Afloat().boat._alerting
    assert alerting is not None
    assert alerting.hear(heading(), 20, 0.0) == []
    assert alerting.command(ACK(), 0.0, None) == Done()


def test_alr_of_what_stands_comes_every_thirty_seconds():
    afloat = Afloat(alarm_repeat=0)
    afloat.bus(alert(AlertState.ACKNOWLEDGED))
    afloat.until(29.0)
    afloat.bus(alert(AlertState.ACKNOWLEDGED))
    assert lines(afloat.until(31.0)) == ["IIALR,,401,A,A,alert 20493"]


def test_a_port_that_comes_back_hears_all_that_stands():
    afloat = Afloat()
    afloat.silent_bus()
    afloat.bus(alert())
    effects = afloat.boat.port_changed("IN1", True, afloat.now)
    assert lines(effects) == ["IIALR,,101,V,V,backbone silent", "IIALR,,401,A,V,alert 20493"]
    assert lines(afloat.boat.port_changed("IN1", False, afloat.now)) == []


def test_words_that_no_sentence_carries_are_said_as_near_as_can_be():
    afloat = Afloat()
    afloat.bus(text("Wysoki poziom wody, zęza *!" + "x" * 60))
    effects = afloat.bus(alert())
    assert lines(effects) == ["IIALR,,401,A,V,Wysoki poziom wody  zeza   xxxxxxxxxxxxxxxxxxxxx"]
    assert afloat.standing[0][1].startswith("Wysoki poziom wody, zęza *!x")


# Escalation -----------------------------------------------------------------------------------------


def test_an_alarm_that_nobody_acknowledges_is_announced_again_after_thirty_seconds():
    afloat = Afloat()
    afloat.bus(seatalk(), 204)
    effects = afloat.until(29.0)
    assert not any(isinstance(effect, AlertChanged) for effect in effects)
    afloat.bus(seatalk(), 204)
    announced = [effect.alert.announced for effect in afloat.until(31.0) if isinstance(effect, AlertChanged)]
    assert announced == [1]


def test_the_bus_hears_that_an_alert_of_ours_was_escalated():
    afloat = Afloat()
    afloat.say(ALR(None, 7, True, False, "no fix"), "AIS", "AI")
    effects = afloat.until(30.0)
    told = [message.escalation_status for message in afloat.sent(effects) if isinstance(message, AlertMessage)]
    assert told[-1] is YesNoBit.YES
    assert told[0] is YesNoBit.NO


def test_a_warning_becomes_an_alarm_where_its_owner_wants_it():
    afloat = Afloat(warning_escalation=20.0)
    afloat.bus(alert(alert_type=AlertType.WARNING))
    afloat.until(21.0)
    assert [a.kind.priority.name for a in afloat.boat.helm.alerts.standing] == ["ALARM"]


# Loops ----------------------------------------------------------------------------------------------


def test_what_an_instrument_says_after_us_is_no_alert_of_its_own():
    afloat = Afloat()
    afloat.silent_bus()
    afloat.bus(alert())
    for sentence in (ALR(None, 101, True, False, "backbone silent"), ALR(None, 433, True, False, "alert 20493")):
        assert afloat.say(sentence, "AIS", "II") == []
    assert afloat.boat.counters["alerts that came back"] == 2
    assert lines(afloat.say(ALR(None, 5, True, False, "backbone silent"), "AIS", "AI")) != [], "another device's"


def test_two_gateways_on_one_bus_and_one_wire_do_not_feed_each_other():
    """Each hears the other on the bus, and all that the other says on an instrument's port."""
    one, two = Afloat(), Afloat()
    two.boat._sender.address = 0x24
    said = [*one.say(ALR(None, 7, True, False, "no fix"), "AIS", "AI"), *one.silent_bus(3.0)]
    two.now = 3.0
    total = 0
    for _ in range(50):
        for there in (two, one):
            answers: list[Effect] = []
            for effect in said:
                if isinstance(effect, Transmit):
                    answers += there.boat.receive_frames([effect.frame], there.now)
                elif isinstance(effect, Say):
                    answers += there.boat.receive_bytes("BAM", effect.line, there.now)
            said = answers
            total += len(answers)
        if not said:
            break
    assert said == []
    assert total < 60
    assert {name for _, name, *_ in one.standing} == {"no fix", "backbone silent"}
    assert {name for _, name, *_ in two.standing} == {"no fix", "backbone silent"}
    assert len(one.standing) == len(two.standing) == 2


# Replay ---------------------------------------------------------------------------------------------


def test_the_same_inputs_give_the_same_answers_from_settings_that_were_written_down():
    settings = BoatSettings(alerts=AlertSettings(sentences="both", warning_escalation=5.0))
    copy = msgspec.json.decode(msgspec.json.encode(settings), type=BoatSettings)
    runs = []
    for given in (settings, copy):
        afloat = Afloat()
        afloat.boat = Boat(given, PORTS, now=0.0)
        effects = afloat.bus(alert()) + afloat.bus(seatalk(), 204) + afloat.silent_bus()
        effects += afloat.say(ALR(None, 7, True, False, "no fix"), "AIS", "AI") + afloat.say(ACK(401))
        effects += afloat.until(70.0)
        runs.append(effects)
    assert runs[0] == runs[1]
    assert len(runs[0]) > 100
