"""Alerts as messages of the bus: what other devices' mean, what answers them, and how ours are told.

message                        owner          means                              answered by
126983, 126985                 its NAME       the standard's alert, and its text 126984 acknowledge, silence
130819 (Maretron)              its NAME       the same alert's state in words    -
65288 (Raymarine)              its address    not met, active, silenced          65361 for an acknowledgement
130850 alarm (Navico)          the network    activate, acknowledge, silence,    130850 acknowledge, silence
                                              deactivate; man overboard
130825, 130856 (Navico)        the network    it holds, how severe; its text     -

Raymarine's alarms know one answer, and stay quiet after it: it is given for an acknowledgement only, so that what
somebody silenced for 30 s is not quiet for good. Nothing here goes out with a manufacturer's header but the answers to
that manufacturer's own messages.
"""

import unicodedata
from collections.abc import Hashable
from typing import Any

import msgspec

from timonel.core.alerts import Alert, Priority
from timonel.core.message import Message
from timonel.nmea2000.lookups import (
    AlertCategory,
    AlertLanguageId,
    AlertResponseCommand,
    AlertState,
    AlertThresholdStatus,
    AlertTriggerCondition,
    AlertType,
    ManufacturerCode,
    SeatalkAlarmGroup,
    SeatalkAlarmId,
    SeatalkAlarmStatus,
    SimnetAlarmCommand,
    YesNoBit,
)
from timonel.nmea2000.messages.alerts import Alert as AlertMessage
from timonel.nmea2000.messages.alerts import AlertResponse, AlertText, OfAlert
from timonel.nmea2000.messages.maretron import MaretronAlertTransmission
from timonel.nmea2000.messages.navico import NavicoAlarm, SimnetAlarm
from timonel.nmea2000.messages.raymarine import SeatalkAlarm, SeatalkSilenceAlarm
from timonel.vehicles.boat.foreign_alerts import Condition, Order, Report

NO_NAME = (1 << 64) - 1  # of nobody known
AGE = 60.0  # s: the standard's and Raymarine's are told about once a second while they stand
AGE_OF_COMMANDS = 600.0  # s: Navico tells when one comes and when it goes
LONGEST_WORDS = 60

PRIORITIES = {
    AlertType.EMERGENCY_ALARM: Priority.EMERGENCY,
    AlertType.ALARM: Priority.ALARM,
    AlertType.WARNING: Priority.WARNING,
    AlertType.CAUTION: Priority.CAUTION,
}
TYPES = {priority: kind for kind, priority in PRIORITIES.items()}
STATES = {
    AlertState.DISABLED: Condition.NORMAL,
    AlertState.NORMAL: Condition.NORMAL,
    AlertState.ACTIVE: Condition.ACTIVE,
    AlertState.SILENCED: Condition.SILENCED,
    AlertState.ACKNOWLEDGED: Condition.ACKNOWLEDGED,
    AlertState.AWAITING_ACKNOWLEDGE: Condition.RECTIFIED,
}
SEATALK_STATUSES = {
    SeatalkAlarmStatus.NOT_MET: Condition.NORMAL,
    SeatalkAlarmStatus.ACTIVE: Condition.ACTIVE,
    SeatalkAlarmStatus.SILENCED: Condition.ACKNOWLEDGED,
}
SIMNET_COMMANDS = {
    SimnetAlarmCommand.ACTIVATE: Condition.ACTIVE,
    SimnetAlarmCommand.ACKNOWLEDGE: Condition.ACKNOWLEDGED,
    SimnetAlarmCommand.SILENCE: Condition.SILENCED,
    SimnetAlarmCommand.DEACTIVATE: Condition.NORMAL,
}
MAN_OVERBOARD = {
    SimnetAlarmCommand.MOB_ACTIVATED: Condition.ACTIVE,
    SimnetAlarmCommand.MOB_CANCELLED: Condition.NORMAL,
}
RESPONSES = {
    Order.ACKNOWLEDGE: AlertResponseCommand.ACKNOWLEDGE,
    Order.SILENCE: AlertResponseCommand.TEMPORARY_SILENCE,
}
SIMNET_ORDERS = {Order.ACKNOWLEDGE: SimnetAlarmCommand.ACKNOWLEDGE, Order.SILENCE: SimnetAlarmCommand.SILENCE}
ENGLISH = (AlertLanguageId.ENGLISH_US, AlertLanguageId.ENGLISH_UK)
WORDS_KEPT = 256


class Worded(msgspec.Struct, frozen=True, gc=False):
    """Name and text of an alert, in a language; "" is what nobody told."""

    name: str = ""
    text: str = ""
    language: AlertLanguageId | None = None


