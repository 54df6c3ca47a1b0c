"""Signal K's autopilot API, by HTTP to the demo, whose pilot answers as a real one does."""

import asyncio
import json
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from math import degrees
from pathlib import Path
from typing import Any

import pytest

from tests.program import Program, free_port

pytestmark = pytest.mark.timeout(60)


class Panel:
    """An autopilot panel that is station 2."""

    def __init__(self, port: int) -> None:
        self._base = f"http://127.0.0.1:{port}/signalk/v2/api/vessels/self/autopilots/_default"

    async def ask(self, method: str, what: str, body: Any = None, station: int = 2) -> tuple[int, Any]:
        """The status and what is said."""
        url = f"{self._base}/{what}?station={station}"
        data = None if body is None else json.dumps(body).encode()
        headers = {"Content-Type": "application/json"}
        return await asyncio.to_thread(self._ask, urllib.request.Request(url, data, headers, method=method))

    @staticmethod
    def _ask(request: urllib.request.Request) -> tuple[int, Any]:
        try:
            with urllib.request.urlopen(request, timeout=10) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as fault:
            with fault:
                return fault.code, json.load(fault)

    async def target(self) -> float:
        _, told = await self.ask("GET", "target")
        return round(degrees(told["value"]), 1)


@contextmanager
def demo(directory: Path) -> Iterator[tuple[Program, int]]:
    port, web = free_port(), free_port()
    program = Program(
        directory, "demo", "--no-view", "--no-recording", "--port", str(port), "--web-port", str(web),
        "--directory", str(directory),
    )  # fmt: skip
    program.start()
    try:
        yield program, web
    finally:
        program.kill()


def test_a_panel_engages_turns_and_lets_go_and_another_one_may_not(tmp_path: Path) -> None:
    async def play() -> None:
        with demo(tmp_path) as (program, web):
            await program.running()
            panel = Panel(web)
            for _ in range(50):  # until there is a heading
                status, told = await panel.ask("POST", "engage")
                if status == 200:
                    break
                assert told["message"] in ("no heading", "alarm"), told
                await asyncio.sleep(0.2)
            assert await panel.ask("GET", "state") == (200, {"value": "auto"})
            held = await panel.target()
            assert (await panel.ask("PUT", "target/adjust", {"value": 10, "units": "deg"}))[0] == 200
            assert await panel.target() == pytest.approx((held + 10) % 360, abs=0.05)
            status, told = await panel.ask("POST", "disengage", station=3)
            assert (status, told["message"]) == (403, "not in command")
            assert (await panel.ask("POST", "tack/port"))[0] == 501
            assert (await panel.ask("POST", "disengage"))[0] == 200
            assert await panel.ask("GET", "state") == (200, {"value": "standby"})

    asyncio.run(play())
