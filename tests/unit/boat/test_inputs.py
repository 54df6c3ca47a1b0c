"""A boat with instruments on wires: what she hears, what the bus gets, and that nothing goes round in a circle."""

from collections import Counter
from math import radians

import pytest

from tests.unit.boat.test_vehicle import frames, heading, lines, parp_lines, rudder, sent
from timonel.core.effects import Effect, Rejected, Say, SecurityEvent, Transmit
from timonel.core.frame import Frame
from timonel.core.message import Message
from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.parp import Verb
from timonel.nmea2000 import registry
from timonel.nmea2000.identifier import join, split
from timonel.nmea2000.lookups import HeadingReference, TemperatureSource, WindReference
from timonel.nmea2000.messages.environment import (
    EnvironmentalParameters,
    EnvironmentalParametersObsolete,
    TemperatureExtendedRange,
    WindData,
)
from timonel.nmea2000.messages.navigation import (
    CogSogRapidUpdate,
    PositionRapidUpdate,
    SetDriftRapidUpdate,
    Speed,
    SystemTime,
)
from timonel.nmea2000.messages.network import IsoAddressClaim
from timonel.nmea2000.messages.steering import MagneticVariation, VesselHeading
from timonel.vehicles.boat.conversion import RATES
from timonel.vehicles.boat.inputs import Ruler, rulers
from timonel.vehicles.boat.onto_bus import LISTEN
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.sources import Correction, SourceChanged, SourceDamaged, SourceSettings
from timonel.vehicles.boat.vehicle import Boat

COMPASS, GPS = "Compass", "GPS"
ALIVE = Frame(join(7, 65300, 16), bytes(8))  # of a PGN that tells us nothing
PORTS = [Port("IN1", 1), Port(COMPASS, instrument=True), Port(GPS, instrument=True)]
RMC = "GPRMC,120000.00,A,3645.0000,N,00312.0000,W,5.0,90.0,221126,,,A"


class Aboard:
    """A boat with two ports of instruments."""

    def __init__(self, ports: list[Port] = PORTS, alive: bool = True, **settings: object) -> None:
        self.boat = Boat(BoatSettings(**settings), ports, now=-LISTEN, variation_model=lambda *_: radians(2))  # type: ignore[arg-type]
        if alive:
            self.boat.receive_frames([ALIVE], -0.5)
        self.now = 0.0
        self.boat.expire(0.0)

    def hear(self, body: str, port: str = COMPASS) -> list[Effect]:
        return self.boat.receive_bytes(port, seal(body), self.now)

    def bus(self, message: Message, source: int = 10) -> list[Effect]:
        return self.boat.receive_frames(frames(message, source), self.now)

    def wait(self, seconds: float) -> list[Effect]:
        self.now += seconds
        return self.boat.expire(self.now)


def pgns(effects: list[Effect]) -> list[int]:
    """Of the messages that the bus gets; of a fast packet its first frame."""
    found = [(split(frame.identifier).pgn, frame.data[0] & 0x1F) for frame in sent(effects)]
    return [pgn for pgn, first in found if not registry.is_fast(pgn) or first == 0]


def decoded(effects: list[Effect]) -> list[Message | None]:
    return [registry.decode(split(frame.identifier).pgn, frame.data) for frame in sent(effects)]


def formatters(effects: list[Effect]) -> list[str]:
    return [line[3:6] for line in lines(effects) if not line.startswith("$PARP")]


# What is heard ----------------------------------------------------------------------------------


def test_an_instrument_is_heard_by_the_boat_and_by_the_bus():
    effects = Aboard().hear("HEHDT,90.0,T")
    assert pgns(effects) == [127250]
    assert formatters(effects) == ["HDT", "THS"]
    [message] = decoded(effects)
    assert message == VesselHeading(
        sid=0, heading=1.5708, deviation=None, variation=None, reference=HeadingReference.TRUE
    )
    assert {split(frame.identifier).source for frame in sent(effects)} == {0x23}


def test_without_devices_on_the_bus_stations_hear_all_that_instruments_tell():
    aboard = Aboard()
    aboard.hear("HEHDT,90.0,T")
    effects = aboard.hear(RMC, GPS)
    assert pgns(effects) == [126992, 129029, 129025, 129026]
    assert {"GLL", "RMC", "VTG", "GGA", "ZDA"} <= set(formatters(effects))


