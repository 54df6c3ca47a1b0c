"""What is written for a value, and what is read from a field, sentence by sentence."""

import datetime

import pytest

from timonel.errors import EncodeError
from timonel.nmea0183.checksum import Fault, checksum, seal
from timonel.nmea0183.dialect import encode_ar10
from timonel.nmea0183.registry import SENTENCES, parse
from timonel.nmea0183.sentence import Sentence
from timonel.nmea0183.sentences import (
    ACK,
    ACN,
    ALC,
    ALF,
    ALR,
    APB,
    ARC,
    DBK,
    DBS,
    DBT,
    DPT,
    GGA,
    GLL,
    HBT,
    HDG,
    HDM,
    HDT,
    HSC,
    HTC,
    HTD,
    MTW,
    MWD,
    MWV,
    RMB,
    RMC,
    ROT,
    RSA,
    THS,
    VDR,
    VHW,
    VLW,
    VTG,
    XDR,
    XTE,
    ZDA,
    AlertCategory,
    AlertCommand,
    AlertCondition,
    AlertUrgency,
    HeadingMode,
    Listed,
    Mode,
    NavigationalStatus,
    Reference,
    RudderDirection,
    SpeedUnit,
    SteeringMode,
    Transducer,
    TurnMode,
    WindReference,
)
from timonel.nmea0183.sentences.alarm import listing
from timonel.nmea0183.sentences.transducer import split
from timonel.nmea0183.sentences.water import Depth

NOON = 12 * 3600.0
POSITION = {"latitude_deg": 43.5, "longitude_deg": -8.25}
ROUTE = {"cross_track_error_nm": 0.25, "destination": "CABO", "bearing_deg": 213.9, "mode": Mode.AUTONOMOUS}

