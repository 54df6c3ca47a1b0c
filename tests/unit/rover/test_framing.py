"""The rover's framings, rule by rule."""

import math
from random import Random

import pytest

from benchmarks.channel import byte_loss, realistic, traffic
from benchmarks.framing import PARSERS, orders, study
from tests.unit.rover.lengths import ALL, DOWN, UP
from timonel.errors import EncodeError
from timonel.vehicles.rover.framing import DIALECTS, Counters, Framer, Hal062, Strzyga, StrzygaCrc

FULL_FORWARD = (100, b"\x00\x9c")
PERMIT = (101, b"1")
STOP = (101, b"\xce")
CURRENTS = (104, bytes.fromhex("4607ba08170d"))


def strzyga(*frames: tuple[int, bytes]) -> bytes:
    return b"".join(Strzyga.write(*frame) for frame in frames)


def test_a_frame_comes_out_with_the_first_byte_of_the_next() -> None:
    framer = Strzyga(UP)
    assert framer.receive(b"#d\x00\x9c", 0.0) == []
    assert framer.receive(b"#", 0.001) == [FULL_FORWARD]
    assert framer.waiting == 1


def test_the_last_frame_comes_out_when_the_line_has_been_idle_for_five_milliseconds() -> None:
    framer = Strzyga(UP)
    assert framer.receive(b"#eC"[:2], 0.998) == []
    assert framer.receive(b"1", 1.0) == []
    assert framer.deadline == 1.005
    assert framer.expire(1.0049) == []
    assert framer.expire(1.005) == [PERMIT]
    assert framer.deadline == math.inf


def test_silence_that_nobody_waited_for_counts_too() -> None:
    framer = Strzyga(UP, idle=0.5)
    framer.receive(strzyga(PERMIT), 0.0)
    assert framer.receive(b"\x55", 0.5) == [PERMIT]
    assert framer.counters.skipped == 1


def test_receiving_nothing_is_not_receiving() -> None:
    framer = Strzyga(UP)
    framer.receive(strzyga(PERMIT), 0.0)
    assert framer.receive(b"", 0.004) == []
    assert framer.deadline == 0.005


def test_the_end_of_the_stream_proves_the_last_frame() -> None:
    framer = Strzyga(UP)
    assert framer.receive(strzyga(PERMIT), 0.0) == []
    assert framer.finish() == [PERMIT]
    assert (framer.waiting, framer.deadline) == (0, math.inf)


@pytest.mark.parametrize("pad", range(5))
def test_up_to_four_fill_bytes_may_follow_a_frame(pad: int) -> None:
    framer = Strzyga(UP)
    stream = Strzyga.write(*PERMIT, pad=pad) + Strzyga.write(*STOP, pad=pad)
    assert framer.receive(stream, 0.0) + framer.expire(0.005) == [PERMIT, STOP]
    assert framer.counters == Counters(frames=2, fill=2 * pad)


@pytest.mark.parametrize("follower", [b"\x00\x00\x00\x00\x00#", b"\x00\x00\x01#", b"\xff#", b"d\x00"])
def test_a_frame_that_anything_else_follows_is_rejected(follower: bytes) -> None:
    framer = Strzyga(UP)
    assert framer.receive(strzyga(PERMIT) + follower, 0.0) == []
    assert framer.counters.rejected == 1
    assert framer.counters.skipped + framer.waiting == 3 + len(follower)


def test_a_rejected_frame_loses_its_start_alone_and_what_is_inside_is_found() -> None:
    framer = Strzyga(ALL)
    assert framer.receive(b"#h\x01" + strzyga(PERMIT, STOP) + b"#", 0.0) == [PERMIT, STOP]
    assert framer.counters == Counters(frames=2, skipped=3, rejected=1, resynchronised=1)


def test_an_id_of_the_other_direction_begins_no_frame() -> None:
    framer = Strzyga(UP)
    assert framer.receive(strzyga(CURRENTS, PERMIT) + b"#", 0.0) == [PERMIT]
    assert framer.counters == Counters(frames=1, skipped=8, resynchronised=1)


