"""Logs of NMEA 0183, with times before the sentences and without."""

import pytest

from timonel.errors import RecordingError
from timonel.nmea0183.checksum import checksum
from timonel.recording import LogSentence, open_any, open_log
from timonel.recording.nmea0183 import Nmea0183

HDT = "$IIHDT,45.0,T*13"
BEFORE = {
    "": (None, False),
    "  ": (None, False),
    "1402160417499;N;": (1402160417.499, True),
    "1402160417499;;": (1402160417.499, True),
    "1402160417.499 ": (1402160417.499, True),
    "(1402160417.499) ": (1402160417.499, True),
    "12.25\t": (12.25, False),
    "2014-06-07T17:00:17.499Z ": (1402160417.499, True),
    "2014-06-07 17:00:17.499+00:00\t": (1402160417.499, True),
    "[2014-06-07 19:00:17+02:00] ": (1402160417.0, True),
    "2014-06-07T17:00:17.499Z 160 ": (1402160417.499, True),
    "12:30:05.5 ": (45_005.5, False),
    "12:30:05 udp:10110 ": (45_005.0, False),
}


def read(line):
    reader = Nmea0183([line])
    return reader.read(line), reader.dated


def tagged(block, line=HDT):
    return f"\\{block}*{checksum(block.encode()):02X}\\{line}"


@pytest.mark.parametrize("before", BEFORE)
def test_what_stands_before_a_sentence_is_its_time(before):
    stamp, dated = BEFORE[before]
    assert read(before + HDT) == (LogSentence(stamp, HDT.encode()), dated)


@pytest.mark.parametrize(
    ("block", "stamp"),
    [("c:1319460666", 1319460666.0), ("s:gps,c:1319460666123,n:4", 1319460666.123), ("g:1-2-3,s:r", None)],
)
def test_a_tag_block_has_the_time_in_seconds_or_milliseconds(block, stamp):
    assert read(tagged(block)) == (LogSentence(stamp, HDT.encode()), stamp is not None)


def test_any_kind_of_sentence_is_read_if_its_check_sum_is_right():
    for line in ("!AIVDM,1,1,,B,13aGra0P00PHid>NK9<2FOw`R61p,0*50", "$PXXX,1*" + f"{checksum(b'PXXX,1'):02x}"):
        assert read(line)[0].line == line.encode()


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("$IIHDT,45.0,T*12", "wrong check sum"),
        ("$IIHDT,45.0,T", "no check sum"),
        ("$IIHDT,45.0,T*1", "malformed"),
        ("$IIHDT,4\x00.0,T*13", "neither a comment nor a sentence"),
        ("foobar", "neither a comment nor a sentence"),
        ("yesterday " + HDT, "neither a time nor a TAG block before the sentence"),
        ("\\c:1319460666*00\\" + HDT, "wrong check sum of the TAG block"),
        (tagged("c:99999999999999999999"), "1e+17 s is no time of a recording"),
        ("23:99:59 " + HDT, "23:99:59 is no time of day"),
        ('1402160417499;I;{"context":"vessels.self"}', "neither a comment nor a sentence"),
    ],
)
def test_a_line_of_another_shape_is_refused(line, reason):
    with pytest.raises(ValueError) as error:
        read(line)
    assert str(error.value) == reason


def test_a_log_of_sentences_is_no_log_of_frames(tmp_path):
    path = tmp_path / "log"
    path.write_text(f"# from the masthead\n1402160417499;N;{HDT}\r\n$IIHDT,45.")
    log = open_any(path)
    assert (log.kind, log.format, log.timed, log.dated) == ("sentences", "NMEA 0183", True, True)
    assert list(log) == [LogSentence(1402160417.499, HDT.encode())]
    assert [(u.place, u.reason) for u in log.unreadable] == [("line 3", "no check sum")]
    with pytest.raises(RecordingError, match=r"log: sentences \(NMEA 0183\), not frames of a bus"):
        open_log(path)
