"""What holds for every framing and every stream."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.unit.rover.lengths import ALL, DOWN
from timonel.vehicles.rover.framing import DIALECTS, Framer, Hal062, Strzyga, StrzygaCrc
from timonel.vehicles.rover.framing.strzyga import MOST_FILL

Frames = list[tuple[int, bytes]]

SHORT = {number: length for number, length in ALL.items() if length <= Hal062.LONGEST}
OFTEN = b"#\x00dehov\xff"
TELLING = bytes(value if value % 2 else OFTEN[value % len(OFTEN)] for value in range(256))
"""Every second byte becomes one that framing could stumble over."""

FRAME = st.sampled_from(sorted(SHORT)).flatmap(
    lambda number: st.tuples(
        st.just(number),
        st.binary(min_size=SHORT[number], max_size=SHORT[number]).map(lambda data: data.translate(TELLING)),
    )
)
FRAMES = st.lists(FRAME, max_size=12)
NOISE = st.lists(
    st.binary(max_size=6) | st.sampled_from([b"#", b"##", b"#o", b"#d", b"#e1", b"\x00" * 5, b"#68", b"xx", b"#6531"]),
    max_size=12,
).map(b"".join)
CUTS = st.lists(st.integers(0, 300), max_size=20)
KEPT = {Strzyga: 2 + 12 + MOST_FILL, StrzygaCrc: 2 + 12 + 2 - 1, Hal062: 18}
"""The longest undecided beginning: one byte more decides."""

every_dialect = pytest.mark.parametrize("dialect", DIALECTS.values(), ids=list(DIALECTS))


def pieces(stream: bytes, cuts: list[int]) -> list[bytes]:
    places = [0, *sorted(min(cut, len(stream)) for cut in cuts), len(stream)]
    return [stream[start:end] for start, end in pairwise(places)]


def outcome(framer: Framer, portions: list[bytes]) -> Frames:
    frames: Frames = []
    for portion in portions:
        frames += framer.receive(portion, 0.0)
    return frames + framer.finish()


def spoil(stream: bytes, places: list[int], change: Callable[[bytearray, int], object]) -> bytes:
    spoilt = bytearray(stream)
    for place in places:
        if spoilt:
            change(spoilt, place % len(spoilt))
    return bytes(spoilt)


def written(dialect: type[Framer], frames: Frames) -> bytes:
    return b"".join(dialect.write(*frame) for frame in frames)


CHANGES = st.sampled_from(
    [
        lambda stream, place: stream.pop(place),
        lambda stream, place: stream.insert(place, 0x23),
        lambda stream, place: stream.__setitem__(place, stream[place] ^ 0x10),
    ]
)


@every_dialect
@given(frames=FRAMES, noise=NOISE, places=st.lists(st.integers(0, 999), max_size=4), change=CHANGES, cuts=CUTS)
def test_how_a_stream_is_cut_into_pieces_changes_nothing(
    dialect: type[Framer],
    frames: Frames,
    noise: bytes,
    places: list[int],
    change: Callable[[bytearray, int], object],
    cuts: list[int],
) -> None:
    stream = spoil(written(dialect, frames) + noise + written(dialect, frames), places, change)
    whole, cut, bytewise = dialect(ALL), dialect(ALL), dialect(ALL)
    expected = outcome(whole, [stream])
    assert outcome(cut, pieces(stream, cuts)) == expected
    assert outcome(bytewise, [bytes((byte,)) for byte in stream]) == expected
    assert whole.counters == cut.counters == bytewise.counters


@every_dialect
@given(frames=FRAMES, cuts=CUTS)
def test_a_clean_stream_loses_nothing_whatever_the_data(dialect: type[Framer], frames: Frames, cuts: list[int]) -> None:
    framer = dialect(ALL)
    assert outcome(framer, pieces(written(dialect, frames), cuts)) == frames
    assert (framer.counters.frames, framer.counters.skipped) == (len(frames), 0)


@given(frames=st.lists(st.tuples(FRAME, st.integers(0, MOST_FILL)), max_size=12), cuts=CUTS)
def test_a_clean_stream_with_fill_loses_nothing(frames: list[tuple[tuple[int, bytes], int]], cuts: list[int]) -> None:
    framer = Strzyga(ALL)
    stream = b"".join(Strzyga.write(*frame, pad=pad) for frame, pad in frames)
    assert outcome(framer, pieces(stream, cuts)) == [frame for frame, _ in frames]
    assert (framer.counters.fill, framer.counters.skipped) == (sum(pad for _, pad in frames), 0)


@every_dialect
@given(frames=FRAMES)
def test_frames_with_silence_between_come_out_each_at_its_deadline(dialect: type[Framer], frames: Frames) -> None:
    framer = dialect(ALL)
    for number, frame in enumerate(frames):
        assert framer.receive(dialect.write(*frame), float(number)) + framer.expire(number + 0.005) == [frame]
        assert framer.waiting == 0


@every_dialect
@given(noise=NOISE | st.binary(max_size=300), cuts=CUTS)
def test_garbage_never_raises_and_no_more_than_one_frame_of_it_is_kept(
    dialect: type[Framer], noise: bytes, cuts: list[int]
) -> None:
    framer = dialect(DOWN)
    received = 0
    taken = 0
    for portion in pieces(noise, cuts):
        received += len(portion)
        taken += sum(len(dialect.write(*frame)) for frame in framer.receive(portion, 0.0))
        assert framer.waiting <= KEPT[dialect]
        assert received == taken + framer.counters.fill + framer.counters.skipped + framer.waiting


@every_dialect
@given(frames=st.lists(FRAME, min_size=4, max_size=8), noise=NOISE)
def test_after_any_noise_the_parser_is_back_after_a_few_frames(
    dialect: type[Framer], frames: Frames, noise: bytes
) -> None:
    framer = dialect(SHORT)
    outcome(framer, [noise])
    assert outcome(framer, [written(dialect, frames)]) == frames
