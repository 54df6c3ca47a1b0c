"""The `$PARP` family: what stations and concentrator say to each other about steering.

```
$PARP,STATUS,<mode>,<setpoint>,<heading>,<rudder>,<commander>   concentrator, 2 Hz and after every change
$PARP,CMDTRANSFER,<from>,<to>                                   concentrator, command has passed
$PARP,CMDREQUEST,<station>                                      concentrator, a station asks for command
$PARP,<COMMAND>,<parameter>,<station>                           station
$PARP,RELCMD|ACKCMD|DENYCMD,<requester>                         station, short form
```
Source: spec/boat.md, `$PARP` sent and received. A sentence without a right check sum is nothing, and a
command is taken to the letter or not at all: no blank, lower case, exponent, plus sign or field too many.
"""

import re
from enum import StrEnum
from functools import lru_cache

import msgspec

from timonel.errors import EncodeError
from timonel.nmea0183.checksum import ENDINGS, Fault, checksum, seal, verify

TURN = 3600
"""Tenths of a degree in a full turn; set points are counted in these."""


class PilotMode(StrEnum):
    STANDBY = "STANDBY"
    HEADING_HOLD = "HEADING_HOLD"
    TRACK = "TRACK"
    ALARM = "ALARM"


class Verb(StrEnum):
    """The command words."""

    ENGAGE = "ENGAGE"
    DISENGAGE = "DISENGAGE"
    SETHEADING = "SETHEADING"
    PORTONE = "PORTONE"
    STBDONE = "STBDONE"
    PORTTEN = "PORTTEN"
    STBDTEN = "STBDTEN"
    REQCMD = "REQCMD"
    RELCMD = "RELCMD"
    TAKECMD = "TAKECMD"
    ACKCMD = "ACKCMD"
    DENYCMD = "DENYCMD"


class Command(msgspec.Struct, frozen=True, gc=False):
    """One command of a station.

    `station` is who says so; None in the short form, where `requester` names the station that had asked for
    command. `heading_tenths` is SETHEADING's heading in tenths of a degree, 0..3599; None for all others,
    whose parameter means nothing.
    """

    verb: Verb
    station: int | None = None
    requester: int | None = None
    heading_tenths: int | None = None


class Status(msgspec.Struct, frozen=True, gc=False):
    """The pilot's state and who is in command (0 is nobody). A value is None where it is not known.

    A mode word that is not listed gives `mode` None, never STANDBY, and is kept in `mode_text`.
    """

    mode: PilotMode | None
    mode_text: str
    setpoint_deg: float | None
    heading_deg: float | None
    rudder_deg: float | None
    commander: int


class CommandTransferred(msgspec.Struct, frozen=True, gc=False):
    """Command has passed from `previous` to `commander`; 0 is nobody."""

    previous: int
    commander: int


class CommandRequested(msgspec.Struct, frozen=True, gc=False):
    """`station` asks the commander for command."""

    station: int


Report = Status | CommandTransferred | CommandRequested

_VERBS = {verb.value.encode(): verb for verb in Verb}
_SHORT = frozenset({Verb.RELCMD, Verb.ACKCMD, Verb.DENYCMD})
_NUMBERS = ("00", "01", "02", "03", "04")
_STATIONS = {b"01": 1, b"02": 2, b"03": 3, b"04": 4}
_COMMANDERS = {b"00": 0, **_STATIONS}
_MODES = {mode.value.encode(): mode for mode in PilotMode}
_STANDBY = PilotMode.STANDBY
_SETHEADING = Verb.SETHEADING

# Every sentence of these is waited for, so it is put together of parts that are printed already. A check sum is the
# XOR of the parts' check sums, which stand beside them.
Part = tuple[bytes, int]

_PRINTED = tuple(b"%03d.%d" % (whole, tenth) for whole in range(360) for tenth in range(10))
_PRINTED_SUMS = bytes(
    whole ^ tenth for whole in [checksum(b"%03d." % whole) for whole in range(360)] for tenth in b"0123456789"
)
_TENTHS = {text: tenths for tenths, text in enumerate(_PRINTED)}
_STATUS_BEGINNINGS: dict[PilotMode | None, Part] = {
    mode: (b"$" + body, checksum(body))
    for mode, body in ((mode, f"PARP,STATUS,{mode or ''},".encode()) for mode in (None, *PilotMode))
}
_STATUS_ENDS: tuple[Part, ...] = tuple((b"," + text, checksum(b",,," + text)) for text in _COMMANDERS)
_SET_HEADING = b"$PARP,SETHEADING,"
_SET_BY: dict[bytes, tuple[int, int]] = {
    b"," + text: (station, checksum(_SET_HEADING[1:] + b"," + text)) for text, station in _STATIONS.items()
}


