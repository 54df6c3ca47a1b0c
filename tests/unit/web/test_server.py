"""The console on the gateway's own loop."""

import asyncio
import re
import socket
import ssl
from pathlib import Path

import pytest

from tests.unit.web.scene import configuration
from tests.web_client import WebClient, handshake
from timonel.errors import LinkError
from timonel.gateway.assemble import assemble
from timonel.gateway.web_settings import Web
from timonel.web.app import SECURITY
from timonel.web.server import address, listen, served

HERE = Path(__file__).parent
CERTIFICATE, KEY = str(HERE / "localhost.pem"), str(HERE / "localhost.key")
ANY_PORT = Web(port=0)


async def said(port: int, request: bytes, context: ssl.SSLContext | None = None) -> bytes:
    """Everything that comes back."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
    writer.write(request)
    answer = await asyncio.wait_for(reader.read(), 10.0)
    writer.close()
    return answer


def get(port: int, path: str) -> bytes:
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\nConnection: close\r\n\r\n".encode()


def port_of(url: str | None) -> int:
    match = re.fullmatch(r"https?://127\.0\.0\.1:(\d+)/", url or "")
    assert match, url
    return int(match[1])


def test_it_is_up_while_it_is_entered_and_gone_after() -> None:
    async def play() -> None:
        made_of = configuration("boat", ANY_PORT)
        gateway = assemble(made_of)
        async with served(gateway, made_of) as url:
            port = port_of(url)
            answer = await said(port, get(port, "/api/v1/about"))
            assert answer.startswith(b"HTTP/1.1 200 OK\r\n")
            for name, value in SECURITY.items():
                assert f"\r\n{name.lower()}: {value}\r\n".encode() in answer
            assert b"server:" not in answer.lower()
        with pytest.raises(ConnectionError):
            await said(port, b"")

    asyncio.run(play())


def test_there_is_none_where_none_is_wanted() -> None:
    async def play() -> None:
        made_of = configuration("boat", ANY_PORT)
        async with served(assemble(made_of), configuration("boat", None)) as url:  # type: ignore[arg-type]
            assert url is None

    asyncio.run(play())


def test_it_ends_at_once_also_while_somebody_looks() -> None:
    async def play() -> None:
        made_of = configuration("boat", ANY_PORT)
        loop = asyncio.get_running_loop()
        async with served(assemble(made_of), made_of) as url:
            client = await WebClient(port_of(url)).connect()
            client.wake()
            await asyncio.sleep(0.2)
            assert client.messages()[0]["type"] == "snapshot"
            ending = loop.time()
        assert loop.time() - ending < 2.0
        await asyncio.sleep(0.05)
        assert client.closed == 1012, "service restart: come again"
        client.close()

    asyncio.run(play())


def test_signals_stay_with_the_gateway() -> None:
    async def play() -> None:
        import signal

        before = signal.getsignal(signal.SIGTERM)
        made_of = configuration("boat", ANY_PORT)
        async with served(assemble(made_of), made_of):
            await asyncio.sleep(0.05)
            assert signal.getsignal(signal.SIGTERM) is before

    asyncio.run(play())


def test_a_port_that_is_taken_is_told() -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(LinkError) as caught:
            listen(Web(port=port))
    assert str(caught.value) == (
        f"console: 127.0.0.1:{port}: Address already in use; listen in [web] takes another one"
    )
    with pytest.raises(LinkError, match=r"console: 203\.0\.113\.1:80: "):
        listen(Web("203.0.113.1", 80))


def test_the_address_is_one_to_type_at_this_computer() -> None:
    for web, expected in (
        (Web("127.0.0.1", 0), "http://127.0.0.1:"),
        (Web("0.0.0.0", 0, "token"), "http://127.0.0.1:"),
        (Web("::1", 0), "http://[::1]:"),
        (Web("::", 0, "token", CERTIFICATE, KEY), "https://[::1]:"),
    ):
        with listen(web) as listener:
            assert address(web, listener) == f"{expected}{listener.getsockname()[1]}/"


def test_with_a_certificate_it_is_served_by_tls() -> None:
    async def play() -> None:
        made_of = configuration("boat", Web(port=0, certificate=CERTIFICATE, key=KEY))
        async with served(assemble(made_of), made_of) as url:
            assert url is not None
            assert url.startswith("https://")
            port = port_of(url)
            context = ssl.create_default_context(cafile=CERTIFICATE)
            answer = await said(port, get(port, "/api/v1/about"), context)
            assert answer.startswith(b"HTTP/1.1 200 OK\r\n")
            reader, writer = await asyncio.open_connection("127.0.0.1", port, ssl=context)
            writer.write(handshake(port, Origin=f"https://127.0.0.1:{port}"))
            head = await asyncio.wait_for(reader.readuntil(b"\r\n\r\n"), 10.0)
            assert head.startswith(b"HTTP/1.1 101 ")
            assert b'"type":"snapshot"' in await asyncio.wait_for(reader.read(200), 10.0)
            writer.close()

    asyncio.run(play())


def test_a_certificate_that_is_none_is_told(tmp_path: Path) -> None:
    (tmp_path / "boat.pem").write_text("nothing")

    async def play(certificate: str) -> None:
        made_of = configuration("boat", Web(port=0, certificate=certificate, key=KEY))
        async with served(assemble(made_of), made_of):
            raise AssertionError

    for certificate in (str(tmp_path / "boat.pem"), str(tmp_path / "nowhere.pem")):
        with pytest.raises(LinkError, match=re.escape(f"console: {certificate}, {KEY}: ")):
            asyncio.run(play(certificate))
