"""Whatever a recording's bytes are and however they come, nothing raises, nothing hangs, and no frame is impossible."""

from itertools import pairwise

import can
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.unit.recording import writers
from timonel.errors import RecordingError
from timonel.recording import LogFrame, LogSentence, Unreadable, open_any
from timonel.recording.formats import FORMATS, STREAMS, Lines
from timonel.recording.uart import Uart

FRAMES = [LogFrame(1.6e9 + number, 0x09F80100 + number, bytes(range(number, number + 8))) for number in range(12)]
FEW = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    """The same dozen frames in every format."""
    folder = tmp_path_factory.mktemp("samples")
    text = (writers.candump, writers.candump_printed, writers.yd_raw, writers.trc_11, writers.canboat)
    gateways = (writers.actisense_ascii, writers.ikonvert, writers.garmin, writers.ngt1, writers.ngt1_d0)
    binary = (writers.ngt1_frames, writers.ebl, writers.ebl_frames, writers.pcap, writers.pcapng)
    tools = ((can.ASCWriter, ".asc"), (can.TRCWriter, ".trc"), (can.BLFWriter, ".blf"))
    rover = [LogFrame(None, number, bytes(size)) for number, size in ((100, 2), (101, 1), (119, 1))] * 9
    return [
        *(write(FRAMES) for write in (*text, *gateways, *binary)),
        *(writers.with_python_can(writer, folder / f"a{suffix}", FRAMES) for writer, suffix in tools),
        *(writers.uart(dialect, rover) for dialect in ("strzyga", "strzyga-crc", "hal062")),
        b"1402160417499;N;$IIHDT,45.0,T*13\n" * 12,
        writers.gzipped(writers.candump(FRAMES)),
        writers.zstd(writers.candump(FRAMES)),
    ]


def possible(found):
    match found:
        case LogFrame():
            return found.identifier < (1 << 29 if found.extended else 1 << 11) and (
                found.whole or len(found.data) <= 8 or not found.extended
            )
        case LogSentence():
            return found.line[:1] in (b"$", b"!")
        case Unreadable():
            return bool(found.reason)
    return False


def cut(data, cuts):
    places = [0, *sorted(place % (len(data) + 1) for place in cuts), len(data)]
    return [data[start:end] for start, end in pairwise(places)]


def damaged(data, damage):
    data = bytearray(data)
    for place, piece in damage:
        place %= len(data)
        data[place : place + len(piece)] = piece
    return bytes(data)


CUTS = st.lists(st.integers(0, 100_000), max_size=6)
DAMAGE = st.lists(st.tuples(st.integers(0, 100_000), st.binary(max_size=6)), max_size=4)


@pytest.mark.parametrize("form", [*STREAMS, *FORMATS, Uart], ids=lambda form: form.__name__)
@FEW
@given(pick=st.integers(0, 99), damage=DAMAGE, end=st.integers(1, 100_000), cuts=CUTS)
def test_a_reader_takes_any_damage_in_any_pieces(form, samples, pick, damage, end, cuts):
    data = damaged(samples[pick % len(samples)], damage)
    data = data[: 1 + end % len(data)]
    if form in FORMATS:
        reader = Lines(form(data.decode("latin-1").splitlines()))
    elif form.recognises(data):
        try:
            reader = form(data)
        except ValueError:
            return
    else:
        return
    for piece in cut(data, cuts):
        assert all(map(possible, reader.receive(piece)))
    assert all(map(possible, reader.finish()))


@FEW
@given(pick=st.integers(0, 99), damage=DAMAGE, end=st.integers(1, 100_000))
def test_a_file_with_any_damage_is_read_or_refused(samples, tmp_path, pick, damage, end):
    data = damaged(samples[pick % len(samples)], damage)
    (tmp_path / "log").write_bytes(data[: 1 + end % len(data)])
    try:
        log = open_any(tmp_path / "log")
    except RecordingError:
        return
    assert all(map(possible, log))
    assert log.bytes_read <= log.size


@FEW
@given(st.binary(max_size=3000))
def test_any_bytes_are_read_or_refused(tmp_path, data):
    (tmp_path / "log").write_bytes(data)
    try:
        log = open_any(tmp_path / "log")
    except RecordingError:
        return
    assert all(map(possible, log))


@pytest.mark.parametrize("form", STREAMS, ids=lambda form: form.__name__)
@FEW
@given(pick=st.integers(0, 99), cuts=CUTS)
def test_what_is_read_does_not_depend_on_the_pieces(form, samples, pick, cuts):
    known = [sample for sample in samples if form.recognises(sample)]
    if known:
        data = known[pick % len(known)]
        whole, pieces = form(data), form(data)
        expected = [*whole.receive(data), *whole.finish()]
        assert [each for piece in cut(data, cuts) for each in pieces.receive(piece)] + [*pieces.finish()] == expected
