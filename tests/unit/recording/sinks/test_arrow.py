"""Arrow, Parquet and CSV files: what is read back is what was decoded."""

import csv
import io

import pyarrow as pa
import pytest
from pyarrow import ipc, parquet

from tests.recordings import recording
from timonel.errors import RecordingError
from timonel.nmea2000.identifier import join
from timonel.recording import LogFrame, open_log
from timonel.recording.assembly import Assembly
from timonel.recording.decoded import Decoder
from timonel.recording.decoding import Pass
from timonel.recording.frames import from_logframes
from timonel.recording.sinks import arrow
from timonel.recording.sinks.arrow import Batches, Choice, Files, joined, write
from timonel.recording.tables import Tables
from timonel.vehicles.rover.protocol import Protocol

SAMPLE = "canboat_canboat/samples/susteranna2020.raw"
WIND = 506
"""Messages of it called windData."""


def nothing(read):
    return None


def written(directory, kind, name=SAMPLE, **choice):
    write(Pass(recording(name)), Files(directory, kind), Protocol(), Choice(**choice), nothing)
    return directory


def messages(name=SAMPLE):
    decoder = Decoder()
    return [message for frame in open_log(recording(name)) if (message := decoder.receive(frame))]


def tables(frames, labels=True):
    found = {}
    batches = Batches(labels)
    for table in Tables(labels=labels).receive(Assembly().receive(from_logframes(frames))):
        for name, batch in batches.receive(table):
            found.setdefault(name, []).append(batch)
    return {name: joined(parts) for name, parts in found.items()}


def test_parquet_has_every_message_with_its_values(tmp_path):
    written(tmp_path, "parquet")
    expected = [message for message in messages() if message.name == "windData"]
    table = parquet.read_table(tmp_path / "windData.parquet")
    assert table.num_rows == len(expected)
    for row, message in zip(table.to_pylist(), expected, strict=True):
        assert row["time"].timestamp() == message.time
        assert (row["source"], row["destination"], row["priority"]) == (message.source, 255, message.priority)
        assert {name: row[name] for name in row if row[name] is not None and name in message.fields} == message.fields


def test_every_message_is_in_a_table_of_its_name(tmp_path):
    written(tmp_path, "parquet")
    counts = {}
    for message in messages():
        counts[message.name or "unknown"] = counts.get(message.name or "unknown", 0) + 1
    found = {path.stem: parquet.read_metadata(path).num_rows for path in tmp_path.iterdir() if ".list" not in path.name}
    assert found == counts


@pytest.mark.parametrize("kind", ["arrow", "parquet"])
def test_items_of_repeating_sets_know_their_message(tmp_path, kind):
    written(tmp_path, kind, "canboat_canboat/samples/candumpSample2.txt")
    satellites = [
        message for message in messages("canboat_canboat/samples/candumpSample2.txt") if message.pgn == 129540
    ]
    path = tmp_path / f"gnssSatsInView.list.{kind}"
    table = parquet.read_table(path) if kind == "parquet" else ipc.open_file(path).read_all()
    expected = [(row, item["prn"]) for row, message in enumerate(satellites) for item in message.fields["list"]]
    assert list(zip(table["row"].to_pylist(), table["prn"].to_pylist(), strict=True)) == expected


def test_a_column_says_what_it_is_and_where_that_stands(tmp_path):
    written(tmp_path, "parquet")
    field = parquet.read_schema(tmp_path / "vesselHeading.parquet").field("heading")
    about = {key.decode(): value.decode() for key, value in field.metadata.items() if not key.startswith(b"PARQUET")}
    assert (about["unit"], about["resolution"]) == ("rad", "0.0001")
    assert about["source"].startswith("canboat ")
    assert "vesselHeading" in about["source"]


def test_lookups_are_dictionaries_of_words_or_numbers():
    frames = [
        LogFrame(1.0, join(2, 127250, 1), bytes.fromhex(data)) for data in ("0083E9FF7FFF7FFC", "0083E9FF7FFF7FFD")
    ]
    words = tables(frames)["vesselHeading"]["reference"]
    assert pa.types.is_dictionary(words.type)
    assert words.to_pylist() == ["True", "Magnetic"]
    assert tables(frames, labels=False)["vesselHeading"]["reference"].to_pylist() == [0, 1]


