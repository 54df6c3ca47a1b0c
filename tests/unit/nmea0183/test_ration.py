from collections import Counter

import pytest

from timonel.core.effects import Say
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.ration import KEYS_MAX, URGENT_MAX, WEIGHTS, Ration
from timonel.nmea0183.selection import formatter
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulator import SimulatedBoat
from timonel.vehicles.boat.vehicle import Boat

HDT = Say(seal("IIHDT,182.3,T"), "HDT")  # 19 bytes
MTW = Say(seal("IIMTW,18.3,C"), "MTW")
STATUS = Say(b"$PARP,STATUS,STANDBY,000.0,182.3,+0.0,00*5D\r\n", "STATUS", urgent=True, state=True)
ALARM = Say(seal("IIALR,,301,A,V,bus silent"), "ALR", urgent=True)


def exhausted(rate=480.0) -> Ration:
    """A port whose burst is used up at 0 s."""
    ration = Ration(rate)
    while not ration.waiting:
        ration.give([Say(b"$IIXXX," + b"x" * 40 + b"\r\n", "")], 0.0)
    ration.clear()
    ration.skipped.clear()
    return ration


def drain(ration: Ration, seconds: float, start: float = 0.0) -> list[Say]:
    """What comes out by itself."""
    said: list[Say] = []
    while ration.deadline <= start + seconds:
        said += ration.take(ration.deadline)
    return said


def test_where_there_is_room_the_same_lines_go_out_in_their_order() -> None:
    lines = [HDT, MTW, STATUS]
    assert Ration(480.0).give(lines, 0.0) is lines


def test_a_port_carries_its_bytes_a_second_and_not_more() -> None:
    ration, sent = Ration(480.0), 0
    for tick in range(6000):
        sent += sum(len(say.line) for say in ration.give([HDT, MTW], tick / 100))
    assert 480 * 60 - 100 <= sent <= 480 * 60 + ration.burst


def test_an_urgent_line_goes_out_in_the_call_in_which_it_is_said_though_the_port_is_full() -> None:
    ration = exhausted()
    ration.give([HDT], 0.0)
    assert ration.give([STATUS], 0.0) == [STATUS]
    assert ration.give([ALARM, MTW], 0.0) == [ALARM]


def test_what_went_ahead_is_paid_back_by_data() -> None:
    ration = exhausted()
    for _ in range(4):
        ration.give([STATUS], 0.0)
    ration.give([HDT], 0.0)
    owed = -ration._room
    assert owed >= 3 * len(STATUS.line)
    assert ration.deadline == pytest.approx((owed + len(HDT.line)) / 480)
    assert drain(ration, 10.0) == [HDT]


def test_urgent_lines_do_not_run_ahead_without_end() -> None:
    ration = exhausted()
    said = [line for _ in range(100) for line in ration.give([ALARM], 0.0)]
    assert sum(len(say.line) for say in said) <= 2 * ration.burst + len(ALARM.line)
    assert ration.waiting
    assert drain(ration, 60.0) == [ALARM] * (100 - len(said))


def test_of_urgent_lines_that_wait_the_newest_state_and_the_last_256_are_kept() -> None:
    ration = exhausted()
    newer = Say(b"$PARP,STATUS,STANDBY,000.0,182.4,+0.0,00*5A\r\n", "STATUS", urgent=True, state=True)
    while ration.give([ALARM], 0.0):
        pass
    ration.give([STATUS, newer], 0.0)
    assert ration.skipped == {"PARP": 1}
    ration.give([ALARM] * 300, 0.0)
    assert len(ration._urgent) == URGENT_MAX
    assert ration.skipped["PARP"] + ration.skipped["ALR"] == 1 + 302 - URGENT_MAX


def test_a_newer_value_takes_the_place_of_one_that_waits_and_that_is_counted_under_its_formatter() -> None:
    ration = exhausted()
    newer = Say(seal("IIHDT,183.0,T"), "HDT")
    ration.give([HDT, MTW], 0.0)
    ration.give([newer], 0.0)
    assert ration.skipped == {"HDT": 1}
    assert drain(ration, 1.0) == [newer, MTW]


