import io
import json
import logging
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
