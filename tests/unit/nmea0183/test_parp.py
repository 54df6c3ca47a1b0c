import pytest
from hypothesis import given
from hypothesis import strategies as st

from timonel.errors import EncodeError
from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import Fault, checksum, seal, verify
from timonel.nmea0183.parp import (
    Command,
    CommandRequested,
    CommandTransferred,
    PilotMode,
    Status,
    Verb,
    parse_command,
    parse_report,
    read_command,
    read_report,
)


def test_status_is_written_as_the_specification_prints_it() -> None:
    written = parp.status(PilotMode.HEADING_HOLD, 1925, 183.1, 2.5, 1)
    assert written == b"$PARP,STATUS,HEADING_HOLD,192.5,183.1,+2.5,01*18\r\n"
    assert parp.status(PilotMode.STANDBY, 0, 182.3, 0.0, 0) == b"$PARP,STATUS,STANDBY,000.0,182.3,+0.0,00*5D\r\n"


def test_transfers_and_requests_carry_the_computed_check_sums() -> None:
    assert parp.cmdtransfer(1, 2) == b"$PARP,CMDTRANSFER,01,02*7D\r\n"
    assert parp.cmdtransfer(0, 1) == b"$PARP,CMDTRANSFER,00,01*7F\r\n"
    assert parp.cmdrequest(2) == b"$PARP,CMDREQUEST,02*0A\r\n"


def test_unknown_values_of_a_status_are_empty_fields() -> None:
    assert parp.status(PilotMode.ALARM, None, None, None, 0) == seal("PARP,STATUS,ALARM,,,,00")


def test_an_unknown_pilot_mode_is_an_empty_field_and_not_standby() -> None:
    assert parp.status(None, 1800, 180.0, 0.0, 1) == seal("PARP,STATUS,,180.0,180.0,+0.0,01")


@pytest.mark.parametrize("setpoint", [None, 0, 1800])
def test_the_set_point_of_standby_is_zero(setpoint: int | None) -> None:
    assert parp.status(PilotMode.STANDBY, setpoint, 5.0, None, 0) == seal("PARP,STATUS,STANDBY,000.0,005.0,,00")


@pytest.mark.parametrize(
    ("heading", "text"),
    [(0.0, "000.0"), (-0.0, "000.0"), (5.04, "005.0"), (359.94, "359.9"), (359.97, "000.0"), (360.0, "000.0"),
     (-0.02, "000.0"), (-10.0, "350.0"), (725.0, "005.0")],
)  # fmt: skip
def test_a_heading_is_000_0_to_359_9(heading: float, text: str) -> None:
    assert parp.status(PilotMode.STANDBY, 0, heading, None, 0) == seal(f"PARP,STATUS,STANDBY,000.0,{text},,00")


@pytest.mark.parametrize(("tenths", "text"), [(3599, "359.9"), (3600, "000.0"), (-1, "359.9"), (3700, "010.0")])
def test_a_set_point_is_normalised_too(tenths: int, text: str) -> None:
    assert parp.status(PilotMode.TRACK, tenths, None, None, 1) == seal(f"PARP,STATUS,TRACK,{text},,,01")


@pytest.mark.parametrize(
    ("rudder", "text"),
    [(0.0, "+0.0"), (-0.0, "+0.0"), (-0.02, "+0.0"), (0.05, "+0.1"), (-35.0, "-35.0"), (3.8, "+3.8")],
)
def test_a_rudder_angle_has_its_sign_and_zero_is_positive(rudder: float, text: str) -> None:
    assert parp.status(PilotMode.STANDBY, 0, None, rudder, 0) == seal(f"PARP,STATUS,STANDBY,000.0,,{text},00")


