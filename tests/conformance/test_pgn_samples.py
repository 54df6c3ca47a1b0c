"""Recorded payloads, and the values that other decoders find in them."""

import gzip
import json
import re
from collections import Counter
from collections.abc import Iterator
from typing import Any

import pytest
from nmea2000 import backend

from tests.recordings import recording
from timonel.core.fields import Ascii, Bits, Packed, Repeat, Reserved, Spare
from timonel.core.message import Message
from timonel.errors import EncodeError
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.lookups import (
    DeviceClass,
    DirectionRudder,
    HeadingReference,
    IndustryCode,
    ManufacturerCode,
    NewPriority,
    ParameterError,
    PgnErrorCode,
    SeatalkAlarmGroup,
    SeatalkAlarmId,
    SeatalkAlarmStatus,
    SeatalkDeviceId,
    SeatalkKey,
    SeatalkMode,
    SimnetApEvent,
    SimnetApMode,
    SimnetApModeFlags,
    SimnetDeviceModel,
    SimnetDirection,
    SteeringMode,
    TransmissionIntervalError,
    TurnMode,
    YesNo,
    YesNoBit,
)
from timonel.nmea2000.messages.group_function import (
    NmeaAcknowledgeGroupFunction,
    NmeaCommandGroupFunction,
    NmeaReadFieldsGroupFunction,
    NmeaRequestGroupFunction,
    NmeaWriteFieldsGroupFunction,
    Parameter,
    Proprietary,
    command,
    message_of,
    parameters_of,
)
from timonel.nmea2000.messages.navico import (
    SimnetApCommand,
    SimnetAutopilotAngle,
    SimnetCommandApChangeCourse,
    SimnetDeviceModeRequest,
    SimnetPilotMode,
)
from timonel.nmea2000.messages.navigation import GnssPositionData, PositionRapidUpdate
from timonel.nmea2000.messages.network import IsoAddressClaim, IsoRequest
from timonel.nmea2000.messages.raymarine import (
    Seatalk1DeviceIdentification,
    Seatalk1Keystroke,
    SeatalkAlarm,
    SeatalkKeepAlive,
    SeatalkPilotLockedHeading,
    SeatalkPilotMode,
    SeatalkPilotWindDatum,
    SeatalkSilenceAlarm,
)
from timonel.nmea2000.messages.steering import HeadingTrackControl, Rudder
from timonel.recording.formats import open_log

