"""Maretron's own messages about alerts."""

from typing import Annotated

from timonel.core.fields import U8, U16, Binary, Bits, Lookup, Match, Reserved
from timonel.core.message import Message
from timonel.nmea2000.lookups import AlertCategory, AlertType, IndustryCode, ManufacturerCode


class MaretronAlertTransmission(Message, pgn=130819):
    """PGN 130819: an alert that 126983 tells too; the extension ends with its state in words.

    Fast packet, priority 7, on event. Layout: canboat `maretronAlertTransmission`.
    """

    manufacturer_code: Annotated[ManufacturerCode, Match(11)] = ManufacturerCode.MARETRON
    reserved: Annotated[None, Reserved(2)] = None
    industry_code: Annotated[IndustryCode, Match(3)] = IndustryCode.MARINE
    alert_type: Annotated[AlertType | None, Lookup(4, AlertType)]
    alert_category: Annotated[AlertCategory | None, Lookup(4, AlertCategory)]
    alert_system: Annotated[int | None, U8()]
    alert_sub_system: Annotated[int | None, U8()]
    alert_id: Annotated[int | None, U16()]
    data_source_network_id_name: Annotated[int, Bits(64)]
    data_source_instance: Annotated[int | None, U8()]
    data_source_index_source: Annotated[int | None, U8()]
    alert_occurrence_number: Annotated[int | None, U8()]
    maretron_extension: Annotated[bytes, Binary(16)]
