"""Tables for people. rich draws them; where no terminal is there to decide, what it would draw is written at once.

To load rich and to draw two tables with it takes longer than to decode a hundred thousand frames.
"""

import os
import re
import sys
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING

import msgspec

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

WIDE = 160
"""Characters of a line where it is no terminal that decides."""

_GAP = "  "
_FORCED = ("FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE", "JUPYTER_COLUMNS")
_MARKUP = frozenset("[:\\")  # what names may have that is more than text to rich
_EMOJI = re.compile(r":\S+:")  # and lines


class Sheet(msgspec.Struct, frozen=True):
    """A table without lines between its cells, and without the columns in which nothing stands.

    Columns of `numbers` are set to the right. Without `names` it is a list of names and values.
    """

    names: Sequence[str]
    rows: Sequence[Sequence[str]]
    numbers: frozenset[str] = frozenset()

    @property
    def _shown(self) -> list[int]:
        if not self.names:
            return [0, 1]
        return [place for place in range(len(self.names)) if any(row[place] for row in self.rows)]

    def __rich__(self) -> "Table":
        return self._table() if self.names else self._grid()

    def _table(self) -> "Table":
        from rich.table import Table
        from rich.text import Text

        made = Table(box=None, padding=(0, 2, 0, 0), header_style="bold")
        for place in self._shown:
            name = self.names[place]
            made.add_column(name, justify="right" if name in self.numbers else "left", overflow="fold")
        for row in self.rows:
            made.add_row(*(Text(row[place]) for place in self._shown))
        return made

    def _grid(self) -> "Table":
        from rich.table import Table
        from rich.text import Text

        made = Table.grid(padding=(0, 2))
        for name, value in self.rows:
            made.add_row(Text(name, "dim"), Text(value, overflow="fold"))
        return made

    def text(self) -> str | None:
        """What rich makes of it on lines of `WIDE`; None where it takes rich to know: long lines, any letters."""
        shown = self._shown
        lines = [[row[place] for place in shown] for row in (self.names, *self.rows) if row]
        sizes = [max(map(len, column)) for column in zip(*lines, strict=True)]
        if not (self._simple(lines) and all(sizes) and sum(sizes) + len(_GAP) * len(sizes) <= WIDE):
            return None
        right = [bool(self.names) and self.names[place] in self.numbers for place in shown]
        form = _GAP.join(f"{{:{'>' if to_right else '<'}{size}}}" for to_right, size in zip(right, sizes, strict=True))
        edge = _GAP if self.names else ""
        return "".join(f"{form.format(*line)}{edge}\n" for line in lines)

    def _simple(self, lines: Sequence[Sequence[str]]) -> bool:
        if not (self.rows and self._shown) or any(_MARKUP.intersection(name) for name in self.names):
            return False
        return all(_plain(cell) for line in lines for cell in line)


def _plain(cell: str) -> bool:
    return cell.isascii() and (cell.isprintable() or not cell) and cell == cell.strip()


class Screen:
    """Where people look: a terminal, or what stands for it."""

    def __init__(self, stderr: bool = False) -> None:
        self._stderr = stderr
        file = sys.stderr if stderr else sys.stdout
        self._terminal = file.isatty() or any(name in os.environ for name in _FORCED)

    def print(self, what: "Sheet | str") -> None:
        """A table, or one line as it stands."""
        text = None if self._terminal else self._text(what)
        if text is None:
            self._console.print(what, markup=False, highlight=False)
        else:
            file = sys.stderr if self._stderr else sys.stdout
            file.write(text)
            file.flush()

    @staticmethod
    def _text(what: "Sheet | str") -> str | None:
        if isinstance(what, Sheet):
            return what.text()
        return f"{what}\n" if _plain(what) and len(what) <= WIDE and not _EMOJI.search(what) else None

    @cached_property
    def _console(self) -> "Console":
        return console(self._stderr)


def console(stderr: bool = False) -> "Console":
    """rich's, of the terminal's width, or wide enough for a file."""
    from rich.console import Console

    made = Console(stderr=stderr, highlight=False)
    return made if made.is_terminal else Console(stderr=stderr, highlight=False, width=WIDE)
