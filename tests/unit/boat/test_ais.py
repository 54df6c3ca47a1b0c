import random
from collections import Counter
from datetime import date
from math import degrees, radians
from typing import Any

import pytest

from timonel.core.effects import Say, Transmit
from timonel.core.message import Message
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.vdm import AisRadio, VdmReader, VdmWriter
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.lookups import AisTransceiver, NavStatus, ShipType
from timonel.nmea2000.messages.ais import (
    AisAidsToNavigationAtonReport,
    AisClassAPositionReport,
    AisClassAStaticAndVoyageRelatedData,
    AisClassBStaticDataMsg24PartB,
    AisSafetyRelatedBroadcastMessage,
    AisSarAircraftPositionReport,
    AisUtcAndDateReport,
)
from timonel.nmea2000.messages.steering import RateOfTurn
from timonel.nmea2000.sender import Sender, outgoing
from timonel.vehicles.boat import ais
from timonel.vehicles.boat.ais import ECHO, KNOWN, MOST_SAID, NOT_WHOLE, Ais
from timonel.vehicles.boat.ais_layout import DIMENSIONS, LAYOUTS, POSITION
from timonel.vehicles.boat.conversion import KNOT
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

EPOCH = date(1970, 1, 1)
ZEROS = {
    "position_accuracy": 0, "raim": 0, "special_maneuver_indicator": 0, "communication_state": 0, "time_stamp": 0,
}  # fmt: skip


def day(year: int, month: int, of_month: int) -> int:
    return (date(year, month, of_month) - EPOCH).days


def there_and_back(kind: type[Message], **values: Any) -> Any:
    """A message as it comes back from its VDM."""
    radio = ais.write(kind(**values))
    assert radio is not None
    return ais.read(radio, day(2026, 11, 22))


def ship(**values: Any) -> dict[str, Any]:
    return {"message_id": 1, "repeat_indicator": 0, "user_id": 224_123_456} | values


def test_a_layout_has_the_bits_that_the_recommendation_gives_its_message() -> None:
    sizes = {kind.__name__: sum(row.bits for row in rows) for kind, rows in LAYOUTS.items()}
    assert sizes == {
        "AisClassAPositionReport": 168,
        "AisUtcAndDateReport": 168,
        "AisClassAStaticAndVoyageRelatedData": 424,
        "AisSarAircraftPositionReport": 168,
        "AisClassBPositionReport": 168,
        "AisClassBExtendedPositionReport": 312,
        "AisAidsToNavigationAtonReport": 272,
        "AisSafetyRelatedBroadcastMessage": 40,
        "AisClassBStaticDataMsg24PartA": 160,
        "AisClassBStaticDataMsg24PartB": 168,
    }


def test_nothing_known_is_nothing_known_there_and_back() -> None:
    back = there_and_back(AisClassAPositionReport, **ship())
    assert (back.longitude, back.latitude, back.cog, back.sog, back.heading) == (None,) * 5
    assert (back.rate_of_turn, back.nav_status) == (None, None)


def test_a_ships_position_and_way_come_back() -> None:
    back = there_and_back(
        AisClassAPositionReport,
        **ship(
            longitude=-2.63, latitude=39.55, sog=12.3 * KNOT, cog=radians(359.9), heading=radians(358),
            nav_status=NavStatus.UNDER_WAY_SAILING, rate_of_turn=-radians(10 / 60),
        ),
    )  # fmt: skip
    assert (back.longitude, back.latitude) == pytest.approx((-2.63, 39.55), abs=1e-6)
    assert (back.sog / KNOT, degrees(back.cog), degrees(back.heading)) == pytest.approx((12.3, 359.9, 358))
    assert degrees(back.rate_of_turn) * 60 == pytest.approx(-10, abs=0.2)
    assert back.nav_status is NavStatus.UNDER_WAY_SAILING


def test_a_course_just_below_north_is_north_and_not_360() -> None:
    back = there_and_back(AisClassAPositionReport, **ship(cog=radians(359.98), heading=radians(359.7)))
    assert (back.cog, back.heading) == (0, 0)


@pytest.mark.parametrize("steps", [0, 2, -2, 126, 127, -127, -128])
def test_a_rate_of_turn_keeps_its_step(steps: int) -> None:
    row = next(row for row in POSITION if row.names == ("rate_of_turn",))
    (value,) = row.read(steps & 0xFF, None)
    carried = AisClassAPositionReport.decode(AisClassAPositionReport(**ship(rate_of_turn=value, **ZEROS)).encode())
    assert row.write(carried.rate_of_turn) == steps & 0xFF


