import pytest

from timonel.core.effects import Say
from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import seal, verify
from timonel.nmea0183.selection import EVERYTHING, Hearing, Selection, Selector, formatter, with_talker

HDT, RMC = Say(seal("IIHDT,182.3,T"), "HDT"), Say(seal("IIRMC,,V,,,,,,,,,,N"), "RMC")
STATUS = Say(parp.command(parp.Verb.TAKECMD, 1), "STATUS", urgent=True, state=True)
ALARM = Say(seal("IIALR,,301,A,V,bus silent"), "ALR", urgent=True)
SHIP = Say(b"!AIVDM,1,1,,A,13u?etPv2;0n:dDPwUM1U1Cb069D,0*24\r\n", "VDM")
ALL = [HDT, RMC, STATUS, ALARM, SHIP]


def test_formatters_of_all_kinds_of_lines() -> None:
    assert [formatter(say.line) for say in ALL] == ["HDT", "RMC", "PARP", "ALR", "VDM"]
    assert formatter(b"") == ""


def test_without_wishes_every_line_passes_as_it_is() -> None:
    assert EVERYTHING.all
    chosen = Selector(EVERYTHING).choose(ALL, 0.0)
    assert all(one is other for one, other in zip(chosen, ALL, strict=True))


def test_only_those_named_pass() -> None:
    assert Selector(Selection(only=("RMC", "PARP"))).choose(ALL, 0.0) == [RMC, STATUS]


def test_all_but_those_named_pass() -> None:
    assert Selector(Selection(but=("PARP", "VDM"))).choose(ALL, 0.0) == [HDT, RMC, ALARM]


def test_at_a_station_urgent_lines_pass_whatever_it_wants_to_hear() -> None:
    assert Selector(Selection(only=("RMC",)), urgent_passes=True).choose(ALL, 0.0) == [RMC, STATUS, ALARM]


def test_a_rate_is_a_ceiling_of_one_port_and_none_for_the_others() -> None:
    slow, quick = Selector(Selection(rates={"HDT": 0.5})), Selector(Selection(rates={"RMC": 0.5}))
    chosen = [selector.choose([HDT], tick / 10) for tick in range(1000) for selector in (slow, quick)]
    assert sum(map(len, chosen[::2])) == pytest.approx(50, abs=2)
    assert sum(map(len, chosen[1::2])) == 1000


def test_a_rate_of_zero_is_never() -> None:
    selector = Selector(Selection(rates={"HDT": 0.0}))
    assert [selector.choose([HDT, RMC], now) for now in (0.0, 1e9)] == [[RMC], [RMC]]


def test_another_talker_has_its_own_check_sum() -> None:
    [line] = Selector(Selection(talker="GP")).choose([HDT], 0.0)
    assert line == Say(b"$GPHDT,182.3,T*%02X\r\n" % int(line.line[-4:-2], 16), "HDT")
    assert verify(line.line.rstrip()) == b"GPHDT,182.3,T"


def test_talkers_may_differ_by_formatter() -> None:
    chosen = Selector(Selection(talker="GP", talkers={"HDT": "HE"})).choose([HDT, RMC], 0.0)
    assert [say.line[:6] for say in chosen] == [b"$HEHDT", b"$GPRMC"]
    [hdt, rmc] = Selector(Selection(talkers={"HDT": "HE"})).choose([HDT, RMC], 0.0)
    assert (hdt.line[:6], rmc) == (b"$HEHDT", RMC)


def test_proprietary_sentences_and_ais_keep_their_talker_and_urgent_lines_stay_urgent() -> None:
    chosen = Selector(Selection(talker="GP")).choose([STATUS, SHIP, ALARM], 0.0)
    assert chosen[:2] == [STATUS, SHIP]
    assert (chosen[2].line[:6], chosen[2].urgent) == (b"$GPALR", True)


def test_a_line_is_retold_once_for_all_ports_with_the_same_talker() -> None:
    one, other = (Selector(Selection(talker="GP")).choose([HDT], 0.0) for _ in range(2))
    assert one[0].line is other[0].line


def test_a_line_without_check_sum_is_left_as_it_is() -> None:
    assert with_talker(b"$IIHDT,1.0,T\r\n", b"GP") == b"$IIHDT,1.0,T\r\n"


def test_endless_new_beginnings_cost_no_memory() -> None:
    selector = Selector(Selection(but=("HDT",)))
    for number in range(3000):
        selector.choose([Say(b"$%05d,1" % number, "")], 0.0)
    assert len(selector._rules) == 1000


def heard(hearing: Hearing) -> list[str]:
    return [formatter(say.line) for say in ALL if hearing.accepts(say.line.rstrip())]


def test_of_an_instrument_only_what_its_owner_wants_is_heard() -> None:
    assert heard(Hearing()) == ["HDT", "RMC", "PARP", "ALR", "VDM"]
    assert heard(Hearing(only=("RMC", "VDM"))) == ["RMC", "VDM"]
    assert heard(Hearing(but=("HDT",))) == ["RMC", "PARP", "ALR", "VDM"]
    assert heard(Hearing(talkers=("AI",))) == ["VDM"]
    assert heard(Hearing(only=("HDT", "VDM"), talkers=("II",))) == ["HDT"]
