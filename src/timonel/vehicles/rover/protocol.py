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
        self.own = tuple(own)
        self.declarations: dict[int, type[RoverFrame]] = {}
        for frame in (*FRAMES, *self.own):
            if (first := self.declarations.setdefault(frame.FRAME, frame)) is not frame:
                raise ConfigError(f"{frame.__name__}: frame {frame.FRAME} is {first.__name__} already")
        self._codecs: dict[int, Codec] = {}
        self._decoders: dict[int, Decoder] = {}

    def declaration(self, identifier: int) -> type[RoverFrame] | None:
        """How a frame is declared; None if it is not."""
        return self.declarations.get(identifier)

    def lengths(self, to: Party) -> dict[int, int]:
        """The length in bytes of every frame that goes to `to`, by identifier."""
        return {number: frame.size for number, frame in self.declarations.items() if frame.TO is to}

    def decode(self, identifier: int, data: bytes) -> RoverFrame | None:
        """The frame in SI values; None where no such frame is declared or it has another length. Never raises."""
        decode = self._decoders.get(identifier)  # written for speed: it runs once a frame
        if decode is None:
            return self.decoder(identifier)(data) if identifier in self.declarations else None
        return decode(data)

    def decoder(self, identifier: int) -> Decoder:
        """What decodes a declared frame, for whoever reads many."""
        return self._decoders.setdefault(identifier, self.codec(identifier).decode)

    def codec(self, identifier: int) -> Codec:
        """The generated codec of a declared frame, made when it is first used."""
        if identifier not in self._codecs:
            self._codecs[identifier] = codec(self.declarations[identifier], self.calibration)
        return self._codecs[identifier]

    def encode(self, frame: RoverFrame) -> tuple[int, bytes]:
        """Identifier and data. Raises EncodeError for a value that cannot be sent, and a frame that is not ours."""
        if self.declarations.get(frame.FRAME) is not type(frame):
            raise EncodeError(f"{type(frame).__name__}: not a frame of this rover")
        return frame.FRAME, self.codec(frame.FRAME).encode(frame)

    def columns(self, identifier: int, payloads: "Payloads") -> "dict[str, Column]":
        """Decode uint8[n, size] into one float64[n] per signal, derived ones too, NaN where not available.

        The values are those of `decode`, bit for bit; of derived signals with `atan2` to the last digit. Raises
        DecodeError for payloads of another size. Needs the extra `columns`.
        """
        return self.codec(identifier).columns(payloads)
