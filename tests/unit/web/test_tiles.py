"""Map tiles from a directory."""

import asyncio
from pathlib import Path

import pytest

from tests.unit.web.scene import scene
from timonel.gateway.web_settings import Web
from timonel.web.tiles import SIZE_MAX, Tiles

PNG = b"\x89PNG\r\n\x1a\n and a picture"


@pytest.fixture
def directory(tmp_path: Path) -> Path:
    """One tile, something beside it, and a zoom that has none."""
    place = tmp_path / "tiles" / "12" / "2077"
    place.mkdir(parents=True)
    (place / "1543.png").write_bytes(PNG)
    (tmp_path / "tiles" / "9").mkdir()
    (tmp_path / "tiles" / "9.txt").write_text("no zoom")
    (tmp_path / "secret.png").write_bytes(b"secret")
    return tmp_path / "tiles"


def test_a_tile_is_found_by_zoom_column_and_row(directory: Path) -> None:
    assert Tiles(directory).get("12/2077/1543.png") == PNG


@pytest.mark.parametrize(
    "place",
    ["12/2077/1544.png", "../secret.png", "12/../../secret.png", "12/2077/../../../secret.png", "12/2077/1543.png/",
     "12/2077/1543.PNG", "12/2077", "", "/etc/passwd", "12/2077/1543.png\x00", "\u0661\u0662/2077/1543.png",
     "1/2/3.png\n"],
)  # fmt: skip
def test_nothing_else_is_found(directory: Path, place: str) -> None:
    assert Tiles(directory).get(place) is None


def test_what_is_too_long_for_a_tile_is_none(directory: Path) -> None:
    (directory / "12" / "2077" / "1543.png").write_bytes(bytes(SIZE_MAX + 1))
    assert Tiles(directory).get("12/2077/1543.png") is None


def test_the_nearest_zoom_is_that_of_the_directory(directory: Path, tmp_path: Path) -> None:
    assert Tiles(directory).nearest == 12
    (tmp_path / "empty").mkdir()
    assert Tiles(tmp_path / "empty").nearest is None


def test_tiles_are_served_and_what_there_is_not_is_nothing_to_complain_of(directory: Path) -> None:
    async def play() -> None:
        async with scene(web=Web(tiles=str(directory))) as here:
            assert (await here.get("/api/v1/about")).json["tiles"] == 12
            answer = await here.get("/tiles/12/2077/1543.png", **{"accept-encoding": "gzip"})
            assert (answer.status, answer.body, answer.headers["content-type"]) == (200, PNG, "image/png")
            for missing in ("/tiles/12/2077/1.png", "/tiles/12/../../secret.png"):
                assert (await here.get(missing)).status == 204

    asyncio.run(play())


def test_without_tiles_there_are_none() -> None:
    async def play() -> None:
        async with scene() as here:
            assert (await here.get("/api/v1/about")).json["tiles"] is None
            assert (await here.get("/tiles/12/2077/1543.png")).status == 204

    asyncio.run(play())
