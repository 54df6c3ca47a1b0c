"""What a driver sees: a pure function of what is known of the rover, drawn for the size of the terminal."""

from math import atan2, degrees, hypot

import msgspec
from rich.text import Text

from timonel.cli.page import DAY, NIGHT, Page, Palette, fitting, rule, spread, wrapped
from timonel.cli.rover_traffic import STATIONS
from timonel.gateway.rover import DRIVERS, DriverStatus, Rover
from timonel.gateway.telemetry import Battery, LinkQuality, Position, Quality, Telemetry, Wheel
from timonel.vehicles.rover.drive import Stick, mixed
from timonel.vehicles.rover.frames import BatteryState, DriverState, Imu, Magnetometer

WIDE = 72
BAR = 10  # cells a side
FULL_RPM = 100.0  # at the end of a bar
HOT_MOTOR, HOT_BATTERY, LOW_CELL = 80.0, 55.0, 3.3  # degC, degC, V: shown as a warning from here on

HELP = (
    ("hold ↑ ↓  w s", "forward, back"),
    ("hold ← →  a d", "turn on the spot"),
    ("hold shift ← →", "forward in a curve"),
    ("e", "enable, with nothing pressed"),
    ("space", "stop, at all times"),
    ("+  -", "speed limit"),
    ("l", "day or night colours"),
    ("q", "stop and leave"),
)
KEYS = (
    "hold ↑ ↓ ← → to drive   shift ← → curve   e enable   space STOP",
    "+ - speed limit   l night   ? help   q stop and leave",
)
KEYS_NARROW = ("hold ↑↓←→  e enable  spc STOP", "+ - limit  ? help  q stop, end")


class Attitude(msgspec.Struct, frozen=True):
    """What the IMU and the magnetometer say, in degrees and degrees a second; None is not available.

    Roll is positive with the right side down, pitch with the bow up, the turn and the heading clockwise.
    """

    roll: float | None = None
    pitch: float | None = None
    turn: float | None = None
    heading: float | None = None

    @classmethod
    def of(cls, telemetry: Telemetry) -> "Attitude":
        """Tilt is that of the specific force, so it is right while the rover does not speed up or brake."""
        imu, magnetometer = telemetry.get(Imu), telemetry.get(Magnetometer)
        heading = None if magnetometer is None else magnetometer.frame.magnetic_heading
        facing = None if heading is None else degrees(heading)
        match None if imu is None else imu.frame:
            case Imu(acceleration_x=float(x), acceleration_y=float(y), acceleration_z=float(z), rate_z=float(turn)):
                return cls(degrees(atan2(y, z)), degrees(atan2(x, hypot(y, z))), -degrees(turn), facing)
        return cls(heading=facing)


