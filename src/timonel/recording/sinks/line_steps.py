"""How the lines of a message are written by the kernel (`native/page.c`): in steps, one a field. Needs `columns`.

A step says which bits are its value, and how that is told: a number by its digits, anything else of 16 bits or less by
the text that was found for its raw value, text and bytes as they stand. What steps cannot tell (text that is chosen by
another field, floats that are sent as such, fields whose size another field says) has none.
"""

from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from timonel.core.fields import Ascii, Fixed
from timonel.nmea2000 import catalogue_codec as scalar
from timonel.nmea2000.catalogue import Definition, Field, pairs
from timonel.nmea2000.catalogue_layout import (
    Choice,
    Choices,
    Octets,
    OddOctets,
    Place,
    Ranged,
    Real,
    Repeated,
    Run,
    Tail,
    constant,
    plan,
    single,
)
from timonel.recording.decoded import Message, as_json
from timonel.recording.sinks.notation import set_bits

Array = npt.NDArray[Any]

# As in native/page.c.
TEXT, NUMBER, CODE, HEXADECIMAL, ASCII, BITS, GO, COUNT, ITEMS, LAU, LZ, VALUE, UNTOLD = range(13)

_SLACK = 64  # bytes behind the last text
_EXACT = 10**15  # decimals below it are printed as they are
_LONG = 1 << 63
_VALUES = NUMBER, CODE, HEXADECIMAL, ASCII  # of fields whose kind their key tells
_CODE = 16  # bits of a code, at most
_ODD = 57  # of these all are in eight bytes, wherever they begin
_PLACES = 16
_FIRST = 1  # where the first text stands: 0 is none
_OPENING = ', "%s": [{'

_Text = Callable[[int], bytes]


class Step(msgspec.Struct, frozen=True):
    """What is done next; offsets are in bits from where the line is in its payload.

    `need` bits must be there, and the raw value not below `lowest` or above `highest`. Its number is (raw + `add`) *
    `factor` / 10**`places`, which is as well (raw + `add`) / `inverse`, and has 15 digits up to the raw value `most`;
    without places it is raw * `factor` + `add`. `told` makes the text of a code, whose last bit is before `most`.

    Of items `steps` is how many steps they take, `least` how many bytes must be there for one, `most` how many there
    can be, and `counter` which count says how many there are, -1 for none. Otherwise `least` is the size in bytes.
    `announced` makes the step that reads the value behind a key.
    """

    kind: int
    text: bytes = b""
    offset: int = 0
    bits: int = 0
    need: int = 0
    sign: bool = False
    lowest: int = 0
    highest: int = 0
    add: int = 0
    factor: int = 1
    places: int = 0
    inverse: int = 1
    most: int = 0
    steps: int = 0
    least: int = 0
    counter: int = -1
    told: _Text | None = None
    announced: "Callable[[int], Step] | None" = None


class Written(msgspec.Struct, frozen=True):
    """Where the steps of a message are, and what stands before its bytes; `known` if it has fields at all."""

    step: int
    steps: int
    head: int
    head_size: int
    known: bool


class LineSteps:
    """The steps of all messages that were met; without `labels` lookups are numbers.

    `texts` is uint8[n], in which names, heads and labels stand; `slots` uint64[n], where what is known of each code is;
    `steps` int64[n, 18]. They are others once something was added.
    """

    def __init__(self, labels: bool = True) -> None:
        self._flavour = scalar.Flavour(labels, True)
        self._text_end, self._slot_end = _FIRST, 0
        self._steps: list[Step] = []
        self._written: dict[tuple[int, str], Written | None] = {}
        # As in native/page.c.
        self.texts, self.slots = np.zeros(1 << 16, np.uint8), np.zeros(1 << 12, np.uint64)
        self.steps = np.zeros((0, _COLUMNS), np.int64)

    def written(self, pgn: int, definition: Definition | None) -> Written | None:
        """How a message is written; None if not by steps."""
        key = pgn, definition.id if definition else ""
        if key not in self._written:
            self._written[key] = self._made(pgn, definition)
        return self._written[key]

    def learn(self, number: int, code: int) -> None:
        """Find out how a code is written that a step met for the first time."""
        step, slot = self._steps[number], int(self.steps[number, _SLOTS]) + code
        if step.announced is not None:
            self._add([step.announced(code)])
            self.slots[slot] = len(self._steps)
        elif step.told is not None:
            text = step.told(code)
            self.slots[slot] = self._text(text) << _CODE | len(text)

    def _made(self, pgn: int, definition: Definition | None) -> Written | None:
        steps: list[Step] = []
        if definition is not None:
            try:
                steps = list(_Steps(definition, self._flavour).all())
            except _Untold:
                return None
        head = Message(None, 0, 0, 0, pgn, b"", definition).head.encode()
        first = len(self._steps)
        self._add(steps)
        return Written(first, len(steps), self._text(head), len(head), definition is not None)

    def _add(self, steps: list[Step]) -> None:
        rows, at = [], self._text(b"".join(step.text for step in steps))
        for step in steps:
            rows.append(self._row(step, at))
            at += len(step.text)
        self._steps += steps
        self.steps = np.concatenate((self.steps, np.array(rows, np.int64).reshape(-1, _COLUMNS)))

    def _row(self, step: Step, at: int) -> list[int]:
        kind, text, *numbers = msgspec.structs.astuple(step)[:-2]
        slots = self._slot_end
        if step.told is not None or step.announced is not None:
            self._slot_end += 1 << step.bits
            self.slots = _longer(self.slots, self._slot_end)
        row = [kind, at, len(text), *numbers[:_AHEAD], slots, *numbers[_AHEAD:]]
        return [number - (number >= _LONG) * 2 * _LONG for number in row]

    def _text(self, text: bytes) -> int:
        at, self._text_end = self._text_end, self._text_end + len(text)
        self.texts = _longer(self.texts, self._text_end + _SLACK)
        self.texts[at : self._text_end] = np.frombuffer(text, np.uint8)
        return at


