"""What goes through a gateway, counted for people to look at: told the time, without a terminal."""

import logging
from collections import Counter, deque
from collections.abc import Sequence
from enum import IntEnum, IntFlag
from math import degrees

import msgspec

from timonel.core.alerts import Alert, AlertChanged
from timonel.core.effects import Effect, Event, Say, Transmit
from timonel.core.fields import Number
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.gateway.health import describe, level
from timonel.nmea0183 import parp
from timonel.nmea2000 import registry
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split

WINDOW = 5  # seconds that a rate is averaged over
EVENTS_KEPT = 100
IMPORTANT = (
    127250, 127245, 127237, 127251, 129025, 129026, 128259, 128267, 130306, 127257, 130316, 130312,
    128275, 127258, 129029, 126992,
)  # fmt: skip
IMPORTANT_SENTENCES = (
    "STATUS",
    "HDT",
    "ROT",
    "RMC",
    "VHW",
    "DPT",
    "MWV",
    "GLL",
    "MTW",
    "RSA",
    "CMDTRANSFER",
    "CMDREQUEST",
    "ALR",
)
SPOKEN = {
    "rad": (degrees, "°", 1),
    "rad/s": (lambda value: degrees(value) * 60, "°/min", 1),
    "m/s": (lambda value: value * 3600 / 1852, " kn", 1),
    "K": (lambda value: value - 273.15, " °C", 1),
    "Pa": (lambda value: value / 100, " hPa", 0),
    "deg": (float, "°", 5),
}
"""Units for the eye: how to come to them, what they are called, and how many decimals they deserve."""
UNSPOKEN = ("sid", "instance", "reserved", "spare", "date", "time", "age")


class Meter:
    """Events a second, over the last whole seconds."""

    def __init__(self) -> None:
        self._began: float | None = None
        self._seconds: deque[list[int]] = deque(maxlen=WINDOW + 1)

    def count(self, now: float, events: int = 1) -> None:
        if self._began is None:
            self._began = now
        if self._seconds and self._seconds[-1][0] == int(now):
            self._seconds[-1][1] += events
        else:
            self._seconds.append([int(now), events])

    def rate(self, now: float) -> float:
        """0 before the first second is over."""
        if self._began is None:
            return 0.0
        first = max(int(now) - WINDOW, int(self._began) + 1)
        events = sum(events for second, events in self._seconds if first <= second < int(now))
        return events / max(1, int(now) - first)


class Heard(msgspec.Struct):
    """One kind of message or sentence: how often it comes and what the last one was, and when."""

    name: str
    meter: Meter
    last: bytes = b""
    at: float = 0.0

    def take(self, last: bytes, now: float) -> None:
        self.meter.count(now)
        self.last, self.at = last, now


class Told(msgspec.Struct):
    """An event in words; `times` it came in a row, the last time at `at` (s)."""

    text: str
    severity: int
    at: float
    times: int = 1