# Formats: NMEA 0183 as spec/boat.md and the standard have them; HTC and HTD are the manuals' own examples.
WRITTEN = [
    (HDT(182.3), "IIHDT,182.3,T"),
    (HDM(178.1), "IIHDM,178.1,M"),
    (HDG(180.0, -1.5, 4.0), "IIHDG,180.0,1.5,W,4.0,E"),
    (HDG(180.0), "IIHDG,180.0,,,,"),
    (THS(182.3, HeadingMode.AUTONOMOUS), "IITHS,182.3,A"),
    (ROT(-3.04, True), "IIROT,-3.0,A"),
    (VHW(speed_kn=5.0, speed_kmh=9.26), "IIVHW,,,,,5.0,N,9.3,K"),
    (VHW(182.3, 178.3, 5.0, 9.26), "IIVHW,182.3,T,178.3,M,5.0,N,9.3,K"),
    (VLW(9417.4, 43.25), "IIVLW,9417.40,N,43.25,N"),
    (DPT(3.2, 0.5), "IIDPT,3.2,0.5"),
    (DPT(3.2, None), "IIDPT,3.2,"),
    (DPT(3.2, -1.1, 100.0), "IIDPT,3.2,-1.1,100.0"),
    (DBT(25.3, 7.7, 4.2), "IIDBT,25.3,f,7.7,M,4.2,F"),
    (DBS(25.3, 7.7, 4.2), "IIDBS,25.3,f,7.7,M,4.2,F"),
    (DBK(None, 7.7, None), "IIDBK,,f,7.7,M,,F"),
    (GLL(**POSITION, time=NOON, valid=True, mode=Mode.AUTONOMOUS), "IIGLL,4330.000000,N,00815.000000,W,120000,A,A"),
    (
        RMC(NOON + 0.25, True, 43.5, -8.25, 6.1, 84.4, datetime.date(2026, 8, 1), -3.1, Mode.DIFFERENTIAL),
        "IIRMC,120000.25,A,4330.000000,N,00815.000000,W,6.1,84.4,010826,3.1,W,D",
    ),
    (
        GGA(NOON, 43.5, -8.25, 1, 8, 0.9, 12.3, 54.1, 3.0, "0120"),
        "IIGGA,120000,4330.000000,N,00815.000000,W,1,08,0.9,12.3,M,54.1,M,3,0120",
    ),
    (GGA(quality=0), "IIGGA,,,,,,0,,,,M,,M,,"),
    (VTG(84.4, 87.5, 6.1, 11.3, Mode.AUTONOMOUS), "IIVTG,84.4,T,87.5,M,6.1,N,11.3,K,A"),
    (VTG(course_deg=84.4, speed_kn=6.1), "IIVTG,84.4,T,,M,6.1,N,,K,"),
    (ZDA(NOON, 1, 8, 2026, -2, 0), "IIZDA,120000,01,08,2026,-02,00"),
    (MTW(18.4), "IIMTW,18.4,C"),
    (MWV(214.8, WindReference.RELATIVE, 10.0, SpeedUnit.KNOTS, True), "IIMWV,214.8,R,10.0,N,A"),
    (MWD(125.3, 124.6, 5.6, 2.9), "IIMWD,125.3,T,124.6,M,5.6,N,2.9,M"),
    (VDR(90.0, 93.0, 1.2), "IIVDR,90.0,T,93.0,M,1.2,N"),
    (RSA(-4.25, True), "IIRSA,-4.2,A,,"),
    (
        APB(
            True,
            True,
            **ROUTE,
            arrived=False,
            perpendicular_passed=False,
            leg_bearing_deg=213.9,
            leg_bearing_reference=Reference.TRUE,
            bearing_reference=Reference.TRUE,
            heading_to_steer_deg=211.0,
            heading_to_steer_reference=Reference.MAGNETIC,
        ),
        "IIAPB,A,A,0.250,L,N,V,V,213.9,T,CABO,213.9,T,211.0,M,A",
    ),
    (
        RMB(True, **ROUTE, **POSITION, origin="RIA", range_nm=4.25, closing_speed_kn=-0.1, arrived=False),
        "IIRMB,A,0.25,L,RIA,CABO,4330.000000,N,00815.000000,W,4.2,213.9,-0.1,V,A",
    ),
    (XTE(True, True, -0.25, Mode.AUTONOMOUS), "IIXTE,A,A,0.250,R,N,A"),
    (XDR((Transducer("A", -2.5, "D", "ROLL"), Transducer("P", 1.026, "B", None))), "IIXDR,A,-2.5,D,ROLL,P,1.026,B,"),
    (HSC(45.5, 49.0), "IIHSC,45.5,T,49.0,M"),
    (ALR(NOON, 41, True, False, "PILOT OFF COURSE"), "IIALR,120000,041,A,V,PILOT OFF COURSE"),
    (ACK(41), "IIACK,041"),
    (ACN(NOON, None, 41, None, AlertCommand.SILENCE, "C"), "IIACN,120000,,041,,S,C"),
    (ARC(NOON, "ARP", 41, 1, AlertCommand.ACKNOWLEDGE), "IIARC,120000,ARP,041,1,A"),
    (HBT(30, True, 4), "IIHBT,30,A,4"),
    (
        ALF(
            2,
            1,
            3,
            NOON,
            AlertCategory.B,
            AlertUrgency.WARNING,
            AlertCondition.UNACKNOWLEDGED,
            "ARP",
            3048,
            2,
            7,
            1,
            "Lost target",
        ),
        "IIALF,2,1,3,120000,B,W,V,ARP,3048,2,7,1,Lost target",
    ),
    (
        ALC(2, 1, 5, (Listed("FUR", 3048, 2, 7), Listed(None, 41, None, None))),
        "IIALC,02,01,05,2,FUR,3048,2,7,,41,,",
    ),
    (ALC(), "IIALC,01,01,00,0"),
    (
        HTC(
            False,
            12.0,
            RudderDirection.LEFT,
            SteeringMode.RUDDER_CONTROL,
            TurnMode.RADIUS,
            radius_nm=0.5,
            reference=Reference.MAGNETIC,
        ),
        "IIHTC,V,12.0,L,R,R,,,0.50,,,,,M",
    ),
]


