"""Lines of text from a network: whatever comes, nothing raises, and what is written is read back."""

from hypothesis import given
from hypothesis import strategies as st

from timonel.core.frame import Frame
from timonel.nmea0183.checksum import Fault
from timonel.nmea0183.tag_block import TagBlock, split, write
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import join
from timonel.nmea2000.registry import is_fast
from timonel.nmea2000.text import FORMS, TextReader, TextWriter

SINGLE, FAST = 127250, 127237
PIECES = (
    b"$PCDIN,|01F119,|00000000,|0F|*59|A120000.107 |23FF2 |1F112 |09F11223| R |12:00:00.000|(1.0) can0 |#| FF|FF|R8"
)
ENDS = [b"\r\n", b"\n", b"\xff", b"\0"]
LIKELY = st.lists(st.sampled_from(PIECES.split(b"|") + ENDS), max_size=40).map(b"".join)
ADDRESS = st.integers(0, 253)


@given(form=st.sampled_from(sorted(FORMS)), data=st.binary(max_size=400) | LIKELY, cut=st.integers(1, 50))
def test_any_bytes_are_frames_of_at_most_eight_bytes_or_counted(form, data, cut) -> None:
    whole, parts = TextReader(FORMS[form]), TextReader(FORMS[form])
    heard = whole.receive(data)
    assert [said for at in range(0, len(data), cut) for said in parts.receive(data[at : at + cut])] == heard
    assert parts.rejected == whole.rejected <= data.count(b"\n") + data.count(b"\r")
    for said in heard:
        for frame in whole.frames(said):
            assert len(frame.data) <= 8
            assert frame.identifier < 1 << 29


@given(
    form=st.sampled_from(sorted(FORMS)),
    source=ADDRESS,
    single=st.binary(min_size=1, max_size=8),
    fast=st.binary(min_size=1, max_size=223),
    now=st.floats(0, 4e9),
)
def test_what_a_gateway_writes_another_reads(form, source, single, fast, now) -> None:
    writer, reader = TextWriter(FORMS[form]), TextReader(FORMS[form])
    assert is_fast(FAST)
    frames = [
        Frame(join(2, SINGLE, source), single),
        *(Frame(join(2, FAST, source), data) for data in fragment(fast, 1)),
    ]
    lines = [FORMS[form].report(*payload, now, False) for payload in writer.payloads(frames, 0.0)]
    heard = reader.receive(b"".join(line for line in lines if line is not None))
    assert reader.rejected == 0
    assert [frame for said in heard for frame in reader.frames(said)] == frames


@given(data=st.binary(max_size=120))
def test_any_bytes_are_a_tag_block_or_a_fault(data) -> None:
    tag, _ = split(b"\\" + data)
    assert isinstance(tag, TagBlock | Fault)


@given(source=st.from_regex(r"[A-Z]{2}[0-9]{4}", fullmatch=True), line=st.integers(1, 999))
def test_a_tag_block_is_read_back(source, line) -> None:
    assert split(write(TagBlock(source, line=line)) + b"$") == (TagBlock(source, line=line), b"$")
