"""The console on the gateway's own loop: it is up while it is entered, and ends with the gateway.

```python
async with served(gateway, configuration) as url:
    await serve(gateway)
```
"""

import asyncio
import logging
import os
import socket
import ssl
from asyncio import BaseTransport, Transport
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, contextmanager, suppress
from typing import Any, cast

import uvicorn
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

from timonel.errors import LinkError
from timonel.gateway.configuration import Configuration
from timonel.gateway.gateway import Gateway
from timonel.gateway.web_settings import Web
from timonel.web.access import new_key
from timonel.web.app import SECURITY, App
from timonel.web.console import Console
from timonel.web.keys import kept_key
from timonel.web.socket import LINE

MESSAGE_MAX = 4096  # bytes that a browser may say at once
CONNECTIONS_MAX = 512
BACKLOG = 128  # that may knock at once
BUFFERED = 16_384  # bytes of a client that wait for it here; when it has taken them it gets the newest
KERNEL_BUFFER = 65_536  # bytes, the same in the kernel
UNSENT = 16_384  # bytes in the kernel that were not sent yet, from where on it takes no more (tcp(7))
END_WITHIN = 1  # s
PING = 20.0  # s

logger = logging.getLogger("timonel")


class Socket(WebSocketsSansIOProtocol):
    """A socket with a short queue, that can be written to without going through all of the server, and cut."""

    def connection_made(self, transport: BaseTransport) -> None:
        assert isinstance(transport, Transport)
        transport.set_write_buffer_limits(high=BUFFERED)
        super().connection_made(transport)

    def handle_connect(self, event: Any) -> None:
        super().handle_connect(event)
        if not self.handshake_complete:
            cast(dict[str, Any], self.scope["extensions"])[LINE] = self

    def send_receive_event_to_app(self) -> None:
        """What says to be text and is none is bytes, which nobody understands, and no matter for the log."""
        if self.curr_msg_data_type == "text":
            try:
                b"".join(self.frames).decode()
            except UnicodeDecodeError:
                self.curr_msg_data_type = "bytes"
        super().send_receive_event_to_app()

    def write(self, frame: bytes) -> bool:
        """Send a whole frame; false where the far end has not taken what it was sent before."""
        if not self.writable.is_set():
            return False
        if not (self.close_sent or self.disconnected or self.transport.is_closing()):
            self.transport.write(frame)
        return True

    def abort(self) -> None:
        """Cut it off."""
        self.transport.abort()


class Server(uvicorn.Server):
    """A server that leaves signals to the gateway."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


@asynccontextmanager
async def served(gateway: Gateway, configuration: Configuration) -> AsyncIterator[str | None]:
    """While it is entered, the console is served as the configuration wants; its address, None if it is not.

    Raises LinkError where that cannot be.
    """
    web = configuration.web
    if web is None:
        yield None
        return
    listener = listen(web)
    try:
        console = Console(gateway, configuration, new_key() if web.token is None else kept_key())
        server = Server(_settings(web, App(console)))
    except BaseException:
        listener.close()
        raise
    url = address(web, listener)
    logger.info("console: %s", url, extra={"fields": {"event": "console", "url": url}})
    loop = asyncio.get_running_loop()
    serving = loop.create_task(server.serve([listener]), name="console server")
    looking = loop.create_task(console.run(), name="console")
    try:
        yield url
    finally:
        looking.cancel()
        server.should_exit = True
        with suppress(asyncio.CancelledError):
            await looking
        await serving
        listener.close()


def _settings(web: Web, app: App) -> uvicorn.Config:
    settings = uvicorn.Config(
        app=app,
        lifespan="off",
        log_config=None,
        log_level="error",  # a peer's mistakes are not worth a line each
        access_log=False,
        server_header=False,
        headers=list(SECURITY.items()),
        ws=Socket,
        ws_max_size=MESSAGE_MAX,
        ws_per_message_deflate=False,
        ws_ping_interval=PING,
        ws_ping_timeout=PING,
        http="h11",
        limit_concurrency=CONNECTIONS_MAX,
        timeout_graceful_shutdown=END_WITHIN,
        proxy_headers=False,
        ssl_certfile=web.certificate,
        ssl_keyfile=web.key,
    )
    try:
        settings.load()
    except (OSError, ssl.SSLError) as fault:
        raise LinkError(f"console: {web.certificate}, {web.key}: {fault}") from fault
    return settings


def listen(web: Web) -> socket.socket:
    """The socket that the console listens on. Raises LinkError."""
    family = socket.AF_INET6 if ":" in web.host else socket.AF_INET
    listener = socket.socket(family, socket.SOCK_STREAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, KERNEL_BUFFER)
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, UNSENT)
        listener.bind((web.host, web.port))
        listener.listen(BACKLOG)
        listener.setblocking(False)
    except OSError as fault:
        listener.close()
        text = os.strerror(fault.errno) if fault.errno and fault.errno > 0 else str(fault)
        raise LinkError(f"console: {web.host}:{web.port}: {text}; listen in [web] takes another one") from fault
    return listener


def address(web: Web, listener: socket.socket) -> str:
    """What to type in a browser at this computer."""
    port = listener.getsockname()[1]
    host = {"0.0.0.0": "127.0.0.1", "::": "[::1]"}.get(web.host, f"[{web.host}]" if ":" in web.host else web.host)
    return f"{'https' if web.certificate else 'http'}://{host}:{port}/"