@pytest.mark.parametrize(("sentence", "body"), WRITTEN, ids=lambda value: str(value)[:40])
def test_a_sentence_is_written_as_the_standard_prints_it(sentence: Sentence, body: str) -> None:
    assert sentence.encode() == seal(body)


@pytest.mark.parametrize(("sentence", "body"), WRITTEN, ids=lambda value: str(value)[:40])
def test_what_is_written_is_read_as_it_was_printed(sentence: Sentence, body: str) -> None:
    read = parse(seal(body)[:-2])
    assert type(read) is type(sentence)
    assert read.encode() == seal(body)


def test_every_typed_sentence_is_in_the_table_above() -> None:
    assert {type(sentence) for sentence, _ in WRITTEN} | {HTD} == set(SENTENCES.values())


def test_the_manuals_examples_of_heading_control_are_understood_and_written_again() -> None:
    report = HTD(
        override=False,
        steering_mode=SteeringMode.HEADING_CONTROL,
        turn_mode=TurnMode.NOT_CONTROLLED,
        rudder_limit_deg=25.0,
        off_heading_limit_deg=20.0,
        heading_to_steer_deg=190.4,
        reference=Reference.TRUE,
        within_rudder_limit=True,
        within_off_heading_limit=True,
        within_off_track_limit=True,
        heading_deg=186.4,
    )
    assert parse(b"$AGHTD,V,,,H,N,25.0,20.0,,,190.4,,,T,A,A,A,186.4*35") == report
    assert report.encode("AG") == b"$AGHTD,V,,,H,N,25.0,20.0,,,190.4,,,T,A,A,A,186.4*35\r\n"
    command = parse(b"$EIHTC,V,,,H,N,,,,,45.5,,,M,C*17")  # a 14th field of one maker
    assert command == HTC(
        override=False,
        steering_mode=SteeringMode.HEADING_CONTROL,
        turn_mode=TurnMode.NOT_CONTROLLED,
        heading_to_steer_deg=45.5,
        reference=Reference.MAGNETIC,
    )


def test_a_report_of_heading_control_is_never_taken_for_a_command() -> None:
    assert not isinstance(HTD(), HTC)


@pytest.mark.parametrize(
    ("heading", "text"),
    [(359.94, "359.9"), (359.96, "0.0"), (360.0, "0.0"), (0.0, "0.0"), (-0.0, "0.0"), (0.25, "0.2")],
)
def test_a_rounded_angle_is_never_360(heading: float, text: str) -> None:
    assert HDT(heading).encode() == seal(f"IIHDT,{text},T")


@pytest.mark.parametrize("tiny", [-0.0, -0.04, 0.04])
def test_a_rounded_zero_has_no_minus_and_no_west(tiny: float) -> None:
    assert ROT(tiny, True).encode() == seal("IIROT,0.0,A")
    assert HDG(1.0, tiny, tiny).encode() == seal("IIHDG,1.0,0.0,E,0.0,E")


@pytest.mark.parametrize(
    ("latitude", "longitude", "text"),
    [
        (59 + 59.99999999 / 60, 8 + 59.99999999 / 60, "6000.000000,N,00900.000000,E"),
        (-90.0, -180.0, "9000.000000,S,18000.000000,W"),
        (90.0, 180.0, "9000.000000,N,18000.000000,E"),
        (-1e-9, -1e-9, "0000.000000,N,00000.000000,E"),
        (43.3623441, -8.4115401, "4321.740646,N,00824.692406,W"),
        (43.3623442, -8.4115402, "4321.740652,N,00824.692412,W"),
    ],
)
def test_minutes_carry_and_1e_7_degrees_survive(latitude: float, longitude: float, text: str) -> None:
    sentence = GLL(latitude, longitude)
    assert sentence.encode() == seal(f"IIGLL,{text},,,")
    read = parse(sentence.encode()[:-2])
    assert isinstance(read, GLL)
    assert read.latitude_deg == pytest.approx(latitude, abs=1e-8)
    assert read.longitude_deg == pytest.approx(longitude, abs=1e-8)


