"""Several sources of one datum: the owner's order, silence, lost fixes, damaged lines, and corrections."""

from math import pi, radians

import pytest

from timonel.nmea2000.lookups import GnssMethod, HeadingReference, WindReference
from timonel.nmea2000.messages.environment import WindData
from timonel.nmea2000.messages.navigation import GnssPositionData, PositionRapidUpdate, WaterDepth
from timonel.nmea2000.messages.steering import RateOfTurn, Rudder, VesselHeading
from timonel.vehicles.boat.sources import (
    DERIVED,
    ENOUGH,
    HISTORY,
    INSTRUMENTS,
    Correction,
    SourceChanged,
    SourceDamaged,
    Sources,
    SourceSettings,
)
from timonel.vehicles.boat.truth import Datum, Truth

FLUXGATE, SATELLITE, PLOTTER = 0xC0328200E0000001, 0xC0328200E0000002, 0xC0328200E0000003
PORTS = ["wind", "compass"]
WIND_PORT, COMPASS_PORT = INSTRUMENTS, INSTRUMENTS + 1


def hexed(name: int) -> str:
    return f"0x{name:016x}"


def sources(*order: str, ports: list[str] = PORTS, **settings: object) -> Sources:
    """Those of a boat with a list for heading, on whose bus three devices have told who they are."""
    made = Sources(SourceSettings(order={"heading": order}, **settings), ports)  # type: ignore[arg-type]
    for address, name in ((10, FLUXGATE), (20, SATELLITE), (30, PLOTTER)):
        made.introduce(address, name)
    return made


class Heard:
    """One datum, and who rules it."""

    def __init__(self, made: Sources, name: str = "true heading", hold: float = 1.0) -> None:
        self.sources = made
        self.datum: Datum[float] = made.datum(name, hold)

    def hear(self, source: int, now: float, rank: int = 0) -> bool:
        return self.datum.offer(now, now, source, rank)

    def both(self, first: int, second: int, since: float, until: float, step: float = 0.1) -> float:
        """Two sources speak one after the other; when the second one came to rule."""
        now = since
        while now < until:
            self.hear(first, now)
            if self.hear(second, now + step / 2):
                return now + step / 2
            now += step
        return float("inf")


# Without an order -------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["plain", "ranked"])
def test_without_an_order_the_first_is_kept_to_while_it_speaks(kind: str):
    datum: Datum[int] = Datum(1.0) if kind == "plain" else Sources(SourceSettings(), []).datum("speed", 1.0)
    assert datum.offer(1, 0.0, source=10, rank=1)
    assert not datum.offer(2, 0.9, source=20, rank=1)
    assert datum.offer(1, 0.95, source=10, rank=1)
    assert not datum.offer(2, 1.9, source=20, rank=1)
    assert datum.offer(2, 1.95, source=20, rank=1)
    assert datum.offer(1, 2.0, source=10, rank=0)
    assert not datum.offer(1, 2.5, source=10, rank=1)
    assert (datum.source, datum.value, datum.heard) == (10, 1, 2.0)


def test_a_device_on_the_bus_comes_before_an_instrument_and_that_before_what_is_computed():
    heard = Heard(sources(settle=0.0))
    assert heard.hear(DERIVED, 0.0)
    assert heard.hear(WIND_PORT, 0.1)
    assert heard.hear(99, 0.2)
    assert not heard.hear(WIND_PORT, 0.3)
    assert not heard.hear(DERIVED, 0.4)


# The order --------------------------------------------------------------------------------------


def test_a_better_source_takes_over_when_it_has_spoken_for_five_seconds():
    heard = Heard(sources(hexed(SATELLITE), hexed(FLUXGATE)))
    assert heard.hear(10, 0.0)
    assert heard.both(10, 20, since=0.0, until=10.0) == pytest.approx(5.05, abs=0.11)
    assert heard.both(20, 10, since=5.1, until=30.0) == float("inf")


