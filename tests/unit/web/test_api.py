"""The HTTP interface is as it describes itself."""

import asyncio
import json
import threading
from collections.abc import Iterator

import pytest
import schemathesis
from hypothesis import HealthCheck, settings
from schemathesis.checks import not_a_server_error
from schemathesis.specs.openapi.checks import (
    content_type_conformance,
    response_schema_conformance,
    status_code_conformance,
)

from tests.unit.web.scene import configuration, request, scene
from timonel.gateway.assemble import assemble
from timonel.gateway.web_settings import Web
from timonel.web import openapi
from timonel.web.routes import FILES, OPENAPI, ROUTES
from timonel.web.server import served

EXAMPLES = 20  # of each route
CHECKS = [not_a_server_error, status_code_conformance, content_type_conformance, response_schema_conformance]

schema = schemathesis.openapi.from_dict(json.loads(openapi.document()))


@pytest.fixture(scope="module")
def url() -> Iterator[str]:
    """A gateway in a thread of its own."""
    found: list[str] = []
    ready, end = threading.Event(), threading.Event()

    async def serve() -> None:
        made_of = configuration("boat", Web(port=0))
        gateway = assemble(made_of)
        await gateway.open()
        async with served(gateway, made_of) as address:
            found.append(address or "")
            ready.set()
            await asyncio.to_thread(end.wait)
        await gateway.close(0.0)

    thread = threading.Thread(target=asyncio.run, args=(serve(),))
    thread.start()
    ready.wait(10.0)
    yield found[0]
    end.set()
    thread.join()


@schema.parametrize()
@settings(max_examples=EXAMPLES, suppress_health_check=list(HealthCheck), deadline=None)
def test_every_answer_is_as_described(url: str, case: schemathesis.Case) -> None:
    case.call_and_validate(base_url=url, checks=CHECKS)


def test_every_route_is_described() -> None:
    async def play() -> None:
        async with scene() as here:
            described = (await request(here.app, "GET", OPENAPI)).json
            paths = {(method.upper(), path) for path, methods in described["paths"].items() for method in methods}
            ours = {(route.method, route.path) for route in ROUTES if route.described}
            assert paths == ours
            assert FILES not in described["paths"]
            orders = described["components"]["schemas"]["CommandRequest"]["properties"]["order"]["anyOf"]
            assert len(orders) == 5

    asyncio.run(play())
