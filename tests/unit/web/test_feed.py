"""What changed, for each who looks."""

import json
from typing import Any

from timonel.web.feed import Feed, framed
from timonel.web.messages import Measured, You

YOU = You("reader", None, [])


def value(number: float, at: float = 0.0) -> Measured:
    return Measured(number, at, "fresh")


def unframed(frame: bytes) -> Any:
    at = {126: 4, 127: 10}.get(frame[1], 2)
    return json.loads(frame[at:])


def test_a_snapshot_has_everything() -> None:
    feed = Feed("boat", "Alba")
    feed.update({"depth": value(3.0), "sog": value(2.5)}, 7.0)
    told = json.loads(feed.snapshot(YOU))
    assert told["type"] == "snapshot"
    assert (told["sequence"], told["clock"], told["vehicle"], told["name"]) == (1, 7.0, "boat", "Alba")
    assert told["you"] == {"role": "reader", "station": None, "may_choose": []}
    assert told["topics"]["depth"] == {"value": 3.0, "at": 0.0, "quality": "fresh"}


def test_what_did_not_change_is_not_said_again() -> None:
    feed = Feed("boat", "Alba")
    feed.update({"depth": value(3.0), "sog": value(2.5)}, 7.0)
    assert feed.update({"depth": value(3.0), "sog": value(2.6)}, 7.1)
    told = unframed(feed.since(1))
    assert told == {
        "type": "changes", "since": 1, "sequence": 2, "clock": 7.1,
        "topics": {"sog": {"value": 2.6, "at": 0.0, "quality": "fresh"}},
    }  # fmt: skip


def test_who_missed_some_gets_the_newest_of_each_once() -> None:
    feed = Feed("boat", "Alba")
    feed.update({"depth": value(1.0), "sog": value(1.0)}, 1.0)
    for number in range(2, 50):
        feed.update({"depth": value(number), "sog": value(1.0)}, float(number))
    told = unframed(feed.since(1))
    assert (told["since"], told["sequence"]) == (1, 49)
    assert told["topics"] == {"depth": {"value": 49, "at": 0.0, "quality": "fresh"}}


def test_nothing_new_is_said_once_a_second_so_that_silence_means_a_dead_link() -> None:
    feed = Feed("boat", "Alba")
    topics = {"depth": value(1.0)}
    feed.update(topics, 1.0)
    assert not feed.update(topics, 1.9)
    assert feed.update(topics, 2.0)
    assert unframed(feed.since(1))["topics"] == {}


def test_all_who_lack_the_same_get_the_same_bytes() -> None:
    feed = Feed("boat", "Alba")
    feed.update({"depth": value(1.0)}, 1.0)
    feed.update({"depth": value(2.0)}, 2.0)
    assert feed.since(1) is feed.since(1)
    before = feed.since(1)
    feed.update({"depth": value(3.0)}, 3.0)
    assert feed.since(1) != before


def test_a_text_is_framed_as_a_server_does() -> None:
    """RFC 6455, 5.7: examples of the first two lengths."""
    assert framed(b"Hello") == b"\x81\x05Hello"
    assert framed(b"x" * 256)[:4] == b"\x81\x7e\x01\x00"
    assert framed(b"x" * 65536)[:10] == b"\x81\x7f\x00\x00\x00\x00\x00\x01\x00\x00"