@pytest.mark.parametrize("data", [b"\x80\x7f", b"\xff\xff", b"##"])
def test_the_meaning_of_a_frame_does_not_veto_it(data: bytes) -> None:
    assert Strzyga(UP).receive(strzyga((100, data)) + b"#", 0.0) == [(100, data)]


def test_skipped_bytes_in_two_places_are_two_resynchronisations() -> None:
    framer = Strzyga(UP)
    for portion in (b"\xff", b"\xff" + strzyga(PERMIT, STOP), b"\xff", b"\xff", strzyga(PERMIT) + b"#"):
        framer.receive(portion, 0.0)
    assert framer.counters == Counters(frames=2, skipped=7, rejected=1, resynchronised=2)


def test_half_a_frame_waits_longer_than_an_adapter_keeps_bytes_back() -> None:
    framer = Strzyga(UP)
    framer.receive(b"#d\x00", 0.0)
    assert framer.deadline == 0.018
    assert framer.receive(b"\x9c#", 0.0175) == [FULL_FORWARD]


def test_half_a_frame_is_not_completed_by_the_next_one() -> None:
    framer = Strzyga(UP)
    framer.receive(b"#d\x00", 0.0)
    assert framer.receive(b"\x64\x00\x00", 0.02) == []  # the next frame, 20 ms later, without its `#`
    assert framer.finish() == []
    assert framer.counters == Counters(skipped=6, rejected=1)


def test_a_frame_inside_an_unfinished_one_comes_out_when_that_is_given_up() -> None:
    framer = Strzyga(ALL, patience=0.005)
    assert framer.receive(b"#h\x01" + strzyga(STOP), 0.0) == []
    assert framer.expire(0.005) == [STOP]


def test_a_parser_without_ids_skips_everything() -> None:
    for dialect in DIALECTS.values():
        framer = dialect({})
        assert framer.receive(b"#d\x00\x9c#6531xxxxxxxxxxxxxx#", 0.0) + framer.finish() == []
        assert framer.counters == Counters(skipped=24)


def test_a_declared_frame_may_have_no_data() -> None:
    for dialect in DIALECTS.values():
        framer = dialect({200: 0, 201: 1})
        stream = dialect.write(200, b"") + dialect.write(201, b"#") + dialect.write(200, b"")
        assert framer.receive(stream, 0.0) + framer.finish() == [(200, b""), (201, b"#"), (200, b"")]


@pytest.mark.parametrize("number", [0x23, 0x5B, 0x5C, 0x5D, 0x5E, 0x2D, 0x0A, 0x00, 0xFF])
def test_every_number_can_be_an_id(number: int) -> None:
    for dialect in DIALECTS.values():
        framer = dialect({number: 2, 1: 1})
        stream = dialect.write(number, b"ab") + dialect.write(1, b"c")
        assert framer.receive(stream, 0.0) + framer.finish() == [(number, b"ab"), (1, b"c")]
        assert framer.counters.skipped == 0


def test_the_check_sum_is_the_one_of_its_name() -> None:
    assert StrzygaCrc.write(0x31, b"23456789") == b"#123456789\x29\xb1"


def test_a_frame_with_a_check_sum_comes_out_with_its_last_byte() -> None:
    framer = StrzygaCrc(UP)
    written = StrzygaCrc.write(*STOP)
    assert framer.receive(written[:-1], 0.0) == []
    assert framer.receive(written[-1:], 0.001) == [STOP]
    assert framer.deadline == math.inf


def test_every_error_within_two_neighbouring_bytes_is_found() -> None:
    written = StrzygaCrc.write(*FULL_FORWARD)
    for place in range(1, len(written) - 1):
        for error in range(1, 0x10000):
            pair = int.from_bytes(written[place : place + 2], "big") ^ error
            assert StrzygaCrc._parse(written[1:place] + pair.to_bytes(2, "big") + written[place + 2 :]) is None


def test_after_a_wrong_check_sum_the_search_goes_on_within_the_frame() -> None:
    framer = StrzygaCrc(ALL)
    stream = b"#h\x01" + StrzygaCrc.write(*PERMIT) + StrzygaCrc.write(*STOP)
    assert framer.receive(stream, 0.0) == [PERMIT, STOP]
    assert framer.counters == Counters(frames=2, skipped=3, rejected=1, resynchronised=1)


