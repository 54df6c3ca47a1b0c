"""The live view of what goes through a rover's controller: frames both ways, stations, alerts, what to connect."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from rich.text import Text

from timonel.cli.page import DAY, Palette
from timonel.cli.rover_traffic import STATIONS, RoverTraffic, spoken
from timonel.cli.traffic import Heard
from timonel.cli.view import LiveView
from timonel.vehicles.rover.frames import WheelSpeedSetLeft, WheelSpeedSetRight
from timonel.vehicles.rover.protocol import Protocol


class RoverView(LiveView):
    """An observer of a rover's gateway with a screen."""

    NAMES: ClassVar[Mapping[int, str]] = STATIONS
    traffic: RoverTraffic

    def __init__(
        self, protocol: Protocol, connect: Sequence[str] = (), *, title: str = "timonel", palette: Palette = DAY
    ) -> None:
        super().__init__(connect, title=title, palette=palette)
        self.traffic = RoverTraffic(protocol)

    def _rates(self, now: float) -> str:
        traffic = self.traffic
        return (
            f"bus {traffic.frames_in.rate(now):.0f} in {traffic.frames_out.rate(now):.0f} out frames/s   "
            f"to stations {traffic.lines_out.rate(now):.0f} frames/s"
        )

    def _share(self, rows: int) -> int:
        return rows - min(rows // 2, len(self.traffic.sent))

    def _state(self, width: int) -> Text:
        paint, permission = self._paint, self.traffic.permission
        state = " ENABLED " if permission.granted else " STOPPED "
        return Text.assemble(
            " ", (state, f"reverse {paint.good if permission.granted else paint.value}"),
            ("  wheels left ", paint.dim), (self._setpoint(WheelSpeedSetLeft.FRAME), paint.value),
            ("  right ", paint.dim), (self._setpoint(WheelSpeedSetRight.FRAME), paint.value),
            (f"   {permission.reason}", paint.dim),
        )  # fmt: skip

    def _setpoint(self, identifier: int) -> str:
        match self.traffic.decoded(self.traffic.sent, identifier):
            case WheelSpeedSetLeft(middle_percent=int(percent)) | WheelSpeedSetRight(middle_percent=int(percent)):
                return f"{percent:+4d} %"
        return "  -- %"

    def _commander(self) -> int | None:
        return self.traffic.commander

    def _messages(self, width: int, rows: int, now: float) -> list[Text]:
        return self._frames("from the modules", self.traffic.messages, rows, width, now)

    def _sentences(self, width: int, rows: int, now: float) -> list[Text]:
        return self._frames("to the modules", self.traffic.sent, rows, width, now)

    def _frames(self, title: str, heard: dict[int, Heard], rows: int, width: int, now: float) -> list[Text]:
        heading = self._heading(f"  id  {title:<24} /s   age  values", len(heard) - rows, width)
        return [heading, *(self._frame(heard, identifier, now) for identifier in sorted(heard)[:rows])]

    def _frame(self, heard: dict[int, Heard], identifier: int, now: float) -> Text:
        one = heard[identifier]
        values = spoken(self.traffic.decoded(heard, identifier), one.last)
        return Text(
            f" {identifier:3d}  {one.name[:21]:<21} {self._pace(one, now)}  {values}", self._freshness(one, now)
        )
