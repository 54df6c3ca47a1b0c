"""One browser on the socket: what it is told, and what it says.

It is told what concerns it alone in order, and of the vehicle only the newest: while it does not take what it was
sent, nothing is put together for it. Who takes nothing for `STUCK` s is cut off.

What goes out is framed here (RFC 6455, 5.2) and written as it is: what a server says is not masked, so that of 200
browsers all get the same bytes, and the wires do not wait for them.
"""

from collections import deque
from typing import Protocol

import msgspec
from starlette.websockets import WebSocket, WebSocketState

from timonel.core.pace import Allowance
from timonel.web.access import Rights
from timonel.web.console import CLIENTS_MAX, Console
from timonel.web.feed import framed
from timonel.web.messages import (
    Acknowledge,
    Answer,
    BrowserMessage,
    Choose,
    Command,
    Enable,
    FromServer,
    LetGo,
    Limit,
    Outcome,
    Ping,
    Pong,
    Refresh,
    RefusePairing,
    Silence,
    Stick,
    Stop,
)
from timonel.web.outcome import Judge, Verdict
from timonel.web.port import Order, RoverPort
from timonel.web.state import seconds

STUCK = 30.0  # s
MESSAGES_PER_SECOND = 120
WAITING_MAX = 64  # answers that it has not taken, and orders that are not decided
POLICY, NOT_UNDERSTOOD, TRY_AGAIN = 1008, 1007, 1013
RIGHTS = "timonel.rights"
LINE = "timonel.line"

_decoder = msgspec.json.Decoder(BrowserMessage)


class TooMuch(Exception):
    """It says more than anybody could mean."""


class Line(Protocol):
    """The way out to one browser."""

    def write(self, frame: bytes) -> bool:
        """Send a whole frame; false where it has not taken what it was sent before."""

    def abort(self) -> None:
        """Cut it off."""


async def serve(console: Console, socket: WebSocket) -> None:
    """Talk with one browser until it leaves."""
    if len(console.clients) >= CLIENTS_MAX:
        await socket.close(TRY_AGAIN)
        return
    await socket.accept()
    client = Browser(console, socket.scope["extensions"][LINE], socket.scope[RIGHTS])
    try:
        await client.hear(socket)
    except TooMuch:
        await close(socket, POLICY, "too many messages")
    except (msgspec.DecodeError, RecursionError) as fault:
        await close(socket, NOT_UNDERSTOOD, f"not understood: {fault}"[:120])
    finally:
        client.leave()


async def close(socket: WebSocket, code: int, reason: str) -> None:
    """End it where it has not ended."""
    if socket.client_state is WebSocketState.CONNECTED:
        await socket.close(code, reason)


class Browser:
    """A client on a socket."""

    def __init__(self, console: Console, line: Line, rights: Rights) -> None:
        self.rights = rights
        self.station: int | None = None
        self._console = console
        self._line = line
        self._sequence: int | None = None
        self._told: deque[bytes] = deque()
        self._undecided: list[tuple[int, Judge]] = []
        self._allowance = Allowance(MESSAGES_PER_SECOND)
        self._stuck_since: float | None = None
        self._number = console.enter(self)
        if rights.only_station is not None:
            console.become(self._number, self, rights.only_station)
        self.news()

    def leave(self) -> None:
        """It is gone."""
        self._console.leave(self._number)

    # What it is told ----------------------------------------------------------------------------------

    def news(self) -> None:
        """Say what there is, as far as it listens. Runs once a client and look: written for speed."""
        feed, line = self._console.feed, self._line
        if self._sequence is None:
            if not self._said(line.write(framed(feed.snapshot(self.rights.you(self.station))))):
                return
            self._sequence = feed.sequence
        while self._told:
            if not self._said(line.write(self._told[0])):
                return
            self._told.popleft()
        if self._sequence != feed.sequence and self._said(line.write(feed.since(self._sequence))):
            self._sequence = feed.sequence

    def _said(self, written: bool) -> bool:
        if written:
            self._stuck_since = None
        elif self._stuck_since is None:
            self._stuck_since = self._console.gateway.now
        return written

    def tell(self, message: FromServer) -> None:
        """Something for this one alone; who leaves too much of that lying is cut off."""
        if len(self._told) >= WAITING_MAX:
            self._line.abort()
            return
        self._told.append(framed(msgspec.json.encode(message)))
        self.news()

    def look(self, now: float) -> None:
        """See what became of what it said, and whether it still listens."""
        if self._stuck_since is not None and now > self._stuck_since + STUCK:
            self._line.abort()
        if self._undecided:
            self._undecided = [(id, judge) for id, judge in self._undecided if not self._decided(id, judge, now)]

    def _decided(self, id: int, judge: Judge, now: float) -> bool:
        verdict = judge(now)
        if verdict is not None:
            self._answer(id, verdict.outcome, verdict.reason)
        return verdict is not None

    def _answer(self, id: int, outcome: Outcome, reason: str = "") -> None:
        self.tell(Answer(id, outcome, reason))

    # What it says -------------------------------------------------------------------------------------

    async def hear(self, socket: WebSocket) -> None:
        """Until it leaves. Raises TooMuch, and msgspec.DecodeError or RecursionError for what is no message."""
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            if not self._allowance.take(self._console.gateway.now):
                raise TooMuch
            self._obey(_decoder.decode(message.get("text") or ""))

    def _obey(self, message: BrowserMessage) -> None:
        match message:
            case Stick() | LetGo():
                self._drive(message)
            case Command() | Acknowledge() | Silence() | Enable() | Stop() | Limit():
                self._carry_out(message)
            case Ping(n):
                self.tell(Pong(n, seconds(self._console.gateway.now)))
            case Refresh():
                self._sequence = None
                self.news()
            case Choose(id, station):
                self._choose(id, station)
            case RefusePairing(id, pairing):
                refused = self._console.may_refuse(self, pairing)
                self._answer(id, "confirmed" if refused else "refused", "" if refused else "no such pairing")

    def _choose(self, id: int, station: int | None) -> None:
        if station is not None and station not in self.rights.stations:
            self._answer(id, "refused", "not paired with this station")
            return
        self._console.become(self._number, self, station)
        self._sequence = None
        self._answer(id, "confirmed")

    def _drive(self, message: Stick | LetGo) -> None:
        port = None if self.station is None else self._console.ports[self.station]
        if isinstance(port, RoverPort):
            if isinstance(message, Stick):
                port.stick(self._number, message)
            else:
                port.let_go(self._number)

    def _carry_out(self, order: Order) -> None:
        if self.station is None:
            self._answer(order.id, "refused", "you are no station")
            return
        if len(self._undecided) >= WAITING_MAX:
            self._answer(order.id, "refused", "too many commands")
            return
        result = self._console.ports[self.station].carry_out(order)
        if isinstance(result, Verdict):
            if result.outcome != "refused":
                self._answer(order.id, "sent")
            self._answer(order.id, result.outcome, result.reason)
        else:
            self._answer(order.id, "sent")
            if not self._decided(order.id, result, self._console.gateway.now):
                self._undecided.append((order.id, result))