# Payloads, and the messages that they are.
GOLDEN: list[tuple[str, Message]] = [
    (  # canboat, merrimac-2022
        "30 38 ff ff 7f ff ff ff ff 0b 11 a3 0d ff 7f ff 7f ff 7f ff ff",
        HeadingTrackControl(
            rudder_limit_exceeded=YesNo.NO,
            off_heading_limit_exceeded=YesNo.NO,
            override=YesNo.NO,
            steering_mode=SteeringMode.MAIN_STEERING,
            heading_reference=HeadingReference.TRUE,
            rudder_limit=0.4363,
            off_heading_limit=0.3491,
        ),
    ),
    (  # canboat, Furuno FAP-7011C
        "00 4d 3f ff 7f cf 81 cf 81 ff ff ff ff ff 7f ff 7f ff 7f 14 7f",
        HeadingTrackControl(
            rudder_limit_exceeded=YesNo.NO,
            off_heading_limit_exceeded=YesNo.NO,
            off_track_limit_exceeded=YesNo.NO,
            override=YesNo.NO,
            steering_mode=SteeringMode.TRACK_CONTROL,
            turn_mode=TurnMode.TURN_RATE_CONTROLLED,
            heading_reference=HeadingReference.MAGNETIC,
            commanded_rudder_direction=DirectionRudder.STARBOARD,
            heading_to_steer_course=3.3231,
            track=3.3231,
            vessel_heading=3.2532,
        ),
    ),
    (
        "3f 3c ff ff 7f 05 1f ff ff ff ff ff ff ff 7f ff 7f ff 7f 8b 1e",
        HeadingTrackControl(
            override=YesNo.NO,
            steering_mode=SteeringMode.HEADING_CONTROL,
            heading_reference=HeadingReference.TRUE,
            heading_to_steer_course=0.7941,
            vessel_heading=0.7819,
        ),
    ),
    (  # an independent encoder: -3.2 deg is -558.505 steps
        "ff 04 5f d1 fd 05 1f ff ff dd 17 ff ff ff 7f ff 7f ff 7f 8b 1e",
        HeadingTrackControl(
            steering_mode=SteeringMode.HEADING_CONTROL,
            turn_mode=TurnMode.RUDDER_LIMIT_CONTROLLED,
            heading_reference=HeadingReference.TRUE,
            commanded_rudder_direction=DirectionRudder.PORT,
            commanded_rudder_angle=-0.0559,
            heading_to_steer_course=0.7941,
            rudder_limit=0.6109,
            vessel_heading=0.7819,
        ),
    ),
    (
        "ff 38 ff ff 7f ff ff ff ff ff ff ff ff ff 7f ff 7f ff 7f 8b 1e",
        HeadingTrackControl(
            steering_mode=SteeringMode.MAIN_STEERING,
            heading_reference=HeadingReference.TRUE,
            vessel_heading=0.7819,
        ),
    ),
    (  # canboat, direction not available
        "ff ff 15 02 28 02 ff ff",
        Rudder(instance=None, direction_order=None, angle_order=0.0533, position=0.0552),
    ),
    (
        "d2 04 e0 7c 00 82 32 c0",
        IsoAddressClaim(
            unique_number=1234,
            manufacturer_code=ManufacturerCode.SIGNAL_K,
            device_instance_lower=0,
            device_instance_upper=0,
            device_function=130,
            device_class=DeviceClass.INTERNETWORK_DEVICE,
            system_instance=0,
            industry_group=IndustryCode.MARINE,
            arbitrary_address_capable=YesNoBit.YES,
        ),
    ),
    ("14 f0 01", IsoRequest(pgn=126996)),
    ("e8 ac 51 19 be ab 6d d5", PositionRapidUpdate(latitude=42.478308, longitude=-71.4232898)),
    (  # a command to 127237
        "01 05 f1 01 f8 03 05 04 07 01 0b 05 1f",
        NmeaCommandGroupFunction(
            pgn=127237,
            priority=NewPriority.LEAVE_UNCHANGED,
            number_of_parameters=3,
            parameters=(Parameter(5, b"\x04"), Parameter(7, b"\x01"), Parameter(11, b"\x05\x1f")),
        ),
    ),
    (  # an EV-1 acknowledges a command to 65379
        "02 63 ff 00 00 04 00 00",
        NmeaAcknowledgeGroupFunction(
            pgn=65379,
            pgn_error_code=PgnErrorCode.ACKNOWLEDGE,
            transmission_interval_priority_error_code=TransmissionIntervalError.ACKNOWLEDGE,
            number_of_parameters=4,
            parameters=(ParameterError.ACKNOWLEDGE,) * 4,
        ),
    ),
    (  # a control head asks an EV-1 for its hull type; nobody has declared the target
        "00 00 ef 01 ff ff ff ff ff ff 04 01 3b 07 03 04 04 6c 05 1a 50",
        NmeaRequestGroupFunction(
            pgn=126720,
            number_of_parameters=4,
            parameters=(
                Parameter(1, b"\x3b\x07"),
                Parameter(3, b"\x04"),
                Parameter(4, b"\x6c"),
                Parameter(5, b"\x1a\x50"),
            ),
        ),
    ),
    (  # a write to a proprietary PGN says whose it is
        "05 50 ff 00 3b 9f 01 00 01 06 05 1f",
        NmeaWriteFieldsGroupFunction(
            pgn=65360,
            owner=Proprietary(manufacturer_code=ManufacturerCode.RAYMARINE, industry_code=IndustryCode.MARINE),
            unique_id=1,
            number_of_selection_pairs=0,
            number_of_parameters=1,
            parameters=(Parameter(6, b"\x05\x1f"),),
        ),
    ),
    (
        "03 05 f1 01 01 01 02 05 04 0b 13",
        NmeaReadFieldsGroupFunction(
            pgn=127237,
            unique_id=1,
            number_of_selection_pairs=1,
            number_of_parameters=2,
            selection=(Parameter(5, b"\x04"),),
            parameters=(11, 19),
        ),
    ),
    (  # Raymarine EV-1: auto
        "3b 9f 40 00 00 00 02 ff",
        SeatalkPilotMode(pilot_mode=SeatalkMode.AUTO, sub_mode=0, pilot_mode_data=2),
    ),
    (
        "3b 9f ff ff ff 05 1f ff",
        SeatalkPilotLockedHeading(sid=None, target_heading_true=None, target_heading_magnetic=0.7941),
    ),
    ("3b 9f 05 1f ff ff ff ff", SeatalkPilotWindDatum(wind_datum=0.7941, rolling_average_wind_angle=None)),
    ("3b 9f 00 00 00 00 00 00", SeatalkKeepAlive(unknown=bytes(6))),
    ("3b 9f f0 81 90 ff 03", Seatalk1DeviceIdentification(device=SeatalkDeviceId.S100)),
    (
        "3b 9f f0 81 86 21 07 f8 ff ff ff ff ff c1 c2 cd 66 80 d3 42 b1 c8",
        Seatalk1Keystroke(
            device=0x21,
            key=SeatalkKey.PLUS_1,
            keyinverted=0xF8,
            unknown_data=bytes.fromhex("ffffffffffc1c2cd6680d342b1c8"),
        ),
    ),
    (
        "3b 9f ff 01 1b 01 00 00",
        SeatalkAlarm(
            sid=None,
            alarm_status=SeatalkAlarmStatus.ACTIVE,
            alarm_id=SeatalkAlarmId.PILOT_CU_DISCONNECTED,
            alarm_group=SeatalkAlarmGroup.AUTOPILOT,
            alarm_priority=0,
        ),
    ),
    (
        "3b 9f 1b 01 ff ff ff ff",
        SeatalkSilenceAlarm(alarm_id=SeatalkAlarmId.PILOT_CU_DISCONNECTED, alarm_group=SeatalkAlarmGroup.AUTOPILOT),
    ),
    (  # Simrad: ten degrees to port
        "41 9f 02 ff ff 0a 1a 00 02 d1 06 ff",
        SimnetCommandApChangeCourse(address=2, direction=SimnetDirection.PORT, angle=0.1745),
    ),
    ("41 9f 02 ff ff 0a 06 00 ff ff ff ff", SimnetApCommand(address=2, event=SimnetApEvent.STANDBY)),
    ("41 9f 00 0b 00 00 00 00", SimnetDeviceModeRequest(model=SimnetDeviceModel.AC)),
    (
        "41 9f 64 0a 10 00 00 00",
        SimnetPilotMode(model=SimnetDeviceModel.NAC, mode=SimnetApModeFlags.HEADING),
    ),
    ("41 9f ff ff 02 ff 05 1f", SimnetAutopilotAngle(mode=SimnetApMode.HEADING, angle=0.7941)),
]


