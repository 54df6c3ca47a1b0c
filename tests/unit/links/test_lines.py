from hypothesis import given
from hypothesis import strategies as st

from timonel.links.lines import LONGEST, WholeLines
from timonel.links.link import Counters


def test_a_line_is_held_back_until_it_is_whole():
    lines = WholeLines(Counters())
    assert lines.receive(b"$PARP,REQ") == b""
    assert lines.receive(b"CMD,02*XX\r\n$PARP") == b"$PARP,REQCMD,02*XX\r\n"
    assert lines.receive(b"\n") == b"$PARP\n"


def test_an_endless_line_is_counted_once_and_dropped_up_to_its_end():
    tally = Counters()
    lines = WholeLines(tally)
    for _ in range(10):
        assert lines.receive(b"x" * LONGEST) == b""
    assert lines.receive(b"rest\ngood\nnext") == b"good\n"
    assert lines.receive(b"\n") == b"next\n"
    assert tally.rejected == 1


@given(st.lists(st.text("ab\n").map(str.encode)))
def test_however_the_bytes_are_cut_the_same_lines_come_out(chunks):
    lines = WholeLines(Counters())
    whole = b"".join(chunks)
    assert b"".join(map(lines.receive, chunks)) == whole[: whole.rfind(b"\n") + 1]
