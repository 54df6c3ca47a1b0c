"""A running gateway with a token, attacked: what is refused stays refused, and it goes on serving everybody else."""

import asyncio
import json
import os
import random
import re
import string
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from tests.program import Program, free_port, until, write_configuration
from tests.web_client import WebClient, masked

TOKEN = "correct-horse-battery-staple"
BEARER = {"Authorization": f"Bearer {TOKEN}"}
FUZZ = 300  # messages, and as many requests
SEED = 20261122


class Attacked:
    """The program, and raw requests to it."""

    def __init__(self, program: Program, port: int) -> None:
        self.program = program
        self.port = port

    async def send(self, data: bytes, within: float = 10.0) -> bytes:
        """What comes back until it is a whole answer, it hangs up, or says nothing more."""
        reader, writer = await asyncio.open_connection("127.0.0.1", self.port)
        answer = b""
        try:
            writer.write(data)
            async with asyncio.timeout(within):
                while not whole(answer) and (more := await reader.read(1_000_000)):
                    answer += more
        except (ConnectionError, TimeoutError):
            pass
        finally:
            writer.close()
        return answer

    async def ask(self, method: str, path: str, body: bytes = b"", **headers: str) -> tuple[int, bytes]:
        """Status and everything else of one request."""
        given = {"Host": f"127.0.0.1:{self.port}", "Connection": "close"} | headers
        if body:
            given |= {"Content-Length": str(len(body))}
            given.setdefault("Content-Type", "application/json")
        lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in given.items())]
        answer = await self.send("\r\n".join([*lines, "", ""]).encode("latin-1") + body)
        return int(answer.split(b" ", 2)[1]) if answer else 0, answer

    async def post(self, path: str, said: object, **headers: str) -> tuple[int, bytes]:
        return await self.ask("POST", path, json.dumps(said).encode(), **headers)

    async def fine(self) -> None:
        """It serves whoever may."""
        assert (await self.ask("GET", "/api/v1/you", **BEARER))[0] == 200


def whole(answer: bytes) -> bool:
    """Whether its body is as long as its header says."""
    head, end, body = answer.partition(b"\r\n\r\n")
    length = re.search(rb"(?i)content-length: *(\d+)", head)
    return bool(end) and (length is None or len(body) >= int(length[1]))


