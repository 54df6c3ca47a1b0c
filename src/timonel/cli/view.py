"""The live view of what goes through a gateway: bus, sentences, stations, alerts, and what to connect."""

import asyncio
import logging
from collections.abc import Mapping, Sequence
from typing import ClassVar

from rich.console import Console
from rich.live import Live
from rich.text import Text

from timonel.cli.face import NAMES, angle, bar, rudder_text
from timonel.cli.page import DAY, Page, Palette, spread, wrapped
from timonel.cli.traffic import Heard, Traffic, spoken
from timonel.core.effects import Effect
from timonel.core.frame import Frame
from timonel.nmea0183.parp import PilotMode

REDRAW = 0.2  # s
OLD = 3.0  # s after which a value says nothing about now
RUDDER_CELLS = 7  # a side
RUDDER_CELLS_WIDE = 18
WIDE = 110
EVENTS_MIN = 3


class LiveView:
    """An observer of the gateway with a screen. `connect` is what stands at its foot.

    What it shows of a boat, another vehicle's view shows in other words (`rover_view`).
    """

    NAMES: ClassVar[Mapping[int, str]] = NAMES

    def __init__(self, connect: Sequence[str] = (), *, title: str = "timonel", palette: Palette = DAY) -> None:
        self.traffic = Traffic()
        self._connect = connect
        self._title_text = title
        self._paint = palette

    def frames_received(self, frames: Sequence[Frame], now: float) -> None:
        self.traffic.frames_received(frames, now)

    def effect(self, effect: Effect, now: float) -> None:
        self.traffic.effect(effect, now)

    def port(self, name: str, connected: bool, now: float) -> None:
        self.traffic.port(name, connected, now)

    async def show(self, console: Console) -> None:
        """Draw on `console` five times a second, until cancelled; the screen is given back as it was."""
        loop = asyncio.get_running_loop()
        with Live(console=console, screen=True, auto_refresh=False, vertical_overflow="crop") as live:
            while True:
                live.update(self.page(*console.size, loop.time()), refresh=True)
                await asyncio.sleep(REDRAW)

    def page(self, width: int, height: int, now: float) -> Page:
        """The screen at `now` (s). The tables share the lines that the rest leaves."""
        head = [self._title(width, now), self._state(width), *self._stations(width), *self._alerts(width)]
        foot = self._how_to_connect(width)
        room = height - len(head) - len(foot) - 3
        events = max(1, min(room // 5 + 1, max(EVENTS_MIN, len(self.traffic.events))))
        messages = min(len(self.traffic.messages), max(1, self._share(room - events)))
        sentences = max(0, room - events - messages)
        lines = [
            *head,
            *self._messages(width, messages, now),
            *self._sentences(width, sentences, now),
            *self._events(width, events, now),
        ]
        return Page(lines, foot, self._paint.base)

    # Parts ----------------------------------------------------------------------------------------

    def _title(self, width: int, now: float) -> Text:
        rates = Text(self._rates(now), self._paint.dim)
        return spread(Text(f" {self._title_text}", self._paint.value), rates, width - 1)

    def _rates(self, now: float) -> str:
        traffic = self.traffic
        return (
            f"bus {traffic.frames_in.rate(now):.0f} in {traffic.frames_out.rate(now):.1f} out frames/s   "
            f"{traffic.lines_out.rate(now):.0f} sentences/s"
        )

    def _share(self, rows: int) -> int:
        """How many of the rows messages have, beside sentences."""
        return rows // 2

    def _state(self, width: int) -> Text:
        paint, status = self._paint, self.traffic.status
        if status is None:
            return Text(" no STATUS yet", paint.dim)
        alarm = status.mode is PilotMode.ALARM
        mode = (status.mode.value if status.mode else status.mode_text or "unknown").replace("_", " ")
        port, starboard = bar(status.rudder_deg, RUDDER_CELLS if width < WIDE else RUDDER_CELLS_WIDE)
        return Text.assemble(
            " ", (f" {mode:<12} ", paint.bad if alarm else f"reverse {paint.value}"),
            ("  set ", paint.dim), (angle(status.setpoint_deg), paint.value),
            ("  heading ", paint.dim), (angle(status.heading_deg), paint.value),
            ("  P▕", paint.dim), (port, paint.port), "│", (starboard, paint.starboard), ("▏S ", paint.dim),
            (rudder_text(status.rudder_deg), paint.value),
        )  # fmt: skip

    def _stations(self, width: int) -> list[Text]:
        paint, commander = self._paint, self._commander()
        who = f"{commander:02d} {self.NAMES[commander]}" if commander else "nobody"
        command = Text.assemble("  ", ("command ", paint.dim), (f"{who:<12}", paint.value))
        ports = Text()
        for name, connected in self.traffic.ports.items():
            ports.append(f"  {'●' if connected else '○'} {name}", paint.good if connected else paint.dim)
        together = Text.assemble(command, ports)
        return [together] if together.cell_len <= width else [command, ports]

    def _commander(self) -> int | None:
        status = self.traffic.status
        return None if status is None else status.commander

    def _alerts(self, width: int) -> list[Text]:
        alerts = sorted(self.traffic.alerts.values(), key=lambda alert: alert.kind.priority)
        return [
            line
            for alert in alerts[:2]
            for line in wrapped(f"{alert.kind.priority.name}  {alert.kind.name}: {alert.text}", width, self._paint.bad)
        ]

    def _messages(self, width: int, rows: int, now: float) -> list[Text]:
        heard = self.traffic.messages_by_importance()
        title = self._heading("   PGN  message                 /s   age  values", len(heard) - rows, width)
        return [title, *(self._message(pgn, message, now) for pgn, message in heard[:rows])]

    def _message(self, pgn: int, heard: Heard, now: float) -> Text:
        text = f"{pgn:6d}  {heard.name[:21]:<21} {self._pace(heard, now)}  {spoken(pgn, heard.last)}"
        return Text(text, self._freshness(heard, now))

    def _sentences(self, width: int, rows: int, now: float) -> list[Text]:
        heard = self.traffic.sentences_by_importance()
        title = self._heading("sentence       /s   age  last", len(heard) - rows, width)
        return [title, *(self._sentence(sentence, now) for sentence in heard[:rows])]

    def _sentence(self, heard: Heard, now: float) -> Text:
        last = heard.last.decode("ascii", "replace")
        return Text(f" {heard.name[:11]:<11} {self._pace(heard, now)}  {last}", self._freshness(heard, now))

    def _pace(self, heard: Heard, now: float) -> str:
        return f"{heard.meter.rate(now):5.1f} {min(now - heard.at, 999.9):5.1f}"

    def _freshness(self, heard: Heard, now: float) -> str:
        return self._paint.dim if now - heard.at > OLD else ""

    def _heading(self, text: str, hidden: int, width: int) -> Text:
        more = Text(f"+{hidden} more" if hidden > 0 else "", f"reverse {self._paint.dim}")
        line = spread(Text(text, f"reverse {self._paint.dim}"), more, width)
        line.pad_right(max(0, width - line.cell_len))
        line.stylize(f"reverse {self._paint.dim}")
        return line

    def _events(self, width: int, rows: int, now: float) -> list[Text]:
        events = list(self.traffic.events)[-rows:]
        title = self._heading("  happened", 0, width)
        if not events:
            return [title, Text("  nothing yet", self._paint.dim)]
        return [title, *(self._event(event.text, event.severity, event.times, now - event.at) for event in events)]

    def _event(self, text: str, severity: int, times: int, age: float) -> Text:
        repeated = f"  ({times} times)" if times > 1 else ""
        style = self._paint.warn if severity >= logging.WARNING else ""
        return Text.assemble((f" {age:4.0f} s  ", self._paint.dim), (f"{text}{repeated}", style))

    def _how_to_connect(self, width: int) -> list[Text]:
        return [line for text in self._connect for line in wrapped(text, width, self._paint.dim)]
