"""The page's own files without a gateway, sent as the gateway sends them: packed, and under its policy."""

import http.server
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.parse import parse_qs, urlsplit

from timonel.web.app import SECURITY
from timonel.web.static import Files

FILES = Files()


class Handler(http.server.BaseHTTPRequestHandler):
    """Files; and a gateway that has only just been started."""

    def do_GET(self) -> None:
        url = urlsplit(self.path)
        if url.path == "/api/v1/history":
            names = parse_qs(url.query)["series"][0].split(",")
            series = {name: [] for name in names}
            self._send(
                json.dumps({"clock": 100.0, "ended": 100.0, "step": 1.0, "series": series}).encode(), "application/json"
            )
        elif (file := FILES.get(url.path[1:])) is None:
            self._send(b"{}", "application/json", status=404 if "." in url.path else 200)
        elif file.packed is None:
            self._send(file.plain, file.kind)
        else:
            self._send(file.packed, file.kind, {"Content-Encoding": "gzip"})

    def _send(self, content: bytes, kind: str, more: dict[str, str] | None = None, status: int = 200) -> None:
        self.send_response(status)
        headers = {**SECURITY, **(more or {}), "Content-Type": kind, "Content-Length": str(len(content))}
        for name, value in headers.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: object) -> None:
        """Nobody reads it."""


class Server(http.server.ThreadingHTTPServer):
    """One that does not mind a browser that leaves."""

    def handle_error(self, *_: object) -> None:
        """It left."""


@contextmanager
def serve() -> Iterator[str]:
    """The address of the page."""
    server = Server(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
