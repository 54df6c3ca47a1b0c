"""A real broker on this computer, with its own clients to look at it: Debian's mosquitto."""

import json
import os
import shutil
import signal
import socket
import subprocess
from pathlib import Path
from typing import Any, Self

import pytest

from tests.program import free_port, until

HERE = "127.0.0.1"
QUIET = "allow_anonymous true\npersistence false\nset_tcp_nodelay true\n"


def tool(name: str) -> str:
    path = shutil.which(name, path="/usr/sbin:/usr/bin:/usr/local/sbin:/usr/local/bin")
    if path is None:
        pytest.fail(f"{name} is missing: apt-get install mosquitto mosquitto-clients")
    return path


class Mosquitto:
    """A broker that may be stopped, frozen and started again at the same port; `more` are lines of its file."""

    def __init__(self, directory: Path, more: str = QUIET) -> None:
        self.port = free_port()
        self.url = f"mqtt://{HERE}:{self.port}"
        self._directory = directory
        self._file = directory / "mosquitto.conf"
        self._file.write_text(f"listener {self.port} {HERE}\n{more}")
        self._process: subprocess.Popen[bytes] | None = None

    async def start(self) -> None:
        with (self._directory / "mosquitto.log").open("ab") as log:
            self._process = subprocess.Popen([tool("mosquitto"), "-c", str(self._file)], stdout=log, stderr=log)
        await until(self._listens, "mosquitto listens")

    def _listens(self) -> bool:
        with socket.socket() as stream:
            return stream.connect_ex((HERE, self.port)) == 0

    def freeze(self, frozen: bool) -> None:
        """It does nothing any more, and its sockets stay open."""
        assert self._process is not None
        os.kill(self._process.pid, signal.SIGSTOP if frozen else signal.SIGCONT)

    def stop(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()

    def publish(self, topic: str, payload: str, *options: str) -> None:
        command = [tool("mosquitto_pub"), "-h", HERE, "-p", str(self.port), "-t", topic, "-m", payload, *options]
        subprocess.run(command, check=True, timeout=10)

    async def __aenter__(self) -> Self:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        self.stop()


class Listener:
    """Somebody who subscribes to everything now, and takes down what he hears."""

    def __init__(self, broker: Mosquitto, directory: Path, *options: str) -> None:
        self._path = directory / f"heard-{os.urandom(4).hex()}.jsonl"
        command = [tool("mosquitto_sub"), "-h", HERE, "-p", str(broker.port), "-t", "#", "-F", "%j", *options]
        with self._path.open("wb") as file:
            self._process = subprocess.Popen(command, stdout=file)

    @property
    def heard(self) -> list[dict[str, Any]]:
        whole = self._path.read_text().rpartition("\n")[0]
        return [json.loads(line) for line in whole.splitlines()]

    def said(self, topic: str) -> list[Any]:
        """What was published there, in order."""
        return [_understood(each["payload"]) for each in self.heard if each["topic"] == topic]

    @property
    def standing(self) -> dict[str, Any]:
        """The last of every topic that was not taken back."""
        last = {each["topic"]: _understood(each["payload"]) for each in self.heard}
        return {topic: payload for topic, payload in last.items() if payload not in ("", None)}

    async def hears(self, topic: str, within: float = 10.0, **fields: Any) -> Any:
        """The first document at a topic with these fields; waits for it."""

        def found() -> list[Any]:
            return [each for each in self.said(topic) if not fields or _has(each, fields)]

        await until(found, f"{fields or 'anything'} at {topic}", within)
        return found()[0]

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()


def _has(document: Any, fields: dict[str, Any]) -> bool:
    return isinstance(document, dict) and all(document.get(name) == value for name, value in fields.items())


def _understood(payload: Any) -> Any:
    """What mosquitto_sub shows: JSON as it is in some versions, as text in others."""
    try:
        return json.loads(payload) if isinstance(payload, str) else payload
    except json.JSONDecodeError:
        return payload
