import pytest

from timonel.nmea2000.fastpacket import LONGEST, fragment
from timonel.nmea2000.identifier import split
from timonel.nmea2000.messages.network import IsoRequest
from timonel.nmea2000.sender import Outgoing, Sender, outgoing


def test_a_message_leaves_from_the_address_that_we_have_now() -> None:
    sender = Sender(0x23)
    sender.address = 0x42
    (frame,) = sender.frames(outgoing(IsoRequest(pgn=60928), destination=7))
    assert split(frame.identifier) == (6, 59904, 0x42, 7)
    assert frame.data == bytes((0x00, 0xEE, 0x00))


def test_the_counter_of_each_fast_packet_turns_by_itself() -> None:
    sender = Sender(1)
    first = [sender.frames(Outgoing(127237, bytes(21)))[0].data[0] for _ in range(9)]
    assert first == [sequence << 5 for sequence in (0, 1, 2, 3, 4, 5, 6, 7, 0)]
    assert sender.frames(Outgoing(126996, bytes(134)))[0].data[0] == 0


def test_a_priority_may_differ_from_the_usual_one() -> None:
    (frame,) = Sender(1).frames(Outgoing(127250, bytes(8), priority=5))
    assert split(frame.identifier).priority == 5


@pytest.mark.parametrize("length", range(LONGEST + 1))
def test_a_fast_packet_leaves_in_the_frames_that_it_is_taken_apart_to(length: int) -> None:
    sender, payload = Sender(1), bytes(range(length))
    for sequence in range(9):
        assert [frame.data for frame in sender.frames(Outgoing(127237, payload))] == fragment(payload, sequence)