def test_what_cannot_be_printed_is_our_callers_mistake() -> None:
    nan = float("nan")
    for call in (
        lambda: parp.status(PilotMode.STANDBY, 0, nan, None, 0),
        lambda: parp.status(PilotMode.STANDBY, 0, None, nan, 0),
        lambda: parp.status(PilotMode.STANDBY, 0, None, 361.0, 0),
        lambda: parp.status(PilotMode.STANDBY, 0, None, None, 5),
        lambda: parp.cmdtransfer(-1, 0),
        lambda: parp.cmdtransfer(1, 5),
        lambda: parp.cmdrequest(0),
        lambda: parp.command(Verb.SETHEADING, 1, float("inf")),
        lambda: parp.command(Verb.ENGAGE, 0),
        lambda: parp.command(Verb.ENGAGE, 5),
    ):
        with pytest.raises(EncodeError):
            call()


@pytest.mark.parametrize("verb", Verb)
def test_every_command_that_is_written_is_read(verb: Verb) -> None:
    for station in (1, 2, 3, 4):
        heading = 0 if verb is Verb.SETHEADING else None
        assert read_command(parp.command(verb, station)[:-2]) == Command(verb, station, heading_tenths=heading)


@pytest.mark.parametrize(
    ("degrees", "text"),
    [(200.0, "200.0"), (5.0, "005.0"), (359.97, "000.0"), (370.0, "010.0"), (-10.0, "350.0"), (0.25, "000.2")],
)
def test_a_heading_to_set_is_written_000_0_to_359_9(degrees: float, text: str) -> None:
    assert parp.command(Verb.SETHEADING, 2, degrees) == seal(f"PARP,SETHEADING,{text},02")


@pytest.mark.parametrize(
    ("text", "tenths"),
    [
        ("200.0", 2000), ("000.0", 0), ("0", 0), ("5", 50), ("359.9", 3599), ("359.94", 3599), ("359.96", 0),
        ("360", 0),
        ("370.0", 100), ("-10.0", 3500), ("-0.04", 0), ("-0.06", 3599), ("9999.9999", 2800), ("182.3499", 1823),
        ("0.05", 0),
        ("0.15", 2),
    ],
)  # fmt: skip
def test_a_heading_to_set_is_kept_in_tenths_modulo_a_turn(text: str, tenths: int) -> None:
    body = f"PARP,SETHEADING,{text},02".encode()
    assert parse_command(body) == Command(Verb.SETHEADING, station=2, heading_tenths=tenths)


@pytest.mark.parametrize("parameter", ["", "000.0", "12", "-3.5"])
def test_the_parameter_of_other_commands_means_nothing(parameter: str) -> None:
    assert parse_command(f"PARP,ENGAGE,{parameter},03".encode()) == Command(Verb.ENGAGE, station=3)


@pytest.mark.parametrize("verb", Verb)
def test_the_short_form_names_the_requester_and_is_for_answers_only(verb: Verb) -> None:
    answer = verb in (Verb.RELCMD, Verb.ACKCMD, Verb.DENYCMD)
    expected = Command(verb, requester=2) if answer else Fault.MALFORMED
    assert parse_command(f"PARP,{verb},02".encode()) == expected


@pytest.mark.parametrize(
    "body",
    [
        b"PARP,SETHEADING,,01",
        b"PARP,SETHEADING,nan,01",
        b"PARP,SETHEADING,inf,01",
        b"PARP,SETHEADING,1e2,01",
        b"PARP,SETHEADING,1000000000,01",
        b"PARP,SETHEADING,12345,01",
        b"PARP,SETHEADING,1.23456,01",
        b"PARP,SETHEADING,+10.0,01",
        b"PARP,SETHEADING,--10,01",
        b"PARP,SETHEADING,10.,01",
        b"PARP,SETHEADING,.5,01",
        b"PARP,SETHEADING, 10.0,01",
        b"PARP,SETHEADING,10.0 ,01",
        b"PARP,SETHEADING,10.0\n,01",
        b"PARP,SETHEADING,\xd9\xa1,01",
        b"PARP,ENGAGE,x,01",
        b"PARP,ENGAGE,000.0,00",
        b"PARP,ENGAGE,000.0,05",
        b"PARP,ENGAGE,000.0,1",
        b"PARP,ENGAGE,000.0,001",
        b"PARP,ENGAGE,000.0, 1",
        b"PARP,ENGAGE,000.0,01 ",
        b"PARP,ENGAGE,000.0,01\x00",
        b"PARP,ENGAGE,000.0,",
        b"PARP,ENGAGE,000.0,01,",
        b"PARP,ENGAGE,000.0,01,02",
        b"PARP,ENGAGE",
        b"PARP,RELCMD,00",
        b"PARP,RELCMD,2",
        b"PARP,RELCMD,",
    ],
)
def test_a_command_is_taken_to_the_letter_or_not_at_all(body: bytes) -> None:
    assert parse_command(body) is Fault.MALFORMED


