from io import StringIO

import pytest
from can.io.canutils import CanutilsLogReader

from timonel.core.frame import Frame
from timonel.links.urls import TEXTS
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.text import FORMS, LONGEST_LINE, Heard, TextReader, TextWriter

NOON = 1_620_820_800.107  # 2021-05-12 12:00:00.107 UTC
HEADING = 0x09F11223
DATA = bytes.fromhex("ff10270080ff7ffd")
STEER = bytes.fromhex("3f3cffff7f051fffffffffffffff7fff7fff7f8b1e")
STEER_ID = 0x09F10523

LINES = {
    # YDWG-02 manual, appendix E
    "ydraw": ("17:33:21.107 R 19F51323 01 2F 30 70 00 2F 30 70", Heard(0x19F51323, bytes.fromhex("012f3070002f3070"))),
    # can-utils, candump -L
    "candump": (
        "(1620807235.135072) can0 09F8017F#3E17B322B320590D",
        Heard(0x09F8017F, bytes.fromhex("3e17b322b320590d")),
    ),
    # Actisense SDK, nmea2000-type-A.md; priority 7, so that the identifier is 1D...
    "n2kascii": (
        "A173321.107 23FF7 1F513 012F3070002F30709F",
        Heard(0x1DF51323, bytes.fromhex("012f3070002f30709f"), whole=True),
    ),
    # SeaSmart.Net protocol specification
    "seasmart": ("$PCDIN,01F119,00000000,0F,2AAF00D1067414FF*59", Heard(0x0DF1190F, bytes.fromhex("2aaf00d1067414ff"))),
}  # fmt: skip


def test_the_schemes_of_urls_are_the_forms() -> None:
    assert set(TEXTS) == set(FORMS)


@pytest.mark.parametrize("form", FORMS)
def test_a_line_of_the_makers_own_text_is_understood(form) -> None:
    line, heard = LINES[form]
    assert FORMS[form].read(line) == heard


@pytest.mark.parametrize("form", FORMS)
def test_what_is_written_is_read_back(form) -> None:
    writer, reader = TextWriter(FORMS[form]), TextReader(FORMS[form])
    frames = [Frame(HEADING, DATA), *[Frame(STEER_ID, data) for data in fragment(STEER, 1)]]
    lines = [FORMS[form].report(*payload, NOON, False) for payload in writer.payloads(frames, 0.0)]
    heard = reader.receive(b"".join(lines))
    assert [frame for each in heard for frame in reader.frames(each)] == frames
    assert reader.rejected == 0


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("cut", [1, 7, 40])
def test_however_the_bytes_are_cut_the_lines_say_the_same(form, cut) -> None:
    line, heard = LINES[form]
    data = f"{line}\r\n# a comment\r\n{line}\n".encode()
    reader = TextReader(FORMS[form])
    assert [h for start in range(0, len(data), cut) for h in reader.receive(data[start : start + cut])] == [
        heard,
        heard,
    ]


WRITTEN = {
    "ydraw": b"12:00:00.107 T 09F11223 FF 10 27 00 80 FF 7F FD\r\n",
    "candump": b"(1620820800.107000) can0 09F11223#FF10270080FF7FFD\r\n",
    "n2kascii": b"A120000.107 23FF2 1F112 FF10270080FF7FFD\r\n",
    "seasmart": b"$PCDIN,01F112,00000000,23,FF10270080FF7FFD*5B\r\n",
}


@pytest.mark.parametrize("form", FORMS)
def test_a_frame_is_written_as_the_maker_has_it(form) -> None:
    assert FORMS[form].report(HEADING, DATA, NOON, True) == WRITTEN[form]


def test_a_client_of_yacht_devices_sends_neither_time_nor_direction() -> None:
    assert FORMS["ydraw"].command(HEADING, DATA, NOON) == b"09F11223 FF 10 27 00 80 FF 7F FD\r\n"


def test_yacht_devices_marks_tell_what_the_gateway_sent_itself() -> None:
    read = FORMS["ydraw"].read
    assert [read(f"12:00:00.000 {mark} 09F11223 FF").sent for mark in "RT"] == [False, True]
    assert read("09f11223 ff") == Heard(HEADING, b"\xff")


