"""What other computers can reach has names on the network, and nothing else has."""

import asyncio

import pytest
from zeroconf import IPVersion, ServiceStateChange, Zeroconf
from zeroconf.asyncio import AsyncServiceBrowser, AsyncServiceInfo, AsyncZeroconf

from tests.program import free_port, until
from timonel.errors import ConfigError
from timonel.gateway import configuration as reader
from timonel.gateway import mdns
from timonel.gateway.configuration import parse
from timonel.gateway.mdns import Announcer, Service, announced, own_addresses, services

BOAT = """
[vehicle]
kind = "boat"
name = "Alba"
[bus]
url = "loop://x"
[network]
mdns = true
"""
HERE = "127.0.0.1"


def told(text: str) -> list[tuple[str, str, int]]:
    return [(each.kind, each.name, each.port) for each in services(parse(BOAT + text))]


def test_sentences_for_everybody_are_told_of() -> None:
    outputs = '[[output]]\nurl = "tcp-listen://0.0.0.0:10110"\n[[output]]\nurl = "tcp-listen://192.0.2.7:10111"\n'
    assert told(outputs) == [("_nmea-0183._tcp", "Alba", 10110), ("_nmea-0183._tcp", "Alba (2)", 10111)]


@pytest.mark.parametrize(
    "text",
    [
        '[[output]]\nurl = "tcp-listen://127.0.0.1:10110"',
        '[[output]]\nurl = "tcp-listen://0.0.0.0:0"',
        '[[output]]\nurl = "udp://192.0.2.255:10110"',
        '[[output]]\nurl = "tcp-listen://0.0.0.0:10110"\nformat = "ydraw"',
        '[[station]]\nid = 2\nurl = "tcp-listen://0.0.0.0:10110"',
        '[web]\nlisten = "127.0.0.1:8080"',
        '[web]\nlisten = "[::1]:8080"',
        '[signalk]\ntcp = "tcp-listen://localhost:8375"',
        '[signalk]\ntcp = "tcp://192.0.2.7:8375"',
    ],
)
def test_what_nobody_else_can_reach_or_should_is_not_told_of(text: str) -> None:
    assert told(text) == []


def test_a_console_for_everybody_is_told_of_with_its_signal_k() -> None:
    web = '[web]\nlisten = "0.0.0.0:8080"\ntoken = "correct horse"\n'
    kinds = ["_http._tcp", "_signalk-http._tcp", "_signalk-ws._tcp"]
    assert told(web) == [(kind, "Alba", 8080) for kind in kinds]
    signalk = '[signalk]\ntcp = "tcp-listen://0.0.0.0:8375"\nmmsi = "224123456"'
    about = {each.kind: each.about for each in services(parse(BOAT + web + signalk))}
    assert about["_http._tcp"] == {"path": "/"}
    assert about["_signalk-ws._tcp"] == about["_signalk-tcp._tcp"]
    assert about["_signalk-tcp._tcp"]["self"] == "urn:mrn:imo:mmsi:224123456"


def test_a_console_with_tls_is_told_of_as_that() -> None:
    web = '[web]\nlisten = "0.0.0.0:8080"\ntoken = "correct horse"\ncertificate = "a"\nkey = "b"'
    assert [kind for kind, *_ in told(web)] == ["_https._tcp", "_signalk-https._tcp", "_signalk-wss._tcp"]


def test_of_a_rover_only_the_console_is_told_of() -> None:
    text = """
[vehicle]
kind = "rover"
[bus]
url = "loop://x"
[[output]]
url = "tcp-listen://0.0.0.0:5000"
[web]
listen = "0.0.0.0:8080"
token = "correct horse"
"""
    assert [each.kind for each in services(parse(text))] == ["_http._tcp"]


def test_a_name_has_room_for_its_number() -> None:
    long = BOAT.replace("Alba", "Ł" * 40) + '[[output]]\nurl = "tcp-listen://0.0.0.0:1"\n' * 1
    (service,) = services(parse(long))
    assert 0 < len(service.name.encode()) <= 58


def test_the_library_is_asked_for_by_the_name_of_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "mdns_installed", lambda: False)
    with pytest.raises(ConfigError, match=r"network\.mdns: needs zeroconf: pip install timonel\[mdns\]"):
        parse(BOAT + "[web]")


def test_no_address_of_this_computer_alone_is_told() -> None:
    assert not {"127.0.0.1", "::1"} & set(own_addresses())


# On the network ---------------------------------------------------------------------------------------------