@pytest.mark.parametrize(
    "body",
    [
        b"PARP,engage,000.0,01",
        b"PARP,ENGAGE ,000.0,01",
        b"PARP,ENGAGED,000.0,01",
        b"PARP,,000.0,01",
        b"PARP,NOSUCH,02",
        b"PARP,STATUS,STANDBY,000.0,182.3,+0.0,00",
        b"PARP,CMDTRANSFER,01,02",
        b"PARP,CMDREQUEST,02",
        b"PARP",
    ],
)
def test_a_word_that_is_no_command_is_unknown(body: bytes) -> None:
    assert parse_command(body) is Fault.UNKNOWN_COMMAND


@pytest.mark.parametrize("body", [b"IIHDT,182.3,T", b"parp,ENGAGE,000.0,01", b"", b"PARPX,ENGAGE,000.0,01"])
def test_any_other_sentence_is_no_command(body: bytes) -> None:
    assert parse_command(body) is Fault.UNKNOWN_SENTENCE
    assert parse_report(body) is Fault.UNKNOWN_SENTENCE


def test_a_command_needs_a_dollar_and_a_right_check_sum_of_two_digits() -> None:
    assert read_command(b"$PARP,REQCMD,000.0,01*1C") == Command(Verb.REQCMD, station=1)
    assert read_command(b"$PARP,REQCMD,000.0,01*1c") == Command(Verb.REQCMD, station=1)
    assert read_command(b"$PARP,REQCMD,000.0,01*00") is Fault.WRONG_CHECKSUM
    assert read_command(b"$PARP,REQCMD,000.0,01") is Fault.NO_CHECKSUM
    assert read_command(b"$PARP,REQCMD,000.0,01*1C ") is Fault.MALFORMED
    assert read_command(b"!PARP,REQCMD,000.0,01*1C") is Fault.MALFORMED
    assert read_report(b"!PARP,CMDREQUEST,02*0A") is Fault.MALFORMED
    assert read_report(b"$PARP,CMDREQUEST,02*1B") is Fault.WRONG_CHECKSUM


def test_a_station_reads_what_the_concentrator_says() -> None:
    written = parp.status(PilotMode.HEADING_HOLD, 1925, 183.1, -2.5, 1)[:-2]
    assert read_report(written) == Status(PilotMode.HEADING_HOLD, "HEADING_HOLD", 192.5, 183.1, -2.5, 1)
    assert read_report(parp.cmdtransfer(0, 4)[:-2]) == CommandTransferred(previous=0, commander=4)
    assert read_report(parp.cmdrequest(3)[:-2]) == CommandRequested(station=3)


def test_a_station_reads_empty_fields_as_not_known() -> None:
    assert parse_report(b"PARP,STATUS,ALARM,,,,00") == Status(PilotMode.ALARM, "ALARM", None, None, None, 0)


@pytest.mark.parametrize("word", ["", "WIND_VANE", "STANDBY_"])
def test_a_mode_that_a_station_does_not_know_is_not_standby(word: str) -> None:
    report = parse_report(f"PARP,STATUS,{word},000.0,182.3,+0.0,01".encode())
    assert report == Status(None, word, 0.0, 182.3, 0.0, 1)


