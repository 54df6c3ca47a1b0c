"""What ships, aircraft and marks tell of themselves by radio, as an AIS receiver passes it on to the backbone.

Each message carries one message of ITU-R M.1371, `message_id` says which.
"""

from typing import Annotated

from timonel.core.fields import (
    I16,
    I32,
    U8,
    U16,
    U32,
    Ascii,
    Bits,
    Date,
    Lookup,
    Reserved,
    Spare,
    StringLau,
    TimeOfDay,
)
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    AisAssignedMode,
    AisBand,
    AisCommunicationState,
    AisMessageId,
    AisMode,
    AisSpecialManeuver,
    AisTransceiver,
    AisType,
    AisVersion,
    AtonType,
    Available,
    NavStatus,
    PositionAccuracy,
    PositionFixDevice,
    RaimFlag,
    RepeatIndicator,
    ShipType,
    TimeStamp,
    YesNoBit,
)

MMSI = 999_999_999
"""The highest: nine digits."""


class OfTransponder(Message):
    """How all but one of them begin: which message, how often repeated, and the MMSI of who speaks."""

    message_id: Annotated[AisMessageId | None, Lookup(6, AisMessageId)]
    repeat_indicator: Annotated[RepeatIndicator | None, Lookup(2, RepeatIndicator)]
    user_id: Annotated[int | None, U32(limit=MMSI)]


class OfPlace(OfTransponder):
    """Who is where, and how well that is known."""

    longitude: Annotated[float | None, I32(1e-7, "deg", limit=180)]
    latitude: Annotated[float | None, I32(1e-7, "deg", limit=90)]
    position_accuracy: Annotated[PositionAccuracy, Lookup(1, PositionAccuracy)]
    raim: Annotated[RaimFlag, Lookup(1, RaimFlag)]


class OfReport(OfPlace):
    """A place at a second of the minute; 60 and above say why there is none."""

    time_stamp: Annotated[TimeStamp, Lookup(6, TimeStamp)]


