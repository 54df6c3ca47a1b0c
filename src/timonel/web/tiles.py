"""Map tiles of the owner's own, from a directory as every tool makes them: `z/x/y.png`, y from the north."""

import re
from pathlib import Path

PLACE = re.compile(r"(\d{1,2})/(\d{1,8})/(\d{1,8})\.png", re.ASCII)
SIZE_MAX = 1_000_000  # bytes


class Tiles:
    """The tiles of a directory."""

    def __init__(self, directory: Path) -> None:
        self._directory = directory
        zooms = [int(each.name) for each in directory.glob("[0-9]*") if each.name.isdecimal()]
        self.nearest = max(zooms, default=None)
        """The nearest zoom that there is, None without any."""

    def get(self, place: str) -> bytes | None:
        """The tile at `z/x/y.png`; None where there is none. Blocks while it is read."""
        if PLACE.fullmatch(place) is None:
            return None
        try:
            with (self._directory / place).open("rb") as file:
                tile = file.read(SIZE_MAX + 1)
        except OSError:
            return None
        return tile if len(tile) <= SIZE_MAX else None
