"""Browsers that look at the console while the wires are measured: most take what they are told, some hardly ever."""

import select
import socket
from multiprocessing.connection import Connection
from urllib.parse import urlsplit

DEAF = SLOW = 10  # the share of each: one in so many
SLOW_RATE = 1000  # bytes a second
SMALL = 4096  # bytes of the buffer of one that does not read
PERIOD = 0.1  # s
REQUEST = (
    "GET /api/v1/socket HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


def run_consoles(pipe: Connection, url: str, count: int) -> None:
    """Look until ended; says when all are in. What comes is thrown away unread, to leave the core to the harness."""
    sockets = [_enter(url, number) for number in range(count)]
    readers = {stream.fileno(): stream for number, stream in enumerate(sockets) if number % DEAF > 1}
    slow = [stream for number, stream in enumerate(sockets) if number % SLOW == 1]
    waiting = select.epoll()
    for descriptor in readers:
        waiting.register(descriptor, select.EPOLLIN)
    pipe.send("all in")
    buffer = bytearray(65536)
    while True:
        for descriptor, _ in waiting.poll(PERIOD):
            readers[descriptor].recv_into(buffer)
        for stream in slow:
            _sip(stream, buffer)


def _enter(url: str, number: int) -> socket.socket:
    place = urlsplit(url)
    stream = socket.socket()
    if number % DEAF < 2:
        stream.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, SMALL)
    stream.connect((place.hostname, place.port))
    stream.sendall(REQUEST.format(host=place.netloc).encode())
    assert stream.recv(12) == b"HTTP/1.1 101"
    stream.setblocking(False)
    return stream


def _sip(stream: socket.socket, buffer: bytearray) -> None:
    try:
        stream.recv_into(buffer, int(SLOW_RATE * PERIOD))
    except BlockingIOError:
        return
