"""What a keyboard head shows: a pure function of what is known, drawn for the size of the terminal."""

import msgspec
from rich.text import Text

from timonel.cli.page import DAY, NIGHT, Page, Palette, fitting, rule, spread, wrapped
from timonel.gateway.lookout import Request, StationStatus
from timonel.nmea0183.parp import PilotMode

NAMES = {1: "Bridge", 2: "Cockpit", 3: "Flybridge", 4: "Reserve"}
WIDE = 72
RUDDER_MAX = 35.0  # degrees at the ends of the bar

# 3 by 5 pixels, row by row
_DIGITS = {
    "0": "### # # # # # # ###",
    "1": " #  ##   #   #  ###",
    "2": "###   # ### #   ###",
    "3": "###   # ###   # ###",
    "4": "# # # # ###   #   #",
    "5": "### #   ###   # ###",
    "6": "### #   ### # # ###",
    "7": "###   #   #   #   #",
    "8": "### # # ### # # ###",
    "9": "### # # ###   # ###",
    "-": "        ###        ",
}
_HALVES = {"  ": " ", "# ": "▀", " #": "▄", "##": "█"}

HELP = (
    ("← →  ↓ ↑", "-1, +1 degree"),
    ("shift ← →  < >", "-10, +10 degrees"),
    ("h 0 4 5 enter", "hold heading 045"),
    ("a  e", "AUTO: hold this heading"),
    ("space", "STANDBY, at all times"),
    ("r", "ask for command"),
    ("t", "take command (bridge)"),
    ("y", "give command away"),
    ("n", "deny who asks"),
    ("l", "day or night colours"),
    ("q", "leave all as it is"),
)
KEYS = (
    "← → 1 degree   shift ← → 10 degrees   h heading   a AUTO   space STANDBY",
    "r ask   t take   y give   n deny   l night   ? help   q leave",
)
KEYS_NARROW = ("← → 1  shift ← → 10  a AUTO  spc STANDBY", "r ask t take y give n deny ? help q end")


