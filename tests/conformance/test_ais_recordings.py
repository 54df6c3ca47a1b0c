"""AIS of real receivers: against an independent decoder (pyais), canboat's n2kd, and through the PGNs and back."""

import gzip
import json
from collections import Counter, defaultdict, deque
from collections.abc import Iterator
from math import degrees
from typing import Any

import pytest
from pyais.messages import NMEASentenceFactory

from tests.recordings import recording
from timonel.core.message import Message
from timonel.nmea0183.vdm import AisRadio, VdmReader, VdmWriter
from timonel.nmea2000 import registry
from timonel.nmea2000.messages.ais import AisClassAPositionReport
from timonel.vehicles.boat import ais
from timonel.vehicles.boat.ais_layout import LAYOUTS
from timonel.vehicles.boat.conversion import KNOT

RECEIVERS = {
    "ntpsec_gpsd/test/daemon/ais-nmea.log": 100,
    "SignalK_signalk-server/samples/nais300-merrimac.log": 500,
    "SignalK_signalk-server/samples/nais400-merrimac.log": 600,
    "wellenvogel_avnav/test/nmea-20130630-3wind.log": 15_000,
}
"""Recordings, and how many messages are in them at least."""
BACKBONE = "SignalK_signalk-server/samples/aava-n2k.data"
TODAY = 16_000  # days since 1970; recordings of AIS alone have no date


def received(name: str) -> Iterator[tuple[AisRadio, list[bytes]]]:
    """The messages of a recording, each with the sentences that it came in."""
    reader, parts = VdmReader(), dict[bytes, list[bytes]]()
    for number, line in enumerate(recording(name).read_bytes().splitlines()):
        start = line.find(b"!")
        if start < 0 or line[start + 3 : start + 6] not in (b"VDM", b"VDO"):
            continue
        sentence = line[start : line.find(b"*") + 3]
        group = sentence.split(b",")[3]
        parts.setdefault(group, []).append(sentence)
        if isinstance(message := reader.receive(sentence, number / 100), AisRadio):
            yield message, parts.pop(group)


def theirs(sentences: list[bytes]) -> Any:
    messages = [NMEASentenceFactory.produce(sentence) for sentence in sentences]
    whole = messages[0] if len(messages) == 1 else type(messages[0]).assemble_from_iterable(messages)
    return whole.decode()


COMPARED = {
    "longitude": ("lon", 1.0, 181),
    "latitude": ("lat", 1.0, 91),
    "sog": ("speed", KNOT, 102.3),
    "cog": ("course", None, 360),
    "heading": ("heading", None, 511),
    "true_heading": ("heading", None, 511),
    "draft": ("draught", 1.0, 0),
    "imo_number": ("imo", 1, 0),
    "name": ("shipname", 1, ""),
    "callsign": ("callsign", 1, ""),
    "destination": ("destination", 1, ""),
    "type_of_ship": ("ship_type", 1, None),
    "nav_status": ("status", 1, 15),
    "time_stamp": ("second", 1, None),
    "communication_state": ("radio", 1, None),
    "altitude": ("alt", 1.0, 4095),
    "aton_type": ("aid_type", 1, None),
    "position_accuracy": ("accuracy", 1, None),
    "raim": ("raim", 1, None),
}
"""Our field, theirs, what theirs is multiplied with (None: they are degrees), and what says not available there."""


def compare(ours: Message, other: Any) -> int:
    """How many fields were compared."""
    compared = 0
    for name, (their_name, unit, missing) in COMPARED.items():
        if not hasattr(ours, name) or not hasattr(other, their_name):
            continue
        mine, told = getattr(ours, name), getattr(other, their_name)
        compared += 1
        if name == "type_of_ship" and mine is not None and mine.name.startswith("UNKNOWN"):
            continue  # pyais tells such a number as the group that it is in
        if name == "communication_state" and other.msg_type == 18:
            told &= 0x7FFFF  # its first bit tells the kind
        if isinstance(told, str):
            assert (mine or "").strip() == told.partition("@")[0].strip(), name
        elif mine is None:
            assert told == missing or told > (missing or 0), name
        elif unit is None:
            assert abs(degrees(mine) - told) < 1e-6, name
        else:
            assert abs(mine - told * unit) < 1e-6, name
    return compared


