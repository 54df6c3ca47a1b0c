"""NMEA 0183 logs in columns: the values of the sentences, whatever else stands in the log."""

import math
import random

import pytest

from tests.unit.recording.sentences import by_formatter, compared, listed, sealed
from timonel.errors import RecordingError
from timonel.nmea0183.checksum import checksum
from timonel.nmea0183.registry import SENTENCES
from timonel.nmea0183.sentences import HDT
from timonel.recording import fast_nmea0183
from timonel.recording.fast_nmea0183 import open_sentences
from timonel.recording.frames import NO_STAMP

pytestmark = pytest.mark.usefixtures("each_way")


def written(tmp_path, *lines):
    path = tmp_path / "log"
    path.write_bytes("".join(lines).encode("latin-1"))
    return path


USUAL = [
    "IIHDT,123.4,T", "IIHDT,,T", "IIHDM,359.9,M", "IIVHW,,T,,M,06.11,N,11.31,K",
    "GPGLL,6005.071,N,02332.346,E,095559,A,D",
    "GPRMC,120000.25,A,3930.738000,S,00236.740400,W,6.5,123.4,010126,2.1,E,A", "IIMWV,338,R,13.41,N,A",
    "GPZDA,095559,02,05,2014,00,00", "IIXTE,A,A,0.021,L,N,D", "IIDBT,034.25,f,010.44,M,005.64,F",
    "GPVTG,224.44,T,224.44,M,5.81,N,,,D", "GPGGA,085411.000,5222.3215,N,00454.5778,E,1,4,2.95,16.0,M,47.0,M,,",
    "IIALR,120000,001,A,V,Low voltage", "IIXDR,C,21.5,C,AIR,P,1.013,B,BARO", "IIROT,-3.5,A",
    "GPAPB,A,A,0.1,R,N,V,V,11.0,M,WP1,12.0,M,13.0,T,A",
]  # fmt: skip


def test_sentences_of_all_kinds_have_their_values(tmp_path):
    tables = compared(written(tmp_path, *(sealed(body) for body in USUAL * 30)))
    assert {table.kind for table in tables} > {HDT}
    assert {table.formatter for table in tables} == {body[2:5] for body in USUAL}


def test_a_column_has_nan_where_there_is_no_value(tmp_path):
    (table,) = open_sentences(written(tmp_path, sealed("IIHDT,123.4,T"), sealed("GPHDT,,T")))
    assert table.columns["heading_deg"].values[0] == 123.4
    assert math.isnan(table.columns["heading_deg"].values[1])
    assert table.talker.tolist() == [b"II", b"GP"]
    assert (table.line.tolist(), table.stamp.tolist()) == ([1, 2], [NO_STAMP] * 2)


ODD = [
    "IIHDT,1e2,T", "IIHDT,361,T", "IIHDT,-1,T", "IIHDT,12.5,M", "IIHDT,12.5", "IIHDT,12.5,T,more,of,it",
    "IIHDT,12.5,TT", "IIHDT,000000000000123.25,T", "IIHDT,-0,T", "IIHDT, 12,T", "IIHDT,nan,T", "IIHDT,",
    "GPRMC,235960,A,,,,,,,311215,,,N", "GPRMC,235960.5,V,,,,,,,310215,,",
    "GPRMC,125959,A,4560.0,N,00100.0,E,1,2,290224,,,A", "GPRMC,240000,A,,,,,,,,,,", "GPRMC,12595,A,,,,,,,,,,",
    "GPRMC,1259590,A,,,,,,,,,,", "GPRMC,125959.,A,,,,,,,290223,,,", "GPRMC,,A,,,,,,,311280,,,X",
    "GPRMC,,A,,,,,,,010179,,,E", "GPRMC,,AA,,,,,,,,,,A", "GPRMC,,A,4500.0,,,,,,,,,", "GPRMC,,A,x,,,,,,,,,",
    "GPRMC,,A,4500.0,Q,,,,,,,,", "GPGLL,9000.0,N,18000.0,W,,A,A", "GPGLL,9000.1,N,18000.0,W,,A,A",
    "GPGLL,-4500.0,N,00000.0,W,,A,A", "GPZDA,,32,13,2014,14,60", "GPZDA,,-1,+1,2014.,-13,-59",
    "GPZDA,,00007,00000012,2014,0,0", "IIALR,120000,001,A,V,caf^E9", "IIALR,120000,001,A,V,^", "IIMWV,1,Q,2,N,A",
    "IIMWV,1,R,2,NN,B", "IIXDR,A,-1.-3,D,ROLL", "IIXDR,A,1,D", "IIXTE,A,A,-0.1,L,N", "IIROT,-720,A", "PGRMC,A,1",
    "PGRMC", "IIZZZ,1,2,3", "GPRMC", "RMC,1,2", "IIHDTX,1,T", "AIVDM,1,1,,A,13aJG1wP?w<tSF0l4Q@>4?wv0`9F,0",
    "IIRMC*1,A", "", "P", "IIHDT,1*2,T", "$IIHDT,12.5,T",
]  # fmt: skip


