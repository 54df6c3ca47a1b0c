"""Damaged input by the million: nothing raises, nothing that is not a command is obeyed, the next good input counts.

The usual run takes a part of the million; `-m slow` takes all of it.
"""

import re
from collections.abc import Callable, Iterator
from functools import reduce
from operator import xor
from pathlib import Path
from random import Random

import pytest

from tests.program import heading, line_of
from tests.recordings import recording
from timonel.core.effects import Effect, Say, Transmit
from timonel.core.frame import Frame
from timonel.errors import ConfigError
from timonel.gateway.configuration import parse
from timonel.gateway.lookout import Lookout
from timonel.links.link import Counters
from timonel.links.slcan import SlcanParser
from timonel.nmea0183 import parp
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.parp import Verb
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.messages.navigation import DistanceLog
from timonel.nmea2000.registry import MESSAGES
from timonel.recording import LogFrame
from timonel.recording.formats import FORMATS
from timonel.vehicles.boat.pilot import Mode, Steer
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.vehicle import Boat

MILLION = pytest.param(1_000_000, marks=[pytest.mark.slow, pytest.mark.timeout(1800)])
PART = 20_000
STATIONS = {f"IN{number}": number for number in (1, 2, 3, 4)}
EXAMPLE = Path(__file__).parents[2] / "docs" / "boat.toml"

COMMANDS = [
    *(parp.command(verb, station, 123.4) for verb in Verb for station in STATIONS.values()),
    *(seal(f"PARP,{verb},0{station}") for verb in ("RELCMD", "ACKCMD", "DENYCMD") for station in STATIONS.values()),
]
SENTENCES = [
    *COMMANDS,
    seal("IIACK,001"),
    seal("GPRMC,123519.00,A,4807.038000,N,01131.000000,E,022.4,084.4,230394,3.1,W,A"),
    b"\\s:gps*1F\\" + seal("IIHDT,182.5,T"),
]
LAWFUL = re.compile(
    rb"\$PARP,(?:(?:%b),-?\d{1,4}(?:\.\d{1,4})?,(0[1-4])|(?:RELCMD|ACKCMD|DENYCMD),0[1-4])\*([0-9A-Fa-f]{2})"
    % "|".join(Verb).encode()
)

# Damage ---------------------------------------------------------------------------------------------------------------


def replaced(data: bytearray, rng: Random) -> None:
    data[rng.randrange(len(data))] = rng.randrange(256)


def flipped(data: bytearray, rng: Random) -> None:
    data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)


def deleted(data: bytearray, rng: Random) -> None:
    first = rng.randrange(len(data))
    del data[first : first + rng.choice((1, 1, 2, 9))]


def inserted(data: bytearray, rng: Random) -> None:
    first = rng.randrange(len(data) + 1)
    data[first:first] = rng.choice((b"$", b"*", b",", b"\0", b"!", b"\\", b"\r\n", b"0", b"-", b"A" * 90, b"9" * 300))


def swapped(data: bytearray, rng: Random) -> None:
    first = rng.randrange(len(data))
    second = rng.randrange(len(data))
    data[first], data[second] = data[second], data[first]


def doubled(data: bytearray, rng: Random) -> None:
    first = rng.randrange(len(data))
    data[first:first] = data[first : first + rng.randrange(1, 20)]


def lowered(data: bytearray, rng: Random) -> None:
    data[:] = data.lower()


DAMAGE = (replaced, flipped, deleted, inserted, swapped, doubled, lowered)


def damaged(good: bytes, rng: Random, ways: tuple[Callable[[bytearray, Random], None], ...] = DAMAGE) -> bytes:
    data = bytearray(good)
    for _ in range(rng.choice((1, 1, 2, 3))):
        if data:
            rng.choice(ways)(data, rng)
    return bytes(data)


def pieces(data: bytes, rng: Random) -> Iterator[bytes]:
    cut = rng.randrange(len(data) + 1)
    yield data[:cut]
    yield data[cut:]


# Sentences ------------------------------------------------------------------------------------------------------------


def lawful(data: bytes, station: int) -> int:
    """How many commands of `station` are among the lines of `data`, on its own port, to the protocol's letter.

    The short form does not say who speaks.
    """
    lines = (line[max(line.rfind(b"$"), line.rfind(b"!"), 0) :] for line in re.split(rb"[\r\n]", data))
    matches = (match for line in lines if (match := LAWFUL.fullmatch(line)))
    right = [match for match in matches if reduce(xor, match[0][1:-3]) == int(match[2], 16)]
    return sum(match[1] in (None, b"0%d" % station) for match in right)


