"""The description of the HTTP interface, OpenAPI 3.1, written from the table of routes and the declarations."""

from functools import cache
from typing import Any

import msgspec

from timonel import __version__
from timonel.web.access import COOKIE, Least
from timonel.web.api import ErrorText
from timonel.web.routes import ROUTES, Route

Json = dict[str, Any]

WHY = {
    400: "The request is not understood; the text says why.",
    401: "Sign in first.",
    403: "You may not; or the request comes from a page of somebody else's.",
    404: "There is no such thing.",
    409: "It is so already.",
    413: "Too long.",
    415: "Not JSON.",
    421: "By a name that is not ours: add it to `hosts` of `[web]`.",
    429: "Too many failures, or too many at once.",
}
OF_ALL = (400, 421, 429)
OF_BODIES = (400, 403, 413, 415)
TEMPLATE = "#/components/schemas/{name}"


@cache
def document() -> bytes:
    """The whole of it."""
    described = [route for route in ROUTES if route.described]
    types = [ErrorText, *(kind for route in described for kind in (route.body, route.answer) if kind is not None)]
    schemas, components = msgspec.json.schema_components(types, ref_template=TEMPLATE)
    schema_of = dict(zip(map(id, types), schemas, strict=True))
    paths: dict[str, Json] = {}
    for route in described:
        paths.setdefault(route.path, {})[route.method.lower()] = _operation(route, schema_of)
    return msgspec.json.encode(
        {
            "openapi": "3.1.0",
            "info": {"title": "timonel", "version": __version__, "license": {"name": "Apache-2.0"}},
            "paths": paths,
            "components": {
                "schemas": components,
                "securitySchemes": {
                    "cookie": {"type": "apiKey", "in": "cookie", "name": COOKIE},
                    "token": {"type": "http", "scheme": "bearer"},
                },
            },
        }
    )


def _operation(route: Route, schema_of: dict[int, Json]) -> Json:
    refusals = {*OF_ALL, *route.refusals, *(OF_BODIES if route.changes else ())}
    if route.least > Least.NOBODY:
        refusals |= {401, 403}
    operation: Json = {
        "operationId": route.path.rsplit("/v1/")[-1].replace("/", "_"),
        "summary": route.about,
        "description": f"Least role: {route.least.name.lower()}.",
        "responses": {
            str(route.status): _answer(route, schema_of),
            **{str(status): _refusal(status, schema_of) for status in sorted(refusals)},
        },
    }
    if route.least > Least.NOBODY:
        operation["security"] = [{"cookie": []}, {"token": []}, {}]  # nothing, where no token is configured
    if route.query:
        operation["parameters"] = [
            {"name": each.name, "in": "query", "schema": each.schema, "description": each.about} for each in route.query
        ]
    if route.body is not None:
        operation["requestBody"] = {"required": True, "content": _json(schema_of[id(route.body)])}
    return operation


def _answer(route: Route, schema_of: dict[int, Json]) -> Json:
    if route.answer is None:
        return {"description": "Done."}
    return {"description": route.about, "content": _json(schema_of[id(route.answer)])}


def _refusal(status: int, schema_of: dict[int, Json]) -> Json:
    return {"description": WHY[status], "content": _json(schema_of[id(ErrorText)])}


def _json(schema: Json) -> Json:
    return {"application/json": {"schema": schema}}
