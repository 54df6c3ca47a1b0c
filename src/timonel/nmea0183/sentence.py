"""What all typed sentences have in common: the declaration is the layout, parser and writer come from it.

```python
class HDT(Sentence, frozen=True):
    heading_deg: Annotated[float | None, Angle(unit="T")] = None
```
The class's name is the formatter. Attributes stand in the order of the fields, in the sentence's own units,
and are None where the field is empty. Parser and writer are written as Python text on first use and compiled;
this is what keeps them within a few microseconds.
"""

from textwrap import indent
from typing import Any, Self, get_type_hints

import msgspec

from timonel.nmea0183 import fields
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.fields import Field, Status


class Sentence(msgspec.Struct, frozen=True, gc=False):
    """Base of all typed sentences."""

    def __init_subclass__(cls) -> None:
        for method in (_encode_first, _read_first):  # a class never inherits the code of its base
            name = method.__name__.split("_")[1]
            if name not in vars(cls):
                setattr(cls, name, classmethod(method) if method is _read_first else method)

    def encode(self, talker: str = "II") -> bytes:
        """The sentence to send, with check sum and CR LF.

        Raises EncodeError for a value outside its field or a sentence of more than 82 characters.
        """
        raise NotImplementedError

    @classmethod
    def read(cls, wires: list[bytes]) -> Self | None:
        """The sentence of the guarded fields behind the address; None if one of them is malformed.

        Fields missing at the end are empty (older editions have fewer), those in excess are not looked at.
        """
        raise NotImplementedError


def _encode_first(sentence: Sentence, talker: str = "II") -> bytes:
    cls = type(sentence)
    cls.encode = _compiled("encode", encode_source(cls), cls)  # type: ignore[method-assign]
    return cls.encode(sentence, talker)


def _read_first(cls: type[Sentence], wires: list[bytes]) -> Sentence | None:
    cls.read = staticmethod(_compiled("read", read_source(cls), cls))  # type: ignore[method-assign]
    sentence: Sentence | None = cls.read(wires)
    return sentence


def layout(sentence: type[Sentence]) -> dict[str, Field]:
    """The kind of each attribute, in the order of the fields."""
    hints = get_type_hints(sentence, include_extras=True)
    return {name: hints[name].__metadata__[0] for name in sentence.__struct_fields__}


def _compiled(name: str, source: str, sentence: type[Sentence]) -> Any:
    namespace = vars(fields) | {"cls": sentence, "seal": seal}
    for kind in layout(sentence).values():
        namespace |= kind.names
    exec(compile(source, f"<{sentence.__name__}.{name}>", "exec"), namespace)
    return namespace[name]


def read_source(sentence: type[Sentence]) -> str:
    """The text of the parser. A status comes last, for the mode has a say in it."""
    kinds = layout(sentence)
    wires = [f"w{index}" for index in range(sum(kind.wires for kind in kinds.values()))]
    left, statements = iter(wires), []
    for name, kind in kinds.items():
        statements.append((isinstance(kind, Status), kind.read([next(left) for _ in range(kind.wires)], name)))
    body = "\n".join(statement for _, statement in sorted(statements, key=lambda entry: entry[0]))
    return f"""
def read(wires):
    if len(wires) != {len(wires)}: wires = (wires + [b""] * {len(wires)})[:{len(wires)}]
    {", ".join(wires)}, = wires
    try:
{indent(body, " " * 8)}
    except (ValueError, KeyError):
        return None
    return cls({", ".join(kinds)})
"""


def encode_source(sentence: type[Sentence]) -> str:
    """The text of the writer. The text of each field begins with its comma."""
    statements, texts = [], ""
    for index, (name, kind) in enumerate(layout(sentence).items()):
        write = kind.write("value", f"w{index}", f"{sentence.__name__}.{name}")
        statements.append(f"value = sentence.{name}\n{write}")
        texts += f"{{w{index}}}"
    return f"""
def encode(sentence, talker="II"):
{indent(chr(10).join(statements), " " * 4)}
    return seal(f"{{talker}}{sentence.__name__}{texts}")
"""