@pytest.mark.parametrize("body", ODD)
def test_what_is_not_as_usual_is_what_the_parser_makes_of_it(tmp_path, body):
    others = sealed("IIHDT,123.4,T") * 3
    compared(
        written(
            tmp_path, others, sealed(body), others, sealed(body, "!"), sealed("GPGLL,6005.071,N,02332.346,E,095559,A,D")
        )
    )


LINES = [
    "# a comment\n", "\n", "hello\n", "$IIHDT,123.4,T\n", "$IIHDT,123.4,T*00\n", "$IIHDT,123.4,T*2Z\n",
    "$IIHDT,123.4,T*2\n", "$\n", "$*00\n", "*00\n", "$IIHDT,123.4,T*26 \n", "$IIHDT,123.4,T*26\r\n",
    "$IIHDT,\r123.4,T*26\n", "$IIHDT,\x8023.4,T*26\n", "$IIHDT,1\t.4,T*26\n", "1402160417499;N;$IIHDT,123.4,T*26\n",
    "\\c:1319460666*44\\$IIHDT,123.4,T*26\n", "2023-09-02T12:41:35.168Z $IIHDT,123.4,T*26\n",
    "garbage $IIHDT,123.4,T*26\n", "$II$IIHDT,123.4,T*26\n", "$IIXDR,A,x,D,R*00\n", "$IIHDM,12.5,M*17\n",
    "$IIHDT,123.4,T*2a\n",
]  # fmt: skip


@pytest.mark.parametrize("line", LINES)
def test_a_line_that_is_no_plain_sentence_is_read_in_its_place(tmp_path, line):
    others = "".join(map(sealed, USUAL))
    compared(written(tmp_path, others, line, others, line, line, others))


def tagged(block):
    return f"\\{block}*{checksum(block.encode()):02X}\\"


