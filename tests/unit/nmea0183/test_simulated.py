import pytest

from timonel.errors import EncodeError
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.fields import Mode
from timonel.nmea0183.registry import SENTENCES, parse
from timonel.nmea0183.sentences import GGA, GLL, RMC, THS, VTG, XTE, HeadingMode
from timonel.nmea0183.simulated import MODES, simulated

RMC_LINE = seal("GPRMC,101500,A,3930.00,N,00236.00,E,5.8,182.3,270726,2.1,E,A")


def body(line: bytes) -> list[str]:
    return line.decode().rstrip()[1:-3].split(",")


def test_every_sentence_with_a_mode_is_known() -> None:
    """The layouts of the typed sentences say which have one."""
    assert {name.decode() for name, kind in SENTENCES.items() if "mode" in kind.__struct_fields__} == set(MODES)


@pytest.mark.parametrize(
    "sentence",
    [
        GLL(39.5, 2.6, 36900.0, True, Mode.AUTONOMOUS),
        VTG(182.3, 180.2, 5.8, 10.7, Mode.DIFFERENTIAL),
        XTE(0.02, True, mode=Mode.AUTONOMOUS),
    ],
)
def test_the_mode_becomes_simulator_and_the_status_void(sentence: GLL | VTG | XTE) -> None:
    marked = parse(simulated(sentence.encode()).rstrip())
    assert isinstance(marked, GLL | VTG | XTE)
    assert marked.mode is Mode.SIMULATOR
    assert getattr(marked, "valid", False) is False


def test_rmc_keeps_all_else() -> None:
    before, after = body(RMC_LINE), body(simulated(RMC_LINE))
    assert [number for number, pair in enumerate(zip(before, after, strict=True)) if pair[0] != pair[1]] == [2, 12]
    marked = parse(simulated(RMC_LINE).rstrip())
    assert isinstance(marked, RMC)
    assert (marked.mode, marked.valid) == (Mode.SIMULATOR, False)


def test_a_sentence_older_than_the_mode_gets_one() -> None:
    assert body(simulated(seal("GPGLL,3930.00,N,00236.00,E,101500,A"))) == [
        "GPGLL", "3930.00", "N", "00236.00", "E", "101500", "V", "S",
    ]  # fmt: skip


def test_a_true_heading_and_a_fix_are_marked_in_their_own_way() -> None:
    ths = parse(simulated(THS(182.3, HeadingMode.AUTONOMOUS).encode()).rstrip())
    assert isinstance(ths, THS)
    assert ths.mode is HeadingMode.SIMULATOR
    gga = parse(simulated(GGA(36900.0, 39.5, 2.6, 1).encode()).rstrip())
    assert isinstance(gga, GGA)
    assert gga.quality == 8


@pytest.mark.parametrize(
    "line",
    [
        seal("GPGLL,,,,,,V,N"),
        seal("GPTHS,,V"),
        seal("GPGGA,,,,,,0,,,,,,,,"),
        seal("IIHDT,182.3,T"),
        seal("PARP,STATUS,HEADING,182.3,182.3,+0.0,01"),
        seal("PGRMC,A,1,2,3,4,5,6,7,8,9,10,11"),
        b"$GPGLL,3930.00,N,00236.00,E,101500,A*00\r\n",
        b"#\x01\x02",
        b"",
    ],
)
def test_what_is_not_valid_or_has_no_mode_stays_as_it_is(line: bytes) -> None:
    assert simulated(line) == line


def test_a_sentence_without_room_for_the_mark_is_an_error() -> None:
    with pytest.raises(EncodeError):
        simulated(seal("GPRMB,A,1.00,L,WAYPOINT001,WAYPOINT002,3930.00,N,00236.00,E,123.4,182.3,5.8,A"))
