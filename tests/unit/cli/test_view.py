import asyncio
import logging
from io import StringIO

import pytest
from rich.console import Console

from tests.unit.cli.test_face import drawn
from timonel.cli.traffic import Meter, Traffic, spoken
from timonel.cli.view import LiveView
from timonel.core.alerts import Alert, AlertChanged
from timonel.core.command import Transferred
from timonel.core.effects import Refused, Rejected, Say, Transmit
from timonel.core.frame import Frame
from timonel.nmea0183 import parp
from timonel.nmea0183.parp import PilotMode
from timonel.nmea2000.fastpacket import fragment
from timonel.nmea2000.identifier import GLOBAL, join
from timonel.nmea2000.lookups import HeadingReference, SteeringMode
from timonel.nmea2000.messages.steering import HeadingTrackControl, RateOfTurn, VesselHeading
from timonel.vehicles.boat.alerts import BACKBONE_SILENT
from timonel.vehicles.boat.pilot import Steer

HEADING = VesselHeading(heading=1.0, reference=HeadingReference.TRUE)
STATUS = Say(parp.status(PilotMode.HEADING_HOLD, 455, 44.8, -3.2, 1), "STATUS")
HDT = Say(b"$IIHDT,44.8,T*15\r\n", "HDT")


def frame(message: VesselHeading | RateOfTurn) -> Frame:
    assert message.PGN is not None
    return Frame(join(2, message.PGN, 1, GLOBAL), message.encode())


def test_a_meter_counts_by_the_second_and_forgets():
    meter = Meter()
    for tenth in range(100):
        meter.count(10.0 + tenth / 10)
    assert meter.rate(20.0) == 10.0
    assert meter.rate(22.0) == 6.0
    assert meter.rate(40.0) == 0.0


def test_a_meter_is_right_after_two_seconds_already():
    meter = Meter()
    for tenth in range(22):
        meter.count(10.5 + tenth / 10, events=2)
    assert meter.rate(12.0) == 20.0


def test_a_meter_that_has_counted_nothing_shows_nothing():
    assert Meter().rate(5.0) == 0.0


def test_frames_are_told_apart_by_pgn():
    traffic = Traffic()
    traffic.frames_received([frame(HEADING), frame(RateOfTurn(rate=0.01)), frame(HEADING)], 1.0)
    assert [(pgn, heard.name) for pgn, heard in traffic.messages_by_importance()] == [
        (127250, "Vessel heading"),
        (127251, "Rate of turn"),
    ]
    assert traffic.messages[127250].last == HEADING.encode()
    assert traffic.messages[127250].at == 1.0


def test_a_fast_packet_counts_when_it_is_whole():
    traffic = Traffic()
    payload = HeadingTrackControl(steering_mode=SteeringMode.HEADING_CONTROL_STANDALONE).encode()
    frames = [Frame(join(2, 127237, 1, GLOBAL), data) for data in fragment(payload, 3)]
    traffic.frames_received(frames[:-1], 1.0)
    assert traffic.messages == {}
    traffic.frames_received(frames[-1:], 1.01)
    assert traffic.messages[127237].last == payload


def test_sentences_are_told_apart_by_formatter():
    traffic = Traffic()
    for effect in (Say(parp.cmdrequest(2), "CMDREQUEST"), Say(b"$IIXDR,A\r\n", "XDR"), HDT, STATUS):
        traffic.effect(effect, 1.0)
    names = [heard.name for heard in traffic.sentences_by_importance()]
    assert names == ["STATUS", "HDT", "CMDREQUEST", "XDR"]
    assert traffic.sentences["HDT"].last == b"$IIHDT,44.8,T*15"


def test_what_the_pilot_does_is_what_status_said():
    traffic = Traffic()
    traffic.effect(STATUS, 1.0)
    assert traffic.status is not None
    assert (traffic.status.mode, traffic.status.commander) == (PilotMode.HEADING_HOLD, 1)


def test_frames_sent_are_counted_apart_from_frames_heard():
    traffic = Traffic()
    traffic.effect(Transmit(frame(HEADING)), 0.5)
    traffic.effect(Transmit(frame(HEADING)), 1.5)
    assert (traffic.frames_out.rate(2.0), traffic.frames_in.rate(2.0)) == (1.0, 0.0)


def test_events_are_words_and_repetitions_are_counted():
    traffic = Traffic()
    traffic.effect(Transferred(0, 1), 1.0)
    for now in (2.0, 3.0):
        traffic.effect(Refused("not in command", 2), now)
    assert [(event.text, event.times, event.at) for event in traffic.events] == [
        ("command passes from nobody to station 1", 1, 1.0),
        ("station 2 refused: not in command", 2, 3.0),
    ]