@pytest.mark.parametrize(("payload", "message"), GOLDEN, ids=lambda value: type(value).__name__)
def test_a_known_payload_is_its_message_and_the_message_is_the_payload(payload: str, message: Message):
    assert message.PGN is not None
    assert registry.decode(message.PGN, bytes.fromhex(payload)) == message
    assert message.encode() == bytes.fromhex(payload)


@pytest.mark.parametrize(
    ("payload", "expected"),
    [
        ("01 63 ff 00 f8 04 01 3b 07 03 04 04 40 00 05 ff ff", {"pilot_mode": SeatalkMode.AUTO, "sub_mode": 0xFFFF}),
        (
            "01 63 ff 00 f8 04 01 3b 07 03 04 04 81 01 05 ff ff",
            {"pilot_mode": SeatalkMode.NO_DRIFT, "sub_mode": 0xFFFF},
        ),
        ("01 50 ff 00 f8 03 01 3b 07 03 04 06 05 1f", {"target_heading_magnetic": 0.7941}),
        ("01 41 ff 00 f8 03 01 3b 07 03 04 04 05 1f", {"wind_datum": 0.7941}),
        (
            "01 05 f1 01 f8 03 05 04 07 01 0b 05 1f",
            {
                "steering_mode": SteeringMode.HEADING_CONTROL,
                "heading_reference": HeadingReference.MAGNETIC,
                "heading_to_steer_course": 0.7941,
            },
        ),
    ],
)
def test_a_command_is_made_of_fields_of_its_target_and_read_as_them(payload: str, expected: dict[str, Any]):
    read = registry.decode(126208, bytes.fromhex(payload))
    assert isinstance(read, NmeaCommandGroupFunction)
    (target,) = registry.MESSAGES[read.pgn]
    assert command(target, **expected).encode() == bytes.fromhex(payload)
    meant = message_of(target, read.parameters)
    assert {name: getattr(meant, name) for name in expected} == expected


