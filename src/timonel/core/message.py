"""A message is a declaration: a frozen struct whose annotations are its layout on the wire.

```python
class Speed(Message, pgn=128259):
    sid: Annotated[int | None, U8()]
    speed_water_referenced: Annotated[float | None, U16(0.01, "m/s")]
    ...

Speed.decode(payload)      # -> Speed(sid=1, speed_water_referenced=3.21, ...)
Speed(sid=1, ...).encode() # -> bytes
Speed.layout               # -> (Slot(name="sid", offset=0, field=U8(), default=...), ...)
```
The codec is generated from the layout when a class is first used (`core.codec`). A message without a PGN is a
group of fields: the base of messages that begin alike, or what `Repeat` repeats.
"""

import sys
from typing import Annotated, Any, ClassVar, Self, dataclass_transform, get_origin, get_type_hints

import msgspec

from timonel.core import codec
from timonel.core.fields import Ascii, Binary, Field, Fixed, Float32, Number


class Slot(msgspec.Struct, frozen=True):
    """One field in its place: `offset` in bits from the message's beginning, None behind a variable field."""

    name: str
    offset: int | None
    field: Field
    default: Any = msgspec.NODEFAULT

    @property
    def length(self) -> int | None:
        """In bits; None where the content decides."""
        return self.field.bits if isinstance(self.field, Fixed | Ascii | Binary | Float32) else None

    @property
    def unit(self) -> str:
        return self.field.unit if isinstance(self.field, Number | Float32) else ""


LAZY: dict[str, Any] = {}


class LayoutMeta(msgspec.StructMeta):
    """Makes every declaration frozen and unseen by the garbage collector, and reads its layout.

    At run time a field left out is None; the type checker asks for those that are declared without a default.
    """

    layout: tuple[Slot, ...]

    def __new__(mcls, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **options: Any) -> "LayoutMeta":
        for field in _annotated(namespace):
            namespace.setdefault(field, None)
        cls = super().__new__(mcls, name, bases, namespace, **options | {"frozen": True, "gc": False})
        cls.layout = tuple(_slots(cls))
        return cls


class MessageMeta(LayoutMeta):
    """Adds the PGN, and the codec that is made when it is first used."""

    PGN: int | None

    def __new__(
        mcls,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        pgn: int | None = None,
        **options: Any,
    ) -> "LayoutMeta":
        cls = super().__new__(mcls, name, bases, namespace, **options)
        assert isinstance(cls, MessageMeta)
        cls.PGN = pgn
        for method, lazy in LAZY.items():  # a class never inherits the codec of its base
            setattr(cls, method, lazy)
        return cls

    def __init__(
        cls,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        pgn: int | None = None,
        **options: Any,
    ) -> None:
        super().__init__(name, bases, namespace)


def _annotated(namespace: dict[str, Any]) -> list[str]:
    """The names of the fields in a class body, in order."""
    if sys.version_info >= (3, 14):
        from annotationlib import Format, call_annotate_function, get_annotate_from_class_namespace

        annotate = get_annotate_from_class_namespace(namespace)
        annotations = call_annotate_function(annotate, Format.FORWARDREF) if annotate else {}
    else:
        annotations = namespace.get("__annotations__", {})
    return [name for name, hint in annotations.items() if get_origin(hint) is Annotated]


def _slots(cls: LayoutMeta) -> list[Slot]:
    defaults = dict(zip(reversed(cls.__struct_fields__), reversed(cls.__struct_defaults__), strict=False))
    slots: list[Slot] = []
    offset: int | None = 0
    for name, hint in get_type_hints(cls, include_extras=True).items():
        for field in getattr(hint, "__metadata__", ()):
            slot = Slot(name, offset, field, defaults.get(name, msgspec.NODEFAULT))
            slots.append(slot)
            offset = None if offset is None or slot.length is None else offset + slot.length
    return slots


@dataclass_transform(frozen_default=True, kw_only_default=True)
class Message(msgspec.Struct, metaclass=MessageMeta, frozen=True):
    """Base of all messages."""

    PGN: ClassVar[int | None]
    layout: ClassVar[tuple[Slot, ...]]

    @classmethod
    def decode(cls, data: bytes) -> Self:
        """The message in `data`: cut where too long; fields that are not there whole are not available.

        Never raises: bytes that make no sense give None, or what could be read.
        """
        codec.install(cls)
        return cls.decode(data)

    @classmethod
    def read(cls, data: bytes, at: int) -> tuple[Self, int]:
        """The message that begins at byte `at` of `data`, and where it ends."""
        codec.install(cls)
        return cls.read(data, at)

    def encode(self) -> bytes:
        """The payload. None is sent as not available, reserved bits as ones.

        Raises EncodeError for a value that does not fit its field.
        """
        codec.install(type(self))
        return self.encode()


LAZY |= {name: vars(Message)[name] for name in ("decode", "read", "encode")}
