"""The byte streams of the specification give the frames it says, however they arrive."""

import json
from random import Random
from typing import Any

import pytest

from tests.recordings import vectors
from timonel.vehicles.rover.framing import Counters, Strzyga

CASES: list[dict[str, Any]] = [json.loads(line) for line in vectors("rover_uart.jsonl").read_text().splitlines()]
LENGTHS = {frame["id"]: len(frame["data"]) // 2 for frame in CASES[0]["frames"]}
"""The first case has every frame once."""


def frames(case: dict[str, Any]) -> list[tuple[int, bytes]]:
    return [(frame["id"], bytes.fromhex(frame["data"])) for frame in case["frames"]]


def parsed(portions: list[bytes]) -> tuple[list[tuple[int, bytes]], Counters]:
    """Bytes come every half millisecond, and behind the last one is silence."""
    framer = Strzyga(LENGTHS)
    result = []
    for number, portion in enumerate(portions):
        result += framer.receive(portion, number * 0.0005)
    result += framer.expire(len(portions) * 0.0005 + framer.deadline)
    return result, framer.counters


def test_the_vectors_have_all_twenty_one_frames() -> None:
    assert sorted(LENGTHS) == list(range(100, 121))


@pytest.mark.parametrize("case", CASES, ids=lambda case: case["name"])
def test_the_stream_gives_its_frames_whole_byte_by_byte_and_in_random_pieces(case: dict[str, Any]) -> None:
    stream = bytes.fromhex(case["stream"])
    whole = parsed([stream])
    assert whole[0] == frames(case)
    assert parsed([bytes((byte,)) for byte in stream]) == whole
    random = Random(7)
    for _ in range(50):
        cuts = sorted(random.sample(range(len(stream) + 1), min(5, len(stream))))
        pieces = [stream[start:end] for start, end in zip([0, *cuts], [*cuts, len(stream)], strict=True)]
        assert parsed(pieces) == whole


def test_the_clean_stream_is_written_as_it_was_read() -> None:
    assert b"".join(Strzyga.write(*frame) for frame in frames(CASES[0])) == bytes.fromhex(CASES[0]["stream"])