@pytest.mark.parametrize(
    ("raw", "size"),
    [
        (0, (None, None, None, None)),
        (30 << 21 | 70 << 12 | 4 << 6 | 6, (100.0, 10.0, 6.0, 30.0)),
        (0 << 21 | 70 << 12 | 0 << 6 | 6, (70.0, 6.0, None, None)),
        (0 << 21 | 70 << 12 | 3 << 6 | 6, (70.0, 9.0, 6.0, 0.0)),
    ],
)
def test_the_size_of_a_ship_and_where_its_antenna_is(raw: int, size: tuple[float | None, ...]) -> None:
    assert DIMENSIONS.read(raw, None) == size
    assert DIMENSIONS.write(*size) == raw


@pytest.mark.parametrize(
    ("today", "eta", "meant"),
    [
        (day(2026, 11, 22), (11, 30), day(2026, 11, 30)),
        (day(2026, 12, 20), (1, 3), day(2027, 1, 3)),
        (day(2027, 1, 5), (12, 28), day(2026, 12, 28)),
        (day(2026, 11, 22), (0, 0), None),
        (day(2026, 11, 22), (2, 30), None),
    ],
)
def test_the_year_of_an_arrival_is_the_one_that_makes_it_nearest(
    today: int, eta: tuple[int, int], meant: int | None
) -> None:
    message = AisClassAStaticAndVoyageRelatedData(**ship(message_id=5, eta_date=day(2024, 2, 1), eta_time=3600.0))
    radio = ais.write(message)
    assert radio is not None
    at = 424 - 274 - 20
    bits = radio.bits & ~(0x1FF << at + 11) | (eta[0] << 5 | eta[1]) << at + 11
    back = ais.read(AisRadio(bits, 424, "A"), today)
    assert isinstance(back, AisClassAStaticAndVoyageRelatedData)
    assert (back.eta_date, back.eta_time) == (meant, 3600.0)


def test_without_a_clock_an_arrival_has_a_time_and_no_date() -> None:
    message = AisClassAStaticAndVoyageRelatedData(**ship(message_id=5, eta_date=day(2026, 12, 1), eta_time=60.0))
    radio = ais.write(message)
    assert radio is not None
    back = ais.read(radio)
    assert isinstance(back, AisClassAStaticAndVoyageRelatedData)
    assert (back.eta_date, back.eta_time) == (None, 60.0)


def test_the_clock_of_a_base_station_comes_back() -> None:
    back = there_and_back(
        AisUtcAndDateReport, **ship(message_id=4, position_date=day(2026, 2, 28), position_time=86399.0)
    )
    assert (back.position_date, back.position_time) == (day(2026, 2, 28), 86399.0)
    unknown = there_and_back(AisUtcAndDateReport, **ship(message_id=11))
    assert (unknown.position_date, unknown.position_time) == (None, None)


def test_names_sizes_and_draught_of_a_voyage_come_back() -> None:
    values = {
        "imo_number": 9301122, "callsign": "EA7XYZ", "name": "SANTA MARIA", "type_of_ship": ShipType.SAILING,
        "length": 29.0, "beam": 8.0, "position_reference_from_starboard": 3.0, "position_reference_from_bow": 10.0,
        "draft": 2.1, "destination": "PALOS",
    }  # fmt: skip
    back = there_and_back(AisClassAStaticAndVoyageRelatedData, **ship(message_id=5, **values))
    assert {name: getattr(back, name) for name in values} == pytest.approx(values)


def test_the_name_of_a_mark_goes_on_behind_its_message() -> None:
    name = "BAJO DE LA MORA CARDINAL NORTE"
    back = there_and_back(AisAidsToNavigationAtonReport, **ship(message_id=21, aton_name=name))
    assert back.aton_name == name


def test_a_warning_keeps_its_words() -> None:
    values = {"message_id": 14, "repeat_indicator": 0, "source_id": 224_123_456, "safety_related_text": "MAN OVERBOARD"}
    assert there_and_back(AisSafetyRelatedBroadcastMessage, **values).safety_related_text == "MAN OVERBOARD"


def test_an_aircraft_is_as_high_and_fast_as_its_message_can_say() -> None:
    back = there_and_back(AisSarAircraftPositionReport, **ship(message_id=9, altitude=9000.0, sog=700.0))
    assert (back.altitude, back.sog / KNOT) == (4094.0, pytest.approx(1022))


