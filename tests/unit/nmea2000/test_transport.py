"""Long messages in packets of seven bytes."""

from timonel.nmea2000.transport import CONTROL, DATA, SESSIONS, Transport

WANTED = frozenset({65240})
PAYLOAD = bytes(range(1, 10))


def announced(size: int = 9, packets: int = 2, pgn: int = 65240, control: int = 32) -> bytes:
    return bytes((control,)) + size.to_bytes(2, "little") + bytes((packets, 255)) + pgn.to_bytes(3, "little")


def packet(number: int, data: bytes = PAYLOAD) -> bytes:
    return bytes((number,)) + data[7 * number - 7 : 7 * number].ljust(7, b"\xff")


def test_a_message_is_put_together_from_its_packets() -> None:
    transport = Transport(WANTED)
    assert transport.receive(CONTROL, announced(), 7, now=0.0) is None
    assert transport.receive(DATA, packet(1), 7, now=0.7) is None
    assert transport.receive(DATA, packet(2), 7, now=1.4) == (65240, PAYLOAD)
    assert transport.receive(DATA, packet(2), 7, now=1.4) is None
    assert transport.counters == {}


def test_sources_do_not_disturb_each_other() -> None:
    transport = Transport(WANTED)
    for source in (7, 8):
        transport.receive(CONTROL, announced(), source, now=0.0)
    for source in (7, 8):
        transport.receive(DATA, packet(1), source, now=0.0)
    for source in (7, 8):
        assert transport.receive(DATA, packet(2), source, now=0.0) == (65240, PAYLOAD)


def test_a_gap_a_pause_and_a_short_packet_break_a_message() -> None:
    for data, now in ((packet(2), 0.1), (packet(1), 0.76), (packet(1)[:7], 0.1)):
        transport = Transport(WANTED)
        transport.receive(CONTROL, announced(), 7, now=0.0)
        assert transport.receive(DATA, data, 7, now=now) is None
        assert transport.receive(DATA, packet(1), 7, now=now) is None
        assert transport.receive(DATA, packet(2), 7, now=now) is None
        assert transport.counters == {"transport: broken": 1}


def test_who_begins_anew_gives_up_what_was_under_way() -> None:
    transport = Transport(WANTED)
    transport.receive(CONTROL, announced(), 7, now=0.0)
    transport.receive(DATA, packet(1), 7, now=0.0)
    transport.receive(CONTROL, announced(), 7, now=0.0)
    assert transport.receive(DATA, packet(1), 7, now=0.0) is None
    assert transport.receive(DATA, packet(2), 7, now=0.0) == (65240, PAYLOAD)
    assert transport.counters == {"transport: begun anew": 1}


def test_what_is_not_wanted_or_not_an_announcement_is_passed_by() -> None:
    transport = Transport(WANTED)
    for words in (announced(pgn=65226), announced(control=16), announced()[:7]):
        transport.receive(CONTROL, words, 7, now=0.0)
        assert transport.receive(DATA, packet(1), 7, now=0.0) is None
    assert transport.counters == {}


def test_sizes_that_cannot_be_are_counted() -> None:
    transport = Transport(WANTED)
    for size, packets in ((8, 2), (9, 1), (1786, 255), (20, 2)):
        transport.receive(CONTROL, announced(size, packets), 7, now=0.0)
    assert transport.counters == {"transport: malformed": 4}


def test_no_more_than_so_many_are_under_way() -> None:
    transport = Transport(WANTED)
    for source in range(SESSIONS + 1):
        transport.receive(CONTROL, announced(), source, now=0.0)
    assert transport.counters == {"transport: evicted": 1}
    for source in (0, 1):
        transport.receive(DATA, packet(1), source, now=0.0)
    assert transport.receive(DATA, packet(2), 0, now=0.0) is None
    assert transport.receive(DATA, packet(2), 1, now=0.0) == (65240, PAYLOAD)