def test_python_can_reads_our_candump() -> None:
    [message] = CanutilsLogReader(StringIO(WRITTEN["candump"].decode()))
    assert (message.arbitration_id, bytes(message.data), message.is_extended_id) == (HEADING, DATA, True)
    assert message.timestamp == NOON


def test_a_message_to_one_device_is_not_said_in_a_form_that_would_tell_it_to_all() -> None:
    to_one = 0x0DED7F23  # 126208 to device 127
    assert FORMS["seasmart"].command(to_one, STEER, NOON) is None
    assert FORMS["n2kascii"].command(to_one, b"\1", NOON) == b"A120000.107 237F3 1ED00 01\r\n"


BAD = [
    ("ydraw", "12:00:00.000 R 29F11223 FF"),
    ("ydraw", "12:00:00.000 R 09F11223 FF 1"),
    ("ydraw", "09F11223 00 01 02 03 04 05 06 07 08"),
    ("candump", "(1.0) can0 09F11223#FF1"),
    ("candump", "(1.0) can0 89F11223#FF"),
    ("n2kascii", "A120000.107 23FF2 1F112 FF10270080FF7FFD00"),
    ("n2kascii", "A120000.107 23FF2 3FFFF " + "00" * 224),
    ("n2kascii", "A120000.107 23FF2 0EA01 00EE00"),
    ("seasmart", "$PCDIN,01F119,00000000,0F,2AAF00D1067414FF*58"),
    ("seasmart", "$PCDIN,01F119,00000000,0F,2AAF00D1067414F*59"),
    ("seasmart", "hello"),
]


@pytest.mark.parametrize(("form", "line"), BAD)
def test_a_broken_line_is_counted_and_the_next_one_is_read(form, line) -> None:
    reader = TextReader(FORMS[form])
    good, heard = LINES[form]
    assert reader.receive(f"{line}\r\n{good}\r\n".encode()) == [heard]
    assert reader.rejected == 1


def test_remote_requests_comments_and_other_sentences_carry_nothing_and_are_no_fault() -> None:
    candump, seasmart, actisense = (TextReader(FORMS[form]) for form in ("candump", "seasmart", "n2kascii"))
    assert actisense.receive(b"A120000.107 23FF2 401F0 00EE00\n") == []  # a PGN of the gateway itself
    assert candump.receive(b"(1.0) can0 09F11223#R\n#\n  \n") == []
    assert seasmart.receive(b"$IIHDT,1.0,T*2F\r\n!AIVDM,1,1,,A,1,0*00\r\n") == []
    assert (candump.rejected, seasmart.rejected, actisense.rejected) == (0, 0, 0)


def test_a_line_without_end_costs_no_memory() -> None:
    reader = TextReader(FORMS["ydraw"])
    for _ in range(100):
        assert reader.receive(b"0" * 1000) == []
    assert len(reader._rest) == LONGEST_LINE + 1
    assert reader.receive(b"\n" + LINES["ydraw"][0].encode() + b"\n") == [LINES["ydraw"][1]]
    assert reader.rejected == 1


def test_two_messages_of_one_sender_are_taken_apart_with_different_counters() -> None:
    reader = TextReader(FORMS["n2kascii"])
    line = FORMS["n2kascii"].report(STEER_ID, STEER, NOON, False)
    heads = [reader.frames(heard)[0].data[0] >> 5 for heard in reader.receive(line * 9)]
    assert heads == [1, 2, 3, 4, 5, 6, 7, 0, 1]


def test_frames_with_11_bit_identifiers_are_not_of_nmea_2000() -> None:
    foreign = Frame(0x123, b"\0", extended=False)
    assert TextWriter(FORMS["ydraw"]).payloads([foreign], 0.0) == []
    assert TextWriter(FORMS["n2kascii"]).payloads([foreign], 0.0) == []
    assert FORMS["candump"].read("(1.0) can0 123#00") == Heard(0x123, b"\0", extended=False)
