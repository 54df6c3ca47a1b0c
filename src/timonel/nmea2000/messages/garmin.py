"""Garmin's messages of the pilot, in PGN 126720. Nobody but their maker has documented them.

They travel both ways: a control head tells the pilot's computer, and it tells everybody the same field.
"""

from typing import Annotated

from timonel.core.fields import U8, Binary, Float32, Lookup, Match, Reserved, Spare
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    GarminAutopilotField,
    GarminManeuver,
    GarminMessageId,
    GarminPilotMode,
    IndustryCode,
    ManufacturerCode,
)


class GarminAutopilot(Message):
    """How every message of a Garmin pilot begins: `e5 98 10 17 04 04`."""

    manufacturer_code: Annotated[ManufacturerCode, Match(11)] = ManufacturerCode.GARMIN
    reserved: Annotated[None, Reserved(2)] = None
    industry_code: Annotated[IndustryCode, Match(3)] = IndustryCode.MARINE
    sub_protocol_id: Annotated[GarminMessageId, Match(16)] = GarminMessageId.AUTOPILOT_TRANSPORT
    wrapper_byte1: Annotated[int, Match(8)] = 4
    wrapper_byte2: Annotated[int, Match(8)] = 4


class GarminAutopilotHeadingToSteer(GarminAutopilot, pgn=126720):
    """PGN 126720: the heading that the pilot steers to; while it stands by, the heading that it would hold.

    Fast packet, priority 7, on event. Layout: canboat `garminAutopilotHeadingToSteer`.

    What north it is counted from it does not say.
    """

    field_group: Annotated[int, Match(8)] = 0
    field: Annotated[GarminAutopilotField, Match(8)] = GarminAutopilotField.HEADING_TO_STEER
    reserved9: Annotated[None, Reserved(8)] = None
    heading_to_steer: Annotated[float | None, Float32("rad", 1000.0)]


class GarminAutopilotRateOfTurn(GarminAutopilot, pgn=126720):
    """PGN 126720: how fast the pilot finds the bow to turn, once a second while it is engaged.

    Fast packet, priority 7, on event. Layout: canboat `garminAutopilotRateOfTurn`.
    """

    field_group: Annotated[int, Match(8)] = 0
    field: Annotated[GarminAutopilotField, Match(8)] = GarminAutopilotField.RATE_OF_TURN
    reserved9: Annotated[None, Reserved(8)] = None
    rate_of_turn: Annotated[float | None, Float32("rad/s")]


class GarminAutopilotModeState(GarminAutopilot, pgn=126720):
    """PGN 126720: the mode that the pilot shall be in, or has come to be in.

    Fast packet, priority 7, on event. Layout: canboat `garminAutopilotModeState`.
    """

    field_group: Annotated[int, Match(8)] = 5
    field: Annotated[GarminAutopilotField, Match(8)] = GarminAutopilotField.MODE_STATE
    spare9: Annotated[None, Spare(8)] = None
    mode_state: Annotated[GarminPilotMode | None, Lookup(8, GarminPilotMode)]
    spare11: Annotated[None, Spare(8)] = None


class GarminAutopilotHeartbeat(GarminAutopilot, pgn=126720):
    """PGN 126720: a control head is there; seen every 2.1 s.

    Fast packet, priority 7, on event. Layout: canboat `garminAutopilotHeartbeat`.
    """

    field_group: Annotated[int, Match(8)] = 21
    field: Annotated[GarminAutopilotField, Match(8)] = GarminAutopilotField.HEARTBEAT
    heartbeat_data: Annotated[bytes, Binary(4)]


class GarminAutopilotManeuver(GarminAutopilot, pgn=126720):
    """PGN 126720: a button that turns the heading to steer was pressed. `value` is not sent with these four.

    Fast packet, priority 7, on event. Layout: canboat `garminAutopilotManeuver`.
    """

    field_group: Annotated[int, Match(8)] = 38
    maneuver_code: Annotated[GarminManeuver | None, Lookup(8, GarminManeuver)]
    spare9: Annotated[None, Spare(8)] = None
    value: Annotated[int | None, U8()]
