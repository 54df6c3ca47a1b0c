"""`timonel decode` and `timonel info` on real recordings."""

import csv
import json
import os
import subprocess
import sys

import pytest
from pyarrow import ipc, parquet

from tests.recordings import recording
from tests.unit.cli.programs import ENVIRONMENT, timonel
from timonel.recording.decoded import open_recording

SAMPLES = "canboat_canboat/samples"
LOG = f"{SAMPLES}/susteranna2020.raw"
OTHER = f"{SAMPLES}/candumpSample2.txt"


def path(name):
    return str(recording(name))


def lines(name):
    return b"".join(f"{message.line()}\n".encode() for message in open_recording(path(name)))


def test_json_lines_go_to_standard_output_and_what_was_read_to_standard_error():
    done = timonel("decode", path(LOG))
    assert done.returncode == 0
    assert done.stdout == lines(LOG)
    told = done.stderr.decode()
    for word in ("6 086", "4 429", "55 PGNs from 38 sources", "297 whole", "line 202"):
        assert word in told


def test_standard_input_is_decoded_as_a_file_is():
    done = timonel("decode", "-", stdin=recording(OTHER).read_bytes())
    assert done.stdout == lines(OTHER)


def test_several_recordings_are_read_by_several_processes_and_written_in_their_order():
    done = timonel("decode", path(LOG), path(OTHER), path(LOG), "--jobs", "2")
    assert done.stdout == lines(LOG) + lines(OTHER) + lines(LOG)
    assert len(done.stderr.splitlines()) > 3


def test_lines_go_to_a_file_or_to_one_for_each_recording(tmp_path):
    timonel("decode", path(LOG), path(OTHER), "--jobs", "1", "-o", str(tmp_path / "all.jsonl"))
    assert (tmp_path / "all.jsonl").read_bytes() == lines(LOG) + lines(OTHER)
    timonel("decode", path(OTHER), "-o", str(tmp_path / "all.jsonl"))
    assert (tmp_path / "all.jsonl").read_bytes() == lines(OTHER)
    timonel("decode", path(OTHER), path(OTHER), "--jobs", "1", "-o", f"{tmp_path}/each/")
    assert sorted(os.listdir(tmp_path / "each")) == ["candumpSample2.txt.jsonl", "candumpSample2.txt~2.jsonl"]


def test_lookups_are_words_or_numbers_and_messages_can_be_chosen():
    done = timonel("decode", path(LOG), "-m", "vesselHeading", "--pgn", "127251", "--lookups", "code")
    found = [json.loads(line) for line in done.stdout.splitlines()]
    assert {line["pgn"] for line in found} == {127250, 127251}
    assert {line["fields"]["reference"] for line in found if "reference" in line["fields"]} == {1}


def test_a_day_is_given_to_times_without_a_date():
    undated = timonel("decode", path(f"{SAMPLES}/simulator1.raw"), "-m", "systemTime")
    assert json.loads(undated.stdout.splitlines()[0])["time"] is None
    assert b"no date" in undated.stderr
    dated = timonel("decode", path(f"{SAMPLES}/simulator1.raw"), "-m", "systemTime", "--date", "2020-01-02")
    assert 1577923200 < json.loads(dated.stdout.splitlines()[0])["time"] < 1578009600


@pytest.mark.parametrize("kind", ["csv", "arrow", "parquet"])
def test_tables_are_a_file_a_message(tmp_path, kind):
    done = timonel("decode", path(LOG), "--to", kind, "-o", str(tmp_path))
    assert done.returncode == 0
    file = tmp_path / f"vesselHeading.{kind}"
    match kind:
        case "csv":
            rows = len(list(csv.reader(file.read_text().splitlines()))) - 1
        case "arrow":
            rows = ipc.open_file(file).read_all().num_rows
        case _:
            rows = parquet.read_table(file).num_rows
    assert rows == sum(message.name == "vesselHeading" for message in open_recording(path(LOG)))


