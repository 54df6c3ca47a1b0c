"""Signal K's discovery and its tree."""

import asyncio
from typing import Any

import pytest

from tests.unit.web.scene import OPEN_TO_ALL, TOKEN, Scene, heading, scene
from tests.unit.web.test_routes import AT, knock_at_socket
from timonel.gateway.web_settings import Web
from timonel.web.routes import STREAM

API = "/signalk/v1/api"


async def shown(here: Scene, path: str) -> Any:
    answer = await here.get(f"{API}/{path}")
    assert answer.status == 200, answer.body
    return answer.json


@pytest.mark.parametrize("path", ["/signalk", "/signalk/"])
def test_discovery_names_the_endpoints_by_the_name_we_are_called_by(path: str) -> None:
    async def play() -> None:
        async with scene() as here:
            found = (await here.get(path)).json
            assert found["server"]["id"] == "timonel"
            assert found["endpoints"]["v1"] == {
                "version": "1.7.0",
                "signalk-http": "http://127.0.0.1:8080/signalk/v1/api/",
                "signalk-ws": "ws://127.0.0.1:8080/signalk/v1/stream",
            }

    asyncio.run(play())


def test_discovery_names_those_with_tls_where_there_is_a_certificate() -> None:
    async def play() -> None:
        async with scene(web=Web(certificate="a.pem", key="a.key")) as here:
            found = (await here.get("/signalk")).json["endpoints"]["v1"]
            assert found["signalk-http"].startswith("https://")
            assert found["signalk-ws"].startswith("wss://")

    asyncio.run(play())


def test_the_tree_is_shown_whole_and_in_parts() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            context = await shown(here, "self")
            whole = await shown(here, "")
            assert whole["self"] == context
            own = whole["vessels"][context.removeprefix("vessels.")]
            assert await shown(here, "vessels/self") == own
            assert await shown(here, context.replace(".", "/", 1)) == own
            leaf = await shown(here, "vessels/self/navigation/headingTrue/")
            assert leaf["value"] == pytest.approx(1.5708, abs=1e-4)
            assert leaf["$source"] == "timonel.10"
            assert await shown(here, "vessels/self/navigation/headingTrue/value") == leaf["value"]
            assert await shown(here, "vessels/self/steering/command/value") is None

    asyncio.run(play())


@pytest.mark.parametrize(
    "path",
    [
        "vessels/x",
        "vessels/self/navigation/headingTrue/value/x",
        "vessels/self/x",
        "..",
        "{path}",
        "vessels/self/name/0",
    ],
)
def test_what_is_not_known_is_not_found(path: str) -> None:
    async def play() -> None:
        async with scene() as here:
            answer = await here.get(f"{API}/{path}")
            assert answer.status == 404
            assert answer.json == {"state": "FAILED", "statusCode": 404, "message": "nothing is known there"}

    asyncio.run(play())


def test_what_is_no_route_of_signal_k_is_not_a_page() -> None:
    async def play() -> None:
        async with scene() as here:
            for path in ("/signalk/v1", "/signalk/v3/api", "/signalk/v1/stream/x"):
                assert (await here.get(path)).status == 404
            assert (await here.get(STREAM)).status == 405

    asyncio.run(play())


def test_a_refusal_is_said_as_signal_k_says_it() -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            refused = await here.get(f"{API}/self", **AT)
            assert refused.json == {"state": "FAILED", "statusCode": 401, "message": "sign in first"}
            for _ in range(6):
                refused = await here.get(f"{API}/self", authorization="Bearer wrong", **AT)
            assert refused.json["statusCode"] == refused.status == 429
            right = await here.get(
                f"{API}/self", host="boat.local", authorization=f"Bearer {TOKEN}", address="192.168.1.8"
            )
            assert right.status == 200

    asyncio.run(play())


def test_a_rover_has_no_signal_k() -> None:
    async def play() -> None:
        async with scene("rover") as here:
            for path in ("/signalk", f"{API}/self", "/signalk/v2/api/vessels/self/autopilots/_default"):
                assert (await here.get(path)).status == 404
            assert await knock_at_socket(here, {}, STREAM) == 404

    asyncio.run(play())