@asynccontextmanager
async def attacked(directory: Path) -> AsyncIterator[Attacked]:
    port = free_port()
    web = f'[web]\nlisten = "127.0.0.1:{port}"\ntoken = "{TOKEN}"\nhosts = ["boat.local"]'
    pty = {1: f'url = "pty://{directory}/bridge"'}
    path = write_configuration(directory / "boat.toml", "loop://nothing", pty, more=web)
    os.environ["XDG_STATE_HOME"] = str(directory)
    async with Program(directory, "run", str(path)) as program:
        await program.running()
        yield Attacked(program, port)
        assert not program.ended
        log = program.log_path.read_text() + program.output_path.read_text()
        assert TOKEN not in log
        assert "Traceback" not in log, log
        assert "traceback" not in log, log


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a scene changes is as it was afterwards."""
    monkeypatch.setenv("XDG_STATE_HOME", "/nowhere")
    monkeypatch.delenv("STATE_DIRECTORY", raising=False)


def test_a_rebound_host_another_site_and_a_stranger_are_refused(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            assert (await it.ask("GET", "/api/v1/state"))[0] == 401
            assert (await it.ask("GET", "/api/v1/state", **BEARER))[0] == 200
            assert (await it.ask("GET", "/api/v1/state", Host="evil.example", **BEARER))[0] == 421
            assert (await it.ask("GET", "/api/v1/state", Host="boat.local", **BEARER))[0] == 200
            evil = {"Origin": "http://evil.example"} | BEARER
            order = {"order": {"type": "command", "id": 1, "verb": "REQCMD"}, "station": 2}
            assert (await it.post("/api/v1/commands", order, **evil))[0] == 403
            assert (await it.post("/api/v1/commands", order, **BEARER))[0] == 403, "a reader"
            for headers, status in (
                ({}, 401),
                (evil, 403),
                ({"Origin": "null"} | BEARER, 403),
                ({"Host": "evil.example"} | BEARER, 421),
                ({"Cookie": "timonel=eyJzdGF0aW9ucyI6WzFdfQ.AAAA"}, 401),
                (BEARER, 101),
                ({"Origin": f"http://127.0.0.1:{it.port}"} | BEARER, 101),
            ):
                client = WebClient(it.port, **headers)
                assert (await client.connect()).status == status, headers
                client.close()
            socket_with_token = f"/api/v1/socket?token={TOKEN}"
            assert (await it.ask("GET", socket_with_token))[0] == 405, "a token in a URL is nothing"
            assert (await it.ask("GET", f"/api/v1/state?token={TOKEN}"))[0] == 401

    asyncio.run(play())


def test_every_answer_has_the_policy_also_a_refusal(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            for path, headers in (
                ("/", {}),
                ("/nothing", {}),
                ("/api/v1/state", {}),
                ("/api/v1/state", BEARER),
                ("/", {"Host": "evil.example"}),
            ):
                _, answer = await it.ask("GET", path, **headers)
                assert answer.count(b"content-security-policy: default-src 'self'") == 1, answer
                assert answer.count(b"x-content-type-options: nosniff") == 1

    asyncio.run(play())


def test_five_guesses_a_minute_are_let_go_through_whichever_way_they_come(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            statuses = [(await it.post("/api/v1/login", {"token": f"guess {n}"}))[0] for n in range(3)]
            for n in range(3):
                client = WebClient(it.port, Authorization=f"Bearer guess {n}")
                statuses.append((await client.connect()).status)
                client.close()
            assert statuses == [403, 403, 403, 401, 401, 429]
            assert (await it.post("/api/v1/login", {"token": TOKEN}))[0] == 429
            assert (await it.ask("GET", "/"))[0] == 200

    asyncio.run(play())


def test_a_pairing_is_confirmed_by_the_digits_of_the_log_and_outlives_a_restart(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            asked = await it.post("/api/v1/pairings", {"station": 2, "name": "tablet"}, **BEARER)
            assert asked[0] == 202
            number = json.loads(asked[1].partition(b"\r\n\r\n")[2])["pairing"]
            await until(lambda: "the digits are" in it.program.log_path.read_text(), "the digits")
            (said,) = [each["text"] for each in it.program.log() if "the digits are" in each["text"]]
            assert said.startswith("tablet (127.0.0.1) asks to be Station 2: the digits are ")
            code = {"pairing": number, "code": said[-6:]}
            status, answer = await it.post("/api/v1/pairings/code", code, **BEARER)
            assert status == 200
            cookie = answer.partition(b"set-cookie: ")[2].partition(b";")[0].decode()
            await it.program.stop()
            it.program.start()
            await it.program.running()
            client = await WebClient(it.port, Cookie=cookie).connect()
            client.wake()
            await until(lambda: client.heard, "the snapshot")
            assert client.messages()[0]["you"] == {"role": "station", "station": 2, "may_choose": [2]}
            assert (await client.order("command", verb="REQCMD"))["outcome"] == "confirmed"
            client.close()

    asyncio.run(play())


PATHS = [
    "/../boat.toml", "/..%2fboat.toml", "/%2e%2e/boat.toml", "/..\\boat.toml", "/%2e%2e%5cboat.toml", "//etc/passwd",
    "/static/../../boat.toml", "/vendor/../../../messages.py", "/%00", "/.git/config", "/app.py", "/messages.d.ts",
    "/%c0%ae%c0%ae/boat.toml", "/....//boat.toml", "/etc/passwd", "/./../boat.toml", "/%252e%252e/boat.toml",
    "http://127.0.0.1/../boat.toml", "/api/v1/../../boat.toml", "/\xff\xfe",
]  # fmt: skip


def test_no_path_leads_out_of_the_directory(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            for path in PATHS:
                status, answer = await it.ask("GET", path)
                assert status in (400, 404), (path, answer)
                assert b"[vehicle]" not in answer
                assert b"root:" not in answer
            await it.fine()

    asyncio.run(play())


def requests() -> Iterable[bytes]:
    """Malformed, oversized, half and senseless."""
    rng = random.Random(SEED)
    yield b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n"
    yield b"GET " + b"a" * 70_000 + b" HTTP/1.1\r\n\r\n"
    yield b"GET / HTTP/1.1\r\n" + b"X: " + b"y" * 70_000 + b"\r\n\r\n"
    yield b"POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: -1\r\n\r\n"
    yield b"POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: 99999999999\r\n\r\n" + b"x" * 100_000
    yield (
        b"POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n"
        b"Transfer-Encoding: chunked\r\nContent-Length: 3\r\n\r\n5\r\nhello\r\n0\r\n\r\n"
    )
    yield b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03"
    for _ in range(FUZZ):
        line = "".join(rng.choices(string.printable, k=rng.randint(0, 60))).encode()
        yield rng.choice((b"", b"GET ", b"POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\n")) + line + b"\r\n\r\n"


def messages() -> Iterable[bytes]:
    """What a browser would not say: masked frames."""
    rng = random.Random(SEED)
    sound = '{"type": "command", "id": 1, "verb": "ENGAGE", "parameter": 1.5}'
    yield masked(b"x" * 5000)
    yield masked(b"\xff\xfe")
    yield masked(b"binary", opcode=2)
    yield masked(b"", opcode=3)
    yield masked(b"x" * 126, opcode=9)
    yield b"\x81\x05hello"
    yield b"\x81\xff" + b"\xff" * 8 + b"mask"
    yield masked(b'{"n":' + b"[" * 1900 + b"]" * 1900 + b"}")
    for _ in range(FUZZ):
        at, end = sorted((rng.randrange(len(sound)), rng.randrange(len(sound))))
        text = sound[:at] + "".join(rng.choices(string.printable, k=rng.randint(0, 8))) + sound[end:]
        yield masked(text.encode()[:120])


def test_requests_that_make_no_sense_hurt_nobody(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            for data in requests():
                answer = await it.send(data, within=0.05)
                assert not answer or answer.startswith(b"HTTP/1.1 4"), (data[:200], answer[:200])
            await it.fine()

    asyncio.run(play())


def test_messages_that_make_no_sense_end_the_socket_and_hurt_nobody(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            bystander = await WebClient(it.port, **BEARER).connect()
            bystander.wake()
            ended = 0
            for frame in messages():
                client = await WebClient(it.port, **BEARER).connect()
                client.wake()
                client.stream.send(frame)
                await asyncio.sleep(0.005)
                client.read()
                ended += client.closed is not None or client.gone
                client.close()
            assert ended > FUZZ / 2
            bystander.say("ping", n=1)
            await until(lambda: bystander.messages("pong"), "a pong")
            bystander.close()
            await it.fine()

    asyncio.run(play())


def test_who_knocks_and_says_nothing_or_little_keeps_nobody_out(tmp_path: Path) -> None:
    async def play() -> None:
        async with attacked(tmp_path) as it:
            silent = [await asyncio.open_connection("127.0.0.1", it.port) for _ in range(100)]
            for number, (_, writer) in enumerate(silent):
                if number % 2:
                    writer.write(b"POST /api/v1/login HTTP/1.1\r\nHost: localhost\r\nContent-Length: 10\r\n\r\n{")
            began = asyncio.get_running_loop().time()
            await it.fine()
            assert asyncio.get_running_loop().time() - began < 2.0
            for _, writer in silent:
                writer.close()

    asyncio.run(play())