@pytest.mark.parametrize(
    ("text", "degrees"), [("0543.2100", 5.7201666667), ("543.2100", 5.7201666667), ("43.21", 0.7201666667)]
)
def test_leading_zeros_of_a_position_may_lack(text: str, degrees: float) -> None:
    read = parse(seal(f"IIGLL,{text},S,{text},W,,,")[:-2])
    assert isinstance(read, GLL)
    assert read.latitude_deg == pytest.approx(-degrees)
    assert read.longitude_deg == pytest.approx(-degrees)


@pytest.mark.parametrize(
    ("seconds", "text"),
    [
        (0.0, "000000"),
        (0.004, "000000"),
        (45296.0, "123456"),
        (45296.7, "123456.70"),
        (45296.78, "123456.78"),
        (45296.999, "123457"),
        (59.999, "000100"),
        (86399.999, "235959.99"),
        (86400.0, "235960"),
        (86400.5, "235960.50"),
        (86400.999, "235960.99"),
    ],
)
def test_a_time_is_rounded_but_never_into_the_next_day(seconds: float, text: str) -> None:
    assert ZDA(seconds).encode() == seal(f"IIZDA,{text},,,,,")


def test_a_leap_second_is_read_at_midnight_only() -> None:
    assert parse(seal("IIZDA,235960.50,31,12,2026,00,00")[:-2]) == ZDA(86400.5, 31, 12, 2026, 0, 0)
    assert parse(seal("IIZDA,120060,31,12,2026,00,00")[:-2]) is Fault.MALFORMED


@pytest.mark.parametrize(
    ("text", "date"),
    [
        ("010180", datetime.date(1980, 1, 1)),
        ("311279", datetime.date(2079, 12, 31)),
        ("290224", datetime.date(2024, 2, 29)),
    ],
)
def test_two_digits_of_a_year_are_1980_to_2079(text: str, date: datetime.date) -> None:
    read = parse(seal(f"IIRMC,,,,,,,,,{text},,,")[:-2])
    assert read == RMC(date=date)
    assert read.encode() == seal(f"IIRMC,,,,,,,,,{text},,,")


def test_a_full_recommended_minimum_fits_into_82_characters() -> None:
    full = RMC(
        86399.99, True, 89.99999, -179.99999, 99.9, 359.9, datetime.date(2026, 12, 31), -179.9, Mode.RTK_FIXED,
        NavigationalStatus.SAFE,
    )  # fmt: skip
    assert len(full.encode("GP")) == 82


@pytest.mark.parametrize("mode", ["E", "M", "S", "N", "?", "Z", "1"])
def test_a_position_of_any_mode_but_the_valid_ones_is_not_valid(mode: str) -> None:
    read = parse(seal(f"IIRMC,120000,A,4330.0,N,00815.0,W,6.1,84.4,010826,,,{mode}")[:-2])
    assert isinstance(read, RMC)
    assert read.valid is False
    assert read.mode is (Mode(mode) if mode in "EMS" else Mode.NOT_VALID)


@pytest.mark.parametrize("mode", ["A", "D", "P", "R", "F", ""])
def test_a_position_of_a_valid_mode_or_of_an_old_sender_is_as_valid_as_its_status(mode: str) -> None:
    for status, valid in (("A", True), ("V", False), ("", None), ("X", False)):
        read = parse(seal(f"IIGLL,4330.0,N,00815.0,W,120000,{status},{mode}")[:-2])
        assert isinstance(read, GLL)
        assert read.valid is valid


