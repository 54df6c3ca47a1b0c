from pathlib import Path

import pytest

from tests.recordings import recording
from tests.unit.cli.programs import timonel
from timonel.nmea0183.checksum import verify

POWER_ON = "aldas_go-nmea-client/socketcan/testdata/candump_2021-05-25-1635_5s.log"
HEADING = b"(1600000000.000000) can0 09F11223#FF102700000000FC\n"


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "boat.log"
    path.write_bytes(b"".join(HEADING.replace(b".000000", b".%06d" % (n * 100_000)) for n in range(10)))
    return path


def test_two_runs_give_the_same_bytes(tmp_path: Path) -> None:
    log = str(recording(POWER_ON))
    first, second = timonel("convert", log), timonel("convert", log, "-o", str(tmp_path / "out"))
    assert first.stdout == (tmp_path / "out").read_bytes()
    assert second.stdout == b""
    assert first.stdout.count(b"\r\n") > 10


def test_every_line_is_a_sentence_with_its_check_sum() -> None:
    run = timonel("convert", str(recording(POWER_ON)))
    lines = run.stdout.split(b"\r\n")
    assert lines.pop() == b""
    assert [line for line in lines if not isinstance(verify(line), bytes)] == []


def test_standard_input_is_read_as_a_file_is(log: Path) -> None:
    assert timonel("convert", "-", stdin=log.read_bytes()).stdout == timonel("convert", str(log)).stdout


def test_a_heading_at_10_hz_from_our_own_usual_address_comes_out_at_10_hz(log: Path) -> None:
    assert timonel("convert", str(log)).stdout.count(b"$IIHDT,57.3,T*") == 10


def test_a_configuration_has_its_say(log: Path, tmp_path: Path) -> None:
    config = tmp_path / "boat.toml"
    config.write_text(
        'vehicle.kind = "boat"\nbus.url = "loop://a"\nsentences.HDT = false\n[[output]]\nurl = "udp://127.0.0.1:2000"\n'
    )
    assert b"HDT" not in timonel("convert", str(log), "--config", str(config)).stdout


def test_what_was_read_and_written_is_summed_up(log: Path) -> None:
    summary = timonel("convert", str(log)).stderr.decode().splitlines()[-1]
    assert summary.startswith(f"{log}: candump: 10 frames, 0 whole messages, 0.9 s; ")
    assert "IIHDT 10" in summary


def test_a_line_that_cannot_be_read_is_told_with_file_and_line(log: Path) -> None:
    log.write_bytes(log.read_bytes() + b"(1600000001.0) can0 09F1\n" + HEADING)
    told = timonel("convert", str(log)).stderr.decode().splitlines()
    assert told[0].startswith(f"{log}, line 11: ")
    assert told[1] == "1 frames with a time before the one before: time stood still"


def test_a_recording_that_cannot_be_read_at_all_is_told(tmp_path: Path) -> None:
    run = timonel("convert", str(tmp_path / "nowhere.log"))
    assert (run.returncode, run.stdout) == (1, b"")
    assert run.stderr.decode() == f"{tmp_path}/nowhere.log: No such file or directory\n"


def test_the_recording_is_not_written_over(log: Path) -> None:
    before = log.read_bytes()
    run = timonel("convert", str(log), "-o", str(log))
    assert run.returncode == 2
    assert log.read_bytes() == before


def test_a_place_that_cannot_be_written_to_is_told(log: Path, tmp_path: Path) -> None:
    run = timonel("convert", str(log), "-o", str(tmp_path / "no" / "out"))
    assert run.returncode == 1
    assert b"No such file or directory" in run.stderr


def test_the_configuration_of_a_rover_is_none_for_it(log: Path, tmp_path: Path) -> None:
    rover = tmp_path / "rover.toml"
    rover.write_text('vehicle.kind = "rover"\nbus.url = "loop://a"\n[[output]]\nurl = "udp://127.0.0.1:2000"\n')
    run = timonel("convert", str(log), "--config", str(rover))
    assert run.returncode == 2
    assert run.stderr.decode() == f"{rover}, vehicle.kind: only what a boat said is converted\n"