def test_a_tender_tells_its_mother_ship_instead_of_its_size() -> None:
    values = ship(message_id=24, user_id=982_241_234, mothership_user_id=224_123_456, length=3.0)
    back = there_and_back(AisClassBStaticDataMsg24PartB, **values)
    assert (back.mothership_user_id, back.length) == (224_123_456, None)


@pytest.mark.parametrize(
    "message",
    [
        AisClassAPositionReport(**ship(message_id=18)),
        AisClassAPositionReport(**ship(message_id=None)),
        AisClassAPositionReport(**ship(user_id=0)),
        AisClassAPositionReport(**ship(user_id=0xFFFFFFFF)),
        RateOfTurn(),
    ],
)
def test_what_is_no_ships_message_has_no_sentence(message: Message) -> None:
    assert ais.write(message) is None


@pytest.mark.parametrize(
    "radio",
    [
        AisRadio(1 << 161, 167, "A"),
        AisRadio(6 << 162, 168, "A"),
        AisRadio(0, 3, "A"),
        AisRadio(24 << 30, 36, "A"),
        AisRadio(24 << 162 | 3 << 128, 168, "A"),
    ],
)
def test_what_is_cut_off_or_has_no_pgn_is_no_message(radio: AisRadio) -> None:
    assert ais.read(radio) is None


@pytest.mark.parametrize(
    ("channel", "own", "told"),
    [
        ("A", False, AisTransceiver.CHANNEL_A_VDL_RECEPTION),
        ("B", False, AisTransceiver.CHANNEL_B_VDL_RECEPTION),
        ("A", True, AisTransceiver.CHANNEL_A_VDL_TRANSMISSION),
        ("B", True, AisTransceiver.CHANNEL_B_VDL_TRANSMISSION),
        ("", True, AisTransceiver.OWN_INFORMATION_NOT_BROADCAST),
        ("", False, None),
    ],
)
def test_channel_and_own_ship_come_back(channel: str, own: bool, told: AisTransceiver | None) -> None:
    radio = ais.write(AisClassAPositionReport(**ship()))
    assert radio is not None
    message = ais.read(AisRadio(radio.bits, radio.length, channel, own))
    assert isinstance(message, AisClassAPositionReport)
    assert message.ais_transceiver_information is told
    back = ais.write(message)
    assert back is not None
    assert (back.channel, back.own) == (channel, own)


def test_any_bits_are_read_and_what_was_read_can_be_sent() -> None:
    chance = random.Random(3)
    read = 0
    for _ in range(5_000):
        length = chance.choice((40, 160, 162, 168, 272, 312, 360, 420, 424, 1008))
        kind = chance.choice((1, 3, 4, 5, 9, 11, 14, 18, 19, 21, 24))
        bits = chance.getrandbits(length) & (1 << length - 6) - 1 | kind << length - 6
        message = ais.read(AisRadio(bits, length, "A"), chance.choice((None, 20_000)))
        if message is not None:
            read += 1
            assert message.PGN is not None
            ais.write(type(message).decode(message.encode()))
    assert read > 2_000


def test_any_payload_of_the_backbone_gives_sentences_or_none() -> None:
    chance = random.Random(4)
    written = 0
    for _ in range(5_000):
        kind = chance.choice(list(LAYOUTS))
        assert kind.PGN is not None
        payload = bytearray(chance.randbytes(60))
        payload[0] = chance.choice(ais.IDS[kind])
        payload[4] &= 0x3F
        message = registry.decode(kind.PGN, bytes(payload))
        assert message is not None
        radio = ais.write(message)
        written += radio is not None
        if radio is not None:
            VdmWriter().sentences(radio)
    assert written > 4_000


def said(says: list[Any]) -> list[bytes]:
    assert all(isinstance(say, Say) for say in says)
    return [line for say in says for line in say.line.splitlines()]


def test_a_message_of_two_sentences_is_said_in_one_piece() -> None:
    effects = Ais().say(AisClassAStaticAndVoyageRelatedData(**ship(message_id=5, name="SANTA MARIA")), 0.0)
    (say,) = effects
    assert isinstance(say, Say)
    assert say.key == "VDM,5,224123456"
    reader = VdmReader()
    first, second = (reader.receive(line, 0.0) for line in said(effects))
    assert first is None
    assert isinstance(second, AisRadio)


def test_a_ceiling_is_one_for_each_ship() -> None:
    talk = Ais(rate=0.1)
    spoken = [
        bool(talk.say(AisClassAPositionReport(**ship(user_id=mmsi)), now))
        for mmsi, now in ((1_000_001, 0.0), (1_000_002, 0.0), (1_000_001, 9.9), (1_000_001, 10.0))
    ]
    assert spoken == [True, True, False, True]


