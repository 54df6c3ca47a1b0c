from collections.abc import Sequence

from tests.unit.gateway.fakes import FakeVehicle
from timonel.core.effects import Effect, Rejected, Say
from timonel.core.frame import Frame
from timonel.gateway.convert import LONGEST_PAUSE, Conversion, RecordedTime
from timonel.recording import LogFrame

NOON = 1_700_000_000.0


def times(*stamps: float | None) -> list[float]:
    time = RecordedTime()
    return [round(time.receive(stamp), 6) for stamp in stamps]


def test_time_starts_with_the_recording() -> None:
    assert times(NOON, NOON + 0.25, NOON + 2) == [0.0, 0.25, 2.0]


def test_a_recording_without_times_has_a_frame_each_millisecond() -> None:
    assert times(None, None, None) == [0.001, 0.002, 0.003]


def test_a_stamp_a_little_before_the_last_counts_as_the_last() -> None:
    assert times(NOON, NOON + 1, NOON + 0.5, NOON + 1.5) == [0.0, 1.0, 1.0, 1.5]


def test_after_a_stamp_from_long_before_time_goes_on_from_there() -> None:
    assert times(NOON, NOON + 500, NOON + 1, NOON + 3) == [0.0, 500.0, 500.0, 502.0]


def test_an_hour_of_a_longer_pause_passes() -> None:
    assert times(NOON, NOON + 1, NOON + 9000, NOON + 9001) == [0.0, 1.0, 1.0 + LONGEST_PAUSE, 2.0 + LONGEST_PAUSE]


def test_what_is_irregular_is_counted() -> None:
    time = RecordedTime()
    for stamp in (NOON, None, NOON - 1, NOON + 10_000, NOON):
        time.receive(stamp)
    assert (time.missing, time.backward, time.shortened) == (1, 2, 1)


class Ticker(FakeVehicle):
    """Says something each second, and echoes the frames it hears."""

    def __init__(self) -> None:
        super().__init__()
        self.deadline = 0.0
        self.heard_at: list[float] = []

    def expire(self, now: float) -> list[Effect]:
        self.deadline = now + 1.0
        return [Say(b"$PARP,TICK %g\r\n" % now, "TICK")]

    def receive_frames(self, frames: Sequence[Frame], now: float) -> list[Effect]:
        self.heard_at.append(now)
        return [Say(b"$IIHDT,%s\r\n" % frame.data, "HDT") for frame in frames]

    def receive_message(self, identifier: int, payload: bytes, now: float) -> list[Effect]:
        return [Rejected("unheard of", payload)]


def test_timers_go_off_between_the_frames_when_they_are_due() -> None:
    lines: list[bytes] = []
    conversion = Conversion(Ticker(), lines.append)
    conversion.receive([LogFrame(NOON, 1, b"a"), LogFrame(NOON + 1.5, 1, b"b"), LogFrame(NOON + 3, 1, b"c")])
    assert b"".join(lines).split(b"\r\n")[:-1] == [
        b"$PARP,TICK 0",
        b"$IIHDT,a",
        b"$PARP,TICK 1",
        b"$IIHDT,b",
        b"$PARP,TICK 2",
        b"$PARP,TICK 3",
        b"$IIHDT,c",
    ]


def test_frames_messages_sentences_and_rejections_are_counted() -> None:
    conversion = Conversion(Ticker(), lambda line: None)
    conversion.receive([LogFrame(NOON, 1, b"a"), LogFrame(NOON, 1, bytes(20), whole=True)])
    assert (conversion.frames, conversion.messages) == (1, 1)
    assert conversion.sentences == {"PARP": 1, "IIHDT": 1}
    assert conversion.rejected == {"unheard of": 1}
