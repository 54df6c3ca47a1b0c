"""Messages of recorded buses with machine time, whatever the recording's format."""

from functools import cache

import msgspec

from tests.recordings import ROOT
from timonel.errors import RecordingError
from timonel.gateway.convert import RecordedTime
from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.recording import open_log

BUSY = 0.001  # s from frame to frame


class Message(msgspec.Struct, frozen=True):
    """A whole message and when its last frame came, in s since the recording began."""

    identifier: int
    payload: bytes
    now: float


@cache
def recordings():
    """Every file below the recordings' folder in which a bus is recorded, by its path."""
    found = []
    for path in sorted(ROOT.rglob("*")):
        if path.is_file() and next(iter(frames(path)), None) is not None:
            found.append(str(path.relative_to(ROOT)))
    return found


def frames(path):
    """Frames (and whole messages, where the recording has them) of a log or a capture; none of any other file."""
    try:
        log = open_log(path)
    except RecordingError:
        return
    with log:
        yield from log


def timed(path):
    """Each frame with machine time; where recorded time stands still, it goes on as on a busy bus."""
    time, now = RecordedTime(), 0.0
    for frame in frames(path):
        now = max(time.receive(frame.stamp), now + BUSY)
        yield frame, now


def messages(path):
    """The whole messages of a recording."""
    reassembler = Reassembler()
    for frame, now in timed(path):
        payload = frame.data
        if is_fast(split(frame.identifier).pgn) and not frame.whole:
            payload = reassembler.receive(frame.identifier, frame.data, now)
        if payload is not None:
            yield Message(frame.identifier, payload, now)
