"""`timonel sql` on real recordings."""

import csv
import json
import os
import shutil

import pytest

from tests.recordings import recording
from tests.unit.cli.programs import timonel
from timonel.recording.decoded import open_recording

NAMES = ("susteranna2020.raw", "candumpSample2.txt")


@pytest.fixture(scope="module")
def logs(tmp_path_factory):
    directory = tmp_path_factory.mktemp("logs")
    return [shutil.copy(recording(f"canboat_canboat/samples/{name}"), directory / name) for name in NAMES]


def expected(log, name):
    return [message for message in open_recording(log) if message.name == name]


def test_a_query_over_several_recordings_knows_the_file_of_each_row(logs):
    query = "select file, source, count(*) n from vesselHeading group by all order by all"
    done = timonel("sql", query, *map(str, logs))
    rows = list(csv.DictReader(done.stdout.decode().splitlines()))
    assert {row["file"] for row in rows} == set(map(str, logs))
    assert sum(int(row["n"]) for row in rows) == sum(len(expected(log, "vesselHeading")) for log in logs)


def test_answers_for_programs_are_json_lines(logs):
    query = "select time, heading, reference, deviation from vesselHeading order by time limit 1"
    (line,) = timonel("sql", "--json", query, str(logs[0])).stdout.splitlines()
    assert json.loads(line) == {
        "time": "2020-08-22T13:52:36.950000Z", "heading": 5.9782, "reference": "Magnetic", "deviation": None,
    }  # fmt: skip


def test_repeating_sets_are_tables_that_can_be_joined(logs):
    query = (
        "select count(*) n from gnssSatsInView_list join "
        "(select row_number() over () - 1 as row, satsInView from gnssSatsInView) using (row)"
    )
    done = timonel("sql", query, str(logs[1]))
    items = sum(len(message.fields.get("list", [])) for message in expected(logs[1], "gnssSatsInView"))
    assert done.stdout.decode().splitlines() == ["n", str(items)]


def test_the_second_question_is_answered_from_what_was_decoded_for_the_first(logs):
    timonel("sql", "show tables", str(logs[0]))
    note = os.stat(f"{logs[0]}.timonel/cache.json").st_ino
    assert b"vesselHeading" in timonel("sql", "show tables", str(logs[0])).stdout
    assert os.stat(f"{logs[0]}.timonel/cache.json").st_ino == note


@pytest.mark.parametrize(
    ("query", "told"), [("select * from vesselHedding", 'Did you mean "vesselHeading"'), ("selct 1", "syntax error")]
)
def test_what_is_no_query_is_said(logs, query, told):
    done = timonel("sql", query, str(logs[0]))
    assert done.returncode == 1
    assert told in done.stderr.decode()
    assert "Traceback" not in done.stderr.decode()


def test_a_file_that_is_no_recording_is_said(tmp_path):
    done = timonel("sql", "select 1", str(tmp_path / "none"))
    assert (done.returncode, done.stderr) == (1, f"{tmp_path / 'none'}: No such file or directory\n".encode())
