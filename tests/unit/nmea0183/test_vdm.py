import random

import pytest

from timonel.nmea0183.checksum import LONGEST, Fault, checksum
from timonel.nmea0183.vdm import MOST_GROUPS, AisRadio, VdmReader, VdmWriter

VOYAGE = AisRadio(5 << 418 | 7, 424, "B")


def sentence(body: str) -> bytes:
    return b"!%s*%02X" % (body.encode(), checksum(body.encode()))


def split(message: AisRadio = VOYAGE, writer: VdmWriter | None = None) -> list[bytes]:
    return [line.rstrip() for line in (writer or VdmWriter()).sentences(message)]


def test_a_message_of_one_sentence_is_read() -> None:
    message = VdmReader().receive(b"!AIVDM,1,1,,B,13noL401AuQfPShR<7M9tp1n080<,0*45", 0.0)
    assert isinstance(message, AisRadio)
    assert (message.kind, message.length, message.channel, message.own) == (1, 168, "B", False)


def test_our_own_ships_message_says_so() -> None:
    message = VdmReader().receive(b"!AIVDO,1,1,,A,B3KHAA00?`LCi1`Rk75tKwP5oP06,0*11", 0.0)
    assert isinstance(message, AisRadio)
    assert (message.kind, message.own) == (18, True)


def test_a_message_of_two_sentences_comes_back() -> None:
    first, second = split()
    reader = VdmReader()
    assert reader.receive(first, 0.0) is None
    assert reader.receive(second, 0.5) == VOYAGE
    assert reader.lost == 0


def test_no_written_sentence_is_longer_than_a_listener_must_take() -> None:
    lines = VdmWriter().sentences(AisRadio((1 << 1000) - 1, 1008, "A"))
    assert len(lines) == 3
    assert all(len(line) <= LONGEST for line in lines)


def test_the_group_number_goes_round() -> None:
    writer = VdmWriter()
    groups = [split(writer=writer)[0].split(b",")[3] for _ in range(11)]
    assert groups == [b"%d" % (number % 10) for number in range(11)]


def test_halves_of_two_messages_are_never_joined() -> None:
    writer, reader = VdmWriter(), VdmReader()
    (first, _), (_, second) = split(writer=writer), split(writer=writer)
    assert reader.receive(first, 0.0) is None
    assert reader.receive(second, 0.0) is None
    assert reader.lost == 1


def test_a_second_half_that_comes_late_is_lost_with_the_first() -> None:
    first, second = split()
    reader = VdmReader()
    reader.receive(first, 0.0)
    assert reader.receive(second, 2.1) is None
    assert reader.lost == 2


def test_a_first_half_that_comes_again_begins_anew() -> None:
    first, second = split()
    reader = VdmReader()
    reader.receive(first, 0.0)
    reader.receive(first, 0.1)
    assert reader.receive(second, 0.2) == VOYAGE
    assert reader.lost == 1


def test_a_third_part_without_the_second_is_lost() -> None:
    lines = split(AisRadio(1, 1008, "A"))
    reader = VdmReader()
    reader.receive(lines[0], 0.0)
    assert reader.receive(lines[2], 0.0) is None
    assert reader.receive(lines[1], 0.0) is None
    assert reader.lost == 3


def test_groups_that_never_end_do_not_pile_up() -> None:
    reader = VdmReader()
    for number in range(MOST_GROUPS + 5):
        talker = chr(65 + number // 26) + chr(65 + number % 26)
        reader.receive(sentence(f"{talker}VDM,2,1,1,A,0,0"), 0.0)
    assert reader.lost == 5


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (b"!AIVDM,1,1,,A,0,0*00", Fault.WRONG_CHECKSUM),
        (b"!AIVDM,1,1,,A,0,0", Fault.NO_CHECKSUM),
        (sentence("AIVDM,1,1,1,,13aI8e?P00PGpU:NR6s00?vT2000,0,0"), Fault.MALFORMED),
        (sentence("AIVDM,1,2,,A,0,0"), Fault.MALFORMED),
        (sentence("AIVDM,x,1,,A,0,0"), Fault.MALFORMED),
        (sentence("AIVDM,12,1,,A,0,0"), Fault.MALFORMED),
        (sentence("AIVDM,1,1,,A,0,6"), Fault.MALFORMED),
        (sentence("AIVDM,1,1,,A,,0"), Fault.MALFORMED),
        (sentence("AIVDM,1,1,,A,0Y,0"), Fault.MALFORMED),
        (sentence("AIABM,1,1,,A,0,0"), Fault.MALFORMED),
    ],
)
def test_what_is_no_vdm_is_told_apart(text: bytes, fault: Fault) -> None:
    assert VdmReader().receive(text, 0.0) is fault


def test_no_bytes_make_it_fail() -> None:
    chance = random.Random(7)
    reader = VdmReader()
    lines = split(AisRadio(1, 1008, "A")) + split()
    for step in range(20_000):
        line = bytearray(chance.choice(lines))
        for _ in range(chance.randrange(4)):
            line[chance.randrange(len(line))] = chance.randrange(256)
        body = bytes(line[1:-3])
        reader.receive(b"!%s*%02X" % (body, checksum(body)), step / 100)
    assert reader.lost > 0