@pytest.mark.parametrize("mode", [Mode.ESTIMATED, Mode.MANUAL, Mode.SIMULATOR, Mode.NOT_VALID])
def test_status_a_is_never_written_beside_a_mode_that_forbids_it(mode: Mode) -> None:
    assert GLL(valid=True, mode=mode).encode() == seal(f"IIGLL,,,,,,V,{mode}")
    assert XTE(True, True, 0.0, mode).encode() == seal(f"IIXTE,V,A,0.000,L,N,{mode}")


def test_an_unknown_mode_of_a_heading_is_not_valid() -> None:
    assert parse(seal("IITHS,182.3,Q")[:-2]) == THS(182.3, HeadingMode.NOT_VALID)


def test_an_unknown_navigational_status_says_nothing() -> None:
    read = parse(seal("IIRMC,,,,,,,,,,,,A,Q")[:-2])
    assert read == RMC(mode=Mode.AUTONOMOUS, navigational_status=NavigationalStatus.NOT_GIVEN)


def test_fields_that_older_editions_lack_are_not_available() -> None:
    assert parse(seal("GPGLL,4330.0,N,00815.0,W")[:-2]) == GLL(43.5, -8.25)
    assert parse(seal("02MWV,327.6,R,1.9,N")[:-2]) == MWV(327.6, WindReference.RELATIVE, 1.9, SpeedUnit.KNOTS)


def test_a_magnitude_without_its_direction_is_not_available() -> None:
    assert parse(seal("IIHDG,180.0,1.5,,4.0,")[:-2]) == HDG(180.0)
    assert parse(seal("IIGLL,4330.0,,00815.0,,,,")[:-2]) == GLL()


@pytest.mark.parametrize(
    "body",
    [
        "IIVHW,,,5.0,N,9.3,K",  # the concentrator's 1.0 print: knots where the magnetic heading's letter stands
        "IIHDT,182.3,M",
        "IIHDT,1e2,T",
        "IIHDT,1E2,T",
        "IIHDT,nan,T",
        "IIHDT,NaN,T",
        "IIHDT,inf,T",
        "IIHDT, 1.0,T",
        "IIHDT,1.0 ,T",
        "IIHDT,+1.0,T",
        "IIHDT,1_0,T",
        "IIHDT,0x1,T",
        "IIHDT,-1.0,T",
        "IIHDT,360.1,T",
        "IIHDT,1.2.3,T",
        "IIHDT,.,T",
        "IIHDT," + "9" * 60 + ",T",
        "IIHDG,180.0,-1.5,E,,",
        "IIHDG,180.0,1.5,N,,",
        "IIHDG,180.0,x,,,",
        "IIGLL,9000.1,N,00815.0,W,,,",
        "IIGLL,4360.0,N,00815.0,W,,,",
        "IIGLL,-4330.0,N,00815.0,W,,,",
        "IIGLL,4330.0,E,00815.0,W,,,",
        "IIGLL,4330.0,N,18000.1,W,,,",
        "IIGLL,4330.0,N,x,,,,",
        "IIZDA,240000,,,,,",
        "IIZDA,126000,,,,,",
        "IIZDA,12345,,,,,",
        "IIZDA,1234567,,,,,",
        "IIZDA,1234-1,,,,,",
        "IIZDA,123456.x,,,,,",
        "IIZDA,120000,32,08,2026,00,00",
        "IIZDA,120000,1.5,08,2026,00,00",
        "IIRMC,,,,,,,,,310226,,,",
        "IIRMC,,,,,,,,,31022026,,,",
        "IIRMC,,,,,,,,,-10226,,,",
        "IIMWV,214.8,X,10.0,N,A",
        "IIMWV,214.8,R,10.0,kn,A",
        "IIHTC,V,,,Q,N,,,,,45.5,,,M",
        "IIXDR,A,1.0,D",
        "IIXDR,A,-1.-3,D,TRIM",
        "IIXTE,A,A,0.25,L,K,A",
        "IIALR,120000,041,A,V,\x00",
        "IIALF,2,1,3,120000,B,W,X,ARP,3048,2,7,1,Lost target",
        "IIALC,01,01,00,2,FUR,3048,2,7",
        "IIALC,01,01,00,1,FUR,3048,2",
        "IIALC,01,01,00,1,FUR,-3,2,1",
        "IIALC,01,02,00,0",
        "IIALC,01,00,00,0",
        "IIALC,01",
        "IIALC,01,01,00,x",
        "IIALR,120000,041,A,V,^07",
    ],
)  # fmt: skip
def test_a_malformed_field_makes_no_sentence(body: str) -> None:
    sentence = b"$%b*%02X" % (body.encode(), checksum(body.encode()))
    assert parse(sentence) is Fault.MALFORMED


