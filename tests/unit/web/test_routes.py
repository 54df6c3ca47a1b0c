"""Every route with every role, and what every answer has."""

import asyncio
import gzip
import json
import time
from typing import Any

import pytest

from tests.unit.web.scene import HERE, KEY, OPEN_TO_ALL, TOKEN, Answered, Scene, heading, request, scene
from timonel.gateway.web_settings import Web
from timonel.web.access import Access, Least, Rights
from timonel.web.app import SECURITY, find
from timonel.web.pairing import GUESSES
from timonel.web.routes import FILES, ROUTES, SOCKET, STREAM, Route

AT = {"host": "boat.local:8080", "address": "192.168.1.7"}
BODIES: dict[str, Any] = {
    "/api/v1/login": {"token": TOKEN},
    "/api/v1/pairings": {"station": 4},
    "/api/v1/pairings/code": {"pairing": 1, "code": "000000"},
    "/api/v1/commands": {"order": {"type": "command", "id": 1, "verb": "REQCMD"}, "station": 2},
}
PILOT = "/signalk/v2/api/vessels/self/autopilots/_default"
SIGNALK_BODIES = {
    f"{PILOT}/state": {"value": "auto"},
    f"{PILOT}/target": {"value": 1.5},
    f"{PILOT}/target/adjust": {"value": 10, "units": "deg"},
}
FINE = {
    "/api/v1/pairings": 202,
    "/api/v1/logout": 204,
    "/tiles/vessels/self/name": 204,
    "/api/v1/pairings/code": 403,
    ("POST", f"{PILOT}/engage"): 400,  # there is no heading
    ("PUT", f"{PILOT}/state"): 400,
    ("PUT", f"{PILOT}/target"): 400,  # it is not engaged
    ("PUT", f"{PILOT}/target/adjust"): 400,
    ("POST", f"{PILOT}/disengage"): 504,  # there is no pilot to confirm it
    **{
        (method, f"{PILOT}/{what}"): 501
        for method, what in (
            ("PUT", "mode"), ("POST", "tack/port"), ("POST", "tack/starboard"), ("POST", "gybe/port"),
            ("POST", "gybe/starboard"), ("POST", "dodge"), ("PUT", "dodge"), ("DELETE", "dodge"),
            ("POST", "courseCurrentPoint"), ("POST", "courseNextPoint"),
        )
    },
}  # fmt: skip
"""Statuses of those that may, where it is not 200."""
ROLES = list(Least)


def who(least: Least) -> tuple[Web, dict[str, str]]:
    """A gateway and headers by which somebody has a role there."""
    if least is Least.ADMIN:
        return HERE, {}
    headers = {
        Least.NOBODY: {},
        Least.READER: {"authorization": f"Bearer {TOKEN}"},
        Least.STATION: {"cookie": access().seal([2]).partition(";")[0]},
    }[least]
    return OPEN_TO_ALL, AT | headers


def access() -> Access:
    return Access(OPEN_TO_ALL, KEY, lambda: 0.0, time.time)


def path_of(route: Route) -> str:
    """One that it fits."""
    return route.path.replace(FILES, "/").replace("{id}", "_default").replace("{path}", "vessels/self/name")


def body_for(path: str, method: str) -> Any:
    return BODIES.get(path) if method == "POST" else SIGNALK_BODIES.get(path)


def fine(route: Route) -> int:
    path = path_of(route)
    return 101 if route.method == "SOCKET" else FINE.get((route.method, path), FINE.get(path, 200))


async def knock(here: Scene, route: Route, headers: dict[str, str]) -> int:
    path = path_of(route)
    if route.method == "SOCKET":
        return await knock_at_socket(here, headers, path)
    if path == f"{PILOT}/disengage":
        await here.hear(heading(90.0))  # a bus that is silent is no bus to confirm anything
    which = "?station=2" if path.startswith(PILOT) else ""
    answer = await request(here.app, route.method, path + which, body_for(path, route.method), **headers)
    return answer.status