class Words:
    """What other devices' alerts are called: a text may come before its alert, and is kept for it.

    A device that tells its texts in several languages is heard in English, or else in the one that came first.
    """

    def __init__(self) -> None:
        self._words: dict[Hashable, Worded] = {}

    def keep(self, key: Hashable, name: str | None, text: str | None, language: AlertLanguageId | None = None) -> bool:
        """Remember what an alert is called and what is said of it; whether that is new."""
        before = self._words.get(key, Worded())
        other = None not in (language, before.language) and language is not before.language
        if other and (language not in ENGLISH or before.language in ENGLISH):
            return False
        words = Worded(
            plain(name) or before.name, plain(text) or before.text, before.language if language is None else language
        )
        if words == before:
            return False
        if len(self._words) >= WORDS_KEPT and key not in self._words:
            del self._words[next(iter(self._words))]
        self._words[key] = words
        return True

    def of(self, key: Hashable, otherwise: str) -> Worded:
        """Name and text; `otherwise` is the name of one that has none."""
        words = self._words.get(key, Worded())
        return words if words.name else msgspec.structs.replace(words, name=otherwise)


def plain(text: str | None) -> str:
    """The printable characters of a peer's text, at most `LONGEST_WORDS`."""
    printable = "".join(letter if letter.isprintable() else " " for letter in text or "")
    return " ".join(unicodedata.normalize("NFC", printable).split())[:LONGEST_WORDS]


# In ---------------------------------------------------------------------------------------------------


def standard_key(message: OfAlert | MaretronAlertTransmission, source: int) -> Hashable:
    """Which alert of whom, without how often it arose. Who does not tell its NAME is known by its address."""
    name = message.data_source_network_id_name
    return (
        "address" if name in (0, NO_NAME) else "name",
        source if name in (0, NO_NAME) else name,
        message.alert_system,
        message.alert_sub_system,
        message.alert_id,
        message.data_source_instance,
        message.data_source_index_source,
    )


def standard(message: AlertMessage, source: int, words: Words) -> Report | None:
    """What 126983 tells; None for a state that is not known."""
    condition = None if message.alert_state is None else STATES.get(message.alert_state)
    if condition is None:
        return None
    key = standard_key(message, source)
    told = words.of(key, f"alert {message.alert_id}")
    priority = Priority.WARNING if message.alert_type is None else PRIORITIES.get(message.alert_type, Priority.WARNING)
    return Report(key, source, message, condition, told.name, told.text, priority, AGE, message.alert_occurrence_number)


def maker(name: int) -> str:
    """Who made the device of a NAME, as far as that says so."""
    code = name >> 21 & 0x7FF
    known = name not in (0, NO_NAME) and code in set(ManufacturerCode)
    return spoken(ManufacturerCode(code).name) if known else "another device"


def seatalk(message: SeatalkAlarm, source: int) -> Report | None:
    """What 65288 tells; None for what is no alarm or no status."""
    alarm, status = message.alarm_id, message.alarm_status
    condition = None if status is None else SEATALK_STATUSES.get(status)
    if condition is None or alarm is None or alarm is SeatalkAlarmId.NO_ALARM:
        return None
    group = message.alarm_group
    priority = Priority.CAUTION if group is SeatalkAlarmGroup.BLUETOOTH_ACCESSORY else Priority.ALARM
    name = spoken(alarm.name)
    return Report(("seatalk", source, group, alarm), source, message, condition, name, "Raymarine", priority, AGE)


def simnet(message: SimnetAlarm, source: int, words: Words) -> Report | None:
    """What 130850 tells; None for commands that are about no alarm. Whoever says it, the alarm is the network's."""
    command = message.command
    if command in MAN_OVERBOARD:
        condition, name, key = MAN_OVERBOARD[command], "man overboard", simnet_key(None)
        return Report(key, source, message, condition, name, "Navico", Priority.EMERGENCY, NEVER_AGES, confirms=False)
    if command not in SIMNET_COMMANDS or message.alarm_id is None:
        return None
    key = simnet_key(message.alarm_id)
    name, text = spoken(message.alarm_id.name), words.of(key, "Navico").name
    condition = SIMNET_COMMANDS[command]
    return Report(key, source, message, condition, name, text, Priority.ALARM, AGE_OF_COMMANDS, confirms=False)


NEVER_AGES = 86400.0  # s: a man overboard is over when somebody says so