def test_a_heading_of_an_instrument_is_one_to_steer_by_and_its_silence_an_alarm():
    aboard = Aboard()
    aboard.boat.receive_frames([ALIVE], 0.0)
    aboard.hear("HEHDT,90.0,T")
    for verb in (Verb.REQCMD, Verb.ENGAGE):
        effects = aboard.boat.receive_bytes("IN1", parp.command(verb, 1, 0.0), aboard.now)
    assert parp_lines(effects)[-1] == "PARP,STATUS,HEADING_HOLD,090.0,090.0,,01"
    for _ in range(6):
        aboard.bus(rudder(0))
        effects = aboard.wait(0.5)
    assert parp_lines(effects)[-1].startswith("PARP,STATUS,ALARM")


def test_a_backbone_that_may_be_missing_is_no_alarm_until_it_was_heard():
    aboard = Aboard(backbone="optional", alive=False)
    assert "ALARM" not in str(parp_lines(aboard.wait(10.0)))
    aboard.bus(heading(90))
    assert "ALARM" in str(parp_lines(aboard.wait(3.0)))


def test_without_a_word_about_it_a_missing_backbone_is_an_alarm():
    assert "ALARM" in str(parp_lines(Aboard(alive=False).wait(0.5)))


def test_what_is_sent_on_the_bus_is_limited_and_what_is_heard_is_not():
    aboard = Aboard(rates={"HDT": 1000.0})
    effects: list[Effect] = []
    for tick in range(200):
        aboard.now = tick / 100
        effects += aboard.hear("HEHDT,90.0,T")
    assert Counter(formatters(effects))["HDT"] == 200
    assert Counter(pgns(effects))[127250] in (20, 21)


def test_an_instrument_may_not_command():
    aboard = Aboard()
    effects = aboard.boat.receive_bytes(COMPASS, parp.command(Verb.REQCMD, 1, 0.0), 0.0)
    assert effects == [SecurityEvent("an instrument commands", COMPASS)]
    assert aboard.boat.helm.transfer.commander == 0
    assert aboard.boat.counters["commands of instruments"] == 1


def test_a_stations_wire_with_instruments_commands_and_tells():
    aboard = Aboard([Port("IN2", 2, instrument=True)])
    aboard.boat.receive_bytes("IN2", parp.command(Verb.REQCMD, 2, 0.0), 0.0)
    assert aboard.boat.helm.transfer.commander == 2
    assert pgns(aboard.hear("HEHDT,90.0,T", "IN2")) == [127250]


def test_a_stations_wire_without_instruments_tells_nothing():
    aboard = Aboard()
    assert aboard.hear("HEHDT,90.0,T", "IN1") == []
    assert aboard.boat.counters["sentences not for us"] == 1


def test_sentences_of_no_instrument_are_not_for_us():
    aboard = Aboard()
    assert aboard.hear("GPGSV,1,1,00") == []
    assert aboard.boat.counters["sentences not for us"] == 1


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        (b"$HEHDT,90.0,T*00\r\n", "wrong check sum"),
        (b"$HEHDT,90.0,T\r\n", "no check sum"),
        (seal("HEHDT,x,T"), "malformed"),
    ],
)
def test_a_damaged_sentence_is_rejected_and_counted(line: bytes, reason: str):
    aboard = Aboard()
    [rejected] = aboard.boat.receive_bytes(COMPASS, line, 0.0)
    assert rejected == Rejected(reason, line.rstrip(), COMPASS)
    assert aboard.boat.counters[reason] == 1


def test_a_value_that_no_message_can_hold_is_rejected_and_not_heard():
    aboard = Aboard()
    [rejected] = aboard.hear("HEROT,500000.0,A")
    assert isinstance(rejected, Rejected)
    assert (rejected.source, rejected.reason[:5]) == (COMPASS, "rate:")


def test_what_is_no_position_is_not_told_the_bus_as_one():
    aboard = Aboard()
    aboard.hear(RMC, GPS)
    aboard.now = 1.0
    effects = aboard.hear(RMC.replace(",A,3645", ",V,3645"), GPS)
    assert pgns(effects) == [126992, 129029]
    assert aboard.boat.truth.position_at(1.0) is None


# Who rules --------------------------------------------------------------------------------------


def test_who_rules_is_told_and_can_be_asked():
    aboard = Aboard()
    first = aboard.hear("HEHDT,90.0,T")
    assert first[0] == SourceChanged("true heading", COMPASS, "")
    aboard.now = 1.0
    aboard.bus(rudder(1))
    assert rulers(aboard.boat.truth, aboard.boat.sources) == {
        "true heading": Ruler(COMPASS, 0.0),
        "rudder": Ruler("address 10", 1.0),
    }