class Face(msgspec.Struct, frozen=True):
    """All that is shown. `entry` is the heading being typed; `message` the last event or refusal."""

    station: int
    link: str
    status: StationStatus
    requests: tuple[Request, ...] = ()
    lost: str | None = None
    asking: bool = False
    entry: str | None = None
    message: str = ""
    refused: bool = False
    help: bool = False
    night: bool = False

    @property
    def palette(self) -> Palette:
        return NIGHT if self.night else DAY

    def page(self, width: int) -> Page:
        paint = self.palette
        lines = [self._title(width), rule(width, paint.dim)]
        lines += self._help() if self.help else self._instruments(width)
        return Page(lines, self._foot(width), paint.base)

    def _title(self, width: int) -> Text:
        paint = self.palette
        name = f" {self.station:02d} {NAMES[self.station]}"
        link = f"   {self.link}" if width >= WIDE else ""
        return spread(Text.assemble((name, paint.value), (link, paint.dim)), self._freshness(), width - 1)

    def _freshness(self) -> Text:
        age = self.status.age
        if self.lost is not None or age is None:
            return Text("○ no link" if self.lost else "○ listening", self.palette.warn)
        return Text(f"● {age:.1f} s", self.palette.good)

    def _help(self) -> list[Text]:
        paint = self.palette
        return [Text.assemble((f" {keys:<14} ", paint.value), (what, "")) for keys, what in HELP]

    def _instruments(self, width: int) -> list[Text]:
        return [
            *self._warning(width),
            *self._numbers(width),
            Text(),
            self._mode(),
            self._command(),
            Text(),
            self._rudder(width),
            Text(),
            *self._request(width),
            Text(),
            *self._message(width),
        ]

    def _warning(self, width: int) -> list[Text]:
        if self.lost is not None:
            age = "" if self.status.age is None else f", last heard {self.status.age:.0f} s ago"
            return wrapped(f"NO LINK  {self.lost}{age}", width, self.palette.bad)
        if self.status.mode is PilotMode.ALARM:
            return wrapped("ALARM  steer by hand", width, self.palette.bad)
        return [Text()]

    def _numbers(self, width: int) -> list[Text]:
        paint, wide = self.palette, width >= WIDE
        style = paint.dim if self.status.stale else paint.value
        setpoint = self.status.setpoint_deg if self.status.mode is not PilotMode.STANDBY else None
        left, right = big(angle(self.status.heading_deg), wide), big(angle(setpoint), wide)
        gap = max(3, width // 2 - len(left[0]) - 1)
        labels = f" {'HEADING':<{len(left[0]) + gap}}SET POINT"
        rows = [Text(f" {a}{' ' * gap}{b}", style) for a, b in zip(left, right, strict=True)]
        return [Text(labels, paint.dim), *rows]

    def _mode(self) -> Text:
        paint = self.palette
        mode = self.status.mode
        name = mode.value.replace("_", " ") if mode else self.status.mode_text or "unknown"
        style = paint.bad if mode is PilotMode.ALARM else paint.good if mode is PilotMode.HEADING_HOLD else paint.value
        return Text.assemble((" MODE     ", paint.dim), (f" {name} ", paint.dim if self.status.stale else style))

    def _command(self) -> Text:
        paint, commander = self.palette, self.status.commander
        label = (" COMMAND  ", paint.dim)
        if commander is None or self.status.stale:
            return Text.assemble(label, (" not known ", paint.dim))
        if commander == self.station:
            return Text.assemble(label, (" THIS STATION ", paint.good))
        who = f"{commander:02d} {NAMES[commander]}" if commander else "nobody"
        asking = "  asking ..." if self.asking else ""
        return Text.assemble(label, (" LOCKED ", "reverse"), (f"  {who}{asking}", paint.value))

    def _rudder(self, width: int) -> Text:
        paint, angle = self.palette, self.status.rudder_deg
        port, starboard = bar(angle, min(35, (width - 22) // 2))
        figure = (rudder_text(angle), paint.dim if self.status.stale else paint.value)
        left = (" RUDDER  P▕", paint.dim), (port, paint.port), "│"
        return Text.assemble(*left, (starboard, paint.starboard), ("▏S ", paint.dim), figure)

    def _request(self, width: int) -> list[Text]:
        if not self.requests:
            return [Text()]
        request = self.requests[0]
        if request.station == self.station:
            return wrapped(f"you have asked for command: {request.seconds_left:.0f} s", width, self.palette.warn)
        style = f"reverse {self.palette.warn}"
        who = f"{request.station:02d} {NAMES[request.station]} asks for command: {request.seconds_left:.0f} s"
        if self.status.commander != self.station:
            return wrapped(who, width, style)
        return [line for text in fitting((who, "y give  n deny"), width - 2) for line in wrapped(text, width, style)]

    def _message(self, width: int) -> list[Text]:
        if self.entry is not None:
            return wrapped(f"set heading: {self.entry}_   (enter sets, escape does not)", width, self.palette.warn)
        return wrapped(self.message, width, self.palette.warn if self.refused else "")

    def _foot(self, width: int) -> list[Text]:
        keys = KEYS if width >= WIDE + 4 else KEYS_NARROW
        return [Text(f" {line}" if width > 40 else line, self.palette.dim) for line in keys]


def angle(degrees: float | None) -> str:
    return "---.-" if degrees is None else f"{degrees:05.1f}"


def rudder_text(degrees: float | None) -> str:
    return "--.-" if degrees is None else f"{degrees:+.1f}"


def bar(degrees: float | None, half: int) -> tuple[str, str]:
    """The port and the starboard half of a rudder bar, each `half` cells wide; full at 35 degrees."""
    length = 0.0 if degrees is None else min(1.0, abs(degrees) / RUDDER_MAX) * half
    filled = "█" * int(length) + ("▌" if length % 1 >= 0.5 else "")
    if degrees is not None and degrees < 0:
        return filled.replace("▌", "▐")[::-1].rjust(half), " " * half
    return " " * half, filled.ljust(half)


def big(text: str, wide: bool) -> list[str]:
    """`text` in large digits: five rows of pixels two cells wide, or three rows of halves of cells."""
    bitmaps = [_bitmap(character) for character in text]
    rows = [" ".join(parts) for parts in zip(*bitmaps, strict=True)]
    if wide:
        return [row.replace("#", "██").replace(" ", "  ") for row in rows]
    rows.append(" " * len(rows[0]))
    pairs = zip(rows[::2], rows[1::2], strict=True)
    return ["".join(_HALVES[top + bottom] for top, bottom in zip(*pair, strict=True)) for pair in pairs]


def _bitmap(character: str) -> list[str]:
    if character == ".":
        return [" ", " ", " ", " ", "#"]
    pixels = _DIGITS[character]
    return [pixels[start : start + 3] for start in range(0, 19, 4)]