class Traffic:
    """An observer of the gateway. What comes once a frame only counts and keeps; reading is for those who look."""

    def __init__(self) -> None:
        self.frames_in = Meter()
        self.frames_out = Meter()
        self.lines_out = Meter()
        self.messages: dict[int, Heard] = {}
        self.sentences: dict[str, Heard] = {}
        self.ports: dict[str, bool] = {}
        self.status: parp.Status | None = None
        self.alerts: dict[int, Alert] = {}
        self.events: deque[Told] = deque(maxlen=EVENTS_KEPT)
        self._reassembler = Reassembler()

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        """Frames came in from the bus."""
        self.frames_in.count(now, len(frames))
        for frame in frames:
            pgn = split(frame.identifier).pgn
            fast = registry.is_fast(pgn)
            data = self._reassembler.receive(frame.identifier, frame.data, now) if fast else frame.data
            if data is not None:
                self._message(pgn).take(data, now)

    def _message(self, pgn: int) -> Heard:
        heard = self.messages.get(pgn)
        if heard is None:
            heard = self.messages[pgn] = Heard(_name(pgn), Meter())
        return heard

    def effect(self, effect: Effect, now: float) -> None:
        """The gateway said, sent or noticed something."""
        match effect:
            case Say():
                self._say(effect.line, now)
            case Transmit():
                self.frames_out.count(now)
            case AlertChanged(alert=alert):
                self._alert(alert)
                self._tell(effect, now)
            case Event():
                self._tell(effect, now)

    def _say(self, line: bytes, now: float) -> None:
        self.lines_out.count(now)
        name = _formatter(line)
        if name not in self.sentences:
            self.sentences[name] = Heard(name, Meter())
        self.sentences[name].take(line.rstrip(), now)
        if name == "STATUS":
            report = parp.read_report(line.rstrip())
            self.status = report if isinstance(report, parp.Status) else self.status

    def _alert(self, alert: Alert) -> None:
        if alert.active or not alert.acknowledged:
            self.alerts[alert.kind.id] = alert
        else:
            self.alerts.pop(alert.kind.id, None)

    def _tell(self, event: Event, now: float) -> None:
        severity = level(event)
        if severity <= logging.DEBUG:
            return
        text = describe(event)
        if self.events and self.events[-1].text == text:
            self.events[-1].times += 1
            self.events[-1].at = now
        else:
            self.events.append(Told(text, severity, now))

    def port(self, name: str, connected: bool, now: float) -> None:
        """A link came or went."""
        self.ports[name] = connected

    def messages_by_importance(self) -> list[tuple[int, Heard]]:
        """The messages: those a helmsman asks for first, then by PGN."""
        return sorted(self.messages.items(), key=lambda item: (_rank(IMPORTANT, item[0]), item[0]))

    def sentences_by_importance(self) -> list[Heard]:
        """The sentences: those a helmsman asks for first, then as they came."""
        return sorted(self.sentences.values(), key=lambda heard: _rank(IMPORTANT_SENTENCES, heard.name))


def _rank(important: tuple[object, ...], name: object) -> int:
    return important.index(name) if name in important else len(important)


def _name(pgn: int) -> str:
    variants = registry.MESSAGES.get(pgn, ())
    names = Counter(variant.__name__ for variant in variants)
    return words(next(iter(names))) if len(names) == 1 else f"PGN {pgn}"


def words(name: str) -> str:
    """`VesselHeading` as `Vessel heading`."""
    text = "".join(f" {letter.lower()}" if letter.isupper() else letter for letter in name)
    return text.strip().capitalize()


def _formatter(line: bytes) -> str:
    """What a sentence is called: its formatter, or the second field of a `$PARP`."""
    address, _, rest = line[1:].partition(b",")
    word = rest.partition(b",")[0] if address == b"PARP" else address[2:]
    return word.decode("ascii", "replace")


def spoken(pgn: int, data: bytes) -> str:
    """The values of a message in units for the eye; what is not available is left out."""
    message = registry.decode(pgn, data)
    if message is None:
        return data.hex(" ")
    return "  ".join(_values(message)) or "nothing available"


def _values(message: Message) -> list[str]:
    """Name and value of each field, numbers first; an answer of `no` is not worth its place."""
    units = {slot.name: slot.field.unit for slot in message.layout if isinstance(slot.field, Number)}
    values = {name: getattr(message, name) for name in message.__struct_fields__ if not name.startswith(UNSPOKEN)}
    names = sorted(
        (name for name in values if values[name] is not None), key=lambda name: isinstance(values[name], IntEnum)
    )
    texts = ((name.replace("_", " "), _value(values[name], units.get(name, ""))) for name in names)
    return [f"{name} {text}" for name, text in texts if text != "no"]


def _value(value: object, unit: str) -> str:
    match value:
        case IntEnum() | IntFlag():
            return (value.name or str(value.value)).replace("_", " ").lower()
        case int() | float() if unit in SPOKEN:
            convert, name, decimals = SPOKEN[unit]
            return f"{convert(value):.{decimals}f}{name}"
        case float():
            return f"{value:.6g} {unit}".rstrip()
        case _:
            return f"{value} {unit}".rstrip()
