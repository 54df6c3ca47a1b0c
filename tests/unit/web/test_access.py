"""Who may do what."""

import re

import pytest

from tests.unit.web.scene import HERE, KEY, OPEN_TO_ALL, TOKEN
from timonel.gateway.web_settings import Web
from timonel.web.access import (
    COOKIE,
    COOKIE_AGE,
    NOBODY,
    Access,
    Failures,
    Least,
    Rights,
    TooManyFailures,
    host_name,
)

AT = "192.168.1.7"
READER = Rights(Least.READER)


class Clock:
    """Both clocks."""

    def __init__(self) -> None:
        self.now = 1_000_000.0

    def __call__(self) -> float:
        return self.now


def access(web: Web = OPEN_TO_ALL, key: bytes = KEY, clock: Clock | None = None) -> Access:
    clock = clock or Clock()
    return Access(web, key, clock, clock)


def bearer(token: str) -> dict[bytes, bytes]:
    return {b"authorization": f"Bearer {token}".encode()}


def kept(set_cookie: str) -> dict[bytes, bytes]:
    return {b"cookie": f"other=1; {set_cookie.partition(';')[0]}; more=2".encode()}


# Tokens -----------------------------------------------------------------------------------------------------


def test_without_a_token_whoever_reaches_it_may_be_any_station() -> None:
    assert access(HERE).who({}, AT) == Rights(Least.ADMIN, (1, 2, 3, 4))


def test_with_a_token_who_says_nothing_is_nobody() -> None:
    assert access().who({}, "127.0.0.1") == NOBODY


def test_who_says_the_token_may_see() -> None:
    assert access().who(bearer(TOKEN), AT) == READER
    assert access().who({b"authorization": f"bearer  {TOKEN} ".encode()}, AT) == READER


@pytest.mark.parametrize("said", ["Bearer x", "Bearer", "Basic Zm9vOmJhcg==", TOKEN, f"Bearer {TOKEN}x", "Bearer \xff"])
def test_who_says_anything_else_is_nobody(said: str) -> None:
    assert access().who({b"authorization": said.encode("latin-1")}, AT) == NOBODY


def test_who_guesses_five_times_in_a_minute_is_not_looked_at_for_the_rest_of_it() -> None:
    clock = Clock()
    guarded = access(clock=clock)
    for second in range(5):
        clock.now = 1_000_000.0 + second
        assert guarded.who(bearer("wrong"), AT) == NOBODY
    with pytest.raises(TooManyFailures) as caught:
        guarded.who(bearer(TOKEN), AT)
    assert caught.value.seconds == pytest.approx(56.0)
    assert guarded.who(bearer(TOKEN), "192.168.1.8") == READER, "others are not held up"
    clock.now = 1_000_060.1
    assert guarded.who(bearer(TOKEN), AT) == READER


def test_success_does_not_make_up_for_failures() -> None:
    guarded = access()
    for _ in range(5):
        guarded.who(bearer("wrong"), AT)
        if _ < 4:
            guarded.who(bearer(TOKEN), AT)
    with pytest.raises(TooManyFailures):
        guarded.knows(TOKEN, AT)


def test_whoever_has_one_address_of_an_ipv6_network_has_all_of_them() -> None:
    failures = Failures()
    for number in range(5):
        failures.count(f"2001:db8:1:2::{number + 1}", 0.0)
    with pytest.raises(TooManyFailures):
        failures.check("2001:db8:1:2:ffff::1", 0.0)
    failures.check("2001:db8:1:3::1", 0.0)


def test_addresses_without_number_are_not_remembered_for_ever() -> None:
    failures = Failures()
    for number in range(30_000):
        failures.count(f"10.{number >> 16}.{number >> 8 & 255}.{number & 255}", number / 10)
    assert len(failures._failures) <= 10_000


# Cookies ----------------------------------------------------------------------------------------------------


def test_a_cookie_is_known_again_also_after_a_restart() -> None:
    cookie = access().seal([3, 2])
    assert access().who(kept(cookie), AT) == Rights(Least.STATION, (2, 3))
    assert access().who(kept(access().seal([])), AT) == READER


def test_no_script_reads_a_cookie_and_no_other_site_sends_it() -> None:
    assert access().seal([]).endswith("; Max-Age=7776000; Path=/; HttpOnly; SameSite=Strict")
    secure = access(Web("0.0.0.0", 443, TOKEN, "boat.pem", "boat.key"))
    assert secure.seal([]).endswith("; Secure")


