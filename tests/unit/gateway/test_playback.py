"""A recording as a bus or as what a gateway said: on its own time, marked, and commanding nobody."""

import asyncio
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.recordings import recording
from tests.voyage import BOAT, ROVER, Voyage
from timonel.core.frame import Frame
from timonel.errors import RecordingError
from timonel.gateway.playback import Entry, Playback, Player, at_once, begin_at, commands
from timonel.nmea0183.checksum import seal
from timonel.nmea0183.registry import parse
from timonel.nmea0183.sentences import GLL, RMC, Mode
from timonel.nmea2000.identifier import split
from timonel.recording.flight import frames

POWER_ON = "aldas_go-nmea-client/socketcan/testdata/candump_2021-05-25-1635_5s.log"
NOON = datetime(2026, 7, 27, 12, tzinfo=UTC).timestamp()


@pytest.fixture(scope="module")
def boat(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Voyage(tmp_path_factory.mktemp("boat"), BOAT, seed=8).sail(60)


@pytest.fixture(scope="module")
def rover(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return Voyage(tmp_path_factory.mktemp("rover"), ROVER, seed=8).sail(5)


def log(path: Path, stamps: list[float | None], frame: str = "09F11223#FF725AFF7FFF7FFD") -> Path:
    path.write_text("".join(f"({stamp:.6f}) can0 {frame}\n" for stamp in stamps))
    return path


def played(playback: Playback) -> tuple[list[Frame], list[bytes]]:
    entries = list(playback.entries())
    return [frame for entry in entries for frame in entry.frames], [
        say.line for entry in entries for say in entry.lines
    ]


# What is played ---------------------------------------------------------------------------------------


def test_of_a_recording_what_came_in_is_played_except_commands(boat: Path) -> None:
    playback = Playback(boat, bus=True)
    out, _ = played(playback)
    came = [entry.frame for entry in frames(boat, sent=False)]
    assert out == [frame for frame in came if not commands(frame)]
    assert playback.played.withheld == len(list(frames(boat))) - len(out) > 0


def test_what_commands_is_played_if_it_is_allowed(boat: Path) -> None:
    out, _ = played(Playback(boat, bus=True, allow_commands=True))
    assert out == [entry.frame for entry in frames(boat)]


def test_no_frame_that_is_played_makes_a_pilot_or_a_wheel_move(boat: Path, rover: Path) -> None:
    pgns = {split(frame.identifier).pgn for frame in played(Playback(boat, bus=True))[0] if frame.extended}
    assert 127250 in pgns
    assert 127237 not in pgns
    identifiers = {frame.identifier for frame in played(Playback(rover, bus=True))[0] if not frame.extended}
    assert 104 in identifiers
    assert not identifiers & {100, 101, 102, 103, 119}


def test_what_was_said_is_played_and_marked_as_simulated(boat: Path) -> None:
    _, lines = played(Playback(boat, bus=False))
    positions = [sentence for line in lines if isinstance(sentence := parse(line.rstrip()), RMC | GLL)]
    assert len(positions) > 50
    assert {position.mode for position in positions if position.latitude_deg is not None} == {Mode.SIMULATOR}
    assert {position.valid for position in positions} == {False}
    assert any(line.startswith(b"$PARP,STATUS,") for line in lines)


def test_the_frames_that_a_rover_said_are_played_as_they_are(rover: Path) -> None:
    _, pieces = played(Playback(rover, bus=False))
    assert len(pieces) > 100
    assert all(piece.startswith(b"#") for piece in pieces)


def test_a_log_of_a_bus_is_played_as_frames_or_through_a_boats_machine() -> None:
    path = recording(POWER_ON)
    as_frames, _ = played(Playback(path, bus=True, allow_commands=True))
    assert len(as_frames) > 300
    entries = list(Playback(path, bus=False).entries())
    assert [entry.now for entry in entries] == sorted(entry.now for entry in entries)
    lines = [say.line for entry in entries for say in entry.lines]
    assert any(line[3:6] == b"HDT" for line in lines)
    assert any(line.startswith(b"$PARP,STATUS,") for line in lines)


def test_a_message_that_its_recorder_put_together_is_played_in_frames(tmp_path: Path) -> None:
    path = tmp_path / "plain.log"
    line = "2016-02-28T19:57:02.364Z,3,129029,7,255,43,ff,f0,42,10,71,18,22" + ",00" * 36
    path.write_text(line + "\n" + line + "\n")
    out, _ = played(Playback(path, bus=True))
    assert [frame.data[0] for frame in out[:7]] == [0x20 | number for number in range(7)]
    assert [frame.data[0] for frame in out[7:9]] == [0x40, 0x41]


def test_a_log_of_sentences_is_played_as_sentences_and_as_no_bus(tmp_path: Path) -> None:
    path = tmp_path / "log.nmea"
    path.write_bytes(seal("GPGLL,3930.00,N,00236.00,E,101500,A,A") + seal("IIHDT,182.3,T"))
    assert played(Playback(path, bus=False))[1] == [
        seal("GPGLL,3930.00,N,00236.00,E,101500,V,S"),
        seal("IIHDT,182.3,T"),
    ]
    with pytest.raises(RecordingError, match="sentences, not frames of a bus"):
        Playback(path, bus=True).check()


def test_a_sentence_without_room_for_its_mark_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "log.nmea"
    long = "GPRMB,A,1.00,L,WAYPOINT001,WAYPOINT002,3930.00,N,00236.00,E,123.4,182.3,5.8,A"
    path.write_bytes(seal(long[:-6]) if len(long) > 76 else seal(long))
    playback = Playback(path, bus=False)
    lines = played(playback)[1]
    assert len(lines) + playback.played.unmarked == 1


@pytest.mark.parametrize("bus", [True, False])
def test_a_file_that_is_not_there_is_an_error(tmp_path: Path, bus: bool) -> None:
    with pytest.raises(RecordingError, match=r"no\.log: No such file"):
        Playback(tmp_path / "no.log", bus=bus).check()


# Where it begins --------------------------------------------------------------------------------------


def first(begin: str, stamps: list[float | None]) -> int | None:
    """The number of the entry that is begun with."""
    matches = begin_at(begin)
    now = 0.0
    for number, stamp in enumerate(stamps):
        now = now if stamp is None else stamp - (stamps[0] or 0.0)
        if matches(Entry(now, stamp, [], [])):
            return number
    return None


@pytest.mark.parametrize(
    ("begin", "number"),
    [
        ("12:00", 0),
        ("12:01", 1),
        ("12:00:30", 1),
        ("12:02:00.5", 3),
        ("+90", 2),
        ("+0", 0),
        ("2026-07-27T12:01:00", 1),
        ("2026-07-27T14:01:00+02:00", 1),
        ("11:59", 4),  # the next day
        ("2026-07-29", None),
    ],
)
def test_a_recording_begins_where_one_says(begin: str, number: int | None) -> None:
    assert first(begin, [NOON, NOON + 60, NOON + 120, NOON + 180, NOON + 86400]) == number


def test_a_recording_without_times_has_no_noon() -> None:
    assert first("12:00", [None, None]) is None


@pytest.mark.parametrize("begin", ["noon", "25:00:", "-5", ""])
def test_what_is_no_time_is_an_error(begin: str) -> None:
    with pytest.raises(ValueError, match="should be a time like 12:30"):
        begin_at(begin)


# The player -------------------------------------------------------------------------------------------


class Show:
    """A player of a log with one frame every 100 ms; what it sent, and when."""

    def __init__(
        self, path: Path, speed: float | None, count: int = 5, busy: Callable[[], bool] = lambda: False
    ) -> None:
        stamps: list[float | None] = [NOON + number / 10 for number in range(count)]
        self.sent: list[tuple[float, float]] = []
        self.player = Player(Playback(log(path / "a.log", stamps), bus=True), self._send, speed=speed, busy=busy)

    def _send(self, entry: Entry) -> None:
        self.sent.append((asyncio.get_running_loop().time(), round(entry.now, 1)))

    @property
    def positions(self) -> list[float]:
        return [position for _, position in self.sent]


@pytest.mark.parametrize("speed", [2.0, 10.0])
def test_frames_come_at_their_own_pace_or_a_multiple_of_it(tmp_path: Path, speed: float) -> None:
    async def scene() -> list[tuple[float, float]]:
        show = Show(tmp_path, speed)
        await show.player.play()
        return show.sent

    sent = asyncio.run(scene())
    began = sent[0][0]
    assert [position for _, position in sent] == [0.0, 0.1, 0.2, 0.3, 0.4]
    assert all(when - began >= position / speed - 0.001 for when, position in sent)


def test_as_fast_as_the_link_takes_it_is_as_fast_as_that(tmp_path: Path) -> None:
    async def scene() -> int:
        looked = 0

        def busy() -> bool:
            nonlocal looked
            looked += 1
            return looked % 3 != 0

        show = Show(tmp_path, None, count=200, busy=busy)
        await show.player.play()
        assert len(show.sent) == 200
        return looked

    assert asyncio.run(scene()) == 3 * (200 // 64 + 1)


def test_it_stands_still_and_goes_on(tmp_path: Path) -> None:
    async def scene() -> None:
        show = Show(tmp_path, 4.0)
        playing = asyncio.create_task(show.player.play())
        await asyncio.sleep(0.01)
        show.player.pause()
        await asyncio.sleep(0.15)
        assert show.positions == [0.0]
        show.player.pause()
        paused = asyncio.get_running_loop().time()
        await playing
        assert show.positions == [0.0, 0.1, 0.2, 0.3, 0.4]
        assert show.sent[-1][0] - paused > 0.07  # what was left of it, not less

    asyncio.run(scene())


def test_one_can_go_back_and_forth(tmp_path: Path) -> None:
    async def scene() -> None:
        show = Show(tmp_path, 1.0, count=100)
        playing = asyncio.create_task(show.player.play())
        await asyncio.sleep(0.01)
        show.player.seek(3.0)
        show.player.seek(2.0)
        await asyncio.sleep(0.01)
        assert show.positions == [0.0, 5.0]
        show.player.seek(-2.0)
        await asyncio.sleep(0.01)
        show.player.seek(-60.0)
        await asyncio.sleep(0.01)
        assert show.positions == [0.0, 5.0, 3.0, 0.0]
        show.player.seek(+60.0)
        await playing
        assert show.positions == [0.0, 5.0, 3.0, 0.0]

    asyncio.run(scene())


def test_one_can_go_elsewhere_while_it_stands_still(tmp_path: Path) -> None:
    async def scene() -> None:
        show = Show(tmp_path, 1.0, count=100)
        playing = asyncio.create_task(show.player.play())
        await asyncio.sleep(0.01)
        show.player.pause()
        show.player.seek(9.9)
        await asyncio.sleep(0.01)
        assert show.positions == [0.0]
        show.player.pause()
        await playing
        assert show.positions == [0.0, 9.9]

    asyncio.run(scene())


def test_nothing_to_play_is_an_error(tmp_path: Path) -> None:
    async def scene() -> None:
        with pytest.raises(RecordingError, match="nothing to play from there on"):
            await Show(tmp_path, None).player.play(begin_at("+60"))

    asyncio.run(scene())


def test_the_first_entry_is_the_first(tmp_path: Path) -> None:
    assert at_once(Entry(5.0, None, [], []))