class Helm:
    """A boat that holds a heading for station 1 while its bus and its clock go on."""

    def __init__(self) -> None:
        settings = BoatSettings(commands_per_second=10_000)
        self.boat = Boat(settings, [Port(name, number) for name, number in STATIONS.items()], now=0.0)
        self.now = 0.0
        self.take()

    def take(self) -> None:
        for verb in (Verb.TAKECMD, Verb.ENGAGE):
            self.pass_time(0.01)
            self.boat.receive_bytes("IN1", parp.command(verb, 1), self.now)
        assert self.state[:2] == (1, Mode.HEADING_HOLD)

    def pass_time(self, seconds: float) -> None:
        self.now += seconds
        self.boat.receive_frames([heading(182.5)], self.now)
        self.boat.expire(self.now)

    @property
    def state(self) -> tuple[object, ...]:
        pilot, transfer = self.boat.helm.pilot, self.boat.helm.transfer
        return transfer.commander, pilot.mode, pilot.setpoint, transfer.deadline

    @property
    def obeyed(self) -> int:
        """Commands that were let through to be judged by who commands."""
        return self.boat.counters["commands"]

    def hear(self, port: str, data: bytes) -> list[Effect]:
        return self.boat.receive_bytes(port, data, self.now)


@pytest.mark.parametrize("count", [PART, MILLION])
def test_of_damaged_sentences_only_those_are_obeyed_that_are_commands_to_the_letter(count: int) -> None:
    rng = Random(count)
    helm = Helm()
    for number in range(count):
        if number % 10 == 0:
            helm.pass_time(0.1)
        port = rng.choice(list(STATIONS))
        bad = damaged(rng.choice(SENTENCES), rng)
        before, obeyed = helm.state, helm.obeyed
        effects = [effect for piece in pieces(bad + b"\n", rng) for effect in helm.hear(port, piece)]
        commands = lawful(bad, STATIONS[port])
        assert helm.obeyed - obeyed == commands, bad
        if not commands:
            assert helm.state == before, bad
            assert not any(isinstance(effect, Transmit) for effect in effects), bad
        helm.hear(port, parp.command(Verb.REQCMD, STATIONS[port]))
        assert helm.obeyed - obeyed == commands + 1, bad
        if number % 1000 == 0 or helm.state[:2] != (1, Mode.HEADING_HOLD):
            helm.take()


@pytest.mark.parametrize("count", [PART, MILLION])
def test_random_damage_hardly_ever_makes_another_command_of_a_command(count: int) -> None:
    rng = Random(count)
    changed = 0
    for _ in range(count):
        good = rng.choice(COMMANDS)
        read = parp.read_command(damaged(good, rng, (replaced,)).strip())
        changed += isinstance(read, parp.Command) and read != parp.read_command(good.strip())
    assert changed <= 1