def test_a_pause_makes_a_better_source_begin_anew():
    heard = Heard(sources(hexed(SATELLITE)))
    heard.hear(10, 0.0)
    heard.both(10, 20, since=0.0, until=4.0)
    heard.both(10, 30, since=4.0, until=5.2)
    assert heard.both(10, 20, since=5.2, until=20.0) == pytest.approx(10.25, abs=0.11)


def test_two_better_sources_do_not_keep_each_other_from_taking_over():
    heard = Heard(sources(hexed(SATELLITE), hexed(PLOTTER)))
    now = 0.0
    heard.hear(10, now)
    while heard.datum.source != 20:
        now += 0.1
        heard.hear(10, now)
        heard.hear(30, now)
        heard.hear(20, now)
        assert now < 6
    assert now == pytest.approx(5.1, abs=0.11)


def test_silence_gives_the_datum_to_the_best_of_those_that_speak():
    heard = Heard(sources(hexed(SATELLITE), hexed(PLOTTER), hexed(FLUXGATE)))
    heard.hear(20, 0.0)
    heard.hear(30, 0.5)
    assert not heard.hear(10, 1.2)  # the plotter spoke within the time, and is the better one
    assert heard.hear(30, 1.3)
    assert not heard.hear(10, 1.4)


def test_silence_gives_the_datum_to_the_only_one_that_speaks():
    heard = Heard(sources(hexed(SATELLITE)))
    heard.hear(20, 0.0)
    assert not heard.hear(10, 0.9)
    assert heard.hear(10, 1.0)


def test_the_owner_says_how_long_silence_is():
    heard = Heard(sources(hold=4.0))
    heard.hear(20, 0.0)
    assert not heard.hear(10, 3.9)
    assert heard.hear(10, 4.0)


def test_a_port_may_stand_before_the_bus():
    heard = Heard(sources("compass", settle=0.0))
    assert heard.hear(10, 0.0)
    assert heard.hear(COMPASS_PORT, 0.1)
    assert not heard.hear(10, 0.2)
    assert heard.sources.listed("heading", COMPASS_PORT)
    assert not heard.sources.listed("heading", WIND_PORT)
    assert not heard.sources.listed("speed", COMPASS_PORT)


def test_a_device_that_moves_takes_its_place_along():
    heard = Heard(sources(hexed(SATELLITE), settle=0.0))
    heard.hear(20, 0.0)
    heard.sources.introduce(20, PLOTTER)
    heard.sources.introduce(40, SATELLITE)
    assert heard.hear(20, 0.1)
    assert heard.hear(40, 0.1)
    assert not heard.hear(20, 0.2)


def test_a_device_that_tells_its_name_again_is_what_it_was():
    heard = Heard(sources(hexed(SATELLITE), settle=0.0))
    heard.hear(20, 0.0)
    heard.sources.introduce(20, SATELLITE)
    assert heard.sources.label(20) == hexed(SATELLITE)
    assert not heard.hear(10, 0.1)


def test_both_headings_stand_in_one_order_and_other_data_in_none():
    made = sources(hexed(SATELLITE), settle=0.0)
    magnetic, speed = Heard(made, "magnetic heading"), Heard(made, "speed")
    for heard in (magnetic, speed):
        heard.hear(10, 0.0)
    assert magnetic.hear(20, 0.1)
    assert not speed.hear(20, 0.1)


def test_names_are_read_in_either_case():
    heard = Heard(sources(hexed(SATELLITE).upper().replace("X", "x"), settle=0.0))
    heard.hear(10, 0.0)
    assert heard.hear(20, 0.1)


# Lost fixes -------------------------------------------------------------------------------------


def fix(
    method: GnssMethod | None = GnssMethod.GNSS_FIX, hdop: float | None = 1.0, place: bool = True
) -> GnssPositionData:
    latitude, longitude = (36.0, -3.0) if place else (None, None)
    return GnssPositionData(latitude=latitude, longitude=longitude, method=method, hdop=hdop)


def truth(*order: str, **settings: object) -> tuple[Truth, Sources]:
    made = Sources(SourceSettings(order={"position": order}, **settings), PORTS)  # type: ignore[arg-type]
    made.introduce(10, FLUXGATE)
    made.introduce(20, SATELLITE)
    return Truth(3.0, None, made.datum, made.hdop_limit), made


