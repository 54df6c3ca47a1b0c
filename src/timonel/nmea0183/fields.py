"""The kinds of fields a sentence is declared with, and the lines of code each of them becomes.

A kind covers one or more comma-separated fields (`wires`) and one attribute. `read` and `write` return
Python statements; `sentence.py` joins them to one parser and one writer a sentence type. In the statements of
`read`, `ValueError` and `KeyError` mean a malformed field. Empty fields are None in both directions.
"""

import datetime
import re
from enum import StrEnum
from functools import lru_cache

import msgspec

from timonel.errors import EncodeError

# float() and int() take more than a number of the standard: blanks, `_`, `+`, exponents, `nan`, `inf`. The
# characters these are made of are moved out of ASCII before a sentence is split, so that they cannot.
_GUARDED = b"eEnN_+ \t\n\r\v\f"
GUARD = bytes(byte | 0x80 if byte in _GUARDED else byte for byte in range(256))
_UNGUARD = bytes(byte & 0x7F for byte in range(256))

_RESERVED = re.compile(r"[!$*,\\^~]|[^ -~]")
_MINUTES = tuple(f"{hour:02d}{minute:02d}" for hour in range(24) for minute in range(60))
_MINUTE_OF_DAY = {text.encode(): minute for minute, text in enumerate(_MINUTES)}

_ESCAPE = re.compile(r"\^([0-9A-Fa-f]{2})")


class Field(msgspec.Struct, frozen=True):
    """Base of all kinds."""

    @property
    def wires(self) -> int:
        """How many comma-separated fields the kind covers."""
        return 1

    @property
    def names(self) -> dict[str, object]:
        """What the statements refer to besides the functions of this module."""
        return {}

    @property
    def notation(self) -> str:
        """The fields as the standard writes them, for the documentation."""
        raise NotImplementedError

    def read(self, wire: list[str], out: str) -> str:
        """Statements that set the variable `out` from the variables `wire`."""
        raise NotImplementedError

    def write(self, value: str, out: str, label: str) -> str:
        """Statements that set the variable `out` to the fields' text, commas first, from `value`."""
        raise NotImplementedError


def guarded(letter: str) -> bytes:
    """`letter` as it looks in a guarded sentence."""
    return letter.encode().translate(GUARD)


def out_of_range(label: str, value: float, low: float, high: float) -> EncodeError:
    return EncodeError(f"{label}: {value} is outside {low:g}..{high:g}")


class Number(Field, frozen=True):
    """A decimal number `low`..`high` and, if it has one, the letter of its unit in the field behind it.

    The letter is written beside an empty value too (some readers tell old formats by it), unless `keep_unit`
    is off; it may be empty when read, but not another one. Above `ceiling` that is written (RMB). An
    `optional` number is the last field and left out when None.
    """

    decimals: int
    low: float
    high: float
    unit: str = ""
    keep_unit: bool = True
    ceiling: float | None = None
    optional: bool = False

    @property
    def wires(self) -> int:
        return 2 if self.unit else 1

    @property
    def notation(self) -> str:
        number = "x." + "x" * self.decimals if self.decimals else "x"
        return f"{number},{self.unit}" if self.unit else number

    def read(self, wire: list[str], out: str) -> str:
        check = f"if {wire[1]} and {wire[1]} != {guarded(self.unit)!r}: raise ValueError" if self.unit else ""
        return f"""
if {wire[0]}:
    {out} = float({wire[0]})
    if not {self.low} <= {out} <= {self.high}: raise ValueError
else:
    {out} = None
{check}"""

    def write(self, value: str, out: str, label: str) -> str:
        unit = f",{self.unit}" if self.unit else ""
        empty = "" if self.optional else "," + (unit if self.keep_unit else "," * len(unit[:1]))
        limited = value if self.ceiling is None else f"min({value}, {self.ceiling})"
        return f"""
if {value} is None: {out} = {empty!r}
elif {self.low} <= {value} <= {self.high}: {out} = f",{{{limited}:z.{self.decimals}f}}{unit}"
else: raise out_of_range({label!r}, {value}, {self.low}, {self.high})"""


