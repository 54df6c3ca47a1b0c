"""Recordings for several processes, some of which are killed."""

import os
import signal
from pathlib import Path

import pytest

from timonel.cli.many import Work, carry_out
from timonel.cli.pool import ATTEMPTS
from timonel.errors import RecordingError


def size(file, tell):
    tell(1)
    return Path(file).stat().st_size


def killed_at_first(file, tell, mark):
    """As if the kernel had run out of memory, the first time."""
    tell(1)
    attempts = Path(mark)
    with attempts.open("a") as note:
        note.write(".")
    if Path(file).name == "deadly" and len(attempts.read_text()) < 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return file


def always_killed(file, tell):
    tell(1)
    if Path(file).name == "deadly":
        os.kill(os.getpid(), signal.SIGKILL)
    return file


def refused(file, tell):
    if Path(file).name == "deadly":
        raise RecordingError(f"{file}: no log")
    return file


@pytest.fixture
def files(tmp_path):
    names = ["a", "deadly", "b", "c"]
    for number, name in enumerate(names):
        (tmp_path / name).write_bytes(bytes(number))
    return [str(tmp_path / name) for name in names]


@pytest.mark.parametrize("jobs", [1, 2])
def test_results_are_in_the_order_of_the_work(files, jobs):
    outcome = carry_out([Work(file, size) for file in files], jobs)
    assert outcome.results == [0, 1, 2, 3]
    assert outcome.failures == []


def test_what_a_killed_worker_lost_is_done_again(files, tmp_path):
    outcome = carry_out([Work(file, killed_at_first, (str(tmp_path / "mark"),)) for file in files], 2)
    assert outcome.results == files
    assert outcome.failures == []


def test_a_file_that_kills_its_worker_every_time_is_given_up_and_the_others_are_not(files):
    outcome = carry_out([Work(file, always_killed) for file in files], 2)
    assert outcome.results == [file for file in files if not file.endswith("deadly")]
    assert outcome.failures == [f"{files[1]}: the process that read it was killed, {ATTEMPTS} times"]


@pytest.mark.parametrize("jobs", [1, 2])
def test_a_file_that_cannot_be_read_does_not_keep_the_others_from_it(files, jobs, capsys):
    outcome = carry_out([Work(file, refused) for file in files], jobs)
    assert len(outcome.results) == 3
    with pytest.raises(SystemExit) as left:
        outcome.leave()
    assert left.value.code == 1
    assert capsys.readouterr().err == f"{files[1]}: no log\n"
