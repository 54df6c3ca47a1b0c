"""One message of a recording in columns."""

import numpy as np
import pytest

import timonel
from tests.recordings import recording
from timonel.errors import RecordingError

LOG = "canboat_canboat/samples/susteranna2020.raw"


def test_columns_are_the_values_of_the_messages():
    heading = timonel.columns(recording(LOG), "vesselHeading")
    messages = [message for message in timonel.open_recording(recording(LOG)) if message.name == "vesselHeading"]
    assert len(heading) == len(messages)
    assert heading.time.tolist() == [message.time for message in messages]
    assert heading.source.tolist() == [message.source for message in messages]
    for name in ("heading", "deviation"):
        expected = [message.fields.get(name, np.nan) for message in messages]
        np.testing.assert_array_equal(heading[name], expected)
    assert heading["reference"].tolist() == [message.fields.get("reference") for message in messages]
    assert heading.units["heading"] == "rad"


def test_items_know_the_message_that_they_are_of():
    satellites = timonel.columns(recording("canboat_canboat/samples/candumpSample2.txt"), "gnssSatsInView")
    items = satellites.items["list"]
    assert np.bincount(items["row"]).tolist() == satellites["satsInView"].tolist()
    assert set(items) >= {"row", "prn", "elevation", "status"}


def test_arrow_tables_have_the_same_values():
    heading = timonel.columns(recording(LOG), "vesselHeading")
    table = heading.to_arrow()
    assert table["heading"].to_pylist() == [None if value != value else value for value in heading["heading"].tolist()]
    assert table.schema.field("heading").metadata[b"unit"] == b"rad"


def test_a_message_that_never_came_has_no_rows():
    nothing = timonel.columns(recording(LOG), "aisClassAPositionReport")
    assert len(nothing) == 0
    assert nothing["sog"].tolist() == []
    assert nothing.time.tolist() == []


def test_what_is_not_there_is_told_with_what_may_have_been_meant():
    with pytest.raises(RecordingError, match='did you mean "vesselHeading"'):
        timonel.columns(recording(LOG), "vesselHedding")
    with pytest.raises(KeyError, match='did you mean "heading"'):
        timonel.columns(recording(LOG), "vesselHeading")["headin"]


def test_without_a_date_there_is_no_time_but_what_elapsed():
    found = timonel.columns(recording("canboat_canboat/samples/simulator1.raw"), "positionRapidUpdate")
    assert np.isnan(found.time).all()
    assert (np.diff(found.elapsed) >= 0).all()


def test_a_rovers_frames_are_columns_too(tmp_path):
    log = tmp_path / "rover.log"
    log.write_text("(1700000000.000000) can0 068#060006000600\n")
    currents = timonel.columns(log, "MotorCurrentRight")
    assert currents.units == {"front": "A", "middle": "A", "rear": "A"}
    assert currents["front"].shape == (1,)
