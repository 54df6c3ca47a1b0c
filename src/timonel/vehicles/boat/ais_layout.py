"""Which bits of an AIS message are which field of its PGN: one table that reads and writes.

A `Row` is a stretch of bits and the fields of the PGN's message that it stands for, with a function from the bits to
their values and one back. Values are those of the declarations in `nmea2000.messages.ais`: SI, None where not
available. What the PGN has no field for is written as zeros.

Lost on the way through a PGN, and only that: a rate of turn of +-1 (0.04 degrees a minute) becomes 0; the class B
communication selector of an aircraft and its assigned mode; letters behind the first `@` of a text.
A rate of turn of +-127, which says "turning, but nothing measures how fast", travels as the 720 degrees a minute that
the formula has for it.
Source: ITU-R M.1371-5, tables 48 to 91; canboat's layouts of 129038..129810.
"""

from collections.abc import Callable
from datetime import date, timedelta
from enum import IntEnum
from functools import partial
from math import copysign, degrees, radians, sqrt
from typing import Any

import msgspec

from timonel.core.message import Message
from timonel.nmea0183.sixbit import read_text, write_text
from timonel.nmea2000 import lookups
from timonel.nmea2000.messages.ais import (
    AisAidsToNavigationAtonReport,
    AisClassAPositionReport,
    AisClassAStaticAndVoyageRelatedData,
    AisClassBExtendedPositionReport,
    AisClassBPositionReport,
    AisClassBStaticDataMsg24PartA,
    AisClassBStaticDataMsg24PartB,
    AisSafetyRelatedBroadcastMessage,
    AisSarAircraftPositionReport,
    AisUtcAndDateReport,
)
from timonel.vehicles.boat.conversion import EPOCH, KNOT
from timonel.vehicles.boat.truth import SECONDS_A_DAY

LAST_DAY = 65532  # of those that 16 bits can say
TURN = 4.733  # of the square root of degrees a minute
TENDERS = range(980_000_000, 990_000_000)
"""The MMSIs of craft that belong to a mother ship."""

Read = Callable[[int, int | None], tuple[Any, ...]]
"""From the bits, and the day since 1970 if it is known, to the values of the fields."""
Write = Callable[..., int]


class Row(msgspec.Struct, frozen=True):
    """`bits` of the message, and the fields that they stand for."""

    bits: int
    names: tuple[str, ...]
    read: Read
    write: Write


# Kinds of row -----------------------------------------------------------------------------------


def unused(bits: int) -> Row:
    """Zeros, not read."""
    return Row(bits, (), lambda raw, day: (), lambda: 0)


def part(number: int) -> Row:
    """Two bits that tell the parts of message 24 apart."""
    return Row(2, (), lambda raw, day: (), lambda: number)


def whole(bits: int, name: str) -> Row:
    """Bits as they are."""
    return Row(bits, (name,), lambda raw, day: (raw,), lambda value: value or 0)


def code(bits: int, name: str, codes: type[IntEnum], highest: int | None = None, none: int = 0) -> Row:
    """One of a list. What is above `highest` is not available, which is written as `none`."""
    limit = (1 << bits) - 1 if highest is None else highest

    def read(raw: int, day: int | None) -> tuple[IntEnum | None]:
        return (codes(raw) if raw <= limit else None,)

    return Row(bits, (name,), read, lambda value: none if value is None or value > limit else int(value))


def scaled(bits: int, name: str, unit: float, missing: int, highest: int) -> Row:
    """Steps of `unit`; `highest` stands for all that is more, and what is above it (`missing` too) for none."""

    def read(raw: int, day: int | None) -> tuple[float | None]:
        return (None if raw > highest or raw == missing else raw * unit,)

    return Row(
        bits, (name,), read, lambda value: missing if value is None else max(0, min(round(value / unit), highest))
    )


def angle(bits: int, name: str, step_deg: float, missing: int) -> Row:
    """An angle of a full circle, in rad."""
    circle = round(360 / step_deg)

    def read(raw: int, day: int | None) -> tuple[float | None]:
        return (None if raw >= circle else radians(raw * step_deg),)

    def write(value: float | None) -> int:
        return missing if value is None else round(degrees(value) / step_deg) % circle

    return Row(bits, (name,), read, write)


def place(bits: int, name: str, limit: int) -> Row:
    """Latitude or longitude in deg, kept in ten-thousandths of a minute; a degree beyond `limit` is none."""
    full, half = 1 << bits, 1 << bits - 1

    def read(raw: int, day: int | None) -> tuple[float | None]:
        value = (raw ^ half) - half
        return (value / 600_000 if abs(value) <= limit * 600_000 else None,)

    def write(value: float | None) -> int:
        return round((limit + 1 if value is None else value) * 600_000) % full

    return Row(bits, (name,), read, write)


def text(characters: int, name: str) -> Row:
    """Letters of six bits."""
    return Row(
        6 * characters,
        (name,),
        lambda raw, day: (read_text(raw, characters),),
        partial(_write_text, characters),
    )


def _write_text(characters: int, value: str | None) -> int:
    return write_text(value, characters)