class Gauges(msgspec.Struct, frozen=True):
    """All that is shown. `speed_limit` is 0..1, `message` the last event or refusal."""

    station: int
    url: str
    enabled: bool
    why_idle: str
    lost: str | None
    setpoint: tuple[float, float]
    speed_limit: float
    wheels: tuple[Wheel, ...]
    battery: Battery
    position: Position
    attitude: Attitude
    drivers: dict[str, str]
    link: LinkQuality
    message: str = ""
    refused: bool = False
    help: bool = False
    night: bool = False

    @classmethod
    def of(cls, rover: Rover, url: str, speed_limit: float, **shown: object) -> "Gauges":
        """What `rover` knows now."""
        return cls(
            station=rover.station,
            url=url,
            enabled=rover.enabled,
            why_idle=rover.why_idle,
            lost=rover.lost,
            setpoint=rover.setpoint,
            speed_limit=speed_limit,
            wheels=rover.wheels,
            battery=rover.battery,
            position=rover.position,
            attitude=Attitude.of(rover.telemetry),
            drivers={
                name.removesuffix(" motor driver"): _driver(rover.telemetry, kind) for kind, name in DRIVERS.items()
            },
            link=rover.link,
            **shown,  # type: ignore[arg-type]  # message, refused, help, night
        )

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
        name = f" {self.station:02d} {STATIONS[self.station]}"
        link = f"   {self.url}" if width >= WIDE else ""
        return spread(Text.assemble((name, paint.value), (link, paint.dim)), self._quality(), width - 1)

    def _quality(self) -> Text:
        paint, link = self.palette, self.link
        if self.lost is not None or link.share is None:
            return Text("○ no link" if self.lost else "○ listening", paint.warn)
        style = paint.good if link.share > 0.99 else paint.warn
        return Text(f"● {link.frames:.0f} frames/s  {link.share * 100:.1f} % whole", style)

    def _help(self) -> list[Text]:
        paint = self.palette
        return [Text.assemble((f" {keys:<16} ", paint.value), (what, "")) for keys, what in HELP]

    def _instruments(self, width: int) -> list[Text]:
        return [
            self._state(),
            Text(),
            *self._wheels(width),
            Text(),
            *self._battery(width),
            self._place(),
            self._tilt(),
            self._driver_states(),
            self._framing(),
            Text(),
            *self._said(width),
        ]

    def _state(self) -> Text:
        paint, (forward, right) = self.palette, self.setpoint
        if self.lost is not None:
            return Text(f" NO LINK  {self.lost}", paint.bad)
        state, style = (" ENABLED ", paint.good) if self.enabled else (" STOPPED ", paint.value)
        return Text.assemble(
            " ", (state, f"reverse {style}"),
            ("  speed limit ", paint.dim), (f"{self.speed_limit * 100:.0f} %", paint.value),
            ("  forward ", paint.dim), (f"{forward:+.2f}", paint.value),
            ("  right ", paint.dim), (f"{right:+.2f}", paint.value),
        )  # fmt: skip

    def _wheels(self, width: int) -> list[Text]:
        wide = width >= WIDE
        label = f" {'wheel':<13}  set     rpm       A     °C" + ("  speed" if wide else "")
        return [Text(label, self.palette.dim), *(self._wheel(wheel, wide) for wheel in self.wheels)]

    def _wheel(self, wheel: Wheel, wide: bool) -> Text:
        paint = self.palette
        style = "" if wheel.quality is Quality.FRESH else paint.dim
        hot = wheel.temperature_c is not None and wheel.temperature_c >= HOT_MOTOR
        line = Text.assemble(
            (f" {wheel.side} {wheel.place:<{12 - len(wheel.side)}}", paint.dim),
            (f"{self._asked(wheel.side):+5d} %", style),
            (f"{number(wheel.rpm, '+7.1f'):>8}{number(wheel.current, '+8.1f'):>8}", style),
            (f"{number(wheel.temperature_c, '7.1f'):>7}", paint.warn if hot else style),
        )
        if wide:
            back, ahead = bar(wheel.rpm)
            line.append_text(Text.assemble(("  ", ""), (back, paint.port), "│", (ahead, paint.starboard)))
        return line

    def _asked(self, side: str) -> int:
        """What the controller's mixer makes of the set point, in percent."""
        forward, right = self.setpoint
        wheels = mixed(Stick(y=round(right * 100), x=-round(forward * 100)), round(self.speed_limit * 20))
        return wheels.left if side == "left" else wheels.right

    def _battery(self, width: int) -> list[Text]:
        paint, battery = self.palette, self.battery
        dim = "" if battery.quality is Quality.FRESH else paint.dim
        state = "unknown" if battery.state is None else battery.state.name.lower().replace("_", " ")
        low = any(cell is not None and cell < LOW_CELL for cell in battery.cells)
        hot = any(module is not None and module >= HOT_BATTERY for module in battery.temperatures_c)
        cells = " ".join(number(cell, ".2f") for cell in battery.cells)
        modules = " ".join(number(module, ".0f") for module in battery.temperatures_c)
        return [
            Text.assemble(
                (" battery  ", paint.dim), (f"{number(battery.voltage, '.1f')} V", dim or paint.value), "  ",
                (state, paint.good if battery.state is BatteryState.OK else paint.bad),
                ("   cells ", paint.dim), (f"{cells} V", paint.warn if low else dim),
            ),
            Text.assemble((" modules  ", paint.dim), (f"{modules} °C", paint.warn if hot else dim)),
        ]  # fmt: skip

    def _place(self) -> Text:
        paint, place = self.palette, self.position
        label = (" position ", paint.dim)
        if place.latitude_deg is None or place.longitude_deg is None:
            return Text.assemble(label, ("no fix", paint.warn))
        north, east = "N" if place.latitude_deg >= 0 else "S", "E" if place.longitude_deg >= 0 else "W"
        text = f"{abs(place.latitude_deg):.6f}° {north}  {abs(place.longitude_deg):.6f}° {east}"
        stale = place.quality is not Quality.FRESH
        return Text.assemble(
            label, (f"{text}{f'  {place.age:.0f} s old' if stale else ''}", paint.dim if stale else "")
        )

    def _tilt(self) -> Text:
        tilt = self.attitude
        text = (
            f"roll {number(tilt.roll, '+.0f')}°  pitch {number(tilt.pitch, '+.0f')}°  "
            f"turn {number(tilt.turn, '+.0f')}°/s  heading {number(tilt.heading, '03.0f')}° magnetic"
        )
        return Text.assemble((" attitude ", self.palette.dim), text)

    def _driver_states(self) -> Text:
        paint = self.palette
        fine = {_words(DriverState.RUNNING): paint.good, _words(DriverState.STOPPED): paint.value}
        parts = [
            part
            for side, state in sorted(self.drivers.items())
            for part in ((f"{side} ", paint.dim), (state, fine.get(state, paint.bad)), ("   ", ""))
        ]
        return Text.assemble((" drivers  ", paint.dim), *parts)

    def _framing(self) -> Text:
        text = f"{self.link.skipped} bytes found no place, {self.link.resynchronised} times found again"
        return Text.assemble((" link     ", self.palette.dim), text)

    def _said(self, width: int) -> list[Text]:
        if not self.message and not self.enabled and self.lost is None:
            return wrapped(self.why_idle, width, self.palette.dim)
        return wrapped(self.message, width, self.palette.warn if self.refused else "")

    def _foot(self, width: int) -> list[Text]:
        keys = KEYS if width >= WIDE else KEYS_NARROW
        return [Text(f" {line}", self.palette.dim) for line in fitting(keys, 0)]


def _driver(telemetry: Telemetry, kind: type[DriverStatus]) -> str:
    reading = telemetry.get(kind)
    return "silent" if reading is None or reading.quality is not Quality.FRESH else _words(reading.frame.status)


def _words(state: DriverState | None) -> str:
    return "unknown" if state is None else state.name.lower().replace("_", " ")


def number(value: float | None, how: str) -> str:
    """A number, or a dash where there is none; never a minus before nothing."""
    if value is None:
        return "-"
    text = format(value, how)
    return text.replace("-", "+" if "+" in how else " ") if not text.strip("-+0. ") else text


def bar(rpm: float | None) -> tuple[str, str]:
    """How fast a wheel turns back and ahead, as cells."""
    length = min(BAR, round(abs(rpm or 0.0) / FULL_RPM * BAR))
    cells = "█" * length
    return (cells.rjust(BAR), " " * BAR) if rpm and rpm < 0 else (" " * BAR, cells.ljust(BAR))