HEADS = [
    "1402160417499;N;", "1402160417499 ", "140216041749;;", "000000000012;N;", "99999999999;N;", "9999999999999;N;",
    "8589934591 ", "8589934592 ", "8589934592000;;", "8589934591999;;", "1402160417;gps 1;", "1402160417.499 ",
    "0.5 ", "1402160417.4995555 ", "1402160417.49955555 ", "14021604.123456789 ", "12. ", "12", "12;", "12;N",
    "12;N!;", "12;\\;", "12;\t;", "12;\xe9;", "12\t", "12  ", "12 gps ", "[12] ", "12.5.5 ", "-12 ", "12345678901 ",
    "99999999999999 ", "2023-09-02T12:41:35.168Z ", "2023-09-02 12:41:35 ", "2023-09-02T12:41:35;x;",
    "2023-09-02T12:41:35.168+00:00 ", "2024-02-29T23:59:59.999999Z ", "2023-02-29T00:00:00Z ",
    "2000-02-29T00:00:00Z ", "1970-01-01T00:00:00 ", "1969-12-31T23:59:59 ", "2099-12-31T23:59:59.99999999Z ",
    "2100-03-01T00:00:00Z ", "2242-03-16T12:56:32Z ", "2023-09-02T24:00:00Z ", "2023-09-02T12:60:00Z ",
    "2023-09-02T12:41:60Z ", "2023-09-31T12:41:00Z ", "2023-00-02T12:41:00Z ", "2023-13-02T12:41:00Z ",
    "2023-09-00T12:41:00Z ", "2023-09-02x12:41:00Z ", "2023-09-02T12-41:00Z ", "2023-09-02T12:41-00Z ",
    "2023:09-02T12:41:00Z ", "2023-09:02T12:41:00Z ", "2023-09-02T12:41:35. ", "2023-09-02T12:41:35.Z ",
    "2023-09-02T12:41:35.123456789Z ", "2023-09-02T12:41:3 ", "2023-09-02T12:41:355 ", "2023-09-02T12:41:35ZZ ",
    "2023-09-02T12:41:35Z", "2023-", "2023-09-02T12:41", "202a-09-02 ", "12:41:35.168 ", "12:41:35 gps ",
    tagged("c:1319460666"), tagged("s:gps,c:1319460666123,n:4"), tagged("g:1-2-3,s:r"), tagged("c:1.5"), tagged("c:"),
    tagged("c:12x"), tagged("c:12x,c:13"), tagged("c,c:12"), tagged("c:12,c:13"), tagged("xc:12"), tagged(""),
    tagged(","), tagged("s:$,c:12"), tagged("s:\t,c:12"), tagged("c:999999999999999"), tagged("c:9999999999999999"),
    tagged("c:8589934592"), "\\c:12*00\\", "\\c:12*2a\\", "\\c:12*2A", "\\", "\\\\", "\\c:12\\", "\\*00\\",
    "1" + tagged("c:12"), tagged("c:12") + " ", "#12 ", " ", "  12 ",
]  # fmt: skip


def test_a_time_before_a_sentence_is_read_in_any_shape(tmp_path):
    sentences = [sealed("IIHDT,123.4,T"), sealed("IIZZZ,!", "!"), sealed("II$HDT,1,T"), "$IIHDT,123.4,T*00\n", "\n"]
    lines = [head + sentence for head in HEADS for sentence in sentences]
    compared(written(tmp_path, sealed("IIHDT,123.4,T") * 300, *lines))
    compared(written(tmp_path, *(line.replace("\n", "\r\n") for line in [sealed("IIHDT,1,T") * 300, *lines])))


def test_times_before_sentences_are_those_of_the_reader_of_single_lines(tmp_path):
    draw = random.Random(10)
    times = [f"{draw.randrange(10 ** draw.randrange(1, 14))}" for _ in range(3000)]
    times += [
        f"{draw.randrange(10 ** draw.randrange(1, 11))}.{draw.randrange(10 ** draw.randrange(1, 9))}" for _ in times
    ]
    heads = [time + draw.choice((" ", ";N;")) for time in times] + [tagged(f"c:{time}") for time in times]
    compared(written(tmp_path, sealed("IIHDT,123.4,T") * 300, *(head + sealed("IIHDT,1,T") for head in heads)))


def test_dates_before_sentences_are_those_of_the_reader_of_single_lines(tmp_path):
    draw = random.Random(16)
    heads = [
        f"{draw.randrange(1968, 2103)}-{draw.randrange(14):02}-{draw.randrange(33):02}{draw.choice('T ')}"
        f"{draw.randrange(25):02}:{draw.randrange(61):02}:{draw.randrange(61):02}"
        f"{draw.choice(('', f'.{draw.randrange(10 ** draw.randrange(1, 10))}'))}{draw.choice(('', 'Z'))} "
        for _ in range(8000)
    ]
    compared(written(tmp_path, sealed("IIHDT,123.4,T") * 300, *(head + sealed("IIHDT,1,T") for head in heads)))


def test_the_last_line_may_lack_its_end(tmp_path):
    for cut in range(1, 12):
        compared(written(tmp_path, sealed("IIHDT,123.4,T") * 5, sealed("IIHDM,123.4,M")[:-cut]))