class _Printed(dict[str, Part]):
    """Texts as they are met, as parts."""

    def __missing__(self, text: str) -> Part:
        part = self[text] = (text.encode(), checksum(text.encode()))
        return part


_RUDDERS = _Printed()  # 7,201 at most

_PARAMETER = re.compile(rb"(-?)([0-9]{1,4})(?:\.([0-9]{1,4}))?")
_DEGREES = re.compile(rb"[0-9]{1,3}(?:\.[0-9]{1,4})?")
_RUDDER = re.compile(rb"[+-]?[0-9]{1,3}(?:\.[0-9]{1,4})?")
_MODE_WORD = re.compile(rb"[A-Z_]{0,20}")


def status(
    mode: PilotMode | None,
    setpoint_tenths: int | None,
    heading_deg: float | None,
    rudder_deg: float | None,
    commander: int,
) -> bytes:
    """The STATUS sentence. None leaves a field empty; in STANDBY the set point is `000.0` whatever it is.

    Heading and set point are normalised modulo 360, the rudder is positive to starboard. Raises EncodeError
    for a number that is not finite and for a commander outside 0..4.
    """
    beginning, total = _STATUS_BEGINNINGS[mode]
    setpoint = heading = rudder = b""
    if mode is _STANDBY:
        setpoint_tenths = 0
    if setpoint_tenths is not None:
        setpoint_tenths %= TURN
        setpoint = _PRINTED[setpoint_tenths]
        total ^= _PRINTED_SUMS[setpoint_tenths]
    if heading_deg is not None:
        heading_tenths = _tenths(heading_deg, "STATUS.heading") % TURN
        heading = _PRINTED[heading_tenths]
        total ^= _PRINTED_SUMS[heading_tenths]
    if rudder_deg is not None:
        rudder, rudder_sum = _RUDDERS[_rudder(rudder_deg)]
        total ^= rudder_sum
    if not 0 <= commander <= 4:
        raise _outside(commander, 0)
    end, end_sum = _STATUS_ENDS[commander]
    return b"%b%b,%b,%b%b%b" % (beginning, setpoint, heading, rudder, end, ENDINGS[total ^ end_sum])


def cmdtransfer(previous: int, commander: int) -> bytes:
    """The sentence that command has passed; 0 is nobody. Raises EncodeError for a station outside 0..4."""
    return seal(f"PARP,CMDTRANSFER,{_station(previous, 0)},{_station(commander, 0)}")


def cmdrequest(station: int) -> bytes:
    """The sentence that `station` asks for command. Raises EncodeError for a station outside 1..4."""
    return seal(f"PARP,CMDREQUEST,{_station(station, 1)}")


def command(verb: Verb, station: int, parameter: float = 0.0) -> bytes:
    """A station's command. SETHEADING's `parameter` is degrees, normalised modulo 360; others have 0.0.

    Raises EncodeError for a parameter that is not finite and for a station outside 1..4.
    """
    text = _PRINTED[_tenths(parameter, f"{verb}.parameter") % TURN].decode()
    return seal(f"PARP,{verb},{text},{_station(station, 1)}")


def read_command(sentence: bytes) -> Command | Fault:
    """The command of one framed sentence, or why it is none."""
    if sentence.startswith(_SET_HEADING) and (command := _set_heading(sentence)) is not None:
        return command
    return _read_command(sentence)


def _set_heading(sentence: bytes) -> Command | None:
    """The command of a SETHEADING as `command` writes it; None for one in other words, or none at all."""
    tenths, by = _TENTHS.get(sentence[17:22]), _SET_BY.get(sentence[22:25])
    if tenths is None or by is None:
        return None
    station, total = by
    if sentence[25:] != ENDINGS[total ^ _PRINTED_SUMS[tenths]][:3]:
        return None
    return Command(_SETHEADING, station, None, tenths)


# A head says the same dozen sentences over and over, and each is waited for.
@lru_cache(maxsize=1024)
def _read_command(sentence: bytes) -> Command | Fault:
    body = verify(sentence)
    if not isinstance(body, bytes):
        return body
    return parse_command(body) if sentence[:1] == b"$" else Fault.MALFORMED