@pytest.mark.parametrize("name", RECEIVERS)
def test_every_message_of_a_receiver_is_read_as_by_an_independent_decoder(name: str) -> None:
    read: Counter[int] = Counter()
    for radio, sentences in received(name):
        message = ais.read(radio, TODAY)
        if message is None:
            continue
        other = theirs(sentences)
        assert (int(other.mmsi), other.msg_type) == (mmsi_of(message), radio.kind)
        assert compare(message, other) > 0 or radio.kind in (14, 24)
        read[radio.kind] += 1
    assert read.total() > RECEIVERS[name]


def mmsi_of(message: Any) -> int:
    return int(message.user_id if hasattr(message, "user_id") else message.source_id)


def backbone() -> Iterator[Message]:
    """Every AIS message of a recorded bus."""
    with gzip.open(recording(f"{BACKBONE}.canboat.jsonl.gz"), "rt") as stream:
        for line in stream:
            found = json.loads(line)
            if "version" in found:
                continue
            (item,) = found.values()
            message = registry.decode(item["pgn"], bytes.fromhex(item["data"]))
            if type(message) in LAYOUTS:
                assert message is not None
                yield message


def test_what_a_bus_tells_of_ships_is_read_again_by_an_independent_decoder() -> None:
    writer, read = VdmWriter(), Counter[str]()
    for message in backbone():
        radio = ais.write(message)
        assert radio is not None
        other = theirs([line.rstrip() for line in writer.sentences(radio)])
        assert int(other.mmsi) == mmsi_of(message)
        again = ais.read(radio, TODAY)
        assert again is not None
        assert compare(again, other) > 0 or radio.kind == 24
        read[type(message).__name__] += 1
    assert len(read) == 7
    assert read.total() > 3_400


def test_position_reports_are_n2kds_bit_for_bit() -> None:
    """Its other messages leave out what ours carry: date and time of base stations and arrivals, the state of marks."""
    others: dict[int, deque[AisRadio]] = defaultdict(deque)
    reader = VdmReader()
    with gzip.open(recording(f"{BACKBONE}.n2kd.nmea.gz")) as stream:
        for number, line in enumerate(stream):
            if line.startswith(b"!") and isinstance(radio := reader.receive(line.strip(), number / 100), AisRadio):
                others[radio.bits >> radio.length - 38].append(radio)
    equal = 0
    for message in backbone():
        ours = ais.write(message)
        assert ours is not None
        if ours.kind in (1, 3, 18):
            other = others[ours.bits >> ours.length - 38].popleft()
            assert (ours.bits, ours.length, ours.own) == (other.bits, other.length, other.own)
            assert ours.own or ours.channel == other.channel
            equal += 1
    assert equal == 2_867


LOST = {
    "rate of turn": lambda radio: radio.kind in (1, 2, 3) and (radio.bits >> 118 & 0xFF) in (1, 0xFF),
    "spare bits": lambda radio: radio.kind in (1, 2, 3) and radio.bits >> 20 & 7,
    "padding of texts": lambda radio: radio.kind in (5, 21, 24),
}
"""What a PGN has no room for."""


@pytest.mark.parametrize("name", RECEIVERS)
def test_through_a_pgn_and_back_no_bit_is_lost_but_those_that_it_has_no_room_for(name: str) -> None:
    same = 0
    for radio, _ in received(name):
        message = ais.read(radio, TODAY)
        if message is None:
            continue
        carried = type(message).decode(message.encode())
        back = ais.write(carried)
        assert back is not None
        if (back.bits, back.length) == (radio.bits, radio.length):
            same += 1
            continue
        assert any(lost(radio) for lost in LOST.values()), (radio.kind, format(radio.bits ^ back.bits, "b"))
        again = ais.read(back, TODAY)
        assert again is not None
        left, right = carried.encode(), again.encode()
        if isinstance(message, AisClassAPositionReport):
            left, right = (type(message).decode(payload[:21]).encode() for payload in (left, right))  # up to the turn
        assert left == right
    assert same > 0.9 * RECEIVERS[name]
