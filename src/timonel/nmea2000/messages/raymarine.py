"""Raymarine's SeaTalkNG messages of pilot and alarms. Nobody but their maker has documented them."""

from typing import Annotated

from timonel.core.fields import U8, U16, Binary, Bits, Lookup, Match, Reserved
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    IndustryCode,
    ManufacturerCode,
    Seatalk1Command,
    Seatalk1Mode,
    SeatalkAlarmGroup,
    SeatalkAlarmId,
    SeatalkAlarmStatus,
    SeatalkCommand,
    SeatalkDeviceId,
    SeatalkKey,
    SeatalkMessageId,
    SeatalkMode,
)


class Seatalk(Message):
    """How every message of Raymarine begins: `3b 9f`."""

    manufacturer_code: Annotated[ManufacturerCode, Match(11)] = ManufacturerCode.RAYMARINE
    reserved: Annotated[None, Reserved(2)] = None
    industry_code: Annotated[IndustryCode, Match(3)] = IndustryCode.MARINE


class SeatalkAlarm(Seatalk, pgn=65288):
    """PGN 65288: an alarm and the state it is in.

    Single frame, priority 7, on event. Layout: canboat `seatalkAlarm`.
    """

    sid: Annotated[int | None, U8()]
    alarm_status: Annotated[SeatalkAlarmStatus | None, Lookup(8, SeatalkAlarmStatus)]
    alarm_id: Annotated[SeatalkAlarmId | None, Lookup(8, SeatalkAlarmId)]
    alarm_group: Annotated[SeatalkAlarmGroup | None, Lookup(8, SeatalkAlarmGroup)]
    alarm_priority: Annotated[int, Bits(16)]


class SeatalkPilotWindDatum(Seatalk, pgn=65345):
    """PGN 65345: the wind angle that the pilot steers to.

    Single frame, on event. Layout: canboat `seatalkPilotWindDatum`.
    """

    wind_datum: Annotated[float | None, U16(1e-4, "rad")]
    rolling_average_wind_angle: Annotated[float | None, U16(1e-4, "rad")]
    reserved6: Annotated[None, Reserved(16)] = None


class SeatalkPilotHeading(Seatalk, pgn=65359):
    """PGN 65359: the heading by the pilot's own compass.

    Single frame, priority 7, on event. Layout: canboat `seatalkPilotHeading`.
    """

    sid: Annotated[int | None, U8()]
    heading_true: Annotated[float | None, U16(1e-4, "rad")]
    heading_magnetic: Annotated[float | None, U16(1e-4, "rad")]
    reserved7: Annotated[None, Reserved(8)] = None


class SeatalkPilotLockedHeading(Seatalk, pgn=65360):
    """PGN 65360: the heading that the pilot steers to.

    Single frame, priority 7, on event. Layout: canboat `seatalkPilotLockedHeading`.
    """

    sid: Annotated[int | None, U8()]
    target_heading_true: Annotated[float | None, U16(1e-4, "rad")]
    target_heading_magnetic: Annotated[float | None, U16(1e-4, "rad")]
    reserved7: Annotated[None, Reserved(8)] = None


class SeatalkSilenceAlarm(Seatalk, pgn=65361):
    """PGN 65361: silences an alarm.

    Single frame, on event. Layout: canboat `seatalkSilenceAlarm`.
    """

    alarm_id: Annotated[SeatalkAlarmId | None, Lookup(8, SeatalkAlarmId)]
    alarm_group: Annotated[SeatalkAlarmGroup | None, Lookup(8, SeatalkAlarmGroup)]
    reserved6: Annotated[None, Reserved(32)] = None


class SeatalkPilotMode(Seatalk, pgn=65379):
    """PGN 65379: the mode that the pilot is in.

    Single frame, priority 7, on event. Layout: canboat `seatalkPilotMode`.
    """

    pilot_mode: Annotated[SeatalkMode | None, Lookup(16, SeatalkMode)]
    sub_mode: Annotated[int, Bits(16)]
    pilot_mode_data: Annotated[int, Bits(8)]
    reserved7: Annotated[None, Reserved(8)] = None


class SeatalkKeepAlive(Seatalk, pgn=65384):
    """PGN 65384: what a control head sends once a second while it is there; the bytes are all zero.

    Single frame, priority 7, on event. Layout: canboat has none.
    """

    unknown: Annotated[bytes, Binary(6)]


class Seatalk1(Seatalk):
    """How a datagram of the older SeaTalk 1 begins when it travels in PGN 126720: `3b 9f f0 81`."""

    proprietary_id: Annotated[SeatalkMessageId, Match(8)] = SeatalkMessageId.SEATALK_1_ENCODED
    command: Annotated[SeatalkCommand, Match(8)] = SeatalkCommand.SEATALK1


class Seatalk1PilotMode(Seatalk1, pgn=126720):
    """PGN 126720: heading, course and mode of the pilot, as SeaTalk 1 had them.

    Fast packet, on event. Layout: canboat `seatalk1PilotMode`.
    """

    seatalk1_command: Annotated[Seatalk1Command, Match(8)] = Seatalk1Command.PILOT_STATE
    unknown1: Annotated[bytes, Binary(3)]
    pilot_mode: Annotated[Seatalk1Mode | None, Lookup(8, Seatalk1Mode)]
    sub_mode: Annotated[int | None, U8()]
    pilot_mode_data: Annotated[int, Bits(8)]
    unknown2: Annotated[bytes, Binary(10)]


class Seatalk1DeviceIdentification(Seatalk1, pgn=126720):
    """PGN 126720: a device is there; a control head sends it every 2 s.

    Fast packet, on event. Layout: canboat `seatalk1DeviceIdentification`.
    """

    seatalk1_command: Annotated[Seatalk1Command, Match(8)] = Seatalk1Command.DEVICE_IDENTIFICATION
    reserved7: Annotated[None, Reserved(8)] = None
    device: Annotated[SeatalkDeviceId | None, Lookup(8, SeatalkDeviceId)]


class Seatalk1Keystroke(Seatalk1, pgn=126720):
    """PGN 126720: a key of a control head was pressed; `keyinverted` is the one's complement of `key`.

    Fast packet, on event. Layout: canboat `seatalk1Keystroke`.
    """

    seatalk1_command: Annotated[Seatalk1Command, Match(8)] = Seatalk1Command.KEYSTROKE
    device: Annotated[int | None, U8()]
    key: Annotated[SeatalkKey | None, Lookup(8, SeatalkKey)]
    keyinverted: Annotated[int, Bits(8)]
    unknown_data: Annotated[bytes, Binary(14)]