def parse_command(body: bytes) -> Command | Fault:
    """The command of a sentence's body, whose check sum was right."""
    match body.split(b","):
        case [b"PARP", word, parameter, station]:
            return _full(word, parameter, station)
        case [b"PARP", word, requester]:
            return _short(word, requester)
        case [b"PARP", word, *_] if word in _VERBS:
            return Fault.MALFORMED
        case [b"PARP", *_]:
            return Fault.UNKNOWN_COMMAND
    return Fault.UNKNOWN_SENTENCE


def read_report(sentence: bytes) -> Report | Fault:
    """What the concentrator says in one framed sentence, or why it is nothing."""
    body = verify(sentence)
    if not isinstance(body, bytes):
        return body
    return parse_report(body) if sentence[:1] == b"$" else Fault.MALFORMED


def parse_report(body: bytes) -> Report | Fault:
    """What the concentrator says in a sentence's body, whose check sum was right."""
    try:
        match body.split(b","):
            case [b"PARP", b"STATUS", *values] if len(values) == 5:
                return _status(*values)
            case [b"PARP", b"CMDTRANSFER", previous, commander]:
                return CommandTransferred(_COMMANDERS[previous], _COMMANDERS[commander])
            case [b"PARP", b"CMDREQUEST", station]:
                return CommandRequested(_STATIONS[station])
            case [b"PARP", b"STATUS" | b"CMDTRANSFER" | b"CMDREQUEST", *_]:
                return Fault.MALFORMED
    except (ValueError, KeyError):
        return Fault.MALFORMED
    return Fault.UNKNOWN_SENTENCE


def _full(word: bytes, parameter: bytes, station: bytes) -> Command | Fault:
    verb = _VERBS.get(word)
    if verb is None:
        return Fault.UNKNOWN_COMMAND
    number = _PARAMETER.fullmatch(parameter)
    if station not in _STATIONS or (parameter and number is None):
        return Fault.MALFORMED
    if verb is not Verb.SETHEADING:
        return Command(verb, station=_STATIONS[station])
    if number is None:
        return Fault.MALFORMED
    return Command(verb, station=_STATIONS[station], heading_tenths=_normalised(*number.groups(b"")))


def _short(word: bytes, requester: bytes) -> Command | Fault:
    verb = _VERBS.get(word)
    if verb is None:
        return Fault.UNKNOWN_COMMAND
    if verb not in _SHORT or requester not in _STATIONS:
        return Fault.MALFORMED
    return Command(verb, requester=_STATIONS[requester])


def _normalised(sign: bytes, whole: bytes, fraction: bytes) -> int:
    """Tenths of a degree 0..3599 of a decimal number: rounded first, then wrapped, so never 3600."""
    ten_thousandths = int(whole + fraction.ljust(4, b"0"))
    return round((-ten_thousandths if sign else ten_thousandths) / 1000) % TURN


def _status(mode: bytes, setpoint: bytes, heading: bytes, rudder: bytes, commander: bytes) -> Status:
    if not _MODE_WORD.fullmatch(mode):
        raise ValueError
    return Status(
        mode=_MODES.get(mode),
        mode_text=mode.decode("ascii"),
        setpoint_deg=_number(_DEGREES, setpoint),
        heading_deg=_number(_DEGREES, heading),
        rudder_deg=_number(_RUDDER, rudder),
        commander=_COMMANDERS[commander],
    )


def _number(grammar: re.Pattern[bytes], text: bytes) -> float | None:
    if not text:
        return None
    if grammar.fullmatch(text):
        return float(text)
    raise ValueError


def _tenths(degrees: float, label: str) -> int:
    """`degrees` in tenths, rounded to nearest, not yet wrapped."""
    if abs(degrees) < 1e9:
        return round(degrees * 10)
    raise EncodeError(f"{label}: {degrees} is not an angle")


def _rudder(degrees: float) -> str:
    if abs(degrees) <= 360.0:
        return f"{degrees:+z.1f}"
    raise EncodeError(f"STATUS.rudder: {degrees} is outside -360..360")


def _station(number: int, lowest: int) -> str:
    if lowest <= number <= 4:
        return _NUMBERS[number]
    raise _outside(number, lowest)


def _outside(station: int, lowest: int) -> EncodeError:
    return EncodeError(f"station: {station} is outside {lowest}..4")