@pytest.mark.parametrize(
    "body", ["PGRMC,A,1,2", "PARP,HDT", "IIHDT", "IIXYZ,1", "HDT,182.3,T", "", "AIVDM,1,1,,A,13u,0"]
)
def test_an_address_that_is_not_of_a_typed_sentence_is_unknown(body: str) -> None:
    assert parse(seal(body)[:-2]) is Fault.UNKNOWN_SENTENCE


def test_an_8_bit_byte_is_never_taken_for_a_letter() -> None:
    body = b"IIHDG,180.0,1.5,\xc5,,"
    assert parse(b"$%b*%02X" % (body, checksum(body))) is Fault.MALFORMED


def test_a_sentence_without_its_check_sum_is_not_read() -> None:
    assert parse(b"$IIHDT,182.3,T") is Fault.NO_CHECKSUM
    assert parse(b"$IIHDT,182.3,T*28") is Fault.WRONG_CHECKSUM


@pytest.mark.parametrize("talker", ["GP", "II", "AG", "ZZ", "23", "U1"])
def test_any_talker_is_read_and_written(talker: str) -> None:
    assert parse(HDT(182.3).encode(talker)[:-2]) == HDT(182.3)
    assert HDT(182.3).encode(talker)[1:3] == talker.encode()


def test_reserved_and_accented_characters_travel_escaped() -> None:
    name = "A,B*$!\\^~ñ"
    written = RMB(destination=name).encode()
    assert b"A^2CB^2A^24^21^5C^5E^7E^F1" in written
    assert parse(written[:-2]) == RMB(destination=name)
    assert parse(seal("IIRMB,,,,,50^,,,,,,,,,")[:-2]) == RMB(destination="50^")


@pytest.mark.parametrize(
    ("sentence", "text"),
    [
        (HDT(361.0), "HDT.heading_deg: 361.0 is outside 0..360"),
        (HDT(float("nan")), "HDT.heading_deg: nan is outside 0..360"),
        (ROT(float("inf"), True), r"ROT.rate_deg_min: inf is outside"),
        (HDG(1.0, 181.0), "HDG.deviation_deg: 181.0 is outside -180..180"),
        (GLL(90.1, 0.0), "GLL.latitude_deg: 90.1 is outside -90..90"),
        (GLL(0.0, -180.1), "GLL.longitude_deg: -180.1 is outside -180..180"),
        (ZDA(86401.0), "ZDA.time: 86401.0 is outside 0..86401"),
        (ZDA(0.0, 32), "ZDA.day: 32 is outside 1..31"),
        (RMC(date=datetime.date(1979, 12, 31)), "RMC.date: 1979 is outside 1980..2079"),
        (ALR(text="über\n"), "ALR.text: .* is not printable ISO 8859-1"),
        (ALR(text="€"), "ALR.text: '€' is not printable ISO 8859-1"),
        (XDR(), "XDR.transducers: at least one is needed"),
        (XDR((Transducer("A", float("nan"), "D", "X"),)), "XDR.value: nan is outside"),
        (ALR(text="x" * 80), "IIALR: 96 characters, a sentence has at most 82"),
    ],
)
def test_a_value_that_does_not_fit_is_our_callers_mistake(sentence: Sentence, text: str) -> None:
    with pytest.raises(EncodeError, match=text):
        sentence.encode()


