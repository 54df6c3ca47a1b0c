"""The lines of a log, compiled and not: each is found alike."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.unit.recording.sentences import sealed
from timonel import native
from timonel.nmea0183.checksum import checksum
from timonel.recording.fast_nmea0183 import open_sentences
from timonel.recording.frames import nanoseconds
from timonel.recording.sentence_lines import LONGEST, LogLines, lines_of, padded


def places(lines: LogLines) -> list[list[int]]:
    return [column.tolist() for column in (lines.begin, lines.end, lines.behind, lines.plain)]


def same_lines(text: bytes) -> None:
    compiled = lines_of(padded(text))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native, "kernels", None)
        assert places(compiled) == places(lines_of(padded(text)))


def nearly_sentences() -> st.SearchStrategy[bytes]:
    body = st.text("$!*,\r\t 09AFaf\x7f\x80\xff", max_size=40)
    lines = st.one_of(
        body.map(lambda text: text + "\n"),
        body.map(sealed),
        body.map(lambda text: sealed(text, "!").lower()),
        body.map(lambda text: sealed(text).replace("\n", "\r\n")),
        body.map(lambda text: sealed(text).replace("*", "*0")),
    )
    return st.lists(lines, max_size=8).map(lambda found: "".join(found).encode("latin-1"))


@given(nearly_sentences())
def test_lines_are_found_alike(text):
    same_lines(text)


def test_lines_of_any_bytes_are_found_alike():
    draw = random.Random(11)
    for _ in range(300):
        same_lines(draw.randbytes(draw.randrange(200)).replace(b"\0", b"\n") + b"\n")


def test_a_character_that_is_not_printable_is_seen_at_every_place():
    for size in range(1, 40):
        for place in range(size):
            for character in "\x00\x1f\x7f\x80\xff\r":
                line = sealed("A" * place + character + "A" * (size - place - 1))
                assert lines_of(padded(line.encode("latin-1"))).plain.tolist() == [False]


def test_a_check_sum_is_right_or_not():
    body = "IIHDT,123.4,T"
    for value in range(256):
        lines = lines_of(padded(f"${body}*{value:02X}\n${body}*{value:02x}\n".encode()))
        assert lines.plain.tolist() == [value == checksum(body.encode())] * 2


def test_an_address_ends_where_its_sentence_does(tmp_path):
    path = tmp_path / "log"
    path.write_bytes((sealed("IIHDT,1,T") * 9 + sealed("A") + ",\n").encode())
    assert {table.formatter for table in open_sentences(path)} == {"HDT", "A"}


@pytest.mark.parametrize(
    ("head", "seconds"),
    [
        ("1402160417499;N;", 1402160417.499),
        ("1402160417.25 ", 1402160417.25),
        ("2023-09-02T12:41:35.5Z ", 1693658495.5),
        ("\\c:1319460666*57\\", 1319460666.0),
    ],
)
def test_a_kernel_reads_the_usual_times_before_a_sentence(head, seconds):
    lines = lines_of(padded((head + sealed("IIHDT,123.4,T")).encode()))
    assert (lines.plain.tolist(), lines.stamp.tolist()) == ([True], [nanoseconds(seconds)])
    assert lines.begin.tolist() == [LONGEST + len(head)]
