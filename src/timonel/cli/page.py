"""A screen page: lines of styled text that fit the terminal exactly, by day and by night."""

from collections.abc import Sequence
from textwrap import wrap

import msgspec
from rich.console import Console, ConsoleOptions, RenderResult
from rich.segment import Segment
from rich.style import Style
from rich.text import Text


class Palette(msgspec.Struct, frozen=True):
    """What the pages paint with; every part stands on `base`. Nothing is told by colour alone."""

    base: str = ""
    dim: str = "dim"
    value: str = "bold"
    good: str = "bold green"
    warn: str = "bold yellow"
    bad: str = "bold white on red"
    port: str = "red"
    starboard: str = "green"


DAY = Palette()
NIGHT = Palette(
    base="color(124) on color(16)",
    dim="color(88)",
    value="color(160)",
    good="color(160)",
    warn="bold color(160)",
    bad="reverse",
    port="color(160)",
    starboard="color(160)",
)
"""Red on black, from the fixed part of the 256 colours, so that a terminal's theme cannot make it pale."""


class Page(msgspec.Struct, frozen=True):
    """`lines` from the top and `foot` from the bottom of the terminal.

    What is too wide is cut. What is too many is left out: empty lines first, the last lines then.
    """

    lines: Sequence[Text]
    foot: Sequence[Text] = ()
    base: str = ""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        width, height = options.max_width, options.height or console.height
        base = console.get_style(self.base)
        for number, line in enumerate(self.fitted(height)):
            if number:
                yield Segment.line()
            yield from _painted(console, line, width, base)

    def fitted(self, height: int) -> list[Text]:
        """Exactly `height` lines."""
        lines = list(self.lines)
        spare = height - len(lines) - len(self.foot)
        for place in range(len(lines) - 1, -1, -1):
            if spare < 0 and not lines[place].plain.strip():
                del lines[place]
                spare += 1
        lines = lines[: max(0, height - len(self.foot))]
        blank = [Text() for _ in range(height - len(lines) - len(self.foot))]
        return [*lines, *blank, *self.foot][:height]


def _painted(console: Console, line: Text, width: int, base: Style) -> list[Segment]:
    line = line.copy()
    line.truncate(width, overflow="ellipsis", pad=True)
    line.end = ""
    return list(Segment.apply_style(line.render(console), base))


def spread(left: Text, right: Text, width: int) -> Text:
    """`left` and `right` at the two ends of a line; `right` gives way where there is no room for both."""
    if left.cell_len + right.cell_len + 1 > width:
        return left
    return Text.assemble(left, " " * (width - left.cell_len - right.cell_len), right)


def wrapped(text: str, width: int, style: str) -> list[Text]:
    """`text` in as many lines as it needs, each with a blank before and behind it."""
    return [Text.assemble(" ", (line, style)) for line in wrap(text, width - 2)] or [Text()]


def fitting(texts: Sequence[str], width: int) -> Sequence[str]:
    """`texts` side by side as one, where there is room for that."""
    together = "  ".join(texts)
    return [together] if len(together) <= width else texts


def rule(width: int, style: str) -> Text:
    return Text("─" * width, style)