async def knock_at_socket(here: Scene, headers: dict[str, str], path: str = SOCKET) -> int:
    """101 if it is let in."""
    said: list[Any] = []
    given = {"host": "127.0.0.1:8080"} | headers
    address = given.pop("address", "127.0.0.1")

    async def receive() -> dict[str, Any]:
        return {"type": "websocket.connect"} if not said else {"type": "websocket.disconnect", "code": 1001}

    async def send(message: Any) -> None:
        said.append(message)

    class Line:
        def write(self, frame: bytes) -> bool:
            return True

        def abort(self) -> None:
            raise AssertionError

    scope = {
        "type": "websocket",
        "path": path,
        "query_string": b"",
        "headers": [(name.encode(), value.encode()) for name, value in given.items()],
        "client": (address, 40000),
        "server": ("127.0.0.1", 8080),
        "extensions": {"timonel.line": Line(), "websocket.http.response": {}},
    }
    await here.app(scope, receive, send)
    return 101 if said[0]["type"] == "websocket.accept" else int(said[0]["status"])


@pytest.mark.parametrize("least", ROLES, ids=lambda least: least.name)
@pytest.mark.parametrize("route", ROUTES, ids=lambda route: f"{route.method} {route.path}")
def test_each_route_is_for_those_that_the_table_says(route: Route, least: Least) -> None:
    async def play() -> None:
        web, headers = who(least)
        async with scene(web=web) as here:
            status = await knock(here, route, headers)
            if least is Least.ADMIN and route.path == "/api/v1/pairings":
                assert status == 409
            elif least >= route.least:
                assert status == fine(route)
            else:
                assert status == (401 if least is Least.NOBODY else 403)

    asyncio.run(play())


@pytest.mark.parametrize(
    "path", ["/api", "/api/", "/api/v1/", "/api/v2/state", "/api/v1/state/", "/x", "/static/app.js"]
)
def test_what_is_not_in_the_table_is_not_found(path: str) -> None:
    async def play() -> None:
        async with scene() as here:
            answer = await here.get(path)
            assert answer.status == 404
            assert answer.json == {"error": "there is no such page"}

    asyncio.run(play())


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "TRACE", "X"])
def test_a_method_that_a_path_does_not_have_is_refused(method: str) -> None:
    async def play() -> None:
        async with scene() as here:
            answer = await request(here.app, method, "/api/v1/state")
            assert (answer.status, answer.headers["allow"]) == (405, "GET")
            assert (await request(here.app, method, SOCKET)).status == 405

    asyncio.run(play())


def test_the_first_lines_alone_can_be_asked_for() -> None:
    async def play() -> None:
        async with scene() as here:
            whole, head = await here.get("/api/v1/about"), await request(here.app, "HEAD", "/api/v1/about")
            assert head.body == b""
            assert head.headers["content-length"] == str(len(whole.body))

    asyncio.run(play())


def test_all_paths_are_different() -> None:
    assert len({(route.method, route.path) for route in ROUTES}) == len(ROUTES)
    assert find("GET", "/app.js")[0].path == FILES


# Where from -------------------------------------------------------------------------------------------------


def test_a_host_that_is_not_ours_is_refused_before_anything_else() -> None:
    async def play() -> None:
        async with scene() as here:
            for path in ("/", "/api/v1/about", "/api/v1/state", "/nothing"):
                answer = await here.get(path, host="evil.example:8080")
                assert answer.status == 421
                assert "add it to hosts in [web]" in answer.json["error"]
            assert await knock_at_socket(here, {"host": "evil.example:8080"}) == 421

    asyncio.run(play())


def test_a_page_of_another_site_changes_nothing_and_opens_no_socket() -> None:
    async def play() -> None:
        async with scene() as here:
            for headers in ({"origin": "http://evil.example"}, {"sec-fetch-site": "cross-site"}, {"origin": "null"}):
                for route in ROUTES:
                    if route.changes:
                        assert await knock(here, route, headers) == 403, route
                for path in (SOCKET, STREAM):
                    assert await knock_at_socket(here, headers, path) == 403
            assert here.gateway.vehicle.helm.transfer.commander == 0  # type: ignore[attr-defined]
            assert await knock_at_socket(here, {"origin": "http://127.0.0.1:8080"}) == 101

    asyncio.run(play())


