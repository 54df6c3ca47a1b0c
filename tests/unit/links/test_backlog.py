from hypothesis import given
from hypothesis import strategies as st

from tests.unit.links.far_side import line
from timonel.core.effects import Say
from timonel.links.backlog import KEYS_MAX, Backlog
from timonel.links.link import Counters


def test_a_newer_line_takes_the_place_of_the_unsent_one_of_its_key_and_is_counted():
    tally = Counters()
    backlog = Backlog(tally)
    backlog.add([line("HDT 1", "HDT"), line("DPT 1", "DPT"), line("HDT 2", "HDT")])
    assert backlog.head(1000) == b"HDT 2\r\nDPT 1\r\n"
    assert tally.replaced == 1


def test_urgent_lines_go_ahead_of_data_in_their_order_and_are_never_replaced():
    backlog = Backlog(Counters())
    backlog.add([line("HDT"), line("first", "x", urgent=True), line("second", "x", urgent=True)])
    assert backlog.head(1000) == b"first\r\nsecond\r\nHDT\r\n"


def test_an_urgent_state_takes_away_an_older_one_and_comes_after_what_led_to_it():
    tally = Counters()
    backlog = Backlog(tally)
    status = [Say(text, "STATUS", urgent=True, state=True) for text in (b"old\r\n", b"new\r\n")]
    backlog.add([status[0], line("transfer", "CMDTRANSFER", urgent=True), status[1], line("HDT")])
    assert backlog.head(1000) == b"transfer\r\nnew\r\nHDT\r\n"
    assert tally.replaced == 1


def test_the_rest_of_a_cut_line_goes_before_an_urgent_one():
    backlog = Backlog(Counters())
    backlog.keep([line("HDT"), line("DPT")], written=3)
    backlog.add([line("now", urgent=True)])
    assert backlog.head(1000) == b"\r\nnow\r\nDPT\r\n"


def test_a_cut_line_is_finished_even_if_a_newer_one_of_its_key_waits():
    tally = Counters()
    backlog = Backlog(tally)
    backlog.keep([line("HDT 1", "HDT")], written=2)
    backlog.add([line("HDT 2", "HDT")])
    assert backlog.head(1000) == b"T 1\r\nHDT 2\r\n"
    assert tally.replaced == 0


def test_a_batch_cut_between_two_lines_leaves_whole_lines():
    backlog = Backlog(Counters())
    backlog.keep([line("HDT"), line("DPT")], written=5)
    assert backlog.head(1000) == b"DPT\r\n"


def test_nothing_written_leaves_everything():
    backlog = Backlog(Counters())
    backlog.keep([line("HDT"), line("DPT")], written=0)
    assert backlog.head(1000) == b"HDT\r\nDPT\r\n"


def test_only_so_many_urgent_lines_wait_and_the_oldest_is_dropped_and_counted():
    tally = Counters()
    backlog = Backlog(tally, urgent_max=2)
    backlog.add([line(text, urgent=True) for text in ("one", "two", "three")])
    assert backlog.head(1000) == b"two\r\nthree\r\n"
    assert tally.dropped == 1


def test_only_so_many_keys_wait_and_the_oldest_is_dropped_and_counted():
    tally = Counters()
    backlog = Backlog(tally)
    backlog.add([line(str(number)) for number in range(KEYS_MAX + 1)])
    assert backlog.head(1_000_000).startswith(b"1\r\n")
    assert tally.dropped == 1


def test_the_head_is_whole_lines_until_the_room_is_filled():
    backlog = Backlog(Counters())
    backlog.add([line("HDT"), line("DPT"), line("MTW")])
    assert backlog.head(0) == b""
    assert backlog.head(5) == b"HDT\r\n"
    assert backlog.head(6) == b"HDT\r\nDPT\r\n"


def test_a_cleared_backlog_still_finishes_the_cut_line():
    tally = Counters()
    backlog = Backlog(tally)
    backlog.keep([line("HDT"), line("DPT"), line("now", urgent=True)], written=1)
    backlog.clear()
    assert backlog.head(1000) == b"DT\r\n"
    assert tally.dropped == 2


SAYS = st.builds(
    Say,
    line=st.binary(min_size=1, max_size=8).map(lambda text: text.replace(b"\n", b"") + b"\n"),
    key=st.sampled_from("abc"),
    urgent=st.booleans(),
)


@given(
    first=st.lists(SAYS, min_size=1),
    later=st.lists(SAYS),
    steps=st.lists(st.integers(0, 20)),
    cut=st.integers(0),
)
def test_whatever_is_written_when_no_line_is_ever_torn(first, later, steps, cut):
    whole = b"".join(say.line for say in first)
    cut %= len(whole) + 1
    out = whole[:cut]
    backlog = Backlog(Counters())
    backlog.keep(first, cut)
    for step in steps:
        part = backlog.head(step)[:step]
        backlog.written(len(part))
        out += part
    backlog.add(later)
    while backlog:
        part = backlog.head(7)[:5]
        backlog.written(len(part))
        out += part
    said = {say.line for say in first + later}
    assert all(text + b"\n" in said for text in out.split(b"\n")[:-1])
