"""One client of the Signal K stream, `/signalk/v1/stream`: what it is told, and what it says.

```
?subscribe=         self (or nothing): all of this boat as it changes; all: the same, we know no other; none
?sendCachedValues=  false: only what changes from now on
?sendMeta=          all: what the paths mean, first
{"subscribe": [{"path": "navigation.*", "period": 1000, "policy": "fixed"}]}, {"unsubscribe": [{"path": "*"}]}
```
Who does not take what it was sent gets the newest later. It tells us nothing: `updates` are passed over, `put` is
answered with 405.
"""

from collections.abc import Mapping

import msgspec
from starlette.websockets import WebSocket

from timonel.core.pace import Allowance
from timonel.interop.signalk.deltas import hello, meta
from timonel.interop.signalk.paths import PATHS
from timonel.interop.signalk.subscriptions import EVERYTHING, Message, Subscriptions
from timonel.web.autopilot import BASE
from timonel.web.console import Console
from timonel.web.feed import framed
from timonel.web.signalk import FOLLOWERS_MAX, SignalK
from timonel.web.socket import LINE, NOT_UNDERSTOOD, POLICY, STUCK, TRY_AGAIN, Line, TooMuch, close

MESSAGES_PER_SECOND = 20

_decoder = msgspec.json.Decoder(Message)


async def serve(console: Console, signalk: SignalK, socket: WebSocket, query: Mapping[str, str]) -> None:
    """Talk with one client until it leaves."""
    if len(signalk.followers) >= FOLLOWERS_MAX:
        await socket.close(TRY_AGAIN)
        return
    await socket.accept()
    client = Client(signalk, socket.scope["extensions"][LINE], query)
    signalk.refresh(console.gateway.now)
    signalk.followers.add(client)
    client.look(console.gateway.now)
    try:
        await client.hear(socket, console)
    except TooMuch:
        await close(socket, POLICY, "too many messages")
    except (msgspec.DecodeError, RecursionError) as fault:
        await close(socket, NOT_UNDERSTOOD, f"not understood: {fault}"[:120])
    finally:
        signalk.followers.discard(client)


class Client:
    """A follower on a socket."""

    def __init__(self, signalk: SignalK, line: Line, query: Mapping[str, str]) -> None:
        self._signalk = signalk
        self._line = line
        self._waiting: list[bytes] = []
        self._stuck_since: float | None = None
        self._sequence = 0 if query.get("sendCachedValues") != "false" else signalk.model.sequence
        self._allowance = Allowance(MESSAGES_PER_SECOND)
        rows = () if query.get("subscribe") == "none" else (EVERYTHING,)
        self._subscriptions = Subscriptions(*rows)
        self._introduced = False
        self._wants_meta = query.get("sendMeta") == "all"

    # What it is told ----------------------------------------------------------------------------------

    def look(self, now: float) -> None:
        """Say what there is, as far as it listens; who has not for a while is cut off."""
        if self._stuck_since is not None and now > self._stuck_since + STUCK:
            self._line.abort()
            return
        if not self._introduced:
            self._introduce(now)
        while self._waiting:
            if not self._said(self._line.write(self._waiting[0]), now):
                return
            del self._waiting[0]
        if self._subscriptions.everything:
            self._tell_all(now)
        else:
            self._tell_some(now)

    def _introduce(self, now: float) -> None:
        context, epoch = self._signalk.vessel.context, self._signalk.epoch
        self._waiting.append(framed(hello(context, now, epoch)))
        if self._wants_meta:
            self._waiting.append(framed(meta(context, PATHS, now, epoch)))
        self._introduced = True

    def _tell_all(self, now: float) -> None:
        newest = self._signalk.model.sequence
        if newest != self._sequence and self._said(self._line.write(self._signalk.since(self._sequence)), now):
            self._sequence = newest

    def _tell_some(self, now: float) -> None:
        due = self._subscriptions.due(self._signalk.model, now)
        if due and self._said(self._line.write(self._signalk.told(due)), now):
            self._subscriptions.told(due, self._signalk.model, now)

    def _said(self, written: bool, now: float) -> bool:
        if written:
            self._stuck_since = None
        elif self._stuck_since is None:
            self._stuck_since = now
        return written

    # What it says -------------------------------------------------------------------------------------

    async def hear(self, socket: WebSocket, console: Console) -> None:
        """Until it leaves. Raises TooMuch, and msgspec.DecodeError or RecursionError for what is no message."""
        while True:
            message = await socket.receive()
            if message["type"] == "websocket.disconnect":
                return
            now = console.gateway.now
            if not self._allowance.take(now):
                raise TooMuch
            self._obey(_decoder.decode(message.get("text") or ""))
            self.look(now)

    def _obey(self, message: Message) -> None:
        if message.put is not None:
            self._answer(message.request_id)
        if message.context not in (None, "*", "self", "vessels.self", "vessels.*", self._signalk.vessel.context):
            return
        for unwanted in message.unsubscribe:
            self._subscriptions.unsubscribe(unwanted.path)
        if not self._subscriptions.subscribe(message.subscribe):
            raise TooMuch

    def _answer(self, request: str | None) -> None:
        answer = {
            "requestId": request,
            "state": "COMPLETED",
            "statusCode": 405,
            "message": f"nothing is put here; the autopilot is at {BASE}",
        }
        self._waiting.append(framed(msgspec.json.encode(answer)))
