import pytest

from timonel.cli.keys import Keys


@pytest.mark.parametrize(
    ("data", "keys"),
    [
        (b"ae 4.", ["a", "e", " ", "4", "."]),
        (b"\x1b[A\x1b[B\x1b[C\x1b[D", ["up", "down", "right", "left"]),
        (b"\x1bOC\x1bOD", ["right", "left"]),
        (b"\x1b[1;2C\x1b[1;2D", ["shift-right", "shift-left"]),
        (b"\x1b[c\x1b[d", ["shift-right", "shift-left"]),
        (b"\x1b[1;6C", ["shift-right"]),
        (b"\x1b[1;5C\x1b[1;3C", ["right", "right"]),
        (b"\r\n\x7f\x08", ["enter", "enter", "backspace", "backspace"]),
        (b"\x1b[5~\x1b[3;2~\x1bOP\x1b[I", []),
        (b"\x00\x01\xc3\xa9", []),
        (b"\x1b\x1b[C", ["escape", "right"]),
        (b"\x1b ", ["escape", " "]),
        (b"\x1b[;C", ["right"]),
    ],
)
def test_bytes_of_a_terminal_are_keys(data: bytes, keys: list[str]):
    assert Keys().receive(data) == keys


def test_a_sequence_may_come_in_pieces():
    keys = Keys()
    for byte in b"\x1b[1;2":
        assert keys.receive(bytes([byte])) == []
        assert keys.pending
    assert keys.receive(b"C") == ["shift-right"]
    assert not keys.pending


def test_an_escape_that_nothing_follows_is_the_escape_key():
    keys = Keys()
    assert keys.receive(b"\x1b") == []
    assert keys.expire() == ["escape"]
    assert keys.receive(b"[C") == ["[", "C"]


def test_the_beginning_of_a_sequence_that_never_ends_is_nothing():
    keys = Keys()
    keys.receive(b"\x1b[1;")
    assert keys.expire() == []
    assert keys.receive(b"a") == ["a"]