def test_a_leg_too_long_for_its_fields_is_written_as_their_largest_value() -> None:
    far = RMB(cross_track_error_nm=-25.0, range_nm=1234.0)
    assert far.encode() == seal("IIRMB,,9.99,R,,,,,,,999.9,,,,")


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (-0.0, "0"), (-0.000001, "0"), (100.0, "100"), (1.026, "1.026"), (-2.5, "-2.5"), (0.123456, "0.12346"),
     (None, "")],
)  # fmt: skip
def test_a_transducer_value_has_the_decimals_it_needs(value: float | None, text: str) -> None:
    assert XDR((Transducer("A", value, "D", "X"),)).encode() == seal(f"IIXDR,A,{text},D,X")


def test_many_transducers_are_split_over_as_few_sentences_as_hold_them() -> None:
    transducers = [Transducer("C", 20.0 + index, "C", f"TANK{index}") for index in range(12)]
    sentences = split(transducers)
    assert [transducer for sentence in sentences for transducer in sentence.transducers] == transducers
    lengths = [len(sentence.encode()) for sentence in sentences]
    assert all(length <= 82 for length in lengths)
    assert all(length + 14 > 82 for length in lengths[:-1])
    assert split([]) == []


def test_the_ar_1_0_dialect_prints_three_sentences_as_the_original_does() -> None:
    log = VHW(182.3, 178.3, 5.0, 9.26)
    assert encode_ar10(log) == seal("IIVHW,,,5.0,N,9.3,K")
    assert encode_ar10(DPT(3.2, 0.5, 100.0)) == seal("IIDPT,3.2,0.0")
    position = GLL(43.5, -8.25, NOON + 0.99, True, Mode.AUTONOMOUS)
    assert encode_ar10(position, "GP") == seal("GPGLL,4330.000000,N,00815.000000,W,120000,A")
    assert encode_ar10(GLL(43.5, -8.25, None, False, Mode.NOT_VALID), "GP") == seal(
        "GPGLL,4330.000000,N,00815.000000,W,,V"
    )


def test_the_ar_1_0_dialect_is_the_standard_for_all_other_sentences() -> None:
    for sentence, _ in WRITTEN:
        if not isinstance(sentence, VHW | DPT | GLL):
            assert encode_ar10(sentence, "GP") == sentence.encode("GP")


def test_sentences_that_share_their_fields_do_not_share_their_formatter() -> None:
    with pytest.raises(NotImplementedError):
        Sentence().encode()
    assert issubclass(DBT, Depth)
    assert DBT(depth_m=1.0).encode()[1:6] == b"IIDBT"
    assert DBK(depth_m=1.0).encode()[1:6] == b"IIDBK"
    assert isinstance(parse(DBS(depth_m=1.0).encode()[:-2]), DBS)


def test_a_list_of_alerts_takes_as_few_sentences_as_hold_it() -> None:
    alerts = [Listed("ARP", 400 + number, 1, 99) for number in range(20)]
    sentences = listing(alerts, 7)
    assert [sentence.number for sentence in sentences] == list(range(1, len(sentences) + 1))
    assert {(sentence.total, sentence.sequence) for sentence in sentences} == {(len(sentences), 7)}
    assert [alert for sentence in sentences for alert in sentence.entries] == alerts
    lengths = [len(sentence.encode()) for sentence in sentences]
    assert all(length <= 82 for length in lengths)
    assert all(length + 13 > 82 for length in lengths[:-1])
    assert listing([], 7) == [ALC(1, 1, 7)]


def test_a_list_of_alerts_has_at_most_ninety_nine_sentences() -> None:
    sentences = listing([Listed("ARP", 400 + number, 1, 99) for number in range(1000)], 0)
    assert len(sentences) == sentences[-1].total == 99