def test_what_is_repeated_every_second_is_no_event():
    traffic = Traffic()
    traffic.effect(Steer(455), 1.0)
    assert not traffic.events


def test_an_alert_stands_until_it_is_over_and_seen():
    traffic = Traffic()
    for active, acknowledged, stands in ((True, False, True), (False, False, True), (False, True, False)):
        alert = Alert(BACKBONE_SILENT, "nothing heard", 1.0, active=active, acknowledged=acknowledged)
        traffic.effect(AlertChanged(alert), 1.0)
        assert bool(traffic.alerts) is stands
    assert traffic.events[0].severity == logging.ERROR


@pytest.mark.parametrize(
    ("pgn", "data", "text"),
    [
        (127250, HEADING.encode(), "heading 57.3°  reference true"),
        (127251, RateOfTurn(rate=0.01).encode(), "rate 34.4°/min"),
        (127250, VesselHeading().encode(), "nothing available"),
        (129025, bytes.fromhex("c0f0d7178051a3fd"), "latitude 40.00278°  longitude -3.96284°"),
        (128259, bytes.fromhex("002c01ffff00ffff"), "speed water referenced 5.8 kn"),
        (130312, bytes.fromhex("0000002473ffffff"), "actual temperature 21.6 °C  source sea"),
        (61184, b"\x01\x02", "01 02"),
        (128267, bytes.fromhex("00d2040000e8fdff"), "depth 12.34 m  offset -0.536 m"),
        (128275, bytes.fromhex("ffffffffffff4a2f0000e8030000"), "log 12106 m  trip log 1000 m"),
    ],
)
def test_values_are_told_in_units_for_the_eye(pgn: int, data: bytes, text: str):
    assert spoken(pgn, data).startswith(text)


def busy_view() -> LiveView:
    view = LiveView(["Listen: tcp://127.0.0.1:10110", "Steer: timonel station tcp://127.0.0.1:10114 --id 4"])
    for tenth in range(30):
        view.frames_received([frame(HEADING), frame(RateOfTurn(rate=0.01))], tenth / 10)
        view.effect(HDT, tenth / 10)
    view.effect(STATUS, 2.9)
    view.effect(Rejected("wrong check sum", b"$PARP", "cockpit"), 2.9)
    view.effect(AlertChanged(Alert(BACKBONE_SILENT, "nothing heard from the backbone for 3 s", 2.9)), 2.9)
    view.port("bridge", True, 0.0)
    view.port("cockpit", False, 0.0)
    return view


def test_the_view_shows_everything_that_goes_through_at_80_by_24():
    text = "\n".join(drawn(busy_view().page(80, 24, 3.0)))
    for part in (
        "bus 20 in 0.0 out frames/s   10 sentences/s",
        " HEADING_HOLD   set 045.5  heading 044.8 ".replace("_", " "),
        "-3.2",
        "command 01 Bridge",
        "● bridge  ○ cockpit",
        "ALARM  backbone silent: nothing heard from the backbone for 3 s",
        "127250  Vessel heading         10.0   0.1  heading 57.3°  reference true",
        " HDT          10.0   0.1  $IIHDT,44.8,T*15",
        "cockpit: rejected, wrong check sum",
        "Listen: tcp://127.0.0.1:10110",
        "Steer: timonel station tcp://127.0.0.1:10114 --id 4",
    ):
        assert part in text


@pytest.mark.parametrize(("width", "height"), [(80, 24), (200, 60), (60, 12), (40, 8)])
def test_the_view_fills_the_terminal_exactly(width: int, height: int):
    for view in (busy_view(), LiveView()):
        assert [len(line) for line in drawn(view.page(width, height, 3.0), width, height)] == [width] * height


def test_what_there_is_no_room_for_is_counted():
    view = busy_view()
    for pgn in range(127488, 127520):
        view.frames_received([Frame(join(2, pgn, 1, GLOBAL), bytes(8))], 2.9)
    assert "more" in drawn(view.page(80, 24, 3.0))[4]


def test_before_anything_goes_through_it_says_so():
    text = "\n".join(drawn(LiveView().page(80, 24, 3.0)))
    assert "no STATUS yet" in text
    assert "nothing yet" in text
    assert "command nobody" in text


def test_it_draws_until_it_is_cancelled_and_gives_the_screen_back():
    out = StringIO()

    async def main() -> None:
        console = Console(file=out, width=80, height=24, force_terminal=True, _environ={"TERM": "xterm"})
        showing = asyncio.create_task(busy_view().show(console))
        await asyncio.sleep(0)
        showing.cancel()
        with pytest.raises(asyncio.CancelledError):
            await showing

    asyncio.run(main())
    assert "Vessel heading" in out.getvalue()
    assert "\x1b[?1049l" in out.getvalue()