def test_a_form_cannot_say_anything() -> None:
    async def play() -> None:
        async with scene() as here:
            for kind in ("application/x-www-form-urlencoded", "text/plain", "multipart/form-data", ""):
                answer = await here.post("/api/v1/commands", BODIES["/api/v1/commands"], content_type=kind)
                assert answer.status == 415
            assert (await here.post("/api/v1/commands", BODIES["/api/v1/commands"],
                                    content_type="Application/JSON; charset=utf-8")).status == 200  # fmt: skip

    asyncio.run(play())


def test_what_is_too_long_or_not_understood_is_refused() -> None:
    async def play() -> None:
        async with scene() as here:
            assert (await here.post("/api/v1/commands", b" " * 20_000)).status == 413
            for body in (b"", b"{", b"\xff\xfe", b'{"order": {}}', b'{"a":' + b"[" * 5000 + b"]" * 5000 + b"}"):
                answer = await here.post("/api/v1/commands", body)
                assert answer.status == 400
                assert answer.json["error"]

    asyncio.run(play())


def test_a_query_with_too_many_fields_is_refused() -> None:
    async def play() -> None:
        async with scene() as here:
            for count, status in ((20, 200), (21, 400)):
                assert (await here.get("/api/v1/you?" + "&".join(["a=1"] * count))).status == status

    asyncio.run(play())


# Signing in and pairing -------------------------------------------------------------------------------------


def test_who_signs_in_has_a_cookie_and_sees() -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            assert (await here.get("/api/v1/about", **AT)).json["token_needed"] is True
            wrong = await here.post("/api/v1/login", {"token": "wrong"}, **AT)
            assert (wrong.status, wrong.json) == (403, {"error": "wrong token"})
            assert "set-cookie" not in wrong.headers
            right = await here.post("/api/v1/login", {"token": TOKEN}, **AT)
            assert right.json == {"role": "reader", "station": None, "may_choose": []}
            you = await here.get("/api/v1/you", cookie=right.cookie, **AT)
            assert you.json == right.json
            out = await here.post("/api/v1/logout", cookie=right.cookie, **AT)
            assert (out.status, out.body, out.cookie) == (204, b"", "timonel=")

    asyncio.run(play())


def test_guesses_are_counted_together_however_they_come() -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            for _ in range(2):
                assert (await here.post("/api/v1/login", {"token": "wrong"}, **AT)).status == 403
            assert (await here.get("/api/v1/state", authorization="Bearer wrong", **AT)).status == 401
            for _ in range(2):
                assert await knock_at_socket(here, AT | {"authorization": "Bearer wrong"}) == 401
            refused = await here.post("/api/v1/login", {"token": TOKEN}, **AT)
            assert refused.status == 429
            assert 0 < int(refused.headers["retry-after"]) <= 61
            assert await knock_at_socket(here, AT | {"authorization": f"Bearer {TOKEN}"}) == 429
            assert (await here.get("/", **AT)).status == 200, "the pages stay"

    asyncio.run(play())


async def paired(here: Scene, station: int, **headers: str) -> Answered:
    asked = await here.post("/api/v1/pairings", {"station": station, "name": "tablet\n\x1b[31m"}, **headers)
    assert asked.status == 202
    (waiting,) = here.console.pairings.waiting(here.gateway.now)
    assert asked.json["pairing"] == waiting.number
    assert asked.json["deadline"] == pytest.approx(asked.json["clock"] + 120, abs=0.01)
    assert waiting.code.encode() not in asked.body
    assert waiting.name == "tablet??[31m", "nothing that a terminal would obey"
    told = {"pairing": waiting.number, "code": waiting.code}
    return await here.post("/api/v1/pairings/code", told, **headers)


