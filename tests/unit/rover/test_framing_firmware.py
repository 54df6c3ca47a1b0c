"""The reference code in C gives the same frames as ours, byte for byte, whatever the stream."""

import struct
import subprocess
from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest

from tests.unit.rover.lengths import ALL
from timonel.vehicles.rover.framing import StrzygaCrc

FIRMWARE = Path(__file__).parents[3] / "firmware"
TABLE = bytes(ALL.get(number, 0xFF) for number in range(256))
SILENCE = b""
FLAGS = (
    "-std=c99",
    "-Wall",
    "-Wextra",
    "-Werror",
    "-pedantic",
    "-g",
    "-fsanitize=address,undefined",
    "-fno-sanitize-recover",
)

Firmware = Callable[[list[bytes]], tuple[bytes, list[int]]]


@pytest.fixture(scope="module")
def firmware(tmp_path_factory: pytest.TempPathFactory) -> Firmware:
    """Feeds portions to the C decoder; its frames, encoded again in C, and its counters come back."""
    program = tmp_path_factory.mktemp("firmware") / "filter"
    sources = [FIRMWARE / "strzyga_crc.c", Path(__file__).with_name("strzyga_crc_filter.c")]
    subprocess.run(["gcc", *FLAGS, "-I", FIRMWARE, "-o", program, *sources], check=True)

    def run(portions: list[bytes]) -> tuple[bytes, list[int]]:
        data = TABLE + b"".join(struct.pack(">H", len(portion)) + portion for portion in portions)
        output = subprocess.run([program], input=data, stdout=subprocess.PIPE, check=True).stdout
        frames, place = b"", 0
        while size := output[place]:
            frames += output[place + 1 : place + 1 + size]
            place += 1 + size
        return frames, list(struct.unpack(">5I", output[place + 1 :]))

    return run


def ours(portions: list[bytes]) -> tuple[bytes, list[int]]:
    framer = StrzygaCrc(ALL)
    frames = []
    for portion in portions:
        frames += framer.receive(portion, 0.0) if portion else framer.finish()
    counters = framer.counters
    figures = [counters.frames, counters.skipped, counters.rejected, counters.resynchronised, framer.waiting]
    return b"".join(StrzygaCrc.write(*frame) for frame in frames), figures


def telemetry(random: Random, count: int) -> bytes:
    ids = random.choices(sorted(ALL), k=count)
    return b"".join(
        StrzygaCrc.write(number, bytes(random.choices(b"#\x00hoe\xff\x64", k=ALL[number]))) for number in ids
    )


def damaged(random: Random, stream: bytes) -> bytes:
    result = bytearray()
    for byte in stream:
        match random.randrange(300):
            case 0 | 1 | 2:
                continue
            case 3:
                result += random.randbytes(3)
            case 4:
                byte ^= 1 << random.randrange(8)
            case 5:
                result += b"#"
        result.append(byte)
    return bytes(result)


def chunked(random: Random, stream: bytes) -> list[bytes]:
    portions, place = [], 0
    while place < len(stream):
        size = random.randint(1, 40)
        portions.append(stream[place : place + size])
        place += size
        if random.random() < 0.05:
            portions.append(SILENCE)
    return portions


def test_a_clean_stream_comes_back_as_it_was(firmware: Firmware) -> None:
    stream = telemetry(Random(1), 3000)
    assert firmware([stream]) == (stream, [3000, 0, 0, 0, 0])
    assert firmware([stream]) == ours([stream])


@pytest.mark.parametrize("seed", range(4))
def test_a_damaged_stream_with_gaps_gives_the_same_frames_and_counters(firmware: Firmware, seed: int) -> None:
    random = Random(seed)
    portions = chunked(random, damaged(random, telemetry(random, 5000)))
    theirs = firmware(portions)
    assert theirs == ours(portions)
    assert 3500 < theirs[1][0] < 5000


@pytest.mark.parametrize("alphabet", [bytes(range(256)), b"#", b"#h\x00", b"#ove\x31"])
def test_garbage_gives_the_same_frames_and_counters(firmware: Firmware, alphabet: bytes) -> None:
    random = Random(9)
    portions = chunked(random, bytes(random.choices(alphabet, k=40_000)))
    assert firmware(portions) == ours(portions)