def test_of_a_boat_without_instruments_it_can_be_asked_too():
    aboard = Aboard([Port("IN1", 1)])
    assert all(type(effect) is not SourceChanged for effect in aboard.bus(heading(90)))
    assert rulers(aboard.boat.truth, aboard.boat.sources) == {"true heading": Ruler("address 10", 0.0)}


def test_a_device_is_called_by_its_name_once_it_told_it():
    aboard = Aboard()
    claim = IsoAddressClaim.decode(bytes.fromhex("d204e07c008232c0"))
    assert claim is not None
    aboard.bus(claim)
    [changed] = [effect for effect in aboard.bus(heading(90)) if isinstance(effect, SourceChanged)][:1]
    assert changed == SourceChanged("true heading", "0xc03282007ce004d2", "")


def test_a_listed_port_whose_line_is_damaged_gives_way_at_once():
    aboard = Aboard(sources=SourceSettings(order={"heading": (COMPASS, GPS)}))
    aboard.hear("HEHDT,90.0,T")
    aboard.now = 0.5
    aboard.hear("HEHDT,95.0,T", GPS)
    for _ in range(10):
        effects = aboard.boat.receive_bytes(COMPASS, b"$HEHDT,90.0,T*00\r\n", 0.6)
    assert aboard.boat.truth.true.source == aboard.boat.sources.ports[COMPASS]  # type: ignore[union-attr]
    effects = aboard.hear("HEHDT,90.0,T")
    assert SourceDamaged(COMPASS, True, 0.9) in effects
    aboard.now = 0.7
    assert SourceChanged("true heading", GPS, COMPASS) in aboard.hear("HEHDT,95.0,T", GPS)


def test_a_correction_is_in_what_is_said_and_in_what_is_sent():
    settings = SourceSettings(corrections=(Correction(COMPASS, heading_deg=2.0),))
    effects = Aboard(sources=settings).hear("HEHDT,359.0,T")
    assert lines(effects)[-2].startswith("$IIHDT,1.0,T")
    [message] = decoded(effects)
    assert isinstance(message, VesselHeading)
    assert message.heading == pytest.approx(radians(1), abs=1e-4)


def test_a_correction_of_a_device_on_the_bus_is_in_what_is_said():
    settings = SourceSettings(corrections=(Correction("0xc03282007ce004d2", rudder_invert=True),))
    aboard = Aboard([Port("IN1", 1)], sources=settings)
    claim = IsoAddressClaim.decode(bytes.fromhex("d204e07c008232c0"))
    assert claim is not None
    aboard.bus(claim)
    assert lines(aboard.bus(rudder(5)))[-1].startswith("$IIRSA,-5.0,A")


# What the bus has, it does not get --------------------------------------------------------------


def test_what_a_device_on_the_bus_tells_is_not_sent_again():
    aboard = Aboard()
    aboard.bus(heading(90))
    effects = aboard.hear("HEHDT,95.0,T")
    assert (pgns(effects), formatters(effects)) == ([], [])


def test_a_true_heading_made_of_the_buss_magnetic_one_is_not_sent():
    aboard = Aboard()
    aboard.bus(heading(90, HeadingReference.MAGNETIC))
    effects = aboard.hear("HEHDT,92.0,T")
    assert (pgns(effects), formatters(effects)) == ([], [])


def test_three_seconds_after_the_device_fell_silent_the_instrument_is_sent():
    aboard = Aboard()
    aboard.bus(heading(90))
    sending = []
    for tick in range(40):
        aboard.now = tick / 10
        if pgns(aboard.hear("HEHDT,95.0,T")):
            sending.append(tick / 10)
    assert sending[0] == 3.0


def test_a_listed_port_is_sent_although_the_bus_has_a_device():
    aboard = Aboard(sources=SourceSettings(order={"heading": (COMPASS,)}, settle=0.0))
    aboard.bus(heading(90))
    assert pgns(aboard.hear("HEHDT,95.0,T")) == [127250]


def test_another_temperature_on_the_bus_does_not_keep_that_of_the_sea_from_it():
    aboard = Aboard()
    engine = TemperatureSource.ENGINE_ROOM
    aboard.bus(TemperatureExtendedRange(sid=0, instance=0, source=engine, temperature=350.0, set_temperature=None))
    assert pgns(aboard.hear("YXMTW,15.0,C")) == [130316, 130312]
    aboard.now = 10.0
    aboard.bus(
        EnvironmentalParametersObsolete(
            sid=0, water_temperature=288.0, outside_ambient_air_temperature=None, atmospheric_pressure=None
        )
    )
    assert pgns(aboard.hear("YXMTW,15.0,C")) == []