_COLUMNS, _SLOTS = 18, 14
_AHEAD = _SLOTS - 3  # numbers between the text and the slots


def _longer(array: Array, size: int) -> Array:
    """The same, with zeros behind it if it is too short."""
    return array if len(array) >= size else np.concatenate((array, np.zeros(size, array.dtype)))


class _Untold(Exception):
    """Steps cannot tell this."""


class _Steps:
    """Makes the steps of a definition."""

    def __init__(self, definition: Definition, flavour: scalar.Flavour) -> None:
        self._definition = definition
        self._flavour = flavour
        self._counters = [group.counter for group in definition.groups]
        self._counted: set[str] = set()
        self._before: Run | None = None  # the part before, if it is one

    def all(self) -> Iterator[Step]:
        """Raises _Untold if steps are not enough."""
        lists = False
        for part in plan(self._definition).parts:
            if isinstance(part, Repeated):
                lists = True
                yield from self._items(part)
            elif lists and (isinstance(part, Tail) or part.values):
                raise _Untold  # lists come last, wherever they are in the payload
            else:
                yield from self._part(part)

    def _part(self, part: Run | Tail) -> Iterator[Step]:
        if isinstance(part, Tail):
            yield self._tail(part.field)
            self._before = None
            return
        if part.conditional:
            raise _Untold
        for place in part.values:
            yield self._field(place, part)
            if place.field.id in self._counters:
                yield self._count(place)
                self._counted.add(place.field.id)
        self._before = part
        yield Step(GO, least=part.size)

    def _items(self, part: Repeated) -> Iterator[Step]:
        if part.packed or (part.group.counter and part.group.counter not in self._counted):
            raise _Untold
        self._before = None
        inside = [step for one in part.parts for step in self._part(one)]
        counter = self._counters.index(part.group.counter) if part.group.counter else -1
        opening = (_OPENING % part.group.name).encode()
        yield Step(ITEMS, opening, most=scalar.EVERYTHING, steps=len(inside), least=part.least, counter=counter)
        yield from inside

    def _field(self, place: Place, run: Run) -> Step:
        field, name = place.field, _name(place.field)
        if field.match is not None:
            value = constant(field) if self._flavour.labels else field.match
            return Step(TEXT, name + as_json(value).encode())
        if field.by and self._flavour.labels:
            return self._paired(place, next(one for one in run.places if one.field.id == field.by))
        return self._of_kind(field, place.kind, place.offset, name)

    def _paired(self, place: Place, by: Place) -> Step:
        """A label that two numbers make: a code of all bits from the first to the last of them."""
        first, end = min(place.offset, by.offset), max(place.offset + place.bits, by.offset + by.bits)
        if end - first > _CODE:
            raise _Untold
        words, name = pairs(place.field.lookup), _name(place.field)

        def told(code: int) -> bytes:
            number, other = (_plain(one, _cut(code, one, first)) for one in (place, by))
            known = {} if other is None else words.get(other, {})
            return b"" if number is None else name + as_json(known.get(number, number)).encode()

        return Step(CODE, name, first, end - first, place.need, most=end, told=told)

    def _of_kind(self, field: Field, kind: Fixed | Ascii, offset: int, name: bytes) -> Step:
        end = offset + kind.bits
        match kind:
            case Ascii():
                return Step(ASCII, name, offset, kind.bits)
            case Octets():
                return Step(HEXADECIMAL, name, offset, kind.bits)
            case OddOctets() if kind.bits <= _ODD:
                return Step(BITS, name, offset, kind.bits, end)
            case Ranged() if number := _number(kind, offset, name):
                return number
            case Real():
                raise _Untold
        if kind.bits > _CODE:
            raise _Untold
        return Step(CODE, name, offset, kind.bits, end, most=end, told=self._told(field, kind, name))

    def _told(self, field: Field, kind: Fixed | Ascii, name: bytes) -> _Text:
        def told(code: int) -> bytes:
            value = _value(field, kind, code, self._flavour)
            return b"" if value is None else name + as_json(value).encode()

        return told

    def _count(self, place: Place) -> Step:
        kind = place.kind
        if not isinstance(kind, Ranged) or (kind.resolution, kind.offset) != (1, 0) or kind.bits > _CODE:
            raise _Untold
        found, counter = kind.range, self._counters.index(place.field.id)
        return Step(COUNT, b"", place.offset, kind.bits, place.need, kind.signed, *found, counter=counter)

    def _tail(self, field: Field) -> Step:
        match field.kind:
            case "STRING_LAU" if not field.length:
                return Step(LAU, _name(field))
            case "STRING_LZ" if not field.length:
                return Step(LZ, _name(field))
            case "DYNAMIC_FIELD_VALUE" if not field.length and self._before is not None:
                return self._value(field, self._before)
        raise _Untold

    def _value(self, field: Field, before: Run) -> Step:
        """A value that its key and its length announce, which stand in the run before it."""
        key, length = scalar.announced_by(self._definition, field)
        places = [place for place in before.values if place.field in (key, length)]
        bits = sum(place.bits for place in places)
        if not places or len(places) != (key is not None) + (length is not None) or bits > _CODE:
            raise _Untold
        first = places[0].offset
        if places[-1].offset + places[-1].bits != first + bits:
            raise _Untold
        keyed = scalar.Keyed(key, length, self._flavour)

        def announced(code: int) -> Step:
            told = {place.field: _plain(place, _cut(code, place, first)) for place in places}
            by = told[key] if key else None, told[length] if length else None
            return self._announced(keyed, *by, _name(field))

        return Step(VALUE, b"", first - 8 * before.size, bits, announced=announced)

    def _announced(self, keyed: scalar.Keyed, key: int | None, length: int | None, name: bytes) -> Step:
        told, size = keyed.told(key), keyed.size(key, length)
        field = None if told is None or size is None else scalar.sized(told, size)
        if field is None:
            bytes_ = scalar.EVERYTHING if size is None else size
            return Step(HEXADECIMAL, name, least=bytes_)
        assert size is not None
        layout = single(field)
        if isinstance(layout, Tail):
            return Step(UNTOLD, name, least=size)
        try:
            made = self._of_kind(field, layout.places[0].kind, 0, name)
        except _Untold:
            return Step(UNTOLD, name, least=size)
        return msgspec.structs.replace(made, kind=made.kind if made.kind in _VALUES else UNTOLD, least=size)


