"""What all typed sentences have in common: the declaration is the layout, parser and writer come from it.

```python
class HDT(Sentence):
    heading_deg: Annotated[float | None, Angle(unit="T")]
```
The class's name is the formatter. Attributes stand in the order of the fields, in the sentence's own units, and
are None where the field is empty. Parser and writer are written as Python text on first use and compiled; this
is what keeps them within a few microseconds.
"""

from collections.abc import Callable
from textwrap import indent
from typing import Any, Self, get_type_hints

import msgspec

from timonel.nmea0183 import fields
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.fields import Field

Reader = Callable[[list[bytes]], Any]
Writer = Callable[[Any, str], str]


class Sentence(msgspec.Struct, frozen=True, gc=False):
    """Base of all typed sentences."""

    def encode(self, talker: str = "II") -> bytes:
        """The sentence to send, with check sum and CR LF.

        Raises EncodeError for a value outside its field or a sentence of more than 82 characters.
        """
        return seal(_WRITERS[type(self)](self, talker))

    @classmethod
    def read(cls, wires: list[bytes]) -> Self | None:
        """The sentence of the guarded fields behind the address; None if one of them is malformed.

        Fields missing at the end are empty (older editions have fewer), those in excess are not looked at.
        """
        sentence: Self | None = READERS[cls](wires)
        return sentence


def layout(sentence: type[Sentence]) -> dict[str, Field]:
    """The kind of each attribute, in the order of the fields."""
    hints = get_type_hints(sentence, include_extras=True)
    return {name: hints[name].__metadata__[0] for name in sentence.__struct_fields__}


def _compile(source: str, name: str, kinds: dict[str, Field], sentence: type[Sentence]) -> Any:
    namespace = dict(vars(fields))
    for kind in kinds.values():
        namespace |= kind.names
    namespace["cls"] = sentence
    exec(compile(source, f"<{sentence.__name__}.{name}>", "exec"), namespace)
    return namespace[name]


def reader_source(sentence: type[Sentence]) -> str:
    """The text of the parser."""
    kinds = layout(sentence)
    wires = [f"w{index}" for index in range(sum(kind.wires for kind in kinds.values()))]
    statements, first = [], 0
    for name, kind in sorted(kinds.items(), key=lambda item: isinstance(item[1], fields.Status)):
        first = _first_wire(kinds, name)
        statements.append(kind.read(wires[first : first + kind.wires], name))
    return f"""
def read(wires):
    if len(wires) != {len(wires)}: wires = (wires + [b""] * {len(wires)})[:{len(wires)}]
    {", ".join(wires)}, = wires
    try:
{indent(chr(10).join(statements), " " * 8)}
    except (ValueError, KeyError):
        return None
    return cls({", ".join(kinds)})
"""


def _first_wire(kinds: dict[str, Field], name: str) -> int:
    before = list(kinds)[: list(kinds).index(name)]
    return sum(kinds[other].wires for other in before)


def writer_source(sentence: type[Sentence]) -> str:
    """The text of the writer."""
    kinds = layout(sentence)
    statements = [
        f"value = sentence.{name}\n" + kind.write("value", f"w{index}", f"{sentence.__name__}.{name}")
        for index, (name, kind) in enumerate(kinds.items())
    ]
    texts = ",".join(f"{{w{index}}}" for index in range(len(kinds)))
    return f"""
def write(sentence, talker):
{indent(chr(10).join(statements), " " * 4)}
    return f"{{talker}}{sentence.__name__},{texts}"
"""


class _Readers(dict[type[Sentence], Reader]):
    def __missing__(self, sentence: type[Sentence]) -> Reader:
        self[sentence] = reader = _compile(reader_source(sentence), "read", layout(sentence), sentence)
        return reader  # type: ignore[no-any-return]


class _Writers(dict[type[Sentence], Writer]):
    def __missing__(self, sentence: type[Sentence]) -> Writer:
        self[sentence] = writer = _compile(writer_source(sentence), "write", layout(sentence), sentence)
        return writer  # type: ignore[no-any-return]


READERS: dict[type[Sentence], Reader] = _Readers()
_WRITERS: dict[type[Sentence], Writer] = _Writers()
