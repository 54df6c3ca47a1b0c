from io import StringIO

import msgspec
import pytest
from rich.console import Console

from timonel.cli.face import Face, bar, big
from timonel.cli.page import NIGHT, Page
from timonel.gateway.lookout import Request, StationStatus
from timonel.nmea0183.parp import PilotMode

HOLDING = StationStatus(PilotMode.HEADING_HOLD, "HEADING_HOLD", 192.5, 183.1, 2.5, 2, 0.2)
FACE = Face(station=2, link="serial:///dev/ttyUSB4", status=HOLDING, message="set point moved")


def drawn(page: Page, width: int = 80, height: int = 24) -> list[str]:
    console = Console(width=width, height=height, file=StringIO(), record=True)
    console.print(page, end="")
    return console.export_text().split("\n")


def shown(width: int = 80, height: int = 24, **changes: object) -> str:
    face = msgspec.structs.replace(FACE, **changes)
    return "\n".join(drawn(face.page(width), width, height))


def status(**changes: object) -> StationStatus:
    return msgspec.structs.replace(HOLDING, **changes)


@pytest.mark.parametrize(("width", "height"), [(80, 24), (40, 17), (40, 24), (132, 50), (20, 5), (80, 1)])
@pytest.mark.parametrize("help", [False, True])
def test_the_page_fills_the_terminal_exactly(width: int, height: int, help: bool):
    face = msgspec.structs.replace(FACE, help=help, lost="IN port: no such file or directory")
    lines = drawn(face.page(width), width, height)
    assert [len(line) for line in lines] == [width] * height


@pytest.mark.parametrize(("width", "height"), [(80, 24), (40, 17)])
def test_what_matters_is_there_on_small_terminals_too(width: int, height: int):
    text = shown(width, height, requests=(Request(3, 7.4),))
    for part in ("02 Cockpit", "HEADING HOLD", "THIS STATION", "+2.5", "03 Flybridge asks for command: 7 s", "n deny"):
        assert part in text
    assert "…" not in text


def test_numbers_are_large_and_in_their_place():
    lines = shown(40, 17).split("\n")
    assert lines[3] == " HEADING             SET POINT          "
    assert lines[4:7] == [
        " ▄█  █▀█ ▀▀█   ▄█    ▄█  █▀█ ▀▀█   █▀▀  ",
        "  █  █▀█ ▀▀█    █     █  ▀▀█ █▀▀   ▀▀█  ",
        " ▀▀▀ ▀▀▀ ▀▀▀ ▀ ▀▀▀   ▀▀▀ ▀▀▀ ▀▀▀ ▀ ▀▀▀  ",
    ]


def test_wide_digits_are_the_same_ones_with_two_cells_a_pixel():
    assert big("7.", wide=True) == ["██████    ", "    ██    ", "    ██    ", "    ██    ", "    ██  ██"]


def test_every_digit_has_its_own_shape():
    shapes = {tuple(big(digit, wide=False)) for digit in "0123456789-"}
    assert len(shapes) == 11


def test_a_value_that_is_not_known_is_dashes():
    text = shown(status=status(heading_deg=None, rudder_deg=None))
    assert "--.-" in text
    assert " ██████  ██████  ██████      ██████ " in text


def test_in_standby_there_is_no_set_point():
    held, let_go = shown(40), shown(40, status=status(mode=PilotMode.STANDBY, setpoint_deg=0.0))
    assert "▄█  █▀█ ▀▀█   ▄█    ▄█" in held
    assert "▄█  █▀█ ▀▀█   ▄█      " in let_go


@pytest.mark.parametrize(
    ("commander", "text"), [(2, "THIS STATION"), (1, "LOCKED   01 Bridge"), (0, "LOCKED   nobody"), (None, "not known")]
)
def test_who_commands_is_always_to_be_seen(commander: int | None, text: str):
    assert text in shown(status=status(commander=commander))


def test_a_lost_far_end_is_marked_and_its_last_values_stay():
    text = shown(lost="no STATUS for 3 s", status=status(age=7.0))
    assert "NO LINK  no STATUS for 3 s, last heard 7 s ago" in text
    assert "○ no link" in text
    assert "HEADING HOLD" in text
    assert "not known" in text


def test_before_the_first_status_it_listens():
    assert "○ listening" in shown(status=StationStatus())


def test_an_alarm_is_shown_as_one():
    assert "ALARM  steer by hand" in shown(status=status(mode=PilotMode.ALARM))


def test_a_mode_that_is_not_in_the_protocol_is_shown_as_it_came():
    assert " MODE      WIND " in shown(status=status(mode=None, mode_text="WIND"))


def test_only_the_commander_is_offered_an_answer_to_a_request():
    asked = (Request(3, 7.4),)
    assert "y give" in shown(requests=asked).split("r ask")[0]
    assert "y give" not in shown(requests=asked, status=status(commander=1)).split("r ask")[0]


def test_the_own_request_counts_down():
    assert "you have asked for command: 7 s" in shown(requests=(Request(2, 7.4),), status=status(commander=1))


def test_a_heading_being_typed_stands_where_messages_stand():
    text = shown(entry="04")
    assert "set heading: 04_" in text
    assert "set point moved" not in text


@pytest.mark.parametrize(
    ("degrees", "port", "starboard"),
    [
        (0.0, "    ", "    "),
        (17.5, "    ", "██  "),
        (-17.5, "  ██", "    "),
        (-22.0, " ▐██", "    "),
        (90.0, "    ", "████"),
        (None, "    ", "    "),
    ],
)
def test_the_rudder_bar_grows_to_the_side_the_rudder_is_on(degrees: float | None, port: str, starboard: str):
    assert bar(degrees, 4) == (port, starboard)


def test_at_night_everything_is_red_on_black():
    console = Console(width=80, height=24, file=StringIO(), force_terminal=True, color_system="256", _environ={})
    page = msgspec.structs.replace(FACE, night=True, lost="x", requests=(Request(3, 7.4),)).page(80)
    for line in console.render_lines(page):
        for segment in line:
            assert segment.style is not None
            assert segment.style.color.number in (88, 124, 160)
            assert segment.style.bgcolor.number == 16
    assert NIGHT.base == page.base


def test_no_color_is_respected():
    out = StringIO()
    console = Console(width=80, height=24, file=out, force_terminal=True, _environ={"NO_COLOR": "1", "TERM": "xterm"})
    console.print(FACE.page(80))
    assert "\x1b[1m" in out.getvalue()
    assert "\x1b[3" not in out.getvalue()
