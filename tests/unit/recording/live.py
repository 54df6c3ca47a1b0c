"""The live path, one frame after the other: what messages in columns are compared with."""

from collections.abc import Iterator

from timonel.nmea2000.fastpacket import Reassembler
from timonel.nmea2000.identifier import split
from timonel.nmea2000.registry import is_fast
from timonel.recording.assembly import PACE, Assembly
from timonel.recording.frames import EXTENDED, NO_STAMP, Frames

Message = tuple[int, int, int, bytes]


def one_by_one(frames: Frames, max_slots: int = 256) -> tuple[list[Message], Reassembler]:
    """(place of its last frame, that one's stamp and identifier, payload) of each message."""
    reassembler = Reassembler(250_000_000, 100_000_000, max_slots)
    messages, now = [], 0
    fields = (frames.identifier, frames.whole, frames.stamp)
    for row, (identifier, whole, stamp) in enumerate(zip(*(field.tolist() for field in fields), strict=True)):
        now = now + PACE if stamp == NO_STAMP else stamp
        payload: bytes | None = frames.payload(row)
        if identifier >= EXTENDED and not whole and is_fast(split(identifier).pgn):
            payload = reassembler.receive(identifier & EXTENDED - 1, payload or b"", now)
        if payload is not None:
            messages.append((row, stamp, identifier & EXTENDED - 1, payload))
    return messages, reassembler


def in_columns(frames: Frames, size: int, assembly: Assembly | None = None) -> list[Message]:
    """The same from an assembly that is given `size` frames at a time."""
    found = list(_listed(frames, size, assembly or Assembly()))
    rows = [message[0] for message in found]
    assert len(set(rows)) == len(rows)
    return sorted(found)


def _listed(frames: Frames, size: int, assembly: Assembly) -> Iterator[Message]:
    for start in range(0, len(frames), size):
        for group in assembly.receive(frames[start : start + size]):
            columns = (group.row, group.stamp, group.identifier, group.lengths)
            assert group.row.tolist() == sorted(group.row.tolist())
            for place, (row, stamp, identifier, length) in enumerate(zip(*(c.tolist() for c in columns), strict=True)):
                assert (group.frame if group.pgn is None else group.pgn) == _number(identifier, group.pgn)
                yield row, stamp, identifier, group.payloads[place, :length].tobytes()


def _number(identifier: int, pgn: int | None) -> int:
    return identifier if pgn is None else split(identifier).pgn
