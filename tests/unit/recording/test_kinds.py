"""What becomes of a frame, looked up by its PGN and destination."""

from timonel.nmea2000.schedule import is_fast
from timonel.recording.assembly import _all
from timonel.recording.part import STANDARD


def channel_of(place):
    """The PGN of an identifier's 18 bits, or a standard identifier."""
    addressed = place < STANDARD and place & 0xFF00 < 0xF000
    return place & 0x3FF00 if addressed else place


def test_every_identifier_has_its_channel_and_pgns_travel_as_the_schedule_says():
    kinds = _all()
    codes = kinds.codes.tolist()
    assert [kinds.channels[code] for code in codes] == [channel_of(place) for place in range(len(codes))]
    assert {code >= kinds.fast for code in set(codes) if kinds.channels[code] >= STANDARD} == {False}
    pgns = {code: kinds.channels[code] for code in codes if kinds.channels[code] < STANDARD}
    assert {code >= kinds.fast for code in pgns} == {True, False}
    assert [code for code, pgn in pgns.items() if (code >= kinds.fast) != is_fast(pgn)] == []
