"""A browser's end of the console's socket, as little of it as a test needs (RFC 6455)."""

import asyncio
import base64
import json
import os
import socket
import struct
from typing import Any, Self

from tests.program import until

HERE = "127.0.0.1"
PATH = "/api/v1/socket"


def handshake(port: int, path: str = PATH, **headers: str) -> bytes:
    """The request for a socket; an underscore in a header's name is a hyphen, and "" leaves it out."""
    given = {
        "Host": f"{HERE}:{port}",
        "Upgrade": "websocket",
        "Connection": "Upgrade",
        "Sec-WebSocket-Version": "13",
        "Sec-WebSocket-Key": base64.b64encode(os.urandom(16)).decode(),
    } | {name.replace("_", "-"): value for name, value in headers.items()}
    lines = [f"GET {path} HTTP/1.1", *(f"{name}: {value}" for name, value in given.items() if value)]
    return "\r\n".join([*lines, "", ""]).encode()


def masked(data: bytes, opcode: int = 1) -> bytes:
    """A frame as browsers send it."""
    size = len(data)
    length = bytes((0x80 | size,)) if size < 126 else b"\xfe" + struct.pack(">H", size)
    mask = os.urandom(4)
    return bytes((0x80 | opcode,)) + length + mask + bytes(byte ^ mask[at % 4] for at, byte in enumerate(data))


class WebClient:
    """A socket of the console that takes down what it hears, with the loop's time, while it is awake."""

    def __init__(self, port: int, buffer: int | None = None, **headers: str) -> None:
        self.port = port
        self.stream = socket.socket()
        if buffer is not None:
            self.stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        self.heard: list[tuple[float, bytes]] = []
        self.status = 0
        self.closed: int | None = None
        self.gone = False
        self._headers = headers
        self._rest = b""
        self._ids = 0

    async def connect(self) -> Self:
        """Ask for the socket; `status` is what the server says to that."""
        loop = asyncio.get_running_loop()
        self.stream.setblocking(False)
        await loop.sock_connect(self.stream, (HERE, self.port))
        await loop.sock_sendall(self.stream, handshake(self.port, **self._headers))
        answer = b""
        while b"\r\n\r\n" not in answer:
            more = await asyncio.wait_for(loop.sock_recv(self.stream, 1024), 10.0)
            assert more, answer
            answer += more
        head, _, self._rest = answer.partition(b"\r\n\r\n")
        self.status = int(head.split(b" ", 2)[1])
        return self

    def wake(self) -> None:
        """Read from now on."""
        asyncio.get_running_loop().add_reader(self.stream, self.read)
        self._take()

    def read(self, size: int = 65536) -> None:
        """What there is, up to `size` bytes."""
        try:
            data = self.stream.recv(size)
        except BlockingIOError:
            return
        except ConnectionError:
            data = b""
        if not data:
            self.gone = True
            asyncio.get_running_loop().remove_reader(self.stream)
        self._rest += data
        self._take()

    def _take(self) -> None:
        now = asyncio.get_running_loop().time()
        while len(self._rest) >= 2:
            size, at = self._rest[1] & 0x7F, 2
            if size >= 126:
                wide = ">H" if size == 126 else ">Q"
                at += struct.calcsize(wide)
                if len(self._rest) < at:
                    return
                (size,) = struct.unpack_from(wide, self._rest, 2)
            if len(self._rest) < at + size:
                return
            opcode, data = self._rest[0] & 0x0F, self._rest[at : at + size]
            self._rest = self._rest[at + size :]
            if opcode == 8:
                self.closed = int.from_bytes(data[:2], "big")
            elif opcode == 1:
                self.heard.append((now, data))

    def messages(self, type: str = "") -> list[dict[str, Any]]:
        """What was heard, of one type."""
        told = [json.loads(data) for _, data in self.heard]
        return [message for message in told if not type or message["type"] == type]

    def say(self, type: str, **fields: Any) -> None:
        self.stream.send(masked(json.dumps({"type": type, **fields}).encode()))

    async def order(self, type: str, within: float = 5.0, **fields: Any) -> dict[str, Any]:
        """Say something with an id; how it ended."""
        self._ids += 1
        number = self._ids
        self.say(type, id=number, **fields)

        def ended() -> list[dict[str, Any]]:
            return [each for each in self.messages("answer") if each["id"] == number and each["outcome"] != "sent"]

        await until(ended, f"the end of {type} {fields}", within)
        return ended()[0]

    def topics(self) -> dict[str, Any]:
        """Everything as it was told last."""
        known: dict[str, Any] = {}
        for message in self.messages():
            if message["type"] == "snapshot":
                known = dict(message["topics"])
            elif message["type"] == "changes":
                known |= message["topics"]
        return known

    def close(self) -> None:
        """As a browser that is killed."""
        asyncio.get_running_loop().remove_reader(self.stream)
        self.stream.close()
