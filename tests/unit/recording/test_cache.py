"""Tables kept beside a recording."""

import os
import shutil

import pytest
from pyarrow import parquet

from tests.recordings import recording
from timonel.errors import RecordingError
from timonel.recording import cache


@pytest.fixture
def log(tmp_path):
    return shutil.copy(recording("canboat_canboat/samples/candumpSample2.txt"), tmp_path / "log.txt")


def made(place):
    return os.stat(os.path.join(place, "cache.json")).st_ino


def test_tables_are_made_once_and_stand_beside_the_recording(log):
    place = cache.tables(str(log), "1.0")
    assert place == f"{log}.timonel"
    first = made(place)
    assert made(cache.tables(str(log), "1.0")) == first
    assert parquet.read_metadata(f"{place}/vesselHeading.parquet").num_rows > 0


def test_they_are_made_anew_when_the_recording_changed(log):
    first = made(cache.tables(str(log), "1.0"))
    with open(log, "ab") as file:
        file.write(b"  can0  09F11217   [8]  00 83 E9 FF 7F FF 7F FD\n")
    assert made(cache.tables(str(log), "1.0")) != first


def test_they_are_made_anew_by_another_version(log):
    first = made(cache.tables(str(log), "1.0"))
    assert made(cache.tables(str(log), "1.1")) != first


def test_a_recording_of_the_same_size_and_another_time_is_another_one(log):
    first = made(cache.tables(str(log), "1.0"))
    os.utime(log, ns=(0, 0))
    assert made(cache.tables(str(log), "1.0")) != first


def test_half_a_cache_is_none(log):
    place = cache.tables(str(log), "1.0")
    os.unlink(f"{place}/cache.json")
    os.unlink(f"{place}/vesselHeading.parquet")
    assert os.path.exists(os.path.join(cache.tables(str(log), "1.0"), "vesselHeading.parquet"))


def test_where_nothing_can_be_written_they_are_in_the_users_cache(log, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    place = cache.tables(str(log), "1.0")
    assert place.startswith(str(tmp_path / "home" / "timonel" / "log.txt-"))
    assert not os.path.exists(f"{log}.timonel")


def test_a_recording_that_is_none_leaves_nothing_behind(tmp_path):
    log = tmp_path / "log.txt"
    log.write_text("nothing of the kind\n" * 10)
    with pytest.raises(RecordingError):
        cache.tables(str(log), "1.0")
    with pytest.raises(RecordingError, match="No such file"):
        cache.tables(str(tmp_path / "none"), "1.0")
    assert os.listdir(tmp_path) == ["log.txt"]