def _name(field: Field) -> bytes:
    return f', "{field.id}": '.encode()


def _cut(code: int, place: Place, first: int) -> int:
    """The bits of a field, of some that begin at `first`."""
    return code >> place.offset - first & (1 << place.bits) - 1


def _plain(place: Place, raw: int) -> int | None:
    """The number that a raw value is."""
    value: int | None = _value(place.field, place.kind, raw, scalar.Flavour(False, False))
    return value


# The decoder of single messages has to be compiled first, which takes longer than to tell the codes of a recording.
def _value(field: Field, kind: Fixed | Ascii, raw: int, flavour: scalar.Flavour) -> Any:
    """What a raw value means; None if that is nothing."""
    match kind:
        case Choice(highest=highest):
            known = field.labels if flavour.labels else {}
            return None if raw > highest else known.get(raw, raw)
        case Choices():
            return set_bits(field, raw) if flavour.labels else raw
    return scalar.value_of(field, flavour)(raw.to_bytes(-(-(field.bits or 0) // 8), "little"), 0)


def _number(kind: Ranged, offset: int, name: bytes) -> Step | None:
    """A number that its digits tell; None if it is not a decimal, or one too long to be told so."""
    lowest, highest = kind.range
    if not kind.signed:
        lowest = max(lowest, 0)
    made = Step(NUMBER, name, offset, kind.bits, offset + kind.bits, kind.signed, lowest, highest)
    if kind.integral:
        factor, add = int(kind.resolution), int(kind.offset)
        least = -_LONG if kind.signed or add else 0
        fits = all(least <= raw * factor + add < least + 2 * _LONG for raw in (lowest, highest))
        return msgspec.structs.replace(made, factor=factor, add=add) if fits else None
    inverse, shift = kind.inverse, kind.shift if kind.offset else 0
    places = next((places for places in range(1, _PLACES + 1) if inverse and not 10**places % inverse), None)
    if not inverse or shift is None or places is None:
        return None
    limit = min(_LONG, _EXACT * inverse)
    if not all(-limit <= number < limit for number in (lowest, highest, lowest + shift, highest + shift)):
        return None
    factor = 10**places // inverse
    most = (_EXACT - 1) // factor
    return msgspec.structs.replace(made, add=shift, factor=factor, places=places, inverse=inverse, most=most)
