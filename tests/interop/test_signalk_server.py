"""A real signalk-server reads the demo over NMEA 0183, over YD RAW, and over Signal K in two ways."""

import asyncio
import json
from collections import defaultdict
from contextlib import suppress
from math import radians, tau
from pathlib import Path
from typing import Any

import pytest
from websockets.asyncio.client import connect

from tests.interop.signalk_server import NODE, SignalKServer, provider, token
from tests.program import Bench, Program, free_port, rudder, until
from timonel.interop.signalk.paths import PATHS

pytestmark = pytest.mark.timeout(150)

KNOT = 1852 / 3600
TENTH = radians(0.05) + 1e-9  # a tenth of a degree, rounded
MINUTE = 1e-4 / 60  # the fourth digit of a minute, in degrees
WITHIN = {
    "navigation.headingTrue": TENTH,
    "environment.depth.belowTransducer": 0.051,
    "environment.wind.angleApparent": TENTH,
    "environment.wind.speedApparent": 0.051 * KNOT + 0.005,
    "navigation.speedOverGround": 0.051 * KNOT + 0.005,
    "navigation.courseOverGroundTrue": TENTH,
    "navigation.rateOfTurn": radians(0.06) / 60,
    "environment.water.temperature": 0.051,
    "steering.rudderAngle": TENTH,
    "latitude": MINUTE,
    "longitude": MINUTE,
}
"""How much the last digit of a sentence may hide."""
WATCHED = 8.0  # s
BEFORE = 2.5  # s of these that only the reference is watched: what the others tell first is older
REFERENCE, OTHERS = "ydraw", ("0183", "tcp", "ws")
"""Frames bring every value; sentences come at most as often as their rates, and our deltas ten times a second."""
EXACT = 1e-6

Heard = dict[str, dict[str, set[float]]]
"""All values that a path had, by the way that they came."""


async def listen(directory: Path) -> Heard:
    port, web = free_port(), free_port()
    async with Program(
        directory, "demo", "--no-view", "--no-recording", "--port", str(port), "--web-port", str(web),
        "--directory", str(directory),
    ) as demo:  # fmt: skip
        await demo.running()
        providers = (
            provider("NMEA0183", "0183", type="tcp", port=port),
            provider("NMEA2000", "ydraw", type="ydwg02-canboatjs", port=port + 1),
            provider("SignalK", "tcp", type="tcp", port=port + 2),
            provider("SignalK", "ws", type="ws", port=web, selfHandling="useRemoteSelf"),
        )
        async with SignalKServer(directory, *providers) as server:
            await all_ways(server)
            return await watch(server)


async def all_ways(server: SignalKServer) -> None:
    """Wait until its REST interface shows everything from everywhere."""
    for path in ("navigation.position", *(path for path in WITHIN if "." in path)):
        for _ in range(100):
            found = {way(source) for source in await server.values(path)}
            if found == {REFERENCE, *OTHERS}:
                break
            await asyncio.sleep(0.1)
        else:
            pytest.fail(f"{path}: only {found}")


def way(source: str) -> str:
    """How a value came, by its source; over TCP the sources are those that we name."""
    return source.partition(".")[0].replace("timonel", "tcp")


async def watch(server: SignalKServer) -> Heard:
    """All that its stream tells for a while."""
    heard: Heard = defaultdict(lambda: defaultdict(set))
    async with connect(f"{server.stream}?subscribe=self") as stream:
        with suppress(TimeoutError):
            async with asyncio.timeout(WATCHED):
                began = asyncio.get_running_loop().time()
                async for message in stream:
                    ways = {REFERENCE, *OTHERS} if asyncio.get_running_loop().time() > began + BEFORE else {REFERENCE}
                    take(heard, json.loads(message), ways)
    return heard


def take(heard: Heard, delta: dict[str, Any], ways: set[str]) -> None:
    for update in delta.get("updates", ()):
        if way(update["$source"]) not in ways:
            continue
        for told in update.get("values", ()):
            path, value = told["path"], told["value"]
            values = value if path == "navigation.position" else {path: value}
            for name in values.keys() & WITHIN.keys():
                if values[name] is not None:
                    heard[name][way(update["$source"])].add(values[name])


@pytest.fixture(scope="module")
def heard(tmp_path_factory: pytest.TempPathFactory) -> Heard:
    return asyncio.run(listen(tmp_path_factory.mktemp("signalk")))


def apart(value: float, others: set[float]) -> float:
    """How far it is to the nearest of the others, the short way round."""
    return min(min(abs(value - other), abs(abs(value - other) - tau)) for other in others)


@pytest.mark.parametrize("path", WITHIN)
@pytest.mark.parametrize("kind", OTHERS)
def test_signalk_server_shows_the_same_on_every_way(heard: Heard, path: str, kind: str) -> None:
    told = heard[path]
    assert told[kind]
    within = WITHIN[path] if kind == "0183" else EXACT
    wrong = {value: apart(value, told[REFERENCE]) for value in told[kind]}
    assert max(wrong.values()) < within, (wrong, sorted(told[REFERENCE]))


def test_a_signalk_server_is_told_over_its_own_stream_and_told_what_is_no_more(tmp_path: Path) -> None:
    async def play() -> None:
        async with SignalKServer(tmp_path) as server:
            pushed = f'[signalk]\npush = "ws://127.0.0.1:{server.port}"'
            async with Bench(tmp_path, more=pushed) as bench:
                await shown(server, "navigation.headingTrue", pytest.approx(radians(182.5), abs=1e-4))
                assert (await server.own("navigation.headingTrue"))["$source"] == "timonel.10"
                bench.bus.frames = [rudder(5.0)]
                await shown(server, "steering.rudderAngle", pytest.approx(radians(5.0), abs=1e-4))
                await shown(server, "navigation.headingTrue", None)

    asyncio.run(play())


def test_a_server_with_security_on_is_told_by_who_has_its_token(tmp_path: Path) -> None:
    async def play() -> None:
        async with SignalKServer(tmp_path, devices=["timonel"]) as server:
            pushed = f'[signalk]\npush = "ws://127.0.0.1:{server.port}"\ntoken = "{token("timonel")}"'
            async with Bench(tmp_path, more=pushed) as bench:
                await shown(server, "navigation.headingTrue", pytest.approx(radians(182.5), abs=1e-4))
                assert token("timonel") not in bench.program.log_path.read_text()
            wrong = pushed.replace(token("timonel"), token("somebody else"))
            (tmp_path / "other").mkdir()
            async with Bench(tmp_path / "other", more=wrong) as bench:
                refused = "server rejected WebSocket connection: HTTP 401"
                await until(lambda: refused in bench.program.log_path.read_text(), refused)

    asyncio.run(play())


async def shown(server: SignalKServer, path: str, value: object) -> None:
    """Wait until it shows this value."""
    told = {}
    for _ in range(100):
        told = await server.own(path) or {}
        if "value" in told and told["value"] == value:
            return
        await asyncio.sleep(0.1)
    pytest.fail(f"{path}: {told}")


# The schema -------------------------------------------------------------------------------------------------

OURS = {"steering.command", "steering.autopilot.engaged"}


def test_every_path_is_one_of_the_schema_with_its_unit() -> None:
    """Of `nextPoint` the schema's list has only the whole."""
    keys = json.loads((NODE / "node_modules/@signalk/signalk-schema/dist/keyswithmetadata.json").read_text())
    for path, ours in PATHS.items():
        above, within, _ = path.partition(".nextPoint")
        if path not in OURS:
            theirs = keys[f"/vessels/*/{(above + within).replace('.', '/')}"]
            assert within or theirs.get("units") in (ours.units, None), path