def test_fields_that_a_command_does_not_name_stay_not_available():
    meant = message_of(HeadingTrackControl, parameters_of(HeadingTrackControl, track=1.0))
    assert meant == HeadingTrackControl(track=1.0)


@pytest.mark.parametrize("owner", [None, Proprietary(manufacturer_code=None, industry_code=None)])
def test_only_a_proprietary_target_has_an_owner(owner: Proprietary | None):
    message = NmeaReadFieldsGroupFunction(pgn=127237 if owner else 65379, owner=owner, unique_id=1)
    with pytest.raises(EncodeError, match=r"owner: .* does not go with PGN"):
        message.encode()


def test_more_reference_stations_than_there_are_give_those_there_are():
    payload = (  # Furuno FAP-7011C: 20 stations in 51 bytes
        "1E000014000014000890768DD0330500C06411BA02ECEE00140000140000141000140000140000140000140000140000140000"
    )
    message = registry.decode(129029, bytes.fromhex(payload))
    assert isinstance(message, GnssPositionData)
    assert (message.reference_stations, len(message.stations)) == (20, 2)


@pytest.mark.parametrize("pgn", [65379, 126720, 130850])
def test_another_makers_message_is_none(pgn: int):
    assert registry.decode(pgn, bytes.fromhex("89 98 7e 0a 01 00 50 05")) is None  # Maretron SSC300


def test_a_pgn_that_is_not_declared_has_no_decoder():
    assert registry.decoder(127488) is None
    assert registry.decode(127488, bytes(8)) is None
    assert (registry.priority(127488), registry.interval(127488)) == (6, None)


REFERENCES = [
    "SignalK_signalk-server/samples/aava-n2k.data",
    "canboat_canboat/samples/candumpSample2.txt",
    "canboat_canboat/samples/furuno-fap7011c-autopilot-off-then-on.raw",
    "canboat_canboat/samples/raymarine-ev1.raw",
    "canboat_canboat/samples/simulator1.raw",
]


def lines(name: str) -> Iterator[dict[str, Any]]:
    with gzip.open(recording(name), "rt") as stream:
        yield from map(json.loads, stream)


def snake(identifier: str) -> str:
    return re.sub(r"([a-z0-9])([A-Z])", r"\1_\2", identifier).lower()


