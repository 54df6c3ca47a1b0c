"""The application of the server (ASGI): looks at every request before anything else does.

in this order         refused with
the host              421, a name that is not ours
the page it is from   403, where a socket is opened or something changes
who it is             429 while an address guesses, 401, 403
the body              413, 415, 400
"""

import asyncio
import gzip
import re
from collections.abc import Awaitable, Callable, Mapping, MutableMapping
from typing import Any
from urllib.parse import parse_qsl

import msgspec
from starlette.websockets import WebSocket

from timonel.web import openapi, signalk_stream, socket
from timonel.web.access import Headers, Least, Rights, TooManyFailures, headers_of
from timonel.web.api import Call, ErrorText, Problem, Reply
from timonel.web.console import Console
from timonel.web.routes import FILES, OPENAPI, ROUTES, SIGNALK, STREAM, Route
from timonel.web.signalk_api import Failed
from timonel.web.static import File, Files

Scope = MutableMapping[str, Any]
Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]

BODY_MAX = 16_384  # bytes
BODY_WITHIN = 10.0  # s
QUERY_MAX = 20  # fields
WORTH_PACKING = 2048  # bytes
APIS = ("/api/", f"{SIGNALK}/")
OPEN = {"id": "[^/]+", "path": ".+"}  # what a route may leave open
SECURITY = {
    "Content-Security-Policy": (
        "default-src 'self'; img-src 'self' data:; object-src 'none'; base-uri 'none'; form-action 'self'; "
        "frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Permissions-Policy": "camera=(), microphone=(), geolocation=(), payment=(), usb=()",
}

_by_path: dict[str, dict[str, Route]] = {}
for _route in ROUTES:
    _by_path.setdefault(_route.path, {})[_route.method] = _route
_by_pattern = {
    re.compile(re.sub(r"{(\w+)}", lambda match: f"(?P<{match[1]}>{OPEN[match[1]]})", path)): methods
    for path, methods in _by_path.items()
    if "{" in path and path != FILES
}


class App:
    """Serves a console."""

    def __init__(self, console: Console, files: Files | None = None) -> None:
        self._console = console
        self._files = files or Files()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return
        try:
            reply = await self._serve(scope, receive, send)
        except Problem as problem:
            reply = _problem(problem, scope["path"])
        except TooManyFailures as fault:
            told = Problem(429, str(fault), {"Retry-After": str(int(fault.seconds) + 1)})
            reply = _problem(told, scope["path"])
        if reply is not None:
            await _answer(scope, reply, send)

    async def _serve(self, scope: Scope, receive: Receive, send: Send) -> Reply | None:
        """The reply; None if the socket was served."""
        headers, address = headers_of(scope), (scope.get("client") or ("", 0))[0]
        access = self._console.access
        own = (scope.get("server") or (None, None))[0]
        host = headers.get(b"host", b"").decode("latin-1")
        if not access.is_ours(host, own):
            raise Problem(421, f'"{host[:100]}" is no name of this gateway; add it to hosts in [web]')
        is_socket = scope["type"] == "websocket"
        method = "SOCKET" if is_socket else scope["method"]
        route, open_places = find(method, scope["path"])
        if (is_socket or route.changes) and not access.is_from_us(headers):
            raise Problem(403, "not from a page of this gateway")
        rights = self._admitted(route, headers, address)
        if is_socket:
            scope[socket.RIGHTS] = rights
            scope.setdefault("extensions", {})
            await self._talk(route, WebSocket(scope, receive, send))
            return None
        if route.path == FILES:
            return self._file(scope["path"], headers)
        if route.path == OPENAPI:
            return Reply(words=openapi.document())
        assert route.handle is not None
        body = await _body(route, headers, receive)
        return await route.handle(Call(self._console, rights, address, _query(scope), body, open_places, host))

    async def _talk(self, route: Route, stream: WebSocket) -> None:
        if route.path != STREAM:
            await socket.serve(self._console, stream)
        elif self._console.signalk is None:
            raise Problem(404, "there is no such page")
        else:
            await signalk_stream.serve(self._console, self._console.signalk, stream, _query(stream.scope))

    def _admitted(self, route: Route, headers: Headers, address: str) -> Rights:
        if route.least is Least.NOBODY and not route.changes:
            return Rights(Least.NOBODY)
        rights = self._console.access.who(headers, address)
        if rights.least >= route.least:
            return rights
        if rights.least is Least.NOBODY:
            raise Problem(401, "sign in first", {"WWW-Authenticate": "Bearer"})
        raise Problem(403, f"only a {route.least.name.lower()} may; pair this console first")

    def _file(self, path: str, headers: Headers) -> Reply:
        file = self._files.get(path[1:])
        if file is None:
            raise Problem(404, "there is no such page")
        return _file_reply(file, headers)


def find(method: str, path: str) -> tuple[Route, dict[str, str]]:
    """The route of a request, and what stands in its open places. Raises Problem."""
    if path.startswith(SIGNALK):
        path = path.rstrip("/")
    methods, open_places = _methods(path)
    route = methods.get("GET" if method == "HEAD" else method)
    if route is None:
        allowed = ", ".join(each for each in methods if each != "SOCKET")
        raise Problem(405, f"not with {method[:20]}", {"Allow": allowed} if allowed else {})
    return route, open_places


def _methods(path: str) -> tuple[dict[str, Route], dict[str, str]]:
    if path in _by_path and "{" not in path:
        return _by_path[path], {}
    for pattern, methods in _by_pattern.items():
        if match := pattern.fullmatch(path):
            return methods, match.groupdict()
    if path.startswith(APIS):
        raise Problem(404, "there is no such page")
    return _by_path[FILES], {}


def _file_reply(file: File, headers: Headers) -> Reply:
    told = {"ETag": file.etag, "Cache-Control": file.cache, "Content-Type": file.kind, "Vary": "Accept-Encoding"}
    if file.etag.encode() in [
        tag.strip().removeprefix(b"W/") for tag in headers.get(b"if-none-match", b"").split(b",")
    ]:
        return Reply(status=304, headers=told)
    if file.packed is not None and _takes_gzip(headers):
        return Reply(words=file.packed, headers=told | {"Content-Encoding": "gzip"})
    return Reply(words=file.plain, headers=told)


def _takes_gzip(headers: Headers) -> bool:
    return any(each.split(b";")[0].strip() == b"gzip" for each in headers.get(b"accept-encoding", b"").split(b","))


def _query(scope: Scope) -> dict[str, str]:
    try:
        return dict(parse_qsl(scope["query_string"].decode("latin-1"), max_num_fields=QUERY_MAX))
    except ValueError:
        raise Problem(400, f"more than {QUERY_MAX} fields in the query") from None


async def _body(route: Route, headers: Headers, receive: Receive) -> Any:
    """What the request says, as its route declares it. Raises Problem."""
    if route.body is None:
        return None
    if headers.get(b"content-type", b"").split(b";")[0].strip().lower() != b"application/json":
        raise Problem(415, "say it in JSON: Content-Type: application/json")
    try:
        async with asyncio.timeout(BODY_WITHIN):
            said = await _read(receive)
    except TimeoutError:
        raise Problem(400, f"the body did not come within {BODY_WITHIN:g} s") from None
    try:
        return msgspec.json.decode(said, type=route.body)
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError) as fault:
        raise Problem(400, str(fault)[:200]) from None