def test_a_cookie_of_another_key_or_another_token_is_nothing() -> None:
    cookie = kept(access().seal([1]))
    assert access(key=b"x" * 32).who(cookie, AT) == NOBODY
    assert access(Web("0.0.0.0", 8080, "another token")).who(cookie, AT) == NOBODY


def test_a_cookie_that_was_changed_is_nothing() -> None:
    value = access().seal([1]).partition(";")[0].partition("=")[2]
    told, mac = value.split(".")
    other = access().seal([2]).partition(";")[0].partition("=")[2].partition(".")[0]
    for forged in (f"{other}.{mac}", told, f"{told}.", f".{mac}", f"{told}.{mac[:-2]}", f"{told}.{mac}x", "é.é", "."):
        assert access().who({b"cookie": f"{COOKIE}={forged}".encode()}, AT) == NOBODY, forged


def test_a_cookie_has_its_time() -> None:
    clock = Clock()
    cookie = kept(access(clock=clock).seal([1]))
    clock.now += COOKIE_AGE - 1
    assert access(clock=clock).who(cookie, AT).least is Least.STATION
    clock.now += 2
    assert access(clock=clock).who(cookie, AT) == NOBODY


def test_a_station_that_no_console_may_be_any_more_is_none() -> None:
    cookie = kept(access().seal([1, 2]))
    narrow = access(Web("0.0.0.0", 8080, TOKEN, stations=(2,)))
    assert narrow.who(cookie, AT) == Rights(Least.STATION, (2,))


def test_a_wrong_token_beside_a_right_cookie_is_nobody() -> None:
    cookie = access().seal([1])
    assert access().who(kept(cookie) | bearer("wrong"), AT) == NOBODY
    assert access().who(kept(cookie) | bearer(TOKEN), AT).least is Least.STATION


def test_forgetting_takes_the_cookie_back() -> None:
    assert re.match(f"{COOKIE}=; Max-Age=0; Path=/; HttpOnly", access().forget())


# Hosts and origins ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("host", "own", "ours"),
    [
        ("127.0.0.1:8080", "127.0.0.1", True),
        ("localhost", "127.0.0.1", True),
        ("[::1]:8080", "::1", True),
        ("BOAT.local:8080", "192.168.1.5", True),
        ("192.168.1.5:8080", "192.168.1.5", True),
        ("192.168.1.6:8080", "192.168.1.5", False),
        ("evil.example:8080", "127.0.0.1", False),
        ("0.0.0.0:8080", "127.0.0.1", False),
        ("boat.local.evil.example", "127.0.0.1", False),
        ("", "127.0.0.1", False),
        ("localhost:x", "127.0.0.1", False),
        ("[::1", "::1", False),
        ("[::1]x", "::1", False),
        ("user@localhost", "127.0.0.1", False),
    ],
)
def test_a_host_is_ours_by_address_or_by_configuration(host: str, own: str, ours: bool) -> None:
    assert access().is_ours(host, own) is ours


def test_the_port_of_a_host_is_not_its_name() -> None:
    assert host_name("Boat:80") == "boat"
    assert host_name("[FE80::1]") == "fe80::1"
    assert host_name(":80") is None


@pytest.mark.parametrize(
    ("headers", "ours"),
    [
        ({}, True),
        ({b"origin": b"http://boat.local:8080"}, True),
        ({b"origin": b"https://BOAT.local:8080"}, True),
        ({b"origin": b"http://boat.local"}, False),
        ({b"origin": b"http://evil.example"}, False),
        ({b"origin": b"null"}, False),
        ({b"origin": b""}, False),
        ({b"origin": b"file://boat.local:8080"}, False),
        ({b"sec-fetch-site": b"same-origin"}, True),
        ({b"sec-fetch-site": b"none"}, False),
        ({b"sec-fetch-site": b"cross-site"}, False),
        ({b"sec-fetch-site": b"same-site"}, False),
    ],
)
def test_a_change_comes_from_a_page_of_ours_or_from_no_page(headers: dict[bytes, bytes], ours: bool) -> None:
    assert access().is_from_us({b"host": b"boat.local:8080"} | headers) is ours