def test_logs_that_something_went_over_are_read_the_same_in_any_portions(tmp_path):
    draw = random.Random(8)
    for _ in range(12):
        log = bytearray("".join(sealed(draw.choice(USUAL + ODD)) for _ in range(800)).encode("latin-1"))
        for _ in range(draw.choice((0, 5, 100))):
            place = draw.randrange(len(log))
            match draw.randrange(3):
                case 0:
                    log[place] = draw.choice(b"0123456789,.*$!-AVNSEW\r\n\x00\xff")
                case 1:
                    del log[place : place + draw.randrange(1, 40)]
                case 2:
                    log[place:place] = draw.choice(LINES).encode("latin-1")
        (tmp_path / "log").write_bytes(log)
        compared(tmp_path / "log", size=draw.choice((1, 3000, 1 << 21)))


def test_values_of_every_kind_of_field_are_those_of_the_parser(tmp_path):
    draw = random.Random(9)
    words = [
        "",
        "A",
        "V",
        "N",
        "S",
        "E",
        "W",
        "T",
        "M",
        "K",
        "D",
        "R",
        "L",
        "12.5",
        "0",
        "359.9",
        "-7.25",
        "4530.125",
        "120000",
        "235959.99",
    ]
    words += ["010126", "311299", "7", "1", "2014", "WP1", "x y", "F", "f", "B", "C", "9999.9", "180.0"]
    bodies = [
        f"II{formatter.decode()}," + ",".join(draw.choices(words, k=draw.randrange(1, 16)))
        for formatter in SENTENCES
        for _ in range(150)
    ]
    draw.shuffle(bodies)
    compared(written(tmp_path, *map(sealed, bodies)))


def test_formatters_that_are_not_declared_keep_their_sentences(tmp_path):
    lines = [sealed("IIZZZ,1"), sealed("PGRMC,A"), sealed("GPZZZ,2"), sealed("IIZZY,3")]
    tables = by_formatter(list(open_sentences(written(tmp_path, *lines))))
    assert tables["ZZZ"][0].sentences == [lines[0].strip().encode(), lines[2].strip().encode()]
    assert tables["PGRMC"][0].kind is None
    assert set(tables) == {"ZZZ", "ZZY", "PGRMC"}


def test_of_too_many_formatters_those_that_nobody_declared_are_one_table(tmp_path, monkeypatch):
    monkeypatch.setattr(fast_nmea0183, "MOST_NAMES", 3)
    bodies = ["IIAAA,1", "IIBBB,2", "IICCC,3", "PXYZ,4", "IIAAA,5", "IIHDT,12.5,T"]
    tables = open_sentences(written(tmp_path, *map(sealed, bodies)))
    assert {table.formatter: table.line.tolist() for table in tables} == {
        "AAA": [1, 5],
        "BBB": [2],
        "": [3, 4],
        "HDT": [6],
    }


def test_measurements_are_objects(tmp_path):
    (table,) = open_sentences(written(tmp_path, sealed("IIXDR,C,21.5,C,AIR,P,1.013,B,BARO")))
    (measurements,) = listed(table.columns["transducers"])
    assert [(one.kind, one.value, one.unit, one.name) for one in measurements] == [
        ("C", 21.5, "C", "AIR"),
        ("P", 1.013, "B", "BARO"),
    ]


def test_a_recording_of_a_bus_has_no_sentences(tmp_path):
    path = written(tmp_path, "(1620807235.135421) can0 09F8017F#3E17B322B320590D\n")
    with pytest.raises(RecordingError, match=r"frames \(candump\), not NMEA 0183"):
        open_sentences(path)


def test_a_strict_reader_names_the_line(tmp_path):
    path = written(tmp_path, sealed("IIHDT,123.4,T") * 20, "$IIHDT,1,T*00\n")
    with pytest.raises(RecordingError, match=r"line 21: wrong check sum"):
        list(open_sentences(path, strict=True))
