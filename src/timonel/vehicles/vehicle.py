"""What every vehicle is to the gateway: one machine that is told the time."""

from collections.abc import Sequence
from typing import Protocol

from timonel.core.effects import Effect
from timonel.core.frame import Frame


class Vehicle(Protocol):
    """A whole gateway without its wires: frames and port bytes in, effects out.

    `now` is monotonic seconds and never goes back. The effects are to be carried out in order. After every call
    `deadline` says when `expire` is due at the latest; calling it earlier does no harm.
    """

    def receive_frames(self, frames: Sequence[Frame], now: float) -> list[Effect]:
        """Frames came in from the bus."""

    def receive_message(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        """A whole message came in, as recordings have them: longer than a frame, put together by somebody else."""

    def receive_bytes(self, port: str, data: bytes, now: float) -> list[Effect]:
        """Bytes came in on a station's port, in any portions."""

    def port_changed(self, port: str, connected: bool, now: float) -> list[Effect]:
        """A port was plugged in or unplugged."""

    @property
    def deadline(self) -> float:
        """When `expire` is due."""

    def expire(self, now: float) -> list[Effect]:
        """What the passing of time brings about."""