class Browser:
    """Another computer's view, on this one."""

    def __init__(self, network: AsyncZeroconf, kind: str) -> None:
        self.names: set[str] = set()
        self._browser = AsyncServiceBrowser(network.zeroconf, f"{kind}.local.", handlers=[self._changed])

    def _changed(self, zeroconf: Zeroconf, service_type: str, name: str, state_change: ServiceStateChange) -> None:
        if state_change is ServiceStateChange.Removed:
            self.names.discard(name)
        else:
            self.names.add(name)

    async def close(self) -> None:
        await self._browser.async_cancel()


def test_a_service_is_found_by_others_and_taken_back_at_the_end() -> None:
    async def play() -> None:
        port = free_port()
        service = Service("_signalk-ws._tcp", f"Alba {port}", HERE, port, {"swname": "timonel"})
        network = AsyncZeroconf(interfaces=[HERE])
        browser = Browser(network, service.kind)
        announcer = Announcer([service], interfaces=[HERE])
        announcing = asyncio.create_task(announcer.run())
        name = f"{service.name}.{service.kind}.local."
        await until(lambda: name in browser.names, "the name is there", 10.0)
        info = AsyncServiceInfo(f"{service.kind}.local.", name)
        assert await info.async_request(network.zeroconf, 3000)
        assert info.port == port
        assert info.parsed_addresses(IPVersion.V4Only) == [HERE]
        assert info.decoded_properties["swname"] == "timonel"
        await announcing
        await announcer.close()
        await until(lambda: name not in browser.names, "the name is gone", 10.0)
        await browser.close()
        await network.async_close()

    asyncio.run(play())


def test_a_network_that_is_not_there_is_tried_again(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def unreachable(**choice: object) -> None:
        raise OSError("no such network")

    monkeypatch.setattr(mdns, "AGAIN", 0.01)
    monkeypatch.setattr("zeroconf.asyncio.AsyncZeroconf", unreachable)
    caplog.set_level("WARNING")

    async def play() -> None:
        announcer = Announcer([Service("_http._tcp", "Alba", HERE, 1)], interfaces=[HERE])
        announcing = asyncio.create_task(announcer.run())
        await until(lambda: len(caplog.records) >= 2, "two attempts")
        announcing.cancel()
        await asyncio.gather(announcing, return_exceptions=True)
        await announcer.close()

    asyncio.run(play())
    assert "mDNS: no such network; tried again in" in caplog.text


@pytest.mark.parametrize("text", ["[web]", ""])
def test_where_there_is_nothing_to_tell_the_library_is_not_even_loaded(
    text: str, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(mdns, "Announcer", None)
    caplog.set_level("INFO")

    async def play() -> None:
        wanted = text or '[[output]]\nurl = "tcp-listen://0.0.0.0:10110"'
        configured = parse((BOAT if text else BOAT.replace("true", "false")) + wanted)
        async with announced(configured):
            pass

    asyncio.run(play())
    assert ("nothing to tell" in caplog.text) == bool(text), "who asked for it is told why"


def test_what_others_can_reach_is_told_while_the_gateway_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    happened: list[object] = []

    class Crier:
        def __init__(self, told: list[Service]) -> None:
            happened.append([service.kind for service in told])

        async def run(self) -> None:
            happened.append("told")
            await asyncio.Event().wait()

        async def close(self) -> None:
            happened.append("taken back")

    monkeypatch.setattr(mdns, "Announcer", Crier)

    async def play() -> None:
        async with announced(parse(BOAT + '[[output]]\nurl = "tcp-listen://0.0.0.0:10110"')):
            await asyncio.sleep(0)
            happened.append("running")

    asyncio.run(play())
    assert happened == [["_nmea-0183._tcp"], "told", "running", "taken back"]


@pytest.mark.parametrize(
    ("host", "addresses"), [("0.0.0.0", None), ("::", None), (HERE, [HERE]), ("localhost", [HERE])]
)
def test_a_service_is_told_with_the_addresses_that_it_listens_on(host: str, addresses: list[str] | None) -> None:
    found = asyncio.run(Announcer([])._addresses(host))
    assert set(found) >= set(own_addresses() if addresses is None else addresses)


def test_a_network_that_does_not_let_go_does_not_keep_the_gateway(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(mdns, "END_WITHIN", 0.01)

    class Stuck:
        async def async_unregister_all_services(self) -> None:
            await asyncio.Event().wait()

    async def play() -> None:
        announcer = Announcer([])
        announcer._network = Stuck()  # type: ignore[assignment]
        await announcer.close()

    asyncio.run(play())
    assert "could not be taken back" in caplog.text
