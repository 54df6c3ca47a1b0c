"""JSON lines: what is not in every recording of a bus."""

import json
from typing import Annotated

import numpy as np
import pytest

from timonel.nmea2000.identifier import join
from timonel.recording.assembly import Assembly
from timonel.recording.decoded import Decoder
from timonel.recording.frames import from_logframes
from timonel.recording.lines import LogFrame
from timonel.recording.sinks.jsonl import FEW, JsonLines
from timonel.vehicles.rover.conversions import signal
from timonel.vehicles.rover.declaration import RoverFrame
from timonel.vehicles.rover.protocol import Protocol

pytestmark = pytest.mark.usefixtures("each_way")

HEADING = bytes.fromhex("0083E9FF7FFF7FFD")
DAY = 1_700_000_000 // 86400 * 86400


def lines(frames, **options):
    part = from_logframes(frames)
    text = bytes(JsonLines(**options).lines(Assembly().receive(part), 0, len(part)))
    return [json.loads(line) for line in text.splitlines()]


def heading(stamp, data=HEADING, source=23, pgn=127250):
    return LogFrame(stamp, join(2, pgn, source), data)


@pytest.mark.parametrize("count", [1, FEW + 1])
def test_without_a_date_times_are_null_unless_the_day_is_told(count):
    frames = [heading(12.5)] * count
    assert {line["time"] for line in lines(frames, day=None)} == {None}
    assert {line["time"] for line in lines(frames, day=DAY * 1_000_000_000)} == {DAY + 12.5}
    assert {line["time"] for line in lines([heading(None)] * count)} == {None}


def test_times_with_and_without_and_before_1970_stand_together():
    stamps = [None, 5.25, -3.5, 1_700_000_000.000001] * FEW
    found = lines([heading(stamp) for stamp in stamps])
    assert [line["time"] for line in found] == stamps


@pytest.mark.parametrize("count", [1, FEW + 1])
def test_what_canboat_does_not_know_has_no_name_and_no_fields(count):
    (line, *_) = lines([heading(1.0, b"\1\2", pgn=0x1F7FF)] * count)
    assert line == {
        "time": 1.0, "priority": 2, "source": 23, "destination": 255, "pgn": 0x1F7FF, "name": None, "data": "0102",
    }  # fmt: skip


@pytest.mark.parametrize("count", [1, FEW + 1])
def test_a_message_without_any_value_has_empty_fields(count):
    (line, *_) = lines([heading(1.0, b"", source=1)] * count)
    assert line["data"] == ""
    assert line["fields"] == {}


def test_only_messages_of_the_names_asked_for_are_written():
    frames = [heading(1.0), heading(1.1, pgn=127251)] * FEW
    assert {line["name"] for line in lines(frames, names={"rateOfTurn"})} == {"rateOfTurn"}


def test_every_value_of_sixteen_bits_is_printed_as_single_messages_print_it():
    raws = np.arange(0, 1 << 16, 7, dtype="<u2")
    frames = [heading(float(row), b"\0" + raw.tobytes() + HEADING[3:]) for row, raw in enumerate(raws)]
    part = from_logframes(frames)
    decoder = Decoder()
    expected = "".join(f"{message.line()}\n" for frame in frames if (message := decoder.receive(frame)))
    assert bytes(JsonLines().lines(Assembly().receive(part), 0, len(part))).decode() == expected


def test_frames_of_a_rover_have_their_number_and_name():
    currents = LogFrame(2.0, 104, bytes(6), extended=False)
    unknown = LogFrame(2.5, 0x7F0, b"\1", extended=False)
    first, second = lines([currents, unknown])
    assert (first["frame"], first["name"]) == (104, "MotorCurrentRight")
    assert first["fields"].keys() == {"front", "middle", "rear"}
    assert second == {"time": 2.5, "frame": 0x7F0, "name": None, "data": "01"}


class Arm(RoverFrame, frame=150, segmented=True):
    """Ten bytes of an arm."""

    a: Annotated[int | None, signal("u32")]
    b: Annotated[int | None, signal("u32")]
    c: Annotated[int | None, signal("u16")]


def test_the_halves_of_a_segmented_frame_are_one_line_with_the_time_of_the_second():
    halves = [LogFrame(3.0, 150, bytes(8), False), LogFrame(3.01, 150, b"\1\0", False)]
    protocol = Protocol(own=(Arm,))
    (line,) = lines(halves, protocol=protocol)
    assert (line["time"], line["frame"], line["name"], line["data"]) == (3.01, 150, "Arm", "00" * 8 + "0100")
    assert line["fields"] == {"a": 0, "b": 0, "c": 1}
    decoder = Decoder(protocol)
    (message,) = (message for half in halves if (message := decoder.receive(half)))
    assert json.loads(message.line()) == line


def test_lines_are_in_the_order_in_which_messages_were_complete():
    fast = [bytes((0, 8, 1, 2, 3, 4, 5, 6)), bytes((1, 7, 8, 255, 255, 255, 255, 255))]
    identifier = join(3, 126992 + 4, 7)
    frames = [LogFrame(1.0, identifier, fast[0]), heading(1.01), LogFrame(1.02, identifier, fast[1]), heading(1.03)]
    assert [line["pgn"] for line in lines(frames)] == [127250, 126996, 127250]