async def _read(receive: Receive) -> bytes:
    said = b""
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise Problem(400, "nobody waits for the answer")
        part: bytes = message.get("body", b"")
        said += part
        if len(said) > BODY_MAX:
            raise Problem(413, f"more than {BODY_MAX} bytes")
        if not message.get("more_body", False):
            return said


def _problem(problem: Problem, path: str) -> Reply:
    """As the interface that was asked says it."""
    failed = Failed(problem.text, problem.status) if path.startswith(SIGNALK) else ErrorText(problem.text)
    return Reply(failed, problem.status, problem.headers)


async def _answer(scope: Scope, reply: Reply, send: Send) -> None:
    """Say it, with the headers that everything has; on a socket that was not opened too."""
    words = reply.words
    if words is None:
        words = b"" if reply.status in (204, 304) else msgspec.json.encode(reply.what)
    headers: dict[str, str] = {"Cache-Control": "no-store", **reply.headers}
    if words:
        headers.setdefault("Content-Type", "application/json")
    if reply.words is not None and "ETag" not in headers and len(words) >= WORTH_PACKING:
        headers["Vary"] = "Accept-Encoding"
        if _takes_gzip(headers_of(scope)):
            words = await asyncio.to_thread(_packed, words)
            headers["Content-Encoding"] = "gzip"
    if reply.status not in (204, 304):
        headers["Content-Length"] = str(len(words))
    kind = "http.response"
    if scope["type"] == "websocket":  # of all other answers the server sees to these, its own errors too
        kind = "websocket.http.response"
        headers |= SECURITY
    await send({"type": f"{kind}.start", "status": reply.status, "headers": _encoded(headers)})
    body = b"" if scope.get("method") == "HEAD" else words
    await send({"type": f"{kind}.body", "body": body})


def _packed(words: bytes) -> bytes:
    packed: bytes = gzip.compress(words, 1)
    return packed


def _encoded(headers: Mapping[str, str]) -> list[tuple[bytes, bytes]]:
    return [(name.lower().encode(), value.encode("latin-1", "replace")) for name, value in headers.items()]