def alike(ours: Any, theirs: Any) -> bool:
    """Equal, as far as the reference printed it: to seven decimals."""
    if isinstance(ours, int | float) and isinstance(theirs, int | float):
        return abs(ours - theirs) <= 5.1e-8 + 1e-9 * abs(theirs)
    if isinstance(ours, bytes):
        return isinstance(theirs, str | bytes) and ours.startswith(as_bytes(theirs))
    return bool(ours == theirs)


def as_bytes(theirs: str | bytes) -> bytes:
    return bytes.fromhex(theirs) if isinstance(theirs, str) else theirs


@pytest.mark.parametrize("name", REFERENCES)
def test_every_value_is_the_one_that_was_expected(name: str):
    compared = 0
    for line in lines(f"{name}.expected.jsonl.gz"):
        message = registry.decode(line["pgn"], bytes.fromhex(line["d"]))
        assert message is not None
        for identifier, theirs in line["f"].items():
            ours = getattr(message, snake(identifier))
            if identifier in ("time", "etaTime") and ours is not None:
                ours = round(ours * 10000)
            assert alike(ours, theirs), (line["d"], identifier)
            compared += 1
        if "n_list" in line and isinstance(message, GnssPositionData):
            assert len(message.stations) == line["n_list"]
    assert compared > 500


@pytest.mark.parametrize("name", REFERENCES)
def test_every_declared_message_has_the_values_that_canboat_prints(name: str):
    compared: Counter[str] = Counter()
    for line in lines(f"{name}.canboat.jsonl.gz"):
        if "version" in line:
            continue
        ((identifier, found),) = line.items()
        message = registry.decode(found["pgn"], bytes.fromhex(found["data"]))
        if message is not None and type(message).__name__ == identifier[0].upper() + identifier[1:]:
            for key, theirs in found["fields"].items():
                check_printed(message, key, theirs)
            compared[identifier] += 1
    assert compared.total() > 100


def check_printed(message: Message, key: str, theirs: Any) -> None:
    """Compare one field with canboat's JSON: lookups are objects, raw bytes are hex, groups a list."""
    if key == "list":
        check_list(message, theirs)
        return
    if key.startswith(("reserved", "spare")):
        return
    slot = next(slot for slot in message.layout if slot.name == snake(key))
    ours = getattr(message, slot.name)
    value = theirs["value"] if isinstance(theirs, dict) else theirs
    if slot.unit == "s" and isinstance(theirs, dict) and isinstance(ours, float):
        ours = round(ours / slot.field.resolution)  # type: ignore[attr-defined]  # in raw steps
    if slot.name == "rate_of_turn" and isinstance(ours, float):
        ours = round(ours, 5)  # as many decimals as it is printed with
    if slot.name.endswith("user_id"):
        value = int(value) or None if ours is None else int(value)  # an MMSI is printed as nine digits
    elif isinstance(slot.field, Bits) and isinstance(value, str):
        value = int.from_bytes(bytes.fromhex(value), "little")
    if slot.name == "eta_time" and ours is None:  # canboat prints 25:00, which is no time
        assert value is None or value > 24 * 36_000_000
        return
    if isinstance(ours, bytes) and value is None:
        value = b""
    assert alike(ours, value), (message, key, theirs)


def check_list(message: Message, theirs: list[dict[str, Any]]) -> None:
    for slot in message.layout:
        ours = getattr(message, slot.name)
        if isinstance(slot.field, Packed):
            values = [value for item in theirs for value in item.values()]
            assert list(ours) == [value["value"] if isinstance(value, dict) else value for value in values]
        elif isinstance(slot.field, Repeat):
            assert len(ours) == len(theirs)
            for group, item in zip(ours, theirs, strict=True):
                for key, value in item.items():
                    check_printed(group, key, value)
        elif isinstance(ours, tuple):
            indices = [parameter.index for parameter in ours]  # and sizes: canboat has stopped where it knew none
            assert indices[: len(theirs)] == [item["parameter"] for item in theirs]