class AisClassAPositionReport(OfReport, pgn=129038):
    """PGN 129038: where a ship is and goes (messages 1, 2, 3).

    Fast packet, priority 4, on event. Layout: canboat `aisClassAPositionReport`.
    """

    cog: Annotated[float | None, U16(1e-4, "rad")]
    sog: Annotated[float | None, U16(0.01, "m/s")]
    communication_state: Annotated[int, Bits(19)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    heading: Annotated[float | None, U16(1e-4, "rad")]
    rate_of_turn: Annotated[float | None, I16(3.125e-5, "rad/s")]
    nav_status: Annotated[NavStatus | None, Lookup(4, NavStatus)]
    special_maneuver_indicator: Annotated[AisSpecialManeuver, Lookup(2, AisSpecialManeuver)]
    reserved: Annotated[None, Reserved(2)] = None
    spare18: Annotated[None, Spare(3)] = None
    reserved19: Annotated[None, Reserved(5)] = None
    sequence_id: Annotated[int | None, U8()]


class AisClassBPositionReport(OfReport, pgn=129039):
    """PGN 129039: where a craft with the smaller equipment is and goes (message 18).

    Fast packet, priority 4, on event. Layout: canboat `aisClassBPositionReport`.
    """

    cog: Annotated[float | None, U16(1e-4, "rad")]
    sog: Annotated[float | None, U16(0.01, "m/s")]
    communication_state: Annotated[int, Bits(19)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    heading: Annotated[float | None, U16(1e-4, "rad")]
    regional_application: Annotated[None, Spare(8)] = None
    regional_application_b: Annotated[None, Spare(2)] = None
    unit_type: Annotated[AisType, Lookup(1, AisType)]
    integrated_display: Annotated[YesNoBit, Lookup(1, YesNoBit)]
    dsc: Annotated[YesNoBit, Lookup(1, YesNoBit)]
    band: Annotated[AisBand, Lookup(1, AisBand)]
    can_handle_msg22: Annotated[YesNoBit, Lookup(1, YesNoBit)]
    ais_mode: Annotated[AisMode, Lookup(1, AisMode)]
    ais_communication_state: Annotated[AisCommunicationState, Lookup(1, AisCommunicationState)]
    reserved: Annotated[None, Reserved(7)] = None
    sequence_id: Annotated[int | None, U8()]


class AisClassBExtendedPositionReport(OfReport, pgn=129040):
    """PGN 129040: the same with name and size (message 19).

    Fast packet, priority 4, on event. Layout: canboat `aisClassBExtendedPositionReport`.
    """

    cog: Annotated[float | None, U16(1e-4, "rad")]
    sog: Annotated[float | None, U16(0.01, "m/s")]
    regional_application: Annotated[None, Spare(8)] = None
    regional_application_b: Annotated[None, Spare(4)] = None
    reserved: Annotated[None, Reserved(4)] = None
    type_of_ship: Annotated[ShipType | None, Lookup(8, ShipType)]
    true_heading: Annotated[float | None, U16(1e-4, "rad")]
    reserved16: Annotated[None, Reserved(4)] = None
    gnss_type: Annotated[PositionFixDevice | None, Lookup(4, PositionFixDevice)]
    length: Annotated[float | None, U16(0.1, "m")]
    beam: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_starboard: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_bow: Annotated[float | None, U16(0.1, "m")]
    name: Annotated[str | None, Ascii(20)]
    dte: Annotated[Available, Lookup(1, Available)]
    ais_mode: Annotated[AisMode, Lookup(1, AisMode)]
    spare25: Annotated[None, Spare(4)] = None
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    reserved27: Annotated[None, Reserved(5)] = None


class AisAidsToNavigationAtonReport(OfReport, pgn=129041):
    """PGN 129041: a buoy, beacon or light, real or virtual (message 21).

    Fast packet, priority 4, on event. Layout: canboat `aisAidsToNavigationAtonReport`.
    """

    length_diameter: Annotated[float | None, U16(0.1, "m")]
    beam_diameter: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_starboard_edge: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_true_north_facing_edge: Annotated[float | None, U16(0.1, "m")]
    aton_type: Annotated[AtonType, Lookup(5, AtonType)]
    off_position_indicator: Annotated[YesNoBit, Lookup(1, YesNoBit)]
    virtual_aton_flag: Annotated[YesNoBit, Lookup(1, YesNoBit)]
    assigned_mode_flag: Annotated[AisAssignedMode, Lookup(1, AisAssignedMode)]
    spare: Annotated[None, Spare(1)] = None
    position_fixing_device_type: Annotated[PositionFixDevice | None, Lookup(4, PositionFixDevice)]
    reserved19: Annotated[None, Reserved(3)] = None
    aton_status: Annotated[int, Bits(8)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    reserved22: Annotated[None, Reserved(3)] = None
    aton_name: Annotated[str | None, StringLau()]


class AisUtcAndDateReport(OfPlace, pgn=129793):
    """PGN 129793: time and place of a base station (message 4), or of a ship that was asked (11).

    Fast packet, priority 7, on event. Layout: canboat `aisUtcAndDateReport`.
    """

    reserved: Annotated[None, Reserved(6)] = None
    position_time: Annotated[float | None, TimeOfDay()]
    communication_state: Annotated[int, Bits(19)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    position_date: Annotated[int | None, Date()]
    reserved13: Annotated[None, Reserved(4)] = None
    gnss_type: Annotated[PositionFixDevice | None, Lookup(4, PositionFixDevice)]
    spare15: Annotated[None, Spare(10)] = None
    reserved16: Annotated[None, Reserved(6)] = None
    sequence_id: Annotated[int | None, U8()]


class AisClassAStaticAndVoyageRelatedData(OfTransponder, pgn=129794):
    """PGN 129794: name, size and destination of a ship (message 5).

    Fast packet, priority 6, on event. Layout: canboat `aisClassAStaticAndVoyageRelatedData`.
    """

    imo_number: Annotated[int | None, U32()]
    callsign: Annotated[str | None, Ascii(7)]
    name: Annotated[str | None, Ascii(20)]
    type_of_ship: Annotated[ShipType | None, Lookup(8, ShipType)]
    length: Annotated[float | None, U16(0.1, "m")]
    beam: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_starboard: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_bow: Annotated[float | None, U16(0.1, "m")]
    eta_date: Annotated[int | None, Date()]
    eta_time: Annotated[float | None, TimeOfDay()]
    draft: Annotated[float | None, U16(0.01, "m")]
    destination: Annotated[str | None, Ascii(20)]
    ais_version_indicator: Annotated[AisVersion, Lookup(2, AisVersion)]
    gnss_type: Annotated[PositionFixDevice | None, Lookup(4, PositionFixDevice)]
    dte: Annotated[Available, Lookup(1, Available)]
    reserved: Annotated[None, Reserved(1)] = None
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    reserved21: Annotated[None, Reserved(3)] = None
    sequence_id: Annotated[int | None, U8()]


class AisSarAircraftPositionReport(OfReport, pgn=129798):
    """PGN 129798: an aircraft that searches and rescues (message 9).

    Fast packet, priority 4, on event. Layout: canboat `aisSarAircraftPositionReport`.
    """

    cog: Annotated[float | None, U16(1e-4, "rad")]
    sog: Annotated[float | None, U16(0.1, "m/s")]
    communication_state: Annotated[int, Bits(19)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    altitude: Annotated[float | None, I32(0.01, "m")]
    reserved_for_regional_applications: Annotated[int, Bits(8)]
    dte: Annotated[Available, Lookup(1, Available)]
    spare: Annotated[None, Spare(5)] = None
    reserved17: Annotated[None, Reserved(2)] = None


class AisSafetyRelatedBroadcastMessage(Message, pgn=129802):
    """PGN 129802: a warning in words to everybody (message 14).

    Fast packet, priority 5, on event. Layout: canboat `aisSafetyRelatedBroadcastMessage`.
    """

    message_id: Annotated[AisMessageId | None, Lookup(6, AisMessageId)]
    repeat_indicator: Annotated[RepeatIndicator | None, Lookup(2, RepeatIndicator)]
    source_id: Annotated[int | None, U32(limit=MMSI)]
    reserved: Annotated[None, Reserved(1)] = None
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    spare6: Annotated[None, Spare(2)] = None
    safety_related_text: Annotated[str | None, StringLau()]


class AisClassBStaticDataMsg24PartA(OfTransponder, pgn=129809):
    """PGN 129809: the name of a craft (message 24, part A).

    Fast packet, priority 6, on event. Layout: canboat `aisClassBStaticDataMsg24PartA`.
    """

    name: Annotated[str | None, Ascii(20)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    reserved: Annotated[None, Reserved(3)] = None
    sequence_id: Annotated[int | None, U8()]


class AisClassBStaticDataMsg24PartB(OfTransponder, pgn=129810):
    """PGN 129810: kind and size of a craft, and who made its equipment (message 24, part B).

    Fast packet, priority 6, on event. Layout: canboat `aisClassBStaticDataMsg24PartB`.

    A tender says whose it is by `mothership_user_id` instead of its size.
    """

    type_of_ship: Annotated[ShipType | None, Lookup(8, ShipType)]
    vendor_id: Annotated[str | None, Ascii(7)]
    callsign: Annotated[str | None, Ascii(7)]
    length: Annotated[float | None, U16(0.1, "m")]
    beam: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_starboard: Annotated[float | None, U16(0.1, "m")]
    position_reference_from_bow: Annotated[float | None, U16(0.1, "m")]
    mothership_user_id: Annotated[int | None, U32(limit=MMSI)]
    reserved: Annotated[None, Reserved(2)] = None
    spare13: Annotated[None, Spare(2)] = None
    gnss_type: Annotated[PositionFixDevice | None, Lookup(4, PositionFixDevice)]
    ais_transceiver_information: Annotated[AisTransceiver | None, Lookup(5, AisTransceiver)]
    reserved16: Annotated[None, Reserved(3)] = None
    sequence_id: Annotated[int | None, U8()]
