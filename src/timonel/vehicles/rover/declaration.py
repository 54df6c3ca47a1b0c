"""A rover's frame is a declaration, as a PGN is: a frozen struct whose annotations are its layout on the wire.

```python
class MotorCurrentRight(RoverFrame, frame=104, to=Party.OPERATOR, sender="right drive", rate=20):
    front: Annotated[float | None, Current("right", 0)]
    ...
```
What the bytes mean depends on a rover's calibration, so it is a `Protocol` that decodes and encodes.
"""

import math
import re
from collections.abc import Callable
from enum import Enum
from types import CodeType
from typing import Any, ClassVar, Self, dataclass_transform, overload

import msgspec

from timonel.core.message import LayoutMeta, Slot
from timonel.vehicles.rover.conversions import Signal


class Party(Enum):
    """Whom a frame is for."""

    ROVER = "rover"
    """The controller or, through it, a module: what operators and programs say."""
    MOTORS = "motors"
    """The motor drivers, on the CAN bus only."""
    OPERATOR = "operator"
    """Whoever listens: telemetry."""


FUNCTIONS: dict[str, Callable[..., Any]] = {
    "atan2": math.atan2,
    "sqrt": math.sqrt,
}
CONSTANTS = {"pi": math.pi}


class Derived:
    """A signal that is not on the wire: `formula` is a Python expression of the frame's other signals, in SI.

    None where one of them is not available. It may use `atan2`, `sqrt` and `pi`.
    """

    def __init__(self, unit: str, formula: str, about: str = "") -> None:
        self.unit = unit
        self.formula = formula
        self.about = about
        words = dict.fromkeys(re.findall(r"[a-z_]\w*", formula))
        self.operands = tuple(word for word in words if word not in FUNCTIONS | CONSTANTS)
        self.code: CodeType = compile(formula, f"<{formula}>", "eval")
        arguments = ", ".join(self.operands)
        self._function: Callable[..., float] = eval(f"lambda {arguments}: {formula}", FUNCTIONS | CONSTANTS)

    @overload
    def __get__(self, frame: None, owner: type) -> Self: ...
    @overload
    def __get__(self, frame: "RoverFrame", owner: type) -> float | None: ...
    def __get__(self, frame: "RoverFrame | None", owner: type) -> "Self | float | None":
        if frame is None:
            return self
        values = [getattr(frame, name) for name in self.operands]
        return None if None in values else self._function(*values)


class FrameMeta(LayoutMeta):
    """Reads where a frame goes, beside its layout."""

    FRAME: int
    TO: Party
    SENDER: str
    RATE: float
    SEGMENTED: bool
    VALID: str
    DERIVED: dict[str, Derived]

    def __new__(
        mcls,
        name: str,
        bases: tuple[type, ...],
        namespace: dict[str, Any],
        *,
        frame: int = 0,
        to: Party = Party.OPERATOR,
        sender: str = "",
        rate: float = 1,
        segmented: bool = False,
        valid: str = "",
        **options: Any,
    ) -> "FrameMeta":
        cls = super().__new__(mcls, name, bases, namespace, **options)
        assert isinstance(cls, FrameMeta)
        cls.FRAME, cls.TO, cls.SENDER, cls.RATE, cls.SEGMENTED, cls.VALID = frame, to, sender, rate, segmented, valid
        cls.DERIVED = {key: value for key, value in namespace.items() if isinstance(value, Derived)}
        return cls

    def __init__(cls, name: str, bases: tuple[type, ...], namespace: dict[str, Any], **options: Any) -> None:
        super().__init__(name, bases, namespace)

    @property
    def signals(cls) -> list[tuple[str, Signal]]:
        """The names of the fields and what they are declared as, in order."""
        return [(slot.name, slot.field) for slot in cls.layout if isinstance(slot.field, Signal)]

    @property
    def size(cls) -> int:
        """In bytes."""
        return sum(field.bits for _, field in cls.signals) // 8


@dataclass_transform(frozen_default=True, kw_only_default=True)
class RoverFrame(msgspec.Struct, metaclass=FrameMeta, frozen=True):
    """Base of all frames of a rover.

    `frame` is the identifier on UART and CAN, `to` whom it is for, `sender` who sends it at `rate` Hz. A frame of more
    than 8 bytes crosses CAN only if it is `segmented`. `valid` is an expression of the raw values that is false where
    the frame says that it has none: all of them are None then, and are sent as zeros.
    """

    FRAME: ClassVar[int]
    TO: ClassVar[Party]
    SENDER: ClassVar[str]
    RATE: ClassVar[float]
    SEGMENTED: ClassVar[bool]
    VALID: ClassVar[str]
    DERIVED: ClassVar[dict[str, Derived]]
    layout: ClassVar[tuple[Slot, ...]]