def test_with_a_ceiling_of_zero_nothing_is_said() -> None:
    assert Ais(rate=0).say(AisClassAPositionReport(**ship()), 0.0) == []


def test_what_we_said_ourselves_is_not_taken_for_a_receivers() -> None:
    counters: Counter[str] = Counter()
    talk = Ais(counters=counters)
    (line,) = said(talk.say(AisClassAPositionReport(**ship()), 0.0))
    assert talk.hear(line, None, ECHO - 0.1) == []
    assert counters == {KNOWN: 1}
    assert talk.hear(line, None, ECHO) == [AisClassAPositionReport(**ship(**ZEROS))]


def test_what_was_said_is_forgotten_in_order_when_it_is_too_much() -> None:
    talk = Ais()
    lines = [
        said(talk.say(AisClassAPositionReport(**ship(user_id=1_000_000 + number)), 0.0))[0]
        for number in range(MOST_SAID + 1)
    ]
    assert len(talk.hear(lines[0], None, 1.0)) == 1
    assert talk.hear(lines[1], None, 1.0) == []


def test_a_broken_sentence_is_told_and_a_lost_half_counted() -> None:
    counters: Counter[str] = Counter()
    talk = Ais(counters=counters)
    assert talk.hear(b"!AIVDM,1,1,,A,0,0*00", None, 0.0) is Fault.WRONG_CHECKSUM
    _, second = said(Ais().say(AisClassAStaticAndVoyageRelatedData(**ship(message_id=5)), 0.0))
    assert talk.hear(second, None, 0.0) == []
    assert counters == {NOT_WHOLE: 1}


def test_what_another_receiver_has_put_on_the_bus_is_not_put_there_again_even_if_nothing_is_said() -> None:
    (line,) = said(Ais().say(AisClassAPositionReport(**ship()), 0.0))
    silent = Ais(rate=0)
    silent.say(AisClassAPositionReport(**ship()), 0.0)
    assert silent.hear(line, None, 1.0) == []


class Receiver:
    """A boat with an AIS receiver on a wire, and what she does."""

    def __init__(self, settings: BoatSettings | None = None) -> None:
        self.boat = Boat(settings or BoatSettings(), [Port("AIS", instrument=True)], 0.0)
        self.reassembler = Reassembler()

    def hear(self, line: bytes, now: float) -> tuple[list[Message], list[bytes]]:
        """Messages on the bus, and sentences to the stations."""
        effects = self.boat.receive_bytes("AIS", line + b"\r\n", now)
        frames = [effect.frame for effect in effects if isinstance(effect, Transmit)]
        payloads = [
            (split(frame.identifier).pgn, self.reassembler.receive(frame.identifier, frame.data, now))
            for frame in frames
        ]
        messages = [registry.decode(pgn, payload) for pgn, payload in payloads if payload is not None]
        lines = [effect.line.rstrip() for effect in effects if isinstance(effect, Say) and effect.key.startswith("VD")]
        return [message for message in messages if message is not None], lines


LINE = b"!AIVDM,1,1,,B,13noL401AuQfPShR<7M9tp1n080<,0*45"


def test_a_receiver_on_a_wire_tells_the_bus_and_the_stations() -> None:
    (message,), lines = Receiver().hear(LINE, 1.0)
    assert isinstance(message, AisClassAPositionReport)
    assert message.user_id == 258_858_000
    assert lines == [LINE]


def test_the_same_message_of_a_second_receiver_is_counted_and_goes_no_further() -> None:
    receiver = Receiver()
    receiver.hear(LINE, 1.0)
    assert receiver.hear(LINE, 2.0) == ([], [])


def test_a_broken_sentence_of_a_receiver_is_rejected() -> None:
    receiver = Receiver()
    assert receiver.hear(LINE[:-1] + b"6", 1.0) == ([], [])
    assert receiver.boat.counters["wrong check sum"] == 1


def test_a_receiver_on_the_bus_is_told_to_the_stations_unless_its_owner_does_not_want_it() -> None:
    message = AisClassAPositionReport(**ship(**ZEROS))
    for rates, sentences in (({}, 1), ({"VDM": 0.0}, 0)):
        boat = Boat(BoatSettings(rates=rates), [], 0.0)
        frames = Sender(43).frames(outgoing(message))
        effects = boat.receive_frames(frames, 1.0)
        assert len([effect for effect in effects if isinstance(effect, Say) and effect.key != "STATUS"]) == sentences