def _read_turn(raw: int, day: int | None) -> tuple[float | None]:
    value = (raw ^ 0x80) - 0x80
    if value == -128:
        return (None,)
    return (radians(copysign((value / TURN) ** 2, value) / 60),)


def _write_turn(value: float | None) -> int:
    if value is None:
        return 0x80
    steps = min(round(TURN * sqrt(abs(degrees(value)) * 60)), 127)
    return (steps if value > 0 else -steps) & 0xFF


def _read_size(raw: int, day: int | None) -> tuple[float | None, ...]:
    """Length, beam, and where on it the antenna is: m from starboard, and from the bow.

    Zeros ahead and to port say that only the size is known.
    """
    bow, stern, port, starboard = raw >> 21, raw >> 12 & 0x1FF, raw >> 6 & 0x3F, raw & 0x3F
    if not raw:
        return None, None, None, None
    if bow == port == 0:
        return float(stern) or None, float(starboard) or None, None, None
    return float(bow + stern), float(port + starboard), float(starboard), float(bow)


def _write_size(length: float | None, beam: float | None, starboard: float | None, bow: float | None) -> int:
    long, wide = round(length or 0), round(beam or 0)
    if starboard is None or bow is None:
        return min(long, 511) << 12 | min(wide, 63)
    right, ahead = min(round(starboard), 63), min(round(bow), 511)
    stern, port = max(0, min(long - ahead, 511)), max(0, min(wide - right, 63))
    return ahead << 21 | stern << 12 | port << 6 | right


SIZE = ("length", "beam", "position_reference_from_starboard", "position_reference_from_bow")
ATON_SIZE = (
    "length_diameter",
    "beam_diameter",
    "position_reference_from_starboard_edge",
    "position_reference_from_true_north_facing_edge",
)


def _read_eta(raw: int, day: int | None) -> tuple[int | None, float | None]:
    """Day since 1970 and seconds of it. The message has no year: the one is meant that makes it nearest to `day`."""
    month, of_month, hour, minute = raw >> 16, raw >> 11 & 31, raw >> 6 & 31, raw & 63
    time = (hour * 60 + minute) * 60.0 if hour < 24 and minute < 60 else None
    return (None if day is None else _nearest(month, of_month, day)), time


def _nearest(month: int, of_month: int, day: int) -> int | None:
    year = (EPOCH + timedelta(day)).year
    days = [found for candidate in (year - 1, year, year + 1) if (found := _day(candidate, month, of_month))]
    return min(days, key=lambda found: abs(found - day), default=None)


def _day(year: int, month: int, of_month: int) -> int | None:
    """The day since 1970, as far as its field goes; None for a day that no calendar has."""
    try:
        day = (date(year, month, of_month) - EPOCH).days
    except ValueError:
        return None
    return day if 0 <= day <= LAST_DAY else None