@pytest.mark.parametrize("count", [PART, MILLION])
def test_random_bytes_on_a_port_are_never_a_command_and_the_next_sentence_is_understood(count: int) -> None:
    rng = Random(count)
    helm = Helm()
    for _ in range(count // 1000):
        helm.pass_time(0.1)
        before, obeyed = helm.state, helm.obeyed
        for piece in pieces(rng.randbytes(1000), rng):
            helm.hear("IN1", piece)
        assert helm.state == before
        assert helm.obeyed == obeyed
        helm.hear("IN1", b"\n" + parp.command(Verb.STBDONE, 1))
        assert helm.state != before


@pytest.mark.parametrize("count", [PART, MILLION])
def test_a_station_hears_the_next_status_whatever_came_before_it(count: int) -> None:
    rng = Random(count)
    lookout = Lookout()
    said = [parp.status(parp.PilotMode.TRACK, 1234, 182.5, -3.1, 2), parp.cmdtransfer(1, 2), parp.cmdrequest(3)]
    status = parp.status(parp.PilotMode.STANDBY, None, None, None, 4)
    for number in range(count):
        for piece in pieces(damaged(rng.choice(said), rng) + b"\n", rng):
            for report in lookout.receive(piece):
                lookout.hear(report, float(number))
        heard = lookout.receive(status)
        assert [report.commander for report in heard if isinstance(report, parp.Status)] == [4]


# Frames ---------------------------------------------------------------------------------------------------------------

PGNS = sorted(MESSAGES.keys() | {61184, 65280, 126720, 130820})
LOG = DistanceLog(date=None, time=None, log=185_200, trip_log=1852)


def any_frame(rng: Random, good: list[Frame]) -> Frame:
    match rng.randrange(4):
        case 0:
            return Frame(rng.getrandbits(29), rng.randbytes(rng.randrange(9)), rng.random() < 0.9)
        case 1:
            return Frame(join(rng.randrange(8), rng.choice(PGNS), rng.randrange(252)), rng.randbytes(8))
        case _:
            frame = rng.choice(good)
            return Frame(frame.identifier, damaged(frame.data, rng, (replaced, flipped, deleted, swapped)))


def recorded_frames() -> list[Frame]:
    reader = FORMATS[0]([])
    lines = recording("canboat_canboat/samples/candumpSample2.txt").read_text("latin-1").splitlines()[:2000]
    return [found.frame for line in lines if (found := reader.read(line)) is not None]


@pytest.mark.parametrize("count", [PART, MILLION])
def test_damaged_frames_give_nobody_command_never_steer_and_leave_the_next_good_ones_understood(count: int) -> None:
    rng = Random(count)
    good = recorded_frames()
    boat = Boat(BoatSettings(), [Port("IN1", 1)], now=0.0)
    now = 0.0
    for number in range(count):
        now += 0.001
        effects = boat.receive_frames([any_frame(rng, good)], now)
        assert not [effect for effect in effects if isinstance(effect, Steer) and effect.setpoint is not None]
        if number % 1000 == 999:
            now += 10.0  # what the damage said is too old to count
            frames = [heading(182.5), *(Frame(join(6, 128275, 10), data) for data in fragment(LOG.encode(), 1))]
            said = [effect.line for effect in boat.receive_frames(frames, now) if isinstance(effect, Say)]
            assert seal("IIHDT,182.5,T") in said
            assert any(line.startswith(b"$IIVLW,100.0") for line in said)
    assert boat.helm.transfer.commander == 0


@pytest.mark.parametrize("count", [PART, MILLION])
def test_damaged_lines_of_an_adapter_are_counted_and_the_frame_after_the_next_is_understood(count: int) -> None:
    rng = Random(count)
    tally = Counters()
    parser = SlcanParser(tally)
    lines = [line_of(frame) for frame in recorded_frames()[:50]] + [
        b"t12381122334455667788\r",
        b"z\r",
        b"\a",
        b"V1013\r",
    ]
    good = line_of(heading(182.5))
    for _ in range(count):
        frames = [frame for piece in pieces(damaged(rng.choice(lines), rng), rng) for frame in parser.receive(piece)]
        frames += parser.receive(good + good)
        assert frames[-1] == heading(182.5)
        assert all(len(frame.data) <= 8 and frame.identifier < 1 << 29 for frame in frames)
    assert tally.rejected > count // 10


# Files ----------------------------------------------------------------------------------------------------------------

SAMPLES = (
    "(1502979132.106111) slcan0 09F805FD#DBA000C38A6F27FA",
    "  can0  09F8027F   [8]  00 FC FF FF 00 00 FF FF",
    "17:33:21.107 R 19F51323 01 2F 30 70 00 2F 30 70",
    "2016-02-28T19:57:02.364Z,2,127250,7,255,8,ff,10,3b,ff,7f,ce,f5,fc",
    "A000057.086 13FF2 1F112 005679FF7FFF7FFD",
    "!PDGY,127250,2,3,255,481.734,2C20AAAAAAE=",
    "0,486942,127508,Battery Status,Garmin,6,255,2,1,8,0x017505FF7FFFFFFF",
    "   0.015991 1  18EBFF00x       Rx   d 8 01 A0 0F A6 60 3B D1 40",
    "     1)      1059.9  18EBFF00  8  01 A0 0F A6 60 3B D1 40",
    "1402160417.499 $IIHDT,45.0,T*10",
)


@pytest.mark.parametrize("count", [PART, MILLION])
@pytest.mark.parametrize("log_format", FORMATS)
def test_a_damaged_line_of_a_recording_is_a_frame_or_not_a_line(log_format: type, count: int) -> None:
    rng = Random(count)
    reader = log_format(SAMPLES)
    for _ in range(count):
        line = damaged(rng.choice(SAMPLES).encode(), rng).decode("latin-1")
        try:
            found = reader.read(line)
        except ValueError:
            continue
        assert not isinstance(found, LogFrame) or found.whole or len(found.data) <= 8, line


def mistakes_in(text: str) -> list[str]:
    """What is wrong with a configuration; any other exception than ConfigError is a fault of ours."""
    try:
        parse(text)
    except ConfigError as mistakes:
        return str(mistakes).split("\n")
    return []


@pytest.mark.parametrize("count", [1_000, pytest.param(30_000, marks=pytest.mark.slow)])
def test_a_damaged_configuration_is_understood_or_its_mistakes_are_told(count: int) -> None:
    rng = Random(count)
    example = EXAMPLE.read_bytes()
    told = [mistakes_in(damaged(example, rng).decode("utf-8", "replace")) for _ in range(count)]
    assert all(re.match(r"boat\.toml[:,]", mistake) for mistakes in told for mistake in mistakes)
    assert any(told)
    assert not all(told)  # damage to a comment is none
