"""Draws docs/images/demo.svg: the screen of `timonel demo` a minute after the bridge engaged the pilot."""

import re
from pathlib import Path

from rich.console import Console

from timonel.cli.view import LiveView
from timonel.core.effects import Effect, Transmit
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import Verb
from timonel.vehicles.boat.settings import BoatSettings, Port
from timonel.vehicles.boat.simulator import SimulatedBoat
from timonel.vehicles.boat.vehicle import Boat

TARGET = Path(__file__).parents[1] / "docs" / "images" / "demo.svg"
WIDTH, HEIGHT = 110, 34
FONT_FACE = re.compile(r"@font-face \{.*?\}\s*", re.DOTALL)  # the picture must not fetch anything
STEP = 0.05  # s
STATIONS = {1: "Bridge", 2: "Cockpit", 3: "Flybridge"}
SCRIPT = {
    2.0: ("Bridge", parp.command(Verb.TAKECMD, 1)),
    4.0: ("Bridge", parp.command(Verb.ENGAGE, 1)),
    6.0: ("Bridge", parp.command(Verb.STBDTEN, 1)),
    9.0: ("Cockpit", parp.command(Verb.REQCMD, 2)),
    12.0: ("Bridge", parp.command(Verb.RELCMD, 1)),
    14.0: ("Cockpit", parp.command(Verb.STBDTEN, 2)),
}


class Demo:
    """The demo without a clock, a wire or a screen."""

    def __init__(self) -> None:
        ports = [Port(name, station) for station, name in STATIONS.items()]
        self.view = LiveView(
            ["listen   OpenCPN: TCP, 127.0.0.1:10110", "steer    timonel station tcp://127.0.0.1:10114 --id 4"]
        )
        self._sea = SimulatedBoat(seed=1)
        self._boat = Boat(BoatSettings(name="demo"), ports, now=0.0)
        for name in ("bus", *STATIONS.values()):
            self.view.port(name, True, 0.0)

    def run(self, seconds: float) -> None:
        """Let the boat sail, with the stations saying what `SCRIPT` has."""
        for number in range(round(seconds / STEP)):
            now = number * STEP
            frames = self._sea.step(STEP)
            self.view.frames_received(frames, now)
            self._do(self._boat.receive_frames(frames, now), now)
            self._do(self._boat.expire(now) if now >= self._boat.deadline else [], now)
            for time, (port, sentence) in SCRIPT.items():
                if abs(time - now) < STEP / 2:
                    self._do(self._boat.receive_bytes(port, sentence, now), now)

    def _do(self, effects: list[Effect], now: float) -> None:
        for effect in effects:
            self.view.effect(effect, now)
            if isinstance(effect, Transmit):
                self._sea.receive(effect.frame)


def main() -> None:
    demo = Demo()
    demo.run(16.5)
    with Path("/dev/null").open("w") as nowhere:
        console = Console(
            record=True, width=WIDTH, height=HEIGHT, file=nowhere, force_terminal=True, color_system="truecolor"
        )
        console.print(demo.view.page(WIDTH, HEIGHT, 16.5))
        TARGET.parent.mkdir(parents=True, exist_ok=True)
        svg = console.export_svg(title="timonel demo", unique_id="demo")
        TARGET.write_text(FONT_FACE.sub("", svg).replace("Fira Code", "DejaVu Sans Mono"))


if __name__ == "__main__":
    main()