class Angle(Number, frozen=True):
    """A direction 0..360 degrees. One that rounds to 360.0 is written 0.0."""

    decimals: int = 1
    low: float = 0.0
    high: float = 360.0

    def write(self, value: str, out: str, label: str) -> str:
        unit = f",{self.unit}" if self.unit else ""
        full, zero = (f",{turn:.{self.decimals}f}{unit}" for turn in (360, 0))
        return super().write(value, out, label) + f"\nif {out} == {full!r}: {out} = {zero!r}"


class Signed(Field, frozen=True):
    """A magnitude and the letter of its direction: one number, positive towards `positive`.

    A magnitude without a letter is not available. `unit` may follow as in `Number`.
    """

    decimals: int
    high: float
    positive: str
    negative: str
    unit: str = ""
    ceiling: float | None = None

    @property
    def wires(self) -> int:
        return 3 if self.unit else 2

    @property
    def notation(self) -> str:
        unit = f",{self.unit}" if self.unit else ""
        return f"x.{'x' * self.decimals},{self.positive}/{self.negative}{unit}"

    def read(self, wire: list[str], out: str) -> str:
        check = f"if {wire[2]} and {wire[2]} != {guarded(self.unit)!r}: raise ValueError" if self.unit else ""
        return f"""
if {wire[0]} and {wire[1]}:
    {out} = float({wire[0]})
    if not 0.0 <= {out} <= {self.high}: raise ValueError
    if {wire[1]} == {guarded(self.negative)!r}: {out} = 0.0 - {out}
    elif {wire[1]} != {guarded(self.positive)!r}: raise ValueError
else:
    if {wire[0]}: float({wire[0]})
    {out} = None
{check}"""

    def write(self, value: str, out: str, label: str) -> str:
        unit = f",{self.unit}" if self.unit else ""
        magnitude = f"abs({value})" if self.ceiling is None else f"min(abs({value}), {self.ceiling})"
        positive, negative = (f",{letter}{unit}" for letter in (self.positive, self.negative))
        zero = f",{0:.{self.decimals}f}"
        return f"""
if {value} is None: {out} = {",," + unit!r}
elif {-self.high} <= {value} <= {self.high}:
    {out} = f",{{{magnitude}:.{self.decimals}f}}"
    {out} += {negative!r} if {value} < 0 and {out} != {zero!r} else {positive!r}
else: raise out_of_range({label!r}, {value}, {-self.high}, {self.high})"""


class Position(Field, frozen=True):
    """`ddmm.mmmmmm` and a hemisphere: signed degrees. Six decimals of a minute keep 1e-7 degrees and more."""

    limit: int
    positive: str
    negative: str

    @property
    def wires(self) -> int:
        return 2

    @property
    def notation(self) -> str:
        return f"{'d' * len(str(self.limit))}mm.mmmmmm,{self.positive}/{self.negative}"

    def read(self, wire: list[str], out: str) -> str:
        return f"""
if {wire[0]} and {wire[1]}:
    {out} = degrees_of({wire[0]}, {float(self.limit)})
    if {wire[1]} == {guarded(self.negative)!r}: {out} = 0.0 - {out}
    elif {wire[1]} != {guarded(self.positive)!r}: raise ValueError
else:
    if {wire[0]}: float({wire[0]})
    {out} = None"""

    def write(self, value: str, out: str, label: str) -> str:
        point = len(str(self.limit)) + 3
        one = 10 ** (point + 5)
        return f"""
if {value} is None: {out} = ",,"
elif {-self.limit} <= {value} <= {self.limit}:
    micro = round({value} * 60e6)
    if micro < 0: micro = -micro; hemisphere = ",{self.negative}"
    else: hemisphere = ",{self.positive}"
    digits = str(micro + micro // 60000000 * 40000000 + {one})
    {out} = f",{{digits[1:{point}]}}.{{digits[{point}:]}}{{hemisphere}}"
else: raise out_of_range({label!r}, {value}, {-self.limit}, {self.limit})"""


