"""Hosts and ports as people write them."""

import pytest

from timonel.gateway.places import is_loopback, place


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("127.0.0.1:8080", ("127.0.0.1", 8080)),
        ("boat.local:80", ("boat.local", 80)),
        ("[::1]:0", ("::1", 0)),
        ("0.0.0.0:65535", ("0.0.0.0", 65535)),
    ],
)
def test_a_place_is_a_host_and_a_port(text: str, expected: tuple[str, int]) -> None:
    assert place(text) == expected


@pytest.mark.parametrize("text", ["", "8080", ":8080", "host:", "host:x", "host:65536", "::1:8080", "host:-1"])
def test_what_is_no_place_is_told_with_what_would_be(text: str) -> None:
    with pytest.raises(ValueError, match=r"should be a host and a port, like .127\.0\.0\.1:8080."):
        place(text)


def test_only_this_computer_reaches_a_loopback_address() -> None:
    assert all(map(is_loopback, ("127.0.0.1", "127.8.9.1", "::1", "localhost")))
    assert not any(map(is_loopback, ("0.0.0.0", "::", "192.168.1.5", "boat.local")))