@pytest.mark.parametrize(("place", "sent"), [(TemperatureSource.SEA, []), (TemperatureSource.INSIDE, [130316, 130312])])
def test_of_the_environment_only_the_sea_counts_as_water(place: TemperatureSource, sent: list[int]):
    aboard = Aboard()
    told = EnvironmentalParameters(
        sid=0,
        temperature_source=place,
        humidity_source=None,
        temperature=290.0,
        humidity=None,
        atmospheric_pressure=None,
    )
    aboard.bus(told)
    assert pgns(aboard.hear("YXMTW,15.0,C")) == sent


def test_our_own_words_do_not_make_a_port_the_one_that_is_listened_to():
    aboard = Aboard()
    [ours] = [line for line in lines(aboard.bus(heading(90))) if line.startswith("$IIHDT")]
    aboard.now = 2.5  # the compass is silent, and our last word comes back
    assert formatters(aboard.boat.receive_bytes(GPS, ours.encode() + b"\r\n", aboard.now)) == []
    assert aboard.boat.counters["echoes of our own sentences"] == 1
    assert formatters(aboard.hear("HEHDT,95.0,T", GPS)) == ["HDT", "THS"]


def test_of_two_ports_the_first_is_heard_while_it_speaks():
    aboard = Aboard()
    aboard.hear("HCHDM,90.0,M")
    aboard.now = 1.9
    assert aboard.hear("HEHDT,95.0,T", GPS)[1:] == []
    assert aboard.boat.counters["values that another source tells"] == 1
    aboard.now = 2.0
    assert formatters(aboard.hear("HEHDT,95.0,T", GPS))[:2] == ["HDT", "THS"]


def test_of_two_listed_ports_each_tells_what_the_other_does_not():
    aboard = Aboard(sources=SourceSettings(order={"heading": (COMPASS, GPS)}))
    aboard.hear("HCHDM,90.0,M")
    assert "HDT" in formatters(aboard.hear("HEHDT,95.0,T", GPS))


def test_a_position_of_another_port_must_wait_until_no_old_one_can_be_under_way():
    aboard = Aboard()
    aboard.hear(RMC, GPS)
    for tick in range(1, 30):
        aboard.now = tick / 2
        aboard.bus(rudder(0))
        aboard.hear(RMC, COMPASS)
        if aboard.boat.truth.position.source == aboard.boat.sources.ports[COMPASS]:  # type: ignore[union-attr]
            break
    assert aboard.now == 12.0


def test_a_port_that_rules_may_say_what_we_say():
    aboard = Aboard()
    for tick in range(10):
        aboard.now = tick / 10
        assert formatters(aboard.hear("IIHDT,90.0,T")) == ["HDT", "THS"]


def test_what_we_said_long_ago_is_forgotten():
    aboard = Aboard()
    aboard.bus(heading(90))
    aboard.now = 4.0
    aboard.bus(rudder(0))
    assert formatters(aboard.hear("IIHDT,90.0,T")) == ["HDT", "THS"]


# Two gateways -----------------------------------------------------------------------------------


class Sea:
    """Two gateways. Whatever one says is heard by the other; they share a bus or have one each."""

    def __init__(self, shared: bool, **settings: object) -> None:
        every = dict.fromkeys(RATES, 100.0)
        self.boats = [
            Boat(
                BoatSettings(address=address, rates=every, **settings),  # type: ignore[arg-type]
                [Port("other", instrument=True)],
                0.0,
                lambda *_: radians(2),
            )
            for address in (0x23, 0x24)
        ]
        self.shared = shared
        self.said: list[Counter[bytes]] = [Counter(), Counter()]
        self.sent: list[Counter[int]] = [Counter(), Counter()]

    def tell(self, message: Message, now: float, boat: int | None = None) -> None:
        """A device on the bus speaks: on the one that they share, else on that of `boat`."""
        for number in (0, 1):
            if self.shared or number == boat:
                self._carry_out(number, self.boats[number].receive_frames(frames(message), now), now)

    def _carry_out(self, number: int, effects: list[Effect], now: float, depth: int = 0) -> None:
        assert depth < 20, "it goes round"
        other = self.boats[1 - number]
        for effect in effects:
            answer: list[Effect] = []
            if isinstance(effect, Say) and not effect.urgent:
                self.said[number][effect.key.encode()] += 1
                answer = other.receive_bytes("other", effect.line, now)
            elif isinstance(effect, Transmit):
                self.sent[number][split(effect.frame.identifier).pgn] += 1
                answer = other.receive_frames([effect.frame], now) if self.shared else []
            self._carry_out(1 - number, answer, now, depth + 1)

    def age(self, now: float) -> None:
        for number, boat in enumerate(self.boats):
            self._carry_out(number, boat.expire(now), now)