RECORDINGS = [
    *REFERENCES,
    "SignalK_signalk-server/samples/aava-n2k.data",
    "aldas_go-nmea-client/actisense/testdata/actisense-w2k1-raw-ascii-2022-09-16.txt",
    "aldas_go-nmea-client/socketcan/testdata/candump-2021-05-12_091355.log",
    "canboat_canboat/samples/126208.raw",
    "canboat_canboat/samples/130311.raw",
    "canboat_canboat/samples/bandg_tritonedge.raw",
    "canboat_canboat/samples/bandg_zeuss.raw",
    "canboat_canboat/samples/dirona-actisense-serial.raw",
    "canboat_canboat/samples/h5000_pilot_126998.raw",
    "canboat_canboat/samples/maretron-alm100-command.raw",
    "canboat_canboat/samples/maretron-alm100-pgnlist.raw",
    "canboat_canboat/samples/pgn129285.raw",
    "canboat_canboat/samples/pgn65379.raw",
    "canboat_canboat/samples/sample-YDWG02-2.txt",
    "canboat_canboat/samples/sample-single.raw.txt",
    "canboat_canboat/samples/simnet-tp32.raw",
    "canboat_canboat/samples/simrad_event_timer_auto_start_on_off.raw",
    "canboat_canboat/samples/susteranna2020.raw",
]
MOST_OF_A_PGN = 200  # different payloads of one PGN and recording


def payloads(name: str) -> Iterator[tuple[int, bytes]]:
    """Different payloads of declared PGNs in a recording, fast packets put together."""
    reassembler, seen, count = Reassembler(), set(), Counter[int]()
    with open_log(recording(name)) as log:
        for frame in log:
            pgn = split(frame.identifier).pgn
            data: bytes | None = frame.data
            if registry.is_fast(pgn) and not frame.whole:
                data = reassembler.receive(frame.identifier, frame.data, frame.stamp or 0.0)
            if data and pgn in registry.MESSAGES and (pgn, data) not in seen and count[pgn] < MOST_OF_A_PGN:
                seen.add((pgn, data))
                count[pgn] += 1
                yield pgn, data


@pytest.mark.parametrize("name", sorted(set(RECORDINGS)))
def test_recorded_messages_have_the_values_of_the_package_nmea2000(name: str):
    compared = 0
    for pgn, data in payloads(name):
        theirs, ours = backend.decode(pgn, data), registry.decode(pgn, data)
        if ours is None or theirs is None or not same_variant(ours, theirs.id):
            continue
        for field in theirs.fields:
            check_field(ours, field, data)
            compared += 1
    assert compared > 0


def same_variant(message: Message, identifier: str) -> bool:
    """Whether both chose the same declaration; for keys of a Simrad head that have no arguments we have one."""
    generic = isinstance(message, SimnetApCommand) and identifier.startswith("simnetCommandAp")
    return generic or snake(identifier) == snake(type(message).__name__)


def check_field(message: Message, field: Any, data: bytes) -> None:
    slot = next((slot for slot in message.layout if slot.name == snake(field.id)), None)
    if slot is None or isinstance(slot.field, Reserved | Spare):
        return  # reserved, or in a group
    ours, theirs = getattr(message, slot.name), field.raw_value
    if isinstance(ours, str) or field.value is None:
        theirs = field.value if isinstance(ours, str) or ours is None else theirs
    if isinstance(slot.field, Bits) and isinstance(theirs, bytes):
        theirs = int.from_bytes(theirs, "little")
    if theirs is None and isinstance(ours, bytes | int):
        return  # not in a short payload
    if slot.name == "eta_time" and ours is None and theirs is not None:
        assert theirs > 86400  # 25:00 is no time
        return
    if isinstance(slot.field, Ascii) and isinstance(theirs, str):
        theirs = theirs.partition("@")[0].rstrip() or None  # behind the padding some receivers leave older text
    if slot.name == "address" and ours is None:
        ours = 255
    assert alike(ours, theirs), (message, field, data.hex())