@pytest.mark.parametrize("lost", [fix(GnssMethod.NONE), fix(place=False), fix(hdop=5.1)])
def test_a_receiver_that_loses_its_fix_is_left_at_once_even_if_it_is_the_best(lost: GnssPositionData):
    known, _ = truth(hexed(SATELLITE), hdop_limit=5.0)
    assert known.hear_fix(fix(), 20, 0.0)
    assert not known.hear_fix(fix(), 10, 0.1)
    known.hear_fix(lost, 20, 1.0)
    assert known.hear_fix(fix(), 10, 1.1)
    assert known.fix.source == known.position.source == 10
    known.hear_fix(lost, 20, 2.0)
    assert known.fix.source == known.position.source == 10


def test_an_hdop_counts_only_if_the_owner_says_so():
    known, _ = truth()
    known.hear_fix(fix(), 10, 0.0)
    known.hear_fix(fix(hdop=80.0), 10, 1.0)
    assert not known.hear_fix(fix(), 20, 1.1)


def test_a_fix_that_is_back_must_stay_before_it_counts_again():
    known, _ = truth(hexed(SATELLITE))
    for second in range(30):
        known.hear_fix(fix(GnssMethod.NONE), 20, float(second))
        known.hear_fix(fix(), 10, second + 0.5)
    ruling = []
    for second in range(30, 40):
        known.hear_fix(fix(), 20, float(second))
        known.hear_fix(fix(), 10, second + 0.5)
        ruling.append(known.fix.source)
    assert ruling == [10] * 5 + [20] * 5


def test_a_rapid_position_of_a_receiver_without_a_fix_is_the_last_resort():
    known, _ = truth(hexed(SATELLITE))
    known.hear_fix(fix(GnssMethod.NONE), 20, 0.0)
    place = PositionRapidUpdate(latitude=36.0, longitude=-3.0)
    assert known.hear_position(place, 20, 0.1)
    assert known.hear_position(place, 10, 0.2)
    assert not known.hear_position(place, 20, 0.3)


# Damaged lines ----------------------------------------------------------------------------------


def test_a_port_with_many_damaged_sentences_comes_last_until_it_is_clean_again():
    made = sources("compass", settle=0.0)
    heard = Heard(made)
    heard.hear(10, 0.0)
    assert heard.hear(COMPASS_PORT, 0.1)
    judged = [made.sentence("compass", sound=number % 3 > 0) for number in range(ENOUGH)]
    assert judged == [False] * (ENOUGH - 1) + [True]
    assert heard.hear(COMPASS_PORT, 0.2)
    assert heard.hear(10, 0.3)
    assert not heard.hear(COMPASS_PORT, 0.4)
    back = [made.sentence("compass", sound=True) for _ in range(HISTORY)]
    assert back.count(True) == 1
    assert heard.hear(COMPASS_PORT, 0.5)
    told = [change for change in made.changes if isinstance(change, SourceDamaged)]
    assert told == [SourceDamaged("compass", True, 0.4), SourceDamaged("compass", False, 0.08)]


def test_a_damaged_port_is_still_better_than_nothing():
    made = sources()
    heard = Heard(made)
    for _ in range(ENOUGH):
        made.sentence("compass", sound=False)
    assert heard.hear(COMPASS_PORT, 0.0)
    assert heard.hear(COMPASS_PORT, 0.1)


def test_a_few_damaged_sentences_are_nothing_and_another_port_has_nothing_to_do_with_it():
    made = sources()
    assert not any(made.sentence("compass", sound=number % 10 > 0) for number in range(1, 200))
    assert not any(made.sentence("wind", sound=False) for _ in range(ENOUGH - 1))
    assert made.changes == []


# Who rules --------------------------------------------------------------------------------------