def navico(message: NavicoAlarm, source: int, words: Words) -> Report | None:
    """What 130825 tells: that an alarm holds, not who has seen it; None for what it does not name."""
    if message.alarm_id is None or message.alarm_state is None:
        return None
    holds = message.alarm_state not in (AlertState.NORMAL, AlertState.DISABLED)
    severity = message.alarm_severity
    priority = Priority.ALARM if severity is None else PRIORITIES.get(severity, Priority.ALARM)
    key = simnet_key(message.alarm_id)
    name, text = spoken(message.alarm_id.name), words.of(key, "Navico").name
    condition = Condition.HOLDS if holds else Condition.NORMAL
    return Report(key, source, message, condition, name, text, priority, AGE_OF_COMMANDS, confirms=False)


def simnet_key(alarm: int | None) -> Hashable:
    """Navico's alarms are one network's, whoever tells of them; None is a man overboard."""
    return ("simnet", alarm)


def spoken(name: str) -> str:
    """The name of a lookup's number as people say it: `PILOT_OFF_COURSE` is "pilot off course"."""
    return name.lower().replace("_", " ")


def maretron_words(message: MaretronAlertTransmission) -> str:
    """The state in words at the end of the extension: a counted text as canboat's STRING_LAU; "" if there is none."""
    counted = message.maretron_extension[2:]
    size = counted[0]
    if not 2 < size <= len(counted) or counted[1] != 1:
        return ""
    return counted[2:size].decode("ascii", "replace")


# Answers ----------------------------------------------------------------------------------------------


def answer(order: Order, origin: object, name: int) -> Message | None:
    """What tells the owner of an alert; None where it cannot be told. `name` is our own NAME."""
    match origin:
        case AlertMessage():
            identity = {field: getattr(origin, field) for field in OfAlert.__struct_fields__}
            response = RESPONSES[order]
            return AlertResponse(**identity, acknowledge_source_network_id_name=name, response_command=response)
        case SeatalkAlarm() if order is Order.ACKNOWLEDGE:
            return SeatalkSilenceAlarm(alarm_id=origin.alarm_id, alarm_group=origin.alarm_group)
        case SimnetAlarm(alarm_id=int()):
            return msgspec.structs.replace(origin, address=None, command=SIMNET_ORDERS[order])
        case NavicoAlarm():
            command = SIMNET_ORDERS[order]
            return SimnetAlarm(address=None, command=command, alarm_id=origin.alarm_id, f=None, g=None)
    return None


# Ours -------------------------------------------------------------------------------------------------


def identity(alert: Alert, category: AlertCategory, occurrence: int, name: int) -> dict[str, Any]:
    """How every message about an alert of ours begins."""
    return {
        "alert_type": TYPES[alert.kind.priority],
        "alert_category": category,
        "alert_id": alert.kind.id,
        "data_source_network_id_name": name,
        "data_source_instance": 0,
        "data_source_index_source": 0,
        "alert_occurrence_number": occurrence,
    }


def told(alert: Alert, begin: dict[str, Any], acknowledged_by: int) -> AlertMessage:
    """An alert of ours as 126983; `acknowledged_by` is the NAME of who acknowledged it."""
    return AlertMessage(
        **begin,
        temporary_silence_status=_yes(alert.silenced_until is not None),
        acknowledge_status=_yes(alert.acknowledged),
        escalation_status=_yes(alert.announced > 0),
        temporary_silence_support=YesNoBit.YES,
        acknowledge_support=YesNoBit.YES,
        escalation_support=YesNoBit.YES,
        acknowledge_source_network_id_name=acknowledged_by if alert.acknowledged else NO_NAME,
        trigger_condition=AlertTriggerCondition.AUTO,
        threshold_status=AlertThresholdStatus.THRESHOLD_EXCEEDED if alert.active else AlertThresholdStatus.NORMAL,
        alert_priority=None,
        alert_state=_state(alert),
    )


def told_in_words(alert: Alert, begin: dict[str, Any]) -> AlertText:
    """What an alert of ours is called, as 126985."""
    words = alert.kind.name if alert.text in ("", alert.kind.name) else f"{alert.kind.name}: {alert.text}"
    return AlertText(
        **begin,
        language_id=AlertLanguageId.ENGLISH_UK,
        alert_text_description=words[:LONGEST_TEXT],
        alert_location_text_description="",
    )


LONGEST_TEXT = 90  # characters, in two bytes each if they must be: within a fast packet's 223 bytes


def _state(alert: Alert) -> AlertState:
    if not alert.active:
        return AlertState.NORMAL if alert.acknowledged else AlertState.AWAITING_ACKNOWLEDGE
    if alert.acknowledged:
        return AlertState.ACKNOWLEDGED
    return AlertState.ACTIVE if alert.silenced_until is None else AlertState.SILENCED


def _yes(holds: bool) -> YesNoBit:
    return YesNoBit.YES if holds else YesNoBit.NO
