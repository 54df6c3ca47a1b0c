"""Orders that come by MQTT: the words of the console, as its HTTP interface takes them, for one station.

order            by MQTT
a boat's         command words, acknowledge, silence; obeyed only while the station is in command
a rover's        stop, acknowledge, silence: who drives it must see it
one retained     refused: nobody knows when it was meant
"""

from collections.abc import Callable

import msgspec

from timonel.core.pace import Allowance
from timonel.interop.mqtt import Answer, Vehicle
from timonel.web.messages import Acknowledge, Command, Silence, Stop
from timonel.web.outcome import Judge, Verdict
from timonel.web.port import Port

AT_MOST = 40  # orders a second
WAITING_MAX = 64  # that are not decided

Order = Command | Acknowledge | Silence | Stop
DECODERS: dict[Vehicle, msgspec.json.Decoder[Order]] = {
    "boat": msgspec.json.Decoder(Command | Acknowledge | Silence),
    "rover": msgspec.json.Decoder(Acknowledge | Silence | Stop),
}
US = 1  # our number among the consoles of the port: there is no other


class Orders:
    """Carries orders out and says to `answer` what becomes of them, to `reject` what is none."""

    def __init__(
        self, vehicle: Vehicle, port: Port, answer: Callable[[Answer], object], reject: Callable[[str], object]
    ) -> None:
        self._port = port
        self._answer = answer
        self._reject = reject
        self._decoder = DECODERS[vehicle]
        self._allowance = Allowance(AT_MOST)
        self._undecided: list[tuple[int, Judge]] = []

    def plug(self, connected: bool) -> None:
        """The broker is there, or gone."""
        if connected:
            self._port.enter(US)
        else:
            self._port.leave(US)

    @property
    def waiting(self) -> bool:
        """Whether something is not decided yet."""
        return bool(self._undecided)

    def hear(self, payload: bytes, retained: bool, now: float) -> None:
        """Somebody published an order, at `now` (s)."""
        if retained:
            self._reject("an order must not be retained")
        elif not self._allowance.take(now):
            self._reject("too many orders")
        else:
            try:
                order = self._decoder.decode(payload)
            except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as fault:
                self._reject(f"not understood: {fault}"[:200])
            else:
                self._carry_out(order, now)

    def _carry_out(self, order: Order, now: float) -> None:
        if len(self._undecided) >= WAITING_MAX:
            self._answer(Answer(order.id, "refused", "too many orders"))
            return
        result = self._port.carry_out(order)
        if isinstance(result, Verdict):
            self._answer(Answer(order.id, result.outcome, result.reason))
            return
        self._answer(Answer(order.id, "sent", ""))
        self._undecided.append((order.id, result))
        self.look(now)

    def look(self, now: float) -> None:
        """See what became of what was ordered."""
        self._undecided = [(id, judge) for id, judge in self._undecided if not self._decided(id, judge, now)]

    def _decided(self, id: int, judge: Judge, now: float) -> bool:
        verdict = judge(now)
        if verdict is not None:
            self._answer(Answer(id, verdict.outcome, verdict.reason))
        return verdict is not None