def test_every_change_is_told_with_names():
    made = sources(hexed(SATELLITE), "compass", settle=0.0)
    heard = Heard(made)
    heard.hear(99, 0.0)
    heard.hear(99, 0.1)
    heard.hear(COMPASS_PORT, 0.2)
    heard.hear(20, 0.3)
    heard.hear(DERIVED, 5.0)
    assert made.changes == [
        SourceChanged("true heading", "address 99", ""),
        SourceChanged("true heading", "compass", "address 99"),
        SourceChanged("true heading", hexed(SATELLITE), "compass"),
        SourceChanged("true heading", "derived", hexed(SATELLITE)),
    ]


# Corrections ------------------------------------------------------------------------------------


def mended(correction: Correction, message: object, source: int = COMPASS_PORT) -> object:
    return sources(corrections=(correction,)).mended(message, source)  # type: ignore[arg-type]


def heading(angle: float | None) -> VesselHeading:
    reference = HeadingReference.MAGNETIC
    return VesselHeading(sid=1, heading=angle, deviation=0.1, variation=0.2, reference=reference)


def rudder(angle: float | None) -> Rudder:
    return Rudder(instance=0, direction_order=None, angle_order=None, position=angle)


def wind(angle: float | None, reference: WindReference = WindReference.APPARENT) -> WindData:
    return WindData(sid=1, wind_speed=5.0, wind_angle=angle, reference=reference)


def test_a_heading_is_turned_clockwise_and_stays_a_heading():
    correction = Correction("compass", heading_deg=-10.0)
    assert mended(correction, heading(radians(5))) == heading(pytest.approx(radians(355)))
    assert mended(correction, heading(None)) == heading(None)


def test_a_rudder_is_inverted_and_then_moved():
    assert mended(Correction("compass", rudder_invert=True), rudder(0.1)) == rudder(-0.1)
    both = Correction("compass", rudder_invert=True, rudder_deg=2.0)
    assert mended(both, rudder(0.1)) == rudder(pytest.approx(radians(2) - 0.1))
    assert mended(both, rudder(None)) == rudder(None)


def test_a_rate_of_turn_is_inverted():
    correction = Correction("compass", rate_of_turn_invert=True)
    assert mended(correction, RateOfTurn(sid=1, rate=0.1)) == RateOfTurn(sid=1, rate=-0.1)
    assert mended(correction, RateOfTurn(sid=1, rate=None)) == RateOfTurn(sid=1, rate=None)


def test_wind_from_the_bow_is_mirrored_and_turned_but_not_wind_from_north():
    correction = Correction("compass", wind_invert=True, wind_deg=5.0)
    assert mended(correction, wind(radians(40))) == wind(pytest.approx(radians(325)))
    assert mended(Correction("compass", wind_deg=5.0), wind(pi)) == wind(pytest.approx(pi + radians(5)))
    assert mended(correction, wind(None)) == wind(None)
    north = wind(1.0, WindReference.TRUE_NORTH)
    assert mended(correction, north) is north


def test_a_sounder_gets_the_offset_that_its_owner_measured():
    sounding = WaterDepth(sid=1, depth=4.0, offset=None, range=None)
    assert mended(Correction("compass", depth_offset_m=-1.5), sounding) == WaterDepth(
        sid=1, depth=4.0, offset=-1.5, range=None
    )
    assert sources(corrections=(Correction("compass", depth_offset_m=-1.5),)).depth_offset("compass") == -1.5
    assert sources().depth_offset("compass") is None


def test_a_correction_is_for_its_source_and_its_message_alone():
    correction = Correction(hexed(SATELLITE), rudder_invert=True)
    assert mended(correction, rudder(0.1), source=20) == rudder(-0.1)
    assert mended(correction, rudder(0.1), source=10) == rudder(0.1)
    assert mended(correction, heading(1.0), source=20) == heading(1.0)


def test_a_correction_follows_its_device():
    made = sources(corrections=(Correction(hexed(SATELLITE), rudder_invert=True),))
    made.introduce(20, PLOTTER)
    made.introduce(40, SATELLITE)
    assert made.mended(rudder(0.1), 20) == rudder(0.1)
    assert made.mended(rudder(0.1), 40) == rudder(-0.1)
