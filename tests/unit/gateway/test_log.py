import io
import json
import logging
import os
from collections.abc import Iterator

import pytest

from timonel.gateway import log


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def as_before() -> Iterator[None]:
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    yield
    root.handlers[:], root.level = handlers, level


def test_on_a_terminal_the_log_is_text() -> None:
    terminal = Terminal()
    log.start("info", terminal)
    logging.getLogger("timonel").warning("Bridge: %s", "not connected")
    assert terminal.getvalue()[8:] == " WARNING  Bridge: not connected\n"


def test_elsewhere_the_log_is_one_json_object_a_line() -> None:
    stream = io.StringIO()
    log.start("info", stream)
    logging.getLogger("timonel").info("two\nlines", extra={"fields": {"event": "Transferred", "commander": 2}})
    [line] = stream.getvalue().splitlines()
    entry = json.loads(line)
    assert entry.pop("time").endswith("+00:00")
    assert entry == {"level": "info", "text": "two\nlines", "event": "Transferred", "commander": 2}


def test_a_traceback_stays_in_its_object() -> None:
    stream = io.StringIO()
    log.start("info", stream)
    try:
        raise ZeroDivisionError("of our own")
    except ZeroDivisionError:
        logging.getLogger("timonel").exception("fault")
    [line] = stream.getvalue().splitlines()
    assert "ZeroDivisionError: of our own" in json.loads(line)["traceback"]


def test_what_is_less_severe_than_wanted_is_not_logged() -> None:
    stream = io.StringIO()
    log.start("warning", stream)
    logging.getLogger("timonel").info("running")
    assert stream.getvalue() == ""


def test_a_log_that_nobody_reads_holds_nothing_up_and_tells_afterwards_what_was_dropped() -> None:
    far_end, descriptor = os.pipe()
    logger = logging.getLogger("timonel")
    with open(descriptor, "w") as stream, open(far_end, "rb") as reader:
        log.start("info", stream)
        for number in range(10_000):
            logger.info("line %d", number)
        written = reader.read1(1 << 20).decode().splitlines()
        logger.info("and on")
        told, last = map(json.loads, reader.read1().decode().splitlines())
    assert told["level"] == "warning"
    assert told["text"] == f"{10_000 - len(written)} lines of the log were dropped: nobody read them"
    assert last["text"] == "and on"


def test_a_log_whose_reader_has_gone_is_nobodys_fault(capfd: pytest.CaptureFixture[str]) -> None:
    far_end, descriptor = os.pipe()
    with open(descriptor, "w") as stream:
        log.start("info", stream)
        os.close(far_end)
        logging.getLogger("timonel").info("running")
    assert capfd.readouterr() == ("", "")
