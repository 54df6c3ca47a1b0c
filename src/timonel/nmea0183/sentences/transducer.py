"""Measurements of all kinds, several in one sentence."""

import re
from typing import Self

import msgspec

from timonel.errors import EncodeError
from timonel.nmea0183.checksum import LONGEST, seal
from timonel.nmea0183.fields import escaped, text_of
from timonel.nmea0183.sentence import Sentence

_DECIMALS = 5


class Transducer(msgspec.Struct, frozen=True, gc=False):
    """One measurement: `kind` (A angle, C temperature, P pressure ...), `unit` (D, C, B ...) and a name.

    A value is written with at most five decimals and no trailing zeros: round it to what it is worth.
    """

    kind: str | None = None
    value: float | None = None
    unit: str | None = None
    name: str | None = None


class XDR(Sentence, frozen=True):
    """Transducer measurements."""

    transducers: tuple[Transducer, ...] = ()

    def encode(self, talker: str = "II") -> bytes:
        if not self.transducers:
            raise EncodeError("XDR.transducers: at least one is needed")
        return seal(f"{talker}XDR,{','.join(map(_text, self.transducers))}")

    @classmethod
    def read(cls, wires: list[bytes]) -> Self | None:
        groups = zip(*(iter(wires),) * 4, strict=True)
        try:
            return cls(tuple(_transducer(*group) for group in groups))
        except ValueError:
            return None


def split(transducers: list[Transducer], talker: str = "II") -> list[XDR]:
    """As few sentences as hold `transducers` in order, each within 82 characters."""
    room = LONGEST - len(f"${talker}XDR*hh\r\n")
    sentences: list[list[Transducer]] = []
    left = 0
    for transducer in transducers:
        needed = len(_text(transducer)) + 1
        if needed > left:
            sentences.append([])
            left = room
        sentences[-1].append(transducer)
        left -= needed
    return [XDR(tuple(group)) for group in sentences]


def _transducer(kind: bytes, value: bytes, unit: bytes, name: bytes) -> Transducer:
    return Transducer(
        text_of(kind) if kind else None,
        float(value) if value else None,
        text_of(unit) if unit else None,
        text_of(name) if name else None,
    )


def _text(transducer: Transducer) -> str:
    texts = (transducer.kind, _number(transducer.value), transducer.unit, transducer.name)
    return ",".join(escaped(text, "XDR") if text else "" for text in texts)


def _number(value: float | None) -> str:
    if value is None:
        return ""
    if not abs(value) < 1e9:
        raise EncodeError(f"XDR.value: {value} is outside -1e9..1e9")
    return re.sub(r"\.?0+$", "", f"{value:z.{_DECIMALS}f}")