def test_who_tells_the_digits_has_the_cookie_of_a_station(caplog: pytest.LogCaptureFixture) -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            reader = (await here.post("/api/v1/login", {"token": TOKEN}, **AT)).cookie
            answer = await paired(here, 2, cookie=reader, **AT)
            assert answer.json == {"role": "station", "station": 2, "may_choose": [2]}
            again = await paired(here, 4, cookie=answer.cookie, **AT)
            assert again.json == {"role": "station", "station": None, "may_choose": [2, 4]}
            assert (await here.get("/api/v1/you", cookie=again.cookie, **AT)).json == again.json
            twice = await here.post("/api/v1/pairings", {"station": 2}, cookie=again.cookie, **AT)
            assert twice.status == 409

    asyncio.run(play())
    assert "asks to be Station 2: the digits are" in caplog.text


def test_wrong_digits_are_refused_and_count_as_guesses() -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            reader = (await here.post("/api/v1/login", {"token": TOKEN}, **AT)).cookie
            asked = (await here.post("/api/v1/pairings", {"station": 2}, cookie=reader, **AT)).json["pairing"]
            (waiting,) = here.console.pairings.waiting(here.gateway.now)
            wrong = {"pairing": asked, "code": f"{(int(waiting.code) + 1) % 10**6:06d}"}
            for _ in range(GUESSES):
                assert (await here.post("/api/v1/pairings/code", wrong, cookie=reader, **AT)).status == 403
            right = {"pairing": asked, "code": waiting.code}
            assert (await here.post("/api/v1/pairings/code", right, cookie=reader, **AT)).status == 403, "it is over"
            await here.post("/api/v1/pairings/code", wrong, cookie=reader, **AT)
            assert (await here.post("/api/v1/pairings/code", right, cookie=reader, **AT)).status == 429

    asyncio.run(play())


def test_nobody_floods_the_helm_with_pairings() -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            headers = AT | {"authorization": f"Bearer {TOKEN}"}
            statuses = [(await here.post("/api/v1/pairings", {"station": 2}, **headers)).status for _ in range(12)]
            assert statuses == [202] * 10 + [429] * 2

    asyncio.run(play())


def test_a_station_that_no_console_may_be_is_not_paired() -> None:
    async def play() -> None:
        async with scene(web=Web("0.0.0.0", 8080, TOKEN, hosts=("boat.local",), stations=(3,))) as here:
            headers = AT | {"authorization": f"Bearer {TOKEN}"}
            assert (await here.post("/api/v1/pairings", {"station": 2}, **headers)).status == 404

    asyncio.run(play())


def test_where_no_token_is_needed_any_token_is_right() -> None:
    async def play() -> None:
        async with scene() as here:
            answer = await here.post("/api/v1/login", {"token": "anything"})
            assert answer.json == {"role": "admin", "station": None, "may_choose": [1, 2, 3, 4]}

    asyncio.run(play())


# What is shown and said -------------------------------------------------------------------------------------


def test_the_state_is_that_of_the_socket() -> None:
    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            state = (await here.get("/api/v1/state")).json
            assert state["type"] == "snapshot"
            assert state["topics"]["heading"]["value"] == pytest.approx(1.5708, abs=1e-4)
            assert (await here.get("/api/v1/stations")).json == state["topics"]["command"]
            assert (await here.get("/api/v1/alerts")).json == state["topics"]["alerts"]

    asyncio.run(play())


def test_the_history_is_what_was_asked_for() -> None:
    async def play() -> None:
        async with scene() as here:
            for second in range(10):
                here.console.history.take({"depth": float(second)}, 100.0 + second)
            answer = await here.get("/api/v1/history?series=depth,sog&seconds=5&step=2")
            assert answer.json["series"] == {"depth": [5.0, 7.0, 9.0], "sog": [None, None, None]}
            assert (answer.json["ended"], answer.json["step"]) == (109.0, 2.0)
            assert (await here.get("/api/v1/history")).json["series"].keys() == set(here.console.history.names)
            for query in ("series=x", "seconds=0", "seconds=3601", "seconds=x", "step=-1", "seconds=%B2", "step=1e3"):
                assert (await here.get(f"/api/v1/history?{query}")).status == 400, query

    asyncio.run(play())


