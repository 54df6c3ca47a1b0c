"""What a broker is still to be told."""

from timonel.web.board import EVENTS, Board, News


def published(board: Board) -> list[tuple[str, bytes]]:
    """Everything that is to be told, and told it is."""
    said = []
    while (news := board.next()) is not None:
        said.append((news.topic, news.payload))
        board.told(news)
    return said


def test_only_what_changed_is_told() -> None:
    board = Board()
    board.put("depth", b"12")
    board.put("heading", b"1")
    assert published(board) == [("depth", b"12"), ("heading", b"1")]
    board.put("depth", b"12")
    board.put("heading", b"2")
    assert published(board) == [("heading", b"2")]


def test_of_what_changed_often_the_newest_is_told() -> None:
    board = Board()
    for heading in (b"1", b"2", b"3"):
        board.put("heading", heading)
    assert published(board) == [("heading", b"3")]


def test_what_changes_while_it_is_being_told_is_told_again() -> None:
    board = Board()
    board.put("heading", b"1")
    news = board.next()
    assert news == News("heading", b"1", retained=True)
    board.put("heading", b"2")
    board.told(news)
    assert published(board) == [("heading", b"2")]


def test_what_changes_back_while_it_is_being_told_is_known() -> None:
    board = Board()
    board.put("heading", b"1")
    news = board.next()
    assert news is not None
    board.put("heading", b"2")
    board.put("heading", b"1")
    board.told(news)
    assert published(board) == []


def test_who_may_know_nothing_is_told_all_that_stands() -> None:
    board = Board()
    board.put("depth", b"12")
    board.tell("event", b"came")
    assert published(board) == [("depth", b"12"), ("event", b"came")]
    board.forget()
    assert published(board) == [("depth", b"12")]


def test_while_nobody_listens_the_last_events_are_kept_and_the_others_counted() -> None:
    board = Board()
    for number in range(EVENTS + 3):
        board.tell("event", b"%d" % number)
    assert board.dropped == 3
    assert [payload for _, payload in published(board)] == [b"%d" % number for number in range(3, EVENTS + 3)]


def test_an_event_that_fell_out_while_it_was_being_told_takes_no_other_with_it() -> None:
    board = Board()
    board.tell("event", b"first")
    news = board.next()
    assert news is not None
    for number in range(EVENTS):
        board.tell("event", b"%d" % number)
    board.told(news)
    assert len(published(board)) == EVENTS