SPEED = Speed(
    sid=1,
    speed_water_referenced=2.5,
    speed_ground_referenced=None,
    speed_water_referenced_type=None,
    speed_direction=None,
)
DEVICES: list[tuple[str, Message]] = [
    ("true heading", heading(90)),
    ("magnetic heading", heading(90, HeadingReference.MAGNETIC)),
    ("rudder", rudder(3)),
    ("speed", SPEED),
    (
        "old water temperature",
        EnvironmentalParametersObsolete(
            sid=1, water_temperature=288.15, outside_ambient_air_temperature=None, atmospheric_pressure=None
        ),
    ),
    ("wind", WindData(sid=1, wind_speed=5.0, wind_angle=0.7, reference=WindReference.APPARENT)),
    ("true wind", WindData(sid=1, wind_speed=5.0, wind_angle=0.7, reference=WindReference.TRUE_WATER)),
    ("position", PositionRapidUpdate(latitude=36.0, longitude=-3.0)),
    ("course", CogSogRapidUpdate(sid=1, cog_reference=HeadingReference.TRUE, cog=1.0, sog=2.0)),
    ("magnetic course", CogSogRapidUpdate(sid=1, cog_reference=HeadingReference.MAGNETIC, cog=1.0, sog=2.0)),
    ("time", SystemTime(sid=1, source=None, date=20779, time=43200.0)),
    ("current", SetDriftRapidUpdate(sid=1, set_reference=HeadingReference.TRUE, set=1.0, drift=0.5)),
    ("variation", MagneticVariation(sid=1, source=None, age_of_service=None, variation=0.05)),
]  # fmt: skip


@pytest.mark.parametrize("shared", [True, False], ids=["one bus", "a bus each"])
def test_between_two_gateways_nothing_goes_round_and_nothing_outlives_its_source(shared: bool):
    sea, alone = Sea(shared), Sea(shared)
    alone.boats[1] = Boat(BoatSettings(address=0x24), [Port("other")], 0.0)  # hears nothing by wire
    for tick in range(150):
        now = tick / 10
        for _, message in DEVICES:
            sea.tell(message, now, boat=0)
            alone.tell(message, now, boat=0)
    assert sea.said[0] == alone.said[0]  # rate in is rate out
    if shared:
        assert sea.sent[1] == Counter()
    assert sea.sent[0] == Counter()
    before = [*map(Counter, sea.said), *map(Counter, sea.sent)]
    for tick in range(150, 300):
        sea.age(tick / 10)
    assert [*sea.said, *sea.sent] == before


@pytest.mark.parametrize(("name", "message"), DEVICES, ids=[name for name, _ in DEVICES])
def test_one_device_on_a_bus_of_two_gateways_is_said_as_often_as_it_speaks(name: str, message: Message):
    sea, alone = Sea(shared=True), Sea(shared=True)
    alone.boats[1] = Boat(BoatSettings(address=0x24), [Port("other")], 0.0)
    for tick in range(50):
        sea.tell(message, tick / 5)
        alone.tell(message, tick / 5)
    assert sea.said[0] == alone.said[0]
    assert sea.sent == [Counter(), Counter()]


def test_two_gateways_that_both_derive_do_not_feed_each_other():
    sea = Sea(shared=True, sources=SourceSettings(derive=("true_wind", "current", "variation")))
    told = [message for name, message in DEVICES if name not in ("true wind", "current", "variation")]
    for tick in range(200):
        for message in told:
            sea.tell(message, tick / 10)
    assert 0 < sum(sea.sent[number][130306] for number in (0, 1)) <= 2 * 21
    before = [*map(Counter, sea.said), *map(Counter, sea.sent)]
    for tick in range(200, 400):
        sea.age(tick / 10)
    assert [*sea.said, *sea.sent] == before


def test_a_pgn_that_nobody_ranks_is_not_sent_while_another_device_sends_it():
    aboard = Aboard()
    inputs = aboard.boat._inputs
    assert inputs is not None
    claim = IsoAddressClaim.decode(bytes.fromhex("d204e07c008232c0"))
    assert claim is not None
    assert not inputs.rules(claim, 256)
    assert inputs.allow(claim, 256, 0.0)
    inputs.heard(claim, 10, [], 0.0)
    assert not inputs.allow(claim, 256, 59.0)
    assert inputs.allow(claim, 256, 60.0)
