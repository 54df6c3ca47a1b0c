"""AIS both ways: the messages of a receiver on the backbone as VDM, and VDM of a receiver on a wire as messages.

Each message of PGN 129038, 129039, 129040, 129041, 129793, 129794, 129798, 129802, 129809 and 129810 gives its own
sentence, or several. A ceiling is one for each ship and type of message: ships do not share it. What the backbone has
had within the last `ECHO` seconds is not put there again: two receivers hear the same ships, and what we said
ourselves may come back to us by another way and would go round for ever.
"""

from collections import Counter, OrderedDict
from typing import Any, TypeVar

from timonel.core.effects import Effect, Say
from timonel.core.fields import Bits
from timonel.core.message import Message
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.sixbit import read_text, write_text
from timonel.nmea0183.vdm import OTHERS as OTHER_SHIPS
from timonel.nmea0183.vdm import OWN as OWN_SHIP
from timonel.nmea0183.vdm import AisRadio, VdmReader, VdmWriter
from timonel.nmea2000.lookups import AisTransceiver
from timonel.nmea2000.messages.ais import (
    MMSI,
    AisAidsToNavigationAtonReport,
    AisClassAStaticAndVoyageRelatedData,
    AisClassBStaticDataMsg24PartA,
    AisClassBStaticDataMsg24PartB,
    AisSafetyRelatedBroadcastMessage,
)
from timonel.vehicles.boat.ais_layout import CRAFT_SIZE, KINDS, LAYOUTS, TENDER, TENDERS, Row
from timonel.vehicles.boat.conversion import AIS_RATE
from timonel.vehicles.boat.truth import NEVER

K = TypeVar("K")

ECHO = 10.0  # s
KNOWN = "AIS messages that the backbone had already"
"""From another receiver, or our own that came back."""
NOT_WHOLE = "AIS sentences without the rest of their message"
MOST_SAID = 4096  # messages remembered: a busy harbour has some hundred in ten seconds
STATIC = 24  # the message type that has two parts
PARTS = (AisClassBStaticDataMsg24PartA, AisClassBStaticDataMsg24PartB)
SHORTEST: dict[type[Message], int] = {AisClassAStaticAndVoyageRelatedData: 420, AisClassBStaticDataMsg24PartB: 162}
"""Bits that are enough: some transponders leave out the last, which say nothing."""
LETTERS = {AisAidsToNavigationAtonReport: 34, AisSafetyRelatedBroadcastMessage: 161}
NAME_AT, NAME_LETTERS = 43, 20  # the name of a mark goes on behind the message
IDS: dict[type[Message], tuple[int, ...]] = {
    kind: tuple(number for number, other in KINDS.items() if other is kind) or (STATIC,) for kind in LAYOUTS
}
NOTHING = {kind: {slot.name: 0 for slot in kind.layout if isinstance(slot.field, Bits)} for kind in LAYOUTS}
"""What stands in bits that an AIS message tells nothing about."""
CHANNELS = {"A": AisTransceiver.CHANNEL_A_VDL_RECEPTION, "B": AisTransceiver.CHANNEL_B_VDL_RECEPTION}
OWN_CHANNELS = {"A": AisTransceiver.CHANNEL_A_VDL_TRANSMISSION, "B": AisTransceiver.CHANNEL_B_VDL_TRANSMISSION}
NAMES = {AisTransceiver(number): letter for number, letter in enumerate("ABAB")}
OWN = (*OWN_CHANNELS.values(), AisTransceiver.OWN_INFORMATION_NOT_BROADCAST)


def read(radio: AisRadio, day: int | None = None) -> Message | None:
    """The PGN's message of an AIS message; None for a type that has none, an MMSI that nobody has, or a cut one.

    `day` (since 1970) is today, if it is known: a message of a voyage tells a date without a year.
    """
    kind = _kind(radio)
    if kind is None:
        return None
    rows = LAYOUTS[kind]
    mmsi = radio.bits >> radio.length - 38 & 0x3FFFFFFF
    if rows is CRAFT_SIZE and mmsi in TENDERS:
        rows = TENDER
    if not 0 < mmsi <= MMSI:
        return None
    size = sum(row.bits for row in rows)
    if radio.length < SHORTEST.get(kind, size):
        return None
    bits, length = radio.bits, radio.length
    if length < size:
        bits, length = bits << size - length, size
    values = _fields(rows, bits, length, day)
    if kind in LETTERS:
        values |= _letters(kind, bits, length, size)
    values["ais_transceiver_information"] = _transceiver(radio)
    return kind(**NOTHING[kind] | values)


def _kind(radio: AisRadio) -> type[Message] | None:
    if radio.kind != STATIC:
        return KINDS.get(radio.kind)
    part = radio.bits >> radio.length - 40 & 3 if radio.length >= 40 else 3
    return PARTS[part] if part < len(PARTS) else None


