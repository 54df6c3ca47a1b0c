"""Alerts as NMEA 2000 has them: raised, answered, and told in words."""

from typing import Annotated

from timonel.core.fields import U8, U16, Bits, Lookup, Reserved, StringLau
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    AlertCategory,
    AlertLanguageId,
    AlertResponseCommand,
    AlertState,
    AlertThresholdStatus,
    AlertTriggerCondition,
    AlertType,
    YesNoBit,
)


class OfAlert(Message):
    """How every message about an alert begins: which one it is, and whose."""

    alert_type: Annotated[AlertType | None, Lookup(4, AlertType)] = None
    alert_category: Annotated[AlertCategory | None, Lookup(4, AlertCategory)] = None
    alert_system: Annotated[int | None, U8()] = None
    alert_sub_system: Annotated[int | None, U8()] = None
    alert_id: Annotated[int | None, U16()] = None
    data_source_network_id_name: Annotated[int, Bits(64)]
    data_source_instance: Annotated[int | None, U8()] = None
    data_source_index_source: Annotated[int | None, U8()] = None
    alert_occurrence_number: Annotated[int | None, U8()] = None


class Alert(OfAlert, pgn=126983):
    """PGN 126983: an alert and the state it is in.

    Fast packet, on event. Layout: canboat `alert`.
    """

    temporary_silence_status: Annotated[YesNoBit, Lookup(1, YesNoBit)] = YesNoBit.NO
    acknowledge_status: Annotated[YesNoBit, Lookup(1, YesNoBit)] = YesNoBit.NO
    escalation_status: Annotated[YesNoBit, Lookup(1, YesNoBit)] = YesNoBit.NO
    temporary_silence_support: Annotated[YesNoBit, Lookup(1, YesNoBit)] = YesNoBit.NO
    acknowledge_support: Annotated[YesNoBit, Lookup(1, YesNoBit)] = YesNoBit.NO
    escalation_support: Annotated[YesNoBit, Lookup(1, YesNoBit)] = YesNoBit.NO
    reserved: Annotated[None, Reserved(2)] = None
    acknowledge_source_network_id_name: Annotated[int, Bits(64)]
    trigger_condition: Annotated[AlertTriggerCondition | None, Lookup(4, AlertTriggerCondition)] = None
    threshold_status: Annotated[AlertThresholdStatus | None, Lookup(4, AlertThresholdStatus)] = None
    alert_priority: Annotated[int | None, U8()] = None
    alert_state: Annotated[AlertState | None, Lookup(8, AlertState)] = None


class AlertResponse(OfAlert, pgn=126984):
    """PGN 126984: somebody acknowledges or silences an alert.

    Fast packet, on event. Layout: canboat `alertResponse`.
    """

    acknowledge_source_network_id_name: Annotated[int, Bits(64)]
    response_command: Annotated[AlertResponseCommand, Lookup(2, AlertResponseCommand)]
    reserved: Annotated[None, Reserved(6)] = None


class AlertText(OfAlert, pgn=126985):
    """PGN 126985: an alert in words.

    Fast packet, on event. Layout: canboat `alertText`.
    """

    language_id: Annotated[AlertLanguageId | None, Lookup(8, AlertLanguageId)] = None
    alert_text_description: Annotated[str | None, StringLau()] = None
    alert_location_text_description: Annotated[str | None, StringLau()] = None