def test_tables_of_several_recordings_are_in_a_directory_each(tmp_path):
    timonel("decode", path(LOG), path(OTHER), "--to", "parquet", "-o", str(tmp_path), "--jobs", "1")
    assert sorted(os.listdir(tmp_path)) == ["candumpSample2.txt", "susteranna2020.raw"]


def test_one_table_can_go_to_standard_output():
    done = timonel("decode", path(LOG), "--to", "csv", "-m", "vesselHeading")
    header = done.stdout.decode().splitlines()[0]
    assert header == '"time","source","destination","priority","sid","heading","deviation","variation","reference"'


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["-m", "vesselHedding"], 'no message is called "vesselHedding" (did you mean "vesselHeading"?)'),
        (["--to", "parquet"], "needs a directory (-o)"),
        (["--strict"], "line 202: fewer than seven fields"),
        (["-o", "{log}"], "is a recording itself"),
        (["none.log"], "none.log: No such file or directory"),
    ],
)
def test_what_cannot_be_done_is_said(arguments, told):
    done = timonel("decode", path(LOG), *(argument.format(log=path(LOG)) for argument in arguments))
    assert done.returncode != 0
    assert told in done.stderr.decode()


def test_a_recording_that_is_cut_off_gives_what_stands_before(tmp_path):
    torn = tmp_path / "torn.raw"
    torn.write_bytes(recording(LOG).read_bytes()[:50_000])
    whole = lines(LOG)
    done = timonel("decode", str(torn))
    assert done.returncode == 0
    assert done.stdout
    assert whole.startswith(done.stdout)


def test_frames_of_ones_own_rover_are_decoded(tmp_path):
    (tmp_path / "own.toml").write_text(
        '[[frame]]\nid = 164\nname = "Arm"\nto = "operator"\nsender = "arm"\n'
        'fields = [{ name = "joint", type = "u16", scale = 0.5, unit = "rad" }]\n'
    )
    (tmp_path / "rover.log").write_text("(1700000000.000000) can0 0A4#0A00\n")
    done = timonel("decode", str(tmp_path / "rover.log"), "--frames", str(tmp_path / "own.toml"))
    assert json.loads(done.stdout)["fields"] == {"joint": 5.0}, done.stderr


def test_info_tells_what_is_sent_how_often_and_by_whom():
    text = timonel("info", path(f"{SAMPLES}/can0-2.pcap")).stdout.decode()
    for word in (
        "pcap",
        "2022-11-30 12:01:29.869 UTC",
        "59.999 s",
        "vesselHeading",
        "127250",
        "Airmar",
        "C078880010E8F235",
    ):
        assert word in text


def test_info_for_programs_is_json():
    done = timonel("info", "--json", path(LOG), path(OTHER), "--jobs", "1")
    first, second = map(json.loads, done.stdout.splitlines())
    assert (first["frames"], first["unreadable"], first["dated"]) == (6086, 2, True)
    assert (second["timed"], second["first"]) == (False, None)
    assert {"pgn": 127250, "name": "vesselHeading"}.items() <= next(
        message for message in first["messages"] if message.get("pgn") == 127250
    ).items()


def test_info_of_what_is_no_recording_says_so_and_tells_the_rest(tmp_path):
    done = timonel("info", path(OTHER), str(tmp_path / "none"), "--jobs", "1")
    assert done.returncode == 1
    assert b"candumpSample2.txt" in done.stdout
    assert b"No such file" in done.stderr


@pytest.mark.parametrize(("module", "program", "extra"), [("numpy", "decode", "columns"), ("duckdb", "sql", "sql")])
def test_what_is_not_installed_is_named_with_what_installs_it(module, program, extra):
    code = f"import sys; sys.modules['{module}'] = None; from timonel.cli.main import main; main()"
    done = subprocess.run([sys.executable, "-c", code, program], capture_output=True, env=ENVIRONMENT, check=False)
    assert f"{program} needs the extra `{extra}` (pip install 'timonel[{extra}]')" in done.stderr.decode()