def _write_eta(day: int | None, second: float | None) -> int:
    month = of_month = 0
    if day is not None:
        found = EPOCH + timedelta(day)
        month, of_month = found.month, found.day
    hour, minute = (24, 60) if second is None or second >= SECONDS_A_DAY else divmod(int(second) // 60, 60)
    return month << 16 | of_month << 11 | hour << 6 | minute


def _read_clock(raw: int, day: int | None) -> tuple[int | None, float | None]:
    """Day since 1970 and seconds of it."""
    year, month, of_month = raw >> 26, raw >> 22 & 15, raw >> 17 & 31
    hour, minute, second = raw >> 12 & 31, raw >> 6 & 63, raw & 63
    time = (hour * 60 + minute) * 60.0 + second if hour < 24 and minute < 60 and second < 60 else None
    return _day(year, month, of_month), time


def _write_clock(day: int | None, second: float | None) -> int:
    year = month = of_month = 0
    if day is not None:
        found = EPOCH + timedelta(day)
        year, month, of_month = found.year, found.month, found.day
    if second is None or second >= SECONDS_A_DAY:
        hour, minute, seconds = 24, 60, 60
    else:
        hour, rest = divmod(int(second), 3600)
        minute, seconds = divmod(rest, 60)
    return year << 26 | month << 22 | of_month << 17 | hour << 12 | minute << 6 | seconds


# The tables -------------------------------------------------------------------------------------

HEAD = (
    code(6, "message_id", lookups.AisMessageId),
    code(2, "repeat_indicator", lookups.RepeatIndicator),
    whole(30, "user_id"),
)
ACCURACY = code(1, "position_accuracy", lookups.PositionAccuracy)
RAIM = code(1, "raim", lookups.RaimFlag)
PLACE = (ACCURACY, place(28, "longitude", 180), place(27, "latitude", 90))
SOG = scaled(10, "sog", KNOT / 10, missing=1023, highest=1022)
COG = angle(12, "cog", 0.1, missing=3600)
HEADING = angle(9, "heading", 1.0, missing=511)
SECOND = code(6, "time_stamp", lookups.TimeStamp)
RADIO = whole(19, "communication_state")
SHIP = code(8, "type_of_ship", lookups.ShipType, highest=252)
FIX = code(4, "gnss_type", lookups.PositionFixDevice, highest=13, none=15)
ASSIGNED = code(1, "ais_mode", lookups.AisMode)
DTE = code(1, "dte", lookups.Available)
DIMENSIONS = Row(30, SIZE, _read_size, _write_size)


def flag(name: str, codes: type[IntEnum] = lookups.YesNoBit) -> Row:
    """One bit."""
    return code(1, name, codes)


POSITION = (
    *HEAD,
    code(4, "nav_status", lookups.NavStatus, highest=14, none=15),
    Row(8, ("rate_of_turn",), _read_turn, _write_turn),
    SOG, *PLACE, COG, HEADING, SECOND,
    code(2, "special_maneuver_indicator", lookups.AisSpecialManeuver),
    unused(3), RAIM, RADIO,
)  # fmt: skip
CLOCK = (
    *HEAD,
    Row(40, ("position_date", "position_time"), _read_clock, _write_clock),
    *PLACE, FIX, unused(10), RAIM, RADIO,
)  # fmt: skip
VOYAGE = (
    *HEAD,
    code(2, "ais_version_indicator", lookups.AisVersion),
    scaled(30, "imo_number", 1, missing=0, highest=(1 << 30) - 1),
    text(7, "callsign"), text(20, "name"), SHIP, DIMENSIONS, FIX,
    Row(20, ("eta_date", "eta_time"), _read_eta, _write_eta),
    scaled(8, "draft", 0.1, missing=0, highest=255),
    text(20, "destination"), DTE, unused(1),
)  # fmt: skip
AIRCRAFT = (
    *HEAD,
    scaled(12, "altitude", 1.0, missing=4095, highest=4094),
    scaled(10, "sog", KNOT, missing=1023, highest=1022),
    *PLACE, COG, SECOND, whole(8, "reserved_for_regional_applications"), DTE,
    unused(3), unused(1), RAIM, unused(1), RADIO,
)  # fmt: skip
SMALL_CRAFT = (
    *HEAD, unused(8), SOG, *PLACE, COG, HEADING, SECOND, unused(2),
    flag("unit_type", lookups.AisType), flag("integrated_display"), flag("dsc"), flag("band", lookups.AisBand),
    flag("can_handle_msg22"), ASSIGNED, RAIM, flag("ais_communication_state", lookups.AisCommunicationState), RADIO,
)  # fmt: skip
SMALL_CRAFT_EXTENDED = (
    *HEAD, unused(8), SOG, *PLACE, COG, angle(9, "true_heading", 1.0, missing=511), SECOND, unused(4),
    text(20, "name"), SHIP, DIMENSIONS, FIX, RAIM, DTE, ASSIGNED, unused(4),
)  # fmt: skip
SHORT_MARK = (
    *HEAD, code(5, "aton_type", lookups.AtonType), text(20, "aton_name"), *PLACE,
    Row(30, ATON_SIZE, _read_size, _write_size),
    code(4, "position_fixing_device_type", lookups.PositionFixDevice, highest=13, none=15),
    SECOND, flag("off_position_indicator"), whole(8, "aton_status"), RAIM, flag("virtual_aton_flag"),
    flag("assigned_mode_flag", lookups.AisAssignedMode), unused(1),
)  # fmt: skip
WARNING = (*HEAD[:2], whole(30, "source_id"), unused(2))
CRAFT_NAME = (*HEAD, part(0), text(20, "name"))
CRAFT_SIZE = (
    *HEAD, part(1), SHIP, text(7, "vendor_id"), text(7, "callsign"), DIMENSIONS, FIX, unused(2),
)  # fmt: skip
TENDER = tuple(whole(30, "mothership_user_id") if row is DIMENSIONS else row for row in CRAFT_SIZE)

LAYOUTS: dict[type[Message], tuple[Row, ...]] = {
    AisClassAPositionReport: POSITION,
    AisUtcAndDateReport: CLOCK,
    AisClassAStaticAndVoyageRelatedData: VOYAGE,
    AisSarAircraftPositionReport: AIRCRAFT,
    AisClassBPositionReport: SMALL_CRAFT,
    AisClassBExtendedPositionReport: SMALL_CRAFT_EXTENDED,
    AisAidsToNavigationAtonReport: SHORT_MARK,
    AisSafetyRelatedBroadcastMessage: WARNING,
    AisClassBStaticDataMsg24PartA: CRAFT_NAME,
    AisClassBStaticDataMsg24PartB: CRAFT_SIZE,
}
"""The fixed part of each message; those of marks and warnings are followed by more letters."""

KINDS: dict[int, type[Message]] = {
    1: AisClassAPositionReport,
    2: AisClassAPositionReport,
    3: AisClassAPositionReport,
    4: AisUtcAndDateReport,
    5: AisClassAStaticAndVoyageRelatedData,
    9: AisSarAircraftPositionReport,
    11: AisUtcAndDateReport,
    14: AisSafetyRelatedBroadcastMessage,
    18: AisClassBPositionReport,
    19: AisClassBExtendedPositionReport,
    21: AisAidsToNavigationAtonReport,
}
"""By message type; 24 has two."""
