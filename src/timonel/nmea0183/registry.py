"""Which sentence a formatter means, and the way from received bytes to a typed sentence."""

from functools import lru_cache

from timonel.nmea0183 import sentences
from timonel.nmea0183.checksum import Fault, verify
from timonel.nmea0183.fields import GUARD
from timonel.nmea0183.sentence import Sentence

SENTENCES: dict[bytes, type[Sentence]] = {
    name.encode(): kind
    for name, kind in vars(sentences).items()
    if isinstance(kind, type) and issubclass(kind, Sentence)
}
"""Formatter -> typed sentence."""


@lru_cache(maxsize=256)
def parse(sentence: bytes) -> Sentence | Fault:
    """The typed sentence of one framed sentence of any talker, or why there is none.

    A check sum is required. Runs once a sentence, so it is written for speed; what instruments say again and again,
    as those of a boat at rest do, is remembered.
    """
    body = verify(sentence)
    if not isinstance(body, bytes):
        return body
    kind = SENTENCES.get(body[2:5])
    if kind is None or body[5:6] != b"," or body[:1] == b"P":  # $PGRMC is Garmin's own, not an RMC
        return Fault.UNKNOWN_SENTENCE
    if not body.isascii():
        return Fault.MALFORMED
    typed = kind.read(body[6:].translate(GUARD).split(b","))
    return Fault.MALFORMED if typed is None else typed
