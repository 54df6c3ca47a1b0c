"""Recordings as tables: the values of the single messages, in columns."""

import math
import tracemalloc

import numpy as np
import pytest

from timonel.nmea2000.catalogue import by_id
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.recording import LogFrame
from timonel.recording.assembly import Assembly
from timonel.recording.frames import from_logframes
from timonel.recording.tables import Tables, decode_file, keep_memory
from timonel.vehicles.rover.declared import parse
from timonel.vehicles.rover.protocol import Protocol

pytestmark = pytest.mark.usefixtures("each_way")

HEADING = bytes.fromhex("FF725AFF7FFF7FFD")


def tables(*chunks, **options):
    assembly, made = Assembly(), Tables(**options)
    return [table for chunk in chunks for table in made.receive(assembly.receive(from_logframes(list(chunk))))]


def test_a_table_has_a_column_a_field():
    (table,) = tables([LogFrame(1.5, join(2, 127250, 204), HEADING), LogFrame(None, join(2, 127250, 204), b"\xff" * 8)])
    assert table.name == "vesselHeading"
    assert table.messages.source.tolist() == [204, 204]
    assert table.time[0] == 1.5
    assert math.isnan(table.time[1])
    heading = table.fields["heading"].values
    assert heading[0] == by_id("vesselHeading").decode(HEADING).heading
    assert math.isnan(heading[1])


def test_variants_of_a_pgn_are_tables_of_their_own():
    payloads = [bytes.fromhex(text) for text in ("3B87FF7FFFFFFFFF", "E598FFFFFFFFFFFF", "3B870000FFFFFFFF")]
    pilot, other = tables([LogFrame(1.0, join(7, 65345, 1), payload) for payload in payloads])
    assert (pilot.name, pilot.messages.row.tolist()) == ("seatalkPilotWindDatum", [0, 2])
    assert other.name != "seatalkPilotWindDatum"
    assert other.messages.row.tolist() == [1]


def test_what_nobody_explains_is_a_table_of_payloads():
    (table,) = tables([LogFrame(1.0, join(7, 60672, 1), b"\x01\x02")])
    assert (table.name, table.definition, table.fields) == (None, None, {})
    assert table.messages.payloads[0, : table.messages.lengths[0]].tobytes() == b"\x01\x02"


def test_repeating_sets_are_groups():
    satellite = bytes.fromhex("05102700000000FFFFFFFFF1")
    payload = b"\x00\xff\x02" + 2 * satellite
    found = tables([LogFrame(1.0, join(6, 129540, 3), data) for data in fragment(payload, 0)])
    assert [table.name for table in found] == ["gnssSatsInView"]
    (items,) = found[0].groups
    assert (items.rows.tolist(), items.fields["prn"].values.tolist()) == ([0, 0], [5, 5])


def test_a_rovers_frames_have_signals():
    protocol = Protocol()
    data = [bytes((40 + place, 60, 3)) for place in range(3)]
    size = protocol.declarations[104].size
    frames = [LogFrame(1.0, 104, (each * 3)[:size], extended=False) for each in data]
    (table,) = tables(frames)
    assert table.name == protocol.declarations[104].__name__
    expected = protocol.columns(104, np.frombuffer(b"".join(frame.data for frame in frames), np.uint8).reshape(3, size))
    assert {name: values.tolist() for name, values in table.signals.items()} == {
        name: values.tolist() for name, values in expected.items()
    }


def test_a_rovers_frame_of_another_length_or_nobodys_has_none():
    found = tables([LogFrame(1.0, 104, b"\x01", extended=False), LogFrame(1.0, 0x7FF, b"\x01", extended=False)])
    assert [(table.messages.frame, table.name, table.signals) for table in found] == [
        (104, None, {}),
        (0x7FF, None, {}),
    ]


ARM = """
[[frame]]
id = 160
name = "Arm"
to = "operator"
segmented = true
fields = [{ name = "base", type = "u32" }, { name = "elbow", type = "u32" }, { name = "grip", type = "u16" }]
"""


@pytest.fixture(scope="module")
def rover():
    return Protocol(own=parse(ARM, "own.toml"))


def test_the_halves_of_a_segmented_frame_are_joined_across_chunks(rover):
    data = bytes(range(10))
    halves = [LogFrame(1.0, 160, half, extended=False) for half in (data[:8], data[8:])]
    alone = [LogFrame(2.0, 160, data[:8], extended=False)]
    for chunks in ([halves + alone], [halves[:1], halves[1:], alone]):
        (table,) = tables(*chunks, protocol=rover)
        assert (table.name, table.messages.row.tolist(), table.signals["grip"].tolist()) == ("Arm", [1], [0x0908])
        assert table.messages.payloads.tobytes() == data


def test_a_frame_that_was_recorded_whole_needs_no_joining(rover):
    (table,) = tables([LogFrame(None, 160, bytes(10), extended=False)], protocol=rover)
    assert table.messages.payloads.tobytes() == bytes(10)


def test_a_file_comes_in_chunks_of_what_is_wanted(tmp_path):
    line = "(1620807235.135421) can0 09F112CC#FF725AFF7FFF7FFD\n(1620807235.135421) can0 09F80101#0000000000000000\n"
    (tmp_path / "log").write_text(line * 300)
    chunks = list(decode_file(tmp_path / "log", pgns={127250}, chunk=100))
    assert sum(len(table.messages.row) for chunk in chunks for table in chunk) == 300
    assert {table.name for chunk in chunks for table in chunk} == {"vesselHeading"}
    everything = [table.name for chunk in decode_file(tmp_path / "log") for table in chunk]
    assert everything == ["vesselHeading", "positionRapidUpdate"]


def test_a_file_takes_no_more_memory_than_its_chunks(tmp_path):
    line = "(1620807235.135421) can0 09F112CC#FF725AFF7FFF7FFD\n"
    keep_memory()
    peaks = []
    for count in (60_000, 240_000):
        (tmp_path / "log").write_text(line * count)
        tracemalloc.start()
        chunks = decode_file(tmp_path / "log", chunk=20_000)
        assert sum(len(table.messages.row) for chunk in chunks for table in chunk) == count
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 1.2 * peaks[0]