def degrees_of(text: bytes, limit: float) -> float:
    """Degrees of `dddmm.mmmm`. Some senders leave out leading zeros; the minutes stand before the point."""
    value = float(text)
    degrees = value // 100.0
    minutes = value - degrees * 100.0
    result = degrees + minutes / 60.0
    if minutes < 60.0 and 0.0 <= result <= limit:
        return result
    raise ValueError


class TimeOfDay(Field, frozen=True):
    """UTC `hhmmss` or `hhmmss.ss`: seconds of the day, a fraction only where there is one.

    A leap second is 86400.0 up to 86401.0. Rounding never carries into the next day.
    """

    @property
    def notation(self) -> str:
        return "hhmmss.ss"

    def read(self, wire: list[str], out: str) -> str:
        return f"{out} = seconds_of({wire[0]}) if {wire[0]} else None"

    def write(self, value: str, out: str, label: str) -> str:
        return f"""
if {value} is None: {out} = ","
elif 0.0 <= {value} < 86401.0: {out} = "," + clock_text({value})
else: raise out_of_range({label!r}, {value}, 0, 86401)"""


def seconds_of(text: bytes) -> float:
    """Seconds of the day from `hhmmss` or `hhmmss.ss`."""
    minute, second = _MINUTE_OF_DAY[text[:4]], float(text[4:])
    if len(text) < 6 or not text[4:6].isdigit() or text[6:7] not in b"." or second >= 60.0 + (minute == 1439):
        raise ValueError
    return minute * 60 + second


def clock_text(seconds: float) -> str:
    """`hhmmss` or `hhmmss.ss` of the day's seconds, 0 up to 86401."""
    hundredths = round(seconds * 100.0)
    if hundredths >= 8640000:
        return _last_minute_text(seconds, hundredths)
    minute, rest = divmod(hundredths, 6000)
    digits = str(10000 + rest)
    return _MINUTES[minute] + digits[1:3] + ("." + digits[3:] if rest % 100 else "")


def _last_minute_text(seconds: float, hundredths: int) -> str:
    if seconds < 86400.0:
        return "235959.99"
    fraction = min(hundredths - 8640000, 99)
    return f"235960.{fraction:02d}" if fraction else "235960"


class Date(Field, frozen=True):
    """`ddmmyy`; the years are 1980..2079, for GPS time begins in 1980."""

    @property
    def notation(self) -> str:
        return "ddmmyy"

    def read(self, wire: list[str], out: str) -> str:
        return f"{out} = date_of({wire[0]}) if {wire[0]} else None"

    def write(self, value: str, out: str, label: str) -> str:
        return f"""
if {value} is None: {out} = ","
elif 1980 <= {value}.year <= 2079:
    {out} = date_text({value})
else: raise out_of_range({label!r}, {value}.year, 1980, 2079)"""


@lru_cache(maxsize=8)  # a date stays for a day
def date_of(text: bytes) -> datetime.date:
    if len(text) != 6 or not text.isdigit():
        raise ValueError
    year = int(text[4:])
    return datetime.date(year + (1900 if year >= 80 else 2000), int(text[2:4]), int(text[:2]))


@lru_cache(maxsize=8)
def date_text(date: datetime.date) -> str:
    return date.strftime(",%d%m%y")


class Integer(Field, frozen=True):
    """A whole number, written with at least `digits` digits."""

    digits: int
    low: int
    high: int

    @property
    def notation(self) -> str:
        return "x" * self.digits

    def read(self, wire: list[str], out: str) -> str:
        return f"""
if {wire[0]}:
    {out} = int({wire[0]})
    if not {self.low} <= {out} <= {self.high}: raise ValueError
else:
    {out} = None"""

    def write(self, value: str, out: str, label: str) -> str:
        return f"""
if {value} is None: {out} = ","
elif {self.low} <= {value} <= {self.high}: {out} = f",{{{value}:0{{{self.digits} + ({value} < 0)}}d}}"
else: raise out_of_range({label!r}, {value}, {self.low}, {self.high})"""