def test_a_field_that_is_called_as_a_column_of_every_table_stands_beside_it():
    found = tables([LogFrame(1.0, join(5, 130312, 7), bytes.fromhex("010000B871FFFFFF"))])["temperature"]
    (row,) = found.to_pylist()
    assert (row["source"], row["source_field"], row["priority"]) == (7, "Sea Temperature", 5)
    assert found.schema.field("source_field").metadata[b"title"] == b"Source"
    clock = tables([LogFrame(1.5, join(3, 126992, 7), bytes.fromhex("01F0F14C10270000"))])["systemTime"]
    (row,) = clock.to_pylist()
    assert (row["time"].timestamp(), row["time_field"], row["source_field"]) == (1.5, 1.0, "GPS")


def test_dictionaries_grow_from_batch_to_batch():
    batches = Batches()
    made = []
    for reference in ("FC", "FD"):
        frames = [LogFrame(1.0, join(2, 127250, 1), bytes.fromhex("0083E9FF7FFF7F" + reference))]
        (table,) = Tables().receive(Assembly().receive(from_logframes(frames)))
        made += [batch for _, batch in batches.receive(table)]
    assert joined(made)["reference"].to_pylist() == ["True", "Magnetic"]


def test_values_that_are_not_numbers_stand_beside_those_that_are(tmp_path):
    written(tmp_path, "parquet", "canboat_canboat/samples/126208.raw")
    table = parquet.read_table(tmp_path / "nmeaCommandGroupFunction.list.parquet")
    both = zip(table["value"].to_pylist(), table["value_text"].to_pylist(), strict=True)
    assert (None, "YD:VOLUME 60") in list(both)


def test_what_nobody_knows_is_kept_as_bytes():
    found = tables([LogFrame(1.0, join(2, 0x1F7FF, 1), b"\1\2")])["unknown"]
    assert found.select(["pgn", "data"]).to_pylist() == [{"pgn": 0x1F7FF, "data": b"\1\2"}]


def test_frames_of_a_rover_have_no_addresses():
    found = tables([LogFrame(1.0, 104, bytes(6), False), LogFrame(1.0, 101, b"\xce", False)])
    assert found["MotorCurrentRight"].column_names == ["time", "front", "middle", "rear"]
    assert found["DriveEnable"]["code"].to_pylist() == ["STOP"]


def test_times_without_a_date_are_null_unless_the_day_is_told(tmp_path):
    name = "canboat_canboat/samples/simulator1.raw"
    table = parquet.read_table(written(tmp_path / "a", "parquet", name) / "positionRapidUpdate.parquet")
    assert table["time"].null_count == table.num_rows
    day = 86400 * 10**9
    dated = parquet.read_table(written(tmp_path / "b", "parquet", name, date=day) / "positionRapidUpdate.parquet")
    assert dated["time"].to_pylist()[0].isoformat().startswith("1970-01-02T14:10:55")


def test_rows_that_wait_are_written_when_they_are_many(tmp_path, monkeypatch):
    monkeypatch.setattr(arrow, "ROWS", 10)
    written(tmp_path, "parquet")
    assert parquet.read_metadata(tmp_path / "windData.parquet").num_rows == sum(
        m.name == "windData" for m in messages()
    )


def test_the_largest_table_is_written_first_where_memory_is_scarce(tmp_path, monkeypatch):
    monkeypatch.setattr(arrow, "HELD", 1)
    written(tmp_path, "arrow")
    assert ipc.open_file(tmp_path / "windData.arrow").read_all().num_rows == sum(
        m.name == "windData" for m in messages()
    )


def test_csv_has_a_header_and_empty_fields(tmp_path):
    written(tmp_path, "csv")
    rows = list(csv.DictReader((tmp_path / "vesselHeading.csv").read_text().splitlines()))
    expected = [message for message in messages() if message.name == "vesselHeading"]
    assert len(rows) == len(expected)
    assert rows[0]["time"].startswith("2020-08-22 13:52:36.9")
    assert [row["heading"] and float(row["heading"]) for row in rows] == [m.fields.get("heading", "") for m in expected]
    assert rows[0]["deviation"] == ""


def test_a_stream_has_one_table_only():
    frames = from_logframes([LogFrame(1.0, join(2, pgn, 1), bytes(8)) for pgn in (127250, 127251)])
    files, batches = Files(io.BytesIO(), "csv"), Batches()
    for table in Tables().receive(Assembly().receive(frames)):
        for name, batch in batches.receive(table):
            files.write(name, batch)
    with pytest.raises(RecordingError, match="rateOfTurn is a second table beside vesselHeading: name a directory"):
        files.close()


def test_set_bits_are_lists_of_words():
    table = tables([LogFrame(1.0, join(6, 127489, 1), bytes(20) + b"\3\0" + bytes(4), whole=True)])
    status = table["engineParametersDynamic"]["discreteStatus1"]
    assert status.to_pylist() == [["Check Engine", "Over Temperature"]]