@pytest.mark.parametrize(
    "body",
    [
        b"PARP,STATUS,standby,000.0,182.3,+0.0,01",
        b"PARP,STATUS,STANDBY,000.0,182.3,+0.0,05",
        b"PARP,STATUS,STANDBY,000.0,182.3,+0.0,",
        b"PARP,STATUS,STANDBY,000.0,182.3,+0.0",
        b"PARP,STATUS,STANDBY,000.0,182.3,+0.0,01,",
        b"PARP,STATUS,STANDBY,nan,182.3,+0.0,01",
        b"PARP,STATUS,STANDBY,000.0,-1.0,+0.0,01",
        b"PARP,STATUS,STANDBY,000.0,182.3,++1,01",
        b"PARP,CMDTRANSFER,01",
        b"PARP,CMDTRANSFER,01,02,03",
        b"PARP,CMDTRANSFER,01,05",
        b"PARP,CMDREQUEST,00",
        b"PARP,CMDREQUEST,2",
    ],
)
def test_a_malformed_report_is_none(body: bytes) -> None:
    assert parse_report(body) is Fault.MALFORMED


# What is put together of parts, and read at once, beside the long way ----------------------------------------

DEGREES = st.floats(-1000.0, 1000.0)


@given(
    st.none() | st.sampled_from(PilotMode),
    st.none() | st.integers(-5000, 5000),
    st.none() | DEGREES,
    st.none() | st.floats(-360.0, 360.0),
    st.integers(0, 4),
)
def test_a_status_of_parts_is_its_text_with_its_check_sum(
    mode: PilotMode | None, setpoint: int | None, heading: float | None, rudder: float | None, commander: int
) -> None:
    course = 0 if mode is PilotMode.STANDBY else setpoint
    texts = [
        "" if mode is None else mode.value,
        "" if course is None else f"{course % 3600 / 10:05.1f}",
        "" if heading is None else f"{round(heading * 10) % 3600 / 10:05.1f}",
        "" if rudder is None else f"{rudder:+z.1f}",
        f"{commander:02d}",
    ]
    assert parp.status(mode, setpoint, heading, rudder, commander) == seal(f"PARP,STATUS,{','.join(texts)}")


@pytest.mark.parametrize("station", [1, 2, 3, 4])
def test_every_heading_to_set_is_read_at_once_as_it_is_the_long_way(station: int) -> None:
    for tenths in range(3600):
        sentence = parp.command(Verb.SETHEADING, station, tenths / 10)[:-2]
        body = verify(sentence)
        assert isinstance(body, bytes)
        assert read_command(sentence) == parse_command(body) == Command(Verb.SETHEADING, station, None, tenths)


@given(st.integers(0, 27), st.integers(0, 255).filter(lambda byte: byte != ord("$")), st.booleans())
def test_a_heading_to_set_with_one_byte_changed_is_read_as_it_is_the_long_way(
    place: int, byte: int, sealed: bool
) -> None:
    sentence = bytearray(parp.command(Verb.SETHEADING, 2, 200.0)[:-2])
    sentence[place] = byte
    if sealed and 1 <= place < 25:
        sentence[-2:] = checksum(bytes(sentence[1:-3])).to_bytes().hex().upper().encode()
    body = verify(bytes(sentence))
    command = body if isinstance(body, Fault) else parse_command(body)
    assert read_command(bytes(sentence)) == (command if place else Fault.MALFORMED)


@pytest.mark.parametrize(
    "sentence", [b"$PARP,SETHEADING,200.0,02*3", b"$PARP,SETHEADING,200.0,02", b"$PARP,SETHEADING,"]
)
def test_a_heading_to_set_that_is_cut_off_is_none(sentence: bytes) -> None:
    assert isinstance(read_command(sentence), Fault)