def test_half_a_frame_with_a_check_sum_is_given_up_in_silence() -> None:
    framer = StrzygaCrc(UP)
    framer.receive(StrzygaCrc.write(*STOP)[:-1], 0.0)
    assert framer.expire(0.018) == []
    assert framer.counters == Counters(skipped=4, rejected=1)


def test_the_ascii_frame_is_nineteen_characters_long() -> None:
    assert Hal062.write(71, bytes.fromhex("000bfd")) == b"#47000BFDxxxxxxxxxx"
    assert Hal062.write(255, bytes(8)) == b"#FF0000000000000000"


@pytest.mark.parametrize("line", [b"#47000BFDxxxxxxxxxx", b"#47000bfdXXXXXXXXXX", b"#47000bFDxXxXxXxXxX"])
def test_the_ascii_frame_is_read_in_both_cases(line: bytes) -> None:
    framer = Hal062({71: 3, 110: 8})
    assert framer.receive(line, 0.0) == [(71, bytes.fromhex("000bfd"))]
    assert framer.deadline == math.inf


@pytest.mark.parametrize(
    "line",
    [
        b"#47000BFD00xxxxxxxx",
        b"#47000Bxxxxxxxxxxxx",
        b"#47000BFxxxxxxxxxxx",
        b"#47000BFDxxxxxxxxx\n",
        b"#47000BGDxxxxxxxxxx",
    ],
)
def test_an_ascii_frame_of_another_length_or_with_other_characters_is_rejected(line: bytes) -> None:
    framer = Hal062({71: 3})
    assert framer.receive(line + b"#48", 0.0) == []
    assert (framer.counters.skipped, framer.counters.rejected, framer.waiting) == (19, 1, 3)


def test_a_start_inside_an_ascii_frame_begins_the_next_one() -> None:
    framer = Hal062({71: 3})
    assert framer.receive(b"#47000B#47000BFDxxxxxxxxxx", 0.0) == [(71, bytes.fromhex("000bfd"))]


def test_what_does_not_fit_the_ascii_frame_is_neither_read_nor_written() -> None:
    framer = Hal062(DOWN)
    assert framer.receive(b"#6F" + b"00" * 8, 0.0) == []
    assert framer.counters == Counters(skipped=19)
    with pytest.raises(EncodeError, match="frame 111: 12 bytes of data are more than 8"):
        Hal062.write(111, bytes(12))


@pytest.mark.parametrize("dialect", DIALECTS.values())
@pytest.mark.parametrize("number", [-1, 256])
def test_an_id_that_no_frame_can_have_is_not_written(dialect: type[Framer], number: int) -> None:
    with pytest.raises(EncodeError, match=f"frame {number}: ids are 0..255"):
        dialect.write(number, b"")


@pytest.mark.parametrize("pad", [-1, 5])
def test_more_fill_than_proves_a_frame_is_not_written(pad: int) -> None:
    with pytest.raises(EncodeError, match=f"frame 101: a pad of {pad} is outside 0..4"):
        Strzyga.write(*PERMIT, pad=pad)


def test_at_one_percent_of_lost_bytes_the_specified_figures_are_met() -> None:
    sent = traffic(20_000, realistic, Random(1))
    ours = study(sent, PARSERS["strzyga"], byte_loss(1e-2))
    assert ours.false_per_1000 <= 0.1
    assert ours.lost_percent <= 1.5
    checked = study(sent, PARSERS["strzyga-crc"], byte_loss(1e-2))
    assert (checked.false, checked.corrupt) == (0, 0)
    assert checked.lost_percent <= 0.05
    naive = study(sent, PARSERS["naive"], byte_loss(1e-2))
    assert 55 < naive.false_per_1000 < 75
    assert 5.5 < naive.lost_percent < 7.5


@pytest.mark.parametrize("name", ["strzyga", "strzyga-crc"])
def test_at_one_percent_of_lost_bytes_no_set_point_is_executed_that_was_never_sent(name: str) -> None:
    made = orders(name, 20_000)
    assert made.invented == 0
    assert made.taken > 18_000
