"""VDM and VDO: AIS messages in one sentence or several, others' and our own ship's.

```
!--VDM,total,number,group,channel,payload,fill*hh
```
A message of several sentences is put together only from sentences of one group: same talker, formatter, group number
and channel, in order, each within `MAX_AGE` of the one before. What does not fit is dropped and counted; nothing is
joined from two messages that a group number can tell apart.
Source: IEC 61162-1, VDM; ITU-R M.1371-5.
"""

import msgspec

from timonel.nmea0183.checksum import Fault, checksum, verify
from timonel.nmea0183.sixbit import armour, dearmour

LONGEST = 60
"""Characters of payload in one sentence of several, so that it stays within 82."""
MAX_AGE = 2.0  # s; the sentences of one message follow each other on the wire
MOST_SENTENCES = 9
MOST_GROUPS = 32  # that wait for their next sentence

OTHERS, OWN = "VDM", "VDO"


class AisRadio(msgspec.Struct, frozen=True, gc=False):
    """One AIS message: its bits, first bit highest, and how many; the channel it came on, A, B or empty."""

    bits: int
    length: int
    channel: str
    own: bool = False

    @property
    def kind(self) -> int:
        """The number of the message type, 1..27 of those that exist."""
        return self.bits >> self.length - 6 if self.length >= 6 else 0


class _Group(msgspec.Struct):
    total: int
    payload: bytes
    received: int
    heard: float


class VdmReader:
    """Messages out of sentences."""

    def __init__(self) -> None:
        self.lost = 0
        """Sentences whose message never became whole."""
        self._groups: dict[tuple[bytes, ...], _Group] = {}

    def receive(self, sentence: bytes, now: float) -> AisRadio | Fault | None:
        """The message that `sentence` (without its line end) completes; None if it waits for more, or was one too many.

        Never raises.
        """
        body = verify(sentence)
        if isinstance(body, Fault):
            return body
        parts = body.split(b",")
        if len(parts) != 7 or parts[0][2:] not in (b"VDM", b"VDO"):
            return Fault.MALFORMED
        address, total_text, number_text, group, channel, payload, fill_text = parts
        total, number, fill = _digit(total_text), _digit(number_text), _digit(fill_text)
        if not 1 <= number <= total <= MOST_SENTENCES or fill > 5:
            return Fault.MALFORMED
        if total > 1:
            whole = self._joined((address, group, channel), total, number, payload, now)
            if whole is None:
                return None
            payload = whole
        dearmoured = dearmour(payload, fill)
        if dearmoured is None:
            return Fault.MALFORMED
        bits, length = dearmoured
        return AisRadio(bits, length, _CHANNELS.get(channel, ""), address[2:] == b"VDO")

    def _joined(self, key: tuple[bytes, ...], total: int, number: int, payload: bytes, now: float) -> bytes | None:
        group = self._groups.pop(key, None)
        if number == 1:
            self.lost += 0 if group is None else group.received
            self._make_room()
            self._groups[key] = _Group(total, payload, 1, now)
            return None
        if group is None or (group.total, group.received + 1) != (total, number) or now - group.heard > MAX_AGE:
            self.lost += 1 if group is None else 1 + group.received
            return None
        group.payload += payload
        group.received, group.heard = number, now
        if number == total:
            return group.payload
        self._groups[key] = group
        return None

    def _make_room(self) -> None:
        while len(self._groups) >= MOST_GROUPS:
            self.lost += self._groups.pop(next(iter(self._groups))).received


_CHANNELS = {b"A": "A", b"B": "B", b"1": "A", b"2": "B"}


def _digit(text: bytes) -> int:
    """0..9; 10 for anything else, which is too many of everything."""
    return text[0] - 48 if len(text) == 1 and text.isdigit() else 10


class VdmWriter:
    """Sentences out of messages, with a group number that goes round."""

    def __init__(self) -> None:
        self._group = 0

    def sentences(self, message: AisRadio, talker: str = "AI") -> list[bytes]:
        """The sentences of one message, each with check sum and CR LF."""
        payload, fill = armour(message.bits, message.length)
        parts = [payload[at : at + LONGEST] for at in range(0, len(payload), LONGEST)]
        address = f"{talker}{OWN if message.own else OTHERS}"
        if len(parts) == 1:
            return [_sealed(f"{address},1,1,,{message.channel},", payload, fill)]
        group, self._group = self._group, (self._group + 1) % 10
        last = len(parts)
        return [
            _sealed(f"{address},{last},{number},{group},{message.channel},", part, fill if number == last else 0)
            for number, part in enumerate(parts, 1)
        ]


def _sealed(head: str, payload: bytes, fill: int) -> bytes:
    body = b"%s%s,%d" % (head.encode(), payload, fill)
    return b"!%s*%02X\r\n" % (body, checksum(body))
