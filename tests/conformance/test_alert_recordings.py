"""Alerts of real devices, as they were recorded, through the boat's table; and the bytes that answer them.

No recording has somebody acknowledge a Navico alarm or one of the standard, so those answers are held against the
layout of what they answer. Raymarine's is the one that the Signal K project's autopilot sends.
"""

import pytest

from tests.conformance.recorded import messages
from tests.recordings import ROOT
from timonel.core.alerts import AlertChanged
from timonel.core.effects import Effect, Say, Transmit
from timonel.core.frame import Frame
from timonel.nmea0183.sentences import ACK
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join, split
from timonel.nmea2000.messages.alerts import Alert, AlertResponse
from timonel.nmea2000.messages.maretron import MaretronAlertTransmission
from timonel.vehicles.boat.alert_settings import AlertSettings
from timonel.vehicles.boat.foreign_alerts import FIRST
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

PORTS = [Port("IN1", 1)]
SAMPLES = "canboat_canboat/samples/"


def boat(now=0.0):
    return Boat(BoatSettings(alerts=AlertSettings(tell_bus=False)), PORTS, now)


def hear(there: Boat, payload: bytes, pgn: int, source: int, now: float = 0.0) -> list[Effect]:
    parts = fragment(payload, 0) if registry.is_fast(pgn) else [payload]
    return there.receive_frames([Frame(join(2, pgn, source), part) for part in parts], now)


def said(effects):
    return [effect.line.decode()[1:-5] for effect in effects if isinstance(effect, Say) and effect.key == "ALR"]


def sent(effects):
    return [(split(e.frame.identifier).pgn, e.frame.data.hex(" ")) for e in effects if isinstance(e, Transmit)]


def play(name):
    """A whole recording at its own times; what happens, and what the table says of it."""
    there, effects = boat(), []
    for message in messages(ROOT / SAMPLES / name):
        effects += there.receive_message(message.identifier, message.payload, message.now)
    return there, effects


def test_the_alarm_of_a_raymarine_pilot_without_its_control_unit_comes_and_goes():
    """29 times active, 3 times not met: to people it is one alarm."""
    _, effects = play("raymarine-ev1.raw")
    assert said(effects) == ["IIALR,,401,A,V,pilot cu disconnected", "IIALR,,401,V,V,pilot cu disconnected"]


def test_its_acknowledgement_is_the_message_that_raymarines_displays_send():
    there = boat()
    hear(there, bytes.fromhex("3b9fff011b010000"), 65288, 204)
    acknowledged = there.receive_bytes("IN1", ACK(401).encode(), 1.0)
    assert sent(acknowledged) == [(65361, "3b 9f 1b 01 ff ff ff ff")]
    assert said(hear(there, bytes.fromhex("3b9fff001b010000"), 65288, 204, 2.0)) == [
        "IIALR,,401,V,A,pilot cu disconnected"
    ]


@pytest.mark.parametrize(
    "name",
    [
        "can0-2.pcap",
        "mercury-proprietary.raw",
        "maretron-alm100-alert.raw",
        "maretron-alm100-sounding.raw",
        "maretron-alm100-command.raw",
        "maretron-alm100-capabilities.raw",
        "sample-single.raw.txt",
        "scx20-setting-tool-offsets.raw",
        "simnet-tp32.raw",
        "simrad_130850.raw",
        "simrad_event_timer_start.raw",
        "susteranna2020.raw",
    ],
)
def test_messages_of_other_makers_and_purposes_under_the_same_numbers_raise_nothing(name):
    _, effects = play(name)
    changed = [effect.alert.kind for effect in effects if isinstance(effect, AlertChanged)]
    assert not [kind for kind in changed if kind.id >= FIRST]


def test_the_alarms_of_an_engine_on_a_navico_network_are_three():
    _, effects = play("can0-3.pcap")
    assert [line.split(",")[2:] for line in said(effects)[:3]] == [
        ["401", "A", "V", "engine water in fuel"],
        ["402", "A", "V", "engine low coolant level"],
        ["403", "A", "V", "engine low oil level"],
    ]


# Payloads that canboat's database holds as samples: merrimac-2022, nac3-operations and ac42-commissioning.
ENGINE_WATER = "41 9f ff ff 01 ff 39 00 44 00 03 00"
HEADING_BACK = "41 9f ff ff 01 ff 38 00 16 00 01 00"
COMMAND_97 = "41 9f ff ff 64 ff 61 00 ff ff ff ff"


def test_a_navico_alarm_is_answered_in_its_own_group_with_the_acknowledgement_in_the_commands_place():
    there = boat()
    raised = hear(there, bytes.fromhex(ENGINE_WATER), 130850, 15)
    assert said(raised) == ["IIALR,,401,A,V,engine water flow"]
    acknowledged = there.receive_bytes("IN1", ACK(401).encode(), 1.0)
    assert sent(acknowledged) == [
        (130850, "00 0c 41 9f ff ff 01 ff"),
        (130850, "01 3a 00 44 00 03 00 ff"),
    ]


@pytest.mark.parametrize("payload", [HEADING_BACK, COMMAND_97])
def test_navico_commands_that_raise_nothing_raise_nothing(payload):
    there = boat()
    assert said(hear(there, bytes.fromhex(payload), 130850, 50)) == []
    assert there.helm.alerts.standing == []


def test_a_navico_alarm_ends_as_the_recorded_one_did():
    there = boat()
    hear(there, bytes.fromhex(HEADING_BACK.replace("ff 38", "ff 39")), 130850, 50)
    assert said(hear(there, bytes.fromhex(HEADING_BACK), 130850, 50, 1.0)) == ["IIALR,,401,V,V,heading missing"]


def test_an_alert_of_the_standard_is_known_by_what_maretron_sends_beside_it():
    (recorded,) = messages(ROOT / SAMPLES / "maretron-alm100-alert.raw")
    beside = MaretronAlertTransmission.decode(recorded.payload)
    identity = recorded.payload[2:18]
    there = boat()
    hear(there, recorded.payload, 130819, 128)
    active = identity + bytes.fromhex("10 ff ff ff ff ff ff ff ff 11 ff 02")
    assert said(hear(there, active, 126983, 128)) == [f"IIALR,,401,A,V,alert {beside.alert_id}"]
    (standing,) = there.helm.alerts.standing
    assert (standing.kind.priority.name, standing.text) == ("EMERGENCY", "Tripped")
    answer = there.receive_bytes("IN1", ACK(401).encode(), 1.0)
    pgns = {pgn for pgn, _ in sent(answer)}
    assert pgns == {126984}
    payload = b"".join(effect.frame.data[1:] for effect in answer if isinstance(effect, Transmit))[1:26]
    assert payload == identity + b"\xff" * 8 + b"\xfc", "the alert's own identity, no NAME of ours yet, acknowledge"
    assert AlertResponse.decode(payload).alert_occurrence_number == Alert.decode(active).alert_occurrence_number
    acknowledged = identity + bytes.fromhex("12 ff ff ff ff ff ff ff ff 11 ff 04")
    assert said(hear(there, acknowledged, 126983, 128, 2.0)) == []
    assert not sent(there.expire(4.0)), "its owner has shown that it heard"