def _fields(rows: tuple[Row, ...], bits: int, length: int, day: int | None) -> dict[str, object]:
    values: dict[str, object] = {}
    for row in rows:
        length -= row.bits
        if row.names:
            raw = bits >> length & (1 << row.bits) - 1
            values.update(zip(row.names, row.read(raw, day), strict=True))
    return values


def _letters(kind: type[Message], bits: int, length: int, size: int) -> dict[str, object]:
    """The text of a warning; the whole name of a mark, which begins within the message and ends behind it."""
    count = min((length - size) // 6, LETTERS[kind])
    rest = bits >> length - size - 6 * count & (1 << 6 * count) - 1
    if kind is AisSafetyRelatedBroadcastMessage:
        return {"safety_related_text": read_text(rest, count)}
    name = bits >> length - NAME_AT - 6 * NAME_LETTERS & (1 << 6 * NAME_LETTERS) - 1
    return {"aton_name": read_text(name << 6 * count | rest, NAME_LETTERS + count)}


def _transceiver(radio: AisRadio) -> AisTransceiver | None:
    if radio.own:
        return OWN_CHANNELS.get(radio.channel, AisTransceiver.OWN_INFORMATION_NOT_BROADCAST)
    return CHANNELS.get(radio.channel)


def write(message: Message) -> AisRadio | None:
    """The AIS message of a PGN's; None if it is none of ours, has another's type, or an MMSI that nobody has."""
    kind = type(message)
    ids = IDS.get(kind)
    if ids is None:
        return None
    mmsi, number, told = _identity(message)
    if number not in ids or not mmsi or mmsi > MMSI:
        return None
    tender = kind is AisClassBStaticDataMsg24PartB and mmsi in TENDERS
    bits = length = 0
    for row in TENDER if tender else LAYOUTS[kind]:
        bits = bits << row.bits | row.write(*[getattr(message, name) for name in row.names])
        length += row.bits
    match message:
        case AisSafetyRelatedBroadcastMessage(safety_related_text=text):
            bits, length = _with_letters(bits, length, text, 0, LETTERS[kind])
        case AisAidsToNavigationAtonReport(aton_name=name):
            bits, length = _with_letters(bits, length, name, NAME_LETTERS, LETTERS[kind])
            bits, length = bits << -length % 8, length - -length % -8
    return AisRadio(bits, length, NAMES.get(told, "") if told is not None else "", told in OWN)


def _identity(message: Any) -> tuple[int | None, int | None, AisTransceiver | None]:
    """MMSI, message type and the receiver's channel."""
    mmsi = message.source_id if type(message) is AisSafetyRelatedBroadcastMessage else message.user_id
    return mmsi, message.message_id, message.ais_transceiver_information


def _with_letters(bits: int, length: int, text: str | None, first: int, most: int) -> tuple[int, int]:
    """The letters of `text` from the `first` on, at most up to `most`, behind the bits."""
    letters = (text or "")[first:most]
    return bits << 6 * len(letters) | write_text(letters, len(letters)), length + 6 * len(letters)


class Ais:
    """Both ways, with what was said lately, so that it is not heard again as somebody else's.

    `counters` has what was not put on the backbone, and why.
    """

    def __init__(self, rate: float = AIS_RATE, counters: Counter[str] | None = None) -> None:
        self._counters: Counter[str] = Counter() if counters is None else counters
        self._interval = 1 / rate if rate > 0 else None
        self._reader = VdmReader()
        self._writer = VdmWriter()
        self._known: OrderedDict[tuple[int, int], float] = OrderedDict()
        self._last: OrderedDict[str, float] = OrderedDict()

    def say(self, message: Message, now: float) -> list[Effect]:
        """What a message heard on the bus gives: one `Say` with all its sentences, which are worthless alone."""
        radio = write(message)
        if radio is None:
            return []
        _remember(self._known, (radio.bits, radio.length), now)
        if self._interval is None:
            return []
        key = f"{OWN_SHIP if radio.own else OTHER_SHIPS},{radio.kind},{_identity(message)[0]}"
        if now - self._last.get(key, NEVER) < self._interval:
            return []
        _remember(self._last, key, now)
        return [Say(b"".join(self._writer.sentences(radio)), key)]

    def hear(self, sentence: bytes, day: int | None, now: float) -> list[Message] | Fault:
        """The messages that a VDM or VDO sentence completes; none for what has no PGN, or is known. Never raises."""
        lost = self._reader.lost
        radio = self._reader.receive(sentence, now)
        if self._reader.lost > lost:
            self._counters[NOT_WHOLE] += self._reader.lost - lost
        if isinstance(radio, Fault):
            return radio
        if radio is None:
            return []
        if now - self._known.get((radio.bits, radio.length), NEVER) < ECHO:
            self._counters[KNOWN] += 1
            return []
        message = read(radio, day)
        return [] if message is None else [message]


def _remember(times: OrderedDict[K, float], key: K, now: float) -> None:
    times[key] = now
    times.move_to_end(key)
    if len(times) > MOST_SAID:
        times.popitem(last=False)
