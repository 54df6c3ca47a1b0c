"""A real signalk-server, on this computer alone: its providers, what it knows, and its end."""

import asyncio
import base64
import hmac
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import urllib.error
import urllib.request
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import pytest

from tests.program import die_with_parent, until

HERE = "127.0.0.1"
SECRET = "a secret of this server, for as long as a test takes"
NODE = Path(__file__).parent / "node"
SERVER = NODE / "node_modules" / "signalk-server" / "bin" / "signalk-server"
OFF = ("nmea-tcp", "tcp", "appstore", "mfd_webapp", "playground", "wasm")
"""Parts of the server that would listen on all networks, or look for something outside."""
TAKE_OVER = "import os, sys; os.dup2(int(sys.argv[1]), 3); os.execvp(sys.argv[2], sys.argv[2:])"
"""The server listens on all networks, unless systemd gives it a socket: that is descriptor 3 (sd_listen_fds(3))."""


def provider(kind: str, name: str, **options: Any) -> dict[str, Any]:
    """A data connection, as the server's settings have it."""
    simple = {"type": kind, "logging": False, "subOptions": {"host": HERE, **options}}
    return {"id": name, "enabled": True, "pipeElements": [{"type": "providers/simple", "options": simple}]}


def token(device: str) -> str:
    """What the administrator of a server with `SECRET` gives a device (RFC 7519, HS256)."""
    signed = ".".join(_text(json.dumps(part).encode()) for part in ({"alg": "HS256", "typ": "JWT"}, {"device": device}))
    return f"{signed}.{_text(hmac.digest(SECRET.encode(), signed.encode(), 'sha256'))}"


def _text(data: bytes) -> str:
    return base64.urlsafe_b64encode(data).decode().rstrip("=")


class SignalKServer:
    """While it is entered, a server with these providers runs on `port`.

    With `devices` its security is on, and who may write are these.
    """

    def __init__(self, directory: Path, *providers: Mapping[str, Any], devices: Sequence[str] = ()) -> None:
        self._directory = directory
        self._socket = socket.create_server((HERE, 0))
        self.port = int(self._socket.getsockname()[1])
        settings: dict[str, Any] = {
            "mdns": False,
            "interfaces": dict.fromkeys(OFF, False),
            "pipedProviders": providers,
        }
        if devices:
            settings["security"] = {"strategy": "./tokensecurity"}
            known = [{"clientId": device, "permissions": "readwrite"} for device in devices]
            admin = {"username": "admin", "type": "admin", "password": ""}
            secure = {"allow_readonly": True, "secretKey": SECRET, "users": [admin], "devices": known}
            (directory / "security.json").write_text(json.dumps(secure))
            (directory / "security.json").chmod(0o600)
        (directory / "settings.json").write_text(json.dumps(settings))
        self.log = directory / "signalk-server.log"

    async def __aenter__(self) -> Self:
        node = shutil.which("node")
        if node is None or not SERVER.exists():
            pytest.fail(f"signalk-server is missing: npm ci --prefix {NODE}")
        environment = {
            "PATH": os.environ["PATH"],
            "HOME": str(self._directory),
            "SIGNALK_NODE_CONFIG_DIR": str(self._directory),
            "SIGNALK_DISABLE_SERVER_UPDATES": "1",
            "LISTEN_FDS": "1",
        }
        number = self._socket.fileno()
        with self.log.open("wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-c", TAKE_OVER, str(number), node, str(SERVER)],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
                env=environment,
                pass_fds=(number,),
                preexec_fn=die_with_parent,
            )
        self._socket.close()
        await until(lambda: self._process.poll() is not None or self._runs(), "signalk-server runs", 60.0)
        assert self._process.poll() is None, self.log.read_text()
        return self

    def _runs(self) -> bool:
        return "running at" in self.log.read_text()

    async def __aexit__(
        self, kind: type[BaseException] | None, fault: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._process.send_signal(signal.SIGKILL)
        self._process.wait()

    @property
    def stream(self) -> str:
        """Where its deltas are."""
        return f"ws://{HERE}:{self.port}/signalk/v1/stream"

    async def get(self, path: str) -> Any:
        """What its REST interface says; None where there is no such thing."""
        return await asyncio.to_thread(self._get, f"http://{HERE}:{self.port}/signalk/v1/api/{path}")

    @staticmethod
    def _get(url: str) -> Any:
        try:
            with urllib.request.urlopen(url, timeout=10) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as fault:
            if fault.code == 404:
                return None
            raise

    async def own(self, path: str) -> Any:
        """A path of its own vessel."""
        return await self.get(f"vessels/self/{path.replace('.', '/')}")

    async def values(self, path: str) -> dict[str, Any]:
        """What each source says of a path of its own vessel, by source."""
        leaf = await self.own(path)
        if leaf is None:
            return {}
        told = leaf.get("values") or {leaf["$source"]: leaf}
        return {source: each["value"] for source, each in told.items()}
