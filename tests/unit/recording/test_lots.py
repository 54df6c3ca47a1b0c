"""Messages wait for others of their kind: none is lost, and none overtakes another."""

import pyarrow as pa
import pytest

from tests.recordings import recording
from timonel.nmea2000.catalogue import by_id
from timonel.nmea2000.identifier import join
from timonel.recording import LogFrame, lots
from timonel.recording.assembly import Assembly, Group
from timonel.recording.chunks import open_frames
from timonel.recording.frames import from_logframes
from timonel.recording.lots import Lots
from timonel.recording.sinks.arrow import Batches, joined
from timonel.recording.tables import Lot, Tables

HEADING, RATE = 127250, 127251


def frame(pgn, sid):
    return LogFrame(float(sid), join(2, pgn, 1), bytes((sid,)) + b"\xff" * 7)


def fed(kept, *chunks):
    """What comes of each chunk: names and sequence identifiers."""
    assembly, tables = Assembly(), Tables()
    for chunk in chunks:
        yield told(kept.receive(tables.lots(assembly.receive(from_logframes(chunk)))))


def told(found):
    return [(lot.name, lot.messages.payloads[:, 0].tolist()) for lot in found]


def test_messages_of_a_kind_wait_until_they_are_many(monkeypatch):
    monkeypatch.setattr(lots, "ROWS", 4)
    kept = Lots()
    chunks = [[frame(HEADING, 1), frame(RATE, 2), frame(HEADING, 3)], [frame(HEADING, 4), frame(HEADING, 5)]]
    assert list(fed(kept, *chunks)) == [[], [("vesselHeading", [1, 3, 4, 5])]]
    assert told(kept.finish()) == [("rateOfTurn", [2])]
    assert told(kept.finish()) == []


def test_or_until_they_are_large(monkeypatch):
    monkeypatch.setattr(lots, "ENOUGH", 1)
    assert list(fed(Lots(), [frame(HEADING, 1)])) == [[("vesselHeading", [1])]]


def test_where_memory_is_scarce_the_largest_kind_goes_first(monkeypatch):
    kept = Lots()
    chunk = [frame(HEADING, 1), frame(RATE, 2), frame(RATE, 3)]
    assert list(fed(kept, chunk)) == [[]]
    held = sum(column.nbytes for lot in kept.finish() for column in lots._columns(lot.messages))
    monkeypatch.setattr(lots, "HELD", held - 1)
    assert list(fed(kept, chunk)) == [[("rateOfTurn", [2, 3])]]
    assert told(kept.finish()) == [("vesselHeading", [1])]


def test_messages_of_pgns_that_share_a_definition_are_in_the_order_of_the_recording(monkeypatch):
    monkeypatch.setattr(lots, "ROWS", 6)
    maker = bytes.fromhex("FE9F")  # of nobody: what stands for all PGNs of the range explains it
    first, other = (
        lambda sid, pgn=pgn: LogFrame(1.0, join(6, pgn, 1), bytes((sid,)) + maker) for pgn in (65290, 65300)
    )
    chunks = [[other(1), first(2), other(3)], [other(4), first(5), first(6)]]
    ((name, found),) = [one for chunk in fed(Lots(), *chunks) for one in chunk]
    assert name.startswith("0xff00")
    assert found == [1, 2, 3, 4, 5, 6]


def test_a_frame_of_a_rover_is_not_taken_for_a_message_of_its_name():
    namesake = type("vesselHeading", (), {})
    kept = Lots()
    (group,) = Assembly().receive(from_logframes([frame(HEADING, 1)]))
    own = Group(None, 160, *lots._columns(group))
    assert list(kept.receive([Lot(by_id("vesselHeading"), group), Lot(namesake, own)])) == []
    assert [lot.messages.frame for lot in kept.finish()] == [160, None]


def test_what_nothing_explains_does_not_wait():
    assert list(fed(Lots(), [frame(0x1F7FF, 1)])) == [[(None, [1])]]


def test_payloads_of_several_widths_are_as_wide_as_the_widest():
    kept = Lots()
    short, long = (LogFrame(1.0, join(6, 126998, 1), bytes((size,)) * size, whole=True) for size in (9, 20))
    list(fed(kept, [short], [long], [short]))
    (lot,) = kept.finish()
    messages = lot.messages
    assert [row[:size].tobytes() for row, size in zip(messages.payloads, messages.lengths, strict=True)] == [
        short.data,
        long.data,
        short.data,
    ]
    assert messages.row.tolist() == [0, 1, 2]


def batches(log, size, kept=None):
    """The tables of a recording, chunk by chunk or, through `kept`, from larger lots."""
    assembly, tables, made, found = Assembly(), Tables(), Batches(), {}

    def put(some):
        for lot in some:
            for name, batch in made.receive(tables.table(lot)):
                found.setdefault(name, []).append(batch)

    for frames in open_frames(log, size=size):
        some = tables.lots(assembly.receive(frames))
        put(some if kept is None else kept.receive(some))
    put(kept.finish() if kept else ())
    return {name: joined(parts) for name, parts in found.items()}


def plain(table):
    """With words instead of places in a dictionary, whose order may differ."""
    return [c.cast(pa.string()) if pa.types.is_dictionary(c.type) else c for c in table.columns]


@pytest.mark.parametrize(
    "name",
    [
        "canboat_canboat/samples/susteranna2020.raw",
        "canboat_canboat/samples/candumpSample2.txt",
        "canboat_canboat/samples/126208.raw",
        "canboat_canboat/samples/can0-2.pcap",
    ],
)
@pytest.mark.parametrize("rows", [1, 50, 1 << 16])
def test_tables_of_large_lots_are_those_of_small_ones(name, rows, monkeypatch):
    monkeypatch.setattr(lots, "ROWS", rows)
    expected = batches(recording(name), 1 << 18)
    found = batches(recording(name), 300, Lots())
    assert found.keys() == expected.keys()
    for table in found.keys() - {"unknown"}:
        assert found[table].schema.equals(expected[table].schema, check_metadata=True)
        assert plain(found[table]) == plain(expected[table])
    assert found.get("unknown", ()) == () or found["unknown"].num_rows == expected["unknown"].num_rows