def test_when_all_want_more_than_there_is_each_gets_its_share_by_weight() -> None:
    ration, sent = Ration(480.0), Counter()
    names = ("HDT", "ROT", "DPT", "MTW")
    lines = [Say(seal(f"II{name},182.3,T"), name) for name in names]
    for tick in range(20_000):
        for say in ration.give(lines, tick / 100):
            sent[say.key] += len(say.line)
    shares = {name: sent[name] / sum(sent.values()) for name in names}
    weights = {name: WEIGHTS.get(name, 1.0) for name in names}
    for name in names:
        assert shares[name] == pytest.approx(weights[name] / sum(weights.values()), abs=0.01)


def test_what_a_formatter_does_not_need_the_others_get() -> None:
    ration, sent = Ration(480.0), Counter()
    for tick in range(6000):
        for say in ration.give([MTW, HDT] if tick % 100 == 0 else [MTW], tick / 100):
            sent[say.key] += 1
    assert sent["HDT"] == 60
    assert sent["MTW"] * len(MTW.line) > 0.9 * (480 * 60 - 60 * len(HDT.line))


def test_ships_take_turns_and_their_number_is_bounded() -> None:
    ration = exhausted()
    ships = [Say(b"!AIVDM,1,1,,A,%04d,0*00\r\n" % number, f"VDM {number}") for number in range(KEYS_MAX + 100)]
    ration.give(ships, 0.0)
    ration.give([HDT], 0.0)
    assert ration.skipped == {"VDM": 100}
    said = drain(ration, 60.0)
    assert said.index(HDT) < 5
    assert [say for say in said if say is not HDT] == ships[100:]


def test_a_line_longer_than_the_burst_goes_out_when_the_port_has_rested() -> None:
    ration = exhausted()
    monster = Say(b"$IIXXX," + b"x" * 400 + b"\r\n", "")
    ration.give([monster], 0.0)
    assert drain(ration, 2.0) == [monster]


def test_what_is_forgotten_is_counted() -> None:
    ration = exhausted()
    while ration.give([ALARM], 0.0):
        pass
    ration.give([HDT], 0.0)
    ration.clear()
    assert not ration.waiting
    assert ration.deadline == float("inf")
    assert ration.skipped == {"ALR": 1, "HDT": 1}


def test_a_whole_boat_at_4800_baud_is_useful_and_status_is_never_late() -> None:
    """Three minutes of the simulated boat with every sentence at its usual rate: four times what the port carries."""
    sea, boat = SimulatedBoat(1, destination=(39.55, 2.63)), Boat(BoatSettings(), [Port("Bridge", 1)], 0.0)
    ration = Ration(480.0)
    said, sent, late, size, ticks = Counter(), Counter(), 0, 0, 50 * 180
    for tick in range(ticks):
        now = tick * 0.02
        effects = boat.receive_frames(sea.step(0.02), now)
        lines = [effect for effect in effects if isinstance(effect, Say)]
        said.update(formatter(say.line) for say in lines)
        given = ration.give(lines, now)
        late += sum(say.urgent and not any(say is each for each in given) for say in lines)
        sent.update(formatter(say.line) for say in given)
        size += sum(len(say.line) for say in given)
    assert late == 0
    assert sent["PARP"] == said["PARP"] >= 358
    assert size <= 480 * 180 + ration.burst
    assert sum(said.values()) > 3 * sum(sent.values())
    a_minute = {name: count / 3 for name, count in sent.items()}
    for name in ("HDT", "HDG", "RSA", "ROT"):
        assert a_minute[name] >= 55, a_minute
    for name in ("RMC", "GLL", "GGA", "VTG"):
        assert a_minute[name] >= 10, a_minute
    for name in ("DPT", "DBT", "VHW", "MWV"):
        assert a_minute[name] >= 6, a_minute
    for name in said:
        assert a_minute[name] >= 3, (name, a_minute)
    waiting = +(said - sent - ration.skipped)
    assert all(count == 1 for count in waiting.values())
