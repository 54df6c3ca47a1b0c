"""The rover's protocol: identifiers, lengths and directions of all frames, and what a calibration makes of them.

```python
protocol = Protocol(PHYSICAL)
protocol.decode(104, data)                      # -> MotorCurrentRight(front=0.006, ...), None if it is no such frame
protocol.encode(SpeedLimit(steps=10))           # -> (119, b"\\x0a")
protocol.columns(108, payloads)["cell1"]        # -> float64[n], V
```
"""

from collections.abc import Iterable
from typing import TYPE_CHECKING

from timonel.errors import ConfigError, EncodeError
from timonel.vehicles.rover.calibration import PHYSICAL, Calibration
from timonel.vehicles.rover.codec import Codec, Decoder, codec
from timonel.vehicles.rover.declaration import Party, RoverFrame
from timonel.vehicles.rover.frames import FRAMES

if TYPE_CHECKING:
    from timonel.vehicles.rover.columns import Column, Payloads


class Protocol:
    """All frames of a rover, its owner's own ones too, by identifier."""

    def __init__(self, calibration: Calibration = PHYSICAL, own: Iterable[type[RoverFrame]] = ()) -> None:
        """Raises ConfigError where two frames have the same identifier."""
        self.calibration = calibration
        self.declarations: dict[int, type[RoverFrame]] = {}
        for frame in (*FRAMES, *own):
            if (first := self.declarations.setdefault(frame.FRAME, frame)) is not frame:
                raise ConfigError(f"{frame.__name__}: frame {frame.FRAME} is {first.__name__} already")
        self._codecs = _Codecs(self.declarations, calibration)

    def declaration(self, identifier: int) -> type[RoverFrame] | None:
        """How a frame is declared; None if it is not."""
        return self.declarations.get(identifier)

    def lengths(self, to: Party) -> dict[int, int]:
        """The length in bytes of every frame that goes to `to`, by identifier."""
        return {number: frame.size for number, frame in self.declarations.items() if frame.TO is to}

    def decode(self, identifier: int, data: bytes) -> RoverFrame | None:
        """The frame in SI values; None where no such frame is declared or it has another length. Never raises."""
        return self._codecs[identifier].decode(data) if identifier in self.declarations else None

    def decoder(self, identifier: int) -> Decoder:
        """What decodes a declared frame, for whoever reads many."""
        return self._codecs[identifier].decode

    def codec(self, identifier: int) -> Codec:
        """The generated codec of a declared frame."""
        return self._codecs[identifier]

    def encode(self, frame: RoverFrame) -> tuple[int, bytes]:
        """Identifier and data. Raises EncodeError for a value that cannot be sent, and a frame that is not ours."""
        if self.declarations.get(frame.FRAME) is not type(frame):
            raise EncodeError(f"{type(frame).__name__}: not a frame of this rover")
        return frame.FRAME, self._codecs[frame.FRAME].encode(frame)

    def columns(self, identifier: int, payloads: "Payloads") -> "dict[str, Column]":
        """Decode uint8[n, size] into one float64[n] per signal, derived ones too, NaN where not available.

        The values are those of `decode`, bit for bit; of derived signals with `atan2` to the last digit. Raises
        DecodeError for payloads of another size. Needs the extra `columns`.
        """
        return self._codecs[identifier].columns(payloads)


class _Codecs(dict[int, Codec]):
    """Made when they are first used."""

    def __init__(self, declarations: dict[int, type[RoverFrame]], calibration: Calibration) -> None:
        self._declarations = declarations
        self._calibration = calibration

    def __missing__(self, identifier: int) -> Codec:
        made = self[identifier] = codec(self._declarations[identifier], self._calibration)
        return made
