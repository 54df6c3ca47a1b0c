"""What a machine asks the world to do, and what it tells the world about.

A machine never acts: it returns effects and the gateway carries them out, in order. Effects are frozen and
compare by value, so a test states them as it would say them.
"""

import msgspec

from timonel.core.frame import Frame


class Effect(msgspec.Struct, frozen=True, gc=False):
    """Base of all effects."""


class Say(Effect, frozen=True, gc=False):
    """Write one line to every OUT port: a sentence with its CR LF, or a frame of a binary protocol.

    `key` names what the line is about: where a port cannot keep up, a newer line of data
    replaces an unsent one of the same key. An `urgent` line goes ahead of all data and is not replaced, unless
    it tells a `state` as a whole, which makes an older one worthless.
    """

    line: bytes
    key: str
    urgent: bool = False
    state: bool = False


class SayTo(Effect, frozen=True, gc=False):
    """Write one line to the OUT port called `port`, and to no other: an order that others must not take for theirs.

    It goes ahead of all data, and a newer one of the same `key` replaces one that is not sent yet.
    """

    line: bytes
    key: str
    port: str


class Transmit(Effect, frozen=True, gc=False):
    """Put one frame on the bus."""

    frame: Frame


class Event(Effect, frozen=True, gc=False):
    """Something worth telling and recording; changes nothing outside by itself."""


class Rejected(Event, frozen=True, gc=False):
    """Bytes of a peer that were not understood: counted, visible in health, otherwise without effect."""

    reason: str
    data: bytes = b""
    source: str = ""


class Refused(Event, frozen=True, gc=False):
    """A station that may not do something now. Ordinary traffic."""

    reason: str
    station: int = 0


class SecurityEvent(Event, frozen=True, gc=False):
    """Somebody claimed to be who they are not."""

    reason: str
    port: str
    station: int = 0
