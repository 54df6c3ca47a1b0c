"""What is said on the socket."""

import runpy
from pathlib import Path
from typing import get_args

import msgspec
import pytest

from timonel.web import messages
from timonel.web.messages import BrowserMessage, ServerMessage

ROOT = Path(__file__).parents[3]
SAID = [
    '{"type": "command", "id": 1, "verb": "ENGAGE"}',
    '{"type": "command", "id": 1, "verb": "SETHEADING", "parameter": 1.5}',
    '{"type": "acknowledge", "id": 2, "alert": 101}',
    '{"type": "silence", "id": 2, "alert": 101}',
    '{"type": "choose", "id": 3, "station": null}',
    '{"type": "refuse_pairing", "id": 4, "pairing": 7}',
    '{"type": "refresh"}',
    '{"type": "ping", "n": 5}',
    '{"type": "stick", "n": 6, "x": -1, "y": 0.5}',
    '{"type": "stick", "n": 6, "x": -1, "y": 0.5, "seen": 17.5}',
    '{"type": "let_go"}',
    '{"type": "enable", "id": 7}',
    '{"type": "stop", "id": 8}',
    '{"type": "limit", "id": 9, "which": "speed", "value": 20}',
]
NOT_SAID = [
    "",
    "[]",
    "null",
    '{"type": "command", "id": 1}',
    '{"type": "command", "id": 1, "verb": "SELFDESTRUCT"}',
    '{"type": "command", "id": -1, "verb": "ENGAGE"}',
    '{"type": "command", "id": 1, "verb": "SETHEADING", "parameter": NaN}',
    '{"type": "command", "id": 1, "verb": "SETHEADING", "parameter": 1e999}',
    '{"type": "command", "id": 1, "verb": "ENGAGE", "station": 1}',
    '{"type": "stick", "n": 6, "x": -1.01, "y": 0}',
    '{"type": "choose", "id": 3, "station": 5}',
    '{"type": "limit", "id": 9, "which": "speed", "value": 0}',
    '{"type": "snapshot"}',
    "[" * 100_000,
]


def test_the_types_of_the_browser_are_those_of_the_declarations() -> None:
    script = runpy.run_path(str(ROOT / "scripts" / "make_types.py"))
    assert script["PATH"].read_text() == script["page"](), "run scripts/make_types.py"


def test_every_declaration_is_in_them() -> None:
    page = (ROOT / "src/timonel/web/static/messages.d.ts").read_text()
    for kind in (*get_args(BrowserMessage), *get_args(ServerMessage), messages.BoatTopics, messages.RoverTopics):
        assert f"export interface {kind.__name__} {{" in page


def test_every_message_of_the_browser_is_understood() -> None:
    said = [msgspec.json.decode(text, type=BrowserMessage) for text in SAID]
    assert {type(message) for message in said} == set(get_args(BrowserMessage))


@pytest.mark.parametrize("text", NOT_SAID, ids=lambda text: text[:60])
def test_what_is_no_message_is_none(text: str) -> None:
    with pytest.raises((msgspec.DecodeError, RecursionError)):
        msgspec.json.decode(text, type=BrowserMessage)