def test_an_order_over_http_takes_the_way_of_the_socket() -> None:
    async def play() -> None:
        async with scene() as here:

            async def order(verb: str, station: int | None) -> Answered:
                said = {"order": {"type": "command", "id": 7, "verb": verb}}
                return await here.post("/api/v1/commands", said if station is None else said | {"station": station})

            assert (await order("REQCMD", 2)).json == {"type": "answer", "id": 7, "outcome": "confirmed", "reason": ""}
            waits = (await order("REQCMD", 3)).json
            assert (waits["outcome"], waits["reason"]) == ("sent", "the commander is asked")
            refused = (await order("ENGAGE", 3)).json
            assert (refused["outcome"], refused["reason"]) == ("refused", "not in command")
            assert (await order("TAKECMD", None)).status == 400, "an admin may be several"

    asyncio.run(play())


def test_a_station_commands_over_http_as_itself_alone() -> None:
    async def play() -> None:
        async with scene(web=OPEN_TO_ALL) as here:
            headers = who(Least.STATION)[1]
            said = {"order": {"type": "command", "id": 7, "verb": "REQCMD"}}
            assert (await here.post("/api/v1/commands", said | {"station": 1}, **headers)).status == 403
            assert (await here.post("/api/v1/commands", said, **headers)).json["outcome"] == "confirmed"
            assert here.gateway.vehicle.helm.transfer.commander == 2  # type: ignore[attr-defined]

    asyncio.run(play())


def test_a_course_over_http_ends_as_unconfirmed_where_no_pilot_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("timonel.web.outcome.WITHIN", 0.05)

    async def play() -> None:
        async with scene() as here:
            await here.hear(heading(90.0))
            for verb, outcome in (("TAKECMD", "confirmed"), ("ENGAGE", "unconfirmed")):
                said = {"order": {"type": "command", "id": 7, "verb": verb}, "station": 1}
                assert (await here.post("/api/v1/commands", said)).json["outcome"] == outcome

    asyncio.run(play())


# Answers ----------------------------------------------------------------------------------------------------


def test_a_page_is_packed_and_not_sent_twice() -> None:
    async def play() -> None:
        async with scene() as here:
            plain = await here.get("/")
            packed = await here.get("/", accept_encoding="br, gzip;q=0.9")
            assert packed.headers["content-encoding"] == "gzip"
            assert gzip.decompress(packed.body) == plain.body
            assert plain.headers["vary"] == packed.headers["vary"] == "Accept-Encoding"
            same = await here.get("/", if_none_match=f'"x", W/{plain.headers["etag"]}')
            assert (same.status, same.body) == (304, b"")
            assert "content-length" not in same.headers

    asyncio.run(play())


def test_long_answers_are_packed() -> None:
    async def play() -> None:
        async with scene() as here:
            packed = await here.get("/api/v1/openapi.json", accept_encoding="gzip")
            assert packed.headers["content-encoding"] == "gzip"
            assert json.loads(gzip.decompress(packed.body))["openapi"] == "3.1.0"

    asyncio.run(play())


def test_nothing_of_the_interface_is_kept_by_a_browser() -> None:
    async def play() -> None:
        async with scene() as here:
            for path in ("/api/v1/state", "/api/v1/about", "/nothing"):
                assert (await here.get(path)).headers["cache-control"] == "no-store"

    asyncio.run(play())


def test_the_policy_allows_nothing_but_what_we_serve() -> None:
    policy = SECURITY["Content-Security-Policy"]
    assert policy.startswith("default-src 'self'; ")
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert "*" not in policy


def test_rights_of_several_stations_do_not_choose_by_themselves() -> None:
    assert Rights(Least.STATION, (2, 3)).only_station is None
    assert Rights(Least.ADMIN, (2,)).only_station is None