class Letter(Field, frozen=True):
    """One letter of a list. An unknown one is malformed, or read as `otherwise` where that is given.

    An `optional` one is the last field of newer editions; None leaves it out.
    """

    choices: type[StrEnum]
    otherwise: StrEnum | None = None
    optional: bool = False

    @property
    def names(self) -> dict[str, object]:
        letters = {guarded(letter): letter for letter in self.choices}
        return {f"_{self.choices.__name__}": letters, f"_{self.choices.__name__}_otherwise": self.otherwise}

    @property
    def notation(self) -> str:
        return "/".join(self.choices)

    def read(self, wire: list[str], out: str) -> str:
        table = f"_{self.choices.__name__}"
        known = f"{table}[{wire[0]}]" if self.otherwise is None else f"{table}.get({wire[0]}, {table}_otherwise)"
        return f"{out} = {known} if {wire[0]} else None"

    def write(self, value: str, out: str, label: str) -> str:
        return f'{out} = "," + {value} if {value} else "{"" if self.optional else ","}"'


class Mode(StrEnum):
    """How a position was found (mode indicator). A letter that is not listed is read as `NOT_VALID`."""

    AUTONOMOUS = "A"
    DIFFERENTIAL = "D"
    ESTIMATED = "E"
    MANUAL = "M"
    SIMULATOR = "S"
    PRECISE = "P"
    RTK_FIXED = "R"
    RTK_FLOAT = "F"
    NOT_VALID = "N"


VALID_MODES = frozenset({Mode.AUTONOMOUS, Mode.DIFFERENTIAL, Mode.PRECISE, Mode.RTK_FIXED, Mode.RTK_FLOAT, None})
"""The modes that allow status A; None is a sender older than the mode indicator."""


class Status(Field, frozen=True):
    """`A` is True, any other letter is False.

    With `mode`, the attribute of that name in the same sentence has a say: estimated, manual, simulated and
    invalid positions are never valid, neither read nor written.
    """

    mode: str = ""

    @property
    def notation(self) -> str:
        return "A/V"

    def read(self, wire: list[str], out: str) -> str:
        allowed = f" and {self.mode} in VALID_MODES" if self.mode else ""
        return f"{out} = {wire[0]} == b'A'{allowed} if {wire[0]} else None"

    def write(self, value: str, out: str, label: str) -> str:
        allowed = f" and sentence.{self.mode} in VALID_MODES" if self.mode else ""
        return f'{out} = "," if {value} is None else ",A" if {value}{allowed} else ",V"'


class Text(Field, frozen=True):
    """Printable ISO 8859-1; reserved and accented characters travel as `^hh`."""

    @property
    def notation(self) -> str:
        return "c--c"

    def read(self, wire: list[str], out: str) -> str:
        return f"{out} = text_of({wire[0]}) if {wire[0]} else None"

    def write(self, value: str, out: str, label: str) -> str:
        return f'{out} = "," + escaped({value}, {label!r}) if {value} else ","'


def text_of(wire: bytes) -> str:
    """The text of a guarded field."""
    text = wire.translate(_UNGUARD).decode("ascii")
    if "^" in text:
        text = _ESCAPE.sub(lambda match: chr(int(match[1], 16)), text)
    if text.isprintable():
        return text
    raise ValueError


def escaped(text: str, label: str) -> str:
    """`text` with every character that may not stand in a field as `^hh`."""
    if not text.isprintable() or max(text) > "\xff":
        raise EncodeError(f"{label}: {text!r} is not printable ISO 8859-1")
    return _RESERVED.sub(lambda match: f"^{ord(match[0]):02X}", text)
